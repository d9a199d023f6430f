# What casts: --exclude and --include patterns, the flag in extras, skins; in every command that loads a scene, in reports, and in
# names.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import re
import struct

import pytest

import small_scene
from test_docs import validator

# what floats over x = 0, 4, 8, ..., each a box: mesh, material
THINGS = {"door_1": ("door", "wood"), "door_2": ("door", "wood"), "frame": ("window", "wood"), "pane": ("window", "glass"),
          "cape": ("cloth", None)}
EVERY = set(THINGS)
COMMANDS = ["bake", "plan", "truth", "compare", "bench", "render", "health", "mend"]


def level(path, skinned=False, extras={}, floating=True):
    """A ground named "earth" and the things over it; the doors are one mesh, and hang below a node "doors"; frame and pane are one mesh with
    two materials, of a node "window". skinned: the cape has a skin, whose joint leaves it where it is, while its node is far away, which means nothing.
    extras: of nodes, meshes and materials by "kind:name"."""
    positions, triangles = small_scene.box((-0.5, 0, -0.5), (0.5, 1, 0.5))
    data = b"".join(struct.pack("<3I", *t) for t in triangles)
    accessors = [{"bufferView": 0, "componentType": 5125, "type": "SCALAR", "count": 3 * len(triangles)}]

    def box(at, scale=(1, 1, 1)):
        nonlocal data
        placed = [[p * s + a for p, s, a in zip(position, scale, at)] for position in positions]
        accessors.append({"bufferView": 0, "byteOffset": len(data), "componentType": 5126, "type": "VEC3", "count": len(placed),
                          "min": [min(c) for c in zip(*placed)], "max": [max(c) for c in zip(*placed)]})
        data += b"".join(struct.pack("<3f", *p) for p in placed)
        return {"attributes": {"POSITION": len(accessors) - 1}, "indices": 0}

    meshes = [{"name": "soil", "primitives": [box((8, -1, 0), (24, 1, 8))]},
              {"name": "door", "primitives": [box((0, 2, 0)) | {"material": 0}]},
              {"name": "window", "primitives": [box((8, 2, 0)) | {"material": 0}, box((12, 2, 0)) | {"material": 1}]},
              {"name": "cloth", "primitives": [box((16, 2, 0))]}]
    if skinned:
        for name, kind, text in ("JOINTS_0", 5121, bytes(4)), ("WEIGHTS_0", 5126, struct.pack("<4f", 1, 0, 0, 0)):
            meshes[3]["primitives"][0]["attributes"][name] = len(accessors)
            accessors.append({"bufferView": 0, "byteOffset": len(data), "componentType": kind, "type": "VEC4", "count": len(positions)})
            data += text * len(positions)
    nodes = [{"name": "earth", "mesh": 0}, {"name": "doors", "children": [2, 3]}, {"name": "door_1", "mesh": 1},
             {"name": "door_2", "mesh": 1, "translation": [4, 0, 0]}, {"name": "window", "mesh": 2},
             {"name": "cape", "mesh": 3, **({"skin": 0, "translation": [99, 0, 0]} if skinned else {})},
             {"name": "noon", "rotation": small_scene.turned(small_scene.NOON), "extensions": {"KHR_lights_punctual": {"light": 0}}}]
    materials = [{"name": "wood"}, {"name": "glass"}]
    for key, value in extras.items():
        kind, name = key.split(":")
        next(o for o in {"node": nodes, "mesh": meshes, "material": materials}[kind] if o["name"] == name)["extras"] = value
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 4, 5, 6] if floating else [0, 6]}], "nodes": nodes, "meshes": meshes,
        "materials": materials, "accessors": accessors, "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [{"name": "noon", "type": "directional"}]}},
        **({"skins": [{"joints": [0]}]} if skinned else {})}))
    return path


UNDER = "".join(f"{4 * n} 1 0.1\n" for n in range(len(THINGS)))


def casting(vxs, path, *options):
    """What darkens the places under it."""
    lit = vxs("truth", path, *options, input=UNDER).stdout.split()
    return {name for name, fraction in zip(THINGS, lit) if float(fraction) == 0}


def baked(vxs, path, out, *options):
    """The same of an asset; and the report of its bake."""
    report = vxs("bake", path, "-o", out, "--resolution", 128, "--region", "-1,-1,-4,19,4,4", "--json", "-", *options)
    lit = vxs("query", out, input=UNDER).stdout.split()
    return {name for name, fraction in zip(THINGS, lit) if float(fraction) == 0}, json.loads(report.stdout)


