/* Random questions about airlight of punctual lights, to C and to a shader, and errors of answers. Included behind cmocka.h and
 * gl_points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AIR_QUESTIONS_H
#define AIR_QUESTIONS_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "random_light.h"
#include "read_text.h"
#include "runtime/volumes/vxs_air.h"
#include "runtime/volumes/vxs_air_path.h"
#include "tests/volumes/airlight.h"

/* Uniform in the logarithm. */
static inline double spread(rng *r, double low, double high)
{
    return exp(uniform(r, log(low), log(high)));
}

/* A question to C and to a shader alike: floats, as the shader reads them. */
typedef struct question {
    float to_light[3], radius;
    float direction[3], begin;
    float axis[3], length; /* of a spot light; 0: of a point light */
    float scattering[3], anisotropy;
    float extinction[3], cos_inner;
    float cos_outer, has_top, top, in_fog; /* top: from the eye's height, along y; in_fog: where the ray comes into the fog */
    float range, unused[3];                /* 0: none */
} question;

static inline air_passing passing_of(const question *q)
{
    double w[3], l[3], axis[3];
    for (int i = 0; i < 3; i++) {
        w[i]    = q->direction[i];
        l[i]    = q->to_light[i];
        axis[i] = q->axis[i];
    }
    air_passing p = air_passing_of(w, l, q->radius, q->cos_inner > 0 ? axis : NULL, q->cos_inner, q->cos_outer);
    p.has_top     = q->has_top > 0;
    p.range       = q->range;
    p.up          = w[1];
    p.top         = q->in_fog > 0 ? p.up * (double)q->in_fog : (double)q->top; /* as the rounded place has it */
    p.punctual    = p.top + l[1] - (double)q->top;
    return p;
}

static inline void reference(const question *q, double airlight[3])
{
    air_passing p = passing_of(q);
    for (int i = 0; i < 3; i++)
        airlight[i] = (double)q->scattering[i] * air_of_punctual(&p, q->anisotropy, q->extinction[i], q->begin, q->length);
}

/* The same for runtime/volumes. */
static inline void ask_c(const question *q, vxs_medium *medium, vxs_air_ray *ray)
{
    double to_light[3], direction[3], axis[3];
    for (int i = 0; i < 3; i++) {
        to_light[i]           = q->to_light[i];
        direction[i]          = q->direction[i];
        axis[i]               = q->axis[i];
        medium->scattering[i] = q->scattering[i];
        medium->extinction[i] = q->extinction[i];
    }
    medium->anisotropy = q->anisotropy;
    *ray               = q->cos_inner > 0 ? vxs_air_ray_of_spot(to_light, direction, q->radius, axis, q->cos_inner, q->cos_outer)
                                          : vxs_air_ray_of(to_light, direction, q->radius);
    if (q->has_top > 0) vxs_air_below_top(ray, to_light[1], direction[1], q->top, q->in_fog);
    if (q->range > 0) ray->per_range = 1 / (double)q->range;
}

/* Any ray: the light before the eye, behind it, at it, on the ray; short and endless pieces; thin air and ink.
 * least_beside  of the light's distance */
