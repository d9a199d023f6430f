/* Output files that appear complete or not at all; see output_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/output_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/base/text.h"
#include "baker/base/threads.h"
#include "baker/files/file_access.h"
#include "baker/files/input_file.h"
#include "baker/files/replaced_file.h"
#include "baker/files/run_files.h"
#include "baker/files/temporary_files.h"

/* enough for the files left by killed runs with the same process number */
enum { TEMPORARY_NAMES = 1000 };

static vxs_result out_of_memory(const char *path, run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory while opening %s", path);
}

static vxs_result cannot_write(const output_file *f, int error, run_context *m)
{
    return fail(m, VXS_E_WRITE, "%s: cannot write: %s%s", f->name, strerror(error),
                error == ENOENT && !m->access ? ": its folder is not there" : "");
}

/* The path in /proc of an open file. A link to this path gives the unnamed file its first name. */
static void descriptor_path(char path[64], int descriptor)
{
    snprintf(path, 64, "/proc/self/fd/%d", descriptor);
}

/* Create a new file with this name, or link the unnamed file `descriptor` to it. Returns -1 and errno on failure. */
static int take_name(const char *name, int descriptor)
{
    char from[64];
    if (descriptor < 0) return open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    descriptor_path(from, descriptor);
    return linkat(AT_FDCWD, from, AT_FDCWD, name, AT_SYMLINK_FOLLOW);
}

/* The same, and register the name with f->remembered for as long as the file has it. Signals are blocked between the two steps: the
 * name must not be registered earlier, because until then it may belong to another process's file. */
static int take_and_remember_name(output_file *f, int descriptor)
{
    sigset_t before;
    if (!f->remembered) return take_name(f->temporary, descriptor);
    threads_block_signals(&before);
    int taken = take_name(f->temporary, descriptor);
    int error = errno;
    if (taken >= 0) f->pending = temporary_files_remember(f->remembered, f->temporary);
    threads_unblock_signals(&before);
    errno = error;
    return taken;
}

/* Find a free name, f->temporary, for a new file (descriptor -1) or for an unnamed one. mkstemp is not usable: it sets the
 * permissions 0600, and umask cannot be read without changing it.
 * taken  [out] result of open or linkat */
static vxs_result name_temporary(output_file *f, int descriptor, int *taken, run_context *m)
{
    for (int n = 0; n < TEMPORARY_NAMES; n++) {
        /* a name beside the target, unique by the process number */
        char folder[PATH_MAX] = "", *name;
        path_split(f->target, folder);
        if (asprintf(&name, "%s.vxs-%ld-%d.tmp", folder, (long)getpid(), n) < 0) return out_of_memory(f->name, m);
        f->temporary = name;
        *taken       = take_and_remember_name(f, descriptor);
        if (*taken >= 0) return VXS_OK;
        int error = errno;
        free(f->temporary);
        f->temporary = NULL;
        if (error != EEXIST) return cannot_write(f, error, m);
    }
    return cannot_write(f, EEXIST, m);
}

/* Open the folder of f->target. Returns -1 and errno on failure. */
static int open_folder(const output_file *f, int flags)
{
    char folder[PATH_MAX];
    errno = ENAMETOOLONG;
    return path_split(f->target, folder) ? open(folder, flags, 0666) : -1;
}

/* Create an unnamed file in the folder of f->target. The system removes it if the process ends early. Returns -1 where the file
 * system or the kernel does not support this, or cannot name such a file later. */
static int create_nameless(const output_file *f)
{
#ifdef O_TMPFILE
    char path[64];
    int  descriptor = open_folder(f, O_TMPFILE | O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) return -1;
    descriptor_path(path, descriptor);
    if (!access(path, F_OK)) return descriptor;
    close(descriptor);
#else
    (void)f;
#endif
    return -1;
}

static vxs_result open_temporary(output_file *f, run_context *m)
{
    int        descriptor = create_nameless(f);
    vxs_result r          = descriptor < 0 ? name_temporary(f, -1, &descriptor, m) : VXS_OK;
    if (r != VXS_OK) return r;
    f->stream = fdopen(descriptor, "wb");
    if (f->stream) return VXS_OK;
    close(descriptor);
    if (f->temporary) unlink(f->temporary);
    return out_of_memory(f->name, m);
}

/* Objects that a rename cannot replace: a device, a pipe, and an open file whose name was removed (/dev/fd/3). */
static int is_written_directly(const struct stat *s)
{
    return !S_ISDIR(s->st_mode) && (!S_ISREG(s->st_mode) || !s->st_nlink);
}

/* For an existing path, links are resolved; a new path is used as given.
 * old  status of the existing file; NULL: none */
static vxs_result open_beside(output_file *f, const char *path, const struct stat *old, run_context *m)
{
    vxs_result r = old ? replaced_file_check(path, old, m) : VXS_OK;
    if (r != VXS_OK) return r;
    f->target = old ? realpath(path, NULL) : strdup(path);
    if (!f->target) return errno == ENOMEM ? out_of_memory(path, m) : cannot_write(f, errno, m);
    r = open_temporary(f, m);
    return r == VXS_OK && old ? replaced_file_keep(f->target, old, fileno(f->stream), m) : r;
}

static void release(output_file *f)
{
    if (f->remembered) temporary_files_forget(f->remembered, f->pending);
    free(f->name);
    free(f->target);
    free(f->temporary);
    free(f->memory);
    *f = (output_file){0};
}

