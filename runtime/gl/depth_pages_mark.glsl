/* Lists the pages that the pixels of a view need, each once. Compiled behind depth_pages.glsl with VXS_PAGES_FILL and view.glsl. */
layout(local_size_x = 8, local_size_y = 8) in;
/* The number of listed pages; frame of the marks; two that are not used; then 4 words for each listed page: light, map | level << 8,
 * x | y << 16, word of the page table; then, for each word of the tables, the tag and frame of its last mark */
layout(std430, binding = VXS_PAGES_AT_WORK) coherent restrict buffer vxs_marks_block { uint vxs_marks[]; };
uniform int vxs_by_lists;

void vxs_mark_page(uint n, vxs_light_constants light, uint map, uint level, uvec2 page)
{
    uint word  = vxs_page_entry(n, light, map, level, page), tag = vxs_page_tag(page);
    uint stamp = 4u + 4u * VXS_PAGES_LISTED + word - vxs_pages[VXS_PAGES_LIGHTS], mark = tag | (vxs_marks[1] & 0xffffu);
    if (vxs_marks[stamp] == mark || atomicExchange(vxs_marks[stamp], mark) == mark) return;
    uint at_list = atomicAdd(vxs_marks[0], 1u);
    if (at_list >= VXS_PAGES_LISTED) return;
    uint first = 4u + 4u * at_list, entry = vxs_pages[word], slot = (entry & 0xffffu) - 1u;
    bool is_partial = slot < VXS_PAGES_ROOM && (entry & 0xffff0000u) == tag &&
                      vxs_pages[VXS_PAGES_INFO + 4u * slot + 3u] == 0xffffffffu; /* decode again what lacked words */
    vxs_marks[first]      = n;
    vxs_marks[first + 1u] = map | (level << 8) | (is_partial ? 0x80000000u : 0u);
    vxs_marks[first + 2u] = page.x | (page.y << 16);
    vxs_marks[first + 3u] = word;
}

/* The page of a point, and those that a lookup with a normal may move it to. */
void vxs_mark(uint n, vec3 at)
{
    vxs_light_constants light   = vxs_light_at(n);
    uint                level   = vxs_depth_level(n, at);
    vxs_light_constants coarser = vxs_light_of_level(light, level);
    vxs_place           place   = vxs_place_from_ws(coarser, at, vec3(0.0), vxs_box(1));
    if (place.map < 0 || place.voxel[2] < 0) return;
    ivec2 texel = ivec2(place.voxel[0], place.voxel[1]), last = ivec2((1 << coarser.levels) - 1), step = ivec2(VXS_PAGES_BORDER + 2u);
    uvec2 low   = uvec2(max(texel - step, ivec2(0))) >> 7u, high = uvec2(min(texel + step, last)) >> 7u;
    for (uint y = low.y; y <= high.y; y++)
        for (uint x = low.x; x <= high.x; x++) vxs_mark_page(n, light, uint(place.map), level, uvec2(x, y));
}

void main()
{
    vec3  at;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!vxs_pixel_point(pixel, at)) return;
    uint tile = vxs_by_lists != 0 ? vxs_tile_of(pixel) : 0u;
    uint count = vxs_by_lists != 0 ? vxs_tile_light_count(tile) : vxs_light_count();
    for (uint n = 0u; n < count; n++) vxs_mark(vxs_by_lists != 0 ? vxs_tile_light(tile, n) : n, at);
}
