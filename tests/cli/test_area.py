# vxs render with area lights: how much light, which VPLs, what is left out; the scene of a screen.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import math
import struct
import time

import jsonschema
import pytest

import damage
import small_scene
from conftest import ROOT
from png import read_png

SIZE = 64, 48
RADIANCE = 1, 0.5, 0.25


def add_quads(path, quads, **material):
    """Parallelograms of light in a small scene: corner, across, up; each a node and a material of its own."""
    gltf = json.loads(path.read_text())
    data = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    views, accessors = [{"buffer": 1, "byteOffset": 0, "byteLength": 12}], [{"bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 6}]
    for n, (corner, across, up, factor) in enumerate(quads):
        places = [corner, [c + a for c, a in zip(corner, across)], [c + a + b for c, a, b in zip(corner, across, up)], [c + b for c, b in zip(corner, up)]]
        views.append({"buffer": 1, "byteOffset": len(data), "byteLength": 48})
        accessors.append({"bufferView": 3 + n, "componentType": 5126, "type": "VEC3", "count": 4, "min": [min(c) for c in zip(*places)],
                          "max": [max(c) for c in zip(*places)]})
        data += b"".join(struct.pack("<3f", *p) for p in places)
        gltf["materials"].append({"emissiveFactor": factor, **material})
        gltf["meshes"].append({"primitives": [{"attributes": {"POSITION": 3 + n}, "indices": 2, "material": 1 + n}]})
        gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]))
        gltf["nodes"].append({"name": f"quad {n}", "mesh": 1 + n})
    gltf["buffers"].append({"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()})
    gltf["bufferViews"] += views
    gltf["accessors"] += accessors
    path.write_text(json.dumps(gltf))


ABOVE, BESIDE = ((-1, 4, -1), (2, 0, 0), (0, 0, 2)), ((3, 4, -1), (1, 0, 0), (0, 0, 1))  # across x up is down


@pytest.fixture(scope="module")
def lit(vxs, tmp_path_factory):
    """render(*options, colours): what vxs says, its report, and its folder; of a floor in a sun of 1 lux, below ABOVE and BESIDE, which shine so."""
    folder = tmp_path_factory.mktemp("area")
    scene, asset = folder / "level.gltf", folder / "level.vxs"

    def write(colours, boxes=(), **material):
        small_scene.write(scene, boxes=[small_scene.GROUND, *boxes], lights=[("sun", "directional", (1, -1, 0))])
        add_quads(scene, [(*ABOVE, colours[0]), (*BESIDE, colours[1])], **material)

    write([RADIANCE, [0, 0, 0]])
    vxs("bake", scene, "-o", asset, "--resolution", 256)

    def render(*options, colours=(RADIANCE, [0, 0, 0]), boxes=(), **material):
        write(colours, boxes, **material)
        said = vxs("render", scene, asset, "-o", folder / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1,
                   "--json", folder / "r.json", *options).stdout
        found = json.loads((folder / "r.json").read_text())
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
        return said.partition("wrote  ")[0], found, folder

    return render


def linear(byte):
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def irradiance(place, steps=40):
    """What a floor gets of ABOVE, of radiance 1: each piece by both cosines and the square of how far away it is."""
    total = 0
    for i in range(steps):
        for k in range(steps):
            way = [c + (i + 0.5) / steps * a + (k + 0.5) / steps * b - p for c, a, b, p in zip(*ABOVE, place)]
            total += way[1] ** 2 / sum(w * w for w in way) ** 2
    return total * 4 / steps ** 2


CAMERA = "--eye", "0,3,0.01", "--target", "0,0,0", "--fov", 60
SLOPE = 3 * math.tan(math.radians(30)) / SIZE[1]  # of the floor, half a pixel of CAMERA


def test_light_of_a_quad(lit, tmp_path):
    """As much as its radiance over its solid angle, beside a sun of 1 lux; each channel by itself. Air that is clear adds none."""
    _, found, _ = lit(*CAMERA, "--area", 64, "--area-gather", "each", "--exposure", -0.5, "--passes", tmp_path)
    area, light = (read_png((tmp_path / name).read_bytes())[2] for name in ("area.png", "light.png"))
    assert found["area"]["lights"] == [{"node": "quad 0", "cull_result": "drawn", "vpls": 64}] and found["area"]["points_of"] == "scene"
    assert found["frames"][0]["area_lights"] == {"drawn": 1, "faint": 0, "behind": 0} and found["median_ms"]["area"] > 0
    assert "fog" not in found and not (tmp_path / "airlight.png").exists()
    for y in range(2, SIZE[1], 8):
        for x in range(2, SIZE[0], 8):
            wanted = irradiance([SLOPE * (2 * x + 1 - SIZE[0]), 0, SLOPE * (2 * y + 1 - SIZE[1])])
            for n in range(3):
                here, both = linear(area[y][3 * x + n]), linear(light[y][3 * x + n])
                assert here / (both - here) == pytest.approx(RADIANCE[n] * wanted / math.sqrt(0.5), rel=0.05), (x, y, n)


def floor_of(eye, target, x, y, fov=60):
    """Where a pixel shows the floor; None: it shows none."""
    def unit(v):
        length = math.sqrt(sum(c * c for c in v))
        return [c / length for c in v]
    ahead = unit([t - e for t, e in zip(target, eye)])
    right = unit([-ahead[2], 0, ahead[0]])
    up = [right[1] * ahead[2] - right[2] * ahead[1], right[2] * ahead[0] - right[0] * ahead[2], right[0] * ahead[1] - right[1] * ahead[0]]
    half = math.tan(math.radians(fov / 2))
    across, down = half * (2 * x + 1 - SIZE[0]) / SIZE[1], half * (SIZE[1] - 2 * y - 1) / SIZE[1]
    way = [a + across * r + down * u for a, r, u in zip(ahead, right, up)]
    return [e - eye[1] / way[1] * w for e, w in zip(eye, way)] if way[1] < 0 else None


@pytest.mark.parametrize("eye, target, points", [((3, 1.6, 7), (0, 0.3, 0), "scene"), ((5, 0.5, 4), (0, 0.2, 1), "scene"), ((3, 1.6, 7), (0, 0.3, 0), "asset")])
def test_from_each_eye(vxs, lit, tmp_path, eye, target, points):
    """A floor of 40 m has as much light, seen from wherever, by points of the scene as by those of a file."""
    ground, place = [((-20, -1, -20), (20, 0, 20))], ["--eye", ",".join(map(str, eye)), "--target", ",".join(map(str, target)), "--fov", 60]
    asked = *place, "--area", 64, "--area-gather", "each", "--exposure", -1, "--passes", tmp_path
    _, found, folder = lit(*asked, boxes=ground)
    if points == "asset":
        vxs("bake", folder / "level.gltf", "-o", tmp_path / "points.vxs", "--resolution", 256, "--points", 1 << 18)
        vxs("render", folder / "level.gltf", tmp_path / "points.vxs", "-o", tmp_path / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1, "--force", *asked)
    area, light = (read_png((tmp_path / name).read_bytes())[2] for name in ("area.png", "light.png"))
    ratios, sums = [], [0, 0]
    for x, y in ((x, y) for y in range(1, SIZE[1], 2) for x in range(1, SIZE[0], 3)):
        at = floor_of(eye, target, x, y)
        here, sun = linear(area[y][3 * x]), linear(light[y][3 * x]) - linear(area[y][3 * x])
        if at is None or max(abs(at[0]), abs(at[2])) > 6 or sun < 0.9 * linear(light[-1][0]) - linear(area[-1][0]):  # in the shadow of a quad
            continue
        wanted = irradiance(at, 12) / math.sqrt(0.5)
        ratios.append(here / sun / wanted)
        sums = [sums[0] + here / sun, sums[1] + wanted]
    assert len(ratios) > 100 and 0.9 < min(ratios) and max(ratios) < 1.1 and sums[0] == pytest.approx(sums[1], rel=0.02), (len(ratios), min(ratios), max(ratios), sums)


def test_it_is_seen(lit):
    """From its front it is bright, from behind as dark as without light."""
    def middle(eye, *options):
        _, _, folder = lit("--eye", f"0,{eye},0.01", "--target", "0,4,0", "--fov", 20, *options, pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 1]})
        return list(read_png((folder / "out.png").read_bytes())[2][24][96:99])

    red, green, blue = middle(2)
    assert red > green > blue > 100 and middle(2, "--area", 0) == middle(6) == [0, 0, 0]


