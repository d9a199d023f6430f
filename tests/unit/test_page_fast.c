/* Pages and resident parts that are packed fast (formats/vxs_page_fast.h): the same words come back; frames of other sizes are
 * refused; and words are taken exactly where the coder of small ones takes them, which shares nothing with the check but the
 * layout. What is taken may be looked up.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/vxs_bytes.h"
#include "formats/vxs_page_fast.h"
#include "page_encoded.h"
#include "resident_sample.h"
#include "tests/unit/repeats.h"

#include <cmocka.h>

enum { HEAD_BYTES = 4, PALETTE_ENTRIES = 14 };

static sample_page      page; /* large, as the next three */
static sample_common    common;
static uint8_t          in_common_at[VXS_COMMON_HALVES_MAX];
static vxs_common_marks in_common = {in_common_at, 0};
static vxs_page_marks   marks     = {.common = &in_common};
static ZSTD_CCtx       *packer;
static ZSTD_DCtx       *unpacker;

static int make_zstd(void **state)
{
    (void)state;
    packer   = ZSTD_createCCtx();
    unpacker = ZSTD_createDCtx();
    return !packer || !unpacker;
}

static int free_zstd(void **state)
{
    (void)state;
    ZSTD_freeCCtx(packer);
    ZSTD_freeDCtx(unpacker);
    return 0;
}

/* nodes: 0: as many as there is room for. */
static void make_page(uint64_t seed, uint32_t patterns, uint32_t nodes)
{
    rng r = rng_split(seed, 1);
    assert_int_equal(sample_common_make(&r, &common, patterns), VXS_OK);
    vxs_common_mark(&in_common, &common.common);
    sample_page_make(&r, &page, &common, nodes);
}

static vxs_result pack(vxs_bytes *out)
{
    *out = (vxs_bytes){0};
    return vxs_page_pack(out, page.words, page.word_count, page.nodes, page.node_count, &marks, packer);
}

static vxs_result unpack(uint32_t *words, const uint8_t *bytes, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1);
    memcpy(exact, bytes, size);
    vxs_result r = vxs_page_inflate(words, page.word_count, exact, size, unpacker);
    if (r == VXS_OK)
        r = vxs_page_check(words, page.word_count, vxs_page_node_words(exact), page.nodes, page.node_count, &marks,
                           VXS_PAGE_UNPACK);
    free(exact);
    return r;
}

static void check_round_trip(void)
{
    vxs_bytes bytes;
    uint32_t *words = malloc(page.word_count * sizeof *words);
    assert_int_equal(pack(&bytes), VXS_OK);
    assert_int_equal(vxs_page_word_count(bytes.data, bytes.size_bytes), page.word_count);
    assert_int_equal(unpack(words, bytes.data, bytes.size_bytes), VXS_OK);
    assert_memory_equal(words, page.words, page.word_count * sizeof *words);
    free(words);
    free(bytes.data);
}

static void pages_come_back(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 300; seed++) {
        make_page(seed, seed % 3 ? (uint32_t)seed % SAMPLE_COMMON_MAX : 0, 1 + (uint32_t)seed % 20);
        check_round_trip();
    }
    for (uint64_t seed = 0; seed < 6; seed++) {
        make_page(seed, SAMPLE_COMMON_MAX, 0);
        assert_int_equal(page.word_count, VXS_PAGE_WORDS_MAX);
        check_round_trip();
    }
}

static void pages_are_appended(void **state)
{
    (void)state;
    make_page(3, 10, 4);
    vxs_bytes one, two;
    assert_int_equal(pack(&one), VXS_OK);
    assert_int_equal(pack(&two), VXS_OK);
    assert_int_equal(vxs_page_pack(&two, page.words, page.word_count, page.nodes, page.node_count, &marks, packer), VXS_OK);
    assert_int_equal(two.size_bytes, 2 * one.size_bytes);
    assert_memory_equal(two.data, one.data, one.size_bytes);
    assert_memory_equal(two.data + one.size_bytes, one.data, one.size_bytes);
    free(one.data);
    free(two.data);
}

/* frames ----------------------------------------------------------------------------------------------------------------------- */

static void prefixes_are_refused(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 10; seed++) {
        make_page(seed, 12, 1 + (uint32_t)seed % 3);
        vxs_bytes bytes;
        uint32_t *words = malloc(page.word_count * sizeof *words);
        assert_int_equal(pack(&bytes), VXS_OK);
        for (size_t size = 0; size < bytes.size_bytes; size++) assert_int_equal(unpack(words, bytes.data, size), VXS_E_CORRUPT);
        free(words);
        free(bytes.data);
    }
}

