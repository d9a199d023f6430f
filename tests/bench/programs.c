/* The texts of the programs that libvxs_gl and libvxs_volumes compile, without any OpenGL: its functions are replaced by ones that
 * do nothing, but for the one that receives texts, which writes them into files. Each technique is called for a light of each kind;
 * those that read words, in each coding.
 *
 *     programs FOLDER      FOLDER/NNN_CODING_TECHNIQUE_LIGHT.comp, .vert, .frag, in the order in which programs are compiled
 *
 * tests/bench/program_size.py measures them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/gl/vxs_gl.h"
#include "runtime/gl/vxs_gl_depths.h"
#include "runtime/volumes/volumes_gl.h"
#include "runtime/volumes/vxs_area_light.h"
#include "runtime/volumes/vxs_transmittance.h"
#include "runtime/volumes/vxs_volumes.h"
#include "vxs_format.h"

enum { SUN, SPOT, POINT, LIGHTS, SIDE_PX = 64 };

static const char *folder, *coding, *technique, *light_name;
static unsigned    last_name, last_shader, texts_written;
static gl_enum     kind_of_shader[4096];

/* OpenGL ---------------------------------------------------------------------------------------------------------------------- */

static uint32_t marks[4 * 4097]; /* of depth pages */

static const void *GL_CALL map_buffer(gl_enum target, gl_bytes first, gl_bytes bytes, unsigned access)
{
    (void)target;
    (void)first;
    (void)bytes;
    (void)access;
    return marks;
}

static uintptr_t GL_CALL nothing(void)
{
    return 0;
}

static const unsigned char *GL_CALL get_string(gl_enum name)
{
    (void)name;
    return (const unsigned char *)"4.5 (Core Profile)";
}

static void GL_CALL get_integer(gl_enum name, int *value)
{
    *value = name == GL_MOST_FRAGMENT_STORAGE_BLOCKS ? 16 : name == GL_MOST_TEXTURE_SIZE ? 16384 : 1 << 30;
}

static void GL_CALL create(int count, gl_name *names)
{
    for (int n = 0; n < count; n++) names[n] = ++last_name;
}

static void GL_CALL create_textures(gl_enum target, int count, gl_name *names)
{
    (void)target;
    create(count, names);
}

static gl_name GL_CALL create_program(void)
{
    return ++last_name;
}

static gl_name GL_CALL create_shader(gl_enum kind)
{
    if (++last_shader == sizeof kind_of_shader / sizeof *kind_of_shader) abort();
    kind_of_shader[last_shader] = kind;
    return last_shader;
}

static void GL_CALL get_status(gl_name name, gl_enum what, int *value)
{
    (void)name;
    (void)what;
    *value = 1;
}

static void GL_CALL read_buffer(gl_name buffer, gl_bytes first, gl_bytes bytes, void *to)
{
    (void)buffer;
    (void)first;
    memset(to, 0, (size_t)bytes);
}

static void GL_CALL shader_source(gl_name shader, int count, const char *const *texts, const int *lengths)
{
    char    path[4096];
    gl_enum kind = kind_of_shader[shader];
    snprintf(path, sizeof path, "%s/%03u_%s_%s_%s.%s", folder, ++texts_written, coding, technique, light_name,
             kind == GL_KIND_COMPUTE_SHADER  ? "comp"
             : kind == GL_KIND_VERTEX_SHADER ? "vert"
                                             : "frag");
    FILE *file = fopen(path, "w");
    for (int n = 0; n < count && file && !lengths; n++) fputs(texts[n], file);
    if (!file || lengths || fclose(file)) {
        fprintf(stderr, "%s: not written\n", path);
        exit(1);
    }
}

static vxs_gl_function function_of(const char *name, void *user)
{
#define IS(wanted, function)                                                                                                       \
    if (!strcmp(name, "gl" wanted)) return (vxs_gl_function)(function)
    (void)user;
    IS("GetString", get_string);
    IS("GetIntegerv", get_integer);
    IS("GenBuffers", create);
    IS("GenTextures", create);
    IS("CreateBuffers", create);
    IS("CreateFramebuffers", create);
    IS("CreateVertexArrays", create);
    IS("CreateTextures", create_textures);
    IS("CreateProgram", create_program);
    IS("CreateShader", create_shader);
    IS("GetShaderiv", get_status);
    IS("GetProgramiv", get_status);
    IS("GetNamedBufferSubData", read_buffer);
    IS("MapBufferRange", map_buffer);
    IS("ShaderSource", shader_source);
    return (vxs_gl_function)nothing;
}

/* techniques ------------------------------------------------------------------------------------------------------------------ */

