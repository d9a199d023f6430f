# Measure bakes and lookups, print them beside the aims, and write them as JSON (docs/bench.schema.json).
# BENCH_RESOLUTIONS: texels a side (default 512 to 16384).  BENCH_RUNS: bakes of each, of which the median counts (default 5).
# VXS_SCENES: the shared scenes; without them only the city is measured.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
RESOLUTIONS = [int(n) for n in os.environ.get("BENCH_RESOLUTIONS", "512 1024 2048 4096 8192 16384").split()]
RUNS = int(os.environ.get("BENCH_RUNS", "5"))
SCENES = pathlib.Path(os.environ.get("VXS_SCENES", ROOT.parent / "shared" / "scenes"))
MAPS_TO_DAG = ("pyramid", "masks", "insert", "compress", "merge")
LOOKUP_RESOLUTION = 4096

# what, at which resolution (None: the worst of all), which figure, unit, aim
AIMS = [
    ("mesh to file", 4096, "wall_seconds", "s", 1.0),
    ("mesh to file", 16384, "wall_seconds", "s", 6.0),
    ("maps to DAG", 4096, "maps_to_dag_seconds", "s", 0.150),
    ("maps to DAG", 8192, "maps_to_dag_seconds", "s", 0.600),
    ("peak memory", None, "peak_bytes", "MiB", 600),
]
LOOKUP_AIM = ("a million scattered single taps", "s", 0.150)