/* Bytes of the page, with a frame of `words` words of it behind the head, of which `count` is said. */
static size_t put_frame(uint8_t *to, size_t room, uint32_t count, uint32_t words, int says_size)
{
    uint32_t *content = calloc(words + 1, sizeof *content);
    memcpy(content, page.words, (words < page.word_count ? words : page.word_count) * sizeof *content);
    vxs_store16(to, (uint16_t)(count - 1));
    vxs_store16(to + 2, 0);
    ZSTD_CCtx_setParameter(packer, ZSTD_c_contentSizeFlag, says_size);
    size_t stored = ZSTD_compress2(packer, to + HEAD_BYTES, room - HEAD_BYTES, content, words * sizeof *content);
    ZSTD_CCtx_setParameter(packer, ZSTD_c_contentSizeFlag, 1);
    free(content);
    assert_false(ZSTD_isError(stored));
    return HEAD_BYTES + stored;
}

/* Room behind the words would be overwritten by a frame that holds more than it may. */
static void frames_of_other_sizes_are_refused(void **state)
{
    (void)state;
    make_page(1, 12, 2);
    uint32_t count = page.word_count, *words = malloc(count * sizeof *words);
    size_t   room  = HEAD_BYTES + 2 * ZSTD_compressBound((count + 4) * sizeof *words);
    uint8_t *bytes = malloc(room);
#define INFLATES(size) vxs_page_inflate(words, count, bytes, size, unpacker)
    assert_int_equal(INFLATES(put_frame(bytes, room, count, count, 1)), VXS_OK);
    assert_int_equal(INFLATES(put_frame(bytes, room, count, count, 0)), VXS_E_CORRUPT);
    assert_int_equal(INFLATES(put_frame(bytes, room, count, count + 1, 1)), VXS_E_CORRUPT);
    assert_int_equal(INFLATES(put_frame(bytes, room, count, count - 1, 1)), VXS_E_CORRUPT);
    assert_int_equal(INFLATES(put_frame(bytes, room, count + 1, count, 1)), VXS_E_CORRUPT);
    size_t size = put_frame(bytes, room, count, count, 1);
    bytes[size] = 0;
    assert_int_equal(INFLATES(size + 1), VXS_E_CORRUPT);
    memcpy(bytes + size, bytes + HEAD_BYTES, size - HEAD_BYTES); /* two frames */
    assert_int_equal(INFLATES(2 * size - HEAD_BYTES), VXS_E_CORRUPT);
    memmove(bytes + HEAD_BYTES + 8, bytes + HEAD_BYTES, size - HEAD_BYTES); /* one that is skipped, before the other */
    vxs_store32(bytes + HEAD_BYTES, 0x184d2a50);
    vxs_store32(bytes + HEAD_BYTES + 4, 0);
    assert_int_equal(INFLATES(size + 8), VXS_E_CORRUPT);
#undef INFLATES
    free(words);
    free(bytes);
}

/* words ------------------------------------------------------------------------------------------------------------------------ */

static uint32_t get16(const uint32_t *words, uint32_t half)
{
    return words[half / 2] >> 16 * (half & 1) & 0xffff;
}

static void set16(uint32_t *words, uint32_t half, uint32_t value)
{
    words[half / 2] ^= ((get16(words, half) ^ value) & 0xffff) << 16 * (half & 1);
}

/* Words become others, some of which are at the edge of a rule. blocks: where they start, [block_count] */
static void change_words(rng *r, uint32_t *words, uint32_t count, const uint16_t *blocks, uint32_t block_count)
{
    static const uint32_t edges[] = {0,          1,          0xff,       0xff00,     0xffff,     0x10000,    0xffffff,
                                     0x1000000,  0xff000000, 0xff000001, 0x7fffffff, 0x80000000, 0x80040000, 0x80040001,
                                     0xffffffff, 0x20000000, 0x0eff0000, 0x05000000, 0x0c000000, 0x0d000000};
    uint32_t              at = rng_below(r, count), n = rng_below(r, sizeof edges / sizeof *edges);
    uint32_t              block = block_count && rng_below(r, 2) ? blocks[rng_below(r, block_count)] : at;
    if (rng_below(r, 2)) at = block + rng_below(r, 12) < count ? block + rng_below(r, 12) % (count - block) : at;
    uint32_t half = 2 * at + rng_below(r, 2), other = half ^ 1;
    switch (rng_below(r, 10)) {
    case 0: words[at] = edges[n]; break;
    case 1: set16(words, half, edges[n]); break;
    case 2: set16(words, half, get16(words, half) + 1); break;
    case 3: set16(words, half, get16(words, half) - 1); break;
    case 4: set16(words, half, get16(words, rng_below(r, 2) ? other : rng_below(r, 2 * count))); break;
    case 5: words[at] = words[rng_below(r, count)]; break;
    case 6: words[at] += rng_below(r, 2) ? 1 << 14 : 0xffffc000u; break; /* the pattern of a tile */
    case 7:                                                              /* how a block keeps its palette */
        if (block + 1 < count) words[block + 1] ^= 1u << (16 + rng_below(r, 16));
        break;
    case 8: /* shifts that bring what is shifted beyond the end */
        if (block + 1 < count) words[block + 1] |= 0x01f00000;
        break;
    default: words[at] ^= 1u << rng_below(r, 32);
    }
}

