# The runtime compiles for Windows, where files and threads are others (runtime/platform_windows.h), and streams there.
# MINGW: the compiler (default x86_64-w64-mingw32-gcc, package gcc-mingw-w64-x86-64). Debian has no libzstd for it, so nothing is
# linked, but where VXS_MINGW_LIBS names a folder with a libzstd.a and a libxxhash.a of its making; then wine (package wine64) runs
# what is linked.
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
GL_SOURCES = sorted((ROOT / "runtime" / "gl").glob("*.c"))


@pytest.fixture(scope="module")
def headers(tmp_path_factory):
    """Of libraries that are alike everywhere, and nothing else of this system."""
    if not shutil.which(MINGW):
        pytest.skip(f"no {MINGW}: package gcc-mingw-w64-x86-64")
    folder = tmp_path_factory.mktemp("headers")
    for name in ("zstd.h", "xxhash.h"):
        shutil.copy(pathlib.Path("/usr/include") / name, folder)
    return folder


def compile_for_windows(headers, *arguments):
    done = subprocess.run([MINGW, "-std=c11", "-O1", "-Wall", "-Wextra", "-Wshadow", "-Werror", f"-I{ROOT}", f"-I{ROOT / 'formats'}",
                           f"-I{ROOT / 'runtime'}", f"-I{ROOT / 'runtime' / 'gl'}", f"-I{headers}", *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("source", SOURCES + GL_SOURCES, ids=lambda path: path.stem)
def test_the_runtime_compiles(headers, tmp_path, source):
    compile_for_windows(headers, "-c", source, "-o", tmp_path / "a.o")


@pytest.mark.slow
def test_the_example_flies(headers, vxs, tmp_path):
    """With threads; what is seen in the end is what the same program sees here."""
    wine = shutil.which("wine64") or shutil.which("wine64", path="/usr/lib/wine")
    if not wine or "VXS_MINGW_LIBS" not in os.environ:
        pytest.skip("no wine64" if not wine else "VXS_MINGW_LIBS names no folder with libzstd.a and libxxhash.a for Windows")
    libraries = [pathlib.Path(os.environ["VXS_MINGW_LIBS"]) / f"lib{name}.a" for name in ("zstd", "xxhash")]
    flight = ROOT / "docs" / "example" / "flight.c"
    compile_for_windows(headers, flight, *SOURCES, *libraries, "-o", tmp_path / "flight.exe")
    subprocess.run(["cc", "-O1", f"-I{ROOT / 'formats'}", f"-I{ROOT / 'runtime'}", flight, *SOURCES, "-lzstd", "-lxxhash", "-lm", "-pthread",
                    "-o", tmp_path / "flight"], check=True)
    vxs("scene", "city", "--triangles", 20000, "-o", tmp_path / "city.glb")
    vxs("bake", tmp_path / "city.glb", "-o", tmp_path / "city.vxs", "--resolution", 8192)
    said = []
    env = os.environ | {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    for prefix, program in (("w", [wine, "flight.exe"]), ("l", ["./flight"])):
        done = subprocess.run([*program, "city.vxs", "16", prefix], cwd=tmp_path, env=env, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        said.append(done.stdout.splitlines()[-1].replace("w31", "l31"))
    assert said[0] == said[1] and "l31.pgm" in said[0]
    assert (tmp_path / "w31.pgm").read_bytes() == (tmp_path / "l31.pgm").read_bytes()
