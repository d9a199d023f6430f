/* Random points in the part of a baked light's volume that is inside a box.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_VOLUME_H
#define LIGHT_VOLUME_H

#include "baker/base/box.h"
#include "baker/base/random.h"
#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

enum { VOLUME_CELLS_SIDE = 64, VOLUME_CELLS = VOLUME_CELLS_SIDE * VOLUME_CELLS_SIDE };

typedef struct light_volume {
    const vxs_light *light; /* borrowed */
    light_shape      shape;
    box              box_ws;
    enum { DRAW_FROM_BOX, DRAW_FROM_MAP, DRAW_FROM_CONE } way;
    double axes[3][3];                /* of the cone: two across it, and its direction */
    double cell_weight[VOLUME_CELLS]; /* the mean of t1^3 - t0^3 over rays through a cell, which are in the box from t0 to t1 */
    double cell_sum[VOLUME_CELLS];    /* this cell and all before it */
} light_volume;

/* box_ws  metres; of some volume */
void light_volume_init(light_volume *v, const vxs_light *light, const box *box_ws);

/* A point in the box and in the volume of the light, uniform by volume.
 * Returns 0 when a hundred points in a row were in only one of them.   Threads: any. */
int light_volume_draw(const light_volume *v, rng *r, double point_ws[3]);

#endif
