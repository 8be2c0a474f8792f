"""Soft shadows and glossy light from area lights, without noise.

    import cosine_lobes as cl

    scene = cl.Scene.load("scene.toml")
    picture = cl.Renderer(scene).render()  # linear radiance, float32, (height, width, 3)

A Renderer keeps what the next picture can use: a light that moves rebuilds nothing. Lengths may have any unit, angles are in
degrees, world space is right-handed with y up, and radiance is linear.
"""

from ._native import (
    Camera,
    EditError,
    Environment,
    Light,
    LightHandle,
    LobesError,
    LobesWarning,
    Material,
    MaterialHandle,
    ObjectHandle,
    Pick,
    Renderer,
    RenderError,
    Scene,
    SceneError,
    Settings,
    SphereSet,
    bake,
    compare,
    cut_out,
    exposed,
    read_exr,
    reference,
    write_exr,
    write_png,
)

__all__ = [
    "Camera",
    "EditError",
    "Environment",
    "Light",
    "LightHandle",
    "LobesError",
    "LobesWarning",
    "Material",
    "MaterialHandle",
    "ObjectHandle",
    "Pick",
    "RenderError",
    "Renderer",
    "Scene",
    "SceneError",
    "Settings",
    "SphereSet",
    "bake",
    "compare",
    "cut_out",
    "exposed",
    "read_exr",
    "reference",
    "write_exr",
    "write_png",
]
