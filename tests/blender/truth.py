# Which light reaches which point, by Blender's own rays. Runs inside Blender. Points and normals are in Blender's axes.
#
# An answer is 1 lit, 0 in shadow, None where the light does not reach: beside a spot's cone, or farther than a range.
# SPDX-License-Identifier: GPL-3.0-or-later
import math
import random

import bpy
import numpy as np
from mathutils import Vector
from mathutils.geometry import barycentric_transform, intersect_point_tri_2d

STEPS = 200  # holes that a ray passes


def show_only_what_casts(left_out):
    """Rays meet what the viewport shows. So hide there what renders hide, and the objects `left_out`; in this process alone."""
    for collection in bpy.data.collections:
        collection.hide_viewport |= collection.hide_render
    for thing in bpy.context.scene.objects:
        thing.hide_viewport |= thing.hide_render or thing.name in left_out
    bpy.context.scene.frame_set(bpy.context.scene.frame_current)  # emitted particles are there again


class Image:
    """Alpha of an image that repeats, between the centres of its pixels as textures have it."""

    def __init__(self, image):
        self.width, self.height = image.size
        pixels = np.empty(4 * self.width * self.height, np.float32)
        image.pixels.foreach_get(pixels)
        self.alpha = pixels[3::4].reshape(self.height, self.width)

    def at(self, u, v):
        x, y = u * self.width - 0.5, v * self.height - 0.5
        i, j = math.floor(x), math.floor(y)
        columns, rows = (i % self.width, (i + 1) % self.width), (j % self.height, (j + 1) % self.height)
        low, high = (self.alpha[row, columns[0]] * (1 - x + i) + self.alpha[row, columns[1]] * (x - i) for row in rows)
        return low * (1 - y + j) + high * (y - j)


class Rays:
    def __init__(self):
        self.depsgraph = bpy.context.evaluated_depsgraph_get()
        self.scene = bpy.context.scene
        self.triangles = {}  # of a mesh and a polygon: corners and their texture coordinates
        self.images = {}
        self.closed = self.find_closed()

    def find_closed(self):
        """Objects whose faces close: an instance of geometry nodes has the name of their object, and a mesh of its own."""
        of_mesh, closed = {}, {}
        for instance in self.depsgraph.object_instances:
            if instance.object.type == "MESH":
                mesh = instance.object.data
                if mesh.as_pointer() not in of_mesh:
                    of_mesh[mesh.as_pointer()] = is_closed(mesh)
                closed[key_of(instance.object, instance.matrix_world)] = of_mesh[mesh.as_pointer()]
        return closed

    def hit(self, origin, way, distance):
        found, at, normal, face, thing, matrix = self.scene.ray_cast(self.depsgraph, origin, way, distance=distance)
        return (at, normal, face, thing, matrix) if found else None

    def is_hole(self, at, face, thing, matrix):
        """Whether the material has a hole where a ray meets a face."""
        mesh = thing.evaluated_get(self.depsgraph).data
        if not mesh.materials or not mesh.uv_layers:
            return False
        material = mesh.materials[mesh.polygons[face].material_index]
        texture = next((node for node in material.node_tree.nodes if node.type == "TEX_IMAGE"), None) if material else None
        if not texture:
            return False
        uv = self.texture_place(mesh, face, matrix.inverted() @ at)
        image = self.images.get(texture.image.name) or self.images.setdefault(texture.image.name, Image(texture.image))
        return image.at(uv.x, uv.y) < material.original["clip"]

    def texture_place(self, mesh, face, at):
        key = mesh.name, face
        if key not in self.triangles:
            mesh.calc_loop_triangles()
            layer = mesh.uv_layers.active.data
            self.triangles[key] = [([mesh.vertices[v].co.copy() for v in t.vertices], [layer[loop].uv.to_3d() for loop in t.loops])
                                   for t in mesh.loop_triangles if t.polygon_index == face]
        places = []
        for corners, uvs in self.triangles[key]:
            uv = barycentric_transform(at, *corners, *uvs)
            places.append(uv)
            if intersect_point_tri_2d(uv.to_2d(), *(corner.to_2d() for corner in uvs)):
                return uv
        return places[0]

    def is_blocked(self, origin, way, distance):
        """Whether a ray meets a surface, not counting holes, before a distance."""
        step = 1e-5 * max(1.0, origin.length)
        for _ in range(STEPS):
            hit = self.hit(origin, way, distance)
            if not hit:
                return False
            at, _, face, thing, matrix = hit
            if not self.is_hole(at, face, thing, matrix):
                return True
            distance -= (at - origin).length + step
            origin = at + step * way
            if distance <= 0:
                return False
        raise RuntimeError("a ray passes too many holes")


class Lamp:
    """A light with Blender's own numbers."""

    def __init__(self, thing):
        users = [other for other in bpy.context.scene.objects if other.data == thing.data]
        self.name = thing.data.name if len(users) == 1 else thing.name
        self.kind, matrix = thing.data.type, thing.matrix_world
        self.at = matrix.translation.copy()
        self.way = -matrix.col[2].to_3d().normalized()
        self.half_angle = thing.data.spot_size / 2 if self.kind == "SPOT" else math.pi
        self.range = thing.data.cutoff_distance if self.kind != "SUN" and thing.data.use_custom_distance else math.inf

    def towards(self, point):
        """The unit vector to the light, and the distance."""
        if self.kind == "SUN":
            return -self.way, 1e5
        away = self.at - point
        return away.normalized(), away.length

    def reaches(self, point):
        to, distance = self.towards(point)
        return self.kind == "SUN" or distance <= self.range and (-to).angle(self.way, 0) <= self.half_angle


