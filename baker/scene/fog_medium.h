/* What fills the air.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_MEDIUM_H
#define FOG_MEDIUM_H

/* As vxs_medium, with a top. */
typedef struct fog_medium {
    double scattering[3], extinction[3]; /* per metre */
    double anisotropy;
    double top_ws; /* height of its level top, metres; INFINITY: it is everywhere */
} fog_medium;

#endif
