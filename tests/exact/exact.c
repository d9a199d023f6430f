/* exact: bake a scene, then query the file about the voxels of its depth maps, all of them.
 *
 * The contract (docs/overview.md): with e and x the enter and exit depth of texel (i,j) in voxels, voxel (i,j,k) is lit if
 * its far side is at or before e (k + 1 <= e), shadowed if its near side is at or behind x (k >= x), and free otherwise. The
 * maps are rendered a second time and compared as the floats that they are, in double: no pyramid, mask or node takes part. What
 * the bake and this check have in common is the renderer and the lookup. What is baked with --maps sparse is compared with brute
 * force (tests/columns/brute.h), which has only the projection in common with it.
 *
 *     exact SCENE [--sun X,Y,Z]... [--resolution N]... [--columns all|COUNT] [bake's options]... [--fault NAME]
 *     exact SCENE [--free shadow|free,METRES]...
 *     exact SCENE --spot X,Y,Z,DX,DY,DZ,DEGREES[,RANGE] ... --point X,Y,Z[,RANGE] ... [the same]
 *
 * --sun, --resolution, --free, --maps, --closed, --exit, --coding, --rule, --reuse, --compress, --stop and --seed may be repeated:
 * every combination is baked and compared. The scene is read once; casters are found once for each --closed; and maps are rendered
 * once for all files that differ in coding, rule, reuse, compress, stop or seed only. The first combination is baked by bake(),
 * from the scene's file to the asset's, the others by its stages.
 * --free gives bake's --behind and --thickness, 0 for none.
 * --columns all requests every voxel, COUNT for that many random columns: the voxels around e and x, both ends, and 16
 * others; with --maps sparse for every voxel of so many columns, in tiles of 64, every other of them where an edge of a triangle
 * passes, and besides for the former through the runtime; --silhouettes COUNT for all tiles around so many random silhouettes of
 * the map, too. --spot and --point put lights into the scene, in place of its own; places are shares of the scene's box, how
 * far in shares of its diagonal, so that the same light fits every scene. DEGREES is the whole cone.
 * --fault builds the DAG here, stage by stage, and spoils one thing after one of them: the check must see it.
 * One line of JSON on standard output for each combination. Exit status 0: no voxel is wrong; 1: some are; else as vxs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "formats/vxs_lookup.h" /* before dag.h: a lookup calls its light's words `dag` */

#include "baker/bake/bake_light.h"
#include "baker/bake/light_coder.h"
#include "baker/bake/light_columns.h"
#include "baker/bake/plan.h"
#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/command/asset_open.h"
#include "baker/command/options/options.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/light/light_fit.h"
#include "baker/scene/light_choice.h"
#include "tests/exact/check.h"
#include "tests/exact/spoil.h"
#include "tests/gl_choice.h"

/* Options of bake of which several values may be requested. */
enum choice {
    CHOICE_MAPS,
    CHOICE_CLOSED,
    CHOICE_EXIT,
    CHOICE_CODING,
    CHOICE_RULE,
    CHOICE_REUSE,
    CHOICE_COMPRESS,
    CHOICE_STOP,
    CHOICES
};

static const struct {
    const char *option, *words;
    int         usual;
} choices[CHOICES] = {
    [CHOICE_MAPS]     = {"--maps", MAPS_CHOICES, MAPS_GL},
    [CHOICE_CLOSED]   = {"--closed", CLOSED_CHOICES, CLOSED_AUTO},
    [CHOICE_EXIT]     = {"--exit", EXIT_CHOICES, EXIT_AUTO},
    [CHOICE_CODING]   = {"--coding", CODING_CHOICES, CODING_DAG},
    [CHOICE_RULE]     = {"--rule", RULE_CHOICES, MASK_RULE_GREEDY},
    [CHOICE_REUSE]    = {"--reuse", REUSE_CHOICES, 1},
    [CHOICE_COMPRESS] = {"--compress", COMPRESS_CHOICES, COMPRESS_CHOICE_AUTO},
    [CHOICE_STOP]     = {"--stop", STOP_CHOICES, STOP_FINAL},
};

