/* A .vxs file that is streamed; see asset_open.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/asset_open.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/threads.h"
#include "baker/files/input_file.h"

enum { PAGES_A_FRAME = 4, THREADS = 4, FILL_FRAMES_MAX = 100000 };

/* From this budget on, the memory that threads need for decoding is a small part of the budget. */
static const uint64_t threads_from_bytes = (uint64_t)64 << 20;

static void keep_metadata(void *user, const char *text, size_t size_bytes)
{
    vxs_contents *c   = user;
    c->metadata       = malloc(size_bytes + 1); /* out of memory: treated as a file without metadata */
    c->metadata_bytes = c->metadata ? size_bytes : 0;
    if (!c->metadata) return;
    memcpy(c->metadata, text, size_bytes);
    c->metadata[size_bytes] = '\0';
}

static void skip_metadata(void *user, const char *text, size_t size_bytes)
{
    (void)user;
    (void)text;
    (void)size_bytes;
}

static void keep_points(void *user, const vxs_baked_points *points)
{
    vxs_baked_points *kept       = user;
    const size_t      size_bytes = points->count * 3 * sizeof *points->coordinates;
    uint16_t         *copy       = malloc(size_bytes); /* out of memory: treated as a file without points */
    if (!copy) return;
    *kept             = *points;
    kept->coordinates = memcpy(copy, points->coordinates, size_bytes);
}

static void skip_points(void *user, const vxs_baked_points *points)
{
    (void)user;
    (void)points;
}

static void keep_failure(void *user, uint32_t light, uint32_t page, vxs_result result, int finding)
{
    asset_stream *s    = user;
    const char   *name = s->contents.lights[light].light.name;
    if (s->broken != VXS_OK) return;
    s->broken = result;
    if (result == VXS_E_CORRUPT)
        snprintf(s->broken_text, sizeof s->broken_text, "is not a valid .vxs file: page %u of light '%s' (finding %d)", page, name,
                 finding);
    else
        snprintf(s->broken_text, sizeof s->broken_text, "cannot be read: page %u of light '%s'", page, name);
}

static void forget_contents(asset_stream *s)
{
    free(s->contents.metadata);
    free(s->contents.lights);
    free((void *)s->points.coordinates);
    s->contents = (vxs_contents){0};
    s->points   = (vxs_baked_points){0};
}

/* The last attempt uses one thread, which needs the least memory. */
static vxs_result open_stream(asset_stream *s, vxs_stream_desc *desc)
{
    vxs_result r = vxs_stream_open(&s->stream, desc);
    if (r != VXS_E_MEMORY || desc->threads <= 1) return r;
    desc->threads = 1;
    forget_contents(s);
    return vxs_stream_open(&s->stream, desc);
}

static int opens_within(vxs_stream_desc desc, uint64_t budget_bytes)
{
    vxs_stream *stream;
    desc.budget_bytes = budget_bytes;
    desc.metadata     = skip_metadata;
    if (desc.points) desc.points = skip_points;
    desc.finding = NULL;
    vxs_result r = vxs_stream_open(&stream, &desc);
    vxs_stream_close(stream);
    return r == VXS_OK;
}

/* The smallest budget above `low` with which the file opens; 0: there is none. */
static uint64_t least_budget(const vxs_stream_desc *desc, uint64_t low)
{
    uint64_t high = low;
    do {
        if (high > UINT64_MAX / 4) return 0;
        low  = high;
        high = 2 * high + 1;
    } while (!opens_within(*desc, high));
    while (high - low > 1) {
        uint64_t middle = low + (high - low) / 2;
        if (opens_within(*desc, middle))
            high = middle;
        else
            low = middle;
    }
    return high;
}

static vxs_result fail_opening(asset_stream *s, const vxs_stream_desc *desc, vxs_result r, const first_finding *f, run_context *m)
{
    if (r == VXS_E_READ && !f->number)
        return fail(m, r, "cannot read '%s': %s", s->path, errno ? strerror(errno) : "it is cut short");
    uint64_t least = f->number == 211 ? least_budget(desc, desc->budget_bytes) : 0;
    if (!least) return asset_fail(s->path, r, f, "", m);
    char needed[32];
    return fail(m, r, "--budget %llu: '%s' needs at least %llu bytes, %s", (unsigned long long)desc->budget_bytes, s->path,
                (unsigned long long)least, size_text(needed, least));
}

/* List the lights of the stream. */
static vxs_result list_lights(asset_stream *s, run_context *m)
{
    vxs_contents *c = &s->contents;
    c->light_count  = vxs_stream_light_count(s->stream);
    c->lights       = malloc(c->light_count * sizeof *c->lights);
    if (!c->lights) return fail(m, VXS_E_MEMORY, "out of memory for %u lights", c->light_count);
    for (uint32_t n = 0; n < c->light_count; n++) c->lights[n] = *vxs_stream_light(s->stream, n);
    return VXS_OK;
}

