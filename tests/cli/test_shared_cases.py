# Inputs on which vxs was wrong, as they lie in the folder of shared cases: forged files, outputs over inputs, light that was wrong.
# Those of files that people have are in test_files.py, test_useless_bakes.py, test_plan.py and test_mend.py; small inputs of the
# same kinds, which need no folder, in others.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import os
import re
import subprocess

import pytest

import skies
from exr import read_exr


def run_script(path, vxs_path):
    """A script's lines; it makes a folder of its own."""
    return subprocess.run(["bash", path], env={**os.environ, "VXS": str(vxs_path)}, capture_output=True, text=True, timeout=600).stdout.splitlines()


@pytest.mark.parametrize("name", ["sun_crash", "sun_crash_small", "answers_differ"])
def test_an_entry_with_min_above_max(vxs, cases, name):
    folder = cases / "hostile" / "01-min-above-max-crash"
    assert "finding 501" in vxs("validate", folder / f"{name}.vxs", status=1).stdout
    assert "finding 501" in vxs("compare", folder / "scene.glb", folder / f"{name}.vxs", "--points", 10, "--other-scene", status=3).stderr


def test_passes_over_inputs(vxs_path, cases):
    lines = run_script(cases / "hostile" / "02-passes-over-inputs" / "run.sh", vxs_path)[4:]
    assert len(lines) == 7 and all(re.match("rc 2 .*: kept$", line) for line in lines[:4]) and all(" rc 2" in line for line in lines[4:])


def test_outputs_over_inputs(vxs_path, cases):
    lines = run_script(cases / "hostile" / "09-small" / "run.sh", vxs_path)
    assert [line for line in lines if line.startswith("rc ")] == ["rc 2"] * 4
    assert "0" * 32 + ".square" in lines and lines[-1].endswith("rc 0") and not [line for line in lines if "rc 3" in line]


def test_control_characters(vxs, cases):
    folder = cases / "hostile" / "04-compare-control-characters"
    text = vxs("compare", folder / "x.gltf", folder / "x.vxs", "--points", 10, "--verbose").stdout
    assert all(c.isprintable() or c == "\n" for c in text) and "\nvxs: error: " not in text


def test_a_square_of_3_gb(vxs_path, cases):
    lines = run_script(cases / "hostile" / "06-resume-big-square" / "run.sh", vxs_path)
    assert [line[:13] for line in lines] == ["exit status 0", "with ulimit -"] and lines[1].endswith("exit status 0")


def test_a_floor_below_a_fixture(vxs, cases, tmp_path):
    """It had 5 to 13 % of its points dark."""
    scene, asset = cases / "light" / "lamp_fixture.glb", tmp_path / "a.vxs"
    vxs("bake", scene, "-o", asset, "--resolution", 4096)
    vxs("compare", scene, asset, "--points", 20000, "--filter", 1, "--filter", 9, "--json", tmp_path / "r.json")
    asset, = json.loads((tmp_path / "r.json").read_text())["assets"]
    light, = asset["lights"]
    for surface in (light["surface"], light["filters"][0]["surface"]):
        assert surface["points"] == 20000 and surface["self_shadows"] == surface["deep_leaks"] == 0
    assert light["surface"]["wrong"] == 0 == light["filters"][0]["surface"]["rmse"] and not light["faults"]


def share_of_sky(x, z, rows=40):
    """How much of a sky's irradiance on open ground comes to a place in the corner of two walls: 40 m high, from -20 to 20 m."""
    seen = 0
    for row in range(rows):
        sine = math.sqrt((row + 0.5) / rows)
        for column in range(4 * rows):
            around = math.pi / 2 * (column + 0.5) / rows
            dx, dy, dz = sine * math.cos(around), math.sqrt(1 - sine * sine), sine * math.sin(around)
            seen += ((dx >= 0 or dy / -dx * x > 40 or abs(z - dz / dx * x) > 20) and (dz >= 0 or dy / -dz * z > 40 or abs(x - dx / dz * z) > 20))
    return seen / (4 * rows * rows)


def test_a_corner_below_a_sky(vxs, cases, tmp_path):
    """A radiance of 1 everywhere: from the 65th lamp it was 17 to 29 % too bright. The sun, of 1 lux, shows what exposure does."""
    scene, asset, side = cases / "light" / "s_corner.gltf", tmp_path / "a.vxs", 16
    vxs("bake", scene, "-o", asset, "--sun", "0,-1,0", "--resolution", 256)
    skies.Sky(8, lambda way: (1, 1, 1)).write(tmp_path / "sky.hdr")
    places = [1.25 + 3.5 * (n + 0.5) / side for n in range(side)]  # from an eye above (3, 3)
    for lamps in (64, 65):
        vxs("render", scene, asset, "-o", tmp_path / "o.png", "--linear", tmp_path / "o.exr", "--passes", tmp_path, "--width", side, "--height", side, "--samples", 1,
            "--sky", tmp_path / "sky.hdr", "--area", lamps, "--area-gather", "each", "--eye", "3,6,3.0001", "--target", "3,0,3", "--fov", math.degrees(2 * math.atan(1.75 / 6)))
        sky, light = (read_exr((tmp_path / name).read_bytes())[2]["G"] for name in ("sky.exr", "light.exr"))
        found = [sky[y][x] / (light[y][x] - sky[y][x]) / math.pi / share_of_sky(places[x], places[y]) for y in range(0, side, 3) for x in range(0, side, 3)]
        assert abs(sum(found) / len(found) - 1) < 0.05 and max(abs(f - 1) for f in found) < 0.2, (lamps, found)
