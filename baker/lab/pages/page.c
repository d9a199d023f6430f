/* Pages; see page.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/pages/page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "baker/base/embedded.h"
#include "baker/base/memory.h"
#include "baker/base/watch.h"
#include "baker/command/report/report.h"
#include "baker/files/html_data.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
#include "baker/files/png_encode.h"
#include "baker/lab/picture/picture.h"

EMBEDDED(page_html)
EMBEDDED(page_js)
EMBEDDED(bake_page_js)
EMBEDDED(bench_page_js)
EMBEDDED(volumes_page_js)
EMBEDDED(charts_js)
EMBEDDED(chart_min_js)

/* any page --------------------------------------------------------------------------------------------------------------------- */

/* The text after a mark in it. This skips the comments at the head of templates, which are for developers. */
static embedded behind(embedded text, const char *mark)
{
    const char *at = memmem(text.begin, (size_t)(text.end - text.begin), mark, strlen(mark));
    return (embedded){at + strlen(mark), text.end};
}

vxs_result page_write(const char *path, page_kind kind, json_t *data, run_context *m)
{
    char       *json = data ? json_print(data, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    output_file out  = {0};
    vxs_result  r    = VXS_OK;
    if (!json) {
        r = fail(m, VXS_E_MEMORY, "out of memory for the page %s", path);
        goto done;
    }
    if ((r = output_file_open(&out, path, m)) != VXS_OK) goto done;

    FILE    *to     = out.stream;
    embedded script = kind == PAGE_BAKE ? bake_page_js : kind == PAGE_BENCH ? bench_page_js : volumes_page_js;
    embedded_print(to, behind(page_html, "-->\n"));
    html_print_json(to, json);
    fputs("</script>\n<script>", to);
    if (kind != PAGE_BAKE) embedded_print(to, chart_min_js);
    fputs("</script>\n<script>", to);
    embedded_print(to, behind(page_js, "*/\n"));
    if (kind != PAGE_BAKE) embedded_print(to, behind(charts_js, "*/\n"));
    embedded_print(to, behind(script, "*/\n"));
    fputs("</script>\n</body>\n</html>\n", to);

    r = output_file_commit(&out, m);
done:
    output_file_abort(&out);
    free(json);
    json_decref(data);
    return r;
}

/* the page of a bake: pixels of pictures --------------------------------------------------------------------------------------- */

/* The size of the picture of the shadows, and limits on memory for drawing it: in all, and for each triangle. */
enum { PICTURE_WIDTH_PX = 480, PICTURE_HEIGHT_PX = 270, PICTURE_BYTES = 16 << 20, PICTURE_TRIANGLE_BYTES = 160 };

/* Classes of the number of masks that a tile needs, ascending; until: the class's largest number. */
static const struct {
    uint8_t     until;
    uint8_t     colour[3];
    const char *name;
} mask_classes[] = {{1, {0xf7, 0xd5, 0x7e}, "1"},   {2, {0xf5, 0xb0, 0x41}, "2"},     {4, {0xea, 0x7d, 0x2f}, "3–4"},
                    {8, {0xd1, 0x45, 0x3b}, "5–8"}, {16, {0x9c, 0x1f, 0x5f}, "9–16"}, {64, {0x4c, 0x12, 0x6b}, "17–64"}};

enum { MASK_CLASSES = sizeof mask_classes / sizeof *mask_classes };

/* A depth range that covers nearly all of a map, so that a single distant object does not reduce the contrast of the rest. */
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

/* The depth at a pixel; `otherwise` beside the map and where there is no caster. */
static double depth_near(const uint16_t *depth, uint32_t side, int64_t x, int64_t y, double otherwise)
{
    if (x < 0 || y < 0 || x >= side || y >= side) return otherwise;
    uint16_t d = depth[(size_t)y * side + (size_t)x];
    return d == PICTURE_NO_CASTER ? otherwise : d;
}

/* Lightness of each pixel, 0 to 1: near is light, and slopes are lit from the upper left. rise: pixels for a unit of depth. */
static void shade(float *light, const uint16_t *depth, uint32_t side, double rise, double from, double until)
{
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            double d  = depth[(size_t)y * side + x];
            double gx = (depth_near(depth, side, (int64_t)x + 1, y, d) - depth_near(depth, side, (int64_t)x - 1, y, d)) / 2 * rise;
            double gy = (depth_near(depth, side, x, (int64_t)y + 1, d) - depth_near(depth, side, x, (int64_t)y - 1, d)) / 2 * rise;
            /* the surface faces the light in the picture: its normal is (gx, gy, 1), normalized */
            double facing               = (0.7 - 0.45 * gx - 0.45 * gy) / sqrt(1 + gx * gx + gy * gy);
            double tone                 = 1 - 0.55 * fmin(1, fmax(0, (d - from) / fmax(1, until - from)));
            light[(size_t)y * side + x] = (float)(tone * fmin(1, fmax(0.15, 0.35 + 0.85 * facing)));
        }
}

