# vxs bake, info and validate as their users meet them: every option, every error.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import signal
import subprocess
import time

import pytest

import small_scene
from conftest import writes_into
from small_scene import BLOCK, GROUND, MORNING, NOON

SMALL = ("--resolution", 64)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("bake") / "small.gltf")


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    path = tmp_path_factory.mktemp("bake") / "city.glb"
    vxs("scene", "city", "-o", path, "--triangles", 5000, "--blocks", 2)
    return path


@pytest.fixture
def bake(vxs, tmp_path):
    """bake(scene, *options): the report, with the asset's path and bytes added."""

    def run(scene, *options):
        asset = tmp_path / "out.vxs"
        vxs("bake", scene, "-o", asset, "--json", tmp_path / "out.json", *options)
        report = json.loads((tmp_path / "out.json").read_text())
        return report | {"path": asset, "bytes": asset.read_bytes()}

    return run


@pytest.fixture
def fails(vxs, tmp_path):
    """fails(status, *args, says=...): one line on standard error, nothing on standard output, no file left behind."""

    def run(status, *args, says=""):
        before = sorted(tmp_path.iterdir())
        done = vxs(*args, status=status, input="")
        assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1 and done.stderr.endswith("\n")
        assert says in done.stderr
        assert done.stdout == ""
        assert sorted(tmp_path.iterdir()) == before
        return done.stderr

    return run


def lit(vxs, asset, *points, options=()):
    """The answers of vxs query, a list of columns for each point."""
    text = "".join(" ".join(map(str, p)) + "\n" for p in points)
    return [line.split() for line in vxs("query", asset, *options, input=text).stdout.splitlines()]


# --- what a bake gives ------------------------------------------------------------------------------------------------------


def test_shadow_lies_under_the_block(vxs, bake, scene):
    asset = bake(scene, *SMALL)["path"]
    assert lit(vxs, asset, (0, 0.5, 0), (3, 0.5, 0), (0, 4, 0), (0, -3, 0), (99, 0, 0)) == [["0"], ["1"], ["1"], ["0"], ["out"]]


def test_same_bytes_at_any_thread_count_and_every_time(bake, city):
    digests = {bake(city, "--resolution", 1024, "--threads", n)["bytes"] for n in (1, 2, 8, 1)}
    assert len(digests) == 1


def test_same_bytes_from_another_folder(vxs, bake, city, tmp_path, vxs_path):
    expected = bake(city, *SMALL)["bytes"]
    subprocess.run([vxs_path, "bake", city.name, "-o", tmp_path / "b.vxs", *map(str, SMALL)], cwd=city.parent, check=True,
                   capture_output=True)
    assert (tmp_path / "b.vxs").read_bytes() == expected


def test_output_to_standard_output(vxs_path, bake, city):
    done = subprocess.run([vxs_path, "bake", city, "-o", "-", "--verbose", *map(str, SMALL)], capture_output=True, check=True)
    assert done.stdout == bake(city, *SMALL)["bytes"]
    assert b"total" in done.stderr, "the report gives way to the asset"


def test_json_to_standard_output(vxs, scene, tmp_path):
    done = vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL, "--verbose", "--json", "-")
    assert json.loads(done.stdout)["file_bytes"] == (tmp_path / "a.vxs").stat().st_size
    assert "total" in done.stderr


def test_report_adds_up(bake, city):
    report = bake(city, "--resolution", 512)
    (light,) = report["lights"]
    assert report["file_bytes"] == len(report["bytes"])
    assert sum(level["stored_bytes"] for level in light["levels"]) == light["size"]["stored_bytes"] < report["file_bytes"]
    padding = light["size"]["memory_bytes"] - sum(level["memory_bytes"] for level in light["levels"])
    assert padding in (0, 4), "masks start at an even word"
    assert light["size"]["depth16_bytes"] == 2 * 512 * 512
    assert light["size"]["memory_bit_per_texel"] == pytest.approx(8 * light["size"]["memory_bytes"] / 512**2)
    assert report["casters"]["solids"]["triangles"] == report["casters"]["triangles"]
    assert sum(s["seconds"] for s in report["stages"]) <= report["total_seconds"]
    assert report["peak_bytes"] == max(s["peak_bytes"] for s in report["stages"]) > 0


