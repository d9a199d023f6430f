# Measure lookups, lists of lights and fog on a graphics processor, each beside its rivals (tests/bench/gpu.c), in a city and in
# Sponza; then an area light in a room and smoke (area.c, smoke.c). Tables, and JSON (--json, docs/gpu.schema.json).
#
#     make bench-gpu                                                  # llvmpipe, 320 x 180
#     VXS_GL=egl make bench-gpu size=1920x1080                        # what EGL finds, for instance a graphics processor
#
# On a machine without the repository: --stage bake fills a folder where the programs were built. Then --stage measure needs this
# file, tables.py, that folder and the programs gpu, area and smoke of tests/bench alone.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import time

from tables import SPONZA, SPONZA_SUN, markdown

CITY_VIEWS = ["street:-20,4,-150,-20,12,0", "above:-180,120,-180,0,0,0"]
SPONZA_VIEWS = ["hall:-9,2,0.3,8,4.5,-0.5", "above:0,28,3,0,0,0"]
LAMPS = {165: (15, 11), 500: (25, 20), 2000: (50, 40)}
LAMPS_OF_FILE = 1000
GRID_METRES = 825
AREA_SCREEN = ["--corner", "-1.8,1.2,-2.9", "--across", "1.6,0,0", "--up", "0,0.9,0", "--picture", "--eye", "3,1.6,2.2", "--target", "-2,1.2,-2", "--fog", "0.1"]
# program, scene, group, view, texels a side, options, names of cells; the rival of a group is one of them
VOLUMES = [("area", "room.glb", "area light of 256 VPLs", "room", 128, [*AREA_SCREEN, "--samples", "4096"],
            {"imperfect:256": "at once", "imperfect, one by one:256": "one by one (rival)", "exact maps:256": "at once, exact maps"}),
           ("smoke", None, "smoke of 4000 capsules", "columns", 256, ["--side", "256", "--capsules", "4000"],
            {"adaptive:8": "curves of 8 nodes", "adaptive, unsorted:8": "curves of 8 nodes, unsorted", "deep:100": "deep map, lines off by .01",
             "uncompressed:1": "deep map, all segments (rival)"})]
AREA_RAYS = 64  # pixels of the reference, across


