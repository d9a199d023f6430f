# The programs that print the figures of docs/measurements.md, at sizes that take no time: that their tables say what their JSON
# says.
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


@pytest.mark.long
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


def test_large_maps(measure, vxs_path, tmp_path):
    printed = measure("large.py", "--json", tmp_path / "large.json", "--against", vxs_path, LARGE_ROWS="small:512 sponza small:1024", LARGE_RUNS="1")
    result = json.loads((tmp_path / "large.json").read_text())
    schema("large").validate(result)
    first, second = result["rows"]
    assert [(r["scene"], r["resolution_px"]) for r in result["rows"]] == [("small", 512), ("small", 1024)] and result["runs"] == 1
    row, other, stages = rows(printed, "small", "1024")
    assert all(r["against"]["file_bytes"] == r["file_bytes"] for r in result["rows"]), "the same build"
    assert float(other[4]) == pytest.approx(second["against"]["seconds_ratio"], abs=0.006) and other[7] == "1.000"
    assert row[4] == f"{second['seconds']['median'] / second['two_maps_seconds']:.3f}"
    assert row[8] == f"{second['file_bytes'] / first['file_bytes']:.2f}" and rows(printed, "small", "512")[0][8] == ""
    assert stages[-1] == f"{second['processor_seconds'] / 2:.3g} s"
    for stage in second["stages"]:
        assert stage["three_threads_seconds"] <= stage["seconds"] + 1e-9


@pytest.fixture
def measure_fog(measure, tmp_path):
    """measure_fog(only): the one scene of that name at 48 x 27 pixels, three settings of each knob; and what was printed."""

    def run(only, values=3):
        printed = measure("volumes.py", "--json", tmp_path / "volumes.json", "--folder", tmp_path, "--only", only, "--size", "48x27",
                          "--resolution", "256", "--rounds", "1", "--values", str(values), "--capsules", "200", "--points", "100000", "--samples", "256")
        result = json.loads((tmp_path / "volumes.json").read_text())
        schema("volumes").validate(result)
        (scene,) = result["scenes"]
        assert scene["name"] == only and (tmp_path / "volumes.html").stat().st_size > 100000
        stem = f"volumes-{only.replace(', ', '-').replace(' ', '-')}"
        plots = {f"{stem}.svg"} | ({f"{stem}-bytes.svg"} if "capsules" in scene else set())
        assert {p.name for p in tmp_path.glob("volumes-*.svg") if p.stat().st_size > 1000} == plots
        drawn = [c for c in scene["cells"] if not c["refused"]]
        assert len(drawn) == len(scene["cells"]) > 10 and all(t["limit"] for t in scene["techniques"])
        return scene, {t["name"]: [c["error"]["relative_rms"] for c in drawn if c["technique"] == t["name"]] for t in scene["techniques"]}, printed

    return run


@pytest.mark.long
def test_volumes(measure_fog):
    """Each technique comes nearer with more of its knob; what is on the front, and how far the others are behind, follows from their figures."""
    scene, errors, printed = measure_fog("room, lamp off screen")
    assert {t["name"] for t in scene["techniques"] if t["rival"]} == {"froxels", "moments", "min-max slices"}
    for name, found in errors.items():
        assert all(b < 1.1 * a for a, b in zip(found, found[1:])), f"{name}: {found}"
        # what stays: a map's texels, columns, floats, pixels that share a ray
        if name not in ("mesh", "adaptive mesh", "froxels", "intervals", "angles, half", "intervals, half"):
            assert found[-1] < 0.8 * found[0], name
    assert errors["intervals"][0] < 1e-4
    for cell in scene["cells"]:
        ms, rms = cell["ms"]["median"], cell["error"]["relative_rms"]
        quickest = lambda most: min(c["ms"]["median"] for c in [cell, *(c for c in scene["cells"] if c["error"]["relative_rms"] <= most)])
        assert 0.999 * ms / quickest(0.999 * rms) <= cell["behind"] <= 1.001 * ms / quickest(rms), "figures have four digits"
        assert cell["front"] == (cell["behind"] == 1)
    bold = [cell for row in rows(printed) for cell in row if cell.startswith("**")]
    assert len(bold) == sum(c["front"] for c in scene["cells"])
    assert {row[0] for row in rows(printed)} >= {t["name"] for t in scene["techniques"]}, "losers have a row, too"


