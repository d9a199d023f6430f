#!/usr/bin/python3
# Run every fuzzer of build/fuzz with its corpus for so many seconds, one after the other, and print a line for each: how many
# inputs it ran and what it found. Inputs that showed a fault are in build/fuzz/found/NAME, the log is build/fuzz/found/NAME.txt.
# Inputs that reach new code are in build/fuzz/new/NAME, and the next run begins with them. make fuzz-pack adds such a folder to the
# corpus.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import os
import pathlib
import re
import subprocess
import sys

import corpus

ROOT = corpus.ROOT


def run_fuzzer(program, seconds, seed):
    name = program.name.removeprefix("fuzz_")
    found, new = (program.parents[2] / kind / name for kind in ("found", "new"))
    for folder in (found, new):
        folder.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    log = found.with_suffix(".txt")
    with log.open("wb") as to:
        status = subprocess.run([program, f"-max_total_time={seconds}", f"-seed={seed}", *corpus.LIMITS, "-print_final_stats=1",
                                 f"-artifact_prefix={found}/", new, corpus.UNPACKED / name], cwd=ROOT,
                                env={**corpus.ENVIRONMENT, **os.environ}, stdout=to, stderr=subprocess.STDOUT).returncode
    runs = re.findall(r"stat::number_of_executed_units: (\d+)", log.read_text(errors="replace"))
    inputs = sorted(str(path.relative_to(ROOT)) for path in set(found.iterdir()) - before)
    bad = status != 0 or bool(inputs)
    what = f"FOUND {', '.join(inputs) or f'exit status {status}'}, see {log.relative_to(ROOT)}" if bad else "nothing found"
    print(f"{program.name}: {runs[-1] if runs else '?'} inputs, {what}", flush=True)
    return not bad


def run_commands(vxs, seconds, seed):
    done = subprocess.run([sys.executable, ROOT / "tests" / "fuzz" / "command_lines.py", "--vxs", vxs, "--seconds", str(seconds), "--seed", str(seed)],
                          cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout if done.returncode else f"command_lines.py: {done.stdout.splitlines()[-1]}", flush=True)
    return done.returncode == 0


def main():
    parser = argparse.ArgumentParser(description="Run every fuzzer for so many seconds.")
    parser.add_argument("programs", nargs="+", type=pathlib.Path, help="built by make fuzz")
    parser.add_argument("--vxs", type=pathlib.Path, help="the command, for random command lines")
    parser.add_argument("--seconds", type=int, default=60, help="of each")
    parser.add_argument("--seed", type=int, default=1, help="other inputs")
    options = parser.parse_args()
    corpus.unpack(corpus.ARCHIVES, corpus.UNPACKED)
    good = [run_fuzzer(program.resolve(), options.seconds, options.seed) for program in options.programs]
    if options.vxs:
        good.append(run_commands(options.vxs, options.seconds, options.seed))
    return 0 if all(good) else 1


sys.exit(main())
