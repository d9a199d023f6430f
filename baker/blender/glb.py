# A binary glTF 2.0 file: arrays become buffer views and accessors, dictionaries become JSON.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

FLOAT, UNSIGNED_INT = 5126, 5125
COMPONENTS = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


class Glb:
    """Collects what a file holds; write() writes it. The same calls give the same bytes."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}}
        self.parts: list[bytes | np.ndarray] = []
        self.size = 0

    def add(self, kind: str, value: dict[str, Any], extension: str = "") -> int:
        """Append to an array, as "meshes", of the JSON, or of an extension in it. Returns the index."""
        if extension:
            self.use(extension)
        holder = self.json.setdefault("extensions", {}).setdefault(extension, {}) if extension else self.json
        items = holder.setdefault(kind, [])
        items.append(value)
        return len(items) - 1

    def use(self, extension: str) -> None:
        used = self.json.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def view(self, data: bytes | np.ndarray) -> int:
        """Store bytes. Returns the buffer view; it begins at a multiple of 4."""
        size = data.nbytes if isinstance(data, np.ndarray) else len(data)
        index = self.add("bufferViews", {"buffer": 0, "byteOffset": self.size, "byteLength": size})
        self.parts += [data, bytes(-size % 4)]
        self.size += size + -size % 4
        return index

    def accessor(self, array: np.ndarray) -> int:
        """Store an array [count] or [count, components] of float32 or uint32. Returns the accessor."""
        array = np.ascontiguousarray(array)
        value = {"bufferView": self.view(array), "count": len(array), "componentType": FLOAT if array.dtype == np.float32 else UNSIGNED_INT,
                 "type": COMPONENTS[array.shape[1] if array.ndim > 1 else 1]}
        if array.ndim > 1 and array.shape[1] == 3:
            value["min"], value["max"] = array.min(0).tolist(), array.max(0).tolist()
        return self.add("accessors", value)

    def write(self, path: str) -> None:
        if self.size:
            self.json["buffers"] = [{"byteLength": self.size}]
        text = json.dumps(self.json, separators=(",", ":"), ensure_ascii=False).encode("utf-8", "replace")
        text += b" " * (-len(text) % 4)
        chunks = 12 + 8 + len(text) + (8 + self.size if self.size else 0)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sIIII", b"glTF", 2, chunks, len(text), 0x4E4F534A) + text)
            if self.size:
                file.write(struct.pack("<II", self.size, 0x004E4942))
                for part in self.parts:
                    file.write(part)
