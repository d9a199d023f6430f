# Which folder may include which: every #include of the product follows the table "Folders" of docs/overview.md.
# SPDX-License-Identifier: GPL-3.0-or-later
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

def rules():
    """Folder: the folders that it may include."""
    section = (ROOT / "docs/overview.md").read_text().split("\n## Folders\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `([\w/.]+)` \|.*\|(.*)\|$", section, re.M)
    base = {"baker/base/"}
    return {folder: set(re.findall(r"`([\w/.]+)`", may)) | {folder} | (base if folder.startswith(("baker/", "scenes/")) and folder != "baker/" else set())
            for folder, may in rows}


def product_files():
    """File: the product's files that it includes, all by their paths."""
    files = [p for folder in ("baker", "formats", "runtime", "scenes") for p in (ROOT / folder).rglob("*") if p.suffix in (".c", ".cc", ".h")]
    quoted = re.compile(r'^ *# *include "([^"]+)"', re.M)

    def path_of(used, beside):
        return next(str(p.relative_to(ROOT)) for p in (ROOT / used, beside.parent / used, ROOT / "formats" / used, ROOT / "runtime" / used,
                                                           ROOT / "runtime/gl" / used, *(ROOT / "runtime/volumes").rglob(used)) if p.exists())

    return {str(p.relative_to(ROOT)): [path_of(used, p) for used in quoted.findall(p.read_text())] for p in files}


def folder_of(file):
    """baker/main.c stands above all rooms, and has a row of its own."""
    return file if file == "baker/main.c" else str(Path(file).parent) + "/"


def circle(edges):
    """Nodes that reach each other, each by the next; [] when there are none."""
    done, path = set(), []

    def walk(node):
        if node in path:
            return path[path.index(node):] + [node]
        if node in done:
            return []
        path.append(node)
        found = next(filter(None, map(walk, sorted(edges.get(node, ())))), [])
        path.pop()
        done.add(node)
        return found

    return next(filter(None, map(walk, sorted(edges))), [])


def modules():
    """JavaScript module: the product's modules that it imports by their paths. Packages, such as vxs and three, are no paths."""
    files = [p for folder in ("baker", "runtime") for p in (ROOT / folder).rglob("*.mjs")]
    imported = re.compile(r"""(?:from|import) *\(?['"](\.[^'"]+)['"]""")
    return {str(p.relative_to(ROOT)): [str((p.parent / used).resolve().relative_to(ROOT)) for used in imported.findall(p.read_text())] for p in files}


def python_modules():
    """Module of the Blender add-on, of vxs for Python or of the Godot add-on: those that it imports, from its own folder."""
    files = [p for folder in ("baker/blender", "runtime/python/vxs", "runtime/godot") for p in (ROOT / folder).glob("*.py")]
    return {str(p.relative_to(ROOT)): [str(p.parent.relative_to(ROOT) / f"{name}.py") for name in re.findall(r"^from \.(\w+) import", p.read_text(), re.M)]
            for p in files}


def test_every_folder_has_a_rule():
    assert {folder_of(file) for file in (*product_files(), *modules(), *python_modules())} == set(rules())


def test_includes_follow_the_rules():
    may = rules()
    assert not [f"{file}: {used}" for file, includes in {**product_files(), **modules()}.items() for used in includes
                if folder_of(used) not in may.get(folder_of(file), ())]


def test_the_laboratory_uses_installed_headers():
    """Of the runtime and the formats it knows what a game knows: so it proves the public interface."""
    installed = subprocess.run(["make", "-s", "--no-print-directory", "packages=skip", "--eval=print-headers: ; @echo $(headers)", "print-headers"],
                               cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    assert "runtime/vxs.h" in installed
    assert not [f"{file}: {used}" for file, includes in product_files().items() if file.startswith(("baker/lab/", "scenes/"))
                for used in includes if used.startswith(("runtime/", "formats/")) and used not in installed]


@pytest.mark.parametrize("name", [folder_of, lambda file: file], ids=["folders", "headers"])
def test_there_are_no_circles(name):
    edges = {}
    for file, includes in {**product_files(), **python_modules()}.items():
        edges.setdefault(name(file), set()).update(name(used) for used in includes if name(used) != name(file))
    assert circle(edges) == []
    assert circle({folder: may - {folder} for folder, may in rules().items()}) == []


def test_no_two_modules_include_each_other():
    """A module is a header and the source of its name."""
    pairs = {(str(Path(file).with_suffix("")), str(Path(used).with_suffix(""))) for file, includes in product_files().items()
             for used in includes}
    assert {(a, b) for a, b in pairs if a < b and (b, a) in pairs} == set()


def journeys():
    """Title: the files of each step, in their order."""
    section = (ROOT / "docs/overview.md").read_text().split("\n## Journeys\n")[1].split("\n## ")[0]
    parts = re.split(r"^\*\*(.+)\*\*$", section, flags=re.M)[1:]
    return {title: [re.findall(r"`([\w./]+\.(?:cc?|h|glsl))`", step.partition(":")[0]) for step in re.findall(r"^\d+\. (.*)$", steps, re.M)]
            for title, steps in zip(parts[::2], parts[1::2])}


@pytest.mark.parametrize("title", journeys())
def test_journeys_go_downward(title):
    """Each file is there, by its path or a name that no other has; a step above may use it, and it may use none above."""
    may, above = rules(), []
    for step in journeys()[title]:
        here = []
        for name in step:
            (file,) = {p for p in [ROOT / name] if p.is_file()} or {p for folder in ("baker", "formats", "runtime", "scenes") for p in (ROOT / folder).rglob(name)}
            here.append(folder_of(str(file.relative_to(ROOT))))
        assert here
        for folder in here:
            assert not above or any(folder in may[upper] for upper in above + here), f"{step}: nothing above may use it"
            assert not [upper for upper in above if upper != folder and upper in may[folder]], f"{step} may use what is above it"
        above += here


def test_there_are_five_journeys():
    assert len(journeys()) == 5 and all(len(steps) > 2 for steps in journeys().values())
