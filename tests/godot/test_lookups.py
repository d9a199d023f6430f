# Lookups in Godot's shading language: voxels to the bit, points as far as floats go, of lights of palette blocks (voxels.py).
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import struct

import voxels
from project import ROOT

WIDTHS = {0: [1, 9], 1: [-4], 2: [9, -16], 3: [1, -4]}


def test_lookups_are_those_of_c(godot, vxs, tmp_path):
    library = [f"-I{ROOT}/runtime", f"-I{ROOT}/formats", str(ROOT / "build/release/libvxs.a"), "-lzstd", "-lxxhash"]
    program = voxels.compile_places(tmp_path, library)
    vxs("export", ROOT / "tests/golden/blocks.vxs", "-o", tmp_path / "export", "--axes", "godot")
    files = {f"export/{path.name}": path.read_bytes() for path in (tmp_path / "export").iterdir()}
    cases, wanted = [], []
    for light, widths in WIDTHS.items():
        for width in widths:
            here = tmp_path / f"{light}.{width}"
            _, of_voxels, _, of_points, _, _ = voxels.write_places(program, here, "blocks", light, width, ROOT)
            for rows in ("voxels", "points"):
                name = f"{rows}.{light}.{width}"
                files[name] = (here / rows).read_bytes()
                cases.append({"rows": name, "light": light, "width": width, "in_world": rows == "points"})
            wanted += [[lit for _, lit in of_voxels], of_points]
    result = godot(files | {"main.gd": (ROOT / "tests/godot/lookups.gd").read_text(), "cases.json": json.dumps(cases)})
    assert result.faults == []
    assert set(result.values) == {case["rows"] for case in cases}
    for case, answers in zip(cases, wanted):
        found = list(struct.unpack("<1024f", result.values[case["rows"]]))
        if case["in_world"]:
            voxels.check_points(found, answers)
        else:
            assert found == answers and len(set(found)) > 1, case
