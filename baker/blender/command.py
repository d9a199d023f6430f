# The command vxs: where it is, its arguments for a bake, and a run of it.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import json
import os
import queue
import shutil
import signal
import subprocess
import threading
import time
from itertools import product
from typing import Any, Sequence

import bpy
from mathutils import Vector

from .settings import own


class VxsMissing(Exception):
    """The command vxs is not there; the text says how to get it."""


def preferences(context: bpy.types.Context) -> Any:
    """The add-on's preferences; None where it was registered without being enabled."""
    addon = context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


def find_vxs(context: bpy.types.Context) -> str:
    """Path of vxs: the one in the preferences, or on the PATH."""
    asked = bpy.path.abspath(getattr(preferences(context), "vxs", ""))
    found = shutil.which(asked or "vxs")
    if found:
        return found
    if asked:
        raise VxsMissing(f"{asked} is not a program. Set the path of vxs in the add-on's preferences")
    raise VxsMissing("The command vxs was not found: build it with make and run make install, or set its path in the add-on's preferences")


def run_vxs(vxs: str, arguments: Sequence[str], stdin: bytes = b"") -> subprocess.CompletedProcess[bytes]:
    """Run vxs to its end. Raises VxsMissing when it does not start."""
    try:
        return subprocess.run([vxs, *arguments], input=stdin, capture_output=True, check=False)
    except OSError as error:
        raise VxsMissing(f"{vxs} does not start: {error.strerror}") from error


def to_gltf(point: Sequence[float]) -> tuple[float, float, float]:
    return point[0], point[2], -point[1]


def region_argument(box: bpy.types.Object) -> str:
    """--region for the bounding box of an object, of an empty as it is drawn."""
    corners = map(Vector, box.bound_box)
    if box.type == "EMPTY":
        corners = (Vector(corner) * box.empty_display_size for corner in product((-1, 1), repeat=3))
    points = [to_gltf(box.matrix_world @ corner) for corner in corners]
    return ",".join(f"{bound(axis):.9g}" for bound in (min, max) for axis in zip(*points))


def detail_arguments(settings: Any, prefix: str = "") -> list[str]:
    if settings.detail == "TEXEL":
        return ["--texel", f"{prefix}{settings.texel:.7g}"]
    return ["--resolution", f"{prefix}{settings.resolution}"]


def bake_arguments(context: bpy.types.Context, settings: Any, lights: dict[str, bpy.types.Light], level: str, output: str,
                   report: str) -> list[str]:
    """settings: as Scene.vxs; lights: by the names that the level's file gives them."""
    arguments = ["bake", level, "-o", output, "--json", report, "--progress", "json", *detail_arguments(settings),
                 "--closed", settings.closed, "--pack", settings.pack]
    if settings.blend != "auto":
        arguments += ["--blend", settings.blend]
    for name, light in lights.items():
        if own(light).detail != "SCENE":
            arguments += detail_arguments(light.vxs, name + "=")
    if settings.region:
        arguments += ["--region", region_argument(settings.region)]
    if settings.if_changed:
        arguments.append("--if-changed")
    chosen = preferences(context)
    if chosen and chosen.threads:
        arguments += ["--threads", str(chosen.threads)]
    if chosen and chosen.memory:
        arguments += ["--memory", f"{chosen.memory}M"]
    return arguments


def read_progress(line: str) -> dict[str, Any]:
    kinds = {"share": (int, float), "seconds_left": (int, float), "doing": str}
    try:
        return {key: value for key, value in json.loads(line).items() if isinstance(value, kinds.get(key, ()))}
    except ValueError:
        return {}


class Run:
    """vxs at work beside Blender. A thread reads what it prints; poll() and finish() are for the main thread."""

    def __init__(self, vxs: str, arguments: Sequence[str]) -> None:
        try:
            self.process = subprocess.Popen([vxs, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        except OSError as error:
            raise VxsMissing(f"{vxs} does not start: {error.strerror}") from error
        self.lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.errors: list[str] = []
        self.kill_at = 0.0  # when a cancelled vxs has had its time
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self) -> None:
        for line in self.process.stderr:
            self.lines.put(line.decode("utf-8", "replace").rstrip("\n"))

    def poll(self) -> tuple[int | None, dict[str, Any]]:
        """The exit status, None while vxs runs; and the newest progress: share, seconds_left, doing, where they are known."""
        status = self.process.poll()
        if status is not None:
            self.reader.join()
        progress: dict[str, Any] = {}
        while not self.lines.empty():
            line = self.lines.get()
            if line.startswith("{"):
                progress = read_progress(line) or progress
            elif line.startswith("vxs: error: "):
                self.errors.append(line[len("vxs: error: "):])
        return status, progress

    def cancel(self) -> None:
        """Ask vxs to stop; it takes its unfinished file away. Called again, it kills a vxs that did not stop within 5 seconds."""
        if self.process.poll() is not None:
            return
        if not self.kill_at:
            self.kill_at = time.monotonic() + 5
            self.process.send_signal(signal.SIGTERM if os.name == "nt" else signal.SIGINT)
        elif time.monotonic() > self.kill_at:
            self.process.kill()

    def finish(self) -> None:
        """Wait for the end; a vxs that does not stop within 5 seconds is killed."""
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.reader.join()
        self.process.stderr.close()
