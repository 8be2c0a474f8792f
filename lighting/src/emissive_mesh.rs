//! A mesh that emits, as lights: by its flat faces, or by spheres and tubes.

mod lamp;
mod picture;
mod triangle;
mod tube;

use self::lamp::Lamp;
use self::picture::Picture;
use self::triangle::{Triangle, area, bounds, moments};
use self::tube::{capsule, part_of_ring};
use crate::faces::weld;
use crate::{FacesError, Light, faces};
use core::f64::consts::PI;
use glam::{DVec3, Vec3};
use lobe_core::{Lobe, Receiver, cap_integral, outline_integral};
use shading::LightLobes;

/// The most lights that a mesh becomes.
const MOST: usize = 24;
/// Lights for a part of a mesh: the fewest that are good enough.
const COUNTS: [usize; 5] = [1, 2, 4, 8, 16];
/// How much of what receivers see may be elsewhere for a light to be good enough; mean error of irradiance beyond which none is taken.
const GOOD: f64 = 0.05;
const WORST: f64 = 0.25;
/// Receivers that the lights are compared at: directions, and distances in radii of the part.
const DIRECTIONS: usize = 24;
const DISTANCES: [f64; 2] = [1.5, 4.0];
/// Pieces that are divided among lights are no longer than this, in radii of the part.
const PIECE: f64 = 0.2;
/// The lights that stand for a mesh ([`emissive_mesh`]).
#[derive(Clone, Debug, PartialEq)]
pub struct EmissiveMesh {
    /// The lights.
    pub lights: Vec<Light>,
    /// Whether they are inside the mesh, which must not hide them: spheres and tubes. Flat faces are the mesh itself.
    pub is_inside: bool,
    /// How far their irradiance is off, a part of it: the mean over receivers around the mesh, at 1.5 and 4 times its radius. Of the
    /// separate parts of a mesh the largest.
    pub error: f32,
}

/// Why a mesh is not taken as lights.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum EmissiveMeshError {
    /// It has no area, or numbers that are not finite.
    Degenerate,
    /// It is of more than 24 separate parts.
    Parts,
    /// Spheres and tubes give a light that is off by this part of it.
    Shape(f32),
}

impl core::fmt::Display for EmissiveMeshError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Degenerate => f.write_str("the surface has no area"),
            Self::Parts => write!(f, "the surface is of more than {MOST} flat faces and separate parts"),
            Self::Shape(error) => write!(f, "spheres and tubes in place of the surface err by {:.0} %", 100.0 * error),
        }
    }
}

impl core::error::Error for EmissiveMeshError {}

