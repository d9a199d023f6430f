/* What a fuzz program is: one function, called with bytes that come from anywhere.
 *
 *     make fuzz        build/fuzz/tests/fuzz/fuzz_NAME: libFuzzer's loop around it, by clang with sanitizers; seconds=N runs each
 *     (run.py) make check-unit  build/CONFIG/tests/fuzz/fuzz_NAME: each file of build/corpus/NAME once (replay.c)
 *
 * The corpus is an archive in tests/fuzz/corpus (corpus.py). An input that showed a fault is added with the repair:
 *
 *     make fuzz-pack corpus=NAME inputs=build/fuzz/found/NAME
 *
 * It returns when the bytes are refused or used up, and ends the process when something is wrong.
 * mutate_NAME.c, where there is one, changes bytes in ways that libFuzzer would hardly find; it is no part of a replay. Programs
 * for .vxs files share mutate_vxs.c and the archive vxs.tar.xz, to which NAME.tar.xz is a link.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

/* data  [size] of their own, so that a byte read beyond them is seen.   Returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Change data[size], which has room for size_max bytes, by chance; the same seed, the same change. Returns the new size. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned int seed);

/* libFuzzer's own changes, for a part of the bytes. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t size_max);

#ifdef __cplusplus
}
#endif

/* An assertion that no build leaves out. */
#define FUZZ_CHECK(condition) ((condition) ? (void)0 : (fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition), abort()))

#endif
