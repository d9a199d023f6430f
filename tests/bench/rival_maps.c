/* The depth maps that rivals share; see rival.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/lab/opengl/depth_gl.h"
#include "tests/bench/rival.h"

static vxs_result render(rival_maps *out, const bake_options *o, run_context *m)
{
    gl_context     *gl       = NULL;
    depth_renderer *renderer = NULL;
    exit_mode       exit     = out->plan.peels_all ? EXIT_PEEL : o->exit;
    uint32_t        side     = 1u << out->levels;
    double          start    = clock_seconds();
    vxs_result      r;
    if ((r = gl_context_create(&gl, o->gl, o->threads, m)) != VXS_OK) goto done;
    snprintf(out->renderer, sizeof out->renderer, "%s", gl->names.renderer);
    if ((r = depth_maps_init(&out->maps, side, side, 0, out->plan.has_exit_map, m)) != VXS_OK) goto done;
    if ((r = depth_renderer_create(&renderer, gl, &out->casters, &out->light, 0, exit, o->threads, m)) != VXS_OK) goto done;
    r = depth_renderer_tile(renderer, &out->maps, 0, 0, m);
done:
    depth_renderer_destroy(renderer);
    if (gl) gl_context_destroy(gl);
    out->checked      = out->maps.enter;
    out->checked_exit = out->maps.exit;
    out->seconds      = clock_seconds() - start;
    return r;
}

vxs_result rival_maps_render(rival_maps *out, const bake_options *o, run_context *m)
{
    light_choice chosen = {0};
    vxs_result   r;
    memset(out, 0, sizeof *out);
    if ((r = scene_load_gltf(&out->scene, o->scene_path, NULL, m)) != VXS_OK) goto done;
    if ((r = casters_for_maps(&out->casters, &out->scene, o->closed, 2, m)) != VXS_OK) goto done;
    if ((r = lights_choose(&out->scene, &o->light_names, &o->suns, &chosen, m)) != VXS_OK) goto done;
    if ((r = plan_make(&out->plan, o, &out->casters, NULL, &chosen, 0, m)) != VXS_OK) goto done;

    size_t n = 0;
    while (n < out->plan.light_count &&
           (out->plan.lights[n].left_out || out->plan.lights[n].light.kind != VXS_LIGHT_KIND_DIRECTIONAL))
        n++;
    if (n == out->plan.light_count) {
        r = fail(m, VXS_E_NO_LIGHT, "%s: no directional light: expected one, or --sun X,Y,Z", o->scene_path);
        goto done;
    }
    out->light  = out->plan.lights[n].light;
    out->levels = out->light.levels;
    r           = render(out, o, m);
done:
    light_choice_free(&chosen);
    return r;
}

vxs_result rival_maps_spoil(rival_maps *maps, run_context *m)
{
    size_t texels = (size_t)1 << 2 * maps->levels, nearest = 0, bytes = texels * sizeof *maps->checked;
    float *enter = malloc(bytes), *exit = malloc(bytes);
    if (!enter || !exit) {
        free(enter);
        free(exit);
        return fail(m, VXS_E_MEMORY, "out of memory for another pair of depth maps");
    }
    maps->checked      = memcpy(enter, maps->maps.enter, bytes);
    maps->checked_exit = memcpy(exit, maps->maps.exit, bytes);
    for (size_t n = 1; n < texels; n++)
        if (exit[n] < exit[nearest]) nearest = n;
    maps->maps.enter[nearest] = maps->maps.exit[nearest] = 1;
    return VXS_OK;
}

void rival_maps_free(rival_maps *maps)
{
    if (maps->checked != maps->maps.enter) {
        free(maps->checked);
        free(maps->checked_exit);
    }
    depth_maps_free(&maps->maps);
    plan_free(&maps->plan);
    casters_free(&maps->casters);
    scene_free(&maps->scene);
    memset(maps, 0, sizeof *maps);
}

void rival_maps_contract(const rival_maps *maps, uint32_t i, uint32_t j, uint32_t k, int *must_be_lit, int *must_be_dark)
{
    size_t at     = ((size_t)j << maps->levels) + i;
    double side   = (double)(1u << maps->levels);
    *must_be_lit  = (double)k + 1 <= (double)maps->checked[at] * side;
    *must_be_dark = (double)k >= (double)maps->checked_exit[at] * side;
}
