# What a plan shows of a bake that would be of little use is said by name, with a remedy, and the remedy ends it; a good scene hears
# nothing.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import math
import random
import re
import shlex
import subprocess

import pytest

import punctual
from named_scene import cube, dome, inside_out, join, light, node, plane, write
from small_scene import NOON, box

LOW = ("--resolution", 512)
SUN = light("sun", "directional")
LAMP = light("lamp", "point", (0, 4, 0))


@pytest.fixture
def said(vxs, tmp_path):
    """said(nodes, lights, *options): the warnings of a plan; those of a bake are the same, and --strict refuses both."""

    def run(nodes, lights, *options, bake=False, **rest):
        path = write(tmp_path / "scene.gltf", nodes, lights, **rest)
        lines = vxs("plan", path, *(options or LOW)).stderr.splitlines()
        assert all(line.startswith("vxs: warning: ") for line in lines)
        if bake:
            out = tmp_path / "a.vxs"
            done = vxs("bake", path, "-o", out, *(options or LOW), "--json", tmp_path / "a.json")
            assert done.stderr.splitlines() == lines
            assert json.loads((tmp_path / "a.json").read_text())["warnings"] == [line.removeprefix("vxs: warning: ") for line in lines]
            out.unlink()
            for command in ("bake", "plan") if lines else ():
                strict = vxs(command, path, "-o", out, *(options or LOW), "--strict", status=1).stderr
                assert strict == lines[0].replace("warning", "error") + " (--strict: a warning is an error)\n"
                assert not out.exists()
        return [line.removeprefix("vxs: warning: ") for line in lines]

    return run


def crates(count=10):
    """A row of crates of 1 m on a ground of 24 m."""
    return [node("ground", box((-12, -1, -12), (12, 0, 12)))] + [
        node(f"crate{n}", cube(), (2.2 * n - 10, 0.5, 3)) for n in range(count)]


def remedy(text):
    """The options that a warning gives, as a shell would read them: the patterns that are to be left out."""
    return [word for found in re.findall(r"(--exclude (?:'[^']*'|\S+))", text) for word in shlex.split(found)]


# --- lights that one object hides ---------------------------------------------------------------------------------------------

TWO_SIDED = {"doubleSided": True}
SIX_PLANES = join(*(([p[:] for p in positions], triangles) for positions, triangles in (
    ([[s * 50 if axis == a else c for a, c in enumerate((49.9 * u, 49.9 * v, 0) if axis == 2 else (49.9 * u, 0, 49.9 * v) if axis == 1
                                                       else (0, 49.9 * u, 49.9 * v))] for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))],
     [(0, 1, 2), (0, 2, 3)]) for axis in range(3) for s in (-1, 1))))


@pytest.mark.parametrize("sky, sun", [
    (node("SkyBox", inside_out(cube(400))), NOON),
    (node("Sky dome", inside_out(dome(60, lowest=0))), (1, -0.7, 0.2)),
    (node("dome", dome(60)), NOON),  # as three.js writes what is seen from inside
    (node("dome", dome(60), material=TWO_SIDED), (-1, -0.4, 0.3)),
    (node("six", SIX_PLANES, material=TWO_SIDED), NOON),  # planes that do not touch: one node
    (node("clouds", inside_out(plane(300, 40))), NOON),
], ids=lambda value: value[0] if isinstance(value[0], str) else None)
def test_a_sky_keeps_the_sun_out(said, sky, sun):
    nodes, lights = [*crates(), sky], [light("sun", "directional", direction=sun)]
    found = [text for text in said(nodes, lights) if "shadow of" in text]
    pattern = f"node:{sky[0]}" if " " not in sky[0] else f"'node:{sky[0]}'"
    assert found == [f"light 'sun': all else is in the shadow of node '{sky[0]}'; if that is a sky or a cover, leave that out with "
                     f"--exclude {pattern}"]
    assert said(nodes, lights, *LOW, *remedy(found[0])) == []


