# What a bake is asked to do, stored with the scene, its lights and objects; and what it reports, which is never stored.
# SPDX-License-Identifier: GPL-3.0-or-later
# flake8: noqa: F722, F821 -- annotations of Blender are properties, not types
from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import AddonPreferences, Collection, Context, Light, Object, PropertyGroup, Scene, WindowManager

SIDES = tuple((str(1 << n), f"{1 << n} x {1 << n}", "") for n in range(8, 19))
CLOSED = (("auto", "By the rules", "Closed meshes of one-sided materials have an inside, where nothing is looked up"),
          ("on", "All closed meshes", "Also those of two-sided materials: smaller files"),
          ("off", "None", "Every mesh is a thin surface: largest files"))
PACK = (("small", "Small", "The fewest bytes"), ("fast", "Fast to open", "Opens six times faster, 1.6 to 1.9 times the bytes"))
BLEND = (("auto", "Walls, and a Warning", "Walls where alpha is 0.5 or more; the bake names such materials"),
         ("mask", "Walls Where Alpha Is 0.5 or More", ""), ("opaque", "Walls", ""), ("exclude", "Nothing", ""))
EXPORT_AS = (("EXTENSION", "Extension VXS_baked_shadows", "For three.js, by vxs/three"),
             ("EXTRAS", "Extras", "A property vxs_shadows of the file, which more tools keep"))
DETAIL = (("RESOLUTION", "Resolution", "Texels along a side of the map of a light"), ("TEXEL", "Texel Size", "Metres along a side of a texel"))


def resolution() -> EnumProperty:
    return EnumProperty(name="Resolution", description="Texels along a side of the map of a light", items=SIDES, default="4096")


def texel() -> FloatProperty:
    return FloatProperty(name="Texel Size", description="Side of a texel: no edge of a shadow is finer", unit="LENGTH", default=0.05,
                         min=1e-4, soft_max=1.0, precision=4)


class VxsSceneSettings(PropertyGroup):
    detail: EnumProperty(name="Detail", items=DETAIL)
    resolution: resolution()
    texel: texel()
    region: PointerProperty(name="Region", type=Object,
                            description="Points are looked up in the bounding box of this object, such as an empty cube. Objects outside "
                            "still cast shadows into it. Without one, the region is all that casts shadows")
    movers: PointerProperty(name="Movers", type=Collection,
                            description="Objects of this collection move in the game, and cast no baked shadow")
    leave_out_animated: BoolProperty(name="Leave out Animated Objects", default=True,
                                     description="Objects whose place is animated, and their children, cast no baked shadow")
    closed: EnumProperty(name="Solids", items=CLOSED, description="Which meshes have an inside")
    pack: EnumProperty(name="Packing", items=PACK)
    blend: EnumProperty(name="Blended Materials", items=BLEND, description="What materials that are partly transparent cast")
    if_changed: BoolProperty(name="Only If Changed", default=True,
                             description="Keep a file that was baked from the same scene and settings")
    filepath: StringProperty(name="Output", subtype="FILE_PATH",
                             description="The file to write. Without one: that of the .blend, with .vxs")
    export: BoolProperty(name="Baked Shadows", default=True,
                         description="Exports of glTF bake this scene into a .vxs file beside theirs, where anything has changed")
    export_as: EnumProperty(name="Named by", items=EXPORT_AS, description="How the exported file names the .vxs file")


class VxsLightSettings(PropertyGroup):
    bake: BoolProperty(name="Bake Shadows", default=True, description="This light gets baked shadows")
    detail: EnumProperty(name="Detail", items=(("SCENE", "As the Scene", "As in the render properties"), *DETAIL))
    resolution: resolution()
    texel: texel()


class VxsObjectSettings(PropertyGroup):
    casts: BoolProperty(name="Casts Baked Shadows", default=True)


class VxsNamed(PropertyGroup):
    """A thing that a message names; `name` is its name."""
    kind: StringProperty()  # OBJECT, MATERIAL, LIGHT


class VxsMessage(PropertyGroup):
    text: StringProperty()
    level: EnumProperty(items=(("INFO", "", ""), ("WARNING", "", ""), ("ERROR", "", "")))
    named: CollectionProperty(type=VxsNamed)


class VxsState(PropertyGroup):
    is_running: BoolProperty(options={"SKIP_SAVE"})
    is_cancelled: BoolProperty(options={"SKIP_SAVE"})
    share: FloatProperty(subtype="FACTOR", min=0.0, max=1.0, options={"SKIP_SAVE"})
    doing: StringProperty(options={"SKIP_SAVE"})
    messages: CollectionProperty(type=VxsMessage, options={"SKIP_SAVE"})
    result: StringProperty(options={"SKIP_SAVE"})  # lines of the last bake: size, time, memory, texels
    filepath: StringProperty(options={"SKIP_SAVE"})  # what the last bake wrote
    check: StringProperty(options={"SKIP_SAVE"})  # lines of the last comparison with rays

    def clear(self) -> None:
        self.result = self.filepath = self.check = ""
        self.messages.clear()


class VxsPreferences(AddonPreferences):
    bl_idname = __package__

    vxs: StringProperty(name="vxs", subtype="FILE_PATH", description="The command vxs. Without it, the one on the PATH")
    threads: IntProperty(name="Threads", min=0, max=1024, description="0: all processors")
    memory: IntProperty(name="Memory in MiB", min=0, description="A bake uses no more; 0: as much as it needs")

    def draw(self, _context: Context) -> None:
        for name in ("vxs", "threads", "memory"):
            self.layout.prop(self, name)


UNTOUCHED = SimpleNamespace(bake=True, detail="SCENE", casts=True)


def own(holder: Light | Object) -> Any:
    """The settings of a light or an object. One that has none is only read, as holder.vxs would make some in the user's file."""
    return holder.vxs if holder.is_property_set("vxs") else UNTOUCHED


CLASSES = (VxsSceneSettings, VxsLightSettings, VxsObjectSettings, VxsNamed, VxsMessage, VxsState, VxsPreferences)
HOLDERS = ((Scene, VxsSceneSettings), (Light, VxsLightSettings), (Object, VxsObjectSettings), (WindowManager, VxsState))


@persistent
def forget_bake(*_: object) -> None:
    """A newly opened file has had no bake."""
    for manager in bpy.data.window_managers:
        manager.vxs.clear()


def register() -> None:
    for holder, group in HOLDERS:
        holder.vxs = PointerProperty(type=group)
    bpy.app.handlers.load_post.append(forget_bake)


def unregister() -> None:
    bpy.app.handlers.load_post.remove(forget_bake)
    for holder, _ in HOLDERS:
        del holder.vxs
