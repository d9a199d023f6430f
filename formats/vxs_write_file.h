/* Writing .vxs bytes (formats/vxs.md). Not installed: games only read.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_WRITE_FILE_H
#define VXS_WRITE_FILE_H

#include "vxs_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A reference while a DAG is built and written: VXS_REF_LIT, VXS_REF_SHADOW, or VXS_REF_FIRST + index into the level below
 * (or into the masks). */
enum { VXS_REF_LIT = 0, VXS_REF_SHADOW = 1, VXS_REF_FIRST = 2 };

/* A DAG to write. A node is eight references. */
typedef struct vxs_dag_view {
    const uint32_t *nodes[VXS_LEVELS_MAX]; /* [l] 8 * count[l] references; [0] slice nodes, [level_count - 1] holds the root */
    uint32_t        count[VXS_LEVELS_MAX];
    uint32_t        level_count;
    const uint64_t *masks; /* [mask_count] */
    uint32_t        mask_count;
    uint32_t        roots[VXS_CUBE_FACES]; /* indices into the top level, one for each map */
} vxs_dag_view;

/* Palette blocks to write: words in canonical order (formats/vxs.md section 13). */
typedef struct vxs_blocks_view {
    const uint32_t *words; /* [word_count] */
    uint32_t        word_count;
    /* [common_count] kind of each pattern of the common pool, in storage order: number of palette depths, 2..14, or 0: a
     * private-palette pattern */
    const uint8_t  *common_kinds;
    uint32_t        common_count;
    uint32_t        packing; /* VXS_PACKING_* */
} vxs_blocks_view;

/* A light to write, in the coding of light.coding. */
typedef struct vxs_write_light {
    vxs_light       light;
    vxs_dag_view    dag;    /* VXS_CODING_DAG */
    vxs_blocks_view blocks; /* VXS_CODING_BLOCKS */
} vxs_write_light;

/* Points to write, in any order; the file stores them sorted. */
typedef struct vxs_points_view {
    const double *places_ws;     /* [3 * count] */
    uint32_t      count;         /* 1 to VXS_POINTS_MAX */
    double        square_metres; /* area that each point represents */
    /* > 0: unit of rounding of places; a larger unit is used if their bounding box has more than 65535 units */
    double        step_metres;
} vxs_points_view;

typedef struct vxs_write_desc {
    const vxs_write_light *lights;
    uint32_t               light_count;
    const char            *metadata;   /* JSON text, NUL-terminated; NULL: none */
    int                    zstd_level; /* 1..19 */
    const vxs_parallel    *parallel;   /* NULL: the caller's thread does all. The bytes written do not depend on it */
    const vxs_points_view *points;     /* NULL: none */
} vxs_write_desc;

typedef struct vxs_bytes {
    uint8_t *data;
    size_t   size_bytes, capacity_bytes;
} vxs_bytes;

/* Encode a whole file in memory; version 1 if all lights are DAGs. DAG nodes that the root does not reach are omitted. The
 * same input gives the same bytes with one version of zstd.
 * out  [out] grown with realloc; zero it first, release with free(out->data).
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT if the format cannot store a light (number of lights, levels, coding, or
 * words; an empty, unterminated or repeated name; a DAG with another number of levels, or without its roots; blocks that are
 * not in canonical order, or with an unknown packing), if points are NaN or infinite, none or too many, or if zstd_level is
 * out of range. Other numbers of a light are not checked here; vxs_read checks them. */
vxs_result vxs_write(vxs_bytes *out, const vxs_write_desc *desc);

/* Smoke of a light to write (formats/vxs.md section 15). A node is a depth, with the transmittance there, of 65535, in the
 * high half. Along a curve the depth never decreases and the transmittance never increases. */
typedef struct vxs_smoke_view {
    /* maps have 2^levels curves a side: from 3 to the levels of the light, at most VXS_SMOKE_LEVELS_MAX */
    uint32_t        levels;
    float           first_metres, step_metres; /* depth d is first + d * step metres along the map's axis */
    /* [maps][4^levels] number of nodes of each curve, up to VXS_SMOKE_NODES_MAX: tiles of 8 x 8 texels by rows, texels of a tile by
     * rows; NULL: the light has no smoke */
    const uint8_t  *counts;
    const uint32_t *nodes; /* of all curves, in the same order */
} vxs_smoke_view;

/* Add smoke to a file that has none. All other content is kept byte for byte; only its position may change.
 * out         [out] as for vxs_write; not the file itself
 * bytes       [size_bytes] the file;   contents  from vxs_read of these bytes
 * smoke       [light_count] one for each light
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT for a curve or a map that section 15 does not allow, or if the file already
 * has smoke. */
vxs_result vxs_write_smoke(vxs_bytes *out, const void *bytes, size_t size_bytes, const vxs_contents *contents,
                           const vxs_smoke_view *smoke, int zstd_level);

#ifdef __cplusplus
}
#endif

#endif
