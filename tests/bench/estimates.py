# How far off the estimates of `vxs plan` are: bakes scenes, and compares what their plans said with what came of them.
# ESTIMATES_RESOLUTIONS: texels a side (default 1024 4096).  VXS_SCENES: the shared scenes; without them only generated ones are
# baked.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

from tables import SCENES, markdown

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESOLUTIONS = [int(n) for n in os.environ.get("ESTIMATES_RESOLUTIONS", "1024 4096").split()]
CODINGS = {"blocks": "palette blocks", "dag": "DAG"}
FIGURES = {"file_bytes": "bytes of the file", "memory_bytes": "bytes when loaded", "peak_bytes": "peak memory", "total_seconds": "time"}


def scenes(vxs, folder):
    for kind in ("city", "landscape", "room", "forest"):
        subprocess.run([vxs, "scene", kind, "-o", folder / f"{kind}.glb"], check=True)
        yield folder / f"{kind}.glb"
    yield from sorted((SCENES / "real").glob("*.glb"))


def bake(vxs, scene, resolution, coding, folder):
    """Estimated by actual, of each figure; None where nothing casts a shadow."""
    report = folder / "bake.json"
    done = subprocess.run([vxs, "bake", scene, "-o", folder / "bake.vxs", "--sun", "-0.4,-1,-0.2", "--resolution", str(resolution),
                           "--coding", coding, "--json", report], capture_output=True, text=True)
    if done.returncode:
        print(f"{scene.name} is left out: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return None
    plan = json.loads(report.read_text())["plan"]
    ratios = {figure: plan["estimate"][figure] / plan["actual"][figure] for figure in FIGURES}
    return {"scene": scene.stem, "resolution_px": resolution, "coding": coding} | ratios


def main():
    arguments = argparse.ArgumentParser(description="Measure how far off the estimates of plans are.")
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release", help="the build tree")
    arguments.add_argument("--json", type=pathlib.Path, default=ROOT / "build" / "estimates.json", help="where the result goes")
    options = arguments.parse_args()
    vxs, folder = options.build.resolve() / "vxs", options.build / "estimates"
    folder.mkdir(parents=True, exist_ok=True)

    bakes = [b for scene in scenes(vxs, folder) for r in RESOLUTIONS for coding in CODINGS if (b := bake(vxs, scene, r, coding, folder))]
    rows = []
    for coding, figure in ((c, f) for c in CODINGS for f in FIGURES):
        ratios = sorted(b[figure] for b in bakes if b["coding"] == coding)
        within = sum(0.5 <= r <= 2 for r in ratios)
        rows.append([f"{CODINGS[coding]}: {FIGURES[figure]}", f"{ratios[0]:.2f}", f"{statistics.median(ratios):.2f}", f"{ratios[-1]:.2f}",
                     f"{within} of {len(ratios)}"])
    version = subprocess.run([vxs, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    options.json.parent.mkdir(parents=True, exist_ok=True)
    options.json.write_text(json.dumps({"vxs": version, "bakes": bakes}, indent=2) + "\n")
    print(f"Estimated by actual, {len({b['scene'] for b in bakes})} scenes at {' and '.join(map(str, RESOLUTIONS))} texels a side\n")
    markdown(["", "least", "median", "most", "within a factor of 2"], rows)
    print(f"as JSON: {options.json}")


main()
