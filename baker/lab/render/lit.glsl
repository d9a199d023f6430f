/* Light that reaches a place, by the law of vxs_air_light.h, whose text this uses; follows the texts of vxs_gl.h. */
layout(std430, binding = 3) readonly restrict buffer colours_block { vec4 colours[]; }; /* and the cosine of the inner cone */
uniform vec4 fog; /* extinction per metre, and the height of its top; 0 and VXS_AIR_EVERYWHERE: no fog */

vec3 place_of(vxs_light_constants l)
{
    return -(l.ls_from_ws[0].xyz * l.ls_from_ws[0].w + l.ls_from_ws[1].xyz * l.ls_from_ws[1].w + l.ls_from_ws[2].xyz * l.ls_from_ws[2].w);
}

/* Before shadows, in each channel; to_light is a unit vector. */
vec3 strength(vxs_light_constants l, float cos_inner, vec3 at, out vec3 to_light)
{
    bool          is_sun = l.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    vec3          reaches;
    vxs_air_light light = vxs_air_light(l.kind, is_sun ? -normalize(l.ls_from_ws[2].xyz) : place_of(l), l.ls_from_ws[2].xyz, cos_inner, l.cos_outer,
                                        1e-3, l.range_metres);
    vxs_air_reaches(vxs_medium(vec3(0.0), fog.rgb, 0.0), light, at, fog.a, to_light, reaches);
    return reaches;
}

#ifdef MOVING
/* The part of a light that passes moving casters, by the depth maps of moving_pass.c. */
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
#endif

#ifdef SMOKE
/* The transmittance of smoke towards a light at a pixel's surface: pictures of smoke_pass.c. */
layout(std430, binding = 7) readonly restrict buffer smoke_block { int smoke_layers[]; }; /* of each light; -1: no smoke dims it */
layout(binding = 7) uniform sampler2DArray smoke_pictures;

float smoke_left(uint light, ivec2 pixel)
{
    int layer = smoke_layers[light];
    return layer < 0 ? 1.0 : texelFetch(smoke_pictures, ivec3(pixel, layer), 0).r;
}
#endif
