/* exact: bake a scene, then ask the file about the voxels of its depth maps, one by one.
 *
 * The contract (docs/overview.md): with e and x the enter and exit depth of texel (i,j) in voxels, voxel (i,j,k) is lit if
 * its far side is at or before e (k + 1 <= e), shadowed if its near side is at or behind x (k >= x), and free otherwise. The
 * maps are rendered a second time and compared as the floats that they are, in double: no rounding to whole voxels, pyramid,
 * mask or node takes part. What the bake and this check have in common is the renderer and the lookup.
 *
 *     exact SCENE [--sun X,Y,Z] [--resolution N] [--columns all|COUNT] [bake's options] [--fault NAME]
 *     exact SCENE --spot X,Y,Z,DX,DY,DZ,DEGREES[,RANGE] ... --point X,Y,Z[,RANGE] ... [the same]
 *
 * --columns all asks for every voxel, COUNT for that many random columns: the voxels around e and x, both ends, and 16
 * others.
 * --spot and --point put lights into the scene, in place of its own; where is told in shares of the scene's box, how far in shares of
 * its diagonal, so that the same light fits every scene. DEGREES is the whole cone.
 * --fault builds the DAG here, stage by stage, and spoils one thing after one of them: the check must see it.
 * One line of JSON on standard output. Exit status 0: no voxel is wrong; 1: some are; else as vxs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "formats/vxs_lookup.h" /* before dag.h: a lookup calls its light's words `dag` */

#include "baker/bake/bake_light.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/command/asset_open.h"
#include "baker/options/options.h"
#include "baker/light/light_fit.h"
#include "baker/bake/plan.h"
#include "baker/scene/light_choice.h"

enum { WINDOW_VX = 3, RANDOM_VOXELS = 16 };

typedef enum fault {
    FAULT_NONE,       /* bake() itself */
    FAULT_STAGES,     /* the stages as they are called here, unspoilt: must be right */
    FAULT_DEPTH,      /* a texel of the depth maps loses its caster */
    FAULT_TILE,       /* the bounds of a tile: a depth that parts nothing is said to part lit from shadowed */
    FAULT_SQUARE,     /* the bounds of a square of 16 texels or more: lit to the end */
    FAULT_MASK,       /* a bit of a visibility mask */
    FAULT_UNTIL,      /* a run of a tile holds one voxel too long */
    FAULT_INSERTED,   /* a child of a node after insertion */
    FAULT_COMPRESSED, /* after compression */
    FAULT_MERGED,     /* after the merge */
    FAULT_WORD        /* a word of the file, after it was read */
} fault;

static const char fault_names[] = "none|stages|depth|tile|square|mask|until|inserted|compressed|merged|word";

typedef struct exact_options {
    bake_options bake;
    const char  *scene_path;
    uint64_t     columns; /* 0: all */
    uint32_t     seed;
    fault        fault;
    text_list    spots, points;
} exact_options;

typedef struct tally {
    uint64_t columns, voxels, wrong_lit, wrong_shadow, insane, maps;
} tally;

/* a scene and what casts shadows in it
 * ---------------------------------------------------------------------------------------- */

typedef struct world {
    scene       s;
    casters     c;
    gl_context *gl;
} world;

/* min xyz, max xyz */
/* Bounds, and room above and below what is flat: a lamp in its plane would see an edge. */
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
static vxs_result put_lamp(scene *s, const char *text, int spot, const double box[6], message *m)
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
    l->shape.kind      = spot ? LIGHT_SPOT : LIGHT_POINT;
    l->shape.outer_rad = spot ? v[6] * acos(-1) / 360 : 0;
    l->shape.range_m   = count > wanted ? v[wanted] * sqrt(diagonal) : (double)INFINITY;
    if (spot && !vec3_unit(v + 3, l->shape.direction_ws)) return fail(m, VXS_E_ARGUMENT, "--spot: expected a direction, not zero");
    if (!(l->name = malloc(32))) return fail(m, VXS_E_MEMORY, "out of memory");
    snprintf(l->name, 32, "%s %zu", spot ? "spot" : "point", s->light_count++);
    return VXS_OK;
}

static size_t lamps_asked_for(const exact_options *o)
{
    return o->spots.count + o->points.count;
}

