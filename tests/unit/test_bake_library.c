/* The bake library: options that make no sense, steps, bakes that are given up, several at once, and what a program has to be left
 * alone with.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/vxs_bake.h"

#include <dirent.h>
#include <fenv.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* a scene --------------------------------------------------------------------------------------------------------------------- */

enum { BOXES = 60, CORNERS = 8, SIDES = 12 };

static float         positions[BOXES * CORNERS * 3];
static uint32_t      indices[BOXES * SIDES * 3];
static vxs_bake_mesh town = {
    .positions = positions, .indices = indices, .vertex_count = BOXES * CORNERS, .triangle_count = BOXES * SIDES};

static const vxs_bake_light  punctuals[]    = {{"lamp", VXS_BAKE_SPOT, {0, 30, 0}, {0, -1, 0}, 0.825335614909678, 60},
                                               {"bulb", VXS_BAKE_POINT, {4, 14, 3}, {0, 0, 0}, 0, 0}};
static const vxs_bake_arrays town_only      = {.meshes = &town, .mesh_count = 1};
static const vxs_bake_arrays town_punctuals = {.meshes = &town, .mesh_count = 1, .lights = punctuals, .light_count = 2};
static const vxs_bake_sun    noon = {NULL, {0.3, -1, 0.1}}, evening = {"evening", {1, -0.4, 0.2}};

static void make_town(void)
{
    static const uint8_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}};
    for (uint32_t b = 0; b < BOXES; b++) {
        float low[3]  = {(float)(b % 8) * 5 - 20, 0, (float)(b / 8) * 5 - 20};
        float high[3] = {low[0] + 3, 2 + (float)(b * 7 % 11), low[2] + 2 + (float)(b % 3)};
        if (!b) { /* the ground */
            for (int axis = 0; axis < 3; axis++) low[axis] = axis == 1 ? -1 : -40, high[axis] = axis == 1 ? -0.5f : 40;
        }
        for (uint32_t c = 0; c < CORNERS; c++)
            for (uint32_t axis = 0; axis < 3; axis++)
                positions[(b * CORNERS + c) * 3 + axis] = c >> axis & 1 ? high[axis] : low[axis];
        for (uint32_t f = 0; f < 6; f++)
            for (uint32_t k = 0; k < 6; k++)
                indices[(b * SIDES + 2 * f) * 3 + k] = b * CORNERS + faces[f][(uint8_t[]){0, 1, 2, 0, 2, 3}[k]];
    }
}

/* What was logged since the last reset; for bakes whose options have log = keep. */
typedef struct logged {
    uint32_t errors, warnings;
    char     error[1024];
} logged;

static logged kept;

static void keep(vxs_severity severity, const char *text, void *user)
{
    (void)user;
    assert_true(text[0] && !strchr(text, '\n'));
    assert_true(severity == VXS_SEVERITY_ERROR || severity == VXS_SEVERITY_WARNING);
    if (severity == VXS_SEVERITY_WARNING)
        kept.warnings++;
    else {
        kept.errors++;
        snprintf(kept.error, sizeof kept.error, "%s", text);
    }
}

/* Each failure logs one error text that contains `words`.
 * words  NULL: the options have no valid struct_size, so the library cannot know where `log` is */
static void assert_logged(const char *words)
{
    if (!words)
        assert_int_equal(kept.errors, 0);
    else if (kept.errors != 1 || !strstr(kept.error, words))
        fail_msg("%u errors, '%s': expected '%s'", kept.errors, kept.error, words);
    kept = (logged){.errors = 0};
}

static vxs_bake_options town_options(void)
{
    vxs_bake_options o = vxs_bake_defaults();
    o.arrays           = &town_only;
    o.suns             = &noon;
    o.sun_count        = 1;
    o.resolution       = 1024;
    o.threads          = 2;
    o.log              = keep;
    return o;
}

static vxs_bake_bytes baked(const vxs_bake_options *o)
{
    vxs_bake_bytes file;
    kept = (logged){.errors = 0};
    if (vxs_bake(o, &file) != VXS_OK) fail_msg("%s", kept.error);
    assert_int_equal(kept.errors, 0);
    assert_true(file.size_bytes > 100);
    return file;
}

static void assert_same(vxs_bake_bytes *a, const vxs_bake_bytes *wanted)
{
    assert_int_equal(a->size_bytes, wanted->size_bytes);
    assert_memory_equal(a->data, wanted->data, wanted->size_bytes);
    vxs_bake_bytes_free(a);
    assert_null(a->data);
}

/* options --------------------------------------------------------------------------------------------------------------------- */

