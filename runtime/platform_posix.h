/* platform.h on POSIX systems: Linux, macOS.
 * SPDX-License-Identifier: MIT */
#ifndef PLATFORM_POSIX_H
#define PLATFORM_POSIX_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L /* declares threads and pread with a strict -std option */
#endif
#include <errno.h>
#include <fcntl.h>
#ifndef VXS_ONE_THREAD
#include <pthread.h>
#endif
#include <stdint.h>
#include <sys/stat.h>
#include <unistd.h>

#include "vxs_result.h"

/* files ----------------------------------------------------------------------------------------------------------------------- */

typedef struct os_file {
    int      descriptor;
    uint64_t size_bytes;
} os_file;

static inline vxs_result os_file_open(os_file *file, const char *path)
{
    struct stat about;
    file->descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (file->descriptor < 0)
        return errno == ENOENT || errno == ENOTDIR ? VXS_E_NO_FILE : errno == ENOMEM ? VXS_E_MEMORY : VXS_E_READ;
    if (!fstat(file->descriptor, &about) && S_ISREG(about.st_mode)) {
        file->size_bytes = (uint64_t)about.st_size;
        return VXS_OK;
    }
    close(file->descriptor);
    return VXS_E_READ;
}

static inline void os_file_close(os_file *file)
{
    close(file->descriptor);
}

static inline int os_file_read(const os_file *file, uint64_t offset, uint64_t size_bytes, void *to)
{
    while (size_bytes) {
        ssize_t got = pread(file->descriptor, to, size_bytes, (off_t)offset);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return 0;
        to = (char *)to + got;
        offset += (uint64_t)got;
        size_bytes -= (uint64_t)got;
    }
    return 1;
}

/* threads --------------------------------------------------------------------------------------------------------------------- */

#ifndef VXS_ONE_THREAD

typedef pthread_mutex_t os_mutex;
typedef pthread_cond_t  os_signal;
typedef pthread_t       os_thread;

static inline int os_mutex_init(os_mutex *m)
{
    return pthread_mutex_init(m, NULL) == 0;
}

static inline int os_signal_init(os_signal *s)
{
    return pthread_cond_init(s, NULL) == 0;
}

static inline int os_thread_start(os_thread *t, void *(*run)(void *), void *work)
{
    return pthread_create(t, NULL, run, work) == 0;
}

static inline void os_mutex_free(os_mutex *m)
{
    pthread_mutex_destroy(m);
}

static inline void os_signal_free(os_signal *s)
{
    pthread_cond_destroy(s);
}

static inline void os_lock(os_mutex *m)
{
    pthread_mutex_lock(m);
}

static inline void os_unlock(os_mutex *m)
{
    pthread_mutex_unlock(m);
}

static inline void os_wait(os_signal *s, os_mutex *m)
{
    pthread_cond_wait(s, m);
}

static inline void os_wake_all(os_signal *s)
{
    pthread_cond_broadcast(s);
}

static inline void os_thread_join(os_thread t)
{
    pthread_join(t, NULL);
}

#endif

#endif
