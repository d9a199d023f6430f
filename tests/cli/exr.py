# OpenEXR files that vxs writes, read without a library: scan lines of 32-bit floats, in chunks of 16 lines that zlib has packed.
# SPDX-License-Identifier: GPL-3.0-or-later
import array
import struct
import sys
import zlib


def attributes(data):
    """The header's attributes by name, as (type, bytes), and where it ends."""
    assert struct.unpack_from("<II", data) == (20000630, 2)
    at, found = 8, {}
    while data[at]:
        (name, kind), at = [part.decode() for part in data[at:].split(b"\0", 2)[:2]], at
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<I", data, at)
        found[name] = kind, data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def unpacked(packed, size):
    """zlib's bytes are differences of neighbours, and of each pair of bytes the first is in the first half."""
    if len(packed) == size:
        return packed
    raw, value = bytearray(zlib.decompress(packed)), 0
    assert len(raw) == size
    raw[1:] = (byte - 128 & 255 for byte in raw[1:])
    for n, byte in enumerate(raw):
        value = raw[n] = value + byte & 255
    out = bytearray(size)
    out[0::2], out[1::2] = raw[:(size + 1) // 2], raw[(size + 1) // 2:]
    return bytes(out)


def read_exr(data):
    """Width, height, {channel: rows of floats, top row first}, and the header's other attributes."""
    header, at = attributes(data)
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"][1])
    width, height = right - left + 1, bottom - top + 1
    assert (left, top) == (0, 0) and header["displayWindow"] == header["dataWindow"]
    assert header["lineOrder"][1] == b"\0" and header["compression"][1] == b"\3"  # from the top; zlib by 16 lines
    names, listed = [], header["channels"][1]
    while listed[0]:
        name, rest = listed.split(b"\0", 1)
        assert struct.unpack_from("<I4x2i", rest) == (2, 1, 1)  # floats, none left out
        names.append(name.decode())
        listed = rest[16:]
    assert names == sorted(names)
    channels = {name: [] for name in names}
    for offset in struct.unpack_from(f"<{(height + 15) // 16}Q", data, at):
        y, size = struct.unpack_from("<iI", data, offset)
        lines = min(16, height - y)
        numbers = array.array("f", unpacked(data[offset + 8:offset + 8 + size], 4 * width * lines * len(names)))
        if sys.byteorder == "big":
            numbers.byteswap()
        for line in range(lines):
            assert len(channels[names[0]]) == y + line
            for n, name in enumerate(names):
                begin = (line * len(names) + n) * width
                channels[name].append(numbers[begin:begin + width])
    return width, height, channels, header


def white(header):
    """cd/m2 of a value of 1."""
    return struct.unpack("<f", header["whiteLuminance"][1])[0]
