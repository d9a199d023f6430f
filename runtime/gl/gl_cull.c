/* Lists of lights for tiles of pixels; see vxs_gl.h. The C version uses vxs_cull.h in float, as the shaders do.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"

#define vxs_real     float
#define VXS_REAL_MIN 1e-30f
#define VXS_LIGHT    const vxs_light_constants *
#include "vxs_cull.h"

enum { LISTS_WIDE = 2048 };

uint64_t vxs_lists_words(uint32_t width_px, uint32_t height_px, uint32_t tile_lights)
{
    uint64_t columns = ((uint64_t)width_px + VXS_TILE_PX - 1) / VXS_TILE_PX,
             rows    = ((uint64_t)height_px + VXS_TILE_PX - 1) / VXS_TILE_PX;
    uint64_t list    = (uint64_t)tile_lights + 1;
    return columns * rows > (UINT64_MAX - VXS_LISTS_HEAD) / list ? UINT64_MAX : VXS_LISTS_HEAD + columns * rows * list;
}

/* in C ------------------------------------------------------------------------------------------------------------------------ */

/* SOME_LIGHTS lights at a time are tested first against a square of 64 tiles, then the remaining ones against each tile: with ten
 * thousand lights, most are far from all tiles.
 *
 *       some lights --- box of a square of tiles ---> few --- box of a tile ---> its list */
enum { SQUARE_TILES = 8, SOME_LIGHTS = 1024 };

/* A box; empty where low is greater than high. */
typedef struct tile_box {
    float low[3], high[3];
} tile_box;

static const tile_box empty_box = {{3e38f, 3e38f, 3e38f}, {-3e38f, -3e38f, -3e38f}};

/* Add a pixel's point to a box, unless the point is not finite or too far away. */
static void add_pixel(tile_box *b, const vxs_view *v, uint32_t x, uint32_t y, float depth)
{
    const float *m = v->point_from_depth, u = ((float)x + 0.5f) / (float)v->width_px, w = ((float)y + 0.5f) / (float)v->height_px;
    float        last = m[3] * u + m[7] * w + m[11] * depth + m[15], at[3];
    for (int n = 0; n < 3; n++) {
        at[n] = (m[n] * u + m[4 + n] * w + m[8 + n] * depth + m[12 + n]) / last;
        if (!(fabsf(at[n]) < (float)VXS_VIEW_METRES)) return;
    }
    for (int n = 0; n < 3; n++) {
        b->low[n]  = at[n] < b->low[n] ? at[n] : b->low[n];
        b->high[n] = at[n] > b->high[n] ? at[n] : b->high[n];
    }
}

static tile_box box_of_tile(const vxs_view *v, const float *depths, uint32_t column, uint32_t row)
{
    tile_box b      = empty_box;
    uint32_t x_last = (column + 1) * VXS_TILE_PX, y_last = (row + 1) * VXS_TILE_PX;
    for (uint32_t y = row * VXS_TILE_PX; y < y_last && y < v->height_px; y++)
        for (uint32_t x = column * VXS_TILE_PX; x < x_last && x < v->width_px; x++) {
            float depth = depths[(size_t)y * v->width_px + x];
            if (depth != v->empty_depth) add_pixel(&b, v, x, y, depth);
        }
    return b;
}

static void add_box(tile_box *b, const tile_box *other)
{
    for (int n = 0; n < 3; n++) {
        b->low[n]  = other->low[n] < b->low[n] ? other->low[n] : b->low[n];
        b->high[n] = other->high[n] > b->high[n] ? other->high[n] : b->high[n];
    }
}

/* Select the lights that meet a box, in their order.
 * some  [count] light indices
 * met   [out] [room] light indices; may be the same array as some
 * Returns how many lights meet the box; the first `room` of them are written. */
static uint32_t choose_lights(const vxs_light_constants *lights, const uint32_t *some, uint32_t count, const tile_box *b,
                              vxs_filter filter, uint32_t *met, uint32_t room)
{
    float    middle[3], half_size[3];
    uint32_t found = 0;
    if (b->low[0] > b->high[0]) return 0;
    for (int n = 0; n < 3; n++) {
        middle[n]    = 0.5f * (b->low[n] + b->high[n]);
        half_size[n] = b->high[n] - middle[n];
    }
    for (uint32_t n = 0; n < count; n++) {
        if (!vxs_light_meets_box(&lights[some[n]], middle, half_size, filter)) continue;
        if (found < room) met[found] = some[n];
        found++;
    }
    return found;
}

/* A square of tiles, clipped to the view. */
typedef struct tile_square {
    uint32_t column, row, columns, rows;
    tile_box boxes[SQUARE_TILES * SQUARE_TILES], all;
} tile_square;

static void find_boxes(tile_square *s, const vxs_view *view, const float *depths)
{
    s->all = empty_box;
    for (uint32_t n = 0; n < s->columns * s->rows; n++) {
        s->boxes[n] = box_of_tile(view, depths, s->column + n % s->columns, s->row + n / s->columns);
        add_box(&s->all, &s->boxes[n]);
    }
}