def test_sizes_of_a_point_light_are_of_six_maps(vxs, bake, tmp_path):
    vxs("scene", "room", "-o", tmp_path / "room.glb")
    sizes = {light["name"]: light["size"] for light in bake(tmp_path / "room.glb", *SMALL)["lights"]}
    planned = json.loads(vxs("plan", tmp_path / "room.glb", *SMALL, "--json", "-").stdout)["lights"]
    assert {light["maps"] for light in planned} == {1, 6}
    for light in planned:
        texels, size = light["maps"] * 64 * 64, sizes[light["name"]]
        assert size["depth16_bytes"] == 2 * texels
        assert size["stored_bit_per_texel"] == pytest.approx(8 * size["stored_bytes"] / texels)



def test_report_for_people_names_every_stage(vxs, scene, tmp_path):
    text = vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL, "--verbose").stdout
    for word in ("casters", "light sun", "64 x 64 texels", "maps", "insert", "merge", "total", "bit/texel", "wrote"):
        assert word in text


def test_old_output_is_replaced(bake, scene, tmp_path):
    (tmp_path / "out.vxs").write_bytes(b"old")
    assert bake(scene, *SMALL)["bytes"] != b"old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.json", "out.vxs"]


# --- lights -------------------------------------------------------------------------------------------------------------------

LIGHTS = (("noon", "directional", NOON), ("lamp", "spot", NOON), ("morning", "directional", MORNING), ("bulb", "point", NOON))
UNDER, BESIDE = (0, 0.5, 0), (2, 0.5, 0)  # beside: the morning's shadow, 1.5 to 2.5 m to the side of what casts it


@pytest.fixture(scope="module")
def lights(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("lights") / "lights.gltf", lights=LIGHTS)


@pytest.mark.parametrize("options, names", [
    ((), ["noon", "lamp", "morning", "bulb"]),
    (("--light", "lamp"), ["lamp"]),
    (("--light", "bulb", "--sun", "1,-1,0"), ["bulb", "sun"]),
    (("--light", "morning"), ["morning"]),
    (("--light", "morning", "--light", "noon"), ["morning", "noon"]),
    (("--sun", "1,-1,0"), ["sun"]),
    (("--sun=1,-1,0", "--light=noon"), ["noon", "sun"]),
    (("--light", "sun", "--light", "noon", "--sun", "1,-1,0"), ["sun", "noon"]),
])
def test_lights(vxs, bake, lights, options, names):
    report = bake(lights, *SMALL, *options)
    assert [light["name"] for light in report["lights"]] == names
    expected = {"noon": "01", "morning": "10", "sun": "10", "lamp": "01", "bulb": "01"}
    under, beside = lit(vxs, report["path"], UNDER, BESIDE)
    assert ["".join(pair) for pair in zip(under, beside)] == [expected[name] for name in names]


def test_direction_is_the_way_the_light_travels(bake, lights):
    report = bake(lights, *SMALL, "--sun", "0,-3,4")
    assert report["lights"][0]["direction"] == pytest.approx([0, -0.6, 0.8])


def test_sun_takes_the_place_of_the_scenes_own(bake, scene):
    report = bake(scene, *SMALL, "--sun", "1,-1,0")
    assert [light["name"] for light in report["lights"]] == ["sun"]
    assert report["lights"][0]["direction"] == pytest.approx([0.5**0.5, -0.5**0.5, 0])


@pytest.mark.parametrize("options, status, says", [
    (("--light", "nobody"), 2, "noon (directional, node 1), lamp (spot, node 2)"),
    (("--light", "noon", "--light", "noon"), 2, "twice"),
    (("--sun", "0,0,0"), 2, "not zero"),
    (("--sun", "1,2"), 2, "3 numbers"),
    (("--sun", "1,2,3,4"), 2, "3 numbers"),
    (("--sun", "1,2,nan"), 2, "3 numbers"),
])
def test_wrong_lights(fails, lights, tmp_path, options, status, says):
    fails(status, "bake", lights, "-o", tmp_path / "a.vxs", *SMALL, *options, says=says)


