"""Baking from arrays of triangles, by libvxs_bake, which is under the GPL, version 3 or later, and is loaded by the first bake alone.

SPDX-License-Identifier: MIT
"""
import ctypes
import functools
import os
from ctypes import POINTER, c_char_p, c_double, c_int, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _library
from .errors import Cancelled, VxsError


class _Mesh(ctypes.Structure):
    _fields_ = [("positions", c_void_p), ("indices", c_void_p), ("vertex_count", c_uint32), ("triangle_count", c_uint32),
                ("origin_ws", c_double * 3), ("double_sided", c_int)]


class _BakeLight(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("kind", c_int), ("position_ws", c_double * 3), ("direction_ws", c_double * 3), ("cos_outer", c_double),
                ("range_metres", c_double)]


class _Arrays(ctypes.Structure):
    _fields_ = [("meshes", POINTER(_Mesh)), ("mesh_count", c_size_t), ("lights", POINTER(_BakeLight)), ("light_count", c_size_t),
                ("viewpoints_ws", c_void_p), ("viewpoint_count", c_size_t)]


class _Sun(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("direction_ws", c_double * 3)]


class _Progress(ctypes.Structure):
    _fields_ = [("share", c_double), ("seconds_left", c_double), ("doing", c_char_p)]


class _Bytes(ctypes.Structure):
    _fields_ = [("data", POINTER(c_uint8)), ("size_bytes", c_size_t)]


_PROGRESS = ctypes.CFUNCTYPE(c_int, c_void_p, POINTER(_Progress))
_LOG = ctypes.CFUNCTYPE(None, c_int, c_char_p, c_void_p)


class _Options(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("scene_path", c_char_p), ("arrays", POINTER(_Arrays)), ("scene", c_void_p),
                ("exclude", c_void_p), ("include", c_void_p), ("exclude_count", c_size_t), ("include_count", c_size_t),
                ("scene_name", c_char_p), ("closed", c_int), ("skinned", c_int), ("light_names", c_void_p), ("light_name_count", c_size_t),
                ("suns", POINTER(_Sun)), ("sun_count", c_size_t), ("resolution", c_uint32), ("texel_metres", c_double),
                ("map_sizes", c_void_p), ("map_size_count", c_size_t), ("has_region", c_int), ("region_ws", c_double * 6),
                ("exit", c_int), ("behind_free", c_int), ("thickness_metres", c_double), ("coding", c_int), ("pack", c_int),
                ("zstd_level", c_uint32), ("output_path", c_char_p), ("replace", c_int), ("resume_path", c_char_p), ("if_changed", c_int),
                ("threads", c_uint32), ("memory_bytes", c_uint64), ("progress", _PROGRESS), ("log", _LOG), ("user", c_void_p),
                ("blend", c_int), ("allow_outside", c_int), ("files", c_void_p)]


_FUNCTIONS = {
    "vxs_bake": (c_int, [POINTER(_Options), POINTER(_Bytes)]),
    "vxs_bake_bytes_free": (None, [POINTER(_Bytes)]),
    "vxs_bake_scene_open": (c_int, [POINTER(c_void_p), POINTER(_Options)]),
    "vxs_bake_scene_close": (None, [c_void_p]),
}
_INTERRUPTED = 5
_CLOSED = {"auto": 0, "on": 1, "off": 2}
_PACK = {"small": 0, "fast": 1}
Mesh = Union[Any, Tuple[Any, Any]]


@functools.lru_cache(maxsize=None)
def _baker() -> Any:
    return _library.load("vxs_bake", "VXS_BAKE_LIBRARY", _FUNCTIONS)


def _mesh(mesh: Mesh, held: List[Any]) -> _Mesh:
    """A mesh for C. Its arrays are appended to `held`: float32 positions about their middle, which is kept in double."""
    positions, indices = mesh if isinstance(mesh, tuple) else (mesh, None)
    places = np.asarray(positions, np.float64).reshape(-1, 3)
    if not len(places) or not np.isfinite(places).all():
        raise ValueError("a mesh needs finite positions, of shape (n, 3)")
    middle = (places.min(0) + places.max(0)) / 2
    local = np.ascontiguousarray(places - middle, np.float32)
    held.append(local)
    triangles = None
    if indices is not None:
        corners = np.asarray(indices)
        if corners.size % 3 or corners.size and not 0 <= corners.min() <= corners.max() < len(places):
            raise ValueError(f"indices must be triples from 0 to {len(places) - 1}")
        triangles = np.ascontiguousarray(corners, np.uint32)
        held.append(triangles)
    elif len(places) % 3:
        raise ValueError("without indices, three positions make a triangle")
    count = (triangles.size if triangles is not None else len(places)) // 3
    return _Mesh(local.ctypes.data, triangles.ctypes.data if triangles is not None else None, len(places), count, (c_double * 3)(*middle))


