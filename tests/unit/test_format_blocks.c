/* Lights of palette blocks in .vxs files, version 2 of the format: words that are written are read back and looked up, beside DAGs,
 * and bytes that break a rule of formats/vxs.md are refused with their finding. Damaged pages are tests/unit/test_page.c's; here
 * they come in files whose checksums hold.
 * VXS_BLOCKS_OUT=FILE writes a file with lights of palette blocks instead, VXS_GOLDEN_OUT=FOLDER the golden file of tests/golden/.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before the baker, which has a type of a name that is a parameter here */
#include "formats/vxs_reader.h"

#include <stdio.h>

#include "alloc_fail.h"
#include "baker/bake/bake_light.h"
#include "baker/base/parallel.h"
#include "baker/base/z_order.h"
#include "baker/coding/blocks/blocks.h" /* before cmocka, whose fail() is a macro */
#include "dag_sample.h"
#include "formats/vxs_page_fast.h"
#include "runtime/vxs.h"
#include "tests/columns/analytic.h"
#include "tests/unit/repeats.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "blocks_built.h"
#include "format_parts.h"

/* How lights that are made here are packed. */
static uint32_t packing;

static int pack_small(void **state)
{
    (void)state;
    packing = VXS_PACKING_SMALL;
    return 0;
}

static int pack_fast(void **state)
{
    (void)state;
    packing = VXS_PACKING_FAST;
    return 0;
}

/* lights ----------------------------------------------------------------------------------------------------------------------- */

/* Words of several pages, with a common pool: rows of noise, some of which come again, half a node lower. */
static block_words make_words_of_pages(void)
{
    enum { SIDE = 1024, PERIOD = 384 };
    depth_maps  d = random_maps(SIDE, SIDE, MAPS_NOISE, 3);
    column_map  m = stored_map(&d);
    block_words w;
    for (uint32_t n = 0; n < SIDE * SIDE; n++) d.exit[n] = d.enter[n] = n < SIDE * PERIOD ? d.enter[n] : d.enter[n - SIDE * PERIOD];
    depth_maps_reduce(&d, 1);
    assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
    depth_maps_free(&d);
    assert_true(w.words[0] > 4 && w.common_count > 10);
    return w;
}

/* Made once: each test that queries gets a copy of its own. */
static block_words words_of_pages(void)
{
    static block_words made;
    if (!made.words) made = make_words_of_pages();
    block_words copy  = made;
    size_t      bytes = (made.count + VXS_BLOCKS_SPARE_WORDS) * sizeof *made.words;
    copy.words = copy.memory = memcpy(malloc(bytes), made.words, bytes);
    copy.common_kinds        = memcpy(malloc(made.common_count), made.common_kinds, made.common_count);
    return copy;
}

/* A sun, or a punctual light of six maps. */
static vxs_write_light blocks_light(const block_words *w, uint32_t levels, uint32_t map_count, const char *name)
{
    dag_sample      of = {.levels = levels};
    vxs_write_light l =
        map_count == 1 ? dag_sample_light(&of, name) : dag_sample_punctual(&of, name, VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE);
    l.light.coding = VXS_CODING_BLOCKS;
    l.blocks       = (vxs_blocks_view){w->words, w->count, w->common_kinds, w->common_count, packing};
    return l;
}

static vxs_bytes file_of(const vxs_write_light *lights, uint32_t count)
{
    vxs_write_desc desc = {.lights = lights, .light_count = count, .zstd_level = 1};
    vxs_bytes      file = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    return file;
}

/* One light of one page, and a DAG: nothing more. */
static vxs_bytes small_file(void)
{
    static const uint32_t slices[8] = {0, 0, 0, 2, 2, 1, 1, 1};
    static const uint64_t mask      = 0x000000003c3c0000u;
    block_words           w         = words_of_maps(4, 1, MAPS_NOISE, 1);
    dag_sample            none      = {.levels = 3};
    vxs_write_light       lights[2] = {blocks_light(&w, 4, 1, "sun"), dag_sample_light(&none, "moon")};
    lights[1].dag  = (vxs_dag_view){.nodes = {slices}, .count = {1}, .level_count = 1, .masks = &mask, .mask_count = 1};
    vxs_bytes file = file_of(lights, 2);
    block_words_free(&w);
    return file;
}

/* One light of some pages. */
static vxs_bytes paged_file(void)
{
    block_words     w     = words_of_pages();
    vxs_write_light light = blocks_light(&w, 10, 1, "sun");
    vxs_bytes       file  = file_of(&light, 1);
    block_words_free(&w);
    return file;
}

/* written data is read back ------------------------------------------------------------------------------------------------- */

static void check_parts(const vxs_baked_light *l, const block_words *w)
{
    static const char *const kinds[3]  = {"tops", "patterns", "pages"};
    const uint32_t           counts[3] = {vxs_map_count(&l->light), w->common_count, w->words[0]};
    uint64_t                 sum       = 0;
    assert_int_equal(l->part_count, 3);
    for (int n = 0; n < 3; n++) {
        assert_string_equal(l->parts[n].kind, kinds[n]);
        assert_int_equal(l->parts[n].count, counts[n]);
        sum += l->parts[n].memory_bytes;
    }
    assert_int_equal(l->parts[0].memory_bytes, 4 * (uint64_t)w->words[1]);
    assert_int_equal(l->parts[1].memory_bytes, 4 * (uint64_t)w->counts.common_words);
    assert_int_equal(sum, 4 * (uint64_t)w->count);
}

/* Words are the same, starts of pages among them; behind them are zeros. */
static void check_words(const vxs_baked_light *l, const block_words *w)
{
    static const uint32_t zeros[VXS_BLOCKS_SPARE_WORDS];
    assert_int_equal(l->light.coding, VXS_CODING_BLOCKS);
    assert_int_equal(l->packing, packing);
    assert_int_equal(l->word_count, w->count);
    assert_memory_equal(l->words, w->words, w->count * sizeof *w->words);
    assert_memory_equal(l->words + w->count, zeros, sizeof zeros);
    check_parts(l, w);
}

/* Lookups at random points about the light, in the words that were read and in those that were written. */
static void check_lookups(const vxs_baked_light *l, const block_words *w, uint64_t seed)
{
    vxs_baked_light written = {.light = l->light, .words = w->words, .word_count = w->count};
    rng             r       = {seed};
    double          side    = (double)(1u << l->light.levels);
    int             sun     = l->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    for (uint32_t n = 0, count = repeats(200, 2000); n < count; n++) {
        double at[3], point[3], normal[3] = {0, 1, 0};
        int    width_px = 1 + 2 * (int)rng_below(&r, 9), map = sun ? 0 : (int)rng_below(&r, 6);
        for (int k = 0; k < 3; k++) at[k] = side * (double)random_unit(&r);
        vxs_point(&l->light, map, at, point);
        float lit = vxs_lookup(l, point, n % 2 ? normal : NULL, vxs_box(width_px));
        if (lit != vxs_lookup(&written, point, n % 2 ? normal : NULL, vxs_box(width_px))) fail_msg("point %u", n);
    }
}

