/* A .vxs file opened as a stream, as a game does it; errors become messages.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_STREAM_H
#define ASSET_STREAM_H

#include "baker/base/message.h"
#include "baker/base/text.h"
#include "runtime/vxs_stream.h"

typedef struct asset_stream {
    vxs_stream      *stream;
    const char      *path;
    vxs_contents     contents; /* chosen lights, and metadata; no sections */
    vxs_baked_points points;   /* of casters; coordinates NULL: there are none, or they are not wanted */
    vxs_result       broken;   /* result of the first page that failed to load, and its message */
    char             broken_text[192];
} asset_stream;

/* Open a file, not a pipe, within a memory budget.
 * s      [out] must not be moved; released with asset_stream_close, whatever is returned
 * names  of the lights that are wanted; empty: all lights
 * points 1: also hold the points of casters, in addition to the budget
 * lights, light_count  [out] the chosen lights, as in asset_choose_lights
 * smoke  [out] [VXS_LIGHTS_MAX] baked smoke of each light; NULL: it has none
 * Returns VXS_OK; VXS_E_ARGUMENT: a pipe, no such light, or one given twice; VXS_E_MEMORY: the budget is too small, and the
 * message states the smallest one; VXS_E_READ and others as vxs_stream_open. */
vxs_result asset_stream_open(asset_stream *s, const char *path, uint64_t budget_bytes, const text_list *names, int points,
                             const vxs_baked_light **lights, const vxs_baked_smoke **smoke, uint32_t *light_count, message *m);

/* Update the stream for an eye. First waits for the pages that the last frame requested, so that the result depends only on
 * earlier frames, not on timing.
 * status  [in, out] as for vxs_stream_frame
 * Returns VXS_OK, VXS_E_READ or VXS_E_CORRUPT: a page could not be loaded. */
vxs_result asset_stream_frame(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, message *m);

/* Repeat frames until no page is pending: all pages that fit are loaded. The status counts the pages that appeared and left in
 * all of these frames. */
vxs_result asset_stream_fill(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, message *m);

/* Accepts a zeroed object. */
void asset_stream_close(asset_stream *s);

#endif