enum { CHOICE_VALUES_MAX = 8, WAYS_MAX = 64 };

typedef struct exact_options {
    bake_options bake; /* what is the same in all combinations */
    const char  *scene_path;
    text_list    suns;      /* none: the scene's lights */
    text_list    left_free; /* none: nothing but what lies between surfaces */
    number_list  resolutions, seeds;
    int          value[CHOICES][CHOICE_VALUES_MAX];
    size_t       value_count[CHOICES]; /* at least 1 */
    uint64_t     columns;              /* 0: all */
    uint32_t     silhouettes;
    fault        fault;
    text_list    spots, points;
} exact_options;

/* A combination, its file, and what is found of it. */
typedef struct way {
    bake_options bake;
    const char  *left_free; /* as it was given, or NULL */
    uint32_t     seed;
    vxs_asset   *asset;
    tally        sum;
} way;

/* a scene and what casts shadows in it ----------------------------------------------------------------------------------------- */

typedef struct world {
    scene       s;
    casters     c;
    gl_context *gl;
} world;

/* Bounds, and room above and below what is flat: a punctual light in its plane would see an edge. */
static void scene_box(const scene *s, double box[6])
{
    double widest = 0;
    for (int n = 0; n < 6; n++) box[n] = n < 3 ? INFINITY : -INFINITY;
    for (size_t n = 0; n < 3 * s->triangle_count; n++)
        for (int k = 0; k < 3; k++) {
            double at  = s->positions_ws[3 * (size_t)s->indices[n] + (size_t)k];
            box[k]     = fmin(box[k], at);
            box[3 + k] = fmax(box[3 + k], at);
        }
    for (int k = 0; k < 3; k++) widest = fmax(widest, box[3 + k] - box[k]);
    for (int k = 0; k < 3; k++)
        if (box[3 + k] - box[k] < 0.05 * widest) {
            box[k] -= 0.1 * widest;
            box[3 + k] += 0.15 * widest;
        }
}

/* A light of the command line, from shares of the scene's box. */
static vxs_result put_punctual(scene *s, const char *text, int spot, const double box[6], run_context *m)
{
    double       v[8] = {0}, diagonal = 0;
    int          end = 0, count, wanted = spot ? 7 : 3;
    scene_light *l = &s->lights[s->light_count];
    for (count = 0; count < 8 && sscanf(text, count ? ",%lf%n" : "%lf%n", &v[count], &end) == 1; count++) text += end;
    if (*text || count < wanted || count > wanted + 1)
        return fail(m, VXS_E_ARGUMENT, "--%s: expected %d or %d numbers", spot ? "spot" : "point", wanted, wanted + 1);
    for (int n = 0; n < 3; n++) {
        diagonal += (box[3 + n] - box[n]) * (box[3 + n] - box[n]);
        l->shape.position_ws[n] = box[n] + v[n] * (box[3 + n] - box[n]);
    }
    l->shape.kind         = spot ? LIGHT_SPOT : LIGHT_POINT;
    l->shape.outer_rad    = spot ? v[6] * acos(-1) / 360 : 0;
    l->shape.range_metres = count > wanted ? v[wanted] * sqrt(diagonal) : (double)INFINITY;
    if (spot && !vec3_unit(v + 3, l->shape.direction_ws)) return fail(m, VXS_E_ARGUMENT, "--spot: expected a direction, not zero");
    if (!(l->name = malloc(32))) return fail(m, VXS_E_MEMORY, "out of memory");
    snprintf(l->name, 32, "%s %zu", spot ? "spot" : "point", s->light_count++);
    return VXS_OK;
}

static size_t punctuals_asked_for(const exact_options *o)
{
    return o->spots.count + o->points.count;
}

/* The lights of the command line in place of the scene's. */
static vxs_result put_punctuals(scene *s, const exact_options *o, run_context *m)
{
    double     box[6];
    vxs_result r = VXS_OK;
    for (size_t n = 0; n < s->light_count; n++) free(s->lights[n].name);
    free(s->lights);
    s->light_count = 0;
    s->lights      = calloc(punctuals_asked_for(o), sizeof *s->lights);
    if (!s->lights) return fail(m, VXS_E_MEMORY, "out of memory");
    scene_box(s, box);
    for (size_t n = 0; n < o->spots.count && r == VXS_OK; n++) r = put_punctual(s, o->spots.items[n], 1, box, m);
    for (size_t n = 0; n < o->points.count && r == VXS_OK; n++) r = put_punctual(s, o->points.items[n], 0, box, m);
    return r;
}

