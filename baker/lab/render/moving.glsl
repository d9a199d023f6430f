/* The part of a light that passes moving casters: follows the texts of vxs_gl.h, uses the depth maps of moving_pass.c. */
struct moving_view {
    mat4 depth_from_point;
    vec4 texel; /* x: metres of one, times w */
};
layout(std430, binding = 6) readonly restrict buffer moving_block {
    moving_view moving_views[16];
    uvec2       moving_lights[]; /* the first view, and how many */
};
layout(binding = 6) uniform sampler2DArray moving_depths;

/* The share of 3 x 3 texels around a place, in texels, without a caster nearer to the light than `depth`: 1 without any. */
float moving_part(vec2 place, uint layer, float depth)
{
    vec2  first = floor(place - 1.5), part = place - 1.5 - first;
    ivec2 most = textureSize(moving_depths, 0).xy - 1;
    float sum = 0.0;
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++) {
            vec2  weight = vec2(x == 0 ? 1.0 - part.x : x == 3 ? part.x : 1.0, y == 0 ? 1.0 - part.y : y == 3 ? part.y : 1.0);
            float met = texelFetch(moving_depths, ivec3(clamp(ivec2(first) + ivec2(x, y), ivec2(0), most), layer), 0).r;
            sum += depth <= met ? weight.x * weight.y : 0.0;
        }
    return sum / 9.0;
}

/* The lookup is moved 1.5 texels off the surface, so that the surface does not shadow itself. */
float moving_lit(uint light, vec3 at, vec3 normal)
{
    uvec2 views = moving_lights[light];
    float lit = 1.0;
    for (uint n = views.x; n < views.x + views.y; n++) {
        moving_view view = moving_views[n];
        float       texel = view.texel.x * (view.depth_from_point * vec4(at, 1.0)).w;
        vec4        seen = view.depth_from_point * vec4(at + 1.5 * texel * normal, 1.0);
        vec2        place = seen.xy / seen.w;
        if (!(seen.w > 0.0) || any(lessThan(place, vec2(0.0))) || any(greaterThan(place, vec2(1.0)))) continue;
        lit *= moving_part(place * vec2(textureSize(moving_depths, 0).xy), n, min(seen.z / seen.w, 1.0));
    }
    return lit;
}
