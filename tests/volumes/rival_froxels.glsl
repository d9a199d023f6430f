/* Froxels: FILL, a column each, sums airlight up to the far side of each slice; SHOW, a pixel each, reads it. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;
layout(rgba32f, binding = 1) uniform restrict image2DArray cells; /* airlight from the eye to the far side */

/* Slices are GROWTH times as deep at the far bound as at the eye, near enough. */
const float GROWTH = 20.0;

float metres_of(float slice)
{
    float slices = float(imageSize(cells).z);
    return vxs_frame.eye_far.w * (pow(GROWTH, slice / slices) - 1.0) / (GROWTH - 1.0);
}

float slice_of(float metres)
{
    return float(imageSize(cells).z) * log(1.0 + metres / vxs_frame.eye_far.w * (GROWTH - 1.0)) / log(GROWTH);
}

#ifdef FILL
void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID.xy, 0), size = imageSize(cells);
    if (any(greaterThanEqual(cell.xy, size.xy))) return;
    vec4         point     = vxs_frame.point_from_depth * vec4((vec2(cell.xy) + 0.5) / vec2(size.xy), 0.5, 1.0);
    vec3         direction = normalize(point.xyz / point.w - vxs_frame.eye_far.xyz), sum = vec3(0.0), air;
    vxs_medium   medium    = vxs_frame_medium();
    vxs_air_path path      = vxs_eye_path(direction, vxs_frame.eye_far.w);
    for (; cell.z < size.z; cell.z++) {
        float begin = metres_of(float(cell.z)), end = metres_of(float(cell.z + 1)), middle = 0.5 * (begin + end);
        if (middle > path.begin && middle < path.end && vxs_map_lit(vxs_frame.eye_far.xyz + middle * direction)) {
            vxs_air_at(medium, path, middle, air);
            sum += air * (end - begin);
        }
        imageStore(cells, cell, vec4(sum, 0.0));
    }
}
#endif

#ifdef SHOW
/* Of a column, from the eye to a slice and a part of the next; nothing before the first. */
vec3 column(ivec2 at, float slice)
{
    ivec3 size  = imageSize(cells);
    int   last  = clamp(int(floor(slice)), 0, size.z - 1);
    at          = clamp(at, ivec2(0), size.xy - 1);
    vec3 before = last > 0 ? imageLoad(cells, ivec3(at, last - 1)).rgb : vec3(0.0);
    return mix(before, imageLoad(cells, ivec3(at, last)).rgb, clamp(slice - float(last), 0.0, 1.0));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(vec2(pixel), vxs_frame.sizes.xy))) return;
    float metres;
    vxs_eye_ray(pixel, metres);
    vec2  at    = (vec2(pixel) + 0.5) / vxs_frame.sizes.xy * vec2(imageSize(cells).xy) - 0.5, part = fract(at);
    ivec2 first = ivec2(floor(at));
    float slice = slice_of(metres);
    vec3  near  = mix(column(first, slice), column(first + ivec2(1, 0), slice), part.x);
    vec3  far   = mix(column(first + ivec2(0, 1), slice), column(first + ivec2(1, 1), slice), part.x);
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(mix(near, far, part.y) * vxs_frame.colour.rgb, 0.0));
}
#endif
