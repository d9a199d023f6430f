/* The fingerprint of a scene; see fingerprint.h.
 *
 * Numbers are hashed one by one, as 64-bit words. Structs are never hashed, because their padding is undefined.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/fingerprint.h"

#include <endian.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

enum { BUFFER_WORDS = 512 };

/* Words are buffered: hashing many at once is much faster. */
typedef struct hasher {
    XXH3_state_t state;
    uint64_t     words[BUFFER_WORDS];
    size_t       count;
} hasher;

static void hash_begin(hasher *h)
{
    XXH3_128bits_reset(&h->state);
    h->count = 0;
}

static void flush(hasher *h)
{
    XXH3_128bits_update(&h->state, h->words, h->count * sizeof *h->words);
    h->count = 0;
}

static void hash_word(hasher *h, uint64_t word)
{
    if (h->count == BUFFER_WORDS) flush(h);
    h->words[h->count++] = htole64(word);
}

/* Normalizes -0 to 0, and all NaN to one. */
static void hash_number(hasher *h, double number)
{
    uint64_t bits;
    number = isnan(number) ? (double)NAN : number + 0.0;
    memcpy(&bits, &number, sizeof bits);
    hash_word(h, bits);
}

static void hash_numbers(hasher *h, const double *numbers, size_t count)
{
    for (size_t n = 0; n < count; n++) hash_number(h, numbers[n]);
}

static void hash_bytes(hasher *h, const void *bytes, size_t size_bytes)
{
    hash_word(h, size_bytes);
    flush(h);
    XXH3_128bits_update(&h->state, bytes, size_bytes);
}

static XXH128_hash_t hash_end(hasher *h)
{
    flush(h);
    return XXH3_128bits_digest(&h->state);
}

static void hash_end_text(hasher *h, char text[FINGERPRINT_BYTES])
{
    XXH128_hash_t hash = hash_end(h);
    snprintf(text, FINGERPRINT_BYTES, "%016" PRIx64 "%016" PRIx64, (uint64_t)hash.high64, (uint64_t)hash.low64);
}

static XXH128_hash_t hash_of_mask(hasher *h, const alpha_mask *mask, const alpha_image *image)
{
    hash_begin(h);
    hash_word(h, image->width_px);
    hash_bytes(h, image->alpha, (size_t)image->width_px * image->height_px);
    hash_number(h, mask->threshold);
    hash_word(h, (uint64_t)mask->wrap_u);
    hash_word(h, (uint64_t)mask->wrap_v);
    hash_word(h, mask->nearest != 0);
    return hash_end(h);
}

mask_fingerprint alpha_mask_fingerprint(const alpha_mask *mask, const alpha_image *image)
{
    hasher        h;
    XXH128_hash_t hash = hash_of_mask(&h, mask, image);
    return (mask_fingerprint){hash.low64, hash.high64};
}

vxs_result scene_fingerprint_take(scene_fingerprint *f, const scene *s, run_context *m)
{
    hasher h;

    hash_begin(&h);
    for (size_t t = 0; t < s->triangle_count; t++) {
        for (int corner = 0; corner < 3; corner++) hash_numbers(&h, s->positions_ws + 3 * (size_t)s->indices[3 * t + corner], 3);
        hash_word(&h, s->triangle_flags[t] & (TRIANGLE_DOUBLE_SIDED | TRIANGLE_ALPHA_MASK));
    }
    hash_end_text(&h, f->geometry);

    hash_begin(&h);
    hash_numbers(&h, s->camera_positions_ws, 3 * s->camera_count);
    hash_end_text(&h, f->cameras);

    static const double nowhere[3] = {0, 0, 0};
    hash_begin(&h);
    for (const scene_light *l = s->lights; l < s->lights + s->light_count; l++) {
        int is_punctual = l->shape.kind != LIGHT_DIRECTIONAL;
        hash_bytes(&h, l->name, strlen(l->name));
        hash_word(&h, (uint64_t)is_punctual);
        hash_numbers(&h, is_punctual ? l->shape.position_ws : nowhere, 3);
    }
    hash_end_text(&h, f->lights);

    /* triangle numbers are not hashed: the geometry hash already includes which triangles have holes */
    XXH128_hash_t *masks = calloc(s->alpha_mask_count + 1, sizeof *masks);
    if (!masks) return fail(m, VXS_E_MEMORY, "out of memory for the fingerprint of %zu alpha masks", s->alpha_mask_count);
    for (size_t n = 0; n < s->alpha_mask_count; n++)
        masks[n] = hash_of_mask(&h, &s->alpha_masks[n], &s->images[s->alpha_masks[n].image]);
    hash_begin(&h);
    for (size_t n = 0; n < s->holed_triangle_count; n++) {
        const holed_triangle *t = &s->holed_triangles[n];
        hash_word(&h, masks[t->mask].high64);
        hash_word(&h, masks[t->mask].low64);
        for (int corner = 0; corner < 3; corner++) hash_numbers(&h, (double[2]){t->uv[corner][0], t->uv[corner][1]}, 2);
    }
    hash_end_text(&h, f->alpha_masks);
    free(masks);
    return VXS_OK;
}
