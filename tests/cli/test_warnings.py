# What is probably a mistake is said, with what to do about it, before long work; with --strict it is an error and nothing is
# written.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import re
import subprocess

import pytest

import punctual
import small_scene
from small_scene import BLOCK, GROUND, MORNING, NOON

SMALL = ("--resolution", 64)
UPWARD = (0.6, 0.8, 0)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("warnings") / "small.gltf")


@pytest.fixture
def said(vxs, tmp_path):
    """said(scene, *options): the warnings of a bake, which plan gives too, and --strict makes an error that leaves nothing."""

    def run(scene, *options):
        options = [*SMALL, *options] if "--texel" not in options else options
        out = tmp_path / "said.vxs"
        done = vxs("bake", scene, "-o", out, *options)
        lines = done.stderr.splitlines()
        assert all(line.startswith("vxs: warning: ") for line in lines)
        assert vxs("plan", scene, *options).stderr == done.stderr
        out.unlink()
        for command in ("bake", "plan") if lines else ():
            strict = vxs(command, scene, "-o", out, *options, "--strict", status=1)
            assert strict.stderr == lines[0].replace("warning", "error") + " (--strict: a warning is an error)\n"
            assert strict.stdout == "" and not out.exists()
        return [line.removeprefix("vxs: warning: ") for line in lines]

    return run


def with_lights(folder, *found):
    return punctual.copy_with(small_scene.write(folder / "dark.gltf", lights=()), folder, found)


# --- suns from below ----------------------------------------------------------------------------------------------------------


def test_sun_from_below(vxs, said, scene, tmp_path):
    upward = small_scene.write(tmp_path / "up.gltf", lights=(("moon", "directional", UPWARD), ("lamp", "spot", (0.6, -0.8, 0))))
    text = ("light '{}' travels upward, (0.6, 0.8, 0), as from a sun below the horizon: the direction is the way light travels; "
            "turn it round, or give --sun -0.6,-0.8,0")
    assert said(upward) == [text.format("moon")]
    assert said(scene, "--sun", "3,4,0") == [text.format("sun")]
    assert said(upward, "--light", "lamp") == [] == said(scene, "--sun=-3,-4,0")
    for options in (("truth", upward, "--light", "moon"), ("truth", scene, "--sun", "3,4,0")):
        assert "travels upward" in vxs(*options, input="0 9 0\n").stderr
        assert vxs(*options, "--strict", input="0 9 0\n", status=1).stdout == ""
    made = ("scene", "city", "--triangles", 1000, "--blocks", 1, "-o", tmp_path / "city.glb", "--sun", "0,1,0")
    assert vxs(*made).stderr.count("travels upward") == 1
    (tmp_path / "city.glb").unlink()
    assert vxs(*made, "--strict", status=1).stdout == "" and not (tmp_path / "city.glb").exists()


def test_sun_at_the_horizon_is_none_from_below(said, tmp_path):
    assert said(small_scene.write(tmp_path / "dusk.gltf", lights=(("dusk", "directional", (1, 1e-6, 0)),))) == []


# --- lights that are there twice ----------------------------------------------------------------------------------------------

POINT = punctual.point("a", (0, 6, 0), 9)
SPOT = punctual.spot("a", (0, 6, 0), NOON, 60, 9)


