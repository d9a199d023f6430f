# tests/bench/sources: what it prints is what it writes, what differs is explained, and both are what the schema says.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import subprocess

import jsonschema
import pytest

from conftest import ROOT


@pytest.fixture(scope="module")
def sources(vxs_path):
    path = vxs_path.parent / "tests" / "bench" / "sources"
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it")
    return lambda *options: subprocess.run([path, *map(str, options)], capture_output=True, text=True, timeout=300)


def test_what_differs_is_explained(sources, vxs, tmp_path):
    vxs("scene", "city", "--triangles", 5000, "-o", tmp_path / "city.glb")
    done = sources(tmp_path / "city.glb", "--sun", "0.3,-1,0.2", "--resolution", 256, "--list", 3, "--json", tmp_path / "s.json")
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads((tmp_path / "s.json").read_text())
    jsonschema.validate(result, json.loads((ROOT / "docs" / "sources.schema.json").read_text()))
    (row,) = result["rows"]
    assert row["columns"] == 256**2 and row["wrong"] == row["unexplained"] == 0 < row["edge"] < row["depth"] + row["tie"]
    assert [t["why"] for t in row["texels"]] == [why for why in ("edge", "depth", "tie") for _ in range(min(3, row[why]))]
    assert all(t["rendered"] != t["found"] for t in row["texels"])
    first, *texels = done.stdout.splitlines()
    words = first.split()
    assert words[:4] == ["city.glb", "0.3,-1,0.2", "256", "65536"] and len(texels) == len(row["texels"])
    for why, after in (("depth", "depth,"), ("edge", "edges,"), ("tie", "ties,")):
        assert words[words.index(after) - 2] == str(row[why])


def test_what_is_wrong_is_said(sources, tmp_path):
    assert sources().returncode == 2
    assert sources(tmp_path / "none.glb").returncode == 3
