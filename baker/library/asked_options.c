/* Options of a program; see asked_options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/library/asked_options.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/parallel.h"
#include "baker/scene/light_choice.h"

enum { RESOLUTION_DEFAULT_PX = 4096, ZSTD_DEFAULT = 12, ZSTD_MAX = 19 };

static const double TEXEL_MIN_METRES = 1e-9, TEXEL_MAX_METRES = 1e9;

/* the struct ------------------------------------------------------------------------------------------------------------------ */

/* Copy the options. The struct of an older program is shorter. A newer program's is longer; its fields that this library does
 * not know must be 0. */
static vxs_result take_known(vxs_bake_options *known, const vxs_bake_options *options, run_context *m)
{
    const size_t least = offsetof(vxs_bake_options, blend), second = offsetof(vxs_bake_options, files); /* sizes of versions */
    *known = (vxs_bake_options){0};
    if (!options || options->struct_size < least || options->struct_size > 64 * sizeof *known)
        return fail(m, VXS_E_ARGUMENT, "options: expected what vxs_bake_defaults returns, with what is to be changed");
    size_t size = options->struct_size < second ? least : options->struct_size < sizeof *known ? second : sizeof *known;
    memcpy(known, options, size);
    known->struct_size         = sizeof *known;
    const unsigned char *bytes = (const unsigned char *)options;
    for (size_t n = sizeof *known; n < options->struct_size; n++)
        if (bytes[n]) return fail(m, VXS_E_ARGUMENT, "options: some are of a later version than this library");
    return VXS_OK;
}

/* numbers and words ----------------------------------------------------------------------------------------------------------- */

static vxs_result check_choice(const char *name, unsigned value, unsigned most, run_context *m)
{
    return value <= most ? VXS_OK : fail(m, VXS_E_ARGUMENT, "%s %u: expected 0 to %u", name, value, most);
}

/* At most one of the two may be given. */
static vxs_result check_map_size(const char *light, uint32_t side, double texel, run_context *m)
{
    if (side && texel != 0)
        return fail(m, VXS_E_ARGUMENT, "light %s: resolution %u and texel_metres %g exclude each other", light, side, texel);
    if (side && (side < RESOLUTION_MIN_PX || side > RESOLUTION_MAX_PX || (side & (side - 1))))
        return fail(m, VXS_E_ARGUMENT, "light %s: resolution %u: expected a power of two from %d to %d", light, side,
                    RESOLUTION_MIN_PX, RESOLUTION_MAX_PX);
    if (texel != 0 && !(texel >= TEXEL_MIN_METRES && texel <= TEXEL_MAX_METRES))
        return fail(m, VXS_E_ARGUMENT, "light %s: texel_metres %g: expected %g to %g", light, texel, TEXEL_MIN_METRES,
                    TEXEL_MAX_METRES);
    return VXS_OK;
}

static vxs_result check_region(const vxs_bake_options *a, run_context *m)
{
    for (int axis = 0; axis < 3 && a->has_region; axis++) {
        double low = a->region_ws[axis], high = a->region_ws[axis + 3];
        if (!isfinite(low) || !isfinite(high) || !(low < high))
            return fail(m, VXS_E_ARGUMENT,
                        "region_ws: expected a minimum below the maximum, both finite, but it is %g and %g on axis %c", low, high,
                        "xyz"[axis]);
    }
    return VXS_OK;
}

