/* Depth pages: which pages are in the atlas, and the passes that mark and decode them; see vxs_gl_depths.h and depth_pages.glsl.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "gl_state.h"
#include "vxs_desc.h"
#include "vxs_gl_depths.h"

enum {
    PAGE_PX       = 128,
    PAGES_AT_ONCE = 16, /* decoded by one dispatch */
    LISTED        = 4096,
    WINDOW        = 6, /* the page table of a level has at most 2^WINDOW pages a side */
    HEAD_WORDS    = 8,
    INFO_WORDS    = 4,
    BOUNDS_WORDS  = 2 * (PAGE_PX / 8) * (PAGE_PX / 8),
    MARK_WORDS    = 4, /* of a listed page; and before the first one */
    JOB_WORDS     = 8,
};

/* A page of the atlas. */
typedef struct atlas_page {
    uint32_t word;      /* of the page table, that names it; 0: it is free */
    uint32_t last_used; /* frame of the last marks that listed it */
} atlas_page;

/* A listed page, as the shader writes it. */
typedef struct mark {
    uint32_t light, map_level; /* the second: map | level << 8 | is_partial */
    uint32_t x_y, word;        /* x | y << 16; word of the page table */
} mark;
static const uint32_t is_partial = 0x80000000; /* the page is in the atlas, but lacked words */
_Static_assert(sizeof(mark) == MARK_WORDS * sizeof(uint32_t), "read as words");

typedef enum page_pass { PASS_MARK, PASS_FILL, PASS_PACK, PASSES } page_pass;

struct vxs_gl_depth_pages {
    vxs_gl     *gl;
    uint32_t    binding, unit, border_px, stride_px, columns, room, held;
    gl_name     atlas, programs[PASSES]; /* programs: 0 before first use */
    gl_words    table, fill, marks[2];
    uint32_t    marked[2]; /* frame of unread marks; 0: none */
    uint32_t    turn, frame;
    uint32_t    first_entry, entry_count; /* of the page table: its first word behind the lights, and number of words from there */
    uint32_t   *entries;                  /* [entry_count] as on the GPU */
    atlas_page *pages;                    /* [room] */
    mark       *listed;                   /* [LISTED] */
    uint32_t    jobs[PAGES_AT_ONCE * JOB_WORDS], job_count;
    char        head[512], fill_head[64];
};

/* sizes ------------------------------------------------------------------------------------------------------------------------ */

/* Words of the tables of a map: a window for each level. */
static uint32_t entries_of_map(uint32_t levels)
{
    uint32_t count = 0;
    for (int32_t level = levels > 7 ? (int32_t)levels - 7 : 0; level >= 0; level--)
        count += 1u << 2 * (level < WINDOW ? level : WINDOW);
    return count;
}

static uint32_t entries_of_light(const vxs_light *light)
{
    return vxs_map_count(light) * entries_of_map(light->levels);
}

static uint64_t bytes_of_page(uint32_t stride_px)
{
    return 2u * stride_px * stride_px + (INFO_WORDS + BOUNDS_WORDS) * sizeof(uint32_t);
}

static uint32_t fill_words(uint32_t stride_px)
{
    return PAGES_AT_ONCE * (JOB_WORDS + stride_px * stride_px + stride_px * stride_px / 2);
}

/* As many columns of pages as the budget, the largest texture and the page table allow. */
static void choose_sizes(vxs_gl_depth_pages *p, const vxs_gl_depth_pages_desc *desc)
{
    int32_t width = desc->filter.width_px < 1 ? 1 : desc->filter.width_px > VXS_FILTER_MAX ? VXS_FILTER_MAX : desc->filter.width_px;
    int     most  = 0;
    p->border_px  = (uint32_t)(width + (desc->filter.is_smooth != 0)) / 2;
    p->border_px += p->border_px & 1; /* rows of whole words */
    p->stride_px = PAGE_PX + 2 * p->border_px;
    p->gl->api.GetIntegerv(GL_MOST_TEXTURE_SIZE, &most);
    uint64_t budget = desc->budget_bytes ? desc->budget_bytes : 32 << 20, fixed = 4ull * fill_words(p->stride_px);
    while ((p->columns + 1) * p->stride_px <= (uint32_t)most && p->columns < 255 &&
           fixed + (uint64_t)(p->columns + 1) * (p->columns + 1) * bytes_of_page(p->stride_px) <= budget)
        p->columns++;
    p->room = p->columns * p->columns;
}

