# Where Blender's own rays disagree with a baked shadow: colours on the preview, and numbers.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722 -- annotations of Blender are properties, not types
from __future__ import annotations

import math
import os
import tempfile
from typing import Any, Iterator

import bpy
import numpy as np
from bpy.props import IntProperty
from bpy.types import Context, Material, Operator
from mathutils.bvhtree import BVHTree

from . import overlay
from .command import Failed, to_gltf
from .level import Level, Surface, gather
from .materials import Appearance
from .operators import Work
from .preview import OUTSIDE, Baked, preview, towards

COLOURS = {"NEAR": (1.0, 0.8, 0.1), "FAR": (1.0, 0.05, 0.05)}  # of what differs
REACH = 1.5  # texels, from a point to where edges of shadow are looked for
PIECE = 1000  # points between two looks at the clock


class Truth:
    """Answers of Blender's rays through what casts. Where a ray meets a surface with holes, `vxs truth` answers in its place."""

    def __init__(self, context: Context, baked: Baked, folder: str) -> None:
        self.baked, self.path = baked, os.path.join(folder, "level.glb")
        gatherer, writer = gather(context, Level(self.path))
        writer.write(context.scene)
        self.matrices = {node["name"]: np.array(node["matrix"]).reshape(4, 4) for node in writer.glb.json["nodes"] if "extensions" in node}
        self.numbers = {name: n for n, name in enumerate(writer.level.lights)}
        casters = list(overlay.surfaces(gatherer))
        if not casters:
            raise Failed("Nothing casts shadows: there is nothing to compare with")
        behind = [math.nan if self.has_holes(surface, gatherer.looks) else OUTSIDE if whole else 0.0 for surface, _, whole in casters]
        self.behind = np.repeat(behind, [len(part) for _, part, _ in casters])  # what ray() answers from behind a triangle
        triangles = np.concatenate([part for _, part, _ in casters])
        self.tree = BVHTree.FromPolygons(triangles.reshape(-1, 3).tolist(), np.arange(triangles.size // 3).reshape(-1, 3).tolist(),
                                         all_triangles=True)

    def has_holes(self, surface: Surface, looks: dict[Material, Appearance]) -> bool:
        return any(m and not {"alphaMode", "extras", "extensions"}.isdisjoint(looks[m].value) for m in surface.materials)

    def now(self, light: dict[str, Any]) -> dict[str, Any]:
        """A light of the file, where it is in the scene."""
        matrix = self.matrices.get(light["name"])
        if matrix is None:
            raise Failed(f"The light '{light['name']}' of the file is not in the scene")
        back, place = to_gltf(matrix[2:, :3])
        return light | {"direction": -back / np.linalg.norm(back), "position_m": place}

    def ray(self, start: np.ndarray, way: np.ndarray, far: float) -> float:
        """1 or 0; OUTSIDE where it leaves a solid, in which nothing is looked up; nan where it meets a surface with holes."""
        _, normal, index, _ = self.tree.ray_cast(start, way, far)
        if index is None:
            return 1.0
        return self.behind[index] if math.isnan(self.behind[index]) or normal.dot(way) > 0.0 else 0.0

    def lit(self, points: np.ndarray, normals: np.ndarray, light: dict[str, Any]) -> np.ndarray:
        """[points] 1 or 0; OUTSIDE where they face away from the light, which is dark whatever the file says, or are in a solid."""
        ways, far = towards(self.now(light), points)
        answers = np.full(len(points), OUTSIDE)
        for n in np.flatnonzero((ways * normals).sum(1) >= 0.0).tolist():
            answers[n] = self.ray(points[n], ways[n], 1e30 if light["kind"] == "directional" else far[n])
        unknown, number = np.isnan(answers), [self.numbers[light["name"]]]
        if unknown.any():
            answers[unknown] = self.baked.ask(points[unknown], normals[unknown], number, "truth", self.path)[:, 0] != 0.0
        return answers


def at_edges(baked: Baked, n: int, places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """[points]: whether the file has an edge of a light's shadow within about two texels on the surface."""
    across = np.cross(normals, np.eye(3)[np.abs(normals).argmin(1)])
    across *= (REACH * baked.lights[n]["texel_m"] * towards(baked.lights[n], places)[1] / np.linalg.norm(across, axis=1))[:, None]
    turns = np.linspace(0, 2 * math.pi, 12, False)[:, None, None]
    around = (places + np.cos(turns) * across + np.sin(turns) * np.cross(normals, across)).reshape(-1, 3)
    lit = baked.ask(around, np.tile(normals, (12, 1)), [baked.numbers[n]], "query", baked.path, "--filter", "3").reshape(12, -1)
    return (lit.max(0) > 0.0) & (lit.min(0) < 1.0)


def compare(context: Context, baked: Baked, folder: str, limit: int) -> Iterator[float]:
    """Compare points on the preview, each light with Blender's rays, and show what differs. Yields the share that is done."""
    shown = overlay.shown_in(context.scene) or preview(context, baked, 1, 100000)
    mesh, hair, count = shown.data, shown["vxs_hair"], len(shown.data.polygons)
    centres, normals, areas, colours = (np.empty(count * width, np.float32) for width in (3, 3, 1, 12))
    for name, values in (("center", centres), ("normal", normals), ("area", areas)):
        mesh.polygons.foreach_get(name, values)
    mesh.color_attributes["shadow"].data.foreach_get("color_srgb", colours)
    rows = np.random.default_rng(1).permutation(count)[:limit]
    normals = normals.reshape(-1, 3)[rows].astype(float)
    places = centres.reshape(-1, 3)[rows] - hair * normals
    truth = Truth(context, baked, folder)
    given = baked.lit(places, normals)
    right = np.empty_like(given)
    for n, light in enumerate(baked.lights):
        for part in [slice(begin, begin + PIECE) for begin in range(0, len(rows), PIECE)]:
            right[part, n] = truth.lit(places[part] + 0.1 * hair * normals[part], normals[part], light)
            yield (n + min(1.0, part.stop / len(rows))) / len(baked.lights)
    compared = (given != OUTSIDE) & (right != OUTSIDE)
    differs, weights = compared & (given != right), compared * areas[rows][:, None]
    far = differs.copy()
    for n, wrong in enumerate(differs.T):
        far[wrong, n] = ~at_edges(baked, n, places[wrong], normals[wrong])
    colours = colours.reshape(-1, 3, 4)[..., :3]
    colours[rows[differs.any(1)]] = COLOURS["NEAR"]
    colours[rows[far.any(1)]] = COLOURS["FAR"]
    overlay.paint(shown.data, "error", colours.reshape(-1, 3))
    context.window_manager.vxs.check = (
        f"{differs.sum()} of {compared.sum()} answers differ from rays, on {(weights * differs).sum() / max(weights.sum(), 1e-30):.2%} of the surface\n"
        f"{far.sum()} of them are at no edge of a shadow")


class VXS_OT_check_error(Work, Operator):
    bl_idname = "vxs.check_error"
    bl_label = "Compare with Rays"
    bl_description = "Compare the baked shadows with rays of Blender: yellow differs at an edge of shadow, red elsewhere"

    points: IntProperty(name="Points", default=20000, min=1, soft_max=500000)

    def work(self, context: Context) -> Iterator[float]:
        state, shown = context.window_manager.vxs, overlay.shown_in(context.scene)
        state.doing = "comparing with rays"
        with tempfile.TemporaryDirectory(prefix="vxs_", ignore_cleanup_errors=True) as folder:
            for state.share in compare(context, Baked(context, shown["vxs_light"] if shown else ""), folder, self.points):
                yield 0.0
        self.report({"INFO"}, state.check.replace("\n", "; "))


CLASSES = (VXS_OT_check_error,)
