# The add-on as a whole: it comes and goes without traces, changes nothing of the user's file, and writes the same bytes for the same scene.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

import pytest

from blend_file import contents

NAMES = ("光と影", "ضوء وظل", 'say "sun"', "it's", "two\nlines", "x" * 63, "🌞🌿", "a\\b/c", "é=ü,ß;", "--help", "-5", " ",
         "%s{}[0]*?", "光" * 21)


@pytest.fixture
def scene(addon):
    """A scene that bakes in no time."""
    addon("make", scene="mirrored")
    return addon


def lights_of(vxs, file):
    return {light["name"]: light for light in json.loads(vxs("info", file, "--json", "-").stdout)["lights"]}


def test_it_comes_and_goes(addon, vxs_path):
    there = addon("traces")
    assert there["properties"] == ["Light", "Object", "Scene", "WindowManager"] and "bake" in there["operators"] and there["classes"]
    for _ in range(2):
        addon("switch", on=False)
        assert not any(addon("traces").values())
        addon("switch", on=True)
        assert addon("traces") == there
    addon("prefer", vxs=str(vxs_path))  # which went with it
    assert "Traceback" not in addon.printed()


def test_a_bake_says_what_it_wrote(scene, vxs, tmp_path):
    file = tmp_path / "level.vxs"
    baked = scene("bake", filepath=str(file), resolution=256)
    assert baked["outcome"] == ["FINISHED"] and baked["filepath"] == str(file) and not baked["is_running"]
    assert {light: value["resolution_px"] for light, value in lights_of(vxs, file).items()} == {"sun": 256, "spot": 256}
    vxs("validate", file)
    assert "sun: 256 x 256 texels" in baked["result"] and scene("temporary_files") == []


def test_settings_of_scene_and_lights_reach_the_bake(scene, vxs, tmp_path):
    for path, name, value in (("scenes['mirrored'].vxs", "resolution", "512"), ("lights['spot'].vxs", "detail", "TEXEL"),
                              ("lights['spot'].vxs", "texel", 0.05), ("scenes['mirrored'].vxs", "closed", "off"),
                              ("scenes['mirrored'].vxs", "pack", "fast")):
        scene("set", path=f"bpy.data.{path}", name=name, value=value)
    assert scene("bake", filepath=str(tmp_path / "a"))["outcome"] == ["FINISHED"]
    lights = lights_of(vxs, tmp_path / "a.vxs")
    assert lights["sun"]["resolution_px"] == 512 and lights["sun"]["packing"] == "fast" and lights["spot"]["texel_m"] <= 0.05
    options = json.loads(vxs("info", tmp_path / "a.vxs", "--json", "-").stdout)["metadata"]["options"]
    assert options["closed"] == "off"
    scene("set", path="bpy.data.lights['spot'].vxs", name="bake", value=False)
    assert scene("bake", filepath=str(tmp_path / "b.vxs"), closed="auto", pack="small", texel=0.1)["outcome"] == ["FINISHED"]
    lights = lights_of(vxs, tmp_path / "b.vxs")
    assert lights.keys() == {"sun"} and lights["sun"]["packing"] == "small" and lights["sun"]["texel_m"] <= 0.1


def test_a_region(scene, vxs, tmp_path):
    texels = {}
    for region in ("", "middle"):
        assert scene("bake", filepath=str(tmp_path / "a.vxs"), resolution=256, region=region)["outcome"] == ["FINISHED"]
        texels[region] = lights_of(vxs, tmp_path / "a.vxs")["sun"]["texel_m"]
    assert texels["middle"] < 0.3 * texels[""]
    x, y, z = scene("get", expression="list(bpy.data.objects['middle'].matrix_world.translation)")
    points = f"{x} {z + 0.5} {-y}\n{x + 2} {z + 0.5} {-y}\n"
    assert [line.split()[0] == "out" for line in vxs("query", tmp_path / "a.vxs", "--light", "sun", input=points).stdout.splitlines()] == [
        False, True]
    assert "no object 'none'" in scene("bake", filepath=str(tmp_path / "a.vxs"), region="none")["outcome"]


def test_what_is_left_out_is_counted_by_reason(addon, tmp_path):
    addon("make", scene="movers")
    addon("set", path="bpy.context.scene.vxs", name="movers", collection="moving")
    told = {message["text"]: message["named"] for message in addon("bake", filepath=str(tmp_path / "a.vxs"), resolution=64)["messages"]}
    found = {tuple(sorted(name for _, name in named)): text for text, named in told.items()}
    assert {("door", "knob"), ("lift", "on lift"), ("unseen by lamps",), ("no caster",), ("figure",)} <= found.keys(), told


def test_a_message_selects_what_it_names(addon, tmp_path):
    addon("make", scene="leaves")
    messages = addon("bake", filepath=str(tmp_path / "a.vxs"), resolution=64)["messages"]
    number, kinds = next((n, message["named"]) for n, message in enumerate(messages) if "blended" in message["text"])
    assert ["MATERIAL", "hashed"] in kinds or ["MATERIAL", "blend"] in kinds, messages
    addon("get", expression=f"list(bpy.ops.vxs.select_named(index={number}))")
    names = addon("get", expression="[thing.name for thing in bpy.context.view_layer.objects if thing.select_get()]")
    assert names and all(name.startswith("leaf") for name in names)