static void write_head(vxs_gl_depth_pages *p)
{
    snprintf(p->head, sizeof p->head,
             "#define VXS_PAGES_AT %u\n#define VXS_PAGES_AT_WORK %u\n#define VXS_PAGES_UNIT %u\n#define VXS_PAGES_BORDER "
             "%uu\n#define VXS_PAGES_WIDEST %u\n"
             "#define VXS_PAGES_STRIDE %uu\n#define VXS_PAGES_COLUMNS %uu\n#define VXS_PAGES_ROOM %uu\n#define VXS_PAGES_PX %u.0\n"
             "#define VXS_PAGES_AT_ONCE %uu\n#define VXS_PAGES_LISTED %uu\n",
             p->binding, p->binding + 1, p->unit, p->border_px, 2 * p->border_px + 1, p->stride_px, p->columns, p->room,
             p->columns * p->stride_px, PAGES_AT_ONCE, LISTED);
}

/* creation --------------------------------------------------------------------------------------------------------------------- */

/* Write zeros: buffers begin with any words. */
static int clear_words(const vxs_gl *gl, const gl_words *w)
{
    uint32_t *zeros = vxs_gl_alloc(gl, w->count, sizeof *zeros);
    if (!zeros) return 0;
    memset(zeros, 0, w->count * sizeof *zeros);
    vxs_gl_words_write(gl, w, zeros, 0, w->count);
    vxs_gl_free(gl, zeros, w->count, sizeof *zeros);
    return 1;
}

/* Upload for each light the word where its tables start. */
static int put_lights(vxs_gl_depth_pages *p)
{
    const vxs_gl *gl     = p->gl;
    uint32_t     *starts = vxs_gl_alloc(gl, gl->light_count, sizeof *starts), at = p->first_entry;
    if (!starts) return 0;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        starts[n] = at;
        at += entries_of_light(gl->lights[n].light);
    }
    vxs_gl_words_write(gl, &p->table, starts, p->first_entry - gl->light_count, gl->light_count);
    vxs_gl_free(gl, starts, gl->light_count, sizeof *starts);
    return 1;
}

static vxs_result make(vxs_gl_depth_pages *p)
{
    vxs_gl  *gl      = p->gl;
    uint64_t entries = 0, first = HEAD_WORDS + (uint64_t)p->room * (INFO_WORDS + BOUNDS_WORDS) + gl->light_count;
    for (uint32_t n = 0; n < gl->light_count; n++) entries += entries_of_light(gl->lights[n].light);
    if (first + entries > UINT32_MAX / sizeof(uint32_t)) return VXS_E_MEMORY;
    p->first_entry = (uint32_t)first;
    p->entry_count = (uint32_t)entries;
    p->entries     = vxs_gl_alloc(gl, entries, sizeof *p->entries);
    p->pages       = vxs_gl_alloc(gl, p->room, sizeof *p->pages);
    p->listed      = vxs_gl_alloc(gl, LISTED, sizeof *p->listed);
    if (!p->entries || !p->pages || !p->listed) return VXS_E_MEMORY;
    memset(p->entries, 0, entries * sizeof *p->entries);
    memset(p->pages, 0, p->room * sizeof *p->pages);

    if (!(p->atlas = vxs_gl_depths_make(gl, p->columns * p->stride_px, 16))) return VXS_E_MEMORY;
    if (!vxs_gl_words_make(gl, &p->table, first + entries, 1, 0) || !clear_words(gl, &p->table) || !put_lights(p))
        return VXS_E_MEMORY;
    if (!vxs_gl_words_make(gl, &p->fill, fill_words(p->stride_px), 1, 0)) return VXS_E_MEMORY;
    for (int n = 0; n < 2; n++)
        if (!vxs_gl_words_make(gl, &p->marks[n], MARK_WORDS * (1 + LISTED) + entries, 1, 0) || !clear_words(gl, &p->marks[n]))
            return VXS_E_MEMORY;
    write_head(p);
    return VXS_OK;
}