static inline question random_question(rng *r, double least_beside, int spots)
{
    question q = {0};
    double   w[3], side[3], axis[3], along, beside, size = spread(r, 1e-2, 1e5), dot = 0, length = 0;
    random_direction(r, w);
    random_direction(r, side);
    random_direction(r, axis);
    for (int i = 0; i < 3; i++) dot += w[i] * side[i];
    for (int i = 0; i < 3; i++) side[i] -= dot * w[i];
    for (int i = 0; i < 3; i++) length += side[i] * side[i];
    along    = size * (rng_below(r, 8) ? uniform(r, -1, 1) : 0);
    beside   = rng_below(r, 8) ? size * spread(r, least_beside, 10) : 0;
    q.radius = (float)(size * spread(r, least_beside, 1e-1));
    for (int i = 0; i < 3; i++) {
        q.direction[i] = (float)w[i];
        q.to_light[i]  = (float)(along * w[i] + beside * side[i] / sqrt(length));
        q.axis[i]      = (float)axis[i];
    }
    q.begin     = (float)(rng_below(r, 3) ? size * spread(r, 1e-3, 3) : 0);
    q.length    = (float)(rng_below(r, 8) ? size * spread(r, 1e-7, 10) : size * 1e3);
    double most = spread(r, 1e-6, 1e4) / hypot(along, fmax(beside, (double)q.radius));
    int    grey = rng_below(r, 2) == 0;
    for (int i = 0; i < 3; i++) {
        q.extinction[i] = (float)(grey ? most : most * spread(r, 1e-2, 1));
        q.scattering[i] = q.extinction[i] * (rng_below(r, 8) ? (float)rng_unit(r) : 0);
    }
    if (!rng_below(r, 16)) q.scattering[0] = q.extinction[0] = 0;
    q.anisotropy = rng_below(r, 3) ? (float)uniform(r, -0.99, 0.99) : rng_below(r, 2) ? 0 : 0.99F;
    if (spots) {
        double outer = uniform(r, 0.05, M_PI / 2), inner = outer * uniform(r, 0, 0.9);
        q.cos_outer = (float)cos(outer);
        q.cos_inner = (float)cos(inner);
    }
    return q;
}

/* The same in fog with a level top below the light, near it or far, in which a part of the ray is. */
static inline question random_question_below(rng *r, double least_beside, int spots)
{
    for (;;) {
        question q    = random_question(r, least_beside, spots);
        double   size = hypot(hypot(q.to_light[0], q.to_light[1]), hypot(q.to_light[2], q.radius));
        q.has_top     = 1;
        q.top         = q.to_light[1] - (float)(rng_below(r, 8) ? size * spread(r, 1e-4, 10) : 0);
        double all[2] = {0, INFINITY}, part[2] = {(double)q.begin, (double)q.begin + (double)q.length};
        vxs_air_in_fog(0, (double)q.direction[1], (double)q.top, all);
        vxs_air_in_fog(0, (double)q.direction[1], (double)q.top, part);
        if (!(part[1] > part[0])) continue;
        q.in_fog = (float)all[0];
        q.begin  = fmaxf((float)part[0], q.in_fog);
        q.length = (float)((part[1] - (double)q.begin) * (1 - 1e-6));
        if (q.length > 0) return q;
    }
}

/* What of a question is in a range that ends somewhere in its segment, or behind it. */
static inline question in_some_range(rng *r, question q)
{
    air_passing p = passing_of(&q);
    for (;;) {
        double y = (double)q.begin + uniform(r, 0, (double)q.length) - p.along, range = hypot(p.beside, y), part[2];
        if (rng_below(r, 2)) range *= spread(r, 1, 30);
        part[0] = (double)q.begin;
        part[1] = (double)q.begin + (double)q.length;
        vxs_air_in_range(p.along, p.beside * p.beside, range, part);
        question found = q;
        found.range    = (float)range;
        found.begin    = fmaxf((float)part[0], q.begin);
        found.length   = (float)((part[1] - (double)found.begin) * (1 - 1e-6));
        if (found.length > 0) return found;
    }
}

static inline question random_question_in_range(rng *r, double least_beside, int spots)
{
    return in_some_range(r, random_question(r, least_beside, spots));
}

static inline question random_question_below_in_range(rng *r, double least_beside, int spots)
{
    return in_some_range(r, random_question_below(r, least_beside, spots));
}

typedef struct errors {
    double   most, sum;
    uint32_t count, large; /* channels; those with an error of 1e-3 and more */
} errors;

/* Errors of what a spot light adds, or a punctual light with a range, count relative to a hundredth of what a point light without
 * one would, where that is more: a ray that grazes its cone sees nothing, and at the end of its range there is nothing. Channels do
 * not count of which fog leaves less than 1e-8 before the segment begins. */
