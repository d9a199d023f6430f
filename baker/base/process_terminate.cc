/* What ends a process that C++ gives up on; see process.h.
 * nlohmann::json allocates in its destructor, which may not throw: without memory the process ends there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <new>

#include "baker/base/output_file.h"
#include "baker/base/process.h"

[[noreturn]] static void end_process()
{
    try {
        if (std::current_exception()) throw;
    } catch (const std::bad_alloc &) {
        static const char text[] = "vxs: error: out of memory\n";
        output_file_remove_temporary();
        if (write(STDERR_FILENO, text, sizeof text - 1) < 0) abort();
        _exit(exit_status(VXS_E_MEMORY));
    } catch (...) {
    }
    abort();
}

void process_catch_terminate(void)
{
    std::set_terminate(end_process);
}