/* Skinned meshes are voxels like others. */
static const scene_choice everything = {.skinned = SKINNED_REST, .skinned_given = 1};

static vxs_result world_load(world *w, const exact_options *o, run_context *m)
{
    vxs_result r;
    if ((r = scene_load_gltf(&w->s, o->scene_path, &everything, m)) != VXS_OK) return r;
    return punctuals_asked_for(o) ? put_punctuals(&w->s, o, m) : VXS_OK;
}

static void world_free(world *w)
{
    if (w->gl) gl_context_destroy(w->gl);
    casters_free(&w->c);
    scene_free(&w->s);
}

/* the three ways to an asset --------------------------------------------------------------------------------------------------- */

static vxs_result bake_asset(const exact_options *o, way *y, run_context *m)
{
    bake_options bake_it  = y->bake;
    bake_report  report   = {0};
    const char  *tmp      = getenv("TMPDIR");
    char         dir[512] = "", path[600];
    snprintf(dir, sizeof dir, "%s/exact-XXXXXX", tmp && *tmp ? tmp : "/tmp");
    if (!mkdtemp(dir)) return fail(m, VXS_E_WRITE, "%s: cannot make a folder", dir);
    snprintf(path, sizeof path, "%s/asset.vxs", dir);
    bake_it.scene_path  = o->scene_path;
    bake_it.scene       = everything;
    bake_it.output_path = path;
    vxs_result r        = bake(&bake_it, NULL, &report, m);
    if (r == VXS_OK) r = asset_open(&y->asset, path, 0, 1, y->bake.threads, m);
    bake_report_free(&report);
    unlink(path);
    rmdir(dir);
    return r;
}

/* The lights of a plan, each as bake() bakes one. */
static vxs_result planned_asset(const world *w, const bake_plan *plan, way *y, run_context *m)
{
    size_t           count  = plan->light_count;
    bake_context     ctx    = {.run = m, .threads = y->bake.threads};
    uint32_t         baked  = 0;
    vxs_write_light *lights = calloc(count, sizeof *lights);
    coded_light     *coded  = calloc(count, sizeof *coded);
    vxs_bytes        file   = {0};
    vxs_result       r      = VXS_E_MEMORY;
    if (!lights || !coded) goto done;

    for (size_t n = 0; n < count; n++) {
        const plan_light *planned = &plan->lights[n];
        chosen_coder      coding;
        light_columns     columns;
        if (planned->left_out) continue;
        chosen_coder_init(&coding, &y->bake, plan->compress, NULL);
        light_columns_init(&columns, w->gl, &y->bake, plan, planned, &w->c, NULL);
        column_source source = light_columns_source(&columns);
        r                    = bake_light(planned, &source, &coding.coder, &coded[baked], &ctx);
        chosen_coder_free(&coding);
        light_columns_free(&columns);
        if (r != VXS_OK) goto done;
        lights[baked] = coded[baked].written;
        baked++;
    }
    vxs_write_desc desc = {.lights = lights, .light_count = baked, .zstd_level = 1};
    if ((r = vxs_write(&file, &desc)) != VXS_OK || (r = vxs_asset_open(&y->asset, file.data, file.size_bytes, NULL)) != VXS_OK)
        fail(m, r, "the asset cannot be written and read back");
done:
    for (size_t n = 0; n < count && coded; n++) coded_light_free(&coded[n]);
    free(coded);
    free(lights);
    free(file.data);
    return r;
}

/* By the stages of bake(); lights that reach no caster are left out. */
static vxs_result staged_asset(world *w, const light_choice *chosen, way *y, run_context *m)
{
    bake_plan  plan = {0};
    vxs_result r    = plan_make(&plan, &y->bake, &w->c, NULL, chosen, 0, m);
    if (r == VXS_OK) r = planned_asset(w, &plan, y, m);
    plan_free(&plan);
    return r;
}

