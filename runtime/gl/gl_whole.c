/* Lights that are whole when vxs_gl is created, of an asset or of the caller: words, or tables of those of palette blocks
 * (gl_tables.h).
 *
 *     all words   words of all lights | smoke
 *     with tables root of each light | tables | words of DAGs | smoke
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

/* Make the tables of all lights of blocks, behind a word for each light. table_count stays 0 if they are not wanted. */
static vxs_result make_tables(vxs_gl *gl, const vxs_gl_desc *desc)
{
    vxs_result r     = VXS_OK;
    uint64_t   words = 0, smoke = vxs_gl_smoke_words(gl, desc);
    if (!(gl->table_starts = vxs_gl_alloc(gl, gl->light_count, sizeof *gl->table_starts))) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < gl->light_count; n++) words += whole_light(desc, n)->word_count;
    uint64_t standard = most_of(TABLES_PER_WORD * (words + smoke), ((uint64_t)TABLES_MIB << 20) / sizeof(uint32_t));
    gl->tables        = (gl_tables){.memory = gl->memory, .first = gl->light_count};
    gl->tables.most   = vxs_gl_most_table_words(gl, desc, standard, words + smoke + gl->light_count + VXS_BLOCKS_SPARE_WORDS);
    for (uint32_t n = 0; n < gl->light_count && r == VXS_OK; n++)
        if (whole_light(desc, n)->light.coding == VXS_CODING_BLOCKS)
            r = vxs_gl_tables_add(&gl->tables, whole_light(desc, n), &gl->table_starts[n]);
    if (r == VXS_OK) gl->table_count = gl->tables.count;
    if (r == VXS_E_ARGUMENT) vxs_gl_tables_free(&gl->tables); /* shaders read words alone */
    return r == VXS_E_ARGUMENT ? VXS_OK : r;
}

vxs_result vxs_gl_whole_lights(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t *words)
{
    vxs_result r = make_tables(gl, desc);
    *words       = gl->table_count ? gl->light_count + (uint64_t)gl->table_count : 0;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        const vxs_baked_light *baked   = whole_light(desc, n);
        int                    is_root = gl->table_count && baked->light.coding == VXS_CODING_BLOCKS;
        gl->lights[n]                  = (vxs_gl_light){&baked->light, is_root ? n : (uint32_t)*words};
        *words += is_root ? 0 : baked->word_count;
    }
    return r;
}

vxs_result vxs_gl_whole_put(vxs_gl *gl, const vxs_gl_desc *desc)
{
    vxs_result r = vxs_gl_put_words(gl, gl->tables.words, gl->tables.first, gl->table_count);
    for (uint32_t n = 0; n < gl->light_count && r == VXS_OK; n++) {
        const vxs_baked_light *baked   = whole_light(desc, n);
        int                    is_root = gl->table_count && baked->light.coding == VXS_CODING_BLOCKS;
        r = vxs_gl_put_words(gl, is_root ? &gl->table_starts[n] : baked->words, gl->lights[n].first_word,
                             is_root ? 1 : baked->word_count);
    }
    return r;
}
