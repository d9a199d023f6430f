# What disks, memory and people do to a run: kills at random and at chosen moments, full disks, files cut short or changed, calls
# that fail, closed standard streams, interrupts. Every time: one clear line and the exit status for it, and the old output as it
# was. VXS_EVERY_BIT=1 checks every prefix and every flipped bit of a file instead of one bit in each third byte (two minutes more);
# the unit tests of the format always do. VXS_EVERY_ALLOCATION=1 lets every allocation of a bake fail instead of one at each place
# that allocates.
# SPDX-License-Identifier: GPL-3.0-or-later
import collections
import concurrent.futures
import ctypes
import errno
import json
import os
import random
import resource
import shutil
import signal
import statistics
import subprocess
import tempfile
import time

import pytest

import small_scene
from conftest import ROOT, open_terminal
from small_scene import MORNING, NOON

SMALL = ("--resolution", "64", "--threads", "2")
OLD = b"the output of an earlier run"
EVERY_ALLOCATION = bool(os.environ.get("VXS_EVERY_ALLOCATION"))
TEMPORARY = ".vxs-*.tmp"


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene")
    return small_scene.write(folder / "two.gltf", lights=(("noon", "directional", NOON), ("morning", "directional", MORNING)))


@pytest.fixture(scope="module")
def asset(vxs, scene):
    """A file with two lights: what every complete bake of the scene gives."""
    path = scene.with_suffix(".vxs")
    vxs("bake", scene, "-o", path, *SMALL)
    return path.read_bytes()


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    path = tmp_path_factory.mktemp("city") / "city.glb"
    vxs("scene", "city", "-o", path)
    return path


def one_error_line(done):
    text = done.stderr if isinstance(done.stderr, str) else done.stderr.decode()
    return text.startswith("vxs: error: ") and text.count("\n") == 1


# --- files cut short or changed -------------------------------------------------------------------------------------------------------


def changed_files(data):
    """A name and bytes for prefixes, one byte more, and a flipped bit of each third byte; or for every prefix, and all bits."""
    everything = bool(os.environ.get("VXS_EVERY_BIT"))
    for size in range(len(data)):
        if not everything and size > 64 and size < len(data) - 64 and size % 12:
            continue
        yield f"the first {size} bytes", data[:size]
    yield "a byte more", data + b"\0"
    for at in range(0, len(data), 1 if everything else 3):
        for bit in range(8) if everything else [at % 8]:
            yield f"byte {at} bit {bit}", data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1:]


@pytest.mark.slow
def test_every_prefix_and_flipped_bit(vxs, vxs_path, scene, tmp_path):
    """Of a file with two lights: validate reports it, query refuses it."""
    vxs("bake", scene, "-o", tmp_path / "a.vxs", "--resolution", 8)
    data = (tmp_path / "a.vxs").read_bytes()
    assert vxs("validate", tmp_path / "a.vxs").returncode == 0 and data.count(b"LGHT") == 1

    def check(change):
        name, content = change
        path = tmp_path / (name.replace(" ", "-") + ".vxs")
        path.write_bytes(content)
        found = subprocess.run([vxs_path, "validate", path], capture_output=True, timeout=60)
        asked = subprocess.run([vxs_path, "query", path], capture_output=True, timeout=60, input=b"0 0 0\n")
        path.unlink()
        good = found.returncode == 1 and b": finding " in found.stdout and not found.stderr
        return name, good and asked.returncode == 3 and one_error_line(asked) and not asked.stdout

    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        results = list(pool.map(check, changed_files(data)))
    assert len(results) > len(data) / 3
    assert [name for name, good in results if not good] == []


# --- kills ----------------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def fault_library(vxs_path, tmp_path_factory):
    if b"__asan_init" in vxs_path.read_bytes() or b"__tsan_init" in vxs_path.read_bytes():
        pytest.skip("a sanitizer stands before libc's functions itself")
    library = tmp_path_factory.mktemp("fault") / "fault.so"
    subprocess.run([os.environ.get("CXX", "g++"), "-std=c++17", "-D_GNU_SOURCE", "-O1", "-fPIC", "-shared", "-o", library,
                    ROOT / "tests" / "faults" / "fault.cc", "-ldl"], check=True)
    return library


