/* Transmittance between the light and the visible surface of each pixel. */
#include "transmittance_light.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f, binding = VXS_AT_IMAGE) uniform writeonly restrict image2D transmittance;

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    float metres;
    vec3  direction = vxs_eye_ray(pixel, metres);
    bool  seen = texelFetch(vxs_depths, pixel, 0).r != vxs_frame.sizes.z;
    float left = seen ? vxs_transmittance(vxs_frame.eye_far.xyz + metres * direction) : 1.0;
    imageStore(transmittance, pixel, vec4(left, 0.0, 0.0, 0.0));
}
