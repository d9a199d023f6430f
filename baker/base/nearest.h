/* The word that was probably meant.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef NEAREST_H
#define NEAREST_H

#include <stddef.h>

/* Longer words are not compared. */
enum { NEAREST_LENGTH_MAX = 32 };

/* Candidates are tried one by one; zeroed but for `typed` before the first. */
typedef struct nearest {
    const char *typed;
    const char *word; /* NULL, or the best so far, [length], not terminated: of those equally near, the one tried first */
    size_t      length;
    int         distance;
} nearest;

/* A candidate counts when not more than a third of the longer word's letters, and 3 at most, are other ones, missing, too many, or changed
 * places with their neighbours. Case does not matter. */
void nearest_try(nearest *n, const char *word, size_t length);

/* The same for all words of "auto|on|off". */
void nearest_try_choices(nearest *n, const char *choices);

/* ": did you mean 'bake'?" into text, or nothing. Returns text. */
const char *nearest_text(char text[64], const nearest *n);

#endif
