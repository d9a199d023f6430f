/* Masks: what a material with alphaMode MASK becomes. Images are made here, by the encoders of libpng and libwebp.
 * In the JSON below ' stands for ", so that it can be read.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/gltf_file.h"

#include <png.h>
#include <webp/encode.h>

static uint8_t bin[16384];
static size_t  bin_size, image_at, image_bytes;

/* The square of two triangles, its texture coordinates as floats (1) and as normalised shorts (2), colours with (3) and without
 * holes (4), a broken coordinate (5), indices (6), coordinates as bytes that are not normalised (7). Then the image: bufferView
 * 1. */
static struct {
    float    corners[4][3], uvs[4][2];
    uint16_t shorts[4][2];
    float    clear[4][4], solid[4][4], broken[4][2];
    uint8_t  indices[8], bytes[4][4];
} square = {.corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
            .uvs     = {{0, 1}, {1, 1}, {1, 0}, {0, 0}},
            .shorts  = {{0, 65535}, {65535, 65535}, {65535, 0}, {0, 0}},
            .clear   = {{1, 1, 1, 1}, {1, 1, 1, 0.5f}, {1, 1, 1, 1}, {1, 1, 1, 1}},
            .solid   = {{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}},
            .broken  = {{0, 1}, {NAN, 1}, {1, 0}, {0, 0}},
            .indices = {0, 1, 2, 0, 2, 3},
            .bytes   = {{0, 1}, {1, 1}, {1, 0}, {0, 0}}};

static void use_bytes(const void *bytes, size_t size)
{
    assert_true(sizeof square + size <= sizeof bin);
    memcpy(bin, &square, sizeof square);
    image_at = sizeof square;
    memcpy(bin + image_at, bytes, image_bytes = size);
    bin_size = image_at + size;
}

/* 2 x 2 pixels with these alphas. */
static void use_png(uint8_t a, uint8_t b, uint8_t c, uint8_t d)
{
    uint8_t          rgba[4][4] = {{9, 9, 9, a}, {9, 9, 9, b}, {9, 9, 9, c}, {9, 9, 9, d}}, bytes[1024];
    png_image        image      = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 2, .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size       = sizeof bytes;
    assert_int_not_equal(png_image_write_to_memory(&image, bytes, &size, 0, rgba, 0, NULL), 0);
    use_bytes(bytes, size);
}

static void use_webp(uint8_t a, uint8_t b, uint8_t c, uint8_t d)
{
    uint8_t rgba[4][4] = {{9, 9, 9, a}, {9, 9, 9, b}, {9, 9, 9, c}, {9, 9, 9, d}}, *bytes = NULL;
    size_t  size = WebPEncodeLosslessRGBA(&rgba[0][0], 2, 2, 8, &bytes);
    assert_int_not_equal(size, 0);
    use_bytes(bytes, size);
    WebPFree(bytes);
}

static const char *mode = "MASK"; /* alphaMode of the next load */

/* material: members of the material but alphaMode; rest: textures, samplers, images, more */
static vxs_result load_mask(const char *node, const char *attributes, const char *material, const char *rest)
{
    char   json[8192];
    size_t size, at = (size_t)(square.uvs[0] - square.corners[0]) * sizeof(float);
    snprintf(json, sizeof json,
             "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%zu}],'bufferViews':[{'buffer':0,'byteLength':%zu},"
             "{'buffer':0,'byteOffset':%zu,'byteLength':%zu}],'accessors':["
             "{'bufferView':0,'componentType':5126,'type':'VEC3','count':4},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC2','count':4},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5123,'normalized':true,'type':'VEC2','count':4},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC4','count':4},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC4','count':4},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5126,'type':'VEC2','count':4},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5121,'type':'SCALAR','count':6},"
             "{'bufferView':0,'byteOffset':%zu,'componentType':5123,'type':'VEC2','count':4}],"
             "'nodes':[{'mesh':0%s}],'meshes':[{'primitives':[{'attributes':{'POSITION':0%s},'indices':6,'material':0},"
             "{'attributes':{'POSITION':0},'indices':6}]}],"
             "'materials':[{'name':'leaf','alphaMode':'%s',%s}],%s}",
             bin_size, sizeof square, image_at, image_bytes, at, at + 32, at + 48, at + 112, at + 176, at + 208, at + 216, node,
             attributes, mode, material, rest);
    uint8_t *glb = make_glb(json, bin, bin_size, &size);
    write_file("mask.glb", glb, size);
    free(glb);
    return load_file(path, NULL);
}

