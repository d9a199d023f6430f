# The command vxs: where it is, its arguments for a bake, and a run of it.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
from itertools import product
from typing import Any, Iterator, Sequence

import bpy
import numpy as np
from mathutils import Vector

from .settings import own


class Failed(Exception):
    """The text is one sentence for the user."""


def preferences(context: bpy.types.Context) -> Any:
    return context.preferences.addons[__package__].preferences


def find_vxs(context: bpy.types.Context) -> str:
    """Path of vxs: the one in the preferences, or on the PATH."""
    asked = bpy.path.abspath(preferences(context).vxs)
    found = shutil.which(asked or "vxs")
    if found:
        return found
    if asked:
        raise Failed(f"{asked} is not a program. Set the path of vxs in the add-on's preferences")
    raise Failed("The command vxs was not found: build it with make and run make install, or set its path in the add-on's preferences")


def start(vxs: str, arguments: Sequence[str], **streams: Any) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen([vxs, *arguments], **streams)
    except OSError as error:
        raise Failed(f"{vxs} does not start: {error.strerror}") from error


def why(status: int, said: bytes) -> str:
    """Why vxs failed, in its own words where it has some."""
    errors = [line[len("vxs: error: "):] for line in said.decode("utf-8", "replace").splitlines() if line.startswith("vxs: error: ")]
    if errors:
        return errors[-1]
    return f"vxs was ended by signal {-status}" if status < 0 else f"vxs failed with status {status}"


def answer(vxs: str, *arguments: str, stdin: bytes = b"") -> bytes:
    """Run vxs to its end. Returns what it prints."""
    process = start(vxs, arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    printed, said = process.communicate(stdin)
    if process.returncode:
        raise Failed(why(process.returncode, said))
    return printed


def to_gltf(vectors: np.ndarray) -> np.ndarray:
    """Of vectors [count, 3]: in the axes of glTF."""
    return vectors[:, [0, 2, 1]] * (1.0, 1.0, -1.0)


def region_argument(box: bpy.types.Object) -> str:
    """--region for the bounding box of an object, of an empty as it is drawn."""
    corners = map(Vector, box.bound_box)
    if box.type == "EMPTY":
        corners = (Vector(corner) * box.empty_display_size for corner in product((-1, 1), repeat=3))
    points = to_gltf(np.array([box.matrix_world @ corner for corner in corners]))
    return ",".join(f"{v:.9g}" for v in (*points.min(0), *points.max(0)))


def detail_arguments(settings: Any, prefix: str = "") -> list[str]:
    if settings.detail == "TEXEL":
        return ["--texel", f"{prefix}{settings.texel:.7g}"]
    return ["--resolution", f"{prefix}{settings.resolution}"]


def bake_arguments(context: bpy.types.Context, settings: Any, lights: dict[str, bpy.types.Light], level: str, output: str,
                   report: str) -> list[str]:
    """settings: as Scene.vxs; lights: by the names that the level's file gives them."""
    arguments = [level, "-o", output, "--json", report, "--progress", "json", *detail_arguments(settings),
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
    if chosen.threads:
        arguments += ["--threads", str(chosen.threads)]
    if chosen.memory:
        arguments += ["--memory", f"{chosen.memory}M"]
    return arguments


def read_progress(line: bytes) -> dict[str, Any]:
    """Of a line that vxs prints: share, seconds_left, doing, where they are known."""
    kinds = {"share": (int, float), "seconds_left": (int, float), "doing": str}
    try:
        return {key: value for key, value in json.loads(line).items() if isinstance(value, kinds.get(key, ()))}
    except (ValueError, AttributeError):
        return {}


def run(vxs: str, arguments: Sequence[str], log: str) -> Iterator[dict[str, Any]]:
    """Run vxs beside Blender, and yield its newest progress. Closed before its end, it stops vxs. log: a file for what vxs prints."""
    with open(log, "wb") as out, open(log, "rb") as said:
        process = start(vxs, arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=out)
        try:
            while process.poll() is None:
                yield next((known for known in map(read_progress, reversed(said.readlines())) if known), {})
        finally:
            stop(process)
        said.seek(0)
        if process.returncode:
            raise Failed(why(process.returncode, said.read()))


def stop(process: subprocess.Popen[bytes]) -> None:
    """vxs takes its unfinished file away; one that does not stop within 5 seconds is killed."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM if os.name == "nt" else signal.SIGINT)
        try:
            process.wait(5)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