@pytest.fixture
def faulty(vxs_path, fault_library, tmp_path):
    """run(fault, *args, **environment): the command with a call that fails (tests/faults/fault.cc)."""

    def run(fault, *args, **environment):
        return subprocess.run([vxs_path, *map(str, args)], capture_output=True, timeout=120,
                              env=os.environ | {"LD_PRELOAD": str(fault_library), "FAULT": fault} | environment)

    def places(call, *args, **environment):
        """How many calls there are, and of each place in the code that makes one, which is its first."""
        done = run(f"{call}:0:0", *args, FAULT_COUNT=str(tmp_path / "count"), **environment)
        assert done.returncode == 0, done.stderr
        count, *first = map(int, (tmp_path / "count").read_text().split())
        (tmp_path / "count").unlink()
        return count, first

    run.places = places
    run.calls = lambda *args, **environment: places(*args, **environment)[0]
    return run


@pytest.mark.slow
@pytest.mark.parametrize("named", [False, True], ids=["nameless", "named"])
def test_kills_at_random_moments(vxs, vxs_path, fault_library, tmp_path, named):
    """50 of them, over a file that is there: it stays, or the new one is complete, and what is left behind disturbs no later run. A file
    without a name has one for a moment, at the check before the work and before it replaces the old one: rarely is one left."""
    environment = os.environ | ({"LD_PRELOAD": str(fault_library), "FAULT_NO_NAMELESS": "1"} if named else {})
    out, scene = tmp_path / "out" / "a.vxs", tmp_path / "city.glb"
    out.parent.mkdir()
    vxs("scene", "city", "-o", scene, "--triangles", 2000, "--blocks", 2)
    command = [vxs_path, "bake", scene, "-o", out, "--resolution", "512"]

    def run(seconds):
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment) as process:
            try:
                process.wait(seconds)
            except subprocess.TimeoutExpired:
                process.kill()
            assert process.stderr.read() == b""
        return process.returncode

    times = []
    for _ in range(3):
        begin = time.monotonic()
        assert run(60) == 0
        times.append(time.monotonic() - begin)
    new, seconds, chance = out.read_bytes(), statistics.median(times), random.Random(1)
    count = collections.Counter()
    for _ in range(50):
        out.write_bytes(OLD)
        begin = time.monotonic()
        status = run(chance.uniform(0, 1.05 * seconds))
        if status == 0:  # moments lie in the shortest bake so far: machines get faster when others have done
            seconds = min(seconds, time.monotonic() - begin)
        count[status] += 1
        assert out.read_bytes() in (OLD, new)
        left = {p for p in out.parent.iterdir() if p != out}
        assert all(p.match(TEMPORARY) for p in left)
    assert set(count) <= {0, -signal.SIGKILL} and count[-signal.SIGKILL] >= 25
    assert run(60) == 0 and out.read_bytes() == new
    assert named or len(left) <= 5


@pytest.mark.slow
@pytest.mark.parametrize("named", [False, True], ids=["nameless", "named"])
@pytest.mark.parametrize("call", ["open", "write", "close", "link", "rename"])
def test_kill_at_a_call(faulty, scene, asset, tmp_path, call, named):
    """At the last calls of a run, when the file gets its name. A complete one without it is the most that is left."""
    out, options = tmp_path / "a.vxs", {"FAULT_NO_NAMELESS": "1"} if named else {}
    bake = ("bake", scene, "-o", out, *SMALL)
    calls = faulty.calls(call, *bake, **options)
    outcomes = collections.Counter()
    for n in range(max(1, calls - 5), calls + 1):
        out.write_bytes(OLD)
        assert faulty(f"{call}:{n}:kill", *bake, **options).returncode == -signal.SIGKILL
        left = [p for p in tmp_path.iterdir() if p != out]
        outcomes["old" if out.read_bytes() == OLD else "new", len(left)] += 1
        assert out.read_bytes() in (OLD, asset) and all(p.match(TEMPORARY) for p in left)
        assert named or all(p.read_bytes() == asset for p in left)
        assert faulty("none:0:0", *bake, **options).returncode == 0 and out.read_bytes() == asset
        for p in left:
            p.unlink()
    if call == "rename":
        assert outcomes == {("old", 1): 1}, "the moment between the two names"
    if call == "link" and not named:
        assert outcomes == {("old", 0): calls}


# --- calls that fail ------------------------------------------------------------------------------------------------------------------


def check_fault(done, out, new, allowed):
    """It worked and the output is right, or it says in one line that it did not and the old output is there. Nothing else is."""
    assert [p.name for p in out.parent.iterdir()] == [out.name]
    if done.returncode == 0:
        assert out.read_bytes() == new and not done.stderr
    else:
        assert done.returncode in allowed and one_error_line(done) and out.read_bytes() == OLD, (done.returncode, done.stderr)


