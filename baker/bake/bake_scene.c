/* Scenes of bakes; see bake_scene.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_scene.h"

#include <sys/stat.h>

#include "baker/smoke/smoke_grid.h"

static uint64_t file_bytes(const char *path)
{
    struct stat s;
    return stat(path, &s) || s.st_size < 0 ? 0 : (uint64_t)s.st_size;
}

vxs_result bake_scene_read(bake_scene *s, const bake_options *o, const scene_check *check, bake_context *ctx)
{
    watch_say(ctx->watch, "reading %s", o->scene_path);
    s->file_bytes = file_bytes(o->scene_path);
    vxs_result r  = scene_load_gltf_checked(&s->scene, o->scene_path, &o->scene, check, ctx->message);
    return r == VXS_OK ? scene_fingerprint_take(&s->fingerprint, &s->scene, ctx->message) : r;
}

vxs_result bake_scene_read_smoke(bake_scene *s, const bake_options *o, bake_context *ctx)
{
    if (!o->smoke_path) return VXS_OK;
    watch_say(ctx->watch, "reading %s", o->smoke_path);
    return nrrd_read(&s->smoke, o->smoke_path, o->smoke_factor, ctx->message);
}

smoke_source bake_scene_smoke(const bake_scene *s, const bake_options *o)
{
    return (smoke_source){.grid     = s->smoke.extinction ? &s->smoke : NULL,
                          .capsules = o->scene_smoke && s->scene.smoke.count ? &s->scene.smoke : NULL};
}

vxs_result bake_scene_find_casters(bake_scene *s, const bake_options *o, bake_context *ctx)
{
    vxs_result r;
    stage_begin(ctx, STAGE_SOLIDS);
    if ((r = context_check(ctx)) != VXS_OK) return r;
    watch_say(ctx->watch, "telling solids from sheets");
    return casters_for_maps(&s->casters, &s->scene, o->closed, o->threads, ctx->message);
}

void bake_scene_free(bake_scene *s)
{
    casters_free(&s->casters);
    smoke_grid_free(&s->smoke);
    scene_free(&s->scene);
    *s = (bake_scene){0};
}
