# vxs mend: what it closes, and that a bake of what it writes is a bake of the scene.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import pathlib
import random
import struct

import jsonschema
import pytest

import small_scene
from named_scene import cube, light, node, plane, write

SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "docs" / "mend.schema.json"


@pytest.fixture
def mend(vxs, tmp_path):
    """mend(scene, *options): the report; the mended scene is tmp_path/mended.glb."""

    def run(scene, *options):
        vxs("mend", scene, "-o", tmp_path / "mended.glb", "--json", tmp_path / "mend.json", *options)
        report = json.loads((tmp_path / "mend.json").read_text())
        jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(report)
        return report

    return run


def health(vxs, path):
    """Of a scene, whatever its nodes are called."""
    report = json.loads(vxs("health", path, "--json", "-").stdout)["health"]
    return report | {"components": [{key: c[key] for key in c if key != "from"} for c in report["components"]]}


def sections(vxs, scene, tmp_path, *options):
    """What a bake holds of its lights. The direction of a light may differ in its last bit, since glTF has it as a rotation."""
    out = tmp_path / "out.vxs"
    vxs("bake", scene, "-o", out, "--resolution", 256, *options)
    data = out.read_bytes()
    found = [data[s["offset_bytes"]:s["offset_bytes"] + s["stored_bytes"]]
            for s in json.loads(vxs("info", out, "--json", "-").stdout)["sections"] if "light" in s]
    assert len(found) >= 2
    return found


def test_openings_are_left(vxs, mend, tmp_path):
    path = small_scene.write(tmp_path / "open.gltf", open_faces=True)  # openings as large as the boxes are not filled
    for diameter in (100, 0.5):
        report = mend(path, "--hole-diameter", diameter)
        assert report["total"]["left_holes"] == 2 and report["total"]["filled_holes"] == 0 and report["closed_after"] == 0
        assert report["options"]["hole_diameter_m"] == diameter
        assert health(vxs, path) == health(vxs, tmp_path / "mended.glb")
    assert "still open: 1 holes left" in vxs("mend", path, "-o", tmp_path / "mended.glb", "--verbose").stdout


def test_what_is_sound_is_kept(vxs, mend, tmp_path):
    """Also each kind of light, and a material with two sides."""
    lights = (("noon", "directional", small_scene.MORNING), ("lamp", "spot", small_scene.NOON), ("bulb", "point", small_scene.NOON))
    for material in ({}, {"doubleSided": True}):
        sound = small_scene.write(tmp_path / "sound.gltf", lights=lights, **material)
        report = mend(sound)
        assert report["components"] == [] and report["closed_before"] == report["closed_after"] == 2
        assert report["solids_before"] == report["solids_after"] == {"components": 0 if material else 2, "triangles": 0 if material else 24}
        assert health(vxs, sound) == health(vxs, tmp_path / "mended.glb")
        assert sections(vxs, sound, tmp_path) == sections(vxs, tmp_path / "mended.glb", tmp_path)
    assert "nothing to do" in vxs("mend", sound, "-o", tmp_path / "mended.glb").stdout


def test_holes_of_leaves_are_kept(vxs, mend, tmp_path):
    vxs("scene", "forest", "--triangles", 2000, "-o", tmp_path / "forest.glb")
    mend(tmp_path / "forest.glb", "--hole-edges", 0)
    assert sections(vxs, tmp_path / "forest.glb", tmp_path) == sections(vxs, tmp_path / "mended.glb", tmp_path)


def test_a_turned_triangle_makes_no_solid(vxs, mend, tmp_path):
    whole = small_scene.write(tmp_path / "whole.gltf")
    report = mend(small_scene.with_a_turned_triangle(whole))
    assert report["total"]["turned_triangles"] == 1
    assert [report[when]["triangles"] for when in ("solids_before", "solids_after")] == [12, 24]
    assert sections(vxs, whole, tmp_path) == sections(vxs, tmp_path / "mended.glb", tmp_path)
    vxs("bake", tmp_path / "mended.glb", "-o", tmp_path / "mended.vxs", "--resolution", 128)
    compared = json.loads(vxs("compare", tmp_path / "mended.glb", tmp_path / "mended.vxs", "--points", 20000, "--json", "-").stdout)
    assert compared["assets"][0]["solid_triangles"] == 24 and compared["passed"]


@pytest.mark.parametrize("command", ["bake", "plan", "compare", "health"])
def test_no_other_command_mends(vxs, tmp_path, command):
    path = small_scene.write(tmp_path / "scene.gltf")
    for option in ("--repair", "--union"):
        assert f"unknown option '{option}'" in vxs(command, path, option, status=2).stderr
    assert "repair" not in vxs(command, "--help").stdout


