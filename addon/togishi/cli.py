"""`blender --command togishi render …` and `python -m togishi render …`: render frames without a window."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import bpy

from . import blender_versions, map_images, properties
from .core import atomic, headless, native
from .core.headless import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_OK, RenderOptions, UsageError


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _engine_id(name: str, scene: bpy.types.Scene) -> str:
    return {
        "file": scene.render.engine,
        "togishi": "TOGISHI",
        "cycles": "CYCLES",
        "eevee": blender_versions.eevee_engine(),
        "workbench": "BLENDER_WORKBENCH",
    }[name]


def _open(path: Path) -> None:
    if not path.is_file():
        raise UsageError(f"{path}: no such file")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise UsageError(f"{path}: {str(error).strip()}") from error


def _prepare(options: RenderOptions) -> bpy.types.Scene:
    """The scene with the options applied. Raises UsageError."""
    scene = bpy.context.scene
    if options.scene is not None:
        found = bpy.data.scenes.get(options.scene)
        if found is None:
            names = ", ".join(s.name for s in bpy.data.scenes)
            raise UsageError(f"--scene: {options.scene!r} is not in the file; it has {names}")
        scene = found
    if options.camera is not None:
        camera = scene.objects.get(options.camera)
        if camera is None or camera.type != "CAMERA":
            names = ", ".join(o.name for o in scene.objects if o.type == "CAMERA") or "none"
            raise UsageError(
                f"--camera: {options.camera!r} is not a camera of the scene; it has {names}"
            )
        scene.camera = camera
    if scene.camera is None:
        raise UsageError(
            f"{options.blend}: scene {scene.name!r} has no camera; add one, or name one by --camera"
        )
    try:
        scene.render.engine = _engine_id(options.engine, scene)
    except TypeError as error:
        raise UsageError(f"--engine: {options.engine} is not available here") from error
    if scene.render.engine == "TOGISHI" and native.problem():
        raise UsageError(native.problem())
    if options.width is not None and options.height is not None:
        scene.render.resolution_x, scene.render.resolution_y = options.width, options.height
        scene.render.resolution_percentage = 100
    if options.samples is not None:
        _set_samples(scene, options.samples)
    return scene


def _set_samples(scene: bpy.types.Scene, samples: int) -> None:
    engine = scene.render.engine
    if engine == "TOGISHI":
        if samples > 64:
            raise UsageError(f"--samples: {samples}; the engine Togishi takes 1 to 64")
        scene.togishi.samples = samples
    elif engine == "CYCLES":
        scene.cycles.samples = samples
    elif engine == blender_versions.eevee_engine():
        scene.eevee.taa_render_samples = samples
    else:
        raise UsageError(f"--samples: not for the engine {engine}")


def _objects(scene: bpy.types.Scene) -> set[bpy.types.Object]:
    """The scene's own objects, and those of the collections that they stand for."""
    found: set[bpy.types.Object] = set()
    waiting = list(scene.objects)
    while waiting:
        obj = waiting.pop()
        if obj in found:
            continue
        found.add(obj)
        if obj.instance_type == "COLLECTION" and obj.instance_collection is not None:
            waiting += obj.instance_collection.all_objects
    return found


def _check_inputs(scene: bpy.types.Scene) -> None:
    """Files that the render needs: missing ones would give pink or wrong pictures without a word."""
    problems = []
    for library in bpy.data.libraries:
        path = Path(bpy.path.abspath(library.filepath))
        if not path.is_file():
            problems.append(f"linked library {library.name!r}: no such file: {path}")
    # Of a material that only a fake user keeps nothing is drawn.
    blades = [
        material
        for material in bpy.data.materials
        if material.users > material.use_fake_user and properties.is_blade(material)
    ]
    for material in blades:
        problems += map_images.missing(material)
    for image in bpy.data.images:
        if (
            image.users
            and image.source in {"FILE", "SEQUENCE"}
            and not image.packed_files
            and image.filepath
        ):
            path = Path(bpy.path.abspath(image.filepath, library=image.library))
            sentence = f"no such file: {path}"
            if (
                image.source == "FILE"
                and not path.is_file()
                and not any(sentence in p for p in problems)
            ):
                problems.append(f"image {image.name!r}: {sentence}")
    if not native.problem():
        core = native.core()
        lights = {
            f"light {o.name!r}": properties.light_spectrum(o.data)
            for o in _objects(scene)
            if o.type == "LIGHT"
        }
        lights["world"] = properties.world_spectrum(scene.world)
        metals = {f"material {m.name!r}": properties.metal_spec(m) for m in blades}
        reads = [(core.light_rgb, lights), (lambda metal: core.fresnel_table(metal, "E"), metals)]
        for read, specs in reads:
            for owner, spec in specs.items():
                try:
                    read(spec)
                except core.InputError as error:
                    problems.append(f"{owner}: {error}")
    if problems:
        raise UsageError("\n".join(problems))


