/* Operating system functions of the runtime: files read by position, and threads. Not installed. Of the types os_file, os_mutex,
 * os_signal and os_thread, only os_file's size_bytes is used directly.
 *
 *     vxs_result os_file_open(os_file *, const char *path)     path: UTF-8. VXS_OK, VXS_E_NO_FILE, VXS_E_MEMORY; VXS_E_READ: a folder, a
 *          pipe, or no permission
 *     int  os_file_read(const os_file *, uint64_t offset, uint64_t size_bytes, void *to)    exactly size_bytes; any thread. 0:
 *          failed
 *     void os_file_close(os_file *)
 *
 *     int  os_mutex_init(os_mutex *), os_signal_init(os_signal *)         0: failed
 *     int  os_thread_start(os_thread *, void *(*run)(void *), void *work) 0: failed; do not move the os_thread until it is joined
 *     void os_lock, os_unlock(os_mutex *)
 *     void os_wait(os_signal *, os_mutex *)                               releases the lock while it waits
 *     void os_wake_all(os_signal *)
 *     void os_thread_join(os_thread), os_mutex_free(os_mutex *), os_signal_free(os_signal *)
 *
 * With VXS_NO_FILES, which needs VXS_ONE_THREAD, there are no files. With VXS_ONE_THREAD (make threads=1) there are no threads: os_thread_start fails, and the other functions do nothing.
 * SPDX-License-Identifier: MIT */
#ifndef PLATFORM_H
#define PLATFORM_H

#ifdef VXS_NO_FILES
#include "platform_no_files.h"
#elif defined(_WIN32)
#include "platform_windows.h"
#else
#include "platform_posix.h"
#endif
#ifdef VXS_ONE_THREAD
#include "platform_one_thread.h"
#endif

#endif
