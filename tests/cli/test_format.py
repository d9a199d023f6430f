# The format's spec, formats/vxs.md, is true: its tables hold the numbers of the headers, its dump is a file that is read, and
# a reader written from it alone gives the answers of the command. And headers stand alone, in each language they are for.
# SPDX-License-Identifier: GPL-3.0-or-later
import ctypes
import ctypes.util
import hashlib
import itertools
import math
import os
import random
import re
import shutil
import struct
import subprocess

import pytest

from conftest import ROOT
from test_install import INSTALLED

SPEC = (ROOT / "formats" / "vxs.md").read_text()
GOLDEN = ROOT / "tests" / "golden"


def section(number):
    """The text of a section of the spec."""
    return re.search(rf"^## {number}\. .*?(?=^## |\Z)", SPEC, re.S | re.M)[0]


def tables(text):
    """Each table as a list of rows, each row a dict by the table's head."""
    found = []
    for block in re.findall(r"(?:^\|.*\n)+", text, re.M):
        rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in block.splitlines()]
        found.append([dict(zip(rows[0], row)) for row in rows[2:]])
    return found


def macros():
    """Every number that vxs_format.h defines."""
    text = (ROOT / "formats" / "vxs_format.h").read_text()
    return {name: int(value, 0) for name, value in re.findall(r"^#define (VXS_\w+) +(0x[0-9a-f]+|\d+)u?\b", text, re.M)}


def code_blocks(text):
    return re.findall(r"^```\n(.*?)^```", text, re.S | re.M)


def dump_bytes(text):
    """The bytes of a dump: offset, two blanks, bytes, notes; each line's offset is where the one before it ends."""
    data = b""
    for offset, line in re.findall(r"^([0-9a-f]{8})  ((?:[0-9a-f]{2} ?)+)(?=  |$)", text, re.M):
        assert int(offset, 16) == len(data), f"the dump at {offset}"
        data += bytes.fromhex(line)
    return data


# tables ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number, prefix, size", [(3, "HEADER", "HEADER_BYTES"), (4, "ENTRY", "ENTRY_BYTES"),
                                                  (5, "LIGHT", "LIGHT_BYTES"), (14, "PAGE", "PAGE_BYTES"),
                                                  (15, "SMOKE", "SMOKE_PREFIX_BYTES"), (16, "POINTS", "POINTS_PREFIX_BYTES")])
def test_fields(number, prefix, size):
    fields, end = tables(section(number))[0], 0
    defined = macros()
    for field in fields:
        assert int(field["offset"]) == end, f"{field['name']} leaves a gap"
        end += int(field["size"])
        count, _, kind = field["type"].rpartition(" ")
        if kind != "bytes":
            assert int(field["size"]) == int(count or 1) * int(kind[1:]) // 8, field["name"]
        for finding in field["otherwise"].split(", "):
            assert f"X({finding}," in (ROOT / "formats" / "vxs_findings.h").read_text()
    assert end == defined[f"VXS_{size}"]

    spec = {f"VXS_{prefix}_{field['name'].upper()}": int(field["offset"]) for field in fields}
    for name in spec.keys() - {"VXS_HEADER_MAGIC"}:
        assert defined[name] == spec[name], name
    # and nothing is defined that the spec does not have, but sizes and values
    others = {"VXS_HEADER_BYTES", "VXS_ENTRY_BYTES", "VXS_LIGHT_BYTES", "VXS_PAGE_BYTES", "VXS_LIGHT_NAME_BYTES",
              "VXS_LIGHT_KIND_DIRECTIONAL", "VXS_LIGHT_KIND_SPOT", "VXS_LIGHT_KIND_POINT", "VXS_LIGHT_BOUNDED", "VXS_LIGHT_CUBE",
              "VXS_SMOKE_PREFIX_BYTES", "VXS_SMOKE_LEVELS_MAX", "VXS_SMOKE_NODES_MAX", "VXS_POINTS_PREFIX_BYTES", "VXS_POINTS_MAX"}
    assert {name for name in defined if name.startswith(f"VXS_{prefix}_")} - others == spec.keys() - {"VXS_HEADER_MAGIC"}


