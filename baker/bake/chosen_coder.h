/* The coding that the options choose, behind the seam of light_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CHOSEN_CODER_H
#define CHOSEN_CODER_H

#include "baker/bake/blocks_coder.h"
#include "baker/bake/dag_coder.h"

typedef struct chosen_coder {
    dag_coder          dags;
    blocks_coder       blocks;
    light_coder        coder;
    const build_stats *stats; /* of the chosen coding */
} chosen_coder;

/* compress  order of compression from the plan, for DAGs
 * picture   NULL, or where masks of DAGs are drawn; borrowed
 * c         [out] must not move until chosen_coder_free */
void chosen_coder_init(chosen_coder *c, const bake_options *o, compress_order compress, light_picture *picture);

void chosen_coder_free(chosen_coder *c);

#endif
