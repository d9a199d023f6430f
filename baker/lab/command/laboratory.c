/* The laboratory; see laboratory.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/laboratory.h"

#include "baker/lab/command/lab_commands.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/lab/pages/page.h"

static const command_entry commands[] = {
    {"truth", cmd_truth},   {"compare", cmd_compare}, {"bench", cmd_bench}, {"report", cmd_report}, {"render", cmd_render},
    {"health", cmd_health}, {"mend", cmd_mend},       {"scene", cmd_scene}, {NULL, NULL},
};

static const bake_pages pages = {bake_page_look, bake_page_write, bake_page_free};

const laboratory linked_laboratory = {.commands = commands, .renderer = &opengl_renderer, .pages = &pages};
