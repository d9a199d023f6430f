/* Words and lights on a GPU; see vxs_gl.h.
 * SPDX-License-Identifier: MIT */
#include "vxs_gl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gl_state.h"
#include "vxs_desc.h"

enum { WORDS_WIDE = 2048, LIGHTS_WIDE = 64, LIGHT_TEXELS = 6, LIGHT_WORDS = 24, RANGES_AT_FIRST = 64 };

_Static_assert(sizeof(vxs_light_constants) == LIGHT_WORDS * sizeof(uint32_t), "lights are uploaded as words");

/* the context ----------------------------------------------------------------------------------------------------------------- */

vxs_result vxs_gl_fail(const vxs_gl *gl, vxs_result r, const char *text)
{
    if (gl->log) gl->log(VXS_SEVERITY_ERROR, text, gl->user);
    return r;
}

static vxs_result load(vxs_gl *gl, const vxs_gl_desc *desc)
{
#define LOAD(result, name, arguments) gl->api.name = (result(GL_CALL *) arguments)desc->get_proc_address("gl" #name, desc->user);
#define LOADED(result, name, arguments)                                                                                            \
    if (!gl->api.name) return vxs_gl_fail(gl, VXS_E_GL, "the OpenGL context has no function gl" #name);
    GL_API(LOAD)
    GL_API(LOADED)
    GL_COMPUTE_API(LOAD)
#undef LOADED
#undef LOAD
    return VXS_OK;
}

/* Parse "4.5 (Core Profile) ...", or "OpenGL ES 3.1 ...". */
static void read_version(vxs_gl *gl)
{
    static const char es[]  = "OpenGL ES ";
    const char       *text  = (const char *)gl->api.GetString(GL_NAME_VERSION);
    int               major = 0, minor = 0;
    if (!text) return;
    gl->is_es = !strncmp(text, es, sizeof es - 1);
    if (sscanf(text + (gl->is_es ? sizeof es - 1 : 0), "%d.%d", &major, &minor) == 2) gl->version = 100 * major + 10 * minor;
}

/* Whether storage buffers can hold words and lights. */
static int has_buffers(const vxs_gl *gl, uint64_t bytes)
{
    int blocks = 0, most = 0;
    if (gl->version < (gl->is_es ? 310 : 430)) return 0;
    gl->api.GetIntegerv(GL_MOST_FRAGMENT_STORAGE_BLOCKS, &blocks);
    gl->api.GetIntegerv(GL_MOST_STORAGE_BYTES, &most);
    return blocks >= 3 && bytes <= (uint64_t)most;
}

static vxs_result choose_storage(vxs_gl *gl, vxs_gl_storage asked, uint64_t word_count)
{
    int buffers    = has_buffers(gl, word_count * sizeof(uint32_t));
    gl->is_texture = asked == VXS_GL_TEXTURE || !buffers;
    if (gl->version < (gl->is_es ? 300 : 330))
        return vxs_gl_fail(gl, VXS_E_GL, "expected an OpenGL context of version 3.3 or later, or ES 3.0");
    if (asked != VXS_GL_BUFFER || buffers) return VXS_OK;
    if (gl->version >= (gl->is_es ? 310 : 430))
        return vxs_gl_fail(
            gl, VXS_E_MEMORY,
            "VXS_GL_BUFFER: the words are larger than a storage buffer of this context: use VXS_GL_TEXTURE, or most_table_bytes 1");
    return vxs_gl_fail(gl, VXS_E_GL, "VXS_GL_BUFFER: expected an OpenGL context of version 4.3 or later, or ES 3.1");
}

/* lights and words ------------------------------------------------------------------------------------------------------------ */

void *vxs_gl_alloc(const vxs_gl *gl, uint64_t count, size_t size)
{
    return count > SIZE_MAX / size ? NULL : gl->memory.alloc((size_t)count * size, gl->memory.user);
}

void vxs_gl_free(const vxs_gl *gl, void *memory, uint64_t count, size_t size)
{
    if (memory) gl->memory.free(memory, (size_t)count * size, gl->memory.user);
}

static int grow_ranges(vxs_gl *gl)
{
    uint32_t  capacity = gl->range_capacity ? 2 * gl->range_capacity : RANGES_AT_FIRST;
    gl_range *ranges   = vxs_gl_alloc(gl, capacity, sizeof *ranges);
    if (!ranges) return 0;
    for (uint32_t n = 0; n < gl->range_count; n++) ranges[n] = gl->ranges[(gl->range_first + n) % gl->range_capacity];
    vxs_gl_free(gl, gl->ranges, gl->range_capacity, sizeof *gl->ranges);
    gl->ranges         = ranges;
    gl->range_capacity = capacity;
    gl->range_first    = 0;
    return 1;
}

vxs_result vxs_gl_put_words(vxs_gl *gl, const uint32_t *words, uint32_t first, uint32_t count)
{
    if (!count) return VXS_OK;
    if (gl->range_count == gl->range_capacity && !grow_ranges(gl)) return VXS_E_MEMORY;
    gl->ranges[(gl->range_first + gl->range_count++) % gl->range_capacity] = (gl_range){words, first, count};
    gl->bytes_left += (uint64_t)count * sizeof *words;
    return VXS_OK;
}

static const vxs_baked_smoke *smoke_of(const vxs_gl_desc *desc, uint32_t light)
{
    if (desc->asset) return vxs_asset_smoke(desc->asset, light);
    if (desc->smoke) return desc->smoke[light];
    return desc->stream ? vxs_stream_smoke(desc->stream, light) : NULL;
}

uint64_t vxs_gl_smoke_words(const vxs_gl *gl, const vxs_gl_desc *desc)
{
    uint64_t words = 0;
    for (uint32_t n = 0; n < gl->light_count; n++) words += smoke_of(desc, n) ? 1 + (uint64_t)smoke_of(desc, n)->word_count : 1;
    return words;
}

/* Returns the first word of a light's smoke; smoke that is not yet in a stream's words is placed at the end. 0: no smoke.
 * words  [in, out] word count so far */
static uint32_t place_of(const vxs_gl *gl, const vxs_gl_desc *desc, uint32_t light, uint64_t *words)
{
    const vxs_baked_smoke *smoke = smoke_of(desc, light);
    uint32_t               count, at = (uint32_t)*words;
    if (!smoke) return 0;
    if (desc->stream && !gl->table_count && smoke == vxs_stream_smoke(desc->stream, light))
        return (uint32_t)(smoke->words - vxs_stream_words(desc->stream, &count));
    *words += smoke->word_count;
    return at;
}

/* Place a table with the first word of each light's smoke behind the words of all lights, followed by smoke that is not among
 * these words.
 * words  [in, out] word count so far */
static vxs_result place_smoke(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t *words)
{
    uint32_t some = 0;
    for (uint32_t n = 0; n < gl->light_count; n++) some += smoke_of(desc, n) != NULL;
    if (!some) return VXS_OK;
    if (!(gl->smoke = vxs_gl_alloc(gl, gl->light_count, sizeof *gl->smoke))) return VXS_E_MEMORY;
    gl->smoke_word = (uint32_t)*words;
    *words += gl->light_count;
    for (uint32_t n = 0; n < gl->light_count; n++) gl->smoke[n] = place_of(gl, desc, n, words);
    return VXS_OK;
}

static vxs_result put_smoke(vxs_gl *gl, const vxs_gl_desc *desc)
{
    if (!gl->smoke) return VXS_OK;
    vxs_result r = vxs_gl_put_words(gl, gl->smoke, gl->smoke_word, gl->light_count);
    if (r == VXS_OK) r = vxs_gl_put_words(gl, &gl->smoke_word, gl->words.count - 1, 1);
    for (uint32_t n = 0; r == VXS_OK && n < gl->light_count; n++)
        if (gl->smoke[n]) r = vxs_gl_put_words(gl, smoke_of(desc, n)->words, gl->smoke[n], smoke_of(desc, n)->word_count);
    return r;
}

/* Texels in a row of the words' texture: a power of two, so that row and column are a shift and a mask. More than WORDS_WIDE,
 * which every WebGL 2 context supports, only where the texture would be too high. */
static uint32_t words_wide(const vxs_gl *gl, uint64_t count)
{
    int      most = 0;
    uint32_t wide = WORDS_WIDE;
    gl->api.GetIntegerv(GL_MOST_TEXTURE_SIZE, &most);
    while (count / wide >= (uint64_t)most && 2 * wide <= (uint32_t)most) wide *= 2;
    return wide;
}

/* Name what all lights have in common, so that code for others is not compiled. */
static void write_common(const vxs_gl *gl, char *to, size_t size)
{
    const vxs_light *first = gl->lights[0].light;
    uint32_t         cube = first->flags & VXS_LIGHT_CUBE, kinds = 1, cubes = 1, codings = 1;
    for (uint32_t n = 1; n < gl->light_count; n++) {
        const vxs_light *l = gl->lights[n].light;
        kinds &= l->kind == first->kind;
        cubes &= (l->flags & VXS_LIGHT_CUBE) == cube;
        codings &= l->coding == first->coding;
    }
    char *end = to + size;
    if (kinds) to += snprintf(to, (size_t)(end - to), "#define VXS_ONLY_KIND %u\n", first->kind);
    if (cubes) to += snprintf(to, (size_t)(end - to), "#define VXS_ONLY_CUBE %d\n", cube != 0);
    if (codings) snprintf(to, (size_t)(end - to), "#define VXS_ONLY_CODING %u\n", first->coding);
}

/* Write the first text of shaders. With buffers it depends on no sizes, because buffers have their own length. So programs of
 * levels with lights of the same kinds are the same, and a driver's program cache finds them. */
static void write_head(vxs_gl *gl)
{
    int   language = gl->is_es ? gl->is_texture ? 300 : 310 : gl->is_texture ? 330 : 430;
    char *to = gl->head, *end = gl->head + sizeof gl->head;
    to += snprintf(to, (size_t)(end - to), "#version %d %s\n", language, gl->is_es ? "es" : "core");
    if (gl->is_texture)
        to += snprintf(to, (size_t)(end - to),
                       "#define VXS_GL_LIGHT_COUNT %uu\n#define VXS_GL_LAST_WORD %uu\n#define VXS_GL_WIDE %uu\n", gl->light_count,
                       gl->words.count - 1, gl->words.wide);
    else
        to += snprintf(
            to, (size_t)(end - to),
            "#define VXS_GL_BUFFERS\n#define VXS_GL_AT_WORDS %u\n#define VXS_GL_AT_LIGHTS %u\n#define VXS_GL_AT_LISTS %u\n",
            gl->first_binding, gl->first_binding + 1, gl->first_binding + 2);
    if (gl->smoke) to += snprintf(to, (size_t)(end - to), "#define VXS_GL_SMOKE\n");
    if (gl->table_count)
        to += snprintf(to, (size_t)(end - to), "#define VXS_GL_TABLES\n%s", gl->stream ? "#define VXS_GL_STREAM\n" : "");
    if (gl->light_count) write_common(gl, to, (size_t)(end - to));
}

static vxs_result make(vxs_gl *gl, const vxs_gl_desc *desc)
{
    uint64_t word_count = desc->word_count;
    gl->light_count     = desc->asset    ? vxs_asset_light_count(desc->asset)
                          : desc->stream ? vxs_stream_light_count(desc->stream)
                                         : desc->light_count;
    gl->first_binding   = desc->first_binding;
    gl->stream          = desc->stream;
    vxs_result r        = load(gl, desc);
    if (r != VXS_OK) return r;
    read_version(gl);
    gl->lights    = vxs_gl_alloc(gl, gl->light_count, sizeof *gl->lights);
    gl->constants = vxs_gl_alloc(gl, gl->light_count, sizeof *gl->constants);
    if (!gl->lights || !gl->constants) return VXS_E_MEMORY;
    if (desc->asset || desc->baked)
        r = vxs_gl_whole_lights(gl, desc, &word_count);
    else if (desc->stream)
        word_count = vxs_gl_stream_tables_lights(gl, desc, vxs_gl_stream_lights(gl));
    else
        memcpy(gl->lights, desc->lights, gl->light_count * sizeof *gl->lights);

    if (r == VXS_OK) r = place_smoke(gl, desc, &word_count);
    if (r != VXS_OK) return r;
    if (desc->stream && gl->table_count) word_count = vxs_gl_stream_tables_place(gl, word_count);

    /* lookups may read a few words behind a light's last one; the last word is the position of the table of smoke */
    word_count += VXS_BLOCKS_SPARE_WORDS;
    r = choose_storage(gl, desc->storage, word_count);
    if (r != VXS_OK) return r;
    if (!vxs_gl_words_make(gl, &gl->words, word_count, 1, words_wide(gl, word_count)))
        return vxs_gl_fail(gl, VXS_E_MEMORY,
                           "no room on the graphics processor for all words: use a stream, fewer lights or smaller maps");
    if (!vxs_gl_words_make(gl, &gl->rows, (uint64_t)LIGHT_WORDS * gl->light_count, 4, LIGHT_TEXELS * LIGHTS_WIDE))
        return VXS_E_MEMORY;
    write_head(gl);
    vxs_gl_origin(gl, NULL);
    if ((r = put_smoke(gl, desc)) != VXS_OK) return r;
    if (desc->asset || desc->baked) return vxs_gl_whole_put(gl, desc);
    return desc->stream ? vxs_gl_stream_put(gl) : VXS_OK;
}

vxs_result vxs_gl_create(vxs_gl **out, const vxs_gl_desc *desc)
{
    vxs_gl_desc  known  = {0};
    const size_t first  = offsetof(vxs_gl_desc, first_binding) + sizeof known.first_binding;
    vxs_result   result = vxs_desc_take(&known, sizeof known, first, desc);
    *out                = NULL;
    if (result != VXS_OK) return result;
    if (!known.get_proc_address || !!known.asset + !!known.stream + !!known.baked > 1) return VXS_E_ARGUMENT;
    if (!known.asset && !known.stream && ((!known.lights && !known.baked) || !known.light_count)) return VXS_E_ARGUMENT;
    for (uint32_t n = 0; !known.asset && !known.stream && n < known.light_count; n++)
        if (known.baked ? !known.baked[n] : !known.lights[n].light) return VXS_E_ARGUMENT;
    vxs_allocator memory = vxs_allocator_of(&(vxs_read_desc){.allocator = known.allocator});
    vxs_gl       *gl     = memory.alloc(sizeof *gl, memory.user);
    if (!gl) return VXS_E_MEMORY;
    *gl    = (vxs_gl){.memory = memory, .log = known.log, .user = known.user};
    result = make(gl, &known);
    if (result == VXS_OK)
        *out = gl;
    else
        vxs_gl_destroy(gl);
    return result;
}

void vxs_gl_destroy(vxs_gl *gl)
{
    if (!gl) return;
    vxs_allocator memory = gl->memory;
    vxs_gl_words_delete(gl, &gl->words);
    vxs_gl_words_delete(gl, &gl->rows);
    vxs_gl_words_delete(gl, &gl->lists);
    if (gl->culling) gl->api.DeleteProgram(gl->culling);
    vxs_gl_free(gl, gl->lights, gl->light_count, sizeof *gl->lights);
    vxs_gl_free(gl, gl->constants, gl->light_count, sizeof *gl->constants);
    vxs_gl_tables_free(&gl->tables);
    vxs_gl_stream_tables_free(gl);
    vxs_gl_free(gl, gl->smoke, gl->light_count, sizeof *gl->smoke);
    vxs_gl_free(gl, gl->ranges, gl->range_capacity, sizeof *gl->ranges);
    vxs_gl_free(gl, gl->pages, gl->page_count, sizeof *gl->pages);
    vxs_gl_free(gl, gl->names, gl->page_count, sizeof *gl->names);
    memory.free(gl, sizeof *gl, memory.user);
}

/* upload ---------------------------------------------------------------------------------------------------------------------- */

vxs_result vxs_gl_put(vxs_gl *gl, const uint32_t *words, uint32_t first, uint32_t count)
{
    uint32_t end = gl->smoke ? gl->smoke_word : gl->words.count - VXS_BLOCKS_SPARE_WORDS;
    if (gl->table_count)
        return vxs_gl_fail(gl, VXS_E_ARGUMENT,
                           "vxs_gl_put: tables would not follow new words: create with most_table_bytes 1, without them");
    if (first > end || count > end - first || (!words && count)) return VXS_E_ARGUMENT;
    return vxs_gl_put_words(gl, words, first, count);
}

uint64_t vxs_gl_upload(vxs_gl *gl, size_t max_bytes)
{
    size_t room = max_bytes / sizeof(uint32_t);
    if (gl->stream) vxs_gl_stream_detach(gl);
    while (gl->range_count && room) {
        gl_range *r    = &gl->ranges[gl->range_first];
        uint32_t  some = r->count < room ? r->count : (uint32_t)room;
        vxs_gl_words_write(gl, &gl->words, r->words, r->first, some);
        r->words += some;
        r->first += some;
        r->count -= some;
        room -= some;
        gl->bytes_left -= (uint64_t)some * sizeof(uint32_t);
        gl->bytes_uploaded += (uint64_t)some * sizeof(uint32_t);
        if (r->count) break;
        gl->range_first = (gl->range_first + 1) % gl->range_capacity;
        gl->range_count--;
    }
    if (!gl->range_count && !gl->stream) vxs_gl_tables_free(&gl->tables);
    return gl->bytes_left + (gl->stream ? vxs_gl_stream_upload(gl, room) : 0);
}

uint64_t vxs_gl_table_bytes(const vxs_gl *gl)
{
    return (uint64_t)gl->table_count * sizeof(uint32_t);
}

uint64_t vxs_gl_uploaded_bytes(const vxs_gl *gl)
{
    return gl->bytes_uploaded;
}

void vxs_gl_origin(vxs_gl *gl, const double origin_ws[3])
{
    for (uint32_t n = 0; n < gl->light_count; n++)
        gl->constants[n] = vxs_light_constants_of(gl->lights[n].light, origin_ws, gl->lights[n].first_word);
    vxs_gl_words_write(gl, &gl->rows, (const uint32_t *)gl->constants, 0, LIGHT_WORDS * gl->light_count);
}

const vxs_light_constants *vxs_gl_constants(const vxs_gl *gl)
{
    return gl->constants;
}

uint32_t vxs_gl_light_count(const vxs_gl *gl)
{
    return gl->light_count;
}

/* shaders --------------------------------------------------------------------------------------------------------------------- */

void vxs_gl_texts(const vxs_gl *gl, const char *texts[VXS_GL_TEXTS])
{
    const char *const all[VXS_GL_TEXTS] = {gl->head,
                                           vxs_gl_text_words_tables_glsl,
                                           vxs_gl_text_vxs_lookup_h,
                                           gl->table_count ? "" : vxs_gl_text_vxs_lookup_blocks_h,
                                           vxs_gl_text_vxs_space_h,
                                           vxs_gl_text_vxs_cull_h,
                                           vxs_gl_text_smoke_lights_glsl};
    memcpy(texts, all, sizeof all);
}

void vxs_gl_link(const vxs_gl *gl, unsigned program)
{
    static const char *const names[] = {"vxs_words", "vxs_lights", "vxs_lists"};
    int                      before;
    if (!gl->is_texture) return;
    gl->api.GetIntegerv(GL_IS_PROGRAM, &before);
    gl->api.UseProgram(program);
    for (int n = 0; n < 3; n++) {
        int at = gl->api.GetUniformLocation(program, names[n]);
        if (at >= 0) gl->api.Uniform1i(at, (int)gl->first_binding + n);
    }
    gl->api.UseProgram((gl_name)before);
}

void vxs_gl_bind(const vxs_gl *gl)
{
    vxs_gl_words_bind(gl, &gl->words, 0);
    vxs_gl_words_bind(gl, &gl->rows, 1);
    vxs_gl_words_bind(gl, &gl->lists, 2);
}
