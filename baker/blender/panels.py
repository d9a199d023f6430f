# The panels of the scene's render properties, of lights and of objects.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import textwrap
from typing import Any

from bpy.types import Context, Panel, UILayout

from .lights import TYPES


def draw_detail(layout: UILayout, settings: Any) -> None:
    layout.prop(settings, "detail")
    if settings.detail != "SCENE":
        layout.prop(settings, "texel" if settings.detail == "TEXEL" else "resolution")


class PropertiesPanel(Panel):
    bl_label = "Baked Shadows"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_options = {"DEFAULT_CLOSED"}


class ScenePanel(PropertiesPanel):
    bl_context = "render"


class VXS_PT_scene(ScenePanel):
    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.vxs
        layout.use_property_split, layout.use_property_decorate = True, False
        draw_detail(layout, settings)
        for name in ("region", "movers", "leave_out_animated", "blend", "closed", "pack", "if_changed", "filepath"):
            layout.prop(settings, name)


class VXS_PT_lights(ScenePanel):
    bl_label = "Lights"
    bl_parent_id = "VXS_PT_scene"

    def draw(self, context: Context) -> None:
        lights = {ob.data for ob in context.scene.objects if ob.type == "LIGHT" and ob.data.type in TYPES}
        for light in sorted(lights, key=lambda each: each.name):
            self.layout.prop(light.vxs, "bake", text=light.name)


class VXS_PT_bake(ScenePanel):
    """The button, what it is doing, and what came of it."""
    bl_label = "Bake"
    bl_parent_id = "VXS_PT_scene"
    bl_options = set()

    def draw(self, context: Context) -> None:
        layout, state = self.layout, context.window_manager.vxs
        if state.is_running:
            row = layout.row(align=True)
            row.prop(state, "share", text=state.doing or "baking", slider=True)
            row.operator("vxs.cancel", text="", icon="X")
        else:
            layout.operator("vxs.bake", icon="RENDER_STILL")
        for line in state.result.splitlines():
            layout.label(text=line)
        for index, message in enumerate(state.messages):
            self.draw_message(layout, context, index, message)

    def draw_message(self, layout: UILayout, context: Context, index: int, message: Any) -> None:
        box = layout.box()
        row = box.row()
        column = row.column(align=True)
        column.scale_y = 0.8
        icon = "INFO" if message.level == "INFO" else "ERROR"
        for line in textwrap.wrap(message.text, max(20, int(context.region.width / context.preferences.system.ui_scale / 7) - 8)):
            column.label(text=line, icon=icon)
            icon = "BLANK1"
        if len(message.named):
            row.operator("vxs.select_named", text="", icon="RESTRICT_SELECT_OFF").index = index


class VXS_PT_preview(ScenePanel):
    bl_label = "Preview and Export"
    bl_parent_id = "VXS_PT_scene"

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.scene.vxs
        row = layout.row(align=True)
        row.operator("vxs.preview", icon="SHADING_SOLID").set_shading = True
        row.operator("vxs.preview_clear", text="", icon="X")
        layout.operator("vxs.picture", icon="IMAGE_DATA")
        layout.operator("vxs.check_error", icon="VIEWZOOM")
        for line in context.window_manager.vxs.check.splitlines():
            layout.label(text=line)
        layout.prop(settings, "export", text="Bake in glTF Exports")
        layout.prop(settings, "export_as")


class VXS_PT_light(PropertiesPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.light is not None and context.light.type in TYPES

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.light.vxs
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.prop(settings, "bake")
        column = layout.column()
        column.active = settings.bake
        draw_detail(column, settings)


class VXS_PT_object(PropertiesPanel):
    bl_context = "object"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None and context.object.type in ("MESH", "CURVE", "SURFACE", "FONT", "META", "EMPTY")

    def draw(self, context: Context) -> None:
        self.layout.prop(context.object.vxs, "casts")


CLASSES = (VXS_PT_scene, VXS_PT_lights, VXS_PT_bake, VXS_PT_preview, VXS_PT_light, VXS_PT_object)
