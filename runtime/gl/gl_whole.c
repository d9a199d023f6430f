/* Lights that are whole when vxs_gl is created, of an asset or of the caller: their words, and tables of those of palette blocks
 * (gl_tables.h).
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

uint64_t vxs_gl_whole_lights(vxs_gl *gl, const vxs_gl_desc *desc)
{
    uint64_t words = 0;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        const vxs_baked_light *baked = whole_light(desc, n);
        gl->lights[n]                = (vxs_gl_light){&baked->light, (uint32_t)words};
        words += baked->word_count;
    }
    return words;
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

vxs_result vxs_gl_whole_tables(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t *words)
{
    vxs_result r        = VXS_OK;
    uint64_t   standard = most_of(TABLES_PER_WORD * *words, ((uint64_t)TABLES_MIB << 20) / sizeof(uint32_t));
    if (!(gl->table_starts = vxs_gl_alloc(gl, gl->light_count, sizeof *gl->table_starts))) return VXS_E_MEMORY;
    gl->tables      = (gl_tables){.memory = gl->memory, .first = (uint32_t)*words};
    gl->tables.most = vxs_gl_most_table_words(gl, desc, standard, *words + VXS_BLOCKS_SPARE_WORDS);
    for (uint32_t n = 0; n < gl->light_count; n++) gl->table_starts[n] = 0;
    for (uint32_t n = 0; n < gl->light_count && r == VXS_OK; n++)
        if (gl->lights[n].light->coding == VXS_CODING_BLOCKS)
            r = vxs_gl_tables_add(&gl->tables, whole_light(desc, n), &gl->table_starts[n]);
    if (r == VXS_E_ARGUMENT) { /* shaders read words alone */
        vxs_gl_tables_free(&gl->tables);
        return VXS_OK;
    }
    gl->table_count = gl->tables.count;
    *words += gl->table_count;
    return r;
}

vxs_result vxs_gl_whole_put(vxs_gl *gl, const vxs_gl_desc *desc)
{
    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < gl->light_count && r == VXS_OK; n++) {
        const vxs_baked_light *baked = whole_light(desc, n);
        uint32_t               first = gl->lights[n].first_word, has_tables = gl->table_count && gl->table_starts[n] ? 1 : 0;
        if (has_tables) r = vxs_gl_put_words(gl, &gl->table_starts[n], first, 1);
        if (r == VXS_OK) r = vxs_gl_put_words(gl, baked->words + has_tables, first + has_tables, baked->word_count - has_tables);
    }
    return r == VXS_OK ? vxs_gl_put_words(gl, gl->tables.words, gl->tables.first, gl->table_count) : r;
}
