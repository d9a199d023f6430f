/* A scene that was read, with its casters: the input of bakes of any of its lights.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_SCENE_H
#define BAKE_SCENE_H

#include "baker/bake/bake_options.h"
#include "baker/base/context.h"
#include "baker/scene/fingerprint.h"
#include "baker/smoke/smoke_grid.h"

/* Zero it. */
typedef struct bake_scene {
    scene             scene;
    scene_fingerprint fingerprint;
    casters           casters;
    smoke_grid        smoke;      /* zeroed if there is none */
    uint64_t          file_bytes; /* of the scene's file; 0: not known. Buffer files of a .gltf are not counted */
} bake_scene;

/* Read o->scene_path, and compute its fingerprint.
 * check  NULL: none
 * Returns what scene_load_gltf_checked returns. */
vxs_result bake_scene_read(bake_scene *s, const bake_options *o, const scene_check *check, bake_context *ctx);

/* Read the smoke grid that the options name, if any.   Returns what nrrd_read returns. */
vxs_result bake_scene_read_smoke(bake_scene *s, const bake_options *o, bake_context *ctx);

/* The smoke that is baked.   Valid until bake_scene_free. */
smoke_source bake_scene_smoke(const bake_scene *s, const bake_options *o);

/* Find the casters of a scene that was read.   Returns what casters_for_maps and context_check return. */
vxs_result bake_scene_find_casters(bake_scene *s, const bake_options *o, bake_context *ctx);

/* Accepts a zeroed object. */
void bake_scene_free(bake_scene *s);

#endif