def command(name, path, folder):
    """A command line, with an asset and outputs where it needs them."""
    return {"bake": ["bake", path, "-o", folder / "new.vxs"], "plan": ["plan", path], "truth": ["truth", path],
            "compare": ["compare", path, folder / "a.vxs", "--points", "1000"],
            "bench": ["bench", path, "-o", folder / "new.json", "--resolution", "64", "--runs", "1", "--points", "0"],
            "render": ["render", path, folder / "a.vxs", "-o", folder / "new.png", "--width", "16", "--height", "16"],
            "health": ["health", path], "mend": ["mend", path, "-o", folder / "new.glb"]}[name]


@pytest.fixture(scope="module")
def whole(vxs, tmp_path_factory):
    """A folder with the level, level.gltf, and all of it baked, a.vxs."""
    folder = tmp_path_factory.mktemp("geometry")
    level(folder / "level.gltf")
    assert baked(vxs, folder / "level.gltf", folder / "a.vxs")[0] == EVERY
    return folder


# --- patterns -------------------------------------------------------------------------------------------------------------------

DOORS, WINDOW = {"door_1", "door_2"}, {"frame", "pane"}
CASES = [
    (["--exclude", "node:door_?"], EVERY - DOORS),
    (["--exclude", "node:doors"], EVERY - DOORS),  # and all nodes below it
    (["--exclude", "mesh:door"], EVERY - DOORS),
    (["--exclude", "door_1"], EVERY - {"door_1"}),  # its mesh is cast by the other node
    (["--exclude", "node:#2"], EVERY - {"door_1"}),
    (["--exclude", "material:wood"], {"pane", "cape"}),
    (["--exclude", "wood"], {"pane", "cape"}),
    (["--exclude", "[gw]lass"], EVERY - {"pane"}),
    (["--exclude", "window"], EVERY - WINDOW),
    (["--exclude", "mesh:cloth", "--exclude", "material:glass"], EVERY - {"pane", "cape"}),
    (["--include", "node:door*"], DOORS),
    (["--include", "mesh:cloth", "--include", "material:glass"], {"pane", "cape"}),
    (["--include", "window", "--exclude", "material:w*"], {"pane"}),
    (["--exclude", "door_2", "--include", "node:doors"], {"door_1"}),
]


@pytest.mark.parametrize("options, left", CASES, ids=lambda v: " ".join(v) if isinstance(v, list) else "")
def test_what_is_named_does_not_cast(vxs, whole, tmp_path, options, left):
    path = whole / "level.gltf"
    assert casting(vxs, path, *options) == left
    found, report = baked(vxs, path, tmp_path / "b.vxs", *options)
    assert found == left
    triangles = report["casters"]["triangles"]
    assert triangles == 12 * (len(left) + ("--include" not in options))
    assert triangles + sum(e["triangles"] for e in report["casters"]["excluded"]) == 72


def test_a_bake_is_judged_with_the_same_options(vxs, whole, tmp_path):
    options = ["--exclude", "node:door_1", "--exclude", "material:glass"]
    baked(vxs, whole / "level.gltf", tmp_path / "a.vxs", *options)
    compare = ["compare", whole / "level.gltf", tmp_path / "a.vxs", "--points", "20000", "--json", "-"]
    assert json.loads(vxs(*compare, *options).stdout)["passed"]
    assert json.loads(vxs(*compare).stdout)["passed"], "those that its metadata tells"
    assert "(differs: geometry)" in vxs(*compare, "--include", "*", status=2).stderr
    assert not json.loads(vxs(*compare, "--include", "*", "--other-scene", status=1).stdout)["passed"]
    pictures = [tmp_path / f"{n}.png" for n in range(3)]
    for picture, more in zip(pictures, [[], options, ["--include", "*"]]):
        vxs("render", whole / "level.gltf", tmp_path / "a.vxs", "-o", picture, "--width", "64", "--height", "64", *more)
    assert pictures[0].read_bytes() == pictures[1].read_bytes() != pictures[2].read_bytes()
    like = ["--like", tmp_path / "a.vxs"]
    assert casting(vxs, whole / "level.gltf", *like) == EVERY - {"door_1", "pane"}
    assert casting(vxs, whole / "level.gltf", *like, "--include", "*") == EVERY


