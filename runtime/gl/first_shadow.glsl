/* Where shadow begins on a light ray in the asset, for depth pages and volumes: from tables, or by bisection of lookups, as a column
 * is lit up to a voxel, and in shadow from there on. */

/* The first voxel in shadow of a texel of the baked map, [0, 2^levels]; 2^levels: light does not end. */
int vxs_first_shadow(VXS_LIGHT light, int map, int i, int j)
{
#ifdef VXS_TABLES
    if (VXS_CODING(light) == VXS_CODING_BLOCKS)
        return vxs_table_depth(vxs_root_of(light.first_word, light, map), light.levels, uint(i), uint(j));
#endif
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
