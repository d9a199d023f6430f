/* Point lines and the choice of lights: what is accepted, messages about the rest.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/command/points.h"
#include "baker/scene/light_choice.h"

#include <cmocka.h> /* last: it makes a macro of fail */

#define CAPACITY 8

/* Read everything that `bytes` holds, in blocks of `block` points; the first CAPACITY points are kept. */
static vxs_result read_bytes(const char *bytes, size_t size, size_t block, query_point *points, size_t *total, run_context *m)
{
    FILE *file = tmpfile();
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    rewind(file);

    point_reader reader = {.file = file, .name = "standard input"};
    query_point  some[CAPACITY];
    size_t       count = 0;
    vxs_result   r;
    *total = 0;
    do {
        r = points_read(&reader, some, block, &count, m);
        for (size_t i = 0; i < count; i++, ++*total)
            if (*total < CAPACITY) points[*total] = some[i];
    } while (r == VXS_OK && count);
    fclose(file);
    return r;
}

static size_t good(const char *text, query_point *points)
{
    run_context m = {0};
    size_t      total;
    assert_int_equal(read_bytes(text, strlen(text), 3, points, &total, &m), VXS_OK);
    assert_string_equal(m.error, "");
    return total;
}

static void bad_bytes(const char *bytes, size_t size, const char *why, size_t points_before)
{
    run_context m = {0};
    query_point points[CAPACITY];
    size_t      total;
    assert_int_equal(read_bytes(bytes, size, 3, points, &total, &m), VXS_E_READ);
    assert_string_equal(m.error, why);
    assert_int_equal(total, points_before);
}

static void bad(const char *text, const char *why, size_t points_before)
{
    bad_bytes(text, strlen(text), why, points_before);
}

static void points_are_read(void **state)
{
    (void)state;
    query_point p[CAPACITY];
    assert_int_equal(good("1 -2 3.5\n  4e1\t5 6   0 -3 4  \n", p), 2);
    assert_true(p[0].position_ws[0] == 1 && p[0].position_ws[1] == -2 && p[0].position_ws[2] == 3.5);
    assert_false(p[0].has_normal);
    assert_true(p[1].position_ws[0] == 40 && p[1].position_ws[1] == 5 && p[1].position_ws[2] == 6);
    assert_true(p[1].has_normal);
    assert_true(p[1].normal_ws[0] == 0 && p[1].normal_ws[1] == -0.6 && p[1].normal_ws[2] == 0.8);
}

static void blank_lines_and_comments_are_skipped(void **state)
{
    (void)state;
    query_point p[CAPACITY];
    assert_int_equal(good("", p), 0);
    assert_int_equal(good("\n\n", p), 0);
    assert_int_equal(good("# 1 2 3\n\n \t\n  # x\n1 2 3\n#", p), 1);
    assert_int_equal(good("1 2 3\n4 5 6\n7 8 9\n1 2 3\n", p), 4); /* more than a block */
}

static void line_ends_may_be_crlf_or_missing(void **state)
{
    (void)state;
    query_point p[CAPACITY];
    assert_int_equal(good("1 2 3\r\n\r\n4 5 6\r\n", p), 2);
    assert_int_equal(good("1 2 3\n4 5 7", p), 2);
    assert_true(p[1].position_ws[2] == 7);
    assert_int_equal(good("1 2 3\r\n4 5 8\r", p), 2);
    assert_true(p[1].position_ws[2] == 8);
}

static void wrong_lines_are_named(void **state)
{
    (void)state;
    bad("1 2 3\n\n1 2 3 4\n", "standard input: line 3: expected 3 or 6 numbers, found 4", 1);
    bad("1 2\n", "standard input: line 1: expected 3 or 6 numbers, found 2", 0);
    bad("1 2 3 4 5 6 7", "standard input: line 1: expected 3 or 6 numbers, found 7", 0);
    bad("# no\n1:2:3\n", "standard input: line 2: expected a finite number, found '1:2:3'", 0);
    bad("1 two 3\n", "standard input: line 1: expected a finite number, found 'two'", 0);
    bad("1 2 nan\n", "standard input: line 1: expected a finite number, found 'nan'", 0);
    bad("1 -inf 2\r\n", "standard input: line 1: expected a finite number, found '-inf'", 0);
    bad("1 2 1e999\n", "standard input: line 1: expected a finite number, found '1e999'", 0);
    bad("1 2 3 0 0 -0\n", "standard input: line 1: the normal is zero", 0);
    bad_bytes("1 2 3\0 4\n", 9, "standard input: line 1: holds a NUL byte", 0);
}

