# Section 14 of formats/vxs.md is true: a decoder that is written from it alone, page_text.py, comes to the words of libvxs.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import struct
import subprocess

import pytest

from page_text import Page, Refused, Resident
from test_format import words_by_libvxs


def written_by(vxs_path, test, variable, path):
    """What a unit test writes to a file when it is asked to."""
    program = vxs_path.parent / "tests" / "unit" / test
    if not program.exists():
        pytest.skip("no unit tests")
    subprocess.run([program], env=os.environ | {variable: str(path)}, check=True)
    return path.read_bytes()


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
    """A resident part, its levels and maps, its words and nodes; nodes, words and bytes of a page that stands on its common pool."""
    parts = Parts(data)
    while parts.at < len(data):
        levels, maps, resident_bytes, word_count, node_count, page_nodes, page_words, page_bytes = parts.numbers(8)
        yield (parts.take(resident_bytes), levels, maps, parts.numbers(word_count), parts.nodes(node_count), parts.nodes(page_nodes),
               parts.numbers(page_words), parts.take(page_bytes))


def test_any_page_that_the_layout_allows(vxs_path, tmp_path):
    count = 0
    for data, levels, maps, words, nodes, page_nodes, page_words, page in samples(
            written_by(vxs_path, "test_page", "VXS_PAGES_OUT", tmp_path / "pages")):
        resident = Resident(data, levels, maps)
        assert resident.words == words
        assert [node for nodes_of_page in resident.pages for node in nodes_of_page] == nodes
        assert Page(page, page_nodes, resident.common).words == page_words
        for end in (page[:-2], page[:-8] + bytes(2) + page[-8:], page[:-1] + bytes([page[-1] ^ 0x80])):
            with pytest.raises(Refused):
                Page(end, page_nodes, resident.common)
        count += 1
    assert count == 30


def test_pages_that_are_built(vxs_path, tmp_path):
    """Those of lights of tests/unit/test_format_blocks.c that are not too large for Python; word 8 on has where pages start."""
    if vxs_path.parent.name in ("asan", "tsan"):
        pytest.skip("libvxs.so needs a sanitizer")
    data, pages_met = written_by(vxs_path, "test_format_blocks", "VXS_BLOCKS_OUT", tmp_path / "blocks.vxs"), 0
    entries = list(struct.iter_unpack("<4s3I4Q", data[64:64 + 48 * struct.unpack_from("<I", data, 12)[0]]))
    contents = {(kind, light): data[offset:offset + stored] for kind, _, light, _, offset, stored, _, _ in entries}
    for light, levels, maps in ((1, 9, 1), (3, 9, 1), (4, 15, 1), (5, 5, 6)):
        words = words_by_libvxs(vxs_path.parent / "libvxs.so", tmp_path / "blocks.vxs", light)
        resident, pages = Resident(contents[b"RSDT", light], levels, maps), Parts(contents[b"PAGE", light])
        count, size = pages.numbers(2)
        assert size == 16 and count == len(resident.pages) == words[0]
        starts, words[8:8 + count] = words[8:8 + count], [0] * count
        assert resident.words == words[:len(resident.words)]
        table = [pages.numbers(4)[:2] for _ in range(count)]
        for (stored, word_count), nodes, start in zip(table, resident.pages, starts, strict=True):
            assert Page(pages.take(stored), nodes, resident.common).words == words[start:start + word_count]
            pages_met += 1
    assert pages_met >= 4
