# libvxs_bake as a program gets it: installed, built against in C and C++, with the bytes of the command; and what it must not have:
# names that clash, state that bakes share, calls that change the process.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shlex
import subprocess

import pytest

import small_scene
from conftest import ROOT
from small_scene import MORNING, NOON
from test_faults import fault_library  # noqa: F401  a fixture
from test_install import CXX_COMPILER, C_COMPILER, MAJOR, SANITIZERS, build, config_of, make, needed, nm  # noqa: F401  build: a fixture

GUIDE = (ROOT / "docs" / "bake-library.md").read_text()
LISTINGS = re.findall(r"^```c\n(.*?)^```$", GUIDE, re.MULTILINE | re.DOTALL)

# user SCENE OUT RESOLUTION [dag] [fast] [behind] [thick] [off] [region] [steps] [one]
USER = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vxs_bake.h>

static void print(vxs_severity severity, const char *text, void *user)
{
    (void)user;
    if (severity == VXS_SEVERITY_ERROR) fprintf(stderr, "%s\\n", text);
}

int main(int argc, char **argv)
{
    vxs_bake_options o = vxs_bake_defaults();
    vxs_bake_job    *job;
    vxs_bake_state   state = VXS_BAKE_MORE;
    double           budget = 0;
    int              n;
    o.scene_path  = argv[1];
    o.output_path = argv[2];
    o.resolution  = atoi(argv[3]);
    o.threads     = 2;
    o.log         = print;
    for (n = 4; n < argc; n++) {
        if (!strcmp(argv[n], "dag")) o.coding = VXS_BAKE_DAG;
        if (!strcmp(argv[n], "fast")) o.pack = VXS_BAKE_PACK_FAST;
        if (!strcmp(argv[n], "behind")) o.behind_free = 1;
        if (!strcmp(argv[n], "thick")) o.thickness_metres = 0.25;
        if (!strcmp(argv[n], "off")) o.closed = VXS_BAKE_CLOSED_OFF;
        if (!strcmp(argv[n], "one")) o.threads = 1;
        if (!strcmp(argv[n], "steps")) budget = 3;
        if (!strcmp(argv[n], "region")) {
            o.has_region = 1;
            o.region_ws[3] = o.region_ws[4] = o.region_ws[5] = 4;
        }
    }
    if (vxs_bake_job_open(&job, &o) != VXS_OK) return 2;
    while (budget > 0 && state == VXS_BAKE_MORE) state = vxs_bake_step(job, budget);
    n = vxs_bake_job_run(job);
    vxs_bake_job_close(job);
    return n;
}
"""


@pytest.fixture(scope="module")
def installed(build, tmp_path_factory):  # noqa: F811
    prefix = tmp_path_factory.mktemp("bake library")
    make(build, "install", f"prefix={prefix}")
    return prefix


@pytest.fixture(scope="module")
def compiled(build, installed, tmp_path_factory):  # noqa: F811
    """compiled(source, compiler, static=False): a program against what was installed, away from the sources."""
    folder = tmp_path_factory.mktemp("user")

    def compiled(source, compiler=C_COMPILER, static=False):
        name = folder / f"user{len(list(folder.iterdir()))}"
        source_file = name.with_suffix(".cpp" if compiler is CXX_COMPILER else ".c")
        source_file.write_text(source)
        flags = pkg_config_of(installed, "--static" if static else "--shared")
        done = subprocess.run([*compiler, "-Wall", "-Wextra", "-Werror", *SANITIZERS.get(config_of(build), []), "-o", name, source_file, *flags],
                              capture_output=True, text=True, cwd=folder)
        assert done.returncode == 0, done.stderr
        return name

    return compiled


def pkg_config_of(prefix, kind):
    """Flags for libvxs_bake.   kind: --shared, --static"""
    env = {"PATH": os.environ["PATH"], "PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig")}
    args = ["--static"] if kind == "--static" else []
    done = subprocess.run(["pkg-config", *args, "--cflags", "--libs", "vxs_bake"], env=env, capture_output=True, text=True, check=True)
    text = done.stdout.replace("-lvxs_bake", "-l:libvxs_bake.a") if args else done.stdout
    return shlex.split(text)


@pytest.fixture(scope="module")
def run(installed):
    def run(program, *args, status=0, cwd=None, **environment):
        env = os.environ | {"LD_LIBRARY_PATH": str(installed / "lib")} | environment
        done = subprocess.run([program, *map(str, args)], env=env, cwd=cwd, capture_output=True, text=True, timeout=300)
        assert status in (done.returncode, None), done.stderr
        return done

    return run


@pytest.fixture(scope="module")
def scenes(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes")
    vxs("scene", "city", "-o", folder / "city.glb", "--triangles", 5000, "--blocks", 2)
    vxs("scene", "room", "-o", folder / "room.glb")
    small_scene.write(folder / "small.gltf", lights=(("noon", "directional", NOON), ("lamp", "spot", MORNING)))
    return folder


OPTIONS = {"dag": ("--coding", "dag"), "fast": ("--pack", "fast"), "off": ("--closed", "off"), "behind": ("--behind", "free"), "thick": ("--thickness", "0.25"), "region": ("--region", "0,0,0,4,4,4")}


@pytest.fixture(scope="module")
def user(compiled):
    return {"c": compiled(USER), "c++": compiled(USER, CXX_COMPILER), "static": compiled(USER, static=True)}


@pytest.mark.parametrize("scene, words, language", [
    ("city.glb", (), "c"), ("city.glb", ("dag", "one"), "c++"), ("city.glb", ("fast", "steps"), "static"), ("city.glb", ("off", "region"), "c"),
    ("small.gltf", ("steps",), "c"), ("small.gltf", ("dag", "steps"), "static"), ("room.glb", ("fast",), "c++"), ("room.glb", ("behind", "thick"), "c"),
], ids=str)
def test_bytes_of_the_command(vxs, run, user, scenes, tmp_path, scene, words, language):
    options = [o for word in words for o in OPTIONS.get(word, ())]
    vxs("bake", scenes / scene, "-o", tmp_path / "a.vxs", "--resolution", 512, *options)
    done = run(user[language], scenes / scene, tmp_path / "b.vxs", 512, *words)
    assert done.stdout == done.stderr == ""
    assert (tmp_path / "a.vxs").read_bytes() == (tmp_path / "b.vxs").read_bytes()


def test_users_are_linked_as_they_say(user):
    assert f"libvxs_bake.so.{MAJOR}" in needed(user["c"]) and f"libvxs_bake.so.{MAJOR}" in needed(user["c++"])
    assert not [name for name in needed(user["static"]) if name.startswith("libvxs")]


def test_a_level_when_it_is_saved(vxs, run, compiled, scenes, tmp_path):
    program = compiled(LISTINGS[0])
    vxs("bake", scenes / "city.glb", "-o", tmp_path / "a.vxs", "--resolution", 1024)
    shown = run(program, scenes / "city.glb", tmp_path / "b.vxs").stdout
    assert "reading" in shown and "light sun: square 1 of" in shown
    assert (tmp_path / "a.vxs").read_bytes() == (tmp_path / "b.vxs").read_bytes()
    assert run(program, tmp_path / "missing.glb", tmp_path / "b.vxs", status=1).stderr.startswith("error: ")


def test_a_sun_that_moves(vxs, run, compiled, scenes, tmp_path):
    run(compiled(LISTINGS[1]), scenes / "city.glb", cwd=tmp_path)
    for hour in (8, 12, 16):
        vxs("bake", scenes / "city.glb", "-o", tmp_path / "a.vxs", "--resolution", 1024, f"--sun={(hour - 12) / 4},-1,-0.25")
        assert (tmp_path / "a.vxs").read_bytes() == (tmp_path / f"{hour:02}.vxs").read_bytes()


def test_bad_input_is_a_result(run, user, scenes, tmp_path):
    assert "missing.glb" in run(user["c"], tmp_path / "missing.glb", tmp_path / "a.vxs", 64, status=3).stderr
    assert "resolution 63" in run(user["c"], scenes / "small.gltf", tmp_path / "a.vxs", 63, status=2).stderr
    (tmp_path / "bad.glb").write_bytes((scenes / "city.glb").read_bytes()[:1000])
    run(user["c"], tmp_path / "bad.glb", tmp_path / "a.vxs", 64, status=20)
    assert not (tmp_path / "a.vxs").exists()


# --- what it has, and what not ----------------------------------------------------------------------------------------------------


def declared():
    header = (ROOT / "baker" / "vxs_bake.h").read_text()
    return set(re.findall(r"^(?!typedef|static)\w[^;(\n]*?\b(vxs_bake\w*)\(", header, re.MULTILINE))


def test_only_the_headers_names_are_seen(build):  # noqa: F811
    exported = subprocess.run(["nm", "-D", "--defined-only", "--with-symbol-versions", build / "libvxs_bake.so"], capture_output=True, text=True,
                              check=True).stdout
    names = dict(line.split()[2].split("@@") for line in exported.splitlines() if line.split()[1] != "A")
    assert len(names) > 10 and set(names) == declared() and set(names.values()) == {f"VXS_BAKE_{MAJOR}"}
    assert nm(build / "libvxs_bake.a", "-g", "--defined-only") == declared()
    dynamic = subprocess.run(["readelf", "-d", build / "libvxs_bake.so"], capture_output=True, text=True, check=True).stdout
    assert f"soname: [libvxs_bake.so.{MAJOR}]" in dynamic


# Of the libraries whose templates are compiled here: constants, counters that are atomic, and what belongs to a thread.
FOREIGN = r"(guard variable for )?(CGAL::|boost::|std::|tinygltf::|nlohmann::)"
# Ours: tables of the glTF reader, static const and made when they are first used; and the run control of a thread.
CONSTANT = {"filters", "modes", "types", "known", "none", "kinds", "nothing"}
OF_A_THREAD = {"current"}


def test_bakes_share_no_state(build):  # noqa: F811
    """Every variable that can be written, of all objects in the library."""
    if config_of(build) in SANITIZERS:
        pytest.skip("sanitizers have variables of their own")
    table = subprocess.run(["objdump", "-t", "-C", build / "vxs_bake.o"], capture_output=True, text=True, check=True).stdout
    rows = re.findall(r"^[0-9a-f]+ .{6}[Oo ] (\.t?(?:data|bss)\S*)\s+[0-9a-f]+ (?:\.hidden )?(.+)$", table, re.MULTILINE)
    rows = [(section, name) for section, name in rows if not section.startswith((".data.rel.ro", ".data.rel.local.DW.ref")) and name != section]
    names = {name for _, name in rows if not re.match(FOREIGN, name)}
    ours = {re.sub(r"^guard variable for ", "", name).split("::")[-1] for name in names if "gltf::" in name}
    assert len(rows) > 10 and ours <= CONSTANT
    assert {name for name in names if "gltf::" not in name} == OF_A_THREAD
    for name in ours:  # a table says itself that it is one
        sources = "".join(path.read_text() for path in (ROOT / "baker" / "scene" / "gltf").glob("*.cc"))
        assert re.search(rf"static const [^;]*\b{name}\b", sources), name


def test_the_process_is_left_alone(build):  # noqa: F811
    called = nm(build / "vxs_bake.o", "-u")
    assert {"malloc", "pthread_create"} <= called
    assert not called & {"_exit", "fork", "execve", "signal", "sigaction", "mallopt", "setlocale", "umask", "chdir", "setrlimit", "setenv", "putenv",
                         "dlopen", "stderr", "puts", "printf", "fputs_unlocked", "json_set_alloc_funcs", "_ZSt13set_terminatePFvvE"}


def test_nothing_but_what_it_says_is_needed(build):  # noqa: F811
    if config_of(build) in SANITIZERS:
        pytest.skip("sanitizers need libraries of their own")
    assert not [name for name in needed(build / "libvxs_bake.so") if re.match(r"libvxs|libOSMesa|libGL|libEGL|libembree", name)]
    loose = subprocess.run(["ldd", "-r", build / "libvxs_bake.so"], capture_output=True, text=True, check=True)
    assert "undefined symbol" not in loose.stdout + loose.stderr


ARRAYS_USER = """
#include <stdio.h>
#include <vxs_bake.h>

