# Lights as Blender's glTF exporter converts them: watts to candela, the cone of a spot, the distance where it ends.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import math
from typing import Any

import bpy

TYPES = {"SUN": "directional", "POINT": "point", "SPOT": "spot"}
LUMENS_PER_WATT = 683.0


def strength(light: bpy.types.Light, matrix: Any) -> float:
    """Lux of a sun, candela of a lamp. matrix: of the light's object, which scales lights that are not normalized."""
    value = light.energy
    if not getattr(light, "normalize", True):
        value *= light.area(matrix_world=matrix)
    value *= 2.0 ** getattr(light, "exposure", 0.0)
    return LUMENS_PER_WATT * (value if light.type == "SUN" else value / (4.0 * math.pi))


def color(light: bpy.types.Light) -> list[float]:
    tint = light.temperature_color if getattr(light, "use_temperature", False) else (1.0, 1.0, 1.0)
    return [a * b for a, b in zip(light.color, tint)]


def gltf_light(light: bpy.types.Light, matrix: Any) -> dict[str, Any] | None:
    """The light of KHR_lights_punctual; None for an area light, which glTF does not have."""
    if light.type not in TYPES:
        return None
    value: dict[str, Any] = {"name": light.name, "type": TYPES[light.type], "color": color(light), "intensity": strength(light, matrix)}
    if light.type == "SPOT":
        half = light.spot_size * 0.5
        value["spot"] = {"innerConeAngle": half - half * light.spot_blend, "outerConeAngle": half}
    if getattr(light, "use_custom_distance", False):
        value["range"] = light.cutoff_distance
    return value