/* The lights of the command line in place of the scene's. */
static vxs_result put_lamps(scene *s, const exact_options *o, message *m)
{
    double     box[6];
    vxs_result r = VXS_OK;
    for (size_t n = 0; n < s->light_count; n++) free(s->lights[n].name);
    free(s->lights);
    s->light_count = 0;
    s->lights      = calloc(lamps_asked_for(o), sizeof *s->lights);
    if (!s->lights) return fail(m, VXS_E_MEMORY, "out of memory");
    scene_box(s, box);
    for (size_t n = 0; n < o->spots.count && r == VXS_OK; n++) r = put_lamp(s, o->spots.items[n], 1, box, m);
    for (size_t n = 0; n < o->points.count && r == VXS_OK; n++) r = put_lamp(s, o->points.items[n], 0, box, m);
    return r;
}

static vxs_result world_load(world *w, const exact_options *o, message *m)
{
    vxs_result r;
    memset(w, 0, sizeof *w);
    if ((r = scene_load_gltf(&w->s, o->scene_path, NULL, m)) != VXS_OK) return r;
    if (lamps_asked_for(o) && (r = put_lamps(&w->s, o, m)) != VXS_OK) return r;
    if ((r = casters_from_scene(&w->c, &w->s, o->bake.closed, m)) != VXS_OK) return r;
    return gl_context_create(&w->gl, GL_BACKEND_OSMESA, o->bake.threads, m);
}

static void world_free(world *w)
{
    if (w->gl) gl_context_destroy(w->gl);
    casters_free(&w->c);
    scene_free(&w->s);
}

/* comparing
 * ------------------------------------------------------------------------------------------------------------------- */

typedef struct check {
    const depth_maps *maps;
    const uint32_t   *words;
    uint32_t          root; /* of the map in words */
    uint32_t          levels;
    uint32_t          side_vx;
    uint32_t          i0, j0; /* first texel of the rendered tile in the map */
    uint64_t          seed;
    tally             worker[PARALLEL_THREADS_MAX];
    int               failed;
} check;

/* A depth as it was sampled, in voxels: shares of the whole, or near / distance of a perspective map, negative, whose logarithm is
 * divided by a voxel's. */
static double voxels(const check *c, float depth)
{
    if (c->maps->voxel_log == 0) return (double)depth * c->side_vx;
    return depth == 0 ? c->side_vx : fmin(log(-1 / (double)depth) / c->maps->voxel_log, c->side_vx);
}

static int must_be_lit(const check *c, float enter, uint32_t k)
{
    return (double)k + 1 <= voxels(c, enter);
}

static int must_be_dark(const check *c, float exit, uint32_t k)
{
    return (double)k >= voxels(c, exit);
}

static void ask_voxel(const check *c, tally *t, uint32_t i, uint32_t j, uint32_t k)
{
    size_t   at   = (size_t)j * c->maps->side_px + i;
    uint32_t dark = vxs_shadow(c->words, c->root, c->levels, c->i0 + i, c->j0 + j, k);
    t->voxels++;
    t->wrong_shadow += dark && must_be_lit(c, c->maps->enter[at], k);
    t->wrong_lit += !dark && must_be_dark(c, c->maps->exit[at], k);
}

static void ask_window(const check *c, tally *t, uint32_t i, uint32_t j, float depth)
{
    int64_t at = (int64_t)voxels(c, depth);
    for (int64_t k = at - WINDOW_VX; k <= at + WINDOW_VX; k++)
        if (k >= 0 && k < c->side_vx) ask_voxel(c, t, i, j, (uint32_t)k);
}

static void ask_random_columns(void *user, size_t begin, size_t end, uint32_t worker)
{
    check *c = user;
    tally *t = &c->worker[worker];
    for (size_t n = begin; n < end; n++) {
        rng      random = rng_split(c->seed, n);
        uint32_t i = rng_below(&random, c->maps->side_px), j = rng_below(&random, c->maps->side_px);
        size_t   at = (size_t)j * c->maps->side_px + i;
        ask_window(c, t, i, j, c->maps->enter[at]);
        ask_window(c, t, i, j, c->maps->exit[at]);
        ask_voxel(c, t, i, j, 0);
        ask_voxel(c, t, i, j, c->side_vx - 1);
        for (int k = 0; k < RANDOM_VOXELS; k++) ask_voxel(c, t, i, j, rng_below(&random, c->side_vx));
        t->columns++;
    }
}

/* Every voxel of the tile of 8 x 8 texels at (x, y), a slice at a time. changes[k] is set where some answer may differ from
 * the one at k - 1, with a voxel to spare on either side, so that the 64 comparisons need not be made at each depth. */
