# What tests of all folders need: the command, and the shared scenes.
# VXS: the binary (default build/release/vxs).  VXS_SCENES: the shared scenes (default ../shared/scenes beside the checkout).
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def vxs_path():
    """The binary as an absolute path, for tests that start it themselves."""
    path = (ROOT / os.environ.get("VXS", "build/release/vxs")).resolve()
    if not path.is_file():
        pytest.skip(f"no command at {path}: build it, or set VXS")
    return path


@pytest.fixture(scope="session")
def vxs(vxs_path):
    """run(*args, input=None, status=0): run the command, check its exit status, return it with text stdout and stderr."""

    def run(*args, input=None, status=0):
        done = subprocess.run([vxs_path, *map(str, args)], input=input, capture_output=True, text=True, timeout=600)
        assert done.returncode == status, f"exit status {done.returncode}, expected {status}: {done.stderr}"
        return done

    return run


def shared(name):
    """A folder of the shared ones: VXS_SCENES or VXS_CASES, or ../shared/NAME beside the checkout."""
    variable = f"VXS_{name.upper()}"
    path = pathlib.Path(os.environ.get(variable, ROOT.parent / "shared" / name))
    if not path.is_dir():
        pytest.skip(f"no shared {name} at {path}: set {variable}")
    return path


@pytest.fixture(scope="session")
def scenes():
    return shared("scenes")
