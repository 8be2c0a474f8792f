//! Files of all kinds to scenes.

use crate::animation::{Body, LightMover, LightPlace, Mover};
use crate::cut_out::CutOut;
use crate::deformer::{BoundBall, Deformer};
use crate::gltf_file::Read;
use crate::gltf_light::PlacedLight;
use crate::placement::Placement;
use crate::scene_file::{DEFAULT_FOV, DEFAULT_SIZE, DEFAULT_SPHERES};
use crate::skeleton::{Carrier, Skeleton};
use crate::{
    Animation, Bounds, Camera, Mesh, Object, Pose, Proxy, Scene, SceneError, Shape, Surface, gltf_file, obj, ply,
    scene_file,
};
use brdf::{Lambert, Material, ModifiedPhong};
use glam::{DVec3, Mat4, Vec3};
use lighting::SphereLight;
use lobe_core::Sphere;
use std::path::Path;

/// What a file brings besides its objects.
#[derive(Default)]
pub(crate) struct Context {
    /// Things that were left out or replaced, one line each.
    pub(crate) warnings: Vec<String>,
    /// The nodes of the glTF files with a clip that moves.
    pub(crate) skeletons: Vec<Skeleton>,
    /// Names of all clips.
    pub(crate) clips: Vec<String>,
    /// What the coordinates of the mesh file that was read last are relative to.
    pub(crate) origin: DVec3,
    /// The objects whose emission is a light.
    pub(crate) emitters: Vec<usize>,
}

impl Context {
    /// The animation of what was read.
    pub(crate) fn animation(&mut self) -> Animation {
        let (skeletons, clips) = (std::mem::take(&mut self.skeletons), std::mem::take(&mut self.clips));
        Animation { skeletons, clips, ..Animation::default() }
    }

    /// Binds the spheres of an explicit proxy to a mesh at its first moment.
    pub(crate) fn bind_proxy(&self, mover: &Mover, mesh: &Mesh, proxy: &Proxy) -> Vec<BoundBall> {
        let (Proxy::Spheres(balls), Body::Mesh(deformer, carrier)) = (proxy, &mover.body) else { return Vec::new() };
        let skeleton = carrier.as_ref().map(|c| &self.skeletons[c.skeleton]);
        let worlds = skeleton.map_or_else(Vec::new, |s| s.worlds(0.0));
        let mut pose = Pose::default();
        mover.pose(0.0, skeleton, &worlds, &mut pose);
        balls.iter().map(|&b| deformer.bind_ball(b, &mesh.positions, &pose.joints)).collect()
    }

    pub(crate) fn warn(&mut self, path: &Path, message: impl std::fmt::Display) {
        self.warnings.push(SceneError::file(path, message.to_string()).to_string());
    }

    /// Cuts what is not there out of a mesh.
    pub(crate) fn cut_out(&mut self, path: &Path, name: &str, cut_out: &CutOut, mesh: &mut Mesh, moves: bool) {
        if moves {
            self.warn(path, format!("\"{name}\" moves: it is opaque where its alpha would cut it out"));
        } else if !cut_out.cut(mesh) {
            self.warn(path, format!("\"{name}\" repeats its image too often to be cut out: it is opaque"));
        }
    }

    /// Warns of what a file has that is left out, if anything; an error where there is nothing else in it.
    pub(crate) fn left_out(&mut self, path: &Path, is_all: bool, what: &str) -> Result<(), SceneError> {
        match (is_all, what.is_empty()) {
            (true, true) => return Err(SceneError::file(path, "no triangles")),
            (true, false) => return Err(SceneError::file(path, format!("no triangles: {what}"))),
            (false, true) => {}
            (false, false) => self.warn(path, what),
        }
        Ok(())
    }
}

/// How many of something were left out and why; empty for none.
pub(crate) fn counted(count: usize, noun: &str, why: &str) -> String {
    match count {
        0 => String::new(),
        1 => format!("1 {noun} left out for {why}"),
        _ => format!("{count} {noun}s left out for {why}"),
    }
}

