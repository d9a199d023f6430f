/* Where a camera is, frame by frame; see camera_path.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/camera_path.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/files/input_file.h"

enum { ORBIT_KEYS = 24, FILE_BYTES_MAX = 8 << 20 };

static const double pi = 3.14159265358979323846;

/* Parse a line of exactly six finite numbers. */
static int read_key(char *line, camera_pose *key)
{
    double numbers[6];
    for (int n = 0; n < 6; n++) {
        char *end;
        numbers[n] = strtod(line, &end);
        if (end == line || !isfinite(numbers[n])) return 0;
        line = end;
    }
    memcpy(key->eye_ws, numbers, sizeof key->eye_ws);
    memcpy(key->target_ws, numbers + 3, sizeof key->target_ws);
    return line[strspn(line, " \t\r")] == 0 && memcmp(key->eye_ws, key->target_ws, sizeof key->eye_ws);
}

static vxs_result read_keys(camera_path *path, char *text, const char *name, double fov_degrees, message *m)
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
        if (!read_key(line, key))
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

vxs_result camera_path_read(camera_path *path, const char *file, double fov_degrees, message *m)
{
    uint8_t *bytes  = NULL;
    size_t   size   = 0;
    *path           = (camera_path){0};
    vxs_result r    = input_read(&bytes, &size, file, FILE_BYTES_MAX, &(input_head){wanted_bytes, NULL}, m);
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

vxs_result camera_path_orbit(camera_path *path, const camera_pose *camera, message *m)
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
