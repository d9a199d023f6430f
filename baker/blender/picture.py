# A picture of the level in its baked shadows, by vxs render, as the active camera or a 3D view sees it.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

import math
import os
import tempfile
from typing import Any, NamedTuple

import bpy
import numpy as np
from bpy.props import EnumProperty, IntProperty
from bpy.types import Context, Operator
from mathutils import Matrix

from .command import Failed, answer
from .level import Level, gather
from .operators import Action
from .preview import Baked

NAME = "vxs picture"
PIXELS = 8192  # a side of what vxs render draws


class View(NamedTuple):
    """A camera: its place, its projection, and pixels."""
    matrix: Matrix
    projection: Matrix
    width: int
    height: int


def view_of(context: Context, seen_from: str) -> View:
    """What the operator is asked for: the 3D view, or the camera with the size of renders."""
    area = context.area if context.area and context.area.type == "VIEW_3D" else next(
        (area for area in (context.screen.areas if context.screen else ()) if area.type == "VIEW_3D"), None)
    if seen_from == "VIEW" and area:
        region = next(region for region in area.regions if region.type == "WINDOW")
        space = area.spaces.active.region_3d
        return View(space.view_matrix.inverted(), space.window_matrix.copy(), region.width, region.height)
    camera, render = context.scene.camera, context.scene.render
    if not camera or camera.type != "CAMERA":
        raise Failed("There is no view to draw: the scene has no camera")
    if camera.data.type == "PANO":
        raise Failed("A panoramic camera cannot be drawn")
    width, height = (max(16, getattr(render, "resolution_" + axis) * render.resolution_percentage // 100) for axis in "xy")
    depsgraph = context.evaluated_depsgraph_get()
    projection = camera.evaluated_get(depsgraph).calc_matrix_camera(depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x,
                                                                    scale_y=render.pixel_aspect_y)
    place, turn, _ = camera.matrix_world.decompose()
    square = max(16, round(height * projection[1][1] / projection[0][0]))  # pixels across, as high as wide
    return View(Matrix.LocRotScale(place, turn, None), projection, square, height)


def centred(view: View) -> tuple[View, int, int, dict[str, Any]]:
    """glTF has no shift: a larger view whose middle is the camera's axis, where the picture lies in it, and glTF's camera. The picture
    is right to a quarter of a pixel."""
    m = view.projection
    wide, high = 1.0 / m[0][0], 1.0 / m[1][1]
    if m[3][2] == 0.0:
        near = (m[2][3] + 1.0) / m[2][2]
        matrix = view.matrix @ Matrix.Translation((-m[0][3] * wide, -m[1][3] * high, 0.0))
        camera = {"xmag": wide, "ymag": high, "znear": max(near, 0.0), "zfar": 1e6}
        return View(matrix, m, view.width, view.height), 0, 0, {"type": "orthographic", "orthographic": camera}
    beside, above = m[0][2] * view.width / 2, m[1][2] * view.height / 2  # pixels
    larger = view.width + 2 * math.ceil(abs(beside)), view.height + 2 * math.ceil(abs(above))
    near = m[2][3] / (m[2][2] - 1.0)
    camera = {"yfov": 2.0 * math.atan(high * larger[1] / view.height), "znear": max(near, 1e-4)}
    left, low = round((larger[0] - view.width) / 2 + beside), round((larger[1] - view.height) / 2 + above)
    return View(view.matrix, m, *larger), left, low, {"type": "perspective", "perspective": camera}


def draw(context: Context, baked: Baked, view: View, taps: int) -> np.ndarray:
    """Pixels [height, width, 4] from below, by vxs render."""
    larger, left, low, camera = centred(view)
    if max(larger.width, larger.height) > PIXELS:
        raise Failed(f"The picture would have {larger.width} x {larger.height} pixels, and has at most {PIXELS} a side")
    with tempfile.TemporaryDirectory(prefix="vxs_", ignore_cleanup_errors=True) as folder:
        _, writer = gather(context, Level(os.path.join(folder, "level.glb")), receivers=True)
        matrix = [v for column in larger.matrix.col for v in column]
        writer.nodes.append(writer.glb.add("nodes", {"name": NAME, "matrix": matrix, "camera": writer.glb.add("cameras", camera)}))
        writer.write(context.scene)
        file = os.path.join(folder, "picture.png")
        answer(baked.vxs, "render", writer.level.path, baked.path, "-o", file, "--camera", "0", "--filter", str(taps),
               "--width", str(larger.width), "--height", str(larger.height), "--quiet")
        image = bpy.data.images.load(file)
        try:
            pixels = np.empty(4 * larger.width * larger.height, np.float32)
            image.pixels.foreach_get(pixels)
        finally:
            bpy.data.images.remove(image)
    return pixels.reshape(larger.height, larger.width, 4)[low:low + view.height, left:left + view.width]


def keep(pixels: np.ndarray) -> bpy.types.Image:
    """As the image of the picture; where it is used it stays so."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(NAME) or bpy.data.images.new(NAME, width, height)
    image.scale(width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    image.pack()
    return image


class VXS_OT_picture(Action, Operator):
    bl_idname = "vxs.picture"
    bl_label = "Picture"
    bl_description = f"Draw the level in its baked shadows with vxs render, as the image '{NAME}'"

    seen_from: EnumProperty(name="From", items=(("CAMERA", "Camera", "The active camera, with the size of renders"),
                                               ("VIEW", "3D View", "A 3D view of this window; the camera where there is none")))
    taps: IntProperty(name="Filter", default=5, min=1, max=17, description="Texels along a side of the box filter, odd")

    def work(self, context: Context) -> tuple[()]:
        image = keep(draw(context, Baked(context), view_of(context, self.seen_from), self.taps | 1))
        for area in context.screen.areas if context.screen else ():
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
        return ()


CLASSES = (VXS_OT_picture,)
