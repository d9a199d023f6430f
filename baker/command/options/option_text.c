/* Texts that help, manual pages and completion have in common; see option_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/option_text.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

const char *option_value(const option *o)
{
    return o->kind == OPTION_CHOICE && !is_operand(o) ? o->choices : o->value;
}

const char *option_usage(char text[96], const option *o)
{
    const char *value = option_value(o);
    snprintf(text, 96, "%s%s%s", o->name, value ? " " : "", value ? value : "");
    return text;
}

const char *summary_phrase(char text[128], const char *summary)
{
    const char *end = strstr(summary, ". ");
    snprintf(text, 128, "%.*s", (int)(end ? end - summary : (long)strlen(summary) - 1), summary);
    text[0] = (char)tolower((unsigned char)text[0]);
    return text;
}
