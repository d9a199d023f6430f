/* Curves of other kinds, of the lists of a map of transmittance curves: rival_left says what is left of light at a depth; BUILD
 * makes them, a texel an invocation. */
layout(std140, binding = VXS_AT_OWN) uniform rival_block { float nearest, farthest, knob; } rival_of; /* depths */
layout(std430, binding = VXS_AT_GRID + 1) restrict buffer rival_buffer {
    uint rival_used, rival_nodes, rival_reserved_0, rival_reserved_1; /* of deep shadow maps: events, and nodes that are left of them */
    uint rival_words[];
};

const float TWO_PI = 6.283185307;

float rival_number(uint at)
{
    return uintBitsToFloat(rival_words[at]);
}

/* A depth in the range as [0, 1]. */
float rival_place(float depth)
{
    return clamp((depth - rival_of.nearest) / (rival_of.farthest - rival_of.nearest), 0.0, 1.0);
}

vec3 rival_segment(uint n)
{
    uint at = vxs_curve_segment(n);
    return vec3(uintBitsToFloat(vxs_curves.words[at]), uintBitsToFloat(vxs_curves.words[at + 1u]), uintBitsToFloat(vxs_curves.words[at + 2u]));
}

uint rival_next(uint n)
{
    return vxs_curves.words[vxs_curve_segment(n) + 3u];
}

/* Optical depth of a segment; what is opaque has that of e^-20. */
float rival_depth(vec3 segment)
{
    return -log(max(segment.z, 2e-9));
}

#ifdef OPACITY
float rival_left(uint texel, float depth)
{
    float at = rival_place(depth) * float(KNOB) - 1.0; /* slice n ends at n + 1 */
    int   n = int(floor(at));
    float before = n >= 0 ? rival_number(texel * uint(KNOB) + uint(n)) : 0.0, behind = rival_number(texel * uint(KNOB) + uint(min(n + 1, KNOB - 1)));
    return exp(-mix(before, behind, at - float(n)));
}

void rival_build(uint texel, uint first)
{
    for (int k = 0; k < KNOB; k++) {
        float place = float(k + 1) / float(KNOB), sum = 0.0;
        for (uint n = first; n != VXS_NO_SEGMENT; n = rival_next(n)) {
            vec3  s = rival_segment(n);
            float entry = rival_place(s.x), exit = rival_place(s.y);
            sum += rival_depth(s) * (place >= exit ? 1.0 : clamp((place - entry) / max(exit - entry, 1e-9), 0.0, 1.0));
        }
        rival_words[texel * uint(KNOB) + uint(k)] = floatBitsToUint(sum);
    }
}
#endif

#ifdef FOURIER
/* Of each term k from 1 on, twice the mean of cos and sin (2 pi k z) over extinction; of term 0 that of 1. */
float rival_left(uint texel, float depth)
{
    uint  at = texel * uint(2 * KNOB);
    float z = rival_place(depth), sum = 0.5 * z * rival_number(at);
    for (int k = 1; k < KNOB; k++) {
        float turn = TWO_PI * float(k);
        sum += (rival_number(at + uint(2 * k)) * sin(turn * z) + rival_number(at + uint(2 * k + 1)) * (1.0 - cos(turn * z))) / turn;
    }
    return clamp(exp(-sum), 0.0, 1.0);
}

void rival_build(uint texel, uint first)
{
    for (int k = 0; k < KNOB; k++) {
        float turn = TWO_PI * float(k);
        vec2  sum = vec2(0.0);
        for (uint n = first; n != VXS_NO_SEGMENT; n = rival_next(n)) {
            vec3  s = rival_segment(n);
            float entry = rival_place(s.x), exit = rival_place(s.y), half_of_it = 0.5 * turn * (exit - entry), middle = 0.5 * turn * (entry + exit);
            sum += 2.0 * rival_depth(s) * (half_of_it > 1e-3 ? sin(half_of_it) / half_of_it : 1.0) * vec2(cos(middle), sin(middle));
        }
        rival_words[texel * uint(2 * KNOB) + uint(2 * k)]     = floatBitsToUint(sum.x);
        rival_words[texel * uint(2 * KNOB) + uint(2 * k + 1)] = floatBitsToUint(sum.y);
    }
}
#endif

#ifdef MOMENTS
float rival_left(uint texel, float depth)
{
    uint  at = texel * 5u;
    float all = rival_number(at);
    if (!(all > 0.0)) return 1.0;
    vec4 moments = vec4(rival_number(at + 1u), rival_number(at + 2u), rival_number(at + 3u), rival_number(at + 4u)) / all;
    return exp(-all * (1.0 - part_above(moments, 2.0 * rival_place(depth) - 1.0)));
}

/* The mean of z^n over a segment of even extinction, z in [-1, 1]: of Gauss' three places, which is exact up to n = 5. */
void rival_build(uint texel, uint first)
{
    float sums[5] = float[5](0.0, 0.0, 0.0, 0.0, 0.0);
    for (uint n = first; n != VXS_NO_SEGMENT; n = rival_next(n)) {
        vec3  s = rival_segment(n);
        float entry = 2.0 * rival_place(s.x) - 1.0, exit = 2.0 * rival_place(s.y) - 1.0;
        for (int place = -1; place <= 1; place++) {
            float z = 0.5 * (entry + exit) + 0.5 * (exit - entry) * 0.7745966692 * float(place), power = rival_depth(s) * (place == 0 ? 8.0 : 5.0) / 18.0;
            for (int k = 0; k < 5; k++) {
                sums[k] += power;
                power *= z;
            }
        }
    }
    for (uint k = 0u; k < 5u; k++) rival_words[texel * 5u + k] = floatBitsToUint(sums[k]);
}
#endif

