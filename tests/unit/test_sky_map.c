/* Maps of the sky: pixels of Radiance's pictures, plain and in both kinds of runs, and of PNG, against what they were written from;
 * files that end early, that are damaged anywhere, and that are no such map.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/sky_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/files/png_encode.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { WIDE = 40, HIGH = 20, PIXELS = WIDE * HIGH, ROOM = 16 * PIXELS };

static uint8_t pixels[PIXELS][4];

typedef enum coding { PLAIN, RUNS, OLD_RUNS, CODINGS } coding;

typedef struct written {
    uint8_t bytes[ROOM];
    size_t  size;
} written;

static void put(written *w, const void *bytes, size_t size)
{
    assert_true(w->size + size <= ROOM);
    memcpy(w->bytes + w->size, bytes, size);
    w->size += size;
}

/* Some rows of one colour, some of stretches, some of noise; as exponents say, from 1e-3 to 1e6, and black. */
static void make_pixels(void)
{
    rng r = {7};
    for (int n = 0; n < PIXELS; n++) {
        int y = n / WIDE, again = n % WIDE && (y % 3 == 0 || (y % 3 == 1 && rng_below(&r, 9)));
        if (again) {
            memcpy(pixels[n], pixels[n - 1], 4);
            continue;
        }
        for (int k = 0; k < 3; k++) pixels[n][k] = (uint8_t)(128 + rng_below(&r, 128));
        pixels[n][3] = rng_below(&r, 8) ? (uint8_t)(118 + rng_below(&r, 30)) : 0;
    }
}

/* How many bytes, or pixels, from here on are equal, `most` at most. */
static int equals(const uint8_t *at, size_t step, size_t size, int most)
{
    int n = 1;
    while (n < most && !memcmp(at, at + (size_t)n * step, size)) n++;
    return n;
}

/* How many follow that differ from the next. */
static int differs(const uint8_t *at, size_t step, size_t size, int most)
{
    int n = 1;
    while (n < most && equals(at + (size_t)n * step, step, size, most - n) == 1) n++;
    return n;
}

static void put_channel(written *w, const uint8_t *at)
{
    for (int x = 0, n; x < WIDE; x += n) {
        int is_run     = (n = equals(at + 4 * x, 4, 1, WIDE - x)) > 1;
        n              = is_run ? n : differs(at + 4 * x, 4, 1, WIDE - x);
        uint8_t length = (uint8_t)(is_run ? 128 + n : n);
        put(w, &length, 1);
        for (int k = 0; k < (is_run ? 1 : n); k++) put(w, at + 4 * (x + k), 1);
    }
}

static void put_row(written *w, coding c, const uint8_t (*row)[4])
{
    const uint8_t begin[4] = {2, 2, WIDE >> 8, WIDE & 255};
    if (c == RUNS) put(w, begin, 4);
    for (int k = 0; c == RUNS && k < 4; k++) put_channel(w, &row[0][k]);
    for (int x = 0, n; c != RUNS && x < WIDE; x += n) {
        n                      = c == OLD_RUNS ? equals(row[x], 4, 4, WIDE - x) : 1;
        const uint8_t again[4] = {1, 1, 1, (uint8_t)(n - 1)};
        put(w, row[x], 4);
        if (n > 1) put(w, again, 4);
    }
}

static void write_picture(written *w, coding c, const char *settings)
{
    char head[256];
    w->size = 0;
    put(w, head, (size_t)snprintf(head, sizeof head, "#?RADIANCE\n# by a test\n%s\n-Y %d +X %d\n", settings, HIGH, WIDE));
    for (int y = 0; y < HIGH; y++) put_row(w, c, (const uint8_t(*)[4])pixels + y * WIDE);
}

static vxs_result read_bytes(sky_map *map, const uint8_t *bytes, size_t size, run_context *m)
{
    uint8_t *copy = malloc(size); /* of its size, so that a sanitizer sees what is read behind it */
    assert_non_null(copy);
    memcpy(copy, bytes, size);
    *m           = (run_context){0};
    vxs_result r = sky_map_decode(map, "sky", copy, size, m);
    free(copy);
    return r;
}

