/* The masks and nodes of a DAG as bytes, and back.
 *
 *     masks, then nodes of each level: how many, each 4 bytes
 *     masks, 8 bytes each; nodes of each level, slice nodes first, 8 references of 4 bytes each
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DAG_FILE_H
#define DAG_FILE_H

#include "baker/base/byte_stream.h"
#include "baker/coding/dag/dag.h"

/* Append those of a DAG; its roots and how many levels it has are the caller's. Returns 0 without memory. */
int dag_put(const dag *d, vxs_bytes *out);

/* Read those of an empty DAG whose level_count is known. No node refers to what is not there.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result dag_take(dag *d, byte_reader *r);

#endif