/* The three numbers of a point and, where they are given, of its normal. */
static void is_point(const char *text, double x, double y, double z, int has_normal)
{
    query_point p[CAPACITY];
    assert_int_equal(good(text, p), 1);
    assert_true(p[0].position_ws[0] == x && p[0].position_ws[1] == y && p[0].position_ws[2] == z);
    assert_int_equal(p[0].has_normal, has_normal);
}

static void commas_and_semicolons_separate(void **state)
{
    (void)state;
    is_point("1,2,3", 1, 2, 3, 0);
    is_point("1.5, -2.5 ,3e1\t\r\n", 1.5, -2.5, 30, 0);
    is_point(" 1;2;3 \n", 1, 2, 3, 0);
    is_point("1.5 ; 2.5;3", 1.5, 2.5, 3, 0);
    is_point("1,2,3,0,1,0", 1, 2, 3, 1);
    is_point("1, 2, 3, 0, 1, 0", 1, 2, 3, 1);
    is_point("1,2,3, 0,1,0", 1, 2, 3, 1);
    is_point("1.5,2, 3.5,0, 1.5,0", 1.5, 2, 3.5, 1); /* ragged, but the decimal point is a point */
}

/* A comma that is a decimal point is never taken for another thing. */
static void lines_that_may_mean_two_things_are_refused(void **state)
{
    (void)state;
    static const char *const lines[] = {"1,5 2,5 3,5", "1,5\t2,5\t3,5", "1,5;2,5;3,5", "1,5, 2,5, 3,5", "1,5 , 2,5 , 3,5",
                                        "1 2,5 3",     "1,2 3",         "1 2 3,5",     "1;2,3",         "1,5 2 3 4 5"};
    for (size_t n = 0; n < sizeof lines / sizeof *lines; n++) {
        char        why[256];
        run_context m = {0};
        query_point p[CAPACITY];
        size_t      total;
        snprintf(why, sizeof why,
                 "standard input: line 1: expected numbers with a decimal point, separated all alike, by blanks or "
                 "commas: '%s' could mean two things",
                 lines[n]);
        for (char *c = why; *c; c++)
            if (*c == '\t') *c = '?';
        assert_int_equal(read_bytes(lines[n], strlen(lines[n]), 3, p, &total, &m), VXS_E_READ);
        assert_string_equal(m.error, why);
    }
    bad("1,,2,3\n", "standard input: line 1: expected a finite number, found ''", 0);
    bad("1,2,3,\n", "standard input: line 1: expected a finite number, found ''", 0);
    bad(",1,2,3\n", "standard input: line 1: expected a finite number, found ''", 0);
    bad("x,y,z\n", "standard input: line 1: expected a finite number, found 'x'", 0);
    bad("1,5\n", "standard input: line 1: expected 3 or 6 numbers, found 2", 0);
}

static void a_byte_order_mark_is_skipped(void **state)
{
    (void)state;
    query_point p[CAPACITY];
    is_point("\xef\xbb\xbf"
             "1 2 3\n",
             1, 2, 3, 0);
    assert_int_equal(good("\xef\xbb\xbf# x\r\n1 2 3\r\n", p), 1);
    assert_int_equal(good("\xef\xbb\xbf", p), 0);
    bad("1 2 3\n\xef\xbb\xbf"
        "4 5 6\n",
        "standard input: line 2: expected a finite number, found '\xef\xbb\xbf"
        "4'",
        1);
    bad_bytes("\xef\xbb\xbf"
              "1 2 3\0 4\n",
              12, "standard input: line 1: holds a NUL byte", 0);
}

/* A line of `length` characters, "1 2 3" and blanks, and then another point. */
static size_t long_line(char *text, size_t length, const char *end)
{
    memset(text, ' ', length);
    memcpy(text, "1 2 3", 5);
    return length + (size_t)sprintf(text + length, "%s4 5 6\n", end);
}

static void overlong_lines_are_refused(void **state)
{
    (void)state;
    static char text[1 << 18];
    const char *why = "standard input: line 1: longer than 4096 characters";
    query_point p[CAPACITY];
    long_line(text, POINT_LINE_MAX, "\n");
    assert_int_equal(good(text, p), 2);
    long_line(text, POINT_LINE_MAX, "\r\n");
    assert_int_equal(good(text, p), 2);
    bad_bytes(text, long_line(text, POINT_LINE_MAX + 1, "\n"), why, 0);
    bad_bytes(text, long_line(text, POINT_LINE_MAX + 1, "\r\n"), why, 0);
    bad_bytes(text, long_line(text, 200000, "\n"), why, 0);
    memset(text, '1', 200000);
    bad_bytes(text, 200000, why, 0);
}

