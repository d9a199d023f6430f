/* Before rival_froxels.glsl: airlight of a rectangle, as if all of it were seen from wherever its centre is: by its solid angle,
 * with the phase and the way of light from the centre. colour: its radiance. */
layout(std140, binding = VXS_AT_OWN) uniform rectangle_block { vec4 corner, across, up; } rectangle;

float triangle_angle(vec3 a, vec3 b, vec3 c)
{
    return 2.0 * atan(abs(dot(a, cross(b, c))), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

void rectangle_air(vxs_medium medium, vec3 direction, float x, out vec3 air)
{
    vec3  corner = rectangle.corner.xyz, across = rectangle.across.xyz, up = rectangle.up.xyz;
    vec3  from = vxs_frame.eye_far.xyz + x * direction, centre = corner + 0.5 * (across + up) - from;
    float metres = length(centre);
    air          = vec3(0.0);
    if (dot(centre, cross(across, up)) >= 0.0) return;
    vec3  a = normalize(corner - from), b = normalize(corner + across - from), c = normalize(corner + across + up - from);
    vec3  d = normalize(corner + up - from);
    float angle = triangle_angle(a, b, c) + triangle_angle(a, c, d);
    air = medium.scattering * exp(-medium.extinction * (x + metres)) * vxs_air_phase(medium.anisotropy, dot(centre, direction) / metres) * angle;
}
#define vxs_air_at(medium, path, x, air) rectangle_air(medium, direction, x, air)
