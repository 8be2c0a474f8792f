//! Simplified meshes, for outlines that are seen from a distance.

mod patch;
mod steps;

pub(crate) use patch::{Patch, Reduced};

use crate::topology::WHOLE;
use core::ops::Range;
use glam::Vec3;
use patch::Form;
use rayon::prelude::*;

/// The most triangles of a patch. Its rim is not simplified, so a small patch loses few triangles.
const PATCH: usize = 2048;

/// A mesh in patches, and their simplified forms. Each form has the rim of its patch, so that any forms fit together.
#[derive(Debug)]
pub(crate) struct Coarse {
    /// The patch of each triangle of the mesh; [`WHOLE`] if it has no simplified form.
    pub(crate) patches: Vec<u16>,
    /// Corners of the mesh that simplified forms store as corners of their own, since these may be moved.
    pub(crate) own: Vec<u32>,
    /// The triangles of the simplified forms, between corners of the mesh on rims and their own corners, which are numbered after
    /// those of the mesh; and the patches of these triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) triangle_patches: Vec<u16>,
    /// Each corner that is left out, and the number in `triangles` of the triangle next to it.
    pub(crate) left_out: Vec<[u32; 2]>,
    /// Patches with a simplified form.
    pub(crate) count: usize,
}

/// The most patches: two of their numbers fit into a [`Tag`](topology::Tag).
const MOST: usize = 1 << 14;

/// Simplifies a mesh patch by patch; `None` if that saves too little.
pub(crate) fn coarse(positions: &[Vec3], triangles: &[[u32; 3]]) -> Option<Coarse> {
    let middle = |t: &[u32; 3]| t.iter().map(|i| positions[*i as usize]).sum();
    let middles: Vec<Vec3> = triangles.par_iter().map(middle).collect();
    let middle = |t: &u32| middles[*t as usize];
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let parts = divide(&mut order, 0, &middle);
    let forms: Vec<Option<Form>> = parts
        .par_iter()
        .map(|part| Patch::new(positions, triangles, &order[part.clone()]).simplified(positions.len()))
        .collect();
    let mut out = Coarse {
        patches: vec![WHOLE; triangles.len()],
        own: Vec::new(),
        triangles: Vec::new(),
        triangle_patches: Vec::new(),
        left_out: Vec::new(),
        count: 0,
    };
    for (part, form) in parts.into_iter().zip(forms) {
        let (Some(form), true) = (form, out.count < MOST) else { continue };
        let patch = out.count as u16;
        let first = out.triangles.len() as u32;
        order[part].iter().for_each(|t| out.patches[*t as usize] = patch);
        out.triangle_patches.extend(form.triangles.iter().map(|_| patch));
        let (mesh, before) = (positions.len() as u32, out.own.len() as u32);
        let place = |i: u32| if i < mesh { i } else { i + before };
        out.triangles.extend(form.triangles.iter().map(|t| t.map(place)));
        out.own.extend(form.own);
        out.left_out.extend(form.left_out.iter().map(|[corner, near]| [*corner, near + first]));
        out.count += 1;
    }
    (out.count > 0).then_some(out)
}

/// Halves a list of triangles by the centres of their corners until the parts are small. Returns the parts.
fn divide(order: &mut [u32], first: usize, middle: &(impl Fn(&u32) -> Vec3 + Sync)) -> Vec<Range<usize>> {
    if order.len() <= PATCH {
        return core::iter::once(first..first + order.len()).collect();
    }
    let bounds = order.iter().map(middle).fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[a, b], m| [a.min(m), b.max(m)]);
    let axis = (bounds[1] - bounds[0]).max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b)));
    let (low, high) = order.split_at_mut(half);
    let (mut parts, more) = rayon::join(|| divide(low, first, middle), || divide(high, first + half, middle));
    parts.extend(more);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology;
    use lobe_core::oracle::Random;
    use std::collections::BTreeMap;

    /// A wavy sheet, folded so that it meets itself: triangles of 60 by 60 squares.
    fn sheet(random: &mut Random) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        const SIDE: u32 = 60;
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..=SIDE {
            for k in 0..=SIDE {
                let height = (i as f32 * 0.2).sin() + (k as f32 * 0.15).cos() + random.uniform() as f32 * 0.05;
                positions.push(Vec3::new(i as f32, height, k as f32));
            }
        }
        let corner = |i: u32, k: u32| i * (SIDE + 1) + k;
        for (i, k) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| (i, k))) {
            let [a, b, c, d] = [corner(i, k), corner(i + 1, k), corner(i, k + 1), corner(i + 1, k + 1)];
            triangles.extend([[a, b, c], [c, b, d]]);
        }
        // A fin across two patches: edges of three triangles.
        positions.push(Vec3::new(30.0, 9.0, 30.0));
        let top = positions.len() as u32 - 1;
        triangles.extend((0..SIDE).map(|k| [corner(30, k), corner(30, k + 1), top]));
        (positions, triangles)
    }

    /// For any choice of forms, and on any side of each triangle, all outlines are closed.
    #[test]
    fn any_forms_go_together() {
        let mut random = Random::new(3);
        let (positions, mut triangles) = sheet(&mut random);
        topology::oriented(&mut triangles);
        let fine = triangles.len();
        let coarse = coarse(&positions, &triangles).expect("a large mesh");
        assert!(coarse.count > 1 && coarse.triangles.len() * 3 < fine);
        triangles.extend(coarse.triangles);
        let patches = [coarse.patches, coarse.triangle_patches].concat();
        let edges = topology::tagged_edges(&triangles, fine as u32, &patches);
        for _ in 0..20 {
            let forms: Vec<bool> = (0..coarse.count).map(|_| random.uniform() < 0.5).collect();
            let side: Vec<i32> = (0..triangles.len()).map(|_| (random.uniform() * 3.0) as i32 - 1).collect();
            let mut ends = BTreeMap::new();
            let mut drawn = 0;
            for (edge, tag) in &edges {
                if tag.patches().all(|(patch, is_coarse)| forms[usize::from(patch)] == is_coarse) {
                    let step = side[edge.triangle() as usize] - edge.other().map_or(0, |t| side[t as usize]);
                    let [from, to] = edge.ends().map(|k| triangles[edge.triangle() as usize][k]);
                    *ends.entry(from).or_insert(0) -= step;
                    *ends.entry(to).or_insert(0) += step;
                    drawn += edge.triangles().count();
                }
            }
            assert!(ends.values().all(|sum| *sum == 0));
            // Each side of each triangle occurs once.
            let is_chosen = |t: &usize| patches[*t] == WHOLE || forms[usize::from(patches[*t])] == (*t >= fine);
            assert_eq!(drawn, 3 * (0..triangles.len()).filter(is_chosen).count());
        }
    }
}
