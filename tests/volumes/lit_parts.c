/* Lists of lit parts; see lit_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/lit_parts.h"
#include "baker/base/spread.h"

#include <stdlib.h>

static void *grown(void *array, size_t count, size_t *room, size_t size)
{
    if (count < *room) return array;
    *room = 2 * count + 16;
    array = realloc(array, *room * size);
    if (!array) abort();
    return array;
}

void lit_parts_clear(lit_parts *parts)
{
    parts->count = 0;
}

void lit_parts_free(lit_parts *parts)
{
    free(parts->at);
    *parts = (lit_parts){0};
}

void lit_parts_add(lit_parts *parts, double begin, double end)
{
    if (!(end > begin)) return;
    if (parts->count && parts->at[parts->count - 1].end >= begin) {
        parts->at[parts->count - 1].end = end;
        return;
    }
    parts->at                 = grown(parts->at, parts->count, &parts->room, sizeof *parts->at);
    parts->at[parts->count++] = (lit_part){begin, end};
}

double lit_parts_length(const lit_parts *parts)
{
    double sum = 0;
    for (size_t n = 0; n < parts->count; n++) sum += parts->at[n].end - parts->at[n].begin;
    return sum;
}

void places_add(places *p, double x)
{
    p->at             = grown(p->at, p->count, &p->room, sizeof *p->at);
    p->at[p->count++] = x;
}

void places_sort(places *p)
{
    if (p->count) qsort(p->at, p->count, sizeof *p->at, doubles_ascending);
}

void places_free(places *p)
{
    free(p->at);
    *p = (places){0};
}
