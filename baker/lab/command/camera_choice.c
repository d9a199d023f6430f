/* Cameras of a command line; see camera_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/camera_choice.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/nearest.h"
#include "baker/base/text.h"
#include "baker/base/vec3.h"
#include "baker/files/input_file.h"
#include "baker/scene/light_choice.h"

vxs_result camera_check(const camera_choice *c, run_context *m)
{
    if (c->eye_given != c->target_given)
        return fail(m, VXS_E_ARGUMENT, "--eye and --target go together: %s is missing", c->eye_given ? "--target" : "--eye");
    if (c->eye_given && !memcmp(c->camera.eye_ws, c->camera.target_ws, sizeof c->camera.eye_ws))
        return fail(m, VXS_E_ARGUMENT, "--eye and --target are the same point: expected two");
    return VXS_OK;
}

/* cameras of a file ------------------------------------------------------------------------------------------------------------ */

static const double PARALLEL_TIMES = 1000;

/* Called only if no camera has exactly this name. */
static int is_meant(const char *name, size_t number, const scene_view *v)
{
    char digits[24];
    snprintf(digits, sizeof digits, "%zu", number);
    return !strcmp(name, digits) || light_name_matches(name, number, v->name);
}

/* "#0 'front' (perspective), ...": the cameras that match a name, or all. */
static const char *list_cameras(char text[LIST_BYTES], const scene *s, const char *name)
{
    static const char *const kinds[] = {"unsound", "perspective", "orthographic"};
    text[0]                          = 0;
    for (size_t n = 0; n < s->view_count; n++) {
        char item[LIST_BYTES];
        if (name && strcmp(name, s->views[n].name) != 0 && !is_meant(name, n, &s->views[n])) continue;
        snprintf(item, sizeof item, "#%zu '%s' (%s)", n, s->views[n].name, kinds[s->views[n].kind]);
        list_item(text, item);
    }
    return text;
}

vxs_result scene_camera_find(const scene_view **view, const scene *s, const char *name, const char *path, run_context *m)
{
    size_t by_name = 0, by_pattern = 0;
    char   known[LIST_BYTES];
    for (size_t n = 0; n < s->view_count; n++) by_name += !strcmp(name, s->views[n].name);
    for (size_t n = 0; n < s->view_count; n++) {
        const scene_view *v = &s->views[n];
        if (by_name ? strcmp(name, v->name) != 0 : !is_meant(name, n, v)) continue;
        *view = v;
        by_pattern++;
    }
    if (!by_pattern) {
        nearest near = {.typed = name};
        char    all[LIST_BYTES], meant[64];
        if (!s->view_count)
            return fail(m, VXS_E_ARGUMENT, "--camera %s: '%s' has no camera; --eye and --target give one", name, path);
        for (size_t n = 0; n < s->view_count; n++) nearest_try(&near, s->views[n].name, strlen(s->views[n].name));
        return fail(m, VXS_E_ARGUMENT, "--camera %s: '%s' has no camera of that name; it has %s%s", name, path,
                    list_cameras(all, s, NULL), nearest_text(meant, &near));
    }
    if (by_pattern > 1)
        return fail(m, VXS_E_ARGUMENT, "--camera %s: '%s' has %zu of them, %s; expected one", name, path, by_pattern,
                    list_cameras(known, s, name));
    if ((*view)->kind != VIEW_NONE) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT,
                "--camera %s: '%s' says nothing sound of what it sees: expected a perspective with yfov, or an orthographic "
                "with xmag and ymag, on a node without a scale of 0",
                name, path);
}

static uint32_t side_of(double px, uint32_t side_max)
{
    double least = 16;
    return (uint32_t)fmin(fmax(rint(px), least), side_max);
}

void scene_camera_size(const scene_view *view, int width_given, int height_given, uint32_t side_max, uint32_t *width,
                       uint32_t *height)
{
    if (!(view->aspect > 0) || (width_given && height_given)) return;
    if (width_given)
        *height = side_of(*width / view->aspect, side_max);
    else
        *width = side_of(*height * view->aspect, side_max);
}

camera_pose scene_camera_pose(const scene_view *view, const box *around)
{
    const double degrees = 180 / 3.14159265358979323846;
    camera_pose  p       = {.fov_degrees = 2 * atan(view->half_high) * degrees, .near_metres = view->near_metres};
    double       ahead = 1, back = 0;
    memcpy(p.up_ws, view->up_ws, sizeof p.up_ws);
    if (view->kind == VIEW_ORTHOGRAPHIC) {
        back          = PARALLEL_TIMES * fmax(view->half_high, box_diagonal(around));
        ahead         = 0;
        p.fov_degrees = 2 * atan(view->half_high / back) * degrees;
        p.near_metres = back + view->near_metres;
    }
    vec3_mad(view->eye_ws, -back, view->forward_ws, p.eye_ws);
    vec3_mad(view->eye_ws, ahead, view->forward_ws, p.target_ws);
    return p;
}

/* paths ------------------------------------------------------------------------------------------------------------------------ */

