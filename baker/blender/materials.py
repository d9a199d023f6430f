# The alpha of materials as Blender's glTF exporter of this version writes it: a mask, a blend, or none.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import bpy

from .nodes import End, constant, node_before, search, source, surface

BLENDER_4_2 = bpy.app.version >= (4, 2)  # from then on the nodes decide about alpha, not the settings of EEVEE
MODES = {"CLIP": "MASK", "HASHED": "BLEND", "BLEND": "BLEND"}
CLAMP, MIRROR, REPEAT = 33071, 33648, 10497
WRAPS = {"EXTEND": CLAMP, "CLIP": CLAMP, "MIRROR": MIRROR}


@dataclass
class Texture:
    """The image of a mask. channel: R, G, B, A, or L for luminance."""
    image: bpy.types.Image
    channel: str
    sampler: dict[str, int]
    transform: dict[str, Any]
    uv_map: str  # "": the layer that renders


@dataclass
class Appearance:
    value: dict[str, Any]  # of glTF's "materials", without the texture
    texture: Texture | None = None
    fault: str = ""  # what of its alpha is not baked


def factor_of(alpha: End) -> float:
    """The number that alpha is, or is multiplied by."""
    product = node_before(alpha, "MATH", operation="MULTIPLY")
    numbers = (constant(alpha), *((constant(product.input(0)), constant(product.input(1))) if product else ()))
    return next((number for number in numbers if number is not None), 1.0)


def clipped(end: End) -> tuple[float | None, End]:
    """The cutoff of nodes that clip alpha, and what they clip; or None, and the input."""
    if rounded := node_before(end, "MATH", operation="ROUND"):
        return 0.5, rounded.input(0)
    turned = node_before(end, "MATH", operation="SUBTRACT")
    if turned and constant(turned.input(0)) == 1.0:  # 1 - (alpha < cutoff)
        for operation, alpha, cutoff in (("LESS_THAN", 0, 1), ("GREATER_THAN", 1, 0)):
            test = node_before(turned.input(1), "MATH", operation=operation)
            if test and constant(test.input(alpha)) is None and constant(test.input(cutoff)) is not None:
                return constant(test.input(cutoff)), test.input(alpha)
    for operation, alpha, cutoff in (("GREATER_THAN", 0, 1), ("LESS_THAN", 1, 0)):
        test = node_before(end, "MATH", operation=operation)
        if test and constant(test.input(cutoff)) is not None:
            return constant(test.input(cutoff)), test.input(alpha)
    return None, end


def alpha_by_nodes(alpha: End | None) -> tuple[str, float | None, float]:
    """glTF's alphaMode, its cutoff, and the factor of alpha."""
    if alpha is None or constant(alpha) == 1.0:
        return "OPAQUE", None, 1.0
    cutoff, alpha = clipped(alpha)
    factor = factor_of(alpha)
    if cutoff is None and factor == 0.0:
        cutoff = 0.5
    return "BLEND" if cutoff is None else "MASK", cutoff, factor


def alpha_by_settings(material: bpy.types.Material, alpha: End | None) -> tuple[str, float | None, float]:
    """The same in Blender before 4.2."""
    mode = MODES.get(material.blend_method, "OPAQUE")
    return mode, material.alpha_threshold if mode == "MASK" else None, factor_of(alpha) if alpha else 1.0


def unlit_sockets(end: End) -> tuple[End, End | None] | None:
    """Color and alpha of a material that shows a color as it is; None for others."""
    alpha, before = None, end
    end = past_light_path(end)
    mix = node_before(end, "MIX_SHADER") if end == before else None
    if mix and node_before(mix.input(1), "BSDF_TRANSPARENT"):
        alpha, end = mix.input(0), past_light_path(mix.input(2))
    return (end, alpha) if end.socket.type == "RGBA" or source(end).socket.is_output and source(end).socket.type == "RGBA" else None


def past_light_path(end: End) -> End:
    """Past a mix that shows an emission to the camera alone."""
    mix = node_before(end, "MIX_SHADER")
    path = node_before(mix.input(0), "LIGHT_PATH") if mix else None
    if not path or path.socket.name != "Is Camera Ray":
        return end
    emission = node_before(mix.input(2), "EMISSION")
    return emission.input(0) if emission else mix.input(2)


def channel(trail: list[End], is_unlit: bool) -> str:
    """Which channel of the image is alpha. trail: from the image to the input of alpha."""
    if is_unlit:
        return "A"
    for end in trail:
        if end.node.type in ("SEPARATE_COLOR", "SEPRGB"):
            return end.socket.name[0]
        if end.socket.name == "Alpha":
            return "A"
    return ("L" if trail[0].socket.type == "RGBA" else "A") if BLENDER_4_2 else "R"


def manual_wrap(image: End) -> tuple[dict[str, int], End]:
    """Wrap modes that math nodes before an image make of its coordinates, and the input before them."""
    vector = image.input("Vector")
    combined = node_before(vector, "COMBXYZ")
    wraps: dict[str, int] = {}
    split = None
    for axis, key in (("X", "wrapS"), ("Y", "wrapT")) if combined else ():
        end = combined.input(axis)
        if (bounce := node_before(end, "MATH", operation="PINGPONG")) and constant(bounce.input(1)) == 1.0:
            wraps[key], end = MIRROR, bounce.input(0)
        elif (wrap := node_before(end, "MATH", operation="WRAP")) and (constant(wrap.input(1)), constant(wrap.input(2))) == (0.0, 1.0):
            wraps[key], end = REPEAT, wrap.input(0)
        found = node_before(end, "SEPXYZ")
        if not found or found.socket.name != axis or split and found.node != split.node:
            return {}, vector
        split = found
    return (wraps, split.input(0)) if split else ({}, vector)


