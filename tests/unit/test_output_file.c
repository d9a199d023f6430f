/* A file appears complete or not at all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/output_file.h"
#include "baker/files/run_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Each test runs in an empty folder of its own. */
static int enter_folder(void **state)
{
    static char folder[32];
    strcpy(folder, "/tmp/vxs-output-XXXXXX");
    *state = folder;
    return !mkdtemp(folder) || chdir(folder);
}

static int leave_folder(void **state)
{
    unlink("a");
    unlink("b");
    return chdir("/") || rmdir(*state); /* fails when a temporary file was left */
}

static int file_count(void)
{
    int  count  = 0;
    DIR *folder = opendir(".");
    assert_non_null(folder);
    for (struct dirent *e; (e = readdir(folder));) count += strcmp(e->d_name, ".") && strcmp(e->d_name, "..");
    closedir(folder);
    return count;
}

static void check_content(const char *path, const char *wanted)
{
    char  content[64] = {0};
    FILE *file        = fopen(path, "rb");
    assert_non_null(file);
    size_t size = fread(content, 1, sizeof content - 1, file);
    fclose(file);
    assert_int_equal(size, strlen(wanted));
    assert_string_equal(content, wanted);
}

static void write_file(const char *path, const char *content)
{
    run_context m = {0};
    output_file f;
    assert_int_equal(output_file_open(&f, path, &m), VXS_OK);
    assert_int_equal(output_file_write(&f, content, strlen(content), &m), VXS_OK);
    assert_int_equal(output_file_commit(&f, &m), VXS_OK);
}

static void test_commit_replaces(void **state)
{
    (void)state;
    write_file("a", "first");
    write_file("a", "second");
    check_content("a", "second");
    assert_int_equal(file_count(), 1);
}

static void test_old_file_stays_until_commit(void **state)
{
    (void)state;
    run_context m = {0};
    output_file f;
    write_file("a", "old");
    assert_int_equal(output_file_open(&f, "a", &m), VXS_OK);
    assert_int_equal(output_file_write(&f, "new", 3, &m), VXS_OK);
    fflush(f.stream);
    check_content("a", "old");
    output_file_abort(&f);
    check_content("a", "old");
    assert_int_equal(file_count(), 1);
}

/* It is invisible until it is complete, so a kill leaves nothing. */
static void test_no_name_until_commit(void **state)
{
    (void)state;
    run_context m = {0};
    output_file f;
    int         probe = open(".", O_TMPFILE | O_WRONLY, 0600);
    if (probe < 0) skip();
    close(probe);
    assert_int_equal(output_file_open(&f, "a", &m), VXS_OK);
    assert_int_equal(output_file_write(&f, "new", 3, &m), VXS_OK);
    fflush(f.stream);
    assert_int_equal(file_count(), 0);
    assert_int_equal(output_file_commit(&f, &m), VXS_OK);
    check_content("a", "new");
    assert_int_equal(file_count(), 1);
}

/* Names that earlier runs left are passed over: they may be those of a run that goes on. */
static void test_names_left_behind(void **state)
{
    (void)state;
    char left[64];
    snprintf(left, sizeof left, ".vxs-%ld-0.tmp", (long)getpid());
    FILE *file = fopen(left, "wb");
    assert_non_null(file);
    fclose(file);
    write_file("a", "new");
    check_content("a", "new");
    check_content(left, "");
    unlink(left);
}

static void test_two_files_at_once(void **state)
{
    (void)state;
    run_context m = {0};
    output_file f, g;
    assert_int_equal(output_file_open(&f, "a", &m), VXS_OK);
    assert_int_equal(output_file_open(&g, "b", &m), VXS_OK);
    fputs("one", f.stream);
    fputs("two", g.stream);
    assert_int_equal(output_file_commit(&g, &m), VXS_OK);
    assert_int_equal(output_file_commit(&f, &m), VXS_OK);
    check_content("a", "one");
    check_content("b", "two");
}

