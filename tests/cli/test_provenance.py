# An asset knows its scene: what its metadata say, what compare and picture say to another scene, and when --if-changed does
# nothing.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import os
import re
import shutil
import struct
import subprocess
import zlib

import pytest

import damage
import small_scene
from test_docs import validator

SMALL = ("--resolution", 64)
LIGHTS = (("sun", "directional", small_scene.NOON), ("lamp", "spot", small_scene.NOON), ("bulb", "point", small_scene.NOON))


def png(side, alpha):
    """An image of alpha alone: alpha(x, y)."""
    rows = b"".join(b"\0" + bytes(v for x in range(side) for v in (255, 255, 255, alpha(x, y))) for y in range(side))
    chunks = ((b"IHDR", struct.pack(">2I5B", side, side, 8, 6, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
                                           for kind, data in chunks)


def uri(data, kind="application/octet-stream"):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


def data_of(gltf, buffer=0):
    return bytearray(base64.b64decode(gltf["buffers"][buffer]["uri"].partition(",")[2]))


def sieve(x, y):
    return 255 * ((x ^ y) & 1)


def write_scene(path, alpha=sieve, lights=LIGHTS, boxes=(small_scene.GROUND, small_scene.BLOCK), eye=(0, 9, 0), cutoff=0.5):
    """A ground and a block with holes, three lights, a camera."""
    small_scene.write(path, boxes=boxes, lights=lights)
    gltf = json.loads(path.read_text())
    count = gltf["accessors"][0]["count"]
    uv = b"".join(struct.pack("<2f", n & 1, n >> 1 & 1) for n in range(count))
    gltf["buffers"].append({"byteLength": len(uv), "uri": uri(uv)})
    gltf["bufferViews"].append({"buffer": 1, "byteLength": len(uv)})
    gltf["accessors"].append({"bufferView": 2, "componentType": 5126, "type": "VEC2", "count": count})
    gltf["materials"].append({"alphaMode": "MASK", "alphaCutoff": cutoff, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
    gltf |= {"textures": [{"source": 0}], "images": [{"uri": uri(png(8, alpha), "image/png")}], "cameras": [
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]}
    plain = gltf["meshes"][0]["primitives"][0]
    per_box = 36
    last = (len(boxes) - 1) * per_box
    view = gltf["accessors"][1]
    gltf["accessors"].append(view | {"count": per_box, "byteOffset": 4 * last})
    view["count"] = last
    gltf["meshes"][0]["primitives"].append({"attributes": plain["attributes"] | {"TEXCOORD_0": 2}, "indices": 3, "material": 1})
    gltf["nodes"].append({"camera": 0, "translation": list(eye)})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]) - 1)
    path.write_text(json.dumps(gltf))
    return path


def edited(scene, path, change):
    """A copy of a scene whose JSON, or what that leads to, is changed."""
    gltf = json.loads(scene.read_text())
    change(gltf)
    path.write_text(json.dumps(gltf))
    return path


def move_a_vertex(gltf):
    data = data_of(gltf)
    struct.pack_into("<f", data, 4, struct.unpack_from("<f", data, 4)[0] - 2**-20)
    gltf["buffers"][0]["uri"] = uri(data)


def one_pixel_opaque(gltf):
    gltf["images"][0]["uri"] = uri(png(8, lambda x, y: 255 if (x, y) == (2, 4) else sieve(x, y)), "image/png")


def node_named(gltf, name):
    return next(node for node in gltf["nodes"] if node.get("name") == name)


def turn_the_sun(gltf):
    node_named(gltf, "sun")["rotation"] = small_scene.turned((1e-6, -1, 0))


def move_the_lamp(gltf):
    node_named(gltf, "lamp")["translation"] = [0, 6.5, 0]


def narrow_the_lamp(gltf):
    gltf["extensions"]["KHR_lights_punctual"]["lights"][1] |= {"spot": {"outerConeAngle": 0.7}, "range": 50}


def lamp_to_bulb(gltf):
    gltf["extensions"]["KHR_lights_punctual"]["lights"][1]["type"] = "point"
    del gltf["extensions"]["KHR_lights_punctual"]["lights"][1]["spot"]


def no_lamp(gltf):
    del node_named(gltf, "lamp")["extensions"]


def move_the_camera(gltf):
    gltf["nodes"][-1]["translation"] = [0, 9.5, 0]


CHANGES = [
    (move_a_vertex, "geometry"),
    (one_pixel_opaque, "alpha masks"),
    (lambda gltf: gltf["materials"][1].update(alphaCutoff=0.25), "alpha masks"),
    (lambda gltf: gltf["materials"][0].update(doubleSided=True), "geometry"),
    (turn_the_sun, "light 'sun': direction"),
    (move_the_lamp, "light 'lamp': position"),
    (narrow_the_lamp, "light 'lamp': range, cone"),
    (lamp_to_bulb, "light 'lamp': kind, direction, cone"),
    (no_lamp, "light 'lamp': not there"),
    (move_the_camera, "cameras"),
]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return write_scene(tmp_path_factory.mktemp("scene") / "level.gltf")


@pytest.fixture(scope="module")
def asset(vxs, scene, tmp_path_factory):
    path = tmp_path_factory.mktemp("asset") / "level.vxs"
    vxs("bake", scene, "-o", path, *SMALL)
    return path


def info(vxs, path):
    report = json.loads(vxs("info", path, "--json", "-").stdout)
    validator("info").validate(report)
    return report


def made(vxs, path):
    return info(vxs, path)["metadata"]


# --- the same scene in other files -----------------------------------------------------------------------------------------------


def to_glb(gltf):
    body, views = b"", []
    for buffer in range(len(gltf["buffers"])):
        views.append(len(body))
        body += data_of(gltf, buffer)
    for view in gltf["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + views[view["buffer"]]
        view["buffer"] = 0
    gltf["buffers"] = [{"byteLength": len(body)}]
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    body += b"\0" * (-len(body) % 4)
    return (struct.pack("<4s2I", b"glTF", 2, 28 + len(text) + len(body)) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(body), b"BIN\0") + body)


def short_indices_behind_a_gap(gltf):
    """Indices of 16 bits, in front of positions that are interleaved with something else."""
    data, at = data_of(gltf), gltf["bufferViews"][1]["byteOffset"]
    indices = struct.unpack(f"<{(len(data) - at) // 4}I", data[at:])
    short = struct.pack(f"<{len(indices)}H", *indices) + b"\xee" * 8
    wide = b"".join(data[n:n + 12] + b"\x77" * 8 for n in range(0, at, 12))
    gltf["buffers"][0] = {"byteLength": len(short) + len(wide), "uri": uri(short + wide)}
    gltf["bufferViews"][0] = {"buffer": 0, "byteOffset": len(short), "byteLength": len(wide), "byteStride": 20}
    gltf["bufferViews"][1] = {"buffer": 0, "byteLength": len(short) - 8}
    for accessor in (gltf["accessors"][1], gltf["accessors"][3]):
        accessor["componentType"] = 5123
        accessor["byteOffset"] = accessor.get("byteOffset", 0) // 2


def vertices_of_their_own(gltf):
    """No vertex is shared, and no index is needed."""
    data, at = data_of(gltf), gltf["bufferViews"][1]["byteOffset"]
    uvs = data_of(gltf, 1)
    indices = struct.unpack(f"<{(len(data) - at) // 4}I", data[at:])
    positions = b"".join(data[12 * n:12 * n + 12] for n in indices)
    uv = b"".join(uvs[8 * n:8 * n + 8] for n in indices)
    first, count = gltf["accessors"][1]["count"], len(indices)
    gltf["buffers"] = [{"byteLength": len(b), "uri": uri(b)} for b in (positions, uv)]
    gltf["bufferViews"] = [{"buffer": n, "byteLength": b["byteLength"]} for n, b in enumerate(gltf["buffers"])]
    bounds = {key: gltf["accessors"][0][key] for key in ("min", "max")}

    def accessor(view, begin, end):
        kind, size = (("VEC3", 12), ("VEC2", 8))[view]
        return {"bufferView": view, "byteOffset": size * begin, "componentType": 5126, "type": kind, "count": end - begin} | (
            bounds if view == 0 else {})

    gltf["accessors"] = [accessor(0, 0, first), accessor(0, first, count), accessor(1, first, count)]
    primitives = gltf["meshes"][0]["primitives"]
    primitives[0] |= {"attributes": {"POSITION": 0}}
    primitives[1] |= {"attributes": {"POSITION": 1, "TEXCOORD_0": 2}}
    for primitive in primitives:
        del primitive["indices"]


def buffers_in_files(folder, gltf):
    for n, buffer in enumerate(gltf["buffers"]):
        (folder / f"buffer {n}.bin").write_bytes(data_of(gltf, n))
        buffer["uri"] = f"buffer%20{n}.bin"


def test_the_same_scene_in_other_files(vxs, scene, asset, tmp_path):
    others = [edited(scene, tmp_path / "short.gltf", short_indices_behind_a_gap),
              edited(scene, tmp_path / "own.gltf", vertices_of_their_own),
              edited(scene, tmp_path / "files.gltf", lambda gltf: buffers_in_files(tmp_path, gltf)),
              tmp_path / "level.glb", shutil.copy(scene, tmp_path / "copy.gltf")]
    others[3].write_bytes(to_glb(json.loads(scene.read_text())))
    before = asset.stat()
    for other in others:
        vxs("bake", other, "-o", tmp_path / "other.vxs", *SMALL)
        assert (tmp_path / "other.vxs").read_bytes() == asset.read_bytes(), other
        assert vxs("bake", other, "-o", asset, *SMALL, "--if-changed").stdout.startswith("up to date "), other
        vxs("compare", other, asset, "--points", 100)
    assert asset.stat().st_ino == before.st_ino


def test_nothing_of_the_machine_is_in_the_metadata(vxs, asset):
    text = json.dumps(made(vxs, asset))
    assert "/" not in text and "level.gltf" not in text
    assert not re.search(r"20\d\d-|\d\d:\d\d", text)


# --- what a file says ------------------------------------------------------------------------------------------------------------


def test_metadata(vxs, scene, asset):
    m = made(vxs, asset)
    assert m["generator"] == vxs("--version").stdout.strip()
    assert (m["triangles"], m["solids"], m["solid_triangles"], m["warnings"], m["left_out"]) == (24, 1, 12, 0, [])
    assert m["scene"]["name"] == "small" and m["scene"]["triangles"] == 24
    assert all(re.fullmatch("[0-9a-f]{32}", m["scene"][key]) for key in ("geometry", "alpha_masks", "cameras", "lights"))
    down = pytest.approx([0, -1, 0])
    assert m["lights"] == [
        {"name": "sun", "in_scene": True, "kind": "directional", "direction": down, "resolution_px": 64},
        {"name": "lamp", "in_scene": True, "kind": "spot", "direction": down, "position_m": [0, 6, 0],
         "outer_rad": pytest.approx(0.7853981633974483), "resolution_px": 64},
        {"name": "bulb", "in_scene": True, "kind": "point", "position_m": [0, 6, 0], "resolution_px": 64}]
    assert m["options"] == {"closed": "auto", "exit": "auto", "maps": "sparse", "coding": "blocks", "gl": "osmesa", "zstd_level": 12}


def lines(text):
    """The lines of vxs info by their first word, those of it that are about the making."""
    found = {}
    for line in text.splitlines():
        match = re.match(r"(made by|scene|fingerprint|options|left out) +(.*)", line)
        if match:
            found.setdefault(match[1], []).append(match[2])
    return found


def test_info_of_what_was_left_alone(vxs, asset):
    said = lines(vxs("info", asset).stdout)
    m = made(vxs, asset)
    assert said == {
        "made by": [m["generator"]],
        "scene": ["small: 24 triangles cast shadows, 12 of them in 1 solid"],
        "fingerprint": [f"geometry {m['scene']['geometry']}, alpha masks {m['scene']['alpha_masks']}, "
                        f"cameras {m['scene']['cameras']}, lights {m['scene']['lights']}"],
        "options": ["--resolution 64"]}


def test_info_of_a_default_and_of_what_casts_no_shadow(vxs, tmp_path):
    vxs("scene", "stress", "--case", "zero-area-and-needles", "-o", tmp_path / "a.glb")
    vxs("bake", tmp_path / "a.glb", "-o", tmp_path / "a.vxs")
    said = vxs("info", tmp_path / "a.vxs").stdout
    m, lights = made(vxs, tmp_path / "a.vxs"), info(vxs, tmp_path / "a.vxs")["lights"]
    assert m["triangles"] < m["scene"]["triangles"] and m["solids"] == 2
    assert lines(said)["scene"] == [f"zero-area-and-needles: {m['scene']['triangles']} triangles; {m['triangles']} triangles cast shadows, "
                                    f"{m['solid_triangles']} of them in 2 solids"]
    assert lines(said)["options"] == ["--resolution 4096"]
    assert said.splitlines()[0].endswith(", 1 light") and len(lights) == 1


def test_info_of_what_was_asked_for(vxs, scene, tmp_path):
    """The options are those of a command line: it bakes the same."""
    far = edited(scene, tmp_path / "far.gltf", lambda gltf: node_named(gltf, "bulb").update(translation=[0, 900, 0]) or
                 gltf["extensions"]["KHR_lights_punctual"]["lights"][2].update(range=1))
    given = ("--sun", "2,-4,0", "--light", "lamp", "--light", "bulb", "--texel", 0.5, "--region", "-3,-1,-3,3,4,3", "--closed", "off",
             "--exit", "back", "--maps", "gl", "--coding", "dag", "--rule", "shadow", "--stop", "insert", "--reuse", "off", "--level", 3)
    vxs("bake", far, "-o", tmp_path / "a.vxs", *given)
    said = lines(vxs("info", tmp_path / "a.vxs").stdout)
    assert said["made by"] == [made(vxs, tmp_path / "a.vxs")["generator"] + ", warnings: 1"]
    assert said["left out"] == ["light bulb: reaches no caster"]
    assert said["options"] == ["--sun 0.447213595,-0.894427191,0 --texel 0.5 --region -3,-1,-3,3,4,3 --closed off --exit back "
                               "--maps gl --coding dag --rule shadow --stop insert --reuse off --level 3"]
    again = said["options"][0].split()
    vxs("bake", far, "-o", tmp_path / "b.vxs", "--light", "lamp", "--light", "bulb", *again)
    assert lines(vxs("info", tmp_path / "b.vxs").stdout) == said

    vxs("bake", far, "-o", tmp_path / "a.vxs", *SMALL, "--light", "lamp")
    assert lines(vxs("info", tmp_path / "a.vxs").stdout)["left out"] == ["light sun: not requested", "light bulb: not requested"]


def test_options_of_info_are_those_of_a_shell(vxs, scene, tmp_path):
    """Names and patterns with blanks and quotes, and what a shell would look for among its files."""
    odd = edited(scene, tmp_path / "odd.gltf",
                 lambda gltf: gltf["extensions"]["KHR_lights_punctual"]["lights"][2].update(name="it's the $HOME of `bulbs`"))
    given = ["--sun", "dusk & dawn=0,-1,0", "--exclude", "node:bul[!a]", "--include", "*", "--resolution", "64", "--resolution",
             "it's the $HOME of `bulbs`=32"]
    vxs("bake", odd, "-o", tmp_path / "a.vxs", "--light", "sun", "--light", given[-1][:-3], *given)
    said = lines(vxs("info", tmp_path / "a.vxs").stdout)["options"][0]
    read = subprocess.run(["sh", "-c", f"printf '%s\\n' {said}"], cwd="/", capture_output=True, text=True, check=True).stdout
    assert read.splitlines() == given
    assert "--include '*' --resolution 64 " in said


# --- what others made ------------------------------------------------------------------------------------------------------------


def with_metadata(asset, path, text):
    forged = damage.Asset(asset)
    forged.contents["META", damage.NONE, 0] = text if isinstance(text, bytes) else json.dumps(text).encode()
    forged.write(path)
    return path


OLD = {"generator": "vxs 0.1.0", "triangles": 24, "solids": 1, "solid_triangles": 12,
       "options": {"closed": "auto", "exit": "auto", "rule": "greedy", "stop": "final"}}


def test_files_of_older_versions(vxs, scene, asset, tmp_path):
    """Nothing is known of their scene, and nothing is said, but one line of info."""
    old = with_metadata(asset, tmp_path / "old.vxs", OLD)
    other = edited(scene, tmp_path / "other.gltf", move_a_vertex)
    assert lines(vxs("info", old).stdout) == {
        "made by": ["vxs 0.1.0"], "scene": ["24 triangles cast shadows, 12 of them in 1 solid"],
        "fingerprint": ["none: no scene can be told from the one that was baked"], "options": ["--maps gl --coding dag"]}
    assert made(vxs, old) == OLD
    assert vxs("compare", other, old, "--points", 100).stderr == ""
    assert vxs("render", other, old, "-o", tmp_path / "a.png", "--width", 16, "--height", 16).stderr == ""
    assert vxs("bake", scene, "-o", old, *SMALL, "--if-changed").stdout.startswith("scene ")
    assert old.read_bytes() == asset.read_bytes()


def scene_of(**changed):
    return {"name": "", "triangles": 1, "geometry": "", "alpha_masks": "", "cameras": "", "lights": ""} | changed


def light_of(**changed):
    return {"name": "sun", "in_scene": True, "kind": "directional"} | changed


NOT_OURS = {
    "no JSON": b"{]", "bytes": bytes(range(256)) * 4, "a zero": b'{"generator": "vxs"}\0', "nothing": b"", "a list": [OLD],
    "deep": b"[" * 100000 + b"]" * 100000, "deep in a member": b'{"generator": "", "x": ' + b"[" * 5000 + b"]" * 5000 + b"}",
    "huge": b'{"generator": "' + b"x" * (5 << 20) + b'"}', "no generator": {"triangles": 1}, "twice": b'{"generator": "a", "generator": "b"}',
    "a number": OLD | {"generator": 1}, "triangles": OLD | {"triangles": "many"}, "scene": OLD | {"scene": "none"},
    "geometry": OLD | {"scene": scene_of(geometry=5)}, "options": OLD | {"options": [1]}, "closed": OLD | {"options": {"closed": {}}}, "coding": OLD | {"options": {"coding": 2}},
    "region": OLD | {"options": {"region_m": [1, 2, 3]}}, "lights": OLD | {"lights": {"sun": 1}}, "a light": OLD | {"lights": [5]},
    "a name": OLD | {"lights": [light_of(name=None)]}, "direction": OLD | {"lights": [light_of(direction=[0, 1])]},
    "left out": OLD | {"left_out": [{"name": "a"}]}, "overflow": b'{"generator": "", "triangles": 1e999}', "null": b"null",
    "infinite": b'{"generator": "", "triangles": 99999999999999999999999999}',
}


@pytest.mark.parametrize("name", NOT_OURS)
def test_metadata_that_vxs_did_not_write(vxs, scene, asset, tmp_path, name):
    other = with_metadata(asset, tmp_path / "a.vxs", NOT_OURS[name])
    text = vxs("info", other).stdout
    assert "\nmade by      unknown: vxs did not write the metadata, " in text and len(text) < 5000
    assert "metadata" not in info(vxs, other)
    assert vxs("compare", scene, other, "--points", 10).stderr == ""
    assert vxs("bake", scene, "-o", other, *SMALL, "--if-changed").stdout.startswith("scene ")
    assert other.read_bytes() == asset.read_bytes()


def test_hostile_metadata_of_the_right_shape(vxs, scene, asset, tmp_path):
    """Texts of any kind are printed on their line, without what speaks to a terminal."""
    evil = "a\x1b[31m\n\u009b2J\r\x7f" + "\u00e9" * 3
    hostile = with_metadata(asset, tmp_path / "a.vxs", OLD | {
        "generator": evil, "scene": scene_of(name=evil, geometry=evil), "warnings": -1, "left_out": [{"name": evil, "why": evil}],
        "lights": [light_of(name=evil, in_scene=False, direction=[1e308, -0.0, 5], texel_m=-1e300), light_of(name=evil, resolution_px=-5),
                   light_of(name=evil, kind=evil)],
        "options": {word: evil for word in ("closed", "exit", "coding", "pack", "rule", "stop", "reuse", "gl")} | {"zstd_level": -(2**63), "region_m": [0] * 6}})
    text = vxs("info", hostile).stdout
    assert not re.search("[\x00-\x09\x0b-\x1f\x7f\x80-\x9f]", text)
    assert "a?[31m???2J??ééé" in text and all(len(found) == 1 for found in lines(text).values())
    assert made(vxs, hostile)["generator"] == evil
    done = vxs("compare", scene, hostile, "--points", 10, status=2)
    assert done.stderr.count("\n") == 1 and "(differs: name, which was 'a?[31m???2J??ééé'; geometry; alpha masks; cameras)" in done.stderr


def test_no_metadata(vxs, scene, asset, tmp_path):
    bare = damage.Asset(asset)
    bare.entries = [entry for entry in bare.entries if entry[0] != b"META"]
    struct.pack_into("<I", bare.head, 12, len(bare.entries))
    bare.write(tmp_path / "a.vxs")
    assert lines(vxs("info", tmp_path / "a.vxs").stdout) == {} and "metadata" not in info(vxs, tmp_path / "a.vxs")
    assert vxs("compare", scene, tmp_path / "a.vxs", "--points", 10).stderr == ""


# --- another scene ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("change, differs", CHANGES, ids=[f"{n}-{differs}" for n, (_, differs) in enumerate(CHANGES)])
def test_compare_picture_and_truth_name_what_differs(vxs, scene, asset, tmp_path, change, differs):
    other = edited(scene, tmp_path / "other.gltf", change)
    done = vxs("compare", other, asset, "--points", 100, "--json", tmp_path / "a.json", status=2)
    assert done.stdout == "" and not (tmp_path / "a.json").exists()
    assert done.stderr == (f"vxs: error: '{asset}' was baked from another scene than {other} (differs: {differs}): bake it anew, "
                           "or --other-scene compares all the same\n")
    draw = ("render", other, asset, "-o", tmp_path / "a.png", "--width", 16, "--height", 16)
    assert vxs(*draw).stderr == (f"vxs: warning: '{asset}' was baked from another scene than {other} (differs: {differs}): its shadows "
                                 "may not fit; bake it anew\n")
    (tmp_path / "a.png").unlink()
    vxs(*draw, "--strict", status=1)
    assert not (tmp_path / "a.png").exists()
    ask = ("truth", other, "--like", asset)
    assert vxs(*ask, input="0 5 0").stderr == (f"vxs: warning: '{asset}' was baked from another scene than {other} (differs: {differs}): "
                                               "it may answer otherwise; bake it anew\n")
    assert vxs(*ask, "--strict", input="0 5 0", status=1).stdout == ""


def test_compare_with_another_scene_on_purpose(vxs, scene, asset, tmp_path):
    other = edited(scene, tmp_path / "other.gltf", lambda gltf: (turn_the_sun(gltf), move_the_camera(gltf)))
    done = vxs("compare", other, asset, asset, "--points", 100, "--other-scene", "--json",
               tmp_path / "a.json")
    assert done.stderr == "" and done.stdout.count("\nother scene  than it was baked from: cameras; light 'sun': direction\n") == 2
    report = json.loads((tmp_path / "a.json").read_text())
    validator("compare").validate(report)
    assert [a["scene_differences"] for a in report["assets"]] == [["cameras", "light 'sun': direction"]] * 2

    done = vxs("compare", scene, asset, "--points", 100, "--other-scene", "--json", "-")
    assert json.loads(done.stdout)["assets"][0]["scene_differences"] == [] and "other scene" not in done.stderr


def test_of_many_differences_the_first_are_said(vxs, tmp_path):
    names = [f"sun {n} {'x' * 60}" for n in range(9)]
    scene = small_scene.write(tmp_path / "a.gltf", lights=[(name, "directional", small_scene.NOON) for name in names])
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL)
    other = small_scene.write(tmp_path / "b.gltf", boxes=[small_scene.GROUND], lights=LIGHTS[:1])
    said = vxs("compare", other, tmp_path / "a.vxs", status=2).stderr
    assert f"(differs: geometry; light '{names[0]}': not there; light '{names[1]}': not there" in said
    assert said.endswith("--other-scene compares all the same\n") and said.count("\n") == 1
    scene = small_scene.write(tmp_path / "a.gltf", lights=[(f"sun{n}", "directional", small_scene.NOON) for n in range(9)])
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL)
    assert "light 'sun2': not there; and 6 more): bake" in vxs("compare", other, tmp_path / "a.vxs", status=2).stderr


