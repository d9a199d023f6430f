# vxs report: pages and plots of what vxs bench measured, of any names and figures.
# SPDX-License-Identifier: GPL-3.0-or-later
import copy
import json
import os
import pathlib
import shutil
import subprocess
import xml.etree.ElementTree

import jsonschema
import pytest

import small_scene
from page import SVG, Page, decode_png

SCHEMA = json.loads((pathlib.Path(__file__).resolve().parents[2] / "docs" / "bench.schema.json").read_text())
STAGES = ("load", "solids", "plan", "gl", "maps", "pyramid", "masks", "insert", "compress", "merge", "encode", "write")
PLOTS = {"bytes-by-level-1", "error-bake-random", "error-bake-surface", "error-bytes-random", "error-bytes-surface",
         "error-lookup-random", "error-lookup-surface", "growth-bytes", "growth-time", "nodes-by-level-1", "stages-1"}
NASTY = ["<script>alert(1)</script>", "\"><img src=x onerror=alert(1)>", "it's `touch pwned` \\", "'; system('touch pwned') #",
         "two\nlines\tand \u0001", "%s%n %d $HOME ${HOME} @a _b ^c {d", "&#x0; &#60;b&#62; &lt;", "\ufffe\uffff \u202eback", "x" * 300,
         "]]> --> </svg></title></style>", ""]

