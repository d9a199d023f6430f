/* The plan of a frame as text and JSON; see frame_plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/frame_plan.h"

#include <math.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/vec3.h"
#include "baker/files/json_value.h"

/* An object with a count for each name. */
static json_t *counts_json(const char *const *names, const uint32_t *counts, int count)
{
    json_t *o = json_object();
    for (int n = 0; n < count; n++) json_set(&o, names[n], json_integer(counts[n]));
    return o;
}

/* fog -------------------------------------------------------------------------------------------------------------------------- */

const char *const fog_by_names[] = {"march", "angles", "intervals", "mesh", "grid"};

static const char *const fog_cull_names[FOG_CULL_RESULTS] = {"drawn", "faint", "out_of_view", "clear"};

static void fog_cull_text(char text[64], fog_cull_result cull_result)
{
    static const char *const texts[FOG_CULL_RESULTS] = {[FOG_OUT_OF_VIEW] = "out of view", [FOG_CLEAR] = "not in the fog"};
    if (cull_result == FOG_FAINT)
        snprintf(text, 64, "too faint (together less than 1/%.0f of white)", 1 / FOG_FAINTEST);
    else
        snprintf(text, 64, "%s", texts[cull_result]);
}

/* savings ---------------------------------------------------------------------------------------------------------------------- */

static void leave_out(fog_saving **next, const char *what, const char *reason)
{
    snprintf((*next)->left_out, sizeof(*next)->left_out, "%s", what);
    snprintf((*next)->reason, sizeof(*next)->reason, "%s", reason);
    ++*next;
}

/* by  the requested method;   light_count  of the file */
static void fog_plan_savings(const fog_plan *plan, fog_by by, uint32_t light_count, fog_saving savings[FOG_SAVINGS])
{
    fog_saving *next = savings;
    char        what[64];
    memset(savings, 0, FOG_SAVINGS * sizeof *savings);
    if (!plan->lights[FOG_DRAWN]) leave_out(&next, "all passes of lights", "no light has airlight to speak of in view");
    if (by == FOG_BY_INTERVALS && !plan->by_angles)
        leave_out(&next, "march, grid and mesh", "the file says where each ray is lit, exactly");
    if (by == FOG_BY_MESH) {
        leave_out(&next, "adaptive pass", "what stands has a mesh that is made once, with triangles where its surface bends");
        snprintf(what, sizeof what, "%u of %u meshes", light_count - plan->meshes_made, light_count);
        if (plan->meshes_made < light_count) leave_out(&next, what, "their lights have not been drawn");
    } else if (!plan->shadow_depth_maps)
        leave_out(&next, "shadow depth maps", "nothing moves: where shadow begins is looked up in the file");
}

/* text ------------------------------------------------------------------------------------------------------------------------- */

void fog_plan_print(FILE *to, const fog_plan *plan, fog_by by, const fog_light_plan *lights, const vxs_baked_light *const *names,
                    uint32_t light_count, int verbose)
{
    fog_saving savings[FOG_SAVINGS];
    char       why[64];
    fprintf(to, "fog          %u light%s: %u drawn by %s", light_count, light_count == 1 ? "" : "s", plan->lights[FOG_DRAWN],
            fog_by_names[by]);
    for (int n = FOG_FAINT; n < FOG_CULL_RESULTS; n++) {
        fog_cull_text(why, (fog_cull_result)n);
        if (plan->lights[n]) fprintf(to, ", %u %s", plan->lights[n], why);
    }
    if (plan->by_angles) fprintf(to, "; %u of them by %s", plan->by_angles, fog_by_names[FOG_BY_ANGLES]);
    if (plan->shadow_depth_maps) fprintf(to, "; %u of maps that end where something moves", plan->shadow_depth_maps);
    fputc('\n', to);
    if (!verbose) return;
    fog_plan_savings(plan, by, light_count, savings);
    for (const fog_saving *s = savings; s < savings + FOG_SAVINGS && *s->left_out; s++)
        fprintf(to, "%-20s left out: %s\n", s->left_out, s->reason);
    for (uint32_t n = 0; n < light_count; n++) {
        char name[VXS_LIGHT_NAME_BYTES], reason[64];
        one_line(strcpy(name, names[n]->light.name));
        if (lights[n].cull_result == FOG_DRAWN) {
            fprintf(to, "light %s: by %s, in %.0f %% of the picture%s%s\n", name, fog_by_names[lights[n].by], 100 * lights[n].share,
                    lights[n].why ? ": " : "", lights[n].why ? lights[n].why : "");
            continue;
        }
        fog_cull_text(reason, lights[n].cull_result);
        fprintf(to, "light %s is left out: %s\n", name, reason);
    }
}

