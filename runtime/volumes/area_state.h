/* An area light; see vxs_area_light.h. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef AREA_STATE_H
#define AREA_STATE_H

#include "grid_head.h"
#include "or_scan.h"
#include "transmittance_map.h"
#include "vxs_area_light.h"

enum { AREA_BITS = 128 };

/* As area.glsl has it (std430). */
typedef struct area_lamp {
    grid_head grid;
    float     place[3], radius_metres;
    float     normal[3], kind;  /* AREA_ALL_SIDES and so on */
    float     colour[3], baked; /* number of the light whose baked smoke dims it, and 1; 0: none does */
    float     across[4];
} area_lamp;

/* What programs need beside the texts that all have: lines of #define. What only reads lamps, and what gathers, without exact maps and with them. */
#define AREA_USES       "#define VXS_USES_GRID\n#define VXS_USES_AREA\n"
#define AREA_READS      AREA_USES "#define VXS_GRID_ACCESS readonly\n"
#define AREA_GATHERS    AREA_READS "#define VXS_AREA_GATHERS\n"
#define AREA_TAKES_MAPS AREA_GATHERS "#define VXS_AREA_TAKES_MAPS\n"

/* How a lamp shines. */
enum { AREA_ALL_SIDES, AREA_ONE_SIDE, AREA_FAR };

typedef enum area_program {
    AREA_SPLAT,
    AREA_HOLES,
    AREA_GRIDS,
    AREA_GATHER,
    AREA_SHOW,
    AREA_EXACT, /* 0 where no light maps are taken */
    AREA_CLEAR_PROGRAMS,
    AREA_CURVES = AREA_CLEAR_PROGRAMS, /* this and the next: 0 where no smoke is taken */
    AREA_GATHER_SMOKE,
    AREA_EXACT_SMOKE,
    AREA_PROGRAMS
} area_program;

/* Curves of smoke: there are none, they are those of the lamps, or of where these were before. */
typedef enum area_smoke { AREA_CLEAR, AREA_DIMMED, AREA_DIMMED_BEFORE } area_smoke;

struct vxs_area_light {
    vxs_volumes     *volumes;
    vxs_grid_size    size; /* of each grid */
    uint32_t         most, side_px, count;
    int              is_cast;
    gl_name          buffer;               /* VXS_VPLS_MAX lamps, words of `most` grids, of as many maps */
    gl_name          gathered, irradiance; /* textures; gathered: two layers, air and surfaces */
    gl_name          programs[AREA_PROGRAMS];
    or_scan          scan;
    vxs_shadow_grid *exact; /* NULL: no light maps are taken */
    area_smoke       smoke;
    float            anchor[3];
    area_lamp        lamps[VXS_VPLS_MAX];  /* places count from the anchor */
    area_lamp        placed[VXS_VPLS_MAX]; /* from the origin, as they were uploaded last so */

    vxs_transmittance_map curves; /* of smoke, a layer for each lamp; all 0: none is taken */
};

/* The first word of all maps. */
uint32_t vxs_area_shadow_depth_maps(const vxs_area_light *light);

/* Upload the lamps, their places counted from the anchor, or from the origin. */
void vxs_area_light_put(vxs_area_light *light, int from_origin);

/* 1: each lamp shines to one side, so that a map of it has all that it shines to; of one lamp and more. */
int vxs_area_light_has_sides(const vxs_area_light *light);

/* Make what smoke needs.   VXS_OK; VXS_E_ARGUMENT; VXS_E_GL; VXS_E_MEMORY */
vxs_result vxs_area_light_take_smoke(vxs_area_light *light, const vxs_area_light_desc *desc);

/* Bind the lamps' curves, and the lamps behind them. */
void vxs_area_light_use_curves(const vxs_area_light *light);

/* Set what a program counts; see there. */
void vxs_area_light_count(const vxs_area_light *light, uint32_t a, uint32_t b, uint32_t c, uint32_t d);

/* Show a layer of what was gathered: added to `image`, or in its place. */
void vxs_area_light_show(const vxs_area_light *light, vxs_area_gather gather, uint32_t layer, gl_name image, int is_added);

#endif
