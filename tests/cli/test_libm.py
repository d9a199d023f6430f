# Bytes of baked files depend on no C library and on no processor: baker/base/portable_math.h stands in for functions of libm
# whose last bit differs.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import subprocess
import sys

import pytest

import small_scene
from conftest import ROOT

# Functions with one right result, which IEEE 754 or the C standard defines
EXACT = {name + suffix for suffix in ("", "f", "l") for name in """
    ceil copysign fabs fdim floor fmax fmin fmod frexp ilogb ldexp llrint llround logb lrint lround modf nearbyint nextafter remainder
    rint round scalbln scalbn sqrt trunc""".split()} | {"fegetenv", "fesetenv", "fegetround", "fesetround", "feholdexcept", "feupdateenv"}
# CGAL: how deep a tree of boxes is; the pairs that it finds do not depend on this
ALLOWED = {("mesh_intersect.cc.o", "log")}


def symbols(*arguments):
    return subprocess.run(["nm", *arguments], capture_output=True, text=True, check=True).stdout


def test_baker_imports_exact_functions_of_libm_only(vxs_path):
    bake = vxs_path.parent / "bake.a"
    if not bake.is_file():
        pytest.skip(f"no {bake}: make unit builds it")
    libm = subprocess.run(["cc", "-print-file-name=libm.so.6"], capture_output=True, text=True, check=True).stdout.strip()
    of_libm = {line.split()[-1].split("@")[0] for line in symbols("-D", "--defined-only", libm).splitlines()}
    assert {"tan", "exp", "log", "pow", "hypot"} <= of_libm
    imported, member = set(), None
    for line in symbols("-u", bake).splitlines():
        if line.endswith(":"):
            member = pathlib.Path(line.rstrip(":").split("[")[-1].rstrip("]")).name
        elif line.split() and line.split()[-1] in of_libm:
            imported.add((member, line.split()[-1]))
    assert ("light_fit.c.o", "sqrt") in imported and ("sparse_columns.c.o", "ldexp") in imported
    assert {pair for pair in imported if pair[1] not in EXACT} == ALLOWED


WITHOUT_FMA = dict(os.environ, GLIBC_TUNABLES="glibc.cpu.hwcaps=-FMA", VXS_CPU="sse2")
ANGLES = [n / 5000 for n in range(1000, 5000)]  # of cones, radians


@pytest.fixture(scope="module")
def hard_angles():
    """Angles whose tangent or cosine has another last bit where glibc takes its functions for processors without fused multiply-add."""
    probe = [sys.executable, "-c", f"import math, json; print(json.dumps([[math.tan(a).hex(), math.cos(a).hex()] for a in {ANGLES}]))"]
    plain, other = (json.loads(subprocess.run(probe, capture_output=True, text=True, check=True, env=e).stdout) for e in (None, WITHOUT_FMA))
    hard = [a for a, p, o in zip(ANGLES, plain, other) if p != o]
    if not hard:
        pytest.skip("this C library has one variant of tan and cos here: no FMA, or not glibc")
    return hard


def check_same_bytes(vxs_path, folder, *commands):
    """Run commands, which write `scene.glb` or `baked.vxs`, with both variants of the library's functions."""
    written = []
    for environment in (None, WITHOUT_FMA):
        for command in commands:
            subprocess.run([vxs_path, *command, "--quiet", "--force"], check=True, env=environment, cwd=folder, stderr=subprocess.DEVNULL)
        written.append([(folder / name).read_bytes() for name in ("scene.glb", "baked.vxs") if (folder / name).is_file()])
    assert written[0] == written[1]


def test_same_bytes_of_lamps_with_hard_angles(vxs_path, hard_angles, tmp_path):
    angles = hard_angles[:: max(1, len(hard_angles) // 24)]
    scene = small_scene.write(tmp_path / "lamps.gltf", lights=[(f"lamp{n}", "spot", (0.1 * n, -1, 0)) for n in range(len(angles))])
    gltf = json.loads(scene.read_text())
    for light, angle in zip(gltf["extensions"]["KHR_lights_punctual"]["lights"], angles):
        light["spot"] = {"outerConeAngle": angle}
    scene.write_text(json.dumps(gltf))
    check_same_bytes(vxs_path, tmp_path, ["bake", "lamps.gltf", "-o", "baked.vxs", "--resolution", "64"])


SCENES = [  # how a scene is made, and how it is baked
    (["city"], ["--resolution", "512"]),
    (["city", "--spots", "40"], ["--resolution", "128"]),
    (["room"], ["--resolution", "256"]),
    (["smoke"], ["--resolution", "128", "--scene-smoke", "on", "--smoke-side", "64"]),
]
SHARED = ["features/lights_point_spot_directional.glb", "features/cubes_point_light.glb"]


@pytest.mark.parametrize("kind, options", SCENES, ids=lambda value: "-".join(value).replace("--", ""))
def test_same_bytes_of_generated_scenes(vxs_path, hard_angles, tmp_path, kind, options):
    check_same_bytes(vxs_path, tmp_path, ["scene", *kind, "-o", "scene.glb"], ["bake", "scene.glb", "-o", "baked.vxs", *options])


@pytest.mark.parametrize("name", SHARED)
def test_same_bytes_of_shared_scenes(vxs_path, hard_angles, tmp_path, name):
    scene = pathlib.Path(os.environ.get("VXS_SCENES", ROOT.parent / "shared" / "scenes")) / "real" / name
    if not scene.is_file():
        pytest.skip(f"no shared scene {scene}: set VXS_SCENES")
    check_same_bytes(vxs_path, tmp_path, ["bake", scene, "-o", "baked.vxs", "--resolution", "512"])
