/* Floats as OpenEXR: scan lines, zlib; see exr_encode.h. The library writes with a function of ours, into memory.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/exr_encode.h"

#include <OpenEXR/openexr.h>
#include <stdlib.h>
#include <string.h>

typedef struct bytes {
    uint8_t *data;
    size_t   size, room;
} bytes;

/* Like pwrite: the library goes back to write the chunks' offsets. */
static int64_t put(exr_const_context_t context, void *user, const void *buffer, uint64_t size, uint64_t offset,
                   exr_stream_error_func_ptr_t on_error)
{
    bytes *b   = user;
    size_t end = (size_t)(offset + size);
    (void)context;
    (void)on_error;
    if (end > b->room) {
        size_t   room = end + end / 2;
        uint8_t *data = realloc(b->data, room);
        if (!data) return -1;
        memset(data + b->room, 0, room - b->room);
        b->data = data;
        b->room = room;
    }
    memcpy(b->data + offset, buffer, size);
    if (end > b->size) b->size = end;
    return (int64_t)size;
}

static void quiet(exr_const_context_t context, exr_result_t code, const char *text)
{
    (void)context;
    (void)code;
    (void)text;
}

static exr_result_t write_chunks(exr_context_t file, const float *pixels, uint32_t width_px, uint32_t height_px,
                                 const char *channels)
{
    exr_encode_pipeline_t pipe  = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t               lines = 1;
    exr_result_t          r     = exr_get_scanlines_per_chunk(file, 0, &lines);
    for (uint32_t y = 0; y < height_px && r == EXR_ERR_SUCCESS; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        const float     *row = pixels + (size_t)y * width_px * strlen(channels);
        r                    = exr_write_scanline_chunk_info(file, 0, (int)y, &chunk);
        if (r == EXR_ERR_SUCCESS) {
            int          is_first = y == 0;
            const size_t count = strlen(channels), pixel_bytes = count * sizeof *row;
            r = is_first ? exr_encoding_initialize(file, 0, &chunk, &pipe) : exr_encoding_update(file, 0, &chunk, &pipe);
            for (int n = 0; n < pipe.channel_count && r == EXR_ERR_SUCCESS; n++) { /* in the order of their names */
                exr_coding_channel_info_t *c = &pipe.channels[n];
                c->encode_from_ptr           = (const uint8_t *)(row + (strchr(channels, c->channel_name[0]) - channels));
                c->user_pixel_stride         = (int32_t)pixel_bytes;
                c->user_line_stride          = (int32_t)(pixel_bytes * width_px);
            }
            if (r == EXR_ERR_SUCCESS && is_first) r = exr_encoding_choose_default_routines(file, 0, &pipe);
            r = r == EXR_ERR_SUCCESS ? exr_encoding_run(file, 0, &pipe) : r;
        }
    }
    exr_encoding_destroy(file, &pipe);
    return r;
}

uint8_t *exr_encode(const float *pixels, uint32_t width_px, uint32_t height_px, const char *channels, float white,
                    size_t *size_bytes)
{
    bytes                     b    = {0};
    exr_context_t             file = NULL;
    exr_context_initializer_t how  = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.error_handler_fn           = quiet;
    how.user_data                  = &b;
    how.write_fn                   = put;
    exr_result_t r                 = exr_start_write(&file, "picture", EXR_WRITE_FILE_DIRECTLY, &how);
    if (r == EXR_ERR_SUCCESS) {
        int part;
        r = exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
        if (r == EXR_ERR_SUCCESS)
            r = exr_initialize_required_attr_simple(file, part, (int32_t)width_px, (int32_t)height_px, EXR_COMPRESSION_ZIP);
        for (const char *c = channels; *c && r == EXR_ERR_SUCCESS; c++)
            if (*c != '.')
                r = exr_add_channel(file, part, (const char[]){*c, 0}, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
        if (r == EXR_ERR_SUCCESS && white > 0) r = exr_attr_set_float(file, part, "whiteLuminance", white);
        r = r == EXR_ERR_SUCCESS ? exr_write_header(file) : r;
    }
    if (r == EXR_ERR_SUCCESS) r = write_chunks(file, pixels, width_px, height_px, channels);
    exr_result_t end = file ? exr_finish(&file) : EXR_ERR_SUCCESS; /* writes the chunks' offsets */
    if (r != EXR_ERR_SUCCESS || end != EXR_ERR_SUCCESS) {
        free(b.data);
        return NULL;
    }
    *size_bytes = b.size;
    return b.data;
}
