"""The meshes that the measurements take."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def knot(around: int = 600, across: int = 24) -> tuple[Floats, NDArray[np.int64]]:
    """A trefoil knot as a tube."""
    t, s = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")

    def curve(t: Floats) -> Floats:
        ring = 0.62 + 0.26 * np.cos(3 * t)
        return np.stack([ring * np.cos(2 * t), 0.62 + 0.36 * np.sin(3 * t), ring * np.sin(2 * t)], axis=-1)

    along = curve(t + 1e-4) - curve(t - 1e-4)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    side = np.cross(along, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    points = curve(t) + 0.13 * (np.cos(s)[..., None] * side + np.sin(s)[..., None] * np.cross(side, along))
    number = np.arange(around * across).reshape(around, across)
    here, next_t = number, np.roll(number, -1, axis=0)
    quads = np.stack([here, next_t, np.roll(next_t, -1, axis=1), np.roll(here, -1, axis=1)], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return points.reshape(-1, 3), triangles


FLOOR = np.array([[-6.0, 0, 6], [6, 0, 6], [6, 0, -6], [-6, 0, -6]]), np.array([[0, 1, 2], [0, 2, 3]])
