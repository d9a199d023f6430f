/* The glTF loader: small files made here for each feature and each refusal, then the real scenes with their known figures.
 * In the JSON below ' stands for ", so that it can be read.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/gltf_file.h"
#include "tests/unit/repeats.h"

/* ---- making files ---- */

/* What the binary chunk of most files here holds: a unit square and ways to index it. */
typedef struct square {
    float    corners[4][3];
    uint8_t  u8[8];
    uint16_t u16[8];
    uint32_t u32[8];
    float    moved[2][3];   /* sparse values: corners 1 and 3 */
    float    strided[4][6]; /* corners at byte 8 of 24 */
    uint8_t  at8[4];        /* sparse indices */
    uint16_t at16[2];
    uint32_t at32[2];
    float    broken[3][3]; /* one position is not finite */
    uint8_t  wild[4];      /* an index too far */
} square;

static square make_square(void)
{
    square q = {.corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                .u8      = {0, 1, 2, 0, 2, 3},
                .u16     = {0, 1, 2, 0, 2, 3},
                .u32     = {0, 1, 2, 0, 2, 3},
                .moved   = {{1, 0, 5}, {0, 1, 7}},
                .at8     = {1, 3},
                .at16    = {1, 3},
                .at32    = {1, 3},
                .broken  = {{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}},
                .wild    = {0, 1, 4}};
    for (int i = 0; i < 4; i++) memcpy(&q.strided[i][2], q.corners[i], sizeof q.corners[i]);
    return q;
}

/* bufferViews: 0 all of it; 1 the strided corners. Accessors are named by number in the tests:
 * 0 corners; 1, 2, 3 indices of 8, 16, 32 bits; 4 strided corners; 5, 6, 7 sparse corners by index type; 8 sparse without a
 * bufferView; 9 a broken position; 10 an index out of range; 11 the first three indices of 1; 12 corners as shorts */
static void square_json(char *out, size_t size, const char *rest)
{
    const char *position = "'componentType':5126,'type':'VEC3'";
    int         at       = 0;
#define VIEW(member) (int)offsetof(square, member)
    at += snprintf(out + at, size - (size_t)at,
                   "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%d}],'bufferViews':["
                   "{'buffer':0,'byteLength':%d},{'buffer':0,'byteOffset':%d,'byteLength':96,'byteStride':24}],'accessors':["
                   "{'bufferView':0,%s,'count':4},",
                   (int)sizeof(square), (int)sizeof(square), VIEW(strided), position);
    at += snprintf(out + at, size - (size_t)at,
                   "{'bufferView':0,'byteOffset':%d,'componentType':5121,'type':'SCALAR','count':6},"
                   "{'bufferView':0,'byteOffset':%d,'componentType':5123,'type':'SCALAR','count':6},"
                   "{'bufferView':0,'byteOffset':%d,'componentType':5125,'type':'SCALAR','count':6},"
                   "{'bufferView':1,'byteOffset':8,%s,'count':4},",
                   VIEW(u8), VIEW(u16), VIEW(u32), position);
    for (int i = 0; i < 4; i++)
        at += snprintf(out + at, size - (size_t)at,
                       "{%s%s,'count':4,'sparse':{'count':2,'indices':{'bufferView':0,'byteOffset':%d,'componentType':%d},"
                       "'values':{'bufferView':0,'byteOffset':%d}}},",
                       i < 3 ? "'bufferView':0," : "", position,
                       i == 1   ? VIEW(at16)
                       : i == 2 ? VIEW(at32)
                                : VIEW(at8),
                       i == 1   ? 5123
                       : i == 2 ? 5125
                                : 5121,
                       VIEW(moved));
    snprintf(out + at, size - (size_t)at,
             "{'bufferView':0,'byteOffset':%d,%s,'count':3},"
             "{'bufferView':0,'byteOffset':%d,'componentType':5121,'type':'SCALAR','count':3},"
             "{'bufferView':0,'byteOffset':%d,'componentType':5121,'type':'SCALAR','count':3},"
             "{'bufferView':0,'componentType':5122,'type':'VEC3','count':4}],%s}",
             VIEW(broken), position, VIEW(wild), VIEW(u8), rest);
#undef VIEW
}

/* ---- loading them ---- */

static vxs_result load_square(const char *rest, const char *which)
{
    char   json[8192];
    square q = make_square();
    size_t size;
    square_json(json, sizeof json, rest);
    uint8_t *glb = make_glb(json, &q, sizeof q, &size);
    write_file("square.glb", glb, size);
    free(glb);
    return load_file(path, which);
}

/* The square drawn by one node: members of the node and of the primitive. */
static vxs_result load_placed(const char *node, const char *primitive)
{
    char rest[2048];
    snprintf(rest, sizeof rest, "'nodes':[{'mesh':0%s}],'meshes':[{'primitives':[{%s}]}]", node, primitive);
    return load_square(rest, NULL);
}

/* The square as two triangles, turned to +z. */
static void expect_square(void)
{
    assert_int_equal(s.triangle_count, 2);
    expect_corner(0, 0, 0, 0, 0);
    expect_corner(0, 1, 1, 0, 0);
    expect_corner(0, 2, 1, 1, 0);
    expect_corner(1, 0, 0, 0, 0);
    expect_corner(1, 1, 1, 1, 0);
    expect_corner(1, 2, 0, 1, 0);
}

/* ---- geometry ---- */

static void test_indices_of_every_type(void **state)
{
    (void)state;
    for (int accessor = 1; accessor <= 3; accessor++) {
        char primitive[64];
        snprintf(primitive, sizeof primitive, "'attributes':{'POSITION':0},'indices':%d", accessor);
        must(load_placed("", primitive));
        expect_square();
        assert_int_equal(s.vertex_count, 4);
        assert_int_equal(s.triangle_flags[0], 0);
        assert_int_equal(m.warning_count, 0);
    }
}

static void test_no_indices_ignore_a_partial_triangle(void **state)
{
    (void)state;
    must(load_placed("", "'attributes':{'POSITION':0}"));
    assert_int_equal(s.triangle_count, 1);
    assert_int_equal(s.vertex_count, 3); /* the fourth is in no triangle */
    expect_corner(0, 2, 1, 1, 0);
    must_warn("not a multiple of 3");
}

static void test_strip_alternates_its_winding(void **state)
{
    (void)state;
    must(load_placed("", "'attributes':{'POSITION':0},'mode':5"));
    assert_int_equal(s.triangle_count, 2);
    expect_corner(0, 0, 0, 0, 0);
    expect_corner(0, 1, 1, 0, 0);
    expect_corner(0, 2, 1, 1, 0);
    expect_corner(1, 0, 1, 0, 0);
    expect_corner(1, 1, 0, 1, 0);
    expect_corner(1, 2, 1, 1, 0);
}

static void test_fan_ends_every_triangle_at_its_first_vertex(void **state)
{
    (void)state;
    must(load_placed("", "'attributes':{'POSITION':0},'mode':6"));
    assert_int_equal(s.triangle_count, 2);
    expect_corner(0, 0, 1, 0, 0);
    expect_corner(0, 1, 1, 1, 0);
    expect_corner(0, 2, 0, 0, 0);
    expect_corner(1, 0, 1, 1, 0);
    expect_corner(1, 1, 0, 1, 0);
    expect_corner(1, 2, 0, 0, 0);
}

static void test_stride_and_offset(void **state)
{
    (void)state;
    must(load_placed("", "'attributes':{'POSITION':4},'indices':1"));
    expect_square();
}

static void test_sparse_replaces_positions(void **state)
{
    (void)state;
    for (int accessor = 5; accessor <= 7; accessor++) {
        char primitive[64];
        snprintf(primitive, sizeof primitive, "'attributes':{'POSITION':%d},'indices':1", accessor);
        must(load_placed("", primitive));
        expect_corner(0, 1, 1, 0, 5);
        expect_corner(0, 2, 1, 1, 0);
        expect_corner(1, 2, 0, 1, 7);
    }
    must(load_placed("", "'attributes':{'POSITION':8},'indices':1"));
    expect_corner(0, 1, 1, 0, 5);
    expect_corner(0, 2, 0, 0, 0); /* no bufferView: the rest is zero */
    expect_corner(1, 2, 0, 1, 7);
}

static void test_transforms_are_applied_scale_first(void **state)
{
    (void)state;
    must(load_placed(",'translation':[10,20,30],'rotation':[0,0,0.7071067811865476,0.7071067811865476],'scale':[2,3,4]",
                     "'attributes':{'POSITION':0},'indices':1"));
    expect_corner(0, 1, 10, 22, 30);
    expect_corner(0, 2, 7, 22, 30);
    must(load_placed(",'matrix':[0,2,0,0, -3,0,0,0, 0,0,4,0, 10,20,30,1]", "'attributes':{'POSITION':0},'indices':1"));
    expect_corner(0, 1, 10, 22, 30);
    expect_corner(0, 2, 7, 22, 30);
}

static void test_hierarchy_multiplies(void **state)
{
    (void)state;
    must(load_square("'nodes':[{'mesh':0,'translation':[1,0,0]},{'children':[0],'scale':[2,2,2],'translation':[0,5,0]}],"
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],"
                     "'scene':0,'scenes':[{'name':'one','nodes':[1]}]",
                     NULL));
    assert_string_equal(s.name, "one");
    expect_corner(0, 0, 2, 5, 0);
    expect_corner(0, 2, 4, 7, 0);
}

static void test_mirrored_nodes_turn_the_winding_back(void **state)
{
    (void)state;
    must(load_placed(",'scale':[-1,1,1]", "'attributes':{'POSITION':0},'indices':1"));
    expect_corner(0, 0, 0, 0, 0);
    expect_corner(0, 1, -1, 1, 0);
    expect_corner(0, 2, -1, 0, 0);
    must(load_placed(",'scale':[-1,-1,1]", "'attributes':{'POSITION':0},'indices':1"));
    expect_corner(0, 1, -1, 0, 0);
    expect_corner(0, 2, -1, -1, 0);
}

static void test_vertices_are_shared_within_a_node(void **state)
{
    (void)state;
    const char *both = "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1},"
                       "{'attributes':{'POSITION':0},'indices':2}]}]";
    char        rest[512];
    snprintf(rest, sizeof rest, "'nodes':[{'mesh':0}],%s", both);
    must(load_square(rest, NULL));
    assert_int_equal(s.triangle_count, 4);
    assert_int_equal(s.vertex_count, 4);
    snprintf(rest, sizeof rest, "'nodes':[{'mesh':0},{'mesh':0,'translation':[0,0,1]}],%s", both);
    must(load_square(rest, NULL));
    assert_int_equal(s.triangle_count, 8);
    assert_int_equal(s.vertex_count, 8);
    expect_corner(4, 0, 0, 0, 1);
    must(load_placed("", "'attributes':{'POSITION':0},'indices':11"));
    assert_int_equal(s.vertex_count, 3); /* only what is referenced */
}

