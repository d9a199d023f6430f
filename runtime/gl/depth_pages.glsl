/* Lookups in depth pages (vxs_gl_depths.h). Compiled behind the texts of vxs_gl_texts and the constants of gl_depth_pages.c.
 *
 * Words of the page table:
 *
 *     0..7      eye, width of a pixel; 4 that are not used
 *     info      4 for each page: least and greatest depth of its shadowed texels; 1 if squares of it are missing; base | shift << 24
 *     bounds    for each tile of 8 x 8 texels of each page: least and greatest depth of the tile and the texels around it
 *     lights    for each light: the word where its table starts
 *     tables    for each map, for each level: a window of at most 64 x 64 pages, by rows; page (x, y) is at (x & 63, y & 63):
 *               0, or page of the atlas + 1 | (x >> 6) << 16 | (y >> 6) << 21
 *
 * A texel of the atlas is (depth - base) >> shift, rounded up, or 65535 if it has no shadow. */
#ifndef VXS_PAGES_ACCESS
#define VXS_PAGES_ACCESS readonly restrict
#endif
layout(std430, binding = VXS_PAGES_AT) VXS_PAGES_ACCESS buffer vxs_pages_block { uint vxs_pages[]; };

#define VXS_PAGES_INFO   8u
#define VXS_PAGES_BOUNDS (VXS_PAGES_INFO + 4u * VXS_PAGES_ROOM)
#define VXS_PAGES_LIGHTS (VXS_PAGES_BOUNDS + 512u * VXS_PAGES_ROOM)

/* A light whose map is level `level` of the map of `light`. */
vxs_light_constants vxs_light_of_level(vxs_light_constants light, const uint level)
{
    float wider = float(1u << level), part = uintBitsToFloat((127u - level) << 23); /* 1 / wider: a division need not be exact */
    for (int row = 0; row < 3 && VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL; row++) light.ls_from_ws[row] *= part;
    light.texel_metres *= wider;
    light.voxel_metres *= wider;
    light.levels -= level;
    return light;
}

uint vxs_last_level(const vxs_light_constants light)
{
    return max(light.levels, 7u) - 7u;
}

uint vxs_depth_level(const uint n, const vec3 at)
{
    vxs_light_constants light = vxs_light_at(n);
    vec3  eye = uintBitsToFloat(uvec3(vxs_pages[0], vxs_pages[1], vxs_pages[2]));
    float px  = distance(at, eye) * uintBitsToFloat(vxs_pages[3]), texel = light.texel_metres;
    if (VXS_KIND(light) != VXS_LIGHT_KIND_DIRECTIONAL) {
        vec3 ls;
        vxs_ls_from_ws(light, at, 1.0, ls);
        texel *= VXS_IS_CUBE(light) ? max(max(abs(ls.x), abs(ls.y)), abs(ls.z)) : ls.z;
    }
    uint level = 0u;
    for (uint last = vxs_last_level(light); level < last && 2.0 * texel <= px; level++) texel *= 2.0;
    return level;
}

/* Word of the page table for page `page` of a level of map `map` of light n. Level L has 4^e pages, at most 4^6 of which are in the
 * table at a time. */
uint vxs_page_entry(const uint n, const vxs_light_constants light, const uint map, const uint level, const uvec2 page)
{
    uint last = vxs_last_level(light), wide = max(last, 6u) - 6u, narrow = min(last, 6u); /* levels of more than 64 pages a side */
    uint all  = (wide << 12) + ((4u << (2u * narrow)) - 1u) / 3u, e = min(last - level, 6u);
    uint before = level <= wide ? level << 12 : all - ((4u << (2u * (last - level))) - 1u) / 3u;
    return vxs_pages[VXS_PAGES_LIGHTS + n] + map * all + before + ((page.y & ((1u << e) - 1u)) << e) + (page.x & ((1u << e) - 1u));
}

uint vxs_page_tag(const uvec2 page)
{
    return ((page.x >> 6) << 16) | ((page.y >> 6) << 21);
}

