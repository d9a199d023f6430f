# vxs health against counts made by others: the table of the shared scenes.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import pathlib
import re

import jsonschema
import pytest

import small_scene

SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "docs" / "health.schema.json"


def health(vxs, path, *options):
    report = json.loads(vxs("health", path, "--json", "-", *options).stdout)
    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(report)
    return report


def readme_rows(scenes):
    """What the README of the scenes says: file -> counts."""
    text = (scenes / "real" / "README.md").read_text()
    rows = {}
    for name, triangles, closed in re.findall(r"^\| (\S+\.gl\w+) \|[^|]*\|[^|]*\| ([\d,]+) \| ((?:open|closed)[^|]*) \|", text, re.MULTILINE):
        parts = re.search(r"([\d,]+)/([\d,]+) parts closed", closed)
        rows[name] = {
            "triangles": int(triangles.replace(",", "")),
            "open": float(re.search(r"open \(([\d.]+)%", closed)[1]) if "open" in closed else 0,
            "parts": [int(n.replace(",", "")) for n in parts.groups()] if parts else None,
            "nonmanifold": int(re.search(r"([\d,]+) edges with >2", closed)[1].replace(",", "")) if ">2" in closed else 0,
        }
    geometry = r"^\| (\S+\.gl\w+) \| [\d,]+ \|[^|]*\|[^|]*\|[^|]*\|[^|]*\| ([\d,]+) \+ ([\d,]+) \+ ([\d,]+) \|"
    for name, *counts in re.findall(geometry, text, re.MULTILINE):
        rows.setdefault(name, {})["bad"] = [int(n.replace(",", "")) for n in counts]
    return rows


# Vertices are welded where positions are equal in double, those of the README in float, which is coarser: scenes whose parts meet
# only after rounding differ, and are not here.
SCENES = ["sponza", "dream_apartment", "pandora_indoor", "stanford_bunny_closed", "voxel_district", "mountains_heightfield",
          "low_poly_terrain", "truck_town", "dutch_ship_mask", "chess_board", "room_with_spheres_closed", "japanese_bridge_garden",
          "camp_and_cave_two_scenes", "sunlit_primitives", "skylight_hall_directional", "features/cubes_point_light", "features/duck", "features/Fox"]


@pytest.mark.parametrize("name", SCENES)
def test_counts_of_the_readme(vxs, scenes, name):
    said = readme_rows(scenes)[name + ".glb"]
    report = health(vxs, scenes / "real" / (name + ".glb"), "--skinned", "rest", "--blend", "opaque")
    total, components = report["health"]["total"], report["health"]["components"]
    assert total["triangles"] + total["collapsed_triangles"] == said["triangles"]
    assert [total["collapsed_triangles"], total["zero_area_triangles"], total["repeated_triangles"]] == said["bad"]
    assert total["nonmanifold_edges"] == said["nonmanifold"]
    assert 100 * total["boundary_edges"] / total["edges"] == pytest.approx(said["open"], abs=0.06)
    closed = sum(c["closed"] for c in components)
    if said["parts"] is None:
        assert closed == len(components)
    elif said["parts"][1] == len(components):
        assert closed == said["parts"][0]
    else:  # the README's parts hang together by corners too, so it has fewer
        assert closed >= said["parts"][0] and len(components) > said["parts"][1]


def test_sound_scene(vxs, tmp_path):
    path = small_scene.write(tmp_path / "scene.gltf")
    report = health(vxs, path)
    assert report["scene"] == str(path) and report["name"] == "small" and report["health"]["complete"]
    ground, block = report["health"]["components"]
    assert ground["kind"] == block["kind"] == "solid"
    assert ground["volume_m3"] == pytest.approx(256) and block["volume_m3"] == pytest.approx(4)
    assert [ground["min_m"], ground["max_m"]] == [list(map(float, c)) for c in small_scene.GROUND]
    assert ground["vertices"] == 8 and ground["edges"] == 18 and ground["meets"] == []
    text = vxs("health", path).stdout
    assert text.splitlines() == ["24 triangles in 2 components", "  solid                2 components        24 triangles",
                                 "2 without a fault, 0 of which meet others: --all lists them", "0 pairs of solids meet"]


def test_faults(vxs, tmp_path):
    open_boxes = small_scene.write(tmp_path / "open.gltf", open_faces=True)
    for component in health(vxs, open_boxes)["health"]["components"]:
        assert component["kind"] == "open" and component["boundary_edges"] == 4 and component["holes"] == 1
    crossing = small_scene.write(tmp_path / "crossing.gltf", boxes=(small_scene.GROUND, ((-1, -0.5, -1), (1, 3, 1)), ((5, 0, 5), (6, 1, 6))))
    report = health(vxs, crossing)["health"]
    assert [c["meets"] for c in report["components"]] == [[1, 2], [0], [0]] and report["total"]["pairs_that_meet"] == 2
    assert "; meets 1, 2; node 0, mesh 0, material 0\n" in vxs("health", crossing, "--all").stdout
    forced = health(vxs, crossing, "--closed", "off")["health"]
    assert [c["kind"] for c in forced["components"]] == ["forced"] * 3 and forced["total"]["pairs_that_meet"] == 0


def test_long_scenes_are_cut(vxs, tmp_path):
    boxes = [((3 * i, 0, 0), (3 * i + 1, 1 + i, 1)) for i in range(40)]
    path = small_scene.write(tmp_path / "scene.gltf", boxes=boxes, open_faces=True)
    assert len(re.findall(r"^ +\d+  open ", vxs("health", path).stdout, re.MULTILINE)) == 30
    assert "10 more with faults" in vxs("health", path).stdout
    assert len(re.findall(r"^ +\d+  open ", vxs("health", path, "--all").stdout, re.MULTILINE)) == 40


def test_rows_fit_into_100_columns(vxs, tmp_path):
    """Names are cut in the middle, between letters; those that fit are whole."""
    path = small_scene.write(tmp_path / "scene.gltf", boxes=[((3 * i, 0, 0), (3 * i + 4, 1, 1)) for i in range(12)])
    gltf = json.loads(path.read_text())
    for letter, length in [(letter, length) for letter in "x\u00e4\u4e2d\U0001f600" for length in (4, 10, 17, 18, 19, 20)]:
        gltf["nodes"][0]["name"] = name = letter * length
        gltf["meshes"][0]["name"] = "wall " + name
        path.write_text(json.dumps(gltf))
        rows = vxs("health", path, "--all").stdout.splitlines()
        assert max(map(len, rows)) <= 100 and "\ufffd" not in "".join(rows)
        places = [row.partition("node ")[2] for row in rows if "; node 0 " in row]
        whole = f"0 '{name}', mesh 0 'wall {name}', material 0"
        for place in places:
            head, _, tail = place.partition("...")
            assert place == whole or (whole.startswith(head) and whole.endswith(tail) and len(head) > 5 < len(tail))
        assert len(places) == 12 and (whole in places or len(whole.encode()) > 45)


def test_errors(vxs, tmp_path):
    assert "no triangles" in vxs("health", small_scene.write(tmp_path / "empty.gltf", boxes=()), status=5).stderr
    assert "error" in vxs("health", tmp_path / "nobody.gltf", status=3).stderr
    path = small_scene.write(tmp_path / "scene.gltf")
    vxs("health", path, "--json", path, status=2)
    vxs("health", path, "--json", tmp_path / "no" / "where.json", status=4)
    vxs("health", path, "--scene", "other", status=2)
    done = vxs("health", path, "--json", "-")
    json.loads(done.stdout)
    assert "without a fault" in done.stderr
