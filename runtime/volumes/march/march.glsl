/* A ray for each pixel. It tests at the middle of each step whether the light reaches it, by the light's map or the asset, and
 * multiplies by the transmittance of smoke. The ray ends where extinction leaves nothing of its light. march.c splits many steps
 * into pieces, because drivers end all loops of an invocation after
 * 65535 iterations. */
#include "frame.glsl"

#define VXS_MARCH_DEPTH 12.0 /* optical depth: e^-12 */

layout(std140, binding = VXS_AT_OWN) uniform vxs_march_block {
    uint steps, first, end; /* the number of steps of a ray; of them, the first that is summed, and the end */
    uint baked_number;      /* of the light whose baked smoke dims it; 0: none */
} vxs_march;
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;

/* Outside the volume of the light all is lit. */
bool lit(vec3 at)
{
#ifdef VXS_ASK_ASSET
    vec3 ls, turned;
    int  map = 0, side = 1 << vxs_frame.light.levels;
    vxs_ls_from_ws(vxs_frame.light, at, 1.0, ls);
    if (VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL)
        turned = ls;
    else {
        map = vxs_map_from_ls(vxs_frame.light, ls);
        vxs_face_from_ls(vxs_face_of_map(vxs_frame.light, map), ls, turned);
        float z = max(turned.z, VXS_REAL_MIN);
        turned.x = vxs_punctual_coordinate(vxs_frame.light, turned.x, z);
        turned.y = vxs_punctual_coordinate(vxs_frame.light, turned.y, z);
        turned.z = log(z / vxs_frame.light.near_metres) / vxs_frame.light.voxel_metres;
    }
    ivec3 voxel = ivec3(vxs_clamped(floor(turned.x)), vxs_clamped(floor(turned.y)), vxs_clamped(floor(turned.z)));
    if (VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL) {
        if (voxel.x < 0 || voxel.y < 0 || voxel.x >= side || voxel.y >= side) return true;
        if ((vxs_frame.light.flags & VXS_LIGHT_BOUNDED) != 0u && voxel.z >= side) return true;
    } else {
        if (vxs_in_reach(vxs_frame.light, ls) == 0) return true;
        voxel.xy = clamp(voxel.xy, ivec2(0), ivec2(side - 1));
    }
    if (voxel.z < 0) return true;
    return vxs_shadow_tap(vxs_frame.light.first_word, vxs_frame.light, map, voxel.x, voxel.y, uint(min(voxel.z, side - 1))) == 0u;
#else
    return vxs_map_lit(at);
#endif
}

float left(vec3 at)
{
    float some = 1.0;
    if (!lit(at)) return 0.0;
#ifdef VXS_READS_CURVES
    some = vxs_transmittance(at);
#endif
#ifdef VXS_GL_SMOKE
    if (vxs_march.baked_number > 0u) some *= vxs_smoke_left_by(vxs_march.baked_number - 1u, at);
#endif
    return some;
}

#ifdef VXS_MARCH_EVEN
/* Steps of equal length: airlight per metre of the step, times its length. */
vec3 march(vxs_medium medium, vxs_air_path path, vec3 direction, int steps)
{
    vec3  sum = vec3(0.0), air;
    float step = (path.end - path.begin) / float(steps);
    for (int n = int(vxs_march.first); n < int(vxs_march.end); n++) {
        float x = path.begin + (float(n) + 0.5) * step;
        float part = left(vxs_frame.eye_far.xyz + x * direction);
        if (part == 0.0) continue;
        vxs_air_step(medium, path, x, step, air);
        sum += air * (part * step);
    }
    return sum;
}

#elif VXS_ONLY_KIND != 1
/* Equal steps of the angle that vxs_air.h integrates over: a quadrature node at the middle of each. */
vec3 march(vxs_medium medium, vxs_air_path path, vec3 direction, int steps)
{
    vec3         sum = vec3(0.0);
    vxs_air_ray  ray = path.passed;
    float        k = vxs_air_sharpness(medium);
    vxs_air_part part = vxs_air_part_between(ray, k, path.begin, path.end - path.begin);
    for (int n = int(vxs_march.first); n < int(vxs_march.end); n++) {
        float more = vxs_air_more_at(part, (float(n) + 0.5) / float(steps));
        float some = left(vxs_frame.eye_far.xyz + (path.begin + vxs_air_metres_of(ray, part, more)) * direction);
        if (some > 0.0) vxs_air_add_node(medium, ray, k, part, path.begin - ray.in_fog, more, some * part.wide / float(steps), sum);
    }
    return sum * vxs_air_node_scale(medium, ray) * medium.scattering;
}

#else
/* Equal steps of the light that the sun scatters, in the thinnest channel: then each step has equal weight, however thick the
 * fog. */
vec3 march(vxs_medium medium, vxs_air_path path, vec3 direction, int steps)
{
    vec3  sum = vec3(0.0), air;
    float thinnest = min(medium.extinction.r, min(medium.extinction.g, medium.extinction.b));
    float turn = max(path.slope, 0.0) * thinnest, gone = 1.0 - exp(-turn * (path.end - path.begin)), begin = path.begin;
    for (int n = int(vxs_march.first); n <= int(vxs_march.end); n++) {
        float share = float(n) / float(steps), end = path.begin + share * (path.end - path.begin);
        if (gone > 1e-3) end = n == steps ? path.end : path.begin - log(1.0 - share * gone) / turn;
        if (n == int(vxs_march.first)) { /* begin of the first step */
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
#endif

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    float        metres;
    vec3         direction = vxs_eye_ray(pixel, metres), sum;
    vxs_medium   medium = vxs_frame_medium();
    vxs_air_path path = vxs_eye_path(direction, metres);
    int          steps = int(vxs_march.steps);
    path.end = vxs_air_seen_to(medium, path, VXS_MARCH_DEPTH);
    if (!(path.end > path.begin)) return;
    sum = march(medium, path, direction, steps);
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(sum * vxs_frame.colour.rgb, 0.0));
}