#ifndef VXS_PAGES_FILL
layout(binding = VXS_PAGES_UNIT) uniform highp sampler2DShadow vxs_pages_atlas;

/* Taps of a filter: texels from `first` on; all but the first and the last of each row and column count by `whole`. */
struct vxs_taps {
    ivec2 first;
    int   width_px;
    vec2  part;  /* of the first texel that is not covered, times `whole` */
    float whole; /* 256, or 1 for a box of whole texels */
};

vxs_taps vxs_taps_of(const vxs_place place, const vxs_filter pcf)
{
    vxs_taps taps;
    taps.width_px = vxs_filter_width(pcf);
    taps.first    = ivec2(place.voxel[0], place.voxel[1]) - taps.width_px / 2;
    taps.part     = vec2(0.0);
    taps.whole    = 1.0;
    if (VXS_IS_SMOOTH(pcf)) {
        vxs_smooth_box box = vxs_smooth_box_at(place.voxel[0], place.voxel[1], place.across, place.down, taps.width_px);
        taps.first = ivec2(box.x, box.y);
        taps.part  = vec2(float(box.across), float(box.down));
        taps.whole = 256.0;
    }
    return taps;
}

/* Weight of texels n, counted from the first one. */
vec2 vxs_tap_weights(const vxs_taps taps, const vec2 n, const float part)
{
    return clamp(min(taps.whole * (n + 1.0) - part, taps.whole * (float(taps.width_px) - n) + part), 0.0, taps.whole);
}

/* Lit part of the taps in the atlas.   at  of the first tap;   depth  as the atlas has it */
float vxs_lit_in_page(const vxs_taps taps, const vec2 at, const float depth)
{
    float lit = 0.0, across = float(taps.width_px) * taps.whole;
    for (int y = 0; y <= taps.width_px; y += 2) {
        vec2 rows = vxs_tap_weights(taps, vec2(y, y + 1), taps.part.y);
        for (int x = 0; x <= taps.width_px; x += 2) {
            vec2 columns = vxs_tap_weights(taps, vec2(x, x + 1), taps.part.x);
            vec4 four    = textureGather(vxs_pages_atlas, (at + vec2(x, y) + 1.0) / VXS_PAGES_PX, depth);
            lit += dot(four, vec4(columns, columns.yx) * rows.yyxx);
        }
    }
    return lit / (across * across);
}

#ifndef VXS_PAGES_ALONE
/* Texels of a tile of the baked map that are in shadow at depth k.   root  vxs_root_of the map;   at  a texel of the tile */
vxs_mask vxs_tile_at(const vxs_light_constants light, const int map, const uint root, const uvec2 at, const uint k)
{
#ifdef VXS_READS_BLOCKS
    if (VXS_CODING(light) == VXS_CODING_BLOCKS) {
        vxs_blocks_node node = vxs_blocks_find_node(light.first_word, uint(map), light.levels, at.x >> 8, at.y >> 8, int(k));
        vxs_blocks_block block = vxs_blocks_find_block(light.first_word, node, ((at.x >> 5) & 7u) | (((at.y >> 5) & 7u) << 3));
        return vxs_blocks_slice(light.first_word, node, block, at.x >> 3, at.y >> 3, 0u, 32u);
    }
#endif
    return vxs_tile(light.first_word, root, light.levels, at.x >> 3, at.y >> 3, k);
}

/* The same by the words, tile by tile of the baked map. A texel of a level is the one in the middle of 2^level x 2^level of that
 * map.   k  at the level */
