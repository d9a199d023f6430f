/* A pass of a rival; see rival_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/rival_pass.h"

#include <stdlib.h>
#include <string.h>

gl_name rival_program(const vxs_volumes *v, const char *names, const volumes_text *with, const embedded *texts, size_t count)
{
    static const volumes_text *const needs[] = {&vxs_volumes_text_frame_glsl, NULL};
    size_t                           size    = 0;
    for (size_t n = 0; n < count; n++) size += (size_t)(texts[n].end - texts[n].begin);
    char *body = malloc(size + 1), *to = body;
    if (!body) abort();
    for (size_t n = 0; n < count; to += texts[n].end - texts[n].begin, n++)
        memcpy(to, texts[n].begin, (size_t)(texts[n].end - texts[n].begin));
    *to             = 0;
    gl_name program = vxs_volumes_compile(v, &(program_texts){.names = names, .with = with, .body = &(volumes_text){body, needs}});
    free(body);
    return program;
}

void rival_run(vxs_volumes *v, gl_name program, const vxs_shadow_depth_map *map, gl_name image, gl_enum format, uint32_t x,
               uint32_t y, uint32_t z)
{
    saved_state saved = vxs_volumes_use(v, program, vxs_shadow_depth_map_texture(map), v->airlight, GL_FORMAT_RGBA32F);
    v->api.BindImageTexture(RIVAL_IMAGE, image, 0, 1, 0, GL_ACCESS_READ_WRITE, format);
    v->api.DispatchCompute(x, y, z);
    v->api.BindImageTexture(RIVAL_IMAGE, 0, 0, 0, 0, GL_ACCESS_READ_WRITE, format);
    vxs_volumes_restore(v, &saved);
}
