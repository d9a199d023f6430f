# A bake by many processes: vxs-mpi, and what docs/farm.md shows, as it stands there: a makefile, a line of xargs, a job array of
# Slurm. The bytes are those of one process. What is not installed is skipped.
# VXS_KILLS: how many times a rank is killed (default 3; make check-faults: 50).
# SPDX-License-Identifier: GPL-3.0-or-later
import contextlib
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import time

import pytest

import small_scene

FARM = (pathlib.Path(__file__).resolve().parents[2] / "docs" / "farm.md").read_text()
LIGHTS = (("sun", "directional", (0.2, -1, 0.1)), ("lamp", "point", (0, -1, 0)), ("spot", "spot", (0.1, -1, 0.2)))
PILLARS = [((x - 0.3, 0, z - 0.3), (x + 0.3, 2, z + 0.3)) for x in range(-6, 7, 3) for z in range(-6, 7, 3)]
SIZES = ("--resolution", "sun=2048", "--resolution", "256")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("farm") / "scene.gltf", (small_scene.GROUND, *PILLARS), lights=LIGHTS)


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    """A city, options that make 64 squares of it, and the bytes of its file."""
    folder, options = tmp_path_factory.mktemp("city"), ("--resolution", "8192")
    vxs("scene", "city", "--triangles", "20000", "-o", folder / "city.glb")
    vxs("bake", folder / "city.glb", "-o", folder / "want.vxs", *options)
    return folder / "city.glb", options, (folder / "want.vxs").read_bytes()


# MPI


