# Lookups that a shader repeats: places in lights of the golden files, and C's answers there. A program writes the buffers of a
# shader, and the answers, for one light and one filter:
#
#     words             uint32: the words of all lights of the file, and four more
#     lights            their vxs_light_constants
#     voxels            8 floats a place: i, j, k, 0, map, across, down, 0 (vxs_place)
#     voxels_answers    2 numbers each: uint32 shadowed texels (of a smooth filter, in 1/65536), float vxs_lit_at_place
#     points            8 floats a point in world space: position, 0, normal, 0
#     points_answers    32 floats each: vxs_lookup there, and at 31 points that lie at most 2^-20 of the map's side away
#     rays              8 floats a ray between two points: begin, 0, way to its end, 0
#     rays_answers      32 floats each: the lit part of its length, and of 31 rays whose ends lie as far away
# SPDX-License-Identifier: GPL-3.0-or-later
import pathlib
import struct
import subprocess

from conftest import EVERY, ROOT

LAVAPIPE = next(iter(sorted(pathlib.Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))), None)  # a driver on the processor
COUNT = 1024
# (file, number of the light): blocks of a sun of 512 and of 8192 texels, slanted planes, a cube; DAGs of two suns, of a spot light,
# of two cubes
LIGHTS = [("blocks", 0), ("blocks", 1), ("blocks", 2), ("blocks", 3), ("sample", 0), ("sample", 1), ("lamps", 0), ("lamps", 1), ("lamps", 2)]
WIDTHS = [1, 9, -4, -16]  # negative: smooth
CASES = [(*light, width) for n, light in enumerate(LIGHTS) for m, width in enumerate(WIDTHS) if EVERY or (n + m) % 4 == 0]

SOURCE = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vxs.h>
#include <vxs_query.h>
#include <vxs_space.h>

enum { BESIDE = 31 };

static int32_t random_below(int32_t n)
{
    static uint64_t state = 7;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (int32_t)(state >> 33) % n;
}

static const char *const names[] = {"words", "lights", "voxels", "voxels_answers", "points", "points_answers", "rays", "rays_answers"};
enum { WORDS, LIGHTS, VOXELS, VOXELS_ANSWERS, POINTS, POINTS_ANSWERS, RAYS, RAYS_ANSWERS, FILES };
static FILE *files[FILES];

static void put(int file, const void *bytes, size_t size)
{
    if (!files[file]) files[file] = fopen(names[file], "wb");
    if (!files[file] || fwrite(bytes, 1, size, files[file]) != size) exit(1);
}

static void put_voxel(const vxs_baked_light *l, vxs_place place, vxs_filter pcf)
{
    const int32_t *at    = place.voxel;
    float          lit   = (float)vxs_lit_at_place(l->words, &l->light, place, pcf);
    uint32_t       k     = (uint32_t)at[2];
    uint32_t       dark  = pcf.is_smooth ? vxs_shadow_part(l->words, &l->light, place, k, pcf.width_px)
                                         : vxs_shadow_taps(l->words, &l->light, place.map, at[0], at[1], k, pcf.width_px);
    put(VOXELS, (float[8]){(float)at[0], (float)at[1], (float)at[2], 0, (float)place.map, (float)place.across, (float)place.down, 0}, 32);
    put(VOXELS_ANSWERS, &dark, 4);
    put(VOXELS_ANSWERS, &lit, 4);
}

/* A point of the map: at, or one beside it. */
static void point_beside(const vxs_baked_light *l, int map, const double at[3], int n, double ws[3])
{
    double beside[3];
    for (int c = 0; c < 3; c++) beside[c] = at[c] + (n > 0) * (random_below(3) - 1) * ldexp(1, (int)l->light.levels - 20 - random_below(4));
    vxs_point(&l->light, map, beside, ws);
}

static double in_voxel(const vxs_place *place, int axis)
{
    return place->voxel[axis] + random_below(1 << 20) * 0x1p-20;
}

/* A point in the voxel of a place, and C's answers there and at points beside it: a shader's coordinates are floats of 24 bits,
 * and it may look up any of them. */
static void put_point(const vxs_baked_light *l, vxs_place place, vxs_filter pcf)
{
    double at[3], ws[3], normal[3] = {0};
    float  stored[8] = {0}, answers[1 + BESIDE];
    for (int c = 0; c < 3; c++) at[c] = in_voxel(&place, c);
    vxs_point(&l->light, place.map, at, ws);
    for (int c = 0; c < 3; c++) {
        stored[c]     = (float)ws[c];
        stored[4 + c] = place.voxel[2] % 3 ? (float)(random_below(201) - 100) : 0;
        ws[c]         = (double)stored[c];
        normal[c]     = (double)stored[4 + c];
    }
    for (int n = 0; n <= BESIDE; n++) {
        if (n) point_beside(l, place.map, at, n, ws);
        answers[n] = vxs_lookup(l, ws, normal, pcf);
    }
    put(POINTS, stored, sizeof stored);
    put(POINTS_ANSWERS, answers, sizeof answers);
}

static float lit_part(const vxs_baked_light *l, const vxs_ray *ray)
{
    vxs_lit_walk walk;
    vxs_interval interval[16];
    double       lit = 0;
    size_t       count;
    if (vxs_lit_begin(&walk, l, ray) != VXS_OK) exit(1);
    do {
        count = vxs_lit_next(&walk, interval, 16);
        for (size_t n = 0; n < count; n++)
            if (interval[n].state == VXS_INTERVAL_LIT) lit += interval[n].t_end - interval[n].t_begin;
    } while (count == 16);
    return (float)lit;
}

