/* A stream that threads read and decode for, while others look up: what the sanitizer of threads has to see, and that a frame is a
 * boundary for all of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before the baker, which has a type of a name that is a parameter here */

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

#include "baker/base/parallel.h"
#include "baker/coding/blocks/blocks.h" /* before cmocka, whose fail() is a macro */
#include "tests/unit/repeats.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "stream_sample.h"

enum { READERS = 4, LOOKUPS = 40 };

typedef struct world {
    stream_sample    sample;
    vxs_stream      *stream;
    pthread_rwlock_t frame; /* held for writing during a frame */
    atomic_int       ended;
    atomic_uint      full, coarse, wrong;
} world;

typedef struct reader {
    world    *of;
    uint64_t  seed;
    pthread_t thread;
} reader;

/* As stream_check_light, but cmocka's asserts belong to the main thread. */
static void *look_up(void *work)
{
    reader *me = work;
    world  *w  = me->of;
    rng     r  = {me->seed};
    while (!atomic_load(&w->ended)) {
        pthread_rwlock_rdlock(&w->frame);
        for (int n = 0; n < LOOKUPS; n++) {
            uint32_t               light = rng_below(&r, w->sample.light_count);
            const vxs_baked_light *here = vxs_stream_light(w->stream, light), *whole = vxs_asset_light(w->sample.full, light);
            double                 point[3];
            int                    width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
            stream_random_point(&whole->light, &r, point);
            int   full  = vxs_lookup_is_full(here, point, NULL, vxs_box(width_px));
            float found = vxs_lookup(here, point, NULL, vxs_box(width_px));
            atomic_fetch_add(&w->wrong,
                             found != vxs_lookup(full ? whole : &w->sample.coarse[light], point, NULL, vxs_box(width_px)));
            atomic_fetch_add(full ? &w->full : &w->coarse, 1);
        }
        pthread_rwlock_unlock(&w->frame);
    }
    return NULL;
}

/* The eye jumps about, with too little memory for all. */
static void fly(world *w, uint32_t frames, uint32_t *appeared)
{
    rng r = {1};
    for (uint32_t n = 0; n < frames; n++) {
        vxs_stream_status status = {.struct_size = sizeof status};
        double            at[3];
        stream_random_point(&vxs_asset_light(w->sample.full, rng_below(&r, w->sample.light_count))->light, &r, at);
        vxs_stream_focus eye = vxs_stream_camera(at, 0);
        pthread_rwlock_wrlock(&w->frame);
        assert_int_equal(vxs_stream_frame(w->stream, &eye, 1, &status), VXS_OK);
        pthread_rwlock_unlock(&w->frame);
        *appeared += status.appeared;
        if (n % 4 == 0) vxs_stream_wait(w->stream);
    }
}

static void check_threads(vxs_stream_desc *desc)
{
    static world w;
    reader       readers[READERS];
    uint32_t     appeared = 0;
    memset(&w, 0, sizeof w);
    stream_sample_init(&w.sample, 1);
    desc->struct_size  = sizeof *desc;
    desc->bytes        = w.sample.file.data;
    desc->size_bytes   = w.sample.file.size_bytes;
    desc->budget_bytes = stream_least_budget(*desc) + 800000;
    assert_int_equal(vxs_stream_open(&w.stream, desc), VXS_OK);
    pthread_rwlockattr_t fair; /* by default readers may keep a writer out for good */
    pthread_rwlockattr_init(&fair);
    pthread_rwlockattr_setkind_np(&fair, PTHREAD_RWLOCK_PREFER_WRITER_NONRECURSIVE_NP);
    assert_int_equal(pthread_rwlock_init(&w.frame, &fair), 0);
    for (uint64_t n = 0; n < READERS; n++) {
        readers[n] = (reader){.of = &w, .seed = n};
        assert_int_equal(pthread_create(&readers[n].thread, NULL, look_up, &readers[n]), 0);
    }
    fly(&w, repeats(150, 2000), &appeared);
    atomic_store(&w.ended, 1);
    for (int n = 0; n < READERS; n++) pthread_join(readers[n].thread, NULL);
    assert_int_equal(w.wrong, 0);
    assert_in_range(w.full, 100, UINT32_MAX);
    assert_in_range(w.coarse, 100, UINT32_MAX);
    assert_in_range(appeared, 20, UINT32_MAX);
    vxs_stream_close(w.stream);
    pthread_rwlock_destroy(&w.frame);
    stream_sample_free(&w.sample);
}

static void test_own_threads(void **state)
{
    (void)state;
    vxs_stream_desc desc = {.threads = 2};
    check_threads(&desc);
}

/* Threads of the caller's, one for each job. */
typedef struct job_thread {
    void (*run)(void *job);
    void *job;
} job_thread;

static void *run_job_thread(void *work)
{
    job_thread t = *(job_thread *)work;
    free(work);
    t.run(t.job);
    return NULL;
}

static void submit_to_thread(void *user, void (*run)(void *job), void *job)
{
    job_thread *t = malloc(sizeof *t);
    pthread_t   thread;
    (void)user;
    *t = (job_thread){run, job};
    if (pthread_create(&thread, NULL, run_job_thread, t)) abort();
    pthread_detach(thread);
}

static void test_submitted_jobs(void **state)
{
    (void)state;
    vxs_stream_desc desc = {.threads = 2, .submit = submit_to_thread};
    check_threads(&desc);
}

/* Many streams that are closed while they are busy. */
static void test_early_close(void **state)
{
    (void)state;
    stream_sample s;
    stream_sample_init(&s, 2);
    for (uint32_t n = 0; n < repeats(20, 300); n++) {
        vxs_stream     *stream;
        vxs_stream_desc desc = stream_desc_of(&s, 32 << 20);
        desc.threads         = 2;
        desc.submit          = n & 1 ? submit_to_thread : NULL;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        for (uint32_t frame = 0; frame < n % 4; frame++) vxs_stream_frame(stream, &stream_all, 1, NULL);
        vxs_stream_close(stream);
    }
    stream_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_own_threads),
        cmocka_unit_test(test_submitted_jobs),
        cmocka_unit_test(test_early_close),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
