/* Temporary files for a signal handler; see temporary_files.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/temporary_files.h"

#include <string.h>
#include <unistd.h>

enum { SLOT_FREE, SLOT_TAKEN, SLOT_PENDING };

int temporary_files_remember(temporary_files *t, const char *name)
{
    if (strlen(name) >= PATH_MAX) return 0;
    for (int n = 0; n < TEMPORARY_FILES_MAX; n++) {
        int state = SLOT_FREE;
        if (!atomic_compare_exchange_strong(&t->slots[n].state, &state, SLOT_TAKEN)) continue;
        strcpy(t->slots[n].name, name);
        atomic_store(&t->slots[n].state, SLOT_PENDING);
        return n + 1;
    }
    return 0;
}

void temporary_files_forget(temporary_files *t, int slot)
{
    if (slot) atomic_store(&t->slots[slot - 1].state, SLOT_FREE);
}

void temporary_files_remove(temporary_files *t)
{
    for (int n = 0; n < TEMPORARY_FILES_MAX; n++)
        if (atomic_load(&t->slots[n].state) == SLOT_PENDING) unlink(t->slots[n].name);
}
