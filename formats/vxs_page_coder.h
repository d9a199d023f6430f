/* The entropy coder of pages: symbols to 16-bit words and back. Internal to vxs_page_*.c. Not installed.
 *
 * Two rANS states (Duda 2013) are used alternately, so that the processor works on two symbols at once. A state is a 32-bit
 * number of at least 2^16; odds are parts of 2^15; a state that falls below 2^16 reads one word. The encoder works
 * backwards, so that the decoder reads the words in storage order. A symbol is one of sixteen (a nibble), or plain bits. The
 * odds of nibbles are adaptive. They are kept as sums: from[s] is the sum of the odds before symbol s. Each coded symbol
 * moves all sums towards the distribution that has only this symbol: a subtraction, shift and addition for each of two
 * vectors of eight.
 *
 * The includer defines PAGE_ENCODING: 1 for the encoder, 0 for the decoder. In the encoder, a function code_*(c, odds,
 * value) codes `value` and returns it; in the decoder it ignores `value` and returns the decoded value.
 * With and without SSE2 the bytes are the same.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_CODER_H
#define VXS_PAGE_CODER_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "vxs_bytes.h"

#ifdef __SSE2__
#define PAGE_SSE2
#include <emmintrin.h>
#endif

#ifdef __GNUC__
#define PAGE_INLINE          static inline __attribute__((always_inline))
#define page_first_bit(x)    ((uint32_t)__builtin_ctz(x))
#define page_last_bit(x)     (31 - (uint32_t)__builtin_clz(x))
#define page_first_bit_64(x) ((uint32_t)__builtin_ctzll(x))
#else
#define PAGE_INLINE static inline
static inline uint32_t page_first_bit(uint32_t x)
{
    uint32_t n = 0;
    while (!(x >> n & 1)) n++;
    return n;
}
static inline uint32_t page_first_bit_64(uint64_t x)
{
    return (uint32_t)x ? page_first_bit((uint32_t)x) : 32 + page_first_bit((uint32_t)(x >> 32));
}
static inline uint32_t page_last_bit(uint32_t x)
{
    uint32_t n = 31;
    while (!(x >> n & 1)) n--;
    return n;
}
#endif

/* Functions that are inlined for speed; not in builds with VXS_SMALL, which have half of the code and are a tenth slower. */
#ifdef VXS_SMALL
#define PAGE_CALL static
#else
#define PAGE_CALL PAGE_INLINE
#endif

/* The decoder fits better in the cache of instructions where these are not inlined; the encoder is quicker where they are. */
#if defined __GNUC__ && !PAGE_ENCODING
#define PAGE_APART static __attribute__((noinline, unused))
#else
#define PAGE_APART PAGE_CALL
#endif

enum { ODDS_BITS = 15, ODDS_ONE = 1 << ODDS_BITS, STATE_LEAST = 1 << 16 };

/* odds ------------------------------------------------------------------------------------------------------------------------- */

/* 36 bytes: loads of vectors that are not aligned are as fast, and a third more odds fit in the cache. */
typedef struct nibble_odds {
    uint16_t from[17]; /* from[0] is 0; ascending; from[16] is ODDS_ONE */
    uint16_t seen;
} nibble_odds;

/* Adaptation rate, as a shift, after so many symbols: fast at first. */
static const uint8_t nibble_rate[161] = {
    1, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 6,
    6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6,
    6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6,
    6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 7};

/* A symbol is found as the sums behind it: those above a number `at` within its odds. Learning moves all sums towards those of the
 * distribution that has only this symbol, where every other symbol keeps odds of 1: sum n is n up to the symbol, and n + REST
 * behind it. So learning does not wait for the symbol's number. */
enum { REST = ODDS_ONE - 16 };

#ifdef PAGE_SSE2

typedef struct nibble {
    __m128i low, high; /* masks of eight sums each */
} nibble;

/* The symbol whose part of the odds contains `at`, 0..ODDS_ONE - 1. */
PAGE_INLINE nibble nibble_at(const nibble_odds *odds, uint32_t at)
{
    const __m128i *from = (const __m128i *)odds->from, all = _mm_set1_epi16((int16_t)at);
    return (nibble){_mm_cmpgt_epi16(_mm_loadu_si128(from), all), _mm_cmpgt_epi16(_mm_loadu_si128(from + 1), all)};
}

