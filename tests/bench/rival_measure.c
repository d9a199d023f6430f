/* Measuring rivals; see rival_measure.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/rival_measure.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "baker/base/random.h"
#include "runtime/vxs.h"
#include "tests/bench/rival_screen.h"
#include "tests/unit/smooth_box.h"

enum { CHUNK = 65536, FILTERS_CHECKED = 20000, WINDOW_VX = 2, RAY_TAP_SHARE = 10, RAY_FILTER_SHARE = 100 };

/* Of this process, where all runs on one thread: what else the machine does counts little. */
static double seconds_now(uint32_t threads)
{
    struct timespec t;
    clock_gettime(threads > 1 ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* All rivals while they are measured. They take turns, so that what else the machine does, and how warm it is, hits all alike. */
typedef struct contest {
    rival_maps            *maps;
    const measure_options *o;
    rival_result          *results; /* [count] */
    size_t                 count;
    vxs_bytes             *files;          /* [count] */
    rival_asset           *assets;         /* [count] */
    voxel_at              *at[POINT_SETS]; /* [points] */
    size_t                 points[POINT_SETS];
    screen                 picture;
    uint32_t              *dark;  /* [the most points] */
    double                *times; /* [count][runs] of what is measured just now */
} contest;

/* points ----------------------------------------------------------------------------------------------------------------------- */

static voxel_at random_voxel(rng *random, uint32_t levels)
{
    uint32_t side = 1u << levels;
    int32_t  i = (int32_t)rng_below(random, side), j = (int32_t)rng_below(random, side);
    int32_t  k = (int32_t)rng_below(random, side);
    return (voxel_at){i, j, k, rng_below(random, 1 << 16)};
}

static voxel_at *random_points(const contest *c, uint64_t set)
{
    voxel_at *at     = malloc(c->o->points * sizeof *at);
    rng       random = rng_split(c->o->seed, set);
    for (uint32_t n = 0; n < c->o->points && at; n++) at[n] = random_voxel(&random, c->maps->levels);
    return at;
}

/* For a filter of that width. */
static vxs_result look_at_picture(contest *c, vxs_filter filter, run_context *m)
{
    c->points[POINTS_SCREEN] = screen_voxels(&c->picture, filter, c->at[POINTS_SCREEN]);
    return c->points[POINTS_SCREEN] ? VXS_OK
                                    : fail(m, VXS_E_ARGUMENT, "nothing is seen: expected --eye and --target that see the scene");
}

static int32_t clamped(int32_t k, int32_t side)
{
    return k < 0 ? 0 : k >= side ? side - 1 : k;
}

/* Move points along their columns to within a voxel of the first that is in shadow, by bisection: a column is lit, then dark. */
static int move_to_edges(const contest *c, voxel_at *at, const rival *one, const rival_asset *asset)
{
    uint32_t  count  = c->o->points;
    int32_t   side   = 1 << c->maps->levels;
    voxel_at *ask    = malloc(count * sizeof *ask);
    int32_t  *lit    = calloc(count, sizeof *lit); /* voxels in front that are known to be lit */
    rng       random = rng_split(c->o->seed, POINT_SETS);
    int       ok     = ask && lit;
    for (int32_t step = side / 2; step && ok; step /= 2) {
        for (uint32_t n = 0; n < count; n++) ask[n] = (voxel_at){at[n].i, at[n].j, lit[n] + step - 1, 0};
        one->count_dark(asset->state, ask, count, vxs_box(1), c->dark);
        for (uint32_t n = 0; n < count; n++) lit[n] += c->dark[n] ? 0 : step;
    }
    for (uint32_t n = 0; n < count && ok; n++) at[n].k = clamped(lit[n] + rng_between(&random, -1, 1), side);
    free(ask);
    free(lit);
    return ok;
}

/* time ------------------------------------------------------------------------------------------------------------------------- */

static void drop_file(contest *c, size_t n)
{
    free(c->files[n].data);
    c->files[n] = (vxs_bytes){.data = NULL};
}

static vxs_result build(contest *c, size_t n)
{
    const rival *one         = c->results[n].rival;
    vxs_result   r           = one->build ? one->build(c->maps, one->options, &c->files[n]) : VXS_OK;
    c->results[n].file_bytes = c->files[n].size_bytes;
    return r;
}

static void drop_asset(contest *c, size_t n)
{
    if (c->assets[n].state) c->results[n].rival->close(c->assets[n].state);
    c->assets[n] = (rival_asset){.state = NULL};
}

static vxs_result open_file(contest *c, size_t n)
{
    const rival *one           = c->results[n].rival;
    vxs_result   r             = one->open(c->maps, one->options, &c->files[n], &c->assets[n]);
    c->results[n].memory_bytes = c->assets[n].memory_bytes;
    return r;
}

/* Time what is done for each rival, in turns, when what the run before made is gone. What the last run made stays. */
static vxs_result take_turns(contest *c, void (*drop)(contest *, size_t), vxs_result (*make)(contest *, size_t), run_context *m)
{
    for (uint32_t run = 0; run < c->o->runs; run++)
        for (size_t n = 0; n < c->count; n++) {
            drop(c, n);
            double     start               = seconds_now(c->maps->threads);
            vxs_result r                   = make(c, n);
            c->times[n * c->o->runs + run] = seconds_now(c->maps->threads) - start;
            if (r != VXS_OK) return fail(m, r, "%s: %s", c->results[n].rival->name, vxs_result_text(r));
        }
    return VXS_OK;
}

static spread times_of(const contest *c, size_t n)
{
    return spread_of(c->times + n * c->o->runs, c->o->runs);
}

static size_t some_of(size_t points, size_t share)
{
    return points > share ? points / share : 1;
}

static int can_answer(const rival *one, lookup_kind what)
{
    return what != LOOKUP_SMOOTH || one->traits & RIVAL_SMOOTH;
}

static size_t points_asked(const contest *c, size_t n, point_set set, lookup_kind what)
{
    const rival *one = c->results[n].rival;
    if (!can_answer(one, what)) return 0;
    if (!(one->traits & RIVAL_RAYS)) return c->points[set];
    return some_of(c->points[set], what == LOOKUP_TAP ? RAY_TAP_SHARE : RAY_FILTER_SHARE);
}

/* In turns, too. A rival with few points gets those in the middle: of a picture, what it shows. */
static void ask_all(contest *c, point_set set, lookup_kind what)
{
    for (uint32_t run = 0; run < c->o->runs; run++)
        for (size_t n = 0; n < c->count; n++) {
            size_t count = points_asked(c, n, set, what);
            double start = seconds_now(1);
            if (!count) continue;
            c->results[n].rival->count_dark(c->assets[n].state, c->at[set] + (c->points[set] - count) / 2, count,
                                            lookup_filters[what], c->dark);
            c->times[n * c->o->runs + run] = 1e9 * (seconds_now(1) - start) / (double)count;
        }
    for (size_t n = 0; n < c->count; n++) {
        rival_result *r      = &c->results[n];
        r->points[what][set] = points_asked(c, n, set, what);
        if (r->points[what][set]) r->lookup_ns[what][set] = times_of(c, n);
    }
}

/* wrong answers ---------------------------------------------------------------------------------------------------------------- */

/* The voxels to compare: every one of the map by its number, or at random, half of them about the enter and exit depth of their
 * texel. */
static voxel_at voxel_to_check(const rival_maps *maps, uint64_t n, const measure_options *o)
{
    int32_t side = 1 << maps->levels;
    if (!o->voxels) {
        uint64_t texel = n >> maps->levels;
        return (voxel_at){(int32_t)(texel & (uint64_t)(side - 1)), (int32_t)(texel >> maps->levels),
                          (int32_t)(n & (uint64_t)(side - 1)), 0};
    }
    rng      random = rng_split(o->seed + 1, n);
    voxel_at v      = random_voxel(&random, maps->levels);
    if (n % 2) {
        const float *depths = n % 4 == 1 ? maps->checked : maps->checked_exit;
        int32_t      depth  = (int32_t)(depths[((size_t)v.j << maps->levels) + (size_t)v.i] * (float)side);
        v.k                 = clamped(depth + rng_between(&random, -WINDOW_VX, WINDOW_VX), side);
    }
    return v;
}

static int check_taps(const contest *c, rival_result *out, const rival_asset *asset)
{
    uint64_t  all  = c->o->voxels ? c->o->voxels : (uint64_t)1 << 3 * c->maps->levels;
    voxel_at *at   = malloc(CHUNK * sizeof *at);
    uint32_t *dark = malloc(CHUNK * sizeof *dark);
    int       ok   = at && dark;
    for (uint64_t first = 0; first < all && ok; first += CHUNK) {
        size_t count = all - first < CHUNK ? (size_t)(all - first) : CHUNK;
        for (size_t n = 0; n < count; n++) at[n] = voxel_to_check(c->maps, first + n, c->o);
        out->rival->count_dark(asset->state, at, count, vxs_box(1), dark);
        for (size_t n = 0; n < count; n++) {
            int must_be_lit, must_be_dark;
            rival_maps_contract(c->maps, (uint32_t)at[n].i, (uint32_t)at[n].j, (uint32_t)at[n].k, &must_be_lit, &must_be_dark);
            out->wrong_lit += !dark[n] && must_be_dark;
            out->wrong_dark += dark[n] && must_be_lit;
        }
    }
    out->voxels = all;
    free(at);
    free(dark);
    return ok;
}

/* What a tap beside a voxel counts. */
static uint32_t weight_of(lookup_kind what, voxel_at at, int32_t x, int32_t y)
{
    int inside = abs(x - at.i) <= FILTER_PX / 2 && abs(y - at.j) <= FILTER_PX / 2;
    if (what == LOOKUP_BOX) return (uint32_t)inside;
    return smooth_overlap(x, at.i, at.within & 255, FILTER_PX) * smooth_overlap(y, at.j, at.within >> 8, FILTER_PX);
}

static uint32_t sum_of_taps(const rival *one, const rival_asset *asset, lookup_kind what, voxel_at at, int32_t side)
{
    enum { WIDE = FILTER_PX + 2 };
    tap_box  taps             = tap_box_at(at, WIDE, side);
    voxel_at tap[WIDE * WIDE] = {{0}};
    uint32_t dark[WIDE * WIDE], sum = 0;
    size_t   count = 0;
    for (int32_t y = taps.y0; y < taps.y1; y++)
        for (int32_t x = taps.x0; x < taps.x1; x++)
            if (weight_of(what, at, x, y)) tap[count++] = (voxel_at){x, y, at.k, 0};
    one->count_dark(asset->state, tap, count, vxs_box(1), dark);
    for (size_t n = 0; n < count; n++) sum += dark[n] * weight_of(what, at, tap[n].i, tap[n].j);
    return sum;
}

/* In all sets; the first points lie in the corners and on the sides of the map, where taps fall outside. */
static void check_filters(const contest *c, rival_result *out, const rival_asset *asset, lookup_kind what)
{
    int32_t side = 1 << c->maps->levels;
    for (int set = 0; set < POINT_SETS; set++) {
        size_t most  = c->points[set] < FILTERS_CHECKED ? c->points[set] : FILTERS_CHECKED;
        size_t count = some_of(most, out->rival->traits & RIVAL_RAYS ? RAY_FILTER_SHARE : 1);
        out->filters[what] += count;
        for (size_t n = 0; n < count; n++) {
            voxel_at at = c->at[set][n], asked;
            uint32_t dark;
            if (n < 64) at.i = n & 1 ? side - 1 - (int32_t)(n >> 4) : (int32_t)(n >> 4);
            if (n < 32) at.j = n & 2 ? side - 1 - (int32_t)(n >> 3) : (int32_t)(n >> 3);
            asked = at;
            if (c->o->filter_aside) asked.i += at.i + 1 < side ? 1 : -1;
            out->rival->count_dark(asset->state, &asked, 1, lookup_filters[what], &dark);
            out->wrong_filters[what] += dark != sum_of_taps(out->rival, asset, what, at, side);
        }
    }
}

static int contest_begin(contest *c)
{
    size_t pixels = (size_t)c->o->width_px * c->o->height_px;
    c->files      = calloc(c->count, sizeof *c->files);
    c->assets     = calloc(c->count, sizeof *c->assets);
    c->times      = malloc(c->count * c->o->runs * sizeof *c->times);
    c->dark       = malloc((pixels > c->o->points ? pixels : c->o->points) * sizeof *c->dark);
    for (int set = POINTS_VOLUME; set <= POINTS_EDGE; set++) {
        c->at[set]     = random_points(c, (uint64_t)set);
        c->points[set] = c->o->points;
    }
    c->at[POINTS_SCREEN] = malloc(pixels * sizeof *c->at[POINTS_SCREEN]);
    return c->files && c->assets && c->times && c->dark && c->at[POINTS_VOLUME] && c->at[POINTS_EDGE] && c->at[POINTS_SCREEN];
}

static void contest_end(contest *c)
{
    for (size_t n = 0; n < c->count && c->files && c->assets; n++) {
        drop_asset(c, n);
        drop_file(c, n);
    }
    for (int set = 0; set < POINT_SETS; set++) free(c->at[set]);
    screen_close(&c->picture);
    free(c->files);
    free(c->assets);
    free(c->times);
    free(c->dark);
}

vxs_result rivals_measure(rival_result *results, size_t count, rival_maps *maps, const measure_options *o, run_context *m)
{
    contest    c  = {.maps = maps, .o = o, .results = results, .count = count};
    int        ok = contest_begin(&c);
    vxs_result r  = VXS_OK;
    if (!ok) goto done;
    if ((r = take_turns(&c, drop_file, build, m)) != VXS_OK) goto done;
    for (size_t n = 0; n < count; n++)
        if (results[n].rival->build) results[n].build_s = times_of(&c, n);
    if ((r = take_turns(&c, drop_asset, open_file, m)) != VXS_OK) goto done;
    for (size_t n = 0; n < count; n++) results[n].open_s = times_of(&c, n);

    if (!(ok = move_to_edges(&c, c.at[POINTS_EDGE], results[0].rival, &c.assets[0]))) goto done;
    if ((r = screen_open(&c.picture, maps, &o->camera.camera, o->width_px, o->height_px, m)) != VXS_OK) goto done;
    for (lookup_kind what = LOOKUP_TAP; what < LOOKUP_KINDS; what++) {
        if ((r = look_at_picture(&c, lookup_filters[what], m)) != VXS_OK) goto done;
        for (int set = 0; set < POINT_SETS; set++) ask_all(&c, set, what);
    }

    for (size_t n = 0; n < count && ok; n++) {
        ok = check_taps(&c, &results[n], &c.assets[n]);
        for (lookup_kind what = LOOKUP_BOX; what < LOOKUP_KINDS; what++)
            if (can_answer(results[n].rival, what)) check_filters(&c, &results[n], &c.assets[n], what);
    }
done:
    contest_end(&c);
    return ok ? r : fail(m, VXS_E_MEMORY, "out of memory for measuring");
}
