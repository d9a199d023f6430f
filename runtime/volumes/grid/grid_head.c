/* See grid_head.h.
 * SPDX-License-Identifier: MIT */
#include "grid_head.h"

_Static_assert(sizeof(grid_head) == 128, "a head is eight texels");

/* The vector from the eye to a point of the image at a depth; 0 if the point is not finite. */
static int way_to(const frame_block *f, double x, double y, double depth, double way[3])
{
    const float *m = f->point_from_depth;
    double       point[4], square = 0;
    for (int n = 0; n < 4; n++) point[n] = (double)m[n] * x + (double)m[4 + n] * y + (double)m[8 + n] * depth + (double)m[12 + n];
    for (int n = 0; n < 3; n++) {
        way[n] = point[n] / point[3] - (double)f->eye[n];
        square += way[n] * way[n];
    }
    return square > 0 && square < (double)VXS_VIEW_METRES * (double)VXS_VIEW_METRES;
}

/* Each corner uses the first depth at which it is a finite point. */
vxs_epipolar_view vxs_grid_view_of(const frame_block *f)
{
    vxs_epipolar_view view = {.far_metres = (double)f->far_metres};
    const vxs_pixels *p    = &f->pixels;
    double            u[2] = {p->x / (double)f->wide_px, (p->x + p->wide_px) / (double)f->wide_px};
    double            v[2] = {p->y / (double)f->high_px, (p->y + p->high_px) / (double)f->high_px};
    for (int n = 0; n < 4; n++)
        for (double depth = 0.5; depth < 1; depth += 0.125)
            if (way_to(f, u[n == 1 || n == 2], v[n >= 2], depth, view.corners[n])) break;
    return view;
}

grid_head vxs_grid_head_of(const vxs_epipolar *space, const vxs_grid_size *size, uint32_t runs)
{
    grid_head head = {
        .away = (float)space->away, .columns = size->columns, .rows = size->rows, .bits = size->bits, .runs = (int32_t)runs};
    for (int n = 0; n < 3; n++) {
        head.axis[n]  = (float)space->axis[n];
        head.ahead[n] = (float)space->ahead[n];
        head.side[n]  = (float)space->side[n];
    }
    for (int n = 0; n < 2; n++) {
        head.alpha[n] = (float)space->alpha[n];
        head.theta[n] = (float)space->theta[n];
        head.phi[n]   = (float)space->phi[n];
    }
    return head;
}