/* vxs_read_written, where a page packed small is not decoded; and it takes no damage elsewhere. */
static void check_written(const vxs_bytes *file, const block_words *w)
{
    vxs_contents c;
    assert_int_equal(vxs_read_written(&c, file->data, file->size_bytes, NULL), VXS_OK);
    const vxs_baked_light *l     = &c.lights[0];
    uint32_t               pages = w->words[0];
    check_parts(l, w);
    assert_int_equal(l->word_count, w->count);
    for (uint32_t n = 0; n < pages; n++) assert_int_equal(l->words[8 + n], packing == VXS_PACKING_FAST ? w->words[8 + n] : 0);
    assert_memory_equal(l->words + 8 + pages, w->words + 8 + pages, 4 * (size_t)(w->words[8] - 8 - pages));
    vxs_contents_free(&c);
    for (size_t n = 0; n < 8; n++) {
        uint8_t *byte = file->data + (file->size_bytes - 1) * n / 7;
        *byte ^= 1;
        assert_int_not_equal(vxs_read_written(&c, file->data, file->size_bytes, NULL), VXS_OK);
        *byte ^= 1;
    }
}

static void round_trip(block_words *w, uint32_t levels, uint32_t map_count, uint64_t seed)
{
    vxs_write_light light = blocks_light(w, levels, map_count, "sun");
    vxs_bytes       file = file_of(&light, 1), again = file_of(&light, 1);
    assert_int_equal(file.size_bytes, again.size_bytes);
    assert_memory_equal(file.data, again.data, file.size_bytes);
    alloc_fail    a         = {0}; /* whose memory is not zero before */
    vxs_allocator allocator = alloc_fail_allocator(&a);
    vxs_asset    *asset;
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, &(vxs_read_desc){.allocator = &allocator}), VXS_OK);
    assert_int_equal(vxs_asset_contents(asset)->version, 2);
    check_words(vxs_asset_light(asset, 0), w);
    check_lookups(vxs_asset_light(asset, 0), w, seed);
    vxs_asset_close(asset);
    assert_true(!a.live_bytes && !a.wrong_sizes);
    if (w->words[0]) check_written(&file, w);
    free(file.data);
    free(again.data);
    block_words_free(w);
}

static void test_round_trip(void **state)
{
    (void)state;
    for (uint32_t levels = 3; levels <= 9; levels++)
        for (map_kind kind = 0; kind<MAP_KINDS; kind += levels> 8 ? repeats(3, 1) : 1) {
            block_words one = words_of_maps(levels, 1, kind, levels + kind);
            round_trip(&one, levels, 1, kind);
            if (levels % 3 || (levels > 8 && kind >= (map_kind)repeats(1, MAP_KINDS))) continue;
            block_words six = words_of_maps(levels, 6, kind, 10 * levels + kind);
            round_trip(&six, levels, 6, kind);
        }
}

static void test_round_trip_of_pages(void **state)
{
    (void)state;
    block_words w = words_of_pages();
    round_trip(&w, 10, 1, 1);
}

/* Maps with cells, whose depths are wide. */
static void test_round_trip_of_large_maps(void **state)
{
    (void)state;
    for (uint32_t levels = 15; levels <= 18; levels += 3)
        for (analytic_kind kind = repeats((levels + packing / 2) % 2, 0); kind < ANALYTIC_KINDS; kind += repeats(2, 1)) {
            if (kind == ANALYTIC_PLANES) continue; /* detail everywhere */
            analytic    a = analytic_shape(kind, 1u << levels);
            block_words w;
            a.fetch_px = 1024;
            assert_int_equal(build_analytic(&w, &a, 2), VXS_OK);
            round_trip(&w, levels, 1, levels);
        }
}

/* A map of 16 x 16 nodes: 80, the same once more, 20 others, and squares of one depth. */
static block_words words_of_repeats(uint32_t threads)
{
    enum { NODES = 256, SHAPES = 80, MIXED = 180 };
    block_set   set = {0};
    block_words w;
    rng         r = rng_split(7, 1);
    uint32_t    ids[MIXED - SHAPES][NODE_BLOCKS];
    for (uint32_t n = 0; n < (MIXED - SHAPES) * NODE_BLOCKS; n++) {
        block b = {.depths = PALETTE_MAX};
        for (int k = 1; k < PALETTE_MAX; k++) b.depth[k] = 40 * k + (int32_t)rng_below(&r, 40);
        for (uint32_t t = 0; t < BLOCK_TILES; t++) b.tile[t].palette = (uint16_t)(t % PALETTE_MAX);
        assert_int_equal(block_set_find(&set, &b, &ids[n / NODE_BLOCKS][n % NODE_BLOCKS]), VXS_OK);
    }
    for (uint32_t n = 0; n < NODES; n++) {
        const z_place at = z_order(n);
        if (n >= MIXED) {
            assert_int_equal(block_set_add_uniform(&set, &(uniform_square){0, square_level(NODE_PX), at.i, at.j, 9}), VXS_OK);
            continue;
        }
        block_node node = {.x = at.i, .y = at.j, .emin = 1000, .xmax = 1000 + 40 * PALETTE_MAX, .mixed = UINT64_MAX};
        for (int k = 0; k < NODE_BLOCKS; k++) node.depth[k] = 1000;
        memcpy(node.block, ids[n < SHAPES ? n : n - SHAPES], sizeof node.block);
        assert_int_equal(block_set_add_node(&set, &node), VXS_OK);
    }
    assert_int_equal(block_words_lay_out(&w, &set, 12, 1, threads), VXS_OK);
    block_set_free(&set);
    return w;
}

/* As few pages as possible have the first nodes and their repeats in one page. Equal pages have these apart, and take more words. */
static void test_round_trip_of_pages_that_grow(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads++) {
        block_words w = words_of_repeats(threads), one = words_of_repeats(1);
        assert_true(w.count > 120000 && w.counts.nodes > 160 && w.words[0] == 4);
        assert_int_equal(w.count, one.count);
        assert_memory_equal(w.words, one.words, w.count * sizeof *w.words);
        block_words_free(&one);
        round_trip(&w, 12, 1, threads);
    }
}