/// A material and what its surfaces show beside it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    pub(crate) material: Material,
    pub(crate) surface: Surface,
    /// What of its surfaces is there; all without.
    pub(crate) cut_out: Option<CutOut>,
}

impl<M: Into<Material>> From<M> for Look {
    fn from(material: M) -> Self {
        Self { material: material.into(), surface: Surface::default(), cut_out: None }
    }
}

impl Look {
    /// Materials and surfaces of a scene; no surfaces where all are plain.
    pub(crate) fn parted(looks: Vec<Self>) -> (Vec<Material>, Vec<Surface>) {
        let is_plain = looks.iter().all(|look| look.surface.is_plain());
        let (materials, surfaces) = looks.into_iter().map(|look| (look.material, look.surface)).unzip();
        (materials, if is_plain { Vec::new() } else { surfaces })
    }
}

/// A mesh of a file, with the look that the file gives it: a number that is the same for the same look, and it.
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) mesh: Mesh,
    pub(crate) material: Option<(usize, Look)>,
    /// What its file moves it with.
    pub(crate) rig: Option<(Deformer, Carrier)>,
}

/// Which normals a mesh is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Normals {
    /// The file's; smooth ones where it has none.
    File,
    Face,
    Smooth,
}

impl Part {
    pub(crate) fn fixed(name: String, mesh: Mesh, material: Option<(usize, Look)>) -> Self {
        Self { name, mesh, material, rig: None }
    }

    /// Takes out the triangles that never have an area and tells how many there were; those that are there twice, too.
    fn clean(&mut self) -> usize {
        let dropped = match self.rig {
            None => self.mesh.remove_degenerate(),
            // What is flat at the first moment may open later.
            Some(_) => self.mesh.remove_repeated(),
        };
        self.mesh.remove_doubles(self.rig.is_some());
        dropped
    }

    /// Gives the mesh its normals and puts it where it stands first; what moves it then, if anything does.
    pub(crate) fn place(&mut self, normals: Normals, placement: &Placement) -> Option<Mover> {
        let smooth = match normals {
            Normals::File => self.mesh.normals.is_empty(),
            Normals::Face => {
                self.mesh.normals.clear();
                false
            }
            Normals::Smooth => true,
        };
        if smooth {
            self.mesh.smooth_normals();
        }
        let body = match self.rig.take() {
            Some((mut deformer, carrier)) => {
                match normals {
                    Normals::Face => deformer.drop_normals(),
                    _ if smooth => deformer.smooth_normals(&self.mesh),
                    _ => {}
                }
                Some(Body::Mesh(Box::new(deformer), Some(carrier)))
            }
            None if placement.is_fixed() => None,
            None => Some(Body::Mesh(Box::new(Deformer::rigid(&self.mesh)), None)),
        };
        self.mesh.transform(&placement.at(0.0));
        let fixed = body.is_none();
        if fixed {
            self.mesh.remove_degenerate();
        }
        body.map(|body| Mover { placement: placement.clone(), body, proxy: Vec::new() })
    }
}

/// Loads a scene: a scene file (`.toml`; keys in [`SCHEMA_EXAMPLE`](crate::SCHEMA_EXAMPLE)), or a mesh (`.obj`, `.ply`,
/// `.gltf`, `.glb`) to which a floor, a light and, where the file has none, a camera are added. What moves is as at its
/// first moment: [`load_animated`] gives the others.
///
/// # Errors
/// [`SceneError`], one line with the file and, for text files, the line.
///
/// ```no_run
/// let scene = scene::load("scenes/soft_spheres.toml")?;
/// println!("{} objects", scene.objects.len());
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    load_with_warnings(path).map(|(scene, _)| scene)
}