/* Of the first light, which is spoilt. */
static vxs_result spoilt_asset(const world *w, const light_choice *chosen, fault planted, way *y, run_context *m)
{
    vxs_write_light     out  = {0};
    vxs_bytes           file = {0};
    dag                 d    = {0};
    const chosen_light *l    = &chosen->lights[0];
    vxs_result          r;
    if (y->bake.resolution < 64 || y->bake.resolution > TILE_MAX_PX)
        return fail(m, VXS_E_ARGUMENT, "--fault needs --resolution 64 to %d", TILE_MAX_PX);
    if (l->shape.kind != LIGHT_DIRECTIONAL) return fail(m, VXS_E_ARGUMENT, "--fault: the first light is not directional");
    light_fit_desc fit   = {.name = l->name, .shape = &l->shape, .resolution = y->bake.resolution};
    spoil_desc     spoil = {w->gl, &w->c, &out.light, &y->bake, planted, y->seed};
    if ((r = light_fit(&out.light, &w->c, &fit, m)) != VXS_OK) goto done;
    if ((r = spoilt_dag(&spoil, &d, m)) != VXS_OK) goto done;
    out                 = dag_to_write(&out.light, &d);
    vxs_write_desc desc = {.lights = &out, .light_count = 1, .zstd_level = 1};
    if ((r = vxs_write(&file, &desc)) != VXS_OK || (r = vxs_asset_open(&y->asset, file.data, file.size_bytes, NULL)) != VXS_OK)
        fail(m, r, "the asset cannot be written and read back");
done:
    free(file.data);
    dag_free(&d);
    return r;
}

/* comparing -------------------------------------------------------------------------------------------------------------------- */

/* A child of a root that was a node of its own becomes lit: of the first of six that has one. */
static void spoil_word(uint32_t *words, const vxs_light *light)
{
    uint32_t root = light->flags & VXS_LIGHT_CUBE ? words[0] : 0;
    for (uint32_t map = 1; map < VXS_CUBE_FACES && light->flags & VXS_LIGHT_CUBE && !vxs_own(words[root]); map++) root = words[map];
    uint32_t own = vxs_own(words[root]);
    words[root] &= ~(2u * (own & (0u - own)));
}

/* What lookups and maps are made of is the same in both: all but the words. */
static int same_light(const vxs_light *a, const vxs_light *b)
{
    return a->kind == b->kind && a->levels == b->levels && a->flags == b->flags && a->voxel_metres == b->voxel_metres &&
           !strcmp(a->name, b->name) && !memcmp(a->ls_from_ws, b->ls_from_ws, sizeof a->ls_from_ws);
}

/* Light n of all files, against maps that are rendered once. */
static vxs_result check_light(const exact_options *o, const world *w, way *ways, uint32_t count, uint32_t n, run_context *m)
{
    const vxs_light *light = &vxs_asset_light(ways[0].asset, n)->light;
    checked_file     files[WAYS_MAX];
    check_desc       d    = {.gl          = w->gl,
                             .casters     = &w->c,
                             .light       = light,
                             .exit        = ways[0].bake.exit,
                             .behind      = ways[0].bake.behind == BEHIND_FREE,
                             .thickness   = ways[0].bake.thickness_metres,
                             .brute       = ways[0].bake.maps == MAPS_SPARSE,
                             .threads     = o->bake.threads,
                             .columns     = o->columns,
                             .silhouettes = o->silhouettes,
                             .seed        = ways[0].seed,
                             .files       = files,
                             .file_count  = count};
    int              maps = (int)vxs_map_count(light);
    vxs_result       r    = VXS_OK;
    memset(files, 0, sizeof files);
    for (uint32_t y = 0; y < count; y++) {
        const vxs_baked_light *own   = vxs_asset_light(ways[y].asset, n);
        size_t                 bytes = ((size_t)own->word_count + VXS_BLOCKS_SPARE_WORDS) * sizeof *own->words;
        uint32_t              *words = calloc(1, bytes);
        files[y].words               = words;
        files[y].light               = &own->light;
        r                            = VXS_E_MEMORY;
        if (!words) goto done;
        memcpy(words, own->words, (size_t)own->word_count * sizeof *words);
        if (o->fault == FAULT_WORD) spoil_word(words, &own->light);
        r = VXS_E_CORRUPT;
        if (!same_light(light, &own->light)) goto done;
    }
    r = VXS_OK;
    for (int map = 0; map < maps && r == VXS_OK; map++) r = check_map(&d, map, m);
done:
    if (r == VXS_E_MEMORY) fail(m, r, "out of memory");
    if (r == VXS_E_CORRUPT) fail(m, r, "light %u is not the same in all files", n);
    for (uint32_t y = 0; y < count; y++) {
        tally *to = &ways[y].sum, *from = &files[y].sum;
        to->columns += from->columns;
        to->voxels += from->voxels;
        to->lookups += from->lookups;
        to->wrong_lit += from->wrong_lit;
        to->wrong_shadow += from->wrong_shadow;
        to->misread += from->misread;
        to->insane += from->insane;
        to->maps += (uint64_t)maps;
        free((void *)files[y].words);
    }
    return r;
}

