/* Square cache in a folder; see cache_folder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/cache/cache_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/base/array.h"
#include "baker/base/byte_stream.h"
#include "baker/base/memory.h"
#include "baker/base/text.h"
#include "baker/files/output_file.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

static const char magic[SQUARE_FILE_MAGIC_BYTES] = {'v', 'x', 's', ' ', 'k', 'e', 'p', 't'};
enum { SQUARE_FILE_VERSION = 1 };

vxs_result square_file_write(const column_key *key, const vxs_bytes *record, vxs_bytes *out)
{
    size_t start = out->size_bytes;
    int    ok = put_bytes(out, magic, sizeof magic) && put32(out, SQUARE_FILE_VERSION) && put32(out, 0) && put64(out, key->low) &&
             put64(out, key->high) && put64(out, record->size_bytes) && put_bytes(out, record->data, record->size_bytes);
    return ok && put64(out, XXH64(out->data + start, out->size_bytes - start, 0)) ? VXS_OK : VXS_E_MEMORY;
}

/* Whether bytes begin like a record in a file, of any square and version.   head  [SQUARE_FILE_MAGIC_BYTES] */
static int square_file_begins(const uint8_t *head)
{
    return !memcmp(head, magic, sizeof magic);
}

/* Whether a file may hold this square, by its first bytes and its size.   head  [SQUARE_FILE_HEAD_BYTES] */
static int square_file_may_be(const uint8_t *head, uint64_t file_bytes, const column_key *key)
{
    byte_reader from    = {head + sizeof magic, SQUARE_FILE_HEAD_BYTES - sizeof magic};
    uint32_t    version = take32(&from), zero = take32(&from);
    int         is_square = take64(&from) == key->low;
    is_square &= take64(&from) == key->high;
    uint64_t size = take64(&from), around = SQUARE_FILE_HEAD_BYTES + SQUARE_FILE_TRAILER_BYTES;
    return square_file_begins(head) && version == SQUARE_FILE_VERSION && !zero && is_square && file_bytes >= around &&
           size == file_bytes - around;
}

vxs_result square_file_read(vxs_bytes *bytes, const column_key *key)
{
    if (bytes->size_bytes < SQUARE_FILE_HEAD_BYTES || !square_file_may_be(bytes->data, bytes->size_bytes, key))
        return VXS_E_CORRUPT;
    size_t hashed = bytes->size_bytes - SQUARE_FILE_TRAILER_BYTES, size = hashed - SQUARE_FILE_HEAD_BYTES;
    if (vxs_load64(bytes->data + hashed) != XXH64(bytes->data, hashed, 0)) return VXS_E_CORRUPT;
    memmove(bytes->data, bytes->data + SQUARE_FILE_HEAD_BYTES, size);
    bytes->size_bytes = size;
    return VXS_OK;
}

column_key column_key_with(column_key before, const void *bytes, size_t size_bytes)
{
    XXH3_state_t state;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, &before, sizeof before);
    XXH3_128bits_update(&state, bytes, size_bytes);
    XXH128_hash_t hash = XXH3_128bits_digest(&state);
    return (column_key){hash.low64, hash.high64};
}

#define EXTENSION ".square"
enum { KEY_DIGITS = 32, NAME_BYTES = KEY_DIGITS + sizeof EXTENSION };

static void name_of(char name[NAME_BYTES], const column_key *key)
{
    snprintf(name, NAME_BYTES, "%016" PRIx64 "%016" PRIx64 EXTENSION, key->high, key->low);
}

static vxs_result out_of_memory(run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory for the squares of the cache");
}

/* A warning of the cache. */
#define WARN(s, m, ...)                                                                                                            \
    do {                                                                                                                           \
        size_t before = (m)->warning_count;                                                                                        \
        warn(m, __VA_ARGS__);                                                                                                      \
        (s)->warnings += (m)->warning_count - before;                                                                              \
    } while (0)

