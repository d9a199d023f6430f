/* A picture of a scene in the shadows of baked lights; see picture.h.
 *
 * A pixel is the mean of 2 x 2 rays. All surfaces are one matt material under these lights:
 *
 *     suns      lambert, times the lookup in the asset at the point, with its normal, filtered
 *     punctual lights     the same, weaker with distance: as bright as a sun at the usual distance of surfaces that the light
 *     lights
 *     sky       rays over the hemisphere: the sky's colour where they leave the scene, darker the sooner they meet it
 *     haze      mixed over all, by distance behind the nearest corner of the scene
 *     air       in front of all, punctual light that haze scatters: single lookups at some places along the ray
 *     fog       optional, replaces haze and air: its transmittance, and airlight of suns and punctual lights along exactly those
 *     parts of
 *               the ray that are lit (fog.h). Then lights reach surfaces by the law of light in the air, too: by the square of
 *               the distance, and with transmittance along the way
 *
 * Colours are linear until the end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/picture/picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/base/srgb.h"
#include "baker/base/vec3.h"
#include "baker/files/png_encode.h"
#include "baker/light/map_space.h"
#include "runtime/vxs.h"

enum { SIDE_SAMPLES = 2, SKY_RAYS_SIDE = 3, SKY_RAYS = SKY_RAYS_SIDE * SKY_RAYS_SIDE, AIR_STEPS = 16, PUNCTUAL_PROBES = 64 };

static const double pi = 3.14159265358979323846;

static const double albedo[3]          = {0.66, 0.62, 0.56};
static const double sun_colour[3]      = {2.05, 1.76, 1.34};
static const double punctual_colour[3] = {2.00, 1.55, 0.95};
static const double sky_zenith[3]      = {0.20, 0.40, 0.86};
static const double sky_horizon[3]     = {0.70, 0.81, 0.95};
static const double sky_below[3]       = {0.56, 0.61, 0.68};
static const double bounce[3]          = {0.09, 0.08, 0.07};

static const double night = 0.07; /* of a sky without a sun */

typedef struct punctual_light {
    const vxs_baked_light *light;
    light_shape            shape;
    double                 usual_metres; /* usual distance of the surfaces that it lights */
    double                 reach_metres; /* its light ends there */
} punctual_light;

typedef struct view {
    const picture_options  *options;
    const truth            *truth;
    const vxs_baked_light **suns;            /* [sun_count] */
    punctual_light         *punctual_lights; /* [punctual_count] */
    fog_light              *fog_lights;      /* [sun_count + punctual_count] */
    uint32_t                sun_count, punctual_count;
    double                  day; /* factor on the sky's light: 1, or night */
    uint8_t                *rgb;
    float                  *linear; /* NULL: not wanted */
    camera_view             seen;
    double                  near_metres; /* haze begins */
    double                  haze_metres; /* it takes 1 - 1/e in so much */
    double                  end_metres;  /* beyond it no surface is seen, and fog ends */
    double                  sky_metres;  /* a surface at this distance shuts out half of the sky */
} view;

/* light ------------------------------------------------------------------------------------------------------------------------ */

static void mix(const double a[3], const double b[3], double share, double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[i] + share * (b[i] - a[i]);
}

static void sky_colour(const double direction[3], double out[3])
{
    double y = direction[1];
    if (y >= 0)
        mix(sky_horizon, sky_zenith, 1 - pow(1 - y, 2.5), out);
    else
        mix(sky_horizon, sky_below, 1 - pow(1 + y, 2), out);
}

/* Two unit vectors perpendicular to a unit normal. */
static void frame_of(const double normal[3], double a[3], double b[3])
{
    double axis[3] = {fabs(normal[0]) < 0.5, fabs(normal[0]) >= 0.5, 0};
    vec3_cross(normal, axis, a);
    double length = sqrt(vec3_dot(a, a));
    for (int i = 0; i < 3; i++) a[i] /= length;
    vec3_cross(normal, a, b);
}

/* Light from the sky, shut out by surfaces, by cosine-distributed rays: a grid of cells, a ray in each, mapped to a disk and
 * projected to the hemisphere. The samples of a pixel share the cells. */
