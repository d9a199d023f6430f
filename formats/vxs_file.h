/* Reading .vxs bytes (formats/vxs.md); vxs_write_file.h writes them. This layer handles bytes only: no scenes, no OpenGL, no
 * printing. Games use runtime/vxs.h, which includes this.
 * Public.
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

/* The filter of a lookup: over which texels of a map shadow is averaged.
 *   vxs_box(K)     K odd: a box PCF over the K x K texels centred at the point's texel ([CPVS16] 5); vxs_box(1): a single tap. The
 *                  box moves in steps of whole texels, and so do shadow edges
 *   vxs_smooth(K)  K even or odd: a box of width K centred at the point itself. Its border texels count by the covered part, in
 *                  1/256 along each axis. At most 1/(256 K) of the result changes in one step
 * Every width is allowed: one below 1 counts as 1, one above VXS_FILTER_MAX as VXS_FILTER_MAX, and an even one of vxs_box, whose
 * box has no middle texel, as K + 1. Shaders have the same struct and functions (vxs_space.h). */
typedef struct vxs_filter {
    int32_t width_px;  /* K */
    int32_t is_smooth; /* 0: vxs_box; other numbers: vxs_smooth */
} vxs_filter;

static inline vxs_filter vxs_box(int32_t width_px)
{
    vxs_filter filter = {width_px, 0};
    return filter;
}

static inline vxs_filter vxs_smooth(int32_t width_px)
{
    vxs_filter filter = {width_px, 1};
    return filter;
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

/* Called for each finding: its number in vxs_findings.h, its text, and its place (section -1: header and directory). Not a
 * vxs_log_fn, because programs use the number and the place. */
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
 * needs some 0.6 MiB within the limit (0.15 MiB for pages packed fast). If there is less memory, fewer threads are
 * used. Allocator and findings are called only on the caller's thread. */
vxs_result vxs_read(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc);

/* Accepts a zeroed object. */
void vxs_contents_free(vxs_contents *contents);

#ifdef __cplusplus
}
#endif

#endif
