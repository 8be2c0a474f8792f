"""Settings, and which of Blender's panels show for the engine."""

import bpy

#: Panels of Blender that mean nothing to the engine.
_EXCLUDED = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_eevee_performance", "RENDER_PT_simplify"}


class CosineLobesSettings(bpy.types.PropertyGroup):
    """Settings of a scene."""

    tolerance: bpy.props.FloatProperty(
        name="Tolerance",
        description="Error of shadows, as a part of the light without them",
        default=0.005,
        min=0.0005,
        max=0.1,
        precision=4,
    )
    samples: bpy.props.IntProperty(
        name="Pixel Samples",
        description="Rays of the camera in each pixel; 0 for eight at outlines and one elsewhere",
        default=0,
        min=0,
        max=64,
    )
    viewport_tolerance: bpy.props.FloatProperty(
        name="Viewport Tolerance", description="The tolerance in viewports", default=0.02, min=0.0005, max=0.1, precision=4
    )


class RENDER_PT_cosine_lobes(bpy.types.Panel):
    """The engine's settings, in the render properties."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_label = "Cosine Lobes"
    COMPAT_ENGINES = {"COSINE_LOBES"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        self.layout.use_property_split = True
        own = context.scene.cosine_lobes
        for name in ("tolerance", "samples", "viewport_tolerance"):
            self.layout.prop(own, name)
        self.layout.operator("object.cosine_lobes_bake")


def _panels():
    return [p for p in bpy.types.Panel.__subclasses__() if "BLENDER_RENDER" in getattr(p, "COMPAT_ENGINES", ())]


def share():
    """Shows Blender's common panels for the engine."""
    for panel in _panels():
        if panel.__name__ not in _EXCLUDED:
            panel.COMPAT_ENGINES.add("COSINE_LOBES")


def unshare():
    for panel in _panels():
        panel.COMPAT_ENGINES.discard("COSINE_LOBES")


classes = (CosineLobesSettings, RENDER_PT_cosine_lobes)
