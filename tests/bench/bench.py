# Measure the city and Sponza with `vxs bench` and lookups with `rivals`, print the tables of README and docs/measurements.md and
# what is aimed at, and write the measurements as JSON: --json (docs/bench.schema.json), which `vxs bench --against` can read, and
# beside it NAME-lookups.json, and NAME-SCENE-RESOLUTION-CAMERA.json for each picture (docs/rivals.schema.json).
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

from tables import SCENES, SPONZA, SPONZA_SUN, machine_line, markdown

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESOLUTIONS = [int(n) for n in os.environ.get("BENCH_RESOLUTIONS", "512 1024 2048 4096 8192 16384").split()]
RUNS = int(os.environ.get("BENCH_RUNS", "5"))
POINTS = int(os.environ.get("BENCH_POINTS", "100000"))
LOOKUP_RESOLUTION = 4096
PICTURE_RESOLUTIONS = [n for n in (4096, 16384) if n in RESOLUTIONS]  # of 65536 x 65536 texels a float depth map has 16 GiB

# what, at which resolution (None: the worst of all), which figure, unit, aim
AIMS = [
    ("mesh to file", 4096, lambda c: c["bake"]["wall_seconds"]["median"], "s", 1.0),
    ("mesh to file", 16384, lambda c: c["bake"]["wall_seconds"]["median"], "s", 6.0),
    ("maps to words", 4096, lambda c: c["bake"]["maps_to_words_seconds"]["median"], "s", 0.150),
    ("maps to words", 8192, lambda c: c["bake"]["maps_to_words_seconds"]["median"], "s", 0.600),
    ("peak memory", None, lambda c: c["bake"]["peak_bytes"] / 2**20, "MiB", 600),
]
SCATTERED = {"volume": "anywhere", "edge": "at edges"}  # of shadows
WHERE = SCATTERED | {"screen": "in a picture"}
TAPS = {"1 tap": "tap_ns", "9 x 9": "filter_ns", "9 x 9 smooth": "smooth_ns"}
SHOWN = {"palette blocks": "vxs", "palette blocks, batch": "vxs, many at once", "DAG": "vxs, --coding dag",
         "DAG, batch": "vxs, --coding dag, many at once"} | {
    name: name for name in ("merged intervals", "16-bit depth map", "float depth map", "Embree shadow rays", "DAG, GLSL",
                                 "palette blocks, GLSL", "16-bit texture, GLSL")}
LOOKUP_AIM = ("a million scattered single taps", "s", 0.150)
CAMERAS = {
    "city": [[], ["--eye=60,40,60", "--target=0,0,0"], ["--eye=3,2,3", "--target=40,3,20", "--fov", 60]],
    "sponza": [["--eye=-7,2,-0.3", "--target=5,3.2,-0.6", "--fov", 60], ["--eye=-9.5,0.8,-0.3", "--target=8,1.5,-0.3", "--fov", 65],
               ["--eye=0,8,0", "--target=6,0,1", "--fov", 60]],
}
ASSETS, MAPS = ["palette blocks", "palette blocks, batch", "DAG, batch"], ["16-bit depth map", "float depth map"]
RAYS = "Embree shadow rays"


def run(*command, stdout=subprocess.PIPE):
    """What the command printed; it fails when the command does. Errors and progress go where ours go."""
    done = subprocess.run([*map(str, command)], stdout=stdout, text=True)
    if done.returncode != 0:
        sys.exit(done.returncode)
    return done.stdout


def measure(vxs, folder):
    """One result of all scenes. Those with a light of their own, and those without, need different options: a bench each."""
    run(vxs, "scene", "city", "-o", folder / "city.glb")
    scenes = [[folder / "city.glb"], [SPONZA, "--sun", SPONZA_SUN]]
    if not SPONZA.is_file():
        print(f"no {SPONZA}: only the city is measured", file=sys.stderr)
        scenes.pop()
    resolutions = [word for n in RESOLUTIONS for word in ("--resolution", n)]
    results = []
    for n, scene in enumerate(scenes):
        path = folder / f"{n}.json"
        run(vxs, "bench", *scene, "-o", path, *resolutions, "--runs", RUNS, "--points", POINTS, "--filter", 9, "--smooth", 9)
        results.append(json.loads(path.read_text()))
    return results[0] | {"cells": [cell for result in results for cell in result["cells"]]}


def lookups(build, folder, path):
    """Lookups in the city, beside its rivals, by name."""
    if LOOKUP_RESOLUTION not in RESOLUTIONS:
        return None
    run(build / "tests" / "bench" / "rivals", folder / "city.glb", "--resolution", LOOKUP_RESOLUTION, "--runs", RUNS, "--json", path)
    return lookups_of(path)


