/* What the shaders of an engine call that add segments to a map's lists; behind transmittance_lists.glsl. Places are as all places that the library is given, metres. */
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

/* What a vertex shader gives as gl_Position, so that in a viewport of as many pixels as a layer has texels the fragment at a texel's place is the texel's.
 * No depth cuts it. */
vec4 vxs_segment_position(vec3 at, int layer)
{
    vec3  place = vxs_segment_metres(at, layer);
    float wide = vxs_view.texel_metres * float(vxs_view.shape.x);
    if (vxs_view.is_sun != 0.0) return vec4(2.0 * place.xy / wide - 1.0, 0.0, 1.0);
    return vec4(2.0 * place.xy / wide, 0.0, place.z);
}

/* Where the light ray through a texel's centre is in the layer's axes.   way  [out] of length 1;   Returns where it begins: at the lamp, or where a sun's map begins */
vec3 vxs_segment_axes(ivec3 texel, out vec3 way)
{
    vec2 at = (vec2(texel.xy) + 0.5) * vxs_view.texel_metres;
    way = vec3(0.0, 0.0, 1.0);
    if (vxs_view.is_sun != 0.0) return vec3(at, 0.0);
    way = normalize(vec3(at - 0.5 * float(vxs_view.shape.x) * vxs_view.texel_metres, 1.0));
    return vec3(0.0);
}

/* That ray in the world.   from  [out] where it begins;   Returns its way, of length 1 */
vec3 vxs_segment_ray(ivec3 texel, out vec3 from)
{
    vec3 way, begin = vxs_segment_axes(texel, way);
    vec4 rows[3] = vec4[3](vxs_view.metres_from_ws[3 * texel.z], vxs_view.metres_from_ws[3 * texel.z + 1], vxs_view.metres_from_ws[3 * texel.z + 2]);
    mat3 world = mat3(rows[0].xyz, rows[1].xyz, rows[2].xyz); /* axes are at right angles */
    from = world * (begin - vec3(rows[0].w, rows[1].w, rows[2].w));
    return world * way;
}

/* What lets a part of the light through, from entry to exit, metres along that ray. What lies before a lamp is cut off, as if it was evenly dense. What is no such
 * segment is not added: of a texel that is not there, of numbers that are none, without an end, all clear. */
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