static void ask_tile(const check *c, tally *t, uint32_t x, uint32_t y, uint8_t *changes)
{
    const float *enter = c->maps->enter + (size_t)y * 8 * c->maps->side_px + x * 8;
    const float *exit  = c->maps->exit + (size_t)y * 8 * c->maps->side_px + x * 8;
    memset(changes, 0, c->side_vx + 4);
    for (uint32_t n = 0; n < 64; n++) {
        size_t at = (size_t)(n / 8) * c->maps->side_px + n % 8;
        memset(changes + (uint32_t)voxels(c, enter[at]), 1, 3);
        memset(changes + (uint32_t)voxels(c, exit[at]), 1, 3);
    }
    uint64_t lit = 0, dark = 0;
    for (uint32_t k = 0; k < c->side_vx; k++) {
        if (k == 0 || changes[k] || changes[k + 1]) {
            lit = dark = 0;
            for (uint32_t n = 0; n < 64; n++) {
                size_t at = (size_t)(n / 8) * c->maps->side_px + n % 8;
                lit |= (uint64_t)must_be_lit(c, enter[at], k) << n;
                dark |= (uint64_t)must_be_dark(c, exit[at], k) << n;
            }
        }
        vxs_mask mask  = vxs_slice(c->words, c->root, c->levels, c->i0 / 8 + x, c->j0 / 8 + y, k);
        uint64_t found = mask.low | (uint64_t)mask.high << 32;
        t->wrong_shadow += (uint64_t)__builtin_popcountll(found & lit);
        t->wrong_lit += (uint64_t)__builtin_popcountll(~found & dark);
    }
    t->columns += 64;
    t->voxels += (uint64_t)64 * c->side_vx;
}

static void ask_rows(void *user, size_t begin, size_t end, uint32_t worker)
{
    check   *c       = user;
    uint8_t *changes = malloc(c->side_vx + 4);
    if (!changes) {
        c->failed = 1;
        return;
    }
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < c->maps->side_px / 8; x++) ask_tile(c, &c->worker[worker], x, (uint32_t)y, changes);
    free(changes);
}

/* Depths are depths, and a column without a solid is entered and left at once. */
static uint64_t insane_texels(const depth_maps *maps, const depth_maps *solids)
{
    uint64_t count  = 0;
    size_t   texels = (size_t)maps->side_px * maps->side_px;
    float    near = maps->voxel_log == 0 ? 0 : -1, far = near + 1;
    for (size_t n = 0; n < texels; n++) {
        float e = maps->enter[n], x = maps->exit[n];
        count += !(near <= e && e <= x && x <= far) || ((!solids || solids->enter[n] == far) && e != x);
    }
    return count;
}

static void add_tallies(tally *to, const tally *worker)
{
    for (int n = 0; n < PARALLEL_THREADS_MAX; n++) {
        to->columns += worker[n].columns;
        to->voxels += worker[n].voxels;
        to->wrong_lit += worker[n].wrong_lit;
        to->wrong_shadow += worker[n].wrong_shadow;
    }
}

