/* A text of the repository, as shaders are made of. Included behind cmocka.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef READ_TEXT_H
#define READ_TEXT_H

#include <stdio.h>
#include <stdlib.h>

/* To be freed. Skips the test where it is not started in the root of the repository. */
static inline char *read_text(const char *path)
{
    enum { MOST = 1 << 16 };
    char *text = calloc(1, MOST);
    FILE *file = fopen(path, "r");
    assert_non_null(text);
    if (!file) {
        print_message("%s is not here: start this test in the root of the repository\n", path);
        skip();
    }
    assert_in_range(fread(text, 1, MOST - 1, file), 1, MOST - 2);
    fclose(file);
    return text;
}

#endif
