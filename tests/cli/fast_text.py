# Pages and resident parts of lights that are packed fast, by sections 13 and 14.10 of formats/vxs.md: what is left out of their
# words.
# SPDX-License-Identifier: GPL-3.0-or-later
import struct

HALVES_OF_KIND = {3: 19, 4: 33, 5: 65, 6: 97, 7: 3, 8: 6, 9: 6, 10: 10}


def ones(x):
    return bin(x).count("1")


class Page:
    """A page's words as they are looked up, from those that its frame holds. inflate(frame, size)"""

    def __init__(self, data, inflate):
        count, self.node_words = (n + 1 for n in struct.unpack_from("<2H", data))
        self.halves = list(struct.unpack(f"<{2 * count}H", inflate(data[4:], 4 * count)))
        self.word, self.pool = 0, 2 * self.node_words
        while self.word < self.node_words:
            self.node()
        assert self.word == self.node_words and self.pool in (2 * count, 2 * count - 1)
        self.words = [low | high << 16 for low, high in zip(self.halves[::2], self.halves[1::2], strict=True)]

    def byte(self, half, n):
        return self.halves[half + n // 2] >> 8 * (n % 2) & 255

    def node(self):
        at = 2 * self.word
        mixed, fresh = (sum(ones(half) for half in self.halves[at + first:at + first + 4]) for first in (0, 4))
        wide = self.halves[at + 10]
        self.word += (11 + mixed + (1 + wide) * (mixed + fresh) + 1) // 2
        for name in range(at + 11, at + 11 + mixed):
            if self.halves[name] == 0:
                self.halves[name] = self.word
                self.block()

    def block(self):
        at = 2 * self.word
        mixed, fresh, own, form = self.halves[at:at + 4]
        q, width, far = (form & 15) + 1, form >> 8 & 3, form >> 10 & 1
        tiles = self.word + (4 if own & ~mixed else 2)
        data = (q - 1) * (1 << width) + (ones(fresh) + 1) // 2
        self.word = tiles + ones(mixed) + (data + 3) // 4 + far * ones(own & mixed)
        for n, t in enumerate(t for t in range(16) if mixed >> t & 1):
            half = 2 * (tiles + n)
            low, high = self.halves[half:half + 2]
            if low >> 14 or high:
                continue
            self.halves[half], self.halves[half + 1] = low | self.pool << 14 & 0xffff, self.pool >> 2
            self.pool += self.own() if own >> t & 1 else self.masks(self.pool, ones(low))

    def masks(self, half, p):
        """How many halves a pattern of p depths takes."""
        if self.byte(half, 0) == 255:
            return 17
        return p // 2 + sum(self.byte(half, n) >> 2 * c & 3 == 2 for n in range(p - 1) for c in range(4))

    def own(self):
        kind, p = self.halves[self.pool] >> 12, self.halves[self.pool] & 255
        if kind > 2:
            return HALVES_OF_KIND[kind]
        deltas = (p // 2, p - 1, 2 * (p - 1))[kind]
        return 1 + deltas + self.masks(self.pool + 1 + deltas, p)


def resident_words(data, inflate):
    """Of a resident part, zeros where pages start."""
    words, _, _, patterns = struct.unpack_from("<4I", data)
    return list(struct.unpack_from(f"<{words}I", inflate(data[16:], 4 * words + patterns)))
