# Pages that vxs writes, as a browser shows them, and pictures in them, read strictly.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import html.parser
import json
import re
import struct
import zlib

TAGS = {"html", "head", "meta", "title", "style", "body", "noscript", "script", "h1", "h2", "h3", "p", "ul", "li", "div", "small", "b", "i",
        "u", "code", "figure", "figcaption", "canvas", "img", "table", "thead", "tbody", "tfoot", "tr", "th", "td", "br"}
LOOK = """(() => {
    const parts = [document.title], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode())
        if (!walker.currentNode.parentElement.closest("script, noscript")) parts.push(walker.currentNode.data);
    const elements = [...document.getElementsByTagName("*")];
    const colours = (canvas) => new Set(new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size;
    const charts = [...document.querySelectorAll("figure[id]")].map((figure) => {
        const canvas = figure.querySelector("canvas"), scales = Object.values(Chart.getChart(canvas).scales);
        return [figure.id, {title: figure.querySelector("h3").textContent, colours: colours(canvas),
            words: scales.flatMap((s) => [s.options.title.text ?? "", ...s.ticks.map((t) => [t.label].flat().join(" "))]),
            key: [...figure.querySelectorAll("li")].map((item) => item.textContent)}];
    });
    return {text: parts.join(" "), tags: elements.map((e) => e.localName), charts: Object.fromEntries(charts),
        attributes: elements.flatMap((e) => [...e.attributes].map((a) => [e.localName, a.name, a.value])),
        sources: [...document.images].map((i) => i.src), ids: elements.map((e) => e.id).filter(Boolean), data: JSON.stringify(data)};
})()"""


class Source(html.parser.HTMLParser):
    """What a page's markup is before a script has run."""

    def __init__(self, source):
        super().__init__(convert_charrefs=True)
        self.tags = []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        assert not any(name.startswith("on") for name, _ in attributes)


class Page:
    """A page that stands alone and runs nothing but its own scripts.
    text: all of it, blanks made one; charts: by name; data: what its scripts were given; pictures: as PNG."""

    def __init__(self, browser, path):
        self.source = path.read_text()
        assert self.source.startswith("<!DOCTYPE html>\n") and self.source.endswith("</html>\n")
        assert "SPDX" not in self.source, "a page is its user's: the templates' licence is not in it"
        assert Source(self.source).tags == ["html", "head", *["meta"] * 3, "title", "style", "body", "noscript", *["script"] * 3]
        browser.show(path)
        assert browser.complaints == [] and [r for r in browser.requests if not r.startswith("data:")] == [path.as_uri()]
        found = browser.ask(LOOK)
        assert set(found["tags"]) <= TAGS and found["tags"].count("script") == 3, "no name became markup"
        assert len(found["ids"]) == len(set(found["ids"])), "an id twice"
        for tag, name, value in found["attributes"]:
            assert not name.startswith("on"), f"{tag} {name}"
            assert not re.match(r"(?i)\s*(javascript:|https?:|//)", value), f"{tag} {name}={value}"
        self.text, self.charts, self.sources = re.sub(r"\s+", " ", found["text"]), found["charts"], found["sources"]
        self.data = json.loads(found["data"])
        assert self.data == json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', self.source, re.DOTALL)[1])
        self.pictures = [base64.b64decode(s.removeprefix("data:image/png;base64,"), validate=True) for s in self.sources]
        self.sizes = [inflate_png(p)[:2] for p in self.pictures]


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