/* A map of a light of the file against depths that are rendered anew. */
static vxs_result check_map(const exact_options *o, const world *w, const vxs_light *light, int map, const uint32_t *words,
                            tally *sum, message *m)
{
    casters         solids_only = w->c;
    depth_renderer *renderer = NULL, *solid_renderer = NULL;
    depth_maps      maps = {0}, solids = {0};
    vxs_result      r;
    uint32_t        side      = 1u << light->levels;
    uint32_t        tile      = side < TILE_MAX_PX ? side : TILE_MAX_PX;
    uint64_t        tiles     = (uint64_t)(side / tile) * (side / tile);
    int             any       = w->c.solid_triangle_count != 0;
    double          voxel_log = light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : light->voxel_metres;
    check          *c         = malloc(sizeof *c);
    if (!c) return fail(m, VXS_E_MEMORY, "out of memory");

    solids_only.triangle_count = solids_only.masked_first = solids_only.solid_triangle_count;
    solids_only.mask_count                                = 0;
    if ((r = depth_renderer_create(&renderer, w->gl, &w->c, light, map, o->bake.exit, o->bake.threads, m)) != VXS_OK) goto done;
    if ((r = depth_maps_init(&maps, tile, side, voxel_log, any, m)) != VXS_OK) goto done;
    if (any && (r = depth_maps_init(&solids, tile, side, voxel_log, 1, m)) != VXS_OK) goto done;

    for (uint64_t n = 0; n < tiles && r == VXS_OK; n++) {
        uint32_t i = (uint32_t)(n % (side / tile)), j = (uint32_t)(n / (side / tile));
        if ((r = depth_renderer_tile(renderer, &maps, i, j, m)) != VXS_OK) break;
        if (any) {
            /* one renderer at a time sets up the context */
            depth_renderer_destroy(renderer);
            renderer = NULL;
            if ((r = depth_renderer_create(&solid_renderer, w->gl, &solids_only, light, map, EXIT_BACK, o->bake.threads, m)) !=
                VXS_OK)
                break;
            if ((r = depth_renderer_tile(solid_renderer, &solids, i, j, m)) != VXS_OK) break;
            depth_renderer_destroy(solid_renderer);
            solid_renderer = NULL;
            if ((r = depth_renderer_create(&renderer, w->gl, &w->c, light, map, o->bake.exit, o->bake.threads, m)) != VXS_OK) break;
        }
        sum->insane += insane_texels(&maps, any ? &solids : NULL);

        *c      = (check){.maps = &maps, .words = words, .levels = light->levels, .side_vx = side, .i0 = i * tile, .j0 = j * tile};
        c->root = light->flags & VXS_LIGHT_CUBE ? words[map] : 0;
        c->seed = rng_split(o->seed + (uint64_t)map, n).state;
        if (o->columns)
            parallel_for(o->bake.threads, o->columns / tiles, 1024, ask_random_columns, c);
        else
            parallel_for(o->bake.threads, tile / 8, 1, ask_rows, c);
        add_tallies(sum, c->worker);
        if (c->failed) r = fail(m, VXS_E_MEMORY, "out of memory");
    }
done:
    free(c);
    depth_maps_free(&maps);
    depth_maps_free(&solids);
    depth_renderer_destroy(renderer);
    depth_renderer_destroy(solid_renderer);
    return r;
}

static vxs_result check_light(const exact_options *o, const world *w, const vxs_light *light, const uint32_t *words, tally *sum,
                              message *m)
{
    int        maps = (int)vxs_light_map_count(light);
    vxs_result r    = VXS_OK;
    for (int map = 0; map < maps && r == VXS_OK; map++) r = check_map(o, w, light, map, words, sum, m);
    sum->maps += (uint64_t)maps;
    return r;
}

/* the bake, with something spoilt
 * ---------------------------------------------------------------------------------------------
 *
 * Each fault is put where it must show, not where it may hide in a voxel that is free. The place is random, by the seed. */

static void spoil_depth(depth_maps *maps, rng *random)
{
    size_t texels = (size_t)maps->side_px * maps->side_px;
    size_t at     = rng_below(random, (uint32_t)texels);
    while (maps->exit[at] >= 1 - 1.0f / (float)maps->depth_vx) at = (at + 1) % texels;
    maps->enter[at] = maps->exit[at] = 1;
}

static void spoil_tile(depth_maps *maps, rng *random)
{
    size_t tiles = (size_t)(maps->side_px / 8) * (maps->side_px / 8);
    size_t at    = rng_below(random, (uint32_t)tiles);
    while (maps->pyramid[0][at].emax <= maps->pyramid[0][at].xmin) at = (at + 1) % tiles;
    maps->pyramid[0][at].emax = maps->pyramid[0][at].xmin;
}

/* The square nearest the light of a larger one that is looked into: there it must be dark somewhere. */
static void spoil_square(depth_maps *maps, rng *random)
{
    uint32_t level = 1 + rng_below(random, maps->pyramid_levels - 3);
    uint32_t side  = maps->side_px >> (3 + level);
    for (size_t at = rng_below(random, side * side);; at = (at + 1) % ((size_t)side * side)) {
        column_bounds *square = &maps->pyramid[level][at];
        column_bounds *parent = &maps->pyramid[level + 1][at / side / 2 * (side / 2) + at % side / 2];
        if (square->xmin != parent->xmin || parent->emax <= parent->xmin) continue;
        square->xmin = square->emax = maps->depth_vx;
        return;
    }
}

/* The tiles of a sub-DAG in turn, from a random one on, until one of them can be spoilt. */
static int spoil_some_tile(tile_masks *t, const column_source *source, uint32_t i, uint32_t j, rng *random,
                           int (*spoil)(tile_masks *t, uint32_t tile, const column_tile *columns))
{
    uint32_t tiles = t->side_tiles * t->side_tiles;
    uint32_t at    = rng_below(random, tiles);
    for (uint32_t n = 0; n < tiles; n++, at = (at + 1) % tiles) {
        column_tile columns;
        source->tile(source->data, i + at % t->side_tiles, j + at / t->side_tiles, &columns);
        if (t->first[at] < t->first[at + 1] && spoil(t, at, &columns)) return 1;
    }
    return 0;
}