def test_plan_health_and_mend_leave_it_out(vxs, whole, tmp_path):
    path, options = whole / "level.gltf", ["--exclude", "mesh:door", "--include", "*"]
    assert json.loads(vxs("plan", path, "--json", "-", *options).stdout)["casters"]["triangles"] == 48
    assert json.loads(vxs("health", path, "--json", "-", *options).stdout)["health"]["total"]["triangles"] == 48
    report = json.loads(vxs("mend", path, "-o", tmp_path / "m.glb", "--json", "-", *options).stdout)
    assert report["component_count"] == 4
    assert casting(vxs, tmp_path / "m.glb") == EVERY - DOORS


def test_bench_bakes_and_compares_what_casts(vxs, tmp_path):
    path = level(tmp_path / "level.gltf", skinned=True)
    result = json.loads(vxs("bench", path, "-o", "-", "--runs", 1, "--points", 1000, "--resolution", 128, "--skinned", "exclude", "--skinned",
                            "rest", "--exclude", "mesh:door", "--include", "*").stdout)
    validator("bench").validate(result)
    cells = result["cells"]
    assert [(c["triangles"], c["options"].get("skinned")) for c in cells] == [(36, None), (48, "rest")]
    assert all(c["options"]["exclude"] == ["mesh:door"] and c["options"]["include"] == ["*"] for c in cells)
    assert [e["unexplained"] for c in cells for e in c["errors"]] == [0] * 4


@pytest.mark.parametrize("order", [("exclude", "rest"), ("rest", "exclude")])
def test_bench_names_cells_by_what_is_skinned(vxs, tmp_path, order):
    path = level(tmp_path / "level.gltf", skinned=True)
    text = vxs("bench", path, "-o", tmp_path / "b.json", "--runs", 1, "--points", 0, "--resolution", 128, "--skinned", order[0], "--skinned",
               order[1]).stdout
    table = [line.split() for line in text.splitlines() if line.startswith(("scene ", "level.gltf "))]
    assert [row[2] for row in table] == ["skinned", *order]


@pytest.mark.parametrize("name", COMMANDS)
def test_a_pattern_that_names_nothing_is_refused(vxs, whole, name):
    line = command(name, whole / "level.gltf", whole)
    before = sorted(whole.iterdir())
    for pattern, near in [("node:Door*", "near it are node:doors, node:door_1, node:door_2"), ("material:Wood", "near it are material:wood"),
                          ("mesh:wood", "there are mesh:soil, mesh:door, mesh:window, mesh:cloth"), ("noon2", "there are node:earth, mesh:soil, "),
                          ("", "near it are"), ("light:noon", "there are")]:
        for option in ("--exclude", "--include"):
            done = vxs(*line, option, pattern, status=2, input="")
            errors = [text for text in done.stderr.splitlines() if text.startswith("vxs: error: ")]
            assert len(errors) == 1 and f"level.gltf': {option} {pattern} names nothing in the scene; {near}" in errors[0]
    assert sorted(whole.iterdir()) == before


def test_only_the_scene_has_names(vxs, tmp_path):
    path = level(tmp_path / "level.gltf", floating=False)
    for pattern in ("node:doors", "mesh:door", "material:wood"):
        vxs("truth", path, "--exclude", pattern, status=2, input="")
    assert "there are node:earth, node:noon\n" in vxs("truth", path, "--exclude", "node:frame", status=2, input="").stderr


@pytest.mark.parametrize("name", COMMANDS)
def test_nothing_left_says_which_options_did_it(vxs, whole, name):
    line = command(name, whole / "level.gltf", whole)
    before = sorted(whole.iterdir())
    if name == "compare":
        line.append("--other-scene")
    stderr = vxs(*line, "--include", "node:doors", "--exclude", "wood", "--exclude", "mesh:*", status=5, input="").stderr
    assert (": nothing casts a shadow: all that the scene has is excluded; 48 triangles: no --include names them; "
            "24 triangles: --exclude wood\n") in stderr
    assert sorted(whole.iterdir()) == before


# --- extras ---------------------------------------------------------------------------------------------------------------------

OFF = {"vxs_cast_shadow": False, "author": "somebody"}


