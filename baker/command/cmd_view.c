/* vxs view: a page that shows a scene in its baked light.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/options/bake_arguments.h"
#include "baker/command/process/process.h"
#include "baker/command/provenance_differences.h"
#include "baker/command/report/report.h"
#include "baker/command/view_page.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"

typedef struct view_command {
    bake_arguments bake;       /* the scene; and how it is baked, when there is no asset */
    const char    *asset_path; /* NULL: bake */
    const char    *output_path, *page_path, *bake_report_path;
    vxs_bytes      asset; /* owned */
    option         options[OPTIONS_MAX];
    command_line   line;
} view_command;

/* Whether an option is given that only a bake uses. */
static const char *option_of_bake(const bake_options *o)
{
    return o->light_names.count   ? "--light"
           : o->suns.count        ? "--sun"
           : o->resolutions.count ? "--resolution"
           : o->texels.count      ? "--texel"
           : o->region_given      ? "--region"
                                  : NULL;
}

/* Open the asset, and compare the scene with the one that it was baked from. */
static vxs_result read_asset(view_command *c, run_context *m)
{
    bake_options *o     = &c->bake.o;
    first_finding found = {0};
    vxs_parallel  lent  = parallel_lent(o->threads);
    vxs_read_desc desc  = {.metadata = 1, .parallel = &lent, .finding = keep_first_finding, .finding_user = &found};
    const char   *given = option_of_bake(o);
    vxs_asset    *asset = NULL;
    json_t       *made  = NULL;
    scene         s     = {0};
    vxs_result    r;
    if (given)
        return fail(m, VXS_E_ARGUMENT, "%s is an option of the bake, and '%s' is baked: expected one of them", given,
                    input_name(c->asset_path));
    r = asset_read_keeping(&asset, &c->asset, c->asset_path, &desc, m);
    if (r != VXS_OK) return asset_fail(c->asset_path, r, &found, "", m);
    r = provenance_read(&made, vxs_asset_contents(asset), m);
    if (r == VXS_OK && made) r = asset_scene_choice(made, &o->scene, m);
    if (r == VXS_OK) r = scene_load_gltf(&s, o->scene_path, &o->scene, m);
    if (r == VXS_OK && made)
        r = asset_check_scene(vxs_asset_contents(asset), made, c->asset_path, &s, o->scene_path, "its shadows may not fit", m);
    /* the choice borrows texts from `made`, and is not used again */
    scene_free(&s);
    json_decref(made);
    vxs_asset_close(asset);
    return r;
}

static vxs_result take_asset(void *user, const bake_options *o, const casters *c, vxs_bytes *file, run_context *m)
{
    vxs_bytes *taken = user;
    (void)o, (void)c, (void)m;
    *taken = *file;
    *file  = (vxs_bytes){0};
    return VXS_OK;
}

static vxs_result bake_asset(view_command *c, FILE *to, run_context *m)
{
    bake_options *o      = &c->bake.o;
    bake_report   report = {0};
    bake_observer taking = {take_asset, &c->asset};
    process_return_large();
    o->watch     = progress_watch(m);
    vxs_result r = bake_arguments_check(&c->bake, m);
    if (r == VXS_OK) r = bake(o, &taking, &report, m);
    progress_clear();
    if (r == VXS_OK && to) (m->verbose ? report_print : bake_summary_print)(to, o, &report);
    bake_report_free(&report);
    return r;
}

/* The warnings in the report of a bake; none without a path.   warnings  [out] an array, NULL on failure */
static vxs_result read_warnings(json_t **warnings, const char *report_path, run_context *m)
{
    json_t     *report  = NULL, *text;
    run_context of_file = {0};
    size_t      n;
    vxs_result  r = report_path ? json_read(&report, report_path, &of_file) : VXS_OK;
    *warnings     = NULL;
    if (r != VXS_OK) return fail(m, r, "--bake-report %s", of_file.error);
    if (report && !json_is_array(json_object_get(report, "warnings")))
        r = fail(m, VXS_E_READ, "--bake-report %s: expected what vxs bake --json writes, with a list as warnings", report_path);
    if (r == VXS_OK) *warnings = json_array();
    json_array_foreach(json_object_get(report, "warnings"), n, text) if (*warnings && json_is_string(text))
        json_append(warnings, json_incref(text));
    json_decref(report);
    return r == VXS_OK && !*warnings ? fail(m, VXS_E_MEMORY, "out of memory for the warnings of the page") : r;
}

