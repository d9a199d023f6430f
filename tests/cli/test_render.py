# vxs render with OpenGL: paths and their reports, passes, culling that changes nothing but time, streams within a budget. Pictures
# are in test_compare.py.
# SPDX-License-Identifier: GPL-3.0-or-later
import csv
import json
import math
import re
import xml.etree.ElementTree

import jsonschema
import pytest

import small_scene
from conftest import ROOT
from png import read_png

SMALL = "--width", 64, "--height", 48, "--samples", 1


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    """A folder with level.gltf, all.vxs of its sun, its spot light and its lamp, and sun.vxs."""
    folder = tmp_path_factory.mktemp("render")
    small_scene.write(folder / "level.gltf", lights=small_scene.EACH_KIND)
    for name, lights in (("all", ()), ("sun", ("--light", "noon"))):
        vxs("bake", folder / "level.gltf", "-o", folder / f"{name}.vxs", "--resolution", 256, *lights)
    return folder


@pytest.fixture(scope="module")
def render(vxs, level):
    def run(asset, *options, **more):
        return vxs("render", level / "level.gltf", level / f"{asset}.vxs", "-o", level / "out.png", *SMALL, *options, **more)

    return run


def report(level, render, asset, *options):
    render(asset, "--json", level / "r.json", *options)
    found = json.loads((level / "r.json").read_text())
    jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
    return found


def test_path(level, render):
    """Keys are met, the last frame is the picture, and JSON, table and plot agree."""
    keys = [(0, 20, 0.5, 0, 0, 0), (10, 12, 5, 1, 0, 0), (15, 3, 0, 0, 1, 0)]
    (level / "path.txt").write_text("# eye and target\n\n" + "".join(" ".join(map(str, key)) + "\r\n" for key in keys))
    found = report(level, render, "all", "--path", level / "path.txt", "--frames", 5, "--csv", level / "r.csv", "--plot", level / "r.svg")
    assert [[*f["eye"], *f["target"]] for f in found["frames"]][::2] == [list(key) for key in keys]
    last = (level / "out.png").read_bytes()
    render("all", "--eye", "15,3,0", "--target", "0,1,0")
    assert read_png(last)[:2] == (64, 48)
    rows = list(csv.DictReader((level / "r.csv").read_text().splitlines()))
    assert len(rows) == len(found["frames"]) == 5
    for row, frame in zip(rows, found["frames"]):
        assert [float(row[name]) for name in ("eye_x", "target_y", "lights_per_sample")] == pytest.approx(
            [frame["eye"][0], frame["target"][1], frame["lights_per_sample"]], rel=1e-3)
        assert float(row["total_ms"]) == pytest.approx(sum(frame["ms"].values()), rel=1e-2)
        assert 0 < frame["surface_samples"] <= 64 * 48
    plot = xml.etree.ElementTree.fromstring((level / "r.svg").read_text())
    assert [len(p.get("points").split()) for p in plot.iter("{http://www.w3.org/2000/svg}polygon")] == [10] * 4


def test_path_is_smooth(level, render):
    """Equal steps along a line are equal steps between them; about a corner it swings out."""
    (level / "line.txt").write_text("".join(f"{x} 9 3 {x} 0 0\n" for x in range(5)) + "4 9 4 4 0 0\n")
    eyes = [f["eye"] for f in report(level, render, "sun", "--path", level / "line.txt", "--frames", 11)["frames"]]
    assert eyes[3:6] == [pytest.approx([x, 9, 3]) for x in (1.5, 2, 2.5)]
    assert eyes[9][0] > 4 and 3 < eyes[9][2] < 4 and all(eye[1] == pytest.approx(9) for eye in eyes)


def test_an_orbit_has_60_frames(level, render):
    assert len(report(level, render, "sun", "--orbit")["frames"]) == 60


def test_orbit(level, render):
    found = report(level, render, "all", "--orbit", "--frames", 8, "--eye", "12,9,0", "--target", "0,1,0")
    for frame in found["frames"]:
        assert frame["eye"][1] == 9 and frame["target"] == [0, 1, 0]
        assert (frame["eye"][0] ** 2 + frame["eye"][2] ** 2) ** 0.5 == pytest.approx(12, rel=1e-3)
    assert found["frames"][4]["eye"] == pytest.approx([-12, 9, 0], abs=1e-9)


