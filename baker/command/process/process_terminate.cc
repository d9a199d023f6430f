/* The handler for std::terminate; see process.h.
 * nlohmann::json allocates in functions that are noexcept, such as its destructor and move: out of memory terminates the process
 * there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <new>

#include "baker/base/run_context.h"
#include "baker/command/process/process.h"

/* When a noexcept function throws, the exception may be still in flight and cannot be inspected. Only out of memory is thrown
 * there. */
static bool out_of_memory()
{
    try {
        if (!std::current_exception()) return std::uncaught_exceptions() > 0;
        throw;
    } catch (const std::bad_alloc &) {
        return true;
    } catch (...) {
        return false;
    }
}

[[noreturn]] static void end_process()
{
    static const char text[] = "vxs: error: out of memory\n";
    if (!out_of_memory()) abort();
    process_remove_temporary();
    progress_clear();
    if (write(STDERR_FILENO, text, sizeof text - 1) < 0) abort();
    _exit(exit_status(VXS_E_MEMORY));
}

void process_catch_terminate(void)
{
    std::set_terminate(end_process);
}
