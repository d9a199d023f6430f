/* Suggestion for a mistyped word.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef NEAREST_H
#define NEAREST_H

#include <stddef.h>

/* Longer words are not compared. */
enum { NEAREST_LENGTH_MAX = 32 };

/* Zero it and set `typed`; then call nearest_try for each candidate. */
typedef struct nearest {
    const char *typed;
    const char *word; /* best candidate so far, [length], not terminated, or NULL; of equally near ones the first */
    size_t      length;
    int         distance;
} nearest;

/* A candidate is accepted when its edit distance is at most 3, and at most a third of the longer word's length. Edits: change,
 * insert, delete, swap of neighbours. Case is ignored. */
void nearest_try(nearest *n, const char *word, size_t length);

/* The same for each word of "auto|on|off". */
void nearest_try_choices(nearest *n, const char *choices);

/* ": did you mean 'bake'?" into text, or "". Returns text. */
const char *nearest_text(char text[64], const nearest *n);

#endif
