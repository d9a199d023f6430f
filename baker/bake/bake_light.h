/* One light of a bake: from the columns of its maps to the DAG of its shadows. Where columns come from is not known here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHT_H
#define BAKE_LIGHT_H

#include "baker/bake/light_picture.h"
#include "baker/bake/plan.h"

/* source   of the maps of the light, opened one after the other
 * build    as build_options_of has it; `after` is used for pictures here
 * unify    1: one DAG without equal subtrees; 0: sub-DAGs side by side
 * picture  NULL, or what gets the masks
 * out      [out] a DAG with a root for each map; released with dag_free, whatever is returned
 * stats    added to
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the source returns. */
vxs_result bake_light(const plan_light *planned, const column_source *source, const build_options *build, int unify,
                      light_picture *picture, dag *out, build_stats *stats, bake_context *ctx);

#endif
