/* Where shadow begins on a light ray, of the asset: along a column it is lit first, and then it is not, so that lookups find it by bisection. */

/* The voxel of a texel of the baked map, [0, 2^levels]; 2^levels: light does not end. */
int vxs_first_shadow(vxs_light_constants light, int map, int i, int j)
{
    int first = 0, end = 1 << light.levels;
    while (first < end) {
        int middle = (first + end) >> 1;
        if (vxs_shadow_taps(light.first_word, light, map, i, j, uint(middle), 1) != 0u)
            end = middle;
        else
            first = middle + 1;
    }
    return first;
}

/* The same as light maps have it: of suns in voxels, of lamps in metres along the axis of the map. */
float vxs_first_depth(vxs_light_constants light, int voxel)
{
    if (voxel >= 1 << light.levels) return VXS_NO_END;
    return light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? float(voxel) : light.near_metres * exp(float(voxel) * light.voxel_metres);
}