/* Words are packed where they are coded, and come back. */
static void words_are_taken_where_the_coder_takes_them(void **state)
{
    (void)state;
    const uint32_t seeds = repeats(30, 100);
    uint32_t       taken = 0, refused = 0;
    for (uint64_t seed = 0; seed < seeds; seed++) {
        make_page(seed, 12, 1 + (uint32_t)seed % 3);
        rng       r     = rng_split(seed, 2);
        uint32_t *words = malloc(page.word_count * sizeof *words);
        memcpy(words, page.words, page.word_count * sizeof *words);
        for (int n = 0; n < 60; n++) {
            vxs_bytes coded = {0}, bytes;
            change_words(&r, page.words, page.word_count, page.blocks, page.block_count);
            vxs_result wanted = page_encoded(&coded, page.words, page.word_count, page.nodes, page.node_count, &common.common);
            if (pack(&bytes) != wanted) fail_msg("seed %d, change %d: wanted %d", (int)seed, n, wanted);
            wanted == VXS_OK ? taken++ : refused++;
            if (wanted == VXS_OK) check_round_trip();
            free(coded.data);
            free(bytes.data);
            memcpy(page.words, words, page.word_count * sizeof *words);
        }
        free(words);
    }
    assert_true(taken > 5 * seeds && refused > 5 * seeds);
}

/* Words that come from a frame may be anything: what is taken is a page that can be looked up, and that the coder takes, and is
 * packed to what it came from. */
static void stored_words_that_are_taken_are_a_page(void **state)
{
    (void)state;
    uint32_t taken = 0, refused = 0;
    for (uint64_t seed = 0; seed < 100; seed++) {
        make_page(seed, 12, 1 + (uint32_t)seed % 3);
        vxs_bytes bytes, coded = {0};
        rng       r     = rng_split(seed, 3);
        uint32_t  count = page.word_count, *stored = malloc(count * sizeof *stored), *words = malloc(count * sizeof *words);
        assert_int_equal(pack(&bytes), VXS_OK);
        uint32_t node_words = vxs_page_node_words(bytes.data);
        assert_int_equal(vxs_page_inflate(stored, count, bytes.data, bytes.size_bytes, unpacker), VXS_OK);
        for (int n = 0; n < 60; n++) {
            uint32_t nodes = rng_below(&r, 8) ? node_words : rng_below(&r, count + 2);
            memcpy(words, stored, count * sizeof *words);
            for (uint32_t k = 1 + rng_below(&r, 2); k; k--) change_words(&r, words, count, page.blocks, page.block_count);
            uint32_t *before = malloc(count * sizeof *before);
            memcpy(before, words, count * sizeof *words);
            if (vxs_page_check(words, count, nodes, page.nodes, page.node_count, &marks, VXS_PAGE_UNPACK) == VXS_OK) {
                assert_true(check_page(words, count, page.nodes, page.node_count, &common.common));
                assert_int_equal(page_encoded(&coded, words, count, page.nodes, page.node_count, &common.common), VXS_OK);
                assert_int_equal(vxs_page_check(words, count, nodes, page.nodes, page.node_count, &marks, VXS_PAGE_PACK), VXS_OK);
                assert_memory_equal(words, before, count * sizeof *words);
                taken++;
            } else
                refused++;
            free(before);
        }
        free(stored);
        free(words);
        free(bytes.data);
        free(coded.data);
    }
    assert_true(taken > 500 && refused > 500);
}

/* A node with a block with a tile with a pattern of these halves. kind: VXS_PATTERN_KINDS; of a palette the tile uses as many
 * entries. */
