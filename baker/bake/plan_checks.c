/* Checks for bakes of little use; see plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/bake/coarse_texels.h"
#include "baker/bake/plan.h"
#include "baker/bake/scene_objects.h"
#include "baker/base/parallel_runs.h"
#include "baker/base/portable_math.h"
#include "baker/base/text.h"
#include "baker/base/vec3.h"

enum { POINTS = 256, POINT_TRIANGLES_MAX = 1 << 14, TOLD_EACH = 3 };

/* Lights with the same warning: the first few get a line each, the others are listed in one line. */
typedef struct light_tally {
    size_t count;
    char   more[LIST_BYTES];
} light_tally;

static int is_told(light_tally *t, const char *name)
{
    if (t->count++ < TOLD_EACH) return 1;
    list_item(t->more, name);
    return 0;
}

static void tell_rest(const light_tally *t, const char *what, run_context *m)
{
    if (t->count > TOLD_EACH) warn(m, "%zu more lights %s: %s; the same goes for them", t->count - TOLD_EACH, what, t->more);
}

/* texels ---------------------------------------------------------------------------------------------------------------------- */

static int by_distance(const void *a, const void *b)
{
    const lit_point *p = a, *q = b;
    return p->along_metres < q->along_metres ? -1 : p->along_metres > q->along_metres;
}

/* points  are sorted by distance */
static texel_range texels_of(const plan_light *l, lit_point *points, size_t count)
{
    double slope = l->light.texel_metres, near = l->light.near_metres, all = 0, before = 0;
    double far = near * portable_exp(l->light.voxel_metres * ldexp(1, (int)l->light.levels));
    size_t n   = 0;
    if (is_sun(l)) return (texel_range){slope, slope, slope};
    if (!count) return (texel_range){slope * near, slope * sqrt(near * far), slope * far};
    qsort(points, count, sizeof *points, by_distance);
    for (size_t k = 0; k < count; k++) all += points[k].weight;
    while (n + 1 < count && 2 * (before += points[n].weight) < all) n++;
    return (texel_range){slope * points[0].along_metres, slope * points[n].along_metres, slope * points[count - 1].along_metres};
}

/* objects that hide a light --------------------------------------------------------------------------------------------------- */

static const scene_object *find_hider(check_scene *k, const lit_points_desc *d, const lit_point *points, size_t count,
                                      double *metres)
{
    const scene_object *o = light_hider_find(&k->components, points, count, d, metres);
    if (!o && k->nodes.count && k->nodes.count < k->components.count) o = light_hider_find(&k->nodes, points, count, d, metres);
    return o;
}

static void warn_about_hider(const check_scene *k, const plan_light *l, const scene_object *hider, double metres)
{
    object_name name;
    object_name_find(&name, hider, k->c, k->s);
    const char *own = name.option[0] ? "" : "give that a node of its own, and leave it out with --exclude";
    const char *out = name.option[0] ? "leave that out with " : "";
    if (is_sun(l))
        warn(k->m, "light '%s': all else is in the shadow of %s; if that is a sky or a cover, %s%s%s", l->name, name.text, out,
             name.option, own);
    else
        warn(k->m, "light '%s': all else is in the shadow of %s, %.2g m from it at most; move the light, or %s%s%s", l->name,
             name.text, metres, out, name.option, own);
}

/* What is found for a light on a thread of its own. */
typedef struct light_find {
    const scene_object *hider; /* NULL: none */
    double              metres;
} light_find;

/* far objects ----------------------------------------------------------------------------------------------------------------- */

/* Warn of far objects. Objects that hide lights have a warning already.   found  [lights]
 * Returns 1 if it has warned. */
static int check_far(const check_scene *k, const light_find *found)
{
    far_objects        far;
    const object_list *of   = k->nodes.count > 1 && far_objects_find(&far, &k->nodes) ? &k->nodes : &k->components;
    size_t             hide = 0;
    if (of == &k->components && !far_objects_find(&far, of)) return 0;
    for (size_t n = 0; n < far.count; n++)
        for (size_t l = 0; l < k->plan->light_count; l++)
            if (found[l].hider && found[l].hider->component == of->items[far.items[n]].component) {
                hide++;
                break;
            }
    return hide < far.count && warn_about_far_objects(k, &far, of);
}

