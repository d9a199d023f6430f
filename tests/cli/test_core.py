# vxs-core, the command without the laboratory (make core=1): what it links, and that it bakes, plans and answers as vxs does.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import re
import shutil
import subprocess

import pytest
from conftest import EVERY, ROOT
from small_scene import write

PRODUCT = ["bake", "plan", "merge", "info", "validate", "query", "view", "export"]
LABORATORY = ["truth", "compare", "bench", "report", "render", "health", "mend", "scene"]
FOREIGN = re.compile(r"embree|osmesa|libegl|libgl\b|libmpi|openexr", re.I)


@pytest.fixture(scope="module")
def core(vxs_path):
    path = vxs_path.with_name("vxs-core")
    if not path.is_file():
        pytest.skip(f"no command at {path}: make builds it")
    return path


@pytest.fixture(scope="module")
def run(core):
    def run(*args, status=0, **more):
        done = subprocess.run([core, *map(str, args)], capture_output=True, text=True, timeout=600, **more)
        assert done.returncode == status, done.stderr
        return done

    return run


def test_it_links_neither_embree_nor_opengl_nor_mpi_nor_charts(core, vxs_path):
    linked = {path: subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout for path in (core, vxs_path)}
    assert not FOREIGN.search(linked[core])
    assert "sanitizer" in linked[core] or "embree" in linked[vxs_path], "the pattern finds what the whole command links"
    names = [line.split()[-1] for line in subprocess.run(["nm", core], capture_output=True, text=True, check=True).stdout.splitlines()]
    ours = [name for name in names if not name.startswith("_Z")]
    assert not [name for name in ours if re.search(r"^rtc[A-Z]|OSMesa|^egl[A-Z]|^gl[A-Z]|^gl_context|^MPI_|chart", name)]
    assert "bake_light" in " ".join(ours)


def test_its_commands_are_the_product(run):
    told = re.findall(r"^  (\w+) +\S", run("--help").stdout.split("commands:")[1], re.M)
    assert told[:len(PRODUCT)] == PRODUCT and not set(LABORATORY) & set(told)
    for name in LABORATORY:
        assert "unknown command" in run(name, status=2).stderr


def test_what_needs_the_laboratory_is_refused(run, tmp_path):
    scene, out = write(tmp_path / "small.gltf"), tmp_path / "a.vxs"
    assert "no OpenGL" in run("bake", scene, "-o", out, "--resolution", 64, "--maps", "gl", status=6).stderr
    assert "without pages" in run("bake", scene, "-o", out, "--resolution", 64, "--report", tmp_path / "a.html", status=2).stderr
    assert not out.exists()


@pytest.mark.parametrize("options", [(), ("--coding", "dag"), ("--pack", "fast", "--points", 200), ("--closed", "off", "--behind", "free")])
def test_same_bytes_and_answers(vxs, run, tmp_path, options):
    lights = (("sun", "directional", (-0.3, -1, -0.2)), ("lamp", "point", (0, -1, 0)))
    scene, files = write(tmp_path / "small.gltf", lights=lights), {}
    for name, command in (("vxs", vxs), ("core", run)):
        files[name] = tmp_path / f"{name}.vxs"
        command("bake", scene, "-o", files[name], "--resolution", 128, *options)
    assert files["core"].read_bytes() == files["vxs"].read_bytes()
    points = "".join(f"{x / 3} 0.01 {z / 3}\n" for x in range(-9, 10) for z in range(-9, 10))
    assert run("query", files["core"], input=points).stdout == vxs("query", files["vxs"], input=points).stdout
    run("validate", files["core"])
    told = [json.loads(command("info", files["core"], "--json", "-").stdout) for command in (run, vxs)]
    assert told[0] == told[1]
    plans = [json.loads(command("plan", scene, "--resolution", 128, *options, "--json", "-").stdout) for command in (run, vxs)]
    assert plans[0]["options"] == plans[1]["options"] and plans[0]["decisions"] == plans[1]["decisions"]


@pytest.mark.parametrize("name", ["sponza", "room_with_spheres_closed", "kaykit_city"])
def test_same_bytes_of_real_scenes(vxs, run, scenes, tmp_path, name):
    scene = scenes / "real" / f"{name}.glb"
    for out, command in (("vxs", vxs), ("core", run)):
        command("bake", scene, "-o", tmp_path / out, "--sun", "-0.4,-1,-0.2", "--resolution", 1024)
    assert (tmp_path / "core").read_bytes() == (tmp_path / "vxs").read_bytes()


THREADS = re.compile(r"\bU pthread_\w+|\bU __pthread\w+|\bU thrd_\w+")


