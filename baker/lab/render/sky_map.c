/* Reads a map of the sky: a PNG, by libpng; or a picture in the Radiance format, which none of the linked libraries reads: lines of
 * text, an empty line, the size, and rows of pixels of three mantissas and an exponent, plain or run-length encoded.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/sky_map.h"

#include <float.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/memory.h"
#include "baker/base/srgb.h"
#include "baker/files/input_file.h"

enum { FILE_BYTES_MAX = 1 << 28 };

/* A file in memory, and its name in messages. */
typedef struct sky_file {
    const char    *name;
    const uint8_t *bytes, *end;
} sky_file;

/* Allocate a map of the size that a file states.   Returns VXS_OK, VXS_E_UNSUPPORTED, VXS_E_MEMORY. */
static vxs_result make_map(sky_map *map, const sky_file *file, uint32_t wide_px, uint32_t high_px, run_context *m)
{
    size_t count = 3 * (size_t)wide_px * high_px;
    if (!high_px || high_px != wide_px / 2 || wide_px % 2)
        return fail(m, VXS_E_UNSUPPORTED,
                    "'%s' has %u x %u pixels: expected twice as many across as down, an equirectangular map of all directions",
                    file->name, wide_px, high_px);
    if (high_px > SKY_HIGH_MAX)
        return fail(m, VXS_E_UNSUPPORTED, "'%s' has %u x %u pixels: expected at most %d x %d: make it smaller", file->name, wide_px,
                    high_px, 2 * SKY_HIGH_MAX, SKY_HIGH_MAX);
    vxs_result r = memory_check(2 * count * sizeof *map->radiance, m, "the sky of '%s', %u x %u pixels, here and in OpenGL, needs",
                                file->name, wide_px, high_px);
    if (r != VXS_OK) return r;
    *map = (sky_map){wide_px, high_px, malloc(count * sizeof *map->radiance)};
    return map->radiance ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the sky of '%s'", file->name);
}

static int is_png(const sky_file *file)
{
    static const char magic[8] = "\x89PNG\r\n\x1a\n";
    return file->end - file->bytes >= 8 && !memcmp(file->bytes, magic, sizeof magic);
}

/* Radiance --------------------------------------------------------------------------------------------------------------------- */

enum { LINE_BYTES = 1024, RUNS_WIDE_MIN = 8, RUN = 128 };

/* The file and the position in it. */
typedef struct reader {
    const sky_file *file;
    const uint8_t  *at;
    uint32_t        wide_px, high_px, row;
    double          exposure[3]; /* factors that red, green and blue were multiplied with */
    run_context    *m;
} reader;

static vxs_result broken(const reader *r, vxs_result code, const char *what)
{
    return fail(r->m, code, "'%s' is a broken Radiance picture: %s", r->file->name, what);
}

static vxs_result ends_early(const reader *r)
{
    return fail(r->m, VXS_E_TRUNCATED, "'%s' ends in row %u of %u", r->file->name, r->row + 1, r->high_px);
}

/* lines of text ---------------------------------------------------------------------------------------------------------------- */

/* Read the next line, cut to the size of `line`, without its end.   Returns 0 when the file ends first. */
static int next_line(reader *r, char line[LINE_BYTES])
{
    const uint8_t *end = memchr(r->at, '\n', (size_t)(r->file->end - r->at));
    if (!end) return 0;
    size_t size = (size_t)(end - r->at), kept = size < LINE_BYTES ? size : LINE_BYTES - 1;
    memcpy(line, r->at, kept);
    if (kept && line[kept - 1] == '\r') kept--;
    line[kept] = '\0';
    r->at      = end + 1;
    return 1;
}

/* Read up to `most` numbers, by strtod.   Returns how many were found. */
static int read_numbers(const char *text, double *numbers, int most)
{
    int count = 0;
    for (char *end; count < most; count++, text = end) {
        numbers[count] = strtod(text, &end);
        if (end == text) break;
    }
    return count;
}

/* EXPOSURE= has one factor for the whole picture, COLORCORR= one for each colour; both may occur many times. */
static vxs_result read_factors(reader *r, const char *text, int count)
{
    double factor[3];
    int    good = read_numbers(text, factor, count) == count;
    for (int n = 0; n < 3; n++) {
        r->exposure[n] *= good ? factor[n % count] : 0;
        if (!(r->exposure[n] > 0 && isfinite(r->exposure[n])))
            return broken(r, VXS_E_CORRUPT,
                          count == 1 ? "its exposure is no number above 0" : "its COLORCORR is not three numbers above 0");
    }
    return VXS_OK;
}