@pytest.mark.parametrize("name", ["sponza", "dream_apartment", "pandora_indoor", "low_poly_terrain", "truck_town", "chess_board"])
def test_real_scenes(vxs, mend, scenes, tmp_path, name):
    """More of them is solid than before, and nothing that was solid is lost."""
    path = scenes / "real" / (name + ".glb")
    report = mend(path)
    before, after, total = health(vxs, path), health(vxs, tmp_path / "mended.glb"), report["total"]
    assert report["solids_after"]["components"] >= report["solids_before"]["components"]
    assert report["closed_after"] >= report["closed_before"]
    for health_then, when in (before, "solids_before"), (after, "solids_after"):
        solids = [c for c in health_then["components"] if c["kind"] == "solid"]
        assert {"components": len(solids), "triangles": sum(c["triangles"] for c in solids)} == report[when]
    assert (after["total"]["triangles"] + after["total"]["collapsed_triangles"] == before["total"]["triangles"]
            + before["total"]["collapsed_triangles"] - total["removed_repeated"] - total["removed_zero_area"] + total["added_triangles"])
    for component in after["components"]:
        if component["kind"] == "solid":
            assert component["closed"] and component["oriented"] and component["volume_m3"] > 0
    if name == "sponza":
        assert report["solids_after"]["components"] - report["solids_before"]["components"] > 20 and total["filled_holes"] >= 20
    if name == "low_poly_terrain":
        assert report["closed_after"] > report["closed_before"] and total["removed_repeated"] + total["removed_zero_area"] > 100


SITE = (1661274.3, 16.6, -8178659.7)  # metres, as of a georeferenced model


def moved(at, by=SITE):
    return [a + b for a, b in zip(at, by)]


def crates(by=SITE, **rest):
    return [node("ground", plane(6), by, **rest)] + [node(f"crate{n}", cube(0.3), moved((n / 2, 0.15, 0), by), **rest) for n in range(5)]


def read_glb(path):
    """The JSON of a file, and the positions of its first buffer view."""
    data = path.read_bytes()
    size, = struct.unpack_from("<I", data, 12)
    gltf, bytes_ = json.loads(data[20:20 + size]), data[28 + size:]
    count = gltf["bufferViews"][0]["byteLength"] // 12
    return gltf, [struct.unpack_from("<3f", bytes_, 12 * n) for n in range(count)]


def test_a_scene_far_from_the_origin(vxs, mend, tmp_path):
    """A root node places it, in double: crates keep their places and size, and a bake answers as before."""
    lights = [light("sun", "directional", direction=(0.5, -1, 0.2)), light("lamp", "point", moved((1, 1.5, 0.4)))]
    path = write(tmp_path / "far.gltf", crates(), lights)
    mend(path)
    gltf, positions = read_glb(tmp_path / "mended.glb")
    roots = [gltf["nodes"][n] for n in gltf["scenes"][0]["nodes"]]
    assert [root["name"] for root in roots] == ["origin", "sun", "lamp"] and roots[2]["translation"] == lights[1][1]
    found = [moved(p, roots[0]["translation"]) for p in positions]
    expected = [moved(moved(p, (0, 0, 0)), at) for _, (corners, _), at, _ in crates() for p in corners]
    assert len(found) == len(expected) and all(min(max(abs(a - b) for a, b in zip(p, q)) for q in expected) < 1e-6 for p in found)
    assert all(min(max(abs(a - b) for a, b in zip(p, q)) for p in found) < 1e-6 for q in expected)
    options = ("--resolution", 1024)
    for scene, asset in ((path, "far.vxs"), (tmp_path / "mended.glb", "mended.vxs")):
        assert vxs("bake", scene, "-o", tmp_path / asset, *options).stderr == ""
    random.seed(3)
    points = "\n".join(" ".join(map(str, moved([random.uniform(-1, 3), random.uniform(0, 0.5), random.uniform(-1, 1)]))) for _ in range(4000))
    answers = [vxs("query", tmp_path / asset, input=points).stdout.splitlines() for asset in ("far.vxs", "mended.vxs")]
    assert sum(a != b for a, b in zip(*answers)) <= 2 and len(set(answers[0])) > 2
    for scene, asset in ((path, "far.vxs"), (tmp_path / "mended.glb", "mended.vxs")):
        assert json.loads(vxs("compare", scene, tmp_path / asset, "--points", 5000, "--json", "-").stdout)["passed"]


def test_floats_of_one_origin_are_kept(vxs, mend, tmp_path):
    """What is placed by one node has the same floats afterwards, and bakes to the same bytes."""
    mesh = cube(0.3, (4.1, 0.2, 0.7))
    path = write(tmp_path / "far.gltf", [node("all", mesh, SITE)], [light("sun", "directional", direction=(0.5, -1, 0.2)),
                                                                    light("lamp", "point", moved((4, 1.5, 0.4)))])
    mend(path)
    gltf, positions = read_glb(tmp_path / "mended.glb")
    assert gltf["nodes"][1]["translation"] == list(SITE)
    assert sorted(positions) == sorted(struct.unpack("<3f", struct.pack("<3f", *p)) for p in mesh[0])
    assert sections(vxs, path, tmp_path) == sections(vxs, tmp_path / "mended.glb", tmp_path)