def test_lights_that_were_not_baked_make_no_difference(vxs, scene, tmp_path):
    asset = tmp_path / "sun.vxs"
    vxs("bake", scene, "-o", asset, *SMALL, "--light", "sun")
    for change in (move_the_lamp, narrow_the_lamp, lamp_to_bulb, no_lamp):
        other = edited(scene, tmp_path / "other.gltf", change)
        assert vxs("compare", other, asset, "--points", 10).stderr == ""
        assert vxs("render", other, asset, "-o", tmp_path / "a.png", "--width", 16, "--height", 16).stderr == ""


def test_which_scene_of_a_file_it_was(vxs, scenes, tmp_path):
    """Its name is said, for --scene; alone it is no difference."""
    two = scenes / "real" / "camp_and_cave_two_scenes.glb"
    vxs("bake", two, "-o", tmp_path / "a.vxs", *SMALL, "--sun", "0,-1,0", "--scene", "camp")
    done = vxs("compare", two, tmp_path / "a.vxs", "--points", 100, status=2)
    assert "(differs: name, which was 'camp'; geometry)" in done.stderr
    assert vxs("compare", two, tmp_path / "a.vxs", "--points", 100, "--scene", "camp").stderr == ""


def test_nor_do_lights_that_were_left_out(vxs, scene, tmp_path):
    """The metadata tell of them, and the file has none of their shadows."""
    def reach(range_m):
        return lambda gltf: gltf["extensions"]["KHR_lights_punctual"]["lights"][2].update(range=range_m)

    near = edited(scene, tmp_path / "near.gltf", reach(0.5))
    vxs("bake", near, "-o", tmp_path / "a.vxs", *SMALL)
    assert [light["name"] for light in made(vxs, tmp_path / "a.vxs")["left_out"]] == ["bulb"]
    assert vxs("compare", edited(near, tmp_path / "other.gltf", reach(0.25)), tmp_path / "a.vxs", "--points", 10).stderr == ""


