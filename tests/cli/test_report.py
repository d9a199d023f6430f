# vxs report: pages of what vxs bench measured, of any names and figures.
# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import json
import pathlib
import re
import shutil

import pytest

import small_scene
from page import Page
from reports import NASTY, pages_of, rejections_of, told_at

SCHEMA = json.loads((pathlib.Path(__file__).resolve().parents[2] / "docs" / "bench.schema.json").read_text())
STAGES = ("load", "solids", "plan", "gl", "maps", "pyramid", "masks", "insert", "compress", "merge", "encode", "smoke", "write")
PLOTS = {"bytes-by-level-1", "error-bake-random", "error-bake-surface", "error-bytes-random", "error-bytes-surface",
         "error-lookup-random", "error-lookup-surface", "growth-bytes", "growth-time", "nodes-by-level-1", "stages-1"}


def spread(median):
    return {"median": median, "min": median * 0.9, "max": median * 1.2}


def cell(scene="city.glb", resolution=1024, light="sun", **options):
    """Made so that growth is known: bytes and time are powers of the resolution; the older rule takes half as much again."""
    times = 1.5 if options.get("rule") == "shadow" else 1
    size = times * 64 * resolution
    seconds = 1e-6 * resolution ** 1.5
    levels = [(resolution >> n, 4 ** n) for n in range(resolution.bit_length() - 3)] + [(0, resolution)]
    errors = [{"points": points, "filter_px": 1, "checked": 100000, "wrong_share": share / resolution, "leaks": 7, "false_shadows": 11,
               "unexplained": 0} for points, share in (("random", 1.25), ("surface", 20))]
    errors += [{"points": points, "filter_px": 9, "smooth": smooth, "checked": 100000, "rmse": (5 - smooth) / resolution, "max_error": 0.25}
               for smooth in (False, True) for points in ("random", "surface")]
    return {
        "scene": scene, "triangles": 12345, "solid_triangles": 12000, "light": light, "lights": 1, "maps": 1,
        "options": {"resolution_px": resolution, "rule": "greedy", "stop": "final", "exit": "auto", "closed": "auto", "reuse": "on",
                    "compress": "auto", "threads": 2, "zstd_level": 12} | options,
        "bake": {"wall_seconds": spread(seconds * 1.1), "total_seconds": spread(seconds),
                 "maps_to_words_seconds": spread(seconds / 4), "peak_bytes": 200 << 20,
                 "stages": [{"name": s, "seconds": spread(seconds / len(STAGES)), "peak_bytes": 100 << 20} for s in STAGES]},
        "size": {"file_bytes": int(size), "memory_bytes": int(3 * size), "nodes": 5 * resolution, "masks": resolution,
                 "inserted_nodes": 50 * resolution, "inserted_masks": 10 * resolution,
                 "levels": [{"side_voxels": side, "count": count, "memory_bytes": int(size) // len(levels),
                             "stored_bytes": int(size) // len(levels)} for side, count in levels]},
        "errors": errors,
        "lookups": [{"filter_px": 1, "nanoseconds": spread(50), "ray_nanoseconds": spread(900)},
                    {"filter_px": 9, "smooth": False, "nanoseconds": spread(101)},
                    {"filter_px": 9, "smooth": True, "nanoseconds": spread(151)}],
    }


def blocks(resolution=1024):
    """The same in palette blocks, half as large."""
    made = cell(resolution=resolution)
    options = {name: value for name, value in made["options"].items() if name not in ("rule", "stop", "reuse", "compress")}
    parts = [{"kind": kind, "count": n, "memory_bytes": share * resolution, "stored_bytes": share * resolution // 2}
             for n, (kind, share) in enumerate((("tops", 1), ("patterns", 2), ("pages", 55)))]
    kept = {"pages": 2, "nodes": 17, "blocks": 313, "tiles": resolution, "private_tiles": 78, "patterns": 447}
    return made | {"options": options | {"coding": "blocks"}, "size": {"file_bytes": 32 * resolution, "memory_bytes": 58 * resolution,
                                                                      "palette_blocks": kept, "parts": parts}}


def bench(*cells, **more):
    return {"vxs": "0.1.0", "started": "2026-01-31T12:00:00Z", "runs": 5, "points": 100000, "cells": list(cells),
            "machine": {"processor": "Abacus 3000", "cores": 2, "memory_bytes": 24 << 30, "system": "Linux", "renderer": "llvmpipe"},
            } | more


@pytest.fixture
def report(vxs, browser, tmp_path):
    """report(*benches): their page."""
    return pages_of(vxs, browser, tmp_path, SCHEMA)


@pytest.fixture
def rejected(vxs_path, tmp_path):
    """rejected(status, content or text, *arguments): the one line of an error."""
    return rejections_of(vxs_path, tmp_path)


def test_holds_the_figures(report):
    page = report(bench(cell(), cell(resolution=2048), cell(resolution=4096)))
    for word in ("3 bakes of city.glb", "Abacus 3000", "24 GiB", "64.0 KiB – 256.0 KiB", "32.8 ms – 262 ms", "0.49 % – 1.95 %",
                 "The file grows 2.00-fold with each doubling", "Bake time grows 2.83-fold with each doubling", "slope 1.50",
                 "2.00-fold, slope 1.00: city.glb", "12 345", "0.500", "random points", "50 ns", "900 ns", "101 ns", "4096³",
                 "Of random points, 0.031 % to 0.12 % are answered wrong"):
        assert word in page.text, word
    for stage in STAGES:
        assert stage in page.text
    assert "What each setting is worth" not in page.text and set(page.charts) == PLOTS


def test_charts_are_drawn(report):
    page = report(bench(cell(), cell(resolution=2048)))
    assert set(page.charts) == PLOTS
    for name, drawn in page.charts.items():
        assert len(" ".join([drawn["title"], *drawn["words"]]).split()) > 10, f"{name}: a title, axes with units"
        assert drawn["colours"] > 20, name
    assert "2.00-fold, slope 1.00: city.glb" in [item.lstrip("●") for item in page.charts["growth-bytes"]["key"]]


def test_charts_are_told_about_where_the_mouse_is(report, browser):
    report(bench(cell(), cell(resolution=2048)))
    assert told_at(browser, "growth-bytes", 0, 1) == "city.glb, 2048 texels: 128.0 KiB"


def test_codings_side_by_side(report):
    """Blocks have their own parts and counts, and are distinguished from DAGs by the coding alone."""
    page = report(bench(*(c for side in (1024, 2048) for c in (cell(resolution=side, coding="dag"), blocks(side)))))
    for word in ("coding blocks", "313", "447", "Parts of palette blocks", "tops", "patterns", "pages", "What each setting is worth"):
        assert word in page.text, word
    for word in ("NaN", "undefined", "no rule", "rule greedy", "no stop"):
        assert word not in page.text, word
    assert {"bytes-by-level-1", "nodes-by-level-1"} <= set(page.charts)
    alone = report(bench(blocks(), blocks(2048)))
    assert "masks inserted" not in alone.text and "masks inserted" in page.text and set(alone.charts) == PLOTS - {"nodes-by-level-1"}


def luminance(colour):
    parts = [int(n) / 255 for n in re.findall(r"\d+", colour)[:3]]
    return sum(w * (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055)**2.4) for w, p in zip((0.2126, 0.7152, 0.0722), parts))


def contrast(a, b):
    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("width, dark, media", [(1200, False, ""), (400, True, ""), (800, True, "print")])
def test_can_be_read(report, browser, tmp_path, width, dark, media):
    """In light and in dark, and on a telephone, where nothing but tables is wider than the screen."""
    report(bench(cell(), cell(resolution=2048, rule="shadow"), cell("a hill with a name that is rather long for its width.glb")))
    browser.show(tmp_path / "out.html", width, dark, media)
    paper, ink, little, painted = browser.ask("""(() => {
        if (matchMedia("print").matches) dispatchEvent(new Event("beforeprint"));
        const style = (element) => getComputedStyle(element);
        const probe = document.body.appendChild(document.createElement("i"));
        probe.style.color = Chart.defaults.color;
        return [style(document.body).backgroundColor, style(document.body).color, style(document.querySelector(".soft")).color,
            style(probe).color];
    })()""")
    assert (luminance(paper) < 0.05) == (dark and not media)
    assert contrast(paper, ink) > 7 and contrast(paper, painted) > 7 and contrast(paper, little) > 4.5
    assert media or browser.ask("document.documentElement.scrollWidth <= innerWidth")


def test_settings_and_files_are_told_apart(report, vxs, browser, tmp_path):
    page = report(bench(cell(), cell(rule="shadow"), cell("hills.glb"), cell("hills.glb", rule="shadow")), bench(cell()))
    for word in ("a bake without such is called base: rule greedy.", "rule shadow 2 1.50 1.50–1.50", "b0.json", "b1.json", "hills.glb"):
        assert word in page.text, word
    assert page.text.index("base") == page.text.index("base: rule greedy"), "said what it is where it first appears"
    for folder in "pq":
        (tmp_path / folder).mkdir()
        shutil.copy(tmp_path / "b1.json", tmp_path / folder / "same.json")
    (tmp_path / "out.html").write_text(vxs("report", tmp_path / "p" / "same.json", tmp_path / "q" / "same.json", "-o", "-").stdout)
    page = Page(browser, tmp_path / "out.html")
    assert f"{tmp_path}/p/same.json" in page.text and f"{tmp_path}/q/same.json" in page.text


def test_lights_of_one_scene_are_told_apart(report):
    assert "city.glb, lamp" in report(bench(cell(light="sun"), cell(light="lamp"))).text


def test_one_cell(report):
    page = report(bench(cell()))
    assert "1 bake of city.glb" in page.text and "The file by resolution: of one alone" in page.text


def test_nothing_at_all(report):
    """Figures that are zero have no place on logarithmic axes; without points there are no errors."""

    def empty(value):
        if isinstance(value, dict):
            return {k: v if k in ("options", "triangles", "lights", "maps", "filter_px", "smooth", "side_voxels") else empty(v)
                    for k, v in value.items()}
        if isinstance(value, list):
            return [empty(v) for v in value]
        return 0 if isinstance(value, (int, float)) else value

    content = bench(*(empty(cell(resolution=r)) for r in (64, 128)))
    page = report(content)
    assert "2 bakes" in page.text and "nan" not in page.text and "inf" not in page.text
    for c in content["cells"]:
        c["errors"] = c["lookups"] = []
    assert "How wrong" not in report(content).text


def test_no_wrong_answer_is_drawn(report):
    content = bench(cell(), cell(resolution=2048))
    content["cells"][1]["errors"][0]["wrong_share"] = 0
    assert "Of random points, 0 % to 0.12 % are answered wrong" in report(content).text


@pytest.mark.parametrize("names", [NASTY[n::3] for n in range(3)], ids=range(3))
def test_names_are_harmless(report, names):
    """As scenes, lights, options, stages, and of the machine."""
    cells = [cell(name, 1024 << n, name, rule=name, closed=[name, {name: 1}]) for n, name in enumerate(names)]
    for c, name in zip(cells, names):
        c["bake"]["stages"][3]["name"] = name
    content = bench(cell("plain.glb"), *cells, cell(names[0], light="b"))
    content["machine"] |= dict(zip(("processor", "system", "renderer"), names))
    page = report(content | {"vxs": names[0], "started": names[1]}, check=False)
    assert page.sources == []
    for name in names:
        assert not name.isprintable() or name in page.text


def test_names_of_files_are_harmless(vxs, browser, tmp_path):
    name = "'<b>`x` \\&#x0;\n.json"
    (tmp_path / name).write_text(json.dumps(bench(cell())))
    vxs("report", tmp_path / name, tmp_path / name, "-o", tmp_path / "out.html")
    assert "'<b>`x` \\&#x0;?.json" in Page(browser, tmp_path / "out.html").text


def broken(change):
    content = bench(cell(), cell(resolution=2048))
    change(content)
    return content


@pytest.mark.parametrize("content, says", [
    ("", "not JSON"),
    ("[1]", "no object"),
    ("{\"vxs\": NaN}", "not JSON"),
    (broken(lambda b: b.pop("machine")), "machine"),
    (broken(lambda b: b.update(cells=[])), "no cells"),
    (broken(lambda b: b.update(cells={})), "cells"),
    (broken(lambda b: b["cells"][1].pop("bake")), "cell 2"),
    (broken(lambda b: b["cells"][1]["options"].update(resolution_px=0)), "cell 2: \"resolution_px\""),
    (broken(lambda b: b["cells"][1]["options"].update(resolution_px="1024")), "resolution_px"),
    (broken(lambda b: b["cells"][0]["bake"]["total_seconds"].update(median="NaN")), "median"),
    (broken(lambda b: b["cells"][0]["bake"]["total_seconds"].update(median=1e300)), "median"),
    (broken(lambda b: b["cells"][0]["bake"]["total_seconds"].update(min=1e9)), "total_seconds"),
    (broken(lambda b: b["cells"][0]["errors"][0].update(wrong_share=1.5)), "wrong_share"),
    (broken(lambda b: b["cells"][0].update(scene=7)), "scene"),
    (broken(lambda b: b["cells"].append(3)), "cells"),
])
def test_other_json_is_refused(rejected, content, says):
    assert says in rejected(3, content)


def test_what_is_not_there(rejected, vxs, tmp_path):
    page = tmp_path / "out.html"
    assert "-o" in rejected(2, bench(cell()), "--")
    assert "input itself" in rejected(2, bench(cell()), "-o", tmp_path / "b.json")
    assert "No such file" in rejected(3, bench(cell()), tmp_path / "nobody.json", "-o", page)
    assert "cannot write" in rejected(4, bench(cell()), "-o", tmp_path / "nobody" / "out.html")
    assert "usage" in vxs("report", "-o", page, status=2).stderr


def test_same_figures_same_page(report):
    content = bench(cell(), cell(resolution=2048))
    assert report(content).source == report(copy.deepcopy(content)).source


def test_a_bench(vxs, browser, tmp_path):
    small_scene.write(tmp_path / "small.gltf")
    vxs("bench", tmp_path / "small.gltf", "-o", tmp_path / "b.json", "--runs", 1, "--points", 0, "--resolution", 32, "--resolution", 64)
    vxs("report", tmp_path / "b.json", "-o", tmp_path / "out.html")
    page = Page(browser, tmp_path / "out.html")
    assert "2 bakes of small.gltf" in page.text and "The file grows" in page.text and len(page.charts) == 4