@pytest.mark.parametrize("call, number, status", [
    ("open", errno.EMFILE, 3), ("read", errno.EIO, 3), ("write", errno.ENOSPC, 4), ("write", errno.EIO, 4), ("write", errno.EDQUOT, 4),
    ("write", errno.EINTR, 4), ("close", errno.EIO, 4), ("link", errno.EPERM, 4), ("rename", errno.EXDEV, 4), ("thread", errno.EAGAIN, None)])
def test_failing_call(faulty, scene, asset, tmp_path, call, number, status):
    """The first and the last calls of each kind, which are those for the scene and for the asset. Some do not matter: /proc, and the
    look at what kind of file the scene is."""
    out = tmp_path / "a.vxs"
    bake = ("bake", scene, "-o", out, *SMALL)
    calls, statuses = faulty.calls(call, *bake), set()
    for n in sorted({*range(1, min(calls, 6) + 1), *range(max(1, calls - 3), calls + 1)}):
        out.write_bytes(OLD)
        done = faulty(f"{call}:{n}:{number}", *bake)
        check_fault(done, out, asset, {status, 4})  # the output's folder is opened, too
        statuses.add(done.returncode)
        assert not done.returncode or os.strerror(number).encode() in done.stderr
    assert status is None or status in statuses


@pytest.mark.parametrize("what", ["short", str(errno.EINTR)])
def test_reads_that_fall_short(faulty, scene, asset, tmp_path, what):
    out = tmp_path / "a.vxs"
    bake = ("bake", scene, "-o", out, *SMALL)
    for n in range(1, 4):
        done = faulty(f"read:{n}:{what}", *bake, **({"FAULT_EVERY": "1"} if what == "short" else {}))
        assert done.returncode == 0 and out.read_bytes() == asset, done.stderr
    for command, expected in (("validate", f"{out}: valid\n"), ("query", "")):
        done = faulty("read:1:short", command, out, FAULT_EVERY="1")
        assert done.returncode == 0 and done.stdout.decode() == expected


def test_reads_of_an_asset_that_fail(faulty, asset, tmp_path):
    """The first read looks at what kind of file it is, and may fail."""
    path = tmp_path / "a.vxs"
    path.write_bytes(asset)
    for command in ("validate", "query", "info"):
        done = faulty(f"read:2:{errno.EIO}", command, path)
        assert done.returncode == 3 and one_error_line(done) and b"Input/output error" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("source, every", [("", False), ("", True), ("libzstd", False)], ids=["vxs", "vxs-from-then-on", "zstd"])
