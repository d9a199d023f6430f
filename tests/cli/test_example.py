# The examples of docs/example, built against an installed libvxs by pkg-config and by CMake, fly over a city that streams.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shutil
import subprocess

import pytest

import small_scene
from conftest import ROOT
from test_install import build, make, pkg_config  # noqa: F401 (build is a fixture)

EXAMPLES = ROOT / "docs" / "example"
COMPILERS = {"flight.c": ["cc", "-std=c99"], "lit_ground.cpp": ["c++", "-std=c++11", "-Wold-style-cast"]}
WARNINGS = ["-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror"]

CMAKE = """
cmake_minimum_required(VERSION 3.16)
project(examples C CXX)
find_package(vxs REQUIRED)
add_executable(flight @FOLDER@/flight.c)
add_executable(lit_ground @FOLDER@/lit_ground.cpp)
target_link_libraries(flight PRIVATE vxs::vxs)
target_link_libraries(lit_ground PRIVATE vxs::static)
"""


@pytest.fixture(scope="module")
def installed(build, tmp_path_factory):  # noqa: F811
    if build.name in ("asan", "tsan"):
        pytest.skip("programs of others have no sanitizers")
    prefix = tmp_path_factory.mktemp("prefix")
    make(build, "install", f"prefix={prefix}")
    return prefix


