# vxs plan, and that the bake follows it.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import re
import subprocess
import time

import jsonschema
import pytest

import small_scene
from conftest import ROOT, open_terminal
from named_scene import dome, inside_out, light, node, plane, write
from small_scene import NOON

LIGHTS = (("noon", "directional", NOON), ("lamp", "spot", NOON), ("bulb", "point", NOON), ("up", "spot", (0, 1, 0)))
INSIDE = (((-8, -1, -8), (8, 0, 8)), ((-1, 2, -1), (1, 3, 1)), ((-0.5, 2.5, -0.5), (0.5, 4, 0.5)))  # two boxes intersect


@pytest.fixture(scope="module")
def folder(vxs, tmp_path_factory):
    path = tmp_path_factory.mktemp("plan")
    small_scene.write(path / "apart.gltf", lights=LIGHTS)
    small_scene.write(path / "meet.gltf", boxes=INSIDE)
    small_scene.write(path / "sheets.gltf", open_faces=True)
    vxs("scene", "city", "-o", path / "city.glb", "--triangles", 20000, "--blocks", 3)
    vxs("scene", "forest", "-o", path / "forest.glb", "--triangles", 5000, "--size", 30)
    return path


@pytest.fixture
def plan(vxs):
    """plan(scene, *options): the plan as JSON, with its decisions by name."""

    def run(scene, *options):
        plan = json.loads(vxs("plan", scene, *options, "--json", "-").stdout)
        return plan | {"decided": {d["name"]: d for d in plan["decisions"]}}

    return run


@pytest.fixture
def bake(vxs, tmp_path):
    def run(scene, *options):
        vxs("bake", scene, "-o", tmp_path / "out.vxs", "--json", tmp_path / "out.json", *options)
        return json.loads((tmp_path / "out.json").read_text())

    return run


def sections(vxs, path):
    """The bytes of all sections but the metadata."""
    data = path.read_bytes()
    return [data[s["offset_bytes"]:s["offset_bytes"] + s["stored_bytes"]]
            for s in json.loads(vxs("info", path, "--json", "-").stdout)["sections"] if s["kind"] != "metadata"]


def test_says_what_and_why(vxs, folder):
    text = vxs("plan", folder / "apart.gltf", "--coding", "dag", "--verbose").stdout
    for word in ("lights", "3 baked", "1 that reach no caster", "exit map", "2 solids with 24 triangles", "tiles", "tile size",
                 "sub-DAG compression", "file", "light up is left out: it reaches no caster", "estimate"):
        assert word in text
    assert not list(folder.glob("*.vxs"))


def test_large_numbers_are_written_out(vxs, folder):
    """12300 nodes, and not 1.23e+04."""
    text = vxs("plan", folder / "city.glb", "--coding", "dag", "--verbose").stdout
    assert re.search(r"^  about +\d{4,} masks, \d{5,} nodes;", text, re.MULTILINE) and "e+" not in text


def test_nothing_is_written(vxs, folder, tmp_path):
    vxs("plan", folder / "apart.gltf", "-o", tmp_path / "a.vxs")
    assert not list(tmp_path.iterdir())
    assert "No such file" in vxs("plan", folder / "apart.gltf", "-o", tmp_path / "nobody" / "a.vxs", status=4).stderr


@pytest.mark.parametrize("name", ["apart", "meet", "sheets"])
@pytest.mark.parametrize("resolution", [64, 512, 4096])
@pytest.mark.parametrize("maps", ["gl", "sparse"])
def test_the_bake_does_what_was_planned(plan, bake, folder, name, resolution, maps):
    planned = plan(folder / f"{name}.gltf", "--resolution", resolution, "--maps", maps)
    report = bake(folder / f"{name}.gltf", "--resolution", resolution, "--maps", maps)
    assert report["plan"]["decisions"] == planned["decisions"]
    assert report["plan"]["lights"] == planned["lights"]
    assert report["plan"]["estimate"] == planned["estimate"]
    expected = [light for light in planned["lights"] if "left_out" not in light]
    assert [light["name"] for light in report["lights"]] == [light["name"] for light in expected]
    for light, by_plan in zip(report["lights"], expected):
        if maps == "sparse":
            continue
        for count in ("tiles", "tiles_without_casters", "blocks_peeled", "blocks_not_peeled"):
            assert light[count] == by_plan[count], count
        assert light["blocks_rendered"] == by_plan["blocks"] - by_plan["blocks_without_casters"]


