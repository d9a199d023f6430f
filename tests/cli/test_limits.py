# Time and memory follow the input: deep piles of geometry, small files that unfold, --memory from outside of the process.
# VXS_EVERY_SCENE=1 bakes every real scene within half and twice of what it needs (make check-memory); else a few.
# VXS_LARGE=1 bakes maps of 65536 texels with too little memory (make check-faults); else of 8192.
# SPDX-License-Identifier: GPL-3.0-or-later
import collections
import base64
import json
import os
import pathlib
import resource
import struct
import subprocess

import pytest

import boxes
import damage
import small_scene
from conftest import ROOT

SUN = ("--sun", "-0.4,-1,-0.2")


# --- time -----------------------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("pile", [boxes.coinciding, boxes.nested])
def test_deep_piles_take_time_like_their_triangles(vxs_path, tmp_path, pile):
    """8000 boxes: some two seconds of a processor; 100 and 40, when every layer was compared with every other."""
    scene = boxes.write(tmp_path / "pile.glb", pile(8000))
    done = subprocess.run([vxs_path, "bake", scene, "-o", tmp_path / "a.vxs", *SUN, "--resolution", "64"],
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (15, 15)), capture_output=True)
    assert done.returncode == 0, done


def test_peeling_is_bounded(vxs, tmp_path):
    """However many solids are open at once, 255 passes end it; the plan knows."""
    scene = boxes.write(tmp_path / "nest.glb", boxes.nested(300))
    options = (*SUN, "--resolution", 16, "--maps", "gl", "--closed", "on", "--json", tmp_path / "b.json")
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *options)
    light = json.loads((tmp_path / "b.json").read_text())["lights"][0]
    assert light["peel_passes_max"] == 255 and light["blocks_peeled"] == 1


# --- memory, from outside of the process ----------------------------------------------------------------------------------------------

MIB = 1 << 20
# what is not worth a look before it is taken: libraries, stacks, arrays of less than a mebibyte
TOLERANCE = 8 * MIB


@pytest.fixture(scope="session")
def outside(vxs_path, tmp_path_factory):
    """run(*args): the command, and the most that it has held as the system tells its parent."""
    if b"__asan_init" in vxs_path.read_bytes() or b"__tsan_init" in vxs_path.read_bytes():
        pytest.skip("a sanitizer needs memory of its own")
    folder = tmp_path_factory.mktemp("peak")
    subprocess.run([os.environ.get("CC", "cc"), "-O1", "-o", folder / "peak", ROOT / "tests" / "faults" / "peak.c"], check=True)
    outcome = collections.namedtuple("outcome", "returncode peak stderr")

    def run(*args, **limits):
        done = subprocess.run([folder / "peak", folder / "bytes", vxs_path, *map(str, args)], capture_output=True, text=True,
                              timeout=600, **limits)
        return outcome(done.returncode, int((folder / "bytes").read_text()), done.stderr)

    return run


def refused(done):
    *warnings, error = done.stderr.splitlines()
    return done.returncode == 6 and error.startswith("vxs: error: ") and all(line.startswith("vxs: warning: ") for line in warnings)


EVERY, LARGE = (bool(os.environ.get(name)) for name in ("VXS_EVERY_SCENE", "VXS_LARGE"))


def real_scenes():
    folder = pathlib.Path(os.environ.get("VXS_SCENES", ROOT.parent / "shared" / "scenes")) / "real"
    return sorted(path.stem for path in folder.glob("*.glb"))


FINE = [(name, resolution, coding) for name in ("sponza", "stanford_bunny_closed", "room_with_spheres_closed")
        for resolution in (16384, 65536) for coding in ("dag", "blocks")]


@pytest.mark.slow
@pytest.mark.parametrize("name, resolution, coding", [(name, resolution, "blocks") for name in real_scenes() for resolution in (1024, 4096)]
                         + FINE if EVERY else [("kaykit_city", 2048, "blocks"), ("sunlit_primitives", 2048, "blocks")])
