# Columns straight from triangles, at length: every stress scene, what rendered maps have otherwise, and the largest maps there are.
# make check-sparse runs all three, part=NAME one of them:
#     stress   each stress scene from both sources and in both codings at 512, every voxel; straight from triangles 157 tiles at
#     16384, and, as
#              palette blocks alone, at 262144, or less where sheets fill the maps, of which every tile needs a mask
#     sources  where the two sources differ on all real scenes at 512 to 4096, under two suns, and why (tests/bench/sources.c)
#     columns  a city of 800 000 triangles, Sponza and a landscape of 2 million at 262144: 10 000 random tiles, all tiles around
#     1000
#              silhouettes, and 32 lookups through the runtime in each of their texels, at least 20 million for each scene
# VXS_SCENES: the shared scenes; what needs them is left out without them.
# SPDX-License-Identifier: GPL-3.0-or-later
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
REAL = pathlib.Path(os.environ.get("VXS_SCENES", ROOT.parent / "shared" / "scenes")) / "real"
NO_SCENE = ("nan-vertices", "infinite-vertices", "empty-scene")
FINEST = {"wall-along-light": 65536, "inside-out-room": 16384, "light-in-wall": 16384}
CITY = ("city", "--triangles", 800000, "--blocks", 22)
LANDSCAPE = ("landscape", "--triangles", 2000000)


class Proof:
    def __init__(self, build, folder):
        self.vxs, self.exact, self.sources = build / "vxs", build / "tests/exact/exact", build / "tests/bench/sources"
        self.folder, self.failed = folder, 0

    def scene(self, *words):
        path = self.folder / f"{'-'.join(map(str, words))}.glb"
        subprocess.run([self.vxs, "scene", *map(str, words), "-o", path, "--quiet"], check=True)
        return path

    def ask(self, name, scene, *options):
        """One run of exact, and a line about it."""
        done = subprocess.run([self.exact, scene, *map(str, options)], stdout=subprocess.PIPE, text=True)
        counts = [json.loads(line) for line in done.stdout.splitlines()]
        wrong = sum(c["wrong_lit"] + c["wrong_shadow"] + c["misread"] + c["insane_depths"] for c in counts)
        self.failed += done.returncode != 0
        print(f"{name:24} {counts[0]['resolution'] if counts else '':>6} {len(counts)} files {sum(c['columns'] for c in counts):>12} columns "
              f"{sum(c['voxels'] for c in counts):>16} voxels {sum(c['lookups'] for c in counts):>11} lookups {wrong} wrong"
              + ("" if done.returncode == 0 else f", exit status {done.returncode}"), flush=True)

    def stress(self):
        listed = subprocess.run([self.vxs, "scene", "stress", "--case", "list"], check=True, stdout=subprocess.PIPE, text=True).stdout
        codings = ("--coding", "dag", "--coding", "blocks")
        for case in [line.split()[0] for line in listed.splitlines()]:
            if case in NO_SCENE:
                continue
            scene, sun = self.scene("stress", "--case", case), ("--sun", "1,-1,0") if case == "no-light" else ()
            self.ask(case, scene, *sun, "--maps", "gl", "--maps", "sparse", *codings)
            some = (*sun, "--maps", "sparse", "--columns", 10000)
            self.ask(case, scene, *some, *codings, "--resolution", 16384)
            self.ask(case, scene, *some, "--coding", "blocks", "--resolution", FINEST.get(case, 262144))

    def differences(self):
        scenes = sorted(REAL.glob("*.glb"))
        if not scenes:
            print(f"no scenes at {REAL}: the sources are not compared; set VXS_SCENES")
            return
        sides = [word for side in (512, 1024, 2048, 4096) for word in ("--resolution", side)]
        self.failed += subprocess.run([self.sources, *scenes, *map(str, sides), "--list", "5"]).returncode != 0

    def columns(self):
        options = ("--maps", "sparse", "--coding", "blocks", "--resolution", 262144, "--columns", 640000, "--silhouettes", 1000)
        self.ask("city", self.scene(*CITY), *options)
        self.ask("landscape", self.scene(*LANDSCAPE), *options)
        if (REAL / "sponza.glb").is_file():
            self.ask("sponza", REAL / "sponza.glb", "--sun", "-0.4,-1,-0.2", *options)
        else:
            print(f"no {REAL / 'sponza.glb'}: it is left out; set VXS_SCENES")


def main():
    arguments = argparse.ArgumentParser(description="Check columns straight from triangles at length.")
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release", help="the build tree")
    arguments.add_argument("--part", choices=("stress", "sources", "columns"), help="one alone")
    options = arguments.parse_args()
    with tempfile.TemporaryDirectory(prefix="vxs-sparse-") as folder:
        proof = Proof(options.build.resolve(), pathlib.Path(folder))
        for name, part in (("stress", proof.stress), ("sources", proof.differences), ("columns", proof.columns)):
            if options.part in (None, name):
                part()
    print("all of it is right" if not proof.failed else f"{proof.failed} runs found something wrong")
    return proof.failed != 0


sys.exit(main())
