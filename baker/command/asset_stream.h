/* A .vxs file that a command opens as a game streams it; what goes wrong is a message.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_STREAM_H
#define ASSET_STREAM_H

#include "baker/base/message.h"
#include "baker/base/text.h"
#include "runtime/vxs_stream.h"

typedef struct asset_stream {
    vxs_stream      *stream;
    const char      *path;
    vxs_contents     contents; /* lights that were chosen, and metadata; no sections */
    vxs_baked_points points;   /* of what casts; coordinates NULL: there are none, or nobody asked */
    vxs_result       broken;   /* of the first page that could not be had, and what there is to say of it */
    char             broken_text[192];
} asset_stream;

/* Open a file, not a pipe, within a budget.
 * s      [out] stays where it is; released with asset_stream_close, whatever is returned
 * names  of lights that are wanted; none: all
 * points 1: points of what casts are kept, too, beside the budget
 * lights, light_count  [out] these lights, as asset_choose_lights has them
 * smoke  [out] [VXS_LIGHTS_MAX] what smoke leaves of each; NULL: it has none
 * Returns VXS_OK; VXS_E_ARGUMENT: a pipe, no such light, or one given twice; VXS_E_MEMORY: the budget is too small, and the
 * message says how much is the least; VXS_E_READ and others as vxs_stream_open. */
vxs_result asset_stream_open(asset_stream *s, const char *path, uint64_t budget_bytes, const text_list *names, int points,
                             const vxs_baked_light **lights, const vxs_baked_smoke **smoke, uint32_t *light_count, message *m);

/* A frame for an eye: pages that the last one asked for are waited for, so that what is there depends on the frames before and
 * on nothing else.
 * status  [in, out] as for vxs_stream_frame
 * Returns VXS_OK, VXS_E_READ or VXS_E_CORRUPT: a page that cannot be had. */
vxs_result asset_stream_frame(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, message *m);

/* Frames until nothing comes any more: all is there that fits. Pages that appeared and left are those of all these frames. */
vxs_result asset_stream_fill(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, message *m);

/* Accepts a zeroed object. */
void asset_stream_close(asset_stream *s);

#endif
