/* Opening a .vxs file for a command, with one line that says what is wrong with it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_OPEN_H
#define ASSET_OPEN_H

#include "baker/base/message.h"
#include "runtime/vxs.h"

/* asset  [out] NULL on failure; closed with vxs_asset_close.   Returns what vxs_asset_open_file returns. */
vxs_result asset_open(vxs_asset **asset, const char *path, message *m);

/* The light that --light names.   light  [out] NULL on failure.   Returns VXS_OK or VXS_E_ARGUMENT. */
vxs_result asset_find_light(const vxs_light **light, const vxs_asset *asset, const char *name, message *m);

#endif
