# The glTF exporter writes the baked shadows beside its file, and names them in it.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import os
from typing import Any, Callable
from urllib.parse import quote

import bpy
from bpy.types import Context, Panel, UILayout

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
    for item in [*gltf.nodes, *gltf.scenes]:
        if item.extras and item.extras.pop("vxs", None) is not None and not item.extras:
            item.extras = None
    for light in (gltf.extensions or {}).get("KHR_lights_punctual", {}).get("lights", ()):
        if light.get("extras") and light["extras"].pop("vxs", None) is not None and not light["extras"]:
            light["extras"] = None


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


def draw(context: Context, layout: UILayout) -> None:
    """A part of the export panel, as Blender 4.2 and later call it."""
    settings = context.scene.vxs
    header, body = layout.panel("VXS_export", default_closed=False)
    header.prop(settings, "export")
    if body:
        body.active = settings.export
        body.prop(settings, "export_as")


class VXS_PT_export(Panel):
    """The same for Blender 3.4."""
    bl_space_type = "FILE_BROWSER"
    bl_region_type = "TOOL_PROPS"
    bl_label = ""
    bl_parent_id = "GLTF_PT_export_user_extensions"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.space_data.active_operator.bl_idname == "EXPORT_SCENE_OT_gltf"

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.vxs, "export")

    def draw(self, context: Context) -> None:
        self.layout.active = context.scene.vxs.export
        self.layout.prop(context.scene.vxs, "export_as")


def register_panel() -> Callable[[], None]:
    """Blender 3.4 asks for the panel when its exporter opens, and calls the result when that is disabled."""
    if not VXS_PT_export.is_registered:
        bpy.utils.register_class(VXS_PT_export)
    return unregister_panel


def unregister_panel() -> None:
    if VXS_PT_export.is_registered:
        bpy.utils.unregister_class(VXS_PT_export)


def panels_of_exporter() -> dict[str, Any]:
    """What Blender 4.2 and later draw in the export panel; elsewhere a dictionary that is not used."""
    try:
        import io_scene_gltf2
    except ImportError:
        return {}
    return getattr(io_scene_gltf2, "exporter_extension_layout_draw", {})


def register() -> None:
    panels_of_exporter()["vxs"] = draw


def unregister() -> None:
    panels_of_exporter().pop("vxs", None)
    unregister_panel()
