# tests/bench/rivals on a small scene: every rival obeys the contract voxel by voxel, its figures of vxs are those of vxs bake, and
# planted faults are seen.
# RIVALS: that program (default tests/bench/rivals beside the command, where the Makefile puts it).
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import re
import subprocess

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIDE = 64
SMALL = ("--resolution", SIDE, "--voxels", "all", "--runs", 2, "--points", 5000, "--width", 64)


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    path = tmp_path_factory.mktemp("rivals") / "city.glb"
    vxs("scene", "city", "--triangles", 5000, "-o", path)
    return path


@pytest.fixture(scope="module")
def rivals(vxs_path):
    """run(*args, status=0): what the program printed; its exit status is checked."""
    path = (ROOT / os.environ.get("RIVALS", vxs_path.parent / "tests" / "bench" / "rivals")).resolve()
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it, or set RIVALS")

    def run(*args, status=0):
        done = subprocess.run([path, *map(str, args)], capture_output=True, text=True, timeout=300)
        assert done.returncode == status, f"exit status {done.returncode}, expected {status}: {done.stderr}"
        return done.stdout

    return run


@pytest.fixture(scope="module")
def measured(rivals, city, tmp_path_factory):
    """The tables, and the JSON."""
    path = tmp_path_factory.mktemp("rivals") / "rivals.json"
    tables = rivals(city, *SMALL, "--json", path)
    return tables, json.loads(path.read_text())


def by_name(result):
    return {r["name"]: r for r in result["rivals"]}


def only(*names):
    return [option for name in names for option in ("--rival", name)]


def is_smooth(rival):
    return rival["name"].startswith(("palette blocks", "DAG")) or rival["name"] == "16-bit texture, GLSL"