def test_scene_without_a_light(fails, tmp_path):
    dark = small_scene.write(tmp_path / "dark.gltf", lights=())
    fails(5, "bake", dark, "-o", tmp_path / "a.vxs", says="--sun")
    fails(2, "bake", dark, "-o", tmp_path / "a.vxs", "--light", "sun", says="no lights")


REMEDY = "; move it, turn it, give it a longer range, or leave it out with --light"


def test_lights_that_reach_nothing_are_left_out(bake, fails, vxs, tmp_path):
    """A lamp that shines up into the sky."""
    up = small_scene.write(tmp_path / "up.gltf", lights=(("up", "spot", (0, 1, 0)), ("noon", "directional", NOON)))
    report = bake(up, *SMALL)
    assert [light["name"] for light in report["lights"]] == ["noon"]
    assert report["lights_left_out"] == [{"name": "up", "why": "reaches no caster"}]
    said = vxs("bake", up, "-o", tmp_path / "a.vxs", *SMALL).stderr
    assert said == f"vxs: warning: light 'up' reaches no caster: it is left out{REMEDY}\n"
    fails(1, "bake", up, "-o", tmp_path / "b.vxs", *SMALL, "--strict", says=f"light 'up' reaches no caster: it is left out{REMEDY} (--strict")
    fails(5, "bake", up, "-o", tmp_path / "b.vxs", *SMALL, "--light", "up", says="no light reaches a caster")


# --- the map ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("resolution", [8, 16, 512, 8192])
def test_resolution(vxs, bake, scene, resolution):
    report = bake(scene, "--resolution", resolution)
    assert report["lights"][0]["resolution_px"] == resolution
    assert lit(vxs, report["path"], (0, -5, 0), (5, 6, 0)) == [["0"], ["1"]], "at two voxels from everything, however coarse"


@pytest.mark.parametrize("texel, resolution", [(1, 32), (0.5, 64), (0.26, 64), (16, 8)])
def test_texel(bake, scene, texel, resolution):
    (light,) = bake(scene, "--texel", texel)["lights"]
    assert (light["resolution_px"], light["texel_m"]) == (resolution, texel)


def test_region(vxs, bake, scene):
    report = bake(scene, *SMALL, "--region", "-2,0,-2,2,4,2")
    assert report["lights"][0]["texel_m"] == pytest.approx(4 / 62)
    assert lit(vxs, report["path"], (0, 0.5, 0), (1.5, 0.5, 0), (3, 0.5, 0)) == [["0"], ["1"], ["out"]]


def test_casters_outside_of_the_region_still_cast(vxs, bake, scene):
    asset = bake(scene, *SMALL, "--region", "-2,0,-2,2,1,2")["path"]
    assert lit(vxs, asset, (0, 0.5, 0), (1.5, 0.5, 0)) == [["0"], ["1"]]


