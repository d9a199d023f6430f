# vxs bake --smoke: what a grid of smoke leaves of the lights of a small scene, in every command that reads the file; grids that are
# none.
# SPDX-License-Identifier: GPL-3.0-or-later
import array
import json
import math
import random
import struct
import struct

import jsonschema
import pytest

import small_scene
from conftest import ROOT
from png import read_png
from test_format import libraries, read  # noqa: F401, a fixture

SMALL = ("--resolution", 64)
SIZE, ORIGIN, STEP = (16, 6, 12), (-6, 4, -5), (0.8, 0.2, 0.8)


def nrrd(path, numbers=None, kind="float", **changes):
    """A slab of even smoke over the block, whose extinction doubles from -x to +x; fields are changed, or left out where they are None."""
    nx, ny, nz = SIZE
    if numbers is None:
        numbers = [0.1 + 0.1 * i / (nx - 1) for _ in range(nz) for _ in range(ny) for i in range(nx)]
    fields = {"type": kind, "dimension": 3, "sizes": "%d %d %d" % SIZE, "encoding": "raw", "endian": "little", "space_dimension": 3,
              "space_directions": "(%g,0,0) (0,%g,0) (0,0,%g)" % STEP, "space_origin": "(%g,%g,%g)" % ORIGIN} | changes
    text = "NRRD0004\n# a slab\n" + "".join(f"{name.replace('_', ' ')}: {value}\n" for name, value in fields.items() if value is not None) + "\n"
    data = array.array({"float": "f", "uint8": "B", "uint16": "H"}[kind], numbers).tobytes()
    path.write_bytes(text.encode() + data)
    return path


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    lights = (("sun", "directional", (0, -1, 0)), ("lamp", "point", (0, 8, 0)), ("far", "spot", (0, 1, 0)))
    return small_scene.write(tmp_path_factory.mktemp("smoke") / "small.gltf", lights=lights[:1])


@pytest.fixture(scope="module")
def baked(vxs, scene, tmp_path_factory):
    """The asset, its report, and the same without smoke."""
    folder = tmp_path_factory.mktemp("baked")
    smoke = nrrd(folder / "smoke.nrrd")
    vxs("bake", scene, *SMALL, "-o", folder / "plain.vxs")
    vxs("bake", scene, *SMALL, "--smoke", smoke, "--smoke-side", 64, "--smoke-nodes", 16, "--smoke-error", 0.001, "-o", folder / "out.vxs",
        "--json", folder / "out.json")
    return folder / "out.vxs", json.loads((folder / "out.json").read_text()), folder / "plain.vxs", smoke


