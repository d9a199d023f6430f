/* What tests/bench/volumes.c, smoke.c and area.c have in common: a picture that techniques draw, each with a knob, and a cell for
 * each setting of a knob, which is timed, and held against what is wanted. Of shadows in fog it is airlight, of smoke how much
 * light is left at places in it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VOLUMES_BENCH_H
#define VOLUMES_BENCH_H

#include <jansson.h>

#include "baker/base/run_context.h"
#include "baker/base/spread.h"
#include "baker/base/text.h"
#include "baker/casters/casters.h"
#include "baker/lab/command/fog_choice.h"
#include "baker/lab/truth/camera.h"
#include "baker/lab/truth/truth.h"
#include "runtime/volumes/vxs_volumes.h"
#include "runtime/vxs.h"
#include "tests/volumes/metrics.h"
#include "tests/volumes/sphere_parts.h"

enum { CAMERAS = 3, VALUES_MAX = 8, CELLS_MAX = 128, ROUNDS_MAX = 99, BEFORE_MAX = 2, PARTS = BEFORE_MAX + 1 };

/* Of OSMesa the processor's time, of all threads, is hardly disturbed by what else a machine does. CLOCK_TIMER: timestamps of the
 * graphics processor, without the time of the calls. */
typedef enum bench_clock { CLOCK_WALL, CLOCK_PROCESSOR, CLOCK_TIMER } bench_clock;

typedef struct bench     bench;
typedef struct technique technique;

struct bench {
    /* options */
    const char *scene_path, *asset_path, *light_name, *json_path;
    camera_pose pose;
    uint32_t    width, height, rounds, threads, values;
    text_list   cell_texts; /* TECHNIQUE:VALUE; none: all cells */
    gl_backend  backend;
    bench_clock clock;
    fog_choice  fog;
    int         is_of_spheres;

    /* what is measured, and how it is reported */
    const technique *techniques;
    size_t           technique_count;
    const char      *reference, *parts[PARTS];             /* of a frame, in order; NULL: there are none before the last */
    void (*describe)(const bench *b, json_t **scene);      /* adds what else JSON says */
    double (*value_of)(const float pixel[4], int channel); /* of what is drawn, for what is wanted */
    unsigned          picture;                             /* a texture of width x height: what is drawn */
    uint32_t          cameras;                             /* CAMERAS, or 1: there is no flicker */
    int               has_creation;                        /* 1: what a view of one pixel takes is reported, too */
    size_t            pixels;
    vxs_volumes_frame frames[CAMERAS];
    double           *wanted;  /* [cameras][pixels][3]; NaN: this pixel is not compared */
    uint8_t          *classes; /* [pixels] of the first camera; NULL: all are alike */

    /* what it is drawn with */
    vxs_asset   *asset;
    gl_context  *gl;
    vxs_gl      *shadows;
    vxs_volumes *volumes;

    /* a light of a scene in fog, seen from a camera, and from others a third of a texel of the light's map aside */
    double                far_metres, radius_metres;
    fog_medium            medium;
    scene                 scene;
    casters               casting;
    truth                *truth;
    lit_spheres           spheres; /* of a scene that is of nothing else */
    uint32_t              number;  /* of the light */
    vxs_volumes_light     light;
    vxs_shadow_depth_map *map; /* as fine as the baked one */

    struct smoke *smoke; /* smoke.c */
    struct area  *area;  /* area.c */
};

typedef vxs_result technique_step(bench *b, void *state, uint32_t value);

/* What is drawn, by what knob; values end with 0. */
struct technique {
    const char *name, *knob;
    const char *limit; /* what it comes to as its knob grows; test_rival_volumes.c, _curves.c and _areas.c show that rivals do */
    int         is_rival;
    uint32_t    values[VALUES_MAX + 1];
    vxs_result (*open)(bench *b, void **state,
                       uint32_t value); /* before the first round: what a level or a size is made ready by; NULL: nothing */
    technique_step *draw;               /* what a frame does */
    void (*close)(void *state);         /* NULL: nothing */
    technique_step *before[BEFORE_MAX]; /* what it does before, and is distinguished; NULL: nothing */
    double (*bytes)(const bench *b, const void *state,
                    uint32_t value); /* of a texel, for lookups, in the mean; NULL: it is not reported */
};

