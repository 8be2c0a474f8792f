//! Meshes of a glTF document, and the joints that carry their vertices.

use crate::context::broken_uvs;
use crate::gltf_buffers::Buffers;
use crate::gltf_morphs::Morphs;
use glam::{Mat4, Vec2, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Node, Root};
use scene::{MAX_COORDINATE, Mesh};

/// A mesh and the shapes that it morphs to.
#[derive(Clone)]
pub(crate) struct Shapes {
    pub(crate) mesh: Mesh,
    /// Alphas of the vertices; none where all are 1.
    pub(crate) alphas: Vec<f32>,
    pub(crate) morphs: Morphs,
    /// Whether the mesh has been moved by its targets, so that `morphs` has none.
    pub(crate) is_morphed: bool,
    /// How many normals had no direction, and how many texture coordinates were not finite.
    pub(crate) broken: [usize; 2],
}

/// The joints that carry the vertices of a primitive.
pub(crate) struct Influences {
    pub(crate) joints: Vec<[u16; 4]>,
    /// Of sum 1.
    pub(crate) weights: Vec<[f32; 4]>,
    /// Vertices without a joint, which use the joint after the last one.
    pub(crate) unbound: usize,
    /// Vertices that had more than four joints.
    pub(crate) reduced: usize,
    /// Vertices whose weights did not add up to 1.
    pub(crate) uneven: usize,
}

/// The triangles of a primitive in bind space; none for points, lines and primitives without positions. With weights they are moved by
/// its morph targets, which are left out.
pub(crate) fn read_primitive(
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    weights: Option<&[f32]>,
) -> Result<Option<Shapes>, String> {
    let Checked::Valid(mode) = primitive.mode else { return Err("unknown mode".to_owned()) };
    let attribute = |s| primitive.attributes.get(&Checked::Valid(s)).copied();
    let Some(positions) = attribute(Semantic::Positions) else { return Ok(None) };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(None);
    }
    let positions = vectors(buffers, positions)?;
    let vertices = positions.len();
    let normals = match attribute(Semantic::Normals) {
        Some(index) => one_each("normals", vectors(buffers, index)?, vertices)?,
        None => Vec::new(),
    };
    let indices = match primitive.indices {
        Some(index) => buffers.integers(index, Type::Scalar)?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(i) = indices.iter().find(|&&i| i as usize >= vertices) {
        return Err(format!("uses vertex {i} of {vertices}"));
    }
    let triangles = triangles_of(mode, &indices);
    let mut uv_sets = Vec::new();
    for set in 0.. {
        let Some(index) = attribute(Semantic::TexCoords(set)) else { break };
        let pairs = buffers.floats(index, Type::Vec2)?;
        let pairs = pairs.chunks_exact(2).map(Vec2::from_slice).collect();
        uv_sets.push(one_each("texture coordinates", pairs, vertices)?);
    }
    let (colors, alphas) = match attribute(Semantic::Colors(0)) {
        Some(index) => {
            let (colors, alphas) = buffers.colors(index)?;
            (one_each("colours", colors, vertices)?, alphas)
        }
        None => (Vec::new(), Vec::new()),
    };
    let mut mesh = Mesh { positions, normals, triangles, uv_sets, colors };
    if let Some(bad) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(format!("position {bad} is not finite"));
    }
    let broken = [mesh.repair_normals(), broken_uvs(mesh.uv_sets.iter().flatten())];
    let morphs = match weights {
        Some(weights) => Morphs::apply(buffers, primitive, weights, &mut mesh)?,
        None => Morphs::read(buffers, primitive, &mesh)?,
    };
    Ok(Some(Shapes { mesh, alphas, morphs, is_morphed: weights.is_some(), broken }))
}

