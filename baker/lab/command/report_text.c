/* Lines of reports; see report_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/report_text.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/base/text.h"
#include "baker/files/json_file.h"
#include "baker/files/run_files.h"

void written_print(FILE *to, const char *path, const char *what)
{
    struct stat status;
    char        size[32], plain[PLAIN_BYTES];
    if (!path) return;
    fprintf(to, "wrote        %s: %s", is_standard_output(path) ? "standard output" : plain_text(plain, path), what);
    if (!is_standard_output(path) && !stat(path, &status) && S_ISREG(status.st_mode))
        fprintf(to, ", %s", size_text(size, (uint64_t)status.st_size));
    fputc('\n', to);
}

enum { NAME_BYTES = 60 };

/* "node 3 'lamp'", "mesh 2" */
static size_t append(char *text, size_t used, const char *kind, uint32_t number, const char *name)
{
    char shown[NAME_BYTES + 1];
    used += (size_t)snprintf(text + used, PART_TEXT_BYTES - used, "%s%s %u", used ? ", " : "", kind, number);
    if (*name) used += (size_t)snprintf(text + used, PART_TEXT_BYTES - used, " '%s'", shorten(shown, NAME_BYTES, name));
    return used;
}

const char *part_text(char *text, const scene *s, const part_span *span)
{
    const scene_part *p    = &s->parts[span->first];
    size_t            used = append(text, 0, "node", p->node, s->names + p->node_name);
    used                   = append(text, used, "mesh", p->mesh, s->names + p->mesh_name);
    if (p->material != SCENE_NO_MATERIAL) used = append(text, used, "material", p->material, s->names + p->material_name);
    if (span->count > 1) snprintf(text + used, PART_TEXT_BYTES - used, " and %u more", span->count - 1);
    return one_line(text);
}

static json_t *name_json(const scene *s, uint32_t at)
{
    return at ? json_text(s->names + at) : json_null();
}

json_t *part_json(const scene *s, const part_span *span)
{
    const scene_part *p = &s->parts[span->first];
    return json_pack("{s:I, s:o, s:I, s:o, s:o, s:o, s:I}", "node", (json_int_t)p->node, "node_name", name_json(s, p->node_name),
                     "mesh", (json_int_t)p->mesh, "mesh_name", name_json(s, p->mesh_name), "material",
                     p->material == SCENE_NO_MATERIAL ? json_null() : json_integer(p->material), "material_name",
                     name_json(s, p->material_name), "parts", (json_int_t)span->count);
}
