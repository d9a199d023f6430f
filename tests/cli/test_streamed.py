# Files with smoke and points that are streamed, by vxs query and vxs render with --budget: answers and pictures are those of the
# whole file; budgets that are too small, pages and smoke that are damaged.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import random
import re
import struct

import pytest

import small_scene
from test_area import BESIDE, add_quads
from test_smoke_bake import SMALL, nrrd

SIZE = "--width", 48, "--height", 36, "--samples", 1


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    """A folder with level.gltf, plain.vxs and smoky.vxs, in which smoke dims each of three lights."""
    folder = tmp_path_factory.mktemp("streamed")
    lights = (("sun", "directional", (0.3, -1, 0.2)), ("spot", "spot", (0, -1, 0)), ("lamp", "point", (0, -1, 0)))
    small_scene.write(folder / "level.gltf", lights=lights)
    for name, smoke in (("plain", ()), ("smoky", ("--smoke", nrrd(folder / "smoke.nrrd", space_origin="(-6,1,-5)")))):
        vxs("bake", folder / "level.gltf", *SMALL, *smoke, "-o", folder / f"{name}.vxs")
    return folder


@pytest.fixture(scope="module")
def forest(vxs, tmp_path_factory):
    """A file of three pages."""
    folder = tmp_path_factory.mktemp("pages")
    vxs("scene", "forest", "--triangles", 20000, "-o", folder / "forest.glb")
    vxs("bake", folder / "forest.glb", "-o", folder / "forest.vxs", "--resolution", 4096)
    return folder / "forest.vxs"


def places(count, wide, high):
    dice = random.Random(3)
    numbers = ([dice.uniform(-wide, wide), dice.uniform(-1, high), dice.uniform(-wide, wide)] for _ in range(count))
    return "".join("%r %r %r%s\n" % (*p, " 0 1 0" if n % 2 else "") for n, p in enumerate(numbers))


def least_budget(run, *arguments, **more):
    said = run(*arguments, "--budget", 1, status=6, **more).stderr
    assert said.count("\n") == 1 and said.startswith("vxs: error: --budget 1: ")
    return int(re.search(r"needs at least (\d+) bytes", said)[1])


@pytest.mark.parametrize("options", [(), ("--smooth", 4), ("--light", "lamp", "--light", "sun")])
def test_answers_are_those_of_the_whole_file(vxs, level, options):
    ask = "query", level / "smoky.vxs", "--smoke", *options
    points = places(800, 8, 6)
    whole = vxs(*ask, input=points).stdout
    assert vxs(*ask, "--budget", "16M", input=points).stdout == whole
    dimmed = sum(min(map(float, line.split()[1::2])) < 0.95 for line in whole.splitlines())
    assert dimmed > 50


def test_least_budget(vxs, level, tmp_path):
    """What the message names is enough, a byte less is not, and smoke is a part of it."""
    ask, points = ("query", level / "smoky.vxs", "--smoke"), places(800, 8, 6)
    least, plain = least_budget(vxs, *ask, input=points), least_budget(vxs, "query", level / "plain.vxs", input=points)
    vxs("info", level / "smoky.vxs", "--json", tmp_path / "info.json")
    smoke = [s["memory_bytes"] for s in json.loads((tmp_path / "info.json").read_text())["sections"] if s["kind"] == "smoke"]
    assert len(smoke) == 3 and plain + sum(smoke) <= least < plain + 5 * sum(smoke)
    assert f"needs at least {least} bytes" in vxs(*ask, "--budget", least - 1, input=points, status=6).stderr
    found, whole = (vxs(*ask, *budget, input=points).stdout.split() for budget in (("--budget", least), ()))
    assert found[1::2] == whole[1::2]


def test_pages_come_to_points(vxs, forest):
    """One after the other, where there is no room for all; where there is none for any, a warning counts what is coarse."""
    points = "".join(sorted(places(60, 30, 8).splitlines(keepends=True), key=lambda line: float(line.split()[0])))
    ask = "query", forest, "--filter", 5, "--budget"
    whole = vxs(*ask[:-1], input=points).stdout.splitlines()
    least = least_budget(vxs, *ask[:-1], input=points)
    for budget, most in ((16 << 20, 0), (least + 700000, 12), (least, 60)):
        done = vxs(*ask, budget, input=points)
        told = re.fullmatch(r"vxs: warning: (\d+) points are answered coarsely: --budget \d+ has no room for all pages about them\n", done.stderr)
        coarse, others = int(told[1]) if told else 0, sum(a != b for a, b in zip(done.stdout.splitlines(), whole, strict=True))
        assert others <= coarse <= most
    assert coarse > 20 and others > 5 and "(--strict: " in vxs(*ask, least, "--strict", input=points, status=1).stderr


def test_a_page_that_is_damaged_is_no_answer(vxs, forest, tmp_path):
    data = bytearray(forest.read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / "broken.vxs").write_bytes(data)
    done = vxs("query", tmp_path / "broken.vxs", "--budget", "16M", input=places(400, 30, 8), status=3)
    assert re.search(r"broken.vxs' is not a valid .vxs file: page \d of light 'sun' \(finding 50\d\)\n$", done.stderr) and done.stdout == ""


