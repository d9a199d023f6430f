# Pictures that vxs writes, read without a library.
# SPDX-License-Identifier: GPL-3.0-or-later
import struct
import zlib


def read_rows(data, depth, colour, pixel_bytes):
    """Width, height and rows of bytes, after the container's own checks and the five filters."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, chunks = 8, {}
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + length)[0]
        chunks[kind] = chunks.get(kind, b"") + body
        at += 12 + length
    width, height, *form = struct.unpack_from(">IIBB", chunks[b"IHDR"])
    assert form == [depth, colour] and b"IEND" in chunks
    raw, stride = zlib.decompress(chunks[b"IDAT"]), pixel_bytes * width
    rows, above = [], bytes(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            before = x >= pixel_bytes
            a, b, c = row[x - pixel_bytes] if before else 0, above[x], above[x - pixel_bytes] if before else 0
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            row[x] = (row[x] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        rows.append(bytes(row))
        above = row
    return width, height, rows


def read_png(data):
    """Width, height and rows of RGB bytes."""
    return read_rows(data, 8, 2, 3)


def read_grey16(data):
    """Width, height and rows of 16-bit numbers."""
    width, height, rows = read_rows(data, 16, 0, 2)
    return width, height, [struct.unpack(f">{width}H", row) for row in rows]
