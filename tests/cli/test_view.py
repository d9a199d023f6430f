# vxs view: the page holds the scene with its files, the asset and texts, byte by byte; and what is refused. What a browser makes of the
# page is in tests/web/view.test.mjs.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import html.parser
import json
import os
import re
import shutil
import struct
import subprocess

import pytest

import small_scene
from conftest import ROOT
from test_faults import one_error_line

MARK = "<!--vxs:level:1-->"
HEAD, TAIL = "<!doctype html><title>é</title>\n", "\n<p>behind</p>\n"
SMALL = ("--resolution", 64)
BUILT = ROOT / "build/web/view.html"
NASTY = "</script><!--<script>&amp; ünï日本"  # what could end an element, or be taken for one


@pytest.fixture(scope="module")
def made(vxs, tmp_path_factory):
    """A template, a scene in one file, and its asset with the report of its bake."""
    folder = tmp_path_factory.mktemp("view")
    (folder / "page.html").write_text(HEAD + MARK + TAIL)
    small_scene.write(folder / "level.gltf", lights=(("sun", "directional", small_scene.NOON), (NASTY, "directional", small_scene.MORNING)))
    vxs("bake", folder / "level.gltf", "-o", folder / "level.vxs", *SMALL, "--json", folder / "bake.json")
    return folder


@pytest.fixture
def view(vxs, made, tmp_path):
    def view(*args, status=0, template=made / "page.html"):
        done = vxs("view", *args, "-o", tmp_path / "out.html", "--page", template, status=status)
        assert status == 0 or (one_error_line(done) and not (tmp_path / "out.html").exists())
        return done

    view.page = tmp_path / "out.html"
    return view


class Scripts(html.parser.HTMLParser):
    """The attributes and the text of each script element, as a browser finds them."""

    def __init__(self, text):
        super().__init__(convert_charrefs=False)
        self.scripts = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "script":
            self.scripts.append([dict(attrs), ""])

    def handle_data(self, data):
        if self.cdata_elem == "script":
            self.scripts[-1][1] += data


def level_of(page):
    """What a page holds: its texts, and its files as bytes."""
    scripts, files = Scripts(page).scripts, []
    for attributes, text in scripts:
        if "data-vxs" in attributes:
            index = int(attributes["data-vxs"])
            files += [b""] * (index + 1 - len(files))
            assert len(text) <= 4 << 20 and index == len(files) - 1, "in order, and no element is large"
            files[index] += base64.b64decode(text, validate=True)
    texts = [json.loads(text) for attributes, text in scripts if attributes.get("id") == "vxs-level"]
    assert len(texts) == 1 and [len(data) for data in files] == [file["size_bytes"] for file in texts[0]["files"]]
    return texts[0], files


def test_the_page_holds_the_files(view, made):
    done = view(made / "level.gltf", made / "level.vxs")
    page = view.page.read_text()
    assert page.startswith(HEAD) and page.endswith(TAIL) and MARK not in page
    texts, files = level_of(page)
    assert files == [(made / "level.gltf").read_bytes(), (made / "level.vxs").read_bytes()]
    assert texts["scene"] == {"name": "level.gltf", "scene": None} and texts["asset"] == {"name": "level.vxs"}
    assert [file["uri"] for file in texts["files"]] == [None, None] and str(made) not in page
    assert f"{view.page}, " in done.stdout and re.search(r": scene \d+ B, shadows \d+ B\n$", done.stdout)


def test_large_files_are_cut(view, made, tmp_path):
    """At whole triples of bytes, so that only the last piece is padded: 3 MiB, and what is one byte more or less."""
    for more in (-1, 0, 1):
        text = (made / "level.gltf").read_bytes()
        (tmp_path / "large.gltf").write_bytes(text + b" " * ((3 << 20) + more - len(text)))
        view(tmp_path / "large.gltf", made / "level.vxs")
        assert level_of(view.page.read_text())[1][0] == (tmp_path / "large.gltf").read_bytes()


def test_without_an_asset_the_scene_is_baked(view, vxs, made, tmp_path):
    done = view(made / "level.gltf", "--resolution", 128, "--light", "sun")
    vxs("bake", made / "level.gltf", "-o", tmp_path / "same.vxs", "--resolution", 128, "--light", "sun")
    texts, files = level_of(view.page.read_text())
    assert files[1] == (tmp_path / "same.vxs").read_bytes() and texts["asset"] == {"name": None}
    assert "baked shadows: " in done.stdout and "128 x 128 texels" in done.stdout and "page " in done.stdout
    assert "baked shadows, " in view(made / "level.gltf", *SMALL, "--verbose").stdout


