/* What is probably wrong with a scene's size or region; see scene_warnings.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/scene_warnings.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/text.h"
#include "baker/base/vec3.h"

/* scale ----------------------------------------------------------------------------------------------------------------------- */

/* The surface of the Earth bends away over a farther distance; no terrain is half as high; no building is as small. */
static const double ACROSS_MAX_M = 200e3, HEIGHT_MAX_M = 20e3, ACROSS_MIN_M = 0.01;

/* A place this large has many things in it that are not: the smallest tenth of a city's parts is 3 m and less, of a terrain in tiles
 * there are few parts. In centimetres nearly all is larger. */
static const double PLACE_MIN_M = 5e3, PART_LARGE_M = 50;
enum { PARTS_MIN = 16, PARTS_SMALL_SHARE = 10 };

static size_t all_components(const casters *c)
{
    size_t count = 0;
    for (int kind = 0; kind < COMPONENT_KINDS; kind++) count += c->component_count[kind];
    return count;
}

/* Nine in ten components are larger than anything in a level is; no where there are few, or no memory to find out. */
static int parts_are_large(const casters *c)
{
    size_t count = all_components(c), small = 0;
    box   *boxes = count < PARTS_MIN ? NULL : malloc(count * sizeof *boxes);
    if (!boxes) return 0;
    for (size_t i = 0; i < count; i++) boxes[i] = box_empty();
    for (size_t n = 0; n < 3 * c->triangle_count; n++)
        box_add(&boxes[c->component_of[n / 3]], c->positions_ws + 3 * (size_t)c->indices[n]);
    for (size_t i = 0; i < count; i++) small += box_diagonal(&boxes[i]) < PART_LARGE_M;
    free(boxes);
    return small * PARTS_SMALL_SHARE <= count;
}

void warn_about_scale(const casters *c, message *m)
{
    box    all    = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double across = box_diagonal(&all), height = all.max[1] - all.min[1];
    int    large = across > ACROSS_MAX_M || height > HEIGHT_MAX_M || (across > PLACE_MIN_M && parts_are_large(c));
    if (!large && !(across < ACROSS_MIN_M)) return;
    warn(m, "the scene is %.15g x %.15g x %.15g m, %s: glTF is in metres; export it so, or scale its root nodes%s",
         rounded(all.max[0] - all.min[0], 3), rounded(height, 3), rounded(all.max[2] - all.min[2], 3),
         large ? "as one in centimetres is" : "too small for anything to be in it", large ? " by 0.01" : "");
}

/* region ---------------------------------------------------------------------------------------------------------------------- */

enum { CORNERS_MAX = 9 }; /* of a triangle that six planes cut */

/* Keep the part of a convex polygon where sign * (coordinate - limit) >= 0. Returns how many corners it has. */
static int cut(double corners[CORNERS_MAX][3], int count, int axis, double limit, double sign)
{
    double kept[CORNERS_MAX][3], along[3];
    int    kept_count = 0;
    for (int n = 0; n < count; n++) {
        const double *a = corners[n], *b = corners[(n + 1) % count];
        double        a_in = sign * (a[axis] - limit), b_in = sign * (b[axis] - limit);
        if (a_in >= 0) memcpy(kept[kept_count++], a, sizeof kept[0]);
        if ((a_in >= 0) == (b_in >= 0)) continue;
        vec3_sub(b, a, along);
        vec3_mad(a, a_in / (a_in - b_in), along, kept[kept_count]);
        kept[kept_count++][axis] = limit;
    }
    memcpy(corners, kept, (size_t)kept_count * sizeof kept[0]);
    return kept_count;
}

static int triangle_touches(const casters *c, size_t triangle, const double region_ws[6])
{
    double corners[CORNERS_MAX][3];
    int    count = 3;
    for (int n = 0; n < 3; n++) memcpy(corners[n], c->positions_ws + 3 * (size_t)c->indices[3 * triangle + n], sizeof corners[n]);
    for (int axis = 0; axis < 3 && count; axis++) {
        count = cut(corners, count, axis, region_ws[axis], 1);
        if (count) count = cut(corners, count, axis, region_ws[axis + 3], -1);
    }
    return count != 0;
}

void warn_about_region(const casters *c, const double region_ws[6], message *m)
{
    for (size_t n = 0; n < c->triangle_count; n++)
        if (triangle_touches(c, n, region_ws)) return;
    box all = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    warn(
        m,
        "--region touches no caster: they lie from (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m; give a box that meets them, or none",
        all.min[0], all.min[1], all.min[2], all.max[0], all.max[1], all.max[2]);
}
