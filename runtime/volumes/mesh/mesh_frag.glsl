/* Where an eye ray crosses the surface of the lit volume: the airlight from there to the visible surface is subtracted where the
 * ray leaves, and added where it enters. Crossings behind the visible surface do not count. Alpha counts leaving minus entering:
 * in the end it is 1 if the eye is in light, else 0. mesh_whole.glsl multiplies the airlight of the whole ray by it. */
#include "mesh.glsl"

layout(location = 0) out vec4 airlight;

/* Distance where a ray from the eye meets the plane of a triangle; corners are relative to the eye. It is clamped to the range
 * of the corners along the ray, because a triangle seen edge-on may be drawn beside itself. Distances of corners are not
 * interpolated: this would be very wrong where a triangle comes near the eye. The normal comes from the two edges at the corner
 * between the two shorter edges. */
float met_at(vec3 a, vec3 b, vec3 c, vec3 direction)
{
    float size = sqrt(max(dot(a, a), max(dot(b, b), dot(c, c))));
    vec3  ab = b - a, bc = c - b, ca = a - c, at = a, first = ab, second = -ca;
    vec3  along = vec3(dot(a, direction), dot(b, direction), dot(c, direction));
    float ab2 = dot(ab, ab), bc2 = dot(bc, bc), ca2 = dot(ca, ca);
    float least = max(min(along.x, min(along.y, along.z)), 0.0), most = max(along.x, max(along.y, along.z));
    if (ca2 >= ab2 && ca2 >= bc2) {
        at     = b;
        first  = bc;
        second = -ab;
    } else if (ab2 >= bc2 && ab2 >= ca2) {
        at     = c;
        first  = ca;
        second = -bc;
    }
    vec3  normal = cross(first / size, second / size);
    float met = dot(normal, at) / dot(normal, direction);
    if (!(met >= least)) return least;
    return met < most ? met : most;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float metres, met, leaves = gl_FrontFacing == (vxs_mesh_of.turn < 0.0) ? -1.0 : 1.0;
    vec3  direction = vxs_eye_ray(pixel, metres), at[3], air;
    for (int n = 0; n < 3; n++) at[n] = (vxs_mesh_of.eye_from_ls * vec4(vxs_mesh_corner_ls(gl_PrimitiveID, n), 1.0)).xyz;
    met      = met_at(at[0], at[1], at[2], direction);
    airlight = vec4(vec3(0.0), leaves);
    if (met >= metres) return;
    vxs_air_lit(vxs_frame_medium(), vxs_eye_path(direction, metres), met, metres, air);
    airlight.rgb = -leaves * air * vxs_frame.colour.rgb;
}
