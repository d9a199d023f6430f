# vxs render under a map of the sky: how much light, from where, what shadows it, how it is seen, messages about it, and files that
# are no such map.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import struct
import zlib

import jsonschema
import pytest

import skies
import small_scene
from conftest import ROOT
from png import read_png
from test_area import add_quads
from test_render_smoke import add_balls, left_between

SIZE = 32, 24
SUN = -1, -1, 0  # of the file, 1 lux
ABOVE = "--eye", "0,3,0.01", "--target", "0,0,0", "--fov", 60
SLOPE = 3 * math.tan(math.radians(30)) / SIZE[1]  # of the floor, half a pixel of ABOVE
HOUSE = (0.6, 0, -4), (2.6, 1.5, 4)  # it hides the sun of skies.evening from the floor before it
BLOCK = (-1, 0, -1), (1, 2, 1)
SKY = skies.Sky(16, skies.evening)
SOFT = skies.Sky(8, lambda way: [c * (1.05 + sum(a * b for a, b in zip(way, skies.SUN))) ** 2 for c in (0.5, 1, 2)])  # brightest about the same place


def linear(byte):
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def floor_at(x, y):
    """What a pixel of ABOVE shows."""
    return SLOPE * (2 * x + 1 - SIZE[0]), 0, SLOPE * (2 * y + 1 - SIZE[1])


def is_free(place, boxes):
    """Whether a way from a place meets none of some boxes."""
    def ask(toward):
        for low, high in boxes:
            spans = [sorted(((a - p) / (t or 1e-12), (b - p) / (t or 1e-12))) for a, b, p, t in zip(low, high, place, toward)]
            if max(1e-6, *(begin for begin, _ in spans)) < min(end for _, end in spans):
                return False
        return True
    return ask


def png_of(rows, size=None):
    """An RGB PNG of rows of colours, or one that says to be larger."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    raw = b"".join(b"\0" + bytes(c for colour in row for c in colour) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", *(size or (len(rows[0]), len(rows))), 8, 2, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(raw))
            + chunk(b"IEND", b""))


@pytest.fixture(scope="module")
def under(vxs, tmp_path_factory):
    """render(*options, boxes, sky): what vxs says, its report, and its folder; of a floor, and of boxes that the file does not know."""
    folder = tmp_path_factory.mktemp("sky")
    scene, asset = folder / "level.gltf", folder / "level.vxs"
    SKY.write(folder / "sky.hdr")

    def write(boxes):
        small_scene.write(scene, boxes=[small_scene.GROUND, *boxes], lights=[("sun", "directional", SUN)])

    write(())
    vxs("bake", scene, "-o", asset, "--resolution", 256)

    def render(*options, boxes=(), sky=folder / "sky.hdr"):
        write(boxes)
        said = vxs("render", scene, asset, "-o", folder / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1, "--sky", sky,
                   "--json", folder / "r.json", *options).stdout
        found = json.loads((folder / "r.json").read_text())
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
        return said.partition("wrote  ")[0], found, folder

    return render


@pytest.fixture
def irradiance(under, tmp_path):
    """ask(*options, pixels, boxes, sky): what a sky sends to each pixel, lux, three channels: beside it is the sun's light, at 45 degrees."""
    def ask(*options, pixels, boxes=(), sky=SKY):
        under("--area-gather", "each", "--sky-light", 0.2, "--exposure", -1, "--passes", tmp_path, *options, boxes=boxes, sky=sky.write(tmp_path / "asked.hdr"))
        sky, light = (read_png((tmp_path / name).read_bytes())[2] for name in ("sky.png", "light.png"))
        found = []
        for x, y in pixels:
            ours = [linear(sky[y][3 * x + n]) for n in range(3)]
            sun = sum(linear(light[y][3 * x + n]) - ours[n] for n in range(3)) / 3 / math.sqrt(0.5)
            found.append([c / sun / 0.2 for c in ours])
        return found
    return ask


def test_light_of_an_open_sky(irradiance):
    """A floor gets the integral of the map over its hemisphere, each channel by itself, and everywhere the same."""
    found = irradiance(*ABOVE, "--area", 128, pixels=[(x, y) for x in range(1, SIZE[0], 5) for y in range(1, SIZE[1], 5)])
    for n, wanted in enumerate(SKY.irradiance((0, 1, 0))):
        mean = sum(light[n] for light in found) / len(found)
        assert mean == pytest.approx(wanted, rel=0.03) and all(light[n] == pytest.approx(mean, rel=0.01) for light in found), (n, mean, wanted)


