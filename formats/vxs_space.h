/* World space to voxel, voxel to world space, and the whole lookup: one text for C99, C++, GLSL and HLSL; it needs
 * vxs_lookup.h.
 *
 *     world space --- ls_from_ws ---> light space --- one of its maps ---> texels u, v, and depth in voxels ---> a voxel
 *       metres        3 x 4 matrix      directional: unchanged
 *                                       spot, point: metres about the light; u, v = 2^levels / 2 + (x, y) / z / texel_metres,
 *                                                    depth = log(z / near_metres) / voxel_metres, z away from the light
 *
 *     vxs_place_from_ws    the place of a point: a voxel of a map and the position in its texel, moved off a surface along its
 *                          normal; and whether the light reaches there.   vxs_voxel_from_ws: only the voxel
 *     vxs_shadow_taps      number of taps of a box around a voxel that are in shadow, for any coding of the words
 *     vxs_shadow_part      shadowed part of a smooth box around a place
 *     vxs_lit_at_place     the lit fraction around a place; vxs_lit_at_voxel: around the middle of a voxel
 *     vxs_lit              both: the lit fraction around a point
 *     vxs_lit_is_full      whether vxs_lit is exact, or coarse because pages are missing
 *     vxs_ws_from_voxel    the point in world space of map coordinates
 *
 * A shader passes to its compiler: its own head (#version, the words, vxs_word), the texts of vxs_lookup.h and
 * vxs_lookup_blocks.h, this text, and its body. A shader whose lights are all DAGs may omit vxs_lookup_blocks.h. Its lights
 * are vxs_light_constants, which vxs_light_constants_of (runtime/vxs.h) fills. Macros of the includer, in addition to those
 * of vxs_lookup.h:
 *
 *     vxs_real             the scalar; C and C++: double. Shaders: float
 *     VXS_REAL_MIN         least distance from the light; nearer points count as this far; C and C++: DBL_MIN.
 *                          Shaders: 1e-30
 *     VXS_LIGHT            type of a light in C and C++: const vxs_light *
 *
 * In C all numbers are allowed: NaN and values beyond +-2^30 voxels are clamped and lie outside any map; no conversion
 * overflows. Compilers of shading languages may assume that there is no NaN and no infinity, and may flush tiny numbers to
 * 0: there, positions and normals must be finite. Any filter is allowed in both. Otherwise both agree
 * except for float rounding: see docs/runtime.md.
 * Source: [CPVS16] 5.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_SPACE_H
#define VXS_SPACE_H

#ifndef VXS_LOOKUP_H /* a shader that cannot include already has this text */
#include "vxs_lookup.h"
#endif

#ifdef VXS_C
#include <float.h>
#include <math.h>

#include "vxs_file.h"
#include "vxs_lookup_blocks.h"
#ifndef vxs_real
#define vxs_real     double
#define VXS_REAL_MIN DBL_MIN
#endif
#ifndef VXS_LIGHT
#define VXS_LIGHT const vxs_light *
#endif
typedef vxs_real         vxs_real3[3];
typedef vxs_i32          vxs_int3[3];
typedef struct vxs_place vxs_place;
#define VXS_OUT
#define VXS_INOUT
#define VXS_REF(x)                         (&(x)) /* passes a struct by pointer, to be filled or to avoid a copy */
#define VXS_REF_OF(object, field)          (&(object)->field)
#define VXS_REAL(x)                        VXS_CAST(vxs_real, x)
#define VXS_FIELD(light, field)            ((light)->field)
#define VXS_LS_FROM_WS(light, row, column) ((light)->ls_from_ws[4 * (row) + (column)])
#define vxs_abs(x)                         fabs(x)

/* floor without a call, for numbers that vxs_clamped does not clamp; other numbers are returned unchanged. */
VXS_FN vxs_real vxs_floor(vxs_real x)
{
    if (!(x > -2147483648.0 && x < 2147483648.0)) return x;
    vxs_real whole = VXS_REAL(VXS_I(x));
    return whole > x ? whole - 1.0 : whole;
}
#else
#define vxs_real     float
#define VXS_REAL_MIN 1e-30
#define VXS_LIGHT    const vxs_light_constants
#ifdef VXS_HLSL
#define vxs_real3         float3
#define vxs_int3          int3
#define vxs_real4         float4
#define vxs_uint4         uint4
#define vxs_real_of(bits) asfloat(bits)
#else
#define vxs_real3         vec3
#define vxs_int3          ivec3
#define vxs_real4         vec4
#define vxs_uint4         uvec4
#define vxs_real_of(bits) uintBitsToFloat(bits)
#endif
#define VXS_OUT                            out
#define VXS_INOUT                          inout
#define VXS_REF(x)                         (x)
#define VXS_REF_OF(object, field)          ((object).field)
#define VXS_REAL(x)                        float(x)
#define VXS_FIELD(light, field)            ((light).field)
#define VXS_LS_FROM_WS(light, row, column) ((light).ls_from_ws[row][column])
#define vxs_abs(x)                         abs(x)
#define vxs_floor(x)                       floor(x)

