# tests/bench/smoke: what it prints is what it writes, and that is what the schema says; what is exact is exact, and bytes are those of the knobs.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import subprocess

import jsonschema
import pytest

from conftest import ROOT


@pytest.mark.slow
def test_smoke(vxs_path, tmp_path):
    program = vxs_path.parent / "tests" / "bench" / "smoke"
    if not program.is_file():
        pytest.skip(f"no program at {program}: build it")
    done = subprocess.run([program, "--side", "32", "--capsules", "200", "--width", "32", "--height", "16", "--rounds", "1", "--json", tmp_path / "s.json"],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads((tmp_path / "s.json").read_text())
    jsonschema.validate(result, json.loads((ROOT / "docs" / "smoke.schema.json").read_text()))
    assert [s["name"] for s in result["scenes"]] == ["smoke columns", "smoke with hair", "leaves"]
    for scene in result["scenes"]:
        cells = {(c["technique"], c["value"]): c for c in scene["cells"]}
        assert len(cells) == len(scene["cells"]) == 24 and scene["merged"] == 0
        assert cells["uncompressed", 1]["rms"] < 1e-4
        assert cells["adaptive", 8]["bytes_per_texel"] == cells["opacity slices", 16]["bytes_per_texel"] == cells["Fourier", 8]["bytes_per_texel"] == 64
        assert all(c["rms"] < 0.2 and c["most"] <= 1 and abs(c["signed_mean"]) <= c["rms"] for c in scene["cells"])
    assert sum(line.startswith("adaptive ") for line in done.stdout.splitlines()) == 4 * 3
