# What the command says of itself: help, the words that were probably meant, manual pages, and completion as shells do it.
# SPDX-License-Identifier: GPL-3.0-or-later
import fcntl
import itertools
import json
import os
import re
import shutil
import struct
import subprocess
import termios
import threading
import time

import pytest

import small_scene
from commands import COMMANDS, options, rows
from conftest import ROOT, open_terminal

# --- help ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command(vxs, command):
    text = vxs(command, "--help").stdout
    assert vxs("help", command).stdout == text == vxs(command, "-h").stdout
    assert max(map(len, text.splitlines()[1:])) <= 80
    listed = rows(vxs, command)
    assert all(said for _, _, _, said in listed)
    assert "--help" in [name for _, name, _, _ in listed]
    usage = text.splitlines()[0].split()[2:]
    optional = re.compile(r"\[(?!options)[^\]]+\]")
    operands = [word.strip("[]") for word in itertools.takewhile(lambda word: word[0] not in "-[<" or optional.fullmatch(word), usage)]
    assert operands and [word.removesuffix("...") for word in operands] == [name for group, name, _, _ in listed if group == "operands"]


def test_help_lists_the_commands(vxs):
    text = vxs("--help").stdout
    assert vxs("help").stdout == text == vxs("-h").stdout == vxs("help", "--help").stdout
    assert re.findall(r"^  (\w+)  +\S", text, re.MULTILINE) == COMMANDS and "vxs help COMMAND" in text
    assert max(map(len, text.splitlines())) <= 80


def test_no_command_lists_the_commands(vxs):
    done = vxs(status=2)
    assert (done.stdout, done.stderr) == ("", vxs("--help").stdout)


def read_some(terminal):
    """Nothing in the end, when the other side is closed."""
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""


@pytest.mark.parametrize("columns, least, most", [(120, 100, 120), (66, 50, 66), (20, 50, 56)])
def test_help_fits_the_terminal(vxs_path, columns, least, most):
    ours, its = open_terminal()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen([vxs_path, "help", "bake"], stdout=its)
    os.close(its)
    text = b"".join(iter(lambda: read_some(ours), b""))
    assert process.wait() == 0
    os.close(ours)
    assert least < max(len(line) for line in text.decode().splitlines()[1:]) <= most


@pytest.mark.parametrize("line, says", [
    (["bkae"], "unknown command 'bkae': did you mean 'bake'? vxs --help lists the commands"),
    (["help", "bkae"], "unknown command 'bkae': did you mean 'bake'? vxs --help lists the commands"),
    (["hlep"], "unknown command 'hlep': did you mean 'help'? vxs --help lists the commands"),
    (["help", "toast"], "unknown command 'toast': vxs --help lists the commands"),
    (["help", "bake", "plan"], "unexpected argument 'plan': usage is vxs help COMMAND"),
    (["bake", "--resolutoin", "64"], "unknown option '--resolutoin': did you mean '--resolution'? vxs bake --help lists the options"),
    (["bake", "--resolutoin=64"], "unknown option '--resolutoin=64': did you mean '--resolution'? vxs bake --help lists the options"),
    (["bake", "-resolution", "64"], "unknown option '-resolution': did you mean '--resolution'? vxs bake --help lists the options"),
    (["bake", "--frobnicate"], "unknown option '--frobnicate': vxs bake --help lists the options"),
    (["bake", "--" + "frobnicate" * 200], ""),
    (["bake", "--closed", "atuo"], "--closed atuo: expected one of auto|on|off: did you mean 'auto'?"),
    (["bake", "--closed", "maybe"], "--closed maybe: expected one of auto|on|off"),
    (["scene", "ctiy"], "KIND ctiy: expected one of city|landscape|room|forest|smoke|hair|stress: did you mean 'city'?"),
    (["bake", "--help=mann"], "--help mann: expected one of text|man|bash|zsh|fish|text-row|man-row: did you mean 'man'?"),
    (["--help=html"], "--help html: expected one of text|man|bash|zsh|fish"),
])
def test_what_was_meant(vxs, line, says):
    done = vxs(*line, status=2)
    assert done.stdout == "" and done.stderr.startswith("vxs: error: ") and done.stderr.endswith(says + "\n")
    assert len(done.stderr.splitlines()) == 1


# --- manual pages ----------------------------------------------------------------------------------------------------------------


def man(vxs, command):
    return vxs(*([command] if command else []), "--help=man").stdout


@pytest.mark.parametrize("command", [None, *COMMANDS])
def test_manual_page_is_sound(vxs, command):
    checkers = {"groff": ["groff", "-man", "-ww", "-z", "-Tutf8"], "mandoc": ["mandoc", "-T", "lint", "-W", "warning"]}
    here = {name: line for name, line in checkers.items() if shutil.which(name)}
    if not here:
        pytest.skip("neither groff nor mandoc: package groff-base")
    page = man(vxs, command).replace('1 ""', '1 "2026-01-01"', 1)
    for line in here.values():
        done = subprocess.run(line, input=page, capture_output=True, text=True)
        assert (done.returncode, done.stdout + done.stderr) == (0, "")


