//! Coordinates of surfaces of many small pieces, such as leaves: a chart for each flat part of a piece, in rows by their heights.
//!
//! [uvunwrap](https://crates.io/crates/uvunwrap) folds charts into each other and takes minutes for 10⁵ of them; rows take a second.

use crate::pieces;
use glam::{DVec2, DVec3, Vec2};
use scene::Mesh;
use std::collections::HashMap;

/// From this number of pieces on a surface is of many ones, if they have few triangles each.
const MANY: usize = 2000;
const TRIANGLES: usize = 8;

/// The cosine between a triangle's normal and its chart's, at least: areas are 6 % too small then.
const FLAT: f64 = 0.94;

/// The most triangles of a chart.
const MOST: usize = 64;

/// Steps in search of the largest density that fits.
const STEPS: usize = 24;

/// Whether a surface is of many small pieces.
pub(crate) fn is_scattered(mesh: &Mesh) -> bool {
    // There are no more pieces than triangles.
    let count = || pieces::count(mesh);
    mesh.triangles.len() >= MANY && {
        let pieces = count();
        pieces >= MANY && mesh.triangles.len() <= TRIANGLES * pieces
    }
}

/// A chart: triangles of a mesh on a plane.
#[derive(Clone, Debug, Default)]
struct Chart {
    /// Places of the triangles in the mesh.
    triangles: Vec<u32>,
    /// Corners of the triangles on the plane, from 0 on, in units of length.
    corners: Vec<[DVec2; 3]>,
    size: DVec2,
}

/// Coordinates of a mesh: those of the vertices, each with the vertex that it is a copy of, and the triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unfolded {
    pub(crate) coordinates: Vec<Vec2>,
    pub(crate) origins: Vec<u32>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// The charts of a mesh.
#[derive(Debug)]
pub(crate) struct Charts<'a> {
    mesh: &'a Mesh,
    charts: Vec<Chart>,
}

/// Whether the insides of two triangles have a place in common.
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    let is_between = |axis: DVec2| {
        let ends = |t: &[DVec2; 3]| {
            let d = t.map(|p| p.dot(axis));
            [d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2])]
        };
        let ([low, high], [from, to]) = (ends(a), ends(b));
        high.min(to) - low.max(from) <= 1e-6 * (high - low).min(to - from)
    };
    let sides = |t: &[DVec2; 3]| [0, 1, 2].map(|k| (t[(k + 1) % 3] - t[k]).perp());
    !sides(a).into_iter().chain(sides(b)).any(is_between)
}

