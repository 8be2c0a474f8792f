"""Races the library against Mitsuba 3 and Blender's Cycles at equal error, on the same meshes and the same cores, in one run.

    python benches/races.py --meshes FOLDER [--only sphere sky] [--curves] [--json FILE]

Needs the release build of the Python package, and takes part in whatever is installed: `mitsuba` and `bpy` are optional. FOLDER holds
bunny.obj and armadillo.obj; without it the cow of this repository stands for both.

All render direct light alone. Errors are those of pixels in penumbra that show no outline: the mean difference from a reference, as a part
of the radiance without shadows. The reference is this library's Monte Carlo, which has no code in common with what is measured; its own
noise is taken off in squares, and how far Mitsuba at its most samples is from it is printed as well. Mitsuba's plastic is another model than
ours, so that glossy scene of its is compared with its own picture of 8192 samples. Times are the shortest of some
repetitions after a first picture. They include finding the visible points, and leave out hierarchies and compiled kernels.
"""

import argparse
import copy
import json
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Optional

import numpy as np

import cosine_lobes as cl

SIZE = 256
EYE, TARGET, FOV = (1.2, 3.2, 5.4), (0.1, 0.6, 0.15), 27.0
WIDE = (0.0, 9.0, 11.0), (0.0, 0.3, 0.0), 40.0
FLOOR, OBJECT = 0.4, 0.6
LAMP = (-3.0, 5.0, 3.2)
#: The lamp of the glossy scene, which the floor mirrors around the shadow.
BEHIND = (-1.0, 3.6, -4.5)
ROUGHNESS = 0.4
TARGETS = (0.01, 0.003)


class Mesh:
    """Corners and triangles of an OBJ file, placed on the floor."""

    def __init__(self, file: Path, height: float) -> None:
        lines = [line.split() for line in file.read_text().splitlines()]
        self.corners = np.array([line[1:4] for line in lines if line[:1] == ["v"]], np.float64)
        faces = [[int(corner.split("/")[0]) for corner in line[1:]] for line in lines if line[:1] == ["f"]]
        faces = [[face[0], face[i], face[i + 1]] for face in faces for i in range(1, len(face) - 1)]
        self.triangles = np.array(faces, np.int64)
        self.triangles -= np.where(self.triangles > 0, 1, -len(self.corners))
        low, high = self.corners.min(0), self.corners.max(0)
        middle = (low + high) / 2
        self.corners = (self.corners - (middle[0], low[1], middle[2])) * (height / (high - low)[1])

    def repeated(self, places: list[tuple[float, float, float]]) -> "Mesh":
        """Copies at x and z, turned by an angle, as one mesh."""
        many = object.__new__(Mesh)
        turned = []
        for x, z, angle in places:
            c, s = np.cos(angle), np.sin(angle)
            turned.append(self.corners @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + (x, 0, z))
        many.corners = np.concatenate(turned)
        many.triangles = np.concatenate([self.triangles + i * len(self.corners) for i in range(len(places))])
        return many

    def write(self, file: Path) -> Path:
        """As a PLY file, which all three read alike."""
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(self.corners)}\n"
        head += "".join(f"property float {axis}\n" for axis in "xyz")
        head += f"element face {len(self.triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
        faces = np.zeros(len(self.triangles), np.dtype([("n", "u1"), ("corners", "<i4", 3)]))
        faces["n"], faces["corners"] = 3, self.triangles
        file.write_bytes(head.encode() + self.corners.astype("<f4").tobytes() + faces.tobytes())
        return file


def sky(height: int = 128) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """A soft sky: blue above, a bright cloud 25° wide, a dark ground. Rows from the top; columns as this library has them."""
    v, u = (np.arange(height) + 0.5) / height, (np.arange(2 * height) + 0.5) / (2 * height)
    polar, azimuth = np.pi * v[:, None], 2 * np.pi * (u[None, :] - 0.5)
    y = np.cos(polar) + 0 * azimuth
    glow = np.exp(-((azimuth + 0.8) ** 2 + (polar - 0.9) ** 2) / (2 * 0.22**2))
    base = np.where(y > 0, 0.3 + 0.5 * y, 0.1)
    grey = base + 6 * glow
    return np.repeat(grey[..., None], 3, axis=2).astype(np.float32)