def test_nothing_of_the_file_changes(addon, tmp_path):
    for scene in ("leaves", "particles", "movers", "boolean"):
        addon("make", scene=scene)
        # as the panel does: now the scene has settings
        addon("get", expression="[getattr(bpy.context.scene.vxs, each.identifier) for each in bpy.context.scene.vxs.bl_rna.properties]"
                                " and None")
        addon("save", path=str(tmp_path / f"{scene}.blend"))
        copies = []
        for n in range(4):
            if n == 3:
                dirty = addon("get", expression="bpy.data.is_dirty")
                assert addon("bake", resolution=128, force=True)["outcome"] == ["FINISHED"]
                assert addon("get", expression="bpy.data.is_dirty") == dirty
            addon("save_copy", path=str(tmp_path / "copy.blend"))
            copies.append(contents(tmp_path / "copy.blend"))
        before, after = copies[2], copies[3]
        noise = {at for copy in copies[:2] if copy != before for at in range(len(before)) if copy[at] != before[at]}  # addresses
        assert len(before) == len(after) and len(noise) < 100
        assert [at for at in range(len(before)) if before[at] != after[at] and at not in noise] == [], scene
        assert (tmp_path / f"{scene}.vxs").is_file(), "beside the .blend"


def test_the_same_scene_gives_the_same_bytes(addon, tmp_path):
    for scene in ("many", "nodes", "leaves", "decimated"):
        files = []
        for n in range(2):
            addon("make", scene=scene)
            for again in range(2):
                files.append(tmp_path / f"{scene}-{n}-{again}.vxs")
                assert addon("bake", filepath=str(files[-1]), resolution=256)["outcome"] == ["FINISHED"]
        assert len({file.read_bytes() for file in files}) == 1


def test_only_what_changed_is_baked(scene, tmp_path):
    file = tmp_path / "level.vxs"
    first = scene("bake", filepath=str(file), resolution=256)
    at = file.stat().st_mtime_ns
    again = scene("bake", filepath=str(file), resolution=256)
    assert "unchanged" in again["result"] and "unchanged" not in first["result"] and file.stat().st_mtime_ns == at
    assert "unchanged" not in scene("bake", filepath=str(file), resolution=256, force=True)["result"]
    scene("set", path="bpy.data.objects['left']", name="location", value=[-3, 0.5, 1])
    assert "unchanged" not in scene("bake", filepath=str(file), resolution=256)["result"]


@pytest.mark.parametrize("name", NAMES)
def test_names_in_any_script(scene, name, vxs, tmp_path):
    for path in ("objects['left']", "meshes['wedge']", "lights['sun']", "objects['sun']", "scenes['mirrored']"):
        scene("set", path=f"bpy.data.{path}", name="name", value=name)
    given = scene("get", expression="next(light.name for light in bpy.data.lights if light.type == 'SUN')")
    scene("set", path=f"bpy.data.lights[{given!r}].vxs", name="detail", value="RESOLUTION")
    scene("set", path=f"bpy.data.lights[{given!r}].vxs", name="resolution", value="512")
    folder = tmp_path / name.replace("/", "_").strip()
    folder.mkdir(exist_ok=True)
    file = folder / "level.vxs"
    baked = scene("bake", filepath=str(file), resolution=256)
    assert baked["outcome"] == ["FINISHED"], baked
    lights = lights_of(vxs, file)
    assert lights[given]["resolution_px"] == 512 and lights["spot"]["resolution_px"] == 256


def test_a_file_that_was_never_saved(scene, tmp_path):
    for arguments in ({}, {"filepath": "//level.vxs"}):
        outcome = scene("bake", resolution=64, **arguments)["outcome"]
        assert isinstance(outcome, str) and "never saved" in outcome
    assert scene("bake", resolution=64, filepath=str(tmp_path / "a.vxs"))["outcome"] == ["FINISHED"]


def test_a_bake_in_edit_mode(scene, tmp_path):
    scene("get", expression="[setattr(bpy.context.view_layer.objects, 'active', bpy.data.objects['left']), "
                            "list(bpy.ops.object.mode_set(mode='EDIT'))][1]")
    assert scene("bake", filepath=str(tmp_path / "a.vxs"), resolution=64)["outcome"] == ["FINISHED"]
    assert scene("get", expression="bpy.context.mode") == "EDIT_MESH"
    scene("get", expression="list(bpy.ops.object.mode_set(mode='OBJECT'))")


def test_nothing_to_bake(addon, tmp_path):
    addon("make", scene="mirrored")
    addon("get", expression="[setattr(thing, 'hide_render', True) for thing in bpy.data.objects if thing.type == 'LIGHT'] and None")
    assert "No light" in addon("bake", filepath=str(tmp_path / "a.vxs"))["outcome"]
    addon("get", expression="[setattr(thing, 'hide_render', thing.type != 'LIGHT') for thing in bpy.data.objects] and None")
    assert "Nothing casts shadows" in addon("bake", filepath=str(tmp_path / "a.vxs"))["outcome"]
    assert not list(tmp_path.iterdir()) and addon("temporary_files") == []
