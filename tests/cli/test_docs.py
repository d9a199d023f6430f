# The documents hold what they say: options and exit statuses, links, schemas, and the listings of the guides and of the reference.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import re
import subprocess

import jsonschema
import pytest

import small_scene
from commands import COMMANDS, options

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted([ROOT / "README.md", *DOCS.glob("*.md"), *(ROOT / "scenes").glob("*.md"), *(ROOT / "formats").glob("*.md")])


@pytest.fixture(scope="module")
def asset(vxs, tmp_path_factory):
    """A baked scene: the folder, with scene.gltf, a.vxs and bake.json."""
    folder = tmp_path_factory.mktemp("docs")
    small_scene.write(folder / "scene.gltf")
    vxs("bake", folder / "scene.gltf", "-o", folder / "a.vxs", "--resolution", 64, "--json", folder / "bake.json")
    return folder


# --- the manual ---------------------------------------------------------------------------------------------------------------


MANUAL = (DOCS / "manual.md").read_text()


def manual_section(heading):
    return re.search(rf"^##+ {heading}\n(.*?)(?=^## |\Z)", MANUAL, re.MULTILINE | re.DOTALL)[1]


def named_in(text):
    """Options that a text names."""
    return {name for span in re.findall(r"`([^`\n]*)`", text) for name in re.findall(r"(?<![\w-])--?[a-z][a-z-]*", span)}


EVERYWHERE, STEPS = "in every command", "steps of a DAG, with --coding dag alone"
SHARED = "Options of several commands"


@pytest.mark.parametrize("command", COMMANDS)
def test_manual_has_every_option(vxs, command):
    """In the section of the command, or among those that several have; what it takes, units and defaults are only in the help."""
    names = {name for group, name, _, _ in options(vxs, command) if group != EVERYWHERE}
    here = manual_section(command if command != "plan" else "bake")
    assert names <= named_in(here) | named_in(manual_section(SHARED))


def test_manual_names_no_other_options(vxs):
    """What is shared is there in several commands, and what a section names is an option of some command."""
    of = {command: {name for _, name, _, _ in options(vxs, command)} for command in COMMANDS}
    every = set().union(*of.values()) | {"--version", "--help"}
    table = "".join(re.findall(r"^\|[^|]*\|", manual_section(SHARED).partition("\n### ")[0], re.MULTILINE))
    assert len(named_in(table)) > 20 and all(sum(name in found for found in of.values()) > 1 for name in named_in(table))
    assert named_in(MANUAL) - every == {"--name", "-colonly", "-v"}, "any option, a name of a collision shape, ulimit -v"


def test_plan_has_the_options_of_bake(vxs):
    """The manual states this, and does not repeat them."""
    bake, plan = ([(group, name, value) for group, name, value, _ in options(vxs, command)] for command in ("bake", "plan"))
    assert plan == bake and "vxs plan SCENE [options of bake]" in manual_section("plan")


@pytest.mark.parametrize("command", COMMANDS)
def test_help_says_each_default_once(vxs, command):
    """In one way, at the end."""
    for _, name, _, text in options(vxs, command):
        said = re.findall(r" \(default ([^()]+)\)$", text)
        assert text.count("default") == len(said), name


NEED_OTHERS = {"plan": ["--rule", "--reuse", "--compress", "--stop", "--smoke-extinction", "--smoke-nodes", "--smoke-error", "--gl"],
               "render": ["--width", "--height", "--fog-steps", "--fog-grid", "--area-gather", "--sky-light", "--sky-turn", "--smoke-side",
                          "--moving-by", "--upload", "--frames"],
               "scene": ["--size", "--height", "--capsules"], "mend": []}


def given_defaults(vxs, command, without):
    """Each option with the default that help tells, where that is a value that can be given."""
    found = []
    for group, name, value, text in options(vxs, command):
        default = re.search(r" \(default (\S+)\)$", text)
        if default and group != EVERYWHERE and name not in without and (default[1] in value.split("|") or re.match(r"-?\d", default[1])):
            found.append(f"{name}={default[1]}")
    return found


