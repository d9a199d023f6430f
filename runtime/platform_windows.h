/* platform.h on Windows.
 * SPDX-License-Identifier: MIT */
#ifndef PLATFORM_WINDOWS_H
#define PLATFORM_WINDOWS_H

#ifndef WIN32_LEAN_AND_MEAN
#define WIN32_LEAN_AND_MEAN
#endif
#include <windows.h>
#undef near /* macros of 16-bit times, and names here */
#undef far

#include <process.h>
#include <stdint.h>
#include <stdlib.h>

#include "vxs_result.h"

/* files ----------------------------------------------------------------------------------------------------------------------- */

typedef struct os_file {
    HANDLE   handle;
    uint64_t size_bytes;
} os_file;

/* path  UTF-8 */
static inline HANDLE os_open_utf8(const char *path)
{
    HANDLE   handle = INVALID_HANDLE_VALUE;
    int      count  = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, NULL, 0);
    wchar_t *wide   = count > 0 ? malloc((size_t)count * sizeof *wide) : NULL;
    if (wide && MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, wide, count) == count)
        handle = CreateFileW(wide, GENERIC_READ, FILE_SHARE_READ, NULL, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, NULL);
    free(wide);
    return handle;
}

static inline vxs_result os_file_open(os_file *file, const char *path)
{
    LARGE_INTEGER size;
    file->handle = os_open_utf8(path);
    if (file->handle == INVALID_HANDLE_VALUE) {
        DWORD why = GetLastError();
        if (why == ERROR_FILE_NOT_FOUND || why == ERROR_PATH_NOT_FOUND) return VXS_E_NO_FILE;
        return why == ERROR_NOT_ENOUGH_MEMORY || why == ERROR_OUTOFMEMORY ? VXS_E_MEMORY : VXS_E_READ;
    }
    if (GetFileType(file->handle) == FILE_TYPE_DISK && GetFileSizeEx(file->handle, &size)) {
        file->size_bytes = (uint64_t)size.QuadPart;
        return VXS_OK;
    }
    CloseHandle(file->handle);
    return VXS_E_READ;
}

static inline void os_file_close(os_file *file)
{
    CloseHandle(file->handle);
}

static inline int os_file_read(const os_file *file, uint64_t offset, uint64_t size_bytes, void *to)
{
    while (size_bytes) {
        OVERLAPPED at  = {.Offset = (DWORD)offset, .OffsetHigh = (DWORD)(offset >> 32)};
        DWORD      got = 0, asked = size_bytes < (1u << 30) ? (DWORD)size_bytes : 1u << 30;
        if (!ReadFile(file->handle, to, asked, &got, &at)) return 0;
        if (!got) return 0;
        to = (char *)to + got;
        offset += got;
        size_bytes -= got;
    }
    return 1;
}

/* threads --------------------------------------------------------------------------------------------------------------------- */

#ifndef VXS_ONE_THREAD

typedef SRWLOCK            os_mutex;
typedef CONDITION_VARIABLE os_signal;

typedef struct os_thread {
    uintptr_t handle;
    void *(*run)(void *work);
    void *work;
} os_thread;

static inline int os_mutex_init(os_mutex *m)
{
    InitializeSRWLock(m);
    return 1;
}

static inline int os_signal_init(os_signal *s)
{
    InitializeConditionVariable(s);
    return 1;
}

static inline unsigned __stdcall os_thread_main(void *thread)
{
    os_thread *t = thread;
    t->run(t->work);
    return 0;
}

static inline int os_thread_start(os_thread *t, void *(*run)(void *work), void *work)
{
    t->run    = run;
    t->work   = work;
    t->handle = _beginthreadex(NULL, 0, os_thread_main, t, 0, NULL);
    return t->handle != 0;
}

static inline void os_mutex_free(os_mutex *m)
{
    (void)m;
}

static inline void os_signal_free(os_signal *s)
{
    (void)s;
}

static inline void os_lock(os_mutex *m)
{
    AcquireSRWLockExclusive(m);
}

static inline void os_unlock(os_mutex *m)
{
    ReleaseSRWLockExclusive(m);
}

static inline void os_wait(os_signal *s, os_mutex *m)
{
    SleepConditionVariableSRW(s, m, INFINITE, 0);
}

static inline void os_wake_all(os_signal *s)
{
    WakeAllConditionVariable(s);
}

static inline void os_thread_join(os_thread t)
{
    WaitForSingleObject((HANDLE)t.handle, INFINITE);
    CloseHandle((HANDLE)t.handle);
}

#endif

#endif