def test_culling_changes_nothing_but_lists(level, render):
    camera = "--eye", "6,9,2", "--target", "0,0,0", "--fov", 60
    on, off = (report(level, render, "all", "--cull", mode, *camera) for mode in ("on", "off"))
    render("all", *camera)
    culled = (level / "out.png").read_bytes()
    render("all", "--cull", "off", *camera)
    assert culled == (level / "out.png").read_bytes()
    assert on["culling"] and not off["culling"] and off["frames"][0]["lights_per_sample"] == 3
    assert 1 <= on["frames"][0]["lights_per_sample"] < 3 == on["frames"][0]["longest_list"]


def test_one_sun_has_no_lists(level, render):
    found = report(level, render, "sun")
    assert not found["culling"] and found["lights"] == 1 and found["frames"][0]["longest_list"] == 0


def test_passes(vxs, level, render):
    """Each pass is a picture, lookups agree with rays, and those of another asset do not."""
    camera = "--eye", "6,9,2", "--target", "0,0,0", "--fov", 60
    moved = [[x + 2, y, z] for x, y, z in small_scene.BLOCK]
    small_scene.write(level / "moved.gltf", boxes=[small_scene.GROUND, moved], lights=small_scene.EACH_KIND)
    vxs("bake", level / "moved.gltf", "-o", level / "moved.vxs", "--resolution", 256)
    right = report(level, render, "all", "--passes", level / "right", *camera)["difference"]
    wrong = report(level, render, "moved", "--passes", level / "wrong", *camera)["difference"]
    names = {path.name for path in (level / "right").iterdir()}
    assert names == {"depth.png", "normal.png", "albedo.png", "light.png", "lights.png", "truth.png", "difference.png",
                     "lit-0-noon.png", "lit-1-spot.png", "lit-2-lamp.png"}
    assert {read_png((level / "right" / name).read_bytes())[:2] for name in names} == {(64, 48)}
    assert right["samples"] > 1000 and right["mean"] < 0.02 and right["too_dark"] + right["too_light"] < right["samples"] / 50
    assert wrong["mean"] > 3 * right["mean"] and wrong["too_light"] > 10 < wrong["too_dark"]


def colour(level, render, **material):
    """Mean red, green and blue of a picture from above."""
    small_scene.write(level / "level.gltf", lights=small_scene.EACH_KIND, **material)
    render("all", "--eye", "0.1,20,0", "--target", "0,0,0", "--fov", 20)
    rows = read_png((level / "out.png").read_bytes())[2]
    return [sum(sum(row[n::3]) for row in rows) for n in range(3)]


def test_colours_of_materials(vxs, level, render):
    """A base colour is seen; one that makes no sense is white, and nothing fails."""
    red, green, blue = colour(level, render, pbrMetallicRoughness={"baseColorFactor": [1, 0.2, 0.05, 1]})
    assert red > 1.1 * green > 1.2 * blue
    white = colour(level, render)
    for wrong in ([2, 0, 0, 1], ["red"], "red", [1, 0], {}):
        assert colour(level, render, pbrMetallicRoughness={"baseColorFactor": wrong}) == white
    assert colour(level, render, pbrMetallicRoughness=[]) == colour(level, render)


def test_colours_of_lights(vxs, level, render):
    gltf = json.loads(small_scene.write(level / "level.gltf", lights=small_scene.EACH_KIND).read_text())
    for light in gltf["extensions"]["KHR_lights_punctual"]["lights"]:
        light |= {"color": [0.1, 0.2, 1], "intensity": 40}
    (level / "level.gltf").write_text(json.dumps(gltf))
    render("all", "--eye", "0.1,20,0", "--target", "0,0,0", "--fov", 20)
    rows = read_png((level / "out.png").read_bytes())[2]
    red, green, blue = (sum(sum(row[n::3]) for row in rows) for n in range(3))
    assert blue > 1.05 * green and green > red
    small_scene.write(level / "level.gltf", lights=small_scene.EACH_KIND)


