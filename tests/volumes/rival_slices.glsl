/* Epipolar slices: FILL finds where shadow begins in each bin of each slice; TREE the least and most of 2, 4, 8... of them; SAMPLE
 * airlight at each angle of each slice; SHOW each pixel's, between them. Or SUM adds up moments of angles, and SHOW_MOMENTS queries
 * these.
 *
 *     tree, a row for a slice:  | bins ...            | bins / 2 ... | bins / 4 ... | ... |    .r least, .g most
 */
layout(local_size_x = 64) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;
layout(rg32f, binding = 1) uniform coherent image2DArray tree;
layout(rgba32f, binding = 2) uniform restrict image2DArray samples; /* .a: its metres; or moments of the bins before one */

layout(std140, binding = 3) uniform slices_block {
    vec4 axis, up, across;
    vec4 angles;  /* theta and its range; alpha and its range */
    vec4 sizes;   /* the range of bins; slices, bins, samples */
    mat4 depth_from_point;
} slices;

bool is_sun()
{
    return vxs_frame.light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
}

int level_begin(int level)
{
    int bins = int(slices.sizes.z);
    return 2 * bins - ((2 * bins) >> level);
}

vec3 side_of_slice(float slice)
{
    float theta = slices.angles.x + (slice + 0.5) / slices.sizes.y * slices.angles.y;
    return cos(theta) * slices.up.xyz + sin(theta) * slices.across.xyz;
}

#ifdef FILL
/* Metres along the light's ray from the light on; of a sun, from the plane across it that the eye is in. */
void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= int(slices.sizes.z)) return;
    vec3  side = side_of_slice(float(at.y)), ls;
    float bin = (float(at.x) + 0.5) / slices.sizes.z * slices.sizes.x, depth, begin = VXS_NO_END;
    ivec3 texel;
    if (is_sun()) {
        vec3 more;
        vxs_ls_from_ws(vxs_frame.light, vxs_frame.eye_far.xyz + bin * side, 1.0, ls);
        vxs_ls_from_ws(vxs_frame.light, -slices.axis.xyz, 0.0, more);
        float side_px = float(vxs_frame.map_side);
        vec2  place   = ls.xy * (side_px / float(1u << vxs_frame.light.levels));
        if (all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(side_px)))) {
            float first = texelFetch(vxs_map, ivec3(place, 0), 0).r;
            if (first < VXS_NO_END) begin = (first - ls.z) / more.z;
        }
    } else {
        vxs_ls_from_ws(vxs_frame.light, -cos(bin) * slices.axis.xyz + sin(bin) * side, 0.0, ls);
        if (vxs_map_texel(ls, texel, depth)) begin = min(texelFetch(vxs_map, texel, 0).r / depth, VXS_NO_END);
    }
    imageStore(tree, ivec3(at, 0), vec4(begin, begin, 0.0, 0.0));
}
#endif

#ifdef TREE
void main()
{
    int slice = int(gl_WorkGroupID.y), bins = int(slices.sizes.z);
    for (int level = 1; (bins >> level) > 0; level++) {
        memoryBarrierImage();
        barrier();
        for (int n = int(gl_LocalInvocationID.x); n < (bins >> level); n += 64) {
            vec4 a = imageLoad(tree, ivec3(level_begin(level - 1) + 2 * n, slice, 0));
            vec4 b = imageLoad(tree, ivec3(level_begin(level - 1) + 2 * n + 1, slice, 0));
            imageStore(tree, ivec3(level_begin(level) + n, slice, 0), vec4(min(a.r, b.r), max(a.g, b.g), 0.0, 0.0));
        }
    }
}
#endif

#if defined(SAMPLE) || defined(SHOW) || defined(SHOW_MOMENTS)
/* An eye ray in its slice: x metres along it, how far along the light's ray there, and in which bin. */
struct slice_ray {
    float sine, cosine, to_light; /* of alpha */
};

float bin_of(slice_ray ray, float x)
{
    float at = ray.sine * x;
    if (!is_sun()) at = atan(at, ray.to_light - ray.cosine * x);
    return clamp(at / slices.sizes.x, 0.0, 1.0) * slices.sizes.z;
}

float place_of(slice_ray ray, float bin)
{
    float at = bin / slices.sizes.z * slices.sizes.x;
    if (is_sun()) return at / max(ray.sine, 1e-6);
    float turned = sin(at) * ray.cosine + cos(at) * ray.sine; /* sin(phi + alpha) */
    return turned > 0.0 ? ray.to_light * sin(at) / turned : VXS_FAR_MOST;
}