/* The same as in runtime/vxs.h, where the fields are described: 96 bytes in std140, std430, a cbuffer and a
 * StructuredBuffer. */
struct vxs_light_constants {
    vxs_real4 ls_from_ws[3];
    float     texel_metres, voxel_metres, near_metres, range_metres;
    float     cos_outer;
    uint      kind, flags, levels;
    uint      first_word, coding, origin_fraction_ij, origin_fraction_k;
};

/* A light whose 96 bytes are six texels of four words, for shaders that read textures. */
vxs_light_constants vxs_light_of_texels(const vxs_uint4 row_0, const vxs_uint4 row_1, const vxs_uint4 row_2, const vxs_uint4 metres,
                                        const vxs_uint4 kind, const vxs_uint4 words)
{
    vxs_light_constants light;
    light.ls_from_ws[0]      = vxs_real_of(row_0);
    light.ls_from_ws[1]      = vxs_real_of(row_1);
    light.ls_from_ws[2]      = vxs_real_of(row_2);
    light.texel_metres       = vxs_real_of(metres.x);
    light.voxel_metres       = vxs_real_of(metres.y);
    light.near_metres        = vxs_real_of(metres.z);
    light.range_metres       = vxs_real_of(metres.w);
    light.cos_outer          = vxs_real_of(kind.x);
    light.kind               = kind.y;
    light.flags              = kind.z;
    light.levels             = kind.w;
    light.first_word         = words.x;
    light.coding             = words.y;
    light.origin_fraction_ij = words.z;
    light.origin_fraction_k  = words.w;
    return light;
}

/* The filter of a lookup, as in vxs_file.h, where it is described. GLSL reserves the name "filter"; here one is called "pcf". */
struct vxs_filter {
    int width_px, is_smooth;
};

vxs_filter vxs_box(int width_px)
{
    vxs_filter pcf;
    pcf.width_px  = width_px;
    pcf.is_smooth = 0;
    return pcf;
}

vxs_filter vxs_smooth(int width_px)
{
    vxs_filter pcf;
    pcf.width_px  = width_px;
    pcf.is_smooth = 1;
    return pcf;
}
#endif

/* Numbers of vxs_format.h and vxs.h that shaders need too. A C compiler sees both definitions, and rejects different ones. */
#define VXS_LIGHT_KIND_DIRECTIONAL 1u
#define VXS_LIGHT_KIND_POINT       3u
#define VXS_LIGHT_BOUNDED          1u
#define VXS_LIGHT_CUBE             2u
#define VXS_CODING_BLOCKS          2u
#define VXS_OUTSIDE                (-1.0f)
#define VXS_FILTER_MAX             17

/* A shader may define what all of its lights have in common, as plain numbers: code for others is then not compiled.
 *     VXS_ONLY_KIND    the kind of light, 1 to 3;   VXS_ONLY_CUBE  1: six maps, 0: one map
 *     VXS_ONLY_CODING  the coding of the words, 1 or 2
 *     VXS_ONLY_WIDTH   width_px of all filters, odd if they are not smooth;   VXS_ONLY_SMOOTH  1: they are smooth, 0: not */
#ifdef VXS_ONLY_KIND
#define VXS_KIND(light) VXS_U(VXS_ONLY_KIND)
#if VXS_ONLY_KIND == 1
#define VXS_HAS_SUNS
#else
#define VXS_HAS_PUNCTUAL
#endif
#else
#define VXS_KIND(light) VXS_FIELD(light, kind)
#define VXS_HAS_SUNS
#define VXS_HAS_PUNCTUAL
#endif
#ifdef VXS_ONLY_CUBE
#define VXS_IS_CUBE(light) (VXS_ONLY_CUBE != 0)
#else
#define VXS_IS_CUBE(light) ((VXS_FIELD(light, flags) & VXS_LIGHT_CUBE) != 0u)
#endif
#ifdef VXS_ONLY_CODING
#define VXS_CODING(light) VXS_U(VXS_ONLY_CODING)
#if VXS_ONLY_CODING == 1
#define VXS_HAS_DAGS
#else
#define VXS_HAS_BLOCKS
#endif
#else
#define VXS_CODING(light) VXS_FIELD(light, coding)
#define VXS_HAS_DAGS
#define VXS_HAS_BLOCKS
#endif
#ifdef VXS_ONLY_WIDTH
#define VXS_WIDTH(width_px) (VXS_ONLY_WIDTH)
#else
#define VXS_WIDTH(width_px) (width_px)
#endif
#ifdef VXS_ONLY_SMOOTH
#define VXS_IS_SMOOTH(pcf) (VXS_ONLY_SMOOTH != 0)
#else
#define VXS_IS_SMOOTH(pcf) ((pcf).is_smooth != 0)
#endif

/* maps ------------------------------------------------------------------------------------------------------------------------ */

/* Axis n (0 across, 1 down, 2 away from the light) of face `face` of a cube, as an axis of light space. Face 2a looks along
 * axis a; the next two axes in cyclic order are across and down. Face 2a + 1 looks against axis a; there across and down are
 * exchanged, so that the face stays right-handed. */
