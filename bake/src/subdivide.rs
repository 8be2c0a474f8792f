//! Triangles that are divided where light changes faster than between their vertices.

use crate::BakeError;
use crate::division::{Blend, Division, Edges, Marks, Piece};
use crate::light::Irradiance;
use crate::mixing::{self, Spot};
use crate::steps::{PointLights, Steps, step};
use crate::target::Face;
use crate::vertices::INSIDE;
use core::ops::ControlFlow;
use glam::{DVec3, Vec3};
use lobe_core::Receiver;
use renderer::{RenderError, Renderer};
use scene_files::GltfPart;

/// Points along an edge of a piece: at least its ends and its middle, and one for each 64th of the whole, so that no shadow of that size
/// is missed.
const LEAST: u32 = 2;
const ALONG: f64 = 64.0;

/// The shortest edge that is divided, as a part of the whole, where no density is requested.
const FINEST: f64 = 1.0 / 512.0;

/// Pieces are divided together whose difference over their area is at least this part of the largest.
const NEAR: f64 = 0.25;

/// Points that are lit at once.
const POINTS: usize = 1 << 19;

/// A requested subdivision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Request {
    /// The largest difference between interpolated and true light, as a part of the mean light.
    pub(crate) error: f32,
    /// The most vertices.
    pub(crate) most: usize,
    /// Edges a unit of length, at most.
    pub(crate) density: Option<f32>,
}

/// How near the light of a subdivision is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Subdivision {
    /// Triangles, after it.
    pub triangles: u64,
    /// The mean difference of interpolated and true light over all surfaces, as a part of the mean light.
    pub mean_error: f64,
    /// The part of all surfaces on which the difference exceeds the request: on edges as short as are divided, or where it ended early.
    pub beyond: f64,
    /// Whether it ended at the most vertices that are taken.
    pub is_cut: bool,
}

/// A surface as it was divided.
pub(crate) struct Divided {
    /// Its vertices, and its triangles; `None` where it is as it was.
    pub(crate) mesh: Option<(Vec<Blend>, Vec<[u32; 3]>)>,
    /// The irradiance of its vertices.
    pub(crate) light: Vec<Vec3>,
}

/// The light of a piece.
#[derive(Clone, Debug, Default)]
struct PieceLight {
    /// At its corners, with their weights: angles, or 0 inside of bodies.
    corners: [(Vec3, f64); 3],
    /// The light of its points; `None` for those inside of bodies.
    points: Vec<Option<Vec3>>,
    /// Of its surface, in square units.
    area: f64,
    /// The largest and the mean difference of its points.
    error: [f64; 2],
    /// The points are tested, and their light is gone.
    is_tested: bool,
}

/// The weights of the corners at the points of a piece: all places of a grid of `n` steps a side but the corners, moved inward as the
/// corners are.
fn points(n: u32) -> impl Iterator<Item = [f64; 3]> {
    let all = (0..=n).flat_map(move |i| (0..=n - i).map(move |j| [n - i - j, i, j]));
    let inside = move |k: [u32; 3]| k.map(|k| f64::from(k) / f64::from(n) * (1.0 - INSIDE) + INSIDE / 3.0);
    all.filter(move |k| !k.contains(&n)).map(inside)
}

/// Where a corner's light is taken.
fn corner(k: usize) -> [f64; 3] {
    [0, 1, 2].map(|j| if j == k { 1.0 - INSIDE * 2.0 / 3.0 } else { INSIDE / 3.0 })
}

/// All surfaces while they are divided.
struct Surfaces<'a> {
    parts: &'a [&'a GltfPart],
    edges: Edges,
    divisions: Vec<Division<'a>>,
    lit: Vec<Vec<PieceLight>>,
    /// Between points, at most.
    step: f64,
}