def test_plan(lit):
    """Lamps are shared out by power; what all that is seen is behind has none, nor what is fainter than those that have all."""
    both = RADIANCE, [0.01, 0.01, 0.01]
    for vpls, shares, results in ((20, [19, 1], ["drawn", "drawn"]), (1, [1, 0], ["drawn", "faint"])):
        _, found, _ = lit(*CAMERA, "--area", vpls, colours=both)
        assert [light["vpls"] for light in found["area"]["lights"]] == shares and [light["cull_result"] for light in found["area"]["lights"]] == results
    said, found, _ = lit("--eye", "0,9,0", "--target", "0,20,0", "--verbose", colours=both)
    assert found["frames"][0]["area_lights"] == {"drawn": 0, "faint": 0, "behind": 2} and found["area"]["vpls"] == 0
    assert said.startswith("area         2 parallelograms of light: 0 drawn by 0 VPLs, 2 behind all that is seen\n")
    assert "area light quad 1 is left out: behind all that is seen\n" in said


def test_points_of_the_asset(vxs, lit, tmp_path):
    """A file may have the points: light that comes by them is as that by points of the scene. The reports say how many, and what they take."""
    _, found, folder = lit(*CAMERA, "--area", 16, "--passes", tmp_path / "scene")
    vxs("bake", folder / "level.gltf", "-o", tmp_path / "points.vxs", "--resolution", 64, "--points", 50000, "--json", tmp_path / "bake.json")
    told = json.loads((tmp_path / "bake.json").read_text())
    jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "bake-report.schema.json").read_text())).validate(told)
    vxs("info", tmp_path / "points.vxs", "--json", tmp_path / "info.json")
    held = json.loads((tmp_path / "info.json").read_text())
    jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "info.schema.json").read_text())).validate(held)
    section = [s for s in held["sections"] if s["kind"] == "points"]
    assert [(s["count"], s["stored_bytes"]) for s in section] == [(50000, told["points"]["stored_bytes"])] and told["points"]["count"] == 50000
    assert told["points"]["stored_bytes"] < 3 * 50000 and held["metadata"]["options"]["points"] == 50000
    vxs("render", folder / "level.gltf", tmp_path / "points.vxs", "-o", tmp_path / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1, *CAMERA,
        "--area", 16, "--passes", tmp_path / "asset", "--json", tmp_path / "r.json")
    area = json.loads((tmp_path / "r.json").read_text())["area"]
    assert (area["points"], area["points_of"], found["area"]["points_of"]) == (50000, "asset", "scene")
    there, here = (sum(linear(byte) for row in read_png((tmp_path / name / "area.png").read_bytes())[2] for byte in row) for name in ("scene", "asset"))
    assert here == pytest.approx(there, rel=0.02)
    assert "--points is of a whole asset" in vxs("bake", folder / "level.gltf", "-o", tmp_path / "a.part", "--part", "1/2", "--points", 9, status=2).stderr