def test_sizes_in_prose():
    defined = macros()

    def prose(number):
        return " ".join(section(number).split())

    assert f"first {defined['VXS_HEADER_BYTES']} bytes" in prose(3)
    assert f"entries of {defined['VXS_ENTRY_BYTES']} bytes" in prose(4)
    assert f"size of a record, {defined['VXS_LIGHT_BYTES']};" in prose(5)
    assert defined["VXS_LIGHTS_PREFIX_BYTES"] == 8 and defined["VXS_MAGIC_BYTES"] == 8
    assert defined["VXS_LIGHT_NAME_BYTES"] == int(next(f for f in tables(section(5))[0] if f["name"] == "name")["size"])
    assert defined["VXS_NO_LIGHT"] == 0xffffffff and "`ffffffff`: none" in prose(4)
    assert f"size of an entry, {defined['VXS_PAGE_BYTES']};" in prose(14) and defined["VXS_PAGES_PREFIX_BYTES"] == 8
    assert defined["VXS_BLOCKS_SPARE_WORDS"] == 4 and "a reader keeps four more" in prose(13)
    assert defined["VXS_SECTION_OPTIONAL"] == 1 and defined["VXS_SECTION_STORED"] == 2 and defined["VXS_LIGHT_BOUNDED"] == 1
    assert defined["VXS_LIGHT_CUBE"] == 2 and defined["VXS_CUBE_FACES"] == 6
    kinds = [defined["VXS_LIGHT_KIND_" + kind] for kind in ("DIRECTIONAL", "SPOT", "POINT")]
    assert kinds == [1, 2, 3] and "| 1: directional; 2: spot; 3: point |" in prose(5)
    assert [defined["VXS_CODING_" + coding] for coding in ("DAG", "BLOCKS")] == [1, 2] and "1: a DAG; 2: palette blocks." in prose(5)
    assert [defined["VXS_PACKING_" + packing] for packing in ("SMALL", "FAST", "FINE")] == [0, 1, 2]
    assert "0: small, 14.1 to 14.9; 1: fast, 14.10; 2: fine, 14.11." in prose(5)
    assert defined["VXS_FORMAT_VERSION_BLOCKS"] == 2


def test_kinds():
    names = {"LGHT": "LIGHTS", "LEVL": "LEVEL", "MASK": "MASKS", "RSDT": "RESIDENT", "PAGE": "PAGES", "SMKE": "SMOKE", "PNTS": "POINTS", "META": "METADATA"}
    kinds = tables(section(4))[1]
    assert [kind["kind"].strip("`") for kind in kinds] == list(names)
    for kind in kinds:
        letters = kind["kind"].strip("`")
        assert int(kind["value"], 16) == int.from_bytes(letters.encode(), "little") == macros()[f"VXS_KIND_{names[letters]}"]


def test_states():
    states = tables(section(6))[1]
    assert [int(state["state"]) for state in states] == [0, 1, 2, 3]
    for state in states:
        assert macros()[f"VXS_CHILD_{state['name'].upper()}"] == int(state["state"])


def test_limits():
    limits = {row["name"]: int(row["value"]) for row in tables(section(9))[0]}
    assert limits == {name: macros()[name] for name in limits}
    assert {name for name in macros() if re.search("_(MIN|MAX)$", name)} <= limits.keys()


def test_findings():
    text = (ROOT / "formats" / "vxs_findings.h").read_text()
    listed = re.findall(r'X\((\d+), (VXS_E_\w+), +"(.*?)"\)', text)
    assert listed == [(row["number"], row["result"], row["text"]) for row in tables(section(8))[0]]
    numbers = [int(number) for number, _, _ in listed]
    assert numbers == sorted(set(numbers)), "numbers only grow"
    results = (ROOT / "formats" / "vxs_result.h").read_text()
    for _, result, _ in listed:
        assert f"X({result}," in results
    # every finding that the text names is in the list
    assert {int(n) for n in re.findall(r"\((\d{3})(?=[,)])|, (\d{3})\)", SPEC) for n in n if n} <= set(numbers)


