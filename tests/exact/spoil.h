/* The DAG of a directional light, built stage by stage, with one thing spoilt after one of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXACT_SPOIL_H
#define EXACT_SPOIL_H

#include "baker/bake/bake.h"
#include "baker/lab/opengl/depth_gl.h"

typedef enum fault {
    FAULT_NONE,       /* bake() itself */
    FAULT_STAGES,     /* the stages as they are called here, unspoilt: must be right */
    FAULT_DEPTH,      /* a texel of the depth maps loses its caster */
    FAULT_TILE,       /* the bounds of a tile: a depth that parts nothing is said to part lit from shadowed */
    FAULT_SQUARE,     /* the bounds of a square of 16 texels or more: lit to the end */
    FAULT_MASK,       /* a bit of a visibility mask */
    FAULT_UNTIL,      /* a run of a tile holds one voxel too long */
    FAULT_INSERTED,   /* a child of a node after insertion */
    FAULT_COMPRESSED, /* after compression */
    FAULT_MERGED,     /* after the merge */
    FAULT_WORD        /* a word of the file, after it was read */
} fault;

#define FAULT_CHOICES "none|stages|depth|tile|square|mask|until|inserted|compressed|merged|word"

typedef struct spoil_desc {
    gl_context         *gl;
    const casters      *casters;
    const vxs_light    *light;
    const bake_options *bake; /* exit, rule, reuse, compress, stop, threads */
    fault               planted;
    uint64_t seed; /* of the place; each fault is put where it must show, not where it may hide in a voxel that is free */
} spoil_desc;

/* out  [out] released with dag_free, whatever is returned.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result spoilt_dag(const spoil_desc *s, dag *out, run_context *m);

#endif
