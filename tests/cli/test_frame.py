# vxs render: one frame with everything: baked shadows, what moves, smoke, an area light, and fog by what the plan chooses for each
# light.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

import jsonschema

import small_scene
from conftest import ROOT
from test_area import BESIDE, add_quads
from test_render_smoke import add_balls


def test_everything(vxs, tmp_path):
    """Each part is drawn, each has a stage, a pass, and a line of the plan; all of it may be streamed."""
    level, asset, moving = tmp_path / "level.gltf", tmp_path / "level.vxs", tmp_path / "moving.gltf"
    small_scene.write(level, lights=small_scene.EACH_KIND)
    vxs("bake", level, "-o", asset, "--resolution", 256)
    add_quads(level, [(*BESIDE, [1, 0.5, 0.25])])
    add_balls(level, [((-3, 2, 0), 0.6, 1)], level)
    small_scene.write(moving, boxes=[((3, 1, 2), (3.5, 1.5, 2.5))], lights=[])

    def frame(*options):
        said = vxs("render", level, asset, "-o", tmp_path / "out.png", "--width", 64, "--height", 48, "--samples", 1, "--eye", "7,9,6", "--target", "0,1,0",
                   "--fog", 0.05, "--moving", moving, "--area", 8, "--json", tmp_path / "r.json", "--verbose", "--force", *options).stdout
        found = json.loads((tmp_path / "r.json").read_text())
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(found)
        return said, found

    said, found = frame("--passes", tmp_path / "passes")
    last = found["frames"][-1]
    assert {"moving", "surfaces", "shade", "smoke", "area", "fog", "tone"} <= last["ms"].keys()
    assert last["moving"] == {"lights": 3, "maps": 3, "left_out": 0} and last["smoke_lights"]["dims"] == 3 and last["area_lights"]["drawn"] == 1
    assert {light["by"] for light in found["fog"]["lights"]} == {"angles"} and all(light["why"] for light in found["fog"]["lights"])
    assert {path.name for path in (tmp_path / "passes").iterdir()} >= {"light.png", "airlight.png", "transmittance.png", "smoke.png", "area.png", "depth.png"}
    for line in ("moving       seen by 3 lights", "smoke        1 capsules; 3 lights", "area         1 parallelogram", "fog          3 lights: 3 drawn"):
        assert line in said
    whole = (tmp_path / "out.png").read_bytes()
    frame("--budget", "16M")
    assert (tmp_path / "out.png").read_bytes() == whole
