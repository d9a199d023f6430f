/* The page of vxs view; see view_page.h.
 *
 * Where the template has its mark, these elements are written:
 *
 *     <script type="text/plain" data-vxs="0">base64</script>    file 0, at most 3 MiB of it; more elements for the rest
 *     ...                                                       files 1, 2, ... in the same way
 *     <script type="application/json" id="vxs-level">{...}</script>
 *
 * {"vxs", "scene": {"name", "scene"}, "asset": {"name"}, "files": [{"uri", "size_bytes"}], "warnings": [text]}
 *
 * File 0 is the scene, its uri is null; then the scene's buffers and images; the last file is the asset. scene.scene chooses the
 * glTF scene by name or index, or is null. Elements are small, so that a browser can decode and release them one by one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/view_page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "baker/base/system.h"
#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/command/report/plan_text.h"
#include "baker/files/html_data.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
#include "baker/files/run_files.h"
#include "baker/scene/scene.h"

static const char mark[] = "<!--vxs:level:1-->"; /* the number counts versions of the elements above */

enum { TEMPLATE_MAX_BYTES = 64 << 20, ELEMENT_BYTES = 3 << 20 };

/* the template ----------------------------------------------------------------------------------------------------------------- */

/* The place of the template: PATH_MAX bytes into path. Returns 0 when there is none. */
static int find_template(char path[PATH_MAX])
{
    static const char *const beside[] = {"../share/vxs/view.html", "../web/view.html"};
    char                     program[PATH_MAX], folder[PATH_MAX];
    const char              *data = getenv("VXS_DATA");
    if (data && snprintf(path, PATH_MAX, "%s/view.html", data) < PATH_MAX && !access(path, F_OK)) return 1;
    if (!system_program(program, sizeof program) || !path_split(program, folder)) return 0;
    for (size_t n = 0; n < sizeof beside / sizeof *beside; n++)
        if (snprintf(path, PATH_MAX, "%s%s", folder, beside[n]) < PATH_MAX && !access(path, F_OK)) return 1;
    return 0;
}

vxs_result view_page_read(view_page *page, const char *path, run_context *m)
{
    char found[PATH_MAX];
    *page = (view_page){0};
    if (!path && !find_template(found))
        return fail(m, VXS_E_READ,
                    "the page's template, view.html, is not there: 'make web' builds it, or --page FILE.html names its place");
    if (!path) path = found;
    vxs_result     r  = input_read(&page->bytes, &page->size_bytes, path, TEMPLATE_MAX_BYTES, NULL, m);
    const uint8_t *at = r == VXS_OK ? memmem(page->bytes, page->size_bytes, mark, strlen(mark)) : NULL;
    if (r != VXS_OK) return r;
    if (!at)
        return fail(m, VXS_E_READ, "'%s' is no template of this version: expected view.html, which 'make web' builds, with %s",
                    input_name(path), mark);
    page->head_bytes = (size_t)(at - page->bytes);
    page->tail_begin = page->head_bytes + strlen(mark);
    return VXS_OK;
}

void view_page_free(view_page *page)
{
    free(page->bytes);
    *page = (view_page){0};
}

/* the level -------------------------------------------------------------------------------------------------------------------- */

typedef struct page_writer {
    FILE       *to;
    json_t     *files; /* NULL when out of memory */
    size_t      count;
    view_sizes *sizes;
} page_writer;

static void write_file(page_writer *w, const char *uri, const uint8_t *bytes, size_t size_bytes)
{
    json_t *file  = json_object();
    size_t  index = w->count++;
    json_set(&file, "uri", uri ? json_text(uri) : json_null());
    json_set(&file, "size_bytes", json_integer((json_int_t)size_bytes));
    json_append(&w->files, file);
    for (size_t at = 0; at < size_bytes; at += ELEMENT_BYTES) {
        size_t count = size_bytes - at < ELEMENT_BYTES ? size_bytes - at : ELEMENT_BYTES;
        fprintf(w->to, "<script type=\"text/plain\" data-vxs=\"%zu\">", index);
        base64_print(w->to, bytes + at, count);
        fputs("</script>\n", w->to);
    }
}

static vxs_result write_scene_file(void *user, const char *uri, const uint8_t *bytes, size_t size_bytes, run_context *m)
{
    page_writer *w = user;
    (void)m;
    w->sizes->scene += size_bytes;
    write_file(w, uri, bytes, size_bytes);
    return VXS_OK;
}

/* The name of a file without its folder; null for standard input. */
static json_t *name_json(const char *path)
{
    const char *slash = path ? strrchr(path, '/') : NULL;
    return path && !is_standard_input(path) ? json_text(slash ? slash + 1 : path) : json_null();
}

/* Takes `files`. Returns VXS_OK or VXS_E_MEMORY. */
static vxs_result write_texts(FILE *to, const view_level *level, json_t *files, run_context *m)
{
    json_t *root = json_object(), *from = json_object(), *asset = json_object(), *warnings = json_copy(level->warnings);
    json_t *ours = report_warnings_json(m); /* now, when the files of the scene are read */
    if (json_array_extend(warnings, ours)) json_decref(warnings), warnings = NULL;
    json_decref(ours);
    json_set(&from, "name", name_json(level->scene_path));
    json_set(&from, "scene", level->scene_name ? json_text(level->scene_name) : json_null());
    json_set(&asset, "name", name_json(level->asset_path));
    json_set(&root, "vxs", json_string(VXS_VERSION));
    json_set(&root, "scene", from);
    json_set(&root, "asset", asset);
    json_set(&root, "files", files);
    json_set(&root, "warnings", warnings);
    char *text = root ? json_print(root, JSON_COMPACT) : NULL;
    if (text) {
        fputs("<script type=\"application/json\" id=\"vxs-level\">", to);
        html_print_json(to, text);
        fputs("</script>\n", to);
    }
    json_decref(root);
    free(text);
    return text ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the texts of the page");
}

vxs_result view_page_write(const char *path, const view_page *page, const view_level *level, view_sizes *sizes, run_context *m)
{
    output_file out = {0};
    vxs_result  r   = output_file_open(&out, path, m);
    if (r != VXS_OK) return r;
    page_writer w = {out.stream, json_array(), 0, sizes};
    *sizes        = (view_sizes){0};

    fwrite(page->bytes, 1, page->head_bytes, w.to);
    r = scene_visit_files_gltf(level->scene_path, level->allow_outside, write_scene_file, &w, m);
    if (r != VXS_OK) json_decref(w.files);
    if (r != VXS_OK) goto done;
    write_file(&w, NULL, level->asset->data, level->asset->size_bytes);
    if ((r = write_texts(w.to, level, w.files, m)) != VXS_OK) goto done;
    fwrite(page->bytes + page->tail_begin, 1, page->size_bytes - page->tail_begin, w.to);
    off_t end   = is_standard_output(path) ? -1 : ftello(w.to);
    sizes->page = end > 0 ? (uint64_t)end : 0;
    r           = output_file_commit(&out, m);
done:
    output_file_abort(&out);
    return r;
}
