# vxs bake --report: the page of one bake says what its JSON says, and its pictures show the maps.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import re

import pytest

import small_scene
from page import Page, decode_png
from small_scene import GROUND, MORNING, NOON

CLASSES = {(0xf7, 0xd5, 0x7e), (0xf5, 0xb0, 0x41), (0xea, 0x7d, 0x2f), (0xd1, 0x45, 0x3b), (0x9c, 0x1f, 0x5f), (0x4c, 0x12, 0x6b)}
SHADOWS_PX = (480, 270)
NASTY = "<script>alert('x')</script> & \"`\\"


# where a box stands about a bulb, across an edge of its cube of maps: +x and +z, +z and -x, -x and -z, +y and +z, -y and +z
ACROSS = [(1, 0.4, 1), (-1, -0.4, 1), (-1, 0.2, -1), (0.3, 1, 1), (-0.3, -1, 1)]


def around_the_bulb(direction):
    centre = [3 * d + b for d, b in zip(direction, (0, 6, 0))]
    return tuple(c - 0.3 for c in centre), tuple(c + 0.3 for c in centre)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("pages")
    small_scene.write(path / "one.gltf", boxes=(GROUND, ((-1.3, 2, -1.3), (5.1, 3, 1.3))), lights=(("noon", "directional", NOON),))
    small_scene.write(path / "two.gltf", lights=(("bulb", "point", NOON), (NASTY, "directional", MORNING)))
    small_scene.write(path / "flat.gltf", boxes=(GROUND,), lights=(("noon", "directional", NOON),))
    small_scene.write(path / "around.gltf", boxes=[around_the_bulb(d) for d in ACROSS], lights=(("bulb", "point", NOON),))
    small_scene.write(path / "many.gltf", lights=[(f"spot{n}", "spot", NOON) for n in range(40)])
    return path


@pytest.fixture
def bake(vxs, browser, tmp_path):
    """bake(scene, *options): the page, the report as JSON, the asset."""

    def run(scene, *options):
        vxs("bake", scene, "-o", tmp_path / "a.vxs", "--report", tmp_path / "a.html", "--json", tmp_path / "a.json", *options)
        return Page(browser, tmp_path / "a.html"), json.loads((tmp_path / "a.json").read_text()), (tmp_path / "a.vxs").read_bytes()

    return run


def size_text(size):
    if size < 10240:
        return f"{size} B"
    unit = next((n for n in (1, 2, 3) if size / 1024 ** n < 1023.95), 4)
    return f"{size / 1024 ** unit:.{2 if size / 1024 ** unit < 9.995 else 1}f} {' KMGT'[unit]}iB"


@pytest.mark.parametrize("coding", ["dag", "blocks"])
def test_says_what_the_report_says(bake, folder, coding):
    page, report, _ = bake(folder / "two.gltf", "--resolution", 256, "--coding", coding)
    for size in (report["file_bytes"], report["peak_bytes"], *(light["size"]["stored_bytes"] for light in report["lights"])):
        assert size_text(size) in page.text
    for decision in report["plan"]["decisions"]:
        assert f"{decision['name']} {decision['choice']} {decision['reason']}" in page.text
    for stage in report["stages"]:
        assert re.search(rf" {stage['name']} [\d.]+ (µs|ms|s|ns) ", page.text) or stage["seconds"] < 1e-6
    kind = "pages" if coding == "blocks" else "masks"
    kept = sum(level["count"] for light in report["lights"] for level in light["levels"] if level["kind"] == kind)
    assert f"{kind} {kept} " in page.text and "12 triangles" not in page.text and "24 triangles and 2 lights" in page.text
    assert (" insert " in page.text) == (coding == "dag"), "blocks have no such stage"
    assert NASTY in page.text
    assert page.data["report"] == report, "one truth"


def colours(rows, x, y, side):
    """What is seen in a square of a picture."""
    return {rows[v][u] for v in range(y, y + side) for u in range(x, x + side)}


def test_pictures_show_depths_and_masks(bake, folder):
    """From noon: a block over a square ground, light on dark; every tile that needs masks is coloured, and no other."""
    page, report, _ = bake(folder / "one.gltf", "--resolution", 256, "--coding", "dag")
    assert page.sizes == [SHADOWS_PX] + [(256, 256)] * 3 and page.pictures[1] == page.pictures[2]
    depths, masks = map(decode_png, page.pictures[2:])
    light = report["lights"][0]
    coloured = [(x, y) for y in range(32) for x in range(32) if colours(masks, 8 * x, 8 * y, 8) <= {(*c, 255) for c in CLASSES}]
    assert len(coloured) == light["mask_tiles"] > 20
    for x in range(32):
        for y in range(32):
            assert (x, y) in coloured or not colours(masks, 8 * x, 8 * y, 8) & {(*c, 255) for c in CLASSES}
    block, ground = depths[128][128], depths[128][40]
    assert block[3] == ground[3] == 255 and block[0] > ground[0] + 50
    assert depths[2][2][3] == 0 or light["tiles_without_casters"] == 0
    assert (16, 16) not in coloured and (5, 16) not in coloured, "flat"
    assert all(len(colours(depths, 8 * x, 8 * y, 8)) > 1 for x, y in coloured), "the same place"
    assert any(3 < x < 28 and 3 < y < 28 for x, y in coloured), "the block's edge"


