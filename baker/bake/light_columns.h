/* Column source of a planned light: its maps, rendered with OpenGL or computed straight from triangles.
 * Rendered depths are also drawn into the light's picture.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_COLUMNS_H
#define LIGHT_COLUMNS_H

#include "baker/bake/light_picture.h"
#include "baker/bake/plan.h"
#include "baker/columns/sparse/sparse_columns.h"

typedef struct light_columns {
    maps_choice            maps;
    const column_renderer *renderer; /* for rendered maps */
    rendered_columns       rendered; /* used by `maps`: this one, or sparse */
    sparse_columns         sparse;
    light_picture         *picture; /* NULL: not wanted; borrowed */
} light_columns;

/* device  of the renderer; NULL if nothing is rendered
 * device, plan, planned, all  borrowed until light_columns_free; released with that */
void light_columns_init(light_columns *c, void *device, const bake_options *o, const bake_plan *plan, const plan_light *planned,
                        const casters *all, light_picture *picture);

/* Valid until light_columns_free, while c stays at its address. */
column_source light_columns_source(light_columns *c);

/* Draw the depths of all maps into a picture, if rendering has not drawn them. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result light_columns_draw(const light_columns *c, light_picture *picture, bake_context *ctx);

void light_columns_free(light_columns *c);

#endif
