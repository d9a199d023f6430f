/* libvxs_bake: what `vxs bake` does, from a program: shadows of a scene at level load, or of a sun that moves, a little in each frame.
 *
 *     vxs_bake_options o = vxs_bake_defaults();
 *     char             error[VXS_BAKE_ERROR_BYTES];
 *     o.scene_path  = "level.glb";
 *     o.output_path = "level.vxs";
 *     if (vxs_bake(&o, NULL, error) != VXS_OK) fprintf(stderr, "%s\n", error);
 *
 * Same scene, same options, same bytes as the command's, whatever the threads, and however often a bake is held. Depths come straight from
 * triangles: there is no OpenGL in here, and no bake for which `vxs bake` would need it.
 *
 * The library keeps no state but that of its objects. It never prints, exits or aborts, installs no signal handler, and changes nothing of the
 * process. (Reading glTF is an exception when memory ends: the JSON library allocates in a destructor, where C++ ends the process.)
 *
 * Licence: GPL-3.0-or-later, as CGAL is, which it contains: a program that is linked with it is under the GPL where it is handed on. A game
 * that only looks shadows up links libvxs (vxs.h), which is MIT; a level editor that is not handed on may link this.
 * docs/bake-library.md is the guide.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VXS_BAKE_H
#define VXS_BAKE_H

#include <stddef.h>
#include <stdint.h>

#include "vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Texts of errors: one line, without a newline, in English; they name options as the command does (--sun, --memory). */
enum { VXS_BAKE_ERROR_BYTES = 1024 };

/* scenes as arrays ------------------------------------------------------------------------------------------------------------ */

/* Triangles of a scene. World space is that of glTF: metres, +Y up. */
typedef struct vxs_bake_mesh {
    const float    *positions; /* [3 * vertex_count] finite; metres from origin_ws */
    const uint32_t *indices;   /* [3 * triangle_count] < vertex_count, counter-clockwise as seen from outside; NULL: 0, 1, 2, ... */
    uint32_t        vertex_count;
    uint32_t        triangle_count;
    double          origin_ws[3]; /* finite; where it is placed: floats are fine only near their origin */
    int             double_sided; /* 1: both sides are seen, so that it is no solid even where it is closed */
} vxs_bake_mesh;

typedef enum vxs_bake_light_kind { VXS_BAKE_DIRECTIONAL, VXS_BAKE_SPOT, VXS_BAKE_POINT } vxs_bake_light_kind;

typedef struct vxs_bake_light {
    const char         *name; /* UTF-8, 1 to 63 bytes; no two are alike */
    vxs_bake_light_kind kind;
    double              position_ws[3];  /* metres; of spot and point lights */
    double              direction_ws[3]; /* the way light travels, of any length but zero; of directional and spot lights */
    double              outer_rad;       /* of a spot: from its direction to the edge of its cone, (0, pi/2] */
    double              range_m;         /* of spot and point lights: how far they reach, > 0; 0: without end */
} vxs_bake_light;

typedef struct vxs_bake_arrays {
    const vxs_bake_mesh  *meshes; /* [mesh_count] at least one */
    size_t                mesh_count;
    const vxs_bake_light *lights; /* [light_count] NULL: none, where there are suns */
    size_t                light_count;
    const double *viewpoints_ws; /* [3 * viewpoint_count] where cameras may be: what is closed around one is no solid. NULL: none */
    size_t        viewpoint_count;
} vxs_bake_arrays;

/* options --------------------------------------------------------------------------------------------------------------------- */

/* A directional light that is added, or takes the place of the scene's light of its name: --sun NAME=X,Y,Z. */
typedef struct vxs_bake_sun {
    const char *name;            /* UTF-8, 1 to 63 bytes; NULL: "sun" */
    double      direction_ws[3]; /* the way sunlight travels, of any length but zero */
} vxs_bake_sun;

/* How large the maps of one light are; one of the two: --resolution NAME=N, --texel NAME=METRES. */
typedef struct vxs_bake_map_size {
    const char *light_name;
    uint32_t    resolution;   /* texels a side, a power of two, 8 to 262144; 0: from texel_metres */
    double      texel_metres; /* 1e-9 to 1e9; 0: from resolution */
} vxs_bake_map_size;

typedef enum vxs_bake_closed { VXS_BAKE_CLOSED_AUTO, VXS_BAKE_CLOSED_ON, VXS_BAKE_CLOSED_OFF } vxs_bake_closed;
typedef enum vxs_bake_exit { VXS_BAKE_EXIT_AUTO, VXS_BAKE_EXIT_PEEL, VXS_BAKE_EXIT_BACK } vxs_bake_exit;
typedef enum vxs_bake_coding { VXS_BAKE_BLOCKS, VXS_BAKE_DAG } vxs_bake_coding;
typedef enum vxs_bake_pack { VXS_BAKE_PACK_SMALL, VXS_BAKE_PACK_FAST } vxs_bake_pack;
typedef enum vxs_bake_skinned { VXS_BAKE_SKINNED_EXCLUDE, VXS_BAKE_SKINNED_REST } vxs_bake_skinned;
typedef enum vxs_bake_blend { VXS_BAKE_BLEND_MASK, VXS_BAKE_BLEND_OPAQUE, VXS_BAKE_BLEND_EXCLUDE } vxs_bake_blend;

