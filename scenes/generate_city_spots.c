/* Spot lights of the city (after the scene of [CPVS16] 6.4: many spots, each of which lights a small part).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate_parts.h"

#include <math.h>
#include <stdio.h>

static const double distance_to_boxes = 0.1, wall_lamp_height_most = 15;

/* A random value in [low, high], in 1024 steps. */
static double between(rng *r, double low, double high)
{
    return low + (high - low) * rng_between(r, 0, 1024) / 1024;
}

static void add_spot(parts *p, rng *r, const double at[3], const double direction[3], uint32_t *made)
{
    char name[32];
    snprintf(name, sizeof name, "spot%04u", ++*made);
    int degrees = rng_between(r, 20, 60);
    parts_spot(p, name, at, direction, degrees, rng_between(r, 15, 40));
}

/* A downward direction that leans along one axis to either side, and along the other one. */
static void down(rng *r, const double along[3], double lean, const double out[3], double out_least, double out_most, double d[3])
{
    double a = between(r, -lean, lean), o = between(r, out_least, out_most);
    for (int i = 0; i < 3; i++) d[i] = a * along[i] + o * out[i] - (i == 1);
}

/* Whether a point is in a box, or within distance_to_boxes of it. */
static int is_in_box(const float *corners, const double at[3])
{
    for (int axis = 0; axis < 3; axis++) {
        const float *end    = corners + 3 * (1 << axis);
        double       length = 0, reach = 0;
        for (int i = 0; i < 3; i++) {
            double edge = (double)end[i] - corners[i];
            length += edge * edge;
            reach += edge * (at[i] - corners[i]);
        }
        double slack = distance_to_boxes * sqrt(length);
        if (reach < -slack || reach > length + slack) return 0;
    }
    return 1;
}

/* Add a spot in front of a wall of a large enough box, farther out than wall clutter. Returns 0 when the position is inside or
 * near another box, or the box is too small. */
static int add_on_wall(parts *p, rng *r, const city_block *k, uint32_t *made)
{
    const float *corners = p->s->positions + 24 * (k->box_first + rng_below(r, (uint32_t)k->box_count));
    int          axis = rng_below(r, 2) ? 2 : 0, is_high = (int)rng_below(r, 2);
    const float *across = corners + 3 * (1 << axis), *beside = corners + 3 * (1 << (2 - axis)), *above = corners + 3 * 2;
    double       top = above[1] - 1.0, u = between(r, 0.1, 0.9), stand_off = between(r, 1.25, 1.75);
    double       along[3], out[3], at[3], direction[3], width = 0, depth = 0;

    for (int i = 0; i < 3; i++) {
        along[i] = (double)beside[i] - corners[i];
        out[i]   = is_high ? (double)across[i] - corners[i] : (double)corners[i] - across[i];
        width += along[i] * along[i];
        depth += out[i] * out[i];
    }
    width = sqrt(width), depth = sqrt(depth);
    if (width < 4 || depth < 4 || top < 4) return 0;
    for (int i = 0; i < 3; i++) {
        at[i] = (is_high ? across[i] : corners[i]) + u * along[i] + stand_off * (out[i] / depth);
        along[i] /= width;
        out[i] /= depth;
    }
    at[1]              = between(r, 3, top < wall_lamp_height_most ? top : wall_lamp_height_most);
    const glb_scene *s = p->s;
    for (size_t i = 0; i < k->box_count; i++)
        if (is_in_box(s->positions + 24 * (k->box_first + i), at)) return 0;

    down(r, along, 0.5, out, 0.1, 0.8, direction);
    add_spot(p, r, at, direction, made);
    return 1;
}

void add_city_spots(parts *p, const city_block *k, rng r, uint32_t count, uint32_t *made)
{
    uint32_t wanted = count < k->lamp_count ? count : k->lamp_count, rest = count - wanted;
    for (uint32_t i = 0; i < k->lamp_count; i++) {
        double direction[3];
        if (rng_below(&r, k->lamp_count - i) >= wanted) continue;
        down(&r, k->lamps[i].along, 0.75, k->lamps[i].out, 0, 0.25, direction);
        add_spot(p, &r, k->lamps[i].head, direction, made);
        wanted--;
    }

    for (uint32_t i = 0; i < rest; i++) {
        int done = 0;
        for (int tries = 0; i % 2 && k->box_count && !done && tries < 16; tries++) done = add_on_wall(p, &r, k, made);
        if (!done) {
            /* in the middle third of the street beside the block's side, out of reach of the lamps on both sides */
            uint32_t side     = i / 2 % 4;
            double   along[3] = {side & 1 ? 0 : 1, 0, side & 1}, out[3] = {side & 1, 0, side & 1 ? 0 : 1}, at[3], direction[3];
            double   u = between(&r, -k->half, k->half), v = k->half + k->street * between(&r, 1 / 3.0, 2 / 3.0);
            if (side & 2) v = -v;
            at[0] = k->x + u * along[0] + v * out[0];
            at[1] = between(&r, 6, 12);
            at[2] = k->z + u * along[2] + v * out[2];
            down(&r, along, 0.75, out, -0.25, 0.25, direction);
            add_spot(p, &r, at, direction, made);
        }
    }
}
