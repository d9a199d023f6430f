# Images of masks, in the GLB: as the bytes they have, or as a PNG of one channel.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import pathlib
import struct
import zlib
from typing import Any

import bpy
import numpy as np

from .glb import Glb
from .materials import Texture


def png(alpha: np.ndarray) -> bytes:
    """A PNG, white, with this alpha [rows, columns] uint8, the first row on top."""
    rows, columns = alpha.shape
    pixels = np.full((rows, columns, 2), 255, np.uint8)
    pixels[:, :, 1] = alpha
    lines = np.zeros((rows, columns * 2 + 1), np.uint8)  # each line begins with its filter, 0
    lines[:, 1:] = pixels.reshape(rows, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", columns, rows, 8, 4, 0, 0, 0)  # grey and alpha, 8 bits
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines.tobytes(), 1)) + chunk(b"IEND", b"")


def stored_bytes(image: bpy.types.Image) -> bytes:
    """The PNG that an image was read from, where nothing was painted since; b"" for others."""
    if image.source != "FILE" or image.is_dirty or image.alpha_mode == "NONE":
        return b""
    path = pathlib.Path(bpy.path.abspath(image.filepath_raw, library=image.library))
    data = image.packed_file.data if image.packed_file else path.read_bytes() if path.is_file() else b""
    return data if data.startswith(b"\x89PNG") else b""


def channel_bytes(image: bpy.types.Image, channel: str) -> bytes:
    """A PNG whose alpha is a channel of the image; "L": luminance times alpha, as the exporter has it."""
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, 4)[::-1]
    if channel == "L":
        values = pixels[:, :, :3] @ np.array((0.2989, 0.587, 0.114), np.float32)
        if image.alpha_mode in ("STRAIGHT", "PREMUL"):
            values = values * pixels[:, :, 3]
    else:
        values = pixels[:, :, "RGBA".index(channel)]
    return png((np.clip(values, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8))


class Images:
    """Writes each image, sampler and texture once."""

    def __init__(self) -> None:
        self.done: dict[tuple[Any, ...], int] = {}

    def once(self, glb: Glb, kind: str, key: tuple[Any, ...], make: Any) -> int:
        if (kind, *key) not in self.done:
            self.done[kind, *key] = glb.add(kind, make())
        return self.done[kind, *key]

    def texture_info(self, glb: Glb, texture: Texture) -> dict[str, Any]:
        image, channel = texture.image, texture.channel
        source = self.once(glb, "images", (image, channel), lambda: {
            "name": image.name, "mimeType": "image/png",
            "bufferView": glb.view(channel == "A" and stored_bytes(image) or channel_bytes(image, channel))})
        sampler = self.once(glb, "samplers", tuple(sorted(texture.sampler.items())), lambda: texture.sampler)
        value: dict[str, Any] = {"index": self.once(glb, "textures", (source, sampler), lambda: {"source": source, "sampler": sampler})}
        if texture.transform:
            value["extensions"] = {"KHR_texture_transform": texture.transform}
            glb.use("KHR_texture_transform")
        return value
