/* libvxs_bake: runs what `vxs bake` runs, from a program. Use it to bake shadows at level load, or to bake again while a sun moves,
 * a little work in each frame.
 *
 *     vxs_bake_options o = vxs_bake_defaults();
 *     o.scene_path  = "level.glb";
 *     o.output_path = "level.vxs";
 *     o.log         = print; // void print(vxs_severity severity, const char *text, void *user)
 *     if (vxs_bake(&o, NULL) != VXS_OK) ...
 *
 * The same scene and options give the same bytes as the command does, at any number of threads and with any number of pauses.
 * Depths are computed straight from triangles. The library does not contain OpenGL, and has no option that needs it.
 *
 * The library has no state outside its objects. It never prints, exits or aborts, installs no signal handler, and does not change
 * the state of the process. One exception: if memory runs out while glTF is read, C++ ends the process, because the JSON library
 * allocates in a destructor.
 *
 * Licence: GPL-3.0-or-later, because the library contains CGAL, which has this licence. A program that is linked with it and
 * distributed is under the GPL. A game that only looks up shadows links libvxs (vxs.h), which is MIT. A level editor that is not
 * distributed may link this. docs/bake-library.md is the guide.
 * Public.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VXS_BAKE_H
#define VXS_BAKE_H

#include <stddef.h>
#include <stdint.h>

#include "vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* scenes as arrays ------------------------------------------------------------------------------------------------------------ */

/* Triangles of a scene. World space is that of glTF: metres, +Y up. */
typedef struct vxs_bake_mesh {
    const float    *positions; /* [3 * vertex_count] finite; metres from origin_ws */
    const uint32_t *indices;   /* [3 * triangle_count] < vertex_count, counter-clockwise as seen from outside; NULL: 0, 1, 2, ... */
    uint32_t        vertex_count;
    uint32_t        triangle_count;
    double          origin_ws[3]; /* finite; position of the mesh in the world. Floats are precise only near their origin */
    int             double_sided; /* 1: both sides are visible, so the mesh is no solid even where it is closed */
} vxs_bake_mesh;

typedef enum vxs_bake_light_kind { VXS_BAKE_DIRECTIONAL, VXS_BAKE_SPOT, VXS_BAKE_POINT } vxs_bake_light_kind;

typedef struct vxs_bake_light {
    const char         *name; /* UTF-8, 1 to 63 bytes; unique */
    vxs_bake_light_kind kind;
    double              position_ws[3];  /* metres; spot and point lights */
    double              direction_ws[3]; /* direction in which light travels, any length but zero; directional and spot lights */
    double              cos_outer;       /* spot lights: cosine of the angle between direction and edge of the cone, (0, 1) */
    double              range_metres;    /* spot and point lights: range, > 0; 0: unlimited */
} vxs_bake_light;

typedef struct vxs_bake_arrays {
    const vxs_bake_mesh  *meshes; /* [mesh_count] at least one */
    size_t                mesh_count;
    const vxs_bake_light *lights; /* [light_count] NULL: none; then options.suns must have some */
    size_t                light_count;
    const double *viewpoints_ws; /* [3 * viewpoint_count] possible camera positions: a component closed around one is no solid.
                                    NULL: none */
    size_t        viewpoint_count;
} vxs_bake_arrays;

/* options --------------------------------------------------------------------------------------------------------------------- */

/* A directional light. It is added, or replaces the scene's light of the same name: --sun NAME=X,Y,Z. */
typedef struct vxs_bake_sun {
    const char *name;            /* UTF-8, 1 to 63 bytes; NULL: "sun" */
    double      direction_ws[3]; /* direction in which sunlight travels, any length but zero */
} vxs_bake_sun;

/* Size of the maps of one light. Set one of the two: --resolution NAME=N, --texel NAME=METRES. */
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

/* Files of the caller, in place of those of the system: in memory, in an archive, or in a browser. Names are those of the options,
 * and of files to which a scene refers, relative to the scene's folder ("levels/" of "levels/a.gltf"). Called from the baking
 * thread. */
typedef struct vxs_bake_files {
    /* Size of a file in bytes; UINT64_MAX: there is no such file. */
    uint64_t (*size)(void *user, const char *name);
    /* Copy the whole file, size_bytes as `size` returned. Returns VXS_OK; other results, such as VXS_E_READ or VXS_E_MEMORY, end the bake. */
    vxs_result (*read)(void *user, const char *name, void *bytes, size_t size_bytes);
    /* Create or replace a file. Called once, with all bytes. Returns VXS_OK; other results, such as VXS_E_WRITE, end the bake. NULL: no
     * output_path may be given */
    vxs_result (*write)(void *user, const char *name, const void *bytes, size_t size_bytes);
    void *user;
} vxs_bake_files;

