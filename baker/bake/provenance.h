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

/* The metadata of a file from any writer. "generator" is there; other members may be missing, and have the types that vxs writes.
 * made  [out] NULL if there is none, or if vxs did not write it; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_read(json_t **made, const vxs_contents *contents, run_context *m);

/* Returns 1 if the path has a sound asset that was baked from this input.
 * file_bytes, warning_count  [out] if 1 is returned: its size, and the number of warnings of its bake */
int provenance_is_current(const char *path, const json_t *inputs, uint64_t *file_bytes, size_t *warning_count, const run_context *m);

/* Differences between a scene and the scene of an asset: ["geometry", "light 'lamp': position, range"]. Lights that are not in the
 * asset are ignored, and so is what the metadata does not have.
 * made         from provenance_read of the contents
 * differences  [out] an array, empty if the scenes are the same; NULL on failure; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_differences(json_t **differences, const json_t *made, const vxs_contents *contents, const scene *s,
                                  run_context *m);

enum { PROVENANCE_TEXT_BYTES = 256 };

/* "geometry; light 'lamp': position, range; and 7 more": one line, cut to the size of text. Returns text. */
const char *provenance_differences_text(char text[PROVENANCE_TEXT_BYTES], const json_t *differences);

#endif
