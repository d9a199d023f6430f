/* Reads a sky from a picture in the Radiance format; see sky_map.h. The format: lines of text, an empty line, the size, and rows
 * of pixels of three mantissas and an exponent, plain or run-length encoded.
 *
 * None of the linked libraries reads it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/lab/render/sky_map.h"

enum { LINE_BYTES = 1024, RUNS_WIDE_MIN = 8, RUN = 128 };

/* The file and the position in it. */
typedef struct reader {
    const sky_file *file;
    const uint8_t  *at;
    uint32_t        wide_px, high_px, row;
    double          exposure[3]; /* factors that red, green and blue were multiplied with */
    message        *m;
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

/* PRIMARIES= has the chromaticities of red, green, blue and white. Radiance's defaults are near those of sRGB, which scenes
 * have. */
static void judge_primaries(const reader *r, const char *text)
{
    static const double known[][8] = {
        {0.64, 0.33, 0.29, 0.6, 0.15, 0.06, 1.0 / 3, 1.0 / 3}, {0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329}, {0}};
    double found[8];
    int    is_known = read_numbers(text, found, 8) < 8; /* incomplete lines are ignored */
    for (size_t k = 0; k < sizeof known / sizeof *known && !is_known; k++) {
        is_known = 1;
        for (int n = 0; n < 8; n++) is_known &= fabs(found[n] - known[k][n]) < 2e-3;
    }
    if (!is_known)
        warn(r->m, "'%s' has PRIMARIES of its own, %.60s: its colours are taken as those of sRGB; convert it", r->file->name,
             text + strspn(text, " \t"));
}

static vxs_result read_setting(reader *r, char *line)
{
    static const char format[] = "32-bit_rle_rgbe";
    for (size_t size = strlen(line); size && (line[size - 1] == ' ' || line[size - 1] == '\t'); size--) line[size - 1] = '\0';
    if (!strncmp(line, "EXPOSURE=", 9)) return read_factors(r, line + 9, 1);
    if (!strncmp(line, "COLORCORR=", 10)) return read_factors(r, line + 10, 3);
    if (!strncmp(line, "PRIMARIES=", 10)) judge_primaries(r, line + 10);
    if (strncmp(line, "FORMAT=", 7)) return VXS_OK;
    const char *found = line + 7 + strspn(line + 7, " \t");
    return strcmp(found, format) ? fail(r->m, VXS_E_UNSUPPORTED, "'%s' has pixels of format %s: expected %s: convert it",
                                        r->file->name, found, format)
                                 : VXS_OK;
}

/* "-Y 512 +X 1024": rows from the top, from left to right. */
static vxs_result read_size(reader *r, const char *line)
{
    if (sscanf(line, "-Y %9u +X %9u", &r->high_px, &r->wide_px) == 2) return VXS_OK;
    return fail(r->m, VXS_E_UNSUPPORTED, "'%s' says '%.40s' of its rows: expected '-Y HEIGHT +X WIDTH': turn it", r->file->name,
                line);
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
    return next_line(r, line) ? read_size(r, line) : broken(r, VXS_E_TRUNCATED, "it ends before its pixels begin");
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

/* Three mantissas of 8 bits below 1, times two to the power of the exponent - 128; 0 where that is 0. */
static vxs_result put_row(const reader *r, const uint8_t (*row)[4], float *radiance)
{
    for (uint32_t x = 0; x < r->wide_px; x++)
        for (int n = 0; n < 3; n++) {
            double value = row[x][3] ? ldexp(row[x][n], row[x][3] - 136) / r->exposure[n] : 0;
            if (!(value <= FLT_MAX)) return broken(r, VXS_E_CORRUPT, "its exposure makes pixels infinite");
            *radiance++ = (float)value;
        }
    return VXS_OK;
}

/* ------------------------------------------------------------------------------------------------------------------------------ */

int sky_is_radiance(const sky_file *file)
{
    return file->end - file->bytes >= 2 && !memcmp(file->bytes, "#?", 2);
}

vxs_result sky_read_radiance(sky_map *map, const sky_file *file, message *m)
{
    uint8_t    row[2 * SKY_HIGH_MAX][4];
    reader     r      = {.file = file, .at = file->bytes, .exposure = {1, 1, 1}, .m = m};
    vxs_result result = read_head(&r);
    if (result == VXS_OK) result = sky_map_make(map, file, r.wide_px, r.high_px, m);
    for (; r.row < r.high_px && result == VXS_OK; r.row++) {
        result = read_row(&r, row);
        if (result == VXS_OK) result = put_row(&r, row, map->radiance + 3 * (size_t)r.row * r.wide_px);
    }
    return result;
}