@pytest.mark.parametrize("draw", ["rays", "gl"])
def test_fog(vxs, level, draw):
    """Ink hides all, thin air nothing; drops shine where light comes, and below the fog's top alone."""
    def brightness(asset, *fog):
        vxs("render", level / "level.gltf", level / f"{asset}.vxs", "-o", level / "out.png", *SMALL[:4], "--draw", draw,
            "--eye", "0.1,20,0", "--target", "0,0,0", "--fov", 20, *(("--fog", *fog) if fog else ()))
        rows = read_png((level / "out.png").read_bytes())[2]
        return sum(map(sum, rows)) / (3 * 64 * 48)

    assert brightness("sun", 10, "--fog-albedo", 0) < 1
    assert brightness("sun", 0) == pytest.approx(brightness("sun"), rel=0.05)
    assert brightness("sun", 10, "--fog-albedo", 0, "--fog-top", -9) == brightness("sun", 0)
    assert brightness("all", 0.1, "--fog-albedo", 1) > 1.2 * brightness("all", 0.1, "--fog-albedo", 0) > 0
    assert brightness("sun", 0.1, "--fog-anisotropy", 0.9) != brightness("sun", 0.1, "--fog-anisotropy", -0.9)


def test_fog_with_opengl(vxs, level, render):
    """All techniques come to the airlight of exact intervals, which are the default; it is a pass, and a stage."""
    rows = {}
    for by, knob in (("march", ("steps", 400)), ("angles", ("steps", 400)), ("mesh", None), ("grid", ("grid", 128)), ("intervals", None)):
        options = ("--fog-by", by) if by != "intervals" else ()
        options += (f"--fog-{knob[0]}", knob[1]) if knob else ()
        told = report(level, render, "all", "--eye", "1,6,9", "--target", "0,1,0", "--fog", 0.05, "--fog-top", 8, *options, "--passes", level / by)
        assert {k: v for k, v in told["fog"].items() if k not in ("lights", "left_out")} == {"extinction_per_metre": [0.05] * 3, "scattering_per_metre": [pytest.approx(0.045)] * 3, "anisotropy": 0.4,
                               "top_metres": 8, "by": by} | dict([knob] if knob else [])
        assert told["median_ms"]["fog"] > 0
        rows[by] = [v for row in read_png((level / by / "airlight.png").read_bytes())[2] for v in row]
    half = report(level, render, "all", "--eye", "1,6,9", "--target", "0,1,0", "--fog", 0.05, "--fog-top", 8, "--fog-half", "--passes", level / "half")
    shares = [[light["share"] for light in r["fog"]["lights"] if "share" in light] for r in (half, told)]
    assert half["fog"]["is_half"] and len(shares[0]) == 3 and shares[0] == pytest.approx(shares[1], abs=0.1)
    rows["half"] = [v for row in read_png((level / "half" / "airlight.png").read_bytes())[2] for v in row]
    assert rows["half"] != rows["intervals"]
    exact = rows.pop("intervals")
    assert sum(exact) > 10 * len(exact)
    for by, found in rows.items():
        different = [abs(a - b) for a, b in zip(found, exact)]
        assert max(different) < 20 and sum(different) < len(different), by


def test_transmittance(level, render):
    """What fog leaves is exponential in the way through it: seen from above, through all of it, below its top alone, and up to the sky."""
    def middle(*options):
        render("sun", "--eye", "0.01,20,0", "--target", "0,0,0", "--fov", 20, *options, "--passes", level / "left")
        return read_png((level / "left" / "transmittance.png").read_bytes())[2]

    block, ground = middle("--fog", 0.05), middle("--fog", 0.05, "--fog-top", 1)
    assert list(block[24][3 * 32 : 3 * 33]) == [pytest.approx(255 * math.exp(-0.05 * 17), abs=1)] * 3  # its top is 3 high
    assert ground[24][3 * 32] == 255 and ground[24][3] == pytest.approx(255 * math.exp(-0.05 * math.hypot(1, math.tan(math.radians(10)) * 4 / 3)), abs=1)
    render("sun", "--eye", "0,20,0.1", "--target", "0,40,0", "--fog", 0.05, "--passes", level / "left")
    assert max(map(max, read_png((level / "left" / "transmittance.png").read_bytes())[2])) < 64


