/* vxs bake --watch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_WATCH_H
#define BAKE_WATCH_H

#include "baker/base/run_context.h"

/* Bake, and again after each change of the scene's file or of a file that it names, until a signal ends the process. Each bake is
 * a process of its own. A bake that fails prints why; the next change is waited for all the same.
 * scene_path  a file, not standard input
 * bake        does all and returns the exit status
 * Returns a failure: VXS_E_UNSUPPORTED: this system cannot watch; VXS_E_READ: the scene's folder; VXS_E_MEMORY. */
vxs_result bake_watch(const char *scene_path, int (*bake)(void *work), void *work, run_context *m);

#endif
