/* The operating system of WebAssembly builds: POSIX functions that emscripten's C library has only for its own JavaScript, and the answers
 * to memory.h, clock.h, pages.h, terminal.h and system.h. The host (host.mjs) does what needs a system; standard streams, reads, writes
 * and clocks go to it as WASI calls, as emscripten's C library makes them.
 *
 * Functions of the host return a negated errno on failure. Paths are UTF-8. A path is relative to the open folder `dir`, or with AT_FDCWD
 * to the current one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <malloc.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "baker/base/clock.h"
#include "baker/base/integer.h"
#include "baker/base/memory.h"
#include "baker/base/pages.h"
#include "baker/base/system.h"
#include "baker/base/terminal.h"
#include "baker/command/process/watched_files.h"

#define HOST(name) extern __attribute__((import_module("vxs"), import_name(#name)))

/* Numbers of a file, as host.mjs writes them. */
typedef struct host_stat {
    int64_t dev, ino, mode, nlink, uid, gid, size, mtime_seconds, mtime_nanoseconds;
} host_stat;

HOST(open) int host_open(int dir, const char *path, int flags, int mode);
HOST(stat) int host_stat_of(int dir, const char *path, int is_link_itself, host_stat *s);
HOST(fstat) int host_fstat(int fd, host_stat *s);
HOST(list) int host_list(int fd, char *names, int room);
HOST(unlink) int host_unlink(int dir, const char *path);
HOST(rename) int host_rename(const char *from, const char *to);
HOST(mkdir) int host_mkdir(const char *path, int mode);
HOST(realpath) int host_realpath(const char *path, char *to, int room);
HOST(access) int host_access(const char *path, int mode);
HOST(chmod) int host_chmod(int fd, int mode);
HOST(chown) int host_chown(int fd, int uid, int gid);
HOST(dup) int host_dup(int fd, int to);
HOST(is_open) int host_is_open(int fd);
HOST(is_terminal) int host_is_terminal(int fd);
HOST(is_broken) int host_is_broken(int fd);
HOST(columns) int host_columns(int fd);
HOST(process) int host_process(void);
HOST(processors) int host_processors(void);
HOST(shows_progress) int host_shows_progress(void);
HOST(show_progress) void host_show_progress(double share, const char *doing);
HOST(available_bytes) double host_available_bytes(void);

/* what emscripten's C library calls, in the place of its own JavaScript */
long     __syscall_open(long path, long flags, ...);
void     setTempRet0(uint32_t value);
uint32_t getTempRet0(void);
void     __call_sighandler(void (*handler)(int number), int number);
int      madvise(void *address, size_t size, int advice);

static int done(int result)
{
    if (result >= 0) return result;
    errno = -result;
    return -1;
}

/* files ----------------------------------------------------------------------------------------------------------------------- */

static int mode_of(int flags, va_list args)
{
    return flags & O_CREAT ? va_arg(args, int) : 0;
}

int open(const char *path, int flags, ...)
{
    va_list args;
    va_start(args, flags);
    int mode = mode_of(flags, args);
    va_end(args);
    return done(host_open(AT_FDCWD, path, flags, mode));
}

int openat(int dir, const char *path, int flags, ...)
{
    va_list args;
    va_start(args, flags);
    int mode = mode_of(flags, args);
    va_end(args);
    return done(host_open(dir, path, flags, mode));
}

long __syscall_open(long path, long flags, ...)
{
    va_list args;
    va_start(args, flags);
    int mode = mode_of(flags, args);
    va_end(args);
    return host_open(AT_FDCWD, (const char *)path, flags, mode);
}

static int copy_stat(int result, const host_stat *from, struct stat *to)
{
    if (result < 0) return done(result);
    *to = (struct stat){.st_dev   = (dev_t)(from->dev ^ from->dev >> 32),
                        .st_ino   = (ino_t)from->ino,
                        .st_mode  = (mode_t)from->mode,
                        .st_nlink = (nlink_t)from->nlink,
                        .st_uid   = (uid_t)from->uid,
                        .st_gid   = (gid_t)from->gid,
                        .st_size  = from->size,
                        .st_mtim  = {.tv_sec = from->mtime_seconds, .tv_nsec = (long)from->mtime_nanoseconds}};
    return 0;
}

int fstatat(int dir, const char *restrict path, struct stat *restrict to, int flags)
{
    host_stat s;
    return copy_stat(host_stat_of(dir, path, !!(flags & AT_SYMLINK_NOFOLLOW), &s), &s, to);
}