@pytest.fixture(scope="module")
def mpirun(vxs_path):
    """start(ranks, *args): vxs-mpi bake by so many ranks of a thread each. A list in args begins the line of the ranks after it: [1, ...]."""
    program = vxs_path.parent / "vxs-mpi"
    if not program.is_file() or not shutil.which("mpirun"):
        pytest.skip("no vxs-mpi or no mpirun: packages libopenmpi-dev and openmpi-bin, before vxs is built")
    environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}

    def start(ranks, *args):
        line = ["mpirun", "-q", "--oversubscribe", "--bind-to", "none"]
        for count, of in ((ranks, [a for a in args if not isinstance(a, list)]), *((a[0], a[1:]) for a in args if isinstance(a, list))):
            line += [":"] * (line[-1] != "none") + ["-n", count, program, "bake", *of, "--threads", "1"]
        return subprocess.Popen(list(map(str, line)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
                                stdin=subprocess.DEVNULL)

    return start


@pytest.fixture(scope="module")
def mpi(mpirun):
    """run(ranks, *args, status=0): the same, to its end: its output and its errors."""

    def run(*args, status=0):
        with mpirun(*args) as job:
            stdout, stderr = job.communicate(timeout=120)
        assert job.returncode == status, (job.returncode, stderr)
        return stdout, stderr

    return run


def squares(stdout):
    """Of a report: made, all, found."""
    return tuple(map(int, re.search(r"^squares      (\d+) of (\d+) made, (\d+) found in ", stdout, re.M).groups()))


@pytest.mark.parametrize("ranks, options", [(2, ()), (3, ("--coding", "dag")), (4, ("--pack", "fast", "--light", "sun")),
                                            (4, ("--coding", "dag", "--maps", "gl"))])
def test_same_bytes_by_many_ranks(vxs, mpi, scene, tmp_path, ranks, options):
    out, want, kept = tmp_path / "out.vxs", tmp_path / "want.vxs", tmp_path / "kept"
    vxs("bake", scene, "-o", want, *SIZES, *options)
    made, count, _ = squares(mpi(ranks, scene, "-o", out, *SIZES, *options, "--resume", kept)[0])
    assert made == count > ranks and out.read_bytes() == want.read_bytes()
    out.unlink()
    assert squares(mpi(ranks, scene, "-o", out, *SIZES, *options, "--resume", kept)[0]) == (0, count, count)
    assert out.read_bytes() == want.read_bytes()


def test_as_one_process_says_it(mpi, scene, tmp_path):
    """Reports once, help once, errors once, with their exit statuses."""
    out = tmp_path / "out.vxs"
    stdout, stderr = mpi(3, scene, "-o", out, *SIZES)
    assert stdout.count("\nfile ") == 1 and not stderr
    assert mpi(3, "--help")[0].count("vxs bake SCENE") == 1
    before = out.read_bytes()
    assert mpi(2, scene, "-o", out, *SIZES, "--if-changed")[0].startswith("up to date")
    for status, options, says in ((2, ("--resolution", "7"), "--resolution 7"), (2, ("--part", "1/2"), "--part makes a part"),
                                  (2, ("--report", tmp_path / "a.html"), "with several processes"), (6, ("--memory", "1M"), "memory")):
        _, stderr = mpi(2, scene, "-o", out, *options, status=status)
        assert re.fullmatch(f"vxs: error: .*{says}.*\n", stderr)
    assert re.fullmatch("vxs: error: several processes read the scene.*\n", mpi(2, "-", "-o", out, status=2)[1])
    assert re.fullmatch("vxs: error: cannot read.*\n", mpi(2, tmp_path / "none.glb", "-o", out, status=3)[1])
    assert out.read_bytes() == before


def test_ranks_that_are_not_alike(mpi, scene, city, tmp_path):
    """Another scene there, other options, or none of it: rank 0, which has enough to do until then, reports it."""
    out, (level, _, _), sizes = tmp_path / "out.vxs", city, ("--resolution", "32768")
    for there, status, says in (([scene, *sizes], 2, "rank 1 makes squares of another bake"),
                                ([level, *sizes, "--coding", "dag"], 2, "rank 1 makes squares of another bake"),
                                ([tmp_path / "none.glb", *sizes], 3, "rank 1: cannot read '.*none.glb'")):
        _, stderr = mpi(1, level, "-o", out, *sizes, [1, *there, "-o", out], status=status)
        assert re.fullmatch(f"vxs: error: {says}.*\n", stderr)
    assert not out.exists()


def ranks_of(job):
    return list(map(int, pathlib.Path(f"/proc/{job.pid}/task/{job.pid}/children").read_text().split()))


def test_a_rank_that_is_lost(mpirun, mpi, city, tmp_path):
    """The run ends, and leaves the whole file or none; the next one makes the squares that the cache lacks, and no more."""
    scene, options, want = city
    out, kept, rng = tmp_path / "out.vxs", tmp_path / "kept", random.Random(1)
    command = (3, scene, "-o", out, *options)
    begun = time.monotonic()
    mpi(*command, "--resume", tmp_path / "other")
    lasts = time.monotonic() - begun
    cut_short = 0
    for n in range(int(os.environ.get("VXS_KILLS", "3"))):
        shutil.rmtree(kept, ignore_errors=True)
        out.unlink(missing_ok=True)
        with mpirun(*command, "--resume", kept) as job:
            time.sleep(rng.uniform(0.3, 0.9) * lasts)
            found = ranks_of(job)
            for rank in found[n % 3:n % 3 + 1]:
                with contextlib.suppress(ProcessLookupError):  # it has just ended
                    os.kill(rank, signal.SIGKILL)
            job.communicate(timeout=60)
        lost = job.returncode == 128 + signal.SIGKILL
        assert lost or job.returncode == 0 and out.exists()
        assert not out.exists() or out.read_bytes() == want  # it may be there before a rank is lost that has nothing left to do
        there = len(list(kept.glob("*.square"))) if kept.exists() else 0
        stdout, stderr = mpi(*command, "--resume", kept)
        assert squares(stdout) == (64 - there, 64, there) and not stderr
        assert out.read_bytes() == want
        cut_short += lost
    assert cut_short


# what the page shows


def listing(name):
    """The text that follows its name in the page."""
    text = re.search(rf"`{name}`:\n\n((?:    .*\n)+)", FARM)[1]
    return re.sub("^    ", "", text, flags=re.M)


@pytest.fixture()
def level(vxs_path, scene, vxs, tmp_path, monkeypatch):
    """A folder with level.glb, the command in PATH; and the bytes of its file."""
    vxs("bake", scene, "-o", tmp_path / "want.vxs")
    shutil.copy(scene, tmp_path / "level.glb")
    monkeypatch.setenv("PATH", f"{vxs_path.parent}:{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    return (tmp_path / "want.vxs").read_bytes()


def test_make(level, tmp_path):
    (tmp_path / "Makefile").write_text(listing("Makefile"))
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}

    def made():
        done = subprocess.run(["make", "-j", "3", "level.vxs"], check=True, capture_output=True, text=True, env=environment)
        assert (tmp_path / "level.vxs").read_bytes() == level
        return done.stdout.count("vxs bake")

    assert made() == 8 and made() == 0
    (tmp_path / "level.3.part").unlink()
    assert made() == 1


def test_xargs(level, tmp_path):
    lines = re.search(r"Without `make`:\n\n((?:    .*\n)+)", FARM)[1]
    subprocess.run(["sh", "-e", "-c", lines], check=True, capture_output=True)
    assert (tmp_path / "level.vxs").read_bytes() == level


SLURM = """
ClusterName=one
SlurmctldHost={host}
AuthType=auth/munge
CryptoType=crypto/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPort={port}
SlurmdPort={next_port}
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
# jobs begin when they may, not at the next look in half a minute
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
MpiDefault=none
NodeName={host} CPUs={processors} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
"""


@pytest.fixture()
def slurm(tmp_path_factory, monkeypatch):
    """Slurm on this machine alone, with a daemon of each kind, which end with the test."""
    daemons = ("munged", "slurmctld", "slurmd")
    missing = [name for name in (*daemons, "sbatch") if not shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")]
    if missing or os.geteuid():
        pytest.skip(f"no Slurm: packages slurm-wlm and munge, and root, to start it: {', '.join(missing) or 'not root'}")
    folder, port, host = tmp_path_factory.mktemp("slurm"), random.randrange(20000, 30000), os.uname().nodename
    for name in ("state", "spool"):
        (folder / name).mkdir()
    folder.chmod(0o755)
    (folder / "key").write_bytes(os.urandom(1024))
    (folder / "key").chmod(0o400)
    (folder / "slurm.conf").write_text(SLURM.format(folder=folder, host=host, port=port, next_port=port + 1,
                                                    processors=len(os.sched_getaffinity(0))))
    monkeypatch.setenv("SLURM_CONF", str(folder / "slurm.conf"))
    monkeypatch.setenv("PATH", f"{os.environ['PATH']}:/usr/sbin:/sbin")
    lines = (["munged", "--force", f"--key-file={folder}/key", f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
              f"--log-file={folder}/munged.log", f"--seed-file={folder}/seed"], ["slurmctld"], ["slurmd"])
    try:
        for line in lines:
            subprocess.run(line, check=True, capture_output=True, timeout=30)
        until = time.monotonic() + 20
        while "idle" not in subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True).stdout:
            if time.monotonic() > until:
                pytest.skip("Slurm is there, and does not come up: " + (folder / "slurmctld.log").read_text()[-300:])
            time.sleep(0.2)
        yield
    finally:
        for name in reversed(daemons):
            if (folder / f"{name}.pid").exists():
                os.kill(int((folder / f"{name}.pid").read_text()), signal.SIGTERM)


@pytest.mark.slow
def test_slurm(slurm, level, tmp_path, mpirun):
    """The job array and the job that waits for it; then all of it by the ranks of one job."""
    for name in ("part.sh", "merge.sh", "submit.sh", "mpi.sh"):
        (tmp_path / name).write_text(listing(name))
    subprocess.run(["sh", "submit.sh"], check=True, capture_output=True, timeout=120)
    assert (tmp_path / "level.vxs").read_bytes() == level and len(list(tmp_path.glob("level.*.part"))) == 8
    (tmp_path / "level.vxs").unlink()
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    submit = re.search(r"`(sbatch --ntasks=)8 (mpi.sh)`", FARM)
    done = subprocess.run([*f"{submit[1]}{len(os.sched_getaffinity(0))}".split(), "--wait", submit[2]], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done
    assert (tmp_path / "level.vxs").read_bytes() == level
