"""Cosine Lobes for Blender: a render engine for direct light with exact soft shadows."""

import bpy

from . import bake, engine, panels

_classes = (*panels.classes, *bake.classes, engine.CosineLobesEngine)


def register():
    for cls in _classes:
        bpy.utils.register_class(cls)
    bpy.types.Scene.cosine_lobes = bpy.props.PointerProperty(type=panels.CosineLobesSettings)
    panels.share()


def unregister():
    panels.unshare()
    engine._kept.clear()
    del bpy.types.Scene.cosine_lobes
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
