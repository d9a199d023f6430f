# Assets of palette blocks as their users meet them, beside those of DAGs (vxs bake --coding dag).
# SPDX-License-Identifier: GPL-3.0-or-later
import json

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
    assert 0 < kept["own_tiles"] < kept["tiles"] <= light["mask_tiles"] and kept["tiles"] <= 16 * kept["blocks"]
    assert parts["patterns"]["count"] < kept["patterns"] < kept["tiles"] and kept["pages"] == parts["pages"]["count"] > 0
    assert sum(part["memory_bytes"] for part in parts.values()) == light["size"]["memory_bytes"] == told["lights"][0]["memory_bytes"]
    assert sum(s["memory_bytes"] for s in told["sections"]) == told["lights"][0]["memory_bytes"]
    rows = {row.split()[0]: row for row in vxs("info", out).stdout.splitlines()}
    assert f" {parts['patterns']['count']} " in rows["patterns"] and f" {parts['tops']['count']} " in rows["tops"]


@pytest.mark.parametrize("options", [("--coding", "dag", "--rule", "shadow", "--stop", "insert", "--reuse", "off"), ("--coding", "blocks")])
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
