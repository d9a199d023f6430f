# Spot and point lights in real scenes, against rays: lamps of 1, 60, 120 and 179 degrees and a point light are hung into a copy of
# each, baked and compared.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

import pytest

import punctual

SCENES = ["camp_and_cave_two_scenes", "chess_board", "dream_apartment", "dutch_ship_mask", "japanese_bridge_garden", "kaykit_city",
          "kaykit_city_gpu_instancing", "low_poly_terrain", "mountains_heightfield", "pandora_indoor", "room_with_spheres_closed",
          "skylight_hall_directional", "sponza", "stanford_bunny_closed", "sunlit_primitives", "truck_town", "voxel_district"]
LARGE = ["dream_apartment", "dutch_ship_mask", "kaykit_city_gpu_instancing", "mountains_heightfield", "stanford_bunny_closed", "voxel_district"]


def bounds(vxs, scene, folder):
    vxs("bake", scene, "-o", folder / "small.vxs", "--sun", "0,-1,0", "--resolution", 8, "--json", folder / "small.json")
    casters = json.loads((folder / "small.json").read_text())["casters"]
    return casters["min_m"], casters["max_m"]


def hung(scene, box, folder):
    """A copy of the scene with lamps, at shares of its bounds; beside it stands what a lamp's own file would refer to."""
    def at(*shares):
        return [low + (high - low) * share for low, high, share in zip(*box, shares)]
    eye = at(0.1, 1.2, 0.2)
    to_middle = [b - a for a, b in zip(eye, at(0.5, 0.4, 0.5))]
    folder.mkdir()
    return punctual.copy_with(scene, folder, [punctual.spot("narrow", eye, to_middle, 1),
                                           punctual.spot("sixty", at(0.3, 0.8, 0.6), (0.3, -1, -0.2), 60),
                                           punctual.spot("wide", at(0.45, 0.9, 0.4), (-0.1, -1, 0.3), 120),
                                           punctual.spot("half", at(0.52, 1.1, 0.55), (0.2, -1, 0.1), 179),
                                           punctual.point("bulb", at(0.41, 0.62, 0.57))])


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) if name in LARGE else name for name in SCENES])
def test_punctual_lights_against_rays(vxs, scenes, tmp_path, name):
    source = scenes / "real" / f"{name}.glb"
    if not source.is_file():
        pytest.skip(f"{source} is not there")
    scene = hung(source, bounds(vxs, source, tmp_path), tmp_path / "lamps")
    vxs("bake", scene, "-o", tmp_path / "a.vxs", "--resolution", 256)
    vxs("compare", scene, tmp_path / "a.vxs", "--points", 4000, "--json", tmp_path / "c.json")  # status 1: something is unexplained
    compared = json.loads((tmp_path / "c.json").read_text())["assets"][0]["lights"]
    assert [light["name"] for light in compared] == ["narrow", "sixty", "wide", "half", "bulb"]
    assert all(light[kind]["checked"] > 1000 and light[kind]["unexplained"] == 0
               for light in compared for kind in ("random", "surface"))


def test_errors_shrink_with_texels(vxs, scenes, tmp_path):
    source = scenes / "real" / "japanese_bridge_garden.glb"
    if not source.is_file():
        pytest.skip(f"{source} is not there")
    scene = hung(source, bounds(vxs, source, tmp_path), tmp_path / "lamps")
    wrong = {}
    for resolution in (128, 1024):
        vxs("bake", scene, "-o", tmp_path / "a.vxs", "--resolution", resolution, "--light", "wide", "--light", "bulb")
        vxs("compare", scene, tmp_path / "a.vxs", "--points", 20000, "--json", tmp_path / "c.json")
        for light in json.loads((tmp_path / "c.json").read_text())["assets"][0]["lights"]:
            counts = light["random"]
            wrong.setdefault(light["name"], []).append((counts["leaks"] + counts["false_shadows"]) / counts["checked"])
    for coarse, fine in wrong.values():
        assert fine < coarse / 3
