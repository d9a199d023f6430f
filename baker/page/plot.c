/* Plots by gnuplot; see plot.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/plot.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "baker/files/output_file.h"
#include "baker/base/text.h"
#include "baker/page/html.h"

extern char **environ;

/* gnuplot --------------------------------------------------------------------------------------------------------------------- */

/* A file in memory that a child may take for its standard input or output. */
static int memory_file(const char *name, message *m)
{
    int descriptor = memfd_create(name, MFD_CLOEXEC);
    if (descriptor < 0) fail(m, VXS_E_MEMORY, "no file in memory for %s: %s", name, strerror(errno));
    return descriptor;
}

static int write_all(int to, const char *bytes, size_t size)
{
    while (size) {
        ssize_t n = write(to, bytes, size);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return 0;
        bytes += n;
        size -= (size_t)n;
    }
    return 1;
}

/* All bytes of a file in memory, with a NUL behind them; released with free(). NULL without memory. */
static char *read_all(int from, size_t *size)
{
    off_t end  = lseek(from, 0, SEEK_END);
    char *text = end < 0 ? NULL : malloc((size_t)end + 1);
    *size      = 0;
    while (text && *size < (size_t)end) {
        ssize_t n = pread(from, text + *size, (size_t)end - *size, (off_t)*size);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        *size += (size_t)n;
    }
    if (text) text[*size] = 0;
    return text;
}

/* Without the user's settings (-d), so that the same figures give the same plots. Returns the wait status, or -1 when none ran. */
static int run_gnuplot(int in, int out, int errors)
{
    static char                program[] = "gnuplot", defaults[] = "-d";
    char *const                arguments[] = {program, defaults, NULL};
    posix_spawn_file_actions_t actions;
    pid_t                      child;
    int                        status = -1;
    if ((errno = posix_spawn_file_actions_init(&actions))) return -1;
    if (!(errno = posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO)) &&
        !(errno = posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO)) &&
        !(errno = posix_spawn_file_actions_adddup2(&actions, errors, STDERR_FILENO)) &&
        !(errno = posix_spawnp(&child, program, &actions, NULL, arguments, environ)))
        while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    int error = errno;
    posix_spawn_file_actions_destroy(&actions);
    errno = error;
    return status;
}

/* What gnuplot said last before it gave up. */
static vxs_result gnuplot_failed(const plot *p, int status, int errors, message *m)
{
    size_t size;
    char  *said = read_all(errors, &size);
    while (said && size && strchr(" \n^", said[size - 1])) said[--size] = 0;
    const char *line = said ? strrchr(said, '\n') : NULL;
    vxs_result  r    = fail(m, VXS_E_PROGRAM, "gnuplot failed at plot %s with status %d: %s", p->name, status,
                        line   ? line + 1
                            : said ? said
                                   : "");
    free(said);
    return r;
}

/* Run the script behind a head that names the terminal.
 * out  [out] what it drew; released with free() */
static vxs_result draw(const plot *p, const char *head, char **out, size_t *out_bytes, message *m)
{
    int in = memory_file("a plot", m), to = memory_file("a plot", m), errors = memory_file("a plot", m), status = -1;
    *out         = NULL;
    vxs_result r = in < 0 || to < 0 || errors < 0 ? VXS_E_MEMORY : VXS_OK;
    if (r == VXS_OK && (!write_all(in, head, strlen(head)) || !write_all(in, p->script, p->script_bytes) || lseek(in, 0, SEEK_SET)))
        r = fail(m, VXS_E_MEMORY, "out of memory for plot %s", p->name);
    if (r == VXS_OK && (status = run_gnuplot(in, to, errors)) == -1) {
        if (errno == ENOENT)
            r = fail(m, VXS_E_PROGRAM, "there is no gnuplot, which draws the plots: expected one on PATH (Debian: gnuplot-nox)");
        else
            r = fail(m, VXS_E_PROGRAM, "gnuplot cannot be run: %s", strerror(errno));
    }
    if (r == VXS_OK && status) r = gnuplot_failed(p, status, errors, m);
    if (r == VXS_OK && (!(*out = read_all(to, out_bytes)) || !*out_bytes))
        r = fail(m, VXS_E_MEMORY, "out of memory for plot %s", p->name);
    if (in >= 0) close(in);
    if (to >= 0) close(to);
    if (errors >= 0) close(errors);
    return r;
}

/* scripts --------------------------------------------------------------------------------------------------------------------- */

