# make's set-up on systems that are not this one: programs that stand for Debian's say what is there and write down what they
# must do. And the counting of tests/run and .ci/run.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import pathlib
import re
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ["sh", "sed", "grep", "env", "cat", "nproc", "find", "paste"]
FAKES = {
    "dpkg-query": 'for p in $(cat "$STATE/here"); do echo "$p installed"; done; echo "half unpacked"; exit 1',
    "id": 'cat "$STATE/user"',
    "sudo": 'echo sudo >>"$STATE/log"; exec "$@"',
    "apt-get": '[ "$2" = -s ] && { [ -e "$STATE/lists" ]; exit; }; echo "apt-get $*" >>"$STATE/log"; exit $(cat "$STATE/status")',
}


def packages(which):
    text = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    return re.search(rf"^packages\.{which}\s*:= (.*)$", text, re.MULTILINE)[1].split()


@pytest.fixture
def system(tmp_path):
    """run(goal, here=, user=, without=(), lists=True): make on a made-up system; its status, its words, what was done."""

    def run(*goals, here, user=0, without=(), lists=True, status=0):
        programs, state = tmp_path / "bin", tmp_path / "state"
        for folder in (programs, state):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
        for tool in TOOLS:
            (programs / tool).symlink_to(shutil.which(tool))
        for name, text in FAKES.items():
            if name not in without:
                (programs / name).write_text(f"#!/bin/sh\n{text}\n")
                (programs / name).chmod(0o755)
        (state / "here").write_text(" ".join(here))
        (state / "user").write_text(f"{user}\n")
        (state / "status").write_text(f"{status}\n")
        if lists:
            (state / "lists").touch()
        environment = {k: v for k, v in os.environ.items() if not k.startswith("MAKE") and k not in ("MFLAGS", "packages")}
        done = subprocess.run([shutil.which("make"), *goals], cwd=ROOT, env=environment | {"PATH": str(programs), "STATE": str(state)},
                              capture_output=True, text=True)
        log = (state / "log").read_text() if (state / "log").exists() else ""
        return done.returncode, done.stdout + done.stderr, log

    return run


ALL = packages("build") + packages("test") + packages("deb")


def test_nothing_is_done_when_all_is_there(system):
    assert system("-s", "packages", here=ALL) == (0, "", "")


def test_only_what_is_missing_is_installed(system):
    status, said, log = system("packages", here=[p for p in ALL if p not in ("libpng-dev", "g++")])
    assert status == 0 and log == "apt-get install -y --no-install-recommends g++ libpng-dev\n"
    assert "not installed: g++ libpng-dev\n" in said and f"installing: " in said


def test_lists_are_fetched_when_they_do_not_know_a_package(system):
    _, _, log = system("packages", here=ALL[1:], lists=False)
    assert log.splitlines() == ["apt-get update -q", f"apt-get install -y --no-install-recommends {ALL[0]}"]


def test_a_package_that_is_not_whole_is_missing(system):
    assert "g++" in system("packages", here=[p + "-doc" for p in ALL])[2]


def test_sudo_when_not_root(system):
    status, said, log = system("packages", here=ALL[1:], user=1000)
    assert status == 0 and log.splitlines()[0] == "sudo" and "installing: sudo " in said


@pytest.mark.parametrize("without, user, says", [(("apt-get",), 0, "there is no apt-get here"), (("sudo",), 1000, "not root, and there is no sudo")])
def test_what_to_do_when_it_cannot(system, without, user, says):
    status, said, log = system("packages", here=ALL[1:], user=user, without=without)
    assert status != 0 and log == "" and says in said and ALL[0] in said and "packages=skip" in said


def test_failure_to_install_stops(system):
    assert system("packages", here=ALL[1:], status=100)[0] != 0


def test_skip(system):
    assert system("-s", "packages", "packages=skip", here=[], without=("apt-get", "sudo"))[2] == ""


