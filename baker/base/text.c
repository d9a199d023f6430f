/* Small text functions; see text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const named_value *named_find(const named_list *list, const char *name)
{
    for (const named_value *v = list->items; v < list->items + list->count; v++)
        if (name && v->name ? !strcmp(v->name, name) : name == v->name) return v;
    return NULL;
}

void named_list_free(named_list *list)
{
    for (size_t n = 0; n < list->count; n++) free(list->items[n].name);
    free(list->items);
    *list = (named_list){0};
}

void list_item(char text[LIST_BYTES], const char *item)
{
    size_t used = strlen(text);
    used += (size_t)snprintf(text + used, LIST_BYTES - used, "%s%s", used ? ", " : "", item);
    if (used >= LIST_BYTES) memcpy(text + LIST_BYTES - sizeof "...", "...", sizeof "...");
}

size_t utf8_letter(const char *text, uint32_t *code)
{
    const unsigned char *c    = (const unsigned char *)text;
    size_t               size = c[0] < 0x80 ? 1 : c[0] < 0xc2 ? 0 : c[0] < 0xe0 ? 2 : c[0] < 0xf0 ? 3 : c[0] < 0xf5 ? 4 : 0;
    *code                     = size > 1 ? c[0] & (0x7fu >> size) : c[0];
    for (size_t n = 1; n < size; n++) {
        if ((c[n] & 0xc0) != 0x80) return 0; /* also rejects a NUL */
        *code = *code << 6 | (c[n] & 0x3f);
    }
    int overlong = (size == 3 && *code < 0x800) || (size == 4 && *code < 0x10000), surrogate = *code >= 0xd800 && *code < 0xe000;
    return overlong || surrogate || *code > 0x10ffff ? 0 : size;
}

/* Not printable: C0 and C1 control characters (C1: U+0080 to U+009F), line and paragraph separators (U+2028, U+2029), and the
 * characters that change the text direction (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069), which can make a line
 * look like another one. */
static int is_printable(uint32_t code)
{
    if (code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0x200e || code == 0x200f) return 0;
    return !(code >= 0x2028 && code <= 0x202e) && !(code >= 0x2066 && code <= 0x2069);
}

char *one_line(char *text)
{
    for (char *c = text; *c;) {
        uint32_t code;
        size_t   size = utf8_letter(c, &code);
        if (!size || !is_printable(code)) memset(c, '?', size ? size : 1);
        c += size ? size : 1;
    }
    return text;
}

const char *plain_text(char text[PLAIN_BYTES], const char *whole)
{
    snprintf(text, PLAIN_BYTES, "%s", whole);
    return one_line(text);
}

static int is_within_letter(char c)
{
    return (c & 0xc0) == 0x80;
}

const char *shorten(char *text, size_t bytes, const char *whole)
{
    size_t length = strlen(whole), kept = bytes - strlen("..."), head = (kept + 1) / 2, tail = kept / 2;
    if (length <= bytes) return strcpy(text, whole);
    while (head && is_within_letter(whole[head])) head--;
    while (is_within_letter(whole[length - tail])) tail--;
    snprintf(text, bytes + 1, "%.*s...%s", (int)head, whole, whole + length - tail);
    return text;
}

void print_quoted(FILE *to, const char *text, const char *special)
{
    for (; *text; text++) {
        if (*text == '\'')
            fputs("'\\''", to);
        else
            fprintf(to, "%s%c", strchr(special, *text) ? "\\" : "", *text);
    }
}

const char *size_text(char text[32], uint64_t bytes)
{
    static const char *const units[] = {"KiB", "MiB", "GiB", "TiB"};
    double                   size    = (double)bytes / 1024;
    int                      unit    = 0;
    if (bytes < 10 * 1024) {
        snprintf(text, 32, "%llu B", (unsigned long long)bytes);
        return text;
    }
    while (size >= 1023.95 && unit < 3) { /* would print as 1024.0 */
        size /= 1024;
        unit++;
    }
    snprintf(text, 32, "%.*f %s", size < 9.995 ? 2 : 1, size, units[unit]);
    return text;
}

double rounded(double number, int digits)
{
    char text[32];
    snprintf(text, sizeof text, "%.*g", digits, number);
    return strtod(text, NULL);
}

const char *choice_word(char word[32], const char *choices, int index)
{
    while (index-- > 0) choices += strcspn(choices, "|") + 1;
    snprintf(word, 32, "%.*s", (int)strcspn(choices, "|"), choices);
    return word;
}

int choice_index(const char *choices, const char *word)
{
    size_t length = strlen(word);
    for (int index = 0;; index++) {
        size_t n = strcspn(choices, "|");
        if (n == length && !memcmp(choices, word, n)) return index;
        if (!choices[n]) return -1;
        choices += n + 1;
    }
}

const char *path_split(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (name - path >= PATH_MAX) return NULL;
    snprintf(folder, PATH_MAX, "%.*s", (int)(name - path), path);
    if (!slash) strcpy(folder, "./");
    return name;
}
