/* Media and lights of fog as airlight's functions take them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_AIR_H
#define FOG_AIR_H

#include "baker/scene/smoke.h"
#include "runtime/volumes/vxs_air_path.h"

struct fog_light; /* of fog.h */

vxs_medium    fog_air_medium(const fog_medium *f);
vxs_air_light fog_air_light(const struct fog_light *light);

#endif
