# Reading pages, drawings and pictures that vxs writes, strictly.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import html.parser
import re
import struct
import xml.etree.ElementTree
import zlib

EMPTY = {"meta", "img", "br", "link", "hr"}
SVG = "{http://www.w3.org/2000/svg}"


class Page(html.parser.HTMLParser):
    """A page that is balanced, stands alone and runs nothing. text: all of it, blanks made one; pictures: as PNG."""

    def __init__(self, source):
        super().__init__(convert_charrefs=True)
        self.source, self.open, self.parts, self.ids, self.tags, self.sources = source, [], [], [], [], []
        self.feed(source)
        self.close()
        assert self.open == [], f"not closed: {self.open}"
        assert source.startswith("<!DOCTYPE html>\n") and source.endswith("</html>\n")
        assert len(self.ids) == len(set(self.ids)), "an id twice"
        assert not {"script", "iframe", "object", "embed", "link", "form", "base"} & set(self.tags)
        self.text = re.sub(r"\s+", " ", "".join(self.parts)).replace("\u202f", " ")
        self.drawings = [xml.etree.ElementTree.fromstring(s) for s in re.findall(r"<svg.*?</svg>", source, re.DOTALL)]
        self.pictures = [base64.b64decode(s.removeprefix("data:image/png;base64,"), validate=True) for s in self.sources]
        self.sizes = [inflate_png(p)[:2] for p in self.pictures]

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        for name, value in attributes:
            assert not name.startswith("on"), f"{tag} {name}"
            assert not re.match(r"(?i)javascript:|https?:|//", value or "") or name.startswith("xmlns"), f"{tag} {name}={value}"
            if name == "id":
                self.ids.append(value)
            if (tag, name) == ("img", "src"):
                self.sources.append(value)
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in EMPTY:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> in {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data):
        self.parts.append(" " + data if self.open and self.open[-1] != "style" else "")


def inflate_png(data):
    """width, height, bytes a pixel, and the filtered rows; every checksum is looked at."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, chunks = 8, []
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0]
        chunks.append((kind, body))
        at += 12 + size
    assert chunks[-1] == (b"IEND", b"")
    width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[0][1])
    bytes_a_pixel = {2: 3, 6: 4}[colour]
    assert (depth, interlaced) == (8, 0)
    packed = zlib.decompress(b"".join(body for kind, body in chunks if kind == b"IDAT"))
    assert len(packed) == height * (1 + width * bytes_a_pixel)
    return width, height, bytes_a_pixel, packed


def decode_png(data):
    """Rows of (r, g, b) or (r, g, b, a)."""
    width, height, bytes_a_pixel, packed = inflate_png(data)
    step, rows, last = width * bytes_a_pixel, [], bytes(width * bytes_a_pixel)
    for y in range(height):
        last = unfilter(packed[y * (1 + step)], packed[y * (1 + step) + 1:(y + 1) * (1 + step)], last, bytes_a_pixel)
        rows.append([tuple(last[n:n + bytes_a_pixel]) for n in range(0, step, bytes_a_pixel)])
    return rows


def unfilter(kind, row, above, pixel):
    out = bytearray(row)
    for n in range(len(row)):
        a, b, c = (out[n - pixel] if n >= pixel else 0), above[n], (above[n - pixel] if n >= pixel else 0)
        if kind == 4:
            p = a + b - c
            guess = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        else:
            guess = (0, a, b, (a + b) // 2)[kind]
        out[n] = (row[n] + guess) & 255
    return bytes(out)