static char error[256];
static int  errors;

static void keep(vxs_severity severity, const char *text, void *user)
{
    (void)user;
    if (severity != VXS_SEVERITY_ERROR) return;
    errors++;
    snprintf(error, sizeof error, "%s", text);
}

int main(void)
{
    static const float    positions[] = {-4, 0, -4, 4, 0, -4, 4, 0, 4, -4, 0, 4, -1, 2, -1, 1, 2, -1, 0, 3, 1};
    static const uint32_t indices[]   = {0, 2, 1, 0, 3, 2, 4, 6, 5};
    vxs_bake_mesh    mesh   = {positions, indices, 7, 3, {0, 0, 0}, 0};
    vxs_bake_arrays  arrays = {&mesh, 1, NULL, 0, NULL, 0};
    vxs_bake_sun     sun    = {NULL, {0.1, -1, 0.2}};
    vxs_bake_bytes   file;
    vxs_bake_options o = vxs_bake_defaults();
    int              n, r = 0;
    for (n = 0; n < 2 && !r; n++) {
        o.arrays     = &arrays;
        o.suns       = &sun;
        o.sun_count  = 1;
        o.resolution = 256;
        o.threads    = 2;
        o.coding     = n ? VXS_BAKE_DAG : VXS_BAKE_BLOCKS;
        o.log        = keep;
        r            = vxs_bake(&o, &file);
        printf("%d %d %s\\n", r, file.data != NULL, error);
        vxs_bake_bytes_free(&file);
    }
    if (errors != (r != VXS_OK)) return 3; /* each failure logs one reason */
    return r;
}
"""


@pytest.mark.slow
def test_no_memory_is_a_result(build, run, compiled, fault_library, tmp_path):  # noqa: F811
    """Each place in the library that allocates fails, the first time that it is come to."""
    if config_of(build) in SANITIZERS:
        pytest.skip("a sanitizer stands before libc's functions itself")
    program = compiled(ARRAYS_USER)
    env = {"LD_PRELOAD": str(fault_library), "FAULT_FROM": "libvxs_bake"}
    run(program, **env, FAULT="alloc:0:0", FAULT_COUNT=str(tmp_path / "count"))
    count, *first = map(int, (tmp_path / "count").read_text().split())
    assert count > 100 and len(first) > 50
    failed = 0
    for call in first:
        done = run(program, status=None, **env, FAULT=f"alloc:{call}:12")
        lines = done.stdout.splitlines()
        assert done.returncode in (0, 2), (call, done)
        assert done.stderr == "" and lines, (call, done)
        if done.returncode == 2:
            assert re.match(r"2 0 .", lines[-1]), (call, done)
            failed += 1
    assert failed > 40
