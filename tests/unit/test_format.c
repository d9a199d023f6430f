/* The .vxs format: written data is read back, and bytes that break a rule of formats/vxs.md are refused with their finding.
 *
 * Checksums would hide the deeper checks, so files are also taken apart, changed inside, and put together again with checksums
 * that hold. Whatever is accepted then must be safe to look up: `walk` follows every offset.
 * VXS_GOLDEN_OUT=FOLDER writes the golden files of tests/golden/ instead.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>

#include "alloc_fail.h"
#include "dag_sample.h"
#include "formats/vxs_lookup.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "format_parts.h"

/* the words of a DAG ----------------------------------------------------------------------------------------------------------- */

static uint32_t map_count(const vxs_baked_light *l)
{
    return l->light.flags & VXS_LIGHT_CUBE ? 6 : 1;
}

/* Words 0 to 5 say where six roots are; behind them the nodes begin. */
static uint32_t root_of(const vxs_baked_light *l, uint32_t map)
{
    if (map_count(l) == 1) return 0;
    assert_in_range(l->words[map], 6, l->word_count - 1);
    assert_int_equal(vxs_face_root(l->words, map), l->words[map]);
    return l->words[map];
}

/* Every offset that a lookup could follow, checked without the reader's help. seen[w]: 1 + the level of the node at word w. */
static void walk_node(const vxs_baked_light *l, uint8_t *seen, uint32_t at, uint32_t level)
{
    assert_true(at < l->word_count);
    if (seen[at]) {
        assert_int_equal(seen[at], level + 1);
        return;
    }
    seen[at]        = (uint8_t)(level + 1);
    uint32_t states = l->words[at], offset = at;
    assert_int_equal(states >> 16, 0);
    for (uint32_t c = 0, masks = 0; c < 8; c++) {
        uint32_t state = states >> (2 * c) & 3;
        if (state == VXS_CHILD_SAME) assert_true(level ? c >= 4 && (states >> (2 * c - 8) & 3) == VXS_CHILD_OWN : masks);
        masks = state >= VXS_CHILD_OWN;
        if (state != VXS_CHILD_OWN) continue;
        assert_true(++offset < l->word_count);
        uint32_t child = l->words[offset];
        if (level)
            walk_node(l, seen, child, level - 1);
        else
            assert_true(child % 2 == 0 && child < l->word_count && child + 1 < l->word_count);
    }
}

static void walk(const vxs_baked_light *l)
{
    uint8_t *seen = dag_sample_alloc(l->word_count, 1);
    assert_in_range(l->light.levels, VXS_LEVELS_MIN, VXS_LEVELS_MAX);
    for (uint32_t map = 0; map < map_count(l); map++) walk_node(l, seen, root_of(l, map), l->light.levels - 3);
    free(seen);
    uint32_t side = 1u << l->light.levels;
    rng      r    = {l->word_count};
    for (int n = 0; n < 16; n++) {
        uint32_t i = rng_below(&r, side), j = rng_below(&r, side), k = rng_below(&r, side),
                 root = root_of(l, (uint32_t)n % map_count(l));
        assert_in_range(vxs_shadow(l->words, root, l->light.levels, i, j, k), 0, 1);
    }
}

/* An accepted file is safe, a refused one gives the reason. */
static int accepted(const vxs_bytes *file)
{
    vxs_contents contents;
    findings     f;
    if (read_bytes(&contents, file, &f, 0) != VXS_OK) return 0;
    for (uint32_t n = 0; n < contents.light_count; n++) walk(&contents.lights[n]);
    vxs_contents_free(&contents);
    return 1;
}

/* small files ------------------------------------------------------------------------------------------------------------------ */

static const char metadata[] = "{\"scene\":\"none\"}";

/* The file of vxs.md section 10: a map of 8 x 8 texels whose one node has a state of each kind. */
static vxs_bytes smallest_file(void)
{
    static const uint32_t slices[8] = {0, 0, 0, 2, 2, 1, 1, 1};
    static const uint64_t mask      = 0x000000003c3c0000u;
    vxs_write_light       light     = {
                  .light = {.name         = "sun",
                            .kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                            .levels       = 3,
                            .coding       = VXS_CODING_DAG,
                            .ls_from_ws   = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 8},
                            .texel_metres = 1,
                            .voxel_metres = 1,
                            .direction_ws = {0, -1, 0}},
                  .dag   = {.nodes = {slices}, .count = {1}, .level_count = 1, .masks = &mask, .mask_count = 1},
    };
    vxs_write_desc desc = {.lights = &light, .light_count = 1, .zstd_level = 19};
    vxs_bytes      file = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    return file;
}

/* Two lights of 16 x 16 and 32 x 32 texels, with shared, repeated and ended children, and metadata. */
static vxs_bytes sample_file(void)
{
    static const uint32_t roots[8]     = {2, 3, 1, 0, 2, 0, 1, 2};
    static const uint32_t slices[16]   = {0, 2, 2, 3, 1, 1, 1, 1, 0, 0, 3, 0, 2, 2, 4, 1};
    static const uint64_t masks[3]     = {0x00000000ffffffffu, 0x8040201008040201u, 0xfffffffffffffffeu};
    static const uint32_t high_root[8] = {2, 2, 3, 0, 2, 1, 3, 1};
    static const uint32_t high[16]     = {2, 3, 0, 1, 2, 3, 2, 0, 3, 3, 3, 3, 1, 1, 1, 1};
    const vxs_light       common       = {.kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                                          .coding       = VXS_CODING_DAG,
                                          .ls_from_ws   = {2, 0, 0, 2, 0, 0, 2, -4, 0, -1, 0, 10},
                                          .texel_metres = 0.5,
                                          .voxel_metres = 1,
                                          .direction_ws = {0, -1, 0}};
    vxs_write_light       lights[2]    = {{.light = common}, {.light = common}};
    lights[0].light.levels             = 4;
    lights[1].light.levels             = 5;
    lights[1].light.flags              = VXS_LIGHT_BOUNDED;
    strcpy(lights[0].light.name, "sun");
    strcpy(lights[1].light.name, "moon");
    lights[0].dag = (vxs_dag_view){{slices, roots}, {2, 1}, 2, masks, 3, {0}};
    lights[1].dag = (vxs_dag_view){{slices, high, high_root}, {2, 2, 1}, 3, masks, 3, {0}};

    vxs_write_desc desc = {.lights = lights, .light_count = 2, .metadata = metadata, .zstd_level = 19};
    vxs_bytes      file = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    return file;
}

/* A spot, a wide spot and a point light of 16 x 16 texels, whose maps share nodes and masks; two roots of the last are the same
 * node. */