static void make_page_of_pattern(uint32_t kind, uint32_t entries, const uint16_t *halves, uint32_t count)
{
    uint32_t node_words = 10 + (entries + 3) / 4, *w = page.words;
    memset(&page, 0, sizeof page);
    w[0] = 1;                                    /* mixed: block 0 */
    w[2] = 2;                                    /* fresh: block 1 */
    w[5] = 7u << 16;                             /* the block's name */
    w[6] = 5u << 16;                             /* a depth, behind a base */
    w[7] = 1 | 2u << 16;                         /* mixed: tile 0; fresh: tile 1 */
    w[8] = (kind ? 0 : 1) | (entries - 1) << 16; /* own */
    w[9] = (2 * node_words) << 14 | (kind ? (1u << kind) - 1 : 8192);
    for (uint32_t n = 0; n + 1 < entries; n++) w[10 + n / 4] |= (n + 1) << 8 * (n % 4);
    for (uint32_t n = 0; n < count; n++) set16(w, 2 * node_words + n, halves[n]);
    page.word_count = node_words + (count + 1) / 2;
    page.node_count = 1;
}

/* Whether the page is taken; the coder has to agree. kind: of a pattern that pages before have left everywhere */
static int is_taken(uint32_t kind)
{
    vxs_bytes bytes, coded = {0};
    memset(marks.at, (int)kind + 1, sizeof marks.at);
    vxs_result wanted = page_encoded(&coded, page.words, page.word_count, page.nodes, page.node_count, &common.common);
    vxs_result r      = pack(&bytes);
    if (r != wanted) fail_msg("the coder says %d, the check %d", wanted, r);
    if (r == VXS_OK) check_round_trip();
    free(bytes.data);
    free(coded.data);
    return r == VXS_OK;
}

static int pattern_is_taken(uint32_t kind, const uint16_t *halves, uint32_t count)
{
    make_page_of_pattern(kind, kind ? kind : 1, halves, count);
    return is_taken(kind);
}

