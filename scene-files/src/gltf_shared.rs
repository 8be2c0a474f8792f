//! Meshes that several nodes or instances show: read once.

use crate::Normals;
use crate::appearance::Appearance;
use crate::context::Context;
use crate::gltf_buffers::Buffers;
use crate::gltf_mesh::read_primitive;
use crate::normals::turn_strays;
use crate::part::{Part, Repaired};
use glam::Mat4;
use gltf::json::Root;
use scene::{Instances, Mesh};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Smaller meshes are copied: a hierarchy of their own would cost more than they do.
const SMALLEST: usize = 64;
/// A mesh is shared where its copies would have at least this number of triangles more than itself.
const WORTH: usize = 100_000;

/// Whether a mesh is stored once, by the number of its triangles and of its copies.
pub(crate) const fn is_worth_sharing(triangles: usize, copies: usize) -> bool {
    triangles >= SMALLEST && triangles.saturating_mul(copies.saturating_sub(1)) >= WORTH
}

/// The sums of two pairs.
pub(crate) fn sum([a, b]: [usize; 2], [c, d]: [usize; 2]) -> [usize; 2] {
    [a + c, b + d]
}

/// Primitives that are shared, by mesh and number; none for those that cannot be.
#[derive(Default)]
pub(crate) struct SharedMeshes {
    known: HashMap<(usize, usize), Option<Arc<Mesh>>>,
    /// Normals without direction so far, and texture coordinates that are not finite.
    pub(crate) broken: [usize; 2],
}

/// A primitive, and what shows it.
pub(crate) struct Shown<'a> {
    pub(crate) path: &'a Path,
    pub(crate) name: &'a str,
    pub(crate) mesh: usize,
    pub(crate) primitive: usize,
    /// The number of its places in the whole document.
    pub(crate) copies: usize,
    /// Those of one node.
    pub(crate) places: Vec<Mat4>,
    pub(crate) material: Option<&'a (usize, Appearance)>,
}

impl SharedMeshes {
    /// The part of a node that stands still, if the primitive is large enough to be shared; `None` for all others.
    pub(crate) fn part(
        &mut self,
        root: &Root,
        buffers: &Buffers<'_>,
        shown: Shown<'_>,
        context: &mut Context,
    ) -> Result<Option<Part>, String> {
        if shown.copies < 2 || context.document.is_some() || context.normals != Normals::File {
            return Ok(None);
        }
        let Some(primitive) = root.meshes.get(shown.mesh).and_then(|mesh| mesh.primitives.get(shown.primitive)) else {
            return Ok(None);
        };
        let accessor = primitive.indices.or_else(|| primitive.attributes.values().next().copied());
        let corners = accessor.and_then(|index| root.accessors.get(index.value())).map_or(0, |a| a.count.0 as usize);
        if !is_worth_sharing(corners / 3, shown.copies)
            || primitive.targets.is_some()
            || !shown.places.iter().all(Instances::is_place)
        {
            return Ok(None);
        }
        let key = (shown.mesh, shown.primitive);
        let (mesh, repaired) = match self.known.get(&key) {
            Some(known) => (known.clone(), Repaired::default()),
            None => {
                let (mesh, repaired) = self.read(buffers, primitive, &shown, context)?;
                self.known.insert(key, mesh.clone());
                (mesh, repaired)
            }
        };
        let Some(mesh) = mesh else { return Ok(None) };
        let is_bare = mesh.normals.is_empty();
        context.files.budget.take_places(shown.places.len(), shown.name)?;
        let instances = Instances::of_valid(mesh, shown.places).map_err(|e| e.to_string())?;
        let part = Part::fixed(shown.name.to_owned(), Mesh::default(), shown.material.cloned());
        Ok(Some(Part { instances: Some(instances), is_bare, repaired, ..part }))
    }