VXS_FN vxs_i32 vxs_ls_axis_from_face(const vxs_i32 face, const vxs_i32 n)
{
    vxs_i32 after = n < 2 ? 1 + (n ^ (face & 1)) : 0;
    return (face / 2 + after) % 3;
}

/* The inverse: the axis of the face, 0 to 2 as above, that is axis `axis` of light space. */
VXS_FN vxs_i32 vxs_face_axis_from_ls(const vxs_i32 face, const vxs_i32 axis)
{
    vxs_i32 after = (axis + 3 - face / 2) % 3;
    return after == 0 ? 2 : (after - 1) ^ (face & 1);
}

/* -1 if the face looks against its axis, else 1. */
VXS_FN vxs_real vxs_face_sign(const vxs_i32 face)
{
    return (face & 1) != 0 ? VXS_REAL(-1.0) : VXS_REAL(1.0);
}

/* The cube face of a map. The single map of a light without six maps has the axes of light space, as face 4 has. */
VXS_FN vxs_i32 vxs_face_of_map(VXS_LIGHT light, const vxs_i32 map)
{
    return VXS_IS_CUBE(light) ? map : 4;
}

/* The map that contains a point of light space: of six maps, the one along its longest axis; if axes are equally long, the
 * first. */
VXS_FN vxs_i32 vxs_map_from_ls(VXS_LIGHT light, const vxs_real3 ls)
{
    vxs_i32 map = 0;
    if (VXS_IS_CUBE(light)) {
        vxs_i32 along = vxs_abs(ls[1]) > vxs_abs(ls[0]) ? 1 : 0;
        if (vxs_abs(ls[2]) > vxs_abs(ls[along])) along = 2;
        map = 2 * along + (ls[along] < 0.0 ? 1 : 0);
    }
    return map;
}

/* Light space to the space of a face: across, down, and away from the light. */
VXS_FN void vxs_face_from_ls(const vxs_i32 face, const vxs_real3 ls, VXS_OUT vxs_real3 turned)
{
    turned[0] = ls[vxs_ls_axis_from_face(face, 0)];
    turned[1] = ls[vxs_ls_axis_from_face(face, 1)];
    turned[2] = ls[vxs_ls_axis_from_face(face, 2)] * vxs_face_sign(face);
}

/* The inverse of vxs_face_from_ls. */
VXS_FN void vxs_ls_from_face(const vxs_i32 face, const vxs_real3 turned, VXS_OUT vxs_real3 ls)
{
    vxs_real3 p;
    p[0]  = turned[0];
    p[1]  = turned[1];
    p[2]  = turned[2] * vxs_face_sign(face);
    ls[0] = p[vxs_face_axis_from_ls(face, 0)];
    ls[1] = p[vxs_face_axis_from_ls(face, 1)];
    ls[2] = p[vxs_face_axis_from_ls(face, 2)];
}

/* world to voxel -------------------------------------------------------------------------------------------------------------- */

/* Coordinate `row` of a point (one = 1) or a direction (one = 0) in light space. */
#ifdef VXS_C
VXS_FN vxs_real vxs_ls_coordinate(VXS_LIGHT light, vxs_i32 row, const vxs_real3 ws, vxs_real one)
{
    return VXS_LS_FROM_WS(light, row, 0) * ws[0] + VXS_LS_FROM_WS(light, row, 1) * ws[1] + VXS_LS_FROM_WS(light, row, 2) * ws[2] +
           VXS_LS_FROM_WS(light, row, 3) * one;
}
#else /* the position of the origin, the largest number, is added last */
#define vxs_ls_coordinate(light, row, ws, one) (dot((light).ls_from_ws[row].xyz, ws) + (light).ls_from_ws[row].w * (one))
#endif

VXS_FN void vxs_ls_from_ws(VXS_LIGHT light, const vxs_real3 ws, const vxs_real one, VXS_OUT vxs_real3 ls)
{
    ls[0] = vxs_ls_coordinate(light, 0, ws, one);
    ls[1] = vxs_ls_coordinate(light, 1, ws, one);
    ls[2] = vxs_ls_coordinate(light, 2, ws, one);
}

/* Width of a filter: 1 to VXS_FILTER_MAX, odd if the filter is not smooth. */
#ifdef VXS_ONLY_WIDTH
#define vxs_filter_width(pcf) (vxs_clamp(VXS_ONLY_WIDTH, 1, VXS_FILTER_MAX) | (VXS_IS_SMOOTH(pcf) ? 0 : 1))
#else
VXS_FN vxs_i32 vxs_filter_width(vxs_filter pcf)
{
    vxs_i32 width = vxs_clamp(pcf.width_px, 1, VXS_FILTER_MAX);
    return VXS_IS_SMOOTH(pcf) ? width : width | 1;
}
#endif

/* The place of a lookup. */
struct vxs_place {
    vxs_i32  map;   /* 0, or 0 to 5 of a light with six maps; -1: outside the volume of the light */
    vxs_int3 voxel; /* [0] and [1] texels, [2] depth; may lie outside the map */
    /* distance from the near corner of the texel, rounded down to 1/256 texel: [0, 255]; 0 if the filter is not smooth */
    vxs_u32  across, down;
};

