/* The operating system of native builds, Linux: memory.h, clock.h, pages.h, terminal.h, system.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/xattr.h>
#include <unistd.h>

#include "baker/base/clock.h"
#include "baker/base/integer.h"
#include "baker/base/memory.h"
#include "baker/base/pages.h"
#include "baker/base/system.h"
#include "baker/base/terminal.h"

void system_sort(void *items, size_t count, size_t item_bytes, int (*compare)(const void *a, const void *b, void *user), void *user)
{
    qsort_r(items, count, item_bytes, compare, user);
}

uint32_t system_processors(void)
{
    cpu_set_t allowed;
    int       count = sched_getaffinity(0, sizeof allowed, &allowed) ? 1 : CPU_COUNT(&allowed);
    return count < 1 ? 1 : (uint32_t)count;
}

int system_program(char *path, size_t room)
{
    ssize_t length = readlink("/proc/self/exe", path, room);
    if (length <= 0 || (size_t)length >= room) return 0;
    path[length] = '\0';
    return 1;
}

/* memory ---------------------------------------------------------------------------------------------------------------------- */

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

void memory_peak_reset(void)
{
    FILE *f = fopen("/proc/self/clear_refs", "w");
    if (!f) return;
    fputs("5", f); /* resets the high-water mark, see proc(5) */
    fclose(f);
}

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

uint64_t memory_peak_bytes(void)
{
    return 1024 * number_in("/proc/self", "status", "VmHWM:", 0);
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

int memory_has_room(uint64_t bytes)
{
    void *room = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED) return 0;
    munmap(room, bytes);
    return 1;
}

void *pages_alloc(size_t size_bytes)
{
    const size_t page = (size_t)2 << 20;
    if (size_bytes < page) return malloc(size_bytes);
    if (size_bytes > SIZE_MAX - page) return NULL;
    size_t size   = (size_bytes + page - 1) / page * page;
    void  *memory = aligned_alloc(page, size);
    if (memory) madvise(memory, size, MADV_HUGEPAGE); /* only a hint: failure costs time alone */
    return memory;
}

/* files ----------------------------------------------------------------------------------------------------------------------- */

int standard_output_is_broken(void)
{
    struct pollfd p = {.fd = STDOUT_FILENO, .events = POLLOUT};
    return poll(&p, 1, 0) == 1 && p.revents & (POLLERR | POLLHUP);
}

/* limit of Linux */
enum { ATTRIBUTE_BYTES_MAX = 65536 };

static const char access_list[] = "system.posix_acl_access";

int system_copy_attributes(const char *path, int descriptor)
{
    char    names[ATTRIBUTE_BYTES_MAX], value[ATTRIBUTE_BYTES_MAX];
    ssize_t size   = listxattr(path, names, sizeof names);
    int     listed = 0;
    if (size < 0) return errno == ENOTSUP || errno == ENOSYS ? 0 : errno;
    for (const char *name = names; name < names + size; name += strlen(name) + 1) {
        if (strncmp(name, "user.", 5) && strcmp(name, access_list)) continue;
        ssize_t length = getxattr(path, name, value, sizeof value);
        if (length < 0 || fsetxattr(descriptor, name, value, (size_t)length, 0)) return errno;
        listed |= !strcmp(name, access_list);
    }
    /* the new file may have inherited an access list from its folder */
    int inherited = !listed && fgetxattr(descriptor, access_list, NULL, 0) >= 0;
    return inherited && fremovexattr(descriptor, access_list) ? errno : 0;
}

/* progress: on a terminal alone ----------------------------------------------------------------------------------------------- */

int system_shows_progress(void)
{
    return 0;
}

void system_show_progress(double share, const char *doing)
{
    (void)share;
    (void)doing;
}
