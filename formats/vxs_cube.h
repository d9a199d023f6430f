/* How the six maps of a cube lie in light space (formats/vxs.md section 2): for whoever looks maps up or makes them.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_CUBE_H
#define VXS_CUBE_H

#include "vxs_file.h"

/* Which axes of light space a map has for u, v and away from the light, and the sign of the last; right-handed in each. Map 2a looks
 * along axis a, map 2a + 1 against it. */
typedef struct vxs_map_axes {
    int u, v, along, sign;
} vxs_map_axes;

/* Of map `map` of a spot or point light. The one map of a light without six has the axes of light space, as map 4 has. */
static inline vxs_map_axes vxs_axes_of_map(const vxs_light *light, int map)
{
    static const vxs_map_axes cube[VXS_CUBE_FACES] = {{1, 2, 0, 1},  {2, 1, 0, -1}, {2, 0, 1, 1},
                                                      {0, 2, 1, -1}, {0, 1, 2, 1},  {1, 0, 2, -1}};
    return cube[light->flags & VXS_LIGHT_CUBE ? map : 4];
}

#endif