static void sky_light(const view *v, const double from_ws[3], const double normal[3], int sample, rng *r, double out[3])
{
    double a[3], b[3];
    frame_of(normal, a, b);
    memset(out, 0, 3 * sizeof *out);
    for (int n = 0; n < SKY_RAYS; n++) {
        int    row    = n / SKY_RAYS_SIDE * SIDE_SAMPLES + sample / SIDE_SAMPLES;
        int    column = n % SKY_RAYS_SIDE * SIDE_SAMPLES + sample % SIDE_SAMPLES;
        double square = (column + rng_unit(r)) / (SKY_RAYS_SIDE * SIDE_SAMPLES);
        double angle  = (row + rng_unit(r)) / (SKY_RAYS_SIDE * SIDE_SAMPLES) * 2 * pi;
        double radius = sqrt(square), height = sqrt(1 - square), distance, direction[3], sky[3];
        for (int i = 0; i < 3; i++) direction[i] = radius * cos(angle) * a[i] + radius * sin(angle) * b[i] + height * normal[i];
        sky_colour(direction, sky);
        if (truth_first_hit(v->truth, from_ws, direction, &distance, NULL, NULL))
            mix(bounce, sky, distance / (distance + v->sky_metres) * 0.85, sky);
        for (int i = 0; i < 3; i++) out[i] += sky[i] / SKY_RAYS;
    }
}

/* punctual lights -------------------------------------------------------------------------------------------------------------- */

static punctual_light make_punctual(const view *v, const vxs_baked_light *light, double size)
{
    punctual_light l    = {.light = light, .shape = baked_light_shape(&light->light)};
    rng            r    = {1};
    double         sum  = 0, metres;
    int            hits = 0;
    for (int n = 0; n < PUNCTUAL_PROBES; n++) {
        double direction[3];

        /* a random direction in the light's cone */
        double a[3], b[3], sunk = rng_unit(&r), turn = 2 * pi * rng_unit(&r);
        sunk *= l.shape.kind == LIGHT_POINT ? 2 : 1 - cos(l.shape.outer_rad);
        double wide = sqrt(sunk * (2 - sunk));
        frame_of(l.shape.direction_ws, a, b);
        for (int i = 0; i < 3; i++)
            direction[i] = wide * (cos(turn) * a[i] + sin(turn) * b[i]) + (1 - sunk) * l.shape.direction_ws[i];

        if (!truth_first_hit(v->truth, l.shape.position_ws, direction, &metres, NULL, NULL)) continue;
        sum += metres;
        hits++;
    }
    l.usual_metres = fmax(fmin(hits ? sum / hits : 0.1 * size, 0.5 * l.shape.range_metres), 1e-6 * size);
    l.reach_metres = fmin(l.shape.range_metres, 8 * l.usual_metres);
    return l;
}

/* Brightness of a punctual light at a point: it decreases with distance, to the edge of its cone and to the end of its range. 0 out
 * of reach.
 * to_light  [out] unit */
static double punctual_strength(const punctual_light *l, const double point_ws[3], double to_light[3])
{
    double way[3];
    vec3_sub(l->shape.position_ws, point_ws, way);
    double metres = sqrt(vec3_dot(way, way)), share = metres / l->usual_metres;
    if (!(metres < l->reach_metres) || !vec3_unit(way, to_light)) return 0;
    double strength = 2 / (1 + share * share) * (1 - pow(metres / l->reach_metres, 4));
    if (l->shape.kind == LIGHT_POINT) return strength;
    double angle = acos(fmin(1, fmax(-1, -vec3_dot(to_light, l->shape.direction_ws))));
    double edge  = fmin(1, (l->shape.outer_rad - angle) / (0.1 * l->shape.outer_rad));
    return edge <= 0 ? 0 : strength * edge * edge * (3 - 2 * edge);
}

/* Light of punctual lights that the air scatters along a ray. Lookups are at equal angles as seen from the light (Kulla and
 * Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media", EGSR 2012). */
