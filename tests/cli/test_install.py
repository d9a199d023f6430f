# What a game gets: `make install` puts all of it in place, a program builds against it with pkg-config alone, and `make uninstall`
# takes all of it away. And the runtime library stands on its own: nothing of the baker, no foreign or unprefixed symbol.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shutil
import subprocess

import pytest

from conftest import ROOT

GOLDEN = ROOT / "tests" / "golden" / "smallest.vxs"
SANITIZERS = {"asan": ["-fsanitize=address,undefined"], "tsan": ["-fsanitize=thread"]}
INSTALLED = {"bin/vxs", "lib/libvxs.a", "lib/pkgconfig/vxs.pc",
             *(f"include/vxs/{name}.h" for name in ("vxs", "vxs_file", "vxs_format", "vxs_result", "vxs_findings", "vxs_lookup",
                                             "vxs_space"))}

# The points of the file of vxs.md section 10: under its mask, beside it, behind it, outside.
C_USER = """
#include <stdio.h>
#include <vxs.h>

int main(int argc, char **argv)
{
    static const double points[4][3] = {{2.5, 4.5, 2.5}, {0.5, 4.5, 0.5}, {0.5, -5, 0.5}, {9, 4, 4}};
    vxs_asset          *asset;
    if (argc != 2 || vxs_asset_open_file(&asset, argv[1], NULL) != VXS_OK) return 1;
    for (int n = 0; n < 4; n++) printf("%g ", vxs_lookup(vxs_asset_light(asset, 0), points[n], NULL, 1));
    vxs_asset_close(asset);
    return 0;
}
"""

CXX_USER = """
#include <cstdio>
#include <vxs.h>
#include <vxs_lookup.h>
#include <vxs_space.h>

int main(int argc, char **argv)
{
    vxs_asset *asset = nullptr;
    if (argc != 2 || vxs_asset_open_file(&asset, argv[1], nullptr) != VXS_OK) return 1;
    const vxs_baked_light *sun  = vxs_asset_find_light(asset, "sun");
    const vxs_contents *contents = vxs_asset_contents(asset);
    std::printf("%u %u %u ", contents->version, vxs_shadow(sun->dag.words, 0, sun->light.levels, 2, 2, 3),
                vxs_shadow(sun->dag.words, 0, sun->light.levels, 2, 2, 2));
    const double point[3] = {2.5, 4.5, 2.5}, normal[3] = {0, 0, 0};
    if (vxs_lit(sun->dag.words, &sun->light, point, normal, 1) != vxs_lookup(sun, point, nullptr, 1)) return 2;
    vxs_asset_close(asset);
    /* the layer below, by its own header */
    vxs_contents none = {};
    std::printf("%s", vxs_read(&none, "", 0, nullptr) == VXS_E_TRUNCATED ? "ok" : "not refused");
    vxs_contents_free(&none);
    return 0;
}
"""


@pytest.fixture(scope="module")
def build(vxs_path):
    """The build tree of the command under test."""
    for tool in ("make", "pkg-config", "nm"):
        if not shutil.which(tool):
            pytest.skip(f"no {tool}")
    if not (vxs_path.parent / "libvxs.a").is_file():
        pytest.skip(f"no libvxs.a beside {vxs_path}")
    return vxs_path.parent


def config_of(build):
    return build.name if build.name in ("debug", "release", "asan", "tsan") else "release"


def make(build, *args):
    """make, on its own: what an outer make was told is not for this one."""
    env = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "DESTDIR")}
    done = subprocess.run(["make", f"B={build}", f"config={config_of(build)}", "packages=skip", *args], cwd=ROOT, env=env,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def files_under(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}


def pkg_config(root, env, *args):
    env = {"PATH": os.environ["PATH"], "PKG_CONFIG_PATH": str(root / "lib" / "pkgconfig"), **env}
    done = subprocess.run(["pkg-config", *args, "vxs"], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def build_and_run(folder, name, source, compiler, flags, extra):
    """Build away from the sources, so that only what was installed can be found."""
    (folder / name).write_text(source)
    done = subprocess.run([*compiler, "-Wall", "-Wextra", "-Werror", *extra, "-o", "user", name, *flags], cwd=folder,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return subprocess.run([folder / "user", GOLDEN], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("staged", [False, True], ids=["prefix", "destdir"])
def test_install_use_uninstall(build, tmp_path, staged):
    stage, user = tmp_path / "stage", tmp_path / "user"
    user.mkdir()
    prefix = "/opt/vxs" if staged else str(stage)
    root = stage / "opt" / "vxs" if staged else stage
    where = [f"prefix={prefix}", *([f"DESTDIR={stage}"] if staged else [])]
    make(build, "install", *where)
    assert files_under(root) == INSTALLED
    assert os.access(root / "bin" / "vxs", os.X_OK)
    assert "@" not in (root / "lib" / "pkgconfig" / "vxs.pc").read_text()

    env = {"PKG_CONFIG_SYSROOT_DIR": str(stage)} if staged else {}
    header = (ROOT / "runtime" / "vxs.h").read_text()
    version = [re.search(rf"VXS_VERSION_{part} (\d+)", header)[1] for part in ("MAJOR", "MINOR", "PATCH")]
    assert pkg_config(root, env, "--modversion") == [".".join(version)]
    flags = pkg_config(root, env, "--cflags", "--libs")
    extra = SANITIZERS.get(config_of(build), [])
    c, cxx = os.environ.get("CC", "cc").split(), os.environ.get("CXX", "c++").split()
    assert build_and_run(user, "user.c", C_USER, [*c, "-std=c99", "-pedantic"], flags, extra) == "0 1 0 -1 "
    assert build_and_run(user, "user.cpp", CXX_USER, [*cxx, "-std=c++11", "-pedantic"], flags, extra) == "1 1 0 ok"

    make(build, "uninstall", *where)
    make(build, "uninstall", *where)  # nothing is there any more: no error
    assert files_under(stage) == set()
    assert not (root / "include" / "vxs").exists()


def nm(library, *args):
    done = subprocess.run(["nm", "-P", *args, str(library)], capture_output=True, text=True, check=True)
    return {line.split()[0] for line in done.stdout.splitlines() if len(line.split()) > 1}


def test_library_symbols(build):
    defined = nm(build / "libvxs.a", "-g", "--defined-only")
    assert "vxs_lookup" in defined and "vxs_read" in defined
    foreign = {name for name in defined if not name.startswith("vxs_")}
    if config_of(build) in SANITIZERS:  # which mark each global
        foreign = {name for name in foreign if not re.match(r"__(odr_)?(asan|ubsan|tsan)", name)}
    assert foreign == set()
    missing = {name for name in nm(build / "libvxs.a", "-u") if name.startswith("vxs_")} - defined
    assert missing == set()


def test_library_needs_only_libc_libm_zstd_xxhash(build, tmp_path):
    """All of it, whether it is used or not, links with these alone."""
    (tmp_path / "main.c").write_text("int main(void) { return 0; }\n")
    done = subprocess.run([*os.environ.get("CC", "cc").split(), *SANITIZERS.get(config_of(build), []), "-o", "main", "main.c",
                           "-Wl,--whole-archive", build / "libvxs.a", "-Wl,--no-whole-archive", "-lzstd", "-lxxhash", "-lm"],
                          cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_formats_and_runtime_stay_apart_from_the_baker():
    for folder in ("formats", "runtime"):
        for path in (ROOT / folder).glob("*.[ch]"):
            text = path.read_text()
            assert not re.search(r'#include ["<](baker|tests)/', text), path
            assert "SPDX-License-Identifier: MIT" in text, path