/* Lines of many lengths cross the ends of the reader's buffer in every way. */
static void long_input_is_read_in_pieces(void **state)
{
    (void)state;
    enum { LINES = 10000 };
    char *text = malloc(LINES * 512);
    assert_non_null(text);
    size_t size = 0;
    for (int i = 0; i < LINES; i++) size += (size_t)sprintf(text + size, "%d %*d 0.5%s\n", i, 1 + i % 401, i, i % 3 ? "" : "\r");

    FILE *file = fmemopen(text, size, "r");
    assert_non_null(file);
    run_context  m      = {0};
    point_reader reader = {.file = file, .name = "text"};
    query_point  some[CAPACITY];
    size_t       count, next = 0;
    do {
        assert_int_equal(points_read(&reader, some, 7, &count, &m), VXS_OK);
        for (size_t i = 0; i < count; i++, next++)
            assert_true(some[i].position_ws[0] == (double)next && some[i].position_ws[1] == (double)next);
    } while (count);
    assert_int_equal(next, LINES);
    fclose(file);
    free(text);
}

static void unreadable_files_are_errors(void **state)
{
    (void)state;
    FILE *file = fopen(".", "r"); /* opens, but cannot be read */
    assert_non_null(file);
    run_context  m      = {0};
    point_reader reader = {.file = file, .name = "folder"};
    query_point  p[CAPACITY];
    size_t       count;
    assert_int_equal(points_read(&reader, p, CAPACITY, &count, &m), VXS_E_READ);
    assert_string_equal(m.error, "folder: cannot be read: Is a directory");
    fclose(file);
}

/* -- lights ---------------------------------------------------------------------------------------------- */

static scene_light scene_lights[] = {
    {.name = (char *)"lamp", .shape = {.kind = LIGHT_SPOT}},
    {.name = (char *)"moon", .shape = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {1, 0, 0}}},
    {.name = (char *)"sun", .shape = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {0, -1, 0}}},
};
static const scene      lit_scene  = {.light_count = 3, .lights = scene_lights};
static const scene      dark_scene = {.light_count = 1, .lights = scene_lights};
static const named_list no_suns    = {0};
static const named_list one_sun    = {(named_value[]){{(char *)"sun", {0, 0, -2}}}, 1, 1};
static const named_list two_suns   = {(named_value[]){{(char *)"noon", {0, 0, -1}}, {(char *)"sun", {0, 0, -2}}}, 2, 2};

/* The names chosen, "a b", or the error. */
static const char *choose(const scene *s, const char **names, size_t name_count, const named_list *suns, vxs_result expected)
{
    static char     text[2048];
    light_choice    chosen;
    run_context     m    = {0};
    const text_list list = {.items = names, .count = name_count};
    assert_int_equal(lights_choose(s, &list, suns, &chosen, &m), expected);
    if (expected != VXS_OK) {
        assert_null(chosen.lights);
        strcpy(text, m.error);
        run_free(&m);
        return text;
    }

    text[0] = '\0';
    for (size_t i = 0; i < chosen.count; i++) {
        strcat(strcat(text, i ? " " : ""), chosen.lights[i].name);
        if (strcmp(chosen.lights[i].name, "sun")) continue;
        assert_true(chosen.lights[i].shape.direction_ws[1] == (suns->count ? 0 : -1)); /* --sun replaces the scene's */
        assert_true(chosen.lights[i].shape.direction_ws[2] == (suns->count ? -1 : 0)); /* and is made a unit vector */
    }
    light_choice_free(&chosen);
    run_free(&m);
    return text;
}

static void lights_are_chosen(void **state)
{
    (void)state;
    assert_string_equal(choose(&lit_scene, NULL, 0, &no_suns, VXS_OK), "lamp moon sun");
    assert_string_equal(choose(&lit_scene, (const char *[]){"sun", "moon"}, 2, &no_suns, VXS_OK), "sun moon");
    assert_string_equal(choose(&lit_scene, NULL, 0, &one_sun, VXS_OK), "sun");
    assert_string_equal(choose(&lit_scene, (const char *[]){"moon"}, 1, &one_sun, VXS_OK), "moon sun");
    assert_string_equal(choose(&lit_scene, (const char *[]){"sun", "moon"}, 2, &one_sun, VXS_OK), "sun moon");
    assert_string_equal(choose(&dark_scene, NULL, 0, &one_sun, VXS_OK), "sun");
}

