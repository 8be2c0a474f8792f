//! Scenes: meshes, materials, lights, camera and their loading.
//!
//! - [`Scene`] and its parts: [`Camera`], [`Object`] ([`Shape`], [`Proxy`], [`Strategy`]), [`Mesh`], materials of `brdf`,
//!   textures and emission ([`Surface`]), lights of `lighting`. [`Scene::validate`] checks all that renderers rely on. [`Animation`]: its motion.
//! - [`load`]: scene files in TOML (every key, commented: [`SCHEMA_EXAMPLE`]), and `.obj`, `.ply`, `.gltf`, `.glb` meshes,
//!   to which a floor, a light and a camera are added. [`builtin`]: the scene that needs no file.
//! - The inputs and results of renderers, the same for CPU and GPU: [`Shade`], [`ShadingPoints`], [`Frame`], [`BlockerSet`], [`Cancel`].
//!
//! ```
//! let scene = scene::builtin();
//! scene.validate()?;
//! assert_eq!(scene.lights.len(), 2);
//! # Ok::<(), scene::SceneError>(())
//! ```
//!
//! # Conventions
//! Right-handed world space, linear RGB, y up where a default needs an up. Meshes of a loaded scene are in world space;
//! sphere sets in files are in the coordinates of their mesh's file and placed with it. Surfaces are two-sided: renderers
//! turn normals to the viewer. Fields of view are full, vertical, and in radians here but in degrees in files.
//!
//! # Files
//! Whatever a file contains, loading neither panics nor takes memory that the files' own sizes do not justify: meshes and images get 1.7 GB
//! in all, and 128 bytes for each byte of the files that they are read from; it
//! returns a scene or a [`SceneError`] of one line. Files that a scene file or a glTF refers to are looked for beside
//! it; a glTF reads nothing outside its folder. Triangles without an area are left out. Coordinates may be as large as
//! 1e9; NaN and infinity are refused. The numbers of scene files, OBJ and PLY are read in double precision: a scene 32 times
//! farther from its origin than its camera from the target, and a mesh 32 times farther than its radius, is taken relative to a point nearby
//! ([`Animation::origin`]), so that it looks the same anywhere. glTF files have single precision.
//!
//! glTF: triangles (strips and fans too) of the default scene, with skins and morph targets; sparse and quantised
//! accessors; the first perspective camera; metallic–roughness materials with their textures (base colour, metalness, roughness, normal,
//! emission; samplers, transforms, all sets of coordinates), vertex colours, cut-outs by alpha, KHR_materials_ior, specular,
//! emissive_strength and unlit; KHR_lights_punctual, KHR_node_visibility, EXT_mesh_gpu_instancing. Not read: other extensions, of which
//! [`load_with_warnings`] names those that may change the picture; Draco and meshopt compression.
//!
//! OBJ: one object for each material in use; of MTL `Kd`, `Ks`, `Ns`, `Ke`, `Pr`, `Pm`, `illum` and their maps, `norm`. PLY: colours and
//! texture coordinates of vertices and faces, images that its comments name.
//!
//! Images: PNG, JPEG, BMP, TGA up to 16384 texels a side ([`Texture`]). A missing image gives a warning, and its factor is used
//! alone; a broken image is an error.
//!
//! # Motion
//! [`load_animated`] gives an [`Animation`] with the scene: key frames of objects, lights and the camera of a scene file, and
//! one clip of each glTF file (node transforms, skins, morph weights; steps, lines and cubic splines). A mesh file alone
//! plays its first clip, or the one that [`load_clip`] names. A scene file may name a clip; else it plays the first one, too. A skinned
//! vertex keeps its four largest weights. Normals are transformed by the inverse transpose of the vertex's matrix; [smooth ones](Normals) that are
//! requested follow from the triangles of each pose.
//!
//! A broken clip (times not in order, NaN, too few values, nodes that do not exist, rotations of length 0 …) is an error
//! if it is the one that is played; else it is left out with a warning. Channels with unsupported targets
//! (pointers of extensions, weights without targets) are left out with a warning. A broken skin is always an
//! error.
//!
//! # Scope
//! Out of scope here: pictures as output, sphere-set construction, threads.

#![cfg_attr(not(feature = "files"), expect(dead_code, reason = "readers make much of what is held here"))]