/* short ranges ---------------------------------------------------------------------------------------------------------------- */

/* Find the only object within a punctual light's range, if it is small: the light's fixture.   next_metres  [out] distance to the
 * next object */
static const scene_object *find_fixture(const check_scene *k, const plan_light *l, double *next_metres)
{
    const object_list  *list  = k->nodes.count > 1 ? &k->nodes : &k->components;
    const scene_object *found = NULL;
    box                 all   = box_empty();
    *next_metres              = INFINITY;
    for (const scene_object *o = list->items; o < list->items + list->count; o++) {
        double square = 0;
        for (int axis = 0; axis < 3; axis++) {
            double beside =
                fmax(0, fmax(o->around.min[axis] - l->shape.position_ws[axis], l->shape.position_ws[axis] - o->around.max[axis]));
            square += beside * beside;
        }
        double metres = sqrt(square);

        box_add(&all, o->around.min);
        box_add(&all, o->around.max);
        if (metres > l->shape.range_metres) {
            *next_metres = fmin(*next_metres, metres);
        } else {
            if (found) return NULL;
            found = o;
        }
    }
    int is_fixture = found && isfinite(*next_metres) && box_width(&found->around) <= l->shape.range_metres &&
                     box_diagonal(&found->around) < box_diagonal(&all) / 4;
    return is_fixture ? found : NULL;
}

/* coarse positions ------------------------------------------------------------------------------------------------------------ */

/* Difference between a float of this size and the next. */
static double float_step(double size)
{
    return size > 0 ? ldexp(1, ilogb(size) - 23) : 0;
}

static double farthest_corner(const box *b, const double from[3])
{
    double far = 0;
    for (int axis = 0; axis < 3; axis++) far = fmax(far, fmax(fabs(b->min[axis] - from[axis]), fabs(b->max[axis] - from[axis])));
    return far;
}

static const double STEP_MAX_METRES = 1e-3, FAR_TIMES = 16;

/* Warn of coarse positions: they are floats relative to the origin of their node. Names the node with the coarsest steps. */
static void warn_about_steps(const check_scene *k)
{
    const scene      *s     = k->s;
    const scene_part *worst = NULL, *last = NULL;
    box               all   = box_empty();
    size_t            nodes = 0, origin = 0;
    double            worst_far = 0;
    for (size_t n = 0; n < k->components.count; n++) {
        box_add(&all, k->components.items[n].around.min);
        box_add(&all, k->components.items[n].around.max);
    }
    for (size_t n = 0; s && s->origin_count && n < s->part_count; n++) {
        const scene_part *part  = &s->parts[n];
        size_t            first = part->triangle_first, end = n + 1 < s->part_count ? part[1].triangle_first : s->triangle_count;
        while (origin + 1 < s->origin_count && s->origins[origin + 1].triangle_first <= first) origin++;
        const double *from = s->origins[origin].at_ws;
        if (float_step(farthest_corner(&all, from)) <= STEP_MAX_METRES) continue; /* a fast test, enough for most scenes */
        box    own = box_of_corners(s->positions_ws, s->indices + 3 * first, 3 * (end - first));
        double far = farthest_corner(&own, from);
        if (float_step(far) <= STEP_MAX_METRES || far < FAR_TIMES * box_diagonal(&own)) continue;
        nodes += !last || last->node != part->node;
        last = part;
        if (far <= worst_far) continue;
        worst_far = far;
        worst     = part;
    }
    if (!worst) return;
    char more[48] = "";
    if (nodes > 1) snprintf(more, sizeof more, " and %zu more", nodes - 1);
    warn(k->m,
         "node %u '%s'%s: positions are floats %.9g m from the origin of the node, in steps of %.3g m; store them near it, and "
         "place them by the translation of the node",
         worst->node, s->names + worst->node_name, more, rounded(worst_far, 3), float_step(worst_far));
}

