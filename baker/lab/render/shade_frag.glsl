/* Follows the texts of vxs_gl.h, lit.glsl, and FILTER, the filter of lookups as a constant. The light of a pixel: each
 * light's K x K PCF times lambert times the light that reaches the pixel (lit.glsl). */
#define SHOW_LIGHT   0 /* direct light, and the number of lights that were looked up */
#define SHOW_LIT     1 /* lit fraction of one light, or VXS_OUTSIDE */
#define SHOW_FULL    2 /* lookups, and how many of them are answered in full; where STREAMED */

layout(binding = 0) uniform sampler2D depths;
layout(binding = 1) uniform sampler2D normals;
layout(binding = 2) uniform sampler2D albedos;
uniform mat4 point_from_depth;
uniform vec4 sizes;   /* width, height */
uniform ivec4 asked;  /* SHOW_*; the light of SHOW_LIT; 1: lights of the pixel's tile, 0: all; the first of the LIGHTS_AT_ONCE
                         lights to add up */
layout(location = 0) out vec4 light_out;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depths, pixel, 0).r;
    light_out   = vec4(0.0);
    if (depth == 0.0) return;
    vec4 there  = point_from_depth * vec4(gl_FragCoord.xy / sizes.xy, depth, 1.0);
    vec3 at     = there.xyz / there.w, normal = texelFetch(normals, pixel, 0).xyz, sum = vec3(0.0);
    bool one    = asked.x == SHOW_LIT, listed = asked.z != 0 && !one;
    uint tile   = listed ? vxs_tile_of(pixel) : 0u, count = one ? 1u : listed ? vxs_tile_light_count(tile) : vxs_light_count();
    uint first  = uint(asked.w), end = min(count, first + LIGHTS_AT_ONCE);
#ifdef STREAMED
    vec2 lookups = vec2(0.0);
#endif
    for (uint i = first; i < end; i++) { /* a single call of vxs_lit: it is inlined, and compiling it takes long */
        uint                n = one ? uint(asked.y) : listed ? vxs_tile_light(tile, i) : i;
        vxs_light_constants l = vxs_light_at(n);
        vec3                to_light;
        vec3                power = strength(l, colours[n].a, at, to_light);
        power *= dot(normal, to_light);
        if (!one && !(max(power.r, max(power.g, power.b)) > 0.0)) continue;
#ifdef STREAMED
        if (asked.x == SHOW_FULL) {
            lookups += vec2(1.0, float(vxs_lit_is_full(l.first_word, l, at, normal, FILTER)));
            continue;
        }
#endif
        float lit = vxs_lit(l.first_word, l, at, normal, FILTER);
        if (one) {
            light_out = vec4(vec3(lit), 1.0);
            return;
        }
        if (lit < 0.0) lit = l.kind == VXS_LIGHT_KIND_DIRECTIONAL ? 1.0 : 0.0;
#ifdef MOVING
        if (lit > 0.0) lit *= moving_lit(n, at, normal);
#endif
        if (lit > 0.0) lit *= vxs_smoke_left_by(n, at);
#ifdef SMOKE
        lit *= smoke_left(n, pixel);
#endif
        sum += colours[n].rgb * (power * lit);
    }
#ifdef STREAMED
    if (asked.x == SHOW_FULL) {
        light_out = vec4(lookups, 0.0, 1.0);
        return;
    }
#endif
    light_out = vec4(sum, float(max(end, first) - first));
}
