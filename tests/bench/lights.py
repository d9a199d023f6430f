# Measure frames of a city at night, lit by 165 spot lights: what culling and lookups take, by lights per pixel, with lists of
# lights and by querying all of them ([CPVS16] 6.3, where a GTX Titan takes 3.2 ms at 1920 x 1080, 9 at worst). A table, and JSON
# (--json): the reports of vxs render, docs/render.schema.json, for "on" and "off".
# Runs with lists and without follow each other; of each frame the median counts. On a processor with a graphics card:
#
#     make bench-lights gl=egl size=1920x1080 resolution=8192 frames=200          # build/lights.json
#
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import pathlib
import re
import statistics
import subprocess
import tempfile

from tables import markdown

# a flight low along a street, looking at the ground ahead, and a look from above in the end: eye, target
PATH = [*((x, 9, -226, x + 22, 0, -226) for x in range(-290, 130, 60)), (150, 60, -250, 60, 0, -150)]


def made(vxs, folder, resolution):
    """The scene, and an asset of its spot lights."""
    scene, asset, plan = folder / "city.glb", folder / "city.vxs", folder / "plan.json"
    subprocess.run([vxs, "scene", "city", "--spots", "165", "-o", scene, "--quiet"], check=True)
    subprocess.run([vxs, "plan", scene, "--resolution", "64", "--json", plan, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    names = sorted(set(re.findall(r'"(spot\d+)"', plan.read_text())))
    lights = [word for name in names for word in ("--light", name)]
    subprocess.run([vxs, "bake", scene, "-o", asset, "--resolution", str(resolution), "--quiet", *lights], check=True)
    return scene, asset


def frames_of(args, folder, scene, asset, mode):
    width, height = args.size.split("x")
    (folder / "path.txt").write_text("".join(" ".join(map(str, key)) + "\n" for key in PATH))
    subprocess.run([args.vxs, "render", scene, asset, "-o", folder / "last.png", "--force", "--samples", "1", "--width", width, "--height", height,
                    "--filter", str(args.filter), "--gl", args.gl, "--cull", mode, "--path", folder / "path.txt", "--frames", str(args.frames),
                    "--json", folder / "frames.json", "--quiet"], check=True)
    return json.loads((folder / "frames.json").read_text())


def median_report(reports):
    """Of reports of the same frames, one: its times are medians."""
    first = reports[0]
    for n, frame in enumerate(first["frames"]):
        for stage in frame["ms"]:
            frame["ms"][stage] = statistics.median(r["frames"][n]["ms"][stage] for r in reports)
        frame["total_ms"] = sum(frame["ms"].values())
    return first


def rows_of(found):
    """Frames, but for the first, in thirds by lights per pixel."""
    frames = sorted(zip(found["on"]["frames"][1:], found["off"]["frames"][1:]), key=lambda pair: pair[0]["lights_per_sample"])
    third = -(-len(frames) // 3)
    for at in range(0, len(frames), third):
        some = frames[at:at + third]

        def middle(of):
            return statistics.median(map(of, some))

        yield [f"{middle(lambda p: p[0]['lights_per_sample']):.2f}", str(max(p[0]["longest_list"] for p in some)),
               f"{middle(lambda p: p[0]['ms']['cull']):.3g}", f"{middle(lambda p: p[0]['ms']['shade']):.3g}",
               f"{middle(lambda p: p[1]['ms']['shade']):.4g}",
               f"{middle(lambda p: p[1]['ms']['shade'] / (p[0]['ms']['shade'] + p[0]['ms']['cull'])):.1f}"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--vxs", required=True)
    parser.add_argument("--json", default="build/lights.json")
    parser.add_argument("--gl", default="osmesa")
    parser.add_argument("--size", default="240x136")
    parser.add_argument("--filter", type=int, default=9)
    parser.add_argument("--resolution", type=int, default=1024)
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--runs", type=int, default=3)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        scene, asset = made(args.vxs, folder, args.resolution)
        reports = {"on": [], "off": []}
        for _ in range(args.runs):
            for mode, of_mode in reports.items():
                of_mode.append(frames_of(args, folder, scene, asset, mode))
    found = {mode: median_report(of_mode) for mode, of_mode in reports.items()}
    pathlib.Path(args.json).write_text(json.dumps(found, indent=2) + "\n")
    on = found["on"]
    print(f"{on['lights']} spot lights of {args.resolution} texels, {on['word_bytes'] / 1e6:.1f} MB; {args.size}, {args.filter} x {args.filter} taps; "
          f"{on['renderer']}; {args.frames - 1} frames in thirds, {args.runs} runs\n")
    markdown(["lights per pixel", "longest list", "lists, ms", "light, ms", "light without lists, ms", "times as fast"], list(rows_of(found)))
    print(args.json)


if __name__ == "__main__":
    main()
