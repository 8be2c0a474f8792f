"""A shadow study: how wide a shadow's edge is behind a wall, by the size of the lamp, against a quadrature.

A line of points on a floor behind a wall is lit by a disc; no picture is made. The visible part of the lamp, weighted as the floor
receives it, is one integral over a part of the disc.

    python shadow_study.py [-o study.png]

Without matplotlib only the table is printed.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

import cosine_lobes as cl

# The lamp is so high and so far on the other side of the wall, which is so high and reaches so far to both sides.
HEIGHT, ASIDE, EDGE, FAR = 8.0, -4.0, 2.0, 400.0
Floats = NDArray[np.float64]


def rendered(radius: float, x: Floats) -> Floats:
    """The visible part of the lamp at points of the floor."""
    scene = cl.Scene(size=(8, 8), camera=cl.Camera((0, 5, 9), (0, 0, 0)))
    wall = np.array([[0, 0, -FAR], [0, 0, FAR], [0, EDGE, FAR], [0, EDGE, -FAR]])
    scene.add_mesh(wall, np.array([[0, 1, 2], [0, 2, 3]]), name="wall")
    scene.add_light(cl.Light.disc((ASIDE, HEIGHT, 0), (0, -1, 0), radius, radiance=100))
    renderer = cl.Renderer(scene, tolerance=0.001, depth=6)
    points, normals = np.stack([x, 0 * x, 0 * x], axis=-1), np.tile([0.0, 1.0, 0.0], (len(x), 1))
    light = renderer.shade_layers(points, normals)
    return light["beauty"][:, 0].astype(np.float64) / light["unshadowed"][:, 0]


def integrated(radius: float, x: Floats) -> Floats:
    """The same: the integral of cos θ cos θ' / r² = h²/r⁴ over the part of the disc that is seen above the wall.

    Across the disc it is closed; along x, with x = c + R sin t, 64 Gauss points are exact to 1e-9.
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    # A point at x sees what lies beyond the plane through it and the edge.
    cut = np.clip((x * (1 - HEIGHT / EDGE) - ASIDE) / radius, -1, 1)

    def part(start: Floats) -> Floats:
        half = 0.5 * (np.pi / 2 - start)[:, None]
        t = start[:, None] + half * (nodes + 1)
        a2 = (ASIDE + radius * np.sin(t) - x[:, None]) ** 2 + HEIGHT**2
        z, a = radius * np.cos(t), np.sqrt(a2)
        across = z / (a2 * (a2 + z * z)) + np.arctan(z / a) / (a2 * a)
        return np.sum(half * weights * across * z, axis=1)

    return part(np.arcsin(cut)) / part(np.full_like(x, -np.pi / 2))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("-o", "--output", default="study.png")
    parser.add_argument("-n", "--points", type=int, default=800)
    options = parser.parse_args()
    x = np.linspace(0.4, 2.6, options.points)
    curves = {radius: (rendered(radius, x), integrated(radius, x)) for radius in (0.25, 0.5, 1.0, 2.0)}
    print("radius  penumbra  mean error  largest error")
    for radius, (visible, exact) in curves.items():
        edge = x[(visible > 0.005) & (visible < 0.995)]
        error = np.abs(visible - exact)
        print(f"{radius:6}  {edge[-1] - edge[0]:8.3f}  {error.mean():10.5f}  {error.max():13.5f}")
    try:
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        print("no plot: matplotlib is not installed")
        return
    figure, axes = pyplot.subplots(figsize=(7, 4), layout="constrained")
    for radius, (visible, exact) in curves.items():
        (line,) = axes.plot(x, visible, label=f"lamp of radius {radius}")
        axes.plot(x[::20], exact[::20], ".", color=line.get_color(), markersize=5)
    axes.set_xlabel("distance behind the wall")
    axes.set_ylabel("visible part of the lamp")
    axes.set_title("Lines: rendered. Dots: quadrature.", fontsize=10)
    axes.legend(frameon=False)
    figure.savefig(options.output, dpi=120)
    print(f"wrote {options.output}")


if __name__ == "__main__":
    main()
