# What every command-line test needs beside the command itself (fixtures.py).
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import pathlib
import pty
import shutil
import signal

import pytest

from browser import Browser
from fixtures import ROOT, scenes, shared, vxs, vxs_path  # noqa: F401 (fixtures)

# a shell starts what runs in the background with SIGINT ignored, nohup SIGHUP; what we start would ignore them, too
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

EVERY = os.environ.get("VXS_TEST_REPEATS") == "all"  # make check-repeats

# files all of whose tests are left out by `make check-fast`; in other files, tests are marked one by one
SLOW = {f"test_{name}.py" for name in ("bench", "compare", "compare_faults", "encodings", "gpu", "health", "measurements", "punctual", "report",
                                       "report_bake", "report_volumes", "rivals", "stress", "threads", "vulkan", "wgsl")}


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: left out by make check-fast")
    config.addinivalue_line("markers", "long: run by make check-repeats alone, where a quicker test of the same feature is run always")


def pytest_collection_modifyitems(config, items):
    """test_exact.py comes last: it is the longest by far, and its tests, which share nothing, fill all processors to the end."""
    left_out = [] if EVERY else [item for item in items if item.get_closest_marker("long")]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
    items.sort(key=lambda item: item.path.name == "test_exact.py")
    for item in items:
        if item.path.name in SLOW:
            item.add_marker(pytest.mark.slow)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            """What one worker runs: a file, because its tests share what they make; of test_exact.py, each test for itself."""
            file = nodeid.split("::")[0]
            return nodeid if file.endswith("test_exact.py") else file

    return Scheduling(config, log)



@pytest.fixture(scope="session")
def browser():
    """One for all pages."""
    if not shutil.which("chromium"):
        pytest.skip("no browser: package chromium")
    started = Browser()
    yield started
    started.close()


@pytest.fixture(scope="session")
def cases():
    """Inputs on which vxs was wrong."""
    return shared("cases")


def open_terminal():
    """Both sides of a terminal, as file descriptors."""
    try:
        return pty.openpty()
    except OSError as error:
        pytest.skip(f"no terminal can be had here: {error}")


def writes_into(process, folder):
    """Whether a process has a new file open in a folder: one without a name, which the system shows as deleted, or a temporary one."""
    for descriptor in pathlib.Path(f"/proc/{process.pid}/fd").iterdir():
        try:
            target = os.readlink(descriptor)
        except FileNotFoundError:  # closed meanwhile
            continue
        if target.startswith(f"{folder}/") and target.endswith((" (deleted)", ".tmp")):
            return True
    return False