def forge_points(path, to, times=1, count=None):
    """A copy of an asset each of whose points is there so many times; or that has so many in one place."""
    asset = damage.Asset(path)
    content = asset.contents["PNTS", damage.NONE, 0]
    head, found = content[:40], struct.unpack_from("<I", content, 40)[0]
    planes = [content[44 + k * found:44 + (k + 1) * found] for k in range(6)]
    spread = [bytes(b for byte in plane for b in (byte, *bytes(times - 1))) for plane in planes] if count is None else [bytes(count)] * 6
    asset.contents["PNTS", damage.NONE, 0] = head + struct.pack("<I", len(spread[0])) + b"".join(spread)
    return asset.write(to)


def test_points_in_one_place(vxs, lit, tmp_path):
    """A file of a few kilobytes may hold millions of points in one place, each as wide as a room: of each place one is drawn. True files are as they are."""
    folder = lit(*CAMERA, "--area", 1)[2]
    true = tmp_path / "true.vxs"
    vxs("bake", folder / "level.gltf", "-o", true, "--resolution", 64, "--points", 500)

    def draw(asset):
        started = time.monotonic()
        done = vxs("render", folder / "level.gltf", asset, "-o", tmp_path / "out.png", "--width", 32, "--height", 24, *CAMERA, "--area", 8, "--json", tmp_path / "r.json")
        return (tmp_path / "out.png").read_bytes(), json.loads((tmp_path / "r.json").read_text())["area"]["points"], done.stderr, time.monotonic() - started

    picture, points, said, _ = draw(true)
    assert points == 500 and not said
    assert draw(forge_points(true, tmp_path / "twice.vxs", times=2))[1:3] == (1000, "")
    again, points, said, _ = draw(forge_points(true, tmp_path / "often.vxs", times=8))
    assert 490 <= points <= 500 and said == (f"vxs: warning: {4000 - points} of 4000 points of the file lie within a quarter of their width of others: "
                                             f"{points} are drawn\n")
    was, now = ([linear(c) for row in pixels for c in row] for pixels in (read_png(picture)[2], read_png(again)[2]))
    assert sum(abs(a - b) for a, b in zip(was, now)) < 0.01 * sum(was)
    many = forge_points(true, tmp_path / "many.vxs", count=1 << 22)
    _, points, said, seconds = draw(many)
    assert many.stat().st_size < 20000 and points == 1 and "4194303 of 4194304 points" in said and seconds < 30


