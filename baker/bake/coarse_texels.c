/* Texels that are coarser than they should be; see coarse_texels.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/coarse_texels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/portable_math.h"
#include "baker/base/spread.h"
#include "baker/base/text.h"
#include "baker/base/vec3.h"

static const double TIMES_MIN = 10;
enum { TRIANGLES_SHARE = 4, BINS = 1024 };

static void add_box(box *sum, const box *b)
{
    box_add(sum, b->min);
    box_add(sum, b->max);
}

static double size_of(const box *b)
{
    double size = 0;
    for (int axis = 0; axis < 3; axis++) size = fmax(size, b->max[axis] - b->min[axis]);
    return size;
}

/* Median of the objects' centres along an axis, weighted by triangles, to 1/1024 of the scene's size: enough to tell far
 * from near. */
static double median(const object_list *l, const box *all, size_t triangles, int axis)
{
    size_t bins[BINS] = {0}, before = 0;
    double low = all->min[axis], size = all->max[axis] - low;
    if (!(size > 0)) return low;
    for (const scene_object *o = l->items; o < l->items + l->count; o++) {
        int bin = (int)(BINS * ((o->around.min[axis] - low) / size + (o->around.max[axis] - low) / size) / 2);
        bins[bin < BINS ? bin : BINS - 1] += o->triangles;
    }
    for (int bin = 0; bin < BINS; bin++)
        if (2 * (before += bins[bin]) >= triangles) return low + (bin + 0.5) * (size / BINS);
    return low;
}

int far_objects_find(far_objects *out, const object_list *l)
{
    box    all       = box_empty(), rests[FAR_OBJECTS_MAX + 1];
    size_t triangles = 0, found;
    double middle[3];
    *out = (far_objects){0};
    for (const scene_object *o = l->items; o < l->items + l->count; o++) {
        add_box(&all, &o->around);
        triangles += o->triangles;
    }
    for (int axis = 0; axis < 3; axis++) middle[axis] = median(l, &all, triangles, axis);

    /* the objects that extend farthest, in this order; ties in the scene's order */
    double reaches[FAR_OBJECTS_MAX];
    found = 0;
    for (size_t n = 0; n < l->count; n++) {
        const box *b     = &l->items[n].around;
        double     reach = 0;
        size_t     place = found;
        for (int axis = 0; axis < 3; axis++) reach = fmax(reach, fmax(b->max[axis] - middle[axis], middle[axis] - b->min[axis]));
        while (place && reach > reaches[place - 1]) place--;
        if (place == FAR_OBJECTS_MAX) continue;
        if (found < FAR_OBJECTS_MAX) found++;
        memmove(&out->items[place + 1], &out->items[place], (found - place - 1) * sizeof *out->items);
        memmove(&reaches[place + 1], &reaches[place], (found - place - 1) * sizeof *reaches);
        out->items[place] = (uint32_t)n;
        reaches[place]    = reach;
    }

    /* bounding box without the first n of them */
    rests[found] = box_empty();
    for (size_t n = 0; n < l->count; n++) {
        int is_far = 0;
        for (size_t k = 0; k < found; k++) is_far |= out->items[k] == n;
        if (!is_far) add_box(&rests[found], &l->items[n].around);
    }
    for (size_t n = found; n-- > 0;) {
        rests[n] = rests[n + 1];
        add_box(&rests[n], &l->items[out->items[n]].around);
    }
    for (size_t n = 0; n < found && n + 1 < l->count; n++) {
        out->triangles += l->items[out->items[n]].triangles;
        if (out->triangles > triangles / TRIANGLES_SHARE) break;
        if (size_of(&all) < TIMES_MIN * size_of(&rests[n + 1])) continue;
        out->count = n + 1;
        out->rest  = rests[n + 1];
        break;
    }
    return out->count != 0;
}

enum { COMPONENTS_MIN = 4, LOST_PX = 2, LOST_NODE_PX = 4 };

static int is_preview(const plan_light *l)
{
    return 1u << l->light.levels < PREVIEW_PX;
}

/* far objects ----------------------------------------------------------------------------------------------------------------- */

/* Whether a component counts: cards of a few triangles, such as leaves, cast their shadows together. */
static int counts_alone(const casters *c, const scene_object *component, uint32_t number)
{
    return component->triangles > 4 || c->kind_of[number] == COMPONENT_SOLID;
}