mod animation;
mod animation_edits;
mod bounds;
#[cfg(feature = "files")]
mod budget;
mod builtin;
mod camera;
mod camera_keys;
mod cancel;
mod check;
mod clock;
mod coherence;
#[cfg(feature = "files")]
mod context;
mod creases;
#[cfg(feature = "files")]
mod cut_out;
#[cfg(feature = "files")]
mod defaults;
mod deformer;
mod duplicates;
#[cfg(feature = "files")]
mod emission;
mod error;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "files")]
mod gltf_animation;
#[cfg(feature = "files")]
mod gltf_buffers;
#[cfg(feature = "files")]
mod gltf_document;
#[cfg(feature = "files")]
mod gltf_extensions;
#[cfg(feature = "files")]
mod gltf_file;
#[cfg(feature = "files")]
mod gltf_instances;
#[cfg(feature = "files")]
mod gltf_layers;
#[cfg(feature = "files")]
#[cfg(test)]
mod gltf_layers_tests;
#[cfg(feature = "files")]
mod gltf_light;
#[cfg(feature = "files")]
mod gltf_material;
#[cfg(feature = "files")]
mod gltf_mesh;
#[cfg(feature = "files")]
mod gltf_nodes;
#[cfg(feature = "files")]
mod gltf_shared;
#[cfg(test)]
#[cfg(feature = "files")]
mod gltf_tests;
#[cfg(feature = "files")]
mod gltf_texture;
#[cfg(feature = "files")]
mod hdr_header;
#[cfg(feature = "files")]
mod height;
#[cfg(feature = "files")]
mod image_file;
mod instances;
#[cfg(feature = "files")]
mod keys;
#[cfg(feature = "files")]
mod known_errors;
#[cfg(feature = "files")]
mod load;
#[cfg(feature = "files")]
mod look;
mod mesh;
#[cfg(feature = "files")]
mod mesh_file;
#[cfg(feature = "files")]
mod mesh_scene;
#[cfg(test)]
#[cfg(feature = "files")]
mod mesh_tests;
#[cfg(test)]
#[cfg(feature = "files")]
mod motion_tests;
#[cfg(feature = "files")]
mod mtl;
mod normals;
#[cfg(feature = "files")]
mod obj;
#[cfg(feature = "files")]
mod obj_libraries;
#[cfg(feature = "files")]
mod obj_lines;
#[cfg(feature = "files")]
mod obj_normals;
mod origin;
#[cfg(feature = "files")]
mod part;
mod placement;
#[cfg(feature = "files")]
mod ply;
#[cfg(feature = "files")]
mod ply_mesh;
#[cfg(feature = "files")]
mod polygon;
mod quick_hash;
mod scene;
#[cfg(feature = "files")]
mod scene_environment;
#[cfg(feature = "files")]
mod scene_file;
#[cfg(test)]
#[cfg(feature = "files")]
mod scene_file_tests;
#[cfg(feature = "files")]
mod scene_light;
#[cfg(feature = "files")]
mod scene_material;
#[cfg(feature = "files")]
mod scene_object;
mod shade;
mod shapes;
mod skeleton;
mod strategy;
mod studio;
mod surface;
mod texture;
mod texture_level;
#[cfg(test)]
mod texture_tests;
#[cfg(feature = "files")]
mod toml_reader;
mod track;
#[cfg(feature = "files")]
mod vertex_colors;

pub use crate::animation::{Animation, Pose, Rig};
pub use crate::animation_edits::{KeyFrame, KeyFrames};
pub use crate::bounds::Bounds;
pub use crate::builtin::builtin;
pub use crate::camera::Camera;
pub use crate::cancel::Cancel;
pub use crate::clock::{Stopwatch, set_clock};
pub use crate::coherence::GROUP;
pub use crate::duplicates::Duplicates;
#[cfg(feature = "files")]
pub use crate::emission::Emission;
pub use crate::error::SceneError;
#[cfg(feature = "files")]
pub use crate::files::{Disk, Files};
#[cfg(feature = "files")]
pub use crate::gltf_document::{GltfDocument, GltfPart};
pub use crate::instances::Instances;
#[cfg(feature = "files")]
pub use crate::load::{
    LoadOptions, load, load_animated, load_clip, load_document, load_from, load_objects, load_with, load_with_warnings,
    obj_mesh,
};
pub use crate::mesh::Mesh;
pub use crate::normals::Normals;
pub use crate::scene::{Object, Proxy, Scene, Shape};
#[cfg(feature = "files")]
pub use crate::scene_file::SCHEMA_EXAMPLE;
pub use crate::shade::{BlockerSet, Counts, Frame, Shade, ShadeStats, ShadingPoints, StageSeconds};
pub use crate::strategy::Strategy;
pub use crate::studio::Studio;
pub use crate::surface::{Channel, Surface, TextureMap, TexturePlace};
pub use crate::texture::{Encoding, Texture};
pub use crate::texture_level::Wrap;
pub use glam;
