/* A ray for each pixel, and its exact lit parts in the asset: no steps, but a closed form of each lit part.
 *
 * In pieces, each dispatch makes a limited number of steps of the walk, before a driver ends its loops. Alpha stores
 * where the ray continues; 0: it has ended. */
#include "frame.glsl"
#include "vxs_intervals.h"

#define VXS_INTERVALS_WHOLE 0u
#define VXS_INTERVALS_FIRST 1u
#define VXS_INTERVALS_STEPS 512
#define VXS_INTERVALS_ROUNDS 8 /* of a walk: a ray that finds a lit part waits no longer for those beside it */
layout(std140, binding = VXS_AT_OWN) uniform vxs_intervals_block { uint piece; } vxs_pieces;
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;
layout(std430, binding = VXS_AT_GRID) restrict buffer vxs_cut_buffer { uint rays; } vxs_cut;

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    bool  in_pieces = vxs_pieces.piece != VXS_INTERVALS_WHOLE, goes_on = vxs_pieces.piece > VXS_INTERVALS_FIRST;
    vec4  before = imageLoad(airlight, pixel);
    if (goes_on && before.a == 0.0) return;
    float        metres;
    vec3         direction = vxs_eye_ray(pixel, metres), sum = vec3(0.0), air;
    vxs_medium   medium = vxs_frame_medium();
    vxs_air_path path = vxs_eye_path(direction, metres);
    float        begin = goes_on ? before.a : path.begin;
    path.end = vxs_air_seen_to(medium, path, VXS_AIR_DEPTH_MAX);
    if (!(path.end > begin)) return;
    vxs_light_constants light = vxs_frame.light;
    vxs_walk     w = vxs_walk_of(light, vxs_frame.eye_far.xyz, direction, begin, path.end);
    vxs_span     span;
    if (in_pieces) w.pause = w.steps - VXS_INTERVALS_STEPS;
    if (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL) w.outside = VXS_SPAN_LIT; /* beyond the end of its map, the sun is not shadowed */
    while (vxs_walk_is_on(w) != 0) {
        int found = vxs_walk_some(light.first_word, light, w, VXS_SPAN_LIT, VXS_INTERVALS_ROUNDS, span);
        for (; found != 0; found = 0) { /* a loop: see vxs_walk_step */
            vxs_air_lit(medium, path, span.begin, span.end, air);
            sum += air;
        }
    }
    if (w.t < w.end) atomicAdd(vxs_cut.rays, 1u);
    imageStore(airlight, pixel, vec4(before.rgb + sum * vxs_frame.colour.rgb, in_pieces ? (w.t < w.end ? w.t : 0.0) : before.a));
}
