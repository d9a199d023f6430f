# Requests to previews and exports of the add-on, inside Blender (inside.py).
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
import numpy as np
import truth
from mathutils import Vector

KINDS = ("objects", "meshes", "materials", "collections", "images", "node_groups", "lights", "cameras", "scenes")


class PreviewRequests:
    def run(self, operator, **arguments):
        """What an operator of the add-on returns, or the error that it raises."""
        try:
            return list(getattr(bpy.ops.vxs, operator)(**arguments))
        except RuntimeError as error:
            return str(error).strip()

    def datablocks(self):
        return {kind: sorted(block.name for block in getattr(bpy.data, kind)) for kind in KINDS}

    def overlay(self):
        """Of the preview's object: places of corners [3 * triangles, 3] as they are on the scene's surface, normals, colours."""
        shown = bpy.data.objects["vxs preview"]
        mesh, count = shown.data, len(shown.data.polygons)
        corners, normals, colours = np.empty(9 * count, np.float32), np.empty(3 * count, np.float32), np.empty(12 * count, np.float32)
        mesh.vertices.foreach_get("co", corners)
        mesh.polygons.foreach_get("normal", normals)
        mesh.color_attributes.active_color.data.foreach_get("color_srgb", colours)
        normals = np.repeat(normals.reshape(-1, 3), 3, axis=0).astype(float)
        return corners.reshape(-1, 3) - normals * shown["vxs_hair"], normals, colours.reshape(-1, 4)[:, :3]

    def colours(self):
        """Those of the preview, each once, from 0 to 255."""
        return np.unique(np.rint(self.overlay()[2] * 255).astype(int), axis=0).tolist()

    def preview_corners(self, light, count, seed, texel, voxel):
        """Corners by chance whose colours are those of light or shadow: how many, how many of them are lit, how many differ from
        Blender's rays, and those that no edge of a shadow explains within 1.5 texels, with half a texel for where they are looked up."""
        places, normals, colours = self.overlay()
        truth.show_only_what_casts(set())
        rays = truth.Rays()
        lamp = next(lamp for lamp in truth.lamps() if lamp.name == light)
        explainer = truth.Explainer(rays, lamp, texel * 4 / 3, voxel)
        inwards = np.repeat(places.reshape(-1, 3, 3).mean(1), 3, axis=0) - places  # a corner itself may be that of two surfaces
        far = np.linalg.norm(inwards, axis=1, keepdims=True)
        places = places + inwards * np.minimum(0.5, 0.5 * texel / far)
        grey = (colours[:, 0] - 0.06) / 0.94
        sure = np.flatnonzero((np.ptp(colours, axis=1) < 0.004) & ((grey < 0.01) | (grey > 0.99)))
        chosen = np.random.default_rng(seed).choice(sure, min(count, len(sure)), replace=False)
        lit, differ, unexplained = 0, 0, []
        for n in chosen.tolist():
            place, normal, given = Vector(places[n]) + 2e-4 * Vector(normals[n]), Vector(normals[n]), round(float(grey[n]))
            lit += given
            is_away = lamp.towards(place)[0].dot(normal) < 0  # dark, whatever a ray from beside the surface meets
            if (0 if is_away else truth.answer(rays, lamp, place)) != given:
                differ += 1
                if explainer.explain(place, normal, given) is None:
                    unexplained.append([list(place), list(normal), given])
        return {"count": len(chosen), "of": len(places) // 3, "lit": lit, "differ": differ, "unexplained": unexplained}

    def camera(self, width, height, location, target, **more):
        """A camera of the scene, and the size of its pictures."""
        data = bpy.data.cameras.new("eye")
        thing = bpy.data.objects.new("eye", data)
        thing.location = location
        thing.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
        thing.rotation_euler.rotate_axis("Z", more.pop("roll", 0.0))
        for name, value in more.items():
            setattr(data, name, value)
        scene = bpy.context.scene
        scene.collection.objects.link(thing)
        scene.camera = thing
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100

    def seen(self, x, y):
        """What Blender's own rays meet behind a place of the picture, in pixels: "sky", "lit" or "dark" floor, or another thing."""
        scene = bpy.context.scene
        eye, render = scene.camera, scene.render
        right, low_right, low, high = (eye.matrix_world @ corner for corner in eye.data.view_frame(scene=scene))
        place = low + (low_right - low) * (x / render.resolution_x) + (high - low) * (y / render.resolution_y)
        if eye.data.type == "ORTHO":
            start, way = place, -eye.matrix_world.col[2].to_3d().normalized()
        else:
            start, way = eye.location, (place - eye.location).normalized()
        hit = self.rays.hit(start, way, 1e5)
        if not hit or hit[3].name != "floor":
            return hit[3].name if hit else "sky"
        return "lit" if truth.answer(self.rays, truth.lamps()[0], hit[0] + 2e-4 * hit[1]) else "dark"

    def picture_colours(self, count, seed):
        """Of pixels by chance that see one thing, and so do places 2 pixels beside them: the colours of each thing."""
        truth.show_only_what_casts(set())
        self.rays = truth.Rays()
        image = bpy.data.images["vxs picture"]
        width, height = image.size
        pixels = np.empty(4 * width * height, np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(height, width, 4)
        colours, draw = {}, np.random.default_rng(seed)
        for x, y in zip(draw.integers(0, width, count).tolist(), draw.integers(0, height, count).tolist()):
            things = {self.seen(x + 0.5 + dx, y + 0.5 + dy) for dx, dy in ((0, 0), (-2, 0), (2, 0), (0, -2), (0, 2))}
            if len(things) == 1:
                colours.setdefault(things.pop(), []).append(pixels[y, x, :3].tolist())
        return {"size": [width, height], "colours": colours}

    def export_level(self, path, **more):
        """As a user exports a level with lights: what the exporter returns, or its error."""
        try:
            return list(bpy.ops.export_scene.gltf(filepath=path, **{"export_lights": True, "export_animations": False, **more}))
        except RuntimeError as error:
            return str(error).strip()