FILE *plot_begin(plot *p, const char *name, uint32_t width, uint32_t height)
{
    *p = (plot){.width = width, .height = height};
    snprintf(p->name, sizeof p->name, "%s", name);
    p->to = open_memstream(&p->script, &p->script_bytes);
    if (!p->to) return NULL;
    fputs("set encoding utf8\n"
          "set border 3 lw 0.8 lc rgb '" PLOT_SOFT "'\n"
          "set tics nomirror out scale 0.5 textcolor rgb '" PLOT_INK "'\n"
          "set grid lt 1 lw 0.6 lc rgb '" PLOT_RULE "'\n"
          "set style fill solid 1 noborder\n"
          "set key noautotitle bmargin left Left reverse horizontal samplen 1.6 textcolor rgb '" PLOT_INK "'\n"
          "set lmargin 11\nset rmargin 2\n",
          p->to);
    return p->to;
}

uint32_t plot_bottom(FILE *to, size_t key_rows)
{
    double lines = 3.7 + 1.04 * (double)key_rows;
    fprintf(to, "set bmargin %.2f\n", lines);
    return (uint32_t)(lines * 1.5 * 13);
}

vxs_result plot_end(plot *p, message *m)
{
    char head[128];
    int  failed = !p->to || ferror(p->to);
    if (p->to && fclose(p->to)) failed = 1;
    p->to = NULL;
    if (failed) return fail(m, VXS_E_MEMORY, "out of memory for plot %s", p->name);
    snprintf(head, sizeof head, "set terminal svg size %u,%u dynamic noenhanced font 'sans-serif,13'\nset tmargin 0.7\n", p->width,
             p->height);
    return draw(p, head, &p->svg, &p->svg_bytes, m);
}

void plot_free(plot *p)
{
    if (p->to) fclose(p->to);
    free(p->script);
    free(p->svg);
    *p = (plot){0};
}

static void print_quoted(FILE *to, const char *text, size_t most, int is_format)
{
    char *clean = strdup(text);
    if (!clean) return; /* no text at all makes the script wrong, and gnuplot says so */
    size_t count = 0;
    fputc('\'', to);
    for (const char *c = clean_text(clean); *c; c++) {
        if (((unsigned char)*c & 0xc0) != 0x80 && count++ == most) {
            fputs("…", to);
            break;
        }
        if (*c == '%' && is_format) fputc('%', to);
        if (*c == '\'')
            fputs("’", to); /* gnuplot reads a doubled quote as one, but not at the start of a text */
        else if ((*c == '#' && c > clean && c[-1] == '&') || (*c == '>' && c > clean + 1 && c[-1] == ']' && c[-2] == ']'))
            fputc('?', to); /* gnuplot leaves "&#x..;", which would mean a character, and "]]>", which XML forbids, as they are */
        else
            fputc(*c, to);
    }
    fputc('\'', to);
    free(clean);
}

void plot_text(FILE *to, const char *text, size_t most)
{
    print_quoted(to, text, most, 0);
}

void plot_tic(FILE *to, const char *text, size_t most, double at)
{
    print_quoted(to, text, most, 1);
    fprintf(to, " %.9g", at);
}

/* drawings -------------------------------------------------------------------------------------------------------------------- */

/* What a page changes in a drawing: fixed colours become those of the page, and names that are the same in all drawings get a number.
 * Other colours are series. */
static const struct {
    const char *from, *to; /* %u: number of the plot */
} changes[] = {
    {"'rgb( 34,  34,  31)'", "'var(--ink)'"},
    {"\"rgb( 34,  34,  31)\"", "\"var(--ink)\""},
    {"'rgb(102, 100,  93)'", "'var(--soft)'"},
    {"\"rgb(102, 100,  93)\"", "\"var(--soft)\""},
    {"'rgb(220, 217, 207)'", "'var(--rule)'"},
    {"\"rgb(220, 217, 207)\"", "\"var(--rule)\""},
    {"\"rgb(34,34,31)\"", "\"var(--ink)\""},
    {"\"rgb(102,100,93)\"", "\"var(--soft)\""},
    {"<title>Gnuplot</title>\n", ""},
    {"\"black\"", "\"var(--ink)\""},
    {"'black'", "'var(--ink)'"},
    {"'gpDot'", "'p%ugpDot'"},
    {"'gpPt", "'p%ugpPt"},
    {"'#gpDot'", "'#p%ugpDot'"},
    {"'#gpPt", "'#p%ugpPt"},
    {"\"gnuplot_", "\"p%ugnuplot_"},
    {"id='textbox'", "id='p%utextbox'"},
    {"id='greybox'", "id='p%ugreybox'"},
};

