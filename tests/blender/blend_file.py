# What a .blend file holds, without what a window shows: to see whether something changed the user's data.
# SPDX-License-Identifier: GPL-3.0-or-later
import struct


def blocks(data):
    """Code and bytes of each block. Blender 5 has a longer header, and 64-bit lengths."""
    assert data[:7] == b"BLENDER"
    at, new = (17, True) if data[7:9] == b"17" else (12, False)
    while at < len(data):
        if new:
            code, _, _, size, _ = struct.unpack_from("<4siQqq", data, at)
        else:
            code, size, _, _, _ = struct.unpack_from("<4siQii", data, at)
        at += 32 if new else 24
        yield code, data[at:at + size]
        at += size


def contents(path):
    """The bytes of all blocks but those of the window manager, which holds the state of bakes, and of the file's own head."""
    kept, is_kept = [], True
    for code, payload in blocks(path.read_bytes()):
        if code != b"DATA":
            is_kept = code not in (b"WM\0\0", b"GLOB")
        if is_kept:
            kept.append(code + payload)
    return b"".join(kept)