float way_of(slice_ray ray, float x)
{
    if (is_sun()) return -ray.cosine * x;
    return length(vec2(ray.sine * x, ray.to_light - ray.cosine * x));
}

/* 1 when all of a node is lit along the ray, -1 when none, 0 when nothing is said. A way to a punctual light is least where the ray
 * is nearest to it. */
int node_lit(slice_ray ray, int slice, int level, int node, float begin, float end)
{
    vec2  first = imageLoad(tree, ivec3(level_begin(level) + node, slice, 0)).rg;
    float one = way_of(ray, begin), two = way_of(ray, end), nearest = ray.cosine * ray.to_light, least = min(one, two);
    if (level == 0) return way_of(ray, 0.5 * (begin + end)) < first.r ? 1 : -1;
    if (!is_sun() && nearest > begin && nearest < end) least = way_of(ray, nearest);
    return max(one, two) < first.r ? 1 : least >= first.g ? -1 : 0;
}

/* Airlight of the path, by the bins of a slice: nodes as large as they can be, from the eye on; what is lit in one piece is added
 * in one. */
vec3 walk(vxs_medium medium, vxs_air_path path, slice_ray ray, int slice)
{
    vec3  sum = vec3(0.0), air;
    int   bins = int(slices.sizes.z), last_level = slices.across.w > 0.0 ? 0 : findMSB(bins), level = 0;
    int   last = min(int(bin_of(ray, path.end)), bins - 1), bin = min(int(bin_of(ray, path.begin)), last);
    float at = path.begin, lit_from = -1.0;
    while (bin <= last) {
        while (level < last_level && (bin & ((2 << level) - 1)) == 0 && bin + (2 << level) <= last + 1) level++;
        while (level > 0 && ((bin & ((1 << level) - 1)) != 0 || bin + (1 << level) > last + 1)) level--;
        float end = bin + (1 << level) > last ? path.end : clamp(place_of(ray, float(bin + (1 << level))), at, path.end);
        int   lit = node_lit(ray, slice, level, bin >> level, at, end);
        while (lit == 0) {
            level--;
            end = bin + (1 << level) > last ? path.end : clamp(place_of(ray, float(bin + (1 << level))), at, path.end);
            lit = node_lit(ray, slice, level, bin >> level, at, end);
        }
        if (lit > 0 && lit_from < 0.0) lit_from = at;
        if (lit < 0 && lit_from >= 0.0) {
            vxs_air_lit(medium, path, lit_from, at, air);
            sum += air;
            lit_from = -1.0;
        }
        bin += 1 << level;
        at = end;
    }
    if (lit_from >= 0.0) {
        vxs_air_lit(medium, path, lit_from, path.end, air);
        sum += air;
    }
    return sum;
}

vec3 walk_towards(vec3 direction, float metres, int slice)
{
    vxs_air_path path = vxs_eye_path(direction, metres);
    if (!(path.end > path.begin)) return vec3(0.0);
    slice_ray ray = slice_ray(length(cross(direction, slices.axis.xyz)), dot(direction, slices.axis.xyz), slices.axis.w);
    return walk(vxs_frame_medium(), path, ray, slice);
}
#endif

#ifdef SAMPLE
void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), pixel;
    if (at.x >= int(slices.sizes.w)) return;
    float alpha     = slices.angles.z + (float(at.x) + 0.5) / slices.sizes.w * slices.angles.w, metres = vxs_frame.eye_far.w;
    vec3  direction = cos(alpha) * slices.axis.xyz + sin(alpha) * side_of_slice(float(at.y));
    vec4  seen      = slices.depth_from_point * vec4(vxs_frame.eye_far.xyz + direction, 1.0);
    vec2  place     = seen.xy / seen.w * vxs_frame.sizes.xy;
    bool  is_seen   = seen.w > 0.0 && all(greaterThan(place, vec2(-1.0))) && all(lessThan(place, vxs_frame.sizes.xy + 1.0));
    if (!is_seen) { /* no pixel is near */
        imageStore(samples, ivec3(at, 0), vec4(0.0, 0.0, 0.0, -1.0));
        return;
    }
    vxs_eye_ray(clamp(ivec2(floor(place)), ivec2(0), ivec2(vxs_frame.sizes.xy) - 1), metres);
    imageStore(samples, ivec3(at, 0), vec4(walk_towards(direction, metres, at.y), metres));
}
#endif