def test_a_sun_of_the_command_line_is_not_looked_for_in_the_scene(vxs, scene, tmp_path):
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL, "--sun", "1,-2,1")
    assert made(vxs, tmp_path / "a.vxs")["lights"][0]["in_scene"] is False
    for other in (scene, edited(scene, tmp_path / "other.gltf", turn_the_sun)):
        assert vxs("compare", other, tmp_path / "a.vxs", "--points", 10).stderr == ""


# --- up to date ------------------------------------------------------------------------------------------------------------------


def bake_again(vxs, scene, path, *options):
    """vxs bake --if-changed: 1 when it baked, and then what it wrote is what a bake writes."""
    before, old = path.stat(), path.read_bytes()
    text = vxs("bake", scene, "-o", path, *options, "--if-changed").stdout
    fresh = path.with_suffix(".fresh")
    vxs("bake", scene, "-o", fresh, *options)
    assert path.read_bytes() == fresh.read_bytes()
    baked = not text.startswith("up to date ")
    if not baked:
        size = path.stat().st_size
        assert text == f"up to date   {path}, {size} B: baked from this scene, these lights and options by {vxs('--version').stdout}"
        assert (path.stat().st_ino, path.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns) and path.read_bytes() == old
    return baked


@pytest.fixture
def baked(asset, tmp_path):
    return shutil.copy(asset, tmp_path / "a.vxs")