static vxs_result read_setting(reader *r, char *line)
{
    static const char format[] = "32-bit_rle_rgbe";
    for (size_t size = strlen(line); size && (line[size - 1] == ' ' || line[size - 1] == '\t'); size--) line[size - 1] = '\0';
    if (!strncmp(line, "EXPOSURE=", 9)) return read_factors(r, line + 9, 1);
    if (!strncmp(line, "COLORCORR=", 10)) return read_factors(r, line + 10, 3);
    if (!strncmp(line, "PRIMARIES=", 10)) {
        /* chromaticities of red, green, blue and white; Radiance's defaults are near those of sRGB, which scenes have */
        static const double known[][8] = {
            {0.64, 0.33, 0.29, 0.6, 0.15, 0.06, 1.0 / 3, 1.0 / 3}, {0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329}, {0}};
        double found[8];
        int    is_known = read_numbers(line + 10, found, 8) < 8; /* incomplete lines are ignored */
        for (size_t k = 0; k < sizeof known / sizeof *known && !is_known; k++) {
            is_known = 1;
            for (int n = 0; n < 8; n++) is_known &= fabs(found[n] - known[k][n]) < 2e-3;
        }
        if (!is_known)
            warn(r->m, "'%s' has PRIMARIES of its own, %.60s: its colours are taken as those of sRGB; convert it", r->file->name,
                 line + 10 + strspn(line + 10, " \t"));
    }
    if (strncmp(line, "FORMAT=", 7)) return VXS_OK;
    const char *found = line + 7 + strspn(line + 7, " \t");
    return strcmp(found, format) ? fail(r->m, VXS_E_UNSUPPORTED, "'%s' has pixels of format %s: expected %s: convert it",
                                        r->file->name, found, format)
                                 : VXS_OK;
}

static vxs_result read_head(reader *r)
{
    char       line[LINE_BYTES];
    vxs_result result = VXS_OK;
    do {
        if (!next_line(r, line)) return broken(r, VXS_E_TRUNCATED, "it ends before its pixels begin");
        result = read_setting(r, line);
    } while (result == VXS_OK && *line);
    if (result != VXS_OK) return result;
    if (!next_line(r, line)) return broken(r, VXS_E_TRUNCATED, "it ends before its pixels begin");
    if (sscanf(line, "-Y %9u +X %9u", &r->high_px, &r->wide_px) == 2) return VXS_OK; /* rows from the top, from left to right */
    return fail(r->m, VXS_E_UNSUPPORTED, "'%s' says '%.40s' of its rows: expected '-Y HEIGHT +X WIDTH': turn it", r->file->name,
                line);
}

/* rows ------------------------------------------------------------------------------------------------------------------------- */

/* Decode one of the four bytes of all pixels of a row: a length and so many bytes, or RUN plus a length and one byte to repeat. */
static vxs_result read_channel(reader *r, uint8_t (*row)[4], int channel)
{
    for (uint32_t x = 0; x < r->wide_px;) {
        if (r->file->end - r->at < 2) return ends_early(r);
        uint8_t  length = *r->at++;
        int      is_run = length > RUN;
        uint32_t count  = is_run ? length - RUN : length;
        if (!count || count > r->wide_px - x) return broken(r, VXS_E_CORRUPT, "a run is longer than its row");
        if (!is_run && r->file->end - r->at < (ptrdiff_t)count) return ends_early(r);
        for (uint32_t n = 0; n < count; n++) row[x++][channel] = r->at[is_run ? 0 : n];
        r->at += is_run ? 1 : count;
    }
    return VXS_OK;
}

/* Decode pixels one by one. 1, 1, 1, n repeats the pixel before n times; directly after another such pixel, 256 n times. */
static vxs_result read_pixels(reader *r, uint8_t (*row)[4])
{
    uint64_t unit = 1;
    for (uint32_t x = 0; x < r->wide_px; r->at += 4) {
        if (r->file->end - r->at < 4) return ends_early(r);
        int      again = r->at[0] == 1 && r->at[1] == 1 && r->at[2] == 1;
        uint64_t count = again ? unit * r->at[3] : 1;
        if (count > r->wide_px - x || (again && !x)) return broken(r, VXS_E_CORRUPT, "a run is longer than its row");
        for (uint64_t n = 0; n < count; n++, x++) memcpy(row[x], again ? row[x - 1] : r->at, 4);
        unit = again && unit <= r->wide_px ? 256 * unit : 1;
    }
    return VXS_OK;
}

static vxs_result read_row(reader *r, uint8_t (*row)[4])
{
    const uint8_t *at = r->at;
    if (r->file->end - at < 4) return ends_early(r);
    if (r->wide_px < RUNS_WIDE_MIN || at[0] != 2 || at[1] != 2 || at[2] >= 128) return read_pixels(r, row);
    if ((uint32_t)(at[2] << 8 | at[3]) != r->wide_px) return broken(r, VXS_E_CORRUPT, "a row is not as wide as the picture");
    r->at += 4;
    vxs_result result = VXS_OK;
    for (int n = 0; n < 4 && result == VXS_OK; n++) result = read_channel(r, row, n);
    return result;
}

