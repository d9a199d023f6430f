// One call of the program fails: a library for LD_PRELOAD that stands before libc's functions.
//
//   FAULT=CALL:N:WHAT       the N-th call of CALL, counted from 1, does WHAT. N 0: none
//       CALL  alloc (malloc, calloc, realloc, aligned_alloc, operator new, and what allocates inside: strdup, asprintf, realpath,
//             fopen, fdopen, opendir), open, read, write, close, link, rename, fsync, thread
//       WHAT  a number: fail with that errno (alloc: without memory);  short: read half of what is requested;  kill: SIGKILL;
//             interrupt: SIGINT
//   FAULT_EVERY=1           every call from the N-th on, not that one alone
//   FAULT_FROM=libzstd      alloc: calls made by the library of this name; without it, by the program itself
//   FAULT_NO_NAMELESS=1     open knows no O_TMPFILE, as on NFS
//   FAULT_COUNT=FILE        write the number of calls there when the program ends, and in lines of their own the calls that were
//   the
//                           first of their place: of the last STACK_DEPTH functions of the program or library that lead to it
//
// Calls of other libraries do not count, so that Mesa or a loader may fail or not as it likes, nor do calls before main. Streams
// that the program opens are backed by read and write here, since libc's own calls cannot be stood before.
// SPDX-License-Identifier: GPL-3.0-or-later
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <atomic>
#include <mutex>
#include <new>