#define UV      ",'TEXCOORD_0':1"
#define BASE    "'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}"
#define TEXTURE "'textures':[{'source':0}],'images':[{'name':'pic','bufferView':1,'mimeType':'image/png'}]"

static void expect_uv(size_t i, int corner, double u, double v)
{
    const float *uv = s.holed_triangles[i].uv[corner];
    if (fabs(uv[0] - u) > 1e-6 || fabs(uv[1] - v) > 1e-6) fail_msg("triangle %zu corner %d: %g %g", i, corner, uv[0], uv[1]);
}

static void test_a_texture_makes_holes(void **state)
{
    (void)state;
    for (int webp = 0; webp < 2; webp++) {
        if (webp)
            use_webp(0, 255, 200, 100);
        else
            use_png(0, 255, 200, 100);
        must(load_mask("", UV, BASE, TEXTURE));
        assert_int_equal(m.warning_count, 0);
        assert_int_equal(s.triangle_count, 4);
        assert_int_equal(s.triangle_flags[0], TRIANGLE_ALPHA_MASK);
        assert_int_equal(s.triangle_flags[2], 0);
        assert_int_equal(s.image_count, 1);
        assert_true(s.images[0].width_px == 2 && s.images[0].height_px == 2);
        assert_memory_equal(s.images[0].alpha, ((uint8_t[]){0, 255, 200, 100}), 4);
        assert_int_equal(s.alpha_mask_count, 1);
        assert_true(s.alpha_masks[0].image == 0 && s.alpha_masks[0].threshold == 0.5f && !s.alpha_masks[0].nearest);
        assert_true(s.alpha_masks[0].wrap_u == WRAP_REPEAT && s.alpha_masks[0].wrap_v == WRAP_REPEAT);
        assert_int_equal(s.holed_triangle_count, 2);
        assert_true(s.holed_triangles[0].triangle == 0 && s.holed_triangles[1].triangle == 1 && s.holed_triangles[1].mask == 0);
        expect_uv(0, 0, 0, 1);
        expect_uv(0, 1, 1, 1);
        expect_uv(1, 1, 1, 0);
        expect_uv(1, 2, 0, 0);
    }
}

static void test_texture_coordinates_of_every_kind(void **state)
{
    (void)state;
    use_png(0, 255, 255, 255);
    must(load_mask("", ",'TEXCOORD_0':2", BASE, TEXTURE));
    expect_uv(0, 1, 1, 1);
    must(load_mask("", ",'TEXCOORD_3':1", "'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':3}}", TEXTURE));
    expect_uv(0, 1, 1, 1);
    must(load_mask("", ",'TEXCOORD_0':7", BASE, TEXTURE ",'extensionsUsed':['KHR_mesh_quantization']"));
    expect_uv(0, 0, 256, 0);                               /* bytes 0, 1 as a short */
    must(load_mask("", ",'TEXCOORD_0':0", BASE, TEXTURE)); /* three where two are enough: assimp writes the third */
    expect_uv(0, 1, 1, 0);
    expect_uv(0, 2, 1, 1);
    assert_int_equal(m.warning_count, 0);
    must(load_mask(",'scale':[-1,1,1]", UV, BASE, TEXTURE)); /* corners change places, and take their coordinates along */
    expect_corner(0, 1, -1, 1, 0);
    expect_uv(0, 1, 1, 0);
    expect_uv(0, 2, 1, 1);
}