/* A sun and a punctual light of palette blocks, with DAGs before, between and behind them. */
static void test_mixed_codings(void **state)
{
    (void)state;
    rng         r = {8};
    dag_sample  of_dag;
    block_words sun = words_of_maps(8, 1, MAPS_BOXES, 1), punctual = words_of_maps(6, 6, MAPS_SLOPE, 2);
    dag_sample_init(&of_dag, &r, 5, 40);
    vxs_write_light lights[5] = {dag_sample_light(&of_dag, "first"), blocks_light(&sun, 8, 1, "sun"),
                                 dag_sample_light(&of_dag, "middle"), blocks_light(&punctual, 6, 6, "lamp"),
                                 dag_sample_light(&of_dag, "last")};
    vxs_bytes       file = file_of(lights, 5), dags = file_of(lights, 1);
    vxs_asset      *mixed, *alone;
    assert_int_equal(vxs_load32(dags.data + VXS_HEADER_VERSION), 1);
    assert_int_equal(vxs_asset_open(&mixed, file.data, file.size_bytes, NULL), VXS_OK);
    assert_int_equal(vxs_asset_open(&alone, dags.data, dags.size_bytes, NULL), VXS_OK);
    const vxs_baked_light *wanted = vxs_asset_light(alone, 0);
    for (uint32_t n = 0; n < 5; n += 2) {
        const vxs_baked_light *found = vxs_asset_light(mixed, n);
        assert_int_equal(found->light.coding, VXS_CODING_DAG);
        assert_int_equal(found->word_count, wanted->word_count);
        assert_memory_equal(found->words, wanted->words, wanted->word_count * sizeof *wanted->words);
    }
    check_words(vxs_asset_light(mixed, 1), &sun);
    check_words(vxs_asset_light(mixed, 3), &punctual);
    check_lookups(vxs_asset_light(mixed, 1), &sun, 1);
    check_lookups(vxs_asset_light(mixed, 3), &punctual, 2);
    vxs_asset_close(mixed);
    vxs_asset_close(alone);
    free(file.data);
    free(dags.data);
    block_words_free(&sun);
    block_words_free(&punctual);
    dag_sample_free(&of_dag);
}

static void test_write_refuses(void **state)
{
    (void)state;
    block_words     w     = words_of_pages();
    vxs_write_light light = blocks_light(&w, 10, 1, "sun");
    vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes       file  = {0};
    uint32_t        pages = w.words[0], page = w.words[8 + pages / 2], was;
#define REFUSES(field, value)                                                                                                      \
    was   = field;                                                                                                                 \
    field = value;                                                                                                                 \
    assert_int_equal(vxs_write(&file, &desc), VXS_E_ARGUMENT);                                                                     \
    field = was
    REFUSES(light.light.levels, 9); /* another top */
    REFUSES(light.light.levels, 2);
    REFUSES(light.light.flags, VXS_LIGHT_CUBE); /* six of them */
    REFUSES(light.light.coding, 3);
    REFUSES(light.blocks.packing, 3);
    REFUSES(light.blocks.word_count, 0);
    REFUSES(light.blocks.word_count, 8);
    REFUSES(light.blocks.word_count, was - 1);
    REFUSES(light.blocks.word_count, w.words[8 + pages - 1]); /* the last page is empty */
    REFUSES(light.blocks.common_count, was - 1);
    REFUSES(w.common_kinds[0], (uint8_t)(was == 2 ? 3 : 2));
    REFUSES(w.words[0], VXS_PAGES_MAX + 1);
    REFUSES(w.words[0], pages - 1);
    REFUSES(w.words[1], 0);
    REFUSES(w.words[1], was + 1);
    REFUSES(w.words[1], UINT32_MAX);
    REFUSES(w.words[2], was + 1); /* the top of the map */
    REFUSES(w.words[8], was + 1);
    REFUSES(w.words[8], UINT32_MAX);
    REFUSES(w.words[9], w.words[8]);
    REFUSES(w.words[8 + pages / 2], page - 1);
    REFUSES(w.words[page + 5], was ^ 2); /* a flag of the first node that there is not */
#undef REFUSES
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    free(file.data);
    block_words_free(&w);
}

/* damaged files ---------------------------------------------------------------------------------------------------------------- */

/* An accepted file is safe to query, a refused one gives the reason. */
static int accepted(const vxs_bytes *file)
{
    vxs_contents contents;
    findings     f;
    if (read_bytes(&contents, file, &f, 0) != VXS_OK) return 0;
    for (uint32_t n = 0; n < contents.light_count; n++) {
        const vxs_baked_light *l    = &contents.lights[n];
        uint32_t               side = 1u << l->light.levels;
        rng                    r    = {7};
        if (l->light.coding != VXS_CODING_BLOCKS) continue; /* test_format.c walks them */
        for (int voxel = 0; voxel < 64; voxel++) {
            uint32_t map = rng_below(&r, vxs_map_count(&l->light));
            int32_t  i = (int32_t)rng_below(&r, side), j = (int32_t)rng_below(&r, side);
            assert_in_range(vxs_blocks_shadow_count(l->words, map, l->light.levels, i, j, rng_below(&r, side), 9), 0, 81);
        }
    }
    vxs_contents_free(&contents);
    return 1;
}

static void test_every_prefix_is_refused(void **state)
{
    (void)state;
    vxs_bytes file = small_file();
    for (size_t size = 0; size < file.size_bytes; size++) {
        vxs_bytes prefix = {0}; /* in memory of its own size, so that a read beyond it is seen */
        set_bytes(&prefix, file.data, size);
        refused(&prefix, size == 0 ? 101 : size < VXS_MAGIC_BYTES ? 102 : size < VXS_HEADER_BYTES ? 101 : 106);
        free(prefix.data);
    }
    free(file.data);
}

