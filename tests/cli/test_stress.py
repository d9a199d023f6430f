# vxs scene stress: every case, baked light by light, against points whose light was worked out by hand, against rays, and, from
# both sources of maps, voxel by voxel; or refused with one line. scenes/README.md says what each case is.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

LIT, DARK, OUT = 1, 0, "out"
SLANTED, DOWN, NEARLY_DOWN, GRAZING = "1,-1,0", "0,-1,0", "0.01,-1,0.02", "1,-0.01,0.00017453"


def floor(x, z, y=0):
    """A point of the ground: its bias is upward."""
    return (x, y, z, 0, 1, 0)


def bars(i):
    """Bar i of far-coordinates over its ground, from and to: bottom at 1 m, top at 1.01 m."""
    return -1.5 + 0.1 * i, -1.49 + 0.1 * i


FAR = (1e7, 250000, -1e7)
FAR_SUN = [(floor((bars(i)[0] + 1 + bars(i)[1] + 1.01) / 2, z), DARK) for i in range(0, 20, 3) for z in (-0.9, 0, 0.9)] \
    + [(floor(bars(i)[1] + 1.05, z), LIT) for i in range(0, 20, 3) for z in (-0.9, 0, 0.9)] \
    + [(floor(-1, 0), LIT), (floor(0.01, 1.2), LIT)]
FAR_SPOT = [(floor((bars(i)[0] * 3 / 1.99 + bars(i)[1] * 3 / 2) / 2, 0), DARK) for i in (10, 5, 2)] \
    + [(floor(bars(i)[1] * 1.5 + 0.05, 0), LIT) for i in (10, 5, 2)]

