/* Light from all directions at places in smoke; one place for each pixel, row by row. Follows the texts of vxs_gl.h
 * and lit.glsl. */
layout(std430, binding = 5) readonly restrict buffer places_block { vec4 places[]; };
layout(std430, binding = 8) readonly restrict buffer left_block { float left[]; }; /* layer by layer, in each place by place */
uniform ivec4 sizes; /* pixels across, places; the first of the LIGHTS_AT_ONCE lights to add up */
layout(location = 0) out vec4 light_out;

void main()
{
    int  place = int(gl_FragCoord.y) * sizes.x + int(gl_FragCoord.x);
    vec3 at = place < sizes.y ? places[place].xyz : vec3(0.0), sum = vec3(0.0);
    uint end = min(vxs_light_count(), uint(sizes.z) + LIGHTS_AT_ONCE);
    for (uint n = uint(sizes.z); n < end && place < sizes.y; n++) {
        vxs_light_constants l = vxs_light_at(n);
        vec3                to_light;
        vec3                power = strength(l, colours[n].a, at, to_light);
        if (!(max(power.r, max(power.g, power.b)) > 0.0)) continue;
        float lit = vxs_lit(l.first_word, l, at, vec3(0.0), FILTER);
        if (lit < 0.0) lit = l.kind == VXS_LIGHT_KIND_DIRECTIONAL ? 1.0 : 0.0;
#ifdef MOVING
        if (lit > 0.0) lit *= moving_lit(n, at, vec3(0.0));
#endif
        if (lit > 0.0) lit *= vxs_smoke_left_by(n, at);
        if (smoke_layers[n] >= 0) lit *= left[smoke_layers[n] * sizes.y + place];
        sum += colours[n].rgb * (power * lit);
    }
    light_out = vec4(sum, 1.0);
}
