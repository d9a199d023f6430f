# The square cache: bakes that go on after a kill, bakes after a change, and folders in which something is wrong. Whatever is there,
# the bytes are those of a bake without.
# VXS_KILLS: how many times a bake of each coding is killed (default 3; make check-faults: 50).
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import stat
import subprocess
import time

import jsonschema
import pytest

import small_scene

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPARSE = ("--maps", "sparse")
GL = ("--maps", "gl")
CODINGS = ("blocks", "dag")


def squares(done):
    """Of a report: made, all, found."""
    return tuple(map(int, re.search(r"^squares      (\d+) of (\d+) made, (\d+) found in ", done.stdout, re.M).groups()))


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    """A city, and its bakes without a folder, by their options."""
    folder = tmp_path_factory.mktemp("city")
    scene = folder / "city.glb"
    vxs("scene", "city", "--triangles", "20000", "-o", scene)
    baked = {}

    def want(*options):
        if options not in baked:
            out = folder / "want.vxs"
            vxs("bake", scene, "-o", out, *options)
            baked[options] = out.read_bytes()
        return baked[options]

    return scene, want


@pytest.mark.parametrize("coding", CODINGS)
@pytest.mark.parametrize("maps", (SPARSE, GL))
def test_same_bytes_at_any_number_of_threads(vxs, city, tmp_path, coding, maps):
    scene, want = city
    options = (*maps, "--coding", coding, "--resolution", "2048")
    out, cache, report = tmp_path / "out.vxs", tmp_path / "cache", tmp_path / "report.json"
    vxs("bake", scene, "-o", out, "--json", report, *options)
    found = json.loads(report.read_text())["lights"][0]
    made, count, _ = squares(vxs("bake", scene, "-o", out, "--resume", cache, "--threads", "1", *options))
    assert made == count == len(list(cache.iterdir())) == (16 if maps == SPARSE else 1)
    assert out.read_bytes() == want(*options)
    for threads in "1238":
        assert squares(vxs("bake", scene, "-o", out, "--resume", cache, "--threads", threads, *options)) == (0, count, count)
        assert out.read_bytes() == want(*options)
        (cache / sorted(os.listdir(cache))[int(threads) % count]).unlink()
        done = vxs("bake", scene, "-o", out, "--resume", cache, "--threads", threads, "--json", report, *options)
        assert squares(done) == (1, count, count - 1)
        told = json.loads(report.read_text())["lights"][0]
        assert all(told[key] == found[key] for key in ("mask_tiles", "levels", "size")) and found["mask_tiles"]
        assert out.read_bytes() == want(*options)


# a change of the scene

PILLARS = [((x - 0.3, 0, z - 0.3), (x + 0.3, 2, z + 0.3)) for x in range(-6, 7, 3) for z in range(-6, 7, 3)]


def scene_of(path, *moved):
    """The ground and pillars, and a block that stands somewhere."""
    return small_scene.write(path, (small_scene.GROUND, *PILLARS, *moved), lights=(
        ("sun", "directional", (0.2, -1, 0.1)), ("lamp", "point", (0, -1, 0)), ("spot", "spot", (0.1, -1, 0.2))))


@pytest.mark.parametrize("coding", CODINGS)
def test_only_squares_with_other_casters_are_made_again(vxs, tmp_path, coding):
    out, cache, report = tmp_path / "out.vxs", tmp_path / "cache", tmp_path / "report.json"
    schema = json.loads((ROOT / "docs/bake-report.schema.json").read_text())
    options = ("--coding", coding, "--resolution", "sun=4096", "--resolution", "512", *SPARSE)
    places = [((x, 0, z), (x + 0.4, 1, z + 0.4)) for x, z in ((1, 1), (1.2, 1.1), (-5, 4), (1, 1))]
    counts = []
    for place in places:
        scene = scene_of(tmp_path / "scene.gltf", place)
        counts.append(squares(vxs("bake", scene, "-o", out, "--resume", cache, "--json", report, *options)))
        made, count, was_found = counts[-1]
        assert made + was_found == count == len(list(cache.iterdir()))
        told = json.loads(report.read_text())
        jsonschema.validate(told, schema)
        assert told["squares"] == {"folder": str(cache), "made": made, "found": was_found}
        want = out.read_bytes()
        vxs("bake", scene, "-o", out, *options)
        assert out.read_bytes() == want
    made = [made for made, _, _ in counts]
    assert counts[0][0] == counts[0][1] > 16
    assert all(0 < m < counts[0][1] / 2 for m in made[1:]), counts


