/* The machine that measurements come from; see machine.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/machine.h"

#include <gnu/libc-version.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "baker/base/parallel.h"

int machine_describe(bench_machine *machine)
{
    struct utsname name;
    uname(&name);

    /* the processor's model name from the system, else the machine type */
    char  line[512], *model = NULL;
    FILE *f = fopen("/proc/cpuinfo", "re");
    while (f && !model && fgets(line, sizeof line, f)) {
        char *colon = strncmp(line, "model name", 10) ? NULL : strchr(line, ':');
        if (!colon) continue;
        model                       = colon + 1 + strspn(colon + 1, " \t");
        model[strcspn(model, "\n")] = 0;
    }
    if (f) fclose(f);

    machine->processor    = strdup(model ? model : name.machine);
    machine->cores        = parallel_default_threads();
    machine->memory_bytes = (uint64_t)sysconf(_SC_PAGESIZE) * (uint64_t)sysconf(_SC_PHYS_PAGES);
    if (asprintf(&machine->system, "%s %s %s, glibc %s", name.sysname, name.release, name.machine, gnu_get_libc_version()) < 0)
        machine->system = NULL;
    return machine->processor && machine->system;
}

void machine_free(bench_machine *machine)
{
    free(machine->processor);
    free(machine->system);
    free(machine->renderer);
    *machine = (bench_machine){0};
}
