use core::ops::ControlFlow;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::error::BuildError;
use crate::options::Progress;
use crate::random::{Random, quasi_random};
use crate::solid::Solid;
use crate::surface::Surface;

/// Points that judge the volume outside the mesh.
const JUDGES: usize = 1 << 16;

const SWEEPS: usize = 60;

/// Sweeps between two divisions of the surface among the spheres.
const ROUND: usize = 4;

/// Places tried for a sphere in a sweep.
const TRIES: usize = 6;

/// Sides below which a piece of a triangle is given to a sphere that does not hold it, first and last, in units of D.
const PIECES: [f32; 2] = [8e-3, 1e-3];

/// Moves and resizes spheres (unit space) until every point of the surface is in one of them, with little volume outside
/// the mesh.
///
/// Each sphere owns a part of the surface, and its radius covers that part. A sphere moves where that lowers the volume
/// outside the mesh that it adds to the others'; every few sweeps, each piece of the surface goes to the sphere that it is
/// deepest in. Triangles are cut until each piece lies in one sphere, so that the cover holds all points.
pub(crate) fn bound(
    surface: &Surface,
    solid: &Solid,
    spheres: &mut Vec<Vec4>,
    random: &mut Random,
    progress: &mut Progress,
) -> Result<(), BuildError> {
    let judges = judges(surface, solid);
    let mut steps: Vec<f32> = spheres.iter().map(|sphere| 0.1 * sphere.w).collect();
    let mut shares = Vec::new();
    for sweep in 0..=SWEEPS {
        let done = sweep as f32 / SWEEPS as f32;
        if let ControlFlow::Break(()) = progress(done) {
            return Err(BuildError::Cancelled);
        }
        if sweep % ROUND == 0 {
            let piece = PIECES[0] * (PIECES[1] / PIECES[0]).powf((1.5 * done).min(1.0));
            shares = divide(surface, spheres, piece);
            for (sphere, share) in spheres.iter_mut().zip(&shares) {
                sphere.w = radius(share, sphere.truncate());
            }
        }
        for i in 0..spheres.len() {
            improve(spheres, i, &shares[i], &judges, &mut steps[i], random);
        }
    }
    spheres.retain(|sphere| sphere.w > 0.0);
    // Rounding, here and where the spheres are carried to the mesh's space.
    let far = surface.bounds.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    let slack = 1e-6 + 2.0 * f32::EPSILON * (f64::from(far) / surface.diagonal) as f32;
    for sphere in spheres {
        sphere.w += slack;
    }
    Ok(())
}

/// Moves sphere `i` to the best of a few places near it.
fn improve(spheres: &mut [Vec4], i: usize, share: &[Vec3], judges: &[Vec3], step: &mut f32, random: &mut Random) {
    let sphere = spheres[i];
    if share.is_empty() {
        return;
    }
    // No place is farther than √3 steps: points that much nearer are never the farthest, points that much farther never
    // inside.
    let slack = 1.74 * *step;
    let share: Vec<Vec3> =
        share.iter().copied().filter(|p| p.distance(sphere.truncate()) >= sphere.w - 2.0 * slack).collect();
    let reach = sphere.truncate().extend(sphere.w + 2.0 * slack);
    let near: Vec<Vec4> = (0..spheres.len())
        .filter(|j| *j != i)
        .map(|j| spheres[j])
        .filter(|other| other.truncate().distance(sphere.truncate()) < other.w + reach.w)
        .collect();
    let open = |p: &Vec3| inside(reach, *p) && !near.iter().any(|other| inside(*other, *p));
    let judges: Vec<Vec3> = judges.iter().copied().filter(open).collect();
    let mut best = (usize::MAX, sphere);
    for k in 0..=TRIES {
        let shift = Vec3::new(random.unit(), random.unit(), random.unit()) * 2.0 - 1.0;
        let center = if k == 0 { sphere.truncate() } else { sphere.truncate() + shift * *step };
        let place = center.extend(radius(&share, center));
        let cost = judges.iter().filter(|p| inside(place, **p)).count();
        if cost < best.0 || (cost == best.0 && place.w < best.1.w) {
            best = (cost, place);
        }
    }
    let moved = best.1 != sphere;
    *step = if moved { (*step * 1.3).min(0.3 * sphere.w) } else { *step * 0.85 }.max(2e-4);
    spheres[i] = best.1;
}

/// The radius that covers the points around a centre.
fn radius(share: &[Vec3], center: Vec3) -> f32 {
    share.iter().map(|p| p.distance_squared(center)).fold(0.0, f32::max).sqrt()
}

/// Cuts the triangles until each piece is in one sphere, or smaller than `piece`, and gives it to the sphere that it is
/// deepest in or nearest to. Returns the corners of each sphere's pieces.
fn divide(surface: &Surface, spheres: &[Vec4], piece: f32) -> Vec<Vec<Vec3>> {
    let owners: Vec<Vec<(usize, [Vec3; 3])>> = surface
        .triangles
        .par_iter()
        .map(|triangle| {
            let mut owners = Vec::new();
            let mut open = vec![*triangle];
            while let Some(part) = open.pop() {
                let (mut owner, mut least) = (0, f32::INFINITY);
                for (i, sphere) in spheres.iter().enumerate() {
                    let far = part.iter().map(|p| p.distance_squared(sphere.truncate())).fold(0.0, f32::max);
                    let gap = far.sqrt() - sphere.w;
                    if gap < least {
                        (owner, least) = (i, gap);
                    }
                }
                let [a, b, c] = part;
                if least <= 0.0 || a.distance(b).max(b.distance(c)).max(c.distance(a)) < piece {
                    owners.push((owner, part));
                } else {
                    let [d, e, f] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
                    open.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
                }
            }
            owners
        })
        .collect();
    let mut shares = vec![Vec::new(); spheres.len()];
    for (owner, part) in owners.into_iter().flatten() {
        shares[owner].extend(part);
    }
    shares
}

fn inside(sphere: Vec4, p: Vec3) -> bool {
    p.distance_squared(sphere.truncate()) <= sphere.w * sphere.w
}

/// Points outside the mesh, in a box somewhat larger than its own.
fn judges(surface: &Surface, solid: &Solid) -> Vec<Vec3> {
    let [lo, hi] = surface.unit_bounds();
    let room = Vec3::splat(0.06);
    let all = (0..JUDGES).map(|i| lo - room + quasi_random(i) * (hi - lo + 2.0 * room));
    all.filter(|p| solid.depth_near(*p) < 0.0).collect()
}