static vxs_bytes punctuals_file(void)
{
    static const uint32_t roots[4 * 8] = {2, 3, 1, 0, 2, 0, 1, 2, 0, 0, 0, 3, 1, 1, 1, 3,
                                          3, 2, 4, 0, 3, 2, 4, 1, 0, 0, 0, 0, 0, 0, 0, 0};
    static const uint32_t slices[24]   = {0, 2, 2, 3, 1, 1, 1, 1, 0, 0, 3, 0, 2, 2, 4, 1, 0, 0, 0, 0, 4, 4, 4, 4};
    static const uint64_t masks[3]     = {0x00000000ffffffffu, 0x8040201008040201u, 0xfffffffffffffffeu};
    const vxs_dag_view    dag          = {{slices, roots}, {3, 4}, 2, masks, 3, {0, 1, 2, 3, 1, 0}};
    const dag_sample      of           = {.levels = 4, .view = dag};
    vxs_write_light       lights[3]    = {dag_sample_punctual(&of, "spot", VXS_LIGHT_KIND_SPOT, 0),
                                          dag_sample_punctual(&of, "wide", VXS_LIGHT_KIND_SPOT, VXS_LIGHT_CUBE),
                                          dag_sample_punctual(&of, "point", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE)};
    lights[1].light.range_metres       = 6;
    lights[2].light.range_metres       = 10;
    vxs_write_desc desc                = {.lights = lights, .light_count = 3, .metadata = metadata, .zstd_level = 19};
    vxs_bytes      file                = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    return file;
}

/* written data is read back ------------------------------------------------------------------------------------------------- */

static void check_map(const vxs_baked_light *baked, uint32_t root, const dag_sample *s)
{
    uint32_t tiles = dag_sample_tiles(s), side = 8 * tiles;
    for (uint32_t k = 0; k < side; k++)
        for (uint32_t y = 0; y < tiles; y++)
            for (uint32_t x = 0; x < tiles; x++) {
                vxs_mask mask = vxs_slice(baked->words, root, baked->light.levels, x, y, k);
                if ((mask.low | (uint64_t)mask.high << 32) != s->dense[x + tiles * (y + (size_t)tiles * k)])
                    fail_msg("tile %u %u, slice %u", x, y, k);
            }
    if (side > 64) return;
    for (uint32_t k = 0; k < side; k++)
        for (uint32_t j = 0; j < side; j++)
            for (uint32_t i = 0; i < side; i++)
                if (vxs_shadow(baked->words, root, baked->light.levels, i, j, k) != dag_sample_shadow(s, i, j, k))
                    fail_msg("voxel %u %u %u", i, j, k);
}

static void check_light(const vxs_baked_light *baked, const vxs_write_light *wanted, dag_sample *s)
{
    const vxs_light *light = &baked->light;
    assert_string_equal(light->name, wanted->light.name);
    assert_int_equal(light->kind, wanted->light.kind);
    assert_int_equal(light->flags, wanted->light.flags);
    assert_int_equal(light->levels, wanted->light.levels);
    assert_int_equal(light->coding, wanted->light.coding);
    assert_memory_equal(light->ls_from_ws, wanted->light.ls_from_ws, sizeof light->ls_from_ws);
    assert_memory_equal(light->direction_ws, wanted->light.direction_ws, sizeof light->direction_ws);
    assert_true(light->texel_metres == wanted->light.texel_metres && light->voxel_metres == wanted->light.voxel_metres);
    assert_true(light->near_metres == wanted->light.near_metres && light->cos_outer == wanted->light.cos_outer);
    assert_true(light->range_metres == wanted->light.range_metres);
    walk(baked);
    for (uint32_t map = 0; map < map_count(baked); map++) {
        dag_sample_show(s, map);
        check_map(baked, root_of(baked, map), s);
    }
}

/* One of the five shapes of a light: a sun, a bounded one, a spot with one map, one with six, a point. */
static vxs_write_light sample_of_shape(const dag_sample *s, const char *name, uint32_t shape)
{
    vxs_write_light l = shape < 2   ? dag_sample_light(s, name)
                        : shape < 4 ? dag_sample_punctual(s, name, VXS_LIGHT_KIND_SPOT, shape == 3 ? VXS_LIGHT_CUBE : 0)
                                    : dag_sample_punctual(s, name, VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE);
    if (shape == 1) l.light.flags = VXS_LIGHT_BOUNDED;
    if (shape == 4) l.light.range_metres = 12.5;
    return l;
}

/* first_shape  of the first light; those after it have the next ones */
static void round_trip(uint64_t seed, uint32_t first_shape, uint32_t light_count, const uint32_t *levels, uint32_t count_max)
{
    dag_sample      s[5];
    vxs_write_light lights[5];
    rng             r = {seed};
    assert_in_range(light_count, 1, 5);
    for (uint32_t n = 0; n < light_count; n++) {
        static const char *const names[5] = {"sun", "moon", "a name that takes all of its sixty-three bytes: 0123456789abcdef", "l",
                                             "\xc3\xbc"};
        dag_sample_init(&s[n], &r, levels[n], count_max);
        lights[n] = sample_of_shape(&s[n], names[n], (first_shape + n) % 5);
    }
    vxs_write_desc desc = {.lights = lights, .light_count = light_count, .metadata = seed & 1 ? metadata : NULL, .zstd_level = 3};
    vxs_bytes      file = {0}, again = {0};
    vxs_contents   contents;
    findings       f;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_int_equal(vxs_write(&again, &desc), VXS_OK);
    assert_int_equal(file.size_bytes, again.size_bytes);
    assert_memory_equal(file.data, again.data, file.size_bytes);

    assert_int_equal(read_bytes(&contents, &file, &f, 0), VXS_OK);
    assert_int_equal(contents.version, 1);
    assert_int_equal(contents.light_count, light_count);
    for (uint32_t n = 0; n < light_count; n++) check_light(&contents.lights[n], &lights[n], &s[n]);
    if (desc.metadata) {
        assert_string_equal(contents.metadata, metadata);
        assert_int_equal(contents.metadata_bytes, strlen(metadata));
    } else {
        assert_null(contents.metadata);
    }
    vxs_contents_free(&contents);
    free(file.data);
    free(again.data);
    for (uint32_t n = 0; n < light_count; n++) dag_sample_free(&s[n]);
}

static void test_round_trip_small(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++)
        round_trip(seed, seed % 5, 1, (uint32_t[]){3 + (uint32_t)(seed % 4)}, seed % 3 ? 5 : 60);
}

static void test_round_trip_large(void **state)
{
    (void)state;
    for (uint32_t levels = 7; levels <= 9; levels++)
        for (uint64_t seed = 0; seed < 3; seed++) round_trip(1000 + seed, seed == 2 ? 4 : 0, 1, &levels, 300);
}

static void test_round_trip_many_lights(void **state)
{
    (void)state;
    round_trip(1, 0, 3, (uint32_t[]){3, 6, 5}, 40);
    round_trip(2, 0, 2, (uint32_t[]){4, 4}, 40);
    for (uint32_t first = 0; first < 5; first++) round_trip(first, first, 5, (uint32_t[]){3, 4, 5, 6, 3}, 30);
}

