# Maps of the sky: Radiance's pictures, written without a library, and what light they send.
#
#     python3 tests/cli/skies.py sky.hdr      # an evening: blue above, warm about a low sun, dark below; docs/sky.png is lit by it
# SPDX-License-Identifier: GPL-3.0-or-later
import math
import sys


def rgbe(colour):
    """Three mantissas of 8 bits and an exponent."""
    most = max(colour)
    if most <= 0:
        return bytes(4)
    exponent = math.frexp(most)[1]
    if round(math.ldexp(most, 8 - exponent)) == 256:
        exponent += 1
    return bytes([round(math.ldexp(c, 8 - exponent)) for c in colour] + [exponent + 128])


def value(four):
    return [math.ldexp(m, four[3] - 136) if four[3] else 0 for m in four[:3]]


def head(wide, high, settings=("FORMAT=32-bit_rle_rgbe",)):
    return "".join(f"{line}\n" for line in ("#?RADIANCE", *settings, "", f"-Y {high} +X {wide}")).encode()


def way(x, y, wide, high, turn=0):
    """Where a place on the map is seen: its middle column along +x, turned by degrees, counter-clockwise from above."""
    polar, around = math.pi * y / high, 2 * math.pi * (x / wide - 0.5) - math.radians(turn)
    return math.sin(polar) * math.cos(around), math.cos(polar), math.sin(polar) * math.sin(around)


class Sky:
    """colour(way): radiance, linear; rounded as a file has it."""

    def __init__(self, high, colour):
        self.wide, self.high = 2 * high, high
        self.pixels = [[rgbe(colour(way(x + 0.5, y + 0.5, self.wide, high))) for x in range(self.wide)] for y in range(high)]

    def write(self, path, settings=("FORMAT=32-bit_rle_rgbe",)):
        """One pixel after the other, without runs."""
        path.write_bytes(head(self.wide, self.high, settings) + b"".join(pixel for row in self.pixels for pixel in row))
        return path

    def irradiance(self, normal, left=lambda toward: 1, turn=0, fine=2):
        """Of a plane: each texel in fine x fine parts, each by its solid angle and cosine, and by what is left of its light on the way."""
        total = [0, 0, 0]
        for y in range(self.high * fine):
            top, end = (math.cos(math.pi * (y + n) / (self.high * fine)) for n in (0, 1))
            for x in range(self.wide * fine):
                toward = way(x + 0.5, y + 0.5, self.wide * fine, self.high * fine, turn)
                cosine = sum(a * b for a, b in zip(normal, toward))
                if cosine > 0 and (share := left(toward)):
                    solid = 2 * math.pi / (self.wide * fine) * (top - end) * share
                    total = [t + c * solid * cosine for t, c in zip(total, value(self.pixels[y // fine][x // fine]))]
        return total


SUN = [c / math.sqrt(0.9 ** 2 + 0.35 ** 2 + 0.5 ** 2) for c in (0.9, 0.35, 0.5)]


def evening(toward):
    """Blue above, warm about a sun of 5 degrees, a dark ground."""
    up, near = toward[1], max(0, sum(a * b for a, b in zip(toward, SUN)))
    if up < 0:
        return 0.05, 0.045, 0.04
    if near > math.cos(math.radians(2.5)):
        return 420, 300, 170
    glow, dusk = near ** 12, (1 - up) ** 3
    return 0.16 + 0.5 * dusk + 2.2 * glow, 0.3 + 0.34 * dusk + 1.3 * glow, 0.62 + 0.2 * dusk + 0.5 * glow


if __name__ == "__main__":
    import pathlib
    Sky(256, evening).write(pathlib.Path(sys.argv[1]))