static int is_radiance(const sky_file *file)
{
    return file->end - file->bytes >= 2 && !memcmp(file->bytes, "#?", 2);
}

static vxs_result read_radiance(sky_map *map, const sky_file *file, run_context *m)
{
    uint8_t    row[2 * SKY_HIGH_MAX][4];
    reader     r      = {.file = file, .at = file->bytes, .exposure = {1, 1, 1}, .m = m};
    vxs_result result = read_head(&r);
    if (result == VXS_OK) result = make_map(map, file, r.wide_px, r.high_px, m);
    if (result != VXS_OK) return result;
    for (float *radiance = map->radiance; r.row < r.high_px; r.row++) {
        if ((result = read_row(&r, row)) != VXS_OK) return result;
        for (uint32_t n = 0; n < 3 * r.wide_px; n++) {
            /* mantissas of 8 bits below 1, times two to the power of the exponent - 128; 0 where that is 0 */
            const uint8_t *pixel = row[n / 3];
            double         value = pixel[3] ? ldexp(pixel[n % 3], pixel[3] - 136) / r.exposure[n % 3] : 0;
            if (!(value <= FLT_MAX)) return broken(&r, VXS_E_CORRUPT, "its exposure makes pixels infinite");
            *radiance++ = (float)value;
        }
    }
    return VXS_OK;
}

/* PNG ------------------------------------------------------------------------------------------------------------------------ */

static vxs_result read_png(sky_map *map, const sky_file *file, run_context *m)
{
    png_image  image  = {.version = PNG_IMAGE_VERSION};
    png_color  black  = {0, 0, 0}; /* of transparent pixels */
    uint8_t   *pixels = NULL;
    float      light[256];
    vxs_result r = VXS_OK;
    if (!png_image_begin_read_from_memory(&image, file->bytes, (size_t)(file->end - file->bytes))) {
        r = fail(m, VXS_E_CORRUPT, "'%s' is a broken PNG: %s", file->name, image.message);
        goto done;
    }
    if ((r = make_map(map, file, image.width, image.height, m)) != VXS_OK) goto done;
    size_t count = 3 * (size_t)map->wide_px * map->high_px;
    if (!(pixels = malloc(count))) {
        r = fail(m, VXS_E_MEMORY, "out of memory for the sky of '%s'", file->name);
        goto done;
    }
    image.format = PNG_FORMAT_RGB;
    if (!png_image_finish_read(&image, &black, pixels, 0, NULL)) {
        r = fail(m, VXS_E_CORRUPT, "'%s' is a broken PNG: %s", file->name, image.message);
        goto done;
    }
    for (int n = 0; n < 256; n++) light[n] = srgb_light((uint8_t)n);
    for (size_t n = 0; n < count; n++) map->radiance[n] = light[pixels[n]];
done:
    free(pixels);
    png_image_free(&image);
    return r;
}

/* files ------------------------------------------------------------------------------------------------------------------------ */

vxs_result sky_map_decode(sky_map *map, const char *name, const uint8_t *bytes, size_t size_bytes, run_context *m)
{
    sky_file   file = {name, bytes, bytes + size_bytes};
    vxs_result r    = VXS_E_UNSUPPORTED;
    *map            = (sky_map){0};
    if (is_radiance(&file))
        r = read_radiance(map, &file, m);
    else if (is_png(&file))
        r = read_png(map, &file, m);
    else
        fail(m, r, "'%s' is neither a Radiance picture (.hdr) nor a PNG: convert it to .hdr", name);

    size_t black = 0, count = 3 * (size_t)map->wide_px * map->high_px;
    while (black < count && !(map->radiance[black] > 0)) black++;
    if (r == VXS_OK && black == count) r = fail(m, VXS_E_SCENE, "'%s' is black: there is no light in it", name);
    if (r != VXS_OK) sky_map_free(map);
    return r;
}

/* Reads on only if the file begins as a supported picture. */
static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    sky_file file = {user, first, first + size_bytes};
    return is_radiance(&file) || is_png(&file) ? UINT64_MAX : 0;
}

vxs_result sky_map_read(sky_map *map, const char *path, run_context *m)
{
    uint8_t *bytes  = NULL;
    size_t   size   = 0;
    *map            = (sky_map){0};
    input_head head = {wanted_bytes, (void *)input_name(path)};
    vxs_result r    = input_read(&bytes, &size, path, FILE_BYTES_MAX, &head, m);
    if (r == VXS_OK) r = sky_map_decode(map, input_name(path), bytes, size, m);
    free(bytes);
    return r;
}

void sky_map_free(sky_map *map)
{
    free(map->radiance);
    *map = (sky_map){0};
}