static void refused(const vxs_bake_options *o, vxs_result wanted, const char *words)
{
    vxs_bake_job  *job = (vxs_bake_job *)o;
    vxs_bake_bytes file;
    kept         = (logged){.errors = 0};
    vxs_result r = vxs_bake(o, &file);
    if (r != wanted) fail_msg("%d, '%s': expected %d, '%s'", r, kept.error, wanted, words);
    assert_logged(words);
    assert_null(file.data);
    if (vxs_bake_job_open(&job, o) == VXS_OK) {
        vxs_bake_job_close(job);
        assert_int_equal(kept.errors, 0);
    } else {
        assert_null(job);
        assert_logged(words);
    }
}

#define REFUSED(change, words)                                                                                                     \
    do {                                                                                                                           \
        vxs_bake_options o = town_options();                                                                                       \
        change;                                                                                                                    \
        refused(&o, VXS_E_ARGUMENT, words);                                                                                        \
    } while (0)

static void test_options_out_of_range(void **state)
{
    (void)state;
    static const char *const nobody[] = {"nobody", NULL};
    vxs_bake_sun             sun = {"sun", {0, -1, 0}}, twice[2] = {noon, {"sun", {1, -1, 0}}};
    vxs_bake_map_size        size = {"sun", 64, 0};
    char                     long_name[65];
    memset(long_name, 'n', 64);
    long_name[64] = 0;
    REFUSED(o.struct_size = 0, NULL);
    REFUSED(o.struct_size = offsetof(vxs_bake_options, blend) - 1, NULL); /* less than the first version had */
    REFUSED(o.struct_size = SIZE_MAX, NULL);
    refused(NULL, VXS_E_ARGUMENT, NULL);
    REFUSED(o.arrays = NULL, "one of scene_path, arrays and scene");
    REFUSED(o.scene_path = "a.glb", "one of scene_path, arrays and scene");
    REFUSED(o.arrays = NULL; o.scene_path = "-", "scene_path '-'");
    REFUSED(o.output_path = "-", "output_path '-'");
    REFUSED(o.output_path = "", "output_path ''");
    REFUSED(o.if_changed = 1, "if_changed");
    REFUSED(o.resolution = 1, "resolution 1");
    REFUSED(o.resolution = 1000, "resolution 1000");
    REFUSED(o.resolution = 524288, "resolution 524288");
    REFUSED(o.resolution = UINT32_MAX, "resolution 4294967295");
    REFUSED(o.texel_metres = 0.5, "exclude each other");
    REFUSED(o.resolution = 0; o.texel_metres = NAN, "texel_metres");
    REFUSED(o.resolution = 0; o.texel_metres = -1, "texel_metres -1");
    REFUSED(o.resolution = 0; o.texel_metres = INFINITY, "texel_metres inf");
    REFUSED(o.resolution = 0; o.texel_metres = 1e-30, "texel_metres 1e-30");
    REFUSED(o.threads = 257, "threads 257");
    REFUSED(o.thickness_metres = NAN, "thickness_metres");
    REFUSED(o.thickness_metres = -1, "thickness_metres -1");
    REFUSED(o.thickness_metres = INFINITY, "thickness_metres inf");
    REFUSED(o.zstd_level = 20, "zstd_level 20");
    REFUSED(o.closed = 3, "closed 3");
    REFUSED(o.exit = 99, "exit 99");
    REFUSED(o.coding = 2, "coding 2");
    REFUSED(o.pack = 2, "pack 2");
    REFUSED(o.skinned = 2, "skinned 2");
    REFUSED(o.blend = 3, "blend 3");
    REFUSED(o.coding = VXS_BAKE_DAG; o.pack = VXS_BAKE_PACK_FAST, "pack");
    REFUSED(o.has_region = 1, "region_ws");
    REFUSED(o.has_region = 1; o.region_ws[3] = o.region_ws[4] = 1; o.region_ws[5] = NAN, "axis z");
    REFUSED(o.has_region = 1; o.region_ws[3] = o.region_ws[4] = 1; o.region_ws[5] = INFINITY, "axis z");
    REFUSED(o.suns = NULL, "no array");
    REFUSED(o.suns = &sun; sun.direction_ws[1] = 0, "sun 'sun'");
    REFUSED(o.suns = &sun; sun.direction_ws[1] = NAN, "sun 'sun'");
    REFUSED(o.suns = &sun; sun.direction_ws[1] = -INFINITY, "sun 'sun'");
    sun.direction_ws[1] = -1;
    REFUSED(o.suns = &sun; sun.name = "", "sun 0");
    REFUSED(o.suns = &sun; sun.name = long_name, "sun 0");
    REFUSED(o.suns = &sun; sun.name = "\xff", "sun 0");
    REFUSED(o.suns = twice; o.sun_count = 2, "twice");
    REFUSED(o.light_names = nobody; o.light_name_count = 1, "nobody");
    REFUSED(o.light_names = nobody; o.light_name_count = 2, "item 1");
    REFUSED(o.light_names = NULL; o.light_name_count = SIZE_MAX, "no array");
    REFUSED(o.map_sizes = &size; o.map_size_count = 1; size.light_name = NULL, "names no light");
    REFUSED(o.map_sizes = &size; o.map_size_count = 1; size.light_name = "moon", "moon");
    size.light_name = "sun";
    REFUSED(o.map_sizes = &size; o.map_size_count = 1; size.resolution = 0, "expected a resolution");
    REFUSED(o.map_sizes = &size; o.map_size_count = 1; size.texel_metres = -0.1, "texel_metres -0.1");
    REFUSED(o.exclude = nobody; o.exclude_count = 1, "choose from a file");
    vxs_bake_options o = town_options();
    assert_int_equal(vxs_bake(&o, NULL), VXS_E_ARGUMENT); /* no output */
    assert_logged("output_path");
    o.log = NULL;
    assert_int_equal(vxs_bake(&o, NULL), VXS_E_ARGUMENT);
}