pytestmark = pytest.mark.skipif(not shutil.which("gnuplot"), reason="no gnuplot: package gnuplot-nox")


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
    errors += [{"points": points, "filter_px": 9, "checked": 100000, "rmse": 5 / resolution, "max_error": 0.25}
               for points in ("random", "surface")]
    return {
        "scene": scene, "triangles": 12345, "solid_triangles": 12000, "light": light, "lights": 1, "maps": 1,
        "options": {"resolution_px": resolution, "rule": "greedy", "stop": "final", "exit": "auto", "closed": "auto", "reuse": "on",
                    "compress": "auto", "threads": 2, "zstd_level": 12} | options,
        "bake": {"wall_seconds": spread(seconds * 1.1), "total_seconds": spread(seconds),
                 "maps_to_dag_seconds": spread(seconds / 4), "peak_bytes": 200 << 20,
                 "stages": [{"name": s, "seconds": spread(seconds / len(STAGES)), "peak_bytes": 100 << 20} for s in STAGES]},
        "size": {"file_bytes": int(size), "memory_bytes": int(3 * size), "nodes": 5 * resolution, "masks": resolution,
                 "inserted_nodes": 50 * resolution, "inserted_masks": 10 * resolution,
                 "levels": [{"side_voxels": side, "count": count, "memory_bytes": int(size) // len(levels),
                             "stored_bytes": int(size) // len(levels)} for side, count in levels]},
        "errors": errors,
        "lookups": [{"filter_px": 1, "nanoseconds": spread(50), "ray_nanoseconds": spread(900)},
                    {"filter_px": 9, "nanoseconds": spread(101)}],
    }


def bench(*cells, **more):
    return {"vxs": "0.1.0", "started": "2026-01-31T12:00:00Z", "runs": 5, "points": 100000, "cells": list(cells),
            "machine": {"processor": "Abacus 3000", "cores": 2, "memory_bytes": 24 << 30, "system": "Linux", "renderer": "llvmpipe"},
            } | more


@pytest.fixture
def report(vxs, tmp_path):
    """report(*benches): the page of JSONs that are first checked against the schema. plots: the folder `plots` gets plots, too."""

    def run(*benches, check=True, plots=False):
        for n, content in enumerate(benches):
            if check:
                jsonschema.Draft202012Validator(SCHEMA).validate(content)
            (tmp_path / f"b{n}.json").write_text(json.dumps(content))
        vxs("report", *(tmp_path / f"b{n}.json" for n in range(len(benches))), "-o", tmp_path / "out.html",
            *(("--plots", tmp_path / "plots") if plots else ()))
        return Page((tmp_path / "out.html").read_text())

    return run


@pytest.fixture
def rejected(vxs_path, tmp_path):
    """rejected(status, content or text, *arguments): the one line of an error; no page, no plots."""

    def run(status, content, *arguments, environment=None):
        text = content if isinstance(content, str) else json.dumps(content)
        (tmp_path / "b.json").write_text(text)
        before = sorted(tmp_path.iterdir())
        arguments = arguments or ("-o", tmp_path / "out.html", "--plots", tmp_path / "plots")
        done = subprocess.run([vxs_path, "report", tmp_path / "b.json", *arguments], capture_output=True, text=True,
                              env=os.environ | (environment or {}))
        assert (done.returncode, done.stdout) == (status, ""), done.stderr
        assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1
        assert sorted(tmp_path.iterdir()) == before and (tmp_path / "b.json").read_text() == text
        return done.stderr

    return run


def test_holds_the_figures(report):
    page = report(bench(cell(), cell(resolution=2048), cell(resolution=4096)))
    for word in ("3 bakes of city.glb", "Abacus 3000", "24 GiB", "64.0 KiB – 256.0 KiB", "32.8 ms – 262 ms", "0.49 % – 1.95 %",
                 "The file grows 2.00-fold with each doubling", "Bake time grows 2.83-fold with each doubling", "slope 1.50",
                 "2.00-fold, slope 1.00: city.glb", "12 345", "0.500", "random points", "50 ns", "900 ns", "101 ns", "4096³",
                 "Of random points, 0.031 % to 0.12 % are answered wrong"):
        assert word in page.text, word
    for stage in STAGES:
        assert stage in page.text
    assert "What each setting is worth" not in page.text and len(page.drawings) == len(PLOTS)


def drawn_text(drawing):
    return " ".join("".join(e.itertext()) for e in drawing.iter(SVG + "text"))


def test_plots_are_drawings_and_pictures(report, tmp_path):
    report(bench(cell(), cell(resolution=2048)), plots=True)
    files = {p.name for p in (tmp_path / "plots").iterdir()}
    assert files == {f"{n}.{suffix}" for n in PLOTS for suffix in ("svg", "png")}
    for name in PLOTS:
        drawing = xml.etree.ElementTree.parse(tmp_path / "plots" / f"{name}.svg").getroot()
        data = (tmp_path / "plots" / f"{name}.png").read_bytes()
        assert drawing.tag == SVG + "svg"
        assert int.from_bytes(data[16:20], "big") == 2 * int(drawing.get("width"))
        assert len(drawn_text(drawing).split()) > 10, "a title, axes with units"
    rows = decode_png((tmp_path / "plots" / "growth-bytes.png").read_bytes())
    assert len({p for row in rows for p in row}) > 20
    assert "slope 1.00" in drawn_text(xml.etree.ElementTree.parse(tmp_path / "plots" / "growth-bytes.svg"))


def test_settings_and_files_are_told_apart(report, vxs, tmp_path):
    page = report(bench(cell(), cell(rule="shadow"), cell("hills.glb"), cell("hills.glb", rule="shadow")), bench(cell()))
    for word in ("Base is rule greedy.", "rule shadow 2 1.50 1.50–1.50", "b0.json", "b1.json", "hills.glb"):
        assert word in page.text, word
    for folder in "pq":
        (tmp_path / folder).mkdir()
        shutil.copy(tmp_path / "b1.json", tmp_path / folder / "same.json")
    page = vxs("report", tmp_path / "p" / "same.json", tmp_path / "q" / "same.json", "-o", "-").stdout
    assert f"{tmp_path}/p/same.json" in Page(page).text and f"{tmp_path}/q/same.json" in Page(page).text


def test_lights_of_one_scene_are_told_apart(report):
    assert "city.glb, lamp" in report(bench(cell(light="sun"), cell(light="lamp"))).text


def test_one_cell(report):
    page = report(bench(cell()))
    assert "1 bake of city.glb" in page.text and "The file by resolution: of one alone" in page.text


def test_nothing_at_all(report):
    """Figures that are zero have no place on logarithmic axes; without points there are no errors."""

    def empty(value):
        if isinstance(value, dict):
            return {k: v if k in ("options", "triangles", "lights", "maps", "filter_px", "side_voxels") else empty(v)
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
    assert "Of random points, 0.0005 % to 0.12 % are answered wrong" in report(content).text


@pytest.mark.parametrize("names", [NASTY[n::3] for n in range(3)], ids=range(3))
def test_names_are_harmless(report, tmp_path, monkeypatch, names):
    """As scenes, lights, options, stages, and of the machine."""
    monkeypatch.chdir(tmp_path)
    cells = [cell(name, 1024 << n, name, rule=name, closed=[name, {name: 1}]) for n, name in enumerate(names)]
    for c, name in zip(cells, names):
        c["bake"]["stages"][3]["name"] = name
    content = bench(cell("plain.glb"), *cells, cell(names[0], light="b"))
    content["machine"] |= dict(zip(("processor", "system", "renderer"), names))
    page = report(content | {"vxs": names[0], "started": names[1]}, check=False, plots=True)
    assert not list(tmp_path.rglob("pwned")) and page.sources == []
    for plot in (tmp_path / "plots").glob("*.svg"):
        tags = {e.tag for e in xml.etree.ElementTree.parse(plot).iter()}
        assert tags <= {SVG + t for t in ("svg", "title", "desc", "g", "rect", "defs", "circle", "path", "use", "filter", "feFlood",
                                          "feComposite", "text", "tspan", "polygon")}, tags
    for name in names:
        assert not name.isprintable() or name in page.text


def test_names_of_files_are_harmless(vxs, tmp_path):
    name = "'<b>`x` \\&#x0;\n.json"
    (tmp_path / name).write_text(json.dumps(bench(cell())))
    vxs("report", tmp_path / name, tmp_path / name, "-o", tmp_path / "out.html")
    assert "'<b>`x` \\&#x0;?.json" in Page((tmp_path / "out.html").read_text()).text


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
    (tmp_path / "file").write_text("")
    assert "-o" in rejected(2, bench(cell()), "--plots", tmp_path / "plots")
    assert "input itself" in rejected(2, bench(cell()), "-o", tmp_path / "b.json")
    assert "No such file" in rejected(3, bench(cell()), tmp_path / "nobody.json", "-o", page)
    assert "no folder" in rejected(4, bench(cell()), "-o", page, "--plots", tmp_path / "file")
    assert "No such file" in rejected(4, bench(cell()), "-o", page, "--plots", tmp_path / "nobody" / "plots")
    assert "cannot write" in rejected(4, bench(cell()), "-o", tmp_path / "nobody" / "out.html")
    assert "usage" in vxs("report", "-o", page, status=2).stderr


def test_without_gnuplot(rejected, tmp_path):
    (tmp_path / "bin").mkdir()
    assert "gnuplot-nox" in rejected(6, bench(cell()), environment={"PATH": str(tmp_path / "bin")})
    (tmp_path / "bin" / "gnuplot").write_text("#!/bin/sh\necho that is wrong >&2\nexit 1\n")
    (tmp_path / "bin" / "gnuplot").chmod(0o755)
    assert "that is wrong" in rejected(6, bench(cell()), environment={"PATH": str(tmp_path / "bin")})


def test_same_figures_same_page(report):
    content = bench(cell(), cell(resolution=2048))
    assert report(content).source == report(copy.deepcopy(content)).source


def test_a_bench(vxs, tmp_path):
    small_scene.write(tmp_path / "small.gltf")
    vxs("bench", tmp_path / "small.gltf", "-o", tmp_path / "b.json", "--runs", 1, "--points", 0, "--resolution", 32, "--resolution", 64)
    vxs("report", tmp_path / "b.json", "-o", tmp_path / "out.html")
    page = Page((tmp_path / "out.html").read_text())
    assert "2 bakes of small.gltf" in page.text and "The file grows" in page.text and len(page.drawings) == 5
