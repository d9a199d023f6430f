# Several suns by name, the size of a map by its light, lights of a file by name, and rays that query as a filter does.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import random

import jsonschema
import pytest

import small_scene
from conftest import ROOT
from small_scene import MORNING, NOON

LIGHTS = (("sun", "directional", NOON), ("spot", "spot", NOON), ("lamp", "point", NOON))
SMALL = ("--resolution", 64)
UNDER, BESIDE, AGAINST = "0 0.5 0\n", "2 0.5 0\n", "-2 0.5 0\n"  # the block's shadow at noon, in the morning, and in the evening


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The block under a sun, a spot of 30 degrees to each side, and a lamp that reaches 7 m, both 6 m above the ground."""
    at = tmp_path_factory.mktemp("lights")
    path = small_scene.write(at / "small.gltf", lights=LIGHTS)
    gltf = json.loads(path.read_text())
    _, spot, lamp = gltf["extensions"]["KHR_lights_punctual"]["lights"]
    spot["spot"]["outerConeAngle"] = 0.5235987755982988
    lamp["range"] = 7
    path.write_text(json.dumps(gltf))
    return at


@pytest.fixture
def bake(vxs, folder, tmp_path):
    """bake(*options): what bake and plan say, which agree, checked against their schemas; the asset is a.vxs."""

    def run(*options):
        vxs("bake", folder / "small.gltf", "-o", tmp_path / "a.vxs", "--json", tmp_path / "a.json", *options)
        report = json.loads((tmp_path / "a.json").read_text())
        plan = json.loads(vxs("plan", folder / "small.gltf", "--json", "-", *options).stdout)
        for name, value in (("bake-report", report), ("plan", plan)):
            jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / f"{name}.schema.json").read_text())).validate(value)
        assert report["options"] == plan["options"] and report["plan"]["lights"] == plan["lights"]
        return report

    return run


@pytest.fixture
def fails(vxs, folder, tmp_path):
    """fails(says, *options): the same error of bake and plan, before anything is written."""

    def run(says, *options):
        for command in ("bake", "plan"):
            done = vxs(command, folder / "small.gltf", "-o", tmp_path / "a.vxs", *options, status=2)
            assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1 and says in done.stderr, done.stderr
        assert not (tmp_path / "a.vxs").exists()

    return run


# --- several suns -------------------------------------------------------------------------------------------------------------

SUNS = ("--sun", "evening=-1,-1,0", "--sun", "1,-3,0", "--sun", "noon=0,-1,0")


@pytest.mark.parametrize("options, names", [
    (SUNS, ["evening", "sun", "noon"]),
    ((*SUNS, "--light", "noon", "--light", "lamp"), ["noon", "lamp", "evening", "sun"]),
    (("--sun=a=b=-1,-1,0", "--sun=spot=0,-1,0"), ["a=b", "spot"]),  # a name with '=', and the scene's spot is a sun now
    (("--sun", "evening=-1,-1,0", "--light", "sun"), ["sun", "evening"]),  # the scene's own
])
def test_several_suns(vxs, bake, folder, tmp_path, options, names):
    report = bake(*SMALL, *options)
    assert [light["name"] for light in report["lights"]] == names
    assert {light["name"] for light in report["lights_left_out"]} == {"sun", "spot", "lamp"} - set(names)
    points = UNDER + BESIDE + AGAINST
    baked = [list(line) for line in zip(*(line.split() for line in vxs("query", tmp_path / "a.vxs", input=points).stdout.splitlines()))]
    traced = vxs("truth", folder / "small.gltf", *options, input=points).stdout
    assert traced == vxs("query", tmp_path / "a.vxs", input=points).stdout, "truth takes the same suns"
    shadows = {"noon": "011", "evening": "110", "a=b": "110", "spot": "011", "lamp": "011", "sun": "011"}
    assert ["".join(column) for column in baked] == [shadows[name] for name in names]


def test_suns_stand_in_the_report(bake):
    options = bake(*SMALL, *SUNS, "--light", "noon")["options"]
    assert options["sun"] == {"evening": [-1, -1, 0], "sun": [1, -3, 0], "noon": [0, -1, 0]} and options["light"] == ["noon"]
    assert "sun" not in bake(*SMALL)["options"]


@pytest.mark.parametrize("options, says", [
    (("--sun", "noon=0,-1,0", "--sun", "noon=1,-1,0"), "--sun is given twice for 'noon'"),
    (("--sun", "0,-1,0", "--sun", "sun=1,-1,0"), "--sun is given twice for 'sun'"),
    (("--sun", "=0,-1,0"), "--sun =0,-1,0: expected a name before the '='"),
    (("--sun", "noon=0,-1"), "--sun noon=0,-1: expected 3 numbers"),
    (("--sun", "noon="), "expected 3 numbers"),
    (("--sun", "noon=0,0,0"), "--sun noon=0,0,0: expected a direction"),
    (("--sun", "x" * 64 + "=0,-1,0"), "the name has 64 bytes, expected 1 to 63"),
    (("--sun", "noon=0,-1,0", "--light", "dusk"), "--light dusk: no such light; there are sun (directional, node 1), spot (spot, node 2), lamp (point, node 3), "
     "noon (directional)\n"),
    (("--light", "Sun"), "--light Sun: no such light; there are sun (directional, node 1), spot (spot, node 2), lamp (point, node 3): did you mean 'sun'?\n"),
])
def test_wrong_suns(vxs, fails, folder, options, says):
    fails(says, *options)
    assert says in vxs("truth", folder / "small.gltf", *options, input=UNDER, status=2).stderr


# --- the size of a map, by light ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("options, sizes, texel", [
    (("--resolution", "sun=256", "--resolution", 64), {"sun": 256, "spot": 64, "lamp": 64}, 16 / 254),
    (("--resolution", 64, "--resolution=lamp=32", "--resolution=spot=8"), {"sun": 64, "spot": 8, "lamp": 32}, 16 / 62),
    (("--sun", "a=b=0,-1,0", "--light", "spot", "--resolution", "a=b=128", "--resolution", 16), {"spot": 16, "a=b": 128}, 16 / 126),
    (("--texel", "sun=0.5", "--resolution", 32), {"sun": 64, "spot": 32, "lamp": 32}, 0.5),
    (("--texel", 1, "--resolution", "lamp=16", "--texel", "sun=0.25"), {"sun": 128, "spot": 16, "lamp": 16}, 0.25),
])
def test_sizes_by_light(bake, options, sizes, texel):
    report = bake(*options)
    assert {light["name"]: light["resolution_px"] for light in report["lights"]} == sizes
    assert [light["texel_m"] for light in report["lights"] if light["kind"] == "directional"] == [pytest.approx(texel)]


def test_maps_of_other_sizes_are_not_touched(vxs, bake, tmp_path):
    """A light has the bytes that it has where all lights are of its size."""

    def sections(*options):
        bake(*options)
        data = (tmp_path / "a.vxs").read_bytes()
        listed = json.loads(vxs("info", tmp_path / "a.vxs", "--json", "-").stdout)["sections"]
        parts = {}
        for s in listed:
            if "light" in s:
                parts.setdefault(s["light"], []).append(data[s["offset_bytes"]:s["offset_bytes"] + s["stored_bytes"]])
        return list(parts.values())

    coarse, fine = sections("--resolution", 64), sections("--resolution", 256)
    mixed = sections("--resolution", 64, "--resolution", "spot=256")
    assert len(coarse) == 3 and mixed == [coarse[0], fine[1], coarse[2]] != coarse


def test_sizes_stand_in_the_report(bake):
    options = bake("--resolution", "sun=128", "--texel", "lamp=0.5", "--resolution", 32)["options"]
    assert (options["resolution_px"], options["light_resolution_px"], options["light_texel_m"]) == (32, {"sun": 128}, {"lamp": 0.5})
    options = bake("--texel", 0.5)["options"]
    assert options["texel_m"] == 0.5 and not {"resolution_px", "light_resolution_px", "light_texel_m"} & options.keys()


@pytest.mark.parametrize("options, says", [
    (("--resolution", 64, "--resolution", 128), "--resolution is given twice without a name"),
    (("--resolution", "sun=64", "--resolution", "sun=64"), "--resolution is given twice for 'sun'"),
    (("--texel", 1, "--texel", 1), "--texel is given twice without a name"),
    (("--texel", "lamp=1", "--texel", "lamp=2"), "--texel is given twice for 'lamp'"),
    (("--resolution", 64, "--texel", 1), "exclude each other"),
    (("--resolution", "sun=64", "--texel", "sun=1"), "--resolution sun=64 and --texel sun=1 exclude each other"),
    (("--resolution", "sun=65"), "--resolution sun=65: expected a power of two from 8 to 262144"),
    (("--resolution", "sun=524288"), "--resolution sun=524288: expected a whole number from 8 to 262144"),
    (("--resolution", "sun="), "--resolution sun=: expected a whole number"),
    (("--resolution", "=64"), "expected a name"),
    (("--texel", "sun=0"), "--texel sun=0: expected a number from"),
    (("--texel", "sun=0.00001"), "at least --texel sun="),
    (("--texel", "0.00001", "--light", "spot"), "at least --texel spot="),
    (("--resolution", "son=64"), "--resolution son=64: no light of that name is baked, but sun (directional, node 1), spot (spot, node 2), lamp (point, node 3): "
     "did you mean 'sun'?"),
    (("--texel", "son=0.5"), "--texel son=0.5: no light of that name is baked"),
    (("--light", "lamp", "--resolution", "sun=64"), "--resolution sun=64: no light of that name is baked, but lamp (point, node 3)"),
])
def test_wrong_sizes(fails, options, says):
    fails(says, *options)


@pytest.mark.parametrize("light", ["sun", "spot"])
def test_the_texel_that_is_said_to_be_enough_is_enough(vxs, folder, light):
    options = ("plan", folder / "small.gltf", "--light", light, "--texel")
    said = vxs(*options, f"{light}=0.00001", status=2).stderr
    vxs(*options, said.rpartition("at least --texel ")[2].strip())


# --- lights of a file ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def assets(vxs, folder):
    """Two files: of all lights, and without the spot."""
    for name, options in (("all", ()), ("two", ("--light", "lamp", "--light", "sun"))):
        vxs("bake", folder / "small.gltf", "-o", folder / f"{name}.vxs", "--resolution", 256, *options)
    return folder / "all.vxs", folder / "two.vxs"


def test_compare_of_chosen_lights(vxs, folder, assets):
    def compare(*options):
        report = json.loads(vxs("compare", folder / "small.gltf", *assets, "--points", 500, "--json", "-", *options).stdout)
        jsonschema.Draft202012Validator(json.loads((ROOT / "docs" / "compare.schema.json").read_text())).validate(report)
        for light in (light for asset in report["assets"] for light in asset["lights"]):
            del light["time"]
        return report["assets"]

    every, chosen = compare(), compare("--light", "sun", "--light", "lamp")
    lights = [{light["name"]: light for light in asset["lights"]} for asset in every]
    assert [list(names) for names in lights] == [["sun", "spot", "lamp"], ["lamp", "sun"]]
    for asset, all_of_it, count in zip(chosen, lights, (3, 2)):
        assert asset["lights"] == [all_of_it["sun"], all_of_it["lamp"]], "in the order asked for"
        assert asset["checked"] == sum(light[kind]["checked"] for light in asset["lights"] for kind in ("random", "surface"))
        assert asset["lights_in_file"] == count
    text = vxs("compare", folder / "small.gltf", *assets, "--points", 50, "--light", "lamp", "--verbose").stdout
    assert "all.vxs: 1 of 3 lights, " in text and "two.vxs: 1 of 2 lights, " in text and "light sun" not in text


@pytest.mark.parametrize("command", ["compare", "query", "render"])
def test_lights_that_a_file_lacks(vxs, folder, assets, tmp_path, command):
    """An error that names the file and its lights; with several files, the one that lacks it."""
    files = {"compare": (folder / "small.gltf", *assets), "query": assets[1:],
             "render": (folder / "small.gltf", assets[1], "-o", tmp_path / "a.png")}[command]
    said = vxs(command, *files, "--light", "spot", input="", status=2).stderr
    assert said == f"vxs: error: --light spot: '{assets[1]}' has no light of that name; it has lamp, sun\n"
    assert ": did you mean 'lamp'?\n" in vxs(command, *files, "--light", "lmap", input="", status=2).stderr
    assert "--light sun is given twice" in vxs(command, *files, "--light", "sun", "--light", "sun", input="", status=2).stderr
    assert not list(tmp_path.iterdir())


# --- rays that query as a filter does -------------------------------------------------------------------------------------------


def scattered(seed):
    """Points in the air, not inside a solid, and on the ground with its normal."""
    draw = random.Random(seed)
    air = ([draw.uniform(-8, 8), draw.uniform(0.2, 6), draw.uniform(-8, 8)] for _ in range(3000))
    return "".join([f"{x} {y} {z}\n" for x, y, z in air if max(abs(x), abs(z), abs(y - 2.5) + 0.7) > 1.2] +
                   [f"{draw.uniform(-7, 7)} 0 {draw.uniform(-7, 7)} 0 1 0\n" for _ in range(1500)])


@pytest.mark.parametrize("kind, k", [("--filter", 1), ("--filter", 3), ("--filter", 9), ("--smooth", 4), ("--smooth", 9)])
def test_truth_of_a_filter_is_what_a_query_should_say(vxs, folder, assets, kind, k):
    def ask(*arguments):
        return [line.split() for line in vxs(*arguments, input=scattered(k)).stdout.splitlines()]

    lookups, rays = ask("query", assets[0], kind, k), ask("truth", folder / "small.gltf", "--like", assets[0], kind, k)
    from_points = ask("truth", folder / "small.gltf")
    differ, differ_from_points = 0, 0
    for light in range(3):
        pairs = [(a[light], b[light]) for a, b in zip(lookups, rays, strict=True)]
        assert all((a == "out") == (b == "out") for a, b in pairs) and sum(a != "out" for a, _ in pairs) > 250
        errors = [abs(float(a) - float(b)) for a, b in pairs if a != "out"]
        assert sum(e > 1e-6 for e in errors) < len(errors) / 200 and sum(errors) / len(errors) < 1e-3
        between = sum(0 < float(a) < 1 for a, _ in pairs if a != "out")
        assert between > 5 if k > 1 else between == 0
        differ += sum(e > 0 for e in errors)
        differ_from_points += sum(a[light] != b[light] for a, b in zip(lookups, from_points))
    assert differ < differ_from_points, "single rays know no texel"


def test_truth_like_a_file(vxs, folder, assets):
    """Its lights in its order, or those of --light; its volume; a filter of one texel unless another is requested."""
    def ask(text, *options):
        return vxs("truth", folder / "small.gltf", "--like", assets[1], *options, input=text).stdout

    points = "0 0.5 0\n3 0.5 0\n0 50 0\n0 -50 0\n99 0 0\n1e300 0 0\n0 1e15 0\n0 -1e15 0\n0 6 0\n0 5.999 0\n"
    assert ask(points) == vxs("query", assets[1], input=points).stdout == (
        "0 0\n1 1\nout 1\nout 0\nout out\nout out\nout 1\nout 0\n1 1\n1 1\n"), "far away, and where the lamp is"
    assert ask(points) == ask(points, "--filter", 1)
    assert ask("0 50 0\n", "--light", "sun", "--light", "lamp") == "1 out\n"
    assert ask("3 0 0 0 1 0\n3 0 0 0 -1 0\n", "--filter", 17, "--light", "sun") == "1\n0\n", "moved as a lookup is"


@pytest.mark.parametrize("options, says", [
    (("--filter", 3), "--filter goes with --like FILE.vxs"),
    (("--smooth", 4), "--smooth goes with --like FILE.vxs"),
    (("--like", "all.vxs", "--filter", 3, "--smooth", 4), "--filter and --smooth exclude each other"),
    (("--like", "all.vxs", "--filter", 4), "--filter 4: expected an odd number"),
    (("--like", "all.vxs", "--filter", 19), "from 1 to 17"),
    (("--like", "all.vxs", "--sun", "0,-1,0"), "--sun and --like exclude each other"),
    (("--like", "two.vxs", "--light", "spot"), "has no light of that name; it has lamp, sun"),
])
def test_wrong_filters_of_rays(vxs, folder, assets, options, says):
    options = [folder / o if str(o).endswith(".vxs") else o for o in options]
    said = vxs("truth", folder / "small.gltf", *options, input=UNDER, status=2).stderr
    assert said.startswith("vxs: error: ") and said.count("\n") == 1 and says in said


# --- lights by patterns -------------------------------------------------------------------------------------------------------

NAMES = ("sun", "lamp1", "lamp2", "lamp10", "lamp*", "desk lamp")


@pytest.fixture(scope="module")
def many(vxs, tmp_path_factory):
    """A scene of these lights, all spots but the sun, and the asset of all."""
    at = tmp_path_factory.mktemp("patterns")
    scene = small_scene.write(at / "many.gltf", lights=[(name, "spot" if name != "sun" else "directional", (n / 10, -1, 0))
                                                        for n, name in enumerate(NAMES)])
    vxs("bake", scene, "-o", at / "many.vxs", *SMALL)
    return scene, at / "many.vxs"


@pytest.mark.parametrize("patterns, expected", [
    (["lamp?"], ["lamp1", "lamp2", "lamp*"]),  # in the scene's order
    (["lamp*"], ["lamp*"]),  # which is the name of one
    (["lamp[0-9]*"], ["lamp1", "lamp2", "lamp10"]),
    (["*lamp"], ["desk lamp"]),
    (["#0"], ["sun"]),
    (["lamp10", "lamp??", "lamp1*"], ["lamp10", "lamp1"]),  # what is there already stays where it is
    (["*"], list(NAMES)),
])
def test_lights_by_patterns(vxs, many, tmp_path, patterns, expected):
    scene, asset = many
    options = [word for pattern in patterns for word in ("--light", pattern)]
    plan = json.loads(vxs("plan", scene, *options, "--json", "-").stdout)
    assert [light["name"] for light in plan["lights"]] == expected and plan["options"]["light"] == patterns
    vxs("bake", scene, "-o", tmp_path / "a.vxs", *SMALL, *options)
    assert [light["name"] for light in json.loads(vxs("info", tmp_path / "a.vxs", "--json", "-").stdout)["lights"]] == expected
    one_by_one = " ".join(vxs("query", asset, "--light", name, input=AGAINST).stdout.strip() for name in expected)
    for budget in ((), ("--budget", "4M")):
        assert vxs("query", asset, *options, *budget, input=AGAINST).stdout.strip() == one_by_one
    assert len(vxs("truth", scene, *options, input=AGAINST).stdout.split()) == len(expected)
    assert len(vxs("truth", scene, "--like", asset, *options, input=AGAINST).stdout.split()) == len(expected)
    compared = json.loads(vxs("compare", scene, asset, *options, "--points", 500, "--json", "-").stdout)
    assert [light["name"] for light in compared["assets"][0]["lights"]] == expected


def test_patterns_that_name_no_light(vxs, many):
    scene, asset = many
    known = "sun, lamp1, lamp2, lamp10, lamp*, desk lamp"
    for pattern in ("lump*", "LAMP*", "#6", ""):
        assert f"--light {pattern}: no such light; there are sun (directional, node 1), lamp1 (spot, node 2)" in vxs("plan", scene, "--light", pattern, status=2).stderr
        for budget in ((), ("--budget", "4M")):
            said = vxs("query", asset, "--light", pattern, *budget, input=UNDER, status=2).stderr
            assert f"--light {pattern}: '{asset}' has no light of that name; it has {known}" in said
    for words in (("plan", scene), ("query", asset), ("query", asset, "--budget", "4M")):
        assert "given twice" in vxs(*words, "--light", "lamp1", "--light", "lamp1", input=UNDER, status=2).stderr


def test_a_budget_below_the_least_for_a_pattern(vxs, many):
    """The least is that of the lights that are meant."""
    least = [int(vxs("query", many[1], "--light", light, "--budget", 1, input=UNDER, status=6).stderr.split(" bytes")[0].split()[-1])
             for light in ("lamp1[0]", "lamp10", "*")]
    assert least[0] == least[1] < least[2]
    assert vxs("query", many[1], "--light", "lamp1?", "--budget", least[0], input=UNDER).stdout
