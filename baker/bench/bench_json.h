/* Measurements as JSON (docs/bench.schema.json), and back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_JSON_H
#define BENCH_JSON_H

#include "baker/bench/bench.h"

/* path "-" is standard output. Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result bench_json_write(const char *path, const bench_result *result, message *m);

/* Read a file that anyone may have written.
 * result  [out] zero it first; released with bench_result_free, whatever is returned
 * Returns VXS_OK; VXS_E_READ: it cannot be read, is no JSON, or not what bench_json_write writes; VXS_E_MEMORY. */
vxs_result bench_json_read(bench_result *result, const char *path, message *m);

#endif
