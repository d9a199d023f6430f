/* Any bytes as a .vxs file: opened within a memory limit, checked to the last finding, and, when the reader takes them, looked up
 * in every light at points within, around and far outside its volume. A good file is opened again with too little memory.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <string.h>

#include "formats/vxs_findings.h"
#include "fuzz.h"
#include "fuzz_places.h"
#include "runtime/vxs_stream.h"
#include "tests/unit/alloc_fail.h"

enum { MEMORY_LIMIT_BYTES = 64 << 20, LIGHTS_LOOKED_UP = 8, POINTS_PER_LIGHT = 160 };

/* opening ---------------------------------------------------------------------------------------------------------------------- */

typedef struct findings {
    int first, count;
} findings;

/* "Printed" in full, as validate does: number, text and place are read. */
static void print_finding(void *user, int number, const char *text, int section, uint64_t offset)
{
    findings *f = user;
    char      line[512];
    snprintf(line, sizeof line, "finding %d: %s (section %d, byte %llu)", number, text, section, (unsigned long long)offset);
    FUZZ_CHECK(number > 0 && text[0] && section >= -1);
    if (!f->count++) f->first = number;
}

static vxs_result result_of(int number)
{
#define RESULT_OF(n, result, text)                                                                                                 \
    if (number == n) return result;
    VXS_FINDINGS(RESULT_OF)
#undef RESULT_OF
    return VXS_OK;
}

static vxs_result open_asset(vxs_asset **asset, alloc_fail *memory, int find_all, const uint8_t *data, size_t size, findings *f)
{
    vxs_allocator allocator = alloc_fail_allocator(memory);
    vxs_read_desc desc      = {.allocator          = &allocator,
                               .memory_limit_bytes = MEMORY_LIMIT_BYTES,
                               .finding            = print_finding,
                               .finding_user       = f,
                               .find_all           = find_all,
                               .metadata           = 1};
    vxs_result    r         = vxs_asset_open(asset, data, size, &desc);
    FUZZ_CHECK((r == VXS_OK) == (*asset != NULL) && (r == VXS_OK) == !f->count);
    FUZZ_CHECK(r == result_of(f->first));
    FUZZ_CHECK(memory->peak_bytes <= MEMORY_LIMIT_BYTES + 4096); /* the asset itself is not counted */
    return r;
}

/* The same file with half of what it needs, and with one allocation that fails: no asset, and nothing is kept. */
static void open_without_memory(const uint8_t *data, size_t size, const alloc_fail *needed, uint64_t random)
{
    for (int failing = 0; failing < 2; failing++) {
        alloc_fail    memory    = {.fail_at = failing ? 1 + random % needed->calls : 0};
        vxs_allocator allocator = alloc_fail_allocator(&memory);
        vxs_read_desc desc = {.allocator = &allocator, .memory_limit_bytes = failing ? 0 : needed->peak_bytes / 2, .metadata = 1};
        vxs_asset    *asset;
        FUZZ_CHECK(vxs_asset_open(&asset, data, size, &desc) == VXS_E_MEMORY && !asset);
        FUZZ_CHECK(!memory.live_bytes && !memory.wrong_sizes);
    }
}

/* looking up ------------------------------------------------------------------------------------------------------------------- */

static void check_lit(float lit, int width_px)
{
    FUZZ_CHECK(lit == VXS_OUTSIDE || (lit >= 0 && lit <= 1)); /* NaN is neither */
    if (width_px == 1) FUZZ_CHECK(lit == VXS_OUTSIDE || lit == 0 || lit == 1);
}

static void look_up(const vxs_baked_light *l, uint64_t *random)
{
    static const double normals[][3] = {{0, 1, 0}, {-1, 0, 0}, {0.6, 0, -0.8}};
    for (int n = 0; n < POINTS_PER_LIGHT; n++) {
        double point[3];
        point_ws(&l->light, random, point);
        const double *normal = normals[n % 3];
        float         single = vxs_lookup(l, point, NULL, vxs_box(1)), box = vxs_lookup(l, point, NULL, vxs_box(9));
        check_lit(single, 1);
        check_lit(box, 9);
        FUZZ_CHECK((single == VXS_OUTSIDE) == (box == VXS_OUTSIDE));
        check_lit(vxs_lookup(l, point, normal, vxs_box(1)), 1);
        check_lit(vxs_lookup(l, point, normal, vxs_box(9)), 9);
        check_lit(vxs_lookup(l, point, normal, vxs_box(VXS_FILTER_MAX)), VXS_FILTER_MAX);
    }
}

