/* Reading a grid of smoke from NRRD, a header of text before raw numbers (teem.sourceforge.net/nrrd/format.html):
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
 * Space is the scene's world space, metres, +Y up: sample (i, j, k) lies at origin + i, j and k times the directions. Without
 * directions, "spacings" are distances along x, y and z. Numbers are float, unsigned char (uint8) or unsigned short (uint16).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef NRRD_READ_H
#define NRRD_READ_H

#include "baker/base/message.h"
#include "baker/smoke/smoke_grid.h"

/* The header, of 64 KiB at most, is looked at first: it says how many numbers there are, and no more are read. Memory is counted by
 * m->memory_bytes.
 * factor  on all numbers, which then are extinction per metre
 * g       [out] zeroed; released with smoke_grid_free whatever is returned
 * Returns VXS_OK; VXS_E_READ; VXS_E_UNSUPPORTED: what NRRD has and this reader has not; VXS_E_SCENE: it is none, or has a number
 * that is no extinction; VXS_E_MEMORY. */
vxs_result nrrd_read(smoke_grid *g, const char *path, double factor, message *m);

#endif
