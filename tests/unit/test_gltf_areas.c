/* Area lights of glTF scenes: which triangles are one, where its corner and its sides are, how its texture lies, and what shines
 * and is none. In the JSON below ' stands for ", so that it can be read.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/gltf_file.h"

#include <png.h>

/* A parallelogram of the triangles 0 1 2, 0 2 3; its texture upright, and in mirror and three times; a bent one; other orders of
 * the same corners. */
typedef struct area_bytes {
    float    corners[4][3], bent[4][3], uvs[4][2], others[4][2];
    uint16_t indices[6], strip[4], last_first[6];
    uint8_t  png[256];
} area_bytes;

static area_bytes bin = {.corners    = {{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 1, 0}},
                         .bent       = {{0, 0, 0}, {2, 0, 0}, {3, 1.1F, 0}, {1, 1, 0}},
                         .uvs        = {{0, 1}, {1, 1}, {1, 0}, {0, 0}},
                         .others     = {{3, 1}, {0, 1}, {0, 0}, {3, 0}},
                         .indices    = {0, 1, 2, 0, 2, 3},
                         .strip      = {0, 1, 3, 2},
                         .last_first = {2, 3, 0, 1, 2, 0}};

/* Upper row red, green; lower row blue, half of white. */
static size_t write_png(void)
{
    static const uint8_t rgba[4][4] = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {188, 188, 188, 255}};
    png_image            image      = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 2, .format = PNG_FORMAT_RGBA};
    png_alloc_size_t     size       = sizeof bin.png;
    assert_int_not_equal(png_image_write_to_memory(&image, bin.png, &size, 0, rgba, 0, NULL), 0);
    return size;
}

/* node, primitive, material  members of these; textures  what is beside them */
static void load_area(const char *node, const char *primitive, const char *material, const char *textures)
{
    char   json[4096];
    size_t size, at[] = {offsetof(area_bytes, bent),    offsetof(area_bytes, uvs),   offsetof(area_bytes, others),
                         offsetof(area_bytes, indices), offsetof(area_bytes, strip), offsetof(area_bytes, last_first)};
    snprintf(json, sizeof json,
             HEAD "'buffers':[{'byteLength':%zu}],'bufferViews':[{'buffer':0,'byteLength':%zu},{'buffer':0,'byteOffset':%zu,'"
                  "byteLength':%zu}],"
                  "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':4},"
                  "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC3','count':4},"
                  "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC2','count':4},"
                  "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC2','count':4},"
                  "{'bufferView':0,'byteOffset':%zu,'componentType':5123,'type':'SCALAR','count':6},"
                  "{'bufferView':0,'byteOffset':%zu,'componentType':5123,'type':'SCALAR','count':4},"
                  "{'bufferView':0,'byteOffset':%zu,'componentType':5123,'type':'SCALAR','count':6}],"
                  "'nodes':[{'name':'screen','mesh':0%s}],'meshes':[{'primitives':[{%s,'material':0}]}],'materials':[{%s}]%s}",
             sizeof bin, offsetof(area_bytes, png), offsetof(area_bytes, png), write_png(), at[0], at[1], at[2], at[3], at[4],
             at[5], node, primitive, material, textures);
    uint8_t *glb = make_glb(json, &bin, sizeof bin, &size);
    write_file("area.glb", glb, size);
    free(glb);
    chosen.areas = 1;
    must(load_file(path, NULL));
}

#define PLAIN   "'attributes':{'POSITION':0},'indices':4"
#define SEEN    "'attributes':{'POSITION':0,'TEXCOORD_0':2},'indices':4"
#define SHINES  "'emissiveFactor':[1,0.5,0]"
#define SHOWS   SHINES ",'emissiveTexture':{'index':0}"
#define TEXTURE ",'textures':[{'source':0}],'images':[{'bufferView':1,'mimeType':'image/png'}]"

