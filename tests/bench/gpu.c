/* gpu: times of frames on a graphics processor: lookups, lists of lights and fog, each beside its rivals, in one run.
 *
 *     gpu SCENE FILE.vxs... --view NAME:EX,EY,EZ,TX,TY,TZ... [--fog PER_METRE] [--json FILE.json] ...
 *
 * Rays find what each pixel of a view sees; compute shaders answer for all pixels. A file with one light is measured with lookups.
 * The first file of each resolution also gives the rivals their depth maps, which have the same depths. A file with several lights
 * is measured with lists of lights. --fog measures fog in the first file, too. VXS_GL=egl takes what EGL finds, for instance a
 * graphics processor; without it llvmpipe draws. Times are those of timer queries; with llvmpipe, wall time until all is drawn.
 * Exit status 1: answers of shaders differ that must be equal.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/gpu_bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/casters/casters.h"
#include "baker/command/options/options.h"
#include "baker/files/json_value.h"
#include "baker/lab/truth/camera.h"
#include "baker/lab/truth/truth.h"
#include "tests/gl_choice.h"

#define NEAR_METRES 0.01

enum { TILE_PX = 8, RUNS_WALL_MS = 2000 };

/* what is seen ----------------------------------------------------------------------------------------------------------------- */

typedef struct seen {
    const gpu_bench *b;
    const gpu_view  *view;
    const truth     *truth;
    camera_view      camera;
    float           *positions, *normals, *depths;
} seen;

static void see_pixels(void *user, size_t begin, size_t end, uint32_t worker)
{
    seen *s = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        size_t x = n % s->b->width_px, y = n / s->b->width_px;
        double way[3], metres, normal[3];
        camera_direction(&s->camera, (double)(x + 0.5) / s->b->width_px, 1 - (double)(y + 0.5) / s->b->height_px, way);
        if (!truth_first_hit(s->truth, s->view->eye_ws, way, &metres, normal, NULL)) continue;
        double side = vec3_dot(normal, way) > 0 ? -1 : 1; /* seen from behind */
        for (int k = 0; k < 3; k++) {
            s->positions[4 * n + (size_t)k] = (float)(metres * way[k]);
            s->normals[4 * n + (size_t)k]   = (float)(side * normal[k]);
        }
        s->positions[4 * n + 3] = 1;
        s->depths[n]            = (float)(NEAR_METRES / (metres * vec3_dot(way, s->camera.forward)));
    }
}

/* Depths are NEAR_METRES over metres along the axis, 0 where nothing is seen. Rows count from the bottom. */
static vxs_view view_of(const gpu_bench *b, const camera_view *c)
{
    vxs_view v = {.width_px = b->width_px, .height_px = b->height_px, .filter = vxs_box(9)};
    for (int n = 0; n < 3; n++) {
        v.point_from_depth[n]      = (float)(2 * c->right[n] * NEAR_METRES);
        v.point_from_depth[4 + n]  = (float)(2 * c->up[n] * NEAR_METRES);
        v.point_from_depth[12 + n] = (float)((c->forward[n] - c->right[n] - c->up[n]) * NEAR_METRES);
    }
    v.point_from_depth[11] = 1;
    return v;
}