@pytest.mark.parametrize("options, says", [
    (("--resolution", "1000"), "power of two"),
    (("--resolution", "4"), "from 8 to 262144"),
    (("--resolution", "524288"), "from 8 to 262144"),
    (("--resolution", "-64"), "from 8 to 262144"),
    (("--resolution", "64.5"), "whole number"),
    (("--resolution", "many"), "whole number"),
    (("--resolution", ""), "whole number"),
    (("--texel", "0"), "a number from"),
    (("--texel", "inf"), "a number from"),
    (("--texel", "0.00001"), "at least --texel"),
    (("--texel", "1", "--resolution", "64"), "exclude"),
    (("--region", "0,0,0,1,1"), "6 numbers"),
    (("--region", "0,0,0,1,0,1"), "axis y"),
    (("--threads", "0"), "from 1 to"),
    (("--level", "0"), "from 1 to 19"),
    (("--level", "20"), "from 1 to 19"),
    (("--maps", "dense"), "auto|gl|sparse"),
    (("--gl", "glx"), "osmesa|egl"),
    (("--exit", "front"), "auto|peel|back"),
    (("--closed", "maybe"), "auto|on|off"),
    (("--rule", "golden"), "greedy|shadow"),
    (("--reuse", "yes"), "off|on"),
    (("--compress", "sideways"), "top-down|bottom-up"),
    (("--stop", "early"), "insert|partial|final"),
    (("--coding", "octree"), "dag|blocks"),
    (("--pack", "tight"), "small|fast"),
    (("--coding", "dag", "--pack", "fast"), "needs --coding blocks"),
    (("--pack", "small", "--coding", "dag"), "needs --coding blocks"),
    (("--rule", "greedy"), "need --coding dag"),
    (("--coding", "blocks", "--stop", "insert"), "need --coding dag"),
    (("--coding", "blocks", "--rule", "shadow"), "need --coding dag"),
    (("--coding", "blocks", "--reuse", "on"), "need --coding dag"),
    (("--compress", "auto", "--coding", "blocks"), "need --coding dag"),
    (("--scene", "other"), "small"),
    (("--scene", "1"), "small"),
    (("--frobnicate",), "unknown option"),
    (("-x",), "unknown option"),
    (("--resolution",), "needs a value"),
    (("another.glb",), "unexpected argument"),
])
def test_wrong_options(fails, scene, tmp_path, options, says):
    fails(2, "bake", scene, "-o", tmp_path / "a.vxs", *options, says=says)


def test_wrong_command_lines(fails, scene):
    fails(2, "toast", says="unknown command 'toast'")
    fails(2, "bake", scene, says="-o OUT.vxs")
    fails(2, "bake", "-o", "a.vxs", says="SCENE is missing")
    fails(2, "bake", scene, "-o", says="needs a value")
    fails(2, "bake", scene, "-o", "-", "--json", "-", says="exclude")
    fails(2, "info", says="FILE.vxs is missing")
    fails(2, "validate", "a.vxs", "b.vxs", says="unexpected argument 'b.vxs'")


# --- solids, exits, and how the DAG is built: the same answers, other sizes -----------------------------------------------------


def test_closed(tmp_path, bake, scene):
    def solids(path, *options):
        casters = bake(path, *SMALL, *options)["casters"]
        return casters["solids"]["components"], {k: v["components"] for k, v in casters["sheets"].items() if v["components"]}

    two_sided = small_scene.write(tmp_path / "two.gltf", doubleSided=True)
    torn = small_scene.write(tmp_path / "open.gltf", open_faces=True)
    assert solids(scene) == (2, {})
    assert solids(scene, "--closed", "auto") == (2, {})
    assert solids(scene, "--closed", "off") == (0, {"forced": 2})
    assert solids(two_sided) == (0, {"double sided": 2})
    assert solids(two_sided, "--closed", "on") == (2, {})
    assert solids(torn) == solids(torn, "--closed", "on") == (0, {"open": 2})


def stored(report):
    return report["lights"][0]["size"]["stored_bytes"]


def test_exit(bake, city):
    peel, auto, back = (bake(city, "--resolution", 512, "--maps", "gl", "--exit", e) for e in ("peel", "auto", "back"))
    assert stored(auto) == stored(peel) < stored(back), "a nearer exit leaves less to choose"
    assert auto["lights"][0]["peel_passes"] > back["lights"][0]["peel_passes"]


def contents(vxs, report):
    """The bytes of all sections but the metadata, which say what was requested."""
    report["path"].write_bytes(report["bytes"])
    sections = json.loads(vxs("info", report["path"], "--json", "-").stdout)["sections"]
    return b"".join(report["bytes"][s["offset_bytes"]:s["offset_bytes"] + s["stored_bytes"]] for s in sections
                    if s["kind"] != "metadata")