def lamps():
    return [Lamp(thing) for thing in bpy.context.scene.objects if thing.type == "LIGHT"]


def answer(rays, lamp, point):
    if not lamp.reaches(point):
        return None
    to, distance = lamp.towards(point)
    return 0 if rays.is_blocked(point, to, distance) else 1


# receivers ----------------------------------------------------------------------------------------------------------------------


def world_triangles(rays):
    """Corners [n, 3, 3] of every triangle that the viewport shows."""
    parts = []
    for instance in rays.depsgraph.object_instances:
        thing = instance.object
        if thing.type != "MESH" or not instance.show_self:
            continue
        mesh = thing.data
        mesh.calc_loop_triangles()
        corners, order = np.empty(3 * len(mesh.vertices), np.float32), np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.vertices.foreach_get("co", corners)
        mesh.loop_triangles.foreach_get("vertices", order)
        matrix = np.array(instance.matrix_world)
        corners = corners.reshape(-1, 3).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
        if instance.matrix_world.determinant() < 0:
            order = order.reshape(-1, 3)[:, ::-1].ravel()
        parts.append(corners[order].reshape(-1, 3, 3))
    triangles = np.concatenate(parts)
    return triangles[np.lexsort(triangles.mean(axis=1).round(3).T)]  # Blender's order differs from run to run


def receivers(rays, count, seed):
    """Points on triangles with their normals, as rows of 6: of half of the points each triangle has as many, of the others by area."""
    triangles = world_triangles(rays)
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(across, axis=1)
    solid = np.flatnonzero(areas > 1e-9 * areas.max())
    draw = random.Random(seed)
    chosen = draw.choices(solid, k=count // 2) + draw.choices(solid, areas[solid], k=count - count // 2)
    rows = []
    for n in chosen:
        u, v = draw.random(), draw.random()
        u, v = (1 - u, 1 - v) if u + v > 1 else (u, v)
        a, b, c = triangles[n]
        rows.append([*(a + u * (b - a) + v * (c - a)), *(across[n] / areas[n])])
    return np.array(rows)


# why an answer differs -------------------------------------------------------------------------------------------------------------


class Explainer:
    """Explains answers of a file that differ from the truth, by shadow edges that lie within a texel and a half, and by the bias.

    texel, voxel   the side of a texel and the depth of a voxel, in metres; of punctual lights at one metre
    """

    RADII = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)  # texels
    DIRECTIONS = 16
    DEPTHS = (0, 1, 2, 3)  # voxels off the surface, along the light's ray: the bias is at most these

    def __init__(self, rays, lamp, texel, voxel):
        self.rays, self.lamp, self.texel, self.voxel = rays, lamp, texel, voxel

    def places(self, point, normal, radii):
        """Places about a point, with their distance in texels, on the plane of its surface along the light's rays; and one voxel off
        the surface, along the light's ray."""
        to, distance = self.lamp.towards(point)
        scale = 1 if self.lamp.kind == "SUN" else distance
        slope = to.dot(normal)
        beside = to.orthogonal().normalized()
        other = to.cross(beside)
        for radius in radii:
            for n in range(self.DIRECTIONS if radius else 1):
                angle = 2 * math.pi * n / self.DIRECTIONS
                step = (math.cos(angle) * beside + math.sin(angle) * other) * radius * self.texel * scale
                on_plane = step - to * (step.dot(normal) / slope) if abs(slope) > 0.02 else step
                yield radius, point + on_plane, math.copysign(self.voxel * scale, slope) * to

    def explain(self, point, normal, given):
        """A place that has the given answer: its distance in texels and its voxels off the surface; "inside" of a solid; or None."""
        if given == 1 and any(is_inside(self.rays, place + depth * deep) for _, place, deep in self.places(point, normal, (0.0,))
                              for depth in self.DEPTHS):
            return "inside"
        for radius, place, deep in self.places(point, normal, (0.0, *self.RADII)):
            for depth in self.DEPTHS if given == 1 else (0,):
                if answer(self.rays, self.lamp, place + depth * deep) == given:
                    return [radius, depth]
        return None


def is_inside(rays, point):
    """Whether a point is inside an object: a ray from it meets some object an odd number of times, of those whose faces close."""
    counts = {}
    way, origin = Vector((0.267, 0.534, 0.802)).normalized(), point
    for _ in range(STEPS):
        hit = rays.hit(origin, way, 1e5)
        if not hit:
            break
        at, _, _, thing, matrix = hit
        key = key_of(thing, matrix)
        counts[key] = counts.get(key, 0) + 1
        origin = at + 1e-5 * max(1.0, at.length) * way
    return any(count % 2 and rays.closed[key] for key, count in counts.items())


def key_of(thing, matrix):
    return thing.name, tuple(round(number, 4) for row in matrix for number in row)


def is_closed(mesh):
    uses = {}
    for polygon in mesh.polygons:
        for key in polygon.edge_keys:
            uses[key] = uses.get(key, 0) + 1
    return bool(uses) and all(count == 2 for count in uses.values())
