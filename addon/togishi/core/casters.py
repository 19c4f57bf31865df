"""What hides lamps and is mirrored: the scene's surfaces as trees that the GPU's rays search
(shaders/viewport/casters.glsl)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import native
from .packing import ViewSpace, box_corners
from .scene_data import (
    F32,
    F64,
    BladeMaterial,
    Instance,
    Material,
    MeshData,
    PlainMaterial,
    SceneData,
)
from .shader_source import CASTER_CAPACITY, CASTER_COLOURS, TREE_WIDTH

# Of one mesh; a larger one hides nothing and is said.
MAX_TRIANGLES = 1 << 21
# A matt surface's rays begin so far above it at least, as a share of the scene's size.
_LEAST_HEIGHT = 1.0e-6


@dataclass(frozen=True, eq=False)
class Tree:
    """A mesh for rays, in its own space (togishi_core.ray_tree)."""

    nodes: F32  # (2 N, 4)
    triangles: F32  # (4 T, 4)


@dataclass(frozen=True, eq=False)
class Caster:
    """One thing of the scene that rays may meet."""

    instance: Instance
    mesh: MeshData
    colours: tuple[tuple[float, float, float], ...]  # of the mesh's groups, in their order


@dataclass(frozen=True, eq=False)
class Casters:
    """What a picture's rays may meet, and for what they are cast."""

    casters: tuple[Caster, ...] = ()
    shadows: bool = False
    mirrored: bool = False
    left_out: tuple[str, ...] = ()  # sentences for the user

    def number_of(self, instance: Instance) -> int:
        """Its number among the casters, -1 for none."""
        for number, caster in enumerate(self.casters):
            if caster.instance is instance:
                return number
        return -1


def tree_of(mesh: MeshData) -> Tree:
    """The tree of all groups of a mesh."""
    triangles = np.concatenate([group.triangles for group in mesh.groups])
    sizes = [len(group.triangles) for group in mesh.groups]
    groups = np.repeat(np.arange(len(sizes), dtype=np.uint16), sizes)
    nodes, corners = native.core().ray_tree(
        mesh.position, np.ascontiguousarray(mesh.normal_part[:, :3]), triangles, groups
    )
    return Tree(nodes, corners)


def is_blade(instance: Instance, scene: SceneData) -> bool:
    """Whether any of it is polished steel. A blade is convex: it neither hides nor mirrors itself."""
    return any(
        isinstance(scene.material_of(instance, group.slot)[1], BladeMaterial)
        for group in scene.meshes[instance.mesh].groups
    )


def casters_of(scene: SceneData) -> Casters:
    """What must be traced in this scene: nothing where no thing can hide a lamp from another or from itself, or be
    mirrored by another's steel."""
    meshes = scene.meshes
    possible = [
        i for i in scene.instances if (i.casts or i.mirrored) and meshes[i.mesh].triangle_count
    ]
    blades = {id(i) for i in scene.instances if is_blade(i, scene)}
    shadows = any(light.shadows and not light.dark for light in scene.lights) or bool(
        not scene.world.black
        and scene.world.environment is not None
        and scene.world.environment.spots
    )
    # A blade needs another thing to hide lamps from, steel another thing to mirror.
    shadows = shadows and any(
        i.casts and (len(scene.instances) > 1 or id(i) not in blades) for i in possible
    )
    mirrored = scene.mirror_things and any(i.mirrored and blades - {id(i)} for i in possible)
    if not (shadows or mirrored):
        return Casters()
    left_out = []
    kept = []
    for instance in possible:
        count = meshes[instance.mesh].triangle_count
        if count > MAX_TRIANGLES:
            left_out.append(
                f"An object of {count} triangles neither casts a shadow nor is mirrored; allowed: {MAX_TRIANGLES} at most."
            )
        elif abs(float(np.linalg.det(instance.matrix[:3, :3]))) > 0.0:
            kept.append(instance)
    if len(kept) > CASTER_CAPACITY:
        left_out.append(
            f"{len(kept)} objects: the largest {CASTER_CAPACITY} cast shadows and are mirrored, the rest are not."
        )
        kept.sort(key=lambda i: -_ball(i.matrix, meshes[i.mesh])[3])
        kept = kept[:CASTER_CAPACITY]
    casters = tuple(
        Caster(
            i,
            meshes[i.mesh],
            tuple(
                _albedo(scene.material_of(i, group.slot)[1], group.nakago)
                for group in meshes[i.mesh].groups
            ),
        )
        for i in kept
    )
    return Casters(casters, shadows, mirrored, tuple(left_out))


def texels_of(trees: Sequence[Tree]) -> tuple[F32, list[tuple[int, int, int]]]:
    """All trees in one texture (H, TREE_WIDTH, 4); of each: texel of its first node, number of nodes, texel of its
    first triangle."""
    places = []
    used = 0
    for tree in trees:
        places.append((used, len(tree.nodes) // 2, used + len(tree.nodes)))
        used += len(tree.nodes) + len(tree.triangles)
    rows = max(-(-used // TREE_WIDTH), 1)
    texels = np.zeros((rows * TREE_WIDTH, 4), np.float32)
    for tree, (first, _count, triangles) in zip(trees, places, strict=True):
        texels[first : first + len(tree.nodes)] = tree.nodes
        texels[triangles : triangles + len(tree.triangles)] = tree.triangles
    return texels.reshape(rows, TREE_WIDTH, 4), places


def casters_block(
    casters: Casters, places: Sequence[tuple[int, int, int]], camera: ViewSpace
) -> F32:
    """TgCasters."""
    block = np.zeros((1 + 6 * CASTER_CAPACITY + CASTER_COLOURS, 4), np.float32)
    first_colour = 0
    size = 0.0
    for number, (caster, place) in enumerate(zip(casters.casters, places, strict=True)):
        rows = block[1 + 6 * number : 7 + 6 * number]
        in_view = camera.view @ caster.instance.matrix
        rows[0:3] = np.linalg.inv(in_view)[:3]
        rows[3] = (*place, number)
        rows[4] = _ball(in_view, caster.mesh)
        size = max(size, float(rows[4, 3]))
        # Colours that do not fit are those of the last one.
        first = min(first_colour, CASTER_COLOURS - 1)
        rows[5, :3] = (caster.instance.casts, caster.instance.mirrored, first)
        colours = np.asarray(caster.colours, np.float32)[: CASTER_COLOURS - first]
        at = 1 + 6 * CASTER_CAPACITY + first
        block[at : at + len(colours), :3] = colours
        first_colour += len(colours)
    block[0, :3] = (
        len(casters.casters),
        size * _LEAST_HEIGHT,
        max(min(first_colour, CASTER_COLOURS), 1),
    )
    return block


def _albedo(material: Material, nakago: bool) -> tuple[float, float, float]:
    """Of polished steel black: what it mirrors is not traced on."""
    if isinstance(material, PlainMaterial):
        return material.albedo
    return material.nakago.albedo if nakago else (0.0, 0.0, 0.0)


def _ball(matrix: F64, mesh: MeshData) -> F32:
    """Middle and radius of a ball that holds the mesh's box, in the matrix's space."""
    placed = (box_corners(*mesh.bounds) @ matrix.T)[:, :3]
    middle = placed.mean(axis=0)
    radius = float(np.linalg.norm(placed - middle, axis=1).max())
    return np.asarray((*middle, radius * 1.0001), np.float32)