static void several_suns_are_chosen(void **state)
{
    (void)state;
    assert_string_equal(choose(&lit_scene, NULL, 0, &two_suns, VXS_OK), "noon sun");
    assert_string_equal(choose(&lit_scene, (const char *[]){"sun"}, 1, &two_suns, VXS_OK), "sun noon");
    assert_string_equal(choose(&lit_scene, (const char *[]){"lamp", "noon"}, 2, &two_suns, VXS_OK), "lamp noon sun");
    assert_string_equal(choose(&lit_scene, (const char *[]){"son"}, 1, &two_suns, VXS_E_ARGUMENT),
                        "--light son: no such light; there are lamp (spot), moon (directional), noon (directional), "
                        "sun (directional): did you mean 'sun'?");
}

/* Lights by the names of their nodes; those that do not shine, and those that cannot be baked. */
static void faulty_lights_are_left_out(void **state)
{
    (void)state;
    scene_light lights[] = {
        {.name = "Spot", .shape = {.kind = LIGHT_SPOT}, .node_name = "kitchen", .node = 3},
        {.name = "Spot#2", .shape = {.kind = LIGHT_SPOT}, .node_name = "hall", .node = 4, .odd = "range is 0; set it"},
        {.name = "off", .shape = {.kind = LIGHT_POINT}, .node_name = "", .node = 5, .dark = "its intensity is 0"},
        {.name = "a", .shape = {.kind = LIGHT_POINT}, .node_name = "twin", .node = 6},
        {.name = "b", .shape = {.kind = LIGHT_POINT}, .node_name = "twin", .node = 7}};
    lost_light lost[] = {{"bad", "shed", 8, "unknown type 'area'; mend it"}, {"hidden", "attic", 9, NULL}};
    scene      s      = {.light_count = 5, .lights = lights, .lost_light_count = 2, .lost_lights = lost};
    assert_string_equal(choose(&s, NULL, 0, &no_suns, VXS_OK), "Spot Spot#2 a b");
    assert_string_equal(choose(&s, (const char *[]){"hall", "kitchen"}, 2, &no_suns, VXS_OK), "Spot#2 Spot");
    assert_string_equal(choose(&s, (const char *[]){"off"}, 1, &no_suns, VXS_OK), "off");
    assert_string_equal(choose(&s, (const char *[]){"hall", "Spot#2"}, 2, &no_suns, VXS_E_ARGUMENT), "--light Spot#2: given twice");
    assert_string_equal(choose(&s, (const char *[]){"bad"}, 1, &no_suns, VXS_E_ARGUMENT),
                        "--light bad: the light of node 8 'shed' cannot be baked: unknown type 'area'; mend it");
    assert_non_null(strstr(choose(&s, (const char *[]){"shed"}, 1, &no_suns, VXS_E_ARGUMENT), "cannot be baked"));
    assert_non_null(strstr(choose(&s, (const char *[]){"attic"}, 1, &no_suns, VXS_E_ARGUMENT),
                           "node 9 'attic' is hidden (KHR_node_visibility)"));
    assert_non_null(strstr(choose(&s, (const char *[]){"twin"}, 1, &no_suns, VXS_E_ARGUMENT),
                           "--light twin: 2 nodes of that name have lights"));
    assert_string_equal(
        choose(&s, (const char *[]){"x"}, 1, &no_suns, VXS_E_ARGUMENT),
        "--light x: no such light; there are Spot (spot, node 3 'kitchen'), Spot#2 (spot, node 4 'hall'), off (point, node 5), "
        "a (point, node 6 'twin'), b (point, node 7 'twin')");
    s.lights      = lights + 2;
    s.light_count = 1;
    assert_string_equal(choose(&s, NULL, 0, &no_suns, VXS_E_NO_LIGHT),
                        "the scene has no light that can be baked; 'bad': unknown type 'area'; mend it; --sun X,Y,Z gives one");
    s.lost_light_count = 0;
    assert_string_equal(choose(&s, NULL, 0, &no_suns, VXS_E_NO_LIGHT),
                        "the scene has no light that shines; 'off': its intensity is 0; --sun X,Y,Z gives one");
    s.light_count      = 0;
    s.lost_lights      = lost + 1;
    s.lost_light_count = 1;
    assert_string_equal(choose(&s, NULL, 0, &no_suns, VXS_E_NO_LIGHT),
                        "all lights of the scene are hidden (KHR_node_visibility): --sun X,Y,Z gives one");
    s.lost_light_count = 0;
    s.emissive_count   = 1;
    assert_string_equal(choose(&s, NULL, 0, &no_suns, VXS_E_NO_LIGHT),
                        "the scene has no light, and materials that shine are none: --sun X,Y,Z gives one");
}

