/* Bakes one light: from the columns of its maps to its encoded form. It does not depend on the column source or the coding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHT_H
#define BAKE_LIGHT_H

#include "baker/bake/light_coder.h"
#include "baker/bake/plan.h"

/* source  of the light's maps, opened one after the other
 * coder   not begun
 * out     [out] written only if VXS_OK is returned; released with coded_light_free. NULL: do not finish the light; another process
 *         adds its squares
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the source returns. */
vxs_result bake_light(const plan_light *planned, const column_source *source, const light_coder *coder, coded_light *out,
                      bake_context *ctx);

#endif