static double air_light(const view *v, const double direction[3], double metres, rng *r)
{
    const double scattered = 0.10; /* share scattered along the usual distance, by light of the usual strength */
    double       sum       = 0;
    for (uint32_t n = 0; n < v->punctual_count; n++) {
        const punctual_light *l     = &v->punctual_lights[n];
        double                begin = 0, end = metres, nearest, beside, first = rng_unit(r), to_light[3], point[3];

        /* the part of the ray in the light's reach, its point nearest to the light, and the distance between them */
        double from[3];
        vec3_sub(v->options->camera.eye_ws, l->shape.position_ws, from);
        nearest       = -vec3_dot(from, direction);
        double across = fmax(0, vec3_dot(from, from) - nearest * nearest), half = l->reach_metres * l->reach_metres - across;
        if (half <= 0) continue;
        beside = fmax(sqrt(across), 1e-3 * l->usual_metres);
        begin  = fmax(0, nearest - sqrt(half));
        end    = fmin(end, nearest + sqrt(half));
        if (!(begin < end)) continue;

        double low = atan((begin - nearest) / beside), step = (atan((end - nearest) / beside) - low) / AIR_STEPS;
        for (int i = 0; i < AIR_STEPS; i++) {
            double slope = tan(low + (i + first) * step), length = step * beside * (1 + slope * slope);
            vec3_mad(v->options->camera.eye_ws, nearest + beside * slope, direction, point);
            double strength = punctual_strength(l, point, to_light);
            if (!(strength > 0)) continue;
            /* weighted by strength twice: else haze far from punctual lights would hide the scene */
            double lit = fmax(0, (double)vxs_lookup(l->light, point, NULL, vxs_box(1)));
            sum += scattered * strength * fmin(1, strength) * lit * length / l->usual_metres;
        }
    }
    return sum;
}

/* Light of suns and punctual lights on a surface, after shadows, without fog. */
static void lights_at(const view *v, const double point_ws[3], const double normal[3], double out[3])
{
    double suns = 0, punctual_lights = 0, to_light[3];
    for (uint32_t n = 0; n < v->sun_count; n++) {
        double facing = -vec3_dot(normal, v->suns[n]->light.direction_ws);
        if (facing <= 0) continue;
        float lit = vxs_lookup(v->suns[n], point_ws, normal, v->options->filter);
        suns += facing * (lit < 0 ? 1 : (double)lit) / v->sun_count; /* beyond the map there is no shadow */
    }
    for (uint32_t n = 0; n < v->punctual_count; n++) {
        double strength = punctual_strength(&v->punctual_lights[n], point_ws, to_light), facing = 0;
        if (strength > 0) facing = vec3_dot(normal, to_light);
        if (facing > 0)
            punctual_lights +=
                strength * facing * fmax(0, (double)vxs_lookup(v->punctual_lights[n].light, point_ws, normal, v->options->filter));
    }
    for (int i = 0; i < 3; i++) out[i] = suns * sun_colour[i] + punctual_lights * punctual_colour[i];
}

/* Light that comes to the eye along one ray, from the first surface. */
static int trace_surface(const view *v, const double direction[3], int sample, rng *r, double *distance, double out[3])
{
    double normal[3], point[3], lifted[3], haze[3];
    sky_colour(direction, haze);
    for (int i = 0; i < 3; i++) haze[i] *= v->day;
    memcpy(out, haze, sizeof haze);
    double begin = v->options->camera.near_metres / vec3_dot(direction, v->seen.forward), from[3];
    vec3_mad(v->options->camera.eye_ws, begin, direction, from);
    if (!truth_first_hit(v->truth, from, direction, distance, normal, NULL)) return 0;
    *distance += begin;
    double turn = vec3_dot(normal, direction) > 0 ? -1 : 1; /* turn the normal: a sheet may be seen from behind */
    for (int i = 0; i < 3; i++) normal[i] *= turn;
    vec3_mad(v->options->camera.eye_ws, *distance, direction, point);
    truth_lift(v->truth, point, normal, lifted);

    double sky[3], light[3];
    if (v->options->fog) {
        memset(light, 0, 3 * sizeof *light);
        for (uint32_t n = 0; n < v->sun_count + v->punctual_count; n++) {
            const fog_light *l = &v->fog_lights[n];
            double           to_light[3], reaches[3];
            fog_reaches(v->options->fog, l, point, to_light, reaches);
            double facing = vec3_dot(normal, to_light);
            if (facing <= 0 || !(reaches[0] + reaches[1] + reaches[2] > 0)) continue;
            double lit = (double)vxs_lookup(l->light, point, normal, v->options->filter);
            if (lit < 0) lit = l->shape.kind == LIGHT_DIRECTIONAL;
            for (int i = 0; i < 3; i++) light[i] += facing * lit * reaches[i] * l->colour[i] / pi;
        }
    } else
        lights_at(v, point, normal, light);
    sky_light(v, lifted, normal, sample, r, sky);
    for (int i = 0; i < 3; i++) out[i] = albedo[i] * (light[i] + 0.42 * v->day * sky[i]);
    if (!v->options->fog) mix(out, haze, 1 - exp(-fmax(*distance - v->near_metres, 0) / v->haze_metres), out);
    return 1;
}