static void test_every_flipped_bit_is_refused(void **state)
{
    (void)state;
    vxs_bytes file = small_file();
    for (size_t bit = 0; bit < 8 * file.size_bytes; bit++) {
        file.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        if (accepted(&file)) fail_msg("bit %zu", bit);
        file.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_true(accepted(&file));
    free(file.data);
}

/* Where page `page` is in the content of its section. */
static uint8_t *page_bytes(part *pages, uint32_t page)
{
    uint8_t *at = pages->content.data + VXS_PAGES_PREFIX_BYTES + (size_t)vxs_load32(pages->content.data) * VXS_PAGE_BYTES;
    for (uint32_t n = 0; n < page; n++) at += vxs_load32(pages->content.data + VXS_PAGES_PREFIX_BYTES + n * VXS_PAGE_BYTES);
    return at;
}

static uint8_t *page_entry(part *pages, uint32_t page)
{
    return pages->content.data + VXS_PAGES_PREFIX_BYTES + (size_t)page * VXS_PAGE_BYTES;
}

/* Make the checksum of a page hold. */
static void seal_page(part *pages, uint32_t page)
{
    uint8_t *entry = page_entry(pages, page);
    vxs_store64(entry + VXS_PAGE_HASH, XXH64(page_bytes(pages, page), vxs_load32(entry + VXS_PAGE_STORED_BYTES), 0));
}

/* Under checksums that hold: every bit of the resident part, of the table of pages, and of a page. */
static void test_every_flipped_bit_under_checksums_is_safe(void **state)
{
    (void)state;
    vxs_bytes file = small_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    const uint32_t kinds[2] = {VXS_KIND_RESIDENT, VXS_KIND_PAGES};
    uint32_t       taken = 0, total = 0;
    for (int n = 0; n < 2; n++) {
        part *to = find_part(&p, kinds[n], 0);
        for (size_t bit = 0; bit < 8 * to->content.size_bytes; bit++, total++) {
            uint8_t *byte = &to->content.data[bit / 8];
            *byte ^= (uint8_t)(1u << bit % 8);
            if (n == 1 && byte >= page_bytes(to, 0)) seal_page(to, 0);
            store(to);
            file = put_together(&p);
            taken += (uint32_t)accepted(&file);
            free(file.data);
            *byte ^= (uint8_t)(1u << bit % 8);
        }
        if (n == 1) seal_page(to, 0);
        store(to);
    }
    file = put_together(&p);
    assert_true(accepted(&file));
    assert_in_range(taken, 0, total / 2); /* most are no longer a page of that many words */
    free(file.data);
    parts_free(&p);
}

/* a test for each finding ------------------------------------------------------------------------------------------------------ */

typedef void change_fn(parts *p);

static void finding_after(int number, vxs_bytes file, change_fn *change)
{
    parts p;
    take_apart(&p, &file);
    free(file.data);
    change(&p);
    file = put_together(&p);
    refused(&file, number);
    free(file.data);
    parts_free(&p);
}

static part *resident_of(parts *p)
{
    return find_part(p, VXS_KIND_RESIDENT, 0);
}
static part *pages_of(parts *p)
{
    return find_part(p, VXS_KIND_PAGES, 0);
}
/* The record of the first light, which is of palette blocks. */
static uint8_t *record_of(parts *p)
{
    return find_part(p, VXS_KIND_LIGHTS, 0)->content.data + VXS_LIGHTS_PREFIX_BYTES;
}
static void store_records(parts *p)
{
    store(find_part(p, VXS_KIND_LIGHTS, 0));
}

static void resident_in_a_frame(parts *p)
{
    resident_of(p)->flags = 0;
    store(resident_of(p));
}
static void masks_stored(parts *p)
{
    find_part(p, VXS_KIND_MASKS, 0)->flags = VXS_SECTION_STORED;
    store(find_part(p, VXS_KIND_MASKS, 0));
}
static void other_size(parts *p)
{
    pages_of(p)->inflated_bytes++;
}
static void other_size_of_unknown(parts *p)
{
    add_part(p, 0x31323334, VXS_SECTION_OPTIONAL | VXS_SECTION_STORED, "1234", 4)->inflated_bytes = 5;
}
static void undefined_flag(parts *p)
{
    pages_of(p)->flags |= 4;
}
static void version_one(parts *p)
{
    p->version = 1;
}
/* Without flags that version 1 does not have, kinds are left that it does not know. */
static void version_one_without_flags(parts *p)
{
    p->version            = 1;
    resident_of(p)->flags = pages_of(p)->flags = 0;
}
/* A section becomes one of an unknown, optional kind. */
static void drop(part *gone)
{
    gone->kind  = 0x31323334;
    gone->flags = VXS_SECTION_OPTIONAL;
}
static void no_resident(parts *p)
{
    drop(resident_of(p));
}
static void no_pages(parts *p)
{
    drop(pages_of(p));
}
static void resident_twice(parts *p)
{
    add_part(p, VXS_KIND_RESIDENT, VXS_SECTION_STORED, "", 0)->light = 0;
}
static void resident_of_a_dag(parts *p)
{
    add_part(p, VXS_KIND_RESIDENT, VXS_SECTION_STORED, "", 0)->light = 1;
}
static void masks_of_blocks(parts *p)
{
    add_part(p, VXS_KIND_MASKS, 0, "", 0)->light = 0;
}
static void pages_of_a_level(parts *p)
{
    part *pages  = add_part(p, VXS_KIND_PAGES, VXS_SECTION_STORED, "", 0);
    pages->light = 0;
    pages->level = 1;
}
static void pages_of_no_light(parts *p)
{
    add_part(p, VXS_KIND_PAGES, VXS_SECTION_STORED, "", 0)->light = 2;
}
static void unknown_coding(parts *p)
{
    vxs_store32(record_of(p) + VXS_LIGHT_CODING, 3);
    store_records(p);
}
static void no_coding(parts *p)
{
    vxs_store32(record_of(p) + VXS_LIGHT_CODING, 0);
    store_records(p);
}
static void unknown_packing(parts *p)
{
    vxs_store32(record_of(p) + VXS_LIGHT_PACKING, 3);
    store_records(p);
}
static void other_packing(parts *p)
{
    record_of(p)[VXS_LIGHT_PACKING] ^= VXS_PACKING_SMALL ^ VXS_PACKING_FAST;
    store_records(p);
}
static void packing_of_a_dag(parts *p)
{
    vxs_store32(record_of(p) + VXS_LIGHT_BYTES + VXS_LIGHT_PACKING, VXS_PACKING_FAST);
    store_records(p);
}
static void reserved_bytes(parts *p)
{
    record_of(p)[VXS_LIGHT_RESERVED] = 1;
    store_records(p);
}
static void one_word_more(parts *p)
{
    record_of(p)[VXS_LIGHT_WORD_COUNT]++;
    store_records(p);
}

static void resident_empty(parts *p)
{
    set_bytes(&resident_of(p)->content, NULL, 0);
    store(resident_of(p));
}
static void resident_of_too_many_pages(parts *p)
{
    vxs_store32(resident_of(p)->content.data + 4, VXS_PAGES_MAX + 1);
    store(resident_of(p));
}
static void resident_broken(parts *p)
{
    resident_of(p)->content.data[resident_of(p)->content.size_bytes - 1] ^= 0x80;
    store(resident_of(p));
}
static void resident_shorter(parts *p)
{
    resident_of(p)->content.size_bytes -= 2;
    store(resident_of(p));
}
/* The top of a map of other levels does not end where this one does. */
static void other_levels(parts *p)
{
    vxs_store32(record_of(p) + VXS_LIGHT_LEVELS, 10);
    store_records(p);
}

static void table_empty(parts *p)
{
    set_bytes(&pages_of(p)->content, NULL, 0);
    store(pages_of(p));
}
static void table_short(parts *p)
{
    pages_of(p)->content.size_bytes = VXS_PAGES_PREFIX_BYTES + VXS_PAGE_BYTES - 1;
    store(pages_of(p));
}
static void table_of_two(parts *p)
{
    vxs_store32(pages_of(p)->content.data, 2);
    store(pages_of(p));
}
static void table_of_others(parts *p)
{
    vxs_store32(pages_of(p)->content.data + 4, VXS_PAGE_BYTES + 8);
    store(pages_of(p));
}
static void page_longer(parts *p)
{
    page_entry(pages_of(p), 0)[VXS_PAGE_STORED_BYTES]++;
    store(pages_of(p));
}
static void pages_shorter(parts *p)
{
    pages_of(p)->content.size_bytes--;
    store(pages_of(p));
}
static void page_of_more_words(parts *p)
{
    page_entry(pages_of(p), 0)[VXS_PAGE_WORD_COUNT]++;
    store(pages_of(p));
}
/* The record agrees, the page does not. */
static void page_of_more_words_than_it_has(parts *p)
{
    page_of_more_words(p);
    one_word_more(p);
}
static void page_hash(parts *p)
{
    page_entry(pages_of(p), 0)[VXS_PAGE_HASH] ^= 1;
    store(pages_of(p));
}
static void page_changed(parts *p)
{
    page_bytes(pages_of(p), 0)[5] ^= 1;
    store(pages_of(p));
}
static void page_broken(parts *p)
{
    page_bytes(pages_of(p), 1)[-1] ^= 1; /* the coder's second state */
    seal_page(pages_of(p), 0);
    store(pages_of(p));
}
/* The first two pages, whole, each in the other's place. */
static void pages_in_other_order(parts *p)
{
    part    *pages = pages_of(p);
    uint8_t *entry = page_entry(pages, 0);
    size_t   first = vxs_load32(entry), second = vxs_load32(entry + VXS_PAGE_BYTES);
    uint8_t *bytes = page_bytes(pages, 0), *copy = parts_alloc(first), old[VXS_PAGE_BYTES];
    memcpy(copy, bytes, first);
    memmove(bytes, bytes + first, second);
    memcpy(bytes + second, copy, first);
    memcpy(old, entry, sizeof old);
    memcpy(entry, entry + VXS_PAGE_BYTES, sizeof old);
    memcpy(entry + VXS_PAGE_BYTES, old, sizeof old);
    store(pages);
    free(copy);
}

static void test_findings(void **state)
{
    (void)state;
    finding_after(201, small_file(), version_one);
    finding_after(201, small_file(), undefined_flag);
    finding_after(205, small_file(), version_one_without_flags);
    finding_after(208, small_file(), resident_twice);
    finding_after(209, small_file(), no_resident);
    finding_after(209, small_file(), no_pages);
    finding_after(210, small_file(), resident_of_a_dag);
    finding_after(210, small_file(), masks_of_blocks);
    finding_after(210, small_file(), pages_of_a_level);
    finding_after(210, small_file(), pages_of_no_light);
    finding_after(212, small_file(), resident_in_a_frame);
    finding_after(212, small_file(), masks_stored);
    finding_after(212, small_file(), other_size);
    finding_after(212, small_file(), other_size_of_unknown);
    finding_after(307, small_file(), reserved_bytes);
    finding_after(307, small_file(), packing_of_a_dag);
    finding_after(310, small_file(), unknown_packing);
    finding_after(501, small_file(), other_packing);
    finding_after(309, small_file(), unknown_coding);
    finding_after(309, small_file(), no_coding);
    finding_after(406, small_file(), one_word_more);
    finding_after(406, small_file(), page_of_more_words);
    finding_after(501, small_file(), resident_empty);
    finding_after(501, small_file(), resident_of_too_many_pages);
    finding_after(501, small_file(), resident_broken);
    finding_after(501, small_file(), resident_shorter);
    finding_after(501, small_file(), other_levels);
    finding_after(502, small_file(), table_empty);
    finding_after(502, small_file(), table_short);
    finding_after(502, small_file(), table_of_two);
    finding_after(502, small_file(), table_of_others);
    finding_after(502, small_file(), page_longer);
    finding_after(502, small_file(), pages_shorter);
    finding_after(503, small_file(), page_hash);
    finding_after(503, small_file(), page_changed);
    finding_after(504, small_file(), page_broken);
    finding_after(504, small_file(), page_of_more_words_than_it_has);
    finding_after(504, paged_file(), pages_in_other_order);
}

/* The words of a page, as they are stored, become others, in a frame of its own. */
static void change_stored_words(parts *p, void (*change)(uint32_t *words))
{
    part     *pages = pages_of(p);
    uint8_t  *entry = page_entry(pages, 0), *bytes = page_bytes(pages, 0);
    uint32_t  count = vxs_load32(entry + VXS_PAGE_WORD_COUNT), size = vxs_load32(entry + VXS_PAGE_STORED_BYTES);
    size_t    bound = ZSTD_compressBound(4 * (size_t)count);
    uint32_t *words = parts_alloc(4 * (size_t)count);
    uint8_t  *frame = parts_alloc(bound);
    assert_int_equal(ZSTD_decompress(words, 4 * (size_t)count, bytes + 4, size - 4), 4 * (size_t)count);
    change(words);
    size_t stored = ZSTD_compress(frame, bound, words, 4 * (size_t)count, 19);
    assert_int_equal(bytes + size - pages->content.data, pages->content.size_bytes); /* it is the last one */
    pages->content.size_bytes += stored - (size - 4);
    pages->content.data = realloc(pages->content.data, pages->content.size_bytes);
    memcpy(page_bytes(pages, 0) + 4, frame, stored);
    vxs_store32(page_entry(pages, 0) + VXS_PAGE_STORED_BYTES, (uint32_t)stored + 4);
    seal_page(pages, 0);
    store(pages);
    free(words);
    free(frame);
}
static void nothing(uint32_t *words)
{
    (void)words;
}
static void undefined_flag_of_a_node(uint32_t *words)
{
    words[5] ^= 2;
}
static void page_packed_again(parts *p)
{
    change_stored_words(p, nothing);
}
static void node_with_an_undefined_flag(parts *p)
{
    change_stored_words(p, undefined_flag_of_a_node);
}
static void page_with_more_words_of_nodes(parts *p)
{
    page_bytes(pages_of(p), 0)[2]++;
    seal_page(pages_of(p), 0);
    store(pages_of(p));
}

static void test_findings_of_fast(void **state)
{
    (void)state;
    vxs_bytes file = small_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    page_packed_again(&p);
    file = put_together(&p);
    assert_true(accepted(&file));
    free(file.data);
    parts_free(&p);
    finding_after(310, small_file(), unknown_packing);
    finding_after(501, small_file(), other_packing);
    finding_after(501, small_file(), resident_empty);
    finding_after(501, small_file(), resident_of_too_many_pages);
    finding_after(501, small_file(), resident_broken);
    finding_after(501, small_file(), resident_shorter);
    finding_after(501, small_file(), other_levels);
    finding_after(503, small_file(), page_hash);
    finding_after(503, small_file(), page_changed);
    finding_after(504, small_file(), node_with_an_undefined_flag);
    finding_after(504, small_file(), page_with_more_words_of_nodes);
    finding_after(504, paged_file(), pages_in_other_order);
    finding_after(505, small_file(), page_broken);
    finding_after(505, small_file(), page_of_more_words_than_it_has);
}

/* Every page is looked at, where everything is wanted. */
static void test_find_all_goes_on(void **state)
{
    (void)state;
    vxs_bytes file = paged_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    for (uint32_t page = 0; page < 3; page++) page_entry(pages_of(&p), page)[VXS_PAGE_HASH] ^= 1;
    store(pages_of(&p));
    file = put_together(&p);
    vxs_contents contents;
    findings     f;
    assert_int_equal(read_bytes(&contents, &file, &f, 1), VXS_E_CORRUPT);
    assert_int_equal(f.count, 3);
    assert_int_equal(read_bytes(&contents, &file, &f, 0), VXS_E_CORRUPT);
    assert_int_equal(f.count, 1);
    free(file.data);
    parts_free(&p);
}

/* threads ---------------------------------------------------------------------------------------------------------------------- */

/* An engine that has one thread, and runs the last task first. */
static void run_backwards(void *user, uint32_t count, void (*task)(void *work, uint32_t n), void *work)
{
    *(uint32_t *)user += count;
    while (count-- > 0) task(work, count);
}

static const uint32_t thread_counts[] = {0, 1, 2, 3, 8, 1000};

enum { THREAD_COUNTS = sizeof thread_counts / sizeof *thread_counts };

/* The same bytes and words on any threads; tasks are as many as threads, pages and memory of their own allow. Pages of several
 * lights, with a DAG between them and packed in either way, share the threads. */
static void test_any_threads(void **state)
{
    (void)state;
    rng         r = {9};
    dag_sample  of_dag;
    block_words w = words_of_pages(), lamp = words_of_maps(6, 6, MAPS_SLOPE, 2);
    dag_sample_init(&of_dag, &r, 5, 40);
    vxs_write_light light    = blocks_light(&w, 10, 1, "sun");
    vxs_write_light three[3] = {blocks_light(&lamp, 6, 6, "lamp"), dag_sample_light(&of_dag, "moon"), light};
    three[0].blocks.packing  = packing == VXS_PACKING_FAST ? VXS_PACKING_SMALL : VXS_PACKING_FAST;
    vxs_bytes once = file_of(&light, 1), once_three = file_of(three, 3);
    uint32_t  tasks = 0;
    for (int n = 0; n < 2 * THREAD_COUNTS; n++) {
        vxs_parallel parallel = parallel_lent(thread_counts[n / 2]);
        if (n % 2) parallel = (vxs_parallel){.run = run_backwards, .user = &tasks, .threads = thread_counts[n / 2]};
        uint32_t       expected = min_u32(thread_counts[n / 2], w.words[0]);
        vxs_write_desc write    = {.lights = &light, .light_count = 1, .zstd_level = 1, .parallel = &parallel};
        vxs_read_desc  read     = {.parallel = &parallel};
        vxs_bytes      file     = {0};
        vxs_asset     *asset;
        tasks = 0;
        assert_int_equal(vxs_write(&file, &write), VXS_OK);
        assert_int_equal(file.size_bytes, once.size_bytes);
        assert_memory_equal(file.data, once.data, once.size_bytes);
        assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, &read), VXS_OK);
        check_words(vxs_asset_light(asset, 0), &w);
        assert_int_equal(tasks, n % 2 && expected > 1 ? 2 * expected : 0);
        vxs_asset_close(asset);
        write.lights      = three;
        write.light_count = 3;
        assert_int_equal(vxs_write(&file, &write), VXS_OK);
        assert_int_equal(file.size_bytes, once_three.size_bytes);
        assert_memory_equal(file.data, once_three.data, once_three.size_bytes);
        free(file.data);
    }
    free(once.data);
    free(once_three.data);
    dag_sample_free(&of_dag);
    block_words_free(&lamp);
    block_words_free(&w);
}

