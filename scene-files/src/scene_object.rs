//! The objects of a scene file.

use crate::Normals;
use crate::context::Context;
use crate::defaults::DEFAULT_SPHERES;
use crate::kept_meshes::kept_parts;
use crate::keys::{Keys, Stand, read_rotation, read_scale};
use crate::origin::relative;
use crate::part::{Part, share_out};
use crate::scene_material::Materials;
use crate::toml_reader::{Table, Value};
use glam::{DVec3, Mat4, Vec3};
use lobe_core::{Sphere, scales_evenly};
use scene::motion::{Body, BoundSphere, Mover, Origins, Placement};
use scene::{Mesh, Object, Proxy, Scene, SceneError, Shape, Strategy, Terminator};
use std::collections::HashMap;
use std::path::Path;

/// The geometry of an object before it is placed.
enum Geometry {
    Spheres(Vec<Sphere>),
    Flat(Mesh),
    Solid(Vec<Part>),
}

const UNEVEN: &str = "spheres can only be scaled uniformly";

/// Objects of a scene file, their motion, and the key that says whether their emission is light.
pub(crate) struct Read<'s> {
    pub(crate) objects: Placed,
    pub(crate) light: Option<(Value<'s>, bool)>,
}

type Placed = Vec<(Object, Option<Mover>)>;

/// An object but for its geometry: the keys that all its parts have in common, and how it stands.
struct Common<'s> {
    name: String,
    material: Option<usize>,
    visible: bool,
    strategy: Option<Strategy>,
    terminator: Terminator,
    /// Normals of meshes, and whether the object asks for them.
    normals: (Normals, bool),
    proxy: Option<Proxy>,
    /// The key of the shape and its name, that of the proxy, and the one that a sphere may not follow.
    shape: &'static str,
    value: Value<'s>,
    proxy_key: Option<Value<'s>>,
    place: Option<Value<'s>>,
    placement: Placement,
    /// The placement at the beginning.
    matrix: Mat4,
}

/// Notes which mesh files several of the `[[objects]]` show. One that cannot be read is refused later, when it is read.
pub(crate) fn count_files(objects: &[Value<'_>], path: &Path, context: &mut Context) {
    for object in objects {
        let Ok(mut table) = object.table() else { continue };
        if let (Some(Ok(file)), None) = (table.get("mesh").map(|v| v.string()), table.get("clip")) {
            context.kept.count(path.with_file_name("").join(file));
        }
    }
}

/// Reads one of `[[objects]]`: several objects where a glTF file has several parts.
pub(crate) fn read_object<'s>(
    mut t: Table<'s>,
    index: usize,
    path: &Path,
    origin: DVec3,
    materials: &mut Materials,
    context: &mut Context,
) -> Result<Read<'s>, SceneError> {
    let light = t.get("light").map(|key| key.boolean().map(|is_light| (key, is_light))).transpose()?;
    let name = t.get("name").map_or(Ok(format!("object {index}")), |v| v.string().map(str::to_owned))?;
    let wish = read_normals(&mut t)?;
    let terminator = t.get("terminator").map_or(Ok(context.terminator), read_terminator)?;
    let (shape, value) = t.one_of(&["quad", "plane", "box", "sphere", "spheres", "mesh"])?;
    let clip = t.get("clip").map(|v| read_clip(v).map(|name| (v, name))).transpose()?;
    let first_clip = context.clips.len();
    let (geometry, origins) = geometry(shape, value, path, clip, origin, context)?;
    for clip in &mut context.clips[first_clip..] {
        *clip = format!("{name}/{clip}");
    }
    let material = t.get("material").map(|v| materials.named(v)).transpose()?;
    let visible = t.get("visible").map_or(Ok(true), |v| v.boolean())?;
    let strategy = t.get("visibility").map(read_strategy).transpose()?;
    let (stand, place) = transform(&mut t, &origins)?;
    let proxy_key = t.get("proxy");
    let proxy = proxy_key.map(|v| read_proxy(v, path, origins.own)).transpose()?;
    // Who says that nothing stands for it says that it blocks nothing.
    let strategy = strategy.or((proxy == Some(Proxy::None)).then_some(Strategy::None));
    let keys = Keys::read(&mut t)?;
    t.finish()?;

    let round = matches!(geometry, Geometry::Spheres(_)) || matches!(proxy, Some(Proxy::Spheres(_)));
    let placement = stand.placement(keys, origins, round)?;
    let matrix = placement.at(0.0);
    let of_kind = if shape == "box" { Normals::default() } else { context.normals };
    let normals = (wish.unwrap_or(of_kind), wish.is_some());
    let mut common = Common {
        name,
        material,
        visible,
        strategy,
        terminator,
        normals,
        proxy,
        shape,
        value,
        proxy_key,
        place,
        placement,
        matrix,
    };
    common.place_proxy(&origins)?;
    let objects = match geometry {
        Geometry::Spheres(own) => common.spheres(own, path, materials, context)?,
        Geometry::Flat(mesh) => common.flat(mesh, path, materials, context)?,
        Geometry::Solid(parts) => common.solid(parts, path, materials, context)?,
    };
    Ok(Read { objects, light })
}

