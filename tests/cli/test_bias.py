# tests/bench/bias: what it prints is what it writes, by its schema; nothing of a plane is dark.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import pathlib
import subprocess

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILTERS = [(1, False), (3, False), (9, False), (17, False), (2, True), (9, True), (16, True)]


def test_rows_are_printed_and_written(vxs_path, tmp_path):
    path = vxs_path.parent / "tests" / "bench" / "bias"
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it")
    done = subprocess.run([path, "--stages", "1", "--points", "50", "--largest", "1024", "--json", tmp_path / "bias.json"],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "bias.json").read_text())
    jsonschema.validate(result, json.loads((ROOT / "docs" / "bias.schema.json").read_text()))
    rows = result["rows"]
    assert [(r["light"], r["filter_px"], r["smooth"]) for r in rows] == [(l, *f) for l in ("sun", "spot", "point") for _ in range(3) for f in FILTERS]
    for line, row in zip(done.stdout.splitlines()[1:], rows, strict=True):
        assert line.split()[0] == row["light"] and line.split()[-2:] == [f"{row['gap_texels']:.3f}", f"{row['shift_texels']:.3f}"]
        if row["light"] != "spot" or not row["other_caster_m"]:  # a spot's fixture is in its cone
            assert row["points"] > 0 and row["dark"] == row["lost"] == 0
