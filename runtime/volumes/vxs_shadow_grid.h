/* A voxelized shadow volume. It stores, in bits along eye rays, where shadow begins on each light ray of epipolar space
 * (vxs_epipolar.h). One text for C99, C++, GLSL and HLSL. Built on vxs_epipolar.h and vxs_air_path.h.
 *
 *     vxs_grid_column      the column where shadow begins
 *     vxs_grid_word_of     the word of a voxel's bit
 *     vxs_grid_airlight    airlight along an eye ray
 *
 * The bit of a voxel is 1 if its middle is in shadow. Words are in the order of 128-bit texels in an array of images, x = alpha,
 * y = theta, bit = phi:
 *
 *     layer 0: row 0: column 0: bits 0 to 31, 32 to 63, 64 to 95, 96 to 127; column 1: ...
 *              row 1: ...
 *     layer 1: bits 128 to 159...
 *
 * So the bits of an eye ray are adjacent, and light travels from texel to texel of a row.
 *
 * A shader must define, before this text, vxs_grid_word(words, i): word i of a grid; vxs_grid_airlight passes `words` to it.
 * Source: [VSV11]; bits for the middles of voxels and the ends of rays are ours.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_SHADOW_GRID_H
#define VXS_SHADOW_GRID_H

#ifndef VXS_EPIPOLAR_H /* a shader that cannot include has them already */
#include "vxs_air_path.h"
#include "vxs_epipolar.h"
#endif

#ifdef VXS_C
typedef struct vxs_grid_size vxs_grid_size;
typedef struct vxs_grid_rows vxs_grid_rows;
#define VXS_GRID_SIZE           const vxs_grid_size *
#define VXS_GRID_ROWS           const vxs_grid_rows *
#define VXS_GRID_WORDS          const vxs_u32 *
#define vxs_grid_word(words, i) (words)[i]
#else
#define VXS_GRID_SIZE  const vxs_grid_size
#define VXS_GRID_ROWS  const vxs_grid_rows
#define VXS_GRID_WORDS uint
#endif

struct vxs_grid_size {
    vxs_i32 columns; /* steps of alpha, > 0 */
    vxs_i32 rows;    /* steps of theta, > 0 */
    vxs_i32 bits;    /* steps of phi, > 0; a layer has 128. At most 2^29 words in all */
};

/* Number of words of a grid. */
VXS_FN vxs_i32 vxs_grid_words(VXS_GRID_SIZE size)
{
    return 4 * ((VXS_FIELD(size, bits) + 127) >> 7) * VXS_FIELD(size, rows) * VXS_FIELD(size, columns);
}

/* Position after `voxels` of the `count` voxels of a range. */
VXS_FN vxs_real vxs_grid_place(const vxs_real2 range, vxs_real voxels, vxs_i32 count)
{
    return range[0] + (range[1] - range[0]) * (voxels / VXS_REAL(count));
}

/* Middle of voxel n. */
VXS_FN vxs_real vxs_grid_middle(const vxs_real2 range, vxs_i32 n, vxs_i32 count)
{
    return vxs_grid_place(range, VXS_REAL(n) + 0.5, count);
}

/* Number of voxels of a range before a position: the inverse of vxs_grid_place. */
VXS_FN vxs_real vxs_grid_before(const vxs_real2 range, vxs_real at, vxs_i32 count)
{
    return (at - range[0]) / (range[1] - range[0]) * VXS_REAL(count);
}

/* Index of the voxel at that number, clamped to [0, count). */
VXS_FN vxs_i32 vxs_grid_voxel(vxs_real before, vxs_i32 count)
{
    if (!(before > 0.0)) return 0;
    return before < VXS_REAL(count) ? VXS_I(before) : count - 1;
}

/* The first column whose middle is in shadow, if shadow begins at alpha. Column 0 if it begins before the visible range;
 * `columns` if it begins behind it. */
VXS_FN vxs_i32 vxs_grid_column(VXS_EPIPOLAR space, VXS_GRID_SIZE size, vxs_real alpha)
{
    vxs_real column = ceil(vxs_grid_before(VXS_FIELD(space, alpha), alpha, VXS_FIELD(size, columns)) - 0.5);
    if (!(column > 0.0)) return 0;
    return column < VXS_REAL(VXS_FIELD(size, columns)) ? VXS_I(column) : VXS_FIELD(size, columns);
}

