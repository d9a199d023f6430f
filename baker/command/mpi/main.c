/* vxs-mpi bake: vxs bake by all ranks of an MPI job (docs/farm.md).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <mpi.h>
#include <stdio.h>
#include <string.h>

#include "baker/base/run_context.h"
#include "baker/base/version.h"
#include "baker/command/commands.h"
#include "baker/command/mpi/ranks.h"
#include "baker/command/options/options.h"
#include "baker/command/process/process.h"

static int usage(void)
{
    run_context m = {0};
    return command_end(&m, fail(&m, VXS_E_ARGUMENT, "usage: mpirun -n N vxs-mpi bake SCENE -o OUT.vxs [options of vxs bake]"));
}

static int run(int rank, int ranks, int argc, char **argv)
{
    if (argc == 2 && !strcmp(argv[1], "--version")) return rank ? 0 : printf("vxs-mpi %s\n", VXS_VERSION) < 0;
    if (argc < 2 || strcmp(argv[1], "bake") != 0) return rank ? 0 : usage();
    if (ranks == 1) return cmd_bake(argc - 1, argv + 1);
    return rank ? bake_other(argc - 1, argv + 1) : bake_first(ranks, argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    int provided, rank, ranks;
    process_begin();
    MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    if (provided < MPI_THREAD_SERIALIZED) {
        if (!rank) fprintf(stderr, "vxs: error: this MPI lets one thread alone call it: expected MPI_THREAD_SERIALIZED\n");
        MPI_Abort(MPI_COMM_WORLD, exit_status(VXS_E_PROGRAM));
    }
    int status = run(rank, ranks, argc, argv);
    MPI_Finalize();
    return status;
}