/* The same for a symbol that is known. */
PAGE_INLINE nibble nibble_of(uint32_t number)
{
    const __m128i all = _mm_set1_epi16((int16_t)number);
    return (nibble){_mm_cmpgt_epi16(_mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7), all),
                    _mm_cmpgt_epi16(_mm_setr_epi16(8, 9, 10, 11, 12, 13, 14, 15), all)};
}

PAGE_INLINE uint32_t nibble_number(nibble behind)
{
    return page_first_bit((uint32_t)_mm_movemask_epi8(_mm_packs_epi16(behind.low, behind.high)) | 0x10000) - 1;
}

PAGE_INLINE __m128i shift_right(__m128i x, uint32_t bits)
{
#ifdef __wasm_simd128__ /* one instruction; emulated SSE2 takes several */
    return (__m128i)wasm_i16x8_shr((v128_t)x, bits);
#else
    return _mm_sra_epi16(x, _mm_cvtsi32_si128((int)bits));
#endif
}

PAGE_INLINE void learn_eight(__m128i *from, __m128i numbers, __m128i behind, uint32_t rate)
{
    __m128i sums = _mm_loadu_si128(from);
    __m128i way  = _mm_add_epi16(_mm_sub_epi16(numbers, sums), _mm_and_si128(behind, _mm_set1_epi16(REST)));
    _mm_storeu_si128(from, _mm_add_epi16(sums, shift_right(way, rate)));
}

PAGE_INLINE void nibble_learn(nibble_odds *odds, nibble behind, uint32_t rate)
{
    __m128i *from = (__m128i *)odds->from;
    learn_eight(from, _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7), behind.low, rate);
    learn_eight(from + 1, _mm_setr_epi16(8, 9, 10, 11, 12, 13, 14, 15), behind.high, rate);
}

#else

typedef struct nibble {
    uint32_t number;
} nibble;

PAGE_INLINE nibble nibble_at(const nibble_odds *odds, uint32_t at)
{
    uint32_t count = 0;
    for (int n = 0; n < 16; n++) count += odds->from[n] <= at;
    return (nibble){count - 1};
}

PAGE_INLINE nibble nibble_of(uint32_t number)
{
    return (nibble){number};
}

PAGE_INLINE uint32_t nibble_number(nibble behind)
{
    return behind.number;
}

PAGE_INLINE void nibble_learn(nibble_odds *odds, nibble behind, uint32_t rate)
{
    for (uint32_t n = 0; n < 16; n++) {
        int32_t way   = (int32_t)(n + (n > behind.number ? REST : 0)) - odds->from[n];
        odds->from[n] = (uint16_t)(odds->from[n] + (way >> rate));
    }
}

#endif

/* Start sums of odds in proportion to weights; their sum is 2^32, and each symbol gets at least 1.
 * seen  adapt as slowly as after so many symbols */
static void nibble_start(nibble_odds *odds, const uint32_t weight[16], uint32_t seen)
{
    uint64_t before = 0;
    for (uint32_t n = 0; n < 16; n++) {
        odds->from[n] = (uint16_t)(n + (before * (ODDS_ONE - 16) >> 32));
        before += weight[n];
    }
    odds->from[16] = ODDS_ONE;
    odds->seen     = (uint16_t)seen;
}

/* symbols ---------------------------------------------------------------------------------------------------------------------- */

#ifndef PAGE_ENCODING
#error PAGE_ENCODING is not defined: 0 or 1
#elif PAGE_ENCODING

/* Symbols to code: where each begins and ends in the odds. Coding begins when all are known, with the last one. */
typedef struct coder {
    uint32_t *parts, *at, *end; /* begin | end << 16; at: where the next one goes, always before `end` */
    int       no_memory;
} coder;

/* 0: no memory. */
static int coder_begin(coder *c)
{
    const size_t capacity = 1 << 16;
    uint32_t    *parts    = malloc(capacity * sizeof *parts);
    *c                    = parts ? (coder){parts, parts, parts + capacity, 0} : (coder){0};
    return parts != NULL;
}

/* Make room. Without memory the last symbol is overwritten from then on. */
static coder coder_grown(coder c)
{
    size_t    count = (size_t)(c.end - c.parts);
    uint32_t *grown = realloc(c.parts, 2 * count * sizeof *grown);
    if (grown) return (coder){grown, grown + count, grown + 2 * count, c.no_memory};
    c.no_memory = 1;
    c.at--;
    return c;
}