def test_shadows_come_first(vxs, bake, folder, tmp_path):
    """The scene as `vxs render --draw rays` draws it from the file, before all else but the title."""
    page, _, _ = bake(folder / "two.gltf", "--resolution", 256)
    assert page.text.index("looked up in the file") < page.text.index("How big?")
    vxs("render", folder / "two.gltf", tmp_path / "a.vxs", "-o", tmp_path / "a.png", "--draw", "rays", "--width", SHADOWS_PX[0],
        "--height", SHADOWS_PX[1])
    assert page.pictures[0] == (tmp_path / "a.png").read_bytes()


def test_says_how_it_was_made(bake, folder):
    os.utime(folder / "two.gltf", (0, 86400 * 365.25 * 30))
    page, report, _ = bake(folder / "two.gltf", "--resolution", 1024, "--region", "-1.5,-2,-3,4,5,123.456", "--level", 7)
    assert f"{NASTY}, directional, which travels (0.707, \N{MINUS SIGN}0.707, 0), 45° above the horizon: 1024 x 1024 texels of" in page.text
    assert "bulb, point: 6 maps of 1024 x 1024 texels of" in page.text
    assert f"two.gltf, {report['casters']['triangles']} triangles, written 2000-01-01 12:00 UTC" in page.text
    assert "region \N{MINUS SIGN}1.5,\N{MINUS SIGN}2,\N{MINUS SIGN}3,4,5,123.456" in page.text and "zstd level 7" in page.text and "exit auto" in page.text
    assert "resolution 1024" in page.text and "NaN" not in page.text and "[object" not in page.text
    assert f"by vxs {report['vxs']}, OpenGL by {report['renderer']}" in page.text


def test_options_of_all_kinds_are_said(bake, folder):
    page, _, _ = bake(folder / "two.gltf", "--sun", "noon=0,-1,0", "--sun", "0.5,-1,0", "--resolution", "noon=64", "--resolution", 32,
                      "--include", "*", "--include", "node:#0")
    for words in ("sun noon=0,\N{MINUS SIGN}1,0, sun=0.5,\N{MINUS SIGN}1,0", "light resolution noon=64", "resolution 32", "include *,node:#0"):
        assert words in page.text, words


def test_six_maps_are_one_cross(bake, folder):
    """The cube unfolded, as the bulb sees it with +y above and +x to the left of +z: a box across an edge goes on beyond it."""
    page, _, _ = bake(folder / "around.gltf", "--resolution", 1024)
    assert page.sizes[1:] == [(2048, 1536)] * 2
    assert "In the row: +x, +z, \N{MINUS SIGN}x, \N{MINUS SIGN}z; above +y, below \N{MINUS SIGN}y." in page.text
    cross, n = decode_png(page.pictures[2]), 512

    def seen(x, y):
        return cross[y][x][3] != 0

    for seam, height in ((1, 0.4), (2, -0.4), (3, 0.2)):
        y, mirrored = round(1.5 * n - height * n / 2), round(1.5 * n + height * n / 2)
        assert seen(seam * n - 5, y) and seen(seam * n + 5, y) and not seen(seam * n - 5, mirrored) and not seen(seam * n + 5, mirrored)
    for seam, left in ((1, 0.3), (2, -0.3)):
        x, mirrored = round(1.5 * n - left * n / 2), round(1.5 * n + left * n / 2)
        assert seen(x, seam * n - 5) and seen(x, seam * n + 5) and not seen(mirrored, seam * n - 5) and not seen(mirrored, seam * n + 5)


@pytest.mark.parametrize("width", [420, 800, 1300])
def test_nothing_is_cut_off(bake, browser, folder, tmp_path, width):
    """A page is no wider than its window, and no words lie over others."""
    bake(folder / "two.gltf", "--resolution", 256)
    browser.show(tmp_path / "a.html", width=width)
    assert browser.ask("document.documentElement.scrollWidth <= window.innerWidth")
    overlaps = browser.ask("""(() => {
        const boxes = [...document.querySelectorAll("h1, h2, h3, p, li, td, th, small, b, figcaption")]
            .filter((e) => e.textContent.trim() && !e.closest(".table")).map((e) => [e, e.getBoundingClientRect()]);
        return boxes.flatMap(([a, p], n) => boxes.slice(n + 1).filter(([b, q]) => !a.contains(b) && !b.contains(a)
            && p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1)
            .map(([b]) => `${a.textContent} / ${b.textContent}`));
    })()""")
    assert overlaps == []


