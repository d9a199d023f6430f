/* Depth maps of a baked light for shadow-map shaders of engines, with the matrices that those take, in an engine's world space.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXPORT_DEPTH_H
#define EXPORT_DEPTH_H

#include <jansson.h>

#include "baker/base/run_context.h"
#include "formats/vxs_file.h"

/* World space of an engine, as the importers of these engines read glTF: Godot as it is; Unity (glTFast, UnityGLTF) with -x;
 * Unreal as 100 (x, z, y), in centimetres. */
typedef enum export_axes { EXPORT_GLTF, EXPORT_GODOT, EXPORT_UNITY, EXPORT_UNREAL } export_axes;
#define EXPORT_AXES_CHOICES "gltf|godot|unity|unreal"

/* Files of depth. PNG: 16 bits, depth 1 is 65535. RAW: 32-bit floats, little endian. Rows from the top, without padding. */
typedef enum export_format { EXPORT_PNG, EXPORT_RAW } export_format;
#define EXPORT_FORMAT_CHOICES "png|raw"

typedef struct export_depth {
    uint32_t      resolution_px; /* texels a side at most, a power of two; 0: no depth maps */
    export_format format;
} export_depth;

/* Change a matrix from glTF's world space into one from an engine's.
 * rows  [row_count] rows of four */
void export_turn(double *rows, int row_count, export_axes axes);

/* An array of numbers. NULL without memory. */
json_t *export_numbers(const double *numbers, int count);

/* Write the depth map of a map of a light, in bands of rows: memory follows the length of a row.
 * entry   [out] its description (docs/export.schema.json); NULL on failure
 * number  of the light in the export; part of the file's name
 * Returns VXS_OK, VXS_E_ARGUMENT (an input would be overwritten), VXS_E_WRITE, VXS_E_MEMORY. VXS_E_ARGUMENT
 * also for PNG in a build that writes none. */
vxs_result export_depth_map(json_t **entry, const char *folder, const vxs_baked_light *baked, uint32_t number, int map,
                            const export_depth *depth, export_axes axes, run_context *m);

#endif