@pytest.mark.parametrize("first, second, kind", [
    (POINT, punctual.point("b", (0, 6.00001, 0), 9), "point"),
    (POINT, punctual.point("b", (0, 6.01, 0), 9), None),
    (POINT, punctual.point("b", (0, 6, 0), 8), None),
    (POINT, punctual.point("b", (0, 6, 0)), None),
    (punctual.point("a", (0, 6, 0)), punctual.point("b", (0, 6, 0)), "point"),
    (POINT, punctual.spot("b", (0, 6, 0), NOON, 60, 9), None),
    (SPOT, punctual.spot("b", (0, 6, 0), (1e-5, -1, 0), 60.001, 9), "spot"),
    (SPOT, punctual.spot("b", (0, 6, 0), NOON, 61, 9), None),
    (SPOT, punctual.spot("b", (0, 6, 0), (0.01, -1, 0), 60, 9), None),
    (({"name": "a", "type": "directional"}, (0, 0, 0), NOON, None), ({"name": "b", "type": "directional"}, (5, 6, 7), NOON, None),
     "directional"),
    (({"name": "a", "type": "directional"}, (0, 0, 0), NOON, None), ({"name": "b", "type": "directional"}, (0, 0, 0), MORNING, None),
     None),
])
def test_a_light_twice(said, tmp_path, first, second, kind):
    path = with_lights(tmp_path, first, second)
    expected = [f"lights 'a' and 'b' are one {kind} light, there twice: take one out of the scene, or choose with --light"] if kind else []
    assert said(path) == expected
    assert said(path, "--light", "b") == []


@pytest.mark.parametrize("options, pair, left_out", [
    (("--sun", "0,-2,0", "--sun", "noon=0,-1,0"), ("sun", "noon"), "noon"),
    (("--light", "sun", "--sun", "noon=0,-1,0"), ("sun", "noon"), "noon"),
    (("--light", "noon", "--light", "sun", "--sun", "noon=0,-1,0"), ("noon", "sun"), "noon"),
])
def test_a_light_twice_by_options(said, scene, options, pair, left_out):
    """What is on the command line is taken from there."""
    first, second = pair
    assert said(scene, *options) == [f"lights '{first}' and '{second}' are one directional light, there twice: "
                                     f"leave out '{left_out}', which --sun gives"]


def test_names_that_differ_in_case_only(said, tmp_path):
    lights = (("Sun", "directional", NOON), ("moon", "directional", MORNING), ("sun", "directional", (-1, -1, 0)))
    path = small_scene.write(tmp_path / "case.gltf", lights=lights)
    assert said(path) == ["lights 'Sun' and 'sun' differ in case only, and are easily taken for each other where they are looked up: "
                          "rename one"]
    assert said(path, "--light", "Sun", "--light", "moon") == []
    assert len(said(path, "--light", "Sun", "--sun", "0,-1,0.1")) == 1, "the light that --sun adds"


# --- region and scale ---------------------------------------------------------------------------------------------------------


def test_region_that_no_caster_touches(said, scene):
    assert said(scene, "--region", "-2,4,-2,2,5,2") == [
        "--region touches no caster: they lie from (-8, -1, -8) to (8, 3, 8) m; give a box that meets them, or none"]
    assert said(scene, "--region", "-2,0.5,-2,2,1,2") != [], "within the casters' box"
    assert said(scene, "--region", "-2,2.5,-2,2,9,2") == [] == said(scene, "--region", "-2,0,-2,2,1,2"), "from above, and as a floor"


def test_region_beside_a_slope(said, tmp_path):
    """In the box of a large triangle, and not on it."""
    path = small_scene.write(tmp_path / "slope.gltf", boxes=(((-1, -1, -1), (1, 1, 1)),))
    gltf = json.loads(path.read_text())
    gltf["nodes"][0]["rotation"] = [0, 0, 0.38268343, 0.92387953]  # a diamond, seen along z
    path.write_text(json.dumps(gltf))
    assert len(said(path, "--region", "0.9,0.9,-0.5,1.2,1.2,0.5")) == 1
    assert said(path, "--region", "0.6,0.6,-0.5,1.2,1.2,0.5") == []


def test_punctual_lights_do_not_look_at_the_region(said, tmp_path):
    path = small_scene.write(tmp_path / "lamp.gltf", lights=(("lamp", "spot", NOON),))
    assert said(path, "--region", "-2,4,-2,2,5,2") == []


def test_region_smaller_than_a_texel(said, scene):
    region = ("--region", "0,-0.1,0,0.2,0.1,0.2")
    assert said(scene, *region, "--texel", 0.5) == [
        "light 'sun': --region is 0.2 x 0.2 m seen from it, and a texel is 0.5 m: one voxel holds all; give a smaller --texel or a "
        "larger region"]
    assert said(scene, *region, "--texel", 0.1) == [] == said(scene, *region)


