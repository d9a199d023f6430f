# What people see: reports in a few lines, at length or not at all, colours, pipes without a reader; and what is read from pipes.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import os
import re
import subprocess

import pytest

import small_scene
from conftest import open_terminal
from small_scene import MORNING, NOON

SMALL = ("--resolution", 64)
LIGHTS = (("noon", "directional", NOON), ("morning", "directional", MORNING), ("up", "spot", (0, 1, 0)))
RED, YELLOW, GREEN = "\x1b[1;31m{}\x1b[0m", "\x1b[1;33m{}\x1b[0m", "\x1b[1;32m{}\x1b[0m"


@pytest.fixture(scope="module")
def folder(vxs, tmp_path_factory):
    at = tmp_path_factory.mktemp("terminal")
    small_scene.write(at / "three.gltf", lights=LIGHTS)
    small_scene.write(at / "open.gltf", open_faces=True)
    vxs("bake", at / "three.gltf", "-o", at / "a.vxs", *SMALL, "--light", "noon", "--json", at / "bake.json")
    vxs("bench", at / "open.gltf", "-o", at / "bench.json", *SMALL, "--runs", 1, "--points", 0)
    return at


@pytest.fixture
def shell(vxs_path, folder):
    """shell(script): bash in that folder, with `vxs` on its path."""

    def run(script):
        return subprocess.run(["bash", "-c", script], cwd=folder, capture_output=True, text=True, timeout=60,
                              env=os.environ | {"PATH": f"{vxs_path.parent}:{os.environ['PATH']}"})

    return run


def has_lines(text, *patterns):
    lines = text.splitlines()
    assert len(lines) == len(patterns) and all(re.fullmatch(p, line) for p, line in zip(patterns, lines)), text
    assert max(map(len, lines)) <= 80, text
    return True


# --- how much is said -----------------------------------------------------------------------------------------------------------------


def test_a_bake_says_the_essential(vxs, folder, monkeypatch):
    """What was baked, what was left out and why, size, time; and unrequested items beside what reaches nothing."""
    monkeypatch.chdir(folder)
    done = vxs("bake", "three.gltf", "-o", "b.vxs", *SMALL, "--light", "noon", "--light", "up")
    assert has_lines(done.stdout, r"scene +three.gltf: 24 triangles, 100 % of them in solids",
                     r"light +noon; 64 x 64 texels of 0\.[23]\d+ m", r"left out +morning: not requested",
                     r"left out +up: reaches no caster",
                     rf"file +b.vxs: {(folder / 'b.vxs').stat().st_size} B; depth maps are [\d.]+ times that",
                     r"time +[\d.]+ s, [\d.]+ of it [a-zA-Z ]+; memory [\d.]+ MiB")
    assert done.stderr.startswith("vxs: warning: light 'up' reaches no caster: it is left out; ") and done.stderr.count("\n") == 1


def test_many_lights_have_a_line(vxs, tmp_path):
    lights = [(f"lamp of the street number {n}", "directional", (n / 100, -1, 0)) for n in range(40)]
    lights += [("bulb", "point", NOON), ("slant", "directional", (1, -0.2, 1))]
    small_scene.write(tmp_path / "many.gltf", lights=lights)
    text = vxs("plan", tmp_path / "many.gltf", "--resolution", 8).stdout
    assert re.search(r"^lights +42: lamp of the street number 0 and 41 more; 8 x 8 texels each$", text, re.MULTILINE)
    text = vxs("plan", tmp_path / "many.gltf", "--resolution", 8, "--light", "bulb").stdout
    assert re.search(r"\nlight        bulb; 8 x 8 texels, six maps, of [\d.]+ to [\d.]+ m at casters, median [\d.]+ m\n"
                     r"left out     lamp of the street number 0 and 40 more: not requested\n", text)
    text = vxs("plan", tmp_path / "many.gltf", "--texel", 0.26, "--light", "slant", "--light", "lamp of the street number 0").stdout
    assert re.search(r"^lights +2: slant and 1 more; 64 to 128 texels a side$", text, re.MULTILINE)


def test_a_plan_says_the_essential(vxs, folder, monkeypatch):
    monkeypatch.chdir(folder)
    text = vxs("plan", "three.gltf", *SMALL, "--light", "noon", "--light", "morning").stdout
    assert has_lines(text, r"scene .*", r"lights +2: noon, morning; 64 x 64 texels each", r"left out +up: not requested",
                     r"estimate +[\d.e-]+ s, .* of memory, a file of .*, .* when loaded")


