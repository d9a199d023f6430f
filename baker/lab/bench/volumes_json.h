/* Error against run time of shadows in fog as JSON (docs/volumes.schema.json), which `make bench-volumes` writes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VOLUMES_JSON_H
#define VOLUMES_JSON_H

#include <jansson.h>

#include "baker/base/message.h"

/* Whether this JSON claims to be such a file, and not a result of vxs bench. */
int is_volumes_json(const json_t *measured);

/* As bench_json_check. */
vxs_result volumes_json_check(const json_t *volumes, const char *path, message *m);

#endif
