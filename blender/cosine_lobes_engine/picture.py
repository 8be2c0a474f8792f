"""Pictures as Blender takes them: premultiplied RGBA and passes, the lower row first."""

import numpy as np


def rgba(radiance, coverage, behind, is_transparent):
    """The picture over what is behind it, `(height, width, 4)`."""
    alpha = coverage[..., None]
    if is_transparent:
        return np.concatenate([radiance, alpha], axis=2)
    return np.concatenate([radiance + (1 - alpha) * behind, np.ones_like(alpha)], axis=2)


def render(live, view, *, is_transparent=False, progress=None):
    """The picture of a view that `live` shows."""
    renderer = live.renderer
    radiance = renderer.render(window=view.window, progress=progress)
    return rgba(radiance, renderer.coverage(window=view.window), live.behind(view), is_transparent)


def render_passes(live, view, wanted, *, is_transparent=False, progress=None):
    """The picture, and passes by their names: "Depth", "Normal" and a list of light groups."""
    renderer = live.renderer
    names = [name for name, layer in (("depth", "Depth"), ("normal", "Normal")) if layer in wanted["passes"]]
    names += ["lights"] if wanted["groups"] else []
    layers = renderer.layers(names, window=view.window, progress=progress)
    coverage = renderer.coverage(window=view.window)
    behind = live.behind(view)
    made = {"Combined": rgba(layers["beauty"], coverage, behind, is_transparent)}
    if "Depth" in wanted["passes"]:
        made["Depth"] = _depth(layers["depth"], view)[..., None]
    if "Normal" in wanted["passes"]:
        made["Normal"] = layers["normal"]
    groups = live.groups
    for group in wanted["groups"]:
        total = sum((layers[f"light{n}"] for n, g in enumerate(groups) if g == group), np.zeros_like(layers["beauty"]))
        is_sky = group == live.sky_group and not is_transparent
        picture = rgba(total, coverage, behind, False) if is_sky else np.concatenate([total, np.ones_like(coverage)[..., None]], axis=2)
        made[f"Combined_{group}"] = picture[..., :3]
    return made


def _depth(distance, view):
    """Blender's depth is along the camera's axis, and 1e10 where there is nothing."""
    x, y, width, height = view.window
    pitch = 2 * np.tan(np.radians(view.fov) / 2) / view.frame[1]
    across = (np.arange(width) + x + 0.5 - view.frame[0] / 2) * pitch
    down = (np.arange(height) + y + 0.5 - view.frame[1] / 2) * pitch
    along = distance / np.sqrt(1 + across[None, :] ** 2 + down[:, None] ** 2)
    return np.where(np.isfinite(distance) & (distance > 0), along, 1e10).astype(np.float32)


def flat(picture):
    """Row by row from below, as `rect` wants it."""
    return np.ascontiguousarray(picture[::-1], dtype=np.float32).ravel()
