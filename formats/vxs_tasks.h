/* Items shared by tasks on the caller's threads (vxs_parallel in vxs_file.h). Each task repeatedly takes the next item that
 * is not taken, until none is left. So no thread waits while there is work, and a task can keep its own memory from item to
 * item. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_TASKS_H
#define VXS_TASKS_H

#include <stdatomic.h>

#include "vxs_file.h"

enum { VXS_TASKS_MAX = 64 };

/* Zero it, then set count and parallel. */
typedef struct vxs_items {
    uint32_t            count;
    atomic_uint         next;
    const vxs_parallel *parallel; /* NULL: only the caller's thread */
} vxs_items;

/* Take the next item; calls parallel->pause first, if it is set. 0: no item is left. Items are taken in order. */
static inline int vxs_items_next(vxs_items *items, uint32_t *item)
{
    if (items->parallel && items->parallel->pause) items->parallel->pause(items->parallel->user);
    *item = atomic_fetch_add_explicit(&items->next, 1, memory_order_relaxed);
    return *item < items->count;
}

/* End the work: no further item is taken. */
static inline void vxs_items_end(vxs_items *items)
{
    atomic_store_explicit(&items->next, items->count, memory_order_relaxed);
}

/* Number of tasks for so many items: 1..VXS_TASKS_MAX. */
static inline uint32_t vxs_task_count(const vxs_parallel *parallel, uint32_t items)
{
    uint32_t threads = parallel && parallel->run ? parallel->threads : 1;
    if (threads > items) threads = items;
    return threads < 1 ? 1 : threads > VXS_TASKS_MAX ? VXS_TASKS_MAX : threads;
}

/* count  vxs_task_count, or less */
static inline void vxs_tasks_run(const vxs_parallel *parallel, uint32_t count, void (*task)(void *work, uint32_t n), void *work)
{
    if (count == 1)
        task(work, 0);
    else
        parallel->run(parallel->user, count, task, work);
}

#endif
