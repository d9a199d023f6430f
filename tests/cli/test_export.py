# What vxs export writes is read back here, by readers of its own: words by section 13 of the spec, depth maps by the matrices beside
# them, in each engine's world space; and their answers are those of the command.
# SPDX-License-Identifier: GPL-3.0-or-later
import itertools
import json
import math
import random
import resource
import struct
import subprocess

import jsonschema
import pytest

import small_scene
from conftest import EVERY, ROOT
from png import read_grey16
from small_scene import NOON
from test_format import BlocksLight, Light

POINTS = 100000 if EVERY else 4000
GOLDEN = ROOT / "tests" / "golden"
# from an engine's world to glTF's
TO_GLTF = {"gltf": lambda x, y, z: (x, y, z), "godot": lambda x, y, z: (x, y, z), "unity": lambda x, y, z: (-x, y, z),
           "unreal": lambda x, y, z: (x / 100, z / 100, y / 100)}
FROM_GLTF = TO_GLTF | {"unreal": lambda x, y, z: (100 * x, 100 * z, 100 * y)}


@pytest.fixture(scope="module")
def lamps(vxs, tmp_path_factory):
    """A sun, a spot and a point light, as palette blocks."""
    at = tmp_path_factory.mktemp("export")
    small_scene.write(at / "a.gltf", lights=(("sun", "directional", NOON), ("spot", "spot", (0.3, -1, 0.2)), ("bulb", "point", NOON)))
    vxs("bake", at / "a.gltf", "-o", at / "a.vxs", "--resolution", 256)
    return at / "a.vxs"


class Exported:
    """The folder of an export: its description, and each light as a reader of the spec."""

    def __init__(self, folder):
        self.folder, self.root = folder, json.loads((folder / "shadows.json").read_text())
        jsonschema.validate(self.root, json.loads((ROOT / "docs" / "export.schema.json").read_text()))
        words = (folder / self.root["words"]).read_bytes()
        self.words = struct.unpack(f"<{len(words) // 4}I", words)
        assert len(self.words) == self.root["word_count"] and not any(self.words[-4:])
        self.constants = list(struct.iter_unpack("<17f7I", (folder / self.root["constants"]).read_bytes()))

    def light(self, n):
        entry, constants = self.root["lights"][n], self.constants[n]
        kind, flags, levels, first_word, coding = constants[17:22]
        assert entry["constants_offset_bytes"] == 96 * n and first_word == entry["first_word"] and 1 << levels == entry["resolution_px"]
        assert constants[:14] == struct.unpack("<14f", struct.pack("<14f", *entry["ls_from_ws"], entry["texel_m"], entry["voxel_m"]))
        light = object.__new__(BlocksLight if coding == 2 else Light)
        light.kind, light.levels, light.flags, light.matrix = kind, levels, flags, entry["ls_from_ws"]
        light.texel, light.voxel, light.near = entry["texel_m"], entry["voxel_m"], entry.get("near_m", 0)
        light.cos_outer = math.cos(math.radians(entry.get("cone_degrees", 180) / 2))
        light.range = entry.get("range_m", 0)
        light.words = self.words[first_word:first_word + entry["word_count"] + 4]
        return light

    def depths(self, n, map_number):
        """Rows of depths in [0, 1] of a depth map."""
        entry = self.root["lights"][n]["depth_maps"][map_number]
        side, data = entry["resolution_px"], (self.folder / entry["file"]).read_bytes()
        if entry["file"].endswith(".f32"):
            flat = struct.unpack(f"<{side * side}f", data)
        else:
            width, height, rows = read_grey16(data)
            assert (width, height) == (side, side)
            flat = [value / 65535 for row in rows for value in row]
        assert len(flat) == side * side
        return entry, [flat[side * y:side * (y + 1)] for y in range(side)]


def answers(vxs, path, points, *options):
    done = vxs("query", path, *options, input="".join("%r %r %r\n" % point for point in points))
    return [[None if word == "out" else float(word) for word in line.split()] for line in done.stdout.splitlines()]


def some_points(count, low=-3, high=3):
    dice = random.Random(5)
    return [tuple(dice.uniform(low, high) for _ in range(3)) for _ in range(count)]


