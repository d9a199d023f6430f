# vxs compare and vxs render on a small baked city: an honest asset passes, a wrong one fails and says where.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import subprocess

import jsonschema
import pytest
import small_scene
from png import read_png

SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "docs" / "compare.schema.json"
SUN = "-0.3,-1,-0.2"
POINTS = int(os.environ.get("VXS_COMPARE_POINTS", 50000))  # of each kind, on the real scenes
REAL = ("sponza dream_apartment kaykit_city voxel_district truck_town chess_board room_with_spheres_closed "
        "stanford_bunny_closed low_poly_terrain mountains_heightfield pandora_indoor dutch_ship_mask japanese_bridge_garden "
        "camp_and_cave_two_scenes sunlit_primitives skylight_hall_directional").split()
LARGE = ("voxel_district", "chess_board", "stanford_bunny_closed", "kaykit_city")


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    """Folder with two cities and an asset of the first at two resolutions."""
    at = tmp_path_factory.mktemp("city")
    for seed in (1, 2):
        vxs("scene", "city", "--triangles", 4000, "--blocks", 3, "--seed", seed, "-o", at / f"city{seed}.glb")
    for resolution in (128, 512):
        vxs("bake", at / "city1.glb", "--sun", SUN, "--light", "sun", "--resolution", resolution,
            "-o", at / f"{resolution}.vxs")
    return at


def check_counts(counts, points):
    texels = counts["boundary_texels"]
    assert counts["points"] == points == counts["outside"] + counts["inside_solid"] + counts["left_free"] + counts["checked"]
    assert counts["wrong"] == counts["leaks"] + counts["false_shadows"] == texels["points"] + texels["beyond"]
    assert counts["wrong"] == counts["near_boundary"] + counts["near_surface"] + counts["unexplained"]
    assert counts.get("self_shadows", 0) <= counts["false_shadows"] and counts.get("deep_leaks", 0) <= counts["leaks"]
    if texels["points"]:
        assert 0 < texels["median"] <= texels["p95"] <= texels["max"] <= 8 and 0 < texels["mean"] <= texels["max"]


def check_report(report):
    """Its schema, and its own sums."""
    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(report)
    kinds = ["random", "surface"] + ["camera"] * ("camera" in report)
    pixels = report["camera"]["width_px"] * report["camera"]["height_px"] if "camera" in report else 0
    for asset in report["assets"]:
        for light in asset["lights"]:
            assert [kind for kind in ("random", "surface", "camera") if kind in light] == kinds
            for kind in kinds:
                check_counts(light[kind], pixels if kind == "camera" else report["points"])
            for one in light["filters"]:
                assert [kind for kind in ("random", "surface", "camera") if kind in one] == kinds
        for key in ("checked", "wrong", "unexplained"):
            assert asset[key] == sum(light[kind][key] for light in asset["lights"] for kind in kinds)
        accepted = asset["wrong_share"] <= report.get("max_error", 1)
        biased = [counts[fault] for light in asset["lights"] for kind in kinds[1:]
                  for counts in [light[kind], *(one[kind] for one in light["filters"])] for fault in ("self_shadows", "deep_leaks")]
        assert asset["passed"] == (asset["unexplained"] == 0 and not any(biased) and accepted)
    assert report["passed"] == all(asset["passed"] for asset in report["assets"])
    return report


def test_schema():
    jsonschema.Draft202012Validator.check_schema(json.loads(SCHEMA.read_text()))


@pytest.fixture(scope="module")
def compare_all(vxs, city):
    """compare_all(scene, assets, *options, status=0): the JSON report, checked."""

    def run(scene, assets, *options, status=0):
        done = vxs("compare", city / scene, *(city / asset for asset in assets), "--json", "-", *options, status=status)
        report = check_report(json.loads(done.stdout))
        assert report["passed"] == (status == 0) and [a["asset"] for a in report["assets"]] == [str(city / a) for a in assets]
        return report

    return run


@pytest.fixture(scope="module")
def compare(compare_all):
    """The same for one asset: what the report says of it."""
    return lambda scene, asset, *options, status=0: compare_all(scene, [asset], *options, status=status)["assets"][0]