/* A tile's first run starts at xmin: a texel with that exit depth has to be dark in it. */
static int spoil_mask(tile_masks *t, uint32_t tile, const column_tile *columns)
{
    uint32_t texel = 0;
    while (columns->x[texel] != t->xmin[tile]) texel++;
    t->mask[t->first[tile]] &= ~((uint64_t)1 << texel);
    return 1;
}

/* The first run goes on to where a texel that it leaves lit has to be dark. */
static int spoil_until(tile_masks *t, uint32_t tile, const column_tile *columns)
{
    uint32_t run = t->first[tile], x = t->emax[tile];
    for (uint32_t n = 0; n < 64; n++)
        if (!(t->mask[run] >> n & 1) && columns->x[n] < x) x = columns->x[n];
    if (x == t->emax[tile]) return 0;
    t->until[run] = x + 1;
    return 1;
}

/* A child that is a node or a mask has voxels that must be dark: else it would have been lit. */
static int spoil_node(dag *d, uint32_t level, rng *random)
{
    dag_level *l = &d->level[level];
    if (!l->count) return 0;
    for (uint32_t at = rng_below(random, l->count * 8);; at = (at + 1) % (l->count * 8)) {
        uint32_t *child = &l->nodes[at / 8].child[at % 8];
        if (*child < REF_FIRST) continue;
        *child = REF_LIT;
        return 1;
    }
}

/* One sub-DAG as bake.c makes it; *left counts the faults still to be planted. */
static vxs_result build_sub(const exact_options *o, const column_source *source, uint32_t sub_px, uint32_t i, uint32_t j,
                            dag_merger *merger, int *left, rng *random)
{
    tile_masks masks = {0};
    dag        d     = {0};
    uint32_t   tiles = sub_px / 8, levels = 1;
    vxs_result r;
    while (8u << (levels - 1) < sub_px) levels++;

    if ((r = tile_masks_build(&masks, source, i * tiles, j * tiles, tiles, o->bake.rule)) != VXS_OK) goto done;
    if (*left && o->fault == FAULT_MASK) *left -= spoil_some_tile(&masks, source, i * tiles, j * tiles, random, spoil_mask);
    if (*left && o->fault == FAULT_UNTIL) *left -= spoil_some_tile(&masks, source, i * tiles, j * tiles, random, spoil_until);
    if ((r = dag_insert(&d, source, i, j, levels, &masks, o->bake.reuse)) != VXS_OK) goto done;
    uint32_t level = rng_below(random, levels);
    if (*left && o->fault == FAULT_INSERTED) *left -= spoil_node(&d, level, random);
    if (o->bake.stop != STOP_INSERT &&
        (r = dag_compress(&d, o->bake.compress == COMPRESS_CHOICE_BOTTOM_UP ? COMPRESS_BOTTOM_UP : COMPRESS_TOP_DOWN)) != VXS_OK)
        goto done;
    if (*left && o->fault == FAULT_COMPRESSED) *left -= spoil_node(&d, level, random);
    r = dag_merger_add(merger, &d, 0, i, j);
done:
    tile_masks_free(&masks);
    dag_free(&d);
    return r;
}

static vxs_result build_dag(const exact_options *o, const world *w, const vxs_light *light, dag *out, message *m)
{
    rng             random   = rng_split(o->seed, 1);
    depth_renderer *renderer = NULL;
    dag_merger     *merger   = NULL;
    depth_maps      maps     = {0};
    vxs_result      r;
    uint32_t        side = 1u << light->levels, sub = side / 4 < SUB_DAG_MAX_PX ? side / 4 : SUB_DAG_MAX_PX;
    int             faults = o->fault != FAULT_STAGES && o->fault != FAULT_WORD;

    if ((r = depth_renderer_create(&renderer, w->gl, &w->c, light, 0, o->bake.exit, o->bake.threads, m)) != VXS_OK) goto done;
    if ((r = depth_maps_init(&maps, side, side, 0, w->c.solid_triangle_count != 0, m)) != VXS_OK) goto done;
    if ((r = dag_merger_create(&merger, side, sub, 1, o->bake.stop == STOP_FINAL)) != VXS_OK) goto done;
    if ((r = depth_renderer_tile(renderer, &maps, 0, 0, m)) != VXS_OK) goto done;
    if (o->fault == FAULT_DEPTH) spoil_depth(&maps, &random);
    depth_maps_reduce(&maps, o->bake.threads);
    if (o->fault == FAULT_TILE) spoil_tile(&maps, &random);
    if (o->fault == FAULT_SQUARE) spoil_square(&maps, &random);

    column_source source = depth_maps_columns(&maps);
    uint32_t      count = (side / sub) * (side / sub), first = rng_below(&random, count);
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        uint32_t at = (first + n) % count;
        r           = build_sub(o, &source, sub, at % (side / sub), at / (side / sub), merger, &faults, &random);
    }
    if (r == VXS_OK) r = dag_merger_finish(merger, out);
    if (r == VXS_OK && o->fault == FAULT_MERGED) spoil_node(out, out->level_count - 1, &random);
