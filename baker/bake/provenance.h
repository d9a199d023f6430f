/* Where an asset comes from: its metadata, as it is written, read, and held against a scene (formats/vxs.md, section 4).
 *
 * What goes into a bake is known as soon as the scene is read. It stands in the file, so that later on a scene and options can be told
 * from those that were baked: numbers and names of lights and options as they are, all else as fingerprints.
 *
 *     {"generator", "scene", "lights", "options",                            what went in: the bytes follow from it
 *      "triangles", "solids", "solid_triangles", "left_out", "warnings"}     what came of it
 *
 * No clock, no path: same input, same bytes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROVENANCE_H
#define PROVENANCE_H

#include "baker/bake/bake_report.h"
#include "baker/bake/bake_scene.h"

/* What goes into a bake.
 * inputs  [out] NULL on failure; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_inputs(json_t **inputs, const bake_options *o, const bake_scene *s, const light_choice *chosen, message *m);

/* The metadata of a bake, as text: its inputs and what came of them. NULL without memory; released with free(). */
char *provenance_text(const bake_report *report);

/* Members of an object: what a light's kind gives a meaning to. */
void provenance_set_shape(json_t **object, const light_shape *l);

/* The metadata of a file; NULL where there is none, it is not what vxs writes, or there is no memory for it. Released with json_decref. */
json_t *provenance_parse(const vxs_contents *contents);

/* The metadata of a file that anyone may have written. "generator" is there; of the other members, those that are have the types that
 * vxs writes.
 * made  [out] NULL where there is none, or it is not what vxs writes; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_read(json_t **made, const vxs_contents *contents, message *m);

/* 1 when a sound asset lies at a path that was baked from these inputs.
 * file_bytes, warning_count  [out] its size, and how many warnings its bake had; when 1 is returned */
int provenance_is_current(const char *path, const json_t *inputs, uint64_t *file_bytes, size_t *warning_count);

/* What differs between a scene and the one that an asset was baked from: ["geometry", "light 'lamp': position, range"]. Lights that are
 * not in the asset make no difference, nor what the metadata does not tell.
 * made         what provenance_read had of the contents
 * differences  [out] an array, empty when it is the same scene; NULL on failure; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_differences(json_t **differences, const json_t *made, const vxs_contents *contents, const scene *s,
                                  message *m);

enum { PROVENANCE_TEXT_BYTES = 256 };

/* "geometry; light 'lamp': position, range; and 7 more": one line, cut short where it would fill the text. Returns text. */
const char *provenance_differences_text(char text[PROVENANCE_TEXT_BYTES], const json_t *differences);

#endif
