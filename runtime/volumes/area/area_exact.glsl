/* Gathers the light of one VPL on surfaces, by its shadow depth map, which is that of the frame. */
#include "area_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2DArray gathered; /* air; surfaces */

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    uint  vpl = vxs_area_pass.vpl;
    bool  ninths = vxs_area_pass.gather == 1u, is_added = vxs_area_pass.is_added != 0u;
    if (at.x >= int(vxs_area_pass.wide) || at.y >= int(vxs_area_pass.high)) return;
    bool is_mine = !ninths || vpl % 9u == uint(at.x % 3 + 3 * (at.y % 3));
    if (!is_mine && is_added) return;
    vxs_area_pixel p = vxs_area_pixel_of(vxs_area_pass.gather == 2u ? 2 * at : at);
    vec3 irradiance = is_mine && p.normal != vec3(0.0) ? vxs_area_irradiance(p, vpl) : vec3(0.0);
    if (irradiance != vec3(0.0)) {
        irradiance *= vxs_area_lit_exactly(p, vpl);
#ifdef VXS_GRID_DIMS
        irradiance *= vxs_area_left(vpl, p.eye + p.metres * p.direction);
#endif
    }
    vec4 before = is_added ? imageLoad(gathered, ivec3(at, 1)) : vec4(0.0, 0.0, 0.0, p.metres);
    imageStore(gathered, ivec3(at, 1), before + vec4(vxs_area.vpls[vpl].colour.rgb * irradiance * (ninths ? 9.0 : 1.0), 0.0));
}