@pytest.mark.parametrize("extras, options, left", [
    ({"node:doors": OFF}, [], EVERY - DOORS),
    ({"node:door_1": OFF}, [], EVERY - {"door_1"}),
    ({"mesh:door": {"vxs_cast_shadow": 0}}, [], EVERY - DOORS),
    ({"material:glass": OFF}, [], EVERY - {"pane"}),
    ({"material:glass": {"vxs_cast_shadow": True}, "mesh:door": {"vxs_cast_shadow": 1}}, [], EVERY),
    ({"mesh:door": OFF}, ["--include", "mesh:*"], EVERY),
    ({"mesh:door": OFF}, ["--include", "node:*"], EVERY - DOORS),
    ({"node:doors": OFF}, ["--include", "door_1", "--include", "window"], {"door_1", "frame", "pane"}),
], ids=lambda v: json.dumps(v) if isinstance(v, (dict, list)) else "")
def test_extras(vxs, tmp_path, extras, options, left):
    path = level(tmp_path / "level.gltf", extras=extras)
    assert casting(vxs, path, *options) == left
    found, report = baked(vxs, path, tmp_path / "a.vxs", *options)
    assert found == left and report["warnings"] == []


def test_extras_of_a_wrong_type_are_warned_about(vxs, tmp_path):
    wrong = {"vxs_cast_shadow": "false"}
    path = level(tmp_path / "level.gltf", extras={"mesh:door": wrong, "material:glass": wrong})
    done = vxs("truth", path, input=UNDER)
    assert done.stdout.split() == ["0"] * 5
    assert done.stderr == ("vxs: warning: mesh 1 'door': vxs_cast_shadow in its extras is neither true nor false: ignored, as in 1 more\n")
    vxs("truth", path, "--strict", input=UNDER, status=1)


# --- skins ----------------------------------------------------------------------------------------------------------------------


def test_skinned_meshes(vxs, tmp_path):
    path = level(tmp_path / "level.gltf", skinned=True)
    warning = ("vxs: warning: skinned meshes cast no shadow, for they move: 1 with 12 triangles are left out; --skinned rest takes "
               "them in the pose that the file has, --skinned exclude says that this is meant\n")
    for options, left, said in [([], EVERY - {"cape"}, warning), (["--skinned", "exclude"], EVERY - {"cape"}, ""),
                                (["--skinned", "rest"], EVERY, ""), (["--exclude", "cape"], EVERY - {"cape"}, "")]:
        assert casting(vxs, path, *options) == left
        assert vxs("truth", path, *options, input=UNDER).stderr == said
    found, report = baked(vxs, path, tmp_path / "a.vxs")
    assert found == EVERY - {"cape"} and report["casters"]["excluded"] == [{"rule": "skinned", "triangles": 12}]
    assert "skinned" not in report["options"] and report["warnings"] == [warning[len("vxs: warning: "):-1]]
    found, report = baked(vxs, path, tmp_path / "a.vxs", "--skinned", "rest")
    assert found == EVERY and report["casters"]["excluded"] == [] and report["options"]["skinned"] == "rest"
    assert "12 triangles: skinned, which --skinned rest includes\n" in vxs("truth", path, "--include", "cape", status=5, input="").stderr


def test_real_skins(vxs, scenes, tmp_path):
    for name, triangles in [("Fox.glb", 576), ("RiggedFigure/RiggedFigure.gltf", 256)]:
        path = scenes / "real" / "features" / name
        done = vxs("bake", path, "-o", tmp_path / "a.vxs", "--sun", "0,-1,0", status=5)
        assert f"1 with {triangles} triangles are left out" in done.stderr and "--skinned rest" in done.stderr.splitlines()[-1]
        assert json.loads(vxs("health", path, "--skinned", "rest", "--json", "-").stdout)["health"]["total"]["triangles"] == triangles


# --- reports --------------------------------------------------------------------------------------------------------------------


