/* Oracle T2: lit parts of a ray by a closed mesh that bounds what is lit, as light meshes are ([PLV10]): in double, with triangles
 * that meet at an edge never both hit nor both missed there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_PARTS_H
#define MESH_PARTS_H

#include "tests/volumes/lit_parts.h"

typedef struct lit_mesh lit_mesh;

/* triangles  [count], corners in metres, counter-clockwise as seen from where it is dark; corners that are one place are equal to
 * the bit.
 *            Triangles without area are allowed. Copied. Those that follow each other should be near each other.
 * NULL where memory ends */
lit_mesh *lit_mesh_create(const double (*triangles)[3][3], size_t count);
void      lit_mesh_destroy(lit_mesh *mesh);

/* A lit_oracle of a lit_mesh: lit is where as many more faces are left for the dark than are entered from it, from there on to
 * infinity. */
void mesh_parts(const void *mesh, const eye_ray *ray, lit_parts *parts);

/* That number for the ray's begin: 1 in lit space, 0 elsewhere, of a mesh that is closed. */
int mesh_winding(const lit_mesh *mesh, const eye_ray *ray);

#endif