/* Median width of the components in a box; 0: none. */
static double median_width(const check_scene *k, const box *within)
{
    const object_list *l     = &k->components;
    double            *width = malloc((l->count + 1) * sizeof *width), median = 0;
    size_t             count = 0;
    for (size_t n = 0; n < l->count && width; n++) {
        const box *b      = &l->items[n].around;
        int        inside = counts_alone(k->c, &l->items[n], (uint32_t)n);
        for (int axis = 0; axis < 3; axis++) inside &= b->min[axis] >= within->min[axis] && b->max[axis] <= within->max[axis];
        if (inside) width[count++] = box_width(b);
    }
    if (count) {
        qsort(width, count, sizeof *width, doubles_ascending);
        median = width[count / 2];
    }
    free(width);
    return median;
}

/* Texels, or voxels, of a sun's map across a box. */
static double span_of(const vxs_light *light, const box *b, int first_row, int last_row)
{
    double span = 0;
    for (int row = first_row; row <= last_row; row++) {
        double along = 0;
        for (int axis = 0; axis < 3; axis++) along += fabs(light->ls_from_ws[4 * row + axis]) * (b->max[axis] - b->min[axis]);
        span = fmax(span, along);
    }
    return span;
}

/* The box, slightly enlarged, with few digits: "-12.5,0,-3,12.5,4,3". */
static const char *region_text(char text[160], const box *b)
{
    double size = 0;
    size_t used = 0;
    for (int axis = 0; axis < 3; axis++) size = fmax(size, b->max[axis] - b->min[axis]);
    int power = -6; /* of ten: the first digit of the size, or of 1e-6 */
    while (power < 308 && portable_pow(10, power + 1) <= size) power++;
    double step = portable_pow(10, power - 1);
    for (int n = 0; n < 6; n++) {
        double at = n < 3 ? floor(b->min[n] / step) * step : ceil(b->max[n - 3] / step) * step;
        used += (size_t)snprintf(text + used, 160 - used, "%s%.15g", n ? "," : "", rounded(at, 9) + 0);
    }
    return text;
}

int warn_about_far_objects(const check_scene *k, const far_objects *far, const object_list *of)
{
    const plan_light *worst = NULL;
    double            most = 0, texels = 0, median = median_width(k, &far->rest);
    int               deep = 0;
    for (const plan_light *l = k->plan->lights; l < k->plan->lights + k->plan->light_count; l++) {
        if (l->left_out || !is_sun(l) || is_preview(l)) continue;
        double side   = ldexp(1, (int)l->light.levels);
        double across = span_of(&l->light, &far->rest, 0, 1), along = span_of(&l->light, &far->rest, 2, 2);
        double times  = side / fmax(across, 1e-9),
               layers = l->light.voxel_metres > 1.5 * l->light.texel_metres ? side / fmax(along, 1e-9) : 0;
        if (fmax(times, layers) <= most) continue;
        worst  = l;
        most   = fmax(times, layers);
        deep   = layers > times;
        texels = deep ? along : across;
    }
    if (!worst || most < 8) return 0;
    double size = deep ? worst->light.voxel_metres : worst->light.texel_metres;
    if (texels > 64 && median > 32 * size) return 0; /* coarser than necessary, but still fine */
    char names[LIST_BYTES], remedies[LIST_BYTES], region[160];

    /* names of the objects, "node 'sea', node 'sky'", and the options that exclude them */
    names[0] = remedies[0] = 0;
    for (size_t n = 0; n < far->count; n++) {
        object_name name;
        size_t      used = strlen(remedies);
        object_name_find(&name, &of->items[far->items[n]], k->c, k->s);
        list_item(names, name.text);
        if (name.option[0] && used + strlen(name.option) + 2 < LIST_BYTES)
            snprintf(remedies + used, LIST_BYTES - used, "%s%s", used ? " " : "", name.option);
    }

    warn(k->m,
         "%zu of %zu triangles, %s, make %s of light '%s' %.15g times as %s, %.3g m: all else is %.15g of them %s; "
         "--region %s, or %s",
         far->triangles, casters_whole_count(k->c), names, deep ? "depths" : "texels", worst->name, rounded(most, 2),
         deep ? "deep" : "large", size, ceil(texels), deep ? "deep" : "wide", region_text(region, &far->rest),
         remedies[0] ? remedies : "leave them out");
    return 1;
}

/* texels wider than components ------------------------------------------------------------------------------------------------ */

/* A component as seen from a light. */
typedef struct seen_component {
    double metres; /* from the light; sun: 0 */
    double width_px;
} seen_component;

static int nearer(const void *a, const void *b)
{
    const seen_component *p = a, *q = b;
    if (p->metres != q->metres) return p->metres < q->metres ? -1 : 1;
    return p->width_px < q->width_px ? -1 : p->width_px > q->width_px;
}

