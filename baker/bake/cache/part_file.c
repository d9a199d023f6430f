/* Parts of bakes; see part_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/cache/part_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "baker/bake/cache/cache_folder.h"
#include "baker/base/byte_stream.h"
#include "baker/files/input_file.h"

static const char end_magic[8] = {'v', 'x', 's', ' ', 'p', 'a', 'r', 't'};

enum { MAGIC_BYTES = sizeof PART_MAGIC - 1, PART_VERSION = 1, HEAD_BYTES = 24, SQUARE_BYTES = 24, TRAILER_BYTES = 40 };

/* Limit of data that is read as a whole: a pipe, and the common data. */
static const uint64_t LIMIT_BYTES = (uint64_t)4 << 30;

static vxs_result out_of_memory(run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory for the part of a bake");
}

static int put_head(vxs_bytes *out, uint32_t number, uint32_t parts)
{
    return put_bytes(out, PART_MAGIC, MAGIC_BYTES) && put32s(out, (uint32_t[]){PART_VERSION, number, parts, 0}, 4);
}

static vxs_result note_square(part_squares *list, const part_square *s, run_context *m)
{
    if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items)) return out_of_memory(m);
    list->items[list->count++] = *s;
    return VXS_OK;
}

/* writing --------------------------------------------------------------------------------------------------------------------- */

/* Write the bytes, and empty them. */
static vxs_result flush(part_writer *w, vxs_bytes *bytes, run_context *m)
{
    vxs_result r = output_file_write(&w->out, bytes->data, bytes->size_bytes, m);
    w->at += bytes->size_bytes;
    bytes->size_bytes = 0;
    return r;
}

vxs_result part_begin(part_writer *w, const char *path, uint32_t number, uint32_t parts, run_context *m)
{
    vxs_bytes head = {0};
    *w             = (part_writer){.number = number, .parts = parts};
    vxs_result r   = output_file_open(&w->out, path, m);
    if (r == VXS_OK) r = put_head(&head, number, parts) ? flush(w, &head, m) : out_of_memory(m);
    free(head.data);
    return r;
}

vxs_result part_add(part_writer *w, uint64_t square, const column_key *key, const vxs_bytes *record, run_context *m)
{
    vxs_bytes  bytes = {0};
    vxs_result r     = square_file_write(key, record, &bytes) == VXS_OK ? VXS_OK : out_of_memory(m);
    if (r == VXS_OK) r = note_square(&w->squares, &(part_square){square, w->at, bytes.size_bytes}, m);
    if (r == VXS_OK) r = flush(w, &bytes, m);
    free(bytes.data);
    return r;
}

/* Hash over what part_open checks: the head, and all that follows the squares. */
static uint64_t hash_of(const vxs_bytes *head, const uint8_t *rest, size_t size_bytes)
{
    return XXH64(rest, size_bytes, XXH64(head->data, head->size_bytes, 0));
}

vxs_result part_end(part_writer *w, const vxs_bytes *common, run_context *m)
{
    vxs_bytes rest = {0}, head = {0};
    int       ok = put_head(&head, w->number, w->parts) && put_bytes(&rest, common->data, common->size_bytes);
    for (const part_square *s = w->squares.items; s < w->squares.items + w->squares.count && ok; s++)
        ok = put64(&rest, s->number) && put64(&rest, s->at) && put64(&rest, s->size_bytes);
    ok           = ok && put64(&rest, w->at) && put64(&rest, common->size_bytes) && put64(&rest, w->squares.count);
    ok           = ok && put64(&rest, hash_of(&head, rest.data, rest.size_bytes)) && put_bytes(&rest, end_magic, sizeof end_magic);
    vxs_result r = ok ? flush(w, &rest, m) : out_of_memory(m);
    free(rest.data);
    free(head.data);
    return r == VXS_OK ? output_file_commit(&w->out, m) : r;
}

void part_abort(part_writer *w)
{
    output_file_abort(&w->out);
    free(w->squares.items);
    *w = (part_writer){.number = 0};
}

/* reading --------------------------------------------------------------------------------------------------------------------- */

vxs_result part_is_damaged(const part_reader *p, run_context *m)
{
    return fail(m, VXS_E_CORRUPT, "'%s' is a part of a bake, and damaged: make it again", input_name(p->path));
}

static vxs_result cannot_read(const part_reader *p, run_context *m)
{
    return fail(m, VXS_E_READ, "cannot read '%s': %s", input_name(p->path), strerror(errno));
}

/* Read bytes of the file.   out  [out] zero it first, released with free(out->data) */
static vxs_result read_at(const part_reader *p, uint64_t at, uint64_t size_bytes, vxs_bytes *out, run_context *m)
{
    if (at > p->size_bytes || size_bytes > p->size_bytes - at || size_bytes > LIMIT_BYTES) return part_is_damaged(p, m);
    if (!array_reserve(&out->data, &out->capacity_bytes, size_bytes + 1, 1)) return out_of_memory(m);
    out->size_bytes = size_bytes;
    if (p->file < 0) memcpy(out->data, p->whole.data + at, size_bytes);
    for (uint64_t have = 0; p->file >= 0 && have < size_bytes;) {
        ssize_t n = pread(p->file, out->data + have, size_bytes - have, (off_t)(at + have));
        if (n < 0 && errno != EINTR) return cannot_read(p, m);
        if (n == 0) return part_is_damaged(p, m); /* the file has become shorter */
        if (n > 0) have += (uint64_t)n;
    }
    return VXS_OK;
}

static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    (void)user;
    return size_bytes >= MAGIC_BYTES && !memcmp(first, PART_MAGIC, MAGIC_BYTES) ? UINT64_MAX : 0;
}

