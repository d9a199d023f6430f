# Lookups in Vulkan: docs/example/vulkan.c on a driver that needs no graphics processor (lavapipe), held against C: from integer
# voxels bit for bit, from positions but for where float rounding decides between two voxels.
# SPDX-License-Identifier: GPL-3.0-or-later
import ctypes.util
import functools
import pathlib
import shutil
import subprocess

import pytest

import voxels
from conftest import ROOT
from test_example import EXAMPLES, WARNINGS, installed, pkg_config  # noqa: F401 (installed is a fixture)
from test_install import build  # noqa: F401 (of which installed is made)

LAYERS = pathlib.Path("/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json")
MAIN = "void main()\n"
OF_VOXELS = """void main()
{
    uint n = gl_GlobalInvocationID.x;
    if (n >= point_count) return;
    vxs_light_constants light = lights[light_index];
    vxs_place           place;
    place.voxel  = ivec3(points[n].position_ws);
    place.map    = int(points[n].normal_ws.x);
    place.across = uint(points[n].normal_ws.y);
    place.down   = uint(points[n].normal_ws.z);
    vxs_filter pcf = FILTER_IS_SMOOTH != 0 ? vxs_smooth(FILTER_WIDTH_PX) : vxs_box(FILTER_WIDTH_PX);
    uint       k   = uint(place.voxel.z), dark;
    if (FILTER_IS_SMOOTH != 0)
        dark = vxs_shadow_part(light.first_word, light, place, k, FILTER_WIDTH_PX);
    else
        dark = vxs_shadow_taps(light.first_word, light, place.map, place.voxel.x, place.voxel.y, k, FILTER_WIDTH_PX);
    lit[n] = ANSWER;
}
"""


def missing():
    if not shutil.which("glslangValidator"):
        return "no glslangValidator: package glslang-tools"
    if not ctypes.util.find_library("vulkan") or not pathlib.Path("/usr/include/vulkan/vulkan.h").is_file():
        return "no Vulkan loader and headers: package libvulkan-dev"
    return "" if voxels.LAVAPIPE else "no lavapipe: package mesa-vulkan-drivers"


if missing():
    pytest.skip(missing(), allow_module_level=True)


@pytest.fixture(scope="module")
def flags(installed):  # noqa: F811
    return pkg_config(installed / "lib" / "pkgconfig", {}, "--cflags", "--libs")


@pytest.fixture(scope="module")
def program(flags, tmp_path_factory):
    made = tmp_path_factory.mktemp("vulkan") / "vulkan"
    done = subprocess.run(["cc", "-std=c99", *WARNINGS, EXAMPLES / "vulkan.c", *flags, "-lvulkan", "-o", made], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return made


@pytest.fixture(scope="module")
def spirv(installed, tmp_path_factory):  # noqa: F811
    """spirv(text): the file that glslangValidator makes of a shader with the installed headers."""
    folder = tmp_path_factory.mktemp("spirv")

    def compile(text):
        path = folder / f"{len(list(folder.iterdir()))}.comp"
        path.write_text(text)
        done = subprocess.run(["glslangValidator", "-V", f"-I{installed / 'include' / 'vxs'}", path, "-o", path.with_suffix(".spv")],
                              capture_output=True, text=True)
        assert done.returncode == 0 and "WARNING" not in done.stdout, done.stdout
        if shutil.which("spirv-val"):
            done = subprocess.run(["spirv-val", "--target-env", "vulkan1.0", path.with_suffix(".spv")], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
        return path.with_suffix(".spv")

    return compile


@pytest.fixture(scope="module")
def shader(spirv):
    return spirv((EXAMPLES / "vulkan.comp").read_text())


@pytest.fixture
def look_up(program, installed):  # noqa: F811
    """look_up(file, shader, light, width, points): answers as floats."""

    def run(file, shader, light, width, points, status=0):
        lines = "".join(" ".join(f"{x:.9g}" for x in point) + "\n" for point in points)
        layers = {"VK_INSTANCE_LAYERS": "VK_LAYER_KHRONOS_validation"} if LAYERS.is_file() else {}
        done = subprocess.run([program, file, shader, str(light), str(width)], input=lines, capture_output=True, text=True, timeout=120,
                              env={"LD_LIBRARY_PATH": str(installed / "lib"), "VK_ICD_FILENAMES": str(voxels.LAVAPIPE), **layers})
        assert done.returncode == status, done.stderr
        return [voxels.as_float(float(line)) for line in done.stdout.split()] if not status else done.stderr

    return run


@pytest.fixture(scope="module")
def places(flags, installed, tmp_path_factory):  # noqa: F811
    """places(name, light, width): what voxels.write_places returns of a golden file."""
    folder = tmp_path_factory.mktemp("places")
    program = voxels.compile_places(folder, flags)
    return functools.cache(lambda *case: voxels.write_places(program, folder / "-".join(map(str, case)), *case, installed / "lib"))


def golden(name):
    return ROOT / "tests" / "golden" / f"{name}.vxs"


def six(rows):
    """A point of the program's input."""
    return [(*row[:3], *row[4:7]) for row in rows]


@pytest.mark.parametrize("answer", ["float(dark)", "vxs_lit_at_place(light.first_word, light, place, pcf)"], ids=["dark", "lit"])
def test_voxels(spirv, look_up, places, answer):
    text = (EXAMPLES / "vulkan.comp").read_text()
    shader = spirv(text[:text.index(MAIN)] + OF_VOXELS.replace("ANSWER", answer))
    partly, cases = 0, voxels.CASES if answer == "float(dark)" else voxels.CASES[1::3]
    for name, light, width in cases:
        rows, answers, *_ = places(name, light, width)
        found = look_up(golden(name), shader, light, width, six(rows))
        assert found == [as_wanted[answer != "float(dark)"] for as_wanted in answers], f"{name}, light {light}, width {width}"
        partly += sum(0 < lit < 1 for _, lit in answers)
    assert partly > 100 * len(cases)


def test_points(shader, look_up, places):
    for name, light, width in voxels.CASES:
        _, _, points, answers, *_ = places(name, light, width)
        voxels.check_points(look_up(golden(name), shader, light, width, six(points)), answers)


def test_what_goes_wrong_is_said(shader, look_up, program, installed, tmp_path):  # noqa: F811
    (tmp_path / "no.spv").write_text("no shader")
    done = subprocess.run([program], env={"LD_LIBRARY_PATH": str(installed / "lib")}, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (2, "usage: vulkan LEVEL.vxs SHADER.spv LIGHT WIDTH\n")
    assert look_up(tmp_path / "none.vxs", shader, 0, 1, [], status=1) == f"vulkan: {tmp_path / 'none.vxs'}: no such file\n"
    assert look_up(golden("sample"), shader, 2, 1, [], status=1) == "vulkan: the level has no such light\n"
    for name in ("none.spv", "no.spv"):
        assert look_up(golden("sample"), tmp_path / name, 0, 1, [], status=1) == "vulkan: the second argument is no SPIR-V file\n"
    assert look_up(golden("sample"), shader, 0, 1, []) == []