@pytest.mark.slow
def test_solids_that_meet_nothing_are_not_peeled(vxs, bake, scenes, tmp_path):
    apart = small_scene.write(tmp_path / "apart.gltf", lights=LIGHTS)
    for path, options in ((apart, ()), (scenes / "real" / "room_with_spheres_closed.glb", ("--sun", "-0.4,-1,-0.2"))):
        auto, peel = (bake(path, "--resolution", 4096, *options, "--maps", "gl", "--exit", e) for e in ("auto", "peel"))
        for light in auto["lights"]:
            assert (light["blocks_peeled"], light["peel_passes"]) == (0, 0) and light["blocks_not_peeled"] > 0
        for light in peel["lights"]:
            assert light["blocks_not_peeled"] == 0 and light["peel_passes"] >= light["blocks_peeled"] > 0
        assert contents(vxs, auto) == contents(vxs, peel)


DAG = ("--coding", "dag", "--resolution", 512)


def test_rule(bake, city):
    assert bake(city, *DAG)["lights"][0]["mask_runs"] < bake(city, *DAG, "--rule", "shadow")["lights"][0]["mask_runs"]


def test_reuse(bake, city):
    on, off = (bake(city, *DAG, "--reuse", r) for r in ("on", "off"))
    assert on["lights"][0]["inserted_nodes"] < off["lights"][0]["inserted_nodes"]
    assert on["bytes"] == off["bytes"], "compression finds what insertion did not"


def test_compress(bake, city):
    top, bottom = (bake(city, *DAG, "--compress", c) for c in ("top-down", "bottom-up"))
    counts = [[level["count"] for level in report["lights"][0]["levels"]] for report in (top, bottom)]
    assert counts[0] == counts[1], "both find the least number of nodes"


def test_stop(bake, city):
    insert, partial, final = (bake(city, *DAG, "--stop", s) for s in ("insert", "partial", "final"))
    nodes = [sum(level["count"] for level in r["lights"][0]["levels"]) for r in (insert, partial, final)]
    assert nodes[0] > nodes[1] > nodes[2]


def test_level(bake, city):
    assert stored(bake(city, *DAG, "--level", 1)) > stored(bake(city, *DAG, "--level", 19))


@pytest.mark.parametrize("options", [
    ("--maps", "gl"), ("--maps", "sparse"), ("--maps", "sparse", "--exit", "back"), ("--exit", "back"), ("--closed", "off"), ("--level", 1),
    ("--scene", "small"), ("--scene", 0), ("--coding", "blocks"),
    ("--pack", "fast"), *(("--coding", "dag", *step) for step in ((), ("--rule", "shadow"), ("--reuse", "off"), ("--compress", "bottom-up"),
                                              ("--stop", "insert"), ("--stop", "partial"))),
])
def test_no_option_changes_an_answer(vxs, bake, scene, options):
    points = [(x / 2, y, z / 2) for x in range(-9, 10, 3) for y in (0.5, 4) for z in range(-9, 10, 3)]
    assert lit(vxs, bake(scene, *SMALL, *options)["path"], *points) == [
        ["0" if y < 2 and max(abs(x), abs(z)) < 1 else "1"] for x, y, z in points]


