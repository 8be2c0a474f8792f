//! Meshes of the nodes of a glTF document, as parts.

use crate::appearance::Appearance;
use crate::context::Context;
use crate::gltf_buffers::Buffers;
use crate::gltf_document::GltfPart;
use crate::gltf_extensions::Extensions;
use crate::gltf_file::Read;
use crate::gltf_instances::{attribute_notes, expanded, read_instances};
use crate::gltf_material::read_material;
use crate::gltf_mesh::{Influences, Shapes, read_influences, read_primitive, read_skin, spare_indices};
use crate::gltf_shared::{SharedMeshes, Shown, sum};
use crate::gltf_texture::Images;
use crate::part::Part;
use glam::Mat4;
use gltf::json::Root;
use gltf::json::mesh::Primitive;
use scene::cut_out::CutOut;
use scene::motion::{Body, CameraMover, Carrier, Deformer, Mover, Placement, Skeleton};
use scene::{Camera, MAX_COORDINATE, Mesh};
use std::collections::HashMap;
use std::path::Path;

/// For each mesh how many of some nodes show it.
fn uses(root: &Root, shown: &[(usize, bool)]) -> Vec<usize> {
    let mut uses = vec![0; root.meshes.len()];
    for mesh in shown.iter().filter(|(_, is_visible)| *is_visible).filter_map(|(n, _)| root.nodes[*n].mesh) {
        if let Some(count) = uses.get_mut(mesh.value()) {
            *count += 1;
        }
    }
    uses
}

/// Counts for the warnings that appear once a file.
#[derive(Default)]
struct Notes {
    skipped: usize,
    reduced: usize,
    uneven: usize,
    unbound: usize,
    broken: [usize; 2],
}

/// Reads the meshes of nodes.
pub(crate) struct Reader<'a> {
    root: &'a Root,
    pub(crate) buffers: Buffers<'a>,
    pub(crate) skeleton: Skeleton,
    /// Of all nodes at the first moment.
    pub(crate) worlds: Vec<Mat4>,
    /// For each node whether the clip moves it.
    pub(crate) moving: Vec<bool>,
    /// The materials that were used so far.
    materials: HashMap<usize, Appearance>,
    /// For each mesh how many nodes show it.
    uses: Vec<usize>,
    /// Primitives, by mesh and number, that are cut out for all nodes.
    cut: HashMap<(usize, usize), Shapes>,
    /// Primitives, by mesh and number, as the weights of nodes at rest morph them, for other nodes with the same weights.
    morphed: HashMap<(usize, usize, Vec<u32>), Shapes>,
    /// Primitives that are stored once for all nodes.
    shared: SharedMeshes,
    images: Images<'a>,
    extensions: Extensions,
    notes: Notes,
}

/// A node's mesh, and how it is carried.
struct PlacedMesh {
    node: usize,
    mesh: usize,
    /// The number that the file's skeleton will have.
    skeleton: usize,
    name: String,
    /// Joints and their inverse bind matrices.
    skin: Option<Vec<(usize, Mat4)>>,
    /// Of a mesh without a skin, the places of its instances in the node's coordinates.
    copies: Option<Vec<Mat4>>,
}

impl<'a> Reader<'a> {
    /// `shown` are the nodes that are read, and whether each is visible.
    pub(crate) fn new(
        root: &'a Root,
        buffers: Buffers<'a>,
        skeleton: Skeleton,
        extensions: Extensions,
        images: Images<'a>,
        shown: &[(usize, bool)],
    ) -> Self {
        Self {
            root,
            buffers,
            worlds: skeleton.worlds(0.0),
            moving: skeleton.moving(),
            skeleton,
            materials: HashMap::new(),
            uses: uses(root, shown),
            cut: HashMap::new(),
            morphed: HashMap::new(),
            shared: SharedMeshes::default(),
            images,
            extensions,
            notes: Notes::default(),
        }
    }
}

