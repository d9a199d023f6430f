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
