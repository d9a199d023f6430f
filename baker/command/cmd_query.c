/* vxs query: how lit is each point, by lookups in a .vxs file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/command/asset_open.h"
#include "baker/options/filter_choice.h"
#include "baker/options/options.h"
#include "baker/command/points.h"

enum { BLOCK_POINTS = 65536 };

typedef struct query_options {
    text_list light_names;
    uint32_t  filter_px;
} query_options;

/* "0", "1", "0.703704", or "out" where the light's volume does not reach. */
static int print_answer(float lit, char end)
{
    if (lit < 0) return printf("out%c", end);
    if (lit == 0 || lit == 1) return printf("%c%c", lit == 0 ? '0' : '1', end);
    return printf("%.6g%c", (double)lit, end);
}

static vxs_result answer_points(const query_options *o, const vxs_baked_light *const *lights, uint32_t light_count, message *m)
{
    query_point *points = malloc(BLOCK_POINTS * sizeof *points);
    point_reader reader = {0};
    size_t       count  = 0;
    vxs_result   r =
        points ? point_reader_init(&reader, stdin, "standard input", m) : fail(m, VXS_E_MEMORY, "out of memory for points");
    while (r == VXS_OK) {
        r = points_read(&reader, points, BLOCK_POINTS, &count, m);
        for (size_t n = 0; n < count && r == VXS_OK; n++)
            for (uint32_t l = 0; l < light_count; l++) {
                const double *normal = points[n].has_normal ? points[n].normal_ws : NULL;
                float         lit    = vxs_lookup(lights[l], points[n].position_ws, normal, (int)o->filter_px);
                if (print_answer(lit, l + 1 < light_count ? ' ' : '\n') < 0) break;
            }
        if (fflush(stdout) || ferror(stdout)) r = fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
        if (!count) break;
    }
    point_reader_free(&reader);
    free(points);
    return r;
}

int cmd_query(int argc, char **argv)
{
    query_options o         = {.filter_px = 1};
    const char   *path      = NULL;
    const option  options[] = {
         {"--light", OPTION_TEXTS, &o.light_names, 0, 0, NULL, "NAME",
          "answer for this light; repeat for more (default: all, in file order)", NULL},
         {"--filter", OPTION_U32, &o.filter_px, 1, VXS_FILTER_MAX, NULL, "K",
          "K x K box filter, K odd, 1 to 17 texels (default 1, a single tap)", NULL},
    };
    const command_line line  = {"query",
                                "FILE.vxs [options] < points",
                                "For each line 'x y z' or 'x y z nx ny nz' of standard input (world space, metres), print "
                                 "the lit fraction, 0 to 1,\n"
                                 "one column a light; 'out' outside a light's volume.",
                                options,
                                sizeof options / sizeof *options,
                                1};
    message            m     = {0};
    vxs_asset         *asset = NULL;
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &path, &help_shown, &m);
    if (r == VXS_OK && !help_shown) {
        r = filter_check(o.filter_px, &m);
        if (r == VXS_OK) r = asset_open(&asset, path, &m);
        const vxs_baked_light *lights[VXS_LIGHTS_MAX];
        uint32_t               count = 0;
        if (r == VXS_OK) r = asset_choose_lights(asset, &o.light_names, lights, &count, &m);
        if (r == VXS_OK) r = answer_points(&o, lights, count, &m);
    }
    vxs_asset_close(asset);
    free(o.light_names.items);
    return command_end(&m, r);
}