def test_plan_of_fog(level, render):
    """Lights that have no airlight to speak of, none in view, or none in the fog are left out, counted, and reported with the reason: when it is so, and only then."""
    here, up, away = ("--eye", "1,6,9", "--target", "0,1,0"), ("--eye", "1,6,9", "--target", "1,9,0"), ("--eye", "30,3,0", "--target", "60,3,0")
    words = {"faint": "too faint (together less than 1/6600 of white)", "out_of_view": "out of view", "clear": "not in the fog"}
    for drawn, faint, out, clear, options in ((3, 0, 0, 0, (*here, "--fog", 0.05)),
                                              (0, 3, 0, 0, (*here, "--fog", 1e-9)),
                                              (1, 0, 2, 0, (*away, "--fog", 0.00008)),
                                              (3, 0, 0, 0, (*here, "--fog", 0.05, "--fog-top", 3)),
                                              (0, 0, 0, 3, (*up, "--fog", 0.05, "--fog-top", 3))):
        told = report(level, render, "all", *options)
        counts = {"drawn": drawn, "faint": faint, "out_of_view": out, "clear": clear}
        assert told["frames"][0]["fog_lights"] == counts
        results = {light["light"]: light["cull_result"] for light in told["fog"]["lights"]}
        assert list(results) == ["noon", "spot", "lamp"] and {result: list(results.values()).count(result) for result in counts} == counts
        left_out = [saving["what"] for saving in told["fog"]["left_out"]]
        assert left_out == ["all passes of lights"] * (not drawn) + ["march, grid and mesh", "shadow depth maps"]
        line = f"fog          3 lights: {drawn} drawn by intervals" + "".join(f", {counts[k]} {words[k]}" for k in words if counts[k]) + "\n"
        assert render("all", *options).stdout.splitlines(keepends=True)[:-1] == [line]
        said = render("all", *options, "--verbose").stdout
        assert said.startswith(line) and all((f"light {name} is left out: {words.get(result)}\n" in said) == (result != "drawn")
                                             and (f"light {name}: by intervals, in " in said) == (result == "drawn") for name, result in results.items())
        assert render("all", *options, "--quiet").stdout == ""
    assert "fog_lights" not in report(level, render, "all")["frames"][0] and render("all").stdout.startswith("wrote ")
    told = render("sun", *away, "--fog", 0.01, "--json", "-")
    assert json.loads(told.stdout)["frames"][0]["fog_lights"]["drawn"] == 1 and told.stderr.startswith("fog          1 light: 1 drawn")


def test_plan_of_meshes(level, render):
    """A mesh is made once, of a light that is drawn; the picture is the same as if all were."""
    away = "--eye", "30,3,0", "--target", "60,3,0", "--fog", 0.00008, "--fog-by", "mesh"
    left_out = [saving["what"] for saving in report(level, render, "all", *away)["fog"]["left_out"]]
    picture = (level / "out.png").read_bytes()
    assert left_out == ["adaptive pass", "2 of 3 meshes"]
    assert [saving["what"] for saving in report(level, render, "sun", *away)["fog"]["left_out"]] == ["adaptive pass"]
    render("all", *away[:-1], "intervals")
    exact = (level / "out.png").read_bytes()
    assert max(abs(a - b) for rows in zip(read_png(picture)[2], read_png(exact)[2]) for a, b in zip(*rows)) <= 1


def test_picture_of_a_mesh(level, render):
    """From a lit eye a ray leaves the light before it comes into it again: no pixel is warmer than cold. Without meshes there is no such picture."""
    camera = "--eye", "1,6,9", "--target", "0,1,0", "--fog", 0.05
    render("sun", *camera, "--fog-by", "mesh", "--passes", level / "mesh")
    wide, high, rows = read_png((level / "mesh" / "light-mesh.png").read_bytes())[:3]
    pixels = [row[n : n + 3] for row in rows for n in range(0, 3 * wide, 3)]
    assert (wide, high) == (64, 48)
    assert sum(blue > red + 20 for red, _, blue in pixels) > 100 and sum(red > blue + 5 for red, _, blue in pixels) < 20
    assert any(red == blue for red, _, blue in pixels)
    render("sun", *camera, "--passes", level / "no mesh")
    assert not (level / "no mesh" / "light-mesh.png").exists()


def test_picture_of_a_grid(level, render):
    """Behind what shadows a ray all of it is dark: columns only grow darker with alpha."""
    render("sun", "--eye", "1,6,9", "--target", "0,1,0", "--fog", 0.05, "--fog-by", "grid", "--fog-grid", 64, "--passes", level / "grid")
    wide, high, rows = read_png((level / "grid" / "shadow-grid.png").read_bytes())[:3]
    greys = [list(row[::3]) for row in rows]
    assert (wide, high) == (64, 128)
    assert all(a >= b for row in greys for a, b in zip(row, row[1:]))
    assert any(0 < grey < 255 for row in greys for grey in row)