int stat(const char *restrict path, struct stat *restrict to)
{
    return fstatat(AT_FDCWD, path, to, 0);
}

int lstat(const char *restrict path, struct stat *restrict to)
{
    return fstatat(AT_FDCWD, path, to, AT_SYMLINK_NOFOLLOW);
}

int fstat(int fd, struct stat *to)
{
    host_stat s;
    return copy_stat(host_fstat(fd, &s), &s, to);
}

int unlink(const char *path)
{
    return done(host_unlink(AT_FDCWD, path));
}

int unlinkat(int dir, const char *path, int flags)
{
    return done(flags ? -ENOSYS : host_unlink(dir, path));
}

int rename(const char *from, const char *to)
{
    return done(host_rename(from, to));
}

/* Only for files without a name, which hosts do not have. */
int linkat(int from_dir, const char *from, int to_dir, const char *to, int flags)
{
    (void)from_dir, (void)from, (void)to_dir, (void)to, (void)flags;
    return done(-ENOSYS);
}

int mkdir(const char *path, mode_t mode)
{
    return done(host_mkdir(path, (int)mode));
}

char *realpath(const char *restrict path, char *restrict to)
{
    char found[PATH_MAX];
    if (done(host_realpath(path, found, PATH_MAX)) < 0) return NULL;
    return to ? strcpy(to, found) : strdup(found);
}

int access(const char *path, int mode)
{
    return done(host_access(path, mode));
}

int fchmod(int fd, mode_t mode)
{
    return done(host_chmod(fd, (int)mode));
}

int fchown(int fd, uid_t uid, gid_t gid)
{
    return done(host_chown(fd, (int)uid, (int)gid));
}

/* No host has locks. Of two bakes at once with one --resume folder, none can see the other. */
int flock(int fd, int operation)
{
    (void)fd, (void)operation;
    return done(-ENOSYS);
}

int dup(int fd)
{
    return done(host_dup(fd, -1));
}

int dup2(int fd, int to)
{
    return done(host_dup(fd, to));
}

int fcntl(int fd, int command, ...)
{
    if (command == F_DUPFD_CLOEXEC) return dup(fd);
    if (command == F_GETFD) return done(host_is_open(fd) ? FD_CLOEXEC : -EBADF);
    return done(-EINVAL);
}

int isatty(int fd)
{
    return host_is_terminal(fd);
}

int ioctl(int fd, int request, ...)
{
    if (request != TIOCGWINSZ || !isatty(fd)) return done(-ENOTTY);
    va_list args;
    va_start(args, request);
    *va_arg(args, struct winsize *) = (struct winsize){.ws_col = (unsigned short)host_columns(fd)};
    va_end(args);
    return 0;
}

/* folders: all names at once, each with its final 0 */
struct __dirstream {
    int           fd;
    char         *names, *next, *end;
    struct dirent entry;
};

DIR *fdopendir(int fd)
{
    DIR *d    = calloc(1, sizeof *d);
    int  size = d ? host_list(fd, NULL, 0) : -ENOMEM;
    if (size >= 0 && !(d->names = malloc((size_t)size + 1))) size = -ENOMEM;
    if (size >= 0) size = host_list(fd, d->names, size);
    if (done(size) >= 0) {
        d->fd   = fd;
        d->next = d->names;
        d->end  = d->names + size;
        return d;
    }
    if (d) free(d->names);
    free(d);
    return NULL;
}

DIR *opendir(const char *path)
{
    int  fd = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *d  = fd < 0 ? NULL : fdopendir(fd);
    if (fd >= 0 && !d) close(fd);
    return d;
}

struct dirent *readdir(DIR *d)
{
    if (d->next >= d->end) return NULL;
    snprintf(d->entry.d_name, sizeof d->entry.d_name, "%s", d->next);
    d->next += strlen(d->next) + 1;
    return &d->entry;
}

int closedir(DIR *d)
{
    int result = close(d->fd);
    free(d->names);
    free(d);
    return result;
}

int dirfd(DIR *d)
{
    return d->fd;
}

int standard_output_is_broken(void)
{
    return host_is_broken(STDOUT_FILENO);
}

int system_copy_attributes(const char *path, int descriptor)
{
    (void)path, (void)descriptor;
    return 0;
}

/* process --------------------------------------------------------------------------------------------------------------------- */

pid_t getpid(void)
{
    return host_process();
}

