/* two_maps: how long it takes to render the two depth maps of all lights of a scene, and nothing else.
 *
 *     two_maps SCENE [--sun X,Y,Z] [--resolution N] [--tiles K] [--threads N]
 *
 * Enter depths and nearest back faces, with OSMesa, by K random tiles of up to 4096 texels of all maps, those without a caster
 * among them; fewer where there are fewer. One line of JSON: how many tiles there are, and the seconds that all of them take.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/command/options/options.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/light/light_fit.h"
#include "baker/scene/light_choice.h"
#include "tests/gl_choice.h"

typedef struct two_maps_options {
    const char *scene_path;
    named_list  suns;
    uint32_t    resolution, tiles, threads;
} two_maps_options;

/* Render tile n of a map. Setting up is a part of it where each map is a tile; else it is done once for many. */
static vxs_result render_tile(double *seconds, gl_context *gl, const casters *c, const vxs_light *light, int map, uint32_t n,
                              uint32_t threads, run_context *m)
{
    depth_maps      maps     = {0};
    depth_renderer *renderer = NULL;
    uint32_t        side = 1u << light->levels, tile = min_u32(side, TILE_MAX_PX), across = side / tile;
    double          begun = clock_seconds(), set_up = 0;
    vxs_result      r = depth_renderer_create(&renderer, gl, c, light, map, EXIT_BACK, threads, m);
    if (across > 1) set_up = clock_seconds() - begun;
    if (r == VXS_OK)
        r = depth_maps_init(&maps, tile, side, light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : light->voxel_metres, 1, m);
    if (r == VXS_OK) r = depth_renderer_tile(renderer, &maps, n % across, n / across, m);
    *seconds += clock_seconds() - begun - set_up;
    depth_renderer_destroy(renderer);
    depth_maps_free(&maps);
    return r;
}

/* Render some of all tiles.   *total  all that there are;   *seconds  that they would take */
static vxs_result render_some(const two_maps_options *o, const scene *s, const casters *c, gl_context *gl, uint64_t *total,
                              double *seconds, run_context *m)
{
    static const text_list no_names = {0};
    light_choice           chosen   = {0};
    rng                    random   = rng_split(1, 0);
    uint32_t               rendered = 0;
    vxs_result             r        = lights_choose(s, &no_names, &o->suns, &chosen, m);
    vxs_light             *lights   = calloc(chosen.count + 1, sizeof *lights);
    uint64_t              *first    = calloc(chosen.count + 1, sizeof *first); /* tile of each light */
    if (r == VXS_OK && (!lights || !first)) r = fail(m, VXS_E_MEMORY, "out of memory");
    for (size_t n = 0; n < chosen.count && r == VXS_OK; n++) {
        light_fit_desc fit    = {.name = chosen.lights[n].name, .shape = &chosen.lights[n].shape, .resolution = o->resolution};
        uint64_t       across = max_u32(o->resolution / TILE_MAX_PX, 1), tiles = 0;
        vxs_result     fitted = light_fit(&lights[n], c, &fit, m);
        if (fitted == VXS_OK) tiles = vxs_map_count(&lights[n]) * across * across;
        if (fitted != VXS_E_NO_CASTER) r = fitted;
        first[n + 1] = first[n] + tiles;
    }
    if (r == VXS_OK) *total = first[chosen.count];
    for (*seconds = 0; r == VXS_OK && rendered < o->tiles && rendered < *total; rendered++) {
        uint64_t tile = *total <= o->tiles ? rendered : (uint64_t)(rng_unit(&random) * (double)*total);
        size_t   n    = 0;
        while (tile >= first[n + 1]) n++;
        uint64_t maps = vxs_map_count(&lights[n]), of_map = (first[n + 1] - first[n]) / maps;
        r = render_tile(seconds, gl, c, &lights[n], (int)((tile - first[n]) / of_map), (uint32_t)((tile - first[n]) % of_map),
                        o->threads, m);
    }
    if (rendered) *seconds *= (double)*total / rendered;
    free(first);
    free(lights);
    light_choice_free(&chosen);
    return r;
}

int main(int argc, char **argv)
{
    two_maps_options o         = {.resolution = 4096, .tiles = 8, .threads = parallel_default_threads()};
    const option     options[] = {
            {"SCENE", OPTION_INPUT, &o.scene_path, FILE_SCENE, 0, NULL, NULL, NULL, NULL},
            {"--sun", OPTION_NAMED_VECTOR, &o.suns, 0, 3, SUN_NAME, "[NAME=]X,Y,Z", "as bake", NULL},
            {"--resolution", OPTION_U32, &o.resolution, 512, 262144, NULL, "N", "texels a side, a power of two (default 4096)", NULL},
            {"--tiles", OPTION_U32, &o.tiles, 1, 1000000, NULL, "K", "that are rendered (default 8)", NULL},
            {"--threads", OPTION_U32, &o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default: all)", NULL}};
    const command_line line  = COMMAND_LINE("two_maps", "SCENE [options]", "The time that two depth maps take to render.", options);
    run_context        m     = {0};
    scene              s     = {0};
    casters            c     = {0};
    gl_context        *gl    = NULL;
    uint64_t           total = 0;
    double             seconds = 0;
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &help_shown, &m);
    if (r != VXS_OK || help_shown) goto done;
    if (o.resolution & (o.resolution - 1)) r = fail(&m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two", o.resolution);
    if (r == VXS_OK) r = scene_load_gltf(&s, o.scene_path, NULL, &m);
    if (r == VXS_OK) r = casters_for_maps(&c, &s, CLOSED_AUTO, o.threads, &m);
    if (r == VXS_OK) r = gl_context_create(&gl, gl_choice(), o.threads, &m);
    if (r == VXS_OK) r = render_some(&o, &s, &c, gl, &total, &seconds, &m);
    if (r == VXS_OK) printf("{\"tiles\": %llu, \"seconds\": %.6f}\n", (unsigned long long)total, seconds);
done:
    if (gl) gl_context_destroy(gl);
    casters_free(&c);
    scene_free(&s);
    named_list_free(&o.suns);
    return command_end(&m, r);
}