static int print_result(const exact_options *o, const way *y)
{
    const tally *t          = &y->sum;
    const double sunless[3] = {0}, *sun = y->bake.suns.count ? y->bake.suns.items[0].numbers : sunless;
    json_t      *line =
        json_pack("{s:s, s:I, s:s*, s:[f,f,f], s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "scene", o->scene_path, "resolution",
                  (json_int_t)y->bake.resolution, "free", y->left_free, "sun", sun[0], sun[1], sun[2], "seed", (json_int_t)y->seed,
                  "maps", (json_int_t)t->maps, "columns", (json_int_t)t->columns, "voxels", (json_int_t)t->voxels, "lookups",
                  (json_int_t)t->lookups, "wrong_lit", (json_int_t)t->wrong_lit, "wrong_shadow", (json_int_t)t->wrong_shadow,
                  "misread", (json_int_t)t->misread, "insane_depths", (json_int_t)t->insane);
    json_t *told   = bake_options_json(&y->bake);
    int     failed = !line || !told || json_object_update_missing(line, told) || json_dumpf(line, stdout, JSON_COMPACT) ||
                 puts("") < 0 || fflush(stdout);
    json_decref(line);
    json_decref(told);
    return !failed && !t->wrong_lit && !t->wrong_shadow && !t->misread && !t->insane && t->columns;
}

/* all combinations ------------------------------------------------------------------------------------------------------------- */

/* The combinations that share maps: they differ in coding, rule, reuse, compress, stop and seed.
 * left_free  as it was given, or NULL */
static uint32_t ways_of(const exact_options *o, const bake_options *bake, const char *left_free, way *ways)
{
    static const int inner[] = {CHOICE_CODING, CHOICE_RULE, CHOICE_REUSE, CHOICE_COMPRESS, CHOICE_STOP};
    enum { INNER = sizeof inner / sizeof *inner };
    size_t count = o->seeds.count;
    for (int n = 0; n < INNER; n++) count *= o->value_count[inner[n]];
    if (count > WAYS_MAX) return 0;
    for (size_t y = 0; y < count; y++) {
        size_t at = y;
        int    chosen[INNER];
        for (int n = 0; n < INNER; n++) {
            chosen[n] = o->value[inner[n]][at % o->value_count[inner[n]]];
            at /= o->value_count[inner[n]];
        }
        ways[y]               = (way){.bake = *bake, .left_free = left_free, .seed = o->seeds.items[at]};
        ways[y].bake.coding   = (coding_choice)chosen[0];
        ways[y].bake.rule     = (mask_rule)chosen[1];
        ways[y].bake.reuse    = chosen[2];
        ways[y].bake.compress = (compress_choice)chosen[3];
        ways[y].bake.stop     = (stop_stage)chosen[4];
    }
    return (uint32_t)count;
}

/* What is distinguished by one pass over the maps.
 * left_free  as it was given, or NULL
 * first      NULL, or the asset of the first combination, which is taken over
 * *right     becomes 0 when something is wrong */
