/* Attributes of a replaced file; see replaced_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/replaced_file.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "baker/base/system.h"

vxs_result replaced_file_check(const char *path, const struct stat *old, run_context *m)
{
    unsigned long links = old->st_nlink;
    if (!m->force && !(old->st_mode & S_IWUSR))
        return fail(m, VXS_E_WRITE, "%s: cannot write: it is read-only: --force replaces it all the same", path);
    if (!m->force && links > 1)
        return fail(m, VXS_E_WRITE, "%s: cannot write: it is one of %lu hard links to a file: --force replaces this one alone",
                    path, links);
    if (links > 1) warn(m, "%s: was one of %lu hard links to a file: the others keep the old one", path, links);
    return run_check(m);
}

static vxs_result not_kept(const char *path, const char *what, int error, run_context *m)
{
    if (!m->force)
        return fail(m, VXS_E_WRITE, "%s: cannot write: its %s cannot be kept (%s): --force replaces it without", path, what,
                    strerror(error));
    warn(m, "%s: its %s cannot be kept (%s)", path, what, strerror(error));
    return run_check(m);
}

vxs_result replaced_file_keep(const char *path, const struct stat *old, int descriptor, run_context *m)
{
    struct stat now;
    vxs_result  r     = VXS_OK;
    mode_t      kept  = 0777; /* without set-user-ID and similar bits: they apply to the old bytes, and systems clear them on each
                             write */
    int         error = fstat(descriptor, &now) ? errno : 0;
    if (!error && (now.st_uid != old->st_uid || now.st_gid != old->st_gid) && fchown(descriptor, old->st_uid, old->st_gid))
        r = not_kept(path, "owner and group", errno, m);
    int lost = system_copy_attributes(path, descriptor);
    if (lost && r == VXS_OK) r = not_kept(path, "attributes", lost, m);

    /* last, because the calls above change the permissions, and a read-only file accepts no attributes */
    if (!error && fstat(descriptor, &now)) error = errno;
    if (!error && ((now.st_mode ^ old->st_mode) & kept) && fchmod(descriptor, old->st_mode & kept)) error = errno;
    if (error && r == VXS_OK) r = not_kept(path, "permissions", error, m);
    return r;
}
