# VxsLevel: words and constants of exports and of files packed fast, to the bit; what it refuses; files with damage.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

from conftest import ROOT

SCENES = {"city": ("2048", 1), "room": ("512", 2), "forest": ("1024", 1)}
TIMES = 200


def test_files(godot, vxs, tmp_path):
    files, cases = {"main.gd": (ROOT / "tests/godot/files.gd").read_text()}, {"read": [], "damaged": "city.vxs", "times": TIMES}
    for scene, (resolution, _) in SCENES.items():
        vxs("scene", scene, "-o", tmp_path / f"{scene}.glb", "--quiet")
        vxs("bake", tmp_path / f"{scene}.glb", "-o", tmp_path / f"{scene}.vxs", "--resolution", resolution, "--pack", "fast", "--quiet")
        vxs("export", tmp_path / f"{scene}.vxs", "-o", tmp_path / scene, "--axes", "godot", "--quiet")
        files[f"{scene}.vxs"] = (tmp_path / f"{scene}.vxs").read_bytes()
        files |= {f"{scene}/{path.name}": path.read_bytes() for path in (tmp_path / scene).iterdir()}
        cases["read"] += [scene, f"{scene}.vxs"]
    vxs("export", ROOT / "tests/golden/sample.vxs", "-o", tmp_path / "dag", "--quiet")
    vxs("export", tmp_path / "city.vxs", "-o", tmp_path / "unity", "--axes", "unity", "--quiet")
    for folder in ("dag", "unity"):
        files |= {f"{folder}/{path.name}": path.read_bytes() for path in (tmp_path / folder).iterdir()}
    files |= {f"short/{name}": files[f"city/{name}"] for name in ("shadows.json", "lights.bin")}
    files |= {"short/words.bin": files["city/words.bin"][:-4], "text/shadows.json": "{", "kinds/words.bin": b"1234",
              "kinds/shadows.json": '{"axes": "gltf", "lights": [1], "word_count": [1]}', "none/x": "", "words.vxs": b"words" * 20,
              "dag.vxs": (ROOT / "tests/golden/sample.vxs").read_bytes(), "small.vxs": (ROOT / "tests/golden/blocks.vxs").read_bytes()}
    refused = {"dag": "light 'sun' is a DAG", "unity": "lights for 'unity': export with --axes godot", "short": "words.bin is not that",
               "text": "is not JSON", "kinds": "words.bin is not that", "none": "no shadows.json", "dag.vxs": "version 1 of the format",
               "small.vxs": "is packed small: bake with --pack fast", "words.vxs": "not a .vxs file"}
    result = godot(files | {"cases.json": json.dumps(cases | {"refused": list(refused)})})

    got, errors = result.values, [line for line in result.faults if not line.strip().startswith("at: ")]
    for scene, (_, lights) in SCENES.items():
        constants, words = files[f"{scene}/lights.bin"], files[f"{scene}/words.bin"]
        for path in (scene, f"{scene}.vxs"):
            assert len(got[f"{path}.names"].split("|")) == lights
            read = got[f"{path}.words"]
            assert read[:len(words)] == words and not any(read[len(words):]), path
            for at in range(0, len(constants), 96):  # but for fractions of the origin, which lookups do not read
                assert got[f"{path}.constants"][at:at + 88] == constants[at:at + 88], path
    assert got["loaded"] == got["dock"] == got["own"] == "true"
    assert [got.get(f"pair.{n}") for n in range(3)] == ["lamp3 lamp", "y corner", None]
    assert got["scaled"] == "false" and any("is scaled: bake it at the size" in line for line in errors)
    for path, text in refused.items():
        assert got[f"{path}.opened"] == "false"
        assert [line for line in errors if line.startswith(f"ERROR: vxs: res://{path}: ") and text in line], (path, errors)
    assert TIMES / 2 < int(got["refused"]) <= TIMES
    assert not [line for line in result.printed if "SCRIPT ERROR" in line or "SHADER ERROR" in line]