impl<'a> Surfaces<'a> {
    fn new(parts: &'a [&'a GltfPart], density: Option<f32>) -> Self {
        let places = parts.iter().flat_map(|part| &part.geometry.positions);
        let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = places.fold(none, |[low, high], p| [low.min(*p), high.max(*p)]);
        let whole = f64::from((high - low).max_element().max(0.0));
        let mut edges = Edges::new(density.map_or(whole * FINEST, |density| 1.0 / f64::from(density)));
        let divisions: Vec<Division<'a>> = parts.iter().map(|part| Division::new(part, &mut edges)).collect();
        let lit = divisions.iter().map(|division| vec![PieceLight::default(); division.pieces.len()]).collect();
        Self { parts, edges, divisions, lit, step: whole / ALONG }
    }

    fn steps(&self, piece: &Piece) -> u32 {
        let steps = (self.edges.size(piece) / self.step).ceil();
        if steps.is_finite() { (steps as u32).clamp(LEAST, ALONG as u32) } else { LEAST }
    }

    /// Lights all pieces that have no light yet.
    fn light(&mut self, lamp: &mut Lamp<'_>) -> Result<(), BakeError> {
        let mut batch = Batch::default();
        for (number, part) in self.parts.iter().enumerate() {
            for place in 0..self.divisions[number].pieces.len() {
                let piece = self.divisions[number].pieces[place];
                let lit = &self.lit[number][place];
                if lit.is_tested || !lit.points.is_empty() {
                    continue;
                }
                let Some(face) = Face::new(part, piece.whole as usize) else {
                    self.lit[number][place].is_tested = true;
                    continue;
                };
                let steps = self.steps(&piece);
                batch.add(&face, &piece, steps, ((number, place), part.is_back));
                if batch.receivers.len() >= POINTS {
                    self.take(&mut batch, lamp)?;
                }
            }
        }
        self.take(&mut batch, lamp)
    }

    fn take(&mut self, batch: &mut Batch, lamp: &mut Lamp<'_>) -> Result<(), BakeError> {
        let Batch { receivers, owners } = core::mem::take(batch);
        if receivers.is_empty() {
            return Ok(());
        }
        let PointLights { values, weights } = lamp.shine(&receivers)?;
        let mut first = 0;
        for ((number, place), count, area) in owners {
            let lit = &mut self.lit[number][place];
            lit.corners = [0, 1, 2].map(|k| (values[first + k], weights[first + k].max(0.0)));
            lit.points = (first + 3..first + count).map(|k| (weights[k] >= 0.0).then(|| values[k])).collect();
            lit.area = area;
            first += count;
        }
        Ok(())
    }

    /// The mean light of all points, of the brightest channel.
    fn mean(&self) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for lit in self.lit.iter().flatten() {
            let known: Vec<f64> = lit.points.iter().flatten().map(|value| f64::from(value.max_element())).collect();
            if !known.is_empty() {
                sum += lit.area * known.iter().sum::<f64>() / known.len() as f64;
                area += lit.area;
            }
        }
        if area > 0.0 { sum / area } else { 0.0 }
    }

    /// The irradiance of the vertices: means over the pieces around each, by their angles.
    fn vertices(&self, number: usize) -> Vec<Vec3> {
        let division = &self.divisions[number];
        let mut sums = vec![(DVec3::ZERO, 0.0); division.vertices.len()];
        for (piece, lit) in division.pieces.iter().zip(&self.lit[number]) {
            for (vertex, (value, weight)) in piece.corners.iter().zip(lit.corners) {
                let (sum, all) = &mut sums[*vertex as usize];
                *sum += value.as_dvec3() * weight;
                *all += weight;
            }
        }
        sums.into_iter().map(|(sum, all)| if all > 0.0 { (sum / all).as_vec3() } else { Vec3::ZERO }).collect()
    }

    /// Compares the interpolated light of all pieces that are not tested yet with that of their points.
    fn test(&mut self) {
        for number in 0..self.divisions.len() {
            let light = self.vertices(number);
            for place in 0..self.divisions[number].pieces.len() {
                let piece = self.divisions[number].pieces[place];
                let steps = self.steps(&piece);
                let lit = &mut self.lit[number][place];
                if lit.is_tested {
                    continue;
                }
                let values = piece.corners.map(|vertex| light[vertex as usize].as_dvec3());
                let (mut most, mut sum, mut count) = (0.0_f64, 0.0, 0);
                for (weights, value) in points(steps).zip(&lit.points) {
                    let Some(value) = value else { continue };
                    let shown: DVec3 = values.iter().zip(weights).map(|(value, weight)| *value * weight).sum();
                    let apart = (shown - value.as_dvec3()).abs().max_element();
                    most = most.max(apart);
                    sum += apart;
                    count += 1;
                }
                lit.error = [most, sum / f64::from(count.max(1))];
                lit.points = Vec::new();
                lit.is_tested = true;
            }
        }
    }

    /// The edges to be divided next where pieces differ by more than `most`: those of the pieces whose differences over their areas come near
    /// to the largest, as far as there is room for new vertices. So a subdivision that ends early is as good as that many vertices are. Says
    /// whether the room left some out.
    fn marks(&self, most: f64, room: usize) -> (Marks, bool) {
        let all = || self.divisions.iter().flat_map(|division| &division.pieces);
        let score = |piece: &Piece, lit: &PieceLight| {
            let is_open = lit.error[0] > most && self.edges.size(piece) > 0.0;
            if is_open { lit.error[0] * lit.area } else { 0.0 }
        };
        let scores: Vec<f64> = all().zip(self.lit.iter().flatten()).map(|(piece, lit)| score(piece, lit)).collect();
        let top = scores.iter().copied().fold(0.0, f64::max);
        let with = |least: f64| {
            let chosen = all().zip(&scores).filter(|(_, score)| **score > 0.0 && **score >= least);
            let marks = Marks::new(&self.edges, chosen.map(|(piece, _)| piece), &all());
            let new: usize = self.divisions.iter().map(|division| division.new_vertices(&marks)).sum();
            (marks, new)
        };
        let (marks, new) = with(NEAR * top);
        if new <= room {
            return (marks, false);
        }
        let (mut low, mut high) = (NEAR * top, f64::INFINITY);
        let mut found = with(high).0;
        for step in 0..24 {
            let middle = if step == 0 { top } else { 0.5 * (low + high) };
            let (marks, new) = with(middle);
            if new > room {
                low = middle;
            } else {
                (found, high) = (marks, middle);
            }
            if low >= top {
                break;
            }
        }
        (found, true)
    }

    fn divide(&mut self, marks: &Marks) {
        for (division, lit) in self.divisions.iter_mut().zip(&mut self.lit) {
            let before = core::mem::take(lit);
            division.divide(&mut self.edges, marks, |place, is_same| {
                lit.push(if is_same { before[place].clone() } else { PieceLight::default() });
            });
        }
    }

    fn count(&self) -> usize {
        self.divisions.iter().map(|division| division.vertices.len()).sum()
    }

    fn summary(&self, mean: f64, most: f64, is_cut: bool) -> Subdivision {
        let (mut area, mut error, mut beyond) = (0.0, 0.0, 0.0);
        for lit in self.lit.iter().flatten() {
            area += lit.area;
            error += lit.area * lit.error[1];
            beyond += if lit.error[0] > most { lit.area } else { 0.0 };
        }
        let part = |x: f64, whole: f64| if whole > 0.0 { x / whole } else { 0.0 };
        let triangles = self.divisions.iter().map(|division| division.pieces.len() as u64).sum();
        Subdivision { triangles, mean_error: part(error, area * mean), beyond: part(beyond, area), is_cut }
    }
}

