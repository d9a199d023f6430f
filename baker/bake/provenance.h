/* Provenance of an asset: metadata that is written, read, and compared with a scene (formats/vxs.md, section 4).
 *
 * All input of a bake is known as soon as the scene is read. It is stored in the file, so that a scene and options can later be
 * compared with those of the bake. Numbers and names of lights and options are stored as they are, everything else as fingerprints.
 *
 *     {"generator", "scene", "lights", "options",                            input: the bytes follow from it
 *      "triangles", "solids", "solid_triangles", "left_out", "warnings"}     results
 *
 * No clock and no path is stored: same input, same bytes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROVENANCE_H
#define PROVENANCE_H

#include "baker/bake/bake_options.h"
#include "baker/bake/bake_report.h"

/* The input of a bake.
 * inputs  [out] NULL on failure; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_inputs(json_t **inputs, const bake_options *o, const bake_scene *s, const light_choice *chosen,
                             run_context *m);

/* The metadata of a bake as text: its input and its results. NULL without memory; released with free(). */
char *provenance_text(const bake_report *report);

/* Set the members of *object that have a meaning for the light's kind. */
void provenance_set_shape(json_t **object, const light_shape *l);

/* The metadata of a file; NULL: there is none, vxs did not write it, or there is no memory. Released with json_decref. */
json_t *provenance_parse(const vxs_contents *contents);

/* Returns 1 if the path has a sound asset that was baked from this input.
 * file_bytes, warning_count  [out] if 1 is returned: its size, and the number of warnings of its bake */
int provenance_is_current(const char *path, const json_t *inputs, uint64_t *file_bytes, size_t *warning_count,
                          const run_context *m);

#endif
