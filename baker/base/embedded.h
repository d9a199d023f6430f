/* Files that the Makefile embeds in the program, unchanged.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EMBEDDED_H
#define EMBEDDED_H

#include <stddef.h>
#include <stdio.h>

/* The bytes [begin, end). */
typedef struct embedded {
    const char *begin, *end;
} embedded;

/* Declares an embedded file: page_html is page.html. */
#define EMBEDDED(name)                                                                                                             \
    extern const char     name##_begin[] __asm__("_binary_" #name "_start"), name##_end[] __asm__("_binary_" #name "_end");        \
    static const embedded name = {name##_begin, name##_end};

static inline void embedded_print(FILE *to, embedded text)
{
    fwrite(text.begin, 1, (size_t)(text.end - text.begin), to);
}

#endif