def test_demo_needs_no_test_packages(system):
    status, _, log = system("demo", "B=build/no-such-tree", here=packages("build"), status=0)
    assert status != 0 and log == "", "it goes on to compile, which this system cannot"
    status, _, log = system("check", "B=build/no-such-tree", here=packages("build"), status=100)
    assert status != 0 and "libcmocka-dev" in log


def test_deb_installs_what_makes_packages(system):
    _, _, log = system("deb", "B=build/no-such-tree", here=packages("build"), status=100)
    assert log == "apt-get install -y --no-install-recommends dpkg-dev\n"


def test_a_wheel_and_the_joined_sources_install_what_they_need(system):
    _, _, log = system("wheel", "B=build/no-such-tree", here=packages("build"), status=100)
    assert log == "apt-get install -y --no-install-recommends python3-venv\n"
    _, _, log = system("amalgamation", here=(), status=100)
    assert log == "apt-get install -y --no-install-recommends python3 dpkg-dev\n"


@pytest.mark.parametrize("check, asan, web, status, last", [
    ("7 passed, 0 failed", "5 passed, 0 failed", "2 passed, 0 failed", 0, "14 passed, 0 failed"),
    ("7 passed, 0 failed, 2 skipped", "5 passed, 0 failed", "2 passed, 0 failed, 1 skipped", 0, "14 passed, 0 failed, 3 skipped"),
    ("7 passed, 1 failed", "5 passed, 0 failed", "2 passed, 0 failed", 2, "14 passed, 1 failed"),
    ("does not compile", "5 passed, 0 failed", "2 passed, 0 failed", 2, "7 passed, 1 failed"),
    ("tests/unit/x.c: 3 passed, 0 failed\\n3 passed in 1 s\\n3 passed, 0 failed", "0 passed, 0 failed", "0 passed, 0 failed", 0, "3 passed, 0 failed"),
])
def test_ci_counts(tmp_path, check, asan, web, status, last):
    fake = tmp_path / "make"
    fake.write_text(f"#!/bin/bash\ncase $* in *asan*) echo -e '{asan}';; *web*) echo -e '{web}';; *) echo -e '{check}'; exit {status};; esac\n")
    fake.chmod(0o755)
    done = subprocess.run([ROOT / ".ci" / "run"], env=os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}, capture_output=True,
                          text=True)
    assert done.stdout.splitlines()[-1] == last and (done.returncode == 0) == (status == 0)


@pytest.mark.parametrize("output, status, last, exit_status", [
    ("1..2\nok 1 - a\nok 2 - b", 0, "{n} passed, 0 failed", 0),
    ("1..2\nok 1 - a\nnot ok 2 - b", 1, "{m} passed, 1 failed", 1),
    ("1..2\nok 1 - a\nnot ok 2 # SKIP b", 0, "{m} passed, 0 failed, 1 skipped", 0),
    ("1..2\nok 1 - a\nok 2 - b\nleaks", 1, "{n} passed, 1 failed", 1),
    ("1..2\nok 1 - a", 139, "{m} passed, 1 failed", 1),
    ("Segmentation fault", 139, "{l} passed, 1 failed", 1),
])
def test_runner_counts(tmp_path, output, status, last, exit_status):
    sources = [*sorted(ROOT.glob("tests/unit/test_*.c")), *sorted(ROOT.glob("tests/fuzz/fuzz_*.c*"))]
    for n, source in enumerate(sources):
        program = tmp_path / source.relative_to(ROOT).with_suffix("")
        program.parent.mkdir(parents=True, exist_ok=True)
        text, end = (output, status) if n == 1 else ("1..1\nok 1 - a", 0)
        program.write_text(f"#!/bin/bash\necho -e '{text}'\nexit {end}\n".replace("\\n", "\n"))
        program.chmod(0o755)
    done = subprocess.run([ROOT / "tests" / "run", "--unit", "--build", tmp_path], capture_output=True, text=True)
    others = len(sources) - 1
    assert done.stdout.splitlines()[-1] == last.format(n=others + 2, m=others + 1, l=others)
    assert done.returncode == exit_status
