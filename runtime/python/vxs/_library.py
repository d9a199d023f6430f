"""libvxs by ctypes: its structs, as vxs_file.h, vxs.h and vxs_query.h declare them, and its functions. Internal.

SPDX-License-Identifier: MIT
"""
import ctypes
import ctypes.util
import os
import pathlib
from ctypes import POINTER, c_char, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint32, c_uint64, c_void_p
from typing import Any, Optional

OK = 0
F64, F32 = 0, 1
FINDING = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_int, c_uint64)


class LightRecord(ctypes.Structure):
    _fields_ = [("name", c_char * 64), ("kind", c_uint32), ("flags", c_uint32), ("levels", c_uint32), ("coding", c_uint32),
                ("ls_from_ws", c_double * 12), ("texel_metres", c_double), ("voxel_metres", c_double), ("direction_ws", c_double * 3),
                ("near_metres", c_double), ("cos_outer", c_double), ("range_metres", c_double)]


class Part(ctypes.Structure):
    _fields_ = [("kind", c_char_p), ("side_voxels", c_uint32), ("count", c_uint32), ("memory_bytes", c_uint64), ("section", c_uint32)]


class BakedLight(ctypes.Structure):
    _fields_ = [("light", LightRecord), ("words", POINTER(c_uint32)), ("word_count", c_uint32), ("packing", c_uint32), ("part_count", c_uint32),
                ("parts", Part * 18)]


class Filter(ctypes.Structure):
    _fields_ = [("width_px", c_int32), ("is_smooth", c_int32)]


class Constants(ctypes.Structure):
    _fields_ = [("numbers", c_uint32 * 24)]


class ReadDesc(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("allocator", c_void_p), ("memory_limit_bytes", c_uint64), ("finding", FINDING),
                ("finding_user", c_void_p), ("find_all", c_int), ("metadata", c_int), ("parallel", c_void_p)]


class Vectors(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("stride_bytes", c_size_t), ("type", c_uint32)]


class Batch(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("points_ws", Vectors), ("normals_ws", Vectors), ("count", c_size_t), ("filter", Filter),
                ("lit", c_void_p), ("lit_stride_bytes", c_size_t), ("light_stride_bytes", c_size_t)]


class DepthMapDesc(ctypes.Structure):
    _fields_ = [("struct_size", c_size_t), ("map", c_int32), ("i", c_int32), ("j", c_int32), ("wide_px", c_uint32), ("high_px", c_uint32),
                ("shift", c_uint32), ("which", c_uint32), ("voxels", c_void_p), ("depths", c_void_p), ("row_stride_bytes", c_size_t)]


class Ray(ctypes.Structure):
    _fields_ = [("origin_ws", c_double * 3), ("direction_ws", c_double * 3), ("t_begin", c_double), ("t_end", c_double)]


class Walk(ctypes.Structure):
    _fields_ = [("baked", c_void_p), ("room", c_uint64 * 127)]


FUNCTIONS = {
    "vxs_asset_open": (c_int, [POINTER(c_void_p), c_char_p, c_size_t, POINTER(ReadDesc)]),
    "vxs_asset_open_file": (c_int, [POINTER(c_void_p), c_char_p, POINTER(ReadDesc)]),
    "vxs_asset_close": (None, [c_void_p]),
    "vxs_asset_light_count": (c_uint32, [c_void_p]),
    "vxs_asset_light": (POINTER(BakedLight), [c_void_p, c_uint32]),
    "vxs_lookup_batch": (c_int, [POINTER(BakedLight), c_uint32, POINTER(Batch)]),
    "vxs_depth_map": (c_int, [POINTER(BakedLight), POINTER(DepthMapDesc), POINTER(c_int)]),
    "vxs_lit_begin": (c_int, [POINTER(Walk), POINTER(BakedLight), POINTER(Ray)]),
    "vxs_lit_next": (c_size_t, [POINTER(Walk), c_void_p, c_size_t]),
    "vxs_light_constants_of": (Constants, [POINTER(LightRecord), POINTER(c_double), c_uint32]),
    "vxs_point": (None, [POINTER(LightRecord), c_int, POINTER(c_double), POINTER(c_double)]),
    "vxs_result_text": (c_char_p, [c_int]),
    "vxs_version": (c_uint32, []),
}


def load(name: str, variable: str, functions: dict) -> Any:
    """A shared library: beside this file, where an environment variable says, or where the system finds it.

    Raises ImportError where there is none.
    """
    here = pathlib.Path(__file__).parent
    beside = [str(path) for pattern in (f"lib{name}.so*", f"lib{name}.dylib", f"{name}.dll") for path in sorted(here.glob(pattern))]
    tried = [path for path in (os.environ.get(variable), *beside, ctypes.util.find_library(name), f"lib{name}.so.0") if path]
    library: Optional[ctypes.CDLL] = None
    reason = ""
    for path in tried:
        try:
            library = ctypes.CDLL(path)
            break
        except OSError as error:
            reason = reason or str(error)
    if library is None:
        raise ImportError(f"no lib{name}: install vxs (make install), or let {variable} name the library ({reason})")
    for function, (result, arguments) in functions.items():
        getattr(library, function).restype, getattr(library, function).argtypes = result, arguments
    return library
