# What a file is, by its bytes where it is read and by its name where it is written: what does not fit is said before the work.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import subprocess
import threading

import pytest

import small_scene

SMALL = ("--resolution", 64)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("kinds") / "small.gltf")


@pytest.fixture(scope="module")
def asset(vxs, scene):
    path = scene.with_suffix(".vxs")
    vxs("bake", scene, "-o", path, *SMALL)
    return path


@pytest.fixture(scope="module")
def inputs(vxs, scene, asset):
    """Of each kind that a command reads, and a picture: their names say nothing."""
    folder = scene.parent
    vxs("scene", "city", "-o", folder / "city.glb", "--triangles", 1000, "--blocks", 1)
    vxs("render", scene, asset, "-o", folder / "a.png", "--width", 16, "--height", 16)
    vxs("plan", scene, "--json", folder / "plan.json")
    found = {"gltf": scene, "glb": folder / "city.glb", "vxs": asset,
             "png": folder / "a.png", "report": folder / "plan.json"}
    for kind, path in found.items():
        (folder / kind).write_bytes(path.read_bytes())
    (folder / "json").write_text('{ "any": 1 }')
    (folder / "folder").mkdir()
    return {kind: folder / kind for kind in [*found, "json", "folder"]}


# --- names of outputs ---------------------------------------------------------------------------------------------------------

OUTPUTS = [("bake {gltf} --resolution 64 -o {}", ".vxs"), ("bake {gltf} --resolution 64 -o - --json {}", ".json"),
           ("bake {gltf} --resolution 64 -o - --report {}", ".html"), ("plan {gltf} -o {}", ".vxs"), ("plan {gltf} --json {}", ".json"),
           ("info {vxs} --json {}", ".json"), ("validate {vxs} --json {}", ".json"), ("compare {gltf} {vxs} --points 10 --json {}", ".json"),
           ("render {gltf} {vxs} --width 16 --height 16 -o {}", ".png"), ("health {gltf} --json {}", ".json"),
           ("mend {gltf} -o {}", ".glb"), ("mend {gltf} -o - --json {}", ".json"), ("scene room --triangles 1000 -o {}", ".glb"),
           ("bench {gltf} --resolution 64 --runs 1 --points 0 -o {}", ".json"), ("report {bench} -o {}", ".html")]


@pytest.mark.parametrize("line, extension", OUTPUTS, ids=lambda v: v)
def test_extensions_of_outputs(vxs_path, vxs, inputs, tmp_path, line, extension):
    bench = inputs["gltf"].parent / "bench.json"
    if "{bench}" in line and not bench.exists():
        vxs("bench", inputs["gltf"], "--resolution", 64, "--runs", 1, "--points", 0, "-o", bench)

    def run(name, *options):
        done = subprocess.run([vxs_path, *line.format(tmp_path / name, **inputs, bench=bench).split(), *options], capture_output=True)
        return done.returncode, done.stderr.decode()

    def left():
        return sorted(path.name for path in tmp_path.iterdir())

    written = 0 if line.startswith("plan {gltf} -o") else 1
    option = line.split()[-2]
    for name in ("a" + extension.upper(), "a", ".a"):
        status, text = run(name)
        assert status == 0 and "vxs: warning" not in text and left() == [name] * written
        for path in tmp_path.iterdir():
            path.unlink()
    status, text = run("a.dat")
    assert status == 0 and f"vxs: warning: {option} {tmp_path}/a.dat: what is written is {extension}, and '.dat' does not say so: rename it" in text
    assert left() == ["a.dat"] * written
    for path in tmp_path.iterdir():
        path.unlink()
    status, text = run("a.dat", "--strict")
    assert (status, text.count("\n"), left()) == (1, 1, []) and "'.dat' does not say so" in text
    for other in {".vxs", ".gltf", ".glb", ".json", ".html", ".png"} - {extension}:
        status, text = run("a" + other)
        assert (status, left()) == (2, [])
        assert text == f"vxs: error: {option} {tmp_path}/a{other}: '{other}' is the extension of other files: what is written is {extension}\n"


def test_names_are_looked_at_before_the_scene(vxs, tmp_path):
    words = ("bake", tmp_path / "nobody.gltf", "-o")
    assert "nobody.gltf': No such file" in vxs(*words, tmp_path / "a.dat", status=3).stderr
    assert "does not say so" in vxs(*words, tmp_path / "a.dat", "--strict", status=1).stderr
    assert "extension of other files" in vxs(*words, tmp_path / "a.glb", status=2).stderr


