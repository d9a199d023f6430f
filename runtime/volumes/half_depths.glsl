/* Depths for rays at half the width and height: of each, the depth, and the length of the ray in metres. A ray that meets one surface
 * has the depth there, interpolated, which is exact for a plane. At an edge it has the nearest or the farthest depth of its pixels, in
 * turn, so that a pixel finds both near it. */
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32f, binding = VXS_AT_IMAGE) uniform restrict writeonly image2D half_depths;

const float most_apart = 1.1; /* farthest over nearest distance of what counts as one surface */

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    vec2  at = (vec2(pixel) + 0.5) / vec2(vxs_frame.pixels.zw), place = at * vxs_frame.sizes.xy - 0.5, between = fract(place);
    float nearest = vxs_frame.eye_far.w, farthest = -1.0, mean = 0.0, metres;
    vec2  ends = vec2(vxs_frame.sizes.z);
    bool  is_seen = true;
    for (int n = 0; n < 4; n++) {
        ivec2 corner = ivec2(n & 1, n >> 1), there = clamp(ivec2(floor(place)) + corner, ivec2(0), ivec2(vxs_frame.sizes.xy) - 1);
        vec2  weight = mix(1.0 - between, between, vec2(corner));
        float depth = texelFetch(vxs_depths, there, 0).r;
        vxs_eye_ray(there, metres);
        if (metres <= nearest) ends.x = depth;
        if (metres > farthest) ends.y = depth;
        nearest = min(nearest, metres);
        farthest = max(farthest, metres);
        is_seen = is_seen && depth != vxs_frame.sizes.z;
        mean += weight.x * weight.y * depth;
    }
    bool  is_one = is_seen && farthest < vxs_frame.eye_far.w && farthest <= most_apart * nearest;
    float depth = is_one ? mean : ((pixel.x + pixel.y) & 1) == 0 ? ends.x : ends.y;
    vxs_ray_of_depth(at, depth, metres);
    imageStore(half_depths, pixel, vec4(depth, metres, 0.0, 0.0));
}
