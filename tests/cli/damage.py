# .vxs files with something wrong in them that no check of the format can see: taken apart by formats/vxs.md, changed, and put
# together again with right sizes and checksums.
# SPDX-License-Identifier: GPL-3.0-or-later
import ctypes
import ctypes.util
import struct

import pytest

NONE = 0xffffffff
STORED = 2  # of a section's flags: its bytes are the content, and no frame
LIT, SHADOW, OWN = 0, 1, 2


def libraries():
    names = {name: ctypes.util.find_library(name) for name in ("zstd", "xxhash")}
    if not all(names.values()):
        pytest.skip(f"no shared library of {' or '.join(name for name in names if not names[name])}")
    zstd, xxhash = (ctypes.CDLL(names[name]) for name in ("zstd", "xxhash"))
    for function in (zstd.ZSTD_decompress, zstd.ZSTD_compress, zstd.ZSTD_compressBound):
        function.restype = ctypes.c_size_t
    xxhash.XXH64.restype = ctypes.c_uint64
    return zstd, xxhash


class Asset:
    """The sections of a file: contents[kind, light, level], bytearrays to be changed."""

    def __init__(self, path):
        self.zstd, self.xxhash = libraries()
        data = path.read_bytes()
        self.head, count = bytearray(data[:64]), struct.unpack_from("<I", data, 12)[0]
        self.entries = [list(entry) for entry in struct.iter_unpack("<4s3I4Q", data[64:64 + 48 * count])]
        self.contents = {}
        for kind, flags, light, level, offset, stored, inflated, _ in self.entries:
            content = data[offset:offset + stored]
            self.contents[kind.decode(), light, level] = bytearray(content) if flags & STORED else self.inflated(content, inflated)

    def inflated(self, frame, size):
        out = ctypes.create_string_buffer(size + 1)
        assert self.zstd.ZSTD_decompress(out, ctypes.c_size_t(size), frame, ctypes.c_size_t(len(frame))) == size
        return bytearray(out.raw[:size])

    def frame(self, content):
        size = ctypes.c_size_t(self.zstd.ZSTD_compressBound(ctypes.c_size_t(len(content))))
        out = ctypes.create_string_buffer(size.value)
        stored = self.zstd.ZSTD_compress(out, size, bytes(content), ctypes.c_size_t(len(content)), 3)
        return out.raw[:stored]

    def hash(self, data):
        return self.xxhash.XXH64(bytes(data), ctypes.c_size_t(len(data)), ctypes.c_uint64(0))

    def write(self, path):
        at, directory, body = 64 + 48 * len(self.entries), b"", b""
        for kind, flags, light, level, *_ in self.entries:
            content = self.contents[kind.decode(), light, level]
            frame = bytes(content) if flags & STORED else self.frame(content)
            directory += struct.pack("<4s3I4Q", kind, flags, light, level, at, len(frame), len(content), self.hash(frame))
            body += frame
            at += len(frame)
        struct.pack_into("<2Q", self.head, 16, at, self.hash(directory))
        struct.pack_into("<Q", self.head, 56, self.hash(self.head[:56]))
        path.write_bytes(self.head + directory + body)
        return path

    # what is in them

    def shift(self, texels=(0, 0), voxels=0, light=0):
        """A directional light's matrix: every point is looked up so far aside, and so far away from the light."""
        table = self.contents["LGHT", NONE, 0]
        for row, step in enumerate((*texels, voxels)):
            at = 8 + 256 * light + 16 + 8 * (4 * row + 3)
            struct.pack_into("<d", table, at, struct.unpack_from("<d", table, at)[0] + step)

    def levels(self, light=0):
        return 1 + max(level for kind, of, level in self.contents if kind == "LEVL" and of == light)

    def states(self, level, light=0):
        """Of each node, the states of its children."""
        content = self.contents["LEVL", light, level]
        count, = struct.unpack_from("<I", content)
        return [[word >> 2 * c & 3 for c in range(8)] for word in struct.unpack_from(f"<{count}H", content, 4)]

    def turn_state(self, level, node, child, light=0):
        """A child that is lit becomes shadow, and the other way round."""
        assert self.states(level, light)[node][child] in (LIT, SHADOW)
        self.contents["LEVL", light, level][4 + 2 * node + child // 4] ^= 1 << 2 * (child % 4)

    def references(self, level, light=0):
        """Number d of section 7 of each own child: 0 where it names a new one, else how far back it was named."""
        content = self.contents["LEVL", light, level]
        found, value, shift = [], 0, 0
        for byte in content[4 + 2 * len(self.states(level, light)):]:
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                found.append(value)
                value = shift = 0
        return found

    def refer(self, level, n, back, light=0):
        """Reference n names what was named so far back."""
        references = self.references(level, light)
        assert references[n] > 0 and 0 < back <= references[:n].count(0)
        references[n] = back
        head = 4 + 2 * len(self.states(level, light))
        content = self.contents["LEVL", light, level][:head]
        for value in references:
            while value > 127:
                content.append(value & 127 | 128)
                value >>= 7
            content.append(value)
        self.contents["LEVL", light, level] = content

    def masks(self, light=0):
        return len(self.contents["MASK", light, 0]) // 8

    def turn_bit(self, mask, bit, light=0):
        self.contents["MASK", light, 0][8 * mask + bit // 8] ^= 1 << bit % 8
