/* Input files; see input_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/base/memory.h"
#include "baker/base/text.h"
#include "baker/files/file_access.h"

enum { READ_AT_FIRST = 65536 };

int is_standard_input(const char *path)
{
    return !strcmp(path, "-");
}

const char *input_name(const char *path)
{
    return is_standard_input(path) ? "standard input" : path;
}

int input_open(const char *path)
{
    return is_standard_input(path) ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0) : open(path, O_RDONLY | O_CLOEXEC);
}

uint64_t input_bytes(const char *path, const run_context *m)
{
    struct stat status;
    if (!m->access) return stat(path, &status) || status.st_size < 0 ? 0 : (uint64_t)status.st_size;
    uint64_t size = m->access->size(m->access->user, path);
    return size == FILE_ACCESS_MISSING ? 0 : size;
}

int is_read_once(const char *path)
{
    struct stat status;
    return is_standard_input(path) || (!stat(path, &status) && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode));
}

/* State while an input is read. */
typedef struct input {
    const char  *name;
    int          descriptor;
    uint8_t     *bytes;
    size_t       size_bytes, room;
    uint64_t     known_bytes, wanted_bytes; /* size of a regular file; size that the first bytes give */
    run_context *m;
} input;

/* Grow the buffer to `room` bytes, after a check of the memory. */
static vxs_result make_room(input *in, size_t room)
{
    vxs_result r = memory_check(room, in->m, "'%s': reading it needs", in->name);
    if (r != VXS_OK) return r;
    void *larger = realloc(in->bytes, room);
    if (!larger) return fail(in->m, VXS_E_MEMORY, "out of memory while reading '%s'", in->name);
    in->bytes = larger;
    in->room  = room;
    return VXS_OK;
}

/* Read until size_bytes bytes are there, or to the end. */
static vxs_result read_up_to(input *in, uint64_t size_bytes)
{
    while (in->size_bytes < size_bytes) {
        if (in->size_bytes == in->room) {
            uint64_t   known = in->known_bytes < in->wanted_bytes ? in->known_bytes : 0; /* a byte more detects the end */
            uint64_t   room  = known >= in->room ? known + 1 : 2 * (uint64_t)in->room;
            vxs_result r     = make_room(in, (size_t)(room < size_bytes ? room : size_bytes));
            if (r != VXS_OK) return r;
        }
        size_t  most = size_bytes < in->room ? (size_t)size_bytes : in->room;
        ssize_t n    = read(in->descriptor, in->bytes + in->size_bytes, most - in->size_bytes);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            return fail(in->m, errno == ENOMEM ? VXS_E_MEMORY : VXS_E_READ, "cannot read '%s': %s", in->name, strerror(errno));
        if (n == 0) return VXS_OK;
        in->size_bytes += (size_t)n;
    }
    return VXS_OK;
}

static vxs_result too_large(const input *in, uint64_t limit_bytes)
{
    char text[32];
    return fail(in->m, VXS_E_MEMORY, "'%s' is larger than %s, the most that is read", in->name, size_text(text, limit_bytes));
}

/* Read the first bytes, then the rest if head wants it. */
static vxs_result read_all(input *in, uint64_t limit_bytes, const input_head *head)
{
    vxs_result r = make_room(in, READ_AT_FIRST);
    if (r == VXS_OK) r = read_up_to(in, READ_AT_FIRST);
    if (r != VXS_OK) return r;
    if (head) in->wanted_bytes = head->wanted(head->user, in->bytes, in->size_bytes);
    if (!in->wanted_bytes) return VXS_OK;
    uint64_t expected     = in->known_bytes && in->known_bytes < in->wanted_bytes ? in->known_bytes : in->wanted_bytes;
    int      is_too_large = expected > limit_bytes && expected < UINT64_MAX;
    uint64_t most         = in->wanted_bytes < limit_bytes ? in->wanted_bytes : limit_bytes;
    if (!is_too_large) r = read_up_to(in, most + 1);
    if (r != VXS_OK || (!is_too_large && in->size_bytes <= limit_bytes)) return r;
    return too_large(in, limit_bytes);
}

/* Read a whole file through m->access. */
static vxs_result read_from_caller(input *in, uint64_t limit_bytes, const input_head *head)
{
    const file_access *access = in->m->access;
    uint64_t           size   = access->size(access->user, in->name);
    if (size == FILE_ACCESS_MISSING) return fail(in->m, VXS_E_READ, "cannot read '%s': %s", in->name, strerror(ENOENT));
    if (size > limit_bytes) return too_large(in, limit_bytes);
    vxs_result r = make_room(in, size ? (size_t)size : 1);
    if (r != VXS_OK) return r;
    int error = access->read(access->user, in->name, in->bytes, (size_t)size);
    if (error) return fail(in->m, error == ENOMEM ? VXS_E_MEMORY : VXS_E_READ, "cannot read '%s': %s", in->name, strerror(error));
    in->size_bytes = (size_t)size;
    if (head) head->wanted(head->user, in->bytes, size < READ_AT_FIRST ? in->size_bytes : READ_AT_FIRST);
    return VXS_OK;
}

vxs_result input_read(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, const input_head *head,
                      run_context *m)
{
    input      in = {.name = input_name(path), .descriptor = -1, .wanted_bytes = UINT64_MAX, .m = m};
    vxs_result r;
    *bytes      = NULL;
    *size_bytes = 0;
    if (limit_bytes >= SIZE_MAX - 1) limit_bytes = SIZE_MAX - 2;
    if (m->access)
        r = read_from_caller(&in, limit_bytes, head);
    else if ((in.descriptor = input_open(path)) < 0)
        r = fail(m, errno == ENOMEM ? VXS_E_MEMORY : VXS_E_READ, "cannot read '%s': %s", in.name, strerror(errno));
    else {
        struct stat status;
        if (!fstat(in.descriptor, &status) && S_ISREG(status.st_mode) && status.st_size > 0)
            in.known_bytes = (size_t)status.st_size;
        r = read_all(&in, limit_bytes, head);
        close(in.descriptor);
    }
    if (r != VXS_OK) {
        free(in.bytes);
        return r;
    }
    *bytes      = in.bytes;
    *size_bytes = in.size_bytes;
    return VXS_OK;
}
