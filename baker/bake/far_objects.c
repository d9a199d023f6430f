/* Objects far from the rest; see far_objects.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/far_objects.h"

#include <string.h>

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

static double reach_of(const box *b, const double from[3])
{
    double reach = 0;
    for (int axis = 0; axis < 3; axis++) reach = fmax(reach, fmax(b->max[axis] - from[axis], from[axis] - b->min[axis]));
    return reach;
}

/* The objects that extend farthest, in this order; ties in the scene's order.   Returns their number. */
static size_t farthest(uint32_t out[FAR_OBJECTS_MAX], const object_list *l, const double from[3])
{
    double reaches[FAR_OBJECTS_MAX];
    size_t found = 0;
    for (size_t n = 0; n < l->count; n++) {
        double reach = reach_of(&l->items[n].around, from);
        size_t place = found;
        while (place && reach > reaches[place - 1]) place--;
        if (place == FAR_OBJECTS_MAX) continue;
        if (found < FAR_OBJECTS_MAX) found++;
        memmove(&out[place + 1], &out[place], (found - place - 1) * sizeof *out);
        memmove(&reaches[place + 1], &reaches[place], (found - place - 1) * sizeof *reaches);
        out[place]     = (uint32_t)n;
        reaches[place] = reach;
    }
    return found;
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
    found = farthest(out->items, l, middle);

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