def transform_of(mapping: bpy.types.Node) -> dict[str, Any]:
    """KHR_texture_transform of a mapping node; {} for none, or one that glTF does not have."""
    tilt_x, tilt_y, turn = mapping.inputs["Rotation"].default_value
    if mapping.vector_type == "NORMAL" or tilt_x or tilt_y:
        return {}
    x, y = (0.0, 0.0) if mapping.vector_type == "VECTOR" else mapping.inputs["Location"].default_value[:2]
    scale_x, scale_y = mapping.inputs["Scale"].default_value[:2]
    if mapping.vector_type == "TEXTURE":  # the inverse
        if abs(turn) > 1e-5 and abs(scale_x - scale_y) > 1e-5 or min(abs(scale_x), abs(scale_y)) < 1e-5:
            return {}
        cos, sin = math.cos(turn), math.sin(turn)
        x, y, turn, scale_x, scale_y = (-x * cos - y * sin) / scale_x, (x * sin - y * cos) / scale_y, -turn, 1 / scale_x, 1 / scale_y
    offset = [x - scale_y * math.sin(turn), 1 - y - scale_y * math.cos(turn)]
    value = {"offset": offset, "rotation": turn, "scale": [scale_x, scale_y]}
    return {key: v for key, v in value.items() if v != {"offset": [0, 0], "rotation": 0, "scale": [1, 1]}[key]}


def texture_of(color: list[End] | None, alpha: list[End] | None, is_unlit: bool) -> Texture | None:
    """The image whose alpha counts; placed as the color's image is, as the exporter places it. color, alpha: trails of search()."""
    placed, filled = (color or alpha or [None])[0], alpha or color
    if not filled or not filled[0].node.image or not min(filled[0].node.image.size):
        return None
    node = placed.node
    wrap = WRAPS.get(node.extension, REPEAT)
    wraps, vector = manual_wrap(placed)
    mapping = node_before(vector, "MAPPING")
    vector = mapping.input("Vector") if mapping else vector
    uv_map, attribute = node_before(vector, "UVMAP"), node_before(vector, "ATTRIBUTE") if BLENDER_4_2 else None
    filters = {"magFilter": 9728, "minFilter": 9984} if node.interpolation == "Closest" else {"magFilter": 9729, "minFilter": 9987}
    return Texture(image=filled[0].node.image, channel=channel(alpha, is_unlit) if alpha else "A",
                   sampler={**filters, "wrapS": wrap, "wrapT": wrap, **wraps}, transform=transform_of(mapping.node) if mapping else {},
                   uv_map=uv_map.node.uv_map if uv_map else attribute.node.attribute_name if attribute else "")


def shown_color(material: bpy.types.Material, color: End | None) -> list[float]:
    """For pictures alone: the color where it is one, else that of the viewport."""
    found = source(color) if color else None
    is_one = found and found.socket.type == "RGBA" and (not found.socket.is_output or found.node.type == "RGB")
    return [min(max(c, 0.0), 1.0) for c in (found.socket.default_value if is_one else material.diffuse_color)[:3]]


def transmission(shader: End) -> float:
    """The share of light that a Principled BSDF lets through, where it is one number."""
    name = "Transmission Weight" if "Transmission Weight" in shader.node.inputs else "Transmission"
    return constant(shader.input(name)) or 0.0


def appearance(material: bpy.types.Material) -> Appearance:
    """What glTF says of a material, as far as it decides about shadows."""
    value: dict[str, Any] = {"name": material.name}
    if not material.use_backface_culling:
        value["doubleSided"] = True
    if material.get("vxs_cast_shadow") is not None:
        value["extras"] = {"vxs_cast_shadow": bool(material["vxs_cast_shadow"])}
    end = surface(material)
    unlit = unlit_sockets(end) if end else None
    shader = None if unlit or not end else (search(end, "BSDF_PRINCIPLED") or [None])[0]
    color, alpha = unlit or ((shader.input("Base Color"), shader.input("Alpha")) if shader else (None, None))
    mode, cutoff, factor = alpha_by_nodes(alpha) if BLENDER_4_2 else alpha_by_settings(material, alpha)
    if shader and (share := transmission(shader)):
        value["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": share}}
    value["pbrMetallicRoughness"] = {"baseColorFactor": [*shown_color(material, color), 1.0 if mode == "OPAQUE" else factor]}
    if mode == "OPAQUE":
        return Appearance(value)
    value["alphaMode"] = mode
    if cutoff is not None:
        value["alphaCutoff"] = cutoff
    trails = [search(e, "TEX_IMAGE") if e else None for e in (color, alpha)]
    texture, fault = texture_of(*trails, is_unlit=bool(unlit)), ""
    if texture and texture.image.source == "TILED":
        fault = "of an image in tiles (UDIM), only the first is baked"
    elif not texture and alpha and constant(alpha) is None:
        fault = "its alpha comes from nodes that are not baked, or has no image: it is baked as a wall; use an image or a number"
    return Appearance(value, texture, fault)
