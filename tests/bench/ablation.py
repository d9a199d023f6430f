# What each part of the method is worth: Tables 1 to 5 of [CPVS16] on our scenes, the paper's figures beside ours. Bakes are
# measured by `vxs bench`, whose JSON stays beside the tables (docs/bench.schema.json). The paper's scenes are not public: compare
# ratios, not values.
# ABLATION_RESOLUTIONS: texels a side (default 4096 8192 16384).  ABLATION_RUNS: bakes of each (default 3).
# VXS_SCENES: the shared scenes; without them Sponza is left out.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import subprocess
import sys

from tables import SPONZA, SPONZA_SUN, machine_line, markdown, megabytes, milliseconds, ratio

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESOLUTIONS = [int(n) for n in os.environ.get("ABLATION_RESOLUTIONS", "4096 8192 16384").split()]
RUNS = int(os.environ.get("ABLATION_RUNS", "3"))

# which bakes: products of options, as `vxs bench` takes them
SWEEPS = [
    ["--exit", "peel", "--closed", "auto", "--closed", "off", "--reuse", "on", "--reuse", "off", "--compress", "bottom-up",
     "--compress", "top-down"],
    ["--exit", "peel", "--rule", "greedy", "--rule", "shadow"],
    ["--exit", "peel", "--exit", "back", "--stop", "insert", "--stop", "partial", "--stop", "final"],
]
DEFAULTS = {"exit": "peel", "closed": "auto", "reuse": "on", "compress": "auto", "rule": "greedy", "stop": "final"}
DAG_STAGES = ("insert", "compress", "merge")

# [CPVS16], seconds and megabytes; closed geometry by peeling unless it says otherwise. Its landscape is FractalLandscape.
PAPER_TOTAL = {("city", "off"): {4096: 0.207, 16384: 3.02}, ("city", "auto"): {4096: 0.040, 16384: 0.328},
               ("landscape", "off"): {4096: 0.200, 16384: 2.9}, ("landscape", "auto"): {4096: 0.026, 16384: 0.219}}
PAPER_CULLING = {("off", "off"): {4096: (0.304, 0.293), 16384: (4.1, 4.0)}, ("auto", "off"): {4096: (0.173, 0.140), 16384: (2.1, 1.9)},
                 ("off", "on"): {4096: (0.207, 0.197), 16384: (3.02, 2.8)}, ("auto", "on"): {4096: (0.040, 0.017), 16384: (0.328, 0.128)}}
PAPER_STAGES = {"off": {4096: (0.0021, 0.0018, 0.0929, 0.142, 0.105, None), 16384: (0.0185, 0.0292, 1.36, 2.07, 1.30, 0.214)},
                "auto": {4096: (0.0223, 0.00091, 0.00879, 0.00734, None, None), 16384: (0.170, 0.0149, 0.0488, 0.0441, None, 0.0322)}}
PAPER_RULES = {"city": {4096: (0.83, 1.18), 8192: (1.89, 2.82), 16384: (3.96, 6.25)},
               "landscape": {4096: (0.44, 0.76), 8192: (0.84, 1.59), 16384: (1.60, 3.34)}}
PAPER_STOPS = {("peel", "insert"): (6.3, 0.252), ("peel", "partial"): (4.4, 0.296), ("peel", "final"): (3.9, 0.328),
               ("back", "insert"): (6.5, 0.125), ("back", "partial"): (4.5, 0.169), ("back", "final"): (4.0, 0.202)}


def scenes(vxs, folder):
    """Name, file, options."""
    found = []
    for kind in ("city", "landscape"):
        subprocess.run([vxs, "scene", kind, "-o", folder / f"{kind}.glb"], check=True)
        found.append((kind, folder / f"{kind}.glb", []))
    if SPONZA.is_file():
        found.append(("sponza", SPONZA, ["--sun", SPONZA_SUN]))
    return found


class Cells:
    """What was measured, by scene, resolution, and the options that differ from DEFAULTS."""

    def __init__(self, results):
        self.cells = {}
        for result in results:
            for cell in result["cells"]:
                key = tuple(cell["options"][name] for name in DEFAULTS)
                self.cells[pathlib.Path(cell["scene"]).stem, cell["options"]["resolution_px"], key] = cell
        self.scenes = list(dict.fromkeys(scene for scene, _, _ in self.cells))
        self.resolutions = sorted({resolution for _, resolution, _ in self.cells})

    def get(self, scene, resolution, **options):
        return self.cells[scene, resolution, tuple((DEFAULTS | options).values())]

    def seconds(self, scene, resolution, *stages, **options):
        """The median of the whole, or of some stages."""
        bake = self.get(scene, resolution, **options)["bake"]
        return sum(s["seconds"]["median"] for s in bake["stages"] if s["name"] in stages) if stages else bake["total_seconds"]["median"]


def closedness(closed):
    return "closed" if closed == "auto" else "not closed"


def table_1(c):
    """Total time."""
    rows = []
    for scene in c.scenes:
        for closed in ("off", "auto"):
            row, paper = [scene, closedness(closed)], PAPER_TOTAL.get((scene, closed), {})
            for resolution in c.resolutions:
                row += [milliseconds(c.seconds(scene, resolution, closed=closed, compress="top-down")), milliseconds(paper.get(resolution))]
            rows.append(row)
    head = [h for r in c.resolutions for h in (f"{r}", "paper")]
    print("Table 1: mesh to file, with and without the inside of closed geometry\n")
    markdown(["scene", "geometry", *head], rows)


