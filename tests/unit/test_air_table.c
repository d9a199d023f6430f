/* Airlight from the table of runtime/volumes/vxs_air_table.h against adaptive quadrature in double (tests/volumes/airlight.h), in C
 * and in a shader.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/opengl/gl.h"

#include "repeats.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_points.h"

#include "air_questions.h"

enum { SIDE = VXS_AIR_TABLE_SIDE, PHASES = 9 };
static const double phases[PHASES] = {0, 0.3, 0.6, 0.85, 0.95, 0.99, -0.4, -0.8, -0.99};

/* Made once. */
static const float *values_of(int phase)
{
    static float values[PHASES][SIDE * SIDE];
    static int   is_made[PHASES];
    if (!is_made[phase]) vxs_air_table_fill(phases[phase], values[phase], SIDE);
    is_made[phase] = 1;
    return values[phase];
}

/* Errors of points or spot lights, by phase functions in turn. */
static errors errors_in_c(int spots)
{
    rng      r     = {(uint64_t)(11 + spots)};
    errors   e     = {0};
    uint32_t count = repeats(spots ? 160 : 500, 12000);
    for (int g = 0; g < PHASES; g++) {
        vxs_air_table table = {values_of(g), SIDE};
        for (uint32_t n = 0; n < count; n++) {
            question    q = random_question(&r, 1e-6, spots);
            double      found[3];
            vxs_medium  medium;
            vxs_air_ray ray;
            q.anisotropy = (float)phases[g];
            ask_c(&q, &medium, &ray);
            vxs_air_table_lamp(&table, &medium, &ray, q.begin, q.length, found);
            count_errors(&e, &q, found);
        }
    }
    return e;
}

static void test_points(void **state)
{
    (void)state;
    errors e = errors_in_c(0);
    check_errors(&e, 2e-3, 3e-5, 1e-3, repeats(8000, 190000));
}

static void test_spots(void **state)
{
    (void)state;
    errors e = errors_in_c(1);
    check_errors(&e, 1e-2 * repeats(1, 5), 3e-5, 5e-3, repeats(2500, 190000)); /* rims are the quadrature's */
}

/* Where the table is asked it is nearer to the truth than the quadrature, and it is asked often. */
static void test_who_is_asked(void **state)
{
    (void)state;
    rng    r        = {13};
    double asked[2] = {0}, sum[2] = {0}, most[2] = {0};
    for (int g = 0; g < PHASES; g++) {
        vxs_air_table table = {values_of(g), SIDE};
        for (uint32_t n = 0; n < repeats(500, 12000); n++) {
            question    q = random_question(&r, 1e-6, 0);
            double      found[2][3], wanted[3];
            vxs_medium  medium;
            vxs_air_ray ray;
            q.anisotropy = (float)phases[g];
            ask_c(&q, &medium, &ray);
            vxs_air_lamp(&medium, &ray, q.begin, q.length, found[0]);
            vxs_air_table_lamp(&table, &medium, &ray, q.begin, q.length, found[1]);
            asked[memcmp(found[0], found[1], sizeof found[0]) != 0]++;
            if (!memcmp(found[0], found[1], sizeof found[0])) continue;
            reference(&q, wanted);
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < 2; k++) {
                    if (!(wanted[i] > 1e-30)) continue;
                    double error = fabs(found[k][i] / wanted[i] - 1);
                    sum[k] += error;
                    most[k] = fmax(most[k], error);
                }
        }
    }
    print_message("of %.0f segments %.0f by the table; of these, mean error %.1e, most %.1e; by quadrature %.1e, %.1e\n",
                  asked[0] + asked[1], asked[1], sum[1] / asked[1] / 3, most[1], sum[0] / asked[1] / 3, most[0]);
    assert_true(asked[1] > 0.3 * asked[0]);
    assert_true(sum[1] < 0.7 * sum[0] && most[1] < 0.3 * most[0]);
}