/* References of more than one byte, and masks by the hundred thousand. */
static void test_round_trip_long_references(void **state)
{
    (void)state;
    uint32_t levels = 8;
    round_trip(77, 0, 1, &levels, 100000);
}

/* words: what they take of the light's */
static void check_part(const vxs_baked_light *l, uint32_t index, const char *kind, uint32_t count, uint64_t words)
{
    assert_true(index < l->part_count);
    assert_string_equal(l->parts[index].kind, kind);
    assert_int_equal(l->parts[index].side_voxels, 8);
    assert_int_equal(l->parts[index].count, count);
    assert_int_equal(l->parts[index].memory_bytes, 4 * words);
    assert_int_equal(l->parts[index].section, index); /* the first light's come first in the file */
}

static void test_unreachable_nodes_are_left_out(void **state)
{
    (void)state;
    uint32_t        slices[3 * 8] = {0, 0, 2, 2, 3, 3, 1, 1, 4, 5, 4, 5, 4, 5, 4, 5, 1, 1, 1, 1, 5, 5, 5, 5};
    uint64_t        masks[4]      = {1, 2, 4, 8};
    dag_sample      none          = {.levels = 3};
    vxs_write_light light         = dag_sample_light(&none, "sun");
    light.dag = (vxs_dag_view){.nodes = {slices}, .count = {3}, .level_count = 1, .masks = masks, .mask_count = 4, .roots[0] = 0};

    vxs_write_desc desc      = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes      file      = {0};
    alloc_fail     a         = {0};
    vxs_allocator  allocator = alloc_fail_allocator(&a);
    vxs_contents   contents;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &(vxs_read_desc){.allocator = &allocator}), VXS_OK);
    const vxs_baked_light *l = contents.lights;
    assert_int_equal(l->part_count, 2);
    check_part(l, 0, "nodes", 1, 3);
    check_part(l, 1, "masks", 2, 4);
    assert_int_equal(l->word_count, 8); /* states, two offsets, padding, two masks */
    const uint32_t wanted[8] = {0x5ee0, 4, 6, 0, 1, 0, 2, 0};
    assert_memory_equal(l->words, wanted, sizeof wanted);
    vxs_contents_free(&contents);
    free(file.data);
}

/* Six roots that are one node are six nodes of the file, whose children are shared; the words of section 6. */
static void test_six_equal_roots(void **state)
{
    (void)state;
    uint32_t        slices[8] = {0, 0, 2, 2, 1, 1, 1, 1};
    uint64_t        mask      = 0x123456789abcdef0u;
    dag_sample      none      = {.levels = 3};
    vxs_write_light light     = dag_sample_punctual(&none, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE);
    light.dag                 = (vxs_dag_view){.nodes = {slices}, .count = {1}, .level_count = 1, .masks = &mask, .mask_count = 1};

    vxs_write_desc desc = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes      file = {0};
    vxs_contents   contents;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, NULL), VXS_OK);
    const vxs_baked_light *l          = contents.lights;
    const uint32_t         wanted[20] = {6,      8,  10,     12, 14,     16, 0x55e0, 18, 0x55e0,      18,
                                         0x55e0, 18, 0x55e0, 18, 0x55e0, 18, 0x55e0, 18, 0x9abcdef0u, 0x12345678u};
    check_part(l, 0, "nodes", 6, 12);
    check_part(l, 1, "masks", 1, 2);
    assert_int_equal(l->word_count, 20);
    assert_memory_equal(l->words, wanted, sizeof wanted);
    vxs_contents_free(&contents);
    free(file.data);
}

static void test_write_refuses(void **state)
{
    (void)state;
    dag_sample s;
    rng        r = {5};
    dag_sample_init(&s, &r, 4, 8);
    vxs_write_light lights[2] = {dag_sample_light(&s, "sun"), dag_sample_light(&s, "moon")};
    vxs_write_desc  desc      = {.lights = lights, .light_count = 2, .zstd_level = 1};
    vxs_bytes       file      = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
#define REFUSES(change, undo)                                                                                                      \
    change;                                                                                                                        \
    assert_int_equal(vxs_write(&file, &desc), VXS_E_ARGUMENT);                                                                     \
    undo
    REFUSES(desc.light_count = 0, desc.light_count = 2);
    REFUSES(desc.light_count = VXS_LIGHTS_MAX + 1, desc.light_count = 2);
    REFUSES(desc.zstd_level = 0, desc.zstd_level = 1);
    REFUSES(desc.zstd_level = 20, desc.zstd_level = 1);
    REFUSES(lights[1].light.levels = 5, lights[1].light.levels = 4);
    REFUSES(lights[1].light.levels = 2, lights[1].light.levels = 4);
    REFUSES(lights[1].light.levels = 19, lights[1].light.levels = 4);
    REFUSES(lights[1].light.coding = 0, lights[1].light.coding = VXS_CODING_DAG);
    REFUSES(lights[1].dag.roots[0] = lights[1].dag.count[1], lights[1].dag.roots[0] = 0);
    lights[1].light.kind  = VXS_LIGHT_KIND_POINT;
    lights[1].light.flags = VXS_LIGHT_CUBE;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    for (uint32_t map = 0; map < 6; map++) {
        REFUSES(lights[1].dag.roots[map] = lights[1].dag.count[1], lights[1].dag.roots[map] = 0);
    }
    lights[1].light.flags  = 0; /* then there is one root, and the others are not looked at */
    lights[1].dag.roots[5] = UINT32_MAX;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    REFUSES(lights[1].light.name[0] = 0, lights[1].light.name[0] = 'm');
    REFUSES(strcpy(lights[1].light.name, "sun"), strcpy(lights[1].light.name, "moon"));
    REFUSES(memset(lights[1].light.name, 'x', VXS_LIGHT_NAME_BYTES), strcpy(lights[1].light.name, "moon"));
#undef REFUSES
    free(file.data);
    dag_sample_free(&s);
}

static void test_optional_sections_are_skipped(void **state)
{
    (void)state;
    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    part *unknown  = add_part(&p, 0x31323334, VXS_SECTION_OPTIONAL, "not for this reader", 19);
    unknown->light = 7; /* it belongs to nothing */
    unknown->level = 99;
    unknown->stored.data[0] ^= 0xff; /* nor whether it is a zstd frame */
    add_part(&p, 0x31323334, VXS_SECTION_OPTIONAL, "twice", 5);
    file = put_together(&p);
    vxs_contents contents;
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &(vxs_read_desc){.metadata = 1}), VXS_OK);
    assert_int_equal(contents.section_count, p.count);
    assert_string_equal(contents.metadata, metadata);
    vxs_contents_free(&contents);
    free(file.data);

    unknown        = &p.part[p.count - 2];
    unknown->flags = 0;
    file           = put_together(&p);
    refused(&file, 205);
    free(file.data);
    parts_free(&p);
}

