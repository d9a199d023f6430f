# The operators that bake: the level is written here and now, vxs runs beside Blender.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

import json
import os
import tempfile
from contextlib import closing
from types import SimpleNamespace
from typing import Any, Iterator

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import settings
from .command import Failed, bake_arguments, find_vxs, run
from .level import Level, gather
from .messages import plain, tell, tell_left_out, tell_warnings, things_named
from .operators import Work

AS_SCENE = (("SCENE", "As the Scene", "As in the render properties"),)


def output_path(scene: bpy.types.Scene, asked: str) -> str:
    """Where the bake goes: asked for, set in the scene, or beside the .blend."""
    saved = bpy.data.filepath
    path = asked or scene.vxs.filepath or ("//" if saved else "")
    if not path or path.startswith("//") and not saved:
        raise Failed("This file was never saved: save it first, or choose an output file in Baked Shadows")
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


def read_report(path: str) -> dict[str, Any]:
    try:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        if {"warnings", "unchanged"} <= set(report):
            return report
    except (OSError, ValueError, TypeError):
        pass
    raise Failed("vxs gave no report: set the path of vxs in the add-on's preferences")


def refuse_nothing(level: Level) -> None:
    if not level.instances:
        raise Failed("Nothing casts shadows: no object with a surface is shown, rendered, and not left out")
    if not level.lights:
        areas = [note for note in level.notes if note.startswith("light ")]
        raise Failed((areas or ["No light is baked: add a sun, point or spot light that is rendered, with Bake Shadows on"])[0])


class VXS_OT_bake(Work, bpy.types.Operator):
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
                raise Failed(f"There is no object '{self.region}' for the region")
        return value

    def work(self, context: bpy.types.Context) -> Iterator[float]:
        state, self.level = context.window_manager.vxs, Level()
        state.clear()
        chosen, output = self.chosen(context.scene), output_path(context.scene, self.filepath)
        vxs = find_vxs(context)
        with tempfile.TemporaryDirectory(prefix="vxs_", ignore_cleanup_errors=True) as folder:
            path, report, log = (os.path.join(folder, name) for name in ("level.glb", "report.json", "log"))
            self.level = Level(path, chosen.region.name if chosen.region else "")
            gather(context, self.level)[1].write(context.scene)
            refuse_nothing(self.level)
            arguments = bake_arguments(context, chosen, self.level.lights, path, output, report)
            yield from self.watch(state, run(vxs, ["bake", *arguments], log))
            told, unchanged_bytes = read_report(report), 0
            if told["unchanged"]:  # a plan gives the warnings
                unchanged_bytes = told["file_bytes"]
                yield from self.watch(state, run(vxs, ["plan", *(a for a in arguments if a != "--if-changed")], log))
                told = read_report(report)
        state.result, state.filepath = result_text(told, unchanged_bytes), output
        tell_warnings(state, self.level, told["warnings"])
        tell_left_out(state, self.level)
        for message in state.messages if bpy.app.background else ():
            print(f"vxs: {message.level.lower()}: {message.text}", flush=True)
        self.report({"INFO"}, f"{output}: {state.result.splitlines()[0]}")

    def watch(self, state: Any, running: Iterator[dict[str, Any]]) -> Iterator[float]:
        """Show the progress of vxs until it ends, or stop it."""
        with closing(running):
            for progress in running:
                state.share = progress.get("share", state.share)
                if "doing" in progress:
                    left = progress.get("seconds_left")
                    doing = progress["doing"].replace(self.level.path, "the level")
                    state.doing = doing + (f", {left:.0f} s left" if left is not None else "")
                yield 0.02

    def fail(self, state: Any, text: str) -> None:
        text = plain(text, self.level.path)
        tell(state, "INFO" if state.is_cancelled else "ERROR", text, things_named(text, self.level))
        Work.fail(self, state, text)


class VXS_OT_cancel(bpy.types.Operator):
    bl_idname = "vxs.cancel"
    bl_label = "Cancel"
    bl_description = "Stop the work; a file stays as it was"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.window_manager.vxs.is_running

    def execute(self, context: bpy.types.Context) -> set[str]:
        context.window_manager.vxs.is_cancelled = True
        return {"FINISHED"}


CLASSES = (VXS_OT_bake, VXS_OT_cancel)