static GLuint picture(const gpu_bench *b, GLenum format, GLenum channels, const float *texels)
{
    const gl_context *gl = b->gl;
    GLuint            texture;
    gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    gl->TextureStorage2D(texture, 1, format, (GLsizei)b->width_px, (GLsizei)b->height_px);
    gl->TextureSubImage2D(texture, 0, 0, 0, (GLsizei)b->width_px, (GLsizei)b->height_px, channels, GL_FLOAT, texels);
    gl->TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

static vxs_result see(gpu_bench *b, gpu_view *v, const truth *t, run_context *m)
{
    camera_pose pose = {.fov_degrees = b->fov_degrees};
    memcpy(pose.eye_ws, v->eye_ws, sizeof pose.eye_ws);
    memcpy(pose.target_ws, v->target_ws, sizeof pose.target_ws);
    seen s       = {.b = b, .view = v, .truth = t, .camera = camera_view_of(&pose, (double)b->width_px / b->height_px)};
    s.positions  = calloc(b->pixels, 4 * sizeof(float));
    s.normals    = calloc(b->pixels, 4 * sizeof(float));
    s.depths     = calloc(b->pixels, sizeof(float));
    vxs_result r = s.positions && s.normals && s.depths ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    if (r == VXS_OK) {
        parallel_for(b->threads, b->pixels, b->width_px, see_pixels, &s);
        v->view      = view_of(b, &s.camera);
        v->positions = picture(b, GL_RGBA32F, GL_RGBA, s.positions);
        v->normals   = picture(b, GL_RGBA32F, GL_RGBA, s.normals);
        v->depths    = picture(b, GL_R32F, GL_RED, s.depths);
    }
    free(s.positions);
    free(s.normals);
    free(s.depths);
    return r;
}

static vxs_result see_all(gpu_bench *b, run_context *m)
{
    scene        s      = {0};
    casters      c      = {0};
    truth       *t      = NULL;
    scene_choice choice = {0};
    vxs_result   r      = scene_load_gltf(&s, b->scene_path, &choice, m);
    if (r == VXS_OK) r = casters_from_scene(&c, &s, CLOSED_OFF, b->threads, m);
    if (r == VXS_OK) r = truth_create(&t, &c, b->threads, m);
    for (size_t n = 0; n < b->view_count && r == VXS_OK; n++) r = see(b, &b->views[n], t, m);
    truth_destroy(t);
    casters_free(&c);
    scene_free(&s);
    return r;
}

/* programs --------------------------------------------------------------------------------------------------------------------- */

static const char program_head[] = "layout(binding = 8) uniform sampler2D positions;\n"
                                   "layout(binding = 9) uniform sampler2D normals;\n"
                                   "layout(std430, binding = 7) writeonly restrict buffer answers_block { float answers[]; };\n";

static const char program_end[] = "#ifdef FRAGMENT\n"
                                  "#define PIXEL gl_FragCoord\n"
                                  "#else\n"
                                  "#define PIXEL gl_GlobalInvocationID\n"
                                  "layout(local_size_x = 8, local_size_y = 8) in;\n"
                                  "#endif\n"
                                  "void main()\n"
                                  "{\n"
                                  "    ivec2 pixel = ivec2(PIXEL.xy), size = textureSize(positions, 0);\n"
                                  "    if (any(greaterThanEqual(pixel, size))) return;\n"
                                  "    vec4  at     = texelFetch(positions, pixel, 0);\n"
                                  "    float answer = -1.0;\n"
                                  "    if (at.w > 0.0) answer = answer_of(pixel, at.xyz, texelFetch(normals, pixel, 0).xyz);\n"
                                  "    answers[pixel.y * size.x + pixel.x] = answer;\n"
                                  "}\n";

static void add_shader(const gpu_bench *b, GLuint program, GLenum kind, const char *const *texts, int count, char log[512])
{
    GLuint shader = b->gl->CreateShader(kind);
    b->gl->ShaderSource(shader, count, texts, NULL);
    b->gl->CompileShader(shader);
    if (!log[0]) b->GetShaderInfoLog(shader, 512, NULL, log);
    b->gl->AttachShader(program, shader);
    b->gl->DeleteShader(shader);
}

vxs_result gpu_program(gpu_bench *b, const vxs_gl *shadows, const char *defines, const char *body, GLuint *program, run_context *m)
{
    enum { TEXTS = VXS_GL_TEXTS + 6 };
    static const char triangle[] =
        "#version 450 core\n"
        "void main() { gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0.0, 1.0); }\n";
    const gl_context *gl           = b->gl;
    const char       *texts[TEXTS] = {"#version 450 core\n"};
    GLint             linked       = 0;
    char              log[512]     = "";
    vxs_gl_texts(shadows, texts + 1);
    texts[1]         = strchr(texts[1], '\n') + 1; /* behind its own version, which has no compute shaders with textures */
    texts[TEXTS - 5] = b->is_fragment ? "#define FRAGMENT\n" : "";
    texts[TEXTS - 4] = program_head;
    texts[TEXTS - 3] = defines;
    texts[TEXTS - 2] = body;
    texts[TEXTS - 1] = program_end;
    *program         = gl->CreateProgram();
    add_shader(b, *program, b->is_fragment ? GL_FRAGMENT_SHADER : GL_COMPUTE_SHADER, texts, TEXTS, log);
    if (b->is_fragment) add_shader(b, *program, GL_VERTEX_SHADER, (const char *[]){triangle}, 1, log);
    gl->LinkProgram(*program);
    gl->GetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked) return VXS_OK;
    if (!log[0]) gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
    gl->DeleteProgram(*program);
    *program = 0;
    return fail(m, VXS_E_GL, "OpenGL cannot make a program: %s", log);
}