def test_errors_are_explained_and_fall_with_resolution(compare):
    coarse, fine = (compare("city1.glb", asset, "--points", 50000) for asset in ("128.vxs", "512.vxs"))
    assert coarse["unexplained"] == fine["unexplained"] == 0
    for kind in ("random", "surface"):
        assert 0 < fine["lights"][0][kind]["wrong_share"] < 0.6 * coarse["lights"][0][kind]["wrong_share"]
    assert fine["lights"][0]["random"]["wrong_share"] < 0.01
    assert fine["lights"][0]["random"]["inside_solid"] > 0
    assert fine["lights"][0]["faults"] == []
    time = fine["lights"][0]["time"]
    assert 0 < time["lookup_ns"] and 0 < time["ray_ns"] and fine["lights"][0]["filters"] == []


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) if name in LARGE else name for name in REAL])
def test_real_scene(vxs, compare, scenes, tmp_path, name):
    """No fault at either size, and eight times the texels leave at most a third of the wrong random points."""
    wrong = {}
    for resolution in (512, 4096):
        asset = tmp_path / f"{resolution}.vxs"
        vxs("bake", scenes / "real" / f"{name}.glb", "--sun", SUN, "--light", "sun", "--resolution", resolution,
            "-o", asset)
        report = compare(scenes / "real" / f"{name}.glb", asset, "--points", POINTS)
        light, = report["lights"]
        assert report["unexplained"] == 0
        assert light["random"]["outside"] == 0 and light["surface"]["self_shadows"] == light["surface"]["deep_leaks"] == 0
        wrong[resolution] = light["random"]["wrong_share"]
        print(f"{name} {resolution}: wrong {100 * wrong[resolution]:.4f} % random, "
              f"{100 * light['surface']['wrong_share']:.4f} % surface")
    assert 0 < wrong[512] and wrong[4096] < wrong[512] / 3


def test_points_are_drawn_where_the_region_is(vxs, compare, city):
    vxs("bake", city / "city1.glb", "--sun", SUN, "--light", "sun", "--resolution", 256, "--region", "0,0,0,10,5,10",
        "-o", city / "region.vxs")
    light, = compare("city1.glb", "region.vxs", "--points", 20000)["lights"]
    assert light["random"]["outside"] == 0 and light["random"]["checked"] > 5000
    assert light["surface"]["outside"] > 10000


def test_a_comparison_that_checks_nothing_fails(vxs, city):
    vxs("bake", city / "city1.glb", "--sun", SUN, "--light", "sun", "--resolution", 64, "--region", "0,5000,0,10,5005,10",
        "-o", city / "far.vxs")
    done = vxs("compare", city / "city1.glb", city / "far.vxs", "--points", 1000, status=2)
    assert done.stderr == f"vxs: error: no point of {city / 'city1.glb'} lies in the volume of light 'sun'\n"
    assert done.stdout == ""


