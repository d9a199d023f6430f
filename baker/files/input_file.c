/* Input files; see input_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/base/text.h"

enum { READ_AT_FIRST = 65536, LOOKED_AT = 1024 };

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

int is_read_once(const char *path)
{
    struct stat status;
    return is_standard_input(path) || (!stat(path, &status) && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode));
}

/* Bytes that a file is known to have; 0: a pipe. */
static size_t known_bytes(int descriptor)
{
    struct stat status;
    return !fstat(descriptor, &status) && S_ISREG(status.st_mode) && status.st_size > 0 ? (size_t)status.st_size : 0;
}

/* Room is made for what is known to come and for a byte more, which shows that no more does; or for twice as much as there is. What is looked at
 * first has its room alone. */
static vxs_result read_all(int descriptor, uint8_t **bytes, size_t *size_bytes, uint64_t limit_bytes, input_look *look)
{
    size_t known = known_bytes(descriptor), room = 0;
    for (;;) {
        if (*size_bytes > limit_bytes || (known > limit_bytes && !look)) return VXS_E_UNSUPPORTED;
        if (*size_bytes == room) {
            room = room ? 2 * room : known && !look ? known + 1 : READ_AT_FIRST;
            if (known > room && !look) room = known + 1;
            if (room > limit_bytes) room = (size_t)limit_bytes + 1;
            void *larger = realloc(*bytes, room);
            if (!larger) return VXS_E_MEMORY;
            *bytes = larger;
        }
        ssize_t n = read(descriptor, *bytes + *size_bytes, room - *size_bytes);
        if (n < 0 && errno != EINTR) return VXS_E_READ;
        if (n > 0) *size_bytes += (size_t)n;
        if (look && (n == 0 || *size_bytes >= LOOKED_AT)) {
            if (!look(*bytes, *size_bytes)) return VXS_OK;
            look = NULL;
        }
        if (n == 0) return VXS_OK;
    }
}

vxs_result input_read(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, message *m)
{
    return input_read_if(bytes, size_bytes, path, limit_bytes, NULL, m);
}

vxs_result input_read_if(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, input_look *look, message *m)
{
    char size[32];
    int  descriptor = input_open(path);
    *bytes          = NULL;
    *size_bytes     = 0;
    vxs_result r    = descriptor < 0 ? VXS_E_READ : read_all(descriptor, bytes, size_bytes, limit_bytes, look);
    if (r == VXS_E_READ && errno == ENOMEM) r = VXS_E_MEMORY;
    if (r == VXS_E_READ) fail(m, r, "cannot read '%s': %s", input_name(path), strerror(errno));
    if (r == VXS_E_UNSUPPORTED) {
        r = VXS_E_MEMORY;
        fail(m, r, "'%s' is larger than %s, the most that is read", input_name(path), size_text(size, limit_bytes));
    }
    if (r == VXS_E_MEMORY) fail(m, r, "out of memory while reading '%s'", input_name(path));
    if (descriptor >= 0) close(descriptor);
    if (r == VXS_OK) return r;
    free(*bytes);
    *bytes = NULL;
    return r;
}
