"""Baked shadows in numpy: open a .vxs file, look up how lit points are, read depth maps and lit parts of rays; vxs.bake() makes files.

    import vxs
    with vxs.open("level.vxs") as level:
        lit = level["sun"].lookup(points, normals, vxs.smooth(9))

World space is that of the scene file: metres, +Y up in glTF. Functions take arrays whose last axis is x, y, z, of float32 or float64, and
return arrays of the other axes. Contracts are those of the C library (runtime/vxs.h, runtime/vxs_query.h). An open level is read-only:
any number of threads may look it up at once, and lookups release the interpreter's lock.

SPDX-License-Identifier: MIT
"""
import ctypes
import math
import os
from typing import Any, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _library as c
from .baker import Scene, bake
from .errors import Cancelled, VxsError

__all__ = ["open", "box", "smooth", "bake", "Level", "Light", "Scene", "Filter", "VxsError", "Cancelled", "OUTSIDE", "INTERVAL", "version"]

OUTSIDE = -1.0
"""Result of a lookup at a point outside of the light's volume."""
INTERVAL = np.dtype([("t_begin", "f8"), ("t_end", "f8"), ("state", "i4"), ("coarse", "i4")])
"""An interval of a ray: state is 0 lit, 1 in shadow, 2 outside."""

Filter = c.Filter
_C = c.load("vxs", "VXS_LIBRARY", c.FUNCTIONS)
_KINDS = {1: "directional", 2: "spot", 3: "point"}


def box(width_px: int = 1) -> Filter:
    """A box of K x K whole texels, K odd, 1 to 17."""
    return Filter(width_px, 0)


def smooth(width_px: int) -> Filter:
    """A smooth filter of K x K texels, K 1 to 17: its edges do not move in steps of a texel."""
    return Filter(width_px, 1)


def version() -> str:
    """Version of the C library, as 0.1.0."""
    number = _C.vxs_version()
    return f"{number // 10000}.{number // 100 % 100}.{number % 100}"


def _points(values: Any, count: Optional[Tuple[int, ...]] = None) -> np.ndarray:
    """An array of shape (..., 3), contiguous, of float32 or float64. ValueError: another shape, or not that of `count`."""
    array = np.asarray(values)
    array = np.ascontiguousarray(array, np.float32 if array.dtype == np.float32 else np.float64)
    if array.ndim == 0 or array.shape[-1] != 3 or (count is not None and array.shape[:-1] != count):
        raise ValueError(f"expected an array of shape {(*count, 3) if count is not None else '(..., 3)'}, and it is {array.shape}")
    return array


def _vectors(array: Optional[np.ndarray]) -> c.Vectors:
    if array is None:
        return c.Vectors()
    return c.Vectors(array.ctypes.data, 0, c.F32 if array.dtype == np.float32 else c.F64)