@pytest.mark.parametrize("lamp, hider, at", [
    (LAMP, node("bulb", dome(0.1)), (0, 4, 0)),
    (LAMP, node("bulb", inside_out(dome(0.1)), material=TWO_SIDED), (0, 4, 0)),
    (LAMP, node("slab", box((-3, -0.2, -3), (3, 0.2, 3))), (0, 4, 0)),  # the lamp is stuck in it
    (light("lamp", "point", (0, 8, 0)), node("false ceiling", box((-40, 0, -40), (40, 0.1, 40))), (0, 6, 0)),
    (light("lamp", "point", (0, -6, 0)), node("terrain", plane(60)), (0, 0, 0)),  # it hangs below the floor
    (light("lamp", "spot", (0, 5, 0)), node("lens", box((-0.1, 0, -0.1), (0.1, 0.01, 0.1))), (0, 4.9, 0)),
], ids=["bulb", "inward bulb", "inside of a solid", "over a ceiling", "under the floor", "lens"])
def test_an_object_keeps_a_lamp_in(said, lamp, hider, at):
    name, mesh, _, rest = hider
    nodes = [*crates()[name == "terrain":], node(name, mesh, at, **rest)]
    found = said(nodes, [lamp])
    assert len(found) == 1 and f"light 'lamp': all else is in the shadow of node '{name}', " in found[0] and "move the light, or " in found[0]
    assert said(nodes, [lamp], *LOW, *remedy(found[0])) == []


WALLS = [node("roof", box((-5, 4, -5), (5, 4.2, 5))), node("west", box((-5, 0, -5), (-4.8, 4, 5))),
         node("north", box((-5, 0, -5), (5, 4, -4.8))), node("south", box((-5, 0, 4.8), (5, 4, 5)))]
FURNITURE = [node("table", cube(1), (0, 0.5, 0)), node("bed", cube(1.5), (-3, 0.75, 2))]


@pytest.mark.parametrize("nodes, lights", [
    (crates(), [SUN, LAMP]),
    ([*WALLS, *FURNITURE, node("floor", plane(10))], [light("sun", "directional", direction=(-1, -0.5, 0)), light("lamp", "point", (0, 3, 0))]),
    ([*crates(), node("house", box((-4, 0, -4), (4, 5, 1))), node("table", cube(), (0, 1, -2))], [SUN]),  # lit from outside
    ([*crates(), node("hall", inside_out(box((-30, -3, -30), (30, 9, 30))))], [LAMP]),  # lit from inside
    ([node("room", inside_out(box((-2, -0, -2), (2, 3, 2))), (0, 0, 30)), *crates()], [light("lamp", "point", (0, 2, 30))]),
    ([*crates(), node("shade", dome(0.3, lowest=0), (0, 4, 0), material=TWO_SIDED)], [LAMP]),  # open below
    ([node("terrain", plane(30)), node("cellar chest", cube(), (0, -5, 0)), node("cellar barrel", cube(), (3, -5, 0))], [SUN]),  # lit from above
    ([node("hills", dome(40, lowest=0), (0, -20, 0)), node("cave chest", cube(), (0, 5, 0)), node("lodge", cube(3), (0, 21, 0))], [SUN]),
], ids=["crates", "room", "house", "hall", "apartment", "shade", "cellar", "cave"])
def test_what_light_comes_past(said, nodes, lights):
    assert said(nodes, lights) == []


def test_many_lamps_that_are_hidden(said):
    """Three have a line each, the rest one for all."""
    places = [(3 * x, 4, 3 * z) for x in range(5) for z in range(4)]
    nodes = [*crates(), *(node(f"bulb{n}", dome(0.1), at) for n, at in enumerate(places))]
    found = said(nodes, [light(f"lamp{n}", "point", at) for n, at in enumerate(places)], "--resolution", 32)
    assert [re.match("light 'lamp.': all else is in the shadow of node 'bulb(.)'", text)[1] for text in found[:3]] == ["0", "1", "2"]
    assert found[3].startswith("17 more lights are hidden from all else in this way: lamp3, lamp4, ") and len(found) == 4


