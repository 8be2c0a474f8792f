//! A glTF file as it stands, beside the scene that is made of it.

use crate::context::Context;
use scene::Mesh;

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
    /// Whether its triangles are turned round, because its node mirrors them.
    pub is_turned: bool,
    /// Whether it is the back of another part, for programs that add such parts.
    pub is_back: bool,
    /// All of its triangles at the first moment, in world space: those without an area and those that alpha cuts away too. Vertices and
    /// triangles are in the order of the file, copy after copy.
    pub geometry: Mesh,
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
