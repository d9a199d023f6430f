# Measurements as text: tables in Markdown, figures with their units; and the scene that all of them share.
# VXS_SCENES: the shared scenes; without them nothing is measured in Sponza.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import pathlib

SCENES = pathlib.Path(os.environ.get("VXS_SCENES", pathlib.Path(__file__).resolve().parents[3] / "shared" / "scenes"))
SPONZA = SCENES / "real" / "sponza.glb"
SPONZA_SUN = "-0.4,-1,-0.2"


def milliseconds(seconds):
    """'' when there is none."""
    return "" if seconds is None else f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def megabytes(value):
    return f"{value:.3g} MB"


def ratio(a, b):
    return f"{a / b:.2f}" if b else ""


def machine_line(result):
    m = result["machine"]
    return (f"vxs {result['vxs']} on {m['processor']}, {m['cores']} cores, {m['memory_bytes'] / 2**30:.0f} GiB, {m['system']}; "
            f"medians of {result['runs']} runs")


def markdown(head, rows):
    """A table in columns, for readers of the plain text."""
    widths = [max(len(row[n]) for row in [head, *rows]) for n in range(len(head))]
    line = lambda cells: "| " + " | ".join(c.rjust(w) if n else c.ljust(w) for n, (c, w) in enumerate(zip(cells, widths))) + " |"
    rule = "|" + "|".join("-" * (w + 2) if not n else "-" * (w + 1) + ":" for n, w in enumerate(widths)) + "|"
    print("\n".join([line(head), rule, *map(line, rows)]) + "\n")