def test_hidden_lights_are_dark_by_ray_tracing(vxs, tmp_path):
    """Of lamps at random places among random boxes, those of which it is reported light nothing but the box that hides them."""
    random.seed(5)
    boxes = [node(f"box{n}", cube(random.uniform(0.5, 6)), [random.uniform(-10, 10) for _ in range(3)]) for n in range(24)]
    lights = [light(f"l{n}", "point", [random.uniform(-10, 10) for _ in range(3)]) for n in range(60)]
    path = write(tmp_path / "boxes.gltf", boxes, lights)
    hidden = {}
    for n in range(60):  # one by one, so that each has a line of its own
        text = vxs("plan", path, "--resolution", 16, "--light", f"l{n}").stderr
        if found := re.search(r"light 'l\d+': all else is in the shadow of node '(box\d+)'", text):
            hidden[n] = found[1]
    assert 5 <= len(hidden) <= 40
    points, owners = [], []
    for name, (positions, _), at, _ in boxes:
        half = positions[7][0]
        for _ in range(40):
            p, axis = [random.uniform(-half, half) for _ in range(3)], random.randrange(3)
            p[axis] = random.choice((-1, 1)) * (half + 1e-3)
            points.append(" ".join(str(a + c) for a, c in zip(at, p)))
            owners.append(name)
    rows = [line.split() for line in vxs("truth", path, input="\n".join(points)).stdout.splitlines()]
    for n, name in hidden.items():
        lit = [float(row[n]) for row, owner in zip(rows, owners) if owner != name]
        assert sum(lit) <= 0.05 * len(lit), (n, name)
    dark = [n for n in range(60) if not sum(float(row[n]) for row in rows)]
    assert set(dark) <= set(hidden), "a lamp that lights nothing at all is stuck in one box"


# --- objects that make maps coarse --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("far, names", [
    ([node("forgotten", cube(), (20000, 0, 0))], "node 'forgotten'"),
    ([node("sea", plane(16000, -1))], "node 'sea'"),
    ([node("sea", plane(9000, -1)), node("lost", cube(), (0, 0, -5000)), node("lost too", cube(), (2, 0, -5000))],
     "node 'lost', node 'lost too', node 'sea'"),
    ([node("", plane(16000, -1), mesh_name="Plane")], "mesh 'Plane'"),
    ([node("", plane(16000, -1), material={"name": "Water"})], "material 'Water'"),
    ([node("", plane(16000, -1))], "node 11"),
    ([node("crate3", plane(16000, -1))], "node 'crate3'"),  # another has that name
], ids=["crate", "sea", "several", "mesh", "material", "nameless", "twin"])
def test_objects_that_make_texels_large(said, vxs, tmp_path, far, names):
    nodes = [*crates(), *far]
    found = said(nodes, [SUN], "--resolution", 4096)
    assert len(found) == 1 and f" triangles, {names}, make texels of light 'sun' " in found[0]
    assert said(nodes, [SUN], "--resolution", 4096, *remedy(found[0])) == []
    region = re.search(r"--region (\S+),", found[0])[1]
    assert said(nodes, [SUN], "--resolution", 4096, "--region", region) == []
    times, texel = map(float, re.search(r"'sun' (\S+) times as large, (\S+) m: ", found[0]).groups())
    texels = [json.loads(vxs("plan", tmp_path / "scene.gltf", "--json", "-", *rest).stdout)["lights"][0]["texel_at_casters_m"]["median"]
              for rest in ((), remedy(found[0]))]
    assert texels[0] == pytest.approx(texel, rel=0.01) and texels[0] / texels[1] == pytest.approx(times, rel=0.02)


def test_an_object_that_makes_depths_large(said):
    found = said([*crates(), node("moon", cube(), (0, 15000, 0))], [SUN], "--resolution", 4096)
    assert len(found) == 1 and "node 'moon', make depths of light 'sun' " in found[0] and "times as deep, 3.67 m" in found[0]


def test_a_wide_ground_is_no_mistake(said):
    """Ten times as wide as what stands on it, in fine texels; and without a sun nothing is wide."""
    assert said([node("ground", plane(40)), *crates()[1:6]], [SUN], "--resolution", 4096) == []
    assert said([*crates(), node("sea", plane(16000, -1))], [LAMP], "--resolution", 4096) == []


# --- texels that are larger than things ---------------------------------------------------------------------------------------


