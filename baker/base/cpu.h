/* What the processor can do, for loops that are compiled for several of them: each has to give the same bits as the plain one.
 *
 * Single functions are given a target below; files whose vectors are as wide as the processor's are compiled once for each (level.c in the
 * Makefile, baker/columns/sparse/lanes.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CPU_H
#define CPU_H

#include <stdlib.h>
#include <string.h>

enum { CPU_SSE2, CPU_AVX2 };

/* A function for AVX2, and what is compiled into it. */
#define ALWAYS_INLINE   inline __attribute__((always_inline))
#define CPU_TARGET_AVX2 __attribute__((target("avx2")))

/* What the processor has of these; CPU_SSE2 also stands for what is no x86-64. */
static inline int cpu_level_of_machine(void)
{
#ifdef __x86_64__
    return __builtin_cpu_supports("avx2") ? CPU_AVX2 : CPU_SSE2;
#else
    return CPU_SSE2;
#endif
}

/* The same, or less with VXS_CPU=sse2 in the environment, for tests. Call it once, not in a loop. */
static inline int cpu_level(void)
{
    const char *most = getenv("VXS_CPU");
    return most && !strcmp(most, "sse2") ? CPU_SSE2 : cpu_level_of_machine();
}

#endif