/* How far a bake is. */
typedef struct vxs_bake_progress {
    double      share;        /* of the whole that is done, 0 to 1; below 0 where that is not known yet */
    double      seconds_left; /* of work, not of waiting between steps; below 0: not known */
    const char *doing;        /* "light sun: tile 3 of 16"; one line, valid during the call */
} vxs_bake_progress;

/* Return 0 to go on, anything else to give the bake up: it ends with VXS_E_INTERRUPTED. */
typedef int vxs_bake_progress_fn(void *user, const vxs_bake_progress *progress);

/* A warning: one line, valid during the call. Equal ones come once. */
typedef void vxs_bake_warning_fn(void *user, const char *warning);

typedef struct vxs_bake_scene vxs_bake_scene;
typedef struct vxs_bake_job   vxs_bake_job;

/* What a bake is asked to do. Begin with vxs_bake_defaults(): it says how large the struct is, so that programs keep working with later libraries,
 * which may have more of it. In every field 0 or NULL is the default. All that is pointed to is borrowed until the call, the scene or the job
 * that was given the options ends. Texts and paths as the command line would have them. */
typedef struct vxs_bake_options {
    size_t struct_bytes; /* set by vxs_bake_defaults */

    /* the scene: one of these three */
    const char            *scene_path; /* .gltf or .glb */
    const vxs_bake_arrays *arrays;
    const vxs_bake_scene  *scene; /* that was opened before, and outlives the job; then all options down to `skinned` are its own */

    /* what of the scene casts, and how */
    const char *const *exclude, *const *include; /* [count] patterns, of a file: --exclude, --include */
    size_t           exclude_count, include_count;
    const char      *scene_name; /* which scene of a file: --scene; NULL: its default */
    vxs_bake_closed  closed;     /* which closed components are solids: --closed */
    vxs_bake_skinned skinned;    /* --skinned */

    /* lights: all of the scene, unless there are names or suns */
    const char *const       *light_names; /* [light_name_count] */
    size_t                   light_name_count;
    const vxs_bake_sun      *suns; /* [sun_count] */
    size_t                   sun_count;
    uint32_t                 resolution;   /* texels a side, a power of two, 8 to 262144; 0: 4096, or from texel_metres */
    double                   texel_metres; /* 1e-9 to 1e9; 0: from resolution */
    const vxs_bake_map_size *map_sizes;    /* [map_size_count] of lights that have their own */
    size_t                   map_size_count;
    int                      has_region;   /* 1: maps of suns cover region_ws alone: --region */
    double                   region_ws[6]; /* min xyz, max xyz, metres */

    /* what is made of it */
    vxs_bake_exit   exit;
    int             behind_free; /* 1: what lies behind the last surface is left open: --behind free */
    double          thickness_m; /* of single-sided sheets that face the light, 1e-9 to 1e9; 0: none: --thickness */
    vxs_bake_coding coding;
    vxs_bake_pack   pack;        /* of VXS_BAKE_BLOCKS */
    uint32_t        zstd_level;  /* 1 to 19; 0: 12 */
    const char     *output_path; /* .vxs; it appears complete or not at all. NULL: the bytes stay in memory alone */
    int             replace;     /* 1: also what is read-only, or one of several links to a file: --force */
    const char     *resume_path; /* a folder where finished squares are kept: --resume; NULL: nothing is kept */
    int             if_changed;  /* 1: with output_path: where it was baked from the same by this version, it stays as it is */

    /* how it is made; never changes the bytes */
    uint32_t threads; /* 1 to 256; 0: all processors that the process may run on */
    uint64_t
        memory_bytes; /* what the process may hold at most while it bakes, all of it, not the bake alone; 0: as much as there is */

    /* who is told: from the thread that bakes, never two calls for one job at once */
    vxs_bake_progress_fn *progress;
    vxs_bake_warning_fn  *warning;
    void                 *user; /* handed to both */

    /* of a file's scene, since the second version of this struct: of a scene that was opened before, its own */
    vxs_bake_blend blend;         /* materials of alphaMode BLEND: --blend */
    int            allow_outside; /* 1: buffers and images may lie outside of the scene's folder: --allow-outside */
} vxs_bake_options;

static inline vxs_bake_options vxs_bake_defaults(void)
{
#ifdef __cplusplus
    vxs_bake_options o = vxs_bake_options();
#else
    vxs_bake_options o = {0};
#endif
    o.struct_bytes = sizeof o;
    return o;
}

