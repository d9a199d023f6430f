# vxs render of scenes with smoke: how much of each light it leaves, as looked through in double; how it is seen; what the plan
# says.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import math
import os
import struct
import subprocess

import jsonschema
import pytest

import small_scene
from conftest import ROOT
from png import read_png

LAMP = (0, 6, 0)  # where small_scene puts the spot and the point light
# places, radii, extinctions; the last one is cut by the ground
BALLS = [((0.4, 3, 0.2), 1.2, 0.5), ((-1.5, 2, 1), 0.8, 1.5), ((2.5, 1.5, -2), 1.5, 0.3), ((0.5, 4, -1), 0.7, 2), ((-3, 0.2, -2), 1.4, 0.8)]
EYE, TARGET, FOV, WIDE, HIGH = (7, 9, 6), (0, 1, 0), 60, 96, 72
SMALL = "--width", WIDE, "--height", HIGH, "--samples", 1, "--filter", 1, "--eye", "7,9,6", "--target", "0,1,0", "--fov", FOV


def add_balls(path, balls, to):
    """A copy of a small scene with points that are smoke."""
    gltf = json.loads(path.read_text())
    data = b"".join(struct.pack("<5f", *place, radius, extinction) for place, radius, extinction in balls)
    view, accessor = len(gltf["bufferViews"]), len(gltf["accessors"])
    gltf["bufferViews"].append({"buffer": len(gltf["buffers"]), "byteLength": len(data), "byteStride": 20})
    gltf["buffers"].append({"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()})
    gltf["accessors"] += [{"bufferView": view, "byteOffset": at, "componentType": 5126, "type": kind, "count": len(balls)}
                          for at, kind in ((0, "VEC3"), (12, "SCALAR"), (16, "SCALAR"))]
    gltf["meshes"].append({"primitives": [{"mode": 0, "attributes": {"POSITION": accessor, "_RADIUS": accessor + 1,
                                                                     "_EXTINCTION": accessor + 2}}]})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]))
    gltf["nodes"].append({"mesh": len(gltf["meshes"]) - 1})
    to.write_text(json.dumps(gltf))


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    """A folder with a ground, baked, with smoke over it and without."""
    folder = tmp_path_factory.mktemp("smoke")
    clear = small_scene.write(folder / "clear.gltf", boxes=[small_scene.GROUND], lights=small_scene.EACH_KIND)
    add_balls(clear, BALLS, folder / "smoke.gltf")
    vxs("bake", clear, "-o", folder / "level.vxs", "--resolution", 512)
    return folder


def draw(vxs, level, scene, *options, **more):
    """Output, report, and the picture's bytes."""
    done = vxs("render", level / f"{scene}.gltf", level / "level.vxs", "-o", level / "out.png", *SMALL, "--json", level / "r.json", *options,
               **more)
    found = json.loads((level / "r.json").read_text())
    jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
    return done, found, (level / "out.png").read_bytes()


