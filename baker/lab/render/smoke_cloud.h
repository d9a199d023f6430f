/* Smoke as the eye sees it: capsules from back to front, each by a quad that covers it, facing the eye, and as dense as the ray's length
 * in it. Light is looked up at four places of each quad, and interpolated between them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_CLOUD_H
#define SMOKE_CLOUD_H

#include "baker/base/message.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/smoke.h"

/* Layout as in smoke_quads.glsl. Positions are in metres relative to the eye. */
typedef struct drawn_capsule {
    vxs_capsule capsule;
    float       albedo[4];
} drawn_capsule;

enum { SMOKE_CORNERS = 4 };

typedef struct smoke_quads {
    uint32_t       count;
    drawn_capsule *capsules;       /* [count] */
    float (*corners)[4];           /* [4 * count] of quads, in the order of a strip; the fourth number is unused, as in places */
    float (*places)[4];            /* [4 * count] places of light lookups, between a capsule's middle and the corners */
    struct quad_order *order;      /* [count] */
    double             covered_px; /* about how many samples of the picture quads cover; each quad at most all of the picture */
} smoke_quads;

/* The view of the quads. */
typedef struct smoke_eye {
    double      at_ws[3];
    camera_view seen;
    double      pixel_metres; /* width of a sample at 1 m; no capsule is drawn thinner */
    double      all_px;       /* samples of the picture */
} smoke_eye;

/* Allocate room for the capsules of a scene.   q  [out]   Returns VXS_OK, VXS_E_MEMORY. */
vxs_result smoke_quads_reserve(smoke_quads *q, const scene_smoke *smoke, message *m);
void       smoke_quads_free(smoke_quads *q);

/* The quad of a capsule that contains the eye, or nearly, covers the whole picture. */
void smoke_quads_make(smoke_quads *q, const scene_smoke *smoke, const smoke_eye *eye);

#endif