static void run_each(void *user, uint32_t count, void (*task)(void *work, uint32_t n), void *work)
{
    (void)user;
    for (uint32_t n = 0; n < count; n++) task(work, n);
}

static void count_pause(void *user)
{
    ++*(uint32_t *)user;
}

/* Each task is held before each of its pages, and once before it learns that there is none left; also on the
 * caller's own thread. */
static void test_pauses(void **state)
{
    (void)state;
    block_words     w      = words_of_pages();
    vxs_write_light light  = blocks_light(&w, 10, 1, "sun");
    uint32_t        pauses = 0;
    for (uint32_t threads = 0; threads < 2; threads++) {
        vxs_parallel   parallel = {.run = run_each, .user = &pauses, .threads = 3 * threads, .pause = count_pause};
        uint32_t       expected = w.words[0] + max_u32(1, parallel.threads);
        vxs_write_desc write    = {.lights = &light, .light_count = 1, .zstd_level = 1, .parallel = &parallel};
        vxs_read_desc  read     = {.parallel = &parallel};
        vxs_bytes      file     = {0};
        vxs_contents   contents;
        assert_int_equal(vxs_write(&file, &write), VXS_OK);
        assert_int_equal(pauses, expected);
        assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &read), VXS_OK);
        assert_int_equal(pauses, 2 * expected);
        pauses = 0;
        vxs_contents_free(&contents);
        free(file.data);
    }
    block_words_free(&w);
}