/* Position and rotation of a cube's faces when it is unfolded into a cross, so that edges meet: +x, +z, -x and -z in a row, as
 * seen by the light with +y above. Axes are the light's own; its y is as upright as possible. */
typedef enum turn { TURN_NONE, TURN_QUARTER, TURN_HALF, TURN_THREE_QUARTERS } turn;

typedef struct face_place {
    uint32_t column, row;
    turn     turned;
} face_place;

static const face_place cross_places[6] = {{0, 1, TURN_QUARTER},        {2, 1, TURN_HALF}, /* +x, -x */
                                           {1, 0, TURN_THREE_QUARTERS}, {1, 2, TURN_HALF}, /* +y, -y */
                                           {1, 1, TURN_HALF},           {3, 1, TURN_QUARTER}};

/* A picture of all maps of a light: one map, or the cross of six. */
typedef struct canvas {
    uint32_t width_px, height_px;
    uint8_t *rgba; /* [4 * width * height] transparent outside of maps */
} canvas;

/* Draw depths. With `masks`, [mask_px * mask_px] of a map: faint shapes, and the colour of its class where a pixel's tiles need
 * masks. */
static void draw(canvas *c, face_place place, const float *light, const uint16_t *depth, const light_picture *p,
                 const uint8_t *masks)
{
    uint32_t side = p->side_px, wide = side / p->mask_px;
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            /* the pixel of the map at (x, y) of its rotated picture */
            uint32_t u = x, v = y, last = side - 1;
            if (place.turned == TURN_QUARTER) u = last - y, v = x;
            if (place.turned == TURN_HALF) u = last - x, v = last - y;
            if (place.turned == TURN_THREE_QUARTERS) u = y, v = last - x;
            size_t n = (size_t)v * side + u;

            uint8_t  runs = masks ? masks[n / side / wide * p->mask_px + n % side / wide] : 0;
            uint8_t *rgba = c->rgba + 4 * ((size_t)(place.row * side + y) * c->width_px + place.column * side + x);
            int class     = 0;
            if (runs) {
                while (runs > mask_classes[class].until) class ++;
                memcpy(rgba, mask_classes[class].colour, 3);
                rgba[3] = 255;
            } else if (depth[n] != PICTURE_NO_CASTER) {
                double  lightness = masks ? 0.62 + 0.3 * light[n] : light[n];
                uint8_t level     = (uint8_t)(255 * fmin(1, fmax(0, lightness))) & 0xfc; /* fewer levels, smaller pages */
                rgba[0] = rgba[1] = rgba[2] = level;
                rgba[3]                     = 255;
            }
        }
}

/* pictures as JSON ------------------------------------------------------------------------------------------------------------- */

/* A data URL with a picture of 3 or 4 channels; NULL when out of memory. Released with free(). */
static char *png_url(const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels)
{
    static const char begin[] = "data:image/png;base64,";
    size_t            count;
    uint8_t          *png = png_encode(pixels, width_px, height_px, channels, &count);
    char             *url = png ? malloc(sizeof begin + base64_length(count)) : NULL;
    if (url) {
        char *to = stpcpy(url, begin);
        base64_encode(to, png, count);
        to[base64_length(count)] = '\0';
    }
    free(png);
    return url;
}

/* NULL when out of memory. */
static json_t *png_json(const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels)
{
    char   *url  = pixels ? png_url(pixels, width_px, height_px, channels) : NULL;
    json_t *json = url ? json_string_nocheck(url) : NULL;
    free(url);
    return json;
}