/* Pass the names of lights to the stream. */
typedef struct name_texts {
    char (*texts)[VXS_LIGHT_NAME_BYTES]; /* owned */
    const char *names[VXS_LIGHTS_MAX];
} name_texts;

/* A given name matches no light: it is a pattern, or wrong. The lights are known only when all are open, so open all, expand the
 * patterns, and close the stream again.
 * lights, light_count  scratch */
static vxs_result expand_patterns(asset_stream *s, vxs_stream_desc *desc, const text_list *names, name_texts *out,
                                  const vxs_baked_light **lights, uint32_t *light_count, run_context *m)
{
    vxs_stream_desc all = *desc;
    all.light_names     = NULL;
    all.budget_bytes    = UINT64_MAX;
    forget_contents(s);
    vxs_result r = open_stream(s, &all);
    if (r == VXS_OK) r = list_lights(s, m);
    if (r == VXS_OK) r = asset_choose_lights(&s->contents, s->path, names, lights, light_count, m);
    if (r == VXS_OK && !(out->texts = malloc(*light_count * sizeof *out->texts)))
        r = fail(m, VXS_E_MEMORY, "out of memory for %u lights", *light_count);
    for (uint32_t n = 0; r == VXS_OK && n < *light_count; n++) {
        memcpy(out->texts[n], lights[n]->light.name, sizeof *out->texts);
        out->names[n] = out->texts[n];
    }
    vxs_stream_close(s->stream);
    s->stream = NULL;
    forget_contents(s);
    desc->light_names      = out->names;
    desc->light_name_count = *light_count;
    return r;
}

vxs_result asset_stream_open(asset_stream *s, const char *path, uint64_t budget_bytes, const text_list *names, int points,
                             const vxs_baked_light **lights, const vxs_baked_smoke **smoke, uint32_t *light_count, run_context *m)
{
    first_finding f        = {0};
    name_texts    expanded = {0};
    *s                     = (asset_stream){.path = path};
    if (is_read_once(path))
        return fail(m, VXS_E_ARGUMENT, "--budget: %s is read once, from its beginning to its end: expected a file",
                    input_name(path));
    vxs_stream_desc desc = (vxs_stream_desc){.struct_size       = sizeof(vxs_stream_desc),
                                             .path              = s->path,
                                             .budget_bytes      = budget_bytes,
                                             .threads           = !HAS_THREADS                         ? 0
                                                                  : budget_bytes >= threads_from_bytes ? THREADS
                                                                                                       : 1,
                                             .requests          = PAGES_A_FRAME,
                                             .decodes_per_frame = PAGES_A_FRAME, /* without threads */
                                             .light_names       = names->count ? names->items : NULL,
                                             .light_name_count  = (uint32_t)names->count,
                                             .failed            = keep_failure,
                                             .failed_user       = s,
                                             .metadata          = keep_metadata,
                                             .metadata_user     = &s->contents,
                                             .points            = points ? keep_points : NULL,
                                             .points_user       = &s->points};
    desc.finding         = keep_first_finding;
    desc.finding_user    = &f;
    errno                = 0;
    vxs_result r         = open_stream(s, &desc);
    if (names->count && (r == VXS_E_ARGUMENT || f.number == 211)) { /* with a small budget, opening may fail before names are
                                                                       checked */
        f = (first_finding){0};
        r = expand_patterns(s, &desc, names, &expanded, lights, light_count, m);
        if (r == VXS_OK) r = open_stream(s, &desc);
    }
    if (r != VXS_OK && !m->error[0]) r = fail_opening(s, &desc, r, &f, m);
    if (r == VXS_OK) r = list_lights(s, m);
    for (uint32_t n = 0; r == VXS_OK && n < s->contents.light_count; n++) smoke[n] = vxs_stream_smoke(s->stream, n);
    static const text_list all = {0};
    if (r == VXS_OK) r = asset_choose_lights(&s->contents, path, expanded.texts ? &all : names, lights, light_count, m);
    free(expanded.texts);
    return r;
}

vxs_result asset_stream_frame(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, run_context *m)
{
    const vxs_stream_focus eye = vxs_stream_camera(eye_ws, 0);
    vxs_stream_wait(s->stream);
    vxs_result r = vxs_stream_frame(s->stream, &eye, 1, status);
    if (r == VXS_OK && s->broken != VXS_OK) return fail(m, s->broken, "'%s' %s", s->path, s->broken_text);
    return r;
}

vxs_result asset_stream_fill(asset_stream *s, const double eye_ws[3], vxs_stream_status *status, run_context *m)
{
    vxs_result r        = VXS_OK;
    uint32_t   appeared = 0, left = 0;
    for (int n = 0; n < FILL_FRAMES_MAX && r == VXS_OK; n++) {
        r = asset_stream_frame(s, eye_ws, status, m);
        appeared += status->appeared;
        left += status->left;
        if (!status->pages_coming && !status->reads) break;
    }
    status->appeared = appeared;
    status->left     = left;
    return r;
}

void asset_stream_close(asset_stream *s)
{
    vxs_stream_close(s->stream);
    forget_contents(s);
    s->stream = NULL;
}