/* What a later library has more is 0, or refused. */
static void test_options_of_later_versions(void **state)
{
    (void)state;
    struct {
        vxs_bake_options o;
        uint64_t         later;
    } options               = {town_options(), 0};
    options.o.struct_size   = sizeof options;
    vxs_bake_options o      = town_options();
    vxs_bake_bytes   wanted = baked(&o), file = baked(&options.o);
    assert_same(&file, &wanted);
    options.later = 1;
    refused(&options.o, VXS_E_ARGUMENT, "later version");
    vxs_bake_bytes_free(&wanted);
}

static void test_arrays_that_are_no_scene(void **state)
{
    (void)state;
    vxs_bake_mesh   mesh       = town;
    vxs_bake_light  lights[2]  = {punctuals[0], punctuals[1]};
    vxs_bake_arrays arrays     = {.meshes = &mesh, .mesh_count = 1, .lights = lights, .light_count = 2};
    const double    nowhere[3] = {0, NAN, 0};
#define WRONG(change, back, words)                                                                                                 \
    change;                                                                                                                        \
    REFUSED(o.arrays = &arrays, words);                                                                                            \
    back
    float saved = positions[70];
    WRONG(arrays.mesh_count = 0, arrays.mesh_count = 1, "expected a mesh");
    WRONG(mesh.positions = NULL, mesh.positions = positions, "no positions");
    WRONG(mesh.indices = NULL, mesh.indices = indices, "no indices");
    WRONG(indices[9] = BOXES * CORNERS, indices[9] = 1, "index 9");
    WRONG(indices[9] = UINT32_MAX, indices[9] = 1, "index 9");
    make_town();
    WRONG(positions[70] = NAN, positions[70] = saved, "vertex 23");
    WRONG(mesh.origin_ws[2] = INFINITY, mesh.origin_ws[2] = 0, "origin");
    WRONG(mesh.triangle_count = UINT32_MAX, mesh.triangle_count = town.triangle_count, "triangles");
    WRONG(arrays.viewpoints_ws = nowhere; arrays.viewpoint_count = 1, arrays.viewpoint_count = 0, "viewpoint 0");
    WRONG(lights[1].name = "lamp", lights[1].name = "bulb", "two lights");
    WRONG(lights[1].name = NULL, lights[1].name = "bulb", "light 1");
    WRONG(lights[0].cos_outer = 0, lights[0].cos_outer = 1, "cone");
    WRONG((void)0, lights[0].cos_outer = NAN, "cone");
    WRONG((void)0, lights[0].cos_outer = 0.5, "cone");
    WRONG(lights[0].range_metres = -1, lights[0].range_metres = NAN, "range");
    WRONG((void)0, lights[0].range_metres = 0, "range");
    WRONG(lights[0].position_ws[0] = NAN, lights[0].position_ws[0] = 0, "position");
    WRONG(lights[0].direction_ws[1] = 0, lights[0].direction_ws[1] = -1, "direction");
    WRONG(lights[0].kind = 7, lights[0].kind = VXS_BAKE_SPOT, "kind");
    vxs_bake_options o  = town_options();
    o.arrays            = &arrays;
    mesh.triangle_count = 0;
    refused(&o, VXS_E_NO_CASTER, "");
    mesh.triangle_count = town.triangle_count;
    arrays.light_count = o.sun_count = 0;
    refused(&o, VXS_E_NO_LIGHT, "light");
}

