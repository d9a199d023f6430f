/* The line of a report on an output.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WRITTEN_TEXT_H
#define WRITTEN_TEXT_H

#include <stdio.h>

/* Print "wrote        city.png: 1280 x 720 pixels, 1.25 MiB". The size is read from the regular file at the path.
 * path  NULL: no output, print nothing; "-": standard output */
void written_print(FILE *to, const char *path, const char *what);

#endif