def test_failing_allocation_of_bake(faulty, scene, asset, tmp_path, source, every):
    """One at each place that allocates; where all fail from then on, a sample; every one of zstd's. What Mesa and LLVM allocate
    themselves is left alone: they end the process then."""
    out = tmp_path / "a.vxs"
    bake = ("bake", scene, "-o", out, *SMALL)
    options = ({"FAULT_FROM": source} if source else {}) | ({"FAULT_EVERY": "1"} if every else {})
    calls, places = faulty.places("alloc", *bake, **options)
    sample = [*range(2, calls, max(1, calls // 40)), *range(max(2, calls - 30), calls + 1, 6)]
    statuses = collections.Counter()
    for n in sorted({1, calls, *(sample if every else range(1, calls + 1) if source or EVERY_ALLOCATION else places)}):
        out.write_bytes(OLD)
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", *bake, **options)
        check_fault(done, out, asset, {6})
        assert not done.returncode or b"out of memory" in done.stderr
        statuses[done.returncode] += 1
    assert statuses[6] >= (4 if source else 30 if every else len(places) // 2)


@pytest.mark.slow
@pytest.mark.long
def test_failing_allocation_of_a_dag(faulty, vxs, scene, tmp_path):
    out = tmp_path / "a.vxs"
    bake = ("bake", scene, "-o", out, *SMALL, "--coding", "dag")
    vxs(*bake)
    asset, (calls, places) = out.read_bytes(), faulty.places("alloc", *bake)
    statuses = collections.Counter()
    last = range(max(1, calls - 100), calls + 1)  # among them those of the metadata's text
    for n in sorted({*last, *(range(1, calls + 1) if EVERY_ALLOCATION else places)}):
        out.write_bytes(OLD)
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", *bake)
        check_fault(done, out, asset, {6})
        assert not done.returncode or b"out of memory" in done.stderr
        statuses[done.returncode] += 1
    assert statuses[6] >= len(places) // 2


@pytest.mark.parametrize("kind", ["render", "forest"])
@pytest.mark.parametrize("source", ["", "libpng"], ids=["vxs", "png"])
def test_failing_allocation_of_an_image(faulty, scene, asset, tmp_path, kind, source):
    baked, options = tmp_path.parent / "image.vxs", {"FAULT_FROM": source} if source else {}
    out = tmp_path / ("a.png" if kind == "render" else "a.glb")
    baked.write_bytes(asset)
    command = (("render", scene, baked, "-o", out, "--draw", "rays", "--width", 64, "--height", 36, "--threads", 1) if kind == "render" else
               ("scene", "forest", "-o", out, "--triangles", 1000))
    assert faulty("none:0:0", *command).returncode == 0
    new, calls, statuses = out.read_bytes(), faulty.calls("alloc", *command, **options), collections.Counter()
    for n in sorted({*range(1, calls, max(1, calls // 20)), *range(max(1, calls - 10), calls + 1)}):
        out.write_bytes(OLD)
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", *command, **options)
        check_fault(done, out, new, {6})
        assert not done.returncode or b"out of memory" in done.stderr
        statuses[done.returncode] += 1
    assert statuses[6] >= (1 if source else 5)


@pytest.mark.parametrize("command", ["validate", "query", "info"])
@pytest.mark.parametrize("source", ["", "libzstd"], ids=["vxs", "zstd"])
def test_every_failing_allocation_of_a_reader(faulty, asset, tmp_path, command, source):
    path, options = tmp_path / "a.vxs", {"FAULT_FROM": source} if source else {}
    path.write_bytes(asset)
    whole = faulty("none:0:0", command, path).stdout
    calls = faulty.calls("alloc", command, path, **options)
    for n in range(1, calls + 1):
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", command, path, **options)
        if done.returncode:
            assert done.returncode == 6 and one_error_line(done) and b"out of memory" in done.stderr, (n, done)
        else:
            assert done.stdout == whole, n


def test_failing_allocation_of_embree(vxs, faulty, scene, asset, tmp_path):
    """It says of some that they failed, of others that something did: none is the fault of the scene."""
    (tmp_path / "a.vxs").write_bytes(asset)
    command, options = ("truth", scene, "--like", tmp_path / "a.vxs", "--threads", 1), {"FAULT_FROM": "libembree"}
    calls, failed = faulty.calls("alloc", *command, **options), 0
    for n in range(1, calls + 1, 1 if EVERY_ALLOCATION else 3):
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", *command, **options)
        assert not done.returncode or (done.returncode == 6 and one_error_line(done)), (n, done)
        failed += done.returncode == 6
    assert failed >= calls / 6


@pytest.mark.slow
def test_failing_allocation_of_bench(vxs, faulty, scene, tmp_path, monkeypatch):
    """In itself, and in the bake that it starts. When the measurements are written, only the tables may be missing."""
    temporary, old, new = tmp_path / "temporary", tmp_path / "old.json", tmp_path / "new.json"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    bench = ("bench", scene, *SMALL, "--runs", 1, "--points", 0)
    vxs(*bench, "-o", old)
    bench += ("-o", new, "--against", old)
    calls, failed = faulty.calls("alloc", *bench), 0
    for n in range(1, calls, max(1, calls // 25)):
        new.unlink(missing_ok=True)
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", *bench)
        assert not done.returncode or (done.returncode == 6 and one_error_line(done) and b"out of memory" in done.stderr), (n, done)
        assert list(temporary.iterdir()) == [] and (not new.exists() or json.loads(new.read_text())["cells"])
        failed += done.returncode == 6
        done = faulty(f"alloc:{n}:{errno.ENOMEM}", *bench, FAULT_EVERY="1")
        assert (done.returncode or n > 0.9 * calls) and list(temporary.iterdir()) == [], (n, done)  # times decide how many calls there are
    assert failed >= 20


# --- disks and folders ----------------------------------------------------------------------------------------------------------------


@pytest.fixture
def small_disk(tmp_path):
    """A file system of one mebibyte."""
    if os.geteuid() != 0:
        pytest.skip("only root may mount a file system")
    libc, folder = ctypes.CDLL(None, use_errno=True), tmp_path / "disk"
    folder.mkdir()
    if libc.mount(b"none", os.fsencode(folder), b"tmpfs", 0, b"size=1m"):
        pytest.skip(f"tmpfs cannot be mounted here: {os.strerror(ctypes.get_errno())}")
    yield folder
    libc.umount2(os.fsencode(folder), 2)


@pytest.mark.slow
def test_full_disk(vxs, vxs_path, city, small_disk):
    out = small_disk / "a"
    out.write_bytes(OLD)
    for command in (("bake", city, "-o", out, "--resolution", 8192, "--coding", "dag"),
                    ("scene", "city", "-o", out)):
        done = vxs(*command, status=4)
        assert one_error_line(done) and f"{out}: cannot write: No space left on device" in done.stderr
        assert out.read_bytes() == OLD and list(small_disk.iterdir()) == [out]
    (small_disk / "filler").write_bytes(bytes(shutil.disk_usage(small_disk).free))
    assert "No space left" in vxs("bake", city, "-o", out, *SMALL, status=4).stderr
    (small_disk / "filler").unlink()
    vxs("bake", city, "-o", out, *SMALL)
    vxs("validate", out)
    assert list(small_disk.iterdir()) == [out]


@pytest.mark.parametrize("limit", [1, 1000])
def test_limit_on_the_size_of_files(vxs_path, scene, tmp_path, limit):
    out = tmp_path / "a.vxs"
    out.write_bytes(OLD)
    done = subprocess.run([vxs_path, "bake", scene, "-o", out, *SMALL], capture_output=True, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    assert done.returncode == 4 and one_error_line(done) and f"{out}: cannot write: File too large" in done.stderr
    assert out.read_bytes() == OLD and list(tmp_path.iterdir()) == [out]


def test_folder_that_may_not_be_written(vxs_path, scene):
    """Root may write anywhere, so for root the command runs as nobody."""
    with tempfile.TemporaryDirectory() as name:
        folder = os.path.join(name, "locked")
        os.chmod(name, 0o755)
        shutil.copy(scene, name)
        os.mkdir(folder)
        with open(os.path.join(folder, "a.vxs"), "wb") as old:
            old.write(OLD)
        os.chmod(folder, 0o555)
        command = [vxs_path, "bake", os.path.join(name, scene.name), "-o", os.path.join(folder, "a.vxs"), *SMALL]
        try:
            done = subprocess.run(command, capture_output=True, text=True, **({"user": 65534} if os.geteuid() == 0 else {}))
        except PermissionError:
            pytest.skip("nobody else may run the command where it lies")
        finally:
            os.chmod(folder, 0o755)
        assert done.returncode == 4 and one_error_line(done) and "Permission denied" in done.stderr
        assert os.listdir(folder) == ["a.vxs"] and open(os.path.join(folder, "a.vxs"), "rb").read() == OLD


def test_output_that_is_a_folder(vxs, scene, tmp_path):
    done = vxs("bake", scene, "-o", tmp_path, *SMALL, status=4)
    assert one_error_line(done) and "it is a folder" in done.stderr and not list(tmp_path.iterdir())


# --- closed standard streams ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (1, 2), (0, 1, 2)])
def test_closed_standard_streams_and_bake(vxs_path, scene, asset, tmp_path, closed):
    """No file takes their numbers: nothing that is printed gets into the asset. A report without a reader is an error."""
    out = tmp_path / "a.vxs"
    done = subprocess.run([vxs_path, "bake", scene, "-o", out, *SMALL], preexec_fn=lambda: [os.close(n) for n in closed],
                          stdout=None if 1 in closed else subprocess.DEVNULL, stderr=None if 2 in closed else subprocess.PIPE)
    assert done.returncode == (4 if 1 in closed else 0)
    assert out.read_bytes() == asset and list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("closed, status, says", [(0, 3, b"standard input: cannot be read"), (1, 4, b"standard output: cannot be written")])
def test_closed_standard_streams_and_query(vxs_path, asset, tmp_path, closed, status, says):
    (tmp_path / "a.vxs").write_bytes(asset)
    (tmp_path / "points").write_text("0 0 0\n")
    with open(tmp_path / "points") as points:
        done = subprocess.run([vxs_path, "query", tmp_path / "a.vxs"], preexec_fn=lambda: os.close(closed), stdin=points,
                              stderr=subprocess.PIPE)
    assert done.returncode == status and says in done.stderr and one_error_line(done)


# --- interrupts -----------------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_interrupts_stop_a_long_bake(vxs_path, city, tmp_path):
    """At moments all over two seconds of work: within a second (ten times that on a busy machine), and nothing is left."""
    out = tmp_path / "a.vxs"
    out.write_bytes(OLD)
    took = []
    numbers = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
    for n, delay in enumerate([0.005, 0.02, 0.04, 0.06, 0.1, 0.2, 0.4, 0.8, 1.2]):
        with subprocess.Popen([vxs_path, "bake", city, "-o", out, "--resolution", "262144"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            time.sleep(delay)
            assert process.poll() is None
            number, begin = numbers[n % 3], time.monotonic()
            process.send_signal(number)
            process.send_signal(number)  # an impatient one
            process.wait(20)
            took.append(time.monotonic() - begin)
            # before main has begun, a signal does what it does by default
            assert process.returncode in ({130, -number} if delay < 0.05 else {130} if number == signal.SIGINT else {-number})
            assert process.stderr.read() == b""
        assert out.read_bytes() == OLD and list(tmp_path.iterdir()) == [out]
    assert statistics.median(took) < 1 and max(took) < 10


@pytest.mark.slow
def test_interrupt_in_every_stage(faulty, scene, tmp_path):
    """At allocations from the first to the last, which all stages make."""
    out = tmp_path / "a.vxs"
    bake = ("bake", scene, "-o", out, *SMALL)
    calls = faulty.calls("alloc", *bake)
    new = out.read_bytes()
    out.write_bytes(OLD)
    complete = ended = 0
    for n in range(1, calls + 1, max(1, calls // 40)):
        done = faulty(f"alloc:{n}:interrupt", *bake)
        if done.returncode == 0 and n > calls - 40:
            ended += 1  # the number of allocations varies a little with the times of threads: it ended before this one
            continue
        complete += out.read_bytes() == new  # the report is written when the file has its name
        assert out.read_bytes() in (OLD, new) and (not complete or out.read_bytes() == new)
        assert done.returncode == 130 and not done.stderr and list(tmp_path.iterdir()) == [out]
    assert complete <= 2 and ended <= 1


# --- progress -------------------------------------------------------------------------------------------------------------------------


def on_a_terminal(command, interrupt_at=None):
    """The exit status, and what came on standard error, which is a terminal; SIGINT once a text was seen there."""
    master, terminal = open_terminal()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=terminal) as process:
        os.close(terminal)
        said = b""
        while True:
            try:
                said += os.read(master, 4096)
            except OSError:  # no process has it open any more
                break
            if interrupt_at and interrupt_at in said:
                process.send_signal(signal.SIGINT)
                interrupt_at = None
    os.close(master)
    return process.returncode, said


CLEAR = b"\r\x1b[K"


@pytest.mark.slow
def test_progress_on_a_terminal(vxs_path, city, tmp_path):
    """Each stage is named before it begins, tiles come with an estimate, several times each, no line is longer than a terminal, and in
    the end none is left."""
    status, said = on_a_terminal([vxs_path, "bake", city, "-o", tmp_path / "a.vxs", "--resolution", "8192", "--maps", "gl"])
    lines = said.split(CLEAR)
    assert status == 0 and lines[0] == lines[-1] == b"" and b"\n" not in said
    assert all(line.startswith(b"vxs: ") and len(line) < 80 for line in lines[1:-1])
    for n, text in enumerate((b"reading ", b"telling solids", b"making a plan", b"light sun: square 1 of 4")):
        assert lines[1 + n].startswith(b"vxs: " + text)
    assert lines[-2].startswith(b"vxs: writing ")
    estimates = [int(line.split(b"about ")[1].split()[0]) for line in lines if b"about " in line]
    assert estimates and all(0 < seconds < 600 for seconds in estimates) and said.count(b"square 1 of 4") > 1


@pytest.mark.slow
def test_interrupt_takes_the_progress_away(vxs_path, city, tmp_path):
    status, said = on_a_terminal([vxs_path, "bake", city, "-o", tmp_path / "a.vxs", "--resolution", "16384"], interrupt_at=b"square 1 of")
    assert status == 130 and said.endswith(CLEAR) and list(tmp_path.iterdir()) == []


def test_error_after_progress(vxs_path, tmp_path):
    """It has a line of its own, which stays."""
    scene = small_scene.write(tmp_path / "no.gltf", lights=())
    status, said = on_a_terminal([vxs_path, "bake", scene, "-o", tmp_path / "a.vxs", "--color", "never"])
    assert status == 5 and said.split(CLEAR)[-1].startswith(b"vxs: error: ") and said.endswith(b"\n") and b"vxs: reading" in said
