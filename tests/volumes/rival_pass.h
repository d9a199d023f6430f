/* A pass of a rival: techniques that others use for shadows in fog, beside those of libvxs_volumes and in its frames, so that what
 * they are given is the same: the eye's rays, the medium, the light and its map. They stand on the library's inside, and are no
 * part of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_PASS_H
#define RIVAL_PASS_H

#include "baker/base/embedded.h"
#include "runtime/volumes/volumes_state.h"

enum { RIVAL_IMAGE = 1, RIVAL_BLOCK = BLOCKS }; /* bindings of a rival's own image and uniform block */
enum { RIVAL_FORMAT_RG32F = 0x8230 };

/* A compute program of `names` (lines of #define), the text `with` of the library (NULL: none), the frame, and `count` texts of its
 * own. Returns 0 if it does not compile. */
gl_name rival_program(const vxs_volumes *v, const char *names, const volumes_text *with, const embedded *texts, size_t count);

/* Run it in groups x * y * z on the frame and light that are set.
 * image   a layered texture at RIVAL_IMAGE;  format  of it */
void rival_run(vxs_volumes *v, gl_name program, const vxs_shadow_depth_map *map, gl_name image, gl_enum format, uint32_t x,
               uint32_t y, uint32_t z);

/* Groups of `size` that have `count`. */
static inline uint32_t rival_groups(uint32_t count, uint32_t size)
{
    return (count + size - 1) / size;
}

#endif