static void test_samplers_wrap_and_filter(void **state)
{
    (void)state;
    use_png(0, 255, 255, 255);
    must(load_mask("", UV, BASE,
                   "'textures':[{'source':0,'sampler':1}],'samplers':[{},{'magFilter':9728,'wrapS':33071,'wrapT':33648}],"
                   "'images':[{'bufferView':1}]"));
    assert_true(s.alpha_masks[0].nearest && s.alpha_masks[0].wrap_u == WRAP_CLAMP && s.alpha_masks[0].wrap_v == WRAP_MIRROR);
    must(load_mask("", UV, BASE,
                   "'textures':[{'source':0,'sampler':0}],'samplers':[{'magFilter':9729}],'images':[{'bufferView':1}]"));
    assert_true(!s.alpha_masks[0].nearest);
}

/* offset, a quarter turn and scale: as the sample viewer of the Khronos group moves it. */
static void test_texture_transform_moves_coordinates(void **state)
{
    (void)state;
    use_png(0, 255, 255, 255);
    must(load_mask("", ",'TEXCOORD_1':1",
                   "'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':"
                   "{'offset':[10,20],'rotation':1.5707963267948966,'scale':[2,3],'texCoord':1}}}}",
                   TEXTURE));
    expect_uv(0, 0, 13, 20); /* (0, 1) */
    expect_uv(0, 1, 13, 18); /* (1, 1) */
    expect_uv(0, 2, 10, 18); /* (1, 0) */
    expect_uv(1, 2, 10, 20); /* (0, 0) */
}

static void test_the_cutoff_is_held_against_the_product(void **state)
{
    (void)state;
    use_png(0, 255, 200, 100);
    must(load_mask("", UV,
                   "'alphaCutoff':0.2,'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.8],'baseColorTexture':{'index':0}}",
                   TEXTURE));
    assert_true(s.alpha_masks[0].threshold == 0.25f);
    must(load_mask(
        "", UV, "'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[1,1,1,0.75],'diffuseTexture':{'index':0}}}",
        TEXTURE));
    assert_true(fabsf(s.alpha_masks[0].threshold - 2 / 3.0f) < 1e-6f);
}

static void test_masks_that_are_none(void **state)
{
    (void)state;
    static const char *const plain[] = {"'doubleSided':true", "'alphaCutoff':0", "'pbrMetallicRoughness':{}",
                                        "'alphaCutoff':0.39," BASE,
                                        "'alphaCutoff':0.25,'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.25]}"};
    use_png(100, 255, 255, 255);
    for (size_t i = 0; i < sizeof plain / sizeof *plain; i++) {
        must(load_mask("", UV, plain[i], TEXTURE));
        assert_int_equal(s.triangle_count, 4);
        assert_int_equal(s.triangle_flags[0] & TRIANGLE_ALPHA_MASK, 0);
        assert_true(!s.images && !s.alpha_masks && !s.holed_triangles && !s.holed_triangle_count && !m.warning_count);
    }
    must(load_mask("", UV, "'alphaCutoff':0.4," BASE, TEXTURE)); /* 100 / 255 is 0.392 */
    assert_int_equal(s.holed_triangle_count, 2);
    use_bytes("\xff\xd8\xff\xe0 pixels \xff\xd9", 14);
    must(load_mask("", "", BASE, TEXTURE)); /* a JPEG is opaque: no coordinates are needed */
    assert_int_equal(s.triangle_flags[0], 0);
}

/* Masks that have no holes by what is hardly meant so. */
static void test_masks_that_are_traps(void **state)
{
    (void)state;
    use_bytes("\xff\xd8\xff\xe0 pixels \xff\xd9", 14);
    must(load_mask("", UV, BASE, TEXTURE));
    assert_int_equal(m.warning_count, 1);
    assert_string_equal(
        m.warnings[0], "material 0 'leaf' (node 0, mesh 0 primitive 0): is a mask, but image 0 has no alpha: there are no holes, 2 "
                       "triangles; store it with its alpha as PNG or WebP, or set alphaMode to OPAQUE");
    uint8_t          rgb[4][3] = {{9, 9, 9}, {9, 9, 9}, {9, 9, 9}, {9, 9, 9}}, bytes[1024];
    png_image        image     = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 2, .format = PNG_FORMAT_RGB};
    png_alloc_size_t size      = sizeof bytes;
    assert_int_not_equal(png_image_write_to_memory(&image, bytes, &size, 0, rgb, 0, NULL), 0);
    use_bytes(bytes, size);
    must(load_mask("", UV, BASE, TEXTURE));
    must_warn("image 0 has no alpha");
    use_png(0, 255, 255, 255);
    must(load_mask("", UV, "'alphaCutoff':0," BASE, TEXTURE));
    assert_int_equal(m.warning_count, 1);
    must_warn("alphaCutoff is 0, which any alpha reaches: there are no holes, 2 triangles; raise alphaCutoff");
}

