/* Finds by bisection of lookups where shadow begins on a light ray in the asset: a column is lit up to a voxel, and in shadow
 * from there on. */

/* The first voxel in shadow of a texel of the baked map, [0, 2^levels]; 2^levels: light does not end. */
int vxs_first_shadow(vxs_light_constants light, int map, int i, int j)
{
    int first = 0, end = 1 << light.levels;
    while (first < end) {
        int middle = (first + end) >> 1;
        if (vxs_shadow_tap(light.first_word, light, map, i, j, uint(middle)) != 0u)
            end = middle;
        else
            first = middle + 1;
    }
    return first;
}

/* The same in units of shadow depth maps: for suns in voxels, for punctual lights in metres along the axis of the map. */
float vxs_first_depth(vxs_light_constants light, int voxel)
{
    if (voxel >= 1 << light.levels) return VXS_NO_END;
    return VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL ? float(voxel) : light.near_metres * exp(float(voxel) * light.voxel_metres);
}