def test_grid_of_a_processor(level, render):
    """Fewer voxels without a GPU; and one that OpenGL has no room for is an error."""
    camera = "--eye", "1,6,9", "--target", "0,1,0", "--fog", 0.05, "--fog-by", "grid"
    assert report(level, render, "sun", *camera)["fog"]["grid"] == 256
    said = render("sun", *camera, "--fog-grid", 1024, status=6).stderr
    assert "shadow grid of 1024 x 2048 x 1024" in said and said.count("\n") == 1


def test_meshes_along_a_path(level, render):
    """Made once, they are right wherever the eye goes."""
    airlight = []
    for by in ("mesh", "intervals"):
        render("all", "--orbit", "--frames", 4, "--eye", "1,6,9", "--target", "0,1,0", "--fog", 0.05, "--fog-by", by, "--passes", level / by)
        airlight.append([v for row in read_png((level / by / "airlight.png").read_bytes())[2] for v in row])
    assert sum(abs(a - b) for a, b in zip(*airlight)) < len(airlight[0])


def test_inner_cones(vxs, level, render):
    """From the middle of a spot light to its edge: as bright up to its inner cone, then darker; without one, darker from the middle on."""
    shares = []
    vxs("bake", level / "level.gltf", "-o", level / "spot.vxs", "--resolution", 256, "--light", "spot")
    for degrees in (None, 30, 45):
        gltf = json.loads(small_scene.write(level / "level.gltf", lights=small_scene.EACH_KIND).read_text())
        spot = gltf["extensions"]["KHR_lights_punctual"]["lights"][1]["spot"]
        if degrees:
            spot["innerConeAngle"] = math.radians(degrees)
        (level / "level.gltf").write_text(json.dumps(gltf))
        render("spot", "--eye", "0.01,20,0", "--target", "0,0,0", "--fov", 36, "--passes", level / "cone")
        row = read_png((level / "cone" / "light.png").read_bytes())[2][24][::3]
        shares.append(row[15] / row[22])  # at 37 and 23 degrees
        assert row[22] > 50 and row[3] == row[26] == 0  # beyond the cone, and behind the block
    small_scene.write(level / "level.gltf", lights=small_scene.EACH_KIND)
    assert shares[0] < 0.6 and shares[0] < shares[1] - 0.05 and shares[1] < 0.8 < shares[2]


@pytest.mark.parametrize("text, words", [
    ("0 1 2 3 4 5\n", "has 1 keys: a path needs two"),
    ("0 1 2 3 4 5\n1 2 3 4 5\n", "line 2: expected six numbers"),
    ("0 1 2 3 4 5\n1 2 3 4 5 6 7\n", "line 2: expected six numbers"),
    ("1 2 3 1 2 3\n", "line 1: expected six numbers"),
    ("0 1 2 3 4 nan\n", "line 1: expected six numbers"),
    ("0 1 2 3 4 5\0\n", "is no text"),
    ("0 1 2 3 4 5\n" * 10001, "line 10001: more than 10000 keys"),
])
def test_bad_paths(level, render, text, words):
    (level / "bad.txt").write_text(text)
    said = render("sun", "--path", level / "bad.txt", status=3).stderr
    assert said.startswith("vxs: error: ") and words in said and said.count("\n") == 1


@pytest.mark.parametrize("options, words", [
    (["--frames", 3], "--frames 3 needs --path or --orbit"),
    (["--orbit", "--path", "PATH"], "exclude each other"),
    (["--fog-by", "march"], "--fog-by needs --fog"),
    (["--fog-top", 1], "--fog-top needs --fog"),
    (["--fog-grid", 64], "--fog-grid needs --fog"),
    (["--fog-half"], "--fog-half needs --fog"),
    (["--fog", 1, "--fog-steps", 9], "--fog-steps 9 needs --fog-by march or angles"),
    (["--fog", 1, "--fog-by", "grid", "--fog-steps", 9], "--fog-steps 9 needs --fog-by march or angles"),
    (["--fog", 1, "--fog-by", "mesh", "--fog-grid", 64], "--fog-grid 64 needs --fog-by grid"),
    (["--fog", 1, "--fog-by", "grid", "--fog-grid", 8], "--fog-grid"),
    (["--fog", 1, "--fog-by", "mesh", "--budget", "30M"], "--fog-by mesh goes without --budget"),
    (["--fog", -1], "--fog"),
    (["--fog", 1, "--fog-albedo", 2], "--fog-albedo"),
    (["--path", "PATH", "--eye", "0,1,2", "--target", "0,0,0"], "--path and --eye exclude each other"),
])
def test_options_are_checked(level, render, options, words):
    (level / "p.txt").write_text("0 0 0 1 1 1\n1 1 1 2 2 2\n")
    done = render("sun", *(level / "p.txt" if option == "PATH" else option for option in options), status=2)
    assert words in done.stderr and done.stderr.count("\n") == 1