def test_citations():
    """Where a source names a section of the spec, there is one, and it is on what the source says."""
    titles = {int(n): title.lower() for n, title in re.findall(r"^## (\d+)\. (.*)$", SPEC, re.M)}
    assert list(titles) == list(range(1, 17))
    cited = 0
    for path in itertools.chain.from_iterable(ROOT.glob(f"{folder}/*.[ch]") for folder in ("formats", "runtime", "baker")):
        for first, last, topic in re.findall(r"vxs\.md sections? (\d+)(?: to (\d+))?(?:: (\w+))?", path.read_text()):
            cited += 1
            assert int(first) in titles and int(last or first) in titles, path
            if topic in ("header", "directory", "lights", "limits"):
                assert topic in titles[int(first)], f"{path}: section {first} is not on {topic}"
    assert cited >= 8


# a reader, from the spec ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def libraries():
    """inflate(frame, size) and xxh64(bytes) from the libraries of the system."""
    names = {name: ctypes.util.find_library(name) for name in ("zstd", "xxhash")}
    if not all(names.values()):
        pytest.skip(f"no shared library of {' or '.join(name for name in names if not names[name])}")
    zstd, xxhash = (ctypes.CDLL(names[name]) for name in ("zstd", "xxhash"))
    zstd.ZSTD_decompress.restype = ctypes.c_size_t
    xxhash.XXH64.restype = ctypes.c_uint64

    def inflate(frame, size):
        out = ctypes.create_string_buffer(size + 1)
        assert zstd.ZSTD_decompress(out, ctypes.c_size_t(size), frame, ctypes.c_size_t(len(frame))) == size
        return out.raw[:size]

    return inflate, lambda data: xxhash.XXH64(data, ctypes.c_size_t(len(data)), ctypes.c_uint64(0))


