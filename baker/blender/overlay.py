# The overlay of a preview: triangles that follow the borders of shadows, and the one object that shows them.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

from typing import Callable, Iterator

import bpy
import numpy as np

from .level import Gatherer, Surface

NAME = "vxs preview"  # name of all datablocks of the preview
MARK = "vxs_preview"  # their custom property, as other datablocks may have that name

Ask = Callable[[np.ndarray, np.ndarray], np.ndarray]  # points and normals [count, 3] -> how lit [count, lights]
Width = Callable[[np.ndarray], np.ndarray]  # points [count, 3] -> side of a texel there, in metres


def is_closed(surface: Surface) -> bool:
    """Whether each edge belongs to two triangles, where corners at one place are one."""
    places = np.ascontiguousarray(surface.points + np.float32(0)).view("V12").ravel()
    ends = np.unique(places, return_inverse=True)[1].ravel()[surface.corners[surface.triangles]]
    pairs = np.sort(np.stack([ends, np.roll(ends, 1, axis=1)], 2).reshape(-1, 2), 1)
    return bool((np.unique(pairs @ np.array((len(places), 1)), return_counts=True)[1] == 2).all())


def surfaces(gatherer: Gatherer) -> Iterator[tuple[Surface, np.ndarray, bool]]:
    """Each instance of a surface: its triangles [count, 3, 3] in world space, and whether it is closed."""
    known: dict[int, bool] = {}
    for place in (p for p in gatherer.places if p.surface):
        surface, matrix = place.surface, np.array(place.matrix).reshape(4, 4)
        if id(surface) not in known:
            known[id(surface)] = is_closed(surface)
        part = (surface.points @ matrix[:3, :3] + matrix[3, :3])[surface.corners[surface.triangles]]
        yield surface, part[:, ::-1] if np.linalg.det(matrix) < 0 else part, known[id(surface)]


def seen(gatherer: Gatherer) -> np.ndarray:
    """Triangles [count, 3, 3] in world space, of what is open from both sides."""
    parts = [np.empty((0, 3, 3))]
    for _, part, is_whole in surfaces(gatherer):
        parts += [part] if is_whole else [part, part[:, ::-1]]
    return np.concatenate(parts)


def normals_of(triangles: np.ndarray) -> np.ndarray:
    """Unit normals [count, 3]; nan for triangles without an area."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    with np.errstate(invalid="ignore"):
        return across / np.linalg.norm(across, axis=1, keepdims=True)


def edges(corners: np.ndarray) -> np.ndarray:
    """Lengths [count, 3]: edge k goes from corner k to the next."""
    return np.linalg.norm(corners[..., :3] - np.roll(corners[..., :3], -1, axis=1), axis=2)


def halve(corners: np.ndarray, source: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split triangles at the middle of their longest edge. The halves come last, [2, len(which)]; the middle is their first corner."""
    picked = corners[which]
    order = (edges(picked).argmax(1)[:, None] + np.arange(3)) % 3
    a, b, apex = np.moveaxis(picked[np.arange(len(picked))[:, None], order], 1, 0)
    middle = (a + b) / 2
    halves = np.concatenate([np.stack([middle, apex, a], 1), np.stack([middle, b, apex], 1)])
    return np.concatenate([np.delete(corners, which, 0), halves]), np.concatenate([np.delete(source, which), np.tile(source[which], 2)])


def dice(triangles: np.ndarray, width: Width, ask: Ask, limit: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cut triangles [count, 3, 3], asking for at most `limit` points beside their own corners: first the largest, then those on borders
    of shadows, down to a texel. Returns triangles, how lit their corners are [count, 3, lights], and their normals."""
    normals, middles = normals_of(triangles), triangles.mean(1)
    source = np.flatnonzero(np.isfinite(normals).all(1))
    corners = triangles[source]
    own = len(corners)
    while True:  # three points for each new triangle, half of all
        lengths = edges(corners).max(1)
        which = np.flatnonzero(lengths > np.maximum(width(corners.mean(1)), lengths.max(initial=0.0) / 1.5))
        if not len(which) or len(corners) + len(which) > own + limit // 6:
            break
        corners, source = halve(corners, source, which)

    def asked(points: np.ndarray, of: np.ndarray) -> np.ndarray:
        inwards = middles[of] - points  # a lookup on the edge of a wall may be that of the next one
        far = np.linalg.norm(inwards, axis=1, keepdims=True) + 1e-30
        return ask(points + inwards / far * np.minimum(far / 2, width(points)[:, None] / 2), normals[of])

    corners = np.concatenate([corners, asked(corners.reshape(-1, 3), np.repeat(source, 3)).reshape(len(corners), 3, -1)], 2)
    left = limit - 3 * (len(corners) - own)
    while left > 0:
        lengths = edges(corners).max(1)
        which = np.flatnonzero((np.ptp(corners[..., 3:], axis=1).max(1) > 0.05) & (lengths > width(corners[..., :3].mean(1))))
        which = which[np.argsort(-lengths[which], kind="stable")[:left]]
        if not len(which):
            break
        corners, source = halve(corners, source, which)
        count = len(which)
        corners[-2 * count:-count, 0, 3:] = corners[-count:, 0, 3:] = asked(corners[-count:, 0, :3], source[-count:])
        left -= count
    return corners[..., :3], corners[..., 3:], normals[source]


def mesh_of(corners: np.ndarray) -> bpy.types.Mesh:
    """A mesh of separate triangles."""
    mesh = bpy.data.meshes.new(NAME)
    mesh.from_pydata(corners.reshape(-1, 3), [], np.arange(corners.size // 3).reshape(-1, 3))
    return mesh


def paint(mesh: bpy.types.Mesh, name: str, colours: np.ndarray) -> None:
    """Set and show a colour attribute. colours: [triangles * 3 corners, 3] as they are on the screen."""
    layer = mesh.color_attributes.get(name) or mesh.color_attributes.new(name, "BYTE_COLOR", "CORNER")
    layer.data.foreach_set("color_srgb", np.insert(colours, 3, 1.0, axis=1).astype(np.float32).ravel())
    mesh.color_attributes.active_color = layer
    mesh.color_attributes.render_color_index = list(mesh.color_attributes).index(layer)


def material() -> bpy.types.Material:
    """Shows the colours in rendered viewports, too."""
    made = bpy.data.materials.new(NAME)
    made.use_nodes = made.use_backface_culling = True  # what is open has two sides
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    colour, shine, out = (nodes.new("ShaderNode" + kind) for kind in ("VertexColor", "Emission", "OutputMaterial"))
    links.new(colour.outputs["Color"], shine.inputs["Color"])
    links.new(shine.outputs["Emission"], out.inputs["Surface"])
    return made


def show(scene: bpy.types.Scene, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """One object in a collection of its own, in front of what it covers, neither rendered nor selected."""
    shown, own = bpy.data.objects.new(NAME, mesh), bpy.data.collections.new(NAME)
    mesh.materials.append(material())
    for block in (shown, own, mesh, mesh.materials[0]):
        block[MARK] = True
    for block in (shown, own):
        block.hide_render = block.hide_select = True
    shown.show_in_front = True
    own.objects.link(shown)
    scene.collection.children.link(own)
    return shown


def shown_in(scene: bpy.types.Scene) -> bpy.types.Object | None:
    return next((ob for ob in scene.objects if MARK in ob and ob.type == "MESH"), None)


def clear() -> None:
    """Take away the overlay and all its datablocks."""
    for store in (bpy.data.objects, bpy.data.collections, bpy.data.meshes, bpy.data.materials):
        for block in [b for b in store if MARK in b]:
            store.remove(block)
