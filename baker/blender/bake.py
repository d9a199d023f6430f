# The operators that bake: the level is written here and now, vxs runs beside Blender.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

import json
import os
import tempfile
import time
from types import SimpleNamespace
from typing import Any, Iterable

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import settings
from .command import Run, VxsMissing, bake_arguments, find_vxs
from .level import finish_edits, write_level
from .messages import plain, tell, tell_left_out, tell_warnings, things_named

AS_SCENE = (("SCENE", "As the Scene", "As in the render properties"),)


class BakeFailed(Exception):
    """The text is one sentence for the user."""


def output_path(scene: bpy.types.Scene, asked: str) -> str:
    """Where the bake goes: asked for, set in the scene, or beside the .blend."""
    saved = bpy.data.filepath
    path = asked or scene.vxs.filepath or ("//" if saved else "")
    if not path or path.startswith("//") and not saved:
        raise BakeFailed("This file was never saved: save it first, or choose an output file in Baked Shadows")
    path = bpy.path.abspath(path)
    if path.endswith(("/", os.sep)):
        path = os.path.join(path, bpy.path.display_name_from_filepath(saved) if saved else "level")
    return os.path.abspath(bpy.path.ensure_ext(path, ".vxs"))


def size_text(count: float) -> str:
    power = 1 + (count >= 2**20) + (count >= 2**30)
    return f"{count / 1024**power:.1f} {' KMG'[power]}iB"


def result_text(report: dict[str, Any], unchanged_bytes: int) -> str:
    lines = [f"{size_text(unchanged_bytes)}, unchanged since the last bake" if unchanged_bytes else
             f"{size_text(report['file_bytes'])}, {report['total_seconds']:.1f} s, {size_text(report['peak_bytes'])} of memory"]
    for light in report["lights"]:
        texel = light["texel_at_casters_m"]["median"] if "texel_at_casters_m" in light else light["texel_m"]
        lines.append(f"{light['name']}: {light['resolution_px']} x {light['resolution_px']} texels of {texel:.3g} m")
    return "\n".join(lines)


class Bake:
    """One bake, from the level to the report. Its temporary folder is gone after finish() or close()."""

    def __init__(self, context: bpy.types.Context, chosen: Any, output: str) -> None:
        self.output, self.vxs, self.unchanged_bytes = output, find_vxs(context), 0
        self.folder = tempfile.TemporaryDirectory(prefix="vxs_", ignore_cleanup_errors=True)
        try:
            finish_edits(context)
            path = os.path.join(self.folder.name, "level.glb")
            self.level = write_level(context.evaluated_depsgraph_get(), context.scene, path, chosen.region)
            if not self.level.instances:
                raise BakeFailed("Nothing casts shadows: no object with a surface is shown, rendered, and not left out")
            if not self.level.lights:
                areas = [note for note in self.level.notes if note.startswith("light ")]
                raise BakeFailed((areas or ["No light is baked: add a sun, point or spot light that is rendered, with Bake Shadows on"])[0])
            self.report = os.path.join(self.folder.name, "report.json")
            self.arguments = bake_arguments(context, chosen, self.level.lights, path, output, self.report)
            self.run = Run(self.vxs, self.arguments)
        except BaseException:
            self.folder.cleanup()
            raise

    def step(self, state: Any) -> bool:
        """Take in what vxs printed. True while it runs."""
        if state.is_cancelled:
            self.run.cancel()
        self.status, progress = self.run.poll()
        state.share = progress.get("share", state.share)
        if "doing" in progress:
            left = progress.get("seconds_left")
            state.doing = progress["doing"].replace(self.level.path, "the level") + (f", {left:.0f} s left" if left is not None else "")
        return self.status is None or self.status == 0 and self.plans()

    def plans(self) -> bool:
        """Start a plan, once, where a bake had nothing to do: it gives the warnings. True when it runs."""
        report = self.read_report()
        if self.unchanged_bytes or not report.get("unchanged"):
            return False
        self.unchanged_bytes = report["file_bytes"]
        self.run.finish()
        self.run = Run(self.vxs, ["plan", *(a for a in self.arguments[1:] if a != "--if-changed")])
        return True

    def read_report(self) -> dict[str, Any]:
        """{} when it is none of this vxs."""
        try:
            with open(self.report, encoding="utf-8") as file:
                report = json.load(file)
            return report if {"warnings", "unchanged"} <= set(report) else {}
        except (OSError, ValueError, TypeError):
            return {}

    def finish(self, state: Any) -> None:
        """Show results, once step() returned False. Raises BakeFailed."""
        try:
            self.run.finish()
            if self.status:
                raise BakeFailed("The bake was cancelled" if self.status == 130 or state.is_cancelled else self.why())
            report = self.read_report()
            if not report:
                raise BakeFailed("vxs gave no report: set the path of vxs in the add-on's preferences")
            state.result, state.filepath = result_text(report, self.unchanged_bytes), self.output
            tell_warnings(state, self.level, report["warnings"])
            tell_left_out(state, self.level)
        finally:
            self.folder.cleanup()

    def why(self) -> str:
        if self.run.errors:
            return plain(self.run.errors[-1], self.level.path)
        return f"vxs was ended by signal {-self.status}" if self.status < 0 else f"vxs failed with status {self.status}"

    def close(self) -> None:
        """Stop, and show nothing."""
        self.run.cancel()
        self.run.finish()
        self.folder.cleanup()


