# The zip in a fresh user folder: installed by make, kept by Blender, and used by a build machine with one command.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import shlex
import subprocess

import pytest

from conftest import FOLDER, ROOT, path_of

BAKE = "import bpy; bpy.ops.vxs.bake()"


def documented():
    """The arguments of the command for build machines in docs/blender.md."""
    text = (ROOT / "docs" / "blender.md").read_text()
    (line,) = (line for line in text.splitlines() if line.startswith("    blender -b level.blend"))
    return shlex.split(line)[2:]  # without blender -b


@pytest.fixture(scope="module")
def installed(tmp_path_factory, vxs_path):
    """blender(*arguments): run Blender as a user has it who installed the add-on by make, with vxs on the PATH; and the folder of bin."""
    program, why = path_of("blender")
    if not program:
        pytest.skip(why)
    home = tmp_path_factory.mktemp("home")
    (home / "bin").mkdir()
    (home / "bin" / "vxs").symlink_to(vxs_path)
    environment = {**os.environ, "HOME": str(home), "XDG_CONFIG_HOME": str(home / ".config"), "TMPDIR": str(home),
                   "PATH": f"{home / 'bin'}:{os.environ['PATH']}"}
    for name in ("MAKEFLAGS", "MAKELEVEL", "MFLAGS"):
        environment.pop(name, None)
    done = subprocess.run(["make", "install-blender", "packages=skip", f"BLENDER={program}"], cwd=ROOT, env=environment,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr

    def blender(*arguments, folder=home, **more):
        return subprocess.run([program, "-b", *map(str, arguments)], cwd=folder, env={**environment, "PWD": str(folder), **more},
                              capture_output=True, text=True, timeout=120)

    return blender


@pytest.fixture
def level(installed, tmp_path):
    file = tmp_path / "level.blend"
    made = installed("--factory-startup", "--python-exit-code", 1, "--python-expr",
                     f"import bpy, sys; sys.path.insert(0, {str(FOLDER)!r}); import scenes; scenes.make('mirrored'); "
                     f"bpy.ops.wm.save_as_mainfile(filepath={str(file)!r})")
    assert made.returncode == 0, made.stdout + made.stderr
    return file


def test_a_build_machine_bakes_by_one_command(installed, level, vxs):
    done = installed(*documented(), folder=level.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    vxs("validate", level.with_suffix(".vxs"))


def test_a_build_machine_is_told_of_failures(installed, level, tmp_path):
    before = sorted(path.name for path in tmp_path.iterdir())
    done = installed(*documented(), folder=tmp_path, PATH="/nowhere")
    assert done.returncode == 1 and "vxs was not found" in done.stdout + done.stderr
    done = installed("--python-exit-code", 1, "--python-expr", BAKE)
    assert done.returncode == 1 and "never saved" in done.stdout + done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == before
