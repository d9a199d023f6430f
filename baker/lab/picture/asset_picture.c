/* A picture of all casters in the shadows of an asset; see asset_picture.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/picture/asset_picture.h"

#include <stdlib.h>

#include "baker/base/box.h"
#include "baker/base/parallel.h"
#include "runtime/vxs.h"

enum { FILTER_PX = 5, FOV_DEGREES = 35 };

/* Order: by size; lights of equal size in the order of the file. */
static int largest_first(const void *a, const void *b)
{
    const vxs_baked_light *const *p = a, *const *q = b;
    if ((*p)->word_count != (*q)->word_count) return (*p)->word_count < (*q)->word_count ? 1 : -1;
    return *p < *q ? -1 : 1;
}

vxs_result asset_picture(uint8_t *rgb, uint32_t width_px, uint32_t height_px, const casters *c, const void *file, size_t size_bytes,
                         uint32_t threads, message *m)
{
    picture_options        o     = {.width_px = width_px, .height_px = height_px, .filter_px = FILTER_PX, .threads = threads};
    vxs_asset             *asset = NULL;
    truth                 *t     = NULL;
    const vxs_baked_light *lights[VXS_LIGHTS_MAX];
    uint32_t               count;
    box                    b;
    vxs_parallel           lent = parallel_lent(threads);
    vxs_result             r    = vxs_asset_open(&asset, file, size_bytes, &(vxs_read_desc){.parallel = &lent});
    if (r != VXS_OK) {
        fail(m, r, "the asset cannot be opened for a picture: %s", vxs_result_text(r));
        goto done;
    }
    if ((r = truth_create(&t, c, threads, m)) != VXS_OK) goto done;
    count = vxs_asset_light_count(asset);
    for (uint32_t n = 0; n < count; n++) lights[n] = vxs_asset_light(asset, n);
    if (count > ASSET_PICTURE_LIGHTS) {
        qsort(lights, count, sizeof *lights, largest_first);
        count = ASSET_PICTURE_LIGHTS;
    }
    o.camera.fov_degrees = FOV_DEGREES;
    b                    = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    camera_frame_lit(&o.camera, &b, lights, count, (double)width_px / height_px);
    r = picture_render(rgb, NULL, &o, t, c, lights, count, m);
done:
    truth_destroy(t);
    vxs_asset_close(asset);
    return r;
}
