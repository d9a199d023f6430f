/* Components and nodes as objects, and their names; see scene_objects.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/scene_objects.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"

static size_t count_components(const casters *c)
{
    size_t count = 0;
    for (int kind = 0; kind < COMPONENT_KINDS; kind++) count += c->component_count[kind];
    return count;
}

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
    *list       = (object_list){0};
    list->count = count_components(c);
    list->items = malloc((list->count + 1) * sizeof *list->items);
    list->of    = malloc((list->count + 1) * sizeof *list->of);
    if (!list->items || !list->of) return 0;
    for (size_t n = 0; n < list->count; n++) list->of[n] = (uint32_t)n;
    fill(list, c, list->count);
    return 1;
}

int objects_by_node(object_list *list, const casters *c, const scene *s)
{
    size_t    components = count_components(c), nodes = 0;
    uint32_t *object_of = NULL; /* [nodes] 1 + index of its object; 0: none yet */
    *list               = (object_list){0};
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
    free(list->items);
    free(list->of);
    free(list->first);
    free(list->members);
    *list = (object_list){0};
}

int objects_find_members(object_list *list, const casters *c)
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

/* Whether a name can be a pattern as it is; "#7" can be used for any other. */
static int is_plain(const char *name)
{
    size_t length = strlen(name);
    if (!length || length > 60 || strpbrk(name, "*?[\\'")) return 0;
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) return 0;
    return 1;
}

static void write_name(object_name *out, const scene *s, const scene_part *part, part_label by, int alone)
{
    char        shown[61], pattern[80];
    const char *name = name_of(s, part, by), *word = label_words[by];
    if (*name)
        snprintf(out->text, sizeof out->text, "%s '%s'", word, shorten(shown, 60, name));
    else
        snprintf(out->text, sizeof out->text, "%s %u", word, number_of(part, by));
    if (alone && is_plain(name))
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