/* Distance from a punctual light to a point along the axis of the map that sees it. */
static double along_axis(const plan_light *l, const double at_ws[3])
{
    double from[3], along = 0;
    vec3_sub(at_ws, l->shape.position_ws, from);
    if (l->map_count == 1) return vec3_dot(from, l->light.direction_ws);
    for (int axis = 0; axis < 3; axis++) along = fmax(along, fabs(from[axis]));
    return along;
}

static size_t see_objects(seen_component *out, const check_scene *k, const object_list *list, const plan_light *l, int alone)
{
    const double cosine = portable_cos(l->shape.outer_rad);
    size_t       count  = 0;
    for (size_t n = 0; n < list->count; n++) {
        const box *b = &list->items[n].around;
        double     middle[3];
        if (alone && !counts_alone(k->c, &list->items[n], (uint32_t)n)) continue;
        for (int axis = 0; axis < 3; axis++) middle[axis] = 0.5 * (b->min[axis] + b->max[axis]);
        double metres = is_sun(l) ? 0 : along_axis(l, middle), texel = is_sun(l) ? 1 : metres;
        if (!is_sun(l) && (!(metres > 0) || !light_reaches_by(&l->shape, cosine, middle))) continue;
        out[count++] = (seen_component){metres, box_width(b) / (texel * l->light.texel_metres)};
    }
    return count;
}

static size_t count_lost(const seen_component *seen, size_t count, double width_px)
{
    size_t lost = 0;
    for (size_t n = 0; n < count; n++) lost += seen[n].width_px < width_px;
    return lost;
}

int texels_lose_most(const check_scene *k, const plan_light *l, size_t *lost, size_t *of)
{
    size_t          most = k->components.count > k->nodes.count ? k->components.count : k->nodes.count;
    seen_component *seen = malloc((most + 1) * sizeof *seen);
    int             is   = 0;
    if (!seen || is_preview(l)) goto done;
    *of   = see_objects(seen, k, &k->components, l, 1);
    *lost = count_lost(seen, *of, LOST_PX);
    if (*of < COMPONENTS_MIN || 2 * *lost <= *of) goto done;
    qsort(seen, *of, sizeof *seen, nearer);
    size_t near  = is_sun(l) ? *of : *of / 4 > COMPONENTS_MIN ? *of / 4 : COMPONENTS_MIN;
    is           = 2 * count_lost(seen, near, LOST_PX) > near;
    size_t nodes = see_objects(seen, k, &k->nodes, l, 0);
    if (nodes >= COMPONENTS_MIN) is &= 2 * count_lost(seen, nodes, LOST_NODE_PX) > nodes;
done:
    free(seen);
    return is;
}

static const box EVERYWHERE = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};

uint32_t coarser_side(const check_scene *k, const plan_light *l)
{
    enum { FINE_SIDE_PX = 16384, FINE_WIDTH_PX = 4096 };
    const double fine_metres = 0.5e-3;
    double       texel       = l->texels.median;
    uint32_t     side        = 1u << l->light.levels;
    if (side < FINE_SIDE_PX || texel >= fine_metres) return 0;
    double width = median_width(k, &EVERYWHERE);
    if (width < FINE_WIDTH_PX * texel) return 0;
    while (side > 4096 && texel < fine_metres && width > 2 * FINE_WIDTH_PX * texel) {
        side /= 2;
        texel *= 2;
    }
    return side == 1u << l->light.levels ? side / 2 : side;
}

void warn_about_lost(const check_scene *k, const plan_light *l, size_t lost, size_t of)
{
    /* the resolution at which a texel is a quarter of the components' median width, if one is that fine */
    char   finer[32 + VXS_LIGHT_NAME_BYTES] = "";
    double width = median_width(k, &EVERYWHERE), now = ldexp(1, (int)l->light.levels), side = now;
    while (side <= RESOLUTION_MAX_PX && l->texels.median * now / side > width / 4) side *= 2;
    if (side <= RESOLUTION_MAX_PX && k->plan->light_count > 1)
        snprintf(finer, sizeof finer, "--resolution %s=%.0f, or ", l->name, side);
    else if (side <= RESOLUTION_MAX_PX)
        snprintf(finer, sizeof finer, "--resolution %.0f, or ", side);
    if (is_sun(l))
        warn(k->m,
             "light '%s': a texel is %.3g m, and %zu of %zu components are narrower than two texels: their shadows are lost; "
             "%s--region around what matters",
             l->name, l->texels.median, lost, of, finer);
    else
        warn(k->m,
             "light '%s' is %.15g m from what it lights, where a texel is %.3g m, and %zu of %zu components are narrower than "
             "two texels: their shadows are lost; %smake it a sun, or a spot that lights these alone",
             l->name, rounded(l->texels.median / l->light.texel_metres, 3), l->texels.median, lost, of, finer);
}