def scaled(source, path, scale):
    """A copy of a scene, all of it under nodes that scale."""
    gltf, rest = punctual.read(source)
    roots = gltf["scenes"][gltf.get("scene", 0)]["nodes"]
    gltf["scenes"][gltf.get("scene", 0)]["nodes"] = [len(gltf["nodes"])]
    gltf["nodes"].append({"children": roots, "scale": [scale] * 3})
    return punctual.write(path, gltf, rest)


@pytest.mark.parametrize("options", [("city",), ("landscape",), ("forest",), ("landscape", "--size", 100000, "--height", 9000),
                                     ("forest", "--size", 5000), ("city", "--blocks", 64), ("room",)], ids=str)
def test_scale_of_made_scenes(vxs, said, tmp_path, options):
    """As they are in metres; all but the room, which could be a hall, in centimetres too."""
    vxs("scene", *options, "-o", tmp_path / "metres.glb", "--triangles", 20000)
    coarse = ("--resolution", 8, "--sun", "-0.4,-1,-0.2")
    assert vxs("plan", tmp_path / "metres.glb", *coarse).stderr == ""
    large = vxs("plan", scaled(tmp_path / "metres.glb", tmp_path / "centimetres.glb", 100), *coarse).stderr
    assert (large == "") == (options[0] == "room")
    assert large == "" or re.search(r"the scene is \d+ x \d+ x \d+ m, as one in centimetres is: glTF is in metres; export it so, or scale its "
                                    r"root nodes by 0.01\n", large)


@pytest.mark.slow
def test_scale_of_real_scenes(vxs_path, scenes):
    real = scenes / "real"
    for path in sorted([*real.glob("*.glb"), *(real / "features").rglob("*.gl*"), *(real / "encodings").rglob("*.gl*")]):
        done = subprocess.run([vxs_path, "plan", path, "--resolution", "8", "--sun", "-0.4,-1,-0.2"], capture_output=True, text=True)
        assert done.returncode in (0, 5) and "metres" not in done.stderr, path


@pytest.mark.parametrize("scale, told", [(8000, False), (10000, True)])
def test_scene_that_is_too_wide(vxs, tmp_path, scale, told):
    """Of one part, and flat: 181 and 226 km across."""
    flat = small_scene.write(tmp_path / "flat.gltf", boxes=(((-8, 0, -8), (8, 0.5, 8)),))
    assert ("metres" in vxs("plan", scaled(flat, tmp_path / "wide.gltf", scale), *SMALL).stderr) == told


def test_small_scene(said, scene, tmp_path):
    text = said(scaled(scene, tmp_path / "tiny.gltf", 0.0004))
    assert text == ["the scene is 0.0064 x 0.0016 x 0.0064 m, too small for anything to be in it: glTF is in metres; export it so, or "
                    "scale its root nodes"]
    assert said(scaled(scene, tmp_path / "small.gltf", 0.001)) == []


# --- lights before triangles --------------------------------------------------------------------------------------------------


def far_away(folder, lights=()):
    """A scene whose triangles cannot be placed: they would lie at infinity."""
    path = small_scene.write(folder / "far.gltf", lights=lights)
    gltf = json.loads(path.read_text())
    gltf["nodes"][0]["scale"] = [1e308] * 3
    path.write_text(json.dumps(gltf))
    return path


@pytest.mark.parametrize("command", ["bake", "plan", "truth"])
@pytest.mark.parametrize("lights, options, status, says", [
    ((), (), 5, "the scene has no light: --sun X,Y,Z gives one"),
    ((), ("--light", "nobody"), 2, "the scene has no lights"),
    ((("sun", "directional", NOON),), ("--light", "nobody"), 2, "no such light; there are sun (directional, node 1)"),
    ((), ("--sun", "0,0,0"), 2, "expected a direction, not zero"),
    ((("sun", "directional", (0, 1, 0)),), ("--strict",), 1, "travels upward"),
])
def test_lights_are_looked_at_before_a_triangle_is_placed(vxs, tmp_path, command, lights, options, status, says):
    path = far_away(tmp_path, lights)
    words = (command, path, *(("-o", tmp_path / "a.vxs") if command == "bake" else ()))
    text = vxs(*words, *options, status=status, input="").stderr
    assert says in text and text.count("\n") == 1
    assert "is not finite once placed" in vxs(*words, "--sun", "0,-1,0", status=3, input="").stderr
    assert [p.name for p in tmp_path.iterdir()] == ["far.gltf"]