/* lists ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result no_memory(run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory for options");
}

static vxs_result add_texts(text_list *list, const char *const *texts, size_t count, const char *name, run_context *m)
{
    if (count && !texts) return fail(m, VXS_E_ARGUMENT, "%s: %zu of them, and no array", name, count);
    for (size_t n = 0; n < count; n++) {
        if (!texts[n]) return fail(m, VXS_E_ARGUMENT, "%s: item %zu is no text", name, n);
        if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items)) return no_memory(m);
        list->items[list->count++] = texts[n];
    }
    return VXS_OK;
}

static vxs_result add_named(named_list *list, const char *name, const double *numbers, size_t count, run_context *m)
{
    named_value value = {.name = NULL};
    if (named_find(list, name)) return fail(m, VXS_E_ARGUMENT, "'%s' is given twice", name);
    if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items)) return no_memory(m);
    memcpy(value.numbers, numbers, count * sizeof *numbers);
    if (!(value.name = strdup(name))) return no_memory(m);
    list->items[list->count++] = value;
    return VXS_OK;
}

static vxs_result add_suns(asked_options *a, run_context *m)
{
    vxs_result r = VXS_OK;
    if (a->asked.sun_count && !a->asked.suns) return fail(m, VXS_E_ARGUMENT, "suns: %zu of them, and no array", a->asked.sun_count);
    for (size_t n = 0; n < a->asked.sun_count && r == VXS_OK; n++) {
        const vxs_bake_sun *sun  = &a->asked.suns[n];
        const char         *name = sun->name ? sun->name : SUN_NAME;
        const double       *way  = sun->direction_ws;
        if (!light_name_is_sound(name)) return fail(m, VXS_E_ARGUMENT, "sun %zu: expected a name of 1 to 63 bytes in UTF-8", n);
        if (!isfinite(way[0]) || !isfinite(way[1]) || !isfinite(way[2]) || (way[0] == 0 && way[1] == 0 && way[2] == 0))
            return fail(m, VXS_E_ARGUMENT, "sun '%s': expected a direction, finite and not zero", name);
        r = add_named(&a->o.suns, name, way, 3, m);
    }
    return r;
}

static vxs_result add_map_sizes(asked_options *a, run_context *m)
{
    const vxs_bake_options *asked = &a->asked;
    vxs_result              r     = check_map_size("of all", asked->resolution, asked->texel_metres, m);
    if (asked->map_size_count && !asked->map_sizes)
        return fail(m, VXS_E_ARGUMENT, "map_sizes: %zu of them, and no array", asked->map_size_count);
    for (size_t n = 0; n < asked->map_size_count && r == VXS_OK; n++) {
        const vxs_bake_map_size *size  = &asked->map_sizes[n];
        double                   texel = size->texel_metres, side = size->resolution;
        if (!size->light_name) return fail(m, VXS_E_ARGUMENT, "map_sizes: item %zu names no light", n);
        r = check_map_size(size->light_name, size->resolution, texel, m);
        if (r == VXS_OK && !size->resolution && texel == 0)
            r = fail(m, VXS_E_ARGUMENT, "light %s: expected a resolution or texel_metres", size->light_name);
        if (r == VXS_OK && named_find(size->resolution ? &a->o.texels : &a->o.resolutions, size->light_name))
            r = fail(m, VXS_E_ARGUMENT, "light %s: its map has two sizes", size->light_name);
        if (r == VXS_OK)
            r = add_named(size->resolution ? &a->o.resolutions : &a->o.texels, size->light_name, size->resolution ? &side : &texel,
                          1, m);
    }
    return r;
}

/* files ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result check_files(const vxs_bake_options *a, int lights, run_context *m)
{
    if ((a->scene_path != NULL) + (a->arrays != NULL) + (a->scene != NULL) != 1)
        return fail(m, VXS_E_ARGUMENT, "expected one of scene_path, arrays and scene");
    if (!lights && a->scene) return fail(m, VXS_E_ARGUMENT, "scene: it is open already");
    if (a->scene_path && (!a->scene_path[0] || !strcmp(a->scene_path, "-")))
        return fail(m, VXS_E_ARGUMENT, "scene_path '%s': expected the name of a file", a->scene_path);
    if (a->arrays && (a->exclude_count || a->include_count || a->scene_name))
        return fail(m, VXS_E_ARGUMENT, "exclude, include and scene_name choose from a file, and the scene is of arrays");
    if (a->files && (!a->files->size || !a->files->read))
        return fail(m, VXS_E_ARGUMENT, "files: expected the functions size and read");
    if (!lights) return VXS_OK;
    if (a->files && a->resume_path) return fail(m, VXS_E_ARGUMENT, "resume_path is a folder of the system, and files is given");
    if (a->files && a->output_path && !a->files->write)
        return fail(m, VXS_E_ARGUMENT, "files: expected the function write for output_path");
    if (a->files && a->output_path && a->scene_path && !strcmp(a->output_path, a->scene_path))
        return fail(m, VXS_E_ARGUMENT, "output_path '%s' is scene_path: expected another name", a->output_path);
    if (a->output_path && (!a->output_path[0] || !strcmp(a->output_path, "-")))
        return fail(m, VXS_E_ARGUMENT, "output_path '%s': expected the name of a file", a->output_path);
    if (a->if_changed && !a->output_path) return fail(m, VXS_E_ARGUMENT, "if_changed: expected an output_path");
    return VXS_OK;
}

/* ----------------------------------------------------------------------------------------------------------------------------- */

