/* Suggestion for a mistyped word; see nearest.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/nearest.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* Equal except for case. */
static int same(char a, char b)
{
    return tolower((unsigned char)a) == tolower((unsigned char)b);
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Damerau's edit distance, where each letter takes part in at most one swap (optimal string alignment). Row i holds the distances
 * of the first i letters of a to the prefixes of b. Three rows are enough. */
static int distance(const char *a, size_t a_length, const char *b, size_t b_length)
{
    int rows[3][NEAREST_LENGTH_MAX + 1];
    for (size_t j = 0; j <= b_length; j++) rows[0][j] = (int)j;
    for (size_t i = 1; i <= a_length; i++) {
        int       *row   = rows[i % 3];
        const int *above = rows[(i + 2) % 3], *above_that = rows[(i + 1) % 3];
        row[0] = (int)i;
        for (size_t j = 1; j <= b_length; j++) {
            row[j] = least(least(above[j], row[j - 1]) + 1, above[j - 1] + !same(a[i - 1], b[j - 1]));
            if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
                row[j] = least(row[j], above_that[j - 2] + 1);
        }
    }
    return rows[a_length % 3][b_length];
}

void nearest_try(nearest *n, const char *word, size_t length)
{
    size_t typed_length = strlen(n->typed), longer = typed_length > length ? typed_length : length;
    if (longer > NEAREST_LENGTH_MAX) return;
    int d = distance(n->typed, typed_length, word, length);
    if (d > least((int)longer / 3, 3) || (n->word && d >= n->distance)) return;
    n->word     = word;
    n->length   = length;
    n->distance = d;
}

void nearest_try_choices(nearest *n, const char *choices)
{
    for (;; choices++) {
        size_t length = strcspn(choices, "|");
        nearest_try(n, choices, length);
        if (!*(choices += length)) return;
    }
}

const char *nearest_text(char text[64], const nearest *n)
{
    text[0] = '\0';
    if (n->word) snprintf(text, 64, ": did you mean '%.*s'?", (int)n->length, n->word);
    return text;
}
