/* The medium that fills the air.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_MEDIUM_H
#define FOG_MEDIUM_H

/* vxs_medium with an upper bound. */
typedef struct fog_medium {
    double scattering[3], extinction[3]; /* per metre */
    double anisotropy;
    double top_ws; /* height of its horizontal top, metres; INFINITY: unbounded */
} fog_medium;

#endif
