# Error against run time of shadows in fog, of smoke, and of area lights: each technique, rivals too, in several scenes; one process
# and context a scene (tests/bench/volumes.c, smoke.c, area.c). JSON (docs/volumes.schema.json), a page of it and plots for each
# scene, and tables in Markdown: how each does, and how far it is behind the front of what nothing as near is faster than; ratios
# beside those of the papers, and where error rises along a knob.
#
#     make bench-volumes                                                      # llvmpipe; build/volumes.json, .html, build/volumes/
#     make bench-volumes plots=docs/plots                                     # and the plots of docs/measurements.md
#     make bench-volumes only=room values=2 rounds=1                          # a look at some scenes
#     make bench-volumes only=smoke clock=processor                           # times that other programs hardly disturb
#     make bench-volumes gl=egl size=1920x1080 rounds=31                      # a graphics card
#
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import math
import pathlib
import subprocess

import spheres
from plots import COLOURS, block, draw, quoted
from tables import markdown
from volumes_claims import claims, drawn, monotone_text, slopes

SPONZA = "sponza.glb"  # a real one: the folder of --scenes
CITY = ["city", "--triangles", "100000", "--blocks", "8"]
ROOM = ["room", "--triangles", "20000"]

# name, how the scene is made or a file's name, how it is baked, and what is seen
SCENES = [
    ("city street, sun", CITY, [], ["--eye", "-20,4,-150", "--target", "-20,12,0", "--fog", "0.01"]),
    ("city from above, sun", CITY, [], ["--eye", "-180,120,-180", "--target", "0,0,0", "--fog", "0.004"]),
    ("forest, sun", ["forest", "--triangles", "100000"], [], ["--eye", "2,2,2", "--target", "20,4,24", "--fog", "0.03"]),
    ("Sponza, sun", SPONZA, ["--sun", "0.1,-1,0.15"], ["--eye", "-9,2,0.3", "--target", "8,4.5,-0.5", "--fog", "0.06"]),
    ("Sponza window, sun", SPONZA, ["--sun", "0.3,-0.7,-0.5"], ["--eye", "-3,5.6,-4.5", "--target", "2,3,4", "--fog", "0.06"]),
    ("spheres, sun", "spheres", ["--sun", "-0.4,-1,-0.3"], ["--spheres", "--eye", "4.5,1.5,3.5", "--target", "0,0,0", "--fog", "0.1"]),
    ("spheres, lamp", "ball", [], ["--spheres", "--eye", "3.5,1.5,3.5", "--target", "-1,0,-1", "--fog", "0.1"]),
    ("room, lamp", ROOM, [], ["--light", "lamp", "--eye", "3,1.6,2.2", "--target", "-2,1.2,-2", "--fog", "0.1"]),
    ("room, lamp off screen", ROOM, [], ["--light", "lamp", "--eye", "3,1.6,2.2", "--target", "0,1,3", "--fog", "0.1"]),
    ("room, lamp behind", ROOM, [], ["--light", "lamp", "--eye", "1,1.5,0.8", "--target", "3.9,1.1,2.9", "--fog", "0.1"]),
    ("room, eye in shadow", ROOM, [], ["--light", "lamp", "--eye", "0.3,0.5,0.1", "--target", "-3.9,0.9,-2", "--fog", "0.1"]),
]

# of capsules, that no file has
SMOKE = [("smoke columns", "columns"), ("smoke with hair", "hair"), ("smoke, leaves", "leaves")]
SMOKE_TEXELS = 8  # of a light's map on one of the smoke's

# name, scene, and the rectangle that shines with what is seen of it
AREAS = [
    ("area light, room", ROOM, ["--corner", "-1.8,1.2,-2.9", "--across", "1.6,0,0", "--up", "0,0.9,0", "--picture",
                                "--eye", "3,1.6,2.2", "--target", "-2,1.2,-2", "--fog", "0.1"]),
    ("area light behind a wall", "wall", ["--corner", "-1,0.7,-1.5", "--across", "2,0,0", "--up", "0,1.6,0",
                                          "--eye", "4,1.6,7", "--target", "0,1.2,0", "--fog", "0.05"]),
]
LEAST_PART = 4e-3  # of a frame: parts that take less are not reported in tables
AREA_PART = 0.4  # of the sides of a view: each of its pixels gathers hundreds of VPLs


def stem_of(name):
    return name.lower().replace(", ", "-").replace(" ", "-")


