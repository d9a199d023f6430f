/* Opening a .vxs file for a command; an error message names the first finding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_OPEN_H
#define ASSET_OPEN_H

#include <jansson.h>

#include "baker/base/message.h"
#include "baker/base/text.h"
#include "baker/scene/scene.h"
#include "runtime/vxs.h"

/* What was found first in a file that cannot be opened; number 0: nothing. */
typedef struct first_finding {
    int         number, section;
    uint64_t    offset;
    const char *text;
} first_finding;

/* A vxs_finding_fn whose user is a first_finding. */
void keep_first_finding(void *user, int number, const char *text, int section, uint64_t offset);

/* One line that says why an asset cannot be opened.   remedy  against too little memory.   Returns r, which is not VXS_OK. */
vxs_result asset_fail(const char *path, vxs_result r, const first_finding *f, const char *remedy, message *m);

/* As vxs_asset_open_file, of any input (input_file.h). One line in m only when the bytes could not be had. */
vxs_result asset_read(vxs_asset **asset, const char *path, const vxs_read_desc *desc, message *m);

/* On all processors, with a limit on what is held of the file, 0: the reader's own; metadata: whether it is read, too. */
vxs_result asset_open_within(vxs_asset **asset, const char *path, uint64_t memory_bytes, int metadata, message *m);

/* On so many threads.
 * asset  [out] NULL on failure; closed with vxs_asset_close.   Returns what vxs_asset_open_file returns. */
vxs_result asset_open(vxs_asset **asset, const char *path, uint32_t threads, message *m);

/* The size of an open file: its last section ends where it does. */
uint64_t asset_file_bytes(const vxs_asset *asset);

/* Where the command line does not say what of a scene casts, what was said when an asset was baked.
 * made  its metadata (provenance_read), whose texts choice has from now on
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result asset_scene_choice(const json_t *made, scene_choice *choice, message *m);

/* Warn where a scene is not the one that an asset was baked from: no fault of either, and rarely what is wanted.
 * asset        its lights count
 * made         its metadata
 * consequence  "its shadows may not fit"
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result asset_check_scene(const vxs_contents *asset, const json_t *made, const char *path, const scene *s,
                             const char *scene_path, const char *consequence, message *m);

/* Choose lights of a file by name: all of them, in file order, when there is no name; else the named ones, in the order given.
 * What is no name is a pattern (light_choice.h), and stands for all that it names, in file order, but for those that are there
 * already.
 * path    for messages
 * lights  [out] [VXS_LIGHTS_MAX] valid as long as the contents are
 * Returns VXS_OK or VXS_E_ARGUMENT: no such light, or one given twice. */
vxs_result asset_choose_lights(const vxs_contents *asset, const char *path, const text_list *names, const vxs_baked_light **lights,
                               uint32_t *count, message *m);

/* What smoke leaves of lights that were chosen.   smoke  [out] [count] NULL: the light has none */
void asset_find_smoke(const vxs_asset *asset, const vxs_baked_light *const *lights, uint32_t count, const vxs_baked_smoke **smoke);

#endif