static void test_morph_targets_take_default_weights(void **state)
{
    (void)state;
    const char *mesh = "'meshes':[{'weights':[0.5],'primitives':[{'attributes':{'POSITION':0},'indices':1,"
                       "'targets':[{'POSITION':8}]}]}]";
    char        rest[512];
    snprintf(rest, sizeof rest, "'nodes':[{'mesh':0}],%s", mesh);
    must(load_square(rest, NULL));
    expect_corner(0, 1, 1.5, 0, 2.5);
    must_warn("morph targets");
    snprintf(rest, sizeof rest, "'nodes':[{'mesh':0,'weights':[0]}],%s", mesh);
    must(load_square(rest, NULL));
    expect_square();
    snprintf(rest, sizeof rest, "'nodes':[{'mesh':0,'weights':[1,1]}],%s", mesh); /* the second is of no target */
    must(load_square(rest, NULL));
    expect_corner(0, 1, 2, 0, 5);
    must_warn("mesh 0 primitive 0: 2 weights for 1 morph targets");
}

static void test_materials_set_flags(void **state)
{
    (void)state;
    must(load_square("'nodes':[{'mesh':0}],'materials':[{'alphaMode':'OPAQUE','doubleSided':true},"
                     "{'alphaMode':'BLEND'}],'meshes':[{'primitives':["
                     "{'attributes':{'POSITION':0},'indices':11,'material':0},"
                     "{'attributes':{'POSITION':0},'indices':11,'material':1}]}]",
                     NULL));
    assert_int_equal(s.triangle_flags[0], TRIANGLE_DOUBLE_SIDED);
    assert_int_equal(s.triangle_flags[1], 0);
}

static void test_points_and_lines_are_warned_about(void **state)
{
    (void)state;
    must(load_square("'nodes':[{'mesh':0}],'meshes':[{'primitives':["
                     "{'attributes':{'POSITION':0},'mode':0},{'attributes':{'POSITION':0},'mode':1},"
                     "{'attributes':{'POSITION':0},'mode':3},{'attributes':{'NORMAL':0}}]}]",
                     NULL));
    assert_int_equal(s.triangle_count, 0);
    must_warn("points skipped: 1");
    must_warn("lines skipped: 2");
    must_warn("no POSITION");
}

/* ---- what casts ---- */

/* A house of two nodes and two materials, a door that shows one of its meshes again, and a skinned cloak. */
static vxs_result load_house(void)
{
    return load_square(
        "'nodes':[{'name':'house','mesh':0,'children':[1,2]},{'name':'door','mesh':1},{'mesh':1,'translation':[0,0,9]},"
        "{'name':'cloak','mesh':1,'skin':0}],'skins':[{'joints':[0]}],"
        "'scene':0,'scenes':[{'nodes':[0,3]}],"
        "'materials':[{'name':'brick'},{'name':'glass','extras':{'vxs_cast_shadow':true}}],"
        "'meshes':[{'name':'walls','primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0},"
        "{'attributes':{'POSITION':0},'indices':11,'material':1}]},"
        "{'primitives':[{'attributes':{'POSITION':0},'indices':11}]}]",
        NULL);
}

/* Patterns of the next load; NULL: none. */
static void choose(const char *exclude, const char *include)
{
    static const char *items[2];
    items[0] = exclude, items[1] = include;
    chosen = (scene_choice){.exclude = {items, exclude != NULL, 1}, .include = {items + 1, include != NULL, 1}};
}

static void test_parts_name_triangles(void **state)
{
    (void)state;
    choose(NULL, NULL);
    must(load_house());
    static const uint32_t first[] = {0, 2, 3, 4}, node[] = {0, 0, 1, 2}, mesh[] = {0, 0, 1, 1},
                          material[]     = {0, 1, SCENE_NO_MATERIAL, SCENE_NO_MATERIAL};
    static const char *const node_name[] = {"house", "house", "door", ""}, *const material_name[] = {"brick", "glass", "", ""};
    assert_int_equal(s.triangle_count, 5);
    assert_int_equal(s.part_count, 4);
    for (size_t i = 0; i < s.part_count; i++) {
        const scene_part *p = &s.parts[i];
        assert_true(p->triangle_first == first[i] && p->node == node[i] && p->mesh == mesh[i] && p->material == material[i]);
        assert_string_equal(s.names + p->node_name, node_name[i]);
        assert_string_equal(s.names + p->mesh_name, i < 2 ? "walls" : "");
        assert_string_equal(s.names + p->material_name, material_name[i]);
    }
    assert_int_equal(scene_part_at(&s, 0, 1), 0);
    assert_int_equal(scene_part_at(&s, 0, 2), 1);
    assert_int_equal(scene_part_at(&s, 1, 4), 3);
}

static void test_patterns_choose_what_casts(void **state)
{
    (void)state;
    static const struct {
        const char *exclude, *include;
        size_t      triangles; /* that cast; the cloak's one never does */
    } cases[] = {
        {NULL, NULL, 5},
        {"node:house", NULL, 0},
        {"node:door", NULL, 4},
        {"door", NULL, 4},
        {"mesh:#1", NULL, 3},
        {"node:#2", NULL, 4},
        {"mesh:wall?", NULL, 2},
        {"material:*", NULL, 2},
        {"material:b*", NULL, 3},
        {"[gb]lass", NULL, 4},
        {NULL, "node:house", 5},
        {NULL, "node:door", 1},
        {NULL, "material:glass", 1},
        {"node:door", "mesh:#1", 1},
        {"mesh:#1", "node:house", 3},
        {"node:house", "node:door", 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        choose(cases[i].exclude, cases[i].include);
        must(load_house());
        if (s.triangle_count != cases[i].triangles)
            fail_msg("exclude %s, include %s: %zu triangles", cases[i].exclude, cases[i].include, s.triangle_count);
        size_t excluded = 0;
        for (size_t k = 0; k < s.exclusion_count; k++) excluded += s.exclusions[k].triangles;
        assert_int_equal(s.triangle_count + excluded, 6); /* each by one rule */
    }
    choose(NULL, NULL);
}

static void test_patterns_that_name_nothing_are_refused(void **state)
{
    (void)state;
    choose("node:Door", NULL);
    must_fail(load_house(), VXS_E_ARGUMENT, "--exclude node:Door names nothing in the scene; near it are node:door");
    choose(NULL, "brick*s");
    must_fail(load_house(), VXS_E_ARGUMENT,
              "--include brick*s names nothing in the scene; there are node:house, mesh:walls, material:");
    choose("mesh:", NULL);
    must_fail(load_house(), VXS_E_ARGUMENT, "--exclude mesh: names nothing");
    choose("node:#9", NULL);
    must_fail(load_house(), VXS_E_ARGUMENT, "node:#9");
    choose(NULL, NULL);
}

static void test_instances_are_one_part(void **state)
{
    (void)state;
    must(load_square("'extensionsUsed':['EXT_mesh_gpu_instancing'],'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{"
                     "'attributes':{'TRANSLATION':0}}}},{'mesh':0}],"
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]",
                     NULL));
    assert_int_equal(s.triangle_count, 10);
    assert_int_equal(s.part_count, 2);
    assert_int_equal(s.parts[1].triangle_first, 8);
    choose("node:#0", NULL);
    must(load_square("'extensionsUsed':['EXT_mesh_gpu_instancing'],'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{"
                     "'attributes':{'TRANSLATION':0}}}},{'mesh':0}],"
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]",
                     NULL));
    assert_int_equal(s.triangle_count, 2); /* the other node still shows the mesh */
    assert_int_equal(s.exclusions[0].triangles, 8);
    choose(NULL, NULL);
}

/* The square, with extras of its node, mesh and material. */
static vxs_result load_flagged(const char *node, const char *mesh, const char *material)
{
    char rest[1024];
    snprintf(rest, sizeof rest,
             "'nodes':[{'children':[1]%s},{'name':'below','mesh':0}],'materials':[{'name':'paint'%s}],"
             "'meshes':[{'name':'square','primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]%s}]",
             node, material, mesh);
    return load_square(rest, NULL);
}

static void test_extras_say_what_casts_no_shadow(void **state)
{
    (void)state;
#define EXTRAS(value) ",'extras':{'other':[1],'vxs_cast_shadow':" value "}"
    static const char *const        off[]   = {EXTRAS("false"), EXTRAS("0")},
                             *const on[]    = {EXTRAS("true"), EXTRAS("1"), ",'extras':3", ",'extras':[]"},
                             *const wrong[] = {EXTRAS("'false'"), EXTRAS("2"), EXTRAS("null"), EXTRAS("{}")};
    for (size_t i = 0; i < 2; i++) {
        must(load_flagged(off[i], "", ""));
        assert_int_equal(s.triangle_count, 0);
        assert_true(s.exclusion_count == 1 && s.exclusions[0].rule == EXCLUDED_BY_EXTRAS && s.exclusions[0].triangles == 2);
        must(load_flagged("", off[i], ""));
        assert_int_equal(s.triangle_count, 0);
        must(load_flagged("", "", off[i]));
        assert_int_equal(s.triangle_count, 0);
        assert_int_equal(m.warning_count, 0);
    }
    for (size_t i = 0; i < sizeof on / sizeof *on; i++) {
        must(load_flagged(on[i], on[i], on[i]));
        assert_int_equal(s.triangle_count, 2);
        assert_int_equal(m.warning_count, 0);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        must(load_flagged("", wrong[i], wrong[i]));
        assert_int_equal(s.triangle_count, 2);
        assert_int_equal(m.warning_count, 1);
        must_warn("mesh 0 'square': vxs_cast_shadow in its extras is neither true nor false: ignored, as in 1 more");
    }
    choose(NULL, "mesh:square"); /* which has the flag: set aside */
    must(load_flagged("", off[0], ""));
    assert_int_equal(s.triangle_count, 2);
    must(load_flagged("", "", off[0])); /* another has it */
    assert_int_equal(s.triangle_count, 0);
    choose(NULL, "node:below");
    must(load_flagged(off[0], "", "")); /* the flag of the node above is set aside for this one */
    assert_int_equal(s.triangle_count, 2);
    choose(NULL, NULL);
}

static void test_skinned_meshes_are_left_out(void **state)
{
    (void)state;
    const char *two = "'nodes':[{'mesh':0,'skin':0},{'mesh':0,'skin':0,'name':'cape'},{'mesh':0,'translation':[0,0,9]}],"
                      "'skins':[{'joints':[0]}],'scenes':[{'nodes':[0,1,2]}],"
                      "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]";
    must(load_square(two, NULL));
    assert_int_equal(s.triangle_count, 2);
    assert_true(s.exclusion_count == 1 && s.exclusions[0].rule == EXCLUDED_AS_SKINNED && s.exclusions[0].triangles == 4);
    assert_int_equal(m.warning_count, 1);
    must_warn("2 with 4 triangles are left out; --skinned rest takes them");
    chosen.skinned_given = 1; /* it is meant */
    must(load_square(two, NULL));
    assert_int_equal(s.triangle_count, 2);
    assert_int_equal(m.warning_count, 0);
    choose("node:cape", NULL); /* requested, and counted there */
    must(load_square(two, NULL));
    assert_int_equal(s.exclusion_count, 2);
    must_warn("1 with 2 triangles are left out");
    chosen.skinned = SKINNED_REST; /* no joints say where its vertices are */
    must(load_square(two, NULL));
    assert_int_equal(s.triangle_count, 2);
    must_warn(
        "mesh 0 primitive 0 (node 0): no JOINTS_0, which a mesh of a node with a skin needs: 2 triangles left out; mend it, or "
        "--exclude mesh:#0 bakes without it");
    choose(NULL, NULL);
}

/* A strip of four vertices on two joints, by every way that weights are stored. bin: positions, joints as bytes and shorts, weights
 * as floats, bytes and shorts, a second set of both, and two inverse bind matrices. */