/// Vectors of an accessor.
pub(crate) fn vectors(buffers: &Buffers<'_>, index: Index<Accessor>) -> Result<Vec<Vec3>, String> {
    Ok(buffers.floats(index, Type::Vec3)?.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// Refuses values of which there are not as many as positions.
fn one_each<T>(name: &str, values: Vec<T>, vertices: usize) -> Result<Vec<T>, String> {
    match values.len() == vertices {
        true => Ok(values),
        false => Err(format!("{} {name} for {vertices} positions", values.len())),
    }
}

/// The number of corners behind the last whole triangle of a list, if there are some.
pub(crate) fn spare_indices(root: &Root, primitive: &Primitive) -> Option<u64> {
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
    let corners = root.accessors.get(primitive.indices.or(positions)?.value())?.count.0;
    let is_list = primitive.mode == Checked::Valid(Mode::Triangles);
    Some(corners % 3).filter(|spare| is_list && *spare > 0)
}

/// The triangles of a list, a strip or a fan.
fn triangles_of(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan => indices.get(1..).unwrap_or(&[]).windows(2).map(|w| [indices[0], w[0], w[1]]).collect(),
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

/// The joints of a skin and their inverse bind matrices.
pub(crate) fn read_skin(root: &Root, buffers: &Buffers<'_>, skin: usize) -> Result<Vec<(usize, Mat4)>, String> {
    let fault = |e: String| format!("skin {skin}: {e}");
    let data = root.skins.get(skin).ok_or_else(|| format!("there is no skin {skin}"))?;
    if data.joints.is_empty() {
        return Err(fault("has no joints".to_owned()));
    }
    let inverse = match data.inverse_bind_matrices {
        None => vec![Mat4::IDENTITY; data.joints.len()],
        Some(index) => {
            let values = buffers.floats(index, Type::Mat4).map_err(fault)?;
            values.chunks_exact(16).map(Mat4::from_cols_slice).collect()
        }
    };
    if inverse.len() < data.joints.len() {
        return Err(fault(format!("{} inverse bind matrices for {} joints", inverse.len(), data.joints.len())));
    }
    // One number is for vertices without a joint.
    if data.joints.len() > usize::from(u16::MAX) {
        return Err(fault(format!("{} joints: at most {} are read", data.joints.len(), u16::MAX)));
    }
    let joint = |(joint, inverse): (&Index<Node>, Mat4)| {
        let j = joint.value();
        if j >= root.nodes.len() {
            return Err(fault(format!("there is no node {j}")));
        }
        let usable = inverse.to_cols_array().iter().all(|v| v.abs() <= MAX_COORDINATE);
        if usable { Ok((j, inverse)) } else { Err(fault(format!("the matrix of joint {j} is not finite"))) }
    };
    data.joints.iter().zip(inverse).map(joint).collect()
}

/// The joints that carry the vertices; `None` for a primitive without joints. Of more than four joints a vertex
/// keeps the four with the largest weights.
pub(crate) fn read_influences(
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    vertices: usize,
    joint_count: usize,
) -> Result<Option<Influences>, String> {
    let attribute = |s| primitive.attributes.get(&Checked::Valid(s)).copied();
    let mut sets = Vec::new();
    for set in 0.. {
        let pair = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)));
        let (Some(joints), Some(weights)) = pair else { break };
        let (joints, weights) = (buffers.integers(joints, Type::Vec4)?, buffers.floats(weights, Type::Vec4)?);
        if joints.len() != 4 * vertices || weights.len() != 4 * vertices {
            let (j, w) = (joints.len() / 4, weights.len() / 4);
            return Err(format!("{j} joints and {w} weights for {vertices} positions"));
        }
        sets.push((joints, weights));
    }
    if sets.is_empty() {
        return Ok(None);
    }
    let mut out = Influences { joints: Vec::new(), weights: Vec::new(), unbound: 0, reduced: 0, uneven: 0 };
    let mut all: Vec<(u16, f32)> = Vec::new();
    for vertex in 0..vertices {
        all.clear();
        for (joints, weights) in &sets {
            for k in 4 * vertex..4 * vertex + 4 {
                let (joint, weight) = (joints[k], weights[k]);
                if !weight.is_finite() || weight < 0.0 {
                    return Err(format!("vertex {vertex} has the joint weight {weight}"));
                }
                if weight > 0.0 {
                    if joint as usize >= joint_count {
                        return Err(format!("vertex {vertex} uses joint {joint} of {joint_count}"));
                    }
                    all.push((joint as u16, weight));
                }
            }
        }
        out.push(&mut all, joint_count);
    }
    Ok(Some(out))
}

impl Influences {
    /// Appends a vertex with its joints and their weights, of which the four largest are kept.
    fn push(&mut self, all: &mut Vec<(u16, f32)>, joint_count: usize) {
        let sum: f32 = all.iter().map(|(_, w)| w).sum();
        // Bytes round each of four weights by up to 1/510.
        self.uneven += usize::from(!all.is_empty() && (sum - 1.0).abs() > 0.02);
        if all.len() > 4 {
            self.reduced += 1;
            all.sort_by(|a, b| b.1.total_cmp(&a.1));
            all.truncate(4);
        }
        if all.is_empty() {
            self.unbound += 1;
            all.push((joint_count as u16, 1.0));
        }
        // In f64: the sum of four floats may leave f32.
        let sum: f64 = all.iter().map(|(_, w)| f64::from(*w)).sum();
        let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
        for (k, &(joint, weight)) in all.iter().enumerate() {
            (joints[k], weights[k]) = (joint, (f64::from(weight) / sum) as f32);
        }
        self.joints.push(joints);
        self.weights.push(weights);
    }
}
