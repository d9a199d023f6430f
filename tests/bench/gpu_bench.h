/* Parts of tests/bench/gpu.c: times of frames on a graphics processor, of lookups, lists of lights and fog, beside their rivals.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GPU_BENCH_H
#define GPU_BENCH_H

#include "baker/lab/opengl/gl.h"

#include <jansson.h>

#include "baker/base/run_context.h"
#include "baker/base/spread.h"
#include "baker/base/text.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/vxs.h"

enum { GPU_VIEWS_MAX = 8, GPU_RUNS_MAX = 501 };

/* Filters that lookups are measured with. */
typedef enum gpu_filter { GPU_TAP, GPU_BOX_3, GPU_BOX_9, GPU_SMOOTH_9, GPU_FILTERS } gpu_filter;
extern const char *const gpu_filter_names[GPU_FILTERS];
extern const char *const gpu_filter_texts[GPU_FILTERS];

/* A camera and what it sees. */
typedef struct gpu_view {
    char     name[64];
    double   eye_ws[3], target_ws[3];
    vxs_view view;                       /* positions relative to the eye */
    GLuint   positions, normals, depths; /* RGBA32F, w 0 where nothing is seen; RGBA32F; R32F */
    float   *lit[GPU_FILTERS];           /* [pixels] answers of the asset that rivals are compared with; owned; NULL: none yet */
} gpu_view;

/* Functions that gl_context does not have. */
#define GPU_FUNCTIONS(X)                                                                                                           \
    X(PFNGLBEGINQUERYPROC, BeginQuery)                                                                                             \
    X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                                                                                   \
    X(PFNGLENDQUERYPROC, EndQuery)                                                                                                 \
    X(PFNGLFRAMEBUFFERPARAMETERIPROC, FramebufferParameteri)                                                                       \
    X(PFNGLGENQUERIESPROC, GenQueries)                                                                                             \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                                                 \
    X(PFNGLGETQUERYOBJECTUI64VPROC, GetQueryObjectui64v)                                                                           \
    X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)

typedef struct gpu_bench {
    /* options */
    const char *scene_path, *json_path;
    text_list   asset_paths, view_texts;
    uint32_t    width_px, height_px, runs, warm_ms, threads;
    double      fov_degrees, fog_per_metre;
    int         clock;         /* gpu_clock */
    int         storage, only; /* 1: buffers alone; GPU_ONLY_* */
    int         is_fragment;   /* 1: fragment shaders answer in place of compute shaders */

    gl_context *gl;
#define GPU_POINTER(type, name) type name;
    GPU_FUNCTIONS(GPU_POINTER)
#undef GPU_POINTER
    GLuint   query, answers; /* the second: a buffer of [pixels] floats */
    size_t   pixels;
    gpu_view views[GPU_VIEWS_MAX];
    size_t   view_count;
    json_t  *rows; /* docs/gpu.schema.json */
} gpu_bench;

typedef enum gpu_only { GPU_ALL, GPU_ONLY_FOG, GPU_ONLY_LISTS } gpu_only;

typedef enum gpu_clock { GPU_CLOCK_AUTO, GPU_CLOCK_TIMER, GPU_CLOCK_WALL } gpu_clock;

/* Figures of a row besides its time. Fields that are not set are absent from the row. */
typedef struct gpu_row {
    const char  *group;                 /* rows of a group are compared: "9 x 9 box", "lights", "fog" */
    const char  *name;                  /* "blocks, buffer" */
    uint32_t     resolution_px;         /* of the maps */
    double       bytes;                 /* that the lookup reads from: words or texels; 0: not known */
    const float *wanted;                /* [pixels] compared with the answers; NULL: not compared */
    float        tolerance;             /* of that comparison */
    int          has_error, has_listed; /* the next two are set */
    double       error, listed;         /* relative RMS difference to exact intervals; lights in the list of a pixel, mean */
} gpu_row;

/* Time frames and add a row. First frames are drawn for warm_ms milliseconds, so that clocks are at their top.
 * frame  draws once; returns VXS_OK or the reason why it cannot */
vxs_result gpu_measure(gpu_bench *b, const gpu_view *view, const gpu_row *row, vxs_result (*frame)(gpu_bench *b, void *user),
                       void *user, run_context *m);

/* A program that answers for each pixel of a view: the texts of shadows, then
 * body  defines float answer_of(ivec2 pixel, vec3 at, vec3 normal) */
vxs_result gpu_program(gpu_bench *b, const vxs_gl *shadows, const char *defines, const char *body, GLuint *program, run_context *m);

/* Use such a program for a view. */
void gpu_use(gpu_bench *b, vxs_gl *shadows, GLuint program, const gpu_view *view);

/* Run a program for all pixels of a view. */
typedef struct gpu_dispatch {
    const vxs_gl   *shadows;
    const gpu_view *view;
    GLuint          program;
} gpu_dispatch;
vxs_result gpu_dispatch_frame(gpu_bench *b, void *dispatch);

/* The answers of the last dispatch.   answers  [out] [pixels] */
void gpu_answers(gpu_bench *b, float *answers);

/* Words and lights of an asset on the graphics processor. */
vxs_result gpu_shadows(gpu_bench *b, const vxs_asset *asset, vxs_gl_storage storage, uint64_t most_table_bytes, vxs_gl **shadows,
                       run_context *m);

/* The same of any lights.   desc  its functions of OpenGL are set here */
vxs_result gpu_shadows_of(gpu_bench *b, vxs_gl_desc *desc, vxs_gl **shadows, run_context *m);

/* Measurements, in all views: of an asset with one light, of depth maps with its depths, of several lights, of fog in an
 * asset with one light.
 * is_first  the first asset of its resolution: its answers are kept */
vxs_result gpu_measure_lookups(gpu_bench *b, const vxs_asset *asset, int is_first, run_context *m);
vxs_result gpu_measure_pages(gpu_bench *b, const vxs_asset *asset, run_context *m);
vxs_result gpu_measure_rivals(gpu_bench *b, const vxs_asset *asset, run_context *m);
vxs_result gpu_measure_lights(gpu_bench *b, const vxs_baked_light *const *lights, uint32_t count, run_context *m);
vxs_result gpu_measure_fog(gpu_bench *b, const vxs_asset *asset, run_context *m);

/* Print the rows and write JSON. Marks m as wrong where answers differ. */
vxs_result gpu_report(gpu_bench *b, run_context *m);

#endif