/* damaged files ---------------------------------------------------------------------------------------------------------------- */

static void every_prefix_is_refused(vxs_bytes file)
{
    for (size_t size = 0; size < file.size_bytes; size++) {
        vxs_bytes prefix = {0}; /* in memory of its own size, so that a read beyond it is seen */
        set_bytes(&prefix, file.data, size);
        refused(&prefix, size == 0 ? 101 : size < VXS_MAGIC_BYTES ? 102 : size < VXS_HEADER_BYTES ? 101 : 106);
        free(prefix.data);
    }
    vxs_bytes longer = {0};
    set_bytes(&longer, file.data, file.size_bytes);
    longer.data                        = realloc(longer.data, ++longer.size_bytes);
    longer.data[longer.size_bytes - 1] = 0;
    refused(&longer, 107);
    free(longer.data);
    free(file.data);
}

static void test_every_prefix_is_refused(void **state)
{
    (void)state;
    every_prefix_is_refused(sample_file());
    every_prefix_is_refused(punctuals_file());
}

static void every_flipped_bit_is_refused(vxs_bytes file)
{
    for (size_t bit = 0; bit < 8 * file.size_bytes; bit++) {
        file.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        if (accepted(&file)) fail_msg("bit %zu", bit);
        file.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_true(accepted(&file));
    free(file.data);
}

static void test_every_flipped_bit_is_refused(void **state)
{
    (void)state;
    every_flipped_bit_is_refused(sample_file());
    every_flipped_bit_is_refused(punctuals_file());
}

/* Under checksums that hold: every bit of every section's content, of every directory entry, and of the header. */
static void every_flipped_bit_under_checksums_is_safe(vxs_bytes file)
{
    parts p;
    take_apart(&p, &file);
    uint32_t taken = 0, total = 0;
    for (uint32_t n = 0; n < p.count; n++)
        for (size_t bit = 0; bit < 8 * p.part[n].content.size_bytes; bit++, total++) {
            uint8_t *byte = &p.part[n].content.data[bit / 8];
            *byte ^= (uint8_t)(1u << bit % 8);
            store(&p.part[n]);
            vxs_bytes changed = put_together(&p);
            taken += (uint32_t)accepted(&changed);
            free(changed.data);
            *byte ^= (uint8_t)(1u << bit % 8);
            if (bit + 1 == 8 * p.part[n].content.size_bytes) store(&p.part[n]);
        }
    for (size_t bit = 0; bit < 8 * (VXS_HEADER_BYTES + p.count * VXS_ENTRY_BYTES); bit++, total++) {
        vxs_bytes changed = {0};
        set_bytes(&changed, file.data, file.size_bytes);
        changed.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        seal(&changed);
        taken += (uint32_t)accepted(&changed);
        free(changed.data);
    }
    /* some are harmless: a mask, a name, a matrix; some are not */
    assert_in_range(taken, 500, total - 1000);
    parts_free(&p);
    free(file.data);
}

static void test_every_flipped_bit_under_checksums_is_safe(void **state)
{
    (void)state;
    every_flipped_bit_under_checksums_is_safe(sample_file());
    every_flipped_bit_under_checksums_is_safe(punctuals_file());
}

static void test_random_changes_under_checksums_are_safe(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 12; seed++) {
        rng        r = {seed};
        dag_sample s;
        dag_sample_init(&s, &r, 4 + (uint32_t)(seed % 3), 20);
        vxs_write_light light = sample_of_shape(&s, "light", (uint32_t)(seed % 5));
        vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = 1};
        vxs_bytes       file  = {0};
        assert_int_equal(vxs_write(&file, &desc), VXS_OK);
        for (int n = 0; n < 120; n++) {
            parts p;
            take_apart(&p, &file);
            for (uint32_t change = rng_below(&r, 4) + 1; change; change--) {
                part *to = &p.part[rng_below(&r, p.count)];
                if (!to->content.size_bytes) continue;
                uint32_t at = rng_below(&r, (uint32_t)to->content.size_bytes);
                if (rng_below(&r, 8))
                    to->content.data[at] = (uint8_t)rng_u32(&r);
                else
                    to->content.size_bytes = at;
                store(to);
            }
            vxs_bytes changed = put_together(&p);
            accepted(&changed);
            free(changed.data);
            parts_free(&p);
        }
        free(file.data);
        dag_sample_free(&s);
    }
}

/* a test for each finding ------------------------------------------------------------------------------------------------------ */

/* Change the bytes of a file, seal it, and see what is found. */
static void header_finding(int number, size_t at, uint64_t value, size_t bytes, int sealed)
{
    vxs_bytes file = sample_file();
    uint8_t   little[8];
    vxs_store64(little, value);
    memcpy(file.data + at, little, bytes);
    if (sealed) seal(&file);
    refused(&file, number);
    free(file.data);
}

static void test_header_findings(void **state)
{
    (void)state;
    header_finding(102, 7, 0, 1, 1);
    header_finding(103, VXS_HEADER_VERSION, VXS_FORMAT_VERSION + 1, 4, 1);
    header_finding(103, VXS_HEADER_VERSION, 0, 4, 0); /* a version may change how checksums are made, so it is looked at first */
    header_finding(104, VXS_HEADER_HASH, 0, 8, 0);
    header_finding(105, VXS_HEADER_RESERVED, 1, 1, 1);
    header_finding(105, VXS_HEADER_HASH - 1, 1, 1, 1);
    header_finding(106, VXS_HEADER_FILE_BYTES, UINT64_MAX, 8, 1);
    header_finding(107, VXS_HEADER_FILE_BYTES, 64, 8, 1);
    header_finding(108, VXS_HEADER_SECTION_COUNT, 0, 4, 1);
    header_finding(108, VXS_HEADER_SECTION_COUNT, 64, 4, 1);
    header_finding(108, VXS_HEADER_SECTION_COUNT, VXS_SECTIONS_MAX + 1, 4, 1);
    header_finding(108, VXS_HEADER_SECTION_COUNT, UINT32_MAX, 4, 1);
    header_finding(109, VXS_HEADER_BYTES + VXS_ENTRY_HASH, 0, 1, 0);
    uint8_t   bytes[VXS_HEADER_BYTES] = VXS_MAGIC;
    vxs_bytes file                    = {bytes, VXS_HEADER_BYTES - 1, 0};
    refused(&file, 101);
}

typedef void change_fn(parts *p);

static void finding_after(int number, change_fn *change)
{
    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    change(&p);
    file = put_together(&p);
    refused(&file, number);
    free(file.data);
    parts_free(&p);
}

/* The content of a section, to change; its stored bytes follow with `store`. */
static uint8_t *content_of(parts *p, uint32_t kind, uint32_t level)
{
    return find_part(p, kind, level)->content.data;
}