def told(args, name, program, *arguments, part=1):
    """What a program measured, and what follows from that. part: of the sides of the view."""
    figures, (width, height) = pathlib.Path(args.folder) / f"{stem_of(name)}.json", (str(max(16, round(part * int(px)))) for px in args.size.split("x"))
    print(f"\n{name}", flush=True)
    subprocess.run([args.build / "tests/bench" / program, *arguments, "--width", width, "--height", height, "--rounds", str(args.rounds), "--gl", args.gl,
                    "--clock", args.clock, "--values", str(args.values), "--json", figures], check=True)
    scene = json.loads(figures.read_text())
    ratios = claims(scene)
    print(monotone_text(scene))
    for technique, power in slopes(scene).items():
        print(f"{technique}: the error falls as VPLs to the power of {power:.2f}")
    for claim in ratios:
        print(f"{claim['what']}: {claim['value']:.3g} times; the paper has {claim['paper']:g}")
    return {"name": name, **scene, **({"claims": ratios} if ratios else {})}


def made_scene(args, name, made):
    """Its path; None where it is a file that is absent."""
    folder = pathlib.Path(args.folder)
    if made == SPONZA:
        scene = pathlib.Path(args.scenes) / SPONZA
        if not scene.exists():
            print(f"{name}: skipped, there is no {scene}")
        return scene if scene.exists() else None
    if made in ("spheres", "ball", "wall"):
        scene = folder / f"{made}.gltf"
        spheres.write_wall(scene) if made == "wall" else spheres.write(scene, made == "ball")
    else:
        scene = folder / f"{made[0]}.glb"
        subprocess.run([args.build / "vxs", "scene", *made, "-o", scene, "--force", "--quiet"], check=True)
    return scene


def measured(args, name, made, baked, seen):
    """The cells of a scene in fog; None where it is absent."""
    scene, asset = made_scene(args, name, made), (pathlib.Path(args.folder) / stem_of(name)).with_suffix(".vxs")
    if not scene:
        return None
    subprocess.run([args.build / "vxs", "bake", scene, "-o", asset, "--force", "--quiet", "--resolution", str(args.resolution), *baked],
                   check=True)
    return {**told(args, name, "volumes", scene, asset, *seen), "file_bytes": asset.stat().st_size}


