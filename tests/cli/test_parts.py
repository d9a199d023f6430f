# Bakes in parts: vxs bake --part and vxs merge. The bytes are those of one bake, and what is no set of its parts is refused.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import random
import re
import resource
import subprocess

import jsonschema
import pytest

import damage
import small_scene

ROOT = pathlib.Path(__file__).resolve().parents[2]
SPARSE = ("--maps", "sparse")
GL = ("--maps", "gl")
LIGHTS = (("sun", "directional", (0.2, -1, 0.1)), ("lamp", "point", (0, -1, 0)), ("spot", "spot", (0.1, -1, 0.2)))
PILLARS = [((x - 0.3, 0, z - 0.3), (x + 0.3, 2, z + 0.3)) for x in range(-6, 7, 3) for z in range(-6, 7, 3)]
SIZES = ("--resolution", "sun=2048", "--resolution", "256")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("parts") / "scene.gltf", (small_scene.GROUND, *PILLARS), lights=LIGHTS)


def bake_parts(vxs, scene, folder, count, *options):
    folder.mkdir(exist_ok=True)
    paths = [folder / f"{n}.part" for n in range(1, count + 1)]
    for n, path in enumerate(paths):
        vxs("bake", scene, "-o", path, "--part", f"{n + 1}/{count}", *options)
    return paths


@pytest.fixture(scope="module")
def parts(vxs, scene, tmp_path_factory):
    """Four parts, and what one bake makes."""
    folder = tmp_path_factory.mktemp("four")
    vxs("bake", scene, "-o", folder / "want.vxs", *SPARSE, *SIZES)
    return bake_parts(vxs, scene, folder, 4, *SPARSE, *SIZES), (folder / "want.vxs").read_bytes()


@pytest.mark.parametrize("coding", ("blocks", "dag"))
@pytest.mark.parametrize("maps", (SPARSE, GL))
def test_same_bytes_as_one_bake(vxs, scene, tmp_path, maps, coding):
    out, options = tmp_path / "out.vxs", (*maps, "--coding", coding, *SIZES, "--level", "5")
    vxs("bake", scene, "-o", out, *options)
    want = out.read_bytes()
    rng = random.Random(3)
    for count in (1, 2, 17):
        paths = bake_parts(vxs, scene, tmp_path / str(count), count, *options, "--threads", str(1 + count % 3))
        rng.shuffle(paths)
        for threads in ("1", "3"):
            out.unlink()
            done = vxs("merge", *paths, "-o", out, "--threads", threads)
            assert out.read_bytes() == want
        assert re.match(rf"parts        {count}, \d+ squares of 3 lights\nfile         {out}: ", done.stdout)


@pytest.mark.parametrize("options", [("--pack", "fast"), ("--coding", "dag", "--reuse", "off"), ("--coding", "dag", "--rule", "shadow"),
                                     ("--light", "lamp"), ("--region", "-2,-1,-2,2,2,2", "--exit", "back")])
def test_options_are_in_the_parts(vxs, scene, tmp_path, options):
    out, options = tmp_path / "out.vxs", (*SPARSE, "--resolution", "256", *options)
    vxs("bake", scene, "-o", out, *options)
    want = out.read_bytes()
    vxs("merge", *bake_parts(vxs, scene, tmp_path / "parts", 3, *options), "-o", out)
    assert out.read_bytes() == want


def test_reports(vxs, scene, parts, tmp_path):
    part, report = tmp_path / "a.part", tmp_path / "report.json"
    done = vxs("bake", scene, "-o", part, "--part", "2/4", "--json", report, *SPARSE, *SIZES, "--resume", tmp_path / "kept")
    told = json.loads(report.read_text())
    jsonschema.validate(told, json.loads((ROOT / "docs/bake-report.schema.json").read_text()))
    made = told["part"]["made"]
    assert told["part"] == {"number": 2, "parts": 4, "made": made, "found": 0} and told["file_bytes"] == part.stat().st_size
    assert f"part         2 of 4: {part}, " in done.stdout and f"squares      {made} of {made} made, 0 found in " in done.stdout
    again = vxs("bake", scene, "-o", part, "--part", "2/4", *SPARSE, *SIZES, "--resume", tmp_path / "kept")
    assert f"squares      0 of {made} made, {made} found in " in again.stdout
    assert part.read_bytes() == parts[0][1].read_bytes()
    vxs("merge", *parts[0], "-o", tmp_path / "out.vxs", "--json", report)
    told = json.loads(report.read_text())
    jsonschema.validate(told, json.loads((ROOT / "docs/merge.schema.json").read_text()))
    assert told["parts"] == 4 and told["lights"] == 3 and told["file_bytes"] == len(parts[1])