def test_a_comparison_says_the_essential(vxs, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(folder)
    text = vxs("compare", "three.gltf", "a.vxs", "--points", 200000, "--filter", 3, "--camera").stdout
    assert has_lines(text, r"scene .*", r"asset +a.vxs: 1 light, a file of \d+ B, \d+ B in memory",
                     r"wrong +[\d.]+ % of \d+ points \(random [\d.]+, surface [\d.]+, camera [\d.]+\)",
                     r"filters +3 x 3: RMSE random [\d.]+, surface [\d.]+, camera [\d.]+", r"lookup +[\d.]+ ns on one thread", r"result +passed")
    text = vxs("compare", folder / "three.gltf", folder / "a.vxs", "--points", 2000, "--max-error", 0, status=1).stdout
    assert text.endswith("\nresult       FAILED: more is wrong than --max-error 0; --verbose says where\n")
    other = small_scene.write(tmp_path / "other.gltf", boxes=(small_scene.GROUND, ((-5, 2, -5), (5, 3, 5))))
    text = vxs("compare", other, folder / "a.vxs", "--points", 2000, "--max-error", 0.001, "--other-scene", status=1).stdout
    assert re.search(r"\nresult +FAILED: \d+ wrong answers that nothing explains, and \d+ points in light deep behind casters, and more is wrong than --max-error 0.001; ", text)


def test_several_assets_have_a_table(vxs, folder):
    text = vxs("compare", folder / "three.gltf", folder / "a.vxs", folder / "a.vxs", "--points", 1000).stdout
    assert [line.split()[0] for line in text.splitlines()] == ["scene", "texels", "64", "64"]


def test_mending_lists_components_on_demand(vxs, folder, tmp_path):
    command = ("mend", folder / "open.gltf", "-o", tmp_path / "m.glb")
    brief, full = vxs(*command).stdout, vxs(*command, "--verbose").stdout
    assert [line.split()[0] for line in brief.splitlines()] == ["scene", "in", "closed", "solids", "wrote"]
    assert full.count("\ncomponent of ") == 2 == vxs(*command, "--all").stdout.count("\ncomponent of ")
    assert re.sub("\ncomponent of .*", "", full) == brief


COMMANDS = {
    "bake": ("three.gltf", "-o", "{out}", *SMALL),
    "plan": ("three.gltf", *SMALL),
    "info": ("a.vxs",),
    "validate": ("a.vxs",),
    "compare": ("three.gltf", "a.vxs", "--points", 100),
    "bench": ("open.gltf", "-o", "{out}", *SMALL, "--runs", 1, "--points", 0, "--against", "bench.json"),
    "health": ("three.gltf",),
    "mend": ("three.gltf", "-o", "{out}"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_quiet_leaves_no_report(vxs_path, folder, tmp_path, command):
    """Not on a terminal either; the exit status and outputs stay, and so does what --json requests."""
    arguments = [str(a).format(out=tmp_path / "out") for a in COMMANDS[command]]
    done = subprocess.run([vxs_path, command, *arguments, "--quiet"], cwd=folder, capture_output=True, text=True)
    warned = command in ("bake", "plan")
    assert (done.returncode, done.stdout) == (0, "") and done.stderr.count("vxs: warning: ") == done.stderr.count("\n") == warned
    assert (tmp_path / "out").exists() == ("-o" in arguments)
    assert subprocess.run([vxs_path, command, *arguments], cwd=folder, capture_output=True).stdout
    said = on_a_terminal([vxs_path, command, *arguments, "--quiet"], folder)
    assert said.count("\n") == said.count("warning") == warned and "\x1b[K" not in said
    if "-o" not in arguments:
        done = subprocess.run([vxs_path, command, *arguments, "--quiet", "--json", "-"], cwd=folder, capture_output=True, text=True)
        assert json.loads(done.stdout)


def test_quiet_says_what_is_wrong(vxs, folder, tmp_path):
    broken = tmp_path / "broken.vxs"
    broken.write_bytes((folder / "a.vxs").read_bytes()[:-1])
    assert vxs("validate", broken, "--quiet", status=1).stdout == ""
    assert vxs("info", broken, "--quiet", status=3).stderr.startswith("vxs: error: ")
    fast = json.loads((folder / "bench.json").read_text())
    for spread in ("wall_seconds", "total_seconds"):
        fast["cells"][0]["bake"][spread] = {"min": 1e-9, "median": 1e-9, "max": 1e-9}
    (tmp_path / "fast.json").write_text(json.dumps(fast))
    done = vxs("bench", folder / "open.gltf", "-o", tmp_path / "b.json", *SMALL, "--runs", 1, "--points", 0, "--quiet",
               "--against", tmp_path / "fast.json", "--max-slower", 2, status=1)
    assert done.stdout == done.stderr == ""


def test_answers_are_no_report(vxs, folder):
    for command in (("query", folder / "a.vxs"), ("truth", folder / "three.gltf", "--light", "noon")):
        assert vxs(*command, "--quiet", input="0 0.5 0\n3 0.5 0\n").stdout == "0\n1\n"
    assert vxs("scene", "stress", "--case", "list", "--quiet").stdout


def test_quiet_and_verbose_exclude_each_other(vxs, folder):
    said = vxs("info", folder / "a.vxs", "--quiet", "--verbose", status=2).stderr
    assert said == "vxs: error: --quiet and --verbose exclude each other\n"


# --- pipes without a reader ----------------------------------------------------------------------------------------------------------


def to_nobody(vxs_path, *arguments, cwd=None, input=None):
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([vxs_path, *map(str, arguments)], stdout=writer, stderr=subprocess.PIPE, text=True, cwd=cwd, input=input)
    os.close(writer)
    return done


@pytest.mark.parametrize("command", [*COMMANDS, "--help", "--version"])
def test_a_report_that_nobody_reads_is_silent(vxs_path, folder, tmp_path, command):
    """And no failure: outputs are written, whole."""
    arguments = [str(a).format(out=tmp_path / "out") for a in COMMANDS.get(command, ())]
    done = to_nobody(vxs_path, command, *arguments, cwd=folder)
    assert done.returncode == 0 and "error" not in done.stderr
    if command == "bake":
        whole = subprocess.run([vxs_path, "bake", "three.gltf", "-o", "-", *map(str, SMALL)], cwd=folder, capture_output=True).stdout
        assert (tmp_path / "out").read_bytes() == whole
    assert (tmp_path / "out").exists() == ("-o" in arguments)


def test_a_failure_keeps_its_status_when_nobody_reads(vxs_path, folder, tmp_path):
    assert to_nobody(vxs_path, "compare", "three.gltf", "a.vxs", "--points", 2000, "--max-error", 0, cwd=folder).returncode == 1
    done = to_nobody(vxs_path, "bake", "three.gltf", "-o", tmp_path / "nowhere" / "a.vxs", *SMALL, cwd=folder)
    assert done.returncode == 4 and "nowhere" in done.stderr


@pytest.mark.parametrize("command", [("query", "a.vxs"), ("truth", "three.gltf")])
def test_answers_end_where_nobody_reads_them(vxs_path, folder, shell, command):
    """At once, however many questions come, as SIGPIPE would end it."""
    done = to_nobody(vxs_path, *command, cwd=folder, input="0 0.5 0\n" * 200000)
    assert (done.returncode, done.stderr) == (141, "")
    done = shell(f"yes 0 0.5 0 | vxs {' '.join(command)} | head -1; echo ${{PIPESTATUS[@]}}")
    assert done.stdout.splitlines()[1] == "141 141 0" and done.stderr == ""


# --- colours --------------------------------------------------------------------------------------------------------------------------


def on_a_terminal(command, folder, **environment):
    """What a command prints to a terminal, both streams."""
    master, terminal = open_terminal()
    environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "TERM")} | {"TERM": "xterm"} | environment
    with subprocess.Popen([*map(str, command)], stdout=terminal, stderr=terminal, cwd=folder, env=environment) as process:
        os.close(terminal)
        said = b""
        while True:
            try:
                said += os.read(master, 4096)
            except OSError:
                break
    os.close(master)
    return said.decode().replace("\r\n", "\n")


def test_colours_follow_the_option(vxs, folder):
    """Errors, warnings, and how a check went; where they go does not matter then."""
    wrong = ("info", folder / "nobody.vxs", "--color")
    assert vxs(*wrong, "always", status=3).stderr.startswith("vxs: " + RED.format("error") + ": cannot read ")
    for mode in ("never", "auto"):
        assert vxs(*wrong, mode, status=3).stderr.startswith("vxs: error: ")
    assert vxs("validate", folder / "a.vxs", "--color=always").stdout == f"{folder}/a.vxs: {GREEN.format('valid')}\n"
    assert vxs("plan", folder / "three.gltf", "--color=always").stderr.startswith("vxs: " + YELLOW.format("warning") + ": light 'up'")
    compare = ("compare", folder / "three.gltf", folder / "a.vxs", "--points", 500, "--color", "always")
    assert vxs(*compare).stdout.endswith(GREEN.format("passed") + "\n")
    assert RED.format("FAILED") in vxs(*compare, "--max-error", 0, status=1).stdout
    assert "expected one of auto|always|never" in vxs(*wrong, "maybe", status=2).stderr


def test_colours_on_a_terminal(vxs_path, folder):
    command = [vxs_path, "info", folder / "nobody.vxs"]
    assert "\x1b" in on_a_terminal(command, folder) and "\x1b" in on_a_terminal(command, folder, NO_COLOR="")
    for no in (dict(NO_COLOR="1"), dict(TERM="dumb")):
        assert on_a_terminal(command, folder, **no).startswith("vxs: error: ")
    assert "\x1b" not in on_a_terminal([*command, "--color", "never"], folder)
    assert on_a_terminal([*command, "--color", "always"], folder, NO_COLOR="1").startswith("vxs: " + RED.format("error"))
    assert on_a_terminal([vxs_path, "nonsense"], folder).startswith("vxs: " + RED.format("error"))


@pytest.mark.parametrize("options", [[], ["--color", "always"]])
def test_no_escapes_without_a_terminal_but_on_demand(vxs, folder, tmp_path, options):
    """Progress is none in any case: its line needs a terminal that can write over it."""
    done = vxs("bake", folder / "three.gltf", "-o", tmp_path / "a.vxs", *SMALL, *options)
    assert (done.stdout + done.stderr).count("\x1b") == 2 * bool(options) and "\r" not in done.stderr


def test_progress_for_a_program(vxs, folder, tmp_path):
    """Lines of JSON on standard error, also without a report: shares that grow, and the time that is left where it is known."""
    done = vxs("bake", folder / "three.gltf", "-o", tmp_path / "a.vxs", "--resolution", 8192, "--light", "noon", "--quiet", "--progress", "json")
    lines = [json.loads(line) for line in done.stderr.splitlines()]
    assert lines[0] == {"doing": f"reading {folder / 'three.gltf'}"[:79]} and lines[-1]["doing"].startswith("writing ")
    assert all(set(line) <= {"share", "seconds_left", "doing"} for line in lines)
    shares = [line["share"] for line in lines if "share" in line]
    assert shares == sorted(shares) and all(0 <= share <= 1 for share in shares)


def test_no_progress_on_a_dumb_terminal(vxs_path, folder, tmp_path):
    command = [vxs_path, "bake", folder / "three.gltf", "-o", tmp_path / "a.vxs", *SMALL, "--color", "never"]
    assert "\x1b[K" in on_a_terminal(command, folder)
    assert "\x1b" not in on_a_terminal(command, folder, TERM="dumb")


# --- pipes that are read --------------------------------------------------------------------------------------------------------------


READERS = {  # {scene} and so on: an input; what else is on the line, and what shows that it was read
    "bake": ("{scene} -o - --resolution 8 --quiet | vxs validate -", "standard input: valid"),
    "plan": ("{scene} --resolution 8", "3|2"),
    "info": ("{asset}", "64 x 64 texels"),
    "validate": ("{asset}", "valid"),
    "truth": ("{scene} --light noon <<< '0 0.5 0'", "0"),
    "query": ("{asset} <<< '0 0.5 0'", "0"),
    "compare scene": ("{scene} a.vxs --points 500", "passed"),
    "compare asset": ("three.gltf {asset} --points 500", "passed"),
    "compare report": ("three.gltf a.vxs --points 500 --bake-report {bake} --json - --quiet", '"peak_bytes"'),
    "bench scene": ("{scene} -o - --resolution 8 --runs 2 --points 200 --light noon --quiet", '"wrong_share"'),
    "bench against": ("open.gltf -o /dev/null --resolution 64 --runs 1 --points 0 --against {bench}", "against .* of 20"),
    "report": ("{bench} -o -", "<html"),
    "render scene": ("{scene} a.vxs -o - --width 16 --height 16 | head -c 4 | tail -c 3", "PNG"),
    "render asset": ("three.gltf {asset} -o - --width 16 --height 16 | head -c 4 | tail -c 3", "PNG"),
    "health": ("{scene}", "24 triangles"),
    "mend": ("{scene} -o - --quiet | vxs health -", "24 triangles"),
}


@pytest.mark.parametrize("reader", READERS)
def test_every_input_may_be_a_pipe(shell, reader):
    """`-`, from a pipe or a file, and `<(...)`."""
    line, expected = READERS[reader]
    files = {"scene": "three.gltf", "asset": "a.vxs", "bake": "bake.json", "bench": "bench.json"}
    (name,) = re.findall(r"\{(\w+)\}", line)
    command = "vxs " + reader.split()[0] + " " + line

    def shows(script):
        done = shell(script)
        assert re.search(expected, done.stdout) and "error" not in done.stderr, done
        return True

    assert shows(command.replace("{%s}" % name, f"<(cat {files[name]})"))
    if reader in ("query", "truth"):
        return
    assert shows(f"cat {files[name]} | " + command.replace("{%s}" % name, "-"))
    first, pipe, rest = command.replace("{%s}" % name, "-").partition(" | ")
    assert shows(f"{first} < {files[name]}{pipe}{rest}")


def test_standard_input_is_read_from_where_it_stands(shell):
    assert "valid" in shell("cat three.gltf a.vxs > both; (head -c $(stat -c %s three.gltf) >/dev/null; vxs validate -) < both").stdout


def test_several_pipes_at_once(shell):
    assert "passed" in shell("vxs compare <(cat three.gltf) <(cat a.vxs) --points 500").stdout
    lines = shell("vxs compare - <(cat a.vxs) a.vxs --points 500 < three.gltf").stdout.splitlines()
    assert len(lines) == 4 and lines[0] == "scene        standard input"


def test_assets_of_other_solids_read_the_scene_once(shell):
    shell("vxs bake three.gltf -o off.vxs --resolution 64 --closed off --light noon")
    assert len(shell("cat three.gltf | vxs compare - a.vxs off.vxs --points 500").stdout.splitlines()) == 4


@pytest.mark.parametrize("line, says", [
    ("compare - -", "SCENE - and FILE.vxs -: standard input can be read once"),
    ("compare three.gltf - -", "FILE.vxs - and FILE.vxs -: "),
    ("report - bench.json - -o x", "BENCH.json - and BENCH.json -: "),
    ("bench - -o x --against -", "SCENE - and --against -: "),
    ("query -", "FILE.vxs -: points are read from standard input: expected a file or <(command)"),
    ("truth -", "SCENE -: points are read from standard input: expected a file or <(command)"),
])
def test_standard_input_is_read_once(shell, line, says):
    done = shell(f"vxs {line} < a.vxs")
    assert done.returncode == 2 and done.stderr.startswith(f"vxs: error: {says}") and done.stderr.count("\n") == 1


def test_standard_input_is_not_overwritten(shell, folder):
    before = (folder / "three.gltf").read_bytes()
    for line in ("mend - -o three.gltf", "bake - -o x --json three.gltf"):
        done = shell(f"vxs {line} < three.gltf")
        assert done.returncode == 2 and "is the input itself" in done.stderr
    assert (folder / "three.gltf").read_bytes() == before


def test_files_beside_a_piped_scene_are_those_of_the_working_folder(vxs_path, folder, tmp_path):
    gltf = json.loads((folder / "three.gltf").read_text())
    (tmp_path / "beside.bin").write_bytes(base64.b64decode(gltf["buffers"][0]["uri"].partition(",")[2]))
    gltf["buffers"][0]["uri"] = "beside.bin"
    text = json.dumps(gltf)
    command = [vxs_path, "health", "-"]
    assert "24 triangles" in subprocess.run(command, cwd=tmp_path, input=text, capture_output=True, text=True).stdout
    (tmp_path / "in.gltf").write_text(text)
    piped = subprocess.run(["bash", "-c", f"{vxs_path} health <(cat in.gltf)"], cwd=tmp_path, capture_output=True, text=True)
    assert "24 triangles" in piped.stdout
    done = subprocess.run(command, cwd=folder, input=text, capture_output=True, text=True)
    assert done.returncode == 3 and done.stderr.startswith("vxs: error: 'standard input': cannot read buffer 0, 'beside.bin': ")


@pytest.mark.parametrize("line, says", [
    ("info -", "'standard input' is not a valid .vxs file"), ("health -", "cannot read 'standard input': the file is empty"),
    ("report - -o x", "standard input: not JSON"), ("info <(exit)", "is not a valid .vxs file"),
])
def test_a_pipe_without_content(shell, line, says):
    done = shell(f"vxs {line} < /dev/null")
    assert done.returncode == 3 and says in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.slow
def test_a_pipe_of_too_much_json(shell):
    """A limit of size holds for what has no size."""
    done = shell("head -c 300000000 /dev/zero | tr '\\0' ' ' | vxs report - -o x")
    assert done.returncode == 3 and "larger than 256 MiB" in done.stderr


# --- names from files ---------------------------------------------------------------------------------------------------------------------


def test_no_name_speaks_to_the_terminal(vxs_path, tmp_path):
    """Names of lights, nodes, meshes, materials, images, scenes and files, in what every command prints: no control character but the end of a
    line, and no line that a name makes up."""
    name = "a\nvxs: error: fake\x1b[31m\x1b]0;t\x07\r\u009b2J\x7f\x08"
    scene, asset, picture = (tmp_path / f"{name}.{kind}" for kind in ("gltf", "vxs", "png"))
    small_scene.write(scene, lights=[(f"{name}{n}", *light[1:]) for n, light in enumerate(small_scene.EACH_KIND)], open_faces=True)
    gltf = json.loads(scene.read_text())
    for things in ("nodes", "meshes", "materials", "scenes"):
        gltf[things][0]["name"] = name
    gltf["images"] = [{"uri": f"x{name}.png", "name": name}]
    gltf["cameras"] = [{"type": "perspective", "name": name, "perspective": {"yfov": 1, "znear": 0.1}}]
    gltf["nodes"].append({"camera": 0, "name": name})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]) - 1)
    gltf["extensionsUsed"].append(f"EXT_{name}")
    scene.write_text(json.dumps(gltf))
    draw = ("render", scene, asset, "-o", picture, "--width", 16, "--height", 16)
    for status, *line in ((0, "plan", scene, "--verbose"), (0, "bake", scene, "-o", asset, *SMALL), (0, "bake", scene, "-o", asset, *SMALL, "--verbose"),
                          (0, "bake", scene, "-o", asset, *SMALL, "--if-changed"), (0, "info", asset), (0, "validate", asset), (0, "query", asset),
                          (0, "truth", scene, "--like", asset), (0, "compare", scene, asset, "--points", 10, "--verbose"),
                          (0, "compare", scene, asset, asset, "--points", 10), (0, "health", scene, "--verbose"),
                          (0, "mend", scene, "-o", tmp_path / f"{name}.glb", "--verbose"), (0, *draw, "--fog", 0.01, "--passes", tmp_path / f"p{name}"),
                          (0, *draw, "--verbose"), (0, "bake", scene, "-o", tmp_path / f"{name}.part", "--part", "1/1", "--resume", tmp_path / f"r{name}", *SMALL),
                          (0, "merge", tmp_path / f"{name}.part", "-o", asset), (0, "bench", scene, "-o", tmp_path / "b.json", "--resolution", 16, "--runs", 1, "--points", 1),
                          (0, "report", tmp_path / "b.json", "-o", tmp_path / f"{name}.html"), (2, "query", asset, "--light", f"{name}x"),
                          (3, "info", f"{asset}x"), (2, "bake", scene, "-o", asset, f"--{name}"), (5, "plan", scene, "--exclude", name),
                          (3, *draw, "--sky", scene), (0, *draw, "--camera", name), (2, *draw, "--camera", f"{name}x"),
                          (0, "scene", "city", "-o", tmp_path / f"{name}.glb", "--triangles", 1000, "--blocks", 1)):
        done = subprocess.run([vxs_path, *map(str, line)], input=b"0 1 0\n", capture_output=True, timeout=60)
        said = (done.stdout + done.stderr).decode()
        assert done.returncode == status, (line, said)
        assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f]", said) and "\nvxs: error: fake" not in said, (line, said)
