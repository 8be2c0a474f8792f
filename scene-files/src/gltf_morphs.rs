//! Morph targets of glTF primitives. Targets with the same accessors are read, kept and added once.

use crate::gltf_buffers::Buffers;
use crate::gltf_mesh::vectors;
use glam::Vec3;
use gltf::json::mesh::Primitive;
use scene::{MAX_COORDINATE, Mesh};
use std::collections::HashMap;

/// The displacements of a primitive's targets at weight 1.
#[derive(Clone, Default)]
pub(crate) struct Morphs {
    /// Of positions, one a vertex.
    pub(crate) positions: Vec<Vec<Vec3>>,
    /// Of normals; empty for targets without.
    pub(crate) normals: Vec<Vec<Vec3>>,
    /// For each target the place of its own among these.
    slots: Vec<usize>,
}

impl Morphs {
    /// All of a primitive, whose mesh it is.
    pub(crate) fn read(buffers: &Buffers<'_>, primitive: &Primitive, mesh: &Mesh) -> Result<Self, String> {
        let mut all = Self::default();
        let [vertices, normals] = [&mesh.positions, &mesh.normals].map(Vec::len);
        let (slots, firsts) = slots(primitive, normals > 0);
        // Before they are read: accessors may claim far more than the file has.
        let bytes = (firsts.len() * (vertices + normals) * size_of::<Vec3>()) as u64;
        buffers.budget.take(0, bytes, &format!("{} morph targets", firsts.len()))?;
        each(buffers, primitive, &firsts, [vertices, normals], |_, positions, normals| {
            all.positions.push(positions);
            all.normals.push(normals);
        })?;
        Ok(Self { slots, ..all })
    }

    /// Moves the primitive's mesh by these weights of its targets. Keeps no displacements: only the number of targets.
    pub(crate) fn apply(
        buffers: &Buffers<'_>,
        primitive: &Primitive,
        weights: &[f32],
        mesh: &mut Mesh,
    ) -> Result<Self, String> {
        let [vertices, normals] = [&mesh.positions, &mesh.normals].map(Vec::len);
        let (slots, firsts) = slots(primitive, normals > 0);
        let sums = sums(&slots, weights);
        each(buffers, primitive, &firsts, [vertices, normals], |slot, positions, normals| {
            let amount = sums[slot];
            if amount != 0.0 {
                let add = |to: &mut [Vec3], by: &[Vec3]| to.iter_mut().zip(by).for_each(|(p, d)| *p += amount * *d);
                add(&mut mesh.positions, &positions);
                add(&mut mesh.normals, &normals);
            }
        })?;
        Ok(Self { slots, ..Self::default() })
    }

    /// The number of targets.
    pub(crate) fn count(&self) -> usize {
        self.slots.len()
    }

    /// Bytes of [`all`](Self::all).
    pub(crate) fn bytes(&self) -> u64 {
        let of = |slot: &usize| (self.positions[*slot].len() + self.normals[*slot].len()) * size_of::<Vec3>();
        self.slots.iter().map(|slot| of(slot) as u64).sum()
    }

    /// The displacements of each target: those of positions and those of normals.
    pub(crate) fn all(&self) -> [Vec<Vec<Vec3>>; 2] {
        [&self.positions, &self.normals].map(|lists| self.slots.iter().map(|slot| lists[*slot].clone()).collect())
    }

    /// The same targets with other displacements.
    pub(crate) fn with(&self, positions: Vec<Vec<Vec3>>, normals: Vec<Vec<Vec3>>) -> Self {
        Self { positions, normals, slots: self.slots.clone() }
    }
}

/// For each target the number of its pair of accessors, and for each pair the first target that has it.
fn slots(primitive: &Primitive, has_normals: bool) -> (Vec<usize>, Vec<usize>) {
    let (mut known, mut firsts) = (HashMap::new(), Vec::new());
    let slot = |(k, target): (usize, &gltf::json::mesh::MorphTarget)| {
        let [positions, normals] = [target.positions, target.normals.filter(|_| has_normals)];
        let pair = [positions, normals].map(|index| index.map(|index| index.value()));
        *known.entry(pair).or_insert_with(|| {
            firsts.push(k);
            firsts.len() - 1
        })
    };
    let slots = primitive.targets.iter().flatten().enumerate().map(slot).collect();
    (slots, firsts)
}

/// The weights of targets, added up slot by slot.
fn sums(slots: &[usize], weights: &[f32]) -> Vec<f32> {
    let mut sums = vec![0.0_f64; slots.len()];
    slots.iter().zip(weights).for_each(|(slot, weight)| sums[*slot] += f64::from(*weight));
    sums.into_iter().map(|sum| sum as f32).collect()
}