class Case:
    """One scene: its mesh, its lights, its camera, and whether it is glossy."""

    def __init__(self, mesh: Mesh, lights: list[dict[str, Any]], camera: Any = (EYE, TARGET, FOV), glossy: bool = False) -> None:
        self.mesh, self.lights, self.camera, self.glossy = mesh, lights, camera, glossy

    def own(self, folder: Path, size: int = SIZE) -> cl.Scene:
        eye, target, fov = self.camera
        text = f"[image]\nwidth = {size}\nheight = {size}\n[camera]\neye = {list(eye)}\ntarget = {list(target)}\nfov = {fov}\n"
        for name, albedo in (("floor", FLOOR), ("object", OBJECT)):
            text += f"[materials.{name}]\n"
            if self.glossy:
                text += f'model = "metallic-roughness"\nbase = {albedo}\nmetallic = 0\nroughness = {ROUGHNESS}\n'
            else:
                text += f'model = "lambert"\nalbedo = {albedo}\n'
        text += '[[objects]]\nname = "floor"\nplane = { point = [0, 0, 0], normal = [0, 1, 0], size = 60 }\nmaterial = "floor"\n'
        self.mesh.write(folder / "mesh.ply")
        text += '[[objects]]\nname = "object"\nmesh = "mesh.ply"\nmaterial = "object"\n'
        for light in self.lights:
            text += "[[lights]]\n" + "".join(f"{key} = {value}\n" for key, value in own_light(light, folder).items())
        (folder / "scene.toml").write_text(text)
        return cl.Scene.load(folder / "scene.toml")


def own_light(light: dict[str, Any], folder: Path) -> dict[str, Any]:
    if light["kind"] == "sky":
        cl.write_exr(folder / "sky.exr", sky(light["height"]))
        return {"kind": '"environment"', "file": '"sky.exr"'}
    if light["kind"] == "rectangle":
        # Shines toward u x v.
        return {"kind": '"rectangle"', "center": list(light["center"]), "u": list(light["u"]), "v": list(light["v"]), "radiance": light["radiance"]}
    return {"kind": '"sphere"', "center": list(light["center"]), "radius": light["radius"], "radiance": light["radiance"]}


def square_toward(center: tuple[float, float, float], target: tuple[float, float, float], half: tuple[float, float]) -> Any:
    """Half sides of a rectangle that faces a target."""
    n = np.subtract(target, center) / np.linalg.norm(np.subtract(target, center))
    u = np.cross(n, (0, 1, 0))
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    return [float(x) for x in half[0] * u], [float(x) for x in half[1] * v]


def ring(count: int) -> list[dict[str, Any]]:
    """Spheres of equal brightness over the scene, on a spiral."""
    lights = []
    for i in range(count):
        angle, out = 2.399963 * i, 1.0 + 3.0 * np.sqrt((i + 0.5) / count)
        center = (float(out * np.cos(angle)), 4.0 + 1.5 * ((i * 7) % 5) / 5, float(out * np.sin(angle)))
        lights.append({"kind": "sphere", "center": center, "radius": 0.24, "radiance": 200.0 / count})
    return lights