done:
    dag_merger_destroy(merger);
    depth_maps_free(&maps);
    depth_renderer_destroy(renderer);
    return r;
}

static vxs_result build_file(const world *w, const exact_options *o, vxs_bytes *file, message *m)
{
    light_choice    chosen = {0};
    vxs_write_light out;
    dag             d = {0};
    vxs_result      r;
    memset(&out, 0, sizeof out);
    if ((r = lights_choose(&w->s, &o->bake.light_names, o->bake.sun_given, o->bake.sun, &chosen, m)) != VXS_OK) return r;
    if (chosen.lights[0].shape.kind != LIGHT_DIRECTIONAL) {
        r = fail(m, VXS_E_ARGUMENT, "--fault: the first light is not directional");
        goto done;
    }
    light_fit_desc fit = {.name = chosen.lights[0].name, .shape = &chosen.lights[0].shape, .resolution = o->bake.resolution};
    if ((r = light_fit(&out.light, &w->c, &fit, m)) != VXS_OK) goto done;
    if ((r = build_dag(o, w, &out.light, &d, m)) != VXS_OK) goto done;

    out.dag             = dag_view_of(&d);
    vxs_write_desc desc = {.lights = &out, .light_count = 1, .zstd_level = 1};
    if ((r = vxs_write(file, &desc)) != VXS_OK) fail(m, r, "the asset cannot be encoded");
done:
    dag_free(&d);
    light_choice_free(&chosen);
    return r;
}

/* A child of a root that was a node of its own becomes lit: of the first of six that has one. */
static void spoil_word(uint32_t *words, const vxs_light *light)
{
    uint32_t root = light->flags & VXS_LIGHT_CUBE ? words[0] : 0;
    for (uint32_t map = 1; map < VXS_CUBE_FACES && light->flags & VXS_LIGHT_CUBE && !vxs_own(words[root]); map++) root = words[map];
    uint32_t own = vxs_own(words[root]);
    words[root] &= ~(2u * (own & (0u - own)));
}

/* the three ways to an asset
 * ---------------------------------------------------------------------------------------------------- */

static vxs_result bake_asset(exact_options *o, vxs_asset **asset, message *m)
{
    bake_report report   = {0};
    const char *tmp      = getenv("TMPDIR");
    char        dir[512] = "", path[600];
    snprintf(dir, sizeof dir, "%s/exact-XXXXXX", tmp && *tmp ? tmp : "/tmp");
    if (!mkdtemp(dir)) return fail(m, VXS_E_WRITE, "%s: cannot make a folder", dir);
    snprintf(path, sizeof path, "%s/asset.vxs", dir);
    o->bake.scene_path  = o->scene_path;
    o->bake.output_path = path;
    vxs_result r        = bake(&o->bake, &report, m);
    if (r == VXS_OK) r = asset_open(asset, path, m);
    bake_report_free(&report);
    unlink(path);
    rmdir(dir);
    return r;
}

/* The lights of a plan, each as bake() bakes one. */
static vxs_result planned_asset(const world *w, const exact_options *o, const bake_plan *plan, vxs_asset **asset, message *m)
{
    size_t           count  = plan->light_count;
    bake_report      report = {0};
    vxs_write_light *lights = calloc(count, sizeof *lights);
    dag             *dags   = calloc(count, sizeof *dags);
    vxs_bytes        file   = {0};
    vxs_result       r      = VXS_E_MEMORY;
    report.lights           = calloc(count, sizeof *report.lights);
    if (!lights || !dags || !report.lights) goto done;

    light_baker baker = {.options = &o->bake, .plan = plan, .gl = w->gl, .casters = &w->c, .report = &report};
    for (size_t n = 0; n < count; n++) {
        uint32_t      at    = report.light_count;
        light_report *light = &report.lights[at];
        baseline      base  = {0};
        if (plan->lights[n].left_out) continue;
        r = bake_light(&baker, &plan->lights[n], &dags[at], &base, NULL, light, m);
        baseline_free(&base);
        if (r != VXS_OK) goto done;
        lights[report.light_count++] = (vxs_write_light){.light = light->light, .dag = dag_view_of(&dags[at])};
    }
    vxs_write_desc desc = {.lights = lights, .light_count = report.light_count, .zstd_level = 1};
    if ((r = vxs_write(&file, &desc)) != VXS_OK || (r = vxs_asset_open(asset, file.data, file.size_bytes, NULL)) != VXS_OK)
        fail(m, r, "the asset cannot be written and read back");
done:
    for (size_t n = 0; n < count && dags; n++) dag_free(&dags[n]);
    free(report.lights);
    free(dags);
    free(lights);
    free(file.data);
    return r;
}

