# The level as Blender shows it, in a GLB: what casts shadows, every instance of it, and the lights.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import itertools
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from .casters import Casters, instancer
from .glb import Glb
from .images import Images
from .lights import gltf_light
from .materials import Appearance, appearance
from .settings import own

Y_UP = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]  # from Blender's axes to glTF's, by columns: exact, as no quaternion is
NOT_BAKED = {"CURVES": "are hair curves", "POINTCLOUD": "are point clouds", "VOLUME": "are volumes"}


@dataclass
class Level:
    """What was written, and what was not."""
    path: str = ""
    region: str = ""  # name of its object
    instances: int = 0
    lights: dict[str, bpy.types.Light] = field(default_factory=dict)  # by their names in the file
    objects: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))  # name in the file: what to select for it
    left_out: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))  # why objects cast no shadow: their names
    notes: list[str] = field(default_factory=list)  # warnings, with names in quotes


@dataclass
class Surface:
    """Triangles of an evaluated object in its own space."""
    points: np.ndarray  # [points, 3] float32
    corners: np.ndarray  # [corners] the point of each
    triangles: np.ndarray  # [triangles, 3] corners
    slots: np.ndarray | None  # [triangles] the material of each; None: all have the first
    materials: list[bpy.types.Material | None]
    uvs: dict[str, np.ndarray]  # [corners, 2] float32, of glTF


@dataclass(order=True)
class Place:
    """An instance; they are sorted, as the order in which Blender lists them may change."""
    key: tuple[str, str, tuple[int, ...]]
    matrix: list[float] = field(compare=False)  # by columns
    surface: Any = field(compare=False, default=None)
    light: bpy.types.Object | None = field(compare=False, default=None)


