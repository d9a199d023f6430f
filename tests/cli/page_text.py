# Pages and resident parts of lights of palette blocks, decoded from section 14 of formats/vxs.md to the letter.
# SPDX-License-Identifier: GPL-3.0-or-later
import struct
from collections import defaultdict
from types import SimpleNamespace

NEVER = -1  # ffff as a depth
K1, K2 = 0x9e3779b97f4a7c15, 0xc2b2ae3d27d4eb4f
RATES = [1, 2] + [3] * 4 + [4] * 8 + [5] * 26 + [6] * 120 + [7]


def signed(x, bits):
    return ((x + (1 << bits - 1)) & ((1 << bits) - 1)) - (1 << bits - 1)


def s16(x):
    return signed(x, 16)


def ones(x):
    return bin(x).count("1")


class Refused(Exception):
    """The bytes break a rule."""


def need(good):
    if not good:
        raise Refused


# 14.1 and 14.8 --------------------------------------------------------------------------------------------------------------


class Odds:
    def __init__(self, weights=None, seen=5):
        self.starts, self.seen = [2048 * n for n in range(16)], 0
        if weights:
            self.starts = [n + 32752 * sum(weights[:n]) // sum(weights) for n in range(16)]
            self.seen = seen


def weights_of(v):
    """v(n, symbol): of 256, for bit n."""
    weights = []
    for symbol in range(16):
        weight = 1
        for n in range(4):
            weight *= v(n, symbol) if symbol >> n & 1 else 256 - v(n, symbol)
        weights.append(weight)
    return weights


def odds_at_start(name):
    kind = name[0]
    bit = lambda k, n: k >> n & 1
    if kind in ("node_mixed", "block_mixed"):
        k = name[-1]
        return Odds(weights_of(lambda n, _: 179 if bit(k, n) else 51))
    if kind == "used":
        _, e, k = name
        return Odds(weights_of(lambda n, _: 0 if n >= e > 0 else (38, 64, 128, 218)[bit(k, n) + 2 * bit(k, n + 4)]))
    if kind == "differs":
        k = name[-1]
        before = lambda n, symbol: bit(symbol, n - 1) if n else bit(k, 5)
        return Odds(weights_of(lambda n, symbol: 128 if before(n, symbol) else 77 if bit(k, n) or bit(k, n + 1) else 10))
    return Odds()


def fine_odds_at_start(name):
    """14.11"""
    if name[0] == "depth_like":
        return Odds([2**(31 - n) if n < 15 else 2**17 for n in range(16)], 0)
    if name[0] in ("delta", "pattern", "common", "base", "private_base"):
        if name[-2] == "rest":
            return Odds([int(n < 2**name[-1]) for n in range(16)], 0)
        if name[-1] == "sign":
            return Odds([int(n < 2) for n in range(16)], 0)
    return odds_at_start(name)


class OddsByName(dict):
    def __init__(self, start):
        self.start = start

    def __missing__(self, name):
        self[name] = self.start(name)
        return self[name]


class Coder:
    def __init__(self, data, head):
        need(len(data) >= head + 8 and len(data) % 2 == 0)
        self.words, self.at = struct.unpack(f"<{(len(data) - head - 8) // 2}H", data[head:-8]), 0
        self.states = list(struct.unpack("<2I", data[-8:]))

    def take(self, first, size):
        x = self.states.pop(0)
        x = size * (x >> 15) + x % 2**15 - first
        if x < 2**16:
            need(self.at < len(self.words))
            x, self.at = x << 16 | self.words[self.at], self.at + 1
        self.states.append(x)

    def end(self):
        need(self.states == [2**16, 2**16] and self.at == len(self.words))

    def plain(self, n):
        number = (self.states[0] % 2**15) >> 15 - n
        self.take(number << 15 - n, 1 << 15 - n)
        return number


class Symbols:
    """What 14.1 names; odds by a tuple of name and context."""

    def __init__(self, coder, start=odds_at_start):
        self.coder, self.odds, self.plain = coder, OddsByName(start), coder.plain

    def nibble(self, *name):
        s = self.symbol(name)
        self.learn(name, s)
        return s

    def symbol(self, name):
        o, at = self.odds[name], self.coder.states[0] % 2**15
        s = max(n for n in range(16) if o.starts[n] <= at)
        self.coder.take(o.starts[s], (o.starts[s + 1] if s < 15 else 2**15) - o.starts[s])
        return s

    def learn(self, name, s):
        o = self.odds[name]
        r = RATES[o.seen]
        o.starts = [x + (((n if n <= s else 2**15 - 16 + n) - x) >> r) for n, x in enumerate(o.starts)]
        o.seen = min(160, o.seen + 1)

    def two_nibbles(self, name, second):
        """second: the second one's odds, by what the first one is"""
        s = self.symbol(name)
        t = self.symbol(second(s))
        self.learn(name, s)
        self.learn(second(s), t)
        return s, t

    def flag(self, *name):
        return int(self.nibble(*name) != 0)

    def short(self, name):
        """s, and the number, or None where bits follow that number and step take each in its way."""
        s = self.nibble(*name, "size")
        if s == 15:
            high, middle = self.plain(8), self.plain(12)
            return s, high << 24 | middle << 12 | self.plain(12)
        return s, 0 if s == 0 else 2**s - 1 + self.nibble(*name, "rest", s) if s <= 4 else None

    def top(self, s):
        """What bits above the lowest 12 behind the first one add."""
        return self.plain(s - 12) << 12 if s > 12 else 0

    def number(self, *name):
        s, number = self.short(name)
        return 2**s - 1 + self.top(s) + self.plain(min(s, 12)) if number is None else number

    def signed(self, *name):
        n = self.number(*name, "size") % 2**28
        return 0 if n == 0 else -n if self.flag(*name, "sign") else n

    def step(self, name, rounds, last):
        s, number = self.short(name)
        if number is not None:
            return number
        m, b = min(s, 12), 2**s + self.top(s)
        z = self.nibble(rounds, m)
        e = 0 if z >= m else (2 * self.plain(m - z - 1) + 1) << z
        return b + (e - last - b) % 2**m - 1


# words ----------------------------------------------------------------------------------------------------------------------


class Words(list):
    def put(self, at, size, value):
        """A number of `size` bytes at byte `at`, over zeros."""
        for n in range(size):
            need((at + n) // 4 < len(self))
            self[(at + n) // 4] |= (value >> 8 * n & 255) << 8 * ((at + n) % 4)

    def get(self, at, size):
        return sum((self[(at + n) // 4] >> 8 * ((at + n) % 4) & 255) << 8 * n for n in range(size))

    def half(self, n):
        return self.get(2 * n, 2)


# 14.2 -----------------------------------------------------------------------------------------------------------------------


class Sheet:
    def __init__(self, dx=0, dy=0, at=0, shift=0, whose=0):
        self.dx, self.dy, self.at, self.shift, self.whose = dx, dy, at % 2**32, shift, whose

    def moved(self, x, y):
        return Sheet(self.dx, self.dy, self.at + self.dx * x + self.dy * y, self.shift, self.whose)

    def depth(self, x, y):
        return signed(self.at + self.dx * x + self.dy * y, 32) >> 8


def sheet_of(a, b, shift, least, n, whose):
    dx, dy = a << shift, b << shift
    return Sheet(dx, dy, least - (n - 1) * (min(dx, 0) + min(dy, 0)), shift, whose)


def half_sums(p, q):
    return Sheet(p.dx + q.dx >> 1, p.dy + q.dy >> 1)


def alike(l, a):
    if l is None or a is None:
        return 0 if l is None and a is None else 1 if l is None else 2
    return 3 if l == a else 4


def middle(numbers):
    return sorted(numbers)[len(numbers) // 2] if numbers else 0


def quadrant_index(x, y):
    return 16 * (x // 4 + 2 * (y // 4)) + 4 * (y % 4) + x % 4


def half_place(places, place):
    """What is at a place of a list, and changes places with what is at half of it."""
    need(place < len(places))
    places[place], places[place // 2] = places[place // 2], places[place]
    return places[place // 2]


class Pattern:
    """kind: p, with `index` of each texel; or 0, `own` being its kind, with depths from its base on: deltas by index, depths, or planes."""

    def __init__(self, ref, kind):
        self.ref, self.kind = ref, kind

    def which(self, x, y):
        if self.own == 7:
            return 0
        if self.own == 10:
            return self.mask[x, y]
        one, other = (p.depth(x, y) for p in self.planes)
        return int(other < one if self.own == 8 else other > one)

    def depth(self, x, y, palette=None):
        """From the base on; of a pattern over a palette, the palette's."""
        if self.kind:
            return palette[self.index[x, y]]
        if self.own >= 7:
            return self.planes[self.which(x, y)].depth(x, y)
        return self.deltas[self.index[x, y]] if self.own < 3 else self.depths[x, y]


class Record(SimpleNamespace):
    """A block. It is like no other."""

    __eq__ = object.__eq__


class Walk:
    """What a page and a common pool share: a pool that grows, and what lies beside the texels that come next."""

    def __init__(self, symbols, words, half):
        self.s, self.words, self.pool = symbols, words, half
        self.nx = self.ny = 0
        self.last_private = Sheet()
        self.begin_node([0] * 256, [0] * 256)

    def begin_node(self, above, left):
        self.above = dict(enumerate(above)) | {-1: above[0], 256: above[255]}
        self.left = dict(enumerate(left))
        self.sheet_above, self.sheet_left = defaultdict(Sheet), defaultdict(Sheet)

    def slope(self, i, j):
        a = self.nx * (i - 31 if self.nx < 0 else i)
        b = self.ny * (j - 31 if self.ny < 0 else j)
        return a + b >> 8

    def depth_above(self, x, y0):
        return self.above[x] - self.slope(x // 8, max(y0 // 8 - 1, 0))

    def depth_left(self, x0, y):
        return self.left[y] - self.slope(max(x0 // 8 - 1, 0), y // 8)

    def varied_above(self, x0, n):
        return int(len({self.above[x0 + k] for k in range(n)}) > 1)

    def varied_left(self, y0, n):
        return int(len({self.left[y0 + k] for k in range(n)}) > 1)

    def least_beside(self, x0, y0, n):
        depths = [self.above[x0 + k] for k in range(n)] + [self.left[y0 + k] for k in range(n)]
        depths = [depth for depth in depths if depth != NEVER]
        return min(depths) if depths else None

    # 14.6

    def index_beside(self, v, d):
        v = s16(v - d[0])
        return sum(v > s16((d[n] - d[0]) % 2**16 + (d[n + 1] - d[0]) % 2**16 >> 1) for n in range(len(d) - 1))

    def image(self, p, above, left):
        """Indices of texels. above  of -1 to 8; left  of 0 to 7"""
        index, u, v = {}, above, above
        for y in range(8):
            row, ks = {}, []
            for f in (0, 4):
                ks.append(sum((u[f + n] != u[f + n - 1]) << n for n in range(5)) | any(u[f + n] != v[f + n] for n in range(4)) << 6)
            ks[0] |= (left[y] != u[-1]) << 5
            odds = "differs", int(p > 2), int(y > 0)
            differs = self.s.two_nibbles((*odds, ks[0]), lambda first: (*odds, ks[1] | first >> 3 << 5))
            for x in range(8):
                row[x] = u[x]
                if differs[x // 4] >> x % 4 & 1:
                    row[x] = 1 - u[x] if p == 2 else self.other(p, row[x - 1] if x else left[y], u[x], u[x + 1])
                need(0 <= row[x] < p)
            index |= {(x, y): row[x] for x in range(8)}
            u, v = row | {-1: left[y], 8: row[7]}, u
        return index

    def other(self, p, w, n, ne):
        like = int(ne != n) if w == n else 2 if ne == n else 3 if ne == w else 4
        end = 0 if n == 0 else 2 if n == p - 1 else 1
        value = self.s.nibble("other", 0 if p < 4 else 1 if p < 6 else 2 if p < 9 else 3, like, end)
        if value == 15:
            return self.s.nibble("far")
        return w if value == 0 else ne if value == 1 else n - value // 2 if value % 2 else n + value // 2

    def pattern_of_depths(self, d, x0, y0):
        above = {x: self.index_beside(self.above[x0 + x], d) for x in range(-1, 9)}
        left = {y: self.index_beside(self.left[y0 + y], d) for y in range(8)}
        index = self.image(len(d), above, left)
        self.lay_out(index, len(d))
        return index

    def lay_out(self, index, p):
        order = sorted(index, key=lambda at: quadrant_index(*at))
        masks = [[sum((index[order[16 * c + z]] <= n) << z for z in range(16)) for n in range(p - 1)] for c in range(4)]
        states, halves = [0] * (p // 2 * 2), []
        for c in range(4):
            last = None
            for n, mask in enumerate(masks[c]):
                state = 0 if mask == 0 else 1 if mask == 0xffff else 3 if mask == last else 2
                if state == 2:
                    halves.append(mask)
                    last = mask
                states[n] |= state << 2 * c
        if p // 2 + len(halves) > 17:
            data = [255, 0] + [index[order[z]] | index[order[z + 32]] << 4 for z in range(32)]
            self.put_pool(data)
        else:
            self.put_pool(states + [byte for half in halves for byte in (half & 255, half >> 8)])

    def put_pool(self, data):
        for n, byte in enumerate(data + [0] * (len(data) % 2)):
            self.words.put(2 * self.pool + n, 1, byte)
        self.pool += (len(data) + 1) // 2

    # 14.5, a new pattern with depths of its own

    def new_private(self, x0, y0, base):
        """base: of the block, far; None in the common pool. Returns the pattern, and the tile's base in the node."""
        pattern = Pattern(self.pool, 0)
        kind = self.s.nibble("private_kind", sum(1 for sheet in (self.sheet_left[y0 // 8], self.sheet_above[x0 // 8]) if sheet.whose))
        need(kind <= 11)
        pattern.own = 3 if kind == 11 else kind
        if 7 <= pattern.own <= 10:
            return pattern, self.new_planes(pattern, x0, y0, base)
        at = self.private_base(pattern, x0, y0, base) if base else 0
        shift = self.s.nibble("private_shift")
        if pattern.own < 3:
            p = self.s.nibble("private_count") + 2
            need(p <= 16)
            deltas, width = self.deltas(p - 1, lambda *_: ("private_delta",), "private_round", pattern.own, shift)
            self.put_pool([p, pattern.own << 4 | shift] + [delta >> 8 * n & 255 for delta in deltas for n in range(width)])
            pattern.deltas = [0] + [delta << shift for delta in deltas]
            pattern.index = self.pattern_of_depths([s16(at + delta) for delta in pattern.deltas], x0, y0)
        else:
            self.raw(pattern, kind, shift, at, x0, y0)
        return pattern, at

    def deltas(self, count, name, rounds, width, shift, met=lambda n, last: None):
        """name: odds of delta n behind a step; met: that delta, where it is coded otherwise"""
        last, deltas, size, step = 0, [], 1 << width, 0
        for n in range(count):
            delta = met(n, last)
            step = 1 + self.s.step(name(n, step), rounds, last) if delta is None else delta - last
            need(step > 0)
            last += step
            need(last < 2**(8 if width == 0 else 16 if width == 1 else 24) and last << shift < 2**24)
            deltas.append(last)
        return deltas, size

    def raw(self, pattern, kind, shift, at, x0, y0):
        end, d, m = {3: 271, 4: 2**8, 5: 2**16, 6: 2**24}[pattern.own], {}, 0
        for y in range(8):
            for x in range(8):
                if x and y:
                    expected = d[x - 1, y] + d[x, y - 1] - d[x - 1, y - 1]
                elif x:
                    expected = d[x - 1, 0] + (s16(self.above[x0 + x] - self.above[x0 + x - 1]) >> shift)
                elif y:
                    expected = d[0, y - 1] + (s16(self.left[y0 + y] - self.left[y0 + y - 1]) >> shift)
                else:
                    expected = s16(min(self.left[y0], self.above[x0]) - at) >> shift
                expected = min(max(expected, 0), end - 1)
                u = self.s.nibble("residual", 2 if not x and not y else int(x > 0 and y > 0), m)
                u = 15 + self.s.number("raw_far") if u == 15 else u
                need(u < 2**25)
                d[x, y] = expected - (u + 1) // 2 if u % 2 else expected + u // 2
                need(0 <= d[x, y] < end and d[x, y] << shift < 2**24)
                m = min(5, (2 * m + u + 1) // 4)
        order = sorted(d, key=lambda place: quadrant_index(*place))
        data = [0, pattern.own << 4 | shift]
        if pattern.own == 3:
            bases = [min(d[place] for place in order[16 * c:16 * c + 16]) for c in range(4)]
            if kind == 11:
                bases = [self.s.number("raw_base") for _ in range(4)]
            nibbles = [d[place] - bases[n // 16] for n, place in enumerate(order)]
            need(max(bases) <= 255 and all(0 <= nibble <= 15 for nibble in nibbles))
            data += bases + [nibbles[z] | nibbles[z + 32] << 4 for z in range(32)]
        else:
            data += [d[place] >> 8 * n & 255 for place in order for n in range(pattern.own - 3)]
        self.put_pool(data)
        pattern.depths = {place: depth << shift for place, depth in d.items()}

    # 14.7

    def slopes(self, name, like, shift):
        z = self.s.nibble(*name, "zeros")
        need(z <= 8)
        s, h, steps = shift + z, (1 << shift + z) // 2, []
        for axis, d in (("a", like.dx), ("b", like.dy)):
            step = self.s.signed(*name, axis, z // 4) + (d + h >> s)
            need(-2**15 <= step < 2**15 and -2**15 <= step << z < 2**15)
            steps.append(step << z)
        return steps

    def new_planes(self, pattern, x0, y0, base):
        w = int(pattern.own != 7)
        shift = self.s.nibble("private_plane", w, "shift")
        quarters = self.s.nibble("quarters", w)
        need(shift <= 8 and (w or quarters <= 3))
        left, above = self.sheet_left[y0 // 8], self.sheet_above[x0 // 8]
        left, above = (left if left.whose else above if above.whose else self.last_private,
                       above if above.whose else left if left.whose else self.last_private)
        if w:
            steps = [self.slopes(("private_plane", 1), left, shift), self.slopes(("private_plane", 2), above, shift)]
            p, c = self.s.nibble("far_shift"), self.s.number("far_plane")
            need(p <= 5 and c < 2**16)
        else:
            steps, p, c = [self.slopes(("private_plane", 0), half_sums(left, above), shift)], 0, 0
        leasts = [64 * (quarters & 3), 64 * (quarters >> 2) + (c << p + 8)]
        pattern.planes = [sheet_of(a, b, shift, leasts[n], 8, 1) for n, (a, b) in enumerate(steps)]
        at = self.private_base(pattern, x0, y0, base) if base else 0
        halves = [pattern.own << 12 | shift << 8 | quarters << 3 | p, *(step & 0xffff for pair in steps for step in pair)] + [c] * w
        if pattern.own == 10:
            pattern.mask = self.mask(pattern, at - self.slope(x0 // 8, y0 // 8), x0, y0)
            bits = sum(bit << quadrant_index(*place) for place, bit in pattern.mask.items())
            halves += [bits >> 16 * n & 0xffff for n in range(4)]
        self.put_pool([half >> 8 * n & 255 for half in halves for n in range(2)])
        return at

    def mask(self, pattern, base, x0, y0):
        def nearer(depth, x, y):
            one, other = (abs(depth - base - plane.depth(x, y)) for plane in pattern.planes)
            return int(other < one)

        above = {x: nearer(self.depth_above(x0 + x, y0), x, -1) for x in range(8)}
        left = {y: nearer(self.depth_left(x0, y0 + y), -1, y) for y in range(8)}
        return self.image(2, above | {-1: above[0], 8: above[7]}, left)

    def private_base(self, pattern, x0, y0, base):
        block, far = base
        if pattern.own < 7:
            least = self.least_beside(x0, y0, 8)
            like = 0 if least is None else s16(least - block)
        else:
            planes = pattern.planes[:1] if pattern.own in (7, 10) else pattern.planes
            choose = max if pattern.own == 9 else min
            there = lambda x, y: choose(plane.depth(x, y) for plane in planes)
            numbers = [self.depth_above(x0 + n, y0) - there(n, -1) for n in (1, 3, 5, 7) if self.above[x0 + n] != NEVER]
            numbers += [self.depth_left(x0, y0 + n) - there(-1, n) for n in (1, 3, 5, 7) if self.left[y0 + n] != NEVER]
            like = s16(self.slope(x0 // 8, y0 // 8) - block + middle(numbers))
        value = like + self.s.signed("private_base", 0 if pattern.own < 7 else 1 if pattern.own == 7 else 2)
        need(abs(value) < 2**24 if far else -8192 <= value < 8192)
        return block + value


# 14.3 to 14.5 ---------------------------------------------------------------------------------------------------------------


class Page(Walk):
    """nodes: (word, X, Y, map, base). common: lists of patterns by kind, as they lie, of the common pool. packing: of the light."""

    def __init__(self, data, nodes, common, packing):
        self.more = packing == 2
        self.pattern_sets, self.used_sets, self.last_shift = defaultdict(list), defaultdict(list), 0
        count, node_words = (n + 1 for n in struct.unpack_from("<2H", data))
        need(node_words <= count and nodes)
        super().__init__(Symbols(Coder(data, 4), fine_odds_at_start if self.more else odds_at_start), Words([0] * count), 2 * node_words)
        self.word, self.node_words, self.common = 0, node_words, common
        self.lists, self.blocks, self.lately = defaultdict(list), [], []
        self.plane_above, self.plane_left, self.block_above, self.block_left = {}, {}, {}, {}
        self.last_plane, self.ends = Sheet(), []
        for node in nodes:
            self.node(*node)
        need(self.word == node_words and (self.pool + 1) // 2 == count)
        self.s.coder.end()

    # 14.2

    def beside_node(self, X, Y, map_, base):
        found = {}
        for end in self.ends:  # a later one has the same place
            if end.X % 64 == X % 64:
                found["above"] = end if (end.X, end.Y + 1, end.map) == (X, Y, map_) else None
            if end.Y % 64 == Y % 64:
                found["left"] = end if (end.X + 1, end.Y, end.map) == (X, Y, map_) else None
        above, left = [0] * 256, [0] * 256
        if found.get("above"):
            above = [d if d == NEVER else s16(d - base + self.slope(x // 8, 0)) for x, d in enumerate(found["above"].above)]
        if found.get("left"):
            left = [d if d == NEVER else s16(d - base + self.slope(0, y // 8)) for y, d in enumerate(found["left"].left)]
        return above, left

    def leave(self, x0, y0, n, row, column, sheets=(Sheet(), Sheet())):
        for k in range(n):
            self.above[x0 + k], self.left[y0 + k] = s16(row(k)), s16(column(k))
        for k in range(n // 8):
            self.sheet_above[x0 // 8 + k], self.sheet_left[y0 // 8 + k] = sheets

    def leave_depth(self, x0, y0, n, depth):
        self.leave(x0, y0, n, lambda _: depth, lambda _: depth)

    def leave_pattern(self, x0, y0, pattern, palette, base):
        depth = lambda x, y: pattern.depth(x, y, palette) + (0 if pattern.kind else base)
        sheets = Sheet(), Sheet()
        if not pattern.kind and pattern.own >= 7:
            without = base - self.slope(x0 // 8, y0 // 8) << 8
            sheets = [pattern.planes[pattern.which(*texel)] for texel in ((4, 7), (7, 4))]
            sheets = [Sheet(p.dx, p.dy, p.at + without, p.shift, 1) for p in sheets]
            self.last_private = sheets[1]
        self.leave(x0, y0, 8, lambda x: depth(x, 7), lambda y: depth(7, y), sheets)

    def leave_plane(self, x0, y0, sheet):
        slope = self.slope(x0 // 8, y0 // 8)
        self.leave(x0, y0, 8, lambda x: sheet.depth(x, 7) + slope, lambda y: sheet.depth(7, y) + slope, (sheet, sheet))

    # 14.3

    def node(self, word, X, Y, map_, base):
        need(self.word == word)
        wide = self.s.flag("wide")
        if not self.s.flag("same_slope"):
            self.nx = self.ny = 0
            if not self.s.flag("no_slope"):
                self.nx = s16(self.s.signed("slope"))
                self.ny = s16(self.s.signed("slope"))
        self.begin_node(*self.beside_node(X, Y, map_, base))
        mixed = 0
        for n in range(16):
            x0, y0 = 128 * (n % 2), 32 * (n // 2)
            k = mixed >> 4 * n - 8 & 15 if n > 1 else sum(self.varied_above(x0 + 32 * b, 32) << b for b in range(4))
            k |= (mixed >> 4 * n - 1 & 1 if n % 2 else self.varied_left(y0, 32)) << 4
            mixed |= self.s.nibble("node_mixed", k | n % 2 << 5) << 4 * n
        fresh_count, count = self.s.number("fresh_count"), ones(mixed)
        need(fresh_count + count <= 64)
        size, at = 2 if wide else 1, 2 * self.word
        self.word += (11 + count + size * (count + fresh_count) + 1) // 2
        need(self.word <= self.node_words)
        refs, bases, depths, fresh, last, next_corner = [], [], [], 0, None, None
        blocks = 64 - count
        for c in range(64):
            x0, y0 = 32 * (c % 8), 32 * (c // 8)
            self.corner, next_corner = next_corner if x0 else self.left[y0], self.above[x0 + 31]
            if mixed >> c & 1:
                ref, block_base = self.block(wide, x0, y0)
                refs.append(ref)
                bases.append(block_base)
                continue
            rest = fresh_count - len(depths)
            share = (rest < blocks) + (2 * rest < blocks) + (8 * rest < blocks)
            depth = last if self.more and not rest else self.uniform_block(wide, last or 0, share, x0, y0)
            need(depth is not None)
            blocks -= 1
            self.leave_depth(x0, y0, 32, depth)
            if last is None or depth != last:
                fresh |= 1 << c
                depths.append(depth)
            last = depth
        need(len(depths) == fresh_count)
        for n in range(4):
            self.words.put(2 * (at + n), 2, mixed >> 16 * n)
            self.words.put(2 * (at + 4 + n), 2, fresh >> 16 * n)
        for n, half in enumerate([self.nx, self.ny, wide] + refs):
            self.words.put(2 * (at + 8 + n), 2, half & 0xffff)
        for n, number in enumerate(bases + depths):
            self.words.put(2 * (at + 11 + count + size * n), 2 * size, number)
        above, left = ([depths[n] for n in range(256)] for depths in (self.above, self.left))
        self.ends.append(SimpleNamespace(
            X=X, Y=Y, map=map_, above=[d if d == NEVER else s16(d + base - self.slope(x // 8, 31)) for x, d in enumerate(above)],
            left=[d if d == NEVER else s16(d + base - self.slope(31, y // 8)) for y, d in enumerate(left)]))

    def uniform_block(self, wide, last, share, x0, y0):
        left, above, before = (x & 0xffff for x in (self.left[y0], self.above[x0], last))
        k = (left == above) | (before in (left, above)) << 1 | (left == 0xffff) << 2
        if self.more:
            k = k | (before == left) << 3 | self.alike_at_corner(x0, y0, 32) << 4 | share << 8
        like = self.s.nibble("depth_like", k)
        if like < 4:
            low = (left, above, before, 0xffff)[like]
        else:
            low = (self.s.signed("depth") + (left if left != 0xffff else above if above != 0xffff else 0)) & 0xffff
        depth = (low | self.s.number("high") << 16) & 0xffffffff if wide else low
        need(not wide or depth < 2**24 or depth == 0xffffffff)
        return depth

    # 14.11

    def alike_at_corner(self, x0, y0, n):
        if not self.more:
            return 0
        behind = self.above[x0 + n]
        return ((self.corner == self.left[y0]) | (self.corner == self.above[x0]) << 1 |
                (0 if behind == self.above[x0] else 1 if behind == self.left[y0] else 2) << 2)

    def changes(self, x0, y0):
        if not self.more:
            return 0
        count = sum((self.above[x0 + n] != self.above[x0 + n - 1]) + (self.left[y0 + n] != self.left[y0 + n - 1]) for n in range(1, 32))
        return sum(count >= least for least in (1, 2, 3, 4, 6, 9, 15))

    def again(self, name, places):
        """What the set has at a place, which then comes first; or None."""
        place = self.s.nibble(name[0], name[1], len(places)) if places else 15
        if place >= len(places):
            return None
        places.insert(0, places.pop(place))
        return places[0]

    def depth_beside(self, base, shift, last, x0, y0):
        """The last delta, or None where it leads to no depth beside the block."""
        depths = [self.above[x0 + n] for n in range(32)] + [self.left[y0 + n] for n in range(32)]
        most = max([depth for depth in depths if depth != NEVER], default=-2**15)
        found = [s16(depth - base) for depth in (most, self.left[y0 + 31], self.above[x0 + 31])]
        if found[0] <= last << shift:
            return None
        place = self.s.nibble("last_depth", (found[1] == found[0]) | (found[2] == found[0]) << 1)
        if place > 2:
            return None
        need(found[place] % (1 << shift) == 0)
        return found[place] >> shift

    # 14.4

    def sheets_of_block(self, x0, y0):
        found = []
        for sheets, first, step in ((self.sheet_left, y0 // 8, (8, 0)), (self.sheet_above, x0 // 8, (0, 8))):
            for whose in (2, 1):
                ks = [k for k in range(4) if sheets[first + k].whose == whose]
                if ks:
                    k = ks[0]
                    back = (0, -8 * k) if step[0] else (-8 * k, 0)
                    found.append(sheets[first + k].moved(step[0] + back[0], step[1] + back[1]))
                    break
            else:
                found.append(Sheet())
        return found

    def where_least(self, a, b, shift, left, above, x0, y0):
        s = sheet_of(a, b, shift, 0, 32, 2)
        for one in (left, above):
            if one.whose and (one.dx, one.dy, one.shift) == (s.dx, s.dy, s.shift):
                return one.at - s.at, 1
        numbers = []
        for n in range(2, 32, 4):
            if self.above[x0 + n] != NEVER:
                numbers.append(256 * self.depth_above(x0 + n, y0) + 128 - s.dx * n + s.dy)
            if self.left[y0 + n] != NEVER:
                numbers.append(256 * self.depth_left(x0, y0 + n) + 128 - s.dy * n + s.dx)
        return middle(numbers) - s.at, 0

    def new_plane(self, block, x0, y0):
        left, above = self.sheets_of_block(x0, y0)
        k = left.whose + 3 * above.whose
        block.on_plane = self.s.nibble("on_plane", k)
        need(block.on_plane <= 2)
        if not block.on_plane:
            return
        like = self.s.nibble("plane_like", k)
        need(like <= 3)
        choices = [left if left.whose else self.last_plane, above if above.whose else self.last_plane, self.last_plane]
        if like < 3:
            one = choices[like]
            block.a, block.b, block.s = one.dx >> one.shift, one.dy >> one.shift, one.shift
        else:
            block.s = self.s.nibble("block_plane", "shift")
            need(block.s <= 8)
            block.a, block.b = self.slopes(("block_plane",), half_sums(*choices[:2]), block.s)
        p, g = self.where_least(block.a, block.b, block.s, left, above, x0, y0)
        z = self.s.nibble("least_zeros", g)
        need(z <= 8 or z == 15)
        block.least = p
        if z < 15:
            s, o = min(z + 1, 8), 2**z if z < 8 else 0
            block.least = ((p - o + 2**(s - 1)) % 2**32 >> s << s) + o + (self.s.signed("plane_least", g, z // 4) << s)

    def block(self, wide, x0, y0):
        above, left = self.block_above.get(x0), self.block_left.get(y0)
        found = self.s.nibble("block_found", alike(left, above))
        need(found <= 3)
        if found == 0:
            block = Record(word=self.word, on_plane=0)
            need(self.word + 2 <= self.node_words)
            self.blocks.append(block)
            self.new_plane(block, x0, y0)
        else:
            block = half_place(self.blocks, self.s.number("block")) if found == 1 else left if found == 2 else above
            need(block)
        self.block_above[x0] = self.block_left[y0] = block
        base = self.block_base(block, found, wide, x0, y0)
        if block.on_plane:
            if found == 0:
                block.c = signed(block.least - 256 * base, 28)
            sheet = sheet_of(block.a, block.b, block.s, 256 * base + block.c, 32, 2)
            self.last_plane = sheet
        else:
            sheet = None
        if found == 0:
            self.new_block(block, base, sheet, x0, y0)
        else:
            self.leave_block(block, base, sheet, x0, y0)
        return block.word, base

    def block_base(self, block, found, wide, x0, y0):
        if block.on_plane and found:
            left, above = self.sheets_of_block(x0, y0)
            p, _ = self.where_least(block.a, block.b, block.s, left, above, x0, y0)
            n, like = 2, p - block.c + 128 >> 8
        elif block.on_plane == 2:
            n, like = 1, block.least >> 8
        else:
            n, like = 0, self.least_beside(x0, y0, 32) or 0
        k = self.varied_left(y0, 32) + 2 * self.varied_above(x0, 32) if self.more else 0
        base = (self.s.signed("base", n, k) + like) % 2**16
        high = self.s.number("high") if wide else 0
        need(high < 256)
        return base | high << 16

    def new_block(self, b, base, sheet, x0, y0):
        varied_beside = self.varied_left(y0, 32) + 2 * self.varied_above(x0, 32)
        b.q, b.shift, b.width, b.far, b.deltas, b.tiles, b.palette = 1, 0, 0, 0, [], [], [0]
        if b.on_plane < 2:
            b.q = self.s.nibble("entries", 4 if b.on_plane else varied_beside, self.changes(x0, y0)) + 1
            need(b.q <= 14)
            K = 0 if b.q == 1 else self.size_class(b.q)
            b.shift = self.s.nibble("delta_form", K, min(self.last_shift, 3)) if self.more else self.s.nibble("delta_form", int(b.q == 1))
            if b.shift == 15:
                b.shift = self.s.nibble("delta_shift")
                b.width = self.s.nibble("delta_width")
                need(b.width <= 7)
                b.far, b.width = b.width >> 2, b.width & 3
                need(b.width < 2 or b.width == 2 and b.shift == 0)
            self.last_shift = b.shift if b.q > 1 else self.last_shift
            b.deltas, _ = self.deltas(b.q - 1, lambda *at: self.odds_of_delta(b, *at), "round", b.width, b.shift,
                                      lambda n, last: self.depth_beside(base, b.shift, last, x0, y0)
                                      if self.more and b.width < 2 and n + 2 == b.q else None)
            b.palette += [delta << b.shift for delta in b.deltas]
        depth = [s16(base + d) for d in b.palette]
        K = self.size_class(b.q)
        b.last = 16
        b.corners = [self.corner] + [self.left[y0 + 8 * y - 1] for y in range(1, 4)]
        for y in range(4):
            self.row(b, y, K, base, depth, sheet, x0, y0 + 8 * y)
        kinds = [tile.kind for tile in b.tiles]
        need(not b.on_plane or "plane" in kinds)
        # words of the record
        mixed = sum((kind in ("pattern", "own")) << t for t, kind in enumerate(kinds))
        own = sum((kind in ("plane", "own")) << t for t, kind in enumerate(kinds))
        fresh = sum(bool(tile.fresh) << t for t, tile in enumerate(b.tiles))
        first = self.word
        words = [mixed | fresh << 16, own | b.q - 1 << 16 | b.shift << 20 | b.width << 24 | b.far << 26]
        if b.on_plane:
            words += [b.a & 0xffff | (b.b & 0xffff) << 16, b.s | b.c << 4 & 0xfffffff0]
        words += [tile.word for tile in b.tiles if tile.kind in ("pattern", "own")]
        data = [delta >> 8 * n & 255 for delta in b.deltas for n in range(1 << b.width)]
        nibbles = [tile.entry for tile in b.tiles if tile.fresh]
        data += [sum(nibble << 4 * n for n, nibble in enumerate(nibbles[at:at + 2])) for at in range(0, len(nibbles), 2)]
        data += [0] * (-len(data) % 4)
        words += struct.unpack(f"<{len(data) // 4}I", bytes(data))
        words += [tile.base & 0xffffffff for tile in b.tiles if tile.kind == "own" and b.far]
        need(first + len(words) <= self.node_words)
        self.words[first:first + len(words)] = words
        self.word += len(words)

    def size_class(self, q):
        return q - 1 if q <= 2 else 2 if q <= 4 else 3 if q <= 8 else 4

    def odds_of_delta(self, b, n, step):
        if b.width == 2:
            return ("delta_wide",)
        return ("delta", self.size_class(b.q), min(b.shift, 3), int(n + 2 == b.q), min(step, 6)) if self.more else ("delta", b.shift, int(n > 0))

    def row(self, b, y, K, base, depth, sheet, x0, y0):
        on = mixed = 0
        if b.on_plane == 2:
            on = 15
        elif b.on_plane:
            above = [self.above[x0 + n] != NEVER and abs(s16(self.depth_above(x0 + n, y0) - sheet.depth(n, 8 * y - 1))) <= 1
                     for n in range(32)]
            left = [self.left[y0 + n] != NEVER and abs(s16(self.depth_left(x0, y0 + n) - sheet.depth(-1, 8 * y + n))) <= 1
                    for n in range(8)]
            k = sum(all(above[8 * x:8 * x + 8]) << x for x in range(4)) | all(left) << 4
            on = self.s.nibble("row_on_plane", k | (y > 0) << 5)
        if on != 15:
            k = sum(self.varied_above(x0 + 8 * x, 8) << x for x in range(4))
            k |= self.varied_left(y0, 8) << 4 | (self.left[y0] != self.above[x0]) << 5
            mixed = self.s.nibble("row_mixed", K, on) if b.on_plane else self.s.nibble("block_mixed", K, k)
            need(not on & mixed)
        for x in range(4):
            tile = SimpleNamespace(kind="uniform", fresh=0, used=0)
            self.corner, b.corners[y] = b.corners[y], self.above[x0 + 8 * x + 7]
            if on >> x & 1:
                tile.kind = "plane"
                self.leave_plane(x0 + 8 * x, y0, sheet.moved(8 * x, 8 * y))
            elif mixed >> x & 1:
                self.mixed_tile(b, tile, base, depth, x0 + 8 * x, y0)
            else:
                self.uniform_tile(b, tile, depth, x0 + 8 * x, y0)
            b.tiles.append(tile)

    # 14.5

    def uniform_tile(self, b, tile, depth, x0, y0):
        tile.entry = 0
        if b.q > 1:
            l, a = (next((n for n in range(b.q) if depth[n] == d), None) for d in (self.left[y0], self.above[x0]))
            value = self.s.nibble("index", alike(l, a), 0 if b.q < 4 else 1 if b.q < 9 else 2, self.alike_at_corner(x0, y0, 8))
            tile.entry = l if value == 0 else a if value == 1 else value - 2
            need(tile.entry is not None and tile.entry < b.q)
        tile.fresh, b.last, tile.used = tile.entry != b.last, tile.entry, 1 << tile.entry
        self.leave_depth(x0, y0, 8, depth[tile.entry])

    def entries_used(self, b, depth, x0, y0):
        l = sum(any(self.left[y0 + n] == depth[e] for n in range(8)) << e for e in range(b.q))
        a = sum(any(self.above[x0 + n] == depth[e] for n in range(8)) << e for e in range(b.q))
        used_set = self.used_sets[(l * K1 + (a + (b.q << 16)) * K2) % 2**64 >> 51]
        if self.more and b.q > 4:
            again = self.again(("used_again", int(b.q > 8)), used_set)
            if again is not None:
                need(again < 1 << b.q and ones(again) != 1)
                return again
        t, number = 0, len(b.tiles)
        if number % 4:
            t |= b.tiles[number - 1].used
        if number > 3:
            t |= b.tiles[number - 4].used
        either, s = l | a, 0
        if either:
            s = (2 << either.bit_length() - 1) - (either & -either)
        low, used = (l & a) | ((t | s) & ~either), 0
        for n in range(0, b.q, 4):
            e = b.q - n if b.q - n < 4 else 0
            used |= self.s.nibble("used", e, low >> n & 15 | (either >> n & 15) << 4) << n
        need(used < 1 << b.q and ones(used) != 1)
        if b.q > 4:
            used_set[:] = [used] + used_set[:3]
        return used

    def mixed_tile(self, b, tile, base, depth, x0, y0):
        tile.used = self.entries_used(b, depth, x0, y0) if b.q > 1 else 0
        if tile.used:
            tile.kind = "pattern"
            palette = [depth[n] for n in range(b.q) if tile.used >> n & 1]
            tile.pattern = self.pattern(palette, x0, y0)
            tile.word = tile.pattern.ref << 14 | tile.used
            self.leave_pattern(x0, y0, tile.pattern, palette, None)
        else:
            tile.kind = "own"
            tile.pattern, at = self.private_pattern((base, b.far), x0, y0)
            tile.base = at - base
            tile.word = tile.pattern.ref << 14 | (0 if b.far else tile.base + 8192)
            self.leave_pattern(x0, y0, tile.pattern, None, at)

    def from_common(self, kind):
        n = self.s.number("common", kind)
        need(n < len(self.common[kind]))
        self.lists[kind].append(self.common[kind][n])
        return self.common[kind][n]

    def pattern(self, palette, x0, y0):
        p, pattern = len(palette), None
        above = sum(self.index_beside(self.above[x0 + n], palette) << 8 * n for n in range(8))
        left = sum(self.index_beside(self.left[y0 + n], palette) << 8 * n for n in range(8))
        patterns = self.pattern_sets[(above * K1 + (left + p) * K2) % 2**64 >> 52]
        if self.more:
            again = self.again(("pattern_again", min(p - 2, 3)), patterns)
            if again is not None:
                need(again.kind == p)
                return again
        place = self.s.number("pattern", p)
        if place == 0:
            pattern = Pattern(self.pool, p)
            pattern.index = self.pattern_of_depths(palette, x0, y0)
            self.lists[p].append(pattern)
        else:
            pattern = self.from_common(p) if place == 1 else half_place(self.lists[p], place - 2)
        patterns[:] = [pattern] + patterns[:14]
        return pattern

    def private_pattern(self, base, x0, y0):
        pl, pa = self.plane_left.get(y0), self.plane_above.get(x0)
        found = self.s.nibble("private_found", alike(pl, pa))
        need(found <= 5)
        if found == 0:
            pattern, at = self.new_private(x0, y0, base)
            self.lists[0].append(pattern)
        else:
            if found == 1:
                pattern = self.from_common(0)
            elif found == 2:
                pattern = half_place(self.lists[0], self.s.number("pattern", 0))
            elif found == 5:
                place = self.s.number("private_lately")
                need(place < len(self.lately))
                pattern = self.lately[place]
            else:
                pattern = pl if found == 3 else pa
            need(pattern)
            at = self.private_base(pattern, x0, y0, base)
        if pattern.own >= 7:
            self.plane_left[y0] = self.plane_above[x0] = pattern
            self.lately = ([pattern] + [other for other in self.lately if other is not pattern])[:64]
        return pattern, at

    def leave_block(self, b, base, sheet, x0, y0):
        depth = [s16(base + d) for d in b.palette]
        for t in (3, 7, 11, 12, 13, 14, 15):
            x, y, tile = x0 + 8 * (t % 4), y0 + 8 * (t // 4), b.tiles[t]
            if tile.kind == "plane":
                self.leave_plane(x, y, sheet.moved(x - x0, y - y0))
            elif tile.kind == "uniform":
                self.leave_depth(x, y, 8, depth[tile.entry])
            elif tile.kind == "pattern":
                self.leave_pattern(x, y, tile.pattern, [depth[n] for n in range(b.q) if tile.used >> n & 1], None)
            else:
                self.leave_pattern(x, y, tile.pattern, None, base + tile.base)


# 14.9 -----------------------------------------------------------------------------------------------------------------------


def z_order(side):
    for n in range(side * side):
        yield tuple(sum((n >> 2 * bit + axis & 1) << bit for bit in range(16)) for axis in (0, 1))


class Resident:
    """words, nodes of each page as Page takes them, and the common pool's patterns by kind."""

    def __init__(self, data, levels, map_count, packing=0):
        self.more = packing == 2
        count, self.page_count, self.node_count, self.pattern_count = struct.unpack_from("<4I", data)
        self.s, self.words, self.levels = Symbols(Coder(data, 16)), Words([0] * count), levels
        self.pages, self.met, self.at = [], [], 8 + self.page_count
        need(self.at <= count)
        self.words[0] = self.page_count
        for map_ in range(map_count):
            self.top(map_)
        need(len(self.pages) == self.page_count and len(self.met) == self.node_count)
        self.common_pool()
        self.s.coder.end()

    def top(self, map_):
        side, start = max(1, 2**self.levels // 256), self.at
        self.words[2 + map_] = start
        if self.levels < 15:
            self.at += 2 * side * side
            need(self.at <= len(self.words))
            place = lambda x, y: start + 2 * (y * side + x)
            for x, y in z_order(side):
                self.square(place, x, y, map_, 0)
            return
        cells = side // 8
        self.at += cells * cells
        need(self.at <= len(self.words))
        cell_place = lambda x, y: start + y * cells + x

        def place(x, y):
            cell = cell_place(x // 8, y // 8)
            return cell if self.words[cell] >> 31 else self.words[cell] + 2 * (y % 8 * 8 + x % 8)

        for cx, cy in z_order(cells):
            if not self.square(cell_place, cx, cy, map_, 1):
                self.words[cell_place(cx, cy)] = self.at
                self.at += 128
                need(self.at <= len(self.words))
                for x, y in z_order(8):
                    self.square(place, 8 * cx + x, 8 * cy + y, map_, 0)

    def square(self, place, x, y, map_, cell):
        """Returns whether it is done: it is no cell of entries."""
        at, words = place(x, y), self.words
        beside = [place(x - 1, y) if x else None, place(x, y - 1) if y else None]
        states = [0 if other is None else 1 if words[other] >> 31 else 2 for other in beside]
        kind = self.s.nibble("kind", cell, states[0] + 3 * states[1])
        if kind < 2:
            need(states[kind] == 1)
            words[at] = words[beside[kind]]
        elif kind == 2:
            near = [words[other] & 0x7fffffff for other, state in zip(beside, states) if state == 1] + [0]
            if self.more:
                high = self.s.signed("depth") + (near[0] >> 4)
                depth = high << 4 | self.s.plain(4)
            else:
                depth = self.s.signed("depth") + near[0]
            need(0 <= depth <= 2**18)
            words[at] = 0x80000000 | depth
        elif kind == 6:
            need(cell)
            return False
        else:
            need(not cell and kind <= 5)
            self.node(at, kind, x, y, map_, [other for other, state in zip(beside, states) if state == 2])
        return True

    def node(self, at, kind, x, y, map_, beside):
        if kind == 5:
            back = self.s.number("old")
            need(back < len(self.met))
            page, offset = self.met[-1 - back]
        elif kind == 4:
            page, offset = len(self.pages), 0
            self.pages.append([])
        else:
            need(self.met)
            page, offset = len(self.pages) - 1, self.met[-1][1] + 1 + self.s.number("offset")
            need(offset < 65536)
        self.words[at] = page << 16 | offset
        base = self.s.signed("base") + (self.words[beside[0] + 1] & 0xffff if beside else 0)
        need(0 <= base < 65536)
        s, c = max(0, self.levels - 16), max(0, self.levels - 8)
        least = self.s.signed("least") + (base << s >> c)
        most = least + self.s.signed("range")
        need(0 <= least < 256 and 0 <= most < 256)
        self.words[at + 1] = base | least << 16 | most << 24
        if kind != 5:
            self.met.append((page, offset))
            self.pages[page].append((offset, x, y, map_, base << s))

    def common_pool(self):
        counts = [self.s.number("count") for _ in range(15)]
        need(sum(counts) == self.pattern_count and counts[1] == 0)
        self.words[1] = self.at
        self.common = [[] for _ in range(15)]
        page = Symbols(self.s.coder)
        walk = Walk(page, self.words, 2 * self.at)
        for _ in range(self.pattern_count):
            kind, half = self.s.nibble("pattern_kind"), walk.pool - 2 * self.at
            need(kind < 15 and len(self.common[kind]) < counts[kind] and half < 2**17)
            if kind:
                pattern = Pattern(0, kind)
                pattern.index = walk.pattern_of_depths(list(range(kind)), 0, 0)
            else:
                pattern, _ = walk.new_private(0, 0, None)
            pattern.ref = 2**17 | half
            self.common[kind].append(pattern)
        need((walk.pool + 1) // 2 == len(self.words) and walk.pool - 2 * self.at <= 2**17)
