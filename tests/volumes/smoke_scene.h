/* Procedural smoke, hair and leaves as capsules of vxs_transmittance.h, and how much light they leave along a ray, in double: the
 * product over all capsules, each of whose ends on the ray is found by bisection of the distance to its axis. It shares nothing
 * with what it judges.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_SCENE_H
#define SMOKE_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "runtime/volumes/vxs_transmittance.h"

/* All lie between (-8, 0, -8) and (8, 12, 8), metres. */
typedef enum smoke_kind {
    SMOKE_COLUMNS, /* three columns of puffs that rise and widen */
    SMOKE_HAIR,    /* the same, and as many capsules again in strands of hair between them */
    SMOKE_LEAVES,  /* leaves of trees that let some light through */
    SMOKE_KINDS
} smoke_kind;

extern const char *const smoke_names[SMOKE_KINDS];

/* capsules  [out] [count], the same on every machine but for libm's last bit; as dense in all whatever their number */
void smoke_make(smoke_kind kind, vxs_capsule *capsules, uint32_t count, uint64_t seed);

/* A capsule's part of a ray, metres along it. */
typedef struct smoke_part {
    double entry, exit, extinction;
} smoke_part;

/* way    of length 1
 * parts  [out] [count]; of the ray from its begin on, and not before
 * Returns how many there are. Threads: any. */
size_t smoke_parts(const vxs_capsule *capsules, uint32_t count, const double from[3], const double way[3], smoke_part *parts);

/* How much light is left so many metres along the ray. */
double smoke_left(const smoke_part *parts, size_t count, double metres);

#endif
