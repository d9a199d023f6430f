# Scenes as people make them, exported by hand and baked: lookups agree with Blender's own rays, but for what the size of a texel and
# the bias explain, or what the exporter is known to get wrong.
# SPDX-License-Identifier: GPL-3.0-or-later
import collections
import json

import pytest

SCENES = ("instances", "mirrored", "array", "decimated", "boolean", "centimetres", "leaves", "lamps", "dome", "many", "particles", "nodes", "shapes", "sheared")
# what the exporter leaves out or gets wrong in versions before one
EXPORTER = {
    ("nodes", (3, 6)): "it leaves out instances of geometry nodes",
    ("shapes", (3, 6)): "it leaves out metaballs",
    ("sheared", (99, 0)): "it writes matrices that have shear as a translation, a rotation and a scale",
}
POINTS = 3000
RESOLUTION = 1024


def answers_of(vxs, file, points):
    """Of each light by its name: 1, 0 or None at each point; and what `vxs info` says of it."""
    described = json.loads(vxs("info", file, "--json", "-").stdout)["lights"]
    rows = [line.split() for line in vxs("query", file, input="\n".join(points) + "\n").stdout.splitlines()]
    assert len(rows) == len(points)
    columns = [[None if word == "out" else round(float(word)) for word in column] for column in zip(*rows)]
    return {light["name"]: column for light, column in zip(described, columns)}, {light["name"]: light for light in described}


def explain(blender, vxs, file, truth):
    """How many answers differ, and the numbers of those that nothing explains, by light."""
    given, described = answers_of(vxs, file, truth["points"])
    counts, unexplained = {}, {}
    assert given.keys() == truth["answers"].keys()
    for name, right in truth["answers"].items():
        differ = [(n, given[name][n]) for n in range(len(right)) if given[name][n] != right[n]]
        why = blender("explain", light=name, texel=described[name]["texel_m"], voxel=described[name]["voxel_m"], differ=differ)
        counts[name] = len(differ)
        unexplained[name] = [(n, answer, truth["points"][n]) for (n, answer), reason in zip(differ, why) if reason is None]
    return counts, unexplained


def bake_by_hand(scene, blender, vxs, folder):
    blender("make", scene=scene)
    blender("export", path=str(folder / "level.glb"))
    vxs("bake", folder / "level.glb", "-o", folder / "level.vxs", "--resolution", RESOLUTION)
    return folder / "level.vxs"


@pytest.mark.parametrize("scene", SCENES)
def test_a_file_that_the_exporter_wrote_by_hand(scene, blender, vxs, tmp_path):
    file = bake_by_hand(scene, blender, vxs, tmp_path)
    truth = blender("receivers", count=POINTS, seed=1)
    counts, unexplained = explain(blender, vxs, file, truth)
    fault = next((why for (name, until), why in EXPORTER.items() if name == scene and tuple(blender("version")) < until), None)
    if fault:
        assert sum(map(len, unexplained.values())) > 0.01 * POINTS, f"no fault of the exporter any more: {fault}"
    else:
        assert not any(unexplained.values())