static void trace(const view *v, const double direction[3], int sample, rng *r, double out[3])
{
    double distance;
    if (!trace_surface(v, direction, sample, r, &distance, out)) distance = v->options->fog ? v->end_metres : INFINITY;
    if (v->options->fog) {
        /* fog scatters the sky's light as if a tenth of the sky were seen from everywhere */
        const double      seen = 0.1;
        const double     *eye  = v->options->camera.eye_ws;
        const fog_medium *f    = v->options->fog;
        double            left[3];
        fog_left(f, eye, direction, distance, left);
        for (int i = 0; i < 3; i++) {
            double turned = f->extinction[i] > 0 ? f->scattering[i] / f->extinction[i] : 0;
            out[i]        = left[i] * out[i] + (1 - left[i]) * turned * seen * v->day * sky_horizon[i];
        }
        fog_add_airlight(f, v->fog_lights, v->sun_count + v->punctual_count, eye, direction, distance, out);
        return;
    }
    double air = v->punctual_count ? air_light(v, direction, distance, r) : 0;
    for (int i = 0; i < 3; i++) out[i] += air * punctual_colour[i];
}

/* pixels ----------------------------------------------------------------------------------------------------------------------- */

static void render_pixels(void *user, size_t begin, size_t end, uint32_t worker)
{
    const view *v = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        const double           shown  = 0.80;
        const picture_options *o      = v->options;
        double                 sum[3] = {0};
        for (int k = 0; k < SIDE_SAMPLES * SIDE_SAMPLES; k++) {
            rng    r = rng_split(n, (uint64_t)k);
            double x = (double)(n % o->width_px) + (k % SIDE_SAMPLES + 0.5) / SIDE_SAMPLES;
            double y = (double)(n / o->width_px) + (k / SIDE_SAMPLES + 0.5) / SIDE_SAMPLES;
            double direction[3], colour[3];
            camera_direction(&v->seen, x / o->width_px, y / o->height_px, direction);
            trace(v, direction, k, &r, colour);
            for (int i = 0; i < 3; i++) sum[i] += colour[i] / (SIDE_SAMPLES * SIDE_SAMPLES);
        }
        for (size_t i = 0; i < 3; i++) {
            double light  = shown * sum[i];
            double mapped = light < 0.6 ? light : 0.6 + 0.4 * (1 - exp(-(light - 0.6) / 0.4)); /* keeps detail in sunlit walls */
            v->rgb[3 * n + i] = png_dithered(srgb_of(mapped), (uint32_t)(n % o->width_px), (uint32_t)(n / o->width_px));
            if (v->linear) v->linear[3 * n + i] = (float)light;
        }
    }
}