def test_warnings_of_a_scene_are_errors_before_a_triangle_is_placed(vxs, tmp_path):
    path = far_away(tmp_path, (("sun", "directional", NOON),))
    gltf = json.loads(path.read_text())
    gltf["meshes"][0]["primitives"].append({"attributes": {"POSITION": 0}, "mode": 0})
    path.write_text(json.dumps(gltf))
    assert "points skipped" in vxs("bake", path, "-o", tmp_path / "a.vxs", "--strict", status=1).stderr


def with_many_lights(folder, count):
    """At places of their own, all over the ground."""
    found = [punctual.point(f"lamp{n}", (n % 40 / 4 - 5, 5, n // 40 / 4 - 5), 30) for n in range(count)]
    return punctual.copy_with(far_away(folder), folder, found)


def test_more_lights_than_a_file_holds(vxs, tmp_path):
    path = with_many_lights(tmp_path, 1025)
    for command in ("bake", "plan"):
        text = vxs(command, path, "-o", tmp_path / "a.vxs", *SMALL, status=2).stderr
        assert text == ("vxs: error: 1025 lights to bake, and a file holds 1024 at most: choose some with --light NAME, in several "
                        "bakes\n")
    assert not (tmp_path / "a.vxs").exists()
    for words in (("plan", path, "--light", "lamp7", "--light", "lamp1024"), ("truth", path)):
        assert "is not finite once placed" in vxs(*words, status=3, input="").stderr, "those are not too many"


def test_as_many_lights_as_a_file_holds(vxs, tmp_path):
    assert "is not finite once placed" in vxs("plan", with_many_lights(tmp_path, 1024), status=3).stderr


def test_lights_that_are_left_out_are_errors_before_maps_are_sampled(vxs, tmp_path):
    """How much memory a bake needs is found in the samples."""
    path = small_scene.write(tmp_path / "up.gltf", lights=(("up", "spot", (0, 1, 0)), ("noon", "directional", NOON)))
    options = (path, "--resolution", 1024, "--maps", "gl")
    least   = json.loads(vxs("plan", *options, "--json", "-").stdout)["least_bytes"]
    options += ("--memory", least - 1)
    assert "too little" in vxs("plan", *options, status=6).stderr
    assert "light 'up' reaches no caster" in vxs("plan", *options, "--strict", status=1).stderr


# --- remedies -----------------------------------------------------------------------------------------------------------------


def test_warnings_of_scenes_have_remedies(said, scene, tmp_path):
    """Each says what to do, after a semicolon."""
    gltf = json.loads(scene.read_text())
    primitive = gltf["meshes"][0]["primitives"][0]
    vertices = gltf["accessors"][0]["count"]
    gltf["meshes"][0]["primitives"] += [primitive | {"mode": 0}, primitive | {"mode": 1}, {"attributes": {}, "mode": 4},
                                        {"attributes": primitive["attributes"]}]
    gltf["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    assert vertices % 3
    (tmp_path / "odd.gltf").write_text(json.dumps(gltf))
    found = said(tmp_path / "odd.gltf")
    assert len(found) == 5 and all(line.count("; ") == 1 for line in found)


def test_a_long_name_has_a_remedy(said, tmp_path):
    path = small_scene.write(tmp_path / "long.gltf", lights=(("x" * 80, "directional", NOON),))
    assert said(path) == [f"light '{'x' * 80}': the name is cut to its first 63 bytes, by which it will be looked up; rename it in the scene"]