static void set_content(parts *p, uint32_t kind, uint32_t level, const void *content, size_t size)
{
    part *to = find_part(p, kind, level);
    set_bytes(&to->content, content, size);
    store(to);
}

static void drop(parts *p, uint32_t kind)
{
    part *gone = find_part(p, kind, 0);
    free(gone->content.data);
    free(gone->stored.data);
    memmove(gone, gone + 1, (size_t)(p->part + p->count - gone - 1) * sizeof *gone);
    p->count--;
}

static void undefined_flag(parts *p)
{
    p->part[0].flags = 2;
}
static void unknown_kind(parts *p)
{
    add_part(p, 0x20202020, 0, "?", 1);
}
static void not_a_frame(parts *p)
{
    p->part[0].stored.data[0] ^= 1;
}
static void wrong_size(parts *p)
{
    p->part[0].inflated_bytes++;
}
static void two_frames(parts *p)
{
    vxs_bytes *b = &p->part[0].stored;
    b->data      = realloc(b->data, 2 * b->size_bytes);
    memcpy(b->data + b->size_bytes, b->data, b->size_bytes);
    b->size_bytes *= 2;
}
static void broken_frame(parts *p)
{
    part *lights = find_part(p, VXS_KIND_LIGHTS, 0);
    memset(lights->stored.data + 9, 0xff, lights->stored.size_bytes - 9);
}
static void skippable_frame(parts *p)
{
    static const uint8_t frame[8] = {0x50, 0x2a, 0x4d, 0x18, 0, 0, 0, 0};
    part                *text     = find_part(p, VXS_KIND_METADATA, 0);
    set_bytes(&text->stored, frame, sizeof frame);
    text->inflated_bytes = 0;
}
static void empty_section(parts *p)
{
    part *text              = find_part(p, VXS_KIND_METADATA, 0);
    text->stored.size_bytes = 0;
}
static void endless_section(parts *p)
{
    find_part(p, VXS_KIND_MASKS, 0)->inflated_bytes = UINT64_MAX;
}
static void twice(parts *p)
{
    add_part(p, VXS_KIND_METADATA, 0, "{}", 2);
}
static void no_lights(parts *p)
{
    drop(p, VXS_KIND_LIGHTS);
}
static void no_masks(parts *p)
{
    drop(p, VXS_KIND_MASKS);
}
static void no_level(parts *p)
{
    drop(p, VXS_KIND_LEVEL);
}
static void other_light(parts *p)
{
    add_part(p, VXS_KIND_MASKS, 0, "", 0)->light = 2;
}
static void masks_of_a_level(parts *p)
{
    part *masks  = add_part(p, VXS_KIND_MASKS, 0, "", 0);
    masks->light = 0;
    masks->level = 1;
}
static void level_too_high(parts *p)
{
    part *level  = add_part(p, VXS_KIND_LEVEL, 0, "\1\0\0\0\0\0", 6);
    level->light = 0;
    level->level = 2;
}
static void metadata_of_a_light(parts *p)
{
    find_part(p, VXS_KIND_METADATA, 0)->light = 0;
}

static void test_directory_findings(void **state)
{
    (void)state;
    finding_after(201, undefined_flag);
    finding_after(205, unknown_kind);
    finding_after(207, not_a_frame);
    finding_after(207, wrong_size);
    finding_after(207, two_frames);
    finding_after(207, broken_frame);
    finding_after(207, skippable_frame);
    finding_after(207, empty_section);
    finding_after(207, endless_section);
    finding_after(208, twice);
    finding_after(209, no_lights);
    finding_after(209, no_masks);
    finding_after(209, no_level);
    finding_after(210, other_light);
    finding_after(210, masks_of_a_level);
    finding_after(210, level_too_high);
    finding_after(210, metadata_of_a_light);

    size_t entry = VXS_HEADER_BYTES + VXS_ENTRY_BYTES; /* of the second section */
    header_finding(202, entry + VXS_ENTRY_OFFSET, 0, 8, 1);
    header_finding(202, entry + VXS_ENTRY_OFFSET, UINT64_MAX, 8, 1);
    header_finding(203, entry + VXS_ENTRY_STORED_BYTES, 1u << 20, 8, 1);
    header_finding(203, entry + VXS_ENTRY_STORED_BYTES, UINT64_MAX, 8, 1);
    header_finding(206, entry + VXS_ENTRY_HASH, 0, 8, 1);

    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    p.part[p.count - 1].stored.size_bytes--; /* the last section says less than there is */
    vxs_bytes shorter                    = put_together(&p);
    shorter.data                         = realloc(shorter.data, ++shorter.size_bytes);
    shorter.data[shorter.size_bytes - 1] = 0;
    vxs_store64(shorter.data + VXS_HEADER_FILE_BYTES, shorter.size_bytes);
    seal(&shorter);
    refused(&shorter, 204);
    free(shorter.data);
    parts_free(&p);
    free(file.data);
}

/* A field of the second light. */
static void light_finding(int number, size_t at, const void *value, size_t bytes)
{
    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    memcpy(content_of(&p, VXS_KIND_LIGHTS, 0) + VXS_LIGHTS_PREFIX_BYTES + VXS_LIGHT_BYTES + at, value, bytes);
    store(find_part(&p, VXS_KIND_LIGHTS, 0));
    file = put_together(&p);
    refused(&file, number);
    free(file.data);
    parts_free(&p);
}

static void light_finding_f64(int number, size_t at, double value)
{
    uint8_t little[8];
    vxs_store_f64(little, value);
    light_finding(number, at, little, sizeof little);
}

/* Fields of a light of another kind: 0 the spot, 1 the wide one, 2 the point. */
typedef struct punctual_change {
    uint32_t punctual, flags;
    int      change_flags;
    size_t   at; /* of a number */
    double   value;
} punctual_change;

static vxs_bytes changed_punctuals(punctual_change c)
{
    vxs_bytes file = punctuals_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    uint8_t *record = content_of(&p, VXS_KIND_LIGHTS, 0) + VXS_LIGHTS_PREFIX_BYTES + c.punctual * VXS_LIGHT_BYTES;
    if (c.change_flags) vxs_store32(record + VXS_LIGHT_FLAGS, c.flags);
    if (c.at) vxs_store_f64(record + c.at, c.value);
    store(find_part(&p, VXS_KIND_LIGHTS, 0));
    file = put_together(&p);
    parts_free(&p);
    return file;
}

static void punctual_number(int number, uint32_t punctual, size_t at, double value)
{
    vxs_bytes file = changed_punctuals((punctual_change){.punctual = punctual, .at = at, .value = value});
    if (number)
        refused(&file, number);
    else
        assert_true(accepted(&file));
    free(file.data);
}

static void punctual_flags(int number, uint32_t punctual, uint32_t flags)
{
    vxs_bytes file = changed_punctuals((punctual_change){.punctual = punctual, .flags = flags, .change_flags = 1});
    refused(&file, number);
    free(file.data);
}

