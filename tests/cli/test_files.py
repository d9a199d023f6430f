# Files as people have them: other kinds, too large or endless ones, scenes with hidden nodes, lights that do not shine, materials
# that let light through; in every command that reads a scene. Faults of parts of a scene are in tests/unit/test_scene_gltf.c and
# test_gltf_masks.c.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import gzip
import json
import struct
import subprocess
import time
import zipfile
import zlib

import pytest

import punctual
import small_scene
from conftest import ROOT
from small_scene import GROUND, NOON
from test_docs import validator

SMALL = ("--resolution", 64)
COMMANDS = [("bake", "{scene}", "-o", "{out}.vxs"), ("plan", "{scene}"), ("truth", "{scene}", "--sun", "0,-1,0"), ("compare", "{scene}", "{asset}"),
            ("render", "{scene}", "{asset}", "-o", "{out}.png", "--width", 16, "--height", 16), ("view", "{scene}", "{asset}", "-o", "{out}.html", "--page", "{page}"), ("health", "{scene}"), ("mend", "{scene}", "-o", "{out}.glb"),
            ("bench", "{scene}", "-o", "{out}.json", "--runs", 1, "--points", 0, "--resolution", 64)]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("files") / "small.gltf")


def words(line, **names):
    return [word.format(**names) if isinstance(word, str) else word for word in line]


# --- other kinds --------------------------------------------------------------------------------------------------------------


def zipped(folder, name):
    with zipfile.ZipFile(folder / "z", "w") as archive:
        archive.writestr(name, "x" * 100)
    return (folder / "z").read_bytes()


def tile(magic, header, *lengths, more=b""):
    return magic + struct.pack("<2I", 1, 999) + struct.pack(f"<{len(lengths)}I", *lengths) + more + bytes(header)