def test_memory_is_a_promise(outside, scenes, tmp_path, name, resolution, coding):
    """At twice of what a bake needs it succeeds and stays below; at half of it, and all the way up, it does, or is refused and stays
    below all the same."""
    scene, out = scenes / "real" / f"{name}.glb", tmp_path / "a.vxs"
    bake = ("bake", scene, "-o", out, *SUN, "--resolution", resolution, "--coding", coding)
    free = outside(*bake)
    assert free.returncode == 0, free
    whole = out.read_bytes()
    done = outside(*bake, "--memory", 2 * free.peak)
    assert done.returncode == 0 and done.peak <= 2 * free.peak and out.read_bytes() == whole, done
    out.unlink()
    for share in (0.2, 0.5, 0.75, 1.1) if EVERY else (0.5, 0.9):
        budget = int(share * free.peak)
        done = outside(*bake, "--memory", budget)
        assert done.returncode == 0 or refused(done), done
        assert done.peak <= budget + TOLERANCE, (share, budget, done)
        assert out.exists() == (done.returncode == 0) and (not out.exists() or out.read_bytes() == whole)
        out.unlink(missing_ok=True)


@pytest.mark.slow
@pytest.mark.parametrize("options", [(), ("--coding", "dag"), ("--resume", "kept")], ids=["blocks", "dag", "resume"])
def test_a_large_map_with_half_the_memory(outside, vxs, tmp_path, options):
    """By --memory, and by the address space: the same bytes, or one line; and the same bytes in the end, with what was kept."""
    out, options = tmp_path / "a.vxs", (*options[:-1], tmp_path / "kept") if "--resume" in options else options
    vxs("scene", "city", "--triangles", 100000 if LARGE else 20000, "-o", tmp_path / "city.glb")
    bake = ("bake", tmp_path / "city.glb", "-o", out, "--resolution", 65536 if LARGE else 8192, "--threads", 2, *options)
    free = outside(*bake)
    assert free.returncode == 0, free
    whole, statuses = out.read_bytes(), []
    for share in (0.5, 0.75, 1, 1.5):
        out.unlink()
        room = int(share * free.peak)
        done = outside(*bake, "--memory", room)
        assert done.returncode == 0 or refused(done), (share, done)
        assert done.peak <= room + TOLERANCE and out.exists() == (done.returncode == 0), (share, done)
        limited = outside(*bake, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (60 * MIB + room, 60 * MIB + room)))
        assert limited.returncode == 0 or refused(limited), (share, limited)
        statuses += [done.returncode, limited.returncode]
        if statuses[-2:] == [6, 6]:
            assert not out.exists()
            assert outside(*bake).returncode == 0
        assert out.read_bytes() == whole
    assert statuses[0] == 6


@pytest.mark.parametrize("maps", ["gl", "sparse"])
def test_the_report_tells_what_the_system_tells(outside, scenes, tmp_path, maps):
    done = outside("bake", scenes / "real" / "kaykit_city.glb", "-o", tmp_path / "a.vxs", *SUN, "--resolution", 2048, "--maps", maps,
                   "--json", tmp_path / "a.json")
    assert done.returncode == 0, done
    told = json.loads((tmp_path / "a.json").read_text())["peak_bytes"]
    assert done.peak - TOLERANCE <= told <= done.peak + TOLERANCE


def many_instances(path, count):
    """A box, placed very often by an accessor that needs no bytes: a small file that unfolds."""
    positions = struct.pack("<24f", *(c >> axis & 1 for c in range(8) for axis in range(3)))
    indices = bytes(i for a, b, c, d in small_scene.FACES for i in (a, b, c, a, c, d))
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": 132, "uri": "data:application/octet-stream;base64," + base64.b64encode(positions + indices).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8, "min": [0] * 3, "max": [1] * 3},
                      {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 36},
                      {"componentType": 5126, "type": "VEC3", "count": count}],
    }
    path.write_text(json.dumps(gltf, separators=(",", ":")))
    assert path.stat().st_size < 1000
    return path