#define TAKEN(kind, ...)                                                                                                           \
    pattern_is_taken(kind, (const uint16_t[]){__VA_ARGS__}, sizeof((const uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t))

static void masks_of_patterns(void **state)
{
    (void)state;
    make_page(1, 0, 1); /* no common pool */
    assert_true(TAKEN(2, 0x0000));
    assert_false(TAKEN(2, 0x0100)); /* padding */
    assert_false(TAKEN(2, 0x0003)); /* again, before there is any */
    assert_true(TAKEN(2, 0x0002, 0x000f));
    assert_false(TAKEN(2, 0x000a, 0x000f)); /* a half that is not there */
    assert_false(TAKEN(2, 0x0002, 0x0000)); /* none of the texels, or all, are no halves */
    assert_false(TAKEN(2, 0x0002, 0xffff));
    assert_true(TAKEN(3, 0x0202, 0x000f, 0x00ff));
    assert_false(TAKEN(3, 0x0202, 0x00ff, 0x000f));
    assert_false(TAKEN(3, 0x0202, 0x00ff, 0x00ff));
    assert_true(TAKEN(3, 0x0302, 0x00ff));
    assert_true(TAKEN(3, 0x0102, 0x00ff));
    assert_true(TAKEN(3, 0x0101));
    assert_false(TAKEN(3, 0x0002, 0x00ff)); /* shadow does not end */
    assert_false(TAKEN(3, 0x0001));
    assert_false(TAKEN(3, 0x0201, 0x00ff));
    assert_false(TAKEN(3, 0x0301));
    assert_false(TAKEN(14, 0, 0, 0, 0));
}

/* Which form a pattern has is said by how much room masks take. */
static void images_of_patterns(void **state)
{
    (void)state;
    uint16_t masks[19] = {0xaaaa, 0xffaa, 0xffff, 0xffff, 0xffff, 0xffff, 0x00ff}, image[18] = {0xff};
    make_page(1, 0, 1);
    for (uint32_t n = 0; n < 12; n++) masks[7 + n] = (uint16_t)((2u << n % 3) - 1);
    assert_false(pattern_is_taken(14, masks, 19)); /* three halves of each quadrant, and seven of states */
    assert_false(pattern_is_taken(14, image, 17)); /* all texels have the first depth */
    for (uint32_t n = 0; n < 32; n++) image[1 + n / 2] |= (uint16_t)(0x11u * (n % 4) << 8 * (n % 2));
    assert_true(pattern_is_taken(14, image, 17));
    assert_false(pattern_is_taken(14, image, 16));
    image[0] = 0x1ff;
    assert_false(pattern_is_taken(14, image, 17));
    image[0]  = 0xff;
    image[16] = 0x0ee0;
    assert_false(pattern_is_taken(14, image, 17)); /* no such depth */
    image[16] = 0x0dd0;
    assert_true(pattern_is_taken(14, image, 17));
}

static void patterns_with_a_private_palette(void **state)
{
    (void)state;
    uint16_t raw[97] = {0};
    make_page(1, 0, 1);
    assert_true(TAKEN(0, 0x0002, 0x0001, 0x0000));
    assert_false(TAKEN(0, 0x0002, 0x0101, 0x0000)); /* padding of deltas */
    assert_false(TAKEN(0, 0x0002, 0x0000, 0x0000));
    assert_false(TAKEN(0, 0x0003, 0x0101, 0x0000));
    assert_false(TAKEN(0, 0x0002, 0x0001));
    assert_false(TAKEN(0, 0x0002));
    assert_false(TAKEN(0, 0x0000, 0x0000));
    assert_false(TAKEN(0, 0x0001, 0x0000));
    assert_false(TAKEN(0, 0x0011, 0x0201, 0x0403, 0x0605, 0x0807, 0x0a09, 0x0c0b, 0x0e0d, 0x100f, 0, 0, 0, 0, 0, 0, 0, 0));
    assert_true(TAKEN(0, 0x1902, 0x7fff, 0x0000));
    assert_false(TAKEN(0, 0x1902, 0x8000, 0x0000)); /* 2^24 */
    assert_true(TAKEN(0, 0x2002, 0xffff, 0x00ff, 0x0000));
    assert_false(TAKEN(0, 0x2002, 0x0000, 0x0100, 0x0000));
    for (uint32_t kind = 3; kind < 7; kind++) {
        uint32_t halves = kind == 3 ? 19 : 1 + 32 * (kind - 3);
        raw[0]          = (uint16_t)(kind << 12);
        assert_true(pattern_is_taken(0, raw, halves));
        assert_false(pattern_is_taken(0, raw, halves - 1));
        raw[0]++; /* p */
        assert_false(pattern_is_taken(0, raw, halves));
        raw[0]          = (uint16_t)(kind << 12 | 15 << 8);
        raw[halves - 1] = 0xffff; /* far: of two and three bytes */
        assert_int_equal(pattern_is_taken(0, raw, halves), kind < 5);
        raw[halves - 1] = 0;
    }
    assert_true(TAKEN(0, 0x7818, 0, 0));
    assert_false(TAKEN(0, 0x7918, 0, 0)); /* shift */
    assert_false(TAKEN(0, 0x7820, 0, 0));
    assert_false(TAKEN(0, 0x7801, 0, 0));
    assert_false(TAKEN(0, 0x7818, 0));
    assert_true(TAKEN(0, 0x887d, 0, 0, 0, 0, 0));
    assert_false(TAKEN(0, 0x887e, 0, 0, 0, 0, 0)); /* how far the second plane is */
    assert_false(TAKEN(0, 0x88fd, 0, 0, 0, 0, 0));
    assert_false(TAKEN(0, 0x897d, 0, 0, 0, 0, 0));
    assert_false(TAKEN(0, 0xb000, 0, 0, 0, 0, 0, 0, 0, 0, 0));
}

enum { FAR = 1 << 24 };

/* The base of an own tile of a block that is far has a word of its own, behind those that make_page_of_pattern makes. */
static int far_base_is_taken(uint32_t base)
{
    uint32_t *w = page.words;
    make_page_of_pattern(0, 1, (const uint16_t[]){0x0002, 0x0001, 0x0000}, 3);
    memmove(w + 12, w + 11, 2 * sizeof *w);
    w[8] |= 0x04000000;
    w[9]  = 24u << 14;
    w[11] = base;
    page.word_count++;
    return is_taken(0);
}

static void bases_that_are_far(void **state)
{
    (void)state;
    make_page(1, 0, 1);
    assert_true(far_base_is_taken(FAR - 1));
    assert_false(far_base_is_taken(FAR));
    assert_true(far_base_is_taken(1u - FAR));
    assert_false(far_base_is_taken(0u - FAR));
    assert_true(far_base_is_taken(0));
    page.words[9] |= 1; /* and none in the tile's word */
    assert_false(is_taken(0));
}

static void blocks_and_nodes(void **state)
{
    (void)state;
    static const uint16_t none[2]      = {0};
    static const uint32_t changes[][2] = {
        {5, 0x70002},       /* a flag of the node that there is not */
        {2, 4},             /* block 1 has no depth */
        {2, 3},             /* block 0 has one */
        {2, 6},             /* block 2 as well, which would not fit */
        {5, 6u << 16},      /* no block starts there */
        {5, 8u << 16},      /* nor there */
        {5},                /* nor is the node one */
        {7, 1},             /* tile 1 has no entry */
        {7, 1 | 4u << 16},  /* nor there */
        {7, 1 | 3u << 16},  /* tile 0 has one */
        {7, 1 | 6u << 16},  /* tile 2 has the same again */
        {8, 0x08010000},    /* a bit that there is not */
        {8, 0x03010000},    /* no width */
        {8, 0x02110000},    /* a shift of words */
        {9, 22u << 14 | 1}, /* a pattern of one entry */
        {9, 22u << 14 | 7}, /* of one that is not there */
        {9, 21u << 14 | 3}, /* patterns do not start so early */
        {9, 24u << 14 | 3}, /* nor so late */
        {9, 0x80000003},    /* there is no common pool */
        {10, 0x00010001},   /* padding */
        {10, 0x00001001},   /* of nibbles */
        {10, 0x00000201},   /* no such entry */
        {10, 0x00000000},   /* entries 0 and 1 are one */
    };
    make_page(1, 0, 1);
    for (size_t n = 0; n < sizeof changes / sizeof *changes; n++) {
        make_page_of_pattern(2, 2, none, 1);
        assert_true(is_taken(2));
        page.words[changes[n][0]] = changes[n][1];
        if (is_taken(2)) fail_msg("change %d", (int)n);
    }
    make_page_of_pattern(2, PALETTE_ENTRIES, none, 1);
    assert_true(is_taken(2));
    make_page_of_pattern(2, PALETTE_ENTRIES + 1, none, 1);
    assert_false(is_taken(2));
    make_page_of_pattern(2, 2, none, 0); /* no pool at all */
    page.words[9] = (2 * page.word_count + 2) << 14 | 3;
    assert_false(is_taken(2));
}

/* Whatever the last record is, it does not go beyond the last word. */
static void pages_that_end_early_are_refused(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 60; seed++) {
        make_page(seed, 12, 1 + (uint32_t)seed % 3);
        vxs_bytes bytes;
        assert_int_equal(pack(&bytes), VXS_OK);
        uint32_t node_words = vxs_page_node_words(bytes.data), *stored = malloc(page.word_count * sizeof *stored);
        assert_int_equal(vxs_page_inflate(stored, page.word_count, bytes.data, bytes.size_bytes, unpacker), VXS_OK);
        for (uint32_t count = page.word_count - 1; count && count + 120 > page.word_count; count--) {
            uint32_t nodes = node_words < count ? node_words : count, *words = malloc(count * sizeof *words);
            memcpy(words, stored, count * sizeof *words);
            assert_int_equal(vxs_page_check(words, count, nodes, page.nodes, page.node_count, &marks, VXS_PAGE_UNPACK),
                             VXS_E_CORRUPT);
            free(words);
        }
        free(stored);
        free(bytes.data);
    }
}