vxs_result vxs_gl_depth_pages_create(vxs_gl_depth_pages **out, vxs_gl *gl, const vxs_gl_depth_pages_desc *desc)
{
    vxs_gl_depth_pages_desc known = {0};
    const size_t            first = offsetof(vxs_gl_depth_pages_desc, unit) + sizeof known.unit;
    *out                          = NULL;
    if (vxs_desc_take(&known, sizeof known, first, desc) != VXS_OK) return VXS_E_ARGUMENT;
    if (!known.filter.width_px) known.filter = vxs_smooth(9);
    if (!vxs_gl_can_compute(gl)) return vxs_gl_fail(gl, VXS_E_GL, "depth pages: expected storage buffers and compute shaders");
    vxs_gl_depth_pages *p = vxs_gl_alloc(gl, 1, sizeof *p);
    if (!p) return VXS_E_MEMORY;
    *p = (vxs_gl_depth_pages){.gl = gl, .binding = known.binding ? known.binding : gl->first_binding + 3, .unit = known.unit};
    choose_sizes(p, &known);
    vxs_result r =
        p->room ? make(p) : vxs_gl_fail(gl, VXS_E_ARGUMENT, "depth pages: budget_bytes holds no page: leave it 0, for 32 MiB");
    if (r == VXS_OK)
        *out = p;
    else
        vxs_gl_depth_pages_destroy(p);
    return r;
}

void vxs_gl_depth_pages_destroy(vxs_gl_depth_pages *p)
{
    if (!p) return;
    const vxs_gl *gl = p->gl;
    if (p->atlas) gl->api.DeleteTextures(1, &p->atlas);
    for (int n = 0; n < PASSES; n++)
        if (p->programs[n]) gl->api.DeleteProgram(p->programs[n]);
    vxs_gl_words_delete(gl, &p->table);
    vxs_gl_words_delete(gl, &p->fill);
    vxs_gl_words_delete(gl, &p->marks[0]);
    vxs_gl_words_delete(gl, &p->marks[1]);
    vxs_gl_free(gl, p->entries, p->entry_count, sizeof *p->entries);
    vxs_gl_free(gl, p->pages, p->room, sizeof *p->pages);
    vxs_gl_free(gl, p->listed, LISTED, sizeof *p->listed);
    vxs_gl_free(gl, p, 1, sizeof *p);
}

void vxs_gl_depth_pages_texts(const vxs_gl_depth_pages *p, const char *texts[VXS_GL_DEPTH_PAGES_TEXTS])
{
    texts[0] = p->head;
    texts[1] = vxs_gl_text_depth_pages_glsl;
}

void vxs_gl_depth_pages_bind(const vxs_gl_depth_pages *p)
{
    const gl_api *api = &p->gl->api;
    int           active;
    api->BindBufferBase(GL_TARGET_STORAGE_BUFFER, p->binding, p->table.name);
    api->GetIntegerv(GL_IS_ACTIVE_TEXTURE, &active);
    api->ActiveTexture(GL_UNIT_0 + p->unit);
    api->BindTexture(GL_TARGET_TEXTURE_2D, p->atlas);
    api->BindSampler(p->unit, 0);
    api->ActiveTexture((gl_enum)active);
}

/* passes ----------------------------------------------------------------------------------------------------------------------- */

/* Compile the program of a pass at its first use. Returns 0 on failure. */
static gl_name program_of(vxs_gl_depth_pages *p, page_pass pass)
{
    static const char *const bodies[PASSES]     = {[PASS_MARK] = vxs_gl_text_depth_pages_mark_glsl,
                                                   [PASS_FILL] = vxs_gl_text_depth_pages_fill_glsl,
                                                   [PASS_PACK] = vxs_gl_text_depth_pages_pack_glsl};
    static const char *const helpers[PASSES][2] = {[PASS_MARK] = {vxs_gl_text_view_glsl, ""},
                                                   [PASS_FILL] = {vxs_gl_text_vxs_depths_h, vxs_gl_text_first_shadow_glsl},
                                                   [PASS_PACK] = {"", ""}};
    static const char        head[]             = "#define VXS_PAGES_FILL\n#define VXS_PAGES_ACCESS restrict\n";
    const char *const        texts[] = {p->head, vxs_gl_text_depth_pages_glsl, helpers[pass][0], helpers[pass][1], bodies[pass]};
    if (!p->programs[pass]) p->programs[pass] = vxs_gl_compute(p->gl, head, texts, 5);
    return p->programs[pass];
}