def test_options_of_query(vxs, level, forest):
    for arguments, says in (((forest, "--budget", "1M", "--memory", "1M"), "--memory and --budget exclude each other"),
                            ((forest, "--budget", "1M", "--light", "moon"), "has no light of that name; it has sun"),
                            ((forest, "--budget", "much"), "expected a number of bytes"),
                            (("-", "--budget", "1M"), "points are read from standard input")):
        said = vxs("query", *arguments, input="0 0 0\n", status=2).stderr
        assert says in said and said.count("\n") == 1


def section(data, kind, light):
    """Offset and size of a section's stored bytes."""
    for n in range(struct.unpack_from("<I", data, 12)[0]):
        name, _, of, _, offset, stored = struct.unpack_from("<4sIIIQQ", data, 64 + 48 * n)
        if (name, of) == (kind, light):
            return offset, stored


def test_damaged_smoke_is_told(vxs, level, tmp_path):
    """When the file is opened, and only where the light is wanted."""
    data = bytearray((level / "smoky.vxs").read_bytes())
    offset, stored = section(data, b"SMKE", 0)
    data[offset + stored // 2] ^= 1
    (tmp_path / "broken.vxs").write_bytes(data)
    for command in (("query", tmp_path / "broken.vxs"), ("render", level / "level.gltf", tmp_path / "broken.vxs", "-o", tmp_path / "out.png")):
        said = vxs(*command, "--budget", "16M", input="0 0 0\n", status=3).stderr
        assert re.search(r"broken.vxs' is not a valid .vxs file: the checksum of a section does not match \(finding 206 at byte \d+, in section \d+\)\n$", said)
        assert said.count("\n") == 1
    assert vxs("query", tmp_path / "broken.vxs", "--light", "spot", "--budget", "16M", input="0 0 0\n").stdout == \
        vxs("query", level / "smoky.vxs", "--light", "spot", input="0 0 0\n").stdout
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize("options", [(), ("--fog", 0.05), ("--light", "lamp", "--light", "sun")])
def test_pictures_are_those_of_the_whole_file(vxs, level, tmp_path, options):
    pictures = {}
    for asset in ("plain", "smoky"):
        for budget in ((), ("--budget", "16M")):
            vxs("render", level / "level.gltf", level / f"{asset}.vxs", "-o", tmp_path / "out.png", *SIZE, "--eye", "6,9,2", "--target", "0,0,0", *options, *budget, "--force")
            pictures[asset, bool(budget)] = (tmp_path / "out.png").read_bytes()
    assert pictures["smoky", True] == pictures["smoky", False] != pictures["plain", False] == pictures["plain", True]


def test_smoke_of_the_scene_dims_once(vxs, tmp_path):
    """Where it is drawn, a stream's own, of the same capsules, is left alone."""
    scene, asset = tmp_path / "smoke.glb", tmp_path / "own.vxs"
    vxs("scene", "smoke", "-o", scene, "--capsules", 200)
    vxs("bake", scene, *SMALL, "-o", asset, "--scene-smoke", "on")
    pictures = {}
    for smoke in ("on", "off"):
        for budget in ((), ("--budget", "16M")):
            vxs("render", scene, asset, "-o", tmp_path / "out.png", *SIZE, "--smoke", smoke, *budget, "--force")
            pictures[smoke, bool(budget)] = (tmp_path / "out.png").read_bytes()
    assert pictures["on", True] == pictures["on", False] != pictures["off", False] == pictures["off", True]


def test_points_of_the_asset(vxs, tmp_path):
    """They cast the shadows of area lights; they are within the budget while the file is opened, and without area lights nothing requests them."""
    level, asset = small_scene.write(tmp_path / "level.gltf", lights=[("sun", "directional", (1, -1, 0))]), tmp_path / "level.vxs"
    add_quads(level, [(*BESIDE, [1, 0.5, 0.25])])
    vxs("bake", level, *SMALL, "-o", asset, "--points", 60000)

    def render(*options, **more):
        return vxs("render", level, asset, "-o", tmp_path / "out.png", *SIZE, "--eye", "7,9,6", "--target", "0,1,0", *options, "--json", tmp_path / "r.json", "--force", **more)

    pictures, reports = [], []
    for budget in ((), ("--budget", "16M")):
        render("--area", 8, *budget)
        pictures.append((tmp_path / "out.png").read_bytes())
        reports.append(json.loads((tmp_path / "r.json").read_text())["area"])
    assert pictures[0] == pictures[1] and reports[0] == reports[1] and (reports[0]["points"], reports[0]["points_of"]) == (60000, "asset")
    with_points, without = (least_budget(render, "--area", lamps) for lamps in (8, 0))
    assert with_points > max(without, 2 * 6 * 60000)
    render("--area", 8, "--budget", with_points)
    assert json.loads((tmp_path / "r.json").read_text())["area"] == reports[0]
