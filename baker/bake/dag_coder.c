/* Lights as DAGs; see dag_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/dag_coder.h"

#include <stdlib.h>

dag_coder dag_coder_for(const bake_options *o, compress_order compress, light_picture *picture)
{
    return (dag_coder){.build = build_options_of(o, compress), .unify = o->stop == STOP_FINAL, .picture = picture};
}

void dag_coder_free(dag_coder *c)
{
    dag_merger_free(&c->merger);
}

static vxs_result begin(void *data, const vxs_light *light)
{
    dag_coder *c = data;
    c->light     = light;
    return dag_merger_init(&c->merger, 1u << light->levels, vxs_map_count(light), c->unify);
}

/* Draw the masks of a square into the picture; check the memory limit after each step. */
static vxs_result after_step(void *user, bake_stage stage, column_tree *tree, dag *d)
{
    const dag_coder *c = user;
    (void)d;
    if (c->picture && stage == STAGE_MASKS) light_picture_add_masks(c->picture, tree, c->map);
    return context_has_memory(c->ctx) ? VXS_OK : VXS_E_MEMORY;
}

static vxs_result add_map(void *data, uint32_t map, const column_map *columns, bake_context *ctx)
{
    dag_coder *c   = data;
    c->map         = map;
    c->ctx         = ctx;
    c->build.after = after_step;
    c->build.user  = c;
    return dag_build_map(&c->merger, map, columns, &c->build, &c->stats, ctx);
}

static void free_dag(void *owned)
{
    dag_free(owned);
    free(owned);
}

static vxs_result finish(void *data, coded_light *out)
{
    dag_coder *c = data;
    dag       *d = malloc(sizeof *d);
    vxs_result r = d ? dag_merger_finish(&c->merger, d) : VXS_E_MEMORY;
    if (r != VXS_OK) {
        free(d);
        return r;
    }
    *out = (coded_light){.written      = dag_to_write(c->light, d),
                         .memory_bytes = 20 * dag_node_count(d) + 8 * (uint64_t)d->mask_count,
                         .owned        = d,
                         .free         = free_dag};
    return VXS_OK;
}

light_coder dag_coder_seam(dag_coder *c)
{
    return (light_coder){.data = c, .begin = begin, .add_map = add_map, .finish = finish};
}