typedef struct strip {
    float    positions[4][3];
    uint8_t  joints8[4][4];
    uint16_t joints16[4][4];
    float    weights[4][4];
    uint8_t  weights8[4][4];
    uint16_t weights16[4][4];
    uint8_t  more_joints[4][4];
    float    half[4][4], off[4][4], none[4][4], inverse[2][16];
} strip;

static strip make_strip(void)
{
    strip p = {.positions = {{0, 0, 0}, {128, 0, 0}, {0, 128, 0}, {128, 128, 0}}};
    for (int v = 0; v < 4; v++) {
        int top         = v >= 2;
        p.joints8[v][0] = p.joints8[v][1] = 0, p.joints8[v][1] = 1;
        p.joints16[v][1]   = 1;
        p.weights[v][top]  = 1;
        p.weights8[v][top] = 255, p.weights16[v][top] = 65535;
        p.more_joints[v][0] = (uint8_t)top;
        p.half[v][top]      = 0.5f;
        p.off[v][top]       = 3;
    }
    for (int j = 0; j < 2; j++)
        for (int k = 0; k < 16; k++)
            p.inverse[j][k] = k % 5 ? 0 : k == 15 ? 1 : 1.0f / 128; /* vertices are stored in other units than joints */
    return p;
}

/* attributes: of the primitive besides POSITION; skin: members besides joints. Joint 0 is node 2, moved by (0, 1, 0); joint 1 its
 * child, turned by 90 degrees about z and moved by (0, 0, 5); node 0 shows the mesh, from (30, 30, 30) and twice as large, which
 * means nothing. */
static vxs_result load_strip(const char *attributes, const char *skin)
{
    strip  p = make_strip();
    char   json[4096];
    size_t size;
#define AT(member) (int)offsetof(strip, member)
    snprintf(
        json, sizeof json,
        "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%d}],'bufferViews':[{'buffer':0,'byteLength':%d}],'accessors':["
        "{'bufferView':0,'componentType':5126,'type':'VEC3','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5121,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5123,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5126,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5121,'normalized':true,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5123,'normalized':true,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5121,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5126,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5126,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5126,'type':'VEC4','count':4},"
        "{'bufferView':0,'byteOffset':%d,'componentType':5126,'type':'MAT4','count':2}],"
        "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0,'skin':0,'translation':[30,30,30],'scale':[2,2,-2]},{'children':[2]},"
        "{'translation':[0,1,0],'children':[3]},{'translation':[0,0,5],'rotation':[0,0,0.7071067811865476,0.7071067811865476]}],"
        "'skins':[{'joints':[2,3]%s}],'meshes':[{'name':'strip','primitives':[{'mode':5,'attributes':{'POSITION':0%s}}]}]}",
        (int)sizeof p, (int)sizeof p, AT(joints8), AT(joints16), AT(weights), AT(weights8), AT(weights16), AT(more_joints),
        AT(half), AT(off), AT(none), AT(inverse), skin, attributes);
#undef AT
    uint8_t *glb = make_glb(json, &p, sizeof p, &size);
    write_file("strip.glb", glb, size);
    free(glb);
    chosen.skinned = SKINNED_REST;
    return load_file(path, NULL);
}

#define SKINNED(joints, weights) ",'JOINTS_0':" #joints ",'WEIGHTS_0':" #weights

/* By 3.7.3.3: a vertex is the sum of its joints' transforms times their inverse bind matrices, each by its weight. */
static void test_skinned_meshes_stand_by_their_joints(void **state)
{
    (void)state;
    static const char *const stored[] = {SKINNED(1, 3), SKINNED(2, 4), SKINNED(1, 5), SKINNED(1, 7) ",'JOINTS_1':6,'WEIGHTS_1':7"};
    const char              *inverse  = ",'inverseBindMatrices':10";
    for (size_t i = 0; i < 4; i++) {
        /* the second set repeats joint 0 or 1 in its first place: halves of weights that lie there are of vertex 0 and 1 */
        must(load_strip(stored[i], inverse));
        assert_int_equal(s.triangle_count, 2);
        expect_corner(0, 0, 0, 1, 0);
        expect_corner(0, 1, 1, 1, 0);
        if (i == 3) continue;
        expect_corner(0, 2, -1, 1, 5); /* (0, 1) turned, moved by joint 1 and by joint 0 */
        expect_corner(1, 1, -1, 2, 5);
        assert_int_equal(m.warning_count, 0);
    }
    must(load_strip(SKINNED(1, 3), "")); /* without matrices they are identities */
    expect_corner(0, 1, 128, 1, 0);
    must(load_strip(SKINNED(1, 8), inverse));
    expect_corner(0, 1, 1, 1, 0);
    must_warn("mesh 0 'strip' primitive 0: weights of joints do not sum to 1: taken as shares of their sum, 4 vertices; ");
    must(load_strip(SKINNED(1, 9), inverse)); /* of no weight at all: the first joint has it */
    expect_corner(0, 2, 0, 2, 0);
    must_warn("do not sum to 1");
    choose(NULL, NULL);
}