/* JSON ------------------------------------------------------------------------------------------------------------------------- */

json_t *fog_plan_counts(const fog_plan *plan)
{
    return counts_json(fog_cull_names, plan->lights, FOG_CULL_RESULTS);
}

json_t *fog_plan_lights(const fog_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count)
{
    json_t *list = json_array();
    for (uint32_t n = 0; n < light_count; n++) {
        json_t *o =
            json_pack("{s:o, s:s}", "light", json_text(names[n]->light.name), "cull_result", fog_cull_names[lights[n].cull_result]);
        if (lights[n].cull_result == FOG_DRAWN) {
            json_set(&o, "by", json_text(fog_by_names[lights[n].by]));
            if (lights[n].why) json_set(&o, "why", json_text(lights[n].why));
            json_set(&o, "share", json_real(rounded(lights[n].share, 4)));
        }
        json_append(&list, o);
    }
    return list;
}

json_t *fog_plan_left_out(const fog_plan *plan, fog_by by, uint32_t light_count)
{
    fog_saving savings[FOG_SAVINGS];
    json_t    *list = json_array();
    fog_plan_savings(plan, by, light_count, savings);
    for (const fog_saving *s = savings; s < savings + FOG_SAVINGS && *s->left_out; s++)
        json_append(&list, json_pack("{s:s, s:s}", "what", s->left_out, "reason", s->reason));
    return list;
}

/* smoke ------------------------------------------------------------------------------------------------------------------------ */

static const char *const smoke_cull_names[SMOKE_CULL_RESULTS] = {"dims", "out_of_reach", "out_of_view", "no_room"};
static const char *const smoke_cull_texts[SMOKE_CULL_RESULTS] = {"dimmed", "out of its reach", "out of view",
                                                                 "without a map, for all are taken"};

void smoke_plan_print(FILE *to, const smoke_plan *plan, uint32_t capsules, uint32_t side_px, const smoke_light_plan *lights,
                      const vxs_baked_light *const *names, uint32_t light_count, int verbose)
{
    fprintf(to, "smoke        %u capsules; %u light%s", capsules, light_count, light_count == 1 ? ": " : "s: ");
    for (int n = 0, listed = 0; n < SMOKE_CULL_RESULTS; n++)
        if (plan->lights[n]) fprintf(to, "%s%u %s", listed++ ? ", " : "", plan->lights[n], smoke_cull_texts[n]);
    fputc('\n', to);
    for (uint32_t n = 0; n < light_count && verbose; n++) {
        char name[VXS_LIGHT_NAME_BYTES];
        one_line(strcpy(name, names[n]->light.name));
        if (lights[n].cull_result == SMOKE_DIMS)
            fprintf(to, "light %s: smoke by %u x %u curves, of %u segments\n", name, side_px, side_px, lights[n].segments);
        else
            fprintf(to, "light %s: no smoke: %s\n", name, smoke_cull_texts[lights[n].cull_result]);
    }
}

json_t *smoke_plan_counts(const smoke_plan *plan)
{
    json_t *o = counts_json(smoke_cull_names, plan->lights, SMOKE_CULL_RESULTS);
    json_set(&o, "built", json_integer(plan->built));
    return o;
}

json_t *smoke_plan_lights(const smoke_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count)
{
    json_t *list = json_array();
    for (uint32_t n = 0; n < light_count; n++) {
        json_t *o = json_pack("{s:o, s:s}", "light", json_text(names[n]->light.name), "cull_result",
                              smoke_cull_names[lights[n].cull_result]);
        if (lights[n].cull_result == SMOKE_DIMS) {
            json_set(&o, "segments", json_integer(lights[n].segments));
            json_set(&o, "merged", json_integer(lights[n].merged));
            json_set(&o, "cut_texels", json_integer(lights[n].cut_texels));
        }
        json_append(&list, o);
    }
    return list;
}

/* virtual lights --------------------------------------------------------------------------------------------------------------- */

/* The end of the line with their number: the smoke that dims them, if any. */
static void vpl_plan_print_smoke(FILE *to, const vpl_words *w)
{
    if (w->capsules) fprintf(to, " that %u capsules of smoke dim", w->capsules);
}

/* Further lines on them. */
static void vpl_plan_print(FILE *to, const vpl_words *w)
{
    fprintf(to, "shadows of %u points of the %s, pixels gather %s\n", w->points, w->baked ? "file" : "scene", w->gather);
    if (w->capsules) fprintf(to, "smoke by %u x %u curves for each VPL\n", w->smoke_side, w->smoke_side);
    if (w->baked_smoke) fprintf(to, "baked smoke is left out: the file has it for its own lights alone\n");
}

