# The runtime compiles for Windows, where files and threads are others (runtime/platform_windows.h).
# MINGW: the compiler (default x86_64-w64-mingw32-gcc, package gcc-mingw-w64-x86-64). Debian has no libzstd for it, so nothing is linked.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import pathlib
import shutil
import subprocess

import pytest

from conftest import ROOT

MINGW = os.environ.get("MINGW", "x86_64-w64-mingw32-gcc")
FORMATS = ("vxs_read*.c", "vxs_page_decode.c", "vxs_page_check.c", "vxs_resident_check.c")
SOURCES = sorted([*(ROOT / "runtime").glob("*.c"), *(path for name in FORMATS for path in (ROOT / "formats").glob(name))])


@pytest.fixture(scope="module")
def headers(tmp_path_factory):
    """Of libraries that are alike everywhere, and nothing else of this system."""
    if not shutil.which(MINGW):
        pytest.skip(f"no {MINGW}: package gcc-mingw-w64-x86-64")
    folder = tmp_path_factory.mktemp("headers")
    for name in ("zstd.h", "xxhash.h"):
        shutil.copy(pathlib.Path("/usr/include") / name, folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)
def test_the_runtime_compiles(headers, tmp_path, source):
    done = subprocess.run([MINGW, "-std=c11", "-O1", "-Wall", "-Wextra", "-Wshadow", "-Werror", f"-I{ROOT}", f"-I{ROOT / 'formats'}",
                           f"-I{ROOT / 'runtime'}", f"-I{headers}", "-c", source, "-o", tmp_path / "a.o"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
