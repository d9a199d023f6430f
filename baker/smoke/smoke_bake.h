/* Bakes smoke into an asset: a map of curves for each light that it affects, as additional sections of a finished file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_BAKE_H
#define SMOKE_BAKE_H

#include "baker/smoke/smoke_map.h"

/* Statistics of a light's smoke; all 0 if it loses no light. */
typedef struct smoke_counts {
    uint32_t      side_px;
    size_t        texels, curves, nodes; /* of its maps; curves: texels that lose light */
    double        largest_error;         /* of a curve's transmittance, against the integral along its ray */
    smoke_lookups lookups;               /* between rays; places 0: no lit point was found */
    uint64_t      memory_bytes, stored_bytes;
} smoke_counts;

/* Add smoke to a file.
 * file    [in, out] replaced if some light is lost
 * counts  [out] [lights of the file]
 * Returns VXS_OK, VXS_E_MEMORY, or what context_check returns. */
vxs_result smoke_bake(vxs_bytes *file, const smoke_source *source, const smoke_settings *settings, int zstd_level,
                      smoke_counts *counts, bake_context *ctx);

#endif
