/* The depths of depth_pages_fill.glsl as the atlas has them, 16 bits each, and the bounds around each tile of 8 x 8 texels. Compiled
 * behind depth_pages.glsl with VXS_PAGES_FILL. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = VXS_PAGES_AT_WORK) restrict buffer vxs_fill_block { uint vxs_fill[]; };

const uint vxs_packed = (8u + VXS_PAGES_STRIDE * VXS_PAGES_STRIDE) * VXS_PAGES_AT_ONCE; /* first word of packed depths */

shared uint vxs_least, vxs_greatest;

uint vxs_filled(uvec2 at)
{
    return vxs_fill[8u * VXS_PAGES_AT_ONCE + (gl_WorkGroupID.z * VXS_PAGES_STRIDE + at.y) * VXS_PAGES_STRIDE + at.x];
}

/* A depth relative to base, in steps of 1 << shift, rounded up so that a texel does not shade itself. */
uint vxs_packed_depth(uint depth, uint never, uint base, uint shift)
{
    return depth >= never ? 65535u : (depth - base + (1u << shift) - 1u) >> shift;
}

void main()
{
    uint  job = 8u * gl_WorkGroupID.z, info = VXS_PAGES_INFO + 4u * vxs_fill[job + 5u];
    uint  never = 1u << (vxs_light_at(vxs_fill[job]).levels - vxs_fill[job + 2u]), base = min(vxs_pages[info], never), shift = 0u;
    uvec2 tile = gl_WorkGroupID.xy, at = gl_GlobalInvocationID.xy;
    bool  is_whole = vxs_pages[info + 2u] == 0u;
    while (vxs_pages[info + 1u] > base && (vxs_pages[info + 1u] - base + (1u << shift) - 1u) >> shift > 65534u) shift++;
    if (gl_LocalInvocationIndex == 0u) {
        vxs_least    = 0xffffffffu;
        vxs_greatest = 0u;
    }
    barrier();
    if (max(tile.x, tile.y) < 16u) { /* the tile at 8 * tile, with the border around it */
        uint around = 8u + 2u * VXS_PAGES_BORDER, least = 0xffffffffu, greatest = 0u;
        for (uint n = gl_LocalInvocationIndex; n < around * around; n += 64u) {
            uint depth = vxs_filled(8u * tile + uvec2(n % around, n / around));
            least    = min(least, depth);
            greatest = max(greatest, depth);
        }
        atomicMin(vxs_least, least);
        atomicMax(vxs_greatest, greatest);
    }
    barrier();
    if (max(tile.x, tile.y) < 16u && gl_LocalInvocationIndex == 0u) {
        uint bounds = VXS_PAGES_BOUNDS + 512u * vxs_fill[job + 5u] + 2u * (16u * tile.y + tile.x);
        vxs_pages[bounds]      = is_whole ? vxs_least : 0u;
        vxs_pages[bounds + 1u] = is_whole ? vxs_greatest : 0xffffffffu;
    }
    if (at == uvec2(0u)) vxs_pages[info + 3u] = is_whole ? base | (shift << 24) : 0xffffffffu;
    if ((at.x & 1u) == 0u && max(at.x, at.y) < VXS_PAGES_STRIDE) {
        uint low = vxs_packed_depth(vxs_filled(at), never, base, shift);
        uint high = vxs_packed_depth(vxs_filled(at + uvec2(1u, 0u)), never, base, shift);
        vxs_fill[vxs_packed + (((gl_WorkGroupID.z * VXS_PAGES_STRIDE + at.y) * VXS_PAGES_STRIDE + at.x) >> 1)] = low | (high << 16);
    }
}
