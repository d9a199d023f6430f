/* Bounds of a square from its list of triangles, without a look at texels.
 *
 *     depth ->      . . . e e e e e F          F: every enter depth of the square is at or before it
 *                             xmin . . . .     xmin: every exit depth is at or behind it
 *
 * F comes from what covers the square: one triangle, or a patch whose border does not cross the square and that covers its middle,
 * and therefore all of it. If the border of a patch crosses the square, or the patch covers it in several layers, its triangles are
 * sorted by depth. A group that a gap in depth separates from the others is connected by itself, and is treated as a patch.
 * Triangles that begin behind F are removed from the list. The nearest back face of a solid among them is kept as K: where a list
 * has no further back face for a texel, the exit is at K or behind.
 *
 * With more don't-care voxels (dont_care_rules) the surfaces behind the exit matter too: triangles that may limit the thickness of a
 * sheet stay. All triangles stay until it is known that a surface lies behind F in every texel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_BOUND_H
#define SQUARE_BOUND_H

#include <math.h>

#include "baker/columns/sparse/square_list.h"
#include "formats/vxs_file.h"

/* Don't-care rules of --behind and --thickness: voxels of a column that may be lit or shadowed, in addition to the insides of
 * solids (docs/overview.md, "Solids and sheets").
 *
 *     behind       if no surface lies behind the exit depth, all voxels behind it are don't-care voxels
 *     thickness    a one-sided sheet that faces the light has this thickness, or less if the next surface is nearer */

typedef struct dont_care_rules {
    int    behind;      /* 1: voxels behind the last surface are don't-care voxels */
    double thickness;   /* of sheets, >= 0: in units of depth (directional light) or of the near distance (other lights), along
                           the map's axis */
    int    perspective; /* 1: depths are -near / z (columns.h) */
} dont_care_rules;

/* The rules of a fitted light. */
static inline dont_care_rules dont_care_rules_of(const vxs_light *light, int behind, double thickness_metres)
{
    const int perspective = light->kind != VXS_LIGHT_KIND_DIRECTIONAL;
    return (dont_care_rules){behind,
                             thickness_metres / (perspective ? light->near_metres : ldexp(light->voxel_metres, (int)light->levels)),
                             perspective};
}

/* 1 if the rules depend on the next surface behind the exit depth. */
static inline int dont_care_needs_next(const dont_care_rules *f)
{
    return f->behind || f->thickness > 0;
}

/* A depth plus the thickness. Monotonic in depth, except for rounding. */
static inline double dont_care_through(const dont_care_rules *f, double depth)
{
    return f->perspective ? depth / (1 - f->thickness * depth) : depth + f->thickness;
}

typedef struct square_bound {
    double enter_most; /* F; initially the depth that means no caster */
    double left_out;   /* K; INFINITY: no back face was removed */
    double exit_least; /* xmin */
    int    behind;     /* 1: a surface is known to lie behind F in every texel */
} square_bound;

/* Tighten the bounds of the larger square around it with the square's own list, and remove triangles that no longer matter from
 * the list. */
void square_bound_tighten(square_bound *b, square_list *l, const dont_care_rules *f);

/* Whether the list of a small square settles it without a loss against a look at each texel.
 *
 * A square can be settled if all of its enter depths are at or before all of its exit depths. But the coding chooses a stored depth
 * between the two, and narrow bounds leave it fewer choices. So a small square is evaluated texel by texel, unless its list gives
 * the exact exit depth. The exit of a texel is the first back face up to which there are no more front faces than back faces. It is
 * known without evaluation if layers cover the whole square and do not overlap in depth. */

enum { SETTLE_LIST_MAX = 16 }; /* longer lists rarely give a result */

/* Depths of a square that its list gives. */
typedef struct square_parting {
    double enter_most; /* no enter depth is greater */
    double exit_least; /* no exit depth is less */
    int    is_certain; /* 1: some texel has exactly this exit depth, or smaller squares would not give a better one either */
} square_parting;

/* l      as it was split from the larger square, whose bound is `outer`
 * Returns 0 if the list settles nothing. */
int square_settle(const square_list *l, const sparse_triangles *s, texel_square at, const square_bound *outer, int nearest_back,
                  square_parting *out);

#endif
