#!/usr/bin/python3
# How long a bake by the add-on takes beside the same bake by the command alone: medians of runs that take turns, in each Blender that is
# there. The add-on's bake is all of it: the level is read from Blender, written, and baked.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import os
import pathlib
import statistics
import sys
import tempfile

from conftest import ADDON, HOSTS, Inside, ROOT, path_of


def told(what, timed):
    """Prints a line; returns how many times as long as vxs alone the add-on takes."""
    median = {name: statistics.median(seconds) for name, seconds in timed["seconds"].items()}
    ratio = median["add-on"] / median["vxs"]
    print(f"{what}, {timed['triangles']} triangles: add-on {median['add-on']:.2f} s, {median['level']:.2f} of them for the level; "
          f"vxs alone {median['vxs']:.2f} s: {ratio:.2f} times" + ("" if timed["is_same"] else "; the files differ"), flush=True)
    return ratio


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=1000000)
    parser.add_argument("--resolution", type=int, default=4096)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    vxs = str((ROOT / os.environ.get("VXS", "build/release/vxs")).resolve())
    worst = 0.0
    for host in HOSTS:
        program, why = path_of(host)
        if not program:
            print(f"{host}: skipped: {why}")
            continue
        with tempfile.TemporaryDirectory() as folder:
            inside = Inside(program, pathlib.Path(folder))
            inside("install", path=str(ADDON))
            inside("prefer", vxs=vxs)
            version = ".".join(map(str, inside("version")))
            for objects in (1, 10000):
                timed = inside("time_bake", triangles=options.triangles, objects=objects, resolution=options.resolution, runs=options.runs,
                               vxs=vxs, folder=folder)
                worst = max(worst, told(f"Blender {version}, {objects} objects, {options.resolution} texels", timed))
            inside.close()
    return worst >= 3


if __name__ == "__main__":
    sys.exit(main())
