/* Small text functions: sizes, choices, lists of option values, paths.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEXT_H
#define TEXT_H

#include <limits.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Values of a repeatable option. */
typedef struct text_list {
    const char **items; /* owned; the strings are argv's */
    size_t       count, capacity;
} text_list;

/* A value of an option for one name, or for all other names. */
typedef struct named_value {
    char  *name;       /* owned; NULL: the value for all other names */
    double numbers[3]; /* as many as the option takes */
} named_value;

/* Values of a repeatable option; names are unique. */
typedef struct named_list {
    named_value *items; /* owned */
    size_t       count, capacity;
} named_list;

/* Value for a name (NULL: the value without a name); NULL: none. */
const named_value *named_find(const named_list *list, const char *name);

/* Accepts a zeroed object. */
void named_list_free(named_list *list);

/* Append an item to a list for a message: "noon, morning, ...". Cut short where it does not fit.
 * text  "" at first */
enum { LIST_BYTES = 512 };
void list_item(char text[LIST_BYTES], const char *item);

/* Length in bytes of the UTF-8 character at the start of a text, 1 to 4; 0: not UTF-8.
 * code  [out] code point; undefined when 0 is returned */
size_t utf8_letter(const char *text, uint32_t *code);

/* Make text from a file safe to print, in place. Each byte that is not UTF-8 becomes '?', and each byte of a control character,
 * which could break the line, control the terminal or reverse the text direction. Messages and progress lines do this themselves.
 * Returns text. */
char *one_line(char *text);

/* Copy of a text, made safe as by one_line and cut to PLAIN_BYTES - 1 bytes: for file names and other names in reports.
 * text  [PLAIN_BYTES] out
 * Returns text. */
enum { PLAIN_BYTES = PATH_MAX };
const char *plain_text(char text[PLAIN_BYTES], const char *whole);

/* Shorten a text to `bytes`, at least 3, by removing its middle: "SM_Wal...te_04". UTF-8 characters stay whole.
 * text  [bytes + 1] out
 * Returns text. */
const char *shorten(char *text, size_t bytes, const char *whole);

/* Print a text for use between single quotes in a shell. Characters of `special` get a backslash. */
void print_quoted(FILE *to, const char *text, const char *special);

/* "9876 B", "12.3 KiB", "1.55 MiB", "2.00 GiB" into text: at least three digits, at most 1023 of a unit. Returns text. */
const char *size_text(char text[32], uint64_t bytes);

/* Round to `digits` significant digits. Then %.15g prints no more digits, and no exponent for large numbers: 12300, not
 * 1.23e+04. */
double rounded(double number, int digits);

/* Copy word `index` of "auto|on|off" to `word`, cut to fit. Returns word. */
const char *choice_word(char word[32], const char *choices, int index);

/* Index of a word in "auto|on|off", or -1. */
int choice_index(const char *choices, const char *word);

/* The folder part of a path, with a trailing slash; "./" when the path has none.
 * Returns the name after it, a pointer into the path; NULL when the folder is longer than PATH_MAX. */
const char *path_split(const char *path, char folder[PATH_MAX]);

#ifdef __cplusplus
}
#endif
#endif