def cases(meshes: Optional[Path]) -> dict[str, Case]:
    cow = Path(__file__).parents[1] / "scenes/assets/spot.obj"
    bunny = Mesh(meshes / "bunny.obj" if meshes else cow, 1.5)
    armadillo = Mesh(meshes / "armadillo.obj" if meshes else cow, 1.3)
    places = [(1.6 * (i % 4) - 2.4, 1.6 * (i // 4) - 1.6, 0.7 * i) for i in range(12)]
    lamp = [{"kind": "sphere", "center": LAMP, "radius": 0.24, "radiance": 700.0}]
    u, v = square_toward(LAMP, TARGET, (1.3, 1.1))
    square = [{"kind": "rectangle", "center": LAMP, "u": u, "v": v, "radiance": 22.0}]
    return {
        "sphere": Case(bunny, lamp),
        "rectangle": Case(bunny, square),
        "glossy": Case(bunny, [{"kind": "sphere", "center": BEHIND, "radius": 0.24, "radiance": 700.0}], glossy=True),
        "million": Case(armadillo.repeated(places), lamp, WIDE),
        "sky": Case(bunny, [{"kind": "sky", "height": 128}]),
        "fifty": Case(bunny, ring(50)),
    }


def mitsuba_scene(mi: Any, case: Case, folder: Path) -> Any:
    def look(albedo: float) -> dict[str, Any]:
        grey = {"type": "rgb", "value": albedo}
        diffuse = {"type": "diffuse", "reflectance": grey}
        plastic = {"type": "principled", "base_color": grey, "roughness": ROUGHNESS, "metallic": 0.0, "specular": 0.5}
        return {"type": "twosided", "bsdf": plastic if case.glossy else diffuse}

    eye, target, fov = case.camera
    flat = mi.ScalarTransform4f(np.array([[60, 0, 0, 0], [0, 0, 60, 0], [0, -60, 0, 0], [0, 0, 0, 1.0]]).tolist())
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "direct", "hide_emitters": True, "emitter_samples": 1, "bsdf_samples": 1 if case.glossy else 0},
        "sensor": {
            "type": "perspective",
            "fov": fov,
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=eye, target=target, up=(0, 1, 0)),
            "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
            "sampler": {"type": "multijitter"},
        },
        "floor": {"type": "rectangle", "to_world": flat, "bsdf": look(FLOOR)},
        "object": {"type": "ply", "filename": str(folder / "mesh.ply"), "face_normals": True, "bsdf": look(OBJECT)},
    }
    for i, light in enumerate(case.lights):
        if light["kind"] == "sky":
            # Mitsuba's columns begin half a turn away.
            turned = np.roll(sky(light["height"]), light["height"], axis=1)
            scene["sky"] = {"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(turned))}
            continue
        emitter = {"type": "area", "radiance": {"type": "rgb", "value": light["radiance"]}}
        if light["kind"] == "sphere":
            scene[f"lamp{i}"] = {"type": "sphere", "center": light["center"], "radius": light["radius"], "emitter": emitter}
        else:
            u, v = np.array(light["u"]), np.array(light["v"])
            matrix = np.eye(4)
            matrix[:3, 0], matrix[:3, 1], matrix[:3, 3] = u, v, light["center"]
            matrix[:3, 2] = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
            scene[f"lamp{i}"] = {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix.tolist()), "emitter": emitter}
    return mi.load_dict(scene)


