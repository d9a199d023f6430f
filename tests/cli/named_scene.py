# Scenes of named nodes, each with a mesh of its own, written as glTF text: for tests of messages about nodes by their names.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import math
import struct

from small_scene import box, turned


def inside_out(mesh):
    positions, triangles = mesh
    return positions, [t[::-1] for t in triangles]


def cube(size=1, middle=(0, 0, 0)):
    half = size / 2
    return box([c - half for c in middle], [c + half for c in middle])


def plane(size, y=0):
    """Two triangles that look up."""
    h = size / 2
    return [(-h, y, -h), (h, y, -h), (h, y, h), (-h, y, h)], [(0, 2, 1), (0, 3, 2)]


def dome(radius, rings=8, sides=16, lowest=-1):
    """A sphere that looks outward, without what lies below lowest * radius."""
    positions = [(0, radius, 0)]
    for ring in range(1, rings + 1):
        angle = math.pi * ring / (rings + 1)
        if math.cos(angle) < lowest:
            break
        positions += [(radius * math.sin(angle) * math.cos(2 * math.pi * n / sides), radius * math.cos(angle),
                       radius * math.sin(angle) * math.sin(2 * math.pi * n / sides)) for n in range(sides)]
    triangles = [(0, 1 + (n + 1) % sides, 1 + n) for n in range(sides)]
    for first in range(1, len(positions) - sides, sides):
        for n in range(sides):
            a, b = first + n, first + (n + 1) % sides
            triangles += [(a, b, a + sides), (b, b + sides, a + sides)]
    if lowest == -1:
        last = len(positions) - sides
        positions.append((0, -radius, 0))
        triangles += [(len(positions) - 1, last + n, last + (n + 1) % sides) for n in range(sides)]
    return positions, triangles


def join(*meshes):
    """One mesh of several, which share no vertex."""
    positions, triangles = [], []
    for p, t in meshes:
        triangles += [[i + len(positions) for i in corners] for corners in t]
        positions += p
    return positions, triangles


def node(name, mesh, at=(0, 0, 0), **rest):
    """rest: scale, rotation of the node; material, a dictionary; mesh_name."""
    return name, mesh, at, rest


def light(name, kind, at=(0, 6, 0), direction=(0, -1, 0), reach=None, **rest):
    """rest: of the light's node."""
    shape = {"name": name, "type": kind, **({"range": reach} if reach else {}), **({"spot": {"outerConeAngle": 0.6}} if kind == "spot" else {})}
    return shape, at, direction, rest


def write(path, nodes, lights=(), **rest):
    """rest: more members of the file."""
    data, views, accessors, meshes, materials, gltf_nodes = b"", [], [], [], [], []
    for name, (positions, triangles), at, more in nodes:
        more = dict(more)
        for part, form in ((positions, "f"), (triangles, "I")):
            packed = b"".join(struct.pack(f"<3{form}", *p) for p in part)
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
            data += packed
        stored = [struct.unpack("<3f", struct.pack("<3f", *p)) for p in positions]
        accessors += [{"bufferView": len(views) - 2, "componentType": 5126, "type": "VEC3", "count": len(positions),
                       "min": [min(c) for c in zip(*stored)], "max": [max(c) for c in zip(*stored)]},
                      {"bufferView": len(views) - 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(triangles)}]
        primitive = {"attributes": {"POSITION": len(accessors) - 2}, "indices": len(accessors) - 1}
        if material := more.pop("material", None):
            primitive["material"] = len(materials)
            materials.append(material)
        mesh = {"primitives": [primitive]}
        if mesh_name := more.pop("mesh_name", None):
            mesh["name"] = mesh_name
        gltf_nodes.append({**({"name": name} if name else {}), "mesh": len(meshes), "translation": list(at), **more})
        meshes.append(mesh)
    for n, (shape, at, direction, more) in enumerate(lights):
        placed = {} if direction is None else {"rotation": turned(direction)}
        gltf_nodes.append({"name": shape["name"], "translation": list(at), **placed,
                           "extensions": {"KHR_lights_punctual": {"light": n}}, **more})
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(gltf_nodes)))}], "nodes": gltf_nodes,
            "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
            "bufferViews": views, "accessors": accessors, "meshes": meshes}
    if materials:
        gltf["materials"] = materials
    if lights:
        gltf["extensionsUsed"] = ["KHR_lights_punctual"]
        gltf["extensions"] = {"KHR_lights_punctual": {"lights": [shape for shape, *_ in lights]}}
    path.write_text(json.dumps(gltf | rest))
    return path
