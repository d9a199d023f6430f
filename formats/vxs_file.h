/* Reading and writing .vxs bytes (formats/vxs.md). This layer knows bytes: no scenes, no OpenGL, no printing.
 * Games use runtime/vxs.h, which stands on this.
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

/* The record of a light in the file: how its maps lie in the world. */
typedef struct vxs_light {
    char     name[VXS_LIGHT_NAME_BYTES]; /* UTF-8, NUL-terminated, unique in the file */
    uint32_t kind;                       /* VXS_LIGHT_KIND_* */
    uint32_t flags;                      /* VXS_LIGHT_BOUNDED (directional), VXS_LIGHT_CUBE (point; spot with a wide cone) */
    uint32_t levels;                     /* a map has 2^levels texels a side and 2^levels voxels in depth; 3..18 */
    uint32_t coding;                     /* VXS_CODING_*: how its words hold its maps */
    double ls_from_ws[12];  /* rows of a 3 x 4 matrix from world metres. Directional: to texels u, v and voxels of depth; (0,0,0) is
                                  the corner of the map nearest the light. Spot and point: to metres about the light, x and y
                                  across its direction and z along it */
    double texel_metres;    /* side of a texel; spot and point: at one metre from the light along its map's axis */
    double voxel_metres;    /* depth of a voxel; spot and point: of one metre from the light, log(far / near) / 2^levels */
    double direction_ws[3]; /* unit vector, the way the light travels; the third axis of a point light's cube */
    double near_metres;     /* spot and point: depth 0 is so far from the light along its map's axis; else 0 */
    double cos_outer;       /* spot: cosine of the angle between its direction and the edge of its cone, [0, 1); else 0 */
    double range_metres;    /* spot and point: metres from the light to where its volume ends; 0: no end; else 0 */
} vxs_light;

/* Things of one kind among the words of a light. Which kinds there are is its coding's: of a DAG, nodes of each size, and masks; of
 * palette blocks, maps (where their nodes are), patterns of several pages, and pages, which hold the rest. */
typedef struct vxs_part {
    const char *kind;        /* "nodes", "masks"; "tops", "patterns", "pages" */
    uint32_t    side_voxels; /* of each thing in the map: 8 a mask, a slice node or a pattern, 16.. an octree node; 0: it varies */
    uint32_t    count;
    uint64_t    memory_bytes; /* of the words that they take */
    uint32_t    section;      /* of the file: where they are from */
} vxs_part;

/* A light with the words of its maps, as its coding lays them out: what is looked up. */
typedef struct vxs_baked_light {
    vxs_light       light;
    const uint32_t *words; /* [word_count]; of palette blocks, VXS_BLOCKS_SPARE_WORDS more behind them, zeros */
    uint32_t        word_count;
    uint32_t        packing; /* how the file keeps the pages of palette blocks, VXS_PACKING_*; words are the same */
    uint32_t        part_count;
    vxs_part        parts[VXS_LEVELS_MAX]; /* [part_count] of a DAG, the roots first, masks last */
} vxs_baked_light;

/* How many maps a light has: 1, or 6. */
static inline uint32_t vxs_map_count(const vxs_light *light)
{
    return light->flags & VXS_LIGHT_CUBE ? VXS_CUBE_FACES : 1;
}

/* What smoke leaves of a light, baked: a map of curves in the space of each of the light's maps (formats/vxs.md section 15). */
typedef struct vxs_baked_smoke {
    const uint32_t *words; /* [word_count]; NULL: the light has none, and all else is 0 */
    uint32_t        word_count;
    uint32_t        side_px;    /* curves along a side of a map */
    uint32_t        tile_count; /* that have a curve */
    uint32_t        node_count; /* of all curves */
    uint32_t        section;    /* of the file: where they are from */
} vxs_baked_smoke;

/* Points of the surfaces that cast shadow, baked: as many on each as its part of the area is (formats/vxs.md section 16). */
typedef struct vxs_baked_points {
    const uint16_t *coordinates; /* [3 * count] units from low_ws on; NULL: there are none, and all else is 0 */
    uint32_t        count;
    uint32_t        section;       /* of the file: where they are from */
    double          square_metres; /* that each stands for */
    double          low_ws[3], step_metres;
} vxs_baked_points;

