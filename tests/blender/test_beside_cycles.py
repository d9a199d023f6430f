# The comparison with Cycles: its report, its lightmap against rays, and how it skips.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import subprocess
import sys

import jsonschema
import pytest

FOLDER = pathlib.Path(__file__).resolve().parent
SCHEMA = json.loads((FOLDER.parents[1] / "docs" / "blender.schema.json").read_text())


def compare(tmp_path, vxs_path, blender, *more):
    addon = os.environ.get("ADDON")
    if not addon:
        pytest.skip("no add-on: make check-blender names its zip by ADDON")
    out = tmp_path / "out.json"
    done = subprocess.run([sys.executable, FOLDER / "beside_cycles.py", "--blender", blender, "--vxs", vxs_path, "--addon", addon,
                           "--out", out, "--quick", "--points", "2000", *more], capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stderr
    return out, done.stdout


def test_room(program, vxs_path, tmp_path):
    """Both ways are near the truth: units of lights, axes and UV2 are right."""
    out, printed = compare(tmp_path, vxs_path, program, "--only", "room")
    report = json.loads(out.read_text())
    jsonschema.validate(report, SCHEMA)
    (row,) = report["levels"]
    assert row["lamps"] == 2 and 0.05 < row["lit"] < 0.95
    assert 0 < row["vxs"]["error"] < 0.1 and 0 < row["vxs"]["error_in_air"] < 0.1
    assert 0 < row["equal_resolution"]["error"] < 0.12 and 0 < row["equal_bytes"]["error"] < 0.2
    assert abs(row["equal_bytes"]["bytes"] / row["vxs"]["bytes"] - 1) < 0.2
    assert "| room | vxs | 64² | none |" in printed


def test_level_that_is_not_there(program, vxs_path, tmp_path):
    out, printed = compare(tmp_path, vxs_path, program, "--only", "Sponza", "--real", str(tmp_path))
    jsonschema.validate(json.loads(out.read_text()), SCHEMA)
    assert f"no file {tmp_path}/sponza.glb" in printed


def test_no_blender(vxs_path, tmp_path):
    out, printed = compare(tmp_path, vxs_path, "no-such-blender")
    assert printed.startswith("skipped: no Blender: no-such-blender is not on PATH") and not out.exists()