def measured_smoke(args, name, kind):
    return told(args, name, "smoke", "--scene", kind, "--side", str(args.resolution // SMOKE_TEXELS), "--capsules", str(args.capsules))


def measured_area(args, name, made, seen):
    return told(args, name, "area", made_scene(args, name, made), *seen, "--samples", str(args.samples), "--points", str(args.points), part=AREA_PART)


def plot(path, scene, axis, figure):
    """Relative RMS error against a figure of cells, a line for each technique; what is on the front is ringed."""
    cells = [c for c in drawn(scene) if figure(c)]
    names = list(dict.fromkeys(c["technique"] for c in cells))
    rows = lambda some: [(figure(c), max(c["error"]["relative_rms"], 1e-7), c["value"]) for c in some]
    script = "".join(block(f"t{n}", rows(c for c in cells if c["technique"] == name)) for n, name in enumerate(names))
    script += block("front", rows(c for c in cells if c["front"]))
    script += f"set logscale xy\nset xlabel '{axis}'\nset ylabel 'relative RMS error'\n" \
        f"set format y '%.0e'\nset title {quoted(scene['name'])}\n"
    lines = [f"$t{n} using 1:2 with linespoints pt 7 ps 0.5 lw 1.4 lc rgb '{COLOURS[n % len(COLOURS)]}' title {quoted(name)}"
             for n, name in enumerate(names)]
    lines.append("$front using 1:2 with points pt 6 ps 1.1 lc rgb '#222222' title 'front'")
    draw(path, [*names, "front"], script + "plot " + ", ".join(lines) + "\n")


def plots_of(folder, scene):
    stem = stem_of(scene["name"])
    plot(folder / f"volumes-{stem}.svg", scene, f"ms a frame, {scene['width_px']} x {scene['height_px']}", lambda c: c["ms"]["median"])
    if any("bytes_per_texel" in c for c in drawn(scene)):
        plot(folder / f"volumes-{stem}-bytes.svg", scene, "bytes a texel", lambda c: c.get("bytes_per_texel"))


def cells_by_setting(scenes):
    """{(technique, value, knob): [its cell in each scene, None where it was refused]}, in the order of the first scene."""
    key = lambda c: (c["technique"], c["value"], c["knob"])
    found = [{key(c): c for c in drawn(s)} for s in scenes]
    return {key(c): [cells.get(key(c)) for cells in found] for s in scenes for c in s["cells"]}


def settings_to_tell(settings):
    """Those that are on the front somewhere; of a technique that never is, the one that is least behind."""
    behind = lambda cells: math.prod(c["behind"] for c in cells if c) ** (1 / max(1, sum(map(bool, cells))))
    is_front = lambda cells: any(c and c["front"] for c in cells)
    told = []
    for name in dict.fromkeys(name for name, _, _ in settings):
        mine = [key for key in settings if key[0] == name]
        drawn = sorted(filter(lambda key: any(settings[key]), mine), key=lambda key: behind(settings[key]))
        told += [key for key in mine if is_front(settings[key])] or drawn[:1] or mine[:1]
    return told


def cell_text(cell):
    if not cell:
        return "refused"
    bytes_a_texel = f"{cell['bytes_per_texel']:.3g} B, " if "bytes_per_texel" in cell else ""
    told = [p["ms"] for p in cell.get("parts", []) if p["ms"] > LEAST_PART * cell["ms"]["median"]] or [cell["ms"]["median"]]
    figures = f"{bytes_a_texel}{' + '.join(f'{t:.3g}' for t in told)} ms, {cell['error']['relative_rms']:.2g}"
    return f"**{figures}**" if cell["front"] else f"{figures}, {cell['behind']:.2g} x"


def tables(scenes):
    """A table for suns, one for lamps, one for smoke and one for area lights, ready for docs/: milliseconds and relative RMS; what is on the front is bold, else it is
    told how far it is behind. Of suns and lamps there are settings_to_tell, of the others all."""
    kind_of = lambda s: "smoke" if "capsules" in s else "area" if "points" in s else "sun" if s["name"].endswith("sun") else "lamp"
    for kind in ("sun", "lamp", "smoke", "area"):
        some = [s for s in scenes if kind_of(s) == kind]
        if some:
            settings = cells_by_setting(some)
            keys = settings_to_tell(settings) if kind in ("sun", "lamp") else settings
            markdown(["technique", "knob", *(s["name"] for s in some)],
                     [[key[0], "" if key[2] == "-" else f"{key[1]} {key[2]}", *map(cell_text, settings[key])] for key in keys])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=pathlib.Path, default="build/release")
    parser.add_argument("--json", type=pathlib.Path, default="build/volumes.json", help="the page is beside it")
    parser.add_argument("--folder", default="build/volumes", help="of scenes, assets and figures")
    parser.add_argument("--plots", type=pathlib.Path, help="their folder (default that of --folder)")
    parser.add_argument("--scenes", default="../shared/scenes/real")
    parser.add_argument("--gl", default="osmesa")
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--resolution", type=int, default=1024)
    parser.add_argument("--capsules", type=int, default=4000, help="of smoke")
    parser.add_argument("--points", type=int, default=1000000, help="of casters, for area lights")
    parser.add_argument("--samples", type=int, default=32768, help="of each ray of their reference")
    parser.add_argument("--clock", default="wall", help="or processor")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--values", type=int, default=8, help="of each knob, so many")
    parser.add_argument("--only", default="", help="the scenes whose names begin so")
    args = parser.parse_args()
    plots = args.plots or pathlib.Path(args.folder)
    for folder in (pathlib.Path(args.folder), plots):
        folder.mkdir(parents=True, exist_ok=True)
    scenes = [measure(args, *scene) for measure, some in ((measured, SCENES), (measured_smoke, SMOKE), (measured_area, AREAS))
              for scene in some if scene[0].startswith(args.only)]
    scenes = list(filter(None, scenes))
    if not scenes:
        parser.exit(1, f"no scene is there whose name begins with '{args.only}'\n")
    machine = [s.pop("machine") for s in scenes]
    args.json.write_text(json.dumps({"machine": machine[0], "scenes": scenes}, indent=2) + "\n")
    subprocess.run([args.build / "vxs", "report", args.json, "-o", args.json.with_suffix(".html"), "--force"], check=True)
    for scene in scenes:
        plots_of(plots, scene)
    print()
    tables(scenes)


if __name__ == "__main__":
    main()
