"""Pictures as Blender takes them: premultiplied RGBA and passes, the lower row first."""

import numpy as np


def over(live, view, radiance, is_transparent):
    """The picture with alpha, `(height, width, 4)`: of a transparent film without the sky behind surfaces, which the engine shows."""
    if not is_transparent:
        return np.concatenate([radiance, np.ones_like(radiance[..., :1])], axis=2)
    alpha = live.renderer.coverage(window=view.window)[..., None]
    return np.concatenate([np.maximum(radiance - (1 - alpha) * live.behind(view), 0) * (alpha > 0), alpha], axis=2)


def render(live, view, *, is_transparent=False, progress=None):
    """The picture of a view that `live` shows."""
    radiance = live.renderer.render(window=view.window, progress=progress)
    return over(live, view, radiance, is_transparent)


def render_passes(live, view, wanted, *, is_transparent=False, progress=None):
    """The picture, and passes by their names: "Depth", "Normal" and a list of light groups."""
    renderer = live.renderer
    names = [name for name, layer in (("depth", "Depth"), ("normal", "Normal")) if layer in wanted["passes"]]
    names += ["lights"] if wanted["groups"] else []
    layers = renderer.layers(names, window=view.window, progress=progress)
    made = {"Combined": over(live, view, layers["beauty"], is_transparent)}
    if "Depth" in wanted["passes"]:
        made["Depth"] = _depth(layers["depth"])[..., None]
    if "Normal" in wanted["passes"]:
        made["Normal"] = layers["normal"]
    groups = live.groups
    for group in wanted["groups"]:
        total = sum((layers[f"light{n}"] for n, g in enumerate(groups) if g == group), np.zeros_like(layers["beauty"]))
        if group == live.sky_group and not is_transparent:
            total = total + (1 - renderer.coverage(window=view.window)[..., None]) * live.behind(view)
        made[f"Combined_{group}"] = total
    return made


def _depth(depth):
    """As the engine's, along the camera's axis; but 1e10 where there is nothing."""
    return np.where(np.isfinite(depth) & (depth > 0), depth, 1e10).astype(np.float32)


def flat(picture):
    """Row by row from below, as `rect` wants it."""
    return np.ascontiguousarray(picture[::-1], dtype=np.float32).ravel()