# case: what becomes of it. solids, sheets: components; lights: name: (direction of a sun, resolution, [(point, light)])
CASES = {
    "far-coordinates": dict(solids=21, sheets={}, lights={
        "sun": (SLANTED, 2048, [(tuple(a + b for a, b in zip(p, FAR + (0, 0, 0))), lit) for p, lit in FAR_SUN]),
        "spot": (None, 2048, [(tuple(a + b for a, b in zip(p, FAR + (0, 0, 0))), lit) for p, lit in FAR_SPOT]),
    }),
    # the sheets 1 mm and 1 m below the lights cast shadows of 200 and 50 m, the house one of 4.5 m behind its far wall
    "near-far": dict(solids=2, sheets={"open": 2}, lights={
        light: (None, resolution, [
            (floor(300, 0, -1000), DARK), (floor(210, 90, -1000), DARK), (floor(390, -90, -1000), DARK),
            (floor(60, 0, -1000), LIT), (floor(540, 0, -1000), LIT), (floor(300, 240, -1000), LIT),
            (floor(190, 0, -1000), LIT), (floor(410, 0, -1000), LIT), (floor(300, 110, -1000), LIT),
            (floor(-75, 325, -1000), DARK), (floor(-110, 325, -1000), LIT), (floor(-40, 325, -1000), LIT),
            (floor(-223, 0, -1000), DARK), (floor(-230, 0, -1000), LIT), (floor(-200, 0, -980), LIT),
            ((0, -0.0005, 0), LIT), (floor(0, 0, -1000), LIT), (floor(0, -300, -1000), LIT)])
        for light, resolution in (("spot", 2048), ("point", 2048))
    }),
    # a ray that comes down 3 m while it passes 300 m along the wall moves 0.0524 m away from it
    "grazing-wall": dict(solids=2, sheets={}, lights={
        "sun": (GRAZING, 4096, [
            (floor(600, 0.03), DARK), (floor(600, 0.04), DARK), (floor(600, 0.07), LIT), (floor(600, 2), LIT),
            (floor(999, 0.04), DARK), (floor(999, 0.07), LIT), (floor(100, 0.04), LIT), (floor(250, 0.03), DARK),
            (floor(600, -0.5), LIT), ((600, 1.5, -0.3, 0, 0, -1), LIT), ((600, 1.5, 0.5), LIT)]),
    }),
    "wall-along-light": dict(solids=2, sheets={"open": 2}, lights={
        "sun": (SLANTED, 1024, [
            (floor(4.5, 0), DARK), (floor(3.5, 0.06), DARK), (floor(4.5, 0.3), LIT), (floor(4.5, -0.3), LIT), (floor(6.5, 0), LIT),
            (floor(1, 2.1), LIT), (floor(1, 1.9), LIT), (floor(4.5, 2.1), LIT), (floor(4.5, -2.1), LIT), (floor(4.5, -1.9), LIT)]),
        "spot": (None, 1024, [
            (floor(0, 1), DARK), (floor(2, 1.5), DARK), (floor(3, -1), LIT), (floor(4, -2.1), LIT), (floor(4, -1.9), LIT),
            ((0, 1, -1.9), LIT), ((0, 1, -2.1), LIT)]),
    }),
    # the two in line are one component, front and back of nothing
    "zero-area-and-needles": dict(solids=2, sheets={"open": 100, "inward": 1}, collapsed=3, lights={
        "sun": (SLANTED, 1024, [
            (floor(1.5, 3), DARK), (floor(-0.5, 3), LIT), (floor(3.5, 3), LIT), (floor(1.5, 1.8), LIT), (floor(1, -2.95), LIT),
            (floor(1, -3.05), LIT), (floor(1, -2.5), LIT), *[(floor(0.5 * i, -1.99 + 0.06 * i), LIT) for i in range(8)]]),
    }),
    # equal boxes weld into one component each; so do equal sheets, and a sheet and its back, which encloses nothing
    "coplanar-duplicates": dict(solids=5, sheets={"open": 1, "inward": 1}, lights={
        "sun": (SLANTED, 1024, [
            (floor(1.5, 0), DARK), (floor(4, 0), DARK), (floor(5.3, 0), DARK), (floor(-2, 0), DARK), (floor(-0.5, 2.5), DARK),
            (floor(-1, 0), LIT), (floor(-3.5, 0), LIT), (floor(-0.5, 1.5), LIT), (floor(6, 0), LIT), (floor(1.5, 1.5), LIT)]),
    }),
    "close-sheets": dict(solids=1, sheets={"open": 2}, lights={
        "sun": (SLANTED, 1024, [
            (floor(1.1, 0), DARK), (floor(2, 0), DARK), (floor(2.5, 0.9), DARK), (floor(3.1, 0), DARK), (floor(3.9, 0), DARK),
            (floor(0.9, 0), LIT), (floor(4.1, 0), LIT), (floor(2.5, 1.1), LIT), (floor(2, 0, 2.000001), LIT)]),
    }),
    "nested-100": dict(solids=2, sheets={"occupied": 99}, lights={
        "sun": (SLANTED, 1024, [
            (floor(6, 0), DARK), (floor(-3.8, 0), DARK), (floor(15.8, 0), DARK), (floor(6, 4.8), DARK),
            (floor(-4.2, 0), LIT), (floor(16.2, 0), LIT), (floor(6, 5.2), LIT), (floor(0, 0, 11), LIT)]),
    }),
    # the bars' ends are 0.126 m apart and 0.3 m wide: together a disc of 4 m, from 2.5 to 3.7 m high
    "intersecting-100": dict(solids=101, sheets={}, lights={
        "sun": (SLANTED, 1024, [
            (floor(3, 0), DARK), (floor(5, 2), DARK), (floor(3, 3.8), DARK), (floor(-0.8, 0), DARK), (floor(7, 0), DARK),
            (floor(-3, 0), LIT), (floor(9, 0), LIT), (floor(3, 4.5), LIT)]),
    }),
    "layers-1000": dict(solids=2001, sheets={"open": 1000}, resolution=128, lights={
        "sun": (NEARLY_DOWN, 256, [
            (floor(-2, 0.5), DARK), (floor(2, 0.5), DARK), (floor(6, 0.5), DARK), ((-1.5, 50.575, 0.5), DARK),
            ((6, 50.55, 0.5), DARK), (floor(0.5, 0.5), LIT), (floor(4.5, 0.5), LIT), (floor(-4, 0.5), LIT), (floor(2, -1.5), LIT),
            (floor(2, 3.5), LIT), ((-2, 102, 0), LIT), ((2, 102, 0), LIT), ((6, 102, 0), LIT)]),
    }),
    "klein-bottle": dict(solids=1, sheets={"open": 1}, lights={
        "sun": (DOWN, 1024, [(floor(0, 0), LIT), (floor(2.3, 0), DARK), (floor(-2.3, 0), DARK), (floor(1.3, 0.1), DARK),
                             (floor(3.2, 0), LIT), (floor(5, 0), LIT), (floor(0.3, 0.3), LIT)]),
    }),
    # the band is level at x = 2 and upright at x = -2
    "moebius-band": dict(solids=1, sheets={"open": 1}, lights={
        "sun": (DOWN, 1024, [(floor(0, 0), LIT), (floor(2.3, 0), DARK), (floor(1.2, 0), DARK), (floor(2.8, 0), DARK),
                             (floor(-2.3, 0), LIT), (floor(-1.7, 0), LIT), (floor(3.2, 0), LIT), (floor(0, 2), DARK)]),
    }),
    "inside-out-room": dict(solids=3, sheets={"inward": 1}, lights={
        "sun": (SLANTED, 1024, [
            ((0, 1, 2), DARK), ((-3, 2.5, 0), DARK), ((3.5, 0.5, -2), DARK), (floor(2, 0, -1), DARK), (floor(7.8, 0, -1), DARK),
            (floor(8.3, 0, -1), LIT), (floor(-5, 0, -1), LIT), (floor(2, 3.2, -1), LIT), (floor(0, 0, 3), LIT)]),
        "lamp": (None, 1024, [
            ((0, 0.3, 0), DARK), ((2, 0.3, 0), LIT), ((3.5, 0.1, 1.75), DARK), ((-2, 1, 1), LIT), ((0, 2.8, 0), LIT),
            ((3.9, 2, -2.9), LIT), (floor(6, 0, -1), DARK), ((0, 5, 0), DARK), ((-6, 1, 0), DARK)]),
    }),
    "one-triangle": dict(solids=0, sheets={"open": 1}, lights={
        "sun": (SLANTED, 1024, [((0.5, -0.5, 0), DARK), ((2, -2, 0), DARK), ((-0.5, 0.5, 0), LIT), ((-5, 5, 0), LIT)]),
    }),
    "light-in-wall": dict(solids=1, sheets={"occupied": 1}, lights={
        "sun": (SLANTED, 1024, [(floor(2, 0), DARK), (floor(4.3, 0), DARK), (floor(4.7, 0), LIT), (floor(-2, 0), LIT),
                                (floor(2, 4.2), LIT)]),
        "lamp": (None, 1024, [
            (floor(2, 0), DARK), (floor(-3, 3), DARK), (floor(0, 6), DARK), ((0, 6, 0), DARK), ((3, 2, 0), DARK),
            ((0, 1, 0), LIT), ((0, 3.5, 2), LIT), ((0.3, 2, 0), LIT), ((0, 2, -3.8), LIT)]),
    }),
    "caster-behind-light": dict(solids=4, sheets={}, lights={
        "spot": (None, 1024, [
            (floor(0, 0), LIT), (floor(2, 1), LIT), (floor(-3, -1), LIT), (floor(0, 3.8), LIT), ((0, 3.9, 0), LIT),
            (floor(6, 0), OUT), ((0, 4.5, 0), OUT), ((0, 6.5, 0), OUT), ((3, 4.2, 0), OUT)]),
    }),
    "tiny-scene": dict(solids=2, sheets={}, lights={
        "sun": (SLANTED, 1024, [
            (floor(2.5e-7, 0), DARK), (floor(1.1e-7, 0), DARK), (floor(3.9e-7, 0.9e-7), DARK), (floor(0.9e-7, 0), LIT),
            (floor(4.1e-7, 0), LIT), (floor(-3e-7, 0), LIT), (floor(2.5e-7, 1.1e-7), LIT)]),
        "spot": (None, 1024, [
            (floor(0, 0), DARK), (floor(1.5e-7, 0), DARK), (floor(1.8e-7, 0), LIT), (floor(2.5e-7, 1e-7), LIT)]),
    }),
    "far-vertices": dict(solids=2, sheets={}, lights={
        "sun": (SLANTED, 512, [(tuple(a + b for a, b in zip(p, (1e7, 0, -1e7, 0, 0, 0))), lit) for p, lit in [
            (floor(25, 0), DARK), (floor(13, 8), DARK), (floor(37, -8), DARK), (floor(7, 0), LIT), (floor(43, 0), LIT),
            (floor(25, 12), LIT)]]),
    }),
    "huge-and-tiny": dict(solids=102, sheets={}, lights={
        "sun": (SLANTED, 512, [
            (floor(1.5e5, 0), DARK), (floor(0.2e5, 0.8e5), DARK), (floor(2.8e5, 0), DARK), (floor(-0.2e5, 0), LIT),
            (floor(3.2e5, 0), LIT), (floor(1.5e5, 1.2e5), LIT)]),
    }),
    # those of 10 micrometres enclose less than rounding does
    "solid-needles": dict(solids=106, sheets={"inward": 96}, lights={
        "sun": (SLANTED, 512, [(floor(1.5, 5), DARK), (floor(0.2, 4.2), DARK), (floor(-0.2, 5), LIT), (floor(3.2, 5), LIT),
                               (floor(-5, 0), LIT)]),
    }),
    "dust": dict(solids=5002, sheets={}, resolution=256, lights={
        "sun": (SLANTED, 512, [(floor(1.5, -3), DARK), (floor(0.2, -3), DARK), (floor(-0.2, -3), LIT), (floor(3.2, -3), LIT),
                               (floor(2, 1.8), LIT)]),
    }),
    "fan-100000": dict(solids=2, sheets={}, resolution=128, compared=2000, lights={
        "sun": (SLANTED, 512, [
            (floor(3, 0), DARK), (floor(4.9, 0), DARK), (floor(1.1, 0), DARK), (floor(3, 1.9), DARK), (floor(4.3, 1.3), DARK),
            (floor(5.1, 0), LIT), (floor(0.9, 0), LIT), (floor(3, 2.1), LIT), (floor(4.5, 1.5), LIT)]),
    }),
    # two that touch at a corner are apart, two that have an edge in common are one component
    "bow-ties": dict(solids=4, sheets={"open": 4}, lights={
        "sun": (SLANTED, 512, [
            (floor(-1.8, 0), DARK), (floor(-0.7, 0.2), DARK), (floor(1.8, 1.5), DARK), (floor(0, 1), LIT), (floor(0, -1), LIT),
            (floor(-2.8, 4.5), DARK), (floor(-2, 4.2), DARK), (floor(-2, 5.9), DARK), (floor(-1.2, 4.5), LIT),
            (floor(4.5, -5), DARK), (floor(6.8, -5), DARK), (floor(4.5, -3.8), LIT), (floor(2.5, 4.5), DARK), (floor(4.5, 5.5), DARK),
            (floor(2.5, 5.5), LIT), (floor(4.3, 0.5), DARK), (floor(6.5, 0.5), DARK), (floor(2.8, 0.5), LIT)]),
    }),
    # the sloped one is a parallelogram: at its far end 2.5 m high and shifted by 0.25 m
    "t-junctions": dict(solids=1, sheets={"open": 2}, lights={
        "sun": (SLANTED, 512, [
            *[(floor(2, -1.9 + 0.19 * n), DARK) for n in range(20)], (floor(0.1, 0), DARK), (floor(4.4, 0.2), DARK),
            (floor(-0.1, 0), LIT), (floor(4.6, 0), LIT), (floor(1, 2.1), LIT), (floor(4.3, -2), LIT)]),
    }),
    "z-fighting": dict(solids=1, sheets={"open": 1}, lights={
        "sun": (SLANTED, 512, [(floor(2, 0), DARK), (floor(0.4, 1.9), DARK), (floor(3.9, -1.9), DARK), (floor(-0.1, 0), LIT),
                               (floor(4.3, 0), LIT), (floor(2, 2.1), LIT)]),
    }),
    # squares of 1 m, the first opaque: beside each other in shadow from x = 0 on
    "checkered-masks": dict(solids=1, sheets={"alpha mask": 2}, lights={
        "sun": (SLANTED, 512, [(floor(0.5 + i, -1.5 + j), LIT if (i + j) % 2 else DARK) for i in range(3) for j in range(4)]
                + [(floor(-0.2, -1.5), LIT), (floor(0.5, -2.2), LIT)]),
    }),
    "touching-27": dict(solids=2, sheets={}, lights={
        "sun": (SLANTED, 512, [(floor(2.5, 0), DARK), (floor(-0.4, 0), DARK), (floor(5.4, 0), DARK), (floor(2.5, 1.4), DARK),
                               (floor(-0.6, 0), LIT), (floor(5.6, 0), LIT), (floor(2.5, 1.6), LIT)]),
    }),
    "common-planes-50": dict(solids=51, sheets={}, lights={
        "sun": (SLANTED, 512, [(floor(1.5, 0), DARK), (floor(-0.9, 0), DARK), (floor(3.9, -1), DARK), (floor(-1.1, 0), LIT),
                               (floor(4.2, 0), LIT), (floor(3.9, 0.3), LIT), (floor(1.5, 1.1), LIT)]),
    }),
    # the middle, two tips, and between tips
    "crossing-itself": dict(solids=2, sheets={}, lights={
        "sun": (SLANTED, 512, [(floor(1.25, 0), DARK), (floor(1.5, 0.4), DARK), (floor(3, 0), DARK), (floor(1.87, 1.7), DARK),
                               (floor(2.9, 1), LIT), (floor(-0.6, 0), LIT), (floor(3.6, 0), LIT)]),
    }),
    "spiral": dict(solids=2, sheets={}, lights={
        "sun": (SLANTED, 512, [(floor(1.5, 0.2), DARK), (floor(-0.3, 0), DARK), (floor(3.3, 0), DARK), (floor(1.5, 1.4), DARK),
                               (floor(-0.7, 0), LIT), (floor(3.7, 0), LIT), (floor(1.5, 1.6), LIT)]),
    }),
}
LIGHTS = [(case, light) for case, of in CASES.items() for light in of["lights"]]

