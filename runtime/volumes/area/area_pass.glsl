/* Parameters of the passes of an area light. */
#include "frame.glsl"

layout(std140, binding = VXS_AT_OWN) uniform vxs_area_block {
    uint  vpls, vpl;              /* number of VPLs; the current VPL */
    uint  side, first_word;       /* of the imperfect shadow maps: texels per side, the first word of all */
    uint  points, is_whole;       /* casters; 1: each point is drawn */
    uint  levels, gather;         /* coarser levels that fill gaps; the vxs_area_gather */
    uint  wide, high;             /* gathered pixels across and up */
    uint  layer, is_added;        /* the layer of gathered light that is shown; 1: what is written is added to what is there */
    int   runs;                   /* of lookups in a grid */
    uint  between_rows;
    float point_wide, gap_wide;   /* of the drawn point, and of texels from which gaps are filled: in widths of what it represents */
    float points_apart;           /* distance between drawn points, in texels */
} vxs_area_pass;
