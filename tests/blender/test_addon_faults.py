# What goes wrong is told in one sentence, never as a traceback; nothing is left behind, and the file that was there stays as it was.
# SPDX-License-Identifier: GPL-3.0-or-later
import subprocess

import pytest

# what stands where vxs should: its text, and a word of what the user is told
PROGRAMS = {
    "fails and says nothing": ("#!/bin/sh\nexit 1\n", "status 1"),
    "says why": ("#!/bin/sh\necho 'vxs: error: the moon is full' >&2\nexit 3\n", "the moon is full"),
    "is killed": ("#!/bin/sh\nkill -9 $$\n", "signal 9"),
    "prints rubbish": ("#!/bin/sh\nhead -c 300000 /dev/urandom >&2\n"
                       "printf '{\\n{}\\n{\"share\": \"x\"}\\n[1]\\nnull\\n{\"share\":' >&2\nexit 1\n", "status 1"),
    "wrong progress": ("#!/bin/sh\necho '{\"share\": \"half\", \"doing\": 3, \"seconds_left\": []}' >&2\nsleep 0.3\nexit 1\n", "status 1"),
    "writes no report": ("#!/bin/sh\nexit 0\n", "vxs"),
    "writes a wrong report": ("#!/bin/sh\nwhile [ \"$1\" != --json ]; do shift; done\necho '{\"a\": 1}' >\"$2\"\n", "vxs"),
    "writes half a report": ("#!/bin/sh\nwhile [ \"$1\" != --json ]; do shift; done\necho '{\"a\": 1' >\"$2\"\n", "vxs"),
    "has no interpreter": ("#!/no/such/program\n", "does not start"),
    "is no program": ("\x7fELF rubbish\n", "does not start"),
    "is empty": ("", "vxs"),
}


@pytest.fixture
def scene(addon, vxs_path):
    """A scene that bakes in no time; the command is put back in its place."""
    addon("make", scene="mirrored")
    yield addon
    addon("limit_files", size=None)
    addon("prefer", vxs=str(vxs_path))


def fails(addon, says, **arguments):
    """A bake fails with one line that has some words, and leaves nothing."""
    printed = len(addon.printed())
    baked = addon("bake", resolution=128, **arguments)
    assert isinstance(baked["outcome"], str) and baked["outcome"].startswith("Error: "), baked
    assert says in baked["outcome"] and "\n" not in baked["outcome"] and len(baked["outcome"]) < 400, baked["outcome"]
    assert "Traceback" not in addon.printed()[printed:] and not baked["is_running"]
    assert addon("temporary_files") == []
    return baked["outcome"]


def put(path, text):
    path.write_text(text)
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize("what", PROGRAMS)
def test_a_program_that(what, scene, tmp_path):
    text, says = PROGRAMS[what]
    scene("prefer", vxs=put(tmp_path / "vxs", text))
    file = tmp_path / "level.vxs"
    file.write_text("old")
    fails(scene, says, filepath=str(file))
    assert file.read_text() == "old" and sorted(path.name for path in tmp_path.iterdir()) == ["level.vxs", "vxs"]


def test_no_program(scene, tmp_path):
    for path in (tmp_path / "none", tmp_path, put(tmp_path / "text", "text")):
        if path == str(tmp_path / "text"):
            (tmp_path / "text").chmod(0o644)
        scene("prefer", vxs=str(path))
        assert "preferences" in fails(scene, "is not a program", filepath=str(tmp_path / "a.vxs"))
    scene("prefer", vxs="")
    path = scene("get", expression="__import__('os').environ.pop('PATH')")
    try:
        assert "make" in fails(scene, "was not found", filepath=str(tmp_path / "a.vxs"))
    finally:
        scene("get", expression=f"__import__('os').environ.update(PATH={path!r})")


@pytest.mark.parametrize("on_signal", ("exit 130", ":"), ids=("stops", "does not stop"))
def test_a_program_that_hangs_is_cancelled(on_signal, scene, tmp_path):
    scene("prefer", vxs=put(tmp_path / "vxs", f"#!/bin/sh\ntrap '{on_signal}' INT\nwhile :; do sleep 0.1; done\n"))
    told = scene("bake_and_cancel", filepath=str(tmp_path / "level.vxs"))
    assert told["outcome"] == ["CANCELLED"] and "cancelled" in told["said"][-1] and told["seconds"] < 10 and not told["is_running"]
    assert scene("temporary_files") == [] and not (tmp_path / "level.vxs").exists()


def test_a_bake_is_cancelled(addon, tmp_path):
    addon("make", scene="many")
    (tmp_path / "level.vxs").write_text("old")
    told = addon("bake_and_cancel", filepath=str(tmp_path / "level.vxs"), after=0.05)
    assert told["outcome"] == ["CANCELLED"] and "cancelled" in told["said"][-1] and told["seconds"] < 5
    assert [path.name for path in tmp_path.iterdir()] == ["level.vxs"] and (tmp_path / "level.vxs").read_text() == "old"
    assert addon("temporary_files") == []
    assert addon("bake", filepath=str(tmp_path / "b.vxs"), resolution=64)["outcome"] == ["FINISHED"], "another bake works"


@pytest.fixture
def mounted(tmp_path):
    """disk(options): a small file system, in a folder of its own."""
    folders = []

    def disk(options):
        folder = tmp_path / f"disk {len(folders)}"
        folder.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], capture_output=True, text=True)
        if done.returncode:
            pytest.skip(f"tmpfs cannot be mounted here: {done.stderr.strip()}")
        folders.append(folder)
        return folder

    yield disk
    for folder in folders:
        subprocess.run(["umount", folder], check=True)


def test_a_folder_that_is_read_only(scene, mounted):
    fails(scene, "ead-only", filepath=str(mounted("ro,size=64k") / "level.vxs"))


def test_a_folder_that_is_not_there(scene, tmp_path):
    fails(scene, "No such file", filepath=str(tmp_path / "none" / "level.vxs"))


def test_a_disk_that_is_full(scene, mounted):
    disk = mounted("size=4k")
    (disk / "level.vxs").write_text("old")
    fails(scene, "No space left", filepath=str(disk / "level.vxs"))
    assert [(path.name, path.read_text()) for path in disk.iterdir()] == [("level.vxs", "old")]


def test_no_room_for_temporary_files(addon, mounted, tmp_path):
    addon("make", scene="many")
    addon("get", expression=f"setattr(__import__('tempfile'), 'tempdir', {str(mounted('size=16k'))!r})")
    try:
        fails(addon, "No space left", filepath=str(tmp_path / "level.vxs"))
    finally:
        addon("get", expression="setattr(__import__('tempfile'), 'tempdir', None)")
    addon("get", expression="setattr(__import__('tempfile'), 'tempdir', '/no/such/folder')")
    try:
        printed = addon("bake", filepath=str(tmp_path / "level.vxs"), resolution=64)["outcome"]
        assert printed.startswith("Error: ") and "Traceback" not in printed
    finally:
        addon("get", expression="setattr(__import__('tempfile'), 'tempdir', None)")
    assert not (tmp_path / "level.vxs").exists()
