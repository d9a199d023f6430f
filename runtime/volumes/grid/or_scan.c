/* See or_scan.h.
 * SPDX-License-Identifier: MIT */
#include "or_scan.h"

enum { PASS_GROUP = 256, GROUPS_ACROSS = 32768 };

vxs_result vxs_or_scan_create(or_scan *scan, vxs_volumes *v, uint64_t size_bytes)
{
    *scan = (or_scan){.volumes = v};
    if (size_bytes) scan->other = vxs_volumes_buffer(v, size_bytes);
    return scan->other || !size_bytes ? VXS_OK : VXS_E_MEMORY;
}

void vxs_or_scan_destroy(or_scan *scan)
{
    if (scan->other) scan->volumes->api.DeleteBuffers(1, &scan->other);
    *scan = (or_scan){0};
}

static void dispatch(const or_scan *scan, uint32_t groups, uint32_t length, uint32_t segments, uint32_t first, uint32_t step)
{
    vxs_volumes *v      = scan->volumes;
    uint32_t     across = groups < GROUPS_ACROSS ? groups : GROUPS_ACROSS;
    v->own.or_scan      = (or_scan_block){length, segments, first, step};
    gl_name program     = vxs_volumes_program(
            v, &(program_texts){.names = scan->other ? "#define VXS_SCAN_STEPS\n" : NULL, .body = &vxs_volumes_text_or_scan_glsl});
    vxs_volumes_run(v, program, 0, 0, across, (groups + across - 1) / across);
}

/* From one buffer to the other and back; with a last copy if the number of passes is odd. */
static void in_passes(const or_scan *scan, gl_name texels, uint32_t first, uint32_t length, uint32_t segments)
{
    const vxs_volumes *v    = scan->volumes;
    gl_name            from = texels, to = scan->other;
    gl_bytes           start = (gl_bytes)first * 16, size = (gl_bytes)length * segments * 16;
    for (uint32_t step = 1; step < length; step *= 2) {
        vxs_volumes_use_storage(v, from, to);
        dispatch(scan, (length * segments + PASS_GROUP - 1) / PASS_GROUP, length, segments, first, step);
        from = to;
        to   = from == texels ? scan->other : texels;
    }
    if (from != texels) v->api.CopyNamedBufferSubData(from, texels, start, start, size);
}

void vxs_or_scan_run(const or_scan *scan, gl_name texels, uint32_t first, uint32_t length, uint32_t segments)
{
    if (!length || !segments) return;
    if (scan->other) {
        in_passes(scan, texels, first, length, segments);
        return;
    }
    vxs_volumes_use_storage(scan->volumes, texels, 0);
    dispatch(scan, segments, length, segments, first, 0);
}