/* The lights of the command line; those that reach no caster are left out. */
static vxs_result lamps_asset(world *w, const exact_options *o, vxs_asset **asset, message *m)
{
    light_choice chosen = {0};
    bake_plan    plan   = {0};
    vxs_result   r;
    if ((r = lights_choose(&w->s, &o->bake.light_names, 0, o->bake.sun, &chosen, m)) != VXS_OK) goto done;
    if ((r = plan_make(&plan, &o->bake, &w->c, &chosen, 0, m)) != VXS_OK) goto done;
    r = planned_asset(w, o, &plan, asset, m);
done:
    plan_free(&plan);
    light_choice_free(&chosen);
    return r;
}

static vxs_result spoilt_asset(const world *w, const exact_options *o, vxs_asset **asset, message *m)
{
    vxs_bytes  file = {0};
    vxs_result r;
    if (o->bake.resolution < 64 || o->bake.resolution > TILE_MAX_PX)
        return fail(m, VXS_E_ARGUMENT, "--fault needs --resolution 64 to %d", TILE_MAX_PX);
    if ((r = build_file(w, o, &file, m)) == VXS_OK && (r = vxs_asset_open(asset, file.data, file.size_bytes, NULL)) != VXS_OK)
        fail(m, r, "the asset cannot be read back");
    free(file.data);
    return r;
}

static vxs_result check_asset(const exact_options *o, const world *w, const vxs_asset *asset, tally *sum, message *m)
{
    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < vxs_asset_light_count(asset) && r == VXS_OK; n++) {
        const vxs_light *light  = &vxs_asset_light(asset, n)->light;
        const vxs_dag   *stored = &vxs_asset_light(asset, n)->dag;
        uint32_t        *words  = malloc((size_t)stored->word_count * sizeof *words);
        if (!words) return fail(m, VXS_E_MEMORY, "out of memory");
        memcpy(words, stored->words, (size_t)stored->word_count * sizeof *words);
        if (o->fault == FAULT_WORD) spoil_word(words, light);
        r = check_light(o, w, light, words, sum, m);
        free(words);
    }
    return r;
}

/* the command line
 * ------------------------------------------------------------------------------------------------------------ */

