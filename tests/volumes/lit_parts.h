/* Which parts of an eye ray a light reaches: a list of them, and what an oracle of visibility is. There are three, kept apart: rays
 * that are traced (traced_parts.h), the texels of a shadow depth map (map_parts.h), a mesh that bounds what is lit (mesh_parts.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIT_PARTS_H
#define LIT_PARTS_H

#include <stddef.h>

typedef struct eye_ray {
    double eye[3], direction[3]; /* metres; of length 1 */
    double begin, end;           /* metres along it that are queried, 0 <= begin <= end, finite */
} eye_ray;

typedef struct lit_part {
    double begin, end; /* metres along the ray, begin < end */
} lit_part;

/* From near to far; two that touch are one. A zeroed list is empty. */
typedef struct lit_parts {
    lit_part *at;
    size_t    count, room;
} lit_parts;

/* Empty it, and keep its memory. */
void lit_parts_clear(lit_parts *parts);
void lit_parts_free(lit_parts *parts);

/* Behind all that are in it; end <= begin: nothing. Ends the program where memory ends. */
void lit_parts_add(lit_parts *parts, double begin, double end);

/* Metres in all. */
double lit_parts_length(const lit_parts *parts);

/* An oracle. Clears the list, and fills it with the parts of the ray that are lit. */
typedef void (*lit_oracle)(const void *subject, const eye_ray *ray, lit_parts *parts);

/* Doubles that grow by one; sorted when they are all there. */
typedef struct places {
    double *at;
    size_t  count, room;
} places;

void places_add(places *p, double x);
void places_sort(places *p);
void places_free(places *p);

#endif