enum { ORBIT_KEYS = 24, PATH_BYTES_MAX = 8 << 20 };

static const double pi = 3.14159265358979323846;

static vxs_result read_keys(camera_path *path, char *text, const char *name, double fov_degrees, run_context *m)
{
    size_t number = 0;
    path->keys    = malloc(PATH_KEYS_MAX * sizeof *path->keys);
    if (!path->keys) return fail(m, VXS_E_MEMORY, "out of memory for a camera path");
    for (char *line = text, *next; line; line = next) {
        next = strchr(line, '\n');
        if (next) *next++ = 0;
        number++;
        size_t blank = strspn(line, " \t\r");
        if (!line[blank] || line[blank] == '#') continue;
        if (path->count == PATH_KEYS_MAX)
            return fail(m, VXS_E_READ, "'%s' line %zu: more than %d keys", name, number, (int)PATH_KEYS_MAX);
        camera_pose *key = &path->keys[path->count++];
        *key             = (camera_pose){.fov_degrees = fov_degrees};
        int good         = 1; /* exactly six finite numbers, two different points */
        for (int n = 0; n < 6; n++) {
            char  *end;
            double value = strtod(line, &end);
            good &= end != line && isfinite(value);
            (n < 3 ? key->eye_ws : key->target_ws)[n % 3] = value;
            line                                          = end;
        }
        if (!good || line[strspn(line, " \t\r")] || !memcmp(key->eye_ws, key->target_ws, sizeof key->eye_ws))
            return fail(m, VXS_E_READ, "'%s' line %zu: expected six numbers, x y z of the eye and of another point to look at",
                        name, number);
    }
    return path->count > 1 ? VXS_OK : fail(m, VXS_E_READ, "'%s' has %zu keys: a path needs two", name, path->count);
}

static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    (void)user;
    return memchr(first, 0, size_bytes) ? 0 : UINT64_MAX; /* not a text file */
}

vxs_result camera_path_read(camera_path *path, const char *file, double fov_degrees, run_context *m)
{
    uint8_t *bytes  = NULL;
    size_t   size   = 0;
    *path           = (camera_path){0};
    vxs_result r    = input_read(&bytes, &size, file, PATH_BYTES_MAX, &(input_head){wanted_bytes, NULL}, m);
    char      *text = r == VXS_OK ? malloc(size + 1) : NULL;
    if (text) {
        memcpy(text, bytes, size);
        text[size] = 0;
        r          = strlen(text) == size ? read_keys(path, text, input_name(file), fov_degrees, m)
                                          : fail(m, VXS_E_READ, "'%s' is no text", input_name(file));
    } else if (r == VXS_OK)
        r = fail(m, VXS_E_MEMORY, "out of memory for a camera path");
    free(text);
    free(bytes);
    return r;
}

vxs_result camera_path_orbit(camera_path *path, const camera_pose *camera, run_context *m)
{
    *path = (camera_path){.count = ORBIT_KEYS, .closed = 1, .keys = malloc(ORBIT_KEYS * sizeof *path->keys)};
    if (!path->keys) return fail(m, VXS_E_MEMORY, "out of memory for a camera path");
    double x = camera->eye_ws[0] - camera->target_ws[0], z = camera->eye_ws[2] - camera->target_ws[2];
    for (int n = 0; n < ORBIT_KEYS; n++) {
        double angle            = 2 * pi * n / ORBIT_KEYS;
        path->keys[n]           = *camera;
        path->keys[n].eye_ws[0] = camera->target_ws[0] + x * cos(angle) - z * sin(angle);
        path->keys[n].eye_ws[2] = camera->target_ws[2] + x * sin(angle) + z * cos(angle);
    }
    return VXS_OK;
}

static const camera_pose *key_at(const camera_path *path, long n)
{
    long count = (long)path->count;
    if (path->closed) return &path->keys[(n % count + count) % count];
    return &path->keys[n < 0 ? 0 : n < count ? n : count - 1];
}

static double between(double before, double a, double b, double behind, double t)
{
    return a + 0.5 * t * (b - before + t * (2 * before - 5 * a + 4 * b - behind + t * (3 * (a - b) + behind - before)));
}

camera_pose camera_path_at(const camera_path *path, double share)
{
    double      at = share * (double)(path->closed ? path->count : path->count - 1), from = floor(at);
    long        n      = (long)from;
    camera_pose result = *key_at(path, n);
    for (int k = 0; k < 3; k++) {
        result.eye_ws[k]    = between(key_at(path, n - 1)->eye_ws[k], key_at(path, n)->eye_ws[k], key_at(path, n + 1)->eye_ws[k],
                                      key_at(path, n + 2)->eye_ws[k], at - from);
        result.target_ws[k] = between(key_at(path, n - 1)->target_ws[k], key_at(path, n)->target_ws[k],
                                      key_at(path, n + 1)->target_ws[k], key_at(path, n + 2)->target_ws[k], at - from);
    }
    return result;
}

void camera_path_free(camera_path *path)
{
    free(path->keys);
    *path = (camera_path){0};
}
