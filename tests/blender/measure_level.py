# Bakes one level with vxs and with Cycles, and holds both against rays. Runs inside Blender, for beside_cycles.py.
#
#   blender -b --factory-startup --python measure_level.py -- REQUEST.json       or  python measure_level.py -- REQUEST.json
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import re
import subprocess
import sys
import time

import bpy
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import levels  # noqa: E402  bpy comes first: it makes bmesh known
import lightmap  # noqa: E402
import pictures  # noqa: E402
import with_addon  # noqa: E402

QUALITIES = 100, 80  # of WebP
WHITE, DIM = 99.5, 0.01  # percentile of light that lightmaps store as white; places with less than this share of it do not count


def peak_bytes(reset=False):
    """The most memory this process held since the last reset; with reset, what it holds now."""
    if reset:
        pathlib.Path("/proc/self/clear_refs").write_text("5")
    return int(re.search(r"^VmHWM:\s*(\d+) kB", pathlib.Path("/proc/self/status").read_text(), re.MULTILINE)[1]) * 1024


def processor_seconds():
    """Of this process and those that it started, on all threads."""
    return sum(os.times()[:4])


class Vxs:
    """Bakes through the add-on, and answers for places."""

    def __init__(self, request):
        self.path, self.file = request["vxs"], request["folder"] + "/level.vxs"
        addon = with_addon.AddonRequests()
        addon.install(request["addon"])
        addon.prefer(vxs=self.path)

    def bake(self, resolution):
        """Returns seconds, those of processors, and the most bytes that vxs held."""
        start, busy = time.perf_counter(), processor_seconds()
        if bpy.ops.vxs.bake(filepath=self.file, resolution=resolution, force=True) != {"FINISHED"}:
            raise RuntimeError(bpy.context.window_manager.vxs.result)
        seconds, busy = time.perf_counter() - start, processor_seconds() - busy
        size, unit = re.search(r"([\d.]+) (\wiB) of memory", bpy.context.window_manager.vxs.result).groups()
        return seconds, busy, float(size) * {"KiB": 2**10, "MiB": 2**20, "GiB": 2**30}[unit]

    def run(self, *arguments, lines=None):
        return subprocess.run([self.path, *arguments], input=lines, capture_output=True, text=True, check=True).stdout

    def texels(self):
        """Sides of texels in metres, those of punctual lights at one metre, by light."""
        return {light["name"]: light["texel_m"] for light in json.loads(self.run("info", self.file, "--json", "-"))["lights"]}

    def share(self, places, names):
        """[places, lamps]; 1 outside of maps, as in renderers."""
        asked = [word for name in names for word in ("--light", name)]
        rows = [line.split() for line in self.run("query", self.file, "--smooth", "2", *asked, lines=places.lines()).splitlines()]
        return np.array([[1.0 if word == "out" else float(word) for word in row] for row in rows])


class Receivers:
    """Places, and the light that reaches them: of each lamp without shadows, and the true share of their sum."""

    def __init__(self, level, places, white=None):
        light = level.irradiance(places)
        self.white = white or float(np.percentile(light.sum(axis=1), WHITE))
        bright = light.sum(axis=1) > DIM * self.white
        self.places, self.light = places.pick(bright), light[bright]
        self.lit = np.nan_to_num(level.light(self.places))
        self.truth = self.sum_of(self.lit)

    def sum_of(self, shares):
        return (shares * self.light).sum(axis=1) / self.light.sum(axis=1)

    def error(self, share):
        return float(np.abs(share - self.truth).mean())


class Comparison:
    def __init__(self, request):
        self.request, self.vxs = request, Vxs(request)
        levels.open_level(request["scene"], request.get("suns", ()), request.get("lamps", ()))
        runs = [self.vxs.bake(request["resolution"]) for _ in range(request["runs"])]
        seconds, busy, peak = np.median(runs, axis=0).tolist()
        self.thing = levels.join()
        self.level = levels.Level(self.thing)
        self.names = [lamp.name for lamp in self.level.lamps]
        self.surfaces = Receivers(self.level, self.level.on_surfaces(request["points"], seed=1))
        self.air = Receivers(self.level, self.level.in_air(request["points"] // 4, seed=2), self.surfaces.white)
        self.vxs_row = {"seconds": seconds, "processor_seconds": busy, "peak_bytes": int(peak),
                        "bytes": pathlib.Path(self.vxs.file).stat().st_size, "error": self.surfaces.error(self.vxs_share(self.surfaces)),
                        "error_in_air": self.air.error(self.vxs_share(self.air))}
        texels = self.vxs.texels()
        far = np.where(self.surfaces.light > 0, self.level.distances(self.surfaces.places), np.nan)
        self.texel = float(np.nanmedian(far * np.array([texels[name] for name in self.names])))
        self.map = lightmap.Lightmap(self.thing, request["folder"], self.surfaces.white)

    def vxs_share(self, receivers):
        return receivers.sum_of(self.vxs.share(receivers.places, self.names))

    def all(self):
        rows = {"equal_resolution": self.at_density()}
        rows["equal_bytes"] = self.at_bytes(rows["equal_resolution"], self.vxs_row["bytes"])
        if self.request.get("picture"):
            pictures.write(self)
        asked = {key: self.request[key] for key in ("name", "resolution", "samples")}
        return {**asked, "triangles": len(self.level.areas), "lamps": len(self.names), "texel_m": self.texel,
                "places": len(self.surfaces.truth), "places_in_air": len(self.air.truth), "lit": float(self.surfaces.truth.mean()),
                "vxs": self.vxs_row, **rows}

    def at_density(self):
        """A lightmap whose texels are as large as those of vxs, in the middle."""
        side, area = 2048, float(self.level.areas.sum())
        for _ in range(2):
            self.map.prepare(side)
            side = int(np.clip(np.sqrt(area / self.map.coverage()) / self.texel, *lightmap.SIDES))
        return self.measure(side, QUALITIES[0])

    def at_bytes(self, known, wanted):
        """A lightmap that takes so many bytes, in the quality that errs least."""
        best = None
        for quality in QUALITIES:
            def trial(side):
                self.map.prepare(side)
                self.map.bake(self.request["samples"])
                return self.map.store(quality)
            side = lightmap.side_of_bytes(trial, wanted, (known["side"], known["bytes"]))
            row = self.measure(side, quality)
            best = row if best is None or row["error"] < best["error"] else best
        if best["quality"] != QUALITIES[-1]:  # pictures show the best
            self.measure(best["side"], best["quality"])
        return best

    def measure(self, side, quality):
        held, busy = peak_bytes(reset=True), [processor_seconds()]
        prepared = self.map.prepare(side)
        busy.append(processor_seconds())
        baked = self.map.bake(self.request["samples"])
        busy.append(processor_seconds())
        peak = max(0, peak_bytes() - held)  # the kernel's counts are late by some pages
        size = self.map.store(quality)
        share = self.map.light(self.surfaces.places) / self.surfaces.light.sum(axis=1)
        return {"side": side, "quality": quality, "prepare_seconds": prepared, "seconds": baked,
                "prepare_processor_seconds": busy[1] - busy[0], "processor_seconds": busy[2] - busy[1], "bytes": size, "peak_bytes": peak,
                "error": self.surfaces.error(share)}


def main():
    request = json.loads(pathlib.Path(sys.argv[-1]).read_text())
    row = Comparison(request).all()
    pathlib.Path(request["out"]).write_text(json.dumps({"blender": bpy.app.version_string, **row}))


main()
