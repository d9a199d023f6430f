# vxs bake --watch: a bake after each change of the scene or of a file that it names, until interrupted.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import os
import selectors
import signal
import subprocess
import time

import pytest

import small_scene
from small_scene import NOON


@pytest.fixture
def folder(tmp_path):
    """A scene whose buffer lies in a folder of its own, by a name that a URI escapes."""
    gltf = json.loads(small_scene.write(tmp_path / "level.gltf", lights=(("noon", "directional", NOON),)).read_text())
    (tmp_path / "my data").mkdir()
    (tmp_path / "my data" / "a.bin").write_bytes(base64.b64decode(gltf["buffers"][0]["uri"].partition(",")[2]))
    gltf["buffers"][0]["uri"] = "my%20data/a.bin"
    (tmp_path / "level.gltf").write_text(json.dumps(gltf))
    return tmp_path


@pytest.fixture
def watching(vxs_path, folder):
    """line(): the next line of output, or of errors, of the command that watches; None after two seconds without one."""
    process = subprocess.Popen([vxs_path, "bake", "level.gltf", "-o", "level.vxs", "--resolution", "64", "--watch"], cwd=folder, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)
    ready = selectors.DefaultSelector()
    ready.register(process.stdout, selectors.EVENT_READ)

    def line(seconds=60):
        return process.stdout.readline() if ready.select(seconds) else None

    line.process = process
    yield line
    process.kill()
    process.wait()


def replace(path, data):
    """As editors write: beside it, then renamed."""
    path.with_name("new").write_bytes(data)
    os.replace(path.with_name("new"), path)


def test_bakes_after_each_change(folder, watching):
    scene, data = (folder / "level.gltf").read_bytes(), folder / "my data" / "a.bin"
    assert watching().startswith("level.vxs: ")
    first = (folder / "level.vxs").read_bytes()
    (folder / "notes.txt").write_text("nothing to bake")
    assert watching(2) is None
    replace(folder / "level.gltf", scene.replace(b'"noon"', b'"dusk"'))
    assert watching().startswith("level.vxs: ")
    second = (folder / "level.vxs").read_bytes()
    assert b"dusk" not in first and first != second
    (folder / "level.gltf").write_bytes(b"{ broken")
    assert watching().startswith("vxs: error: ") and (folder / "level.vxs").read_bytes() == second
    (folder / "level.gltf").write_bytes(scene)
    assert watching().startswith("level.vxs: ") and (folder / "level.vxs").read_bytes() == first
    changed = bytearray(data.read_bytes())
    changed[:12] = bytes(12)
    replace(data, bytes(changed))
    assert watching().startswith("level.vxs: ") and (folder / "level.vxs").read_bytes() != first


def test_ends_with_a_signal(folder, watching):
    watching()
    watching.process.send_signal(signal.SIGINT)
    assert watching.process.wait(10) == 130
    time.sleep(0.2)
    assert sorted(path.name for path in folder.iterdir()) == ["level.gltf", "level.vxs", "my data"]


def test_what_cannot_be_watched(vxs, folder):
    for line in (("-", "-o", folder / "a.vxs"), (folder / "level.gltf", "-o", "-")):
        assert "--watch needs a file" in vxs("bake", *line, "--watch", status=2).stderr
