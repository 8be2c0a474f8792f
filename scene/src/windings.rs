//! Faces that wind against those beside them.

use crate::Mesh;
use crate::edges::Edges;
use crate::joined::Joined;

/// Which triangles wind against the most of those that edges connect them with, directly or through others; `None` where all agree.
/// Edges of more than two triangles connect none, nor do repeated triangles. None of a surface with one side alone, as a Möbius strip
/// has, is against it. `triangles` are corners by place: the same number where positions are the same.
///
/// Linear in the triangles.
#[must_use]
pub fn faces_against(triangles: &[[u32; 3]]) -> Option<Vec<bool>> {
    let edges = Edges::of(triangles);
    if !edges.pairs(triangles).any(|(.., disagree)| disagree) {
        return None;
    }
    let mut joined = Joined::new(triangles.len());
    for (one, other, disagree) in edges.pairs(triangles) {
        joined.join(one, other, disagree);
    }
    let roots: Vec<(u32, bool)> = (0..triangles.len() as u32).map(|face| joined.root(face)).collect();
    let mut turned = vec![0_i64; triangles.len()];
    for &(root, is_turned) in &roots {
        turned[root as usize] += if is_turned { 1 } else { -1 };
    }
    let mut has_one_side = vec![false; triangles.len()];
    for (one, other, disagree) in edges.pairs(triangles) {
        let [one, other] = [one, other].map(|face| roots[face as usize]);
        has_one_side[one.0 as usize] |= (one.1 != other.1) != disagree;
    }
    let is_against =
        |&(root, is_turned): &(u32, bool)| !has_one_side[root as usize] && is_turned != (turned[root as usize] > 0);
    let faces: Vec<bool> = roots.iter().map(is_against).collect();
    faces.contains(&true).then_some(faces)
}

impl Mesh {
    /// Turns the triangles round that wind against the most of those around them; `places` has a number for each vertex.
    pub(crate) fn align_windings(&mut self, places: &[u32]) {
        let by_place: Vec<[u32; 3]> = self.triangles.iter().map(|t| t.map(|i| places[i as usize])).collect();
        let against = faces_against(&by_place);
        for (t, _) in self.triangles.iter_mut().zip(against.iter().flatten()).filter(|(_, against)| **against) {
            t.swap(1, 2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A ring around the y axis.
    fn ring() -> Mesh {
        let at = |k: u32| {
            let (sin, cos) = (core::f32::consts::TAU * k as f32 / 24.0).sin_cos();
            Vec3::new(2.0 * cos, 0.0, 2.0 * sin)
        };
        Mesh::closed_tube(&(0..24).map(at).collect::<Vec<_>>(), 0.5, 10)
    }

    #[test]
    fn faces_that_wind_against_others_are_smooth() {
        let right = ring();
        for (step, turned) in [(7, 1), (3, 2), (2, 1), (5, 3)] {
            let mut mixed = right.clone();
            for (_, t) in mixed.triangles.iter_mut().enumerate().filter(|(k, _)| k % step < turned) {
                t.swap(1, 2);
            }
            mixed.smooth_normals();
            let along = |(p, n): (&Vec3, &Vec3)| (*p - 2.0 * Vec3::new(p.x, 0.0, p.z).normalize()).normalize().dot(*n);
            let sides: Vec<f32> = mixed.positions.iter().zip(&mixed.normals).map(along).collect();
            assert!(sides.iter().all(|side| side * sides[0] > 0.9), "{step}: {sides:?}");
        }
    }

    #[test]
    fn sheets_of_two_sides_stay() {
        let mut sheet = ring();
        let backs: Vec<[u32; 3]> = sheet.triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
        sheet.triangles.extend(backs);
        let before = sheet.triangles.clone();
        sheet.smooth_normals();
        assert_eq!(sheet.triangles, before);
    }

    #[test]
    fn surfaces_of_one_side_stay() {
        let n = 20;
        let mut band = Mesh::default();
        for k in 0..n {
            let (sin, cos) = (core::f32::consts::TAU * k as f32 / n as f32).sin_cos();
            let (half_sin, half_cos) = (core::f32::consts::PI * k as f32 / n as f32).sin_cos();
            for side in [-0.3, 0.3] {
                let along = 1.0 + side * half_cos;
                band.positions.push(Vec3::new(along * cos, side * half_sin, along * sin));
            }
            let (a, b) = (2 * k, 2 * k + 1);
            let [c, d] = if k + 1 < n { [a + 2, b + 2] } else { [1, 0] };
            band.triangles.extend([[a, b, d], [a, d, c]]);
        }
        let before = band.triangles.clone();
        band.smooth_normals();
        assert_eq!(band.triangles, before);
        assert!(band.normals.iter().all(|n| n.is_finite() && (n.length() - 1.0).abs() < 1e-5));
    }
}