/// Gives `take` each slot and the displacements of its first target.
fn each(
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    firsts: &[usize],
    [vertices, normals]: [usize; 2],
    mut take: impl FnMut(usize, Vec<Vec3>, Vec<Vec3>),
) -> Result<(), String> {
    let targets: Vec<_> = primitive.targets.iter().flatten().collect();
    for (slot, k) in firsts.iter().copied().enumerate() {
        let read = |index: Option<_>, default| -> Result<Vec<Vec3>, String> {
            let Some(index) = index else { return Ok(vec![Vec3::ZERO; default]) };
            let moved = vectors(buffers, index)?;
            if moved.len() != vertices {
                return Err(format!("morph target {k} of {} positions for {vertices}", moved.len()));
            }
            if moved.iter().any(|d| d.is_nan() || d.abs().max_element() > MAX_COORDINATE) {
                return Err(format!("morph target {k}: displacements must lie within ±1e9"));
            }
            Ok(moved)
        };
        let normals = targets[k].normals.filter(|_| normals > 0);
        take(slot, read(targets[k].positions, vertices)?, read(normals, 0)?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::load_from;
    use glam::Vec3;
    use scene::{Scene, Shape};
    use std::collections::BTreeMap;
    use std::path::PathBuf;
    use std::sync::Arc;

    /// A grid of `side` vertices a side, morph targets by the numbers of their accessors, and nodes by their weights.
    fn load(side: usize, targets: &[usize], nodes: &[Vec<f32>]) -> Scene {
        let vertices = side * side;
        // Positions, and two accessors of displacements.
        let place = |k: usize| Vec3::new((k % side) as f32, (k / side) as f32, 0.0);
        let lists: [Vec<Vec3>; 3] = [
            (0..vertices).map(place).collect(),
            (0..vertices).map(|k| Vec3::new(0.0, 0.0, 0.01 * k as f32)).collect(),
            (0..vertices).map(|k| Vec3::new(0.5, 0.0, 0.3 * (k % 7) as f32)).collect(),
        ];
        let mut bytes: Vec<u8> = lists.iter().flatten().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes).collect();
        let mut indices: Vec<u32> = Vec::new();
        for (x, y) in (1..side as u32).flat_map(|y| (1..side as u32).map(move |x| (x, y))) {
            let [a, b] = [y * side as u32 + x, (y - 1) * side as u32 + x];
            indices.extend([a, a - 1, b, b, a - 1, b - 1]);
        }
        bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        let (size, start, rest) = (12 * vertices, 36 * vertices, 4 * indices.len());
        let accessor = |view: usize| {
            format!(r#"{{"bufferView": {view}, "componentType": 5126, "count": {vertices}, "type": "VEC3"}}"#)
        };
        let view = |k: usize| format!(r#"{{"buffer": 0, "byteOffset": {}, "byteLength": {size}}}"#, k * size);
        let targets: Vec<String> = targets.iter().map(|t| format!(r#"{{"POSITION": {t}}}"#)).collect();
        let nodes: Vec<String> = nodes.iter().map(|w| format!(r#"{{"mesh": 0, "weights": {w:?}}}"#)).collect();
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"uri": "a.bin", "byteLength": {}}}],
            "bufferViews": [{}, {}, {}, {{"buffer": 0, "byteOffset": {start}, "byteLength": {rest}}}],
            "accessors": [{}, {}, {}, {{"bufferView": 3, "componentType": 5125, "count": {}, "type": "SCALAR"}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 3, "targets": [{}]}}]}}],
            "nodes": [{}]}}"#,
            bytes.len(),
            view(0),
            view(1),
            view(2),
            accessor(0),
            accessor(1),
            accessor(2),
            indices.len(),
            targets.join(","),
            nodes.join(",")
        );
        let files: BTreeMap<PathBuf, Vec<u8>> =
            BTreeMap::from([("a.gltf".into(), json.into_bytes()), ("a.bin".into(), bytes)]);
        load_from(Arc::new(files), "a.gltf", None).expect("a scene").0
    }

    fn positions(scene: &Scene, object: usize) -> &[Vec3] {
        let Shape::Mesh(mesh) = &scene.objects[object].shape else { panic!("{object} is no mesh") };
        &mesh.positions
    }

    #[test]
    fn targets_with_common_accessors_add_up() {
        let scene = load(4, &[1, 2, 1, 1], &[vec![0.25, 1.0, 0.5, 0.25], vec![0.0; 4], vec![1.0, 1.0, -1.0, 1.0]]);
        let all = load(4, &[1, 2], &[vec![1.0, 1.0], vec![0.0; 2], vec![1.0, 1.0]]);
        for object in 1..4 {
            assert_eq!(positions(&scene, object), positions(&all, object), "{object}");
        }
        let [rest, moved] = [2, 1].map(|object| positions(&scene, object)[5]);
        assert!((moved - rest - Vec3::new(0.5, 0.0, 0.05 + 0.3 * 5.0)).length() < 1e-6, "{moved} {rest}");
    }

    /// Read for each target and each node they take minutes.
    #[test]
    fn many_targets_of_many_nodes_are_read_once() {
        let begin = std::time::Instant::now();
        let scene = load(60, &[1; 5000], &vec![vec![0.001; 5000]; 50]);
        assert_eq!(scene.objects.iter().filter(|object| matches!(object.shape, Shape::Mesh(_))).count(), 51);
        let lifted = positions(&scene, 49)[100].z - positions(&scene, 49)[0].z;
        assert!((lifted - 5.0).abs() < 1e-3, "{lifted}");
        assert!(begin.elapsed().as_secs_f64() < 10.0, "{:?}", begin.elapsed());
    }
}