@pytest.mark.parametrize("command, least, line", [
    ("plan", 12, ["scene.gltf", "--json", "{}"]), ("scene", 4, ["city", "-o", "{}"]), ("mend", 4, ["scene.gltf", "-o", "{}"]),
    ("render", 14, ["scene.gltf", "a.vxs", "-o", "{}", "--width", "64", "--height", "48", "--fog", "0.05"])])
def test_defaults_of_help_are_the_defaults(vxs, asset, tmp_path, command, least, line):
    """What is made is the same with all of them given as without."""
    defaults, made = given_defaults(vxs, command, NEED_OTHERS[command]), []
    assert len(defaults) >= least
    for name, more in (("without", []), ("given", defaults)):
        out = tmp_path / f"{name}{'.json' if command == 'plan' else '.png' if command == 'render' else '.glb'}"
        vxs(command, *(str(asset / word) if "." in word and (asset / word).is_file() else word.format(out) for word in line), *more)
        made.append(out.read_bytes() if command != "plan" else {k: v for k, v in json.loads(out.read_text()).items() if k != "plan_seconds"})
    assert made[0] == made[1]


@pytest.mark.parametrize("command", COMMANDS)
def test_manual_has_the_options_of_every_command(vxs, command):
    listed = re.search(r"^Options of every command: (.*?)\n\n", manual_section("In common"), re.MULTILINE | re.DOTALL)[1]
    assert re.findall(r"`(--[a-z]+)`", listed) == [name for group, name, _, _ in options(vxs, command) if group == EVERYWHERE]


@pytest.mark.parametrize("command", ["bake", "plan"])
def test_steps_of_a_dag_stand_apart(vxs, command):
    steps = ["--rule", "--reuse", "--compress", "--stop"]
    assert [name for group, name, _, _ in options(vxs, command) if group == STEPS] == steps
    listed = manual_section("bake").partition("Steps of a DAG, for comparison with older work; each needs `--coding dag`:")[2]
    assert re.findall(r"`(--[a-z]+)` \(", listed.partition("\n\n")[0]) == steps


def test_command_lines_of_the_documents(vxs):
    """Each line of a document that calls vxs names a command and options that it has."""
    of = {command: {name for _, name, _, _ in options(vxs, command)} for command in COMMANDS}
    seen = 0
    for page in PAGES:
        text = page.read_text().replace("\\\n", " ")
        for line in re.findall(r"^(?:    |\t)(?:.*[|;] )?(vxs [a-z].*)$", text, re.MULTILINE):
            command, *rest = line.partition(" #")[0].partition(" | ")[0].split()[1:]
            if command in ("help",):
                continue
            assert command in COMMANDS, f"{page.name}: {line}"
            unknown = {word.partition("=")[0] for word in rest if re.match(r"--?[a-z]", word)} - of[command]
            assert not unknown, f"{page.name}: {line}"
            seen += 1
    assert seen > 40


def test_manual_has_every_command(vxs):
    listed = re.findall(r"^  (\w+)  ", vxs("--help").stdout, re.MULTILINE)
    assert listed == COMMANDS
    headings = re.findall(r"^## (\w+)$", MANUAL, re.MULTILINE)
    assert [h for h in headings if h in COMMANDS] == COMMANDS


def test_manual_has_every_exit_status():
    source = (ROOT / "baker" / "base" / "run_context.c").read_text()
    body = source[source.index("int exit_status"):]
    used = {int(n) for n in re.findall(r"return (\d+);", body)} | {1}
    listed = {int(n) for n in re.findall(r"^\| (\d+) \|", MANUAL, re.MULTILINE)}
    assert listed == used


# --- links ----------------------------------------------------------------------------------------------------------------------


