/* The cache of program binaries of libvxs_volumes: a second context compiles nothing and draws the same; values that are damaged,
 * of another program or of another driver are not given to the driver, and are put again.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <stdlib.h>

#include "random_light.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "alloc_fail.h"
#include "volumes_scene.h"

enum { RESOLUTION = 128, WIDE = 16, HIGH = 12, FLOATS = 4 * WIDE * HIGH, VALUES = 16 };

/* The caller's cache: values in memory. */
typedef struct stored_value {
    char   key[33];
    size_t size_bytes;
    void  *bytes;
} stored_value;

typedef struct memory_cache {
    stored_value values[VALUES];
    uint32_t     count, gets, puts;
    int          shrinks; /* a value is gone when it is read, after its size was told */
} memory_cache;

static stored_value *find(memory_cache *c, const char *key)
{
    for (uint32_t n = 0; n < c->count; n++)
        if (!strcmp(c->values[n].key, key)) return &c->values[n];
    return NULL;
}

static size_t cache_get(const char *key, void *value, size_t room_bytes, void *user)
{
    memory_cache *c = user;
    stored_value *s = find(c, key);
    c->gets++;
    assert_int_equal(strspn(key, "0123456789abcdef"), 32);
    if (!s || (c->shrinks && value)) return 0;
    if (s->size_bytes <= room_bytes) memcpy(value, s->bytes, s->size_bytes);
    return s->size_bytes;
}

static void cache_put(const char *key, const void *value, size_t size_bytes, void *user)
{
    memory_cache *c = user;
    stored_value *s = find(c, key);
    if (!s) {
        assert_true(c->count < VALUES);
        s = &c->values[c->count++];
        assert_int_equal(strlen(key), 32);
        strcpy(s->key, key);
    }
    free(s->bytes);
    s->bytes      = malloc(size_bytes);
    s->size_bytes = size_bytes;
    assert_non_null(s->bytes);
    memcpy(s->bytes, value, size_bytes);
    c->puts++;
}

static void cache_free(memory_cache *c)
{
    for (uint32_t n = 0; n < c->count; n++) free(c->values[n].bytes);
    *c = (memory_cache){0};
}

/* A driver that counts, and may be changed. */
static struct {
    uint32_t    compiled, restored;
    int         has_no_formats, refuses;
    const char *version;
} driver;

static void APIENTRY compile_counted(GLuint shader)
{
    driver.compiled++;
    ((PFNGLCOMPILESHADERPROC)gl_choice_function("glCompileShader"))(shader);
}

static void APIENTRY restore_counted(GLuint program, GLenum format, const void *bytes, GLsizei size)
{
    driver.restored++;
    if (!driver.refuses) ((PFNGLPROGRAMBINARYPROC)gl_choice_function("glProgramBinary"))(program, format, bytes, size);
}

static void APIENTRY get_integer(GLenum name, GLint *value)
{
    ((PFNGLGETINTEGERVPROC)gl_choice_function("glGetIntegerv"))(name, value);
    if (name == GL_NUM_PROGRAM_BINARY_FORMATS && driver.has_no_formats) *value = 0;
}

static const GLubyte *APIENTRY get_string(GLenum name)
{
    if (name == GL_VERSION && driver.version) return (const GLubyte *)driver.version;
    return ((PFNGLGETSTRINGPROC)gl_choice_function("glGetString"))(name);
}

static vxs_gl_function counted(const char *name, void *user)
{
    if (!strcmp(name, "glCompileShader")) return (vxs_gl_function)compile_counted;
    if (!strcmp(name, "glProgramBinary")) return (vxs_gl_function)restore_counted;
    if (!strcmp(name, "glGetIntegerv")) return (vxs_gl_function)get_integer;
    if (!strcmp(name, "glGetString")) return (vxs_gl_function)get_string;
    return gl_choice_proc(name, user);
}

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* Skips the test if the driver has no program binaries. */
static void open_scene(volumes_scene *s, memory_cache *cache, vxs_program_cache *callbacks)
{
    GLint formats = 0;
    scene_open(s, RESOLUTION, WIDE, HIGH);
    memset(&driver, 0, sizeof driver);
    *cache     = (memory_cache){0};
    *callbacks = (vxs_program_cache){cache_get, cache_put, cache};
    get_integer(GL_NUM_PROGRAM_BINARY_FORMATS, &formats);
    if (formats > 0) return;
    print_message("this driver has no program binaries; Mesa has none without its own cache\n");
    scene_close(s);
    skip();
}