def test_passes_need_a_folder(level, render):
    (level / "file").write_text("")
    said = render("sun", "--passes", level / "file", status=4).stderr
    assert "file" in said and said.count("\n") == 1
    assert "cannot be made" in render("sun", "--passes", level / "no" / "folder", status=4).stderr


# --- streams ------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def forest(vxs, tmp_path_factory):
    """A folder with forest.glb and forest.vxs, of some pages."""
    folder = tmp_path_factory.mktemp("stream")
    vxs("scene", "forest", "--triangles", 20000, "-o", folder / "forest.glb")
    vxs("bake", folder / "forest.glb", "-o", folder / "forest.vxs", "--resolution", 8192)
    return folder


@pytest.fixture(scope="module")
def stream(vxs, forest):
    def run(*options, asset=forest / "forest.vxs", scene=forest / "forest.glb", **more):
        return vxs("render", scene, asset, "-o", forest / "out.png", *SMALL, *options, **more)

    return run


def least_budget(stream, **more):
    said = stream("--budget", 1, status=6, **more).stderr
    assert said.count("\n") == 1 and said.startswith("vxs: error: --budget 1: ")
    return int(re.search(r"needs at least (\d+) bytes", said)[1])


def test_a_budget_for_all_changes_nothing(level, render):
    """Not a byte of the picture, of lights in any order; reports without one know nothing of streams."""
    lights = "--light", "lamp", "--light", "noon", "--eye", "6,9,2", "--target", "0,0,0", "--fov", 60
    whole = report(level, render, "all", *lights)
    picture = (level / "out.png").read_bytes()
    streamed = report(level, render, "all", *lights, "--budget", "30M")
    assert (level / "out.png").read_bytes() == picture
    frame, = streamed["frames"]
    assert frame["stream"]["full_share"] == 1 and frame["stream"]["pages_resident"] == frame["stream"]["pages"] > 1
    assert frame["stream"]["uploaded_bytes"] >= whole["word_bytes"] and frame["stream"]["waiting_bytes"] == 0
    assert streamed["held_bytes"] <= streamed["budget_bytes"] == 30 << 20
    assert "stream" not in whole["frames"][0] and "upload" not in whole["frames"][0]["ms"] and "budget_bytes" not in whole


