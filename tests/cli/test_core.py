# vxs-core, the command without the laboratory (make core=1): what it links, and that it bakes, plans and answers as vxs does.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import re
import subprocess

import pytest
from small_scene import write

PRODUCT = ["bake", "plan", "merge", "info", "validate", "query"]
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
