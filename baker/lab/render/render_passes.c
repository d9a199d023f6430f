/* The passes of a frame as pictures; see render_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/render_report.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/base/memory.h"
#include "baker/base/parallel.h"
#include "baker/base/srgb.h"
#include "baker/base/vec3.h"
#include "baker/files/output_file.h"
#include "baker/files/png_encode.h"
#include "baker/lab/render/exr_encode.h"
#include "baker/lab/truth/truth.h"
#include "baker/light/map_space.h"

typedef struct passes {
    renderer    *renderer;
    const char  *folder;
    const truth *truth;
    uint32_t     width, height, threads;
    int          is_linear;                          /* floats are written, too */
    vxs_filter   filter;                             /* as for vxs_lookup */
    size_t       count;                              /* samples */
    float       *depths, *normals, *albedos, *light; /* of renderer_read; one allocation with all that follow */
    float       *lit;                                /* [count] of one light */
    float       *spare;                              /* [3 * count] for any pass, before the sums are needed */
    float       *sum, *true_sum, *reached;           /* [count] sums over lights that were looked up: in spare */
    uint8_t     *rgb;
} passes;

static const double pi = 3.14159265358979324;

static uint8_t byte_of(double share)
{
    return (uint8_t)(255 * fmin(fmax(share, 0), 1) + 0.5);
}

static void set_grey(uint8_t rgb[3], double share)
{
    memset(rgb, byte_of(share), 3);
}

static const uint8_t nothing[3] = {255, 0, 255};