/* Said where all lights are meant, or where a light is chosen; a few lines whatever there is. */
static void faulty_lights_are_warned_of(void **state)
{
    (void)state;
    enum { LIGHTS = 100 };
    static scene_light lights[LIGHTS];
    static lost_light  lost[LIGHTS];
    static char        names[LIGHTS][8];
    for (uint32_t n = 0; n < LIGHTS; n++) {
        snprintf(names[n], sizeof names[n], "l%u", n);
        lights[n] = (scene_light){.name      = names[n],
                                  .shape     = {.kind = LIGHT_POINT},
                                  .node_name = names[n],
                                  .dark      = n ? "its intensity is 0" : NULL,
                                  .odd       = n ? NULL : "odd; mend it"};
        lost[n]   = (lost_light){names[n], names[n], n, "faulty; mend it"};
    }
    scene        s = {.light_count = LIGHTS, .lights = lights, .lost_light_count = LIGHTS, .lost_lights = lost};
    run_context  m = {0};
    light_choice chosen;
    assert_int_equal(lights_choose(&s, &(text_list){0}, &no_suns, &chosen, &m), VXS_OK);
    assert_int_equal(chosen.count, 1);
    light_choice_free(&chosen);
    assert_int_equal(m.warning_count, 9);
    assert_string_equal(m.warnings[0], "light 'l0' (node 0) is left out: faulty; mend it");
    assert_string_equal(m.warnings[3], "97 more lights are left out for such faults; see to those above, and run again");
    assert_string_equal(
        m.warnings[4],
        "light 'l1' (node 0) is left out: its intensity is 0; set it in the scene, or --light bakes it all the same");
    assert_string_equal(m.warnings[7],
                        "96 more lights are left out because they are dark; set their intensities, or name them with --light");
    assert_string_equal(m.warnings[8], "light 'l0' (node 0): odd; mend it");
    run_free(&m);
    memset(&m, 0, sizeof m);
    assert_int_equal(lights_choose(&s, &(text_list){.items = (const char *[]){"l7"}, .count = 1}, &no_suns, &chosen, &m), VXS_OK);
    light_choice_free(&chosen);
    assert_int_equal(m.warning_count, 1);
    assert_string_equal(m.warnings[0], "light 'l7' (node 0): its intensity is 0, and pictures do not show it; set it in the scene");
    run_free(&m);
}

/* The error for a sun of this name, or "". */
static const char *choose_sun(const char *name)
{
    named_value  sun = {(char *)name, {0, -1, 0}};
    text_list    all = {0};
    run_context  m   = {0};
    static char  text[1024];
    light_choice chosen;
    vxs_result   r = lights_choose(&dark_scene, &all, &(named_list){&sun, 1, 1}, &chosen, &m);
    assert_int_equal(r, m.error[0] ? VXS_E_ARGUMENT : VXS_OK);
    light_choice_free(&chosen);
    return strcpy(text, m.error);
}

static void names_of_suns_are_those_of_the_format(void **state)
{
    (void)state;
    char long_name[65] = "";
    for (int n = 0; n < 63; n++) strcat(long_name, "x");
    assert_string_equal(choose_sun(long_name), "");
    assert_non_null(strstr(choose_sun(strcat(long_name, "x")), "the name has 64 bytes, expected 1 to 63"));
    static const char *const good[] = {"a=b",          "Mittag \xc3\xbc", "\xe2\x98\x80", "\xf0\x9f\x8c\x9e",
                                       "\xed\x9f\xbf", "\xf4\x8f\xbf\xbf"};
    static const char *const bad[]  = {"\xfc",
                                       "a\xc3",
                                       "\x80",
                                       "\xc0\xaf",
                                       "\xe0\x80\x80",
                                       "\xed\xa0\x80",
                                       "\xf4\x90\x80\x80",
                                       "\xf0\x9f\x8c",
                                       "\xf8\x88\x80\x80\x80",
                                       "\xe2\x98z"};
    for (size_t n = 0; n < sizeof good / sizeof *good; n++) assert_string_equal(choose_sun(good[n]), "");
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) assert_non_null(strstr(choose_sun(bad[n]), "expected a name in UTF-8"));
}