vxs_result output_file_open(output_file *f, const char *path, run_context *m)
{
    int is_stdout = !strcmp(path, "-");
    *f            = (output_file){.name = strdup(is_stdout ? "standard output" : path), .remembered = m->temporary};
    if (!f->name) return out_of_memory(path, m);
    if (is_stdout) {
        f->stream = stdout;
        return VXS_OK;
    }

    if (m->access) {
        f->stream    = open_memstream(&f->memory, &f->memory_bytes);
        vxs_result r = f->stream ? VXS_OK : out_of_memory(path, m);
        if (r != VXS_OK) output_file_abort(f);
        return r;
    }

    struct stat status, link;
    int         exists = !stat(path, &status), error = errno;
    vxs_result  r;
    if (!path[0])
        r = fail(m, VXS_E_WRITE, "the output's name is empty: expected a file name, or - for standard output");
    else if (exists && S_ISDIR(status.st_mode))
        r = fail(m, VXS_E_WRITE, "%s: cannot write: it is a folder, expected a file name", path);
    else if (!exists && !lstat(path, &link) && S_ISLNK(link.st_mode)) /* not a link: created by another process meanwhile */
        r = fail(m, VXS_E_WRITE, "%s: cannot write: it is a link that leads to no file: %s", path, strerror(error));
    else if (exists && (r = run_files_check_write(path, m)) != VXS_OK)
        ; /* the run reads this file, perhaps by another name */
    else if (!exists || !is_written_directly(&status))
        r = open_beside(f, path, exists ? &status : NULL, m);
    else if (!(f->stream = fopen(path, "wbe")))
        r = cannot_write(f, errno, m);
    if (r != VXS_OK) output_file_abort(f);
    return r;
}

vxs_result output_file_open_in_folder(output_file *f, const char *option, const char *folder, const char *name, run_context *m)
{
    char path[PATH_MAX];
    *f = (output_file){0};
    if ((size_t)snprintf(path, sizeof path, "%s/%s", folder, name) >= sizeof path)
        return fail(m, VXS_E_WRITE, "%s %s: the path is too long", option, folder);
    vxs_result r = run_files_check_write_in_folder(option, path, m);
    return r == VXS_OK ? output_file_open(f, path, m) : r;
}

vxs_result output_file_check(const char *path, run_context *m)
{
    struct stat out;
    if (m->access) return VXS_OK;
    if (!strcmp(path, "-") || (!stat(path, &out) && is_written_directly(&out))) return VXS_OK;

    /* includes the naming step: some file systems support unnamed files but cannot name them later */
    output_file f = {0};
    int         linked;
    vxs_result  r = output_file_open(&f, path, m);
    if (r == VXS_OK && f.target && !f.temporary) r = name_temporary(&f, fileno(f.stream), &linked, m);
    output_file_abort(&f);
    return r;
}

vxs_result output_file_write(output_file *f, const void *bytes, size_t size_bytes, run_context *m)
{
    if (size_bytes && fwrite(bytes, 1, size_bytes, f->stream) != size_bytes) return cannot_write(f, errno, m);
    return VXS_OK;
}

/* Flush a file, or the names of a folder, to the disk. Returns 0 or an errno. File systems without this operation are accepted. */
static int sync_to_disk(int descriptor)
{
    return !fsync(descriptor) || errno == EINVAL || errno == ENOTSUP ? 0 : errno;
}

vxs_result output_file_commit(output_file *f, run_context *m)
{
    if (m->access) {
        const file_access *access = m->access;
        vxs_result         r      = run_check(m);
        int                error  = ferror(f->stream) | fclose(f->stream); /* a stream of memory fails only without memory */
        f->stream                 = NULL;
        if (r == VXS_OK && error) r = out_of_memory(f->name, m);
        if (r == VXS_OK && (error = access->write(access->user, f->name, f->memory, f->memory_bytes)))
            r = cannot_write(f, error, m);
        release(f);
        return r;
    }
    vxs_result r      = run_check(m);
    int        error  = ferror(f->stream) ? EIO : 0, linked; /* an unchecked write through stdio failed: its errno is lost */
    int        folder = -1;
    if (fflush(f->stream)) error = errno;
    if (r != VXS_OK) {
        output_file_abort(f);
        return r;
    }
    int synced = f->target && !f->unsynced;
    if (!error && synced) error = sync_to_disk(fileno(f->stream));
    /* a folder that is writable but not readable cannot be flushed: accept this */
    if (!error && synced && (folder = open_folder(f, O_RDONLY | O_DIRECTORY | O_CLOEXEC)) < 0 && errno != EACCES) error = errno;
    if (!error && f->target && !f->temporary) r = name_temporary(f, fileno(f->stream), &linked, m);
    if (f->stream != stdout && fclose(f->stream) && !error) error = errno;
    if (!error && f->temporary && rename(f->temporary, f->target)) error = errno;
    if (error && f->temporary) unlink(f->temporary);
    if (!error && r == VXS_OK && folder >= 0) error = sync_to_disk(folder);

    if (error && r == VXS_OK) r = cannot_write(f, error, m);
    if (folder >= 0) close(folder);
    release(f);
    return r;
}

void output_file_abort(output_file *f)
{
    if (f->stream && f->stream != stdout) fclose(f->stream);
    if (f->stream && f->temporary) unlink(f->temporary);
    release(f);
}
