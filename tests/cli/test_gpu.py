# tests/bench/gpu: its answers agree with depth maps of the same depths, what it prints is what it writes, and both are what the
# schema says.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import pathlib
import subprocess
import sys

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
import gpu as gpu_bench  # noqa: E402
VIEW = ["--view", "street:-20,4,-150,-20,12,0", "--width", "48", "--height", "32", "--runs", "1", "--warm", "0"]


@pytest.fixture(scope="module")
def gpu(vxs_path):
    path = vxs_path.parent / "tests" / "bench" / "gpu"
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it")
    return lambda *options: subprocess.run([path, *map(str, options)], capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def folder(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("gpu")
    assert vxs("scene", "city", "-o", folder / "city.glb", "--triangles", 20000, "--spots", 8).returncode == 0
    for name, options in {"blocks": ["--light", "sun"], "dag": ["--light", "sun", "--coding", "dag"], "all": []}.items():
        assert vxs("bake", folder / "city.glb", "-o", folder / f"{name}.vxs", "--resolution", 512, *options).returncode == 0
    return folder


def rows_of(part):
    jsonschema.validate({"parts": [part], "skipped": []}, json.loads((ROOT / "docs" / "gpu.schema.json").read_text()))
    return part["rows"]


def report(done, path):
    assert done.returncode == 0, done.stderr
    return rows_of(json.loads(path.read_text()))


def test_answers_of_rivals_are_equal(gpu, folder, tmp_path):
    done = gpu(folder / "city.glb", folder / "blocks.vxs", *VIEW, "--json", tmp_path / "out.json")
    rows = report(done, tmp_path / "out.json")
    compared = {f"{row['group']}: {row['name']}": row["pixels_differ"] for row in rows if "pixels_differ" in row}
    for name in ("9 x 9 box: 16 bits, 81 fetches", "9 x 9 box: 32 bits, 25 comparisons", "9 x 9 smooth: 16 bits, 25 comparisons (rival)",
                 "3 x 3 box: 16 bits, 4 comparisons (rival)", "1 tap: 32 bits, 1 comparison", "9 x 9 box: blocks, texture"):
        assert compared[name] == 0
    assert {row["name"] for row in rows if row["group"] == "9 x 9 box"} >= {
        "blocks, buffer", "blocks, words alone", "blocks, texture", "16 bits, 25 gathers", "16 bits, cascades, 25 comparisons"}
    rival = next(row for row in rows if row["group"] == "9 x 9 box" and "(rival)" in row["name"])
    words = next(row for row in rows if row["group"] == "9 x 9 box" and row["name"] == "blocks, buffer")
    assert words["of_rival"] == pytest.approx(words["ms"]["median"] / rival["ms"]["median"])
    assert rival["bytes"] == 2 * 512 * 512
    assert f"{words['of_rival']:.2f}" in done.stdout


def test_lists_light_as_all_lights_do_and_fog_has_errors(gpu, folder, tmp_path):
    rows = report(gpu(folder / "city.glb", folder / "all.vxs", *VIEW, "--json", tmp_path / "out.json"), tmp_path / "out.json")
    assert [row["pixels_differ"] for row in rows if row["name"] == "lists, 9 x 9 box"] == [0]
    assert 0 < next(row["lights_listed"] for row in rows if "lights_listed" in row) <= 9
    rows = report(gpu(folder / "city.glb", folder / "blocks.vxs", *VIEW, "--only", "fog", "--fog", "0.01", "--json", tmp_path / "fog.json"), tmp_path / "fog.json")
    errors = {row["name"]: row["relative_rms"] for row in rows}
    assert errors["exact intervals"] == 0 < errors["march of a map, 128 steps"] < errors["march of a map, 64 steps (rival)"] < 0.2
    assert 0 < errors["froxels, 160 x 90 x 64"] < 0.2
    assert 0 < errors["exact intervals, half"] < 0.2 and 0 < errors["march of a map, 64 steps, half"] < 0.2


@pytest.mark.parametrize("asset", ["blocks", "dag"])
def test_fragment_shaders_answer_alike(gpu, folder, tmp_path, asset):
    done = gpu(folder / "city.glb", folder / f"{asset}.vxs", *VIEW, "--shader", "fragment", "--storage", "buffer", "--json", tmp_path / "out.json")
    differ = [row["pixels_differ"] for row in report(done, tmp_path / "out.json") if "pixels_differ" in row]
    assert len(differ) > 20 and not any(differ) and "fragment shaders" in done.stdout


def test_lists_of_several_files(gpu, folder, tmp_path):
    done = gpu(folder / "city.glb", folder / "all.vxs", folder / "all.vxs", *VIEW, "--only", "lists", "--json", tmp_path / "out.json")
    rows = report(done, tmp_path / "out.json")
    assert {row["group"] for row in rows} == {"18 spot lights"}
    assert {row["name"] for row in rows} >= {"cull", "reading lists alone", "lists, 9 x 9 box"}


def test_area_lights_and_smoke(vxs, vxs_path, tmp_path, capfd):
    """Area light and smoke of bench-gpu, with few VPLs and capsules: errors against the truth, and times relative to the rival's."""
    if not (vxs_path.parent / "tests" / "bench" / "area").is_file():
        pytest.skip("no programs of tests/bench: build them")
    assert vxs("scene", "room", "-o", tmp_path / "room.glb", "--triangles", 2000).returncode == 0
    args = argparse.Namespace(gpu=vxs_path.parent / "tests" / "bench" / "gpu", folder=tmp_path, size="160x90", runs=1)
    less = {"area": ("wall", [*gpu_bench.AREA_SCREEN, "--samples", "64", "--side", "32"]), "smoke": ("timer", ["--side", "64", "--capsules", "200"])}
    found = {}
    for program, scene, group, view, side_px, _, names in gpu_bench.VOLUMES:
        names = {name.replace("256", "4"): text for name, text in names.items()}
        clock, options = less[program]
        part, failed = gpu_bench.measure_volumes(args, clock, program, scene, group, view, side_px, options, names)
        assert not failed
        rows = rows_of({key: "" for key in ("vxs", "renderer", "opengl", "processor")} | part | {"shader": "compute", "clock": clock})
        assert (part["width_px"], part["height_px"]) == ((32, 18) if program == "area" else (160, 90))
        rival = next(row for row in rows if "(rival)" in row["name"])
        for row in rows:
            assert row["of_rival"] == pytest.approx(row["ms"]["median"] / rival["ms"]["median"]) and row["ms"]["median"] > 0
            assert sum(row["parts_ms"].values()) == pytest.approx(row["ms"]["median"], rel=1e-3), "of one frame"
        found |= {row["name"]: row["relative_rms"] for row in rows}
    assert found["at once"] == pytest.approx(found["one by one (rival)"], rel=0.3) and 0.05 < found["at once, exact maps"] < 0.6
    assert found["deep map, all segments (rival)"] < 1e-4 < found["curves of 8 nodes"] < 0.1 and 1e-4 < found["deep map, lines off by .01"] < 0.05
    assert "| one by one (rival)" in capfd.readouterr().out
    part, failed = gpu_bench.measure_volumes(args, "wall", "smoke", None, "smoke", "columns", 64, [], {"no such:1": "none"})
    assert not part and failed == "smoke: exit status 2" and "--cell no such:1" in capfd.readouterr().err


def test_what_is_wrong_is_said(gpu, folder):
    assert gpu().returncode == 2
    for view in ([], ["--view", "street:1,2,3"], ["--view", "nothing"]):
        done = gpu(folder / "city.glb", folder / "blocks.vxs", *view)
        assert done.returncode == 2 and "--view" in done.stderr and not done.stdout