/* bytes  [size] of the picture, freed here; NULL: out of memory */
static vxs_result write_file(const passes *p, const char *name, const char *extension, uint8_t *bytes, size_t size, run_context *m)
{
    char        file[256];
    output_file out = {0};
    vxs_result  r   = bytes ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for %s%s of %s", name, extension, p->folder);
    snprintf(file, sizeof file, "%s%s", name, extension);
    if (r == VXS_OK) r = output_file_open_in_folder(&out, "--passes", p->folder, file, m);
    if (r == VXS_OK) r = output_file_write(&out, bytes, size, m);
    if (r == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    free(bytes);
    return r;
}

static vxs_result write_pixels(const passes *p, const char *name, const uint8_t *rgb, uint32_t width, uint32_t height,
                               run_context *m)
{
    size_t   size = 0;
    uint8_t *png  = png_encode(rgb, width, height, 3, &size);
    return write_file(p, name, ".png", png, size, m);
}

/* Write the floats of a pass, if wanted.   channels  as in exr_encode; NULL: the pass has no floats */
static vxs_result write_floats(const passes *p, const char *name, const float *floats, uint32_t width, uint32_t height,
                               const char *channels, run_context *m)
{
    size_t size = 0;
    if (!p->is_linear || !channels) return VXS_OK;
    uint8_t *exr = exr_encode(floats, width, height, channels, 0, &size);
    return write_file(p, name, ".exr", exr, size, m);
}

/* Write the picture in p->rgb, and its floats. */
static vxs_result write_pass(const passes *p, const char *name, const float *floats, const char *channels, run_context *m)
{
    vxs_result r = write_pixels(p, name, p->rgb, p->width, p->height, m);
    return r == VXS_OK ? write_floats(p, name, floats, p->width, p->height, channels, m) : r;
}

/* surfaces and light ----------------------------------------------------------------------------------------------------------- */

/* Depth, normal and albedo. */
static vxs_result write_surfaces(passes *p, run_context *m)
{
    float near = INFINITY, far = 0;
    for (size_t n = 0; n < p->count; n++) {
        if (p->depths[n] > 0) near = fminf(near, p->depths[n]);
        far = fmaxf(far, p->depths[n]);
    }
    for (size_t n = 0; n < p->count; n++)
        set_grey(p->rgb + 3 * n,
                 p->depths[n] > 0 && far > near ? 1 - 0.9 * (log((double)p->depths[n] / near) / log((double)far / near)) : 0);
    vxs_result r = write_pass(p, "depth", p->depths, "Z", m);

    for (size_t n = 0; n < 3 * p->count; n++) p->rgb[n] = p->depths[n / 3] > 0 ? byte_of(0.5 + 0.5 * (double)p->normals[n]) : 0;
    if (r == VXS_OK) r = write_pass(p, "normal", p->normals, "XYZ", m);

    for (size_t n = 0; n < 3 * p->count; n++) p->rgb[n] = p->depths[n / 3] > 0 ? byte_of(srgb_of((double)p->albedos[n])) : 0;
    return r == VXS_OK ? write_pass(p, "albedo", p->albedos, "RGB", m) : r;
}

/* Light, and the number of lights that reach each sample. */
static vxs_result write_light(passes *p, run_context *m)
{
    double exposure = renderer_facts(p->renderer).exposure;
    float  most     = 1;
    for (size_t n = 0; n < p->count; n++)
        for (size_t k = 0; k < 3; k++) {
            float *light      = &p->light[4 * n + k];
            *light            = (float)(exposure * (double)*light);
            p->rgb[3 * n + k] = byte_of(srgb_of(fmin(1, (double)*light)));
        }
    vxs_result r = write_pass(p, "light", p->light, "RGB.", m);

    for (size_t n = 0; n < p->count; n++) most = fmaxf(most, p->light[4 * n + 3]);
    for (size_t n = 0; n < p->count; n++) {
        uint8_t *rgb   = p->rgb + 3 * n;
        double   share = (double)(p->light[4 * n + 3] / most);
        memset(rgb, 0, 3);
        if (!(share > 0)) continue;
        rgb[0] = byte_of(3 * share - 1); /* blue, green, yellow, red */
        rgb[1] = byte_of(share < 0.5 ? 3 * share : 3 - 3 * share);
        rgb[2] = byte_of(1 - 3 * share);
    }
    return r == VXS_OK ? write_pass(p, "lights", p->light, "...Y", m) : r;
}

/* Write linear light, times a factor. */
static vxs_result write_linear(passes *p, const char *name, render_texture which, double factor, run_context *m)
{
    vxs_result r = renderer_read_texture(p->renderer, which, p->spare, m);
    for (size_t n = 0; n < 3 * p->count && r == VXS_OK; n++) {
        p->spare[n] = (float)(factor * (double)p->spare[n]);
        p->rgb[n]   = byte_of(srgb_of(fmin(1, (double)p->spare[n])));
    }
    return r == VXS_OK ? write_pass(p, name, p->spare, "RGB", m) : r;
}

static vxs_result write_shadow_grid(const passes *p, run_context *m)
{
    uint32_t   side  = renderer_facts(p->renderer).fog_grid;
    size_t     count = (size_t)2 * side * side;
    float     *dark  = malloc(count * sizeof *dark);
    uint8_t   *rgb   = malloc(3 * count);
    vxs_result r = dark && rgb ? renderer_read_grid(p->renderer, dark, m) : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    for (size_t n = 0; n < count && r == VXS_OK; n++) set_grey(rgb + 3 * n, (double)(dark[n] = 1 - dark[n])); /* lit */
    if (r == VXS_OK) r = write_pixels(p, "shadow-grid", rgb, side, 2 * side, m);
    if (r == VXS_OK) r = write_floats(p, "shadow-grid", dark, side, 2 * side, "Y", m);
    free(dark);
    free(rgb);
    return r;
}

/* The mesh over a dimmed picture of the scene. */
static vxs_result write_light_mesh(const passes *p, run_context *m)
{
    vxs_result r = renderer_read_mesh(p->renderer, p->spare, m);
    for (size_t n = 0; n < 3 * p->count && r == VXS_OK; n++) {
        double dim = p->depths[n / 3] > 0 ? 0.05 + 0.03 * (double)p->normals[n - n % 3 + 1] : 0.004;
        p->rgb[n]  = byte_of(srgb_of(dim - expm1(-(double)p->spare[n])));
    }
    return r == VXS_OK ? write_pass(p, "light-mesh", NULL, NULL, m) : r;
}

static vxs_result write_resident(passes *p, run_context *m)
{
    static const double full_rgb[3] = {0.75, 0.75, 0.75}, coarse_rgb[3] = {0.85, 0.15, 0.05};
    vxs_result          r = renderer_read_full(p->renderer, p->lit, m);
    for (size_t n = 0; n < p->count && r == VXS_OK; n++) {
        double share = (double)p->lit[n];
        set_grey(p->rgb + 3 * n, p->lit[n] == RENDER_NOT_ASKED ? 0.25 : 0);
        for (size_t k = 0; k < 3 && share >= 0; k++) p->rgb[3 * n + k] = byte_of(share * full_rgb[k] + (1 - share) * coarse_rgb[k]);
    }
    return r == VXS_OK ? write_pass(p, "resident", p->lit, "Y", m) : r;
}

/* each light ------------------------------------------------------------------------------------------------------------------- */

typedef struct asked_light {
    passes          *passes;
    const vxs_light *light;
    light_shape      shape;
} asked_light;

static void trace_samples(void *user, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        const asked_light *a = user;
        passes            *p = a->passes;
        double place_ws[3], normal[3] = {(double)p->normals[3 * n], (double)p->normals[3 * n + 1], (double)p->normals[3 * n + 2]};
        if (!(p->lit[n] >= 0)) continue;
        renderer_place(p->renderer, (uint32_t)(n % p->width), (uint32_t)(n / p->width), p->depths[n], place_ws);
        double to_light[3];
        for (int k = 0; k < 3; k++)
            to_light[k] = a->shape.kind == LIGHT_DIRECTIONAL ? -a->shape.direction_ws[k] : a->shape.position_ws[k] - place_ws[k];
        if (!(vec3_dot(to_light, normal) > 0)) continue;
        filter_taps taps = filter_taps_of(a->light, place_ws, normal, p->filter);
        if (taps.map < 0) continue;
        p->true_sum[n] += (float)truth_filtered(p->truth, a->light, &a->shape, &taps);
        p->sum[n] += p->lit[n];
        p->reached[n] += 1;
    }
}

