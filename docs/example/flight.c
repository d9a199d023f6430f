/* A flight over a level whose shadows stream in as the camera comes: opens the file with a budget, moves, and draws the ground as
 * the sun lights it, a picture a frame.
 *
 *     cc flight.c $(pkg-config --cflags --libs vxs) -o flight
 *     ./flight level.vxs 4 frame        # 4 MiB; frame00.pgm to frame31.pgm
 *
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <stdlib.h>

#include <vxs_stream.h>

enum { FRAMES = 32, WIDTH = 320, HEIGHT = 180, FILTER = 9 };

/* Where a light's map is: the middle of what it covers, and how wide that is, in metres. */
static double middle_of(const vxs_light *light, double middle_ws[3])
{
    double side = (double)(1u << light->levels);
    vxs_point(light, 0, (double[3]){side / 2, side / 2, side / 2}, middle_ws);
    return side * light->texel_metres;
}

/* The ground around the camera, seen from above, north up: what is beyond the map is black. */
static void draw(const vxs_baked_light *sun, const double eye_ws[3], double metres, FILE *to)
{
    static const double up[3] = {0, 1, 0};
    fprintf(to, "P5 %d %d 255\n", WIDTH, HEIGHT);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double point[3] = {eye_ws[0] + metres * (x - WIDTH / 2) / WIDTH, 0.05, eye_ws[2] + metres * (y - HEIGHT / 2) / WIDTH};
            float  lit      = vxs_lookup(sun, point, up, vxs_box(FILTER));
            fputc(lit == VXS_OUTSIDE ? 0 : 55 + (int)(200 * lit), to);
        }
}

static int fly(vxs_stream *stream, const char *prefix)
{
    const vxs_baked_light *sun = vxs_stream_light(stream, 0);
    double                 eye_ws[3], middle_ws[3], metres = middle_of(&sun->light, middle_ws);
    for (int frame = 0; frame < FRAMES; frame++) {
        eye_ws[0] = middle_ws[0] + metres * (frame - FRAMES / 2) / (2 * FRAMES);
        eye_ws[1] = 20;
        eye_ws[2] = middle_ws[2];

        /* the frame boundary: what has come appears, what is near is requested; no thread may look up meanwhile */
        vxs_stream_focus  eye    = vxs_stream_camera(eye_ws, metres / 8);
        vxs_stream_status status = {.struct_size = sizeof status};
        vxs_stream_frame(stream, &eye, 1, &status);

        char name[256];
        snprintf(name, sizeof name, "%s%02d.pgm", prefix, frame);
        FILE *to = fopen(name, "wb");
        if (!to) return perror(name), 1;
        draw(sun, eye_ws, metres / 8, to);
        if (fclose(to)) return perror(name), 1;
        printf("%s: %u of %u pages wanted are here, %.1f MiB read\n", name, status.pages_wanted - status.pages_missing,
               status.pages_wanted, (double)status.bytes_read / (1 << 20));
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 4) return fprintf(stderr, "usage: flight LEVEL.vxs MIB PREFIX\n"), 2;
    vxs_stream_desc desc = {.struct_size = sizeof desc, .path = argv[1], .threads = 1};
    desc.budget_bytes    = strtoull(argv[2], NULL, 10) << 20;

    vxs_stream *stream;
    vxs_result  result = vxs_stream_open(&stream, &desc);
    if (result != VXS_OK) return fprintf(stderr, "flight: %s: %s\n", argv[1], vxs_result_text(result)), 1;
    int status = fly(stream, argv[3]);
    vxs_stream_close(stream);
    return status;
}
