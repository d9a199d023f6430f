/* Points and lines of glTF files as capsules of smoke: what is read of each mode, how nodes place them, what is refused, and what
 * is written again. In the JSON below ' stands for ", so that it can be read.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/output_file.h"
#include "baker/scene/gltf/glb_write.h"
#include "scenes/generate.h"
#include "tests/unit/gltf_file.h"

/* What the binary chunk of files here holds; accessors are its members in order. */
typedef struct cloud {
    float    places[4][3];
    float    radii[4], extinctions[4];
    uint8_t  halves[4]; /* normalised: 0.2 */
    uint32_t wide[4];
    float    broken[4];        /* the third is no number */
    float    negative[4];      /* the second is -1 */
    float    far_places[4][3]; /* the last is infinite */
    uint8_t  back[4];          /* indices 3, 2, 1, 0 */
    float    instances[2][3];
} cloud;

static const cloud all = {.places      = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 3}},
                          .radii       = {0.1F, 0.2F, 0.3F, 0.5F},
                          .extinctions = {1, 2, 4, 8},
                          .halves      = {51, 51, 51, 51},
                          .wide        = {1, 1, 1, 1},
                          .broken      = {1, 1, NAN, 1},
                          .negative    = {1, -1, 1, 1},
                          .far_places  = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, INFINITY, 0}},
                          .back        = {3, 2, 1, 0},
                          .instances   = {{10, 0, 0}, {0, 10, 0}}};

enum { PLACES, RADII, EXTINCTIONS, HALVES, WIDE, BROKEN, NEGATIVE, FAR_PLACES, BACK, INSTANCES };

static vxs_result load_cloud(const char *rest)
{
    char json[4096];
    int  at = snprintf(json, sizeof json, "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%d}],", (int)sizeof all);
    at += snprintf(json + at, sizeof json - (size_t)at, "'bufferViews':[{'buffer':0,'byteLength':%d}],'accessors':[",
                   (int)sizeof all);
    const struct {
        size_t offset;
        int    component, count;
        char  *more;
    } rows[] = {{offsetof(cloud, places), 5126, 4, "'type':'VEC3'"},
                {offsetof(cloud, radii), 5126, 4, "'type':'SCALAR'"},
                {offsetof(cloud, extinctions), 5126, 4, "'type':'SCALAR'"},
                {offsetof(cloud, halves), 5121, 4, "'type':'SCALAR','normalized':true"},
                {offsetof(cloud, wide), 5125, 4, "'type':'SCALAR'"},
                {offsetof(cloud, broken), 5126, 4, "'type':'SCALAR'"},
                {offsetof(cloud, negative), 5126, 4, "'type':'SCALAR'"},
                {offsetof(cloud, far_places), 5126, 4, "'type':'VEC3'"},
                {offsetof(cloud, back), 5121, 4, "'type':'SCALAR'"},
                {offsetof(cloud, instances), 5126, 2, "'type':'VEC3'"}};
    for (size_t n = 0; n < sizeof rows / sizeof *rows; n++)
        at += snprintf(json + at, sizeof json - (size_t)at, "%s{'bufferView':0,'byteOffset':%d,'componentType':%d,'count':%d,%s}",
                       n ? "," : "", (int)rows[n].offset, rows[n].component, rows[n].count, rows[n].more);
    snprintf(json + at, sizeof json - (size_t)at, "],%s}", rest);
    size_t   size;
    uint8_t *glb = make_glb(json, &all, sizeof all, &size);
    write_file("cloud.glb", glb, size);
    free(glb);
    return load_file(path, NULL);
}

/* One primitive, placed by one node: members of both. */
static vxs_result load_placed(const char *node, const char *primitive)
{
    char rest[2048];
    snprintf(rest, sizeof rest,
             "'nodes':[{'mesh':0%s}],'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,0.125,1]}}],"
             "'meshes':[{'primitives':[{%s}]}]",
             node, primitive);
    return load_cloud(rest);
}

#define SMOKE "'attributes':{'POSITION':0,'_RADIUS':1,'_EXTINCTION':2},"

static void expect_capsule(uint32_t n, int from, int to, double radius, double extinction)
{
    const scene_smoke *smoke = &s.smoke;
    assert_true(n < smoke->count);
    const vxs_capsule *c = &smoke->list[n];
    for (int k = 0; k < 3; k++) {
        assert_true(fabs((double)c->begin[k] + smoke->origin_ws[k] - (double)all.places[from][k]) < 1e-6);
        assert_true(fabs((double)c->end[k] + smoke->origin_ws[k] - (double)all.places[to][k]) < 1e-6);
    }
    if (fabs((double)c->radius_metres - radius) > 1e-6 || fabs((double)c->extinction - extinction) > 1e-6)
        fail_msg("capsule %u: radius %g, extinction %g; expected %g, %g", n, (double)c->radius_metres, (double)c->extinction,
                 radius, extinction);
}

