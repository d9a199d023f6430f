/* Opening a .vxs file for a command; an error message names the first finding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_OPEN_H
#define ASSET_OPEN_H

#include "baker/base/message.h"
#include "baker/base/text.h"
#include "runtime/vxs.h"

/* asset  [out] NULL on failure; closed with vxs_asset_close.   Returns what vxs_asset_open_file returns. */
vxs_result asset_open(vxs_asset **asset, const char *path, message *m);

/* The size of an open file: its last section ends where it does. */
uint64_t asset_file_bytes(const vxs_asset *asset);

/* Choose lights of a file by name: all of them, in file order, when there is no name; else the named ones, in the order given.
 * lights  [out] [VXS_LIGHTS_MAX] valid until the asset is closed
 * Returns VXS_OK or VXS_E_ARGUMENT: no such light, or one given twice. */
vxs_result asset_choose_lights(const vxs_asset *asset, const text_list *names, const vxs_baked_light **lights, uint32_t *count,
                               message *m);

#endif