def test_a_light_of_its_own(vxs, tmp_path):
    """With a region, a sun's map stays where it is when a caster leaves the others' bounds; a light that is added finds those of the others."""
    out, cache = tmp_path / "out.vxs", tmp_path / "cache"
    options = (*SPARSE, "--resolution", "2048", "--region", "-6,0,-6,6,2,6", "--light", "sun")
    assert squares(vxs("bake", scene_of(tmp_path / "a.gltf"), "-o", out, "--resume", cache, *options))[0] == 16
    high = scene_of(tmp_path / "b.gltf", ((5.5, 2.5, 5.5), (5.9, 3.5, 5.9)))
    made, count, _ = squares(vxs("bake", high, "-o", out, "--resume", cache, *options))
    assert count == 16 and 0 < made < 16
    two = squares(vxs("bake", high, "-o", out, "--resume", cache, *options, "--sun", "noon=0,-1,0", "--light", "noon"))
    assert two == (16, 32, 16)
    want = out.read_bytes()
    vxs("bake", high, "-o", out, *options, "--sun", "noon=0,-1,0", "--light", "noon")
    assert out.read_bytes() == want


@pytest.mark.parametrize("options", [("--coding", "dag"), ("--coding", "dag", "--rule", "shadow"), ("--exit", "back"), ("--closed", "off"),
                                     ("--resolution", "1024")])
def test_other_options_make_other_squares(vxs, city, tmp_path, options):
    scene, want = city
    out, cache = tmp_path / "out.vxs", tmp_path / "cache"
    plain = (*SPARSE, "--resolution", "2048") + (("--coding", "dag") if "--rule" in options else ())
    vxs("bake", scene, "-o", out, "--resume", cache, *plain)
    options = (*SPARSE, "--resolution", "2048", *options) if "--resolution" not in options else (*SPARSE, *options)
    made, count, _ = squares(vxs("bake", scene, "-o", out, "--resume", cache, *options))
    assert made == count
    assert out.read_bytes() == want(*options)


def test_options_that_decide_nothing(vxs, city, tmp_path):
    """How the file is packed, and how sub-DAGs are compressed, is no matter of squares."""
    scene, _ = city
    out, cache = tmp_path / "out.vxs", tmp_path / "cache"
    for n, options in enumerate(((), ("--pack", "fast"), ("--level", "3"))):
        made, _, _ = squares(vxs("bake", scene, "-o", out, "--resume", cache, *SPARSE, "--resolution", "2048", *options))
        assert (made == 0) == (n > 0)
    for n, order in enumerate(("auto", "top-down", "bottom-up")):
        made, _, _ = squares(vxs("bake", scene, "-o", out, "--resume", cache, *SPARSE, "--coding", "dag", "--compress", order))
        assert (made == 0) == (n > 0)


def test_gl_squares_are_those_of_one_scene(vxs, tmp_path):
    out, cache = tmp_path / "out.vxs", tmp_path / "cache"
    options = (*GL, "--resolution", "512", "--light", "sun")
    first = scene_of(tmp_path / "a.gltf")
    assert squares(vxs("bake", first, "-o", out, "--resume", cache, *options)) == (1, 1, 0)
    assert squares(vxs("bake", first, "-o", out, "--resume", cache, *options)) == (0, 1, 1)
    other = scene_of(tmp_path / "b.gltf", ((1, 0, 1), (1.4, 1, 1.4)))
    assert squares(vxs("bake", other, "-o", out, "--resume", cache, *options)) == (1, 1, 0)


# ends of runs

