/* Points of standard input, looked up by a compute shader of Vulkan: how much of a light reaches each. C99.
 *
 *     cc vulkan.c $(pkg-config --cflags --libs vxs) -lvulkan -o vulkan        # vulkan.comp has the line for vulkan.spv
 *     ./vulkan level.vxs vulkan.spv 0 9 <points      # light 0, filter of 9 x 9 taps; a negative width: smooth
 *
 * A line is x y z and a normal; an answer is 0 dark to 1 lit, or -1 outside the volume of the light.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include <vxs.h>

#include "vulkan_compute.h"

enum { WORDS, LIGHTS, SURFACE, ANSWERS }; /* bindings of the shader */
enum { POINTS = 1024 * GROUP };           /* looked up at once */

typedef struct surface_point {
    float position_ws[4], normal_ws[4]; /* the shader has vec3, which are aligned like vec4 */
} surface_point;

/* The words of all lights, one light after the other, and their constants. */
static void upload(gpu *g, const vxs_asset *level)
{
    const double origin_ws[3] = {0, 0, 0}; /* in a large world, near the camera; positions count from there */
    uint32_t     lights = vxs_asset_light_count(level), first = 0;
    VkDeviceSize count = 4; /* words behind the last one that may be read */
    for (uint32_t n = 0; n < lights; n++) count += vxs_asset_light(level, n)->word_count;
    uint32_t            *words     = make_buffer(g, WORDS, 4 * count);
    vxs_light_constants *constants = make_buffer(g, LIGHTS, lights * sizeof *constants);
    for (uint32_t n = 0; n < lights; n++) {
        const vxs_baked_light *light = vxs_asset_light(level, n);
        memcpy(words + first, light->words, 4 * light->word_count);
        constants[n] = vxs_light_constants_of(&light->light, origin_ws, first);
        first += (uint32_t)light->word_count;
    }
}

int main(int argc, char **argv)
{
    gpu        g = {0};
    vxs_asset *level;
    if (argc != 5) return fprintf(stderr, "usage: vulkan LEVEL.vxs SHADER.spv LIGHT WIDTH\n"), 2;
    vxs_result result = vxs_asset_open_file(&level, argv[1], NULL);
    if (result != VXS_OK) return fprintf(stderr, "vulkan: %s: %s\n", argv[1], vxs_result_text(result)), 1;
    uint32_t light = (uint32_t)strtoul(argv[3], NULL, 10), count;
    int      width = atoi(argv[4]);
    check(light < vxs_asset_light_count(level), "the level has no such light");

    open_gpu(&g);
    upload(&g, level);
    vxs_asset_close(level);
    surface_point *point   = make_buffer(&g, SURFACE, POINTS * sizeof *point);
    const float   *answers = make_buffer(&g, ANSWERS, POINTS * sizeof *answers);
    make_pipeline(&g, argv[2], abs(width), width < 0);
    do {
        for (count = 0; count < POINTS; count++) {
            float *p = point[count].position_ws, *n = point[count].normal_ws;
            if (scanf("%f %f %f %f %f %f", p, p + 1, p + 2, n, n + 1, n + 2) != 6) break;
        }
        if (count) look_up(&g, light, count);
        for (uint32_t n = 0; n < count; n++) printf("%.9g\n", answers[n]);
    } while (count == POINTS);
    return 0; /* the driver frees the rest */
}