def foreign(folder):
    """Beginnings of files: what they hold, and messages about them."""
    export = "(export it as glTF, .glb)"
    text = '{"asset": {"version": "2.0"}}'
    return {
        "lfs": (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n", "a Git LFS pointer, which stands for the file (git lfs pull fetches it)"),
        "fbx": (b"Kaydara FBX Binary  \0\x1a\0", f"FBX {export}"), "fbx_text": (b"; FBX 7.4.0 project file\n", f"FBX {export}"),
        "obj": (b"# Blender 3.4\n\nmtllib a.mtl\no Cube\nv 1 1 1\n", f"OBJ {export}"), "stl": (b"solid x\nfacet normal 0 0 1\n", f"STL {export}"),
        "stl_binary": (bytes(80) + struct.pack("<I", 2) + b"\1" * 100, f"STL {export}"), "ply": (b"ply\nformat ascii 1.0\n", f"PLY {export}"),
        "dae": (b'<?xml version="1.0"?>\n<COLLADA xmlns="x">', f"COLLADA {export}"), "xml": (b'<?xml version="1.0"?>\n<svg/>', f"XML {export}"),
        "usda": (b"#usda 1.0\n", f"USD {export}"), "usdc": (b"PXR-USDC\0\0", f"USD {export}"), "usdz": (zipped(folder, "scene.usdc"), f"USDZ {export}"),
        "blend": (b"BLENDER-v304", f"a Blender file {export}"), "zip": (zipped(folder, "scene.gltf"), "a ZIP archive (unpack it)"),
        "gz": (gzip.compress(text.encode()), "compressed with gzip (decompress it, or give <(zcat FILE))"),
        "zst": (b"\x28\xb5\x2f\xfd\0", "compressed with zstd (decompress it, or give <(zstdcat FILE)"),
        "b3dm": (tile(b"b3dm", 40, 20, 0, 24, 0), "b3dm of 3D Tiles (its glTF begins at byte 72: tail -c +73 FILE > scene.glb)"),
        "i3dm": (tile(b"i3dm", 40, 20, 4, 24, 0, 1), "i3dm of 3D Tiles (its glTF begins at byte 80: tail -c +81 FILE"),
        "cmpt": (tile(b"cmpt", 40, 2), "a composite of 3D Tiles (its first tile begins at byte 16"), "pnts": (tile(b"pnts", 40, 0, 0, 0, 0), "pnts of 3D Tiles, points"),
        "tscn": (b'[gd_scene load_steps=2 format=3]\n', f"a Godot scene {export}"),
        "html": (b"\n<!DOCTYPE HTML>\n<html>", "an HTML page (what was to be fetched is behind it, or the address is wrong)"),
        "utf16": (text.encode("utf-16"), "text in UTF-16 (iconv -f UTF-16 -t UTF-8 makes it UTF-8)"), "utf16le": (text.encode("utf-16-le"), "text in UTF-16"),
        "zeros": (bytes(5000), "nothing but zeros"), "jpeg": (b"\xff\xd8\xff\xe0\0\x10JFIF", "a JPEG picture"),
    }


def test_files_of_other_kinds_are_named(vxs, vxs_path, tmp_path):
    for name, (data, says) in foreign(tmp_path).items():
        path = tmp_path / name
        path.write_bytes(data)
        text = vxs("plan", path, "--sun", "0,-1,0", status=3).stderr
        assert text.startswith(f"vxs: error: '{path}' is {says}") and ", expected a glTF scene: usage is vxs plan SCENE" in text and text.count("\n") == 1
        piped = subprocess.run([vxs_path, "plan", "-", "--sun", "0,-1,0"], input=data, capture_output=True)
        assert piped.returncode == 3 and piped.stderr.decode().startswith(f"vxs: error: 'standard input': is {says}")
        if name != "zeros":
            assert f"'{path}' is {says}" in vxs("info", path, status=3).stderr


def test_scenes_of_other_versions_are_named(vxs, tmp_path):
    for name, data, says in [("v1.glb", b"glTF" + struct.pack("<4I", 1, 20, 0, 0), "GLB version 1, expected 2: binary glTF 1.0 is another format; convert it"),
                             ("v1.gltf", b'{"asset": {"version": "1.0"}}', "asset.version is 1.0, expected 2.0: glTF 1.0 is another format; convert it"),
                             ("tileset.json", b'{"asset": {"version": "1.1"}, "geometricError": 9, "root": {}}', "is a tileset of 3D Tiles: give the glTF files")]:
        (tmp_path / name).write_bytes(data)
        assert f"'{tmp_path / name}': {says}" in vxs("plan", tmp_path / name, "--sun", "0,-1,0", status=3).stderr


def test_what_is_too_large_is_not_read(vxs, vxs_path, scene, tmp_path):
    """20 GB, of zeros and of what may be JSON, and devices without end: within a second, and little memory."""
    begun = time.monotonic()
    for start, says in [(b"", "nothing but zeros"), (b'{"asset":', "is 4 GiB or larger"), (b"glTF\2\0\0\0\x20\0\0\0", "is 4 GiB or larger")]:
        with open(tmp_path / "huge.glb", "wb") as file:
            file.write(start)
            file.truncate(20 << 30)
        assert says in vxs("plan", tmp_path / "huge.glb", "--sun", "0,-1,0", status=3).stderr
        asset = tmp_path / "a.vxs"
        if not asset.exists():
            vxs("bake", scene, "-o", asset, *SMALL)
        assert says in vxs("render", scene, asset, "-o", tmp_path / "a.png", "--moving", tmp_path / "huge.glb", status=3).stderr
    assert "nothing but zeros" in vxs("plan", "/dev/zero", "--sun", "0,-1,0", status=3).stderr
    assert "expected a grid in NRRD" in vxs("bake", scene, "-o", asset, "--smoke", "/dev/zero", status=3).stderr
    assert "not a valid .vxs file" in vxs("info", "/dev/zero", status=3).stderr
    assert "neither a Radiance picture" in vxs("render", scene, asset, "-o", tmp_path / "a.png", "--sky", "/dev/zero", status=3).stderr
    endless = subprocess.run(f"yes v 1 2 3 | '{vxs_path}' plan - --sun 0,-1,0", shell=True, capture_output=True, text=True, timeout=60)
    assert endless.returncode == 3 and "is OBJ" in endless.stderr
    assert time.monotonic() - begun < 20


def test_a_pipe_ends_where_its_glb_does(vxs, vxs_path, tmp_path):
    vxs("scene", "room", "--triangles", 1000, "-o", tmp_path / "room.glb")
    line = f"(cat '{tmp_path}/room.glb'; cat /dev/zero) | '{vxs_path}' plan - --sun 0,-1,0 --resolution 64"
    done = subprocess.run(line, shell=True, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


# --- what a scene hides ---------------------------------------------------------------------------------------------------------


def hidden(path):
    """A block that is hidden with its child, over a ground; a sun, and a lamp that is hidden."""
    small_scene.write(path, boxes=(GROUND, small_scene.BLOCK))
    gltf = json.loads(path.read_text())
    unseen = {"KHR_node_visibility": {"visible": False}}
    half = len(small_scene.box(*GROUND)[1]) * 3
    gltf["accessors"] += [gltf["accessors"][1] | {"count": half}, gltf["accessors"][1] | {"count": half, "byteOffset": 4 * half}]
    for n in 2, 3:
        gltf["meshes"].append({"primitives": [{"attributes": {"POSITION": 0}, "indices": n}]})
    gltf["extensions"]["KHR_lights_punctual"]["lights"].append({"type": "point"})
    gltf["nodes"] = [{"mesh": 1, "name": "ground"}, gltf["nodes"][1], {"mesh": 2, "name": "block", "children": [3], "extensions": unseen},
                     {"mesh": 2, "name": "child", "translation": [3, 0, 0]}, {"name": "lamp off", "extensions": unseen | {"KHR_lights_punctual": {"light": 1}}}]
    gltf["scenes"][0]["nodes"] = [0, 1, 2, 4]
    gltf["extensionsUsed"].append("KHR_node_visibility")
    gltf["extensionsRequired"] = ["KHR_node_visibility"]
    path.write_text(json.dumps(gltf))
    return path


def test_hidden_nodes_are_left_out_and_said(vxs, tmp_path):
    path, out = hidden(tmp_path / "hidden.gltf"), tmp_path / "a.vxs"
    done = vxs("bake", path, "-o", out, *SMALL, "--strict", "--json", tmp_path / "bake.json")
    assert "left out     24 triangles excluded: hidden by KHR_node_visibility, 3 nodes\nleft out     lamp off: hidden\n" in done.stdout and done.stderr == ""
    report = json.loads((tmp_path / "bake.json").read_text())
    validator("bake-report").validate(report)
    assert report["casters"]["excluded"] == [{"rule": "hidden", "triangles": 24}] and report["lights_left_out"] == [{"name": "lamp off", "why": "hidden"}]
    assert vxs("query", out, input="0 0.1 0\n3 0.1 0\n").stdout == "1\n1\n"
    plan = vxs("plan", path, *SMALL, "--json", "-")
    validator("plan").validate(json.loads(plan.stdout))
    assert "1 left out: 0 not requested, 0 that reach no caster, 1 that are dark, hidden or faulty" in vxs("plan", path, *SMALL, "--verbose").stdout
    assert vxs("truth", path, input="0 0.1 0\n3 0.1 0\n").stdout == "1\n1\n"
    assert "12 triangles in 1 components" in vxs("health", path).stdout
    assert "the light of node 4 is hidden" in vxs("bake", path, "-o", out, "--light", "lamp off", status=2).stderr


# --- lights ---------------------------------------------------------------------------------------------------------------------


def lit_by(folder, *found):
    """The small scene with lights, each a point over the ground: members of its definition."""
    path = folder / "lit.gltf"
    path.parent.mkdir(exist_ok=True)
    punctual.copy_with(small_scene.write(folder / "dark.gltf", lights=()), folder, [({"type": "point"} | light, (3 * n - 3, 5, 3), NOON, None) for n, light in enumerate(found)])
    return folder / "dark.gltf"


def test_lights_that_do_not_shine(vxs, tmp_path):
    """Left out of bakes; in pictures of files that have them, black."""
    path, out, png = lit_by(tmp_path, {"name": "on", "range": 20}, {"name": "off", "intensity": 0, "range": 20}), tmp_path / "a.vxs", tmp_path / "a.png"
    done = vxs("bake", path, "-o", out, *SMALL)
    assert done.stderr == "vxs: warning: light 'off' (node 2) is left out: its intensity is 0; set it in the scene, or --light bakes it all the same\n"
    assert "left out     off: dark\n" in done.stdout and "off" not in vxs("info", out).stdout.split("options")[0].replace("left out", "")
    vxs("bake", path, "-o", out, *SMALL, "--strict", status=1)
    vxs("bake", path, "-o", tmp_path / "on.vxs", *SMALL, "--light", "on", "--strict")
    assert "and pictures do not show it" in vxs("bake", path, "-o", out, *SMALL, "--light", "off", "--light", "on").stderr
    seen = ("--width", 32, "--height", 24, "--eye", "0,12,0.1", "--target", "0,0,0")
    for draw in "gl", "rays":
        pictures = []
        for asset, option in (out, ()), (tmp_path / "on.vxs", ()), (out, ("--light", "off")):
            done = vxs("render", path, asset, "-o", png, *seen, "--draw", draw, *option)
            assert ("light 'off' is not drawn: in the scene its intensity is 0; " in done.stderr) == (asset == out)
            pictures.append(png.read_bytes())
        assert pictures[0] == pictures[1] != pictures[2]
    vxs("mend", path, "-o", tmp_path / "mended.glb")
    assert "light 'off' (node 2) is left out: its intensity is 0; " in vxs("bake", tmp_path / "mended.glb", "-o", out, *SMALL).stderr
    mended = punctual.read(tmp_path / "mended.glb")[0]["extensions"]["KHR_lights_punctual"]["lights"]
    assert [light.get("intensity") for light in mended] == [None, 0]


def test_one_bad_light_costs_itself(vxs, tmp_path):
    path, out = lit_by(tmp_path, {"name": "good", "range": 20}, {"name": "bad", "type": "area"}), tmp_path / "a.vxs"
    why = "unknown type 'area', expected directional, spot or point; mend it in the scene"
    assert vxs("bake", path, "-o", out, *SMALL).stderr == f"vxs: warning: light 'bad' (node 2) is left out: {why}\n"
    for options in ("--light", "good"), ("--sun", "0,-1,0"):
        assert vxs("bake", path, "-o", out, *SMALL, *options, "--strict").stderr == ""
    assert f"--light bad: the light of node 2 cannot be baked: {why}" in vxs("bake", path, "-o", out, "--light", "bad", status=2).stderr
    assert vxs("health", path, "--strict").stderr == "" == vxs("compare", path, out, "--points", 100, "--strict").stderr
    assert "light 'bad' (node 2) is left out" in vxs("mend", path, "-o", tmp_path / "m.glb").stderr
    assert f"the scene has no light that can be baked; 'bad': {why}" in vxs("plan", lit_by(tmp_path, {"name": "bad", "type": "area"}), status=5).stderr


def test_lights_are_found_by_their_nodes(vxs, tmp_path):
    path, out = lit_by(tmp_path, {"range": 20}), tmp_path / "a.vxs"
    gltf = json.loads(path.read_text())
    gltf["nodes"][1]["name"] = "Kitchen lamp"
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]))
    gltf["nodes"].append(gltf["nodes"][1] | {"name": "Hall lamp", "translation": [2, 4, 0]})
    path.write_text(json.dumps(gltf))
    assert "lights       2: Kitchen lamp, Hall lamp" in vxs("bake", path, "-o", out, *SMALL).stdout
    assert "light        Hall lamp" in vxs("bake", path, "-o", out, *SMALL, "--light", "Hall lamp").stdout
    assert "no such light; there are Kitchen lamp (point, node 1), Hall lamp (point, node 2): did you mean 'Hall lamp'?" in \
        vxs("plan", path, "--light", "hall lamp", status=2).stderr