class VXS_OT_bake(bpy.types.Operator):
    bl_idname = "vxs.bake"
    bl_label = "Bake Shadows"
    bl_description = "Bake the shadows of this scene into a .vxs file"

    filepath: StringProperty(name="Output", subtype="FILE_PATH", options={"SKIP_SAVE"})
    resolution: IntProperty(name="Resolution", min=0, max=262144, description="Texels along a side; 0: as the scene", options={"SKIP_SAVE"})
    texel: FloatProperty(name="Texel Size", min=0.0, description="0: as the scene", options={"SKIP_SAVE"})
    region: StringProperty(name="Region", description="Name of an object", options={"SKIP_SAVE"})
    closed: EnumProperty(name="Solids", items=(*AS_SCENE, *settings.CLOSED), options={"SKIP_SAVE"})
    pack: EnumProperty(name="Packing", items=(*AS_SCENE, *settings.PACK), options={"SKIP_SAVE"})
    blend: EnumProperty(name="Blended Materials", items=(*AS_SCENE, *settings.BLEND), options={"SKIP_SAVE"})
    force: BoolProperty(name="Bake Always", description="Also where the file is up to date", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and not context.window_manager.vxs.is_running

    def chosen(self, scene: bpy.types.Scene) -> SimpleNamespace:
        """The scene's settings, less what the caller asks for."""
        own = scene.vxs
        value = SimpleNamespace(detail=own.detail, resolution=own.resolution, texel=own.texel, region=own.region,
                                if_changed=own.if_changed and not self.force)
        for name in ("closed", "pack", "blend"):
            setattr(value, name, getattr(own, name) if getattr(self, name) == "SCENE" else getattr(self, name))
        if self.resolution:
            value.detail, value.resolution = "RESOLUTION", str(self.resolution)
        elif self.texel:
            value.detail, value.texel = "TEXEL", self.texel
        if self.region:
            value.region = scene.objects.get(self.region)
            if not value.region:
                raise BakeFailed(f"There is no object '{self.region}' for the region")
        return value

    def begin(self, context: bpy.types.Context) -> Bake | None:
        """None after a report of what is wrong."""
        state = context.window_manager.vxs
        state.clear()
        try:
            bake = Bake(context, self.chosen(context.scene), output_path(context.scene, self.filepath))
        except (BakeFailed, VxsMissing) as error:
            self.fail(state, str(error))
        except OSError as error:
            self.fail(state, f"The level cannot be written for vxs: {error.strerror}")
        else:
            state.is_running = True
            return bake
        return None

    def fail(self, state: Any, text: str, named: Iterable[tuple[str, str]] = ()) -> None:
        level = "INFO" if state.is_cancelled else "ERROR"  # what the user asked for is no fault
        tell(state, level, text, named)
        self.report({level}, text)

    def end(self, context: bpy.types.Context, bake: Bake) -> set[str]:
        state = context.window_manager.vxs
        state.is_running = False
        try:
            bake.finish(state)
        except BakeFailed as error:
            self.fail(state, str(error), things_named(str(error), bake.level))
            return {"CANCELLED"}
        for message in state.messages if bpy.app.background else ():
            print(f"vxs: {message.level.lower()}: {message.text}", flush=True)
        self.report({"INFO"}, f"{bake.output}: {state.result.splitlines()[0]}")
        return {"FINISHED"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Bake, and return when all is done."""
        bake, state, printed = self.begin(context), context.window_manager.vxs, 0.0
        if not bake:
            return {"CANCELLED"}
        try:
            while bake.step(state):
                if bpy.app.background and state.doing and time.monotonic() > printed + 1.0:
                    print(f"vxs: {state.share:4.0%} {state.doing}", flush=True)
                    printed = time.monotonic()
                time.sleep(0.02)
        except BaseException:
            state.is_running = False
            bake.close()
            raise
        return self.end(context, bake)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Bake beside the window."""
        if bpy.app.background or not context.window:
            return self.execute(context)
        self.bake = self.begin(context)
        if not self.bake:
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        is_running = self.bake.step(context.window_manager.vxs)
        for area in (area for window in context.window_manager.windows for area in window.screen.areas if area.type == "PROPERTIES"):
            area.tag_redraw()
        if is_running:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        return self.end(context, self.bake)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender quits, or opens another file."""
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.vxs.is_running = False
        self.bake.close()


class VXS_OT_cancel(bpy.types.Operator):
    bl_idname = "vxs.cancel"
    bl_label = "Cancel"
    bl_description = "Stop the bake; the file stays as it was"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.window_manager.vxs.is_running

    def execute(self, context: bpy.types.Context) -> set[str]:
        context.window_manager.vxs.is_cancelled = True
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((VXS_OT_bake, VXS_OT_cancel))
