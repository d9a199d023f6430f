# Baked shadows for Blender: bakes the shadows of a scene with the command vxs, shows and exports them.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import sys

for name in [name for name in sys.modules if name.startswith(__name__ + ".")]:  # an update: Blender loads this file alone again
    sys.modules.pop(name)
    globals().pop(name.rpartition(".")[2], None)

import bpy  # noqa: E402

from . import bake, check, messages, panels, picture, preview, settings  # noqa: E402
from .gltf_export import glTF2ExportUserExtension  # noqa: E402, F401  Blender's exporter looks for it here

bl_info = {
    "name": "vxs baked shadows",
    "author": "the vxs maintainers",
    "version": (0, 2, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Render > Baked Shadows",
    "description": "Bakes the shadows of static geometry into small files for games",
    "category": "Render",
}

CLASSES = tuple(cls for module in (settings, messages, bake, panels, preview, picture, check) for cls in module.CLASSES)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    settings.register()


def unregister() -> None:
    settings.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
