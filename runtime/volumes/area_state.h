/* An area light; see vxs_area_light.h. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef AREA_STATE_H
#define AREA_STATE_H

#include "grid_head.h"
#include "or_scan.h"
#include "vxs_area_light.h"

enum { AREA_BITS = 128 };

/* As area.glsl has it (std430). */
typedef struct area_lamp {
    grid_head grid;
    float     place[3], radius_metres;
    float     normal[3], kind; /* AREA_ALL_SIDES and so on */
    float     colour[4];
    float     across[4];
} area_lamp;

/* How a lamp shines. */
enum { AREA_ALL_SIDES, AREA_ONE_SIDE, AREA_FAR };

typedef enum area_program { AREA_SPLAT, AREA_HOLES, AREA_GRIDS, AREA_GATHER, AREA_SHOW, AREA_PROGRAMS } area_program;

struct vxs_area_light {
    vxs_volumes     *volumes;
    vxs_grid_size    size; /* of each grid */
    uint32_t         most, side_px, count;
    int              is_cast;
    gl_name          buffer;               /* VXS_AREA_LAMPS lamps, words of `most` grids, of as many maps */
    gl_name          gathered, irradiance; /* textures; gathered: two layers, air and surfaces */
    gl_name          programs[AREA_PROGRAMS];
    or_scan          scan;
    vxs_shadow_grid *exact; /* NULL: no light maps are taken */
    float            anchor[3];
    area_lamp        lamps[VXS_AREA_LAMPS];  /* places count from the anchor */
    area_lamp        placed[VXS_AREA_LAMPS]; /* from the origin, as they were uploaded last so */
};

/* The first word of all maps. */
uint32_t vxs_area_light_maps(const vxs_area_light *light);

/* Upload the lamps, their places counted from the anchor, or from the origin. */
void vxs_area_light_put(vxs_area_light *light, int from_origin);

/* Set what a program counts; see there. */
void vxs_area_light_count(const vxs_area_light *light, uint32_t a, uint32_t b, uint32_t c, uint32_t d);

/* Show a layer of what was gathered: added to `image`, or in its place. */
void vxs_area_light_show(const vxs_area_light *light, vxs_area_gather gather, uint32_t layer, gl_name image, int is_added);

#endif
