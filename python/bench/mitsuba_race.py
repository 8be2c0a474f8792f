"""Races Mitsuba 3 through both Python interfaces, at equal error, on the same arrays and the same cores.

    python mitsuba_race.py [--size 480 270] [--targets 0.01 0.003] [--json race.json]

Both render direct light of the same meshes. Errors are those of the floor's pixels in penumbra that show no outline: the mean difference from a
reference, as a part of the radiance without shadows. The reference is this library's own Monte Carlo, which has no code in common
with what is measured; how far Mitsuba at its most samples is from it is printed as well. Times are the shortest of some repetitions,
after one picture that builds hierarchies and kernels, and include finding the visible points: the renderer keeps none.
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

import cosine_lobes as cl
from knot import FLOOR, knot

try:
    import mitsuba as mi
except ImportError:
    sys.exit("mitsuba is not installed (pip install mitsuba)")

Floats = NDArray[np.float64]
Image = NDArray[np.float32]
EYE, TARGET, FOV = (2.4, 2.6, 4.2), (0.0, 0.55, 0.0), 38.0
ALBEDO: dict[str, Any] = {"floor": 0.5, "knot": (0.7, 0.25, 0.15)}
LIGHTS: dict[str, Any] = {
    "sphere": {"center": (-2.0, 3.5, 1.5), "radius": 0.5, "radiance": 20.0},
    "rectangle": {"center": (-1.5, 3.5, 1.0), "u": (0.8, 0, 0), "v": (0, 0, 0.5), "radiance": 10.0},
}


def own_scene(kind: str, size: tuple[int, int]) -> cl.Scene:
    scene = cl.Scene(size=size, camera=cl.Camera(EYE, TARGET, fov=FOV))
    scene.add_mesh(*FLOOR, name="floor", material=cl.Material.lambert(ALBEDO["floor"]), visibility="none")
    scene.add_mesh(*knot(), name="knot", material=cl.Material.lambert(ALBEDO["knot"]))
    light = LIGHTS[kind]
    if kind == "sphere":
        scene.add_light(cl.Light.sphere(light["center"], light["radius"], radiance=light["radiance"]))
    else:
        # Shines downward: toward u x v.
        scene.add_light(cl.Light.rectangle(light["center"], light["v"], np.negative(light["u"]), radiance=light["radiance"]))
    return scene


def other_scene(kind: str, size: tuple[int, int], folder: Path) -> Any:
    def mesh(name: str, positions: Floats, triangles: NDArray[np.int64]) -> dict[str, Any]:
        made = mi.Mesh(name, len(positions), len(triangles))
        parameters = mi.traverse(made)
        parameters["vertex_positions"] = positions.astype(np.float32).ravel()
        parameters["faces"] = triangles.astype(np.uint32).ravel()
        parameters.update()
        made.write_ply(str(folder / f"{name}.ply"))
        color = {"type": "rgb", "value": ALBEDO[name]}
        bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": color}}
        return {"type": "ply", "filename": str(folder / f"{name}.ply"), "face_normals": True, "bsdf": bsdf}

    light = LIGHTS[kind]
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": light["radiance"]}}
    if kind == "sphere":
        lamp = {"type": "sphere", "center": light["center"], "radius": light["radius"], "emitter": emitter}
    else:
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = light["v"], np.negative(light["u"]), (0, -1, 0), light["center"]
        lamp = {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix.tolist()), "emitter": emitter}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct", "hide_emitters": True, "emitter_samples": 1, "bsdf_samples": 0},
            "sensor": {
                "type": "perspective",
                "fov": FOV,
                "fov_axis": "y",
                "to_world": mi.ScalarTransform4f().look_at(origin=EYE, target=TARGET, up=(0, 1, 0)),
                "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"},
                "sampler": {"type": "independent"},
            },
            "floor": mesh("floor", *FLOOR),
            "knot": mesh("knot", *knot()),
            "lamp": lamp,
        }
    )


def shortest(work: Callable[[], Image], repetitions: int) -> tuple[float, Image]:
    best, image = np.inf, work()
    for _ in range(repetitions):
        watch = time.perf_counter()
        image = work()
        best = min(best, time.perf_counter() - watch)
    return best, image


def time_at(curve: list[tuple[float, float]], target: float) -> float:
    """Seconds at an error, between the points of a curve of (error, seconds); beyond its ends as it goes on there."""
    errors, seconds = np.log([error for error, _ in curve]), np.log([seconds for _, seconds in curve])
    order = np.argsort(errors)
    errors, seconds, at = errors[order], seconds[order], np.log(target)
    if at < errors[0]:
        # Halving the error takes four times the samples.
        return float(np.exp(seconds[0] + 2 * (errors[0] - at)))
    # The least time that gives this error or a smaller one.
    return float(np.exp(min(np.interp(at, errors, seconds), seconds[errors <= at].min())))


def race(kind: str, size: tuple[int, int], targets: list[float], spp: int, folder: Path) -> dict[str, Any]:
    scene = own_scene(kind, size)
    truth = cl.reference(scene, spp=spp, samples=1)
    renderer = cl.Renderer(scene, samples=1, keep_points=False)
    layers = renderer.layers(["unshadowed", "object"])
    number, unshadowed = layers["object"], layers["unshadowed"].mean(axis=-1)
    part = truth["beauty"].mean(axis=-1) / np.maximum(unshadowed, 1e-6)
    # Pixels of the floor all around which the floor is seen: the facets of the knot are smaller than pixels.
    inside = np.ones_like(part, bool)
    for axis in (0, 1):
        for step in (-2, -1, 1, 2):
            inside &= np.roll(number, step, axis) == number
    penumbra = inside & (number == 0) & (part > 0.01) & (part < 0.99)

    def error(image: Image) -> float:
        difference = np.abs(image - truth["beauty"]).mean(axis=-1)
        return float((difference / np.maximum(unshadowed, 1e-6))[penumbra].mean())

    own = []
    for tolerance in (0.1, 0.03, 0.01, 0.005, 0.003, 0.001):
        renderer.set_settings(tolerance=tolerance)
        seconds, image = shortest(renderer.render, 5)
        own.append((error(image), seconds))
        print(f"  {kind}: tolerance {tolerance:<6} {1e3 * seconds:9.1f} ms  error {100 * own[-1][0]:.3f} %", flush=True)

    other = other_scene(kind, size, folder)
    passes = 128

    def mitsuba(samples: int) -> Image:
        images = [np.array(mi.render(other, spp=min(samples, passes), seed=seed)) for seed in range(max(1, samples // passes))]
        return np.asarray(np.mean(images, axis=0, dtype=np.float64), np.float32)

    theirs, bias = [], 0.0
    for samples in (4, 16, 64, 256, 1024):
        seconds, image = shortest(lambda: mitsuba(samples), 2 if samples <= 64 else 1)
        theirs.append((error(image), seconds))
        bias = float(((image - truth["beauty"]).mean(axis=-1) / np.maximum(unshadowed, 1e-6))[penumbra].mean())
        print(f"  {kind}: {samples:5} samples     {1e3 * seconds:9.1f} ms  error {100 * theirs[-1][0]:.3f} %", flush=True)
    print(f"  {kind}: mean of Mitsuba's last picture less the reference {100 * bias:+.4f} %, {int(penumbra.sum())} pixels")
    rows = []
    for target in targets:
        mine, yours = time_at(own, target), time_at(theirs, target)
        rows.append({"light": kind, "error": target, "own_ms": 1e3 * mine, "mitsuba_ms": 1e3 * yours, "ratio": yours / mine})
    return {"rows": rows, "own": own, "mitsuba": theirs, "bias": bias, "reference_error": float(truth["stderr"][penumbra].mean())}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--size", type=int, nargs=2, default=(480, 270))
    parser.add_argument("--targets", type=float, nargs="+", default=[0.01, 0.003])
    parser.add_argument("--spp", type=int, default=4096, help="samples of the reference")
    parser.add_argument("--json", type=Path)
    # DRJIT_LIBLLVM_PATH names another LLVM where the system's does not know the processor.
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba; scalar_rgb needs no LLVM")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    print(f"Mitsuba {mi.__version__} ({mi.variant()}), {options.size[0]} x {options.size[1]} pixels")
    with tempfile.TemporaryDirectory() as folder:
        size = (options.size[0], options.size[1])
        races = {kind: race(kind, size, options.targets, options.spp, Path(folder)) for kind in LIGHTS}
    print("\n| light | penumbra error | this library | Mitsuba | ratio |\n|---|---|---|---|---|")
    for result in races.values():
        for row in result["rows"]:
            print(f"| {row['light']} | {100 * row['error']:g} % | {row['own_ms']:.0f} ms | {row['mitsuba_ms']:.0f} ms | {row['ratio']:.0f} |")
    if options.json:
        options.json.write_text(json.dumps({"mitsuba": mi.__version__, "variant": mi.variant(), "races": races}, indent=1))


if __name__ == "__main__":
    main()
