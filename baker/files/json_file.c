/* Write JSON files and read them; see json_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/json_file.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "baker/files/input_file.h"
#include "baker/files/output_file.h"

enum { READ_MAX_MIB = 256 };

static atomic_int memory_failed;

static void *watched_alloc(size_t size)
{
    void *memory = malloc(size);
    if (!memory) atomic_store(&memory_failed, 1);
    return memory;
}

void json_watch_memory(void)
{
    json_set_alloc_funcs(watched_alloc, free);
}

int json_memory_missing(void)
{
    return atomic_load(&memory_failed);
}

char *json_print(const json_t *value, size_t flags)
{
    char *text = json_whole_text(value, flags);
    if (!json_memory_missing()) return text;
    free(text);
    return NULL;
}

vxs_result json_write_opened(output_file *out, json_t *value, int digits, run_context *m)
{
    char      *text = value ? json_print(value, JSON_INDENT(2) | JSON_REAL_PRECISION(digits)) : NULL;
    vxs_result r    = text ? output_file_write(out, text, strlen(text), m) : fail(m, VXS_E_MEMORY, "out of memory for JSON");
    if (r == VXS_OK) r = output_file_write(out, "\n", 1, m);
    if (r == VXS_OK) r = output_file_commit(out, m);
    output_file_abort(out);
    free(text);
    json_decref(value);
    return r;
}

vxs_result json_write(const char *path, json_t *value, run_context *m)
{
    output_file out = {0};
    vxs_result  r   = output_file_open(&out, path, m);
    if (r == VXS_OK) return json_write_opened(&out, value, 9, m);
    json_decref(value);
    return r;
}

/* Input for jansson, which reads it in pieces: the size of a pipe is not known in advance. */
typedef struct json_input {
    int    descriptor, error;
    size_t bytes_left;
} json_input;

static size_t read_piece(void *buffer, size_t size, void *user)
{
    json_input *in = user;
    ssize_t     n;
    do n = read(in->descriptor, buffer, size < in->bytes_left ? size : in->bytes_left);
    while (n < 0 && errno == EINTR);
    if (n < 0) in->error = errno;
    if (n < 0) return (size_t)-1;
    in->bytes_left -= (size_t)n;
    return (size_t)n;
}

vxs_result json_read(json_t **value, const char *path, run_context *m)
{
    json_input   in = {.descriptor = input_open(path), .bytes_left = (size_t)READ_MAX_MIB << 20};
    json_error_t e;
    vxs_result   r = VXS_OK;
    path           = input_name(path);
    in.error       = in.descriptor < 0 ? errno : 0;
    *value         = in.error ? NULL : json_load_callback(read_piece, &in, JSON_REJECT_DUPLICATES, &e);
    if (in.error == ENOMEM || json_memory_missing())
        r = fail(m, VXS_E_MEMORY, "out of memory while reading %s", path);
    else if (in.error == EISDIR)
        r = fail(m, VXS_E_READ, "%s: cannot read: it is a folder, expected a file name", path);
    else if (in.error)
        r = fail(m, VXS_E_READ, "%s: cannot read: %s", path, strerror(in.error));
    else if (!in.bytes_left)
        r = fail(m, VXS_E_READ, "%s: larger than %d MiB, which no JSON of vxs is", path, READ_MAX_MIB);
    else if (!*value)
        r = fail(m, VXS_E_READ, "%s: not JSON: line %d: %s", path, e.line, e.text);
    if (r != VXS_OK) json_decref(*value);
    if (r != VXS_OK) *value = NULL;
    if (in.descriptor >= 0) close(in.descriptor);
    return r;
}
