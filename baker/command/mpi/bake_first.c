/* Rank 0: it bakes as vxs bake does, and a thread of it speaks with the other ranks; see ranks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "baker/bake/cache/cache_folder.h"
#include "baker/base/array.h"
#include "baker/base/threads.h"
#include "baker/command/commands.h"
#include "baker/command/mpi/ranks.h"
#include "baker/command/mpi/square_scheduler.h"
#include "runtime/vxs.h"

/* Pause between polls for messages: short compared with a square, long compared with a poll. */
enum { LOOK_NANOSECONDS = 200000 };

typedef struct first_rank {
    os_thread thread; /* while it runs, only this thread calls MPI */

    os_mutex         lock;  /* of all below */
    os_signal        event; /* a square was received, or a rank has failed */
    square_scheduler square_scheduler;
    uint32_t         ranks, ended;
    uint8_t         *waits; /* [ranks] 1: it wants a square, and has not been answered */
    int              over;  /* 1: no more squares are needed */
    int              failed_rank;
    end_note         failure; /* the first of another rank */
} first_rank;

/* the MPI thread --------------------------------------------------------------------------------------------------------------- */

static void note_failure(first_rank *f, int rank, const end_note *note)
{
    if (f->failure.result != VXS_OK) return;
    f->failure     = *note;
    f->failed_rank = rank;
}

static void note_no_memory(first_rank *f)
{
    note_failure(f, 0, &(end_note){VXS_E_MEMORY, "out of memory for squares of other ranks"});
}

