/* Places in lights, and the results in C in each of the ways that it can be queried, which have to agree bit for bit. Included
 * behind cmocka.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASKED_PLACES_H
#define ASKED_PLACES_H

#include "blocks_scalar.h"
#include "formats/vxs_space.h"
#include "lookup_many_scalar.h"
#include "random_light.h"

enum { PLACES = 256 };

/* Points that are looked up in one light with one filter: near one another, as pixels are, so that a batch keeps what it found; or
 * scattered. */
typedef struct asked_places {
    const vxs_baked_light *light;
    vxs_filter             filter;
    double                 points[PLACES][3], normals[PLACES][3];
    vxs_place              places[PLACES]; /* of a map, also where the light does not reach: then some texels beside it */
    float                  lit[PLACES];    /* about that place */
} asked_places;

/* The first voxel of a texel that is in shadow; side: none is. */
static inline int32_t first_dark(const vxs_baked_light *l, int32_t map, int32_t i, int32_t j)
{
    int32_t side = 1 << l->light.levels, low = 0, high = side;
    i = vxs_clamp(i, 0, side - 1);
    j = vxs_clamp(j, 0, side - 1);
    while (low < high) {
        int32_t k = (low + high) / 2;
        if (vxs_shadow_taps(l->words, &l->light, map, i, j, (uint32_t)k, 1))
            high = k;
        else
            low = k + 1;
    }
    return low;
}

/* A point of a map, some texels beside it at most; every other is within a voxel of where its texel goes dark. */
static inline void ask_place(asked_places *a, rng *r, int n, int32_t map, const int32_t middle[2], int32_t reach)
{
    const vxs_light *light = &a->light->light;
    double           side = ldexp(1, (int)light->levels), at[3] = {0, 0, uniform(r, -1, side + 1)};
    for (int axis = 0; axis < 2; axis++) at[axis] = fmin(fmax(middle[axis] + uniform(r, -reach, reach), -12), side + 12);
    if (n % 2) at[2] = first_dark(a->light, map, (int32_t)floor(at[0]), (int32_t)floor(at[1])) + uniform(r, -1, 2);
    vxs_point(light, map, at, a->points[n]);
    memset(a->normals[n], 0, sizeof a->normals[n]);
    if (!rng_below(r, 4)) random_direction(r, a->normals[n]);
    a->places[n] = vxs_place_from_ws(light, a->points[n], a->normals[n], a->filter);
}

/* Dark texels, or parts of them, by vectors and word by word. */
static inline void check_counts(const asked_places *a, vxs_place place)
{
    const vxs_light *light = &a->light->light;
    const uint32_t  *words = a->light->words, map = (uint32_t)place.map;
    int32_t          last = (1 << light->levels) - 1, i = place.voxel[0], j = place.voxel[1], width = a->filter.width_px;
    uint32_t         k      = (uint32_t)vxs_clamp(place.voxel[2], 0, last);
    int              inside = i >= 0 && j >= 0 && i <= last && j <= last;
    if (light->coding != VXS_CODING_BLOCKS) return; /* a DAG has one way */
    if (a->filter.is_smooth)
        assert_int_equal(vxs_shadow_part(words, light, place, k, width),
                         scalar_shadow_weight(words, map, light->levels, i, j, place.across, place.down, k, width));
    else
        assert_int_equal(vxs_shadow_taps(words, light, place.map, i, j, k, width),
                         width > 1 ? scalar_shadow_count(words, map, light->levels, i, j, k, width)
                         : inside  ? scalar_shadow(words, map, light->levels, (uint32_t)i, (uint32_t)j, k)
                                   : 0);
}

static inline void check_same_bits(const asked_places *a, int n, const char *way, float found, float wanted)
{
    const double *p = a->points[n];
    if (memcmp(&found, &wanted, sizeof found))
        fail_msg("%s, filter %d, smooth %d at %.17g %.17g %.17g: %.9g, expected %.9g", way, a->filter.width_px, a->filter.is_smooth,
                 p[0], p[1], p[2], (double)found, (double)wanted);
}

/* Points alone, and many at once. */
static inline void check_lookups(const asked_places *a)
{
    static float by_vectors[PLACES], by_words[PLACES];
    vxs_batch    b = {.points_ws.data = a->points, .normals_ws.data = a->normals, .count = PLACES, .filter = a->filter};
    b.lit          = by_vectors;
    assert_int_equal(vxs_lookup_batch(a->light, 1, &b), VXS_OK);
    b.lit = by_words;
    assert_int_equal(scalar_lookup_batch(a->light, 1, &b), VXS_OK);
    for (int n = 0; n < PLACES; n++) {
        int   outside = vxs_place_from_ws(&a->light->light, a->points[n], a->normals[n], a->filter).map < 0;
        float alone   = vxs_lookup(a->light, a->points[n], a->normals[n], a->filter);
        check_same_bits(a, n, "a lookup", alone, outside ? VXS_OUTSIDE : a->lit[n]);
        check_same_bits(a, n, "a batch", by_vectors[n], alone);
        check_same_bits(a, n, "a batch without vectors", by_words[n], alone);
    }
}

/* Query C in all ways.
 * light  whose words are some; of any kind and coding
 * a      [out] what others are to be queried, and the answer */
static inline void ask_places(asked_places *a, rng *r, const vxs_baked_light *light)
{
    int32_t  side = 1 << light->light.levels, map = (int32_t)rng_below(r, vxs_map_count(&light->light));
    int32_t  middle[2] = {(int32_t)rng_below(r, (uint32_t)side), (int32_t)rng_below(r, (uint32_t)side)};
    int32_t  reach     = rng_below(r, 2) ? 24 : side;
    uint32_t smooth    = rng_below(r, 2);
    a->light           = light;
    a->filter = smooth ? vxs_smooth(rng_between(r, 1, VXS_FILTER_MAX)) : vxs_box(1 + 2 * rng_between(r, 0, VXS_FILTER_MAX / 2));
    for (int n = 0; n < PLACES; n++) {
        ask_place(a, r, n, map, middle, reach);
        if (a->places[n].map < 0) a->places[n].map = map;
        /* a single tap is queried of the map alone */
        for (int axis = 0; axis < 2 && !a->filter.is_smooth && a->filter.width_px == 1; axis++)
            a->places[n].voxel[axis] = vxs_clamp(a->places[n].voxel[axis], 0, side - 1);
        check_counts(a, a->places[n]);
        a->lit[n] = (float)vxs_lit_at_place(light->words, &light->light, a->places[n], a->filter);
    }
    check_lookups(a);
}

#endif