def shown(page):
    """A page as it is read, in one line."""
    if not shutil.which("groff"):
        pytest.skip("no groff: package groff-base")
    done = subprocess.run(["groff", "-man", "-Tascii", "-P-cbou", "-rLL=1000n", "-rHY=0"], input=page, capture_output=True, text=True, check=True)
    return re.sub(r"\s+", " ", done.stdout)


@pytest.mark.parametrize("command", COMMANDS)
def test_manual_page_says_what_help_says(vxs, command):
    page = shown(man(vxs, command))
    assert f"NAME vxs-{command} - " in page and f"SYNOPSIS vxs {command} " in page and "SEE ALSO vxs(1)" in page
    for _, name, value, text in rows(vxs, command):
        assert re.sub(r"\s+", " ", f" {name} {value} {text} ") in page


def test_manual_pages_list_commands_and_statuses(vxs):
    page = shown(man(vxs, None))
    for command in COMMANDS:
        assert f" vxs-{command}(1) " in page
    statuses = re.findall(r"^\| (\d+) \|", (ROOT / "docs" / "manual.md").read_text(), re.MULTILINE)
    for text in (man(vxs, None), man(vxs, "bake")):
        part = text.partition(".SH EXIT STATUS\n")[2].partition(".SH")[0]
        assert re.findall(r"^\.TP\n\.B (\d+)\n\S", part, re.MULTILINE) == statuses


# --- completion ------------------------------------------------------------------------------------------------------------------

FILES = ["a b.glb", "c.gltf", "d.vxs", "e.json", "f.png", "g.txt", "old.json", "page.html"]
KINDS = ["city", "forest", "hair", "landscape", "room", "smoke", "stress"]
SCENES, FOLDER = ["a b.glb", "c.gltf"], ["sub"]

# a line up to where it is completed, and what it may go on with
LINES = [
    ("vxs ba", ["bake"]),
    ("vxs ", sorted([*COMMANDS, "help"])),
    ("vxs help pl", ["plan"]),
    ("vxs bake --clo", ["--closed"]),
    ("vxs bake --closed ", ["auto", "off", "on"]),
    ("vxs bake --closed=o", ["off", "on"]),
    ("vxs bake c.gltf --exit p", ["peel"]),
    ("vxs bench --compress t", ["top-down"]),
    ("vxs plan --resolution ", []),
    ("vxs bake ", SCENES + FOLDER),
    ("vxs bake -o ", ["d.vxs"] + FOLDER),
    ("vxs bake --resolution 64 ", SCENES + FOLDER),
    ("vxs bake --json ", ["e.json", "old.json"] + FOLDER),
    ("vxs render -o ", ["f.png"] + FOLDER),
    ("vxs scene ", KINDS),
    ("vxs scene f", ["forest"]),
    ("vxs toast --", []),
]
# what bash and zsh know besides: which operand comes next
POSITIONS = [
    ("vxs compare ", SCENES + FOLDER),
    ("vxs compare --camera c.gltf ", ["d.vxs"] + FOLDER),
    ("vxs compare c.gltf d.vxs ", ["d.vxs"] + FOLDER),
    ("vxs compare --points 5 c.gltf ", ["d.vxs"] + FOLDER),
    ("vxs view c.gltf ", ["d.vxs"] + FOLDER),
    ("vxs report ", ["e.json", "old.json"] + FOLDER),
    ("vxs report e.json ", ["e.json", "old.json"] + FOLDER),
]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("place")
    for name in FILES:
        (folder / name).touch()
    (folder / "sub").mkdir()
    return folder


def script(vxs, folder, shell):
    if not shutil.which(shell):
        pytest.skip(f"no {shell}: package {shell}")
    path = folder.parent / {"bash": "vxs.bash", "zsh": "_vxs", "fish": "vxs.fish"}[shell]
    path.write_text(vxs(f"--help={shell}").stdout)
    return path