static void test_points_are_balls(void **state)
{
    (void)state;
    must(load_placed("", SMOKE "'mode':0"));
    assert_int_equal(s.smoke.count, 4);
    for (uint32_t n = 0; n < 4; n++) expect_capsule(n, (int)n, (int)n, (double)all.radii[n], (double)all.extinctions[n]);
    assert_int_equal(s.triangle_count, 0);
    assert_int_equal(m.warning_count, 0);
}

static void test_lines_are_means_of_their_ends(void **state)
{
    (void)state;
    must(load_placed("", SMOKE "'mode':1"));
    assert_int_equal(s.smoke.count, 2);
    expect_capsule(0, 0, 1, 0.15, 1.5);
    expect_capsule(1, 2, 3, 0.4, 6);
    must(load_placed("", SMOKE "'mode':3"));
    assert_int_equal(s.smoke.count, 3);
    expect_capsule(1, 1, 2, 0.25, 3);
    must(load_placed("", SMOKE "'mode':2"));
    assert_int_equal(s.smoke.count, 4);
    expect_capsule(2, 2, 3, 0.4, 6);
    expect_capsule(3, 3, 0, 0.3, 4.5);
    must(load_placed("", SMOKE "'mode':3,'indices':8"));
    assert_int_equal(s.smoke.count, 3);
    expect_capsule(0, 3, 2, 0.4, 6);
}

static void test_amounts_of_other_types(void **state)
{
    (void)state;
    must(load_placed("", "'attributes':{'POSITION':0,'_RADIUS':3,'_EXTINCTION':2},'mode':0"));
    expect_capsule(3, 3, 3, 0.2, 8);
}

/* A shrunk puff is as dense to look through. */
static void test_nodes_place_and_scale(void **state)
{
    (void)state;
    must(load_placed(",'translation':[100000,0,0],'scale':[0.5,0.5,-0.5]", SMOKE "'mode':0"));
    const vxs_capsule *c = &s.smoke.list[3];
    assert_true(fabs(s.smoke.origin_ws[0] + (double)c->begin[0] - 100000) < 1e-6);
    assert_true(fabs(s.smoke.origin_ws[2] + (double)c->begin[2] + 1.5) < 1e-6);
    assert_true(fabs((double)c->radius_metres - 0.25) < 1e-6 && fabs((double)c->extinction - 16) < 1e-5);
    must(load_placed(",'scale':[8,1,1]", SMOKE "'mode':0"));
    assert_true(fabs((double)s.smoke.list[1].radius_metres - 0.4) < 1e-6 && fabs((double)s.smoke.list[1].extinction - 1) < 1e-6);
    must(load_placed(",'scale':[1,0,1]", SMOKE "'mode':0"));
    assert_int_equal(s.smoke.count, 0);
}

static void test_instances_are_placed_each(void **state)
{
    (void)state;
    must(load_placed(",'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':9}}}", SMOKE "'mode':0"));
    assert_int_equal(s.smoke.count, 8);
    assert_true(fabs((double)s.smoke.list[7].begin[1] + s.smoke.origin_ws[1] - 12) < 1e-6);
}

static void test_materials_are_albedos(void **state)
{
    (void)state;
    must(load_placed("", SMOKE "'mode':0,'material':0"));
    assert_true(s.smoke.albedos[2][0] == 0.5F && s.smoke.albedos[2][1] == 0.25F && s.smoke.albedos[2][2] == 0.125F);
    must(load_placed("", SMOKE "'mode':0"));
    assert_true(s.smoke.albedos[2][0] == 0.9F);
}

static void test_what_is_excluded_dims_nothing(void **state)
{
    (void)state;
    char *pattern    = "#0";
    chosen.exclude   = (text_list){.items = (const char **)&pattern, .count = 1};
    vxs_result found = load_placed("", SMOKE "'mode':0");
    chosen.exclude   = (text_list){0};
    must(found);
    assert_int_equal(s.smoke.count, 0);
    must(load_placed(",'extras':{'vxs_cast_shadow':false}", SMOKE "'mode':0"));
    assert_int_equal(s.smoke.count, 0);
}

static void test_without_both_attributes_they_are_skipped(void **state)
{
    (void)state;
    must(load_placed("", "'attributes':{'POSITION':0,'_RADIUS':1},'mode':0"));
    assert_int_equal(s.smoke.count, 0);
    must_warn("_RADIUS and _EXTINCTION");
}

