/* Runs after a mesh: adds the airlight of the whole ray, times the count in alpha. */
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    vec4  before = imageLoad(airlight, pixel);
    float metres;
    vec3  direction = vxs_eye_ray(pixel, metres), air;
    if (before.a == 0.0) return;
    vxs_air_lit(vxs_frame_medium(), vxs_eye_path(direction, metres), 0.0, metres, air);
    imageStore(airlight, pixel, vec4(before.rgb + before.a * air * vxs_frame.colour.rgb, before.a));
}
