# The contract of an asset, voxel by voxel: tests/exact/exact.c bakes, finds the depths again, and compares.
# EXACT: that program (default tests/exact/exact beside the command, where the Makefile puts it).
# SPDX-License-Identifier: GPL-3.0-or-later
import itertools
import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = pathlib.Path(os.environ.get("VXS_SCENES", ROOT.parent / "shared" / "scenes")) / "real"

SUNS = ["0.3,-1,0.2", "-1,-0.25,0.6"]
RULES = ["greedy", "shadow"]
STOPS = ["insert", "partial", "final"]
CODINGS = ["dag", "blocks"]
COLUMNS = int(os.environ.get("VXS_COLUMNS", 100000))
SIDE = int(os.environ.get("VXS_SIDE", 256))  # texels of maps whose every voxel is queried; make check-exact: 512
EVERY = "VXS_SIDE" in os.environ  # every test queries every scene; else each scene is queried by one of those that query many, and two by all
FREE = ["free,0", "shadow,0.2", "free,0.02"]
GENERATED = ["city", "landscape"]

# spots of 1, 60, 120 and 179 degrees, the last of six maps, one that ends, and a point light; in shares of the scene's box
LAMPS = ["--spot", "0.45,1.6,0.55,0.02,-1,-0.03,1", "--spot", "0.2,1.4,0.3,0.3,-1,0.2,60", "--spot", "0.43,0.9,0.52,0.2,-1,0.3,120",
         "--spot", "0.57,0.8,0.44,-0.2,-1,0.1,179", "--spot", "0.52,0.5,0.48,1,-0.3,0.4,60,0.6", "--point", "0.47,0.55,0.53"]

# what no option makes loadable, and the exit status that reports it: no triangle
REFUSED = {
    "features/00_empty_scene/00_empty_scene.gltf": 5,
    "features/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf": 5,
    "features/mesh_without_node.gltf": 5,
}
FOUND = sorted(str(p.relative_to(SCENES)) for p in SCENES.rglob("*.gl*") if p.suffix in (".glb", ".gltf"))
LOADABLE = [name for name in FOUND if name not in REFUSED]
EVERY_OPTION = GENERATED + [
    "sponza.glb",
    "kaykit_city.glb",
    "japanese_bridge_garden.glb",
    "features/subpass_scene_mirrored.gltf",
]
FINE = GENERATED + [name for name in LOADABLE if "/" not in name and (EVERY or name == "kaykit_city.glb")]


def share(n):
    """Scenes for the nth of the four tests that query many: what is generated, and an eighth of the others."""
    return GENERATED + [pytest.param(name, marks=pytest.mark.slow) for name in LOADABLE if EVERY or LOADABLE.index(name) % 8 == 2 * n]


# the quickest of them, one whose transforms mirror; make check-exact does each option with each
SOME_SHARED = [pytest.param(name, marks=pytest.mark.slow) for name in EVERY_OPTION
               if name not in GENERATED and (EVERY or name == EVERY_OPTION[-1])]
FAULTS = ["depth", "tile", "square", "mask", "until", "inserted", "compressed", "merged", "word"]


@pytest.fixture(scope="session")
def exact(vxs_path):
    """run(scene, *options, status=0, **choices): the counts of one run, whose exit status is checked: a list, one for each combination of
    choices, which are lists of values of an option."""
    path = (ROOT / os.environ.get("EXACT", vxs_path.parent / "tests" / "exact" / "exact")).resolve()
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it, or set EXACT")

    def run(scene, *options, status=0, **choices):
        chosen = [word for name, values in choices.items() for value in values for word in (f"--{name}", value)]
        done = subprocess.run([path, scene, *map(str, [*options, *chosen])], capture_output=True, text=True, timeout=300)
        found = f"status {done.returncode}, expected {status}: {done.stdout}{done.stderr}"
        assert done.returncode == status, f"{options} {choices}: {found}"
        counts = [json.loads(line) for line in done.stdout.splitlines()]
        if status in (0, 1):
            asked = itertools.product(*([numbers(v) if name == "sun" else v for v in values] for name, values in choices.items()))
            assert sorted(tuple(c[name] for name in choices) for c in counts) == sorted(asked), "each combination once"
        return counts

    return run


def numbers(text):
    return [float(number) for number in text.split(",")]


@pytest.fixture(scope="session")
def scene(vxs, tmp_path_factory):
    """The path of a scene by name: generated, or one of the shared ones."""
    folder = tmp_path_factory.mktemp("generated")

    def find(name):
        if name in GENERATED:
            path = folder / f"{name}.glb"
            if not path.exists():
                vxs("scene", name, "--triangles", 20000, "-o", path)
            return path
        if not (SCENES / name).is_file():
            pytest.skip(f"no shared scene {SCENES / name}: set VXS_SCENES")
        return SCENES / name

    return find


