/* vxs export: the contents of a .vxs file for engines that do not link the runtime: words, constants, depth maps, matrices.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/base/parallel.h"
#include "baker/base/version.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/export_depth.h"
#include "baker/command/light_text.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"

#define EXPORT_NAMES "shadows.json|words.bin|lights.bin|depth-*.png|depth-*.f32"

typedef struct export_command {
    const char  *path, *folder;
    text_list    light_names;
    export_axes  axes;
    export_depth depth; /* resolution_px 0: no depth maps */
    uint64_t     memory_bytes;

    vxs_asset             *asset;
    const vxs_baked_light *lights[VXS_LIGHTS_MAX]; /* [light_count] */
    uint32_t               first_word[VXS_LIGHTS_MAX], light_count, word_count;
} export_command;

/* Lights share one array of words, as in shaders. Returns VXS_OK or VXS_E_UNSUPPORTED. */
static vxs_result place_words(export_command *c, run_context *m)
{
    uint64_t next = 0;
    for (uint32_t n = 0; n < c->light_count; n++) {
        c->first_word[n] = (uint32_t)next;
        next += c->lights[n]->word_count;
        if (next > UINT32_MAX - VXS_BLOCKS_SPARE_WORDS)
            return fail(m, VXS_E_UNSUPPORTED, "'%s' has more than 2^32 words: choose lights with --light", c->path);
    }
    c->word_count = (uint32_t)next + VXS_BLOCKS_SPARE_WORDS;
    return VXS_OK;
}