def test_the_same_plan_every_time(plan, folder):
    plans = [plan(folder / "city.glb", "--threads", n) for n in (1, 2, 2)]
    for p in plans:
        del p["plan_seconds"]
    assert plans[1] == plans[2]
    assert plans[0]["lights"] == plans[1]["lights"]


def test_peeling(plan, folder):
    big = ("--resolution", 4096, "--maps", "gl")
    assert "no component is solid" in plan(folder / "sheets.gltf")["decided"]["exit map"]["reason"]
    assert "peeling" not in plan(folder / "sheets.gltf")["decided"]
    assert plan(folder / "apart.gltf", *big)["decided"]["peeling"]["choice"] == "nowhere"
    meets = plan(folder / "meet.gltf", *big)
    meet, meet_light = meets["decided"]["peeling"], meets["lights"][0]
    assert meet["choice"] == "where solids meet" and "2 of 3 solids" in meet["reason"]
    back = plan(folder / "meet.gltf", *big, "--exit", "back")
    assert back["decided"]["peeling"]["choice"] == "nowhere" and back["lights"][0]["blocks_peeled"] == 0
    assert back["lights"][0]["blocks_not_peeled"] == meet_light["blocks_peeled"] + meet_light["blocks_not_peeled"] > 0
    assert plan(folder / "apart.gltf", "--maps", "gl", "--exit", "peel")["decided"]["peeling"]["choice"] == "everywhere"
    sparse = plan(folder / "meet.gltf", "--exit", "peel")
    assert sparse["decided"]["peeling"]["choice"] == "nowhere" and "--maps sparse" in sparse["decided"]["peeling"]["reason"]
    assert sparse["options"]["maps"] == "sparse" and sparse["lights"][0]["blocks_peeled"] == 0
    # where finding out takes longer than peeling
    few = plan(folder / "city.glb", "--resolution", 64, "--maps", "gl")["decided"]["peeling"]
    assert few["choice"] == "everywhere" and "finding out" in few["reason"]


def test_compression_pays_or_not(vxs, plan, bake, folder, tmp_path):
    """Whatever the plan says, the file is the same."""
    found = []
    for options in (("--threads", 1), ("--threads", 1, "--compress", "top-down")):
        report = bake(folder / "city.glb", "--resolution", 1024, "--coding", "dag", *options)
        stages = {s["name"]: s["seconds"] for s in report["stages"]}
        found.append(sections(vxs, tmp_path / "out.vxs"))
        chosen = {d["name"]: d["choice"] for d in report["plan"]["decisions"]}["sub-DAG compression"]
        assert (stages["compress"] > 1e-4) == (chosen == "done") == (len(options) == 4)
    assert found[0] == found[1]
    many = plan(folder / "city.glb", "--coding", "dag", "--threads", 256, "--resolution", 1024)
    assert many["decided"]["sub-DAG compression"]["choice"] == "done"


# --- estimates -------------------------------------------------------------------------------------------------------------------


def within(factor, estimate, actual):
    return actual / factor <= estimate <= actual * factor


@pytest.mark.parametrize("name", ["city.glb", "apart.gltf", "meet.gltf", "sheets.gltf", "forest.glb"])
def test_a_sample_of_all_is_the_map(bake, folder, name):
    """Windows cover a map of 256 texels whole: what the plan finds in them is what the bake finds. Windows have other neighbours than parts of
    larger squares, which may change where columns of a tile are left by a voxel."""
    for coding in ("dag", "blocks"):
        report = bake(folder / name, "--resolution", 256, "--coding", coding)
        for light, planned in zip(report["lights"], (l for l in report["plan"]["lights"] if "left_out" not in l)):
            assert planned["mask_tiles"] == light["mask_tiles"]
            if coding == "dag":
                assert planned["mask_runs"] == pytest.approx(light["mask_runs"], rel=0.05)
                assert planned["inserted_masks"] == pytest.approx(light["inserted_masks"], rel=0.05)
            elif light["maps"] == 1:  # six share blocks and patterns, and each has a sample of its own
                assert planned["palette_blocks"]["patterns"] == pytest.approx(light["palette_blocks"]["patterns"], rel=0.05)
                assert 0 < planned["palette_blocks"]["blocks"] <= light["palette_blocks"]["blocks"], "those with patterns"