class Light:
    """A light of an open level."""

    def __init__(self, level: "Level", index: int):
        self._level, self._index = level, index

    @property
    def _baked(self) -> Any:
        return self._level._light(self._index)

    @property
    def _record(self) -> c.LightRecord:
        return self._baked.contents.light

    @property
    def name(self) -> str:
        return self._record.name.decode("utf-8", "replace")

    @property
    def kind(self) -> str:
        """directional, spot or point"""
        return _KINDS[self._record.kind]

    @property
    def direction(self) -> np.ndarray:
        """Unit vector, the way the light travels."""
        return np.array(self._record.direction_ws)

    @property
    def resolution(self) -> int:
        """Texels a side of a map, and voxels in depth."""
        return 1 << self._record.levels

    @property
    def map_count(self) -> int:
        """1, or 6 for the faces of a cube."""
        return 6 if self._record.flags & 2 else 1

    @property
    def texel_metres(self) -> float:
        """Side of a texel; spot and point: one metre from the light."""
        return self._record.texel_metres

    @property
    def matrix(self) -> np.ndarray:
        """[3, 4] from world metres to texels u, v and voxels of depth; spot and point: to metres about the light."""
        return np.array(self._record.ls_from_ws).reshape(3, 4)

    @property
    def words(self) -> np.ndarray:
        """A copy of the words that shaders read, uint32, and four zeros."""
        baked = self._baked.contents
        return np.append(np.ctypeslib.as_array(baked.words, (baked.word_count,)), np.zeros(4, np.uint32)).astype(np.uint32)

    def constants(self, origin: Sequence[float] = (0, 0, 0), first_word: int = 0) -> bytes:
        """96 bytes for shaders (vxs_light_constants), for positions relative to an origin."""
        return bytes(_C.vxs_light_constants_of(ctypes.byref(self._record), (ctypes.c_double * 3)(*origin), first_word))

    def lookup(self, points: Any, normals: Any = None, filter: Filter = box(1)) -> np.ndarray:
        """Share of the light that reaches each point, 0 to 1, float32; OUTSIDE (-1) outside of the light's volume.

        normals  of the surfaces at the points, of any length: the surface does not shade itself. None: points in the air
        """
        return self._level._lookup(self._baked, 1, points, normals, filter)[0]

    def depth_map(self, resolution: int = 0, map: int = 0, voxels: bool = False) -> np.ndarray:
        """Where shadow begins in each texel, [resolution, resolution], row v, column u: float32 of 0 near to 1, nowhere; or voxels, uint32.

        resolution  a power of two up to the light's; 0: the light's
        """
        side = resolution or self.resolution
        if not 1 <= side <= self.resolution or side & (side - 1) or not 0 <= map < self.map_count:
            raise ValueError(f"resolution {side}, map {map}: expected a power of two up to {self.resolution}, and a map below {self.map_count}")
        out = np.empty((side, side), np.uint32 if voxels else np.float32)
        shift = self._record.levels - (side.bit_length() - 1)
        desc = c.DepthMapDesc(struct_size=ctypes.sizeof(c.DepthMapDesc), map=map, wide_px=side, high_px=side, shift=shift)
        setattr(desc, "voxels" if voxels else "depths", out.ctypes.data)
        _check(_C.vxs_depth_map(self._baked, ctypes.byref(desc), None), "depth map")
        return out

    def point(self, coordinates: Any, map: int = 0) -> np.ndarray:
        """World-space points of light-space coordinates (..., 3): texels u, v and depth in voxels, fractional."""
        places = _points(np.asarray(coordinates, np.float64))
        out = np.empty_like(places)
        step, at, to = places.itemsize * 3, places.ctypes.data, out.ctypes.data
        record, pointer = ctypes.byref(self._record), ctypes.POINTER(ctypes.c_double)
        for n in range(places.size // 3):
            _C.vxs_point(record, map, ctypes.cast(at + n * step, pointer), ctypes.cast(to + n * step, pointer))
        return out

    def lit_intervals(self, origin: Sequence[float], direction: Sequence[float], t_begin: float = 0, t_end: float = math.inf) -> np.ndarray:
        """Parts of the ray origin + t * direction that are lit, in shadow or outside, in order and without gaps: an array of INTERVAL."""
        ray, walk = c.Ray((ctypes.c_double * 3)(*origin), (ctypes.c_double * 3)(*direction), t_begin, t_end), c.Walk()
        _check(_C.vxs_lit_begin(ctypes.byref(walk), self._baked, ctypes.byref(ray)), "ray")
        found: List[np.ndarray] = []
        while True:
            some = np.empty(64, INTERVAL)
            count = _C.vxs_lit_next(ctypes.byref(walk), some.ctypes.data, len(some))
            found.append(some[:count])
            if count < len(some):
                return np.concatenate(found)

    def __repr__(self) -> str:
        return f"<vxs.Light {self.name!r}: {self.kind}, {self.resolution} x {self.resolution} texels>"


class Level:
    """An open .vxs file: a sequence of lights, which may also be had by name. Close it, or use it in a with statement."""

    def __init__(self, asset: int):
        self._asset: Optional[int] = asset

    def _open(self) -> int:
        if self._asset is None:
            raise ValueError("the level is closed")
        return self._asset

    def _light(self, index: int) -> Any:
        return _C.vxs_asset_light(self._open(), index)

    def _lookup(self, first: Any, light_count: int, points: Any, normals: Any, filter: Filter) -> np.ndarray:
        at = _points(points)
        facing = None if normals is None else _points(normals, at.shape[:-1])
        lit = np.empty((light_count, *at.shape[:-1]), np.float32)
        batch = c.Batch(ctypes.sizeof(c.Batch), _vectors(at), _vectors(facing), at.size // 3, filter, lit.ctypes.data, 0, 0)
        if at.size:
            _check(_C.vxs_lookup_batch(first, light_count, ctypes.byref(batch)), "lookup")
        return lit

    def lookup(self, points: Any, normals: Any = None, filter: Filter = box(1)) -> np.ndarray:
        """Light.lookup for all lights at once: the first axis is the light's."""
        return self._lookup(self._light(0), len(self), points, normals, filter)

    def __len__(self) -> int:
        return _C.vxs_asset_light_count(self._open())

    def __iter__(self) -> Iterator[Light]:
        return (Light(self, n) for n in range(len(self)))

    def __getitem__(self, key: Union[int, str]) -> Light:
        if isinstance(key, str):
            for light in self:
                if light.name == key:
                    return light
            raise KeyError(f"no light {key!r}: there are {[light.name for light in self]}")
        if not -len(self) <= key < len(self):
            raise IndexError(f"no light {key}: there are {len(self)}")
        return Light(self, key % len(self))

    def close(self) -> None:
        """Free its memory. May be called again. Arrays that were returned stay; other uses of the level raise ValueError."""
        if self._asset is not None:
            _C.vxs_asset_close(self._asset)
        self._asset = None

    def __enter__(self) -> "Level":
        return self

    def __exit__(self, *about: Any) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()


def _check(result: int, what: str) -> None:
    if result != c.OK:
        raise ValueError(f"{what}: {_C.vxs_result_text(result).decode()}")


def open(source: Union[str, "os.PathLike[str]", bytes, bytearray, memoryview], memory_limit_bytes: int = 0) -> Level:
    """Open a .vxs file, by path or as bytes, and check every byte of it.

    memory_limit_bytes  0: 256 times the file's size, 64 MiB at least
    Raises VxsError with the first finding; FileNotFoundError.
    """
    findings: List[Tuple[int, str, int, int]] = []
    collect = c.FINDING(lambda user, number, text, section, offset: findings.append((number, text.decode(), section, offset)))
    desc = c.ReadDesc(struct_size=ctypes.sizeof(c.ReadDesc), memory_limit_bytes=memory_limit_bytes, finding=collect)
    asset = ctypes.c_void_p()
    if isinstance(source, (bytes, bytearray, memoryview)):
        name, data = "the bytes", bytes(source)
        result = _C.vxs_asset_open(ctypes.byref(asset), data, len(data), ctypes.byref(desc))
    else:
        name = os.fspath(source)
        if not os.path.exists(name):
            raise FileNotFoundError(f"no file {name}")
        result = _C.vxs_asset_open_file(ctypes.byref(asset), os.fsencode(name), ctypes.byref(desc))
    if result != c.OK or asset.value is None:
        text = _C.vxs_result_text(result).decode()
        if findings:
            number, why, section, offset = findings[0]
            raise VxsError(f"{name}: {text}: finding {number} at byte {offset}: {why}", result, number)
        raise VxsError(f"{name}: {text}", result)
    return Level(asset.value)
