/* Opening a .vxs file; see asset_open.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/asset_open.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

typedef struct first_finding {
    int         number, section;
    uint64_t    offset;
    const char *text;
} first_finding;

static void keep_first(void *user, int number, const char *text, int section, uint64_t offset)
{
    first_finding *f = user;
    if (!f->number) *f = (first_finding){number, section, offset, text};
}

vxs_result asset_open(vxs_asset **asset, const char *path, message *m)
{
    first_finding f    = {0};
    vxs_read_desc desc = {.finding = keep_first, .finding_user = &f};
    errno              = 0;
    vxs_result r       = vxs_asset_open_file(asset, path, &desc);
    if (r == VXS_OK) return r;
    if (r == VXS_E_READ) return fail(m, r, "cannot read '%s': %s", path, strerror(errno ? errno : EIO));
    if (!f.number) return fail(m, r, "cannot read '%s': %s", path, vxs_result_text(r));
    char where[32] = "the header";
    if (f.section >= 0) snprintf(where, sizeof where, "section %d", f.section);
    const char *judgement = r == VXS_E_MEMORY ? "cannot be opened" : "is not a valid .vxs file";
    return fail(m, r, "'%s' %s: %s (finding %d at byte %llu, in %s)", path, judgement, f.text, f.number,
                (unsigned long long)f.offset, where);
}

uint64_t asset_file_bytes(const vxs_asset *asset)
{
    const vxs_contents *c    = vxs_asset_contents(asset);
    const vxs_section  *last = &c->sections[c->section_count - 1];
    return last->offset_bytes + last->stored_bytes;
}

vxs_result asset_choose_lights(const vxs_asset *asset, const text_list *names, const vxs_baked_light **lights, uint32_t *count,
                               message *m)
{
    *count = 0;
    if (!names->count)
        for (uint32_t n = 0; n < vxs_asset_light_count(asset); n++) lights[(*count)++] = vxs_asset_light(asset, n);
    for (size_t n = 0; n < names->count; n++) {
        const vxs_baked_light *light = vxs_asset_find_light(asset, names->items[n]);
        if (!light)
            return fail(m, VXS_E_ARGUMENT, "--light %s: the file has no light of that name (the first is %s)", names->items[n],
                        vxs_asset_light(asset, 0)->light.name);
        for (uint32_t before = 0; before < *count; before++)
            if (lights[before] == light) return fail(m, VXS_E_ARGUMENT, "--light %s is given twice", names->items[n]);
        lights[(*count)++] = light;
    }
    return VXS_OK;
}
