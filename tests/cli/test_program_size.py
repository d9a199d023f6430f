# No program for graphics processors is larger than its ceiling in tests/bench/program_sizes.json: SPIR-V instructions, inlined.
# make check counts those of suns and of `vxs render`, VXS_TEST_REPEATS=all all of them.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shutil
import sys

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests" / "bench"))
import program_size

SLACK = 1.02  # other versions of glslang and spirv-opt count slightly different


def test_ceilings(vxs_path):
    if not shutil.which("spirv-opt") or not shutil.which("glslangValidator"):
        pytest.skip("no spirv-opt or glslangValidator: packages spirv-tools, glslang-tools")
    if not (vxs_path.parent / "tests/bench/programs").is_file():
        pytest.skip("no tests/bench/programs: make unit")
    only = "" if os.environ.get("VXS_TEST_REPEATS") == "all" else r"sun|^render"
    found = program_size.sizes(vxs_path.parent, only)
    most = {name: size for name, size in program_size.ceilings().items() if re.search(only, name)}
    assert sorted(found) == sorted(most), "programs and ceilings differ: tests/bench/program_size.py --lower"
    above = {name: (size, most[name]) for name, size in found.items() if size > SLACK * most[name]}
    assert not above, above


@pytest.mark.parametrize("fog, most", [([], 3), (["--fog", "0.02"], 5), (["--fog", "0.02", "--fog-half"], 7)])
def test_a_frame_compiles_few_programs(vxs, tmp_path, monkeypatch, fog, most):
    """A sun alone; with fog, its march and the blend of the fog come in addition; at half the resolution, two more."""
    city, asset, programs = tmp_path / "city.glb", tmp_path / "city.vxs", tmp_path / "programs"
    vxs("scene", "city", "-o", city, "--triangles", 3000)
    vxs("bake", city, "-o", asset, "--resolution", 256)
    programs.mkdir()
    monkeypatch.setenv("MESA_SHADER_CAPTURE_PATH", str(programs))
    vxs("render", city, asset, "-o", tmp_path / "city.png", "--width", 16, "--height", 16, "--samples", 1, *fog)
    assert 0 < len(list(programs.iterdir())) <= most