/* steps ----------------------------------------------------------------------------------------------------------------------- */

static vxs_bake_bytes stepped(const vxs_bake_options *o, double budget_ms, uint32_t *steps)
{
    vxs_bake_job  *job;
    vxs_bake_bytes file;
    vxs_bake_state s;
    *steps = 0;
    assert_int_equal(vxs_bake_job_open(&job, o), VXS_OK);
    do {
        s = vxs_bake_step(job, budget_ms);
        ++*steps;
        vxs_bake_job_take(job, &file); /* nothing, while there is more */
        if (s == VXS_BAKE_MORE) assert_null(file.data);
        assert_int_equal(vxs_bake_job_result(job), VXS_OK);
    } while (s == VXS_BAKE_MORE);
    assert_int_equal(s, VXS_BAKE_DONE);
    assert_int_equal(vxs_bake_step(job, budget_ms), VXS_BAKE_DONE);
    assert_int_equal(vxs_bake_job_run(job), VXS_OK);
    vxs_bake_job_close(job);
    return file;
}

static void test_steps_give_the_same_bytes(void **state)
{
    (void)state;
    static const double budgets[] = {0.01, 1, 20, INFINITY};
    for (int dag = 0; dag < 2; dag++) {
        vxs_bake_options o    = town_options();
        o.coding              = dag ? VXS_BAKE_DAG : VXS_BAKE_BLOCKS;
        vxs_bake_bytes wanted = baked(&o);
        for (size_t n = 0; n < sizeof budgets / sizeof *budgets; n++) {
            uint32_t       steps;
            vxs_bake_bytes file = stepped(&o, budgets[n], &steps);
            assert_same(&file, &wanted);
            if (n == 0) assert_true(steps > 3);
            if (n == 3) assert_int_equal(steps, 1);
        }
        vxs_bake_bytes_free(&wanted);
    }
}

/* Nothing of a job runs between steps: its threads use no time. */
static void test_nothing_runs_between_steps(void **state)
{
    (void)state;
    vxs_bake_options o = town_options();
    vxs_bake_job    *job;
    o.resolution = 8192;
    assert_int_equal(vxs_bake_job_open(&job, &o), VXS_OK);
    for (int n = 0; n < 5; n++) {
        struct timespec before, after;
        if (vxs_bake_step(job, 5) != VXS_BAKE_MORE) break;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
        usleep(20000);
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
        double used_ms = 1e3 * (double)(after.tv_sec - before.tv_sec) + 1e-6 * (double)(after.tv_nsec - before.tv_nsec);
        assert_true(used_ms < 10);
    }
    vxs_bake_job_close(job); /* in the middle; logs nothing */
    assert_int_equal(kept.errors, 0);
}

static void test_budgets_that_are_none(void **state)
{
    (void)state;
    static const double none[] = {0, -1, NAN, -INFINITY};
    vxs_bake_options    o      = town_options();
    vxs_bake_job       *job;
    assert_int_equal(vxs_bake_job_open(&job, &o), VXS_OK);
    for (size_t n = 0; n < sizeof none / sizeof *none; n++) {
        assert_int_equal(vxs_bake_step(job, none[n]), VXS_BAKE_FAILED);
        assert_int_equal(vxs_bake_job_result(job), VXS_E_ARGUMENT);
        assert_logged("budget_ms");
    }
    (void)vxs_bake_step(job, 0.01);
    assert_int_equal(vxs_bake_job_run(job), VXS_OK);
    assert_int_equal(kept.errors, 0);
    vxs_bake_job_close(job);
    vxs_bake_job_close(NULL);
}

static void count_blend(vxs_severity severity, const char *text, void *user)
{
    keep(severity, text, NULL);
    *(int *)user += severity == VXS_SEVERITY_WARNING && strstr(text, "alphaMode BLEND");
}

/* Options of a file's scene that the first version of the struct had not: a card of BLEND beside a wall, and a buffer out of the
 * folder. */
