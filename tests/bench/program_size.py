# SPIR-V instructions of every program of runtime/gl, runtime/volumes and `vxs render`, after calls are inlined and dead code is
# gone: what a driver that inlines has to compile. Needs no graphics processor. `make program-size` prints them.
#
#     program_size.py --build build/release [--only PATTERN] [--lower]
#
# tests/bench/program_sizes.json has the ceiling of each program. --lower writes the sizes of this build as ceilings; a higher one
# is a decision, and is edited by hand.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
CEILINGS = ROOT / "tests/bench/program_sizes.json"
STAGES = {"compute": "comp", "vertex": "vert", "fragment": "frag"}
PASSES = ("--eliminate-dead-functions", "--merge-return", "--inline-entry-points-exhaustive", "--eliminate-dead-code-aggressive", "--ccp",
          "--simplify-instructions", "--eliminate-dead-branches", "--merge-blocks")


def library_texts(build):
    """Of libvxs_gl and libvxs_volumes, as tests/bench/programs.c writes them: [(name, stage, text)]."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([build / "tests/bench/programs", folder], check=True)
        files = sorted(pathlib.Path(folder).iterdir())
        return [(path.stem[4:], path.suffix[1:], path.read_text()) for path in files]


def command_texts(build):
    """Of `vxs render`, as Mesa writes what it links: a city of one light, and of lights in lists."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        def vxs(*arguments, **variables):
            subprocess.run([build / "vxs", *arguments, "--quiet"], check=True, cwd=folder, env={**os.environ, **variables})

        vxs("scene", "city", "-o", "city.glb", "--triangles", "3000")
        vxs("bake", "city.glb", "-o", "city.vxs", "--resolution", "256")
        (pathlib.Path(folder) / "texts").mkdir()
        vxs("render", "city.glb", "city.vxs", "-o", "city.png", "--width", "16", "--height", "16", "--samples", "1",
            MESA_SHADER_CAPTURE_PATH=f"{folder}/texts")
        for path in sorted(pathlib.Path(folder, "texts").glob("*.shader_test"), key=lambda path: int(path.stem)):
            for kind, stage in STAGES.items():
                part = re.search(rf"\[{kind} shader\]\n(.*?)(?=\n\[|\Z)", path.read_text(), re.S)
                if part:
                    found.append(("render", stage, part[1]))
    if not any(name == "render" for name, _, _ in found):
        sys.exit("vxs render: Mesa wrote no texts")
    return found


def named(texts):
    """The same, each with the file of its main function in its name: {"blocks march_map sun march.glsl": (stage, text)}."""
    bodies = {path.name: re.sub(r'^#include "[^\n]*\n', "", path.read_text(), flags=re.M).strip()
              for path in ROOT.glob("**/*.glsl") if "build" not in path.parts}
    result = {}
    for name, stage, text in texts:
        ends = [file for file, body in bodies.items() if text.strip().endswith(body)]
        label = " ".join([name.replace("_", " "), ends[0] if ends else f"({stage})"])
        if (stage, text) in result.values():
            continue  # the same program as one before
        if label in result:
            number = next(n for n in range(2, 99) if f"{label} {n}" not in result)
            label = f"{label} {number}"
        result[label] = (stage, text)
    return result


def instructions(stage, text):
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder, f"program.{stage}")
        source.write_text(text)
        done = subprocess.run(["glslangValidator", "-G", "--auto-map-locations", "--auto-map-bindings", "-o", "a.spv", source], cwd=folder,
                              capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stdout)
        subprocess.run(["spirv-opt", *PASSES, "-o", "b.spv", "a.spv"], cwd=folder, check=True)
        words = subprocess.run(["spirv-dis", "b.spv"], cwd=folder, check=True, capture_output=True, text=True).stdout
        return len(re.findall(r"^(?:\s*%\S+ = )?\s*Op\w+", words, re.M))


def sizes(build, only=""):
    build = pathlib.Path(build).resolve()
    programs = named(library_texts(build) + command_texts(build))
    programs = {name: program for name, program in programs.items() if re.search(only, name)}
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        return dict(zip(programs, pool.map(lambda program: instructions(*program), programs.values())))


def ceilings():
    return json.loads(CEILINGS.read_text())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--only", default="", help="a regular expression that names have")
    parser.add_argument("--lower", action="store_true", help="write ceilings, where none is higher than before")
    arguments = parser.parse_args()
    if arguments.lower and arguments.only:
        parser.error("--lower goes without --only: it writes the ceilings of all programs")
    found, most = sizes(arguments.build, arguments.only), ceilings()
    for name, size in sorted(found.items(), key=lambda item: -item[1]):
        print(f"{size:7}  {most.get(name, '-'):>7}  {name}")
    if arguments.lower:
        CEILINGS.write_text(json.dumps({name: min(size, most.get(name, size)) for name, size in found.items()}, indent=1) + "\n")


if __name__ == "__main__":
    main()