PAGE_INLINE void code_part(coder *c, uint32_t begin, uint32_t end)
{
    *c->at++ = begin | end << 16;
    if (c->at == c->end) *c = coder_grown(*c);
}

#else

typedef struct coder {
    /* now, next: states of the next symbol and of the one after it. They do not lie side by side: compilers would store both as one
     * vector, and the next symbol would wait for it */
    uint32_t       now;
    /* in: next word; end: where the two states are stored, so that one word beyond the last can be read safely. If too many words
     * are taken, `in` stays beyond `end` */
    const uint8_t *in;
    uint32_t       next;
    const uint8_t *end;
} coder;

/* Consume the symbol whose odds are from..from + size - 1. Whether a word is read is unpredictable, so there is no branch on
 * it. */
PAGE_INLINE void decode_part(coder *c, uint32_t from, uint32_t size)
{
    uint32_t state = size * (c->now >> ODDS_BITS) + (c->now & (ODDS_ONE - 1)) - from, whole = state >= STATE_LEAST;
    uint64_t more = (uint64_t)state << 16 | vxs_load16(c->in);
    c->in += 2 * ((whole ^ 1) & (uint32_t)(c->in <= c->end));
    c->now  = c->next;
    c->next = (uint32_t)(more >> 16 * whole);
}

#endif

/* Code symbol `value`; in the decoder, it is already known. The odds do not adapt yet. */
PAGE_INLINE void code_symbol(coder *c, const nibble_odds *odds, uint32_t value)
{
    uint32_t from = odds->from[value], end = odds->from[value + 1];
#if PAGE_ENCODING
    code_part(c, from, end);
#else
    decode_part(c, from, end - from);
#endif
}

PAGE_INLINE void learn(nibble_odds *odds, nibble behind)
{
    nibble_learn(odds, behind, nibble_rate[odds->seen]);
    odds->seen += odds->seen < 160;
}

PAGE_INLINE uint32_t code_nibble_here(coder *c, nibble_odds *odds, uint32_t value)
{
#if PAGE_ENCODING
    nibble behind = nibble_of(value);
#else
    nibble behind = nibble_at(odds, c->now & (ODDS_ONE - 1));
    value         = nibble_number(behind);
#endif
    code_symbol(c, odds, value);
    learn(odds, behind);
    return value;
}

/* The same for symbols that are not frequent. */
PAGE_APART uint32_t code_nibble(coder *c, nibble_odds *odds, uint32_t value)
{
    return code_nibble_here(c, odds, value);
}

/* Two nibbles of a byte, the low one first. The high one has odds second[0], or second[apart] if the highest bit of the low
 * one is set. The two nibbles use different states, so the decoder looks up the high one with both odds while it decodes the
 * low one. So the odds adapt after both. */
PAGE_INLINE uint32_t code_two_nibbles(coder *c, nibble_odds *first, nibble_odds *second, uint32_t apart, uint32_t value)
{
    uint32_t low = value & 15, high = value >> 4;
#if PAGE_ENCODING
    second += apart * (low >> 3);
    nibble low_behind = nibble_of(low), high_behind = nibble_of(high);
#else
    uint32_t at = c->next & (ODDS_ONE - 1), high_0 = nibble_number(nibble_at(second, at)),
             high_1   = nibble_number(nibble_at(second + apart, at));
    nibble low_behind = nibble_at(first, c->now & (ODDS_ONE - 1));
    low               = nibble_number(low_behind);
    high              = high_0 ^ ((high_0 ^ high_1) & (0 - (low >> 3)));
    second += apart * (low >> 3);
    nibble high_behind = nibble_at(second, at);
#endif
    code_symbol(c, first, low);
    code_symbol(c, second, high);
    learn(first, low_behind);
    learn(second, high_behind);
    return low | high << 4;
}

/* 0 to 12 bits, all equally likely. */
PAGE_CALL uint32_t code_plain(coder *c, uint32_t bits, uint32_t value)
{
    uint32_t shift = ODDS_BITS - bits;
#if PAGE_ENCODING
    code_part(c, value << shift, (value + 1) << shift);
#else
    value              = (c->now & (ODDS_ONE - 1)) >> shift;
    decode_part(c, value << shift, 1u << shift);
#endif
    return value;
}

#endif