#ifdef DEEP
/* Of a texel where its nodes begin, and how many there are; then, of all texels, depth and what is left. */
uint rival_first_node(uint texel)
{
    return 2u * vxs_curve_map.side * vxs_curve_map.side * vxs_curve_map.layers + 4u * rival_words[2u * texel];
}

float rival_left(uint texel, float depth)
{
    uint first = rival_first_node(texel), low = 0u, high = rival_words[2u * texel + 1u];
    if (high == 0u || depth <= rival_number(first)) return 1.0;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (rival_number(first + 2u * middle) > depth)
            high = middle;
        else
            low = middle;
    }
    float before = rival_number(first + 2u * low), left = rival_number(first + 2u * low + 1u);
    if (high < rival_words[2u * texel + 1u])
        left = mix(left, rival_number(first + 2u * high + 1u), (depth - before) / (rival_number(first + 2u * high) - before));
    return clamp(left, 0.0, 1.0); /* the tolerance leads beyond */
}

/* An event: a depth, and how much extinction begins there. Into its place among those before it: four words each, of which nodes
 * will take two. */
void rival_add_event(uint first, uint count, float depth, float extinction)
{
    uint at = first + 4u * count;
    for (; at > first && rival_number(at - 4u) > depth; at -= 4u) {
        rival_words[at]      = rival_words[at - 4u];
        rival_words[at + 1u] = rival_words[at - 3u];
    }
    rival_words[at]      = floatBitsToUint(depth);
    rival_words[at + 1u] = floatBitsToUint(extinction);
}

void rival_build(uint texel, uint list)
{
    uint count = 0u;
    for (uint n = list; n != VXS_NO_SEGMENT; n = rival_next(n)) count += 2u;
    rival_words[2u * texel]      = atomicAdd(rival_used, count);
    rival_words[2u * texel + 1u] = 0u;
    uint first = rival_first_node(texel), added = 0u, nodes = 0u;
    if (count == 0u) return;
    for (uint n = list; n != VXS_NO_SEGMENT; n = rival_next(n)) {
        vec3  s = rival_segment(n);
        float exit = max(s.y, s.x + 1e-6 * max(1.0, abs(s.x))), extinction = rival_depth(s) / (exit - s.x);
        rival_add_event(first, added++, s.x, extinction);
        rival_add_event(first, added++, exit, -extinction);
    }
    /* from a node, slopes that pass all depths since within the tolerance; where none is left, a node at the last depth, on the
     * middle slope */
    float tolerance = rival_of.knob, begin = rival_number(first), from = 1.0, low = -1e30, high = 1e30, depth = begin, sum = 0.0, rate = 0.0;
    for (uint n = 0u; n < count; n++) {
        float at = rival_number(first + 4u * n);
        sum += max(rate, 0.0) * (at - depth);
        rate += rival_number(first + 4u * n + 1u);
        float left = exp(-sum), wide = max(at - begin, 1e-9);
        if (max(low, (left - tolerance - from) / wide) > min(high, (left + tolerance - from) / wide)) {
            rival_words[first + 2u * nodes]      = floatBitsToUint(begin);
            rival_words[first + 2u * nodes + 1u] = floatBitsToUint(from);
            nodes++;
            from += 0.5 * (low + high) * (depth - begin);
            begin = depth;
            low   = -1e30;
            high  = 1e30;
            wide  = max(at - begin, 1e-9);
        }
        if (at > begin) {
            low  = max(low, (left - tolerance - from) / wide);
            high = min(high, (left + tolerance - from) / wide);
        }
        depth = at;
    }
    float last = high < 1e30 ? from + 0.5 * (low + high) * (depth - begin) : from;
    uint  at = first + 2u * nodes;
    rival_words[at]      = floatBitsToUint(begin);
    rival_words[at + 1u] = floatBitsToUint(from);
    rival_words[at + 2u] = floatBitsToUint(depth);
    rival_words[at + 3u] = floatBitsToUint(last);
    rival_words[2u * texel + 1u] = nodes + 2u;
    atomicAdd(rival_nodes, nodes + 2u);
}
#endif

#ifdef UNCOMPRESSED
float rival_left(uint texel, float depth)
{
    float sum = 0.0;
    for (uint n = vxs_curves.words[vxs_curve_record(texel)]; n != VXS_NO_SEGMENT; n = rival_next(n)) {
        vec3 s = rival_segment(n);
        if (depth > s.x) sum += rival_depth(s) * (depth >= s.y ? 1.0 : (depth - s.x) / (s.y - s.x));
    }
    return exp(-sum);
}

void rival_build(uint texel, uint first)
{
}
#endif

#ifdef BUILD
layout(local_size_x = 8, local_size_y = 8) in;
void main()
{
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at.xy, ivec2(vxs_curve_map.side)))) return;
    uint texel = vxs_curve_texel(at);
    rival_build(texel, vxs_curves.words[vxs_curve_record(texel)]);
}
#endif