@pytest.mark.parametrize("resolution", [1024, 4096])
def test_estimates_of_a_city(bake, folder, resolution):
    for coding in ("dag", "blocks"):
        plan = bake(folder / "city.glb", "--resolution", resolution, "--coding", coding)["plan"]
        for figure, factor in (("file_bytes", 2), ("memory_bytes", 2), ("peak_bytes", 1.4)):
            assert within(factor, plan["estimate"][figure], plan["actual"][figure]), (coding, figure)


@pytest.mark.slow
def test_estimates_of_real_scenes(bake, scenes):
    """Most are within a factor of two. Time is left out: how long it takes is up to who else is at work."""
    near = asked = 0
    for name in ("sponza", "kaykit_city", "mountains_heightfield", "chess_board", "dutch_ship_mask", "room_with_spheres_closed"):
        plan = bake(scenes / "real" / f"{name}.glb", "--sun", "-0.4,-1,-0.2", "--resolution", 2048)["plan"]
        asked += 2
        near += sum(within(2, plan["estimate"][f], plan["actual"][f]) for f in ("file_bytes", "memory_bytes"))
        assert within(1.4, plan["estimate"]["peak_bytes"], plan["actual"]["peak_bytes"]), name
    assert near >= 0.8 * asked


# --- memory ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", ["0", "-1", "many", "1Q", "1MM", "1e99", "", "nan", "inf"])
def test_wrong_budgets(vxs, folder, value):
    assert "expected a number of bytes" in vxs("plan", folder / "city.glb", f"--memory={value}", status=2).stderr


@pytest.mark.parametrize("value, bytes", [("1000000000", 10**9), ("1G", 2**30), ("1.5GiB", 3 * 2**29), ("900MB", 900 * 2**20)])
def test_budgets(plan, folder, value, bytes):
    assert plan(folder / "city.glb", "--memory", value)["options"]["memory_bytes"] == bytes


@pytest.mark.slow
@pytest.mark.parametrize("resolution, maps", [(2048, "gl"), (4096, "gl"), (4096, "sparse"), (8192, "sparse")])
def test_less_memory_makes_the_same_file(vxs, plan, bake, folder, tmp_path, resolution, maps):
    """Tiles are rendered smaller; what is looked at straight from triangles is in squares that are small anyway."""
    options = ("--resolution", resolution, "--maps", maps)
    everything = bake(folder / "city.glb", *options)
    expected = sections(vxs, tmp_path / "out.vxs")
    sizes = set()
    budgets = [everything["plan"]["estimate"]["peak_bytes"]]
    if maps == "gl":  # else what a bake needs is known to within a half, and it may be given up
        budgets.append(plan(folder / "city.glb", *options)["least_bytes"])
    for budget in budgets:
        report = bake(folder / "city.glb", *options, "--memory", budget)
        sizes.add(next(d["choice"] for d in report["plan"]["decisions"] if d["name"] == "tile size"))
        assert report["peak_bytes"] <= budget
        assert sections(vxs, tmp_path / "out.vxs") == expected
    assert len(sizes) == (2 if maps == "gl" else 1)


TWO_SIDED = {"doubleSided": True}


