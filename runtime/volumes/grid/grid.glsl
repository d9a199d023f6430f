/* A voxelized shadow volume in a storage buffer: a head that shadow_grid.c fills, then words. */
#include "frame.glsl"
#include "grid_space.glsl"

#define vxs_grid_word(words, i) vxs_grid.words[i]

layout(std430, binding = VXS_AT_GRID) VXS_GRID_ACCESS buffer vxs_grid_buffer {
    vec4  axis; /* and metres to the light; 0: a sun */
    vec4  ahead, side;
    vec4  alpha_theta;
    vec4  phi;
    ivec4 size; /* columns, rows, bits; runs of the lookup */
    ivec4 eye;  /* whether the light reaches the eye, as for vxs_grid_airlight; 1: interpolates between two rows */
    uvec4 cut;  /* number of voxelizer invocations whose loops a driver ended */
    uint  words[];
} vxs_grid;

vxs_epipolar vxs_grid_space()
{
    return vxs_grid_space_of(vxs_grid.axis, vxs_grid.ahead, vxs_grid.side, vxs_grid.alpha_theta, vxs_grid.phi);
}
