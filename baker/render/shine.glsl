/* What lights send to a place, as KHR_lights_punctual has it: behind the texts of vxs_gl.h. */
layout(std430, binding = 3) readonly restrict buffer colours_block { vec4 colours[]; }; /* and the cosine of the inner cone */

vec3 place_of(vxs_light_constants l)
{
    return -(l.ls_from_ws[0].xyz * l.ls_from_ws[0].w + l.ls_from_ws[1].xyz * l.ls_from_ws[1].w + l.ls_from_ws[2].xyz * l.ls_from_ws[2].w);
}

/* Before shadows; to_light is a unit vector. */
float strength(vxs_light_constants l, float cos_inner, vec3 at, out vec3 to_light)
{
    if (l.kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        to_light = -normalize(l.ls_from_ws[2].xyz);
        return 1.0;
    }
    vec3  way    = place_of(l) - at;
    float square = max(dot(way, way), 1e-6), share = square / max(l.range_metres * l.range_metres, 1e-6);
    to_light     = way * inversesqrt(square);
    float result = (l.range_metres > 0.0 ? clamp(1.0 - share * share, 0.0, 1.0) : 1.0) / square;
    if (l.kind == VXS_LIGHT_KIND_POINT) return result;
    float edge = clamp((-dot(to_light, l.ls_from_ws[2].xyz) - l.cos_outer) / max(0.001, cos_inner - l.cos_outer), 0.0, 1.0);
    return result * edge * edge;
}