static void nodes_must_be_where_the_top_says(void **state)
{
    (void)state;
    make_page(2, 12, 3);
    vxs_bytes bytes;
    uint32_t *words = malloc(page.word_count * sizeof *words);
    assert_int_equal(pack(&bytes), VXS_OK);
    page.nodes[1].offset++;
    assert_int_equal(unpack(words, bytes.data, bytes.size_bytes), VXS_E_CORRUPT);
    page.nodes[1].offset--;
    page.node_count--;
    assert_int_equal(unpack(words, bytes.data, bytes.size_bytes), VXS_E_CORRUPT);
    page.node_count = 0;
    assert_int_equal(unpack(words, bytes.data, bytes.size_bytes), VXS_E_CORRUPT);
    page.node_count = 3;
    assert_int_equal(unpack(words, bytes.data, bytes.size_bytes), VXS_OK);
    free(words);
    free(bytes.data);
}

/* the resident part ------------------------------------------------------------------------------------------------------------ */

/* A light, and what it is unpacked to. */
typedef struct resident_case {
    light_sample       light;
    uint8_t            kinds[SAMPLE_COMMON_MAX];
    vxs_resident_sizes sizes;
    vxs_resident       out;
    vxs_common_marks   found;
    uint8_t           *inflated;
} resident_case;

