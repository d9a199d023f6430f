# A scene of spheres in the air, with a lamp among them, inside of a ball that ends all rays: of what is lit there formulas tell
# (tests/volumes/sphere_parts.h); and one of a wall. Written as glTF text.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import math
import struct

# centre and radius, metres; the lamp is at the origin
SPHERES = [((2.1, 0.4, 0.3), 0.5), ((-1.6, 0.9, 0.8), 0.35), ((0.5, -1.3, 1.2), 0.45), ((0.3, 1.2, -0.9), 0.3), ((-0.8, -0.5, -1.9), 0.6),
           ((1.4, -0.9, -1.5), 0.4), ((-2.4, -1.1, -0.2), 0.7), ((0.2, 0.5, 2.3), 0.4)]
BALL = 6  # radius
RINGS, SEGMENTS = 96, 192  # of quads: no place is further than 3e-4 of the radius from the sphere


def unit_sphere():
    """Corners, and triangles that are seen from outside. The six ends of its axes are corners."""
    angles = [(math.pi * ring / RINGS, 2 * math.pi * segment / SEGMENTS) for ring in range(RINGS + 1) for segment in range(SEGMENTS)]
    corners = [(math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b)) for a, b in angles]
    at = lambda ring, segment: ring * SEGMENTS + segment % SEGMENTS
    quads = [(at(r, s), at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)) for r in range(RINGS) for s in range(SEGMENTS)]
    return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def cube():
    """Of half a metre to all sides."""
    corners = [(x - 0.5, y - 0.5, z - 0.5) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def save(path, shape, places, has_lamp):
    """places: of copies of a shape, and how large they are. A lamp is at the origin."""
    corners, triangles = shape
    positions, indices = b"".join(struct.pack("<3f", *c) for c in corners), b"".join(struct.pack("<3I", *t) for t in triangles)
    nodes = [{"mesh": 0, "translation": centre, "scale": scale} for centre, scale in places]
    lamp = {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}}
    extent = [max(abs(c[n]) for c in corners) for n in range(3)]
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes) + has_lamp))}], "nodes": nodes + [lamp] * has_lamp,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(positions + indices),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(positions + indices).decode()}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(positions)},
                        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(corners), "min": [-e for e in extent], "max": extent},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(triangles)}],
        **({"extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"name": "lamp", "type": "point"}]}}} if has_lamp else {})}))


def write(path, ball):
    """ball: with the ball and the lamp; else the spheres alone, for a sun."""
    save(path, unit_sphere(), [(centre, [radius] * 3) for centre, radius in SPHERES + [((0, 0, 0), BALL)] * ball], ball)


def write_wall(path):
    """A wall of 4 x 3 metres, in nothing but air."""
    save(path, cube(), [((0, 1.5, 0), [4, 3, 0.1])], False)
