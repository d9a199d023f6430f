/* A table for people; see text_table.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/text_table.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"

void text_table_add(text_table *t, const char *format, ...)
{
    if (t->no_memory) return;
    char  **grown = realloc(t->cells, (t->count + 1) * sizeof *grown);
    char   *text  = NULL;
    va_list args;
    if (grown) t->cells = grown;
    va_start(args, format);
    if (!grown || vasprintf(&text, format, args) < 0)
        t->no_memory = 1;
    else
        t->cells[t->count++] = one_line(text);
    va_end(args);
}

/* [columns] or NULL without memory; released with free() */
static int *widths_of(const text_table *t)
{
    int *widths = calloc(t->columns, sizeof *widths);
    for (size_t n = 0; widths && n < t->count; n++) {
        int length = (int)strlen(t->cells[n]), *width = &widths[n % t->columns];
        if (*width < length) *width = length;
    }
    return widths;
}

int text_table_print(text_table *t, FILE *to)
{
    int *widths   = t->no_memory ? NULL : widths_of(t);
    int  complete = widths != NULL;
    for (size_t n = 0; n < t->count && complete; n++) {
        size_t column = n % t->columns;
        fprintf(to, "%s%*s%s", column ? "  " : "", column ? widths[column] : -widths[column], t->cells[n],
                column + 1 == t->columns ? "\n" : "");
    }
    for (size_t n = 0; n < t->count; n++) free(t->cells[n]);
    free(t->cells);
    free(widths);
    *t = (text_table){.columns = t->columns};
    return complete;
}
