/* Included before each C++ file of WebAssembly with threads. clang 14 stores what a `catch` looks for in a variable of the C++ library, as
 * if all threads shared it. Declared here before clang does, it is the thread's own, as in that library.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THREAD_EXCEPTIONS_H
#define THREAD_EXCEPTIONS_H

extern "C" {
struct caught_in_thread {
    int         index;
    const void *types;
    int         selector;
};
extern __thread caught_in_thread __wasm_lpad_context;
}

/* An unused declaration would not reach the compiler's later passes. */
static inline __attribute__((used)) const void *caught_here()
{
    return &__wasm_lpad_context;
}

#endif