vxs_result gpu_shadows_of(gpu_bench *b, vxs_gl_desc *desc, vxs_gl **shadows, run_context *m)
{
    desc->struct_size      = sizeof *desc;
    desc->get_proc_address = gl_lookup;
    desc->user             = b->gl;
    vxs_result r           = vxs_gl_create(shadows, desc);
    if (r != VXS_OK) return fail(m, r, "words cannot be uploaded: %s", vxs_result_text(r));
    while (vxs_gl_upload(*shadows, SIZE_MAX)) continue;
    return VXS_OK;
}

vxs_result gpu_shadows(gpu_bench *b, const vxs_asset *asset, vxs_gl_storage storage, uint64_t most_table_bytes, vxs_gl **shadows,
                       run_context *m)
{
    vxs_gl_desc desc = {.storage = storage, .asset = asset, .most_table_bytes = most_table_bytes};
    return gpu_shadows_of(b, &desc, shadows, m);
}

vxs_result gpu_dispatch_frame(gpu_bench *b, void *user)
{
    const gpu_dispatch *d = user;
    (void)d;
    if (b->is_fragment)
        b->gl->DrawArrays(GL_TRIANGLES, 0, 3);
    else
        b->DispatchCompute((b->width_px + TILE_PX - 1) / TILE_PX, (b->height_px + TILE_PX - 1) / TILE_PX, 1);
    return VXS_OK;
}

void gpu_answers(gpu_bench *b, float *answers)
{
    b->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    b->gl->GetNamedBufferSubData(b->answers, 0, (GLsizeiptr)(b->pixels * sizeof *answers), answers);
}

/* time ------------------------------------------------------------------------------------------------------------------------- */

static vxs_result time_once(gpu_bench *b, vxs_result (*frame)(gpu_bench *b, void *user), void *user, double *ms)
{
    GLuint64 nanoseconds = 0;
    double   start       = 0;
    if (b->clock == GPU_CLOCK_TIMER)
        b->BeginQuery(GL_TIME_ELAPSED, b->query);
    else {
        b->gl->Finish();
        start = clock_seconds();
    }
    vxs_result r = frame(b, user);
    if (b->clock == GPU_CLOCK_TIMER) {
        b->EndQuery(GL_TIME_ELAPSED);
        b->GetQueryObjectui64v(b->query, GL_QUERY_RESULT, &nanoseconds);
        *ms = (double)nanoseconds * 1e-6;
    } else {
        b->gl->Finish();
        *ms = 1e3 * (clock_seconds() - start);
    }
    b->MemoryBarrier(GL_ALL_BARRIER_BITS);
    return r;
}