static void test_what_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *attributes, *words;
    } rows[] = {{"'POSITION':0,'_RADIUS':1,'_EXTINCTION':99", "accessor 99 does not exist"},
                {"'POSITION':0,'_RADIUS':0,'_EXTINCTION':2", "_RADIUS is not a scalar"},
                {"'POSITION':0,'_RADIUS':1,'_EXTINCTION':4", "_EXTINCTION is of 32-bit integers"},
                {"'POSITION':9,'_RADIUS':1,'_EXTINCTION':2", "4 elements, expected 2"},
                {"'POSITION':0,'_RADIUS':1,'_EXTINCTION':5", "_EXTINCTION 2 is nan"},
                {"'POSITION':0,'_RADIUS':6,'_EXTINCTION':2", "_RADIUS 1 is -1"},
                {"'POSITION':7,'_RADIUS':1,'_EXTINCTION':2", "position 3 is not finite"}};
    for (size_t n = 0; n < sizeof rows / sizeof *rows; n++) {
        char primitive[256];
        snprintf(primitive, sizeof primitive, "'attributes':{%s},'mode':0", rows[n].attributes);
        if (n < 4) must_fail(load_placed("", primitive), VXS_E_SCENE, rows[n].words);
        if (n < 4) assert_true(!s.smoke.list && !s.smoke.count);
        if (n < 4) continue;
        must(load_placed("", primitive)); /* a bad value costs its capsule */
        assert_true(s.smoke.count == 2 || s.smoke.count == 3);
        must_warn(rows[n].words);
        must_warn(": 1 capsules of smoke left out; mend it, or --exclude mesh:#0 bakes without it");
    }
    must_fail(load_placed(",'scale':[1e13,1e13,1e13]", SMOKE "'mode':0"), VXS_E_SCENE, "once placed");
}

/* 2^24 of them are more than there may be before anything is made of them. */
static void test_more_than_there_may_be(void **state)
{
    (void)state;
    static const char head[] = "{'asset':{'version':'2.0'},'accessors':["
                               "{'componentType':5126,'type':'VEC3','count':%u},{'componentType':5126,'type':'SCALAR','count':%u}],"
                               "'nodes':[{'mesh':0},{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0,'_RADIUS':1,"
                               "'_EXTINCTION':1},'mode':0}]}]}";
    char              text[1024];
    snprintf(text, sizeof text, head, 10000000, 10000000);
    must_fail(load_text(text, NULL), VXS_E_UNSUPPORTED, "16777216 capsules");
}

/* ---- written data is read back ---- */

static void write_and_load(const glb_scene *from)
{
    output_file out = {0};
    snprintf(path, sizeof path, "%s/written.glb", folder);
    must(output_file_open(&out, path, &m));
    must(glb_write(from, &out, &m));
    must(output_file_commit(&out, &m));
    must(load_file(path, NULL));
}

static void expect_same(const scene_smoke *a, const scene_smoke *b)
{
    assert_int_equal(a->count, b->count);
    for (uint32_t n = 0; n < a->count; n++) {
        for (int k = 0; k < 3; k++)
            assert_true(fabs((double)a->list[n].end[k] + a->origin_ws[k] - (double)b->list[n].end[k] - b->origin_ws[k]) < 1e-5);
        assert_memory_equal(&a->list[n].radius_metres, &b->list[n].radius_metres, sizeof(float));
        assert_memory_equal(&a->list[n].extinction, &b->list[n].extinction, sizeof(float));
        assert_memory_equal(a->albedos[n], b->albedos[n], sizeof a->albedos[n]);
    }
}

static void test_generated_smoke_is_read_and_written_again(void **state)
{
    (void)state;
    vxs_result (*const generators[2])(glb_scene *, const smoke_options *, run_context *) = {generate_smoke, generate_hair};
    for (int n = 0; n < 2; n++) {
        glb_scene made, again;
        must(generators[n](&made, &(smoke_options){1000, 7}, &m));
        write_and_load(&made);
        assert_int_equal(s.smoke.count, 1000);
        assert_int_equal(s.light_count, 2);
        assert_true(s.lights[1].colour[0] > 0 && s.lights[1].colour[0] != 1);
        scene first = s;
        s           = (scene){0};
        must(glb_from_scene(&again, &first, (const double[3]){0}, &m));
        write_and_load(&again);
        expect_same(&first.smoke, &s.smoke);
        scene_free(&first);
        glb_scene_free(&made);
        glb_scene_free(&again);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points_are_balls),
        cmocka_unit_test(test_lines_are_means_of_their_ends),
        cmocka_unit_test(test_amounts_of_other_types),
        cmocka_unit_test(test_nodes_place_and_scale),
        cmocka_unit_test(test_instances_are_placed_each),
        cmocka_unit_test(test_materials_are_albedos),
        cmocka_unit_test(test_what_is_excluded_dims_nothing),
        cmocka_unit_test(test_without_both_attributes_they_are_skipped),
        cmocka_unit_test(test_what_is_refused),
        cmocka_unit_test(test_more_than_there_may_be),
        cmocka_unit_test(test_generated_smoke_is_read_and_written_again),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
