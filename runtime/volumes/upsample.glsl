/* Adds airlight of half the width and height to that of the frame. Each pixel takes the four nearest rays, bilinearly, and by how near
 * their ends are to its own: light of another surface does not cross an edge. A ray of another length counts in proportion to the fog
 * on both, for pixels of which no ray ends near: points, and thin wires. */
#include "frame.glsl"

layout(std140, binding = VXS_AT_OWN) uniform vxs_upsample_block { uvec2 half_px; } vxs_upsample;
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;

const float near_share = 0.05; /* of the distance: rays that end so far apart have half the weight */

const float most_scale = 4.0;

/* Metres in the fog of a ray of a length. */
float fogged(vec3 direction, float metres)
{
    vec2 in_fog = vec2(0.0, metres);
    if (VXS_AIR_HAS_TOP(vxs_frame.sizes.w)) vxs_air_in_fog(vxs_frame.eye_far.y, direction.y, vxs_frame.sizes.w, in_fog);
    return max(in_fog.y - in_fog.x, 1e-6);
}

/* The light that fog takes on a way, to a factor: with light from everywhere, airlight grows like it. */
vec3 taken(float metres)
{
    vec3 depth = min(vxs_frame.extinction.rgb * metres, vec3(1e30)); /* an infinity would have no mean */
    return metres * vec3(vxs_air_mean_left(depth.r), vxs_air_mean_left(depth.g), vxs_air_mean_left(depth.b));
}

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    vec2  place = (vec2(pixel) + 0.5) * vec2(vxs_upsample.half_px) / vxs_frame.sizes.xy - 0.5, between = fract(place);
    vec4  sum = vec4(0.0);
    float metres;
    vec3  direction = vxs_eye_ray(pixel, metres), own = taken(fogged(direction, metres));
    for (int n = 0; n < 4; n++) {
        ivec2 corner = ivec2(n & 1, n >> 1), there = clamp(ivec2(floor(place)) + corner, ivec2(0), ivec2(vxs_upsample.half_px) - 1);
        vec2  weight = mix(1.0 - between, between, vec2(corner));
        float ends = texelFetch(vxs_map, ivec3(there, 0), 0).g;
        /* the bound keeps a sum of weights above 0 */
        float apart = min(abs(ends - metres) / (near_share * max(min(ends, metres), 1e-6)), 1e4);
        apart *= apart * apart * apart;
        float part = weight.x * weight.y / (1.0 + apart);
        vec3  scale = mix(vec3(1.0), min(own / taken(fogged(direction, ends)), most_scale), apart / (1.0 + apart));
        sum += part * vec4(texelFetch(vxs_airlight, there, 0).rgb * scale, 1.0);
    }
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(sum.rgb / sum.w, 0.0));
}
