/* Where an eye ray crosses the surface of what is lit: the airlight from there to what is seen, taken away where the ray leaves, added where it enters.
 * Behind what is seen there is none. Alpha counts leaving less entering: in the end it is 1 where the eye is in light, else 0; and so often mesh_whole.glsl
 * adds the airlight from the eye on. */
layout(location = 0) out vec4 airlight;

/* Where a ray from the eye meets the plane of a triangle whose corners are from the eye: no nearer and no farther than these are along the ray,
 * for a triangle that is seen from its edge may be drawn beside itself. Their distances are not interpolated, which would be wrong by far where
 * a triangle comes near the eye. Edges at the corner between the two shorter ones make its normal. */
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
    float metres, met, leaves = gl_FrontFacing == (vxs_frame.mesh.w < 0.0) ? -1.0 : 1.0;
    vec3  direction = vxs_eye_ray(pixel, metres), at[3], air;
    for (int n = 0; n < 3; n++) at[n] = (vxs_frame.eye_from_ls * vec4(vxs_mesh_corner_ls(gl_PrimitiveID, n), 1.0)).xyz;
    met      = met_at(at[0], at[1], at[2], direction);
    airlight = vec4(vec3(0.0), leaves);
    if (met >= metres) return;
    vxs_air_lit(vxs_frame_medium(), vxs_eye_path(direction, metres), met, metres, air);
    airlight.rgb = -leaves * air * vxs_frame.colour.rgb;
}
