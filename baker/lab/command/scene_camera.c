/* A camera of a scene's file; see scene_camera.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/scene_camera.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "baker/base/nearest.h"
#include "baker/base/text.h"
#include "baker/base/vec3.h"
#include "baker/scene/light_choice.h"

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

static vxs_result fail_unknown(const scene *s, const char *name, const char *path, message *m)
{
    nearest near = {.typed = name};
    char    known[LIST_BYTES], meant[64];
    if (!s->view_count) return fail(m, VXS_E_ARGUMENT, "--camera %s: '%s' has no camera; --eye and --target give one", name, path);
    for (size_t n = 0; n < s->view_count; n++) nearest_try(&near, s->views[n].name, strlen(s->views[n].name));
    return fail(m, VXS_E_ARGUMENT, "--camera %s: '%s' has no camera of that name; it has %s%s", name, path,
                list_cameras(known, s, NULL), nearest_text(meant, &near));
}

vxs_result scene_camera_find(const scene_view **view, const scene *s, const char *name, const char *path, message *m)
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
    if (!by_pattern) return fail_unknown(s, name, path, m);
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
    camera_pose  p       = {.fov_degrees = 2 * atan(view->half_high) * degrees, .near_metres = view->near_m};
    double       ahead = 1, back = 0;
    memcpy(p.up_ws, view->up_ws, sizeof p.up_ws);
    if (view->kind == VIEW_ORTHOGRAPHIC) {
        back          = PARALLEL_TIMES * fmax(view->half_high, box_diagonal(around));
        ahead         = 0;
        p.fov_degrees = 2 * atan(view->half_high / back) * degrees;
        p.near_metres = back + view->near_m;
    }
    vec3_mad(view->eye_ws, -back, view->forward_ws, p.eye_ws);
    vec3_mad(view->eye_ws, ahead, view->forward_ws, p.target_ws);
    return p;
}
