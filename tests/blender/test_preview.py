# Previews and pictures of the add-on agree with Blender's own rays, and nothing else of the file changes.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import re

import pytest


@pytest.fixture
def baked(addon, vxs, tmp_path):
    """make(scene, resolution): builds it, or takes the one that is there, and bakes it; returns what `vxs info` says of each light."""

    def make(scene, resolution=512):
        if scene:
            addon("make", scene=scene)
        assert addon("bake", filepath=str(tmp_path / "level.vxs"), resolution=resolution)["outcome"] == ["FINISHED"]
        lights = json.loads(vxs("info", tmp_path / "level.vxs", "--json", "-").stdout)["lights"]
        return {light["name"]: light for light in lights}

    return make


@pytest.mark.parametrize("scene,light", (("mirrored", "sun"), ("mirrored", "spot"), ("boolean", "sun"), ("lamps", "bulb 1"),
                                         ("many", "sun")))
def test_colours_agree_with_rays(scene, light, addon, baked):
    described = baked(scene)[light]
    assert addon("run", operator="preview", light=light, taps=1, points=60000) == ["FINISHED"]
    found = addon("preview_corners", light=light, count=1500, seed=2, texel=described["texel_m"], voxel=described["voxel_m"])
    print(scene, light, found["of"], found["count"], found["lit"], found["differ"], found["unexplained"][:4])
    assert found["count"] == 1500 and 150 < found["lit"] < 1470
    assert found["differ"] < 400 and not found["unexplained"]


def test_it_leaves_nothing_behind(addon, baked):
    baked("mirrored")
    before = addon("datablocks")
    for _ in range(2):
        assert addon("run", operator="preview", points=5000) == ["FINISHED"]
    there = addon("datablocks")
    assert {kind: set(there[kind]) - set(before[kind]) for kind in there if there[kind] != before[kind]} == {
        kind: {"vxs preview"} for kind in ("objects", "meshes", "materials", "collections")}
    assert addon("get", expression="[bpy.data.objects['vxs preview'].hide_render, bpy.data.collections['vxs preview'].hide_render,"
                                   "bpy.data.objects['vxs preview'].hide_select]") == [True] * 3
    assert addon("run", operator="preview_clear") == ["FINISHED"]
    assert addon("datablocks") == before
    assert "poll() failed" in addon("run", operator="preview_clear")


def test_it_is_not_baked(addon, baked, vxs, tmp_path):
    baked("mirrored")
    alone = (tmp_path / "level.vxs").read_bytes()
    assert addon("run", operator="preview", points=5000) == ["FINISHED"]
    assert addon("bake", filepath=str(tmp_path / "again.vxs"), resolution=512)["outcome"] == ["FINISHED"]
    assert (tmp_path / "again.vxs").read_bytes() == alone


def test_what_is_missing_is_one_sentence(addon, baked, tmp_path):
    baked("mirrored")
    assert "has no light 'moon'" in addon("run", operator="preview", light="moon")
    (tmp_path / "level.vxs").write_bytes(b"no shadows")
    assert "level.vxs" in addon("run", operator="preview")
    (tmp_path / "level.vxs").unlink()
    assert "bake first" in addon("run", operator="preview")
    assert "vxs preview" not in addon("datablocks")["objects"]
    assert "Traceback" not in addon.printed(), addon.printed()[-3000:]


def compared(addon):
    """The numbers of the last comparison: answers that differ, of how many, and those of them at no edge."""
    text, is_running = addon("get", expression="[bpy.context.window_manager.vxs.check, bpy.context.window_manager.vxs.is_running]")
    print(text)
    assert not is_running
    found = re.fullmatch(r"(\d+) of (\d+) answers differ from rays, on \S+% of the surface\n(\d+) of them are at no edge of a shadow", text)
    return map(int, found.groups())


@pytest.mark.parametrize("scene,moved", (("mirrored", "left"), ("boolean", None), ("leaves", None)))
def test_a_comparison_with_rays_finds_what_is_wrong(scene, moved, addon, baked):
    baked(scene)
    before = addon("datablocks")
    assert addon("run", operator="check_error", points=1500) == ["FINISHED"]
    differ, checked, far = compared(addon)
    assert checked > 1000 and 0 < differ < checked / 4 and far == 0 and addon("temporary_files") == []
    assert {tuple(colour) for colour in addon("colours")} > {(255, 204, 26)} and (255, 13, 13) not in map(tuple, addon("colours"))
    if moved:
        addon("get", expression=f"setattr(bpy.data.objects['{moved}'], 'location', (1, 2, 1.5))")
        addon("run", operator="preview_clear")
        assert addon("run", operator="check_error", points=1500) == ["FINISHED"]
        differ, checked, far = compared(addon)
        assert far > checked / 100 and (255, 13, 13) in map(tuple, addon("colours"))
    addon("run", operator="preview_clear")
    assert addon("datablocks") == before
    addon("get", expression="[setattr(thing.vxs, 'casts', False) for thing in bpy.data.objects]")
    assert "Nothing casts shadows" in addon("run", operator="check_error", points=100)


@pytest.mark.parametrize("view", ({}, {"roll": 0.4, "shift_x": 0.13, "shift_y": -0.27}, {"sensor_fit": "VERTICAL", "lens": 30},
                                  {"type": "ORTHO", "ortho_scale": 17.0, "shift_x": 0.2}), ids=("plain", "shift", "fit", "orthographic"))
@pytest.mark.parametrize("size", ((320, 200), (200, 320)), ids=("wide", "high"))
def test_a_picture_agrees_with_rays(view, size, addon, baked):
    addon("make", scene="mirrored")
    addon("get", expression="bpy.data.lights.remove(bpy.data.lights['spot'])")
    addon("camera", width=size[0], height=size[1], location=(6, -12, 9), target=(0, 0, 0.5), **view)
    baked(None, 2048)
    for _ in range(2):
        assert addon("run", operator="picture", taps=1) == ["FINISHED"]
    assert addon("datablocks")["images"].count("vxs picture") == 1 and addon("temporary_files") == []
    found = addon("picture_colours", count=2000, seed=3)
    assert found["size"] == list(size)
    means = {}
    for thing in ("sky", "lit", "dark"):
        colours = found["colours"].get(thing, ())
        means[thing] = [sum(channel) / len(colours) for channel in zip(*colours)] if colours else None
        apart = [max(abs(a - b) for a, b in zip(colour, means[thing])) for colour in colours]
        print(thing, len(colours), means[thing], max(apart, default=0))
        assert max(apart, default=0) < (0.06 if thing == "sky" else 0.02)
    assert means["lit"] and means["dark"] and min(a - b for a, b in zip(means["lit"], means["dark"])) > 0.1
