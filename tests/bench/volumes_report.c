/* Cells as a table and as JSON (docs/volumes.schema.json); see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <math.h>
#include <stdio.h>

#include "baker/base/version.h"
#include "baker/files/json_file.h"
#include "baker/files/json_value.h"
#include "baker/lab/bench/machine.h"
#include "baker/lab/opengl/gl.h"

static int is_front(const cell *c)
{
    return !c->is_refused && c->behind <= 1;
}

static json_t *error_json(const picture_error *e)
{
    json_t *o = json_object();
    json_set(&o, "relative_rms", isfinite(e->relative_rms) ? json_real(rounded(e->relative_rms, 4)) : json_null());
    json_set(&o, "signed_mean", json_real(rounded(e->signed_mean, 4)));
    json_set(&o, "percentile_99", json_real(rounded(e->percentile_99, 4)));
    json_set(&o, "most", json_real(rounded(e->most, 4)));
    json_set(&o, "values", json_integer((json_int_t)e->count));
    return o;
}

static json_t *parts_json(const bench *b, const cell *c)
{
    json_t *list = json_array();
    for (int n = 0; n < PARTS && b->parts[n]; n++) {
        json_t *o = json_object();
        json_set(&o, "name", json_text(b->parts[n]));
        json_set(&o, "ms", json_real(rounded(1000 * c->part_medians[n], 4)));
        json_append(&list, o);
    }
    return list;
}

static json_t *cell_json(const bench *b, const cell *c)
{
    json_t *o = json_object(), *ms = json_object();
    json_set(&o, "technique", json_text(c->technique->name));
    json_set(&o, "knob", json_text(c->technique->knob));
    json_set(&o, "value", json_integer(c->value));
    json_set(&o, "refused", json_boolean(c->is_refused));
    json_set(&o, "open_ms", json_real(rounded(1000 * c->open_seconds, 4)));
    if (!c->is_refused) {
        json_set(&ms, "median", json_real(rounded(1000 * c->spread.median, 4)));
        json_set(&ms, "least", json_real(rounded(1000 * c->spread.min, 4)));
        json_set(&ms, "greatest", json_real(rounded(1000 * c->spread.max, 4)));
        json_set(&o, "ms", ms);
        if (b->parts[0]) json_set(&o, "parts", parts_json(b, c));
        if (b->has_creation) json_set(&o, "creation_ms", json_real(rounded(1000 * c->creation_median, 4)));
        if (c->technique->bytes) json_set(&o, "bytes_per_texel", json_real(rounded(c->bytes, 4)));
        json_set(&o, "error", error_json(&c->all));
        json_set(&o, "elsewhere", error_json(&c->elsewhere));
        if (c->epipole.count) json_set(&o, "epipole", error_json(&c->epipole));
        if (b->cameras > 1) json_set(&o, "flicker", json_real(rounded(c->flicker, 4)));
        json_set(&o, "behind", json_real(rounded(c->behind, 4)));
        json_set(&o, "front", json_boolean(is_front(c)));
    } else
        json_decref(ms);
    return o;
}

static json_t *techniques_json(const bench *b)
{
    json_t *list = json_array();
    for (size_t n = 0; n < b->technique_count; n++) {
        const technique *t = &b->techniques[n];
        json_t          *o = json_object();
        json_set(&o, "name", json_text(t->name));
        json_set(&o, "knob", json_text(t->knob));
        json_set(&o, "limit", json_text(t->limit));
        json_set(&o, "rival", json_boolean(t->is_rival));
        json_append(&list, o);
    }
    return list;
}

static json_t *machine_json(void)
{
    bench_machine machine = {0};
    json_t       *o       = json_object();
    if (machine_describe(&machine)) {
        json_set(&o, "processor", json_text(machine.processor));
        json_set(&o, "cores", json_integer((json_int_t)machine.cores));
        json_set(&o, "memory_bytes", json_integer((json_int_t)machine.memory_bytes));
        json_set(&o, "system", json_text(machine.system));
    }
    machine_free(&machine);
    return o;
}

static vxs_result write_json(const bench *b, const cell *cells, size_t count, run_context *m)
{
    json_t *o = json_object(), *list = json_array();
    for (size_t n = 0; n < count; n++) json_append(&list, cell_json(b, &cells[n]));
    json_set(&o, "generator", json_text("vxs " VXS_VERSION));
    json_set(&o, "machine", machine_json());
    json_set(&o, "reference", json_text(b->reference));
    json_set(&o, "light", json_text(b->light_name));
    json_set(&o, "renderer", json_text(b->gl->names.renderer));
    json_set(&o, "clock", json_text(b->clock == CLOCK_WALL ? "wall" : "processor"));
    json_set(&o, "width_px", json_integer(b->width));
    json_set(&o, "height_px", json_integer(b->height));
    b->describe(b, &o);
    json_set(&o, "rounds", json_integer(b->rounds));
    json_set(&o, "techniques", techniques_json(b));
    json_set(&o, "cells", list);
    return json_write(b->json_path, o, m);
}

static void print_cell(const bench *b, const cell *c)
{
    char setting[48], epipole[16] = "", behind[16] = "front";
    snprintf(setting, sizeof setting, "%u %s", c->value, c->technique->knob);
    printf("%-24s %-19s ", c->technique->name, setting);
    if (c->is_refused) {
        printf(" refused\n");
        return;
    }
    if (c->epipole.count) snprintf(epipole, sizeof epipole, "%.2g", c->epipole.relative_rms);
    if (!is_front(c)) snprintf(behind, sizeof behind, "%.3g x", c->behind);
    printf("%8.3g %9.2g %9.2g %9.2g %9.2g %9.2g %9s %9s", 1000 * c->spread.median, c->all.relative_rms, c->all.signed_mean,
           c->all.percentile_99, c->all.most, c->flicker, epipole, behind);
    for (int n = 0; n < PARTS && b->parts[n]; n++) printf(" %8.3g", 1000 * c->part_medians[n]);
    if (b->has_creation) printf(" %8.3g", 1000 * c->creation_median);
    if (c->technique->bytes) printf(" %8.4g", c->bytes);
    printf("\n");
}

vxs_result volumes_report(const bench *b, const cell *cells, size_t count, run_context *m)
{
    printf("%-24s %-19s %8s %9s %9s %9s %9s %9s %9s %9s", "technique", "knob", "ms", "RMS", "mean", "99 %", "largest", "flicker",
           "at lamp", "behind");
    for (int n = 0; n < PARTS && b->parts[n]; n++) printf(" %8s", b->parts[n]);
    if (b->has_creation) printf(" creation");
    printf("\n");
    for (size_t n = 0; n < count; n++) print_cell(b, &cells[n]);
    return b->json_path ? write_json(b, cells, count, m) : VXS_OK;
}
