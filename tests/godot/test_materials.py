# Converted materials beside those of Godot.
# SPDX-License-Identifier: GPL-3.0-or-later
from conftest import ROOT


def test_converted_materials_look_like_standard_ones(godot):
    result = godot({"main.gd": (ROOT / "tests/godot/materials.gd").read_text()})
    assert result.faults == []
    assert result.values["unshaded"] == "true"
    before, after = result.values["standard"], result.values["converted"]
    for ball in range(8):  # each has a quarter of the width and half of the height, in which it is lit
        left, top = 80 * (ball % 4), 120 * (ball // 4)
        at = [3 * (x + 320 * y) + c for y in range(top, top + 120) for x in range(left, left + 80) for c in range(3)]
        shown, apart = sum(before[n] > 20 for n in at), [abs(before[n] - after[n]) for n in at]
        assert shown > 3000 and sum(x > 3 for x in apart) < shown / 100, (ball, shown, max(apart), sum(x > 3 for x in apart))
