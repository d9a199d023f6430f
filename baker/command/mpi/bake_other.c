/* A rank that makes squares for rank 0; see ranks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <mpi.h>
#include <stdio.h>
#include <string.h>

#include "baker/command/mpi/ranks.h"
#include "baker/command/options/bake_arguments.h"

typedef struct other_rank {
    int      has_ticket;
    uint64_t ticket;
} other_rank;

static vxs_result claim(void *data, uint64_t number, square_action *action, run_context *m)
{
    other_rank *of = data;
    (void)m;
    if (!of->has_ticket) {
        MPI_Send(NULL, 0, MPI_BYTE, 0, TAG_CLAIM, MPI_COMM_WORLD);
        MPI_Recv(&of->ticket, 1, MPI_UINT64_T, 0, TAG_TICKET, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        of->has_ticket = 1;
    }
    if (of->ticket == NO_MORE) return VXS_E_BROKEN_PIPE;
    *action = of->ticket == number ? SQUARE_MAKE : SQUARE_LEAVE;
    if (*action == SQUARE_MAKE) of->has_ticket = 0;
    return VXS_OK;
}

static vxs_result give(void *data, uint64_t number, const column_key *key, const vxs_bytes *record, int made, run_context *m)
{
    uint64_t head[HEAD_NUMBERS] = {number, (uint64_t)made, key->low, key->high, record->size_bytes};
    (void)data;
    (void)m;
    MPI_Send(head, HEAD_NUMBERS, MPI_UINT64_T, 0, TAG_SQUARE, MPI_COMM_WORLD);
    for (uint64_t at = 0; at < record->size_bytes; at += BYTES_AT_ONCE) {
        uint64_t left = record->size_bytes - at;
        MPI_Send(record->data + at, left < BYTES_AT_ONCE ? (int)left : BYTES_AT_ONCE, MPI_BYTE, 0, TAG_BYTES, MPI_COMM_WORLD);
    }
    return VXS_OK;
}

/* The same bake as rank 0's, from the same command line, but without outputs and messages. */
static vxs_result bake_quietly(int argc, char **argv, run_context *m)
{
    other_rank      of     = {0};
    square_exchange zero   = {.data = &of, .claim = claim, .give = give};
    bake_report     report = {0};
    bake_arguments  a;
    int             help_shown = 0;
    bake_arguments_init(&a, "bake", "", "", 0);
    vxs_result r = options_parse(&a.line, argc, argv, &help_shown, m);
    if (r == VXS_OK && !help_shown) {
        a.o.others      = &zero;
        a.o.output_path = a.o.page_path = NULL;
        a.o.if_changed                  = 0;
        r                               = bake_arguments_check(&a, m);
        if (r == VXS_OK) r = bake(&a.o, NULL, &report, m);
        bake_report_free(&report);
    }
    options_free(&a.line);
    return r;
}

int bake_other(int argc, char **argv)
{
    run_context m    = {0};
    end_note    note = {0};
    if (!freopen("/dev/null", "w", stdout)) fail(&m, VXS_E_WRITE, "cannot open /dev/null"); /* help is rank 0's to show */
    note.result = m.error[0] ? VXS_E_WRITE : bake_quietly(argc, argv, &m);
    memcpy(note.error, m.error, sizeof note.error);
    MPI_Send(&note, sizeof note, MPI_BYTE, 0, TAG_END, MPI_COMM_WORLD);
    run_free(&m);
    return 0;
}
