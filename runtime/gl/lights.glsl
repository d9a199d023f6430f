/* Lights, and the lists of lights for tiles, as vxs_cull of vxs_gl.h makes them. Compiled behind vxs_cull.h. Light numbers and
 * list indices are clamped, so that a pixel outside the view, or lists made for other lights, only give a wrong light. */
#ifdef VXS_GL_BUFFERS
layout(std430, binding = VXS_GL_AT_LIGHTS) readonly restrict buffer vxs_lights_block { vxs_light_constants vxs_lights[]; };
#define VXS_GL_LIGHT_COUNT uint(vxs_lights.length())
#ifndef VXS_GL_CULL
layout(std430, binding = VXS_GL_AT_LISTS) readonly restrict buffer vxs_lists_block { uint vxs_lists[]; };
uint vxs_list_word(uint at)
{
    return vxs_lists[min(at, max(uint(vxs_lists.length()), 1u) - 1u)];
}
#endif
vxs_light_constants vxs_light_at(uint n)
{
    return vxs_lights[min(n, VXS_GL_LIGHT_COUNT - 1u)];
}
#else
uniform usampler2D vxs_lights; /* 64 lights in a row, 6 texels each */
uniform usampler2D vxs_lists;
uint vxs_list_word(uint at)
{
    return texelFetch(vxs_lists, ivec2(int(at & 2047u), min(int(at >> 11), textureSize(vxs_lists, 0).y - 1)), 0).r;
}
vxs_light_constants vxs_light_at(uint n)
{
    n = min(n, VXS_GL_LIGHT_COUNT - 1u);
    ivec2 at = ivec2(int(n & 63u) * 6, int(n >> 6));
    return vxs_light_of_texels(texelFetch(vxs_lights, at, 0), texelFetch(vxs_lights, at + ivec2(1, 0), 0), texelFetch(vxs_lights, at + ivec2(2, 0), 0),
                               texelFetch(vxs_lights, at + ivec2(3, 0), 0), texelFetch(vxs_lights, at + ivec2(4, 0), 0), texelFetch(vxs_lights, at + ivec2(5, 0), 0));
}
#endif

uint vxs_light_count()
{
    return VXS_GL_LIGHT_COUNT;
}

float vxs_lit_by(uint n, vec3 at, vec3 normal, vxs_filter pcf)
{
    vxs_light_constants light = vxs_light_at(n);
    return vxs_lit(light.first_word, light, at, normal, pcf);
}

/* Transmittance of light n's smoke at a point, 0 to 1. */
float vxs_smoke_left_by(uint n, vec3 at)
{
#ifdef VXS_GL_SMOKE
    uint smoke = vxs_word(vxs_word(VXS_GL_LAST_WORD, 0u), min(n, VXS_GL_LIGHT_COUNT - 1u));
    if (smoke != 0u) return vxs_smoke_left(smoke, vxs_light_at(n), at);
#endif
    return 1.0;
}

#ifndef VXS_GL_CULL
/* When a tile's count is above tile_lights, its list is incomplete, and all lights are used. */
uint vxs_tile_of(ivec2 pixel)
{
    return 4u + (uint(pixel.y >> 3) * vxs_list_word(0u) + uint(pixel.x >> 3)) * (vxs_list_word(2u) + 1u);
}

uint vxs_tile_light_count(uint tile)
{
    uint count = vxs_list_word(tile);
    return count > vxs_list_word(2u) ? VXS_GL_LIGHT_COUNT : count;
}

uint vxs_tile_light(uint tile, uint n)
{
    return vxs_list_word(tile) > vxs_list_word(2u) ? n : vxs_list_word(tile + 1u + n);
}
#endif
