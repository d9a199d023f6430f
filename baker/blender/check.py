# Where Blender's own rays disagree with a baked shadow: colours on the preview, and numbers.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722 -- annotations of Blender are properties, not types
from __future__ import annotations

import math
import os
import tempfile
import time
from collections import Counter
from typing import Any, Iterator

import bpy
import numpy as np
from bpy.props import IntProperty
from bpy.types import Context, Event, Operator
from mathutils import Vector

from . import overlay
from .bake import BakeFailed
from .command import VxsMissing
from .preview import OUTSIDE, Baked, gather, preview

RIGHT, NEAR, FAR, INSIDE = range(4)  # answers; NEAR and FAR are wrong
COLOURS = {NEAR: (1.0, 0.8, 0.1), FAR: (1.0, 0.05, 0.05)}
RADII = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)  # texels, of places where an edge of shadow is looked for
TURNS = 12
DEPTHS = 4  # voxels off a surface, towards the light: what the bias of a lookup may take
STEPS = 200  # surfaces that a ray may pass
PIECE = 300  # points between two looks at the clock


class Truth:
    """Answers of scene.ray_cast through what casts. Where a ray meets a surface with holes, `vxs truth` answers in its place."""

    def __init__(self, context: Context, baked: Baked, folder: str) -> None:
        self.context, self.baked, self.path = context, baked, os.path.join(folder, "level.glb")
        gatherer, writer = gather(context, False, self.path)
        writer.write(context.scene)
        self.numbers = {name: n for n, name in enumerate(writer.level.lights)}
        self.matrices = {node["name"]: np.array(node["matrix"]).reshape(4, 4) for node in writer.glb.json["nodes"] if "extensions" in node}
        self.closed = overlay.seen(gatherer)[1]
        places = [place for place in gatherer.places if place.surface]
        self.casts = {self.key(place.key[1], place.matrix) for place in places}
        self.holes = {place.key[1] for place in places for m in place.surface.materials if m and not gatherer.looks[m].value.keys().isdisjoint(
            ("alphaMode", "extras", "extensions"))}

    def key(self, name: str, matrix: Any) -> tuple[str, tuple[float, ...]]:
        return name, tuple(round(v, 3) for v in matrix)

    def hits(self, start: Vector, way: Vector, far: float) -> Iterator[tuple[str, tuple[float, ...]]]:
        """What casts and lies on a ray, in its order."""
        step = 1e-5 * max(1.0, start.length)
        for _ in range(STEPS):
            found, at, _, _, thing, matrix = self.context.scene.ray_cast(self.depsgraph, start, way, distance=min(far, 1e30))
            if not found:
                return
            key = self.key(thing.name, [v for column in matrix.col for v in column])
            if key in self.casts:
                yield key
            far -= (at - start).length + step
            start = at + way * step

    def towards(self, points: np.ndarray, light: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors to a light where it is now, and how far it is."""
        matrix = self.matrices.get(light["name"])
        if matrix is None:
            raise BakeFailed(f"The light '{light['name']}' of the file is not in the scene")
        if light["kind"] == "directional":
            return np.tile(matrix[2, :3] / np.linalg.norm(matrix[2, :3]), (len(points), 1)), np.full(len(points), math.inf)
        way = matrix[3, :3] - points
        far = np.linalg.norm(way, axis=1)
        return way / far[:, None], far

    def lit(self, points: np.ndarray, light: dict[str, Any]) -> np.ndarray:
        """[points] 1 or 0."""
        self.depsgraph = self.context.evaluated_depsgraph_get()  # what was changed meanwhile counts
        answers = np.ones(len(points))
        for n, (start, way, far) in enumerate(zip(points.tolist(), *(part.tolist() for part in self.towards(points, light)))):
            hit = next(self.hits(Vector(start), Vector(way), far), None)
            answers[n] = 1.0 if not hit else math.nan if hit[0] in self.holes else 0.0
        unknown = np.isnan(answers)
        if unknown.any():
            number = self.numbers[light["name"]]
            answers[unknown] = self.baked.ask("truth", self.path, points=points[unknown], numbers=[number])[:, 0] != 0.0
        return answers

    def is_inside(self, point: np.ndarray) -> bool:
        """Whether a point lies in a solid: a ray leaves it more often than it enters."""
        met = Counter(self.hits(Vector(point), Vector((0.267, 0.534, 0.802)).normalized(), math.inf))
        return any(count % 2 and self.closed[name] for (name, _), count in met.items())

    def reasons(self, points: np.ndarray, normals: np.ndarray, given: np.ndarray, light: dict[str, Any]) -> np.ndarray:
        """Of wrong answers: NEAR where a place within 1.5 texels of light space has the given answer, INSIDE of solids, else FAR."""
        way, far = self.towards(points, light)
        scale = np.where(np.isinf(far), 1.0, far)[:, None]
        slope = (way * normals).sum(1, keepdims=True)
        beside = np.cross(way, np.where(abs(way[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
        beside /= np.linalg.norm(beside, axis=1, keepdims=True)
        other, deep = np.cross(way, beside), np.sign(slope) * way * scale * light["voxel_m"]
        why = np.full(len(points), FAR)
        for radius in (0.0, *RADII):
            left = np.flatnonzero(why == FAR)
            tries = []
            for turn in np.arange(TURNS if radius else 1) * (2 * math.pi / TURNS):
                step = (math.cos(turn) * beside + math.sin(turn) * other) * radius * light["texel_m"] * scale
                on_plane = step - way * np.where(abs(slope) > 0.02, (step * normals).sum(1, keepdims=True) / slope, 0.0)
                tries += [(rows, (points + on_plane + depth * deep)[rows]) for depth in range(DEPTHS)
                          for rows in [left if depth == 0 else left[given[left] == 1.0]]]
            rows, places = (np.concatenate(parts) for parts in zip(*tries))
            why[rows[self.lit(places, light) == given[rows]]] = NEAR
            if radius == 0.0:
                why[[n for n, place in zip(rows, places) if given[n] == 1.0 and self.is_inside(place)]] = INSIDE
        return why


def compare(context: Context, baked: Baked, folder: str, limit: int) -> Iterator[float]:
    """Compare points on the preview, each light with Blender's rays, and show what differs. Yields the share that is done."""
    shown = overlay.shown_in(context.scene) or preview(context, baked, 1, 100000)
    mesh, hair = shown.data, shown["vxs_hair"]
    count = len(mesh.polygons)
    centres, normals, areas, colours = (np.empty(count * width, np.float32) for width in (3, 3, 1, 12))
    for name, values in (("center", centres), ("normal", normals), ("area", areas)):
        mesh.polygons.foreach_get(name, values)
    mesh.color_attributes["shadow"].data.foreach_get("color_srgb", colours)
    rows = np.random.default_rng(1).permutation(count)[:limit]
    normals = normals.reshape(-1, 3)[rows].astype(float)
    places = centres.reshape(-1, 3)[rows] - hair * normals
    truth = Truth(context, baked, folder)
    given = baked.lit(places, normals)
    why = np.zeros(given.shape, int)
    for n, light in enumerate(baked.lights):
        away = (truth.towards(places, light)[0] * normals).sum(1) < 0.0
        given[away, n] = OUTSIDE  # dark, whatever the file says
        for begin in range(0, len(rows), PIECE):
            part = begin + np.flatnonzero(given[begin:begin + PIECE, n] != OUTSIDE)
            starts = places[part] + 0.1 * hair * normals[part]
            wrong = truth.lit(starts, light) != given[part, n]
            part, starts = part[wrong], starts[wrong]
            why[part, n] = truth.reasons(starts, normals[part], given[part, n], light)
            yield (n + min(1.0, (begin + PIECE) / len(rows))) / len(baked.lights)
    compared = (given != OUTSIDE) & (why != INSIDE)
    differs, weights = compared & (why != RIGHT), compared * areas[rows][:, None]
    worst = np.where(differs, why, RIGHT).max(1)
    colours = colours.reshape(-1, 3, 4)[..., :3]
    for kind, colour in COLOURS.items():
        colours[rows[worst == kind]] = colour
    overlay.paint(shown.data, "error", colours.reshape(-1, 3))
    state = context.window_manager.vxs
    state.checked, state.differ, state.differ_far = (int(x.sum()) for x in (compared, differs, differs & (why == FAR)))
    state.check = (f"{state.checked} points: {(weights * differs).sum() / max(weights.sum(), 1e-30):.2%} of the surface differs from rays\n"
                   f"{state.differ_far} points are farther than 1.5 texels from an edge of shadow")


class VXS_OT_check_error(Operator):
    bl_idname = "vxs.check_error"
    bl_label = "Compare with Rays"
    bl_description = "Compare the baked shadows with rays of Blender: yellow differs near an edge of shadow, red farther than 1.5 texels"

    points: IntProperty(name="Points", default=20000, min=1, soft_max=500000)

    @classmethod
    def poll(cls, context: Context) -> bool:
        return not context.window_manager.vxs.is_running

    def begin(self, context: Context) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="vxs_", ignore_cleanup_errors=True)
        shown = overlay.shown_in(context.scene)
        self.state = context.window_manager.vxs
        self.state.is_running, self.state.is_cancelled, self.state.doing, self.state.share = True, False, "comparing with rays", 0.0
        self.work = self.steps(context, shown["vxs_light"] if shown else "")

    def steps(self, context: Context, light: str) -> Iterator[float]:
        yield from compare(context, Baked(context, light), self.folder.name, self.points)

    def step(self, seconds: float) -> set[str]:
        """Work for a while. RUNNING_MODAL, or what the operator returns."""
        until = time.monotonic() + seconds
        try:
            while time.monotonic() < until:
                if self.state.is_cancelled:
                    raise BakeFailed("The comparison was cancelled")
                self.state.share = next(self.work)
            return {"RUNNING_MODAL"}
        except StopIteration:
            self.report({"INFO"}, self.state.check.replace("\n", "; "))
            outcome = {"FINISHED"}
        except (BakeFailed, VxsMissing, ReferenceError) as error:
            self.report({"WARNING" if self.state.is_cancelled else "ERROR"}, str(error))
            outcome = {"CANCELLED"}
        except BaseException:
            self.close()
            raise
        self.close()
        return outcome

    def close(self) -> None:
        self.state.is_running = False
        self.folder.cleanup()

    def execute(self, context: Context) -> set[str]:
        self.begin(context)
        return self.step(math.inf)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        if bpy.app.background or not context.window:
            return self.execute(context)
        self.begin(context)
        self.timer = context.window_manager.event_timer_add(0.02, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "ESC":
            self.state.is_cancelled = True
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        outcome = self.step(0.05)
        for area in context.screen.areas:
            area.tag_redraw()
        if outcome == {"RUNNING_MODAL"}:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        return outcome

    def cancel(self, context: Context) -> None:
        """Blender quits, or opens another file."""
        context.window_manager.event_timer_remove(self.timer)
        self.close()


def register() -> None:
    bpy.utils.register_class(VXS_OT_check_error)


def unregister() -> None:
    bpy.utils.unregister_class(VXS_OT_check_error)
