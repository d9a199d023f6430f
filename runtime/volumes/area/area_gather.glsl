/* Gathers light of VPLs that emit in one way, all of them or a ninth; for each pixel, or for one in four. One program gathers light
 * in the air, another light on surfaces. */
#include "area_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
/* air, and the distance to the surface; surfaces */
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2DArray gathered;

#ifdef VXS_AREA_AIR
const int layer = 0;

vec3 light_of(vxs_area_pixel p, uint n)
{
    vxs_air_light vpl;
    bool is_far        = vxs_area_is_far(n);
    vpl.kind          = is_far ? VXS_LIGHT_KIND_DIRECTIONAL : VXS_LIGHT_KIND_POINT;
    vpl.place         = is_far ? -vxs_area.vpls[n].normal.xyz : vxs_area.vpls[n].place.xyz;
    vpl.axis          = vxs_area.vpls[n].normal.xyz;
    vpl.cos_inner     = 1.0;
    vpl.cos_outer     = 0.0;
    vpl.radius_metres = vxs_area.vpls[n].place.w;
    vpl.range_metres  = 0.0;
    vxs_air_path     path = vxs_area_path(vpl, vxs_area_emits(n) == 1.0 ? 1 : 0, p.eye, p.direction, p.metres, vxs_frame.sizes.w);
    vxs_epipolar     space = vxs_area_space(n);
    vxs_grid_size    size = vxs_grid_size(vxs_area.vpls[n].size.x, vxs_area.vpls[n].size.y, vxs_area.vpls[n].size.z);
    vxs_epipolar_ray ray = vxs_epipolar_eye(space, p.direction);
    vxs_grid_rows    rows = vxs_grid_row_of(space, size, ray.theta);
    vec3             air;
#ifdef VXS_GRID_DIMS
    vxs_vpl_now  = n;
    vxs_area_direction = p.direction;
#endif
    if (vxs_area_pass.between_rows != 0u) rows = vxs_grid_rows_about(space, size, ray.theta);
    vxs_grid_airlight_of(n * uint(vxs_grid_words(size)), space, size, p.medium, path, ray, rows, p.metres, vxs_area_pass.runs,
                         vxs_area.vpls[n].eye.x, air);
    return air;
}
#else
const int layer = 1;

vec3 light_of(vxs_area_pixel p, uint n)
{
    vec3 irradiance = p.normal != vec3(0.0) ? vxs_area_irradiance(p, n) : vec3(0.0);
    if (irradiance == vec3(0.0)) return irradiance;
    irradiance *= vxs_area_lit(p, n);
#ifdef VXS_GRID_DIMS
    irradiance *= vxs_area_left(n, p.eye + p.metres * p.direction);
#endif
    return irradiance;
}
#endif

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(vxs_area_pass.wide) || at.y >= int(vxs_area_pass.high)) return;
    bool ninths = vxs_area_pass.gather == 1u;
    uint first = ninths ? uint(at.x % 3 + 3 * (at.y % 3)) : 0u, step = ninths ? 9u : 1u;
    vec3 light = vec3(0.0);
    vxs_area_pixel p = vxs_area_pixel_of(vxs_area_pass.gather == 2u ? 2 * at : at);
    for (uint n = first; n < vxs_area_pass.vpls; n += step)
        if (vxs_area.vpls[n].normal.w == VXS_AREA_EMITS) light += vxs_area.vpls[n].colour.rgb * light_of(p, n);
    vec4 before = vxs_area_pass.is_added != 0u ? imageLoad(gathered, ivec3(at, layer)) : vec4(0.0, 0.0, 0.0, p.metres);
    imageStore(gathered, ivec3(at, layer), before + vec4(light * float(step), 0.0));
}