/* Where memory comes from. A NULL allocator, or one with NULL functions, is malloc and free. */
typedef struct vxs_allocator {
    void *(*alloc)(size_t size_bytes, void *user); /* NULL when there is none */
    void (*free)(void *memory, size_t size_bytes, void *user);
    void *user;
} vxs_allocator;

/* Threads of the caller's, to which work is given that falls into tasks. No library here starts a thread of its own accord. */
typedef struct vxs_parallel {
    /* Call task(work, n) once for each n from 0 to count - 1, on any threads, in any order, at once or not, and return when all have
     * returned and what they wrote is seen. No task waits for another. A loop over n will do. */
    void (*run)(void *user, uint32_t count, void (*task)(void *work, uint32_t n), void *work);
    void    *user;
    uint32_t threads; /* that are worth having: count is never more. 0, 1, or no run: the caller's thread does all */
    /* Called by each task between pieces of its work of a millisecond or less, where it holds nothing and may be made to wait. NULL: never */
    void (*pause)(void *user);
} vxs_parallel;

/* Called for each thing that is wrong: a number of vxs_findings.h, its text, and where (section is -1 for header and directory). */
typedef void vxs_finding_fn(void *user, int number, const char *text, int section, uint64_t offset_bytes);

/* Zero is every field's default. It may grow in later versions of the library, with which programs that know less of it keep running. */
typedef struct vxs_read_desc {
    size_t               struct_size;       /* sizeof(vxs_read_desc), as the caller knows it; 0: up to and with `parallel` */
    const vxs_allocator *allocator;         /* NULL: malloc and free; copied, but its functions must outlive what was read */
    uint64_t            memory_limit_bytes; /* 0: 256 times the file, but 64 MiB at least. More is refused before it is allocated */
    vxs_finding_fn     *finding;            /* NULL: nobody asks */
    void               *finding_user;
    int                 find_all; /* 1: go on after a finding where that makes sense, to report the others too */
    int                 metadata; /* 1: inflate the metadata, too. 0: no lookup needs it, so it is left as it lies in the file */
    const vxs_parallel *parallel; /* NULL: the caller's thread does all. What is read, and what is found, does not depend on it */
} vxs_read_desc;

typedef struct vxs_section {
    uint32_t kind, flags, light, level;
    uint64_t offset_bytes, stored_bytes, inflated_bytes, hash;
} vxs_section;

/* What a file holds, decoded. Release with vxs_contents_free. */
typedef struct vxs_contents {
    uint32_t         version;
    uint32_t         light_count;
    vxs_baked_light *lights;
    uint32_t         section_count;
    vxs_section     *sections;
    char            *metadata; /* JSON text, NUL-terminated; NULL when the file has none, or nobody asked for it */
    size_t           metadata_bytes;
    vxs_allocator    allocator;
} vxs_contents;

/* Check every byte of a file and decode it, so that a lookup may trust every offset.
 * bytes     [size_bytes] the whole file; only read, not kept
 * desc      NULL: all defaults
 * contents  [out] written only when VXS_OK is returned
 * Returns VXS_OK; VXS_E_NOT_VXS, VXS_E_VERSION, VXS_E_TRUNCATED, VXS_E_CORRUPT: the first finding's result; VXS_E_MEMORY; VXS_E_ARGUMENT
 * for a struct_size that no version had, or fields behind those that this one has which are not zero.
 * Bad bytes never abort, and cost no more memory than the limit; zstd's own working memory (some 160 KiB) comes from malloc and is
 * not counted. Threads: none shared; those of desc->parallel decode the pages of palette blocks, and need some 0.4 MiB each, a third of
 * that where pages are packed fast, within the limit: with less, fewer of them are used. Allocator and findings are called by the caller's thread alone. */
vxs_result vxs_read(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc);

/* Accepts a zeroed object. */
void vxs_contents_free(vxs_contents *contents);

/* A reference, while a DAG is built and written: VXS_REF_LIT, VXS_REF_SHADOW, or VXS_REF_FIRST + index into the level below (or
 * into the masks). */
enum { VXS_REF_LIT = 0, VXS_REF_SHADOW = 1, VXS_REF_FIRST = 2 };

