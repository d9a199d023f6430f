/* Writes gathered light to each pixel: unchanged; or averaged over nine pixels that have a ninth of the VPLs each; or
 * interpolated between four gathered pixels, by position and depth. */
#include "area_pass.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D shown;

/* Weight, larger for similar depths. */
float likeness(float metres, float other)
{
    float off = (other - metres) / (0.05 * max(min(metres, other), 1e-6));
    return 1.0 / (1e-3 + off * off);
}

/* Weighted mean of pixels [first, first + count). Weights are the likeness and, for 2 x 2 pixels, bilinear weights. */
vec3 mean_of(ivec2 first, int count, vec2 part, float metres)
{
    vec4 sum = vec4(0.0);
    for (int n = 0; n < count * count; n++) {
        ivec2 step = ivec2(n % count, n / count), last = ivec2(vxs_area_pass.wide, vxs_area_pass.high) - 1;
        vec4  texel = texelFetch(vxs_map, ivec3(clamp(first + step, ivec2(0), last), vxs_area_pass.layer), 0);
        vec2  near = count == 2 ? abs(1.0 - vec2(step) - part) : vec2(1.0);
        sum += vec4(texel.rgb, 1.0) * (near.x * near.y * likeness(metres, texel.a));
    }
    return sum.rgb / sum.a;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), view = ivec2(vxs_frame.sizes.xy);
    if (any(greaterThanEqual(pixel, view))) return;
    float metres;
    vec3  found;
    vxs_eye_ray(pixel, metres);
    if (vxs_area_pass.gather == 0u)
        found = texelFetch(vxs_map, ivec3(pixel, vxs_area_pass.layer), 0).rgb;
    else if (vxs_area_pass.gather == 1u)
        found = mean_of(max(min(pixel - 1, view - 3), ivec2(0)), 3, vec2(0.0), metres);
    else
        found = mean_of(pixel / 2, 2, vec2(pixel % 2) * 0.5, metres);
    vec4 before = vxs_area_pass.is_added != 0u ? imageLoad(shown, pixel) : vec4(0.0);
    imageStore(shown, pixel, before + vec4(found, 0.0));
}