static void test_abort_is_harmless_twice(void **state)
{
    (void)state;
    run_context m = {0};
    output_file f = {0};
    output_file_abort(&f);
    assert_int_equal(output_file_open(&f, "a", &m), VXS_OK);
    assert_int_equal(output_file_commit(&f, &m), VXS_OK);
    output_file_abort(&f);
    assert_int_equal(file_count(), 1);
}

/* The bytes fit the buffer, so that only the last flush meets the limit. */
static void test_commit_sees_a_full_disk(void **state)
{
    (void)state;
    run_context   m = {0};
    output_file   f;
    struct rlimit old, tight;
    getrlimit(RLIMIT_FSIZE, &old);
    tight                = old;
    tight.rlim_cur       = 2;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);

    write_file("a", "old");
    assert_int_equal(output_file_open(&f, "a", &m), VXS_OK);
    assert_int_equal(output_file_write(&f, "longer", 6, &m), VXS_OK);
    setrlimit(RLIMIT_FSIZE, &tight);
    vxs_result r = output_file_commit(&f, &m);
    setrlimit(RLIMIT_FSIZE, &old);
    signal(SIGXFSZ, handler);

    assert_int_equal(r, VXS_E_WRITE);
    assert_non_null(strstr(m.error, "a: cannot write: "));
    assert_null(f.stream);
    check_content("a", "old");
    assert_int_equal(file_count(), 1);
}

static void test_commit_sees_a_full_standard_output(void **state)
{
    (void)state;
    run_context m = {0};
    output_file f;
    fflush(stdout);
    int terminal = dup(STDOUT_FILENO), full = open("/dev/full", O_WRONLY);
    assert_true(terminal >= 0 && full >= 0);
    dup2(full, STDOUT_FILENO);
    vxs_result opened = output_file_open(&f, "-", &m), written = output_file_write(&f, "x", 1, &m);
    vxs_result committed = output_file_commit(&f, &m);
    dup2(terminal, STDOUT_FILENO);
    fflush(stdout);
    clearerr(stdout);
    close(terminal);
    close(full);

    assert_true(opened == VXS_OK && written == VXS_OK && committed == VXS_E_WRITE);
    assert_string_equal(m.error, "standard output: cannot write: No space left on device");
}

/* open and check agree of a file, and nothing is left of either. */
static void check_refused(const char *path, run_context m, vxs_result code, const char *says)
{
    output_file f;
    run_context again  = m;
    int         before = file_count();
    assert_int_equal(output_file_open(&f, path, &m), code);
    assert_non_null(strstr(m.error, says));
    assert_null(f.stream);
    assert_int_equal(output_file_check(path, &again), code);
    assert_string_equal(again.error, m.error);
    assert_int_equal(file_count(), before);
}

/* The bits of the mode count, which do not keep root from writing. */
static void test_read_only_files_are_left_alone(void **state)
{
    (void)state;
    run_context forced = {.force = 1};
    struct stat status;
    write_file("a", "old");
    chmod("a", 0444);
    check_refused("a", (run_context){0}, VXS_E_WRITE, "a: cannot write: it is read-only: --force");
    check_content("a", "old");

    output_file f;
    assert_int_equal(output_file_open(&f, "a", &forced), VXS_OK);
    fputs("new", f.stream);
    assert_int_equal(output_file_commit(&f, &forced), VXS_OK);
    check_content("a", "new");
    assert_true(!stat("a", &status) && (status.st_mode & 07777) == 0444);
    assert_int_equal(forced.warning_count, 0);
}

static void test_modes_are_kept(void **state)
{
    (void)state;
    static const mode_t modes[] = {0600, 0646, 0755, 02664, 04755, 06711, 01644};
    struct stat         status;
    write_file("a", "old");
    for (size_t n = 0; n < sizeof modes / sizeof *modes; n++) {
        chmod("a", modes[n]);
        write_file("a", "new");
        assert_true(!stat("a", &status) && (status.st_mode & 07777) == (modes[n] & 0777));
    }
}