/* all checks ------------------------------------------------------------------------------------------------------------------ */

typedef struct light_search {
    check_scene *k;
    light_find  *found; /* [light_count of the plan] */
} light_search;

/* Sample points for a light: its texels, and the object that hides it. */
static vxs_result search_light(void *user, size_t n, uint32_t worker, run_context *m)
{
    const light_search *s = user;
    check_scene        *k = s->k;
    plan_light         *l = &k->plan->lights[n];
    lit_point           points[POINTS];
    lit_points_desc     d = {.c = k->c, .shape = &l->shape, .light = &l->light, .triangles_max = POINT_TRIANGLES_MAX};
    (void)worker;
    (void)m;
    if (l->left_out) return VXS_OK;
    size_t count      = lit_points_choose(points, POINTS, &d);
    l->texels         = texels_of(l, points, count);
    s->found[n].hider = find_hider(k, &d, points, count, &s->found[n].metres);
    return VXS_OK;
}

/* Checks of a light that is not hidden. */
static void check_light(const check_scene *k, const plan_light *l, int far_told, light_tally *short_ones, light_tally *coarse,
                        light_tally *fine)
{
    uint32_t            side;
    size_t              lost, of;
    double              metres;
    const scene_object *o = !is_sun(l) && isfinite(l->shape.range_metres) ? find_fixture(k, l, &metres) : NULL;
    if (o) {
        if (is_told(short_ones, l->name)) {
            double      next_metres = metres;
            object_name name;
            object_name_find(&name, o, k->c, k->s);
            warn(k->m,
                 "light '%s' reaches nothing but %s: its range is %.3g m, and what is next is %.3g m from it; give it a longer "
                 "range",
                 l->name, name.text, l->shape.range_metres, next_metres);
        }
    } else if (!(is_sun(l) && far_told) && texels_lose_most(k, l, &lost, &of)) {
        if (is_told(coarse, l->name)) warn_about_lost(k, l, lost, of);
    } else if ((side = coarser_side(k, l))) {
        if (is_told(fine, l->name)) {
            char name[VXS_LIGHT_NAME_BYTES + 2] = "";
            if (k->plan->light_count > 1) snprintf(name, sizeof name, "%s=", l->name);
            warn(k->m,
                 "light '%s': a texel is %.2g mm, and most components are more than 4096 texels wide, finer than shadows are seen; "
                 "--resolution %s%u takes less time and a smaller file",
                 l->name, 1000 * l->texels.median, name, side);
        }
    }
}

void plan_check_lights(bake_plan *plan, const bake_options *o, const casters *c, const scene *s, run_context *m)
{
    check_scene k     = {.plan = plan, .c = c, .s = s, .m = m};
    light_find *found = calloc(plan->light_count, sizeof *found);
    objects_by_node(&k.nodes, c, s);
    if (objects_by_component(&k.components, c) && found) {
        int         has_region = o->region_given;
        light_tally hidden = {0}, short_ones = {0}, coarse = {0}, fine = {0};
        plan_light *lights = k.plan->lights;
        parallel_runs(o->threads, plan->light_count, search_light, &(light_search){&k, found}, m);
        for (size_t n = 0; n < plan->light_count; n++)
            if (found[n].hider && is_told(&hidden, lights[n].name))
                warn_about_hider(&k, &lights[n], found[n].hider, found[n].metres);
        int far_told = !has_region && check_far(&k, found);
        for (size_t n = 0; n < k.plan->light_count; n++)
            if (!lights[n].left_out && !found[n].hider) check_light(&k, &lights[n], far_told, &short_ones, &coarse, &fine);
        warn_about_steps(&k);
        tell_rest(&hidden, "are hidden from all else in this way", k.m);
        tell_rest(&short_ones, "reach nothing but one object", k.m);
        tell_rest(&coarse, "have texels wider than most components", k.m);
        tell_rest(&fine, "have texels finer than shadows are seen", k.m);
    }
    objects_free(&k.components);
    objects_free(&k.nodes);
    free(found);
}
