# One view of a level three times: truth by rays, vxs, and the lightmap that is baked. Runs inside Blender.
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
import levels
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

AMBIENT = 0.25
GAP = 4  # pixels of white between pictures


def view(level, camera, width, height):
    """Places that a camera sees, one for each sample, row by row from the top; and which samples see one."""
    eye, target, half = Vector(camera["eye"]), Vector(camera["target"]), np.tan(np.radians(camera["degrees"]) / 2)
    ahead = (target - eye).normalized()
    right = ahead.cross(Vector((0, 0, 1))).normalized()
    up = right.cross(ahead)
    corners = level.triangles.reshape(-1, 3).tolist()
    tree = BVHTree.FromPolygons(corners, np.arange(len(corners)).reshape(-1, 3).tolist(), all_triangles=True)
    seen, origins, normals, triangles = np.zeros(width * height, bool), [], [], []
    for n in range(width * height):
        x, y = (n % width + 0.5) / width * 2 - 1, 1 - (n // width + 0.5) / height * 2
        way = (ahead + right * (x * half * width / height) + up * (y * half)).normalized()
        at, normal, triangle, _ = tree.ray_cast(eye, way)
        if at is not None:
            seen[n] = True
            origins.append(at)
            normals.append(-normal if normal.dot(way) > 0 else normal)
            triangles.append(triangle)
    origins, triangles = np.array(origins), np.array(triangles)
    return levels.Places(origins, np.array(normals), triangles, weights_of(level.triangles[triangles], origins)), seen


def weights_of(corners, points):
    """Barycentric coordinates of points of triangles."""
    a, b, c = np.moveaxis(corners, 1, 0)
    across = np.cross(b - a, c - a)
    square = np.maximum((across**2).sum(axis=1), 1e-30)
    v = (np.cross(points - a, c - a) * across).sum(axis=1) / square
    w = (np.cross(b - a, points - a) * across).sum(axis=1) / square
    return np.stack([1 - v - w, v, w], axis=1)


def write(comparison):
    """Truth, vxs, lightmap from left to right, as PNG."""
    asked, level, white = comparison.request["picture"], comparison.level, comparison.surfaces.white
    width, height, samples = asked["width"], asked["height"], 2
    places, seen = view(level, asked, width * samples, height * samples)
    lamps = level.irradiance(places)
    shares = np.nan_to_num(level.light(places)), comparison.vxs.share(places, comparison.names)
    lights = (*((share * lamps).sum(axis=1) for share in shares), comparison.map.light(places))
    parts = []
    for light in lights:
        flat = np.ones(len(seen))
        flat[seen] = np.clip(AMBIENT * (0.6 + 0.4 * places.normals[:, 2]) + (1 - AMBIENT) * light / white, 0, 1)
        parts += [np.ones((height, GAP)), flat.reshape(height, samples, width, samples).mean(axis=(1, 3)) ** (1 / 2.2)]
    save(np.hstack(parts[1:]), asked["file"])


def save(grey, path):
    """Rows from the top, in 64 greys: a third of the bytes of 256."""
    image = bpy.data.images.new("picture", grey.shape[1], grey.shape[0], alpha=False)
    image.colorspace_settings.name = "Non-Color"
    rows = np.round(grey[::-1] * 63) / 63
    image.pixels.foreach_set(np.stack([rows, rows, rows, np.ones_like(rows)], axis=2).astype(np.float32).ravel())
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.compression = "PNG", "BW", "8", 100
    image.save_render(path)
