/* Procedural smoke, and what it leaves of light; see smoke_scene.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/smoke_scene.h"

#include <math.h>

#include "baker/base/random.h"

const char *const smoke_names[SMOKE_KINDS] = {"smoke columns", "smoke with hair", "leaves"};

static double between(rng *r, double low, double high)
{
    return low + (high - low) * rng_unit(r);
}

static vxs_capsule capsule_of(const double begin[3], const double end[3], double radius, double extinction)
{
    vxs_capsule c = {.radius_metres = (float)radius, .extinction = (float)extinction};
    for (int n = 0; n < 3; n++) {
        c.begin[n] = (float)begin[n];
        c.end[n]   = (float)end[n];
    }
    return c;
}

/* A puff of one of three columns, 12 m high: an optical depth of about 1.5 across each, however many share it. */
static vxs_capsule puff(rng *r, uint32_t of)
{
    static const double feet[3][2] = {{-4, -3}, {1, 2}, {4, -4}};
    uint32_t            column     = rng_below(r, 3);
    double rise = rng_unit(r), wide = 0.4 + 1.6 * rise, angle = between(r, 0, 2 * M_PI), out = wide * sqrt(rng_unit(r)),
           radius = wide * between(r, 0.3, 0.6);
    double at[3]  = {feet[column][0] + 0.8 * sin(5 * rise + column) + out * cos(angle), 0.6 + 9.8 * rise,
                     feet[column][1] + 0.8 * cos(4 * rise + column) + out * sin(angle)};
    return capsule_of(at, at, radius, 1.5 * 12 * 3 * 3 / (4 * of * radius * radius));
}

/* Piece n of a strand that hangs from a head: each as wide as hair in a tuft is, and lets 60 to 90 % through. */
static vxs_capsule strand(uint64_t seed, uint32_t number)
{
    enum { PIECES = 8 };
    rng    r     = rng_split(seed, number / PIECES);
    double angle = between(&r, 0, 2 * M_PI), lean = between(&r, 0, 1), place[2][3], through = between(&r, 0.6, 0.9),
           wave = between(&r, 0, 6);
    for (uint32_t n = 0; n < 2; n++) {
        double along = (double)(number % PIECES + n) / PIECES, out = 1.1 * sin(1.5 * lean) + 0.5 * along;
        place[n][0] = -1 + out * cos(angle + 0.2 * sin(3 * along + wave));
        place[n][1] = 5.5 + 1.1 * cos(1.5 * lean) - 3 * along * along;
        place[n][2] = -1 + out * sin(angle + 0.2 * sin(3 * along + wave));
    }
    return capsule_of(place[0], place[1], 0.03, -log(through) / 0.047);
}

/* A leaf of one of nine crowns. */
static vxs_capsule leaf(rng *r)
{
    uint32_t tree = rng_below(r, 9);
    double   at[3], end[3], square;
    do {
        square = 0;
        for (int n = 0; n < 3; n++) at[n] = between(r, -1, 1), square += at[n] * at[n];
    } while (square > 1);
    at[0] = 2.2 * at[0] + 5 * (tree % 3) - 5;
    at[1] = 2.5 * at[1] + 7 + 0.5 * (tree % 4);
    at[2] = 2.2 * at[2] + 5 * (tree / 3) - 5;
    for (int n = 0; n < 3; n++) end[n] = at[n] + between(r, -0.15, 0.15);
    return capsule_of(at, end, 0.12, between(r, 2, 8));
}

void smoke_make(smoke_kind kind, vxs_capsule *capsules, uint32_t count, uint64_t seed)
{
    rng      r     = rng_split(seed, 0);
    uint32_t puffs = kind == SMOKE_HAIR ? count / 2 : kind == SMOKE_COLUMNS ? count : 0;
    for (uint32_t n = 0; n < count; n++)
        capsules[n] = n < puffs ? puff(&r, puffs) : kind == SMOKE_HAIR ? strand(seed, n - puffs) : leaf(&r);
}

/* the truth ------------------------------------------------------------------------------------------------------------------------- */

/* How far a place of the ray is from the capsule's axis. */
static double distance_to(const vxs_capsule *c, const double from[3], const double way[3], double metres)
{
    double along = 0, square = 0, size = 0, axis[3], to[3];
    for (int n = 0; n < 3; n++) {
        axis[n] = (double)c->end[n] - (double)c->begin[n];
        to[n]   = from[n] + metres * way[n] - (double)c->begin[n];
        along += axis[n] * to[n];
        size += axis[n] * axis[n];
    }
    double part = size > 0 ? fmin(fmax(along / size, 0), 1) : 0;
    for (int n = 0; n < 3; n++) square += (to[n] - part * axis[n]) * (to[n] - part * axis[n]);
    return sqrt(square);
}

/* Where the distance is the radius, between a place inside and one outside. */
static double end_between(const vxs_capsule *c, const double from[3], const double way[3], double inside, double outside)
{
    for (int n = 0; n < 60; n++) {
        double middle = 0.5 * (inside + outside);
        if (distance_to(c, from, way, middle) < (double)c->radius_metres)
            inside = middle;
        else
            outside = middle;
    }
    return 0.5 * (inside + outside);
}

/* The distance is convex along the ray: where it is least lies in what two tries in the golden section leave. */
static int part_of(const vxs_capsule *c, const double from[3], const double way[3], smoke_part *part)
{
    const double golden = 0.6180339887498949;
    double       near = 0, size = 0, beside = 0, reach;
    for (int n = 0; n < 3; n++) {
        double to = 0.5 * ((double)c->begin[n] + (double)c->end[n]) - from[n];
        near += to * way[n];
        beside += to * to;
        size += pow((double)c->end[n] - (double)c->begin[n], 2);
    }
    reach = 0.5 * sqrt(size) + (double)c->radius_metres;
    if (beside - near * near > reach * reach) return 0;
    double low = near - reach, high = near + reach;
    for (int n = 0; n < 80; n++) {
        double a = high - golden * (high - low), b = low + golden * (high - low);
        if (distance_to(c, from, way, a) < distance_to(c, from, way, b))
            high = b;
        else
            low = a;
    }
    double middle = 0.5 * (low + high);
    if (!(distance_to(c, from, way, middle) < (double)c->radius_metres)) return 0;
    *part = (smoke_part){fmax(end_between(c, from, way, middle, near - reach), 0), end_between(c, from, way, middle, near + reach),
                         (double)c->extinction};
    return part->exit > part->entry;
}

size_t smoke_parts(const vxs_capsule *capsules, uint32_t count, const double from[3], const double way[3], smoke_part *parts)
{
    size_t found = 0;
    for (uint32_t n = 0; n < count; n++) found += (size_t)part_of(&capsules[n], from, way, &parts[found]);
    return found;
}

double smoke_left(const smoke_part *parts, size_t count, double metres)
{
    double depth = 0;
    for (size_t n = 0; n < count; n++) depth += parts[n].extinction * fmax(0, fmin(metres, parts[n].exit) - parts[n].entry);
    return exp(-depth);
}
