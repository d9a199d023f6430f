/* The maps of spot and point lights; see light_fit.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LAMP_FIT_H
#define LAMP_FIT_H

#include "baker/light/light_fit.h"

/* light  [in] its name is set   axes  rows: u, v, and the light's direction; right-handed */
vxs_result lamp_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, double axes[3][3], message *m);

#endif
