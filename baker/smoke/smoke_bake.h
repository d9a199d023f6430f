/* Smoke into an asset: a map of curves for each light that it reaches, as sections of a file that has all else.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_BAKE_H
#define SMOKE_BAKE_H

#include "baker/smoke/smoke_map.h"

/* What became of a light's smoke; all 0 where it loses no light. */
typedef struct smoke_counts {
    uint32_t      side_px;
    size_t        texels, curves, nodes; /* of its maps; curves: texels where light is lost */
    double        largest_error;         /* of a curve's transmittance, against the integral along its ray */
    smoke_lookups lookups;               /* between rays; 0 places: none was found that the light reaches */
    uint64_t      memory_bytes, stored_bytes;
} smoke_counts;

/* Add smoke to a file.
 * file    [in, out] replaced where some light is lost
 * counts  [out] [lights of the file]
 * Returns VXS_OK, VXS_E_MEMORY, or what context_check returns. */
vxs_result smoke_bake(vxs_bytes *file, const smoke_source *source, const smoke_settings *settings, int zstd_level,
                      smoke_counts *counts, bake_context *ctx);

#endif
