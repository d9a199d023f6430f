/* What a command wrote, as a line of its report.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WRITTEN_TEXT_H
#define WRITTEN_TEXT_H

#include <stdio.h>

/* "wrote        city.png: 1280 x 720 pixels, 1.25 MiB". The size is that of a regular file at the path.
 * path  NULL: nothing was written, and nothing is printed; "-": standard output */
void written_print(FILE *to, const char *path, const char *what);

#endif