vxs_result vxs_gl_depth_pages_mark(vxs_gl_depth_pages *p, const vxs_depth_pages_view *view, unsigned depth_texture)
{
    const vxs_gl   *gl      = p->gl;
    const gl_api   *api     = &gl->api;
    const vxs_view *v       = &view->view;
    gl_name         program = program_of(p, PASS_MARK);
    uint32_t        columns = (v->width_px + VXS_TILE_PX - 1) / VXS_TILE_PX, rows = (v->height_px + VXS_TILE_PX - 1) / VXS_TILE_PX;
    float           head[4] = {view->eye[0], view->eye[1], view->eye[2], view->px_width};
    uint32_t        words[4];
    if (!program) return VXS_E_GL;
    memcpy(words, head, sizeof words);
    vxs_gl_words_write(gl, &p->table, words, 0, 4);
    p->frame++;
    p->turn            = 1 - p->turn;
    p->marked[p->turn] = p->frame;
    /* marks of another frame differ; a frame of 0 would be that of no mark */
    vxs_gl_words_write(gl, &p->marks[p->turn], (const uint32_t[2]){0, p->frame % 65535 + 1}, 0, 2);
    vxs_gl_bind(gl);
    vxs_gl_depth_pages_bind(p);
    vxs_gl_words_bind_at(gl, &p->marks[p->turn], p->binding + 1);
    gl_pass pass = vxs_gl_begin_pass(gl, program, depth_texture);
    vxs_gl_set_view(gl, program, v);
    api->Uniform1i(api->GetUniformLocation(program, "vxs_by_lists"), view->by_lists != 0);
    api->DispatchCompute(columns, rows, 1);
    api->MemoryBarrier(GL_BARRIER_BUFFER_UPDATE | GL_BARRIER_SHADER_STORAGE);
    vxs_gl_end_pass(gl, &pass);
    return VXS_OK;
}

/* Decode the pages of all jobs, and name them in the page table. */
static int run_jobs(vxs_gl_depth_pages *p)
{
    const vxs_gl *gl   = p->gl;
    const gl_api *api  = &gl->api;
    gl_name       fill = program_of(p, PASS_FILL), pack = program_of(p, PASS_PACK);
    uint32_t      groups = (p->stride_px + 7) / 8, count = p->job_count;
    uint32_t first_px = 4 * PAGES_AT_ONCE * (JOB_WORDS + p->stride_px * p->stride_px), page_bytes = 2 * p->stride_px * p->stride_px;
    p->job_count = 0;
    if (!fill || !pack) return 0;
    vxs_gl_words_write(gl, &p->fill, p->jobs, 0, count * JOB_WORDS);
    for (uint32_t n = 0; n < count; n++)
        vxs_gl_words_write(gl, &p->table, (const uint32_t[INFO_WORDS]){UINT32_MAX, 0, 0, 0},
                           HEAD_WORDS + INFO_WORDS * p->jobs[JOB_WORDS * n + 5], INFO_WORDS);
    vxs_gl_bind(gl);
    vxs_gl_depth_pages_bind(p);
    vxs_gl_words_bind_at(gl, &p->fill, p->binding + 1);
    gl_pass pass = vxs_gl_begin_pass(gl, fill, 0);
    api->DispatchCompute(groups, groups, count);
    api->MemoryBarrier(GL_BARRIER_SHADER_STORAGE);
    api->UseProgram(pack);
    api->DispatchCompute(groups, groups, count);
    api->MemoryBarrier(GL_BARRIER_SHADER_STORAGE | GL_BARRIER_PIXEL_BUFFER | GL_BARRIER_BUFFER_UPDATE);
    vxs_gl_end_pass(gl, &pass);
    for (uint32_t n = 0; n < count; n++) {
        uint32_t     slot = p->jobs[JOB_WORDS * n + 5], side = p->stride_px, word = p->pages[slot].word;
        gl_rectangle to = {(int)(slot % p->columns * side), (int)(slot / p->columns * side), (int)side, (int)side};
        vxs_gl_depths_write(gl, p->atlas, 16, to, p->fill.name, (const char *)NULL + first_px + (size_t)n * page_bytes);
        vxs_gl_words_write(gl, &p->table, &p->entries[word - p->first_entry], word, 1);
    }
    return 1;
}

/* the atlas -------------------------------------------------------------------------------------------------------------------- */

/* What the page table has for a listed page that is in the atlas, but for the number of the page there. */
static uint32_t tag_of(const mark *m)
{
    return (m->x_y & 0xffff) >> WINDOW << 16 | m->x_y >> (16 + WINDOW) << 21;
}

/* Returns its page of the atlas, or room: it is not there. */
static uint32_t slot_of(const vxs_gl_depth_pages *p, const mark *m)
{
    uint32_t entry = p->entries[m->word - p->first_entry];
    return entry && entry >> 16 == tag_of(m) >> 16 ? (entry & 0xffff) - 1 : p->room;
}