def stones(material, count=60, mesh=lambda n: dome(0.5 + n % 3 / 4, 6, 10)):
    """Round stones over a floor, each a node."""
    rest = {"material": material} if material else {}
    return [node(f"stone{n}", mesh(n), (3 * (n % 8) - 12, 1 + n % 5, 3 * (n // 8) - 12), **rest) for n in range(count)] + [
        node("floor", plane(40))]


def test_closed_but_for_a_material_of_two_sides(vxs, plan, bake, tmp_path):
    """As Blender exports it: --closed on would make solids of it, which is said where it saves much, and is what it then saves."""
    lights, options = [light("sun", "directional", direction=(0.3, -1, 0.2))], ("--resolution", 1024)
    bowls = [node(f"bowl{n}", dome(0.7, 6, 10, lowest=-0.5), (3 * n - 12, 7, 2)) for n in range(8)]  # open: --closed on leaves them
    path = write(tmp_path / "stones.gltf", [*stones(TWO_SIDED), *bowls], lights)
    planned, solid = plan(path, *options), plan(path, *options, "--closed", "on")
    saving = planned["savings"][0]
    triangles = planned["casters"]["sheets"]["double sided"]["triangles"]
    assert saving == {"option": "--closed on", "triangles": triangles, "file_bytes": pytest.approx(solid["estimate"]["file_bytes"], abs=2),
                      "total_seconds": pytest.approx(solid["estimate"]["total_seconds"], rel=0.1)}
    report = bake(path, *options)
    assert report["plan"]["savings"] == [saving]
    closed = bake(path, *options, "--closed", "on")
    assert closed["plan"]["savings"] == [] and closed["file_bytes"] < 0.7 * report["file_bytes"]
    text = f"{triangles} triangles are closed, but their material has two sides; it promises nothing inside of them"
    for command in (("plan",), ("bake", "-o", tmp_path / "b.vxs"), ("bake", "-o", tmp_path / "b.vxs", "--verbose")):
        said = vxs(command[0], path, *command[1:], *options).stdout
        assert re.search(rf"^would save   --closed on: \S+ s, a file of [\d.]+ (Ki)?B, about [a-z ]+: {text}$", said, re.MULTILINE)
    for name, schema in (("plan", planned), ("bake-report", report)):
        schema.pop("decided", None)
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / f"{name}.schema.json").read_text())).validate(schema)


@pytest.mark.parametrize("nodes, options", [
    (stones(None), ()),
    (stones(TWO_SIDED), ("--closed", "off")),
    (stones(TWO_SIDED)[:6] + stones(None)[6:], ()),  # few
    (stones(TWO_SIDED, mesh=lambda n: dome(1, 6, 10, lowest=-0.7)), ()),  # open below
], ids=["one side", "off", "few", "open"])
def test_nothing_is_closed_but_for_its_material(plan, tmp_path, nodes, options):
    path = write(tmp_path / "stones.gltf", nodes, [light("sun", "directional", direction=(0.3, -1, 0.2))])
    assert "--closed on" not in [saving["option"] for saving in plan(path, "--resolution", 1024, *options)["savings"]]


def test_stones_turned_inside_out(plan, tmp_path):
    """--closed on turns them outward, and so does the estimate."""
    path = write(tmp_path / "in.gltf", stones(TWO_SIDED, mesh=lambda n: inside_out(dome(0.5 + n % 3 / 4, 6, 10))),
                 [light("sun", "directional", direction=(0.3, -1, 0.2))])
    planned, solid = plan(path, "--resolution", 1024), plan(path, "--resolution", 1024, "--closed", "on")
    assert planned["savings"][0]["file_bytes"] == solid["estimate"]["file_bytes"]


def test_stones_that_a_spot_reaches(plan, tmp_path):
    """With --closed on, stones come before bowls: which triangles the spot reaches is found again in that order."""
    bowls = [node(f"bowl{n}", dome(0.7, 6, 10, lowest=-0.5), (3 * n, 7, 60)) for n in range(40)]
    path = write(tmp_path / "spot.gltf", [*bowls[:20], *stones(TWO_SIDED), *bowls[20:]], [light("spot", "spot", at=(0, 14, 0))])
    planned, solid = plan(path, "--resolution", 1024), plan(path, "--resolution", 1024, "--closed", "on")
    assert planned["savings"][0]["option"] == "--closed on"
    assert planned["savings"][0]["file_bytes"] == solid["estimate"]["file_bytes"]


