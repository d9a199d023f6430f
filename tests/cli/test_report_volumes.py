# vxs report: pages of error against time of shadows in fog, of any names and figures.
# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import json
import re

import pytest

from conftest import ROOT
from reports import NASTY, pages_of, rejections_of, told_at
from test_report import bench
from test_report import cell as bake_cell

SCHEMA = json.loads((ROOT / "docs" / "volumes.schema.json").read_text())


def error(rms):
    return {"relative_rms": rms, "signed_mean": -rms / 8, "percentile_99": rms / 2, "most": 2 * rms, "values": 768}


def cell(technique, value, ms, rms, behind=1, **more):
    return {"technique": technique, "knob": "steps" if value else "-", "value": value, "refused": False, "open_ms": 2 * ms,
            "ms": {"median": ms, "least": ms * 0.9, "greatest": ms * 1.2}, "error": error(rms), "elsewhere": error(rms), "flicker": rms / 3,
            "behind": behind, "front": behind == 1} | more


def scene(*cells, name="room, lamp", **more):
    techniques = [{"name": n, "knob": "steps", "limit": f"what limits {n}", "rival": n == "froxels"} for n in {c["technique"]: 0 for c in cells}]
    return {"name": name, "file_bytes": 1500, "generator": "vxs 0.1.0", "scene": "room.glb", "file": "room.vxs", "light": "lamp",
            "reference": "exact lit intervals", "renderer": "llvmpipe", "clock": "wall", "eye": [0, 1, 2], "target": [0, 0, 0], "width_px": 16, "height_px": 16,
            "extinction_per_metre": [1, 1, 1], "scattering_per_metre": [1, 1, 1], "anisotropy": 0.4, "rounds": 7, "techniques": techniques,
            "cells": copy.deepcopy(list(cells))} | more


def measured(*scenes):
    return {"machine": {"processor": "Abacus 3000", "cores": 2, "memory_bytes": 24 << 30, "system": "Linux"}, "scenes": list(scenes)}


SOME = (cell("march", 8, 0.5, 0.25), cell("march", 64, 4, 0.03, behind=2), cell("froxels", 16, 2, 0.02), cell("intervals", 0, 40, 5e-7))


@pytest.fixture
def report(vxs, browser, tmp_path):
    """report(*measurements): their page."""
    return pages_of(vxs, browser, tmp_path, SCHEMA)


@pytest.fixture
def rejected(vxs_path, tmp_path):
    """rejected(status, content or text, *arguments): the one line of an error."""
    return rejections_of(vxs_path, tmp_path)


def test_holds_the_figures(report):
    page = report(measured(scene(*SOME)))
    for word in ("error against time of 3 techniques in 1 scene", "Abacus 3000", "24 GiB", "llvmpipe", "16 x 16 pixels", "7 rounds",
                 "room, lamp: 3 of 4 settings on the front", "Against exact lit intervals", "what limits march", "froxels rival", "64 steps", "4 ms",
                 "3.6 ms–4.8 ms", "5e-7", "1500 B", "0.25", "-0.031", "0.01", "80 ms"):
        assert word in page.text, word
    assert re.search(r"march steps 1 of 1 1 0\.03 to 0\.25", page.text) and re.search(r"0\.03 2 -0\.0037", page.text), "how far it is behind"
    assert "at the lamp" not in page.text and "NaN" not in page.text and "undefined" not in page.text


def test_charts_are_drawn(report):
    page = report(measured(scene(*SOME), scene(*SOME, name="city, sun")))
    assert set(page.charts) == {"front-1", "front-2"}
    for drawn in page.charts.values():
        assert drawn["colours"] > 20 and {"time of a frame", "relative RMS error", "1\N{NO-BREAK SPACE}ms", "0.01"} <= set(drawn["words"])
        assert [item.lstrip("●") for item in drawn["key"]] == ["march", "froxels", "intervals", "the front"]


def test_settings_are_told_where_the_mouse_is(report, browser):
    report(measured(scene(*SOME)))
    assert told_at(browser, "front-1", 1, 1) == "march, 64 steps: 4 ms, 0.03; 2 times as long as what is as near"


def test_the_front_is_drawn(report, browser):
    """In order of time, though its settings come in any order; and no other setting is."""
    report(measured(scene(*SOME[::-1])))
    front = browser.ask('Chart.getChart(document.querySelector("#front-1 canvas")).data.datasets[0].data')
    assert [(round(p["x"], 7), p["y"]) for p in front] == [(0.0005, 0.25), (0.002, 0.02), (0.04, 5e-7)]


