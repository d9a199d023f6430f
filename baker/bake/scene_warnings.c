/* Warnings about a scene's size or region; see scene_warnings.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/scene_warnings.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "baker/base/box.h"
#include "baker/base/text.h"
#include "baker/base/vec3.h"

/* A node's triangles: its parts are contiguous. */
typedef struct named_node {
    const char *name;
    uint32_t    node;
    size_t      first, end; /* triangles of the scene */
} named_node;

static const char *name_of(const scene *s, size_t part)
{
    return s->names + s->parts[part].node_name;
}

/* List the nodes with a name, in the scene's order. Returns their number; 0 without memory. */
static size_t list_nodes(named_node **out, const scene *s)
{
    size_t count = 0;
    *out         = malloc((s->part_count + 1) * sizeof **out);
    for (size_t n = 0; n < s->part_count && *out; n++) {
        size_t end = n + 1 < s->part_count ? s->parts[n + 1].triangle_first : s->triangle_count;
        if (!*name_of(s, n)) continue;
        if (count && (*out)[count - 1].node == s->parts[n].node && (*out)[count - 1].end == s->parts[n].triangle_first)
            (*out)[count - 1].end = end;
        else
            (*out)[count++] = (named_node){name_of(s, n), s->parts[n].node, s->parts[n].triangle_first, end};
    }
    return count;
}

/* collisions ------------------------------------------------------------------------------------------------------------------ */

/* The pattern of collision nodes that a name matches, by the rules of Unreal Engine (UCX_ ...) and Godot (-colonly ...); NULL:
 * none. */
static const char *collision_pattern(const char *name)
{
    static const char *const prefixes[]        = {"UCX_", "UBX_", "USP_", "UCP_"};
    static const char *const ends[]            = {"-colonly", "-convcolonly", "-navmesh", "-occonly", "-noimp"};
    static const char *const words[]           = {"collider", "colliders", "collision", "collisions", "hitbox", "navmesh"};
    static const char *const prefix_patterns[] = {"node:UCX_*", "node:UBX_*", "node:USP_*", "node:UCP_*"};
    static const char *const end_patterns[]    = {"node:*-colonly", "node:*-convcolonly", "node:*-navmesh", "node:*-occonly",
                                                  "node:*-noimp"};
    for (size_t n = 0; n < sizeof prefixes / sizeof *prefixes; n++)
        if (!strncmp(name, prefixes[n], strlen(prefixes[n]))) return prefix_patterns[n];
    for (size_t n = 0; n < sizeof ends / sizeof *ends; n++) {
        size_t length = strlen(name), end_length = strlen(ends[n]);
        if (length > end_length && !strcmp(name + length - end_length, ends[n])) return end_patterns[n];
    }
    for (size_t n = 0; n < sizeof words / sizeof *words; n++) {
        size_t length = strlen(words[n]);
        for (const char *at = name; *at; at++) {
            if (at > name && isalnum((unsigned char)at[-1])) continue;
            if (!strncasecmp(at, words[n], length) && !isalnum((unsigned char)at[length])) return "";
        }
    }
    return NULL;
}

static void warn_about_collisions(const named_node *nodes, size_t count, run_context *m)
{
    const named_node *first   = NULL;
    const char       *pattern = NULL;
    size_t            found = 0, triangles = 0;
    char              option[160];
    for (const named_node *n = nodes; n < nodes + count; n++) {
        const char *p = collision_pattern(n->name);
        if (!p) continue;
        if (!found++) {
            first   = n;
            pattern = p;
        }
        triangles += n->end - n->first;
    }
    if (!found) return;
    if (*pattern)
        snprintf(option, sizeof option, "'%s'", pattern);
    else
        snprintf(option, sizeof option, "'node:%.100s'", first->name);
    if (found > 1)
        warn(m,
             "node '%s' and %zu more are named like shapes for collisions, which are not seen, and cast shadows of %zu triangles; "
             "leave them out with --exclude %s",
             first->name, found - 1, triangles, option);
    else
        warn(m,
             "node '%s' is named like a shape for collisions, which is not seen, and casts shadows of %zu triangles; leave it out "
             "with --exclude %s",
             first->name, triangles, option);
}

/* levels of detail ------------------------------------------------------------------------------------------------------------ */

/* Position of the number in "Tree_LOD1"; NULL: none. */
static const char *detail_number(const char *name)
{
    for (const char *at = name; *at; at++)
        if (at > name && strchr("_-. ", at[-1]) && !strncasecmp(at, "lod", 3)) {
            const char *digit = at + 3 + (strchr("_-. ", at[3]) && at[3]);
            if (isdigit((unsigned char)*digit) && !isdigit((unsigned char)digit[1])) return digit;
        }
    return NULL;
}