#ifdef SHOW
void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(slices.sizes.wy);
    float metres;
    if (pixel.x >= int(vxs_frame.sizes.x)) return;
    vec3  direction = vxs_eye_ray(pixel, metres);
    float u = dot(direction, slices.up.xyz), v = dot(direction, slices.across.xyz);
    float turned = mod(atan(v, u) - slices.angles.x, 6.283185307), slice = turned / slices.angles.y * slices.sizes.y - 0.5;
    float alpha = atan(length(vec2(u, v)), dot(direction, slices.axis.xyz));
    float at    = (alpha - slices.angles.z) / slices.angles.w * slices.sizes.w - 0.5;
    vec4  sum = vec4(0.0);
    ivec2 first = ivec2(floor(vec2(at, slice)));
    for (int n = 0; n < 4 && size.x > 0; n++) { /* the four samples about it, where they end near the pixel's own place */
        ivec2 to     = first + ivec2(n & 1, n >> 1);
        vec2  part   = 1.0 - abs(vec2(at, slice) - vec2(to));
        to.y         = slices.angles.y > 6.28 ? (to.y + size.y) % size.y : to.y;
        vec4  found  = imageLoad(samples, ivec3(clamp(to, ivec2(0), size - 1), 0));
        float weight = part.x * part.y * (abs(found.a - metres) < 0.05 * metres ? 1.0 : 0.0);
        sum += weight * vec4(found.rgb, 1.0);
    }
    vec3 air = sum.a > 0.2 ? sum.rgb / sum.a : walk_towards(direction, metres, clamp(int(round(slice)), 0, size.y - 1));
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(air * vxs_frame.colour.rgb, 0.0));
}
#endif

/* An angle at the eye in the view's range as [-1, 1]. Shadow only begins farther from the axis. */
float moment_place(float alpha)
{
    return clamp(2.0 * (alpha - slices.angles.z) / slices.angles.w - 1.0, -1.0, 1.0);
}

#ifdef SUM
void main()
{
    int  slice = int(gl_GlobalInvocationID.x), bins = int(slices.sizes.z);
    vec4 sum   = vec4(0.0);
    if (slice >= int(slices.sizes.y)) return;
    imageStore(samples, ivec3(0, slice, 0), sum);
    for (int n = 0; n < bins; n++) {
        float bin = (float(n) + 0.5) / slices.sizes.z * slices.sizes.x, first = imageLoad(tree, ivec3(n, slice, 0)).r, z = 1.0;
        if (first < VXS_NO_END)
            z = moment_place(is_sun() ? atan(bin, -first) : atan(first * sin(bin), slices.axis.w - first * cos(bin)));
        sum += vec4(z, z * z, z * z * z, z * z * z * z);
        imageStore(samples, ivec3(n + 1, slice, 0), sum);
    }
}
#endif

#ifdef SHOW_MOMENTS
vec4 sum_before(float bin, int slice)
{
    int n = int(floor(bin));
    return mix(imageLoad(samples, ivec3(n, slice, 0)), imageLoad(samples, ivec3(min(n + 1, int(slices.sizes.z)), slice, 0)),
               bin - float(n));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    float metres;
    if (pixel.x >= int(vxs_frame.sizes.x)) return;
    vec3         direction = vxs_eye_ray(pixel, metres), sum = vec3(0.0), air;
    vxs_air_path path      = vxs_eye_path(direction, metres);
    if (!(path.end > path.begin)) return;
    vxs_medium medium = vxs_frame_medium();
    slice_ray  ray    = slice_ray(length(cross(direction, slices.axis.xyz)), dot(direction, slices.axis.xyz), slices.axis.w);
    float turned = mod(atan(dot(direction, slices.across.xyz), dot(direction, slices.up.xyz)) - slices.angles.x, 6.283185307);
    int   slice  = clamp(int(turned / slices.angles.y * slices.sizes.y), 0, int(slices.sizes.y) - 1), parts = int(slices.up.w);
    float begin = bin_of(ray, path.begin), end = bin_of(ray, path.end), z = moment_place(atan(ray.sine, ray.cosine));
    float from = path.begin;
    for (int n = 0; n < parts; n++) {
        float one = mix(begin, end, float(n) / float(parts)), two = mix(begin, end, float(n + 1) / float(parts));
        float to  = n + 1 == parts ? path.end : clamp(place_of(ray, two), from, path.end);
        vec4  all = sum_before(two, slice) - sum_before(one, slice);
        vxs_air_lit(medium, path, from, to, air);
        if (two - one > 1e-6) sum += air * part_above(all / (two - one), z);
        from = to;
    }
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(sum * vxs_frame.colour.rgb, 0.0));
}
#endif
