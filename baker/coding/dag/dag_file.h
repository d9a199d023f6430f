/* Serialization of the masks and nodes of a DAG.
 *
 *     counts of masks, and of the nodes of each level, 4 bytes each
 *     masks, 8 bytes each; nodes of each level, slice nodes first, 8 references of 4 bytes each
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DAG_FILE_H
#define DAG_FILE_H

#include "baker/base/byte_stream.h"
#include "baker/coding/dag/dag.h"

/* Append the masks and nodes of a DAG. The caller stores its roots and level_count. Returns 0 without memory. */
int dag_put(const dag *d, vxs_bytes *out);

/* Read masks and nodes into an empty DAG whose level_count is set. Checks that all references are in range.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result dag_take(dag *d, byte_reader *r);

#endif
