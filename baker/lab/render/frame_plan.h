/* The plan of a frame: passes and methods for each light, and passes that are left out, with reasons; its text and JSON.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FRAME_PLAN_H
#define FRAME_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

/* fog -------------------------------------------------------------------------------------------------------------------------- */

/* How lit intervals of the fog are found. */
typedef enum fog_by { FOG_BY_MARCH, FOG_BY_ANGLES, FOG_BY_INTERVALS, FOG_BY_MESH, FOG_BY_GRID } fog_by;
#define FOG_BY_CHOICES "march|angles|intervals|mesh|grid" /* their words, in that order */
extern const char *const fog_by_names[];

/* Airlight that is not worth a pass, where 1 is white: half of one of a screen's 255 steps near black, where they are finest:
 * 1 / (2 * 255 * 12.92). It bounds the sum of all airlight that is left out in a pixel: one half for whole lights, one half for
 * pixels of the other lights. */
#define FOG_FAINTEST (1.0 / 6600)

/* The decision on a light in a frame. */
typedef enum fog_cull_result {
    FOG_DRAWN,
    FOG_FAINT,       /* left out: the sum of all such lights is below half of FOG_FAINTEST, in any direction of view */
    FOG_OUT_OF_VIEW, /* left out: the same, but only in the pixels of this view */
    FOG_CLEAR,       /* left out: the light, or all visible space, is above the fog's top; or the sun is below the horizon */
    FOG_CULL_RESULTS
} fog_cull_result;

typedef struct fog_plan {
    uint32_t lights[FOG_CULL_RESULTS];
    uint32_t by_angles;         /* lights drawn by equiangular steps instead of the requested method */
    uint32_t shadow_depth_maps; /* lights drawn by maps that are joined with moving casters */
    uint32_t meshes_made;       /* for FOG_BY_MESH: all meshes made so far, including this frame */
} fog_plan;

/* Of one light. */
typedef struct fog_light_plan {
    fog_cull_result cull_result;
    double          share; /* share of the picture that is drawn for it: a rectangle around its cone, range and airlight above the
                          threshold */
    fog_by          by;    /* the method that is used */
    const char     *why;   /* why it is not the requested method; NULL: it is */
} fog_light_plan;

/* A saving of a frame, and its reason; "" ends the list. */
typedef struct fog_saving {
    char left_out[64], reason[160];
} fog_saving;

enum { FOG_SAVINGS = 4 };

/* Print a line; with `verbose` also the savings, and a line for each light. */
void fog_plan_print(FILE *to, const fog_plan *plan, fog_by by, const fog_light_plan *lights, const vxs_baked_light *const *names,
                    uint32_t light_count, int verbose);

/* For a frame: the number of lights with each decision. */
json_t *fog_plan_counts(const fog_plan *plan);

/* For the picture: each light, and the savings. */
json_t *fog_plan_lights(const fog_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count);
json_t *fog_plan_left_out(const fog_plan *plan, fog_by by, uint32_t light_count);

/* smoke ------------------------------------------------------------------------------------------------------------------------ */

/* The decision on a light. */
typedef enum smoke_cull_result {
    SMOKE_DIMS,
    SMOKE_OUT_OF_REACH, /* no capsule is in its range, cone or prism */
    SMOKE_OUT_OF_VIEW,  /* its range is not in view */
    SMOKE_NO_ROOM,      /* all maps are taken */
    SMOKE_CULL_RESULTS
} smoke_cull_result;

/* The plan of one light. A built map stays. */
typedef struct smoke_light_plan {
    smoke_cull_result cull_result;
    uint32_t          segments, merged, cut_texels; /* of its map, as in vxs_transmittance_counts */
} smoke_light_plan;

typedef struct smoke_plan {
    uint32_t lights[SMOKE_CULL_RESULTS];
    uint32_t built; /* maps, in this frame */
} smoke_plan;

/* A line; with `verbose` a line for each light.   capsules  of the scene;   side_px  of maps */
void smoke_plan_print(FILE *to, const smoke_plan *plan, uint32_t capsules, uint32_t side_px, const smoke_light_plan *lights,
                      const vxs_baked_light *const *names, uint32_t light_count, int verbose);

/* For a frame: the number of lights with each decision, and of maps that were built. */
json_t *smoke_plan_counts(const smoke_plan *plan);

/* Of the picture: each light. */
json_t *smoke_plan_lights(const smoke_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count);

/* virtual lights, of area lights or of a sky ----------------------------------------------------------------------------------- */

typedef struct vpl_words {
    const char *gather;               /* its word */
    uint32_t    points;               /* that cast shadows */
    int         baked;                /* they are those of the asset */
    uint32_t    capsules, smoke_side; /* capsules of smoke that dims the light, and the side of each virtual light's smoke map */
    int         baked_smoke;          /* 1: the asset has baked smoke for its own lights, which does not dim virtual lights */
} vpl_words;

/* area lights: which emissive parallelograms of a scene get virtual lights, and how many --------------------------------------- */

/* The decision on a parallelogram in a frame. */
typedef enum area_cull_result {
    AREA_DRAWN,
    AREA_FAINT,  /* left out: black, or brighter ones have all virtual lights */
    AREA_BEHIND, /* left out: all visible space is behind it */
    AREA_CULL_RESULTS
} area_cull_result;

typedef struct area_share {
    area_cull_result cull_result;
    uint32_t         vpls; /* 0 unless it is drawn */
} area_share;

typedef struct area_plan {
    uint32_t areas[AREA_CULL_RESULTS], vpls;
} area_plan;

/* Data for the text and JSON of a plan. */
typedef struct area_words {
    const scene      *scene;
    const area_share *shares; /* [scene->area_count] of the last frame */
    vpl_words         lit;
} area_words;

/* Print a line; with `verbose` a line for each parallelogram, and for emissive surfaces that are not parallelograms. */
void area_plan_print(FILE *to, const area_plan *plan, const area_words *w, int verbose);

/* Counts of decisions in a frame; all data of the picture's plan. */
json_t *area_plan_counts(const area_plan *plan);
json_t *area_plan_json(const area_plan *plan, const area_words *w);

/* a sky ------------------------------------------------------------------------------------------------------------------------ */

typedef struct sky_words {
    const char *path;
    uint32_t    wide_px, high_px;
    double      light, turn_degrees; /* light: factor on radiance; turn_degrees: of the map */
    uint32_t    vpls;
    vpl_words   lit;
} sky_words;

/* Print a line; with `verbose` more lines. */
void sky_plan_print(FILE *to, const sky_words *w, int verbose);

json_t *sky_plan_json(const sky_words *w);

#endif
