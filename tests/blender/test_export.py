# Exports of Blender's glTF exporter: the add-on bakes beside them and names the file in them. An export never fails because of it.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import shutil
import struct
import subprocess
from urllib.parse import unquote

import pytest
from conftest import FOLDER, ROOT

EXTENSION = "VXS_baked_shadows"


def json_of(path):
    data = path.read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data)
    length, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length])


def light_names(file):
    """As vxs names lights of an exported file: that of the definition where one node uses it, else of the node."""
    defined = [light["name"] for light in file["extensions"]["KHR_lights_punctual"]["lights"]]
    nodes = [(node["extensions"]["KHR_lights_punctual"]["light"], node["name"]) for node in file["nodes"]
             if "KHR_lights_punctual" in node.get("extensions", {})]
    users = [light for light, _ in nodes]
    return {defined[light] if users.count(light) == 1 else name for light, name in nodes}


@pytest.fixture
def scene(addon):
    addon("make", scene="mirrored")
    addon("set", path="bpy.context.scene.vxs", name="resolution", value="256")
    return addon


@pytest.mark.parametrize("name,form", [("level.glb", "GLB"), ("a b %41#光é&.glb", "GLB"), ("level.gltf", "GLTF_SEPARATE")])
def test_a_file_names_its_shadows(name, form, scene, vxs, tmp_path):
    assert scene("export_level", path=str(tmp_path / name), export_format=form) == ["FINISHED"]
    file = json_of(tmp_path / name)
    uri = file["extensions"][EXTENSION]["uri"]
    shadows = tmp_path / unquote(uri)
    assert EXTENSION in file["extensionsUsed"] and EXTENSION not in file.get("extensionsRequired", ())
    assert uri.isascii() and " " not in uri and "#" not in uri and shadows == (tmp_path / name).with_suffix(".vxs")
    vxs("validate", shadows)
    described = json.loads(vxs("info", shadows, "--json", "-").stdout)
    assert {light["name"] for light in described["lights"]} == light_names(file) == {"sun", "spot"}
    made = shadows.stat().st_mtime_ns, shadows.stat().st_ino
    assert scene("export_level", path=str(tmp_path / name), export_format=form) == ["FINISHED"]
    assert (shadows.stat().st_mtime_ns, shadows.stat().st_ino) == made, "it was baked again although nothing changed"
    scene("get", expression="setattr(bpy.data.objects['left'], 'location', (0, 4, 1))")
    assert scene("export_level", path=str(tmp_path / name), export_format=form) == ["FINISHED"]
    assert (shadows.stat().st_mtime_ns, shadows.stat().st_ino) != made, "it was not baked again although an object moved"


@pytest.mark.parametrize("made,form,way", (("lamps", "GLB", "EXTENSION"), ("mirrored", "GLTF_SEPARATE", "EXTRAS"),
                                           ("centimetres", "GLB", "EXTRAS")))
def test_lights_match_in_three_js(made, form, way, addon, tmp_path):
    """The package reads what was exported: each light has its shadow, at its place."""
    web = ROOT / "build/web"
    if not shutil.which("node") or not (web / "vxs/three").is_dir():
        pytest.skip("no package vxs in build/web: make web")
    (tmp_path / "node_modules").mkdir()
    for name, path in (("vxs", web / "vxs"), ("three", web / "node_modules/three")):
        (tmp_path / "node_modules" / name).symlink_to(path)
    shutil.copy(FOLDER / "read_export.mjs", tmp_path)
    addon("make", scene=made)
    addon("get", expression="setattr(bpy.data.lights[0], 'name', 'Lämp. %41 [1]')")
    addon("set", path="bpy.context.scene.vxs", name="resolution", value="256")
    addon("set", path="bpy.context.scene.vxs", name="export_as", value=way)
    file = tmp_path / ("a b#光.glb" if form == "GLB" else "a b#光.gltf")
    assert addon("export_level", path=str(file), export_format=form) == ["FINISHED"]
    done = subprocess.run(["node", tmp_path / "read_export.mjs", file], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    read = json.loads(done.stdout)
    print(read)
    assert {name for name, _ in read["matched"]} == light_names(json_of(file))
    assert not any(moved for _, moved in read["matched"]) and read["lights"] == read["baked"] == 0


def test_settings_of_the_export(scene, tmp_path):
    scene("set", path="bpy.context.scene.vxs", name="export_as", value="EXTRAS")
    assert scene("export_level", path=str(tmp_path / "a.glb"), export_extras=True) == ["FINISHED"]
    file = json_of(tmp_path / "a.glb")
    assert file["extras"] == {"vxs_shadows": "a.vxs"} and EXTENSION not in file.get("extensions", ())
    assert "vxs" not in json.dumps([file["nodes"], file["scenes"], file["extensions"]]), "settings of the add-on are in the file"
    scene("set", path="bpy.context.scene.vxs", name="export", value=False)
    assert scene("export_level", path=str(tmp_path / "b.glb")) == ["FINISHED"]
    assert "vxs" not in (tmp_path / "b.glb").read_bytes().decode("latin-1").lower() and not (tmp_path / "b.vxs").exists()


def test_the_preview_is_not_exported(scene, tmp_path):
    assert scene("bake", filepath=str(tmp_path / "level.vxs"), resolution=256)["outcome"] == ["FINISHED"]
    scene("export_level", path=str(tmp_path / "before.glb"))
    assert scene("run", operator="preview", points=5000) == ["FINISHED"]
    scene("export_level", path=str(tmp_path / "after.glb"))
    before, after = json_of(tmp_path / "before.glb"), json_of(tmp_path / "after.glb")
    assert [node["name"] for node in after["nodes"]] == [node["name"] for node in before["nodes"]]
    assert (tmp_path / "before.vxs").read_bytes() == (tmp_path / "after.vxs").read_bytes()


@pytest.mark.parametrize("why,more", (("they need +Y Up", {"export_yup": False}), ("/nowhere/vxs is not", {"vxs": "/nowhere/vxs"}),
                                      ("vxs failed", {"vxs": "/bin/false"}), ("No light is baked", {"remove": True}),
                                      ("level.vxs", {"locked": True})))
def test_an_export_never_fails_because_of_shadows(why, more, scene, vxs_path, tmp_path):
    path, printed = tmp_path / "level.glb", len(scene.printed())
    if "vxs" in more:
        scene("prefer", vxs=more["vxs"])
    if "remove" in more:
        scene("get", expression="[bpy.data.lights.remove(light) for light in list(bpy.data.lights)]")
    if "locked" in more:
        (tmp_path / "level.vxs").mkdir()  # also root cannot write a file there
    try:
        options = {key: value for key, value in more.items() if key.startswith("export")}
        assert scene("export_level", path=str(path), **options) == ["FINISHED"]
    finally:
        scene("prefer", vxs=str(vxs_path))
    assert EXTENSION not in json.dumps(json_of(path)) and not os.path.isfile(tmp_path / "level.vxs")
    said = scene.printed()[printed:]
    assert why in said.split("Exported without baked shadows: ")[1].splitlines()[0] and "Traceback" not in said