static inline void count_errors(errors *e, const question *q, const double found[3])
{
    double      wanted[3], all[3] = {0};
    question    point   = *q;
    air_passing passing = passing_of(q);
    double      way     = fmin(air_way_of(&passing, (double)q->begin), air_way_of(&passing, (double)q->begin + (double)q->length));
    point.cos_inner = point.range = 0;
    reference(q, wanted);
    if (q->cos_inner > 0 || q->range > 0) reference(&point, all);
    for (int i = 0; i < 3; i++) {
        assert_true(isfinite(found[i]) && found[i] >= 0);
        if (q->scattering[i] == 0) assert_true(found[i] == 0);
        double scale = fmax(wanted[i], all[i] / 100);
        if (!(scale > 1e-30) || (double)q->extinction[i] * way > 18) continue;
        double error = fabs(found[i] - wanted[i]) / scale;
        e->sum += error;
        e->count++;
        e->large += error >= 1e-3;
        e->most = fmax(e->most, error);
    }
}

/* mean, share  of relative errors, and of those of 1e-3 and more */
static inline void check_errors(const errors *e, double most, double mean, double share, uint32_t least_count)
{
    print_message("%u channels: relative error %.1e at most, %.1e in the mean, 1e-3 and more in %.2f %%\n", e->count, e->most,
                  e->sum / e->count, 100.0 * e->large / e->count);
    assert_true(e->count >= least_count);
    assert_true(e->most < most);
    assert_true(e->sum < mean * e->count);
    assert_true(e->large < share * e->count);
}

/* A point of gl_points.h requests one channel of a question. */
static const char air_ask_text[] = "struct question { vec4 lamp, way, axis, scattering, extinction, rest, more; };\n"
                                   "layout(std430, binding = 0) readonly buffer asked { question questions[]; };\n"
                                   "flat in int vertex;\n"
                                   "out float answer;\n"
                                   "void main() {\n"
                                   "    question q = questions[vertex / 3];\n"
                                   "    vxs_medium medium = vxs_medium(q.scattering.xyz, q.extinction.xyz, q.scattering.w);\n"
                                   "    vxs_air_ray ray = vxs_air_ray_of(q.lamp.xyz, q.way.xyz, q.lamp.w);\n"
                                   "    if (q.extinction.w > 0.0) ray = vxs_air_ray_of_spot(q.lamp.xyz, q.way.xyz, q.lamp.w,\n"
                                   "                                        q.axis.xyz, q.extinction.w, q.rest.x);\n"
                                   "    if (q.rest.y > 0.0) vxs_air_below_top(ray, q.lamp.y, q.way.y, q.rest.z, q.rest.w);\n"
                                   "    if (q.more.x > 0.0) ray.per_range = 1.0 / q.more.x;\n"
                                   "    vec3 airlight;\n"
                                   "    ask_lamp(medium, ray, q.way.w, q.axis.w, airlight);\n"
                                   "    answer = airlight[vertex % 3];\n"
                                   "}\n";

/* ask_punctual  text that defines this function, as vxs_air_punctual */
static inline void use_air(drawing *d, const char *ask_punctual)
{
    const char *paths[] = {"formats/vxs_lookup.h",          "formats/vxs_lookup_blocks.h",
                           "formats/vxs_space.h",           "runtime/volumes/vxs_air_light.h",
                           "runtime/volumes/vxs_air_ray.h", "runtime/volumes/vxs_air.h"};
    enum { PATHS = sizeof paths / sizeof *paths };
    char       *texts[PATHS];
    const char *all[PATHS + 3] = {"#version 430\n#define vxs_word(dag, i) 0u\n"};
    for (int n = 0; n < PATHS; n++) all[n + 1] = texts[n] = read_text(paths[n]);
    all[PATHS + 1] = ask_punctual;
    all[PATHS + 2] = air_ask_text;
    use_texts(d, "vxs_air.h", "#version 430", all, PATHS + 3);
    for (int n = 0; n < PATHS; n++) free(texts[n]);
}

#endif
