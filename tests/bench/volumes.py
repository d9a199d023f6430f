# Error against run time of shadows in fog: each technique, rivals too, in several scenes; one process and context a scene (tests/bench/volumes.c).
# JSON (docs/volumes.schema.json), a plot for each scene, and the front: what no other is both faster and nearer than.
#
#     make bench-volumes                                                      # llvmpipe, build/volumes.json, build/volumes/
#     make bench-volumes gl=egl size=1920x1080 rounds=31                      # a graphics card
#
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import pathlib
import subprocess

from plots import COLOURS, block, draw, quoted
from tables import markdown

SPONZA = "sponza.glb"  # a real one: the folder of --scenes

# name, how the scene is made or a file's name, how it is baked, and what is seen
SCENES = [
    ("city street, sun", ["city", "--triangles", "100000", "--blocks", "8"], [],
     ["--eye", "-20,4,-150", "--target", "-20,12,0", "--fog", "0.01"]),
    ("city from above, sun", ["city", "--triangles", "100000", "--blocks", "8"], [],
     ["--eye", "-180,120,-180", "--target", "0,0,0", "--fog", "0.004"]),
    ("room, lamp", ["room", "--triangles", "20000"], [], ["--light", "lamp", "--eye", "3,1.6,2.2", "--target", "-2,1.2,-2", "--fog", "0.1"]),
    ("forest, sun", ["forest", "--triangles", "100000"], [], ["--eye", "2,2,2", "--target", "20,4,24", "--fog", "0.03"]),
    ("Sponza, sun", SPONZA, ["--sun", "0.1,-1,0.15"], ["--eye", "-9,2,0.3", "--target", "8,4.5,-0.5", "--fog", "0.06"]),
]


def measured(args, name, made, baked, seen):
    """The cells of a scene; None where it is absent."""
    folder = pathlib.Path(args.folder)
    stem = name.lower().replace(", ", "-").replace(" ", "-")
    scene, asset, figures = folder / f"{stem}.glb", folder / f"{stem}.vxs", folder / f"{stem}.json"
    if made == SPONZA:
        scene = pathlib.Path(args.scenes) / SPONZA
        if not scene.exists():
            print(f"{name}: skipped, there is no {scene}")
            return None
    else:
        subprocess.run([args.build / "vxs", "scene", *made, "-o", scene, "--force", "--quiet"], check=True)
    subprocess.run([args.build / "vxs", "bake", scene, "-o", asset, "--force", "--quiet", "--baseline", "off", "--resolution", str(args.resolution), *baked],
                   check=True)
    width, height = args.size.split("x")
    print(f"\n{name}", flush=True)
    subprocess.run([args.build / "tests/bench/volumes", scene, asset, *seen, "--width", width, "--height", height, "--rounds", str(args.rounds), "--gl", args.gl,
                    "--json", figures], check=True)
    return {"name": name, "file_bytes": asset.stat().st_size, **json.loads(figures.read_text())}


def plot(path, scene):
    """Relative RMS error against milliseconds, a line for each technique; what is on the front is ringed."""
    cells = [c for c in scene["cells"] if not c["refused"]]
    names = list(dict.fromkeys(c["technique"] for c in cells))
    rows = lambda some: [(c["ms"]["median"], max(c["error"]["relative_rms"], 1e-7), c["value"]) for c in some]
    script = "".join(block(f"t{n}", rows(c for c in cells if c["technique"] == name)) for n, name in enumerate(names))
    script += block("front", rows(c for c in cells if c["front"]))
    script += f"set logscale xy\nset xlabel 'ms a frame, {scene['width_px']} x {scene['height_px']}'\nset ylabel 'relative RMS error'\n" \
        f"set format y '%.0e'\nset title {quoted(scene['name'])}\n"
    lines = [f"$t{n} using 1:2 with linespoints pt 7 ps 0.5 lw 1.4 lc rgb '{COLOURS[n % len(COLOURS)]}' title {quoted(name)}"
             for n, name in enumerate(names)]
    lines.append("$front using 1:2 with points pt 6 ps 1.1 lc rgb '#222222' title 'front'")
    draw(path, [*names, "front"], script + "plot " + ", ".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=pathlib.Path, default="build/release")
    parser.add_argument("--json", default="build/volumes.json")
    parser.add_argument("--folder", default="build/volumes")
    parser.add_argument("--scenes", default="../shared/scenes/real")
    parser.add_argument("--gl", default="osmesa")
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--resolution", type=int, default=1024)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", help="the scene of this name")
    args = parser.parse_args()
    folder = pathlib.Path(args.folder)
    folder.mkdir(parents=True, exist_ok=True)
    scenes = [s for s in (measured(args, *scene) for scene in SCENES if args.only in (None, scene[0])) if s]
    pathlib.Path(args.json).write_text(json.dumps({"scenes": scenes}, indent=2) + "\n")
    for scene in scenes:
        plot(folder / (scene["name"].lower().replace(", ", "-").replace(" ", "-") + ".svg"), scene)
    print()
    markdown(["scene", "technique", "knob", "ms", "error", "largest", "flicker"],
             [[s["name"], c["technique"], f"{c['value']} {c['knob']}", f"{c['ms']['median']:.3g}", f"{c['error']['relative_rms']:.2g}",
               f"{c['error']['most']:.2g}", f"{c['flicker']:.2g}"] for s in scenes for c in s["cells"] if c.get("front")])


if __name__ == "__main__":
    main()
