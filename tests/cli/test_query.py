# vxs query as its users meet it: points in, lit fractions out; every option, every error.
# SPDX-License-Identifier: GPL-3.0-or-later
import ctypes
import ctypes.util
import json
import struct
import subprocess

import pytest

import small_scene
from small_scene import MORNING, NOON

N = 64  # texels a side; one lies around the scene, which is 16 m wide


@pytest.fixture(scope="module")
def asset(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("query")
    lights = (("noon", "directional", NOON), ("morning", "directional", MORNING))
    vxs("bake", small_scene.write(folder / "small.gltf", lights=lights), "-o", folder / "small.vxs", "--resolution", N)
    return folder / "small.vxs"


@pytest.fixture
def query(vxs, asset):
    def run(text, *options):
        return vxs("query", asset, *options, input=text).stdout

    return run


@pytest.fixture
def fails(vxs, asset):
    def run(status, *options, input="", says=""):
        done = vxs("query", asset, *options, input=input, status=status)
        assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1 and says in done.stderr
        return done.stdout

    return run


def test_one_column_a_light_one_line_a_point(query):
    assert query("0 0.5 0\n2 0.5 0\n5 0.5 5\n") == "0 1\n1 0\n1 1\n"


def test_lights_in_the_order_asked_for(query):
    assert query("0 0.5 0\n", "--light", "morning") == "1\n"
    assert query("0 0.5 0\n", "--light", "morning", "--light", "noon") == "1 0\n"
    assert query("0 0.5 0\n", "--light=noon") == "0\n"


def test_outside_of_the_volume(query):
    assert query("99 0 0\n0 0 -99\n0 50 0\n1e300 1e300 1e300\n") == "out out\nout out\n1 out\nout out\n"
    assert query("0 100 0\n0 -100 0\n", "--light", "noon") == "1\n0\n", "a sun's volume is a prism: lit above, dark below"


@pytest.mark.parametrize("k", [3, 5, 9, 17])
def test_filter_is_the_mean_of_single_taps(query, k):
    texel = 16 / (N - 2)
    half = k // 2
    row = range(-9 - half, 10 + half)

    def ask(xs, zs, *options):
        text = "".join(f"{(x + 0.5) * texel} 0.5 {(z + 0.5) * texel}\n" for x in xs for z in zs)
        return [float(answer) for answer in query(text, "--light", "noon", *options).split()]

    taps = dict(zip([(x, z) for x in row for z in row], ask(row, row)))
    assert set(taps.values()) == {0, 1}, "the block's shadow, and the light around it"
    inner = range(-9, 10, 3)
    expected = [sum(taps[x + i, z + j] for i in range(-half, half + 1) for j in range(-half, half + 1)) / k**2
                for x in inner for z in inner]
    assert ask(inner, inner, "--filter", k) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("k", [1, 2, 4, 9, 17])
def test_smooth_filter_is_the_mean_of_taps_by_what_it_covers(query, k):
    texel, reach = 16 / (N - 2), k // 2 + 1
    row, places = range(-9 - reach, 10 + reach), [x + part for x in range(-9, 10, 2) for part in (0.0625, 0.5, 0.8125)]

    def ask(points, *options):
        text = "".join(f"{x * texel!r} 0.5 {z * texel!r}\n" for x, z in points)
        return [float(answer) for answer in query(text, "--light", "noon", *options).split()]

    def covered(x, place):
        return max(0, min(x + 1, place + k / 2) - max(x, place - k / 2))

    texels = [(x, z) for x in row for z in row]
    taps = dict(zip(texels, ask([(x + 0.5, z + 0.5) for x, z in texels])))
    expected = [sum(taps[x, z] * covered(x, u) * covered(z, v) for x, z in texels) / k**2 for u in places for v in places]
    assert len(set(expected)) > 5
    assert ask([(u, v) for u in places for v in places], "--smooth", k) == pytest.approx(expected, abs=3 / 256 / k)


def test_filter_of_one_is_the_default(query):
    points = "".join(f"{x / 3} 0.5 0.1\n" for x in range(-20, 20))
    assert query(points) == query(points, "--filter", 1)
    assert set(query(points, "--light", "noon").split()) == {"0", "1"}


def test_normal_lifts_a_point_off_its_surface(query):
    on_ground = "5 0 5"
    assert query(f"{on_ground} 0 1 0\n", "--light", "noon") == "1\n"
    assert query(f"{on_ground} 0 1 0\n", "--light", "noon", "--filter", 17) == "1\n"
    assert query(f"{on_ground} 0 1 0\n") == query(f"{on_ground} 0 7 0\n"), "a normal may have any length but zero"


@pytest.mark.parametrize("text", ["", "\n\n", "# nothing\n", "  \t \n"])
def test_no_points(query, text):
    assert query(text) == ""


@pytest.mark.parametrize("text", ["0 0.5 0", "0 0.5 0\r\n", "\t0  0.5\t0 \n", "+0 5e-1 -0.0\n", "# first\n\n0 0.5 0\n", "0x0 0x.8p0 0\n"])
def test_forms_of_a_point(query, text):
    assert query(text) == "0 1\n"


def test_many_points(query):
    count = 70000  # more than a block
    assert query("0 0.5 0\n5 0.5 5\n" * count) == "0 1\n1 1\n" * count


@pytest.mark.parametrize("line, says", [
    ("0 0", "3 or 6 numbers, found 2"), ("0 0 0 0", "found 4"), ("0 0 0 0 1 0 0", "found 7"), ("0 0 zero", "found 'zero'"),
    ("nan 0 0", "found 'nan'"), ("0 inf 0", "found 'inf'"), ("0 0 1e999", "found '1e999'"), ("0:0:0", "found '0:0:0'"),
    ("0 0 0 0 0 0", "the normal is zero"), ("0 0 0\0", "NUL"), ("1 " * 3000, "longer than"),
])
def test_wrong_points(fails, line, says):
    answered = fails(3, input=f"0 0.5 0\n{line}\n5 0.5 5\n", says=says)
    assert answered in ("", "0 1\n")
    fails(3, input=f"# one\n\n{line}\n", says="line 3")


@pytest.mark.parametrize("options, says", [
    (("--smooth", "0"), "from 1 to 17"), (("--smooth", "18"), "from 1 to 17"),
    (("--smooth", "5", "--filter", "5"), "--filter and --smooth exclude each other"),
    (("--filter", "4"), "odd"), (("--filter", "0"), "from 1 to 17"), (("--filter", "19"), "from 1 to 17"),
    (("--filter", "-3"), "from 1 to 17"), (("--filter", "three"), "whole number"), (("--filter",), "needs a value"),
    (("--light", "evening"), "noon"), (("--light", "noon", "--light", "noon"), "twice"), (("--sun", "0,-1,0"), "unknown option"),
    (("other.vxs",), "unexpected argument"),
])
def test_wrong_options(fails, options, says):
    assert fails(2, *options, input="0 0 0\n", says=says) == ""


def test_reader_that_goes_away(vxs_path, asset):
    """`vxs query | head -1` ends, whatever its status."""
    with subprocess.Popen([vxs_path, "query", asset], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as p:
        p.stdout.close()
        try:
            p.stdin.write(b"0 0.5 0\n" * 200000)
            p.stdin.close()
        except BrokenPipeError:
            pass
        assert p.wait(60) != 0


def test_file_that_needs_too_much_memory(vxs, tmp_path):
    """One section, whose zstd frame claims 5 GiB: not broken, but beyond the limit."""
    if not (name := ctypes.util.find_library("xxhash")):
        pytest.skip("no shared library of xxhash")
    library = ctypes.CDLL(name)
    library.XXH64.restype = ctypes.c_uint64

    def xxh64(data):
        return library.XXH64(data, ctypes.c_size_t(len(data)), ctypes.c_uint64(0))

    claimed = 5 << 30
    frame = struct.pack("<IBQ", 0xFD2FB528, 0xE0, claimed) + b"\1\0\0"
    entry = struct.pack("<4s3I4Q", b"LGHT", 0, 0xFFFFFFFF, 0, 64 + 48, len(frame), claimed, xxh64(frame))
    head = struct.pack("<8s2I2Q24x", b"\x8fVXS\r\n\x1a\n", 1, 1, 64 + 48 + len(frame), xxh64(entry))
    (tmp_path / "large.vxs").write_bytes(head + struct.pack("<Q", xxh64(head)) + entry + frame)
    said = vxs("query", tmp_path / "large.vxs", input="", status=6).stderr
    assert "cannot be opened: the file needs more memory" in said and "finding 211" in said and said.count("\n") == 1
    assert "not a valid" not in said


def test_control_characters_stay_off_the_terminal(fails):
    """Escape sequences, of 7 and of 8 bits, ends of lines, what turns text round, and bytes that are no UTF-8; other characters are kept."""
    fails(2, "--light", "a\x1b[31m\u009bx\u00e9", says="--light a?[31m??x\u00e9:")
    fails(2, "--light", "a\u202eb\u2066c\u200fd\u061ce\u2028f", says="--light a???b???c???d??e???f:")
    fails(2, "--light", "\u4e2d\u200b\U0001f4a1", says="--light \u4e2d\u200b\U0001f4a1:")
    fails(2, "--light", "a\udcffb\udce4\udcb8", says="--light a?b??:")  # bytes 0xff, and two of three


# -- the same question, ray traced -------------------------------------------------------------------------

@pytest.fixture(scope="module")
def lamps(tmp_path_factory):
    """The block under a sun, a spot of 30 degrees to each side, and a lamp that reaches 7 m, both 6 m above the ground."""
    path = tmp_path_factory.mktemp("truth") / "lamps.gltf"
    small_scene.write(path, lights=(("noon", "directional", NOON), ("spot", "spot", NOON), ("lamp", "point", NOON)))
    gltf = json.loads(path.read_text())
    _, spot, lamp = gltf["extensions"]["KHR_lights_punctual"]["lights"]
    spot["spot"]["outerConeAngle"] = 0.5235987755982988
    lamp["range"] = 7
    path.write_text(json.dumps(gltf))
    return path


@pytest.mark.parametrize("point, says", [
    ("0 0.01 0", "0 0 0"),  # under the block
    ("1.9 0.01 0", "1 0 0"),  # the lamps' shadow is twice as wide as the block
    ("2.1 0.01 0", "1 1 1"),
    ("3.4 0.01 0", "1 1 1"),
    ("3.5 0.01 0", "1 out 1"),  # beyond the cone, which is 6 tan 30 degrees wide there
    ("3.7 0.01 0", "1 out out"),  # 7.04 m from the lamp
    ("0 6.5 0", "1 out 1"),  # behind the spot
    ("0 -0.01 0", "0 0 0"),  # in the ground
    ("0 -2 0", "0 0 out"),
    ("3 0 0 0 1 0", "1 1 1"),
    ("3 0 0 0 -1 0", "0 0 0"),
])
def test_truth_of_every_kind_of_light(vxs, lamps, point, says):
    assert vxs("truth", lamps, input=point + "\n").stdout == says + "\n"


def test_truth_of_many_points(vxs, lamps):
    """More than a block of them, lines of unequal length, at any thread count."""
    points, lines = ["0 0.01 0", "3.5 0.01 0", "0 -2 0"] * 70000, ["0 0 0", "1 out 1", "0 0 out"] * 70000
    for threads in (1, 3):
        assert vxs("truth", lamps, "--threads", threads, input="\n".join(points)).stdout.splitlines() == lines


def test_truth_of_chosen_lights(vxs, lamps):
    options = ("--light", "lamp", "--light", "sun", "--light", "spot", "--sun", "1,-1,0")
    assert vxs("truth", lamps, *options, input="0 6.5 0\n2.5 0.01 0\n").stdout == "1 1 out\n1 0 1\n"


# -- and from a file that holds all three -------------------------------------------------------------------

@pytest.fixture(scope="module")
def baked_lamps(vxs, lamps):
    asset = lamps.parent / "lamps.vxs"
    vxs("bake", lamps, "-o", asset, "--resolution", 256)
    return asset


@pytest.mark.parametrize("options", [(), ("--filter", 3)])
def test_query_of_every_kind_of_light(vxs, baked_lamps, lamps, options):
    """Away from shadow boundaries a lookup says what a ray says, `out` included."""
    points = "".join(f"{x} {y} {z}\n" for x, y, z in [
        (0, 0.5, 0), (1.6, 0.1, 0), (2.4, 0.1, 0.3), (3.4, 0.1, 0), (3.5, 0.1, 0.3), (0, 6.5, 0), (0, 3.5, 0.2), (-2.5, 0.1, -1)])
    points += "3.4 0 0 0 1 0\n4 0 4 0 1 0\n0 2 0.5 0 -1 0\n"
    ask = [vxs("query", baked_lamps, *options, input=points).stdout, vxs("truth", lamps, input=points).stdout]
    assert ask[0] == ask[1] and "out" in ask[0]
    assert ask[0].splitlines()[5] == "1 out 1"


def test_info_of_every_kind_of_light(vxs, baked_lamps):
    noon, spot, lamp = json.loads(vxs("info", baked_lamps, "--json", "-").stdout)["lights"]
    assert [light["kind"] for light in (noon, spot, lamp)] == ["directional", "spot", "point"]
    assert [light["maps"] for light in (noon, spot, lamp)] == [1, 1, 6]
    assert not {"position_m", "near_m", "far_m", "range_m", "cone_degrees"} & noon.keys()
    assert spot["position_m"] == lamp["position_m"] == pytest.approx([0, 6, 0], abs=1e-9)
    assert spot["cone_degrees"] == pytest.approx(60) and "cone_degrees" not in lamp
    assert lamp["range_m"] == 7 and "range_m" not in spot
    for light in (spot, lamp):
        assert 0 < light["near_m"] <= 3 and light["far_m"] >= 6  # from the block's top to the ground
    text = vxs("info", baked_lamps).stdout
    assert "light spot: spot at (0, 6, 0) towards (0, -1, 0), cone of 60 degrees, no range, from " in text
    assert "light lamp: point at (0, 6, 0), range 7 m, from " in text and "six maps of 256 x 256 texels" in text