static void test_broken_skins_cost_their_primitive(void **state)
{
    (void)state;
    static const struct {
        const char *attributes, *skin, *words;
    } rows[] = {
        {SKINNED(1, 3), ",'inverseBindMatrices':99", "inverseBindMatrices accessor 99 does not exist"},
        {SKINNED(1, 3), ",'inverseBindMatrices':3", "not matrices of 4 x 4 floats"},
        {SKINNED(3, 3), "", "joints are not of 8 or 16 bits"},
        {SKINNED(4, 3), "", "joints are normalised numbers"},
        {SKINNED(1, 1), "", "weights are not floats or normalised unsigned integers"},
        {",'JOINTS_0':1", "", "WEIGHTS_0 accessor -1 does not exist"},
        {SKINNED(1, 0), "", "WEIGHTS_0 is not a VEC4"},
        {"", "", "no JOINTS_0, which a mesh of a node with a skin needs"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        must_fail(load_strip(rows[i].attributes, rows[i].skin), VXS_E_SCENE, rows[i].words);
    choose(NULL, NULL);
}

/* ---- what is hardly meant ---- */

static void test_traps_are_said(void **state)
{
    (void)state;
#define MESH "'meshes':[{'name':'house','primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]}]"
    static const struct {
        const char *rest, *words;
    } rows[] = {
        {"'extensionsUsed':['KHR_materials_unlit'],'nodes':[{'mesh':0,'extensions':{'MSFT_lod':{'ids':[1]}}},{'name':'low','mesh':"
         "0,'scale':[2,2,2]}],",
         "node 1 'low': by MSFT_lod a level of detail of another node"},
        {"'nodes':[{'name':'flat','mesh':0,'scale':[0,0,0]},{'mesh':0}],",
         "node 0 'flat': has a scale of 0, or a node above it has: its mesh casts nothing, 2 tri"},
        {"'nodes':[{'mesh':0},{'name':'copy','mesh':0}],",
         "node 1 'copy': shows a mesh that another node shows at the same place: it is there twice, 2 triangles; "},
        {"'nodes':[{'name':'fan','children':[1]},{'mesh':0}],'animations':[{'channels':[{'target':{'node':0,'path':'rotation'}}]}]"
         ",",
         "node 1: moved by animations, and its shadow is baked where it stands in the file, 2 triangles; --exclude node:#1 bakes "
         "without it"},
        {"'extensionsUsed':['EXT_mesh_gpu_instancing'],'animations':[{'channels':[{'target':{'node':0,'path':'scale'}}]}],'nodes':["
         "{"
         "'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':0}}}}],",
         "node 0: moved by animations, and its shadow is baked where it stands in the file, 8 triangles; "},
        {"'nodes':[{'mesh':0},{'name':'lost','mesh':0,'scale':[2,2,2]}],'scenes':[{'nodes':[0]}],",
         "node 1 'lost': in no scene of the file, and so not baked; "},
        {"'nodes':[{},{'mesh':0}],'scene':0,'scenes':[{'nodes':[0]},{'name':'yard','nodes':[1]}],",
         "scene 0: no mesh of it casts, and scene 1 'yard' has meshes; choose with --scene"},
    };
    static const char *const sound[] = {
        "'nodes':[{'mesh':0,'scale':[1,1,0]}],",
        "'nodes':[{'mesh':0},{'mesh':0,'translation':[0,0,1e-9]}],",
        "'nodes':[{'mesh':0}],'animations':[{'channels':[{'target':{'node':0,'path':'weights'}},{'target':{'path':'pointer'}},3]},"
        "7],",
    };
    char rest[1024];
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        snprintf(rest, sizeof rest, "%s'materials':[{}]," MESH, rows[i].rest);
        must(load_square(rest, NULL));
        assert_int_equal(m.warning_count, 1);
        must_warn(rows[i].words);
    }
    for (size_t i = 0; i < sizeof sound / sizeof *sound; i++) {
        snprintf(rest, sizeof rest, "%s'materials':[{}]," MESH, sound[i]);
        must(load_square(rest, NULL));
        if (m.warning_count) fail_msg("row %zu: '%s'", i, m.warnings[0]);
    }
    must(load_square("'nodes':[{'mesh':0}],'materials':[{'name':'common/Clip'}]," MESH, NULL));
    must_warn("material 0 'common/Clip': by its name invisible, as level editors have it, and it casts a shadow, 2 triangles; ");
    must(load_square("'nodes':[{'mesh':0}],'materials':[{'emissiveFactor':[1,1,1]}]," MESH, NULL));
    assert_int_equal(s.emissive_count, 1);
}

/* ---- lights, cameras, scenes ---- */

static void test_lights_follow_their_nodes(void **state)
{
    (void)state;
    must(load_text(HEAD "'extensionsRequired':['KHR_lights_punctual']," LIGHTS
                        "{'type':'directional','name':'sun'},{'type':'spot','spot':{}},{'type':'point','name':'sun'}]}},"
                        "'nodes':[{" USE(0) ",'rotation':[-0.7071067811865476,0,0,0.7071067811865476]},"
                                            "{'translation':[1,2,3],'scale':[2,2,2],'children':[2,3]},{'translation':[1,0,0]," USE(
                                                1) "},"
                                                   "{" USE(2) "},{" USE(0) "}]}",
                   NULL));
    assert_int_equal(s.light_count, 4);
    assert_string_equal(s.lights[0].name, "sun");
    assert_string_equal(s.lights[1].name, "light1");
    assert_string_equal(s.lights[2].name, "sun#2");
    assert_string_equal(s.lights[3].name, "sun#3");
    static const uint32_t nodes[] = {0, 2, 3, 4};
    for (size_t i = 0; i < 4; i++) assert_true(s.lights[i].node == nodes[i] && !s.lights[i].node_name[0]);
    assert_int_equal(s.lights[0].shape.kind, LIGHT_DIRECTIONAL);
    assert_int_equal(s.lights[1].shape.kind, LIGHT_SPOT);
    assert_int_equal(s.lights[2].shape.kind, LIGHT_POINT);
    assert_true(fabs(s.lights[0].shape.direction_ws[1] + 1) < 1e-12); /* turned to shine straight down */
    assert_true(s.lights[1].shape.position_ws[0] == 3 && s.lights[1].shape.position_ws[1] == 2 &&
                s.lights[1].shape.position_ws[2] == 3);
    assert_true(s.lights[1].shape.direction_ws[2] == -1);
}

/* A definition that has no name, or that several nodes use, says less than their names. */
static void test_lights_have_names_of_nodes(void **state)
{
    (void)state;
    must(load_text(HEAD LIGHTS "{'type':'point'},{'type':'point','name':'bulb'},{'type':'point','name':'spare'}]}},'nodes':["
                               "{'name':'kitchen'," USE(0) "},{'name':'hall'," USE(0) "},{" USE(0) "},{'name':'desk'," USE(
                                   1) "},"
                                      "{'name':'bulb'," USE(2) "},{" USE(2) "}]}",
                   NULL));
    static const char *const names[] = {"kitchen", "hall", "light0", "bulb", "bulb#2", "spare"};
    assert_int_equal(s.light_count, 6);
    for (size_t i = 0; i < 6; i++) assert_string_equal(s.lights[i].name, names[i]);
    assert_string_equal(s.lights[3].node_name, "desk");
}

/* A bad value costs one light at most, and what a bake does not request nothing. */
static void test_bad_lights_cost_themselves(void **state)
{
    (void)state;
    static const struct {
        const char *light, *node;
        light_kind  kind; /* of the light that comes of it */
        const char *odd;  /* messages about it; NULL: nothing */
        const char *why;  /* why there is none; NULL: there is */
    } rows[] = {
        {"'type':'directional','range':0", "", LIGHT_DIRECTIONAL, NULL, NULL},
        {"'type':'directional','range':'far'", "", LIGHT_DIRECTIONAL, NULL, NULL},
        {"'type':'point','range':0", "", LIGHT_POINT, "range is 0, expected more than 0: taken as none; ", NULL},
        {"'type':'point','range':-2", "", LIGHT_POINT, "range is -2, expected more than 0: taken as none; ", NULL},
        {"'type':'point','range':'far'", "", LIGHT_POINT, "'range' is not a number: taken as none; ", NULL},
        {"'type':'spot','spot':{'innerConeAngle':0.8}", "", LIGHT_SPOT, NULL, NULL},
        {"'type':'spot','spot':{'innerConeAngle':-1}", "", LIGHT_SPOT, NULL, NULL},
        {"'type':'spot','spot':{'innerConeAngle':[]}", "", LIGHT_SPOT, NULL, NULL},
        {"'type':'spot'", "", LIGHT_SPOT, "it has no 'spot' object: its cone is taken as one of 45 degrees; ", NULL},
        {"'type':'spot','spot':3", "", LIGHT_SPOT, "it has no 'spot' object", NULL},
        {"'type':'spot','spot':{'outerConeAngle':1.571}", "", LIGHT_POINT,
         "outerConeAngle is 1.571 radians (90.01 degrees), more than", NULL},
        {"'type':'spot','spot':{'outerConeAngle':45}", "", LIGHT_POINT, "outerConeAngle is 45 radians, which", NULL},
        {"'type':'spot','spot':{'outerConeAngle':0}", "", LIGHT_SPOT, NULL, "outerConeAngle is 0: expected more than 0"},
        {"'type':'area'", "", LIGHT_POINT, NULL, "unknown type 'area', expected directional, spot or point"},
        {"'name':'x'", "", LIGHT_POINT, NULL, "'type' is missing"},
        {"'type':'directional'", "'scale':[0,0,0],", LIGHT_POINT, NULL, "it has no direction"},
        {"'type':'point'", "'scale':[0,0,0],", LIGHT_POINT, NULL, NULL},
        {"'type':'point'", "'translation':[1e308,0,0],'matrix':[1e308,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],", LIGHT_POINT, NULL, NULL},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char text[1024];
        snprintf(text, sizeof text, HEAD LIGHTS "{'type':'point','name':'good'},{%s}]}},'nodes':[{" USE(0) "},{%s" USE(1) "}]}",
                 rows[i].light, rows[i].node);
        must(load_text(text, NULL));
        assert_string_equal(s.lights[0].name, "good");
        assert_int_equal(s.light_count, rows[i].why ? 1 : 2);
        assert_int_equal(s.lost_light_count, rows[i].why ? 1 : 0);
        if (rows[i].why && !strstr(s.lost_lights[0].why, rows[i].why)) fail_msg("row %zu: '%s'", i, s.lost_lights[0].why);
        if (rows[i].why) continue;
        const scene_light *l = &s.lights[1];
        if (!l->odd != !rows[i].odd || (l->odd && strncmp(l->odd, rows[i].odd, strlen(rows[i].odd)) != 0))
            fail_msg("row %zu: '%s'", i, l->odd);
        assert_int_equal(l->shape.kind, rows[i].kind);
        assert_true(l->shape.kind == LIGHT_POINT || l->inner_rad <= l->shape.outer_rad || l->shape.kind == LIGHT_DIRECTIONAL);
        assert_true(strstr(rows[i].light, "range") == NULL || l->shape.range_metres == INFINITY);
    }
}

static void test_uses_of_lights_that_are_not_there(void **state)
{
    (void)state;
    must(load_text(HEAD LIGHTS "{'type':'point'}]}},'nodes':[{" USE(1) "},{'extensions':{'KHR_lights_punctual':{}}},{" USE(0) "}]}",
                   NULL));
    assert_true(s.light_count == 1 && s.lost_light_count == 2);
    assert_non_null(strstr(s.lost_lights[0].why, "light 1 does not exist, the file has 1; "));
    assert_non_null(strstr(s.lost_lights[1].why, "'light' is missing"));
    must(load_text(HEAD "'extensions':{'KHR_lights_punctual':{}},'nodes':[{" USE(0) "}]}", NULL));
    assert_true(s.light_count == 0 && s.lost_light_count == 1);
}

static void test_dark_lights_are_known(void **state)
{
    (void)state;
    static const char *const dark[]   = {"'intensity':0", "'intensity':-3", "'color':[0,0,0]"};
    static const char *const bright[] = {"'intensity':1e-9", "'color':[0,0,0.1]", "'intensity':'much'", "'color':[0,0]"};
    char                     text[512];
    for (size_t i = 0; i < 3; i++) {
        snprintf(text, sizeof text, HEAD LIGHTS "{'type':'point',%s}]}},'nodes':[{" USE(0) "}]}", dark[i]);
        must(load_text(text, NULL));
        assert_true(s.light_count == 1 && s.lights[0].dark && s.lights[0].colour[0] == 0 && s.lights[0].colour[2] == 0);
    }
    for (size_t i = 0; i < 4; i++) {
        snprintf(text, sizeof text, HEAD LIGHTS "{'type':'point',%s}]}},'nodes':[{" USE(0) "}]}", bright[i]);
        must(load_text(text, NULL));
        assert_true(s.light_count == 1 && !s.lights[0].dark && s.lights[0].colour[2] > 0);
    }
}

/* What is hidden has no triangles, no lights and no smoke, with all below it; cameras see all the same. */
static void test_hidden_nodes_show_nothing(void **state)
{
    (void)state;
#define VISIBLE(value) "'extensions':{'KHR_node_visibility':{'visible':" value "}}"
    const char *rest = "'nodes':[{'mesh':0,'children':[1,2,3]," VISIBLE("false") "},{'mesh':0," VISIBLE(
        "true") "},"
                "{'extensions':{'KHR_lights_punctual':{'light':0}}},{'camera':0},{'mesh':0,'translation':[0,0,9]},"
                "{'mesh':0,'translation':[0,0,5],'extensions':{'KHR_node_visibility':{}}}],"
                "'cameras':[{}],'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','name':'lamp'}]}},"
                "'extensionsRequired':['KHR_node_visibility'],'animations':[{'channels':[{'target':{'path':'pointer'}}]}],"
                "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]";
    must(load_square(rest, NULL));
    assert_int_equal(m.warning_count, 0);
    assert_int_equal(s.triangle_count, 4);
    expect_corner(0, 0, 0, 0, 9);
    expect_corner(2, 0, 0, 0, 5);
    assert_true(s.light_count == 0 && s.lost_light_count == 1 && !s.lost_lights[0].why && s.camera_count == 1);
    assert_true(s.exclusion_count == 1 && s.exclusions[0].rule == EXCLUDED_AS_HIDDEN && s.exclusions[0].triangles == 4 &&
                s.exclusions[0].nodes == 4);
    must(load_placed("," VISIBLE("'no'"), "'attributes':{'POSITION':0},'indices':1"));
    assert_int_equal(s.triangle_count, 2);
    must_warn("node 0: KHR_node_visibility: 'visible' is not true or false: taken as visible");
}

static void test_unknown_extensions_are_warned_about(void **state)
{
    (void)state;
    must(load_text(
        HEAD "'extensionsUsed':['KHR_materials_unlit','ACME_holes','KHR_node_visibility','ACME_holes','EXT_lights_area']}", NULL));
    assert_int_equal(m.warning_count, 2);
    must_warn("extension ACME_holes: used, and not read");
    must_warn("extension EXT_lights_area: used, and not read");
    char   text[8192];
    size_t at = (size_t)snprintf(text, sizeof text, HEAD "'extensionsUsed':['A'");
    for (int i = 0; i < 500; i++) at += (size_t)snprintf(text + at, sizeof text - at, ",'B%d'", i);
    snprintf(text + at, sizeof text - at, "]}");
    must(load_text(text, NULL));
    assert_int_equal(m.warning_count, 17);
    must_warn("485 more extensions are used and not read");
}

static void test_lights_have_a_cone_and_a_range(void **state)
{
    (void)state;
    must(load_text(HEAD LIGHTS
                   "{'type':'spot','spot':{},'range':20},{'type':'spot','spot':{'outerConeAngle':0.5,'innerConeAngle':0.5}},"
                   "{'type':'spot','spot':{'outerConeAngle':1.57079637}},{'type':'point','range':0.25},{'type':'directional'}]}},"
                   "'nodes':[{'scale':[3,3,3]," USE(0) "},{" USE(1) "},{" USE(2) "},{" USE(3) "},{" USE(4) "}]}",
                   NULL));
    assert_true(s.lights[0].shape.outer_rad == M_PI_4 && s.lights[0].shape.range_metres == 20); /* no node scales a range */
    assert_true(s.lights[1].shape.outer_rad == 0.5 && s.lights[1].shape.range_metres == INFINITY);
    assert_true(s.lights[2].shape.outer_rad == M_PI_2); /* pi/2 as a float is more */
    assert_true(s.lights[0].inner_rad == 0 && s.lights[1].inner_rad == 0.5 && s.lights[3].inner_rad == 0);
    assert_true(s.lights[3].shape.range_metres == 0.25);
    assert_true(s.lights[4].shape.range_metres == INFINITY);
}

static void test_cameras_are_positions(void **state)
{
    (void)state;
    must(load_text(HEAD "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':1}}],"
                        "'nodes':[{'camera':0,'translation':[1,2,3]}]}",
                   NULL));
    assert_int_equal(s.camera_count, 1);
    assert_true(s.camera_positions_ws[0] == 1 && s.camera_positions_ws[1] == 2 && s.camera_positions_ws[2] == 3);
}

static void test_scenes_are_chosen_by_name_or_index(void **state)
{
    (void)state;
    const char *rest = "'nodes':[{'mesh':0},{'mesh':0,'translation':[0,0,1]}],"
                       "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],"
                       "'scene':1,'scenes':[{'name':'day','nodes':[0]},{'nodes':[1]},{'name':'0','nodes':[0,1]}]";
    must(load_square(rest, NULL));
    expect_corner(0, 0, 0, 0, 1);
    assert_string_equal(s.name, "");
    must(load_square(rest, "day"));
    expect_square();
    must(load_square(rest, "1"));
    expect_corner(0, 0, 0, 0, 1);
    must(load_square(rest, "0")); /* a name goes before an index */
    assert_int_equal(s.triangle_count, 4);
    must_fail(load_square(rest, "night"), VXS_E_ARGUMENT, "no scene 'night'; the file has 3: scene 0 'day', scene 1");
    must_fail(load_square(rest, "3"), VXS_E_ARGUMENT, "no scene '3'");
    must_fail(load_square(rest, ""), VXS_E_ARGUMENT, "no scene ''");
}

static void test_empty_things_are_fine(void **state)
{
    (void)state;
    const char *texts[] = {HEAD "'nodes':[]}", HEAD "'scenes':[{}]}", HEAD "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{}]}",
                           HEAD "'nodes':[{'mesh':0}],'meshes':[{'primitives':[]}]}"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        must(load_text(texts[i], NULL));
        assert_int_equal(s.triangle_count, 0);
        assert_non_null(s.name);
    }
    must(load_square("'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]", NULL));
    assert_int_equal(s.triangle_count, 0);
}

static void test_deep_node_trees_do_not_recurse(void **state)
{
    (void)state;
    int    count = (int)repeats(60000, 200000), at;
    size_t size  = (size_t)count * 48 + 256;
    char  *text  = malloc(size);
    assert_non_null(text);
    at = snprintf(text, size, HEAD "'nodes':[");
    for (int i = 0; i + 1 < count; i++)
        at += snprintf(text + at, size - (size_t)at, "{'children':[%d],'translation':[1,0,0]},", i + 1);
    snprintf(text + at, size - (size_t)at, "{" USE(0) "}]," LIGHTS "{'type':'point'}]}}}");
    must(load_text(text, NULL));
    assert_true(s.lights[0].shape.position_ws[0] == count - 1);
    free(text);
}

/* ---- files that must be refused ---- */

static void test_broken_scenes_say_why(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        vxs_result  code;
        const char *words;
    } broken[] = {
        {"[]", VXS_E_SCENE, "not an object"},
        {"{'asset'", VXS_E_SCENE, "parse error at line 1"},
        {"{}", VXS_E_SCENE, "'asset' is missing"},
        {"{'asset':{'version':'1.0'}}", VXS_E_UNSUPPORTED, "asset.version is 1.0"},
        {"{'asset':{'version':'2.0','minVersion':'2.1'}}", VXS_E_UNSUPPORTED, "minVersion is 2.1"},
        {HEAD "'extensionsRequired':['KHR_materials_unlit','ACME_holes']}", VXS_E_UNSUPPORTED,
         "requires the extension ACME_holes, which is not read: export it without"},
        {HEAD "'extensionsRequired':['KHR_materials_new']}", VXS_E_UNSUPPORTED, "requires the extension KHR_materials_new"},
        {HEAD "'nodes':{}}", VXS_E_SCENE, "'nodes' is not an array of objects"},
        {HEAD "'nodes':[{'mesh':'a'}]}", VXS_E_SCENE, "node 0: 'mesh' is not an integer"},
        {HEAD "'nodes':[{'mesh':-1}]}", VXS_E_SCENE, "node 0: 'mesh' is not an integer"},
        {HEAD "'nodes':[{'mesh':0}]}", VXS_E_SCENE, "node 0: mesh 0 does not exist"},
        {HEAD "'nodes':[{'camera':3}]}", VXS_E_SCENE, "camera 3 does not exist"},
        {HEAD "'nodes':[{'children':[1]}]}", VXS_E_SCENE, "child 1 does not exist"},
        {HEAD "'nodes':[{'children':[1]},{'children':[0]}]}", VXS_E_UNSUPPORTED, "loop"},
        {HEAD "'nodes':[{'children':[0]}]}", VXS_E_UNSUPPORTED, "loop"},
        {HEAD "'nodes':[{'children':[2]},{'children':[2]},{}]}", VXS_E_UNSUPPORTED, "node 2 has two parents, node 0 and node 1"},
        {HEAD "'nodes':[{'translation':[1,2]}]}", VXS_E_SCENE, "'translation' is not 3 numbers"},
        {HEAD "'nodes':[{'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]}", VXS_E_SCENE, "last row"},
        {HEAD "'scene':2,'scenes':[{}]}", VXS_E_SCENE, "default scene 2 does not exist"},
        {"{'asset':{'version':'1.1'},'geometricError':9,'root':{}}", VXS_E_UNSUPPORTED,
         "is a tileset of 3D Tiles: give the glTF files"},
        {HEAD "'scenes':[{'nodes':[1]}],'nodes':[{}]}", VXS_E_SCENE, "scene 0: node 1 does not exist"},
        {HEAD "'scenes':[{'nodes':3}],'nodes':[{}]}", VXS_E_SCENE, "scene 0: 'nodes' is not an array of indices"},
        {HEAD "'buffers':[{'byteLength':4}]}", VXS_E_SCENE, "buffer 0 has neither a uri nor a GLB chunk"},
        {HEAD "'buffers':[{'byteLength':4,'uri':'data:foo'}]}", VXS_E_SCENE, "data URI"},
        {HEAD "'buffers':[{'byteLength':4,'uri':'data:text/plain;base64,AA=='}]}", VXS_E_SCENE,
         "its data URI ends after 1 bytes, expected 4"},
        {HEAD "'buffers':[{'byteLength':4,'uri':'gone.bin'}]}", VXS_E_READ, "gone.bin': No such file"},
        {HEAD "'buffers':[{'byteLength':4,'uri':'https://example.org/a.bin'}]}", VXS_E_UNSUPPORTED, "is not a file: fetch it"},
        {HEAD "'buffers':[{'byteLength':4,'uri':'.'}]}", VXS_E_READ, "Is a directory"},
        {HEAD "'buffers':[{'byteLength':1,'uri':'data:text/plain;base64,AA=='}],'bufferViews':[{'buffer':0,'byteLength':2}]}",
         VXS_E_SCENE, "bufferView 0: 2 bytes at byte 0 do not fit"},
        {HEAD "'bufferViews':[{'buffer':0,'byteLength':2}]}", VXS_E_SCENE, "buffer 0 does not exist"},
    };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++)
        must_fail(load_text(broken[i].text, NULL), broken[i].code, broken[i].words);
}