class Light:
    """A light's record, and its words as section 6 lays them out."""

    def __init__(self, record, levels, masks):
        self.kind, self.levels, self.word_count, self.flags = struct.unpack_from("<4I", record)
        self.matrix = struct.unpack_from("<12d", record, 16)
        self.texel, self.voxel = struct.unpack_from("<2d", record, 112)
        self.near, self.cos_outer, self.range = struct.unpack_from("<3d", record, 152)
        self.name = record[192:].rstrip(b"\0").decode()
        self.decode(levels, masks)

    def decode(self, levels, masks):
        maps = 6 if self.flags & 2 else 1
        parsed, starts, at = {}, {}, maps if maps > 1 else 0
        for level in reversed(range(self.levels - 2)):
            count, = struct.unpack_from("<I", levels[level])
            states = struct.unpack_from(f"<{count}H", levels[level], 4)
            parsed[level] = states, self.references(levels[level][4 + 2 * count:])
            starts[level] = []
            for s in states:
                starts[level].append(at)
                at += 1 + sum(s >> 2 * c & 3 == 2 for c in range(8))
        assert len(starts[self.levels - 3]) == maps
        at += at % 2
        starts[-1] = [at + 2 * n for n in range(len(masks) // 8)]
        assert at + len(masks) // 4 == self.word_count

        self.words = [0] * at + list(struct.unpack(f"<{len(masks) // 4}I", masks))
        if maps > 1:
            self.words[:6] = starts[self.levels - 3]
        for level, (states, references) in parsed.items():
            below, following = starts[level - 1], 0
            for s, start in zip(states, starts[level]):
                self.words[start] = s
                for n in range(sum(s >> 2 * c & 3 == 2 for c in range(8))):
                    code = next(references)
                    self.words[start + 1 + n] = below[following - code]
                    following += code == 0
            assert following == len(below) and next(references, None) is None

    @staticmethod
    def references(data):
        value = shift = 0
        for byte in data:
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                yield value
                value = shift = 0

    def shadow(self, i, j, k, face=None):
        """Section 6, to the letter."""
        node = 0 if face is None else self.words[face]
        for level in range(self.levels - 3, -1, -1):
            states = self.words[node]
            bit = level + 2
            c = (i >> bit & 1) + 2 * (j >> bit & 1) + 4 * (k >> bit & 1) if level else k & 7
            state = states >> 2 * c & 3
            while state == 3:
                c -= 4 if level else 1
                state = states >> 2 * c & 3
            if state < 2:
                return state
            node = self.words[node + 1 + sum(states >> 2 * before & 3 == 2 for before in range(c))]
        bit = i % 8 + 8 * (j % 8)
        return self.words[node + bit // 32] >> bit % 32 & 1

    # the table of section 2, as it stands there
    FACES = {key: row.strip("()").split(", ") for key, row in list(tables(section(2).replace("\n  |", "\n|"))[1][0].items())[1:]}

    def place(self, point):
        """Section 2: None, or the face (None where there is one map) and u, v and depth."""
        m = self.matrix
        ls = [sum(a * b for a, b in zip(m[4 * r:4 * r + 3], point)) + m[4 * r + 3] for r in range(3)]
        side = 1 << self.levels
        if self.kind == 1:
            u, v, depth = ls
            inside = 0 <= u < side and 0 <= v < side and (not self.flags & 1 or 0 <= depth < side)
            return (None, u, v, depth) if inside else None
        distance = math.hypot(*ls)
        if self.kind == 2 and ls[2] < self.cos_outer * distance or 0 < self.range < distance:
            return None
        face = None
        if self.flags & 2:
            along = max(range(3), key=lambda axis: abs(ls[axis]))
            face = 2 * along + (ls[along] < 0)
            names = dict(zip("xyz", ls))
            names |= {"-" + name: -value for name, value in names.items()}
            ls = [names[name] for name in next(row for head, row in self.FACES.items() if head.startswith(f"{face}: "))]
        p, q, r = ls
        if r <= 0:
            return None if p or q else (face, side / 2, side / 2, -1)
        clamp = lambda texel: min(max(texel, 0), side - 1)
        return (face, clamp(side / 2 + p / r / self.texel), clamp(side / 2 + q / r / self.texel), math.log(r / self.near) / self.voxel)

    def answer(self, point, filter_px):
        """Section 2: the lit fraction, or None for outside."""
        side, place = 1 << self.levels, self.place(point)
        if place is None:
            return None
        face, i, j, k = place[0], *(math.floor(x) for x in place[1:])
        if k < 0:
            return 1
        taps = [(x, y) for x in range(i - filter_px // 2, i + filter_px // 2 + 1) for y in range(j - filter_px // 2, j + filter_px // 2 + 1)]
        dark = sum(self.shadow(x, y, min(k, side - 1), face) for x, y in taps if 0 <= x < side and 0 <= y < side)
        return (len(taps) - dark) / len(taps)


def ones(x):
    return bin(x).count("1")


def signed(x, bits):
    return x - (x >> bits - 1 << bits)


class BlocksLight(Light):
    """A light of palette blocks, looked up by section 13 to the letter. Its words are what libvxs makes of its sections."""

    def __init__(self, record, words):
        super().__init__(record, words, None)

    def decode(self, words, _):
        assert len(words) == self.word_count
        self.words = words

    def half(self, word, n):
        return self.words[word + n // 2] >> 16 * (n % 2) & 0xffff

    def byte(self, word, n):
        return self.words[word + n // 4] >> 8 * (n % 4) & 0xff

    def number(self, word, at, size):
        return sum(self.byte(word, at + n) << 8 * n for n in range(size))

    def entry(self, face, x, y):
        top, across = self.words[2 + face], max(1, 2 ** self.levels // 256)
        if self.levels < 15:
            return top + 2 * (y * across + x)
        cell = top + y // 8 * (across // 8) + x // 8
        return cell if self.words[cell] >> 31 else self.words[cell] + 2 * (y % 8 * 8 + x % 8)

    def shadow(self, i, j, k, face=None):
        at = self.entry(face or 0, i // 256, j // 256)
        place = self.words[at]
        if place >> 31:
            return int(k >= place & 0x7fffffff)
        bounds, c, s = self.words[at + 1], max(0, self.levels - 8), max(0, self.levels - 16)
        if k >> c < bounds >> 16 & 255 or k >> c > bounds >> 24:
            return int(k >> c > bounds >> 24)
        page = self.words[8 + (place >> 16)]
        return self.node_shadow(page, page + (place & 0xffff), i % 256, j % 256, k - ((bounds & 0xffff) << s))

    def node_shadow(self, page, node, i, j, k):
        mixed, fresh = (sum(self.half(node, first + n) << 16 * n for n in range(4)) for first in (0, 4))
        nx, ny = (signed(self.half(node, n), 16) for n in (8, 9))
        size, m = 4 if self.half(node, 10) & 1 else 2, ones(mixed)
        slope = lambda n, tile: n * (tile - 31) if n < 0 else n * tile
        flat, k = k, k + (slope(nx, i // 8) + slope(ny, j // 8) >> 8)
        number = lambda n: self.number(node, 2 * (11 + m) + size * n, size)
        c = i // 32 + 8 * (j // 32)
        if not mixed >> c & 1:
            depth = number(m + ones(fresh & (2 << c) - 1) - 1)
            return int(depth != 256 ** size - 1 and k >= depth)
        n = ones(mixed & (1 << c) - 1)
        return self.block_shadow(page, page + self.half(node, 11 + n), i % 32, j % 32, k - number(n), flat - number(n))

    def block_shadow(self, page, block, i, j, k, flat):
        word0, word1 = self.words[block:block + 2]
        mixed, fresh, own, q, shift = word0 & 0xffff, word0 >> 16, word1 & 0xffff, (word1 >> 16 & 15) + 1, word1 >> 20 & 15
        size, far = 1 << (word1 >> 24 & 3), word1 >> 26 & 1
        tiles = 4 if own & ~mixed else 2
        deltas = 4 * (tiles + ones(mixed))
        nibbles = deltas + size * (q - 1)
        palette = [0] + [self.number(block, deltas + size * n, size) << shift for n in range(q - 1)]
        rank, t = sum(depth <= k for depth in palette), i // 8 + 4 * (j // 8)
        if not mixed >> t & 1 and own >> t & 1:
            last = self.words[block + 3]
            return int(flat >= self.plane(2 * (block + 2), last & 15, 32, i, j) + signed(last >> 4, 28) >> 8)
        if not mixed >> t & 1:
            n = ones(fresh & (2 << t) - 1) - 1
            return int(rank > (self.byte(block, nibbles + n // 2) >> 4 * (n % 2) & 15))
        tile = self.words[block + tiles + ones(mixed & (1 << t) - 1)]
        pool, at, low = self.words[1] if tile >> 31 else page, tile >> 14 & 0x1ffff, tile & 0x3fff
        z = 16 * (i % 8 // 4 + 2 * (j % 8 // 4)) + 4 * (j % 4) + i % 4
        if not own >> t & 1:
            return self.mask(pool, at, ones(low), ones(low & (1 << rank) - 1), z)
        base = low - 8192
        if far:
            base = signed(self.words[block + (nibbles + (ones(fresh) + 1) // 2 + 3) // 4 + ones(own & mixed & (1 << t) - 1)], 32)
        return self.own_shadow(pool, at, z, i % 8, j % 8, k - base)

    def plane(self, half, shift, side, x, y):
        """Depth of texel (x, y) over the least one, in 1/256 voxel."""
        a, b = (signed(self.half(0, half + n), 16) for n in (0, 1))
        return (a * (x - side + 1 if a < 0 else x) + b * (y - side + 1 if b < 0 else y)) << shift

    def own_shadow(self, pool, at, z, x, y, k):
        head = self.half(pool, at)
        kind, shift, p, then = head >> 12, head >> 8 & 15, head & 0xff, 2 * (at + 1)
        if k < 0:
            return 0
        if kind < 3:
            size = 1 << kind
            deltas = [0] + [self.number(pool, then + size * n, size) << shift for n in range(p - 1)]
            return self.mask(pool, at + 1 + (size * (p - 1) + 1) // 2, p, sum(delta <= k for delta in deltas), z)
        if kind == 3:
            return int((self.byte(pool, then + z // 16) + self.nibble(pool, then + 4, z)) << shift <= k)
        if kind < 7:
            return int(self.number(pool, then + (kind - 3) * z, kind - 3) << shift <= k)
        planes = 2 * pool + at + 1
        depths = [(64 * (head >> 3 & 3) + self.plane(planes, shift, 8, x, y)) >> 8]
        if kind > 7:
            deeper = self.half(pool, at + 5) << (head & 7)
            depths.append(deeper + ((64 * (head >> 5 & 3) + self.plane(planes + 2, shift, 8, x, y)) >> 8))
        depth = {7: min, 8: min, 9: max}.get(kind, lambda both: both[self.half(pool, at + 6 + z // 16) >> z % 16 & 1])
        return int(depth(depths) <= k)

    def nibble(self, pool, at, z):
        return self.byte(pool, at + z % 32) >> 4 * (z // 32) & 15

    def mask(self, pool, at, p, run, z):
        """Whether texel z of a pattern of p depths is shadow once `run` of them are reached."""
        if run in (0, p):
            return int(run == p)
        if self.byte(pool, 2 * at) == 0xff:
            return int(self.nibble(pool, 2 * at + 2, z) <= run - 1)
        following, last = at + p // 2, None
        for c, n in itertools.product(range(4), range(p - 1)):
            state = self.byte(pool, 2 * at + n) >> 2 * c & 3
            if state == 2:
                last, following = self.half(pool, following), following + 1
            if (c, n) == (z // 16, run - 1):
                return state if state < 2 else last >> z % 16 & 1


def read(path, libraries):
    inflate, xxh64 = libraries
    data = path.read_bytes()
    magic, version, count, size, directory_hash = struct.unpack_from("<8s2I2Q", data)
    assert magic == bytes.fromhex("8f5658530d0a1a0a") and version == 1 and size == len(data)
    assert data[32:56] == bytes(24) and struct.unpack_from("<Q", data, 56)[0] == xxh64(data[:56])
    assert directory_hash == xxh64(data[64:64 + 48 * count])
    sections, end = {}, 64 + 48 * count
    for kind, _, light, level, offset, stored, inflated, check in struct.iter_unpack("<4s3I4Q", data[64:64 + 48 * count]):
        assert offset == end and xxh64(data[offset:offset + stored]) == check
        end += stored
        sections[kind.decode(), light, level] = inflate(data[offset:offset + stored], inflated)
    assert end == size

    table, lights = sections["LGHT", 0xffffffff, 0], []
    assert struct.unpack_from("<2I", table) == (len(table) // 256, 256)
    for n in range(len(table) // 256):
        levels = {level: content for (kind, light, level), content in sections.items() if kind == "LEVL" and light == n}
        lights.append(Light(table[8 + 256 * n:8 + 256 * (n + 1)], levels, sections["MASK", n, 0]))
    return lights, sections


def test_dump_is_the_golden_file(libraries):
    file, contents, words = code_blocks(section(10))
    assert dump_bytes(file) == (GOLDEN / "smallest.vxs").read_bytes()
    (light,), sections = read(GOLDEN / "smallest.vxs", libraries)
    parts = re.split(r"^([A-Z]{4})$", contents, flags=re.M)[1:]
    assert {kind: dump_bytes(text) for kind, text in zip(parts[::2], parts[1::2])} == {key[0]: c for key, c in sections.items()}
    assert light.words == [int(word, 16) for word in re.findall(r"^word \d+  ([0-9a-f]{8})", words, re.M)]


@pytest.mark.parametrize("name", ["smallest.vxs", "sample.vxs", "lamps.vxs"])
@pytest.mark.parametrize("filter_px", [1, 5])
def test_reader_from_the_spec_answers_like_the_command(vxs, libraries, name, filter_px):
    lights, _ = read(GOLDEN / name, libraries)
    dice = random.Random(1)
    points = [(dice.randrange(-32, 160) / 8, dice.randrange(-240, 120) / 8, dice.randrange(-32, 200) / 8)
              for _ in range(20000 if filter_px == 1 else 2000)]
    done = vxs("query", GOLDEN / name, "--filter", filter_px, input="".join("%r %r %r\n" % point for point in points))
    kinds = set()
    for point, line in zip(points, done.stdout.splitlines(), strict=True):
        for light, answer in zip(lights, line.split(), strict=True):
            wanted = light.answer(point, filter_px)
            assert (answer == "out") == (wanted is None) and (wanted is None or abs(float(answer) - wanted) < 1e-6), (point, line)
            kinds.add(wanted)
    assert {None, 0, 1} <= kinds and (len(kinds) > 6) == (filter_px > 1)


def words_by_libvxs(library, path, light):
    """The words of a light: vxs_baked_light has a record of 240 bytes, the address of its words, and their number."""
    library, asset = ctypes.CDLL(str(library)), ctypes.c_void_p()
    library.vxs_asset_light.restype = ctypes.c_void_p
    assert library.vxs_asset_open_file(ctypes.byref(asset), str(path).encode(), None) == 0
    baked = library.vxs_asset_light(asset, light)
    address, count = struct.unpack("<QI", ctypes.string_at(baked + 240, 12))
    words = list(struct.unpack(f"<{count}I", ctypes.string_at(address, 4 * count)))
    library.vxs_asset_close(asset)
    return words


def edges_of(light, dice, count):
    """Points in the voxels where the shadow of random texels begins, and before it; of a sun of tests/unit/dag_sample.h."""
    for _ in range(count):
        i, j, low, high = dice.randrange(1 << light.levels), dice.randrange(1 << light.levels), 0, (1 << light.levels) - 1
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if light.shadow(i, j, middle) else (middle + 1, high)
        for k in (low - 1, low):
            yield (i + 0.5 - 2) / 2, 10 - (k + 0.5), (j + 0.5 + 4) / 2


@pytest.mark.parametrize("filter_px", [1, 5])
def test_lookup_of_blocks_from_the_spec_answers_like_the_command(vxs, vxs_path, libraries, tmp_path, filter_px):
    path, program = tmp_path / "blocks.vxs", vxs_path.parent / "tests" / "unit" / "test_format_blocks"
    if not program.exists() or vxs_path.parent.name in ("asan", "tsan"):
        pytest.skip("no unit tests, or libvxs.so needs a sanitizer")
    subprocess.run([program], env=os.environ | {"VXS_BLOCKS_OUT": str(path)}, check=True)
    data, (inflate, _) = path.read_bytes(), libraries
    version, count = struct.unpack_from("<2I", data, 8)
    entries = list(struct.iter_unpack("<4s3I4Q", data[64:64 + 48 * count]))
    assert version == 2 and [entry[0] for entry in entries] == [b"RSDT", b"PAGE"] * 6 + [b"LGHT"]
    offset, stored, inflated = entries[-1][4:7]
    table, library = inflate(data[offset:offset + stored], inflated), vxs_path.parent / "libvxs.so"
    lights = [BlocksLight(table[8 + 256 * n:8 + 256 * (n + 1)], words_by_libvxs(library, path, n)) for n in range(6)]

    dice, kinds = random.Random(1), set()
    points = [point for light in lights[:5] for point in edges_of(light, dice, 1000 if filter_px == 1 else 50)]
    points += [tuple(dice.uniform(-10, 10) for _ in range(3)) for _ in range(1000 if filter_px == 1 else 100)]
    done = vxs("query", path, "--filter", filter_px, input="".join("%r %r %r\n" % point for point in points))
    for point, line in zip(points, done.stdout.splitlines(), strict=True):
        for light, answer in zip(lights, line.split(), strict=True):
            wanted = light.answer(point, filter_px)
            assert (answer == "out") == (wanted is None), (light.name, point)
            assert wanted is None or abs(float(answer) - wanted) < 1e-6, (light.name, point, line)
            kinds.add((light.name, wanted))
    assert {(light.name, wanted) for light in lights for wanted in (0, 1)} <= kinds or filter_px > 1
    assert len(kinds) > 40 or filter_px == 1


# the command ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["smallest.vxs", "sample.vxs", "lamps.vxs", "blocks.vxs", "fine.vxs"])
def test_golden_files_are_valid(vxs, name):
    done = vxs("validate", GOLDEN / name)
    assert done.stdout.endswith("valid\n") and "finding" not in done.stdout


def test_golden_blocks_keep_their_words(vxs_path):
    """Of lights that are packed small, small, fast, and fast, the last one with six maps; and of one that is packed fine."""
    if vxs_path.parent.name in ("asan", "tsan"):
        pytest.skip("libvxs.so needs a sanitizer")
    lights = [("blocks.vxs", light) for light in range(4)] + [("fine.vxs", 0)]
    words = [words_by_libvxs(vxs_path.parent / "libvxs.so", GOLDEN / name, light) for name, light in lights]
    assert [hashlib.sha256(struct.pack(f"<{len(w)}I", *w)).hexdigest()[:16] for w in words] == [
        "aec3807f9b464991", "5b2cd333747a0136", "34993e252b832eaf", "2c5624be8bb3c8b9", "8d400492cd80870a"]


@pytest.mark.parametrize("change, number", [
    (lambda data: data[:40], 101),
    (lambda data: b"glTF" + data[4:], 102),
    (lambda data: data[:8] + b"\3" + data[9:], 103),
    (lambda data: data[:-1], 106),
    (lambda data: data + b"\0", 107),
    (lambda data: data[:-1] + b"\0", 206),
])
def test_damaged_files_are_refused(vxs, tmp_path, change, number):
    path = tmp_path / "damaged.vxs"
    path.write_bytes(change((GOLDEN / "sample.vxs").read_bytes()))
    text = next(row["text"] for row in tables(section(8))[0] if row["number"] == str(number))
    assert f"finding {number}: {text}" in vxs("validate", path, status=1).stdout


# headers --------------------------------------------------------------------------------------------------------------------

# one text for two ways: what includes it says which (PAGE_ENCODING)
TWO_WAYS = {path.name for path in (ROOT / "formats").glob("vxs_page_*.h")} | {"vxs_resident_model.h"}
# of the sources alone, which are C11
OWN = {"vxs_tasks.h", "vxs_pattern_check.h"}
# of other systems: test_windows.py compiles it
OTHERS = {"platform_windows.h"}
HEADERS = sorted(path.relative_to(ROOT) for folder in ("formats", "runtime") for path in (ROOT / folder).rglob("*.h")
                 if path.name not in TWO_WAYS | OWN | OTHERS)
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-pedantic-errors", "-fsyntax-only"]
# what a game's build may query of those that are installed
ASKED = {"c": ["-Wconversion", "-Wsign-conversion", "-Wdouble-promotion", "-Wshadow", "-Wundef", "-Wstrict-prototypes"],
         "c++": ["-Wconversion", "-Wsign-conversion", "-Wdouble-promotion", "-Wshadow", "-Wundef", "-Wold-style-cast"]}


@pytest.mark.parametrize("compilers", [{"c": os.environ.get("CC", "cc"), "c++": os.environ.get("CXX", "c++")},
                                       {"c": "clang", "c++": "clang++"}], ids=["default", "clang"])
@pytest.mark.parametrize("language, standard", [("c", "c99"), pytest.param("c", "c11", marks=pytest.mark.long), ("c++", "c++11"),
                                                pytest.param("c++", "c++17", marks=pytest.mark.long)])
def test_headers_stand_alone(compilers, language, standard, tmp_path):
    """First and alone, and once more: each header brings what it needs, and can be there twice. The installed ones also together, in both
    orders: no name of one is hidden by another."""
    assert len(HEADERS) >= 7
    compiler = compilers[language]
    if not shutil.which(compiler.split()[0]):
        pytest.skip(f"no compiler {compiler}")
    installed = [header for header in HEADERS if f"include/vxs/{header.name}" in INSTALLED]
    assert len(installed) > 20
    for headers in [*([header, header] for header in HEADERS), installed, installed[::-1]]:
        source = tmp_path / "alone"
        source.write_text("".join(f'#include "{header}"\n' for header in headers) + "int nothing;\n")
        asked = ASKED[language] if headers[0] in installed else []
        folders = [".", "formats", "runtime", "runtime/gl", "runtime/volumes", *(p for p in (ROOT / "runtime/volumes").iterdir() if p.is_dir())]
        done = subprocess.run([*compiler.split(), "-x", language, f"-std={standard}", *WARNINGS, *asked, *(f"-I{folder}" for folder in folders),
                               str(source)], cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, f"{headers} as {standard}: {done.stderr}"
