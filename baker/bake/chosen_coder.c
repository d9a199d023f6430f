/* The chosen coding; see chosen_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/chosen_coder.h"

void chosen_coder_init(chosen_coder *c, const bake_options *o, compress_order compress, light_picture *picture)
{
    int is_dag = o->coding == CODING_DAG;
    *c         = (chosen_coder){.dags   = dag_coder_for(o, compress, picture),
                                .blocks = {.threads = o->threads, .packing = (uint32_t)o->pack}};
    c->coder   = is_dag ? dag_coder_seam(&c->dags) : blocks_coder_seam(&c->blocks);
    c->stats   = is_dag ? &c->dags.stats : &c->blocks.stats;
}

void chosen_coder_free(chosen_coder *c)
{
    dag_coder_free(&c->dags);
    blocks_coder_free(&c->blocks);
}
