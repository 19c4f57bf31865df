"""Blender's side of the engine: thin callers of Renderer for viewports and final renders."""

from __future__ import annotations

import time
import traceback

import bpy

from .. import graphics
from ..core import native
from ..core.scene_data import SceneData
from .camera_read import Region, border_region, region_camera, render_camera, whole_size
from .final_render import FinalPicture, render_final
from .programs import ShaderError
from .renderer import Gathering, Picture, Renderer, lod_bias_of
from .scene_sync import SceneSync

PART_PASS = "Togishi Part"
# After so long without a change the viewport is refined.
REST_S = 0.1


class _Viewport:
    """What one viewport keeps between its pictures."""

    def __init__(self) -> None:
        self.renderer = Renderer()
        self.sync = SceneSync()
        self.scene: SceneData | None = None
        self.gathering: Gathering | None = None
        self.gathered: tuple[object, ...] = ()
        self.moving: Picture | None = None  # what is shown while something moves
        self.moving_step = 1  # side of its pixels, in the screen's
        self.step = 1  # of the next one
        self.moved_s = 0.0


class TogishiRenderEngine(bpy.types.RenderEngine):
    """Japanese swords from measured spectra, in real time."""

    bl_idname = "TOGISHI"
    bl_label = "Togishi"
    bl_use_preview = True
    bl_use_gpu_context = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True  # material preview shading stays EEVEE's

    def __init__(self, *args: object, **keywords: object) -> None:
        super().__init__(*args, **keywords)
        self._viewport: _Viewport | None = None

    # --- final render ---------------------------------------------------------------------------

    def update_render_passes(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> None:
        self.register_pass(scene, layer, "Combined", 4, "RGBA", "COLOR")
        settings = getattr(scene, "togishi", None)
        if layer.use_pass_z or getattr(settings, "use_pass_depth", False):
            self.register_pass(scene, layer, "Depth", 1, "Z", "VALUE")
        if getattr(settings, "use_pass_part", False):
            self.register_pass(scene, layer, PART_PASS, 1, "X", "VALUE")

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        reason = native.problem() or graphics.problem()
        if reason:
            self._fail(reason)
            return
        scene = depsgraph.scene_eval
        settings = getattr(scene, "togishi", None)
        camera = self.camera_override or scene.camera
        if camera is None:
            self._fail(f"Scene {scene.name!r} has no camera.")
            return
        if scene.render.use_multiview:
            self._fail("Togishi renders no stereoscopy; switch it off in the output properties.")
            return
        if camera.type == "CAMERA" and camera.data.type == "PANO":
            self._tell([f"Camera {camera.name!r} is panoramic; it is drawn as a perspective one."])
        layer = depsgraph.view_layer_eval
        want_depth = layer.use_pass_z or getattr(settings, "use_pass_depth", False)
        want_part = getattr(settings, "use_pass_part", False)
        size = whole_size(scene.render)
        region = border_region(scene.render, size)
        sync, renderer = SceneSync(), Renderer()
        try:
            data = sync.update(depsgraph)
            self._tell(sync.messages)
            picture = render_final(
                renderer,
                data,
                render_camera(self, depsgraph, camera),
                size,
                region,
                samples=1 if self.is_preview else getattr(settings, "samples", 16),
                filter_width=scene.render.filter_size,
                depth=want_depth,
                part=want_part,
                progress=self._progress,
            )
            self._tell(renderer.problems)
            if picture is not None:
                self._hand_over(picture, region, layer.name)
        except (ShaderError, native.CoreMissingError, ValueError) as error:
            self._fail(str(error))
            return
        except Exception as error:
            self._fail(f"The engine Togishi failed: {error!r}; the console says where.")
            raise

    def _hand_over(self, picture: FinalPicture, region: Region, layer: str) -> None:
        # Counted from the border's corner, whether the picture is cropped to it or not.
        result = self.begin_result(0, 0, region.width, region.height, layer=layer)
        passes = result.layers[0].passes
        for name, values in (
            ("Combined", picture.colour),
            ("Depth", picture.depth),
            (PART_PASS, picture.part),
        ):
            if values is not None and name in passes:
                passes[name].rect = values.reshape(-1, values.shape[-1])
        self.end_result(result)

    def _progress(self, share: float) -> bool:
        self.update_progress(share)
        return not self.test_break()

    def _fail(self, reason: str) -> None:
        """Shown in the render window; and reported, without which Blender calls a black picture finished."""
        self.error_set(reason)
        self.report({"ERROR"}, reason)

    def _tell(self, messages: list[str]) -> None:
        # A preview's scene is Blender's own: its lights are nothing the user could change.
        for message in () if self.is_preview else messages:
            self.report({"WARNING"}, message)

    # --- viewport -------------------------------------------------------------------------------

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        if native.problem():
            return
        if self._viewport is None:
            self._viewport = _Viewport()
        try:
            self._viewport.scene = self._viewport.sync.update(depsgraph, context.space_data)
        except Exception as error:
            self._viewport = None  # half of an update is read; the next begins anew
            self._show(error)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        reason = native.problem() or graphics.problem()
        if reason:
            self.update_stats("Togishi", reason)
            return
        if self._viewport is None or self._viewport.scene is None:
            self.view_update(context, depsgraph)
        view = self._viewport
        if view is None or view.scene is None:
            return  # view_update said why
        try:
            self._draw(context, depsgraph, view, view.scene)
        except Exception as error:
            self._show(error)
            return
        notes = [*view.sync.messages, *view.renderer.problems]
        self.update_stats("Togishi", "  |  ".join(notes))

    def _show(self, error: Exception) -> None:
        """In the viewport's corner; what was not foreseen also with its place in the console."""
        if isinstance(error, ShaderError | native.CoreMissingError | ValueError):
            self.update_stats("Togishi", str(error))
            return
        traceback.print_exception(error)
        self.update_stats(
            "Togishi", f"The engine Togishi failed: {error!r}; the console says where."
        )

    def _draw(
        self,
        context: bpy.types.Context,
        depsgraph: bpy.types.Depsgraph,
        view: _Viewport,
        scene: SceneData,
    ) -> None:
        region = context.region
        size = (region.width, region.height)
        camera = region_camera(context.region_data)
        settings = getattr(depsgraph.scene_eval, "togishi", None)
        wanted = max(int(getattr(settings, "viewport_samples", 1)), 1)
        # While something moves: one sample, lamps of a size roughly. When nothing does: those refined, samples added up.
        still = (scene, size, camera.view.tobytes(), camera.projection.tobytes(), wanted)
        moved = view.gathered != still
        if moved:
            view.gathered = still
            if view.gathering is not None:
                view.gathering.restart()
        renderer = view.renderer
        sized = any(light.sized and not light.dark for light in scene.lights) or (
            scene.world.environment is not None and not scene.world.black
        )
        if not sized:
            view.moving = None
            if wanted == 1:
                renderer.copy(renderer.draw(scene, camera, size).colour, blend="ALPHA_PREMULT")
                return
        elif moved:
            view.moving_step = view.step
            view.moving, view.step = renderer.draw_moving(scene, camera, size, view.step)
            view.moved_s = time.monotonic()
        if view.moving is not None:
            if time.monotonic() - view.moved_s < REST_S:
                # The next movement is not kept waiting for a refined picture that nobody will look at.
                renderer.copy(view.moving.colour, blend="ALPHA_PREMULT", step=view.moving_step)
                self.tag_redraw()
                return
            view.moving = None
        gathering = view.gathering
        if gathering is None or gathering.size != size:
            gathering = view.gathering = Gathering(renderer, size)
        if gathering.samples < wanted:
            offset = gathering.offset(wanted, depsgraph.scene_eval.render.filter_size)
            bias = lod_bias_of(wanted) if gathering.samples else 0.0
            number = (gathering.samples, wanted)
            gathering.add(
                renderer.draw(scene, camera, size, jitter=offset, lod_bias=bias, added=number)
            )
            if gathering.samples < wanted:
                self.tag_redraw()
        renderer.copy(gathering.texture, 1.0 / gathering.samples, blend="ALPHA_PREMULT")


def register() -> None:
    bpy.utils.register_class(TogishiRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(TogishiRenderEngine)