impl Common<'_> {
    /// A uniform scale: all that spheres can follow.
    fn scale(&self) -> Result<f32, SceneError> {
        let axis = self.matrix.x_axis.truncate();
        match self.place.or(self.proxy_key) {
            Some(place) if !scales_evenly(&self.matrix, axis.as_dvec3().length(), 1e-4) => Err(place.error(UNEVEN)),
            _ => Ok(axis.length()),
        }
    }

    fn moved(&self, spheres: &[Sphere]) -> Result<Vec<Sphere>, SceneError> {
        let scale = self.scale()?;
        let moved = |b: &Sphere| Sphere { center: self.matrix.transform_point3(b.center), radius: b.radius * scale };
        Ok(spheres.iter().map(moved).collect())
    }

    /// The proxy where the object stands.
    fn place_proxy(&mut self, origins: &Origins) -> Result<(), SceneError> {
        self.proxy = match self.proxy.take() {
            Some(Proxy::Spheres(spheres)) => {
                let spheres = self.moved(&spheres)?;
                Scene::check_spheres(&spheres).map_err(|e| self.proxy_key.unwrap_or(self.value).error(e))?;
                Some(Proxy::Spheres(spheres))
            }
            Some(Proxy::File { path, .. }) => {
                // Sets in files are in the coordinates that the mesh's file means.
                let own = relative(-origins.own, DVec3::ZERO);
                let placement = if own == Vec3::ZERO { self.matrix } else { self.matrix * Mat4::from_translation(own) };
                self.scale().map(|_| Some(Proxy::File { path, placement }))?
            }
            other => other,
        };
        Ok(())
    }

    fn object(&self, name: String, shape: Shape, material: usize, proxy: Proxy) -> Object {
        let &Self { visible, strategy, terminator, .. } = self;
        Object { name, shape, material, proxy, visible, strategy, terminator }
    }

    fn spheres(
        self,
        own: Vec<Sphere>,
        path: &Path,
        materials: &mut Materials,
        context: &mut Context,
    ) -> Result<Placed, SceneError> {
        let spheres = self.moved(&own)?;
        let moves = !self.placement.is_fixed();
        Scene::check_spheres(&spheres).map_err(|e| self.value.error(e))?;
        let proxy = match &self.proxy {
            Some(Proxy::Count(_)) => return Err(self.value.error("exact spheres need no built proxy")),
            Some(Proxy::File { .. }) if moves => {
                return Err(self.value.error("a set in a file does not follow them: spheres that move need no proxy"));
            }
            other => other.clone().unwrap_or_else(|| Proxy::Spheres(spheres.clone())),
        };
        let material = self.material.unwrap_or_else(|| materials.fallback());
        if materials.cut_out(material).is_some() {
            let name = &self.name;
            context
                .warn(path, format!("object \"{name}\" stays whole: alpha cuts nothing out of spheres, but of meshes"));
        }
        let bound = bind(&proxy, &self.matrix);
        let object = self.object(self.name.clone(), Shape::Spheres(spheres), material, proxy);
        let mover = moves.then_some(Mover { placement: self.placement, body: Body::Spheres(own), proxy: bound });
        Ok(vec![(object, mover)])
    }

    fn flat(
        self,
        mesh: Mesh,
        path: &Path,
        materials: &mut Materials,
        context: &mut Context,
    ) -> Result<Placed, SceneError> {
        let mut part = Part::fixed(self.name.clone(), mesh, None);
        let mover = part.place(Normals::Face, &self.placement);
        part.mesh.validate().map_err(|e| self.value.error(e))?;
        let material = self.material.unwrap_or_else(|| materials.fallback());
        if let Some(cut_out) = materials.cut_out(material) {
            context.cut_out(path, &part.name, cut_out, (&mut part.mesh, &[]), mover.is_some());
        }
        if part.mesh.triangles.is_empty() {
            return Err(self.value.error(context.cut_away()));
        }
        let proxy = self.proxy.clone().unwrap_or(Proxy::None);
        let mover = mover.map(|m| Mover { proxy: bind(&proxy, &self.matrix), ..m });
        Ok(vec![(self.object(part.name, Shape::Mesh(part.mesh), material, proxy), mover)])
    }

    /// The parts that are left where their material is not cut out, and their motion.
    fn placed(
        &self,
        parts: Vec<Part>,
        path: &Path,
        materials: &Materials,
        context: &mut Context,
    ) -> Result<(Vec<Part>, Vec<Option<Mover>>), SceneError> {
        let (normals, is_wish) = self.normals;
        let (mut placed, mut movers) = (Vec::new(), Vec::new());
        for mut part in parts {
            let was_shared = part.instances.is_some();
            let mover = part.place(normals, &self.placement);
            if let Some(cut_out) = self.material.and_then(|material| materials.cut_out(material)) {
                let name = part.name.clone();
                context.cut_out(path, &name, cut_out, (part.own(), &[]), mover.is_some());
            }
            if was_shared && part.instances.is_none() {
                context.files.budget.take_mesh(&part.mesh, 1, &part.name).map_err(|e| self.value.error(e))?;
            }
            if !part.is_empty() {
                part.validate().map_err(|e| self.value.error(e))?;
                placed.push(part);
                movers.push(mover);
            }
        }
        if self.shape == "mesh" {
            context.tell_smoothed(&path.with_file_name("").join(self.value.string()?), &placed, normals, is_wish);
        }
        let cut_away = context.cut_away();
        if placed.is_empty() {
            let why = if cut_away.is_empty() { "mesh has no triangles once it is placed" } else { &cut_away };
            return Err(self.value.error(why));
        }
        if !cut_away.is_empty() {
            context.warn(path, cut_away);
        }
        Ok((placed, movers))
    }

    fn solid(
        self,
        parts: Vec<Part>,
        path: &Path,
        materials: &mut Materials,
        context: &mut Context,
    ) -> Result<Placed, SceneError> {
        let (placed, movers) = self.placed(parts, path, materials, context)?;
        let single = placed.len() == 1;
        if !single && matches!(self.proxy, Some(Proxy::Spheres(_) | Proxy::File { .. })) {
            return Err(self.value.error(format!(
                "a mesh of {} parts takes no single sphere set: expected \"none\" or a number of spheres",
                placed.len()
            )));
        }
        let proxies = match &self.proxy {
            Some(Proxy::Count(_)) | None => {
                let count = if let Some(Proxy::Count(count)) = self.proxy { count } else { DEFAULT_SPHERES };
                share_out(count, &placed).into_iter().map(Proxy::Count).collect()
            }
            Some(other) => vec![other.clone(); placed.len()],
        };
        let mut own: HashMap<usize, usize> = HashMap::new();
        let mut out = Vec::new();
        for ((mut part, mover), proxy) in placed.into_iter().zip(movers).zip(proxies) {
            let material = match (self.material, part.material.take()) {
                (Some(index), _) => index,
                (None, Some((key, m))) => *own.entry(key).or_insert_with(|| materials.push(m)),
                (None, None) => {
                    context.warnings.extend(context.no_library.take());
                    materials.fallback()
                }
            };
            let name = if single { self.name.clone() } else { format!("{}/{}", self.name, part.name) };
            let mover = mover.map(|mover| {
                let proxy = context.bind_proxy(&mover, &part.mesh, &proxy);
                Mover { proxy, ..mover }
            });
            out.push((self.object(name, part.into_shape(), material, proxy), mover));
        }
        Ok(out)
    }
}