def test_many_lights(bake, folder):
    """Some are pictured; and hints are those of the lights: a sun has no cone, and a lamp no region."""
    page, _, _ = bake(folder / "many.gltf", "--resolution", 64)
    assert "in its shadows, of the 6 largest lights, looked up in the file" in page.text
    assert len(page.pictures) == 2 + 4 and "36 more lights are not pictured" in page.text and "10 smaller lights take" in page.text
    hints = page.text.partition("What would make it smaller")[2].partition("Where the time goes")[0]
    assert "A narrower cone or a shorter range" in hints and "--region" not in hints


def test_hints_of_suns(bake, folder):
    page, _, _ = bake(folder / "one.gltf", "--sun", "noon=0,-1,0", "--sun", "dawn=1,-1,0", "--resolution", "noon=1024", "--resolution", 32)
    hints = page.text.partition("What would make it smaller")[2].partition("Where the time goes")[0]
    assert "The largest light, noon, takes" in hints and "--resolution noon=512" in hints and "--region" in hints and "cone" not in hints
    assert "--stop" not in hints, "what only a DAG could do otherwise"


def test_bytes_do_not_depend_on_the_page(vxs, bake, folder, tmp_path):
    for threads in (1, 3):
        _, _, asset = bake(folder / "two.gltf", "--resolution", 128, "--threads", threads)
        vxs("bake", folder / "two.gltf", "-o", tmp_path / "b.vxs", "--resolution", 128)
        assert (tmp_path / "b.vxs").read_bytes() == asset


def test_pictures_do_not_depend_on_tiles(vxs, bake, folder):
    """What fits into less memory is rendered in smaller tiles."""
    if "sanitize" in os.environ.get("VXS_FLAGS", ""):
        pytest.skip("a sanitizer holds more memory than the plan knows of")
    options = ("--resolution", 2048, "--maps", "gl")
    whole, report, _ = bake(folder / "one.gltf", *options)
    plan = json.loads(vxs("plan", folder / "one.gltf", *options, "--report", "a.html", "--json", "-").stdout)
    memory = (plan["least_bytes"] + plan["estimate"]["peak_bytes"]) // 2
    parts, tiled, _ = bake(folder / "one.gltf", *options, "--memory", memory)
    assert tiled["lights"][0]["tiles"] > report["lights"][0]["tiles"] == 1
    assert parts.pictures == whole.pictures


def test_pictures_count_as_memory(vxs, folder):
    peaks = [json.loads(vxs("plan", folder / "one.gltf", *options, "--json", "-").stdout)["estimate"]["peak_bytes"]
             for options in ((), ("--report", "a.html"))]
    assert 2 << 20 < peaks[1] - peaks[0] < 8 << 20


def test_names_that_are_one_file(vxs, folder, tmp_path):
    scene, page, asset = folder / "one.gltf", tmp_path / "p.html", tmp_path / "a.vxs"
    before = scene.read_bytes()
    (tmp_path / "link").symlink_to(tmp_path)
    for options, says in (
        (("-o", asset, "--report", asset), "expected two names"),
        (("-o", asset, "--report", tmp_path / "link" / "a.vxs"), "expected two names"),
        (("-o", asset, "--report", page, "--json", page), "expected two names"),
        (("-o", asset, "--report", scene), "input itself"),
        (("-o", "-", "--report", "-"), "exclude"),
        (("-o", asset, "--json", "-", "--report", "-"), "exclude"),
    ):
        assert says in vxs("bake", scene, "--resolution", 8, *options, status=2).stderr
    assert scene.read_bytes() == before and {p.name for p in tmp_path.iterdir()} == {"link"}


def test_all_or_nothing(vxs, folder, tmp_path):
    assert "No such file" in vxs("bake", folder / "one.gltf", "-o", tmp_path / "a.vxs", "--report", tmp_path / "nobody" / "p.html",
                                 status=4).stderr
    (tmp_path / "old.html").write_text("old")
    small_scene.write(tmp_path / "empty.gltf", boxes=())
    vxs("bake", tmp_path / "empty.gltf", "-o", tmp_path / "a.vxs", "--report", tmp_path / "old.html", status=5)
    assert (tmp_path / "old.html").read_text() == "old" and not (tmp_path / "a.vxs").exists()
    if os.path.exists("/dev/full"):
        vxs("bake", folder / "one.gltf", "-o", tmp_path / "a.vxs", "--resolution", 64, "--report", "/dev/full", status=4)


def test_to_standard_output(vxs, browser, folder, tmp_path):
    done = vxs("bake", folder / "one.gltf", "-o", tmp_path / "a.vxs", "--resolution", 64, "--verbose", "--report", "-")
    (tmp_path / "a.html").write_text(done.stdout)
    assert "noon" in Page(browser, tmp_path / "a.html").text and "stage" in done.stderr