static void look_through_smoke(const vxs_light *l, const vxs_baked_smoke *smoke, uint64_t *random)
{
    for (int n = 0; smoke && n < POINTS_PER_LIGHT; n++) {
        double point[3];
        point_ws(l, random, point);
        float left = vxs_smoke_lookup(l, smoke, point);
        FUZZ_CHECK(left >= 0 && left <= 1); /* NaN is neither */
    }
}

/* all of it -------------------------------------------------------------------------------------------------------------------- */

/* The same bytes as a stream: opened within the limit where the whole file is, and maybe where it is not, since less of it is read;
 * what is looked up is the answer of the whole file, where there is one and the answer is full.   whole  NULL: the file was refused
 * */
static void stream_file(const uint8_t *data, size_t size, const vxs_asset *whole, uint64_t random)
{
    alloc_fail        memory    = {0};
    vxs_allocator     allocator = alloc_fail_allocator(&memory);
    vxs_stream_focus  all       = {{-1, -1, -1}, {1, 1, 1}, 0, 0};
    vxs_stream_status status    = {.struct_size = sizeof status};
    vxs_stream_desc   desc      = {.struct_size       = sizeof desc,
                                   .bytes             = data,
                                   .size_bytes        = size,
                                   .budget_bytes      = 4 * (uint64_t)MEMORY_LIMIT_BYTES,
                                   .decodes_per_frame = 64,
                                   .requests          = 64,
                                   .allocator         = &allocator};
    vxs_stream       *stream;
    vxs_result        r = vxs_stream_open(&stream, &desc);
    FUZZ_CHECK((r == VXS_OK) == (stream != NULL) && (r == VXS_OK || !whole) && memory.peak_bytes <= desc.budget_bytes);
    for (int frame = 0; stream && frame < 4; frame++) {
        FUZZ_CHECK(vxs_stream_frame(stream, &all, 1, &status) == VXS_OK && (!whole || !status.pages_failed));
        for (uint32_t n = 0; n < vxs_stream_light_count(stream) && n < LIGHTS_LOOKED_UP; n++) {
            const vxs_baked_light *light = vxs_stream_light(stream, n);
            double                 point[3];
            look_up(light, &random);
            look_through_smoke(&light->light, vxs_stream_smoke(stream, n), &random);
            point_ws(&light->light, &random, point);
            if (whole)
                FUZZ_CHECK(vxs_smoke_lookup(&light->light, vxs_stream_smoke(stream, n), point) ==
                           vxs_smoke_lookup(&light->light, vxs_asset_smoke(whole, n), point));
            if (!whole || !vxs_lookup_is_full(light, point, NULL, vxs_box(9))) continue;
            FUZZ_CHECK(vxs_lookup(light, point, NULL, vxs_box(9)) ==
                       vxs_lookup(vxs_asset_light(whole, n), point, NULL, vxs_box(9)));
        }
    }
    vxs_stream_close(stream);
    FUZZ_CHECK(!memory.live_bytes && !memory.wrong_sizes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    alloc_fail all_memory = {0}, memory = {0};
    findings   all = {0}, first = {0};
    vxs_asset *asset;
    vxs_result checked = open_asset(&asset, &all_memory, 1, data, size, &all);
    vxs_asset_close(asset);
    vxs_result opened = open_asset(&asset, &memory, 0, data, size, &first);
    FUZZ_CHECK(opened == checked && first.first == all.first);

    uint64_t random = size;
    for (uint32_t n = 0; asset && n < vxs_asset_light_count(asset); n++) {
        const vxs_baked_light *light = vxs_asset_light(asset, n);
        FUZZ_CHECK(vxs_asset_find_light(asset, light->light.name) == light);
        if (n < LIGHTS_LOOKED_UP) look_up(light, &random);
        if (n < LIGHTS_LOOKED_UP) look_through_smoke(&light->light, vxs_asset_smoke(asset, n), &random);
    }
    if (asset && vxs_asset_contents(asset)->metadata)
        FUZZ_CHECK(strlen(vxs_asset_contents(asset)->metadata) <= vxs_asset_contents(asset)->metadata_bytes);
    if (asset) open_without_memory(data, size, &memory, random);
    stream_file(data, size, asset, random);
    vxs_asset_close(asset);
    FUZZ_CHECK(!memory.live_bytes && !memory.wrong_sizes && !all_memory.live_bytes && !all_memory.wrong_sizes);
    return 0;
}