vxs_result picture_render(uint8_t *rgb, float *linear, const picture_options *o, const truth *t, const casters *c,
                          const vxs_baked_light *const *lights, uint32_t light_count, run_context *m)
{
    box        b    = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double     size = fmax(box_diagonal(&b), 1e-9), square = 0; /* of the distance from the eye to the box */
    vxs_result r = VXS_OK;
    for (int i = 0; i < 3; i++) {
        double outside = fmax(fmax(b.min[i] - o->camera.eye_ws[i], o->camera.eye_ws[i] - b.max[i]), 0);
        square += outside * outside;
    }
    view v            = {.options     = o,
                         .truth       = t,
                         .rgb         = rgb,
                         .linear      = linear,
                         .seen        = camera_view_of(&o->camera, (double)o->width_px / o->height_px),
                         .near_metres = sqrt(square),
                         .haze_metres = 4 * size,
                         .sky_metres  = 0.03 * size,
                         .end_metres  = sqrt(square) + 2 * size};
    v.suns            = malloc((light_count + 1) * sizeof *v.suns);
    v.punctual_lights = malloc((light_count + 1) * sizeof *v.punctual_lights);
    v.fog_lights      = malloc((light_count + 1) * sizeof *v.fog_lights);
    if (!v.suns || !v.punctual_lights || !v.fog_lights) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %u lights", light_count);
        goto done;
    }
    for (uint32_t n = 0; n < light_count; n++) {
        if (lights[n]->light.kind == VXS_LIGHT_KIND_DIRECTIONAL)
            v.suns[v.sun_count++] = lights[n];
        else
            v.punctual_lights[v.punctual_count++] = make_punctual(&v, lights[n], size);
    }
    v.day = v.sun_count ? 1 : night;

    /* a matt surface reflects 1 / pi of the light that reaches it in each direction: so in fog, lights have pi
     * times their colour */
    fog_light *in_fog = v.fog_lights;
    for (uint32_t n = 0; n < v.sun_count; n++, in_fog++) {
        *in_fog = (fog_light){.light = v.suns[n], .shape = baked_light_shape(&v.suns[n]->light)};
        for (int i = 0; i < 3; i++) in_fog->colour[i] = pi * sun_colour[i] / v.sun_count;
    }
    for (uint32_t n = 0; n < v.punctual_count; n++, in_fog++) {
        const punctual_light *l    = &v.punctual_lights[n];
        *in_fog                    = (fog_light){.light = l->light, .shape = l->shape, .radius_metres = 0.03 * l->usual_metres};
        in_fog->cos_inner          = cos(0.9 * l->shape.outer_rad);
        in_fog->shape.range_metres = l->reach_metres;
        for (int i = 0; i < 3; i++) in_fog->colour[i] = pi * punctual_colour[i] * 2 * l->usual_metres * l->usual_metres;
    }
    parallel_for(o->threads, (size_t)o->width_px * o->height_px, o->width_px, render_pixels, &v);
done:
    free(v.suns);
    free(v.punctual_lights);
    free(v.fog_lights);
    return r;
}

/* a picture of an asset -------------------------------------------------------------------------------------------------------- */

enum { FILTER_PX = 5, FOV_DEGREES = 35 };

/* Order: by size; lights of equal size in the order of the file. */
static int largest_first(const void *a, const void *b)
{
    const vxs_baked_light *const *p = a, *const *q = b;
    if ((*p)->word_count != (*q)->word_count) return (*p)->word_count < (*q)->word_count ? 1 : -1;
    return *p < *q ? -1 : 1;
}

vxs_result asset_picture(uint8_t *rgb, uint32_t width_px, uint32_t height_px, const casters *c, const void *file, size_t size_bytes,
                         uint32_t threads, run_context *m)
{
    picture_options        o     = {.width_px = width_px, .height_px = height_px, .filter = vxs_box(FILTER_PX), .threads = threads};
    vxs_asset             *asset = NULL;
    truth                 *t     = NULL;
    const vxs_baked_light *lights[VXS_LIGHTS_MAX];
    uint32_t               count;
    box                    b;
    vxs_parallel           lent = parallel_lent(threads);
    vxs_result             r    = vxs_asset_open(&asset, file, size_bytes, &(vxs_read_desc){.parallel = &lent});
    if (r != VXS_OK) {
        fail(m, r, "the asset cannot be opened for a picture: %s", vxs_result_text(r));
        goto done;
    }
    if ((r = truth_create(&t, c, threads, m)) != VXS_OK) goto done;
    count = vxs_asset_light_count(asset);
    for (uint32_t n = 0; n < count; n++) lights[n] = vxs_asset_light(asset, n);
    if (count > ASSET_PICTURE_LIGHTS) {
        qsort(lights, count, sizeof *lights, largest_first);
        count = ASSET_PICTURE_LIGHTS;
    }
    o.camera.fov_degrees = FOV_DEGREES;
    b                    = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    camera_frame_lit(&o.camera, &b, lights, count, (double)width_px / height_px);
    r = picture_render(rgb, NULL, &o, t, c, lights, count, m);
done:
    truth_destroy(t);
    vxs_asset_close(asset);
    return r;
}