@pytest.fixture(scope="module")
def level(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("level")
    vxs("scene", "city", "--triangles", 20000, "-o", folder / "city.glb")
    vxs("bake", folder / "city.glb", "-o", folder / "city.vxs", "--resolution", 16384)
    return folder / "city.vxs"


@pytest.fixture(scope="module")
def programs(installed, tmp_path_factory):
    """By pkg-config: {name: path}."""
    folder, made = tmp_path_factory.mktemp("programs"), {}
    flags = pkg_config(installed / "lib" / "pkgconfig", {}, "--cflags", "--libs")
    for name, compiler in COMPILERS.items():
        made[name] = folder / name.split(".")[0]
        done = subprocess.run([*compiler, *WARNINGS, EXAMPLES / name, *flags, "-o", made[name]], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    return made


def run(program, installed, *args, folder=None, status=0):
    kept = {name: os.environ[name] for name in ("HOME", "MESA_SHADER_CACHE_DIR") if name in os.environ}
    done = subprocess.run([program, *map(str, args)], cwd=folder, env={"LD_LIBRARY_PATH": str(installed / "lib"), **kept},
                          capture_output=True, text=True, timeout=120)
    assert done.returncode == status, done.stderr
    return done


def test_examples_are_short():
    assert {path.name for path in EXAMPLES.iterdir()} == {*COMPILERS, "frame.c", "frame_scene.h", "gl_picture.h", "vulkan.c", "vulkan.comp", "vulkan_compute.h"}
    assert all(len(path.read_text().splitlines()) <= 80 for path in EXAMPLES.iterdir() if path.suffix != ".h")


def test_a_flight(programs, installed, level, tmp_path):
    said = run(programs["flight.c"], installed, level, 16, "frame", folder=tmp_path).stdout.splitlines()
    here = [re.fullmatch(r"frame\d\d\.pgm: (\d+) of (\d+) pages wanted are here, [\d.]+ MiB read", line) for line in said]
    assert len(here) == 32 and all(here) and int(here[0][1]) == 0 < int(here[0][2])
    assert int(here[-1][1]) > 0  # they came
    pictures = sorted(tmp_path.glob("frame*.pgm"))
    assert len(pictures) == 32
    for picture in (pictures[0], pictures[16]):
        head, pixels = picture.read_bytes().split(b"255\n", 1)
        assert head == b"P5 320 180 " and len(pixels) == 320 * 180 and {55, 255} <= set(pixels)


def test_lit_ground(programs, installed, level, vxs):
    """What is said of complete squares is what vxs query says."""
    said = run(programs["lit_ground.cpp"], installed, level, 16).stdout.splitlines()
    found = [re.fullmatch(r"x = +(-?\d+) m:  sun ([\d.]+) % lit(, in part.*)?", line) for line in said]
    assert len(found) == 9 and all(found)
    assert not any(line[3] for line in found)  # 16 MiB are enough for all that is near
    points = [(12 * step + (n % 16 - 7.5) / 2, 0.05, (n // 16 - 7.5) / 2) for step in range(-4, 5) for n in range(256)]
    text = "".join(f"{x!r} {y!r} {z!r} 0 1 0\n" for x, y, z in points)
    lit = [float(line) if line != "out" else 0 for line in vxs("query", level, "--smooth", 4, input=text).stdout.split()]
    for step, line in enumerate(found):
        assert abs(sum(lit[256 * step:256 * (step + 1)]) / 2.56 - float(line[2])) < 0.051


@pytest.mark.parametrize("name", COMPILERS)
def test_what_goes_wrong_is_said(programs, installed, level, tmp_path, name):
    rest = ["frame"] if name == "flight.c" else []
    (tmp_path / "bad.vxs").write_bytes(level.read_bytes()[:5000])
    assert "usage: " in run(programs[name], installed, status=2).stderr
    assert "no such file" in run(programs[name], installed, "none.vxs", 4, *rest, folder=tmp_path, status=1).stderr
    assert "bad.vxs: " in run(programs[name], installed, "bad.vxs", 4, *rest, folder=tmp_path, status=1).stderr
    assert "out of memory" in run(programs[name], installed, level, 0, *rest, folder=tmp_path, status=1).stderr


def test_a_frame(installed, vxs, tmp_path):
    """The ground at noon, seen as frame_scene.h says: dark below the board and the smoke, blue before the screen, and lit beside them."""
    small_scene.write(tmp_path / "ground.gltf", boxes=[((-100, -1, -100), (100, 0, 100))])
    vxs("bake", tmp_path / "ground.gltf", "-o", tmp_path / "ground.vxs", "--resolution", 1024)
    flags = pkg_config(installed / "lib" / "pkgconfig", {}, "--cflags", "--libs", package="vxs_volumes")
    program = tmp_path / "frame"
    done = subprocess.run(["cc", "-std=c11", *WARNINGS, EXAMPLES / "frame.c", *flags, "-lOSMesa", "-lm", "-o", program], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    assert "usage: " in run(program, installed, status=2).stderr
    assert "no level" in run(program, installed, "none.vxs", "out.ppm", folder=tmp_path, status=1).stderr
    run(program, installed, "ground.vxs", "frame.ppm", folder=tmp_path)
    head, pixels = (tmp_path / "frame.ppm").read_bytes().split(b"255\n", 1)
    wide, high = map(int, head.split()[1:])

    def seen(x, z):
        """Red and blue of the ground at a place, 10 m below the eye."""
        column, row = int((x / z / 1.6 + 0.5) * wide), int((0.5 + 10 / z) * high)
        at = 3 * (row * wide + column)
        return pixels[at], pixels[at + 2]

    lit = seen(10, 40)[0]
    assert seen(-10, 40)[0] < 0.6 * lit  # below the board
    assert 0.6 * lit < seen(-14.5, 40)[0]  # and beside it
    assert seen(-3, 23)[0] < 0.8 * seen(3, 23)[0]  # below the smoke
    assert seen(0, 34)[1] - seen(0, 34)[0] > 20 > abs(seen(20, 60)[1] - seen(20, 60)[0])


# docs/guide-fog.md calls for a renderer: that of the example, whose picture is black ground below black sky
FOG_USER = """
#include "gl_picture.h"

int main(int argc, char **argv)
{
    vxs_asset *level;
    vxs_gl    *shadows;
    double     eye_ws[3];
    if (argc != 3 || !gl_begin() || vxs_asset_open_file(&level, argv[1], NULL)) return 1;
    const vxs_light *sun = &vxs_asset_light(level, 0)->light;
    if (vxs_gl_create(&shadows, &(vxs_gl_desc){.get_proc_address = gl_function, .asset = level})) return 1;
    vxs_gl_upload(shadows, SIZE_MAX);
    vxs_point(sun, 0, (double[3]){512, 512, 512}, eye_ws);
    eye_ws[1] = 10;
    vxs_gl_origin(shadows, eye_ws);
    vxs_volumes *fog = fog_create(shadows, gl_function, WIDE, HIGH);
    if (!fog) return 1;
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    fog_draw(fog, gl_ground(10), WIDE, HIGH, gl_point_from_depth);
    return gl_write(argv[2]) ? 0 : 1;
}
"""


def test_fog_of_the_guide(installed, vxs, tmp_path):
    """Over black, airlight alone: some everywhere, more along longer rays, less where a wall keeps the sun off the air."""
    (listing,) = re.findall(r"^```c\n(.*?)^```", (ROOT / "docs" / "guide-fog.md").read_text(), re.MULTILINE | re.DOTALL)
    (tmp_path / "fog.c").write_text(listing + FOG_USER)
    flags = pkg_config(installed / "lib" / "pkgconfig", {}, "--cflags", "--libs", package="vxs_volumes")
    done = subprocess.run(["cc", "-std=c11", *WARNINGS, "-Wno-unused-function", f"-I{EXAMPLES}", "fog.c", *flags, "-lOSMesa", "-lm", "-o", "fog"], cwd=tmp_path,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ground = ((-100, -1, -100), (100, 0, 100))
    pixels = {}
    for name, boxes in (("open", [ground]), ("roof", [ground, ((-60, 40, 0), (0, 41, 90))])):
        small_scene.write(tmp_path / "ground.gltf", boxes=boxes)
        vxs("bake", tmp_path / "ground.gltf", "-o", tmp_path / "ground.vxs", "--resolution", 1024)
        run(tmp_path / "fog", installed, "ground.vxs", "fog.ppm", folder=tmp_path)
        head, data = (tmp_path / "fog.ppm").read_bytes().split(b"255\n", 1)
        wide, high = map(int, head.split()[1:])
        pixels[name] = [[data[3 * (y * wide + x)] for x in range(wide)] for y in range(high)]
    near, far, left, right = high - 5, high // 2 + 5, wide // 4, 3 * wide // 4
    assert 0 < pixels["open"][near][left] < pixels["open"][far][left], "longer rays have more air"
    assert pixels["roof"][far][left] < 0.8 * pixels["open"][far][left], "below the roof the air is dark"
    assert pixels["roof"][far][left] < 0.8 * pixels["roof"][far][right], "and lit beside it"


@pytest.mark.slow
def test_by_cmake(programs, installed, level, tmp_path):
    if not shutil.which("cmake"):
        pytest.skip("no cmake: package cmake")
    (tmp_path / "CMakeLists.txt").write_text(CMAKE.replace("@FOLDER@", str(EXAMPLES)))
    for line in (["cmake", "-S", ".", "-B", "made", f"-DCMAKE_PREFIX_PATH={installed}"], ["cmake", "--build", "made"]):
        done = subprocess.run(line, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    for name in COMPILERS:
        rest = [tmp_path / "frame"] if name == "flight.c" else []
        program = tmp_path / "made" / name.split(".")[0]
        if name == "flight.c":  # pages come when they come
            run(program, installed, level, 16, *rest)
        else:
            assert run(program, installed, level, 16).stdout == run(programs[name], installed, level, 16).stdout