/* End the program if a call fails: then a program is missing in the table. */
static void must(vxs_result result)
{
    if (result == VXS_OK) return;
    fprintf(stderr, "%s of %s: %s\n", technique, light_name, vxs_result_text(result));
    exit(1);
}

#define CALL(name, call) (technique = (name), must(call))

/* A lookup of a sun in depth pages, with a box. */
static void lookup_in_pages(const vxs_gl *shadows, const vxs_gl_depth_pages *pages, int is_alone)
{
#define ONLY_SUN "#define VXS_ONLY_KIND 1\n#define VXS_ONLY_CUBE 0\n#define VXS_ONLY_SMOOTH 0\n#define VXS_ONLY_WIDTH 9\n"
    enum { TEXTS = VXS_GL_TEXTS + 1 + VXS_GL_DEPTH_PAGES_TEXTS + 1 };
    const char *texts[TEXTS], *common[VXS_GL_TEXTS];
    vxs_gl_texts(shadows, common);
    texts[0] = common[0];
    texts[1] = is_alone ? ONLY_SUN "#define VXS_PAGES_ALONE\n" : ONLY_SUN;
    memcpy(texts + 2, common + 1, sizeof common - sizeof *common);
    vxs_gl_depth_pages_texts(pages, texts + VXS_GL_TEXTS + 1);
    texts[TEXTS - 1] = "layout(local_size_x = 64) in;\n"
                       "layout(std430, binding = 9) restrict buffer points_block { vec4 points[]; };\n"
                       "void main()\n"
                       "{\n"
                       "    uint n = 2u * gl_GlobalInvocationID.x;\n"
                       "    points[n].w = vxs_paged_lit_by(0u, points[n].xyz, points[n + 1u].xyz, vxs_box(9));\n"
                       "}\n";
    light_name       = "sun";
    technique        = is_alone ? "lookup_in_pages_alone" : "lookup_in_pages";
    shader_source(create_shader(GL_KIND_COMPUTE_SHADER), TEXTS, texts, NULL);
}

static void depth_pages(vxs_gl *shadows, const vxs_view *view)
{
    vxs_gl_depth_pages *pages;
    light_name = "all";
    CALL("pages", vxs_gl_depth_pages_create(&pages, shadows, NULL));
    CALL("pages", vxs_gl_depth_pages_mark(pages, &(vxs_depth_pages_view){.view = *view}, 1));
    CALL("pages", vxs_gl_depth_pages_mark(pages, &(vxs_depth_pages_view){.view = *view}, 1));
    marks[0] = 1; /* page (0, 0) of light 0, whose table begins behind the lights */
    marks[7] = 8 + 516 * vxs_gl_depth_pages_room(pages) + LIGHTS;
    if (vxs_gl_depth_pages_update(pages, 1) != 0) abort();
    lookup_in_pages(shadows, pages, 0);
    lookup_in_pages(shadows, pages, 1);
    vxs_gl_depth_pages_destroy(pages);
}

/* maps  [1] of a VPL that emits in all directions; NULL: imperfect shadow maps */
static void area_light(vxs_volumes *v, const char *name, const vxs_vpl *vpl, const vxs_capsules *smoke,
                       const vxs_shadow_depth_map *const *maps)
{
    vxs_area_light     *area;
    vxs_area_casters    casters = {.buffer = 1, .count = 64};
    vxs_area_light_desc desc    = {.vpls = 1, .takes_maps = maps != NULL, .capsules = smoke ? 16 : 0};
    CALL(name, vxs_area_light_create(&area, v, &desc));
    CALL(name, vxs_area_light_set(area, vpl, 1));
    if (!maps) CALL(name, vxs_area_light_cast(area, &casters));
    if (smoke) CALL(name, vxs_area_light_smoke(area, smoke));
    CALL(name, vxs_volumes_area(v, area, &(vxs_area_look){.normal_texture = 1, .maps = maps}));
    vxs_area_light_destroy(area);
}

static void area_lights(vxs_volumes *v)
{
    static const vxs_capsule  capsule = {{0, 0, 0}, 1, {1, 0, 0}, 1};
    const vxs_capsules        smoke   = {.list = &capsule, .count = 1};
    vxs_vpl                   vpl     = {.normal = {0, -1, 0}, .colour = {1, 1, 1}, .radius_metres = 1};
    vxs_shadow_depth_map     *map;
    vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number(POINT), .side_px = SIDE_PX};
    area_light(v, "area", &vpl, NULL, NULL);
    area_light(v, "area_smoke", &vpl, &smoke, NULL);
    vpl.is_far = 1;
    area_light(v, "area_far", &vpl, NULL, NULL);
    vpl.is_far = 0;
    memset(vpl.normal, 0, sizeof vpl.normal);
    CALL("map", vxs_shadow_depth_map_create(&map, v, &desc));
    area_light(v, "area_exact", &vpl, NULL, (const vxs_shadow_depth_map *const[]){map});
    vxs_shadow_depth_map_destroy(map);
}

