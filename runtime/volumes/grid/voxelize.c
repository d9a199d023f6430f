/* See voxelize.h.
 * SPDX-License-Identifier: MIT */
#include "voxelize.h"

#include <math.h>

enum { GROUP = 64, GROUPS_MAX = 65535, GROUPS_ENOUGH = 64, WORDS_MOST = 1 << 30, ROWS_LEAST = 8 };

int vxs_are_casters(const vxs_casters *casters, uint32_t count, const vxs_grid_size *size)
{
    for (const vxs_casters *c = casters; c < casters + count; c++) {
        if (!c->places || (c->place_words && c->place_words < 3) || c->place_words > WORDS_MOST || c->first_word > WORDS_MOST ||
            c->triangle_count > WORDS_MOST || (unsigned)c->kind >= VXS_VOXELS_KINDS)
            return 0;
        if (c->kind == VXS_VOXELS_COVERED && size->rows < ROWS_LEAST) return 0;
        for (int n = 0; n < 16; n++)
            if (!isfinite(c->point_from_place[n])) return 0;
    }
    return 1;
}

/* The matrix to coordinates along the axis, `ahead` and `side`, from the eye. */
static void set_matrix(float axes_from_place[16], const vxs_epipolar *space, const float eye[3], const float point_from_place[16])
{
    const double *const rows[3] = {space->axis, space->ahead, space->side};
    for (int n = 0; n < 16; n++) axes_from_place[n] = 0;
    for (int column = 0; column < 4; column++) {
        double point[3];
        for (int i = 0; i < 3; i++) point[i] = (double)point_from_place[4 * column + i] - (column == 3 ? (double)eye[i] : 0);
        for (int row = 0; row < 3; row++) axes_from_place[4 * column + row] = (float)vxs_air_dot(rows[row], point);
    }
}

static void voxelize(vxs_volumes *v, const vxs_casters *c, vxs_voxels as)
{
    static const char *const names[VXS_VOXELS_KINDS] = {
        [VXS_VOXELS_RAYS]    = "#define VXS_VOXELS_RAYS\n",
        [VXS_VOXELS_SOLID]   = "#define VXS_VOXELS_SOLID\n",
        [VXS_VOXELS_COVERED] = "#define VXS_VOXELS_COVERED\n",
    };
    gl_name         program = vxs_volumes_program(v, &(program_texts){.names = names[as], .body = &vxs_volumes_text_voxelize_glsl});
    uint32_t        groups  = (c->triangle_count + GROUP - 1) / GROUP;
    uint32_t        turns   = groups < GROUPS_ENOUGH ? GROUPS_ENOUGH / (groups ? groups : 1) : 1;
    voxelize_block *to      = &v->own.voxelize;
    to->triangles           = c->triangle_count;
    to->first_word          = c->first_word;
    to->place_words         = c->place_words ? c->place_words : 3;
    to->is_indexed          = c->corners != 0;
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage + 2, c->corners);
    for (uint32_t first = 0; first < groups; first += GROUPS_MAX) {
        to->first_triangle = GROUP * first;
        vxs_volumes_run(v, program, 0, 0, groups - first < GROUPS_MAX ? groups - first : GROUPS_MAX, turns);
    }
}

void vxs_voxelize(vxs_volumes *v, gl_name grid, const vxs_epipolar *space, const vxs_casters *casters, uint32_t count,
                  vxs_voxels kind, vxs_voxels as, uint32_t columns)
{
    v->own.voxelize = (voxelize_block){.columns = (int32_t)columns};
    for (const vxs_casters *c = casters; c < casters + count; c++) {
        if (c->kind != kind) continue;
        set_matrix(v->own.voxelize.axes_from_place, space, v->frame.eye, c->point_from_place);
        vxs_volumes_use_storage(v, grid, c->places);
        voxelize(v, c, as);
    }
    vxs_volumes_use_storage(v, grid, 0);
}