/// The spheres of an explicit proxy, carried by a placement that is `matrix` now.
fn bind(proxy: &Proxy, matrix: &Mat4) -> Vec<BoundSphere> {
    let Proxy::Spheres(spheres) = proxy else { return Vec::new() };
    spheres.iter().map(|&b| BoundSphere::new(b, [0; 4], [1.0, 0.0, 0.0, 0.0], std::slice::from_ref(matrix))).collect()
}

fn read_terminator(v: Value<'_>) -> Result<Terminator, SceneError> {
    match v.string()? {
        "exact" => Ok(Terminator::Exact),
        "smooth" => Ok(Terminator::Smooth),
        _ => Err(v.error("expected \"exact\" or \"smooth\"")),
    }
}

/// The normals that a mesh gets, where its table says so.
fn read_normals(t: &mut Table<'_>) -> Result<Option<Normals>, SceneError> {
    let (normals, crease) = (t.get("normals"), t.get("crease"));
    let wish = match normals.map(|v| v.string().map(|name| (v, name))).transpose()? {
        None => None,
        Some((_, "file")) => Some(Normals::File),
        Some((_, "face")) => Some(Normals::Face),
        Some((_, "smooth")) => Some(Normals::SMOOTH),
        Some((v, _)) => return Err(v.error("expected \"file\", \"face\" or \"smooth\"")),
    };
    let Some(crease) = crease else { return Ok(wish) };
    if !matches!(wish, Some(Normals::Smooth { .. })) {
        return Err(crease.error("a crease angle is for normals = \"smooth\""));
    }
    match crease.positive()? {
        degrees if degrees <= 180.0 => Ok(Some(Normals::Smooth { crease: degrees })),
        degrees => Err(crease.error(format!("{degrees} must lie between 0 and 180 degrees"))),
    }
}