/* A coordinate as an integer. A clamped coordinate is far outside any map. */
VXS_FN vxs_i32 vxs_clamped(vxs_real coordinate)
{
    vxs_real limit = VXS_REAL(1 << 30);
#ifdef VXS_C
    if (!(coordinate > -limit)) return -(1 << 30);
    return coordinate < limit ? VXS_I(coordinate) : 1 << 30;
#else
    return VXS_I(clamp(coordinate, -limit, limit));
#endif
}

/* Position of a coordinate in its texel, in 1/256 texel; 0 if the filter is not smooth. */
VXS_FN vxs_u32 vxs_within(vxs_real coordinate, vxs_filter pcf)
{
    if (!VXS_IS_SMOOTH(pcf)) return 0u;
    vxs_real part = 256.0 * (coordinate - vxs_floor(coordinate));
    if (!(part > 0.0)) return 0u;
    return part < 255.0 ? VXS_U(part) : 255u;
}

/* bias ------------------------------------------------------------------------------------------------------------------------
 *
 * A surface must not shade itself. So a point of a surface is looked up some texels and voxels away from it: all taps of the box
 * lie on the outer side of the plane through the point. A tap is the centre of a texel. Its voxel is certainly lit if the far side
 * of the voxel is before the surface (formats/vxs.md 2).
 *
 *      light        u ->   |   |   |   |   | ./|      p   the point, on the plane /
 *        |                 |   |   |   |  .|/  |      ==  the voxels of a 3 x 1 filter about p, one texel across and one voxel
 *        v  depth          |   |   |===|=/=|===|          towards the light: at each texel's centre, the plane is behind the far
 *                          |   |   |  /|   |   |          side of the voxel
 *                          |   |   |/p |   |   |
 *
 * Let n be the normal in texels: across and down the map, and along the light's ray through the point. A step of (u, v, k) texels
 * moves the place off the plane by n . (u, v, k) texels. The tap that is farthest behind the plane needs
 * n_u * reach_u + n_v * reach_v, and the far side of its voxel needs n_k * 1 voxel more.
 *
 * A step along the light does not move the edges of shadows, but it detaches a shadow from its caster (peter-panning), and it would
 * be infinite where light grazes the surface. A step across the map moves the edges. So the step along the light is at most
 * VXS_BIAS_ALONG times the width of the filter, plus one voxel; the rest is a step across.
 * Source: [CPVS16] 5 moves by half the filter along the normal. That is too little for the corners of a filter, and if voxels are
 * deeper than texels are wide. */

/* Times the width of the filter. docs/measurements.md compares values. */
#define VXS_BIAS_ALONG 0.2

/* Added to distances, in texels and in voxels: for floats, rasterized depths, and normals of 8 bits. */
#define VXS_BIAS_SLACK 0.0625

/* Distance from the middle of a filter to its last tap along one axis, in texels: the average over positions of the middle.
 * The maximum is half a texel more. */
VXS_FN vxs_real vxs_filter_reach(vxs_filter pcf)
{
    vxs_real half_px = 0.5 * VXS_REAL(vxs_filter_width(pcf));
    return VXS_IS_SMOOTH(pcf) ? half_px : half_px - 0.5;
}

/* Position of a point between two taps of its filter: -0.5 to 0.5 texels; 0, the middle of the texel, if the filter is not
 * smooth. On the near side the last tap is farther than vxs_filter_reach by this distance; on the other side it is nearer. */
VXS_FN vxs_real vxs_between_taps(vxs_real at, vxs_filter pcf)
{
    vxs_real first = VXS_IS_SMOOTH(pcf) ? at - 0.5 * VXS_REAL(vxs_filter_width(pcf)) : at;
    return first - vxs_floor(first) - 0.5;
}

/* The voxel for the lookup of a point of a surface.
 * at      the point: texels, texels, voxels
 * normal  in texels, as above; of any length; no step if it is zero, or if one of its numbers is NaN */
VXS_FN void vxs_biased_voxel(VXS_LIGHT light, const vxs_real3 at, const vxs_real3 normal, vxs_filter pcf, VXS_OUT vxs_int3 voxel)
{
    vxs_real across = vxs_abs(normal[0]), down = vxs_abs(normal[1]), along = vxs_abs(normal[2]);
    vxs_real u = VXS_REAL(0.0), v = VXS_REAL(0.0), deep = vxs_floor(at[2]);
    if (across + down + along > 0.0) {
        vxs_real reach = vxs_filter_reach(pcf) + VXS_BIAS_SLACK, most = VXS_BIAS_ALONG * VXS_REAL(vxs_filter_width(pcf)) * along;

        /* Step across: the same for all points of a plane, so that edges of shadows keep their shape; up to half a texel too
         * short for some points. */
        vxs_real beyond = reach * (across + down) - most;
        if (beyond > 0.0) {
            beyond = beyond / (across * across + down * down);
            u      = vxs_floor(beyond * across + 0.5);
            v      = vxs_floor(beyond * down + 0.5);
        }

        /* Distance that is still missing for this point; with one more texel on each axis, it is at most the greatest step
         * along the light. */
        vxs_real missing = reach * (across + down) + vxs_between_taps(at[0], pcf) * normal[0] +
                           vxs_between_taps(at[1], pcf) * normal[1] - u * across - v * down;
        for (vxs_i32 n = 0; n < 2 && missing > most; n++) {
            vxs_i32 axis = across > down ? n : 1 - n;
            u += axis == 0 ? 1.0 : 0.0;
            v += axis == 0 ? 0.0 : 1.0;
            missing -= axis == 0 ? across : down;
        }

        /* Step along the light: towards it, or away from it for the back of a surface. */
        vxs_real voxels =
            (1.0 + VXS_BIAS_SLACK) * along + missing * (VXS_FIELD(light, texel_metres) / VXS_FIELD(light, voxel_metres));
        if (voxels > 0.0) {
            voxels = voxels / along;
            deep   = normal[2] < 0.0 ? vxs_floor(at[2] - voxels) : -1.0 - vxs_floor(-at[2] - voxels);
        }
    }
    voxel[0] = vxs_clamped(vxs_floor(at[0]) + (normal[0] < 0.0 ? -u : u));
    voxel[1] = vxs_clamped(vxs_floor(at[1]) + (normal[1] < 0.0 ? -v : v));
    voxel[2] = vxs_clamped(deep);
}

