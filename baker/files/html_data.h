/* Data inside the script elements of an HTML page: JSON, and bytes as base64.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HTML_DATA_H
#define HTML_DATA_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Characters of the base64 text of size_bytes bytes, without a final zero. */
static inline size_t base64_length(size_t size_bytes)
{
    return (size_bytes + 2) / 3 * 4;
}

/* Encode bytes (RFC 4648, padded).   text  [base64_length(size_bytes)] out, without a final zero */
void base64_encode(char *text, const uint8_t *bytes, size_t size_bytes);

/* Print the base64 text of bytes. The caller checks the stream's error flag. */
void base64_print(FILE *to, const uint8_t *bytes, size_t size_bytes);

/* Print JSON text with each '<' as \u003c, so that it cannot end a script element. In valid JSON '<' is found only in strings. */
void html_print_json(FILE *to, const char *json);

#endif
