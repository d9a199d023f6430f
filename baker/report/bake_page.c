/* The page about one bake; see bake_page.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/report/bake_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/files/png_encode.h"
#include "baker/report/page.h"
#include "baker/report/report.h"

/* pixels of pictures ---------------------------------------------------------------------------------------------------------- */

/* Masks that a tile needs, from few to many; until: of the class, inclusive. */
static const struct {
    uint8_t     until;
    uint8_t     colour[3];
    const char *name;
} mask_classes[] = {{1, {0xf7, 0xd5, 0x7e}, "1"},   {2, {0xf5, 0xb0, 0x41}, "2"},     {4, {0xea, 0x7d, 0x2f}, "3–4"},
                    {8, {0xd1, 0x45, 0x3b}, "5–8"}, {16, {0x9c, 0x1f, 0x5f}, "9–16"}, {64, {0x4c, 0x12, 0x6b}, "17–64"}};

enum { MASK_CLASSES = sizeof mask_classes / sizeof *mask_classes };

/* Depths that nearly all of a map lies between, so that one far thing does not make all else look flat. */
static void depth_range(const uint16_t *depth, size_t count, double *from, double *until)
{
    uint32_t histogram[1024] = {0}, seen = 0, sum = 0;
    for (size_t n = 0; n < count; n++)
        if (depth[n] != PICTURE_NO_CASTER) histogram[depth[n] / 64]++, seen++;
    *from  = 0;
    *until = PICTURE_NO_CASTER;
    for (int n = 0; n < 1024; n++) {
        if (sum <= seen / 200) *from = 64.0 * n;
        if (sum < seen - seen / 200) *until = 64.0 * n + 64;
        sum += histogram[n];
    }
}

/* Depth at a pixel or, beside the map and where there is no caster, at the one that it is compared with. */
static double depth_near(const uint16_t *depth, uint32_t side, int64_t x, int64_t y, double otherwise)
{
    if (x < 0 || y < 0 || x >= side || y >= side) return otherwise;
    uint16_t d = depth[(size_t)y * side + (size_t)x];
    return d == PICTURE_NO_CASTER ? otherwise : d;
}

/* Lightness of each pixel, 0 to 1: near is light, and slopes are lit from the upper left. rise: of a unit of depth, in pixels. */
static void shade(float *light, const uint16_t *depth, uint32_t side, double rise)
{
    double from, until;
    depth_range(depth, (size_t)side * side, &from, &until);
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            double d  = depth[(size_t)y * side + x];
            double gx = (depth_near(depth, side, (int64_t)x + 1, y, d) - depth_near(depth, side, (int64_t)x - 1, y, d)) / 2 * rise;
            double gy = (depth_near(depth, side, x, (int64_t)y + 1, d) - depth_near(depth, side, x, (int64_t)y - 1, d)) / 2 * rise;
            /* the surface looks towards the light of the map: its normal is (gx, gy, 1), shortened */
            double facing               = (0.7 - 0.45 * gx - 0.45 * gy) / sqrt(1 + gx * gx + gy * gy);
            double tone                 = 1 - 0.55 * fmin(1, fmax(0, (d - from) / fmax(1, until - from)));
            light[(size_t)y * side + x] = (float)(tone * fmin(1, fmax(0.15, 0.35 + 0.85 * facing)));
        }
}

static void grey(uint8_t rgba[4], double lightness)
{
    uint8_t level = (uint8_t)(255 * fmin(1, fmax(0, lightness))) & 0xfc; /* fewer levels, smaller pages */
    rgba[0] = rgba[1] = rgba[2] = level;
    rgba[3]                     = 255;
}

/* Depths; or with `masks`, [mask_px * mask_px] of a map, faint shapes, and the colour of its class where a pixel's tiles need masks. */
static void draw(uint8_t *rgba, const float *light, const uint16_t *depth, const light_picture *p, const uint8_t *masks)
{
    uint32_t side = p->side_px, wide = side / p->mask_px;
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            size_t  n    = (size_t)y * side + x;
            uint8_t runs = masks ? masks[(size_t)(y / wide) * p->mask_px + x / wide] : 0;
            int class    = 0;
            if (runs) {
                while (runs > mask_classes[class].until) class ++;
                memcpy(rgba + 4 * n, mask_classes[class].colour, 3);
                rgba[4 * n + 3] = 255;
            } else if (depth[n] == PICTURE_NO_CASTER) {
                memset(rgba + 4 * n, 0, 4);
            } else {
                grey(rgba + 4 * n, masks ? 0.62 + 0.3 * light[n] : light[n]);
            }
        }
}