static void test_options_of_files(void **state)
{
    (void)state;
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"%s\"}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],"
        "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.7]"
        "}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}]}";
    char folder[] = "/tmp/vxs_bake_XXXXXX", path[64];
    int  warnings = 0;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/s.gltf", folder);
    for (int outside = 0; outside < 2; outside++) {
        FILE *f = fopen(path, "w");
        assert_non_null(f);
        fprintf(f, text, outside ? "../none/x.bin" : "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA");
        assert_int_equal(fclose(f), 0);
        vxs_bake_options o = vxs_bake_defaults();
        vxs_bake_bytes   file;
        vxs_bake_sun     sun = {NULL, {0.1, -0.2, -1}};
        o.scene_path         = path;
        o.suns               = &sun;
        o.sun_count          = 1;
        o.resolution         = 64;
        o.log                = count_blend;
        o.user               = &warnings;
        if (outside) {
            refused(&o, VXS_E_READ, "is not in the scene's folder");
            o.allow_outside = 1;
            refused(&o, VXS_E_READ, "No such file or directory");
            continue;
        }
        file = baked(&o);
        vxs_bake_bytes_free(&file);
        assert_int_equal(warnings, 1);
        o.blend = VXS_BAKE_BLEND_OPAQUE; /* which was meant */
        file    = baked(&o);
        vxs_bake_bytes_free(&file);
        assert_int_equal(warnings, 1);
        o.blend = VXS_BAKE_BLEND_EXCLUDE;
        assert_int_equal(vxs_bake(&o, &file), VXS_E_NO_CASTER);
        o.struct_size = offsetof(vxs_bake_options, blend); /* of a program that is older: the default */
        file          = baked(&o);
        vxs_bake_bytes_free(&file);
        assert_int_equal(warnings, 2);
    }
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

/* files of the caller --------------------------------------------------------------------------------------------------------- */

typedef struct memory_file {
    char   name[64];
    char   bytes[65536];
    size_t size;
} memory_file;

typedef struct memory_files {
    memory_file files[4];
    uint32_t    count, reads, writes;
    vxs_result  read_error, write_error;
} memory_files;

static memory_file *find(memory_files *m, const char *name)
{
    for (uint32_t n = 0; n < m->count; n++)
        if (!strcmp(m->files[n].name, name)) return &m->files[n];
    return NULL;
}

static uint64_t memory_size(void *user, const char *name)
{
    const memory_file *f = find(user, name);
    return f ? f->size : UINT64_MAX;
}

static vxs_result memory_read(void *user, const char *name, void *bytes, size_t size_bytes)
{
    memory_files      *m = user;
    const memory_file *f = find(m, name);
    assert_non_null(f);
    assert_true(size_bytes <= f->size);
    memcpy(bytes, f->bytes, size_bytes);
    m->reads++;
    return m->read_error;
}

static vxs_result memory_write(void *user, const char *name, const void *bytes, size_t size_bytes)
{
    memory_files *m = user;
    memory_file  *f = find(m, name);
    if (m->write_error != VXS_OK) return m->write_error;
    if (!f) f = &m->files[m->count++];
    assert_true(m->count <= 4 && size_bytes <= sizeof f->bytes);
    snprintf(f->name, sizeof f->name, "%s", name);
    memcpy(f->bytes, bytes, f->size = size_bytes);
    m->writes++;
    return VXS_OK;
}

static void write_file(const char *name, const memory_file *f)
{
    FILE *to = fopen(name, "w");
    assert_non_null(to);
    assert_int_equal(fwrite(f->bytes, 1, f->size, to), f->size);
    assert_int_equal(fclose(to), 0);
}

/* A scene of two files, and the output, in a folder that the system does not have. */
static void test_files_of_the_caller(void **state)
{
    (void)state;
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"a%20b.bin\"}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}";
    static const float  corners[9] = {0, 0, 0, 0, 1, 0, 1, 0, 0};
    static memory_files m;
    vxs_bake_files      files = {memory_size, memory_read, memory_write, &m};
    vxs_bake_options    o     = vxs_bake_defaults();
    o.log                     = keep;
    vxs_bake_sun   sun        = {NULL, {0.1, -0.2, -1}};
    vxs_bake_bytes file, of_system;
    assert_int_equal(memory_write(&m, "no_such_folder/s.gltf", text, sizeof text - 1), VXS_OK);
    assert_int_equal(memory_write(&m, "no_such_folder/a b.bin", corners, sizeof corners), VXS_OK);
    o.scene_path = "s.gltf";
    o.suns       = &sun;
    o.sun_count  = 1;
    o.resolution = 64;
    write_file("s.gltf", &m.files[0]);
    write_file("a b.bin", &m.files[1]);
    of_system    = baked(&o);
    o.scene_path = "no_such_folder/s.gltf";
    refused(&o, VXS_E_READ, "No such file");
    o.files       = &files;
    o.output_path = "no_such_folder/out.vxs";
    file          = baked(&o);
    assert_int_equal(m.reads, 2);
    assert_int_equal(m.writes, 3);
    const memory_file *out = find(&m, o.output_path);
    assert_non_null(out);
    assert_int_equal(out->size, of_system.size_bytes);
    assert_memory_equal(out->bytes, of_system.data, out->size);
    assert_same(&file, &of_system);
    vxs_bake_bytes_free(&of_system);

    o.if_changed = 1; /* reads the output, and keeps it */
    assert_int_equal(vxs_bake(&o, &file), VXS_OK);
    assert_null(file.data);
    assert_int_equal(m.writes, 3);
    o.if_changed = 0;

    m.write_error = VXS_E_WRITE;
    refused(&o, VXS_E_WRITE, "no_such_folder/out.vxs: cannot write: Input/output error");
    m.write_error = VXS_OK;
    m.read_error  = VXS_E_READ;
    refused(&o, VXS_E_READ, "cannot read 'no_such_folder/s.gltf': Input/output error");
    m.read_error = VXS_E_MEMORY;
    refused(&o, VXS_E_MEMORY, "cannot read 'no_such_folder/s.gltf': Cannot allocate memory");
    m.read_error = VXS_OK;
    snprintf(m.files[1].name, sizeof m.files[1].name, "elsewhere");
    refused(&o, VXS_E_READ, "cannot read buffer 0, 'no_such_folder/a b.bin': No such file");
    o.scene_path = "none.gltf";
    refused(&o, VXS_E_READ, "cannot read 'none.gltf': No such file");
    o.output_path = o.scene_path;
    refused(&o, VXS_E_ARGUMENT, "output_path 'none.gltf' is scene_path");
    o.output_path = "out.vxs";
    o.resume_path = "kept";
    refused(&o, VXS_E_ARGUMENT, "resume_path");
    o.resume_path = NULL;
    files.write   = NULL;
    refused(&o, VXS_E_ARGUMENT, "write for output_path");
    files.read = NULL;
    refused(&o, VXS_E_ARGUMENT, "size and read");
    o.struct_size = offsetof(vxs_bake_options, files); /* of a program that is older: files of the system */
    refused(&o, VXS_E_READ, "cannot read 'none.gltf': No such file");
    assert_int_equal(unlink("s.gltf") | unlink("a b.bin"), 0);
}

/* A scene that is open serves bakes of any sun, with the bytes of bakes that read it themselves. */
static void test_open_scene(void **state)
{
    (void)state;
    vxs_bake_options scene_options = town_options();
    vxs_bake_scene  *scene;
    scene_options.arrays = &town_punctuals;
    scene_options.closed = VXS_BAKE_CLOSED_ON;
    assert_int_equal(vxs_bake_scene_open(&scene, &scene_options), VXS_OK);
    for (int n = 0; n < 2; n++) {
        vxs_bake_options o    = scene_options;
        o.suns                = n ? &evening : &noon;
        o.resolution          = 512;
        vxs_bake_bytes wanted = baked(&o);
        o.arrays              = NULL;
        o.scene               = scene;
        o.closed              = VXS_BAKE_CLOSED_OFF; /* the scene's own counts */
        vxs_bake_bytes file   = baked(&o);
        assert_same(&file, &wanted);
        vxs_bake_bytes_free(&wanted);
    }
    scene_options.scene  = scene;
    scene_options.arrays = NULL;
    vxs_bake_scene *again;
    assert_int_equal(vxs_bake_scene_open(&again, &scene_options), VXS_E_ARGUMENT);
    assert_null(again);
    assert_logged("open already");
    vxs_bake_scene_close(scene);
    vxs_bake_scene_close(NULL);
}

/* giving up ------------------------------------------------------------------------------------------------------------------- */

static char folder[32];

static int enter_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/vxs-library-XXXXXX");
    return !mkdtemp(folder) || chdir(folder);
}

