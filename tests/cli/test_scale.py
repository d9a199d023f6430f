# tests/bench/scale: what it prints is what it writes, and both are what the schema says.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import pathlib
import subprocess

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def scale(vxs_path):
    path = vxs_path.parent / "tests" / "bench" / "scale"
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it")
    return lambda *options: subprocess.run([path, *map(str, options)], capture_output=True, text=True, timeout=300)


def test_cells_are_printed_and_written(scale, tmp_path):
    done = scale("--runs", 2, "--largest", 32768, "--json", tmp_path / "scale.json")
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "scale.json").read_text())
    jsonschema.validate(result, json.loads((ROOT / "docs" / "scale.schema.json").read_text()))
    assert [(c["shape"], c["resolution_px"]) for c in result["cells"]] == [(s, n) for s in ("box", "sphere") for n in (16384, 32768)]
    assert result["runs"] == 2
    for line, cell in zip(done.stdout.splitlines(), result["cells"], strict=True):
        assert line.split()[:2] == [cell["shape"], str(cell["resolution_px"])]
        assert f"{cell['nodes']} nodes" in line and f"{1e3 * cell['seconds']['median']:.1f} ms" in line
        assert cell["seconds"]["min"] <= cell["seconds"]["median"] <= cell["seconds"]["max"]
        assert 0 < cell["tiles"] < cell["calls"] < 2 * cell["resolution_px"]


def test_what_is_wrong_is_said(scale, tmp_path):
    assert scale("--runs", 0).returncode == 2
    assert scale("--largest", 300000).returncode == 2
    done = scale("--runs", 1, "--largest", 16384, "--json", tmp_path / "none" / "scale.json")
    assert done.returncode == 4 and "scale.json" in done.stderr
