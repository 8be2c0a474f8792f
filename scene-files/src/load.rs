//! Files of all kinds to scenes.

use crate::context::Context;
use crate::emission::light_up;
use crate::files::{Files, Source, extension};
use crate::gltf_document::GltfDocument;
use crate::mesh_file::file_parts;
use crate::mesh_scene::{Bare, MESH_OR_SCENE, bare, bare_objects};
use crate::{Emission, Normals, Studio, known_errors, obj, scene_file};
use glam::Mat4;
use scene::motion::Placement;
use scene::{Animation, Mesh, Object, Scene, SceneError, Shape, Surface, Terminator};
use std::path::Path;
use std::sync::Arc;

/// Loads a scene: a scene file (`.toml`; keys in [`SCHEMA_EXAMPLE`](crate::SCHEMA_EXAMPLE)), or a mesh (`.obj`, `.ply`,
/// `.gltf`, `.glb`) to which a floor and, where the file has none, [lights](Studio) and a camera are added. Moving objects stand at their
/// first moment: [`load_animated`] gives the others.
///
/// # Errors
/// [`SceneError`], one line with the file and, for text files, the line.
///
/// ```no_run
/// let scene = scene_files::load("scenes/soft_spheres.toml")?;
/// println!("{} objects", scene.objects.len());
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    load_with_warnings(path).map(|(scene, _)| scene)
}

/// As [`load`], with one line for each thing that was left out or replaced (textures, degenerate triangles, …).
///
/// # Errors
/// As [`load`].
pub fn load_with_warnings(path: impl AsRef<Path>) -> Result<(Scene, Vec<String>), SceneError> {
    load_animated(path).map(|(scene, _, warnings)| (scene, warnings))
}

/// As [`load_with_warnings`], with the animation. The scene is as [`Animation::seek`] to 0 leaves it.
///
/// Of a glTF file without a scene file the first clip is played.
///
/// # Errors
/// As [`load`].
pub fn load_animated(path: impl AsRef<Path>) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    load_any(path.as_ref(), None, Context::default())
}

/// As [`load_animated`], of a glTF file with the clip of that name, or of that number from 0 when no clip has the name.
/// A scene file names the clips of its objects itself.
///
/// # Errors
/// As [`load`], and when there is no such clip or it is broken.
pub fn load_clip(path: impl AsRef<Path>, clip: &str) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    load_any(path.as_ref(), Some(clip), Context::default())
}

/// As [`load_animated`], or [`load_clip`] where a clip is given, from other files than the disk's.
///
/// A sphere set that a scene file names is no part of it: it is read from the disk when the spheres are needed.
///
/// # Errors
/// As [`load_clip`].
///
/// ```
/// use std::collections::BTreeMap;
/// use std::path::PathBuf;
/// use std::sync::Arc;
/// let scene = "[[lights]]\nkind = \"sphere\"\ncenter = [0, 3, 0]\nradius = 0.5\nradiance = 9\n\
///              [[objects]]\nmesh = \"models/corner.obj\"\n";
/// let corner = "v 0 0 0\nv 1 0 0\nv 0 0 -1\nf 1 2 3\n";
/// let files = [("room.toml", scene), ("models/corner.obj", corner)];
/// let files: BTreeMap<_, _> = files.map(|(path, text)| (PathBuf::from(path), text.into())).into();
/// let (scene, _animation, _warnings) = scene_files::load_from(Arc::new(files), "room.toml", None)?;
/// assert_eq!(scene.triangles(), 1);
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load_from(
    files: Arc<dyn Files>,
    path: impl AsRef<Path>,
    clip: Option<&str>,
) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    load_any(path.as_ref(), clip, Context { files: Source::new(files), ..Context::default() })
}

/// The choices in how a scene is loaded.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LoadOptions {
    /// The clip of a glTF file, as for [`load_clip`].
    pub clip: Option<String>,
    /// The normals of the model, or of those models of a scene file for which it names none.
    pub normals: Normals,
    /// How light ends on smooth meshes, or on those of a scene file of which it does not say it.
    pub terminator: Terminator,
    /// Whether objects that emit light the others.
    pub emission: Emission,
    /// The lights of a model that brings none: [`Studio::Soft`] without a choice. A choice also lights a model in which objects emit; else these are
    /// all its lights, unless they are faint.
    pub studio: Option<Studio>,
}

impl LoadOptions {
    /// The defaults.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Plays that clip.
    #[must_use]
    pub fn with_clip(self, clip: Option<impl Into<String>>) -> Self {
        Self { clip: clip.map(Into::into), ..self }
    }

    /// Takes those normals.
    #[must_use]
    pub const fn with_normals(mut self, normals: Normals) -> Self {
        self.normals = normals;
        self
    }

    /// Lets light end so on smooth meshes.
    #[must_use]
    pub const fn with_terminator(mut self, terminator: Terminator) -> Self {
        self.terminator = terminator;
        self
    }

    /// Lights a model that brings no lights so.
    #[must_use]
    pub fn with_studio(self, studio: impl Into<Option<Studio>>) -> Self {
        Self { studio: studio.into(), ..self }
    }

    /// Lets objects that emit light the others, or not.
    #[must_use]
    pub const fn with_emission(mut self, emission: Emission) -> Self {
        self.emission = emission;
        self
    }
}

/// As [`load_animated`], with choices.
///
/// # Errors
/// As [`load_clip`].
///
/// ```no_run
/// use scene_files::{LoadOptions, Normals};
/// let options = LoadOptions::new().with_normals(Normals::Smooth { crease: 40.0 });
/// let (scene, _animation, _warnings) = scene_files::load_with("machine.ply", &options)?;
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    let LoadOptions { clip, normals, terminator, emission, studio } = options;
    let (normals, terminator) = (*normals, *terminator);
    let context = Context { normals, terminator, emission: *emission, studio: *studio, ..Context::default() };
    load_any(path.as_ref(), clip.as_deref(), context)
}

