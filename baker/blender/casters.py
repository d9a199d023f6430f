# Which objects cast baked shadows: what a render shows, less what moves and what is asked to cast none.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

from typing import Iterator

import bpy

from .settings import own

MOVING_PATHS = ("location", "rotation", "scale", "delta_")


def rendered_objects(collection: bpy.types.Collection) -> Iterator[bpy.types.Object]:
    """Objects of a collection and of those in it, without collections that renders leave out."""
    if not collection.hide_render:
        yield from collection.objects
        for child in collection.children:
            yield from rendered_objects(child)


def ancestors(ob: bpy.types.Object | None) -> Iterator[bpy.types.Object]:
    """The object, its parent, and so on."""
    while ob:
        yield ob
        ob = ob.parent


def curves(data: bpy.types.AnimData) -> Iterator[bpy.types.FCurve]:
    """Curves of the action, of strips, and drivers."""
    for user in (data, *(strip for track in data.nla_tracks if not track.mute for strip in track.strips)):
        if hasattr(user.action, "layers"):  # Blender 4.4: an action has curves for each slot
            for bag in (bag for layer in user.action.layers for strip in layer.strips for bag in strip.channelbags):
                yield from bag.fcurves if bag.slot_handle == user.action_slot_handle else ()
        elif user.action:
            yield from user.action.fcurves
    yield from data.drivers


def varies(curve: bpy.types.FCurve) -> bool:
    values = {point.co[1] for point in curve.keyframe_points}
    return len(values) > 1 or bool(curve.modifiers) or curve.driver is not None


def is_keyed(ob: bpy.types.Object) -> bool:
    """Whether keys or drivers change the place of an object."""
    data = ob.animation_data
    return bool(data) and any(curve.data_path.startswith(MOVING_PATHS) and varies(curve) for curve in curves(data))


def is_animated(ob: bpy.types.Object) -> bool:
    """Whether an object changes its place: by keys, drivers, physics, or a constraint to what is keyed, or to follow a path."""
    targets = [c.target for c in ob.constraints if not c.mute and getattr(c, "target", None)]
    follows = any(c.type == "FOLLOW_PATH" and not c.mute for c in ob.constraints)
    is_thrown = ob.rigid_body is not None and ob.rigid_body.type == "ACTIVE"
    return is_keyed(ob) or is_thrown or follows or any(is_keyed(target) for target in targets)


def is_deformed(ob: bpy.types.Object) -> bool:
    return any(m.type == "ARMATURE" and m.object and m.show_viewport for m in ob.modifiers) or ob.parent_type in ("ARMATURE", "BONE")


def instancer(instance: bpy.types.DepsgraphObjectInstance) -> bpy.types.Object | None:
    """The object that shows an instance of another one. Meshes that a curve or geometry nodes make are shown by their own object."""
    parent = instance.parent.original if instance.is_instance and instance.parent else None
    return parent if parent != instance.object.original else None


class Casters:
    """reason() says why an instance casts no shadow."""

    def __init__(self, scene: bpy.types.Scene, region: bpy.types.Object | None) -> None:
        self.settings, self.region = scene.vxs, region
        self.rendered = set(rendered_objects(scene.collection))
        self.movers = set(self.settings.movers.all_objects) if self.settings.movers else set()
        self.own: dict[bpy.types.Object, str] = {}
        self.users: dict[bpy.types.Object, set[bpy.types.ID]] = {}

    def reason(self, instance: bpy.types.DepsgraphObjectInstance) -> str:
        """Plain words; "" for what casts. instance: one that is rendered."""
        ob, shown_by = instance.object.original, instancer(instance)
        return self.own_reason(ob) or (self.own_reason(shown_by) if shown_by else "")

    def is_rendered(self, instance: bpy.types.DepsgraphObjectInstance) -> bool:
        ob, shown_by = instance.object.original, instancer(instance)
        base = shown_by or ob
        is_base_rendered = instance.show_self and base in self.rendered and not base.hide_render
        return is_base_rendered and (not shown_by or self.is_instance_rendered(ob, shown_by))

    def is_instance_rendered(self, ob: bpy.types.Object, by: bpy.types.Object) -> bool:
        """Instances of a collection follow what its objects say; those of an object itself are rendered all the same."""
        if not ob.hide_render and not all(c.hide_render for c in ob.users_collection):
            return True
        if any(s.settings.render_type == "OBJECT" and s.settings.instance_object == ob for s in by.particle_systems):
            return True
        if not any(m.type == "NODES" for m in by.modifiers):
            return False
        if ob not in self.users:
            self.users[ob] = bpy.data.user_map(subset={ob})[ob]
        return by in self.users[ob] or any(isinstance(user, bpy.types.NodeTree) for user in self.users[ob])

    def own_reason(self, ob: bpy.types.Object) -> str:
        if ob not in self.own:
            self.own[ob] = self.find_reason(ob)
        return self.own[ob]

    def find_reason(self, ob: bpy.types.Object) -> str:
        if ob == self.region:
            return "are the region"
        if not ob.visible_shadow:
            return "have no shadow visibility"
        if not own(ob).casts:
            return "are set to cast no baked shadows"
        line = list(ancestors(ob))
        if any(item and not item.get("vxs_cast_shadow", True) for o in line for item in (o, o.data)):
            return "have the property vxs_cast_shadow"
        if not self.movers.isdisjoint(line):
            return "are movers"
        if any(is_deformed(o) for o in line):
            return "are deformed by an armature"
        if self.settings.leave_out_animated and any(is_animated(o) for o in line):
            return "are animated"
        return ""
