"""Types of the compiled module. Stated once: a test compares them with it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Optional, TypedDict, Union, final

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Unpack

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

_Path = Union[str, PathLike[str]]
_Floats = Union[NDArray[np.float32], NDArray[np.float64]]
_Integers = Union[NDArray[np.int32], NDArray[np.int64], NDArray[np.uint32], NDArray[np.uint64]]
_Image = NDArray[np.float32]
_Vector = Union[Iterable[float], _Floats]
_Color = Union[float, Iterable[float], _Floats]
_Matrix = Union[Iterable[Iterable[float]], _Floats]
_Matrices = Union[Iterable[_Matrix], _Floats]
_Triple = tuple[float, float, float]
_Window = tuple[int, int, int, int]
_Progress = Callable[[str, float], object]
_Terminator = Literal["exact", "smooth"]
_Normals = Literal["file", "face", "smooth"]
_Emission = Literal["lights", "seen"]
_Studio = Literal["soft", "key"]
_Visibility = Literal["spheres", "shadow-map", "silhouettes", "rays", "none"]
_SceneVisibility = Literal["scene", "spheres", "shadow-map", "silhouettes", "rays", "none"]
_Layer = Literal["unshadowed", "lights", "normal", "depth", "object", "counts"]
_LightKey = Union["LightHandle", int]
_ObjectKey = Union["ObjectHandle", int, str]
_MaterialKey = Union["MaterialHandle", int]

class LobesError(Exception):
    """Any error of the library."""

class SceneError(LobesError):
    """A scene, a file of one, or a part of it is refused."""

class EditError(LobesError):
    """An edit is refused; the renderer stays the same."""

class RenderError(LobesError):
    """A picture could not be made."""

class LobesWarning(UserWarning):
    """Something was left out, replaced, or fits badly."""

@final
class Camera:
    """A camera. `projection` is "perspective", with the full vertical field of view `fov` in degrees, "orthographic", with the `height` of the
    picture in units of the scene, or "panoramic": all directions by longitude and latitude."""

    def __new__(
        cls,
        eye: _Vector,
        target: _Vector,
        *,
        up: Optional[_Vector] = None,
        fov: Optional[float] = None,
        projection: Literal["perspective", "orthographic", "panoramic"] = "perspective",
        height: Optional[float] = None,
    ) -> Camera: ...
    @property
    def eye(self) -> _Triple: ...
    @property
    def target(self) -> _Triple: ...
    @property
    def up(self) -> _Triple: ...
    @property
    def projection(self) -> Literal["perspective", "orthographic", "panoramic"]: ...
    @property
    def fov(self) -> Optional[float]:
        """In degrees, of a perspective camera."""
    @property
    def height(self) -> Optional[float]:
        """In units of the scene, of an orthographic camera."""
    def __eq__(self, value: object, /) -> bool: ...

@final
class Light:
    """A light. Immutable: `moved`, `shifted`, `aimed`, `resized` and `with_radiance` return another one."""

    @staticmethod
    def sphere(
        center: _Vector, radius: float, *, radiance: Optional[_Color] = None, flux: Optional[_Color] = None
    ) -> Light: ...
    @staticmethod
    def point(center: _Vector, *, intensity: _Color, radius: float = 0.01, range: Optional[float] = None) -> Light: ...
    @staticmethod
    def spot(
        center: _Vector,
        direction: _Vector,
        *,
        intensity: _Color,
        angle: float,
        inner: float = 0.0,
        radius: float = 0.01,
        range: Optional[float] = None,
    ) -> Light: ...
    @staticmethod
    def lamp(
        center: _Vector,
        *,
        intensity: _Color,
        radius: float = 0.01,
        facing: bool = False,
        direction: Optional[_Vector] = None,
        angle: float = 90.0,
        blend: float = 0.0,
    ) -> Light: ...
    @staticmethod
    def rectangle(
        center: _Vector,
        u: _Vector,
        v: _Vector,
        *,
        radiance: Optional[_Color] = None,
        flux: Optional[_Color] = None,
        two_sided: bool = False,
    ) -> Light: ...
    @staticmethod
    def disc(
        center: _Vector,
        normal: _Vector,
        radius: float,
        *,
        radiance: Optional[_Color] = None,
        flux: Optional[_Color] = None,
        two_sided: bool = False,
    ) -> Light: ...
    @staticmethod
    def polygon(
        corners: _Floats,
        *,
        radiance: Optional[_Color] = None,
        flux: Optional[_Color] = None,
        two_sided: bool = False,
    ) -> Light: ...
    @staticmethod
    def tube(
        start: _Vector,
        end: _Vector,
        radius: float,
        *,
        radiance: Optional[_Color] = None,
        flux: Optional[_Color] = None,
    ) -> Light: ...
    @staticmethod
    def sun(
        direction: _Vector,
        *,
        irradiance: Optional[_Color] = None,
        radiance: Optional[_Color] = None,
        angle: Optional[float] = None,
    ) -> Light: ...
    @staticmethod
    def ambient(radiance: _Color) -> Light: ...
    @property
    def kind(self) -> str: ...
    @property
    def center(self) -> Optional[_Triple]: ...
    @property
    def direction(self) -> Optional[_Triple]: ...
    @property
    def size(self) -> Optional[float]: ...
    @property
    def radiance(self) -> _Triple: ...
    def moved(self, matrix: _Matrix) -> Light: ...
    def shifted(self, by: _Vector) -> Light: ...
    def aimed(self, direction: _Vector) -> Light: ...
    def resized(self, size: float) -> Light: ...
    def with_radiance(self, radiance: _Color) -> Light: ...
    def __eq__(self, value: object, /) -> bool: ...

class _LafortuneLobe(TypedDict, total=False):
    exponent: float
    scale: _Color
    c: _Vector
    matrix: _Matrix

class _HalfVectorLobe(TypedDict, total=False):
    roughness: float
    f0: _Color
    f90: _Color

@final
class Material:
    """How a surface reflects light, and what it emits. Immutable."""

    @staticmethod
    def lambert(albedo: _Color, *, emission: Optional[_Color] = None) -> Material: ...
    @staticmethod
    def phong(
        *,
        kd: Optional[_Color] = None,
        ks: Optional[_Color] = None,
        exponent: float,
        emission: Optional[_Color] = None,
    ) -> Material: ...
    @staticmethod
    def modified_phong(
        *,
        kd: Optional[_Color] = None,
        ks: Optional[_Color] = None,
        exponent: float,
        emission: Optional[_Color] = None,
    ) -> Material: ...
    @staticmethod
    def neumann(
        *,
        kd: Optional[_Color] = None,
        ks: Optional[_Color] = None,
        exponent: float,
        emission: Optional[_Color] = None,
    ) -> Material: ...
    @staticmethod
    def lafortune(
        lobes: Sequence[_LafortuneLobe], *, diffuse: Optional[_Color] = None, emission: Optional[_Color] = None
    ) -> Material: ...
    @staticmethod
    def half_vector(
        lobes: Sequence[_HalfVectorLobe], *, diffuse: Optional[_Color] = None, emission: Optional[_Color] = None
    ) -> Material: ...
    @staticmethod
    def metallic_roughness(
        base: _Color,
        *,
        metallic: float = 1.0,
        roughness: float = 1.0,
        ior: Optional[float] = None,
        f0: Optional[_Color] = None,
        clearcoat: float = 0.0,
        clearcoat_roughness: float = 0.0,
        emission: Optional[_Color] = None,
    ) -> Material: ...
    @staticmethod
    def principled(
        base: _Color,
        *,
        metallic: float = 0.0,
        roughness: float = 0.5,
        ior: float = 1.5,
        tint: Optional[_Color] = None,
        scatters: bool = True,
        coat: float = 0.0,
        coat_roughness: float = 0.03,
        coat_ior: float = 1.5,
        coat_tint: Optional[_Color] = None,
        emission: Optional[_Color] = None,
    ) -> Material: ...
    def with_images(
        self,
        *,
        color: Optional[NDArray[np.uint8]] = None,
        specular: Optional[NDArray[np.uint8]] = None,
        emission: Optional[NDArray[np.uint8]] = None,
        normal: Optional[NDArray[np.uint8]] = None,
        roughness: Optional[NDArray[np.uint8]] = None,
        metallic: Optional[NDArray[np.uint8]] = None,
        normal_scale: float = 1.0,
    ) -> Material: ...
    @property
    def model(self) -> str: ...
    @property
    def emission(self) -> _Triple: ...
    def __eq__(self, value: object, /) -> bool: ...

@final
class Environment:
    """Light from all around that objects hide: one radiance, or an image in latitude and longitude, the top row first.

    ``ambient`` is more radiance from everywhere, which is not seen behind the objects. At least one of the two.
    """

    def __new__(
        cls,
        radiance: Optional[_Color] = None,
        *,
        strength: Optional[_Color] = None,
        up: Optional[_Vector] = None,
        turn: float = 0.0,
        patches: int = 2,
        ambient: Optional[_Color] = None,
    ) -> Environment: ...

class _MeshRequired(TypedDict):
    positions: _Floats
    triangles: _Integers

class _Mesh(_MeshRequired, total=False):
    normals: Optional[_Floats]
    uvs: Optional[_Floats]
    colors: Optional[_Floats]
    smooth: bool
    material: Optional[Union[Material, int]]
    name: Optional[str]
    visible: bool
    visibility: Optional[_Visibility]
    spheres: Optional[Union[int, SphereSet, _Floats]]
    terminator: Optional[_Terminator]

@final
class Scene:
    """Everything that a picture is made of: objects, materials, lights, a camera; from files or from arrays."""

    def __new__(
        cls, *, size: Optional[tuple[int, int]] = None, camera: Optional[Camera] = None, background: Optional[_Color] = None
    ) -> Scene: ...
    @staticmethod
    def load(
        path: _Path,
        *,
        clip: Optional[str] = None,
        size: Optional[tuple[int, int]] = None,
        normals: _Normals = "file",
        crease: float = 180.0,
        terminator: _Terminator = "exact",
        emission: _Emission = "lights",
        studio: Optional[_Studio] = None,
    ) -> Scene: ...
    @staticmethod
    def builtin(*, size: Optional[tuple[int, int]] = None) -> Scene: ...
    @staticmethod
    def from_arrays(
        meshes: Sequence[_Mesh],
        *,
        lights: Sequence[Light],
        camera: Camera,
        size: Optional[tuple[int, int]] = None,
        background: Optional[_Color] = None,
        environment: Optional[Environment] = None,
    ) -> Scene: ...
    def add_mesh(
        self,
        positions: _Floats,
        triangles: _Integers,
        *,
        normals: Optional[_Floats] = None,
        uvs: Optional[_Floats] = None,
        colors: Optional[_Floats] = None,
        smooth: bool = False,
        material: Optional[Union[Material, int]] = None,
        name: Optional[str] = None,
        visible: bool = True,
        visibility: Optional[_Visibility] = None,
        spheres: Optional[Union[int, SphereSet, _Floats]] = None,
        terminator: Optional[_Terminator] = None,
        places: Optional[_Matrices] = None,
    ) -> int: ...
    def add_spheres(
        self,
        spheres: _Floats,
        *,
        material: Optional[Union[Material, int]] = None,
        name: Optional[str] = None,
        visible: bool = True,
        visibility: Optional[_Visibility] = None,
    ) -> int: ...
    def add_material(self, material: Material) -> int: ...
    def add_light(self, light: Light) -> int: ...
    def set_environment(self, environment: Optional[Environment]) -> None: ...
    def validate(self) -> None: ...
    @property
    def camera(self) -> Camera: ...
    @camera.setter
    def camera(self, camera: Camera) -> None: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @size.setter
    def size(self, size: tuple[int, int]) -> None: ...
    @property
    def background(self) -> _Triple: ...
    @background.setter
    def background(self, background: _Color) -> None: ...
    @property
    def lights(self) -> list[Light]: ...
    @property
    def objects(self) -> list[str]: ...
    @property
    def materials(self) -> list[Material]: ...
    @property
    def triangles(self) -> int: ...
    @property
    def duration(self) -> float: ...
    @property
    def fps(self) -> float: ...
    @property
    def warnings(self) -> list[str]: ...

class _Changes(TypedDict, total=False):
    tolerance: float
    depth: Optional[int]
    visibility: Optional[_SceneVisibility]
    method: Literal["moments", "lobes", "paper"]
    device: Literal["cpu", "gpu"]
    samples: Optional[int]
    time_budget: Optional[float]
    own_radiance: bool
    interpolate: bool
    threshold: float
    map_resolution: Optional[int]
    keep_points: bool
    cache: Optional[Union[bool, _Path]]

@final
class Settings:
    """How a renderer makes its pictures; the defaults are those of `lobes render`. Immutable, comparable, can be pickled."""

    def __new__(
        cls,
        *,
        tolerance: float = 0.005,
        depth: Optional[int] = None,
        visibility: Optional[_SceneVisibility] = None,
        method: Literal["moments", "lobes", "paper"] = "moments",
        device: Literal["cpu", "gpu"] = "cpu",
        samples: Optional[int] = None,
        time_budget: Optional[float] = None,
        own_radiance: bool = False,
        interpolate: bool = False,
        threshold: float = 0.0,
        map_resolution: Optional[int] = None,
        keep_points: bool = True,
        cache: Optional[Union[bool, _Path]] = None,
    ) -> Settings: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def depth(self) -> Optional[int]: ...
    @property
    def visibility(self) -> Optional[str]: ...
    @property
    def method(self) -> str: ...
    @property
    def device(self) -> str: ...
    @property
    def samples(self) -> Optional[int]: ...
    @property
    def time_budget(self) -> Optional[float]: ...
    @property
    def own_radiance(self) -> bool: ...
    @property
    def interpolate(self) -> bool: ...
    @property
    def threshold(self) -> float: ...
    @property
    def map_resolution(self) -> Optional[int]: ...
    @property
    def keep_points(self) -> bool: ...
    @property
    def cache(self) -> Optional[PathLike[str]]: ...
    def replace(self, **changes: Unpack[_Changes]) -> Settings: ...
    def asdict(self) -> dict[str, Any]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class LightHandle:
    """A light of a renderer; valid until the light is removed."""

    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class ObjectHandle:
    """An object of a renderer; valid until the object is removed."""

    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class MaterialHandle:
    """A material of a renderer; valid until the material is removed."""

    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class Pick:
    """The surface that a pixel shows."""

    @property
    def object(self) -> ObjectHandle: ...
    @property
    def name(self) -> Optional[str]: ...
    @property
    def light(self) -> Optional[LightHandle]: ...
    @property
    def material(self) -> MaterialHandle: ...
    @property
    def position(self) -> _Triple: ...
    @property
    def normal(self) -> _Triple: ...
    @property
    def view(self) -> _Triple: ...
    @property
    def distance(self) -> float: ...

@final
class Renderer:
    """Turns a scene into pictures, and keeps what the next picture can use."""

    def __new__(cls, scene: Scene, settings: Optional[Settings] = None, **changes: Unpack[_Changes]) -> Renderer: ...
    def render(
        self, *, progress: Optional[_Progress] = None, out: Optional[_Image] = None, window: Optional[_Window] = None
    ) -> _Image: ...
    def layers(
        self,
        names: Optional[Sequence[_Layer]] = None,
        *,
        progress: Optional[_Progress] = None,
        window: Optional[_Window] = None,
    ) -> dict[str, NDArray[Any]]: ...
    def unshadowed(self, *, progress: Optional[_Progress] = None) -> _Image: ...
    def shade(
        self,
        points: _Floats,
        normals: _Floats,
        views: Optional[_Floats] = None,
        *,
        faces: Optional[_Floats] = None,
        material: Optional[Union[Material, MaterialHandle, int]] = None,
        objects: Optional[Union[ObjectHandle, int, str, NDArray[np.int32], NDArray[np.int64]]] = None,
    ) -> _Image: ...
    def shade_layers(
        self,
        points: _Floats,
        normals: _Floats,
        views: Optional[_Floats] = None,
        *,
        faces: Optional[_Floats] = None,
        material: Optional[Union[Material, MaterialHandle, int]] = None,
        objects: Optional[Union[ObjectHandle, int, str, NDArray[np.int32], NDArray[np.int64]]] = None,
    ) -> dict[str, _Image]: ...
    def bake(
        self,
        positions: _Floats,
        triangles: _Integers,
        uvs: _Floats,
        size: tuple[int, int],
        *,
        normals: Optional[_Floats] = None,
        samples: int = 2,
        padding: int = 2,
        per_light: bool = False,
        object: Optional[_ObjectKey] = None,
        progress: Optional[_Progress] = None,
    ) -> dict[str, Any]: ...
    def coverage(self, *, window: Optional[_Window] = None) -> NDArray[np.float32]: ...
    def exposure(self) -> float: ...
    def pick(self, x: int, y: int) -> Optional[Pick]: ...
    def visible_fraction(self, point: _Vector, normal: _Vector, light: _LightKey) -> _Triple: ...
    def seek(self, time: float) -> None: ...
    @property
    def time(self) -> float: ...
    @property
    def settings(self) -> Settings: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def upkeep(self) -> dict[str, int]: ...
    @property
    def stale(self) -> frozenset[str]: ...
    @property
    def stats(self) -> Optional[dict[str, Any]]: ...
    def edit(
        self,
        *,
        lights: Optional[Mapping[_LightKey, Light]] = None,
        transforms: Optional[Mapping[_ObjectKey, _Matrix]] = None,
        materials: Optional[Mapping[_MaterialKey, Material]] = None,
        object_materials: Optional[Mapping[_ObjectKey, _MaterialKey]] = None,
        visible: Optional[Mapping[_ObjectKey, bool]] = None,
        visibility: Optional[Mapping[_ObjectKey, Optional[_Visibility]]] = None,
        camera: Optional[Camera] = None,
        size: Optional[tuple[int, int]] = None,
        time: Optional[float] = None,
    ) -> None: ...
    @property
    def lights(self) -> list[LightHandle]: ...
    @property
    def objects(self) -> list[ObjectHandle]: ...
    @property
    def materials(self) -> list[MaterialHandle]: ...
    def light(self, light: _LightKey) -> Light: ...
    def set_light(self, light: _LightKey, new: Light) -> None: ...
    def add_light(self, light: Light) -> LightHandle: ...
    def remove_light(self, light: _LightKey) -> Light: ...
    def set_environment(self, environment: Optional[Environment]) -> None: ...
    def name(self, object: _ObjectKey) -> str: ...
    def transform(self, object: _ObjectKey) -> NDArray[np.float32]: ...
    def set_transform(self, object: _ObjectKey, matrix: _Matrix) -> None: ...
    def add_mesh(
        self,
        positions: _Floats,
        triangles: _Integers,
        *,
        normals: Optional[_Floats] = None,
        uvs: Optional[_Floats] = None,
        colors: Optional[_Floats] = None,
        smooth: bool = False,
        material: Optional[Union[Material, MaterialHandle, int]] = None,
        name: Optional[str] = None,
        visible: bool = True,
        visibility: Optional[_Visibility] = None,
        spheres: Optional[Union[int, SphereSet, _Floats]] = None,
        terminator: Optional[_Terminator] = None,
        places: Optional[_Matrices] = None,
    ) -> ObjectHandle: ...
    def add_spheres(
        self,
        spheres: _Floats,
        *,
        material: Optional[Union[Material, MaterialHandle, int]] = None,
        name: Optional[str] = None,
        visible: bool = True,
        visibility: Optional[_Visibility] = None,
    ) -> ObjectHandle: ...
    def set_mesh(
        self,
        object: _ObjectKey,
        positions: _Floats,
        triangles: _Integers,
        *,
        normals: Optional[_Floats] = None,
        uvs: Optional[_Floats] = None,
        colors: Optional[_Floats] = None,
        smooth: bool = False,
    ) -> None: ...
    def set_places(self, object: _ObjectKey, places: _Matrices) -> None: ...
    def places(self, object: _ObjectKey) -> Optional[_Image]: ...
    def remove_object(self, object: _ObjectKey) -> None: ...
    def set_visible(self, object: _ObjectKey, visible: bool) -> None: ...
    def set_visibility(self, object: _ObjectKey, visibility: Optional[_Visibility]) -> None: ...
    def material(self, material: _MaterialKey) -> Material: ...
    def set_material(self, material: _MaterialKey, new: Material) -> None: ...
    def add_material(self, material: Material) -> MaterialHandle: ...
    def object_material(self, object: _ObjectKey) -> MaterialHandle: ...
    def set_object_material(self, object: _ObjectKey, material: _MaterialKey) -> None: ...
    def set_camera(self, camera: Camera) -> None: ...
    def set_size(self, width: int, height: int) -> None: ...
    def set_background(self, background: _Color) -> None: ...
    def set_settings(self, settings: Optional[Settings] = None, **changes: Unpack[_Changes]) -> None: ...

@final
class SphereSet:
    """Spheres that cast the shadow of a mesh."""

    @staticmethod
    def fit(
        positions: _Floats,
        triangles: _Integers,
        *,
        count: Optional[int] = None,
        tolerance: Optional[float] = None,
        draft: bool = False,
        bounding: bool = False,
        seed: int = 0,
        progress: Optional[_Progress] = None,
    ) -> SphereSet: ...
    @staticmethod
    def measure(positions: _Floats, triangles: _Integers, spheres: _Floats) -> SphereSet: ...
    @staticmethod
    def load(path: _Path) -> SphereSet: ...
    def save(self, path: _Path) -> None: ...
    def placed(self, matrix: _Matrix) -> SphereSet: ...
    @property
    def spheres(self) -> NDArray[np.float32]: ...
    @property
    def quality(self) -> dict[str, float]: ...
    def __len__(self) -> int: ...

def bake(
    path: _Path,
    output: _Path,
    *,
    form: Literal["emission", "lightmap", "vertex-colors"] = "emission",
    page: int = 1024,
    density: Optional[float] = None,
    padding: int = 2,
    samples: int = 2,
    unwrap: bool = False,
    both_sides: bool = False,
    per_light: bool = False,
    subdivide: Optional[float] = None,
    vertices: int = 1000000,
    tolerance: float = 0.005,
    time: float = 0.0,
    clip: Optional[str] = None,
    normals: _Normals = "file",
    crease: float = 180.0,
    terminator: _Terminator = "exact",
    emission: _Emission = "lights",
    studio: Optional[_Studio] = None,
    progress: Optional[_Progress] = None,
) -> dict[str, Any]: ...
def compare(
    test: _Floats, reference: _Floats, *, unshadowed: Optional[_Floats] = None, exposure: float = 0.0
) -> dict[str, Any]: ...
def cut_out(
    positions: _Floats,
    triangles: _Integers,
    uvs: _Floats,
    alpha: NDArray[np.uint8],
    *,
    limit: float = 0.5,
    normals: Optional[_Floats] = None,
) -> tuple[_Image, NDArray[np.uint32], Optional[_Image], _Image]: ...
def reference(
    scene: Scene,
    *,
    spp: int = 1024,
    geometry: Literal["scene", "spheres", "mesh", "none"] = "scene",
    seed: int = 0,
    samples: Optional[int] = None,
    time: float = 0.0,
    progress: Optional[_Progress] = None,
) -> dict[str, _Image]: ...
def read_exr(path: _Path, *, layer: Optional[str] = None) -> _Image: ...
def write_exr(path: _Path, image: _Floats) -> None: ...
def exposed(image: _Floats, *, exposure: float = 0.0, tone: str = "soft") -> NDArray[np.uint8]: ...
def write_png(
    path: _Path, image: _Floats, *, exposure: float = 0.0, tone: str = "soft", bits: int = 8
) -> None: ...