def test_where_it_comes_from(irradiance):
    """A wall that looks along +X, as the map is turned: what is brightest beside it, behind it. The ground hides what is below."""
    for turn in (100, -140):
        (found,) = irradiance("--eye", "6,1,0", "--target", "0,1,0", "--fov", 9, "--area", 32, "--sky-turn", turn, pixels=[(16, 12)], boxes=[BLOCK], sky=SOFT)
        wanted = SOFT.irradiance((1, 0, 0), is_free((1, 1, 0), [small_scene.GROUND]), turn)
        assert sum(found) == pytest.approx(sum(wanted), abs=2), (turn, found, wanted)


def test_behind_a_house(irradiance):
    """Where the sun of the map is hidden, error falls as VPLs come to be more."""
    pixels = [(x, y) for y in (6, 12, 18) for x in range(2, 18, 3)]
    wanted = [SKY.irradiance((0, 1, 0), is_free(floor_at(x, y), [HOUSE])) for x, y in pixels]
    errors = []
    for vpls in (4, 16, 40):
        found = irradiance(*ABOVE, "--area", vpls, pixels=pixels, boxes=[HOUSE])
        errors.append(math.sqrt(sum((sum(f) - sum(w)) ** 2 for f, w in zip(found, wanted)) / sum(sum(w) ** 2 for w in wanted)))
    assert errors[2] < 0.1 and errors[0] > 2 * errors[1] > 4 * errors[2], errors


