#!/usr/bin/python3
# The inputs of the fuzzers: archives in tests/fuzz/corpus. Fuzzers that read the same kind of bytes share one, by links to it.
#
#   corpus.py unpack              write build/corpus/FUZZER/INPUT, when an archive is newer than what is there
#   corpus.py pack FUZZER PATH... add files, or all files of folders, to the fuzzer's archive (make fuzz-pack)
#   corpus.py minimise            leave out what no fuzzer needs for its coverage (make fuzz-minimise)
#
# libFuzzer names an input that reaches new code by its SHA-1. Only inputs with such names are ever left out. All others are kept:
# crash-SHA1 or leak-SHA1 once showed a fault, and any other name is that of a file made for the purpose.
# Same inputs, same archive: sorted by name, without times and owners.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import io
import lzma
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARCHIVES = ROOT / "tests" / "fuzz" / "corpus"
UNPACKED = ROOT / "build" / "corpus"
FUZZERS = ROOT / "build" / "fuzz" / "tests" / "fuzz"
SUFFIX = ".tar.xz"
# how libFuzzer's programs are run
LIMITS = ("-timeout=60", "-report_slow_units=60", "-rss_limit_mb=4096")  # seconds of one input, MiB
ENVIRONMENT = {"ASAN_OPTIONS": "detect_stack_use_after_return=1", "UBSAN_OPTIONS": "print_stacktrace=1",
               "LSAN_OPTIONS": f"suppressions={ROOT / 'tests' / 'lsan.supp'}:print_suppressions=0",
               "MESA_SHADER_CACHE_DIR": str(ROOT / "build" / "shaders")}


def fuzzer_of(archive):
    return archive.name.removesuffix(SUFFIX)


def is_kept(name):
    return not re.fullmatch("[0-9a-f]{40}", name)


# --- an archive: {name: bytes} ----------------------------------------------------------------------------------------------------


def read_archive(archive):
    if not archive.exists():
        return {}  # a new fuzzer's
    with tarfile.open(archive) as tar:
        return {pathlib.PurePosixPath(member.name).name: tar.extractfile(member).read() for member in tar}


def tar_of(fuzzer, inputs):
    """The bytes of a tar file with FUZZER/NAME for each input."""
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for name, data in sorted(inputs.items()):
            member = tarfile.TarInfo(f"{fuzzer}/{name}")  # its time and owner are 0, its mode is 0644
            member.size = len(data)
            tar.addfile(member, io.BytesIO(data))
    return file.getvalue()


def write_archive(archive, inputs):
    """Of inputs with equal bytes one is written, if possible one whose name keeps it."""
    archive = archive.resolve()
    names = {inputs[name]: name for name in sorted(inputs, key=lambda name: (is_kept(name), name))}
    tar = tar_of(fuzzer_of(archive), {name: data for data, name in names.items()})
    packed = lzma.compress(tar, preset=9 | lzma.PRESET_EXTREME)
    archive.write_bytes(packed)
    print(f"{archive.name}: {len(names)} inputs, {sum(map(len, names))} bytes, {len(packed)} packed")


# --- what the command does --------------------------------------------------------------------------------------------------------


def write_folder(folder, inputs):
    folder.mkdir()
    for name, data in inputs.items():
        (folder / name).write_bytes(data)


def unpack(archives, to):
    """Write the inputs of all archives as to/FUZZER/INPUT, in place of what is there: no input stays that left its archive."""
    found = sorted(archives.glob("*" + SUFFIX))
    if to.is_dir() and to.stat().st_mtime >= max(archive.stat().st_mtime for archive in found):
        return
    to.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=to.parent) as temporary:
        new = pathlib.Path(temporary, to.name)
        new.mkdir()
        for archive in found:
            if archive.is_symlink():
                (new / fuzzer_of(archive)).symlink_to(fuzzer_of(archive.readlink()))
            else:
                write_folder(new / fuzzer_of(archive), read_archive(archive))
        shutil.rmtree(to, ignore_errors=True)
        new.rename(to)


def pack(archive, paths):
    """Exits with one line and changes nothing when a path cannot be read, or when another input has the same name."""
    inputs = read_archive(archive)
    files = [file for path in paths for file in (sorted(path.iterdir()) if path.is_dir() else [path])]
    if not files:
        sys.exit(f"{paths[0]}: there are no inputs")
    try:
        for file in files:
            data = file.read_bytes()
            if inputs.setdefault(file.name, data) != data:
                sys.exit(f"{file}: another input of {archive.name} has this name")
    except OSError as error:
        sys.exit(f"{error.filename}: {error.strerror}")
    write_archive(archive, inputs)


def minimise(archives, fuzzers):
    """Each fuzzer in turn adds the fewest inputs with which its coverage is that of all of them (a greedy set cover).

    Exits when a fuzzer fails with an input: libFuzzer would leave that out, and try again without it.
    """
    for archive in sorted(path for path in archives.glob("*" + SUFFIX) if not path.is_symlink()):
        inputs = read_archive(archive)
        with tempfile.TemporaryDirectory() as temporary:
            whole, least = pathlib.Path(temporary, "whole"), pathlib.Path(temporary, "least")
            write_folder(whole, inputs)
            write_folder(least, {name: data for name, data in inputs.items() if is_kept(name)})
            for fuzzer in sorted(map(fuzzer_of, (path for path in archives.iterdir() if path.resolve() == archive.resolve()))):
                done = subprocess.run([fuzzers / f"fuzz_{fuzzer}", "-set_cover_merge=1", *LIMITS, least, whole],
                                      env={**ENVIRONMENT, **os.environ}, capture_output=True, text=True, errors="replace")
                if done.returncode != 0 or "MERGE-OUTER: attempt 2" in done.stderr:
                    sys.exit(f"{done.stderr}fuzz_{fuzzer} fails with an input of {archive.name}, which stays as it is")
            write_archive(archive, {file.name: file.read_bytes() for file in least.iterdir()})


def main():
    parser = argparse.ArgumentParser(description="The archives of the fuzzers' inputs.")
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("unpack", help="write build/corpus, when an archive is newer")
    packing = commands.add_parser("pack", help="add inputs to an archive")
    packing.add_argument("fuzzer", choices=sorted(path.stem.removeprefix("fuzz_") for path in ARCHIVES.parent.glob("fuzz_*.c*")),
                         help="whose inputs they are")
    packing.add_argument("paths", nargs="+", type=pathlib.Path, help="files, or folders of files")
    commands.add_parser("minimise", help="leave out what no fuzzer needs for its coverage")
    options = parser.parse_args()
    if options.command == "unpack":
        unpack(ARCHIVES, UNPACKED)
    elif options.command == "pack":
        pack(ARCHIVES / (options.fuzzer + SUFFIX), options.paths)
    else:
        minimise(ARCHIVES, FUZZERS)


if __name__ == "__main__":
    main()
