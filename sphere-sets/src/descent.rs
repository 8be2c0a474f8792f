use crate::BuildError;
use core::f32::consts::TAU;

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::blurred_difference::BlurredDifference;
use crate::goal::Goal;
use crate::random::{Random, fibonacci};
use crate::solid::Solid;
use crate::view::View;

/// Points on the boundary of each projected disc.
const POINTS: usize = 48;

/// Views a step.
const BATCH: usize = 16;

/// Smallest radius, in units of D.
const LEAST_RADIUS: f32 = 1e-3;

/// Points on each sphere that feel the mesh's surface.
const BULGE_POINTS: usize = 64;

/// Height above the surface from which a bulge counts fully, in units of D.
const BULGE_HEIGHT: f32 = 0.01;

/// Moves and resizes spheres (centre, radius; unit space) so that their silhouettes follow the mesh's.
///
/// The gradient of the first part of the [`Goal`] is an integral over the exposed boundary of the set's silhouette: a
/// piece ds that moves outward by δ adds ±δ ds, + outside the mesh's silhouette and − inside. Steps are Adam's
/// (D. Kingma, J. Ba, *Adam: A Method for Stochastic Optimization*, ICLR 2015) on a few random views at a time; `rates`
/// are the lengths of the first and the last step. `before_each` step may end it with an error.
pub(crate) fn descend(
    goal: &Goal<'_>,
    spheres: &mut [Vec4],
    steps: usize,
    rates: [f32; 2],
    random: &mut Random,
    before_each: &mut dyn FnMut() -> Result<(), BuildError>,
) -> Result<(), BuildError> {
    const MEMORY: [f32; 2] = [0.9, 0.98];
    let views = goal.views;
    let sphere: [Vec3; BULGE_POINTS] = core::array::from_fn(|k| fibonacci(k, BULGE_POINTS));
    let batch = BATCH.min(views.len());
    let mut order: Vec<usize> = (0..views.len()).collect();
    let mut next = order.len();
    let mut partial: Vec<Gradient> = (0..batch).map(|_| Gradient::new(spheres.len(), views[0].size)).collect();
    let mut moments = vec![[Vec4::ZERO; 2]; spheres.len()];
    let mut decay = [1.0_f32; 2];
    for step in 0..steps {
        before_each()?;
        if next + batch > order.len() {
            random.shuffle(&mut order);
            next = 0;
        }
        let chosen = &order[next..next + batch];
        next += batch;
        let turn = random.unit() * TAU;
        let current = &*spheres;
        partial
            .par_iter_mut()
            .zip(chosen)
            .for_each(|(partial, &i)| partial.compute(&views[i], goal.soft, current, turn));

        // The silhouettes' gradient is a sum over the batch.
        let weight = goal.bulge * batch as f32;
        let bulges: Vec<Vec4> = (0..current.len())
            .into_par_iter()
            .with_min_len(8)
            .map(|i| bulging(current, i, goal.solid, &sphere) * weight)
            .collect();

        let progress = step as f32 / steps.max(2).saturating_sub(1) as f32;
        let rate = rates[0] * (rates[1] / rates[0]).powf(progress);
        decay = [decay[0] * MEMORY[0], decay[1] * MEMORY[1]];
        for (i, (sphere, [mean, square])) in spheres.iter_mut().zip(moments.iter_mut().map(|[a, b]| [a, b])).enumerate()
        {
            let gradient = partial.iter().map(|p| p.sums[i]).sum::<Vec4>() + bulges[i];
            *mean = *mean * MEMORY[0] + gradient * (1.0 - MEMORY[0]);
            *square = *square * MEMORY[1] + gradient * gradient * (1.0 - MEMORY[1]);
            let width = (*square / (1.0 - decay[1])).map(f32::sqrt) + 1e-6;
            *sphere -= *mean / (1.0 - decay[0]) / width * rate;
            sphere.w = sphere.w.max(LEAST_RADIUS);
        }
    }
    Ok(())
}

/// One view's part of the gradient, with the buffers for computing it.
struct Gradient {
    sums: Vec<Vec4>,
    discs: Vec<(Vec2, f32)>,
    near: Vec<(Vec2, f32)>,
    blurred: BlurredDifference,
}