static int leave_folder(void **state)
{
    (void)state;
    unlink("a.vxs");
    return chdir("/") || rmdir(folder); /* fails when something was left */
}

static void write_old(void)
{
    FILE *f = fopen("a.vxs", "wb");
    assert_int_equal(fputs("old", f) < 0 || fclose(f), 0);
}

static void assert_old(void)
{
    char  text[8] = "";
    FILE *f       = fopen("a.vxs", "rb");
    assert_non_null(f);
    assert_non_null(fgets(text, sizeof text, f));
    fclose(f);
    assert_string_equal(text, "old");
}

typedef struct counted {
    int      calls, give_up_at;
    double   last_share;
    uint32_t warnings;
} counted;

static int count_progress(void *user, const vxs_bake_progress *p)
{
    counted *c = user;
    assert_true(p->doing && p->doing[0] && !strchr(p->doing, '\n'));
    assert_true(p->share <= 1 && p->share >= c->last_share);
    c->last_share = p->share;
    return ++c->calls == c->give_up_at;
}

static void test_given_up_by_the_callback(void **state)
{
    (void)state;
    vxs_bake_options o = town_options();
    counted          c = {.last_share = -1};
    o.output_path      = "a.vxs";
    o.progress         = count_progress;
    o.user             = &c;
    o.resolution       = 2048;
    assert_int_equal(vxs_bake(&o, NULL), VXS_OK);
    int calls = c.calls;
    assert_true(calls >= 5);
    write_old();
    for (int n = 1; n < calls; n++) { /* the last is said when there is nothing left to give up */
        c = (counted){.give_up_at = n, .last_share = -1};
        assert_int_equal(vxs_bake(&o, NULL), VXS_E_INTERRUPTED);
        assert_true(strstr(kept.error, "given up") || strstr(kept.error, "interrupted"));
        assert_logged("");
        assert_old();
    }
}

