//! A glTF file as it stands, beside the scene that is made of it.

use crate::context::Context;
use glam::Mat4;
use scene::motion::{Body, Mover};
use scene::{Animation, Mesh, Pose};

/// A glTF file as it stands, for programs that write it again with something added.
#[derive(Clone, Debug, Default)]
pub struct GltfDocument {
    /// Its JSON, as it is written.
    pub json: String,
    /// The bytes of its buffers, wherever they came from, each as long as its `byteLength` says.
    pub buffers: Vec<Vec<u8>>,
    /// The bytes of the images that are files of their own; none for other images and for files that cannot be read.
    pub images: Vec<Option<Vec<u8>>>,
    /// The triangle meshes that its scene shows: for each visible node the primitives of its mesh.
    pub parts: Vec<GltfPart>,
}

/// A primitive of a mesh where a node shows it.
#[derive(Clone, Debug, Default)]
pub struct GltfPart {
    /// The node.
    pub node: usize,
    /// The node's mesh.
    pub mesh: usize,
    /// The primitive's place in the mesh.
    pub primitive: usize,
    /// The name of the object that it is.
    pub name: String,
    /// The object, by its place in the scene; `None` where it has no area, or is cut away as a whole.
    pub object: Option<usize>,
    /// Instances of the node (EXT_mesh_gpu_instancing); 1 without.
    pub copies: usize,
    /// Whether the clip moves it.
    pub moves: bool,
    /// Its motion with the vertices of `geometry`, where the clip moves it.
    pub mover: Option<Box<Mover>>,
    /// Whether its triangles are turned round, because its node mirrors them.
    pub is_turned: bool,
    /// Whether it is the back of another part, for programs that add such parts.
    pub is_back: bool,
    /// All of its triangles at the first moment, in world space: those without an area and those that alpha cuts away too. Vertices and
    /// triangles are in the order of the file, copy after copy.
    pub geometry: Mesh,
    /// The radius of the sphere that each vertex lies on, for programs that add such parts; empty for triangles that are flat.
    pub radii: Vec<f32>,
}

impl GltfPart {
    /// Moves [`geometry`](Self::geometry) to a time in seconds, in world space; `worlds` are the [world matrices](Animation::worlds) of that
    /// time. The order of its vertices and triangles stays. Without a clip that moves it nothing happens.
    pub fn seek(&mut self, animation: &Animation, time: f32, worlds: &[Vec<Mat4>]) {
        let Some(Body::Mesh(deformer, carrier)) = self.mover.as_deref().map(|mover| &mover.body) else { return };
        let mut pose = Pose::default();
        let (skeleton, worlds) = match carrier {
            Some(carrier) => (Some(&animation.skeletons[carrier.skeleton]), &*worlds[carrier.skeleton]),
            None => (None, &[][..]),
        };
        if let Some(mover) = &self.mover {
            mover.pose(time, skeleton, worlds, &mut pose);
        }
        deformer.pose(&pose.joints, &pose.morph, &mut self.geometry);
        if self.is_back {
            self.geometry.normals.iter_mut().for_each(|normal| *normal = -*normal);
        }
    }
}

impl Context {
    /// Keeps a part with its triangles where the document is kept, and returns its place there.
    pub(crate) fn keep(&mut self, part: GltfPart, geometry: &Mesh) -> Result<Option<usize>, String> {
        let Some(document) = &mut self.document else { return Ok(None) };
        self.files.budget.take_mesh(geometry, 1, &part.name)?;
        document.parts.push(GltfPart { geometry: geometry.clone(), ..part });
        Ok(Some(document.parts.len() - 1))
    }
}