/* Receive a square and its bytes. Squares that were not requested are received, too, and released. */
static void receive_square(first_rank *f, int rank)
{
    uint64_t head[HEAD_NUMBERS];
    MPI_Recv(head, HEAD_NUMBERS, MPI_UINT64_T, rank, TAG_SQUARE, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    uint64_t  size   = head[HEAD_BYTES];
    vxs_bytes record = {malloc(size + 1), size, size + 1};
    if (!record.data) { /* there is no message that stops a rank while it sends */
        fprintf(stderr, "vxs: error: out of memory for a square of rank %d\n", rank);
        MPI_Abort(MPI_COMM_WORLD, exit_status(VXS_E_MEMORY));
    }
    for (uint64_t at = 0; at < size; at += BYTES_AT_ONCE) {
        uint64_t left = size - at;
        MPI_Recv(record.data + at, left < BYTES_AT_ONCE ? (int)left : BYTES_AT_ONCE, MPI_BYTE, rank, TAG_BYTES, MPI_COMM_WORLD,
                 MPI_STATUS_IGNORE);
    }
    os_lock(&f->lock);
    scheduled_square *s = square_scheduler_deliver(&f->square_scheduler, head[HEAD_NUMBER], (uint32_t)rank);
    if (s)
        *s = (scheduled_square){(uint32_t)rank, 1, head[HEAD_MADE] != 0, {head[HEAD_KEY_LOW], head[HEAD_KEY_HIGH]}, record};
    else
        free(record.data);
    os_wake_all(&f->event);
    os_unlock(&f->lock);
}

static void receive_claim(first_rank *f, int rank)
{
    MPI_Recv(NULL, 0, MPI_BYTE, rank, TAG_CLAIM, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    f->waits[rank] = 1;
}

static void receive_end(first_rank *f, int rank)
{
    end_note note;
    MPI_Recv(&note, sizeof note, MPI_BYTE, rank, TAG_END, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    os_lock(&f->lock);
    f->ended++;
    if (note.result != VXS_OK && note.result != VXS_E_BROKEN_PIPE) note_failure(f, rank, &note);
    os_wake_all(&f->event);
    os_unlock(&f->lock);
}

/* The number of a square for a rank that wants one. 0: it has to wait. */
static int ticket_for(first_rank *f, uint32_t rank, uint64_t *ticket)
{
    os_lock(&f->lock);
    int given = SCHEDULER_GIVEN;
    *ticket   = NO_MORE;
    if (!f->over && f->failure.result == VXS_OK) given = square_scheduler_next(&f->square_scheduler, rank, ticket);
    if (given == SCHEDULER_MEMORY) note_no_memory(f);
    os_unlock(&f->lock);
    return given != SCHEDULER_WAIT;
}

static void answer_claims(first_rank *f)
{
    uint64_t ticket;
    for (uint32_t rank = 1; rank < f->ranks; rank++) {
        if (!f->waits[rank] || !ticket_for(f, rank, &ticket)) continue;
        f->waits[rank] = 0;
        MPI_Send(&ticket, 1, MPI_UINT64_T, (int)rank, TAG_TICKET, MPI_COMM_WORLD);
    }
}

static int receive_one(first_rank *f)
{
    MPI_Status status;
    int        is_there;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &is_there, &status);
    if (!is_there) return 0;
    if (status.MPI_TAG == TAG_SQUARE) receive_square(f, status.MPI_SOURCE);
    if (status.MPI_TAG == TAG_CLAIM) receive_claim(f, status.MPI_SOURCE);
    if (status.MPI_TAG == TAG_END) receive_end(f, status.MPI_SOURCE);
    return 1;
}

static void *speak(void *data)
{
    first_rank *f = data;
    while (f->ended < f->ranks - 1) {
        if (receive_one(f)) continue;
        answer_claims(f);
        nanosleep(&(struct timespec){0, LOOK_NANOSECONDS}, NULL);
    }
    return NULL;
}

/* calls from the bake ---------------------------------------------------------------------------------------------------------- */

static vxs_result failure_of(const first_rank *f, run_context *m)
{
    return fail(m, (vxs_result)f->failure.result, "rank %d: %s", f->failed_rank,
                f->failure.error[0] ? f->failure.error : vxs_result_text((vxs_result)f->failure.result));
}

static vxs_result claim(void *data, uint64_t number, square_action *action, run_context *m)
{
    first_rank *f = data;
    os_lock(&f->lock);
    const scheduled_square *s = square_scheduler_take(&f->square_scheduler, number);
    if (!s) note_no_memory(f);
    if (s) *action = s->rank ? SQUARE_KNOWN : SQUARE_MAKE;
    vxs_result r = f->failure.result == VXS_OK ? VXS_OK : failure_of(f, m);
    os_unlock(&f->lock);
    return r;
}

static vxs_result take(void *data, uint64_t number, const column_key *key, vxs_bytes *record, int *made, run_context *m)
{
    first_rank *f = data;
    vxs_result  r = VXS_OK;
    os_lock(&f->lock);
    while (f->failure.result == VXS_OK && !f->square_scheduler.squares[number].is_here) os_wait(&f->event, &f->lock);
    scheduled_square *s = &f->square_scheduler.squares[number];
    *record             = (vxs_bytes){0};
    *made               = s->made;
    if (f->failure.result != VXS_OK)
        r = failure_of(f, m);
    else if (s->key.low != key->low || s->key.high != key->high)
        r = fail(m, VXS_E_ARGUMENT,
                 "rank %u makes squares of another bake: its scene, its version of vxs, its processor, or its memory differ",
                 s->rank);
    else {
        *record   = s->record;
        s->record = (vxs_bytes){0};
    }
    os_unlock(&f->lock);
    return r;
}

/* the run --------------------------------------------------------------------------------------------------------------------- */

int bake_first(int ranks, int argc, char **argv)
{
    first_rank f = {.ranks = (uint32_t)ranks, .square_scheduler = {.ranks = (uint32_t)ranks}, .waits = calloc((size_t)ranks, 1)};
    if (!f.waits || !os_mutex_init(&f.lock) || !os_signal_init(&f.event) || !os_thread_start(&f.thread, speak, &f)) {
        fprintf(stderr, "vxs: error: rank 0 cannot start the thread that speaks with others\n");
        MPI_Abort(MPI_COMM_WORLD, exit_status(VXS_E_MEMORY));
    }
    square_exchange others = {.data = &f, .adds = 1, .claim = claim, .take = take};
    int             status = cmd_bake_with(&others, argc, argv);
    os_lock(&f.lock);
    f.over = 1;
    os_unlock(&f.lock);
    os_thread_join(f.thread);
    square_scheduler_free(&f.square_scheduler);
    free(f.waits);
    return status;
}
