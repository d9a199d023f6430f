/* A self-contained page; see page.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/pages/page.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/embedded.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"

EMBEDDED(page_html)
EMBEDDED(page_js)
EMBEDDED(bake_page_js)
EMBEDDED(bench_page_js)
EMBEDDED(volumes_page_js)
EMBEDDED(charts_js)
EMBEDDED(chart_min_js)

/* The text after a mark in it. This skips the comments at the head of templates, which are for developers. */
static embedded behind(embedded text, const char *mark)
{
    const char *at = memmem(text.begin, (size_t)(text.end - text.begin), mark, strlen(mark));
    return (embedded){at + strlen(mark), text.end};
}

/* Print JSON so that it cannot end the script element: '<' occurs only in strings, and is escaped there. */
static void print_json(FILE *to, const char *json)
{
    for (size_t n; n = strcspn(json, "<"), fwrite(json, 1, n, to), json[n]; json += n + 1) fputs("\\u003c", to);
}

vxs_result page_write(const char *path, page_kind kind, json_t *data, message *m)
{
    char       *json = data ? json_print(data, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    output_file out  = {0};
    vxs_result  r    = VXS_OK;
    if (!json) {
        r = fail(m, VXS_E_MEMORY, "out of memory for the page %s", path);
        goto done;
    }
    if ((r = output_file_open(&out, path, m)) != VXS_OK) goto done;

    FILE    *to     = out.stream;
    embedded script = kind == PAGE_BAKE ? bake_page_js : kind == PAGE_BENCH ? bench_page_js : volumes_page_js;
    embedded_print(to, behind(page_html, "-->\n"));
    print_json(to, json);
    fputs("</script>\n<script>", to);
    if (kind != PAGE_BAKE) embedded_print(to, chart_min_js);
    fputs("</script>\n<script>", to);
    embedded_print(to, behind(page_js, "*/\n"));
    if (kind != PAGE_BAKE) embedded_print(to, behind(charts_js, "*/\n"));
    embedded_print(to, behind(script, "*/\n"));
    fputs("</script>\n</body>\n</html>\n", to);

    r = output_file_commit(&out, m);
done:
    output_file_abort(&out);
    free(json);
    json_decref(data);
    return r;
}