/* BLEND: of the light that gets through, the nearer of all and nothing; or a wall; or nothing. */
static void test_blend_is_chosen(void **state)
{
    (void)state;
    static const struct {
        int         blend;
        uint8_t     alpha[4];
        const char *material;
        size_t      triangles, holed;
        const char *words; /* of the one warning where --blend is not given */
    } rows[] = {
        {BLEND_MASK,
         {0, 255, 255, 255},
         BASE,
         4,
         2,
         "alphaMode BLEND is baked as a mask, a wall where alpha is 0.5 or more and nothing elsewhere, 2 triangles; "},
        {BLEND_MASK, {255, 255, 255, 255}, BASE, 4, 0, NULL},
        {BLEND_MASK, {0, 0, 0, 0}, BASE, 2, 0, NULL},
        {BLEND_MASK, {255, 255, 255, 255}, "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.51]}", 4, 0, "is baked as a mask"},
        {BLEND_MASK,
         {255, 255, 255, 255},
         "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.49]}",
         2,
         0,
         "alphaMode BLEND, with an alpha below 0.5 everywhere, casts nothing: 2 triangles left out; "},
        {BLEND_MASK,
         {255, 255, 255, 255},
         "'alphaCutoff':0.1,'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.3]}",
         2,
         0,
         "casts nothing"},
        {BLEND_MASK, {255, 255, 255, 255}, "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0]}", 2, 0, NULL},
        {BLEND_OPAQUE, {0, 255, 255, 255}, BASE, 4, 0, ""},
        {BLEND_OPAQUE, {0, 0, 0, 0}, BASE, 2, 0, ""},
        {BLEND_OPAQUE, {0, 0, 0, 0}, "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0]}", 2, 0, ""},
        {BLEND_EXCLUDE, {0, 255, 255, 255}, BASE, 2, 0, ""},
        {BLEND_EXCLUDE, {255, 255, 255, 255}, BASE, 4, 0, ""},
    };
    mode = "BLEND";
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        for (int given = 0; given < 2; given++) {
            const uint8_t *a = rows[i].alpha;
            use_png(a[0], a[1], a[2], a[3]);
            chosen.blend       = rows[i].blend;
            chosen.blend_given = given || rows[i].blend != BLEND_MASK;
            must(load_mask("", UV, rows[i].material, TEXTURE));
            if (s.triangle_count != rows[i].triangles || s.holed_triangle_count != rows[i].holed)
                fail_msg("row %zu: %zu triangles, %zu with holes", i, s.triangle_count, s.holed_triangle_count);
            int says = !chosen.blend_given && rows[i].words;
            assert_int_equal(m.warning_count, says);
            if (says) must_warn(rows[i].words);
            assert_int_equal(s.exclusion_count, s.triangle_count < 4);
            if (s.triangle_count < 4) assert_true(s.exclusions[0].rule == EXCLUDED_AS_BLEND && s.exclusions[0].triangles == 2);
            if (s.holed_triangle_count) assert_true(s.alpha_masks[0].threshold == 0.5f);
        }
    chosen.blend = chosen.blend_given = 0;
    mode                              = "MASK";
}