def test_a_lamp_far_above(said):
    nodes, far = crates(), light("far", "point", (0, 2000, 0))
    found = said(nodes, [far], "--resolution", 4096)
    assert len(found) == 1 and re.match(r"light 'far' is 2000 m from what it lights, where a texel is 0.9\d+ m, and 10 of 11 components", found[0])
    assert "make it a sun, or a spot that lights these alone" in found[0]
    side = re.search(r"--resolution (\d+)", found[0])[1]
    assert said(nodes, [far], "--resolution", side) == []
    assert said(nodes, [far, LAMP], "--resolution", 4096)[0].count(f"--resolution far={side}") == 1
    assert said(nodes, [light("far", "spot", (0, 30, 0))], "--resolution", 4096) == []


def test_texels_at_casters(vxs, tmp_path):
    """Of a spot over a floor all alike; of a bulb from straight below to where its range ends; of a sun, everywhere."""
    path = write(tmp_path / "floor.gltf", [node("floor", plane(40))],
                 [light("spot", "spot", (0, 5, 0)), light("bulb", "point", (0, 5, 0), reach=20), SUN])
    plan = json.loads(vxs("plan", path, "--json", "-").stdout)["lights"]
    spot, bulb, sun = (one["texel_at_casters_m"] for one in plan)
    assert all(value == pytest.approx(5 * math.tan(0.6) / (2048 - 26), rel=1e-6) for value in spot.values())
    at_1_m = 1 / (2048 - 26)
    assert bulb["least"] == pytest.approx(5 * at_1_m, rel=0.01) and bulb["most"] == pytest.approx(375 ** 0.5 * at_1_m, rel=0.1)
    half = (375 * math.pi / 2) ** 0.5 / 2  # the largest coordinate counts: half of the disc is within a square of that half side
    assert bulb["median"] == pytest.approx(half * at_1_m, rel=0.1)
    assert sun["least"] == sun["median"] == sun["most"] == pytest.approx(40 / 4094, rel=1e-3)
    baked = json.loads(vxs("bake", path, "-o", tmp_path / "a.vxs", "--json", "-").stdout)
    assert [one["texel_at_casters_m"] for one in baked["lights"]] == [spot, bulb, sun] == [
        one["texel_at_casters_m"] for one in baked["plan"]["lights"]]
    text = vxs("plan", path, "--light", "bulb", "--verbose").stdout
    assert re.search(r"texels of 0\.0024\d+ to 0\.009\d+ m at casters, median 0\.00\d+ m", text)


def test_texels_larger_than_components(said):
    stones = [node("gravel", join(*(cube(0.05, (x, 0, z)) for x in range(20) for z in range(20)))), node("floor", plane(20))]
    found = said(stones, [SUN], "--resolution", 256)
    assert len(found) == 1 and re.match(r"light 'sun': a texel is 0.1\d+ m, and 400 of 400 components are narrower", found[0])
    side = re.search(r"--resolution (\d+)", found[0])[1]
    assert said(stones, [SUN], "--resolution", side) == []


def test_texels_finer_than_shadows_are_seen(said):
    things = [node(f"thing{n}", cube(0.9), (n, 0, 0)) for n in range(3)]
    found = said(things, [SUN], "--resolution", 16384)
    assert len(found) == 1 and re.match(r"light 'sun': a texel is 0.1\d mm, and most components are more than 4096 texels wide", found[0])
    side = re.search(r"--resolution (\d+)", found[0])[1]
    assert said(things, [SUN], "--resolution", side) == [] == said(things, [SUN], "--resolution", 4096)
    assert said(crates(), [SUN], "--resolution", 16384) == []


def test_leaves_shade_together(said):
    """Cards of two triangles, and trees that are nodes: none is requested alone."""
    leaves = join(*(([(x, 3, z), (x + 0.05, 3, z), (x, 3, z + 0.05), (x + 0.05, 3, z + 0.05)], [(0, 2, 1), (1, 2, 3)])
                    for x in range(10) for z in range(10)))
    tree = join(*(cube(0.1, (x / 5, 3, z / 5)) for x in range(10) for z in range(10)))
    assert said([node("leaves", leaves), node("floor", plane(20))], [SUN], "--resolution", 64) == []
    assert said([*(node(f"tree{n}", tree, (4 * n, 0, 0)) for n in range(6)), node("floor", plane(30))], [SUN], "--resolution", 128) == []


# --- ranges -------------------------------------------------------------------------------------------------------------------


