//! Files of all kinds to scenes.

use crate::scene_file::{DEFAULT_FOV, DEFAULT_SIZE, DEFAULT_SPHERES};
use crate::{Bounds, Camera, Mesh, Object, Proxy, Scene, SceneError, gltf_file, obj, ply, scene_file};
use brdf::{Lambert, Material, ModifiedPhong};
use glam::Vec3;
use lighting::SphereLight;
use lobe_core::Sphere;
use std::path::Path;

/// What a file brings besides its objects.
#[derive(Default)]
pub(crate) struct Context {
    /// Things that were left out or replaced, one line each.
    pub(crate) warnings: Vec<String>,
}

impl Context {
    pub(crate) fn warn(&mut self, path: &Path, message: impl std::fmt::Display) {
        self.warnings.push(SceneError::file(path, message.to_string()).to_string());
    }
}

/// A mesh of a file, with the material that the file gives it: a number that is the same for the same material, and it.
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) mesh: Mesh,
    pub(crate) material: Option<(usize, Material)>,
}

/// Loads a scene: a scene file (`.toml`; keys in [`SCHEMA_EXAMPLE`](crate::SCHEMA_EXAMPLE)), or a mesh (`.obj`, `.ply`,
/// `.gltf`, `.glb`) to which a floor, a light and, where the file has none, a camera are added.
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
    let path = path.as_ref();
    let mut context = Context::default();
    let scene = if extension(path) == "toml" {
        let text = read_text(path)?;
        scene_file::parse(path, &text, &mut context)?
    } else {
        bare(path, &mut context)?
    };
    Ok((scene, context.warnings))
}

fn extension(path: &Path) -> String {
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

/// The meshes of a file, degenerate triangles taken out.
pub(crate) fn mesh_parts(path: &Path, context: &mut Context) -> Result<Vec<Part>, SceneError> {
    file_parts(path, context, ".obj, .ply, .gltf or .glb").map(|(parts, _)| parts)
}

fn file_parts(path: &Path, context: &mut Context, endings: &str) -> Result<(Vec<Part>, Option<Camera>), SceneError> {
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
    let (mut parts, camera) = match extension.as_str() {
        "obj" if is(b"ply\n") || is(b"ply\r") => {
            return Err(SceneError::file(path, "looks like a PLY file: expected the ending .ply"));
        }
        "obj" => (vec![obj::parse(path, &into_text(path, bytes)?, context)?], None),
        "ply" => (vec![ply::parse(path, &bytes)?], None),
        "glb" if is(b"\x89PNG") => return Err(SceneError::file(path, "not a GLB file: looks like a PNG image")),
        _ => gltf_file::parse(path, &bytes, context)?,
    };
    let mut dropped = 0;
    for part in &mut parts {
        // Indices first: the geometry below relies on them.
        if !part.mesh.triangles.is_empty() {
            part.mesh.validate().map_err(|e| SceneError::file(path, format!("{}: {e}", part.name)))?;
        }
        dropped += part.mesh.remove_degenerate();
    }
    if dropped > 0 {
        context.warn(path, format!("{dropped} triangles without an area were left out"));
    }
    parts.retain(|part| !part.mesh.triangles.is_empty());
    if parts.is_empty() {
        return Err(SceneError::file(path, "no triangles"));
    }
    Ok((parts, camera))
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

/// A mesh file as a scene of its own.
fn bare(path: &Path, context: &mut Context) -> Result<Scene, SceneError> {
    let (mut parts, camera) = file_parts(path, context, ".toml, .obj, .ply, .gltf or .glb")?;
    let mut bounds = Bounds::EMPTY;
    for part in &mut parts {
        if part.mesh.normals.is_empty() {
            part.mesh.smooth_normals();
        }
        bounds = bounds.union(part.mesh.bounds());
    }
    let radius = bounds.radius();
    let (width, height) = DEFAULT_SIZE;
    let mut materials: Vec<Material> =
        vec![ModifiedPhong { kd: Vec3::splat(0.32), ks: Vec3::splat(0.18), exponent: 50.0 }.into(), default_material()];
    let mut keys: Vec<(usize, usize)> = Vec::new();
    let counts = share_out(DEFAULT_SPHERES, &parts);

    // A little below the lowest point: a model with a floor of its own must not lie in ours.
    let ground = Vec3::new(bounds.center().x, bounds.min.y - 1e-3 * radius, bounds.center().z);
    let half = 60.0 * radius;
    let floor = Mesh::quad(ground, Vec3::X * half, Vec3::NEG_Z * half);
    let mut objects = vec![Object::mesh("floor", floor, 0, Proxy::None)];
    for (part, count) in parts.into_iter().zip(counts) {
        let material = match part.material {
            None => 1,
            Some((key, material)) => match keys.iter().find(|(k, _)| *k == key) {
                Some(&(_, index)) => index,
                None => {
                    materials.push(material);
                    keys.push((key, materials.len() - 1));
                    materials.len() - 1
                }
            },
        };
        objects.push(Object::mesh(part.name, part.mesh, material, Proxy::Count(count)));
    }
    // Half-angle 6° from the middle of the model, and an irradiance of π there.
    let distance = 5.0 * radius;
    let sin = 6.0_f32.to_radians().sin();
    let center = bounds.center() + distance * Vec3::new(-0.5, 0.9, 0.55).normalize();
    let lights = vec![SphereLight::new(Sphere { center, radius: distance * sin }, Vec3::splat(1.0 / (sin * sin)))];
    let camera = camera.unwrap_or_else(|| default_camera(bounds, width, height));
    let scene = Scene { camera, width, height, background: Vec3::ZERO, materials, objects, lights };
    scene.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
    Ok(scene)
}
