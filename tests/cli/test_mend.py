# vxs mend: what it closes, and that a bake of what it writes is a bake of the scene.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import pathlib

import jsonschema
import pytest

import small_scene

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
    vxs("bake", scene, "-o", out, "--baseline", "off", "--resolution", 256, *options)
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