def test_devices_and_pipes_have_names_of_their_own(vxs, scene, tmp_path):
    os.mkfifo(tmp_path / "pipe.dat")
    found = []
    reader = threading.Thread(target=lambda: found.append((tmp_path / "pipe.dat").read_bytes()))
    reader.start()
    assert vxs("bake", scene, *SMALL, "-o", tmp_path / "pipe.dat", "--json", "/dev/null").stderr == ""
    reader.join()
    assert found[0][1:4] == b"VXS"


def test_scenes_from_pipes_are_not_looked_into(vxs_path, scene):
    """All is in the pipe already: a look would take it away."""
    reading, writing = os.pipe()
    os.write(writing, scene.read_bytes())
    os.close(writing)
    done = subprocess.run([vxs_path, "plan", "/dev/stdin", "--resolution", "64"], stdin=reading, capture_output=True)
    os.close(reading)
    assert done.returncode == 0, done.stderr


# --- files of other kinds -----------------------------------------------------------------------------------------------------

KINDS = {"gltf": "a glTF scene", "glb": "a glTF scene", "vxs": "a .vxs file", "png": "a picture", "report": "a report of vxs",
         "json": "JSON", "folder": "a folder"}
READERS = [("bake {} -o {out}", "gltf"), ("plan {}", "gltf"), ("truth {} --sun 0,-1,0", "gltf"), ("compare {} {vxs}", "gltf"),
           ("render {} {vxs} -o {out}", "gltf"), ("health {}", "gltf"), ("mend {} -o {out}", "gltf"), ("bench {} -o {out}", "gltf"),
           ("info {}", "vxs"), ("validate {}", "vxs"), ("query {}", "vxs"), ("compare {gltf} {vxs} {}", "vxs"),
           ("render {gltf} {} -o {out}", "vxs"), ("report {} -o {out}", "json"), ("bench {gltf} -o {out} --against {}", "json"),
           ("compare {gltf} {vxs} --bake-report {}", "json")]


@pytest.mark.parametrize("line, expected", READERS, ids=lambda v: v)
def test_a_file_of_another_kind_is_named(vxs, inputs, tmp_path, line, expected):
    fitting = {"gltf": {"gltf", "glb", "json"}, "vxs": {"vxs"}, "json": {"json", "report"}}[expected]
    for kind in KINDS.keys() - fitting:
        words = [word.format(inputs[kind], **inputs, out=tmp_path / "out") for word in line.split()]
        text = vxs(*words, status=3, input="").stderr
        what = f"is {KINDS[kind]}, expected {KINDS[expected]}"
        assert text.startswith("vxs: error: ") and text.count("\n") == 1
        if "--against" in line or "--bake" in line:
            assert f"{words[-2]} {inputs[kind]}: {what}\n" in text
        else:
            assert f"'{inputs[kind]}' {what}: usage is vxs {words[0]} " in text
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["gltf", "glb"])
@pytest.mark.parametrize("line", ["render {vxs} {scene} -o {out}", "compare {vxs} {scene}"])
def test_operands_that_are_swapped(vxs, inputs, tmp_path, line, kind):
    words = [word.format(vxs=inputs["vxs"], scene=inputs[kind], out=tmp_path / "a.png") for word in line.split()]
    text = vxs(*words, status=3).stderr
    assert text.startswith(f"vxs: error: '{inputs['vxs']}' is a .vxs file and '{inputs[kind]}' is a glTF scene: they are swapped: usage is")
    assert list(tmp_path.iterdir()) == []


def test_text_of_scenes(vxs, scene, tmp_path):
    gltf = json.loads(scene.read_text())
    late = {"extras": "x" * 9000} | {key: gltf[key] for key in gltf if key != "asset"} | {"asset": gltf["asset"]}
    for name, start in (("late.gltf", ""), ("mark.gltf", "\ufeff"), ("blank.gltf", "\n\n  ")):
        (tmp_path / name).write_text(start + json.dumps(late if name == "late.gltf" else gltf))
        vxs("plan", tmp_path / name, *SMALL)
        kind = "JSON" if name == "late.gltf" else "a glTF scene"
        assert f"is {kind}, expected a .vxs file" in vxs("info", tmp_path / name, status=3).stderr