/* Each coding gives the same floats, divided by all exposures and corrections of colours; blanks about a value are none of it. */
static void test_radiance(void **state)
{
    (void)state;
    static written w;
    run_context    m;
    sky_map        map;
    make_pixels();
    for (int c = 0; c < CODINGS; c++)
        for (int exposed = 0; exposed < 2; exposed++) {
            write_picture(&w, (coding)c,
                          exposed ? "EXPOSURE=2\nCOLORCORR= 1 2 0.5\nFORMAT= 32-bit_rle_rgbe \t\nEXPOSURE= 0.25\nCOLORCORR=1 1 4 \n"
                                  : "FORMAT=32-bit_rle_rgbe\n");
            assert_int_equal(read_bytes(&map, w.bytes, w.size, &m), VXS_OK);
            assert_true(map.wide_px == WIDE && map.high_px == HIGH);
            for (size_t n = 0; n < 3 * PIXELS; n++) {
                const uint8_t *p      = pixels[n / 3];
                double         factor = exposed ? (double[]){2, 1, 1}[n % 3] : 1;
                double         wanted = p[3] ? p[n % 3] / 256.0 * pow(2, p[3] - 128) * factor : 0;
                assert_true((double)map.radiance[n] == wanted);
            }
            sky_map_free(&map);
        }
}

/* Colours of another space are said; those of Radiance and of sRGB, and zeros, are none. */
static void test_primaries(void **state)
{
    (void)state;
    static written w;
    static const struct {
        const char *text;
        int         warns;
    } rows[] = {{"PRIMARIES=0 0 0 0 0 0 0 0\n", 0},
                {"PRIMARIES= 0.640 0.330 0.290 0.600 0.150 0.060 0.333 0.333\n", 0},
                {"PRIMARIES=.64 .33 .3 .6 .15 .06 .3127 .329\n", 0},
                {"PRIMARIES=.708 .292 .17 .797 .131 .046 .3127 .329\n", 1}};
    for (size_t n = 0; n < sizeof rows / sizeof *rows; n++) {
        run_context m;
        sky_map     map;
        write_picture(&w, PLAIN, rows[n].text);
        assert_int_equal(read_bytes(&map, w.bytes, w.size, &m), VXS_OK);
        assert_int_equal(m.warning_count, rows[n].warns);
        if (rows[n].warns) assert_non_null(strstr(m.warnings[0], "'sky' has PRIMARIES of its own, .708 .292"));
        run_free(&m);
        sky_map_free(&map);
    }
}

/* Every beginning of a file is refused as one that ends early, or as no picture; what is damaged gives a picture of numbers, or a
 * message. */
static void test_damage(void **state)
{
    (void)state;
    static written w;
    run_context    m;
    sky_map        map;
    rng            r = {3};
    for (int c = 0; c < CODINGS; c++) {
        write_picture(&w, (coding)c, "FORMAT=32-bit_rle_rgbe\n");
        for (size_t size = 2; size < w.size; size += 1 + size / 50) {
            assert_int_equal(read_bytes(&map, w.bytes, size, &m), VXS_E_TRUNCATED);
            assert_true(m.error[0]);
            sky_map_free(&map);
        }
        for (int n = 0; n < 2000; n++) {
            size_t  at       = rng_below(&r, n % 2 ? 60 : (uint32_t)w.size);
            uint8_t was      = w.bytes[at];
            w.bytes[at]      = (uint8_t)rng_below(&r, 256);
            vxs_result found = read_bytes(&map, w.bytes, w.size, &m);
            assert_true(found == VXS_OK || m.error[0]);
            for (size_t k = 0; found == VXS_OK && k < 3 * (size_t)map.wide_px * map.high_px; k++)
                assert_true(isfinite(map.radiance[k]) && map.radiance[k] >= 0);
            sky_map_free(&map);
            w.bytes[at] = was;
        }
    }
}

/* Runs of runs: 1, 255 and 512 pixels more, and another 256. */
static void test_long_runs(void **state)
{
    (void)state;
    enum { LONG_HIGH = 512 };
    static const uint8_t row[5][4] = {{128, 0, 0, 129}, {1, 1, 1, 255}, {1, 1, 1, 2}, {0, 128, 0, 129}, {1, 1, 1, 255}};
    static written       w;
    run_context          m;
    sky_map              map;
    char                 head[64];
    w.size = 0;
    put(&w, head, (size_t)snprintf(head, sizeof head, "#?RGBE\n\n-Y %d +X %d\n", LONG_HIGH, 2 * LONG_HIGH));
    for (int y = 0; y < LONG_HIGH; y++) put(&w, row, sizeof row);
    assert_int_equal(read_bytes(&map, w.bytes, w.size, &m), VXS_OK);
    for (size_t n = 0; n < 2 * LONG_HIGH * LONG_HIGH; n++) {
        int is_first = n % (2 * LONG_HIGH) < 768;
        assert_true(map.radiance[3 * n] == (float)is_first && map.radiance[3 * n + 1] == (float)!is_first &&
                    map.radiance[3 * n + 2] == 0);
    }
    sky_map_free(&map);
}

