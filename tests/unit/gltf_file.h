/* Small glTF files for tests: written to a folder of their own, loaded, looked at.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GLTF_FILE_H
#define GLTF_FILE_H

#include "baker/scene/scene.h" /* before cmocka.h, which has a macro named fail */

#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static scene       s;
static run_context m;
static char        folder[] = "/tmp/vxs_gltf_XXXXXX";
static char        path[256];

static scene_choice chosen; /* what load_file requests, but for the scene */

#define LIGHTS "'extensions':{'KHR_lights_punctual':{'lights':["
#define USE(n) "'extensions':{'KHR_lights_punctual':{'light':" #n "}}"
#define HEAD   "{'asset':{'version':'2.0'},"

static inline void write_file(const char *name, const void *bytes, size_t size)
{
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline char *quoted(const char *json)
{
    char *text = strdup(json);
    assert_non_null(text);
    for (char *c = text; *c; c++)
        if (*c == '\'') *c = '"';
    return text;
}

/* A GLB in memory, to be freed. */
static inline uint8_t *make_glb(const char *json, const void *bin, size_t bin_size, size_t *size)
{
    char    *text      = quoted(json);
    uint32_t text_size = (uint32_t)(strlen(text) + 3) / 4 * 4;
    uint32_t padded    = (uint32_t)(bin_size + 3) / 4 * 4;
    *size              = 20 + text_size + (bin_size ? 8 + padded : 0);
    uint8_t *glb       = calloc(1, *size);
    assert_non_null(glb);
    memset(glb + 20, ' ', text_size);
    memcpy(glb + 20, text, strlen(text));
    memcpy(glb, "glTF", 4);
    memcpy(glb + 4, (uint32_t[]){2, (uint32_t)*size, text_size, 0x4e4f534a}, 16);
    if (bin_size) {
        memcpy(glb + 20 + text_size, (uint32_t[]){padded, 0x004e4942}, 8);
        memcpy(glb + 28 + text_size, bin, bin_size);
    }
    free(text);
    return glb;
}

static inline void forget(void)
{
    scene_free(&s);
    run_free(&m);
    memset(&m, 0, sizeof m);
}

static inline vxs_result load_file(const char *file, const char *which)
{
    forget();
    chosen.name = which;
    return scene_load_gltf(&s, file, &chosen, &m);
}

static inline vxs_result load_text(const char *json, const char *which)
{
    char *text = quoted(json);
    write_file("text.gltf", text, strlen(text));
    free(text);
    return load_file(path, which);
}

static inline void must(vxs_result r)
{
    if (r != VXS_OK) fail_msg("%s", m.error);
}

static inline void must_fail(vxs_result r, vxs_result expected, const char *words)
{
    if (r != expected || !strstr(m.error, words)) fail_msg("%d '%s', expected %d '%s'", r, m.error, expected, words);
    assert_null(strchr(m.error, '\n'));
    assert_true(s.vertex_count == 0 && !s.positions_ws && !s.indices && !s.lights && !s.name);
}

static inline void must_warn(const char *words)
{
    for (size_t i = 0; i < m.warning_count; i++)
        if (strstr(m.warnings[i], words)) return;
    fail_msg("no warning with '%s'", words);
}

static inline void expect_corner(size_t triangle, int corner, double x, double y, double z)
{
    assert_true(triangle < s.triangle_count);
    uint32_t v = s.indices[3 * triangle + (size_t)corner];
    assert_true(v < s.vertex_count);
    const double *p = s.positions_ws + 3 * v;
    if (fabs(p[0] - x) > 1e-12 || fabs(p[1] - y) > 1e-12 || fabs(p[2] - z) > 1e-12)
        fail_msg("triangle %zu corner %d is (%g %g %g), expected (%g %g %g)", triangle, corner, p[0], p[1], p[2], x, y, z);
}

static inline const char *scenes_folder(void)
{
    const char *given = getenv("VXS_SCENES");
    const char *found = given && *given ? given : "../shared/scenes";
    struct stat status;
    if (!stat(found, &status)) return found;
    print_message("no scenes at %s (VXS_SCENES)\n", found);
    skip();
    return NULL;
}

static inline int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    (void)state;
    forget();
    DIR *files = opendir(folder);
    if (!files) return -1;
    for (struct dirent *file; (file = readdir(files));) {
        snprintf(path, sizeof path, "%s/%.200s", folder, file->d_name);
        if (file->d_name[0] != '.') unlink(path);
    }
    closedir(files);
    return rmdir(folder);
}

#endif
