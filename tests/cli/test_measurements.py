# The programs that print the figures of docs/measurements.md, at sizes that take no time: that their tables say what their JSON says.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree

import jsonschema
import pytest

from conftest import ROOT


@pytest.fixture
def measure(vxs_path, tmp_path):
    """measure(program, *arguments, **environment): what it printed. Without the shared scenes."""

    def run(program, *arguments, **environment):
        done = subprocess.run(["/usr/bin/python3", ROOT / "tests" / "bench" / program, "--build", vxs_path.parent, *arguments],
                              env=os.environ | {"VXS_SCENES": str(tmp_path)} | environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def schema(name):
    return jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / f"{name}.schema.json").read_text()))


def rows(text, *begin):
    """Cells of the rows of all tables that begin with these cells."""
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]
    return [row for row in cells if row[:len(begin)] == list(begin)]


def test_ablation(measure, tmp_path):
    printed = measure("ablation.py", "--json", tmp_path / "ablation", ABLATION_RESOLUTIONS="32 64", ABLATION_RUNS="1")
    results = {path.stem: json.loads(path.read_text()) for path in (tmp_path / "ablation").glob("*.json")}
    assert set(results) == {f"{scene}-{n}" for scene in ("city", "landscape") for n in (1, 2, 3)}
    for result in results.values():
        schema("bench").validate(result)
    assert re.findall(r"^Table (\d)", printed, re.MULTILINE) == list("12345")

    bytes_of = {(c["options"]["resolution_px"], c["options"]["rule"]): c["size"]["memory_bytes"] for c in results["city-2"]["cells"]}
    (row,) = rows(printed, "city", "64", f"{bytes_of[64, 'greedy'] / 1e6:.3g} MB")
    assert row[3:5] == [f"{bytes_of[64, 'shadow'] / 1e6:.3g} MB", f"{bytes_of[64, 'shadow'] / bytes_of[64, 'greedy']:.2f}"]
    stops = {(c["options"]["exit"], c["options"]["stop"]): c["size"]["memory_bytes"] for c in results["landscape-3"]["cells"]
             if c["options"]["resolution_px"] == 64}
    for (exit_mode, stop), size in stops.items():
        (row,) = rows(printed, "landscape", exit_mode, stop)
        assert row[3:5] == [f"{size / 1e6:.3g} MB", f"{size / stops['peel', 'final']:.2f}"]


def test_estimates(measure, tmp_path):
    printed = measure("estimates.py", "--json", tmp_path / "estimates.json", ESTIMATES_RESOLUTIONS="64")
    result = json.loads((tmp_path / "estimates.json").read_text())
    schema("estimates").validate(result)
    assert {b["scene"] for b in result["bakes"]} == {"city", "landscape", "room", "forest"}
    ratios = [b["file_bytes"] for b in result["bakes"] if b["coding"] == "blocks"]
    (row,) = rows(printed, "palette blocks: bytes of the file")
    assert row[1] == f"{min(ratios):.2f}" and row[3] == f"{max(ratios):.2f}"


def test_plots(vxs, tmp_path):
    """Drawings of what was measured: each scene and each part that a bar is stacked of has its name in a key."""
    if not shutil.which("gnuplot"):
        pytest.skip("no gnuplot: package gnuplot-nox")
    vxs("scene", "city", "-o", tmp_path / "city.glb")
    vxs("scene", "forest", "-o", tmp_path / "it's \\ forest.glb")
    vxs("bench", tmp_path / "city.glb", tmp_path / "it's \\ forest.glb", "-o", tmp_path / "b.json", "--resolution", 64, "--resolution", 128,
        "--coding", "blocks", "--runs", 1, "--points", 1000)
    subprocess.run(["/usr/bin/python3", ROOT / "tests" / "bench" / "plots.py", tmp_path / "b.json", tmp_path / "plots"], check=True)
    words = {p.stem: " ".join("".join(e.itertext()) for e in xml.etree.ElementTree.parse(p).iter("{http://www.w3.org/2000/svg}text"))
             for p in (tmp_path / "plots").iterdir()}
    assert set(words) == {p.stem for p in (ROOT / "docs" / "plots").iterdir() if not p.stem.startswith("volumes-")}
    for name in ("error-bake-surface", "error-bytes-surface"):
        assert {"city.glb", "it's", "forest.glb", "64", "128", "%"} <= set(words[name].split()), words[name]
    assert {"maps", "64", "128", "s"} <= set(words["stages-city"].split())
    assert {"pages", "tops", "KiB"} <= set(words["bytes-city"].split())


def test_large_maps(measure, tmp_path):
    printed = measure("large.py", "--json", tmp_path / "large.json", LARGE_ROWS="small:512 sponza small:1024", LARGE_RUNS="1")
    result = json.loads((tmp_path / "large.json").read_text())
    schema("large").validate(result)
    first, second = result["rows"]
    assert [(r["scene"], r["resolution_px"]) for r in result["rows"]] == [("small", 512), ("small", 1024)] and result["runs"] == 1
    (row, stages) = rows(printed, "small", "1024")
    assert row[4] == f"{second['seconds']['median'] / second['two_maps_seconds']:.3f}"
    assert row[8] == f"{second['file_bytes'] / first['file_bytes']:.2f}" and rows(printed, "small", "512")[0][8] == ""
    assert stages[-1] == f"{second['processor_seconds'] / 2:.3g} s"
    for stage in second["stages"]:
        assert stage["three_threads_seconds"] <= stage["seconds"] + 1e-9


def test_volumes(measure, tmp_path):
    """Each technique comes nearer with more of its knob, and the front has both ends."""
    printed = measure("volumes.py", "--json", tmp_path / "volumes.json", "--folder", tmp_path, "--only", "room, lamp", "--size", "48x27",
                      "--resolution", "256", "--rounds", "2")
    result = json.loads((tmp_path / "volumes.json").read_text())
    schema("volumes").validate(result)
    (scene,) = result["scenes"]
    drawn = [c for c in scene["cells"] if not c["refused"]]
    assert len(drawn) == len(scene["cells"]) > 10 and (tmp_path / "room-lamp.svg").stat().st_size > 1000
    for name in {c["technique"] for c in drawn}:
        errors = [c["error"]["relative_rms"] for c in drawn if c["technique"] == name]
        if name in ("mesh", "adaptive mesh", "froxels"):  # whose error is that of what stays: a map's texels, columns
            assert errors[-1] < 1.1 * errors[0]
        elif name == "intervals":
            assert errors[0] < 1e-4
        else:
            assert errors[-1] < 0.8 * errors[0], name
    front = [c for c in drawn if c["front"]]
    for end in (lambda c: c["ms"]["median"], lambda c: c["error"]["relative_rms"]):
        assert min(map(end, drawn)) == min(map(end, front))
    assert len(rows(printed, "room, lamp")) == len(front)