static void test_broken_primitives_say_why(void **state)
{
    (void)state;
    static const struct {
        const char *primitive;
        vxs_result  code;
        const char *words;
    } broken[] = {
        {"'attributes':{'POSITION':99}", VXS_E_SCENE, "POSITION accessor 99 does not exist"},
        {"'attributes':{'POSITION':0},'indices':99", VXS_E_SCENE, "indices accessor 99 does not exist"},
        {"'attributes':{'POSITION':0},'indices':0", VXS_E_SCENE, "not unsigned scalars"},
        {"'attributes':{'POSITION':1}", VXS_E_SCENE, "not a VEC3"},
        {"'attributes':{'POSITION':9}", VXS_E_SCENE, "accessor 9: position 2 is not finite"},
        {"'attributes':{'POSITION':0},'indices':10", VXS_E_SCENE, "accessor 10: index 2 is 4, expected less than 4"},
        {"'attributes':{'POSITION':0},'mode':7", VXS_E_SCENE, "unknown mode 7"},
        {"'attributes':[0]", VXS_E_SCENE, "'attributes' is not an object"},
    };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++)
        must_fail(load_placed("", broken[i].primitive), broken[i].code, broken[i].words);
    must_fail(load_placed(",'scale':[1e308,1e308,1e308],'translation':[1e308,0,0]", "'attributes':{'POSITION':0}"), VXS_E_SCENE,
              "vertex 0 is not finite once placed");
    must_fail(load_placed(",'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{}}}", "'attributes':{'POSITION':0}"),
              VXS_E_SCENE, "node 0 EXT_mesh_gpu_instancing has no attributes");
}

/* A fault costs what it is in, where the rest is sound: here node 0 has a sound square, and mesh 1 of node 1 is faulty.
 * left: triangles that are there; words: of the one warning */