/// Lights for a mesh whose surface emits the same radiance everywhere.
///
/// Up to 24 flat faces are what they are ([`faces`]). Of other meshes each separate part becomes a sphere or a tube, or several where
/// that is nearer to it: the fewest of 1, 2, 4, 8 and 16 that receivers see where they see the part, but for a twentieth, else the best. A sphere has
/// the area that the part shows to receivers around it; a tube has the areas that it shows along its axis and across; of several each has the area
/// that its part of the surface shows. The radiance is that of equal irradiance four radii away.
///
/// Each receiver's view of the mesh is drawn as 192² cells, so that a side hidden by another is not counted twice. Receivers
/// inside the mesh's bounds, as under a lamp shade, are left out.
///
/// # Cost
/// Every triangle is drawn for 48 receivers, and a few times more for each lamp.
///
/// # Errors
/// [`EmissiveMeshError`] for surfaces without area, with more than 24 parts, and where the error is above 25 %.
///
/// # Panics
/// When a triangle has a corner that is not there.
///
/// ```
/// use glam::Vec3;
/// // A prism of 32 sides, without lids.
/// let angle = |k: u32| k as f32 * core::f32::consts::TAU / 32.0;
/// let positions: Vec<Vec3> =
///     (0..64).map(|k| Vec3::new(angle(k % 32).cos(), angle(k % 32).sin(), (k / 32) as f32 * 20.0)).collect();
/// let triangles: Vec<[u32; 3]> =
///     (0..32).flat_map(|k| [[k, (k + 1) % 32, 32 + k], [32 + k, (k + 1) % 32, 32 + (k + 1) % 32]]).collect();
/// let lamp = lighting::emissive_mesh(&positions, &triangles, Vec3::ONE).unwrap();
/// assert_eq!((lamp.lights.len(), lamp.lights[0].name(), lamp.is_inside), (1, "tube", true));
/// assert!(lamp.error < 0.02);
/// ```
pub fn emissive_mesh(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    radiance: Vec3,
) -> Result<EmissiveMesh, EmissiveMeshError> {
    match faces(positions, triangles, radiance) {
        Ok(faces) => {
            let lights = faces.into_iter().map(Light::from).collect();
            return Ok(EmissiveMesh { lights, is_inside: false, error: 0.0 });
        }
        Err(FacesError::Degenerate) => return Err(EmissiveMeshError::Degenerate),
        Err(FacesError::Faces) => {}
    }
    let parts = separate(positions, triangles);
    if parts.len() > MOST {
        return Err(EmissiveMeshError::Parts);
    }
    let (mut lights, mut error) = (Vec::new(), 0.0_f64);
    for part in &parts {
        let part = Part::new(part).ok_or(EmissiveMeshError::Degenerate)?;
        let fit = part.fit(MOST / parts.len());
        error = error.max(fit.error);
        lights.extend(fit.lamps.iter().map(|lamp| part.light(lamp, radiance * fit.scale as f32)));
    }
    // Not a number is no fit either.
    if error > WORST || error.is_nan() {
        return Err(EmissiveMeshError::Shape(error as f32));
    }
    Ok(EmissiveMesh { lights, is_inside: true, error: error as f32 })
}

