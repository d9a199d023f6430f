# The runtime as sources that a project compiles itself: two files (make amalgamation), and CMake. What comes out answers as vxs query does.
# Compilers that are not here are skipped: clang, gcc-multilib, gcc-mingw-w64-x86-64, wine64.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import random
import re
import shutil
import subprocess
import tarfile

import pytest

from conftest import EVERY, ROOT
from test_docs import listings

DECODER = ROOT / "build" / "amalgamation" / "zstddeclib.c"  # make amalgamation, where Debian's sources can be had
POINTS = "".join(f"{dice.uniform(-200, 200)} {dice.uniform(0, 40)} {dice.uniform(-200, 200)} 0 1 0\n" for dice in [random.Random(3)] for _ in range(2000))
STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]


@pytest.fixture(scope="module")
def program():
    """The guide's first program, which looks up points with a 9 x 9 filter."""
    return next(text for text in listings("c", ROOT / "docs" / "guide-shadows.md") if "int main" in text)


@pytest.fixture(scope="module")
def folder(vxs, program, tmp_path_factory):
    """vxs.h, vxs.c, a program of C and C++, a file to look up, and answers."""
    at = tmp_path_factory.mktemp("a program")
    sources = subprocess.run(["make", "-s", "-C", ROOT, "--no-print-directory", "packages=skip", "-f", "Makefile", "amalgamation"], capture_output=True, text=True)
    assert sources.returncode == 0, sources.stderr
    for name in ("vxs.h", "vxs.c"):
        shutil.copy(ROOT / "build" / "amalgamation" / name, at)
    if DECODER.exists():
        shutil.copy(DECODER, at)
    (at / "game.c").write_text(program)
    vxs("scene", "city", "--triangles", 4000, "-o", at / "city.glb")
    vxs("bake", at / "city.glb", "-o", at / "level.vxs", "--resolution", 1024)
    (at / "answers").write_text(vxs("query", at / "level.vxs", "--filter", 9, input=POINTS).stdout)
    return at


def build(folder, line):
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{line}: {done.stderr[-3000:]}"


def answers_alike(folder, program):
    done = subprocess.run([*program, "level.vxs"], cwd=folder, input=POINTS, capture_output=True, text=True, env=os.environ | {"WINEDEBUG": "-all"})
    wanted = ["1" if word == "out" else word for word in (folder / "answers").read_text().split()]
    assert done.returncode == 0 and len(wanted) == 2000 and [float(a) for a in done.stdout.split()] == pytest.approx([float(w) for w in wanted], abs=1e-6)
    assert 100 < sum(float(w) < 1 for w in wanted) < 1900


def decoder_or_system():
    return [] if DECODER.exists() else ["-DVXS_SYSTEM_ZSTD"]


def needs(*programs):
    for name in programs:
        if not shutil.which(name):
            pytest.skip(f"no {name}")


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.long)])
@pytest.mark.parametrize("macros", [[], pytest.param(["-DVXS_NO_STREAM"], marks=pytest.mark.long), pytest.param(["-DVXS_SYSTEM_ZSTD"], marks=pytest.mark.long),
                                    ["-DVXS_SYSTEM_ZSTD", "-DVXS_NO_STREAM"]], ids=" ".join)
def test_two_files(folder, tmp_path, compiler, macros):
    needs(compiler)
    if "-DVXS_SYSTEM_ZSTD" not in macros and not DECODER.exists():
        pytest.skip("no zstddeclib.c: make amalgamation")
    libraries = ["-lzstd"] if "-DVXS_SYSTEM_ZSTD" in macros else []
    threads = [] if "-DVXS_NO_STREAM" in macros else ["-pthread"]
    build(folder, [compiler, "-std=c11", *STRICT, *macros, "-c", "vxs.c", "-o", tmp_path / "vxs.o"])
    build(folder, [compiler, "-std=c99", *STRICT, "-I.", "game.c", tmp_path / "vxs.o", *libraries, *threads, "-lm", "-o", tmp_path / "game"])
    answers_alike(folder, [tmp_path / "game"])
    undefined = subprocess.run(["nm", "-u", tmp_path / "vxs.o"], capture_output=True, text=True).stdout
    assert ("pthread" in undefined) == bool(threads)


@pytest.mark.long
def test_from_cpp_and_with_sanitizers(folder, tmp_path):
    build(folder, ["gcc", "-std=c11", *STRICT, "-DVXS_SYSTEM_ZSTD", "-fsanitize=address,undefined", "-c", "vxs.c", "-o", tmp_path / "vxs.o"])
    shutil.copy(folder / "game.c", tmp_path / "game.cc")
    text = (tmp_path / "game.cc").read_text().replace("<vxs.h>", '"vxs.h"')
    (tmp_path / "game.cc").write_text(text)
    build(folder, ["g++", "-std=c++17", *STRICT, "-fsanitize=address,undefined", "-I.", tmp_path / "game.cc", tmp_path / "vxs.o", "-lzstd", "-pthread", "-o", tmp_path / "game"])
    answers_alike(folder, [tmp_path / "game"])


@pytest.mark.long
def test_with_32_bits(folder, tmp_path):
    if subprocess.run(["gcc", "-m32", "-x", "c", "-", "-o", tmp_path / "a"], input="int main(void) { return 0; }", text=True, capture_output=True).returncode:
        pytest.skip("no gcc-multilib")
    if not DECODER.exists():
        pytest.skip("no zstddeclib.c: make amalgamation")
    build(folder, ["gcc", "-m32", "-std=c11", "-msse2", "-mfpmath=sse", *STRICT, "-I.", "game.c", "vxs.c", "-lm", "-pthread", "-o", tmp_path / "game"])
    answers_alike(folder, [tmp_path / "game"])