def _call(function: Callable, errors: List[str], *arguments: Any) -> None:
    result = function(*arguments)
    if result != _library.OK:
        raise (Cancelled if result == _INTERRUPTED else VxsError)(errors[-1] if errors else f"the bake failed with result {result}", result)


def _log(errors: List[str], warnings: List[str]) -> Any:
    return _LOG(lambda severity, text, user: (errors if severity else warnings).append(text.decode("utf-8", "replace")))


class Scene:
    """Triangles that serve many bakes: casters and solids are found once.

    meshes  positions (n, 3) with three corners a triangle, or (positions, indices), or a list of these; or the path of a .gltf or .glb.
            Metres, +Y up; counter-clockwise as seen from outside
    closed  which closed components are solids: auto, on, off (vxs bake --closed)
    warnings  what vxs says about the scene
    Raises VxsError, ValueError. Close it, or use it in a with statement.
    """

    def __init__(self, meshes: Union[str, "os.PathLike[str]", Mesh, Sequence[Mesh]], closed: str = "auto", threads: int = 0):
        self.warnings: List[str] = []
        self._scene: Optional[int] = None
        errors: List[str] = []
        held: List[Any] = []
        log = _log(errors, self.warnings)
        options = _Options(struct_size=ctypes.sizeof(_Options), closed=_CLOSED[closed], threads=threads, log=log)
        if isinstance(meshes, (str, os.PathLike)):
            options.scene_path = os.fsencode(meshes)
        else:
            several = meshes if isinstance(meshes, list) else [meshes]
            table = (_Mesh * len(several))(*(_mesh(mesh, held) for mesh in several))
            arrays = _Arrays(table, len(several))
            options.arrays = ctypes.pointer(arrays)
        scene = c_void_p()
        _call(_baker().vxs_bake_scene_open, errors, ctypes.byref(scene), ctypes.byref(options))
        self._scene = scene.value

    def bake(self, suns: Optional[Mapping[str, Sequence[float]]] = None, *, resolution: int = 0, texel_metres: float = 0,
             region: Optional[Sequence[float]] = None, pack: str = "small", output: Optional[str] = None, threads: int = 0,
             memory_bytes: int = 0, progress: Optional[Callable[[float, str], Any]] = None) -> bytes:
        """Bake the scene's lights, or suns, and return the bytes of a .vxs file, for vxs.open().

        suns        by name, the way their light travels
        resolution  texels a side of a map, a power of two, 8 to 262144; 0: 4096, or from texel_metres
        region      min x, y, z and max x, y, z of what will be looked up, metres; None: all casters
        output      also write this file, complete or not at all
        progress    called with the done share, below 0 where unknown, and what is done; what it returns cancels the bake where it is true
        Raises VxsError; Cancelled.
        """
        if self._scene is None:
            raise ValueError("the scene is closed")
        errors: List[str] = []
        named = [_Sun(name.encode(), (c_double * 3)(*direction)) for name, direction in (suns or {}).items()]
        table, log = (_Sun * len(named))(*named), _log(errors, self.warnings)
        report = _PROGRESS((lambda user, now: bool(progress(now.contents.share, now.contents.doing.decode("utf-8", "replace")))) if progress else 0)
        options = _Options(struct_size=ctypes.sizeof(_Options), scene=self._scene, suns=table, sun_count=len(named), resolution=resolution,
                           texel_metres=texel_metres, pack=_PACK[pack], threads=threads, memory_bytes=memory_bytes, log=log, progress=report)
        if region is not None:
            options.has_region, options.region_ws = 1, (c_double * 6)(*region)
        if output is not None:
            options.output_path = os.fsencode(output)
        file = _Bytes()
        _call(_baker().vxs_bake, errors, ctypes.byref(options), ctypes.byref(file))
        try:
            return ctypes.string_at(file.data, file.size_bytes)
        finally:
            _baker().vxs_bake_bytes_free(ctypes.byref(file))

    def close(self) -> None:
        """Free its memory. May be called again."""
        if self._scene is not None:
            _baker().vxs_bake_scene_close(self._scene)
        self._scene = None

    def __enter__(self) -> "Scene":
        return self

    def __exit__(self, *about: Any) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()


def bake(meshes: Union[str, "os.PathLike[str]", Mesh, Sequence[Mesh]], suns: Optional[Mapping[str, Sequence[float]]] = None, *,
         closed: str = "auto", **options: Any) -> bytes:
    """Bake once: Scene(meshes, closed).bake(suns, **options)."""
    with Scene(meshes, closed) as scene:
        return scene.bake(suns, **options)
