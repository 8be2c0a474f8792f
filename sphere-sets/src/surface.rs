use std::collections::HashMap;

use glam::{DVec3, Vec3, Vec4};
use lobe_core::Sphere;

use crate::error::BuildError;

/// A cleaned triangle soup in *unit space*: centred at the origin, bounding-box diagonal `D = 1`.
///
/// Equal positions are one vertex, triangles without area and repeated triangles are gone, and neighbouring triangles
/// are turned alike with every patch's volume positive, so that the winding of the input does not matter.
pub(crate) struct Surface {
    pub(crate) triangles: Vec<[Vec3; 3]>,
    /// Per triangle: the vertices that it came from, corner by corner.
    pub(crate) sources: Vec<[u32; 3]>,
    pub(crate) center: DVec3,
    pub(crate) diagonal: f64,
    pub(crate) bounds: [Vec3; 2],
}

impl Surface {
    pub(crate) fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, BuildError> {
        let used = used_vertices(positions, triangles)?;
        let (mut lo, mut hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (&p, _) in positions.iter().zip(&used).filter(|(_, used)| **used) {
            (lo, hi) = (lo.min(p), hi.max(p));
        }
        let diagonal = (hi.as_dvec3() - lo.as_dvec3()).length();
        if diagonal == 0.0 {
            return Err(BuildError::NoArea);
        }
        if !(f64::from(f32::MIN_POSITIVE) * 1e6..=f64::from(f32::MAX) * 0.25).contains(&diagonal) {
            return Err(BuildError::ExtentOutOfRange);
        }
        let center = (lo.as_dvec3() + hi.as_dvec3()) * 0.5;
        let to_unit = |p: Vec3| ((p.as_dvec3() - center) / diagonal).as_vec3();

        let (vertices, welded) = weld(positions.iter().map(|&p| to_unit(p)), &used);
        // The number of a welded vertex, and the number of the vertex before welding.
        let mut faces: Vec<[(u32, u32); 3]> = triangles
            .iter()
            .map(|t| canonical(t.map(|i| (welded[i as usize], i))))
            .filter(|f| has_area(&vertices, f))
            .collect();
        remove_repeats(&mut faces);
        if faces.is_empty() {
            return Err(BuildError::NoArea);
        }
        turn_alike(&vertices, &mut faces);
        let triangles = faces.iter().map(|f| f.map(|(i, _)| vertices[i as usize])).collect();
        let sources = faces.iter().map(|f| f.map(|(_, i)| i)).collect();
        Ok(Self { triangles, sources, center, diagonal, bounds: [lo, hi] })
    }

    /// The bounding box in unit space.
    pub(crate) fn unit_bounds(&self) -> [Vec3; 2] {
        self.bounds.map(|p| ((p.as_dvec3() - self.center) / self.diagonal).as_vec3())
    }

    /// A sphere (centre, radius) of unit space in the space of the mesh.
    pub(crate) fn to_world(&self, sphere: Vec4) -> Sphere {
        Sphere {
            center: (sphere.truncate().as_dvec3() * self.diagonal + self.center).as_vec3(),
            radius: (f64::from(sphere.w) * self.diagonal) as f32,
        }
    }

    /// The inverse of [`Surface::to_world`].
    pub(crate) fn to_unit(&self, sphere: Sphere) -> Vec4 {
        ((sphere.center.as_dvec3() - self.center) / self.diagonal)
            .as_vec3()
            .extend((f64::from(sphere.radius) / self.diagonal) as f32)
    }

    /// A map from the unit cube to the surface (triangle, barycentric coordinates) that keeps areas' ratios.
    pub(crate) fn spread(&self) -> impl Fn(Vec3) -> (usize, [f32; 3]) + Sync + use<> {
        let mut total = 0.0_f64;
        let upto: Vec<f64> = self
            .normals()
            .map(|normal| {
                total += f64::from(normal.length());
                total
            })
            .collect();
        move |at| {
            let t = upto.partition_point(|sum| *sum < f64::from(at.x) * total).min(upto.len() - 1);
            let s = at.y.sqrt();
            (t, [1.0 - s, s * (1.0 - at.z), s * at.z])
        }
    }

    /// Twice the vector area of each triangle.
    pub(crate) fn normals(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.triangles.iter().map(|t| (t[1] - t[0]).cross(t[2] - t[0]))
    }
}

fn used_vertices(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Vec<bool>, BuildError> {
    if triangles.is_empty() {
        return Err(BuildError::EmptyMesh);
    }
    let mut used = vec![false; positions.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            let Some(position) = positions.get(vertex as usize) else {
                return Err(BuildError::VertexOutOfRange { triangle, vertex, vertices: positions.len() });
            };
            if !position.is_finite() {
                return Err(BuildError::NonFiniteVertex { vertex });
            }
            used[vertex as usize] = true;
        }
    }
    Ok(used)
}

/// One vertex for each distinct position; numbers follow the order of the positions, not of the triangles.
fn weld(positions: impl Iterator<Item = Vec3>, used: &[bool]) -> (Vec<Vec3>, Vec<u32>) {
    let mut numbers = HashMap::new();
    let mut vertices = Vec::new();
    let welded = positions
        .zip(used)
        .map(|(p, &used)| {
            if !used {
                return 0;
            }
            // Adding zero makes −0 the same as 0.
            let key = (p + Vec3::ZERO).to_array().map(f32::to_bits);
            *numbers.entry(key).or_insert_with(|| {
                vertices.push(p);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    (vertices, welded)
}

/// The same cyclic order, smallest number first.
fn canonical([a, b, c]: [(u32, u32); 3]) -> [(u32, u32); 3] {
    if a.0 <= b.0 && a.0 <= c.0 {
        [a, b, c]
    } else if b.0 <= c.0 {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn has_area(vertices: &[Vec3], face: &[(u32, u32); 3]) -> bool {
    let [a, b, c] = face.map(|(i, _)| vertices[i as usize]);
    (b - a).cross(c - a).length_squared() > 0.0
}

/// Keeps the first of the triangles with the same three corners (double-sided sheets are stored twice).
fn remove_repeats(faces: &mut Vec<[(u32, u32); 3]>) {
    let mut seen = std::collections::HashSet::new();
    faces.retain(|&[(a, _), (b, _), (c, _)]| seen.insert([a, b.min(c), b.max(c)]));
}

/// Orients the triangles of each patch (joined by edges of exactly two triangles) alike, and the patch so that it
/// encloses a positive volume; a flat patch so that it faces away from the mesh's centre.
fn turn_alike(vertices: &[Vec3], faces: &mut [[(u32, u32); 3]]) {
    let neighbours = neighbours(faces);
    let corners = |t: usize| faces[t].map(|(i, _)| vertices[i as usize].as_dvec3());
    let mut mean = DVec3::ZERO;
    for t in 0..faces.len() {
        mean += corners(t).iter().sum::<DVec3>();
    }
    mean /= 3.0 * faces.len() as f64;

    let mut turned: Vec<Option<bool>> = vec![None; faces.len()];
    for seed in 0..faces.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut patch = vec![seed];
        let mut next = 0;
        while let Some(&t) = patch.get(next) {
            next += 1;
            for (other, flip) in neighbours[t].iter().flatten() {
                if turned[*other].is_none() {
                    turned[*other] = turned[t].map(|own| own ^ flip);
                    patch.push(*other);
                }
            }
        }
        let of_patch = patch.iter().map(|&t| (corners(t), turned[t] == Some(true)));
        let inside_out = is_inside_out(of_patch, patch.len(), mean);
        for &t in &patch {
            turned[t] = turned[t].map(|own| own ^ inside_out);
        }
    }
    for (face, turned) in faces.iter_mut().zip(turned) {
        if turned == Some(true) {
            face.swap(1, 2);
        }
    }
}

/// The neighbours of each triangle across edges of two triangles, and whether one of both has to be turned.
fn neighbours(faces: &[[(u32, u32); 3]]) -> Vec<[Option<(usize, bool)>; 3]> {
    // (edge, triangle, whether the triangle runs along the edge from the smaller number to the larger)
    let mut edges: Vec<((u32, u32), usize, bool)> = Vec::with_capacity(faces.len() * 3);
    for (t, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k].0, face[(k + 1) % 3].0);
            edges.push(((a.min(b), a.max(b)), t, a < b));
        }
    }
    edges.sort_unstable_by_key(|&(edge, t, _)| (edge, t));
    let mut neighbours: Vec<[Option<(usize, bool)>; 3]> = vec![[None; 3]; faces.len()];
    let mut link = |t: usize, other: usize, flip: bool| {
        if let Some(slot) = neighbours[t].iter_mut().find(|slot| slot.is_none()) {
            *slot = Some((other, flip));
        }
    };
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a, along_a), (_, b, along_b)] = *group {
            link(a, b, along_a == along_b);
            link(b, a, along_a == along_b);
        }
    }
    neighbours
}

/// Whether a patch of triangles, each with whether it is turned, has a negative volume, or, if it is flat, faces the middle of the mesh.
fn is_inside_out(patch: impl Iterator<Item = ([DVec3; 3], bool)> + Clone, count: usize, mean: DVec3) -> bool {
    let centroid =
        patch.clone().map(|(corners, _)| corners.iter().sum::<DVec3>()).sum::<DVec3>() / (3.0 * count as f64);
    let (mut volume, mut area, mut vector_area) = (0.0, 0.0, DVec3::ZERO);
    for (corners, is_turned) in patch {
        let sign = if is_turned { -1.0 } else { 1.0 };
        let [a, b, c] = corners.map(|p| p - centroid);
        volume += sign * a.dot(b.cross(c)) / 6.0;
        let normal = (b - a).cross(c - a) * 0.5;
        vector_area += normal * sign;
        area += normal.length();
    }
    let flat = volume.abs() < 1e-6 * area * area.sqrt();
    if flat { vector_area.dot(centroid - mean) < 0.0 } else { volume < 0.0 }
}