def test_nothing_is_done_when_nothing_changed(vxs, scene, baked):
    assert not bake_again(vxs, scene, baked, *SMALL)
    assert not bake_again(vxs, scene, baked, *SMALL, "--threads", 1)
    assert not bake_again(vxs, scene, baked, *SMALL, "--memory", "4G", "--maps", "sparse")
    assert not bake_again(vxs, scene, baked, *SMALL, "--scene", "small", "--level", 12)
    assert not bake_again(vxs, scene, baked, *SMALL, "--light", "sun", "--light", "lamp", "--light", "bulb")


def test_steps_that_change_no_byte_of_a_dag(vxs, scene, tmp_path):
    dag = (*SMALL, "--coding", "dag")
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *dag)
    assert not bake_again(vxs, scene, tmp_path / "a.vxs", *dag, "--compress", "bottom-up")
    assert not bake_again(vxs, scene, tmp_path / "a.vxs", *dag, "--reuse", "off"), "the merge finds the same"


@pytest.mark.parametrize("change", [change for change, _ in CHANGES] + [
    lambda gltf: gltf["scenes"][0].update(name="large"), lambda gltf: node_named(gltf, "bulb").update(translation=[0, 6, 1])])
def test_a_changed_scene_is_baked(vxs, scene, baked, tmp_path, change):
    assert bake_again(vxs, edited(scene, tmp_path / "other.gltf", change), baked, *SMALL)