/* A DAG to be written. Nodes are eight references. */
typedef struct vxs_dag_view {
    const uint32_t *nodes[VXS_LEVELS_MAX]; /* [l] 8 * count[l] references; [0] slice nodes, [level_count - 1] holds the root */
    uint32_t        count[VXS_LEVELS_MAX];
    uint32_t        level_count;
    const uint64_t *masks; /* [mask_count] */
    uint32_t        mask_count;
    uint32_t        roots[VXS_CUBE_FACES]; /* indices into the top level, one for each map of the light */
} vxs_dag_view;

/* Palette blocks to be written: words in canonical order (formats/vxs.md section 13). */
typedef struct vxs_blocks_view {
    const uint32_t *words; /* [word_count] */
    uint32_t        word_count;
    const uint8_t  *common_kinds; /* [common_count] of each pattern of the common pool, as they lie: how many depths of a palette it
                                     parts, 2..14, or 0: it has its own */
    uint32_t        common_count;
    uint32_t        packing; /* VXS_PACKING_* */
} vxs_blocks_view;

/* A light to be written, in the coding that it names. */
typedef struct vxs_write_light {
    vxs_light       light;
    vxs_dag_view    dag;    /* VXS_CODING_DAG */
    vxs_blocks_view blocks; /* VXS_CODING_BLOCKS */
} vxs_write_light;

/* Points to be written, in any order: readers see them sorted. */
typedef struct vxs_points_view {
    const double *places_ws;     /* [3 * count] */
    uint32_t      count;         /* 1 to VXS_POINTS_MAX */
    double        square_metres; /* that each stands for */
    double step_metres; /* > 0: places are rounded to such units, or larger ones where the box about them has more than 65535 */
} vxs_points_view;

typedef struct vxs_write_desc {
    const vxs_write_light *lights;
    uint32_t               light_count;
    const char            *metadata;   /* JSON text, NUL-terminated; NULL: none */
    int                    zstd_level; /* 1..19 */
    const vxs_parallel    *parallel;   /* NULL: the caller's thread does all. What is written does not depend on it */
    const vxs_points_view *points;     /* NULL: none */
} vxs_write_desc;

typedef struct vxs_bytes {
    uint8_t *data;
    size_t   size_bytes, capacity_bytes;
} vxs_bytes;

/* Encode a whole file in memory, of version 1 when all lights are DAGs. Nodes of a DAG that the root does not reach are left out; same
 * input, same bytes for one zstd version.
 * out  [out] grown with realloc; zero it first, release with free(out->data).
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT when the format has no room for a light (number of lights, levels, coding, or words; an
 * empty, unterminated or repeated name; a DAG without as many levels, or without its roots; blocks that are not in canonical order, or of no
 * packing), points that are no numbers, none or too many, or zstd_level is out of range. A light's other numbers are written as they are: vxs_read says whether they make sense.
 * The runtime library does not hold this function: games only read. */
vxs_result vxs_write(vxs_bytes *out, const vxs_write_desc *desc);

/* Smoke of a light to be written (formats/vxs.md section 15). A node is a depth, and in the high half what is left there, of 65535; along a curve the
 * first never falls, the other never rises. */
typedef struct vxs_smoke_view {
    uint32_t levels;                    /* maps have 2^levels curves a side: 3 to those of the light, and VXS_SMOKE_LEVELS_MAX */
    float    first_metres, step_metres; /* depth d is first + d * step metres along the map's axis */
    const uint8_t *
        counts; /* [maps][4^levels] nodes of each curve, up to VXS_SMOKE_NODES_MAX: tiles of 8 x 8 texels by rows, and so texels of each
                               tile; NULL: the light has no smoke */
    const uint32_t *nodes; /* of all curves, in that order */
} vxs_smoke_view;

/* Add smoke to a file that has none; all else in it is kept byte for byte, but for where it lies.
 * out         [out] as for vxs_write; not the file itself
 * bytes       [size_bytes] the file;   contents  what vxs_read made of it
 * smoke       [light_count] one for each light
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT for a curve or a map that section 15 does not allow, or where smoke is there already. */
vxs_result vxs_write_smoke(vxs_bytes *out, const void *bytes, size_t size_bytes, const vxs_contents *contents,
                           const vxs_smoke_view *smoke, int zstd_level);

#ifdef __cplusplus
}
#endif

#endif