/// Lights points, or takes up their light.
pub(crate) struct Lamp<'a> {
    pub(crate) light: &'a Irradiance,
    pub(crate) renderer: &'a mut Renderer,
    pub(crate) steps: &'a mut dyn Steps,
}

impl Lamp<'_> {
    fn shine(&mut self, receivers: &[Spot]) -> Result<PointLights, BakeError> {
        let made = step(self.steps, || {
            let points: Vec<Receiver> = receivers.iter().map(|spot| spot.at).collect();
            let values = self.light.of(self.renderer, &points)?.swap_remove(0);
            let ends: Vec<usize> = (1..=receivers.len()).collect();
            let kept = mixing::weights(self.renderer, receivers, &values, &ends);
            let weight =
                |weights: Option<Vec<f64>>| weights.and_then(|weights| weights.first().copied()).unwrap_or(-1.0);
            Ok(PointLights { values, weights: kept.into_iter().map(weight).collect() })
        })?;
        let is_whole = made.values.len() == receivers.len() && made.weights.len() == receivers.len();
        is_whole.then_some(made).ok_or_else(|| BakeError::Steps("light of another number of points".to_owned()))
    }
}

/// Points to be lit.
#[derive(Default)]
struct Batch {
    receivers: Vec<Spot>,
    /// Of each piece its place, its number of points, and its area.
    owners: Vec<((usize, usize), usize, f64)>,
}

