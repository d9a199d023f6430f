/* Changes to a GLB that leave it one: its JSON, a number in it, or its binary chunk are changed, and the lengths made to fit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <ctype.h>
#include <string.h>

#include "fuzz.h"

enum { HEADER_BYTES = 20, CHUNK_BYTES = 8 };

static uint32_t u32_at(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void put_u32(uint8_t *at, size_t value)
{
    for (int i = 0; i < 4; i++) at[i] = (uint8_t)(value >> 8 * i);
}

/* Another number in place of one of the JSON's: near it, at an edge, or any. Returns the new size. */
static size_t change_number(uint8_t *json, size_t size, size_t size_max, unsigned int seed)
{
    static const char *const edges[] = {"0",     "-1",     "1",    "2147483647", "4294967295", "9007199254740991",
                                        "1e308", "1e-300", "null", "[]"};
    size_t                   at      = size ? seed % size : 0;
    for (size_t n = 0; n < size && !isdigit(json[at]); n++) at = (at + 1) % size;
    size_t end = at;
    while (end < size && isdigit(json[end])) end++;
    if (end == at || end - at > 9) return size;

    char         text[32]   = "";
    char         digits[16] = "";
    unsigned int kind       = seed >> 16 & 15;
    memcpy(digits, json + at, end - at);
    long value = strtol(digits, NULL, 10);
    if (kind < 10)
        snprintf(text, sizeof text, "%s", edges[kind]);
    else
        snprintf(text, sizeof text, "%ld",
                 kind == 10   ? value + 1
                 : kind == 11 ? value - 1
                 : kind == 12 ? 2 * value
                              : (long)(seed >> 20));
    size_t length = strlen(text);
    if (size - (end - at) + length > size_max) return size;
    memmove(json + at + length, json + end, size - end);
    memcpy(json + at, text, length);
    return size - (end - at) + length;
}

/* Room for either part is what the other leaves, with three bytes of padding each. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned int seed)
{
    size_t json_size = size >= HEADER_BYTES ? u32_at(data + 12) : 0, bin_size = 0;
    if (size < HEADER_BYTES || memcmp(data, "glTF", 4) || json_size > size - HEADER_BYTES || seed % 16 == 0)
        return LLVMFuzzerMutate(data, size, size_max);
    if (size - HEADER_BYTES - json_size >= CHUNK_BYTES) bin_size = size - HEADER_BYTES - json_size - CHUNK_BYTES;
    size_t fixed = HEADER_BYTES + CHUNK_BYTES + 6;
    if (fixed + json_size + bin_size >= size_max) return LLVMFuzzerMutate(data, size, size_max);

    size_t   room = size_max - fixed;
    uint8_t *json = malloc(room + 3), *bin = malloc(room + 3);
    FUZZ_CHECK(json && bin);
    memcpy(json, data + HEADER_BYTES, json_size);
    memcpy(bin, data + size - bin_size, bin_size);
    if (bin_size && seed % 16 < 6)
        bin_size = LLVMFuzzerMutate(bin, bin_size, room - json_size);
    else if (seed % 16 < 12)
        json_size = change_number(json, json_size, room - bin_size, seed >> 4);
    else
        json_size = LLVMFuzzerMutate(json, json_size, room - bin_size);

    while (json_size % 4) json[json_size++] = ' ';
    while (bin_size % 4) bin[bin_size++] = 0;
    memcpy(data, "glTF\2\0\0", 8);
    put_u32(data + 8, HEADER_BYTES + json_size + (bin_size ? CHUNK_BYTES + bin_size : 0));
    put_u32(data + 12, json_size);
    put_u32(data + 16, 0x4e4f534a);
    memcpy(data + HEADER_BYTES, json, json_size);
    uint8_t *chunk = data + HEADER_BYTES + json_size;
    if (bin_size) {
        put_u32(chunk, bin_size);
        put_u32(chunk + 4, 0x004e4942);
        memcpy(chunk + CHUNK_BYTES, bin, bin_size);
    }
    free(json);
    free(bin);
    return (size_t)(chunk - data) + (bin_size ? CHUNK_BYTES + bin_size : 0);
}