static void test_faults_cost_their_part(void **state)
{
    (void)state;
    static const struct {
        const char *node, *primitive; /* members of node 1 and of its primitive */
        size_t      left;
        const char *words;
    } rows[] = {
        {"", "'attributes':{'POSITION':99}", 2,
         "mesh 1 'bad' primitive 0 (node 1 'bad one'): POSITION accessor 99 does not exist: left out; mend it, or --exclude "
         "mesh:bad bakes"},
        {"", "'attributes':{'POSITION':0},'indices':99", 2, "indices accessor 99 does not exist: left out"},
        {"", "'attributes':{'POSITION':1}", 2, "accessor 1: POSITION is not a VEC3: 2 triangles left out; "},
        {"", "'attributes':{'POSITION':9}", 2, "accessor 9: position 2 is not finite: 1 triangles left out; "},
        {"", "'attributes':{'POSITION':0},'indices':10", 2,
         "accessor 10: index 2 is 4, expected less than 4: 1 triangles left out; "},
        {"", "'attributes':{'POSITION':0},'mode':7", 2, "unknown mode 7: left out"},
        {"", "'attributes':[0]", 2, "'attributes' is not an object of indices: left out"},
        {"", "'attributes':[0],'material':70000", 2, "material 70000 does not exist: ignored"},
        {"", "'attributes':{'POSITION':'a'}", 2, "'attributes' is not an object of indices"},
        {"", "'attributes':{'POSITION':0},'indices':1,'material':7", 4,
         "mesh 1 'bad' primitive 0: material 7 does not exist: ignored"},
        {"", "'attributes':{'POSITION':0,'NORMAL':99,'COLOR_0':98},'indices':1", 4, NULL},
        {"", "'attributes':{'POSITION':0},'indices':1,'targets':[{'POSITION':9}]", 4, "morph targets are baked at their default"},
        {",'weights':[1]", "'attributes':{'POSITION':0},'indices':1,'targets':[{'POSITION':9}]", 2,
         "a morph target of 3 vertices, expected 4"},
        {",'mesh':-1", "'attributes':{'POSITION':0}", 2, "node 1 'bad one': 'mesh' is not an integer"},
        {",'mesh':5", "'attributes':{'POSITION':0}", 2, "node 1 'bad one': mesh 5 does not exist, the file has 2: ignored"},
        {",'skin':5", "'attributes':{'POSITION':0},'indices':1", 4,
         "node 1 'bad one': skin 5 does not exist, the file has 0: ignored"},
        {",'camera':5", "'attributes':{'POSITION':0},'indices':1", 4,
         "node 1 'bad one': camera 5 does not exist, the file has 0: ignored"},
        {",'translation':[1,2]", "'attributes':{'POSITION':0}", 2,
         "node 1 'bad one': 'translation' is not 3 numbers: left out, with all below it"},
        {",'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]", "'attributes':{'POSITION':0}", 2,
         "the last row of its matrix is not 0, 0, 0, 1 (it seems"},
        {",'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],'scale':[2,2,2]", "'attributes':{'POSITION':0},'indices':1", 4,
         "the matrix counts"},
        {",'rotation':[0,0,0,0]", "'attributes':{'POSITION':0},'indices':1", 4,
         "its rotation is 0, 0, 0, 0, not a unit quaternion: taken as none"},
        {",'children':[9]", "'attributes':{'POSITION':0},'indices':1", 4, "node 1 'bad one': child 9 does not exist: ignored"},
        {",'children':[2,2]", "'attributes':{'POSITION':0},'indices':1", 6,
         "node 1 'bad one': child 2 is listed twice: it is placed once"},
        {",'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{}}}", "'attributes':{'POSITION':0}", 2,
         "EXT_mesh_gpu_instancing has no attributes"},
        {",'scale':[1e308,1e308,1e308],'translation':[1e308,0,0]", "'attributes':{'POSITION':0},'indices':1", 2,
         "not finite once placed: 2 triangles"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char rest[2048], mesh[16] = ",'mesh':1";
        int  has_mesh = strstr(rows[i].node, "'mesh'") != NULL, has_child = strstr(rows[i].node, "[2,2]") != NULL;
        snprintf(rest, sizeof rest,
                 "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'name':'bad one'%s%s},{%s}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]},{'name':'bad','primitives':[{%s}]}]",
                 has_mesh ? "" : mesh, rows[i].node, has_child ? "'mesh':0,'translation':[0,0,3]" : "", rows[i].primitive);
        must(load_square(rest, NULL));
        if (s.triangle_count != rows[i].left) fail_msg("row %zu: %zu triangles", i, s.triangle_count);
        if (!rows[i].words) assert_int_equal(m.warning_count, 0);
        if (rows[i].words) must_warn(rows[i].words);
        assert_true(m.warning_count <= 2 && (has_child || !rows[i].words || m.warning_count >= 1));
        forget();
        m.strict = 1; /* and refuses all of it */
        if (rows[i].words) assert_int_equal(scene_load_gltf(&s, path, &chosen, &m), VXS_E_STRICT);
    }
}

/* Ten thousand faults are a few lines and a count. */
static void test_many_faults_are_few_lines(void **state)
{
    (void)state;
    size_t size = 10000 * 64 + 512, at;
    char  *rest = malloc(size), *json = malloc(size + 8192);
    assert_true(rest && json);
    at = (size_t)snprintf(rest, size, "'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}");
    for (int i = 0; i < 10000; i++) at += (size_t)snprintf(rest + at, size - at, ",{'attributes':{'POSITION':99},'indices':1}");
    snprintf(rest + at, size - at, "]}]");
    square q = make_square();
    square_json(json, size + 8192, rest);
    uint8_t *glb = make_glb(json, &q, sizeof q, &size);
    write_file("many.glb", glb, size);
    must(load_file(path, NULL));
    assert_int_equal(s.triangle_count, 2);
    assert_int_equal(m.warning_count, 4);
    must_warn("9997 more primitives are left out, 19994 in all; see to those above");
    free(glb);
    free(rest);
    free(json);
}

/* Faults of a scene's roots that have one reading. */
static void test_roots_are_mended(void **state)
{
    (void)state;
    static const struct {
        const char *roots, *moved; /* moved: members of node 0, parent of node 1 */
        size_t      triangles;
        double      x; /* of the first corner of the first */
        const char *words;
    } rows[] = {
        {"[1]", "", 2, 0,
         "scene 0: node 1 'crate' is not a root, its parent is node 0 'group', which is not in the scene: it is taken as a root; "},
        {"[1]", "'translation':[5,0,0],", 2, 0, "it is taken as a root, and its parent's transform is not applied; "},
        {"[0,1]", "'translation':[5,0,0],", 2, 5,
         "node 1 'crate' is listed, and is a child of node 0 'group', too: it is placed once, under its parent; "},
        {"[0,0]", "'translation':[5,0,0],", 2, 5, "scene 0: node 0 'group' is listed twice: it is placed once; "},
        {"[0,7]", "", 2, 0, "scene 0: node 7 does not exist: ignored; "},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char rest[512];
        snprintf(rest, sizeof rest,
                 "'scenes':[{'nodes':%s}],'nodes':[{%s'name':'group','children':[1]},{'name':'crate','mesh':0}],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]",
                 rows[i].roots, rows[i].moved);
        must(load_square(rest, NULL));
        assert_int_equal(s.triangle_count, rows[i].triangles);
        expect_corner(0, 0, rows[i].x, 0, 0);
        assert_int_equal(m.warning_count, 1);
        must_warn(rows[i].words);
    }
    must(load_square("'scene':3,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}"
                     ",'indices':1}]}]",
                     NULL));
    must_warn("glTF: its default scene 3 does not exist, the file has 1: scene 0 is taken; ");
    must(load_square(
        "'scenes':[{'nodes':[0]},{}],'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]",
        NULL));
    must_warn("glTF: it has 2 scenes, and says of none that it is the default: scene 0 is taken; ");
}

/* What a truncated buffer still has is read. */
static void test_truncated_buffers_cost_what_lies_behind(void **state)
{
    (void)state;
    const char *json =
        HEAD "'buffers':[{'byteLength':72,'uri':'cut.bin'}],'bufferViews':[{'buffer':0,'byteLength':72}],'accessors':["
             "{'bufferView':0,'componentType':5126,'type':'VEC3','count':3},"
             "{'bufferView':0,'byteOffset':36,'componentType':5126,'type':'VEC3','count':3}],'nodes':[{'mesh':0}],"
             "'meshes':[{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':1}}]}]}";
    square q = make_square();
    write_file("cut.bin", &q, 71);
    must(load_text(json, NULL));
    assert_int_equal(s.triangle_count, 1);
    must_warn("mesh 0 primitive 1 (node 0): buffer 0: 'cut.bin' ends after 71 bytes, expected 72: 1 triangles left out; ");
    write_file("cut.bin", &q, 35);
    must_fail(load_text(json, NULL), VXS_E_SCENE, "buffer 0: 'cut.bin' ends after 35 bytes, expected 72"); /* nothing is left */
    assert_int_equal(unlink(path), 0);
    char gone[300];
    snprintf(gone, sizeof gone, "%s/cut.bin", folder);
    unlink(gone);
    must_fail(load_text(json, NULL), VXS_E_READ, "cannot read buffer 0, '");
    write_file("CUT.BIN", &q, 72);
    must_fail(load_text(json, NULL), VXS_E_READ, "there is 'CUT.BIN': rename it");
}

/* Scripts and printf write numbers that JSON has not: they cost what needs them. */
static void test_numbers_that_are_none(void **state)
{
    (void)state;
    static const char *const numbers[] = {"NaN", "-Infinity", "inf", "-nan(ind)", "1.#QNAN", "1e999"};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        char rest[512];
        snprintf(rest, sizeof rest,
                 "'nodes':[{'mesh':0},{'mesh':0,'name':'NaN, -inf','translation':[0,%s,0]}],'extras':[%s],"
                 "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]",
                 numbers[i], numbers[i]);
        must(load_square(rest, NULL));
        assert_int_equal(s.triangle_count, 2);
        must_warn("JSON: 2 numbers are NaN or infinite, which JSON has not");
        must_warn("node 1 'NaN, -inf': 'translation' is not an array of numbers: left out");
    }
    must_fail(load_text("{'asset':{'version':'2.0'},'nodes':[nano]}", NULL), VXS_E_SCENE, "parse error");
}

/* 24.0 is 24 where an integer is expected; bytes that are no UTF-8 are Latin-1, in names and nearly nowhere else. */
static void test_numbers_and_letters_of_other_languages(void **state)
{
    (void)state;
    must(load_square(
        "'scene':0.0,'scenes':[{'nodes':[0e0,1.0]}],'nodes':[{'mesh':0.0},{'mesh':0,'name':'B\xe4r','translation':[0,1.0,-0.0]}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0.0},'indices':1.0,'mode':4.0}]}]",
        NULL));
    assert_int_equal(s.triangle_count, 4);
    assert_int_equal(m.warning_count, 1);
    must_warn("JSON: 1 bytes are no UTF-8: taken as Latin-1; save it as UTF-8");
    must(load_square(
        "'nodes':[{'mesh':0},{'name':'B\xe4r','scale':[1]}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]",
        NULL));
    must_warn("node 1 'B\xc3\xa4r': 'scale' is not 3 numbers: left out");
    must_fail(load_square("'nodes':[{'mesh':0.5}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]", NULL),
              VXS_E_SCENE, "'mesh' is not an integer from 0 to 2147483647");
}

/* A version as a number, or without its point, is one. */
static void test_versions_as_they_are_written(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        char text[128];
        snprintf(text, sizeof text, "{'asset':{'version':%s}}", i == 0 ? "2.0" : i == 1 ? "2" : "'2'");
        must(load_text(text, NULL));
    }
    must_fail(load_text("{'asset':{'version':1.0}}", NULL), VXS_E_UNSUPPORTED,
              "asset.version is 1.0, expected 2.0: glTF 1.0 is another format");
}

/* Accessors that leave their bufferView, sums that leave 64 bits, promises that no memory could keep. */
static void test_accessors_stay_in_their_buffer(void **state)
{
    (void)state;
    static const struct {
        const char *accessor, *words;
    } broken[] = {
        {"'bufferView':0,'count':4,'byteOffset':1", "do not fit in bufferView 0"},
        {"'bufferView':0,'count':5", "do not fit in bufferView 0"},
        {"'bufferView':0,'count':9007199254740991", "do not fit in bufferView 0"},
        {"'bufferView':0,'count':1,'byteOffset':9007199254740991", "do not fit in bufferView 0"},
        {"'bufferView':0,'count':18446744073709551615", "'count' is not an integer"},
        {"'bufferView':7,'count':1", "bufferView 7 does not exist"},
        {"'bufferView':1,'count':1", "byteStride 4 is less"},
        {"'bufferView':0,'count':1.5", "'count' is not an integer"},
        {"'count':100000000", "sparse accessors would hold more"},
        {"'count':4,'sparse':{'count':5,'indices':{'bufferView':0,'componentType':5121},'values':{'bufferView':0}}",
         "sparse count 5 exceeds"},
        {"'count':4,'sparse':{'count':2,'indices':{'bufferView':0,'componentType':5121},'values':{'bufferView':0}}",
         "sparse index 1 is 0"},
        {"'count':4,'sparse':{'count':4,'indices':{'bufferView':0,'byteOffset':45,'componentType':5121},"
         "'values':{'bufferView':0}}",
         "sparse indices: 4 elements at byte 45 do not fit"},
        {"'count':4,'sparse':{'count':2,'indices':{'bufferView':0,'componentType':5126},'values':{'bufferView':0}}",
         "componentType 5126"},
        {"'count':4,'sparse':{'count':2}", "sparse: 'indices' is missing"},
    };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        char    json[1024];
        uint8_t bin[48] = {0};
        size_t  size;
        snprintf(json, sizeof json,
                 HEAD "'buffers':[{'byteLength':48}],'bufferViews':[{'buffer':0,'byteLength':48},"
                      "{'buffer':0,'byteLength':48,'byteStride':4}],"
                      "'accessors':[{'componentType':5126,'type':'VEC3',%s}],'nodes':[{'mesh':0}],"
                      "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
                 broken[i].accessor);
        uint8_t *glb = make_glb(json, bin, sizeof bin, &size);
        write_file("accessor.glb", glb, size);
        free(glb);
        vxs_result r = load_file(path, NULL);
        must_fail(r, strstr(broken[i].words, "would hold") ? VXS_E_UNSUPPORTED : VXS_E_SCENE, broken[i].words);
    }
}

