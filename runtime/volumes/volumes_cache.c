/* Program binaries in the caller's cache; see vxs_program_cache. A value is a head and what glGetProgramBinary returned. Drivers
 * may crash on bytes that are not theirs, so they get only what has the key, the size and the hash of its head.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "volumes_state.h"

typedef struct binary_head {
    program_key key; /* the version of this struct is in it: see vxs_volumes_cache_begin */
    uint64_t    hash;
    uint32_t    size_bytes, format; /* of the bytes that follow */
} binary_head;

enum { BINARY_BYTES_MOST = 1 << 28 };

static const program_key first_key = {{0xCBF29CE484222325ULL, 0x9E3779B97F4A7C15ULL}};

/* Two hashes: FNV-1a, and one that rotates. */
void vxs_volumes_key_add(program_key *key, const void *data, size_t size_bytes)
{
    const unsigned char *bytes = data;
    uint64_t             a = key->words[0], b = key->words[1];
    for (size_t n = 0; n < size_bytes; n++) {
        a = (a ^ bytes[n]) * 0x100000001B3ULL;
        b = ((b << 23 | b >> 41) ^ bytes[n]) * 0xD6E8FEB86659FD93ULL;
    }
    *key = (program_key){{a, b}};
}

static uint64_t hash_of(const void *data, size_t size_bytes)
{
    program_key key = first_key;
    vxs_volumes_key_add(&key, data, size_bytes);
    return key.words[0];
}

void vxs_volumes_cache_begin(vxs_volumes *v, const vxs_program_cache *cache)
{
    static const gl_enum names[] = {GL_NAME_VENDOR, GL_NAME_RENDERER, GL_NAME_VERSION};
    int                  count   = 0;
    if (!cache) return;
    v->api.GetIntegerv(GL_BINARY_FORMAT_COUNT, &count);
    if (count < 1 || count > BINARY_FORMATS_MOST) return;
    v->api.GetIntegerv(GL_BINARY_FORMATS, v->binary_formats);
    v->binary_format_count = (uint32_t)count;
    v->cache               = *cache;
    v->driver              = first_key;
    vxs_volumes_key_add(&v->driver, "vxs binary 1", 12);
    for (int n = 0; n < 3; n++) {
        const char *text = (const char *)v->api.GetString(names[n]);
        if (text) vxs_volumes_key_add(&v->driver, text, strlen(text) + 1);
    }
}

/* 32 digits and an end. */
static const char *name_of(const program_key *key, char name[33])
{
    for (int n = 0; n < 4; n++) snprintf(name + 8 * n, 9, "%08x", (unsigned)(key->words[n / 2] >> (n % 2 ? 0 : 32)));
    return name;
}

static int is_format(const vxs_volumes *v, uint32_t format)
{
    for (uint32_t n = 0; n < v->binary_format_count; n++)
        if ((uint32_t)v->binary_formats[n] == format) return 1;
    return 0;
}

/* The program of a value.   Returns 0 if the value is damaged or the driver refuses it */
static gl_name restore(const vxs_volumes *v, const program_key *key, const unsigned char *value, size_t size_bytes)
{
    binary_head head;
    int         good = 0;
    memcpy(&head, value, sizeof head);
    if (memcmp(&head.key, key, sizeof *key) || head.size_bytes != size_bytes - sizeof head || !is_format(v, head.format)) return 0;
    if (head.hash != hash_of(value + sizeof head, head.size_bytes)) return 0;
    gl_name program = v->api.CreateProgram();
    v->api.ProgramBinary(program, head.format, value + sizeof head, (int)head.size_bytes);
    v->api.GetProgramiv(program, GL_STATUS_LINK, &good);
    if (good) return program;
    v->api.DeleteProgram(program);
    return 0;
}

gl_name vxs_volumes_cache_get(const vxs_volumes *v, const program_key *key)
{
    char    name[33];
    gl_name program = 0;
    if (!v->cache.get) return 0;
    size_t size = v->cache.get(name_of(key, name), NULL, 0, v->cache.user);
    if (size <= sizeof(binary_head) || size > BINARY_BYTES_MOST) return 0;
    void *value = vxs_volumes_alloc(v, size);
    if (!value) return 0;
    if (v->cache.get(name, value, size, v->cache.user) == size) program = restore(v, key, value, size);
    vxs_volumes_free(v, value, size);
    return program;
}

void vxs_volumes_cache_put(const vxs_volumes *v, const program_key *key, gl_name program)
{
    char name[33];
    int  length = 0, written = 0;
    if (!v->cache.put) return;
    v->api.GetProgramiv(program, GL_BINARY_LENGTH, &length);
    if (length < 1 || length > BINARY_BYTES_MOST - (int)sizeof(binary_head)) return;
    size_t         room  = sizeof(binary_head) + (size_t)length;
    unsigned char *value = vxs_volumes_alloc(v, room);
    if (!value) return;
    binary_head head = {.key = *key};
    v->api.GetProgramBinary(program, length, &written, &head.format, value + sizeof head);
    if (written > 0 && written <= length) {
        head.size_bytes = (uint32_t)written;
        head.hash       = hash_of(value + sizeof head, head.size_bytes);
        memcpy(value, &head, sizeof head);
        v->cache.put(name_of(key, name), value, sizeof head + head.size_bytes, v->cache.user);
    }
    vxs_volumes_free(v, value, room);
}
