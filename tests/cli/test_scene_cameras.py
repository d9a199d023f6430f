# vxs render --camera: what a camera of the file sees, against areas that are known, against --eye, and on an orbit.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math

import jsonschema
import pytest

from conftest import ROOT
from named_scene import cube, light, node, plane, write
from png import read_png
from small_scene import box, turned

DOWN = (0, -1, 0)
FINE = ("--width", 256, "--height", 256)  # for areas that are counted in pixels


def perspective(yfov, **rest):
    return {"type": "perspective", "perspective": {"yfov": yfov, "znear": 0.01, **rest}}


def orthographic(xmag, ymag, znear=0.01):
    return {"type": "orthographic", "orthographic": {"xmag": xmag, "ymag": ymag, "znear": znear, "zfar": 100}}


@pytest.fixture
def view(vxs, tmp_path):
    """view(nodes, cameras, name, *options): the report of a picture of 64 x 64 pixels, and the picture.
    cameras: (name of the node, camera, place, direction or a quaternion)"""

    def run(nodes, cameras, name, *options, size=("--width", 64, "--height", 64)):
        path = write(tmp_path / "scene.gltf", nodes, [light("sun", "directional", direction=(0.2, -1, 0.3))])
        gltf = json.loads(path.read_text())
        gltf["cameras"] = [camera for _, camera, _, _ in cameras]
        for n, (camera_name, _, at, turn) in enumerate(cameras):
            gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]))
            gltf["nodes"].append({**({"name": camera_name} if camera_name else {}), "camera": n, "translation": list(at),
                                  "rotation": turned(turn) if len(turn) == 3 else list(turn)})
        path.write_text(json.dumps(gltf))
        vxs("bake", path, "-o", tmp_path / "a.vxs", "--resolution", 64)
        chosen = ("--camera", name) if name is not None else ()
        vxs("render", path, tmp_path / "a.vxs", "-o", tmp_path / "out.png", "--samples", 1, "--json", tmp_path / "r.json", *size, *chosen, *options)
        report = json.loads((tmp_path / "r.json").read_text())
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "render.schema.json").read_text())).validate(report)
        return report, read_png((tmp_path / "out.png").read_bytes())

    return run


def seen(found):
    return found[0]["frames"][-1]["surface_samples"]


@pytest.mark.parametrize("height", [3, 12, 40])
def test_an_orthographic_camera(view, height):
    """A slab of 4 x 2 m is as large from everywhere, and cut at znear."""
    slab = [node("slab", box((-2, 0, -1), (2, 0.5, 1)))]
    found = view(slab, [("top", orthographic(5, 5), (0, height, 0), DOWN)], "top", size=FINE)
    assert seen(found) == pytest.approx(256 * 256 * 4 * 2 / 100, rel=0.03)
    assert seen(view(slab, [("top", orthographic(5, 2.5), (0, height, 0), DOWN)], "top", size=("--height", 256))) == pytest.approx(
        512 * 256 * 4 * 2 / 50, rel=0.03)
    assert seen(view(slab, [("top", orthographic(5, 5, znear=height + 1), (0, height, 0), DOWN)], "top")) == 0
    assert seen(view(slab, [("up", orthographic(5, 5), (0, height, 0), (0, 1, 0))], "up")) == 0, "it looks away"


@pytest.mark.parametrize("distance, yfov", [(3, 1.2), (10, 0.6)])
def test_a_perspective_camera(view, distance, yfov):
    """A face of a cube, 2 m wide, and what is farther and within its outline."""
    found = view([node("cube", cube(2))], [("front", perspective(yfov), (0, 0, distance + 1), (0, 0, -1))], "front", size=FINE)
    share = 1 / (distance * math.tan(yfov / 2))
    assert seen(found) == pytest.approx(256 * 256 * min(1, share) ** 2, rel=0.03)
    far = view([node("cube", cube(2))], [("front", perspective(yfov, znear=distance + 2.5), (0, 0, distance + 1), (0, 0, -1))], "front")
    assert seen(far) == 0


def test_it_is_what_eye_and_target_are(view):
    nodes = [node("floor", plane(12)), node("cube", cube(2), (1, 1, 0)), node("far", cube(1), (-3, 0.5, -3))]
    eye, way = (4, 3, 6), (-0.5, -0.3, -0.8)
    ours = view(nodes, [("shot", perspective(math.radians(40)), eye, way)], "shot")
    # turned() leaves a camera level only where its way has no part along x; --eye is level everywhere
    level = view(nodes, [("shot", perspective(math.radians(40)), (0, 3, 6), (0, -0.3, -0.8))], "shot")
    other = view(nodes, [], None, "--eye", "0,3,6", "--target", "0,0,-2", "--fov", 40)
    assert level[1][:2] == other[1][:2] == (64, 64)
    differ = sum(abs(a - b) > 2 for p, q in zip(level[1][2], other[1][2]) for a, b in zip(p, q))
    assert differ <= 40, "of 12288"
    assert ours[0]["frames"][0]["eye"] == pytest.approx(list(eye))


