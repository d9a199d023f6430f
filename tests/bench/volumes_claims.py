# What is reported of a scene of `make bench-volumes` beside its cells: whether error falls along each knob, and ratios that papers
# give, too.
# SPDX-License-Identifier: GPL-3.0-or-later

import math

NOISE = 1.1  # times an error before which a greater one does not count


def drawn(scene):
    return [c for c in scene["cells"] if not c["refused"]]


def rises(scene):
    """Settings whose error is greater than that of the one before, by more than noise: [(technique, value, how many times)]."""
    cells = drawn(scene)
    return [(a["technique"], b["value"], b["error"]["relative_rms"] / a["error"]["relative_rms"]) for a, b in zip(cells, cells[1:])
            if a["technique"] == b["technique"] and b["error"]["relative_rms"] > NOISE * a["error"]["relative_rms"]]


def monotone_text(scene):
    found = rises(scene)
    listed = ", ".join(f"{name}, {value}: {times:.2f} times" for name, value, times in found)
    return f"Error rises along a knob: {listed}" if found else "Along every knob error falls, or rises by less than a tenth."


def slopes(scene, most=64):
    """Of area lights: to which power of how many VPLs each technique's error falls, up to so many, by least squares: {technique: power}."""
    found = {}
    for name in dict.fromkeys(c["technique"] for c in drawn(scene) if c["knob"] == "vpls"):
        at = [(math.log(c["value"]), math.log(c["error"]["relative_rms"])) for c in drawn(scene) if c["technique"] == name and c["value"] <= most]
        x, y = (sum(p[n] for p in at) / len(at) for n in (0, 1))
        across = sum((a - x) ** 2 for a, _ in at)
        if across:
            found[name] = sum((a - x) * (b - y) for a, b in at) / across
    return found


def claims(scene):
    """Ratios of what was measured and of the paper's table, [{what, value, paper}]. Smoke: [AVSM10] table 1; area lights: [IVSV13] table 1."""
    cells = {(c["technique"], c["value"]): c for c in drawn(scene)}
    part = lambda name: lambda c: next(p["ms"] for p in c["parts"] if p["name"] == name)
    frame, creation = lambda c: c["ms"]["median"], lambda c: c["creation_ms"]
    rows = [("building deep shadow maps over 8 nodes", part("build"), ("deep", 100), ("adaptive", 8), 276),
            ("looking up deep shadow maps over 8 nodes", part("look up"), ("deep", 100), ("adaptive", 8), 10),
            ("looking up uncompressed segments over 8 nodes", part("look up"), ("uncompressed", 1), ("adaptive", 8), 51),
            ("creating shadow volumes of 256 VPLs, one after the other over together", creation, ("imperfect, one by one", 256), ("imperfect", 256), 20),
            ("a frame of 256 VPLs, one after the other over together", frame, ("imperfect, one by one", 256), ("imperfect", 256), 5.6)]
    return [{"what": what, "value": float(f"{of(cells[a]) / of(cells[b]):.4g}"), "paper": paper} for what, of, a, b, paper in rows
            if a in cells and b in cells and of(cells[b])]
