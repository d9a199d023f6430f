/* Where a camera is, frame by frame.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CAMERA_PATH_H
#define CAMERA_PATH_H

#include <stddef.h>

#include "baker/base/message.h"
#include "baker/lab/truth/camera.h"

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
vxs_result camera_path_read(camera_path *path, const char *file, double fov_degrees, message *m);

/* A circle around the target of a camera, at its height.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result camera_path_orbit(camera_path *path, const camera_pose *camera, message *m);

/* The pose at a share of the path, [0, 1]: eye and target each on a Catmull-Rom curve through the keys, with equal times between
 * keys. */
camera_pose camera_path_at(const camera_path *path, double share);

void camera_path_free(camera_path *path);

#endif