float vxs_lit_by_words(const vxs_taps taps, const vxs_light_constants light, const uint level, const int map, const int k)
{
    int   wide = 1 << level, step = max(wide, 8), side = 1 << (light.levels - level), width = taps.width_px;
    uint  root = vxs_root_of(light.first_word, light, map), deep = uint(((k + 1) << level) - 1), dark = 0u;
    uvec2 middles = uvec2[5](uvec2(0xffffffffu), uvec2(0xaa00aa00u), uvec2(0x440000u), uvec2(0u, 0x10u), uvec2(1u, 0u))[min(level, 4u)];
    ivec2 first = taps.first << level, end = min(taps.first + width + ivec2(greaterThan(taps.part, vec2(0.0))), side) << level;
    ivec2 from = (max(first, 0) & -step) + (level > 3u ? wide >> 1 : 0), at = from;
    vxs_smooth_box box;
    box.across = uint(taps.part.x);
    box.down   = uint(taps.part.y);
    while (at.y < end.y && at.x < end.x) { /* one loop, as in vxs_shadow_weight */
        vxs_mask mask = vxs_tile_at(light, map, root, uvec2(at), deep);
        mask.low &= middles.x;
        mask.high &= middles.y;
        dark += vxs_weigh_mask(mask, box, first.x - at.x, first.y - at.y, width, wide);
        at = at.x + step < end.x ? ivec2(at.x + step, at.y) : ivec2(from.x, at.y + step);
    }
    uint all = 65536u * uint(width * width);
    return float(all - dark) / float(all);
}
#endif

float vxs_paged_lit(const uint n, uint level, const vec3 at, const vec3 normal, const vxs_filter pcf)
{
    vxs_light_constants light = vxs_light_at(n);
    level = min(level, vxs_last_level(light));
    vxs_light_constants coarser = vxs_light_of_level(light, level);
    vxs_place           place   = vxs_place_from_ws(coarser, at, normal, pcf);
    if (place.map < 0) return VXS_OUTSIDE;
    if (place.voxel[2] < 0) return 1.0;

    vxs_taps taps  = vxs_taps_of(place, pcf);
    int      k     = min(place.voxel[2], (1 << coarser.levels) - 1);
    uvec2    texel = uvec2(place.voxel[0], place.voxel[1]), page = texel >> 7u;
    uint     entry = vxs_pages[vxs_page_entry(n, light, uint(place.map), level, page)];
    uint     slot  = (entry & 0xffffu) - 1u;
    if (slot < VXS_PAGES_ROOM && (entry & 0xffff0000u) == vxs_page_tag(page) &&
        taps.width_px + (VXS_IS_SMOOTH(pcf) ? 1 : 0) <= VXS_PAGES_WIDEST) {
        uint tile  = VXS_PAGES_BOUNDS + 512u * slot + 2u * (((texel.y >> 3) & 15u) * 16u + ((texel.x >> 3) & 15u));
        uint least = vxs_pages[tile], greatest = vxs_pages[tile + 1u];
        if (uint(k) < least) return 1.0;
        if (uint(k) >= greatest) return 0.0;
        uint info = vxs_pages[VXS_PAGES_INFO + 4u * slot + 3u];
        if (info != 0xffffffffu) {
            uvec2 corner = uvec2(slot % VXS_PAGES_COLUMNS, slot / VXS_PAGES_COLUMNS) * VXS_PAGES_STRIDE + VXS_PAGES_BORDER;
            ivec2 within = taps.first - ivec2(texel & ~127u);
            int   deep   = (k - int(info & 0xffffffu)) >> (info >> 24);
            return deep < 0 ? 1.0 : vxs_lit_in_page(taps, vec2(ivec2(corner) + within), (float(min(deep, 65534)) + 0.5) / 65535.0);
        }
    }
#ifdef VXS_PAGES_ALONE
    return 1.0;
#else
#ifdef VXS_READS_BLOCKS /* many words are faster to read for all tiles of a block */
    if (level == 0u) return vxs_lit_at_place(light.first_word, light, place, pcf);
#endif
    return vxs_lit_by_words(taps, light, level, place.map, k);
#endif
}

float vxs_paged_lit_by(const uint n, const vec3 at, const vec3 normal, const vxs_filter pcf)
{
    return vxs_paged_lit(n, vxs_depth_level(n, at), at, normal, pcf);
}
#endif
