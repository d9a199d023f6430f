# Levels that the example loads, in their baked light: what the shadows take from a picture of Godot is what `vxs render` says.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

import pytest

from conftest import ROOT
from png import read_png

WIDE, HIGH = 320, 240
LEVELS = {
    "city": {"eye": [-150, 90, -160], "target": [0, 0, 0], "fov": 50, "width": 9, "smooth": False, "energy": {"sun": 1},
             "resolution": 4096, "mover": [-93, 45, -105], "size": 25},
    "room": {"eye": [3, 1.8, 2.2], "target": [-1, 0.8, -0.5], "fov": 70, "width": 9, "smooth": False, "energy": {"lamp": 4, "corner": 60},
             "resolution": 1024, "at": [7, -2, 3], "turn": 0.7},
    "kaykit_city": {"eye": [-9, 7, 11], "target": [1, 0, 0], "fov": 45, "width": 8, "smooth": True, "energy": {"sun": 1},
                    "resolution": 4096, "sun": [-0.4, -1, -0.3]},
}
LINEAR = [(s / 255 / 12.92 if s <= 10 else ((s / 255 + 0.055) / 1.055) ** 2.4) for s in range(256)]
DARK = 90  # grey where a step of 8 bits is at most 2.5 % of the light


@pytest.fixture(scope="module", params=LEVELS)
def level(request, godot, vxs, tmp_path_factory):
    """Name, what Godot drew, and the passes of `vxs render`: {light: grey or None by pixel}."""
    name, case = request.param, LEVELS[request.param]
    here = tmp_path_factory.mktemp(name)
    scene, baked = here / f"{name}.glb", here / "level.vxs"
    if name == "kaykit_city":
        scene.write_bytes((request.getfixturevalue("scenes") / "real" / scene.name).read_bytes())
    else:
        vxs("scene", name, "-o", scene, "--quiet")
    suns = [f"--sun={','.join(map(str, case['sun']))}"] if "sun" in case else []
    vxs("bake", scene, "-o", baked, "--resolution", case["resolution"], "--pack", "fast", "--quiet", *suns)
    view = [f"--{of}={','.join(map(str, case[of]))}" for of in ("eye", "target")]
    vxs("render", scene, baked, "-o", here / "out.png", "--width", WIDE, "--height", HIGH, "--samples", 1, "--fov", case["fov"], *view,
        "--passes", here / "passes", "--smooth" if case["smooth"] else "--filter", case["width"])
    passes = {}
    for path in sorted((here / "passes").glob("lit-*.png")):
        rows = b"".join(read_png(path.read_bytes())[2])
        passes[path.stem.split("-", 2)[2]] = [rows[n] / 255 if rows[n] == rows[n + 1] else None for n in range(0, len(rows), 3)]
    result = godot({"level.glb": scene.read_bytes(), "level.vxs": baked.read_bytes(), "case.json": json.dumps(case),
                    "example.gd": (ROOT / "runtime/godot/example/main.gd").read_text(),
                    "main.gd": (ROOT / "tests/godot/pictures.gd").read_text()})
    assert result.faults == []
    return name, result.values, passes


def green(picture):
    return picture[1::3]


def test_shadows_are_those_of_vxs_render(level):
    name, pictures, passes = level
    assert pictures["lights"] == "|".join(f"{light}={light}" for light in passes)
    for light, wanted in passes.items():
        bare, baked = green(pictures[f"{light}.bare"]), green(pictures[f"{light}.baked"])
        apart = [abs(LINEAR[b] / LINEAR[a] - lit) for a, b, lit in zip(bare, baked, wanted) if DARK <= a < 255 and lit is not None]
        mean, beyond = sum(apart) / len(apart), sum(x > 0.1 for x in apart) / len(apart)
        assert len(apart) > 8000 and mean < 0.004 and beyond < 0.01, (name, light, len(apart), mean, beyond)
        assert 0.1 < sum(lit for lit in wanted if lit is not None) / len(wanted) < 0.95


def test_converted_materials_look_as_before(level):
    """Where a light is not shadowed, the picture is that of StandardMaterial3D: to a step of 8 bits or two."""
    name, pictures, passes = level
    for light, wanted in passes.items():
        bare, baked = pictures[f"{light}.bare"], pictures[f"{light}.baked"]
        apart = [abs(bare[3 * n + c] - baked[3 * n + c]) for n, lit in enumerate(wanted) if lit == 1 for c in range(3)]
        assert len(apart) > 5000 and sum(x > 2 for x in apart) < len(apart) / 50, (name, light, max(apart))


@pytest.mark.parametrize("level", ["city"], indirect=True)
def test_live_shadows_multiply(level):
    _, pictures, _ = level
    before, after = green(pictures["sun.baked"]), green(pictures["mover"])
    darker, brighter = sum(b < a - 40 for a, b in zip(before, after)), sum(b > a + 3 for a, b in zip(before, after))
    assert darker > 200 and brighter < 100
