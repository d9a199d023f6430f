/* Small texts: sizes, choices, lists of option values.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEXT_H
#define TEXT_H

#include <stddef.h>
#include <stdint.h>

/* Values of an option that may be repeated. */
typedef struct text_list {
    const char **items; /* owned; the strings are argv's */
    size_t       count, capacity;
} text_list;

/* Make text that comes from a file fit to print, in place: control characters, which would break the line or speak to the terminal,
 * become '?'. Messages and progress lines do so themselves. Returns text. */
char *one_line(char *text);

/* "12.3 MiB" into text. Returns text. */
const char *size_text(char text[32], uint64_t bytes);

/* Word `index` of "auto|on|off" into word, cut to what fits. Returns word. */
const char *choice_word(char word[32], const char *choices, int index);

/* The index of a word of "auto|on|off", or -1. */
int choice_index(const char *choices, const char *word);

#endif
