/* The scene as plain arrays; see scene.h. Loaders fill it, everybody else only reads it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/scene.h"

#include <stdlib.h>
#include <string.h>

void scene_free(scene *s)
{
    for (size_t i = 0; i < s->light_count; i++) free(s->lights[i].name);
    free(s->lights);
    free(s->camera_positions_ws);
    free(s->triangle_flags);
    free(s->indices);
    free(s->positions_ws);
    free(s->name);
    memset(s, 0, sizeof *s);
}
