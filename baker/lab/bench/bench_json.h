/* Measurements as JSON: of bakes (docs/bench.schema.json), the one form that they have from the first run on; and of shadows in fog
 * (docs/volumes.schema.json), which `make bench-volumes` writes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_JSON_H
#define BENCH_JSON_H

#include <jansson.h>

#include "baker/base/run_context.h"
#include "baker/base/spread.h"

enum { BENCH_CELLS_MAX = 4096, BENCH_RUNS_MAX = 1000 };

/* Check that JSON is a result of vxs bench.   path  of its file.   Returns VXS_OK; VXS_E_READ, with the place in one line of m;
 * VXS_E_MEMORY. */
vxs_result bench_json_check(const json_t *bench, const char *path, run_context *m);

/* Read an untrusted file.
 * result  [out] NULL on failure; released with json_decref
 * Returns VXS_OK; VXS_E_READ: unreadable, not JSON, or not a result of vxs bench, with the place in one line of m; VXS_E_MEMORY. */
vxs_result bench_json_read(json_t **result, const char *path, run_context *m);

/* The member or item at a path: "bake/wall_seconds", "errors/0". NULL when there is none. */
json_t *json_at(const json_t *object, const char *path);

/* Members of JSON from bench_json_read or bench_run. A spread without a unit gets `unit`. */
uint64_t    count_at(const json_t *object, const char *path);
double      number_at(const json_t *object, const char *path);
const char *text_at(const json_t *object, const char *path);
spread      spread_at(const json_t *object, const char *path, double unit);

/* Whether two cells have the same scene and options. */
int bench_cells_equal(const json_t *a, const json_t *b);

/* Whether this JSON claims to be such a file, and not a result of vxs bench. */
int is_volumes_json(const json_t *measured);

/* As bench_json_check. */
vxs_result volumes_json_check(const json_t *volumes, const char *path, run_context *m);

#endif