/// As [`load_with`], of a glTF file as it is: no floor and no light is added. With the [document](GltfDocument), for programs that
/// write it again.
///
/// # Errors
/// As [`load_clip`]; files of other kinds are refused.
///
/// ```no_run
/// let (scene, _animation, document, _warnings) = scene_files::load_document("room.glb", &scene_files::LoadOptions::new())?;
/// let shown = document.parts.iter().filter_map(|part| part.object).count();
/// assert_eq!(shown, scene.objects.len());
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load_document(
    path: impl AsRef<Path>,
    options: &LoadOptions,
) -> Result<(Scene, Animation, GltfDocument, Vec<String>), SceneError> {
    let (path, LoadOptions { clip, normals, terminator, emission, studio: _ }) = (path.as_ref(), options);
    if !["gltf", "glb"].contains(&extension(path).as_str()) {
        return Err(SceneError::file(path, "unknown kind of file: expected .gltf or .glb"));
    }
    let document = Some(GltfDocument::default());
    let (normals, terminator) = (*normals, *terminator);
    let mut context = Context { normals, terminator, emission: *emission, document, ..Context::default() };
    let (scene, animation, warnings) = load_in(path, clip.as_deref(), &mut context)?;
    Ok((scene, animation, context.document.unwrap_or_default(), warnings))
}

/// The objects of a mesh file (`.obj`, `.ply`, `.gltf`, `.glb`) alone, at the first moment of its first clip or of the one
/// named as for [`load_clip`]: no floor, light or camera is added. An object's number is that of the animation; its material
/// is a number only.
///
/// # Errors
/// As [`load_clip`]; a scene file is refused.
///
/// ```no_run
/// let (objects, _animation, _warnings) = scene_files::load_objects("spot.obj", None)?;
/// println!("{} objects", objects.len());
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn load_objects(
    path: impl AsRef<Path>,
    clip: Option<&str>,
) -> Result<(Vec<Object>, Animation, Vec<String>), SceneError> {
    let (path, mut context) = (path.as_ref(), Context::default());
    let file = file_parts(path, clip, &mut context, MESH_OR_SCENE)?;
    let Bare { mut objects, animation, .. } = bare_objects(path, file, &mut context);
    animation.move_objects(0.0, &animation.worlds(0.0), &mut objects);
    for object in &objects {
        if let Some(mesh) = object.shape.vertices() {
            mesh.validate().map_err(|e| SceneError::file(path, format!("object \"{}\": {e}", object.name)))?;
        }
    }
    Ok((objects, animation, context.warnings))
}

/// The mesh of an OBJ file's text, for meshes that a program carries in itself: all its parts as one, without materials. Messages call the text `name`.
///
/// # Errors
/// [`SceneError`], one line with the name and the line.
///
/// ```
/// let mesh = scene_files::obj_mesh("corner", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
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

fn load_any(
    path: &Path,
    clip: Option<&str>,
    mut context: Context,
) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    load_in(path, clip, &mut context)
}

fn load_in(
    path: &Path,
    clip: Option<&str>,
    context: &mut Context,
) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    let is_scene_file = extension(path) == "toml";
    let (mut scene, mut animation) = if is_scene_file {
        if clip.is_some() {
            return Err(SceneError::file(path, "a scene file names the clips of its objects itself"));
        }
        let text = context.files.read_text(path)?;
        scene_file::parse(path, &text, context)?
    } else {
        bare(path, clip, context)?
    };
    // Both have checked what they made; the first moment and lamps are new.
    let lights = scene.lights.len();
    if !animation.is_still() {
        animation.seek(0.0, &mut scene);
    }
    if is_scene_file {
        light_up(path, &mut scene, &mut animation, context);
    }
    if !animation.is_still() || scene.lights.len() > lights {
        scene.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
    }
    for object in &scene.objects {
        let is_lamp = |sphere| scene.lights.iter().any(|light| light.is_shown_by(sphere));
        let is_dark = object.visible && !scene.surface(object.material).is_some_and(Surface::emits);
        if is_dark && matches!(&object.shape, Shape::Spheres(spheres) if spheres.iter().any(is_lamp)) {
            let name = &object.name;
            context
                .warn(path, format!("object \"{name}\" shows a light, but shines not: its material has no `emission`"));
        }
    }
    known_errors::lines(&scene).into_iter().for_each(|line| context.warn(path, line));
    tell_missing_uvs(path, &scene, context);
    Ok((scene, animation, std::mem::take(&mut context.warnings)))
}

/// Warns of objects that lack the texture coordinates of their textures.
fn tell_missing_uvs(path: &Path, scene: &Scene, context: &mut Context) {
    for object in &scene.objects {
        let Some(surface) = scene.surface(object.material).filter(|surface| surface.has_textures()) else { continue };
        let Some(mesh) = object.shape.vertices() else { continue };
        let (name, sets) = (&object.name, mesh.uv_sets.len());
        let shown = |of: &str| of != "emission" || surface.emits();
        if sets == 0 {
            context
                .warn(path, format!("object \"{name}\" has no texture coordinates: it shows a corner of its textures"));
        } else if let Some((of, map)) = surface.maps().find(|(of, map)| shown(of) && map.uv_set >= sets) {
            let set = map.uv_set;
            context.warn(
                path,
                format!("object \"{name}\" has no texture coordinates {set}, by which its {of} texture lies: it shows a corner of that"),
            );
        }
    }
}