/* world to voxel, by the kind of light ---------------------------------------------------------------------------------------- */

VXS_FN vxs_place vxs_sun_place(VXS_LIGHT light, const vxs_real3 point_ws, const vxs_real3 normal_ws, vxs_filter pcf)
{
    vxs_real3 ls, normal;
    vxs_place place;
    vxs_i32   side = VXS_I(1) << VXS_FIELD(light, levels);
    vxs_ls_from_ws(light, point_ws, VXS_REAL(1.0), ls);
    vxs_ls_from_ws(light, normal_ws, VXS_REAL(0.0), normal);
    normal[2]    = normal[2] * (VXS_FIELD(light, voxel_metres) / VXS_FIELD(light, texel_metres));
    place.across = vxs_within(ls[0], pcf);
    place.down   = vxs_within(ls[1], pcf);
    vxs_biased_voxel(light, ls, normal, pcf, place.voxel);
    place.map = 0;
    if (place.voxel[0] < 0 || place.voxel[1] < 0 || place.voxel[0] >= side || place.voxel[1] >= side) place.map = -1;
    if ((VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u && (place.voxel[2] < 0 || place.voxel[2] >= side)) place.map = -1;
    return place;
}

/* 1 in the cone and range of a spot or point light, else 0; 0 also for NaN, and if the square of the distance overflows. */
VXS_FN vxs_i32 vxs_in_reach(VXS_LIGHT light, const vxs_real3 ls)
{
    vxs_real distance2 = ls[0] * ls[0] + ls[1] * ls[1] + ls[2] * ls[2];
    vxs_real range     = VXS_FIELD(light, range_metres);
    if (!(distance2 - distance2 == 0.0)) return 0;
    if (range > 0.0 && distance2 > range * range) return 0;
    return VXS_KIND(light) == VXS_LIGHT_KIND_POINT || ls[2] >= VXS_FIELD(light, cos_outer) * sqrt(distance2) ? 1 : 0;
}

/* u or v in the map of a spot or point light, for a point at `across` metres along that axis and z away from the light. */
VXS_FN vxs_real vxs_punctual_coordinate(VXS_LIGHT light, const vxs_real across, const vxs_real z)
{
    return 0.5 * VXS_REAL(VXS_I(1) << VXS_FIELD(light, levels)) + across / z / VXS_FIELD(light, texel_metres);
}

/* The nearest texel in the map. In maps of fewer than 256 texels the border is too narrow for some bias steps. */
VXS_FN vxs_i32 vxs_texel_in_map(VXS_LIGHT light, vxs_i32 texel)
{
    return vxs_clamp(texel, 0, (VXS_I(1) << VXS_FIELD(light, levels)) - 1);
}

/* Texels are z * texel_metres wide; voxels are z * voxel_metres deep, along the ray through the point: its direction is (p /
 * z, q / z, 1). */
VXS_FN vxs_place vxs_punctual_place(VXS_LIGHT light, const vxs_real3 point_ws, const vxs_real3 normal_ws, vxs_filter pcf)
{
    vxs_real3 ls, normal_ls, p, normal, at;
    vxs_place place;
    vxs_ls_from_ws(light, point_ws, VXS_REAL(1.0), ls);
    vxs_ls_from_ws(light, normal_ws, VXS_REAL(0.0), normal_ls);
    vxs_i32 map = vxs_map_from_ls(light, ls);
    vxs_face_from_ls(vxs_face_of_map(light, map), ls, p);
    vxs_face_from_ls(vxs_face_of_map(light, map), normal_ls, normal);

    vxs_real z = p[2] > VXS_REAL_MIN ? p[2] : VXS_REAL_MIN; /* the position of the light itself is lit */
    at[0]      = vxs_punctual_coordinate(light, p[0], z);
    at[1]      = vxs_punctual_coordinate(light, p[1], z);
    at[2]      = log(z / VXS_FIELD(light, near_metres)) / VXS_FIELD(light, voxel_metres);
    normal[2] += normal[0] * (p[0] / z) + normal[1] * (p[1] / z);
    place.across = vxs_within(at[0], pcf);
    place.down   = vxs_within(at[1], pcf);
    vxs_biased_voxel(light, at, normal, pcf, place.voxel);
    place.voxel[0] = vxs_texel_in_map(light, place.voxel[0]);
    place.voxel[1] = vxs_texel_in_map(light, place.voxel[1]);
    place.map      = vxs_in_reach(light, ls) != 0 ? map : -1;
    return place;
}

/* The place where a point is looked up.
 * point_ws   metres; in a shader, relative to the origin passed to vxs_light_constants_of
 * normal_ws  normal of the surface at the point, of any length: the place is moved off the surface, so that it does not
 *            shade itself (bias, above); (0, 0, 0) in the air
 * pcf        the filter of the lookup, as for vxs_lit */
VXS_FN vxs_place vxs_place_from_ws(VXS_LIGHT light, const vxs_real3 point_ws, const vxs_real3 normal_ws, vxs_filter pcf)
{
#ifdef VXS_HAS_SUNS
#ifdef VXS_HAS_PUNCTUAL
    if (VXS_KIND(light) != VXS_LIGHT_KIND_DIRECTIONAL) return vxs_punctual_place(light, point_ws, normal_ws, pcf);
#endif
    return vxs_sun_place(light, point_ws, normal_ws, pcf);
#else
    return vxs_punctual_place(light, point_ws, normal_ws, pcf);
#endif
}

/* The voxel of vxs_place_from_ws. Returns its map. */
VXS_FN vxs_i32 vxs_voxel_from_ws(VXS_LIGHT light, const vxs_real3 point_ws, const vxs_real3 normal_ws, vxs_filter pcf,
                                 VXS_OUT vxs_int3 voxel)
{
    vxs_place place = vxs_place_from_ws(light, point_ws, normal_ws, pcf);
    voxel[0]        = place.voxel[0];
    voxel[1]        = place.voxel[1];
    voxel[2]        = place.voxel[2];
    return place.map;
}

/* lookup ---------------------------------------------------------------------------------------------------------------------- */

/* Only the next four functions depend on the coding of the words. Without vxs_lookup_blocks.h all words are assumed to be
 * DAGs. */

#if defined(VXS_TABLES) && defined(VXS_HAS_BLOCKS)
#define VXS_READS_TABLES
#elif defined(VXS_LOOKUP_BLOCKS_H) && defined(VXS_HAS_BLOCKS)
#define VXS_READS_BLOCKS
#endif
#if defined(VXS_HAS_DAGS) && (defined(VXS_READS_TABLES) || defined(VXS_READS_BLOCKS))
#define VXS_READS_BOTH /* code for one coding alone is not compiled with a branch, since compilers inline both sides first */
#endif

/* Where the root of a map of a DAG is; or what vxs_tile takes for a map with tables. */
VXS_FN vxs_u32 vxs_root_of(VXS_WORDS dag, VXS_LIGHT light, const vxs_i32 map)
{
#ifdef VXS_READS_TABLES
    if (VXS_CODING(light) == VXS_CODING_BLOCKS) return vxs_table_root(dag, VXS_U(map), VXS_FIELD(light, levels));
#endif
    return VXS_IS_CUBE(light) ? vxs_face_root(dag, VXS_U(map)) : 0u;
}

/* 1 if voxel (i, j, k) of a map is in shadow, else 0; each of i, j, k in [0, 2^levels).   coded  the words of the light */
VXS_FN vxs_u32 vxs_shadow_tap(VXS_WORDS coded, VXS_LIGHT light, const vxs_i32 map, const vxs_i32 i, const vxs_i32 j,
                              const vxs_u32 k)
{
#ifdef VXS_READS_BOTH
    if (VXS_CODING(light) != VXS_CODING_BLOCKS)
        return vxs_shadow(coded, vxs_root_of(coded, light, map), VXS_FIELD(light, levels), VXS_U(i), VXS_U(j), k);
#endif
#if defined(VXS_READS_TABLES)
    return vxs_table_tap(vxs_root_of(coded, light, map), VXS_FIELD(light, levels), VXS_U(i), VXS_U(j), k);
#elif defined(VXS_READS_BLOCKS)
    return vxs_blocks_shadow(coded, VXS_U(map), VXS_FIELD(light, levels), VXS_U(i), VXS_U(j), k);
#else
    return vxs_shadow(coded, vxs_root_of(coded, light, map), VXS_FIELD(light, levels), VXS_U(i), VXS_U(j), k);
#endif
}

/* Number of the width_px x width_px texels centred on (i, j) of a map that are in shadow at depth k, [0, 2^levels).
 * coded  the words of the light
 * i, j   in the map if width_px is 1, else as for vxs_shadow_count;   width_px  odd, 1 to VXS_FILTER_MAX */
VXS_FN vxs_u32 vxs_shadow_taps(VXS_WORDS coded, VXS_LIGHT light, vxs_i32 map, vxs_i32 i, vxs_i32 j, vxs_u32 k, vxs_i32 width_px)
{
    vxs_u32 levels = VXS_FIELD(light, levels);
    if (VXS_WIDTH(width_px) == 1) return vxs_shadow_tap(coded, light, map, i, j, k);
#ifdef VXS_READS_BLOCKS
    else if (VXS_CODING(light) == VXS_CODING_BLOCKS)
        return vxs_blocks_shadow_count(coded, VXS_U(map), levels, i, j, k, width_px);
#endif
    else
        return vxs_shadow_count(coded, vxs_root_of(coded, light, map), levels, i, j, k, width_px);
}

/* Shadowed part of a smooth box of width_px x width_px texels around a place of a map at depth k, [0, 2^levels), in units of
 * 1 / (65536 width_px width_px). */
VXS_FN vxs_u32 vxs_shadow_part(VXS_WORDS coded, VXS_LIGHT light, vxs_place place, vxs_u32 k, vxs_i32 width_px)
{
    vxs_u32 levels = VXS_FIELD(light, levels);
    vxs_i32 i = place.voxel[0], j = place.voxel[1];
#ifdef VXS_READS_BLOCKS
#ifdef VXS_READS_BOTH
    if (VXS_CODING(light) != VXS_CODING_BLOCKS)
        return vxs_shadow_weight(coded, vxs_root_of(coded, light, place.map), levels, i, j, place.across, place.down, k, width_px);
#endif
    return vxs_blocks_shadow_weight(coded, VXS_U(place.map), levels, i, j, place.across, place.down, k, width_px);
#else
    return vxs_shadow_weight(coded, vxs_root_of(coded, light, place.map), levels, i, j, place.across, place.down, k, width_px);
#endif
}

/* The lit fraction, 0 to 1, of a filter around a place whose map is not -1. In front of the map all is lit; behind the map
 * the answer is that of its last voxels. pcf as for vxs_lit. */
VXS_FN vxs_real vxs_lit_at_place(VXS_WORDS coded, VXS_LIGHT light, vxs_place place, vxs_filter pcf)
{
    vxs_i32 last = (VXS_I(1) << VXS_FIELD(light, levels)) - 1, width = vxs_filter_width(pcf);
    if (place.voxel[2] < 0) return VXS_REAL(1.0);
    vxs_u32 k = VXS_U(place.voxel[2] < last ? place.voxel[2] : last), all = VXS_U(width * width), dark;
#ifdef VXS_C
    if (!VXS_IS_SMOOTH(pcf)) {
        dark = vxs_shadow_taps(coded, light, place.map, place.voxel[0], place.voxel[1], k, width);
        return VXS_REAL(all - dark) / VXS_REAL(all);
    }
#endif
    if (VXS_IS_SMOOTH(pcf) ||
        VXS_WIDTH(width) != 1) { /* one call for all, as it is inlined: a box is smooth about a texel's middle */
        if (!VXS_IS_SMOOTH(pcf)) place.across = place.down = 128u;
        all *= 65536u;
        dark = vxs_shadow_part(coded, light, place, k, width);
    } else
        dark = vxs_shadow_tap(coded, light, place.map, place.voxel[0], place.voxel[1], k);
    return VXS_REAL(all - dark) / VXS_REAL(all);
}

/* The same around the middle of a voxel of a map. */
VXS_FN vxs_real vxs_lit_at_voxel(VXS_WORDS coded, VXS_LIGHT light, vxs_i32 map, const vxs_int3 voxel, vxs_filter pcf)
{
    vxs_place place;
    place.map      = map;
    place.voxel[0] = voxel[0];
    place.voxel[1] = voxel[1];
    place.voxel[2] = voxel[2];
    place.across   = 128u;
    place.down     = 128u;
    return vxs_lit_at_place(coded, light, place, pcf);
}

/* The lit fraction around a point; VXS_OUTSIDE if it is outside the volume of the light. Point and normal as for
 * vxs_place_from_ws.
 * pcf  vxs_box(K) or vxs_smooth(K) */
VXS_FN vxs_real vxs_lit(VXS_WORDS coded, VXS_LIGHT light, const vxs_real3 point_ws, const vxs_real3 normal_ws, vxs_filter pcf)
{
    vxs_place place = vxs_place_from_ws(light, point_ws, normal_ws, pcf);
    if (place.map < 0) return VXS_REAL(VXS_OUTSIDE);
    return vxs_lit_at_place(coded, light, place, pcf);
}

/* Whether vxs_lit_at_place is exact for these arguments: 1; 0 if pages that it needs are missing and its answer is coarse. */
VXS_FN vxs_i32 vxs_is_full_at_place(VXS_WORDS coded, VXS_LIGHT light, vxs_place place, vxs_filter pcf)
{
#ifdef VXS_READS_BLOCKS
    vxs_u32 levels = VXS_FIELD(light, levels), map = VXS_U(place.map);
    vxs_i32 last = (VXS_I(1) << levels) - 1, width = vxs_filter_width(pcf), i = place.voxel[0], j = place.voxel[1];
    if (VXS_CODING(light) != VXS_CODING_BLOCKS || place.voxel[2] < 0) return 1;
    vxs_u32 k = VXS_U(place.voxel[2] < last ? place.voxel[2] : last);
    if (VXS_IS_SMOOTH(pcf))
        return VXS_I(vxs_blocks_weight_is_full(coded, map, levels, i, j, place.across, place.down, k, width));
    else
        return VXS_I(vxs_blocks_is_full(coded, map, levels, i, j, k, width));
#elif defined(VXS_GL_STREAM)
    uint levels = light.levels, width = uint(vxs_filter_width(pcf)), last = (1u << levels) - 1u;
    if (VXS_CODING(light) != VXS_CODING_BLOCKS || place.voxel.z < 0) return 1;
    if (pcf.is_smooth == 0) place.across = place.down = 128u;
    vxs_smooth_box box   = vxs_smooth_box_at(place.voxel.x, place.voxel.y, place.across, place.down, int(width));
    ivec2          begin = ivec2(box.x, box.y), end = begin + int(width) + ivec2(box.across != 0u, box.down != 0u);
    return vxs_table_is_known(vxs_root_of(coded, light, place.map), levels, begin, end, min(uint(place.voxel.z), last)) ? 1 : 0;
#else
    return 1;
#endif
}

/* The same for vxs_lit. 1 outside the volume of the light. */
VXS_FN vxs_i32 vxs_lit_is_full(VXS_WORDS coded, VXS_LIGHT light, const vxs_real3 point_ws, const vxs_real3 normal_ws,
                               vxs_filter pcf)
{
    vxs_place place = vxs_place_from_ws(light, point_ws, normal_ws, pcf);
    return place.map < 0 ? 1 : vxs_is_full_at_place(coded, light, place, pcf);
}

/* voxel to world -------------------------------------------------------------------------------------------------------------- */

#ifdef VXS_C
/* A cofactor of the matrix without its last column. */
VXS_FN vxs_real vxs_cofactor(VXS_LIGHT light, vxs_i32 row, vxs_i32 column)
{
    vxs_i32 a = (row + 1) % 3, b = (row + 2) % 3, c = (column + 1) % 3, d = (column + 2) % 3;
    return VXS_LS_FROM_WS(light, a, c) * VXS_LS_FROM_WS(light, b, d) - VXS_LS_FROM_WS(light, a, d) * VXS_LS_FROM_WS(light, b, c);
}

/* A coordinate in world space; `from` is a point of light space minus the world's origin in light space. */
VXS_FN vxs_real vxs_ws_coordinate(VXS_LIGHT light, const vxs_real3 from, vxs_i32 column)
{
    vxs_real determinant = VXS_LS_FROM_WS(light, 0, 0) * vxs_cofactor(light, 0, 0) +
                           VXS_LS_FROM_WS(light, 0, 1) * vxs_cofactor(light, 0, 1) +
                           VXS_LS_FROM_WS(light, 0, 2) * vxs_cofactor(light, 0, 2);
    return (from[0] * vxs_cofactor(light, 0, column) + from[1] * vxs_cofactor(light, 1, column) +
            from[2] * vxs_cofactor(light, 2, column)) /
           determinant;
}
#else
vxs_real vxs_ws_coordinate(VXS_LIGHT light, const vxs_real3 from, const vxs_i32 column)
{
    vxs_real3 a = light.ls_from_ws[0].xyz, b = light.ls_from_ws[1].xyz, c = light.ls_from_ws[2].xyz, across = cross(b, c);
    vxs_real3 ws = from[0] * across + from[1] * cross(c, a) + from[2] * cross(a, b);
    return ws[column] / dot(a, across);
}
#endif

/* The point in world space of map coordinates: texels u, v and depth in voxels, which may have fractions. */
VXS_FN void vxs_ws_from_voxel(VXS_LIGHT light, vxs_i32 map, const vxs_real3 at, VXS_OUT vxs_real3 point_ws)
{
    vxs_real3 ls, from;
    ls[0] = at[0];
    ls[1] = at[1];
    ls[2] = at[2];
    if (VXS_KIND(light) != VXS_LIGHT_KIND_DIRECTIONAL) {
        vxs_real3 p;
        vxs_real  middle = 0.5 * VXS_REAL(VXS_I(1) << VXS_FIELD(light, levels));
        p[2]             = VXS_FIELD(light, near_metres) * exp(at[2] * VXS_FIELD(light, voxel_metres));
        p[0]             = (at[0] - middle) * VXS_FIELD(light, texel_metres) * p[2];
        p[1]             = (at[1] - middle) * VXS_FIELD(light, texel_metres) * p[2];
        vxs_ls_from_face(vxs_face_of_map(light, map), p, ls);
    }
    from[0]     = ls[0] - VXS_LS_FROM_WS(light, 0, 3);
    from[1]     = ls[1] - VXS_LS_FROM_WS(light, 1, 3);
    from[2]     = ls[2] - VXS_LS_FROM_WS(light, 2, 3);
    point_ws[0] = vxs_ws_coordinate(light, from, 0);
    point_ws[1] = vxs_ws_coordinate(light, from, 1);
    point_ws[2] = vxs_ws_coordinate(light, from, 2);
}

#endif
