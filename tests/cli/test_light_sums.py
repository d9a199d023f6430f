# Many lights at one place are one light of the same sum: on surfaces, whose shaders go through all of them, and in fog, which
# leaves out what is faint.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import struct
import subprocess
import sys

import pytest

from exr import read_exr

SMALL = "--width", 48, "--height", 36, "--samples", 1
FLOOR = [(-6, 0, -6), (6, 0, -6), (-6, 0, 6), (6, 0, 6)], [0, 2, 1, 1, 2, 3]
PLATE = [(-1, 1.5, -1), (1, 1.5, -1), (-1, 1.5, 1), (1, 1.5, 1)], [0, 2, 1, 1, 2, 3]


def write(path, count, intensity, range_metres=None):
    """A floor below a plate, both seen from both sides, and over them, micrometres apart, `count` point lights that add up to an intensity, beside one sun."""
    places = [p for part in (FLOOR, PLATE) for p in part[0]]
    corners = [n + 4 * k for k, part in enumerate((FLOOR, PLATE)) for n in part[1]]
    data = b"".join(struct.pack("<3f", *p) for p in places) + struct.pack(f"<{len(corners)}I", *corners)
    lamp = {"type": "point", "intensity": intensity / count} | ({"range": range_metres} if range_metres else {})
    lights = [{"name": f"lamp {n}", **lamp} for n in range(count)] + [{"name": "sun", "type": "directional", "intensity": 1}]
    nodes = [{"mesh": 0}] + [{"translation": [0.3, 3, 0.2 + 1e-6 * n], "rotation": [-0.5 ** 0.5, 0, 0, 0.5 ** 0.5],
                              "extensions": {"KHR_lights_punctual": {"light": n}}} for n in range(count + 1)]
    at = 12 * len(places)
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "materials": [{"doubleSided": True}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": at}, {"buffer": 0, "byteOffset": at, "byteLength": len(data) - at}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(places),
                       "min": [min(c) for c in zip(*places)], "max": [max(c) for c in zip(*places)]},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(corners)}]}))
    return path


@pytest.fixture(scope="module")
def drawn(vxs, tmp_path_factory):
    """drawn(count, intensity, *options): the linear picture of so many lights, what was said, and the folder."""
    folder = tmp_path_factory.mktemp("sums")

    def draw(count, intensity, *options):
        scene, asset = folder / f"{count}.gltf", folder / f"{count}.vxs"
        write(scene, count, intensity)
        if not asset.exists():
            vxs("bake", scene, "-o", asset, "--resolution", 64)
        said = vxs("render", scene, asset, "-o", folder / "out.png", "--linear", folder / "out.exr", "--force", *SMALL, *options).stdout
        return read_exr((folder / "out.exr").read_bytes()), said, folder

    return draw


def radiance(picture):
    """In cd/m2, whatever the exposure."""
    _, _, channels, header = picture
    white, = struct.unpack("<f", header["whiteLuminance"][1])
    return [white * value for row in channels["G"] for value in row]


@pytest.mark.parametrize("count", [350, *(pytest.param(n, marks=pytest.mark.long) for n in (200, 500, 1000))])
def test_lights_on_a_surface(drawn, count):
    """llvmpipe ends all loops of an invocation after 65535 rounds: of so many lights a shader has to be queried in pieces."""
    camera = "--eye", "0.1,7,6", "--target", "0,0,0", "--fov", 30, "--filter", 17
    one, many = (radiance(drawn(n, 9, *camera)[0]) for n in (1, count))
    assert max(one) > 3 * min(one)  # there is light, and shadow
    for a, b in zip(one, many):
        assert b == pytest.approx(a, rel=1e-3, abs=1e-3 * max(one))


def test_faint_lights_together(drawn):
    """Each of so many lights has less airlight than half a step of a screen; all together have more, and what is left out of their sum is less."""
    camera = "--eye", "0,2.5,9", "--target", "0,2.5,0", "--fov", 30, "--fog", 3e-5
    one, many = (drawn(n, 9, *camera) for n in (1, 350))
    assert "351 lights" in many[1]
    white, = struct.unpack("<f", many[0][3]["whiteLuminance"][1])
    difference = [abs(b - a) / white for a, b in zip(radiance(one[0]), radiance(many[0]))]
    assert max(difference) < 1 / 6600, many[1]
    clear = radiance(drawn(1, 9, *camera[:-1], 0)[0])
    assert max(a - b for a, b in zip(radiance(one[0]), clear)) / white > 5 / 6600  # what there is to lose


def drawn_case(vxs, folder, name, *options):
    """Light on surfaces, or airlight where there is fog, of a case's scene, in cd/m2."""
    scene, asset, part = folder / f"{name}.gltf", folder / f"{name}.vxs", "airlight" if "--fog" in options else "light"
    if not asset.exists():
        vxs("bake", scene, "-o", asset, "--resolution", 64)
    vxs("render", scene, asset, "-o", folder / "a.png", "--linear", folder / "a.exr", "--force", *SMALL, *options, "--passes", folder / "passes")
    picture = read_exr((folder / "a.exr").read_bytes())
    return radiance((*picture[:2], read_exr((folder / "passes" / f"{part}.exr").read_bytes())[2], picture[3])), struct.unpack("<f", picture[3]["whiteLuminance"][1])[0]


@pytest.mark.long
def test_case_of_many_lights(vxs, cases, tmp_path):
    """1 lamp, and 1000 within 30 cm of it, of the same sum (light/many.py)."""
    subprocess.run([sys.executable, cases / "light" / "many.py"], cwd=tmp_path, check=True)
    camera = "--eye", "0,6,9", "--target", "0,0,0", "--fov", 40
    one, many = (drawn_case(vxs, tmp_path, f"many{count}", *camera)[0] for count in (1, 1000))
    assert sum(many) == pytest.approx(sum(one), rel=1e-3)
    assert many == pytest.approx(one, rel=0.03, abs=0.03 * max(one))


@pytest.mark.long
def test_case_of_faint_lights(vxs, cases, tmp_path):
    """1 lamp and 1000 of the same sum, far behind the eye: none of which alone can be seen in the fog (light/faint.py)."""
    camera = "--eye", "0,2,14", "--target", "0,1,40", "--fov", 60, "--fog", 3e-3, "--fog-albedo", 1, "--fog-anisotropy", 0
    lamps = []
    for count in 1, 1000:
        subprocess.run([sys.executable, cases / "light" / "faint.py", str(count), "9"], cwd=tmp_path, check=True)
        both, white = drawn_case(vxs, tmp_path, f"faint{count}", *camera)
        sun, _ = drawn_case(vxs, tmp_path, f"faint{count}", *camera, "--light", "sun")
        lamps.append([a - b for a, b in zip(both, sun)])
    assert max(lamps[0]) > 1 / 6600 * white
    assert sum(lamps[1]) == pytest.approx(sum(lamps[0]), rel=0.03)