static vxs_result parse(exact_options *o, int argc, char **argv, int *help_shown, message *m)
{
    int         closed = CLOSED_AUTO, exit_choice = EXIT_AUTO, rule = MASK_RULE_GREEDY, stop = STOP_FINAL, reuse = 0;
    int         compress = COMPRESS_CHOICE_AUTO, planted = FAULT_NONE;
    const char *columns = "all";

    const option options[] = {
        {"--sun", OPTION_VECTOR, o->bake.sun, 0, 3, NULL, "X,Y,Z", "as bake", &o->bake.sun_given},
        {"--light", OPTION_TEXTS, &o->bake.light_names, 0, 0, NULL, "NAME", "as bake", NULL},
        {"--spot", OPTION_TEXTS, &o->spots, 0, 0, NULL, "X,Y,Z,DX,DY,DZ,DEGREES[,RANGE]", "a spot light", NULL},
        {"--point", OPTION_TEXTS, &o->points, 0, 0, NULL, "X,Y,Z[,RANGE]", "a point light", NULL},
        {"--resolution", OPTION_U32, &o->bake.resolution, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX, NULL, "N", "as bake (default 512)",
         NULL},
        {"--exit", OPTION_CHOICE, &exit_choice, 0, 0, "auto|peel|back", NULL, "as bake", NULL},
        {"--closed", OPTION_CHOICE, &closed, 0, 0, CLOSED_CHOICES, NULL, "as bake", NULL},
        {"--rule", OPTION_CHOICE, &rule, 0, 0, "greedy|shadow", NULL, "as bake", NULL},
        {"--reuse", OPTION_CHOICE, &reuse, 0, 0, "on|off", NULL, "as bake", NULL},
        {"--compress", OPTION_CHOICE, &compress, 0, 0, COMPRESS_CHOICES, NULL, "as bake", NULL},
        {"--stop", OPTION_CHOICE, &stop, 0, 0, "insert|partial|final", NULL, "as bake", NULL},
        {"--threads", OPTION_U32, &o->bake.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "as bake", NULL},
        {"--columns", OPTION_TEXT, &columns, 0, 0, NULL, "COUNT", "random columns to look at, or all (default)", NULL},
        {"--seed", OPTION_U32, &o->seed, 0, UINT32_MAX, NULL, "S", "other columns, other places for a fault (default 1)", NULL},
        {"--fault", OPTION_CHOICE, &planted, 0, 0, fault_names, NULL, "spoil one thing", NULL},
    };
    const command_line line = {"exact",
                               "SCENE [options]",
                               "Bake a scene and compare voxels with its depth maps.",
                               options,
                               sizeof options / sizeof *options,
                               1};
    vxs_result         r    = options_parse(&line, argc, argv, &o->scene_path, help_shown, m);
    if (r != VXS_OK) return r;
    if (o->bake.resolution & (o->bake.resolution - 1))
        return fail(m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two", o->bake.resolution);
    if (strcmp(columns, "all")) {
        char *end;
        o->columns = strtoull(columns, &end, 10);
        if (*end || !o->columns) return fail(m, VXS_E_ARGUMENT, "--columns %s: expected all or a number from 1", columns);
    }
    o->bake.closed   = (closed_mode)closed;
    o->bake.exit     = (exit_mode)exit_choice;
    o->bake.rule     = (mask_rule)rule;
    o->bake.reuse    = reuse == 0;
    o->bake.compress = (compress_choice)compress;
    o->bake.stop     = (stop_stage)stop;
    o->fault         = (fault)planted;
    if (lamps_asked_for(o) &&
        (o->bake.sun_given || o->bake.light_names.count || (o->fault != FAULT_NONE && o->fault != FAULT_WORD)))
        return fail(m, VXS_E_ARGUMENT, "--spot and --point: not with --sun, --light or a --fault but word");
    return VXS_OK;
}

static int print_result(const exact_options *o, const tally *t)
{
    json_t *line =
        json_pack("{s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "scene", o->scene_path, "resolution", (json_int_t)o->bake.resolution,
                  "maps", (json_int_t)t->maps, "columns", (json_int_t)t->columns, "voxels", (json_int_t)t->voxels, "wrong_lit",
                  (json_int_t)t->wrong_lit, "wrong_shadow", (json_int_t)t->wrong_shadow, "insane_depths", (json_int_t)t->insane);
    int failed = !line || json_dumpf(line, stdout, JSON_COMPACT) || puts("") < 0 || fflush(stdout);
    json_decref(line);
    return !failed && !t->wrong_lit && !t->wrong_shadow && !t->insane && t->columns;
}

int main(int argc, char **argv)
{
    exact_options o     = {.bake = {.resolution = 512, .zstd_level = 1, .baseline = BASELINE_OFF}, .seed = 1};
    world         w     = {0};
    vxs_asset    *asset = NULL;
    tally         sum   = {0};
    message       m     = {.quiet = 1};
    int           help_shown, right = 1;
    vxs_result    r;

    o.bake.threads = parallel_default_threads();
    if ((r = parse(&o, argc, argv, &help_shown, &m)) != VXS_OK || help_shown) goto done;
    int lamps = lamps_asked_for(&o) != 0;
    if (!lamps && o.fault == FAULT_NONE && (r = bake_asset(&o, &asset, &m)) != VXS_OK) goto done;
    if ((r = world_load(&w, &o, &m)) != VXS_OK) goto done;
    if (lamps && (r = lamps_asset(&w, &o, &asset, &m)) != VXS_OK) goto done;
    if (!lamps && o.fault != FAULT_NONE && (r = spoilt_asset(&w, &o, &asset, &m)) != VXS_OK) goto done;
    if ((r = check_asset(&o, &w, asset, &sum, &m)) != VXS_OK) goto done;
    right = print_result(&o, &sum);
done:
    vxs_asset_close(asset);
    world_free(&w);
    free(o.spots.items);
    free(o.points.items);
    int status = command_end(&m, r);
    return status ? status : !right;
}
