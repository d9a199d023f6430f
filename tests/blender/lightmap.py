# A lightmap of direct light as Blender makes it: a second UV layer by smart_project, and Cycles' diffuse bake. Runs inside Blender.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import time

import bpy
import numpy as np

MARGIN = 2  # texels around islands that take the values of their borders
LEAST_APART = 1 / 2048  # of the image's side: what a level of 50000 islands has room for
LAYER = "lightmap"
SIDES = 64, 16000  # of images; WebP has no larger ones
GAMMA = 2.2


class Lightmap:
    """Of an object. On disk it is WebP of 8 bits a channel, all of them alike; quality 100 loses nothing.

    white   irradiance that is stored as 255
    """

    def __init__(self, thing, folder, white):
        self.thing, self.folder, self.white = thing, folder, white
        thing.data.uv_layers.new(name=LAYER)
        make_matte(thing.data.materials)
        scene = bpy.context.scene
        scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        scene.cycles.max_bounces = 0
        scene.view_settings.view_transform = "Raw"

    def prepare(self, side):
        """UV2 for images of this side. Returns seconds."""
        self.side = side
        self.thing.data.uv_layers[LAYER].active = True
        bpy.context.view_layer.objects.active = self.thing
        start = time.perf_counter()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.uv.smart_project(margin_method="FRACTION", island_margin=min(1 / side, LEAST_APART))
        bpy.ops.object.mode_set(mode="OBJECT")
        self.corners = None
        return time.perf_counter() - start

    def corners_of_triangles(self):
        """UV2 of each corner of each triangle: [n, 3, 2]."""
        if self.corners is None:
            mesh = self.thing.data
            mesh.calc_loop_triangles()
            loops, places = np.empty(3 * len(mesh.loop_triangles), np.int32), np.empty(2 * len(mesh.loops), np.float32)
            mesh.loop_triangles.foreach_get("loops", loops)
            mesh.uv_layers[LAYER].data.foreach_get("uv", places)
            self.corners = places.reshape(-1, 2)[loops].reshape(-1, 3, 2).astype(float)
        return self.corners

    def coverage(self):
        """Share of the image that triangles cover."""
        a, b, c = np.moveaxis(self.corners_of_triangles(), 1, 0)
        return float(np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum() / 2)

    def bake(self, samples):
        """Returns seconds."""
        bpy.context.scene.cycles.samples = samples
        bpy.ops.object.select_all(action="DESELECT")
        self.thing.select_set(True)
        image = self.new_image()
        print(f"lightmap: {self.side} x {self.side}, {samples} samples", flush=True)
        start = time.perf_counter()
        bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT"}, margin=MARGIN, margin_type="EXTEND", use_clear=False)
        seconds = time.perf_counter() - start
        values = np.empty(4 * self.side**2, np.float32)
        image.pixels.foreach_get(values)
        bpy.data.images.remove(image)
        for material in set(self.thing.data.materials):  # their other images are those of holes
            material.node_tree.nodes.remove(material.node_tree.nodes[LAYER])
        self.irradiance = np.pi * values[::4].reshape(self.side, self.side)
        return seconds

    def new_image(self):
        """An image that a bake writes to, because an active node of each material has it."""
        image = bpy.data.images.new(LAYER, self.side, self.side, alpha=False, float_buffer=True)
        for material in set(self.thing.data.materials):
            nodes = material.node_tree.nodes
            node = nodes.new("ShaderNodeTexImage")
            node.name, node.image, nodes.active = LAYER, image, node
        return image

    def store(self, quality):
        """Write the image, and read it back: what was read counts from now on. Returns bytes."""
        settings = bpy.context.scene.render.image_settings
        settings.file_format, settings.color_mode, settings.quality = "WEBP", "RGB", quality
        path = os.path.join(self.folder, "lightmap.webp")
        image = bpy.data.images.new("stored", self.side, self.side, alpha=False)
        image.colorspace_settings.name = "Non-Color"
        values = np.round(np.clip(self.irradiance / self.white, 0, 1) ** (1 / GAMMA) * 255) / 255
        image.pixels.foreach_set(np.stack([values, values, values, np.ones_like(values)], axis=2).ravel())
        image.save_render(path)
        bpy.data.images.remove(image)
        self.stored = pixels_of(path)
        if quality == 100:
            assert np.abs(self.stored - values * 255).max() < 0.5, "quality 100 loses nothing"
        return os.path.getsize(path)

    def light(self, places):
        """Irradiance at places on surfaces, bilinear."""
        uv = (self.corners_of_triangles()[places.triangles] * places.weights[:, :, None]).sum(axis=1)
        x, y = np.clip(uv * self.side - 0.5, 0, self.side - 1.001).T
        i, j = x.astype(int), y.astype(int)
        u, v, m = x - i, y - j, (self.stored / 255.0) ** GAMMA
        return self.white * ((m[j, i] * (1 - u) + m[j, i + 1] * u) * (1 - v) + (m[j + 1, i] * (1 - u) + m[j + 1, i + 1] * u) * v)


def make_matte(materials):
    """White materials; those with holes keep them, as alpha against the cutoff."""
    matte = bpy.data.materials.new("matte")
    matte.use_nodes = True
    connect(matte, matte.node_tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0])
    if not materials:
        materials.append(matte)
    for n, material in enumerate(materials):
        if not material or not material.get("has_holes"):
            materials[n] = matte
            continue
        nodes, links = material.node_tree.nodes, material.node_tree.links
        mix, above = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeMath")
        above.operation, above.inputs[1].default_value = "GREATER_THAN", material["clip"]
        links.new(next(node for node in nodes if node.type == "TEX_IMAGE").outputs["Alpha"], above.inputs[0])
        links.new(above.outputs[0], mix.inputs[0])
        links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        links.new(nodes.new("ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[2])
        connect(material, mix.outputs[0])


def connect(material, shader):
    output = next(node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL")
    material.node_tree.links.new(shader, output.inputs["Surface"])


def pixels_of(path):
    """The first channel of an image, 0 to 255, lowest row first."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    values = np.round(values[::4].reshape(image.size[1], image.size[0]) * 255).astype(np.uint8)
    bpy.data.images.remove(image)
    return values


def side_of_bytes(bake, wanted, start):
    """The side of images that take so many bytes. bake(side) returns bytes of a trial, start is a pair of these."""
    side, size = start
    best, power = None, 0.65
    for _ in range(4):
        before, side = (side, size), int(np.clip(round(side * (wanted / size) ** power), SIDES[0], 2 * side))
        size = bake(side)
        if best is None or abs(size / wanted - 1) < abs(best[1] / wanted - 1):
            best = side, size
        if abs(size / wanted - 1) < 0.04 or side in (SIDES[0], before[0]):
            break
        power = float(np.clip(np.log(side / before[0]) / (np.log(size / before[1]) or 1), 0.4, 0.8))
    return best[0]