static void *cancel_later(void *job)
{
    usleep(3000);
    vxs_bake_job_cancel(job);
    return NULL;
}

static void test_given_up_from_another_thread(void **state)
{
    (void)state;
    vxs_bake_options o = town_options();
    o.output_path      = "a.vxs";
    o.resolution       = 8192;
    write_old();
    for (int n = 0; n < 3; n++) {
        vxs_bake_job *job;
        pthread_t     other;
        assert_int_equal(vxs_bake_job_open(&job, &o), VXS_OK);
        if (n == 1) (void)vxs_bake_step(job, 1);
        assert_int_equal(pthread_create(&other, NULL, cancel_later, job), 0);
        if (n < 2)
            assert_int_equal(vxs_bake_job_run(job), VXS_E_INTERRUPTED);
        else
            while (vxs_bake_step(job, 1) == VXS_BAKE_MORE) {}
        assert_int_equal(vxs_bake_job_result(job), VXS_E_INTERRUPTED);
        assert_logged("");
        pthread_join(other, NULL);
        vxs_bake_job_close(job);
        assert_old();
    }
}

static void test_given_up_before(void **state)
{
    (void)state;
    vxs_bake_options o = town_options();
    vxs_bake_job    *job;
    assert_int_equal(vxs_bake_job_open(&job, &o), VXS_OK);
    vxs_bake_job_cancel(job);
    assert_int_equal(vxs_bake_step(job, 1000), VXS_BAKE_FAILED);
    assert_int_equal(vxs_bake_job_result(job), VXS_E_INTERRUPTED);
    assert_logged("given up");
    vxs_bake_job_close(job);
}

/* output ---------------------------------------------------------------------------------------------------------------------- */

static void count_warning(vxs_severity severity, const char *text, void *user)
{
    counted *c = user;
    keep(severity, text, NULL);
    c->warnings += severity == VXS_SEVERITY_WARNING;
}

static void test_output_and_warnings(void **state)
{
    (void)state;
    vxs_bake_options o     = town_options();
    counted          c     = {.warnings = 0};
    const double     far[] = {1e6, 1e6, 1e6, 2e6, 2e6, 2e6};
    o.log                  = count_warning;
    o.user                 = &c;
    o.output_path          = "a.vxs";
    vxs_bake_bytes wanted  = baked(&o);
    assert_int_equal(c.warnings, 0);
    FILE    *f   = fopen("a.vxs", "rb");
    uint8_t *all = malloc(wanted.size_bytes + 1);
    assert_int_equal(fread(all, 1, wanted.size_bytes + 1, f), wanted.size_bytes);
    assert_memory_equal(all, wanted.data, wanted.size_bytes);
    fclose(f);
    free(all);
    vxs_bake_bytes_free(&wanted);

    o.if_changed = 1;
    assert_int_equal(vxs_bake(&o, &wanted), VXS_OK);
    assert_null(wanted.data); /* it was the same */
    o.if_changed  = 0;
    o.output_path = NULL;
    o.has_region  = 1;
    memcpy(o.region_ws, far, sizeof far);
    assert_int_equal(vxs_bake(&o, &wanted), VXS_OK);
    vxs_bake_bytes_free(&wanted);
    assert_true(c.warnings > 0);
    o             = town_options();
    o.output_path = "missing/a.vxs";
    refused(&o, VXS_E_WRITE, "missing/a.vxs");
    o.output_path = NULL;
    o.arrays      = NULL;
    o.scene_path  = "a.vxs";
    refused(&o, VXS_E_SCENE, "a.vxs");
    o.output_path = "a.vxs";
    refused(&o, VXS_E_ARGUMENT, "a.vxs");
    o.output_path = NULL;
    o.scene_path  = "missing.glb";
    refused(&o, VXS_E_READ, "missing.glb");
}