/* The options of all benches. */
/* clang-format off */
#define BENCH_ROWS(b)                                                                                                              \
    {"--width", OPTION_U32, &(b).width, 16, 4096, NULL, "PX", "default 160", NULL},                                                \
    {"--height", OPTION_U32, &(b).height, 16, 4096, NULL, "PX", "default 90", NULL},                                               \
    {"--rounds", OPTION_U32, &(b).rounds, 1, ROUNDS_MAX, NULL, "N", "default 7", NULL},                                            \
    {"--values", OPTION_U32, &(b).values, 1, VALUES_MAX, NULL, "N", "of each knob, the first N (default all)", NULL},              \
    {"--gl", OPTION_CHOICE, &(b).backend, 0, 0, "osmesa|egl", NULL, "whose OpenGL draws (default osmesa)", NULL},                  \
    {"--cell", OPTION_TEXTS, &(b).cell_texts, 0, 0, NULL, "TECHNIQUE:VALUE", "measure this alone; repeat for more", NULL},         \
    {"--clock", OPTION_CHOICE, &(b).clock, 0, 0, "wall|processor|timer", NULL,                                                     \
     "what is measured; timer: of the graphics processor (default wall)", NULL},                                                   \
    {"--threads", OPTION_U32, &(b).threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads", NULL},                                  \
    {"--json", OPTION_OUTPUT, &(b).json_path, 0, 0, ".json", "FILE.json", "figures as JSON", NULL}
#define BENCH_DEFAULTS                                                                                                             \
    .width = 160, .height = 90, .rounds = 7, .values = VALUES_MAX, .threads = parallel_default_threads(), .cameras = CAMERAS,      \
    .value_of = volumes_colour
/* clang-format on */

/* A channel as it is. */
double volumes_colour(const float pixel[4], int channel);

/* What draws the shadows of b->asset, seen from b->pose. */
vxs_result volumes_open_gl(bench *b, run_context *m);
void       volumes_close_gl(bench *b);

/* The scene of b->scene_path, what in it casts, and room for pictures. */
vxs_result volumes_load_scene(bench *b, run_context *m);
void       volumes_free_scene(bench *b);

/* What casts, in floats, places from the eye.   [3 * casting.vertex_count]; owned by the caller; NULL: out of memory */
float *volumes_casters_from_eye(const bench *b);

/* A map of a baked light, filled. side_px  0: as fine as the baked one */
vxs_result volumes_open_map(const bench *b, uint32_t number, uint32_t side_px, vxs_shadow_depth_map **map);

/* Find the spheres that a light's rays may meet: of each component, unless the light is in it. The axes' ends are among its
 * corners. */
vxs_result volumes_find_spheres(bench *b, run_context *m);

/* What is wanted of an eye ray.   to  [3] [in, out] 0 */
typedef void wanted_of_ray(const bench *b, const double eye_ws[3], const double direction[3], double metres, size_t ray,
                           double to[3]);

/* Fill frames[camera], with the depths of what is seen there, and what is wanted; of the first camera, the classes of its
 * pixels. */
vxs_result volumes_see(bench *b, uint32_t camera, wanted_of_ray *wanted, run_context *m);

/* Of the light: what shines between exact lit intervals of the asset, or of rays among spheres. */
wanted_of_ray volumes_airlight_wanted;

/* Where it is seen from, and the fog: a bench's describe. */
void volumes_describe_view(const bench *b, json_t **scene);

/* Every technique of fog, and every rival, of one light. */
void volumes_use_techniques(bench *b);

/* A technique with one setting of its knob, how long it takes, and how near it comes. */
typedef struct cell {
    const technique *technique;
    uint32_t         value;
    void            *state;
    double           seconds[ROUNDS_MAX], parts[PARTS][ROUNDS_MAX], creation[ROUNDS_MAX], open_seconds;
    double           part_medians[PARTS], creation_median;
    spread           spread;
    picture_error    all, elsewhere, epipole;
    double           flicker, bytes;
    double           behind; /* how many times as long it takes as the quickest that is as near: 1 on the front */
    int              is_refused;
} cell;

/* Make each cell of b's techniques ready, draw all of them in turn, round after round, hold what they draw against what is wanted,
 * and report. */
vxs_result volumes_measure(bench *b, run_context *m);

/* Print a table, and write JSON where a path is given. */
vxs_result volumes_report(const bench *b, const cell *cells, size_t count, run_context *m);

#endif
