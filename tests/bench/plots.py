# Draw the plots of docs/measurements.md with gnuplot, from what `make bench` measured (docs/bench.schema.json):
#     python3 tests/bench/plots.py build/bench.json docs/plots
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import pathlib
import subprocess

COLOURS = ["#3d7ab8", "#d0702a", "#3c9260", "#a9549c", "#c2485a", "#2f979c", "#94742f", "#7b7f8c",
           "#9a8fb0", "#66b37e", "#e0b050", "#4c126b"]
TICS = ", ".join(f"{digit}e{power}" for power in range(-4, 4) for digit in (1, 2, 5))  # of logarithmic axes
HEAD = """set terminal svg size 480,{height} noenhanced font 'sans-serif,13' background rgb 'white'
set encoding utf8
set border 3
set tics nomirror out scale 0.5
set grid lt 1 lw 0.6 lc rgb '#dcd9cf'
set key bmargin left Left reverse horizontal samplen 1.6 maxcols {columns}
"""
SMALL_PART = 0.02  # of every bar: joined into "others"


def draw(path, names, script):
    """names: of the key below the axis, which has as many columns as gnuplot finds room for, at most 3."""
    columns = max(1, min(3, 360 // (45 + 8 * max(map(len, names)))))
    rows = -(-len(names) // columns)
    head = HEAD.format(columns=columns, height=max(380, 300 + 20 * rows))
    head += f"set bmargin {3.7 + 1.1 * rows}\nset output {quoted(path)}\n"
    subprocess.run(["gnuplot", "-d", "-"], input=head + script, text=True, check=True)


def quoted(text):
    return "'" + str(text).replace("'", "''") + "'"


def block(name, rows):
    return f"${name} << EOD\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows) + "EOD\n"


def wrong_share(cell):
    return next(e["wrong_share"] for e in cell["errors"] if (e["points"], e["filter_px"]) == ("surface", 1))


def errors(path, cells, axis, figure):
    """Wrong answers on surfaces, a line for each scene. axis: commands for the x axis. figure(cell): median, least, greatest."""
    scenes = list(dict.fromkeys(c["scene"] for c in cells))
    row = lambda c: (*figure(c), 100 * wrong_share(c), c["options"]["resolution_px"])
    script = "".join(block(f"s{n}", [row(c) for c in cells if c["scene"] == scene]) for n, scene in enumerate(scenes))
    script += f"set logscale y\nset ylabel 'wrong answers'\nset format y '%g %%'\nset ytics ({TICS})\n{axis}\n" \
        "set offsets 0, graph 0.12, 0, 0\n"
    lines = []
    for n, scene in enumerate(scenes):
        colour = f"lc rgb '{COLOURS[n % len(COLOURS)]}'"
        lines += [f"$s{n} using 1:4 with linespoints pt 7 ps 0.6 lw 1.4 {colour} title {quoted(scene)}",
                  f"$s{n} using 2:4:($3-$2):(0) with vectors nohead {colour} notitle",
                  f"$s{n} using 1:4:5 with labels left offset 0.7, 0.5 font ',11' notitle"]
    draw(path, scenes, script + "plot " + ", ".join(lines) + "\n")


def bars(path, cells, label, unit, total, parts_of):
    """A bar for each resolution. parts_of(cell): name and size of what it is stacked of."""
    names = list(dict.fromkeys(name for c in cells for name, _ in parts_of(c)))
    large = [n for n in names if any(dict(parts_of(c)).get(n, 0) >= SMALL_PART * total(c) for c in cells)]
    rows = [[c["options"]["resolution_px"], *(dict(parts_of(c)).get(n, 0) for n in large)] for c in cells]
    for cell, row in zip(cells, rows):
        row.append(max(0, total(cell) - sum(row[1:])))
    script = block("bars", rows) + "set style data histograms\nset style histogram rowstacked\nset style fill solid 1 noborder\n" \
        f"set boxwidth 0.8\nset xlabel 'texels a side'\nset ylabel '{label}'\nset format y '%g {unit}'\nset yrange [0:*]\n"
    colours = [*(COLOURS[n % len(COLOURS)] for n in range(len(large))), "#b9b6ab"]
    parts = [f"$bars using {n + 2}:xtic(1) lc rgb '{colours[n]}' title {quoted(name)}" for n, name in enumerate([*large, "others"])]
    draw(path, parts, script + "plot " + ", ".join(parts) + "\n")


def parts(cell):
    """Levels of a DAG, the finest first, or parts of palette blocks, with what they take."""
    name = lambda p: p["kind"] if "kind" in p else f"{p['side_voxels']}³" if p["side_voxels"] else "masks"
    return [(name(p), p["stored_bytes"] / 1024) for p in (cell["size"].get("parts") or cell["size"]["levels"][::-1])]


def main():
    arguments = argparse.ArgumentParser(description="Draw the plots of docs/measurements.md.")
    arguments.add_argument("bench", type=pathlib.Path, help="what make bench measured")
    arguments.add_argument("folder", type=pathlib.Path, help="where the drawings go, as SVG")
    options = arguments.parse_args()
    cells = json.loads(options.bench.read_text())["cells"]
    city = [c for c in cells if c["scene"] == "city.glb"]
    options.folder.mkdir(parents=True, exist_ok=True)

    seconds = lambda c: tuple(c["bake"]["total_seconds"][key] for key in ("median", "min", "max"))
    kib = lambda c: c["size"]["file_bytes"] / 1024
    errors(options.folder / "error-bake-surface.svg", cells,
           f"set logscale x\nset xlabel 'bake time'\nset format x '%g s'\nset xtics ({TICS})", seconds)
    errors(options.folder / "error-bytes-surface.svg", cells,
           "set logscale x 2\nset xlabel 'size of the file'\nset format x '%g KiB'\nset xtics (4, 16, 64, 256, 1024, 4096, 16384)",
           lambda c: 3 * (kib(c),))
    bars(options.folder / "stages-city.svg", city, "bake time by stage", "s", lambda c: seconds(c)[0],
         lambda c: [(s["name"], s["seconds"]["median"]) for s in c["bake"]["stages"]])
    bars(options.folder / "bytes-city.svg", city, "the file by part", "KiB", kib, parts)


if __name__ == "__main__":
    main()
