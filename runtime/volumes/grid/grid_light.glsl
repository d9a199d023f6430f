/* Airlight of each pixel's ray by a shadow grid. */
#include "grid.glsl"
#include "vxs_shadow_grid.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    float        metres;
    vec3         direction = vxs_eye_ray(pixel, metres), sum;
    vxs_air_path path = vxs_eye_path(direction, metres);
    if (!(path.end > path.begin)) return;
    vxs_grid_size size = vxs_grid_size(vxs_grid.size.x, vxs_grid.size.y, vxs_grid.size.z);
    vxs_epipolar     space = vxs_grid_space();
    vxs_epipolar_ray ray = vxs_epipolar_eye(space, direction);
    vxs_grid_rows    rows = vxs_grid_row_of(space, size, ray.theta);
    if (vxs_grid.eye.y != 0) rows = vxs_grid_rows_about(space, size, ray.theta);
    vxs_grid_airlight_of(0u, space, size, vxs_frame_medium(), path, ray, rows, metres, vxs_grid.size.w, vxs_grid.eye.x, sum);
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(sum * vxs_frame.colour.rgb, 0.0));
}