static void test_punctual_findings(void **state)
{
    (void)state;
    const double bad[]   = {(double)NAN, (double)INFINITY, -(double)INFINITY, -1, -1e-300};
    const size_t reach[] = {VXS_LIGHT_NEAR_METRES, VXS_LIGHT_COS_OUTER, VXS_LIGHT_RANGE_METRES};
    for (int n = 0; n < 3; n++)
        for (int k = 0; k < 5; k++) {
            light_finding_f64(308, reach[n], bad[k]); /* of the moon */
            for (uint32_t punctual = 0; punctual < 3; punctual++) punctual_number(308, punctual, reach[n], bad[k]);
        }
    for (int n = 0; n < 3; n++) light_finding_f64(308, reach[n], 0.5), light_finding_f64(308, reach[n], 5e-324);
    for (uint32_t punctual = 0; punctual < 3; punctual++) {
        int point = punctual == 2;
        punctual_number(308, punctual, VXS_LIGHT_NEAR_METRES, 0);
        punctual_number(0, punctual, VXS_LIGHT_NEAR_METRES, 5e-324);
        punctual_number(0, punctual, VXS_LIGHT_NEAR_METRES, 1e308);
        punctual_number(0, punctual, VXS_LIGHT_COS_OUTER, 0);
        punctual_number(point ? 308 : 0, punctual, VXS_LIGHT_COS_OUTER, 0.999999);
        punctual_number(308, punctual, VXS_LIGHT_COS_OUTER, 1);
        punctual_number(308, punctual, VXS_LIGHT_COS_OUTER, 2);
        punctual_number(0, punctual, VXS_LIGHT_RANGE_METRES, 0);
        punctual_number(0, punctual, VXS_LIGHT_RANGE_METRES, 5e-324);
        punctual_number(0, punctual, VXS_LIGHT_RANGE_METRES, 1e308);
        punctual_number(305, punctual, VXS_LIGHT_TEXEL_METRES, 0);
        punctual_number(305, punctual, VXS_LIGHT_VOXEL_METRES, (double)NAN);
        punctual_number(304, punctual, VXS_LIGHT_LS_FROM_WS + 8, (double)INFINITY);
    }
    for (uint32_t punctual = 0; punctual < 3; punctual++) {
        punctual_flags(307, punctual, VXS_LIGHT_BOUNDED);
        punctual_flags(307, punctual, VXS_LIGHT_BOUNDED | VXS_LIGHT_CUBE);
        punctual_flags(307, punctual, VXS_LIGHT_CUBE | 4);
        punctual_flags(307, punctual, VXS_LIGHT_CUBE | 1u << 31);
    }
    punctual_flags(307, 2, 0);              /* a point light has six maps */
    punctual_flags(404, 0, VXS_LIGHT_CUBE); /* one root is not six */
    punctual_flags(404, 1, 0);              /* nor six one */
    light_finding(307, VXS_LIGHT_FLAGS, "\3", 1);
    /* a sun that is marked as a punctual light, with nothing else changed */
    light_finding(308, VXS_LIGHT_KIND, "\2", 1);
    light_finding(308, VXS_LIGHT_KIND, "\3", 1);
}

/* A file whose one light has six roots, with other bytes in its top level. */
static void six_roots_finding(int number, uint32_t words_more, const void *content, size_t size)
{
    uint32_t        slices[8] = {0, 0, 0, 0, 1, 1, 1, 1};
    dag_sample      none      = {.levels = 3};
    vxs_write_light light     = dag_sample_punctual(&none, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE);
    vxs_write_desc  desc      = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes       file      = {0};
    parts           p;
    light.dag = (vxs_dag_view){.nodes = {slices}, .count = {1}, .level_count = 1};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    take_apart(&p, &file);
    free(file.data);
    if (content) set_content(&p, VXS_KIND_LEVEL, 0, content, size);
    uint8_t *words = content_of(&p, VXS_KIND_LIGHTS, 0) + VXS_LIGHTS_PREFIX_BYTES + VXS_LIGHT_WORD_COUNT;
    assert_int_equal(vxs_load32(words), 12); /* six offsets, six nodes without children */
    vxs_store32(words, 12 + words_more);
    store(find_part(&p, VXS_KIND_LIGHTS, 0));
    file = put_together(&p);
    if (number)
        refused(&file, number);
    else
        assert_true(accepted(&file));
    free(file.data);
    parts_free(&p);
}

static void test_six_roots_findings(void **state)
{
    (void)state;
    six_roots_finding(0, 0, NULL, 0);
    six_roots_finding(406, 0u - 6, NULL, 0); /* as if there were no offsets */
    six_roots_finding(406, 2, NULL, 0);
    static const uint8_t nodes[4 + 2 * 7] = {0};
    for (uint8_t roots = 0; roots <= 7; roots++) {
        uint8_t content[sizeof nodes] = {roots};
        six_roots_finding(roots == 6 ? 0 : 404, roots - 6u, content, 4u + 2u * roots);
    }
}

static void table_short(parts *p)
{
    find_part(p, VXS_KIND_LIGHTS, 0)->content.size_bytes--;
    store(find_part(p, VXS_KIND_LIGHTS, 0));
}
static void table_tiny(parts *p)
{
    set_content(p, VXS_KIND_LIGHTS, 0, "\1", 1);
}
static void table_empty(parts *p)
{
    set_content(p, VXS_KIND_LIGHTS, 0, "\0\0\0\0\0\1\0\0", 8);
}
static void table_of_others(parts *p)
{
    vxs_store32(content_of(p, VXS_KIND_LIGHTS, 0) + 4, VXS_LIGHT_BYTES + 8);
    store(find_part(p, VXS_KIND_LIGHTS, 0));
}
static void table_count(parts *p)
{
    vxs_store32(content_of(p, VXS_KIND_LIGHTS, 0), 0x01000002);
    store(find_part(p, VXS_KIND_LIGHTS, 0));
}

