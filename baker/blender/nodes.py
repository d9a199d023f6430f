# Walks through the nodes of a material, against the links, as Blender's glTF exporter walks.
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

from typing import NamedTuple

import bpy


class End(NamedTuple):
    """A socket, and the group nodes that it lies in: an input, or the output that a walk came to."""
    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    @property
    def node(self) -> bpy.types.Node:
        return self.socket.node

    def input(self, key: str | int) -> End:
        return End(self.node.inputs[key], self.groups)


def twin(socket: bpy.types.NodeSocket, sockets: bpy.types.bpy_prop_collection) -> bpy.types.NodeSocket:
    """The socket on the other side of the border of a group."""
    return next(other for other in sockets if other.identifier == socket.identifier)


def source(end: End) -> End:
    """What feeds an input: an output of a node that is neither a reroute nor a border of a group; or an input that is not linked."""
    socket, groups = end
    while not socket.is_output and socket.is_linked:
        socket = socket.links[0].from_socket
        node = socket.node
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.type == "GROUP" and node.node_tree:
            inner = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
            if inner:
                socket, groups = twin(socket, inner.inputs), (*groups, node)
        elif node.type == "GROUP_INPUT" and groups:
            socket, groups = twin(socket, groups[-1].inputs), groups[:-1]
    return End(socket, groups)


def node_before(end: End, kind: str, **values: str) -> End | None:
    """The output that feeds an input, where it is of a node of this kind with these values."""
    found = source(end)
    fits = found.socket.is_output and found.node.type == kind and all(getattr(found.node, k) == v for k, v in values.items())
    return found if fits else None


def constant(end: End) -> float | None:
    """The number at an input, where nothing but a number feeds it."""
    found = source(end)
    if found.socket.type != "VALUE" or found.socket.is_output and found.node.type != "VALUE":
        return None
    return found.socket.default_value


def search(end: End, kind: str) -> list[End] | None:
    """The outputs from the first node of this kind, in a walk that takes inputs in their order, to an input: the first is that node's."""
    found = source(end)
    if not found.socket.is_output:
        return None
    if found.node.type == kind:
        return [found]
    return next(([*trail, found] for trail in (search(End(i, found.groups), kind) for i in found.node.inputs) if trail), None)


def surface(material: bpy.types.Material) -> End | None:
    """The input of the output node that shows the material's surface."""
    tree = material.node_tree if material.use_nodes else None
    output = next((n for n in tree.nodes if n.type == "OUTPUT_MATERIAL" and n.is_active_output), None) if tree else None
    return End(output.inputs["Surface"]) if output else None