    fn read(
        &mut self,
        buffers: &Buffers<'_>,
        primitive: &gltf::json::mesh::Primitive,
        shown: &Shown<'_>,
        context: &mut Context,
    ) -> Result<(Option<Arc<Mesh>>, Repaired), String> {
        let Some(shapes) = read_primitive(buffers, primitive, None)? else { return Ok((None, Repaired::default())) };
        let mut part = Part::fixed(String::new(), shapes.mesh, None);
        // The reader of single meshes says what is wrong.
        if part.mesh.validate().is_err() {
            return Ok((None, Repaired::default()));
        }
        context.files.budget.take_mesh(&part.mesh, 1, shown.name)?;
        self.broken = sum(self.broken, shapes.broken);
        if let Some(cut_out) = shown.material.and_then(|(_, appearance)| appearance.cut_out.as_ref()) {
            context.cut_out(shown.path, shown.name, cut_out, (&mut part.mesh, &shapes.alphas), false);
        }
        let dropped = part.clean();
        let [turned, mixed] = turn_strays(&mut part.mesh);
        let repaired = Repaired { dropped, turned, mixed };
        let is_empty = part.mesh.triangles.is_empty();
        Ok(((!is_empty).then(|| Arc::new(part.mesh)), repaired))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_from;
    use scene::Shape;
    use std::collections::BTreeMap;
    use std::path::PathBuf;

    /// A document of a number of nodes, each with a band of a number of triangles.
    fn document(nodes: usize, triangles: usize) -> Arc<BTreeMap<PathBuf, Vec<u8>>> {
        let vertices = triangles + 2;
        let mut bytes: Vec<u8> = Vec::new();
        for k in 0..vertices {
            let p = [k as f32, (k % 2) as f32, (k as f32 * 0.3).sin()];
            bytes.extend(p.iter().flat_map(|x| x.to_le_bytes()));
        }
        let indices: Vec<u32> = (0..triangles as u32).flat_map(|k| [k, k + 1, k + 2]).collect();
        bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        let node = |k: usize| format!(r#"{{"mesh": 0, "translation": [{}, 0, {}]}}"#, k % 40 * 99, k / 40 * 3);
        let all: Vec<String> = (0..nodes).map(node).collect();
        let [from, size, count] = [12 * vertices, bytes.len() - 12 * vertices, indices.len()];
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"uri": "a.bin", "byteLength": {}}}],
            "bufferViews": [{{"buffer": 0, "byteLength": {from}}}, {{"buffer": 0, "byteOffset": {from}, "byteLength": {size}}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": {vertices}, "type": "VEC3",
            "min": [0, 0, -1], "max": [{vertices}, 1, 1]}},
            {{"bufferView": 1, "componentType": 5125, "count": {count}, "type": "SCALAR"}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}], "nodes": [{}]}}"#,
            bytes.len(),
            all.join(",")
        );
        Arc::new(BTreeMap::from([("a.gltf".into(), json.into_bytes()), ("a.bin".into(), bytes)]))
    }

    #[test]
    fn meshes_at_many_places_are_stored_once() {
        let (scene, _, warnings) = load_from(document(1500, 70), "a.gltf", None).expect("a scene");
        assert!(warnings.is_empty(), "{warnings:?}");
        let shared = scene.objects.iter().filter_map(|object| match &object.shape {
            Shape::Instances(instances) => Some(instances),
            _ => None,
        });
        let meshes: Vec<&Instances> = shared.collect();
        assert_eq!((meshes.len(), scene.triangles()), (1500, 1500 * 70 + 2));
        assert!(meshes.iter().all(|all| Arc::ptr_eq(all.mesh(), meshes[0].mesh())));
        // A floor stands below them, as below copies.
        let bounds = scene.bounds();
        assert!(bounds.max.x > 40.0 * 99.0 && bounds.max.z > 100.0, "{bounds:?}");
    }

    #[test]
    fn few_or_small_meshes_are_copied() {
        for (nodes, triangles) in [(10, 70), (2000, 60)] {
            let (scene, ..) = load_from(document(nodes, triangles), "a.gltf", None).expect("a scene");
            assert!(scene.objects.iter().all(|object| matches!(object.shape, Shape::Mesh(_))), "{nodes}");
            assert_eq!(scene.objects.len(), nodes + 1);
        }
    }
}
