/* A voxelized shadow volume in a storage buffer: a head that shadow_grid.c fills, then words. */
#ifndef VXS_GRID_ACCESS
#define VXS_GRID_ACCESS
#endif

vxs_epipolar vxs_grid_space_of(vec4 axis, vec4 ahead, vec4 side, vec4 alpha_theta, vec4 phi)
{
    vxs_epipolar space;
    space.axis  = axis.xyz;
    space.ahead = ahead.xyz;
    space.side  = side.xyz;
    space.away  = axis.w;
    space.alpha = alpha_theta.xy;
    space.theta = alpha_theta.zw;
    space.phi   = phi.xy;
    return space;
}

#ifndef VXS_USES_AREA
layout(std430, binding = VXS_AT_GRID) VXS_GRID_ACCESS buffer vxs_grid_buffer {
    vec4  axis; /* and metres to the lamp; 0: a sun */
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
#endif
