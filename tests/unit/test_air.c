/* Airlight of runtime/volumes/vxs_air.h against adaptive quadrature in double, in C and in a shader.
 *
 * The reference integrates what happens at each place of a ray as it is said, from vectors: phase(cosine) * exp(-extinction * way) / r^2,
 * along the ray, in pieces between places where it may change fast. It shares no line with the subject.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/opengl/gl.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "random_lamp.h"
#include "repeats.h"
#include "runtime/volumes/vxs_air.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_points.h"

/* Uniform in the logarithm. */
static double spread(rng *r, double low, double high)
{
    return exp(uniform(r, log(low), log(high)));
}

/* reference ------------------------------------------------------------------------------------------------------------------------ */

/* A question to C and to a shader alike: floats, as the shader reads them. */
typedef struct question {
    float to_lamp[3], radius;
    float direction[3], begin;
    float axis[3], length; /* of a spot light; 0: of a point light */
    float scattering[3], anisotropy;
    float extinction[3], cos_inner;
    float cos_outer, unused[3];
} question;

/* A ray and one channel, as the reference sees them. */
typedef struct integrand {
    double along, beside, before, facing; /* of the lamp; of its axis */
    double from;                          /* where the piece begins, less `along` */
    double extinction, g, cos_inner, cos_outer;
    int    is_spot;
} integrand;

static double airlight_at(double s, void *user)
{
    const integrand *n = user;
    double           y = n->from + s, r = hypot(n->beside, y), cosine = -y / r;
    double           less  = y < 0 ? n->beside * n->beside / (r * (r - y)) : 1 - cosine; /* 1 - cosine */
    double           wide  = (1 - n->g) * (1 - n->g) + 2 * n->g * less;
    double           phase = (1 - n->g * n->g) / (4 * M_PI * wide * sqrt(wide)), rim = 1;
    if (n->is_spot) rim = ((n->before + y * n->facing) / r - n->cos_outer) / fmax(1e-3, n->cos_inner - n->cos_outer);
    rim = fmin(fmax(rim, 0), 1);
    return rim * rim * phase * exp(-n->extinction * (n->along + y + r)) / (r * r);
}