def test_a_range_that_ends_at_the_fixture(said):
    nodes = [*crates(), node("lantern", dome(0.3, lowest=0), (0, 9, 0))]
    assert said(nodes, [light("lamp", "point", (0, 8.9, 0), reach=3)]) == [
        "light 'lamp' reaches nothing but node 'lantern': its range is 3 m, and what is next is 8.3 m from it; give it a longer range"]
    assert said(nodes, [light("lamp", "point", (0, 8.9, 0), reach=12)]) == []


def test_ranges_in_metres_of_a_scene_in_centimetres(said, vxs, tmp_path):
    hall = [node("floor", plane(1200)), *(node(f"crate{n}", cube(100), (130 * n - 500, 50, 0)) for n in range(9))]
    short = [light("lamp", "point", (0, 110, 0), reach=20)]
    found = said(hall, short)
    assert len(found) == 1 and "reaches 20 m, no punctual light farther, and 10 of 10 components are wider than 40 m" in found[0]
    assert said(hall, [*short, light("far", "point", (0, 300, 0), reach=900)]) == []
    assert said(hall, [*short, light("endless", "point", (0, 300, 0))]) == []
    path = write(tmp_path / "none.gltf", hall, [light("lamp", "point", (0, 300, 0), reach=20)])
    text = vxs("plan", path, status=5).stderr
    assert "as of one in centimetres" in text and "no light reaches a caster" in text, "said before the error"


# --- scenes -------------------------------------------------------------------------------------------------------------------


def test_a_flat_scene(said):
    tilted = ([(0, 0, 0), (4, 1, 0), (0, 2, 5), (4, 3, 5)], [(0, 2, 1), (1, 2, 3)])
    assert said([node("sheet", tilted)], [SUN]) == [
        "all that casts shadows lies in one plane, and shades nothing: 2 triangles; bake it with what stands on it"]
    tilted[0][3] = (4, 3.01, 5)
    assert said([node("sheet", tilted)], [SUN]) == []


def test_a_tiny_place(said):
    """Of many parts; one thing may be as small."""
    assert any("too small for anything" in text for text in said([node("all", join(*(cube(0.001, (n / 250, 0, 0)) for n in range(20))))], [SUN]))
    assert said([node("ring", dome(0.01))], [SUN]) == []


def test_a_sun_that_was_never_turned(said):
    text = ("light 'sun' travels level, along -Z, as a node without a rotation has it: sunlight comes from above; turn its node, or give "
            "--sun X,Y,Z")
    assert said(crates(), [light("sun", "directional", direction=None)]) == [text]
    assert said(crates(), [light("sun", "directional", direction=(0, -0.01, -1))]) == []
    assert said(crates(), [], *LOW, "--sun", "0,0,-1") == [], "it was asked for"
    assert said(crates(), [light("lamp", "spot", (0, 1, 12), direction=None)]) == []


@pytest.mark.parametrize("name, pattern", [("UCX_house_01", "node:UCX_*"), ("wall-colonly", "node:*-colonly"), ("level-navmesh", "node:*-navmesh"),
                                           ("door_collider", "node:door_collider"), ("Collision", "node:Collision")])
def test_shapes_for_collisions(said, name, pattern):
    nodes = [*crates(), node(name, cube(1.2), (0, 0.6, 0)), node("crate", cube(), (0, 0.5, 0))]
    assert said(nodes, [SUN]) == [f"node '{name}' is named like a shape for collisions, which is not seen, and casts shadows of 12 triangles; "
                                  f"leave it out with --exclude '{pattern}'"]
    assert said(nodes, [SUN], *LOW, "--exclude", pattern) == []
    more = [*nodes, node("UCX_other", cube(1.2), (5, 0.6, 0))]
    assert "and 1 more are named like shapes for collisions, which are not seen, and cast shadows of 24 triangles" in said(more, [SUN])[0]