/* Pages that are wrong: the first one is reported, and all where all are wanted, in their order. */
static void test_findings_on_any_threads(void **state)
{
    (void)state;
    vxs_bytes file = paged_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    uint32_t last = vxs_load32(pages_of(&p)->content.data) - 1;
    page_bytes(pages_of(&p), 3)[-10] ^= 1; /* met when all of page 2 is decoded, while others look at what is behind it */
    seal_page(pages_of(&p), 2);
    page_entry(pages_of(&p), 3)[VXS_PAGE_HASH] ^= 1;
    page_entry(pages_of(&p), last)[VXS_PAGE_HASH] ^= 1;
    store(pages_of(&p));
    file        = put_together(&p);
    uint64_t at = (uint64_t)(page_bytes(pages_of(&p), 2) - pages_of(&p)->content.data);
    for (int n = 0; n < 2 * THREAD_COUNTS; n++)
        for (int find_all = 0; find_all < 2; find_all++) {
            uint32_t      tasks    = 0;
            vxs_parallel  parallel = parallel_lent(thread_counts[n / 2]);
            findings      f        = {0};
            vxs_contents  contents;
            vxs_read_desc desc = {.finding = collect, .finding_user = &f, .find_all = find_all, .parallel = &parallel};
            if (n % 2) parallel = (vxs_parallel){.run = run_backwards, .user = &tasks, .threads = thread_counts[n / 2]};
            assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_E_CORRUPT);
            assert_int_equal(f.first, 504);
            assert_int_equal(f.offset, at);
            assert_int_equal(f.count, find_all ? 3 : 1);
        }
    free(file.data);
    parts_free(&p);
}

