/* Parallel loop with messages; see parallel_runs.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/parallel_runs.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"

typedef struct piece {
    vxs_result  result;
    run_context own;
} piece;

typedef struct pieces {
    piece     *all;
    atomic_int failed; /* 1: a piece has failed: those that have not begun are not needed, if they come later */
    run_piece *run;
    void      *user;
} pieces;

/* Pieces begin in order, so all before a failed one have begun. */
static void run_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    pieces *p = user;
    for (size_t n = begin; n < end; n++) {
        if (atomic_load(&p->failed)) continue;
        p->all[n].result = p->run(p->user, n, worker, &p->all[n].own);
        if (p->all[n].result != VXS_OK) atomic_store(&p->failed, 1);
    }
}

static vxs_result run_in_turn(pieces *p, size_t count, run_context *m)
{
    vxs_result r = VXS_OK;
    for (size_t n = 0; n < count && r == VXS_OK; n++) r = p->run(p->user, n, 0, m);
    return r;
}

vxs_result parallel_runs(uint32_t threads, size_t count, run_piece *run, void *user, run_context *m)
{
    pieces     p = {.run = run, .user = user};
    vxs_result r = VXS_OK;
    if (threads <= 1 || count <= 1) return run_in_turn(&p, count, m);
    if (!(p.all = calloc(count, sizeof *p.all))) return fail(m, VXS_E_MEMORY, "out of memory for the messages of %zu parts", count);
    for (size_t n = 0; n < count; n++) {
        run_context *own   = &p.all[n].own;
        *own               = *m;
        own->warnings      = NULL;
        own->log           = NULL;
        own->warning_count = own->warning_capacity = 0;
    }
    parallel_for(threads, count, 1, run_some, &p);
    for (size_t n = 0; n < count; n++) {
        run_context *own = &p.all[n].own;
        for (size_t k = 0; k < own->warning_count && r == VXS_OK; k++) warn(m, "%s", own->warnings[k]);
        if (r == VXS_OK && own->error[0] && !m->error[0]) memcpy(m->error, own->error, sizeof m->error);
        if (r == VXS_OK) r = p.all[n].result;
        run_free(own);
    }
    free(p.all);
    return r;
}
