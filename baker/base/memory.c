/* Memory limits; see memory.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/memory.h"

#include <inttypes.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "baker/base/integer.h"
#include "baker/base/text.h"

enum { WORTH_A_LOOK = 1 << 20 }; /* bytes; smaller amounts are not checked */

/* Address space and resident set of the process. */
static void own_sizes(uint64_t *address, uint64_t *resident)
{
    uint64_t page = (uint64_t)sysconf(_SC_PAGESIZE);
    FILE    *f    = fopen("/proc/self/statm", "re");
    *address = *resident = 0;
    if (!f) return;
    if (fscanf(f, "%" SCNu64 " %" SCNu64, address, resident) != 2) *address = *resident = 0;
    *address *= page;
    *resident *= page;
    fclose(f);
}

uint64_t memory_held_bytes(void)
{
    uint64_t address, resident;
    own_sizes(&address, &resident);
    return resident;
}

/* control groups -------------------------------------------------------------------------------------------------------------- */

/* The number after `key` in a file of a folder; the first number when key is "". `otherwise` when there is none ("max"). */
static uint64_t number_in(const char *folder, const char *name, const char *key, uint64_t otherwise)
{
    char     path[PATH_MAX], line[256];
    uint64_t number = otherwise;
    size_t   length = strlen(key);
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path) return otherwise;
    FILE *f = fopen(path, "re");
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, key, length) && sscanf(line + length, "%" SCNu64, &number) == 1) break;
    if (f) fclose(f);
    return number;
}

/* File names of control groups, version 1 and version 2. */
static const char *const        roots[2]  = {"/sys/fs/cgroup/memory", "/sys/fs/cgroup"},
                         *const limits[2] = {"memory.limit_in_bytes", "memory.max"},
                         *const uses[2]   = {"memory.usage_in_bytes", "memory.current"},
                         *const files[2]  = {"total_inactive_file ", "inactive_file "};

/* The rest of a group's limit. Cached files that the system can drop do not count as used. */
static uint64_t left_in_group(int version, const char *path)
{
    char folder[PATH_MAX];
    if (snprintf(folder, sizeof folder, "%s%s", roots[version], path) >= (int)sizeof folder) return UINT64_MAX;
    uint64_t limit = number_in(folder, limits[version], "", UINT64_MAX), used = number_in(folder, uses[version], "", 0);
    uint64_t unused = number_in(folder, "memory.stat", files[version], 0);
    used            = used > unused ? used - unused : 0;
    return limit == UINT64_MAX ? limit : limit > used ? limit - used : 0;
}

/* ----------------------------------------------------------------------------------------------------------------------------- */

/* The rest of RLIMIT_AS. */
static uint64_t left_of_addresses(void)
{
    struct rlimit limit;
    uint64_t      address, resident;
    own_sizes(&address, &resident);
    if (getrlimit(RLIMIT_AS, &limit) || limit.rlim_cur == RLIM_INFINITY) return UINT64_MAX;
    return limit.rlim_cur > address ? limit.rlim_cur - address : 0;
}

uint64_t memory_available_bytes(void)
{
    uint64_t kib = number_in("/proc", "meminfo", "MemAvailable:", UINT64_MAX / 1024);

    /* Minimum over the group of the process and its parent groups. A line is "4:memory:/path", or "0::/path" in version 2. */
    char     line[PATH_MAX];
    uint64_t left_in_groups = UINT64_MAX;
    FILE    *f              = fopen("/proc/self/cgroup", "re");
    while (f && fgets(line, sizeof line, f)) {
        int   version = !strncmp(line, "0::", 3) ? 1 : strstr(line, ":memory:") ? 0 : -1;
        char *path    = strchr(line, '/');
        if (version < 0 || !path) continue;
        path[strcspn(path, "\n")] = 0;
        for (char *end = path + strlen(path); end; end = strrchr(path, '/')) {
            *end           = 0;
            left_in_groups = min_u64(left_in_groups, left_in_group(version, path));
        }
    }
    if (f) fclose(f);

    return min_u64(min_u64(kib * 1024, left_in_groups), left_of_addresses());
}

int memory_allows(uint64_t bytes, const run_context *m)
{
    if (bytes < WORTH_A_LOOK) return 1;
    return (!m->memory_bytes || memory_held_bytes() + bytes <= m->memory_bytes) && bytes <= memory_available_bytes();
}

vxs_result memory_check(uint64_t bytes, run_context *m, const char *format, ...)
{
    char what[512], needed[32], there[32];
    if (bytes < WORTH_A_LOOK) return VXS_OK;
    uint64_t held = memory_held_bytes(), available = memory_available_bytes(), budget_bytes = m->memory_bytes;
    if ((!budget_bytes || held + bytes <= budget_bytes) && bytes <= available) return VXS_OK;

    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    if (budget_bytes && held + bytes > budget_bytes)
        return fail(m, VXS_E_MEMORY, "%s about %s of memory, --memory allows %s", what, size_text(needed, held + bytes),
                    size_text(there, budget_bytes));
    return fail(m, VXS_E_MEMORY, "%s about %s of memory, there are %s left", what, size_text(needed, bytes),
                size_text(there, available));
}

int memory_has_room(uint64_t bytes)
{
    void *room = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED) return 0;
    munmap(room, bytes);
    return 1;
}