def test_files_beside_the_scene(view, vxs, made, tmp_path):
    """Buffers and images go into the page by their URIs, each once; a missing image is a warning, a missing buffer an error."""
    gltf = json.loads((made / "level.gltf").read_text())
    (tmp_path / "the buffer.bin").write_bytes(base64.b64decode(gltf["buffers"][0]["uri"].partition(",")[2]))
    (tmp_path / "<").mkdir()
    (tmp_path / "</script>ü.png").write_bytes(b"a picture")
    gltf["buffers"][0]["uri"] = "the%20buffer.bin"
    gltf["images"] = [{"uri": "</script>ü.png"}, {"uri": "</script>ü.png"}, {"uri": "gone.png"}, {"uri": "data:image/png;base64,AAAA"}]
    (tmp_path / "apart.gltf").write_text(json.dumps(gltf))
    done = view(tmp_path / "apart.gltf", made / "level.vxs")
    texts, files = level_of(view.page.read_text())
    assert [file["uri"] for file in texts["files"]] == [None, "the%20buffer.bin", "</script>ü.png", None]
    assert files[1:3] == [(tmp_path / "the buffer.bin").read_bytes(), b"a picture"]
    missing = [text for text in texts["warnings"] if "gone.png" in text]
    assert missing == [line.removeprefix("vxs: warning: ") for line in done.stderr.splitlines() if "gone.png" in line] and len(missing) == 1
    view.page.unlink()
    assert "gone.png" in view(tmp_path / "apart.gltf", made / "level.vxs", "--strict", status=1).stderr
    (tmp_path / "the buffer.bin").unlink()
    assert "cannot read buffer 0" in view(tmp_path / "apart.gltf", made / "level.vxs", status=3).stderr


