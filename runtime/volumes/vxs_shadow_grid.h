/* A voxelized shadow volume: of each light ray of epipolar space (vxs_epipolar.h) where shadow begins on it, in bits that lie as eye rays run.
 * One text for C99, C++, GLSL and HLSL, that stands on vxs_epipolar.h and vxs_air_path.h.
 *
 *     vxs_grid_column      in which column shadow begins
 *     vxs_grid_word_of     where a voxel's bit is
 *     vxs_grid_airlight    airlight along an eye ray
 *
 * A voxel stands for the place at its middle: its bit is 1 where that is in shadow. Words lie as texels of 128 bits would in an array of images,
 * x = alpha, y = theta, bit = phi:
 *
 *     layer 0: row 0: column 0: bits 0 to 31, 32 to 63, 64 to 95, 96 to 127; column 1: ...     so that an eye ray's bits are side by side, and
 *              row 1: ...                                                                     light goes from texel to texel of a row
 *     layer 1: bits 128 to 159...
 *
 * A shader defines, before this text, vxs_grid_word(words, i): word i of a grid; `words` is what it hands to vxs_grid_airlight.
 * Source: [VSV11]; what a voxel stands for, and the ends of rays, are ours.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_SHADOW_GRID_H
#define VXS_SHADOW_GRID_H

#ifndef VXS_EPIPOLAR_H /* a shader that cannot include has them already */
#include "vxs_air_path.h"
#include "vxs_epipolar.h"
#endif

#ifdef VXS_C
typedef struct vxs_grid_size vxs_grid_size;
#define VXS_GRID_SIZE           const vxs_grid_size *
#define VXS_GRID_WORDS          const vxs_u32 *
#define vxs_grid_word(words, i) (words)[i]
#else
#define VXS_GRID_SIZE  vxs_grid_size
#define VXS_GRID_WORDS uint
#endif

struct vxs_grid_size {
    vxs_i32 columns; /* of alpha, > 0 */
    vxs_i32 rows;    /* of theta, > 0 */
    vxs_i32 bits;    /* of phi, > 0; a layer holds 128. No more than 2^29 words in all */
};

/* How many words it has. */
VXS_FN vxs_i32 vxs_grid_words(VXS_GRID_SIZE size)
{
    return 4 * ((VXS_FIELD(size, bits) + 127) >> 7) * VXS_FIELD(size, rows) * VXS_FIELD(size, columns);
}

/* The middle of voxel n of `count` that a range has. */
VXS_FN vxs_real vxs_grid_middle(const vxs_real2 range, vxs_i32 n, vxs_i32 count)
{
    return range[0] + (range[1] - range[0]) * ((VXS_REAL(n) + 0.5) / VXS_REAL(count));
}

/* How many voxels of a range lie before a place. */
VXS_FN vxs_real vxs_grid_before(const vxs_real2 range, vxs_real at, vxs_i32 count)
{
    return (at - range[0]) / (range[1] - range[0]) * VXS_REAL(count);
}

/* The voxel that a number of them before it leads to, [0, count). */
VXS_FN vxs_i32 vxs_grid_voxel(vxs_real before, vxs_i32 count)
{
    if (!(before > 0.0)) return 0;
    return before < VXS_REAL(count) ? VXS_I(before) : count - 1;
}

/* The first column whose middle is in shadow where shadow begins at alpha. What is nearer to the light than all that can be seen shadows all of
 * it: column 0. `columns`: what can be seen is before it. */
VXS_FN vxs_i32 vxs_grid_column(VXS_EPIPOLAR space, VXS_GRID_SIZE size, vxs_real alpha)
{
    vxs_real column = ceil(vxs_grid_before(VXS_FIELD(space, alpha), alpha, VXS_FIELD(size, columns)) - 0.5);
    if (!(column > 0.0)) return 0;
    return column < VXS_REAL(VXS_FIELD(size, columns)) ? VXS_I(column) : VXS_FIELD(size, columns);
}

/* The word of a voxel's bit, which is bit & 31 of it. */
VXS_FN vxs_i32 vxs_grid_word_of(VXS_GRID_SIZE size, vxs_i32 column, vxs_i32 row, vxs_i32 bit)
{
    vxs_i32 texel = ((bit >> 7) * VXS_FIELD(size, rows) + row) * VXS_FIELD(size, columns) + column;
    return 4 * texel + ((bit & 127) >> 5);
}

/* How many of the bits [first, end) of an eye ray are in shadow. */
VXS_FN vxs_i32 vxs_grid_shadow_count(VXS_GRID_WORDS words, VXS_GRID_SIZE size, vxs_i32 column, vxs_i32 row, vxs_i32 first,
                                     vxs_i32 end)
{
    vxs_i32 count = 0;
    for (vxs_i32 bit = first; bit < end; bit = (bit | 31) + 1) {
        vxs_u32 mask = 0xffffffffu << (bit & 31);
        if (end <= (bit | 31)) mask &= ~(0xffffffffu << (end & 31));
        count += VXS_I(vxs_popcount(vxs_grid_word(words, vxs_grid_word_of(size, column, row, bit)) & mask));
    }
    return count;
}