def test_egl_gives_the_same_answers(vxs, vxs_path, bake, scene, tmp_path):
    done = subprocess.run([vxs_path, "bake", scene, "-o", tmp_path / "egl.vxs", "--gl", "egl", "--resolution", "64"],
                          capture_output=True, text=True)
    if done.returncode == 6:
        assert done.stderr.count("\n") == 1 and not (tmp_path / "egl.vxs").exists()
        pytest.skip(f"no EGL here: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    assert lit(vxs, tmp_path / "egl.vxs", (0, 0.5, 0), (3, 0.5, 0)) == [["0"], ["1"]]


# --- files that are not what they should be --------------------------------------------------------------------------------------


def test_scenes_that_cannot_be_read(fails, tmp_path):
    (tmp_path / "empty.glb").write_bytes(b"")
    (tmp_path / "text.gltf").write_text("no glTF")
    (tmp_path / "folder.glb").mkdir()
    out = ("-o", tmp_path / "a.vxs")
    fails(3, "bake", tmp_path / "nobody.glb", *out, says="nobody.glb': No such file")
    fails(3, "bake", tmp_path / "folder.glb", *out, says="folder.glb' is a folder, expected a glTF scene")
    fails(3, "bake", tmp_path / "empty.glb", *out, says="empty.glb")
    fails(3, "bake", tmp_path / "text.gltf", *out, says="text.gltf")


def test_scene_without_triangles(fails, tmp_path):
    fails(5, "bake", small_scene.write(tmp_path / "none.gltf", boxes=()), "-o", tmp_path / "a.vxs", says="triangle")


def test_scene_that_is_flat(vxs, bake, tmp_path):
    flat = small_scene.write(tmp_path / "flat.gltf", boxes=(((-1, 0, -1), (1, 0, 1)),))
    assert lit(vxs, bake(flat, *SMALL)["path"], (0, 1, 0), (0, -1, 0)) == [["1"], ["0"]]


def test_outputs_that_cannot_be_written(fails, scene, tmp_path):
    (tmp_path / "folder").mkdir()
    fails(4, "bake", scene, "-o", tmp_path / "nobody" / "a.vxs", *SMALL, says="its folder is not there")
    fails(4, "bake", scene, "-o", tmp_path / "folder", *SMALL, says="folder")
    fails(4, "bake", scene, "-o", "", *SMALL, says="empty")
    fails(4, "bake", scene, "-o", "/dev/full", *SMALL, says="No space left")


def test_an_unwritable_output_is_told_before_the_work(fails, scene, tmp_path):
    out = tmp_path / "a.vxs"
    fails(4, "bake", tmp_path / "nobody.glb", "-o", tmp_path / "nobody" / "a.vxs", says="a.vxs")  # not the missing scene
    fails(4, "bake", scene, "-o", out, *SMALL, "--json", tmp_path / "nobody" / "a.json", says="a.json")
    assert not out.exists()


def test_the_scene_is_never_overwritten(fails, tmp_path):
    scene = small_scene.write(tmp_path / "own.gltf")
    before = scene.read_bytes()
    fails(2, "bake", scene, "-o", scene, *SMALL, says="input itself")
    fails(2, "bake", scene, "-o", tmp_path / "a.vxs", "--json", scene, *SMALL, says="input itself")
    assert scene.read_bytes() == before


def test_outputs_are_two_files(fails, scene, tmp_path):
    fails(2, "bake", scene, "-o", tmp_path / "a", "--json", tmp_path / "a", *SMALL, says="two names")


def test_a_region_without_size_in_numbers(vxs, scene, tmp_path):
    done = vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL, "--region", "1e300,1e300,1e300,1.1e300,1.1e300,1.1e300", status=2)
    assert done.stderr.splitlines()[-1].startswith("vxs: error: --region spans ") and not list(tmp_path.iterdir())


def test_the_report_says_what_was_left_out(bake, tmp_path):
    lights = (("sun", "directional", NOON), ("lamp", "spot", NOON), ("moon", "directional", MORNING))
    scene = small_scene.write(tmp_path / "lights.gltf", lights=lights)
    assert bake(scene, *SMALL)["lights_left_out"] == []
    assert bake(scene, *SMALL, "--light", "moon")["lights_left_out"] == [
        {"name": "sun", "why": "not requested"}, {"name": "lamp", "why": "not requested"}]


def test_the_report_counts_tiles_without_casters(bake, tmp_path):
    far = ((600, 0, 0), (601, 1, 1))  # two small boxes in opposite tiles of a map of 2 x 2
    scene = small_scene.write(tmp_path / "far.gltf", boxes=(((0, 0, 600), (1, 1, 601)), far))
    light = bake(scene, "--resolution", 8192, "--maps", "gl")["lights"][0]
    assert light["tiles"] == 4 and light["tiles_without_casters"] == 2


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_output_folder_that_may_not_be_written(fails, scene, tmp_path):
    tmp_path.chmod(0o555)
    fails(4, "bake", scene, "-o", tmp_path / "a.vxs", *SMALL, says="Permission denied")


