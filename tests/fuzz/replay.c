/* Run a fuzz program's function once for each file of its corpus, and report it in TAP: the part of fuzzing that any compiler can
 * do.
 *
 * fuzz_NAME [FILE OR FOLDER...]; without one, build/corpus/NAME, which `tests/fuzz/corpus.py unpack` writes. The last file named is
 * the one at which it crashed.
 * VXS_FUZZ_SECONDS: how long one file may take (default 60).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <dirent.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fuzz.h"

static unsigned seconds_per_file = 60;

/* Bytes without room behind them: a sanitizer sees the first one read beyond. */
static int run_file(const char *path)
{
    FILE       *file   = fopen(path, "rb");
    struct stat status = {0};
    size_t      size   = file && !fstat(fileno(file), &status) ? (size_t)status.st_size : 0;
    uint8_t    *bytes  = malloc(size ? size : 1);
    int         good   = file && bytes && fread(bytes, 1, size, file) == size;
    if (file) fclose(file);
    printf("# %s%s\n", path, good ? "" : ": cannot be read");
    fflush(stdout);
    if (good) {
        alarm(seconds_per_file);
        LLVMFuzzerTestOneInput(bytes, size);
        alarm(0);
    }
    free(bytes);
    return good;
}

static int is_visible(const struct dirent *e)
{
    return e->d_name[0] != '.';
}

/* The number of files that were run, or -1 when one could not be. */
static int run_folder(const char *folder)
{
    struct dirent **entries;
    int             found = scandir(folder, &entries, is_visible, alphasort);
    int             count = found < 0 ? -1 : 0;
    for (int n = 0; n < found; n++) {
        char path[4096];
        int  length = snprintf(path, sizeof path, "%s/%s", folder, entries[n]->d_name);
        if (count >= 0) count = length < (int)sizeof path && run_file(path) ? count + 1 : -1;
        free(entries[n]);
    }
    if (found >= 0) free(entries);
    return count;
}

static int run(int test, const char *path)
{
    struct stat status;
    int         count = stat(path, &status) ? -1 : S_ISDIR(status.st_mode) ? run_folder(path) : run_file(path) ? 1 : -1;
    printf("%sok %d - %s: %d files\n", count > 0 ? "" : "not ", test, path, count < 0 ? 0 : count);
    return count > 0;
}

int main(int argc, char **argv)
{
    const char *limit = getenv("VXS_FUZZ_SECONDS");
    if (limit) seconds_per_file = (unsigned)strtoul(limit, NULL, 10);

    const char *slash = strrchr(argv[0], '/'), *program = slash ? slash + 1 : argv[0];
    char        folder[4096];
    snprintf(folder, sizeof folder, "build/corpus/%s", strncmp(program, "fuzz_", 5) ? program : program + 5);

    int good = 1;
    printf("1..%d\n", argc > 1 ? argc - 1 : 1);
    if (argc == 1) good = run(1, folder);
    if (argc == 1 && access(folder, R_OK)) printf("# tests/fuzz/corpus.py unpack writes %s\n", folder);
    for (int n = 1; n < argc; n++) good &= run(n, argv[n]);
    return !good;
}
