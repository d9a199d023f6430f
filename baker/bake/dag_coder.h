/* A light's maps as a DAG: baker/coding/dag/ behind the seam of light_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DAG_CODER_H
#define DAG_CODER_H

#include "baker/bake/bake_options.h"
#include "baker/bake/light_coder.h"
#include "baker/bake/light_picture.h"

typedef struct dag_coder {
    build_options    build;
    int              unify;   /* 1: one DAG without equal subtrees; 0: sub-DAGs side by side */
    light_picture   *picture; /* NULL, or where masks are drawn; borrowed */
    const vxs_light *light;   /* NULL: not begun */
    dag_merger       merger;
    build_stats      stats; /* of all maps so far */

    uint32_t            map; /* map in work */
    const bake_context *ctx; /* run context during add_map */
} dag_coder;

/* compress  order of compression from the plan
 * picture   NULL, or where masks are drawn; borrowed */
dag_coder dag_coder_for(const bake_options *o, compress_order compress, light_picture *picture);

/* Valid until dag_coder_free, while c stays at its address. */
light_coder dag_coder_seam(dag_coder *c);

/* Accepts one that was not begun. */
void dag_coder_free(dag_coder *c);

#endif
