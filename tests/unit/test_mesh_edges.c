/* Items by key, and the edges of triangles, against plain ways to the same: in order, complete, and alike at any thread count
 * (baker/base/group.h, baker/casters/mesh_edges.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/group.h"
#include "baker/base/random.h"
#include "baker/casters/mesh_edges.h" /* before cmocka, whose fail() is a macro */

#include <cmocka.h>

static void *allocated(size_t count, size_t size)
{
    void *p = calloc(count + 1, size);
    assert_non_null(p);
    return p;
}

/* Each member comes after the one before it: by key, then by number. So it is there once. */
static void check_groups(size_t count, size_t key_count, uint32_t threads)
{
    rng       r      = rng_split(7, count + key_count);
    uint32_t *key_of = allocated(count, sizeof *key_of), *members = allocated(count, sizeof *members);
    uint32_t *first = allocated(key_count, sizeof *first);
    for (size_t n = 0; n < count; n++) key_of[n] = rng_below(&r, (uint32_t)key_count);
    assert_int_equal(group_by_key(first, members, key_of, count, key_count, threads), VXS_OK);
    assert_int_equal(first[0], 0);
    assert_int_equal(first[key_count], count);
    for (size_t k = 0; k < key_count; k++)
        for (uint32_t i = first[k]; i < first[k + 1]; i++) {
            assert_true(members[i] < count);
            assert_int_equal(key_of[members[i]], k);
            if (i > first[k]) assert_true(members[i] > members[i - 1]);
        }
    free(key_of);
    free(members);
    free(first);
}

static void test_groups(void **state)
{
    static const size_t counts[] = {0, 1, 63, 1000, 100000}, keys[] = {1, 2, 255, 256, 257, 1000, 70000};
    (void)state;
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (size_t k = 0; k < sizeof keys / sizeof *keys; k++)
            for (uint32_t threads = 1; threads <= 4; threads += 3) check_groups(counts[i], keys[k], threads);
}

enum { SIDE = 160, FAN = 3000, TRIANGLES = 2 * SIDE * SIDE + 2 * FAN, VERTICES = (SIDE + 1) * (SIDE + 1) + FAN + 3 };

/* A grid; triangles about one corner, more than are sorted by hand; and as many about one edge. Three components. */
static uint32_t *make_mesh(void)
{
    uint32_t *indices = allocated(3 * TRIANGLES, sizeof *indices), *to = indices;
    uint32_t  row = SIDE + 1, corner = row * row, edge = corner + 1;
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++) {
            uint32_t       a       = y * row + x;
            const uint32_t quad[6] = {a, a + 1, a + row, a + row, a + 1, a + row + 1};
            memcpy(to, quad, sizeof quad);
            to += 6;
        }
    for (uint32_t n = 0; n < 2 * FAN; n++, to += 3) {
        const uint32_t k = n % FAN, about_corner[3] = {edge + 2 + k, corner, edge + 2 + (k * 7 + 1) % FAN};
        const uint32_t about_edge[3] = {n & 1 ? edge : edge + 1, n & 1 ? edge + 1 : edge, k};
        memcpy(to, n < FAN ? about_corner : about_edge, sizeof about_edge);
    }
    return indices;
}

typedef struct walk {
    const uint32_t *indices, *sorted;
    uint8_t        *seen; /* [3 * TRIANGLES] by half-edge */
} walk;

static void see(void *user, uint32_t begin, uint32_t end)
{
    const walk *w = user;
    for (uint32_t i = begin; i < end; i++) {
        if (!mesh_same_edge(w->indices, w->sorted[begin], w->sorted[i])) continue;
        __atomic_fetch_add(&w->seen[w->sorted[i]], 1, __ATOMIC_RELAXED);
    }
}

static void test_edges(void **state)
{
    uint32_t *indices = make_mesh(), *sorted = allocated(3 * TRIANGLES, sizeof *sorted);
    uint32_t *one = allocated(TRIANGLES, sizeof *one), *many = allocated(TRIANGLES, sizeof *many);
    uint8_t  *seen = allocated(3 * TRIANGLES, 1);
    walk      w    = {indices, sorted, seen};
    (void)state;
    for (uint32_t threads = 1; threads <= 5; threads += 4) {
        uint32_t *components = threads == 1 ? one : many;
        assert_int_equal(mesh_sort_edges(sorted, indices, TRIANGLES, VERTICES, threads), VXS_OK);
        for (size_t i = 1; i < 3 * TRIANGLES; i++) {
            uint32_t h = sorted[i - 1], g = sorted[i];
            uint32_t low = mesh_edge_low(indices, h), high = mesh_edge_high(indices, h);
            uint32_t low2 = mesh_edge_low(indices, g), high2 = mesh_edge_high(indices, g);
            assert_true(low < low2 || (low == low2 && (high < high2 || (high == high2 && h < g))));
        }
        memset(seen, 0, 3 * TRIANGLES);
        mesh_for_each_edge(indices, sorted, TRIANGLES, threads, see, &w);
        for (size_t h = 0; h < 3 * TRIANGLES; h++) assert_int_equal(seen[h], 1);
        size_t count = mesh_find_components(components, sorted, indices, TRIANGLES, threads);
        assert_int_equal(count, 1 + components[TRIANGLES - 1]);
        for (size_t t = 0; t < 2 * SIDE * SIDE; t++) assert_int_equal(components[t], 0);
    }
    assert_memory_equal(one, many, TRIANGLES * sizeof *one);
    free(indices);
    free(sorted);
    free(one);
    free(many);
    free(seen);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_groups),
        cmocka_unit_test(test_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