/* Materials that let light through by an extension are walls, or nothing where that is requested. */
static void test_transmission_is_said(void **state)
{
    (void)state;
#define THROUGH(name, factor) "'extensions':{'KHR_materials_" name "':{" factor "}}"
    use_png(255, 255, 255, 255);
    mode = "OPAQUE";
    must(load_mask("", UV, THROUGH("transmission", "'transmissionFactor':0.9"), TEXTURE));
    assert_true(s.triangle_count == 4 && m.warning_count == 1);
    must_warn("KHR_materials_transmission lets light through, and is baked as a wall, 2 triangles; --blend exclude leaves such "
              "materials out");
    must(load_mask("", UV, THROUGH("diffuse_transmission", "'diffuseTransmissionFactor':0.9"), TEXTURE));
    assert_true(s.triangle_count == 4 && m.warning_count == 1);
    must_warn("KHR_materials_diffuse_transmission lets light through, and is baked as a wall, 2 triangles; --exclude material:leaf "
              "bakes without it");
    must(load_mask("", UV, THROUGH("transmission", "'transmissionFactor':0"), TEXTURE));
    assert_int_equal(m.warning_count, 0);
    chosen.blend       = BLEND_EXCLUDE;
    chosen.blend_given = 1;
    must(load_mask("", UV, THROUGH("transmission", "'transmissionFactor':0.9"), TEXTURE));
    assert_true(s.triangle_count == 2 && m.warning_count == 0);
    must(load_mask("", UV, THROUGH("diffuse_transmission", "'diffuseTransmissionFactor':0.9"), TEXTURE));
    assert_true(s.triangle_count == 4 && m.warning_count == 0);
    chosen.blend = chosen.blend_given = 0;
    mode                              = "what";
    must(load_mask("", UV, "'doubleSided':2", TEXTURE));
    assert_true(s.triangle_count == 4 && m.warning_count == 1);
    mode = "MASK";
}

static void test_surfaces_that_are_nowhere(void **state)
{
    (void)state;
    static const char *const nowhere[] = {BASE, "'alphaCutoff':1.5", "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0]}",
                                          "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.4]}"};
    use_png(0, 1, 127, 127);
    for (size_t i = 0; i < sizeof nowhere / sizeof *nowhere; i++) {
        must(load_mask("", UV, nowhere[i], TEXTURE));
        assert_int_equal(s.triangle_count, 2);
        assert_int_equal(s.triangle_flags[0], 0);
        assert_int_equal(m.warning_count, 1);
        assert_string_equal(m.warnings[0], "material 0 'leaf': its alpha is below the cutoff everywhere: 2 triangles left out; "
                                           "lower alphaCutoff, or set alphaMode to OPAQUE");
    }
}

static void test_colours_are_warned_about(void **state)
{
    (void)state;
    use_png(0, 255, 255, 255);
    must(load_mask("", UV ",'COLOR_0':3", BASE, TEXTURE));
    must_warn("mesh 0 primitive 0: the alpha of COLOR_0 is ignored");
    must(load_mask("", UV ",'COLOR_0':4", BASE, TEXTURE));
    assert_int_equal(m.warning_count, 0);
}

