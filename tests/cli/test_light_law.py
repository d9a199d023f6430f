# One law of light for surfaces and for the air: pictures against closed forms and a quadrature that are written here. By OpenGL,
# with each technique of fog, and by rays; lamps with a range, a spot light, a sun, thin fog and fog of which a ray shows less than
# a metre.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import os
import re
import subprocess
import sys

import pytest

import small_scene
from conftest import ROOT
from exr import read_exr, white

WIDTH, HEIGHT, FOV = 32, 24, 60
LAMP, EYE, TARGET = (0, 6, 0), (1, 4, 9), (0, 2, 0)
RANGE, OUTER = 7, 0.7
# what each light is: range and half of its cone, 0: none
LIGHTS = {"near": (RANGE, 0), "far": (0, 0), "spot": (RANGE, OUTER), "noon": None, "hidden": (0.6, 0)}
AIR = "--fog-albedo", 1, "--fog-anisotropy", 0


def window(r, end):
    return max(0, 1 - (r / end) ** 4) if end else 1


def rim(cosine, outer):
    """As KHR_lights_punctual has it, of a cone that fades in the last tenth of its angle."""
    return min(max((cosine - math.cos(outer)) / (math.cos(0.9 * outer) - math.cos(outer)), 0), 1) ** 2 if outer else 1


def ways(turn=0.5, lift=0.5):
    """{pixel: unit vector from the eye through it}."""
    ahead = [b - a for a, b in zip(EYE, TARGET)]
    ahead = [c / math.hypot(*ahead) for c in ahead]
    level = math.hypot(ahead[0], ahead[2])
    right = [-ahead[2] / level, 0, ahead[0] / level]
    up = [right[1] * ahead[2] - right[2] * ahead[1], right[2] * ahead[0] - right[0] * ahead[2], right[0] * ahead[1] - right[1] * ahead[0]]
    high, found = math.tan(math.radians(FOV / 2)), {}
    for y in range(HEIGHT):
        for x in range(WIDTH):
            across, rise = (2 * (x + turn) / WIDTH - 1) * high * WIDTH / HEIGHT, (1 - 2 * (y + lift) / HEIGHT) * high
            way = [a + across * r + rise * u for a, r, u in zip(ahead, right, up)]
            found[x, y] = [c / math.hypot(*way) for c in way]
    return found


def on_ground(way):
    """How far away a ray meets the ground's upper side; None where it does not."""
    metres = -EYE[1] / way[1] if way[1] < 0 else math.inf
    return metres if all(abs(EYE[n] + metres * way[n]) < 7.9 for n in (0, 2)) else None


def irradiance(light, way, metres, dense):
    """Of the ground, for an intensity (a sun: an irradiance) of 1."""
    if light == "noon":
        return 1
    end, outer = LIGHTS[light]
    down = [e + metres * w - p for e, w, p in zip(EYE, way, LAMP)]
    r = math.hypot(*down)
    return -down[1] / r ** 3 * window(r, end) * rim(-down[1] / r, outer) * math.exp(-dense * r)


def airlight(light, way, metres, dense, nodes=300):
    """All of the ray is lit. Of lamps the middles of equal angles that the lamp sees."""
    if light == "noon":
        return (1 - math.exp(-dense * metres)) / (4 * math.pi)
    (end, outer), total = LIGHTS[light], 0
    to_lamp = [p - e for e, p in zip(EYE, LAMP)]
    along = sum(a * b for a, b in zip(to_lamp, way))
    beside = math.sqrt(sum(c * c for c in to_lamp) - along * along)
    low, high = math.atan(-along / beside), math.atan((metres - along) / beside)
    step = (high - low) / nodes
    for n in range(nodes):
        angle = low + (n + 0.5) * step
        x, r = along + beside * math.tan(angle), beside / math.cos(angle)
        total += window(r, end) * rim((LAMP[1] - EYE[1] - x * way[1]) / r, outer) * math.exp(-dense * (x + r)) * step
    return dense / (4 * math.pi * beside) * total


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("law")
    kinds = {name: "directional" if name == "noon" else "spot" if name == "spot" else "point" for name in LIGHTS}
    path = small_scene.write(folder / "level.gltf", boxes=[small_scene.GROUND], lights=[(name, kind, small_scene.NOON) for name, kind in kinds.items()])
    scene = json.loads(path.read_text())
    for light in scene["extensions"]["KHR_lights_punctual"]["lights"]:
        end, outer = LIGHTS[light["name"]] or (0, 0)
        light |= ({"range": end} if end else {}) | ({"spot": {"innerConeAngle": 0.9 * outer, "outerConeAngle": outer}} if outer else {})
    scene["nodes"][-1]["translation"] = [0, -0.5, 0]  # in the ground: what is seen without light
    path.write_text(json.dumps(scene))
    vxs("bake", path, "-o", folder / "level.vxs", "--resolution", 512)
    return folder