def test_a_small_file_that_unfolds(outside, tmp_path):
    """4 M boxes in less than 1000 bytes: refused from counts, before they are made. Without --memory it is what there is that counts."""
    scene = many_instances(tmp_path / "many.gltf", 4000000)
    counts = "48000000 triangles with 32000000 vertices, meshes placed 4000000 times"
    done = outside("bake", scene, "-o", tmp_path / "a.vxs", *SUN, "--memory", "2G")
    assert refused(done) and counts in done.stderr and "--memory allows 2.00 GiB" in done.stderr and done.peak < 32 * MIB
    for command in (("bake", scene, "-o", tmp_path / "a.vxs", *SUN), ("health", scene), ("plan", scene, *SUN)):
        done = outside(*command, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30)))
        assert refused(done) and counts in done.stderr and " left" in done.stderr and done.peak < 32 * MIB, done


def test_files_are_counted_before_they_are_read(outside, tmp_path):
    """The scene's own, and one beside it: each is named once."""
    small_scene.write(tmp_path / "large.gltf")
    gltf = json.loads((tmp_path / "large.gltf").read_text())
    gltf["buffers"][0] = {"uri": "a.bin", "byteLength": 64 * MIB}
    (tmp_path / "beside.gltf").write_text(json.dumps(gltf))
    for file, scene, named in (("large.gltf", "large.gltf", "the file"), ("a.bin", "beside.gltf", f"the file '{tmp_path / 'a.bin'}'")):
        with (tmp_path / file).open("ab") as f:
            f.truncate(64 * MIB)
        done = outside("bake", tmp_path / scene, "-o", tmp_path / "a.vxs", *SUN, "--memory", "32M")
        assert refused(done) and f"'{tmp_path / scene}': {named}: this needs about " in done.stderr, done


def test_memory_of_json_is_counted_before_it_is_read(outside, tmp_path):
    nodes = {"asset": {"version": "2.0"}, "nodes": [{"translation": [n, 0, 0]} for n in range(200000)]}
    (tmp_path / "nodes.gltf").write_text(json.dumps(nodes))
    done = outside("bake", tmp_path / "nodes.gltf", "-o", tmp_path / "a.vxs", *SUN, "--memory", "60M")
    assert refused(done) and "values in" in done.stderr and done.peak < 60 * MIB + TOLERANCE


@pytest.mark.slow
def test_memory_of_a_deep_pile(outside, tmp_path):
    """20 000 boxes in one place, all over a map: lists of what lies where, and triangles on their way through OpenGL, stay bounded."""
    scene = boxes.write(tmp_path / "pile.glb", boxes.coinciding(20000))
    done = outside("plan", scene, *SUN, "--resolution", 4096)
    assert done.returncode == 0 and done.peak < 200 * MIB, done
    done = outside("bake", scene, "-o", tmp_path / "a.vxs", *SUN, "--resolution", 16, "--exit", "back")
    assert done.returncode == 0 and done.peak < 110 * MIB, done


@pytest.mark.parametrize("threads", [1, 4])
def test_a_small_stack(vxs_path, tmp_path, threads):
    """ulimit -s 64: commands and their threads, those of Mesa and Embree, too, have stacks that are large enough."""
    def run(*arguments):
        done = subprocess.run([vxs_path, *map(str, arguments)], capture_output=True, text=True,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_STACK, (65536, 65536)))
        assert done.returncode == 0 and not done.stderr, done
    scene, out = tmp_path / "a.glb", tmp_path / "a.vxs"
    run("scene", "city", "--triangles", 1000, "--blocks", 1, "-o", scene)
    run("bake", scene, "-o", out, "--resolution", 256, "--threads", threads)
    run("bake", scene, "-o", out, "--resolution", 256, "--threads", threads, "--maps", "gl")
    run("compare", scene, out, "--points", 1000, "--threads", threads)
    run("render", scene, out, "-o", tmp_path / "a.png", "--width", 32, "--height", 32, "--fog", 0.01, "--threads", threads)