static double linear(uint8_t byte)
{
    double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

/* sRGB; cut short and damaged files are refused by a message. */
static void test_png(void **state)
{
    (void)state;
    static uint8_t rgb[3 * PIXELS];
    run_context    m;
    sky_map        map;
    rng            r    = {5};
    size_t         size = 0;
    for (size_t n = 0; n < sizeof rgb; n++) rgb[n] = (uint8_t)rng_below(&r, 256);
    uint8_t *png = png_encode(rgb, WIDE, HIGH, 3, &size);
    assert_non_null(png);
    assert_int_equal(read_bytes(&map, png, size, &m), VXS_OK);
    for (size_t n = 0; n < sizeof rgb; n++) assert_true(fabs((double)map.radiance[n] - linear(rgb[n])) < 1e-7);
    sky_map_free(&map);
    for (size_t cut = 8; cut < size; cut += 97) {
        assert_int_equal(read_bytes(&map, png, cut, &m), VXS_E_CORRUPT);
        sky_map_free(&map);
    }
    free(png);
}

/* What is no such map, by its head alone. */
static void test_refused(void **state)
{
    (void)state;
    static const struct {
        const char *head;
        vxs_result  result;
        const char *says;
    } rows[] = {
        {"#?RADIANCE\n\n-Y 100000 +X 100000\n", VXS_E_UNSUPPORTED, "100000 x 100000 pixels: expected twice as many across as down"},
        {"#?RADIANCE\n\n-Y 50000 +X 100000\n", VXS_E_UNSUPPORTED, "at most 8192 x 4096: make it smaller"},
        {"#?RADIANCE\n\n-Y 4096 +X 8192\n", VXS_E_TRUNCATED, "ends in row 1 of 4096"},
        {"#?RADIANCE\n\n-Y 0 +X 0\n", VXS_E_UNSUPPORTED, "0 x 0 pixels"},
        {"#?RADIANCE\n\n-Y 99999999999999999999 +X 4\n", VXS_E_UNSUPPORTED, "expected '-Y HEIGHT +X WIDTH': turn it"},
        {"#?RADIANCE\n\n+Y 4 +X 8\n", VXS_E_UNSUPPORTED, "expected '-Y HEIGHT +X WIDTH': turn it"},
        {"#?RADIANCE\n\n-Y -2 +X -4\n", VXS_E_UNSUPPORTED, "pixels: expected"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 4 +X 8\n", VXS_E_UNSUPPORTED,
         "32-bit_rle_xyze: expected 32-bit_rle_rgbe: convert it"},
        {"#?RADIANCE\nEXPOSURE=-1\n\n-Y 4 +X 8\n", VXS_E_CORRUPT, "its exposure is no number above 0"},
        {"#?RADIANCE\nEXPOSURE=nan\n\n-Y 4 +X 8\n", VXS_E_CORRUPT, "its exposure is no number above 0"},
        {"#?RADIANCE\nCOLORCORR=1 1\n\n-Y 4 +X 8\n", VXS_E_CORRUPT, "its COLORCORR is not three numbers above 0"},
        {"#?RADIANCE\nCOLORCORR=1 0 1\n\n-Y 4 +X 8\n", VXS_E_CORRUPT, "its COLORCORR is not three numbers above 0"},
        {"#?RADIANCE\nEXPOSURE=1e-30\n\n-Y 1 +X 2\n\200\200\200\377\200\200\200\377", VXS_E_CORRUPT,
         "its exposure makes pixels infinite"},
        {"#?RADIANCE\n\n-Y 1 +X 2\n\1\1\1\1", VXS_E_CORRUPT, "a run is longer than its row"},
        {"#?RADIANCE\n\n-Y 132 +X 264\n\2\2\1\10\377\1\377\1\213\1", VXS_E_CORRUPT, "a run is longer than its row"},
        {"#?RADIANCE\n\n-Y 4 +X 8\n\2\2\1\1", VXS_E_CORRUPT, "a row is not as wide as the picture"},
        {"#?RADIANCE\nno end", VXS_E_TRUNCATED, "ends before its pixels begin"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof *rows; n++) {
        run_context m;
        sky_map     map;
        assert_int_equal(read_bytes(&map, (const uint8_t *)rows[n].head, strlen(rows[n].head), &m), rows[n].result);
        if (!strstr(m.error, rows[n].says)) fail_msg("row %zu: '%s'", n, m.error);
        sky_map_free(&map);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_radiance),  cmocka_unit_test(test_primaries), cmocka_unit_test(test_damage),
        cmocka_unit_test(test_long_runs), cmocka_unit_test(test_png),       cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