@pytest.fixture(scope="module")
def draw(vxs, level):
    def run(light, *options):
        """The linear picture's green; by OpenGL also passes, in cd/m2: light that a white surface sends back, and airlight."""
        by_rays, passes = "rays" in options, level / "passes"
        vxs("render", level / "level.gltf", level / "level.vxs", "-o", level / "out.png", "--linear", level / "out.exr", "--force", "--light", light, "--width", WIDTH,
            "--height", HEIGHT, "--eye", ",".join(map(str, EYE)), "--target", ",".join(map(str, TARGET)), "--fov", FOV, *AIR, *options,
            *(() if by_rays else ("--samples", 1, "--passes", passes)))
        _, _, channels, header = read_exr((level / "out.exr").read_bytes())
        if by_rays:
            return channels["G"]
        parts = [read_exr((passes / f"{name}.exr").read_bytes())[2]["G"] for name in ("light", "airlight")]
        return [[[white(header) * value for value in row] for row in part] for part in parts]

    return run


def off(pairs):
    """Relative RMS of [(found, wanted)]."""
    assert len(pairs) > 100
    return math.sqrt(sum((a - b) ** 2 for a, b in pairs) / sum(b * b for _, b in pairs))


@pytest.mark.parametrize("light", ["near", "far", "spot", "noon"])
def test_surfaces_and_air(draw, light):
    """Surfaces by a closed form; airlight by exact intervals, which end up to a voxel above the ground: without a range voxels are deeper."""
    dense, seen = 0.05, {p: (w, on_ground(w)) for p, w in ways().items() if on_ground(w)}
    surfaces, air = draw(light, "--fog", dense)
    assert off([(math.pi * surfaces[y][x], irradiance(light, w, m, dense)) for (x, y), (w, m) in seen.items()]) < 1e-5
    found = [(air[y][x], airlight(light, w, m, dense)) for (x, y), (w, m) in seen.items()]
    assert off(found) < (4e-3 if light == "far" else 2e-4)
    if light == "near":  # without its window the lamp would be another
        assert off([(a, airlight("far", w, m, dense)) for (a, _), (w, m) in zip(found, seen.values())]) > 0.5


@pytest.mark.parametrize("light, dense", [("near", 1), ("noon", 10)])
@pytest.mark.parametrize("by, most", [("march", 3e-3), ("angles", 3e-3), ("intervals", 2e-4), ("grid", 1e-3), ("mesh", 2e-4)])
def test_dense_fog(draw, by, most, light, dense):
    """Of fog of which a ray shows its first metre, or the first decimetre, 64 steps lose nothing."""
    _, air = draw(light, "--fog", dense, "--fog-by", by)
    seen = {p: (w, on_ground(w)) for p, w in ways().items() if on_ground(w)}
    assert off([(air[y][x], airlight(light, w, m, dense)) for (x, y), (w, m) in seen.items()]) < most


