/* Small texts: sizes, choices, lists of option values, paths.
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

/* Values of an option that may be repeated. */
typedef struct text_list {
    const char **items; /* owned; the strings are argv's */
    size_t       count, capacity;
} text_list;

/* A value that an option has for what is named, or for all that is not. */
typedef struct named_value {
    char  *name;       /* owned; NULL: none was given */
    double numbers[3]; /* as many as the option has */
} named_value;

/* Values of an option that may be repeated, no two of one name. */
typedef struct named_list {
    named_value *items; /* owned */
    size_t       count, capacity;
} named_list;

/* The value of a name (NULL: the one without); NULL when there is none. */
const named_value *named_find(const named_list *list, const char *name);

/* Accepts a zeroed object. */
void named_list_free(named_list *list);

/* Another item of a list for a message: "noon, morning, ...", cut short where it would not fit. text  "" at first */
enum { LIST_BYTES = 512 };
void list_item(char text[LIST_BYTES], const char *item);

/* Bytes of the UTF-8 letter that a text begins with, 1 to 4; 0: it begins with no UTF-8.
 * code  its number [out]; of no meaning where 0 is returned */
size_t utf8_letter(const char *text, uint32_t *code);

/* Make text that comes from a file fit to print, in place: each byte of a control character, which would break the line, speak to the terminal or
 * turn the text round, and each byte that is no UTF-8, becomes '?'. Messages and progress lines do so themselves. Returns text. */
char *one_line(char *text);

/* A copy of a text that is fit to print as one_line makes it, cut to what a path may have: what a report prints of files and their names.
 * text  [PLAIN_BYTES] out
 * Returns text. */
enum { PLAIN_BYTES = PATH_MAX };
const char *plain_text(char text[PLAIN_BYTES], const char *whole);

/* A text with what is more than `bytes`, at least 3, left out of its middle: "SM_Wal...te_04". No letter of UTF-8 is cut in two.
 * text  [bytes + 1] out
 * Returns text. */
const char *shorten(char *text, size_t bytes, const char *whole);

/* What stands for a text between two single quotes of a shell; characters of `special` get a backslash before them. */
void print_quoted(FILE *to, const char *text, const char *special);

/* "9876 B", "12.3 KiB", "1.55 MiB", "2.00 GiB" into text: three digits or more, and 1023 of a unit at most. Returns text. */
const char *size_text(char text[32], uint64_t bytes);

/* A number rounded to so many digits. Printed with %.15g it has no more of them, and no exponent where it is large: 12300, not 1.23e+04. */
double rounded(double number, int digits);

/* Word `index` of "auto|on|off" into word, cut to what fits. Returns word. */
const char *choice_word(char word[32], const char *choices, int index);

/* The index of a word of "auto|on|off", or -1. */
int choice_index(const char *choices, const char *word);

/* The folder that a path leads to, with a slash at its end: "./" where it names none.
 * Returns the name in it, which is a part of the path; NULL when the folder is longer than any that can be opened. */
const char *path_split(const char *path, char folder[PATH_MAX]);

#ifdef __cplusplus
}
#endif
#endif