def test_refused_exact_and_at_a_lamp(report, browser):
    """What could not be drawn has a row; an error of 0 or of no end has no place in the plot."""
    refused = {"technique": "grid", "knob": "bits", "value": 512, "refused": True, "open_ms": 1}
    endless = cell("march", 16, 1, 0, error=error(0) | {"relative_rms": None})
    page = report(measured(scene(*SOME, refused, endless, cell("angles", 8, 1, 0), cell("mesh", 8, 3, 0.01, epipole=error(0.125)))))
    assert "512 bits refused" in page.text and "RMS at the light" in page.text and "0.13" in page.text
    drawn = browser.ask('Chart.getChart(document.querySelector("#front-1 canvas")).data.datasets.map((d) => d.data.map((p) => p.y))')
    assert drawn == [[0.25, 0.02, 0.01, 5e-7], [0.25, 0.03], [0.02], [5e-7], [], [0.01]]
    alone = report(measured(scene(refused)))
    assert alone.charts == {} and "refused" in alone.text


def test_smoke(report, browser):
    """Bytes have a plot of their own, parts of a frame and what papers say a place; there is neither a file nor flicker."""
    nodes = [cell("adaptive", n, n, 0.2 / n, behind=n / 4, bytes_per_texel=8 * n, creation_ms=3 * n,
                  parts=[{"name": "capture", "ms": 0.125 * n}, {"name": "look up", "ms": 0.875 * n}]) for n in (4, 8)]
    for c in nodes:
        del c["flicker"]
    smoke = scene(*nodes, name="smoke columns", clock="processor", claims=[{"what": "deep over 8 nodes", "value": 3.5, "paper": 276}])
    del smoke["file_bytes"]
    page = report(measured(smoke, scene(*SOME)))
    assert set(page.charts) == {"front-1", "front-1-bytes", "front-2"}
    assert "processor time of a frame" in page.charts["front-1"]["words"] and "time of a frame" in page.charts["front-2"]["words"]
    assert {"bytes a texel", "32\N{NO-BREAK SPACE}B"} <= set(page.charts["front-1-bytes"]["words"])
    assert [item.lstrip("●") for item in page.charts["front-1-bytes"]["key"]] == ["adaptive"]
    assert told_at(browser, "front-1-bytes", 0, 1) == "adaptive, 8 steps: 8 ms, 64 B a texel, 0.025; 2 times as long as what is as near"
    for words in ("capture look up creation bytes a texel first frame", "1 ms 7 ms 24 ms 64 16 ms", "deep over 8 nodes: 3.5 times as long; the paper has 276"):
        assert words in page.text, words
    assert "NaN" not in page.text and "undefined" not in page.text


def test_several_files(report):
    page = report(measured(scene(*SOME)), measured(scene(*SOME)))
    assert "room, lamp, b0.json: 3 of 4" in page.text and "room, lamp, b1.json: 3 of 4" in page.text and page.text.count("Abacus 3000") == 2


@pytest.mark.parametrize("names", [NASTY[n::3] for n in range(3)], ids=range(3))
def test_names_are_harmless(report, names):
    scenes = [scene(*SOME, cell(name, 8, 1, 0.125, knob=name), name=name, light=name, renderer=name, generator=name, reference=name) for name in names]
    for s, name in zip(scenes, names):
        s["techniques"][0]["limit"] = name
    content = measured(*scenes)
    content["machine"] |= {"processor": names[0], "system": names[1]}
    page = report(content, check=False)
    assert page.sources == []
    for name in names:
        assert not name.isprintable() or name in page.text


def broken(change):
    content = measured(scene(*SOME), scene(*SOME))
    change(content)
    return content


@pytest.mark.parametrize("content, says", [
    (broken(lambda v: v.update(scenes=[])), "no scenes"),
    (broken(lambda v: v.update(scenes={})), "scenes"),
    (broken(lambda v: v.pop("machine")), "machine"),
    (broken(lambda v: v["scenes"][1].pop("techniques")), "scene 2: \"techniques\""),
    (broken(lambda v: v["scenes"][1]["cells"][2].pop("ms")), "scene 2: cell 3: \"ms\""),
    (broken(lambda v: v["scenes"][0]["cells"][1].update(behind="1")), "scene 1: cell 2: \"behind\""),
    (broken(lambda v: v["scenes"][0]["cells"][1]["error"].update(relative_rms=-1)), "relative_rms"),
    (broken(lambda v: v["scenes"][0]["cells"][1]["error"].pop("signed_mean")), "signed_mean"),
])
def test_other_json_is_refused(rejected, content, says):
    error = rejected(3, content)
    assert says in error and ("no scenes" in error or "not what make bench-volumes writes" in error)


def test_bakes_and_fog_are_not_mixed(rejected, tmp_path):
    (tmp_path / "bakes.json").write_text(json.dumps(bench(bake_cell())))
    assert "measurements of bakes" in rejected(3, measured(scene(*SOME)), tmp_path / "bakes.json", "-o", tmp_path / "out.html")