def test_path_of_a_stream(forest, stream):
    """Never beyond the budget, never more than a slice a frame; reports agree with each other, with the picture of what is there, and on one thread."""
    budget, slice_bytes = least_budget(stream) + 1000000, 40000
    path = "--budget", budget, "--upload", slice_bytes, "--orbit", "--frames", 9, "--eye", "60,20,60", "--target", "0,0,0"
    stream(*path, "--json", forest / "r.json", "--csv", forest / "r.csv", "--plot", forest / "r.svg", "--passes", forest / "passes")
    picture, table = (forest / "out.png").read_bytes(), list(csv.DictReader((forest / "r.csv").read_text().splitlines()))
    found = json.loads((forest / "r.json").read_text())
    jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
    assert found["held_bytes"] <= found["budget_bytes"] == budget
    frames = [frame["stream"] for frame in found["frames"]]
    for n, (frame, row) in enumerate(zip(frames, table, strict=True)):
        assert all(float(row[name]) == pytest.approx(value, rel=1e-3, abs=1e-4) for name, value in frame.items())
        assert frame["resident_bytes"] <= budget
        assert float(row["upload_ms"]) == pytest.approx(found["frames"][n]["ms"]["upload"], abs=1e-3)
    for before, frame in zip(frames, frames[1:]):
        assert frame["uploaded_bytes"] <= slice_bytes + 2 * 4 * (8192 // 256) ** 2  # words that hide and show squares
        assert frame["pages_resident"] == before["pages_resident"] + frame["pages_appeared"] - frame["pages_left"]
        assert frame["waiting_bytes"] == 0 or frame["uploaded_bytes"] >= slice_bytes
    assert frames[0]["pages_resident"] == frames[0]["pages_appeared"] > 1 and frames[0]["waiting_bytes"] == 0
    assert sum(f["pages_left"] for f in frames[1:]) > 1 < sum(f["pages_appeared"] for f in frames[1:])
    assert any(f["waiting_bytes"] for f in frames) and any(0 < f["full_share"] < 1 for f in frames)

    colours = [tuple(row[n:n + 3]) for row in read_png((forest / "passes" / "resident.png").read_bytes())[2] for n in range(0, len(row), 3)]
    seen = [c for c in colours if c != (0, 0, 0)]
    assert set(seen) == {(191, 191, 191), (64, 64, 64), (217, 38, 13)}, "one light: in full, none, coarse"
    assert frames[-1]["full_share"] == pytest.approx(1 - seen.count((217, 38, 13)) / len(seen), abs=1e-4)

    plot = xml.etree.ElementTree.fromstring((forest / "r.svg").read_text())
    assert [len(p.get("points").split()) for p in plot.iter("{http://www.w3.org/2000/svg}polygon")] == [18] * 5
    assert [len(p.get("points").split()) for p in plot.iter("{http://www.w3.org/2000/svg}polyline")] == [9]

    stream(*path, "--csv", forest / "again.csv", "--threads", 1)
    again = list(csv.DictReader((forest / "again.csv").read_text().splitlines()))
    assert [{k: v for k, v in row.items() if not k.endswith("_ms")} for row in again] == \
        [{k: v for k, v in row.items() if not k.endswith("_ms")} for row in table]
    assert (forest / "out.png").read_bytes() == picture


def test_least_budget(forest, stream):
    """What the message says is enough, a byte less is not; then all that needs a page is coarse."""
    least = least_budget(stream)
    assert f"needs at least {least} bytes" in stream("--budget", least - 1, status=6).stderr
    stream("--budget", least, "--eye", "60,20,60", "--target", "0,0,0", "--json", forest / "r.json")
    found = json.loads((forest / "r.json").read_text())
    frame = found["frames"][0]["stream"]
    assert found["held_bytes"] <= least and frame["pages_resident"] == 0 < frame["pages"] and 0 < frame["full_share"] < 1


def test_budget_is_checked(vxs, level, forest, stream):
    """One line each, before anything is drawn."""
    for options, status, words in (
            (("--upload", "1M"), 2, "--upload 1048576 needs --budget"),
            (("--budget", "much"), 2, "expected a number of bytes"),
            (("--budget", "30M", "--light", "moon"), 2, "has no light of that name; it has sun"),
            (("--budget", "30M", "--light", "sun", "--light", "sun"), 2, "--light sun is given twice")):
        said = stream(*options, status=status).stderr
        assert words in said and said.count("\n") == 1 and said.startswith("vxs: error: ")
    said = vxs("render", forest / "forest.glb", forest / "forest.vxs", "-o", forest / "out.png", "--draw", "rays", "--budget", "30M", status=2).stderr
    assert said == "vxs: error: --draw rays goes without --budget, which is for OpenGL\n"
    said = vxs("render", forest / "forest.glb", "-", "-o", forest / "out.png", "--budget", "30M", input="x", status=2).stderr
    assert "standard input is read once" in said and said.count("\n") == 1
    said = stream("--budget", "30M", "--strict", scene=level / "level.gltf", status=1).stderr
    assert "was baked from another scene" in said


def test_broken_page_of_a_stream(forest, stream):
    """It opens, and the page that is damaged is named."""
    data = bytearray((forest / "forest.vxs").read_bytes())
    data[len(data) // 2] ^= 1
    (forest / "broken.vxs").write_bytes(data)
    said = stream("--budget", "30M", asset=forest / "broken.vxs", status=3).stderr
    assert re.search(r"broken.vxs' is not a valid .vxs file: page \d of light 'sun' \(finding 50\d\)", said) and said.count("\n") == 1
