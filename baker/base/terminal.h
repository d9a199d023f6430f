/* Properties of output streams: a terminal (colours, lines that are overwritten) or a pipe (which may be broken).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TERMINAL_H
#define TERMINAL_H

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* --color. COLOR_AUTO: colours when the stream is a terminal, TERM is not "dumb", and NO_COLOR is empty or unset. */
typedef enum color_mode { COLOR_AUTO, COLOR_ALWAYS, COLOR_NEVER } color_mode;
#define COLOR_CHOICES "auto|always|never"

typedef enum word_color { COLOR_GREEN, COLOR_YELLOW, COLOR_RED } word_color;

enum { COLORED_BYTES = 32 };

/* A word for printing to a stream: bold and coloured, or unchanged.
 * word  at most 16 bytes
 * Returns text, or the word itself. */
const char *colored(char text[COLORED_BYTES], color_mode mode, FILE *to, word_color c, const char *word);

/* 1 when the stream is a terminal on which a line can be overwritten. */
int terminal_can_clear(FILE *to);

/* 1 when standard output is a pipe or socket without a reader, as in `vxs query | head -1`. */
int standard_output_is_broken(void);

#ifdef __cplusplus
}
#endif
#endif