impl<'a> Charts<'a> {
    /// Cost: some 2 µs a triangle.
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        let place = |i: u32| (mesh.positions[i as usize] + 0.0).to_array().map(f32::to_bits);
        let position = |i: u32| mesh.positions[i as usize].as_dvec3();
        let normals: Vec<Option<DVec3>> = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(position);
                (b - a).cross(c - a).try_normalize()
            })
            .collect();
        let mut edges = HashMap::new();
        for (number, t) in mesh.triangles.iter().enumerate().filter(|(number, _)| normals[*number].is_some()) {
            for k in 0..3 {
                edges.entry([place(t[k]), place(t[(k + 1) % 3])]).or_insert(number);
            }
        }
        let mut is_free: Vec<bool> = normals.iter().map(Option::is_some).collect();
        let mut charts = Vec::new();
        for first in 0..mesh.triangles.len() {
            let Some(normal) = normals[first].filter(|_| is_free[first]) else { continue };
            is_free[first] = false;
            let origin = position(mesh.triangles[first][0]);
            let plane = plane(mesh.triangles[first].map(position), normal);
            let flat = |number: usize| {
                mesh.triangles[number].map(|i| DVec2::from_array(plane.map(|axis| (position(i) - origin).dot(axis))))
            };
            let mut chart = Chart { triangles: vec![first as u32], corners: vec![flat(first)], size: DVec2::ZERO };
            let mut next = 0;
            while next < chart.triangles.len() {
                let t = mesh.triangles[chart.triangles[next] as usize];
                next += 1;
                for k in 0..3 {
                    let Some(&other) = edges.get(&[place(t[(k + 1) % 3]), place(t[k])]) else { continue };
                    let is_flat = normals[other].is_some_and(|n| n.dot(normal) >= FLAT);
                    if !is_free[other] || !is_flat || chart.triangles.len() == MOST {
                        continue;
                    }
                    let corners = flat(other);
                    if !chart.corners.iter().any(|known| overlap(known, &corners)) {
                        is_free[other] = false;
                        chart.triangles.push(other as u32);
                        chart.corners.push(corners);
                    }
                }
            }
            charts.push(chart.settled());
        }
        Self { mesh, charts }
    }

    /// The coordinates, of charts at places of a page in texels.
    fn unfolded(&self, places: &[DVec2], density: f64, page: [u32; 2]) -> Unfolded {
        let page = DVec2::new(f64::from(page[0]), f64::from(page[1]));
        let mut all = Unfolded { triangles: vec![[0; 3]; self.mesh.triangles.len()], ..Unfolded::default() };
        let mut known: HashMap<(u32, usize), u32> = HashMap::new();
        for (number, (chart, place)) in self.charts.iter().zip(places).enumerate() {
            for (triangle, corners) in chart.triangles.iter().zip(&chart.corners) {
                for (k, corner) in corners.iter().enumerate() {
                    let origin = self.mesh.triangles[*triangle as usize][k];
                    let vertex = *known.entry((origin, number)).or_insert_with(|| {
                        all.origins.push(origin);
                        all.coordinates.push(((*place + *corner * density) / page).as_vec2());
                        all.origins.len() as u32 - 1
                    });
                    all.triangles[*triangle as usize][k] = vertex;
                }
            }
        }
        // Triangles without an area are on no chart: at its corner, each vertex as a copy of its own.
        for (number, t) in self.mesh.triangles.iter().enumerate() {
            if all.triangles[number] == [0; 3] {
                all.triangles[number] = t.map(|origin| {
                    *known.entry((origin, usize::MAX)).or_insert_with(|| {
                        all.origins.push(origin);
                        all.coordinates.push(Vec2::ZERO);
                        all.origins.len() as u32 - 1
                    })
                });
            }
        }
        all
    }
}

/// Two directions across a normal, the first along the longest side of a triangle.
fn plane(corners: [DVec3; 3], normal: DVec3) -> [DVec3; 2] {
    let sides = [0, 1, 2].map(|k| corners[(k + 1) % 3] - corners[k]);
    let longest =
        sides.into_iter().fold(DVec3::ZERO, |best, side| if side.length() > best.length() { side } else { best });
    let x = longest.reject_from_normalized(normal).normalize_or(normal.any_orthonormal_vector());
    [x, normal.cross(x)]
}

impl Chart {
    /// Moved to where its coordinates begin at 0, and lying: no higher than wide.
    fn settled(mut self) -> Self {
        let each = || self.corners.iter().flatten().copied();
        let (low, high) = (each().fold(DVec2::INFINITY, DVec2::min), each().fold(DVec2::NEG_INFINITY, DVec2::max));
        self.size = high - low;
        let (is_upright, height) = (self.size.y > self.size.x, self.size.y);
        for p in self.corners.iter_mut().flatten() {
            *p -= low;
            if is_upright {
                // A quarter turn; a mirror would turn triangles round.
                *p = DVec2::new(height - p.y, p.x);
            }
        }
        if is_upright {
            self.size = DVec2::new(self.size.y, self.size.x);
        }
        self
    }

    /// Width and height in texels.
    fn texels(&self, density: f64) -> [u32; 2] {
        (self.size * density).to_array().map(|side| side.ceil().max(1.0) as u32)
    }
}

