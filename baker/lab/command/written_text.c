/* The report line on an output; see written_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/written_text.h"

#include <sys/stat.h>

#include "baker/base/text.h"
#include "baker/files/run_files.h"

void written_print(FILE *to, const char *path, const char *what)
{
    struct stat status;
    char        size[32], plain[PLAIN_BYTES];
    if (!path) return;
    fprintf(to, "wrote        %s: %s", is_standard_output(path) ? "standard output" : plain_text(plain, path), what);
    if (!is_standard_output(path) && !stat(path, &status) && S_ISREG(status.st_mode))
        fprintf(to, ", %s", size_text(size, (uint64_t)status.st_size));
    fputc('\n', to);
}