/* pictures as JSON ------------------------------------------------------------------------------------------------------------ */

/* The text of a URL that holds a picture; NULL without memory. Released with free(). */
static char *png_url(const uint8_t *rgba, uint32_t side)
{
    static const char begin[]  = "data:image/png;base64,",
                      digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    size_t   count;
    uint8_t *png = png_encode(rgba, side, side, 4, &count);
    char    *url = png ? malloc(sizeof begin + (count + 2) / 3 * 4) : NULL;
    if (url) {
        char *to = stpcpy(url, begin);
        for (size_t n = 0; n < count; n += 3) {
            uint32_t bits = 0;
            for (size_t k = 0; k < 3; k++) bits = bits << 8 | (n + k < count ? png[n + k] : 0);
            for (size_t k = 0; k < 4; k++) *to++ = n + k > count ? '=' : digits[bits >> (18 - 6 * k) & 63];
        }
        *to = 0;
    }
    free(png);
    return url;
}

static int append_png(json_t *pictures, const uint8_t *rgba, uint32_t side)
{
    char *url     = png_url(rgba, side);
    int   failure = url ? json_array_append_new(pictures, json_string_nocheck(url)) : -1;
    free(url);
    return !failure;
}

/* Both pictures of a map. Returns 0 without memory. */
static int append_map(json_t *depths, json_t *masks, const light_picture *p, const vxs_light *light, uint32_t map)
{
    uint32_t        side   = p->side_px;
    size_t          count  = (size_t)side * side;
    const uint16_t *depth  = p->depth + map * count;
    double          texels = (double)p->map_px / side, voxels = (double)p->map_px / PICTURE_NO_CASTER;
    float          *shades = malloc(count * sizeof *shades);
    uint8_t        *rgba   = malloc(4 * count);
    int             whole  = shades && rgba;
    if (whole) {
        shade(shades, depth, side, voxels * light->voxel_metres / (texels * light->texel_metres));
        draw(rgba, shades, depth, p, NULL);
        whole = append_png(depths, rgba, side);
        draw(rgba, shades, depth, p, p->masks + (size_t)map * p->mask_px * p->mask_px);
        whole &= append_png(masks, rgba, side);
    }
    free(rgba);
    free(shades);
    return whole;
}

static json_t *picture_json(const light_picture *p, const vxs_light *light)
{
    json_t *depths = json_array(), *masks = json_array();
    int     whole = 1;
    for (uint32_t map = 0; map < p->map_count; map++) whole &= append_map(depths, masks, p, light, map);
    json_t *picture = json_pack("{s:i, s:i, s:i, s:o, s:o}", "light", (int)p->light, "side_px", (int)p->side_px, "mask_tiles",
                                (int)p->mask_tiles, "depths", depths, "masks", masks);
    if (whole) return picture;
    json_decref(picture);
    return NULL;
}

/* What colours mean, in the order of a key. */
static json_t *mask_colours_json(void)
{
    json_t *colours = json_array();
    for (int n = 0; n < MASK_CLASSES; n++) {
        const uint8_t *c = mask_classes[n].colour;
        json_array_append_new(colours, json_pack("[s, o]", mask_classes[n].name, json_sprintf("#%02x%02x%02x", c[0], c[1], c[2])));
    }
    json_array_append_new(colours, json_pack("[s, s]", "none", "#c9c9c9"));
    return colours;
}

vxs_result bake_page_write(const char *path, const bake_options *o, const bake_report *r, message *m)
{
    json_t *pictures = json_array();
    int     failed   = 0;
    for (uint32_t n = 0; n < r->picture_count; n++)
        failed |= json_array_append_new(pictures, picture_json(&r->pictures[n], &r->lights[r->pictures[n].light].light));
    json_t *data =
        json_pack("{s:o, s:o, s:o}", "report", report_json(o, r, m), "mask_colours", mask_colours_json(), "pictures", pictures);
    if (!failed) return page_write(path, PAGE_BAKE, data, m);
    json_decref(data);
    return fail(m, VXS_E_MEMORY, "out of memory for pictures of %u lights", r->picture_count);
}
