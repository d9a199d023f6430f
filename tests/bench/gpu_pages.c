/* Lookups in depth pages, and what it takes to mark and decode them; see gpu_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/gpu_bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/gl/vxs_gl_depths.h"

enum { BUDGET_BYTES = 32 << 20, NEW_PAGES = 64, UNIT = 12 };

/* A view of an asset with depth pages. */
typedef struct paged_view {
    vxs_gl              *shadows;
    vxs_gl_depth_pages  *pages;
    const gpu_view      *view;
    vxs_depth_pages_view marked;
    uint32_t             new_pages; /* 0: mark alone */
} paged_view;

static vxs_result mark(const paged_view *p)
{
    return vxs_gl_depth_pages_mark(p->pages, &p->marked, p->view->depths);
}

/* Mark alone; or mark twice, as marks are read a frame later, and decode pages into an empty atlas. */
static vxs_result mark_frame(gpu_bench *b, void *user)
{
    const paged_view *p = user;
    (void)b;
    vxs_gl_depth_pages_forget(p->pages);
    vxs_result r = mark(p);
    if (r != VXS_OK || !p->new_pages) return r;
    b->gl->Flush();
    r = mark(p);
    return vxs_gl_depth_pages_update(p->pages, p->new_pages) == UINT32_MAX ? VXS_E_GL : r;
}

/* Mark a view, at level 0 or at the level of its pixels, and decode all that it needs.   Returns how many pages find no room */
static uint32_t fill(gpu_bench *b, paged_view *p, int is_level_0)
{
    uint32_t missing = 0;
    vxs_gl_origin(p->shadows, p->view->eye_ws);
    p->marked = (vxs_depth_pages_view){.view = p->view->view}; /* positions are relative to the eye */
    if (!is_level_0) p->marked.px_width = (float)(2 * tan(0.5 * b->fov_degrees * M_PI / 180) / b->height_px);
    vxs_gl_depth_pages_forget(p->pages);
    for (int n = 0; n < 3; n++) {
        mark(p);
        b->gl->Flush();
        missing = vxs_gl_depth_pages_update(p->pages, UINT32_MAX);
    }
    return missing;
}

typedef enum page_use { LEVEL_0, LEVEL_0_ALONE, LEVEL_OF_PIXEL, PAGE_USES } page_use;

/* One filter, in all views. Answers of a pixel's level differ from those of the words. */
static vxs_result measure_filter(gpu_bench *b, paged_view *p, uint32_t side_px, gpu_filter filter, page_use use, run_context *m)
{
    static const char *const names[PAGE_USES] = {"", ", without words", " of a pixel's level"};
    const int                is_level_0       = use != LEVEL_OF_PIXEL;
    const char              *texts[VXS_GL_DEPTH_PAGES_TEXTS];
    char                    *body, line[160];
    GLuint                   program;
    vxs_gl_depth_pages_texts(p->pages, texts);
    snprintf(line, sizeof line, "float answer_of(ivec2 pixel, vec3 at, vec3 normal) { return vxs_paged_lit%s at, normal, %s); }\n",
             is_level_0 ? "(0u, 0u," : "_by(0u,", gpu_filter_texts[filter]);
    if (!(body = malloc(strlen(texts[0]) + strlen(texts[1]) + sizeof line)))
        return fail(m, VXS_E_MEMORY, "out of memory for a text");
    sprintf(body, "%s%s%s", texts[0], texts[1], line);
    vxs_result r = gpu_program(b, p->shadows, use == LEVEL_0_ALONE ? "#define VXS_PAGES_ALONE\n" : "", body, &program, m);
    free(body);
    for (size_t n = 0; n < b->view_count && r == VXS_OK; n++) {
        gpu_view    *v = &b->views[n];
        gpu_dispatch d = {p->shadows, v, program};
        char         name[80];
        p->view          = v;
        uint32_t missing = fill(b, p, is_level_0), held = vxs_gl_depth_pages_held(p->pages);
        snprintf(name, sizeof name, "%u pages%s%s", held, names[use], missing ? ", some missing" : "");
        gpu_row row = {.group         = gpu_filter_names[filter],
                       .name          = name,
                       .resolution_px = side_px,
                       .bytes         = BUDGET_BYTES,
                       .wanted        = use == LEVEL_0 || (use == LEVEL_0_ALONE && !missing) ? v->lit[filter] : NULL};
        gpu_use(b, p->shadows, program, v);
        vxs_gl_depth_pages_bind(p->pages);
        r = gpu_measure(b, v, &row, gpu_dispatch_frame, &d, m);
    }
    b->gl->UseProgram(0);
    b->gl->DeleteProgram(program);
    return r;
}

static vxs_result measure_marks(gpu_bench *b, paged_view *p, uint32_t side_px, run_context *m)
{
    static const uint32_t    new_pages[] = {0, NEW_PAGES};
    static const char *const names[]     = {"mark", "mark twice, decode 64 pages"};
    vxs_result               r           = VXS_OK;
    for (size_t n = 0; n < b->view_count; n++)
        for (int k = 0; k < 2 && r == VXS_OK; k++) {
            p->view = &b->views[n];
            fill(b, p, 0);
            p->new_pages = new_pages[k];
            r = gpu_measure(b, p->view, &(gpu_row){.group = "depth pages", .name = names[k], .resolution_px = side_px}, mark_frame,
                            p, m);
        }
    return r;
}

vxs_result gpu_measure_pages(gpu_bench *b, const vxs_asset *asset, run_context *m)
{
    uint32_t   side_px = 1u << vxs_asset_light(asset, 0)->light.levels;
    paged_view p       = {0};
    vxs_result r       = gpu_shadows(b, asset, VXS_GL_BUFFER, 0, &p.shadows, m);
    if (r == VXS_OK && (r = vxs_gl_depth_pages_create(
                            &p.pages, p.shadows, &(vxs_gl_depth_pages_desc){.budget_bytes = BUDGET_BYTES, .unit = UNIT})) != VXS_OK)
        r = fail(m, r, "no depth pages: %s", vxs_result_text(r));
    for (int f = 0; f < GPU_FILTERS && r == VXS_OK; f++)
        for (int use = 0; use < PAGE_USES && r == VXS_OK; use++)
            r = measure_filter(b, &p, side_px, (gpu_filter)f, (page_use)use, m);
    if (r == VXS_OK) r = measure_marks(b, &p, side_px, m);
    vxs_gl_depth_pages_destroy(p.pages);
    vxs_gl_destroy(p.shadows);
    return r;
}
