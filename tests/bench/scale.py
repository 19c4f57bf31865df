"""How the frame time grows with lights, pixels, triangles and maps; what things that are not seen cost; GPU memory.

The scene is the renderer's own data: one bowed sheet of steel that fills most of the picture. Each size grows alone.
"""

from __future__ import annotations

import gc
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import bench_gpu
import numpy as np
from bench_rows import (
    Curve,
    Measurement,
    Row,
    command_line,
    exponent,
    median_and_spread,
    write_measurement,
)

SIZE = (1280, 720)


# --- scenes ---------------------------------------------------------------------------------------


def sheet(triangles: int, *, tangents: bool = True):
    """About so many triangles on a bowed sheet from -1 to 1 that faces +z."""
    from togishi.core.scene_data import MeshData, MeshGroup

    side = max(2, round(math.sqrt(triangles / 2)) + 1)
    at = np.linspace(-1.0, 1.0, side, dtype=np.float32)
    x, y = (grid.ravel() for grid in np.meshgrid(at, at))
    z = 0.1 * (1 - x * x) * (1 - y * y)
    normal = np.column_stack([0.2 * x * (1 - y * y), 0.2 * y * (1 - x * x), np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    corner = np.arange(side * (side - 1), dtype=np.uint32).reshape(side - 1, side)[:, :-1].ravel()
    right, up = corner + 1, corner + side
    faces = np.concatenate(
        [np.column_stack([corner, right, up]), np.column_stack([right, up + 1, up])]
    )
    # Along the sheet, as a blade's strokes; the x axis of the object serves where there are none.
    tangent = np.column_stack([np.ones_like(x), np.zeros_like(x), -normal[:, 0]])
    return MeshData(
        position=np.column_stack([x, y, z]).astype(np.float32),
        normal_part=np.column_stack([normal, np.ones_like(x)]).astype(np.float32),
        uv=np.column_stack([(x + 1) / 2, (y + 1) / 2]).astype(np.float32),
        tangent=tangent.astype(np.float32) if tangents else None,
        groups=(MeshGroup(0, False, faces.astype(np.uint32)),),
    )


def maps(width: int, height: int):
    """A blade's maps of this size: wavy hamon, anisotropic ji, no hadori."""
    import togishi_core
    from togishi.core import packing

    u, v = np.linspace(0, 1, width, dtype=np.float32), np.linspace(0, 1, height, dtype=np.float32)
    w = (v[:, None] < 0.3 + 0.05 * np.sin(60 * u)[None, :]).astype(np.float32)
    lobes = np.zeros((height, width, 4), np.float32)
    lobes[..., 0] = 0.4 * np.sin(200 * u)[None, :]
    lobes[..., 1] = 1.6
    lobes[..., 2] = w
    shape = np.zeros((height, width, 4), np.float32)
    shape[..., 0] = 0.3
    atlas, shapes, levels = togishi_core.pack_mip_atlas(lobes, shape)
    return packing.map_data(atlas, shapes, levels)


def steel(aspect: float, map_data=None):
    from togishi.core.scene_data import BladeMaterial, PlainMaterial, SteelMaterial

    e1 = 0.5 * math.log(aspect)
    smooth, rough = (0.4, e1, 0.0), (1.6, 0.0, 0.0)
    material = SteelMaterial(
        metal="iron_johnson_christy",
        part_lobes=(smooth,) * 8,
        part_weights=(-1.0,) * 8,
        part_rough=(False,) * 8,
        ha=(*rough, -1.0),
        hadori=(*rough, -1.0),
        maps=map_data,
    )
    return BladeMaterial(material, PlainMaterial())


def lights(count: int, **changed):
    from togishi.core.scene_data import Light, LightKind

    spectra = ("D65", "A", "FL11", "LED-B3")
    turns = np.linspace(0, 2 * math.pi, count, endpoint=False)
    return tuple(
        Light(
            LightKind.POINT,
            position=(2 * math.cos(turn), 2 * math.sin(turn), 3.0),
            power=300.0 / count,
            spectrum=spectra[i % len(spectra)],
            **changed,
        )
        for i, turn in enumerate(turns)
    )


def camera():
    """Orthographic; the sheet fills nine tenths of the picture's height and width."""
    from togishi.core.scene_data import Camera

    view = np.eye(4)
    view[2, 3] = -5.0
    projection = np.diag([0.9, 0.9, -0.2, 1.0])
    projection[2, 3] = -1.0
    return Camera(view, projection)


def scene(mesh, material, lamps, **more):
    from togishi.core.scene_data import Instance, SceneData

    return SceneData(
        meshes={"sheet": mesh, **more.pop("meshes", {})},
        instances=(Instance("sheet", np.eye(4), ("steel",)),),
        materials={"steel": material, **more.pop("materials", {})},
        lights=lamps,
        **more,
    )


# --- measuring ------------------------------------------------------------------------------------


def drawer(data, size=SIZE) -> Callable[[int], None]:
    """Draws this scene with a renderer of its own."""
    from togishi.engine.renderer import Renderer

    renderer, view = Renderer(), camera()

    def draw(_frame: int) -> None:
        bench_gpu.finish(renderer.draw(data, view, size).framebuffer)

    return draw


def curve(
    name: str,
    label: str,
    scenes: Mapping[float, Callable[[], Callable[[int], None]]],
    frames: int,
    say: Callable[[str], None],
    fitted_from: float = 0.0,
) -> tuple[Curve, list[Row]]:
    """Frame time of each size, each scene made, measured and let go in its turn: large ones do not fit together."""
    sizes, times, spreads = [], [], []
    for size, make in scenes.items():
        draw = make()
        seconds = bench_gpu.in_turns({"frame": draw}, frames)["frame"]
        middle, spread = median_and_spread(np.array(seconds) * 1e3)
        sizes.append(float(size))
        times.append(middle)
        spreads.append(spread)
        say(f"      {label} {size:,}: {middle:.1f} ms")
        del draw
        gc.collect()
    slope, interval = exponent(sizes, times)
    measured = ", ".join(
        f"{size:,.0f}: {time:.1f}" for size, time in zip(sizes, times, strict=True)
    )
    rows = [
        Row(
            f"scale.{name}.exponent_lo",
            interval[0],
            "",
            1.05,
            "<=",
            interval,
            f"ln(frame time) over ln({label}), lower end of the 95 % interval; medians of {frames} frames in ms: {measured}",
        ),
        Row(f"scale.{name}.exponent", slope, "", spread=interval, how="the fitted exponent itself"),
    ]
    return Curve(label, "frame, ms", tuple(sizes), tuple(times), slope, interval), rows


def cost(
    name: str,
    what: str,
    without: Callable[[int], None],
    with_it: Callable[[int], None],
    frames: int,
) -> list[Row]:
    """What something unseen costs: the median difference of frames measured in turns, as a share of the frame and in
    units of the spread (half the distance of the quartiles) of the frames without it."""
    times = bench_gpu.in_turns({"without": without, "with": with_it}, frames)
    base, added = np.array(times["without"]), np.array(times["with"])
    middle, (low, high) = median_and_spread(base)
    differences = added - base
    difference, quartiles = median_and_spread(differences)
    spread = max((high - low) / 2, 1e-9)
    share = 100 / middle
    how = f"{what}; {frames} frames in turns, median frame {middle * 1e3:.1f} ms"
    return [
        Row(
            f"scale.{name}.cost_in_spreads", max(difference, 0.0) / spread, "", 1.0, "<=", None, how
        ),
        Row(
            f"scale.{name}.cost_percent",
            difference * share,
            "%",
            spread=(quartiles[0] * share, quartiles[1] * share),
            how="the same, of the frame time",
        ),
    ]


def unseen(frames: int, say: Callable[[str], None]) -> list[Row]:
    from togishi.core.scene_data import Instance

    grid, lamps = sheet(80_000), lights(4)
    plain = scene(grid, steel(1.0), lamps)
    dark = replace(lights(1)[0], power=0.0)
    map_data = maps(4096, 512)
    rows = cost(
        "hidden_light",
        "8 lamps without power beside 4 that shine",
        drawer(plain),
        drawer(scene(grid, steel(1.0), (*lamps, *(dark,) * 8))),
        frames,
    )
    say("      hidden light measured")
    rows += cost(
        "unused_map",
        "a material with maps of 4096 x 512 that nothing in the scene uses",
        drawer(plain),
        drawer(scene(grid, steel(1.0), lamps, materials={"mapped": steel(1.0, map_data)})),
        frames,
    )
    say("      unused map measured")
    # Nothing about the isotropic blade uses them, but its mesh carries tangents and its maps a shape image of zeros.
    flat = maps(1024, 256)
    without = replace(flat, shape=None, anisotropic=False)
    zeros = replace(flat, shape=np.zeros_like(flat.shape), anisotropic=False)
    rows += cost(
        "no_anisotropy",
        "an isotropic blade whose mesh carries tangents and whose maps carry a shape image of zeros, against one without both",
        drawer(scene(sheet(80_000, tangents=False), steel(1.0, without), lamps)),
        drawer(scene(grid, steel(1.0, zeros), lamps)),
        frames,
    )
    beside = np.eye(4)
    beside[0, 3] = 100.0
    two = scene(
        grid, steel(1.0), lamps, materials={"anisotropic": steel(4.0)}, meshes={"other": sheet(2)}
    )
    two = replace(two, instances=(*two.instances, Instance("other", beside, ("anisotropic",))))
    rows += [
        row
        for row in cost(
            "other_steel_out_of_view",
            "a second, anisotropic steel beside the picture",
            drawer(plain),
            drawer(two),
            frames,
        )
        if row.bound is None
    ]
    say("      blade without anisotropy measured")
    return rows


def savings(frames: int, say: Callable[[str], None]) -> list[Row]:
    """What leaving code out saves: the frame of a scene that lacks something, against one that has it and is otherwise the
    same; and how many programs all of this can make."""
    from togishi.core.scene_data import LightKind, World

    grid, lamps, iso = sheet(80_000), lights(4), steel(1.0)
    data = maps(4096, 512)
    mapped = replace(data, shape=None, anisotropic=False)
    plain = scene(grid, iso, lamps)
    spots = tuple(replace(lamp, kind=LightKind.SPOT, cone_rad=3.0) for lamp in lamps)
    pairs = {
        "anisotropy": (plain, scene(grid, steel(4.0), lamps)),
        "maps": (plain, scene(grid, steel(1.0, mapped), lamps)),
        "hadori": (
            scene(grid, steel(1.0, mapped), lamps),
            scene(grid, steel(1.0, replace(mapped, hadori=True)), lamps),
        ),
        "spots": (plain, scene(grid, iso, spots)),
        "room": (plain, scene(grid, iso, lamps, world=World((0.1, 0.1, 0.1)))),
    }
    rows = []
    for name, (without, with_it) in pairs.items():
        times = bench_gpu.in_turns(
            {"without": drawer(without), "with": drawer(with_it)}, max(frames // 2, 3)
        )
        saving, spread = median_and_spread(
            100 * (1 - np.array(times["without"]) / np.array(times["with"]))
        )
        rows.append(
            Row(
                f"scale.variant.{name}_saving_percent",
                saving,
                "%",
                spread=spread,
                how=f"frame without {name} against the same with it, {SIZE[0]}x{SIZE[1]}, 4 lamps",
            )
        )
        say(f"      without {name}: {saving:.0f} % less")
    return [*rows, program_count()]


def program_count() -> Row:
    """All different GPU programs of polished steel that a scene can ask for."""
    from itertools import product

    from togishi.core.shader_source import LightVariant, SteelVariant, steel_light_program

    choices = (False, True)
    programs = {
        steel_light_program(LightVariant(*light), SteelVariant(*blade))
        for light in product(choices, repeat=4)
        for blade in product(choices, repeat=5)
    }
    return Row(
        "scale.variant.programs",
        len(programs),
        "",
        how="different programs that light polished steel; each is compiled when a scene first needs it",
    )


def memory(quick: bool) -> list[Row]:
    """Texels, vertices and uniform blocks that are asked for; drivers add their own padding."""
    grid = sheet(80_000)
    rows = []
    for width in (4096,) if quick else (4096, 16384):
        data = scene(grid, steel(1.0, maps(width, 1024)), lights(4))
        with bench_gpu.counted_allocations() as asked:
            drawer(data, (1920, 1080))(0)
        material = data.materials["steel"].steel.maps
        atlases = sum(a.nbytes for a in (material.lobes, material.shape) if a is not None)
        total = sum(asked.values()) + bench_gpu.mesh_bytes(grid)
        parts = {
            "mesh of 80,000 triangles": bench_gpu.mesh_bytes(grid),
            "map atlases": atlases,
            "pictures": asked["textures"] - atlases,
            "uniform blocks": asked["uniforms"],
        }
        described = ", ".join(f"{name} {count / 1e6:.1f}" for name, count in parts.items())
        rows.append(
            Row(
                f"scale.gpu_memory.maps_{width}_mb",
                total / 1e6,
                "MB",
                how=f"1920x1080, maps of {width} x 1024 with all levels, 4 lamps: {described}",
            )
        )
    return rows


def measure(quick: bool, say: Callable[[str], None]) -> Measurement:
    machine = bench_gpu.start()
    frames = 3 if quick else 12
    grid = sheet(80_000)

    def sizes(values: Sequence[float], few: int) -> Sequence[float]:
        return values[:few] if quick else values

    def against_lights(count: float) -> Callable[[], Callable[[int], None]]:
        return lambda: drawer(scene(grid, steel(1.0), lights(int(count))))

    def against_pixels(count: float) -> Callable[[], Callable[[int], None]]:
        width = round(math.sqrt(count * 16 / 9))
        data = scene(grid, steel(1.0), lights(4))
        return lambda: drawer(data, (width, round(count / width)))

    def against_triangles(count: float) -> Callable[[], Callable[[int], None]]:
        return lambda: drawer(scene(sheet(int(count)), steel(1.0), lights(4)))

    def against_map_size(width: float) -> Callable[[], Callable[[int], None]]:
        return lambda: drawer(scene(grid, steel(2.0, maps(int(width), 1024)), lights(4)))

    measurement = Measurement(machine=machine)
    for name, label, values, make in (
        ("lights", "lights", sizes((1, 2, 4, 8, 16, 32, 64), 4), against_lights),
        ("pixels", "pixels", sizes((0.5e6, 1e6, 2e6, 4e6, 8e6), 3), against_pixels),
        ("triangles", "triangles", sizes((1e4, 5e4, 2.5e5, 1e6, 5e6), 3), against_triangles),
        (
            "map_size",
            "width of the maps",
            sizes((1024, 2048, 4096, 8192, 16384), 3),
            against_map_size,
        ),
    ):
        say(f"      {label}")
        found, rows = curve(name, label, {value: make(value) for value in values}, frames, say)
        measurement.curves[name] = found
        measurement.rows += rows
    measurement.rows += unseen(6 if quick else 30, say)
    measurement.rows += savings(6 if quick else 20, say)
    measurement.rows += memory(quick)
    return measurement


if __name__ == "__main__":
    options = command_line(__doc__ or "").parse_args()
    write_measurement(
        options.out, measure(options.quick, lambda text: print(text, file=sys.stdout, flush=True))
    )
    bench_gpu.leave()
