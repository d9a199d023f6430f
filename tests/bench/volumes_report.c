/* Cells as a table and as JSON (docs/volumes.schema.json); see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <math.h>
#include <stdio.h>

#include "baker/base/version.h"
#include "baker/files/json_file.h"
#include "baker/files/json_value.h"
#include "baker/opengl/gl.h"

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

static json_t *cell_json(const cell *c)
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
        json_set(&o, "error", error_json(&c->all));
        json_set(&o, "elsewhere", error_json(&c->elsewhere));
        if (c->epipole.count) json_set(&o, "epipole", error_json(&c->epipole));
        json_set(&o, "flicker", json_real(rounded(c->flicker, 4)));
        json_set(&o, "front", json_boolean(c->is_front));
    } else
        json_decref(ms);
    return o;
}

vxs_result volumes_report(const bench *b, const cell *cells, size_t count, message *m)
{
    json_t *o = json_object(), *list = json_array();
    printf("%-16s %-10s %10s %10s %10s %10s %10s\n", "technique", "knob", "ms", "error", "largest", "flicker", "front");
    for (size_t n = 0; n < count; n++) {
        const cell *c = &cells[n];
        if (c->is_refused)
            printf("%-16s %5u %-10s refused\n", c->technique->name, c->value, c->technique->knob);
        else
            printf("%-16s %5u %-10s %8.3g %10.2g %10.2g %10.2g %6s\n", c->technique->name, c->value, c->technique->knob,
                   1000 * c->spread.median, c->all.relative_rms, c->all.most, c->flicker, c->is_front ? "*" : "");
        json_append(&list, cell_json(c));
    }
    if (!b->json_path) {
        json_decref(o);
        json_decref(list);
        return VXS_OK;
    }
    json_set(&o, "generator", json_text("vxs " VXS_VERSION));
    json_set(&o, "scene", json_text(b->scene_path));
    json_set(&o, "asset", json_text(b->asset_path));
    json_set(&o, "light", json_text(vxs_asset_light(b->asset, b->number)->light.name));
    json_set(&o, "renderer", json_text(b->gl->renderer));
    json_set(&o, "eye", json_vector(b->pose.eye_ws));
    json_set(&o, "target", json_vector(b->pose.target_ws));
    json_set(&o, "width_px", json_integer(b->width));
    json_set(&o, "height_px", json_integer(b->height));
    json_set(&o, "extinction_per_metre", json_vector(b->medium.extinction));
    json_set(&o, "scattering_per_metre", json_vector(b->medium.scattering));
    json_set(&o, "anisotropy", json_real(b->medium.anisotropy));
    json_set(&o, "rounds", json_integer(b->rounds));
    json_set(&o, "cells", list);
    return json_write(b->json_path, o, m);
}