def test_names_that_are_not_utf8(vxs_path, city):
    scene = os.path.join(os.fsencode(city), b"caf\xe9.glb")
    pathlib.Path(os.fsdecode(scene)).write_bytes((city / "city1.glb").read_bytes())
    done = subprocess.run([vxs_path, "compare", scene, city / "512.vxs", "--points", "1000", "--json", "-"],
                          capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["scene"].endswith("/caf?.glb")


def test_filters_are_compared_with_the_same_filters_over_rays(compare):
    options = "--filter", 5, "--filter=1", "--smooth", 4, "--filter", 9, "--smooth", 9
    light = compare("city1.glb", "512.vxs", "--points", 3000, *options)["lights"][0]
    assert [(one["filter_px"], one["smooth"]) for one in light["filters"]] == [(5, False), (9, False), (4, True), (9, True)]
    assert light["filters"][1]["lookup_ns"] > light["time"]["lookup_ns"]
    for one in light["filters"]:
        for kind in ("random", "surface"):
            error = one[kind]
            assert 0 < error["points"] <= 3000 and 0 < error["rmse"] < 0.1 and error["rmse"] <= error["max_error"]


# -- several assets ------------------------------------------------------------------------------------------


def without_times(report):
    for light in (light for asset in report["assets"] for light in asset["lights"]):
        del light["time"]
        for one in light["filters"]:
            del one["lookup_ns"]
    return report


def test_assets_are_compared_as_if_alone(compare_all):
    options = "--points", 5000, "--filter", 3, "--camera"
    both = without_times(compare_all("city1.glb", ["128.vxs", "512.vxs"], *options))
    alone = [without_times(compare_all("city1.glb", [asset], *options)) for asset in ("128.vxs", "512.vxs")]
    assert both["assets"] == [one["assets"][0] for one in alone]
    assert {k: v for k, v in both.items() if k != "assets"} == {k: v for k, v in alone[1].items() if k != "assets"}
    coarse, fine = (asset["lights"][0] for asset in both["assets"])
    for kind in ("random", "surface", "camera"):
        assert fine[kind]["wrong_share"] < coarse[kind]["wrong_share"]
        assert fine["filters"][0][kind]["rmse"] < coarse["filters"][0][kind]["rmse"]
    assert both["assets"][0]["file_bytes"] < both["assets"][1]["file_bytes"] < both["assets"][1]["memory_bytes"]


def test_sizes_are_those_of_the_file(vxs, compare, city):
    asset = compare("city1.glb", "512.vxs", "--points", 1000)
    info = json.loads(vxs("info", city / "512.vxs", "--json", "-").stdout)
    assert asset["file_bytes"] == (city / "512.vxs").stat().st_size
    assert asset["memory_bytes"] == sum(light["memory_bytes"] for light in info["lights"])


def test_each_asset_has_the_solids_that_it_was_baked_with(vxs, compare_all, city):
    """--closed of the bake counts, whatever the others have."""
    scene = small_scene.with_a_turned_triangle(small_scene.write(city / "whole.gltf"))
    options = "--resolution", 128, "-o"
    vxs("bake", scene, *options, city / "open.vxs")
    vxs("bake", scene, "--closed", "off", *options, city / "sheets.vxs")
    report = compare_all(scene, ["open.vxs", "sheets.vxs", "open.vxs"], "--points", 20000)
    assert [a["closed"] for a in report["assets"]] == ["auto", "off", "auto"]
    assert [a["solid_triangles"] for a in report["assets"]] == [12, 0, 12]
    assert without_times(report)["assets"][0] == report["assets"][2]


def test_one_wrong_asset_fails_them_all(vxs, compare_all, city):
    report = compare_all("city1.glb", ["512.vxs", "128.vxs"], "--points", 5000)
    shares = [asset["wrong_share"] for asset in report["assets"]]
    report = compare_all("city1.glb", ["512.vxs", "128.vxs"], "--points", 5000, "--max-error", sum(shares) / 2, status=1)
    assert [asset["passed"] for asset in report["assets"]] == [True, False]
    table = vxs("compare", city / "city1.glb", city / "512.vxs", city / "128.vxs", "--points", 5000, "--filter", 5,
                "--max-error", sum(shares) / 2, status=1).stdout.splitlines()
    assert table[-3].split()[:4] == ["texels", "file", "memory", "bake"] and "RMSE 5 x 5" in table[-3]
    assert table[-2].startswith("512 ") and table[-2].endswith("512.vxs")
    assert table[-1].startswith("128 ") and table[-1].endswith("128.vxs; FAILED")


def test_bake_reports_tell_the_time_of_a_bake(vxs, compare_all, city):
    for resolution in (64, 32):
        vxs("bake", city / "city1.glb", "--sun", SUN, "--light", "sun", "--resolution", resolution,
            "-o", city / f"{resolution}.vxs", "--json", city / f"{resolution}.json")
    files = [city / "64.vxs", city / "32.vxs"]
    reports = [json.loads((city / f"{resolution}.json").read_text()) for resolution in (64, 32)]
    wanted = [{key: report[key] for key in ("total_seconds", "peak_bytes")} for report in reports]
    told = "--bake-report", city / "64.json", "--bake-report", city / "32.json"
    found = compare_all("city1.glb", files, "--points", 1000, *told)["assets"]
    assert [asset["bake"] for asset in found] == wanted
    found = compare_all("city1.glb", files, "--points", 1000, *told[:2])["assets"]
    assert found[0]["bake"] == wanted[0] and "bake" not in found[1]
    table = vxs("compare", city / "city1.glb", *files, "--points", 1000, *told[:2]).stdout.splitlines()
    assert f" {wanted[0]['total_seconds']:.3g} s " in table[-2] and " - " in table[-1]

    swapped = vxs("compare", city / "city1.glb", *files, "--bake-report", city / "32.json", status=2).stderr
    assert "expected the report of its bake" in swapped
    assert "given 2 times for 1 .vxs files" in vxs("compare", city / "city1.glb", files[0], *told, status=2).stderr


@pytest.mark.parametrize("text, words", [
    ("", "bad.json: "),
    ("[" * 100000, "bad.json: "),
    ("[]", "a number from 0 as total_seconds"),
    ('{"total_seconds": "1", "peak_bytes": 1, "file_bytes": 1}', "a number from 0 as total_seconds"),
    ('{"total_seconds": -1, "peak_bytes": 1, "file_bytes": 1}', "a number from 0 as total_seconds"),
    ('{"total_seconds": 1e999, "peak_bytes": 1, "file_bytes": 1}', "bad.json: "),
    ('{"total_seconds": 1, "file_bytes": 1}', "a number from 0 as peak_bytes"),
    ('{"total_seconds": 1, "peak_bytes": 1e300, "file_bytes": 1}', "a number from 0 as peak_bytes"),
    ('{"total_seconds": 1, "peak_bytes": 1, "file_bytes": null}', "a number from 0 as file_bytes"),
])
def test_bake_reports_are_checked(vxs, city, text, words):
    (city / "bad.json").write_text(text)
    done = vxs("compare", city / "city1.glb", city / "512.vxs", "--bake-report", city / "bad.json", status=3)
    assert done.stderr.startswith("vxs: error: --bake-report ") and words in done.stderr and done.stderr.count("\n") == 1


def test_a_bake_report_that_is_not_there(vxs, city):
    done = vxs("compare", city / "city1.glb", city / "512.vxs", "--bake-report", city / "no.json", status=3)
    assert "no.json" in done.stderr and done.stderr.count("\n") == 1


# -- a camera ------------------------------------------------------------------------------------------------


def test_what_a_camera_sees_is_compared(compare_all):
    report = compare_all("city1.glb", ["512.vxs"], "--points", 20000, "--camera")
    camera, light = report["camera"], report["assets"][0]["lights"][0]
    assert 0.95 * 20000 < camera["width_px"] * camera["height_px"] <= 20000 and camera["fov_degrees"] == 35
    assert light["camera"]["checked"] > 8000 and light["camera"]["unexplained"] == 0
    assert 0 < light["camera"]["wrong_share"] < 0.1

    given = compare_all("city1.glb", ["512.vxs"], "--points", 20000, "--fov", 35, "--eye", ",".join(map(repr, camera["eye_m"])),
                        "--target", ",".join(map(repr, camera["target_m"])))
    seen = [asset["lights"][0]["camera"]["checked"] for asset in (report["assets"][0], given["assets"][0])]
    assert abs(seen[0] - seen[1]) < 20, "the same view, but for how its numbers are rounded"
    up = compare_all("city1.glb", ["512.vxs"], "--points", 2000, "--eye", "0,500,0", "--target", "0,1000,0")
    assert up["assets"][0]["lights"][0]["camera"]["checked"] == 0


# -- scenes that moved ---------------------------------------------------------------------------------------


def test_another_scene_is_found_wrong(compare):
    report = compare("city2.glb", "512.vxs", "--points", 20000, "--other-scene", status=1)
    assert report["unexplained"] > 100
    examples = report["lights"][0]["faults"]
    assert len(examples) == 10
    for example in examples:
        assert example["asset_lit"] != example["truth_lit"]
        assert (example["normal"] is None) == (example["kind"] == "random")


def test_examples_are_what_query_and_truth_say(vxs, compare, city):
    examples = compare("city2.glb", "512.vxs", "--points", 20000, "--other-scene", status=1)["lights"][0]["faults"]
    examples = [e for e in examples if e["kind"] == "random"]
    points = "".join("%.9g %.9g %.9g\n" % tuple(e["point_m"]) for e in examples)
    lit = vxs("query", city / "512.vxs", input=points).stdout.split()
    true = vxs("truth", city / "city2.glb", "--light", "sun", "--sun", SUN, input=points).stdout.split()
    assert examples and lit == [str(int(e["asset_lit"])) for e in examples]
    assert true == [str(int(e["truth_lit"])) for e in examples]


def test_every_light_is_compared_by_its_own_direction(vxs, compare, city):
    lights = [("noon", "directional", (0, -1, 0)), ("morning", "directional", (1, -1, 0))]
    small_scene.write(city / "two.gltf", lights=lights)
    vxs("bake", city / "two.gltf", "--resolution", 256, "-o", city / "two.vxs")
    small_scene.write(city / "none.gltf", lights=[])  # the scene's own lights do not matter
    report = compare("none.gltf", "two.vxs", "--points", 20000, "--other-scene")
    assert report["unexplained"] == 0 and report["wrong_share"] < 0.05
    assert [light["name"] for light in report["lights"]] == ["noon", "morning"]
    assert report["lights"][1]["direction"] == pytest.approx([0.5 ** 0.5, -(0.5 ** 0.5), 0])


def test_a_block_that_moved_leaves_a_shadow_and_a_leak(vxs, compare, city):
    moved = ((3, 2, 3), (5, 3, 5))
    small_scene.write(city / "before.gltf")
    small_scene.write(city / "after.gltf", boxes=(small_scene.GROUND, moved))
    vxs("bake", city / "before.gltf", "--resolution", 256, "-o", city / "before.vxs")
    assert compare("before.gltf", "before.vxs", "--points", 20000)["unexplained"] == 0
    light = compare("after.gltf", "before.vxs", "--points", 20000, "--other-scene", status=1)["lights"][0]
    assert light["random"]["leaks"] > 100 and light["random"]["false_shadows"] > 100
    for example in light["faults"]:
        x, y, z = example["point_m"]
        at = (-1, 1) if example["truth_lit"] else (3, 5)  # under where the block was, under where it is
        assert at[0] <= x <= at[1] and at[0] <= z <= at[1] and y < 3


def test_every_kind_of_light_is_compared(vxs, compare, city):
    """And a block that moved is found by each of them."""
    lights = [("noon", "directional", (0, -1, 0)), ("spot", "spot", (0, -1, 0)), ("lamp", "point", (0, -1, 0))]
    small_scene.write(city / "lamps.gltf", lights=lights)
    small_scene.write(city / "moved.gltf", boxes=(small_scene.GROUND, ((3, 2, 3), (5, 3, 5))), lights=[])
    vxs("bake", city / "lamps.gltf", "--resolution", 256, "-o", city / "lamps.vxs")
    right = compare("lamps.gltf", "lamps.vxs", "--points", 10000, "--filter", 3)
    assert [(light["kind"], light["maps"]) for light in right["lights"]] == [("directional", 1), ("spot", 1), ("point", 6)]
    assert right["unexplained"] == 0 and right["wrong_share"] < 0.03
    for light in right["lights"]:
        assert light["random"]["outside"] == 0 and light["random"]["checked"] > 5000 and light["surface"]["checked"] > 5000
        assert light["filters"][0]["random"]["rmse"] < 0.11 and light["filters"][0]["surface"]["rmse"] < 0.11
    for light in compare("moved.gltf", "lamps.vxs", "--points", 10000, "--other-scene", status=1)["lights"]:
        assert light["faults"], light["name"]
        assert all(0 <= e["map"] < light["maps"] for e in light["faults"])


def test_max_error_decides_the_exit_status(compare, compare_all):
    share = compare("city1.glb", "512.vxs", "--points", 5000)["wrong_share"]
    assert compare_all("city1.glb", ["512.vxs"], "--points", 5000, "--max-error", share * 1.01)["max_error"] > share
    compare("city1.glb", "512.vxs", "--points", 5000, "--max-error", share * 0.99, status=1)


def test_same_seed_same_counts_at_any_thread_count(compare_all):
    def run(*options):
        report = without_times(compare_all("city1.glb", ["512.vxs"], "--points", 5000, "--filter", 3, "--camera", *options))
        return report | {"seed": 1}

    one = run("--threads", 1)
    assert one == run("--threads", 3)
    assert one != run("--seed", 2)


def test_solids_are_those_of_the_bake(vxs, compare, city):
    vxs("bake", city / "city1.glb", "--sun", SUN, "--light", "sun", "--resolution", 128, "--closed", "off",
        "-o", city / "sheets.vxs")
    report = compare("city1.glb", "sheets.vxs", "--points", 1000)
    assert (report["closed"], report["solid_triangles"], report["lights"][0]["random"]["inside_solid"]) == ("off", 0, 0)
    report = compare("city1.glb", "sheets.vxs", "--points", 1000, "--closed", "auto")
    assert report["closed"] == "auto" and report["solid_triangles"] > 0


def test_scene_option(vxs, compare, city):
    assert compare("city1.glb", "512.vxs", "--points", 1000, "--scene", 0)["passed"]
    assert "scene" in vxs("compare", city / "city1.glb", city / "512.vxs", "--scene", "no such", status=2).stderr


def test_table_stays_beside_json_on_standard_output(vxs, city):
    done = vxs("compare", city / "city1.glb", city / "512.vxs", "--points", 1000, "--verbose", "--json", "-")
    assert json.loads(done.stdout)["passed"] and "light sun: directional" in done.stderr


def test_table_for_people(vxs, city):
    table = vxs("compare", city / "city1.glb", city / "512.vxs", "--points", 1000, "--filter", 3, "--verbose").stdout
    for word in ("light sun: directional", "random", "surface", "surface points in their own shadow: 0", "3 x 3 filter", "ns", "unexplained: 0"):
        assert word in table
    table = vxs("compare", city / "city2.glb", city / "512.vxs", "--points", 20000, "--verbose", "--other-scene", status=1).stdout
    assert table.count("  unexplained: (") == 10 and "FAILED" in table


@pytest.mark.parametrize("options, words", [
    (["--filter", 4], "--filter 4: expected an odd number"),
    (["--filter", 5, "--filter", "5"], "--filter 5 is given twice"),
    (["--smooth", 18], "--smooth 18: expected a whole number from 1 to 17"),
    (["--smooth", 4, "--filter", 4], "--filter 4: expected an odd number"),
    (["--eye", "0,0,0"], "--target is missing"),
    (["--eye", "1,2,3", "--target", "1,2,3"], "the same point"),
    (["--fov", 40], "--fov goes with --camera"),
    (["--camera", "--fov", 171], "--fov 171"),
    (["--filter", 19], "--filter 19: expected a whole number from 1 to 17"),
    (["--points", 0], "--points 0"),
    (["--max-error", 2], "--max-error 2"),
    (["--closed", "maybe"], "--closed maybe: expected one of auto|on|off"),
])
def test_compare_options_are_checked(vxs, city, options, words):
    done = vxs("compare", city / "city1.glb", city / "512.vxs", *options, status=2)
    assert done.stderr.startswith("vxs: error: ") and words in done.stderr and done.stderr.count("\n") == 1


def test_compare_files_are_checked(vxs, city):
    assert "cannot read" in vxs("compare", city / "city1.glb", city / "none.vxs", status=3).stderr
    assert "is a glTF scene, expected a .vxs file" in vxs("compare", city / "city1.glb", city / "city1.glb", status=3).stderr
    assert "none.glb" in vxs("compare", city / "none.glb", city / "512.vxs", status=3).stderr
    assert "FILE.vxs is missing" in vxs("compare", city / "city1.glb", status=2).stderr


# -- pictures ----------------------------------------------------------------------------------------------

@pytest.fixture(scope="module", params=["gl", "rays"])
def drawn(request):
    return "--draw", request.param


@pytest.fixture(scope="module")
def picture(vxs, city, drawn):
    def run(*options, asset="512.vxs"):
        vxs("render", city / "city1.glb", city / asset, "-o", city / "out.png", "--width", 160, "--height", 90, *drawn, *options)
        return read_png((city / "out.png").read_bytes())

    return run


def brightness(rows):
    return sum(map(sum, rows)) / sum(map(len, rows))


def test_picture_shows_something(picture):
    width, height, rows = picture()
    assert (width, height) == (160, 90)
    values = b"".join(rows)
    assert max(values) > 200 and min(values) < 100 and len(set(values)) > 50


def test_picture_is_the_same_at_any_thread_count(picture):
    assert picture("--threads", 1) == picture("--threads", 3)


def test_picture_has_the_shadows_of_the_asset(vxs, picture, city):
    """With an asset whose only caster lies below everything that is seen, the picture is brighter."""
    small_scene.write(city / "below.gltf", boxes=[((-1000, -200, -1000), (1000, -199, 1000))])
    vxs("bake", city / "below.gltf", "--sun", SUN, "--resolution", 64, "-o", city / "lit.vxs")
    shadowed, lit = brightness(picture()[2]), brightness(picture(asset="lit.vxs")[2])
    assert lit > shadowed + 1


def test_picture_of_lamps(vxs, city, drawn):
    """From above: a spot draws its disk on the ground, the block's shadow in it; without a sun it is night."""
    small_scene.write(city / "night.gltf", lights=[("spot", "spot", (0, -1, 0)), ("lamp", "point", (0, -1, 0)),
                                                   ("noon", "directional", (0, -1, 0))])
    vxs("bake", city / "night.gltf", "--resolution", 256, "-o", city / "night.vxs")

    def at(*options):
        """Brightness at metres on the ground to both sides of the middle: 0 is the block."""
        vxs("render", city / "night.gltf", city / "night.vxs", "-o", city / "night.png", "--width", 128, "--height", 128, "--eye",
            "0,20,0", "--target", "0,0,0", "--fov", 43.6, *drawn, *options)
        rows = read_png((city / "night.png").read_bytes())[2]
        return {metres: sum(rows[64][3 * (64 + 8 * metres):][:3]) for metres in (-7, -3, 3, 5, 7)}

    spot, lamp, day = at("--light", "spot"), at("--light", "lamp"), at()
    assert spot[3] > 2 * spot[7] and spot[-3] > 2 * spot[-7], "the cone ends 6 m from the middle"
    assert lamp[3] > lamp[5] > lamp[7] > 1.5 * spot[7], "the lamp has no cone, and less light far away"
    assert all(day[metres] > lamp[metres] for metres in day), "all lights, the sun too"
    assert at("--light", "spot", "--light", "lamp")[3] > max(spot[3], lamp[3])


def test_picture_camera_and_light(picture):
    down = picture("--eye", "0,500,0", "--target", "0,0,0", "--fov", 60, "--light", "sun", "--filter", 1, "--scene", 0)
    assert down[:2] == (160, 90) and down != picture() and len(set(b"".join(down[2]))) > 50
    away = picture("--eye", "0,500,0", "--target", "0,1000,0")[2]
    assert len(set(b"".join(away))) < 50  # nothing but sky


def test_picture_filter(picture):
    assert picture() == picture("--filter", 5) != picture("--smooth", 5) != picture("--smooth", 4)


@pytest.mark.parametrize("options, words", [
    (["--filter", 2], "--filter 2: expected an odd number"),
    (["--filter", 3, "--smooth", 3], "--filter and --smooth exclude each other"),
    (["--width", 8], "--width 8: expected a whole number from 16 to 8192"),
    (["--height", 9000], "--height 9000"),
    (["--fov", 0], "--fov 0"),
    (["--eye", "0,0,0"], "--target is missing"),
    (["--target", "0,0,0"], "--eye is missing"),
    (["--eye", "1,2,3", "--target", "1,2,3"], "the same point"),
    (["--light", "sun", "--light", "sun"], "--light sun is given twice"),
    (["--light", "moon"], "512.vxs' has no light of that name; it has sun"),
    (["--samples", 5], "--samples 5"),
    (["--samples", 4, "--width", 4097], "expected no side of more than 16384 samples"),
    (["--draw", "rays", "--samples", 1], "--draw rays goes without --samples"),
    (["--draw", "rays", "--cull", "on"], "--draw rays goes without --cull"),
    (["--draw", "rays", "--orbit"], "--draw rays goes without --orbit"),
    (["--draw", "rays", "--json", "-"], "--draw rays goes without --json"),
    (["--draw", "rays", "--exposure", 1], "--draw rays goes without --exposure"),
])
def test_picture_options_are_checked(vxs, city, options, words):
    done = vxs("render", city / "city1.glb", city / "512.vxs", "-o", city / "bad.png", *options, status=2)
    assert done.stderr.startswith("vxs: error: ") and words in done.stderr and done.stderr.count("\n") == 1
    assert not (city / "bad.png").exists()


def test_picture_output(vxs, vxs_path, city):
    files = city / "city1.glb", city / "512.vxs"
    assert "-o" in vxs("render", *files, status=2).stderr
    assert "cannot write" in vxs("render", *files, "-o", city / "no" / "x.png", status=4).stderr
    done = subprocess.run([vxs_path, "render", *files, "-o", "-", "--width", "32", "--height", "16"], capture_output=True,
                          timeout=60)
    assert done.returncode == 0 and read_png(done.stdout)[:2] == (32, 16)
