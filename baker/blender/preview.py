# The baked shadow on the scene: what a file answers, shown by an overlay.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

import json
import os
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, IntProperty, StringProperty
from bpy.types import Context, Operator

from . import overlay
from .bake import output_path
from .command import Failed, answer, find_vxs, to_gltf
from .level import Level, gather
from .operators import Action

OUTSIDE = -1.0  # the answer where a light has no map
BESIDE = (0.3, 0.25, 0.45)  # the colour where no light has one
LUMINANCE = (0.2126, 0.7152, 0.0722)


def to_blender(vector: list[float]) -> np.ndarray:
    return np.array((vector[0], -vector[2], vector[1]))


class Baked:
    """The file of the last bake, and those of its lights that are looked at. Points and directions have Blender's axes."""

    def __init__(self, context: Context, light: str = "") -> None:
        self.vxs, self.path = find_vxs(context), context.window_manager.vxs.filepath or output_path(context.scene, "")
        if not os.path.isfile(self.path):
            raise Failed(f"There is no {self.path}: bake first")
        lights = json.loads(answer(self.vxs, "info", self.path, "--json", "-", "--quiet"))["lights"]
        self.numbers = [n for n, each in enumerate(lights) if light in ("", each["name"])]
        self.lights = [lights[n] for n in self.numbers]
        if not self.lights:
            raise Failed(f"{self.path} has no light '{light}'")

    def ask(self, points: np.ndarray, normals: np.ndarray, numbers: list[int], command: str, *arguments: str) -> np.ndarray:
        """[points, lights of these numbers]: 0 dark to 1 lit, or OUTSIDE."""
        rows = np.concatenate([to_gltf(points), to_gltf(normals)], 1)
        text = "%.9g %.9g %.9g %.6g %.6g %.6g\n" * len(rows) % tuple(rows.ravel().tolist())
        chosen = [part for n in numbers for part in ("--light", f"#{n}")]
        said = answer(self.vxs, command, *arguments, *chosen, stdin=text.encode())
        return np.array(said.replace(b"out", b"-1").split(), "S16").astype(np.float32).reshape(len(rows), len(numbers))

    def lit(self, points: np.ndarray, normals: np.ndarray, taps: int = 1) -> np.ndarray:
        return self.ask(points, normals, self.numbers, "query", self.path, "--filter", str(taps))

    def width(self, points: np.ndarray) -> np.ndarray:
        """Side of a texel at points, of the finest light."""
        return np.min([light["texel_m"] * towards(light, points)[1] for light in self.lights], axis=0)


def towards(light: dict[str, Any], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors from points to a light of `vxs info`, and how far it is; 1 to a sun."""
    if light["kind"] == "directional":
        return np.broadcast_to(-to_blender(light["direction"]), points.shape), np.ones(len(points))
    way = to_blender(light["position_m"]) - points
    far = np.maximum(np.linalg.norm(way, axis=1), 1e-6)
    return way / far[:, None], far


def greys(lights: list[dict[str, Any]], strengths: dict[str, float], points: np.ndarray, normals: np.ndarray, lit: np.ndarray) -> np.ndarray:
    """Colours [points, 3]: the mean of the lights by what each adds where nothing casts shadow; of one light, its shadow alone."""
    share = np.empty_like(lit)
    for n, light in enumerate(lights):
        way, far = towards(light, points)
        facing = (way * normals).sum(1)
        share[:, n] = strengths.get(light["name"], 1.0) * np.maximum(facing, 0.0) / far**2 if len(lights) > 1 else 1.0
        lit[:, n] = np.where((facing < 0.0) & (lit[:, n] > 0.0), 0.0, lit[:, n])
    share[lit == OUTSIDE] = 0.0
    grey = (lit * share).sum(1) / np.maximum(share.sum(1), 1e-30)
    colours = np.repeat(0.06 + 0.94 * grey[:, None], 3, 1)
    colours[(lit == OUTSIDE).all(1)] = BESIDE
    return colours


def preview(context: Context, baked: Baked, taps: int, limit: int) -> bpy.types.Object:
    """Make the overlay anew."""
    overlay.clear()
    gatherer, writer = gather(context, Level(), receivers=True)
    triangles = overlay.seen(gatherer)
    if not len(triangles):
        raise Failed("There is no surface to show a shadow on")
    corners, lit, normals = overlay.dice(triangles, baked.width, lambda points, normals: baked.lit(points, normals, taps), limit)
    lamps = writer.glb.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", ())
    strengths = {lamp["name"]: lamp["intensity"] * float(np.dot(lamp["color"], LUMINANCE)) for lamp in lamps}
    hair = 2e-4 * float(np.ptp(triangles, axis=(0, 1)).max())
    mesh = overlay.mesh_of(corners + hair * normals[:, None])
    points, outwards = corners.reshape(-1, 3), np.repeat(normals, 3, 0)
    overlay.paint(mesh, "shadow", greys(baked.lights, strengths, points, outwards, lit.reshape(len(points), -1)))
    shown = overlay.show(context.scene, mesh)
    shown["vxs_hair"], shown["vxs_light"] = hair, baked.lights[0]["name"] if len(baked.lights) == 1 else ""
    return shown


def shadings(context: Context) -> list[bpy.types.View3DShading]:
    return [space.shading for window in context.window_manager.windows for area in window.screen.areas for space in area.spaces
            if space.type == "VIEW_3D"]


class VXS_OT_preview(Action, Operator):
    bl_idname = "vxs.preview"
    bl_label = "Preview Shadows"
    bl_description = "Show the baked shadows on the scene, by an object that is neither rendered, baked nor exported"
    bl_options = {"REGISTER", "UNDO"}

    light: StringProperty(name="Light", description="Its shadow alone. Without a name: all lights, by what each adds")
    taps: IntProperty(name="Filter", default=5, min=1, max=17, description="Texels along a side of the box filter, odd")
    points: IntProperty(name="Points", default=500000, min=1000, soft_max=5000000,
                        description="Lookups beside those at the scene's own corners")
    set_shading: BoolProperty(name="Set Shading", description="3D views show colours of attributes alone")

    def work(self, context: Context) -> tuple[()]:
        preview(context, Baked(context, self.light), self.taps | 1, self.points)
        for shading in shadings(context) if self.set_shading else ():
            shading.type, shading.color_type, shading.show_backface_culling = "SOLID", "VERTEX", True
        return ()


class VXS_OT_preview_clear(Operator):
    bl_idname = "vxs.preview_clear"
    bl_label = "Remove Preview"
    bl_description = "Remove the preview, and all that belongs to it"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return overlay.shown_in(context.scene) is not None and not context.window_manager.vxs.is_running

    def execute(self, context: Context) -> set[str]:
        overlay.clear()
        return {"FINISHED"}


CLASSES = (VXS_OT_preview, VXS_OT_preview_clear)