/// Charts of several meshes on one page.
#[derive(Debug)]
pub(crate) struct Sheet {
    /// Width and height of the page.
    pub(crate) size: [u32; 2],
    density: f64,
    places: Vec<Vec<DVec2>>,
}

impl Sheet {
    /// The charts of meshes in rows, the highest first; `None` where they do not fit the page at that density.
    fn packed(meshes: &[Charts<'_>], order: &[(u32, u32)], density: f64, side: u32, padding: u32) -> Option<Self> {
        let mut places: Vec<Vec<DVec2>> = meshes.iter().map(|mesh| vec![DVec2::ZERO; mesh.charts.len()]).collect();
        let (mut x, mut y, mut height) = (0_u64, 0_u64, 0_u64);
        for &(mesh, chart) in order {
            let around = u64::from(2 * padding);
            let [w, h] = meshes[mesh as usize].charts[chart as usize].texels(density).map(|k| u64::from(k) + around);
            if w.max(h) > u64::from(side) {
                return None;
            }
            if x + w > u64::from(side) {
                (x, y, height) = (0, y + height, 0);
            }
            height = height.max(h);
            if y + height > u64::from(side) {
                return None;
            }
            places[mesh as usize][chart as usize] = DVec2::new(x as f64, y as f64) + f64::from(padding);
            x += w;
        }
        Some(Self { size: [side, ((y + height) as u32).max(1)], density, places })
    }

    /// The charts of meshes on one page, at a density or at the largest one that fits; `None` where they do not fit. `heard` stops the search.
    pub(crate) fn new(
        meshes: &[Charts<'_>],
        density: Option<f64>,
        (side, padding): (u32, u32),
        heard: &dyn Fn(f32) -> bool,
    ) -> Option<Self> {
        let charts =
            |(k, mesh): (usize, &Charts<'_>)| (0..mesh.charts.len()).map(move |c| (k as u32, c as u32)).collect();
        let mut order: Vec<(u32, u32)> =
            meshes.iter().enumerate().flat_map(|each| -> Vec<_> { charts(each) }).collect();
        let height = |&(mesh, chart): &(u32, u32)| meshes[mesh as usize].charts[chart as usize].size.y;
        order.sort_by(|a, b| height(b).total_cmp(&height(a)).then(a.cmp(b)));
        if let Some(density) = density {
            return Self::packed(meshes, &order, density, side, padding);
        }
        let area: f64 = meshes.iter().flat_map(|mesh| &mesh.charts).map(|chart| chart.size.x * chart.size.y).sum();
        // Twice what would fill the page, for charts that take less than their boxes' area.
        let mut ends = [0.0, 2.0 * f64::from(side) / area.sqrt()];
        let mut best = Self::packed(meshes, &order, 0.0, side, padding)?;
        for step in 0..STEPS {
            if !heard(step as f32 / STEPS as f32) {
                return Some(best);
            }
            let middle = 0.5 * (ends[0] + ends[1]);
            match Self::packed(meshes, &order, middle, side, padding) {
                Some(fits) => (ends[0], best) = (middle, fits),
                None => ends[1] = middle,
            }
        }
        Some(best)
    }

    /// The coordinates of its meshes, one after the other.
    pub(crate) fn unfolded(&self, meshes: &[Charts<'_>]) -> Vec<Unfolded> {
        let each = meshes.iter().zip(&self.places);
        each.map(|(mesh, places)| mesh.unfolded(places, self.density, self.size)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coverage::Grid;
    use glam::Vec3;
    use lobe_core::Random;

    /// Leaves of two triangles that are bent by some angle, and a triangle without an area.
    fn leaves(count: u32, bend: f32) -> Mesh {
        let mut random = Random::new(7);
        let mut mesh = Mesh::default();
        for k in 0..count {
            let mut vector = || Vec3::from_array([0; 3].map(|_| random.uniform() as f32 - 0.5));
            let (middle, x, y) = (10.0 * vector(), vector().normalize(), vector());
            let y = 0.3 * y.reject_from_normalized(x).normalize();
            let n = x.cross(y) * bend.tan();
            mesh.positions.extend([middle, middle + x, middle + 0.5 * x + y + n, middle + 0.5 * x - y + n]);
            mesh.triangles.extend([[4 * k, 4 * k + 1, 4 * k + 2], [4 * k + 1, 4 * k, 4 * k + 3]]);
        }
        mesh.triangles.push([0, 0, 1]);
        mesh
    }

    fn triangle(mesh: &Mesh, t: [u32; 3]) -> f64 {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    }

    /// Charts lie on the page without touching each other, go round as their triangles do, and have their areas: leaves that are bent
    /// little are one chart, others two.
    #[test]
    fn leaves_lie_in_rows() {
        for (bend, most) in [(0.05, 1), (0.6, 2)] {
            let mesh = leaves(3000, bend);
            assert!(is_scattered(&mesh));
            let charts = [Charts::new(&mesh)];
            assert_eq!(charts[0].charts.len(), 3000 * most);
            let sheet = Sheet::new(&charts, None, (512, 1), &|_| true).unwrap();
            let [width, height] = sheet.size;
            assert!(width == 512 && height <= 512);
            let made = sheet.unfolded(&charts).remove(0);
            let grid = Grid { size: sheet.size, rows: [0, height], cells: 1 };
            let mut owners: HashMap<[u32; 2], u32> = HashMap::new();
            let mut covered = 0.0;
            for (number, t) in made.triangles.iter().enumerate().take(6000) {
                assert_eq!(t.map(|i| made.origins[i as usize]), mesh.triangles[number]);
                let corners = t.map(|i| made.coordinates[i as usize]);
                assert!(corners.iter().all(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()));
                let area = f64::from((corners[1] - corners[0]).perp_dot(corners[2] - corners[0])) * 0.5;
                let texels = area * f64::from(width * height);
                let want = triangle(&mesh, mesh.triangles[number]) * sheet.density * sheet.density;
                assert!(texels < 1.001 * want && texels > 0.93 * want, "{texels} {want}");
                covered += texels;
                // A texel shows one leaf, or one half of it.
                let owner = number as u32 / 2 * 2 + if most == 2 { number as u32 % 2 } else { 0 };
                grid.pieces(corners, |piece| {
                    assert_eq!(*owners.entry(piece.texel).or_insert(owner), owner);
                });
            }
            assert!(covered > 0.12 * f64::from(width * height), "{covered}");
        }
    }

    #[test]
    fn pages_that_are_too_small_are_told() {
        let mesh = leaves(3000, 0.0);
        let charts = [Charts::new(&mesh)];
        assert!(Sheet::new(&charts, None, (64, 1), &|_| true).is_none());
        assert!(Sheet::new(&charts, Some(1e3), (512, 1), &|_| true).is_none());
        assert!(Sheet::new(&charts, Some(1e12), (512, 1), &|_| true).is_none());
        assert!(Sheet::new(&charts, Some(4.0), (512, 1), &|_| true).is_some());
        // A round body of as many triangles is of one piece.
        assert!(!is_scattered(&Mesh::closed_tube(&[Vec3::ZERO, Vec3::X, Vec3::X * 2.0], 1.0, 2000)));
    }

    #[test]
    fn triangles_overlap_inside_alone() {
        let t = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| [a, b, c].map(DVec2::from_array);
        let one = t([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]);
        assert!(!overlap(&one, &t([1.0, 0.0], [1.0, 1.0], [0.0, 1.0])));
        assert!(overlap(&one, &t([0.2, 0.2], [1.0, 1.0], [0.2, 1.0])));
        assert!(overlap(&one, &one));
        assert!(!overlap(&one, &t([2.0, 0.0], [3.0, 0.0], [2.0, 1.0])));
    }
}