/* Pixels of the last dispatch that differ by more than the tolerance. */
static vxs_result count_differing(gpu_bench *b, const gpu_row *row, size_t *count, run_context *m)
{
    float *found = malloc(b->pixels * sizeof *found);
    *count       = 0;
    if (!found) return fail(m, VXS_E_MEMORY, "out of memory for answers");
    gpu_answers(b, found);
    for (size_t n = 0; n < b->pixels; n++) *count += !(fabsf(found[n] - row->wanted[n]) <= row->tolerance);
    free(found);
    return VXS_OK;
}

vxs_result gpu_measure(gpu_bench *b, const gpu_view *view, const gpu_row *row, vxs_result (*frame)(gpu_bench *b, void *user),
                       void *user, run_context *m)
{
    double     ms[GPU_RUNS_MAX], one = 0, sum = 0, start = clock_seconds();
    uint32_t   runs   = 0;
    size_t     differ = 0;
    vxs_result r      = time_once(b, frame, user, &one); /* drivers compile late */
    while (r == VXS_OK && sum < b->warm_ms && 1e3 * (clock_seconds() - start) < 4 * b->warm_ms + 100) {
        r = time_once(b, frame, user, &one);
        sum += one;
    }
    for (start = clock_seconds(); r == VXS_OK && runs < b->runs && (runs < 3 || 1e3 * (clock_seconds() - start) < RUNS_WALL_MS);
         runs++)
        r = time_once(b, frame, user, &ms[runs]);
    if (r == VXS_OK && b->gl->GetError() != GL_NO_ERROR) r = VXS_E_GL;
    if (r != VXS_OK) return fail(m, r, "%s, %s: cannot be drawn", row->group, row->name);
    if (row->wanted && (r = count_differing(b, row, &differ, m)) != VXS_OK) return r;

    spread  s   = spread_of(ms, runs);
    json_t *out = json_object();
    json_set(&out, "group", json_text(row->group));
    json_set(&out, "name", json_text(row->name));
    json_set(&out, "view", json_text(view->name));
    json_set(&out, "resolution_px", json_integer((json_int_t)row->resolution_px));
    json_set(&out, "runs", json_integer((json_int_t)runs));
    json_set(&out, "ms", json_pack("{s:f, s:f, s:f}", "median", s.median, "min", s.min, "max", s.max));
    if (row->bytes > 0) json_set(&out, "bytes", json_integer((json_int_t)row->bytes));
    if (row->wanted) json_set(&out, "pixels_differ", json_integer((json_int_t)differ));
    if (row->has_error) json_set(&out, "relative_rms", json_real(row->error));
    if (row->has_listed) json_set(&out, "lights_listed", json_real(row->listed));
    json_append(&b->rows, out);
    return b->rows ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the report");
}

/* the command ------------------------------------------------------------------------------------------------------------------ */

static vxs_result read_views(gpu_bench *b, run_context *m)
{
    for (size_t n = 0; n < b->view_texts.count; n++) {
        gpu_view *v = &b->views[b->view_count++];
        double   *e = v->eye_ws, *t = v->target_ws;
        if (b->view_count == GPU_VIEWS_MAX ||
            sscanf(b->view_texts.items[n], "%63[^:]:%lf,%lf,%lf,%lf,%lf,%lf", v->name, e, e + 1, e + 2, t, t + 1, t + 2) != 7)
            return fail(m, VXS_E_ARGUMENT, "--view %s: expected NAME:EX,EY,EZ,TX,TY,TZ, at most %d of them", b->view_texts.items[n],
                        GPU_VIEWS_MAX - 1);
    }
    return b->view_count ? VXS_OK : fail(m, VXS_E_ARGUMENT, "no --view");
}