def read(collection: Any, name: str, width: int, dtype: type) -> np.ndarray:
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def slots_of(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> list[bpy.types.Material | None]:
    """Materials by index: those of the object where its slots say so, else those of the evaluated mesh."""
    slots = list(mesh.materials) or [None]
    for i, slot in enumerate(ob.material_slots[:len(slots)]):
        if slot.link == "OBJECT":
            slots[i] = slot.material
    return [m.original if m else None for m in slots]


def uv_layer(mesh: bpy.types.Mesh, name: str) -> np.ndarray | None:
    layer = mesh.uv_layers.get(name) if name else None
    layer = layer or next((u for u in mesh.uv_layers if u.active_render), None)
    if layer is None:
        return None
    uv = read(layer.data, "uv", 2, np.float32)
    uv[:, 1] = 1 - uv[:, 1]
    return uv


class Gatherer:
    """Reads instances of a depsgraph, one after the other: each is valid for one step only."""

    def __init__(self, depsgraph: bpy.types.Depsgraph, scene: bpy.types.Scene, level: Level, receivers: bool = False) -> None:
        """receivers: also take what is rendered and casts no shadow."""
        self.level, self.receivers = level, receivers
        self.casters = Casters(scene, scene.objects.get(level.region) or scene.vxs.region)
        self.surfaces: dict[tuple[int, ...], Surface] = {}
        self.looks: dict[bpy.types.Material, Appearance] = {}
        self.places: list[Place] = []
        for instance in depsgraph.object_instances:
            self.take(instance)
        self.places.sort()

    def take(self, instance: bpy.types.DepsgraphObjectInstance) -> None:
        ob = instance.object
        if ob.type not in ("MESH", "LIGHT", *NOT_BAKED) or not self.casters.is_rendered(instance):
            return
        name = ob.original.name
        why = NOT_BAKED.get(ob.type) or ob.type == "MESH" and self.casters.reason(instance)
        if why:
            self.level.left_out[why].add(name)
        if why and not (self.receivers and ob.type == "MESH" and instance.show_self):
            return
        shown_by = instancer(instance)
        by = shown_by.name if shown_by else name
        place = Place((by, name, tuple(instance.persistent_id)), [v for column in instance.matrix_world.col for v in column])
        if ob.type == "LIGHT":
            place.light = ob.original
        else:
            place.surface = self.surface(ob)
        if place.light or len(place.surface.triangles):
            self.places.append(place)
            self.level.objects[name].update((name, by))

    def surface(self, ob: bpy.types.Object) -> Surface:
        slots = slots_of(ob, ob.data)
        key = (ob.data.as_pointer(), *(m.as_pointer() if m else 0 for m in slots))
        if key not in self.surfaces:
            self.surfaces[key] = self.read_surface(ob.to_mesh(), slots)
            ob.to_mesh_clear()
        return self.surfaces[key]

    def read_surface(self, mesh: bpy.types.Mesh, slots: list[bpy.types.Material | None]) -> Surface:
        mesh.calc_loop_triangles()
        triangles = mesh.loop_triangles
        wanted = {look.texture.uv_map for look in map(self.look, slots) if look and look.texture}
        layers = {name: uv_layer(mesh, name) for name in sorted(wanted)}
        return Surface(read(mesh.vertices, "co", 3, np.float32), read(mesh.loops, "vertex_index", 1, np.int32),
                       read(triangles, "loops", 3, np.int32),
                       np.minimum(read(triangles, "material_index", 1, np.int32), len(slots) - 1) if len(slots) > 1 else None,
                       slots, {name: uv for name, uv in layers.items() if uv is not None})

    def look(self, material: bpy.types.Material | None) -> Appearance | None:
        if material and material not in self.looks:
            self.looks[material] = appearance(material)
        return self.looks[material] if material else None


class Writer:
    """Puts what was gathered into a GLB, each mesh, material and image once."""

    def __init__(self, gatherer: Gatherer) -> None:
        self.level, self.looks = gatherer.level, gatherer.looks
        self.glb, self.images = Glb(), Images()
        self.meshes: dict[int, int | None] = {}
        self.materials: dict[bpy.types.Material, int] = {}
        self.light_users: dict[bpy.types.Light, set[bpy.types.Object]] = defaultdict(set)
        for light in (place.light for place in gatherer.places if place.light):
            self.light_users[light.data].add(light)
        self.nodes = [node for place in gatherer.places if (node := self.node(place)) is not None]

    def write(self, scene: bpy.types.Scene) -> None:
        root = self.glb.add("nodes", {"name": "", "matrix": Y_UP, "children": self.nodes} if self.nodes else {"name": ""})
        self.glb.json |= {"scene": 0, "scenes": [{"name": scene.name, "nodes": [root]}]}
        self.glb.write(self.level.path)

    def node(self, place: Place) -> int | None:
        if place.light:
            return self.light_node(place)
        mesh = self.mesh(place.surface, place.key[1])
        self.level.instances += 1
        return self.glb.add("nodes", {"name": place.key[1], "mesh": mesh, "matrix": place.matrix})

    def light_node(self, place: Place) -> int | None:
        light = place.light.data
        value = gltf_light(light, place.light.matrix_world)
        if not own(light).bake:
            return None
        if value is None:
            self.level.notes.append(f"light '{place.light.name}' is an area light, which is not baked: use a point, spot or sun light")
            return None
        base = light.name if len(self.light_users[light]) == 1 else place.light.name
        names = (f"{base} {n}" if n > 1 else base for n in itertools.count(1))  # of instances of one light
        name = next(name for name in names if name not in self.level.lights)
        self.level.lights[name] = light
        self.level.objects[name].update((place.light.name, place.key[0]))
        index = self.glb.add("lights", value | {"name": name}, "KHR_lights_punctual")
        return self.glb.add("nodes", {"name": name, "matrix": place.matrix, "extensions": {"KHR_lights_punctual": {"light": index}}})

    def mesh(self, surface: Surface, name: str) -> int:
        if id(surface) not in self.meshes:
            primitives = [self.primitive(surface, slot) for slot in range(len(surface.materials))]
            self.meshes[id(surface)] = self.glb.add("meshes", {"name": name, "primitives": [p for p in primitives if p]})
        return self.meshes[id(surface)]

    def primitive(self, surface: Surface, slot: int) -> dict[str, Any] | None:
        triangles = surface.triangles if surface.slots is None else surface.triangles[surface.slots == slot]
        if not len(triangles):
            return None
        material = surface.materials[slot]
        texture = self.looks[material].texture if material else None
        uv = surface.uvs.get(texture.uv_map) if texture else None
        if uv is None:
            used, indices = compact(surface.corners[triangles], len(surface.points))
            attributes = {"POSITION": surface.points[used]}
        else:
            used, indices = compact(triangles, len(surface.corners))
            attributes = {"POSITION": surface.points[surface.corners[used]], "TEXCOORD_0": uv[used]}
        value: dict[str, Any] = {"attributes": {name: self.glb.accessor(array) for name, array in attributes.items()},
                                 "indices": self.glb.accessor(indices.astype(np.uint32).ravel())}
        if material:
            value["material"] = self.material(material)
        return value

    def material(self, material: bpy.types.Material) -> int:
        if material not in self.materials:
            look = self.looks[material]
            value = look.value
            if look.texture:
                info = self.images.texture_info(self.glb, look.texture)
                value = value | {"pbrMetallicRoughness": value["pbrMetallicRoughness"] | {"baseColorTexture": info}}
            if look.fault:
                self.level.notes.append(f"material '{material.name}': {look.fault}")
            for extension in value.get("extensions", ()):
                self.glb.use(extension)
            self.materials[material] = self.glb.add("materials", value)
        return self.materials[material]


def compact(indices: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The numbers below count that are used, and the indices among these."""
    is_used = np.zeros(count, bool)
    is_used[indices.ravel()] = True
    return np.flatnonzero(is_used), (np.cumsum(is_used) - 1)[indices]


def gather(context: bpy.types.Context, level: Level, receivers: bool = False) -> tuple[Gatherer, Writer]:
    """What casts, and with `receivers` what else is rendered; Writer.write() writes it. Nothing in Blender changes."""
    for ob in context.view_layer.objects:
        if ob and ob.mode != "OBJECT":  # None: removed, as Blender 5.0 notes later
            ob.update_from_editmode()
    gatherer = Gatherer(context.evaluated_depsgraph_get(), context.scene, level, receivers)
    return gatherer, Writer(gatherer)
