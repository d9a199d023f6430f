# The errors of vxs compare can be falsified: an asset that every check of the format passes, but that is wrong by a shift of one
# texel or voxel, one node or one bit of a mask, is distinguished from the sound one. Some 20 s on two cores.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import random
import subprocess

import pytest

import damage
import small_scene

SUN = "-0.3,-1,-0.2"
POINTS = 40000
ANSWERS = 20000


class Compared:
    """What vxs compare says of an asset with one light."""

    def __init__(self, vxs_path, scene, asset, *options):
        done = subprocess.run([vxs_path, "compare", scene, asset, "--points", str(POINTS), "--json", "-", *map(str, options)],
                              capture_output=True, text=True, timeout=600)
        assert done.returncode in (0, 1), done.stderr
        asset, = json.loads(done.stdout)["assets"]
        light, = asset["lights"]
        self.failed, self.unexplained, self.share = done.returncode, asset["unexplained"], asset["wrong_share"]
        self.random, self.surface = light["random"], light["surface"]


@pytest.fixture(scope="module")
def folder(vxs, tmp_path_factory):
    """A city, and a cube of floating boxes that fills its map from the near to the far side, each with a sound asset, a DAG."""
    at, dice = tmp_path_factory.mktemp("faults"), random.Random(1)
    vxs("scene", "city", "--triangles", 4000, "--blocks", 3, "--sun", SUN, "-o", at / "city.glb")
    corners = [tuple(dice.uniform(0, 14) for _ in range(3)) for _ in range(40)]
    boxes = [(corner, tuple(c + dice.uniform(0.3, 2) for c in corner)) for corner in corners]
    small_scene.write(at / "boxes.gltf", boxes=boxes)
    for scene, resolution in (("city.glb", 128), ("boxes.gltf", 64)):
        vxs("bake", at / scene, "--resolution", resolution, "--coding", "dag", "-o",
            (at / scene).with_suffix(".vxs"))
    return at


@pytest.fixture(scope="module")
def sound(vxs_path, folder):
    return {scene: Compared(vxs_path, folder / scene, (folder / scene).with_suffix(".vxs")) for scene in ("city.glb", "boxes.gltf")}


@pytest.fixture
def damaged(vxs, folder, tmp_path):
    """damaged(scene, change): the path of its asset after change(asset), which must leave it valid."""

    def run(scene, change):
        asset = damage.Asset((folder / scene).with_suffix(".vxs"))
        change(asset)
        path = asset.write(tmp_path / "damaged.vxs")
        vxs("validate", path)
        return path

    return run


def answers(vxs, asset, points):
    return vxs("query", asset, input="".join("%.9g %.9g %.9g\n" % point for point in points)).stdout.split()


# -- shifts ----------------------------------------------------------------------------------------------------


def test_nothing_changed_is_nothing_found(vxs_path, folder, sound, damaged):
    """Taking a file apart and putting it together is no damage."""
    same = Compared(vxs_path, folder / "city.glb", damaged("city.glb", lambda asset: None))
    assert (same.random, same.surface) == (sound["city.glb"].random, sound["city.glb"].surface)


@pytest.mark.parametrize("texels, voxels", [((1, 0), 0), ((-1, 0), 0), ((0, 1), 0), ((0, -1), 0), ((0, 0), 1), ((0, 0), -1)])
def test_a_shift_of_one_shows(vxs_path, folder, sound, damaged, texels, voxels):
    """As unexplained answers, on surfaces and off them. And more are wrong; on surfaces the error of the bias adds to both."""
    path, right = damaged("city.glb", lambda asset: asset.shift(texels, voxels)), sound["city.glb"]
    found = Compared(vxs_path, folder / "city.glb", path)
    assert not right.failed and right.unexplained == 0
    assert found.failed and found.surface["unexplained"] > 500 and found.random["unexplained"] > 50
    assert found.surface["wrong"] > 1.25 * right.surface["wrong"] and found.random["wrong"] > 1.1 * right.random["wrong"]
    wrong, sound_texels = found.random["boundary_texels"], right.random["boundary_texels"]
    assert wrong["median"] > 1.5 * sound_texels["median"] and sound_texels["median"] < 0.2 and wrong["median"] > 0.25


# -- nodes and masks -------------------------------------------------------------------------------------------


def node_damages(asset, dice, count):
    """Some changes of one node: a child that was lit is dark, or the other way round, or a child is another node."""
    found = []
    for level in range(asset.levels()):
        references = asset.references(level)
        back = [n for n, value in enumerate(references) if value and references[:n].count(0) > 1]
        for n in dice.sample(back, min(count, len(back))):
            named = references[:n].count(0)
            found.append((f"level {level}, reference {n}", lambda a, l=level, n=n, d=references[n] % named + 1: a.refer(l, n, d)))
        states = [(node, c) for node, states in enumerate(asset.states(level)) for c in range(8) if states[c] < damage.OWN]
        for node, c in dice.sample(states, min(count, len(states))):
            found.append((f"level {level}, node {node}, child {c}", lambda a, l=level, n=node, c=c: a.turn_state(l, n, c)))
    return found


def in_the_box(dice):
    return [tuple(dice.uniform(0, 15) for _ in range(3)) for _ in range(ANSWERS)]


def test_a_wrong_node_shows_in_the_answers_that_it_changes(vxs, vxs_path, folder, sound, damaged):
    """Whatever changes one answer of a thousand is unexplained somewhere; smaller ones show in the number of wrong answers."""
    dice = random.Random(1)
    points, right = in_the_box(dice), sound["boxes.gltf"]
    before, changed, more = answers(vxs, folder / "boxes.vxs", points), [], []
    for what, change in node_damages(damage.Asset(folder / "boxes.vxs"), dice, 2):
        path = damaged("boxes.gltf", change)
        found = Compared(vxs_path, folder / "boxes.gltf", path)
        changed.append(sum(a != b for a, b in zip(before, answers(vxs, path, points))) / ANSWERS)
        more.append((found.random["wrong"] - right.random["wrong"]) / POINTS)
        print(f"{what}: {changed[-1]:.6f} of the answers change, {more[-1]:.6f} more are wrong, {found.unexplained} unexplained")
        if changed[-1] > 0.001:
            assert found.failed and found.unexplained and more[-1] > 0.3 * changed[-1], what
    assert len(changed) > 7 and sum(share > 0.001 for share in changed) > 3
    assert sum(more) > 0.7 * sum(changed)


def test_a_wrong_bit_shows_when_a_point_meets_it(vxs, vxs_path, folder, damaged):
    """4096 voxels and 40000 points: each is met. In a large map one voxel is not, unless its mask is used often."""
    vxs("bake", folder / "boxes.gltf", "--resolution", 16, "--coding", "dag", "-o", folder / "few.vxs")
    dice, asset = random.Random(1), damage.Asset(folder / "few.vxs")
    points, right = in_the_box(dice), Compared(vxs_path, folder / "boxes.gltf", folder / "few.vxs")
    before, seen = answers(vxs, folder / "few.vxs", points), 0
    for mask, bit in [(dice.randrange(asset.masks()), dice.randrange(64)) for _ in range(8)]:
        path = damaged("few.vxs", lambda a, mask=mask, bit=bit: a.turn_bit(mask, bit))
        differs = Compared(vxs_path, folder / "boxes.gltf", path).random != right.random
        assert differs or answers(vxs, path, points) == before, (mask, bit)
        seen += differs
    assert seen > 5