/* Sort by the name before the number, then by the number. */
static int by_thing(const void *a, const void *b)
{
    const named_node *p = a, *q = b;
    size_t            p_length = (size_t)(detail_number(p->name) - p->name), q_length = (size_t)(detail_number(q->name) - q->name);
    int               differ = strncmp(p->name, q->name, p_length < q_length ? p_length : q_length);
    if (differ) return differ;
    if (p_length != q_length) return p_length < q_length ? -1 : 1;
    differ = strcmp(p->name + p_length, q->name + q_length);
    return differ ? differ : p->first < q->first ? -1 : p->first > q->first;
}

/* Whether the centre of one is in the box of the other. */
static int same_place(const scene *s, const named_node *a, const named_node *b)
{
    box one   = box_of_corners(s->positions_ws, s->indices + 3 * a->first, 3 * (a->end - a->first));
    box other = box_of_corners(s->positions_ws, s->indices + 3 * b->first, 3 * (b->end - b->first));
    for (int axis = 0; axis < 3; axis++) {
        double middle = 0.5 * (other.min[axis] + other.max[axis]);
        if (middle < one.min[axis] || middle > one.max[axis]) return 0;
    }
    return 1;
}

static void warn_about_details(const scene *s, named_node *nodes, size_t count, run_context *m)
{
    const named_node *first = NULL, *other = NULL;
    size_t            levels = 0, found = 0;
    for (size_t n = 0; n < count; n++)
        if (detail_number(nodes[n].name)) nodes[levels++] = nodes[n];
    if (levels > 1) qsort(nodes, levels, sizeof *nodes, by_thing);
    for (size_t n = 0, of = 0; n + 1 < levels; n++) {
        const char *name = nodes[n].name, *next = nodes[n + 1].name;
        size_t      length = (size_t)(detail_number(name) - name);
        if ((size_t)(detail_number(next) - next) != length || strncmp(name, next, length) != 0) {
            of = n + 1;
            continue;
        }
        if (*detail_number(nodes[of].name) == *detail_number(nodes[n + 1].name) || !same_place(s, &nodes[of], &nodes[n + 1]))
            continue;
        if (!found++) {
            first = &nodes[of];
            other = &nodes[n + 1];
        }
    }
    if (!found) return;
    const char *digit = detail_number(other->name), *word = digit;
    while (word[-1] && !isalpha((unsigned char)word[-1])) word--;
    word -= strlen("lod") + 1;
    warn(m,
         "node '%s' is a coarser '%s' in the same place%s: only one level of detail is seen, and all cast shadows; leave the "
         "others out with --exclude 'node:*%.*s[1-9]*'",
         other->name, first->name, found > 1 ? ", and there are more" : "", (int)(digit - word), word);
}

void warn_about_names(const scene *s, run_context *m)
{
    named_node *nodes;
    size_t      count = list_nodes(&nodes, s);
    if (count) {
        warn_about_collisions(nodes, count, m);
        warn_about_details(s, nodes, count, m);
    }
    free(nodes);
}

/* scale ----------------------------------------------------------------------------------------------------------------------- */

/* Beyond the first distance the Earth is not flat; no terrain is half as high as the second; no building is as small as the
 * third. */
static const double ACROSS_MAX_METRES = 200e3, HEIGHT_MAX_METRES = 20e3, ACROSS_MIN_METRES = 0.01;

/* A single object may be this small, but not a furnished room. */
static const double PLACE_ACROSS_MIN_METRES = 0.1;

/* A place of this size has many small things. In a city the smallest tenth of the parts is 3 m or less; a tiled terrain has few
 * parts. In centimetres nearly all parts are larger. */
static const double PLACE_MIN_METRES = 5e3, PART_LARGE_METRES = 50;
enum { PARTS_MIN = 16, PARTS_SMALL_SHARE = 10 };

/* Whether nine of ten components are larger than objects of a level are; 0 if there are few. */
static int parts_are_large(const casters *c)
{
    size_t count = casters_component_count(c), small = 0;
    if (count < PARTS_MIN) return 0;
    for (size_t i = 0; i < count; i++) small += box_diagonal(&c->boxes[i]) < PART_LARGE_METRES;
    return small * PARTS_SMALL_SHARE <= count;
}

