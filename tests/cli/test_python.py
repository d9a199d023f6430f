# The module vxs for Python, runtime/python: answers are those of the command, bad bytes are errors, and the listings of docs/python.md run.
# SPDX-License-Identifier: GPL-3.0-or-later
import ctypes
import json
import math
import os
import random
import re
import subprocess
import sys

import pytest

import small_scene
from conftest import EVERY, ROOT
from small_scene import NOON
from test_docs import listings

np = pytest.importorskip("numpy", reason="no numpy: package python3-numpy")
MODULE = ROOT / "runtime" / "python"
COUNT = 20000 if EVERY else 2000


@pytest.fixture(scope="module")
def libraries(vxs_path):
    folder = vxs_path.parent
    if folder.name in ("asan", "tsan") or not (folder / "libvxs_bake.so").exists():
        pytest.skip("no libvxs_bake.so, or one that needs a sanitizer")
    return {"VXS_LIBRARY": str(folder / "libvxs.so"), "VXS_BAKE_LIBRARY": str(folder / "libvxs_bake.so")}


@pytest.fixture(scope="module")
def module(libraries):
    """The module, in this process."""
    os.environ.update(libraries)
    sys.path.insert(0, str(MODULE))
    import vxs as module
    yield module
    sys.path.remove(str(MODULE))


@pytest.fixture(scope="module")
def folder(vxs, tmp_path_factory):
    at = tmp_path_factory.mktemp("python")
    small_scene.write(at / "a.gltf", lights=(("sun", "directional", NOON), ("spot", "spot", (0.3, -1, 0.2)), ("bulb", "point", NOON)))
    vxs("bake", at / "a.gltf", "-o", at / "a.vxs", "--resolution", 256, "--json", at / "bake.json")
    return at


def some_points(count=COUNT, seed=3):
    """Points with normals in and about the scene, float64, and some that no float holds."""
    dice = np.random.default_rng(seed)
    return dice.uniform(-3, 3, (count, 3)), dice.normal(size=(count, 3))


def answers(vxs, path, points, normals, *options):
    lines = "".join(" ".join(map(repr, map(float, row))) + "\n" for row in (np.hstack([points, normals]) if normals is not None else points))
    rows = [[-1 if word == "out" else float(word) for word in line.split()] for line in vxs("query", path, *options, input=lines).stdout.splitlines()]
    return np.array(rows).T


@pytest.mark.parametrize("width, option", [(1, "--filter"), (9, "--filter"), (4, "--smooth"), (9, "--smooth")])
@pytest.mark.parametrize("with_normals", [False, True])
def test_lookups_answer_like_the_command(vxs, module, folder, width, option, with_normals):
    points, normals = some_points()
    normals = normals if with_normals else None
    chosen = module.box(width) if option == "--filter" else module.smooth(width)
    wanted = answers(vxs, folder / "a.vxs", points, normals, option, width)
    with module.open(folder / "a.vxs") as level:
        lit = level.lookup(points, normals, chosen)
        assert lit.dtype == np.float32 and lit.shape == (3, COUNT) and np.abs(lit - wanted).max() < 1e-6 and {-1, 0, 1} <= set(lit.ravel())
        for n, light in enumerate(level):
            assert (light.lookup(points.reshape(-1, 20, 3), normals if normals is None else normals.reshape(-1, 20, 3), chosen).ravel() == lit[n]).all()
        floats = points.astype(np.float32)
        assert (level["sun"].lookup(floats, normals, chosen) == level["sun"].lookup(floats.astype(np.float64), normals, chosen)).all()


def test_depth_maps_and_words_are_those_of_export(vxs, module, folder, tmp_path):
    vxs("export", folder / "a.vxs", "-o", tmp_path, "--depth", 128, "--format", "raw")
    listed, first = json.loads((tmp_path / "shadows.json").read_text()), 0
    words, constants = np.fromfile(tmp_path / "words.bin", np.uint32), (tmp_path / "lights.bin").read_bytes()
    with module.open(folder / "a.vxs") as level:
        assert [light.name for light in level] == ["sun", "spot", "bulb"] and [light.kind for light in level] == ["directional", "spot", "point"]
        for n, (light, entry) in enumerate(zip(level, listed["lights"])):
            assert (light.words[:-4] == words[first:first + entry["word_count"]]).all()
            assert light.constants(first_word=first) == constants[96 * n:96 * n + 96] and list(light.matrix.ravel()) == entry["ls_from_ws"]
            assert light.map_count == entry["maps"] and light.resolution == 256
            first += entry["word_count"]
        exported = np.fromfile(tmp_path / "depth-0-0.f32", np.float32).reshape(128, 128)
        assert (level[0].depth_map(128) == exported).all() and (level[0].depth_map(128, voxels=True) == exported * 256).all()
        assert level[2].depth_map(map=5).shape == (256, 256) and len({level[2].depth_map(map=n).tobytes() for n in range(6)}) > 1


