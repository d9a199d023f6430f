# vxs render --linear: the picture and its passes as floats, beside what a screen shows of them, whose 8 bits are dithered.
# SPDX-License-Identifier: GPL-3.0-or-later
import math
import shutil
import subprocess

import pytest

import small_scene
from exr import read_exr, white
from png import read_png

SMALL = "--width", 64, "--height", 48
CAMERA = *SMALL, "--eye", "7,6,9", "--target", "0,2,0", "--fov", 50


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("linear")
    small_scene.write(folder / "level.gltf", lights=small_scene.EACH_KIND, pbrMetallicRoughness={"baseColorFactor": [0.9, 0.5, 0.2, 1]})
    vxs("bake", folder / "level.gltf", "-o", folder / "level.vxs", "--resolution", 128)
    return folder


@pytest.fixture(scope="module")
def draw(vxs, level):
    """The rows of the PNG, and what the EXR has."""
    def run(*options, camera=CAMERA):
        vxs("render", level / "level.gltf", level / "level.vxs", "-o", level / "out.png", "--linear", level / "out.exr", *camera, *options)
        return read_png((level / "out.png").read_bytes()), read_exr((level / "out.exr").read_bytes())

    return run


def curve(x):
    return 12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055


def shown(x):
    """What a screen shows of linear light: a soft shoulder, then the curve of sRGB."""
    return curve(x if x < 0.6 else 0.6 + 0.4 * (1 - math.exp(-(x - 0.6) / 0.4)))


def check_pictures(png, exr, of_value, channels="RGB", off=1.001):
    """The PNG is what is shown of the floats, to a step of its 8 bits: at the same places, in the same channels."""
    width, height, rows = png
    assert exr[:2] == (width, height)
    for y in range(height):
        for x in range(width):
            for n in range(3):
                wanted = of_value(exr[2][channels[n]][y][x])
                assert abs(rows[y][3 * x + n] - 255 * min(max(wanted, 0), 1)) <= off, (x, y, n)


@pytest.mark.parametrize("options", [("--samples", 1), ("--samples", 1, "--fog", 0.05), ("--draw", "rays")], ids=["gl", "fog", "rays"])
def test_picture(draw, options):
    """As a screen shows it, from the top row down."""
    if "rays" in options:  # the mean of 2 x 2 rays is linear there
        check_pictures(*draw(*options), shown)
        return
    png, exr = draw(*options)
    check_pictures(png, exr, shown)
    assert white(exr[3]) > 0


def test_same_bytes(draw, level):
    draw("--fog", 0.05)
    first = [(level / name).read_bytes() for name in ("out.png", "out.exr")]
    draw("--fog", 0.05, "--threads", 1)
    assert first == [(level / name).read_bytes() for name in ("out.png", "out.exr")]


def test_white(draw, level):
    """A value is cd/m2 over the answer of the file is white: a floor of albedo .9 in the light of a sun of 1 lux sends back .9 cos / pi."""
    png, exr = draw("--samples", 1, "--light", "noon", "--passes", level / "passes")
    light, normal, depth = (read_exr((level / "passes" / f"{name}.exr").read_bytes())[2] for name in ("light", "normal", "depth"))
    sun = [-c / math.sqrt(0.2 ** 2 + 1 + 0.1 ** 2) for c in (0.2, -1, 0.1)]
    lit = read_exr(next((level / "passes").glob("lit-0-*.exr")).read_bytes())[2]["Y"]
    asked = 0
    for y in range(48):
        for x in range(64):
            if not depth["Z"][y][x] > 0 or lit[y][x] < 1:
                continue
            facing = sum(normal[c][y][x] * s for c, s in zip("XYZ", sun))
            if facing > 0.1:
                asked += 1
                assert light["R"][y][x] * white(exr[3]) * math.pi == pytest.approx(facing, rel=1e-3)
    assert asked > 500


def way(x, y):
    """From the eye of CAMERA along the axis by 1, to what a sample is seen at."""
    eye, target = (7, 6, 9), (0, 2, 0)
    ahead = [b - a for a, b in zip(eye, target)]
    ahead = [c / math.hypot(*ahead) for c in ahead]
    right = [-ahead[2] / math.hypot(ahead[0], ahead[2]), 0, ahead[0] / math.hypot(ahead[0], ahead[2])]
    up = [right[1] * ahead[2] - right[2] * ahead[1], right[2] * ahead[0] - right[0] * ahead[2], right[0] * ahead[1] - right[1] * ahead[0]]
    high = math.tan(math.radians(25))
    across, rise = (2 * (x + 0.5) / 64 - 1) * high * 64 / 48, (1 - 2 * (y + 0.5) / 48) * high
    return eye, [a + across * r + rise * u for a, r, u in zip(ahead, right, up)]