def with_lamps(scene, out, columns, rows, part):
    """The scene without its lights and with a part of a grid of spot lights over it, whose cones overlap: a pixel sees several."""
    apart = GRID_METRES / columns
    data = scene.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    gltf, rest = json.loads(data[20:20 + size]), data[20 + size:]
    for node in gltf["nodes"]:
        node.get("extensions", {}).pop("KHR_lights_punctual", None)
    first = len(gltf["nodes"])
    lamps = [(c, r) for r in range(rows) for c in range(columns)][LAMPS_OF_FILE * part:][:LAMPS_OF_FILE]
    gltf.setdefault("extensions", {})["KHR_lights_punctual"] = {"lights": [
        {"type": "spot", "name": f"lamp{n}", "intensity": 3000, "range": 4 * apart, "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.87}}
        for n in range(len(lamps))]}
    half = 2 ** -0.5
    gltf["nodes"] += [{"translation": [apart * (c - columns // 2), 1.45 * apart, apart * (r - rows // 2)], "rotation": [-half, 0, 0, half],
                       "extensions": {"KHR_lights_punctual": {"light": n}}} for n, (c, r) in enumerate(lamps)]
    gltf["scenes"][gltf.get("scene", 0)]["nodes"] += range(first, first + len(lamps))
    gltf["extensionsUsed"] = sorted({*gltf.get("extensionsUsed", []), "KHR_lights_punctual"})
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    out.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)


def bake(args):
    """Scenes and assets in the folder. Sponza is left out where it is not."""
    folder, vxs = args.folder, args.vxs
    folder.mkdir(parents=True, exist_ok=True)

    def made(scene, name, *options):
        subprocess.run([vxs, "bake", folder / scene, "-o", folder / name, "--force", "--quiet", *map(str, options)], check=True)

    subprocess.run([vxs, "scene", "city", "--triangles", "100000", "--blocks", "8", "-o", folder / "city.glb", "--force", "--quiet"], check=True)
    scenes = {"city": []}
    (folder / "sponza.glb").unlink(missing_ok=True)
    if SPONZA.is_file():
        shutil.copy(SPONZA, folder / "sponza.glb")
        scenes["sponza"] = ["--sun", SPONZA_SUN]
    for scene, sun in scenes.items():
        for px in args.resolutions:
            for coding in ("blocks", "dag"):
                made(f"{scene}.glb", f"{scene}-{px}-{coding}.vxs", "--resolution", px, "--coding", coding, *sun)
    subprocess.run([vxs, "scene", "room", "--triangles", "20000", "-o", folder / "room.glb", "--force", "--quiet"], check=True)
    for count, (columns, rows) in LAMPS.items():
        for part in range(-(-count // LAMPS_OF_FILE)):
            with_lamps(folder / "city.glb", folder / "lamps.glb", columns, rows, part)
            made("lamps.glb", f"lamps{count}-{part}.vxs", "--resolution", args.lamp_resolution if count == 165 else 256)


def volumes_rows(scene, group, view, side_px, names):
    """Rows as of tests/bench/gpu, of a report of area or smoke."""
    rows = [{"group": group, "name": names[f"{c['technique']}:{c['value']}"], "view": view, "resolution_px": side_px, "runs": scene["rounds"],
             "ms": {"median": c["ms"]["median"], "min": c["ms"]["least"], "max": c["ms"]["greatest"]},
             "parts_ms": {p["name"]: p["ms"] for p in c["parts"]}, "relative_rms": c["error"]["relative_rms"]} for c in scene["cells"] if not c["refused"]]
    rival = next(row["ms"]["median"] for row in rows if "(rival)" in row["name"])
    return [{**row, "of_rival": row["ms"]["median"] / rival} for row in rows]


def measure_volumes(args, clock, program, scene, group, view, side_px, options, names):
    """(A part of the report without what all parts have, None), or (None, why there is none)."""
    is_less = program == "area" and clock != "timer"  # llvmpipe draws a fifth of the sides, and shadows of fewer points
    width, height = (max(16, int(px) // (5 if is_less else 1)) for px in args.size.split("x"))
    out = args.folder / "volumes.json"
    out.unlink(missing_ok=True)
    print(f"{group}, {width} x {height}", flush=True)
    done = subprocess.run([args.gpu.with_name(program), *([args.folder / scene] if scene else []), *options, "--width", str(width), "--height", str(height),
                           *(["--apart", str(max(1, width // AREA_RAYS)), "--points", "16384" if is_less else "262144"] if program == "area" else []), *(word for name in names for word in ("--cell", name)),
                           "--gl", os.environ.get("VXS_GL", "osmesa"), "--clock", clock, "--rounds", str(min(args.runs, 15 if clock == "timer" else 3)),
                           "--json", out, "--force"], stdout=subprocess.DEVNULL)
    if done.returncode:
        return None, f"{group}: exit status {done.returncode}"
    rows = volumes_rows(json.loads(out.read_text()), group, view, side_px, names)
    markdown(["", "ms", *rows[0]["parts_ms"], "of the rival", "error"],
             [[row["name"], f"{row['ms']['median']:.4g}", *(f"{ms:.4g}" for ms in row["parts_ms"].values()), f"{row['of_rival']:.2f}",
               f"{row['relative_rms']:.4f}"] for row in rows])
    return {"scene": scene or view, "width_px": width, "height_px": height, "warm_ms": 0, "rows": rows}, None


def measure(args):
    """The report of each part."""
    folder = args.folder
    assets = {scene: [folder / f"{scene}-{px}-{coding}.vxs" for px in args.resolutions for coding in ("blocks", "dag")] for scene in ("city", "sponza")}
    parts = [("city", assets["city"], CITY_VIEWS, []),
             ("city", assets["city"][:1], CITY_VIEWS, ["--only", "fog", "--fog", "0.01"]),
             ("city", assets["city"][:2], CITY_VIEWS, ["--shader", "fragment", "--storage", "buffer"]),
             *(("city", sorted(folder.glob(f"lamps{count}-*.vxs")), CITY_VIEWS, [] if count == 165 else ["--only", "lists"]) for count in LAMPS),
             # textures hold sizes of their asset, so each needs programs of its own: the city tells what they cost
             ("sponza", assets["sponza"], SPONZA_VIEWS, ["--storage", "buffer"])]
    width, height = args.size.split("x")
    reports, skipped, status = [], [], 0
    for scene, files, views, options in parts:
        if not (folder / f"{scene}.glb").is_file():
            skipped.append(f"{scene}: there is no {folder / scene}.glb")
            print(f"skipped: {skipped[-1]}\n")
            continue
        begin = time.monotonic()
        out = folder / "part.json"
        out.unlink(missing_ok=True)
        command = [args.gpu, folder / f"{scene}.glb", *files, *(word for v in views for word in ("--view", v)), "--width", width, "--height", height,
                   "--runs", str(args.runs), "--warm", str(args.warm), "--force", "--json", out, *options]
        done = subprocess.run(command)
        if done.returncode > 1:
            skipped.append(f"{scene} {' '.join(options)}: exit status {done.returncode}")
            print(f"failed: {skipped[-1]}", flush=True)
        status = max(status, min(done.returncode, 2) if done.returncode >= 0 else 2)
        if out.exists():  # of a part that failed, what was measured
            reports.append(json.loads(out.read_text()))
            out.unlink()
        print(f"\n{time.monotonic() - begin:.0f} s\n", flush=True)
    for part in VOLUMES if reports else []:
        report, failed = measure_volumes(args, reports[0]["clock"], *part)
        if failed:
            skipped.append(failed)
            print(f"failed: {failed}", flush=True)
            status = 2
        else:
            reports.append({**reports[0], "shader": "compute", **report})
    args.json.write_text(json.dumps({"parts": reports, "skipped": skipped}, indent=2) + "\n")
    print(args.json)
    return status


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--vxs", default="build/release/vxs", help="to bake")
    parser.add_argument("--gpu", type=pathlib.Path, default=pathlib.Path("build/release/tests/bench/gpu"), help="to measure; area and smoke are beside it")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("build/gpu"), help="of scenes and assets")
    parser.add_argument("--json", type=pathlib.Path, default=pathlib.Path("build/gpu.json"))
    parser.add_argument("--stage", choices=["all", "bake", "measure"], default="all")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--resolutions", type=int, nargs="+", default=[4096, 16384])
    parser.add_argument("--lamp-resolution", type=int, default=4096)
    parser.add_argument("--runs", type=int, default=61)
    parser.add_argument("--warm", type=int, default=250 if os.environ.get("VXS_GL") == "egl" else 0, help="milliseconds of work before each figure")
    args = parser.parse_args()
    if args.stage != "measure":
        bake(args)
    sys.exit(measure(args) if args.stage != "bake" else 0)


if __name__ == "__main__":
    main()