/* Members of an object. */
static void vpl_plan_json(json_t **o, const vpl_words *w)
{
    json_set(o, "gather", json_text(w->gather));
    json_set(o, "points", json_integer(w->points));
    json_set(o, "points_of", json_text(w->baked ? "asset" : "scene"));
    if (w->capsules) json_set(o, "smoke", json_pack("{s:i, s:i}", "capsules", (int)w->capsules, "side_px", (int)w->smoke_side));
    json_set(o, "baked_smoke_left_out", json_boolean(w->baked_smoke));
}

/* area lights ------------------------------------------------------------------------------------------------------------------ */

static const char *const area_cull_names[AREA_CULL_RESULTS] = {"drawn", "faint", "behind"};
static const char *const area_cull_texts[AREA_CULL_RESULTS] = {
    [AREA_FAINT] = "too faint (brighter ones have all VPLs)", [AREA_BEHIND] = "behind all that is seen"};

static const char *name_of(const scene *s, const scene_area *a)
{
    return s->names + s->parts[a->part].node_name;
}

void area_plan_print(FILE *to, const area_plan *plan, const area_words *w, int verbose)
{
    size_t count = w->scene->area_count;
    fprintf(to, "area         %zu parallelogram%s of light", count, count == 1 ? "" : "s");
    if (count)
        fprintf(to, ": %u drawn by %u VPLs", plan->areas[AREA_DRAWN], plan->vpls);
    else
        fputs(": nothing in the scene shines; --sky FILE lights it by a map of the sky", to);
    vpl_plan_print_smoke(to, &w->lit);
    for (int n = AREA_FAINT; n < AREA_CULL_RESULTS; n++)
        if (plan->areas[n]) fprintf(to, ", %u %s", plan->areas[n], area_cull_texts[n]);
    fputc('\n', to);
    if (!verbose) return;
    if (count) vpl_plan_print(to, &w->lit);
    for (size_t n = 0; n < count; n++) {
        char name[128];
        snprintf(name, sizeof name, "%s", name_of(w->scene, &w->scene->areas[n]));
        one_line(name);
        if (w->shares[n].cull_result == AREA_DRAWN)
            fprintf(to, "area light %s: %u VPLs\n", name, w->shares[n].vpls);
        else
            fprintf(to, "area light %s is left out: %s\n", name, area_cull_texts[w->shares[n].cull_result]);
    }
    if (w->scene->dim_count) fprintf(to, "%zu triangles that shine are left out: no parallelogram of two\n", w->scene->dim_count);
}

json_t *area_plan_counts(const area_plan *plan)
{
    return counts_json(area_cull_names, plan->areas, AREA_CULL_RESULTS);
}

json_t *area_plan_json(const area_plan *plan, const area_words *w)
{
    json_t *o = json_pack("{s:i}", "vpls", (int)plan->vpls), *lights = json_array();
    for (size_t n = 0; n < w->scene->area_count; n++)
        json_append(&lights, json_pack("{s:o, s:s, s:i}", "node", json_text(name_of(w->scene, &w->scene->areas[n])), "cull_result",
                                       area_cull_names[w->shares[n].cull_result], "vpls", (int)w->shares[n].vpls));
    vpl_plan_json(&o, &w->lit);
    json_set(&o, "lights", lights);
    json_set(&o, "dim_triangles", json_integer((json_int_t)w->scene->dim_count));
    return o;
}

/* a sky ------------------------------------------------------------------------------------------------------------------------ */

void sky_plan_print(FILE *to, const sky_words *w, int verbose)
{
    char name[128];
    snprintf(name, sizeof name, "%s", w->path);
    fprintf(to, "sky          %s, %u x %u pixels: drawn by %u VPLs", one_line(name), w->wide_px, w->high_px, w->vpls);
    vpl_plan_print_smoke(to, &w->lit);
    fputc('\n', to);
    if (!verbose) return;
    fprintf(to, "radiance times %g, turned by %g degrees\n", w->light, w->turn_degrees);
    vpl_plan_print(to, &w->lit);
}

json_t *sky_plan_json(const sky_words *w)
{
    json_t *o = json_pack("{s:o, s:i, s:i, s:f, s:f, s:i}", "path", json_text(w->path), "width_px", (int)w->wide_px, "height_px",
                          (int)w->high_px, "light", w->light, "turn_degrees", w->turn_degrees, "vpls", (int)w->vpls);
    vpl_plan_json(&o, &w->lit);
    return o;
}