static vxs_result compare_ways(const exact_options *o, world *w, const bake_options *bake, const char *left_free, vxs_asset **first,
                               int *right, run_context *m)
{
    way          ways[WAYS_MAX];
    light_choice chosen = {0};
    uint32_t     count  = ways_of(o, bake, left_free, ways), lights;
    vxs_result   r;
    if (!count) return fail(m, VXS_E_ARGUMENT, "more than %d combinations for the same maps", WAYS_MAX);
    ways[0].asset = *first;
    *first        = NULL;
    if ((r = lights_choose(&w->s, &bake->light_names, &bake->suns, &chosen, m)) != VXS_OK) goto done;
    for (uint32_t y = 0; y < count; y++) {
        if (ways[y].asset) continue;
        r = o->fault == FAULT_NONE || (punctuals_asked_for(o) && o->fault == FAULT_WORD)
                ? staged_asset(w, &chosen, &ways[y], m)
                : spoilt_asset(w, &chosen, o->fault, &ways[y], m);
        if (r != VXS_OK) goto done;
    }
    lights = vxs_asset_light_count(ways[0].asset);
    for (uint32_t n = 0; n < lights; n++)
        if ((r = check_light(o, w, ways, count, n, m)) != VXS_OK) goto done;
    for (uint32_t y = 0; y < count; y++) *right &= print_result(o, &ways[y]);
done:
    for (uint32_t y = 0; y < count; y++) vxs_asset_close(ways[y].asset);
    light_choice_free(&chosen);
    return r;
}

/* The sun of the command line; without one, nothing. */
static vxs_result set_sun(bake_options *bake, named_value *sun, const char *text, run_context *m)
{
    int     end = 0;
    double *v   = sun->numbers;
    bake->suns  = (named_list){sun, text != NULL, 1};
    if (text && (sscanf(text, "%lf,%lf,%lf%n", &v[0], &v[1], &v[2], &end) != 3 || text[end]))
        return fail(m, VXS_E_ARGUMENT, "--sun %s: expected 3 numbers", text);
    return VXS_OK;
}

/* What is left free besides, "free,0.2"; without a text, nothing. */
static vxs_result set_left_free(bake_options *bake, const char *text, run_context *m)
{
    int end                = 0;
    bake->thickness_metres = 0;
    bake->behind           = text && !strncmp(text, "free,", 5) ? BEHIND_FREE : BEHIND_SHADOW;
    if (text && (sscanf(text, bake->behind == BEHIND_FREE ? "free,%lf%n" : "shadow,%lf%n", &bake->thickness_metres, &end) != 1 ||
                 text[end] || !(bake->thickness_metres >= 0 && bake->thickness_metres <= 1e9)))
        return fail(m, VXS_E_ARGUMENT, "--free %s: expected free or shadow, and metres", text);
    return VXS_OK;
}

/* What decides maps beside casters and suns: combination n of map_combinations().
 * *left_free  as it was given, or NULL */
static vxs_result set_maps(const exact_options *o, size_t n, bake_options *bake, const char **left_free, run_context *m)
{
    size_t exits = o->value_count[CHOICE_EXIT], frees = o->left_free.count ? o->left_free.count : 1;
    bake->resolution = o->resolutions.items[n % o->resolutions.count];
    n /= o->resolutions.count;
    *left_free = o->left_free.count ? o->left_free.items[n % frees] : NULL;
    n /= frees;
    bake->exit = (exit_mode)o->value[CHOICE_EXIT][n % exits];
    bake->maps = (maps_choice)o->value[CHOICE_MAPS][n / exits];
    return set_left_free(bake, *left_free, m);
}

static size_t map_combinations(const exact_options *o)
{
    return o->resolutions.count * (o->left_free.count ? o->left_free.count : 1) * o->value_count[CHOICE_EXIT] *
           o->value_count[CHOICE_MAPS];
}

