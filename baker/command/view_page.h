/* The page of vxs view: a template, into which a scene, its baked shadows and texts are written.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VIEW_PAGE_H
#define VIEW_PAGE_H

#include <jansson.h>

#include "baker/base/run_context.h"
#include "formats/vxs_write_file.h"

/* The template, cut where the level is put. */
typedef struct view_page {
    uint8_t *bytes; /* owned */
    size_t   head_bytes, tail_begin, size_bytes;
} view_page;

/* Read the template: from a path; or, when it is NULL, from the first place that has one: $VXS_DATA/view.html, and beside the
 * program ../share/vxs/view.html and ../web/view.html.
 * page  [out] released with view_page_free, whatever is returned
 * Returns VXS_OK; VXS_E_READ: there is none, or it is not this template; VXS_E_MEMORY. */
vxs_result view_page_read(view_page *page, const char *path, run_context *m);

typedef struct view_level {
    const char      *scene_path, *asset_path; /* asset_path NULL: baked by this run */
    int              allow_outside;
    const char      *scene_name; /* name or index of the glTF scene; NULL: the file's */
    const vxs_bytes *asset;      /* a .vxs file */
    json_t          *warnings;   /* of the asset's bake: an array of strings, borrowed; the page also has those of this run */
} view_level;

/* Sizes of what a page holds, bytes. */
typedef struct view_sizes {
    uint64_t page, scene; /* scene: with its buffers and images */
} view_sizes;

/* Write the page. One file of the scene is in memory at a time, beside the scene's own.
 * path  "-" is standard output
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY, or what scene_visit_files_gltf returns. */
vxs_result view_page_write(const char *path, const view_page *page, const view_level *level, view_sizes *sizes, run_context *m);

/* Accepts a zeroed object. */
void view_page_free(view_page *page);

#endif
