/* All of a command, from its line to its exit status; see options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "baker/command/options/options.h"
#include "baker/command/process/process.h"
#include "baker/command/process/progress.h"
#include "baker/files/run_files.h"

/* The exit status of a command that ran, but found something wrong. */
enum { STATUS_WRONG = 1 };

int command_end(message *m, vxs_result code)
{
    char word[COLORED_BYTES];
    /* a flush can fail: output is written only after it succeeds. A reader that has closed the pipe is no error here
     * (output_file.h) */
    if ((fflush(stdout) || ferror(stdout)) && code == VXS_OK && !standard_output_is_broken())
        code = fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
    progress_clear();
    if (code != VXS_OK && code != VXS_E_BROKEN_PIPE)
        fprintf(stderr, "vxs: %s: %s\n", colored(word, m->color, stderr, COLOR_RED, "error"), m->error[0] ? m->error : "unknown");
    /* STATUS_WRONG, even if the run stopped at its finding; except if it failed to write the report */
    int status = m->wrong && code != VXS_E_WRITE ? STATUS_WRONG : exit_status(code);
    message_free(m);
    return status;
}

/* Between lines of progress. */
static void print_warning(const message *m, const char *warning)
{
    char word[COLORED_BYTES];
    progress_clear();
    fprintf(stderr, "vxs: %s: %s\n", colored(word, m->color, stderr, COLOR_YELLOW, "warning"), warning);
}

int command_run(const command_line *c, int argc, char **argv, vxs_result (*run)(void *command, message *m), void *command)
{
    run_files  files = {0};
    message    m     = {.tell = print_warning, .files = &files, .temporary = process_temporary_files()};
    int        help_shown;
    vxs_result r = options_parse(c, argc, argv, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = options_check_files(c, &m);
    if (r == VXS_OK && !help_shown && (r = run(command, &m)) == VXS_OK && (r = message_check(&m)) == VXS_OK)
        options_warn_of_names(c, &m);
    options_free(c);
    run_files_free(&files);
    return command_end(&m, r);
}