def test_a_glb_may_have_files_beside_it(view, made, tmp_path):
    gltf = json.loads((made / "level.gltf").read_text())
    data = base64.b64decode(gltf["buffers"][0].pop("uri").partition(",")[2])
    gltf["images"] = [{"uri": "wall.png"}]
    (tmp_path / "wall.png").write_bytes(b"a wall")
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    (tmp_path / "level.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
    view(tmp_path / "level.glb", made / "level.vxs")
    assert level_of(view.page.read_text())[1][:2] == [(tmp_path / "level.glb").read_bytes(), b"a wall"]


def test_texts_cannot_end_their_element(view, made, tmp_path):
    """Names of files, URIs and warnings."""
    folder = tmp_path / "<script>"
    folder.mkdir()
    shutil.copy(made / "level.gltf", folder / "<!--ü.gltf")
    report = json.loads((made / "bake.json").read_text()) | {"warnings": [NASTY, "plain"]}
    (folder / "bake.json").write_text(json.dumps(report))
    view(folder / "<!--ü.gltf", made / "level.vxs", "--bake-report", folder / "bake.json", "--scene", "small")
    page = view.page.read_text()
    texts, _ = level_of(page)
    assert texts["scene"] == {"name": "<!--ü.gltf", "scene": "small"} and texts["warnings"][:2] == [NASTY, "plain"]
    assert page.count("</script>") == page.count("<script ") == 3 and "<!--" not in page.removeprefix(HEAD)


def test_reports_that_are_none(view, made, tmp_path):
    (tmp_path / "no.json").write_text('{"warnings": 3}')
    assert "a list as warnings" in view(made / "level.gltf", made / "level.vxs", "--bake-report", tmp_path / "no.json", status=3).stderr


def test_another_scene_is_a_warning_on_the_page(view, made, tmp_path):
    small_scene.write(tmp_path / "other.gltf", boxes=(small_scene.GROUND,), lights=(("sun", "directional", small_scene.NOON),))
    done = view(tmp_path / "other.gltf", made / "level.vxs")
    texts, _ = level_of(view.page.read_text())
    assert any("was baked from another scene" in text and text in done.stderr for text in texts["warnings"])
    view(made / "level.gltf", made / "level.vxs")
    assert not any("another scene" in text for text in level_of(view.page.read_text())[0]["warnings"])


@pytest.mark.parametrize("line, status, says", [
    (["level.gltf", "broken.vxs"], 3, "is not a valid .vxs file"),
    (["level.gltf", "gone.vxs"], 3, "gone.vxs"),
    (["level.vxs", "level.gltf"], 3, "they are swapped"),
    (["level.vxs"], 3, "expected a glTF scene"),
    (["level.gltf", "level.gltf"], 3, "expected a .vxs file"),
    (["level.gltf", "level.vxs", "level.vxs"], 2, "unexpected argument"),
    ([], 2, "SCENE is missing"),
    (["-", "level.vxs"], 2, "SCENE - is read twice"),
    (["level.gltf", "level.vxs", "--sun", "0,-1,0"], 2, "--sun is an option of the bake"),
    (["level.gltf", "level.vxs", "--light", "sun"], 2, "--light is an option of the bake"),
    (["level.gltf", "level.vxs", "--resolution", "64"], 2, "--resolution is an option of the bake"),
    (["level.gltf", "level.vxs", "--texel", "1"], 2, "--texel is an option of the bake"),
    (["level.gltf", "level.vxs", "--region", "0,0,0,1,1,1"], 2, "--region is an option of the bake"),
    (["level.gltf", "--resolution", "100"], 2, "a power of two"),
    (["level.gltf", "--bake-report", "bake.json"], 2, "--bake-report goes with FILE.vxs"),
    (["level.gltf", "level.vxs", "--scene", "none"], 2, "none"),
])
def test_what_is_refused(view, made, monkeypatch, line, status, says):
    monkeypatch.chdir(made)
    (made / "broken.vxs").write_bytes((made / "level.vxs").read_bytes()[:-1])
    assert says in view(*line, status=status).stderr


def test_templates(view, made, tmp_path, vxs_path):
    """The one that is named; $VXS_DATA; beside the program. Without one, the message has the remedy, and nothing is baked."""
    (tmp_path / "other.html").write_text("<p>")
    assert "no template of this version" in view(made / "level.gltf", status=3, template=tmp_path / "other.html").stderr
    assert "gone.html" in view(made / "level.gltf", status=3, template=tmp_path / "gone.html").stderr

    program = tmp_path / "tree/bin/vxs"
    program.parent.mkdir(parents=True)
    shutil.copy(vxs_path, program)

    def run(**more):
        return subprocess.run([program, "view", made / "level.gltf", made / "level.vxs", "-o", "-"], capture_output=True, text=True, env=os.environ | more)

    done = run()
    assert done.returncode == 3 and "'make web' builds it, or --page FILE.html names its place" in done.stderr and one_error_line(done)
    for place, text in (("tree/web", "web"), ("tree/share/vxs", "share"), ("data", "data")):
        (tmp_path / place).mkdir(parents=True)
        (tmp_path / place / "view.html").write_text(f"<p>{text}</p>{MARK}")
        found = run(**({"VXS_DATA": str(tmp_path / "data")} if text == "data" else {}))
        assert found.returncode == 0 and found.stdout.startswith(f"<p>{text}</p><script ")


def test_standard_output(vxs, view, made):
    view(made / "level.gltf", made / "level.vxs")
    done = vxs("view", made / "level.gltf", made / "level.vxs", "-o", "-", "--page", made / "page.html")
    assert done.stdout == view.page.read_text() and "page         standard output: scene " in done.stderr


def test_the_built_page(vxs, made, tmp_path):
    """Its size without a level is below 1.6 MB, it has its mark once, and it asks nothing of a network."""
    if not BUILT.is_file():
        pytest.skip("no build/web/view.html: make web builds it")
    page = BUILT.read_text()
    assert len(BUILT.read_bytes()) < 1_600_000 and page.count(MARK) == 1
    tags = [attributes for attributes, _ in Scripts(page).scripts]
    assert tags and not any("src" in attributes for attributes in tags)
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', page)[1]
    assert policy.startswith("default-src 'none';") and not re.search(r"https?:|\*|'self'", policy)
    vxs("view", made / "level.gltf", made / "level.vxs", "-o", tmp_path / "a.html", "--page", BUILT)
    assert level_of((tmp_path / "a.html").read_text())[1][0] == (made / "level.gltf").read_bytes()