static void expect(const double v[3], double x, double y, double z)
{
    if (fabs(v[0] - x) + fabs(v[1] - y) + fabs(v[2] - z) > 1e-6)
        fail_msg("(%g %g %g), expected (%g %g %g)", v[0], v[1], v[2], x, y, z);
}

static void expect_texels(const float *wanted, uint32_t wide, uint32_t high)
{
    const scene_area *a = s.areas;
    assert_true(a->wide_px == wide && a->high_px == high);
    for (size_t n = 0; n < 3 * (size_t)wide * high; n++)
        if (fabs((double)a->texture[n] - (double)wanted[n]) > 4e-3) fail_msg("%zu is %g", n, (double)a->texture[n]);
}

/* Whatever the order of its corners, sides and front are the same; a stronger emission has larger values. */
static void test_corners(void **state)
{
    (void)state;
    static const char *const primitives[] = {PLAIN, "'attributes':{'POSITION':0},'indices':5,'mode':5",
                                             "'attributes':{'POSITION':0},'indices':6"};
    for (size_t n = 0; n < 3; n++) {
        double front[3];
        load_area("", primitives[n], SHINES ",'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':4}}", "");
        assert_int_equal(s.area_count, 1);
        const double *a = s.areas->across_ws, *b = s.areas->up_ws;
        for (int i = 0; i < 3; i++) front[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
        expect(front, 0, 0, 2);
        assert_true(s.areas->radiance[0] == 4 && s.areas->radiance[1] == 2 && s.areas->radiance[2] == 0);
        assert_true(s.areas->part == 0 && !s.areas->texture && !s.dim_count && !m.warning_count);
    }
    load_area(",'translation':[5,0,0],'scale':[-1,3,1]", PLAIN, SHINES, ""); /* it still shines along +Z */
    expect(s.areas->corner_ws, 3, 0, 0);
    expect(s.areas->across_ws, 2, 0, 0);
    expect(s.areas->up_ws, -1, 3, 0);
}

/* The first row of texels lies along the first side. */
static void test_textures(void **state)
{
    (void)state;
    static const float upright[] = {0.5F, 0.5F, 0.5F, 0, 1, 0, 0, 0, 1, 1, 0, 0};
    float              thrice[36];
    load_area("", SEEN, SHOWS, TEXTURE);
    expect(s.areas->across_ws, 1, 1, 0);
    expect(s.areas->up_ws, -2, 0, 0);
    expect_texels(upright, 2, 2);
    load_area("", "'attributes':{'POSITION':0,'TEXCOORD_0':3},'indices':4", SHOWS, TEXTURE);
    for (int n = 0; n < 36; n++) thrice[n] = upright[(n + 6) % 12];
    expect_texels(thrice, 2, 6);
    load_area("", SEEN, SHOWS, ",'textures':[{'source':0}],'images':[{'uri':'data:image/jpeg;base64,/9j/2Q=='}]");
    must_warn("its emissiveTexture is not read");
    assert_true(!s.areas->texture && fabs((double)s.areas->radiance[0] - 0.45) < 1e-6);
    load_area("", PLAIN, SHOWS, TEXTURE);
    must_warn("its emissiveTexture is not read");
}

/* Nothing fails by what pictures alone request; and without the choice nothing is read. */
static void test_none(void **state)
{
    (void)state;
    load_area("", "'attributes':{'POSITION':1},'indices':4", SHINES, "");
    assert_true(!s.area_count && s.dim_count == 2);
    load_area("", PLAIN, "'emissiveFactor':[1,2]", "");
    assert_true(!s.area_count && !s.dim_count);
    load_area("", PLAIN, "'emissiveFactor':[0,0,0],'emissiveTexture':{'index':7}", "");
    assert_true(!s.area_count && !s.dim_count);
    load_area("", SEEN, SHOWS, TEXTURE);
    chosen.areas = 0;
    must(load_file(path, NULL));
    assert_true(!s.area_count && !s.dim_count && !m.warning_count);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_corners),
        cmocka_unit_test(test_textures),
        cmocka_unit_test(test_none),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