def test_reports_say_what_was_excluded(vxs, tmp_path):
    path = level(tmp_path / "level.gltf", skinned=True, extras={"material:glass": OFF})
    options = ["--exclude", "node:door_1", "--exclude", "node:door?1", "--include", "node:door*", "--include", "node:win*", "--include", "cape"]
    plan = json.loads(vxs("plan", path, "--json", "-", *options).stdout)
    bake = json.loads(vxs("bake", path, "-o", tmp_path / "a.vxs", "--resolution", "64", "--json", "-", *options).stdout)
    for report in plan, bake:
        assert report["casters"]["excluded"] == [
            {"rule": "include", "triangles": 12}, {"rule": "exclude", "pattern": "node:door_1", "triangles": 12},
            {"rule": "exclude", "pattern": "node:door?1", "triangles": 0}, {"rule": "extras", "triangles": 12},
            {"rule": "skinned", "triangles": 12}]
        assert report["options"]["exclude"] == ["node:door_1", "node:door?1"]
        assert report["options"]["include"] == ["node:door*", "node:win*", "cape"]
    for name in "plan", "bake":
        text = vxs(*command(name, path, tmp_path), "--resolution", "64", "--verbose", *options).stdout
        for line in ("12 triangles excluded: no --include names them", "12 triangles excluded: --exclude node:door_1",
                     "0 triangles excluded: --exclude node:door?1", "12 triangles excluded: vxs_cast_shadow is false in their extras",
                     "12 triangles excluded: skinned, which --skinned rest includes"):
            assert f"\n             {line}\n" in text
    assert "\nleft out     12 triangles excluded: --exclude node:door_1\n" in vxs("plan", path, *options).stdout
    assert "excluded:" not in vxs("plan", level(tmp_path / "plain.gltf"), "--verbose").stdout


# --- names ----------------------------------------------------------------------------------------------------------------------


def renamed(path, change):
    """Change the JSON of a .gltf."""
    gltf = json.loads(path.read_text())
    change(gltf)
    path.write_text(json.dumps(gltf))
    return path


def test_health_names_every_row(vxs, whole):
    report = json.loads(vxs("health", whole / "level.gltf", "--json", "-").stdout)["health"]
    found = [[c["from"][key] for key in ("node", "node_name", "mesh", "mesh_name", "material", "material_name", "parts")]
             for c in report["components"]]
    assert found == [[0, "earth", 0, "soil", None, None, 1], [2, "door_1", 1, "door", 0, "wood", 1], [3, "door_2", 1, "door", 0, "wood", 1],
                     [4, "window", 2, "window", 0, "wood", 1], [4, "window", 2, "window", 1, "glass", 1], [5, "cape", 3, "cloth", None, None, 1]]
    text = vxs("health", whole / "level.gltf", "--all").stdout
    assert re.search(r"^ +3 .*\n.*; node 4 'window', mesh 2 'window', material 0 'wood'$", text, re.MULTILINE)
    assert re.search(r"^ +5 .*\n.*; node 5 'cape', mesh 3 'cloth'$", text, re.MULTILINE)


def test_components_of_several_parts_name_the_first(vxs, tmp_path):
    """Frame and pane in one place share their edges."""
    def join(gltf):
        gltf["meshes"][2]["primitives"][1]["attributes"] = gltf["meshes"][2]["primitives"][0]["attributes"]
        del gltf["nodes"][4]["name"]
    path = renamed(level(tmp_path / "level.gltf"), join)
    report = json.loads(vxs("health", path, "--json", "-").stdout)["health"]
    assert [c["from"]["parts"] for c in report["components"]] == [1, 1, 1, 2, 1] and report["components"][3]["from"]["node_name"] is None
    assert "; node 4, mesh 2 'window', material 0 'wood' and 1 more\n" in vxs("health", path).stdout


def test_names_are_fit_to_print(vxs, tmp_path):
    def rename(gltf):
        gltf["nodes"][2]["name"] = "\x1b[31mred\n"
        gltf["meshes"][1]["name"] = "é" * 100
    path = renamed(level(tmp_path / "level.gltf"), rename)
    text = vxs("health", path, "--all").stdout
    assert re.search(r"; node 2 '\?\[31mred\?', mesh 1 'é+\.\.\.é+', material 0 'wood'\n", text) and "\x1b" not in text
    assert "\x1b" not in vxs("truth", path, "--exclude", "node:\x1b", status=2, input="").stderr
    assert "--exclude node:?[31m*\n" in vxs("plan", path, "--exclude", "node:\x1b[[]31m*", "--verbose").stdout.replace("[[]", "[")


def rows(text):
    """Numbers of the components of a health table, in its order."""
    return [int(n) for n in re.findall(r"^ +(\d+)  (?:solid|open|forced|double sided|inward|occupied|alpha mask) ", text, re.MULTILINE)]


