"""Settings of the engine, with their panels."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from . import passes

ENGINE = "VELLUS"


class VellusSettings(bpy.types.PropertyGroup):
    """Settings of a scene."""

    samples: IntProperty(name="Samples", description="Samples a pixel", default=64, min=1, max=1 << 20)
    preview_samples: IntProperty(
        name="Viewport Samples", description="Samples a pixel in the viewport", default=16, min=1, max=1 << 20
    )
    noise: FloatProperty(
        name="Noise Limit",
        description="Stop when the estimated noise is this low. 0 takes all samples",
        default=0.0,
        min=0.0,
        max=1.0,
        precision=3,
    )
    time: FloatProperty(
        name="Time Limit", description="Stop after this many seconds. 0 takes all samples", default=0.0, min=0.0
    )
    mode: EnumProperty(
        name="Fibres",
        description="Over which part of a fibre's width its reflectance is averaged",
        items=[
            ("multiscale", "Multi-Scale", "What the pixel sees of the fibre: the least noise"),
            ("near", "Near Field", "The point that is hit"),
            ("far", "Far Field", "The whole width of the fibre"),
        ],
    )
    seed: IntProperty(name="Seed", description="Seed of the random numbers", default=0, min=0)
    denoise: BoolProperty(
        name="Denoise", description="Denoise the picture. This needs Intel Open Image Denoise", default=False
    )


class VellusLayerSettings(bpy.types.PropertyGroup):
    """Settings of a view layer."""

    use_pass_albedo: BoolProperty(name="Albedo", description="The share of white light that the first hit reflects")
    use_pass_lobes: BoolProperty(name="Lobes", description="One pass for each lobe of the fibres at the first hit")


class Panel:
    """A panel of this engine in the properties editor."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


class VELLUS_PT_sampling(Panel, bpy.types.Panel):
    """Samples, limits and mode."""

    bl_label = "Sampling"
    bl_context = "render"

    def draw(self, context):
        layout, settings = self.layout, context.scene.vellus
        layout.use_property_split = True
        for name in ("samples", "preview_samples", "noise", "time", "mode", "seed", "denoise"):
            layout.prop(settings, name)


class VELLUS_PT_film(Panel, bpy.types.Panel):
    """Transparent background and motion blur."""

    bl_label = "Film and Motion Blur"
    bl_context = "render"

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.use_property_split = True
        layout.prop(render, "film_transparent", text="Transparent")
        layout.prop(render, "use_motion_blur")
        column = layout.column()
        column.active = render.use_motion_blur
        column.prop(render, "motion_blur_position", text="Position")
        column.prop(render, "motion_blur_shutter")


class VELLUS_PT_passes(Panel, bpy.types.Panel):
    """Passes of a view layer."""

    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout, layer = self.layout, context.view_layer
        layout.use_property_split = True
        for name in ("use_pass_z", "use_pass_normal"):
            layout.prop(layer, name)
        for name in ("use_pass_albedo", "use_pass_lobes"):
            layout.prop(layer.vellus, name)
        for name in ("use_pass_cryptomatte_object", "use_pass_cryptomatte_material"):
            layout.prop(layer, name)


def update_passes(layer, context):
    """The compositor shows the passes of a layer."""
    layer.update_render_passes()


def panels_of_blender():
    """Blender's own panels that also make sense for this engine: those of its simplest engine."""
    excluded = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes"}
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if "BLENDER_RENDER" in engines and panel.__name__ not in excluded:
            yield panel


EXTRA = ("CYCLES_LIGHT_PT_light", "CYCLES_WORLD_PT_surface")
CLASSES = (VellusSettings, VellusLayerSettings, VELLUS_PT_sampling, VELLUS_PT_film, VELLUS_PT_passes)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.vellus = PointerProperty(type=VellusSettings)
    bpy.types.ViewLayer.vellus = PointerProperty(type=VellusLayerSettings)
    for panel in panels_of_blender():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in panels_of_blender():
        panel.COMPAT_ENGINES.discard(ENGINE)
    del bpy.types.ViewLayer.vellus
    del bpy.types.Scene.vellus
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
