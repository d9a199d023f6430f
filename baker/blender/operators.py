# What the add-on's operators have in common: errors become one sentence, and long work runs beside the window.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import time
from typing import Any, Iterator

import bpy
from bpy.types import Context, Event

from .command import Failed


class Action:
    """An operator. Its work(context) returns () in the end, or is a generator that pauses now and then, and yields the seconds to wait."""

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.scene is not None and not context.window_manager.vxs.is_running

    def fail(self, state: Any, text: str) -> None:
        self.report({"INFO" if state.is_cancelled else "ERROR"}, text)  # what the user asked for is no fault

    def steps(self, context: Context) -> Iterator[float]:
        """The work from its beginning to its end; returns what the operator returns."""
        state = context.window_manager.vxs
        state.is_running, state.is_cancelled, state.share, state.doing = True, False, 0.0, ""
        try:
            work = self.work(context)
            for wait in work:
                yield wait
                if state.is_cancelled:
                    work.throw(Failed(f"{self.bl_label}: cancelled"))
        except (Failed, ReferenceError) as error:  # a reference to what the user removed meanwhile
            self.fail(state, str(error))
            return {"CANCELLED"}
        except OSError as error:
            self.fail(state, f"The level cannot be written for vxs: {error.strerror}")
            return {"CANCELLED"}
        finally:
            state.is_running = False
        return {"FINISHED"}

    def execute(self, context: Context) -> set[str]:
        steps, state, printed = self.steps(context), context.window_manager.vxs, 0.0
        while True:
            try:
                time.sleep(next(steps))
            except StopIteration as end:
                return end.value
            if bpy.app.background and state.doing and time.monotonic() > printed + 1.0:
                print(f"vxs: {state.share:4.0%} {state.doing}", flush=True)
                printed = time.monotonic()


class Work(Action):
    """An operator that works beside the window, where there is one."""

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background or not context.window:
            return self.execute(context)
        self.work_left = self.steps(context)
        outcome = self.step()  # from now on it is known to run
        if outcome != {"PASS_THROUGH"}:
            return outcome
        self.timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def step(self) -> set[str]:
        try:
            next(self.work_left)
        except StopIteration as end:
            return end.value
        return {"PASS_THROUGH"}

    def modal(self, context: Context, event: Event) -> set[str]:
        outcome = {"PASS_THROUGH"}
        if event.type == "TIMER":
            outcome = self.step()
            if outcome != {"PASS_THROUGH"}:
                context.window_manager.event_timer_remove(self.timer)
            for area in (area for window in context.window_manager.windows for area in window.screen.areas):
                if area.type == "PROPERTIES" or outcome != {"PASS_THROUGH"}:
                    area.tag_redraw()
        return outcome

    def cancel(self, context: Context) -> None:
        """Blender quits, or opens another file."""
        context.window_manager.event_timer_remove(self.timer)
        self.work_left.close()