/* Open a regular file; read anything else into memory as a whole. */
static vxs_result open_source(part_reader *p, run_context *m)
{
    struct stat status;
    p->file = is_standard_input(p->path) ? -1 : input_open(p->path);
    if (p->file < 0 && !is_standard_input(p->path)) return cannot_read(p, m);
    if (p->file >= 0 && !fstat(p->file, &status) && S_ISREG(status.st_mode)) {
        p->size_bytes = (uint64_t)status.st_size;
        return VXS_OK;
    }
    if (p->file >= 0) close(p->file);
    p->file       = -1;
    vxs_result r  = input_read(&p->whole.data, &p->whole.size_bytes, p->path, LIMIT_BYTES, &(input_head){wanted_bytes, NULL}, m);
    p->size_bytes = p->whole.size_bytes;
    return r;
}

static vxs_result read_head(part_reader *p, vxs_bytes *head, run_context *m)
{
    vxs_result r = p->size_bytes < HEAD_BYTES ? VXS_E_NOT_VXS : read_at(p, 0, HEAD_BYTES, head, m);
    if (r == VXS_OK && memcmp(head->data, PART_MAGIC, MAGIC_BYTES) != 0) r = VXS_E_NOT_VXS;
    if (r == VXS_E_NOT_VXS)
        return fail(m, r, "'%s' is no part of a bake: expected what vxs bake --part wrote", input_name(p->path));
    if (r != VXS_OK) return r;
    byte_reader from    = {head->data + MAGIC_BYTES, HEAD_BYTES - MAGIC_BYTES};
    uint32_t    version = take32(&from);
    p->number           = take32(&from);
    p->parts            = take32(&from);
    if (version != PART_VERSION)
        return fail(m, VXS_E_VERSION, "'%s' is a part of a bake by another version of vxs", input_name(p->path));
    return p->number >= 1 && p->number <= p->parts && p->parts <= PARTS_MAX ? VXS_OK : part_is_damaged(p, m);
}

static vxs_result read_rest(part_reader *p, const vxs_bytes *head, vxs_bytes *trailer, vxs_bytes *rest, run_context *m)
{
    vxs_result r = p->size_bytes < HEAD_BYTES + TRAILER_BYTES
                       ? part_is_damaged(p, m)
                       : read_at(p, p->size_bytes - TRAILER_BYTES, TRAILER_BYTES, trailer, m);
    if (r != VXS_OK) return r;
    byte_reader from  = {trailer->data, TRAILER_BYTES};
    uint64_t    begin = take64(&from), common = take64(&from), count = take64(&from), hash = take64(&from);
    if (memcmp(from.at, end_magic, sizeof end_magic) != 0 || begin < HEAD_BYTES || begin > p->size_bytes)
        return part_is_damaged(p, m);
    uint64_t size = p->size_bytes - begin, lists = TRAILER_BYTES;
    if (size < lists || count > (size - lists) / SQUARE_BYTES || size - lists - count * SQUARE_BYTES != common)
        return part_is_damaged(p, m);
    if ((r = read_at(p, begin, size - 16, rest, m)) != VXS_OK) return r;
    if (hash_of(head, rest->data, rest->size_bytes) != hash) return part_is_damaged(p, m);
    if (!put_bytes(&p->common, rest->data, common)) return out_of_memory(m);
    byte_reader squares = {rest->data + common, count * SQUARE_BYTES};

    /* numbers ascend, and squares are contiguous */
    uint64_t at = HEAD_BYTES;
    r           = VXS_OK;
    for (uint64_t n = 0; n < count && r == VXS_OK; n++) {
        part_square s = {.number = take64(&squares)};
        s.at          = take64(&squares);
        s.size_bytes  = take64(&squares);
        if (s.at != at || s.size_bytes > begin - at || (n && s.number <= p->squares.items[n - 1].number))
            return part_is_damaged(p, m);
        at += s.size_bytes;
        r = note_square(&p->squares, &s, m);
    }
    return r == VXS_OK && at != begin ? part_is_damaged(p, m) : r;
}

vxs_result part_open(part_reader *p, const char *path, run_context *m)
{
    vxs_bytes head = {0}, trailer = {0}, rest = {0};
    *p           = (part_reader){.path = path, .file = -1};
    vxs_result r = open_source(p, m);
    if (r == VXS_OK) r = read_head(p, &head, m);
    if (r == VXS_OK) r = read_rest(p, &head, &trailer, &rest, m);
    free(head.data);
    free(trailer.data);
    free(rest.data);
    return r;
}

static int by_number(const void *a, const void *b)
{
    const part_square *x = a, *y = b;
    return (x->number > y->number) - (x->number < y->number);
}

const part_square *part_find(const part_reader *p, uint64_t number)
{
    const part_square wanted = {.number = number};
    if (!p->squares.count) return NULL;
    return bsearch(&wanted, p->squares.items, p->squares.count, sizeof wanted, by_number);
}

vxs_result part_read(const part_reader *p, const part_square *s, const column_key *key, vxs_bytes *record, run_context *m)
{
    *record      = (vxs_bytes){0};
    vxs_result r = read_at(p, s->at, s->size_bytes, record, m);
    if (r == VXS_OK && square_file_read(record, key) != VXS_OK) r = part_is_damaged(p, m);
    if (r == VXS_OK) return r;
    free(record->data);
    *record = (vxs_bytes){0};
    return r;
}

void part_close(part_reader *p)
{
    if (p->file >= 0) close(p->file);
    free(p->whole.data);
    free(p->common.data);
    free(p->squares.items);
    *p = (part_reader){.file = -1};
}