static void test_too_little_memory(void **state)
{
    (void)state;
    vxs_bake_options o = town_options();
    o.memory_bytes     = 1 << 20;
    refused(&o, VXS_E_MEMORY, "memory");
    o.memory_bytes      = UINT64_MAX;
    vxs_bake_bytes file = baked(&o);
    vxs_bake_bytes_free(&file);
}

/* What the caller's thread has of floating point is not queried, and not changed. */
static void test_floating_point_of_the_caller(void **state)
{
    (void)state;
    vxs_bake_options o      = town_options();
    vxs_bake_bytes   wanted = baked(&o);
    uint32_t         steps;
    fesetround(FE_UPWARD);
    vxs_bake_bytes file = baked(&o), held = stepped(&o, 2, &steps);
    int            mode = fegetround();
    fesetround(FE_TONEAREST);
    assert_int_equal(mode, FE_UPWARD);
    assert_same(&file, &wanted);
    assert_same(&held, &wanted);
    vxs_bake_bytes_free(&wanted);
}

/* at once --------------------------------------------------------------------------------------------------------------------- */

typedef struct runner {
    vxs_bake_options o;
    double           budget_ms; /* 0: in one go */
    vxs_bake_bytes   wanted, file;
    pthread_t        thread;
} runner;

static void *run(void *user)
{
    runner       *r = user;
    vxs_bake_job *job;
    if (vxs_bake_job_open(&job, &r->o) != VXS_OK) return NULL;
    if (r->budget_ms > 0)
        while (vxs_bake_step(job, r->budget_ms) == VXS_BAKE_MORE) {}
    else
        vxs_bake_job_run(job);
    vxs_bake_job_take(job, &r->file);
    vxs_bake_job_close(job);
    return NULL;
}

static void test_four_at_once(void **state)
{
    (void)state;
    runner           r[4];
    vxs_bake_options scene_options = town_options();
    vxs_bake_scene  *scene;
    assert_int_equal(vxs_bake_scene_open(&scene, &scene_options), VXS_OK);
    for (int n = 0; n < 4; n++) {
        r[n]              = (runner){.o = town_options(), .budget_ms = n == 1 ? 1 : 0};
        r[n].o.resolution = 512u << n % 2;
    }
    r[0].o.arrays           = &town_punctuals; /* punctual lights and a sun */
    r[0].o.light_names      = (const char *const[]){"lamp", "bulb"};
    r[0].o.light_name_count = 2;
    r[1].o.coding           = VXS_BAKE_DAG;
    for (int n = 2; n < 4; n++) {
        r[n].o.arrays = NULL;
        r[n].o.scene  = scene;
        r[n].o.suns   = n == 2 ? &noon : &evening;
        r[n].o.pack   = n == 2 ? VXS_BAKE_PACK_FAST : VXS_BAKE_PACK_SMALL;
    }
    for (int n = 0; n < 4; n++) r[n].wanted = baked(&r[n].o);
    for (int n = 0; n < 4; n++) assert_int_equal(pthread_create(&r[n].thread, NULL, run, &r[n]), 0);
    for (int n = 0; n < 4; n++) pthread_join(r[n].thread, NULL);
    for (int n = 0; n < 4; n++) {
        assert_same(&r[n].file, &r[n].wanted);
        vxs_bake_bytes_free(&r[n].wanted);
    }
    vxs_bake_scene_close(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_options_out_of_range),
        cmocka_unit_test(test_options_of_later_versions),
        cmocka_unit_test(test_arrays_that_are_no_scene),
        cmocka_unit_test(test_steps_give_the_same_bytes),
        cmocka_unit_test(test_nothing_runs_between_steps),
        cmocka_unit_test(test_budgets_that_are_none),
        cmocka_unit_test(test_open_scene),
        cmocka_unit_test(test_options_of_files),
        cmocka_unit_test_setup_teardown(test_files_of_the_caller, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_given_up_by_the_callback, enter_folder, leave_folder),
        cmocka_unit_test_setup_teardown(test_given_up_from_another_thread, enter_folder, leave_folder),
        cmocka_unit_test(test_given_up_before),
        cmocka_unit_test_setup_teardown(test_output_and_warnings, enter_folder, leave_folder),
        cmocka_unit_test(test_too_little_memory),
        cmocka_unit_test(test_floating_point_of_the_caller),
        cmocka_unit_test(test_four_at_once),
    };
    make_town();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