def run(*command):
    """What the command printed; its warnings are not shown unless it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def scenes(vxs, folder):
    """Name, file, options. The city is seen in the light of its own sun."""
    city = folder / "city.glb"
    run(vxs, "scene", "city", "-o", city)
    found = [("city", city, [])]
    sponza = SCENES / "real" / "sponza.glb"
    if sponza.is_file():
        found.append(("sponza", sponza, ["--sun", "-0.4,-1,-0.2"]))
    else:
        print(f"no {sponza}: only the city is measured", file=sys.stderr)
    return found


def bake_once(vxs, scene, options, asset):
    report = asset.with_suffix(".json")
    start = time.monotonic()
    run(vxs, "bake", scene, "-o", asset, "--baseline", "off", "--json", report, *options)
    return json.loads(report.read_text()) | {"wall_seconds": time.monotonic() - start}


def bake(vxs, name, scene, options, resolution, folder):
    """The medians of RUNS bakes; of memory the most."""
    asset = folder / f"{name}-{resolution}.vxs"
    reports = [bake_once(vxs, scene, [*options, "--resolution", str(resolution)], asset) for _ in range(RUNS)]
    stages = [{s["name"]: s["seconds"] for s in r["stages"]} for r in reports]
    size = reports[0]["lights"][0]["size"]
    return {
        "scene": name, "resolution_px": resolution, "triangles": reports[0]["casters"]["triangles"],
        "wall_seconds": statistics.median(r["wall_seconds"] for r in reports),
        "total_seconds": statistics.median(r["total_seconds"] for r in reports),
        "maps_to_dag_seconds": statistics.median(sum(s[n] for n in MAPS_TO_DAG) for s in stages),
        "stage_seconds": {n: statistics.median(s[n] for s in stages) for n in stages[0]},
        "peak_bytes": max(r["peak_bytes"] for r in reports),
        "file_bytes": reports[0]["file_bytes"], "memory_bytes": size["memory_bytes"],
        "file_bit_per_texel": 8 * reports[0]["file_bytes"] / resolution**2,
        "threads": reports[0]["options"]["threads"], "renderer": reports[0]["renderer"],
    }


def machine():
    model = platform.processor() or platform.machine()
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    return {"processor": model, "cores": len(os.sched_getaffinity(0)),
            "memory_bytes": os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"), "system": platform.platform()}


def aims(bakes, lookups):
    found = []
    for what, resolution, figure, unit, aim in AIMS:
        for scene in dict.fromkeys(b["scene"] for b in bakes):
            values = [b[figure] for b in bakes if b["scene"] == scene and resolution in (None, b["resolution_px"])]
            if values:
                measured = max(values) / (2**20 if unit == "MiB" else 1)
                at = f" at {resolution}" if resolution else ""
                found.append({"what": f"{what}, {scene}{at}", "unit": unit, "aim": aim, "measured": measured})
    for name in ("volume", "surface") if lookups else ():
        what, unit, aim = LOOKUP_AIM
        found.append({"what": f"{what}, {name}", "unit": unit, "aim": aim, "measured": lookups[name]["tap_1_seconds"]})
    return [a | {"met": a["measured"] <= a["aim"]} for a in found]


def table(head, rows):
    """Markdown, in columns for those who read it as it is."""
    widths = [max(len(row[n]) for row in [head, *rows]) for n in range(len(head))]
    line = lambda cells: "| " + " | ".join(c.rjust(w) if n else c.ljust(w) for n, (c, w) in enumerate(zip(cells, widths))) + " |"
    rule = "|" + "|".join("-" * (w + 2) if not n else "-" * (w + 1) + ":" for n, w in enumerate(widths)) + "|"
    print("\n".join([line(head), rule, *map(line, rows)]) + "\n")


def print_tables(result):
    ms = lambda seconds: f"{1e3 * seconds:.0f} ms"
    m = result["machine"]
    print(f"vxs {result['vxs']} on {m['processor']}, {m['cores']} cores, {m['memory_bytes'] / 2**30:.0f} GiB, {m['system']}; "
          f"medians of {result['runs']} runs\n")
    table(["scene", "texels a side", "mesh to file", "of that depth maps", "maps to DAG", "peak memory", "file", "bit/texel"],
          [[b["scene"], str(b["resolution_px"]), ms(b["wall_seconds"]), ms(b["stage_seconds"]["maps"]), ms(b["maps_to_dag_seconds"]),
            f"{b['peak_bytes'] / 2**20:.0f} MiB", f"{b['file_bytes'] / 1024:.0f} KiB", f"{b['file_bit_per_texel']:.3f}"]
           for b in result["bakes"]])
    if result["lookups"]:
        table([f"a million lookups, one thread, city at {LOOKUP_RESOLUTION}", "1 tap", "9 x 9 taps"],
              [[f"{points}, {method}", ms(result["lookups"][name][prefix + "tap_1_seconds"]),
                ms(result["lookups"][name][prefix + "tap_81_seconds"])]
               for name, points in (("volume", "anywhere in the volume"), ("surface", "within a voxel of a shadow's start"))
               for method, prefix in (("vxs", ""), ("float depth map", "depth_map_"))])
    table(["aim", "at most", "measured", ""],
          [[a["what"], f"{a['aim']:.3g} {a['unit']}", f"{a['measured']:.3g} {a['unit']}",
            "met" if a["met"] else f"missed by {100 * (a['measured'] / a['aim'] - 1):.0f} %"] for a in result["aims"]])


def main():
    arguments = argparse.ArgumentParser(description="Measure bakes and lookups.")
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release", help="the build tree")
    arguments.add_argument("--json", type=pathlib.Path, default=ROOT / "build" / "bench.json", help="where the result goes")
    options = arguments.parse_args()
    vxs, folder = options.build.resolve() / "vxs", options.build / "bench"
    folder.mkdir(parents=True, exist_ok=True)

    found = scenes(vxs, folder)
    bakes = []
    for name, scene, extra in found:
        for resolution in RESOLUTIONS:
            print(f"bake {name} at {resolution}", file=sys.stderr)
            bakes.append(bake(vxs, name, scene, extra, resolution, folder))
    lookups = None
    asset = folder / f"city-{LOOKUP_RESOLUTION}.vxs"
    if LOOKUP_RESOLUTION in RESOLUTIONS:
        lookups = json.loads(run(options.build / "tests" / "bench" / "lookups", asset))

    version = run(vxs, "--version").split()[1]
    result = {"vxs": version, "machine": machine(), "runs": RUNS, "bakes": bakes, "lookups": lookups, "aims": aims(bakes, lookups)}
    options.json.parent.mkdir(parents=True, exist_ok=True)
    options.json.write_text(json.dumps(result, indent=2) + "\n")
    print_tables(result)
    print(f"as JSON: {options.json}")


main()