static void wrong_choices_are_explained(void **state)
{
    (void)state;
    const scene      empty = {0};
    const named_list zero  = {(named_value[]){{(char *)"sun", {0, 0, 0}}}, 1, 1};
    assert_string_equal(choose(&dark_scene, NULL, 0, &no_suns, VXS_OK), "lamp");
    assert_string_equal(choose(&empty, NULL, 0, &no_suns, VXS_E_NO_LIGHT), "the scene has no light: --sun X,Y,Z gives one");
    assert_string_equal(choose(&lit_scene, NULL, 0, &zero, VXS_E_ARGUMENT), "--sun sun=0,0,0: expected a direction, not zero");
    assert_string_equal(
        choose(&lit_scene, (const char *[]){"son"}, 1, &no_suns, VXS_E_ARGUMENT),
        "--light son: no such light; there are lamp (spot), moon (directional), sun (directional): did you mean 'sun'?");
    assert_string_equal(choose(&empty, (const char *[]){"son"}, 1, &no_suns, VXS_E_ARGUMENT),
                        "--light son: the scene has no lights; --sun X,Y,Z gives one");
    assert_string_equal(choose(&lit_scene, (const char *[]){"lamp"}, 1, &one_sun, VXS_OK), "lamp sun");
    assert_string_equal(choose(&lit_scene, (const char *[]){"moon", "moon"}, 2, &no_suns, VXS_E_ARGUMENT),
                        "--light moon: given twice");
}

static void values_are_of_chosen_lights(void **state)
{
    (void)state;
    named_value      values[] = {{NULL, {64}}, {(char *)"lamp", {512}}};
    const named_list list     = {values, 2, 2};
    text_list        all      = {0};
    run_context      m        = {0};
    light_choice     chosen;
    assert_int_equal(lights_choose(&lit_scene, &all, &no_suns, &chosen, &m), VXS_OK);
    assert_int_equal(light_choice_require(&chosen, "--resolution", &list, &m), VXS_OK);
    light_choice_free(&chosen);
    assert_int_equal(lights_choose(&lit_scene, &all, &two_suns, &chosen, &m), VXS_OK);
    assert_int_equal(light_choice_require(&chosen, "--resolution", &list, &m), VXS_E_ARGUMENT);
    assert_string_equal(m.error,
                        "--resolution lamp=512: no light of that name is baked, but noon (directional), sun (directional)");
    light_choice_free(&chosen);
}

static void long_lists_of_lights_are_cut(void **state)
{
    (void)state;
    enum { LIGHTS = 500 };
    static scene_light many[LIGHTS];
    static char        names[LIGHTS][16];
    for (int i = 0; i < LIGHTS; i++) {
        sprintf(names[i], "light %d", i);
        many[i] = (scene_light){.name = names[i]};
    }
    const scene s     = {.light_count = LIGHTS, .lights = many};
    const char *error = choose(&s, (const char *[]){"x"}, 1, &no_suns, VXS_E_ARGUMENT);
    assert_int_equal(strcmp(error + strlen(error) - 3, "..."), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_read),
        cmocka_unit_test(blank_lines_and_comments_are_skipped),
        cmocka_unit_test(line_ends_may_be_crlf_or_missing),
        cmocka_unit_test(wrong_lines_are_named),
        cmocka_unit_test(commas_and_semicolons_separate),
        cmocka_unit_test(lines_that_may_mean_two_things_are_refused),
        cmocka_unit_test(a_byte_order_mark_is_skipped),
        cmocka_unit_test(overlong_lines_are_refused),
        cmocka_unit_test(long_input_is_read_in_pieces),
        cmocka_unit_test(unreadable_files_are_errors),
        cmocka_unit_test(lights_are_chosen),
        cmocka_unit_test(several_suns_are_chosen),
        cmocka_unit_test(faulty_lights_are_left_out),
        cmocka_unit_test(faulty_lights_are_warned_of),
        cmocka_unit_test(names_of_suns_are_those_of_the_format),
        cmocka_unit_test(wrong_choices_are_explained),
        cmocka_unit_test(values_are_of_chosen_lights),
        cmocka_unit_test(long_lists_of_lights_are_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
