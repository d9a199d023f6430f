# Scenes of a few boxes, written as glTF text, for tests that say where it is lit.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import math
import struct

# the corners of a box are bits: x, y, z
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3)]

GROUND = ((-8, -1, -8), (8, 0, 8))
BLOCK = ((-1, 2, -1), (1, 3, 1))  # floats over the middle of the ground
NOON = (0, -1, 0)
MORNING = (1, -1, 0)  # the shadow of the block lies towards +x
EACH_KIND = [("noon", "directional", (0.2, -1, 0.1)), ("spot", "spot", NOON), ("lamp", "point", NOON)]  # lights


def box(corner_min, corner_max):
    """Positions and triangles of a closed box, counter-clockwise seen from outside."""
    positions = [[(corner_max if c >> axis & 1 else corner_min)[axis] for axis in range(3)] for c in range(8)]
    return positions, [t for a, b, c, d in FACES for t in ((a, b, c), (a, c, d))]


def turned(direction):
    """The quaternion that turns -Z, the way a light of glTF shines, to a direction."""
    length = math.sqrt(sum(c * c for c in direction))
    x, y, z = (c / length for c in direction)
    w = 1 - z
    if w < 1e-9:
        return [0, 1, 0, 0]
    norm = math.sqrt(y * y + x * x + w * w)
    return [y / norm, -x / norm, 0, w / norm]


def write(path, boxes=(GROUND, BLOCK), lights=(("sun", "directional", NOON),), open_faces=False, **material):
    """Write a .gltf with its buffer inside. lights: (name, type, direction). open_faces: leave out the last face of each box."""
    positions, triangles = [], []
    for corners in boxes:
        p, t = box(*corners)
        triangles += [[i + len(positions) for i in corner] for corner in (t[:-2] if open_faces else t)]
        positions += p
    data = b"".join(struct.pack("<3f", *p) for p in positions) + b"".join(struct.pack("<3I", *t) for t in triangles)
    gltf = {"asset": {"version": "2.0"}, "scene": 0}
    nodes = []
    if boxes:
        nodes.append({"mesh": 0})
        at = 12 * len(positions)
        gltf |= {
            "buffers": [{"byteLength": len(data),
                         "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": at},
                            {"buffer": 0, "byteOffset": at, "byteLength": len(data) - at}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions),
                           "min": [min(c) for c in zip(*positions)], "max": [max(c) for c in zip(*positions)]},
                          {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(triangles)}],
            "materials": [material],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        }
    for n, (name, kind, direction) in enumerate(lights):
        nodes.append({"name": name, "rotation": turned(direction), "translation": [0, 6, 0],
                      "extensions": {"KHR_lights_punctual": {"light": n}}})
    if lights:
        gltf["extensionsUsed"] = ["KHR_lights_punctual"]
        gltf["extensions"] = {"KHR_lights_punctual": {"lights": [
            {"name": name, "type": kind, **({"spot": {}} if kind == "spot" else {})} for name, kind, _ in lights]}}
    gltf |= {"nodes": nodes, "scenes": [{"name": "small", "nodes": list(range(len(nodes)))}]}
    path.write_text(json.dumps(gltf))
    return path


def with_a_turned_triangle(path):
    """A copy of a small scene whose first triangle looks inward: its box is no solid until it is mended."""
    gltf = json.loads(path.read_text())
    head, _, text = gltf["buffers"][0]["uri"].partition(",")
    data, at = bytearray(base64.b64decode(text)), gltf["bufferViews"][1]["byteOffset"]
    data[at:at + 8] = data[at + 4:at + 8] + data[at:at + 4]
    gltf["buffers"][0]["uri"] = head + "," + base64.b64encode(data).decode()
    turned = path.with_stem("turned")
    turned.write_text(json.dumps(gltf))
    return turned