/* Progress of a bake. */
typedef struct vxs_bake_progress {
    double      share;        /* done share of the whole, 0 to 1; below 0: not known yet */
    double      seconds_left; /* remaining work, without pauses between steps; below 0: not known */
    const char *doing;        /* current work, "light sun: tile 3 of 16": one line, valid during the call */
} vxs_bake_progress;

/* Return 0 to go on, any other value to cancel the bake: it ends with VXS_E_INTERRUPTED. */
typedef int vxs_bake_progress_fn(void *user, const vxs_bake_progress *progress);

typedef struct vxs_bake_scene vxs_bake_scene;
typedef struct vxs_bake_job   vxs_bake_job;

/* Options of a bake. Begin with vxs_bake_defaults(): it sets the size of the struct, so that programs keep working with later
 * libraries, whose struct may be larger. In every field 0 or NULL is the default. Everything that pointers refer to is borrowed
 * until the end of the call, or of the scene or job that was opened with the options. Texts and paths have the form that they
 * have on the command line. */
typedef struct vxs_bake_options {
    size_t struct_size; /* set by vxs_bake_defaults */

    /* the scene: one of these three */
    const char            *scene_path; /* .gltf or .glb */
    const vxs_bake_arrays *arrays;
    const vxs_bake_scene  *scene; /* opened before, must outlive the job. All options down to `skinned` are then those of the
                                     opened scene */

    /* which objects cast shadows, and how */
    const char *const *exclude, *const *include; /* [count] patterns; files only: --exclude, --include */
    size_t           exclude_count, include_count;
    const char      *scene_name; /* scene of the file: --scene; NULL: its default scene */
    vxs_bake_closed  closed;     /* which closed components are solids: --closed */
    vxs_bake_skinned skinned;    /* --skinned */

    /* lights: all lights of the scene, unless names or suns are given */
    const char *const       *light_names; /* [light_name_count] */
    size_t                   light_name_count;
    const vxs_bake_sun      *suns; /* [sun_count] */
    size_t                   sun_count;
    uint32_t                 resolution;   /* texels a side, a power of two, 8 to 262144; 0: 4096, or from texel_metres */
    double                   texel_metres; /* 1e-9 to 1e9; 0: from resolution */
    const vxs_bake_map_size *map_sizes;    /* [map_size_count] lights with a size of their own */
    size_t                   map_size_count;
    int                      has_region;   /* 1: maps of suns cover only region_ws: --region */
    double                   region_ws[6]; /* min xyz, max xyz, metres */

    /* contents of the file */
    vxs_bake_exit   exit;
    int             behind_free;      /* 1: voxels behind the last surface are don't-care voxels: --behind free */
    double          thickness_metres; /* thickness of single-sided sheets that face the light, 1e-9 to 1e9; 0: none: --thickness */
    vxs_bake_coding coding;
    vxs_bake_pack   pack;        /* VXS_BAKE_BLOCKS only */
    uint32_t        zstd_level;  /* 1 to 19; 0: 12 */
    const char     *output_path; /* .vxs file; it is written completely or not at all. NULL: the bytes stay in memory */
    int             replace;     /* 1: replace also a read-only file, or one of several links to a file: --force */
    const char     *resume_path; /* folder of the square cache: --resume; NULL: no cache */
    int             if_changed;  /* 1: keep the file at output_path if this version baked it from the same input */

    /* how the bake runs; does not change the bytes */
    uint32_t threads;      /* 1 to 256; 0: all processors available to the process */
    uint64_t memory_bytes; /* limit of the memory of the whole process during the bake; 0: no limit */

    /* callbacks: called from the baking thread, never two at once for one job */
    vxs_bake_progress_fn *progress;
    /* Each call that fails logs one error, the reason; only without a valid struct_size it cannot. Equal warnings are logged once.
     * Texts have one line. They name options as the command does (--sun, --memory) */
    vxs_log_fn           *log;
    void                 *user; /* passed to both callbacks */

    /* since the second version of this struct; for a scene that is a file. An opened scene keeps its own */
    vxs_bake_blend blend;         /* materials with alphaMode BLEND: --blend */
    int            allow_outside; /* 1: buffers and images may be outside the scene's folder: --allow-outside */

    /* since the third version of this struct */
    const vxs_bake_files *files; /* of scene_path and output_path; NULL: files of the system. Excludes resume_path */
} vxs_bake_options;

static inline vxs_bake_options vxs_bake_defaults(void)
{
#ifdef __cplusplus
    vxs_bake_options o = vxs_bake_options();
#else
    vxs_bake_options o = {0};
#endif
    o.struct_size = sizeof o;
    return o;
}