/// As [`load`]; also tells in one line each what was left out or replaced (textures, degenerate triangles, …).
///
/// # Errors
/// As [`load`].
pub fn load_with_warnings(path: impl AsRef<Path>) -> Result<(Scene, Vec<String>), SceneError> {
    load_animated(path).map(|(scene, _, warnings)| (scene, warnings))
}

/// As [`load_with_warnings`], with what moves. The scene is as [`Animation::seek`] to 0 leaves it.
///
/// Of a glTF file without a scene file the first clip is played.
///
/// # Errors
/// As [`load`].
pub fn load_animated(path: impl AsRef<Path>) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    load_any(path.as_ref(), None)
}

/// As [`load_animated`], of a glTF file with the clip of that name, or of that number from 0 when no clip has the name.
/// A scene file names the clips of its objects itself.
///
/// # Errors
/// As [`load`], and when there is no such clip or it is broken.
pub fn load_clip(path: impl AsRef<Path>, clip: &str) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    load_any(path.as_ref(), Some(clip))
}

/// The objects of a mesh file (`.obj`, `.ply`, `.gltf`, `.glb`) alone, at the first moment of its first clip or of the one
/// named as for [`load_clip`]: no floor, light or camera is added. An object's number is that of the animation; its material
/// is a number only.
///
/// # Errors
/// As [`load_clip`]; a scene file is refused.
///
/// ```no_run
/// let (objects, _animation, _warnings) = scene::load_objects("spot.obj", None)?;
/// println!("{} objects", objects.len());
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load_objects(
    path: impl AsRef<Path>,
    clip: Option<&str>,
) -> Result<(Vec<Object>, Animation, Vec<String>), SceneError> {
    let (path, mut context) = (path.as_ref(), Context::default());
    let file = file_parts(path, clip, &mut context, MESH_OR_SCENE)?;
    let Bare { mut objects, animation, .. } = bare_objects(file, &mut context);
    animation.move_objects(0.0, &animation.worlds(0.0), &mut objects);
    for object in &objects {
        if let Shape::Mesh(mesh) = &object.shape {
            mesh.validate().map_err(|e| SceneError::file(path, format!("object \"{}\": {e}", object.name)))?;
        }
    }
    Ok((objects, animation, context.warnings))
}

/// The mesh of an OBJ file's text, such as one that a program carries: all its parts as one, smooth normals where the text has none,
/// without materials. Messages call the text `name`.
///
/// # Errors
/// [`SceneError`], one line with the name and the line.
///
/// ```
/// let mesh = scene::obj_mesh("corner", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn obj_mesh(name: &str, text: &str) -> Result<Mesh, SceneError> {
    let path = Path::new(name);
    let mut all = Mesh::default();
    for mut part in obj::parse(path, text, &mut Context::default())? {
        part.mesh.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
        part.clean();
        part.place(Normals::File, &Placement::Fixed(Mat4::IDENTITY));
        all.append(&part.mesh);
    }
    Ok(all)
}

fn load_any(path: &Path, clip: Option<&str>) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    let mut context = Context::default();
    let (mut scene, animation) = if extension(path) == "toml" {
        if clip.is_some() {
            return Err(SceneError::file(path, "a scene file names the clips of its objects itself"));
        }
        let text = read_text(path)?;
        scene_file::parse(path, &text, &mut context)?
    } else {
        bare(path, clip, &mut context)?
    };
    for object in 0..scene.objects.len() {
        let surface = scene.surface(scene.objects[object].material);
        let is_lamp = surface.is_some_and(|s| s.emits() && !s.is_unlit) && !context.emitters.contains(&object);
        if is_lamp && !is_at_a_light(&scene, object) {
            let name = &scene.objects[object].name;
            let advice = "emits, but lights no other: a scene file's object does with `light = true`";
            context.warn(path, format!("object \"{name}\" {advice}"));
            break;
        }
    }
    for object in &scene.objects {
        let is_lamp = |ball| scene.lights.iter().any(|light| light.is_shown_by(ball));
        let is_dark = object.visible && !scene.surface(object.material).is_some_and(Surface::emits);
        if is_dark && matches!(&object.shape, Shape::Spheres(balls) if balls.iter().any(is_lamp)) {
            let name = &object.name;
            context
                .warn(path, format!("object \"{name}\" shows a light, but shines not: its material has no `emission`"));
        }
    }
    let wants_uvs = |o: &&Object| scene.surface(o.material).is_some_and(Surface::has_textures);
    let has_none = |o: &&Object| matches!(&o.shape, Shape::Mesh(mesh) if mesh.uv_sets.is_empty());
    for object in scene.objects.iter().filter(wants_uvs).filter(has_none) {
        let name = &object.name;
        context.warn(path, format!("object \"{name}\" has no texture coordinates: it shows a corner of its textures"));
    }
    if !animation.is_still() {
        animation.seek(0.0, &mut scene);
        scene.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
    }
    Ok((scene, animation, context.warnings))
}

