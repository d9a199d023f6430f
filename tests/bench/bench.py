# Measure the city and Sponza with `vxs bench`, print README's tables and what is aimed at, and write the measurements as JSON
# (docs/bench.schema.json), which `vxs bench --against` can read.
# BENCH_RESOLUTIONS: texels a side (default 512 to 16384).  BENCH_RUNS: how often each is measured (default 5).
# BENCH_POINTS: of each kind, for errors and lookups (default 100000; 0: without them).
# VXS_SCENES: the shared scenes; without them only the city is measured.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESOLUTIONS = [int(n) for n in os.environ.get("BENCH_RESOLUTIONS", "512 1024 2048 4096 8192 16384").split()]
RUNS = int(os.environ.get("BENCH_RUNS", "5"))
POINTS = int(os.environ.get("BENCH_POINTS", "100000"))
SCENES = pathlib.Path(os.environ.get("VXS_SCENES", ROOT.parent / "shared" / "scenes"))
LOOKUP_RESOLUTION = 4096

# what, at which resolution (None: the worst of all), which figure, unit, aim
AIMS = [
    ("mesh to file", 4096, lambda c: c["bake"]["wall_seconds"]["median"], "s", 1.0),
    ("mesh to file", 16384, lambda c: c["bake"]["wall_seconds"]["median"], "s", 6.0),
    ("maps to DAG", 4096, lambda c: c["bake"]["maps_to_dag_seconds"]["median"], "s", 0.150),
    ("maps to DAG", 8192, lambda c: c["bake"]["maps_to_dag_seconds"]["median"], "s", 0.600),
    ("peak memory", None, lambda c: c["bake"]["peak_bytes"] / 2**20, "MiB", 600),
]
LOOKUP_AIM = ("a million scattered single taps", "s", 0.150)


def run(*command, stdout=subprocess.PIPE):
    """What the command printed; it fails when the command does. Errors and progress go where ours go."""
    done = subprocess.run([*map(str, command)], stdout=stdout, text=True)
    if done.returncode != 0:
        sys.exit(done.returncode)
    return done.stdout


def measure(vxs, folder):
    """One result of all scenes. Those with a light of their own, and those without, need different options: a bench each."""
    city, sponza = folder / "city.glb", SCENES / "real" / "sponza.glb"
    run(vxs, "scene", "city", "-o", city)
    scenes = [[city], [sponza, "--sun", "-0.4,-1,-0.2"]]
    if not sponza.is_file():
        print(f"no {sponza}: only the city is measured", file=sys.stderr)
        scenes.pop()
    resolutions = [word for n in RESOLUTIONS for word in ("--resolution", n)]
    results = []
    for n, scene in enumerate(scenes):
        path = folder / f"{n}.json"
        run(vxs, "bench", *scene, "-o", path, *resolutions, "--runs", RUNS, "--points", POINTS, "--filter", 9)
        results.append(json.loads(path.read_text()))
    return results[0] | {"cells": [cell for result in results for cell in result["cells"]]}


def lookups(build, folder):
    """A million lookups in the city, beside a float depth map."""
    if LOOKUP_RESOLUTION not in RESOLUTIONS:
        return None
    asset = folder / "city.vxs"
    run(build / "vxs", "bake", folder / "city.glb", "-o", asset, "--resolution", LOOKUP_RESOLUTION, "--baseline", "off")
    return json.loads(run(build / "tests" / "bench" / "lookups", asset))


def name_of(cell):
    return cell["scene"].removesuffix(".glb")


def aims(cells, found):
    """What, unit, aim, measured."""
    rows = []
    for what, resolution, figure, unit, aim in AIMS:
        for scene in dict.fromkeys(map(name_of, cells)):
            values = [figure(c) for c in cells if name_of(c) == scene and resolution in (None, c["options"]["resolution_px"])]
            if values:
                rows.append([f"{what}, {scene}{f' at {resolution}' if resolution else ''}", unit, aim, max(values)])
    what, unit, aim = LOOKUP_AIM
    return rows + [[f"{what}, {name}", unit, aim, found[name]["tap_1_seconds"]] for name in ("volume", "surface") if found]


def table(head, rows):
    """Markdown, in columns for those who read it as it is."""
    widths = [max(len(row[n]) for row in [head, *rows]) for n in range(len(head))]
    line = lambda cells: "| " + " | ".join(c.rjust(w) if n else c.ljust(w) for n, (c, w) in enumerate(zip(cells, widths))) + " |"
    rule = "|" + "|".join("-" * (w + 2) if not n else "-" * (w + 1) + ":" for n, w in enumerate(widths)) + "|"
    print("\n".join([line(head), rule, *map(line, rows)]) + "\n")


def ms(seconds):
    return f"{1e3 * seconds:.0f} ms"


def bake_row(cell):
    bake, side = cell["bake"], cell["options"]["resolution_px"]
    maps = next(s["seconds"]["median"] for s in bake["stages"] if s["name"] == "maps")
    return [name_of(cell), str(side), ms(bake["wall_seconds"]["median"]), ms(maps),
            ms(bake["maps_to_dag_seconds"]["median"]), f"{bake['peak_bytes'] / 2**20:.0f} MiB",
            f"{cell['size']['file_bytes'] / 1024:.0f} KiB", f"{8 * cell['size']['file_bytes'] / side**2:.3f}"]


def print_tables(result, found):
    m = result["machine"]
    print(f"\nvxs {result['vxs']} on {m['processor']}, {m['cores']} cores, {m['memory_bytes'] / 2**30:.0f} GiB, {m['system']}; "
          f"medians of {result['runs']} runs\n")
    table(["scene", "texels a side", "mesh to file", "of that depth maps", "maps to DAG", "peak memory", "file", "bit/texel"],
          [bake_row(cell) for cell in result["cells"]])
    if found:
        table([f"a million lookups, one thread, city at {LOOKUP_RESOLUTION}", "1 tap", "9 x 9 taps"],
              [[f"{points}, {method}", ms(found[name][prefix + "tap_1_seconds"]), ms(found[name][prefix + "tap_81_seconds"])]
               for name, points in (("volume", "anywhere in the volume"), ("surface", "within a voxel of a shadow's start"))
               for method, prefix in (("vxs", ""), ("float depth map", "depth_map_"))])
    missed = lambda measured, aim: "met" if measured <= aim else f"missed by {100 * (measured / aim - 1):.0f} %"
    table(["aim", "at most", "measured", ""],
          [[what, f"{aim:.3g} {unit}", f"{measured:.3g} {unit}", missed(measured, aim)]
           for what, unit, aim, measured in aims(result["cells"], found)])


def main():
    arguments = argparse.ArgumentParser(description="Measure bakes and lookups.")
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release", help="the build tree")
    arguments.add_argument("--json", type=pathlib.Path, default=ROOT / "build" / "bench.json", help="where the result goes")
    options = arguments.parse_args()
    build = options.build.resolve()

    with tempfile.TemporaryDirectory(prefix="vxs-bench-") as folder:
        result = measure(build / "vxs", pathlib.Path(folder))
        found = lookups(build, pathlib.Path(folder))
    options.json.parent.mkdir(parents=True, exist_ok=True)
    options.json.write_text(json.dumps(result, indent=2) + "\n")
    print_tables(result, found)
    print(f"as JSON: {options.json}")


main()