def test_first_bytes_tell(outside, vxs, tmp_path):
    """What is far too large, or has no end, and is not what was requested: nothing of it is read but its beginning."""
    scene = small_scene.write(tmp_path / "s.gltf")
    asset, huge, longer = tmp_path / "a.vxs", tmp_path / "huge", tmp_path / "longer.vxs"
    vxs("bake", scene, "-o", asset, "--resolution", 16)
    huge.touch()
    longer.write_bytes(asset.read_bytes())
    for path in (huge, longer):
        os.truncate(path, 20 << 30)
    draw = ("render", scene, asset, "-o", tmp_path / "a.png")
    for status, says, *command in (
            (3, "begins with 'NRRD000'", "bake", scene, "-o", tmp_path / "b.vxs", "--smoke"), (3, "finding 102", "info"),
            (3, "neither a Radiance picture", *draw, "--sky"), (3, "is no text", *draw, "--path"), (3, "is no part of a bake", "merge", "-o", tmp_path / "b.vxs"),
            (3, "not JSON", "report", "-o", tmp_path / "b.html"), (3, "nothing but zeros", "bench", "-o", tmp_path / "b.json"),
            (3, "not JSON", "compare", scene, asset, "--points", 10, "--bake-report")):
        files = ("/dev/stdin",) if command[0] == "bench" else (huge, "/dev/zero", "/dev/stdin")
        for path in files:
            with subprocess.Popen(["cat", "/dev/zero"], stdout=subprocess.PIPE) as endless:
                done = outside(*command, path, stdin=endless.stdout)
                endless.kill()
            of_zeros = "nothing but zeros" in done.stderr  # of a regular file, which is looked at before it is opened, and of a scene
            assert done.returncode == status and (of_zeros or says in done.stderr) and done.stderr.count("\n") == 1 and done.peak < 32 * MIB, (command, path, done)
    assert "finding 107" in outside("info", longer).stderr
    for path in (huge, longer):  # an output that is no asset is none that is current
        done = outside("bake", scene, "-o", path, "--resolution", 16, "--if-changed", "--quiet")
        assert done.returncode == 0 and done.peak < 32 * MIB and path.stat().st_size < 20000


def test_smoke_is_read_within_the_memory(outside, tmp_path):
    """By what its header says, of a file and of a pipe, and no further."""
    scene, grid = small_scene.write(tmp_path / "s.gltf"), tmp_path / "a.nrrd"
    for size, memory, says in ((512, "64M", "--memory allows 64.0 MiB"), (4096, "1T", "larger than 16.0 GiB")):
        with grid.open("wb") as file:
            file.write(b"NRRD0004\ntype: float\ndimension: 3\nsizes: %d %d %d\nencoding: raw\nendian: little\nspacings: 1 1 1\n\n" % (size, size, size))
            file.truncate(file.tell() + 4 * size ** 3)
        with grid.open("rb") as given:
            for path, stdin in ((grid, None), ("-", given)):
                done = outside("bake", scene, "-o", tmp_path / "a.vxs", "--smoke", path, "--memory", memory, stdin=stdin)
                assert refused(done) and says in done.stderr and done.peak < 100 * MIB, done


# --- assets ---------------------------------------------------------------------------------------------------------------------------


def test_a_small_asset_that_unfolds(outside, vxs, tmp_path):
    """256 MiB of metadata in a file of less than 32 KiB: query and an engine never inflate it, the others stop at 64 MiB by default."""
    vxs("bake", small_scene.write(tmp_path / "s.gltf"), "-o", tmp_path / "a.vxs", "--resolution", 16)
    asset = damage.Asset(tmp_path / "a.vxs")
    asset.contents["META", damage.NONE, 0] = b'"' + b" " * (256 * MIB) + b'"'
    path = asset.write(tmp_path / "b.vxs")
    assert path.stat().st_size < 32768
    done = outside("query", path, stdin=subprocess.DEVNULL)
    assert done.returncode == 0 and done.peak < 32 * MIB
    done = outside("info", path)
    assert refused(done) and "finding 211" in done.stderr and "--memory" in done.stderr and done.peak < 90 * MIB
    assert outside("validate", path).returncode == 1
    for command in ("info", "validate"):
        assert outside(command, path, "--memory", "1G").returncode == 0
    assert refused(outside("query", tmp_path / "a.vxs", "--memory", 500, stdin=subprocess.DEVNULL))


# --- same bytes -----------------------------------------------------------------------------------------------------------------------


