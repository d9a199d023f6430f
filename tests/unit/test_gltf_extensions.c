/* Extensions of glTF that carry geometry: instances, quantised, compressed. Files are made here; meshoptimizer's own encoder makes
 * compressed bufferViews, so that what was encoded is known. Draco's files are real ones (test_scene_gltf.c, tests/cli).
 * In the JSON below ' stands for ", so that it can be read.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/gltf_file.h"

#include <meshoptimizer.h>

static uint8_t bin[4096];
static size_t  bin_size;

/* Append to the binary chunk; where it lies. */
static size_t put(const void *bytes, size_t size)
{
    size_t at = bin_size;
    assert_true(at + size <= sizeof bin);
    memcpy(bin + at, bytes, size);
    bin_size = (at + size + 3) / 4 * 4;
    return at;
}

static vxs_result load_bin(const char *json)
{
    size_t   size;
    uint8_t *glb = make_glb(json, bin, bin_size, &size);
    write_file("extension.glb", glb, size);
    free(glb);
    return load_file(path, NULL);
}

#define TRIANGLE "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"
static const float corners[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

/* ---- KHR_mesh_quantization ---- */

static vxs_result load_quantized(int component, int size, int normalized, const char *used)
{
    char json[1024];
    snprintf(
        json, sizeof json,
        "{'asset':{'version':'2.0'},%s'buffers':[{'byteLength':48}],'bufferViews':[{'buffer':0,'byteLength':48,'byteStride':%d}],"
        "'accessors':[{'bufferView':0,'componentType':%d,'type':'VEC3','count':3%s}],'nodes':[{'mesh':0}]," TRIANGLE "}",
        used, 4 * size, component, normalized ? ",'normalized':true" : "");
    bin_size = 48;
    return load_bin(json);
}

static void test_quantized_positions_of_every_type(void **state)
{
    (void)state;
    static const struct {
        int    component, size, is_signed;
        double largest;
    } types[] = {{5120, 1, 1, 127}, {5121, 1, 0, 255}, {5122, 2, 1, 32767}, {5123, 2, 0, 65535}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        for (int normalized = 0; normalized < 2; normalized++) {
            memset(bin, 0, sizeof bin);
            for (int corner = 0; corner < 3; corner++) /* corner 1: largest, 7, 0;  corner 2: lowest, 0, 0 */
                if (types[i].size == 1) {
                    uint8_t v[3] = {(uint8_t[]){0, types[i].is_signed ? 127 : 255, types[i].is_signed ? 0x80 : 1}[corner],
                                    corner == 1 ? 7 : 0, 0};
                    memcpy(bin + 4 * corner, v, 3);
                } else {
                    uint16_t v[3] = {(uint16_t[]){0, types[i].is_signed ? 32767 : 65535, types[i].is_signed ? 0x8000 : 1}[corner],
                                     corner == 1 ? 7 : 0, 0};
                    memcpy(bin + 8 * corner, v, 6);
                }
            must(load_quantized(types[i].component, types[i].size, normalized, "'extensionsRequired':['KHR_mesh_quantization'],"));
            double scale  = normalized ? 1 / types[i].largest : 1;
            double lowest = !types[i].is_signed ? scale : normalized ? -1 : -types[i].largest - 1;
            expect_corner(0, 0, 0, 0, 0);
            expect_corner(0, 1, types[i].largest * scale, 7 * scale, 0);
            expect_corner(0, 2, lowest, 0, 0);
        }
    must(load_quantized(5122, 2, 0, "")); /* the accessor says what it is; that the extension is used, some exporters forget to */
    assert_true(s.triangle_count == 1 && m.warning_count == 0);
    must_fail(load_quantized(5125, 4, 0, "'extensionsUsed':['KHR_mesh_quantization'],"), VXS_E_SCENE, "32-bit integers");
}

/* ---- EXT_mesh_gpu_instancing ---- */

/* accessor 0: the triangle; 1: two translations; 2: two rotations, normalised shorts; 3: two scales; 4: three scales; 5: two zero
 * rotations; 6: a broken translation */
static vxs_result load_instances(const char *node)
{
    static const float   translations[2][3] = {{10, 0, 0}, {0, 20, 0}};
    static const int16_t rotations[2][4]    = {{0, 0, 0, 32767}, {0, 0, 32767, 0}};
    static const float   scales[3][3]       = {{1, 2, 1}, {-1, 1, 1}, {1, 1, 1}};
    static const int16_t none[2][4]         = {{0}};
    static const float   broken[2][3]       = {{0, 0, 0}, {INFINITY, 0, 0}};
    char                 json[4096];
    bin_size = 0;
    put(corners, sizeof corners);
    size_t t = put(translations, sizeof translations), r = put(rotations, sizeof rotations), z = put(scales, sizeof scales),
           n = put(none, sizeof none), b = put(broken, sizeof broken);
    snprintf(json, sizeof json,
             "{'asset':{'version':'2.0'},'extensionsRequired':['EXT_mesh_gpu_instancing'],'buffers':[{'byteLength':%zu}],"
             "'bufferViews':[{'buffer':0,'byteLength':%zu}],'accessors':["
             "{'bufferView':0,'componentType':5126,'type':'VEC3','count':3},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC3','count':2},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5122,'normalized':true,'type':'VEC4','count':2},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC3','count':2},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC3','count':3},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5122,'normalized':true,'type':'VEC4','count':2},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC3','count':2},"
             "{'componentType':5126,'type':'VEC3','count':16000000},{'componentType':5126,'type':'VEC3','count':17000000},"
             "{'componentType':5126,'type':'VEC3','count':900}],'nodes':[{%s,"
             "'extensions':{'EXT_mesh_gpu_instancing':{%s}}}],'meshes':["
             "{'primitives':[{'attributes':{'POSITION':0}}]},{'primitives':[{'attributes':{'POSITION':9}}]}]}",
             bin_size, bin_size, t, r, z, z, n, b, strstr(node, "huge") ? "'mesh':1" : "'mesh':0,'translation':[100,7,5]",
             strstr(node, "huge") ? "'attributes':{'TRANSLATION':7}" : node);
    return load_bin(json);
}

static void test_instances_are_placed(void **state)
{
    (void)state;
    must(load_instances("'attributes':{'TRANSLATION':1}"));
    assert_int_equal(s.triangle_count, 2);
    assert_int_equal(s.vertex_count, 6);
    expect_corner(0, 1, 111, 7, 5);
    expect_corner(1, 2, 100, 28, 5);

    must(load_instances("'attributes':{'TRANSLATION':1,'ROTATION':2,'SCALE':3,'_ID':0}"));
    expect_corner(0, 2, 110, 9, 5);
    expect_corner(1, 0, 100, 27, 5); /* mirrored: two corners change places; then half a turn about z */
    expect_corner(1, 1, 100, 26, 5);
    expect_corner(1, 2, 101, 27, 5);

    must(load_instances("'attributes':{'_ID':1}")); /* two, one over the other */
    assert_int_equal(s.triangle_count, 2);
    expect_corner(1, 1, 101, 7, 5);
}

static void test_broken_instances_say_why(void **state)
{
    (void)state;
    static const struct {
        const char *extension, *words;
        vxs_result  code;
    } broken[] = {
        {"'attributes':{}", "node 0 EXT_mesh_gpu_instancing has no attributes", VXS_E_SCENE},
        {"'attributes':[]", "'attributes' is not an object", VXS_E_SCENE},
        {"'count':3", "'attributes' is missing", VXS_E_SCENE},
        {"'attributes':{'TRANSLATION':99}", "TRANSLATION: accessor 99 does not exist", VXS_E_SCENE},
        {"'attributes':{'_ID':99}", "accessor 99 does not exist", VXS_E_SCENE},
        {"'attributes':{'TRANSLATION':2}", "accessor 2 is not a VEC3", VXS_E_SCENE},
        {"'attributes':{'ROTATION':1}", "accessor 1 is not a VEC4", VXS_E_SCENE},
        {"'attributes':{'TRANSLATION':1,'SCALE':4}", "3 elements, the attribute before has 2", VXS_E_SCENE},
        {"huge", "more than 67108864 triangles", VXS_E_UNSUPPORTED}, /* 16 million instances of 300 triangles, in 1 KB */
        {"'attributes':{'TRANSLATION':8}", "would hold more than 16777216 elements", VXS_E_UNSUPPORTED},
    };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++)
        must_fail(load_instances(broken[i].extension), broken[i].code, broken[i].words);
    must(load_instances("'attributes':{'TRANSLATION':1,'ROTATION':5}"));
    assert_int_equal(s.triangle_count, 2);
    expect_corner(0, 1, 111, 7, 5);
    must(load_instances("'attributes':{'TRANSLATION':6}")); /* one of them is nowhere */
    assert_int_equal(s.triangle_count, 1);
    must_warn("is not finite once placed: 1 triangles left out; ");
    must(load_instances("'attributes':{'TRANSLATION':1,'ROTATION':5}"));
    must_warn("node 0 EXT_mesh_gpu_instancing: ROTATION 0 is not a unit quaternion: taken as none; ");
}

/* ---- EXT_meshopt_compression, KHR_meshopt_compression ---- */

static uint8_t stream[1024];
static size_t  stream_size;

/* A buffer of 4-component shorts or floats (bufferView 0) and indices (1), compressed; buffer 1 is a fallback without data. */
typedef struct meshopt_file {
    const char *name, *mode, *filter; /* of the extension; of positions */
    int         component, stride, count;
    const char *index_mode;
    uint8_t     indices[256];
    size_t      index_bytes;
    const char *more; /* members of the extension of bufferView 0 */
} meshopt_file;

static vxs_result load_meshopt(const meshopt_file *f)
{
    char json[4096];
    bin_size  = 0;
    size_t at = put(stream, stream_size), index_at = put(f->indices, f->index_bytes);
    snprintf(json, sizeof json,
             "{'asset':{'version':'2.0'},'extensionsRequired':['%s','KHR_mesh_quantization'],'buffers':[{'byteLength':%zu},"
             "{'byteLength':4096,'extensions':{'%s':{'fallback':true}}}],'bufferViews':["
             "{'buffer':1,'byteLength':%d,'byteStride':%d,'extensions':{'%s':{'buffer':0,'byteOffset':%zu,'byteLength':%zu,"
             "'byteStride':%d,'count':%d,'mode':'%s'%s%s%s%s}}},"
             "{'buffer':1,'byteLength':6,'extensions':{'%s':{'buffer':0,'byteOffset':%zu,'byteLength':%zu,"
             "'byteStride':2,'count':3,'mode':'%s'}}}],'accessors':["
             "{'bufferView':0,'componentType':%d,'type':'VEC3','count':3},{'bufferView':1,'componentType':5123,'type':'SCALAR','"
             "count':3}],"
             "'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]}",
             f->name, bin_size, f->name, f->count * f->stride, f->stride, f->name, at, stream_size, f->stride, f->count, f->mode,
             f->filter ? ",'filter':'" : "", f->filter ? f->filter : "", f->filter ? "'" : "", f->more ? f->more : "", f->name,
             index_at, f->index_bytes, f->index_mode, f->component);
    return load_bin(json);
}

static meshopt_file triangle_file(const char *name)
{
    static const int16_t shorts[3][4] = {{0, 0, 0, 0}, {100, 0, 0, 0}, {0, 200, -300, 0}};
    meshopt_file f = {.name = name, .mode = "ATTRIBUTES", .component = 5122, .stride = 8, .count = 3, .index_mode = "TRIANGLES"};
    stream_size    = meshopt_encodeVertexBuffer(stream, sizeof stream, shorts, 3, 8);
    f.index_bytes  = meshopt_encodeIndexBuffer(f.indices, sizeof f.indices, (const unsigned[]){0, 1, 2}, 3);
    return f;
}

static void test_meshopt_streams_are_decoded(void **state)
{
    (void)state;
    static const char *const names[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
    for (int i = 0; i < 2; i++) {
        meshopt_file f = triangle_file(names[i]);
        for (int sequence = 0; sequence < 2; sequence++) {
            if (sequence) {
                f.index_mode  = "INDICES";
                f.index_bytes = meshopt_encodeIndexSequence(f.indices, sizeof f.indices, (const unsigned[]){0, 1, 2}, 3);
            }
            must(load_meshopt(&f));
            assert_int_equal(s.triangle_count, 1);
            expect_corner(0, 1, 100, 0, 0);
            expect_corner(0, 2, 0, 200, -300);
        }
    }
}

static void test_meshopt_filters_are_undone(void **state)
{
    (void)state;
    static const float source[3][4] = {{0, 0, 0, 0}, {0.5f, 0, 0, 0}, {0, 0.25f, -2, 0}};
    uint32_t           encoded[3][4];
    meshopt_file       f = triangle_file("EXT_meshopt_compression");
    meshopt_encodeFilterExp(encoded, 3, 16, 15, &source[0][0]);
    stream_size = meshopt_encodeVertexBuffer(stream, sizeof stream, encoded, 3, 16);
    f.filter = "EXPONENTIAL", f.component = 5126, f.stride = 16;
    must(load_meshopt(&f));
    expect_corner(0, 1, 0.5, 0, 0);
    expect_corner(0, 2, 0, 0.25, -2);

    /* unit vectors, as positions of a small sphere */
    static const float normals[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    int8_t             packed[3][4];
    meshopt_encodeFilterOct(packed, 3, 4, 8, &normals[0][0]);
    stream_size = meshopt_encodeVertexBuffer(stream, sizeof stream, packed, 3, 4);
    f.filter = "OCTAHEDRAL", f.component = 5120, f.stride = 4;
    must(load_meshopt(&f));
    expect_corner(0, 0, 127, 0, 0);
    expect_corner(0, 1, 0, 127, 0);
    expect_corner(0, 2, 0, 0, 127);

    static const float turns[3][4] = {{0, 0, 0, 1}, {1, 0, 0, 0}, {0, 1, 0, 0}};
    int16_t            quaternions[3][4];
    meshopt_encodeFilterQuat(quaternions, 3, 8, 16, &turns[0][0]);
    stream_size = meshopt_encodeVertexBuffer(stream, sizeof stream, quaternions, 3, 8);
    f.filter = "QUATERNION", f.component = 5122, f.stride = 8;
    must(load_meshopt(&f));
    expect_corner(0, 0, 0, 0, 0);
    expect_corner(0, 1, 32767, 0, 0);
    expect_corner(0, 2, 0, 32767, 0);
}

static void test_broken_meshopt_says_why(void **state)
{
    (void)state;
    meshopt_file good = triangle_file("EXT_meshopt_compression"), f = good;
    f.mode   = "TRIS", must_fail(load_meshopt(&f), VXS_E_SCENE, "bufferView 0 EXT_meshopt_compression: unknown mode 'TRIS'"),
    f        = good;
    f.filter = "COLOR", must_fail(load_meshopt(&f), VXS_E_SCENE, "unknown filter 'COLOR'"), f = good;
    f.filter = "QUATERNION", f.stride = 4, must_fail(load_meshopt(&f), VXS_E_SCENE, "byteStride is 4, expected 8"), f = good;
    f.mode = "INDICES", must_fail(load_meshopt(&f), VXS_E_SCENE, "byteStride is 8, expected 2 or 4"), f = good;
    f.mode = "TRIANGLES", f.filter = "OCTAHEDRAL", f.stride = 4,
    must_fail(load_meshopt(&f), VXS_E_SCENE, "filter OCTAHEDRAL with mode TRIANGLES"), f = good;
    f.mode = "TRIANGLES", f.stride = 2, f.count = 4, must_fail(load_meshopt(&f), VXS_E_SCENE, "multiple of 3"), f = good;
    f.stride = 6, must_fail(load_meshopt(&f), VXS_E_SCENE, "byteStride is 6"), f = good;
    f.count = 0, must_fail(load_meshopt(&f), VXS_E_SCENE, "bufferView 0: byteLength is 0"), f = good;
    f.count = 512, must_fail(load_meshopt(&f), VXS_E_SCENE, "bytes cannot hold 4096"), f = good;
    f.more = ",'count':4", must_fail(load_meshopt(&f), VXS_E_SCENE, "4 elements of 8 bytes, in a bufferView of 24"), f = good;
    f.more = ",'buffer':1", must_fail(load_meshopt(&f), VXS_E_SCENE, "buffer 1 holds nothing but a fallback"), f = good;
    f.more = ",'buffer':2", must_fail(load_meshopt(&f), VXS_E_SCENE, "buffer 2 does not exist"), f = good;
    f.more = ",'byteLength':4096", must_fail(load_meshopt(&f), VXS_E_SCENE, "do not fit in buffer 0"), f = good;
    f.index_mode = "INDICES", must_fail(load_meshopt(&f), VXS_E_SCENE, "its INDICES cannot be decompressed"), f = good;

    f.name = "KHR_meshopt_compression", f.filter = "COLOR", must_fail(load_meshopt(&f), VXS_E_UNSUPPORTED, "COLOR is not read");
    f.filter = NULL, stream[0] = 0xa1, must_fail(load_meshopt(&f), VXS_E_UNSUPPORTED, "version 1 of the vertex codec");
}

/* Every prefix of the streams, and every byte of them changed: a line, never a crash (the sanitizers look on). */
static void test_hostile_meshopt_streams(void **state)
{
    (void)state;
    meshopt_file good = triangle_file("EXT_meshopt_compression"), f = good;
    size_t       size = stream_size;
    for (stream_size = 1; stream_size < size; stream_size++) assert_int_not_equal(load_meshopt(&good), VXS_OK);
    for (f.index_bytes = 1; f.index_bytes < good.index_bytes; f.index_bytes++) assert_int_not_equal(load_meshopt(&f), VXS_OK);
    for (size_t i = 0; i < size; i++)
        for (int bit = 0; bit < 8; bit++) {
            stream[i] ^= (uint8_t)(1 << bit);
            vxs_result r = load_meshopt(&good);
            assert_true(r == VXS_OK || m.error[0]);
            stream[i] ^= (uint8_t)(1 << bit);
        }
    f = good;
    for (size_t i = 0; i < good.index_bytes; i++)
        for (int bit = 0; bit < 8; bit++) {
            f.indices[i] ^= (uint8_t)(1 << bit);
            vxs_result r = load_meshopt(&f);
            assert_true(r == VXS_OK || m.error[0]);
            f.indices[i] ^= (uint8_t)(1 << bit);
        }
    must(load_meshopt(&good));
}

static void test_views_of_a_fallback_have_no_data(void **state)
{
    (void)state;
    must_fail(load_text(HEAD
                        "'buffers':[{'byteLength':36,'extensions':{'EXT_meshopt_compression':{'fallback':true}}}],"
                        "'bufferViews':[{'buffer':0,'byteLength':36}],"
                        "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}],'nodes':[{'mesh':0}]," TRIANGLE
                        "}",
                        NULL),
              VXS_E_SCENE, "bufferView 0 is not compressed, and its buffer 0 holds nothing but a fallback");
}

/* ---- KHR_draco_mesh_compression: what can be said without an encoder ---- */

static void test_broken_draco_says_why(void **state)
{
    (void)state;
    static const struct {
        const char *primitive, *words;
        vxs_result  code;
    } broken[] = {
        {"'indices':1,'extensions':{'KHR_draco_mesh_compression':{'bufferView':0,'attributes':{'POSITION':0}}}", "is not a mesh",
         VXS_E_SCENE},
        {"'indices':1,'extensions':{'KHR_draco_mesh_compression':{'bufferView':9,'attributes':{}}}", "bufferView 9 does not exist",
         VXS_E_SCENE},
        {"'indices':1,'extensions':{'KHR_draco_mesh_compression':{'attributes':{}}}", "'bufferView' is missing", VXS_E_SCENE},
        {"'indices':1,'extensions':{'KHR_draco_mesh_compression':{'bufferView':0,'attributes':{'POSITION':'a'}}}",
         "object of indices", VXS_E_SCENE},
        {"'indices':1,'mode':5,'extensions':{'KHR_draco_mesh_compression':{'bufferView':0,'attributes':{}}}",
         "indexed triangles only", VXS_E_UNSUPPORTED},
        {"'extensions':{'KHR_draco_mesh_compression':{'bufferView':0,'attributes':{}}}", "indexed triangles only",
         VXS_E_UNSUPPORTED},
    };
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        char json[2048];
        snprintf(json, sizeof json,
                 "{'asset':{'version':'2.0'},'buffers':[{'byteLength':36}],'bufferViews':[{'buffer':0,'byteLength':36}],"
                 "'accessors':[{'componentType':5126,'type':'VEC3','count':3},{'componentType':5123,'type':'SCALAR','count':3}],"
                 "'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},%s}]}]}",
                 broken[i].primitive);
        bin_size = 0;
        put(corners, sizeof corners);
        must_fail(load_bin(json), broken[i].code, broken[i].words);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quantized_positions_of_every_type),
        cmocka_unit_test(test_instances_are_placed),
        cmocka_unit_test(test_broken_instances_say_why),
        cmocka_unit_test(test_meshopt_streams_are_decoded),
        cmocka_unit_test(test_meshopt_filters_are_undone),
        cmocka_unit_test(test_broken_meshopt_says_why),
        cmocka_unit_test(test_hostile_meshopt_streams),
        cmocka_unit_test(test_views_of_a_fallback_have_no_data),
        cmocka_unit_test(test_broken_draco_says_why),
    };
    return cmocka_run_group_tests_name("gltf_extensions", tests, make_folder, remove_folder);
}