/* Take a page out of the atlas. */
static void drop(vxs_gl_depth_pages *p, uint32_t slot)
{
    uint32_t word = p->pages[slot].word;
    if (!word) return;
    p->entries[word - p->first_entry] = 0;
    vxs_gl_words_write(p->gl, &p->table, (const uint32_t[1]){0}, word, 1);
    p->pages[slot] = (atlas_page){0};
    p->held--;
}

/* A page of the atlas that is free, or that no view has needed for longest; room: the marks of `frame` need all of them. */
static uint32_t room_for(const vxs_gl_depth_pages *p, uint32_t frame)
{
    uint32_t found = p->room, age = 0;
    for (uint32_t n = 0; n < p->room; n++) {
        if (!p->pages[n].word) return n;
        if (frame - p->pages[n].last_used > age) {
            age   = frame - p->pages[n].last_used;
            found = n;
        }
    }
    return found;
}

/* Queue a listed page to be decoded. Returns 0 when there is no room, when its word of the page table names another page that is
 * needed, or when a shader does not compile. */
static int add_job(vxs_gl_depth_pages *p, const mark *m, uint32_t frame)
{
    uint32_t slot = slot_of(p, m), *entry = &p->entries[m->word - p->first_entry];
    if (slot == p->room) {
        slot = *entry ? (*entry & 0xffff) - 1 : room_for(p, frame);
        if (slot == p->room || (p->pages[slot].word && p->pages[slot].last_used == frame)) return 0;
        drop(p, slot);
        p->held++;
    }
    *entry                        = (slot + 1) | tag_of(m);
    p->pages[slot]                = (atlas_page){m->word, frame};
    const uint32_t job[JOB_WORDS] = {m->light, m->map_level & 0xff, m->map_level >> 8 & 0x7f, m->x_y & 0xffff, m->x_y >> 16, slot};
    memcpy(p->jobs + JOB_WORDS * p->job_count++, job, sizeof job);
    return p->job_count < PAGES_AT_ONCE || run_jobs(p);
}

/* Read the marks of a frame. Returns how many pages are listed. */
static uint32_t read_marks(vxs_gl_depth_pages *p, const gl_words *marks, uint32_t *left_out)
{
    const uint32_t *words = vxs_gl_words_map(p->gl, marks, MARK_WORDS * (1 + LISTED));
    if (!words) return 0;
    uint32_t count = words[0] < LISTED ? words[0] : LISTED, known = 0;
    *left_out = words[0] - count;
    for (uint32_t n = 0; n < count; n++) {
        mark m;
        memcpy(&m, words + MARK_WORDS * (1 + n), sizeof m);
        if (m.word - p->first_entry < p->entry_count && m.light < p->gl->light_count) p->listed[known++] = m;
    }
    vxs_gl_words_unmap(p->gl);
    return known;
}

uint32_t vxs_gl_depth_pages_update(vxs_gl_depth_pages *p, uint32_t max_pages)
{
    uint32_t before = 1 - p->turn, frame = p->marked[before], missing = 0, decoded = 0;
    if (!frame) return 0;
    p->marked[before] = 0;
    uint32_t count    = read_marks(p, &p->marks[before], &missing);
    for (uint32_t n = 0; n < count; n++) {
        uint32_t slot = slot_of(p, &p->listed[n]);
        if (slot < p->room) p->pages[slot].last_used = frame;
    }
    /* new pages first, then those that lacked words */
    for (uint32_t partial = 0; partial < 2; partial++)
        for (uint32_t n = 0; n < count; n++) {
            const mark *m        = &p->listed[n];
            uint32_t    is_there = slot_of(p, m) < p->room;
            if (is_there != partial || (is_there && !(m->map_level & is_partial))) continue;
            if (decoded < max_pages && add_job(p, m, frame))
                decoded++;
            else
                missing++;
        }
    if (p->job_count && !run_jobs(p)) return UINT32_MAX;
    return missing;
}

void vxs_gl_depth_pages_forget(vxs_gl_depth_pages *p)
{
    for (uint32_t n = 0; n < p->room; n++) drop(p, n);
    p->marked[0] = p->marked[1] = 0;
}

uint32_t vxs_gl_depth_pages_room(const vxs_gl_depth_pages *p)
{
    return p->room;
}

uint32_t vxs_gl_depth_pages_held(const vxs_gl_depth_pages *p)
{
    return p->held;
}
