/* Bakes one light: from the columns of its maps to its encoded form. It does not depend on the column source or the coding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHT_H
#define BAKE_LIGHT_H

#include "baker/bake/bake_report.h"
#include "baker/bake/light_coder.h"
#include "baker/bake/plan.h"

/* source  of the light's maps, opened one after the other
 * coder   not begun
 * out     [out] written only if VXS_OK is returned; released with coded_light_free. NULL: do not finish the light; another process
 *         adds its squares
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the source returns. */
vxs_result bake_light(const plan_light *planned, const column_source *source, const light_coder *coder, coded_light *out,
                      bake_context *ctx);

/* From coded lights to a file. */

/* Encode lights.
 * coded     [light_count]
 * metadata  of the file (provenance.h); NULL: out of memory
 * points    NULL: none
 * out       [out] zero it first, release with free(out->data)
 * Returns VXS_OK, VXS_E_MEMORY; VXS_E_ARGUMENT if the format cannot hold it. */
vxs_result asset_encode(const bake_options *o, const coded_light *coded, uint32_t light_count, const char *metadata,
                        const vxs_points_view *points, vxs_bytes *out, run_context *m);

/* Read the encoded file back, as a game would, fill the report from it, and write it to the output path, if there is one. */
vxs_result asset_write(const bake_options *o, const vxs_bytes *file, bake_report *report, run_context *m);

#endif
