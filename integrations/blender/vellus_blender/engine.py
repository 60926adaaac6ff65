"""The render engine: F12, animation and the viewport."""

import bpy
import numpy as np

from . import passes, settings, viewport
from .extract import Problem, extract
from .extract.camera import without_shift
from .extract.particles import Cache

# Strands of particle systems are kept between frames.
CACHE = Cache()

# Warnings of this render job, so that an animation says each once.
SAID = set()


class Stopped(Exception):
    """The user cancelled."""


@bpy.app.handlers.persistent
def forget(*_):
    """A new render job says its warnings again."""
    SAID.clear()


def cropped(scene):
    """The size of the whole picture, and the part to render: left, top, width, height."""
    render = scene.render
    width = max(int(render.resolution_x * render.resolution_percentage / 100), 1)
    height = max(int(render.resolution_y * render.resolution_percentage / 100), 1)
    if not render.use_border:
        return (width, height), (0, 0, width, height)
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    right, top = max(right, left + 1), max(top, bottom + 1)
    return (width, height), (left, height - top, right - left, top - bottom)


def layer_of(picture, layer, shape, is_transparent):
    """A layer as (h, w, c). Missing layers are zeros: a group of lights may be empty."""
    if layer == "combined":
        alpha = picture["alpha"] if is_transparent else np.ones(shape, np.float32)
        return np.concatenate([picture["beauty"], alpha.reshape(*shape, 1)], 2)
    layer, _, part = layer.partition(".")
    found = picture.get(layer)
    if found is None:
        return None
    if layer in ("lobes", "lights"):
        names = picture.lobes if layer == "lobes" else picture.light_groups
        return found[:, :, names.index(part)] if part in names else None
    if part:
        # Two ranks of an id and its coverage in each pass.
        return found[:, :, 4 * int(part) : 4 * int(part) + 4]
    if layer == "depth":
        # Vellus writes 0 where nothing is, Blender a large distance.
        return np.where(found > 0, found, 1e10)
    return found