/// Whether a light stands in an object, or by it: then the object shows the light.
fn is_at_a_light(scene: &Scene, object: usize) -> bool {
    let bounds = scene.objects[object].shape.bounds();
    let reach = 0.25 * bounds.radius();
    let is_near = |center: Vec3| center.distance(center.clamp(bounds.min, bounds.max)) <= reach;
    scene.lights.iter().filter_map(scene_file::place_of).any(is_near)
}

/// The ending of a file's name, in small letters.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase())
}

/// The bytes of a regular file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, SceneError> {
    let fail = |source| SceneError::Read { path: path.to_owned(), source };
    // A device or a pipe may never end.
    if !std::fs::metadata(path).map_err(fail)?.is_file() {
        return Err(SceneError::file(path, "not a regular file"));
    }
    std::fs::read(path).map_err(fail)
}

pub(crate) fn read_text(path: &Path) -> Result<String, SceneError> {
    into_text(path, read(path)?)
}

fn into_text(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        SceneError::at_line(path, line, "not UTF-8 text")
    })
}

/// The text of an OBJ file. Names and comments may be in any encoding: what is not UTF-8 in them is replaced.
fn obj_text(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    const WORDS: [&[u8]; 6] = [b"o", b"g", b"s", b"usemtl", b"mtllib", b"usemap"];
    String::from_utf8(bytes).or_else(|e| {
        let bytes = e.into_bytes();
        for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
            let begin = line.trim_ascii_start();
            let word = begin.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            let free = begin.starts_with(b"#") || WORDS.contains(&word);
            // A comment may follow numbers.
            let read = line.split(|b| *b == b'#').next().unwrap_or_default();
            if !free && std::str::from_utf8(read).is_err() {
                return Err(SceneError::at_line(path, number + 1, "not UTF-8 text"));
            }
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    })
}

/// The meshes of a file, degenerate triangles taken out; of a glTF with the clip of that name or number. Relative to
/// [`Context::origin`], which is not zero where the file's meshes are far from its origin.
pub(crate) fn mesh_parts(path: &Path, clip: Option<&str>, context: &mut Context) -> Result<Vec<Part>, SceneError> {
    let file = near_parts(path, clip, context, ".obj, .ply, .gltf or .glb")?;
    if !file.lights.is_empty() {
        context.warn(path, "its lights are left out: the scene file has its own");
    }
    Ok(file.parts)
}

fn near_parts(path: &Path, clip: Option<&str>, context: &mut Context, endings: &str) -> Result<Read, SceneError> {
    let (lines, skeletons, clips) = (context.warnings.len(), context.skeletons.len(), context.clips.len());
    context.origin = DVec3::ZERO;
    let file = file_parts(path, clip, context, endings)?;
    let bounds = file.parts.iter().fold(Bounds::EMPTY, |b, part| b.union(part.mesh.bounds()));
    context.origin = crate::origin::near(bounds.center(), bounds.radius());
    if context.origin == DVec3::ZERO {
        return Ok(file);
    }
    context.warnings.truncate(lines);
    context.skeletons.truncate(skeletons);
    context.clips.truncate(clips);
    file_parts(path, clip, context, endings)
}

