# What is left free where it is requested: bake --behind free and --thickness. That it is no more than was requested, test_exact.py
# finds out.
# SPDX-License-Identifier: GPL-3.0-or-later
import json

import pytest

import small_scene
from test_docs import validator

UP = (0, 1, 0)  # it shines on the floors of boxes that are open above: sheets that face it
BEHIND, THICK = ("--behind", "free"), ("--thickness", 0.25)
ASKED = [BEHIND, THICK, BEHIND + THICK]
SIZE = ("--resolution", 512)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """The floor of a block floats behind the middle of a ground, and nothing behind the rest of it."""
    return small_scene.write(tmp_path_factory.mktemp("freedom") / "sheets.gltf", lights=(("up", "directional", UP),), open_faces=True)


@pytest.fixture
def bake(vxs, scene, tmp_path):
    def run(*options, name="out.vxs"):
        vxs("bake", scene, *SIZE, "-o", tmp_path / name, "--json", tmp_path / "out.json", *options)
        return json.loads((tmp_path / "out.json").read_text()), (tmp_path / name).read_bytes()

    return run


@pytest.mark.parametrize("options", ASKED)
@pytest.mark.parametrize("maps", [("--maps", "gl"), ("--gl", "egl")])
def test_depth_maps_cannot(vxs, scene, tmp_path, options, maps):
    error = vxs("bake", scene, "-o", tmp_path / "no.vxs", *options, *maps, status=2).stderr
    assert f"{options[0]} " in error and "expected --maps sparse" in error
    assert not (tmp_path / "no.vxs").exists()


@pytest.mark.parametrize("metres", ["0", "-1", "nan", "inf", "thick"])
def test_thickness_is_a_length(vxs, scene, tmp_path, metres):
    assert f"--thickness {metres}" in vxs("bake", scene, "-o", tmp_path / "no.vxs", "--thickness", metres, status=2).stderr


@pytest.mark.parametrize("options", ASKED)
def test_files_say_what_they_leave_free(vxs, bake, tmp_path, options):
    report, _ = bake(*options)
    validator("bake-report").validate(report)
    asked = {"behind": "free"} if "--behind" in options else {}
    asked |= {"thickness_m": 0.25} if "--thickness" in options else {}
    info = json.loads(vxs("info", tmp_path / "out.vxs", "--json", "-").stdout)
    validator("info").validate(info)
    for told in (report["options"], info["metadata"]["options"]):
        assert {key: told[key] for key in ("behind", "thickness_m") if key in told} == asked
    assert " ".join(str(word) for word in options) in vxs("info", tmp_path / "out.vxs").stdout
    bake()
    assert "--behind" not in vxs("info", tmp_path / "out.vxs").stdout and "--thickness" not in vxs("info", tmp_path / "out.vxs").stdout


@pytest.mark.parametrize("options", [(), *ASKED])
def test_what_is_followed_or_too_far_behind_stays_dark(vxs, bake, tmp_path, options):
    bake(*options)
    lit = vxs("query", tmp_path / "out.vxs", input="0 -1.2 0\n4 -1.2 4\n0 -0.6 0\n0 1 0\n").stdout.split()
    assert [float(value) for value in lit] == [1, 1, 0, 0]


def test_kept_squares_are_of_the_same_options(bake, tmp_path):
    made = []
    for options in [(), *ASKED, ("--thickness", 0.125), ("--thickness", 0.125)]:
        report, kept = bake(*options, "--resume", tmp_path / "squares")
        assert kept == bake(*options, name="fresh.vxs")[1]
        made.append(report["squares"]["made"])
    assert all(made[:-1]) and made[-1] == 0


@pytest.mark.parametrize("options", ASKED)
def test_parts_are_of_the_same_options(vxs, scene, bake, tmp_path, options):
    parts = [tmp_path / f"{n}.part" for n in (1, 2, 3)]
    for path, part, asked in zip(parts, ("1/2", "2/2", "2/2"), (options, options, ())):
        vxs("bake", scene, *SIZE, "-o", path, "--part", part, *asked)
    vxs("merge", *parts[:2], "-o", tmp_path / "merged.vxs")
    assert (tmp_path / "merged.vxs").read_bytes() == bake(*options)[1]
    assert "parts of different bakes" in vxs("merge", parts[0], parts[2], "-o", tmp_path / "no.vxs", status=3).stderr


def test_up_to_date_with_the_same_options_alone(bake):
    changed = [not bake(*options, "--if-changed")[0]["unchanged"] for options in [(), (), BEHIND, BEHIND, THICK, THICK]]
    assert changed == [True, False] * 3


def test_same_bytes_on_all_processors_and_threads(vxs, bake, monkeypatch):
    found = set()
    for cpu in ("sse2", "avx2", "avx512"):
        monkeypatch.setenv("VXS_CPU", cpu)
        found |= {bake(*BEHIND, *THICK, "--threads", threads)[1] for threads in (1, 3)}
    assert len(found) == 1


def test_plan_says_what_it_would_save(vxs, scene, bake):
    def plan(*options):
        found = json.loads(vxs("plan", scene, "--sun", "0.3,1,0.2", "--resolution", 1024, *options, "--json", "-").stdout)
        validator("plan").validate(found)
        return {saving["option"]: saving["file_bytes"] for saving in found["savings"]}, found["estimate"]["file_bytes"]

    savings, now = plan()
    assert savings and all(0 < size <= 0.9 * now for size in savings.values())
    assert "--behind free" in savings and "--behind free" not in plan(*BEHIND)[0]
    assert "--behind free: " in vxs("plan", scene, "--sun", "0.3,1,0.2", "--resolution", 1024).stdout
    assert plan("--closed", "on", "--maps", "gl")[0] == {}


@pytest.mark.parametrize("options", ASKED)
def test_compare_counts_nothing_wrong_that_is_free(vxs, scene, tmp_path, options):
    vxs("bake", scene, *SIZE, "--sun", "0.3,1,0.2", "-o", tmp_path / "out.vxs", *options)
    report = json.loads(vxs("compare", scene, tmp_path / "out.vxs", "--points", 4000, "--filter", 3, "--json", "-").stdout)
    validator("compare").validate(report)
    counts = [report["assets"][0]["lights"][0][kind] for kind in ("random", "surface")]
    assert sum(one["left_free"] for one in counts) > 0 and sum(one["unexplained"] for one in counts) == 0
    assert all(one["points"] == one["outside"] + one["inside_solid"] + one["left_free"] + one["checked"] for one in counts)