/* Convert to the command's options. Fields that are not set here have the command's defaults. */
static void translate(asked_options *a)
{
    static const closed_mode closed[] = {CLOSED_AUTO, CLOSED_ON, CLOSED_OFF};
    static const exit_mode   exits[]  = {EXIT_AUTO, EXIT_PEEL, EXIT_BACK};
    const vxs_bake_options  *asked    = &a->asked;
    bake_options            *o        = &a->o;
    o->scene_path                     = asked->scene_path ? asked->scene_path : "arrays";
    o->output_path                    = asked->output_path;
    o->scene.name                     = asked->scene_name;
    o->scene.skinned                  = asked->skinned == VXS_BAKE_SKINNED_REST ? SKINNED_REST : SKINNED_EXCLUDE;
    o->scene.skinned_given            = o->scene.skinned != SKINNED_EXCLUDE;
    o->scene.blend                    = (int)asked->blend; /* both enums have the same order */
    o->scene.blend_given              = o->scene.blend != BLEND_MASK;
    o->scene.allow_outside            = asked->allow_outside != 0;
    o->resolution   = asked->texel_metres != 0 ? 0 : asked->resolution ? asked->resolution : RESOLUTION_DEFAULT_PX;
    o->texel_metres = asked->texel_metres;
    o->region_given = asked->has_region != 0;
    memcpy(o->region_ws, asked->region_ws, sizeof o->region_ws);
    o->maps             = MAPS_SPARSE;
    o->closed           = closed[asked->closed];
    o->exit             = exits[asked->exit];
    o->behind           = asked->behind_free ? BEHIND_FREE : BEHIND_SHADOW;
    o->thickness_metres = asked->thickness_metres;
    o->coding           = asked->coding == VXS_BAKE_DAG ? CODING_DAG : CODING_BLOCKS;
    o->pack             = asked->pack == VXS_BAKE_PACK_FAST ? PACK_FAST : PACK_SMALL;
    o->reuse            = 1;
    o->stop             = STOP_FINAL;
    o->threads          = asked->threads ? asked->threads : parallel_default_threads();
    o->zstd_level       = asked->zstd_level ? asked->zstd_level : ZSTD_DEFAULT;
    o->memory_bytes     = asked->memory_bytes;
    o->resume_path      = asked->resume_path;
    o->if_changed       = asked->if_changed != 0;
}

vxs_result asked_options_init(asked_options *a, const vxs_bake_options *options, int lights, run_context *m)
{
    *a           = (asked_options){0};
    vxs_result r = take_known(&a->asked, options, m);
    if (r == VXS_OK) {
        r = check_choice("closed", a->asked.closed, VXS_BAKE_CLOSED_OFF, m);
        if (r == VXS_OK) r = check_choice("skinned", a->asked.skinned, VXS_BAKE_SKINNED_REST, m);
        if (r == VXS_OK) r = check_choice("blend", a->asked.blend, VXS_BAKE_BLEND_EXCLUDE, m);
        if (r == VXS_OK) r = check_choice("exit", a->asked.exit, VXS_BAKE_EXIT_BACK, m);
        if (r == VXS_OK) r = check_choice("coding", a->asked.coding, VXS_BAKE_DAG, m);
        if (r == VXS_OK) r = check_choice("pack", a->asked.pack, VXS_BAKE_PACK_FAST, m);
        if (r == VXS_OK) r = check_choice("zstd_level", a->asked.zstd_level, ZSTD_MAX, m);
        if (r == VXS_OK) r = check_choice("threads", a->asked.threads, PARALLEL_THREADS_MAX, m);
        if (r == VXS_OK && a->asked.thickness_metres != 0 &&
            !(a->asked.thickness_metres >= TEXEL_MIN_METRES && a->asked.thickness_metres <= TEXEL_MAX_METRES))
            r = fail(m, VXS_E_ARGUMENT, "thickness_metres %g: expected %g to %g", a->asked.thickness_metres, TEXEL_MIN_METRES,
                     TEXEL_MAX_METRES);
        if (r == VXS_OK && a->asked.coding == VXS_BAKE_DAG && a->asked.pack != VXS_BAKE_PACK_SMALL)
            r = fail(m, VXS_E_ARGUMENT, "pack is of the pages of palette blocks, and coding is VXS_BAKE_DAG");
    }
    if (r == VXS_OK) r = check_files(&a->asked, lights, m);
    if (r == VXS_OK && lights) r = check_region(&a->asked, m);
    if (r != VXS_OK) return r;
    translate(a);

    const vxs_bake_options *asked = &a->asked;
    r                             = add_texts(&a->o.scene.exclude, asked->exclude, asked->exclude_count, "exclude", m);
    if (r == VXS_OK) r = add_texts(&a->o.scene.include, asked->include, asked->include_count, "include", m);
    if (r != VXS_OK || !lights) return r;
    r = add_texts(&a->o.light_names, asked->light_names, asked->light_name_count, "light_names", m);
    if (r == VXS_OK) r = add_suns(a, m);
    return r == VXS_OK ? add_map_sizes(a, m) : r;
}

void asked_options_free(asked_options *a)
{
    free(a->o.scene.exclude.items);
    free(a->o.scene.include.items);
    free(a->o.light_names.items);
    named_list_free(&a->o.suns);
    named_list_free(&a->o.resolutions);
    named_list_free(&a->o.texels);
    *a = (asked_options){0};
}
