/* The option rows of every command that loads a scene: the scene within the file, and which parts of it cast shadows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_ROWS_H
#define SCENE_ROWS_H

#include "baker/command/options/options.h"
#include "baker/scene/scene.h"

/* choice  a scene_choice */
/* clang-format off */
#define SCENE_ROWS(choice)                                                                                                         \
    {"--scene", OPTION_TEXT, &(choice).name, 0, 0, NULL, "NAME", "name or index of the glTF scene (default the file's)", NULL},    \
    {"--exclude", OPTION_TEXTS, &(choice).exclude, 0, 0, NULL, "PATTERN",                                                          \
     "nodes, meshes or materials that cast no shadow: node:Door*, mesh:grass_?, Glass; repeat for more", NULL},                    \
    {"--include", OPTION_TEXTS, &(choice).include, 0, 0, NULL, "PATTERN",                                                          \
     "only these cast, less what --exclude names; repeat for more (default all)", NULL},                                                         \
    {"--skinned", OPTION_CHOICE, &(choice).skinned, 0, 0, SKINNED_CHOICES, NULL,                                                   \
     "skinned meshes: left out, or in the pose that the file has (default exclude)", &(choice).skinned_given},                     \
    {"--blend", OPTION_CHOICE, &(choice).blend, 0, 0, BLEND_CHOICES, NULL,                                                         \
     "materials of alphaMode BLEND: walls where alpha is 0.5 or more; walls; nothing (default mask)", &(choice).blend_given},      \
    {"--allow-outside", OPTION_SWITCH, &(choice).allow_outside, 0, 0, NULL, NULL,                                                  \
     "read buffers and images that lie outside of the scene's folder", NULL}
/* clang-format on */

#endif
