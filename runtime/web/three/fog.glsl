/* Airlight of one baked light along an eye ray: its exact lit intervals, and of each the closed form. One text for WebGL and, by naga,
 * for WebGPU. It needs vxs_intervals.h and vxs_air_path.h, with VXS_ONLY_EVERYWHERE. Arguments before `eye` are texels of fog_light.mjs:
 * absorbs  extinction, anisotropy;   scatters  scattering, cosine where the cone begins to fade;   place  of the light, least distance
 * SPDX-License-Identifier: MIT */
vec3 vxs_fog(const vxs_light_constants light, const vec4 absorbs, const vec4 scatters, const vec4 place, const vec4 axis,
             const vec4 color, const vec3 eye, const vec3 direction, const float metres)
{
    vxs_medium medium;
    medium.extinction = absorbs.xyz;
    medium.scattering = scatters.xyz;
    medium.anisotropy = absorbs.w;
    vxs_air_light source;
    source.kind          = VXS_KIND(light);
    source.place         = place.xyz;
    source.axis          = axis.xyz;
    source.cos_inner     = scatters.w;
    source.cos_outer     = light.cos_outer;
    source.radius_metres = place.w;
    source.range_metres  = light.range_metres;
    vec2         in_fog;
    vec3         sum = vec3(0.0), air;
    vxs_span     span;
    vxs_air_path path = vxs_air_path_of(source, eye, direction, metres, VXS_AIR_EVERYWHERE, in_fog);
    path.end          = vxs_air_seen_to(medium, path, VXS_AIR_DEPTH_MAX);
    vxs_walk walk     = vxs_walk_of(light, eye, direction, path.begin, path.end);
    if (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL) walk.outside = VXS_SPAN_LIT; /* nothing is in shadow beyond the map */
    while (vxs_walk_is_on(walk) != 0) {
        int found = vxs_walk_some(light.first_word, light, walk, VXS_SPAN_LIT, 8, span);
        for (; found != 0; found = 0) { /* a loop: see vxs_walk_step */
            vxs_air_lit(medium, path, span.begin, span.end, air);
            sum += air;
        }
    }
    return sum * color.xyz;
}
