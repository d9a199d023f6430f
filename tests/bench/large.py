# Measure bakes of large maps straight from triangles, print them as tables, and write them as JSON (docs/large.schema.json):
# --json. A run is a process for each row, with two threads and with one, row after row; then the next run. Figures are medians,
# memory is the most that the system saw of the process. Beside them stand the two depth maps alone, rendered by a sample of tiles
# (two_maps.c), and what a third processor would gain: of each stage, what one thread takes and two do not halve is taken for the
# work of one. --against VXS: another build bakes the same, run by run in turn with this one.
# LARGE_ROWS: which (default "large-city landscape sponza city spots"), or NAME:RESOLUTION of smaller ones.  LARGE_RUNS: how often (default 3).
# VXS_SCENES: the shared scenes; without them Sponza is left out.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from tables import SPONZA, SPONZA_SUN, markdown

ROOT = pathlib.Path(__file__).resolve().parents[2]
RUNS = int(os.environ.get("LARGE_RUNS", "3"))
SIDES = (4096, 16384, 65536, 262144)
ROWS = {"large-city": SIDES, "landscape": SIDES, "sponza": (65536,), "city": (4096, 16384), "spots": (4096,)}
SCENES = {"large-city": ("city", "--triangles", 800000, "--blocks", 22), "landscape": ("landscape", "--triangles", 2000000),
          "city": ("city", "--triangles", 100000), "spots": ("city", "--triangles", 100000, "--spots", 165), "small": ("city", "--triangles", 5000)}
BEFORE = ("load", "solids", "plan")


def chosen():
    """[(scene, resolution)]"""
    rows = []
    for word in os.environ.get("LARGE_ROWS", " ".join(ROWS)).split():
        name, _, side = word.partition(":")
        rows += [(name, s) for s in ([int(side)] if side else ROWS[name])]
    if not SPONZA.is_file() and any(name == "sponza" for name, _ in rows):
        print(f"no {SPONZA}: it is left out", file=sys.stderr)
    return [row for row in rows if row[0] != "sponza" or SPONZA.is_file()]


def scene_of(vxs, folder, name):
    """The path, and options of its light."""
    if name == "sponza":
        return SPONZA, ("--sun", SPONZA_SUN)
    path = folder / f"{name}.glb"
    if not path.exists():
        subprocess.run([vxs, "scene", *map(str, SCENES[name]), "-o", path, "--quiet"], check=True)
    return path, ()


def bake(vxs, folder, name, side, threads):
    """The report of a bake, with what the system says of its process."""
    scene, light = scene_of(vxs, folder, name)
    command = [vxs, "bake", scene, *light, "-o", folder / "a.vxs", "--json", folder / "a.json", "--resolution", side, "--maps", "sparse",
               "--threads", threads, "--quiet"]
    child = subprocess.Popen([*map(str, command)])
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(child.returncode)
    report = json.loads((folder / "a.json").read_text())
    return report | {"processor_seconds": usage.ru_utime + usage.ru_stime, "outside_bytes": usage.ru_maxrss * 1024}


def two_maps(build, folder, name, side):
    scene, light = scene_of(build / "vxs", folder, name)
    done = subprocess.run([build / "tests/bench/two_maps", scene, *light, "--resolution", str(side), "--threads", "2"], check=True,
                          stdout=subprocess.PIPE)
    return json.loads(done.stdout)["seconds"]


