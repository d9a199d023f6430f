/* Intersections of rays and capsules. */

/* Extend a part of a ray by its intersection with a ball around the origin.   from  origin of the ray;   part  [in, out] begin,
 * end */
void vxs_join_ball(const vec3 from, const vec3 way, const float radius, inout vec2 part)
{
    float near = -dot(from, way);
    vec3  beside = from + near * way;
    float inside = radius * radius - dot(beside, beside);
    if (inside > 0.0) part = vec2(min(part.x, near - sqrt(inside)), max(part.y, near + sqrt(inside)));
}

/* The same for a cylinder from the origin to `axis`. */
void vxs_join_cylinder(const vec3 from, const vec3 way, const vec3 axis, const float radius, inout vec2 part)
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

/* The part of a ray in a capsule. end - begin does not subtract distances to far points.
 * to, axis  from the origin of the ray to the capsule's begin; from there to its end
 * way       of length 1;   near  [out] metres to the point of the ray from which the part is measured
 * Returns begin and end; end < begin if they do not meet */
vec2 vxs_capsule_part(const vec3 to, const vec3 axis, const float radius, const vec3 way, out float near)
{
    vec2 part = vec2(1e30, -1e30);
    near = dot(to, way);
    vec3 from = near * way - to;
    vxs_join_ball(from, way, radius, part);
    vxs_join_ball(from - axis, way, radius, part);
    vxs_join_cylinder(from, way, axis, radius, part);
    return part;
}