static vxs_result write_page(view_command *c, const view_page *page, FILE *to, run_context *m)
{
    view_level level = {.scene_path    = c->bake.o.scene_path,
                        .asset_path    = c->asset_path,
                        .allow_outside = c->bake.o.scene.allow_outside,
                        .scene_name    = c->bake.o.scene.name,
                        .asset         = &c->asset};
    view_sizes sizes;
    vxs_result r = read_warnings(&level.warnings, c->bake_report_path, m);
    if (r == VXS_OK) r = view_page_write(c->output_path, page, &level, &sizes, m);
    json_decref(level.warnings);
    if (r != VXS_OK || !to) return r;
    char size[32], scene_size[32], asset_size[32], plain[PLAIN_BYTES];
    fprintf(to, "page         %s%s%s: scene %s, shadows %s\n",
            is_standard_output(c->output_path) ? "standard output" : plain_text(plain, c->output_path), sizes.page ? ", " : "",
            sizes.page ? size_text(size, sizes.page) : "", size_text(scene_size, sizes.scene),
            size_text(asset_size, c->asset.size_bytes));
    return VXS_OK;
}

static vxs_result run(void *command, run_context *m)
{
    view_command *c    = command;
    view_page     page = {0};
    FILE         *to   = report_stream(m, is_standard_output(c->output_path));
    vxs_result    r    = VXS_OK;
    if (is_read_once(c->bake.o.scene_path))
        r = fail(m, VXS_E_ARGUMENT, "SCENE %s is read twice, and a pipe only once: expected a file", c->bake.o.scene_path);
    if (r == VXS_OK && c->bake_report_path && !c->asset_path)
        r = fail(m, VXS_E_ARGUMENT, "--bake-report goes with FILE.vxs: without it the page has the warnings of its own bake");
    if (r == VXS_OK) r = view_page_read(&page, c->page_path, m);
    if (r == VXS_OK) r = c->asset_path ? read_asset(c, m) : bake_asset(c, to, m);
    if (r == VXS_OK) r = write_page(c, &page, to, m);
    view_page_free(&page);
    free(c->asset.data);
    return r;
}

/* The table: rows of the bake, by their names, and rows of this command. */
static void take_rows(view_command *c)
{
    static const char *const of_bake[] = {"--light",   "--sun",     "--resolution", "--texel", "--region",        "--scene",
                                          "--exclude", "--include", "--skinned",    "--blend", "--allow-outside", "--threads"};
    const option             first[]   = {
                      {"FILE.vxs", OPTION_INPUT, &c->asset_path, FILE_ASSET, OPERAND_OPTIONAL, NULL, NULL,
                       "what vxs bake wrote for the scene; without it, the scene is baked", NULL},
                      {"-o", OPTION_OUTPUT, &c->output_path, 1, 0, ".html|.htm", "PAGE.html", "the page, one file; - is standard output", NULL},
                      {"--bake-report", OPTION_INPUT, &c->bake_report_path, FILE_JSON, 0, NULL, "FILE.json",
                       "what vxs bake --json wrote for FILE.vxs: the page shows its warnings", NULL},
                      {"--page", OPTION_INPUT, &c->page_path, FILE_UNKNOWN, 0, NULL, "VIEW.html",
                       "the template of the page (default view.html of the installation, or of make web)", NULL},
    };
    option *at = c->options;
    *at++      = c->bake.options[0]; /* SCENE */
    for (size_t n = 0; n < sizeof first / sizeof *first; n++) *at++ = first[n];
    for (size_t n = 0; n < sizeof of_bake / sizeof *of_bake; n++)
        for (const option *o = c->bake.options; o < c->bake.options + c->bake.line.option_count; o++)
            if (o->name && !strcmp(o->name, of_bake[n])) *at++ = *o;
    c->line = (command_line){"view", "SCENE [FILE.vxs] -o PAGE.html [options]",
                             "Write a page that shows a scene in its baked light. It is one file, which a browser opens without a "
                             "server or a network.",
                             c->options, (size_t)(at - c->options)};
}

int cmd_view(int argc, char **argv)
{
    view_command c = {.asset_path = NULL};
    bake_arguments_init(&c.bake, "view", "", "", 0);
    take_rows(&c);
    return command_run(&c.line, argc, argv, run, &c);
}