def cycles_scene(bpy: Any, case: Case, folder: Path) -> Callable[[int], np.ndarray]:
    """Sets the scene up in Blender, whose axes are taken as ours; the sky and gloss are left out. The answer renders it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", False, False
    cycles.max_bounces = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.pixel_filter_type = "BOX"
    render = scene.render
    render.resolution_x = render.resolution_y = SIZE
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.filepath = str(folder / "cycles.exr")

    def place(name: str, data: Any) -> Any:
        thing = bpy.data.objects.new(name, data)
        scene.collection.objects.link(thing)
        return thing

    def mesh(name: str, corners: Any, triangles: Any, albedo: float) -> None:
        data = bpy.data.meshes.new(name)
        data.from_pydata(corners, [], triangles)
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        nodes = made.node_tree.nodes
        nodes.clear()
        shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
        shader.inputs["Color"].default_value = (albedo, albedo, albedo, 1)
        made.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
        data.materials.append(made)
        place(name, data)

    def aimed(thing: Any, at: Any, x: Any, y: Any) -> None:
        from mathutils import Matrix

        x, y = np.array(x) / np.linalg.norm(x), np.array(y) / np.linalg.norm(y)
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, y, np.cross(x, y), at
        thing.matrix_world = Matrix(matrix.tolist())

    mesh("floor", [(-60, 0, 60), (60, 0, 60), (60, 0, -60), (-60, 0, -60)], [(0, 1, 2), (0, 2, 3)], FLOOR)
    mesh("object", case.mesh.corners.tolist(), case.mesh.triangles.tolist(), OBJECT)
    eye, target, fov = case.camera
    camera = place("camera", bpy.data.cameras.new("camera"))
    camera.data.angle = np.radians(fov)
    back = np.subtract(eye, target)
    right = np.cross((0, 1, 0), back)
    aimed(camera, eye, right, np.cross(back, right))
    scene.camera = camera
    for i, light in enumerate(case.lights):
        if light["kind"] == "sphere":
            lamp = place(f"lamp{i}", bpy.data.lights.new(f"lamp{i}", "POINT"))
            lamp.data.shadow_soft_size, lamp.location = light["radius"], light["center"]
            lamp.data.use_soft_falloff = False
            lamp.data.energy = light["radiance"] * 4 * np.pi**2 * light["radius"] ** 2
        else:
            lamp = place(f"lamp{i}", bpy.data.lights.new(f"lamp{i}", "AREA"))
            lamp.data.shape = "RECTANGLE"
            u, v = np.array(light["u"]), np.array(light["v"])
            lamp.data.size, lamp.data.size_y = 2 * np.linalg.norm(u), 2 * np.linalg.norm(v)
            # It shines along its -z axis.
            aimed(lamp, light["center"], u, -v)
            lamp.data.energy = light["radiance"] * np.pi * lamp.data.size * lamp.data.size_y
    def shoot(samples: int) -> np.ndarray:
        cycles.samples = samples
        bpy.ops.render.render(write_still=True)
        return cl.read_exr(folder / "cycles.exr")

    return shoot


def shortest(work: Callable[[], Any], repetitions: int) -> tuple[float, Any]:
    best, image = np.inf, work() if repetitions > 1 else None
    for _ in range(max(repetitions, 1)):
        watch = time.perf_counter()
        image = work()
        best = min(best, time.perf_counter() - watch)
    return best, image


def time_at(curve: list[tuple[float, float]], target: float) -> float:
    """Seconds at an error, between the points of a curve of (error, seconds); beyond its end halving the error takes four times as long."""
    errors, seconds = np.log([error for error, _ in curve]), np.log([seconds for _, seconds in curve])
    order = np.argsort(errors)
    errors, seconds, at = errors[order], seconds[order], np.log(target)
    if at < errors[0]:
        return float(np.exp(seconds[0] + 2 * (errors[0] - at)))
    # The least time that gives this error or a smaller one.
    return float(np.exp(min(np.interp(at, errors, seconds), seconds[errors <= at].min())))


class Judge:
    """The pixels that count, and the error of pictures there."""

    def __init__(self, scene: cl.Scene, renderer: cl.Renderer, spp: int) -> None:
        truth = cl.reference(scene, spp=spp, samples=1)
        layers = renderer.layers(["unshadowed", "object"])
        self.truth, self.whole = truth["beauty"].mean(axis=-1), np.maximum(layers["unshadowed"].mean(axis=-1), 1e-9)
        part, number = self.truth / self.whole, layers["object"]
        inside = np.ones_like(part, bool)
        for axis in (0, 1):
            for step in (-2, -1, 1, 2):
                inside &= np.roll(number, step, axis) == number
        # Facets of dense meshes are smaller than pixels, and others take their mean.
        self.where = inside & (number == 0) & (part > 0.01) & (part < 0.99)
        noise = truth["stderr"].reshape(self.truth.shape[0], self.truth.shape[1], -1).mean(axis=-1)
        self.noise = float(np.sqrt(2 / np.pi) * (noise / self.whole)[self.where].mean())

    def beside(self, images: list[Any]) -> "Judge":
        """The same pixels, with the mean of pictures as the truth."""
        other = copy.copy(self)
        greys = [image[..., :3].mean(axis=-1) for image in images]
        other.truth = np.mean(greys, axis=0)
        spread = np.std(greys, axis=0) / np.sqrt(len(greys) - 1)
        other.noise = float(np.sqrt(2 / np.pi) * (spread / self.whole)[self.where].mean())
        return other

    def difference(self, image: Any) -> Any:
        return ((image[..., :3].mean(axis=-1) - self.truth) / self.whole)[self.where]

    def error(self, image: Any) -> float:
        return float(np.sqrt(max(np.abs(self.difference(image)).mean() ** 2 - self.noise**2, (0.1 * self.noise) ** 2)))


def race(name: str, case: Case, spp: int, folder: Path, others: dict[str, Any]) -> dict[str, Any]:
    watch = time.perf_counter()
    scene = case.own(folder)
    renderer = cl.Renderer(scene, samples=1, keep_points=False)
    renderer.render()
    first = time.perf_counter() - watch
    judge = Judge(scene, renderer, spp // max(1, len(case.lights) // 4))
    print(f"{name}: {int(judge.where.sum())} pixels, noise of the reference {100 * judge.noise:.3f} %, first picture {first:.2f} s", flush=True)
    result: dict[str, Any] = {"first": first, "pixels": int(judge.where.sum()), "noise": judge.noise}

    judges = {"mitsuba": judge, "cycles": judge, "own": judge}

    def run(who: str, picture: Callable[[Any], Callable[[], Any]], steps: Any, repetitions: Callable[[Any], int]) -> None:
        rows, last = [], None
        for step in steps:
            seconds, image = shortest(picture(step), repetitions(step))
            rows.append((judges[who].error(image), seconds))
            last = float(judges[who].difference(image).mean())
            print(f"  {who} {step:<7} {1e3 * seconds:9.1f} ms  error {100 * rows[-1][0]:.3f} %, mean {100 * last:+.3f} %", flush=True)
        result[who] = {"curve": rows, "bias": last}

    def own(tolerance: float) -> Callable[[], Any]:
        renderer.set_settings(tolerance=tolerance)
        return renderer.render

    run("own", own, (0.1, 0.03, 0.01, 0.005, 0.003, 0.001), lambda _: 5)
    if mi := others.get("mitsuba"):
        other = mitsuba_scene(mi, case, folder)

        if case.glossy:
            judges["mitsuba"] = judge.beside([np.array(mi.render(other, spp=256, seed=1000 + seed)) for seed in range(32)])

        def mitsuba(samples: int) -> Callable[[], Any]:
            return lambda: np.mean([np.array(mi.render(other, spp=min(samples, 256), seed=seed)) for seed in range(max(1, samples // 256))], axis=0)

        run("mitsuba", mitsuba, (16, 64, 256, 1024), lambda samples: 2 if samples <= 64 else 1)
    if (bpy := others.get("bpy")) and not case.glossy and case.lights[0]["kind"] != "sky":
        shoot = cycles_scene(bpy, case, folder)
        # Its hierarchy is made anew for each picture: that time is taken off.
        ready, _ = shortest(lambda: shoot(1), 2)
        run("cycles", lambda samples: lambda: shoot(samples), (4, 16, 64), lambda samples: 2 if samples <= 16 else 1)
        result["cycles"]["curve"] = [(error, max(seconds - ready, 1e-3)) for error, seconds in result["cycles"]["curve"]]
    return result


def table(results: dict[str, Any]) -> None:
    print("\n| scene | own picture | its error | Mitsuba 1 % / 0.3 % | ahead by | Cycles 1 % / 0.3 % | ahead by |\n|---|---|---|---|---|---|---|")
    for name, result in results.items():
        error, seconds = result["own"]["curve"][3]
        cells = [name, f"{1e3 * seconds:.0f} ms", f"{100 * error:.2f} %"]
        for who in ("mitsuba", "cycles"):
            if who in result:
                times = [time_at(result[who]["curve"], target) for target in TARGETS]
                cells += [" / ".join(f"{t:.2f} s" for t in times), " / ".join(f"{t / seconds:.0f}" for t in times) + " ×"]
            else:
                cells += ["–", "–"]
        print("| " + " | ".join(cells) + " |")


def curves(meshes: Optional[Path], folder: Path) -> None:
    """This library alone: a picture's time over lights, texels of the sky, triangles and pixels, at the default tolerance."""
    base = cases(meshes)

    def picture(case: Case, size: int = SIZE) -> float:
        renderer = cl.Renderer(case.own(folder, size), samples=1, keep_points=False)
        return shortest(renderer.render, 3)[0]

    def row(title: str, unit: str, points: list[tuple[str, Case, int]]) -> None:
        print(f"\n| {title} | {unit} | × the first |\n|---|---|---|")
        least = None
        for label, case, size in points:
            seconds = picture(case, size)
            least = least or seconds
            print(f"| {label} | {1e3 * seconds:.1f} | {seconds / least:.2f} |", flush=True)

    bunny = base["sphere"].mesh
    row("sphere lights", "ms", [(str(n), Case(bunny, ring(n)), SIZE) for n in (1, 2, 5, 10, 20, 50, 100, 200, 400)])
    row("rows of the sky's picture", "ms", [(str(n), Case(bunny, [{"kind": "sky", "height": n}]), SIZE) for n in (32, 128, 512, 2048)])
    single = Mesh(meshes / "armadillo.obj", 1.3) if meshes else bunny
    fields = []
    for count in (1, 4, 12, 40, 116):
        side = int(np.ceil(np.sqrt(count)))
        spacing = 6.4 / side
        many = single.repeated([(spacing * (i % side - (side - 1) / 2), spacing * (i // side - (side - 1) / 2), 0.7 * i) for i in range(count)])
        fields.append((f"{len(many.triangles)}", Case(many, base["sphere"].lights, WIDE), SIZE))
    row("triangles", "ms", [(f"{len(bunny.triangles)}", Case(bunny, base["sphere"].lights, WIDE), SIZE), *fields])
    row("pixels a side, sphere", "ms", [(str(n), base["sphere"], n) for n in (128, 256, 512, 1024)])
    row("pixels a side, sky", "ms", [(str(n), base["sky"], n) for n in (128, 256, 512, 1024)])


def installed(variant: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    try:
        import mitsuba

        mitsuba.set_variant(variant)
        found["mitsuba"] = mitsuba
        print(f"Mitsuba {mitsuba.__version__} ({variant})")
    except ImportError:
        print("left out: Mitsuba (pip install mitsuba)")
    try:
        import bpy

        found["bpy"] = bpy
        print(f"Cycles of Blender {bpy.app.version_string}")
    except ImportError:
        print("left out: Cycles (pip install bpy)")
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--meshes", type=Path, help="a folder with bunny.obj and armadillo.obj")
    parser.add_argument("--only", nargs="+", help="names of scenes")
    parser.add_argument("--spp", type=int, default=4096, help="samples of the reference")
    parser.add_argument("--curves", action="store_true", help="this library's time over lights, skies, triangles and pixels, and no race")
    parser.add_argument("--json", type=Path)
    # DRJIT_LIBLLVM_PATH names another LLVM where the system's does not know the processor.
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba; scalar_rgb needs no LLVM")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.curves:
            return curves(options.meshes, folder)
        others = installed(options.variant)
        chosen = {name: case for name, case in cases(options.meshes).items() if not options.only or name in options.only}
        results = {name: race(name, case, options.spp, folder, others) for name, case in chosen.items()}
    table(results)
    if options.json:
        options.json.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