@pytest.mark.parametrize("options", [
    ("--resolution", 128), ("--texel", 0.5), (*SMALL, "--level", 13), (*SMALL, "--closed", "off"), (*SMALL, "--exit", "back"), (*SMALL, "--maps", "gl"),
    (*SMALL, "--coding", "dag", "--rule", "shadow"), (*SMALL, "--coding", "dag", "--stop", "partial"),
    (*SMALL, "--region", "-1,-1,-1,1,1,1"), (*SMALL, "--light", "sun"),
    (*SMALL, "--light", "lamp", "--light", "sun", "--light", "bulb"), (*SMALL, "--sun", "0,-1,0"), (*SMALL, "--sun", "0,-1,1e-9"),
], ids=lambda options: " ".join(map(str, options)))
def test_other_options_are_baked(vxs, scene, baked, options):
    assert bake_again(vxs, scene, baked, *options)
    assert not bake_again(vxs, scene, baked, *options)


def test_reuse_counts_where_insertion_is_the_last_step(vxs, scene, baked):
    insert = (*SMALL, "--coding", "dag", "--stop", "insert")
    assert bake_again(vxs, scene, baked, *insert)
    assert bake_again(vxs, scene, baked, *insert, "--reuse", "off")


def test_a_light_that_was_left_out_comes_into_reach(vxs, scene, tmp_path):
    """It is not in the file, and yet it counts."""
    def far(gltf, height):
        node_named(gltf, "bulb")["translation"] = [0, height, 0]
        gltf["extensions"]["KHR_lights_punctual"]["lights"][2]["range"] = 1 if height > 9 else 50

    there = edited(scene, tmp_path / "there.gltf", lambda gltf: far(gltf, 900))
    vxs("bake", there, "-o", tmp_path / "a.vxs", *SMALL)
    assert [light["name"] for light in info(vxs, tmp_path / "a.vxs")["lights"]] == ["sun", "lamp"]
    done = vxs("bake", there, "-o", tmp_path / "a.vxs", *SMALL, "--if-changed")
    assert done.stdout.startswith("up to date ") and done.stdout.endswith("; warnings of its bake: 1\n")
    far_range = edited(there, tmp_path / "range.gltf", lambda gltf: gltf["extensions"]["KHR_lights_punctual"]["lights"][2].update(range=999))
    assert bake_again(vxs, far_range, tmp_path / "a.vxs", *SMALL)
    assert len(info(vxs, tmp_path / "a.vxs")["lights"]) == 3