def test_a_town_of_blender(plan, cases):
    folder = cases / "files" / "double_sided_three_times"
    planned = plan(folder / "blender_default.gltf")
    assert planned["savings"][0]["option"] == "--closed on" and planned["savings"][0]["triangles"] == 3600
    assert 0.25 < planned["savings"][0]["file_bytes"] / planned["estimate"]["file_bytes"] < 0.5
    assert "--closed on" not in str(plan(folder / "backface_culling.gltf")["savings"])


def test_too_little_memory_is_told_before_the_work(vxs, plan, folder, tmp_path):
    (tmp_path / "old.vxs").write_bytes(b"old")
    least = plan(folder / "city.glb", "--resolution", 4096)["least_bytes"]
    done = vxs("bake", folder / "city.glb", "-o", tmp_path / "old.vxs", "--resolution", 4096, "--memory", least - 1, status=6)
    assert done.stderr.startswith("vxs: error: --memory ") and "at least" in done.stderr and done.stderr.count("\n") == 1
    assert (tmp_path / "old.vxs").read_bytes() == b"old" and [p.name for p in tmp_path.iterdir()] == ["old.vxs"]


def test_what_is_held_is_watched(vxs, tmp_path):
    """The command itself is larger than this, and the scene too small to be counted first: no estimate is queried."""
    scene = small_scene.write(tmp_path / "small.gltf")
    done = vxs("bake", scene, "-o", tmp_path / "a.vxs", "--memory", "4M", status=6)
    assert "has come to hold" in done.stderr and done.stderr.count("\n") == 1 and not (tmp_path / "a.vxs").exists()


def test_a_scene_larger_than_the_budget_is_not_read(vxs, tmp_path):
    path = tmp_path / "large.glb"
    with open(path, "wb") as f:
        f.write(b"glTF")
        os.ftruncate(f.fileno(), 3 << 30)  # takes no room on the disk
    done = vxs("bake", path, "-o", tmp_path / "a.vxs", "--memory", "1G", status=6)
    assert "large.glb" in done.stderr and "--memory allows 1.00 GiB" in done.stderr and done.stderr.count("\n") == 1


# --- progress --------------------------------------------------------------------------------------------------------------------


def on_a_terminal(vxs_path, *args):
    """What a run writes to standard error, when that is a terminal."""
    ours, its = open_terminal()
    run = subprocess.Popen([vxs_path, *map(str, args)], stderr=its, stdout=subprocess.DEVNULL)
    os.close(its)
    said = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:  # the other side is closed
            break
        if not part:
            break
        said += part
    os.close(ours)
    assert run.wait() == 0
    return said.decode()


@pytest.mark.slow
def test_progress_is_one_line_that_goes_away(vxs_path, folder, tmp_path):
    start = time.monotonic()
    said = on_a_terminal(vxs_path, "bake", folder / "city.glb", "-o", tmp_path / "a.vxs", "--resolution", 8192, "--maps", "gl", "--memory", "150M")
    updates = said.count("\r\x1b[K")
    assert updates <= 20 + 10 * (time.monotonic() - start) and "\n" not in said
    assert said.endswith("\r\x1b[K"), "the line is gone at the end"
    shares = [int(n) for n in re.findall(r"vxs: (\d+) %: light sun: square \d+ of \d+", said)]
    assert len(shares) >= 2 and shares == sorted(shares) and shares[-1] <= 100


def test_warnings_stand_on_lines_of_their_own(vxs_path, folder, tmp_path):
    said = on_a_terminal(vxs_path, "bake", folder / "apart.gltf", "-o", tmp_path / "a.vxs", "--resolution", 64, "--color", "never")
    assert "\r\x1b[Kvxs: warning: light 'up' reaches no caster: it is left out; move it, " in said and said.count("\r\n") == 1


def test_no_progress_without_a_terminal(vxs, folder, tmp_path):
    assert vxs("bake", folder / "city.glb", "-o", tmp_path / "a.vxs", "--resolution", 1024).stderr == ""