/* The same for one light. */
static vxs_result write_of_light(const passes *p, const char *what, uint32_t number, const vxs_light *light, const float *floats,
                                 run_context *m)
{
    char name[VXS_LIGHT_NAME_BYTES + 32];
    snprintf(name, sizeof name, "%s-%u-%s", what, number, light->name);
    for (char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && !strchr("-_.", *c)) *c = '_';
    return write_pass(p, name, floats, "Y", m);
}

static vxs_result write_lights_each(passes *p, const vxs_baked_light *const *lights, uint32_t light_count, run_context *m)
{
    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < light_count && r == VXS_OK; n++) {
        asked_light a = {p, &lights[n]->light, baked_light_shape(&lights[n]->light)};
        if ((r = renderer_read_lit(p->renderer, n, p->lit, m)) != VXS_OK) break;
        size_t reached = 0;
        for (size_t i = 0; i < p->count; i++) {
            set_grey(p->rgb + 3 * i, (double)p->lit[i]);
            if (p->lit[i] >= 0)
                reached++;
            else
                memcpy(p->rgb + 3 * i, nothing, sizeof nothing);
        }
        if (!reached) continue; /* so it is for most of hundreds of lights */
        r = write_of_light(p, "lit", n, a.light, p->lit, m);
        if (r == VXS_OK && p->truth) parallel_for(p->threads, p->count, p->width, trace_samples, &a);
    }
    return r;
}

/* Transmittance of smoke towards each light that it dims, at surfaces; and towards the eye. */
static vxs_result write_smoke(passes *p, const vxs_baked_light *const *lights, uint32_t light_count, run_context *m)
{
    const smoke_light_plan *dimmed = renderer_facts(p->renderer).smoke_lights;
    float                  *left   = p->spare;
    vxs_result              r      = renderer_read_through(p->renderer, left, m);
    for (size_t i = 0; i < p->count && r == VXS_OK; i++) set_grey(p->rgb + 3 * i, (double)left[i]);
    if (r == VXS_OK) r = write_pass(p, "smoke", left, "Y", m);
    for (uint32_t n = 0; n < light_count && r == VXS_OK; n++) {
        if (dimmed[n].cull_result != SMOKE_DIMS) continue;
        r = renderer_read_smoke(p->renderer, n, left, m);
        for (size_t i = 0; i < p->count && r == VXS_OK; i++) {
            set_grey(p->rgb + 3 * i, (double)left[i]);
            if (!(p->depths[i] > 0)) memcpy(p->rgb + 3 * i, nothing, sizeof nothing);
        }
        if (r == VXS_OK) r = write_of_light(p, "smoke", n, &lights[n]->light, left, m);
    }
    return r;
}

