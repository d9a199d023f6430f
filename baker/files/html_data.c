/* Data inside the script elements of an HTML page; see html_data.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/html_data.h"

void base64_encode(char *text, const uint8_t *bytes, size_t size_bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t n = 0; n < size_bytes; n += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; k++) bits = bits << 8 | (n + k < size_bytes ? bytes[n + k] : 0);
        for (size_t k = 0; k < 4; k++) *text++ = n + k > size_bytes ? '=' : digits[bits >> (18 - 6 * k) & 63];
    }
}

void base64_print(FILE *to, const uint8_t *bytes, size_t size_bytes)
{
    enum { PIECE_BYTES = 3 * 1024 }; /* a multiple of 3, so that only the last piece is padded */
    char text[PIECE_BYTES / 3 * 4];
    for (size_t at = 0; at < size_bytes; at += PIECE_BYTES) {
        size_t count = size_bytes - at < PIECE_BYTES ? size_bytes - at : PIECE_BYTES;
        base64_encode(text, bytes + at, count);
        fwrite(text, 1, base64_length(count), to);
    }
}

void html_print_json(FILE *to, const char *json)
{
    for (const char *at = json; *at; at++)
        if (*at == '<')
            fputs("\\u003c", to);
        else
            fputc(*at, to);
}