namespace
{

std::atomic<long> calls{0};
long              fault_at = 0;
char              fault_call[16], fault_what[16];
bool              fault_every = false, main_runs = false;
const char       *count_path = nullptr, *from = "";
// where the code lies whose calls count
uintptr_t         range_begin = 0, range_end = 0;

enum { STACK_DEPTH = 2, PLACES_MAX = 4096 };

// where calls came from, each place once, and the first call from there
struct place {
    uintptr_t stack[STACK_DEPTH];
    long      call;
};
place      places[PLACES_MAX];
int        place_count = 0;
std::mutex places_lock;

int find_range(dl_phdr_info *info, size_t, void *)
{
    bool wanted = *from ? strstr(info->dlpi_name, from) != nullptr : !*info->dlpi_name;
    for (int n = 0; wanted && n < info->dlpi_phnum; n++) {
        const ElfW(Phdr) &h = info->dlpi_phdr[n];
        if (h.p_type != PT_LOAD || !(h.p_flags & PF_X)) continue;
        range_begin = info->dlpi_addr + h.p_vaddr;
        range_end   = range_begin + h.p_memsz;
    }
    return wanted;
}

__attribute__((constructor)) void begin()
{
    const char *fault = getenv("FAULT");
    if (fault) sscanf(fault, "%15[^:]:%ld:%15s", fault_call, &fault_at, fault_what);
    if (getenv("FAULT_FROM")) from = getenv("FAULT_FROM");
    fault_every = getenv("FAULT_EVERY") != nullptr;
    count_path  = getenv("FAULT_COUNT");
    dl_iterate_phdr(find_range, nullptr);
}

__attribute__((destructor)) void end()
{
    if (!count_path) return;
    int  file = open(count_path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    char text[32];
    if (write(file, text, (size_t)snprintf(text, sizeof text, "%ld", calls.load())) < 0) abort();
    for (int n = 0; n < place_count; n++)
        if (write(file, text, (size_t)snprintf(text, sizeof text, "\n%ld", places[n].call)) < 0) abort();
}

bool in_range(const void *code)
{
    return (uintptr_t)code >= range_begin && (uintptr_t)code < range_end;
}

bool counts(const void *caller)
{
    return main_runs && in_range(caller);
}

void note_place(long call)
{
    thread_local bool inside = false; // backtrace() may allocate
    if (inside) return;
    inside = true;
    void *stack[64];
    place here  = {{}, call};
    int   depth = backtrace(stack, 64), found = 0;
    for (int n = 0; n < depth && found < STACK_DEPTH; n++)
        if (in_range(stack[n])) here.stack[found++] = (uintptr_t)stack[n];
    std::lock_guard<std::mutex> held(places_lock);
    int                         n = 0;
    while (n < place_count && memcmp(places[n].stack, here.stack, sizeof here.stack)) n++;
    if (n == place_count && n < PLACES_MAX) places[place_count++] = here;
    inside = false;
}

// Whether this call is the one; errno is set.
bool fails(const char *call, const void *caller)
{
    if (strcmp(call, fault_call) || !counts(caller)) return false;
    long n = ++calls;
    if (count_path) note_place(n);
    if (!fault_at || n < fault_at || (n > fault_at && !fault_every)) return false;
    if (!strcmp(fault_what, "kill")) kill(getpid(), SIGKILL);
    if (!strcmp(fault_what, "interrupt")) kill(getpid(), SIGINT);
    errno = atoi(fault_what);
    return errno || !strcmp(fault_what, "short");
}

template <typename F> F next(F, const char *name)
{
    return (F)dlsym(RTLD_NEXT, name);
}

#define CALLER __builtin_return_address(0)
#define NEXT(name)                                                                                                                 \
    static decltype(&name) real = nullptr;                                                                                         \
    if (!real) real             = next(real, #name)

ssize_t faulty_read(int file, void *to, size_t size, const void *caller)
{
    NEXT(read);
    if (!fails("read", caller)) return real(file, to, size);
    if (errno) return -1;
    return real(file, to, size > 1 ? size / 2 : size);
}

ssize_t faulty_write(int file, const void *bytes, size_t size, const void *caller)
{
    NEXT(write);
    return fails("write", caller) ? -1 : real(file, bytes, size);
}

int faulty_close(int file, const void *caller)
{
    NEXT(close);
    int error  = fails("close", caller) ? errno : 0;
    int result = real(file);
    if (error) errno = error;
    return error ? -1 : result;
}

int (*real_main)(int, char **, char **);

int start_main(int argc, char **argv, char **environment)
{
    main_runs = true;
    return real_main(argc, argv, environment);
}

// A stream over a descriptor, whose reads and writes come here; they count as the program's.
ssize_t stream_read(void *cookie, char *to, size_t size)
{
    return faulty_read((int)(intptr_t)cookie, to, size, (void *)range_begin);
}
ssize_t stream_write(void *cookie, const char *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        ssize_t n = faulty_write((int)(intptr_t)cookie, bytes + done, size - done, (void *)range_begin);
        if (n < 0) return 0; // what fopencookie(3) wants for an error
        done += (size_t)n;
    }
    return (ssize_t)done;
}
int stream_seek(void *cookie, off64_t *offset, int whence)
{
    off64_t at = lseek64((int)(intptr_t)cookie, *offset, whence);
    if (at >= 0) *offset = at;
    return at < 0 ? -1 : 0;
}
int stream_close(void *cookie)
{
    return faulty_close((int)(intptr_t)cookie, (void *)range_begin);
}

FILE *stream_over(int file, const char *mode)
{
    FILE *f = fopencookie((void *)(intptr_t)file, mode, {stream_read, stream_write, stream_seek, stream_close});
    if (f) f->_fileno = file; // fileno() is requested
    return f;
}

} // namespace

extern "C" {

int __libc_start_main(int (*program)(int, char **, char **), int argc, char **argv, void (*init)(), void (*fini)(),
                      void (*rtld_fini)(), void *stack_end)
{
    real_main  = program;
    auto *real = (int (*)(int (*)(int, char **, char **), int, char **, void (*)(), void (*)(), void (*)(), void *))dlsym(
        RTLD_NEXT, "__libc_start_main");
    return real(start_main, argc, argv, init, fini, rtld_fini, stack_end);
}

void *malloc(size_t size)
{
    NEXT(malloc);
    return fails("alloc", CALLER) ? nullptr : real(size);
}
void *realloc(void *old, size_t size)
{
    NEXT(realloc);
    return fails("alloc", CALLER) ? nullptr : real(old, size);
}
// dlsym may request zeroed memory while it looks calloc up: this one needs no looking up
void *__libc_calloc(size_t, size_t);
void *calloc(size_t count, size_t size)
{
    return fails("alloc", CALLER) ? nullptr : __libc_calloc(count, size);
}
void *aligned_alloc(size_t alignment, size_t size)
{
    NEXT(aligned_alloc);
    return fails("alloc", CALLER) ? nullptr : real(alignment, size);
}
int posix_memalign(void **memory, size_t alignment, size_t size)
{
    NEXT(posix_memalign);
    return fails("alloc", CALLER) ? ENOMEM : real(memory, alignment, size);
}
char *strdup(const char *text)
{
    NEXT(strdup);
    return fails("alloc", CALLER) ? nullptr : real(text);
}
char *strndup(const char *text, size_t size)
{
    NEXT(strndup);
    return fails("alloc", CALLER) ? nullptr : real(text, size);
}
int asprintf(char **text, const char *format, ...)
{
    if (fails("alloc", CALLER)) return -1;
    va_list args;
    va_start(args, format);
    int length = vasprintf(text, format, args);
    va_end(args);
    return length;
}
char *realpath(const char *path, char *to)
{
    NEXT(realpath);
    return fails("alloc", CALLER) ? nullptr : real(path, to);
}
DIR *opendir(const char *path)
{
    NEXT(opendir);
    return fails("alloc", CALLER) ? nullptr : real(path);
}
DIR *fdopendir(int folder)
{
    NEXT(fdopendir);
    return fails("alloc", CALLER) ? nullptr : real(folder);
}

static int open_faulty(const char *path, int flags, mode_t mode, const void *caller)
{
    static int (*real)(const char *, int, ...) = nullptr;
    if (!real) real = (int (*)(const char *, int, ...))dlsym(RTLD_NEXT, "open");
    if (counts(caller) && (flags & O_TMPFILE) == O_TMPFILE && getenv("FAULT_NO_NAMELESS")) return errno = EOPNOTSUPP, -1;
    return fails("open", caller) ? -1 : real(path, flags, mode);
}
int open(const char *path, int flags, ...)
{
    va_list args;
    va_start(args, flags);
    mode_t mode = va_arg(args, mode_t);
    va_end(args);
    return open_faulty(path, flags, mode, CALLER);
}
int open64(const char *path, int flags, ...)
{
    va_list args;
    va_start(args, flags);
    mode_t mode = va_arg(args, mode_t);
    va_end(args);
    return open_faulty(path, flags, mode, CALLER);
}
FILE *fopen(const char *path, const char *mode)
{
    NEXT(fopen);
    if (!counts(CALLER)) return real(path, mode);
    if (fails("alloc", CALLER)) return nullptr;
    int flags = *mode == 'r' ? O_RDONLY : O_WRONLY | O_CREAT | O_TRUNC;
    int file  = open_faulty(path, flags | O_CLOEXEC, 0666, CALLER);
    return file < 0 ? nullptr : stream_over(file, mode);
}
FILE *fdopen(int file, const char *mode) noexcept
{
    NEXT(fdopen);
    if (!counts(CALLER)) return real(file, mode);
    return fails("alloc", CALLER) ? nullptr : stream_over(file, mode);
}
ssize_t read(int file, void *to, size_t size)
{
    return faulty_read(file, to, size, CALLER);
}
ssize_t write(int file, const void *bytes, size_t size)
{
    return faulty_write(file, bytes, size, CALLER);
}
int close(int file)
{
    return faulty_close(file, CALLER);
}
int linkat(int from_folder, const char *from_path, int to_folder, const char *to_path, int flags)
{
    NEXT(linkat);
    if (fails("link", CALLER)) return -1;
    int result = real(from_folder, from_path, to_folder, to_path, flags);
    return result;
}
int rename(const char *old_path, const char *new_path)
{
    NEXT(rename);
    return fails("rename", CALLER) ? -1 : real(old_path, new_path);
}
int fsync(int file)
{
    NEXT(fsync);
    return fails("fsync", CALLER) ? -1 : real(file);
}
int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*body)(void *), void *user)
{
    NEXT(pthread_create);
    return fails("thread", CALLER) ? EAGAIN : real(thread, attributes, body, user);
}

} // extern "C"

void *operator new(size_t size)
{
    void *memory = fails("alloc", CALLER) ? nullptr : malloc(size ? size : 1);
    if (!memory) throw std::bad_alloc();
    return memory;
}
void *operator new[](size_t size)
{
    void *memory = fails("alloc", CALLER) ? nullptr : malloc(size ? size : 1);
    if (!memory) throw std::bad_alloc();
    return memory;
}
void *operator new(size_t size, const std::nothrow_t &) noexcept
{
    return fails("alloc", CALLER) ? nullptr : malloc(size ? size : 1);
}
