//! The flat faces of a mesh, as lights.

use crate::flat_light::is_convex;
use crate::{FlatLight, FlatLightError};
use core::f32::consts::PI;
use glam::Vec3;
use std::collections::HashMap;

/// The most faces that are taken.
const MOST: usize = 24;
/// Sine of the angle between triangles up to which they are one face.
const FLAT: f32 = 1e-3;
/// Corners of a polygon that is a disc are as far from its middle as one another, to this part.
const ROUND: f32 = 0.01;

/// Why a mesh is not taken as lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FacesError {
    /// It has no area, or numbers that are not finite.
    Degenerate,
    /// It has more than 24 flat faces, or one that is not a few convex polygons.
    Faces,
}

impl core::fmt::Display for FacesError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Degenerate => f.write_str("the surface has no area"),
            Self::Faces => write!(f, "the surface is not of {MOST} flat faces or fewer"),
        }
    }
}

impl core::error::Error for FacesError {}

/// A mesh whose surface emits the same radiance everywhere, as one [`FlatLight`] for each of its flat faces: exact, since the mesh
/// itself hides what one face hides of another.
///
/// Triangles that share an edge and a plane are one face; a face that is not convex is parted into convex polygons. A face of more than 24
/// corners is taken where it is round, as the disc of its area. The faces of a closed mesh whose triangles all turn the same way are lit outside,
/// all others on both sides.
///
/// # Errors
/// [`FacesError`] for surfaces without area and for those of more than 24 faces, as curved ones are.
///
/// # Panics
/// When a triangle has a corner that is not there.
///
/// ```
/// use glam::Vec3;
/// let (positions, triangles) = ([Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::new(0.0, 1.0, 1.0)], [[0, 1, 2], [0, 2, 3]]);
/// let faces = lighting::faces(&positions, &triangles, Vec3::ONE).unwrap();
/// assert_eq!((faces.len(), faces[0].corners().len(), faces[0].two_sided), (1, 4, true));
/// ```
pub fn faces(positions: &[Vec3], triangles: &[[u32; 3]], radiance: Vec3) -> Result<Vec<FlatLight>, FacesError> {
    if !positions.iter().all(|p| p.is_finite()) {
        return Err(FacesError::Degenerate);
    }
    let (corners, welded) = weld(positions);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| corners[i as usize]);
        (b - a).cross(c - a)
    };
    let mut pieces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|i| welded[i as usize])).collect();
    pieces.retain(|t| area(t).length() > 0.0);
    if pieces.is_empty() {
        return Err(FacesError::Degenerate);
    }
    let mut by_edge: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    for (k, piece) in pieces.iter().enumerate() {
        edges(piece).into_iter().for_each(|edge| by_edge.entry(edge).or_default().push(k));
    }
    let opposite = |[a, b]: [u32; 2]| match by_edge.get(&[b, a]).map(Vec::as_slice) {
        Some(&[one]) if by_edge[&[a, b]].len() == 1 => Some(one),
        _ => None,
    };
    let is_closed = by_edge.keys().all(|edge| opposite(*edge).is_some());
    let volume: f32 = pieces.iter().map(|t| corners[t[0] as usize].dot(area(t))).sum();
    let normals: Vec<Vec3> = pieces.iter().map(|t| area(t).normalize()).collect();

    let mut parts = Vec::new();
    let mut is_taken = vec![false; pieces.len()];
    for first in 0..pieces.len() {
        if is_taken[first] {
            continue;
        }
        let face = coplanar(first, &pieces, &normals, &opposite, &mut is_taken);
        let loops = face.iter().map(|k| pieces[*k].to_vec()).collect();
        parts.extend(convex_parts(loops, &corners, normals[first])?);
        if parts.len() > MOST {
            return Err(FacesError::Faces);
        }
    }
    let light = |mut part: Vec<Vec3>| {
        if is_closed && volume < 0.0 {
            part.reverse();
        }
        let light = polygon(&part, radiance)?;
        Ok(if is_closed { light } else { light.on_both_sides() })
    };
    parts.into_iter().map(light).collect()
}

const fn edges([a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[*a, *b], [*b, *c], [*c, *a]]
}

/// The pieces that are joined to the first in its plane, itself included. They are taken then.
fn coplanar(
    first: usize,
    pieces: &[[u32; 3]],
    normals: &[Vec3],
    opposite: &impl Fn([u32; 2]) -> Option<usize>,
    is_taken: &mut [bool],
) -> Vec<usize> {
    is_taken[first] = true;
    let mut face = vec![first];
    let mut next = 0;
    while next < face.len() {
        for edge in edges(&pieces[face[next]]) {
            let same =
                |k: &usize| normals[*k].dot(normals[first]) > 0.0 && normals[*k].cross(normals[first]).length() < FLAT;
            if let Some(k) = opposite(edge).filter(same)
                && !is_taken[k]
            {
                is_taken[k] = true;
                face.push(k);
            }
        }
        next += 1;
    }
    face
}

