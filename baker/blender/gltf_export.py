# The glTF exporter writes the baked shadows beside its file, and names them in it.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import os
from typing import Any
from urllib.parse import quote

import bpy

from . import overlay

EXTENSION, EXTRA = "VXS_baked_shadows", "vxs_shadows"


class glTF2ExportUserExtension:
    """Hooks of Blender's glTF exporter, which looks for this name and makes one for each export."""

    def __init__(self) -> None:
        self.uri = ""

    def gather_asset_hook(self, _asset: Any, export_settings: dict[str, Any]) -> None:
        """Bakes. This hook is the first one: later ones see the scene at the last frame of its animations."""
        if not bpy.context.scene.vxs.export:
            return
        path = os.path.splitext(export_settings["gltf_filepath"])[0] + ".vxs"
        try:
            refuse_other_places(export_settings)
            os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
            bpy.ops.vxs.bake("EXEC_DEFAULT", filepath=path)
        except Exception as error:  # an export never fails because of its shadows
            tell(export_settings, f"Exported without baked shadows: {str(error).removeprefix('Error: ').strip()}")
            return
        self.uri = quote(os.path.basename(path))
        if not export_settings["gltf_lights"]:
            tell(export_settings, "The file has no lights that the baked shadows belong to: turn on Punctual Lights")

    def gather_tree_filter_tag_hook(self, tree: Any, _export_settings: dict[str, Any]) -> None:
        """The preview is not a part of the level."""
        for node in tree.nodes.values():
            if node.blender_object and overlay.MARK in node.blender_object:
                node.keep_tag = False

    def gather_gltf_extensions_hook(self, gltf: Any, _export_settings: dict[str, Any]) -> None:
        forget_settings(gltf)
        if not self.uri:
            return
        if bpy.context.scene.vxs.export_as == "EXTRAS":
            gltf.extras = {**(gltf.extras or {}), EXTRA: self.uri}
        else:
            gltf.extensions = {**(gltf.extensions or {}), EXTENSION: {"uri": self.uri}}
            gltf.extensions_used.append(EXTENSION)


def forget_settings(gltf: Any) -> None:
    """Before Blender 5.0 the exporter takes the add-on's settings for custom properties of the user."""
    lights = (gltf.extensions or {}).get("KHR_lights_punctual", {}).get("lights", ())
    for extras in (*(item.extras for item in (*gltf.nodes, *gltf.scenes)), *(light.get("extras") for light in lights)):
        if extras:
            extras.pop("vxs", None)


def refuse_other_places(export_settings: dict[str, Any]) -> None:
    """A bake has the scene's own places, Y up."""
    if not export_settings["gltf_yup"]:
        raise ValueError("they need +Y Up")
    if export_settings.get("gltf_collection") and export_settings.get("gltf_at_collection_center"):
        raise ValueError("the file's origin is the centre of a collection")


def tell(export_settings: dict[str, Any], text: str) -> None:
    """A warning of the exporter; Blender 3.4 shows those on the console alone."""
    log = export_settings.get("log")
    if log:
        log.warning("vxs: " + text, popup=True)
    else:
        print("vxs: warning: " + text)
