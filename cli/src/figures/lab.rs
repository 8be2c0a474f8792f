//! Pictures of a scene: by lobes, and by Monte Carlo.

use super::canvas::Cell;
use super::measure::{DEPTH, How, TOLERANCE, frames};
use crate::failure::Failure;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Geometry, Reference, ReferenceJob};
use cosine_lobes::scene::{BlockerSet, Scene};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::{Picture, srgb_bytes};
use glam::Vec3;
use std::sync::atomic::AtomicBool;

/// Rays a pixel of pictures that are only to be looked at.
pub(super) const SMOOTH: u32 = 4;

/// The settings of all figures.
pub(super) const fn accuracy() -> Accuracy {
    Accuracy { tolerance: TOLERANCE, depth: DEPTH }
}

/// One value a point as a picture.
pub(super) fn resolve(gbuffer: &GBuffer, values: &[Vec3]) -> Picture {
    Picture::new(gbuffer.width as usize, gbuffer.height as usize, gbuffer.resolve(values, Vec3::ZERO))
}

/// The picture of visible points.
pub(super) fn shade(scene: &Scene, blockers: &BlockerSet, gbuffer: &GBuffer, how: How<'_>) -> Result<Picture, Failure> {
    let (_, radiance) = frames(scene, blockers, &gbuffer.points, how, 1).map_err(Failure::new)?;
    Ok(resolve(gbuffer, &radiance))
}

/// The same with this number of samples a point.
pub(super) fn reference(
    scene: &Scene,
    blockers: &BlockerSet,
    gbuffer: &GBuffer,
    geometry: Geometry<'_>,
    samples: u32,
) -> Picture {
    let world = World::new(scene);
    let mut reference = Reference::new(ReferenceJob { world: &world, gbuffer, blockers, geometry, seed: 1 });
    reference.advance(samples, &AtomicBool::new(false), &|_| {});
    resolve(gbuffer, &reference.estimate().radiance)
}

/// A picture with two lines above it.
pub(super) fn cell(title: impl Into<String>, note: impl Into<String>, picture: &Picture, exposure: f32) -> Cell {
    let (size, rgb) = ((picture.width(), picture.height()), srgb_bytes(picture, exposure));
    Cell { title: title.into(), note: note.into(), size, rgb }
}

/// The part of `a` above `b`, with `full` white.
pub(super) fn above(a: &Picture, b: &Picture, full: f32) -> Vec<u8> {
    let gain =
        |(a, b): (&Vec3, &Vec3)| ((*a - *b).max(Vec3::ZERO) * (255.0 / full)).to_array().map(|c| c.min(255.0) as u8);
    a.pixels().iter().zip(b.pixels()).flat_map(gain).collect()
}
