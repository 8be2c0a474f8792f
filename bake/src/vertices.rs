//! Light at vertices.

use crate::BakeError;
use crate::light::Irradiance;
use crate::mixing::{self, Spot};
use crate::steps::{Steps, step};
use crate::target::Face;
use core::ops::ControlFlow;
use glam::{DVec3, Vec3};
use lobe_core::Receiver;
use renderer::{RenderError, Renderer};
use scene_files::GltfPart;

/// How far from a corner its light is taken, as a part of the way to the triangle's middle: on the corner itself a wall may stand.
pub(crate) const INSIDE: f64 = 0.02;

/// The irradiance of a part's vertices: the mean over the triangles around each, by their angles there.
///
/// Vertices of triangles without an area, and those that lie inside of bodies alone, have none.
pub(crate) fn vertices(part: &GltfPart, light: &Irradiance, renderer: &mut Renderer) -> Result<Vec<Vec3>, BakeError> {
    let mesh = &part.geometry;
    let (mut receivers, mut corners) = (Vec::new(), Vec::new());
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let Some(face) = Face::new(part, number) else { continue };
        for (k, angle) in face.angles().into_iter().enumerate() {
            let weight = |corner: usize| if corner == k { 1.0 - INSIDE * 2.0 / 3.0 } else { INSIDE / 3.0 };
            let at = face.receiver([weight(1), weight(2)]);
            receivers.push(Spot { at, weight: angle, is_back: part.is_back });
            corners.push(triangle[k] as usize);
        }
    }
    let points: Vec<Receiver> = receivers.iter().map(|spot| spot.at).collect();
    let values = light.of(renderer, &points)?.swap_remove(0);
    let ends: Vec<usize> = (1..=points.len()).collect();
    let kept = mixing::weights(renderer, &receivers, &values, &ends);
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.positions.len()];
    for ((corner, value), weights) in corners.iter().zip(&values).zip(kept) {
        if let Some(weight) = weights.and_then(|weights| weights.first().copied()) {
            let (sum, all) = &mut sums[*corner];
            *sum += value.as_dvec3() * weight;
            *all += weight;
        }
    }
    Ok(sums.into_iter().map(|(sum, all)| if all > 0.0 { (sum / all).as_vec3() } else { Vec3::ZERO }).collect())
}

/// The irradiance of all vertices, part by part.
pub(crate) fn all(
    parts: &[&GltfPart],
    light: &Irradiance,
    renderer: &mut Renderer,
    steps: &mut dyn Steps,
    heard: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<Vec<Vec<Vec3>>, BakeError> {
    let mut done = Vec::new();
    for part in parts {
        done.push(step(steps, || vertices(part, light, renderer))?);
        if heard(done.len() as f32 / parts.len() as f32).is_break() {
            return Err(RenderError::Cancelled.into());
        }
    }
    Ok(done)
}
