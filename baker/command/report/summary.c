/* A bake or its plan in about five lines; see report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/report/report.h"

#include <math.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/command/report/plan_text.h"
#include "baker/files/input_file.h"

/* "sun, light and 12 more": as many names as fit into a line, at least one. */
typedef struct name_list {
    char   text[VXS_LIGHT_NAME_BYTES + 48];
    size_t count, shown;
} name_list;

enum { NAMES_ROOM = 28 };

static void add_name(name_list *l, const char *name)
{
    size_t used = strlen(l->text);
    if (!l->count || (l->shown == l->count && used + strlen(name) <= NAMES_ROOM)) {
        snprintf(l->text + used, sizeof l->text - used, "%s%s", used ? ", " : "", name);
        l->shown++;
    }
    l->count++;
}

static void print_names(FILE *to, name_list *l)
{
    fputs(one_line(l->text), to);
    if (l->count > l->shown) fprintf(to, " and %zu more", l->count - l->shown);
}

static void print_scene(FILE *to, const bake_options *o, const bake_report *r)
{
    const casters *c     = &r->casters;
    double         share = c->triangle_count ? 100 * (double)c->solid_triangle_count / (double)casters_whole_count(c) : 0;
    char           plain[PLAIN_BYTES];
    fprintf(to, "scene        %s: %zu triangles, %.3g %% of them in solids\n", plain_text(plain, input_name(o->scene_path)),
            casters_whole_count(c), share);
    if (r->capsule_count) fprintf(to, "smoke        %u capsules of points and lines\n", r->capsule_count);
}

/* The lights that are baked, and the texels of their maps. */
static void print_lights(FILE *to, const bake_plan *plan)
{
    name_list         names = {0};
    const plan_light *one   = NULL;
    uint32_t          least = 32, most = 0;
    char              texels[TEXELS_BYTES];
    for (const plan_light *l = plan->lights; l < plan->lights + plan->light_count; l++) {
        if (l->left_out) continue;
        one = l;
        add_name(&names, l->name);
        if (l->light.levels < least) least = l->light.levels;
        if (l->light.levels > most) most = l->light.levels;
    }
    fprintf(to, names.count == 1 ? "light        " : "lights       %zu: ", names.count);
    print_names(to, &names);
    if (names.count == 1)
        fprintf(to, "; %u x %u texels%s of %s\n", 1u << most, 1u << most, one->map_count > 1 ? ", six maps," : "",
                texels_text(texels, &one->texels, 3));
    else if (least == most)
        fprintf(to, "; %u x %u texels each\n", 1u << most, 1u << most);
    else
        fprintf(to, "; %u to %u texels a side\n", 1u << least, 1u << most);
}

/* A line for each reason. */
static void print_left_out(FILE *to, const bake_report *r)
{
    report_print_excluded(to, r, "left out");
    for (size_t n = 0; n < r->left_out_count; n++) {
        name_list   names    = {0};
        const char *why      = r->left_out[n].why;
        int         is_first = 1;
        for (size_t before = 0; before < n && is_first; before++) is_first = strcmp(r->left_out[before].why, why) != 0;
        for (size_t k = n; k < r->left_out_count && is_first; k++)
            if (!strcmp(r->left_out[k].why, why)) add_name(&names, r->left_out[k].name);
        if (!is_first) continue;
        fprintf(to, "left out     ");
        print_names(to, &names);
        fprintf(to, ": %s\n", why);
    }
}

/* How much of the file is smoke. */
static void print_smoke(FILE *to, const bake_options *o, const bake_report *r)
{
    smoke_counts sum    = {0};
    uint32_t     lights = 0;
    char         size[32];
    for (uint32_t n = 0; n < r->light_count; n++) {
        const smoke_counts *s = &r->lights[n].smoke;
        lights += s->curves > 0;
        sum.curves += s->curves;
        sum.nodes += s->nodes;
        sum.stored_bytes += s->stored_bytes;
        sum.largest_error   = fmax(sum.largest_error, s->largest_error);
        sum.lookups.rms     = fmax(sum.lookups.rms, s->lookups.rms);
        sum.lookups.largest = fmax(sum.lookups.largest, s->lookups.largest);
    }
    if (!bakes_smoke(o)) return;
    fprintf(to, "smoke        ");
    if (!lights)
        fprintf(to, "it dims no light: the file has none\n");
    else
        fprintf(to,
                "of %u light%s: %zu curves of %.1f nodes, within %.2g of their own rays; lookups between rays: RMS error %.2g, "
                "%.2g at most; %s of the file\n",
                lights, lights == 1 ? "" : "s", sum.curves, (double)sum.nodes / (double)sum.curves, sum.largest_error,
                sum.lookups.rms, sum.lookups.largest, size_text(size, sum.stored_bytes));
}

void squares_print(FILE *to, const bake_options *o, const bake_report *r)
{
    square_counts squares = report_squares(r);
    if (!o->resume_path) return;
    fprintf(to, "squares      %llu of %llu made, %llu found in %s\n", (unsigned long long)squares.made,
            (unsigned long long)squares.all, (unsigned long long)(squares.all - squares.made), o->resume_path);
}

void bake_summary_print(FILE *to, const bake_options *o, const bake_report *r)
{
    print_scene(to, o, r);
    print_lights(to, r->plan);
    print_left_out(to, r);
    squares_print(to, o, r);

    /* how many times larger plain depth maps of 16 bits would be: "0.046", "9.5", "1748" */
    char   size[32], plain[PLAIN_BYTES];
    double maps = 0;
    for (uint32_t n = 0; n < r->light_count; n++) maps += light_depth16_bytes(&r->lights[n]);
    double ratio = maps / (double)r->file_bytes;
    fprintf(to, "file         %s: %s; depth maps are ",
            !o->output_path               ? "baked shadows"
            : strcmp(o->output_path, "-") ? plain_text(plain, o->output_path)
                                          : "standard output",
            size_text(size, r->file_bytes));
    fprintf(to, ratio < 1 ? "%.2g times that\n" : ratio < 10 ? "%.1f times that\n" : "%.0f times that\n", ratio);

    print_smoke(to, o, r);

    const char *const works[STAGE_COUNT] = {"reading the scene",
                                            "finding solids",
                                            "planning",
                                            "starting OpenGL",
                                            o->maps == MAPS_SPARSE ? "finding depths" : "rendering depth maps",
                                            "bounding depths",
                                            o->coding == CODING_DAG ? "making masks" : "making palette blocks",
                                            "inserting nodes",
                                            "compressing",
                                            "merging",
                                            "encoding",
                                            "baking smoke",
                                            "writing"};
    char              memory[32];
    int               longest = 0;
    for (int s = 0; s < STAGE_COUNT; s++)
        if (r->stage[s].seconds > r->stage[longest].seconds) longest = s;
    fprintf(to, "time         %.2f s, %.2f of it %s; memory %s\n", r->total_seconds, r->stage[longest].seconds, works[longest],
            size_text(memory, r->peak_bytes));

    plan_print_savings(to, r->plan, r->file_bytes);
}

void plan_summary_print(FILE *to, const bake_options *o, const bake_report *r)
{
    print_scene(to, o, r);
    print_lights(to, r->plan);
    print_left_out(to, r);
    plan_print_estimate(to, r->plan);
    plan_print_savings(to, r->plan, r->plan->file_bytes);
}