VXS_FN void vxs_grid_add(VXS_MEDIUM medium, VXS_AIR_PATH path, vxs_real begin, vxs_real end, vxs_real share,
                         VXS_INOUT vxs_real3 sum)
{
    vxs_real3 found;
    vxs_air_lit(medium, path, begin, end, found);
    for (vxs_i32 n = 0; n < 3; n++) sum[n] += share * found[n];
}

/* Airlight of an eye ray's path, whose bits are taken in runs: each is as lit as its bits are in the mean, and what is all lit is one part.
 * A bit whose middle is not on the path does not count; beyond the last that is, nothing changes. Two kinds of rays are shorter than a bit, or
 * nearly: those away from the light see all that the eye does; those toward a lamp, of which one column has all, end before it, in the dark,
 * or behind it, all lit.
 * direction  of length 1;   metres  to what is behind the air, along the ray
 * runs       into how many the bits are parted, >= 1; size.bits, and more: each is one
 * eye_lit    1: the light reaches the eye; 2: the eye is in the lamp, and all that it sees is lit; else 0
 * airlight   [out] for an intensity or irradiance of 1 */
VXS_FN void vxs_grid_airlight(VXS_GRID_WORDS words, VXS_EPIPOLAR space, VXS_GRID_SIZE size, VXS_MEDIUM medium, VXS_AIR_PATH path,
                              const vxs_real3 direction, vxs_real metres, vxs_i32 runs, vxs_i32 eye_lit, VXS_OUT vxs_real3 airlight)
{
    vxs_epipolar_ray ray   = vxs_epipolar_eye(space, direction), middle;
    vxs_real         begin = VXS_FIELD(path, begin), end = VXS_FIELD(path, end), away = VXS_FIELD(space, away);
    vxs_i32          columns = VXS_FIELD(size, columns), rows = VXS_FIELD(size, rows), bits = VXS_FIELD(size, bits);
    vxs_real         at     = vxs_grid_before(VXS_FIELD(space, alpha), ray.alpha, columns);
    vxs_i32          column = vxs_grid_voxel(at, columns);
    vxs_i32          row    = vxs_grid_voxel(vxs_grid_before(VXS_FIELD(space, theta), ray.theta, rows), rows);
    vxs_real2        turned;
    middle.alpha = vxs_grid_middle(VXS_FIELD(space, alpha), column, columns);
    middle.theta = ray.theta;
    vxs_epipolar_turn(middle.alpha, turned);
    middle.sine    = turned[0];
    middle.cosine  = turned[1];
    vxs_real from  = vxs_grid_before(VXS_FIELD(space, phi), vxs_epipolar_phi_at(space, VXS_REF(middle), begin), bits);
    vxs_real to    = vxs_grid_before(VXS_FIELD(space, phi), vxs_epipolar_phi_at(space, VXS_REF(middle), end), bits);
    vxs_i32  first = from > 0.5 ? vxs_grid_voxel(ceil(from - 0.5), bits) : 0, last = vxs_grid_voxel(to - 0.5, bits);
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    if (!(end > begin)) return;
    vxs_i32 lit = -1; /* all of it; -1: bits say */
    if (eye_lit > 1)
        lit = 1;
    else if (away > 0.0 && ray.cosine > 0.0 && VXS_FIELD(space, alpha)[0] == 0.0 && at < 1.0)
        lit = metres >= away ? 1 : 0;
    else if (to < 0.5 && VXS_FIELD(space, phi)[0] == 0.0)
        lit = eye_lit;
    if (lit >= 0) {
        if (lit > 0) vxs_air_lit(medium, path, begin, end, airlight);
        return;
    }
    if (last < first) last = first;
    vxs_i32  count = last + 1 - first, parts = runs < count ? runs : count;
    vxs_real lit_from = begin, x = begin;
    for (vxs_i32 n = 0; n < parts; n++) {
        vxs_i32  a = first + count * n / parts, b = first + count * (n + 1) / parts;
        vxs_i32  dark = vxs_grid_shadow_count(words, size, column, row, a, b);
        vxs_real next = end;
        if (n + 1 < parts) {
            vxs_real phi =
                VXS_FIELD(space, phi)[0] + (VXS_FIELD(space, phi)[1] - VXS_FIELD(space, phi)[0]) * (VXS_REAL(b) / VXS_REAL(bits));
            vxs_epipolar_turn_of(space, phi, turned);
            next = vxs_epipolar_distance(space, VXS_REF(ray), turned, end);
            next = next > x ? next : x;
        }
        if (dark > 0) {
            if (x > lit_from) vxs_grid_add(medium, path, lit_from, x, VXS_REAL(1.0), airlight);
            if (dark < b - a) vxs_grid_add(medium, path, x, next, 1.0 - VXS_REAL(dark) / VXS_REAL(b - a), airlight);
            lit_from = next;
        }
        x = next;
    }
    if (x > lit_from) vxs_grid_add(medium, path, lit_from, x, VXS_REAL(1.0), airlight);
}

#endif