FAULTY = {case: "mesh 1 'broken' primitive 0 (node 1 'broken', material 0 'plain'): accessor 2: position 2 is not finite: 1 triangles left out"
          for case in ("nan-vertices", "infinite-vertices")}  # what the warning says

REFUSED = {  # exit status, and what the line says
    "empty-scene": (5, ["no triangles"]),
    "no-light": (5, ["light"]),
}


@pytest.fixture(scope="module")
def scene(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("stress")

    def make(case):
        path = folder / f"{case}.glb"
        if not path.exists():
            vxs("scene", "stress", "--case", case, "-o", path)
        return path

    return make


@pytest.fixture(scope="module")
def exact_path(vxs_path):
    path = (ROOT / os.environ.get("EXACT", vxs_path.parent / "tests" / "exact" / "exact")).resolve()
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it, or set EXACT")
    return path


@pytest.fixture(scope="module")
def baked(vxs, scene, tmp_path_factory):
    """bake(case, light): the asset and the report. Spots and points are skipped where they cannot be baked as what they are."""
    folder = tmp_path_factory.mktemp("baked")
    done = {}

    def bake(case, light):
        if (case, light) not in done:
            path = folder / f"{case}-{light}.vxs"
            resolution = CASES[case]["lights"][light][1]
            report = json.loads(vxs("bake", scene(case), "--light", light, "--resolution", resolution,
                                    "-o", path, "--json", "-").stdout)
            done[case, light] = path, report
        path, report = done[case, light]
        (of,) = json.loads(vxs("info", path, "--json", "-").stdout)["lights"]
        if light != "sun" and of["kind"] == "directional":
            pytest.skip("spot and point lights are baked as directional ones")
        return path, report

    return bake


def lines_of(points):
    return "".join(" ".join(map(repr, map(float, p))) + "\n" for p, _ in points)


def answers(text):
    return [word if word == OUT else float(word) for word in text.split()]


def test_every_case_has_its_test(vxs):
    listed = [line.split()[0] for line in vxs("scene", "stress", "--case", "list").stdout.splitlines()]
    assert sorted(listed) == sorted({*CASES, *FAULTY, *REFUSED})


def test_every_case_is_documented(vxs):
    text = (ROOT / "scenes" / "README.md").read_text()
    for line in vxs("scene", "stress", "--case", "list").stdout.splitlines():
        name, purpose = line.split(maxsplit=1)
        assert f"| `{name}` | " in text and len(purpose) > 10


@pytest.mark.parametrize("case", sorted({*CASES, *FAULTY, *REFUSED}))
def test_same_bytes_again(vxs, scene, tmp_path, case):
    vxs("scene", "stress", "--case", case, "-o", tmp_path / "again.glb")
    assert (tmp_path / "again.glb").read_bytes() == scene(case).read_bytes()


@pytest.mark.parametrize("case", REFUSED)
def test_refused_with_one_line(vxs, scene, tmp_path, case):
    status, words = REFUSED[case]
    done = vxs("bake", scene(case), "-o", tmp_path / "a.vxs", status=status)
    assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1 and all(w in done.stderr for w in words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("case", FAULTY)
def test_a_fault_costs_its_part(vxs, scene, tmp_path, case):
    for command in (("plan",), ("bake", "-o", tmp_path / "a.vxs", "--resolution", 256)):
        done = vxs(command[0], scene(case), *command[1:])
        assert done.stderr.startswith("vxs: warning: ") and done.stderr.count("\n") == 1 and FAULTY[case] in done.stderr
        assert FAULTY[case] in vxs(command[0], scene(case), *command[1:], "--strict", status=1).stderr


@pytest.mark.parametrize("case, light", LIGHTS)
def test_rays_say_what_was_worked_out(vxs, scene, case, light):
    """The expectation itself, before anything is baked."""
    points = CASES[case]["lights"][light][2]
    found = answers(vxs("truth", scene(case), "--light", light, input=lines_of(points)).stdout)
    assert [(p, a) for (p, lit), a in zip(points, found, strict=True) if a != lit] == []


@pytest.mark.parametrize("case, light", LIGHTS)
def test_baked_light_is_what_was_worked_out(vxs, baked, case, light):
    path, _ = baked(case, light)
    points = CASES[case]["lights"][light][2]
    found = answers(vxs("query", path, input=lines_of(points)).stdout)
    assert [(p, a) for (p, lit), a in zip(points, found, strict=True) if a != lit] == []


@pytest.mark.parametrize("case, light", LIGHTS)
def test_casters_are_told_apart(baked, case, light):
    casters = baked(case, light)[1]["casters"]
    expected = CASES[case]
    assert casters["solids"]["components"] == expected["solids"]
    assert {k: v["components"] for k, v in casters["sheets"].items() if v["components"]} == expected["sheets"]
    assert casters["collapsed_triangles"] == expected.get("collapsed", 0)


@pytest.mark.parametrize("case, light", LIGHTS)
def test_no_answer_is_unexplained(vxs, scene, baked, case, light):
    path, _ = baked(case, light)
    vxs("validate", path)
    points = CASES[case].get("compared", 20000)
    report = json.loads(vxs("compare", scene(case), path, "--points", points, "--json", "-").stdout)["assets"][0]
    assert report["unexplained"] == 0 and report["wrong_share"] < 0.03 and report["checked"] > points / 2


@pytest.mark.parametrize("case, light", LIGHTS)
def test_every_voxel(exact_path, scene, baked, case, light):
    baked(case, light)
    resolution = CASES[case].get("resolution", 512)
    done = subprocess.run([exact_path, scene(case), "--light", light, "--resolution", str(resolution), "--maps", "gl", "--maps", "sparse"],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [counts["maps"] for counts in found] == [found[0]["maps"]] * 2
    for counts in found:
        assert counts["voxels"] == counts["maps"] * resolution**3 and counts["wrong_lit"] + counts["wrong_shadow"] == 0


@pytest.mark.parametrize("resolution", [8, 16384])
def test_one_triangle_at_the_ends_of_resolution(vxs, exact_path, scene, tmp_path, resolution):
    path = scene("one-triangle")
    vxs("bake", path, "--resolution", resolution, "-o", tmp_path / "a.vxs")
    points = CASES["one-triangle"]["lights"]["sun"][2]
    found = answers(vxs("query", tmp_path / "a.vxs", input=lines_of(points)).stdout)
    assert found == [lit for _, lit in points]
    vxs("compare", path, tmp_path / "a.vxs", "--points", 20000)
    columns = ["--columns", "200000"] if resolution > 512 else []
    done = subprocess.run([exact_path, path, "--resolution", str(resolution), *columns], capture_output=True, text=True,
                          timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("rule", ["greedy", "shadow"])
@pytest.mark.parametrize("closed", ["on", "off"])
@pytest.mark.parametrize("case", ["nested-100", "coplanar-duplicates", "klein-bottle", "inside-out-room", "zero-area-and-needles"])
def test_every_voxel_whatever_is_solid(exact_path, scene, case, closed, rule):
    done = subprocess.run([exact_path, scene(case), "--light", "sun", "--resolution", "256", "--closed", closed, "--rule", rule],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_no_light_but_the_one_asked_for(vxs, scene, tmp_path):
    """What a scene without lights lacks, --sun gives."""
    vxs("bake", scene("no-light"), "--sun", SLANTED, "--resolution", 256, "-o", tmp_path / "a.vxs")
    points = [(floor(2.5, 0), DARK), (floor(0, 0), LIT), (floor(2.5, 1.5), LIT)]
    assert answers(vxs("query", tmp_path / "a.vxs", input=lines_of(points)).stdout) == [lit for _, lit in points]
