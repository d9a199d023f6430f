# The add-on in Godot's web template in Chromium (project.py); skipped where one of them is missing.
# SPDX-License-Identifier: GPL-3.0-or-later
import pathlib
import re
import shutil
import sys

import pytest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import project  # noqa: E402
from browser import Browser  # noqa: E402
from fixtures import scenes, vxs, vxs_path  # noqa: E402, F401 (fixtures)

ROOT = project.ROOT
EVERY = False  # of voxels.py
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
         "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"]
ADDON = ROOT / "build" / "godot" / "addons" / "vxs"


def addon_files():
    """What a project has of the add-on, with Godot's list of named classes, which the editor would write."""
    files = {f"addons/vxs/{path.name}": path.read_text() for path in sorted(ADDON.iterdir()) if path.suffix in (".gd", ".gdshaderinc")}
    named = re.compile(r"^class_name (\w+)\nextends (\w+)", re.M)
    classes = [(path, *found.groups()) for path, text in files.items() if (found := named.search(text))]
    rows = [f'{{"base": &"{base}", "class": &"{name}", "icon": "", "is_abstract": false, "is_tool": false, "language": &"GDScript", '
            f'"path": "res://{path}"}}' for path, name, base in classes]
    return files | {".godot/global_script_class_cache.cfg": f"list=[{', '.join(rows)}]\n"}


@pytest.fixture(scope="session")
def godot():
    """run(files): what a project with the add-on prints."""
    if not (project.TEMPLATE / "index.wasm").is_file():
        pytest.skip(f"no web template of Godot at {project.TEMPLATE}: npm could not fetch it, or set GODOT_TEMPLATE")
    if not shutil.which("chromium"):
        pytest.skip("no browser: package chromium")
    browser, server, addon = Browser(FLAGS, project.WAIT_S), project.Server(), addon_files()
    yield lambda files: project.run(browser, server, addon | files)
    browser.close()