def table_2(c):
    """Culling: insertion that refers to an equal neighbour nearer the light."""
    rows = []
    for scene in c.scenes:
        for closed in ("off", "auto"):
            for resolution in c.resolutions:
                figures = []
                for stages in ((), DAG_STAGES):
                    off, on = (c.seconds(scene, resolution, *stages, closed=closed, reuse=r, compress="top-down") for r in ("off", "on"))
                    figures += [milliseconds(off), milliseconds(on), ratio(off, on)]
                without, culled = (PAPER_CULLING[closed, reuse].get(resolution) for reuse in ("off", "on"))
                paper = [ratio(without[n], culled[n]) for n in (0, 1)] if scene == "city" and without else ["", ""]
                rows.append([scene, closedness(closed), str(resolution), *figures[:3], paper[0], *figures[3:], paper[1]])
    print("Table 2: without and with culling of identical nodes, mesh to file, and of that the DAG\n")
    markdown(["scene", "geometry", "texels", "total without", "with", "ratio", "paper", "DAG without", "with", "ratio", "paper"], rows)


def table_3(c):
    """Stages, with both orders of compression."""
    names = ["depth maps", "pyramid, masks", "insert", "compress sub-DAGs, bottom-up", "top-down", "merge"]
    stages = [("gl", "maps"), ("pyramid", "masks"), ("insert",), ("compress",), ("compress",), ("merge",)]
    orders = ["bottom-up"] * 4 + ["top-down", "bottom-up"]
    rows = []
    for closed in ("off", "auto"):
        for n, name in enumerate(names):
            row = [closedness(closed), name]
            for scene in c.scenes:
                for resolution in c.resolutions:
                    row.append(milliseconds(c.seconds(scene, resolution, *stages[n], closed=closed, compress=orders[n])))
            row += [milliseconds(PAPER_STAGES[closed][r][n]) for r in (4096, 16384)]
            rows.append(row)
    head = [f"{scene} {resolution}" for scene in c.scenes for resolution in c.resolutions]
    print("Table 3: stages\n")
    markdown(["geometry", "stage", *head, "paper, city 4096", "paper, city 16384"], rows)


def table_4(c):
    """Undefined voxels: with the fewest masks, or dark as in older work."""
    rows = []
    for scene in c.scenes:
        for resolution in c.resolutions:
            new, old = (c.get(scene, resolution, rule=rule)["size"]["memory_bytes"] for rule in ("greedy", "shadow"))
            paper = PAPER_RULES.get(scene, {}).get(resolution)
            rows.append([scene, str(resolution), megabytes(new / 1e6), megabytes(old / 1e6), ratio(old, new),
                         *([megabytes(paper[0]), megabytes(paper[1]), ratio(paper[1], paper[0])] if paper else ["", "", ""])])
    print("Table 4: memory, undefined voxels by the greedy rule and by the older one\n")
    markdown(["scene", "texels", "greedy", "older", "ratio", "paper: greedy", "older", "ratio"], rows)


def table_5(c):
    """Stop stages and exit depths, beside the last of them with peeling."""
    resolution = c.resolutions[-1]
    rows = []
    for scene in c.scenes:
        last = c.get(scene, resolution)["size"]["memory_bytes"], c.seconds(scene, resolution)
        for exit_mode in ("peel", "back"):
            for stop in ("insert", "partial", "final"):
                bytes_, seconds = (c.get(scene, resolution, exit=exit_mode, stop=stop)["size"]["memory_bytes"],
                                   c.seconds(scene, resolution, exit=exit_mode, stop=stop))
                size, time = PAPER_STOPS[exit_mode, stop]
                paper = [ratio(size, 3.9), ratio(time, 0.328)] if scene == "city" else ["", ""]
                rows.append([scene, exit_mode, stop, megabytes(bytes_ / 1e6), ratio(bytes_, last[0]), paper[0], milliseconds(seconds),
                             ratio(seconds, last[1]), paper[1]])
    print(f"Table 5: memory and time by where the bake stops, at {resolution}; ratios to peel, final\n")
    markdown(["scene", "exit", "stop", "memory", "ratio", "paper at 16384", "time", "ratio", "paper at 16384"], rows)


def main():
    arguments = argparse.ArgumentParser(description="Measure what each part of the method is worth.")
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release", help="the build tree")
    arguments.add_argument("--json", type=pathlib.Path, help="folder of the JSON files (default: ablation in the build tree)")
    options = arguments.parse_args()
    vxs, folder = options.build.resolve() / "vxs", options.json or options.build / "ablation"
    folder.mkdir(parents=True, exist_ok=True)

    results = []
    for name, scene, extra in scenes(vxs, folder):
        for n, sweep in enumerate(SWEEPS):
            path = folder / f"{name}-{n + 1}.json"
            sizes = [a for r in RESOLUTIONS for a in ("--resolution", str(r))]
            done = subprocess.run([vxs, "bench", scene, "-o", path, "--runs", str(RUNS), "--points", "0", "--coding", "dag", *sizes, *sweep,
                                   *extra], stdout=subprocess.DEVNULL)
            if done.returncode:
                sys.exit(done.returncode)
            results.append(json.loads(path.read_text()))

    print(machine_line(results[0]) + "\n")
    cells = Cells(results)
    for table in (table_1, table_2, table_3, table_4, table_5):
        table(cells)
    print(f"as JSON: {folder}")


main()