def assert_complete(found, resolution):
    """Of lamps all maps but those, of one map each, that may reach nothing."""
    for counts in found:
        maps, side = counts["maps"], counts["resolution"]
        assert maps == 1 if any(counts["sun"]) else 13 <= maps <= 16
        assert side == resolution and counts["columns"] == maps * side**2 and counts["voxels"] == maps * side**3


@pytest.mark.parametrize("name", share(0))
def test_every_voxel_of_every_scene_straight_from_triangles(exact, scene, name):
    assert_complete(exact(scene(name), "--maps", "sparse", "--resolution", SIDE // 2, sun=SUNS, coding=CODINGS), SIDE // 2)
    assert_complete(exact(scene(name), "--maps", "sparse", *LAMPS, "--resolution", 64, coding=CODINGS), 64)


@pytest.mark.parametrize("name", GENERATED + SOME_SHARED)
def test_every_voxel_straight_from_triangles_whatever_is_solid(exact, scene, name):
    assert_complete(exact(scene(name), "--maps", "sparse", "--sun", SUNS[1], "--resolution", 128, closed=["on", "off"],
                          exit=["peel", "back"], coding=CODINGS), 128)


def test_tiles_around_silhouettes(exact, scene):
    """make check-sparse does so at 262144."""
    few = "--maps", "sparse", "--sun", SUNS[0], "--resolution", 4096, "--columns", 640
    random, = exact(scene("city"), *few)
    counts, = exact(scene("city"), *few, "--silhouettes", 3)
    assert random["columns"] == 640 and counts["columns"] > 640 + 9 * 64 and counts["voxels"] == 4096 * counts["columns"]
    assert 18 * counts["columns"] < counts["lookups"] <= 32 * counts["columns"]
    counts, = exact(scene("city"), *few, "--silhouettes", 3, "--fault", "word", status=1)
    assert counts["wrong_lit"] + counts["wrong_shadow"] > 0
    for refused in (("--maps", "sparse", "--silhouettes", 3), ("--maps", "gl", "--columns", 640, "--silhouettes", 3)):
        assert exact(scene("city"), "--sun", SUNS[0], *refused, status=2) == []


@pytest.mark.parametrize("name", GENERATED + SOME_SHARED)
def test_every_voxel_where_more_is_left_free(exact, scene, name):
    assert_complete(exact(scene(name), "--maps", "sparse", "--sun", SUNS[1], "--resolution", SIDE // 2, free=FREE,
                          closed=["auto", "off"], coding=CODINGS), SIDE // 2)
    assert_complete(exact(scene(name), "--maps", "sparse", *LAMPS, "--closed", "off", "--resolution", 64, free=FREE, coding=CODINGS), 64)


def test_a_wrong_word_of_a_file_straight_from_triangles_is_seen(exact, scene):
    counts, = exact(scene("city"), "--maps", "sparse", "--sun", SUNS[0], "--fault", "word", status=1)
    assert counts["wrong_lit"] + counts["wrong_shadow"] > 0
    assert exact(scene("city"), "--maps", "sparse", "--sun", SUNS[0], "--fault", "depth", status=2) == []


@pytest.mark.skipif(not FOUND, reason=f"no shared scenes at {SCENES}: set VXS_SCENES")
@pytest.mark.parametrize("name", share(1))
def test_every_voxel_of_every_scene(exact, scene, name):
    assert_complete(exact(scene(name), "--resolution", SIDE, sun=SUNS, coding=CODINGS), SIDE)


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_refused_scenes_say_so(exact, scene, name):
    assert exact(scene(name), "--sun", SUNS[0], status=REFUSED[name]) == []


@pytest.mark.parametrize("name", share(2))
def test_every_voxel_after_every_stage_with_each_rule(exact, scene, name):
    suns = SUNS if name in EVERY_OPTION else SUNS[:1]
    assert_complete(exact(scene(name), "--resolution", SIDE, sun=suns, stop=STOPS, rule=RULES), SIDE)


@pytest.mark.parametrize("name", GENERATED + SOME_SHARED)
def test_every_voxel_without_reuse_and_compressed_either_way(exact, scene, name):
    assert_complete(exact(scene(name), "--sun", SUNS[0], "--resolution", SIDE, reuse=["on", "off"], compress=["top-down", "bottom-up"],
                          stop=["partial", "final"]), SIDE)


@pytest.mark.parametrize("name", GENERATED + SOME_SHARED)
def test_every_voxel_whatever_is_solid(exact, scene, name):
    assert_complete(exact(scene(name), "--sun", SUNS[1], "--resolution", SIDE, closed=["on", "off"], exit=["peel", "back"],
                          coding=CODINGS), SIDE)


@pytest.mark.parametrize("name", GENERATED + SOME_SHARED)
def test_every_voxel_of_suns_along_an_axis(exact, scene, name):
    assert_complete(exact(scene(name), "--resolution", 256, sun=["0,-1,0", "1,0,0", "0,0.001,-1"], coding=CODINGS), 256)


@pytest.mark.parametrize("name", GENERATED)
def test_every_voxel_at_every_resolution(exact, scene, name):
    for counts in exact(scene(name), sun=SUNS, resolution=[8, 16, 32, 64, 128, 2 * SIDE], coding=CODINGS):
        assert_complete([counts], counts["resolution"])


@pytest.mark.slow
@pytest.mark.parametrize("name", FINE)
def test_columns_at_4096(exact, scene, name):
    """A tenth of the million that make check-exact queries."""
    for counts in exact(scene(name), "--sun", SUNS[0], "--resolution", 4096, "--columns", COLUMNS, coding=CODINGS):
        assert counts["columns"] == COLUMNS and counts["voxels"] > 20 * COLUMNS


@pytest.mark.slow
def test_several_map_tiles(exact, scene):
    """8192 texels are four tiles that are rendered one by one."""
    for counts in exact(scene("city"), "--sun", SUNS[1], "--resolution", 8192, "--columns", 4 * COLUMNS, coding=CODINGS):
        assert counts["columns"] == 4 * COLUMNS


@pytest.mark.parametrize("name", share(3))
def test_every_voxel_of_punctual_lights_in_every_scene(exact, scene, name):
    assert_complete(exact(scene(name), *LAMPS, "--resolution", 128, coding=CODINGS), 128)


@pytest.mark.parametrize("name", GENERATED + SOME_SHARED)
def test_every_voxel_of_fine_lamps(exact, scene, name):
    assert_complete(exact(scene(name), *LAMPS, "--resolution", SIDE, coding=CODINGS), SIDE)


@pytest.mark.slow
@pytest.mark.parametrize("name", GENERATED[:1] + (SOME_SHARED if EVERY else []))
def test_every_voxel_of_punctual_lights_after_every_stage_with_each_rule(exact, scene, name):
    assert_complete(exact(scene(name), *LAMPS, "--resolution", 256, stop=STOPS, rule=RULES), 256)
    assert_complete(exact(scene(name), *LAMPS, "--resolution", 256, closed=["on", "off"], exit=["peel", "back"]), 256)


@pytest.mark.slow
def test_every_voxel_of_punctual_lights_at_every_resolution(exact, scene):
    for counts in exact(scene("city"), *LAMPS, resolution=[8, 16, 32, 64, 2 * SIDE], coding=CODINGS):
        assert_complete([counts], counts["resolution"])


@pytest.mark.slow
@pytest.mark.long
def test_columns_of_fine_lamps(exact, scene):
    """8192 texels are four map tiles."""
    for counts in exact(scene("city"), *LAMPS[2:4], "--resolution", 8192, "--columns", COLUMNS // 4, coding=CODINGS):
        assert counts["maps"] == 1 and counts["columns"] == COLUMNS // 4
    for counts in exact(scene("city"), *LAMPS[-2:], "--resolution", 2048 if EVERY else 1024, "--columns", COLUMNS // 4, coding=CODINGS):
        assert counts["maps"] == 6


def test_punctual_lights_that_reach_nothing(exact, scene):
    assert exact(scene("city"), "--spot", "0.5,2,0.5,0,1,0,60", status=5) == []
    assert exact(scene("city"), "--point", "0.5,9,0.5,0.1", status=5) == []
    both, = exact(scene("city"), "--spot", "0.5,2,0.5,0,1,0,60", "--spot", "0.5,2,0.5,0,-1,0,60", "--resolution", 64)
    assert both["maps"] == 1


@pytest.mark.parametrize("lamp", [LAMPS[2:4], LAMPS[6:8], LAMPS[10:12]], ids=["spot", "wide", "point"])
def test_faults_of_punctual_lights_are_seen(exact, scene, lamp):
    counts, = exact(scene("city"), *lamp, "--fault", "word", status=1)
    assert counts["wrong_lit"] + counts["wrong_shadow"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["stages"] + FAULTS)
def test_faults_are_seen(exact, scene, fault):
    """Proof that the comparison sees what it is there to see: one fault in one stage, in places that a seed picks."""
    for name in GENERATED:
        found = exact(scene(name), "--sun", SUNS[1], "--fault", fault, status=int(fault != "stages"), seed=[1, 2, 3], rule=RULES)
        assert all((counts["wrong_lit"] + counts["wrong_shadow"] > 0) == (fault != "stages") for counts in found)