class Curves:
    """A section SMKE by section 15 of formats/vxs.md, to the letter."""

    def __init__(self, data, maps):
        levels, self.first, self.step, node_count = struct.unpack_from("<IffI", data)
        self.side = 1 << levels
        tiles = maps * (self.side // 8) ** 2
        mask, at = data[16:16 + (tiles + 7) // 8], 16 + (tiles + 7) // 8
        marked = [t for t in range(tiles) if mask[t // 8] >> t % 8 & 1]
        counts, at = data[at:at + 64 * len(marked)], at + 64 * len(marked)
        planes = [data[at + p * node_count:at + (p + 1) * node_count] for p in range(4)]
        assert at + 4 * node_count == len(data) and sum(counts) == node_count and all(any(counts[64 * n:64 * n + 64]) for n in range(len(marked)))
        self.curves, node = {}, 0
        for n, tile in enumerate(marked):
            for texel in range(64):
                d, t, curve = 0, 65535, []
                for _ in range(counts[64 * n + texel]):
                    d, t, node = d + planes[0][node] + 256 * planes[1][node], t - planes[2][node] - 256 * planes[3][node], node + 1
                    curve.append((d, t))
                assert d < 65536 and t >= 0
                self.curves[tile, texel] = curve

    def curve(self, face, x, y, metres):
        x, y = (min(max(c, 0), self.side - 1) for c in (x, y))
        across, depth = self.side // 8, (metres - self.first) / self.step
        nodes = self.curves.get(((face or 0) * across ** 2 + y // 8 * across + x // 8, x % 8 + 8 * (y % 8)), [])
        before = sum(d <= depth for d, _ in nodes)
        if not before or before == len(nodes):
            return nodes[before - 1][1] / 65535 if before else 1
        (a, s), (b, t) = nodes[before - 1:before + 1]
        return (s + (depth - a) / (b - a) * (t - s)) / 65535

    def left(self, light, point):
        place = light.place(point)
        if place is None:
            return 1
        face, u, v, depth = place
        metres = depth * light.voxel if light.kind == 1 else light.near * math.exp(depth * light.voxel)
        x, y = (c * self.side / 2 ** light.levels - 0.5 for c in (u, v))
        i, j = math.floor(x), math.floor(y)
        return sum((x - i if a else 1 - x + i) * (y - j if b else 1 - y + j) * self.curve(face, i + a, j + b, metres) for a in (0, 1) for b in (0, 1))


def test_curves_from_the_spec_answer_like_the_command(vxs, libraries, tmp_path):  # noqa: F811
    """Of a sun, a spot and a point light, in a file that a reader of version 1 reads."""
    lights = (("sun", "directional", (0.3, -1, 0.2)), ("spot", "spot", (0.1, -1, 0)), ("lamp", "point", (0, -1, 0)))
    scene = small_scene.write(tmp_path / "lights.gltf", lights=lights)
    vxs("bake", scene, *SMALL, "--coding", "dag", "--smoke", nrrd(tmp_path / "smoke.nrrd", space_origin="(-6,1,-5)"), "-o", tmp_path / "out.vxs")
    found, sections = read(tmp_path / "out.vxs", libraries)
    curves = [Curves(sections["SMKE", n, 0], 6 if light.flags & 2 else 1) if ("SMKE", n, 0) in sections else None for n, light in enumerate(found)]
    dice, dimmed = random.Random(5), set()
    points = [(dice.uniform(-7, 7), dice.uniform(-1, 5), dice.uniform(-7, 7)) for _ in range(1500)]
    done = vxs("query", tmp_path / "out.vxs", "--smoke", input="".join("%r %r %r\n" % point for point in points))
    for point, line in zip(points, done.stdout.splitlines(), strict=True):
        for light, of, left in zip(found, curves, line.split()[1::2], strict=True):
            exact = of.left(light, point) if of else 1
            assert abs(float(left) - exact) < 2e-6, (light.name, point)
            dimmed |= {light.name} if exact < 0.95 else set()
    assert {"sun"} < dimmed


def wanted(x, y, z):
    """What is left of the sun, straight down through the slab: half a sample is added on all sides."""
    i = min(max((x - ORIGIN[0]) / STEP[0], 0), SIZE[0] - 1)
    inside = -0.5 <= (x - ORIGIN[0]) / STEP[0] <= SIZE[0] - 0.5 and -0.5 <= (z - ORIGIN[2]) / STEP[2] <= SIZE[2] - 0.5
    low, high = ORIGIN[1] - STEP[1] / 2, ORIGIN[1] + (SIZE[1] - 0.5) * STEP[1]
    return math.exp(-(0.1 + 0.1 * i / (SIZE[0] - 1)) * min(max(high - y, 0), high - low)) if inside else 1


def test_query_says_what_is_left(vxs, baked):
    points = [(x / 3, y / 2, z / 3) for x in range(-17, 18, 3) for y in (0, 3, 8, 9, 10, 13) for z in (-11, 0, 7)]
    done = vxs("query", baked[0], "--smoke", input="".join("%r %r %r\n" % p for p in points))
    plain = vxs("query", baked[2], input="".join("%r %r %r\n" % p for p in points))
    dimmed = 0
    for point, line, before in zip(points, done.stdout.splitlines(), plain.stdout.splitlines(), strict=True):
        lit, left = line.split()
        assert lit == before
        if lit == "1" and abs(wanted(*point) - 1) > 0.01:
            assert abs(float(left) - wanted(*point)) < 0.01, point
            dimmed += 1
    assert dimmed > 40
    assert all(line.split()[1] == "1" for line in vxs("query", baked[2], "--smoke", input="0 0 0\n5 5 5\n").stdout.splitlines())
    assert all(len(line.split()) == 1 for line in vxs("query", baked[0], input="0 0 0\n5 5 5\n").stdout.splitlines())


def test_pictures_are_darker_in_its_shadow(vxs, baked, scene, tmp_path):
    means = []
    for asset in (baked[0], baked[2]):
        vxs("render", scene, asset, "-o", tmp_path / "out.png", "--width", 64, "--height", 48, "--samples", 1, "--exposure", -2, "--eye", "0,12,0.1", "--target", "0,0,0", "--force")
        width, height, rows = read_png((tmp_path / "out.png").read_bytes())
        means.append([sum(rows[y][3 * x] for y in range(20, 28)) / 8 for x in (5, 58)])  # beside the block, on both sides
    (left, right), (bright, other) = means
    assert abs(bright - other) < 1 and right < left - 2  # dithered; smoke is denser on the right; exposure follows what is brightest


def test_reports_tell_of_smoke(vxs, baked, scene, tmp_path):
    asset, report, plain, smoke = baked
    jsonschema.validate(report, json.loads((ROOT / "docs" / "bake-report.schema.json").read_text()))
    (light,) = report["lights"]
    told = light["smoke"]
    assert told["side_px"] == 64 and told["texels"] == 64 * 64 and 0 < told["curves"] <= 64 * 64
    assert told["nodes"] >= 2 * told["curves"] and told["largest_error"] <= 0.002
    between = told["lookups"]
    assert 500 < between["places"] <= 1000 and 0.002 < between["rms_error"] < between["largest_error"] < 1  # the slab has edges
    assert report["options"]["smoke"] == {"extinction": 1, "side_px": 64, "nodes": 16, "error": 0.001}
    assert next(s for s in report["stages"] if s["name"] == "smoke")["seconds"] > 0

    vxs("info", asset, "--json", tmp_path / "info.json")
    info = json.loads((tmp_path / "info.json").read_text())
    jsonschema.validate(info, json.loads((ROOT / "docs" / "info.schema.json").read_text()))
    section = info["sections"][-1]
    assert section["kind"] == "smoke" and section["light"] == "sun" and section["side_px"] == 64
    assert section["count"] == told["nodes"] and section["memory_bytes"] == told["memory_bytes"] and section["stored_bytes"] == told["stored_bytes"]
    assert asset.stat().st_size > plain.stat().st_size + told["stored_bytes"]
    text = vxs("info", asset).stdout
    assert "smoke of 64 x 64 curves" in text and "--smoke-side 64" in text
    assert vxs("validate", asset).stdout.endswith("valid\n")
    short = vxs("bake", scene, *SMALL, "--smoke", smoke, "-o", tmp_path / "a.vxs").stdout
    assert "smoke        of 1 light: " in short and "of their own rays; lookups between rays: RMS error 0." in short
    long = vxs("bake", scene, *SMALL, "--smoke", smoke, "-o", tmp_path / "b.vxs", "--verbose").stdout
    assert "  smoke      64 x 64 texels a map" in long and "             lookups between rays: RMS error 0." in long


def test_smoke_makes_other_files_up_to_date(vxs, scene, baked, tmp_path):
    smoke, out = baked[3], tmp_path / "out.vxs"
    options = ("bake", scene, *SMALL, "-o", out, "--if-changed")
    vxs(*options, "--smoke", smoke)
    assert "up to date" in vxs(*options, "--smoke", smoke).stdout
    first = out.read_bytes()
    for other in (("--smoke", smoke, "--smoke-nodes", 4), ("--smoke", smoke, "--smoke-extinction", 2),
                  ("--smoke", nrrd(tmp_path / "moved.nrrd", space_origin="(-6,4.5,-5)")), ()):
        assert "up to date" not in vxs(*options, *other).stdout
        assert out.read_bytes() != first
        assert "up to date" in vxs(*options, *other).stdout
    assert out.read_bytes()[:8] == first[:8] and b"SMKE" not in out.read_bytes()


def test_smoke_of_the_scene_is_baked_where_it_is_asked_for(vxs, tmp_path):
    scene, plain, own = tmp_path / "smoke.glb", tmp_path / "plain.vxs", tmp_path / "own.vxs"
    vxs("scene", "smoke", "-o", scene, "--capsules", 200)
    vxs("bake", scene, *SMALL, "-o", plain)
    vxs("bake", scene, *SMALL, "-o", own, "--scene-smoke", "on")
    assert b"SMKE" in own.read_bytes() and b"SMKE" not in plain.read_bytes() and "smoke        capsules " in vxs("info", own).stdout
    points = "".join(f"{x} 0.1 {z}\n" for x in range(-12, 13) for z in range(-12, 13))
    columns = list(zip(*(line.split() for line in vxs("query", own, "--smoke", input=points).stdout.splitlines())))
    assert columns[::2] == list(zip(*(line.split() for line in vxs("query", plain, input=points).stdout.splitlines())))
    assert any(min(map(float, left)) < 0.6 for left in columns[1::2])
    pictures = {}
    for asset in (plain, own):
        for smoke in ("on", "off"):
            vxs("render", scene, asset, "-o", tmp_path / "out.png", "--width", 64, "--height", 48, "--samples", 1, "--smoke", smoke, "--force")
            pictures[asset, smoke] = (tmp_path / "out.png").read_bytes()
    assert pictures[plain, "on"] == pictures[own, "on"] and pictures[plain, "off"] != pictures[own, "off"], "the scene's own smoke dims once"
    both = vxs("bake", scene, *SMALL, "-o", tmp_path / "both.vxs", "--scene-smoke", "on", "--smoke", nrrd(tmp_path / "slab.nrrd")).stdout
    assert "smoke        of " in both
    text = vxs("info", tmp_path / "both.vxs").stdout
    assert "smoke        grid " in text and ", capsules " in text


def test_fog_is_dimmed_by_what_is_baked(vxs, tmp_path):
    """As by the same capsules when they are drawn: steps are taken through them, whatever was requested."""
    scene, plain, own = tmp_path / "smoke.glb", tmp_path / "plain.vxs", tmp_path / "own.vxs"
    fine = "--resolution", 512, "--light", "sun"  # so that exposure is the same
    vxs("scene", "smoke", "-o", scene, "--capsules", 400)
    vxs("bake", scene, *fine, "-o", plain)
    vxs("bake", scene, *fine, "-o", own, "--scene-smoke", "on", "--smoke-error", 0.001)

    def airlight(asset, smoke):
        steps = ["--fog-steps", 64] if asset == own or smoke == "on" else []  # else nothing takes them
        said = vxs("render", scene, asset, "-o", tmp_path / "out.png", "--width", 48, "--height", 36, "--samples", 1, "--light", "sun", "--fog", 0.03,
                   "--eye", "12,3,14", "--target", "0,2,0", "--smoke", smoke, "--passes", tmp_path / "passes", "--verbose", "--force", *steps).stdout
        return said, [c for row in read_png((tmp_path / "passes" / "airlight.png").read_bytes())[2] for c in row[::3]]

    (_, drawn), (said, found), (_, clear) = airlight(plain, "on"), airlight(own, "off"), airlight(plain, "off")
    assert "light sun: by angles, in 100 % of the picture: smoke dims it" in said
    wrong, without = (sum(abs(a - b) for a, b in zip(drawn, other)) for other in (found, clear))
    assert wrong < 0.05 * without and without > 500, (wrong, without)


@pytest.mark.parametrize("kind, factor", [("uint8", 0.01), ("uint16", 0.01)])
def test_whole_numbers_are_scaled(vxs, scene, tmp_path, kind, factor):
    numbers = [10 + i for _ in range(SIZE[2]) for _ in range(SIZE[1]) for i in range(SIZE[0])]
    for name, of in (("whole", (numbers, kind)), ("float", ([n * factor for n in numbers], "float"))):
        vxs("bake", scene, *SMALL, "-o", tmp_path / f"{name}.vxs", "--smoke", nrrd(tmp_path / f"{name}.nrrd", *of, endian=None if kind == "uint8" and name == "whole" else "little"),
            "--smoke-extinction", factor if name == "whole" else 1)
    points = "".join(f"{x / 4} 1 {z / 4}\n" for x in range(-20, 20) for z in range(-16, 16, 5))
    a, b = (vxs("query", tmp_path / f"{name}.vxs", "--smoke", input=points).stdout.split() for name in ("whole", "float"))
    assert all(abs(float(x) - float(y)) < 1e-4 for x, y in zip(a, b, strict=True)) and min(map(float, a[1::2])) < 0.9


def test_spacings_stand_along_the_axes(vxs, scene, tmp_path):
    one = nrrd(tmp_path / "directions.nrrd")
    two = nrrd(tmp_path / "spacings.nrrd", space_directions=None, spacings="%g %g %g" % STEP)
    for path in (one, two):
        vxs("bake", scene, *SMALL, "-o", path.with_suffix(".vxs"), "--smoke", path)
    assert one.with_suffix(".vxs").read_bytes() == two.with_suffix(".vxs").read_bytes()


COUNT = SIZE[0] * SIZE[1] * SIZE[2]


@pytest.mark.parametrize("changes, status, says", [
    ({"numbers": [0.1] * (COUNT - 1)}, 3, "4604 bytes of numbers: expected 4608, for 16 x 6 x 12"),
    ({"numbers": [0.1] * (COUNT + 1)}, 3, "more than 4608 bytes of numbers: expected 4608"),
    ({"numbers": [0.1] * 100 + [-1] + [0.1] * (COUNT - 101)}, 3, "sample (4, 0, 1) is -1: expected extinction, 0 or more"),
    ({"numbers": [0.1] * 100 + [math.nan] + [0.1] * (COUNT - 101)}, 3, "sample (4, 0, 1) is nan"),
    ({"numbers": [math.inf] * COUNT}, 3, "sample (0, 0, 0) is inf"),
    ({"type": "double"}, 3, "type: double: expected float, uint8 or uint16"),
    ({"type": None}, 3, "the field 'type' of NRRD is missing"),
    ({"dimension": 2, "sizes": "16 72"}, 3, "dimension: 2: expected 3"),
    ({"sizes": "16 72"}, 3, "sizes: 16 72: expected three numbers"),
    ({"sizes": "0 6 12"}, 3, "sizes: 0 6 12: expected 1 to 16384 along each axis"),
    ({"sizes": "16384 16384 16384"}, 3, "expected 17592186044416"),
    ({"sizes": "99999999999999999999 6 12"}, 3, "expected 1 to 16384 along each axis"),
    ({"encoding": "gzip"}, 3, "encoding: gzip: expected raw"),
    ({"endian": "big"}, 3, "endian: big: expected little"),
    ({"endian": None}, 3, "the field 'endian' of NRRD is missing"),
    ({"space_dimension": 2}, 3, "space: 2: expected 'space dimension: 3'"),
    ({"space_dimension": None, "space": "left-posterior-superior"}, 3, "space: left-posterior-superior: expected"),
    ({"space_directions": "(1,0,0) (0,1,0) none"}, 3, "expected three vectors of three numbers"),
    ({"space_directions": "(1,0,0) (0,1,0) (1,1,0)"}, 3, "axes that lie in a plane"),
    ({"space_directions": "(1,0,0) (0,1,0) (0,0,1e9)"}, 3, "lead beyond 1e9 m"),
    ({"space_directions": "(1,0,0) (0,1,0) (0,0,nan)"}, 3, "expected three vectors of three numbers"),
    ({"space_directions": None}, 3, "the field 'space directions' of NRRD is missing"),
    ({"spacings": "1 1 1"}, 3, "'space directions' and 'spacings': expected one of them"),
    ({"data_file": "other.raw"}, 3, "data file: other.raw: expected numbers behind the header"),
    ({"byte_skip": -1}, 3, "skip: -1: expected 0"),
])
def test_grids_that_are_none(vxs, scene, tmp_path, changes, status, says):
    grid = nrrd(tmp_path / "bad.nrrd", **changes)
    done = vxs("bake", scene, *SMALL, "--smoke", grid, "-o", tmp_path / "out.vxs", status=status)
    assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1 and says in done.stderr, done.stderr
    assert not (tmp_path / "out.vxs").exists()


@pytest.mark.parametrize("data, says", [
    (b"", "expected a grid in NRRD"), (b"glTF and more\n", "expected a grid in NRRD"), (b"NRRD0004\ntype: float\n", "the header of NRRD does not end"),
    (b"NRRD0004\n" + b"a" * 2000 + b"\n\n", "the header of NRRD does not end"), (b"NRRD0004\nnothing\n\n", "'nothing': expected a field of NRRD")])
def test_files_that_are_no_grids(vxs, scene, tmp_path, data, says):
    (tmp_path / "bad.nrrd").write_bytes(data)
    done = vxs("bake", scene, *SMALL, "--smoke", tmp_path / "bad.nrrd", "-o", tmp_path / "out.vxs", status=3)
    assert done.stderr.count("\n") == 1 and says in done.stderr, done.stderr


@pytest.mark.parametrize("options, says", [
    (("--smoke-side", 64), "they need --smoke"), (("--smoke-nodes", 8), "they need --smoke"), (("--smoke-error", 0.1), "they need --smoke"),
    (("--smoke-extinction", 2), "they need --smoke"), (("--smoke", "{}", "--smoke-side", 100), "expected a power of two from 8 to 8192"),
    (("--smoke", "{}", "--smoke-nodes", 3), "--smoke-nodes"), (("--smoke", "{}", "--smoke-error", 2), "--smoke-error"),
    (("--smoke", "{}", "--smoke-extinction", 0), "--smoke-extinction")])
def test_options_that_make_no_sense(vxs, scene, baked, tmp_path, options, says):
    done = vxs("bake", scene, *SMALL, *(str(o).format(baked[3]) for o in options), "-o", tmp_path / "out.vxs", status=2)
    assert done.stderr.count("\n") == 1 and says in done.stderr, done.stderr


def test_parts_have_no_smoke(vxs, scene, baked, tmp_path):
    done = vxs("bake", scene, *SMALL, "--smoke", baked[3], "--part", "1/2", "-o", tmp_path / "out.part", status=2)
    assert "smoke is baked into a whole asset, and --part makes a part of it" in done.stderr


def test_missing_grids_are_told_of(vxs, scene, tmp_path):
    assert "nothing.nrrd" in vxs("bake", scene, "--smoke", tmp_path / "nothing.nrrd", "-o", tmp_path / "out.vxs", status=3).stderr


def test_memory_is_kept(vxs, scene, baked, tmp_path):
    vxs("bake", scene, *SMALL, "--smoke", baked[3], "--memory", "1K", "-o", tmp_path / "out.vxs", status=6)
    lamp = small_scene.write(tmp_path / "lamp.gltf", lights=(("lamp", "point", (0, -1, 0)),))
    done = vxs("bake", lamp, "--resolution", 4096, "--smoke", baked[3], "--smoke-side", 4096, "--memory", "100M", "-o", tmp_path / "out.vxs", status=6)
    assert done.stderr.count("\n") == 1 and "--memory allows" in done.stderr and not (tmp_path / "out.vxs").exists()
