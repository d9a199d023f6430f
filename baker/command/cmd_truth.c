/* vxs truth: how lit is each point, by ray tracing.
 *
 * Points come from standard input in blocks. All threads trace a block, each point's answers have their place, and one pass over
 * them writes the lines:
 *
 *     answers   | 1 0 - | 0 0 1 | ...     one a light
 *     text      1 0 out\n0 0 1\n...
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/options/options.h"
#include "baker/command/points.h"
#include "baker/casters/casters.h"
#include "baker/scene/light_choice.h"
#include "baker/scene/scene.h"
#include "baker/truth/truth.h"

#define BLOCK_POINTS     65536
#define BLOCK_TEXT_MAX   ((size_t)1 << 24) /* bytes; with many lights a block has fewer points */
#define ANSWER_TEXT_MAX  4                 /* "out " */
#define POINTS_AT_A_TIME 256

typedef struct truth_options {
    const char *scene_path;
    const char *scene_name;
    text_list   light_names;
    int         sun_given;
    double      sun[3];
    uint32_t    threads;
} truth_options;

typedef enum answer { ANSWER_SHADOW, ANSWER_LIT, ANSWER_OUT } answer;

typedef struct block {
    const truth        *truth;
    const light_choice *lights;
    query_point        *points;  /* [capacity] */
    uint8_t            *answers; /* [capacity * lights->count] */
    char               *text;    /* [capacity * lights->count * ANSWER_TEXT_MAX] */
    size_t              capacity;
} block;

static vxs_result block_init(block *b, const truth *t, const light_choice *lights, message *m)
{
    size_t line_size = ANSWER_TEXT_MAX * lights->count;
    *b               = (block){.truth = t, .lights = lights, .capacity = BLOCK_POINTS};
    if (b->capacity > BLOCK_TEXT_MAX / line_size) b->capacity = BLOCK_TEXT_MAX / line_size;
    if (!b->capacity) b->capacity = 1;
    b->points  = calloc(b->capacity, sizeof *b->points);
    b->answers = calloc(b->capacity, lights->count);
    b->text    = calloc(b->capacity, line_size);
    return b->points && b->answers && b->text ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a block of points");
}

static void block_free(block *b)
{
    free(b->points);
    free(b->answers);
    free(b->text);
    *b = (block){0};
}

static void trace_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    const block *b = user;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const query_point *point   = &b->points[i];
        uint8_t           *answers = &b->answers[i * b->lights->count];
        double             from_ws[3];
        memcpy(from_ws, point->position_ws, sizeof from_ws);
        if (point->has_normal) truth_lift(b->truth, point->position_ws, point->normal_ws, from_ws);
        for (size_t k = 0; k < b->lights->count; k++) {
            const light_shape *light = &b->lights->lights[k].shape;
            answers[k]               = ANSWER_OUT;
            if (light_reaches(light, point->position_ws))
                answers[k] = truth_lit(b->truth, from_ws, light) ? ANSWER_LIT : ANSWER_SHADOW;
        }
    }
}

/* Returns the length of the text. */
static size_t print_answers(block *b, size_t count)
{
    static const char *const words[] = {[ANSWER_SHADOW] = "0", [ANSWER_LIT] = "1", [ANSWER_OUT] = "out"};
    const uint8_t           *answers = b->answers;
    char                    *to      = b->text;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < b->lights->count; k++) {
            to    = stpcpy(to, words[*answers++]);
            *to++ = k + 1 < b->lights->count ? ' ' : '\n';
        }
    return (size_t)(to - b->text);
}

static vxs_result write_out(const char *text, size_t size, message *m)
{
    if (fwrite(text, 1, size, stdout) != size || fflush(stdout) != 0)
        return fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
    return VXS_OK;
}

static vxs_result answer_points(const truth *t, const light_choice *lights, uint32_t threads, message *m)
{
    vxs_result   r;
    block        b      = {0};
    point_reader reader = {0};
    size_t       count  = 0;

    if ((r = block_init(&b, t, lights, m)) != VXS_OK) goto done;
    if ((r = point_reader_init(&reader, stdin, "standard input", m)) != VXS_OK) goto done;
    do {
        if ((r = points_read(&reader, b.points, b.capacity, &count, m)) != VXS_OK) goto done;
        parallel_for(threads, count, POINTS_AT_A_TIME, trace_points, &b);
        if ((r = write_out(b.text, print_answers(&b, count), m)) != VXS_OK) goto done;
    } while (count);
done:
    point_reader_free(&reader);
    block_free(&b);
    return r;
}

static vxs_result run(const truth_options *o, message *m)
{
    vxs_result   r;
    scene        s      = {0};
    light_choice lights = {0};
    casters      c      = {0};
    truth       *t      = NULL;

    if ((r = scene_load_gltf(&s, o->scene_path, o->scene_name, m)) != VXS_OK) goto done;
    if ((r = lights_choose(&s, &o->light_names, o->sun_given, o->sun, &lights, m)) != VXS_OK) goto done;
    /* solids and sheets cast the same shadow, so nothing needs to tell them apart */
    if ((r = casters_from_scene(&c, &s, CLOSED_OFF, m)) != VXS_OK) goto done;
    if ((r = truth_create(&t, &c, o->threads, m)) != VXS_OK) goto done;
    r = answer_points(t, &lights, o->threads, m);
done:
    truth_destroy(t);
    casters_free(&c);
    light_choice_free(&lights);
    scene_free(&s);
    return r;
}

int cmd_truth(int argc, char **argv)
{
    message       m          = {0};
    int           help_shown = 0;
    truth_options o          = {.threads = parallel_default_threads()};

    const option options[] = {
        {"--light", OPTION_TEXTS, &o.light_names, 0, 0, NULL, "NAME", "a light, a column each (all)", NULL},
        {"--sun", OPTION_VECTOR, o.sun, 0, 3, NULL, "X,Y,Z", "the way sunlight travels; adds a light named sun", &o.sun_given},
        {"--scene", OPTION_TEXT, &o.scene_name, 0, 0, NULL, "NAME", "a scene of the file, name or index (the file's own)", NULL},
        {"--threads", OPTION_U32, &o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (the processors allowed)", NULL},
    };
    const command_line line = {
        .name     = "truth",
        .synopsis = "SCENE [--light NAME]... [--sun X,Y,Z] [options] < points",
        .summary  = "Read points from standard input, `x y z` or `x y z nx ny nz` a line (world space, metres); for each print 1\n"
                    "(lit), 0 (in shadow) or out (beyond the light's cone or range), one column a light, by tracing a ray to the\n"
                    "light. With a normal the ray starts just off the surface.",
        .options  = options,
        .option_count  = sizeof options / sizeof *options,
        .operand_count = 1,
    };

    vxs_result r = options_parse(&line, argc, argv, &o.scene_path, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = run(&o, &m);
    free(o.light_names.items);
    return command_end(&m, r);
}