impl Batch {
    fn add(&mut self, face: &Face<'_>, piece: &Piece, steps: u32, (owner, is_back): ((usize, usize), bool)) {
        let first = self.receivers.len();
        let at = |weights: [f64; 3]| {
            [0, 1].map(|axis| piece.at.iter().zip(weights).map(|(at, weight)| at[axis] * weight).sum::<f64>())
        };
        let (angles, area) = face.angles_of(piece.at);
        let corners = angles.into_iter().enumerate().map(|(k, angle)| (corner(k), angle));
        for (weights, own) in corners.chain(points(steps).map(|weights| (weights, 1.0))) {
            self.receivers.push(Spot { at: face.receiver(at(weights)), weight: own, is_back });
        }
        self.owners.push((owner, self.receivers.len() - first, area));
    }
}

/// Divides the triangles of parts until the light between their vertices is near enough, and lights their vertices.
pub(crate) fn all(
    parts: &[&GltfPart],
    request: Request,
    mut lamp: Lamp<'_>,
    heard: &mut dyn FnMut(f32) -> ControlFlow<()>,
) -> Result<(Vec<Divided>, Subdivision), BakeError> {
    let mut surfaces = Surfaces::new(parts, request.density);
    let mut mean = 0.0;
    let mut is_cut = false;
    for round in 0.. {
        surfaces.light(&mut lamp)?;
        if round == 0 {
            mean = surfaces.mean();
        }
        surfaces.test();
        let most = f64::from(request.error) * mean;
        let (marks, cut) = surfaces.marks(most, request.most.saturating_sub(surfaces.count()));
        is_cut = cut;
        if marks.is_empty() {
            break;
        }
        surfaces.divide(&marks);
        // Each round divides edges once more. Their number is not known before.
        if heard(1.0 - 0.85_f32.powi(round + 1)).is_break() {
            return Err(RenderError::Cancelled.into());
        }
    }
    let summary = surfaces.summary(mean, f64::from(request.error) * mean, is_cut);
    let light: Vec<Vec<Vec3>> = (0..parts.len()).map(|number| surfaces.vertices(number)).collect();
    let divided = surfaces.divisions.into_iter().zip(light).map(|(division, light)| {
        let is_divided = division.is_divided();
        let triangles = division.pieces.iter().map(|piece| piece.corners).collect();
        Divided { mesh: is_divided.then_some((division.vertices, triangles)), light }
    });
    Ok((divided.collect(), summary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_inside_and_even() {
        for n in [2, 3, 7] {
            let all: Vec<[f64; 3]> = points(n).collect();
            assert_eq!(all.len() as u32, (n + 1) * (n + 2) / 2 - 3);
            let sums = [0, 1, 2].map(|k| all.iter().map(|weights| weights[k]).sum::<f64>() / all.len() as f64);
            assert!(sums.iter().all(|mean| (mean - 1.0 / 3.0).abs() < 1e-12));
            assert!(all.iter().flatten().all(|weight| *weight > 0.0));
        }
    }
}