def test_levels_of_detail(said):
    rock = [node("Rock_LOD0", dome(1, 12, 24), (0, 1, 0)), node("Rock_LOD1", dome(1, 4, 8), (0, 1, 0)), node("Rock_LOD2", cube(1.3), (0, 1, 0))]
    found = said([*crates(), *rock], [SUN])
    assert found == ["node 'Rock_LOD1' is a coarser 'Rock_LOD0' in the same place, and there are more: only one level of detail is seen, and "
                     "all cast shadows; leave the others out with --exclude 'node:*_LOD[1-9]*'"]
    assert said([*crates(), *rock], [SUN], *LOW, "--exclude", "node:*_LOD[1-9]*") == []
    apart = [node(name, mesh, (5 * n - 5, 1, 0)) for n, (name, mesh, _, _) in enumerate(rock)]
    assert said([*crates(), *apart], [SUN]) == [], "side by side, as on a sheet"
    assert said([*crates(), rock[1], node("Tree_LOD0", cube(), (0, 1, 0))], [SUN]) == [], "of two things"


def test_positions_far_from_their_origin(said):
    """As floats they are coarse; by the translation of the node they are not."""
    site = (1661274.3, 16.6, -8178659.7)
    far = [node("site", box(*([a + c for a, c in zip(site, corner)] for corner in ((-4, 0, -4), (4, 3, 4))))),
           node("shed", box(*([a + c for a, c in zip(site, corner)] for corner in ((6, 0, -1), (9, 3, 4)))))]
    found = [text for text in said(far, [SUN]) if "floats" in text]
    assert found == ["node 0 'site' and 1 more: positions are floats 8180000 m from the origin of the node, in steps of 0.5 m; store them near "
                     "it, and place them by the translation of the node"]
    assert said([node("site", cube(8), site), node("shed", cube(3), [a + c for a, c in zip(site, (9, 0, 3))])], [SUN]) == []
    assert said([node("terrain", plane(60000)), node("hill", dome(9000, lowest=0))], [SUN]) == [], "large, not far"


# --- files of others ----------------------------------------------------------------------------------------------------------

CASES = {"sky_box_all_dark": "shadow of node 'SkyBox'", "lamp_in_its_bulb_all_dark": "shadow of node 'bulb'",
         "stray_object_texel_5m": "node 'forgotten', make texels", "large_plane_texel_4m": "node 'sea', make texels",
         "far_point_light": "'far sun' is 2000 m from what it lights"}


@pytest.mark.parametrize("name, text", CASES.items())
def test_cases(vxs, cases, tmp_path, name, text):
    path = cases / "files" / "useless_bakes" / f"{name}.gltf"
    for command in (("plan", path), ("bake", path, "-o", tmp_path / "a.vxs")):
        found = vxs(*command).stderr
        assert text in found and found.count("\n") == 1
        assert text in vxs(*command, "--strict", status=1).stderr


@pytest.mark.long
def test_real_scenes(vxs_path, scenes):
    """All of them, from three suns: what is said is right. A town in the middle of a wide plane; a cave, and a closed room; files of one sheet."""
    said = {"truck_town.glb": "node 'OuterGroundMesh', make texels", "camp_and_cave_two_scenes.glb": "shadow of node 'mesh96187052'",
            "room_with_spheres_closed.glb": "shadow of node 'Cube'", "Mesh_PrimitiveMode": "in one plane", "TriangleWithoutIndices": "in one plane"}
    known = ("morph targets", "skinned meshes", "points skipped", "alphaMode BLEND", "KHR_materials_transmission", "has no alpha", "moved by animations", "at the same place", "glTF: ")  # of the file, not of the bake
    real = scenes / "real"
    for path in sorted([*real.glob("*.glb"), *(real / "features").rglob("*.gl*"), *(real / "encodings").rglob("*.gl*")]):
        for sun in ((), ("--sun=-0.4,-1,-0.2",), ("--sun=0,-1,0",), ("--sun=1,-0.3,0.2",)):
            done = subprocess.run([vxs_path, "plan", path, *sun], capture_output=True, text=True)
            lines = [line for line in done.stderr.splitlines() if "warning" in line and not any(text in line for text in known)]
            expected = [text for name, text in said.items() if name in path.name and sun and done.returncode == 0]
            assert len(lines) == len(expected) and all(text in line for text, line in zip(expected, lines)), (path, sun, lines)


@pytest.mark.parametrize("kind", ["city", "city --spots 40", "landscape", "room", "forest", "smoke", "hair"])
def test_made_scenes(vxs, tmp_path, kind):
    vxs("scene", *kind.split(), "-o", tmp_path / "made.glb")
    assert vxs("plan", tmp_path / "made.glb").stderr == ""
