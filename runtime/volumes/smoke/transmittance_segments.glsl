/* Functions for the caller's shaders that add segments to a map's lists; after transmittance_lists.glsl. Positions are those of
 * the library's interface, in metres. */
vec3 vxs_segment_metres(vec3 at, int layer)
{
    vec4 place = vec4(at, 1.0);
    return vec3(dot(vxs_view.metres_from_ws[3 * layer], place), dot(vxs_view.metres_from_ws[3 * layer + 1], place),
                dot(vxs_view.metres_from_ws[3 * layer + 2], place));
}

/* Texels across, down, and layers. */
ivec3 vxs_segment_texels()
{
    return ivec3(vxs_view.shape.xxy);
}

/* gl_Position for a vertex shader: in a viewport with the size of a layer, fragment (x, y) is texel (x, y). Depth never clips
 * it. */
vec4 vxs_segment_position(vec3 at, int layer)
{
    vec3  place = vxs_segment_metres(at, layer);
    float wide = vxs_view.texel_metres * float(vxs_view.shape.x);
    if (vxs_view.is_sun != 0.0) return vec4(2.0 * place.xy / wide - 1.0, 0.0, 1.0);
    return vec4(2.0 * place.xy / wide, 0.0, place.z);
}

/* The light ray through a texel's centre, in the axes of the layer.   way  [out] direction, of length 1;   Returns its origin:
 * the light, or a point where a sun's map begins */
vec3 vxs_segment_axes(ivec3 texel, out vec3 way)
{
    vec2 at = (vec2(texel.xy) + 0.5) * vxs_view.texel_metres;
    way = vec3(0.0, 0.0, 1.0);
    if (vxs_view.is_sun != 0.0) return vec3(at, 0.0);
    way = normalize(vec3(at - 0.5 * float(vxs_view.shape.x) * vxs_view.texel_metres, 1.0));
    return vec3(0.0);
}

/* That ray in the world.   from  [out] origin;   Returns its direction, of length 1 */
vec3 vxs_segment_ray(ivec3 texel, out vec3 from)
{
    vec3 way, begin = vxs_segment_axes(texel, way);
    vec4 rows[3] = vec4[3](vxs_view.metres_from_ws[3 * texel.z], vxs_view.metres_from_ws[3 * texel.z + 1], vxs_view.metres_from_ws[3 * texel.z + 2]);
    mat3 world = mat3(rows[0].xyz, rows[1].xyz, rows[2].xyz); /* axes are orthogonal */
    from = world * (begin - vec3(rows[0].w, rows[1].w, rows[2].w));
    return world * way;
}

/* Add a segment with a transmittance, from entry to exit, metres along that ray. The part before a punctual light is cut off, as if
 * density was constant. Segments are ignored if the texel does not exist, if a number is NaN or infinite, or if they take no
 * light. */
void vxs_add_segment(ivec3 texel, float entry, float exit, float left)
{
    vec3 way;
    if (any(lessThan(texel, ivec3(0))) || any(greaterThanEqual(texel, vxs_segment_texels()))) return;
    if (!(exit >= entry && abs(entry) < 1e12 && abs(exit) < 1e12 && left >= 0.0 && left < 1.0)) return;
    if (vxs_view.is_sun == 0.0 && entry < 0.0) {
        if (!(exit > 0.0)) return;
        left  = pow(left, exit / (exit - entry));
        entry = 0.0;
    }
    vxs_segment_axes(texel, way);
    vxs_list_add(texel, vec3(vec2(entry, exit) * way.z, left));
}