@pytest.mark.long
def test_volumes_of_spheres(measure_fog):
    """Against formulas exact intervals of the asset are off by its map, and nothing comes nearer than maps let it."""
    scene, errors, _ = measure_fog("spheres, sun")
    assert scene["reference"] == "formulas of spheres" and 1e-5 < errors["intervals"][0] < 1e-3
    assert errors["angles"][-1] < 0.5 * errors["angles"][0] and errors["moments"][-1] < 0.5 * errors["moments"][0]


@pytest.mark.long
def test_volumes_of_smoke(measure_fog):
    """Each technique comes nearer with more of its knob, parts of a frame are all of it, bytes are those of knobs, and ratios those of the figures."""
    scene, errors, printed = measure_fog("smoke with hair")
    assert {name for name, found in errors.items() if len(found) == 3} == {t["name"] for t in scene["techniques"]} - {"power moments", "uncompressed"}
    for name, found in errors.items():
        assert all(b < 1.1 * a for a, b in zip(found, found[1:])), f"{name}: {found}"
        if name in ("opacity slices", "Fourier"):  # of the others it is lines between nodes that stay, where capsules are few
            assert found[-1] < 0.5 * found[0], f"{name}: {found}"
    assert errors["uncompressed"][0] < 1e-4 and "Along every knob error falls" in printed
    cells = {(c["technique"], c["value"]): c for c in scene["cells"]}
    for cell in scene["cells"]:
        parts = {p["name"]: p["ms"] for p in cell["parts"]}
        assert list(parts) == ["capture", "build", "look up"] and (parts["capture"] == 0) == (cell["technique"] == "adaptive, tiles")
        assert sum(parts.values()) == pytest.approx(cell["ms"]["median"], rel=1e-3), "of one round"
    for technique, value in (("adaptive", 8), ("adaptive, unsorted", 8), ("opacity slices", 16), ("Fourier", 8)):
        assert cells[technique, value]["bytes_per_texel"] == 64
    looked_up = lambda technique, value: cells[technique, value]["parts"][2]["ms"]
    (claim,) = [c for c in scene["claims"] if c["what"].startswith("looking up uncompressed")]
    assert claim["value"] == pytest.approx(looked_up("uncompressed", 1) / looked_up("adaptive", 8), rel=1e-3) and claim["paper"] == 51
    assert all(f"{c['what']}: {c['value']:.3g} times; the paper has {c['paper']:g}" in printed for c in scene["claims"])
    assert len(rows(printed, "adaptive")) == 3, "of smoke all settings have a row"


def test_volumes_of_area_lights(measure_fog):
    """The same VPLs, with exact maps, are the same by all techniques; the more of them, the nearer."""
    scene, errors, printed = measure_fog("area light behind a wall", values=2)
    assert {t["name"] for t in scene["techniques"] if t["rival"]} == {"imperfect, one by one", "marches", "froxels"} and scene["reference_rms"] < 0.2
    assert errors["exact maps"][1] < errors["exact maps"][0] and errors["marches"] == pytest.approx(errors["exact maps"], rel=0.1)
    assert errors["imperfect"][0] == pytest.approx(errors["imperfect, one by one"][0], rel=1e-3), "one lamp"
    for cell in scene["cells"]:
        parts = {p["name"]: p["ms"] for p in cell["parts"]}
        assert list(parts) == ["vpls", "maps", "volumes"] and (parts["maps"] > 0) == (cell["technique"].startswith("imperfect") and "one" not in cell["technique"])
        assert cell["creation_ms"] > 0 and "flicker" not in cell
    assert all(f"{name}: the error falls as VPLs to the power of " in printed for name in errors if name != "froxels")
    assert ("Error rises" in printed) == any(b > 1.1 * a for found in errors.values() for a, b in zip(found, found[1:]))