/* Append those of lights [first, end) that meet a tile to the lists of a square's tiles. */
static void list_lights(const vxs_light_constants *lights, uint32_t first, uint32_t end, const tile_square *s, vxs_filter filter,
                        uint32_t *lists)
{
    uint32_t some[SOME_LIGHTS], count = end - first, room = lists[2];
    for (uint32_t n = 0; n < count; n++) some[n] = first + n;
    count = choose_lights(lights, some, count, &s->all, filter, some, count);
    for (uint32_t n = 0; n < s->columns * s->rows; n++) {
        uint64_t  tile = (uint64_t)(s->row + n / s->columns) * lists[0] + s->column + n % s->columns;
        uint32_t *list = lists + VXS_LISTS_HEAD + tile * ((uint64_t)room + 1), used = list[0] < room ? list[0] : room;
        list[0] += choose_lights(lights, some, count, &s->boxes[n], filter, list + 1 + used, room - used);
    }
}

static uint32_t less(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

uint32_t vxs_cull(const vxs_light_constants *lights, uint32_t light_count, const vxs_view *view, const float *depths,
                  uint32_t tile_lights, uint32_t *lists)
{
    uint32_t columns = (view->width_px + VXS_TILE_PX - 1) / VXS_TILE_PX, rows = (view->height_px + VXS_TILE_PX - 1) / VXS_TILE_PX;
    uint32_t longest = 0, *list = lists + VXS_LISTS_HEAD;
    memcpy(lists, (const uint32_t[VXS_LISTS_HEAD]){columns, rows, tile_lights, light_count}, VXS_LISTS_HEAD * sizeof *lists);
    for (uint64_t n = 0; n < (uint64_t)columns * rows; n++) list[n * ((uint64_t)tile_lights + 1)] = 0;
    for (uint32_t row = 0; row < rows; row += SQUARE_TILES)
        for (uint32_t column = 0; column < columns; column += SQUARE_TILES) {
            tile_square s = {.column = column, .row = row};
            s.columns     = less(columns - column, SQUARE_TILES);
            s.rows        = less(rows - row, SQUARE_TILES);
            find_boxes(&s, view, depths);
            for (uint32_t first = 0, end; first < light_count; first = end) {
                end = first + less(light_count - first, SOME_LIGHTS);
                list_lights(lights, first, end, &s, view->filter, lists);
            }
        }
    for (uint64_t n = 0; n < (uint64_t)columns * rows; n++, list += (uint64_t)tile_lights + 1)
        longest = list[0] > longest ? list[0] : longest;
    return longest;
}

/* on the graphics processor --------------------------------------------------------------------------------------------------- */

static int make_lists(vxs_gl *gl, uint64_t words)
{
    if (gl->lists.name && gl->lists.count == words) return 1;
    vxs_gl_words_delete(gl, &gl->lists);
    return vxs_gl_words_make(gl, &gl->lists, words, 1, LISTS_WIDE);
}

vxs_result vxs_gl_put_lists(vxs_gl *gl, const uint32_t *lists)
{
    uint64_t words = VXS_LISTS_HEAD + (uint64_t)lists[0] * lists[1] * ((uint64_t)lists[2] + 1);
    if (!make_lists(gl, words)) return VXS_E_MEMORY;
    vxs_gl_words_write(gl, &gl->lists, lists, 0, (uint32_t)words);
    return VXS_OK;
}

vxs_result vxs_gl_cull(vxs_gl *gl, const vxs_view *view, unsigned depth_texture, uint32_t tile_lights)
{
    static const char *const texts[] = {vxs_gl_text_view_glsl, vxs_gl_text_cull_glsl};
    const gl_api            *api     = &gl->api;
    uint32_t columns = (view->width_px + VXS_TILE_PX - 1) / VXS_TILE_PX, rows = (view->height_px + VXS_TILE_PX - 1) / VXS_TILE_PX;
    if (!vxs_gl_can_compute(gl)) return vxs_gl_fail(gl, VXS_E_GL, "vxs_gl_cull: expected storage buffers and compute shaders");
    if (!make_lists(gl, vxs_lists_words(view->width_px, view->height_px, tile_lights))) return VXS_E_MEMORY;
    if (!gl->culling && !(gl->culling = vxs_gl_compute(gl, "#define VXS_GL_CULL\n", texts, 2))) return VXS_E_GL;
    vxs_gl_bind(gl);
    gl_pass pass = vxs_gl_begin_pass(gl, gl->culling, depth_texture);
    vxs_gl_set_view(gl, gl->culling, view);
    api->Uniform1i(api->GetUniformLocation(gl->culling, "vxs_widest.width_px"), view->filter.width_px);
    api->Uniform1i(api->GetUniformLocation(gl->culling, "vxs_widest.is_smooth"), view->filter.is_smooth);
    api->Uniform2ui(api->GetUniformLocation(gl->culling, "vxs_room"), columns, tile_lights);
    api->DispatchCompute(columns, rows, 1);
    api->MemoryBarrier(GL_BARRIER_SHADER_STORAGE);
    vxs_gl_end_pass(gl, &pass);
    return VXS_OK;
}
