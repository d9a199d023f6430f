/* A table for people: columns as wide as what is in them, the first to the left, the others to the right.
 *
 *     text_table t = {.columns = 2};
 *     text_table_add(&t, "scene"), text_table_add(&t, "bake");
 *     ...
 *     text_table_print(&t, stdout);      // and releases it
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEXT_TABLE_H
#define TEXT_TABLE_H

#include <stddef.h>
#include <stdio.h>

typedef struct text_table {
    size_t columns;
    char **cells; /* [count] row by row; owned */
    size_t count;
    int    no_memory; /* 1: something was left out */
} text_table;

/* The next cell, in one line. */
void text_table_add(text_table *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Returns 0 when there was no memory for it: then nothing is printed. Released either way. */
int text_table_print(text_table *t, FILE *to);

#endif