/* Two pages that are not in canonical order: the writer says no on any threads. */
static void test_write_refuses_on_any_threads(void **state)
{
    (void)state;
    block_words     w     = words_of_pages();
    vxs_write_light light = blocks_light(&w, 10, 1, "sun");
    for (uint32_t page = 2; page < 5; page += 2) w.words[w.words[8 + page] + 5] ^= 2; /* a flag that there is not */
    for (int n = 0; n < THREAD_COUNTS; n++) {
        vxs_parallel   parallel = parallel_lent(thread_counts[n]);
        vxs_write_desc desc     = {.lights = &light, .light_count = 1, .zstd_level = 1, .parallel = &parallel};
        vxs_bytes      file     = {0};
        assert_int_equal(vxs_write(&file, &desc), VXS_E_ARGUMENT);
        assert_null(file.data);
    }

    /* the baker says what to do */
    run_context m     = {0};
    coded_light coded = {.written = light};
    vxs_bytes   file  = {0};
    assert_int_equal(asset_encode(&(bake_options){.threads = 1, .zstd_level = 1}, &coded, 1, "{}", NULL, &file, &m),
                     VXS_E_ARGUMENT);
    assert_non_null(strstr(m.error, "a fault of vxs; try another --resolution or --coding dag"));
    assert_null(file.data);
    block_words_free(&w);
}

/* Threads take what memory there is beside what one needs: no limit and no failing allocation of theirs changes what is read. */
static void test_memory_of_threads(void **state)
{
    (void)state;
    vxs_bytes     file      = paged_file();
    alloc_fail    a         = {0};
    vxs_allocator allocator = alloc_fail_allocator(&a);
    vxs_read_desc desc      = {.allocator = &allocator};
    vxs_parallel  parallel  = parallel_lent(3);
    vxs_contents  alone, contents;
    assert_int_equal(vxs_read(&alone, file.data, file.size_bytes, &desc), VXS_OK);
    uint64_t held = a.live_bytes, calls = a.calls,
             needed         = packing == VXS_PACKING_FAST ? sizeof(vxs_page_marks) : vxs_page_scratch_bytes() + 16;
    desc.memory_limit_bytes = a.peak_bytes;
    desc.parallel           = &parallel;
    uint64_t peaks[3];
    for (uint64_t more = 0; more < 3; more++, desc.memory_limit_bytes += needed) {
        a.peak_bytes = a.live_bytes;
        assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_OK);
        peaks[more] = a.peak_bytes - held;
        assert_in_range(peaks[more], 1, desc.memory_limit_bytes);
        assert_memory_equal(contents.lights[0].words, alone.lights[0].words, 4 * (size_t)alone.lights[0].word_count);
        vxs_contents_free(&contents);
    }
    assert_true(peaks[0] + needed == peaks[1] && peaks[1] + needed == peaks[2]);
    desc.memory_limit_bytes = peaks[0] - 1;
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_E_MEMORY);

    desc.memory_limit_bytes = 0;
    for (uint64_t n = 1; n <= calls + 1; n++) { /* the last is that of a second thread */
        a.calls   = 0;
        a.fail_at = n;
        assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), n <= calls ? VXS_E_MEMORY : VXS_OK);
        assert_true(a.calls >= n);
        if (n > calls) {
            assert_memory_equal(contents.lights[0].words, alone.lights[0].words, 4 * (size_t)alone.lights[0].word_count);
            vxs_contents_free(&contents);
        }
        assert_int_equal(a.live_bytes, held);
    }
    vxs_contents_free(&alone);
    assert_true(!a.live_bytes && !a.wrong_sizes);
    free(file.data);
}

/* memory ----------------------------------------------------------------------------------------------------------------------- */

/* A page that claims that it takes as much as a page may, and a resident part that claims that it takes a lot: refused before it is
 * taken. */
static void test_memory_limit(void **state)
{
    (void)state;
    enum { MANY = 60000000 };
    vxs_bytes file = small_file();
    parts     p;
    take_apart(&p, &file);
    free(file.data);
    uint8_t *words = resident_of(&p)->content.data;
    vxs_store32(record_of(&p) + VXS_LIGHT_WORD_COUNT, vxs_load32(record_of(&p) + VXS_LIGHT_WORD_COUNT) + MANY - vxs_load32(words));
    vxs_store32(words, MANY);
    store_records(&p);
    store(resident_of(&p));
    file                    = put_together(&p);
    alloc_fail    a         = {0};
    vxs_allocator allocator = alloc_fail_allocator(&a);
    findings      f         = {0};
    vxs_contents  contents;
    vxs_read_desc desc = {.allocator = &allocator, .finding = collect, .finding_user = &f};
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_E_MEMORY);
    assert_int_equal(f.first, 211);
    assert_in_range(a.peak_bytes, 1, 1 << 16); /* nothing but the directory and the records */
    assert_int_equal(a.live_bytes, 0);
    free(file.data);
    parts_free(&p);

    /* a sound file needs its words and a scratch, and no more; with a byte less than its peak it is refused */
    file         = paged_file();
    a            = (alloc_fail){0};
    desc.finding = NULL;
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_OK);
    uint64_t peak = a.peak_bytes, held = a.live_bytes;
    assert_in_range(held, 4 * contents.lights[0].word_count, 4 * contents.lights[0].word_count + 4096);
    assert_in_range(peak, held, held + vxs_page_scratch_bytes() + (1 << 18));
    vxs_contents_free(&contents);
    desc.memory_limit_bytes = peak;
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_OK);
    vxs_contents_free(&contents);
    desc.memory_limit_bytes = peak - 1;
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, &desc), VXS_E_MEMORY);
    assert_int_equal(a.live_bytes, 0);
    assert_int_equal(a.wrong_sizes, 0);
    free(file.data);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    vxs_bytes file = small_file();
    assert_in_range(opened_without_memory(&file).calls, 12, 100);
    free(file.data);
}

