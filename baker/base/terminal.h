/* Who reads what is printed: a terminal, which may show colours and lines that are written over, or a pipe, whose reader may be gone.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TERMINAL_H
#define TERMINAL_H

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* --color. Auto: where a stream is a terminal, TERM is not "dumb", and NO_COLOR is empty or not set. */
typedef enum color_mode { COLOR_AUTO, COLOR_ALWAYS, COLOR_NEVER } color_mode;
#define COLOR_CHOICES "auto|always|never"

typedef enum word_color { COLOR_GREEN, COLOR_YELLOW, COLOR_RED } word_color;

enum { COLORED_BYTES = 32 };

/* A word as it is printed to a stream: bold and in a colour, or as it is.
 * word  of 16 bytes at most
 * Returns text, or the word itself. */
const char *colored(char text[COLORED_BYTES], color_mode mode, FILE *to, word_color c, const char *word);

/* 1 when a stream is a terminal on which a line can be written over. */
int terminal_can_clear(FILE *to);

/* 1 when standard output is a pipe or a socket that nobody reads any more, as that of `vxs query | head -1`. */
int standard_output_is_broken(void);

#ifdef __cplusplus
}
#endif
#endif