def test_json_keeps_to_its_schema(measured):
    schema = json.loads((ROOT / "docs" / "rivals.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(measured[1])
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.Draft202012Validator(schema).validate({k: v for k, v in measured[1].items() if k != "machine"})


def test_threads_make_the_same_files(rivals, city, measured, tmp_path):
    makers = [name for name, r in by_name(measured[1]).items() if not r["rays"] and "GLSL" not in name]
    tables = rivals(city, *SMALL, "--threads", 3, *only(*makers), "--json", tmp_path / "a.json")
    assert "3 threads" in tables and "one thread" not in tables and "1 thread, processor time" in measured[0]
    result = json.loads((tmp_path / "a.json").read_text())
    assert result["threads"] == 3 and measured[1]["threads"] == 1 and len(makers) >= 8
    for name in makers:
        rival, again = by_name(measured[1])[name], by_name(result)[name]
        assert (again["file_bytes"], again["memory_bytes"], again["check"]) == (rival["file_bytes"], rival["memory_bytes"], rival["check"])


def test_no_voxel_is_wrong_and_filters_are_their_taps(measured):
    for r in measured[1]["rivals"]:
        check = r["check"]
        assert check["voxels"] == SIDE**3 and check["filters"] >= 100 and check["wrong_filters"] == 0, r["name"]
        assert (check["smooth"], check["wrong_smooth"]) == (check["filters"] if is_smooth(r) else 0, 0), r["name"]
        wrong = check["wrong_lit"] + check["wrong_dark"]
        assert wrong <= (1e-4 * SIDE**3 if r["rays"] else 0), r["name"]


def test_vxs_is_what_a_bake_makes(vxs, city, measured, tmp_path):
    for coding, rival in (("dag", "DAG"), ("blocks", "palette blocks")):
        vxs("bake", city, "-o", tmp_path / "city.vxs", "--resolution", SIDE, "--coding", coding, "--maps", "gl", "--json",
            tmp_path / "bake.json")
        size = json.loads((tmp_path / "bake.json").read_text())["lights"][0]["size"]
        assert by_name(measured[1])[rival]["memory_bytes"] == size["memory_bytes"]


def test_rivals_differ_where_they_should(measured):
    found = by_name(measured[1])
    memory = {name: r["memory_bytes"] for name, r in found.items()}
    assert memory["DAG"] == memory["DAG, top-down"] == memory["DAG, bottom-up"]
    assert memory["DAG"] <= memory["DAG, no culling"] < 1.01 * memory["DAG"]
    assert memory["DAG"] < memory["DAG, older mask rule"] and memory["DAG"] < memory["DAG, uncompressed"]
    assert memory["DAG, uncompressed"] < memory["DAG, uncompressed, no culling"]
    assert memory["16-bit depth map"] == found["16-bit depth map"]["file_bytes"] == 2 * SIDE**2
    for shader, asked in (("DAG, GLSL", "DAG"), ("palette blocks, GLSL", "palette blocks"),
                          ("palette blocks, GLSL, clamped", "palette blocks"), ("16-bit texture, GLSL", "16-bit depth map")):
        assert (memory[shader], found[shader]["file_bytes"]) == (memory[asked], found[asked]["file_bytes"])
    disk = [found[name]["file_bytes"] for name in ("16-bit depth map", "16-bit, zstd -3", "16-bit, zstd -19")]
    assert disk == sorted(disk, reverse=True) and len(set(disk)) == 3


def test_tables_say_what_the_json_says(measured):
    tables, result = measured
    rows = re.findall(r"^\| ([^|]+?) +\|", tables, re.MULTILINE)
    for r in result["rivals"]:
        assert rows.count(r["name"]) == 3 + is_smooth(r)
        line = re.search(rf"^- {re.escape(r['name'])}: (.*)$", tables, re.MULTILINE)
        assert (re.sub(r" \d+\.\d\d", "", line[1]) if line else "") == "; ".join(r["beats_vxs"])


def test_a_picture_asks_where_it_sees_surfaces(rivals, city, tmp_path):
    """All pixels, which look down on the city; rays are tested at some of them. Nothing is queried where nothing is seen."""
    look = ("--resolution", 64, "--voxels", 1, "--runs", 1, "--points", 100, "--width", 84)
    down = ("--eye=0,1000,0", "--target=0,0,0.1", "--fov", 2)
    rivals(city, *look, *down, "--json", tmp_path / "down.json")
    result = json.loads((tmp_path / "down.json").read_text())
    picture = result["picture"]
    assert (picture["width_px"], picture["height_px"], picture["eye_ws"], picture["fov_degrees"]) == (84, 47, [0, 1000, 0], 2)
    for r in result["rivals"]:
        lookups = r["lookups"]
        for set_, points in (("volume", 100), ("edge", 100), ("screen", 84 * 47)):
            asked = [lookups[set_][key] for key in ("tap_points", "filter_points", "smooth_points")]
            assert asked == ([points // 10, points // 100, 0] if r["rays"] else [points, points, points * is_smooth(r)]), (r["name"], set_)
            assert (lookups[set_]["smooth_ns"] is not None) == is_smooth(r)
    rivals(city, *look, "--eye=0,1000,0", "--target=0,2000,0.1", status=2)
    rivals(city, *look, "--eye=0,1000,0", status=2)


def test_some_rivals(rivals, city, tmp_path):
    """In the order in which all are, whatever that of the options is; vxs first, named or not."""
    look = ("--resolution", 64, "--voxels", 1, "--runs", 1, "--points", 100, "--width", 84)
    rivals(city, *look, "--rival", "float depth map", "--rival", "DAG", "--json", tmp_path / "some.json")
    assert list(by_name(json.loads((tmp_path / "some.json").read_text()))) == ["palette blocks", "DAG", "float depth map"]
    rivals(city, *look, "--rival", "no such thing", status=2)


@pytest.mark.parametrize("fault", ["depth", "filter"])
def test_fault_is_seen(rivals, city, fault, tmp_path):
    points = {"depth": 1000, "filter": 8000}[fault]  # filters are queried at points, depths in all voxels
    some = only("DAG", "merged intervals", "float depth map", "palette blocks, GLSL", "16-bit texture, GLSL", "Embree shadow rays")
    rivals(city, "--resolution", SIDE, "--voxels", "all", "--runs", 1, "--points", points, "--width", 64, "--fault", fault,
           *(some if fault == "filter" else ()), "--json", tmp_path / "f.json", status=1)
    for r in json.loads((tmp_path / "f.json").read_text())["rivals"]:
        if fault == "filter":
            assert r["check"]["wrong_filters"] > 0, r["name"]
            assert (r["check"]["wrong_smooth"] > 0) == is_smooth(r), r["name"]
        elif not r["rays"]:
            assert r["check"]["wrong_lit"] > 0 and r["check"]["wrong_dark"] == 0, r["name"]


def test_bad_input_has_its_exit_status(rivals, city, tmp_path):
    rivals(tmp_path / "none.glb", status=3)
    rivals(tmp_path / "none.glb", "--voxels", "some", status=2)
    rivals(city, "--json", tmp_path / "none" / "out.json", status=4)  # before anything is measured