void warn_about_scale(const casters *c, run_context *m)
{
    box    all    = casters_bounds(c);
    double across = box_diagonal(&all), height = all.max[1] - all.min[1];
    int    large = across > ACROSS_MAX_METRES || height > HEIGHT_MAX_METRES || (across > PLACE_MIN_METRES && parts_are_large(c));
    int    small = across < ACROSS_MIN_METRES || (across < PLACE_ACROSS_MIN_METRES && casters_component_count(c) >= PARTS_MIN);
    if (!large && !small) return;
    warn(m, "the scene is %.15g x %.15g x %.15g m, %s: glTF is in metres; export it so, or scale its root nodes%s",
         rounded(all.max[0] - all.min[0], 3), rounded(height, 3), rounded(all.max[2] - all.min[2], 3),
         large ? "as one in centimetres is" : "too small for anything to be in it", large ? " by 0.01" : "");
}

/* ranges ---------------------------------------------------------------------------------------------------------------------- */

static const double RANGE_OF_WIDTH_MIN = 0.5, CENTIMETRES_ACROSS_MIN_METRES = 100;
enum { RANGE_PARTS_MIN = 4 };

void warn_about_ranges(const casters *c, const light_choice *chosen, run_context *m)
{
    const chosen_light *longest = NULL;
    size_t              count = casters_component_count(c), wider = 0;
    for (const chosen_light *l = chosen->lights; l < chosen->lights + chosen->count; l++) {
        if (l->shape.kind == LIGHT_DIRECTIONAL) continue;
        if (!isfinite(l->shape.range_metres)) return;
        if (!longest || l->shape.range_metres > longest->shape.range_metres) longest = l;
    }
    if (!longest || count < RANGE_PARTS_MIN) return;
    double width = longest->shape.range_metres / RANGE_OF_WIDTH_MIN;
    for (size_t n = 0; n < count; n++) wider += box_width(&c->boxes[n]) > width;
    if (2 * wider <= count) return;
    box all = casters_bounds(c);
    if (box_diagonal(&all) < CENTIMETRES_ACROSS_MIN_METRES) return;
    warn(m,
         "light '%s' reaches %.3g m, no punctual light farther, and %zu of %zu components are wider than %.3g m, in a scene of "
         "%.15g m: as of one in centimetres with lights in metres; scale its root nodes by 0.01, or give lights longer ranges",
         longest->name, longest->shape.range_metres, wider, count, width, rounded(box_diagonal(&all), 3));
}

/* flat scenes ----------------------------------------------------------------------------------------------------------------- */

void warn_about_flat(const casters *c, run_context *m)
{
    const double  rounding = 1e-6;
    const double *corners[3];
    double        ab[3], ac[3], normal[3], from[3];
    for (int n = 0; n < 3; n++) corners[n] = c->positions_ws + 3 * (size_t)c->indices[n];
    vec3_sub(corners[1], corners[0], ab);
    vec3_sub(corners[2], corners[0], ac);
    vec3_cross(ab, ac, normal);
    double length = sqrt(vec3_dot(normal, normal));
    for (size_t n = 0; n < c->vertex_count; n++) {
        vec3_sub(c->positions_ws + 3 * n, corners[0], from);
        if (fabs(vec3_dot(from, normal)) > rounding * length * sqrt(vec3_dot(from, from))) return;
    }
    warn(m, "all that casts shadows lies in one plane, and shades nothing: %zu triangles; bake it with what stands on it",
         casters_whole_count(c));
}

/* region ---------------------------------------------------------------------------------------------------------------------- */

enum { CORNERS_MAX = 9 }; /* most corners of a triangle clipped by six planes */

/* Clip a convex polygon to sign * (coordinate - limit) >= 0. Returns the number of corners. */
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

void warn_about_region(const casters *c, const double region_ws[6], run_context *m)
{
    for (size_t n = 0; n < c->triangle_count; n++) {
        double corners[CORNERS_MAX][3];
        int    count = 3;
        for (int k = 0; k < 3; k++) memcpy(corners[k], c->positions_ws + 3 * (size_t)c->indices[3 * n + k], sizeof corners[k]);
        for (int axis = 0; axis < 3 && count; axis++) {
            count = cut(corners, count, axis, region_ws[axis], 1);
            if (count) count = cut(corners, count, axis, region_ws[axis + 3], -1);
        }
        if (count != 0) return;
    }
    box all = casters_bounds(c);
    warn(
        m,
        "--region touches no caster: they lie from (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g) m; give a box that meets them, or none",
        all.min[0], all.min[1], all.min[2], all.max[0], all.max[1], all.max[2]);
}