def anchors(page):
    """As forges make them of headings: lower case, blanks to dashes, no punctuation."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if re.match(r"https?:", target):
            continue
        path, _, anchor = target.partition("#")
        other = (page.parent / path).resolve() if path else page
        assert other.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(other), f"{page.name}: {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_files_that_are_named_exist(page):
    for name in re.findall(r"`((?:baker|formats|runtime|tests|docs)/[\w./-]*)`", page.read_text()):
        assert (ROOT / name).exists(), f"{page.name}: {name}"


def test_every_page_is_linked():
    linked = set()
    for page in PAGES:
        linked |= {(page.parent / t.partition("#")[0]).resolve() for t in re.findall(r"\]\(([^)\s]+)\)", page.read_text())}
    assert {p for p in PAGES if p.parent == DOCS} <= linked
    assert {p for p in DOCS.glob("*.schema.json")} <= linked


def test_packages_are_explained():
    makefile = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    packages = " ".join(re.findall(r"^packages\.\w+\s*:= ([^$\n]*)$", makefile, re.MULTILINE)).split()
    text = (DOCS / "dependencies.md").read_text()
    assert len(packages) > 15 and [p for p in packages if f"`{p}`" not in text] == []


def test_changelog_begins_with_this_version(vxs):
    """The version is written once, in runtime/vxs.h; what has changed since is above it."""
    headings = re.findall(r"^## (.*)$", (DOCS / "CHANGELOG.md").read_text(), re.MULTILINE)
    numbers = re.findall(r"^#define VXS_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", (ROOT / "runtime" / "vxs.h").read_text(), re.MULTILINE)
    assert len(numbers) == 3 and headings[:2] == ["Unreleased", ".".join(numbers)]
    assert vxs("--version").stdout.split()[:2] == ["vxs", headings[1]]


# --- schemas --------------------------------------------------------------------------------------------------------------------


def validator(name):
    schema = json.loads((DOCS / f"{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_bake_report_schema(vxs, asset, tmp_path):
    report = json.loads((asset / "bake.json").read_text())
    validator("bake-report").validate(report)
    done = vxs("bake", asset / "scene.gltf", "-o", tmp_path / "b.vxs", "--resolution", 8, "--closed", "off",
               "--json", "-")
    validator("bake-report").validate(json.loads(done.stdout))
    with pytest.raises(jsonschema.ValidationError):
        validator("bake-report").validate({k: v for k, v in report.items() if k != "stages"})


def test_plan_schema(vxs, asset):
    validator("plan").validate(json.loads(vxs("plan", asset / "scene.gltf", "--json", "-").stdout))


def test_info_schema(vxs, asset):
    validator("info").validate(json.loads(vxs("info", asset / "a.vxs", "--json", "-").stdout))


def test_validate_schema(vxs, asset, tmp_path):
    validator("validate").validate(json.loads(vxs("validate", asset / "a.vxs", "--json", "-").stdout))
    data = bytearray((asset / "a.vxs").read_bytes())
    data[-1] ^= 1
    (tmp_path / "broken.vxs").write_bytes(data)
    report = json.loads(vxs("validate", tmp_path / "broken.vxs", "--json", "-", status=1).stdout)
    validator("validate").validate(report)
    assert report["findings"]


# --- listings (VXS_FLAGS: what libvxs.a was compiled with, sanitizers for instance) ---------------------------------------------------

WITH_LISTINGS = [ROOT / "README.md", *(DOCS / f"{name}.md" for name in ("guide-bake", "guide-shadows", "guide-fog", "runtime"))]


def listings(language, *pages):
    """Of the guides and the reference of libvxs, or of these pages."""
    text = "".join(page.read_text() for page in pages or WITH_LISTINGS[1:])
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def compile_listing(vxs_path, tmp_path_factory):
    """compile_listing(text, *options): a program of a listing and libvxs.a."""
    library = vxs_path.parent / "libvxs.a"
    if not library.is_file():
        pytest.skip(f"no {library}")

    def compiled(text, *options):
        folder = tmp_path_factory.mktemp("listing")
        (folder / "game.c").write_text(text)
        subprocess.run(["cc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'runtime'}", f"-I{ROOT / 'formats'}",
                        folder / "game.c", library, *os.environ.get("VXS_FLAGS", "").split(), "-lzstd", "-lxxhash", "-lm", *options,
                        "-o", folder / "game"], check=True)
        return folder / "game"

    return compiled


def run_on(program, path, points=""):
    done = subprocess.run([program, path], input=points, capture_output=True, text=True, check=True)
    assert not done.stderr
    assert subprocess.run([program, program.parent / "absent.vxs"], capture_output=True).returncode == 1
    return done.stdout


GROUND = "".join(f"{x / 4} 0 {z / 4} 0 1 0\n" for x in range(-12, 13) for z in range(-12, 13))


def test_five_lines_of_the_readme(vxs, asset, compile_listing, tmp_path):
    """They are five, and answer as vxs query does."""
    (lines,) = listings("c", WITH_LISTINGS[0])
    assert len(lines.splitlines()) == 5
    program = compile_listing("#include <stdio.h>\n#include <vxs.h>\nint main(void)\n{\n"
                              "    const double position_ws[3] = {0.6, 0, 0.4}, normal_ws[3] = {0, 1, 0};\n"
                              f"{lines}    return printf(\"%.6g\\n\", lit) < 0;\n}}\n")
    (tmp_path / "level.vxs").write_bytes((asset / "a.vxs").read_bytes())
    done = subprocess.run([program], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == vxs("query", asset / "a.vxs", "--filter", 9, input="0.6 0 0.4 0 1 0\n").stdout and 0 < float(done.stdout) < 1
    assert subprocess.run([program], cwd=program.parent, capture_output=True).returncode == 1


@pytest.mark.parametrize("on_threads", [False, True])
def test_listing_in_c(vxs, asset, compile_listing, on_threads):
    others = ("vxs_query.h", "vxs_stream.h", "vxs_gl.h", "vxs_volumes.h")
    game, threads = (text for text in listings("c") if not any(header in text for header in others))
    if on_threads:
        game = game.replace("int main", threads + "\nint main")
        game, count = re.subn(r"vxs_asset_open_file\((&shadows, .*), NULL\)", r"open_on_threads(\1)", game)
        assert count == 1
    program = compile_listing(game, "-fopenmp")
    done = subprocess.run([program, asset / "a.vxs"], input=GROUND, capture_output=True, text=True, check=True).stdout
    assert done == vxs("query", asset / "a.vxs", "--filter", 9, input=GROUND).stdout
    assert len(set(done.split())) > 10, "lit, dark, and between"
    assert subprocess.run([program, program.parent / "absent.vxs"], capture_output=True).returncode == 1


@pytest.fixture(scope="module")
def run_query(compile_listing):
    """run(function, asset, input): what the listing printed that calls a function of vxs_query.h."""

    def run(function, path, points=""):
        listing, = (text for text in listings("c") if f"{function}(" in text and "vxs_query.h" in text)
        return run_on(compile_listing(listing), path, points)

    return run


def test_listing_of_batches(vxs, asset, run_query):
    found = run_query("vxs_lookup_batch", asset / "a.vxs", GROUND)
    assert found == vxs("query", asset / "a.vxs", "--filter", 9, input=GROUND).stdout
    assert len(set(found.split())) > 10, "lit, dark, and between"


def test_listing_of_depth_maps(vxs, asset, run_query):
    """The voxel where light ends is in shadow, and the one before it on its way, a voxel nearer the light, is lit."""
    light = json.loads(vxs("info", asset / "a.vxs", "--json", "-").stdout)["lights"][0]
    points = run_query("vxs_depth_map", asset / "a.vxs")
    behind = vxs("query", asset / "a.vxs", input=points).stdout.split()
    step = [n * light["voxel_m"] for n in light["direction"]]
    nearer = "".join("%.17g %.17g %.17g\n" % tuple(float(p) - s for p, s in zip(line.split(), step)) for line in points.splitlines())
    before = vxs("query", asset / "a.vxs", input=nearer).stdout.split()
    assert len(behind) == len(before) == 32 * 32
    dark = [n for n in range(32 * 32) if behind[n].startswith("0")]
    assert len(dark) > 100, "there are casters, and a ground"
    assert all(before[n].startswith("1") for n in dark)


def test_listing_of_rays(vxs, asset, run_query):
    """Against single taps at many points of each segment."""
    segments = [((x / 2, 0.05, -3), (3 - x / 4, 2, 3)) for x in range(-6, 7)]
    found = [float(n) for n in run_query("vxs_lit_next", asset / "a.vxs", "".join("%g %g %g %g %g %g\n" % (a + b) for a, b in segments)).split()]
    steps = 1000
    points = "".join("%.17g %.17g %.17g\n" % tuple(p + (q - p) * (n + 0.5) / steps for p, q in zip(a, b)) for a, b in segments for n in range(steps))
    taps = [line == "1" for line in vxs("query", asset / "a.vxs", "--filter", 1, input=points).stdout.split()]
    for n, lit in enumerate(found):
        assert abs(sum(taps[n * steps:(n + 1) * steps]) / steps - lit) < 0.01, segments[n]
    assert min(found) < 0.95 and max(found) > 0.5, "some are in shadow"


@pytest.mark.parametrize("header, folders", [("vxs_gl.h", ["gl"]), ("vxs_volumes.h", ["gl", "volumes"])])
def test_listing_of_opengl(tmp_path, header, folders):
    """It compiles; tests/unit/test_gl.c and test_gl_stream.c run what the first calls, and test_example.py the second."""
    listing, = (text for text in listings("c") if f"<{header}>" in text)
    (tmp_path / "gl.c").write_text(listing)
    subprocess.run([*os.environ.get("CC", "cc").split(), "-std=c99", "-Wall", "-Wextra", "-Werror",
                    *(f"-I{ROOT / 'runtime' / folder}" for folder in folders),
                    f"-I{ROOT / 'runtime'}", f"-I{ROOT / 'formats'}", "-c", "gl.c"], cwd=tmp_path, check=True)


def test_listing_of_streams(vxs, asset, compile_listing):
    listing, = (text for text in listings("c") if "<vxs_stream.h>" in text)
    assert run_on(compile_listing(listing, "-lpthread"), asset / "a.vxs", GROUND) == vxs("query", asset / "a.vxs", "--filter", 9, input=GROUND).stdout


def test_listing_of_godot():
    """It is the example that tests/godot runs."""
    assert (ROOT / "runtime/godot/example/main.gd").read_text().partition("extends")[2] in (DOCS / "godot.md").read_text()


def test_listings_of_shaders():
    """One is in tests/shaders, which test_shaders.py compiles and tests/unit/test_shaders.c runs; the other is that of the guide to fog."""
    shaders = ROOT / "tests" / "shaders"
    lit, fog = listings("glsl")
    assert lit == (shaders / "lit_430.frag").read_text() and "vxs_air_path.h" in fog


def test_table_of_shaders():
    text = (DOCS / "runtime.md").read_text()
    assert set(re.findall(r"^\| `(lit\S*)` \|", text, re.MULTILINE)) == {path.name for path in (ROOT / "tests" / "shaders").iterdir()}


# --- words --------------------------------------------------------------------------------------------------------------------


# in identifiers and file names of the product: each has one word of the glossary instead
OTHER_WORDS = re.compile(r"(?<![a-z])(kept_squares?|keepers?|square_fate|own_(patterns?|planes?|tiles?|set)|light_maps?|lamps?|shines?|shining|give_back|put_back"
                         r"|vxs_beside|vxs_take|let_meet|area_holes|pierce[ds]?|freedom|gate|desk)(?![a-z])")
NAMES_OF_SCENES = ("scenes/", "baker/command/options/bake_arguments.c")  # street lamps, and lights of that name


def test_code_has_the_words_of_the_glossary():
    files = [p for folder in ("baker", "formats", "runtime", "scenes") for p in (ROOT / folder).rglob("*") if p.suffix in (".c", ".cc", ".h", ".hpp", ".glsl")]
    found = []
    for path in files:
        name = str(path.relative_to(ROOT))
        text = name + "\n" + re.sub(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', " ", path.read_text(), flags=re.DOTALL)
        found += [f"{name}: {word[0]}" for word in OTHER_WORDS.finditer(text) if not name.startswith(NAMES_OF_SCENES)]
    assert len(files) > 300 and not found