/* The light ray through the middles of a row and a bit: vxs_epipolar_light_ray.
 * turned  [out] for vxs_epipolar_alpha_at */
VXS_FN void vxs_grid_light_ray(VXS_EPIPOLAR space, VXS_GRID_SIZE size, vxs_i32 row, vxs_i32 bit, VXS_OUT vxs_real2 turned,
                               VXS_OUT vxs_real3 begin, VXS_OUT vxs_real3 direction)
{
    vxs_real3 across;
    vxs_epipolar_turn_of(space, vxs_grid_middle(VXS_FIELD(space, phi), bit, VXS_FIELD(size, bits)), turned);
    vxs_epipolar_across(space, vxs_grid_middle(VXS_FIELD(space, theta), row, VXS_FIELD(size, rows)), across);
    vxs_epipolar_light_ray(space, across, turned, begin, direction);
}

/* The word that contains a voxel's bit; it is bit number (bit & 31) of the word. */
VXS_FN vxs_i32 vxs_grid_word_of(VXS_GRID_SIZE size, vxs_i32 column, vxs_i32 row, vxs_i32 bit)
{
    vxs_i32 texel = ((bit >> 7) * VXS_FIELD(size, rows) + row) * VXS_FIELD(size, columns) + column;
    return 4 * texel + ((bit & 127) >> 5);
}

/* Share of the bits [first, end) of an eye ray that is lit, [0, 1]. */
VXS_FN vxs_real vxs_grid_lit_part(VXS_GRID_WORDS words, VXS_GRID_SIZE size, vxs_i32 column, vxs_i32 row, vxs_i32 first, vxs_i32 end)
{
    vxs_u32 lit = 0u; /* not 1 - dark / all: in a shader a quotient of equal numbers may be above 1 */
    for (vxs_i32 bit = first; bit < end; bit = (bit | 31) + 1) {
        vxs_u32 mask = 0xffffffffu << (bit & 31);
        if (end <= (bit | 31)) mask &= ~(0xffffffffu << (end & 31));
        lit += vxs_popcount(~vxs_grid_word(words, vxs_grid_word_of(size, column, row, bit)) & mask);
    }
    return VXS_REAL(lit) / VXS_REAL(end - first);
}

/* The eye ray through the middle of a column, on which the voxels of the column lie. */
VXS_FN vxs_epipolar_ray vxs_grid_column_ray(VXS_EPIPOLAR space, VXS_GRID_SIZE size, vxs_i32 column)
{
    vxs_epipolar_ray ray;
    vxs_real2        turned;
    ray.alpha = vxs_grid_middle(VXS_FIELD(space, alpha), column, VXS_FIELD(size, columns));
    ray.theta = VXS_REAL(0.0);
    vxs_epipolar_turn(ray.alpha, turned);
    ray.sine   = turned[0];
    ray.cosine = turned[1];
    return ray;
}

/* Number of bits before a point on an eye ray. */
VXS_FN vxs_real vxs_grid_bits_before(VXS_EPIPOLAR space, VXS_GRID_SIZE size, VXS_EPIPOLAR_RAY ray, vxs_real metres)
{
    return vxs_grid_before(VXS_FIELD(space, phi), vxs_epipolar_phi_at(space, ray, metres), VXS_FIELD(size, bits));
}

/* The rows that an eye ray uses: one, or two that it interpolates. */
struct vxs_grid_rows {
    vxs_i32  row, next;
    vxs_real part; /* weight of the next row, [0, 1) */
};

/* The row that contains theta. */
VXS_FN vxs_grid_rows vxs_grid_row_of(VXS_EPIPOLAR space, VXS_GRID_SIZE size, vxs_real theta)
{
    vxs_grid_rows rows;
    rows.row = rows.next =
        vxs_grid_voxel(vxs_grid_before(VXS_FIELD(space, theta), theta, VXS_FIELD(size, rows)), VXS_FIELD(size, rows));
    rows.part = VXS_REAL(0.0);
    return rows;
}

