# The archives of the fuzzers' inputs, and tests/fuzz/corpus.py, which packs, unpacks and minimises them.
# SPDX-License-Identifier: GPL-3.0-or-later
import hashlib
import io
import lzma
import os
import subprocess
import sys
import tarfile

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests" / "fuzz"))
import corpus  # noqa: E402

ARCHIVES = sorted(corpus.ARCHIVES.glob("*.tar.xz"))
SHOWED_A_FAULT = {"crash-4a782e5b4b6d29acf3fa3c204de620c831c64952", "crash-890f661e835fa6c5efebd3bc074be1725a627f95",
                  "two-metadata"}


def sha1(data):
    return hashlib.sha1(data).hexdigest()


@pytest.fixture
def archives(tmp_path):
    """A folder with vxs.tar.xz, which has two inputs, and a link to it."""
    folder = tmp_path / "archives"
    folder.mkdir()
    corpus.write_archive(folder / "vxs.tar.xz", {sha1(b"one"): b"one", "by-hand": b"two"})
    (folder / "answers.tar.xz").symlink_to("vxs.tar.xz")
    return folder


def test_every_fuzzer_has_inputs():
    sources = {source.stem.removeprefix("fuzz_") for source in (ROOT / "tests/fuzz").glob("fuzz_*.c*")}
    assert {path.name.removesuffix(".tar.xz") for path in ARCHIVES} == sources and all(path.is_file() for path in ARCHIVES)


@pytest.mark.parametrize("archive", [path for path in ARCHIVES if not path.is_symlink()], ids=lambda path: path.name)
def test_archives_are_reproducible(archive):
    """Of the tar file: another liblzma may compress it to other bytes."""
    tar = lzma.decompress(archive.read_bytes())
    inputs = corpus.read_archive(archive)
    assert tar == corpus.tar_of(archive.name.removesuffix(".tar.xz"), inputs)
    with tarfile.open(fileobj=io.BytesIO(tar)) as members:
        assert {(m.type, m.mtime, m.uid, m.gid, m.uname, m.gname, m.mode) for m in members} == {(b"0", 0, 0, 0, "", "", 0o644)}
        assert members.getnames() == sorted(members.getnames())
    assert len(inputs) > 100 and len(set(inputs.values())) == len(inputs)
    hashed = {name: data for name, data in inputs.items() if len(name.split("-")[-1]) == 40}
    assert all(sha1(data) == name.split("-")[-1] for name, data in hashed.items())


def test_inputs_that_showed_a_fault_are_kept():
    assert SHOWED_A_FAULT <= corpus.read_archive(corpus.ARCHIVES / "vxs.tar.xz").keys()
    assert all(map(corpus.is_kept, SHOWED_A_FAULT))


def test_pack_adds_files_and_folders(archives, tmp_path, capsys):
    archive, found, single = archives / "vxs.tar.xz", tmp_path / "found", tmp_path / "single"
    found.mkdir()
    (found / f"crash-{sha1(b'three')}").write_bytes(b"three")
    (found / f"crash-{sha1(b'one')}").write_bytes(b"one")
    single.write_bytes(b"four")
    corpus.pack(archives / "answers.tar.xz", [found, single])
    assert capsys.readouterr().out.endswith(f"vxs.tar.xz: 4 inputs, 15 bytes, {archive.stat().st_size} packed\n")
    assert corpus.read_archive(archive) == {f"crash-{sha1(b'three')}": b"three", f"crash-{sha1(b'one')}": b"one", "by-hand": b"two",
                                            "single": b"four"}, "equal bytes are one input, with the name that keeps it"
    assert (archives / "answers.tar.xz").is_symlink()
    packed = archive.read_bytes()
    corpus.pack(archive, [single, found])
    assert archive.read_bytes() == packed


@pytest.mark.parametrize("name, says", [("by-hand", "another input of vxs.tar.xz has this name"), ("missing", "No such file"),
                                        ("folder", "there are no inputs")])
def test_pack_refuses(archives, tmp_path, name, says):
    (tmp_path / "by-hand").write_bytes(b"not two")
    (tmp_path / "folder").mkdir()
    packed = (archives / "vxs.tar.xz").read_bytes()
    with pytest.raises(SystemExit, match=says):
        corpus.pack(archives / "vxs.tar.xz", [tmp_path / name])
    assert (archives / "vxs.tar.xz").read_bytes() == packed


def test_unpack_when_an_archive_is_newer(archives, tmp_path):
    to = tmp_path / "build" / "corpus"
    files = lambda: {str(path.relative_to(to)): path.read_bytes() for path in to.glob("*/*")}
    corpus.unpack(archives, to)
    first = files()
    inputs = {sha1(b"one"): b"one", "by-hand": b"two"}
    assert first == {f"{fuzzer}/{name}": data for fuzzer in ("vxs", "answers") for name, data in inputs.items()}
    assert list(to.parent.iterdir()) == [to]

    corpus.write_archive(archives / "vxs.tar.xz", {"new": b"five"})
    os.utime(archives / "vxs.tar.xz", (to.stat().st_mtime - 1,) * 2)
    corpus.unpack(archives, to)
    assert files() == first
    os.utime(archives / "vxs.tar.xz", (to.stat().st_mtime + 1,) * 2)
    corpus.unpack(archives, to)
    assert files() == {"vxs/new": b"five", "answers/new": b"five"}


def fuzzers(folder, **wanted):
    """Programs that stand for libFuzzer's: each adds the input that it wants, and fails when that is none."""
    folder.mkdir()
    for name, data in wanted.items():
        program = folder / f"fuzz_{name}"
        program.write_text(f'#!/bin/sh\n[ "$1" = -set_cover_merge=1 ] || exit 1\nshift $(($# - 2))\n'
                           f'[ -e "$2/{sha1(data)}" ] && cp "$2/{sha1(data)}" "$1" || echo MERGE-OUTER: attempt 2 >&2\n')
        program.chmod(0o755)
    return folder


def test_minimise_keeps_what_a_fuzzer_needs(archives, tmp_path):
    archive = archives / "vxs.tar.xz"
    corpus.write_archive(archive, {sha1(data): data for data in (b"one", b"three", b"four")} | {"by-hand": b"two"})
    corpus.minimise(archives, fuzzers(tmp_path / "fuzzers", vxs=b"one", answers=b"three"))
    least = corpus.read_archive(archive)
    assert least == {sha1(b"one"): b"one", sha1(b"three"): b"three", "by-hand": b"two"}
    with pytest.raises(SystemExit, match="fuzz_answers fails with an input of vxs.tar.xz"):
        corpus.minimise(archives, fuzzers(tmp_path / "failing", vxs=b"one", answers=b"four"))
    assert corpus.read_archive(archive) == least


def test_goals():
    run = lambda *goal: subprocess.run(["make", "-n", *goal], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert "tests/fuzz/corpus.py pack vxs some folder\n" in run("fuzz-pack", "corpus=vxs", "inputs=some folder")
    done = subprocess.run([ROOT / "tests/fuzz/corpus.py", "pack", "vsx", ROOT], capture_output=True, text=True)
    assert done.returncode == 2 and "invalid choice: 'vsx'" in done.stderr
