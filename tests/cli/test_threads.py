# Work shared by 2 and 8 threads: the same bytes as with one, and, in a build for ThreadSanitizer (make check-sanitizers), no two
# threads at the same memory. What other libraries do among themselves is left out, with reasons, in tests/tsan.supp.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import subprocess

import pytest

import small_scene
from conftest import ROOT
from small_scene import MORNING, NOON

LIGHTS = (("noon", "directional", NOON), ("lamp", "spot", MORNING), ("bulb", "point", NOON))
SCENES = {  # options of vxs scene, and the resolution
    "small": (None, 2048),
    "city": (("city", "--triangles", 20000, "--spots", 2), 1024),
    "landscape": (("landscape", "--triangles", 20000), 512),
    "room": (("room",), 256),
    "forest": (("forest",), 512),
}


@pytest.fixture(scope="module")
def run(vxs_path):
    def run(*arguments, **options):
        environment = {"TSAN_OPTIONS": "suppressions=tests/tsan.supp", **os.environ}
        done = subprocess.run([vxs_path, *map(str, arguments)], cwd=ROOT, env=environment, capture_output=True, timeout=600, **options)
        assert done.returncode == 0 and b"ThreadSanitizer" not in done.stderr, done.stderr.decode()
        return done.stdout

    return run


@pytest.fixture(scope="module", params=SCENES)
def scene(request, run, tmp_path_factory):
    """A scene's path, and the resolution for it."""
    path = tmp_path_factory.mktemp("threads") / request.param
    options, resolution = SCENES[request.param]
    if options is None:
        return small_scene.write(path.with_suffix(".gltf"), lights=LIGHTS), resolution
    run("scene", *options, "-o", path)
    return path, resolution


@pytest.mark.parametrize("options", [("--coding", "dag"), (), ("--maps", "gl")], ids=["dag", "blocks", "gl"])
def test_bake(run, scene, tmp_path, options):
    path, resolution = scene
    out = {}
    for threads in (1, 2, 8):
        run("bake", path, "-o", tmp_path / "a.vxs", "--resolution", resolution, "--threads", threads, *options)
        out[threads] = (tmp_path / "a.vxs").read_bytes()
    assert out[1] == out[2] == out[8]


@pytest.mark.parametrize("coding", ["dag", "blocks"])
def test_processors(run, scene, tmp_path, monkeypatch, coding):
    """Loops that are compiled for several processors, and the C library's, which has other functions where numbers can be multiplied and added
    at once."""
    path, resolution = scene
    out = set()
    for most in ("avx512", "avx2", "sse2"):
        monkeypatch.setenv("VXS_CPU", most)
        if most == "sse2":
            monkeypatch.setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX512F,-AVX2,-AVX,-FMA,-FMA4")
        run("bake", path, "-o", tmp_path / "a.vxs", "--resolution", resolution, "--coding", coding)
        out.add((tmp_path / "a.vxs").read_bytes())
    assert len(out) == 1


@pytest.mark.parametrize("threads", [2, 8])
def test_rays(run, tmp_path, threads):
    path = small_scene.write(tmp_path / "small.gltf", lights=LIGHTS)
    run("bake", path, "-o", tmp_path / "a.vxs", "--resolution", 256)
    run("compare", path, tmp_path / "a.vxs", "--points", 2000, "--threads", threads)
    run("render", path, tmp_path / "a.vxs", "-o", tmp_path / "a.png", "--width", 160, "--height", 90, "--threads", threads)
    run("truth", path, "--threads", threads, input=b"0 0 0\n" * 20000)