/* The two rows with the nearest middles. They wrap around if theta is a full circle. */
VXS_FN vxs_grid_rows vxs_grid_rows_about(VXS_EPIPOLAR space, VXS_GRID_SIZE size, vxs_real theta)
{
    vxs_grid_rows rows;
    vxs_i32       count = VXS_FIELD(size, rows);
    vxs_real      wide = VXS_FIELD(space, theta)[1] - VXS_FIELD(space, theta)[0], seam = 2.0 * VXS_AIR_PI - 1e-5;
    vxs_real      before = vxs_grid_before(VXS_FIELD(space, theta), theta, count) - 0.5, floored = floor(before);
    rows.part = before - floored;
    rows.row  = before < 0.0 ? (wide > seam ? count - 1 : 0) : vxs_grid_voxel(floored, count);
    rows.next = before < 0.0 ? 0 : rows.row + 1 < count ? rows.row + 1 : wide > seam ? 0 : rows.row;
    return rows;
}

/* Share of the bits [first, end) of an eye ray that is lit, interpolated between its rows. */
VXS_FN vxs_real vxs_grid_lit_part_of(VXS_GRID_WORDS words, VXS_GRID_SIZE size, vxs_i32 column, VXS_GRID_ROWS rows, vxs_i32 first,
                                     vxs_i32 end)
{
    vxs_real lit = vxs_grid_lit_part(words, size, column, VXS_FIELD(rows, row), first, end), part = VXS_FIELD(rows, part);
    if (!(part > 0.0)) return lit;
    return lit + part * (vxs_grid_lit_part(words, size, column, VXS_FIELD(rows, next), first, end) - lit);
}

/* Transmittance of smoke between the light and a point of the eye ray, at a distance in metres. A shader with smoke defines it
 * before this text. */
#ifdef vxs_grid_left
#define VXS_GRID_DIMS
#else
#define vxs_grid_left(metres) VXS_REAL(1.0)
#endif

/* Airlight of an eye ray's path. Its bits are divided into runs. Each run is lit by the mean of its bits, and weighted by the
 * light that its middle scatters. A fully lit path gives exactly vxs_air_lit. Bits whose middles are not on the path are
 * ignored; behind the last bit, nothing changes. Two kinds of rays are about as short as a bit or shorter. Rays away from the
 * light see what the eye sees. Rays toward a punctual light, all in one column, either end before it, in the dark, or behind it,
 * fully lit.
 * ray       vxs_epipolar_eye of its direction;   rows  that it uses;   metres  along the ray to the surface behind the air
 * runs      number of runs, >= 1; size.bits or more: one for each bit
 * eye_lit   1: the light reaches the eye; 2: the eye is inside the light, and all that it sees is lit; else 0
 * airlight  [out] for an intensity or irradiance of 1 */
