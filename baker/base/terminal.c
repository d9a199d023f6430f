/* Properties of output streams; see terminal.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/terminal.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int terminal_can_clear(FILE *to)
{
    const char *kind = getenv("TERM");
    return isatty(fileno(to)) && !(kind && !strcmp(kind, "dumb"));
}

const char *colored(char text[COLORED_BYTES], color_mode mode, FILE *to, word_color c, const char *word)
{
    static const int codes[]  = {[COLOR_GREEN] = 32, [COLOR_YELLOW] = 33, [COLOR_RED] = 31};
    const char      *unwanted = getenv("NO_COLOR");
    int              shown = mode == COLOR_ALWAYS || (mode == COLOR_AUTO && terminal_can_clear(to) && !(unwanted && unwanted[0]));
    if (!shown) return word;
    snprintf(text, COLORED_BYTES, "\033[1;%dm%s\033[0m", codes[c], word);
    return text;
}
