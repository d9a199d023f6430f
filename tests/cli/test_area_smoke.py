# vxs render: smoke between area lights and what they light, and between that and the eye.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math

import jsonschema
import pytest

import small_scene
from conftest import EVERY, ROOT
from png import read_png
from test_area import ABOVE, CAMERA, RADIANCE, SIZE, SLOPE, add_quads, linear
from test_render_smoke import add_balls, left_between, unit
from test_smoke_bake import nrrd

# places, radii, extinctions: below the light, and above it, where it does not shine
BALLS = [((0.5, 2, 0), 0.6, 1.5), ((-0.8, 1, 0.4), 0.5, 2), ((0.2, 3, -0.6), 0.3, 1)]
BEHIND = [((0, 5, 0), 0.6, 9)]
SUN = [("sun", "directional", (1, -1, 0))]
AT = "its folder"  # among options


@pytest.fixture(scope="module")
def drawn(vxs, tmp_path_factory):
    """draw(*options, balls): what vxs says, its report, and its folder; of a floor below ABOVE, which shines, and a sun."""
    folder = tmp_path_factory.mktemp("area_smoke")
    scene, asset = folder / "level.gltf", folder / "level.vxs"
    clear = small_scene.write(folder / "clear.gltf", boxes=[small_scene.GROUND], lights=SUN)
    vxs("bake", clear, "-o", asset, "--resolution", 256)

    def draw(*options, balls=BALLS, strength=1, of=asset):
        small_scene.write(scene, boxes=[small_scene.GROUND], lights=SUN)
        add_quads(scene, [(*ABOVE, RADIANCE)], extensions={"KHR_materials_emissive_strength": {"emissiveStrength": strength}})
        if balls:
            add_balls(scene, balls, scene)
        said = vxs("render", scene, of, "-o", folder / "out.png", "--width", SIZE[0], "--height", SIZE[1], "--samples", 1, "--area-gather", "each",
                   "--json", folder / "r.json", "--force", *(folder if option == AT else option for option in options)).stdout
        found = json.loads((folder / "r.json").read_text())
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
        return said, found, folder

    return draw


def reds(path):
    """Linear, row by row."""
    return [linear(c) for row in read_png(path.read_bytes())[2] for c in row[::3]]


def irradiance(place, dims, steps=12):
    """What a floor gets of ABOVE: each piece by both cosines and the square of how far away it is, and what balls leave."""
    total = 0
    for i in range(steps):
        for k in range(steps):
            at = [c + (i + 0.5) / steps * a + (k + 0.5) / steps * b for c, a, b in zip(*ABOVE)]
            way = [q - p for p, q in zip(place, at)]
            square = sum(w * w for w in way)
            total += way[1] ** 2 / square ** 2 * (left_between(place, unit(way), math.sqrt(square), BALLS) if dims else 1)
    return total


def test_surfaces(drawn):
    """Each place of the floor gets of each piece of the light what smoke leaves. Exposures are distinguished by the sum of all."""
    clear, dimmed, wanted = [], [], []
    step = 6 if EVERY else 12
    pixels = [(x, y) for x in range(2, SIZE[0], step) for y in range(2, SIZE[1], step)]
    for options, to in ((("--smoke", "off"), clear), ((), dimmed)):
        light = reds(drawn(*CAMERA, "--area", 64, "--exposure", -0.5, "--passes", AT, *options)[2] / "area.png")
        to += [light[y * SIZE[0] + x] for x, y in pixels]
    for x, y in pixels:
        place = [SLOPE * (2 * x + 1 - SIZE[0]), 0, SLOPE * (2 * y + 1 - SIZE[1])]
        wanted.append(irradiance(place, True) / irradiance(place, False))
    found = [d / c for d, c in zip(dimmed, clear)]
    scale = sum(wanted) / sum(found)
    rms = math.sqrt(sum((scale * f - w) ** 2 for f, w in zip(found, wanted)) / len(wanted))
    assert min(wanted) < 0.5 and max(wanted) > 0.95 and rms < 0.02, (rms, min(wanted), max(wanted))


def test_plan(drawn):
    """It says how much smoke dims; what no light shines on is left out, and where nothing is left or smoke is off, all is as without."""
    said, found, _ = drawn(*CAMERA, "--area", 4, "--verbose", balls=BALLS + BEHIND)
    assert "1 drawn by 4 VPLs that 3 capsules of smoke dim\n" in said and "smoke by 64 x 64 curves for each VPL\n" in said
    assert found["area"]["smoke"] == {"capsules": 3, "side_px": 64} and not found["area"]["baked_smoke_left_out"]
    assert drawn(*CAMERA, "--area", 4, "--smoke-side", 32)[1]["area"]["smoke"]["side_px"] == 32
    areas = []
    for options, balls in (((), BEHIND), (("--smoke", "off"), BALLS), ((), [])):
        said, found, folder = drawn(*CAMERA, "--area", 4, "--exposure", -0.5, "--passes", AT, *options, balls=balls)
        assert "VPLs\n" in said and "smoke" not in found["area"]
        areas.append((folder / "area.png").read_bytes())
    assert areas[1] == areas[2]


@pytest.mark.long
def test_baked_smoke_is_left_out(vxs, drawn, tmp_path):
    """What is baked of a grid is of the file's own lights: the plan reports it."""
    small_scene.write(tmp_path / "clear.gltf", boxes=[small_scene.GROUND], lights=SUN)
    vxs("bake", tmp_path / "clear.gltf", "-o", tmp_path / "smoky.vxs", "--resolution", 256, "--smoke", nrrd(tmp_path / "slab.nrrd"))
    said, found, _ = drawn(*CAMERA, "--area", 4, "--verbose", balls=[], of=tmp_path / "smoky.vxs")
    assert found["area"]["baked_smoke_left_out"] and "baked smoke is left out: the file has it for its own lights alone\n" in said


# nothing but air below the light, so that exposure alone is tested
AIR = "--eye", "6,1,0", "--target", "0,2.2,0", "--fov", 20, "--fog", 0.1, "--area", 16


def test_air(drawn):
    """Airlight below smoke is less, too."""
    dimmed, clear = (sum(reds(drawn(*AIR, "--exposure", -6, "--smoke", smoke, "--passes", AT, balls=[((0, 3.2, 0), 0.7, 2)], strength=400)[2] / "airlight.png")) for smoke in ("on", "off"))
    assert 0.5 * clear < dimmed < 0.9 * clear, (dimmed, clear)


@pytest.mark.long
def test_smoke_hides_the_air_behind_it(drawn):
    """That of area lights as that of all lights: a dense ball before the eye, on which they do not shine, has the air before it alone."""
    middle = SIZE[0] * SIZE[1] // 2 + SIZE[0] // 2
    near, none = (reds(drawn(*AIR, "--exposure", -9, balls=balls, strength=6000)[2] / "out.png")[middle] for balls in ([((5, 1.2, 0), 0.3, 30)], []))
    assert none > 0.05 and near < 0.3 * none, (near, none)