def test_masks_and_smoke_far_from_the_origin(vxs, mend, tmp_path):
    near = tmp_path / "near.glb"
    vxs("scene", "smoke", "--capsules", 20, "-o", near)
    gltf, _ = read_glb(near)
    data = near.read_bytes()
    size, = struct.unpack_from("<I", data, 12)
    for n in gltf["scenes"][0]["nodes"]:
        gltf["nodes"][n]["translation"] = moved(gltf["nodes"][n].get("translation", (0, 0, 0)))
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    path = tmp_path / "far.glb"
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(data) - 20 - size, len(text), 0x4e4f534a) + text + data[20 + size:])
    mend(path)
    mended, _ = read_glb(tmp_path / "mended.glb")
    origin = next(one for one in mended["nodes"] if one["name"] == "origin")
    assert {mended["nodes"][n]["name"].split()[0] for n in origin["children"]} == {"material", "smoke"}
    options = ("--scene-smoke", "on", "--resolution", 256)
    points = "\n".join(" ".join(map(str, moved((x / 2, 1, z / 2)))) for x in range(-10, 10) for z in range(-10, 10))
    answers = []
    for scene in (path, tmp_path / "mended.glb"):
        vxs("bake", scene, "-o", tmp_path / "a.vxs", *options)
        answers.append([line.split() for line in vxs("query", tmp_path / "a.vxs", "--smoke", input=points).stdout.splitlines()])
    pairs = [(a, b) for p, q in zip(*answers) for a, b in zip(p, q)]
    assert all(a == b or abs(float(a) - float(b)) < 1e-3 for a, b in pairs) and any(0 < float(a) < 1 for a, _ in pairs if a != "out")


def test_a_scene_near_the_origin_has_none(mend, tmp_path):
    for by in ((0, 0, 0), (20, 0, -10)):
        mend(write(tmp_path / "near.gltf", crates(by), [light("sun", "directional")]))
        gltf, positions = read_glb(tmp_path / "mended.glb")
        assert "origin" not in [one["name"] for one in gltf["nodes"]] and max(p[0] for p in positions) >= by[0] + 2


def test_vertices_that_move(vxs, tmp_path):
    """Two places that are far apart: floats from their middle are as coarse as from the origin."""
    path = write(tmp_path / "two.gltf", [*crates(), *crates((-1e7, 0, 0))])
    text = vxs("mend", path, "-o", tmp_path / "out.glb").stderr
    assert "positions become floats, and vertices move by up to 0." in text and "--include" in text and text.count("\n") == 1
    (tmp_path / "out.glb").unlink()
    vxs("mend", path, "-o", tmp_path / "out.glb", "--strict", status=1)
    assert not (tmp_path / "out.glb").exists()


def test_a_georeferenced_scene(vxs, mend, cases, tmp_path):
    path = cases / "files" / "mend_far_from_origin" / "georeferenced.gltf"
    mend(path)
    boxes = [json.loads(vxs("plan", scene, "--sun", "0.3,-1,0.2", "--json", "-").stdout)["casters"] for scene in (path, tmp_path / "mended.glb")]
    for corner in ("min_m", "max_m"):
        assert boxes[1][corner] == pytest.approx(boxes[0][corner], abs=1e-6, rel=0)


def test_outputs(vxs, tmp_path):
    path = small_scene.write(tmp_path / "scene.gltf")
    before, out = path.read_bytes(), tmp_path / "out.glb"
    assert "needs -o" in vxs("mend", path, status=2).stderr
    vxs("mend", path, "-o", path, status=2)
    vxs("mend", path, "-o", out, "--json", path, status=2)
    vxs("mend", path, "-o", out, "--json", out, status=2)
    vxs("mend", path, "-o", "-", "--json", "-", status=2)
    vxs("mend", path, "-o", tmp_path / "no" / "where.glb", status=4)
    vxs("mend", path, "-o", out, "--hole-edges", 1001, status=2)
    vxs("mend", path, "-o", out, "--scene", "other", status=2)
    vxs("mend", tmp_path / "nobody.gltf", "-o", out, status=3)
    vxs("mend", small_scene.write(tmp_path / "empty.gltf", boxes=()), "-o", out, status=5)
    assert path.read_bytes() == before and not out.exists()
    out.write_text("older")
    vxs("mend", tmp_path / "empty.gltf", "-o", out, status=5)
    assert out.read_text() == "older"
    vxs("mend", path, "-o", out)
    assert out.read_bytes()[:4] == b"glTF"
    assert "nothing to do" in vxs("mend", path, "-o", out, "--json", "-").stderr
