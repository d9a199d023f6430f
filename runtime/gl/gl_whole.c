/* Lights that are whole when vxs_gl is created, of an asset or of the caller: words, or tables of those of palette blocks
 * (gl_tables.h).
 *
 *     all words                words of all lights | smoke
 *     all words, with tables   tables | words of DAGs | smoke
 *
 * SPDX-License-Identifier: MIT */
#include "gl_state.h"

enum { TABLES_MIB = 64, TABLE_WORDS_MAX = 1 << 28 };

static uint64_t least_of(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static uint64_t most_of(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static const vxs_baked_light *whole_light(const vxs_gl_desc *desc, uint32_t n)
{
    return desc->asset ? vxs_asset_light(desc->asset, n) : desc->baked[n];
}

uint32_t vxs_gl_most_table_words(const vxs_gl *gl, const vxs_gl_desc *desc, uint64_t standard, uint64_t others)
{
    int      bytes = 0;
    uint64_t most = desc->most_table_bytes ? desc->most_table_bytes / sizeof(uint32_t) : standard, held = TABLE_WORDS_MAX;
    if (desc->storage != VXS_GL_TEXTURE && gl->version >= (gl->is_es ? 310 : 430))
        gl->api.GetIntegerv(GL_MOST_STORAGE_BYTES, &bytes);
    if (bytes > 0 && (uint64_t)bytes / sizeof(uint32_t) >= others) held = least_of(held, (uint64_t)bytes / sizeof(uint32_t));
    return held < others ? 0 : (uint32_t)least_of(most, held - others);
}

static int has_tables(const vxs_gl *gl, const vxs_baked_light *baked)
{
    return gl->table_count && baked->light.coding == VXS_CODING_BLOCKS;
}

/* Make the tables of all lights of blocks; where each begins becomes its first word. table_count stays 0 if they are not wanted. */
static vxs_result make_tables(vxs_gl *gl, const vxs_gl_desc *desc)
{
    vxs_result r     = VXS_OK;
    uint64_t   words = 0, smoke = vxs_gl_smoke_words(gl, desc);
    for (uint32_t n = 0; n < gl->light_count; n++) words += whole_light(desc, n)->word_count;
    uint64_t standard = most_of(TABLES_PER_WORD * (words + smoke), ((uint64_t)TABLES_MIB << 20) / sizeof(uint32_t));
    gl->tables        = (gl_tables){.memory = gl->memory};
    gl->tables.most   = vxs_gl_most_table_words(gl, desc, standard, words + smoke + VXS_BLOCKS_SPARE_WORDS);
    for (uint32_t n = 0; n < gl->light_count && r == VXS_OK; n++)
        if (whole_light(desc, n)->light.coding == VXS_CODING_BLOCKS)
            r = vxs_gl_tables_add(&gl->tables, whole_light(desc, n), &gl->lights[n].first_word);
    if (r == VXS_OK) gl->table_count = gl->tables.count;
    if (r == VXS_E_ARGUMENT) vxs_gl_tables_free(&gl->tables); /* shaders read words alone */
    return r == VXS_E_ARGUMENT ? VXS_OK : r;
}

vxs_result vxs_gl_whole_lights(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t *words)
{
    vxs_result r = make_tables(gl, desc);
    *words       = gl->table_count;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        const vxs_baked_light *baked = whole_light(desc, n);
        gl->lights[n].light          = &baked->light;
        if (has_tables(gl, baked)) continue;
        gl->lights[n].first_word = (uint32_t)*words;
        *words += baked->word_count;
    }
    return r;
}

vxs_result vxs_gl_whole_put(vxs_gl *gl, const vxs_gl_desc *desc)
{
    vxs_result r = vxs_gl_put_words(gl, gl->tables.words, 0, gl->table_count);
    for (uint32_t n = 0; n < gl->light_count && r == VXS_OK; n++) {
        const vxs_baked_light *baked = whole_light(desc, n);
        if (!has_tables(gl, baked)) r = vxs_gl_put_words(gl, baked->words, gl->lights[n].first_word, baked->word_count);
    }
    return r;
}
