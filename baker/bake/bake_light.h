/* One light of a bake: from the columns of its maps to what is written of it. Where columns come from, and what a coding makes of
 * them, is not known here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHT_H
#define BAKE_LIGHT_H

#include "baker/bake/light_coder.h"
#include "baker/bake/plan.h"

/* source  of the maps of the light, opened one after the other
 * coder   not begun
 * out     [out] written only when VXS_OK is returned; released with coded_light_free. NULL: the light is not finished, others add its squares
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the source returns. */
vxs_result bake_light(const plan_light *planned, const column_source *source, const light_coder *coder, coded_light *out,
                      bake_context *ctx);

#endif