/* A .vxs file in memory. */
typedef struct vxs_bake_bytes {
    uint8_t *data; /* owned by whoever asked for it; released with vxs_bake_bytes_free */
    size_t   size_bytes;
} vxs_bake_bytes;

/* Accepts a zeroed object, and leaves one. */
void vxs_bake_bytes_free(vxs_bake_bytes *bytes);

/* one call -------------------------------------------------------------------------------------------------------------------- */

/* Bake a scene; returns when it is done.
 * options  an output path, or file, or both
 * file     [out] NULL: nobody wants the bytes. Zeroed on failure, and where if_changed left the output as it was
 * error    [VXS_BAKE_ERROR_BYTES] out: what is wrong, or ""; NULL: nobody asks
 * Returns VXS_OK;
 *   VXS_E_ARGUMENT     an option is outside its range or excludes another one, names no light, or there is nowhere to put the file
 *   VXS_E_MEMORY       out of memory, or beyond memory_bytes
 *   VXS_E_READ, VXS_E_SCENE, VXS_E_UNSUPPORTED   of the scene's file
 *   VXS_E_NO_CASTER, VXS_E_NO_LIGHT              nothing casts, or there is nothing that shines
 *   VXS_E_WRITE        the output or the folder of resume_path cannot be written; nothing is left behind
 *   VXS_E_REFERENCES   more nodes than a file can hold
 *   VXS_E_INTERRUPTED  it was given up.
 * Threads: any number of bakes at once, from any threads, of scenes of their own or of one that they share. */
vxs_result vxs_bake(const vxs_bake_options *options, vxs_bake_bytes *file, char *error);

/* scenes that serve many bakes ------------------------------------------------------------------------------------------------ */

/* Read a scene and find out what of it casts and what is solid: most of what a bake at small resolutions takes. Jobs then do only what depends
 * on their lights.
 * scene    [out] NULL on failure; closed with vxs_bake_scene_close, after the jobs that use it
 * options  of the scene; lights are not looked at. Progress and warnings go where it says during the call. Arrays are copied; texts are
 *          borrowed until the scene is closed
 * error    as for vxs_bake
 * Returns what vxs_bake returns.   Threads: an open scene is only read: any number of jobs may use it at once. */
vxs_result vxs_bake_scene_open(vxs_bake_scene **scene, const vxs_bake_options *options, char *error);

/* Accepts NULL. */
void vxs_bake_scene_close(vxs_bake_scene *scene);

/* jobs ------------------------------------------------------------------------------------------------------------------------ */

/* A bake that can be given up from another thread, or be worked on for a while at a time. */

/* Check the options and make a job of them; no work is done yet.
 * job      [out] NULL on failure; closed with vxs_bake_job_close
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_MEMORY. */
vxs_result vxs_bake_job_open(vxs_bake_job **job, const vxs_bake_options *options, char *error);

/* Bake to the end, or go on from the last step to the end; on a job that has ended, nothing.   Returns what vxs_bake returns. */
vxs_result vxs_bake_job_run(vxs_bake_job *job);

typedef enum vxs_bake_state { VXS_BAKE_MORE, VXS_BAKE_DONE, VXS_BAKE_FAILED } vxs_bake_state;

/* Bake for about so long, and hold. Between steps no thread of the job runs: it waits, with all that it holds.
 * budget_ms  > 0, infinity too; the call ends this much later, or as soon as the job does. It takes longer by what is between two places where
 *            work can be held (docs/bake-library.md)
 * Returns VXS_BAKE_MORE; VXS_BAKE_DONE; VXS_BAKE_FAILED: vxs_bake_job_result says why, VXS_E_ARGUMENT for a budget that is none, after which the
 * job may go on.
 * Threads: one at a time for a job. The job's own threads work while the caller waits; the callbacks are called from one of them. */
vxs_bake_state vxs_bake_step(vxs_bake_job *job, double budget_ms);

/* Give a job up. It returns at once; the job ends with VXS_E_INTERRUPTED at one of the next places where it can, in the call that works on it, or
 * in the next one. Nothing is left of its output; what was there before stays. A job that has ended stays what it is.
 * Threads: any, at any time until vxs_bake_job_close is called. */
void vxs_bake_job_cancel(vxs_bake_job *job);

/* Of the last call: VXS_OK while there is more to do, and when it is done. */
vxs_result vxs_bake_job_result(const vxs_bake_job *job);

/* What is wrong, in one line; "" when nothing is. Valid until the next call for the job. */
const char *vxs_bake_job_error(const vxs_bake_job *job);

/* Take the file of a job that is done; the job has it no more.
 * file  [out] zeroed when there is none: the job is not done, it has failed, if_changed left the output as it was, or it was taken before */
void vxs_bake_job_take(vxs_bake_job *job, vxs_bake_bytes *file);

/* End a job; one that is not done is given up, and the call waits until it has ended. Accepts NULL. */
void vxs_bake_job_close(vxs_bake_job *job);

#ifdef __cplusplus
}
#endif
#endif
