/* Sources of a stream's bytes: a file read by position, memory, or the caller.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "stream.h"

vxs_result vxs_stream_source_open(stream_source *source, const vxs_stream_desc *desc)
{
    if ((desc->path != NULL) + (desc->bytes != NULL) + (desc->read != NULL) != 1) return VXS_E_ARGUMENT;
    *source = (stream_source){.bytes = desc->bytes, .read = desc->read, .user = desc->read_user, .size_bytes = desc->size_bytes};
    if (!desc->path) return VXS_OK;
    if (!os_file_open(&source->file, desc->path)) return VXS_E_READ;
    source->is_file    = 1;
    source->size_bytes = source->file.size_bytes;
    return VXS_OK;
}

void vxs_stream_source_close(stream_source *source)
{
    if (source->is_file) os_file_close(&source->file);
}

vxs_stream_answer vxs_stream_source_read(const stream_source *source, uint64_t offset, uint32_t size_bytes, void *buffer,
                                         vxs_stream_request *request)
{
    if (offset > source->size_bytes || size_bytes > source->size_bytes - offset) return VXS_STREAM_FAILED;
    if (source->read) return source->read(source->user, offset, size_bytes, buffer, request);
    if (source->is_file) return os_file_read(&source->file, offset, size_bytes, buffer) ? VXS_STREAM_READ : VXS_STREAM_FAILED;
    memcpy(buffer, source->bytes + offset, size_bytes);
    return VXS_STREAM_READ;
}