@pytest.mark.long
def test_for_windows(folder, tmp_path):
    needs("x86_64-w64-mingw32-gcc")
    if not DECODER.exists():
        pytest.skip("no zstddeclib.c: make amalgamation")
    build(folder, ["x86_64-w64-mingw32-gcc", "-std=c11", *STRICT, "-D__USE_MINGW_ANSI_STDIO=1", "-I.", "game.c", "vxs.c", "-o", tmp_path / "game.exe"])
    wine = shutil.which("wine64") or shutil.which("wine64", path="/usr/lib/wine")
    if not wine:
        pytest.skip("compiled and linked, but there is no wine64 to run it")
    os.environ["WINEPREFIX"] = str(tmp_path / "wine")
    answers_alike(folder, [wine, tmp_path / "game.exe"])


# headers of the C library that MSVC has, as far as the runtime needs them; Debian has none
MSVC = {
    "stdlib.h": "#include <stddef.h>\nvoid *malloc(size_t), *calloc(size_t, size_t), *realloc(void *, size_t), free(void *), abort(void);\n"
                "void qsort(void *, size_t, size_t, int (*)(const void *, const void *));\nunsigned long _byteswap_ulong(unsigned long);\n"
                "unsigned long long _byteswap_uint64(unsigned long long);\n",
    "string.h": "#include <stddef.h>\nvoid *memcpy(void *, const void *, size_t), *memmove(void *, const void *, size_t), *memset(void *, int, size_t);\n"
                "int memcmp(const void *, const void *, size_t), strcmp(const char *, const char *);\nsize_t strlen(const char *);\n"
                "void *memchr(const void *, int, size_t);\n",
    "math.h": "double floor(double), ceil(double), sqrt(double), fabs(double), log(double), exp(double), ldexp(double, int), hypot(double, double);\n"
              "double fmin(double, double), fmax(double, double), copysign(double, double), nextafter(double, double), cos(double);\nlong lround(double);\n"
              "float floorf(float), sqrtf(float), fabsf(float), fminf(float, float), fmaxf(float, float);\n#define INFINITY ((float)(1e300 * 1e300))\n"
              "#define isfinite(x) ((x) - (x) == 0)\n#define isnan(x) ((x) != (x))\n#define isinf(x) (!isnan(x) && !isfinite(x))\n",
    "assert.h": "#define assert(x) ((void)0)\n", "errno.h": "", "malloc.h": "", "setjmp.h": "typedef int jmp_buf[16];\n",
}


def test_in_the_dialect_of_msvc(folder, tmp_path):
    """Checked, not linked: no MSVC, nor its headers, in Debian."""
    needs("clang")
    for name, text in MSVC.items():
        (tmp_path / name).write_text("#pragma once\n" + text)
    if decoder_or_system():
        shutil.copy("/usr/include/zstd.h", tmp_path)
        shutil.copy("/usr/include/xxhash.h", tmp_path)
    build(folder, ["clang", "--target=x86_64-pc-windows-msvc", "-fms-extensions", "-fms-compatibility", "-fms-compatibility-version=19.30", "-std=c11", "-Wall",
                   "-Wextra", "-Werror", "-DVXS_NO_STREAM", "-DVXS_NO_FILES", *decoder_or_system(), "-isystem", tmp_path, "-fsyntax-only", "vxs.c"])


# CMake ----------------------------------------------------------------------------------------------------------------------

USES = {
    "add_subdirectory": "add_subdirectory({source}/runtime vxs)",
    "FetchContent": "include(FetchContent)\nFetchContent_Declare(vxs URL {archive} SOURCE_SUBDIR runtime DOWNLOAD_EXTRACT_TIMESTAMP ON)\nFetchContent_MakeAvailable(vxs)",
    "find_package": "find_package(vxs {version} REQUIRED)",
}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """As make dist makes it, of the work tree."""
    at = tmp_path_factory.mktemp("dist")
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "runtime", "formats"], capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("no git repository")
    with tarfile.open(at / "vxs.tar.gz", "w:gz") as out:
        for name in listed.stdout.splitlines():
            out.add(ROOT / name, f"vxs/{name}")
    return at / "vxs.tar.gz"


def cmake_project(at, folder, use, *options):
    at.mkdir()
    shutil.copy(folder / "game.c", at)
    (at / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.16)\nproject(game C)\n{use}\nadd_executable(game game.c)\n"
                                       "target_link_libraries(game PRIVATE vxs::vxs)\n")
    build(at, ["cmake", "-S", ".", "-B", "made", *options])
    build(at, ["cmake", "--build", "made", "-j2"])


@pytest.mark.parametrize("options", [[], *(pytest.param([option], marks=pytest.mark.long) for option in ("-DVXS_STREAM=OFF", "-DBUILD_SHARED_LIBS=ON"))],
                         ids=" ".join)
def test_cmake(folder, archive, tmp_path, options):
    needs("cmake")
    version = ".".join(re.findall(r"^#define VXS_VERSION_M\w+ (\d+)", (ROOT / "runtime" / "vxs.h").read_text(), re.M))
    uses = {name: use.format(source=ROOT, archive=archive, version=version) for name, use in USES.items()}
    first = tmp_path / "add_subdirectory"
    cmake_project(first, folder, uses["add_subdirectory"], *options, f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'installed here'}", "-DCMAKE_INSTALL_LIBDIR=lib")
    build(first, ["cmake", "--install", "made"])
    cmake_project(tmp_path / "find_package", folder, uses["find_package"], f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed here'}")
    programs = ["add_subdirectory", "find_package"]
    if options and EVERY:
        cmake_project(tmp_path / "FetchContent", folder, uses["FetchContent"])
        programs.append("FetchContent")
    for name in programs:
        answers_alike(folder, [tmp_path / name / "made" / "game"])