static void case_make(resident_case *c, uint64_t seed, uint32_t patterns, uint32_t levels, uint32_t map_count)
{
    rng r = rng_split(seed, 8);
    assert_int_equal(sample_common_make(&r, &common, patterns), VXS_OK);
    vxs_common_mark(&in_common, &common.common);
    light_make(&r, &c->light, &common, levels, map_count);
    for (uint32_t n = 0; n < common.count; n++) c->kinds[n] = (uint8_t)common.pattern[n].kind;
    c->sizes          = (vxs_resident_sizes){c->light.word_count, c->light.page_count, c->light.node_count, common.count};
    c->out.words      = malloc(c->sizes.word_count * 4);
    c->out.nodes      = malloc(c->sizes.node_count * sizeof *c->out.nodes + 1);
    c->out.page_first = malloc((c->sizes.page_count + 1) * 4);
    c->inflated       = malloc(vxs_resident_inflated_bytes(&c->sizes));
    c->found.at       = malloc(vxs_resident_common_halves(&c->sizes) + 1);
}

static void case_free(resident_case *c)
{
    light_free(&c->light);
    free(c->out.words);
    free(c->out.nodes);
    free(c->out.page_first);
    free(c->inflated);
    free(c->found.at);
}

static vxs_result case_unpack(resident_case *c, const uint8_t *bytes, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1);
    memcpy(exact, bytes, size);
    vxs_result r = vxs_resident_unpack(&c->out, &c->found, c->light.levels, c->light.map_count, exact, size, c->inflated, unpacker);
    free(exact);
    return r;
}

static vxs_result case_unpack_words(resident_case *c)
{
    vxs_bytes bytes = {0};
    assert_int_equal(vxs_resident_pack(&bytes, &c->sizes, c->light.words, c->kinds, packer), VXS_OK);
    vxs_result r = case_unpack(c, bytes.data, bytes.size_bytes);
    free(bytes.data);
    return r;
}

static resident_case rc; /* large */

static void resident_parts_come_back(void **state)
{
    (void)state;
    static const uint32_t levels[] = {3, 8, 9, 11, 13, 14, 15, 16, 17};
    for (uint64_t seed = 0; seed < 36; seed++) {
        case_make(&rc, seed, (uint32_t)seed % SAMPLE_COMMON_MAX, levels[seed % 9], seed % 4 == 1 ? 6 : 1);
        light_sample *l = &rc.light;
        if (l->page_count) l->words[8] = 7; /* where pages start is not reported */
        assert_int_equal(case_unpack_words(&rc), VXS_OK);
        if (l->page_count) l->words[8] = 0;
        assert_memory_equal(rc.out.words, l->words, 4 * l->word_count);
        assert_memory_equal(rc.out.nodes, l->nodes, l->node_count * sizeof *l->nodes);
        assert_memory_equal(rc.out.page_first, l->page_first, 4 * (l->page_count + 1));
        assert_in_range(rc.found.half_count, in_common.half_count, in_common.half_count + 1); /* those of whole words */
        if (in_common.half_count) assert_memory_equal(rc.found.at, in_common.at, in_common.half_count);
        case_free(&rc);
    }
}

static void prefixes_of_resident_parts_are_refused(void **state)
{
    (void)state;
    vxs_bytes bytes = {0};
    case_make(&rc, 4, 10, 9, 1);
    assert_int_equal(vxs_resident_pack(&bytes, &rc.sizes, rc.light.words, rc.kinds, packer), VXS_OK);
    assert_int_equal(case_unpack(&rc, bytes.data, bytes.size_bytes), VXS_OK);
    for (size_t size = 0; size < bytes.size_bytes; size++) assert_int_equal(case_unpack(&rc, bytes.data, size), VXS_E_CORRUPT);
    free(bytes.data);
    case_free(&rc);
}

/* Whether the coder takes the words and kinds of a case. */
static int coder_takes(const resident_case *c)
{
    uint32_t           *patterns = malloc((common.count + 1) * sizeof *patterns);
    const light_sample *l        = &c->light;
    vxs_common          pool;
    vxs_bytes           coded    = {0};
    uint32_t            at       = l->words[1];
    int                 is_taken = 0;
    for (uint32_t odd = 0; odd < 2 && at >= 8 && at <= l->word_count && !is_taken; odd++) {
        uint32_t halves = 2 * (l->word_count - at);
        if (odd > halves) break;
        is_taken = vxs_common_index(&pool, patterns, c->kinds, common.count, l->words + at, halves - odd) == VXS_OK &&
                   resident_encoded(&coded, l->words, l->word_count, l->levels, l->map_count, &pool) == VXS_OK;
    }
    /* the head says how many nodes there are */
    if (is_taken) is_taken = vxs_load32(coded.data + 4) == c->sizes.page_count && vxs_load32(coded.data + 8) == c->sizes.node_count;
    free(patterns);
    free(coded.data);
    return is_taken;
}