static void test_broken_masks_are_opaque(void **state)
{
    (void)state;
    static const struct {
        const char *attributes, *material, *rest, *words;
    } broken[] = {
        {UV, "'alphaCutoff':'a'," BASE, TEXTURE, "material 0 'leaf' (node 0, mesh 0 primitive 0): 'alphaCutoff' is not a number"},
        {UV, "'alphaCutoff':-1," BASE, TEXTURE, "'alphaCutoff' is not a number, 0 or more"},
        {UV, "'pbrMetallicRoughness':{'baseColorFactor':[1,1,1]}", TEXTURE, "'baseColorFactor' is not 4 numbers"},
        {UV, "'pbrMetallicRoughness':{'baseColorTexture':{}}", TEXTURE, "'index' is missing"},
        {UV, "'pbrMetallicRoughness':{'baseColorTexture':{'index':7}}", TEXTURE, "texture 7 does not exist"},
        {UV, BASE, "'textures':[{'source':9}]", "image 9 does not exist"},
        {UV, BASE, "'textures':[{}]", "texture: 'source' is missing"},
        {UV, BASE, "'textures':[{'extensions':{'KHR_texture_basisu':{'source':0}}}]",
         "its image is one of KHR_texture_basisu alone, which is not read: expected PNG, JPEG or WebP"},
        {UV, BASE, "'textures':[{'source':0,'sampler':2}],'images':[{'bufferView':1}]", "sampler 2 does not exist"},
        {UV, BASE, "'textures':[{'source':0,'sampler':0}],'samplers':[{'wrapT':5}],'images':[{'bufferView':1}]",
         "'wrapT' is not 10497, 33071 or 33648"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{}]", "image 0 has neither a uri nor a bufferView"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'gone.png'}]", "cannot read image 0 'gone.png', '"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'name':'pic','bufferView':8}]", "image 0 'pic': bufferView 8 does not"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'bufferView':0}]", "image 0: not a PNG, JPEG or WebP"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64,iVBORw0KGgo='}]", "image 0: broken PNG"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'data:image/png,abc'}]", "image 0: not a PNG, JPEG or WebP"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'data:image/png;base64'}]",
         "'data:image/png;base64,...' is not a data URI"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'DATA:image/png;BASE64,iVB!'}]",
         "a character that is no base64, 3 behind the comma"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'data:,GIF89a'}]", "not a PNG, JPEG or WebP, but GIF"},
        {UV, BASE, "'textures':[{'source':0}],'images':[{'uri':'../leaf.png'}]",
         "'../leaf.png' is not in the scene's folder: --allow-outside reads it"},
        {"", BASE, TEXTURE,
         "mesh 0 primitive 0 (node 0, material 0 'leaf'): no TEXCOORD_0, which the mask of material 0 'leaf' needs"},
        {",'TEXCOORD_0':99", BASE, TEXTURE, "TEXCOORD_0 accessor 99 does not exist"},
        {",'TEXCOORD_0':7", BASE, TEXTURE, "accessor 7: TEXCOORD_0 is not a VEC2 of floats or normalised"},
        {",'TEXCOORD_0':6", BASE, TEXTURE, "6 elements of TEXCOORD_0, expected 4"},
        {UV, "'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':{'scale':[1]}}}}",
         TEXTURE, "KHR_texture_transform: 'scale' is not 2 numbers"},
        {UV, "'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':{'rotation':[]}}}}",
         TEXTURE, "'rotation' is not a number"},
    };
    use_png(0, 255, 255, 255);
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        must(load_mask("", broken[i].attributes, broken[i].material, broken[i].rest));
        assert_true(s.triangle_count == 4 && !s.holed_triangle_count && !s.triangle_flags[0] && m.warning_count == 1);
        must_warn(broken[i].words);
        must_warn(": taken as opaque, 2 triangles; ");
        must_warn(" bakes without it");
        forget();
        m.strict = 1;
        assert_int_equal(scene_load_gltf(&s, path, &chosen, &m), VXS_E_STRICT);
    }
    must(load_mask("", ",'TEXCOORD_0':5", BASE, TEXTURE)); /* one coordinate, of one triangle */
    assert_true(s.triangle_count == 3 && s.holed_triangle_count == 1 && s.holed_triangles[0].triangle == 0);
    expect_corner(0, 2, 0, 1, 0);
    must_warn("accessor 5: a texture coordinate of triangle 0 is not finite: 1 triangles left out; ");
}

/* What no mask needs is not looked at. */
static void test_images_are_left_alone_otherwise(void **state)
{
    (void)state;
    use_bytes("no image at all", 15);
    must(load_mask("", "", "'alphaCutoff':0," BASE, TEXTURE));
    assert_int_equal(m.warning_count, 1); /* of the cutoff */
    must(load_mask("", UV, BASE, TEXTURE));
    must_warn("image 0 'pic': not a PNG, JPEG or WebP");
}

static void expect_broken_image(const char *words)
{
    must(load_mask("", UV, BASE, TEXTURE));
    assert_true(s.triangle_count == 4 && !s.holed_triangle_count);
    must_warn(words);
}