def test_classes_of_processors(vxs, scenes, tmp_path, monkeypatch):
    """Same class, same bytes, and the report says which; on the least of them, whatever the bytes, no answer is wrong."""
    scene, files = scenes / "real" / "sunlit_primitives.glb", {}
    for name in ("found", "again", "sse2", "sse2-again"):
        if name == "sse2":
            monkeypatch.setenv("GALLIUM_OVERRIDE_CPU_CAPS", "sse2")
        out, report = tmp_path / f"{name}.vxs", tmp_path / f"{name}.json"
        said = vxs("bake", scene, "-o", out, *SUN, "--resolution", 512, "--maps", "gl", "--json", report, "--verbose").stdout
        cpu_class = json.loads(report.read_text())["cpu_class"]
        assert f"processors of class {cpu_class}\n" in said
        files[name] = cpu_class, out.read_bytes()
    assert files["found"] == files["again"] and files["sse2"] == files["sse2-again"] and files["sse2"][0] == "sse2"
    assert files["found"][0] != "sse2" or files["found"] == files["sse2"]
    for name in ("found", "sse2"):
        done = vxs("compare", scene, tmp_path / f"{name}.vxs", "--points", 20000, "--json", tmp_path / "c.json")
        assert '"unexplained": 0' in (tmp_path / "c.json").read_text(), done.stdout


# --- address space --------------------------------------------------------------------------------------------------------------------


def least_to_start(vxs_path):
    """MiB of address space in which the command just starts."""
    low, high = 20, 150
    while high - low > 0.25:
        middle = (low + high) / 2
        started = subprocess.run([vxs_path, "--version"], capture_output=True, preexec_fn=lambda: limit_address_space(middle)).returncode == 0
        low, high = (low, middle) if started else (middle, high)
    return high


def limit_address_space(mib):
    resource.setrlimit(resource.RLIMIT_AS, (int(mib * MIB), int(mib * MIB)))


@pytest.mark.parametrize("maps, limits", [("gl", range(150, 1400, 25)), ("sparse", range(0, 82, 2))])
def test_address_space_that_ends(vxs_path, tmp_path, maps, limits):
    """Whatever the limit, a bake succeeds or gives the reason not: Mesa is not begun where it would run out."""
    scene, out, statuses = small_scene.write(tmp_path / "s.gltf"), tmp_path / "a.vxs", []
    first = least_to_start(vxs_path) if maps == "sparse" else 0
    for mib in limits:
        done = subprocess.run([vxs_path, "bake", scene, "-o", out, "--resolution", "512", "--threads", "2", "--maps", maps],
                              capture_output=True, text=True, preexec_fn=lambda: limit_address_space(first + mib))
        assert done.returncode == 0 and not done.stderr or refused(done), (mib, done)
        statuses.append(done.returncode)
    assert statuses[0] == 6 and not any(statuses[-10 if maps == "gl" else 8:])
    if maps == "gl":  # the C library reserves arenas of 64 MiB for threads where it can, so a bake may succeed with less by chance
        assert not any(statuses[statuses.index(0) + 3:])


# --- limits on files ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["json", "page", "render", "standard output", "printed"])
def test_limit_on_the_size_of_any_file(vxs, vxs_path, tmp_path, kind):
    """SIGXFSZ is no death: one line, exit status 4, and the file is not there in part."""
    scene, asset, out = small_scene.write(tmp_path / "s.gltf"), tmp_path / "a.vxs", tmp_path / "out"
    vxs("bake", scene, "-o", asset, "--resolution", 16)
    command = {"json": ("info", asset, "--json", out),
               "page": ("bake", scene, "-o", asset, "--resolution", 16, "--report", out),
               "render": ("render", scene, asset, "-o", out, "--width", 64, "--height", 64),
               "standard output": ("bake", scene, "-o", "-", "--resolution", 16),
               "printed": ("info", asset)}[kind]
    with open(tmp_path / "stdout", "wb") as stdout:
        done = subprocess.run([vxs_path, *map(str, command)], stdout=stdout, stderr=subprocess.PIPE, text=True,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (400, 400)))
    assert done.returncode == 4 and "File too large" in done.stderr and not out.exists(), done
    assert [line for line in done.stderr.splitlines() if line.startswith("vxs: error: ")] == done.stderr.splitlines()[-1:], done
