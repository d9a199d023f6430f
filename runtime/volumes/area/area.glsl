/* Virtual point lights with the heads of their grids, and words: of all grids, then of all imperfect shadow maps. As in
 * area_state.h. */
#include "area_pass.glsl"
#include "grid_space.glsl"

struct vxs_vpl {
    vec4  axis, ahead, side, alpha_theta, phi; /* of a grid, as in grid.glsl */
    ivec4 size, eye, reserved;
    vec4  place;  /* and radius */
    vec4  normal; /* and how it emits: 0 in all directions, 1 to one side, 2 along the normal from far away */
    vec4  colour; /* and 1 + index of the light whose baked smoke dims it; 0: none */
    vec4  across; /* the normal, of length 1 */
};

#ifdef VXS_USES_CURVES /* they are after the first binding */
#define VXS_AT_AREA (VXS_AT_GRID + 2)
#else
#define VXS_AT_AREA VXS_AT_GRID
#endif
layout(std430, binding = VXS_AT_AREA) VXS_GRID_ACCESS buffer vxs_area_buffer {
    vxs_vpl vpls[256];
    uint          words[];
} vxs_area;

/* How a VPL emits. A program may be for VPLs that emit in one way: then it has no code for others. */
#ifdef VXS_AREA_EMITS
#define vxs_area_emits(vpl) VXS_AREA_EMITS
#else
#define vxs_area_emits(vpl) vxs_area.vpls[vpl].normal.w
#endif
#define vxs_area_is_far(vpl) (vxs_area_emits(vpl) == 2.0)

#define vxs_grid_word(words, i) vxs_area.words[(words) + uint(i)]

#if defined(VXS_GL_SMOKE) && defined(VXS_AREA_TAKES_MAPS)
#define VXS_AREA_BAKED
#endif
#if defined(VXS_AREA_GATHERS) && (defined(VXS_USES_CURVES) || defined(VXS_AREA_BAKED))
/* The current VPL and eye ray, and below the transmittance of the VPL's smoke along the ray. */
uint  vxs_vpl_now;
vec3  vxs_area_direction;
float vxs_area_left(uint vpl, vec3 at);
#define vxs_grid_left(metres) vxs_area_left(vxs_vpl_now, vxs_frame.eye_far.xyz + (metres) * vxs_area_direction)
#endif

vxs_epipolar vxs_area_space(uint vpl)
{
    return vxs_grid_space_of(vxs_area.vpls[vpl].axis, vxs_area.vpls[vpl].ahead, vxs_area.vpls[vpl].side,
                             vxs_area.vpls[vpl].alpha_theta, vxs_area.vpls[vpl].phi);
}

/* A vector from a VPL in its frame: across, up, along its normal. */
vec3 vxs_area_way(uint vpl, vec3 way)
{
    vec3 normal = vxs_area.vpls[vpl].normal.xyz, across = vxs_area.vpls[vpl].across.xyz;
    return vec3(dot(across, way), dot(cross(normal, across), way), dot(normal, way));
}

/* Position in the imperfect shadow map of a distant VPL, which covers the sphere around all casters; in texels.
 * way  from the sphere's middle, in the VPL's frame */
vec2 vxs_area_far_texel(uint vpl, vec3 way, int side)
{
    return 0.5 * float(side) * (1.0 + way.xy / vxs_area.vpls[vpl].place.w);
}

/* The first word of level n of a VPL's imperfect shadow map; levels are stored in order.   maps  the first word of all maps */
uint vxs_area_level(uint maps, uint vpl, uint side, uint n)
{
    uint part = side >> n;
    return maps + vpl * ((4u * side * side - 1u) / 3u) + 4u * (side * side - part * part) / 3u;
}
