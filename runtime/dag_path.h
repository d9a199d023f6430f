/* Walks through a DAG that reuse the last walk: two neighbouring slices share their upper nodes. Internal to the runtime; not
 * installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DAG_PATH_H
#define VXS_DAG_PATH_H

#include "vxs_file.h"
#include "vxs_lookup.h"

/* The last walk: node[l] has a side of 8 << l voxels. It ended at level `end`: at a uniform child with state `state`, or at level
 * 0. */
typedef struct vxs_dag_path {
    const uint32_t *words;
    uint32_t        levels, root;
    uint32_t        x, y, z; /* position of the last slice's node of side 8 */
    uint32_t        end, state;
    uint32_t        node[VXS_LEVELS_MAX - 2];
} vxs_dag_path;

/* Start at the root of a map. */
void vxs_dag_path_init(vxs_dag_path *path, const vxs_baked_light *baked, uint32_t map);

/* Same results as vxs_shadow, vxs_shadow_count and vxs_shadow_weight. */
uint32_t vxs_dag_path_shadow(vxs_dag_path *path, uint32_t i, uint32_t j, uint32_t k);
uint32_t vxs_dag_path_count(vxs_dag_path *path, int32_t i, int32_t j, uint32_t k, int32_t filter_px);
uint32_t vxs_dag_path_weight(vxs_dag_path *path, vxs_smooth_box box, uint32_t k, int32_t width_px);

#endif
