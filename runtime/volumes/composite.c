/* Blends the frame's fog over a picture; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include "volumes_state.h"

void vxs_volumes_composite(vxs_volumes *v)
{
    if (!v->depth_texture || (v->is_half && vxs_volumes_end_half(v) != VXS_OK)) return;
    gl_name program = vxs_volumes_program(
        v, &(program_texts){.vertex = &vxs_volumes_text_screen_vert_glsl, .body = &vxs_volumes_text_composite_frag_glsl});
    int draws = vxs_volumes_can_draw(v);
    if (vxs_volumes_done(v) != VXS_OK || !draws) return;
    saved_state  saved  = vxs_volumes_use(v, program, 0, 0, 0);
    saved_raster raster = vxs_volumes_draw(v, GL_BLEND_ONE, GL_BLEND_SRC1_COLOUR, GL_BLEND_ONE);
    v->api.DrawArrays(GL_MODE_TRIANGLES, 0, 3);
    vxs_volumes_restore_raster(v, &raster);
    vxs_volumes_restore(v, &saved);
}