/* Last: every number of palette blocks is some file's first finding, so none of them is unreachable. */
static void test_every_finding_was_produced(void **state)
{
    (void)state;
#define WAS_PRODUCED(number, result, text)                                                                                         \
    if (!produced[number] && is_of_blocks(number)) fail_msg("no test produced finding %d", number);
    VXS_FINDINGS(WAS_PRODUCED)
#undef WAS_PRODUCED
}

/* Words of a plate that is slanted both ways, with a step in it: thick enough for one depth a block, once its slope is added. */
static block_words words_of_slope(void)
{
    enum { SIDE = 512 };
    depth_maps  d = random_maps(SIDE, SIDE, MAPS_EMPTY, 0);
    column_map  m = stored_map(&d);
    block_words w;
    for (uint32_t n = 0; n < SIDE * SIDE; n++) {
        double depth = 0.5 + 0.4 * (n % SIDE) / SIDE - 0.3 * (n / SIDE) / SIDE - (n % SIDE < 100 ? 0.1 : 0);
        set_texel(&d, n, depth, depth + 8.0 / SIDE);
    }
    depth_maps_reduce(&d, 1);
    assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
    depth_maps_free(&d);
    return w;
}

/* files ------------------------------------------------------------------------------------------------------------------------ */

static block_words words_of_sphere(uint32_t levels)
{
    analytic    sphere = analytic_shape(ANALYTIC_SPHERE, 1u << levels);
    block_words w;
    sphere.fetch_px = 1024;
    assert_int_equal(build_analytic(&w, &sphere, 2), VXS_OK);
    return w;
}

static int write_file(const char *path, const vxs_write_light *lights, uint32_t count)
{
    vxs_bytes file = file_of(lights, count);
    FILE     *to   = fopen(path, "wb");
    int       good = to && fwrite(file.data, 1, file.size_bytes, to) == file.size_bytes;
    if (to && fclose(to)) good = 0;
    free(file.data);
    return good ? 0 : 1;
}

/* Suns with a bit of all, and a punctual light. */
static int write_blocks(const char *path)
{
    block_words w[] = {
        words_of_pages(),    words_of_maps(9, 1, MAPS_BOXES, 3), words_of_maps(9, 1, MAPS_CLIFF, 4), words_of_slope(),
        words_of_sphere(15), words_of_maps(5, 6, MAPS_NOISE, 5)};
    vxs_write_light lights[] = {blocks_light(&w[0], 10, 1, "noise"),  blocks_light(&w[1], 9, 1, "boxes"),
                                blocks_light(&w[2], 9, 1, "cliff"),   blocks_light(&w[3], 9, 1, "slope"),
                                blocks_light(&w[4], 15, 1, "sphere"), blocks_light(&w[5], 5, 6, "lamp")};
    int             failed   = write_file(path, lights, sizeof lights / sizeof *lights);
    for (size_t n = 0; n < sizeof w / sizeof *w; n++) block_words_free(&w[n]);
    return failed;
}

/* Of both packings; facets have several pages, and a common pool. */
static int write_golden(const char *folder)
{
    char path[512];
    snprintf(path, sizeof path, "%s/blocks.vxs", folder);
    block_words     w[]      = {words_of_maps(9, 1, MAPS_BOXES, 3), words_of_maps(13, 1, MAPS_FACETS, 3), words_of_slope(),
                                words_of_maps(5, 6, MAPS_NOISE, 5)};
    vxs_write_light lights[] = {blocks_light(&w[0], 9, 1, "boxes"), blocks_light(&w[1], 13, 1, "facets"),
                                blocks_light(&w[2], 9, 1, "slope"), blocks_light(&w[3], 5, 6, "lamp")};
    lights[2].blocks.packing = lights[3].blocks.packing = VXS_PACKING_FAST;

    int failed = write_file(path, lights, sizeof lights / sizeof *lights);
    for (size_t n = 0; n < sizeof w / sizeof *w; n++) block_words_free(&w[n]);
    return failed;
}

int main(void)
{
    if (getenv("VXS_BLOCKS_OUT")) return write_blocks(getenv("VXS_BLOCKS_OUT"));
    if (getenv("VXS_GOLDEN_OUT")) return write_golden(getenv("VXS_GOLDEN_OUT"));
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_round_trip, pack_fast),
        cmocka_unit_test_setup(test_round_trip, pack_small),
        cmocka_unit_test_setup(test_round_trip_of_pages, pack_fast),
        cmocka_unit_test_setup(test_round_trip_of_pages, pack_small),
        cmocka_unit_test_setup(test_round_trip_of_large_maps, pack_fast),
        cmocka_unit_test_setup(test_round_trip_of_pages_that_grow, pack_fast),
        cmocka_unit_test_setup(test_round_trip_of_large_maps, pack_small),
        cmocka_unit_test_setup(test_mixed_codings, pack_fast),
        cmocka_unit_test_setup(test_mixed_codings, pack_small),
        cmocka_unit_test_setup(test_write_refuses, pack_fast),
        cmocka_unit_test_setup(test_write_refuses, pack_small),
        cmocka_unit_test_setup(test_every_prefix_is_refused, pack_fast),
        cmocka_unit_test_setup(test_every_prefix_is_refused, pack_small),
        cmocka_unit_test_setup(test_every_flipped_bit_is_refused, pack_fast),
        cmocka_unit_test_setup(test_every_flipped_bit_is_refused, pack_small),
        cmocka_unit_test_setup(test_every_flipped_bit_under_checksums_is_safe, pack_fast),
        cmocka_unit_test_setup(test_every_flipped_bit_under_checksums_is_safe, pack_small),
        cmocka_unit_test_setup(test_findings_of_fast, pack_fast),
        cmocka_unit_test_setup(test_findings, pack_small),
        cmocka_unit_test_setup(test_find_all_goes_on, pack_fast),
        cmocka_unit_test_setup(test_find_all_goes_on, pack_small),
        cmocka_unit_test_setup(test_any_threads, pack_fast),
        cmocka_unit_test_setup(test_any_threads, pack_small),
        cmocka_unit_test(test_pauses),
        cmocka_unit_test(test_findings_on_any_threads),
        cmocka_unit_test_setup(test_write_refuses_on_any_threads, pack_fast),
        cmocka_unit_test_setup(test_write_refuses_on_any_threads, pack_small),
        cmocka_unit_test_setup(test_memory_of_threads, pack_fast),
        cmocka_unit_test_setup(test_memory_of_threads, pack_small),
        cmocka_unit_test(test_memory_limit),
        cmocka_unit_test(test_failing_allocations),
        cmocka_unit_test(test_every_finding_was_produced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
