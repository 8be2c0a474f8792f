//! Attributes of vertices that are mixtures of others.

use crate::division::Blend;
use crate::glb::Document;
use crate::rows::{Rows, add_floats, add_joints, add_rows};
use scene_files::GltfDocument;
use serde_json::{Map, Value};

/// The new accessors of a list of attributes, by their names.
pub(crate) type Named = Vec<(String, usize)>;

/// Attributes in a file, and the vertices to be made of them.
pub(crate) struct Blended<'a> {
    pub(crate) file: &'a GltfDocument,
    pub(crate) before: &'a Value,
    pub(crate) vertices: &'a [Blend],
}

impl Blended<'_> {
    fn rows(&self, accessor: &Value) -> Option<Rows> {
        Rows::read(self.file, self.before, accessor.as_u64()? as usize)
    }

    /// The attributes of a primitive, and those of its morph targets.
    ///
    /// Positions, colours and texture coordinates are interpolated, normals and tangents made unit vectors again, and so are the
    /// displacements of morph targets, of which those of normals are divided by the same length: a moved normal has the direction of the
    /// interpolated one. A vertex keeps the joints with the largest sums of weights, as many as the file has for each. Attributes of whole
    /// numbers with names of a program's own are those of the nearest vertex. All other attributes are floats then.
    pub(crate) fn primitive(&self, document: &mut Document, primitive: &Value) -> (Named, Vec<Named>) {
        let attributes = primitive["attributes"].as_object().cloned().unwrap_or_default();
        let normal = self.lengths(attributes.get("NORMAL"), 3);
        let tangent = self.lengths(attributes.get("TANGENT"), 4);
        let lengths = |name: &str| match name {
            "NORMAL" => normal.as_deref(),
            "TANGENT" => tangent.as_deref(),
            _ => None,
        };
        let mut named = self.joints(document, &attributes);
        for (name, accessor) in attributes.iter().filter(|(name, _)| !is_of_skin(name)) {
            named.extend(self.attribute(document, name, accessor, lengths(name)).map(|number| (name.clone(), number)));
        }
        let morphs = primitive["targets"].as_array().into_iter().flatten().map(|morph| {
            let each = morph.as_object().into_iter().flatten();
            each.filter_map(|(name, accessor)| {
                Some((name.clone(), self.attribute(document, name, accessor, lengths(name))?))
            })
            .collect()
        });
        let morphs = morphs.collect();
        (named, morphs)
    }

    /// The interpolated vectors' lengths, of vectors of 3 components and maybe a sign.
    fn lengths(&self, accessor: Option<&Value>, width: usize) -> Option<Vec<f64>> {
        let values = self.rows(accessor?)?.numbers();
        let length = |vertex: &Blend| {
            let sum = |axis: usize| -> f64 {
                vertex.parts().map(|(i, weight)| weight * values.get(i as usize * width + axis).unwrap_or(&0.0)).sum()
            };
            let length = [0, 1, 2].map(sum).iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 1e-6 && vertex.single().is_none() { length } else { 1.0 }
        };
        Some(self.vertices.iter().map(length).collect())
    }

    fn attribute(
        &self,
        document: &mut Document,
        name: &str,
        accessor: &Value,
        lengths: Option<&[f64]>,
    ) -> Option<usize> {
        let rows = self.rows(accessor)?;
        let width = rows.width();
        if name.starts_with('_') && !rows.is_fraction() {
            let nearest = |vertex: &Blend| {
                let far = |a: &(u32, f64), b: &(u32, f64)| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0));
                vertex.parts().max_by(far).map_or(0, |(i, _)| i)
            };
            let origins: Vec<u32> = self.vertices.iter().map(nearest).collect();
            return Some(rows.write(document, &origins));
        }
        let numbers = rows.numbers();
        let mut values = Vec::with_capacity(width * self.vertices.len());
        for (place, vertex) in self.vertices.iter().enumerate() {
            let scale = lengths.map_or(1.0, |lengths| 1.0 / lengths[place]);
            for axis in 0..width {
                let value = |i: u32| numbers.get(i as usize * width + axis).copied().unwrap_or(0.0);
                // The sign of a tangent's fourth component is that of one vertex: it does not change on a triangle.
                let is_sign = name == "TANGENT" && axis == 3;
                let mixed = || vertex.parts().map(|(i, weight)| weight * value(i)).sum::<f64>() * scale;
                values.push(if is_sign { value(vertex.vertices[0]) } else { mixed() } as f32);
            }
        }
        Some(add_rows(document, rows.fields(), width, &values))
    }

    /// The joints and weights of all sets.
    fn joints(&self, document: &mut Document, attributes: &Map<String, Value>) -> Named {
        let sets = (0..).map_while(|set| {
            let [joints, weights] = ["JOINTS", "WEIGHTS"].map(|kind| attributes.get(&format!("{kind}_{set}")));
            Some((self.rows(joints?)?, self.rows(weights?)?))
        });
        let sets: Vec<(Rows, Rows)> = sets.collect();
        let numbers: Vec<[Vec<f64>; 2]> =
            sets.iter().map(|(joints, weights)| [joints.numbers(), weights.numbers()]).collect();
        let row = |vertex: u32| {
            let at = vertex as usize * 4;
            numbers.iter().flat_map(move |[joints, weights]| {
                (at..at + 4).map(|k| (*joints.get(k).unwrap_or(&0.0) as u32, *weights.get(k).unwrap_or(&0.0)))
            })
        };
        let each: Vec<Vec<(u32, f64)>> = self
            .vertices
            .iter()
            .map(|vertex| match vertex.single() {
                Some(single) => row(single).collect(),
                None => {
                    let all =
                        vertex.parts().flat_map(|(i, part)| row(i).map(move |(joint, weight)| (joint, part * weight)));
                    merged(all, 4 * sets.len())
                }
            })
            .collect();
        let mut named = Vec::new();
        for (set, (joints, _)) in sets.iter().enumerate() {
            let of = |vertex: &[(u32, f64)]| [0, 1, 2, 3].map(|k| vertex[4 * set + k]);
            let numbers: Vec<u32> = each.iter().flat_map(|vertex| of(vertex).map(|(joint, _)| joint)).collect();
            let weights: Vec<f32> =
                each.iter().flat_map(|vertex| of(vertex).map(|(_, weight)| weight as f32)).collect();
            named.push((format!("JOINTS_{set}"), add_joints(document, joints.component(), &numbers)));
            named.push((format!("WEIGHTS_{set}"), add_floats(document, "VEC4", &weights)));
        }
        named
    }
}