static int by_size(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* Integrate between 0 and length, in pieces that grow away from where the ray is nearest to the lamp, and from its begin as fast as light is
 * lost. */
static double integrate(const integrand *n, double length)
{
    static gsl_integration_workspace *space;
    enum { PIECES = 400 };
    double       ends[PIECES], sum = 0, nearest = -n->from;
    int          count = 0;
    gsl_function f     = {airlight_at, (void *)(uintptr_t)n};
    if (!space) space = gsl_integration_workspace_alloc(1000);
    ends[count++] = 0;
    ends[count++] = length;
    ends[count++] = nearest;
    for (double step = 1e-3; step < 1e9; step *= 4) {
        ends[count++] = nearest - step * n->beside;
        ends[count++] = nearest + step * n->beside;
    }
    for (double depth = 0.1; n->extinction > 0 && depth < 800; depth *= 2) ends[count++] = depth / n->extinction;
    if (n->is_spot) /* the ends of its rim */
        for (int k = 1; k < 128; k++) ends[count++] = length * k / 128;
    qsort(ends, (size_t)count, sizeof *ends, by_size);
    for (int k = 0; k + 1 < count; k++) {
        double begin = fmax(ends[k], 0), end = fmin(ends[k + 1], length), part = 0, error = 0;
        if (end <= begin) continue;
        gsl_integration_qag(&f, begin, end, 0, 1e-9, 1000, GSL_INTEG_GAUSS21, space, &part, &error);
        sum += part;
    }
    return sum;
}

static void reference(const question *q, double airlight[3])
{
    double    w[3], l[3], cross[3], square = 0;
    integrand n = {.g = q->anisotropy, .cos_inner = q->cos_inner, .cos_outer = q->cos_outer, .is_spot = q->cos_inner > 0};
    for (int i = 0; i < 3; i++) {
        w[i] = q->direction[i];
        l[i] = q->to_lamp[i];
        n.along += w[i] * l[i];
        n.facing += w[i] * (double)q->axis[i];
    }
    for (int i = 0; i < 3; i++) {
        cross[i] = l[(i + 1) % 3] * w[(i + 2) % 3] - l[(i + 2) % 3] * w[(i + 1) % 3];
        square += cross[i] * cross[i];
        n.before += (n.along * w[i] - l[i]) * (double)q->axis[i];
    }
    n.beside = fmax(sqrt(square), (double)q->radius);
    n.from   = q->begin - n.along;
    for (int i = 0; i < 3; i++) {
        n.extinction = q->extinction[i];
        airlight[i]  = (double)q->scattering[i] * integrate(&n, q->length);
    }
}

/* subjects ------------------------------------------------------------------------------------------------------------------------- */

static void air_of(const question *q, double airlight[3])
{
    vxs_medium  medium;
    vxs_air_ray ray;
    double      to_lamp[3], direction[3], axis[3];
    for (int i = 0; i < 3; i++) {
        to_lamp[i]           = q->to_lamp[i];
        direction[i]         = q->direction[i];
        axis[i]              = q->axis[i];
        medium.scattering[i] = q->scattering[i];
        medium.extinction[i] = q->extinction[i];
    }
    medium.anisotropy = q->anisotropy;
    ray               = q->cos_inner > 0 ? vxs_air_ray_of_spot(to_lamp, direction, q->radius, axis, q->cos_inner, q->cos_outer)
                                         : vxs_air_ray_of(to_lamp, direction, q->radius);
    vxs_air_lamp(&medium, &ray, q->begin, q->length, airlight);
}

/* questions ------------------------------------------------------------------------------------------------------------------------ */

/* Any ray: the lamp before the eye, behind it, at it, on the ray; short and endless pieces; thin air and ink.
 * least_beside  of the lamp's distance */
static question random_question(rng *r, double least_beside, int spots)
{
    question q = {0};
    double   w[3], side[3], axis[3], along, beside, size = spread(r, 1e-2, 1e5), dot = 0, length = 0;
    random_direction(r, w);
    random_direction(r, side);
    random_direction(r, axis);
    for (int i = 0; i < 3; i++) dot += w[i] * side[i];
    for (int i = 0; i < 3; i++) side[i] -= dot * w[i];
    for (int i = 0; i < 3; i++) length += side[i] * side[i];
    along    = size * (rng_below(r, 8) ? uniform(r, -1, 1) : 0);
    beside   = rng_below(r, 8) ? size * spread(r, least_beside, 10) : 0;
    q.radius = (float)(size * spread(r, least_beside, 1e-1));
    for (int i = 0; i < 3; i++) {
        q.direction[i] = (float)w[i];
        q.to_lamp[i]   = (float)(along * w[i] + beside * side[i] / sqrt(length));
        q.axis[i]      = (float)axis[i];
    }
    q.begin     = (float)(rng_below(r, 3) ? size * spread(r, 1e-3, 3) : 0);
    q.length    = (float)(rng_below(r, 8) ? size * spread(r, 1e-7, 10) : size * 1e3);
    double most = spread(r, 1e-6, 1e4) / hypot(along, fmax(beside, (double)q.radius));
    int    grey = rng_below(r, 2) == 0;
    for (int i = 0; i < 3; i++) {
        q.extinction[i] = (float)(grey ? most : most * spread(r, 1e-2, 1));
        q.scattering[i] = q.extinction[i] * (rng_below(r, 8) ? (float)rng_unit(r) : 0);
    }
    if (!rng_below(r, 16)) q.scattering[0] = q.extinction[0] = 0;
    q.anisotropy = rng_below(r, 3) ? (float)uniform(r, -0.99, 0.99) : rng_below(r, 2) ? 0 : 0.99F;
    if (spots) {
        double outer = uniform(r, 0.05, M_PI / 2), inner = outer * uniform(r, 0, 0.9);
        q.cos_outer = (float)cos(outer);
        q.cos_inner = (float)cos(inner);
    }
    return q;
}

/* tests ---------------------------------------------------------------------------------------------------------------------------- */

typedef struct errors {
    double   most, sum;
    uint32_t count, large; /* channels; those with an error of 1e-3 and more */
} errors;

/* Errors of what a spot light adds count relative to a hundredth of what a point light would, where that is more: a ray that grazes its cone
 * sees nothing. Channels do not count of which fog leaves less than 1e-8 before the segment begins. */
static void count_errors(errors *e, const question *q, const double found[3])
{
    double   wanted[3], all[3] = {0}, from_lamp[3], way;
    question point = *q;
    for (int i = 0; i < 3; i++) from_lamp[i] = (double)q->begin * (double)q->direction[i] - (double)q->to_lamp[i];
    way             = (double)q->begin + sqrt(dot(from_lamp, from_lamp));
    point.cos_inner = 0;
    reference(q, wanted);
    if (q->cos_inner > 0) reference(&point, all);
    for (int i = 0; i < 3; i++) {
        assert_true(isfinite(found[i]) && found[i] >= 0);
        if (q->scattering[i] == 0) assert_true(found[i] == 0);
        double scale = fmax(wanted[i], all[i] / 100);
        if (!(scale > 1e-30) || (double)q->extinction[i] * way > 18) continue;
        double error = fabs(found[i] - wanted[i]) / scale;
        e->sum += error;
        e->count++;
        e->large += error >= 1e-3;
        e->most = fmax(e->most, error);
    }
}

/* mean, share  of relative errors, and of those of 1e-3 and more */
static void check_errors(const errors *e, double most, double mean, double share, uint32_t least_count)
{
    print_message("%u channels: relative error %.1e at most, %.1e in the mean, 1e-3 and more in %.2f %%\n", e->count, e->most,
                  e->sum / e->count, 100.0 * e->large / e->count);
    assert_true(e->count >= least_count);
    assert_true(e->most < most);
    assert_true(e->sum < mean * e->count);
    assert_true(e->large < share * e->count);
}

static errors errors_in_c(int spots)
{
    rng      r     = {(uint64_t)(1 + spots)};
    errors   e     = {0};
    uint32_t count = repeats(4000, 100000);
    for (uint32_t n = 0; n < count; n++) {
        question q = random_question(&r, 1e-6, spots);
        double   found[3];
        air_of(&q, found);
        count_errors(&e, &q, found);
    }
    return e;
}

static void test_points(void **state)
{
    (void)state;
    errors e = errors_in_c(0);
    check_errors(&e, 1e-3 * repeats(5, 60), 1e-4, 0.02, repeats(4000, 100000));
}

static void test_spots(void **state)
{
    (void)state;
    errors e = errors_in_c(1);
    check_errors(&e, 1e-2, 1e-4, 0.01, repeats(4000, 100000));
}

/* The sun's, in fog with a top or without, against the same integrand place by place. */
static double sun_at(double x, void *user)
{
    const double *n = user; /* extinction, way at x = 0, slope */
    return exp(-n[0] * (n[1] + n[2] * x));
}

static void test_sun(void **state)
{
    (void)state;
    rng                        r      = {5};
    gsl_integration_workspace *space  = gsl_integration_workspace_alloc(1000);
    uint32_t                   rising = 0;
    for (uint32_t n = 0; n < repeats(10000, 100000); n++) {
        double up = uniform(&r, -1, 1), to_sun_y = uniform(&r, 0.05, 1), height = uniform(&r, -100, 100),
               top     = uniform(&r, -100, 100);
        double part[2] = {0, spread(&r, 1e-6, 1e4)}, cosine = uniform(&r, -1, 1), airlight[3];
        vxs_air_in_fog(height, up, top, part);
        for (int k = 0; k < 20; k++) { /* it is in the part where it is in fog */
            double x = uniform(&r, 0, 200);
            if (part[1] > part[0] && x > part[0] + 1e-9 && x < part[1] - 1e-9) assert_true(height + up * x <= top + 1e-6);
            if (x < part[0] - 1e-9) assert_true(height + up * x >= top - 1e-6);
        }
        if (part[1] <= part[0]) continue;
        vxs_medium medium = {.anisotropy = uniform(&r, -0.99, 0.99)};
        double     way = (top - height - up * part[0]) / to_sun_y, slope = 1 - up / to_sun_y, length = part[1] - part[0];
        for (int i = 0; i < 3; i++) medium.scattering[i] = medium.extinction[i] = i ? spread(&r, 1e-6, 1e2) / length : 0;
        vxs_air_sun(&medium, cosine, length, way, slope, airlight);
        rising += slope < 0;
        for (int i = 0; i < 3; i++) {
            double       numbers[3] = {medium.extinction[i], way, slope}, sum = 0, error;
            gsl_function f = {sun_at, numbers};
            for (int k = 0; k < 16; k++) {
                double piece;
                gsl_integration_qag(&f, length * k / 16, length * (k + 1) / 16, 0, 1e-9, 1000, GSL_INTEG_GAUSS21, space, &piece,
                                    &error);
                sum += piece;
            }
            double g = medium.anisotropy, wide = 1 + g * g - 2 * g * cosine;
            double wanted = medium.scattering[i] * (1 - g * g) / (4 * M_PI * pow(wide, 1.5)) * sum;
            assert_true(isfinite(airlight[i]) && airlight[i] >= 0);
            if (wanted > 1e-200) assert_true(fabs(airlight[i] / wanted - 1) < 1e-9);
        }
    }
    assert_true(rising > 1000);
    gsl_integration_workspace_free(space);
}

/* All light that turns goes somewhere. */
static void test_phase(void **state)
{
    (void)state;
    for (int n = -99; n <= 99; n += 3) {
        enum { STEPS = 100000 };
        double sum = 0;
        for (int k = 0; k < STEPS; k++) {
            double angle = M_PI * (k + 0.5) / STEPS;
            sum += 2 * M_PI * sin(angle) * vxs_air_phase(n / 100.0, cos(angle)) * M_PI / STEPS;
        }
        assert_float_equal(sum, 1, 1e-5);
    }
}

/* The part of a ray in a cone is where its places are. */
static void test_cones(void **state)
{
    (void)state;
    rng      r      = {6};
    uint32_t inside = 0;
    for (uint32_t n = 0; n < repeats(20000, 200000); n++) {
        double to_lamp[3], direction[3], axis[3], cosine = cos(uniform(&r, 0.05, M_PI / 2)), part[2] = {0, 100};
        random_direction(&r, direction);
        random_direction(&r, axis);
        for (int i = 0; i < 3; i++) to_lamp[i] = uniform(&r, -30, 30);
        vxs_air_ray ray = vxs_air_ray_of_spot(to_lamp, direction, 1e-3, axis, 1, cosine);
        vxs_air_in_cone(&ray, cosine, part);
        for (int k = 0; k < 20; k++) {
            double x = uniform(&r, 0, 100), way[3], dot = 0, square = 0;
            for (int i = 0; i < 3; i++) {
                way[i] = direction[i] * x - to_lamp[i];
                dot += way[i] * axis[i];
                square += way[i] * way[i];
            }
            double margin = dot - cosine * sqrt(square);
            if (fabs(margin) < 1e-6) continue;
            assert_int_equal(margin > 0, x >= part[0] && x <= part[1]);
            inside += margin > 0;
        }
    }
    assert_true(inside > 20000);
}

static char *read_text(const char *path)
{
    enum { MOST = 1 << 16 };
    char *text = calloc(1, MOST);
    FILE *file = fopen(path, "r");
    assert_non_null(text);
    if (!file) {
        print_message("%s is not here: start this test in the root of the repository\n", path);
        skip();
    }
    assert_in_range(fread(text, 1, MOST - 1, file), 1, MOST - 2);
    fclose(file);
    return text;
}

/* A point of gl_points.h asks for one channel of a question. */
static const char ask_text[] = "struct question { vec4 lamp, way, axis, scattering, extinction, rest; };\n"
                               "layout(std430, binding = 0) readonly buffer asked { question questions[]; };\n"
                               "flat in int vertex;\n"
                               "out float answer;\n"
                               "void main() {\n"
                               "    question q = questions[vertex / 3];\n"
                               "    vxs_medium medium = vxs_medium(q.scattering.xyz, q.extinction.xyz, q.scattering.w);\n"
                               "    vxs_air_ray ray = vxs_air_ray_of(q.lamp.xyz, q.way.xyz, q.lamp.w);\n"
                               "    if (q.extinction.w > 0.0) ray = vxs_air_ray_of_spot(q.lamp.xyz, q.way.xyz, q.lamp.w,\n"
                               "                                        q.axis.xyz, q.extinction.w, q.rest.x);\n"
                               "    vec3 airlight;\n"
                               "    vxs_air_lamp(medium, ray, q.way.w, q.axis.w, airlight);\n"
                               "    answer = airlight[vertex % 3];\n"
                               "}\n";

static void use_air(drawing *d)
{
    char *texts[4] = {read_text("formats/vxs_lookup.h"), read_text("formats/vxs_lookup_blocks.h"), read_text("formats/vxs_space.h"),
                      read_text("runtime/volumes/vxs_air.h")};
    const char *all[] = {"#version 430\n#define vxs_word(dag, i) 0u\n", texts[0], texts[1], texts[2], texts[3], ask_text};
    use_texts(d, "vxs_air.h", "#version 430", all, sizeof all / sizeof *all);
    for (int n = 0; n < 4; n++) free(texts[n]);
}

/* The lamp's distance from the ray is a difference in a shader: it is no less than a thousandth of the distance here. */
static errors errors_in_shader(const drawing *d, int spots)
{
    enum { ASKED = QUERIES / 3 };
    static question questions[ASKED];
    static query    queries[QUERIES];
    static float    answers[QUERIES];
    rng             r = {(uint64_t)(3 + spots)};
    errors          e = {0};
    for (int n = 0; n < ASKED; n++) questions[n] = random_question(&r, 1e-3, spots);
    bind_buffer(d, GL_SHADER_STORAGE_BUFFER, sizeof questions, questions);
    draw(d, queries, answers);
    for (int n = 0; n < ASKED; n++) {
        double found[3];
        for (int i = 0; i < 3; i++) found[i] = (double)answers[3 * n + i];
        count_errors(&e, &questions[n], found);
    }
    return e;
}

static void test_shader(void **state)
{
    (void)state;
    drawing d = drawing_make();
    use_air(&d);
    errors points = errors_in_shader(&d, 0), spots = errors_in_shader(&d, 1);
    check_errors(&points, 1e-2, 2e-4, 0.03, 6000);
    check_errors(&spots, 1.1, 1e-3, 0.025, 6000); /* one that runs along the side of a cone ends anywhere */
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points), cmocka_unit_test(test_spots), cmocka_unit_test(test_sun),
        cmocka_unit_test(test_phase),  cmocka_unit_test(test_cones), cmocka_unit_test(test_shader),
    };
    gsl_set_error_handler_off(); /* its estimates of error are cautious where little is left */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
