#include "first_shadow.glsl"

/* What vxs_first_shadow returns, in units of shadow depth maps: for suns in voxels, for punctual lights in metres along the axis of
 * the map. */
float vxs_first_depth(vxs_light_constants light, int voxel)
{
    if (voxel >= 1 << light.levels) return VXS_NO_END;
    return VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL ? float(voxel) : light.near_metres * exp(float(voxel) * light.voxel_metres);
}
