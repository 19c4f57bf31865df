"""What feeds a node's socket."""

from __future__ import annotations

import bpy


def feeding_node(socket: bpy.types.NodeSocket) -> bpy.types.Node | None:
    """The node behind a socket, through reroutes and muted nodes; None where nothing, or a muted link, feeds it."""
    seen = set()
    while socket.links and not socket.links[0].is_muted:
        link = socket.links[0]
        node = link.from_node
        if node.type == "REROUTE":
            inside = node.inputs[0]
        elif node.mute:
            inside = next(
                (i.from_socket for i in node.internal_links if i.to_socket == link.from_socket),
                None,
            )
        else:
            return node
        if inside is None or inside in seen:
            return None
        seen.add(inside)
        socket = inside
    return None