impl Reader<'_> {
    /// Tells what was left out or changed.
    pub(crate) fn tell(&self, path: &Path, context: &mut Context) {
        let Notes { skipped, reduced, uneven, unbound, broken } = self.notes;
        let [normals, uvs] = sum(broken, self.shared.broken);
        context.tell_broken(path, normals);
        context.tell_broken_uvs(path, uvs);
        if skipped > 0 {
            context.warn(
                path,
                format!("{skipped} primitives that are points or lines, or have no positions, were left out"),
            );
        }
        if reduced > 0 {
            context.warn(path, format!("{reduced} vertices have more than 4 joints: those that count most are kept"));
        }
        if uneven > 0 {
            context.warn(path, format!("joint weights of {uneven} vertices do not add up to 1: they are made to"));
        }
        if unbound > 0 {
            context.warn(path, format!("{unbound} vertices of a skin have no joint: no bone moves them"));
        }
        self.images.notes.iter().for_each(|note| context.warn(path, note));
        self.extensions.tell(path, context);
    }

    /// Adds a warning that appears once.
    pub(crate) fn note(&mut self, note: String) {
        self.images.note(note);
    }

    /// The first camera is that of the picture.
    pub(crate) fn see(&self, camera: Camera, node: usize, skeleton: usize, read: &mut Read) {
        if read.camera.is_none() {
            let projection = camera.projection;
            read.moving_camera = self.moving[node].then_some(CameraMover::Node { skeleton, node, projection });
            read.camera = Some(camera);
        }
    }

    /// Appends the meshes of a node, as they are at the first moment.
    pub(crate) fn parts_of(
        &mut self,
        n: usize,
        skeleton: usize,
        parts: &mut Vec<Part>,
        context: &mut Context,
    ) -> Result<(), String> {
        let node = &self.root.nodes[n];
        let Some(index) = node.mesh else { return Ok(()) };
        let m = index.value();
        let mesh = self.root.meshes.get(m).ok_or_else(|| format!("node {n}: there is no mesh {m}"))?;
        let skin = node.skin.map(|skin| read_skin(self.root, &self.buffers, skin.value())).transpose()?;
        let attributes = self.extensions.instances(n);
        let instances = attributes.map(|attributes| read_instances(&self.buffers, attributes)).transpose();
        let instances = instances.map_err(|e| format!("node {n}: {e}"))?;
        attributes.into_iter().flat_map(attribute_notes).for_each(|note| self.images.note(note));
        if skin.is_some() && instances.is_some() {
            self.images.note("instances of a mesh with a skin are one: the skin places it".to_owned());
        }
        let name = node.name.clone().or_else(|| mesh.name.clone()).unwrap_or_else(|| format!("node {n}"));
        let copies = instances.filter(|_| skin.is_none());
        let placed = PlacedMesh { node: n, mesh: m, skeleton, name, skin, copies };
        for p in 0..mesh.primitives.len() {
            parts.extend(self.part_of(&placed, p, context)?);
        }
        Ok(())
    }

    /// A primitive of a node's mesh; `None` for one without triangles.
    fn part_of(&mut self, of: &PlacedMesh, p: usize, context: &mut Context) -> Result<Option<Part>, String> {
        let &PlacedMesh { node, mesh: m, .. } = of;
        let fault = |e: String| format!("mesh {m}, primitive {p}: {e}");
        let primitives = &self.root.meshes[m].primitives;
        if let Some(spare) = spare_indices(self.root, &primitives[p]) {
            self.images.note(format!("mesh {m}, primitive {p}: {spare} of its indices are no triangle: left out"));
        }
        let material = self.material(&primitives[p]).map_err(fault)?;
        let name = if primitives.len() == 1 { of.name.clone() } else { format!("{} {p}", of.name) };
        let cut_out = material.as_ref().and_then(|(_, appearance)| appearance.cut_out.as_ref());
        let copies = of.copies.as_deref();
        if let Some(places) = self.places(node, of.skin.is_none(), copies) {
            let all = self.uses[m].max(places.len());
            let (path, material) = (self.images.path(), material.as_ref());
            let shown = Shown { path, name: &name, mesh: m, primitive: p, copies: all, places, material };
            if let Some(part) = self.shared.part(self.root, &self.buffers, shown, context).map_err(fault)? {
                return Ok(Some(part));
            }
        }
        // A document that is kept keeps the whole of it.
        let is_kept = context.document.is_some();
        let early = cut_out.filter(|_| !is_kept);
        let Some((shapes, is_cut)) = self.shapes(of, p, &name, early, context).map_err(fault)? else {
            self.notes.skipped += 1;
            return Ok(None);
        };
        let alphas = shapes.alphas.clone();
        let turn = shapes.mesh.triangles.iter().copied().enumerate().find(|(_, [_, b, c])| b != c);
        let (mut mesh, rig) = self.carried(of, &primitives[p], shapes).map_err(fault)?;
        let mover = rig.as_ref().filter(|_| is_kept).map(|(deformer, carrier)| {
            let body = Body::Mesh(Box::new(deformer.clone()), Some(carrier.clone()));
            Box::new(Mover { placement: Placement::Fixed(Mat4::IDENTITY), body, proxy: Vec::new() })
        });
        let part = GltfPart {
            node,
            mesh: m,
            primitive: p,
            name: name.clone(),
            copies: copies.map_or(1, <[Mat4]>::len),
            moves: rig.is_some(),
            mover,
            is_turned: turn.is_some_and(|(i, t)| mesh.triangles[i] != t),
            ..GltfPart::default()
        };
        let source = context.keep(part, &mesh)?;
        if let Some(cut_out) = cut_out.filter(|_| !is_cut) {
            context.cut_out(self.images.path(), &name, cut_out, (&mut mesh, &alphas), rig.is_some());
        }
        let is_bare = mesh.normals.is_empty();
        Ok(Some(Part { rig, is_bare, source, ..Part::fixed(name, mesh, material) }))
    }

    /// The shapes of a primitive at the first moment, and their motion, by the node or by joints.
    fn carried(
        &mut self,
        of: &PlacedMesh,
        primitive: &Primitive,
        shapes: Shapes,
    ) -> Result<(Mesh, Option<(Deformer, Carrier)>), String> {
        let vertices = shapes.mesh.positions.len();
        let influences = match &of.skin {
            Some(skin) => read_influences(&self.buffers, primitive, vertices, skin.len())?,
            None => None,
        };
        let joints = of.skin.as_deref().filter(|_| influences.is_some());
        if of.skin.is_some() && joints.is_none() {
            self.note("a primitive of a skin has no joints and weights: its node places it".to_owned());
        }
        self.pose(of.node, of.skeleton, shapes, joints, influences)
    }

    /// The places of a node's mesh, or of its instances, if these stand still and keep their shape.
    fn places(&self, n: usize, is_rigid: bool, instances: Option<&[Mat4]>) -> Option<Vec<Mat4>> {
        let is_still = is_rigid && !self.moving[n] && self.skeleton.bones[n].rest_weights.is_empty();
        let world = &self.worlds[n];
        is_still.then(|| instances.map_or_else(|| vec![*world], |all| all.iter().map(|i| *world * *i).collect()))
    }

    /// The material of a primitive and its number, read once.
    fn material(&mut self, primitive: &Primitive) -> Result<Option<(usize, Appearance)>, String> {
        let Some(index) = primitive.material else { return Ok(None) };
        let index = index.value();
        let known = match self.materials.get(&index) {
            Some(known) => known.clone(),
            None => {
                read_material(self.root, index, self.extensions.of_material(index), &self.buffers, &mut self.images)?
            }
        };
        self.materials.insert(index, known.clone());
        Ok(Some((index, known)))
    }

    /// The shapes of a node's mesh's primitive, at the node's instances if it has some, and whether they are cut out already: those that
    /// several nodes or instances show and none moves are cut once.
    fn shapes(
        &mut self,
        of: &PlacedMesh,
        p: usize,
        name: &str,
        cut_out: Option<&CutOut>,
        context: &mut Context,
    ) -> Result<Option<(Shapes, bool)>, String> {
        let (n, m, instances) = (of.node, of.mesh, of.copies.as_deref());
        let bone = &self.skeleton.bones[n];
        let is_still = self.root.nodes[n].skin.is_none()
            && !self.moving[n]
            && bone.weights.is_none()
            && bone.rest_weights.iter().all(|weight| *weight == 0.0);
        let is_shared = self.uses[m] > 1 || instances.is_some();
        let keeps_morphs = bone.weights.is_some() || bone.rest_weights.iter().any(|weight| *weight != 0.0);
        let cut_out = cut_out.filter(|_| is_still && is_shared);
        let known = self.cut.get(&(m, p)).filter(|_| cut_out.is_some()).cloned();
        let is_new = known.is_none();
        let Some(mut shapes) = known.map_or_else(|| self.primitive(of, p), |known| Ok(Some(known)))? else {
            return Ok(None);
        };
        if let Some(cut_out) = cut_out.filter(|_| is_new) {
            let alphas = core::mem::take(&mut shapes.alphas);
            context.cut_out(self.images.path(), name, cut_out, (&mut shapes.mesh, &alphas), false);
            self.cut.insert((m, p), shapes.clone());
        }
        let copies = instances.map_or(1, <[Mat4]>::len);
        context.files.budget.take_mesh(&shapes.mesh, copies, name)?;
        if keeps_morphs && !shapes.is_morphed {
            let (all, targets) = (shapes.morphs.bytes().saturating_mul(copies as u64), shapes.morphs.count());
            context.files.budget.take(all, 0, &format!("\"{name}\" of {targets} morph targets"))?;
        }
        if let Some(instances) = instances {
            shapes = expanded(&shapes, instances);
        }
        Ok(Some((shapes, cut_out.is_some())))
    }

    /// A primitive of a node. Where neither the node nor its joints move and its weights stay, it is morphed by them: once for all such
    /// nodes with the same weights.
    fn primitive(&mut self, of: &PlacedMesh, p: usize) -> Result<Option<Shapes>, String> {
        let (bone, primitive) = (&self.skeleton.bones[of.node], &self.root.meshes[of.mesh].primitives[p]);
        let is_at_rest = !self.moving[of.node] && of.skin.iter().flatten().all(|(joint, _)| !self.moving[*joint]);
        if !is_at_rest || of.copies.is_some() || bone.weights.is_some() || bone.rest_weights.is_empty() {
            return read_primitive(&self.buffers, primitive, None);
        }
        let key = (of.mesh, p, bone.rest_weights.iter().map(|weight| weight.to_bits()).collect());
        if let Some(known) = self.morphed.get(&key) {
            return Ok(Some(known.clone()));
        }
        let shapes = read_primitive(&self.buffers, primitive, Some(&bone.rest_weights))?;
        if let Some(shapes) = shapes.as_ref().filter(|_| self.uses[of.mesh] > 1) {
            self.morphed.insert(key, shapes.clone());
        }
        Ok(shapes)
    }

    /// A primitive at the first moment, and its motion if it moves.
    fn pose(
        &mut self,
        n: usize,
        skeleton: usize,
        shapes: Shapes,
        joints: Option<&[(usize, Mat4)]>,
        influences: Option<Influences>,
    ) -> Result<(Mesh, Option<(Deformer, Carrier)>), String> {
        let bone = &self.skeleton.bones[n];
        let Shapes { mut mesh, morphs, is_morphed, broken, .. } = shapes;
        self.notes.broken = sum(self.notes.broken, broken);
        if morphs.count() != bone.rest_weights.len() {
            let (k, first) = (morphs.count(), bone.rest_weights.len());
            return Err(format!("{k} morph targets, the first primitive has {first}"));
        }
        let morphing = bone.weights.as_ref().is_some_and(|w| !w.is_constant());
        let morphed = morphing || bone.weights.is_some() || bone.rest_weights.iter().any(|&w| w != 0.0);
        if influences.is_none() && !morphed && !self.moving[n] {
            mesh.transform(&self.worlds[n]);
            return Ok((mesh, None));
        }
        let mut deformer = Deformer::rigid(&mesh);
        let morphs = Some(morphs).filter(|_| morphed && !is_morphed);
        let morph = morphs.as_ref().map(|_| n);
        let mut carrier = Carrier { skeleton, joints: vec![(Some(n), Mat4::IDENTITY)], morph };
        if let Some(morphs) = &morphs {
            [deformer.targets, deformer.normal_targets] = morphs.all();
        }
        let mut moves = morphing || self.moving[n];
        if let (Some(joints), Some(influences)) = (joints, influences) {
            carrier.joints = joints.iter().map(|&(node, bind)| (Some(node), bind)).collect();
            if influences.unbound > 0 {
                let here = Mat4::from_translation((-self.skeleton.origin).as_vec3());
                carrier.joints.push((None, here));
            }
            moves = morphing || joints.iter().any(|&(node, _)| self.moving[node]);
            self.notes.reduced += influences.reduced;
            self.notes.uneven += influences.uneven;
            self.notes.unbound += influences.unbound;
            (deformer.joints, deformer.weights) = (influences.joints, influences.weights);
        }
        let now: Vec<Mat4> = carrier.joints(&self.worlds).collect();
        if now.iter().any(|m| !m.to_cols_array().iter().all(|v| v.abs() <= MAX_COORDINATE)) {
            return Err("the matrix of a joint leaves ±1e9".to_owned());
        }
        let mut morph = Vec::new();
        if morphs.is_some() {
            self.skeleton.morph_weights(n, 0.0, &mut morph);
        }
        if deformer.mirrors(&now) {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        deformer.pose(&now, &morph, &mut mesh);
        Ok((mesh, moves.then_some((deformer, carrier))))
    }
}
