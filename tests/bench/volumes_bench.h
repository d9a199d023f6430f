/* The parts of tests/bench/volumes.c: what is measured, the techniques with their knobs, and a cell for each setting of a knob.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VOLUMES_BENCH_H
#define VOLUMES_BENCH_H

#include "baker/base/message.h"
#include "baker/casters/casters.h"
#include "baker/measure/spread.h"
#include "baker/options/fog_choice.h"
#include "baker/truth/camera.h"
#include "baker/truth/truth.h"
#include "runtime/volumes/vxs_volumes.h"
#include "runtime/vxs.h"
#include "tests/volumes/metrics.h"
#include "tests/volumes/sphere_parts.h"

enum { CAMERAS = 3, VALUES_MAX = 8, CELLS_MAX = 128, ROUNDS_MAX = 99 };

/* A light of a scene in fog, seen from a camera, and from others a third of a texel of the light's map aside. */
typedef struct bench {
    const char    *scene_path, *asset_path, *light_name, *json_path;
    camera_pose    pose;
    uint32_t       width, height, rounds, threads, values;
    gl_backend     backend;
    fog_choice     fog;
    int            is_of_spheres;
    double         far_metres, radius_metres;
    fog_medium     medium;
    scene          scene;
    casters        casting;
    truth         *truth;
    lit_spheres    spheres; /* of a scene that is of nothing else */
    vxs_asset     *asset;
    uint32_t       number; /* of the light */
    gl_context    *gl;
    vxs_gl        *shadows;
    vxs_volumes   *volumes;
    vxs_light_map *map; /* as fine as the baked one */

    size_t            pixels;
    vxs_volumes_frame frames[CAMERAS];
    double           *wanted;  /* [CAMERAS][pixels][3] */
    uint8_t          *classes; /* [pixels] of the first camera */
} bench;

/* What is drawn, by what knob; values end with 0. */
typedef struct technique {
    const char *name, *knob;
    const char *limit; /* what it comes to as its knob grows; of rivals, test_rival_volumes.c shows that they do */
    int         is_rival;
    uint32_t    values[VALUES_MAX + 1];
    vxs_result (*open)(bench *b, void **state,
                       uint32_t value); /* before the first round: what a level or a size is made ready by */
    vxs_result (*draw)(bench *b, const vxs_volumes_light *light, void *state, uint32_t value); /* what a frame does */
    void (*close)(void *state);
} technique;

extern const technique volumes_techniques[];
extern const size_t    volumes_technique_count;

/* Find the spheres that a light's rays may meet: of each component, unless the light is in it. The axes' ends are among its corners. */
vxs_result volumes_find_spheres(bench *b, message *m);

/* Fill frames[camera], with the depths of what is seen there, and what airlight is wanted; of the first camera, the classes of its pixels. */
vxs_result volumes_see(bench *b, int camera, message *m);

/* A technique with one setting of its knob, how long it takes, and how near it comes. */
typedef struct cell {
    const technique *technique;
    uint32_t         value;
    void            *state;
    double           seconds[ROUNDS_MAX], open_seconds;
    spread           spread;
    picture_error    all, elsewhere, epipole;
    double           flicker;
    double           behind; /* how many times as long it takes as the quickest that is as near: 1 on the front */
    int              is_refused;
} cell;

/* Make each cell ready.   cells [CELLS_MAX], count [in, out] */
void volumes_open_cells(bench *b, cell *cells, size_t *count);

/* Draw all of them in turn, round after round; those that take over a second, in three. */
vxs_result volumes_time_cells(bench *b, cell *cells, size_t count, message *m);

/* Hold what a cell draws, from each camera, against what is wanted. */
vxs_result volumes_judge(bench *b, cell *c, message *m);

/* How far each is behind the front, which is made of those that nothing as near is faster than. */
void volumes_find_front(cell *cells, size_t count);

/* Print a table, and write JSON where a path says so. */
vxs_result volumes_report(const bench *b, const cell *cells, size_t count, message *m);

#endif
