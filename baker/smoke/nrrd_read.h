/* Reads a grid of smoke from NRRD, a text header before raw numbers (teem.sourceforge.net/nrrd/format.html):
 *
 *     NRRD0004
 *     type: float
 *     dimension: 3
 *     sizes: 64 96 64
 *     encoding: raw
 *     endian: little
 *     space dimension: 3
 *     space directions: (0.25,0,0) (0,0.25,0) (0,0,0.25)
 *     space origin: (-8,0,-8)
 *
 *     numbers, the first axis fastest
 *
 * Space is the world space of the scene, metres, +Y up: sample (i, j, k) is at origin + i, j and k times the directions. Without
 * directions, "spacings" are distances along x, y and z. Numbers are float, unsigned char (uint8) or unsigned short (uint16).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef NRRD_READ_H
#define NRRD_READ_H

#include "baker/base/message.h"
#include "baker/smoke/smoke_grid.h"

/* Reads the header first, at most 64 KiB; it gives the count of numbers, and no more are read. Memory is limited by
 * m->memory_bytes.
 * factor  multiplied with all numbers; the products are extinction per metre
 * g       [out] zeroed; released with smoke_grid_free whatever is returned
 * Returns VXS_OK; VXS_E_READ; VXS_E_UNSUPPORTED: a feature of NRRD that this reader lacks; VXS_E_SCENE: not NRRD, or a number that
 * is not a valid extinction; VXS_E_MEMORY. */
vxs_result nrrd_read(smoke_grid *g, const char *path, double factor, message *m);

#endif