@pytest.fixture(scope="module")
def one_thread(core, tmp_path_factory):
    """The build folder of `make core=1 threads=1`. Objects that neither include nor call anything of threads are the same in both
    builds: they are copied from the tree of the command, unless all tests run."""
    if not shutil.which("make") or core.parent.name != "release":
        pytest.skip("needs make, and a release build")
    build = tmp_path_factory.mktemp("one") / "release-1"
    objects = [path for path in core.parent.rglob("*.o") if "tests" not in path.parts and path.with_suffix(".d").is_file()]
    names = subprocess.run(["nm", "-A", "-u", *objects], capture_output=True, text=True, check=True).stdout
    callers = {line.split(":")[0] for line in names.splitlines() if THREADS.search(line)}
    for path in [] if EVERY else objects + list(core.parent.rglob("*.gch")):
        if str(path) not in callers and "platform.h" not in path.with_suffix(".d").read_text():
            copy = build / path.relative_to(core.parent)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, copy)
    env = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    goals = [f"{build}/{name}" for name in ("vxs-core", "libvxs_bake.a", "libvxs.a")]
    done = subprocess.run(["make", "-j2", "core=1", "threads=1", f"B={build}", "packages=skip", "werror=1", "CFLAGS=-O1", "CXXFLAGS=-O0", *goals], cwd=ROOT, env=env,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "baker/base/parallel.c" in done.stdout
    return build


def test_one_thread_needs_no_thread_library(core, one_thread):
    undefined = lambda path: subprocess.run(["nm", "-u", path], capture_output=True, text=True, check=True).stdout
    for name in ("libvxs_bake.a", "libvxs.a", "vxs-core"):
        assert THREADS.search(undefined(core.parent / name)), "the pattern finds what the build with threads uses"
        assert not THREADS.findall(undefined(one_thread / name))


@pytest.mark.parametrize("options", [(), ("--coding", "dag", "--threads", 3)])
def test_one_thread_bakes_the_same_bytes(vxs, one_thread, tmp_path, options):
    lights = (("sun", "directional", (-0.3, -1, -0.2)), ("lamp", "point", (0, -1, 0)))
    scene, files = write(tmp_path / "small.gltf", lights=lights), [tmp_path / "vxs", tmp_path / "one"]
    bake = ("bake", scene, "--resolution", 1024, *options)
    vxs(*bake, "-o", files[0])
    subprocess.run([one_thread / "vxs-core", *map(str, bake), "-o", files[1]], check=True, capture_output=True)
    assert files[1].read_bytes() == files[0].read_bytes()
    points = "".join(f"{x / 3} 0.01 {z / 3}\n" for x in range(-9, 10) for z in range(-9, 10))
    query = ("query", files[0], "--budget", 4000000)
    told = subprocess.run([one_thread / "vxs-core", *map(str, query)], input=points, check=True, capture_output=True, text=True).stdout
    assert told == vxs(*query, input=points).stdout


def test_a_step_on_one_thread_runs_to_the_end(one_thread, tmp_path):
    program, scene = tmp_path / "step.c", write(tmp_path / "small.gltf")
    program.write_text(r"""
#include <stdio.h>
#include "vxs_bake.h"
static void print(vxs_severity, const char *text, void *)
{
    printf("%s ", text);
}
int main(int argc, char **argv)
{
    vxs_bake_sun     sun = {"sun", {0, -1, 0}};
    vxs_bake_options o   = vxs_bake_defaults();
    vxs_bake_job    *job;
    o.scene_path  = argv[argc - 2];
    o.output_path = argv[argc - 1];
    o.suns        = &sun;
    o.sun_count   = 1;
    o.resolution  = 64;
    o.threads     = 4;
    o.log         = print;
    if (vxs_bake_job_open(&job, &o) != VXS_OK) return 1;
    vxs_bake_state state = vxs_bake_step(job, 1e-3);
    printf("%d ", state == VXS_BAKE_DONE);
    vxs_bake_job_close(job);
    return 0;
}
""")
    libraries = subprocess.run(["pkg-config", "--libs", "libzstd", "libxxhash", "jansson", "libpng", "libwebp"], capture_output=True,
                               text=True, check=True).stdout.split()
    subprocess.run(["g++", "-x", "c++", f"-I{ROOT}/baker", f"-I{ROOT}/formats", program, "-x", "none", one_thread / "libvxs_bake.a",
                    *libraries, "-ldraco", "-lmeshoptimizer", "-lgmp", "-lmpfr", "-lm", "-o", tmp_path / "step"], check=True)
    done = subprocess.run([tmp_path / "step", scene, tmp_path / "a.vxs"], capture_output=True, text=True, check=True)
    assert done.stdout == "1 " and (tmp_path / "a.vxs").is_file()
