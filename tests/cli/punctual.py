# Scenes with more lights than they came with: a copy of a .glb or .gltf file, its geometry as it was.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import shutil
import struct

from small_scene import turned

JSON_CHUNK = 0x4e4f534a


def spot(name, position, direction, degrees, reach=None):
    """degrees: the whole cone, from edge to edge."""
    light = {"name": name, "type": "spot", "spot": {"outerConeAngle": math.radians(degrees) / 2}}
    return light, position, direction, reach


def point(name, position, reach=None):
    return {"name": name, "type": "point"}, position, (0, -1, 0), reach


def read(path):
    """The JSON of a file, and what follows it."""
    data = path.read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data), b""
    size, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + size]), data[20 + size:]


def write(path, gltf, rest):
    text = json.dumps(gltf).encode()
    if path.suffix == ".gltf":
        path.write_bytes(text)
        return path
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), JSON_CHUNK) + text + rest)
    return path


def copy_with(source, folder, lamps):
    """A copy of a scene in a folder, with these lamps at the roots of its default scene in place of its own lights."""
    gltf, rest = read(source)
    for node in gltf.get("nodes", []):
        node.get("extensions", {}).pop("KHR_lights_punctual", None)
    for used in gltf.get("buffers", []) + gltf.get("images", []):
        uri = used.get("uri", "data:").replace("%20", " ")
        if not uri.startswith("data:"):
            shutil.copy(source.parent / uri, folder / uri)
    nodes = gltf.setdefault("nodes", [])
    scenes = gltf.setdefault("scenes", [{"nodes": [n for n in range(len(nodes)) if not any(n in other.get("children", [])
                                                                                          for other in nodes)]}])
    roots = scenes[gltf.get("scene", 0)].setdefault("nodes", [])
    for n, (light, position, direction, reach) in enumerate(lamps):
        if reach:
            light["range"] = reach
        roots.append(len(nodes))
        nodes.append({"translation": list(position), "rotation": turned(direction),
                      "extensions": {"KHR_lights_punctual": {"light": n}}})
    used = gltf.setdefault("extensionsUsed", [])
    if "KHR_lights_punctual" not in used:
        used.append("KHR_lights_punctual")
    gltf.setdefault("extensions", {})["KHR_lights_punctual"] = {"lights": [lamp[0] for lamp in lamps]}
    return write(folder / source.name, gltf, rest)
