/* An area light; see vxs_area_light.h. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef AREA_STATE_H
#define AREA_STATE_H

#include "grid_head.h"
#include "or_scan.h"
#include "transmittance_map.h"
#include "vxs_area_light.h"

enum { AREA_BITS = 128 };

/* As in area.glsl (std430). */
typedef struct area_vpl {
    grid_head grid;
    float     place[3], radius_metres;
    float     normal[3], kind;  /* AREA_ALL_SIDES and so on */
    float     colour[3], baked; /* 1 + index of the light whose baked smoke dims it; 0: none */
    float     across[4];
} area_vpl;

/* Lines of #define in texts of programs: for those that only read VPLs; for those that gather; and for exact maps, whose lights
 * may have baked smoke. */
#define AREA_READS      "#define VXS_GRID_ACCESS readonly\n"
#define AREA_GATHERS    AREA_READS "#define VXS_AREA_GATHERS\n"
#define AREA_TAKES_MAPS "#define VXS_AREA_TAKES_MAPS\n"

/* How a VPL emits. */
enum { AREA_ALL_SIDES, AREA_ONE_SIDE, AREA_FAR };

/* State of the smoke curves: none, valid for the VPLs, or of earlier VPL positions. */
typedef enum area_smoke { AREA_CLEAR, AREA_DIMMED, AREA_DIMMED_BEFORE } area_smoke;

struct vxs_area_light {
    vxs_volumes     *volumes;
    vxs_grid_size    size; /* of each grid */
    uint32_t         most, side_px, count;
    int              is_cast;
    gl_name          buffer;               /* VXS_VPLS_MAX VPLs, words of `most` grids, words of as many maps */
    gl_name          gathered, irradiance; /* textures; gathered has two layers: air and surfaces */
    or_scan          scan;
    vxs_shadow_grid *exact; /* NULL: no shadow depth maps are used */
    area_smoke       smoke;
    float            anchor[3];
    area_vpl         vpls[VXS_VPLS_MAX];   /* positions from the anchor */
    area_vpl         placed[VXS_VPLS_MAX]; /* positions from the origin, as last uploaded in this way */

    vxs_transmittance_map curves; /* smoke, a layer for each VPL; all 0: no smoke */
};

/* The first word of all maps. */
uint32_t vxs_area_shadow_depth_maps(const vxs_area_light *light);

/* Upload the VPLs, with positions from the anchor or from the origin. */
void vxs_area_light_put(vxs_area_light *light, int from_origin);

/* 1: there are VPLs, and each emits to one side only, so that a map covers all of its directions. */
int vxs_area_light_has_sides(const vxs_area_light *light);

/* Allocate what smoke needs.   Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_GL; VXS_E_MEMORY */
vxs_result vxs_area_light_take_smoke(vxs_area_light *light, const vxs_area_light_desc *desc);

/* Bind the VPLs' curves, and after them the VPLs. */
void vxs_area_light_use_curves(const vxs_area_light *light);

/* Show a layer of the gathered light: added to `image`, or replacing it. */
void vxs_area_light_show(const vxs_area_light *light, vxs_area_gather gather, uint32_t layer, gl_name image, int is_added);

#endif