/* From the eye on, against the whole ray. */
static void test_until(void **state)
{
    (void)state;
    rng    r    = {14};
    double most = 0;
    for (int g = 0; g < PHASES; g++) {
        vxs_air_table table = {values_of(g), SIDE};
        for (uint32_t n = 0; n < repeats(300, 6000); n++) {
            question    q = random_question(&r, 1e-6, 0);
            double      found[3], wanted[3], whole[3];
            vxs_medium  medium;
            vxs_air_ray ray;
            q.anisotropy = (float)phases[g];
            q.begin      = 0;
            ask_c(&q, &medium, &ray);
            vxs_air_table_until(&table, &medium, &ray, q.length, found);
            reference(&q, wanted);
            q.length *= 1e4F;
            reference(&q, whole);
            for (int i = 0; i < 3; i++) {
                assert_true(isfinite(found[i]) && found[i] >= 0);
                if (whole[i] > 1e-30) most = fmax(most, fabs(found[i] - wanted[i]) / whole[i]);
            }
        }
    }
    print_message("error of the whole ray's airlight: %.1e at most\n", most);
    assert_true(most < 1e-3 * repeats(1, 4));
}

/* A lamp with a range is the quadrature's: tails go on to infinity. */
static void test_ranges(void **state)
{
    (void)state;
    rng           r     = {17};
    vxs_air_table table = {values_of(0), SIDE};
    for (int n = 0; n < 1000; n++) {
        question    q = random_question_in_range(&r, 1e-6, n % 2);
        double      by_table[3], found[3];
        vxs_medium  medium;
        vxs_air_ray ray;
        q.anisotropy = (float)phases[0];
        ask_c(&q, &medium, &ray);
        vxs_air_table_lamp(&table, &medium, &ray, q.begin, q.length, by_table);
        vxs_air_lamp(&medium, &ray, q.begin, q.length, found);
        assert_memory_equal(by_table, found, sizeof found);
    }
}

/* The formula is that of the tails: what is left over has no slope to speak of. */
static void test_table_is_smooth(void **state)
{
    (void)state;
    for (int g = 0; g < PHASES; g++) {
        const float *values = values_of(g);
        for (int n = 0; n < SIDE * SIDE; n++) assert_in_range(1000 * (double)values[n], 800, 2000);
    }
}

/* The lamp's distance from the ray is a difference in a shader: it is no less than a thousandth of the distance here. */
static errors errors_in_shader(const drawing *d, int spots)
{
    enum { ASKED = QUERIES / 3 };
    static question questions[ASKED];
    static query    queries[QUERIES];
    static float    answers[QUERIES];
    rng             r = {(uint64_t)(15 + spots)};
    errors          e = {0};
    for (int g = 0; g < PHASES; g += (int)repeats(2, 1)) {
        uint32_t count = repeats(ASKED / PHASES / (spots ? 4 : 1), ASKED);
        for (int n = 0; n < ASKED; n++) {
            questions[n]            = random_question(&r, 1e-3, spots);
            questions[n].anisotropy = (float)phases[g];
        }
        GLuint buffer = bind_buffer(d, GL_SHADER_STORAGE_BUFFER, sizeof questions, questions), texture;
        d->gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
        d->gl->TextureStorage2D(texture, 1, GL_R32F, SIDE, SIDE);
        d->gl->TextureSubImage2D(texture, 0, 0, 0, SIDE, SIDE, GL_RED, GL_FLOAT, values_of(g));
        d->gl->TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        d->gl->TextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        d->gl->TextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        d->gl->BindTextureUnit(0, texture);
        draw(d, queries, answers);
        for (uint32_t n = 0; n < count; n++) {
            double found[3];
            for (int i = 0; i < 3; i++) found[i] = (double)answers[3 * n + i];
            count_errors(&e, &questions[n], found);
        }
        d->gl->DeleteBuffers(1, &buffer);
    }
    return e;
}

static void test_shader(void **state)
{
    (void)state;
    drawing d = drawing_make();
    use_air(&d, "layout(binding = 0) uniform sampler2D air_table;\n"
                "#define ask_lamp(medium, ray, begin, length, airlight) \\\n"
                "    vxs_air_table_lamp(air_table, medium, ray, begin, length, airlight)\n");
    errors points = errors_in_shader(&d, 0), spots = errors_in_shader(&d, 1);
    check_errors(&points, 2e-3, 3e-5, 1e-3, repeats(4000, 60000));
    check_errors(&spots, 1.1, 1e-3, 0.025, repeats(1000, 60000)); /* one that runs along the side of a cone ends anywhere */
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points),          cmocka_unit_test(test_spots), cmocka_unit_test(test_who_is_asked),
        cmocka_unit_test(test_table_is_smooth), cmocka_unit_test(test_until), cmocka_unit_test(test_shader),
        cmocka_unit_test(test_ranges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
