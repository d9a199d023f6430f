/* Components and nodes as objects, and their names; see scene_objects.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/scene_objects.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/vec3.h"

/* Fill boxes and counts of the objects from list->of. */
static void fill(object_list *list, const casters *c, size_t components)
{
    for (size_t n = 0; n < list->count; n++) list->items[n] = (scene_object){.around = box_empty(), .component = UINT32_MAX};
    for (size_t n = 0; n < components; n++) {
        scene_object *o = &list->items[list->of[n]];
        if (o->component == UINT32_MAX) o->component = (uint32_t)n;
        box_add(&o->around, c->boxes[n].min);
        box_add(&o->around, c->boxes[n].max);
    }
    for (size_t t = 0; t < c->triangle_count; t++) list->items[list->of[c->component_of[t]]].triangles++;
}

int objects_by_component(object_list *list, const casters *c)
{
    *list = (object_list){0};
    os_mutex_init(&list->lock);
    list->count = casters_component_count(c);
    list->items = malloc((list->count + 1) * sizeof *list->items);
    list->of    = malloc((list->count + 1) * sizeof *list->of);
    if (!list->items || !list->of) return 0;
    for (size_t n = 0; n < list->count; n++) list->of[n] = (uint32_t)n;
    fill(list, c, list->count);
    return 1;
}

int objects_by_node(object_list *list, const casters *c, const scene *s)
{
    size_t    components = casters_component_count(c), nodes = 0;
    uint32_t *object_of = NULL; /* [nodes] 1 + index of its object; 0: none yet */
    *list               = (object_list){0};
    os_mutex_init(&list->lock);
    if (!s || !s->part_count) return 0;
    for (size_t n = 0; n < s->part_count; n++)
        if (s->parts[n].node >= nodes) nodes = (size_t)s->parts[n].node + 1;
    object_of   = calloc(nodes, sizeof *object_of);
    list->items = malloc((components + 1) * sizeof *list->items);
    list->of    = malloc((components + 1) * sizeof *list->of);
    if (object_of && list->items && list->of) {
        for (size_t n = 0; n < components; n++) {
            uint32_t *object = &object_of[s->parts[c->parts_of[n].first].node];
            if (!*object) *object = (uint32_t)++list->count;
            list->of[n] = *object - 1;
        }
        fill(list, c, components);
    }
    free(object_of);
    return list->count != 0;
}

void objects_free(object_list *list)
{
    os_mutex_free(&list->lock);
    free(list->items);
    free(list->of);
    free(list->first);
    free(list->members);
    *list = (object_list){0};
}

/* Find the triangles of each object; a second call does nothing. Returns 0 without memory. */
static int find_members(object_list *list, const casters *c)
{
    uint32_t at = 0;
    if (list->first) return 1;
    uint32_t *first = malloc((list->count + 1) * sizeof *first);
    list->members   = malloc((c->triangle_count + 1) * sizeof *list->members);
    if (!first || !list->members) {
        free(first);
        return 0;
    }
    for (size_t n = 0; n < list->count; n++) {
        first[n] = at;
        at += (uint32_t)list->items[n].triangles;
    }
    for (size_t t = 0; t < c->triangle_count; t++) list->members[first[list->of[c->component_of[t]]]++] = (uint32_t)t;
    for (size_t n = list->count; n > 0; n--) first[n] = first[n - 1];
    first[0]    = 0;
    list->first = first;
    return 1;
}

static int objects_find_members(object_list *list, const casters *c)
{
    os_lock(&list->lock);
    int found = find_members(list, c);
    os_unlock(&list->lock);
    return found;
}

/* names ----------------------------------------------------------------------------------------------------------------------- */

typedef enum part_label { BY_NODE, BY_MESH, BY_MATERIAL, LABELS } part_label;
static const char *const label_words[LABELS] = {"node", "mesh", "material"};

static uint32_t number_of(const scene_part *p, part_label by)
{
    return by == BY_NODE ? p->node : by == BY_MESH ? p->mesh : p->material;
}

static const char *name_of(const scene *s, const scene_part *p, part_label by)
{
    return s->names + (by == BY_NODE ? p->node_name : by == BY_MESH ? p->mesh_name : p->material_name);
}

/* Number of the scene's triangles with the label of `part`; *alone: 0 if another label has the same name. */
static size_t count_labelled(const scene *s, const scene_part *part, part_label by, int *alone)
{
    size_t count = 0;
    *alone       = 1;
    for (size_t n = 0; n < s->part_count; n++) {
        const scene_part *p   = &s->parts[n];
        size_t            end = n + 1 < s->part_count ? s->parts[n + 1].triangle_first : s->triangle_count;
        if (number_of(p, by) == number_of(part, by))
            count += end - p->triangle_first;
        else if (!strcmp(name_of(s, p, by), name_of(s, part, by)))
            *alone = 0;
    }
    return count;
}

