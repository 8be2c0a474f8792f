//! Files of scenes: scene files in TOML, and meshes in glTF, OBJ and PLY, with their materials and images, to a [`Scene`] and its
//! [`Animation`].
//!
//! - [`load`]: scene files (every key, commented: [`SCHEMA_EXAMPLE`]), and `.obj`, `.ply`, `.gltf`, `.glb` meshes, to which a floor, a light and
//!   a camera are added.
//! - [`load_animated`], [`load_clip`]: the same with its motion; [`load_with`]: with [choices](LoadOptions); [`load_from`]: from memory.
//! - [`load_objects`]: the objects of a mesh file alone. [`load_document`]: a glTF file with what it is made of. [`obj_mesh`]: a mesh of a text.
//!
//! ```
//! # let folder = std::env::temp_dir().join("cosine-lobes-doc-files");
//! # std::fs::create_dir_all(&folder)?;
//! # let file = folder.join("sphere.toml");
//! # std::fs::write(&file, "[[objects]]\nsphere = { center = [0, 1, 0], radius = 1 }\n\
//! # keys = [{ time = 0, translate = [0, 0, 0] }, { time = 2, translate = [4, 0, 0] }]\n")?;
//! let (mut scene, animation, _warnings) = scene_files::load_animated(&file)?;
//! assert_eq!(animation.duration(), 2.0);
//! animation.seek(0.5, &mut scene);
//! assert_eq!(scene.bounds().center().x, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! Those of [`scene`], with y up where a default needs an up. Fields of view are in degrees in files.
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
//! Images: PNG, JPEG, BMP, TGA up to 16384 texels a side ([`Texture`](scene::Texture)). A missing image gives a warning, and its factor is used
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

mod appearance;
mod budget;
mod context;
mod decimal;
mod defaults;
mod emission;
mod exr_channels;
mod exr_colors;
mod files;
mod gltf_animation;
mod gltf_buffers;
mod gltf_document;
mod gltf_extensions;
mod gltf_file;
mod gltf_instances;
mod gltf_layers;
#[cfg(test)]
mod gltf_layers_tests;
mod gltf_light;
mod gltf_material;
mod gltf_mesh;
mod gltf_morphs;
mod gltf_nodes;
#[cfg(test)]
mod gltf_notes_tests;
mod gltf_reader;
mod gltf_shared;
#[cfg(test)]
mod gltf_tests;
mod gltf_texture;
mod hdr_header;
mod height;
mod image_file;
mod kept_meshes;
mod keys;
mod known_errors;
mod light_error;
mod load;
mod mesh_file;
mod mesh_scene;
#[cfg(test)]
mod mesh_tests;
#[cfg(test)]
mod motion_tests;
mod mtl;
mod normals;
mod obj;
mod obj_libraries;
mod obj_lines;
mod obj_normals;
mod origin;
mod part;
mod ply;
mod ply_mesh;
mod polygon;
mod scene_environment;
mod scene_file;
#[cfg(test)]
mod scene_file_tests;
mod scene_light;
mod scene_material;
mod scene_object;
mod studio;
mod tangle;
mod toml_reader;
mod turns;
mod unit;
mod vertex_colors;

#[cfg(doc)]
use scene::{Animation, Scene, SceneError};

pub use crate::emission::Emission;
pub use crate::files::{Disk, Files};
pub use crate::gltf_document::{GltfDocument, GltfPart};
pub use crate::light_error::other_light_error;
pub use crate::load::{
    LoadOptions, load, load_animated, load_clip, load_document, load_from, load_objects, load_with, load_with_warnings,
    obj_mesh,
};
pub use crate::normals::Normals;
pub use crate::scene_file::SCHEMA_EXAMPLE;
pub use crate::studio::Studio;