fn file_parts(path: &Path, clip: Option<&str>, context: &mut Context, endings: &str) -> Result<Read, SceneError> {
    let extension = extension(path);
    if !["obj", "ply", "gltf", "glb"].contains(&extension.as_str()) {
        read(path)?;
        return Err(SceneError::file(path, format!("unknown kind of file: expected {endings}")));
    }
    let bytes = read(path)?;
    if bytes.is_empty() {
        return Err(SceneError::file(path, "file is empty"));
    }
    let is = |magic: &[u8]| bytes.starts_with(magic);
    if clip.is_some() && ["obj", "ply"].contains(&extension.as_str()) {
        return Err(SceneError::file(path, "only glTF files have clips"));
    }
    let meshes = |parts| Read { parts, ..Read::default() };
    let mut file = match extension.as_str() {
        "obj" if is(b"ply\n") || is(b"ply\r") => {
            return Err(SceneError::file(path, "looks like a PLY file: expected the ending .ply"));
        }
        "obj" => meshes(obj::parse(path, &obj_text(path, bytes)?, context)?),
        "ply" => meshes(vec![ply::parse(path, &bytes, context.origin)?]),
        "glb" if is(b"\x89PNG") => return Err(SceneError::file(path, "not a GLB file: looks like a PNG image")),
        _ => gltf_file::parse(path, &bytes, clip, context)?,
    };
    let mut dropped = 0;
    let parts = &mut file.parts;
    for part in parts.iter_mut() {
        // Indices first: the geometry below relies on them.
        if !part.mesh.triangles.is_empty() {
            part.mesh.validate().map_err(|e| SceneError::file(path, format!("{}: {e}", part.name)))?;
        }
        dropped += part.clean();
    }
    parts.retain(|part| !part.mesh.triangles.is_empty());
    let mut what = counted(dropped, "triangle", "having no area");
    if parts.is_empty() && dropped > 0 {
        what += " (corners equal or in a line, or nearer to each other than about 1e-18)";
    }
    context.left_out(path, parts.is_empty(), &what)?;
    Ok(file)
}

/// Shares a number of spheres out among parts in proportion to their areas, at least four each (fewer when fewer were
/// asked for).
pub(crate) fn share_out(total: usize, parts: &[Part]) -> Vec<usize> {
    let areas: Vec<f64> = parts.iter().map(|p| p.mesh.area()).collect();
    let sum: f64 = areas.iter().sum();
    let least = total.min(4);
    if parts.len() == 1 {
        return vec![total];
    }
    areas.iter().map(|a| ((total as f64 * a / sum).round() as usize).max(least)).collect()
}

pub(crate) fn default_material() -> Material {
    Lambert { albedo: Vec3::splat(0.5) }.into()
}

/// Looks at everything from the front, a little from the right and from above.
pub(crate) fn default_camera(bounds: Bounds, width: u32, height: u32) -> Camera {
    Camera::framing(bounds, Vec3::new(0.35, 0.5, 1.0), DEFAULT_FOV.to_radians(), width, height)
}

/// The box that holds the objects at all times, near enough: at so many moments.
fn swept_bounds(animation: &Animation, objects: &mut [Object]) -> Bounds {
    const MOMENTS: u32 = 16;
    let moments = if animation.is_still() { 1 } else { MOMENTS };
    let mut bounds = Bounds::EMPTY;
    // The first moment last: it is what remains.
    for i in (0..moments).rev() {
        let time = animation.duration() * i as f32 / MOMENTS as f32;
        animation.move_objects(time, &animation.worlds(time), objects);
        bounds = objects.iter().fold(bounds, |b, o| b.union(o.shape.bounds()));
    }
    bounds
}

