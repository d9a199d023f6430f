/* Cameras of a command line: --eye, --target and --fov; --camera of the file; --path and --orbit, frame by frame.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CAMERA_CHOICE_H
#define CAMERA_CHOICE_H

#include <stddef.h>

#include "baker/base/run_context.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

typedef struct camera_choice {
    camera_pose camera; /* fov_degrees has its default */
    int         eye_given, target_given;
} camera_choice;

/* choice  a camera_choice, 35 degrees before;   fov_given  set when --fov is given;   eye  help for --eye */
/* clang-format off */
#define CAMERA_ROWS(choice, fov_given, eye)                                                                                        \
    {"--eye", OPTION_VECTOR, (choice).camera.eye_ws, 0, 3, NULL, "X,Y,Z", eye, &(choice).eye_given},                               \
    {"--target", OPTION_VECTOR, (choice).camera.target_ws, 0, 3, NULL, "X,Y,Z", "where to look; goes with --eye",                  \
     &(choice).target_given},                                                                                                      \
    {"--fov", OPTION_F64, &(choice).camera.fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom, 1 to 170 (default 35)",      \
     &(fov_given)}
/* clang-format on */

/* Returns VXS_OK, or VXS_E_ARGUMENT when only one of eye and target is given, or both are the same point. */
vxs_result camera_check(const camera_choice *c, run_context *m);

/* Find a camera by its name, by a pattern with shell wildcards, or by its number from 0, "#2" or "2". If several match, the
 * error lists their numbers.
 * path  of the scene, for messages
 * Returns VXS_OK; VXS_E_ARGUMENT: none, several, or one with invalid numbers. */
vxs_result scene_camera_find(const scene_view **view, const scene *s, const char *name, const char *path, run_context *m);

/* The size of the camera's picture: a missing side follows from the camera's aspect; defaults are 1280 x 720. */
void scene_camera_size(const scene_view *view, int width_given, int height_given, uint32_t side_max, uint32_t *width,
                       uint32_t *height);

/* An orthographic camera becomes a perspective one so far away, with so small an angle, that lines along its axis are parallel
 * to a thousandth.
 * around  box of the scene */
camera_pose scene_camera_pose(const scene_view *view, const box *around);

typedef struct camera_path {
    camera_pose *keys; /* [count] owned */
    size_t       count;
    int          closed; /* 1: the first key follows the last one */
} camera_path;

enum { PATH_KEYS_MAX = 10000 };

/* Read keys from a file, a line each: "x y z  target x y z", metres; blank lines and lines that begin with # are skipped. It is
 * an error if a key's points are equal, or if there are fewer than two keys.
 * path  [out] released with camera_path_free, whatever is returned
 * Returns VXS_OK, VXS_E_READ (the message has the line's number), VXS_E_MEMORY. */
vxs_result camera_path_read(camera_path *path, const char *file, double fov_degrees, run_context *m);

/* A circle around the target of a camera, at its height.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result camera_path_orbit(camera_path *path, const camera_pose *camera, run_context *m);

/* The pose at a share of the path, [0, 1]: eye and target each on a Catmull-Rom curve through the keys, with equal times between
 * keys. */
camera_pose camera_path_at(const camera_path *path, double share);

void camera_path_free(camera_path *path);

#endif
