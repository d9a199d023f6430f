/* A voxelized shadow volume in a storage buffer: what shadow_grid.c fills its head with, and words behind it. */
#ifndef VXS_GRID_ACCESS
#define VXS_GRID_ACCESS
#endif
layout(std430, binding = VXS_AT_GRID) VXS_GRID_ACCESS buffer vxs_grid_buffer {
    vec4  axis; /* and metres to the lamp; 0: a sun */
    vec4  ahead, side;
    vec4  alpha_theta;
    vec4  phi;
    ivec4 size; /* columns, rows, bits; runs of the lookup */
    ivec4 eye;  /* whether the light reaches it, as for vxs_grid_airlight; 1: rays lie between two rows */
    ivec4 reserved;
    uint  words[];
} vxs_grid;

vxs_epipolar vxs_grid_space()
{
    vxs_epipolar space;
    space.axis  = vxs_grid.axis.xyz;
    space.ahead = vxs_grid.ahead.xyz;
    space.side  = vxs_grid.side.xyz;
    space.away  = vxs_grid.axis.w;
    space.alpha = vxs_grid.alpha_theta.xy;
    space.theta = vxs_grid.alpha_theta.zw;
    space.phi   = vxs_grid.phi.xy;
    return space;
}