def test_parts_share_a_folder(vxs, scene, parts, tmp_path):
    """No part takes squares of others away; the bake of all finds them."""
    kept = tmp_path / "kept"
    paths = bake_parts(vxs, scene, tmp_path / "p", 4, *SPARSE, *SIZES, "--resume", kept)
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in parts[0]]
    done = vxs("bake", scene, "-o", tmp_path / "out.vxs", *SPARSE, *SIZES, "--resume", kept)
    assert re.search(r"^squares      0 of ", done.stdout, re.M)
    assert (tmp_path / "out.vxs").read_bytes() == parts[1]


def test_pipes(vxs_path, scene, parts, tmp_path):
    """Parts are written to and read from pipes."""
    out, (first, second, *rest) = tmp_path / "out.vxs", parts[0]
    done = subprocess.run([vxs_path, "bake", scene, "-o", "-", "--part", "1/4", *SPARSE, *SIZES], capture_output=True, check=True)
    assert done.stdout == first.read_bytes() and b"part         1 of 4: standard output" in done.stderr
    line = f'"{vxs_path}" merge - <(cat "{second}") {" ".join(map(str, rest))} -o - < <(cat "{first}")'
    assert subprocess.run(["bash", "-c", line], capture_output=True, check=True).stdout == parts[1]


def test_missing_and_twice(vxs, parts, tmp_path):
    paths, out = parts[0], tmp_path / "out.vxs"
    done = vxs("merge", *paths[:2], paths[3], "-o", out, status=2)
    assert done.stderr == "vxs: error: part 3 of 4 is missing: 3 were given\n"
    done = vxs("merge", *paths, paths[1], "-o", out, status=2)
    assert done.stderr == f"vxs: error: '{paths[1]}' and '{paths[1]}' are both part 2 of 4\n"
    assert not out.exists()


@pytest.mark.parametrize("options", [("--coding", "dag"), ("--resolution", "sun=1024"), ("--light", "sun"), ("--level", "3"), ("--exit", "back"),
                                     ("--maps", "gl"), ("--pack", "fast")])
def test_parts_of_another_bake(vxs, scene, parts, tmp_path, options):
    other, out = tmp_path / "other.part", tmp_path / "out.vxs"
    given = {"--maps": SIZES, "--resolution": (*SPARSE, "--resolution", "256")}.get(options[0], (*SPARSE, *SIZES))
    vxs("bake", scene, "-o", other, "--part", "3/4", *given, *options)
    done = vxs("merge", *parts[0][:2], other, parts[0][3], "-o", out, status=3)
    assert done.stderr == (f"vxs: error: '{other}' and '{parts[0][0]}' are parts of different bakes: of other scenes, lights, options, versions, "
                           "renderers, or --memory\n")
    assert not out.exists()


def test_parts_of_another_scene_and_number(vxs, scene, parts, tmp_path):
    other, out = tmp_path / "other.part", tmp_path / "out.vxs"
    moved = small_scene.write(tmp_path / "moved.gltf", (small_scene.GROUND, *PILLARS, ((1, 0, 1), (1.5, 1, 1.5))), lights=LIGHTS)
    vxs("bake", moved, "-o", other, "--part", "4/4", *SPARSE, *SIZES)
    assert "are parts of different bakes" in vxs("merge", *parts[0][:3], other, "-o", out, status=3).stderr
    vxs("bake", scene, "-o", other, "--part", "3/5", *SPARSE, *SIZES)
    done = vxs("merge", *parts[0][:3], other, "-o", out, status=3)
    assert done.stderr == f"vxs: error: '{other}' is one of 5 parts, and '{parts[0][0]}' is one of 4: they are not of one bake\n"


def test_damaged_parts(vxs_path, parts, tmp_path):
    """Any byte that is another, and any end that is missing: one line that names the part, status 3, or 2 where the number in it is that of
    another part."""
    paths, want = parts
    out, wrong, rng = tmp_path / "out.vxs", tmp_path / "wrong.part", random.Random(4)
    data = paths[2].read_bytes()

    def merged():
        return subprocess.run([vxs_path, "merge", *paths[:2], wrong, paths[3], "-o", out], capture_output=True, text=True, timeout=60)

    for n in range(150):
        at = n if n < 40 else len(data) - 1 - (n - 40) if n < 90 else rng.randrange(len(data))
        spoilt = data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1:]
        wrong.write_bytes(data[:rng.randrange(len(data))] if n % 10 == 9 else spoilt)
        done = merged()
        assert done.returncode == 3, (n, done.stderr)
        assert done.stderr.startswith("vxs: error: ") and str(wrong) in done.stderr and done.stderr.count("\n") == 1
        assert not out.exists()
    wrong.write_bytes(data + b"\0")
    assert merged().returncode == 3
    wrong.write_bytes(data)
    assert merged().returncode == 0 and out.read_bytes() == want