def test_real_faults_come_first(vxs, tmp_path):
    """Large solids that meet have no fault, a small open box has one, and a solid with a repeated pair of triangles a lesser one."""
    path = small_scene.write(tmp_path / "scene.gltf", boxes=(small_scene.GROUND, ((-1, -0.5, -1), (1, 3, 1)), ((5, 2, 5), (6, 3, 6))))

    def cut(gltf):
        gltf["accessors"][1]["count"] -= 6
    renamed(path, cut)
    text = vxs("health", path).stdout
    assert rows(text) == [2] and "2 without a fault, 2 of which meet others: --all lists them" in text and "1 pairs of solids meet" in text
    text = vxs("health", path, "--all").stdout
    assert rows(text) == [2, 0, 1] and "; meets 1; node 0, mesh 0, material 0\n" in text
    report = json.loads(vxs("health", path, "--json", "-").stdout)["health"]
    assert [(c["faults"], c["meets"]) for c in report["components"]] == [(0, [1]), (0, [0]), (2, [])]


def test_lesser_faults_come_second(vxs, tmp_path):
    """Two boxes that share a wall are one solid with edges of four faces: larger than the open box, and behind it."""
    path = small_scene.write(tmp_path / "scene.gltf", boxes=(((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1)), ((5, 2, 5), (6, 3, 6)), ((8, 0, 8), (9, 1, 9))))

    def cut(gltf):
        gltf["accessors"][1]["count"] -= 6
    renamed(path, cut)
    report = json.loads(vxs("health", path, "--json", "-").stdout)["health"]["components"]
    assert [(c["triangles"], c["faults"]) for c in report] == [(24, 1), (12, 0), (10, 2)]
    assert rows(vxs("health", path).stdout) == [2, 0] and rows(vxs("health", path, "--all").stdout) == [2, 0, 1]


def test_mend_names_every_row(vxs, tmp_path):
    path = level(tmp_path / "level.gltf")

    def damage(gltf):
        """The doors are open; the frame has a triangle too many, which comes out again."""
        gltf["accessors"].append(gltf["accessors"][0] | {"count": 30})
        gltf["accessors"].append(gltf["accessors"][0] | {"count": 3})
        gltf["meshes"][1]["primitives"][0]["indices"] = len(gltf["accessors"]) - 2
        gltf["meshes"][2]["primitives"].insert(1, gltf["meshes"][2]["primitives"][0] | {"indices": len(gltf["accessors"]) - 1, "material": 1})
    renamed(path, damage)
    done = vxs("mend", path, "-o", tmp_path / "m.glb", "--json", tmp_path / "m.json", "--verbose")
    lines = [line for line in done.stdout.splitlines() if line.startswith("component of")]
    assert lines == [
        "component of 10 triangles from triangle 12, node 2 'door_1', mesh 1 'door', material 0 'wood', still open: 1 holes left",
        "component of 10 triangles from triangle 22, node 3 'door_2', mesh 1 'door', material 0 'wood', still open: 1 holes left",
        "component of 13 triangles from triangle 32, node 4 'window', mesh 2 'window', material 0 'wood' and 1 more, now closed: "
        "1 repeated triangles removed"]
    assert [c["from"]["node_name"] for c in json.loads((tmp_path / "m.json").read_text())["components"]] == ["door_1", "door_2", "window"]


# --- real scenes ----------------------------------------------------------------------------------------------------------------


def test_instances_and_copies_are_excluded_alike(vxs, scenes):
    """The same city, once with nodes and once with instances."""
    counts = []
    for name in ("kaykit_city.glb", "kaykit_city_gpu_instancing.glb"):
        for options in (["--exclude", "node:building_*", "--exclude", "mesh:Cube.949"], ["--include", "node:car_*"]):
            report = json.loads(vxs("plan", scenes / "real" / name, "--sun", "0,-1,0", "--resolution", "64", "--json", "-", *options).stdout)["casters"]
            counts.append([report["triangles"], report["excluded"]])
            assert 0 < report["triangles"] + report["collapsed_triangles"] + sum(e["triangles"] for e in report["excluded"]) == 177426
    assert counts[:2] == counts[2:] and counts[0][0] != counts[1][0]


def test_a_material_of_a_real_scene(vxs, scenes):
    path = scenes / "real" / "room_with_spheres_closed.glb"
    report = json.loads(vxs("plan", path, "--sun", "0,-1,0", "--resolution", "64", "--exclude", "material:Glass", "--json", "-").stdout)["casters"]
    assert report["triangles"] == 232 and report["excluded"] == [{"rule": "exclude", "pattern": "material:Glass", "triangles": 63488}]
    assert "near it are material:Glass\n" in vxs("plan", path, "--sun", "0,-1,0", "--exclude", "material:glass", status=2).stderr