uint32_t system_processors(void)
{
    return (uint32_t)host_processors();
}

int system_program(char *path, size_t room)
{
    (void)path, (void)room;
    return 0;
}

static _Thread_local uint32_t kept;

void setTempRet0(uint32_t value)
{
    kept = value;
}

uint32_t getTempRet0(void)
{
    return kept;
}

void __call_sighandler(void (*handler)(int number), int number)
{
    handler(number);
}

int madvise(void *address, size_t size, int advice)
{
    (void)address, (void)size, (void)advice;
    return 0;
}

/* Bytes up to the end of the heap, which is never given back to the host, but used again. */
static uint64_t heap_bytes(void)
{
    return (uint64_t)(uintptr_t)sbrk(0);
}

uint64_t memory_held_bytes(void)
{
    return heap_bytes() - (uint64_t)mallinfo().fordblks;
}

uint64_t memory_available_bytes(void)
{
    uint64_t unused = (uint64_t)mallinfo().fordblks, growth = ((uint64_t)4 << 30) - heap_bytes();
    double   host = host_available_bytes();
    return unused + (host < (double)growth ? (uint64_t)host : growth);
}

int memory_has_room(uint64_t bytes)
{
    return bytes <= memory_available_bytes();
}

void memory_peak_reset(void) {}

uint64_t memory_peak_bytes(void)
{
    return heap_bytes();
}

void *pages_alloc(size_t size_bytes)
{
    return malloc(size_bytes);
}

/* ------------------------------------------------------------------------------------------------------------------------------ */

int run_apart(int (*run)(void *work), void *work)
{
    (void)run, (void)work;
    return -1;
}

int watched_files_begin(const char *const *paths, size_t count)
{
    (void)paths, (void)count;
    return -1;
}

int watched_files_wait(int descriptor, const char *const *paths, size_t count, int quiet_ms)
{
    (void)descriptor, (void)paths, (void)count, (void)quiet_ms;
    return 0;
}

int system_shows_progress(void)
{
    return host_shows_progress();
}

void system_show_progress(double share, const char *doing)
{
    host_show_progress(share, doing);
}

static _Thread_local struct {
    int (*compare)(const void *a, const void *b, void *user);
    void *user;
} sorted;

static int compare_sorted(const void *a, const void *b)
{
    return sorted.compare(a, b, sorted.user);
}

void system_sort(void *items, size_t count, size_t item_bytes, int (*compare)(const void *a, const void *b, void *user), void *user)
{
    sorted.compare = compare;
    sorted.user    = user;
    qsort(items, count, item_bytes, compare_sorted);
}

/* Messages as native ones have them: those of glibc, for the errors that files give. */
char *strerror(int error)
{
    static const struct {
        int         error;
        const char *text;
    } texts[] = {
        {EACCES, "Permission denied"},
        {EAGAIN, "Resource temporarily unavailable"},
        {EBADF, "Bad file descriptor"},
        {EBUSY, "Device or resource busy"},
        {EDQUOT, "Disk quota exceeded"},
        {EEXIST, "File exists"},
        {EFBIG, "File too large"},
        {EINTR, "Interrupted system call"},
        {EINVAL, "Invalid argument"},
        {EIO, "Input/output error"},
        {EISDIR, "Is a directory"},
        {ELOOP, "Too many levels of symbolic links"},
        {EMFILE, "Too many open files"},
        {ENAMETOOLONG, "File name too long"},
        {ENFILE, "Too many open files in system"},
        {ENODEV, "No such device"},
        {ENOENT, "No such file or directory"},
        {ENOMEM, "Cannot allocate memory"},
        {ENOSPC, "No space left on device"},
        {ENOSYS, "Function not implemented"},
        {ENOTDIR, "Not a directory"},
        {ENOTEMPTY, "Directory not empty"},
        {ENOTSUP, "Operation not supported"},
        {ENXIO, "No such device or address"},
        {EPERM, "Operation not permitted"},
        {EPIPE, "Broken pipe"},
        {ERANGE, "Numerical result out of range"},
        {EROFS, "Read-only file system"},
        {ESPIPE, "Illegal seek"},
        {ETXTBSY, "Text file busy"},
        {EXDEV, "Invalid cross-device link"},
    };
    static char unknown[32];
    for (size_t n = 0; n < sizeof texts / sizeof *texts; n++)
        if (texts[n].error == error) return (char *)texts[n].text;
    snprintf(unknown, sizeof unknown, "Unknown error %d", error);
    return unknown;
}