/// Corners that coincide are one: those that there are, and which one each position is.
pub(crate) fn weld(positions: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut corners = Vec::new();
    let welded = positions
        .iter()
        .map(|p| {
            *numbers.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert_with(|| {
                corners.push(*p);
                corners.len() as u32 - 1
            })
        })
        .collect();
    (corners, welded)
}

/// Joins polygons of a plane along their edges as long as they stay convex (S. Hertel, K. Mehlhorn, *Fast triangulation of simple
/// polygons*, 1983), after a try to take their common outline.
fn convex_parts(mut loops: Vec<Vec<u32>>, corners: &[Vec3], normal: Vec3) -> Result<Vec<Vec<Vec3>>, FacesError> {
    let place = |part: &[u32]| -> Vec<Vec3> {
        without_straight(&part.iter().map(|i| corners[*i as usize]).collect::<Vec<_>>())
    };
    if let Some(outline) = outline(&loops)
        && is_convex(&place(&outline), normal)
    {
        return Ok(vec![place(&outline)]);
    }
    // The rest would be refused, and takes long.
    if loops.len() > 64 * MOST {
        return Err(FacesError::Faces);
    }
    let mut k = 0;
    while k < loops.len() {
        let joined = (k + 1..loops.len()).find_map(|other| {
            let whole = join(&loops[k], &loops[other])?;
            is_convex(&place(&whole), normal).then_some((other, whole))
        });
        match joined {
            Some((other, whole)) => {
                loops.swap_remove(other);
                loops[k] = whole;
            }
            None => k += 1,
        }
    }
    Ok(loops.iter().map(|part| place(part)).collect())
}

/// The one outline of polygons that are joined edge to edge; none where there are holes, or corners at which it meets itself.
fn outline(loops: &[Vec<u32>]) -> Option<Vec<u32>> {
    let pairs = |part: &Vec<u32>| (0..part.len()).map(|i| [part[i], part[(i + 1) % part.len()]]).collect::<Vec<_>>();
    let all: Vec<[u32; 2]> = loops.iter().flat_map(pairs).collect();
    let known: std::collections::HashSet<[u32; 2]> = all.iter().copied().collect();
    let mut next = HashMap::new();
    for [a, b] in all.into_iter().filter(|[a, b]| !known.contains(&[*b, *a])) {
        if next.insert(a, b).is_some() {
            return None;
        }
    }
    let first = *next.keys().min()?;
    let mut outline = vec![first];
    let mut at = next[&first];
    while at != first && outline.len() <= next.len() {
        outline.push(at);
        at = *next.get(&at)?;
    }
    (outline.len() == next.len()).then_some(outline)
}

/// Two polygons that share an edge, as one.
fn join(p: &[u32], q: &[u32]) -> Option<Vec<u32>> {
    for i in 0..p.len() {
        let (a, b) = (p[i], p[(i + 1) % p.len()]);
        let Some(j) = (0..q.len()).find(|j| q[*j] == b && q[(j + 1) % q.len()] == a) else { continue };
        // From b around p to a, then what of q lies between a and b.
        let around = (1..=p.len()).map(|k| p[(i + k) % p.len()]);
        let between = (2..q.len()).map(|k| q[(j + k) % q.len()]);
        return Some(around.chain(between).collect());
    }
    None
}

/// A polygon without corners at which it goes straight on.
fn without_straight(part: &[Vec3]) -> Vec<Vec3> {
    let mut out = part.to_vec();
    let mut k = 0;
    while k < out.len() && out.len() > 3 {
        let n = out.len();
        let (p, q) = (out[k] - out[(k + n - 1) % n], out[(k + 1) % n] - out[k]);
        if p.cross(q).length() <= FLAT * p.length() * q.length() && p.dot(q) >= 0.0 {
            out.remove(k);
        } else {
            k += 1;
        }
    }
    out
}