void plot_print_inline(const plot *p, FILE *to, unsigned number)
{
    const char *from = strstr(p->svg, "<svg");
    fprintf(to, "<svg role=\"img\" aria-label=\"");
    html_text(to, p->title);
    fputc('"', to);
    for (const char *c = from ? from + 4 : p->svg; *c;) {
        size_t n = 0;
        while (n < sizeof changes / sizeof *changes && strncmp(c, changes[n].from, strlen(changes[n].from))) n++;
        if (n == sizeof changes / sizeof *changes) {
            fputc(*c++, to);
            continue;
        }
        const char *at = strstr(changes[n].to, "%u");
        if (at)
            fprintf(to, "%.*s%u%s", (int)(at - changes[n].to), changes[n].to, number, at + 2);
        else
            fputs(changes[n].to, to);
        c += strlen(changes[n].from);
    }
}

/* The title in as many lines as it needs, above the plot. Returns how many. */
static unsigned print_title(FILE *to, const plot *p)
{
    char     title[sizeof p->title];
    size_t   width = p->width / 8;
    unsigned lines = 0;
    strcpy(title, p->title);
    for (char *line = title; line && *line; lines++) {
        char *end = NULL;
        if (strlen(line) > width) {
            for (end = line + width; end > line && *end != ' ';) end--;
            if (end == line) end = strchr(line, ' ');
            if (end) *end++ = 0;
        }
        fprintf(to, "set label %u ", 100 + lines);
        plot_text(to, line, 200);
        fprintf(to,
                " at screen 0, screen 1 offset character 1, character -%.1f left front font ',14' textcolor rgb '" PLOT_INK "'\n",
                1.0 + 1.25 * lines);
        line = end;
    }
    fprintf(to, "set tmargin %.1f\n", 1.3 + 1.3 * lines);
    return lines;
}

static vxs_result write_drawing(const plot *p, const char *folder, const char *suffix, const char *terminal, message *m)
{
    char       *path = NULL, *head = NULL, *bytes = NULL;
    size_t      head_bytes, size;
    output_file out = {0};
    vxs_result  r   = VXS_E_MEMORY;
    FILE       *to  = open_memstream(&head, &head_bytes);
    if (to) fprintf(to, "%s", terminal);
    if (to) print_title(to, p);
    if (!to || fclose(to) || asprintf(&path, "%s/%s.%s", folder, p->name, suffix) < 0) {
        path = NULL;
        fail(m, r, "out of memory for plot %s", p->name);
        goto done;
    }
    if ((r = draw(p, head, &bytes, &size, m)) != VXS_OK) goto done;
    if ((r = output_file_open(&out, path, m)) != VXS_OK) goto done;
    if ((r = output_file_write(&out, bytes, size, m)) != VXS_OK) goto done;
    r = output_file_commit(&out, m);
done:
    output_file_abort(&out);
    free(bytes);
    free(head);
    free(path);
    return r;
}

vxs_result plot_write(const plot *p, const char *folder, message *m)
{
    char     terminal[160];
    unsigned title = 50; /* room above */
    snprintf(terminal, sizeof terminal, "set terminal svg size %u,%u noenhanced font 'sans-serif,13' background rgb 'white'\n",
             p->width, p->height + title);
    vxs_result r = write_drawing(p, folder, "svg", terminal, m);
    snprintf(terminal, sizeof terminal,
             "set terminal pngcairo size %u,%u noenhanced font 'sans,13' fontscale 1.5 linewidth 2 "
             "pointscale 2 background rgb 'white'\n",
             2 * p->width, 2 * (p->height + title));
    return r == VXS_OK ? write_drawing(p, folder, "png", terminal, m) : r;
}

/* series ---------------------------------------------------------------------------------------------------------------------- */

const char *plot_colour(uint32_t scene)
{
    /* of middle lightness: seen on white and on black paper */
    static const char *const colours[] = {"#3d7ab8", "#d0702a", "#3c9260", "#a9549c", "#c2485a", "#2f979c", "#94742f", "#7b7f8c"};
    return colours[scene % (sizeof colours / sizeof *colours)];
}

int plot_mark(uint32_t setting)
{
    static const int marks[] = {7, 5, 9, 11, 13, 15, 6, 4, 8, 10, 12, 14};
    return marks[setting % (sizeof marks / sizeof *marks)];
}

int plot_dash(uint32_t file)
{
    return (int)(file % 5) + 1;
}