static vxs_result write_words(const export_command *c, run_context *m)
{
    static const uint32_t spare[VXS_BLOCKS_SPARE_WORDS];
    output_file           out = {0};
    vxs_result            r   = output_file_open_in_folder(&out, "-o", c->folder, "words.bin", m);
    for (uint32_t n = 0; n < c->light_count && r == VXS_OK; n++)
        r = output_file_write(&out, c->lights[n]->words, 4 * (size_t)c->lights[n]->word_count, m);
    if (r == VXS_OK) r = output_file_write(&out, spare, sizeof spare, m);
    if (r == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    return r;
}

static vxs_result write_constants(const export_command *c, run_context *m)
{
    output_file out = {0};
    vxs_result  r   = output_file_open_in_folder(&out, "-o", c->folder, "lights.bin", m);
    for (uint32_t n = 0; n < c->light_count && r == VXS_OK; n++) {
        vxs_light light = c->lights[n]->light;
        export_turn(light.ls_from_ws, 3, c->axes);
        vxs_light_constants constants = vxs_light_constants_of(&light, NULL, c->first_word[n]);
        r                             = output_file_write(&out, &constants, sizeof constants, m);
    }
    if (r == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    return r;
}

/* The description of a light. Writes its depth maps.   entry  [out] NULL without memory */
static vxs_result light_entry(json_t **entry, const export_command *c, uint32_t n, run_context *m)
{
    const vxs_light *l = &c->lights[n]->light;
    double           matrix[12];
    memcpy(matrix, l->ls_from_ws, sizeof matrix);
    export_turn(matrix, 3, c->axes);
    *entry = light_json(l);
    json_set(entry, "ls_from_ws", export_numbers(matrix, 12));
    json_set(entry, "first_word", json_integer((json_int_t)c->first_word[n]));
    json_set(entry, "word_count", json_integer((json_int_t)c->lights[n]->word_count));
    json_set(entry, "constants_offset_bytes", json_integer((json_int_t)(n * sizeof(vxs_light_constants))));
    if (!c->depth.resolution_px) return VXS_OK;

    json_t    *maps = json_array();
    vxs_result r    = VXS_OK;
    for (int map = 0; map < (int)vxs_map_count(l) && r == VXS_OK; map++) {
        json_t *one = NULL;
        r           = export_depth_map(&one, c->folder, c->lights[n], n, map, &c->depth, c->axes, m);
        json_append(&maps, one);
    }
    json_set(entry, "depth_maps", maps);
    return r;
}

static vxs_result write_json(const export_command *c, run_context *m)
{
    char       axes[32];
    json_t    *root = json_object(), *lights = json_array();
    vxs_result r = VXS_OK;
    json_set(&root, "vxs", json_string(VXS_VERSION));
    json_set(&root, "file", json_text(c->path));
    json_set(&root, "axes", json_string(choice_word(axes, EXPORT_AXES_CHOICES, (int)c->axes)));
    json_set(&root, "unit_m", json_real(c->axes == EXPORT_UNREAL ? 0.01 : 1));
    json_set(&root, "words", json_string("words.bin"));
    json_set(&root, "word_count", json_integer((json_int_t)c->word_count));
    json_set(&root, "constants", json_string("lights.bin"));
    for (uint32_t n = 0; n < c->light_count && r == VXS_OK; n++) {
        json_t *entry = NULL;
        r             = light_entry(&entry, c, n, m);
        json_append(&lights, entry);
    }
    json_set(&root, "lights", lights);
    output_file out = {0};
    if (r == VXS_OK) r = output_file_open_in_folder(&out, "-o", c->folder, "shadows.json", m);
    if (r == VXS_OK) return json_write_opened(&out, root, 17, m);
    json_decref(root);
    return r;
}

static vxs_result write_all(export_command *c, run_context *m)
{
    vxs_result r = asset_choose_lights(vxs_asset_contents(c->asset), c->path, &c->light_names, c->lights, &c->light_count, m);
    if (r == VXS_OK) r = place_words(c, m);
    if (r == VXS_OK && mkdir(c->folder, 0777) && errno != EEXIST)
        r = fail(m, VXS_E_WRITE, "-o %s: the folder cannot be made (%s)", c->folder, strerror(errno));
    if (r == VXS_OK) r = write_words(c, m);
    if (r == VXS_OK) r = write_constants(c, m);
    return r == VXS_OK ? write_json(c, m) : r;
}

static vxs_result run(void *command, run_context *m)
{
    export_command *c = command;
    if (!c->folder) return fail(m, VXS_E_ARGUMENT, "export needs -o FOLDER");
    if (c->depth.resolution_px & (c->depth.resolution_px - 1))
        return fail(m, VXS_E_ARGUMENT, "--depth %u: expected a power of two", c->depth.resolution_px);
    vxs_result r = asset_open(&c->asset, c->path, c->memory_bytes, 0, parallel_default_threads(), m);
    if (r == VXS_OK) r = write_all(c, m);
    FILE *to = r == VXS_OK ? report_stream(m, 0) : NULL;
    char  size[32], plain[PLAIN_BYTES];
    if (to)
        fprintf(to, "%s: %u light%s, %s of words\n", plain_text(plain, c->folder), c->light_count, c->light_count == 1 ? "" : "s",
                size_text(size, 4 * (uint64_t)c->word_count));
    vxs_asset_close(c->asset);
    return r;
}

int cmd_export(int argc, char **argv)
{
    export_command c         = {0};
    const option   options[] = {
          {"FILE.vxs", OPTION_INPUT, &c.path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
          {"-o", OPTION_FOLDER, &c.folder, 0, 0, EXPORT_NAMES, "FOLDER",
           "where shadows.json, words.bin, lights.bin and depth maps go; made if it is missing", NULL},
          {"--light", OPTION_TEXTS, &c.light_names, 0, 0, NULL, "NAME",
           "export this light, or all that a pattern names, as lamp*; repeat for more (default all lights)", NULL},
          {"--axes", OPTION_CHOICE, &c.axes, 0, 0, EXPORT_AXES_CHOICES, NULL,
           "world space of matrices and constants: metres, +Y up, as glTF and Godot; Unity's; Unreal's centimetres, +Z up (default "
             "gltf)",
           NULL},
          {"--depth", OPTION_U32, &c.depth.resolution_px, 8, 1 << VXS_LEVELS_MAX, NULL, "N",
           "also depth maps of N texels a side, a power of two, or of the light's own resolution where that is less", NULL},
          {"--format", OPTION_CHOICE, &c.depth.format, 0, 0, EXPORT_FORMAT_CHOICES, NULL,
           "depth maps as PNG of 16 bits, or as 32-bit floats without a head (default png)", NULL},
          {"--memory", OPTION_BYTES, &c.memory_bytes, 0, 0, NULL, "BYTES",
           "hold no more memory for the file than this: 800M, 2G, or plain bytes (default 256 times its size)", NULL},
    };
    command_line line =
        COMMAND_LINE("export", "FILE.vxs -o FOLDER [options]", "Write words, constants and depth maps for other engines.", options);
    return command_run(&line, argc, argv, run, &c);
}