def test_lights_that_are_not_baked_count_as_far_as_the_bytes_depend_on_them(vxs, scene, tmp_path):
    """A lamp in a box makes a sheet of it, and names are listed. Where a light points does not matter."""
    options = (*SMALL, "--light", "sun")
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *options)
    before = made(vxs, tmp_path / "a.vxs")["solids"]
    assert not bake_again(vxs, edited(scene, tmp_path / "b.gltf", narrow_the_lamp), tmp_path / "a.vxs", *options)
    inside = edited(scene, tmp_path / "c.gltf", lambda gltf: node_named(gltf, "lamp").update(translation=[0, -0.5, 0]))
    assert bake_again(vxs, inside, tmp_path / "a.vxs", *options)
    assert made(vxs, tmp_path / "a.vxs")["solids"] == before - 1
    renamed = edited(inside, tmp_path / "d.gltf",
                     lambda gltf: gltf["extensions"]["KHR_lights_punctual"]["lights"][1].update(name="lantern"))
    assert bake_again(vxs, renamed, tmp_path / "a.vxs", *options)


def test_what_is_not_sound_is_baked(vxs, scene, asset, baked, tmp_path):
    good = asset.read_bytes()
    sections = info(vxs, asset)["sections"]
    bad = [good[:-1], good[:64], b"", good + b"\0", b"glTF" + good[4:]]
    for at in [8, 40, 70, *(s["offset_bytes"] + s["stored_bytes"] // 2 for s in sections[::6])]:
        bad.append(good[:at] + bytes([good[at] ^ 4]) + good[at + 1:])
    for data in bad:
        baked.write_bytes(data)
        assert vxs("bake", scene, "-o", baked, *SMALL, "--if-changed").stdout.startswith("scene ")
        assert baked.read_bytes() == good
    baked.unlink()
    vxs("bake", scene, "-o", baked, *SMALL, "--if-changed")
    assert baked.read_bytes() == good


@pytest.mark.parametrize("change", [{"generator": "vxs 0.0.9"}, {"lights": []}, {"options": {}}, {"scene": None}])
def test_other_metadata_are_baked(vxs, scene, asset, baked, change):
    m = made(vxs, asset) | change
    with_metadata(asset, baked, {key: value for key, value in m.items() if value is not None})
    assert bake_again(vxs, scene, baked, *SMALL)


def test_a_pipe_is_not_read(vxs_path, vxs, scene, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    writer = subprocess.Popen([vxs_path, "bake", scene, "-o", tmp_path / "pipe", *map(str, SMALL), "--if-changed"],
                              stdout=subprocess.DEVNULL)
    data = (tmp_path / "pipe").read_bytes()
    assert writer.wait(60) == 0 and data.startswith(b"\x8fVXS")


def test_reports_of_what_was_not_baked(vxs, scene, baked, tmp_path):
    report, page = tmp_path / "a.json", tmp_path / "a.html"
    options = (*SMALL, "--if-changed", "--json", report)
    vxs("bake", scene, "-o", baked, *options)
    said = json.loads(report.read_text())
    validator("bake-report").validate(said)
    assert said["unchanged"] is True and said["file_bytes"] == baked.stat().st_size and said["warnings"] == []
    assert said["output"] == str(baked) and "lights" not in said
    vxs("compare", scene, baked, "--points", 10, "--bake-report", report)

    vxs("bake", scene, "-o", baked, *options, "--report", page)
    assert json.loads(report.read_text())["unchanged"] is False and page.read_text().startswith("<!")
    page.write_text("mine")
    assert vxs("bake", scene, "-o", baked, *options, "--report", page).stdout.startswith("up to date ")
    assert page.read_text() == "mine"

    done = vxs("bake", scene, "-o", baked, *SMALL, "--if-changed", "--json", "-")
    assert json.loads(done.stdout)["unchanged"] is True and done.stderr.startswith("up to date ")


def test_plan_says_so_too(vxs, scene, baked):
    done = vxs("plan", scene, "-o", baked, *SMALL, "--if-changed")
    assert done.stdout.startswith("up to date ") and done.stdout.count("\n") == 1
    plan = json.loads(vxs("plan", scene, "-o", baked, *SMALL, "--if-changed", "--json", "-").stdout)
    validator("plan").validate(plan)
    assert plan["unchanged"] is True
    page = baked.with_suffix(".html")  # one that is not there is made of a bake
    for options in (("--resolution", 128), (*SMALL, "--report", page)):
        plan = json.loads(vxs("plan", scene, "-o", baked, *options, "--if-changed", "--json", "-").stdout)
        validator("plan").validate(plan)
        assert plan["unchanged"] is False


def test_what_does_not_go_with_it(vxs, scene, tmp_path):
    assert "--if-changed needs -o OUT.vxs" in vxs("bake", scene, "-o", "-", "--if-changed", status=2).stderr
    assert "--if-changed needs -o OUT.vxs" in vxs("plan", scene, "--if-changed", status=2).stderr
    out = tmp_path / "a.vxs"
    assert "exclude each other" in vxs("bake", scene, "-o", out, "--report", "-", "--if-changed", status=2).stderr
    assert "unknown option '--if-changed'" in vxs("bench", scene, "-o", tmp_path / "a.json", "--if-changed", status=2).stderr
    assert list(tmp_path.iterdir()) == []


def test_warnings_are_not_forgotten(vxs, scene, tmp_path):
    """With --strict a file that was baked with warnings is not up to date: the bake says them, and fails."""
    far = edited(scene, tmp_path / "far.gltf", lambda gltf: node_named(gltf, "bulb").update(translation=[0, 900, 0]) or
                 gltf["extensions"]["KHR_lights_punctual"]["lights"][2].update(range=1))
    options = (far, "-o", tmp_path / "a.vxs", *SMALL, "--if-changed")
    vxs("bake", *options)
    assert "; warnings of its bake: 1" in vxs("bake", *options).stdout
    assert "light 'bulb' reaches no caster" in vxs("bake", *options, "--strict", status=1).stderr
    vxs("bake", scene, "-o", tmp_path / "b.vxs", *SMALL)
    assert vxs("bake", scene, "-o", tmp_path / "b.vxs", *SMALL, "--if-changed", "--strict").stdout.startswith("up to date ")
