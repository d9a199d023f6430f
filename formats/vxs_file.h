/* Reading and writing .vxs bytes (formats/vxs.md). This layer handles bytes only: no scenes, no OpenGL, no printing.
 * Games use runtime/vxs.h, which uses this.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_FILE_H
#define VXS_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "vxs_format.h"
#include "vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The record of a light in the file: placement of its maps in the world. */
typedef struct vxs_light {
    char     name[VXS_LIGHT_NAME_BYTES]; /* UTF-8, NUL-terminated, unique in the file */
    uint32_t kind;                       /* VXS_LIGHT_KIND_* */
    uint32_t flags;                      /* VXS_LIGHT_BOUNDED (directional), VXS_LIGHT_CUBE (point; spot with a wide cone) */
    uint32_t levels;                     /* a map has 2^levels texels a side and 2^levels voxels in depth; 3..18 */
    uint32_t coding;                     /* VXS_CODING_*: how the words store the maps */
    /* rows of a 3 x 4 matrix from world metres. Directional: to texels u, v and voxels of depth; (0,0,0) is the corner of the map
     * nearest the light. Spot and point: to metres about the light, x and y across its direction and z along it */
    double   ls_from_ws[12];
    double   texel_metres;    /* side of a texel; spot and point: at one metre from the light along its map's axis */
    double   voxel_metres;    /* depth of a voxel; spot and point: of one metre from the light, log(far / near) / 2^levels */
    double   direction_ws[3]; /* unit vector, the way the light travels; the third axis of a point light's cube */
    double   near_metres;     /* spot and point: distance of depth 0 from the light along the axis of its map; else 0 */
    double   cos_outer;       /* spot: cosine of the angle between its direction and the edge of its cone, [0, 1); else 0 */
    double   range_metres;    /* spot and point: distance from the light where its volume ends; 0: no end; directional: 0 */
} vxs_light;

/* Parts of one kind in the words of a light. The coding determines the kinds: a DAG has nodes of each size, and masks;
 * palette blocks have tops (entries of the maps), patterns of the common pool, and pages, which hold the rest. */
typedef struct vxs_part {
    const char *kind;        /* "nodes", "masks"; "tops", "patterns", "pages" */
    uint32_t    side_voxels; /* side of each part in the map: 8: mask, slice node or pattern; 16..: octree node; 0: it varies */
    uint32_t    count;
    uint64_t    memory_bytes; /* of their words */
    uint32_t    section;      /* section of the file that holds them */
} vxs_part;

/* A light with the words of its maps, laid out for lookups in its coding. */
typedef struct vxs_baked_light {
    vxs_light       light;
    const uint32_t *words; /* [word_count]; palette blocks: followed by VXS_BLOCKS_SPARE_WORDS zeros */
    uint32_t        word_count;
    /* packing of the pages of palette blocks in the file, VXS_PACKING_*; it does not change the words */
    uint32_t        packing;
    uint32_t        part_count;
    vxs_part        parts[VXS_LEVELS_MAX]; /* [part_count] for a DAG, the roots are first and the masks last */
} vxs_baked_light;

/* Number of maps of a light: 1 or 6. */
static inline uint32_t vxs_map_count(const vxs_light *light)
{
    return light->flags & VXS_LIGHT_CUBE ? VXS_CUBE_FACES : 1;
}

/* Baked transmittance of smoke: a map of curves in the space of each map of the light (formats/vxs.md section 15). */
typedef struct vxs_baked_smoke {
    const uint32_t *words; /* [word_count]; NULL: the light has no smoke, and all other fields are 0 */
    uint32_t        word_count;
    uint32_t        side_px;    /* curves along a side of a map */
    uint32_t        tile_count; /* tiles that have a curve */
    uint32_t        node_count; /* of all curves */
    uint32_t        section;    /* section of the file that holds them */
} vxs_baked_smoke;

/* Baked points on the surfaces that cast shadow; the number on each surface is proportional to its area (formats/vxs.md
 * section 16). */
typedef struct vxs_baked_points {
    /* [3 * count] in units of step_metres from low_ws; NULL: there are none, and all other fields are 0 */
    const uint16_t *coordinates;
    uint32_t        count;
    uint32_t        section;       /* section of the file that holds them */
    double          square_metres; /* area that each point represents */
    double          low_ws[3], step_metres;
} vxs_baked_points;