# --- materials that let light through -------------------------------------------------------------------------------------------


def png(alphas):
    """Of one row of white pixels."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    raw = b"\0" + b"".join(bytes((255, 255, 255, a)) for a in alphas)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", len(alphas), 1, 8, 6, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def leaf(path, alphas=(255, 0, 0, 0), mode="BLEND", texture="pixels", **material):
    """A card of 2 x 2 m, 2 m over a ground, whose texture has these alphas from left to right."""
    small_scene.write(path, boxes=(GROUND,))
    gltf = json.loads(path.read_text())
    data = struct.pack("<12f", -1, 2, 1, 1, 2, 1, 1, 2, -1, -1, 2, -1) + struct.pack("<8f", 0, 1, 1, 1, 1, 0, 0, 0) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    gltf["buffers"].append({"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()})
    gltf["bufferViews"].append({"buffer": 1, "byteLength": len(data)})
    gltf["accessors"] += [{"bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 4}, {"bufferView": 2, "byteOffset": 48, "componentType": 5126,
                          "type": "VEC2", "count": 4}, {"bufferView": 2, "byteOffset": 80, "componentType": 5123, "type": "SCALAR", "count": 6}]
    gltf["materials"].append({"name": "Leaf", "alphaMode": mode, "doubleSided": True, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}} | material)
    gltf["meshes"].append({"name": "card", "primitives": [{"attributes": {"POSITION": 2, "TEXCOORD_0": 3}, "indices": 4, "material": 1}]})
    gltf["nodes"].append({"mesh": 1, "name": "tree"})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]) - 1)
    gltf |= {"textures": [{"source": 0, "sampler": 0}], "samplers": [{"magFilter": 9728, "wrapS": 33071}],
             "images": [{"uri": "data:image/png;base64," + base64.b64encode(png(alphas)).decode() if texture == "pixels" else texture}]}
    path.write_text(json.dumps(gltf))
    return path


UNDER = "-0.8 0.5 0\n0.5 0.5 0\n1.7 0.5 0\n"  # the opaque quarter, the rest of the card, beside it


def shown(vxs, asset):
    return vxs("query", asset, input=UNDER).stdout.split()


def test_blend_in_every_command(vxs, tmp_path):
    path, out = leaf(tmp_path / "leaf.gltf"), tmp_path / "a.vxs"
    warning = ("vxs: warning: material 1 'Leaf' (node 2 'tree', mesh 1 'card' primitive 0): alphaMode BLEND is baked as a mask, a wall where alpha is 0.5 or more "
               "and nothing elsewhere, 2 triangles; set alphaMode to MASK or OPAQUE, or give --blend: mask says that this is meant, opaque bakes walls, exclude nothing\n")
    assert vxs("bake", path, "-o", out, *SMALL).stderr == warning and shown(vxs, out) == ["0", "1", "1"]
    default = out.read_bytes()
    for blend, lit in ("mask", ["0", "1", "1"]), ("opaque", ["0", "0", "1"]), ("exclude", ["1", "1", "1"]):
        done = vxs("bake", path, "-o", out, *SMALL, "--blend", blend, "--strict", "--json", tmp_path / "r.json")
        report = json.loads((tmp_path / "r.json").read_text())
        validator("bake-report").validate(report)
        assert shown(vxs, out) == lit == vxs("truth", path, "--blend", blend, "--strict", input=UNDER).stdout.split()
        assert report["options"].get("blend", "mask") == blend and ("blend" in report["options"]) == (blend != "mask")
        assert report["casters"]["excluded"] == ([{"rule": "blend", "triangles": 2}] if blend == "exclude" else [])
        assert ("excluded: their materials let light through (--blend)" in done.stdout) == (blend == "exclude")
        assert (f"--blend {blend}" in vxs("info", out).stdout) == (blend != "mask")
        # what was baked with the option is compared and shown with it
        assert "passed" in vxs("compare", path, out, "--points", 2000, *(("--strict",) if blend != "mask" else ())).stdout
        vxs("render", path, out, "-o", tmp_path / "a.png", "--width", 16, "--height", 16, *(("--strict",) if blend != "mask" else ()))
        assert "up to date" in vxs("bake", path, "-o", out, *SMALL, "--blend", blend, "--if-changed").stdout
        triangles = json.loads(vxs("health", path, "--blend", blend, "--json", "-").stdout)["health"]["total"]["triangles"]
        assert triangles == (12 if blend == "exclude" else 14)
        vxs("mend", path, "-o", tmp_path / "m.glb", "--blend", blend)
        assert vxs("truth", tmp_path / "m.glb", "--sun", "0,-1,0", "--strict", input=UNDER).stdout.split() == lit
    vxs("bake", path, "-o", out, *SMALL, "--blend", "opaque")
    vxs("bake", path, "-o", out, *SMALL, "--if-changed")
    assert shown(vxs, out) == ["0", "1", "1"] and out.read_bytes() == default, "another choice is a change"
    result = json.loads(vxs("bench", path, "-o", "-", "--runs", 1, "--points", 100, "--resolution", 64, "--blend", "mask", "--blend", "exclude").stdout)
    validator("bench").validate(result)
    assert [(c["triangles"], c["options"].get("blend")) for c in result["cells"]] == [(14, None), (12, "exclude")]


def test_blend_without_holes_is_a_wall_by_any_reading(vxs, tmp_path):
    """Nothing is said, and the bytes are those of OPAQUE; and of nothing at all, those of a scene without it."""
    out = []
    for name, alphas, mode in ("opaque", (255,) * 4, "OPAQUE"), ("blend", (255,) * 4, "BLEND"):
        vxs("bake", leaf(tmp_path / f"{name}.gltf", alphas, mode), "-o", tmp_path / f"{name}.vxs", *SMALL, "--strict")
        out.append((tmp_path / f"{name}.vxs").read_bytes())
    assert out[0] == out[1]
    vxs("bake", leaf(tmp_path / "clear.gltf", (0,) * 4), "-o", tmp_path / "clear.vxs", *SMALL, "--strict")
    assert shown(vxs, tmp_path / "clear.vxs") == ["1", "1", "1"]


# --- out of the folder ----------------------------------------------------------------------------------------------------------


def test_files_out_of_the_scenes_folder(vxs, tmp_path):
    """A buffer is an error, an image costs its mask; with --allow-outside both are read, by every command."""
    (tmp_path / "in").mkdir()
    path, asset = leaf(tmp_path / "in" / "leaf.gltf", mode="MASK", texture="../leaf.png"), tmp_path / "a.vxs"
    (tmp_path / "leaf.png").write_bytes(png((255, 0, 0, 0)))
    done = vxs("bake", path, "-o", asset, *SMALL)
    assert "image 0 '../leaf.png': '../leaf.png' is not in the scene's folder: --allow-outside reads it" in done.stderr
    assert ": taken as opaque, 2 triangles; store its image as PNG or WebP, or --exclude material:Leaf bakes without it" in done.stderr
    assert shown(vxs, asset) == ["0", "0", "1"]
    gltf = json.loads(path.read_text())
    head, _, data = gltf["buffers"][1]["uri"].partition(",")
    (tmp_path / "card.bin").write_bytes(base64.b64decode(data))
    gltf["buffers"][1]["uri"] = "..%2Fcard.bin"
    path.write_text(json.dumps(gltf))
    names = {"scene": path, "asset": asset, "out": tmp_path / "out", "page": tmp_path / "page"}
    names["page"].write_text("<!--vxs:level:1-->")
    for line in COMMANDS:
        said = vxs(*words(line, **names), status=3, input="").stderr
        assert "buffer 1: '../card.bin' is not in the scene's folder: --allow-outside reads it all the same" in said
    vxs("bake", path, "-o", asset, *SMALL, "--allow-outside", "--strict")
    assert shown(vxs, asset) == ["0", "1", "1"]
    for line in COMMANDS:
        vxs(*words(line, **names), "--allow-outside", "--strict", input="", status=0)


# --- what was found in public files ---------------------------------------------------------------------------------------------


CRATES = "0 .2 0\n1.5 .2 0\n"


@pytest.mark.parametrize("name, options, points, lit, says", [
    ("node_visibility/used", (), CRATES, "1 1", "lies in one plane"),
    ("node_visibility/required", (), CRATES, "1 1", "lies in one plane"),
    ("scene_lists_child/parent_outside", ("--sun", "0,-1,0"), CRATES, "0 1", "node 1 'crate' is not a root"),
    ("scene_lists_child/all_listed", ("--sun", "0,-1,0"), CRATES, "1 0", "node 1 'crate' is listed, and is a child of node 0 'group', too"),
    ("one_bad_light/range0_point", ("--light", "good"), CRATES, "0 1", None),
    ("one_bad_light/range0_directional", ("--light", "good"), CRATES, "0 1", None),
    ("one_bad_light/inner_rounds_over_outer", ("--sun", "0,-1,0"), CRATES, "0 1", None),
    ("one_bad_light/outer_over_90", ("--light", "good"), CRATES, "0 1", None),
    ("one_bad_light/type_area", (), CRATES, "0 1", "light 'bad' (node 3) is left out: unknown type 'area'"),
    ("one_bad_light/zero_scale_directional", (), CRATES, "0 1", "light 'bad' (node 3 'hidden by scale') is left out: it has no direction"),
    ("one_bad_value_refuses_all/nan_position", ("--sun", "0,-1,0"), "1.5 .2 0\n", "1", "--exclude mesh:crate bakes without it"),
    ("one_bad_value_refuses_all/nan_uv", ("--sun", "0,-1,0"), CRATES, "1 1", "is not finite: 2 triangles left out; mend it, or --exclude mesh:branch"),
    ("one_bad_value_refuses_all/no_uv", ("--sun", "0,-1,0"), CRATES, "0 1", "no TEXCOORD_0, which the mask of material 0 'Leaf' needs: taken as opaque"),
    ("one_bad_value_refuses_all/vec3_uv", ("--sun", "0,-1,0"), "1.5 .2 0\n", "1", None),
    ("one_bad_value_refuses_all/ktx2_mask", ("--sun", "0,-1,0"), CRATES, "0 1", "expected PNG, JPEG or WebP beside it: taken as opaque"),
    ("blend_opaque_silent/leaf_and_collider", ("--sun", "0,-1,0"), "-.8 .5 0\n.5 .5 0\n1.7 .5 0\n", "0 1 1", "alphaMode BLEND is baked as a mask"),
    ("blend_opaque_silent/leaf_and_collider", ("--sun", "0,-1,0", "--blend", "opaque"), "-.8 .5 0\n.5 .5 0\n1.7 .5 0\n", "0 0 1", None),
    ("skinned_rest/statue", ("--sun", "0,-1,0", "--skinned", "rest"), CRATES, "0 1", None),
    ("data_uri/du_upper", ("--sun", "0,-1,0"), CRATES, "0 1", None),
    ("data_uri/du_charset", ("--sun", "0,-1,0"), CRATES, "0 1", None),
    ("data_uri/du_empty", ("--sun", "0,-1,0"), CRATES, "0 1", None),
    ("light_names_of_nodes/two_lamps", ("--light", "Kitchen lamp"), "", "", None),
])
def test_cases(vxs, cases, tmp_path, name, options, points, lit, says):
    done = vxs("bake", cases / "files" / f"{name}.gltf", "-o", tmp_path / "a.vxs", "--resolution", 256, *options)
    assert vxs("query", tmp_path / "a.vxs", input=points).stdout.split() == lit.split()
    assert says in done.stderr if says else done.stderr == ""


def test_case_of_colours_of_a_sky(vxs, cases, tmp_path):
    """COLORCORR takes blue away again; a blank behind FORMAT is none."""
    folder, out = cases / "files" / "hdr_colorcorr", tmp_path / "a.vxs"
    vxs("bake", folder / "hdr_scene.gltf", "-o", out, *SMALL, "--sun", "0,-1,0")
    pictures = []
    for sky in "plain", "colorcorr", "format_trailing_blank":
        vxs("render", folder / "hdr_scene.gltf", out, "-o", tmp_path / "a.png", "--sky", folder / f"{sky}.hdr", "--eye", "0,1,8", "--target", "0,3,0", "--fov", 100,
            "--width", 32, "--height", 24)
        pictures.append((tmp_path / "a.png").read_bytes())
    assert pictures[0] == pictures[2] != pictures[1]


def test_case_of_a_light_of_intensity_0(vxs, cases, tmp_path):
    done = vxs("bake", cases / "light" / "plan2.gltf", "-o", tmp_path / "a.vxs", *SMALL)
    assert "light 'zero' (node 13) is left out: its intensity is 0" in done.stderr and "left out     zero: dark" in done.stdout
