"""Settings, and which of Blender's panels show for the engine."""

import bpy

#: Common panels of Blender that mean nothing to the engine.
_EXCLUDED = {"RENDER_PT_freestyle", "DATA_PT_distance"}
#: Panels of EEVEE that mean the same here.
_INCLUDED = {
    "DATA_PT_EEVEE_light",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_EEVEE_light",
}
_NAME = "COSINE_LOBES"


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


class _Panel:
    """What all panels of the engine have in common."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {_NAME}

    @classmethod
    def poll(cls, context):
        return context.engine == _NAME


class RENDER_PT_cosine_lobes(_Panel, bpy.types.Panel):
    """The engine's settings."""

    bl_context = "render"
    bl_label = "Cosine Lobes"

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("tolerance", "samples", "viewport_tolerance"):
            self.layout.prop(context.scene.cosine_lobes, name)
        self.layout.prop(context.scene.render, "film_transparent", text="Transparent Film")
        self.layout.operator("object.cosine_lobes_bake")


class VIEWLAYER_PT_cosine_lobes(_Panel, bpy.types.Panel):
    """Passes and light groups of a view layer."""

    bl_context = "view_layer"
    bl_label = "Passes"

    def draw(self, context):
        self.layout.use_property_split = True
        layer = context.view_layer
        self.layout.prop(layer, "use_pass_z", text="Depth")
        self.layout.prop(layer, "use_pass_normal", text="Normal")
        self.layout.label(text="Light Groups")
        row = self.layout.row()
        row.template_list("UI_UL_list", "lightgroups", layer, "lightgroups", layer, "active_lightgroup_index", rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")


class OBJECT_PT_cosine_lobes(_Panel, bpy.types.Panel):
    """The light group of an object, and which rays see it."""

    bl_context = "object"
    bl_label = "Cosine Lobes"

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop_search(context.object, "lightgroup", context.view_layer, "lightgroups", text="Light Group")
        if context.object.type != "LIGHT":
            self.layout.prop(context.object, "visible_camera", text="Camera")
            self.layout.prop(context.object, "visible_shadow", text="Shadow")


class WORLD_PT_cosine_lobes(_Panel, bpy.types.Panel):
    """The light group of the world."""

    bl_context = "world"
    bl_label = "Cosine Lobes"

    @classmethod
    def poll(cls, context):
        return context.engine == _NAME and context.world is not None

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop_search(context.world, "lightgroup", context.view_layer, "lightgroups", text="Light Group")


def _is_shared(panel):
    common = "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__ not in _EXCLUDED
    return common or panel.__name__ in _INCLUDED


def share():
    """Shows Blender's panels that suit the engine."""
    for panel in filter(_is_shared, bpy.types.Panel.__subclasses__()):
        panel.COMPAT_ENGINES.add(_NAME)


def unshare():
    for panel in filter(_is_shared, bpy.types.Panel.__subclasses__()):
        panel.COMPAT_ENGINES.discard(_NAME)


classes = (
    CosineLobesSettings,
    RENDER_PT_cosine_lobes,
    VIEWLAYER_PT_cosine_lobes,
    OBJECT_PT_cosine_lobes,
    WORLD_PT_cosine_lobes,
)