def test_points_of_strangers(vxs, cases, tmp_path):
    folder = cases / "hostile" / "07-points-that-hang-render"
    for options in ((), ("--area", 256), ("--sky", folder / "sky.hdr", "--area", 4)):
        started = time.monotonic()
        vxs("render", folder / "rs.glb", folder / "pts.vxs", "-o", tmp_path / "o.png", "--width", 64, "--height", 36, *options)
        assert time.monotonic() - started < 60


@pytest.mark.long
def test_what_moves_casts(lit, tmp_path):
    """A block before the light darkens the floor as if it stood there, in each frame where it is then."""
    block, beyond = (((x - 0.4, 0.9, -0.4), (x + 0.4, 1.5, 0.4)) for x in (-0.7, 0.7))
    small_scene.write(tmp_path / "block.gltf", boxes=[block], lights=[])
    (tmp_path / "path.txt").write_text(2 * "0.01 3.5 0 0 0 0\n")
    look = "--area", 64, "--area-gather", "each", "--fov", 60, "--passes", tmp_path / "passes", "--path", tmp_path / "path.txt", "--frames", 2

    def floor(*options, boxes=()):
        """Irradiance of all that is seen, of the brightest; and of how many points."""
        _, found, _ = lit(*look, *options, boxes=boxes)
        light = [linear(c) for row in read_png((tmp_path / "passes" / "area.png").read_bytes())[2] for c in row[::3]]
        return [c / max(light) for c in light], found["area"]["points"]

    def apart(a, b):
        return sum(abs(x - y) for x, y in zip(a, b)) / len(a)

    clear, few = floor()
    for options, place in (((), block), (("--moving-by", "1.4,0,0"), beyond)):
        found, more = floor("--moving", tmp_path / "block.gltf", *options)
        there, _ = floor(boxes=[place])
        assert more > few and apart(found, there) < 0.25 * apart(clear, there), (apart(found, there), apart(clear, there))


def test_off_and_none(lit):
    said, found, _ = lit(*CAMERA, "--area", 0)
    assert said == "" and "area" not in found
    said, found, _ = lit(*CAMERA, "--area", 64, colours=([0, 0, 0], [0, 0, 0]))
    assert said == "area         0 parallelograms of light: nothing in the scene shines; --sky FILE lights it by a map of the sky\n" and found["area"]["lights"] == [] and "area" not in found["median_ms"]


def test_airlight(lit, tmp_path):
    """Fog has the colour of what shines in it, the more the stronger it is."""
    shares = []
    for strength in (0, 10, 40):
        lit("--eye", "6,2,0", "--target", "0,2,0", "--fog", 0.1, "--area", 16, "--exposure", -2, "--passes", tmp_path,
            extensions={"KHR_materials_emissive_strength": {"emissiveStrength": strength}})
        rows = read_png((tmp_path / "airlight.png").read_bytes())[2]
        red, _, blue = (sum(linear(byte) for row in rows for byte in row[n::3]) for n in range(3))
        shares.append(red / blue)
    assert shares[0] == pytest.approx(1, abs=0.02) and shares[2] > 1.1 * shares[1] > 1.2 * shares[0] and shares[2] < 4


@pytest.mark.parametrize("options, words", [
    (["--area", 0, "--area-gather", "each"], "--area-gather needs area lights"),
    (["--draw", "rays", "--area", 9], "--draw rays goes without --area"),
    (["--area", 257], "--area"),
])
def test_refused(vxs, tmp_path, options, words):
    assert words in vxs("render", tmp_path / "a.gltf", tmp_path / "a.vxs", "-o", tmp_path / "a.png", *options, status=2).stderr


def test_screen(vxs, tmp_path):
    """A room with a screen has its triangles and two more boxes' worth, and a material that shines."""
    for name, options in (("with", ["--screen"]), ("again", ["--screen"]), ("without", [])):
        vxs("scene", "room", "-o", tmp_path / f"{name}.glb", "--triangles", 2000, *options)
    glb = (tmp_path / "with.glb").read_bytes()
    assert glb == (tmp_path / "again.glb").read_bytes() != (tmp_path / "without.glb").read_bytes()
    assert b'"emissiveFactor":[1.0,1.0,1.0],"emissiveTexture":{"index":0}' in glb
    assert "applies to room only" in vxs("scene", "city", "-o", tmp_path / "city.glb", "--screen", status=2).stderr