static vxs_result open_gl(gpu_bench *b, run_context *m)
{
    vxs_result r = gl_context_create(&b->gl, gl_choice(), b->threads, m);
    if (r != VXS_OK) return r;
#define GPU_LOAD(type, name) b->name = (type)b->gl->lookup("gl" #name);
    GPU_FUNCTIONS(GPU_LOAD)
#undef GPU_LOAD
    if (b->clock == GPU_CLOCK_AUTO) b->clock = strstr(b->gl->names.renderer, "llvmpipe") ? GPU_CLOCK_WALL : GPU_CLOCK_TIMER;
    b->pixels = (size_t)b->width_px * b->height_px;
    b->GenQueries(1, &b->query);
    b->gl->GenBuffers(1, &b->answers);
    b->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->answers);
    b->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(b->pixels * sizeof(float)), NULL, GL_DYNAMIC_COPY);
    if (b->is_fragment) { /* a framebuffer without pixels: answers go to the buffer */
        GLuint frame, array;
        b->gl->GenFramebuffers(1, &frame);
        b->gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
        b->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, (GLint)b->width_px);
        b->FramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_HEIGHT, (GLint)b->height_px);
        b->gl->Viewport(0, 0, (GLsizei)b->width_px, (GLsizei)b->height_px);
        b->gl->GenVertexArrays(1, &array);
        b->gl->BindVertexArray(array);
    }
    return VXS_OK;
}

/* The lights of all files, as one set of lights. */
static vxs_result measure_lists(gpu_bench *b, vxs_asset *const *assets, size_t asset_count, run_context *m)
{
    const vxs_baked_light **lights;
    uint32_t                count = 0;
    for (size_t n = 0; n < asset_count; n++) count += vxs_asset_light_count(assets[n]);
    if (!(lights = malloc(count * sizeof *lights))) return fail(m, VXS_E_MEMORY, "out of memory for a list of lights");
    count = 0;
    for (size_t n = 0; n < asset_count; n++)
        for (uint32_t l = 0; l < vxs_asset_light_count(assets[n]); l++) lights[count++] = vxs_asset_light(assets[n], l);
    vxs_result r = gpu_measure_lights(b, lights, count, m);
    free(lights);
    return r;
}

static vxs_result measure_files_together(gpu_bench *b, run_context *m)
{
    size_t      count = b->asset_paths.count, opened = 0;
    vxs_asset **assets = malloc(count * sizeof *assets);
    vxs_result  r      = assets ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a list of files");
    for (; r == VXS_OK && opened < count; opened++) {
        r = vxs_asset_open_file(&assets[opened], b->asset_paths.items[opened], NULL);
        if (r != VXS_OK) {
            fail(m, r, "%s: %s", b->asset_paths.items[opened], vxs_result_text(r));
            break;
        }
    }
    if (r == VXS_OK) r = measure_lists(b, assets, count, m);
    while (opened) vxs_asset_close(assets[--opened]);
    free(assets);
    return r;
}

static vxs_result measure_file(gpu_bench *b, const char *path, uint32_t *last_levels, int has_fog, run_context *m)
{
    vxs_asset *asset;
    vxs_result r = vxs_asset_open_file(&asset, path, NULL);
    if (r != VXS_OK) return fail(m, r, "%s: %s", path, vxs_result_text(r));
    uint32_t levels   = vxs_asset_light(asset, 0)->light.levels;
    int      is_first = levels != *last_levels;
    if (vxs_asset_light_count(asset) > 1)
        r = measure_lists(b, &asset, 1, m);
    else {
        *last_levels = levels;
        /* what cannot be drawn does not keep the rest from being measured */
        if (b->only == GPU_ALL) r = gpu_measure_lookups(b, asset, is_first, m);
        if (r == VXS_OK && is_first && b->only == GPU_ALL) r = gpu_measure_pages(b, asset, m);
        vxs_result rivals = is_first && b->only == GPU_ALL ? gpu_measure_rivals(b, asset, m) : VXS_OK;
        vxs_result fog    = has_fog ? gpu_measure_fog(b, asset, m) : VXS_OK;
        r                 = r != VXS_OK ? r : rivals != VXS_OK ? rivals : fog;
    }
    vxs_asset_close(asset);
    return r;
}