/* A .vxs file in memory. */
typedef struct vxs_bake_bytes {
    uint8_t *data; /* owned by the caller; released with vxs_bake_bytes_free */
    size_t   size_bytes;
} vxs_bake_bytes;

/* Accepts a zeroed object, and leaves one. */
void vxs_bake_bytes_free(vxs_bake_bytes *bytes);

/* one call -------------------------------------------------------------------------------------------------------------------- */

/* Bake a scene; returns when the bake has ended.
 * options  output_path or file must be given, or both
 * file     [out] the asset; NULL: not wanted. Zeroed on failure, and if if_changed kept the output
 * Returns VXS_OK;
 *   VXS_E_ARGUMENT     an option is outside its range, excludes another one or names no light, or no output is given
 *   VXS_E_MEMORY       out of memory, or more than memory_bytes needed
 *   VXS_E_READ, VXS_E_SCENE, VXS_E_UNSUPPORTED   error in the scene's file
 *   VXS_E_NO_CASTER, VXS_E_NO_LIGHT              the scene has no caster, or no light
 *   VXS_E_WRITE        cannot write the output or the folder resume_path; no partial file is left
 *   VXS_E_REFERENCES   more nodes than a file can hold
 *   VXS_E_INTERRUPTED  the bake was cancelled.
 * Threads: any number of bakes at once, from any threads, with separate scenes or a shared one. */
vxs_result vxs_bake(const vxs_bake_options *options, vxs_bake_bytes *file);

/* scenes that serve many bakes ------------------------------------------------------------------------------------------------ */

/* Read a scene, and find its casters and solids. At small resolutions this is most of the work of a bake. Jobs on the scene then do
 * only the work that depends on their lights.
 * scene    [out] NULL on failure; closed with vxs_bake_scene_close, after the jobs that use it
 * options  of the scene; options of lights are ignored. Its callbacks are called during this call only. Arrays are
 *          copied; texts are borrowed until the scene is closed
 * Returns what vxs_bake returns.   Threads: an open scene is never changed: any number of jobs may use it at once. */
vxs_result vxs_bake_scene_open(vxs_bake_scene **scene, const vxs_bake_options *options);

/* Accepts NULL. */
void vxs_bake_scene_close(vxs_bake_scene *scene);

/* jobs ------------------------------------------------------------------------------------------------------------------------ */

/* A job is a bake that another thread can cancel, or that runs in steps of limited time. */

/* Check the options and make a job of them. The work begins later.
 * job      [out] NULL on failure; closed with vxs_bake_job_close
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_MEMORY. */
vxs_result vxs_bake_job_open(vxs_bake_job **job, const vxs_bake_options *options);

/* Bake to the end, from the begin or from the last step on. Does nothing on a job that has ended.
 * Returns what vxs_bake returns. */
vxs_result vxs_bake_job_run(vxs_bake_job *job);

typedef enum vxs_bake_state { VXS_BAKE_MORE, VXS_BAKE_DONE, VXS_BAKE_FAILED } vxs_bake_state;

/* Bake for about budget_ms, then pause. Between steps no thread of the job runs; the job keeps its memory.
 * budget_ms  > 0, may be infinite; the call returns after this time, or earlier when the job ends. It may take longer by the
 *            time between two
 *            places where work can pause (docs/bake-library.md)
 * Returns VXS_BAKE_MORE; VXS_BAKE_DONE; VXS_BAKE_FAILED: see vxs_bake_job_result. After VXS_E_ARGUMENT (invalid budget) the job
 * may go on.
 * Threads: one call at a time for a job. The job's own threads work while the caller waits, and one of them calls the callbacks.
 * A library built with `make threads=1` has no threads and cannot pause: the call runs to the end. */
vxs_bake_state vxs_bake_step(vxs_bake_job *job, double budget_ms);

/* Cancel a job. Returns at once. The job ends with VXS_E_INTERRUPTED at one of the next places where it can, in the call that is
 * running or in the next one. It leaves no output, and keeps a file that was there before. A job that has ended does not change.
 * Threads: any, at any time before vxs_bake_job_close is called. */
void vxs_bake_job_cancel(vxs_bake_job *job);

/* Result of the last call: VXS_OK while there is more to do, and when the job is done. */
vxs_result vxs_bake_job_result(const vxs_bake_job *job);

/* Take the file of a job that is done. The job does not keep a copy.
 * file  [out] zeroed if there is none: the job is not done or has failed, if_changed kept the output, or it was taken before */
void vxs_bake_job_take(vxs_bake_job *job, vxs_bake_bytes *file);

/* Close a job. A job that is not done is cancelled, and the call waits until it has ended. Logs nothing. Accepts NULL. */
void vxs_bake_job_close(vxs_bake_job *job);

#ifdef __cplusplus
}
#endif
#endif