def test_it_is_seen(under, tmp_path):
    """A PNG of four colours, the middle between the second and the third: looking along +X the third is on the right; turned by 90 degrees, along -Z."""
    colours = [(200, 40, 40), (40, 200, 40), (40, 40, 200), (200, 200, 40)]
    (tmp_path / "four.png").write_bytes(png_of([[colours[x // 4] for x in range(16)]] * 8))
    for turn, target in ((0, "1,9,0"), (90, "0,9,-1"), (180, "-1,9,0")):
        _, _, folder = under("--eye", "0,9,0", "--target", target, "--fov", 30, "--area", 1, "--sky-turn", turn, sky=tmp_path / "four.png")
        rows = read_png((folder / "out.png").read_bytes())[2]
        left, right = rows[2][6:9], rows[2][-9:-6]
        assert left[1] > 2 * max(left[0], left[2]) and right[2] > 2 * max(right[0], right[1]), (turn, list(left), list(right))


def test_what_moves_casts(irradiance, tmp_path):
    """A block hides as much of the sky from the floor as it should from where it is."""
    block = (-2.1, 0, -4), (-1.4, 1.5, 4)
    small_scene.write(tmp_path / "block.gltf", boxes=[block], lights=[])
    place, turn = (8, 12), 180
    hidden, wanted = 0, 0
    for sign, options, boxes in ((1, (), ()), (-1, ("--moving", tmp_path / "block.gltf"), [block])):
        (found,) = irradiance(*ABOVE, "--area", 64, "--sky-turn", turn, *options, pixels=[place], sky=SOFT)
        hidden += sign * sum(found)
        wanted += sign * sum(SOFT.irradiance((0, 1, 0), is_free(floor_at(*place), boxes), turn))
    assert hidden == pytest.approx(wanted, rel=0.06)


def test_beside_a_quad(vxs, tmp_path):
    """What shines in the scene lights a floor as without a sky; each has as many virtual lights, a pass and a plan of its own."""
    scene, (across, down) = tmp_path / "level.gltf", (11, 14)
    small_scene.write(scene, boxes=[small_scene.GROUND], lights=[("sun", "directional", SUN)])
    add_quads(scene, [((-1, 4, -1), (2, 0, 0), (0, 0, 2), (1, 1, 1))])
    SKY.write(tmp_path / "sky.hdr")
    vxs("bake", scene, "-o", tmp_path / "level.vxs", "--resolution", 64)

    def quad(*options):
        """Its light beside the sun's."""
        vxs("render", scene, tmp_path / "level.vxs", "-o", tmp_path / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1, *ABOVE, "--area", 4,
            "--area-gather", "each", "--exposure", -1, "--passes", tmp_path / "passes", "--json", tmp_path / "r.json", "--force", *options)
        area, sky, light = ([linear(c) for c in read_png(path.read_bytes())[2][down][3 * across:3 * across + 3]] if path.exists() else [0] * 3
                            for path in (tmp_path / "passes" / name for name in ("area.png", "sky.png", "light.png")))
        assert all(c > 0 for c in sky) or not options
        return sum(area) / (sum(light) - sum(area) - sum(sky))

    assert quad() == pytest.approx(quad("--sky", tmp_path / "sky.hdr", "--sky-light", 0.2), rel=0.05)
    found = json.loads((tmp_path / "r.json").read_text())
    assert found["area"]["vpls"] == found["sky"]["vpls"] == 4 and found["median_ms"]["area"] > 0 and found["median_ms"]["sky"] > 0


def test_in_smoke(vxs, tmp_path):
    """A ball of smoke dims the sky's light on the floor below, by each way through it. Exposures are distinguished by the sum of all places."""
    balls, pixels = [((0.3, 1.2, 0), 0.7, 2)], [(x, y) for x in range(1, SIZE[0], 5) for y in range(1, SIZE[1], 5)]
    scene, found = tmp_path / "level.gltf", []
    small_scene.write(scene, boxes=[small_scene.GROUND], lights=[("sun", "directional", SUN)])
    add_balls(scene, balls, scene)
    SOFT.write(tmp_path / "sky.hdr")
    vxs("bake", scene, "-o", tmp_path / "level.vxs", "--resolution", 64)
    for smoke in ("on", "off"):
        said = vxs("render", scene, tmp_path / "level.vxs", "-o", tmp_path / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1, *ABOVE, "--area", 32,
                   "--area-gather", "each", "--exposure", -1, "--passes", tmp_path / smoke, "--sky", tmp_path / "sky.hdr", "--sky-light", 0.2, "--smoke", smoke,
                   "--force").stdout
        assert (" that 1 capsules of smoke dim\n" in said) == (smoke == "on")
        rows = read_png((tmp_path / smoke / "sky.png").read_bytes())[2]
        found.append([linear(rows[y][3 * x + 1]) for x, y in pixels])
    wanted = [SOFT.irradiance((0, 1, 0), lambda toward: left_between(floor_at(x, y), toward, 50, balls))[1] / SOFT.irradiance((0, 1, 0))[1] for x, y in pixels]
    shares = [on / off for on, off in zip(*found)]
    scale = sum(wanted) / sum(shares)
    rms = math.sqrt(sum((scale * s - w) ** 2 for s, w in zip(shares, wanted)) / len(wanted))
    assert min(wanted) < 0.75 and max(wanted) > 0.95 and rms < 0.05, (rms, min(wanted), max(wanted))


def test_in_fog(under, tmp_path):
    """A sky lights fog by its own colour, the more the brighter it is."""
    shares = []
    for light in (1e-3, 0.5, 2):
        skies.Sky(8, lambda way: (0.1, 0.2, 0.8)).write(tmp_path / "blue.hdr")
        under("--eye", "6,2,0", "--target", "0,2,0", "--fog", 0.1, "--area", 8, "--sky-light", light, "--exposure", -2, "--passes", tmp_path,
              sky=tmp_path / "blue.hdr")
        rows = read_png((tmp_path / "airlight.png").read_bytes())[2]
        red, _, blue = (sum(linear(byte) for row in rows for byte in row[n::3]) for n in range(3))
        shares.append(blue / red)
    assert shares[0] == pytest.approx(1, abs=0.03) and shares[2] > 1.2 * shares[1] > 2 * shares[0] and shares[2] < 8, shares


def test_plan(under):
    said, found, folder = under(*ABOVE, "--area", 3, "--sky-light", 0.5, "--sky-turn", -30, "--verbose")
    assert found["sky"] == {"path": str(folder / "sky.hdr"), "width_px": 32, "height_px": 16, "light": 0.5, "turn_degrees": -30, "vpls": 3, "gather": "quarter",
                            "points": 262144, "points_of": "scene", "baked_smoke_left_out": False}
    assert said == (f"sky          {folder}/sky.hdr, 32 x 16 pixels: drawn by 3 VPLs\n"
                    "radiance times 0.5, turned by -30 degrees\nshadows of 262144 points of the scene, pixels gather quarter\n")
    assert found["median_ms"]["sky"] > 0 and "area" not in found


BLACK = skies.head(4, 2) + bytes(32)
NO_MAPS = {
    "missing": (None, "cannot read"),
    "folder": ("folder", "is a folder, expected a picture"),
    "scene": (b'{"asset": {"version": "2.0"}}', "is a glTF scene, expected a picture"),
    "other": (b"v/1\1 an OpenEXR", "is neither a Radiance picture (.hdr) nor a PNG: convert it to .hdr"),
    "empty": (b"", "is neither a Radiance picture (.hdr) nor a PNG"),
    "shape": (skies.head(4, 4) + bytes(64), "has 4 x 4 pixels: expected twice as many across as down"),
    "huge": (skies.head(100000, 50000), "has 100000 x 50000 pixels: expected at most 8192 x 4096: make it smaller"),
    "cut": (BLACK[:-1], "ends in row 2 of 2"),
    "black": (BLACK, "is black: there is no light in it"),
    "infinite": (skies.head(2, 1, ["EXPOSURE=1e-30"]) + bytes([255, 255, 255, 255]) * 2, "its exposure makes pixels infinite"),
    "negative": (skies.head(2, 1, ["EXPOSURE=-2"]) + bytes([255, 255, 255, 128]) * 2, "its exposure is no number above 0"),
    "huge png": (png_of([[(9, 9, 9)] * 4] * 2, (100000, 50000)), "has 100000 x 50000 pixels: expected at most 8192 x 4096: make it smaller"),
    "broken png": (png_of([[(9, 9, 9)] * 4] * 2)[:45], "is a broken PNG"),
}


@pytest.fixture(scope="module")
def refuse(vxs, tmp_path_factory):
    """refuse(out, *options, status): what vxs says of a picture that it does not draw."""
    folder = tmp_path_factory.mktemp("refused")
    small_scene.write(folder / "level.gltf", boxes=[small_scene.GROUND], lights=[("sun", "directional", SUN)])
    vxs("bake", folder / "level.gltf", "-o", folder / "level.vxs", "--resolution", 16)

    def render(out, *options, status):
        return vxs("render", folder / "level.gltf", folder / "level.vxs", "-o", out, "--width", 16, "--height", 16, "--area", 1, *options, status=status).stderr

    return render


@pytest.mark.parametrize("name", NO_MAPS)
def test_no_map(refuse, tmp_path, name):
    """One line, exit status 3, and no picture."""
    data, words = NO_MAPS[name]
    path = tmp_path / "sky.hdr"
    if data == "folder":
        path.mkdir()
    elif data is not None:
        path.write_bytes(data)
    said = refuse(tmp_path / "out.png", "--sky", path, status=3)
    assert words in said and str(path) in said and said.count("\n") == 1 and not (tmp_path / "out.png").exists(), said


def test_too_bright(refuse, tmp_path):
    (tmp_path / "sky.hdr").write_bytes(skies.head(2, 1) + bytes([255, 255, 255, 255]) * 2)
    said = refuse(tmp_path / "out.png", "--sky", tmp_path / "sky.hdr", "--sky-light", 1e9, status=2)
    assert said == "vxs: error: --sky-light makes the sky brighter than any number: expected a smaller one\n"


@pytest.mark.parametrize("options, words", [
    (["--area", 0, "--sky", "a.hdr"], "--sky needs virtual lights: --area 1 or more"),
    (["--draw", "rays", "--sky", "a.hdr"], "--draw rays goes without --sky"),
    (["--sky-light", 2], "--sky-light needs --sky"),
    (["--sky-turn", 2], "--sky-turn needs --sky"),
    (["--sky", "a.hdr", "--sky-light", 0], "--sky-light"),
    (["--sky", "a.hdr", "--sky-turn", "nan"], "--sky-turn"),
])
def test_refused(vxs, tmp_path, options, words):
    assert words in vxs("render", tmp_path / "a.gltf", tmp_path / "a.vxs", "-o", tmp_path / "a.png", *options, status=2).stderr


def test_it_stays(refuse, tmp_path):
    """No output lands on the map, whatever it is called."""
    path, passes, data = tmp_path / "map.png", tmp_path / "passes", png_of([[(9, 9, 9)] * 4] * 2)
    path.write_bytes(data)
    passes.mkdir()
    (passes / "sky.png").symlink_to(path)
    for out, *options in ([path], ["out.png", "--json", path], ["out.png", "--passes", passes], ["out.png", "--sky", passes / "sky.png", "--passes", passes]):
        said = refuse(tmp_path / out, *([] if "--sky" in options else ["--sky", path]), *options, status=2)
        assert "is the input itself, --sky" in said and path.read_bytes() == data, said
