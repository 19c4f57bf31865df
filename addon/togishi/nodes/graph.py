"""A small notation for shader node trees: arithmetic on sockets, constants that can be set later."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy

Socket = bpy.types.NodeSocket
Value = Socket | float


class Graph:
    """Adds nodes to a tree. Operands are sockets or numbers."""

    def __init__(self, tree: bpy.types.ShaderNodeTree) -> None:
        self.tree = tree
        self._column = 0

    def node(self, kind: str, label: str = "", **settings: Any) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        # A readable spread from left to right; who opens the group sees the order of the formulas.
        node.location = (220.0 * (self._column // 6), -190.0 * (self._column % 6))
        node.hide = False
        self._column += 1
        if label:
            node.label = label
            node.name = label
        for name, value in settings.items():
            setattr(node, name, value)
        return node

    def connect(self, value: Any, socket: Socket) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(
        self, operation: str, a: Value, b: Value = 0.0, c: Value = 0.0, label: str = ""
    ) -> Socket:
        node = self.node("ShaderNodeMath", label, operation=operation)
        for value, socket in zip((a, b, c), node.inputs, strict=False):
            self.connect(value, socket)
        return node.outputs[0]

    def add(self, a: Value, b: Value) -> Socket:
        return self.math("ADD", a, b)

    def sub(self, a: Value, b: Value) -> Socket:
        return self.math("SUBTRACT", a, b)

    def mul(self, a: Value, b: Value) -> Socket:
        return self.math("MULTIPLY", a, b)

    def vector(
        self, operation: str, a: Any, b: Any = None, c: Any = None, scale: Value | None = None
    ) -> Socket:
        """Vector arithmetic; DOT_PRODUCT and LENGTH give a number."""
        node = self.node("ShaderNodeVectorMath", operation=operation)
        for value, socket in zip((a, b, c), node.inputs[:3], strict=True):
            if value is not None:
                self.connect(value, socket)
        if scale is not None:
            self.connect(scale, node.inputs["Scale"])
        return node.outputs["Value" if operation in {"DOT_PRODUCT", "LENGTH"} else "Vector"]

    def combine(self, x: Value, y: Value, z: Value, label: str = "") -> Socket:
        node = self.node("ShaderNodeCombineXYZ", label)
        for value, socket in zip((x, y, z), node.inputs, strict=True):
            self.connect(value, socket)
        return node.outputs[0]

    def separate(self, vector: Socket) -> Sequence[Socket]:
        node = self.node("ShaderNodeSeparateXYZ")
        self.connect(vector, node.inputs[0])
        return node.outputs[:3]

    def channels(self, colour: Socket) -> Sequence[Socket]:
        node = self.node("ShaderNodeSeparateColor", mode="RGB")
        self.connect(colour, node.inputs[0])
        return node.outputs[:3]

    def constant(self, name: str) -> Socket:
        """A number that set_constant changes by its name."""
        return self.node("ShaderNodeValue", name).outputs[0]

    def constant3(self, name: str) -> Socket:
        """Three numbers that set_constant changes by their name."""
        return self.node("ShaderNodeCombineXYZ", name).outputs[0]

    def mix_shader(self, factor: Value, first: Socket, second: Socket, label: str = "") -> Socket:
        node = self.node("ShaderNodeMixShader", label)
        self.connect(factor, node.inputs[0])
        self.connect(first, node.inputs[1])
        self.connect(second, node.inputs[2])
        return node.outputs[0]


def set_constant(tree: bpy.types.ShaderNodeTree, name: str, value: float | Sequence[float]) -> None:
    """Set what Graph.constant or constant3 made. A name that the tree does not use is passed over."""
    node = tree.nodes.get(name)
    if node is None:
        return
    if node.bl_idname == "ShaderNodeValue":
        node.outputs[0].default_value = float(value)
    else:
        for socket, number in zip(node.inputs, value, strict=True):
            socket.default_value = float(number)
