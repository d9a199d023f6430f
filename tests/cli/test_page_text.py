# Section 14 of formats/vxs.md is true: a decoder that is written from it alone, page_text.py, comes to the words of libvxs.
# SPDX-License-Identifier: GPL-3.0-or-later
import itertools
import os
import struct
import subprocess

import pytest

import fast_text
from page_text import Page, Refused, Resident
from test_format import GOLDEN, libraries, words_by_libvxs


class Parts:
    """Bytes, taken piece by piece."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, size):
        self.at += size
        return self.data[self.at - size:self.at]

    def numbers(self, count):
        return list(struct.unpack(f"<{count}I", self.take(4 * count)))

    def nodes(self, count):
        return list(struct.iter_unpack("<4Ii", self.take(20 * count)))


def samples(data):
    """A resident part, its levels and maps, its words and nodes; packing, nodes, words and bytes of a page that stands on its common pool."""
    parts = Parts(data)
    while parts.at < len(data):
        levels, maps, resident_bytes, word_count, node_count, packing, page_nodes, page_words, page_bytes = parts.numbers(9)
        yield (parts.take(resident_bytes), levels, maps, parts.numbers(word_count), parts.nodes(node_count), packing, parts.nodes(page_nodes),
               parts.numbers(page_words), parts.take(page_bytes))


def test_any_page_that_the_layout_allows(vxs_path, tmp_path):
    path, program, count = tmp_path / "pages", vxs_path.parent / "tests" / "unit" / "test_page", 0
    if not program.exists():
        pytest.skip("no unit tests")
    subprocess.run([program], env=os.environ | {"VXS_PAGES_OUT": str(path)}, check=True)
    for data, levels, maps, words, nodes, packing, page_nodes, page_words, page in samples(path.read_bytes()):
        resident = Resident(data, levels, maps, packing)
        assert resident.words == words
        assert [node for nodes_of_page in resident.pages for node in nodes_of_page] == nodes
        assert Page(page, page_nodes, resident.common, packing).words == page_words
        for end in (page[:-2], page[:-8] + bytes(2) + page[-8:], page[:-1] + bytes([page[-1] ^ 0x80])):
            with pytest.raises(Refused):
                Page(end, page_nodes, resident.common, packing)
        count += 1
    assert count == 30


def lights_of(vxs_path, path, lights):
    """Of lights by number: their words by libvxs, where their pages start, the bytes of the resident part and of pages."""
    if vxs_path.parent.name in ("asan", "tsan"):
        pytest.skip("libvxs.so needs a sanitizer")
    data = path.read_bytes()
    entries = list(struct.iter_unpack("<4s3I4Q", data[64:64 + 48 * struct.unpack_from("<I", data, 12)[0]]))
    contents = {(kind, light): data[offset:offset + stored] for kind, _, light, _, offset, stored, _, _ in entries}
    for light in lights:
        words = words_by_libvxs(vxs_path.parent / "libvxs.so", path, light)
        pages = Parts(contents[b"PAGE", light])
        count, size = pages.numbers(2)
        assert size == 16 and count == words[0] > 0
        starts, words[8:8 + count] = words[8:8 + count], [0] * count
        table = [pages.numbers(4)[:2] for _ in range(count)]
        assert starts + [len(words)] == list(itertools.accumulate((n for _, n in table), initial=starts[0]))
        yield words, starts, contents[b"RSDT", light], [pages.take(stored) for stored, _ in table]


def check_small(vxs_path, path, lights, packing=0):
    """lights  their numbers, levels and maps"""
    for (_, levels, maps), (words, starts, resident, pages) in zip(lights, lights_of(vxs_path, path, [n for n, *_ in lights])):
        known = Resident(resident, levels, maps)
        assert known.words == words[:starts[0]] and len(known.pages) == len(pages)
        for page, nodes, start in zip(pages, known.pages, starts, strict=True):
            found = Page(page, nodes, known.common, packing).words
            assert found == words[start:start + len(found)]


def check_fast(vxs_path, path, lights, inflate):
    for words, starts, resident, pages in lights_of(vxs_path, path, lights):
        assert fast_text.resident_words(resident, inflate) == words[:starts[0]]
        for page, start in zip(pages, starts, strict=True):
            found = fast_text.Page(page, inflate).words
            assert found == words[start:start + len(found)]


@pytest.mark.parametrize("kind, resolution, map_counts", [("room", 512, [6, 1]), ("landscape", 1024, [1])])
def test_pages_of_bakes(vxs, vxs_path, libraries, tmp_path, kind, resolution, map_counts):
    """Where sheets go on from block to block."""
    scene, path = tmp_path / "scene.glb", tmp_path / "baked.vxs"
    vxs("scene", kind, "--triangles", 2500, "-o", scene)
    bake = ["bake", scene, "--coding", "blocks", "--resolution", resolution, "-o", path]
    vxs(*bake)
    check_small(vxs_path, path, [(light, resolution.bit_length() - 1, maps) for light, maps in enumerate(map_counts)])
    vxs(*bake, "--pack", "fast")
    check_fast(vxs_path, path, range(len(map_counts)), libraries[0])


def test_pages_of_the_golden_file(vxs_path, libraries):
    """One of the small lights has several pages, and a common pool."""
    check_small(vxs_path, GOLDEN / "blocks.vxs", [(0, 9, 1), (1, 13, 1)])
    check_fast(vxs_path, GOLDEN / "blocks.vxs", [2, 3], libraries[0])


def test_pages_of_a_fine_bake(vxs, vxs_path, tmp_path):
    """Of a map of 2^15 texels, whose pages have more contexts. One page, as there are some seconds in each."""
    scene, path = tmp_path / "scene.glb", tmp_path / "baked.vxs"
    vxs("scene", "city", "--triangles", 1000, "-o", scene)
    vxs("bake", scene, "--resolution", 32768, "-o", path)
    words, starts, resident, pages = next(lights_of(vxs_path, path, [0]))
    known = Resident(resident, 15, 1, 2)
    found = Page(pages[-1], known.pages[-1], known.common, 2).words
    assert found == words[starts[-1]:]
