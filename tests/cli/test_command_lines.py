# The fuzzer of command lines, tests/fuzz/command_lines.py: some runs of it, and faults that it has to find.
# SPDX-License-Identifier: GPL-3.0-or-later
import subprocess
import sys

import pytest

from conftest import ROOT

# what a false command does instead, and what is found
FAULTS = {
    "info": ("echo more >>'level data.bin'", "level data.bin is no output, and was changed"),
    "validate": ("rm b.vxs", "b.vxs is no output, and was removed"),
    "query": ("touch .vxs-1-0.tmp", ".vxs-1-0.tmp is no output, and was made"),
    "truth": ("chmod 600 a.vxs", "a.vxs is no output, and was changed"),
    "scene": ("true", " was not written"),
    "plan": ("kill -SEGV $$", "exit status -11"),
    "bake": ("echo 'ERROR: AddressSanitizer: heap-use-after-free' >&2", "exit status 0"),
    "render": ("exit 3", "exit status 3, and 0 lines of errors"),
    "mend": ("touch $TMPDIR/left", "left is left in TMPDIR"),
}


def fuzz(command, *options):
    return subprocess.run([sys.executable, ROOT / "tests/fuzz/command_lines.py", "--vxs", command, *map(str, options)],
                          capture_output=True, text=True, timeout=1200)


@pytest.mark.slow
def test_random_command_lines(vxs_path):
    done = fuzz(vxs_path, "--runs", 120)
    assert done.returncode == 0 and "120 command lines of seed 1, 0 went wrong" in done.stdout, done.stdout + done.stderr


def test_faults_are_found(vxs_path, tmp_path):
    """By a command that is vxs but for the random runs."""
    false = tmp_path / "vxs"
    cases = "".join(f"*/vxs-lines-*/temporary,{command}) {fault};;\n" for command, (fault, _) in FAULTS.items())
    false.write_text(f'#!/bin/sh\ncase "$TMPDIR,$1" in\n{cases}*) exec "{vxs_path}" "$@";;\nesac\n')
    false.chmod(0o755)
    done = fuzz(false, "--runs", 80)
    found = dict.fromkeys(FAULTS, "")
    for run in done.stdout.split("\nrun ")[1:]:
        found[run.split()[2]] = found.get(run.split()[2], "") + run
    assert done.returncode == 1 and [c for c, (_, says) in FAULTS.items() if says not in found[c]] == [], done.stdout
