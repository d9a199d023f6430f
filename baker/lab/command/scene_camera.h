/* A camera of a scene's file, as pictures take it: vxs render --camera.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_CAMERA_H
#define SCENE_CAMERA_H

#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"

/* Find a camera by its name, by a pattern with shell wildcards, or by its number from 0, "#2" or "2". If several match, the
 * error lists their numbers.
 * path  of the scene, for messages
 * Returns VXS_OK; VXS_E_ARGUMENT: none, several, or one with invalid numbers. */
vxs_result scene_camera_find(const scene_view **view, const scene *s, const char *name, const char *path, message *m);

/* The size of the camera's picture: a missing side follows from the camera's aspect; defaults are 1280 x 720. */
void scene_camera_size(const scene_view *view, int width_given, int height_given, uint32_t side_max, uint32_t *width,
                       uint32_t *height);

/* An orthographic camera becomes a perspective one so far away, with so small an angle, that lines along its axis are parallel
 * to a thousandth.
 * around  box of the scene */
camera_pose scene_camera_pose(const scene_view *view, const box *around);

#endif
