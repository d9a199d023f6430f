# vxs scene: the same options give the same valid GLB, and everything else gives one clear line and no file.
# SPDX-License-Identifier: GPL-3.0-or-later
import hashlib
import json
import math
import os
import resource
import signal
import stat
import struct
import subprocess
import zlib

import pytest

KINDS = ["city", "landscape", "room", "forest"]
SUNNY = ["city", "landscape", "forest"]


def read_glb(data):
    """The JSON and the binary chunk, after every check of the container."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data)) and length % 4 == 0
    json_length, json_kind = struct.unpack_from("<I4s", data, 12)
    bin_at = 20 + json_length
    bin_length, bin_kind = struct.unpack_from("<I4s", data, bin_at)
    assert json_kind == b"JSON" and bin_kind == b"BIN\0" and json_length % 4 == 0
    assert bin_at + 8 + bin_length == len(data)
    text = data[20:bin_at].decode()
    assert text.rstrip(" ").endswith("}")
    return json.loads(text), data[bin_at + 8:]


def read_accessor(gltf, binary, index):
    a = gltf["accessors"][index]
    view = gltf["bufferViews"][a["bufferView"]]
    width, letter = {("VEC3", 5126): (3, "f"), ("VEC2", 5126): (2, "f"), ("SCALAR", 5125): (1, "I")}[a["type"], a["componentType"]]
    assert a["byteOffset"] % 4 == 0 and a["byteOffset"] + 4 * width * a["count"] <= view["byteLength"]
    return struct.unpack_from(f"<{width * a['count']}{letter}", binary, view["byteOffset"] + a["byteOffset"])


def triangle_count(gltf):
    return sum(gltf["accessors"][p["indices"]]["count"] // 3 for m in gltf["meshes"] for p in m["primitives"])


def sun_direction(gltf):
    """Where the node "sun" turns -Z, the way a glTF light shines."""
    (node,) = [n for n in gltf["nodes"] if n.get("name") == "sun"]
    light = gltf["extensions"]["KHR_lights_punctual"]["lights"][node["extensions"]["KHR_lights_punctual"]["light"]]
    assert light["type"] == "directional" and light["name"] == "sun" and "KHR_lights_punctual" in gltf["extensionsUsed"]
    x, y, z, w = node["rotation"]
    assert abs(x * x + y * y + z * z + w * w - 1) < 1e-14
    return -2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))


def assert_one_line(done, *words):
    assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("kind", KINDS)
def test_same_options_same_bytes(vxs, tmp_path, kind):
    def digest(name, *options):
        vxs("scene", kind, "-o", tmp_path / name, "--triangles", 20000, *options)
        return hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()

    first = digest("a.glb")
    assert first == digest("b.glb") == digest("c.glb", "--seed", 1)
    assert first != digest("e.glb", "--seed", 2)
    if kind in SUNNY:
        assert first == digest("d.glb", "--sun", "-0.5,-1,-0.3") and first != digest("f.glb", "--sun", "0,-1,0")
    assert all(p.suffix == ".glb" for p in tmp_path.iterdir()), "a temporary file was left"


@pytest.mark.parametrize("kind", ["smoke", "hair"])
def test_smoke_is_points_and_lines(vxs, tmp_path, kind):
    def make(name, *options):
        vxs("scene", kind, "-o", tmp_path / name, *options)
        return (tmp_path / name).read_bytes()

    first = make("a.glb", "--capsules", 999)
    assert first == make("b.glb", "--capsules", 999, "--seed", 1) != make("c.glb", "--capsules", 999, "--seed", 2)
    gltf, _ = read_glb(first)
    smoke = [p for m in gltf["meshes"] for p in m["primitives"] if "_RADIUS" in p["attributes"]]
    ends = [gltf["accessors"][p["attributes"]["_EXTINCTION"]]["count"] // (1 + p["mode"]) for p in smoke]
    assert sum(ends) == 999 and {p["mode"] for p in smoke} == ({0} if kind == "smoke" else {0, 1})
    done = vxs("bake", tmp_path / "a.glb", "-o", tmp_path / "a.vxs", "--resolution", 256)
    assert "smoke        999 capsules" in done.stdout and "100 % of them in solids" in done.stdout and done.stderr == ""


# Pinned, so that a change of compiler, flags or machine that changes a scene is seen; so is a change of the generators.
@pytest.mark.parametrize("kind, digest", [
    ("city", "758dc3e566feddb3bc70a7bb99ba653dde1e8ba7aaf74cb405122e1aa9efd664"),
    ("room", "2cb8cfd208d15dd6b659fc5b742ea1bbad42416ca2acb688a85f574872bf4508"),
    ("forest", "10334c91e5c6dfa5af233cf9e4bc2595ea68b9653fef7df3c0024214bba245f9"),
    ("landscape", "75f467c9ff2f85fdc1e20564bfeb1c3de418df64769d7b3984dc9cdd994c937e"),
    ("smoke", "74df5021b387993653b82ac63263e631eb73e074018f79c9b79da3b32d3f27a8"),
    ("hair", "67c42a5207b8b37fc0e64a0577b14c28c2ae097c4e05c72af4779439c969e08f"),
])
def test_bytes_of_the_geometry_are_pinned(vxs, tmp_path, kind, digest):
    vxs("scene", kind, "-o", tmp_path / "a.glb")
    gltf, binary = read_glb((tmp_path / "a.glb").read_bytes())
    for image in gltf.get("images", []):  # other versions of libpng and zlib compress otherwise: the pixels are pinned, behind the rest
        view = gltf["bufferViews"][image["bufferView"]]
        png = binary[view["byteOffset"]:][:view["byteLength"]]
        binary = binary[:view["byteOffset"]] + decode_png(png)[2]
    assert hashlib.sha256(binary).hexdigest() == digest


@pytest.mark.parametrize("kind", KINDS)
def test_glb_is_valid(vxs, tmp_path, kind):
    vxs("scene", kind, "-o", tmp_path / "a.glb", "--triangles", 12345)
    gltf, binary = read_glb((tmp_path / "a.glb").read_bytes())
    assert gltf["asset"] == {"version": "2.0", "generator": "vxs"}
    assert gltf["buffers"] == [{"byteLength": len(binary)}]
    assert gltf["scenes"][gltf["scene"]]["nodes"] == list(range(len(gltf["nodes"])))
    for mesh in gltf["meshes"]:
        (primitive,) = mesh["primitives"]
        bounds = gltf["accessors"][primitive["attributes"]["POSITION"]]
        positions = read_accessor(gltf, binary, primitive["attributes"]["POSITION"])
        indices = read_accessor(gltf, binary, primitive["indices"])
        assert [min(positions[i::3]) for i in range(3)] == bounds["min"]
        assert [max(positions[i::3]) for i in range(3)] == bounds["max"]
        assert set(indices) == set(range(bounds["count"])) and len(indices) % 3 == 0


@pytest.mark.parametrize("options", [
    ["city"], ["city", "--triangles", 1000], ["city", "--triangles", 1000, "--blocks", 64],
    ["city", "--triangles", 40007, "--blocks", 3], ["city", "--triangles", 300000, "--blocks", 1],
    ["city", "--triangles", 1000000, "--blocks", 30], ["landscape"], ["landscape", "--triangles", 1000],
    ["landscape", "--triangles", 1234567], *([kind, "--triangles", n] for kind in ["room", "forest"]
                                             for n in [1000, 1500, 5003, 20000, 1000000]),
    ["forest", "--size", 10], ["forest", "--size", 5000, "--seed", 9]])
def test_triangle_target_is_met(vxs, tmp_path, options):
    vxs("scene", *options, "-o", tmp_path / "a.glb")
    target = dict(zip(options[1::2], options[2::2])).get("--triangles", 100000)
    gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
    assert abs(triangle_count(gltf) - target) <= 0.02 * target


@pytest.mark.parametrize("kind", SUNNY)
@pytest.mark.parametrize("sun", [(-0.5, -1, -0.3), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1e-9, 0, 1), (3, 4, 0),
                                 (1e300, -1e300, 0)])
def test_sun_shines_as_asked(vxs, tmp_path, kind, sun):
    vxs("scene", kind, "--triangles", 1000, "--sun", ",".join(map(str, sun)), "-o", tmp_path / "a.glb")
    gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
    largest = max(map(abs, sun))
    length = sum((s / largest) ** 2 for s in sun) ** 0.5 * largest
    assert max(abs(a - b / length) for a, b in zip(sun_direction(gltf), sun)) < 1e-15


def test_default_sun_is_oblique(vxs, tmp_path):
    vxs("scene", "city", "--triangles", 1000, "-o", tmp_path / "a.glb")
    gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
    assert sun_direction(gltf) == pytest.approx([d / 1.34 ** 0.5 for d in (-0.5, -1, -0.3)], abs=1e-15)


def test_landscape_has_the_size_and_height_asked(vxs, tmp_path):
    vxs("scene", "landscape", "--size", 300, "--height", 17.5, "-o", tmp_path / "a.glb")
    gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
    assert gltf["accessors"][0]["min"] == [-150, -300 / 32, -150]
    assert gltf["accessors"][0]["max"] == [150, 17.5, 150]


def casters_of(vxs, tmp_path, *options):
    vxs("scene", *options, "-o", tmp_path / "a.glb")
    done = vxs("bake", tmp_path / "a.glb", "--sun", "0.1,-1,0.2", "--resolution", 64, "--json", "-",
               "-o", tmp_path / "a.vxs")
    casters = json.loads(done.stdout)["casters"]
    return casters["solids"], {k: v["components"] for k, v in casters["sheets"].items() if v["components"]}


@pytest.mark.parametrize("triangles", [1000, 20000])
@pytest.mark.parametrize("seed", [1, 2])
def test_room_is_a_shell_with_solids(vxs, tmp_path, triangles, seed):
    """Nothing is occupied: neither light is inside of a solid, and no solid is inside another."""
    solids, sheets = casters_of(vxs, tmp_path, "room", "--triangles", triangles, "--seed", seed)
    assert sheets == {"open": 2} and solids["components"] >= 48
    gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
    lights = gltf["extensions"]["KHR_lights_punctual"]["lights"]
    assert [(light["name"], light["type"]) for light in lights] == [("lamp", "point"), ("corner", "spot")]
    assert [n["translation"] for n in gltf["nodes"] if "extensions" in n] == [[0, 2, 0], [-3.7, 2.7, -2.7]]


def test_room_faces_inward(vxs, tmp_path):
    vxs("scene", "room", "-o", tmp_path / "a.glb")
    gltf, binary = read_glb((tmp_path / "a.glb").read_bytes())
    (primitive,) = [m["primitives"][0] for m in gltf["meshes"] if m["name"] == "shell"]
    p = read_accessor(gltf, binary, primitive["attributes"]["POSITION"])
    area = 0
    indices = read_accessor(gltf, binary, primitive["indices"])
    for t in zip(indices[::3], indices[1::3], indices[2::3]):
        a, b, c = (p[3 * i:3 * i + 3] for i in t)
        u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        assert sum(n * (m - x) for n, m, x in zip(normal, (0, 1.5, 0), a)) > 0, "its front sees the middle"
        area += sum(n * n for n in normal) ** 0.5 / 2
    assert area == pytest.approx(2 * (8 * 6 + 8 * 3 + 6 * 3) - 2), "all six sides, but for the door"


def decode_png(data):
    """Width, height, and RGBA of a PNG of 8 bits a channel (PNG specification, section 9)."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, *rest = struct.unpack_from(">IIBBBBB", data, at + 8)
            assert rest == [8, 6, 0, 0, 0]
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    raw, stride = zlib.decompress(packed), 4 * width
    above, out = bytes(stride), b""
    for y in range(height):
        method, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            a, b, c = row[x - 4] if x >= 4 else 0, above[x], above[x - 4] if x >= 4 else 0
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            row[x] = (row[x] + [0, a, b, (a + b) // 2, nearest][method]) & 255
        above = bytes(row)
        out += above
    return width, height, out


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_leaves_are_half_transparent(vxs, tmp_path, seed):
    vxs("scene", "forest", "--seed", seed, "-o", tmp_path / "a.glb", "--triangles", 1000)
    gltf, binary = read_glb((tmp_path / "a.glb").read_bytes())
    (material, plain), (image,) = gltf["materials"], gltf["images"]
    matt = {"metallicFactor": 0, "roughnessFactor": 1}
    assert plain["extras"] == {"vxs_plain": True}, "its mark for vxs view"
    assert plain["pbrMetallicRoughness"] == matt and material["pbrMetallicRoughness"].items() >= matt.items(), "glTF's default is metal"
    assert material["alphaMode"] == "MASK" and material["alphaCutoff"] == 0.5 and material["doubleSided"]
    assert gltf["textures"] == [{"source": material["pbrMetallicRoughness"]["baseColorTexture"]["index"]}]
    view = gltf["bufferViews"][image["bufferView"]]
    assert image["mimeType"] == "image/png" and "byteStride" not in view
    width, height, rgba = decode_png(binary[view["byteOffset"]:][:view["byteLength"]])
    opaque = sum(a >= 128 for a in rgba[3::4]) / width / height
    assert 0.4 < opaque < 0.6 and len(set(rgba[3::4])) > 50, "half of it, with soft edges"
    assert set(rgba[3:4 * width:4]) == {0}, "it may be repeated: nothing reaches the border"


def test_forest_is_solid_wood_and_cards(vxs, tmp_path):
    solids, sheets = casters_of(vxs, tmp_path, "forest", "--triangles", 20000)
    gltf, binary = read_glb((tmp_path / "a.glb").read_bytes())
    meshes = {m["name"]: m["primitives"][0] for m in gltf["meshes"]}
    assert list(meshes) == ["landscape", "wood", "leaves"] and gltf["materials"][meshes["wood"]["material"]]["name"] == "plain"
    uv = read_accessor(gltf, binary, meshes["leaves"]["attributes"]["TEXCOORD_0"])
    cards = gltf["accessors"][meshes["leaves"]["indices"]]["count"] // 6
    assert len(uv) == 8 * cards and cards > 4000
    for card in range(0, len(uv), 8):
        corners = list(zip(uv[card:card + 8:2], uv[card + 1:card + 8:2]))
        turn = corners.index((0, 0))
        assert corners[turn:] + corners[:turn] == [(0, 0), (1, 0), (1, 1), (0, 1)]
    trees = gltf["accessors"][meshes["wood"]["indices"]]["count"] // 3 // 112
    assert solids["components"] == 1 + 5 * trees and sum(sheets.values()) == cards


def test_blocks_make_a_wider_city(vxs, tmp_path):
    def width(blocks):
        vxs("scene", "city", "--blocks", blocks, "-o", tmp_path / "a.glb")
        gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
        assert len(gltf["meshes"]) == blocks * blocks + 1
        return gltf["accessors"][0]["max"][0] - gltf["accessors"][0]["min"][0]

    assert width(8) - width(3) == 5 * 72


def spots_of(gltf):
    """name: (the light, its node)"""
    lights = gltf["extensions"]["KHR_lights_punctual"]["lights"]
    nodes = [n for n in gltf["nodes"] if "extensions" in n]
    pairs = [(lights[n["extensions"]["KHR_lights_punctual"]["light"]], n) for n in nodes]
    assert [light for light, _ in pairs] == lights and all(light["name"] == n["name"] for light, n in pairs)
    return {light["name"]: (light, n) for light, n in pairs if light["type"] == "spot"}


def test_spots_are_written(vxs, tmp_path):
    vxs("scene", "city", "--spots", 165, "-o", tmp_path / "a.glb")
    gltf, _ = read_glb((tmp_path / "a.glb").read_bytes())
    spots = spots_of(gltf)
    assert list(spots) == [f"spot{n:04}" for n in range(1, 166)]
    cones = [light["spot"]["outerConeAngle"] * 180 / math.pi for light, _ in spots.values()]
    ranges = [light["range"] for light, _ in spots.values()]
    assert 19.9 < min(cones) < 25 and 55 < max(cones) < 60.1 and 15 <= min(ranges) < 18 and 37 < max(ranges) <= 40
    assert sun_direction(gltf) == pytest.approx([d / 1.34 ** 0.5 for d in (-0.5, -1, -0.3)], abs=1e-15)
    for _, node in spots.values():
        x, y, z, w = node["rotation"]
        assert abs(x * x + y * y + z * z + w * w - 1) < 1e-14 and -2 * (y * z - w * x) < -0.6
        assert 6 < node["translation"][1] < 8, "under the arm of a lamp"


def test_spots_leave_the_city_as_it_is(vxs, tmp_path):
    def binary(*options):
        vxs("scene", "city", "-o", tmp_path / "a.glb", *options)
        return read_glb((tmp_path / "a.glb").read_bytes())[1]

    assert binary() == binary("--spots", 0) == binary("--spots", 3000)


def test_standard_output(vxs, vxs_path, tmp_path):
    vxs("scene", "city", "-o", tmp_path / "a.glb")
    done = subprocess.run([vxs_path, "scene", "city", "-o", "-"], capture_output=True, check=True)
    assert done.stdout == (tmp_path / "a.glb").read_bytes() and done.stderr == b"wrote        standard output: 99996 triangles, 1 light\n"


def test_help(vxs):
    done = vxs("scene", "--help")
    for word in ["city", "landscape", "-o", "--blocks", "--triangles", "--seed", "--sun", "--size", "--height"]:
        assert word in done.stdout


@pytest.mark.parametrize("options, words", [
    ([], ["KIND is missing"]),
    (["village"], ["village", "city|landscape|room|forest|smoke|hair|stress"]),
    (["city", "landscape"], ["unexpected argument 'landscape'"]),
    (["city", "--height", "3"], ["--height applies to landscape only"]),
    (["city", "--size", "3"], ["--size applies to landscape and forest only"]),
    (["room", "--sun", "0,-1,0"], ["--sun applies to city, landscape and forest only"]),
    (["room", "--size", "20"], ["--size applies to landscape and forest only"]),
    (["forest", "--size", "9"], ["--size 9", "10 or more"]),
    (["forest", "--case", "nested-100"], ["--case applies to stress only"]),
    (["stress", "--case", "nested-100", "--triangles", "1000"], ["--triangles applies to city, landscape, room and forest only"]),
    (["stress", "--case", "nested-100", "--seed", "1"], ["--seed applies to all kinds but stress"]),
    (["stress", "--case", "nested-101"], ["--case nested-101", "expected one of", "nested-100", "tiny-scene"]),
    (["stress"], ["--case is missing", "--case list"]),
    (["landscape", "--blocks", "8"], ["--blocks applies to city only"]),
    (["landscape", "--spots", "8"], ["--spots applies to city only"]),
    (["city", "--spots", "10001"], ["--spots 10001", "0 to 10000"]),
    (["city", "--blocks", "0"], ["--blocks 0", "1 to 64"]),
    (["city", "--blocks", "65"], ["--blocks 65", "1 to 64"]),
    (["city", "--triangles", "999"], ["--triangles 999", "1000 to 5000000"]),
    (["city", "--triangles", "5000001"], ["--triangles 5000001"]),
    (["city", "--seed", "-1"], ["--seed -1"]),
    (["city", "--sun", "0,0,0"], ["--sun 0,0,0", "direction"]),
    (["city", "--sun", "1,2"], ["--sun 1,2", "3 numbers"]),
    (["landscape", "--size", "0"], ["--size 0"]),
    (["landscape", "--height", "-1"], ["--height -1"]),
    (["smoke", "--triangles", "1000"], ["--triangles applies to city, landscape, room and forest only"]),
    (["city", "--capsules", "1000"], ["--capsules applies to smoke and hair only"]),
    (["hair", "--capsules", "7"], ["--capsules 7", "8 to 1000000"]),
    (["city", "--lamps", "3"], ["unknown option '--lamps'"]),
])
def test_wrong_options(vxs, tmp_path, options, words):
    assert_one_line(vxs("scene", *options, "-o", tmp_path / "a.glb", status=2), *words)
    assert not list(tmp_path.iterdir())


def test_output_is_required(vxs):
    assert_one_line(vxs("scene", "city", status=2), "-o")


def test_unwritable_outputs(vxs, tmp_path):
    (tmp_path / "folder").mkdir()
    assert_one_line(vxs("scene", "city", "-o", tmp_path / "folder", status=4), "folder", "file name")
    assert_one_line(vxs("scene", "city", "-o", tmp_path / "none" / "a.glb", status=4), "none/a.glb", "No such file")
    assert_one_line(vxs("scene", "city", "-o", "", status=4), "empty")
    assert_one_line(vxs("scene", "city", "-o", "/dev/full", status=4), "/dev/full", "No space left")
    if os.geteuid() != 0:  # root may write anywhere
        (tmp_path / "locked").mkdir(mode=0o555)
        assert_one_line(vxs("scene", "city", "-o", tmp_path / "locked" / "a.glb", status=4), "Permission denied")
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == []


def test_full_standard_output(vxs_path):
    with open("/dev/full", "wb") as full:
        done = subprocess.run([vxs_path, "scene", "city", "-o", "-"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 4 and "standard output: cannot write" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("limit", [1, 4096, 100000, 2000000])
def test_failed_write_leaves_the_old_file_and_no_other(vxs_path, tmp_path, limit):
    """A limit on the size of files stands for a full disk: the write fails half-way."""
    def limited():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    (tmp_path / "a.glb").write_text("old")
    done = subprocess.run([vxs_path, "scene", "city", "-o", tmp_path / "a.glb"], preexec_fn=limited, capture_output=True,
                          text=True)
    assert done.returncode == 4
    assert_one_line(done, "a.glb: cannot write")
    assert [p.name for p in tmp_path.iterdir()] == ["a.glb"] and (tmp_path / "a.glb").read_text() == "old"


def test_output_replaces_a_file_and_follows_a_link(vxs, tmp_path):
    (tmp_path / "real.glb").write_text("old")
    (tmp_path / "link.glb").symlink_to("real.glb")
    vxs("scene", "city", "-o", tmp_path / "link.glb")
    assert (tmp_path / "link.glb").is_symlink() and (tmp_path / "real.glb").read_bytes()[:4] == b"glTF"
    assert len(list(tmp_path.iterdir())) == 2


def test_output_has_the_permissions_that_umask_leaves(vxs_path, tmp_path):
    subprocess.run([vxs_path, "scene", "city", "-o", tmp_path / "a.glb"], preexec_fn=lambda: os.umask(0o027), check=True)
    assert stat.S_IMODE((tmp_path / "a.glb").stat().st_mode) == 0o640


def test_output_in_the_current_folder(vxs_path, tmp_path):
    subprocess.run([vxs_path, "scene", "landscape", "-o", "a.glb"], cwd=tmp_path, check=True)
    assert [p.name for p in tmp_path.iterdir()] == ["a.glb"]


def test_device_stays_a_device(vxs):
    vxs("scene", "city", "-o", "/dev/null")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
