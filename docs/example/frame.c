/* One frame with everything, of installed libraries: the ground of a level in baked shadow, that of a board which moves, and that
 * of smoke; fog, and a screen that shines. Light 0 of the file is a sun.
 *
 *     cc frame.c $(pkg-config --cflags --libs vxs_volumes) -lOSMesa -lm -o frame
 *     ./frame level.vxs frame.ppm
 *
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "frame_scene.h"
#include "gl_picture.h"

int main(int argc, char **argv)
{
    vxs_asset             *level;
    vxs_gl                *shadows;
    vxs_volumes           *air;
    vxs_shadow_depth_map  *map;
    vxs_transmittance_map *smoke;
    vxs_area_light        *screen;
    if (argc != 3) return fprintf(stderr, "usage: frame LEVEL.vxs OUT.ppm\n"), 2;
    if (vxs_asset_open_file(&level, argv[1], NULL) || !gl_begin()) return fprintf(stderr, "frame: no level, or no OpenGL\n"), 1;

    /* when the level is loaded */
    const vxs_light *sun    = &vxs_asset_light(level, 0)->light;
    const uint32_t   number = vxs_baked_number(0);
    if (vxs_gl_create(&shadows, &(vxs_gl_desc){.get_proc_address = gl_function, .asset = level}) ||
        vxs_volumes_create(
            &air, &(vxs_volumes_desc){.get_proc_address = gl_function, .shadows = shadows, .width_px = WIDE, .height_px = HIGH}) ||
        vxs_shadow_depth_map_create(&map, air, &(vxs_shadow_depth_map_desc){.baked_number = number, .side_px = 1024, .moves = 1}) ||
        vxs_transmittance_map_create(&smoke, air,
                                     &(vxs_transmittance_desc){.baked_number = number, .capsules = 1, .segments = 1 << 18}) ||
        vxs_area_light_create(&screen, air, &(vxs_area_light_desc){.vpls = 16, .side_px = 64}))
        return fprintf(stderr, "frame: OpenGL cannot do it\n"), 1;
    vxs_gl_upload(shadows, SIZE_MAX);
    vxs_shadow_depth_map_fill(map, UINT64_MAX);

    /* what casts and shines */
    const vxs_area_casters casters = {gl_buffer(rubble, sizeof rubble), sizeof rubble / sizeof *rubble, 1};
    vxs_vpl                lamps[16];
    vxs_area_sample(&rectangle, VXS_AREA_HALTON, 0, lamps, 16);
    vxs_area_light_set(screen, lamps, 16);

    /* each frame: places count from the eye, 10 m above the ground in the middle of the map */
    double            eye_ws[3], half = ldexp(0.5, (int)sun->levels);
    vxs_volumes_frame frame = {.scattering    = {0.004F, 0.004F, 0.004F},
                               .extinction    = {0.005F, 0.005F, 0.005F},
                               .anisotropy    = 0.5F,
                               .ambient       = {0.3F, 0.35F, 0.4F},
                               .top_metres    = 30,
                               .view          = {.width_px = WIDE, .height_px = HIGH},
                               .far_metres    = 200,
                               .depth_texture = gl_ground(10)};
    vxs_volumes_light light = {.baked_number = number, .colour = {2, 1.9F, 1.7F}, .smoke = smoke};
    GLuint            left  = gl_texture(WIDE, HIGH, NULL);
    memcpy(frame.view.point_from_depth, gl_point_from_depth, sizeof gl_point_from_depth);
    vxs_point(sun, 0, (double[3]){half, half, half}, eye_ws);
    eye_ws[1]                = 10;
    vxs_moving_casters board = board_at(sun, eye_ws, (const double[]){eye_ws[0] - 10, 5, eye_ws[2] + 40});
    vxs_gl_origin(shadows, eye_ws);
    vxs_volumes_begin(air, &frame);
    vxs_shadow_depth_map_join(map, &board, 1);
    vxs_transmittance_map_build(smoke, &(vxs_capsules){&column, 0, 1}, NULL);
    vxs_volumes_march(air, &light, map, 64, VXS_STEPS_EQUIANGULAR);
    vxs_area_light_cast(screen, &casters);
    vxs_volumes_area(air, screen, &(vxs_area_look){.normal_texture = gl_normals_up()});
    vxs_volumes_transmittance(air, smoke, left, VXS_CURVE_LINES);

    /* the picture: what is lit, and fog over it */
    const char *texts[VXS_GL_TEXTS + 1];
    vxs_gl_texts(shadows, texts);
    texts[VXS_GL_TEXTS] = shade;
    vxs_gl_bind(shadows);
    glBindTextures(
        0, 4, (const GLuint[]){frame.depth_texture, left, vxs_area_light_irradiance(screen), vxs_shadow_depth_map_texture(map)});
    gl_draw(texts, VXS_GL_TEXTS + 1);
    vxs_volumes_composite(air);
    return gl_write(argv[2]) ? 0 : 1;
}