@pytest.mark.parametrize("command", [("bake",), ("info",), ("validate",), ("query",), ("bake", "--help"), ("--help",), ("--version",)])
def test_full_standard_output(vxs, vxs_path, bake, scene, tmp_path, command):
    asset = bake(scene, *SMALL)["path"]
    operands = {("bake",): [scene, "-o", "-", "--resolution", "64"], ("info",): [asset], ("validate",): [asset],
                ("query",): [asset]}.get(command, [])
    with open("/dev/full", "wb") as full:
        done = subprocess.run([vxs_path, *command, *operands], stdout=full, stderr=subprocess.PIPE, input=b"0 0 0\n")
    assert done.returncode == 4 and b"standard output" in done.stderr and done.stderr.count(b"\n") == 1


def test_failure_keeps_the_old_output(vxs, scene, tmp_path):
    old = tmp_path / "a.vxs"
    old.write_bytes(b"old")
    for options in (("--resolution", 1000), ("--light", "nobody"), ("--scene", "nobody")):
        vxs("bake", scene, "-o", old, *options, status=2)
    vxs("bake", tmp_path / "nobody.glb", "-o", old, status=3)
    assert old.read_bytes() == b"old" and list(tmp_path.iterdir()) == [old]


@pytest.mark.parametrize("number, status", [(signal.SIGINT, 130), (signal.SIGTERM, -signal.SIGTERM)])
@pytest.mark.parametrize("command", [
    ("bake", "city.glb", "-o", "a.vxs", "--resolution", "262144"),
    ("scene", "city", "-o", "a.glb", "--triangles", "5000000", "--blocks", "64"),
    ("render", "city.glb", "city.vxs", "-o", "a.png", "--draw", "rays", "--width", "8192", "--height", "8192"),
    ("query", "city.vxs"),
], ids=lambda command: command[0])
def test_interrupt_leaves_nothing(vxs, vxs_path, bake, city, tmp_path, command, number, status):
    bake(city, *SMALL)["path"].rename(tmp_path / "city.vxs")
    (tmp_path / "city.glb").write_bytes(city.read_bytes())
    before = sorted(tmp_path.iterdir())
    with subprocess.Popen([vxs_path, *command], cwd=tmp_path, stdin=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
        if command[0] in ("scene", "render"):
            while not writes_into(process, tmp_path):  # the signal is to find a file to remove
                assert process.poll() is None
                time.sleep(0.002)
        else:
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(0.3)
        process.send_signal(number)
        assert process.wait(20) == status
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("command", ["bake", "scene", "render", "info"])
def test_reader_of_an_output_that_has_gone_away(vxs_path, bake, city, command):
    """What was to be written is not: an error. Of reports and answers, test_terminal.py has it."""
    asset = bake(city, *SMALL)["path"]
    operands = {"bake": [city, "-o", "-", *SMALL], "scene": ["city", "-o", "-"], "info": [asset, "--json", "-"],
                "render": [city, asset, "-o", "-", "--width", 64, "--height", 64]}[command]
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([vxs_path, command, *map(str, operands)], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert done.returncode == 4 and b"standard output" in done.stderr and done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("name", ["sponza.glb", "skylight_hall_directional.glb", "features/00_no_scenes/00_no_scenes.gltf"])
def test_real_scenes(bake, scenes, name):
    path = scenes / "real" / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    report = bake(path, "--resolution", 512, "--sun", "-0.4,-1,-0.2")
    assert report["file_bytes"] > 500


# --- info and validate ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def asset(vxs, lights, tmp_path_factory):
    path = tmp_path_factory.mktemp("asset") / "lights.vxs"
    vxs("bake", lights, "-o", path, *SMALL)
    return path


def test_info(vxs, asset):
    text = vxs("info", asset).stdout
    for word in ("4 lights", "light noon: directional", "light morning", "64 x 64 texels", "masks", "metadata", "made by      vxs "):
        assert word in text


def test_info_json(vxs, asset, tmp_path):
    vxs("info", asset, "--json", tmp_path / "info.json")
    info = json.loads((tmp_path / "info.json").read_text())
    assert info == json.loads(vxs("info", asset, "--json", "-").stdout)
    assert info["file_bytes"] == asset.stat().st_size == max(s["offset_bytes"] + s["stored_bytes"] for s in info["sections"])
    assert [light["name"] for light in info["lights"]] == ["noon", "lamp", "morning", "bulb"]
    assert info["metadata"]["options"]["closed"] == "auto"


def test_validate(vxs, asset):
    assert vxs("validate", asset).stdout == f"{asset}: valid\n"
    assert json.loads(vxs("validate", asset, "--json", "-").stdout) == {"file": str(asset), "valid": True, "findings": []}


def broken(asset, tmp_path, kind):
    data = bytearray(asset.read_bytes())
    if kind == "empty":
        data = b""
    elif kind == "not":
        data = b"glTF" + data[4:]
    elif kind == "truncated":
        data = data[:-1]
    elif kind == "longer":
        data += b"\0"
    else:
        data[kind] ^= 1
    path = tmp_path / "broken.vxs"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("kind, number", [("empty", 101), ("not", 102), ("truncated", 106), ("longer", 107), (8, 103), (40, None),
                                          (70, None), (-1, None)])
def test_broken_assets(vxs, fails, asset, tmp_path, kind, number):
    path = broken(asset, tmp_path, kind)
    found = vxs("validate", path, "--json", "-", status=1)
    report = json.loads(found.stdout)
    assert not report["valid"] and report["findings"] and found.stderr == ""
    if number:
        assert report["findings"][0]["number"] == number
    assert f"finding {report['findings'][0]['number']}:" in vxs("validate", path, status=1).stdout
    for command in (("info", path), ("query", path)):
        assert "broken.vxs" in fails(3, *command, says="finding")


def test_assets_that_cannot_be_read(fails, tmp_path):
    for command in ("info", "validate", "query"):
        fails(3, command, tmp_path / "nobody.vxs", says="No such file")
        fails(3, command, tmp_path, says="is a folder, expected a .vxs file")


def test_json_that_cannot_be_written(vxs, asset, scene, tmp_path):
    for command in (("info", asset), ("validate", asset), ("bake", scene, "-o", tmp_path / "a.vxs", *SMALL)):
        for where in ("/dev/full", tmp_path / "nobody" / "a.json", tmp_path):
            done = vxs(*command, "--json", where, status=4)
            assert done.stderr.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["a.vxs"], "the asset was complete, and stays"


def test_names_that_are_not_utf8(vxs_path, scene, tmp_path):
    folder = os.fsencode(tmp_path)
    asset, report = folder + b"/\xff.vxs", folder + b"/r.json"
    subprocess.run([vxs_path, "bake", scene, "-o", asset, "--resolution", "64", "--json", report], check=True, capture_output=True)
    assert json.loads(pathlib.Path(os.fsdecode(report)).read_text())["output"].endswith("/?.vxs")
    for command in ("info", "validate"):
        done = subprocess.run([vxs_path, command, asset, "--json", "-"], check=True, capture_output=True)
        assert json.loads(done.stdout)["file"].endswith("/?.vxs")


# --- help ---------------------------------------------------------------------------------------------------------------------------


def test_help_and_version(vxs):
    text = vxs("--help").stdout
    for command in ("bake", "info", "validate", "query", "truth", "compare", "render", "scene"):
        assert f"\n  {command} " in text
        assert vxs(command, "--help").stdout.startswith(f"vxs {command} ") and vxs(command, "-h").returncode == 0
    header = (pathlib.Path(__file__).parents[2] / "runtime" / "vxs.h").read_text()
    numbers = [line.split()[2] for line in header.splitlines() if line.startswith("#define VXS_VERSION_") and "NUMBER" not in line]
    assert vxs("--version").stdout == f"vxs {'.'.join(numbers)}\n"