/* Every prefix of an image is broken, and reported so; a PNG that promises too much is refused before it is decoded. */
static void test_hostile_images(void **state)
{
    (void)state;
    for (int webp = 0; webp < 2; webp++) {
        if (webp)
            use_webp(0, 255, 200, 100);
        else
            use_png(0, 255, 200, 100);
        for (size_t whole = image_bytes - (webp ? 0 : 16); --image_bytes > 12;)
            if (image_bytes < whole) expect_broken_image("image 0 'pic': broken ");
    }
    static const uint8_t large[]   = {0x89, 'P', 'N', 'G',  13, 10, 26, 10,   0, 0, 0, 13, 'I', 'H', 'D',
                                      'R',  0,   0,   0x40, 0,  0,  0,  0x40, 0, 8, 6, 0,  0,   0};
    uint8_t              bytes[64] = {0};
    memcpy(bytes, large, sizeof large);
    uint32_t crc = 0xffffffff;
    for (size_t i = 12; i < sizeof large; i++) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    for (int i = 0; i < 4; i++) bytes[sizeof large + (size_t)i] = (uint8_t)(~crc >> (24 - 8 * i));
    memcpy(bytes + sizeof large + 8, "IDAT", 4);
    use_bytes(bytes, sizeof bytes);
    expect_broken_image("16384 x 16384 pixels: textures may have 67108864 in an image");
}

/* Sponza's foliage and chains, about half of each transparent; the ship's sails, whose image is opaque. */
static void test_real_masks(void **state)
{
    (void)state;
    char        file[512];
    const char *scenes = scenes_folder();
    snprintf(file, sizeof file, "%s/real/sponza.glb", scenes);
    must(load_file(file, NULL));
    assert_true(s.alpha_mask_count == 3 && s.image_count == 3 && s.holed_triangle_count > 1000);
    for (size_t i = 0; i < s.alpha_mask_count; i++) {
        const alpha_image *image = &s.images[s.alpha_masks[i].image];
        size_t             holes = 0, pixels = (size_t)image->width_px * image->height_px;
        for (size_t k = 0; k < pixels; k++) holes += image->alpha[k] / 255.0f < s.alpha_masks[i].threshold;
        if (holes < pixels / 5 || holes > pixels * 4 / 5) fail_msg("mask %zu: %zu of %zu pixels are holes", i, holes, pixels);
    }
    size_t masked = 0;
    for (size_t i = 0; i < s.triangle_count; i++) masked += (s.triangle_flags[i] & TRIANGLE_ALPHA_MASK) != 0;
    assert_int_equal(masked, s.holed_triangle_count);
    for (size_t i = 1; i < s.holed_triangle_count; i++)
        assert_true(s.holed_triangles[i].triangle > s.holed_triangles[i - 1].triangle);

    snprintf(file, sizeof file, "%s/real/dutch_ship_mask.glb", scenes);
    must(load_file(file, NULL));
    assert_true(s.triangle_count == 69162 && !s.holed_triangle_count && !s.image_count);
    must_warn("is a mask, but image 0 has no alpha");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_texture_makes_holes),
        cmocka_unit_test(test_texture_coordinates_of_every_kind),
        cmocka_unit_test(test_samplers_wrap_and_filter),
        cmocka_unit_test(test_texture_transform_moves_coordinates),
        cmocka_unit_test(test_the_cutoff_is_held_against_the_product),
        cmocka_unit_test(test_masks_that_are_none),
        cmocka_unit_test(test_surfaces_that_are_nowhere),
        cmocka_unit_test(test_colours_are_warned_about),
        cmocka_unit_test(test_masks_that_are_traps),
        cmocka_unit_test(test_blend_is_chosen),
        cmocka_unit_test(test_transmission_is_said),
        cmocka_unit_test(test_broken_masks_are_opaque),
        cmocka_unit_test(test_images_are_left_alone_otherwise),
        cmocka_unit_test(test_hostile_images),
        cmocka_unit_test(test_real_masks),
    };
    return cmocka_run_group_tests_name("gltf_masks", tests, make_folder, remove_folder);
}
