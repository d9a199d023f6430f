/* Transmittance curves of runtime/volumes/vxs_curve.h in a shader on llvmpipe against the same text in C in float: nodes, and what
 * lies between them, to 1e-6.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <string.h>

#include "baker/base/random.h"
/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_points.h"
#include "read_text.h"

#define vxs_real     float
#define VXS_REAL_MIN 1e-30f
#include "runtime/volumes/vxs_curve.h"

/* What is queried of a curve: its numbers as they are stored, and depths, along lines and exponentials. */
enum { NODES = 8, DEPTHS = 8, ASKED = 2 * NODES + 2 * DEPTHS, CURVES = QUERIES / ASKED, SEGMENTS = 1000, MOST = 40 };

static const char ask_text[] =
    "layout(std430, binding = 0) readonly buffer asked { vec4 segments[]; };\n"
    "flat in int vertex;\n"
    "out float answer;\n"
    "float stored[16] = float[16](0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);\n"
    "#define vxs_curve_number(curves, i) stored[i]\n";

static const char ask_main_text[] =
    "void main() {\n"
    "    int number = vertex / ASKED, what = vertex % ASKED;\n"
    "    vxs_curve curve = vxs_curve_empty();\n"
    "    for (int n = 0; n < number % (MOST + 1); n++) {\n"
    "        vec4 s = segments[(number * 13 + n) % SEGMENTS];\n"
    "        vxs_curve_insert(curve, NODES, s.x, s.y, s.z);\n"
    "    }\n"
    "    vxs_curve_pad(curve, NODES);\n"
    "    for (int n = 0; n < NODES; n++) {\n"
    "        stored[2 * n] = curve.depth[n];\n"
    "        stored[2 * n + 1] = curve.left[n];\n"
    "    }\n"
    "    float depth = segments[(number * 7 + what) % SEGMENTS].w;\n"
    "    answer = what < 2 * NODES ? stored[what] : vxs_curve_read(0u, 0, NODES, depth, what & 1);\n"
    "}\n";

static void use_curve(drawing *d)
{
    const char *paths[] = {"formats/vxs_lookup.h", "formats/vxs_lookup_blocks.h", "formats/vxs_space.h"};
    enum { PATHS = sizeof paths / sizeof *paths };
    char        sizes[256], *texts[PATHS + 1];
    const char *all[PATHS + 5] = {"#version 430\n#define vxs_word(dag, i) 0u\n", sizes};
    snprintf(sizes, sizeof sizes,
             "#define NODES %d\n#define ASKED %d\n#define MOST %d\n#define SEGMENTS %d\n#define VXS_CURVE_MOST NODES\n", NODES,
             ASKED, MOST, SEGMENTS);
    for (int n = 0; n < PATHS; n++) all[n + 2] = texts[n] = read_text(paths[n]);
    all[PATHS + 2] = ask_text;
    all[PATHS + 3] = texts[PATHS] = read_text("runtime/volumes/vxs_curve.h");
    all[PATHS + 4]                = ask_main_text;
    use_texts(d, "vxs_curve.h", "#version 430", all, PATHS + 5);
    for (int n = 0; n <= PATHS; n++) free(texts[n]);
}

/* entry, exit, through, and a depth to query at. */
static void random_segments(rng *r, float (*segments)[4])
{
    for (int n = 0; n < SEGMENTS; n++) {
        float entry    = rng_below(r, 2) ? (float)rng_between(r, 0, 20) : 20 * (float)rng_unit(r);
        float length   = rng_below(r, 3) ? 4 * (float)rng_unit(r) : 0;
        segments[n][0] = entry;
        segments[n][1] = entry + length;
        segments[n][2] = rng_below(r, 100) ? (float)exp(-rng_unit(r)) : 0;
        segments[n][3] = rng_below(r, 4) ? 24 * (float)rng_unit(r) : entry;
    }
}

static void test_c_and_glsl_agree(void **state)
{
    (void)state;
    static float segments[SEGMENTS][4], answers[QUERIES];
    static query queries[QUERIES];
    rng          r       = {1};
    float        most    = 0;
    uint32_t     between = 0;
    drawing      d       = drawing_make();
    use_curve(&d);
    random_segments(&r, segments);
    bind_buffer(&d, GL_SHADER_STORAGE_BUFFER, sizeof segments, segments);
    draw(&d, queries, answers);
    for (int k = 0; k < CURVES; k++) {
        vxs_curve c = vxs_curve_empty();
        float     stored[2 * NODES];
        for (int n = 0; n < k % (MOST + 1); n++) {
            const float *s = segments[(k * 13 + n) % SEGMENTS];
            vxs_curve_insert(&c, NODES, s[0], s[1], s[2]);
        }
        vxs_curve_pad(&c, NODES);
        for (int n = 0; n < NODES; n++) {
            stored[2 * n]     = c.depth[n];
            stored[2 * n + 1] = c.left[n];
        }
        for (int n = 0; n < ASKED; n++) {
            float wanted = n < 2 * NODES ? stored[n] : vxs_curve_read(stored, 0, NODES, segments[(k * 7 + n) % SEGMENTS][3], n & 1);
            most         = fmaxf(most, fabsf(answers[k * ASKED + n] - wanted));
            between += wanted > 0 && wanted < 1;
        }
    }
    print_message("%d curves: nodes, and what lies between them, off by %.1e at most\n", CURVES, (double)most);
    assert_true(most < 5e-6F && between > 1000);
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_c_and_glsl_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
