# vxs render --moving: what is not baked is drawn, and casts shadows, as if it had been baked with the rest.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

import jsonschema
import pytest

import small_scene
from conftest import ROOT
from png import read_png

BLOCK = [small_scene.BLOCK]
ABOUT = [((-3, 4, -3), (-2, 5, -2)), ((2, 5, 2), (3, 6, 3))]  # the lamps are among them
WIDE, HIGH = 96, 72
SMALL = "--width", WIDE, "--height", HIGH, "--samples", 1, "--filter", 1, "--eye", "7,9,6", "--target", "0,1,0", "--fov", 60


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    """A folder with the ground alone, what moves over it, and both in one, baked."""
    folder = tmp_path_factory.mktemp("moving")
    beyond = [tuple((x + 2, y, z) for x, y, z in corners) for corners in BLOCK]
    for name, boxes in (("ground", []), ("block", BLOCK), ("about", ABOUT), ("beyond", beyond)):
        small_scene.write(folder / f"{name}.gltf", boxes=[small_scene.GROUND, *boxes], lights=small_scene.EACH_KIND)
        vxs("bake", folder / f"{name}.gltf", "-o", folder / f"{name}.vxs", "--resolution", 512)
        if boxes:
            small_scene.write(folder / f"{name}_alone.gltf", boxes=boxes, lights=[])
    return folder


def red_of(path):
    return [c for row in read_png(path.read_bytes())[2] for c in row[::3]]


def light_of(vxs, level, name, light, *options):
    """Direct light of each pixel, 0 to 255."""
    vxs("render", level / f"{name}.gltf", level / f"{name}.vxs", "-o", level / "out.png", *SMALL, "--light", light, "--passes",
        level / "passes", "--json", level / "r.json", *options)
    return red_of(level / "passes" / "light.png")


def different(a, b):
    return sum(abs(x - y) > 40 for x, y in zip(a, b)) / len(a)


@pytest.mark.parametrize("light", ["noon", pytest.param("spot", marks=pytest.mark.long), "lamp"])
@pytest.mark.parametrize("what", [pytest.param("block", marks=pytest.mark.long), "about"])
def test_as_if_it_were_baked(vxs, level, what, light):
    baked = light_of(vxs, level, what, light)
    moving = light_of(vxs, level, "ground", light, "--moving", level / f"{what}_alone.gltf")
    found = json.loads((level / "r.json").read_text())
    jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
    maps = 6 if what == "about" and light != "noon" else 1
    assert found["frames"][0]["moving"] == {"lights": 1, "maps": maps, "left_out": 0}
    wrong, without = different(moving, baked), different(light_of(vxs, level, "ground", light), baked)
    assert wrong < 0.003 < 0.009 < without


@pytest.mark.parametrize("light", [pytest.param("noon", marks=pytest.mark.long), "lamp"])
def test_fog_as_if_it_were_baked(vxs, level, light):
    """By steps of a map for the light that sees it, where the baked scene has exact intervals."""
    def airlight(name, *options):
        light_of(vxs, level, name, light, "--fog", 0.1, *options)
        return red_of(level / "passes" / "airlight.png")

    def apart(a, b):
        return sum(abs(x - y) for x, y in zip(a, b)) / sum(b)

    baked = airlight("block")
    moving = airlight("ground", "--moving", level / "block_alone.gltf", "--fog-steps", 256)
    plan, = json.loads((level / "r.json").read_text())["fog"]["lights"]
    assert (plan["by"], plan["why"]) == ("angles", "something moves in its light")
    wrong, without = apart(moving, baked), apart(airlight("ground"), baked)
    assert wrong < 0.1 * without and without > 0.002


def test_it_moves(vxs, level):
    (level / "path.txt").write_text("7 9 6 0 1 0\n7 9 6 0 1 0\n")
    options = [*SMALL[:SMALL.index("--eye")], "--fov", 60, "--path", level / "path.txt", "--frames", 2]
    pictures = []
    for name, more in (("beyond", ()), ("ground", ("--moving", level / "block_alone.gltf", "--moving-by", "2,0,0")),
                       ("ground", ("--moving", level / "block_alone.gltf"))):
        vxs("render", level / f"{name}.gltf", level / f"{name}.vxs", "-o", level / "out.png", *options, "--light", "noon", *more)
        pictures.append(red_of(level / "out.png"))
    assert different(pictures[0], pictures[1]) < 0.005 < 0.03 < different(pictures[0], pictures[2])


def test_misuse(vxs, level, tmp_path):
    small_scene.write(tmp_path / "nothing.gltf", boxes=[])
    scene = level / "ground.gltf", level / "ground.vxs", "-o", tmp_path / "out.png"
    for options, status, words in ((("--moving", tmp_path / "nothing.gltf"), 3, "nothing.gltf has no triangles: nothing moves"),
                                   (("--moving", level / "block_alone.gltf", "--moving-by", "1,0,0"), 2, "--path or --orbit"),
                                   (("--moving-by", "1,0,0", "--orbit"), 2, "--moving-by needs --moving"),
                                   (("--moving", level / "block_alone.gltf", "--draw", "rays"), 2, "goes without --moving")):
        assert words in vxs("render", *scene, *options, status=status).stderr
        assert not (tmp_path / "out.png").exists()