static void test_instancing_is_counted_before_it_is_allocated(void **state)
{
    (void)state;
    size_t size = 100000 * 16 + 4096;
    char  *rest = malloc(size);
    assert_non_null(rest);
    int at = snprintf(rest, size, "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0}");
    for (int i = 0; i < 100000; i++) at += snprintf(rest + at, size - (size_t)at, ",{'mesh':0}");
    char *json = malloc(size);
    assert_non_null(json);
    snprintf(json, size, HEAD "'accessors':[{'componentType':5126,'type':'VEC3','count':3300}],%s]}", rest);
    must_fail(load_text(json, NULL), VXS_E_UNSUPPORTED, "more than 67108864 triangles");
    free(json);
    free(rest);
}

static void test_deep_json_is_refused(void **state)
{
    (void)state;
    size_t depth = 100000;
    char  *text  = malloc(2 * depth + 64);
    assert_non_null(text);
    int at = sprintf(text, HEAD "'extras':");
    memset(text + at, '[', depth);
    memset(text + at + depth, ']', depth);
    strcpy(text + at + 2 * depth, "}");
    must_fail(load_text(text, NULL), VXS_E_SCENE, "nested too deeply");
    free(text);
}

static void test_every_prefix_of_a_glb_is_refused(void **state)
{
    (void)state;
    square q = make_square();
    char   json[8192];
    size_t size;
    square_json(json, sizeof json, "'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]");
    uint8_t *glb = make_glb(json, &q, sizeof q, &size);
    for (size_t length = 0; length < size; length += length < 32 || size - length < 700 ? 1 : 61) {
        write_file("prefix.glb", glb, length);
        assert_int_not_equal(load_file(path, NULL), VXS_OK);
        /* and with a header that admits to it */
        if (length >= 20) {
            uint8_t *copy = malloc(length);
            assert_non_null(copy);
            memcpy(copy, glb, length);
            memcpy(copy + 8, &(uint32_t){(uint32_t)length}, 4);
            write_file("prefix.glb", copy, length);
            free(copy);
            assert_int_not_equal(load_file(path, NULL), VXS_OK);
        }
        assert_true(m.error[0]);
    }
    write_file("prefix.glb", glb, size);
    must(load_file(path, NULL));
    glb[4] = 1;
    write_file("prefix.glb", glb, size);
    must_fail(load_file(path, NULL), VXS_E_UNSUPPORTED, "GLB version 1");
    free(glb);
}

static void test_unreadable_files_say_why(void **state)
{
    (void)state;
    char gone[300];
    snprintf(gone, sizeof gone, "%s/gone.glb", folder);
    must_fail(load_file(gone, NULL), VXS_E_READ, "gone.glb': No such file or directory");
    must_fail(load_file(folder, NULL), VXS_E_READ, "Is a directory");
    write_file("empty.glb", "", 0);
    must_fail(load_file(path, NULL), VXS_E_READ, "the file is empty");
}

/* A buffer beside the file: its name is percent-encoded, a plus is a plus, and bytes after byteLength do not matter. */
static void test_buffers_beside_the_file(void **state)
{
    (void)state;
    const char *json = HEAD "'buffers':[{'byteLength':36,'uri':'%s'}],'bufferViews':[{'buffer':0,'byteLength':36}],"
                            "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}],'nodes':[{'mesh':0}],"
                            "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}";
    char        text[1024];
    square      q = make_square();
    snprintf(text, sizeof text, json, "a%20b+c%25.bin");
    write_file("a b+c%.bin", &q, 36);
    must(load_text(text, NULL));
    expect_corner(0, 2, 1, 1, 0);
    write_file("a b+c%.bin", &q, 48);
    must(load_text(text, NULL));
    assert_int_equal(s.triangle_count, 1);
    write_file("a b+c%.bin", &q, 35);
    must_fail(load_text(text, NULL), VXS_E_SCENE, "'a%20b+c%25.bin' ends after 35 bytes, expected 36");
    snprintf(text, sizeof text, json, "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA");
    must(load_text(text, NULL));
    expect_corner(0, 2, 1, 1, 0);
}

/* Data URIs as they are written: schemes and "base64" in any case, parameters, no media type, blanks, other
 * alphabets (RFC 2397). */
static void test_data_uris_of_every_kind(void **state)
{
    (void)state;
    static const char *const uris[] = {
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA",
        "DATA:application/octet-stream;BASE64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA",
        "data:application/octet-stream;charset=utf-8;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA",
        "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA",
        "data:image/png;base64,AAAAAAAAAAAAAAAAAACA\\nPwAAAAAAAAAAAACAPwAAgD8AAAAA",
        "data:;base64,AAAAAAAAAAAAAAAAAACA%50wAAAAAAAAAAAACAPwAAgD8AAAAA",
        "data:,%00%00%00%00%00%00%00%00%00%00%00%00%00%00%80%3f%00%00%00%00%00%00%00%00%00%00%80%3f%00%00%80%3f%00%00%00%00",
    };
    const char *json = HEAD "'buffers':[{'byteLength':36,'uri':'%s'}],'bufferViews':[{'buffer':0,'byteLength':36}],"
                            "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}],'nodes':[{'mesh':0}],"
                            "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}";
    char        text[1024];
    for (size_t i = 0; i < sizeof uris / sizeof *uris; i++) {
        snprintf(text, sizeof text, json, uris[i]);
        must(load_text(text, NULL));
        expect_corner(0, 2, 1, 1, 0);
        assert_int_equal(m.warning_count, 0);
    }
    char *large = malloc(2000000);
    assert_non_null(large);
    int at = sprintf(large, HEAD "'buffers':[{'byteLength':36,'uri':'data:x;base64,");
    memset(large + at, '!', 1500000);
    strcpy(large + at + 1500000, "'}]}");
    must_fail(load_text(large, NULL), VXS_E_SCENE, "buffer 0: its data URI has a character that is no base64, 0 behind the comma");
    assert_true(strlen(m.error) < 200);
    memcpy(large + at - 14, "dota:x;base64,", 14); /* no data, so the name of a file */
    must_fail(load_text(large, NULL), VXS_E_READ, "cannot read buffer 0, '");
    assert_true(strlen(m.error) < 300);
    free(large);
}

/* Names lead to files in the scene's folder, and out of it where that is requested. */
static void test_files_outside_of_the_folder(void **state)
{
    (void)state;
    static const struct {
        const char *uri;
        int         outside;
    } rows[] = {
        {"sub/b.bin", 0},         {"sub/../sub/./b.bin", 0},      {"sub\\\\b.bin", 0},           {"link.bin", 0},
        {"a%20b.bin", 0},         {"../%s/sub/b.bin", 1},         {"sub/../../%s/sub/b.bin", 1}, {"%%2e%%2e/%s/sub/b.bin", 1},
        {"/tmp/%s/sub/b.bin", 1}, {"file:///tmp/%s/sub/b.bin", 1}};
    square q = make_square();
    char   sub[300], link[300], text[1024], uri[200];
    snprintf(sub, sizeof sub, "%s/sub", folder);
    assert_int_equal(mkdir(sub, 0700), 0);
    write_file("sub/b.bin", &q, 36);
    write_file("a%20b.bin", &q, 36); /* a name that was never encoded */
    snprintf(link, sizeof link, "%s/link.bin", folder);
    snprintf(sub, sizeof sub, "%s/sub/b.bin", folder);
    assert_int_equal(symlink(sub, link), 0);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        for (int allowed = 0; allowed < 2; allowed++) {
            if (rows[i].outside)
                snprintf(uri, sizeof uri, rows[i].uri, strrchr(folder, '/') + 1);
            else
                strcpy(uri, rows[i].uri);
            snprintf(text, sizeof text,
                     HEAD "'buffers':[{'byteLength':36,'uri':'%s'}],'bufferViews':[{'buffer':0,'byteLength':36}],"
                          "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}],'nodes':[{'mesh':0}],"
                          "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]}",
                     uri);
            chosen.allow_outside = allowed;
            if (rows[i].outside && !allowed) {
                must_fail(load_text(text, NULL), VXS_E_READ, "is not in the scene's folder: --allow-outside reads it all the same");
            } else {
                must(load_text(text, NULL));
                assert_int_equal(s.triangle_count, 1);
            }
        }
    choose(NULL, NULL);
    chosen.allow_outside = 0;
    unlink(sub);
    unlink(link);
    snprintf(sub, sizeof sub, "%s/sub", folder);
    rmdir(sub);
}

/* ---- real scenes ---- */

typedef struct known_scene {
    const char *file;
    size_t      triangles;
    double      min[3], max[3]; /* four significant digits, as printed */
} known_scene;

#define SPOT(name)                                                                                                                 \
    {                                                                                                                              \
        "encodings/" name, 5856, {-0.4716, -0.7368, -0.6689},                                                                      \
        {                                                                                                                          \
            0.4716, 0.9536, 1.049                                                                                                  \
        }                                                                                                                          \
    }