static void test_light_findings(void **state)
{
    (void)state;
    finding_after(301, table_short);
    finding_after(301, table_tiny);
    finding_after(301, table_empty);
    finding_after(301, table_of_others);
    finding_after(301, table_count);
    light_finding(302, VXS_LIGHT_KIND, "\4", 1);
    light_finding(303, VXS_LIGHT_LEVELS, "\2", 1);
    light_finding(303, VXS_LIGHT_LEVELS, "\x13", 1);
    light_finding(303, VXS_LIGHT_LEVELS, "\xff\xff\xff\xff", 4);
    light_finding_f64(304, VXS_LIGHT_LS_FROM_WS + 8 * 3, (double)INFINITY);
    light_finding_f64(304, VXS_LIGHT_LS_FROM_WS + 8 * 11, (double)NAN);
    light_finding_f64(304, VXS_LIGHT_LS_FROM_WS, 0); /* singular */
    light_finding_f64(305, VXS_LIGHT_TEXEL_METRES, 0);
    light_finding_f64(305, VXS_LIGHT_TEXEL_METRES, (double)NAN);
    light_finding_f64(305, VXS_LIGHT_VOXEL_METRES, -1);
    light_finding_f64(305, VXS_LIGHT_VOXEL_METRES, (double)INFINITY);
    light_finding_f64(305, VXS_LIGHT_DIRECTION, 0.01);
    light_finding_f64(305, VXS_LIGHT_DIRECTION, (double)NAN);
    char name[VXS_LIGHT_NAME_BYTES] = {0};
    light_finding(306, VXS_LIGHT_NAME, name, sizeof name);
    light_finding(306, VXS_LIGHT_NAME, strcpy(name, "sun"), sizeof name);
    strcpy(name, "moon");
    name[VXS_LIGHT_NAME_BYTES - 1] = 'x'; /* something behind the terminator */
    light_finding(306, VXS_LIGHT_NAME, name, sizeof name);
    memset(name, 'x', sizeof name);
    light_finding(306, VXS_LIGHT_NAME, name, sizeof name);
    light_finding(307, VXS_LIGHT_FLAGS, "\2", 1); /* a directional light has no cube */
    light_finding(307, VXS_LIGHT_FLAGS + 3, "\x80", 1);
    light_finding(307, VXS_LIGHT_CODING, "\1", 1); /* version 1 has none */
    light_finding(307, VXS_LIGHT_RESERVED, "\1", 1);
    light_finding(307, VXS_LIGHT_NAME - 1, "\1", 1);
}

/* Levels of the first light of the sample file: level 1 is the root with two children, level 0 two nodes with three masks. */
static void level_finding(int number, uint32_t level, const void *content, size_t size)
{
    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    set_content(&p, VXS_KIND_LEVEL, level, content, size);
    file = put_together(&p);
    refused(&file, number);
    free(file.data);
    parts_free(&p);
}

/* The same for its three masks; the word count follows, so that it is not what is found. */
static void masks_finding(int number, size_t size)
{
    static const uint8_t zeros[64] = {0};
    vxs_bytes            file      = sample_file();
    parts                p;
    take_apart(&p, &file);
    free(file.data);
    set_content(&p, VXS_KIND_MASKS, 0, zeros, size);
    uint8_t *words = content_of(&p, VXS_KIND_LIGHTS, 0) + VXS_LIGHTS_PREFIX_BYTES + VXS_LIGHT_WORD_COUNT;
    vxs_store32(words, vxs_load32(words) + (uint32_t)(size / 8) * 2 - 6);
    store(find_part(&p, VXS_KIND_LIGHTS, 0));
    file = put_together(&p);
    refused(&file, number);
    free(file.data);
    parts_free(&p);
}

static void word_count(parts *p)
{
    content_of(p, VXS_KIND_LIGHTS, 0)[VXS_LIGHTS_PREFIX_BYTES + VXS_LIGHT_WORD_COUNT]++;
    store(find_part(p, VXS_KIND_LIGHTS, 0));
}

static void test_level_findings(void **state)
{
    (void)state;
    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    /* what the cases below vary */
    static const uint8_t root[] = {1, 0, 0, 0, 0x1a, 0x93, 0, 0, 2};
    assert_int_equal(find_part(&p, VXS_KIND_LEVEL, 1)->content.size_bytes, sizeof root);
    assert_memory_equal(content_of(&p, VXS_KIND_LEVEL, 1), root, sizeof root);
    parts_free(&p);
#define LEVEL(number, level, ...)                                                                                                  \
    level_finding(number, level, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))
    LEVEL(401, 1, 1, 0, 0);          /* no count */
    LEVEL(401, 1, 2, 0, 0, 0, 0, 0); /* states missing */
    LEVEL(401, 1, 255, 255, 255, 255, 0, 0);
    LEVEL(401, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0);       /* a reference missing */
    LEVEL(401, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0, 0x80); /* half of one */
    LEVEL(401, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0, 2, 9); /* one too many */
    LEVEL(402, 1, 1, 0, 0, 0, 0x3a, 0x93, 0, 0, 2);    /* child 2 has no neighbour nearer */
    LEVEL(402, 1, 1, 0, 0, 0, 0x1a, 0xd3, 0, 0);       /* child 7 repeats child 3, which is lit */
    LEVEL(402, 0, 1, 0, 0, 0, 3, 0);                   /* slice 0 has none before it */
    LEVEL(402, 0, 1, 0, 0, 0, 0x0d, 0);                /* slice 1 repeats slice 0, which is shadow */
    LEVEL(403, 1, 1, 0, 0, 0, 0x1a, 0x93, 1, 0, 0);    /* back from nothing */
    LEVEL(403, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 2, 0);
    LEVEL(404, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0, 0);          /* a third node, where there are two */
    LEVEL(404, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 1, 1);          /* the second is unused */
    LEVEL(404, 1, 0, 0, 0, 0);                               /* no root */
    LEVEL(404, 1, 2, 0, 0, 0, 0, 0, 0, 0);                   /* two */
    LEVEL(405, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0x80, 0x00, 1); /* 0 in two bytes */
    LEVEL(405, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0xff, 0xff, 0xff, 0xff, 0x7f, 1);
    LEVEL(405, 1, 1, 0, 0, 0, 0x1a, 0x93, 0, 0x80, 0x80, 0x80, 0x80, 0x80, 0x01, 1);
#undef LEVEL
    masks_finding(401, 23);
    masks_finding(404, 16);
    masks_finding(404, 32);
    finding_after(406, word_count);
}

static void test_memory_limit(void **state)
{
    (void)state;
    size_t zeros_bytes = (size_t)16 << 20;
    char  *zeros       = dag_sample_alloc(zeros_bytes, 1);

    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    set_content(&p, VXS_KIND_METADATA, 0, zeros, zeros_bytes);
    set_content(&p, VXS_KIND_METADATA, 0, zeros, zeros_bytes);
    file = put_together(&p);
    assert_in_range(file.size_bytes, 1, 4096); /* it is a tiny file */

    alloc_fail    a         = {0};
    vxs_allocator allocator = alloc_fail_allocator(&a);
    findings      f         = {0};
    vxs_contents  contents;
    vxs_read_desc desc = {
        .allocator = &allocator, .memory_limit_bytes = 1 << 20, .finding = collect, .finding_user = &f, .metadata = 1};
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_E_MEMORY);
    assert_int_equal(f.first, 211);
    produced[211]++;
    assert_in_range(a.peak_bytes, 1, desc.memory_limit_bytes);
    assert_int_equal(a.live_bytes, 0);

    /* it is not requested, so it is not inflated */
    desc.metadata = 0;
    a             = (alloc_fail){0};
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_OK);
    assert_null(contents.metadata);
    assert_in_range(a.peak_bytes, 1, 1 << 16);
    vxs_contents_free(&contents);
    desc.metadata = 1;

    /* with enough, it is read; the limit is what was taken at most, to the byte */
    desc.memory_limit_bytes = 0;
    a                       = (alloc_fail){0};
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_OK);
    vxs_contents_free(&contents);
    assert_int_equal(a.live_bytes, 0);
    for (desc.memory_limit_bytes = a.peak_bytes - 1; desc.memory_limit_bytes <= a.peak_bytes; desc.memory_limit_bytes++) {
        vxs_result r = vxs_read(&contents, file.data, file.size_bytes, &desc);
        assert_int_equal(r, desc.memory_limit_bytes < a.peak_bytes ? VXS_E_MEMORY : VXS_OK);
        if (r == VXS_OK) vxs_contents_free(&contents);
    }
    free(file.data);
    free(zeros);
    parts_free(&p);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    vxs_bytes file = sample_file();
    assert_in_range(opened_without_memory(&file).calls, 10, 100);
    free(file.data);
}

