# What vxs says, in the words of Blender, with the objects, materials and lights that it names.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

import re
from typing import Any, Iterable

import bpy
from bpy.props import IntProperty

from .level import Level

CASTS = "turn off Casts Baked Shadows of"
# what vxs says of its options and of glTF, and the words of Blender; all that fit are replaced, in this order
WORDS = (
    (r"unknown option '.*", "this vxs is older than the add-on: install both from one version"),
    (r"\b(node|mesh|material) \d+ '", r"\1 '"),
    (r" \(node[^)]*\)", ""),
    (r"(material '.*); --exclude .* bakes without it", r"\1; give it the custom property vxs_cast_shadow, False"),
    (r"--exclude (?:'[^']*'|\S+) bakes without it", f"{CASTS} it"),
    (r"leave the others out with --exclude .*", f"{CASTS} the others"),
    (r"give that a node of its own, and leave it out with --exclude", f"separate that from its mesh, and {CASTS} it"),
    (r"leave (it|that|them) out with --exclude .*", rf"{CASTS} \1"),
    (r"--region \S+, or (?:--exclude .*|leave them out)", f"choose a Region around the rest, or {CASTS} these"),
    (r"--region touches no caster: .* m; give a box that meets them, or none",
     "the Region touches nothing that casts shadows: move it, or choose none"),
    (r"--resolution (?:[^;]*=)?(\d+)", r"a resolution of \1"),
    (r"--region around", "a Region around"),
    (r"--region", "the Region"),
    (r"--texel ([\d.e+-]+): (.*); at least --texel .*=(\S+)", r"the Texel Size of \1 m is too small: \2; at least \3 m"),
    (r"--texel", "Texel Size"),
    (r"set alphaMode to (?:MASK or )?OPAQUE, or give --blend: .*", "clip its alpha, or choose what Blended Materials cast"),
    (r"--blend exclude leaves .*", "choose what Blended Materials cast, or give it the custom property vxs_cast_shadow, False"),
    (r"alphaMode BLEND,? is baked as a mask, a wall", "blended, is baked as a wall"),
    (r"alphaMode BLEND, with", "blended, with"),
    (r"lower alphaCutoff, or set alphaMode to OPAQUE", "lower the threshold of its alpha, or make it opaque"),
    (r"leave it out with --light", "turn off its Bake Shadows"),
    (r"set it in the scene, or --light bakes it all the same", "give it power, or turn off its Bake Shadows"),
    (r"set their intensities, or name them with --light", "give them power, or turn off their Bake Shadows"),
    (r"take one out of the scene, or choose with --light", "delete one, or turn off its Bake Shadows"),
    (r"choose some with --light NAME, in several bakes", "turn off Bake Shadows of some"),
    (r"travels upward, \(.*?\), as", "travels upward, as"),
    (r"travels level, along -Z, .*", "travels level, and sunlight comes from above: turn it"),
    (r": the direction is the way light travels; turn it round, or give --sun .*", ": turn it round"),
    (r"[:;] --sun X,Y,Z gives one", ""),
    (r"glTF is in metres; export it so, or scale its root nodes", "a unit of Blender is baked as a metre; scale the objects"),
    (r"scale its root nodes", "scale the objects"),
    (r"store them near it, and place them by the translation of the node", "set the object's origin to its geometry"),
    (r"--memory (\S+(?: \w+)?)", r"the Memory of \1 in the add-on's preferences"),
    (r"try another --resolution or --coding dag, and.*", "try another Resolution"),
    (r"set alphaMode to OPAQUE", "make it opaque"),
    (r"image \d+ has", "its image has"),
    (r"KHR_materials_(?:diffuse_)?transmission lets", "transmission lets"),
    (r"or a node above it has", "or a parent of it has"),
    (r"\bnode\b", "object"),
)


def plain(text: str, path: str = "") -> str:
    """A message of vxs without options of a command line. path: of the level, which the user has not seen."""
    if path:
        text = text.replace(f"'{path}'", "the level").replace(path, "the level")
    for pattern, words in WORDS:
        text = re.sub(pattern, words, text)
    return text


def names_it(text: str, name: str) -> bool:
    """Whether a text has a name in quotes. vxs leaves out the middle of long ones."""
    return f"'{name}'" in text or len(name.encode()) > 60 and f"'{name[:14]}" in text and f"{name[-14:]}'" in text


def things_named(text: str, level: Level) -> Iterable[tuple[str, str]]:
    """Kinds and names of what a message in Blender's words names."""
    for material in bpy.data.materials:
        if names_it(text, material.name) and f"material '{material.name[:14]}" in text:
            yield "MATERIAL", material.name
            text = text.replace(f"'{material.name}'", "")
    for name in sorted(level.objects):
        if names_it(text, name):
            yield from (("OBJECT", ob) for ob in sorted(level.objects[name]))


def tell(state: Any, level: str, text: str, named: Iterable[tuple[str, str]] = ()) -> None:
    message = state.messages.add()
    message.level, message.text = level, text[:1].upper() + text[1:]
    for kind, name in named:
        thing = message.named.add()
        thing.kind, thing.name = kind, name


def tell_warnings(state: Any, level: Level, warnings: list[str]) -> None:
    for text in (*level.notes, *(plain(warning, level.path) for warning in warnings)):
        tell(state, "WARNING", text, [("OBJECT", level.region)] if "the Region" in text else things_named(text, level))


def tell_left_out(state: Any, level: Level) -> None:
    for why, names in sorted(level.left_out.items()):
        tell(state, "INFO", f"{len(names)} left out: objects that {why}", [("OBJECT", name) for name in sorted(names)])


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
        found = [ob for ob in context.view_layer.objects if ob.visible_get() and
                 (ob.name in names or any(slot.material and slot.material.name in used for slot in ob.material_slots))]
        if not found:
            self.report({"WARNING"}, "What this message names is not in this view layer, or hidden")
            return {"CANCELLED"}
        found = [ob for ob in found if ob.type != "LIGHT"] or found  # no user deletes a sun together with a stray plane
        bpy.ops.object.select_all(action="DESELECT")
        for ob in found:
            ob.select_set(True)
        context.view_layer.objects.active = found[0]
        return {"FINISHED"}


CLASSES = (VXS_OT_select_named,)