@pytest.mark.parametrize("coding", CODINGS)
def test_killed_at_any_moment(vxs_path, city, tmp_path, coding):
    scene, want = city
    cache, out, rng = tmp_path / "cache", tmp_path / "out.vxs", random.Random(1)
    options = (*SPARSE, "--resolution", "8192", "--coding", coding)
    command = [vxs_path, "bake", scene, "-o", out, *options]
    begun = time.monotonic()
    subprocess.run([*command, "--resume", tmp_path / "other"], check=True, capture_output=True)
    lasts = time.monotonic() - begun
    cut_short = 0
    for n in range(int(os.environ.get("VXS_KILLS", "3"))):
        if n % 3 == 0:
            shutil.rmtree(cache, ignore_errors=True)
        out.unlink(missing_ok=True)
        run = subprocess.Popen([*command, "--resume", cache, "--threads", str(1 + n % 2)], stdout=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.2, 1) * lasts)
        run.send_signal(signal.SIGKILL)
        cut_short += run.wait() == -signal.SIGKILL
        done = subprocess.run([*command, "--resume", cache], check=True, capture_output=True, text=True)
        assert not done.stderr
        made, count, was_found = squares(done)
        assert made + was_found == count == 64
        assert out.read_bytes() == want(*options)
        for square in rng.sample(sorted(cache.iterdir()), 24):
            square.unlink()
    assert cut_short


def test_two_runs_at_once(vxs_path, vxs, city, tmp_path):
    scene, want = city
    cache, options = tmp_path / "cache", (*SPARSE, "--resolution", "4096")
    outs = [tmp_path / f"{n}.vxs" for n in range(3)]
    runs = [subprocess.Popen([vxs_path, "bake", scene, "-o", out, "--resume", cache, *options], stdout=subprocess.DEVNULL) for out in outs]
    assert [run.wait() for run in runs] == [0] * 3
    assert all(out.read_bytes() == want(*options) for out in outs)
    assert squares(vxs("bake", scene, "-o", outs[0], "--resume", cache, *options))[0] == 0


def test_what_is_not_used_is_removed(vxs, city, tmp_path):
    scene, _ = city
    out, cache = tmp_path / "out.vxs", tmp_path / "cache"
    options = (*SPARSE, "--resume", cache)
    vxs("bake", scene, "-o", out, *options, "--resolution", "2048")
    first = set(os.listdir(cache))
    others = {"notes.txt", "0123.square", "folder", ".hidden", "0" * 32 + ".square", ".vxs-mine.tmp"}
    for name in others - {"folder"}:
        (cache / name).write_text("mine")
    (cache / "folder").mkdir()
    (cache / ".vxs-1-0.tmp").write_text("left over")
    vxs("bake", scene, "-o", tmp_path / "no" / "such" / "folder.vxs", *options, "--resolution", "4096", status=4)
    assert first < set(os.listdir(cache))
    vxs("bake", scene, "-o", out, *options, "--resolution", "4096")
    second = set(os.listdir(cache))
    assert others < second and not first & second and ".vxs-1-0.tmp" not in second
    assert len(second - others) == 16


# folders in which something is wrong

def test_damaged_squares_are_made_again(vxs, city, tmp_path):
    scene, want = city
    out, cache, rng = tmp_path / "out.vxs", tmp_path / "cache", random.Random(2)
    options = (*SPARSE, "--resolution", "2048", "--resume", cache)
    vxs("bake", scene, "-o", out, *options)
    sound = {path.name: path.read_bytes() for path in cache.iterdir()}
    names = sorted(sound)

    def flipped(data, at):
        return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1:]

    for n in range(40):
        name = names[n % len(names)]
        data = sound[name]
        wrong = [b"", data[:-1], data + b"\0", data[:rng.randrange(len(data))], sound[names[(n + 1) % len(names)]], flipped(data, n % 48),
                 flipped(data, rng.randrange(len(data))), data[:32] + b"\xd0" + b"\xff" * 7 + data[40:], b"glTF" * 99][n % 9]
        (cache / name).write_bytes(wrong)
        done = vxs("bake", scene, "-o", out, *options)
        assert done.stderr == f"vxs: warning: {cache}/{name} is damaged: it is made again, as are any others of that kind\n"
        assert squares(done)[0] == 1
        assert out.read_bytes() == want(*options[:-2])
        assert (cache / name).read_bytes() == data
    for name in names:
        (cache / name).write_bytes(sound[names[0]][:-8])
    done = vxs("bake", scene, "-o", out, *options)
    assert done.stderr.count("\n") == 1 and squares(done)[0] == len(names)
    assert out.read_bytes() == want(*options[:-2])
    (cache / names[0]).write_bytes(b"")
    before = out.read_bytes()
    assert "--strict" in vxs("bake", scene, "-o", out, *options, "--strict", status=1).stderr
    assert out.read_bytes() == before