def test_a_camera_that_is_rolled(view):
    """By a quarter turn about its axis: the picture is turned the other way."""
    nodes = [node("floor", plane(12)), node("cube", cube(2), (1.5, 1, 0)), node("low", box((-4, 0, -2), (-1, 0.5, 3)))]
    half = math.sqrt(0.5)
    straight = view(nodes, [("c", perspective(0.9), (0, 2, 9), (0, 0, 0, 1))], "c")[1]
    rolled = view(nodes, [("c", perspective(0.9), (0, 2, 9), (0, 0, half, half))], "c")[1]  # about +z, counter-clockwise
    pixel = lambda picture, x, y: picture[2][y][3 * x:3 * x + 3]
    same = sum(max(abs(a - b) for a, b in zip(pixel(straight, x, y), pixel(rolled, y, 63 - x))) <= 8 for x in range(64) for y in range(64))
    other = sum(max(abs(a - b) for a, b in zip(pixel(straight, x, y), pixel(rolled, x, y))) <= 8 for x in range(64) for y in range(64))
    turned_back = sum(max(abs(a - b) for a, b in zip(pixel(straight, x, y), pixel(rolled, 63 - y, x))) <= 8 for x in range(64) for y in range(64))
    assert max(same, turned_back) > 0.93 * 64 * 64 > max(other, min(same, turned_back))
    assert turned_back > same, "the camera turns left, the picture right"


CAMERAS = [("front", perspective(0.8), (0, 0, 9), (0, 0, -1)), ("", dict(perspective(0.8), name="side view"), (9, 0, 0), (-1, 0, 0)),
           ("", orthographic(4, 4), (0, 9, 0), DOWN), ("front2", perspective(0.8, aspectRatio=2), (0, 0, 9), (0, 0, -1)),
           ("bad", perspective(-1), (0, 0, 9), (0, 0, -1))]


@pytest.mark.parametrize("name, number", [("front", 0), ("#1", 1), ("side*", 1), ("camera2", 2), ("2", 2), ("front?", 3)])
def test_cameras_by_name(view, name, number):
    found = view([node("cube", cube(2))], CAMERAS, name)[0]["frames"][0]["eye"]
    assert found == pytest.approx([0, found[1], 0], abs=1e-6) if number == 2 else found == list(CAMERAS[number][2])


def test_cameras_that_are_none(vxs, view, tmp_path):
    view([node("cube", cube(2))], CAMERAS, "front")
    words = ("render", tmp_path / "scene.gltf", tmp_path / "a.vxs", "-o", tmp_path / "none.png")
    known = "#0 'front' (perspective), #1 'side view' (perspective), #2 'camera2' (orthographic), #3 'front2' (perspective), #4 'bad' (unsound)"
    for options, says in (
            (("--camera", "back"), f"--camera back: '{tmp_path}/scene.gltf' has no camera of that name; it has {known}"),
            (("--camera", "frnt"), f"{known}: did you mean 'front'?"),
            (("--camera", "*2"), "has 2 of them, #2 'camera2' (orthographic), #3 'front2' (perspective); expected one"),
            (("--camera", "5"), "has no camera of that name"),
            (("--camera", "bad"), "says nothing sound of what it sees"),
            (("--camera", "camera2", "--fog", 0.1), "the orthographic camera 'camera2' has none"),
            (("--camera", "front", "--eye", "1,2,3", "--target", "0,0,0"), "--camera and --eye exclude each other"),
            (("--camera", "front", "--fov", 40), "--camera and --fov exclude each other"),
            (("--camera", "front", "--orbit"), "--camera and --orbit exclude each other")):
        done = vxs(*words, *options, status=2)
        assert says in done.stderr and done.stderr.count("\n") == 1, done.stderr
    view([node("cube", cube(2))], [], None)
    assert "has no camera; --eye and --target give one" in vxs(*words, "--camera", "front", status=2).stderr
    assert not (tmp_path / "none.png").exists()


@pytest.mark.parametrize("size, expected", [((), (1440, 720)), (("--width", 64), (64, 32)), (("--height", 40), (80, 40)),
                                            (("--width", 50, "--height", 60), (50, 60))])
def test_the_shape_of_the_picture(view, size, expected):
    assert view([node("cube", cube(2))], CAMERAS, "front2", size=size)[1][:2] == expected


