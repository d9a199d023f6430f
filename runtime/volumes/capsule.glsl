/* Where rays meet capsules. */

/* Join the part of a ray in a ball about the origin.   from  where the ray begins;   part  [in, out] begin, end */
void vxs_join_ball(vec3 from, vec3 way, float radius, inout vec2 part)
{
    float near = -dot(from, way);
    vec3  beside = from + near * way;
    float inside = radius * radius - dot(beside, beside);
    if (inside > 0.0) part = vec2(min(part.x, near - sqrt(inside)), max(part.y, near + sqrt(inside)));
}

/* The same of a cylinder from the origin to `axis`. */
void vxs_join_cylinder(vec3 from, vec3 way, vec3 axis, float radius, inout vec2 part)
{
    float size = length(axis);
    if (!(size > 0.0)) return;
    vec3  u = axis / size;
    float along = dot(from, u), slope = dot(way, u);
    vec3  beside = from - along * u, turned = way - slope * u;
    float square = dot(turned, turned), near = square > 1e-12 ? -dot(beside, turned) / square : 0.0;
    beside += near * turned;
    float inside = radius * radius - dot(beside, beside);
    if (!(inside > 0.0)) return;
    float reach = square > 1e-12 ? sqrt(inside / square) : 1e30;
    vec2  within = vec2(near - reach, near + reach);
    if (abs(slope) > 1e-12) {
        vec2 ends = vec2(-along, size - along) / slope;
        within = vec2(max(within.x, min(ends.x, ends.y)), min(within.y, max(ends.x, ends.y)));
    } else if (!(along >= 0.0 && along <= size)) return;
    if (within.y > within.x) part = vec2(min(part.x, within.x), max(part.y, within.y));
}

/* The part of a ray in a capsule: its end less its begin is no difference of what is far.
 * to, axis  where it begins, from where the ray does; and from there to where it ends
 * way       of length 1;   near  [out] metres to the place of the ray that the part counts from
 * Returns begin and end; the end is less where they do not meet */
vec2 vxs_capsule_part(vec3 to, vec3 axis, float radius, vec3 way, out float near)
{
    vec2 part = vec2(1e30, -1e30);
    near = dot(to, way);
    vec3 from = near * way - to;
    vxs_join_ball(from, way, radius, part);
    vxs_join_ball(from - axis, way, radius, part);
    vxs_join_cylinder(from, way, axis, radius, part);
    return part;
}
