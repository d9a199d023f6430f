# What a game gets: `make install` puts all of it in place, a program builds against it with pkg-config alone, and `make uninstall`
# takes all of it away. And the runtime library stands on its own: nothing of the baker, no foreign or unprefixed symbol.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shlex
import shutil
import subprocess

import pytest

import small_scene
from commands import COMMANDS
from conftest import ROOT

GOLDEN = ROOT / "tests" / "golden" / "smallest.vxs"
SANITIZERS = {"asan": ["-fsanitize=address,undefined"], "tsan": ["-fsanitize=thread"]}
HEADER = (ROOT / "runtime" / "vxs.h").read_text()
VERSION = ".".join(re.search(rf"VXS_VERSION_{part} (\d+)", HEADER)[1] for part in ("MAJOR", "MINOR", "PATCH"))
MAJOR = VERSION.split(".")[0]
DOCUMENTS = ["README.md", "LICENSE", "LICENSE.MIT", "LICENSE.GPL-3.0", "formats/vxs.md", "scenes/README.md",
             *(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*") if path.is_file())]
INSTALLED = {"bin/vxs", "lib/libvxs.a", "lib/libvxs.so", f"lib/libvxs.so.{MAJOR}", f"lib/libvxs.so.{VERSION}", "lib/pkgconfig/vxs.pc",
             "lib/cmake/vxs/vxsConfig.cmake", "lib/cmake/vxs/vxsConfigVersion.cmake",
             "lib/libvxs_gl.a", "lib/libvxs_gl.so", f"lib/libvxs_gl.so.{MAJOR}", f"lib/libvxs_gl.so.{VERSION}", "lib/pkgconfig/vxs_gl.pc",
             "lib/libvxs_volumes.a", "lib/libvxs_volumes.so", f"lib/libvxs_volumes.so.{MAJOR}", f"lib/libvxs_volumes.so.{VERSION}",
             "lib/pkgconfig/vxs_volumes.pc", *(f"include/vxs/{path.name}" for path in (ROOT / "runtime/volumes").glob("vxs_*.h")),
             "lib/libvxs_bake.a", "lib/libvxs_bake.so", f"lib/libvxs_bake.so.{MAJOR}", f"lib/libvxs_bake.so.{VERSION}", "lib/pkgconfig/vxs_bake.pc",
             "include/vxs/vxs.hpp", *(f"include/vxs/{name}.h" for name in ("vxs", "vxs_query", "vxs_stream", "vxs_bake", "vxs_file", "vxs_format", "vxs_result", "vxs_findings", "vxs_lookup",
                                             "vxs_lookup_blocks", "vxs_space", "vxs_smoke", "vxs_depths", "vxs_intervals", "vxs_gl", "vxs_gl_depths", "vxs_cull")),
             "share/man/man1/vxs.1", *(f"share/man/man1/vxs-{command}.1" for command in COMMANDS),
             "share/bash-completion/completions/vxs", "share/zsh/site-functions/_vxs", "share/fish/vendor_completions.d/vxs.fish",
             *(["share/vxs/view.html"] if (ROOT / "build/web/view.html").is_file() else []),  # of make web
             *(f"share/doc/vxs/{name}" for name in DOCUMENTS)}

# The points of the file of vxs.md section 10: under its mask, beside it, behind it, outside.
C_USER = """
#include <stdio.h>
#include <vxs.h>

int main(int argc, char **argv)
{
    static const double points[4][3] = {{2.5, 4.5, 2.5}, {0.5, 4.5, 0.5}, {0.5, -5, 0.5}, {9, 4, 4}};
    vxs_asset          *asset;
    if (argc != 2 || vxs_asset_open_file(&asset, argv[1], NULL) != VXS_OK) return 1;
    for (int n = 0; n < 4; n++) printf("%g ", vxs_lookup(vxs_asset_light(asset, 0), points[n], NULL, vxs_box(1)));
    vxs_asset_close(asset);
    return 0;
}
"""

GL_USER = """
#include <stdio.h>
#include <string.h>
#include <vxs_gl.h>

static vxs_gl_function none(const char *name, void *user)
{
    (void)name;
    (void)user;
    return NULL;
}

int main(int argc, char **argv)
{
    vxs_gl_desc desc;
    vxs_asset  *asset;
    vxs_gl     *gl;
    memset(&desc, 0, sizeof desc);
    if (argc != 2 || vxs_asset_open_file(&asset, argv[1], NULL) != VXS_OK) return 1;
    desc.get_proc_address = none;
    desc.asset            = asset;
    puts(vxs_gl_create(&gl, &desc) == VXS_E_GL && !gl ? "no OpenGL" : "OpenGL");
    vxs_gl_destroy(gl);
    vxs_asset_close(asset);
    return 0;
}
"""

CXX_USER = """
#include <cstdio>
#include <utility>
#include <vxs.hpp>
#include <vxs_lookup.h>
#include <vxs_space.h>

int main(int argc, char **argv)
{
    vxs::asset opened, asset;
    if (argc != 2 || vxs::open(opened, argv[1]) != VXS_OK) return 1;
    asset = std::move(opened);
    if (vxs::open(opened, "no such file") != VXS_E_NO_FILE || vxs::open_bytes(opened, "", 0) != VXS_E_TRUNCATED || opened) return 1;
    const vxs_baked_light *sun  = vxs_asset_find_light(asset.get(), "sun");
    const vxs_contents *contents = vxs_asset_contents(asset.get());
    std::printf("%u %u %u ", contents->version, vxs_shadow(sun->words, 0, sun->light.levels, 2, 2, 3),
                vxs_shadow(sun->words, 0, sun->light.levels, 2, 2, 2));
    const double point[3] = {2.5, 4.5, 2.5}, normal[3] = {0, 0, 0};
    if (vxs_lit(sun->words, &sun->light, point, normal, vxs_box(1)) != vxs_lookup(sun, point, nullptr, vxs_box(1))) return 2;
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


def tree_under(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def files_under(folder):
    return {name for name in tree_under(folder) if (folder / name).is_symlink() or not (folder / name).is_dir()}


def pkg_config(folder, env, *args, package="vxs"):
    env = {"PATH": os.environ["PATH"], "PKG_CONFIG_PATH": str(folder), **env}
    done = subprocess.run(["pkg-config", *args, package], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return shlex.split(done.stdout)


def sysroot(folder, root):
    """For pkg-config; by a name without a blank, which it does not escape where it puts it before paths of other packages."""
    (folder / "sysroot").symlink_to(root)
    return {"PKG_CONFIG_SYSROOT_DIR": str(folder / "sysroot")}


def run_user(program, libdir=None):
    env = os.environ | ({"LD_LIBRARY_PATH": str(libdir)} if libdir else {})
    return subprocess.run([program, GOLDEN], env=env, capture_output=True, text=True, check=True).stdout


def build_and_run(folder, name, source, compiler, flags, extra, libdir):
    """Build away from the sources, so that only what was installed can be found."""
    (folder / name).write_text(source)
    done = subprocess.run([*compiler, "-Wall", "-Wextra", "-Werror", *extra, "-o", "user", name, *flags], cwd=folder,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return run_user(folder / "user", libdir)


C_COMPILER = [*os.environ.get("CC", "cc").split(), "-std=c99", "-pedantic"]
CXX_COMPILER = [*os.environ.get("CXX", "c++").split(), "-std=c++11", "-pedantic", "-Wold-style-cast"]
C_SAYS, CXX_SAYS, GL_SAYS = "0 1 0 -1 ", "1 1 0 ok", "no OpenGL\n"

CMAKE_USER = """
cmake_minimum_required(VERSION 3.16)
project(user C CXX)
foreach(version 1 0.99)
  find_package(vxs ${version} QUIET)
  if(vxs_FOUND)
    message(FATAL_ERROR "version ${version} was found")
  endif()
endforeach()
find_package(vxs @VERSION@ EXACT REQUIRED)
find_package(vxs REQUIRED)
add_executable(c_vxs user.c)
add_executable(c_static user.c)
add_executable(cxx_shared user.cpp)
add_executable(cxx_static user.cpp)
target_link_libraries(c_vxs PRIVATE vxs::vxs)
target_link_libraries(c_static PRIVATE vxs::static)
target_link_libraries(cxx_shared PRIVATE vxs::shared)
target_link_libraries(cxx_static PRIVATE vxs::static)
add_executable(gl_vxs gl.c)
add_executable(gl_static gl.c)
target_link_libraries(gl_vxs PRIVATE vxs::gl)
target_link_libraries(gl_static PRIVATE vxs::gl_static)
"""


def needed(path):
    """The shared libraries that a program or library names."""
    done = subprocess.run(["readelf", "-d", path], capture_output=True, text=True, check=True)
    return re.findall(r"\(NEEDED\).*\[(.*)\]", done.stdout)


def use_with_cmake(folder, prefix, build, *args):
    if not shutil.which("cmake"):
        pytest.skip("no cmake: package cmake")
    folder.mkdir()
    (folder / "user.c").write_text(C_USER)
    (folder / "user.cpp").write_text(CXX_USER)
    (folder / "gl.c").write_text(GL_USER)
    (folder / "CMakeLists.txt").write_text(CMAKE_USER.replace("@VERSION@", VERSION))
    flags = " ".join(SANITIZERS.get(config_of(build), []))
    for line in (["cmake", "-S", ".", "-B", "made", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_C_FLAGS={flags}", f"-DCMAKE_CXX_FLAGS={flags}", *args],
                 ["cmake", "--build", "made"]):
        done = subprocess.run(line, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    for program, says in (("c_vxs", C_SAYS), ("c_static", C_SAYS), ("cxx_shared", CXX_SAYS), ("cxx_static", CXX_SAYS),
                          ("gl_vxs", GL_SAYS), ("gl_static", GL_SAYS)):
        assert run_user(folder / "made" / program) == says
        assert (f"libvxs.so.{MAJOR}" in needed(folder / "made" / program)) == (not program.endswith("static"))


@pytest.mark.parametrize("staged", [False, True], ids=["prefix", "destdir"])
def test_install_use_uninstall(build, tmp_path, staged):
    stage, user = tmp_path / "my sta&ge", tmp_path / "user"
    user.mkdir()
    prefix = "/opt/my vxs" if staged else str(stage)
    root = stage / "opt" / "my vxs" if staged else stage
    where = [f"prefix={prefix}", *([f"DESTDIR={stage}"] if staged else [])]
    # others have been here before
    others = {"bin/other", "include/other.h", "lib/cmake/other/x", "lib/pkgconfig/other.pc", "share/man/man1/other.1", "share/doc/other/x",
              "share/bash-completion/completions/other", "share/zsh/site-functions/_other", "share/fish/vendor_completions.d/other.fish"}
    for name in others:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).touch()
    before = tree_under(stage)

    make(build, "install", *where)
    make(build, "install", *where)  # over what is there
    assert files_under(root) == INSTALLED | others
    assert os.access(root / "bin" / "vxs", os.X_OK) and not os.access(root / "lib" / f"libvxs.so.{VERSION}", os.X_OK)
    for name in ("pkgconfig/vxs.pc", "pkgconfig/vxs_gl.pc", "pkgconfig/vxs_volumes.pc", "pkgconfig/vxs_bake.pc", "cmake/vxs/vxsConfig.cmake", "cmake/vxs/vxsConfigVersion.cmake"):
        assert "@" not in (root / "lib" / name).read_text()
    assert re.match(r'\.TH VXS-BAKE 1 "\d{4}-\d\d-\d\d" ', (root / "share/man/man1/vxs-bake.1").read_text())

    env, libdir = (sysroot(tmp_path, stage) if staged else {}), root / "lib"
    assert pkg_config(libdir / "pkgconfig", env, "--modversion") == [VERSION]
    flags = pkg_config(libdir / "pkgconfig", env, "--cflags", "--libs")
    assert "-lzstd" not in flags
    extra = SANITIZERS.get(config_of(build), [])
    assert build_and_run(user, "user.c", C_USER, C_COMPILER, flags, extra, libdir) == C_SAYS
    assert f"libvxs.so.{MAJOR}" in needed(user / "user") and "libzstd.so.1" not in needed(user / "user")
    assert build_and_run(user, "user.cpp", CXX_USER, CXX_COMPILER, flags, extra, libdir) == CXX_SAYS
    for language, name, compiler in (("C", "gl.c", C_COMPILER), ("C++", "gl.cpp", CXX_COMPILER)):
        flags = pkg_config(libdir / "pkgconfig", env, "--cflags", "--libs", package="vxs_gl")
        assert build_and_run(user, name, GL_USER, compiler, flags, extra, libdir) == GL_SAYS, language
    if not extra:  # sanitizers have no static programs
        flags = ["-static", *pkg_config(libdir / "pkgconfig", env, "--static", "--cflags", "--libs")]
        assert build_and_run(user, "user.c", C_USER, C_COMPILER, flags, [], None) == C_SAYS and needed(user / "user") == []
        assert build_and_run(user, "user.cpp", CXX_USER, CXX_COMPILER, flags, [], None) == CXX_SAYS
        flags = ["-static", *pkg_config(libdir / "pkgconfig", env, "--static", "--cflags", "--libs", package="vxs_gl")]
        assert build_and_run(user, "gl.c", GL_USER, C_COMPILER, flags, [], None) == GL_SAYS and needed(user / "user") == []

    make(build, "uninstall", *where)
    make(build, "uninstall", *where)  # nothing is there any more: no error
    assert tree_under(stage) == before


@pytest.mark.slow
def test_use_with_cmake(build, tmp_path):
    make(build, "install", f"prefix={tmp_path / 'my prefix'}")
    use_with_cmake(tmp_path / "a user", tmp_path / "my prefix", build)
    for line in (["cmake", "-DVXS_STATIC=ON", "made"], ["cmake", "--build", "made", "--target", "c_vxs"]):
        subprocess.run(line, cwd=tmp_path / "a user", capture_output=True, check=True)
    assert f"libvxs.so.{MAJOR}" not in needed(tmp_path / "a user" / "made" / "c_vxs")


def test_uninstall_leaves_no_file(build, tmp_path):
    make(build, "install", f"DESTDIR={tmp_path}")
    assert files_under(tmp_path / "usr" / "local") == INSTALLED
    make(build, "uninstall", f"DESTDIR={tmp_path}")
    assert files_under(tmp_path) == set() and not [name for name in tree_under(tmp_path) if "vxs" in name]


def nm(library, *args):
    done = subprocess.run(["nm", "-P", *args, str(library)], capture_output=True, text=True, check=True)
    return {line.split()[0] for line in done.stdout.splitlines() if len(line.split()) > 1}


@pytest.mark.parametrize("library, some", [("libvxs.a", {"vxs_lookup", "vxs_read"}), ("libvxs_gl.a", {"vxs_gl_create", "vxs_cull"}),
                                           ("libvxs_volumes.a", {"vxs_volumes_create", "vxs_shadow_depth_map_fill"})])
def test_library_symbols(build, library, some):
    defined = nm(build / library, "-g", "--defined-only")
    assert some <= defined
    foreign = {name for name in defined if not name.startswith("vxs_")}
    if config_of(build) in SANITIZERS:  # which mark each global
        foreign = {name for name in foreign if not re.match(r"__(odr_)?(asan|ubsan|tsan)", name)}
    assert foreign == set()
    missing = {name for name in nm(build / library, "-u") if name.startswith("vxs_")} - defined
    others = set().union(*(nm(build / other, "-g", "--defined-only") for other in ("libvxs.a", "libvxs_gl.a") if other <= library))
    assert missing <= others - defined
    assert not {name for name in nm(build / library, "-u") if name.startswith(("gl", "egl", "OSMesa"))}


@pytest.mark.parametrize("library, headers, libraries", [
    ("libvxs", ["runtime/vxs.h", "runtime/vxs_query.h", "runtime/vxs_stream.h", "formats/vxs_file.h"], {"libzstd.so.1", "libxxhash.so.0"}),
    ("libvxs_gl", ["runtime/gl/vxs_gl.h", "runtime/gl/vxs_gl_depths.h"], {f"libvxs.so.{MAJOR}"}),
    ("libvxs_volumes", [f"runtime/volumes/vxs_{name}.h" for name in ("volumes", "transmittance", "area_light")],
     {f"libvxs.so.{MAJOR}", f"libvxs_gl.so.{MAJOR}"})], ids=["libvxs", "libvxs_gl", "libvxs_volumes"])
def test_shared_library_has_what_headers_declare(build, tmp_path, library, headers, libraries):
    shared = build / f"{library}.so"
    exported = subprocess.run(["nm", "-D", "--defined-only", "--with-symbol-versions", shared], capture_output=True, text=True, check=True)
    names = dict(line.split()[2].split("@@") for line in exported.stdout.splitlines() if line.split()[1] != "A")
    text = "".join((ROOT / header).read_text() for header in headers)
    declared = set(re.findall(r"^(?!typedef|static)\w[^;(\n]*?\b(vxs_\w+)\(", text, re.MULTILINE))
    assert len(names) > 10 and set(names) == declared & nm(build / f"{library}.a", "-g", "--defined-only")
    assert set(names.values()) == {f"{library[3:].upper()}_{MAJOR}"}
    dynamic = subprocess.run(["readelf", "-d", shared], capture_output=True, text=True, check=True).stdout
    assert f"soname: [{library}.so.{MAJOR}]" in dynamic
    if config_of(build) not in SANITIZERS:
        assert set(needed(shared)) <= {"libc.so.6", "libm.so.6"} | libraries
        for other in ("libvxs", "libvxs_gl"):
            (tmp_path / f"{other}.so.{MAJOR}").symlink_to(build / f"{other}.so")
        loose = subprocess.run(["ldd", "-r", shared], env=os.environ | {"LD_LIBRARY_PATH": str(tmp_path)}, capture_output=True, text=True,
                               check=True)
        assert "undefined symbol" not in loose.stdout + loose.stderr


def test_library_needs_only_libc_libm_zstd_xxhash(build, tmp_path):
    """All of it, whether it is used or not, links with these alone."""
    (tmp_path / "main.c").write_text("int main(void) { return 0; }\n")
    done = subprocess.run([*os.environ.get("CC", "cc").split(), *SANITIZERS.get(config_of(build), []), "-o", "main", "main.c",
                           "-Wl,--whole-archive", build / "libvxs.a", "-Wl,--no-whole-archive", "-lzstd", "-lxxhash", "-lm"],
                          cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_installed_headers_are_public_or_internal():
    names = {name.split("/")[-1] for name in INSTALLED if name.startswith("include/vxs/")}
    paths = [path for folder in ("formats", "runtime", "baker") for path in (ROOT / folder).rglob("vxs*.h*") if path.name in names]
    assert {path.name for path in paths} == names
    for path in paths:
        comment = path.read_text().split("*/")[0]
        assert re.search(r"^ \* (Public|Internal)[.:]", comment, re.MULTILINE), path
    assert "vxs_write_file.h" not in names  # games only read


def test_formats_and_runtime_stay_apart_from_the_baker():
    for folder in ("formats", "runtime"):
        for path in (ROOT / folder).rglob("*.[ch]"):
            text = path.read_text()
            assert not re.search(r'#include ["<](baker|tests)/', text), path
            assert "SPDX-License-Identifier: MIT" in text, path


# --- Debian packages --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def packages(build, tmp_path_factory):
    """What `make deb` makes: {name: path}."""
    if config_of(build) in SANITIZERS:
        pytest.skip("packages are not made with sanitizers")
    if not shutil.which("dpkg-shlibdeps"):
        pytest.skip("no dpkg-shlibdeps: package dpkg-dev")
    # nothing here tests how small they are, and xz takes most of the time
    shown = make(build, "deb", "DEBFULLNAME=A Maintainer", "DEBEMAIL=a@vxs.test", "DPKG_DEB_COMPRESSOR_LEVEL=0")
    assert "warning" not in shown
    return {path.name.split("_")[0]: path for path in (build / "deb").glob("*.deb")}


def fields(package):
    done = subprocess.run(["dpkg-deb", "--field", package], capture_output=True, text=True, check=True)
    return dict(re.findall(r"^([\w-]+): (.*)$", done.stdout, re.MULTILINE))


@pytest.fixture(scope="module")
def unpacked(packages, tmp_path_factory):
    root = tmp_path_factory.mktemp("unpacked here")
    for path in packages.values():
        subprocess.run(["dpkg-deb", "--extract", path, root], check=True)
    return root


@pytest.mark.slow
def test_packages_say_what_they_need(build, packages, unpacked):
    assert set(packages) == {"vxs", f"libvxs{MAJOR}", "libvxs-dev", f"libvxs-bake{MAJOR}", "libvxs-bake-dev"}
    told = {name: fields(path) for name, path in packages.items()}
    for name, control in told.items():
        assert control["Package"] == name and control["Version"] == VERSION and control["Maintainer"] == "A Maintainer <a@vxs.test>"
    for name, path in (("vxs", unpacked / "usr/bin/vxs"), (f"libvxs{MAJOR}", next(unpacked.glob(f"usr/lib/*/libvxs.so.{VERSION}"))),
                       (f"libvxs-bake{MAJOR}", next(unpacked.glob(f"usr/lib/*/libvxs_bake.so.{VERSION}")))):
        depends = {one.split()[0] for one in told[name]["Depends"].split(", ")}
        where = dict(re.findall(r"(\S+) => (\S+)", subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout))
        found = {library: os.path.basename(os.path.realpath(where[library])) for library in needed(path) if library in where}
        owners = subprocess.run(["dpkg", "-S", *(f"*/{file}" for file in found.values())], capture_output=True, text=True, check=True).stdout
        for library, file in found.items():
            assert depends & set(re.findall(rf"^([^:]+):.*/{re.escape(file)}$", owners, re.MULTILINE)), library
    assert "libosmesa6" in told["vxs"]["Depends"]  # which is opened when something is drawn
    assert f"libvxs{MAJOR} (= {VERSION})" in told["libvxs-dev"]["Depends"]
    assert f"libvxs-bake{MAJOR} (= {VERSION})" in told["libvxs-bake-dev"]["Depends"]


@pytest.mark.slow
def test_packages_hold_what_is_installed(packages, unpacked):
    multiarch = next(unpacked.glob("usr/lib/*/libvxs.a")).parent.name
    here = {name.replace(f"usr/lib/{multiarch}/", "lib/").replace("usr/", "", 1).replace(".1.gz", ".1")
            .replace("zsh/vendor-completions", "zsh/site-functions") for name in files_under(unpacked)}
    of_debian = {f"share/doc/{name}/{file}" for name in packages for file in ("copyright", "changelog.gz")}
    assert here == {name for name in INSTALLED if "/LICENSE" not in name} | of_debian
    for name in packages:
        said = (unpacked / "usr/share/doc" / name / "copyright").read_text()
        assert "License: GPL-3.0-or-later" in said and "License: MIT" in said and "Permission is hereby granted" in said
    for path in packages.values():
        listed = subprocess.run(["dpkg-deb", "--contents", path], capture_output=True, text=True, check=True).stdout
        assert {line.split()[1] for line in listed.splitlines()} == {"root/root"}


@pytest.mark.slow
def test_packages_are_hardened(packages, unpacked):
    """As Debian's are: stacks are guarded, calls of the C library know how much room there is, and no address of a function can be written over."""
    files = [unpacked / "usr/bin/vxs", *unpacked.glob(f"usr/lib/*/libvxs*.so.{VERSION}")]
    assert len(files) == 5
    for path in files:
        segments, dynamic = (subprocess.run(["readelf", "-W", flag, path], capture_output=True, text=True, check=True).stdout for flag in ("-l", "-d"))
        imported = nm(path, "-D", "-u")
        assert "GNU_RELRO" in segments and re.search(r"FLAGS.*BIND_NOW", dynamic), path
        assert re.search(r"GNU_STACK.* RW ", segments), path
        assert "__stack_chk_fail" in {name.split("@")[0] for name in imported}, path
        if path.name != f"libvxs.so.{VERSION}":  # which prints nothing, and copies only what the compiler can see to fit
            assert any(re.match(r"__\w+_chk(@|$)", name) for name in imported), path
    assert "DYN (Position-Independent" in subprocess.run(["readelf", "-h", files[0]], capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_packages_work(build, unpacked, tmp_path):
    """The command bakes, and a program is built and run with the library, each as it was unpacked."""
    small_scene.write(tmp_path / "scene.gltf")
    command = unpacked / "usr/bin/vxs"
    subprocess.run([command, "bake", tmp_path / "scene.gltf", "-o", tmp_path / "a.vxs", "--resolution", "64"], check=True, capture_output=True)
    assert "valid" in subprocess.run([command, "validate", tmp_path / "a.vxs"], check=True, capture_output=True, text=True).stdout
    libdir = next(unpacked.glob("usr/lib/*/libvxs.a")).parent
    flags = pkg_config(libdir / "pkgconfig", sysroot(tmp_path, unpacked), "--cflags", "--libs")
    assert build_and_run(tmp_path, "user.c", C_USER, C_COMPILER, flags, [], libdir) == C_SAYS
    use_with_cmake(tmp_path / "cmake", unpacked / "usr", build, f"-DCMAKE_LIBRARY_ARCHITECTURE={libdir.name}")