static void resident_words_are_taken_where_the_coder_takes_them(void **state)
{
    (void)state;
    static const uint32_t levels[] = {8, 9, 10, 15};
    const uint32_t        seeds    = repeats(12, 24);
    uint32_t              taken = 0, refused = 0;
    for (uint64_t seed = 0; seed < seeds; seed++) {
        case_make(&rc, seed, 8, levels[seed % 4], seed % 5 == 1 && levels[seed % 4] < 15 ? 6 : 1);
        rng       r     = rng_split(seed, 9);
        uint32_t *words = malloc(rc.light.word_count * 4), head = 8 + rc.light.page_count, tops = rc.light.words[1];
        memcpy(words, rc.light.words, 4 * rc.light.word_count);
        for (int n = 0; n < 100; n++) {
            uint8_t kinds[SAMPLE_COMMON_MAX];
            memcpy(kinds, rc.kinds, sizeof kinds);
            uint32_t which = rng_below(&r, 8);
            if (which == 0)
                change_words(&r, rc.light.words, 8, NULL, 0);
            else if (which == 1)
                rc.kinds[rng_below(&r, common.count)] = (uint8_t)rng_below(&r, 18);
            else if (which < 5)
                change_words(&r, rc.light.words + head, tops - head, NULL, 0);
            else
                change_words(&r, rc.light.words + tops, rc.light.word_count - tops, NULL, 0);
            int wanted = coder_takes(&rc);
            if ((case_unpack_words(&rc) == VXS_OK) != wanted) fail_msg("seed %d, change %d: wanted %d", (int)seed, n, wanted);
            wanted ? taken++ : refused++;
            memcpy(rc.light.words, words, 4 * rc.light.word_count);
            memcpy(rc.kinds, kinds, sizeof kinds);
        }
        free(words);
        case_free(&rc);
    }
    assert_true(taken > 6 * seeds && refused > 6 * seeds);
}

/* A min above its max, in every entry that names a node, new or met before. */
static void min_is_not_above_max(void **state)
{
    (void)state;
    uint32_t changed = 0;
    for (uint64_t seed = 0; seed < 4; seed++) {
        case_make(&rc, seed, 8, seed % 2 ? 15 : 9, 1);
        uint32_t *words = rc.light.words, head = 8 + rc.light.page_count, cells = seed % 2 ? 256 : 0;
        for (uint32_t at = head + cells; at < words[1]; at += 2) {
            uint32_t before = words[at + 1], max = before >> 24;
            if (words[at] & 0x80000000u || max == 255) continue;
            words[at + 1] = (before & 0xff00ffff) | (max + 1) << 16;
            assert_int_equal(case_unpack_words(&rc), VXS_E_CORRUPT);
            words[at + 1] = (before & 0xff00ffff) | max << 16;
            assert_int_equal(case_unpack_words(&rc), VXS_OK);
            words[at + 1] = before;
            if (++changed % 40 == 0) break;
        }
        case_free(&rc);
    }
    assert_true(changed > 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pages_come_back),
        cmocka_unit_test(pages_are_appended),
        cmocka_unit_test(prefixes_are_refused),
        cmocka_unit_test(frames_of_other_sizes_are_refused),
        cmocka_unit_test(words_are_taken_where_the_coder_takes_them),
        cmocka_unit_test(stored_words_that_are_taken_are_a_page),
        cmocka_unit_test(bases_that_are_far),
        cmocka_unit_test(blocks_and_nodes),
        cmocka_unit_test(masks_of_patterns),
        cmocka_unit_test(images_of_patterns),
        cmocka_unit_test(patterns_with_a_private_palette),
        cmocka_unit_test(pages_that_end_early_are_refused),
        cmocka_unit_test(nodes_must_be_where_the_top_says),
        cmocka_unit_test(resident_parts_come_back),
        cmocka_unit_test(prefixes_of_resident_parts_are_refused),
        cmocka_unit_test(resident_words_are_taken_where_the_coder_takes_them),
        cmocka_unit_test(min_is_not_above_max),
    };
    return cmocka_run_group_tests(tests, make_zstd, free_zstd);
}
