# Assets of palette blocks as their users meet them, beside those of DAGs (vxs bake --coding dag).
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import struct

import jsonschema
import pytest

import small_scene
from conftest import ROOT
from small_scene import MORNING, NOON

LIGHTS = (("noon", "directional", NOON), ("lamp", "spot", MORNING), ("bulb", "point", NOON))


def valid(document, schema):
    jsonschema.validate(document, json.loads((ROOT / "docs" / f"{schema}.schema.json").read_text()))
    return document


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    path = tmp_path_factory.mktemp("coding") / "city.glb"
    vxs("scene", "city", "-o", path, "--triangles", 20000)
    return path


@pytest.fixture(scope="module")
def lamps(tmp_path_factory):
    return small_scene.write(tmp_path_factory.mktemp("coding") / "lamps.gltf", lights=LIGHTS)


@pytest.fixture
def bake(vxs, tmp_path):
    def run(scene, coding, *options):
        out = tmp_path / f"{coding}.vxs"
        vxs("bake", scene, "-o", out, "--coding", coding, "--json", tmp_path / "report.json", *options)
        return out, valid(json.loads((tmp_path / "report.json").read_text()), "bake-report")

    return run


def test_smaller_files_and_less_memory(bake, city):
    sizes = {}
    for coding in ("dag", "blocks"):
        out, report = bake(city, coding, "--resolution", 2048)
        sizes[coding] = out.stat().st_size, report["lights"][0]["size"]["memory_bytes"]
    assert sizes["blocks"][0] < 0.45 * sizes["dag"][0] and sizes["blocks"][1] < 0.35 * sizes["dag"][1]


def test_what_info_and_validate_say(vxs, bake, lamps):
    out, report = bake(lamps, "blocks", "--resolution", 256)
    told = valid(json.loads(vxs("info", out, "--json", "-").stdout), "info")
    assert told["version"] == 2 and [light["name"] for light in told["lights"]] == ["noon", "lamp", "bulb"]
    assert "version 2" in vxs("info", out).stdout and vxs("validate", out).returncode == 0
    assert report["options"]["coding"] == "blocks" and not {"rule", "reuse", "compress", "stop"} & set(report["options"])
    assert told["metadata"]["options"]["coding"] == "blocks" and "rule" not in told["metadata"]["options"]


def test_what_is_kept_is_told(vxs, bake, city):
    """Counts fit into each other, and the parts of a light are all of its words, in the report as in info."""
    out, report = bake(city, "blocks", "--resolution", 2048)
    light, told = report["lights"][0], json.loads(vxs("info", out, "--json", "-").stdout)
    kept, parts = light["palette_blocks"], {part["kind"]: part for part in light["levels"]}
    assert 0 < kept["nodes"] <= 64 and kept["nodes"] < kept["blocks"] <= 64 * kept["nodes"]
    assert 0 < kept["private_tiles"] < kept["tiles"] <= light["mask_tiles"] and kept["tiles"] <= 16 * kept["blocks"]
    assert parts["patterns"]["count"] < kept["patterns"] < kept["tiles"] and kept["pages"] == parts["pages"]["count"] > 0
    assert sum(part["memory_bytes"] for part in parts.values()) == light["size"]["memory_bytes"] == told["lights"][0]["memory_bytes"]
    assert sum(s["memory_bytes"] for s in told["sections"]) == told["lights"][0]["memory_bytes"]
    rows = {row.split()[0]: row for row in vxs("info", out).stdout.splitlines()}
    assert f" {parts['patterns']['count']} " in rows["patterns"] and f" {parts['tops']['count']} " in rows["tops"]


@pytest.mark.parametrize("options", [("--coding", "dag", "--rule", "shadow", "--stop", "insert", "--reuse", "off"), ("--coding", "blocks"),
                                     ("--pack", "fast", "--level", 3)])
def test_info_repeats_the_options(vxs, lamps, tmp_path, options):
    """What it prints makes the same file, whatever is the default."""
    vxs("bake", lamps, "-o", tmp_path / "a.vxs", "--resolution", 64, *options)
    line = next(line for line in vxs("info", tmp_path / "a.vxs").stdout.splitlines() if line.startswith("options"))
    vxs("bake", lamps, "-o", tmp_path / "b.vxs", *line.split()[1:])
    assert (tmp_path / "b.vxs").read_bytes() == (tmp_path / "a.vxs").read_bytes()


def test_no_answer_is_unexplained(vxs, bake, city, lamps, tmp_path):
    for scene in (city, lamps):
        out, _ = bake(scene, "blocks", "--resolution", 512)
        vxs("compare", scene, out, "--points", 20000, "--filter", 9, "--json", tmp_path / "compared.json")
        lights = json.loads((tmp_path / "compared.json").read_text())["assets"][0]["lights"]
        assert all(light[points]["unexplained"] == 0 for light in lights for points in ("random", "surface") if points in light)
        assert lights


def test_bytes_do_not_depend_on_memory(bake, city):
    free, _ = bake(city, "blocks", "--resolution", 4096)
    free = free.read_bytes()
    assert bake(city, "blocks", "--resolution", 4096, "--memory", "150M")[0].read_bytes() == free