fn polygon(part: &[Vec3], radiance: Vec3) -> Result<FlatLight, FacesError> {
    match FlatLight::polygon(part, radiance) {
        Ok(light) => return Ok(light),
        Err(FlatLightError::Corners) => {}
        Err(FlatLightError::Degenerate) => return Err(FacesError::Degenerate),
        Err(FlatLightError::NotFlat | FlatLightError::NotConvex) => return Err(FacesError::Faces),
    }
    let middle = part.iter().sum::<Vec3>() / part.len() as f32;
    let (low, high) = part
        .iter()
        .map(|p| p.distance(middle))
        .fold((f32::INFINITY, 0.0_f32), |(low, high), r| (low.min(r), high.max(r)));
    let twice: Vec3 = (0..part.len()).map(|k| (part[k] - middle).cross(part[(k + 1) % part.len()] - middle)).sum();
    if high - low > ROUND * high {
        return Err(FacesError::Faces);
    }
    let radius = (0.5 * twice.length() / PI).sqrt();
    FlatLight::disc(middle, twice, radius, radiance).map_err(|_| FacesError::Degenerate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::TAU;
    use shading::LightLobes;

    /// The prism over a polygon, all triangles turned outward.
    fn prism(base: &[Vec3]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let n = base.len() as u32;
        let positions = base.iter().copied().chain(base.iter().map(|p| *p + Vec3::Z)).collect();
        let mut triangles = Vec::new();
        for k in 0..n {
            let next = (k + 1) % n;
            triangles.extend([[k, next, n + next], [k, n + next, n + k]]);
        }
        (positions, triangles)
    }

    fn ring(n: usize) -> Vec<Vec3> {
        let angle = |k: usize| TAU * k as f32 / n as f32;
        (0..n).map(|k| Vec3::new(angle(k).cos(), angle(k).sin(), 0.0)).collect()
    }

    #[test]
    fn a_box_is_six_rectangles() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let (positions, mut triangles) = prism(&square);
        triangles.extend([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]]);
        for flipped in [false, true] {
            if flipped {
                triangles.iter_mut().for_each(|t| t.swap(0, 1));
            }
            let lights = faces(&positions, &triangles, Vec3::ONE).expect("faces");
            assert_eq!(lights.len(), 6);
            for light in lights {
                assert_eq!((light.corners().len(), light.two_sided), (4, false));
                assert!((light.area() - 1.0).abs() < 1e-6);
                let outward = light.bounds().center - Vec3::splat(0.5);
                assert!(outward.dot(light.normal()) > 0.49, "{light:?}");
            }
        }
        // Without a lid it is lit inside, too.
        let lights = faces(&positions, &triangles[..10], Vec3::ONE).expect("faces");
        assert!(lights.len() == 5 && lights.iter().all(|l| l.two_sided));
    }

    /// The parts of any flat face have its area and do not overlap; corners on straight lines go.
    #[test]
    fn faces_that_are_not_convex_are_parted() {
        let p = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        // An L, with a corner on a side.
        let corners = [p(0.0, 0.0), p(1.0, 0.0), p(2.0, 0.0), p(2.0, 1.0), p(1.0, 1.0), p(1.0, 2.0), p(0.0, 2.0)];
        let triangles = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 6], [4, 5, 6]];
        let lights = faces(&corners, &triangles, Vec3::ONE).expect("faces");
        assert_eq!(lights.len(), 2);
        assert!((lights.iter().map(FlatLight::area).sum::<f32>() - 3.0).abs() < 1e-6);
        // A square frame has a hole.
        let inner = [p(1.0, 1.0), p(2.0, 1.0), p(2.0, 2.0), p(1.0, 2.0)];
        let outer = [p(0.0, 0.0), p(3.0, 0.0), p(3.0, 3.0), p(0.0, 3.0)];
        let corners = [inner, outer].concat();
        let triangles: Vec<[u32; 3]> = (0..4)
            .flat_map(|k| {
                let next = (k + 1) % 4;
                [[4 + k, 4 + next, next], [4 + k, next, k]]
            })
            .collect();
        let lights = faces(&corners, &triangles, Vec3::ONE).expect("faces");
        assert_eq!(lights.len(), 4);
        assert!((lights.iter().map(FlatLight::area).sum::<f32>() - 8.0).abs() < 1e-5);
    }

    #[test]
    fn fine_fans_are_discs() {
        let mut positions = ring(64);
        positions.push(Vec3::ZERO);
        let triangles: Vec<[u32; 3]> = (0..64).map(|k| [k, (k + 1) % 64, 64]).collect();
        let lights = faces(&positions, &triangles, Vec3::ONE).expect("a disc");
        assert_eq!(lights.len(), 1);
        let area = 32.0 * (TAU / 64.0).sin();
        assert!(lights[0].as_disc().1.is_some() && (lights[0].area() / area - 1.0).abs() < 1e-5);
        // An ellipse is none.
        positions.iter_mut().for_each(|p| p.x *= 2.0);
        assert_eq!(faces(&positions, &triangles, Vec3::ONE), Err(FacesError::Faces));
    }

    #[test]
    fn what_is_no_face_is_refused() {
        let (positions, triangles) = prism(&ring(24));
        assert_eq!(faces(&positions, &triangles, Vec3::ONE).expect("24 sides").len(), 24);
        let (positions, triangles) = prism(&ring(25));
        assert_eq!(faces(&positions, &triangles, Vec3::ONE), Err(FacesError::Faces));
        assert_eq!(faces(&[Vec3::ZERO; 3], &[[0, 1, 2]], Vec3::ONE), Err(FacesError::Degenerate));
        assert_eq!(faces(&[], &[], Vec3::ONE), Err(FacesError::Degenerate));
        let positions = [Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN)];
        assert_eq!(faces(&positions, &[[0, 1, 2]], Vec3::ONE), Err(FacesError::Degenerate));
    }
}
