# Levels of the comparison with Cycles, and places in them whose light is known by Blender's rays. Runs inside Blender.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import pathlib

import bpy
import numpy as np
import truth
from mathutils import Vector

LIFT = 2e-5  # of the level's size: how far a ray starts above its surface
LEAST_SLOPE = 0.02  # cosine between normal and light; places with less do not face the light
TURN = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)  # Blender's axes to those of glTF


def open_level(path, suns=(), lamps=()):
    """suns: ways that light travels; lamps: places; Blender's axes."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    bpy.context.scene.world = None
    if not hasattr(np, "bool"):
        np.bool = bool  # Blender 3.4's importer beside a newer numpy
    bpy.ops.import_scene.gltf(filepath=str(path))
    for kind, values in (("SUN", suns), ("POINT", lamps)):
        for n, value in enumerate(values):
            light = bpy.data.lights.new(f"{kind.lower()} {n + 1}", kind)
            thing = bpy.data.objects.new(light.name, light)
            bpy.context.collection.objects.link(thing)
            if kind == "SUN":
                thing.rotation_mode, thing.rotation_quaternion = "QUATERNION", Vector(value).to_track_quat("-Z", "Y")
            else:
                thing.location, light.energy = value, 100
    for light in bpy.data.lights:
        light.shadow_soft_size = 0
        if light.type == "SUN":
            light.angle = 0
        if light.type == "SPOT":
            light.spot_blend = 0
    for name, cutoff in masks(path).items():
        material = bpy.data.materials[name]
        material["clip"], material["has_holes"] = cutoff, True
    bpy.context.view_layer.update()


def masks(path):
    """Materials of a GLB that have holes, by their names in Blender, with the cutoff of alpha."""
    data = pathlib.Path(path).read_bytes()
    document = json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])
    return {each.get("name", f"Material_{n}"): each.get("alphaCutoff", 0.5) for n, each in enumerate(document.get("materials", []))
            if each.get("alphaMode") == "MASK"}


def join():
    """All meshes as one object in the world's axes, with flat faces."""
    things = [thing for thing in bpy.context.scene.objects if thing.type == "MESH"]
    bpy.ops.object.select_all(action="DESELECT")
    for thing in things:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = things[0]
    bpy.ops.object.make_single_user(object=True, obdata=True)
    bpy.ops.object.parent_clear(type="CLEAR_KEEP_TRANSFORM")
    bpy.ops.object.transform_apply()
    if len(things) > 1:
        bpy.ops.object.join()
    one = bpy.context.view_layer.objects.active
    bpy.ops.mesh.customdata_custom_splitnormals_clear()
    one.data.polygons.foreach_set("use_smooth", np.zeros(len(one.data.polygons), bool))
    one.data.update()
    return one


class Places:
    """What lookups are asked for. origins, normals [n, 3] (normals are None in the air); in Blender's axes."""

    def __init__(self, origins, normals=None, triangles=None, weights=None):
        self.origins, self.normals, self.triangles, self.weights = origins, normals, triangles, weights

    def pick(self, which):
        return Places(*(None if part is None else part[which] for part in (self.origins, self.normals, self.triangles, self.weights)))

    def lines(self):
        """For vxs query."""
        rows = self.origins @ TURN.T if self.normals is None else np.hstack([self.origins @ TURN.T, self.normals @ TURN.T])
        return "".join(" ".join(map(repr, row)) + "\n" for row in rows.tolist())


class Rays(truth.Rays):
    """Images of other materials than those with holes are lightmaps that are being baked."""

    def is_hole(self, at, face, thing, matrix):
        mesh = thing.evaluated_get(self.depsgraph).data
        material = mesh.materials[mesh.polygons[face].material_index] if mesh.materials else None
        return bool(material and material.original.get("has_holes")) and super().is_hole(at, face, thing, matrix)