def spread(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def stage_seconds(runs, name):
    return statistics.median(next(s["seconds"] for s in run["stages"] if s["name"] == name) for run in runs)


def beside(two, other):
    """What another build took, and the median of the ratios of each run to its own."""
    ratio = lambda key: statistics.median(a[key] / b[key] for a, b in zip(two, other))
    return {"seconds": spread([r["total_seconds"] for r in other]), "seconds_ratio": ratio("total_seconds"),
            "processor_seconds_ratio": ratio("processor_seconds"), "peak_bytes": max(r["outside_bytes"] for r in other),
            "file_bytes": other[0]["file_bytes"]}


def row_of(name, side, one, two, other, maps_seconds):
    stages = []
    for stage in [s["name"] for s in two[0]["stages"]]:
        alone, both = stage_seconds(one, stage), stage_seconds(two, stage)
        serial = min(max(2 * both - alone, 0), both)
        stages.append({"name": stage, "seconds": both, "one_thread_seconds": alone, "three_threads_seconds": serial + 2 * (both - serial) / 3})
    return {"scene": name, "resolution_px": side, "lights": len(two[0]["lights"]), "seconds": spread([r["total_seconds"] for r in two]),
            "one_thread_seconds": spread([r["total_seconds"] for r in one]),
            "processor_seconds": statistics.median(r["processor_seconds"] for r in two),
            "peak_bytes": max(r["outside_bytes"] for r in two), "file_bytes": two[0]["file_bytes"], "two_maps_seconds": maps_seconds,
            "stages": stages, **({"against": beside(two, other)} if other else {})}


def measure(build, folder, against):
    """Rows, each run of all of them before the next one."""
    rows, runs = chosen(), {}
    for _ in range(RUNS):
        for row in rows:
            for threads in (1, 2):
                runs.setdefault((row, threads), []).append(bake(build / "vxs", folder, *row, threads))
            if against:
                runs.setdefault((row, against), []).append(bake(against, folder, *row, 2))
    return [row_of(*row, runs[row, 1], runs[row, 2], runs.get((row, against)), two_maps(build, folder, *row)) for row in rows]


def growth(rows, row, figure):
    """For each doubling since the row before of the same scene; '' for the first."""
    before = [r for r in rows if r["scene"] == row["scene"] and r["resolution_px"] < row["resolution_px"]]
    if not before:
        return ""
    doublings = math.log2(row["resolution_px"] / before[-1]["resolution_px"])
    return f"{(figure(row) / figure(before[-1])) ** (1 / doublings):.2f}"


def print_tables(rows):
    median = lambda row: row["seconds"]["median"]
    seconds = lambda value: f"{value:.3g} s"
    name = lambda row: [row["scene"], str(row["resolution_px"])]
    markdown(["scene", "texels a side", "mesh to file", "least to most", "of the two maps alone", "memory", "file", "a doubling: time", "bytes"],
             [[*name(row), seconds(median(row)), f"{row['seconds']['min']:.3g} to {row['seconds']['max']:.3g}",
               f"{median(row) / row['two_maps_seconds']:.3f}", f"{row['peak_bytes'] / 2**20:.0f} MiB", f"{row['file_bytes'] / 1024:.0f} KiB",
               growth(rows, row, median), growth(rows, row, lambda r: r["file_bytes"])] for row in rows])
    if "against" in rows[0]:
        markdown(["scene", "texels a side", "this build", "the other", "time", "processor time", "memory", "file"],
                 [[*name(row), seconds(median(row)), seconds(row["against"]["seconds"]["median"]), f"{row['against']['seconds_ratio']:.2f}",
                   f"{row['against']['processor_seconds_ratio']:.2f}", f"{row['peak_bytes'] / row['against']['peak_bytes']:.2f}",
                   f"{row['file_bytes'] / row['against']['file_bytes']:.3f}"] for row in rows])
    took = lambda row, key, *names: sum(s[key] for s in row["stages"] if s["name"] in names)
    parts = {"before": BEFORE, "maps": ("maps",), "building": ("masks", "insert", "compress"), "file": ("merge", "encode", "write")}
    markdown(["scene", "texels a side", *[f"{part}: 1, 2, 3 threads" for part in parts], "all with 3", "if none waited, with 2"],
             [[*name(row), *[" ".join(f"{took(row, key, *stages):.3g}" for key in ("one_thread_seconds", "seconds", "three_threads_seconds"))
                             for stages in parts.values()],
               seconds(sum(s["three_threads_seconds"] for s in row["stages"])), seconds(row["processor_seconds"] / 2)] for row in rows])


def main():
    arguments = argparse.ArgumentParser(description="Measure bakes of large maps.")
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release", help="the build tree")
    arguments.add_argument("--json", type=pathlib.Path, default=ROOT / "build" / "large.json", help="where the result goes")
    arguments.add_argument("--against", type=pathlib.Path, help="the command vxs of another build")
    options = arguments.parse_args()
    with tempfile.TemporaryDirectory(prefix="vxs-large-") as folder:
        rows = measure(options.build.resolve(), pathlib.Path(folder), options.against and options.against.resolve())
    version = subprocess.run([options.build / "vxs", "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout.split()[1]
    options.json.parent.mkdir(parents=True, exist_ok=True)
    options.json.write_text(json.dumps({"vxs": version, "cores": len(os.sched_getaffinity(0)), "runs": RUNS, "rows": rows}, indent=2) + "\n")
    print_tables(rows)
    print(f"as JSON: {options.json}")


main()
