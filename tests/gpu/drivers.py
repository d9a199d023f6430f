#!/usr/bin/python3
# Run the unit programs that draw with other OpenGL drivers than the one of `make check`: Mesa's llvmpipe by EGL, zink over Vulkan's
# lavapipe, and softpipe. A driver that is not installed is skipped, with its package.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import concurrent.futures
import glob
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import kit  # noqa: E402

TIMEOUT_S = 1800
LAVAPIPE = "/usr/share/vulkan/icd.d/lvp_icd.*.json"
# Mesa's interpreter of shaders says that it has OpenGL 3.3, because it lacks tessellation. The override makes its other functions of 4.5
# known. These programs look words up in textures and buffers; the others take too long there.
SOFTPIPE = ("test_gl", "test_gl_stream", "test_gl_depths", "test_shaders", "test_stream_smoke", "test_epipolar", "test_smoke_map")


def drivers(folder):
    """(name, environment, what is missing or None)"""
    icd = sorted(glob.glob(LAVAPIPE))
    yield "llvmpipe", {"VXS_GL": "egl"}, None
    yield "softpipe", {"VXS_GL": "egl", "GALLIUM_DRIVER": "softpipe", "LIBGL_ALWAYS_SOFTWARE": "1", "MESA_GL_VERSION_OVERRIDE": "4.5",
                       "MESA_GLSL_VERSION_OVERRIDE": "450"}, None
    yield ("zink", {"VXS_GL": "egl", "GALLIUM_DRIVER": "zink", "LIBGL_ALWAYS_SOFTWARE": "1", "XDG_RUNTIME_DIR": folder,
                    "VK_ICD_FILENAMES": icd[0] if icd else ""}, None if icd else "package mesa-vulkan-drivers")


def run(job):
    name, environment, program = job
    done = subprocess.run([program], env={**os.environ, "VXS_GL_DEBUG": "1", **environment}, timeout=TIMEOUT_S, text=True,
                          errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    lacks = re.search(r"^no OpenGL 4.5.*", done.stdout, re.M)
    if lacks and name != "llvmpipe":  # a Mesa without this driver
        print(f"{name:9} {program.name}: skipped: {lacks[0]}")
        return False
    counts = [len(re.findall(rf"^\[ +{word} +\] \w+$", done.stdout, re.M)) for word in ("OK", "FAILED", "SKIPPED")]
    bad = done.returncode != 0
    print(f"{name:9} {program.name}: {counts[0]} passed, {counts[2]} skipped" + (f", exit status {done.returncode}" if bad else ""))
    if bad:
        print(done.stdout)
    return bad


def main():
    parser = argparse.ArgumentParser(description="Run the unit programs that draw with several OpenGL drivers.")
    parser.add_argument("--build", type=pathlib.Path, required=True, help="folder of a build")
    parser.add_argument("--driver", choices=["llvmpipe", "softpipe", "zink"], help="this one alone")
    options = parser.parse_args()
    programs = list(kit.drawing(options.build))
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = []
        for name, environment, missing in drivers(folder):
            if name != (options.driver or name):
                continue
            if missing:
                print(f"{name:9} skipped: {missing} is not installed")
                continue
            some = [program for program in programs if name != "softpipe" or program.name in SOFTPIPE]
            jobs += [(name, environment, program) for program in some]
            if some != programs:
                print(f"{name:9} skipped: {len(programs) - len(some)} programs that draw fog, areas or maps of a bake: too slow")
        bad = sum(pool.map(run, jobs))
    print(f"{len(jobs) - bad} passed, {bad} failed")
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