class Level:
    """The triangles of an object, and rays among them."""

    def __init__(self, thing):
        mesh = thing.data
        mesh.calc_loop_triangles()
        corners, order = np.empty(3 * len(mesh.vertices), np.float32), np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.vertices.foreach_get("co", corners)
        mesh.loop_triangles.foreach_get("vertices", order)
        self.triangles = corners.reshape(-1, 3)[order].reshape(-1, 3, 3).astype(float)
        across = np.cross(self.triangles[:, 1] - self.triangles[:, 0], self.triangles[:, 2] - self.triangles[:, 0])
        self.areas = np.linalg.norm(across, axis=1) / 2
        self.normals = across / np.maximum(2 * self.areas, 1e-30)[:, None]
        self.low, self.high = self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))
        self.lift = LIFT * float((self.high - self.low).max())
        self.rays, self.lamps = Rays(), truth.lamps()
        for lamp, thing in zip(self.lamps, (thing for thing in bpy.context.scene.objects if thing.type == "LIGHT")):
            lamp.thing = thing.name

    def on_surfaces(self, count, seed):
        """By area, less what lies inside of solids."""
        draw = np.random.default_rng(seed)
        chosen = draw.choice(len(self.areas), count, p=self.areas / self.areas.sum())
        u, v = draw.random((2, count))
        weights = np.stack([1 - np.sqrt(u), np.sqrt(u) * (1 - v), np.sqrt(u) * v], axis=1)
        places = Places((self.triangles[chosen] * weights[:, :, None]).sum(axis=1), self.normals[chosen], chosen, weights)
        return places.pick(~self.are_inside(places, draw))

    def in_air(self, count, seed):
        draw = np.random.default_rng(seed)
        places = Places(self.low + (self.high - self.low) * draw.random((count, 3)))
        return places.pick(~self.are_inside(places, draw))

    def are_inside(self, places, draw):
        """Whether more than half of 8 rays meet a back first."""
        backs = np.zeros(len(places.origins), int)
        for n in range(8):
            ways = draw.normal(size=places.origins.shape)
            if places.normals is not None:
                ways *= np.sign((ways * places.normals).sum(axis=1))[:, None]
            for m, way in enumerate(ways):
                hit = self.rays.hit(self.start(places, m), Vector(way).normalized(), 1e5)
                backs[m] += bool(hit) and hit[1].dot(Vector(way)) > 0
        return backs > 4

    def start(self, places, n):
        origin = Vector(places.origins[n])
        return origin if places.normals is None else origin + self.lift * Vector(places.normals[n])

    def light(self, places):
        """1 lit, 0 in shadow, NaN where a lamp does not shine: [places, lamps]."""
        lit = np.full((len(places.origins), len(self.lamps)), np.nan)
        for n in range(len(places.origins)):
            origin = self.start(places, n)
            for m, lamp in enumerate(self.lamps):
                if places.normals is None or lamp.towards(origin)[0].dot(Vector(places.normals[n])) >= LEAST_SLOPE:
                    found = truth.answer(self.rays, lamp, origin)
                    lit[n, m] = np.nan if found is None else found
        return lit

    def distances(self, places):
        """To each lamp, 1 to suns: [places, lamps]."""
        return np.stack([np.ones(len(places.origins)) if lamp.kind == "SUN" else
                         np.linalg.norm(np.array(lamp.at) - places.origins, axis=1) for lamp in self.lamps], axis=1)

    def irradiance(self, places):
        """Of each lamp without shadows, by Cycles' units: [places, lamps]; in the air of a surface that faces the lamp."""
        columns = []
        for lamp in self.lamps:
            energy = bpy.context.scene.objects[lamp.thing].data.energy
            to = np.broadcast_to(-np.array(lamp.way), places.origins.shape) if lamp.kind == "SUN" else np.array(lamp.at) - places.origins
            square = (to**2).sum(axis=1)
            slope = 1 if places.normals is None else (to * places.normals).sum(axis=1) / np.sqrt(square)
            inside = (to @ -np.array(lamp.way)) / np.sqrt(square) >= math.cos(lamp.half_angle) - 1e-9
            power = energy if lamp.kind == "SUN" else energy / (4 * math.pi * square)
            columns.append(np.where(inside & (slope >= LEAST_SLOPE), power * slope, 0))
        return np.stack(columns, axis=1)