/* Memory functions. A NULL allocator, or one with NULL functions, means malloc and free. */
typedef struct vxs_allocator {
    void *(*alloc)(size_t size_bytes, void *user); /* returns NULL if there is no memory */
    void (*free)(void *memory, size_t size_bytes, void *user);
    void *user;
} vxs_allocator;

/* Threads of the caller, for work that is divided into tasks. The library itself never starts a thread. */
typedef struct vxs_parallel {
    /* Call task(work, n) once for each n from 0 to count - 1, on any threads, in any order, at once or not. Return when all
     * have returned and their writes are visible. No task waits for another. A loop over n is sufficient. */
    void (*run)(void *user, uint32_t count, void (*task)(void *work, uint32_t n), void *work);
    void    *user;
    /* greatest useful number of threads: count is never more. 0, 1, or run NULL: the caller's thread does all */
    uint32_t threads;
    /* Called by each task between pieces of its work of at most a millisecond, where it holds no lock and may be made to
     * wait. NULL: never */
    void (*pause)(void *user);
} vxs_parallel;

/* Called for each finding: its number in vxs_findings.h, its text, and its place (section -1: header and directory). */
typedef void vxs_finding_fn(void *user, int number, const char *text, int section, uint64_t offset_bytes);

/* Zero is the default of every field. The struct may grow in later versions of the library; programs built with an older
 * struct keep running. */
typedef struct vxs_read_desc {
    size_t               struct_size; /* sizeof(vxs_read_desc) of the caller; 0: up to and including `parallel` */
    /* NULL: malloc and free. The struct is copied, but its functions must outlive the contents */
    const vxs_allocator *allocator;
    /* 0: 256 times the file size, but at least 64 MiB. A larger request is refused before allocation */
    uint64_t             memory_limit_bytes;
    vxs_finding_fn      *finding; /* NULL: not wanted */
    void                *finding_user;
    int                  find_all; /* 1: continue after a finding if possible, to report others too */
    int                  metadata; /* 1: inflate the metadata too. 0: leave it compressed; lookups do not need it */
    const vxs_parallel  *parallel; /* NULL: the caller's thread does all. Results and findings do not depend on it */
} vxs_read_desc;

typedef struct vxs_section {
    uint32_t kind, flags, light, level;
    uint64_t offset_bytes, stored_bytes, inflated_bytes, hash;
} vxs_section;

/* The decoded contents of a file. Release with vxs_contents_free. */
typedef struct vxs_contents {
    uint32_t         version;
    uint32_t         light_count;
    vxs_baked_light *lights;
    uint32_t         section_count;
    vxs_section     *sections;
    char            *metadata; /* JSON text, NUL-terminated; NULL if the file has none, or if it was not wanted */
    size_t           metadata_bytes;
    vxs_allocator    allocator;
} vxs_contents;

/* Check every byte of a file and decode it. After that, lookups may trust every offset.
 * bytes     [size_bytes] the whole file; only read, not kept
 * desc      NULL: all defaults
 * contents  [out] written only if VXS_OK is returned
 * Returns VXS_OK; the result of the first finding: VXS_E_NOT_VXS, VXS_E_VERSION, VXS_E_TRUNCATED, VXS_E_CORRUPT;
 * VXS_E_MEMORY; VXS_E_ARGUMENT if no version has this struct_size, or if fields unknown to this version are not zero.
 *
 * Invalid bytes never abort, and never need more memory than the limit. The working memory of zstd (some 160 KiB) comes from
 * malloc and is not counted. Threads: no shared state. Threads of desc->parallel decode the pages of palette blocks; each
 * needs some 0.4 MiB within the limit (a third of that for pages packed fast). If there is less memory, fewer threads are
 * used. Allocator and findings are called only on the caller's thread. */
vxs_result vxs_read(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc);

/* Accepts a zeroed object. */
void vxs_contents_free(vxs_contents *contents);

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
 * out of range. Other numbers of a light are not checked here; vxs_read checks them. The runtime library does not contain
 * this function: games only read. */
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