/// What a mesh file shows, without the floor and the light that [`bare`] adds. The objects are not posed yet.
struct Bare {
    objects: Vec<Object>,
    looks: Vec<Look>,
    animation: Animation,
    camera: Option<Camera>,
    lights: Vec<PlacedLight>,
}

const MESH_OR_SCENE: &str = ".toml, .obj, .ply, .gltf or .glb";

fn bare_objects(file: Read, context: &mut Context) -> Bare {
    let Read { mut parts, camera, moving_camera, lights } = file;
    let mut animation = Animation { origin: context.origin, camera: moving_camera, ..context.animation() };
    let here = Placement::Fixed(Mat4::IDENTITY);
    animation.movers = parts.iter_mut().map(|part| part.place(Normals::File, &here)).collect();
    let floor = ModifiedPhong { kd: Vec3::splat(0.32), ks: Vec3::splat(0.18), exponent: 50.0 };
    let mut looks: Vec<Look> = vec![floor.into(), default_material().into()];
    let mut keys: Vec<(usize, usize)> = Vec::new();
    let counts = share_out(DEFAULT_SPHERES, &parts);
    let mut objects = Vec::new();
    for (part, count) in parts.into_iter().zip(counts) {
        let material = match part.material {
            None => 1,
            Some((key, look)) => match keys.iter().find(|(k, _)| *k == key) {
                Some(&(_, index)) => index,
                None => {
                    looks.push(look);
                    keys.push((key, looks.len() - 1));
                    looks.len() - 1
                }
            },
        };
        objects.push(Object::mesh(part.name, part.mesh, material, Proxy::Count(count)));
    }
    Bare { objects, looks, animation, camera, lights }
}

/// A mesh file as a scene of its own. Floor, light and camera suit the whole animation.
fn bare(path: &Path, clip: Option<&str>, context: &mut Context) -> Result<(Scene, Animation), SceneError> {
    let file = near_parts(path, clip, context, MESH_OR_SCENE)?;
    let Bare { mut objects, looks, mut animation, camera, lights: own } = bare_objects(file, context);
    let bounds = swept_bounds(&animation, &mut objects);
    let radius = bounds.radius();
    let (width, height) = DEFAULT_SIZE;
    // A little below the lowest point: a model with a floor of its own must not lie in ours.
    let ground = Vec3::new(bounds.center().x, bounds.min.y - 1e-3 * radius, bounds.center().z);
    let half = 60.0 * radius;
    let floor = Mesh::quad(ground, Vec3::X * half, Vec3::NEG_Z * half);
    objects.insert(0, Object::mesh("floor", floor, 0, Proxy::None));
    animation.movers.insert(0, None);
    // Half-angle 6° from the middle of the model, and an irradiance of π there.
    let distance = 5.0 * radius;
    let sin = 6.0_f32.to_radians().sin();
    let center = bounds.center() + distance * Vec3::new(-0.5, 0.9, 0.55).normalize();
    let ball = Sphere { center, radius: distance * sin };
    let mut lights = vec![SphereLight::new(ball, Vec3::splat(1.0 / (sin * sin))).into()];
    if !own.is_empty() {
        lights = own.iter().map(|own| own.light.at_origin(&bounds).moved(own.world)).collect();
        animation.lights = own
            .iter()
            .enumerate()
            .filter_map(|(first, own)| {
                let (skeleton, node) = own.mover?;
                let placement = LightPlace::Node { skeleton, node };
                Some(LightMover { first, lights: vec![own.light.at_origin(&bounds)], placement })
            })
            .collect();
    }
    let camera = camera.unwrap_or_else(|| default_camera(bounds, width, height));
    let (materials, surfaces) = Look::parted(looks);
    let scene = Scene {
        camera,
        width,
        height,
        background: Vec3::ZERO,
        environment: None,
        materials,
        surfaces,
        objects,
        lights,
    };
    scene.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
    Ok((scene, animation))
}