def test_squares_that_are_far_too_large(vxs_path, city, tmp_path):
    """Files of 3 GiB that hold nothing: told by their heads, or by the memory that there is, and made again within 100 MiB."""
    scene, want = city
    out, cache = tmp_path / "out.vxs", tmp_path / "cache"
    line = [vxs_path, "bake", scene, "-o", out, *SPARSE, "--resolution", "2048", "--quiet", "--resume", cache]
    subprocess.run(line, check=True)
    name = min(os.listdir(cache))
    data = (cache / name).read_bytes()
    head = data[:32] + (3 * 2**30 - 48).to_bytes(8, "little")
    for first, says in ((data[:40], "is damaged"), (b"", "is damaged"), (head, "has 3.00 GiB, for which there is no memory")):
        (cache / name).write_bytes(first)
        os.truncate(cache / name, 3 * 2**30)
        done = subprocess.run(line + ["--memory", "100M"], stderr=subprocess.PIPE, text=True,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2 * 2**30, 2 * 2**30)))
        assert (done.returncode, done.stderr.count("\n")) == (0, 1) and says in done.stderr, done
        assert out.read_bytes() == want(*SPARSE, "--resolution", "2048") and (cache / name).read_bytes() == data


def test_what_is_no_file_is_not_followed(vxs, city, tmp_path):
    scene, want = city
    out, cache, elsewhere = tmp_path / "out.vxs", tmp_path / "cache", tmp_path / "elsewhere"
    options = (*SPARSE, "--resolution", "2048", "--resume", cache)
    vxs("bake", scene, "-o", out, *options)
    name = min(os.listdir(cache))
    shutil.move(cache / name, elsewhere)
    data = elsewhere.read_bytes()
    for make in (lambda at: at.symlink_to(elsewhere), lambda at: os.mkfifo(at), lambda at: at.mkdir(), lambda at: at.symlink_to("/dev/zero")):
        make(cache / name)
        done = vxs("bake", scene, "-o", out, *options)
        assert re.fullmatch(rf"vxs: warning: --resume {cache}: squares cannot be written any more, .*: {cache}/{name} is no file\n", done.stderr)
        assert squares(done)[0] == 1
        assert out.read_bytes() == want(*options[:-2])
        assert elsewhere.read_bytes() == data
        assert not stat.S_ISREG((cache / name).lstat().st_mode)
        (cache / name).rmdir() if (cache / name).is_dir() else (cache / name).unlink()


def test_a_full_disk(vxs_path, city, tmp_path):
    """Files of the run may have so many bytes: the asset goes to a pipe, squares have no room."""
    scene, want = city
    cache, options = tmp_path / "cache", (*SPARSE, "--resolution", "2048")
    for room in (0, 4096):
        done = subprocess.run([vxs_path, "bake", scene, "-o", "-", "--resume", cache, *options], capture_output=True,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)))
        assert done.returncode == 0 and done.stdout == want(*options)
        lines = [line for line in done.stderr.decode().splitlines() if "warning" in line]
        assert len(lines) == 1 and re.search(r"cannot be written any more, and the bake goes on without: .*File too large", lines[0])
        assert all(path.suffix == ".square" for path in cache.iterdir())


@pytest.fixture(scope="module")
def small_disk():
    """run(folder, size, script, *args): a shell that has a disk of so many bytes in a folder, seen by it alone."""
    mount = 'mount -t tmpfs -o "size=$2" tmpfs "$1" || exit 99; shift 2; eval "$SCRIPT"'

    def run(folder, size, script, *args):
        return subprocess.run(["unshare", "-m", "sh", "-c", mount, "sh", folder, str(size), *map(str, args)], capture_output=True, text=True,
                              env=os.environ | {"SCRIPT": script})

    if not shutil.which("unshare") or run("/mnt", 65536, "true").returncode:
        pytest.skip("no disk can be mounted: not root, or not allowed")
    return run