/* clang-format off */
static const known_scene known[] = {
    {"sponza.glb", 262267, {-15.37, -1.012, -9.462}, {14.4, 11.44, 8.843}},
    {"dream_apartment.glb", 177934, {0.4438, -0.09928, -11.43}, {12.81, 2.681, -0.13}},
    {"pandora_indoor.glb", 60810, {-736, 0, -416}, {736, 448, 416}},
    {"stanford_bunny_closed.glb", 144046, {-0.9559, 0.021, -0.543}, {0.6579, 1.642, 0.6895}},
    {"voxel_district.glb", 672420, {-19.3, 0, -12.8}, {19.3, 6.4, 12.8}},
    {"kaykit_city.glb", 177426, {-13, 0, -13}, {13, 3.05, 13.09}},
    {"mountains_heightfield.glb", 25600, {-1, -0.08558, -1}, {1.002, 0.2493, 1.006}},
    {"low_poly_terrain.glb", 3868, {-8.513, -1.085, -8.224}, {8.17, 9.056, 8.515}},
    {"truck_town.glb", 30477, {-1024, -4.64, -1024}, {1024, 17.76, 1024}},
    {"dutch_ship_mask.glb", 69162, {-10.33, -2, -3.488}, {13.74, 22.66, 3.321}},
    {"chess_board.glb", 178848, {-157.5, -1.346, -136.5}, {179.6, 42.25, 136.5}},
    {"room_with_spheres_closed.glb", 63720, {-5, 0, -5}, {5, 5, 5}},
    {"japanese_bridge_garden.glb", 21883, {-5.527, 0.3775, -5.265}, {5.833, 7.39, 6.101}},
    {"camp_and_cave_two_scenes.glb", 5894, {-6.031, -0.7172, -12.03}, {6.227, 5.954, 9.747}},
    {"sunlit_primitives.glb", 10610, {-3.238, 0.1682, -3.238}, {3.238, 1.175, 3.238}},
    {"skylight_hall_directional.glb", 360, {-3.16, 0.01578, -6.742}, {3.16, 6.322, 6.742}},
    {"features/lights_point_spot_directional.glb", 12, {-1, -1, -1}, {1, 1, 1}},
    {"features/cubes_point_light.glb", 36, {-4.284, -1.938, -2.994}, {4.603, 3.591, 3.639}},
    {"features/primitives_four_materials.glb", 12, {-1, -1, -1}, {1, 1, 1}},
    {"features/sparse_morph_cube.glb", 12, {-0.005, -0.005, -0.005}, {0.005, 0.005, 0.005}},
    {"features/negative_scale_cube.gltf", 12, {-3, -1, -2}, {3, 1, 2}},
    {"features/subpass_scene_mirrored.gltf", 23388, {-11, -9.714, -11}, {11, 0.4864, 11}},
    {"features/duck.glb", 4212, {-0.693, 0.09929, -0.6133}, {0.9618, 1.64, 0.5393}},
    {"features/Lantern/Lantern.gltf", 5394, {-3.922, 0.1839, -2.316}, {11.57, 25.85, 2.316}},
    {"features/CesiumMilkTruck/CesiumMilkTruck.gltf", 3624, {-3.601, -1.621, -2.191}, {1.548, 3.002, 2.191}},
    {"features/Box/Box.gltf", 12, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"features/Box.glb", 12, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}},
    {"features/RiggedFigure/RiggedFigure.gltf", 256, {-0.5895, 0, -0.1309}, {0.5895, 1.45, 0.195}},
    {"features/Fox.glb", 576, {-12.59, -0.1217, -88.1}, {12.59, 78.91, 66.62}},
    {"features/AnimatedMorphCube/AnimatedMorphCube.gltf", 12, {-1, -1, -1}, {1, 1, 1}},
    {"features/TriangleWithoutIndices.gltf", 1, {0, 0, 0}, {1, 1, 0}},
    {"features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf", 0, {0, 0, 0}, {0, 0, 0}},
    {"features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_04.gltf", 2, {-0.5, -0.5, 0}, {0.5, 0.5, 0}},
    {"features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2, {-0.5, -0.5, 0}, {0.5, 0.5, 0}},
    {"features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2, {-0.5, -0.5, 0}, {0.5, 0.5, 0}},
    {"features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_14.gltf", 2, {-0.5, -0.5, 0}, {0.5, 0.5, 0}},
    {"features/02_node_hierarchy/02_node_hierarchy.gltf", 60, {-1, -1, -1}, {5, 5, 1}},
    {"features/01_single_vs_double_sided/01_single_vs_double_sided.gltf", 1480, {-3.5, -0.9432, -1}, {1, 0.9432, 1}},
    {"features/01_vertex_count_16bit/01_vertex_count_16bit.gltf", 130378, {-1, -1, -2.627}, {1, 1, 2.8}},
    {"features/00_no_scenes/00_no_scenes.gltf", 12, {-1, -1, -1}, {1, 1, 1}},
    {"features/00_empty_scene/00_empty_scene.gltf", 0, {0, 0, 0}, {0, 0, 0}},
    {"features/mesh_without_node.gltf", 0, {0, 0, 0}, {0, 0, 0}},
    {"kaykit_city_gpu_instancing.glb", 177426, {-13, 0, -13}, {13, 3.05, 13.09}},
    {"features/simple_instancing.glb", 1500, {-1.667, -1.667, -1.667}, {12.73, 12.73, 12.73}},
    {"features/pirate_meshopt_quantized.glb", 5010, {-0.7606, -0.001088, -0.2295}, {0.7605, 1.904, 0.2258}},
    {"features/heart_draco.glb", 180, {-0.04013, 0.001632, -0.01983}, {0.0402, 0.06879, 0.01975}},
    SPOT("spot.glb"), SPOT("spot_quantized.glb"), SPOT("spot_meshopt.glb"), SPOT("spot_u32.glb"), SPOT("spot_noindex.glb"), SPOT("spot_u8_chunks.glb"), SPOT("spot_fans.glb"),
    SPOT("spot_sparse.glb"), SPOT("spot_sparse_no_view.glb"), SPOT("spot_strided.glb"), SPOT("spot_negative_scale.glb"),
    SPOT("spot_deep_nodes.glb"), SPOT("spot_separate/spot.gltf"), SPOT("spot_datauri.gltf"),
    {"encodings/spot_draco.glb", 5856, {-0.4716, -0.7368, -0.6689}, {0.4716, 0.9537, 1.049}},
    {"encodings/spot_strip.glb", 35131, {-0.4716, -0.7368, -0.6689}, {0.4716, 0.9536, 1.049}},
};
/* clang-format on */

/* Equal once printed with as many digits as the known figure has. */
static void expect_printed(const char *file, double value, double printed)
{
    char text[32];
    snprintf(text, sizeof text, "%.4g", fabs(value) < 1e-6 ? 0 : value); /* joints turn and turn back, which rounds */
    if (strtod(text, NULL) != printed) fail_msg("%s: bound %s, expected %g", file, text, printed);
}

static void expect_bounds(const known_scene *k)
{
    for (size_t axis = 0; axis < 3; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < s.vertex_count; i++) {
            low  = fmin(low, s.positions_ws[3 * i + axis]);
            high = fmax(high, s.positions_ws[3 * i + axis]);
        }
        expect_printed(k->file, low, k->min[axis]);
        expect_printed(k->file, high, k->max[axis]);
    }
}

/* Six times the enclosed volume: positive when a closed surface is turned outward. */
static double volume(void)
{
    double sum = 0;
    for (size_t t = 0; t < s.triangle_count; t++) {
        const double *a = s.positions_ws + 3 * s.indices[3 * t], *b = s.positions_ws + 3 * s.indices[3 * t + 1],
                     *c = s.positions_ws + 3 * s.indices[3 * t + 2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum;
}

static void test_real_scenes_have_their_known_figures(void **state)
{
    (void)state;
    const char *scenes = scenes_folder();
    double      spot   = 0;
    chosen.skinned     = SKINNED_REST;
    chosen.blend       = BLEND_OPAQUE; /* all triangles */
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        char file[512];
        snprintf(file, sizeof file, "%s/real/%s", scenes, known[i].file);
        must(load_file(file, NULL));
        if (s.triangle_count != known[i].triangles) fail_msg("%s: %zu triangles", known[i].file, s.triangle_count);
        for (size_t k = 0; k < 3 * s.triangle_count; k++) assert_true(s.indices[k] < s.vertex_count);
        if (s.triangle_count) expect_bounds(&known[i]);
        if (!strncmp(known[i].file, "encodings/", 10)) {
            if (!spot) spot = volume();
            int rounded = strstr(known[i].file, "quantized") || strstr(known[i].file, "draco") || strstr(known[i].file, "meshopt");
            assert_true(spot > 0 && fabs(volume() - spot) < (rounded ? 1e-4 : 1e-6) * spot); /* same surface, same side outward */
        }
        if (strstr(known[i].file, "spot_fans")) assert_int_equal(s.vertex_count, 2930);
    }
    choose(NULL, NULL);
}

static void test_real_lights_and_scenes(void **state)
{
    (void)state;
    char        file[512];
    const char *scenes = scenes_folder();
    chosen.blend       = BLEND_OPAQUE;
    snprintf(file, sizeof file, "%s/real/features/lights_point_spot_directional.glb", scenes);
    must(load_file(file, NULL));
    int count[3] = {0, 0, 0};
    for (size_t i = 0; i < s.light_count; i++) count[s.lights[i].shape.kind]++;
    assert_true(count[LIGHT_DIRECTIONAL] == 1 && count[LIGHT_SPOT] == 2 && count[LIGHT_POINT] == 1);
    for (size_t i = 0; i < s.light_count; i++)
        if (s.lights[i].shape.kind == LIGHT_SPOT)
            assert_true(s.lights[i].shape.outer_rad > 0 && s.lights[i].shape.range_metres > 0);
    snprintf(file, sizeof file, "%s/real/camp_and_cave_two_scenes.glb", scenes);
    must(load_file(file, "1"));
    assert_int_equal(s.triangle_count, 5894);
    must(load_file(file, "0"));
    assert_int_not_equal(s.triangle_count, 5894);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_indices_of_every_type),
        cmocka_unit_test(test_no_indices_ignore_a_partial_triangle),
        cmocka_unit_test(test_strip_alternates_its_winding),
        cmocka_unit_test(test_fan_ends_every_triangle_at_its_first_vertex),
        cmocka_unit_test(test_stride_and_offset),
        cmocka_unit_test(test_sparse_replaces_positions),
        cmocka_unit_test(test_transforms_are_applied_scale_first),
        cmocka_unit_test(test_hierarchy_multiplies),
        cmocka_unit_test(test_mirrored_nodes_turn_the_winding_back),
        cmocka_unit_test(test_vertices_are_shared_within_a_node),
        cmocka_unit_test(test_morph_targets_take_default_weights),
        cmocka_unit_test(test_materials_set_flags),
        cmocka_unit_test(test_points_and_lines_are_warned_about),
        cmocka_unit_test(test_parts_name_triangles),
        cmocka_unit_test(test_patterns_choose_what_casts),
        cmocka_unit_test(test_patterns_that_name_nothing_are_refused),
        cmocka_unit_test(test_instances_are_one_part),
        cmocka_unit_test(test_extras_say_what_casts_no_shadow),
        cmocka_unit_test(test_skinned_meshes_are_left_out),
        cmocka_unit_test(test_skinned_meshes_stand_by_their_joints),
        cmocka_unit_test(test_broken_skins_cost_their_primitive),
        cmocka_unit_test(test_traps_are_said),
        cmocka_unit_test(test_lights_follow_their_nodes),
        cmocka_unit_test(test_lights_have_names_of_nodes),
        cmocka_unit_test(test_bad_lights_cost_themselves),
        cmocka_unit_test(test_uses_of_lights_that_are_not_there),
        cmocka_unit_test(test_dark_lights_are_known),
        cmocka_unit_test(test_hidden_nodes_show_nothing),
        cmocka_unit_test(test_unknown_extensions_are_warned_about),
        cmocka_unit_test(test_lights_have_a_cone_and_a_range),
        cmocka_unit_test(test_cameras_are_positions),
        cmocka_unit_test(test_scenes_are_chosen_by_name_or_index),
        cmocka_unit_test(test_empty_things_are_fine),
        cmocka_unit_test(test_deep_node_trees_do_not_recurse),
        cmocka_unit_test(test_broken_scenes_say_why),
        cmocka_unit_test(test_broken_primitives_say_why),
        cmocka_unit_test(test_faults_cost_their_part),
        cmocka_unit_test(test_many_faults_are_few_lines),
        cmocka_unit_test(test_roots_are_mended),
        cmocka_unit_test(test_truncated_buffers_cost_what_lies_behind),
        cmocka_unit_test(test_numbers_that_are_none),
        cmocka_unit_test(test_numbers_and_letters_of_other_languages),
        cmocka_unit_test(test_versions_as_they_are_written),
        cmocka_unit_test(test_accessors_stay_in_their_buffer),
        cmocka_unit_test(test_instancing_is_counted_before_it_is_allocated),
        cmocka_unit_test(test_deep_json_is_refused),
        cmocka_unit_test(test_every_prefix_of_a_glb_is_refused),
        cmocka_unit_test(test_unreadable_files_say_why),
        cmocka_unit_test(test_buffers_beside_the_file),
        cmocka_unit_test(test_data_uris_of_every_kind),
        cmocka_unit_test(test_files_outside_of_the_folder),
        cmocka_unit_test(test_real_scenes_have_their_known_figures),
        cmocka_unit_test(test_real_lights_and_scenes),
    };
    return cmocka_run_group_tests_name("scene_gltf", tests, make_folder, remove_folder);
}
