# Blenders to test in, each one process that answers requests (inside.py) for all tests of a run.
# BLENDER: a Blender (default: of PATH).  BPY: Pythons with the module bpy, separated by colons.
# VXS: the command.  ADDON: the add-on's zip.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
from fixtures import ROOT, vxs, vxs_path  # noqa: E402, F401 (fixtures)

FOLDER = pathlib.Path(__file__).resolve().parent
HOSTS = {"blender": os.environ.get("BLENDER", "blender"),
         **{f"bpy {n + 1}": path for n, path in enumerate(filter(None, os.environ.get("BPY", "").split(":")))}}
if len(HOSTS) == 1:
    HOSTS["bpy"] = ""


ADDON = ROOT / os.environ.get("ADDON", "build/blender/vxs_shadows-0.2.0.zip")


class Died(Exception):
    pass


class Inside:
    """A Blender that runs inside.py. Its user folders are its own, and empty at first."""

    def __init__(self, program, home, environment=None):
        self.log = home / "log"
        (home / "tmp").mkdir()
        to_read, to_write = os.pipe()
        from_read, from_write = os.pipe()
        name = pathlib.Path(program).name
        start = [program] if name.startswith("python") else [program, "-b", "--factory-startup", "--python-exit-code", "3", "--python"]
        with open(self.log, "w") as log:
            self.process = subprocess.Popen(
                [*start, FOLDER / "inside.py", "--", str(to_read), str(from_write)], stdin=subprocess.DEVNULL, stdout=log,
                stderr=subprocess.STDOUT, pass_fds=(to_read, from_write), cwd=home,
                env={**os.environ, "HOME": str(home), "XDG_CONFIG_HOME": str(home / ".config"), "TMPDIR": str(home / "tmp"),
                     "PYTHONDONTWRITEBYTECODE": "1",
                     **(environment or {})})
        os.close(to_read)
        os.close(from_write)
        self.requests, self.replies = os.fdopen(to_write, "w"), os.fdopen(from_read)

    def __call__(self, do, **arguments):
        print(json.dumps({"do": do, **arguments}), file=self.requests, flush=True)
        line = self.replies.readline()
        if not line:
            raise Died(f"Blender ended at '{do}': {self.printed()[-2000:]}")
        reply = json.loads(line)
        if "error" in reply:
            raise AssertionError(reply["error"])
        return reply["result"]

    def printed(self):
        return self.log.read_text(errors="replace")

    def close(self):
        self.requests.close()
        self.replies.close()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:  # the module bpy sometimes hangs when Python ends
            self.process.kill()


def path_of(host):
    """The program, or None; and why there is none."""
    if host.startswith("bpy"):
        python = HOSTS[host]
        if not python:
            return None, "no module bpy: BPY=/path/to/python names a Python that has it"
        done = subprocess.run([python, "-c", "import bpy"], capture_output=True) if shutil.which(python) else None
        return (python, "") if done and done.returncode == 0 else (None, f"{python} has no module bpy")
    return shutil.which(HOSTS[host]), f"no Blender: {HOSTS[host]} is not on PATH; Debian: blender"


@pytest.fixture(scope="session", params=HOSTS)
def program(request):
    """The program of each Blender to test in."""
    path, why = path_of(request.param)
    if not path:
        pytest.skip(why)
    return path


@pytest.fixture(scope="session")
def blender(program, tmp_path_factory):
    """ask(what, **arguments): inside Blender."""
    started = Inside(program, tmp_path_factory.mktemp("blender"))
    yield started
    started.close()


@pytest.fixture(scope="session")
def addon(blender, vxs_path):  # noqa: F811 (a fixture)
    """The same, with the add-on installed from its zip, and the command in its preferences."""
    if not ADDON.is_file():
        pytest.skip(f"no add-on at {ADDON}: make blender")
    blender("install", path=str(ADDON))
    blender("prefer", vxs=str(vxs_path))
    return blender