@pytest.mark.parametrize("axes", list(TO_GLTF))
def test_words_and_constants_answer_like_the_command(vxs, lamps, tmp_path, axes):
    vxs("export", lamps, "-o", tmp_path, "--axes", axes)
    exported, points, kinds = Exported(tmp_path), some_points(POINTS // 4), set()
    assert exported.root["axes"] == axes and exported.root["unit_m"] == (0.01 if axes == "unreal" else 1)
    for point, wanted in zip(points, answers(vxs, lamps, points), strict=True):
        for n, lit in enumerate(wanted):
            assert exported.light(n).answer(FROM_GLTF[axes](*point), 1) == lit, (n, point)
            kinds.add((n, lit))
    assert kinds >= set(itertools.product(range(3), (0, 1)))


@pytest.mark.parametrize("name", ["sample.vxs", "lamps.vxs", "blocks.vxs"])
def test_words_of_older_files(vxs, tmp_path, name):
    vxs("export", GOLDEN / name, "-o", tmp_path)
    exported, points = Exported(tmp_path), some_points(500, -30, 30)
    for point, wanted in zip(points, answers(vxs, GOLDEN / name, points), strict=True):
        assert [exported.light(n).answer(point, 1) for n in range(len(wanted))] == wanted


def transformed(matrix, point):
    x, y, z, w = (sum(a * b for a, b in zip(matrix[4 * r:4 * r + 4], (*point, 1))) for r in range(4))
    return (x / w, y / w, z / w, w) if w > 0 else None


def first_voxel(entry, depth, side):
    """The voxel where shadow begins, of a depth in [0, 1]."""
    if entry["kind"] == "directional" or depth == 1:
        return round(depth * side)
    near, far = entry["near_m"], entry["far_m"]
    return round(math.log(far / (far - depth * (far - near))) / entry["voxel_m"])


@pytest.mark.parametrize("axes, form", [("gltf", "raw"), ("godot", "png"), ("unity", "raw"), ("unreal", "png")])
def test_depth_maps_answer_like_the_command(vxs, lamps, tmp_path, axes, form):
    """A texel's first voxel in shadow decides as vxs does. PNGs of lamps are compared a step of theirs beside it: 16 bits round."""
    vxs("export", lamps, "-o", tmp_path, "--axes", axes, "--depth", 256, "--format", form)
    exported, points, kinds, near_step = Exported(tmp_path), some_points(POINTS), set(), 0
    for n, light in enumerate(exported.root["lights"]):
        maps, side = [exported.depths(n, k) for k in range(light["maps"])], light["resolution_px"]
        exact = form == "raw" or light["kind"] == "directional"
        for point, wanted in zip(points, answers(vxs, lamps, points, "--light", light["name"]), strict=True):
            for entry, rows in maps:
                at = transformed(entry["matrices"]["uvd"], FROM_GLTF[axes](*point))
                if at is None or not (0 <= at[0] < 1 and 0 <= at[1] < 1 and 0 <= at[2] < 1) or wanted[0] is None:
                    continue
                depth = rows[int(at[1] * side)][int(at[0] * side)]
                voxel = math.log(at[3] / light["near_m"]) / light["voxel_m"] if "near_m" in light else at[2] * side
                lit = math.floor(voxel) < first_voxel(light, depth, side) if exact else at[2] < depth
                if not exact and abs(at[2] - depth) < 1 / 65535:
                    near_step += 1
                    continue
                assert lit == wanted[0], (light["name"], point)
                kinds.add((n, lit))
    assert kinds >= set(itertools.product(range(3), (False, True))) and near_step < POINTS / 20


def test_matrices_of_each_clip_space(vxs, lamps, tmp_path):
    """What a renderer of each kind makes of them: its own viewport leads to the same texel and depth."""
    vxs("export", lamps, "-o", tmp_path, "--depth", 64)
    for light in Exported(tmp_path).root["lights"]:
        for entry in light["depth_maps"]:
            matrices = entry["matrices"]
            for point in some_points(100):
                u, v, d, w = transformed(matrices["uvd"], point) or (0, 0, 0, 0)
                if w <= 0:
                    continue
                for name, back in (("vulkan", lambda x, y, z: ((x + 1) / 2, (y + 1) / 2, z)), ("d3d", lambda x, y, z: ((x + 1) / 2, (1 - y) / 2, z)),
                                   ("opengl", lambda x, y, z: ((x + 1) / 2, (y + 1) / 2, (z + 1) / 2))):
                    assert back(*transformed(matrices[name], point)[:3]) == pytest.approx((u, v, d), rel=1e-9, abs=1e-9), name


def test_coarser_depth_maps_have_the_texel_in_the_middle(vxs, lamps, tmp_path):
    vxs("export", lamps, "-o", tmp_path / "fine", "--depth", 256, "--format", "raw")
    vxs("export", lamps, "-o", tmp_path / "coarse", "--depth", 32, "--format", "raw")
    (_, fine), (entry, coarse) = Exported(tmp_path / "fine").depths(0, 0), Exported(tmp_path / "coarse").depths(0, 0)
    assert entry["resolution_px"] == 32 and coarse == [row[4::8] and tuple(row[4::8]) for row in fine[4::8]]


def test_what_cannot_be_exported(vxs, lamps, tmp_path):
    assert "power of two" in vxs("export", lamps, "-o", tmp_path, "--depth", 100, status=2).stderr
    assert "-o FOLDER" in vxs("export", lamps, status=2).stderr
    (tmp_path / "file").write_text("")
    assert "file" in vxs("export", lamps, "-o", tmp_path / "file", status=4).stderr
    (tmp_path / "broken.vxs").write_bytes(lamps.read_bytes()[:-1])
    assert "finding" in vxs("export", tmp_path / "broken.vxs", "-o", tmp_path / "new", status=3).stderr and not (tmp_path / "new").exists()
    taken = tmp_path / "words.bin"
    taken.write_bytes(lamps.read_bytes())
    vxs("export", taken, "-o", tmp_path, status=2)
    assert taken.read_bytes() == lamps.read_bytes()


def test_a_full_disk_leaves_what_was_there(vxs_path, lamps, tmp_path, vxs):
    vxs("export", lamps, "-o", tmp_path)
    before = (tmp_path / "words.bin").read_bytes()
    done = subprocess.run([vxs_path, "export", lamps, "-o", tmp_path], capture_output=True, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)))
    assert done.returncode == 4 and done.stderr.count("\n") == 1 and (tmp_path / "words.bin").read_bytes() == before