static vxs_result run(void *command, run_context *m)
{
    gpu_bench *b      = command;
    uint32_t   levels = 0;
    vxs_result failed = VXS_OK, r = read_views(b, m);
    if (r == VXS_OK) r = open_gl(b, m);
    if (r == VXS_OK) r = see_all(b, m);
    b->rows = json_array();
    if (r == VXS_OK && b->only == GPU_ONLY_LISTS) failed = measure_files_together(b, m);
    for (size_t n = 0; r == VXS_OK && b->only != GPU_ONLY_LISTS && n < b->asset_paths.count; n++) {
        vxs_result file = measure_file(b, b->asset_paths.items[n], &levels, n == 0 && b->fog_per_metre > 0, m);
        if (failed == VXS_OK) failed = file;
    }
    if (r == VXS_OK && json_array_size(b->rows)) r = gpu_report(b, m);
    if (r == VXS_OK) r = failed;
    for (size_t n = 0; n < b->view_count; n++)
        for (int f = 0; f < GPU_FILTERS; f++) free(b->views[n].lit[f]);
    json_decref(b->rows);
    gl_context_destroy(b->gl);
    return r;
}

int main(int argc, char **argv)
{
    gpu_bench b = {
        .width_px = 320, .height_px = 180, .runs = 61, .warm_ms = 250, .threads = parallel_default_threads(), .fov_degrees = 60};
    const option options[] = {
        {"SCENE", OPTION_INPUT, &b.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene", NULL},
        {"FILE.vxs", OPTION_INPUTS, &b.asset_paths, FILE_ASSET, 0, NULL, NULL,
         "its shadows; those of a resolution follow each other", NULL},
        {"--view", OPTION_TEXTS, &b.view_texts, 0, 0, NULL, "NAME:EX,EY,EZ,TX,TY,TZ", "eye and target, metres; repeat for more",
         NULL},
        {"--fov", OPTION_F64, &b.fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom (default 60)", NULL},
        {"--fog", OPTION_F64, &b.fog_per_metre, 0, 1e6, NULL, "PER_METRE", "measure fog in the first file, too", NULL},
        {"--storage", OPTION_CHOICE, &b.storage, 0, 0, "both|buffer", NULL, "of words (default both)", NULL},
        {"--only", OPTION_CHOICE, &b.only, 0, 0, "all|fog|lists", NULL,
         "fog: of files with one light; lists: of all lights of all files, without what they are compared with (default all)",
         NULL},
        {"--shader", OPTION_CHOICE, &b.is_fragment, 0, 0, "compute|fragment", NULL, "that answers (default compute)", NULL},
        {"--width", OPTION_U32, &b.width_px, 16, 8192, NULL, "PX", "default 320", NULL},
        {"--height", OPTION_U32, &b.height_px, 16, 8192, NULL, "PX", "default 180", NULL},
        {"--runs", OPTION_U32, &b.runs, 1, GPU_RUNS_MAX, NULL, "N",
         "of each figure; fewer, but 3, when they take more than 2 s (default 61)", NULL},
        {"--warm", OPTION_U32, &b.warm_ms, 0, 10000, NULL, "MS", "work before each figure, milliseconds (default 250)", NULL},
        {"--clock", OPTION_CHOICE, &b.clock, 0, 0, "auto|timer|wall", NULL,
         "timer queries, or the time until all is drawn (default: the first, but of llvmpipe)", NULL},
        {"--threads", OPTION_U32, &b.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "of rays and of a software rasteriser", NULL},
        {"--json", OPTION_OUTPUT, &b.json_path, 0, 0, ".json", "FILE.json", "figures as JSON", NULL},
    };
    const command_line line =
        COMMAND_LINE("gpu", "SCENE FILE.vxs... --view NAME:EX,EY,EZ,TX,TY,TZ... [options]",
                     "Measure lookups, lists of lights and fog on a graphics processor, beside rivals.", options);
    return command_run(&line, argc, argv, run, &b);
}