/* All maps of a light in one picture, of depths or of masks. NULL when out of memory. */
static json_t *maps_json(const light_picture *p, const vxs_light *light, int masks)
{
    uint32_t side = p->side_px, cube = p->map_count > 1;
    size_t   count  = (size_t)side * side;
    canvas   c      = {cube ? 4 * side : side, cube ? 3 * side : side, NULL};
    double   texels = (double)p->map_px / side, voxels = (double)p->map_px / PICTURE_NO_CASTER, from, until;
    float   *shades = malloc(count * sizeof *shades);
    c.rgba          = calloc((size_t)c.width_px * c.height_px, 4);
    depth_range(p->depth, p->map_count * count, &from, &until); /* of all six, so that tones are continuous from face to face */
    for (uint32_t map = 0; map < p->map_count && shades && c.rgba; map++) {
        const uint16_t *depth = p->depth + map * count;
        shade(shades, depth, side, voxels * light->voxel_metres / (texels * light->texel_metres), from, until);
        draw(&c, cube ? cross_places[map] : (face_place){0, 0, TURN_NONE}, shades, depth, p,
             masks ? p->masks + (size_t)map * p->mask_px * p->mask_px : NULL);
    }
    json_t *json = shades ? png_json(c.rgba, c.width_px, c.height_px, 4) : NULL;
    free(c.rgba);
    free(shades);
    return json;
}

vxs_result bake_page_look(void *page, const bake_options *o, const casters *c, vxs_bytes *file, run_context *m)
{
    bake_page *p     = page;
    uint64_t   bytes = PICTURE_BYTES + PICTURE_TRIANGLE_BYTES * c->triangle_count + 8 * file->size_bytes;
    if (o->memory_bytes && memory_held_bytes() + bytes > o->memory_bytes) return VXS_OK;
    watch_say(o->watch, "drawing the shadows");
    p->rgb = malloc((size_t)3 * PICTURE_WIDTH_PX * PICTURE_HEIGHT_PX);
    if (!p->rgb) return fail(m, VXS_E_MEMORY, "out of memory for a picture of the shadows");
    return asset_picture(p->rgb, PICTURE_WIDTH_PX, PICTURE_HEIGHT_PX, c, file->data, file->size_bytes, o->threads, m);
}

vxs_result bake_page_write(const char *path, const bake_page *page, const bake_options *o, const bake_report *r, run_context *m)
{
    json_t *pictures = json_array();
    for (uint32_t n = 0; n < r->picture_count; n++) {
        const light_picture *p      = &r->pictures[n];
        const vxs_light     *light  = &r->lights[p->light].light;
        const double        *a      = light->ls_from_ws; /* the axes of the light in the world */
        json_t              *depths = maps_json(p, light, 0), *masks = maps_json(p, light, 1);
        json_array_append_new(pictures,
                              json_pack("{s:i, s:i, s:i, s:[[f,f,f], [f,f,f], [f,f,f]], s:o, s:o}", "light", (int)p->light,
                                        "side_px", (int)p->side_px, "mask_tiles", (int)p->mask_tiles, "axes", a[0], a[1], a[2],
                                        a[4], a[5], a[6], a[8], a[9], a[10], "depths", depths, "masks", masks));
    }

    json_t *colours = json_array(); /* their meaning, in the order of a legend */
    for (int n = 0; n < MASK_CLASSES; n++) {
        const uint8_t *c = mask_classes[n].colour;
        json_array_append_new(colours, json_pack("[s, o]", mask_classes[n].name, json_sprintf("#%02x%02x%02x", c[0], c[1], c[2])));
    }
    json_array_append_new(colours, json_pack("[s, s]", "none", "#c9c9c9"));

    /* the modification time of the scene's file, "2026-11-22 08:30 UTC"; null if unknown */
    struct stat status;
    struct tm   utc;
    char        date[32];
    int         is_known = !stat(o->scene_path, &status) && S_ISREG(status.st_mode) && gmtime_r(&status.st_mtime, &utc) != NULL;
    if (is_known) strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", &utc);

    json_t *shadows = page->rgb ? png_json(page->rgb, PICTURE_WIDTH_PX, PICTURE_HEIGHT_PX, 3) : json_null();
    int     whole   = shadows && json_array_size(pictures) == r->picture_count;
    json_t *data =
        json_pack("{s:o, s:s?, s:o, s:o, s:i, s:o}", "report", report_json(o, r, m), "scene_date", is_known ? date : NULL,
                  "mask_colours", colours, "shadows", shadows, "shadow_lights", ASSET_PICTURE_LIGHTS, "pictures", pictures);
    if (whole) return page_write(path, PAGE_BAKE, data, m);
    json_decref(data);
    return fail(m, VXS_E_MEMORY, "out of memory for pictures of %u lights", r->picture_count);
}

void bake_page_free(bake_page *page)
{
    free(page->rgb);
    page->rgb = NULL;
}
