/* Which solids are in one cluster of solids that meet.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_MEET_H
#define MESH_MEET_H

#include "baker/casters/casters.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As casters_find_meeting, but solids that meet are put together; a common corner alone does not count, nor what a solid does to itself.
 * cluster_of  [out] [component_count[COMPONENT_SOLID]] the lowest solid of its cluster
 * gave_up     [out] 1: the search took too long, some that meet are in different clusters
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result mesh_find_clusters(uint32_t *cluster_of, int *gave_up, const casters *c, message *m);

#ifdef __cplusplus
}
#endif
#endif