/* The combinations of what decides casters and maps, and in each all others. */
static vxs_result compare_all(const exact_options *o, int *right, run_context *m)
{
    world        w       = {0};
    bake_options bake    = o->bake;
    vxs_asset   *first   = NULL;
    size_t       suns    = o->suns.count ? o->suns.count : 1;
    named_value  sun_now = {.name = (char[]){SUN_NAME}};
    const char  *left_free;
    vxs_result   r;
    bake.renderer = &opengl_renderer;
    if (!punctuals_asked_for(o) && o->fault == FAULT_NONE) {
        way ways[WAYS_MAX];
        bake.closed = (closed_mode)o->value[CHOICE_CLOSED][0];
        if ((r = set_maps(o, 0, &bake, &left_free, m)) != VXS_OK) goto done;
        if ((r = set_sun(&bake, &sun_now, o->suns.count ? o->suns.items[0] : NULL, m)) != VXS_OK) goto done;
        if (ways_of(o, &bake, left_free, ways) && (r = bake_asset(o, &ways[0], m)) != VXS_OK) goto done;
        first = ways[0].asset;
    }
    if ((r = world_load(&w, o, m)) != VXS_OK) goto done;
    for (size_t closed = 0; closed < o->value_count[CHOICE_CLOSED]; closed++) {
        bake.closed = (closed_mode)o->value[CHOICE_CLOSED][closed];
        casters_free(&w.c);
        if ((r = casters_for_maps(&w.c, &w.s, bake.closed, 2, m)) != VXS_OK) goto done;
        if (!w.gl && (r = gl_context_create(&w.gl, gl_choice(), bake.threads, m)) != VXS_OK) goto done;
        for (size_t sun = 0; sun < suns; sun++) {
            if ((r = set_sun(&bake, &sun_now, o->suns.count ? o->suns.items[sun] : NULL, m)) != VXS_OK) goto done;
            for (size_t n = 0; n < map_combinations(o); n++) {
                if ((r = set_maps(o, n, &bake, &left_free, m)) != VXS_OK) goto done;
                if ((r = compare_ways(o, &w, &bake, left_free, &first, right, m)) != VXS_OK) goto done;
            }
        }
    }
done:
    vxs_asset_close(first);
    world_free(&w);
    return r;
}

/* the command line ------------------------------------------------------------------------------------------------------------- */

/* The words given for a choice; without any, the usual one. */
static vxs_result set_choice(exact_options *o, enum choice c, const text_list *given, run_context *m)
{
    o->value[c][0]    = choices[c].usual;
    o->value_count[c] = given->count ? given->count : 1;
    if (given->count > CHOICE_VALUES_MAX) return fail(m, VXS_E_ARGUMENT, "%s is given too often", choices[c].option);
    for (size_t n = 0; n < given->count; n++)
        if ((o->value[c][n] = choice_index(choices[c].words, given->items[n])) < 0)
            return fail(m, VXS_E_ARGUMENT, "%s %s: expected one of %s", choices[c].option, given->items[n], choices[c].words);
    return VXS_OK;
}