@pytest.mark.parametrize("light", ["near", "spot"])
def test_rays(draw, light):
    """--draw rays has its own colours of lamps and surfaces; what it draws of a lamp in fog is one number times what the law says. Light from the sky is the same without the lamp."""
    dense, albedo = 0.05, 0.62
    with_it, without = (draw(name, "--fog", dense, "--draw", "rays") for name in (light, "hidden"))
    places, pairs = [ways(turn, lift) for turn in (0.25, 0.75) for lift in (0.25, 0.75)], []
    for x, y in places[0]:
        rays = [(w[x, y], on_ground(w[x, y])) for w in places]
        if (x + y) % 3 or not all(m for _, m in rays):
            continue
        wanted = sum(albedo / math.pi * irradiance(light, w, m, dense) * math.exp(-dense * m) + airlight(light, w, m, dense, 100) for w, m in rays) / 4
        pairs.append((with_it[y][x] - without[y][x], wanted))
    scale = sum(a * b for a, b in pairs) / sum(b * b for _, b in pairs)
    assert scale > 0 and off([(a / scale, b) for a, b in pairs]) < 3e-4


def test_case_of_ranges(vxs, cases, tmp_path):
    """A lamp of 50 cd at 3 m over a floor of 40 m, with a range of 5 m and of 500 m (light/rng.py)."""
    subprocess.run([sys.executable, cases / "light" / "rng.py"], cwd=tmp_path, check=True)
    camera = "--eye", "0,4,12", "--target", "0,1,0", "--fov", 50, "--width", 48, "--height", 36, "--samples", 1, "--fog", 0.02, "--passes", tmp_path / "passes"
    for name, end in ("rng", 5), ("rng0", 500):
        scene, asset = tmp_path / f"{name}.gltf", tmp_path / f"{name}.vxs"
        vxs("bake", scene, "-o", asset, "--resolution", 256)
        vxs("render", scene, asset, "-o", tmp_path / "a.png", "--linear", tmp_path / "a.exr", "--force", *camera)
        lit, depth = (read_exr((tmp_path / "passes" / f"{part}.exr").read_bytes())[2][channel] for part, channel in (("light", "G"), ("depth", "Z")))
        scale, middle = white(read_exr((tmp_path / "a.exr").read_bytes())[3]), 24
        asked = 0
        for y in range(36):  # the middle column, and the half pixel beside it
            rise, across = (1 - 2 * (y + 0.5) / 36) * math.tan(math.radians(25)), (2 * (middle + 0.5) / 48 - 1) * math.tan(math.radians(25)) * 4 / 3
            ahead = [0, -3 / math.hypot(3, 12), -12 / math.hypot(3, 12)]
            place = [across * depth[y][middle], 4 + depth[y][middle] * (ahead[1] - rise * ahead[2]), 12 + depth[y][middle] * (ahead[2] + rise * ahead[1])]
            if not depth[y][middle] > 0 or abs(place[1]) > 1e-3:
                continue
            r = math.dist(place, (0, 3, 0))
            assert math.pi * scale * lit[y][middle] == pytest.approx(50 * 3 / r ** 3 * window(r, end) * math.exp(-0.02 * r), rel=1e-3, abs=1e-4)
            asked += 1
        assert asked > 10


def test_case_of_a_ray_along_a_cone(cases, tmp_path):
    """Exactly parallel to the side, and turned by a little: the same airlight, by a quadrature of the case's numbers (light/par.cpp)."""
    subprocess.run([os.environ.get("CXX", "g++"), f"-I{ROOT}", f"-I{ROOT / 'formats'}", f"-I{ROOT / 'runtime'}", "-Dvxs_air_lamp=vxs_air_punctual", cases / "light" / "par.cpp", "-o", tmp_path / "par"],
                   check=True)
    said = re.findall(r"cone (\d+) deg, ray turned by \S+: airlight (\S+)", subprocess.run([tmp_path / "par"], capture_output=True, text=True, check=True).stdout)
    assert len(said) == 9
    for half, air in said:
        assert float(air) == pytest.approx({"45": 4.05439e-4, "60": 4.42625e-4, "30": 3.81286e-4}[half], rel=1e-4)