/// The name or number of a clip.
fn read_clip(v: Value<'_>) -> Result<String, SceneError> {
    if v.is_string() { v.string().map(str::to_owned) } else { v.whole(0, u32::MAX).map(|n| n.to_string()) }
}

fn geometry(
    shape: &str,
    value: Value<'_>,
    path: &Path,
    clip: Option<(Value<'_>, String)>,
    origin: DVec3,
    context: &mut Context,
) -> Result<(Geometry, Origins), SceneError> {
    if let (Some((place, _)), true) = (&clip, shape != "mesh") {
        return Err(place.error("only meshes of glTF files have clips"));
    }
    if shape == "spheres" {
        let origins = Origins::of(origin, value.first_place()?);
        return Ok((Geometry::Spheres(value.spheres(origins.own)?), origins));
    }
    if shape == "mesh" {
        let file = path.with_file_name("").join(value.string()?);
        let (place, clip) = clip.map_or((value, None), |(place, name)| (place, Some(name)));
        let parts = kept_parts(&file, clip.as_deref(), context).map_err(|e| place.error(e))?;
        return Ok((Geometry::Solid(parts), Origins { own: context.origin, world: origin }));
    }
    let mut t = value.table()?;
    let center = t.require(if shape == "plane" { "point" } else { "center" })?;
    let origins = Origins::of(origin, center.place()?);
    let center = center.relative(origins.own)?;
    let geometry = match shape {
        "quad" => {
            let (u, v) = (t.require("u")?, t.require("v")?);
            let [u, v] = Value::half_sides(&u, &v)?;
            Geometry::Flat(Mesh::quad(center, u, v))
        }
        "plane" => {
            let normal = t.require("normal")?.direction()?;
            let half = 0.5 * t.get("size").map_or(Ok(100.0), |v| v.positive())?;
            let (u, v) = lobe_core::orthonormal_basis(normal);
            Geometry::Flat(Mesh::quad(center, u * half, v * half))
        }
        "box" => {
            let size = t.require("size")?;
            let edges = size.vec3()?;
            if edges.min_element() <= 0.0 {
                return Err(size.error("all edges must be greater than 0"));
            }
            let mesh = Mesh::cuboid(center, edges);
            Geometry::Solid(vec![Part::fixed("box".to_owned(), mesh, None)])
        }
        _ => Geometry::Spheres(vec![Sphere { center, radius: t.require("radius")?.positive()? }]),
    };
    t.finish()?;
    Ok((geometry, origins))
}

/// How an object is placed at rest.
enum Stood {
    /// The matrix, and its translation in double precision.
    Matrix(Mat4, DVec3),
    Parts(Stand),
}

impl Stood {
    /// The placement over time, which scales a `round` object evenly.
    fn placement(self, keys: Option<Keys<'_>>, origins: Origins, round: bool) -> Result<Placement, SceneError> {
        match (keys, self) {
            (None, Self::Matrix(matrix, translation)) => {
                Ok(Placement::Fixed(origins.place_matrix(matrix, translation)))
            }
            (None, Self::Parts(stand)) => Ok(Placement::Fixed(stand.matrix(&origins))),
            (Some(keys), Self::Matrix(..)) => {
                Err(keys.error("an object with a matrix takes no keys: give scale, rotate and translate"))
            }
            (Some(keys), Self::Parts(own)) => keys.placement(own, origins, |v, s| {
                let even = (s - s.x).abs().max_element() <= 1e-4 * s.x.abs();
                if round && !even { Err(v.error(UNEVEN)) } else { Ok(()) }
            }),
        }
    }
}

/// The placement of the object, and the key to report if it does not suit the shape.
fn transform<'s>(t: &mut Table<'s>, origins: &Origins) -> Result<(Stood, Option<Value<'s>>), SceneError> {
    let (scale, rotate, translate, matrix) = (t.get("scale"), t.get("rotate"), t.get("translate"), t.get("matrix"));
    if let Some(m) = matrix {
        if scale.or(rotate).or(translate).is_some() {
            return Err(m.error("either a matrix or scale, rotate and translate, not both"));
        }
        return Ok((Stood::Matrix(m.mat4()?, m.translation()?), Some(m)));
    }
    let own = Stand::ORIGIN;
    let (axis, degrees) = rotate.map_or(Ok((own.axis, own.degrees)), read_rotation)?;
    let stand = Stand {
        scale: scale.map_or(Ok(own.scale), read_scale)?,
        axis,
        degrees,
        translation: translate.map_or(Ok(relative(DVec3::ZERO, origins.shift())), |v| v.relative(origins.shift()))?,
    };
    Ok((Stood::Parts(stand), scale))
}