def _suffix(scene: bpy.types.Scene, options: RenderOptions) -> str:
    """Set the file format; returns the suffix of its files."""
    name = options.format
    if name is None:
        by_id = {identifier: key for key, (identifier, _suffix) in headless.FORMATS.items()}
        name = by_id.get(scene.render.image_settings.file_format)
        if name is None:
            raise UsageError(
                f"{options.blend}: its output format {scene.render.image_settings.file_format} is not a still "
                f"image that this command writes; choose one by --format: {', '.join(headless.FORMATS)}"
            )
    identifier, suffix = headless.FORMATS[name]
    blender_versions.set_file_format(scene.render.image_settings, identifier)
    return suffix


_stopped = False  # Blender swallows what a handler raises inside an engine; the flag stays


@contextmanager
def _terminable() -> Iterator[None]:
    """SIGTERM, as farms send it, ends like Ctrl-C: temporary files are removed on the way out."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        global _stopped
        _stopped = True
        raise KeyboardInterrupt

    global _stopped
    _stopped = False
    previous = {number: signal.signal(number, stop) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        yield
    finally:
        for number, handler in previous.items():
            if handler is not None:  # None: not installed by Python
                signal.signal(number, handler)


def _render_frame(scene: bpy.types.Scene, frame: int, path: Path) -> None:
    """Raises RuntimeError where the engine fails and UsageError where the picture cannot be saved; `path` is then
    as it was."""
    scene.frame_set(frame)
    try:
        result = bpy.ops.render.render(scene=scene.name, write_still=False)
    finally:
        if _stopped:
            raise KeyboardInterrupt
    if "FINISHED" not in result:
        raise RuntimeError("the render was cancelled")
    image = next((i for i in bpy.data.images if i.type == "RENDER_RESULT"), None)
    if image is None:
        raise RuntimeError("the engine left no picture")
    try:
        with atomic.replacing(path) as temporary:
            # Truncated files raise; a full disk may leave an empty one without an exception.
            image.save_render(str(temporary), scene=scene)
            if temporary.stat().st_size == 0:
                raise OSError("nothing was written")
    except (RuntimeError, OSError) as error:
        reason = str(error).strip().removeprefix("Error: ")
        raise UsageError(
            f"--output: {path} could not be saved ({reason}); allowed: a folder that you may write to, on a disk with free space"
        ) from error


def render(options: RenderOptions) -> int:
    """Render all frames; returns the exit code. Raises UsageError before the first frame."""
    _open(options.blend)
    scene = _prepare(options)
    suffix = _suffix(scene, options)
    frames = options.frames or (scene.frame_current,)
    several = len(frames) > 1
    paths = {
        frame: headless.frame_path(options.output, frame, suffix, several).absolute()
        for frame in frames
    }
    if len(set(paths.values())) < len(frames):
        raise UsageError(f"--output: {options.output!r} gives several frames the same name")
    for folder in {path.parent for path in paths.values()}:
        if sentence := headless.unwritable(folder):
            raise UsageError(sentence)
    _check_inputs(scene)
    todo = frames
    if options.skip_existing:
        todo = tuple(f for f in frames if not (paths[f].is_file() and paths[f].stat().st_size > 0))
        if len(todo) < len(frames):
            say(f"{len(frames) - len(todo)} of {len(frames)} frames are there already")
    failed = 0
    began = time.monotonic()
    for done, frame in enumerate(todo):
        started = time.monotonic()
        try:
            _render_frame(scene, frame, paths[frame])
        except RuntimeError as error:
            failed += 1
            say(f"frame {frame}: {str(error).strip()}")
            continue
        print(f"Saved: '{paths[frame]}'", flush=True)
        now = time.monotonic()
        left = (now - began) / (done + 1) * (len(todo) - done - 1)
        say(
            f"frame {frame}: {now - started:.1f} s, {done + 1} of {len(todo)}, about {left:.0f} s left"
        )
    if failed:
        say(f"{failed} of {len(todo)} frames failed")
        return EXIT_FAILED
    return EXIT_OK


def main(argv: list[str]) -> int:
    """The command; returns its exit code and raises nothing but programming errors."""
    try:
        with _terminable():
            return render(headless.parse(argv))
    except UsageError as error:
        for line in str(error).splitlines():
            say(f"togishi: {line}")
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        say("togishi: stopped")
        return 130
    except SystemExit as end:  # argparse after --help
        return int(end.code or 0)


_command: object | None = None


def register() -> None:
    global _command
    _command = bpy.utils.register_cli_command("togishi", main)


def unregister() -> None:
    global _command
    if _command is not None:
        bpy.utils.unregister_cli_command(_command)
        _command = None
