# What vxs says, in the words of Blender, with the objects, materials and lights that it names.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

import re
from typing import Any, Iterable

import bpy
from bpy.props import IntProperty

from .level import Level

# what vxs says of its options, and where Blender has them; the first that fits is taken
SETTINGS = (
    (r"--resolution \S+ takes less time and a smaller file", "a lower resolution takes less time and a smaller file"),
)


def plain(text: str) -> str:
    """A message of vxs without options of a command line."""
    for pattern, words in SETTINGS:
        text = re.sub(pattern, words, text)
    return text


def things_named(text: str, level: Level) -> Iterable[tuple[str, str]]:
    """Kinds and names of what a message names in quotes."""
    for name in dict.fromkeys(re.findall(r"'(.+?)'", text)):
        if name in level.objects:
            yield from (("OBJECT", ob) for ob in sorted(level.objects[name]))
        elif name in bpy.data.materials:
            yield "MATERIAL", name


def tell(state: Any, level: str, text: str, named: Iterable[tuple[str, str]] = ()) -> None:
    message = state.messages.add()
    message.level, message.text = level, text[:1].upper() + text[1:]
    for kind, name in named:
        thing = message.named.add()
        thing.kind, thing.name = kind, name


def tell_warnings(state: Any, level: Level, warnings: list[str]) -> None:
    for text, name in level.notes:
        tell(state, "WARNING", text, [("OBJECT", name)])
    for text in warnings:
        tell(state, "WARNING", plain(text), things_named(text, level))


def tell_left_out(state: Any, level: Level) -> None:
    for why, names in sorted(level.left_out.items()):
        count = f"{len(names)} objects {why}" if len(names) > 1 else f"Object '{min(names)}' {singular(why)}"
        tell(state, "INFO", f"{count}: no baked shadow", [("OBJECT", name) for name in sorted(names)])


def singular(why: str) -> str:
    return re.sub(r"^(are|have)\b", lambda verb: {"are": "is", "have": "has"}[verb[1]], why)


class VXS_OT_select_named(bpy.types.Operator):
    bl_idname = "vxs.select_named"
    bl_label = "Select"
    bl_description = "Select the objects that this message names, or those with the material that it names"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(min=0, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == "OBJECT"

    def execute(self, context: bpy.types.Context) -> set[str]:
        messages = context.window_manager.vxs.messages
        named = messages[self.index].named if self.index < len(messages) else ()
        names = {thing.name for thing in named if thing.kind == "OBJECT"}
        used = {thing.name for thing in named if thing.kind == "MATERIAL"}
        found = [ob for ob in context.view_layer.objects
                 if ob.name in names or any(slot.material and slot.material.name in used for slot in ob.material_slots)]
        found = [ob for ob in found if ob.visible_get()]
        if not found:
            self.report({"WARNING"}, "What this message names is not in this view layer, or hidden")
            return {"CANCELLED"}
        for ob in context.view_layer.objects:
            ob.select_set(ob in found)
        context.view_layer.objects.active = found[0]
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(VXS_OT_select_named)


def unregister() -> None:
    bpy.utils.unregister_class(VXS_OT_select_named)