VXS_FN void vxs_grid_airlight_of(VXS_GRID_WORDS words, VXS_EPIPOLAR space, VXS_GRID_SIZE size, VXS_MEDIUM medium, VXS_AIR_PATH path,
                                 VXS_EPIPOLAR_RAY ray, VXS_GRID_ROWS rows, vxs_real metres, vxs_i32 runs, vxs_i32 eye_lit,
                                 VXS_OUT vxs_real3 airlight)
{
    vxs_real         begin = VXS_FIELD(path, begin), end = VXS_FIELD(path, end), away = VXS_FIELD(space, away);
    vxs_i32          columns = VXS_FIELD(size, columns), bits = VXS_FIELD(size, bits);
    vxs_real         across = vxs_grid_before(VXS_FIELD(space, alpha), VXS_FIELD(ray, alpha), columns);
    vxs_i32          column = vxs_grid_voxel(across, columns);
    vxs_epipolar_ray of     = vxs_grid_column_ray(space, size, column);
    vxs_real4        before;
    for (vxs_i32 n = 0; n < 4;
         n++) { /* of the column and of the ray: where the path begins and ends; one call, because it is inlined */
        if (n == 2) {
            of.sine   = VXS_FIELD(ray, sine);
            of.cosine = VXS_FIELD(ray, cosine);
        }
        before[n] = vxs_grid_bits_before(space, size, VXS_REF(of), (n & 1) == 0 ? begin : end);
    }
    vxs_real from = before[0], to = before[1];
    vxs_i32  first = from > 0.5 ? vxs_grid_voxel(ceil(from - 0.5), bits) : 0, last = vxs_grid_voxel(to - 0.5, bits);
    vxs_i32  count = last > first ? last + 1 - first : 1, parts = runs < count ? runs : count;
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    if (!(end > begin)) return;

    vxs_real3 all, lit, now;
    vxs_real  same = VXS_REAL(-1.0); /* lit share of the whole path, if the same everywhere: 0 or 1; otherwise < 0 */
    if (eye_lit > 1)
        same = VXS_REAL(1.0);
    else if (away > 0.0 && VXS_FIELD(ray, cosine) > 0.0 && VXS_FIELD(space, alpha)[0] == 0.0 && across < 1.0)
        same = VXS_REAL(metres >= away ? 1.0 : 0.0);
    else if (to < 0.5 && VXS_FIELD(space, phi)[0] == 0.0)
        same = VXS_REAL(eye_lit);
    for (vxs_i32 i = 0; i < 3; i++) all[i] = lit[i] = VXS_REAL(0.0);
    if (same >= 0.0) parts = 0;
#ifdef VXS_GRID_DIMS /* smoke dims fully lit paths, too: by the mean of even runs */
    if (same > 0.0) parts = runs;
#endif

    vxs_real bit = before[2], behind = before[3];
    for (vxs_i32 n = 0; n < parts; n++) {
        vxs_real x, part, weight;
#ifdef VXS_GRID_DIMS
        x    = begin + (VXS_REAL(n) + 0.5) * ((end - begin) / VXS_REAL(parts));
        part = weight = VXS_REAL(1.0);
        if (same < 0.0)
#endif
        {
            vxs_i32   a = first + count * n / parts, b = first + count * (n + 1) / parts;
            vxs_real  next = n + 1 < parts ? VXS_REAL(b) : behind;
            vxs_real2 turned;
            next = next > bit ? next : bit;
            part = vxs_grid_lit_part_of(words, size, column, rows, a, b);
            vxs_epipolar_turn_of(space, vxs_grid_place(VXS_FIELD(space, phi), 0.5 * (bit + next), bits), turned);
            x      = vxs_epipolar_distance(space, ray, turned, end);
            x      = x > begin ? x : begin;
            weight = next - bit;
            bit    = next;
            /* the length of a bit is proportional to the squared distance from the light, also inside its radius */
            if (away > 0.0) {
                vxs_real y = x - away * VXS_FIELD(ray, cosine), h = away * VXS_FIELD(ray, sine);
                weight *= h * h + y * y;
            }
        }
        if (part > 0.0) part *= vxs_grid_left(x);
        vxs_air_at(medium, path, x, now);
        for (vxs_i32 i = 0; i < 3; i++) {
            all[i] += weight * now[i];
            lit[i] += part * (weight * now[i]);
        }
    }
#ifdef VXS_GRID_DIMS
    if (same > 0.0) same = all[0] + all[1] + all[2] > 0.0 ? (lit[0] + lit[1] + lit[2]) / (all[0] + all[1] + all[2]) : VXS_REAL(1.0);
#endif
    vxs_air_lit(medium, path, begin, end, airlight);
    for (vxs_i32 i = 0; i < 3; i++) airlight[i] *= same >= 0.0 ? same : all[i] > 0.0 ? lit[i] / all[i] : VXS_REAL(0.0);
}

/* The same, with the row that contains the ray.   direction  of length 1 */
VXS_FN void vxs_grid_airlight(VXS_GRID_WORDS words, VXS_EPIPOLAR space, VXS_GRID_SIZE size, VXS_MEDIUM medium, VXS_AIR_PATH path,
                              const vxs_real3 direction, vxs_real metres, vxs_i32 runs, vxs_i32 eye_lit, VXS_OUT vxs_real3 airlight)
{
    vxs_epipolar_ray ray  = vxs_epipolar_eye(space, direction);
    vxs_grid_rows    rows = vxs_grid_row_of(space, size, ray.theta);
    vxs_grid_airlight_of(words, space, size, medium, path, VXS_REF(ray), VXS_REF(rows), metres, runs, eye_lit, airlight);
}

#endif