class VellusEngine(bpy.types.RenderEngine):
    """Renders with Vellus."""

    bl_idname = settings.ENGINE
    bl_label = "Vellus"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

    preview = None

    def warn(self, texts):
        """Reports each text once in a job."""
        for text in texts:
            if text not in SAID:
                SAID.add(text)
                self.report({"WARNING"}, f"Vellus: {text}")

    def fail(self, text):
        """Reports an error. The picture stays empty."""
        self.report({"ERROR"}, f"Vellus: {text}")

    def update_render_passes(self, scene=None, renderlayer=None):
        """Tells the compositor about the passes."""
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for p in passes.passes_of(renderlayer):
            self.register_pass(scene, renderlayer, p.name, p.channels, p.letters, p.kind)

    def is_cancelled(self):
        """Whether the user cancelled. A method of its own, because Blender's cannot be replaced in tests."""
        return self.test_break()

    def progress(self, text):
        """Shows what is being done, and stops if the user cancelled."""
        self.update_stats("", text)
        if self.is_cancelled():
            raise Stopped

    def render(self, depsgraph):
        """Renders one view layer of one frame."""
        try:
            self.render_layer(depsgraph)
        except Problem as problem:
            self.fail(str(problem))
        except Stopped:
            pass
        except (ValueError, MemoryError, OSError) as error:
            self.fail(str(error) or type(error).__name__)

    def render_layer(self, depsgraph):
        """As `render`, with exceptions."""
        scene, view_layer = depsgraph.scene, depsgraph.view_layer
        size, crop = cropped(scene)
        wanted = passes.passes_of(view_layer)
        is_transparent, layer_name = scene.render.film_transparent, view_layer.name
        names = ("samples", "noise", "time", "mode", "seed", "denoise")
        options = {name: getattr(scene.vellus, name) for name in names}
        if names := passes.unsupported(view_layer):
            self.warn([f"passes that are not supported: {', '.join(names)}"])
        if scene.render.pixel_aspect_x != scene.render.pixel_aspect_y:
            self.warn(["pixels are square: the pixel aspect is ignored"])
        description = extract(
            depsgraph,
            width=size[0],
            height=size[1],
            cache=CACHE,
            progress=self.progress,
            set_time=self.frame_set,
        )
        self.warn(description.warnings)
        self.progress("Building the scene")
        try:
            from . import render
        except ImportError as error:
            raise Problem(f"the Python package vellus cannot be loaded: {error}") from error

        description.camera, large, part = without_shift(description.camera, size, crop)
        work = render.scene_of(description, is_transparent)
        self.warn(description.warnings)
        result = self.begin_result(0, 0, crop[2], crop[3], layer=layer_name)
        for p in wanted:
            self.add_pass(p.name, p.channels, p.letters, layer=layer_name)
        is_cancelled = False

        def show(picture, done, text):
            self.fill(result, picture, wanted, crop, is_transparent)
            self.update_result(result)
            self.update_progress(done)
            self.update_stats("", text)
            return not self.is_cancelled()

        try:
            picture = render.run(work, large, part, passes.layers_of(wanted), options, show)
            is_cancelled = self.is_cancelled()
            # Fields of a part are not kept: those of the whole result are.
            whole = self.get_result()
            for field, text in passes.cryptomatte_fields(picture, wanted, layer_name):
                whole.stamp_data_add_field(field, text)
            self.fill(result, picture, wanted, crop, is_transparent)
        finally:
            self.end_result(result, cancel=is_cancelled)

    def fill(self, result, picture, wanted, crop, is_transparent):
        """Copies layers into passes, bottom row first."""
        shape = (crop[3], crop[2])
        by_name = {p.name: p for p in wanted}
        for target in result.layers[0].passes:
            p = by_name.get(target.name)
            layer = "combined" if target.name == "Combined" else p.layer if p else None
            values = layer_of(picture, layer, shape, is_transparent) if layer else None
            if values is not None:
                values = np.broadcast_to(values.reshape(*shape, -1), (*shape, target.channels))
                target.rect.foreach_set(np.ascontiguousarray(values[::-1], np.float32).ravel())

    def view_update(self, context, depsgraph):
        """Something changed: the picture starts again at the next `view_draw`."""
        if self.preview:
            self.preview.cancel()

    def view_draw(self, context, depsgraph):
        """Draws the newest pixels, and starts a new picture if the view changed."""
        region, view = context.region, context.region_data
        size = (region.width, region.height)
        if self.preview is None:
            self.preview = viewport.Preview(self.tag_redraw)
        key = (size, tuple(map(tuple, view.view_matrix)), tuple(map(tuple, view.window_matrix)))
        if not self.preview.is_current(key):
            self.start_preview(depsgraph, key, size, viewport.camera_of_view(view.view_matrix, view.window_matrix))
        if self.preview.error:
            self.update_stats("", self.preview.error)
        pixels = self.preview.newest(size)
        if pixels is not None:
            viewport.draw(pixels, self, depsgraph.scene)

    def start_preview(self, depsgraph, key, size, camera):
        """Reads the scene and starts the thread of the preview."""
        from . import render

        scene = depsgraph.scene
        options = {"samples": scene.vellus.preview_samples, "mode": scene.vellus.mode, "seed": scene.vellus.seed}
        try:
            found = extract(depsgraph, width=size[0], height=size[1], is_render=False, cache=CACHE, camera=camera)
            found.camera, large, part = without_shift(found.camera, size, (0, 0, *size))
            work = render.scene_of(found, scene.render.film_transparent)
        except (Problem, ValueError) as problem:
            self.preview.cancel()
            self.preview.key, self.preview.error = key, str(problem)
            return
        shape, is_transparent = (size[1], size[0]), scene.render.film_transparent

        def job(show):
            def step(picture, done, text):
                show(layer_of(picture, "combined", shape, is_transparent), done)
                return True

            picture = render.run(work, large, part, [], options, step)
            show(layer_of(picture, "combined", shape, is_transparent), 1.0)

        self.preview.start(key, job)

    def __del__(self):
        try:
            preview = self.preview
        except ReferenceError:
            # Blender removed its part of the engine first. The thread of a preview holds no data of Blender.
            return
        if preview:
            preview.cancel()


def register():
    bpy.utils.register_class(VellusEngine)
    bpy.app.handlers.render_init.append(forget)


def unregister():
    bpy.app.handlers.render_init.remove(forget)
    bpy.utils.unregister_class(VellusEngine)
    CACHE.clear()
