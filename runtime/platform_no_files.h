/* Files of platform.h in a build that has none: WebAssembly in a browser.
 * SPDX-License-Identifier: MIT */
#ifndef PLATFORM_NO_FILES_H
#define PLATFORM_NO_FILES_H

#include <stdint.h>

#include "vxs_result.h"

typedef struct os_file {
    uint64_t size_bytes;
} os_file;

static inline vxs_result os_file_open(os_file *file, const char *path)
{
    (void)path;
    file->size_bytes = 0;
    return VXS_E_NO_FILE;
}

static inline void os_file_close(os_file *file)
{
    (void)file;
}

static inline int os_file_read(const os_file *file, uint64_t offset, uint64_t size_bytes, void *to)
{
    (void)file;
    (void)offset;
    (void)size_bytes;
    (void)to;
    return 0;
}

#endif
