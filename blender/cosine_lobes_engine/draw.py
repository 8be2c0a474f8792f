"""A picture on the screen, in the scene's display space."""

from . import picture


def show(engine, scene, region, pixels, drawn):
    """Draws a picture over a region. Returns what the next call may use again: the picture and its texture."""
    import gpu
    from gpu_extras.presets import draw_texture_2d

    if drawn is None or drawn[0] is not pixels:
        height, width = pixels.shape[:2]
        buffer = gpu.types.Buffer("FLOAT", width * height * 4, picture.flat(pixels))
        drawn = (pixels, gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer))
    gpu.state.blend_set("ALPHA_PREMULT")
    engine.bind_display_space_shader(scene)
    draw_texture_2d(drawn[1], (0, 0), region.width, region.height)
    engine.unbind_display_space_shader()
    gpu.state.blend_set("NONE")
    return drawn