impl Gradient {
    fn new(spheres: usize, size: usize) -> Self {
        Self {
            sums: vec![Vec4::ZERO; spheres],
            discs: Vec::with_capacity(spheres),
            near: Vec::with_capacity(spheres),
            blurred: BlurredDifference::new(size),
        }
    }

    /// O(n²) tests for overlap, then the points of each disc against the discs that meet it.
    fn compute(&mut self, view: &View, soft: f32, spheres: &[Vec4], turn: f32) {
        self.blurred.weigh(view, spheres);
        self.discs.clear();
        self.discs.extend(spheres.iter().map(|sphere| view.frame.disc(*sphere)));
        let mut circle = [Vec2::ZERO; POINTS];
        for (k, point) in circle.iter_mut().enumerate() {
            *point = Vec2::from_angle(turn + k as f32 * (TAU / POINTS as f32));
        }
        for (i, sum) in self.sums.iter_mut().enumerate() {
            *sum = Vec4::ZERO;
            let (center, radius) = self.discs[i];
            if !overlapping(&self.discs, i, &mut self.near) {
                continue;
            }
            let (mut xs, mut ys, mut free) = ([0.0_f32; POINTS], [0.0_f32; POINTS], [f32::INFINITY; POINTS]);
            for (k, point) in circle.iter().enumerate() {
                (xs[k], ys[k]) = (radius * point.x, radius * point.y);
            }
            for (number, (offset, other)) in self.near.iter().enumerate() {
                let limit = other * other;
                if number % 8 == 7 && free.iter().all(|f| *f < 0.0) {
                    break;
                }
                for k in 0..POINTS {
                    let (dx, dy) = (xs[k] - offset.x, ys[k] - offset.y);
                    free[k] = free[k].min(dx * dx + dy * dy - limit);
                }
            }
            let (mut grow, mut shift) = (0.0, Vec2::ZERO);
            for k in 0..POINTS {
                if free[k] >= 0.0 {
                    let at = center + Vec2::new(xs[k], ys[k]);
                    let sign = view.sign(at) + soft * self.blurred.force(at);
                    grow += sign;
                    shift += circle[k] * sign;
                }
            }
            let weight = radius * (TAU / POINTS as f32) * view.inverse_area * view.frame.scale;
            *sum = (view.frame.lift(shift) * weight).extend(grow * weight);
        }
    }
}

/// The gradient of the set's volume outside the mesh by sphere `i` (centre, radius): an integral over the exposed part of
/// its surface.
fn bulging(spheres: &[Vec4], i: usize, solid: &Solid, directions: &[Vec3; BULGE_POINTS]) -> Vec4 {
    let sphere = spheres[i];
    let center = sphere.truncate();
    // The depth changes no faster than one goes, but for the voxels' interpolation.
    if solid.depth_near(center) > sphere.w + 2.0 * solid.cell() {
        return Vec4::ZERO;
    }
    let hides = |p: Vec3| {
        let holds = |(j, other): (usize, &Vec4)| j != i && p.distance_squared(other.truncate()) < other.w * other.w;
        spheres.iter().enumerate().any(holds)
    };
    let mut sum = Vec4::ZERO;
    for &out in directions {
        let p = center + out * sphere.w;
        if solid.is_deep(p) {
            continue;
        }
        let height = (-solid.depth_near(p) / BULGE_HEIGHT).clamp(0.0, 1.0);
        if height > 0.0 && !hides(p) {
            sum += out.extend(1.0) * height;
        }
    }
    sum * (2.0 * TAU * sphere.w * sphere.w / BULGE_POINTS as f32)
}

/// Collects the discs that may hide a part of disc `i`'s boundary, relative to its centre. False if one hides all of it.
fn overlapping(discs: &[(Vec2, f32)], i: usize, near: &mut Vec<(Vec2, f32)>) -> bool {
    near.clear();
    let (center, radius) = discs[i];
    for (j, &(other, other_radius)) in discs.iter().enumerate() {
        let offset = other - center;
        let distance_sq = offset.length_squared();
        let (sum, difference) = (radius + other_radius, other_radius - radius);
        if distance_sq >= sum * sum || j == i {
            continue;
        }
        if distance_sq <= difference * difference {
            // One disc holds the other; of two equal ones the first keeps its boundary.
            if difference > 0.0 || (difference == 0.0 && j < i) {
                return false;
            }
            continue;
        }
        near.push((offset, other_radius));
    }
    true
}