static void test_hard_links_are_not_parted(void **state)
{
    (void)state;
    run_context forced = {.force = 1}, strict = {.force = 1, .strict = 1};
    output_file f;
    write_file("a", "old");
    assert_int_equal(link("a", "b"), 0);
    check_refused("a", (run_context){0}, VXS_E_WRITE, "a: cannot write: it is one of 2 hard links");
    check_refused("a", strict, VXS_E_STRICT, "a: was one of 2 hard links");
    assert_int_equal(output_file_check("a", &forced), VXS_OK);
    assert_int_equal(output_file_open(&f, "a", &forced), VXS_OK);
    fputs("new", f.stream);
    assert_int_equal(output_file_commit(&f, &forced), VXS_OK);
    assert_int_equal(forced.warning_count, 1);
    check_content("a", "new");
    check_content("b", "old");
    run_free(&forced);
}

static void test_links_lead_to_files(void **state)
{
    (void)state;
    assert_int_equal(symlink("b", "a"), 0);
    check_refused("a", (run_context){.force = 1}, VXS_E_WRITE, "a: cannot write: it is a link that leads to no file: No such file");
    unlink("a");
    assert_int_equal(symlink("a", "a"), 0);
    check_refused("a", (run_context){0}, VXS_E_WRITE, "a: cannot write: it is a link that leads to no file: Too many levels");
}

/* What a run reads it does not write, by whatever name; other files it does, and what no run knows of, too. */
static void test_inputs_are_not_written(void **state)
{
    (void)state;
    run_files   files = {0};
    run_context m     = {.files = &files, .force = 1};
    output_file out   = {0};
    write_file("a", "read");
    write_file("b", "old");
    assert_int_equal(symlink("a", "link"), 0);
    assert_int_equal(link("a", "hard"), 0);
    assert_int_equal(run_files_check_input("a", "SCENE", &m), VXS_OK);
    for (int n = 0; n < 4; n++) {
        static const char *const names[] = {"a", "./a", "link", "hard"};
        m.error[0]                       = 0;
        assert_int_equal(output_file_open(&out, names[n], &m), VXS_E_ARGUMENT);
        assert_non_null(strstr(m.error, "is the input itself, SCENE"));
        assert_int_equal(output_file_check(names[n], &m), VXS_E_ARGUMENT);
    }
    m.error[0] = 0;
    assert_int_equal(output_file_open(&out, "b", &m), VXS_OK);
    assert_int_equal(output_file_write(&out, "new", 3, &m), VXS_OK);
    assert_int_equal(output_file_commit(&out, &m), VXS_OK);
    check_content("a", "read");
    check_content("b", "new");
    run_files_free(&files);
    unlink("link");
    unlink("hard");
    run_free(&m);
}

static void test_a_folder_is_no_file(void **state)
{
    (void)state;
    run_context m = {0};
    output_file f;
    assert_int_equal(output_file_open(&f, ".", &m), VXS_E_WRITE);
    assert_string_equal(m.error, ".: cannot write: it is a folder, expected a file name");
    assert_true(!f.stream && !f.name && !f.target && !f.temporary);
}

int main(void)
{
#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, enter_folder, leave_folder)
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_commit_replaces),         IN_FOLDER(test_old_file_stays_until_commit),
        IN_FOLDER(test_no_name_until_commit),    IN_FOLDER(test_names_left_behind),
        IN_FOLDER(test_two_files_at_once),       IN_FOLDER(test_abort_is_harmless_twice),
        IN_FOLDER(test_commit_sees_a_full_disk), IN_FOLDER(test_commit_sees_a_full_standard_output),
        IN_FOLDER(test_a_folder_is_no_file),     IN_FOLDER(test_read_only_files_are_left_alone),
        IN_FOLDER(test_modes_are_kept),          IN_FOLDER(test_hard_links_are_not_parted),
        IN_FOLDER(test_links_lead_to_files),     IN_FOLDER(test_inputs_are_not_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
