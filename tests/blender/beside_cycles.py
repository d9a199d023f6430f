#!/usr/bin/python3
# Shadows of four levels by vxs and by Cycles, on this machine, held against Blender's rays: a table, JSON (docs/blender.schema.json), and
# pictures. Each level has a Blender of its own, with empty settings.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(__file__).resolve().parent
REAL = FOLDER.parents[2] / "shared" / "scenes" / "real"
LEVELS = {  # samples of a texel of lightmaps: 4 for each lamp
    "city": {"generate": ["city"], "resolution": 1024, "samples": 4,
             "picture": {"eye": [60, -115, 75], "target": [-20, 0, 10], "degrees": 55}},
    "room": {"generate": ["room"], "resolution": 512, "samples": 8},
    "Sponza": {"real": "sponza.glb", "suns": [[0.25, 0.3, -1]], "resolution": 1024, "samples": 4},
    "apartment": {"real": "dream_apartment.glb", "lamps": [[3, 3, 2.2], [6.5, 8.5, 2.2], [10, 3, 2.2]], "resolution": 512,
                  "samples": 12},
}
LESS = 8  # with --quick, resolutions are so many times lower


def blender_command(name):
    """How to run a script, or why it cannot be."""
    path = shutil.which(name)
    if not path:
        return None, f"no Blender: {name} is not on PATH; Debian: blender"
    if not pathlib.Path(path).name.startswith("python"):
        return [path, "-b", "--factory-startup", "--python-exit-code", "3", "--python"], ""
    has_bpy = subprocess.run([path, "-c", "import bpy"], capture_output=True).returncode == 0
    return ([path], "") if has_bpy else (None, f"{name} has no module bpy")


def scene_of(name, level, options, folder):
    """A path, or None and the reason."""
    if "generate" in level:
        path = folder / f"{name}.glb"
        subprocess.run([options.vxs, "scene", *level["generate"], "-o", path, "--quiet"], check=True)
        return path, ""
    path = options.real / level["real"]
    return (path, "") if path.is_file() else (None, f"no file {path}")


def measure(command, name, options, folder):
    """The row of a level, or {"name", "skipped"}."""
    level = LEVELS[name]
    scene, why = scene_of(name, level, options, folder)
    if not scene:
        return {"name": name, "skipped": why}
    less = LESS if options.quick else 1
    request = {"name": name, "scene": str(scene), "vxs": str(options.vxs), "addon": str(options.addon), "folder": str(folder),
               "out": str(folder / "row.json"), "runs": 1 if options.quick else 3, "points": options.points,
               **{key: level[key] for key in ("suns", "lamps", "samples") if key in level},
               "resolution": level["resolution"] // less}
    if "picture" in level and not options.quick:
        request["picture"] = {**level["picture"], "width": 320, "height": 240, "file": str(options.out.with_name(f"blender-{name}.png"))}
    (folder / "request.json").write_text(json.dumps(request))
    home = {**os.environ, "HOME": str(folder), "XDG_CONFIG_HOME": str(folder), "BLENDER_USER_RESOURCES": str(folder / "user")}
    with open(folder / "log", "w") as log:
        done = subprocess.run([*command, FOLDER / "measure_level.py", "--", folder / "request.json"], env=home, cwd=folder, stdout=log,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
    if done.returncode:
        sys.exit(f"{name}: Blender ended with status {done.returncode}\n" + (folder / "log").read_text(errors="replace")[-3000:])
    return json.loads((folder / "row.json").read_text())


HEADINGS = ("level", "way", "texels", "UV2, s", "bake, s", "KiB", "MiB", "error", "in the air")


def table(rows):
    """Lines of Markdown. Seconds are those of all processors: they hardly depend on what else the machine does."""
    lines = [HEADINGS, ("---", "---", *["--:"] * (len(HEADINGS) - 2))]
    for row in rows:
        if "skipped" in row:
            lines.append((row["name"], row["skipped"], *[""] * (len(HEADINGS) - 2)))
            continue
        vxs = row["vxs"]
        lines.append((row["name"], "vxs", f"{row['resolution']}²", "none", f"{vxs['processor_seconds']:.2g}", f"{vxs['bytes'] / 1024:.0f}",
                      f"{vxs['peak_bytes'] / 2**20:.0f}", f"{vxs['error']:.2%}", f"{vxs['error_in_air']:.2%}"))
        for key, way in (("equal_bytes", "Cycles, equal bytes"), ("equal_resolution", "Cycles, equal texels")):
            of = row[key]
            grown = f"{of['peak_bytes'] / 2**20:.0f}" if key == "equal_resolution" else "-"  # later bakes reuse that memory
            lines.append(("", way, f"{of['side']}²", f"{of['prepare_processor_seconds']:.2g}", f"{of['processor_seconds']:.2g}",
                          f"{of['bytes'] / 1024:.0f}", grown, f"{of['error']:.2%}", "-"))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main():
    parser = argparse.ArgumentParser(description="vxs beside lightmaps of Cycles")
    parser.add_argument("--blender", default="blender", help="a Blender, or a Python that has the module bpy")
    parser.add_argument("--vxs", type=pathlib.Path, required=True)
    parser.add_argument("--addon", type=pathlib.Path, required=True, help="the zip of make blender")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="JSON; pictures go beside it")
    parser.add_argument("--only", default="", help="levels, by their beginnings, with commas between")
    parser.add_argument("--real", type=pathlib.Path, default=REAL, help="folder of sponza.glb and dream_apartment.glb")
    parser.add_argument("--points", type=int, default=20000)
    parser.add_argument("--quick", action="store_true", help="coarse maps, one run, no pictures: to test this program")
    options = parser.parse_args()
    for name in ("vxs", "addon", "out", "real"):
        setattr(options, name, getattr(options, name).resolve())
    command, why = blender_command(options.blender)
    if not command:
        print(f"skipped: {why}")
        return
    options.out.parent.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in (name for name in LEVELS if name.startswith(tuple(options.only.split(",")))):
        with tempfile.TemporaryDirectory() as folder:
            rows.append(measure(command, name, options, pathlib.Path(folder)))
        print(table(rows[-1:]), flush=True)
    report = {"version": 1, "machine": platform.machine(), "processors": len(os.sched_getaffinity(0)), "levels": rows}
    options.out.write_text(json.dumps(report, indent=1) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()