fn read_strategy(value: Value<'_>) -> Result<Strategy, SceneError> {
    let name = value.string()?;
    Strategy::named(name).ok_or_else(|| {
        value.error(format!(
            "unknown strategy \"{name}\": expected \"spheres\", \"shadow-map\", \"silhouettes\", \"rays\" or \"none\""
        ))
    })
}

fn read_proxy(value: Value<'_>, path: &Path, origin: DVec3) -> Result<Proxy, SceneError> {
    let what = "expected \"none\", { spheres = N }, { file = \"set.json\" } or { explicit = [[x, y, z, radius], …] }";
    if value.is_string() {
        return if value.string()? == "none" { Ok(Proxy::None) } else { Err(value.error(what)) };
    }
    let mut t = value.table().map_err(|_| value.error(what))?;
    let proxy = match t.one_of(&["spheres", "file", "explicit"])? {
        ("spheres", v) => Proxy::Count(v.whole(1, 100_000)? as usize),
        ("file", v) => {
            let file = path.with_file_name("").join(v.string()?);
            if !file.is_file() {
                let what = if file.exists() { "a folder or a device, but no file:" } else { "there is no file" };
                return Err(v.error(format!("{what} {}", file.display())));
            }
            Proxy::File { path: file, placement: Mat4::IDENTITY }
        }
        (_, v) => Proxy::Spheres(v.spheres(origin)?),
    };
    t.finish()?;
    Ok(proxy)
}