def test_parts_that_lie(vxs_path, scene, vxs, tmp_path):
    """Checksums are right, and what is under them is not: no crash, and no file."""
    _, xxhash = damage.libraries()
    (path,) = bake_parts(vxs, scene, tmp_path / "one", 1, *SPARSE, "--resolution", "256", "--light", "lamp")
    data, out, wrong, rng = path.read_bytes(), tmp_path / "out.vxs", tmp_path / "wrong.part", random.Random(5)
    begin = int.from_bytes(data[-40:-32], "little")
    statuses = set()
    for n in range(300):
        at = rng.choice([rng.randrange(begin, begin + 600), rng.randrange(begin, len(data) - 16)])
        spoilt = bytearray(data)
        spoilt[at] ^= 1 << rng.randrange(8)
        head = xxhash.XXH64(bytes(spoilt[:24]), 24, damage.ctypes.c_uint64(0))
        rest = bytes(spoilt[begin:-16])
        spoilt[-16:-8] = xxhash.XXH64(rest, damage.ctypes.c_size_t(len(rest)), damage.ctypes.c_uint64(head)).to_bytes(8, "little")
        wrong.write_bytes(spoilt)
        out.unlink(missing_ok=True)
        done = subprocess.run([vxs_path, "merge", wrong, "-o", out], capture_output=True, text=True, timeout=60)
        statuses.add(done.returncode)
        assert done.returncode in (0, 2, 3, 6), (n, at, done)
        assert out.exists() == (done.returncode == 0)
        assert done.stderr.count("\n") == (done.returncode != 0)
    assert statuses >= {0, 3}


def test_what_is_no_part(vxs, scene, parts, tmp_path):
    out = tmp_path / "out.vxs"
    asset, text, empty = tmp_path / "a.vxs", tmp_path / "text", tmp_path / "empty"
    asset.write_bytes(parts[1])
    text.write_text("what is this")
    empty.write_bytes(b"")
    for path, says in ((asset, f"'{asset}' is a .vxs file, expected a part of a bake"), (scene, f"'{scene}' is a glTF scene, expected a part of a bake"),
                       (text, f"'{text}' is no part of a bake"), (empty, f"'{empty}' is no part of a bake"), (tmp_path, "is a folder"),
                       (tmp_path / "none", f"cannot read '{tmp_path / 'none'}': No such file or directory")):
        assert says in vxs("merge", *parts[0][:3], path, "-o", out, status=3).stderr
    done = vxs("info", parts[0][0], status=3)
    assert f"'{parts[0][0]}' is a part of a bake, expected a .vxs file" in done.stderr
    assert not out.exists()


@pytest.mark.parametrize("number", ["0/4", "5/4", "4", "/4", "1/", "1/0", "1/65537", "-1/4", "1/4/8", "a/b", "1.5/4", "", "99999999999/99999999999"])
def test_numbers_that_are_none(vxs, scene, tmp_path, number):
    done = vxs("bake", scene, "-o", tmp_path / "a.part", f"--part={number}", *SPARSE, status=2)
    assert f"--part {number}: expected I/N" in done.stderr


def test_what_does_not_go_with_a_part(vxs, scene, tmp_path):
    part = tmp_path / "a.part"
    for options in (("--report", tmp_path / "a.html"), ("--coding", "dag", "--stop", "partial"), ("--if-changed",)):
        vxs("bake", scene, "-o", part, "--part", "1/2", "--maps", "gl", *options, status=2)
    assert "of which vxs merge makes a .vxs file" in vxs("bake", scene, "-o", tmp_path / "a.vxs", "--part", "1/2", status=2).stderr
    assert "'.part' is the extension of other files" in vxs("bake", scene, "-o", part, status=2).stderr
    assert not part.exists()


def test_a_part_is_whole_or_not_there(vxs_path, vxs, scene, tmp_path):
    """A full disk is an error, and the older part stays."""
    part = tmp_path / "a.part"
    part.write_text("old")
    done = subprocess.run([vxs_path, "bake", scene, "-o", part, "--part", "1/1", *SPARSE, *SIZES], capture_output=True, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
    assert done.returncode == 4 and f"{part}: cannot write: File too large" in done.stderr
    assert part.read_text() == "old" and os.listdir(tmp_path) == ["a.part"]
