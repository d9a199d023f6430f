/* Time, memory and progress of a bake; see context.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/context.h"

#include <math.h>
#include <stdio.h>

#include "baker/base/clock.h"
#include "baker/base/integer.h"
#include "baker/base/memory.h"
#include "baker/base/run_control.h"
#include "baker/base/text.h"

static const char *const stage_names[STAGE_COUNT] = {"load",   "solids",   "plan",  "gl",     "maps",  "pyramid", "masks",
                                                     "insert", "compress", "merge", "encode", "smoke", "write"};

const char *bake_stage_name(bake_stage stage)
{
    return stage_names[stage];
}

typedef struct memory_use {
    uint64_t peak, held;
} memory_use;

static memory_use memory_now(const bake_context *ctx)
{
    return ctx->unmeasured ? (memory_use){0} : (memory_use){memory_peak_bytes(), memory_held_bytes()};
}

/* Does not reset the system's high-water mark, because the program around the baker may use it. For a stage that does not raise the
 * peak, only the memory at its begin and end is known. */
static uint64_t stage_peak(const bake_context *ctx, memory_use now)
{
    return now.peak > ctx->past_peak ? now.peak : max_u64(ctx->held_bytes, now.held);
}

static void note_peak(bake_context *ctx, bake_stage stage, uint64_t peak_bytes)
{
    stage_report *s = &ctx->stage[stage];
    if (peak_bytes > s->peak_bytes) s->peak_bytes = peak_bytes;
    if (stage < STAGE_COUNT && peak_bytes > ctx->peak_bytes) ctx->peak_bytes = peak_bytes;
}

static void enter(bake_context *ctx, bake_stage stage, memory_use now)
{
    ctx->at          = stage;
    ctx->held_bytes  = now.held;
    ctx->past_peak   = now.peak;
    ctx->stage_since = stage == STAGE_NONE ? 0 : clock_seconds();
}

void stage_begin(bake_context *ctx, bake_stage stage)
{
    const int  ends = ctx->stage_since > 0;
    memory_use now  = ends || stage != STAGE_NONE ? memory_now(ctx) : (memory_use){0};
    if (ends) {
        ctx->stage[ctx->at].seconds += clock_seconds() - ctx->stage_since;
        note_peak(ctx, ctx->at, stage_peak(ctx, now));
    }
    enter(ctx, stage, now);
}

void stage_begin_after(bake_context *ctx, bake_stage stage, bake_stage first, const double *seconds, uint32_t count)
{
    double     wall = clock_seconds() - ctx->stage_since, all = 0;
    memory_use now = memory_now(ctx);
    for (uint32_t n = 0; n < count; n++) all += seconds[n];
    for (uint32_t n = 0; n < count; n++) {
        if (all > 0 && seconds[n] <= 0) continue;
        ctx->stage[first + n].seconds += all > 0 ? wall * seconds[n] / all : wall / count;
        note_peak(ctx, (bake_stage)(first + n), stage_peak(ctx, now));
    }
    enter(ctx, stage, now);
}

vxs_result context_check(const bake_context *ctx)
{
    char budget[32], held[32];
    run_control_wait();
    if (run_control_is_cancelled()) return fail(ctx->run, VXS_E_INTERRUPTED, "the bake of '%s' was given up", ctx->subject);
    if (!ctx->memory_bytes || ctx->peak_bytes <= ctx->memory_bytes) return VXS_OK;
    return fail(ctx->run, VXS_E_MEMORY, "--memory %s is too little for '%s': the bake has come to hold %s, and is given up",
                size_text(budget, ctx->memory_bytes), ctx->subject, size_text(held, ctx->peak_bytes));
}

int context_has_memory(const bake_context *ctx)
{
    return !ctx->memory_bytes || memory_held_bytes() <= ctx->memory_bytes;
}

void steps_begin(bake_context *ctx, uint32_t steps, double seconds_each, const char *doing)
{
    int first_of_all = ctx->steps == 0;
    snprintf(ctx->doing, sizeof ctx->doing, "%s", doing);
    ctx->steps        = steps;
    ctx->steps_done   = 0;
    ctx->step_seconds = seconds_each;
    if (first_of_all) /* always shown, even shortly after the line before it */
        watch_say(ctx->watch, "%s 1 of %u", ctx->doing, steps);
    else
        step_part(ctx, 0);
}

void step_part(bake_context *ctx, double part)
{
    if (!ctx->watch || !(ctx->total_seconds > 0) || ctx->steps_done >= ctx->steps) return;
    double share = fmin(1, (ctx->past_seconds + part * ctx->step_seconds) / ctx->total_seconds);
    watch_share(ctx->watch, share, ctx->begun, "%s %u of %u", ctx->doing, ctx->steps_done + 1, ctx->steps);
}

void steps_done(bake_context *ctx, uint32_t steps)
{
    ctx->steps_done += steps;
    ctx->past_seconds += steps * ctx->step_seconds;
    step_part(ctx, 0);
}
