/* Features of the processor, for loops that are compiled for several instruction sets. All variants must give the same bits.
 *
 * Single functions get a target with the macros below. Files whose vectors have the width of the processor's vectors are compiled
 * once for each instruction set (level.c in the Makefile, baker/columns/sparse/lanes.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CPU_H
#define CPU_H

#include <stdlib.h>
#include <string.h>

enum { CPU_SSE2, CPU_AVX2, CPU_AVX512 }; /* the last with its parts F, DQ and VL */

/* CPU_TARGET_AVX2 compiles a function for AVX2; ALWAYS_INLINE marks functions that are inlined into it. */
#define ALWAYS_INLINE   inline __attribute__((always_inline))
#define CPU_TARGET_AVX2 __attribute__((target("avx2")))

/* The best level of the processor. CPU_SSE2 also means: not x86-64. */
static inline int cpu_level_of_machine(void)
{
#ifdef __x86_64__
    const int wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    return !__builtin_cpu_supports("avx2") ? CPU_SSE2 : wide ? CPU_AVX512 : CPU_AVX2;
#else
    return CPU_SSE2;
#endif
}

/* The same, but limited by VXS_CPU=sse2 or VXS_CPU=avx2 in the environment, for tests. Call it once, not in a loop. */
static inline int cpu_level(void)
{
    const char *most  = getenv("VXS_CPU");
    const int   level = cpu_level_of_machine();
    if (most && !strcmp(most, "sse2")) return CPU_SSE2;
    return most && !strcmp(most, "avx2") && level > CPU_AVX2 ? CPU_AVX2 : level;
}

#endif