@pytest.mark.parametrize("room", (16384, 131072))
def test_a_disk_that_is_full(small_disk, vxs_path, city, tmp_path, room):
    """Squares go to a small disk: the bake goes on with one warning, and a bake with more room finds what there was room for."""
    scene, want = city
    disk, out, options = tmp_path / "disk", tmp_path / "out.vxs", (*SPARSE, "--resolution", "4096")
    disk.mkdir()
    done = small_disk(disk, room, f'"$@" && mount -o remount,size=100M tmpfs "{disk}" && "$@"', vxs_path, "bake", scene, "-o", out,
                      "--resume", disk / "cache", *options)
    assert done.returncode == 0, done
    assert re.fullmatch(r"vxs: warning: --resume .*: squares cannot be written any more.*No space left on device\n", done.stderr)
    first, again = re.findall(r"^squares      (\d+) of 16 made, (\d+) found in ", done.stdout, re.M)
    assert first == ("16", "0") and int(again[0]) + int(again[1]) == 16 and 0 < int(again[1]) < 16
    assert out.read_bytes() == want(*options)


@pytest.mark.parametrize("options", ((), ("--part", "1/1"), ("--coding", "dag")))
def test_a_disk_without_room_for_the_file(small_disk, vxs_path, city, tmp_path, options):
    """An error, and nothing of it is left there; with the cached squares, the file is complete where there is room."""
    scene, want = city
    disk, cache, sizes = tmp_path / "disk", tmp_path / "cache", (*SPARSE, "--resolution", "4096")
    disk.mkdir()
    out = disk / ("out.part" if "--part" in options else "out.vxs")
    done = small_disk(disk, 16384, f'"$@"; echo $? $(ls -A "{disk}")', vxs_path, "bake", scene, "-o", out, "--resume", cache, *sizes, *options)
    assert re.fullmatch(rf"vxs: error: {out}: cannot write: No space left on device.*\n", done.stderr) and done.stdout == "4\n", done
    if "--part" not in options:
        done = subprocess.run([vxs_path, "bake", scene, "-o", out, "--resume", cache, *sizes, *options], capture_output=True, text=True)
        assert squares(done) == (0, 16, 16) and out.read_bytes() == want(*sizes, *options)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_is_read_only(vxs, city, tmp_path):
    scene, want = city
    out, cache, options = tmp_path / "out.vxs", tmp_path / "cache", (*SPARSE, "--resolution", "2048")
    vxs("bake", scene, "-o", out, "--resume", cache, *options)
    (cache / min(os.listdir(cache))).unlink()
    cache.chmod(0o500)
    done = vxs("bake", scene, "-o", out, "--resume", cache, *options)
    cache.chmod(0o700)
    assert squares(done)[0] == 1 and "cannot be written any more" in done.stderr
    assert out.read_bytes() == want(*options)


def test_what_no_folder_can_be_made_of(vxs, city, tmp_path):
    scene, _ = city
    out, file = tmp_path / "out.vxs", tmp_path / "file"
    file.write_text("")
    for folder, why in ((file, "opened: Not a directory"), (tmp_path / "no" / "such", "made: No such file or directory"), (file / "in", "made: "),
                        ("", "made: ")):
        done = vxs("bake", scene, "-o", out, *SPARSE, f"--resume={folder}", status=4)
        assert f"vxs: error: --resume {folder}: the folder cannot be {why}" in done.stderr
    assert not out.exists()


@pytest.mark.parametrize("options, why", [
    (("--maps", "gl", "--report", "page.html"), "--report draws depth maps"),
    (("--coding", "dag", "--stop", "insert"), "--stop leaves nodes")])
def test_what_needs_every_square(vxs, city, tmp_path, options, why):
    scene, _ = city
    done = vxs("bake", scene, "-o", tmp_path / "out.vxs", "--resume", tmp_path / "cache", *options, status=2)
    assert why in done.stderr and "with --resume not every square is made" in done.stderr
    assert not (tmp_path / "cache").exists()