def test_a_camera_by_rays(view, vxs, tmp_path):
    """With --draw rays it is the same camera, near plane and all."""
    for name in ("front", "camera2"):
        view([node("cube", cube(2))], CAMERAS, name)
        drawn = read_png((tmp_path / "out.png").read_bytes())[2]
        vxs("render", tmp_path / "scene.gltf", tmp_path / "a.vxs", "-o", tmp_path / "rays.png", "--draw", "rays", "--width", 64, "--height", 64,
            "--camera", name)
        traced = read_png((tmp_path / "rays.png").read_bytes())[2]
        half = 32 / (8 * math.tan(0.4)) if name == "front" else 32 / 4  # pixels that half of the cube is wide
        for rows in (drawn, traced):
            row = [rows[32][3 * x:3 * x + 3] for x in range(64)]
            nearer = [sum(abs(a - b) for a, b in zip(pixel, row[32])) < sum(abs(a - b) for a, b in zip(pixel, row[2])) for pixel in row]
            assert sum(nearer) == pytest.approx(2 * half, abs=2) and all(nearer[32 - int(half) + 1:32 + int(half) - 1])


# --- orbits -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("corners, fov", [(((-40, 0, -2), (40, 3, 2)), 35), (((-1, 0, -1), (1, 60, 1)), 35), (((100, 5, 0), (130, 9, 80)), 90)],
                         ids=["long", "high", "wide angle"])
def test_an_orbit_has_all_of_the_scene_in_view(view, corners, fov):
    """From each place on it, with none of it behind the eye; and it is not seen from needlessly far away."""
    frames = view([node("wall", box(*corners))], [], None, "--orbit", "--frames", 24, "--fov", fov, size=("--width", 64, "--height", 32))[0]["frames"]
    widest = 0
    for frame in frames:
        forward = [b - a for a, b in zip(frame["eye"], frame["target"])]
        length = math.sqrt(sum(c * c for c in forward))
        f = [c / length for c in forward]
        flat = math.hypot(f[0], f[2])
        right = [-f[2] / flat, 0, f[0] / flat]
        up = [right[1] * f[2] - right[2] * f[1], right[2] * f[0] - right[0] * f[2], right[0] * f[1] - right[1] * f[0]]
        for n in range(8):
            way = [corners[n >> axis & 1][axis] - frame["eye"][axis] for axis in range(3)]
            along, across, above = (sum(a * b for a, b in zip(way, axis)) for axis in (f, right, up))
            tangent = math.tan(math.radians(fov / 2))
            assert along > 0 and abs(above) <= along * tangent and abs(across) <= 2 * along * tangent
            widest = max(widest, abs(above) / (along * tangent), abs(across) / (2 * along * tangent))
    assert widest > 0.9
    assert frames[0]["target"] == pytest.approx([(a + b) / 2 for a, b in zip(*corners)])


# --- what was written ---------------------------------------------------------------------------------------------------------


def test_scene_and_render_say_what_they_wrote(vxs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = vxs("scene", "city", "--triangles", 1000, "--blocks", 1, "--spots", 2, "-o", "city.glb").stdout
    size = (tmp_path / "city.glb").stat().st_size
    assert said == f"wrote        city.glb: 996 triangles, 3 lights, {size / 1024:.1f} KiB\n"
    assert " capsules of smoke, " in vxs("scene", "smoke", "--capsules", 100, "-o", "smoke.glb").stdout
    assert vxs("scene", "city", "--triangles", 1000, "--blocks", 1, "-o", "q.glb", "--quiet").stdout == ""
    assert vxs("scene", "room", "--triangles", 1000, "-o", "/dev/null").stdout == "wrote        /dev/null: 1004 triangles, 2 lights\n"
    vxs("bake", "city.glb", "-o", "a.vxs", "--resolution", 64)
    small = ("--width", 32, "--height", 16, "--samples", 1)
    said = vxs("render", "city.glb", "a.vxs", "-o", "p.png", *small, "--json", "r.json", "--csv", "r.csv", "--plot", "r.svg", "--passes", "all").stdout
    bytes_of = {name: (tmp_path / name).stat().st_size for name in ("p.png", "r.json", "r.csv", "r.svg")}
    assert all(size < 10240 for size in bytes_of.values())
    assert said.splitlines() == ["wrote        all: passes, as pictures",
                                 f"wrote        r.json: times of frames as JSON, {bytes_of['r.json']} B",
                                 f"wrote        r.csv: times of frames as a table, {bytes_of['r.csv']} B",
                                 f"wrote        r.svg: times of frames as a plot, {bytes_of['r.svg']} B",
                                 f"wrote        p.png: 32 x 16 pixels, {bytes_of['p.png']} B"]
    done = vxs("render", "city.glb", "a.vxs", "-o", "p.png", *small, "--json", "-")
    assert json.loads(done.stdout) and done.stderr.splitlines()[-1] == f"wrote        p.png: 32 x 16 pixels, {bytes_of['p.png']} B"
    assert vxs("render", "city.glb", "a.vxs", "-o", "p.png", *small, "--quiet").stdout == ""
    said = vxs("render", "city.glb", "a.vxs", "-o", "rays.png", "--draw", "rays", "--width", 32, "--height", 16).stdout
    assert said.startswith("wrote        rays.png: 32 x 16 pixels, ")
