/* What the runtime needs of an operating system: files that are read by position, and threads. Not installed. Of the types os_file, os_mutex,
 * os_signal and os_thread only size_bytes of a file is looked at.
 *
 *     int  os_file_open(os_file *, const char *path)     0: there is no such file, or it is a folder or a pipe: errno says why; path in UTF-8
 *     int  os_file_read(const os_file *, uint64_t offset, uint64_t size_bytes, void *to)    exactly so many, from any thread; 0: it cannot
 *     void os_file_close(os_file *)
 *
 *     int  os_mutex_init(os_mutex *), os_signal_init(os_signal *)         0: there is none to be had
 *     int  os_thread_start(os_thread *, void *(*run)(void *), void *work) 0: there is none; the os_thread stays where it is until it is joined
 *     void os_lock, os_unlock(os_mutex *)
 *     void os_wait(os_signal *, os_mutex *)                               without the lock in the meantime
 *     void os_wake_all(os_signal *)
 *     void os_thread_join(os_thread), os_mutex_free(os_mutex *), os_signal_free(os_signal *)
 *
 * SPDX-License-Identifier: MIT */
#ifndef PLATFORM_H
#define PLATFORM_H

#ifdef _WIN32
#include "platform_windows.h"
#else
#include "platform_posix.h"
#endif

#endif