static void test_find_all_goes_on(void **state)
{
    (void)state;
    vxs_bytes file = sample_file();
    for (uint32_t n = 0; n < 3; n++) file.data[VXS_HEADER_BYTES + n * VXS_ENTRY_BYTES + VXS_ENTRY_HASH] ^= 1;
    seal(&file);
    vxs_contents contents;
    findings     f;
    assert_int_equal(read_bytes(&contents, &file, &f, 1), VXS_E_CORRUPT);
    assert_int_equal(f.count, 3);
    assert_int_equal(f.section, 0);
    assert_int_equal(read_bytes(&contents, &file, &f, 0), VXS_E_CORRUPT);
    assert_int_equal(f.count, 1);
    free(file.data);
}

/* A directory of the same section over and over: one finding each, not one for each pair. */
static void test_repeated_sections_are_found_once_each(void **state)
{
    (void)state;
    vxs_bytes file = sample_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    uint32_t more = PARTS_MAX - p.count;
    while (p.count < PARTS_MAX) add_part(&p, VXS_KIND_METADATA, 0, "{}", 2);
    file = put_together(&p);
    vxs_contents contents;
    findings     f;
    assert_int_equal(read_bytes(&contents, &file, &f, 1), VXS_E_CORRUPT);
    assert_int_equal(f.first, 208);
    assert_int_equal(f.count, more);
    free(file.data);
    parts_free(&p);
}

/* Last: every number in the list is some file's first finding, so none of them is unreachable. */
static void test_every_finding_was_produced(void **state)
{
    (void)state;
#define WAS_PRODUCED(number, result, text)                                                                                         \
    if (!produced[number] && !is_of_blocks(number) && !is_of_smoke(number) && !is_of_points(number))                               \
        fail_msg("no test produced finding %d", number);
    VXS_FINDINGS(WAS_PRODUCED)
#undef WAS_PRODUCED
}

/* golden files ----------------------------------------------------------------------------------------------------------------- */

static vxs_bytes read_file(const char *path)
{
    vxs_bytes file = {dag_sample_alloc(1 << 16, 1), 0, 1 << 16};
    FILE     *from = fopen(path, "rb");
    if (from) {
        file.size_bytes = fread(file.data, 1, file.capacity_bytes, from);
        fclose(from);
    }
    return file;
}

/* Old files still open, and hold what is written today. Stored bytes may change with the version of zstd; contents may not. */
static void check_golden(const char *path, vxs_bytes now)
{
    vxs_bytes then = read_file(path);
    if (!then.size_bytes) {
        free(now.data);
        free(then.data);
        print_message("%s is not here: start this test in the root of the repository\n", path);
        skip();
    }
    assert_true(accepted(&then));
    parts a, b;
    take_apart(&a, &then);
    take_apart(&b, &now);
    assert_int_equal(a.count, b.count);
    for (uint32_t n = 0; n < a.count; n++) {
        assert_int_equal(a.part[n].kind, b.part[n].kind);
        assert_int_equal(a.part[n].flags, b.part[n].flags);
        assert_int_equal(a.part[n].light, b.part[n].light);
        assert_int_equal(a.part[n].level, b.part[n].level);
        assert_int_equal(a.part[n].content.size_bytes, b.part[n].content.size_bytes);
        assert_memory_equal(a.part[n].content.data, b.part[n].content.data, a.part[n].content.size_bytes);
    }
    parts_free(&a);
    parts_free(&b);
    free(now.data);
    free(then.data);
}

static void test_golden_smallest(void **state)
{
    (void)state;
    check_golden("tests/golden/smallest.vxs", smallest_file());
}

static void test_golden_sample(void **state)
{
    (void)state;
    check_golden("tests/golden/sample.vxs", sample_file());
}

static void test_golden_punctuals(void **state)
{
    (void)state;
    check_golden("tests/golden/lamps.vxs", punctuals_file());
}

static int write_golden(const char *folder, const char *name, vxs_bytes file)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *to   = fopen(path, "wb");
    int   good = to && fwrite(file.data, 1, file.size_bytes, to) == file.size_bytes;
    if (to && fclose(to)) good = 0;
    free(file.data);
    return good ? 0 : 1;
}

int main(void)
{
    const char *folder = getenv("VXS_GOLDEN_OUT");
    if (folder)
        return write_golden(folder, "smallest.vxs", smallest_file()) | write_golden(folder, "sample.vxs", sample_file()) |
               write_golden(folder, "lamps.vxs", punctuals_file());

    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip_small),
        cmocka_unit_test(test_round_trip_large),
        cmocka_unit_test(test_round_trip_many_lights),
        cmocka_unit_test(test_round_trip_long_references),
        cmocka_unit_test(test_unreachable_nodes_are_left_out),
        cmocka_unit_test(test_six_equal_roots),
        cmocka_unit_test(test_write_refuses),
        cmocka_unit_test(test_optional_sections_are_skipped),
        cmocka_unit_test(test_every_prefix_is_refused),
        cmocka_unit_test(test_every_flipped_bit_is_refused),
        cmocka_unit_test(test_every_flipped_bit_under_checksums_is_safe),
        cmocka_unit_test(test_random_changes_under_checksums_are_safe),
        cmocka_unit_test(test_header_findings),
        cmocka_unit_test(test_directory_findings),
        cmocka_unit_test(test_light_findings),
        cmocka_unit_test(test_punctual_findings),
        cmocka_unit_test(test_six_roots_findings),
        cmocka_unit_test(test_level_findings),
        cmocka_unit_test(test_memory_limit),
        cmocka_unit_test(test_failing_allocations),
        cmocka_unit_test(test_find_all_goes_on),
        cmocka_unit_test(test_repeated_sections_are_found_once_each),
        cmocka_unit_test(test_golden_smallest),
        cmocka_unit_test(test_golden_sample),
        cmocka_unit_test(test_golden_punctuals),
        cmocka_unit_test(test_every_finding_was_produced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
