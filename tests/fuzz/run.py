#!/usr/bin/python3
# Run every fuzzer of build/fuzz with its corpus for so many seconds, one after the other, and say of each in one line how many inputs it ran and
# what it found. What it found, and its log, are in build/fuzz/found/NAME; inputs that reach new code are kept in build/fuzz/new/NAME, where the
# next run begins from.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
TIMEOUT_S = 60  # of one input
MEMORY_MB = 4096
ENVIRONMENT = {"ASAN_OPTIONS": "detect_stack_use_after_return=1", "UBSAN_OPTIONS": "print_stacktrace=1",
               "LSAN_OPTIONS": f"suppressions={ROOT / 'tests' / 'lsan.supp'}:print_suppressions=0",
               "MESA_SHADER_CACHE_DIR": str(ROOT / "build" / "shaders")}


def run_fuzzer(program, seconds, seed):
    name = program.name.removeprefix("fuzz_")
    found, new = (program.parents[2] / kind / name for kind in ("found", "new"))
    for folder in (found, new):
        folder.mkdir(parents=True, exist_ok=True)
    before = set(found.iterdir())
    log = found / "log.txt"
    with log.open("wb") as to:
        status = subprocess.run([program, f"-max_total_time={seconds}", f"-seed={seed}", f"-timeout={TIMEOUT_S}", f"-report_slow_units={TIMEOUT_S}",
                                 f"-rss_limit_mb={MEMORY_MB}", "-print_final_stats=1", f"-artifact_prefix={found}/", new,
                                 ROOT / "tests" / "fuzz" / "corpus" / name], cwd=ROOT,
                                env={**ENVIRONMENT, **os.environ}, stdout=to, stderr=subprocess.STDOUT).returncode
    runs = re.findall(r"stat::number_of_executed_units: (\d+)", log.read_text(errors="replace"))
    inputs = sorted(str(path.relative_to(ROOT)) for path in set(found.iterdir()) - before - {log})
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
    good = [run_fuzzer(program.resolve(), options.seconds, options.seed) for program in options.programs]
    if options.vxs:
        good.append(run_commands(options.vxs, options.seconds, options.seed))
    return 0 if all(good) else 1


sys.exit(main())