/// The triangles of each part of a mesh that no corner joins to another.
fn separate(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec<Triangle>> {
    let (corners, welded) = weld(positions);
    let mut roots: Vec<usize> = (0..corners.len()).collect();
    fn root(roots: &mut [usize], mut k: usize) -> usize {
        while roots[k] != k {
            roots[k] = roots[roots[k]];
            k = roots[k];
        }
        k
    }
    for t in triangles {
        let [a, b, c] = t.map(|i| root(&mut roots, welded[i as usize] as usize));
        let first = a.min(b).min(c);
        [a, b, c].into_iter().for_each(|k| roots[k] = first);
    }
    let mut parts: Vec<Vec<Triangle>> = Vec::new();
    let mut numbers = vec![usize::MAX; corners.len()];
    for t in triangles {
        let at = t.map(|i| corners[welded[i as usize] as usize].as_dvec3());
        if area(&at) == 0.0 {
            continue;
        }
        let number = &mut numbers[root(&mut roots, welded[t[0] as usize] as usize)];
        if *number == usize::MAX {
            *number = parts.len();
            parts.push(Vec::new());
        }
        parts[*number].push(at);
    }
    parts
}

/// Directions all around, evenly.
fn directions() -> impl Iterator<Item = DVec3> {
    (0..DIRECTIONS).map(|k| {
        let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (k as f64 * PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(r * cos, r * sin, z)
    })
}

/// Lights for a part.
struct Fit {
    lamps: Vec<Lamp>,
    /// Multiplies their radiance.
    scale: f64,
    /// The mean error of irradiance.
    error: f64,
    /// How much of what is seen is elsewhere.
    difference: f64,
}

/// A part of a mesh, about its middle and of radius 1.
struct Part {
    triangles: Vec<Triangle>,
    center: DVec3,
    radius: f64,
    /// Receivers around it, their irradiance and their view.
    truth: Vec<(Receiver, f64, Picture)>,
}

impl Part {
    fn new(triangles: &[Triangle]) -> Option<Self> {
        let (center, _) = moments(triangles.iter());
        let radius = bounds(triangles.iter(), center);
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let triangles: Vec<Triangle> = triangles.iter().map(|t| t.map(|p| (p - center) / radius)).collect();
        let receivers = DISTANCES.into_iter().flat_map(|distance| directions().map(move |v| (v, distance)));
        let truth = receivers
            .map(|(v, distance)| {
                let normal = -v.as_vec3().normalize();
                let position = (v * distance).as_vec3();
                let at = Receiver::on_surface(position, normal, normal);
                let picture = Picture::new(triangles.iter(), DVec3::ZERO, 1.0, v, distance);
                (at, picture.irradiance(), picture)
            })
            .collect();
        Some(Self { triangles, center, radius, truth })
    }

    /// The fewest lights that are good enough, or the best.
    fn fit(&self, most: usize) -> Fit {
        let all: Vec<&Triangle> = self.triangles.iter().collect();
        let mut best = self.measured(vec![self.sphere()]);
        let mut pieces = Vec::new();
        for count in COUNTS.into_iter().take_while(|count| *count <= most) {
            if best.difference <= GOOD {
                break;
            }
            let tries = if count == 1 {
                vec![vec![capsule(&all)], vec![part_of_ring(&all)]]
            } else {
                if pieces.is_empty() {
                    self.triangles.iter().for_each(|t| divide(t, &mut pieces));
                }
                vec![clusters(&pieces, count).iter().map(|cluster| part_of_ring(cluster)).collect()]
            };
            for lamps in tries {
                let fit = self.measured(lamps);
                if fit.difference < best.difference {
                    best = fit;
                }
            }
        }
        best
    }

    /// Of the area that it shows to the far receivers.
    fn sphere(&self) -> Lamp {
        let far = &self.truth[DIRECTIONS..];
        let mean = far.iter().map(|(_, irradiance, _)| irradiance).sum::<f64>() / far.len() as f64;
        Lamp { ends: [DVec3::ZERO; 2], radius: mean.sqrt() * DISTANCES[1] }
    }

    /// Lights with the radiance that suits the far receivers, and how near to the truth they are.
    fn measured(&self, lamps: Vec<Lamp>) -> Fit {
        let lights: Vec<Light> = lamps.iter().map(|lamp| lamp.light(DVec3::ZERO, 1.0, Vec3::ONE)).collect();
        let got: Vec<f64> = self.truth.iter().map(|(at, ..)| lights.iter().map(|l| irradiance(l, at)).sum()).collect();
        let truth: f64 = self.truth[DIRECTIONS..].iter().map(|(_, truth, _)| truth).sum();
        let scale = truth / got[DIRECTIONS..].iter().sum::<f64>();
        let off = got.iter().zip(&self.truth).map(|(got, (_, truth, _))| (scale * got / truth - 1.0).abs());
        let error = off.sum::<f64>() / got.len() as f64;
        let [mut off, mut all] = [0.0; 2];
        for (_, _, picture) in &self.truth {
            let [here, whole] = picture.difference(&lamps);
            (off, all) = (off + here, all + whole);
        }
        let finite = |x: f64| if x.is_finite() { x } else { f64::INFINITY };
        Fit { lamps, scale, error: finite(error), difference: finite(off / all) }
    }

    fn light(&self, lamp: &Lamp, radiance: Vec3) -> Light {
        lamp.light(self.center, self.radius, radiance)
    }
}

/// Irradiance of a light of radiance 1 over π.
fn irradiance(light: &Light, at: &Receiver) -> f64 {
    let (term, lobe) = (light.seen_from(at), Lobe::new(at.normal, 1.0, Vec3::ONE));
    f64::from(match &term.outline {
        Some(outline) => outline_integral(at, lobe, outline),
        None => cap_integral(at, lobe, &term.cone),
    })
}

/// Pieces of a triangle that are short enough.
fn divide(t: &Triangle, out: &mut Vec<Triangle>) {
    let [a, b, c] = *t;
    let sides = [a.distance(b), b.distance(c), c.distance(a)];
    let longest = sides.into_iter().fold(0.0, f64::max);
    if longest <= PIECE {
        out.push(*t);
        return;
    }
    let [p, q, r] = if sides[0] == longest {
        [a, b, c]
    } else if sides[1] == longest {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let middle = 0.5 * (p + q);
    divide(&[p, middle, r], out);
    divide(&[middle, q, r], out);
}

/// Pieces in so many groups of what is near to each other (S. Lloyd, *Least squares quantization in PCM*, 1982), from middles that
/// are as far from each other as they can be.
fn clusters(pieces: &[Triangle], count: usize) -> Vec<Vec<&Triangle>> {
    let places: Vec<(DVec3, f64)> = pieces.iter().map(|t| (t.iter().sum::<DVec3>() / 3.0, area(t))).collect();
    let nearest = |centers: &[DVec3], p: DVec3| {
        let distances = centers.iter().map(|c| c.distance_squared(p));
        distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    };
    let mut centers = Vec::new();
    for k in 0..count {
        let far = |p: DVec3| if k == 0 { p.length_squared() } else { nearest(&centers, p).1 };
        let next = places.iter().map(|(p, _)| (*p, far(*p))).max_by(|a, b| a.1.total_cmp(&b.1));
        centers.extend(next.map(|(p, _)| p));
    }
    for _ in 0..16 {
        let mut sums = vec![(DVec3::ZERO, 0.0); centers.len()];
        for (p, area) in &places {
            let (sum, all) = &mut sums[nearest(&centers, *p).0];
            *sum += *p * *area;
            *all += area;
        }
        for (center, (sum, all)) in centers.iter_mut().zip(sums) {
            if all > 0.0 {
                *center = sum / all;
            }
        }
    }
    let mut groups = vec![Vec::new(); centers.len()];
    for (piece, (p, _)) in pieces.iter().zip(&places) {
        groups[nearest(&centers, *p).0].push(piece);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A surface over two angles, closed in both: `at` of two numbers in [0, 1).
    fn surface(n: [u32; 2], is_ring: bool, at: impl Fn(f32, f32) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let rows = if is_ring { n[1] } else { n[1] + 1 };
        let place = |k: u32| at((k % n[0]) as f32 / n[0] as f32, (k / n[0]) as f32 / n[1] as f32);
        let positions = (0..n[0] * rows).map(place).collect();
        let corner = |i: u32, j: u32| (j % rows) * n[0] + i % n[0];
        let quad = |k: u32| {
            let (i, j) = (k % n[0], k / n[0]);
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (positions, (0..n[0] * n[1]).flat_map(quad).collect())
    }

    fn around(angle: f32) -> Vec3 {
        let (sin, cos) = (core::f32::consts::TAU * angle).sin_cos();
        Vec3::new(cos, sin, 0.0)
    }

    /// A tube of radius 0.2 between two half spheres, as long as is said.
    fn pill(length: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        surface([32, 32], false, |u, v| {
            let (sin, cos) = (core::f32::consts::PI * v).sin_cos();
            let end = if v < 0.5 { 0.5 } else { -0.5 } * length;
            around(u) * (0.2 * sin) + Vec3::Z * (end + 0.2 * cos)
        })
    }

    fn torus(thin: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        surface([16, 64], true, |u, v| {
            let out = around(v);
            let (sin, cos) = (core::f32::consts::TAU * u).sin_cos();
            out * (1.0 + thin * cos) + Vec3::Z * (thin * sin)
        })
    }

    fn lamp((positions, triangles): &(Vec<Vec3>, Vec<[u32; 3]>)) -> EmissiveMesh {
        emissive_mesh(positions, triangles, Vec3::splat(2.0)).expect("lights")
    }

    #[test]
    fn spheres_and_tubes_are_found() {
        let sphere = lamp(&surface([48, 24], false, |u, v| {
            let (sin, cos) = (core::f32::consts::PI * v).sin_cos();
            Vec3::new(3.0, 0.0, 0.0) + (around(u) * sin + Vec3::Z * cos) * 0.5
        }));
        println!("{sphere:?}");
        let [Light::Sphere(light)] = sphere.lights[..] else { panic!("{sphere:?}") };
        assert!((light.sphere.radius - 0.5).abs() < 0.005 && light.sphere.center.distance(Vec3::X * 3.0) < 1e-3);
        assert!((light.radiance.x - 2.0).abs() < 0.01 && sphere.error < 0.003);
        let pill = lamp(&pill(2.0));
        println!("{pill:?}");
        let [Light::Tube(tube)] = pill.lights[..] else { panic!("{pill:?}") };
        assert!((tube.radius - 0.2).abs() < 0.003 && (tube.ends[0].distance(tube.ends[1]) - 2.0).abs() < 0.03);
        assert!(pill.error < 0.005 && pill.is_inside);
    }

    #[test]
    fn rings_are_several_tubes() {
        // Seen from the side its near half hides the far one, of tubes none.
        for (thin, limit) in [(0.05, 0.06), (0.2, 0.14), (0.4, 0.2)] {
            let ring = lamp(&torus(thin));
            println!("ring {thin}: {} lights, {}", ring.lights.len(), ring.error);
            assert!(ring.lights.len() > 2 && ring.error < limit, "{thin}: {}", ring.error);
        }
    }

    /// Two bulbs of a mesh are two spheres.
    #[test]
    fn parts_are_lights_of_their_own() {
        let sphere = |x: f32| {
            surface([24, 12], false, move |u, v| {
                let (sin, cos) = (core::f32::consts::PI * v).sin_cos();
                Vec3::X * x + (around(u) * sin + Vec3::Z * cos) * 0.1
            })
        };
        let (mut positions, mut triangles) = sphere(0.0);
        let first = positions.len() as u32;
        let (others, more) = sphere(1.0);
        positions.extend(others);
        triangles.extend(more.iter().map(|t| t.map(|i| i + first)));
        let lamp = lamp(&(positions, triangles));
        assert_eq!(lamp.lights.iter().map(Light::name).collect::<Vec<_>>(), ["sphere", "sphere"]);
    }

    /// Its lights grow and move with a mesh.
    #[test]
    fn size_and_place_do_not_matter() {
        let (positions, triangles) = pill(1.0);
        let whole = lamp(&(positions.clone(), triangles.clone()));
        for scale in [1e-6_f32, 1e6] {
            let other = lamp(&(positions.iter().map(|p| *p * scale + Vec3::Y * scale).collect(), triangles.clone()));
            assert_eq!(other.lights.len(), whole.lights.len());
            for (a, b) in whole.lights.iter().zip(&other.lights) {
                let moved = (a.bounds().center + Vec3::Y) * scale;
                assert!(moved.distance(b.bounds().center) < 1e-3 * scale, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn flat_faces_stay_what_they_are() {
        let quad = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let lamp = emissive_mesh(&quad, &[[0, 1, 2], [0, 2, 3]], Vec3::ONE).expect("a rectangle");
        assert!(lamp.lights.len() == 1 && !lamp.is_inside && lamp.error == 0.0);
        assert_eq!(emissive_mesh(&[], &[], Vec3::ONE), Err(EmissiveMeshError::Degenerate));
        let (positions, triangles) = torus(0.1);
        let many: Vec<Vec3> =
            (0..25).flat_map(|k| positions.iter().map(move |p| *p + Vec3::Z * k as f32 * 3.0)).collect();
        let n = positions.len() as u32;
        let more: Vec<[u32; 3]> = (0..25).flat_map(|k| triangles.iter().map(move |t| t.map(|i| i + k * n))).collect();
        assert_eq!(emissive_mesh(&many, &more, Vec3::ONE), Err(EmissiveMeshError::Parts));
    }
}
