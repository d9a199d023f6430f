/* A ray for each pixel. It tests at the middle of each step whether the light reaches it, by the light's map or the asset, and
 * multiplies by the transmittance of smoke. The ray ends where extinction leaves nothing of its light. map.z, map.w: the first
 * step that is summed, and the end. march.c splits many steps into pieces, because drivers end all loops of an invocation after
 * 65535 iterations. */
#define VXS_MARCH_DEPTH 12.0 /* optical depth: e^-12 */

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;

bool lit(vec3 at)
{
#ifdef VXS_ASK_ASSET
    return vxs_lit(vxs_frame.light.first_word, vxs_frame.light, at, vec3(0.0), 1) != 0.0;
#else
    return vxs_map_lit(at);
#endif
}

float left(vec3 at)
{
    float some = 1.0;
    if (!lit(at)) return 0.0;
#ifdef VXS_READS_CURVES
    some = vxs_transmittance(at, int(vxs_frame.knobs.z));
#endif
#ifdef VXS_GL_SMOKE
    if (vxs_frame.knobs.w > 0.0) some *= vxs_smoke_left_by(uint(vxs_frame.knobs.w) - 1u, at);
#endif
    return some;
}

/* Steps of equal length: airlight per metre of the step, times its length. */
vec3 march_even(vxs_medium medium, vxs_air_path path, vec3 direction, int steps)
{
    vec3  sum = vec3(0.0), air;
    float step = (path.end - path.begin) / float(steps);
    for (int n = int(vxs_frame.map.z); n < int(vxs_frame.map.w); n++) {
        float x = path.begin + (float(n) + 0.5) * step;
        float part = left(vxs_frame.eye_far.xyz + x * direction);
        if (part == 0.0) continue;
        vxs_air_step(medium, path, x, step, air);
        sum += air * (part * step);
    }
    return sum;
}

/* Equal steps of the angle that vxs_air.h integrates over: a quadrature node at the middle of each. */
vec3 march_angle(vxs_medium medium, vxs_air_path path, vec3 direction, int steps)
{
    vec3         sum = vec3(0.0);
    vxs_air_ray  ray = path.passed;
    float        k = vxs_air_sharpness(medium);
    vxs_air_part part = vxs_air_part_between(ray, k, path.begin, path.end - path.begin);
    for (int n = int(vxs_frame.map.z); n < int(vxs_frame.map.w); n++) {
        float more = vxs_air_more_at(part, (float(n) + 0.5) / float(steps));
        float some = left(vxs_frame.eye_far.xyz + (path.begin + vxs_air_metres_of(ray, part, more)) * direction);
        if (some > 0.0) vxs_air_add_node(medium, ray, k, part, path.begin - ray.in_fog, more, some * part.wide / float(steps), sum);
    }
    return sum * vxs_air_node_scale(medium, ray) * medium.scattering;
}

/* Equal steps of the light that the sun scatters, in the thinnest channel: then each step has equal weight, however thick the
 * fog. */
vec3 march_sun(vxs_medium medium, vxs_air_path path, vec3 direction, int steps)
{
    vec3  sum = vec3(0.0), air;
    float thinnest = min(medium.extinction.r, min(medium.extinction.g, medium.extinction.b));
    float turn = max(path.slope, 0.0) * thinnest, gone = 1.0 - exp(-turn * (path.end - path.begin)), begin = path.begin;
    for (int n = int(vxs_frame.map.z); n <= int(vxs_frame.map.w); n++) {
        float share = float(n) / float(steps), end = path.begin + share * (path.end - path.begin);
        if (gone > 1e-3) end = n == steps ? path.end : path.begin - log(1.0 - share * gone) / turn;
        if (n == int(vxs_frame.map.z)) { /* begin of the first step */
            begin = end;
            continue;
        }
        float part = left(vxs_frame.eye_far.xyz + 0.5 * (begin + end) * direction);
        if (part > 0.0) {
            vxs_air_lit(medium, path, begin, end, air);
            sum += air * part;
        }
        begin = end;
    }
    return sum;
}

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    float        metres;
    vec3         direction = vxs_eye_ray(pixel, metres), sum;
    vxs_medium   medium = vxs_frame_medium();
    vxs_air_path path = vxs_eye_path(direction, metres);
    int          steps = int(vxs_frame.knobs.x);
    path.end = vxs_air_seen_to(medium, path, VXS_MARCH_DEPTH);
    if (!(path.end > path.begin)) return;
    if (vxs_frame.knobs.y == 0.0)
        sum = march_even(medium, path, direction, steps);
    else if (path.kind == VXS_LIGHT_KIND_DIRECTIONAL)
        sum = march_sun(medium, path, direction, steps);
    else
        sum = march_angle(medium, path, direction, steps);
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(sum * vxs_frame.colour.rgb, 0.0));
}
