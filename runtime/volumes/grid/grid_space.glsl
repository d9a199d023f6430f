/* The space of a voxelized shadow volume from the head of its buffer, for one grid or for those of an area light. */
#include "vxs_epipolar.h"

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
