/* The machine that measurements come from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MACHINE_H
#define MACHINE_H

#include <stdint.h>

typedef struct bench_machine {
    char    *processor;    /* model; owned, like the other texts */
    uint64_t cores;        /* that this process may use */
    uint64_t memory_bytes; /* of the machine */
    char    *system;       /* kernel and C library */
    char    *renderer;     /* OpenGL's GL_RENDERER */
} bench_machine;

/* Fill all but the renderer.
 * Returns 0 when out of memory; released with machine_free either way. */
int machine_describe(bench_machine *machine);

/* Accepts a zeroed object. */
void machine_free(bench_machine *machine);

#endif