static void smoke_of_light(vxs_volumes *v, vxs_volumes_light light, const vxs_shadow_depth_map *map, uint32_t segments)
{
    static const vxs_capsule capsule = {{0, 0, 0}, 1, {1, 0, 0}, 1};
    vxs_transmittance_map   *smoke;
    vxs_transmittance_desc   desc = {.baked_number = light.baked_number, .capsules = 16, .segments = segments};
    CALL("smoke", vxs_transmittance_map_create(&smoke, v, &desc));
    CALL("smoke", vxs_transmittance_map_build(smoke, &(vxs_capsules){.list = &capsule, .count = 1}, map));
    CALL("smoke", vxs_volumes_transmittance(v, smoke, 1, VXS_CURVE_LINES));
    CALL("smoke", vxs_volumes_transmittance_at(v, smoke, 1, 1, 2, 0, VXS_CURVE_LINES));
    light.smoke = smoke;
    CALL("smoke_march_map", vxs_volumes_march(v, &light, map, 64, VXS_STEPS_EVEN));
    CALL("smoke_march_map_angles", vxs_volumes_march(v, &light, map, 64, VXS_STEPS_EQUIANGULAR));
    CALL("smoke_march_asset", vxs_volumes_march(v, &light, NULL, 64, VXS_STEPS_EVEN));
    vxs_transmittance_map_destroy(smoke);
}

static void meshes(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map)
{
    static const float    places[9];
    static const uint32_t corners[3] = {0, 1, 2};
    vxs_light_mesh       *mesh;
    vxs_adaptive_mesh    *adaptive;
    CALL("mesh_map", vxs_volumes_mesh_map(v, light, map));
    CALL("mesh", vxs_light_mesh_create(&mesh, v, places, corners, &(vxs_light_mesh_size){3, 1}));
    CALL("mesh", vxs_volumes_mesh(v, light, mesh));
    vxs_adaptive_mesh_desc desc = {.side_px = SIDE_PX, .layers = vxs_shadow_depth_map_layers(map)};
    CALL("mesh_adaptive", vxs_adaptive_mesh_create(&adaptive, v, &desc));
    CALL("mesh_adaptive", vxs_volumes_mesh_adaptive(v, light, map, adaptive, 1));
    vxs_light_mesh_destroy(mesh);
    vxs_adaptive_mesh_destroy(adaptive);
}

static void grids(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map)
{
    vxs_shadow_grid *grid;
    vxs_casters      casters[] = {{.places = 1, .triangle_count = 1, .kind = VXS_VOXELS_SOLID},
                                  {.places = 1, .triangle_count = 1, .kind = VXS_VOXELS_COVERED}};
    for (int n = 0; n < 2; n++)
        for (int d = 0; d < 16; d += 5) casters[n].point_from_place[d] = 1;
    CALL("grid", vxs_shadow_grid_create(&grid, v, &(vxs_shadow_grid_desc){.columns = 128, .rows = 128, .bits = 128, .casts = 1}));
    CALL("grid_map", vxs_volumes_grid(v, light, map, grid, 8));
    CALL("grid_casters", vxs_volumes_grid_cast(v, light, map, grid, 8, casters, 2));
    vxs_shadow_grid_destroy(grid);
}

/* What reads the words of a light. */
static void asset_of_light(vxs_volumes *v, const vxs_volumes_light *light)
{
    vxs_shadow_grid *grid;
    CALL("intervals", vxs_volumes_intervals(v, light));
    CALL("march_asset", vxs_volumes_march(v, light, NULL, 64, VXS_STEPS_EVEN));
    CALL("march_asset_angles", vxs_volumes_march(v, light, NULL, 64, VXS_STEPS_EQUIANGULAR));
    CALL("grid_asset", vxs_shadow_grid_create(&grid, v, &(vxs_shadow_grid_desc){.columns = 128, .rows = 128, .bits = 128}));
    CALL("grid_asset", vxs_volumes_grid(v, light, NULL, grid, 8));
    vxs_shadow_grid_destroy(grid);
}

