/* The metadata of a file, compared with a scene. JSON without memory is detected for the whole process (json_file.h), so that this
 * is no part of libvxs_bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROVENANCE_DIFFERENCES_H
#define PROVENANCE_DIFFERENCES_H

#include "baker/bake/provenance.h"

/* The metadata of a file from any writer. "generator" is there; other members may be missing, and have the types that vxs writes.
 * made  [out] NULL if there is none, or if vxs did not write it; released with json_decref
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result provenance_read(json_t **made, const vxs_contents *contents, run_context *m);

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
