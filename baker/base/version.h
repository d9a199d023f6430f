/* The version of vxs as text. The numbers are defined in runtime/vxs.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VERSION_H
#define VERSION_H

#include "runtime/vxs.h"

#define VERSION_TEXT_(x) #x
#define VERSION_TEXT(x)  VERSION_TEXT_(x)
#define VXS_VERSION      VERSION_TEXT(VXS_VERSION_MAJOR) "." VERSION_TEXT(VXS_VERSION_MINOR) "." VERSION_TEXT(VXS_VERSION_PATCH)

#endif
