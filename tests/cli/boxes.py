# Thousands of boxes in one mesh, as binary glTF: piles that are deep for every ray.
# SPDX-License-Identifier: GPL-3.0-or-later
import array
import json
import struct

from small_scene import box


def coinciding(count):
    return [((-1, -1, -1), (1, 1, 1))] * count


def nested(count):
    """One in the other, the smallest first."""
    return [((-h,) * 3, (h,) * 3) for h in (n / count for n in range(1, count + 1))]


def write(path, corners):
    positions, indices = array.array("f"), array.array("I")
    for low_high in corners:
        p, t = box(*low_high)
        indices.extend(i + len(positions) // 3 for triangle in t for i in triangle)
        positions.extend(c for position in p for c in position)
    data = positions.tobytes() + indices.tobytes()
    at = 4 * len(positions)
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": at}, {"buffer": 0, "byteOffset": at, "byteLength": len(data) - at}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions) // 3,
                       "min": [min(positions[k::3]) for k in range(3)], "max": [max(positions[k::3]) for k in range(3)]},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices)}],
    }
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text +
                     struct.pack("<I4s", len(data), b"BIN\0") + data)
    return path