@pytest.mark.parametrize("light, top", [("lamp", None), ("lamp", 2.5), ("noon", None), ("noon", 2.5)])
def test_fog_dims_surfaces(draw, level, light, top):
    """What of a light's way to a surface lies in fog dims it, and exposure stays: a lamp's from the lamp or the fog's top, a sun's from the top."""
    dense, lights = 0.15, []
    for fog in ((), ("--fog", dense, *(("--fog-top", top) if top else ()))):
        draw("--samples", 1, "--light", light, "--passes", level / "dim", *fog)
        lights.append(read_exr((level / "dim" / "light.exr").read_bytes())[2]["G"])
    depth, asked, least = read_exr((level / "dim" / "depth.exr").read_bytes())[2]["Z"], 0, 1
    for y in range(48):
        for x in range(64):
            if not lights[0][y][x] > 0:
                continue
            eye, along = way(x, y)
            place = [e + depth[y][x] * a for e, a in zip(eye, along)]
            below = max((top or 1e9) - place[1], 0)
            if light == "noon":
                metres = below / (1 / math.sqrt(0.2 ** 2 + 1 + 0.1 ** 2)) if top else 0
            else:
                metres = math.dist(place, (0, 6, 0)) * min(1, below / (6 - place[1]) if place[1] < 6 else 1)
            assert lights[1][y][x] / lights[0][y][x] == pytest.approx(math.exp(-dense * metres), rel=2e-3), (x, y)
            least = min(least, math.exp(-dense * metres))
            asked += 1
    assert asked > 400 and (least < 0.7 or light == "noon" and not top)


def test_passes(draw, level):
    """Each pass that has floats has them beside its PNG, which shows them."""
    draw("--samples", 1, "--fog", 0.05, "--fog-by", "grid", "--passes", level / "all")
    names = {path.stem for path in (level / "all").glob("*.png")}
    assert names == {path.stem for path in (level / "all").glob("*.exr")} and {"airlight", "transmittance", "shadow-grid", "truth", "difference"} <= names
    pictures = {name: (read_png((level / "all" / f"{name}.png").read_bytes()), read_exr((level / "all" / f"{name}.exr").read_bytes())) for name in names}
    for name, (png, exr) in pictures.items():
        channels = {"normal": ["X", "Y", "Z"], "depth": ["Z"]}.get(name, ["B", "G", "R"] if name in ("albedo", "light", "airlight", "transmittance") else ["Y"])
        assert list(exr[2]) == channels, name
    light, exact = lambda x: curve(min(x, 1)), 0.51
    check_pictures(*pictures["albedo"], light, off=exact)
    check_pictures(*pictures["light"], light, off=exact)
    check_pictures(*pictures["airlight"], light, off=exact)
    check_pictures(*pictures["transmittance"], lambda x: x, off=exact)
    check_pictures(*pictures["shadow-grid"], lambda x: x, "YYY", off=exact)
    depths = pictures["depth"][1][2]["Z"]
    assert max(map(max, depths)) > 10 > 9 > min(d for row in depths for d in row if d) and any(0 in row for row in depths)
    for y, row in enumerate(pictures["normal"][1][2]["Y"]):
        for x, up in enumerate(row):
            assert pictures["normal"][0][2][y][3 * x + 1] == pytest.approx(255 * (0.5 + 0.5 * up) if depths[y][x] else 0, abs=exact)
    lit = next(name for name in names if name.startswith("lit-1"))
    for y, row in enumerate(pictures[lit][1][2]["Y"]):
        for x, value in enumerate(row):
            red, green = pictures[lit][0][2][y][3 * x:3 * x + 2]
            assert (red, green) == (255, 0) if value < 0 else red == green == pytest.approx(255 * value, abs=exact)


def test_passes_without(vxs, level):
    """Without --linear passes are PNGs."""
    vxs("render", level / "level.gltf", level / "level.vxs", "-o", level / "out.png", *CAMERA, "--passes", level / "png")
    assert not list((level / "png").glob("*.exr"))


@pytest.mark.skipif(not shutil.which("exrheader"), reason="exrheader of the package openexr is not installed")
def test_header(draw, level):
    draw("--samples", 1)
    said = subprocess.run(["exrheader", level / "out.exr"], capture_output=True, text=True, check=True).stdout
    assert "dataWindow (type box2i): (0 0) - (63 47)" in said and "R, 32-bit floating-point" in said and "whiteLuminance" in said


def test_standard_output_and_names(vxs, level):
    """- is standard output; a name of another kind of file is refused."""
    where = "render", level / "level.gltf", level / "level.vxs", "-o", level / "out.png", *CAMERA
    assert "is the extension of other files" in vxs(*where, "--linear", level / "out.vxs", status=2).stderr
    assert "--linear" in vxs(*where, "--linear", level / "out.png", status=2).stderr


def test_dither(draw):
    """A dark gradient of fog has no bands: what a few pixels show in the mean is what is there, where rounding is off by up to half a step."""
    png, exr = draw("--samples", 1, "--light", "lamp", "--fog", 0.06, "--exposure", -8, camera=(*SMALL, "--eye", "7,4,9", "--target", "0,6,0", "--fov", 30))
    side, worst, banded = 8, 0, 0
    for top in range(0, 48, side):
        for left in range(0, 64, side):
            for n, channel in enumerate("RGB"):
                there = [255 * shown(exr[2][channel][y][x]) for y in range(top, top + side) for x in range(left, left + side)]
                seen = [png[2][y][3 * x + n] for y in range(top, top + side) for x in range(left, left + side)]
                if max(there) - min(there) > 1.5:
                    continue
                worst = max(worst, abs(sum(seen) - sum(there)) / side ** 2)
                banded = max(banded, abs(sum(map(round, there)) - sum(there)) / side ** 2)
    assert banded > 0.3  # what 8 bits alone would do
    assert worst < 0.1