static vxs_result write_truth(passes *p, truth_difference *d, run_context *m)
{
    double sum = 0;
    *d         = (truth_difference){0};
    for (size_t n = 0; n < p->count; n++) {
        memcpy(p->rgb + 3 * n, nothing, sizeof nothing);
        p->lit[n] = p->reached[n] > 0 ? p->true_sum[n] / p->reached[n] : -1;
        if (p->reached[n] > 0) set_grey(p->rgb + 3 * n, (double)p->lit[n]);
    }
    vxs_result r = write_pass(p, "truth", p->lit, "Y", m);
    for (size_t n = 0; n < p->count; n++) {
        double difference = p->reached[n] > 0 ? (double)((p->sum[n] - p->true_sum[n]) / p->reached[n]) : 0;
        p->lit[n]         = (float)difference;
        p->rgb[3 * n]     = byte_of(0.5 - 0.5 * difference);
        p->rgb[3 * n + 2] = byte_of(0.5 + 0.5 * difference);
        p->rgb[3 * n + 1] = byte_of(0.5 - 0.5 * fabs(difference));
        d->asked += p->reached[n] > 0;
        d->too_dark += difference < -0.5;
        d->too_light += difference > 0.5;
        sum += fabs(difference);
    }
    d->mean = d->asked ? sum / (double)d->asked : 0;
    return r == VXS_OK ? write_pass(p, "difference", p->lit, "Y", m) : r;
}

static vxs_result take(passes *p, run_context *m)
{
    vxs_result r = memory_check(p->count * (15 * sizeof(float) + 3), m, "passes of %u x %u samples need", p->width, p->height);
    if (r != VXS_OK) return r;
    p->depths = malloc(15 * p->count * sizeof(float));
    p->rgb    = malloc(3 * p->count);
    if (!p->depths || !p->rgb) return fail(m, VXS_E_MEMORY, "out of memory for passes of %u x %u samples", p->width, p->height);
    p->normals  = p->depths + p->count;
    p->albedos  = p->normals + 3 * p->count;
    p->light    = p->albedos + 3 * p->count;
    p->lit      = p->light + 4 * p->count;
    p->spare    = p->lit + p->count;
    p->sum      = p->spare;
    p->true_sum = p->sum + p->count;
    p->reached  = p->true_sum + p->count;
    return renderer_read(p->renderer, p->depths, p->normals, p->albedos, p->light, m);
}

vxs_result render_passes(renderer *drawn, const char *folder, const vxs_baked_light *const *lights, uint32_t light_count,
                         const passes_options *o, truth_difference *difference, run_context *m)
{
    const truth *t     = o->truth;
    render_facts facts = renderer_facts(drawn);
    passes       p     = {
                  .renderer = drawn, .folder = folder, .truth = t, .is_linear = o->is_linear, .filter = o->filter, .threads = o->threads};
    if (mkdir(folder, 0777) && errno != EEXIST)
        return fail(m, VXS_E_WRITE, "--passes %s: the folder cannot be made: %s", folder, strerror(errno));
    p.width      = facts.width;
    p.height     = facts.height;
    p.count      = (size_t)p.width * p.height;
    vxs_result r = take(&p, m);
    if (r == VXS_OK) r = write_surfaces(&p, m);
    if (r == VXS_OK) r = write_light(&p, m);
    if (r == VXS_OK && facts.areas) r = write_linear(&p, "area", TEXTURE_AREAS, 1 / pi, m);
    if (r == VXS_OK && facts.sky) r = write_linear(&p, "sky", TEXTURE_SKY, 1 / pi, m);
    if (r == VXS_OK && facts.is_in_fog) r = write_linear(&p, "airlight", TEXTURE_AIRLIGHT, 1, m);
    if (r == VXS_OK && facts.is_in_fog) {
        renderer_fog_left(drawn, p.depths, p.spare);
        for (size_t n = 0; n < 3 * p.count; n++) p.rgb[n] = byte_of((double)p.spare[n]);
        r = write_pass(&p, "transmittance", p.spare, "RGB", m);
    }
    if (r == VXS_OK && facts.fog_grid) r = write_shadow_grid(&p, m);
    if (r == VXS_OK && facts.has_mesh) r = write_light_mesh(&p, m);
    if (r == VXS_OK && facts.smoke_lights) r = write_smoke(&p, lights, light_count, m);
    if (r == VXS_OK && o->streamed) r = write_resident(&p, m);
    if (r == VXS_OK) {
        memset(p.spare, 0, 3 * p.count * sizeof *p.spare);
        r = write_lights_each(&p, lights, light_count, m);
    }
    if (r == VXS_OK && t) r = write_truth(&p, difference, m);
    free(p.depths);
    free(p.rgb);
    return r;
}
