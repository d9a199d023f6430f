/* What the processor can do, for loops that are compiled for several of them: each has to give the same bits as the plain one.
 *
 * Single functions are given a target below; files whose vectors are as wide as the processor's are compiled once for each (level.c in the
 * Makefile, baker/columns/sparse/lanes.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CPU_H
#define CPU_H

#include <stdlib.h>
#include <string.h>

enum { CPU_SSE2, CPU_AVX2, CPU_AVX512 /* F, BW, DQ and VL */ };

/* A function for one of them, and what is compiled into it. */
#define ALWAYS_INLINE     inline __attribute__((always_inline))
#define CPU_TARGET_AVX2   __attribute__((target("avx2")))
#define CPU_TARGET_AVX512 __attribute__((target("avx2,avx512f,avx512bw,avx512dq,avx512vl")))

/* What the processor has of these; CPU_SSE2 also stands for what is no x86-64. */
static inline int cpu_level_of_machine(void)
{
#ifdef __x86_64__
    if (!__builtin_cpu_supports("avx2")) return CPU_SSE2;
    int wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
    return wide ? CPU_AVX512 : CPU_AVX2;
#else
    return CPU_SSE2;
#endif
}

/* The same, or less where the environment says so, for tests: VXS_CPU=sse2, avx2 or avx512. Ask once, not in a loop. */
static inline int cpu_level(void)
{
    static const char *const names[] = {"sse2", "avx2", "avx512"};
    const char              *most    = getenv("VXS_CPU");
    int                      level   = cpu_level_of_machine();
    for (int n = CPU_SSE2; most && n < level; n++)
        if (!strcmp(most, names[n])) return n;
    return level;
}

#endif