def test_an_asset_of_another_coding_is_baked_again(vxs, bake, lamps, tmp_path):
    out, _ = bake(lamps, "dag", "--resolution", 64)
    before = out.read_bytes()
    assert "up to date" in vxs("bake", lamps, "-o", out, "--resolution", 64, "--if-changed", "--coding", "dag").stdout
    vxs("bake", lamps, "-o", out, "--resolution", 64, "--if-changed", "--coding", "blocks")
    assert out.read_bytes() != before
    assert "up to date" in vxs("bake", lamps, "-o", out, "--resolution", 64, "--if-changed", "--coding", "blocks").stdout


def test_plans_tell_of_their_coding(vxs, lamps):
    """How far off they are, test_plan.py says."""
    for coding, keeps, words in (("dag", {"nodes", "masks", "mask_runs"}, "nodes;"), ("blocks", {"palette_blocks"}, "palette blocks,")):
        plan = valid(json.loads(vxs("plan", lamps, "--coding", coding, "--resolution", 256, "--json", "-").stdout), "plan")
        assert all(keeps <= set(light) for light in plan["lights"]), coding
        assert words in vxs("plan", lamps, "--coding", coding, "--resolution", 256, "--verbose").stdout


def of_all_but_metadata(path):
    """Sections by kind and light."""
    data = path.read_bytes()
    entries = list(struct.iter_unpack("<4s3I4Q", data[64:64 + 48 * struct.unpack_from("<I", data, 12)[0]]))
    return {(kind, light): data[at:at + stored] for kind, _, light, _, at, stored, _, _ in entries if kind != b"META"}


def test_packings_hold_the_same(vxs, bake, lamps, tmp_path):
    """Fast is larger on disk, and nothing else: memory, parts, answers."""
    small, in_small = bake(lamps, "blocks", "--resolution", 256)
    fast = tmp_path / "fast.vxs"
    vxs("bake", lamps, "-o", fast, "--resolution", 256, "--pack", "fast", "--json", tmp_path / "fast.json")
    in_fast = valid(json.loads((tmp_path / "fast.json").read_text()), "bake-report")
    assert (in_small["options"]["pack"], in_fast["options"]["pack"]) == ("small", "fast")
    assert small.stat().st_size < fast.stat().st_size < 3 * small.stat().st_size
    told = [valid(json.loads(vxs("info", path, "--json", "-").stdout), "info") for path in (small, fast)]
    assert [[light.pop("packing") for light in info["lights"]] for info in told] == [["small"] * 3, ["fast"] * 3]
    assert told[0]["lights"] == told[1]["lights"] and "pack" not in told[0]["metadata"]["options"]
    for part, other in zip(told[0]["sections"], told[1]["sections"], strict=True):
        assert all(part[key] == other[key] for key in ("kind", "count", "memory_bytes") if part["kind"] != "metadata")
    assert ", packed small" in vxs("info", small).stdout and ", packed fast" in vxs("info", fast).stdout
    assert vxs("validate", fast).returncode == 0
    points = [(x / 2, y / 4, z / 2) for x in range(-9, 10, 2) for y in (1, 5, 9) for z in range(-9, 10, 2)]
    answers = [vxs("query", path, input="".join(f"{x} {y} {z}\n" for x, y, z in points)).stdout for path in (small, fast)]
    assert answers[0] == answers[1] and len(set(answers[0].split())) > 1


def test_fast_bytes_do_not_depend_on_threads(vxs, city, tmp_path):
    contents = []
    for threads in (1, 2, 3):
        vxs("bake", city, "-o", tmp_path / "a.vxs", "--resolution", 2048, "--pack", "fast", "--threads", threads)
        contents.append((tmp_path / "a.vxs").read_bytes())
    assert contents[0] == contents[1] == contents[2]


def test_level_is_that_of_fast_pages(bake, city):
    """And of nothing in small ones, but of the table of lights and the metadata."""
    sizes = {}
    for pack in ("small", "fast"):
        for level in (1, 19):
            out, _ = bake(city, "blocks", "--resolution", 1024, "--pack", pack, "--level", level)
            sizes[pack, level] = len(of_all_but_metadata(out)[b"PAGE", 0])
    assert sizes["small", 1] == sizes["small", 19] and sizes["fast", 19] < 0.95 * sizes["fast", 1]


def test_an_asset_of_another_packing_is_baked_again(vxs, bake, lamps):
    out, _ = bake(lamps, "blocks", "--resolution", 64)
    before = out.read_bytes()
    vxs("bake", lamps, "-o", out, "--resolution", 64, "--if-changed", "--pack", "fast")
    assert out.read_bytes() != before
    assert "up to date" in vxs("bake", lamps, "-o", out, "--resolution", 64, "--if-changed", "--pack", "fast").stdout
    vxs("bake", lamps, "-o", out, "--resolution", 64, "--if-changed")
    assert out.read_bytes() == before


def test_plans_tell_of_their_packing(vxs, city):
    plans = [valid(json.loads(vxs("plan", city, "--pack", pack, "--resolution", 1024, "--json", "-").stdout), "plan")
             for pack in ("small", "fast")]
    assert [plan["options"]["pack"] for plan in plans] == ["small", "fast"]
    assert plans[0]["estimate"]["file_bytes"] < plans[1]["estimate"]["file_bytes"]
    assert "packed fast" in vxs("plan", city, "--pack", "fast", "--resolution", 1024, "--verbose").stdout
