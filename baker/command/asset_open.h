/* Opening a .vxs file for a command; an error message names the first finding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_OPEN_H
#define ASSET_OPEN_H

#include <jansson.h>

#include "baker/base/run_context.h"
#include "baker/base/text.h"
#include "baker/scene/scene.h"
#include "formats/vxs_write_file.h"
#include "runtime/vxs.h"
#include "runtime/vxs_stream.h"

/* The first finding in a file that cannot be opened. number 0: no finding. */
typedef struct first_finding {
    int         number, section;
    uint64_t    offset;
    const char *text;
} first_finding;

/* A vxs_finding_fn whose user is a first_finding. */
void keep_first_finding(void *user, int number, const char *text, int section, uint64_t offset);

/* Report in one line why an asset cannot be opened.
 * remedy  appended to the line when memory is too small
 * Returns r, which is not VXS_OK. */
vxs_result asset_fail(const char *path, vxs_result r, const first_finding *f, const char *remedy, run_context *m);

/* As vxs_asset_open_file, for any input (input_file.h). Sets the message only when the bytes could not be read. */
vxs_result asset_read(vxs_asset **asset, const char *path, const vxs_read_desc *desc, run_context *m);

/* The same, and keep the bytes of the file.   kept  [out] released with free(kept->data), whatever is returned */
vxs_result asset_read_keeping(vxs_asset **asset, vxs_bytes *kept, const char *path, const vxs_read_desc *desc, run_context *m);

/* Open a file, on `threads` threads. The message names the first finding.
 * asset         [out] NULL on failure; closed with vxs_asset_close
 * memory_bytes  limit on memory for the file; 0: the reader's default
 * metadata      1: read the metadata, too
 * Returns what vxs_asset_open_file returns. */
vxs_result asset_open(vxs_asset **asset, const char *path, uint64_t memory_bytes, int metadata, uint32_t threads, run_context *m);

/* The size of an open file: the end of its last section. */
uint64_t asset_file_bytes(const vxs_asset *asset);

/* Use the scene options of the asset's bake. If the command line gives any of these options itself, change nothing.
 * made  the asset's metadata (provenance_read); choice borrows its texts
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result asset_scene_choice(const json_t *made, scene_choice *choice, run_context *m);

/* Warn when the scene differs from the one that the asset was baked from. This is no error, but rarely intended.
 * asset        only its lights are used
 * made         its metadata
 * consequence  "its shadows may not fit"
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result asset_check_scene(const vxs_contents *asset, const json_t *made, const char *path, const scene *s,
                             const char *scene_path, const char *consequence, run_context *m);

/* Choose lights of a file by name. Without names: all lights, in file order. With names: in the order given. A text that is not
 * the name of a light is a pattern (light_choice.h): it adds all lights that match, in file order, except those already chosen.
 * path    for messages
 * lights  [out] [VXS_LIGHTS_MAX] valid as long as the contents are
 * Returns VXS_OK or VXS_E_ARGUMENT: no such light, or one given twice. */
vxs_result asset_choose_lights(const vxs_contents *asset, const char *path, const text_list *names, const vxs_baked_light **lights,
                               uint32_t *count, run_context *m);

/* Find the baked smoke of chosen lights.   smoke  [out] [count] NULL: the light has none */
void asset_find_smoke(const vxs_asset *asset, const vxs_baked_light *const *lights, uint32_t count, const vxs_baked_smoke **smoke);

/* A .vxs file opened as a stream, as a game does it; errors become messages. */

typedef struct asset_stream {
    vxs_stream      *stream;
    const char      *path;
    vxs_contents     contents; /* chosen lights, and metadata; no sections */
    vxs_baked_points points;   /* of casters; coordinates NULL: there are none, or they are not wanted */
    vxs_result       broken;   /* result of the first page that failed to load, and its message */
    char             broken_text[192];
} asset_stream;

/* Open a file, not a pipe, within a memory budget.
 * s      [out] must not be moved; released with asset_stream_close, whatever is returned
 * names  of the lights that are wanted; empty: all lights
 * points 1: also hold the points of casters, in addition to the budget
 * lights, light_count  [out] the chosen lights, as in asset_choose_lights
 * smoke  [out] [VXS_LIGHTS_MAX] baked smoke of each light; NULL: it has none
 * Returns VXS_OK; VXS_E_ARGUMENT: a pipe, no such light, or one given twice; VXS_E_MEMORY: the budget is too small, and the
 * message states the smallest one; VXS_E_READ and others as vxs_stream_open. */
vxs_result asset_stream_open(asset_stream *s, const char *path, uint64_t budget_bytes, const text_list *names, int points,
                             const vxs_baked_light **lights, const vxs_baked_smoke **smoke, uint32_t *light_count, run_context *m);

/* Update the stream for an eye. First waits for the pages that the last frame requested, so that the result depends only on
 * earlier frames, not on timing.
 * status  [in, out] as for vxs_stream_frame
 * Returns VXS_OK, VXS_E_READ or VXS_E_CORRUPT: a page could not be loaded. */
vxs_result asset_stream_frame(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, run_context *m);

/* Repeat frames until no page is pending: all pages that fit are loaded. The status counts the pages that appeared and left in
 * all of these frames. */
vxs_result asset_stream_fill(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, run_context *m);

/* Accepts a zeroed object. */
void asset_stream_close(asset_stream *s);

#endif