static vxs_result check_options(exact_options *o, const char *columns, run_context *m)
{
    if (!o->resolutions.count) o->resolutions = (number_list){{512}, 1};
    if (!o->seeds.count) o->seeds = (number_list){{1}, 1};
    for (size_t n = 0; n < o->resolutions.count; n++)
        if (o->resolutions.items[n] & (o->resolutions.items[n] - 1))
            return fail(m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two", o->resolutions.items[n]);
    if (strcmp(columns, "all")) {
        char *end;
        o->columns = strtoull(columns, &end, 10);
        if (*end || !o->columns) return fail(m, VXS_E_ARGUMENT, "--columns %s: expected all or a number from 1", columns);
    }
    if (o->silhouettes && !o->columns) return fail(m, VXS_E_ARGUMENT, "--silhouettes: only with --columns COUNT");
    if (punctuals_asked_for(o) &&
        (o->suns.count || o->bake.light_names.count || (o->fault != FAULT_NONE && o->fault != FAULT_WORD)))
        return fail(m, VXS_E_ARGUMENT, "--spot and --point: not with --sun, --light or a --fault but word");
    for (size_t n = 0; n < o->value_count[CHOICE_MAPS]; n++)
        if (o->value[CHOICE_MAPS][n] != MAPS_SPARSE && o->silhouettes)
            return fail(m, VXS_E_ARGUMENT, "--silhouettes: only with --maps sparse");
    for (size_t n = 0; n < o->value_count[CHOICE_MAPS]; n++)
        if (o->value[CHOICE_MAPS][n] == MAPS_SPARSE && o->fault != FAULT_NONE && o->fault != FAULT_WORD)
            return fail(m, VXS_E_ARGUMENT, "--maps sparse: with no --fault but word, the others are of rendered maps");
    for (size_t n = 0; n < o->value_count[CHOICE_MAPS]; n++)
        if (o->value[CHOICE_MAPS][n] != MAPS_SPARSE && o->left_free.count)
            return fail(m, VXS_E_ARGUMENT, "--free: with --maps sparse alone");
    return VXS_OK;
}

static vxs_result parse(exact_options *o, int argc, char **argv, int *help_shown, run_context *m)
{
    text_list   given[CHOICES]        = {{0}};
    int         planted               = FAULT_NONE;
    const char *columns               = "all";
    option      options[CHOICES + 12] = {
             {"SCENE", OPTION_INPUT, &o->scene_path, FILE_SCENE, 0, NULL, NULL, NULL, NULL},
             {"--sun", OPTION_TEXTS, &o->suns, 0, 0, NULL, "X,Y,Z", "as bake; repeated for more", NULL},
             {"--light", OPTION_TEXTS, &o->bake.light_names, 0, 0, NULL, "NAME", "as bake", NULL},
             {"--spot", OPTION_TEXTS, &o->spots, 0, 0, NULL, "X,Y,Z,DX,DY,DZ,DEGREES[,RANGE]", "a spot light", NULL},
             {"--point", OPTION_TEXTS, &o->points, 0, 0, NULL, "X,Y,Z[,RANGE]", "a point light", NULL},
             {"--resolution", OPTION_U32S, &o->resolutions, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX, NULL, "N",
              "as bake (default 512); repeated for more", NULL},
             {"--threads", OPTION_U32, &o->bake.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "as bake", NULL},
             {"--columns", OPTION_TEXT, &columns, 0, 0, NULL, "COUNT", "random columns to look at, or all (default)", NULL},
             {"--silhouettes", OPTION_U32, &o->silhouettes, 0, 1000000, NULL, "COUNT",
              "with --columns COUNT: tiles around them (default 0)", NULL},
             {"--seed", OPTION_U32S, &o->seeds, 0, UINT32_MAX, NULL, "S", "other columns, other places for a fault (default 1)", NULL},
             {"--fault", OPTION_CHOICE, &planted, 0, 0, FAULT_CHOICES, NULL, "spoil one thing", NULL},
             {"--free", OPTION_TEXTS, &o->left_free, 0, 0, NULL, BEHIND_CHOICES ",METRES",
              "--behind and --thickness of bake; repeated for more", NULL},
    };
    for (int c = 0; c < CHOICES; c++)
        options[12 + c] =
            (option){choices[c].option, OPTION_TEXTS, &given[c], 0, 0, NULL, choices[c].words, "as bake; repeated for more", NULL};
    const command_line line =
        COMMAND_LINE("exact", "SCENE [options]", "Bake a scene and compare voxels with its depth maps.", options);
    vxs_result r = options_parse(&line, argc, argv, help_shown, m);
    o->fault     = (fault)planted;
    for (int c = 0; c < CHOICES; c++) {
        if (r == VXS_OK) r = set_choice(o, (enum choice)c, &given[c], m);
        free(given[c].items);
    }
    return r == VXS_OK ? check_options(o, columns, m) : r;
}

int main(int argc, char **argv)
{
    exact_options o = {.bake = {.zstd_level = 1}};
    run_context   m = {0};
    int           help_shown, right = 1;
    vxs_result    r;

    o.bake.threads = parallel_default_threads();
    r              = parse(&o, argc, argv, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = compare_all(&o, &right, &m);
    free(o.suns.items);
    free(o.left_free.items);
    free(o.spots.items);
    free(o.points.items);
    int status = command_end(&m, r);
    return status ? status : !right;
}