static void all_of_light(vxs_volumes *v, uint32_t n, int is_first)
{
    vxs_shadow_depth_map     *map;
    vxs_volumes_light         light = {.baked_number = vxs_baked_number(n), .colour = {1, 1, 1}, .radius_metres = 0.1F};
    vxs_shadow_depth_map_desc desc  = {.baked_number = light.baked_number, .side_px = SIDE_PX, .moves = 1};
    asset_of_light(v, &light);
    CALL("map", vxs_shadow_depth_map_create(&map, v, &desc));
    vxs_shadow_depth_map_fill(map, UINT64_MAX);
    if (is_first) {
        CALL("map_join",
             vxs_shadow_depth_map_join(map, &(vxs_moving_casters){.depth_texture = 1, .width_px = 1, .height_px = 1}, 1));
        CALL("march_map", vxs_volumes_march(v, &light, map, 64, VXS_STEPS_EVEN));
        CALL("march_map_angles", vxs_volumes_march(v, &light, map, 64, VXS_STEPS_EQUIANGULAR));
        meshes(v, &light, map);
        grids(v, &light, map);
        smoke_of_light(v, light, map, 0);
        smoke_of_light(v, light, map, 1024);
    }
    vxs_shadow_depth_map_destroy(map);
}

/* is_first: what does not depend on the coding, too */
static void all_of_coding(uint32_t which, uint64_t most_table_bytes, int is_first)
{
    static const char *const names[LIGHTS] = {"sun", "spot", "point"};
    static const uint32_t    kinds[LIGHTS] = {VXS_LIGHT_KIND_DIRECTIONAL, VXS_LIGHT_KIND_SPOT, VXS_LIGHT_KIND_POINT};
    /* no pages, six maps of 4 x 4 squares whose voxels are lit */
    static uint32_t          words[8 + 2 * 16 + VXS_BLOCKS_SPARE_WORDS];
    vxs_baked_light          lights[LIGHTS];
    const vxs_baked_light   *of[LIGHTS];
    vxs_gl                  *shadows;
    vxs_volumes             *v;
    for (uint32_t n = 0; n < LIGHTS; n++) {
        vxs_light *l = &lights[n].light;
        lights[n]    = (vxs_baked_light){.words = words, .word_count = sizeof words / sizeof *words};
        *l           = (vxs_light){.kind         = kinds[n],
                                   .flags        = n == POINT ? VXS_LIGHT_CUBE : 0,
                                   .levels       = 10,
                                   .coding       = which,
                                   .texel_metres = 0.01,
                                   .voxel_metres = 0.01,
                                   .near_metres  = n == SUN ? 0 : 0.1,
                                   .cos_outer    = n == SPOT ? 0.7 : 0};
        for (int d = 0; d < 3; d++) l->ls_from_ws[5 * d] = 1;
        of[n] = &lights[n];
    }
    for (int n = 0; n < 6; n++) words[2 + n] = 8;
    for (int n = 0; n < 16; n++) words[8 + 2 * n] = 0x80000000 | 1024;
    vxs_gl_desc gl_desc = {.struct_size      = sizeof gl_desc,
                           .get_proc_address = function_of,
                           .baked            = of,
                           .light_count      = LIGHTS,
                           .most_table_bytes = most_table_bytes};
    CALL("gl", vxs_gl_create(&shadows, &gl_desc));
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = function_of,
                             .shadows          = shadows,
                             .width_px         = 64,
                             .height_px        = 64,
                             .has_half         = 1};
    CALL("volumes", vxs_volumes_create(&v, &desc));
    vxs_volumes_frame frame = {.scattering    = {0.01F, 0.01F, 0.01F},
                               .extinction    = {0.01F, 0.01F, 0.01F},
                               .top_metres    = (float)1e30,
                               .view          = {.width_px = 64, .height_px = 64},
                               .far_metres    = 100,
                               .depth_texture = 1};
    for (int d = 0; d < 16; d += 5) frame.view.point_from_depth[d] = 1;
    light_name = "all";
    CALL("cull", vxs_gl_cull(shadows, &frame.view, 1, 16));
    depth_pages(shadows, &frame.view);
    CALL("begin", vxs_volumes_begin(v, &frame));
    for (uint32_t n = 0; n < LIGHTS; n++) {
        light_name = names[n];
        all_of_light(v, n, is_first);
    }
    light_name = "all";
    if (is_first) {
        area_lights(v);
        CALL("half", vxs_volumes_begin_half(v));
        CALL("half", vxs_volumes_end_half(v));
        technique = "composite";
        vxs_volumes_composite(v);
    }
    vxs_volumes_destroy(v);
    vxs_gl_destroy(shadows);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fputs("usage: programs FOLDER\n", stderr);
        return 2;
    }
    folder = argv[1];
    coding = "blocks";
    all_of_coding(VXS_CODING_BLOCKS, 0, 1);
    coding = "words"; /* blocks without tables, as streams have them */
    all_of_coding(VXS_CODING_BLOCKS, 1, 0);
    coding = "dag";
    all_of_coding(VXS_CODING_DAG, 0, 0);
    return 0;
}
