# vxs bench: what it measures is what bake and compare say, what moved is said, nothing is left behind.
# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import json
import os
import pathlib
import re
import signal
import statistics
import subprocess
import time

import jsonschema
import pytest

import small_scene
from conftest import ROOT, open_terminal

SCHEMA = json.loads((ROOT / "docs" / "bench.schema.json").read_text())
LIGHTS = (("sun", "directional", (1, -2, 0.5)), ("lamp", "point", (0, -1, 0)))
SIZES = ("nodes", "masks", "inserted_nodes", "inserted_masks")
QUICK = ("--resolution", 64, "--runs", 1, "--points", 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    at = tmp_path_factory.mktemp("bench")
    small_scene.write(at / "small.gltf", lights=LIGHTS)
    return at


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """TMPDIR of every run: whatever happened, nothing is in it in the end."""
    at = tmp_path / "temporary"
    at.mkdir()
    monkeypatch.setenv("TMPDIR", str(at))
    yield at
    assert list(at.iterdir()) == []


@pytest.fixture
def bench(vxs, folder, tmp_path, temporary):
    """bench(*arguments, status=0): the result, checked against its schema, and what was printed."""

    def run(*arguments, scenes=("small.gltf",), status=0):
        done = vxs("bench", *(folder / s for s in scenes), "-o", tmp_path / "b.json", *arguments, status=status)
        result = json.loads((tmp_path / "b.json").read_text())
        jsonschema.Draft202012Validator(SCHEMA).validate(result)
        return result, done.stdout

    return run


@pytest.fixture
def rejected(vxs, folder, tmp_path, temporary):
    """rejected(status, *arguments): the one line of an error; there is no output."""

    def run(status, *arguments, scenes=("small.gltf",)):
        done = vxs("bench", *(folder / s for s in scenes), "-o", tmp_path / "none.json", *arguments, status=status)
        assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1 and not done.stdout
        assert not (tmp_path / "none.json").exists()
        return done.stderr

    return run


@pytest.fixture(scope="module")
def measured(vxs, folder):
    """Two scenes, two resolutions, two exits, two runs."""
    small_scene.write(folder / "sheets.gltf", open_faces=True)
    done = vxs("bench", folder / "small.gltf", folder / "sheets.gltf", "-o", folder / "old.json", "--resolution", 64,
               "--resolution", 128, "--exit", "peel", "--exit", "back", "--light", "sun", "--filter", 3, "--runs", 2,
               "--points", 2000, "--coding", "blocks")
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    result = json.loads((folder / "old.json").read_text())
    jsonschema.Draft202012Validator(SCHEMA).validate(result)
    return result, done.stdout


def spreads(value):
    if isinstance(value, dict) and "median" in value:
        yield value
    elif isinstance(value, (dict, list)):
        for part in value.values() if isinstance(value, dict) else value:
            yield from spreads(part)


# --- what is measured ---------------------------------------------------------------------------------------------------------


def test_every_combination_in_order(measured):
    result, text = measured
    cells = [(c["scene"], c["options"]["resolution_px"], c["options"]["exit"]) for c in result["cells"]]
    assert cells == [(s, r, e) for s in ("small.gltf", "sheets.gltf") for r in (64, 128) for e in ("peel", "back")]
    assert all(c["options"]["light"] == ["sun"] and c["light"] == "sun" and c["lights"] == 1 for c in result["cells"])
    rows = [line.split()[:3] for line in text.splitlines() if line.startswith(("small.gltf", "sheets.gltf"))]
    assert rows == [[s, str(r), e] for s, r, e in cells], "only options that differ have a column"
    found = list(spreads(result))
    assert len(found) == len(cells) * (3 + 13 + 3) and all(s["min"] <= s["median"] <= s["max"] for s in found)
    walls = [c["bake"]["wall_seconds"] for c in result["cells"]]
    assert all(w["min"] < w["max"] and w["median"] == pytest.approx((w["min"] + w["max"]) / 2) for w in walls), "of two runs"


def test_figures_are_those_of_a_bake(vxs, bench, folder, tmp_path):
    """Of two lights and seven maps: sums."""
    cell = bench("--resolution", 128, "--runs", 1, "--points", 3000, "--level", 3, "--coding", "dag")[0]["cells"][0]
    report = json.loads(vxs("bake", folder / "small.gltf", "-o", tmp_path / "a.vxs", "--resolution", 128, "--level", 3,
                            "--coding", "dag", "--json", "-").stdout)
    lights = report["lights"]
    assert len(lights) == 2 and (cell["lights"], cell["maps"]) == (2, 7)
    assert (cell["triangles"], cell["solid_triangles"]) == (24, 24)
    size = cell["size"]
    assert size["file_bytes"] == report["file_bytes"] == (tmp_path / "a.vxs").stat().st_size
    assert size["memory_bytes"] == sum(light["size"]["memory_bytes"] for light in lights)
    for kind in ("nodes", "masks"):
        assert size[kind] == sum(v["count"] for light in lights for v in light["levels"] if v["kind"] == kind)
        assert size[f"inserted_{kind}"] == sum(light[f"inserted_{kind}"] for light in lights)
    assert [v["side_voxels"] for v in size["levels"]] == [128, 64, 32, 16, 8, 0]
    for n, level in enumerate(size["levels"]):
        for key in ("count", "memory_bytes", "stored_bytes"):
            assert level[key] == sum(light["levels"][n][key] for light in lights)
    bake = cell["bake"]
    assert bake["total_seconds"]["median"] < bake["wall_seconds"]["median"] < 60
    stages = {s["name"]: s["seconds"]["median"] for s in bake["stages"]}
    assert list(stages) == [s["name"] for s in report["stages"]]
    assert bake["maps_to_words_seconds"]["median"] == pytest.approx(
        sum(stages[n] for n in ("pyramid", "masks", "insert", "compress", "merge")), rel=1e-6)
    assert bake["peak_bytes"] == max(s["peak_bytes"] for s in bake["stages"])
    assert 0.5 < bake["peak_bytes"] / report["peak_bytes"] < 2

    compared = json.loads(vxs("compare", folder / "small.gltf", tmp_path / "a.vxs", "--points", 3000, "--json", "-").stdout)
    lights = compared["assets"][0]["lights"]
    assert [(e["points"], e["filter_px"]) for e in cell["errors"]] == [("random", 1), ("surface", 1)]
    for error in cell["errors"]:
        for key in ("checked", "leaks", "false_shadows", "unexplained"):
            assert error[key] == sum(light[error["points"]][key] for light in lights)
        assert error["wrong_share"] == pytest.approx((error["leaks"] + error["false_shadows"]) / error["checked"])
    assert sum(e["wrong_share"] for e in cell["errors"]) > 0
    times = [light["time"] for light in lights]
    mean = sum(t["lookup_ns"] * t["points"] for t in times) / sum(t["points"] for t in times)
    assert 0.1 < cell["lookups"][0]["nanoseconds"]["median"] / mean < 10
    assert cell["lookups"][0]["ray_nanoseconds"]["median"] > 0


def test_filters(vxs, bench, folder, tmp_path):
    """Errors are weighted over lights, in the order of the filters."""
    filters = ("--filter", 5, "--smooth", 4, "--filter", 3, "--smooth", 1)
    result, text = bench("--resolution", 64, "--runs", 1, "--points", 2000, *filters)
    cell, in_order = result["cells"][0], [(5, False), (3, False), (4, True), (1, True)]
    assert [(lookup["filter_px"], lookup.get("smooth")) for lookup in cell["lookups"]] == [(1, None), *in_order]
    assert "lookup 4 x 4 smooth" in text and "RMSE 1 x 1 smooth, surface" in text
    vxs("bake", folder / "small.gltf", "-o", tmp_path / "a.vxs", "--resolution", 64)
    compared = json.loads(vxs("compare", folder / "small.gltf", tmp_path / "a.vxs", "--points", 2000, *filters, "--json", "-").stdout)
    lights = compared["assets"][0]["lights"]
    errors = cell["errors"][2:]
    assert [(e["filter_px"], e["smooth"], e["points"]) for e in errors] == [(*f, points) for f in in_order for points in ("random", "surface")]
    for n, error in enumerate(errors):
        parts = [light["filters"][n // 2][error["points"]] for light in lights]
        assert error["checked"] == sum(p["points"] for p in parts) > 0
        assert error["rmse"] == pytest.approx((sum(p["points"] * p["rmse"]**2 for p in parts) / error["checked"])**0.5)
        assert error["max_error"] == max(p["max_error"] for p in parts)
    assert sum(error["max_error"] for error in errors) > 0


def test_options_reach_the_bake(bench):
    """Each of them changes what is measured, or stands in the cell."""
    plain = bench(*QUICK)[0]["cells"][0]
    assert plain["errors"] == plain["lookups"] == []
    assert plain["options"] == {"resolution_px": 64, "exit": "auto", "closed": "auto", "maps": "sparse", "coding": "blocks", "pack": "small",
                                "threads": len(os.sched_getaffinity(0)), "zstd_level": 12}
    given = {"--coding": "dag", "--rule": "shadow", "--stop": "insert", "--exit": "back", "--maps": "gl", "--closed": "off", "--reuse": "off",
             "--compress": "top-down", "--threads": 3, "--level": 1}
    other = bench(*QUICK, "--sun", "-0.5,-1,0.25", "--region", "-8,-1,-8,8,4,8", "--scene", "small",
                  *[word for pair in given.items() for word in pair])[0]["cells"][0]
    expected = {{"--level": "zstd_level"}.get(name, name[2:]): value for name, value in given.items()}
    expected |= {"resolution_px": 64, "sun": {"sun": [-0.5, -1, 0.25]}, "region_m": [-8, -1, -8, 8, 4, 8], "scene": "small"}
    del expected["maps"]  # as in files, OpenGL's are not named
    assert other["options"] == expected
    assert other["solid_triangles"] == 0 and other["lights"] == 1 and set(SIZES) <= set(other["size"]) and "nodes" not in plain["size"]
    assert other["size"]["nodes"] >= other["size"]["inserted_nodes"], "stopped after insertion: nothing is compressed"


def test_values_by_light(bench):
    """Those of a light are combined with those of other lights, and with those of all others; suns go to every bake."""
    suns = ("--sun", "noon=0,-1,0", "--sun", "-1,-1,0", "--runs", 1, "--points", 0, "--coding", "dag")
    cells = bench("--resolution", "noon=64", "--resolution", 16, "--resolution", "noon=128", "--resolution", "sun=8", *suns)[0]["cells"]
    sizes = [(c["options"]["resolution_px"], c["options"]["light_resolution_px"]) for c in cells]
    assert sizes == [(16, {"noon": 64, "sun": 8}), (16, {"noon": 128, "sun": 8})]
    assert all(c["options"]["sun"] == {"noon": [0, -1, 0], "sun": [-1, -1, 0]} and c["lights"] == 2 for c in cells)
    assert [[v["side_voxels"] for v in c["size"]["levels"]][0] for c in cells] == [64, 128], "the larger map of both lights"
    cells, text = bench("--resolution", "noon=64", "--resolution", 16, "--resolution", 32, *suns)
    assert [(c["options"]["resolution_px"], c["options"]["light_resolution_px"]) for c in cells["cells"]] == [
        (n, {"noon": 64}) for n in (16, 32)]
    assert [line.split()[1] for line in text.splitlines() if line.startswith("small.gltf")] == ["16", "32"]


def test_codings_side_by_side(vxs, bench, folder, tmp_path):
    """Each has what it keeps; steps of a DAG, which blocks have not, are no column."""
    result, text = bench("--coding", "dag", "--coding", "blocks", "--resolution", 128, "--runs", 1, "--points", 0)
    assert [c["options"]["coding"] for c in result["cells"]] == ["dag", "blocks"]
    head = next(line for line in text.splitlines() if line.startswith("scene"))
    assert head.split()[:3] == ["scene", "texels", "coding"] and not {"rule", "compress", "pack"} & set(head.split())
    dag, blocks = (c["size"] for c in result["cells"])
    assert set(SIZES) <= set(dag) and not set(SIZES) & set(blocks)
    lights = json.loads(vxs("bake", folder / "small.gltf", "-o", tmp_path / "a.vxs", "--resolution", 128, "--coding", "blocks",
                            "--json", "-").stdout)["lights"]
    assert blocks["file_bytes"] == (tmp_path / "a.vxs").stat().st_size
    assert blocks["palette_blocks"] == {key: sum(light["palette_blocks"][key] for light in lights) for key in lights[0]["palette_blocks"]}
    assert [part["kind"] for part in blocks["parts"]] == ["tops", "patterns", "pages"]
    for n, part in enumerate(blocks["parts"]):
        for key in ("count", "memory_bytes", "stored_bytes"):
            assert part[key] == sum(light["levels"][n][key] for light in lights)
    (tmp_path / "old.json").write_text(json.dumps(result))
    vxs("bench", folder / "small.gltf", "-o", tmp_path / "new.json", "--coding", "blocks", "--runs", 1, "--points", 0, "--resolution", 128,
        "--against", tmp_path / "old.json")


def test_packings_side_by_side(bench):
    """A column distinguishes them; beside a DAG, which has none, there is none."""
    result, text = bench("--pack", "small", "--pack", "fast", "--resolution", 128, "--runs", 1, "--points", 0)
    small, fast = result["cells"]
    assert (small["options"]["pack"], fast["options"]["pack"]) == ("small", "fast")
    assert fast["size"]["file_bytes"] > small["size"]["file_bytes"] and fast["size"]["memory_bytes"] == small["size"]["memory_bytes"]
    assert next(line for line in text.splitlines() if line.startswith("scene")).split()[:3] == ["scene", "texels", "pack"]


def test_steps_need_a_dag(rejected):
    assert "need --coding dag" in rejected(2, *QUICK, "--coding", "dag", "--coding", "blocks", "--rule", "greedy")


def test_to_standard_output(vxs, folder, temporary):
    done = vxs("bench", folder / "small.gltf", "-o", "-", *QUICK)
    jsonschema.Draft202012Validator(SCHEMA).validate(json.loads(done.stdout))
    assert "small.gltf" in done.stderr and "peak memory" in done.stderr


def test_progress(vxs_path, folder, tmp_path, temporary):
    """Runs go round by round; from the second on there is an estimate."""
    master, terminal = open_terminal()
    with subprocess.Popen([vxs_path, "bench", folder / "small.gltf", "-o", tmp_path / "b.json", "--resolution", "64",
                           "--resolution", "8192", "--runs", "4", "--points", "0"], stdout=subprocess.DEVNULL,
                          stderr=terminal) as process:
        os.close(terminal)
        said = b""
        try:
            while piece := os.read(master, 4096):
                said += piece
        except OSError:  # no process has it open any more
            pass
    os.close(master)
    lines = [line for line in said.split(b"\r\x1b[K") if line]
    assert process.returncode == 0 and b"\n" not in said and said.endswith(b"\r\x1b[K")
    at = [tuple(map(int, re.match(rb"vxs: run (\d) of 4: small.gltf, (\d+) texels", line).groups())) for line in lines]
    rounds = [(run, side) for run in range(1, 5) for side in (64, 8192)]
    assert at == [n for n in rounds if n in at] and {side for _, side in at} == {64, 8192} and len({run for run, _ in at}) == 4
    assert b"about" not in lines[0] and any(b"about" in line for line in lines[1:])


# --- the driver of make bench -------------------------------------------------------------------------------------------------


def test_make_bench(vxs_path, tmp_path, temporary):
    """At a size that takes no time."""
    if not (vxs_path.parent / "tests" / "bench" / "rivals").is_file():
        pytest.skip("the bench is not built: make check builds it")
    environment = os.environ | {"BENCH_RESOLUTIONS": "64", "BENCH_RUNS": "1", "BENCH_POINTS": "1000", "VXS_SCENES": str(tmp_path)}
    done = subprocess.run(["/usr/bin/python3", ROOT / "tests" / "bench" / "bench.py", "--build", vxs_path.parent, "--json",
                           tmp_path / "bench.json"], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "bench.json").read_text())
    jsonschema.Draft202012Validator(SCHEMA).validate(result)
    assert [c["scene"] for c in result["cells"]] == ["city.glb"] and result["runs"] == 1 and result["points"] == 1000
    assert re.search(r"^\| peak memory, city +\| 600 MiB \| +[\d.]+ MiB \| met \|$", done.stdout, re.MULTILINE)


# --- what moved ---------------------------------------------------------------------------------------------------------------


def scaled(value, factor):
    """A copy in which all spreads are of other times."""
    value = copy.deepcopy(value)
    for s in spreads(value):
        s |= {key: factor * s[key] for key in s}
    return value


@pytest.fixture
def against(vxs, folder, measured, tmp_path, temporary):
    """against(old, *options, status=0): what is printed behind the table, of the first cell measured anew against an old result."""

    def run(old, *options, status=0):
        (tmp_path / "old.json").write_text(json.dumps(old))
        done = vxs("bench", folder / "small.gltf", "-o", tmp_path / "new.json", "--resolution", 64, "--exit", "peel",
                   "--light", "sun", "--filter", 3, "--runs", 1, "--points", 2000, "--coding", "blocks", "--against", tmp_path / "old.json",
                   *options, status=status)
        assert (tmp_path / "new.json").exists()
        head, _, rest = done.stdout.partition("\nagainst ")
        return rest

    return run


def first_cell(measured):
    return copy.deepcopy(measured[0]) | {"cells": copy.deepcopy(measured[0]["cells"][:1]), "runs": 1}


def wide(result):
    """Times whose spread holds everything."""
    for s in spreads(result):
        s |= {"min": 0, "max": 1000}
    return result


def moved(text):
    """What moved, but for a peak that is a few MiB another: the system maps libraries in larger or smaller pieces."""
    lines = [line for line in text.splitlines()[1:] if not re.search(r"  peak memory .* (0\.[89]|1\.[01])\d\d$", line)]
    return [] if lines == ["nothing moved in 1 cells"] else lines[1:] if lines[0].split()[:2] == ["moved", "figure"] else lines


def test_nothing_moved(against, measured):
    assert moved(against(wide(first_cell(measured)), "--max-slower", 1)) == []


def test_times_that_moved(against, measured):
    """A millionth of the time before is slower now, and a million times as long is not, whatever else the machine does meanwhile;
    --max-slower gates on the one alone."""
    old = first_cell(measured)
    text = against(scaled(old, 1e-6))
    rows = {row[1]: row for row in (re.split(r"  +", line.strip()) for line in text.splitlines()) if len(row) == 5}
    assert {"bake", "maps to words", "lookup", "lookup 3 x 3", "ray"} <= rows.keys()
    assert any(name.startswith("stage ") for name in rows), "which of them take long enough to be told differs"
    assert not {"file", "nodes"} & rows.keys()
    assert rows["bake"][0] == "small.gltf, 64 texels" and float(rows["bake"][4]) > 1e3
    assert rows["bake"][2].endswith(")") and rows["bake"][3].endswith("s"), "before: a spread; now: a single run"
    assert "of these times are more than 5 times what they were; FAILED" in against(scaled(old, 1e-6), "--max-slower", 5, status=1)
    text = against(scaled(old, 1e6), "--max-slower", 1)
    assert re.search(r"  bake .* 0\.00\d\n", text) and "FAILED" not in text
    assert "FAILED" not in against(wide(scaled(old, 1e-6)), "--max-slower", 1), "within the spread"


@pytest.mark.parametrize("change, row", [
    (lambda c: c["size"].update(file_bytes=c["size"]["file_bytes"] + 1), r"  file  .* B  .* B .*0\.\d\d\d$"),
    (lambda c: c["size"].update(memory_bytes=2 * c["size"]["memory_bytes"]), r"  in memory .*0\.500$"),
    (lambda c: c["size"]["palette_blocks"].update(patterns=0), r"  patterns  +0  +\d+ +-$"),
    (lambda c: c["bake"].update(peak_bytes=c["bake"]["peak_bytes"] // 2), r"  peak memory .*[12]\.\d\d\d$"),
    (lambda c: c["errors"][0].update(leaks=c["errors"][0]["leaks"] + 1), r"  leaks, random .*"),
    (lambda c: c["errors"][1].update(wrong_share=0.5), r"  wrong, surface +50 % .*"),
    (lambda c: c["errors"][3].update(rmse=1), r"  RMSE 3 x 3, surface +100 % .*"),
], ids=["file", "memory", "patterns", "peak", "leaks", "share", "rmse"])
def test_figures_that_moved(against, measured, change, row):
    old = wide(first_cell(measured))
    change(old["cells"][0])
    rows = moved(against(old))
    assert len(rows) == 1 and re.search(row, rows[0]), rows


def test_machines_and_cells_that_differ(against, measured):
    old = wide(copy.deepcopy(measured[0]))
    old |= {"vxs": "0.0.1", "points": 7, "machine": old["machine"] | {"processor": "abacus\x1b[2J", "cores": 4711}}
    del old["cells"][0]
    lines = against(old).splitlines()
    assert re.match(r"vxs: \S+, before: 0\.0\.1$", lines[1]) and lines[2].endswith(", before: abacus?[2J")
    assert lines[3].startswith("cores: ") and lines[3].endswith(", before: 4711")
    assert lines[4:7] == ["runs: 1, before: 2", "points: 2000, before: 7: errors are not compared", "no cell is in both"]
    assert lines[7] == "only now: small.gltf, 64 texels"
    cells = [(s, r, e) for s in ("small.gltf", "sheets.gltf") for r in (64, 128) for e in ("peel", "back")]
    assert lines[8:] == [f"only before: {s}, {r} texels, exit {e}" for s, r, e in cells[1:]]


# --- what cannot be measured --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments, words", [
    (["--exit", "peel", "--exit", "often"], "--exit often: expected one of auto|peel|back"),
    (["--resolution", 100], "--resolution 100: expected a power of two"),
    (["--level", 20], "--level 20: expected a whole number from 1 to 19"),
    (["--threads", "many"], "--threads many"),
    (["--sun", "1,2"], "--sun 1,2: expected 3 numbers"),
    (["--sun", "0,-1,0", "--sun", "sun=1,-1,0"], "--sun is given twice for 'sun'"),
    (["--resolution", "sun=100"], "--resolution sun=100: expected a power of two"),
    (["--resolution", "sun=64", "--resolution", "sun=064"], "given twice"),
    (["--region", "0,0,0,0,1,1"], "--region: the minimum must be less"),
    (["--resolution", 64, "--resolution", "0064"], "given twice"),
    (["--filter", 4], "--filter 4: expected an odd number"),
    (["--filter", 19], "--filter 19"),
    (["--runs", 0], "--runs 0"),
    (["--points", -1], "--points -1"),
    (["--max-slower", 2], "--max-slower goes with --against"),
    ([word for n in range(5000) for word in ("--light", n)], "--light: expected at most"),
    ([word for option in ("--level", "--threads", "--rule") for n in range(17) for word in (option, n)], "too many combinations"),
], ids=lambda value: value.split(":")[0] if isinstance(value, str) else "")
def test_command_line_is_checked(rejected, arguments, words):
    assert words in rejected(2, *arguments)


def test_operands_are_checked(vxs, rejected, folder, tmp_path, temporary):
    assert "bench needs -o" in vxs("bench", folder / "small.gltf", status=2).stderr
    assert "SCENE is missing" in vxs("bench", "-o", tmp_path / "b.json", status=2).stderr
    assert "given twice" in rejected(2, scenes=("small.gltf", "small.gltf"))
    assert "is the input itself" in vxs("bench", folder / "small.gltf", "-o", folder / "small.gltf", status=2).stderr


def test_scenes_that_cannot_be_baked(vxs, rejected, folder):
    small_scene.write(folder / "dark.gltf", lights=())
    (folder / "broken.glb").write_bytes(b"glTF, or so it says")
    assert re.match(r"vxs: error: cannot read '.*nobody\.glb'", rejected(3, *QUICK, scenes=("small.gltf", "nobody.glb")))
    assert re.match(r"vxs: error: '.*broken\.glb': ", rejected(3, *QUICK, scenes=("small.gltf", "broken.glb")))
    assert "bake of dark.gltf, 64 texels: " in rejected(5, *QUICK, scenes=("dark.gltf",))
    assert "bake of small.gltf, 64 texels: " in rejected(2, *QUICK, "--light", "nobody")


def test_output_that_cannot_be_written(vxs, folder, tmp_path, temporary):
    begin = time.monotonic()
    assert "cannot write" in vxs("bench", folder / "small.gltf", "-o", tmp_path / "no" / "b.json", status=4).stderr
    assert "is a folder" in vxs("bench", folder / "small.gltf", "-o", tmp_path, status=4).stderr
    assert time.monotonic() - begin < 2, "before the work"
    if os.path.exists("/dev/full"):
        assert "/dev/full" in vxs("bench", folder / "small.gltf", "-o", "/dev/full", *QUICK, status=4).stderr


def test_no_temporary_folder(vxs, folder, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path / "nowhere"))
    assert "nowhere" in vxs("bench", folder / "small.gltf", "-o", tmp_path / "b.json", status=4).stderr
    assert list(tmp_path.iterdir()) == []


def wait_for(condition, process):
    begin = time.monotonic()
    while not condition():
        assert process.poll() is None and time.monotonic() - begin < 60
        time.sleep(0.002)


def test_runs_of_other_bytes(vxs_path, tmp_path, temporary):
    """The scene changes while it is measured."""
    scene = small_scene.write(tmp_path / "scene.gltf")
    other = small_scene.write(tmp_path / "other.gltf", boxes=[((-3, 0, -2), (1, 2, 2)), small_scene.GROUND])
    with subprocess.Popen([vxs_path, "bench", scene, "-o", tmp_path / "b.json", "--resolution", "64", "--runs", "100"],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        wait_for(lambda: list(temporary.glob("*/asset.vxs")), process)
        other.rename(scene)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 1 and not out and not (tmp_path / "b.json").exists()
    assert re.fullmatch(r"vxs: error: bake of scene.gltf, 64 texels: run \d+ of 100 wrote other bytes than run 1\n", err)


def processes_with(word):
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            found += [entry.parent.name] if word.encode() in entry.read_bytes() else []
        except OSError:  # gone meanwhile
            pass
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_interrupts(vxs, vxs_path, folder, tmp_path, temporary, number):
    """Sent to the bench alone, it stops its bake too."""
    if not (folder / "city.glb").exists():
        vxs("scene", "city", "-o", folder / "city.glb")
    took = []
    for delay in (0, 0.01, 0.2):
        with subprocess.Popen([vxs_path, "bench", folder / "city.glb", "-o", tmp_path / "b.json", "--resolution", "16384"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            wait_for(lambda: list(temporary.glob("*/errors.txt")), process)  # a child is there
            time.sleep(delay)
            begin = time.monotonic()
            process.send_signal(number)
            process.send_signal(number)  # an impatient one
            assert process.communicate(timeout=20) == (b"", b"")
            took.append(time.monotonic() - begin)
            assert process.returncode == (130 if number == signal.SIGINT else -number)
        assert processes_with(str(temporary)) == [] and list(temporary.iterdir()) == [] and not (tmp_path / "b.json").exists()
    assert statistics.median(took) < 1 and max(took) < 10


def test_killed_child(vxs_path, folder, tmp_path, temporary):
    with subprocess.Popen([vxs_path, "bench", folder / "small.gltf", "-o", tmp_path / "b.json", "--resolution", "16384"],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
        wait_for(lambda: children.read_text(), process)
        os.kill(int(children.read_text().split()[0]), signal.SIGKILL)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 6 and "ended by signal 9" in err and err.count("\n") == 1 and not out


# --- files of others ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text, words", [
    (b"", "not JSON"),
    (b"\x00\x01\x02", "not JSON"),
    (b"[]", "no object"),
    (b"{}", '"cells" is missing'),
    (b'{"cells": [], "cells": []}', "not JSON"),
    (b"[" * 100000, "not JSON"),
    (b'{"a":' * 100000, "not JSON"),
    (b'{"cells": [' + b"{}, " * 5000 + b"{}]}", "5001 items"),
    (b'{"cells": [[]]}', "no object"),
    (b'{"cells": 1e999}', "not JSON"),
], ids=lambda value: "")
def test_hostile_json(rejected, tmp_path, text, words):
    (tmp_path / "old.json").write_bytes(text)
    assert words in rejected(3, "--against", tmp_path / "old.json")


def test_no_json(rejected, folder, tmp_path):
    assert "cannot read" in rejected(3, "--against", tmp_path / "nobody.json")
    assert "is a folder" in rejected(3, "--against", tmp_path)
    assert "not JSON" in rejected(3, "--against", "/dev/zero")


def places(value, path=()):
    """The path of every member, but for those of options, which may be any."""
    for key, part in value.items() if isinstance(value, dict) else enumerate(value):
        yield (*path, key)
        if isinstance(part, (dict, list)) and key != "options":
            yield from places(part, (*path, key))


def of_both_codings(measured):
    """A cell with what palette blocks have, and what a DAG has."""
    old = first_cell(measured)
    level = {"side_voxels": 64, "count": 1, "memory_bytes": 36, "stored_bytes": 23}
    old["cells"][0]["size"] |= {name: 7 for name in SIZES} | {"levels": [level]}
    return old


def test_every_member_is_checked(rejected, measured, tmp_path):
    """Each in its turn is null, or of the wrong range; items of arrays, too."""
    old = of_both_codings(measured)
    cell = old["cells"][0]
    cell["size"]["parts"], cell["bake"]["stages"] = cell["size"]["parts"][-1:], cell["bake"]["stages"][:1]
    cell["errors"], cell["lookups"] = [cell["errors"][0], cell["errors"][2]], cell["lookups"][:1]
    paths = list(places(old))
    assert len(paths) > 70
    for n, path in enumerate(paths):
        parent = old
        for key in path[:-1]:
            parent = parent[key]
        was = parent[path[-1]]
        parent[path[-1]] = -1 if n % 2 and isinstance(was, (int, float)) else None
        (tmp_path / "old.json").write_text(json.dumps(old))
        assert "not what vxs bench writes" in rejected(3, "--against", tmp_path / "old.json"), path
        parent[path[-1]] = was


@pytest.mark.parametrize("change", [
    lambda c: c["bake"]["wall_seconds"].update(median=1e9),
    lambda c: c["size"]["levels"][0].update(side_voxels=48),
    lambda c: c["size"]["levels"][0].update(side_voxels=2**32),
    lambda c: c["size"]["levels"].append(c["size"]["levels"][0]),
    lambda c: c["size"]["parts"].extend(3 * c["size"]["parts"]),
    lambda c: c["size"]["parts"][0].update(kind="masks"),
    lambda c: c["bake"]["stages"].extend(3 * c["bake"]["stages"]),
    lambda c: c["errors"].extend(26 * c["errors"]),
    lambda c: c["lookups"].extend(26 * c["lookups"]),
    lambda c: c["errors"][2].update(smooth="yes"),
    lambda c: c["errors"][0].update(points="here and there"),
    lambda c: c["errors"][0].update(wrong_share=1.5),
], ids=lambda value: "")
def test_figures_that_cannot_be(rejected, measured, tmp_path, change):
    old = of_both_codings(measured)
    change(old["cells"][0])
    (tmp_path / "old.json").write_text(json.dumps(old))
    assert "cell 1: " in rejected(3, "--against", tmp_path / "old.json")