/* A new context of OpenGL. */
static void renew_context(volumes_scene *s)
{
    vxs_volumes_destroy(s->volumes);
    vxs_gl_destroy(s->shadows);
    gl_context_destroy(s->gl);
    scene_open_asset(s, s->asset, WIDE, HIGH);
}

/* How a frame is drawn: with a cache or NULL; all techniques, 5 programs of 6 shaders, or only a march, 1 program; after a frame
 * that compiles; and which allocation fails. */
typedef struct drawing {
    const vxs_program_cache *cache;
    int                      all, warms;
    uint64_t                 fail_at;
} drawing;
enum { PROGRAMS = 5, SHADERS = 6 };

/* Draw with a new vxs_volumes.   Returns how many shaders were compiled */
static uint32_t draw(volumes_scene *s, const drawing *d, float pixels[FLOATS])
{
    static const double             eye[3] = {9, 3, 1}, to[3] = {0, 2, 0};
    static double                   metres[WIDE * HIGH];
    alloc_fail                      memory    = {.fail_at = d->fail_at};
    const vxs_allocator             allocator = alloc_fail_allocator(&memory);
    vxs_shadow_depth_map           *map       = NULL;
    vxs_volumes_light               l         = scene_light(SCENE_SPOT);
    const vxs_shadow_depth_map_desc side      = {.baked_number = l.baked_number, .side_px = 64};
    const vxs_volumes_desc          desc      = {.struct_size      = sizeof desc,
                                                 .get_proc_address = counted,
                                                 .allocator        = &allocator,
                                                 .shadows          = s->shadows,
                                                 .width_px         = WIDE,
                                                 .height_px        = HIGH,
                                                 .log              = scene_log,
                                                 .program_cache    = d->cache};
    volumes_camera                  c         = camera_at(eye, to, 0.8);
    vxs_volumes_frame               frame     = scene_frame(s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
    vxs_volumes_destroy(s->volumes);
    driver.compiled = driver.restored = 0;
    assert_int_equal(vxs_volumes_create(&s->volumes, &desc), VXS_OK);
    if (d->all) assert_int_equal(vxs_shadow_depth_map_create(&map, s->volumes, &side), VXS_OK);
    frame.struct_size = sizeof frame;
    for (int n = !d->warms; n < 2; n++) {
        frame.is_warming = !n;
        assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_march(s->volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_OK);
        if (!map) continue;
        while (vxs_shadow_depth_map_fill(map, 100000)) continue;
        assert_int_equal(vxs_volumes_intervals(s->volumes, &l), VXS_OK);
        assert_int_equal(vxs_volumes_mesh_map(s->volumes, &l, map), VXS_OK);
    }
    vxs_shadow_depth_map_destroy(map);
    scene_read(s, pixels);
    vxs_volumes_destroy(s->volumes);
    s->volumes = NULL;
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
    return driver.compiled;
}

/* From a full cache nothing is compiled, in a warming frame or without one, and pixels are the same. */
static void test_second_context(void **state)
{
    (void)state;
    static float      wanted[FLOATS], found[FLOATS], none[FLOATS];
    volumes_scene     s;
    memory_cache      cache;
    vxs_program_cache callbacks;
    open_scene(&s, &cache, &callbacks);
    assert_int_equal(draw(&s, &(drawing){NULL, 1, 0, 0}, wanted), SHADERS);
    assert_memory_not_equal(wanted, none, sizeof none);
    for (int warms = 0; warms < 2; warms++) {
        for (int again = 0; again < 2; again++) {
            renew_context(&s);
            assert_int_equal(draw(&s, &(drawing){&callbacks, 1, warms, 0}, found), again ? 0 : SHADERS);
            assert_int_equal(driver.restored, again ? PROGRAMS : 0);
            assert_int_equal(cache.puts, PROGRAMS);
            assert_memory_equal(found, wanted, sizeof found);
        }
        assert_int_equal(cache.count, PROGRAMS);
        cache_free(&cache);
    }
    scene_close(&s);
}

/* A caller that only reads, or only stores; a driver without binaries; another version of the driver; no memory. */
static void test_without(void **state)
{
    (void)state;
    static float      wanted[FLOATS], found[FLOATS];
    volumes_scene     s;
    memory_cache      cache;
    vxs_program_cache callbacks;
    open_scene(&s, &cache, &callbacks);
    const vxs_program_cache reads = {cache_get, NULL, &cache}, stores = {NULL, cache_put, &cache};
    const drawing           all = {&callbacks, 0, 0, 0};
    draw(&s, &(drawing){0}, wanted);
    driver.has_no_formats = 1;
    assert_int_equal(draw(&s, &all, found), 1);
    assert_int_equal(cache.gets + cache.puts, 0);
    driver.has_no_formats = 0;
    for (int n = 0; n < 2; n++) {
        assert_int_equal(draw(&s, &(drawing){&reads, 0, 0, 0}, found), !n);
        assert_int_equal(cache.puts, n);
        assert_int_equal(draw(&s, &(drawing){&stores, 0, 0, 0}, found), 1);
        assert_int_equal(cache.puts, n + 1);
    }
    assert_int_equal(draw(&s, &all, found), 0);
    driver.version = "4.5 of another day"; /* whose values stand beside those of the first */
    assert_int_equal(draw(&s, &all, found), 1);
    assert_int_equal(driver.restored, 0);
    assert_int_equal(cache.count, 2);
    driver.version = NULL;
    cache.puts     = 0;
    assert_int_equal(draw(&s, &(drawing){&callbacks, 0, 0, 2}, found), 1); /* for the value that is read */
    assert_memory_equal(found, wanted, sizeof found);
    assert_int_equal(cache.puts, 1);
    assert_int_equal(draw(&s, &(drawing){&stores, 0, 0, 2}, found), 1); /* for the one that is stored */
    assert_memory_equal(found, wanted, sizeof found);
    assert_int_equal(cache.puts, 1);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    cache_free(&cache);
    scene_close(&s);
}

/* Hold a changed value: it is compiled and put again, and what is drawn is the same.   restored  1: the driver gets the value */
static void hold_changed(volumes_scene *s, const vxs_program_cache *callbacks, const float wanted[FLOATS], uint32_t restored)
{
    static float  found[FLOATS];
    memory_cache *cache = callbacks->user;
    cache->puts         = 0;
    assert_int_equal(draw(s, &(drawing){callbacks, 0, 0, 0}, found), 1);
    assert_int_equal(driver.restored, restored);
    assert_int_equal(cache->puts, 1);
    assert_memory_equal(found, wanted, FLOATS * sizeof *found);
}

static void test_damage(void **state)
{
    (void)state;
    enum { HEAD_BYTES = 32 };
    static float      wanted[FLOATS], found[FLOATS];
    volumes_scene     s;
    memory_cache      cache;
    vxs_program_cache callbacks;
    rng               r = {3};
    open_scene(&s, &cache, &callbacks);
    draw(&s, &(drawing){&callbacks, 0, 0, 0}, wanted);
    stored_value *v    = cache.values;
    const size_t  size = v->size_bytes;
    assert_true(size > 2 * HEAD_BYTES && cache.count == 1);
    const size_t cuts[] = {1, HEAD_BYTES - 1, HEAD_BYTES, HEAD_BYTES + 1, size / 2, size - 1};
    for (size_t n = 0; n < sizeof cuts / sizeof *cuts; n++) {
        v->size_bytes = cuts[n];
        hold_changed(&s, &callbacks, wanted, 0);
    }
    for (size_t at = 0; at < size; at += at < HEAD_BYTES ? 1 : size / 5) { /* each byte of the head, and some others */
        ((unsigned char *)v->bytes)[at] ^= 1 << at % 8;
        hold_changed(&s, &callbacks, wanted, 0);
    }
    v->bytes = realloc(v->bytes, ++v->size_bytes); /* a byte too much */
    assert_non_null(v->bytes);
    ((char *)v->bytes)[size] = 0;
    hold_changed(&s, &callbacks, wanted, 0);
    for (size_t at = 0; at < size; at++) ((unsigned char *)v->bytes)[at] = (unsigned char)uniform(&r, 0, 256);
    hold_changed(&s, &callbacks, wanted, 0);
    cache.shrinks = 1;
    hold_changed(&s, &callbacks, wanted, 0);
    cache.shrinks = 0;
    assert_int_equal(v->size_bytes, size);

    driver.refuses = 1;
    hold_changed(&s, &callbacks, wanted, 1);
    driver.refuses = 0;
    assert_int_equal(draw(&s, &(drawing){&callbacks, 0, 0, 0}, found), 0);
    assert_memory_equal(found, wanted, sizeof found);

    draw(&s, &(drawing){&callbacks, 1, 0, 0}, found); /* values of other programs */
    assert_int_equal(cache.count, PROGRAMS);
    for (uint32_t n = 1; n < PROGRAMS; n++) {
        cache_put(v->key, cache.values[n].bytes, cache.values[n].size_bytes, &cache);
        hold_changed(&s, &callbacks, wanted, 0);
    }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    cache_free(&cache);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_second_context),
        cmocka_unit_test(test_without),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