def run_shell(line, folder, text):
    done = subprocess.run(line, input=text, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return done.stdout


def bash_words(line):
    """As bash cuts a line for completion: `=` is a word."""
    return re.findall(r"=|[^ =]+", line) + ([""] if line[-1] in " =" else [])


@pytest.mark.parametrize("options", [[], ["-u"], ["-O", "extglob", "-f"]], ids=["plain", "nounset", "noglob"])
def test_bash_completes(vxs, place, options):
    lines = LINES + POSITIONS + [("vxs info d.vxs ", [])]
    text = f"source {script(vxs, place, 'bash')}\n"
    for line, _ in lines:
        words = bash_words(line)
        quoted = " ".join(f"'{word}'" for word in words)
        text += f'COMP_WORDS=({quoted}) COMP_CWORD={len(words) - 1}\n_vxs\nprintf "%s\\n" "${{COMPREPLY[@]}}" %%\n'
    answers = run_shell(["bash", "--norc", *options], place, text).split("%%\n")
    for (line, expected), answer in zip(lines, answers):
        ours = {"help", "--help", "--version"} - set(expected) if line == "vxs " else set()
        assert sorted(set(answer.split("\n")) - {""} - ours) == sorted(expected), line


def test_every_option_is_completed(vxs, place):
    text = f"source {script(vxs, place, 'bash')}\n"
    for command in COMMANDS:
        text += f'COMP_WORDS=(vxs {command} -) COMP_CWORD=2\n_vxs\necho "${{COMPREPLY[@]}}"\n'
    for command, answer in zip(COMMANDS, run_shell(["bash", "--norc"], place, text).splitlines()):
        assert answer.split() == [name for _, name, _, _ in options(vxs, command)]


def test_fish_completes(vxs, place):
    path = script(vxs, place, "fish")
    text = f"source {path}\n" + "".join(f"complete -C '{line}'; echo %%\n" for line, _ in LINES)
    for (line, expected), answer in zip(LINES, run_shell(["fish", "--no-config"], place, text).split("%%\n")):
        found = sorted(each.split("\t")[0].replace("--closed=", "").rstrip("/") for each in answer.splitlines())
        assert found == sorted(expected), line


# What is offered is written down besides, with a line %% when all is.
ZSH = r"""
fpath=(SCRIPTS $fpath); autoload -U compinit; compinit -u -D
compadd() {
    if [[ ${@[1,(i)(-|--)]} != *-(O|A|D)\ * ]]; then
        typeset -a hits
        builtin compadd -A hits "$@"
        ((${#hits})) && print -rl -- $hits >>OUT
    fi
    builtin compadd "$@"
}
whole() { _main_complete; print -r -- %% >>OUT; compstate[insert]= compstate[list]= }
zle -C whole complete-word whole; bindkey '^I' whole
"""


def test_zsh_completes(vxs, place):
    path, out, rc = script(vxs, place, "zsh"), place.parent / "zsh.out", place.parent / "zshrc"
    rc.write_text(ZSH.replace("SCRIPTS", str(path.parent)).replace("OUT", str(out)))
    out.write_text("")
    ours, its = open_terminal()
    process = subprocess.Popen(["zsh", "-f", "-i"], stdin=its, stdout=its, stderr=its, cwd=place, start_new_session=True,
                               env={**os.environ, "TERM": "dumb"})
    os.close(its)
    drain = threading.Thread(target=lambda: [None for _ in iter(lambda: read_some(ours), b"")], daemon=True)
    drain.start()
    lines = LINES + POSITIONS
    os.write(ours, f"source {rc}\n".encode())
    for n, (line, expected) in enumerate(lines):
        os.write(ours, b"\x15" + line.encode() + b"\t")
        end = time.monotonic() + 60
        while out.read_text().count("%%\n") <= n:
            assert time.monotonic() < end and process.poll() is None, f"{line}: no answer"
            time.sleep(0.01)
        answer = out.read_text().split("%%\n")[n]
        assert sorted(set(answer.replace("\\", "").splitlines()) - {""}) == sorted(expected), line
    os.write(ours, b"\x15exit\n")
    process.wait(60)
    drain.join(60)
    os.close(ours)


# --- abbreviations ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("line, says", [
    (["bake", "--res", "64"], "unknown option '--res': did you mean '--resolution' or '--resume'? vxs bake --help lists the options"),
    (["plan", "--resol=64"], "unknown option '--resol=64': did you mean '--resolution'? vxs plan --help lists the options"),
    (["render", "--cam", "x"], "unknown option '--cam': did you mean '--camera'? vxs render --help lists the options"),
    (["bake", "--s"], "unknown option '--s': vxs bake --help lists the options"),  # too many
    (["bake", "--"], "SCENE is missing: usage is vxs bake SCENE -o OUT.vxs [options]"),
])
def test_options_that_are_cut_short(vxs, line, says):
    assert vxs(*line, status=2).stderr == f"vxs: error: {says}\n"


@pytest.mark.parametrize("word", ["-v", "-V", "version"])
def test_version_by_other_words(vxs, word):
    assert vxs(word).stdout == vxs("--version").stdout
    assert "unexpected argument 'bake': usage is vxs --version" in vxs(word, "bake", status=2).stderr


def test_resolution_in_thousands(vxs, tmp_path):
    scene = small_scene.write(tmp_path / "a.gltf", lights=(("sun", "directional", small_scene.NOON), ("lamp", "spot", small_scene.NOON)))
    for given, sides in (("4K", (4096, 4096)), ("16k", (16384, 16384)), ("lamp=1K", (4096, 1024))):
        plan = json.loads(vxs("plan", scene, "--resolution", given, "--json", "-").stdout)
        assert tuple(light["resolution_px"] for light in plan["lights"]) == sides
    for given, says in (("5K", "--resolution 5120: expected a power of two"), ("4KB", "--resolution 4KB: expected a whole number from 8 to 262144"),
                        ("512K", "--resolution 512K: expected a whole number"), ("K", "--resolution K: expected a whole number")):
        assert says in vxs("plan", scene, "--resolution", given, status=2).stderr
    assert "--filter 1K: expected a whole number" in vxs("compare", scene, scene, "--filter", "1K", status=2).stderr