vxs_result cache_folder_open(cache_folder *s, const char *folder, run_context *m)
{
    *s = (cache_folder){.folder = strdup(folder), .descriptor = -1, .is_sound = 1};
    if (!s->folder) return out_of_memory(m);
    int missing = mkdir(folder, 0777) && errno != EEXIST ? errno : 0;
    if (!missing) s->descriptor = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (s->descriptor >= 0) {
        flock(s->descriptor, LOCK_SH); /* without locks, nothing is removed at the end */
        return VXS_OK;
    }
    vxs_result r = fail(m, VXS_E_WRITE, "--resume %s: the folder cannot be %s: %s", folder, missing ? "made" : "opened",
                        strerror(missing ? missing : errno));
    cache_folder_close(s);
    return r;
}

/* lookup ---------------------------------------------------------------------------------------------------------------------- */

vxs_result cache_folder_use(cache_folder *s, const column_key *key, run_context *m)
{
    if (!array_reserve(&s->used, &s->used_capacity, s->used_count + 1, sizeof *s->used)) return out_of_memory(m);
    s->used[s->used_count++] = *key;
    return VXS_OK;
}

/* Open a regular file of the folder for reading; no link, pipe or device. -1: there is none. */
static int open_regular(const cache_folder *s, const char *name, uint64_t *size_bytes)
{
    struct stat status;
    int         file = openat(s->descriptor, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return -1;
    if (!fstat(file, &status) && S_ISREG(status.st_mode)) {
        *size_bytes = (uint64_t)status.st_size;
        return file;
    }
    close(file);
    return -1;
}

/* Read exactly size_bytes. */
static int read_bytes(int file, uint8_t *to, size_t size_bytes)
{
    for (size_t at = 0; at < size_bytes;) {
        ssize_t n = read(file, to + at, size_bytes - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return 0;
        at += (size_t)n;
    }
    return 1;
}

typedef enum finding { FOUND, DAMAGED, TOO_LARGE } finding;

/* Read a square's file. Memory is allocated only after its head has shown the right key and size. */
static finding read_file(int file, uint64_t size_bytes, const column_key *key, vxs_bytes *record, const run_context *m)
{
    uint8_t head[SQUARE_FILE_HEAD_BYTES];
    if (!read_bytes(file, head, sizeof head) || !square_file_may_be(head, size_bytes, key)) return DAMAGED;
    if (size_bytes >= SIZE_MAX || !memory_allows(size_bytes, m)) return TOO_LARGE;
    *record = (vxs_bytes){malloc(size_bytes + 1), size_bytes, size_bytes + 1};
    if (!record->data) return TOO_LARGE;
    memcpy(record->data, head, sizeof head);
    if (!read_bytes(file, record->data + sizeof head, size_bytes - sizeof head)) return DAMAGED;
    return square_file_read(record, key) == VXS_OK ? FOUND : DAMAGED;
}

vxs_result cache_folder_find(cache_folder *s, const column_key *key, vxs_bytes *record, int *found, run_context *m)
{
    char     name[NAME_BYTES], text[32];
    uint64_t size = 0;
    name_of(name, key);
    *found   = 0;
    *record  = (vxs_bytes){0};
    int file = open_regular(s, name, &size);
    if (file < 0) return VXS_OK;
    finding what = read_file(file, size, key, record, m);
    close(file);
    *found = what == FOUND;
    if (*found) return cache_folder_use(s, key, m);
    free(record->data);
    *record = (vxs_bytes){0};
    if (s->is_sound && what == DAMAGED)
        WARN(s, m, "%s/%s is damaged: it is made again, as are any others of that kind", s->folder, name);
    if (s->is_sound && what == TOO_LARGE)
        WARN(s, m, "%s/%s has %s, for which there is no memory: it is made again, as are any others of that kind", s->folder, name,
             size_text(text, size));
    s->is_sound = 0;
    return run_check(m);
}

/* storing --------------------------------------------------------------------------------------------------------------------- */

/* Write a file into the folder. Anything there that is not a regular file stays. */
static vxs_result write_file(const cache_folder *s, const char *name, const vxs_bytes *bytes, run_context *m)
{
    char        path[PATH_MAX];
    struct stat there;
    output_file out = {0};
    if (snprintf(path, sizeof path, "%s/%s", s->folder, name) >= (int)sizeof path)
        return fail(m, VXS_E_WRITE, "%s: the path is too long", s->folder);
    if (!lstat(path, &there) && !S_ISREG(there.st_mode)) return fail(m, VXS_E_WRITE, "%s is no file", path);
    vxs_result r = output_file_open(&out, path, m);
    out.unsynced = 1;
    if (r == VXS_OK) r = output_file_write(&out, bytes->data, bytes->size_bytes, m);
    if (r == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    return r;
}

vxs_result cache_folder_store(cache_folder *s, const column_key *key, const vxs_bytes *record, run_context *m)
{
    char        name[NAME_BYTES];
    run_context why   = {.files = m->files, .temporary = m->temporary};
    vxs_bytes   bytes = {0};
    if (s->is_full) return VXS_OK;
    name_of(name, key);
    vxs_result r = square_file_write(key, record, &bytes);
    if (r == VXS_OK) r = write_file(s, name, &bytes, &why);
    free(bytes.data);
    run_free(&why);
    if (r == VXS_OK) return cache_folder_use(s, key, m);
    if (r == VXS_E_MEMORY) return out_of_memory(m);
    s->is_full = 1;
    WARN(s, m, "--resume %s: squares cannot be written any more, and the bake goes on without: %s", s->folder, why.error);
    return run_check(m);
}

/* removal --------------------------------------------------------------------------------------------------------------------- */

static int by_key(const void *a, const void *b)
{
    const column_key *x = a, *y = b;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return (x->low > y->low) - (x->low < y->low);
}

/* Whether it is a temporary file of a run that ended early: ".vxs-PID-N.tmp". Only called when no other run has the folder open. */
static int is_left_over(const char *name)
{
    static const char digits[] = "0123456789";
    if (strncmp(name, ".vxs-", 5) != 0) return 0;
    size_t pid = strspn(name += 5, digits), n = pid && name[pid] == '-' ? strspn(name + pid + 1, digits) : 0;
    return n && !strcmp(name + pid + 1 + n, ".tmp");
}

/* Whether the cache wrote the file and this run has not used it. Squares must also begin as a square does. */
static int is_unused(const cache_folder *s, const char *name)
{
    column_key key;
    uint64_t   size;
    uint8_t    head[SQUARE_FILE_MAGIC_BYTES];
    int        is_square = strlen(name) == NAME_BYTES - 1 && !strcmp(name + KEY_DIGITS, EXTENSION) &&
                    strspn(name, "0123456789abcdef") == KEY_DIGITS &&
                    sscanf(name, "%16" SCNx64 "%16" SCNx64, &key.high, &key.low) == 2;
    if (!is_square && !is_left_over(name)) return 0;
    if (is_square && s->used_count && bsearch(&key, s->used, s->used_count, sizeof key, by_key)) return 0;
    int file = open_regular(s, name, &size);
    int mine = file >= 0 && (!is_square || (read_bytes(file, head, sizeof head) && square_file_begins(head)));
    if (file >= 0) close(file);
    return mine;
}

void cache_folder_clean(cache_folder *s)
{
    if (s->used_count) qsort(s->used, s->used_count, sizeof *s->used, by_key);
    if (flock(s->descriptor, LOCK_EX | LOCK_NB)) return;
    int  descriptor = dup(s->descriptor);
    DIR *folder     = descriptor < 0 ? NULL : fdopendir(descriptor);
    if (!folder && descriptor >= 0) close(descriptor);
    for (struct dirent *d; folder && (d = readdir(folder));)
        if (is_unused(s, d->d_name)) unlinkat(s->descriptor, d->d_name, 0);
    if (folder) closedir(folder);
}

void cache_folder_close(cache_folder *s)
{
    if (s->folder && s->descriptor >= 0) close(s->descriptor);
    free(s->folder);
    free(s->used);
    *s = (cache_folder){0};
}
