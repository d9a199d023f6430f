#!/usr/bin/python3
# Pack what a machine with a graphics processor needs to run the programs that draw, without packages or a compiler: the unit
# programs that make a context (tests/gl_choice.h), the command, benches, the libraries that ldd names, and run.sh. `make gpu-kit`
# builds and calls it.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_MIB = 24
# of every Linux machine, and bound to its kernel or compiler
SYSTEM = re.compile(r"/(ld-linux|libc\.|libm\.|libdl\.|librt\.|libpthread|libstdc|libgcc_s)")
# the loaders of OpenGL, of which a machine without a desktop may have the driver alone
LOADERS = ("libEGL.so.1", "libGLdispatch.so.0")
TEXTS = ("formats/*.h", "runtime/*/*.h", "runtime/*/*.glsl")  # unit programs read some, from the root of the repository
SCRIPTS = ("tests/gpu/run.sh", "tests/bench/lights.py", "tests/bench/gpu.py", "tests/bench/tables.py")


def drawing(build):
    """Unit programs that draw, by what they were compiled from."""
    for made_from in sorted((build / "tests" / "unit").glob("test_*.c.d")):
        if "tests/gl_choice.h" in made_from.read_text():
            yield made_from.with_name(made_from.name.removesuffix(".c.d"))


def libraries(programs):
    found = set()
    for program in programs:
        told = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
        found |= {path for path in re.findall(r"=> (/\S+)", told) if not SYSTEM.search(path)}
    return sorted(found)


def loaders():
    told = subprocess.run(["/sbin/ldconfig", "-p"], check=True, capture_output=True, text=True).stdout
    return [path for name in LOADERS for path in re.findall(rf"^\s*{re.escape(name)} .*=> (/\S+)$", told, re.M)[:1]]


def main():
    parser = argparse.ArgumentParser(description="Pack a kit for a machine with a graphics processor.")
    parser.add_argument("--build", type=pathlib.Path, required=True, help="folder of a build")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="the archive, .tar.xz")
    options = parser.parse_args()
    programs = list(drawing(options.build))
    benches = [options.build / "vxs", *(options.build / "tests" / "bench" / name for name in ("gpu", "area", "smoke"))]
    with tempfile.TemporaryDirectory() as name:
        kit = pathlib.Path(name) / "gpu-kit"
        for folder, paths in (("unit", programs), ("bin", benches),
                              ("lib", libraries([*programs, *benches])), ("loaders", loaders())):
            (kit / folder).mkdir(parents=True)
            for path in paths:
                shutil.copy(path, kit / folder)
                subprocess.run(["strip", "--strip-unneeded", kit / folder / pathlib.Path(path).name], check=True)
        for pattern in (*TEXTS, *SCRIPTS):
            for path in ROOT.glob(pattern):
                to = kit / path.relative_to(ROOT)
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(path, to)
        shutil.move(kit / "tests" / "gpu" / "run.sh", kit / "run.sh")
        with tarfile.open(options.output, "w:xz", preset=9) as archive:  # programs are alike: a dictionary that holds many
            archive.add(kit, "gpu-kit")
    mib = options.output.stat().st_size / 2**20
    print(f"{options.output}: {len(programs)} unit programs, {mib:.1f} MiB")
    if mib > MOST_MIB:
        sys.exit(f"a kit must have at most {MOST_MIB} MiB")


if __name__ == "__main__":
    main()