/* From a point in the voxel of a place towards that of another, over 512 texels at most: llvmpipe ends the loops of an invocation
 * after 65 535 rounds. */
static void put_ray(const vxs_baked_light *l, vxs_place from, vxs_place to)
{
    double at[3], end[3], there[3], part = fmin(1, ldexp(512, -(int)l->light.levels));
    float  stored[8] = {0}, answers[1 + BESIDE];
    for (int c = 0; c < 3; c++) {
        at[c]  = in_voxel(&from, c);
        end[c] = at[c] + part * (in_voxel(&to, c) - at[c]);
    }
    for (int n = 0; n <= BESIDE; n++) {
        vxs_ray ray = {.t_end = 1};
        point_beside(l, from.map, at, n, ray.origin_ws);
        point_beside(l, to.map, end, n, there);
        for (int c = 0; c < 3; c++) {
            ray.direction_ws[c] = there[c] - ray.origin_ws[c];
            if (n) continue;
            stored[c]           = (float)ray.origin_ws[c];
            stored[4 + c]       = (float)ray.direction_ws[c];
            ray.origin_ws[c]    = (double)stored[c];
            ray.direction_ws[c] = (double)stored[4 + c];
        }
        answers[n] = lit_part(l, &ray);
    }
    put(RAYS, stored, sizeof stored);
    put(RAYS_ANSWERS, answers, sizeof answers);
}

int main(int argc, char **argv)
{
    const double origin_ws[3] = {0, 0, 0};
    vxs_asset   *asset;
    uint32_t     first = 0;
    if (argc != 5 || vxs_asset_open_file(&asset, argv[1], NULL) != VXS_OK) return 1;
    for (uint32_t n = 0; n < vxs_asset_light_count(asset); n++) {
        const vxs_baked_light *l = vxs_asset_light(asset, n);
        vxs_light_constants    c = vxs_light_constants_of(&l->light, origin_ws, first);
        put(WORDS, l->words, 4 * l->word_count);
        put(LIGHTS, &c, sizeof c);
        first += (uint32_t)l->word_count;
    }
    put(WORDS, (uint32_t[4]){0}, 16);

    const vxs_baked_light *l     = vxs_asset_light(asset, (uint32_t)atoi(argv[2]));
    const vxs_light       *light = &l->light;
    int                    width = abs(atoi(argv[3])), smooth = atoi(argv[3]) < 0;
    int32_t                side  = 1 << light->levels;
    vxs_place              last  = {0};
    vxs_filter             pcf   = smooth ? vxs_smooth(width) : vxs_box(width);
    for (int n = 0; n < atoi(argv[4]); n++) {
        vxs_place place = {random_below(light->flags & VXS_LIGHT_CUBE ? 6 : 1), {random_below(side), random_below(side), 0}, 0, 0};
        int32_t  *at    = place.voxel;
        at[2]           = vxs_first_shadow(l, place.map, at[0], at[1], NULL) + random_below(5) - 2; /* where a filter is partly lit */
        if (n % 4 == 0) at[2] = random_below(side);
        put_point(l, place, pcf);
        put_ray(l, place, last);
        last = place;
        if (n % 8 == 0 && (width > 1 || smooth)) at[0] = side * random_below(2) + random_below(24) - 12; /* beside the map, too */
        at[2] = at[2] < 0 ? 0 : at[2] < side ? at[2] : side - 1;
        if (smooth) place.across = (uint32_t)random_below(256), place.down = (uint32_t)random_below(256);
        put_voxel(l, place, pcf);
    }
    return 0;
}
"""


def compile_places(folder, flags):
    """The program, built with what was installed (flags: of pkg-config)."""
    (folder / "places.c").write_text(SOURCE)
    done = subprocess.run(["cc", "-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", folder / "places.c", *flags, "-lm", "-o", folder / "places"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "places"


def write_places(program, folder, name, light, width, libraries):
    """Writes the files into a new folder. Returns voxels, their answers, points, their answers, rays, their answers."""
    folder.mkdir()
    subprocess.run([program, ROOT / "tests" / "golden" / f"{name}.vxs", str(light), str(width), str(COUNT)], cwd=folder,
                   env={"LD_LIBRARY_PATH": str(libraries)}, check=True)
    files = {"voxels": "8f", "voxels_answers": "If", "points": "8f", "points_answers": "32f", "rays": "8f", "rays_answers": "32f"}
    return [list(struct.iter_unpack(row, (folder / file).read_bytes())) for file, row in files.items()]


def as_float(x):
    """The 32-bit float that is nearest to a number."""
    return struct.unpack("f", struct.pack("f", x))[0]


def check_points(found, answers):
    """A shader computes places in floats: each answer is that of a point at most 2^-20 of the map's side away, and most are those of the
    points themselves."""
    assert len(found) == len(answers) > 0
    for x, row in zip(found, answers):
        assert any(abs(x - y) < 1e-6 for y in row), (x, row)
    assert sum(abs(x - row[0]) > 1e-6 for x, row in zip(found, answers)) < len(found) / 50


def check_rays(found, answers):
    """The same of rays: where one touches an edge, its lit part lies between those of rays that miss the edge and meet it."""
    assert len(found) == len(answers) > 0
    for x, row in zip(found, answers):
        assert min(row) - 1e-4 < x < max(row) + 1e-4, (x, row)
    assert sum(abs(x - row[0]) > 1e-5 for x, row in zip(found, answers)) < len(found) / 50