fn is_of_skin(name: &str) -> bool {
    name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_")
}

/// The `most` joints with the largest sums of weights, the largest first, with the sum of all weights; filled up with joint 0 without a
/// weight.
fn merged(all: impl Iterator<Item = (u32, f64)>, most: usize) -> Vec<(u32, f64)> {
    let mut sums: Vec<(u32, f64)> = Vec::new();
    for (joint, weight) in all.filter(|(_, weight)| *weight > 0.0) {
        match sums.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, sum)) => *sum += weight,
            None => sums.push((joint, weight)),
        }
    }
    let whole: f64 = sums.iter().map(|(_, weight)| weight).sum();
    sums.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    sums.truncate(most);
    let kept: f64 = sums.iter().map(|(_, weight)| weight).sum();
    if kept > 0.0 {
        sums.iter_mut().for_each(|(_, weight)| *weight *= whole / kept);
    }
    sums.resize(most, (0, 0.0));
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_joints_stay() {
        let all = [(3, 0.3), (1, 0.1), (2, 0.05), (3, 0.1), (7, 0.2), (9, 0.25), (4, 0.0)];
        let kept = merged(all.into_iter(), 4);
        assert_eq!(kept.iter().map(|(joint, _)| *joint).collect::<Vec<_>>(), [3, 9, 7, 1]);
        let sum: f64 = kept.iter().map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-12 && (kept[0].1 - 0.4 / 0.95).abs() < 1e-12);
        assert_eq!(merged([(5, 1.0)].into_iter(), 4), [(5, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]);
    }
}