def lookups_of(path):
    """By name."""
    return {rival["name"]: rival["lookups"] for rival in json.loads(path.read_text())["rivals"]}


def pictures(build, folder, path_of):
    """Lookups in pictures, three of each scene: [(scene, resolution, camera, lookups by name)]"""
    found = []
    scenes = {"city": [folder / "city.glb"], "sponza": [SPONZA, "--sun", SPONZA_SUN]}
    names = [word for name in [*ASSETS[1:], *MAPS, RAYS] for word in ("--rival", name)]
    for scene, resolution in ((s, n) for s in scenes if s == "city" or SPONZA.is_file() for n in PICTURE_RESOLUTIONS):
        for n, camera in enumerate(CAMERAS[scene]):
            path = path_of(f"{scene}-{resolution}-{n + 1}")
            run(build / "tests" / "bench" / "rivals", *scenes[scene], "--resolution", resolution, "--runs", RUNS, "--points", max(POINTS, 1),
                "--voxels", 200000, *names, *camera, "--json", path)
            found.append((scene, resolution, n + 1, lookups_of(path)))
    return found


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
    return rows + [[f"{what}, {where}", unit, aim, 1e-3 * found["palette blocks"][where]["tap_ns"]["median"]] for where in SCATTERED if found]


def ms(seconds):
    return f"{1e3 * seconds:.0f} ms"


def bake_row(cell):
    bake, side = cell["bake"], cell["options"]["resolution_px"]
    maps = next(s["seconds"]["median"] for s in bake["stages"] if s["name"] == "maps")
    return [name_of(cell), str(side), ms(bake["wall_seconds"]["median"]), ms(maps),
            ms(bake["maps_to_words_seconds"]["median"]), f"{bake['peak_bytes'] / 2**20:.0f} MiB",
            f"{cell['size']['file_bytes'] / 1024:.0f} KiB", f"{8 * cell['size']['file_bytes'] / side**2:.3f}"]


def ns(lookup, taps):
    return f"{lookup[taps]['median']:.1f}" if lookup[taps] else ""


def picture_row(scene, resolution, camera, found):
    """Of each, what it takes in nanoseconds; then what the batch takes of the quicker of both maps."""
    least = lambda taps: min(found[name]["screen"][taps]["median"] for name in MAPS)
    cells = [", ".join(ns(found[name]["screen"], taps) for taps in TAPS.values() if found[name]["screen"][taps]) for name in [*ASSETS, *MAPS, RAYS]]
    batch = found["palette blocks, batch"]
    ratios = [f"{batch['screen'][taps]['median'] / least(taps):.2f}" for taps in ("tap_ns", "filter_ns")]
    edges = batch["edge"]["filter_ns"]["median"] / min(found[name]["edge"]["filter_ns"]["median"] for name in MAPS)
    return [f"{scene} at {resolution}, {camera}", *cells, ", ".join(ratios), f"{edges:.2f}"]


def print_tables(result, found, seen):
    print(f"\n{machine_line(result)}\n")
    markdown(["scene", "texels a side", "mesh to file", "of that depth maps", "maps to words", "peak memory", "file", "bit/texel"],
          [bake_row(cell) for cell in result["cells"]])
    if found:
        markdown([f"a lookup, one thread, city at {LOOKUP_RESOLUTION}", *[f"{taps}, {at}" for at in WHERE.values() for taps in TAPS]],
                 [[shown, *[f"{found[name][where][taps]['median']:.0f} ns" if found[name][where][taps] else "" for where in WHERE for taps in TAPS.values()]]
                  for name, shown in SHOWN.items()])
    if seen:
        print(f"ns a lookup in a picture: {', '.join(TAPS)}; then what a batch takes of the quicker map, in the picture, and 9 x 9 at edges\n")
        markdown(["picture", *ASSETS, *MAPS, RAYS, "batch to map", "at edges"], [picture_row(*one) for one in seen])
    missed = lambda measured, aim: "met" if measured <= aim else f"missed by {100 * (measured / aim - 1):.0f} %"
    markdown(["aim", "at most", "measured", ""],
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
        options.json.parent.mkdir(parents=True, exist_ok=True)
        path_of = lambda name: options.json.with_name(f"{options.json.stem}-{name}.json")
        found = lookups(build, pathlib.Path(folder), path_of("lookups"))
        seen = pictures(build, pathlib.Path(folder), path_of)
    options.json.write_text(json.dumps(result, indent=2) + "\n")
    print_tables(result, found, seen)
    print(f"as JSON: {options.json}")


main()
