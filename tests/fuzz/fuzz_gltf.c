/* Any bytes as a .gltf or .glb file: loaded without other files, and, when the loader takes them, classified into solids and
 * sheets. Every index, flag and mask of a scene must hold what scene.h promises.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <string.h>

#include "baker/casters/casters.h"
#include "fuzz.h"

/* What takes long for good reasons is no finding. */
enum { TRIANGLES_TOLD_APART = 1000 };

static void check_triangles(const scene *s)
{
    size_t masked = 0;
    for (size_t i = 0; i < 3 * s->vertex_count; i++) FUZZ_CHECK(isfinite(s->positions_ws[i]));
    for (size_t i = 0; i < 3 * s->triangle_count; i++) FUZZ_CHECK(s->indices[i] < s->vertex_count);
    for (size_t i = 0; i < s->triangle_count; i++) {
        FUZZ_CHECK(!(s->triangle_flags[i] & ~(TRIANGLE_DOUBLE_SIDED | TRIANGLE_ALPHA_MASK)));
        if (!(s->triangle_flags[i] & TRIANGLE_ALPHA_MASK)) continue;
        FUZZ_CHECK(masked < s->holed_triangle_count && s->holed_triangles[masked].triangle == i);
        masked++;
    }
    FUZZ_CHECK(masked == s->holed_triangle_count);
}

static void check_masks(const scene *s)
{
    for (size_t i = 0; i < s->image_count; i++) {
        FUZZ_CHECK(s->images[i].width_px >= 1 && s->images[i].width_px <= ALPHA_IMAGE_MAX_PX);
        FUZZ_CHECK(s->images[i].height_px >= 1 && s->images[i].height_px <= ALPHA_IMAGE_MAX_PX && s->images[i].alpha);
    }
    for (size_t i = 0; i < s->alpha_mask_count; i++)
        FUZZ_CHECK(s->alpha_masks[i].image < s->image_count && s->alpha_masks[i].threshold > 0 && s->alpha_masks[i].threshold <= 1);
    for (size_t i = 0; i < s->holed_triangle_count; i++) {
        FUZZ_CHECK(s->holed_triangles[i].mask < s->alpha_mask_count);
        for (int k = 0; k < 6; k++) FUZZ_CHECK(isfinite(s->holed_triangles[i].uv[k / 2][k % 2]));
    }
}

static void check_lights(const scene *s)
{
    FUZZ_CHECK(s->name);
    for (size_t i = 0; i < 3 * s->camera_count; i++) FUZZ_CHECK(isfinite(s->camera_positions_ws[i]));
    for (size_t i = 0; i < s->light_count; i++) {
        const light_shape *l = &s->lights[i].shape;
        FUZZ_CHECK(s->lights[i].name && l->range_metres > 0);
        FUZZ_CHECK(l->kind != LIGHT_SPOT || (l->outer_rad > 0 && l->outer_rad <= acos(-1) / 2));
        for (int k = 0; k < 3; k++) FUZZ_CHECK(isfinite(l->position_ws[k]) && fabs(l->direction_ws[k]) <= 1 + 1e-9);
    }
}

static void check_casters(const scene *s, run_context *m)
{
    casters    c;
    vxs_result r = casters_from_scene(&c, s, CLOSED_AUTO, 2, m);
    FUZZ_CHECK(r == VXS_OK || m->error[0]);
    FUZZ_CHECK(c.solid_triangle_count <= c.triangle_count && c.triangle_count <= s->triangle_count);
    for (size_t i = 0; i < 3 * c.triangle_count; i++) FUZZ_CHECK(c.indices[i] < c.vertex_count);
    casters_free(&c);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    scene       s;
    run_context m = {0};
    vxs_result  r = scene_load_gltf_memory(&s, data, size, "fuzzed", &m);
    if (r == VXS_OK) {
        FUZZ_CHECK(!m.error[0]);
        check_triangles(&s);
        check_masks(&s);
        check_lights(&s);
        if (s.triangle_count <= TRIANGLES_TOLD_APART) check_casters(&s, &m);
    } else {
        FUZZ_CHECK(m.error[0] && !strchr(m.error, '\n') && !s.positions_ws && !s.indices && !s.lights && !s.alpha_masks);
    }
    scene_free(&s);
    run_free(&m);
    return 0;
}
