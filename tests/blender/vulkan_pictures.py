"""Pictures of the engine under one GPU backend of Blender 5: `python vulkan_pictures.py OPENGL|VULKAN FILE.npz`.

The bpy module has no way to choose its backend: it takes no command line, and the choice of the preferences is
read where a window is made. So for Vulkan the function behind `--gpu-backend` is called where it lies in the
module, by its place in the symbol table. Exit code 3, with a sentence: this backend does not start here.
"""

from __future__ import annotations

import ctypes
import struct
import sys
from pathlib import Path

import bpy
import numpy as np

SIZE = (128, 96)
_VULKAN = 8  # GPUBackendType
_OVERRIDE = b"_ZN7blender39GPU_backend_type_selection_set_overrideENS_14GPUBackendTypeE"
_SET = b"_ZN7blender30GPU_backend_type_selection_setENS_14GPUBackendTypeE"


class NotHereError(RuntimeError):
    """The backend cannot be had on this machine."""


def _functions(library: Path, names: set[bytes]) -> dict[bytes, int]:
    """Offsets of local symbols of a 64-bit little-endian ELF file."""
    data = np.memmap(library, np.uint8, "r")
    (start,) = struct.unpack_from("<Q", data, 0x28)
    size, count = struct.unpack_from("<HH", data, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, start + size * i) for i in range(count)]
    found = {}
    for section in sections:
        if section[1] != 2:  # SHT_SYMTAB
            continue
        texts = sections[section[6]]
        strings = data[texts[4] : texts[4] + texts[5]].tobytes()
        layout = np.dtype([("name", "<u4"), ("_", "<u4"), ("value", "<u8"), ("size", "<u8")])
        symbols = np.frombuffer(data[section[4] : section[4] + section[5]].tobytes(), layout)
        for name in names:
            at = strings.find(name + b"\0")
            values = symbols["value"][symbols["name"] == at]
            if at >= 0 and len(values):
                found[name] = int(values[0])
    return found


def choose_vulkan() -> None:
    """Before any GPU context. Raises NotHereError."""
    if bpy.app.version < (5, 0, 0):
        raise NotHereError(f"Blender {bpy.app.version_string} has no Vulkan without a window")
    lines = Path("/proc/self/maps").read_text().splitlines()
    mapped = [line.split() for line in lines if line.endswith("/bpy/__init__.so")]
    if not mapped:
        raise NotHereError("bpy is not the wheel's shared library")
    base = min(int(line[0].split("-")[0], 16) for line in mapped)
    places = _functions(Path(mapped[0][-1]), {_OVERRIDE, _SET})
    if len(places) < 2:
        raise NotHereError("bpy's symbols do not say where its choice of backend lies")
    for place in places.values():
        ctypes.CFUNCTYPE(None, ctypes.c_int)(base + place)(_VULKAN)


def pictures() -> dict[str, np.ndarray]:
    import engine_scenes as scenes
    from togishi.core.scene_data import Light, LightKind, PlainMaterial, SceneData, World
    from togishi.engine.renderer import Renderer, read_texture

    rng = np.random.default_rng(11)
    lobes = np.stack(
        [
            rng.uniform(-0.5, 1.0, (32, 64)),
            rng.uniform(1.0, 2.0, (32, 64)),
            rng.uniform(0.0, 1.0, (32, 64)),
            rng.uniform(0.0, 1.0, (32, 64)),
        ],
        -1,
    )
    shape = rng.uniform(-0.5, 0.5, (32, 64, 4))
    lights = (
        scenes.point_light((2.0, -3.0, 4.0), spectrum="A"),
        Light(LightKind.SPOT, position=(-2.0, -4.0, 2.0), power=300.0, cone_rad=1.5, blend=0.5),
        Light(LightKind.SUN, to_light=(0.0, -0.8, 0.6), power=2.0, spectrum="LED-B3"),
    )
    room = World((0.2, 0.25, 0.3))
    camera = scenes.look_at((0.0, -3.5, 0.6))
    mesh = scenes.sphere()
    built = {
        "one lobe": scenes.scene_of(mesh, scenes.isotropic_blade(), lights[:1]),
        "lamps and a room": scenes.scene_of(mesh, scenes.isotropic_blade(), lights, world=room),
        "maps": scenes.scene_of(mesh, scenes.isotropic_blade(maps=scenes.maps_of(lobes)), lights),
        "maps with shape": scenes.scene_of(
            mesh, scenes.isotropic_blade(maps=scenes.maps_of(lobes, shape)), lights, world=room
        ),
    }
    plain = built["lamps and a room"]
    built["no blade"] = SceneData(
        plain.meshes, plain.instances, {"material": PlainMaterial()}, lights, room
    )
    result = {}
    renderer = Renderer()
    for name, scene in built.items():
        result[name] = renderer.draw(scene, camera, SIZE, float32=True).read()
        aux = renderer.draw_aux(scene, camera, SIZE)
        result[f"{name}: depth"] = read_texture(aux.depth)
        result[f"{name}: part"] = read_texture(aux.part)
    return result


def main() -> int:
    backend, file = sys.argv[1:]
    try:
        if backend == "VULKAN":
            choose_vulkan()
        import gpu

        try:
            gpu.init()
        except SystemError as error:
            raise NotHereError(f"gpu.init(): {error}") from error
        if gpu.platform.backend_type_get() != backend:
            raise NotHereError(
                f"asked for {backend}, Blender took {gpu.platform.backend_type_get()} "
                f"({gpu.platform.renderer_get()})"
            )
    except NotHereError as reason:
        print(reason)
        return 3
    print(f"{backend}: {gpu.platform.renderer_get()}, {gpu.platform.version_get()}")
    np.savez(file, **pictures())
    return 0


if __name__ == "__main__":
    sys.exit(main())