static void write_name(object_name *out, const scene *s, const scene_part *part, part_label by, int alone)
{
    char        shown[61], pattern[80];
    const char *name = name_of(s, part, by), *word = label_words[by];
    if (*name)
        snprintf(out->text, sizeof out->text, "%s '%s'", word, shorten(shown, 60, name));
    else
        snprintf(out->text, sizeof out->text, "%s %u", word, number_of(part, by));

    /* the name, if it can be a pattern as it is; "#7" can be used for any */
    int plain = alone && *name && strlen(name) <= 60 && !strpbrk(name, "*?[\\'");
    for (const char *c = name; *c; c++) plain &= (unsigned char)*c >= 0x20 && *c != 0x7f;
    if (plain)
        snprintf(pattern, sizeof pattern, "%s:%s", word, name);
    else
        snprintf(pattern, sizeof pattern, "%s:#%u", word, number_of(part, by));
    int quotes = strspn(pattern, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.:#") != strlen(pattern);
    snprintf(out->option, sizeof out->option, "--exclude %s%s%s", quotes ? "'" : "", pattern, quotes ? "'" : "");
}

void object_name_find(object_name *name, const scene_object *object, const casters *c, const scene *s)
{
    const box *b    = &object->around;
    name->option[0] = 0;
    if (s && s->part_count) {
        const scene_part *part  = &s->parts[c->parts_of[object->component].first];
        size_t            least = object->triangles / 2,
               most             = object->triangles + object->triangles / 4 + 2; /* splitting may have added triangles */
        for (int turn = 0; turn < 2 * LABELS; turn++) {                          /* labels with a name first */
            part_label by      = (part_label)(turn % LABELS);
            int        is_none = by == BY_MATERIAL && part->material == SCENE_NO_MATERIAL, alone;
            if (is_none || (turn < LABELS && !*name_of(s, part, by))) continue;
            size_t count = count_labelled(s, part, by, &alone);
            if (count < least || count > most) continue;
            write_name(name, s, part, by, alone);
            return;
        }
    }
    snprintf(name->text, sizeof name->text, "the component of %zu triangles from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g)",
             object->triangles, b->min[0], b->min[1], b->min[2], b->max[0], b->max[1], b->max[2]);
}

/* Finding an object that hides a light; see scene_objects.h.
 *
 *     points on all objects ---boxes---> a few candidates ---rays to points on the other objects---> the hider
 * */

enum { POINTS = 256, POINTS_SOON = 16, POINTS_LIT = 6, POINTS_MIN = 24, OBJECTS_TRIED = 4 };
static const double SHARE_LIT = 0.02, SHARE_MIXED = 0.1, BULB_METRES = 1.5, GRAZING = 1e-6;

/* Ray from a point to the light: at + t * way. t ends at 1 for a punctual light; it has no end for a sun. */
typedef struct light_ray {
    double at[3], way[3], t_end;
    double over_way[3]; /* 1 / way */
} light_ray;

static light_ray ray_to_light(const light_shape *shape, const double at_ws[3])
{
    light_ray r = {.t_end = shape->kind == LIGHT_DIRECTIONAL ? INFINITY : 1};
    memcpy(r.at, at_ws, sizeof r.at);
    for (int n = 0; n < 3; n++) {
        r.way[n]      = shape->kind == LIGHT_DIRECTIONAL ? -shape->direction_ws[n] : shape->position_ws[n] - at_ws[n];
        r.over_way[n] = r.way[n] == 0 ? INFINITY : 1 / r.way[n];
    }
    return r;
}

static int meets_box(const light_ray *r, const box *b)
{
    double from = 0, to = r->t_end;
    for (int n = 0; n < 3; n++) { /* a ray along a face of the box gives NaN, which bounds nothing */
        double low  = ((r->over_way[n] < 0 ? b->max[n] : b->min[n]) - r->at[n]) * r->over_way[n];
        double high = ((r->over_way[n] < 0 ? b->min[n] : b->max[n]) - r->at[n]) * r->over_way[n];
        if (low > from) from = low;
        if (high < to) to = high;
    }
    return from <= to;
}

/* boxes ----------------------------------------------------------------------------------------------------------------------- */

/* Whether an object contains a punctual light or is near it. An object whose distance is greater than its size leaves most
 * directions free. */
static int is_near(const box *b, const light_shape *shape)
{
    double away = 0, diagonal = box_diagonal(b);
    if (shape->kind == LIGHT_DIRECTIONAL) return 1;
    for (int n = 0; n < 3; n++) {
        double at = shape->position_ws[n], beside = at < b->min[n] ? b->min[n] - at : at > b->max[n] ? at - b->max[n] : 0;
        away += beside * beside;
    }
    return away <= diagonal * diagonal;
}

/* Returns 0 if more than a tenth of the points on other objects are not behind the object's box. */
static int may_hide(const object_list *objects, size_t object, const lit_point *points, const light_ray *rays, size_t count,
                    const uint32_t *component_of)
{
    size_t free = 0, most = 1 + (size_t)(SHARE_MIXED * (double)count);
    for (size_t n = 0; n < count && free <= most; n++)
        free += objects->of[component_of[points[n].triangle]] != object && !meets_box(&rays[n], &objects->items[object].around);
    return free <= most;
}

/* Candidates, those with fewest triangles first. Returns their number. */
static size_t find_suspects(size_t suspects[OBJECTS_TRIED], const object_list *objects, const lit_point *points, size_t count,
                            const lit_points_desc *d)
{
    light_ray rays[POINTS];
    size_t    found = 0;
    count           = count < POINTS ? count : POINTS;
    for (size_t n = 0; n < count; n++) rays[n] = ray_to_light(d->shape, points[n].at_ws);
    for (size_t k = 0; k < objects->count; k++) {
        if (!is_near(&objects->items[k].around, d->shape)) continue;
        if (count > POINTS_SOON && !may_hide(objects, k, points, rays, POINTS_SOON, d->c->component_of)) continue;
        if (!may_hide(objects, k, points, rays, count, d->c->component_of)) continue;
        size_t place = found < OBJECTS_TRIED ? found++ : OBJECTS_TRIED;
        while (place && objects->items[k].triangles < objects->items[suspects[place - 1]].triangles) {
            if (place < OBJECTS_TRIED) suspects[place] = suspects[place - 1];
            place--;
        }
        if (place < OBJECTS_TRIED) suspects[place] = k;
    }
    return found;
}

/* rays ------------------------------------------------------------------------------------------------------------------------ */

/* An object's triangles: one corner and two edges each. */
typedef struct shell {
    size_t count;
    double (*triangles)[9]; /* [count] corner, edge, edge */
    uint8_t *two_sided;     /* [count] */
} shell;

static int shell_of(shell *s, object_list *objects, size_t object, const casters *c)
{
    size_t count = objects->items[object].triangles;
    *s           = (shell){0, malloc((count + 1) * sizeof *s->triangles), malloc(count + 1)};
    if (!s->triangles || !s->two_sided || !objects_find_members(objects, c)) return 0;
    for (const uint32_t *t = objects->members + objects->first[object]; s->count < count; t++) {
        double       *out = s->triangles[s->count];
        const double *p[3];
        for (size_t n = 0; n < 3; n++) p[n] = c->positions_ws + 3 * (size_t)c->indices[3 * (size_t)*t + n];
        memcpy(out, p[0], 3 * sizeof *out);
        vec3_sub(p[1], p[0], out + 3);
        vec3_sub(p[2], p[0], out + 6);
        s->two_sided[s->count++] = c->double_sided && c->double_sided[*t];
    }
    return 1;
}

/* Intersection of a ray with an object, nearest to the light. A ray that begins on the object's surface, as under a crate on a
 * floor, is blocked if it passes through that surface: the light sees the surface from behind. */
typedef struct shell_hit {
    int    found, from_behind; /* from_behind: the light sees the back of a one-sided material */
    double t;
} shell_hit;

/* Moeller and Trumbore, 1997. */
static shell_hit meet(const shell *s, const light_ray *r)
{
    shell_hit hit = {.t = -GRAZING};
    for (size_t n = 0; n < s->count; n++) {
        const double *corner = s->triangles[n], *e1 = corner + 3, *e2 = corner + 6;
        double        p[3], q[3], from[3];
        vec3_cross(r->way, e2, p);
        double facing = vec3_dot(e1, p); /* > 0: the ray goes against the normal */
        if (facing == 0) continue;
        vec3_sub(r->at, corner, from);
        double u = vec3_dot(from, p) / facing;
        if (!(u >= 0 && u <= 1)) continue;
        vec3_cross(from, e1, q);
        double v = vec3_dot(r->way, q) / facing, t = vec3_dot(e2, q) / facing;
        if (!(v >= 0 && u + v <= 1) || !(t > hit.t) || t >= r->t_end * (1 - GRAZING) || (t < GRAZING && facing < 0)) continue;
        hit = (shell_hit){.found = 1, .from_behind = facing > 0 && !s->two_sided[n], .t = t};
    }
    return hit;
}

/* Share of rays from a point that meet an object. */
static double share_around(const shell *s, const double at_ws[3], const double (*ways)[3], int count)
{
    int met = 0;
    for (int n = 0; n < count; n++) {
        light_ray r = {.t_end = INFINITY};
        memcpy(r.at, at_ws, sizeof r.at);
        memcpy(r.way, ways[n], sizeof r.way);
        met += meet(s, &r).found;
    }
    return (double)met / count;
}

/* No direction is parallel to a face of a box: the ray could meet its edges. */
static const double ways_around[14][3] = {{1, .02, .03},  {-1, .03, .02}, {.03, 1, .02},  {.02, -1, .03}, {.02, .03, 1},
                                          {.03, .02, -1}, {1, 1.1, .9},   {-1, 1.1, .9},  {1, -1.1, .9},  {1, 1.1, -.9},
                                          {-1, -1.1, .9}, {-1, 1.1, -.9}, {1, -1.1, -.9}, {-1, -1.1, -.9}};
static const double ways_level[5][3]   = {{1, .02, .03}, {-1, .03, .02}, {.02, .03, 1}, {.03, .02, -1}, {.03, 1, .02}};

/* Whether the object is not worth a bake itself, judged by its lit points. */
static int is_useless(const shell *s, const lit_points_desc *d, const lit_point *points, size_t hidden, size_t from_behind,
                      double farthest_metres)
{
    int sees_back = (double)from_behind >= (1 - SHARE_MIXED) * (double)hidden;
    if (d->shape->kind != LIGHT_DIRECTIONAL)
        return sees_back || farthest_metres <= BULB_METRES || share_around(s, d->shape->position_ws, ways_around, 14) < 0.8;
    double around = 0;
    for (size_t n = 0; n < 16; n++) around += share_around(s, points[n].at_ws, ways_level, 5) / 16;
    return sees_back || around >= 0.95;
}

/* A fast test with the points on all objects: several points on other objects are lit. */
static int lets_light_past(const shell *s, const object_list *objects, size_t object, const lit_point *all, size_t count,
                           const lit_points_desc *d)
{
    size_t lit = 0;
    for (size_t n = 0; n < count && lit < POINTS_LIT; n++) {
        light_ray r = ray_to_light(d->shape, all[n].at_ws);
        lit += objects->of[d->c->component_of[all[n].triangle]] != object && !meet(s, &r).found;
    }
    return lit == POINTS_LIT;
}

static int hides(object_list *objects, size_t object, const lit_point *all, size_t all_count, const lit_points_desc *d,
                 double *farthest_metres)
{
    lit_point       points[POINTS];
    lit_points_desc others = *d;
    shell           s      = {0};
    size_t          count = 0, lit = 0, behind = 0;
    int             is   = 0;
    others.object_of     = objects->of;
    others.without       = (uint32_t)object;
    others.triangles_max = 0;
    if (!shell_of(&s, objects, object, d->c) || lets_light_past(&s, objects, object, all, all_count, d)) goto done;
    if ((count = lit_points_choose(points, POINTS, &others)) < POINTS_MIN) goto done;
    size_t free_most = (size_t)(SHARE_LIT * (double)count);
    *farthest_metres = 0;
    for (size_t n = 0; n < count && lit <= free_most; n++) {
        light_ray r   = ray_to_light(d->shape, points[n].at_ws);
        shell_hit hit = meet(&s, &r);
        lit += !hit.found;
        behind += hit.from_behind;
        if (hit.found) *farthest_metres = fmax(*farthest_metres, (1 - hit.t) * sqrt(vec3_dot(r.way, r.way)));
    }
    is = lit <= free_most && is_useless(&s, d, points, count - lit, behind, *farthest_metres);
done:
    free(s.triangles);
    free(s.two_sided);
    return is;
}

const scene_object *light_hider_find(object_list *objects, const lit_point *points, size_t point_count, const lit_points_desc *d,
                                     double *distance_metres)
{
    size_t suspects[OBJECTS_TRIED];
    if (objects->count < 2) return NULL;
    size_t count = find_suspects(suspects, objects, points, point_count, d);
    for (size_t n = 0; n < count; n++)
        if (hides(objects, suspects[n], points, point_count, d, distance_metres)) return &objects->items[suspects[n]];
    return NULL;
}