def test_intervals_have_the_state_of_their_points(module, folder):
    """Their middles are looked up; they follow one another from t_begin to t_end."""
    dice, states = random.Random(2), set()
    with module.open(folder / "a.vxs") as level:
        for light in level:
            for _ in range(COUNT // 40):
                origin, direction = [[dice.uniform(-3, 3) for _ in range(3)] for _ in range(2)]
                found = light.lit_intervals(origin, direction, 0, 2)
                assert found["t_begin"][0] == 0 and found["t_end"][-1] == 2 and (found["t_begin"][1:] == found["t_end"][:-1]).all()
                wide = found[found["t_end"] - found["t_begin"] > 1e-6]
                middles = np.array(origin) + (wide["t_begin"] + wide["t_end"])[:, None] / 2 * np.array(direction)
                assert (light.lookup(middles) == np.array([1, 0, -1])[wide["state"]]).all()
                states |= set(found["state"])
            place = np.array([[3.5, 200.5, 40.5]])
            assert light.lookup(light.point(place))[0] in (-1, 0, 1)
    assert states == {0, 1, 2}


def test_bakes_are_those_of_the_command(module, folder, tmp_path):
    seen = []
    made = module.bake(folder / "a.gltf", resolution=256, output=str(tmp_path / "out.vxs"), progress=lambda share, doing: seen.append((share, doing)))
    assert made == (folder / "a.vxs").read_bytes() == (tmp_path / "out.vxs").read_bytes() and seen


def cube(low, side):
    corners = np.array([[x, y, z] for x in (0, side) for y in (0, side) for z in (0, side)], float) + low
    return corners, [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def test_a_bake_from_arrays(module):
    """A cube a metre above the ground, far from the origin, where floats have no millimetres: its shadow under a sun at noon is its square."""
    at = np.array([1e5, 0, -2e5])
    ground = np.array([[-5, 0, -5], [-5, 0, 5], [5, 0, 5], [5, 0, -5]]) + at
    with module.Scene([cube(at + [0, 1, 0], 1), (ground, [(0, 1, 2), (0, 2, 3)])]) as scene:
        for way in ((0, -1, 0), (-0.5, -1, 0)):
            with module.open(scene.bake({"noon": way}, resolution=1024)) as level:
                grid = np.stack(np.meshgrid(np.linspace(-3, 3, 61), [0.0], np.linspace(-3, 3, 61)), -1).reshape(-1, 3)
                lit = level["noon"].lookup(grid + at, np.broadcast_to([0.0, 1, 0], grid.shape))
                low, high = (way[0] * 2 if way[0] else 0, 1 + (way[0] if way[0] else 0))
                inside = (grid[:, 0] > low) & (grid[:, 0] < high) & (grid[:, 2] > 0) & (grid[:, 2] < 1)
                edge = np.minimum(np.minimum(abs(grid[:, 0] - low), abs(grid[:, 0] - high)), np.minimum(abs(grid[:, 2]), abs(grid[:, 2] - 1))) < 0.03
                assert (lit[~edge] == ~inside[~edge]).all() and inside.sum() > 50


def test_what_is_wrong_with_arguments(module, folder):
    with module.open(folder / "a.vxs") as level:
        sun = level["sun"]
        for wrong in (lambda: sun.lookup([1, 2]), lambda: sun.lookup([[1, 2, 3]], [[1, 2, 3]] * 2), lambda: sun.depth_map(100), lambda: sun.depth_map(map=1),
                      lambda: sun.lit_intervals([0, 0, math.nan], [1, 0, 0]), lambda: sun.lookup(3.0)):
            with pytest.raises(ValueError):
                wrong()
        assert sun.lookup(np.empty((0, 3))).shape == (0,) and list(sun.lookup([[math.nan, 0, 0], [math.inf, 0, 0]])) == [-1, -1]
        with pytest.raises(KeyError):
            level["moon"]
        with pytest.raises(IndexError):
            level[3]
        assert level[-1].name == "bulb"
    level.close()
    for closed in (lambda: sun.lookup([[0, 0, 0]]), lambda: len(level), lambda: sun.name):
        with pytest.raises(ValueError, match="closed"):
            closed()
    with pytest.raises(FileNotFoundError):
        module.open(folder / "missing.vxs")
    corners, triangles = cube((0, 0, 0), 1)
    for meshes in ((corners, [(0, 1, 8)]), (corners, [(0, 1)]), corners[:4], (corners * math.nan, triangles), np.empty((0, 3))):
        with pytest.raises(ValueError):
            module.bake(meshes, {"sun": (0, -1, 0)})
    with pytest.raises(module.VxsError, match="direction"):
        module.bake((corners, triangles), {"sun": (0, 0, 0)})
    with pytest.raises(module.VxsError):
        module.bake((corners, triangles))
    with pytest.raises(module.Cancelled):
        module.bake((corners, triangles), {"sun": (0, -1, 0)}, progress=lambda share, doing: True)


def test_damaged_files_are_errors_with_the_finding_of_validate(vxs, module, folder, tmp_path):
    data, dice, numbers = (folder / "a.vxs").read_bytes(), random.Random(4), set()
    for _ in range(200 if EVERY else 40):
        changed = bytearray(data[:dice.choice([len(data), dice.randrange(len(data))])])
        if len(changed):
            changed[dice.randrange(min(len(changed), dice.choice([64, 400, len(data)])))] ^= 1 << dice.randrange(8)
        (tmp_path / "b.vxs").write_bytes(changed)
        vxs("validate", tmp_path / "b.vxs", "--json", tmp_path / "b.json", status=1)
        found = json.loads((tmp_path / "b.json").read_text())["findings"][0]["number"]
        with pytest.raises(module.VxsError) as by_bytes:
            module.open(bytes(changed))
        with pytest.raises(module.VxsError) as by_path:
            module.open(tmp_path / "b.vxs")
        numbers.add(found)
        assert by_bytes.value.result == by_path.value.result and by_bytes.value.finding == by_path.value.finding == found
    assert len(numbers) > 3


def test_structs_are_those_of_the_headers(module, tmp_path):
    """Sizes and offsets, by a compiler."""
    from vxs import _library, baker
    pairs = [("vxs_light", _library.LightRecord), ("vxs_part", _library.Part), ("vxs_baked_light", _library.BakedLight), ("vxs_filter", _library.Filter),
             ("vxs_light_constants", _library.Constants), ("vxs_read_desc", _library.ReadDesc), ("vxs_vectors", _library.Vectors), ("vxs_batch", _library.Batch),
             ("vxs_depth_map_desc", _library.DepthMapDesc), ("vxs_ray", _library.Ray), ("vxs_lit_walk", _library.Walk), ("vxs_bake_mesh", baker._Mesh),
             ("vxs_bake_light", baker._BakeLight), ("vxs_bake_arrays", baker._Arrays), ("vxs_bake_sun", baker._Sun), ("vxs_bake_progress", baker._Progress),
             ("vxs_bake_bytes", baker._Bytes), ("vxs_bake_options", baker._Options)]
    lines, wanted = [], []
    for name, struct in pairs:
        lines.append(f'printf("%zu\\n", sizeof({name}));')
        wanted.append(ctypes.sizeof(struct))
        for field in [] if struct is _library.Constants else struct._fields_:
            lines.append(f'printf("%zu\\n", offsetof({name}, {field[0]}));')
            wanted.append(getattr(struct, field[0]).offset)
    (tmp_path / "a.c").write_text("#include <stdio.h>\n#include <vxs_query.h>\n#include <vxs_bake.h>\nint main(void) {\n" + "\n".join(lines) + "\nreturn 0; }\n")
    subprocess.run(["cc", f"-I{ROOT / 'runtime'}", f"-I{ROOT / 'formats'}", f"-I{ROOT / 'baker'}", tmp_path / "a.c", "-o", tmp_path / "a"], check=True)
    assert list(map(int, subprocess.run([tmp_path / "a"], capture_output=True, text=True).stdout.split())) == wanted


def test_listings(vxs, module, libraries, folder, tmp_path):
    vxs("bake", folder / "a.gltf", "-o", tmp_path / "level.vxs", "--resolution", 1024, "--light", "sun")
    said = []
    for listing in listings("python", ROOT / "docs" / "python.md"):
        done = subprocess.run([sys.executable, "-c", listing], cwd=tmp_path, capture_output=True, text=True, env=os.environ | libraries | {"PYTHONPATH": str(MODULE)})
        assert done.returncode == 0, done.stderr
        said.append(done.stdout)
    low, high, mean = map(float, re.findall(r"\d+\.\d+", said[1]))
    assert 0 <= low < mean < high == 11.75  # under the tower, in its shadow for a part of the day, never
    assert (tmp_path / "mask.pgm").stat().st_size == 15 + 512 * 512


def test_lint():
    if subprocess.run([sys.executable, "-m", "flake8", "--version"], capture_output=True).returncode:
        pytest.skip("no flake8: package python3-flake8")
    done = subprocess.run([sys.executable, "-m", "flake8", "--max-line-length", "160", MODULE], capture_output=True, text=True)
    assert done.stdout == ""


@pytest.mark.long
def test_wheel(folder, tmp_path):
    """Installed into an environment of its own, without anything of this system but numpy."""
    made = subprocess.run(["make", "-C", ROOT, "packages=skip", "wheel"], capture_output=True, text=True)
    if made.returncode and "pip" in made.stderr:
        pytest.skip("no PyPI")
    assert made.returncode == 0, made.stderr
    (wheel,) = (ROOT / "build" / "wheel").glob("*.whl")
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", tmp_path / "site", wheel], check=True)
    text = f"import vxs; print(vxs.__file__, vxs.bake({str(folder / 'a.gltf')!r}, resolution=256) == open({str(folder / 'a.vxs')!r}, 'rb').read())"
    env = {name: value for name, value in os.environ.items() if not name.startswith("VXS")} | {"PYTHONPATH": str(tmp_path / "site")}
    done = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True, env=env)
    assert done.stdout.split() == [str(tmp_path / "site" / "vxs" / "__init__.py"), "True"], done.stderr