def unit(v):
    size = math.sqrt(sum(c * c for c in v))
    return [c / size for c in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def direction_of(x, y):
    ahead = unit([t - e for t, e in zip(TARGET, EYE)])
    right = unit(cross(ahead, (0, 1, 0)))
    up, high = cross(right, ahead), math.tan(math.radians(FOV / 2))
    across, above = (2 * (x + 0.5) / WIDE - 1) * high * WIDE / HIGH, (1 - 2 * (y + 0.5) / HIGH) * high
    return unit([f + across * r + above * u for f, r, u in zip(ahead, right, up)])


def left_between(begin, way, metres, balls=BALLS):
    """What all balls leave of a ray's light."""
    depth = 0
    for place, radius, extinction in balls:
        to = [p - b for p, b in zip(place, begin)]
        near = sum(a * b for a, b in zip(to, way))
        inside = radius ** 2 - sum(t * t for t in to) + near ** 2
        if inside > 0:
            half = math.sqrt(inside)
            depth += extinction * max(0, min(near + half, metres) - max(near - half, 0))
    return math.exp(-depth)


def ground_places():
    """Of pixels that show the top of the ground: the number, the way to it, and where it is."""
    for n in range(WIDE * HIGH):
        way = direction_of(n % WIDE, n // WIDE)
        metres = -EYE[1] / way[1] if way[1] < 0 else math.inf
        at = [e + metres * w for e, w in zip(EYE, way)] if metres < math.inf else (9, 9, 9)
        if max(abs(at[0]), abs(at[2])) < 7.9:
            yield n, way, metres, at


def grey(path):
    return [c / 255 for row in read_png(path.read_bytes())[2] for c in row[::3]]


def errors(found, wanted):
    off = sorted(abs(a - b) for a, b in zip(found, wanted))
    return math.sqrt(sum(e * e for e in off) / len(off)), off[int(0.98 * len(off))]


@pytest.mark.parametrize("n, light", list(enumerate(["noon", "spot", "lamp"])))
def test_what_reaches_the_ground(vxs, level, n, light):
    done, found, _ = draw(vxs, level, "smoke", "--passes", level / "passes", "--verbose")
    assert "5 capsules; 3 lights: 3 dimmed" in done.stdout and f"light {light}: smoke by 256 x 256 curves" in done.stdout
    assert found["frames"][0]["smoke_lights"] == {"dims": 3, "out_of_reach": 0, "out_of_view": 0, "no_room": 0, "built": 3}
    assert found["smoke"]["lights"][n]["cull_result"] == "dims" and found["smoke"]["lights"][n]["merged"] == 0
    picture, left, wanted = grey(level / "passes" / f"smoke-{n}-{light}.png"), [], []
    for pixel, _, _, at in ground_places():
        to_light = [-d for d in small_scene.EACH_KIND[0][2]] if light == "noon" else [p - a for p, a in zip(LAMP, at)]
        metres = math.inf if light == "noon" else math.sqrt(sum(t * t for t in to_light))
        if light == "spot" and to_light[1] < 0.72 * metres:
            continue  # beside the cone nothing is queried
        left.append(picture[pixel])
        wanted.append(left_between(at, unit(to_light), metres))
    assert len(left) > 500 and sum(0.1 < w < 0.9 for w in wanted) > 150
    rms, most = errors(left, wanted)
    assert rms < 0.03 and most < 0.1, (rms, most)  # curves are lines between their nodes: it is seen in the ball that the ground cuts


def linear(grey):
    return grey / 12.92 if grey <= 0.04045 else ((grey + 0.055) / 1.055) ** 2.4


def light_of(vxs, level, *options):
    draw(vxs, level, "smoke", "--light", "lamp", "--exposure", -1, "--passes", level / "passes", *options)
    return [linear(c) for c in grey(level / "passes" / "light.png")]


def test_surfaces_are_dimmed(vxs, level):
    """By as much as the picture of it says; exposures are distinguished by light that no smoke dims."""
    with_smoke, left = light_of(vxs, level), grey(level / "passes" / "smoke-0-lamp.png")
    without = light_of(vxs, level, "--smoke", "off")
    places = [n for n, *_ in ground_places() if without[n] > 0.02]
    clear = [n for n in places if left[n] == 1]
    exposure = sum(with_smoke[n] for n in clear) / sum(without[n] for n in clear)
    rms, most = errors([with_smoke[n] / without[n] / exposure for n in places], [left[n] for n in places])
    assert rms < 0.012 and most < 0.03 and len(clear) > 100 and sum(left[n] < 0.7 for n in places) > 150, (rms, most)


def test_what_is_seen_through(vxs, level):
    draw(vxs, level, "smoke", "--passes", level / "passes")
    picture, places = grey(level / "passes" / "smoke.png"), list(ground_places())
    wanted = [left_between(EYE, way, metres) for _, way, metres, _ in places]
    rms, most = errors([picture[n] for n, *_ in places], wanted)
    assert rms < 0.005 and most < 0.01 and sum(w < 0.7 for w in wanted) > 150, (rms, most)


def test_off_is_as_without(vxs, level):
    _, found, without = draw(vxs, level, "clear")
    assert "smoke" not in found and "smoke_lights" not in found["frames"][0] and "smoke" not in found["frames"][0]["ms"]
    done, off_found, off = draw(vxs, level, "smoke", "--smoke", "off")
    assert off == without and "smoke" not in off_found and "capsules" not in done.stdout
    assert draw(vxs, level, "smoke")[2] != without


def test_fog_is_dimmed(vxs, level):
    """By marches, whatever was requested. Exposures are distinguished by light that no smoke dims."""
    clear_ground = [n for n, _, _, at in ground_places() if left_between(at, unit([p - a for p, a in zip(LAMP, at)]), 9) == 1]

    def air(*options):
        light = light_of(vxs, level, "--fog", 0.08, *options)
        plan, = json.loads((level / "r.json").read_text())["fog"]["lights"]
        return plan, sum(map(linear, grey(level / "passes" / "airlight.png"))) / sum(light[n] for n in clear_ground)

    (clear_plan, clear), (plan, dimmed) = air("--smoke", "off"), air("--fog-steps", 48)
    assert clear_plan["by"] == "intervals" and (plan["by"], plan["why"]) == ("angles", "smoke dims it")
    assert len(clear_ground) > 100 and 0.5 * clear < dimmed < 0.98 * clear, (clear, dimmed)


def test_steps_of_fog(vxs, level):
    """Smoke of the scene takes steps without an option; where nothing does, a line says what would."""
    fog = "--light", "noon", "--fog", 0.1, "--fog-steps", 9
    assert draw(vxs, level, "smoke", *fog)[1]["fog"]["steps"] == 9
    for scene, options, words in (("smoke", ["--smoke", "off"], "--fog-steps 9 needs --fog-by march or angles, or --smoke on\n"),
                                  ("clear", [], "--fog-steps 9 needs --fog-by march or angles: there is no smoke, and nothing moves\n")):
        done = vxs("render", level / f"{scene}.gltf", level / "level.vxs", "-o", level / "no.png", *SMALL, *fog, *options, status=2)
        assert done.stderr.endswith(words) and done.stderr.count("\n") == 1


def test_out_of_reach_and_out_of_view(vxs, tmp_path):
    """A lamp whose range ends before the smoke, one out of view, and one that the smoke dims."""
    clear = small_scene.write(tmp_path / "level.gltf", boxes=[small_scene.GROUND], lights=small_scene.EACH_KIND[2:] * 3)
    gltf = json.loads(clear.read_text())
    for n, (range_m, place) in enumerate(((1.5, [-7, 1, 7]), (2, [7.5, 1, 7.5]), (20, [0, 6, 0]))):
        gltf["extensions"]["KHR_lights_punctual"]["lights"][n]["range"] = range_m
        gltf["nodes"][1 + n]["translation"] = place
    clear.write_text(json.dumps(gltf))
    add_balls(clear, BALLS + [((7.5, 1, 6.5), 0.5, 1)], tmp_path / "smoke.gltf")
    vxs("bake", clear, "-o", tmp_path / "level.vxs", "--resolution", 256)
    done, found, _ = draw(vxs, tmp_path, "smoke", "--verbose")
    assert [p["cull_result"] for p in found["smoke"]["lights"]] == ["out_of_reach", "out_of_view", "dims"]
    assert "3 lights: 1 dimmed, 1 out of its reach, 1 out of view" in done.stdout
    assert "light lamp: no smoke: out of its reach" in done.stdout


def test_maps_are_built_once(vxs, level):
    (level / "path.txt").write_text("7 9 6 0 1 0\n-7 9 6 0 1 0\n")
    options = [*SMALL[:SMALL.index("--eye")], "--path", level / "path.txt", "--frames", 2, "--json", level / "r.json"]
    vxs("render", level / "smoke.gltf", level / "level.vxs", "-o", level / "out.png", *options)
    frames = json.loads((level / "r.json").read_text())["frames"]
    assert [f["smoke_lights"]["built"] for f in frames] == [3, 0] and [f["smoke_lights"]["dims"] for f in frames] == [3, 3]


@pytest.mark.skipif(not os.environ.get("VXS_LARGE"), reason="set VXS_LARGE=1: five million segments take half a minute")
def test_no_room(vxs, tmp_path):
    """What lists have no room for is counted, and said with a remedy; a picture is drawn all the same."""
    clear = small_scene.write(tmp_path / "level.gltf", boxes=[small_scene.GROUND], lights=small_scene.EACH_KIND[:1])
    add_balls(clear, [((0, 3 + 0.01 * n, 0), 12, 0.01) for n in range(20)], tmp_path / "smoke.gltf")
    vxs("bake", clear, "-o", tmp_path / "level.vxs", "--resolution", 512)
    done, found, _ = draw(vxs, tmp_path, "smoke", "--smoke-side", 512)
    plan, = found["smoke"]["lights"]
    assert plan["segments"] > 1 << 22 and plan["merged"] == plan["segments"] - (1 << 22)
    assert f"{plan['merged']} of {plan['segments']} segments" in done.stderr and "--smoke-side below 512" in done.stderr


def test_wrong_options(vxs, level):
    scene = level / "smoke.gltf", level / "level.vxs", "-o", level / "no.png"
    for options, words in ((["--smoke-side", 15], "16 to 2048"), (["--smoke", "off", "--smoke-side", 64], "--smoke-side needs --smoke on"),
                           (["--draw", "rays", "--smoke", "on"], "--draw rays goes without --smoke")):
        done = vxs("render", *scene, *options, status=2)
        assert words in done.stderr and done.stderr.count("\n") == 1


def test_smoke_that_covers_everything(vxs_path, level, tmp_path):
    """Thousands of balls over all of a map and of the picture: the map gets fewer curves, or it is reported that it takes long, before the work."""
    add_balls(level / "clear.gltf", [((0.01 * (n % 50), 3, 0.01 * (n // 50)), 40, 0.0001) for n in range(3000)], tmp_path / "thick.gltf")

    def first_warning(*options):
        with subprocess.Popen([vxs_path, "render", tmp_path / "thick.gltf", level / "level.vxs", "-o", tmp_path / "out.png", "--quiet", "--light", "noon",
                               *map(str, options)], stderr=subprocess.PIPE, text=True) as run:
            line = run.stderr.readline()
            run.kill()
        return line

    assert first_warning("--width", 16, "--height", 16) == ("vxs: warning: smoke: 3000 capsules cover 1.97e+08 texels of the map of light noon: it has "
                                                            "149 x 149 curves in place of 256 x 256, unless --smoke-side is larger\n")
    assert first_warning("--width", 16, "--height", 16, "--smoke-side", 300) == (
        "vxs: warning: smoke: 3000 capsules cover 2.7e+08 texels of the map of light noon, which takes long: --smoke-side below 300 takes less\n")
    assert first_warning("--width", 1024, "--height", 768, "--samples", 1, "--smoke-side", 16) == (
        "vxs: warning: smoke: 3000 capsules cover the picture 3000 times, which takes long to draw: a smaller picture, or --samples 1, takes less\n")
