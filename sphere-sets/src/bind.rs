use glam::{DMat3, DMat4, DVec3, Mat4, Vec3, Vec4};
use lobe_core::Sphere;
use rayon::prelude::*;

use crate::bound_set::{BoundSet, BoundSphere, CARRIERS, Morph, at_least, stretch};
use crate::error::BindError;
use crate::random::quasi_random;
use crate::sphere_set::SphereSet;
use crate::surface::Surface;

/// Points on the surface that the patches are made of.
const SAMPLES: usize = 40_000;

/// Joints with a smaller part of a patch do not carry the sphere.
const LEAST_SHARE: f64 = 0.02;

/// The joints and weights that carry the points of a mesh: point `v` is at `Σ_j w_vj J_j (p_v + Σ_k m_k Δ_kv)`, `J_j` from
/// bind space to the world, as in glTF (linear blend skinning after morph targets).
#[derive(Clone, Copy, Debug)]
pub struct Carriers<'a> {
    /// Per vertex, the numbers of its joints.
    pub joints: &'a [[u16; 4]],
    /// Per vertex, the weights of its joints; those of weight 0 do not matter.
    pub weights: &'a [[f32; 4]],
    /// Per morph target, per vertex, its displacement in bind space.
    pub targets: &'a [Vec<Vec3>],
    /// The joints' matrices in the pose of the positions, bind space to the world.
    pub rest_joints: &'a [Mat4],
    /// The morph weights in the pose of the positions.
    pub rest_morph: &'a [f32],
}

impl SphereSet {
    /// Binds the spheres to the bones of their mesh: `positions` are its vertices in the space and pose that the set was
    /// built in.
    ///
    /// A sphere rides on the surface near its own whose outward normal leaves it, so that an arm's spheres do not cling
    /// to the trunk that the arm rests on. O(spheres × 40 000) distances.
    ///
    /// # Errors
    /// [`BindError`] for slices of other lengths than the mesh has vertices, joints that have no rest matrix, weights
    /// that are negative or not finite, and meshes that no set could be built from.
    pub fn bind(
        &self,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        carriers: &Carriers<'_>,
    ) -> Result<BoundSet, BindError> {
        check(positions.len(), carriers)?;
        let surface = Surface::new(positions, triangles)?;
        let bind_pose = BindPose::new(positions, carriers);
        let samples = samples(&surface);
        let bound: Vec<(BoundSphere, Vec<Morph>)> = self
            .spheres
            .par_iter()
            .enumerate()
            .map(|(i, sphere)| {
                let offset = self.self_shadows.get(i).map_or(Vec3::ZERO, |own| own.offset);
                bind_pose.carry(sphere, offset, surface.to_unit(*sphere), &samples)
            })
            .collect();
        let targets = (0..carriers.targets.len()).map(|k| bound.iter().map(|(_, morphs)| morphs[k]).collect());
        Ok(BoundSet {
            rest: self.clone(),
            targets: targets.collect(),
            spheres: bound.iter().map(|(sphere, _)| *sphere).collect(),
        })
    }
}

fn check(vertices: usize, carriers: &Carriers<'_>) -> Result<(), BindError> {
    at_least("joints of vertices", carriers.joints.len(), vertices)?;
    at_least("weights of vertices", carriers.weights.len(), vertices)?;
    at_least("rest morph weights", carriers.rest_morph.len(), carriers.targets.len())?;
    for target in carriers.targets {
        at_least("displacements of a morph target", target.len(), vertices)?;
    }
    for (vertex, (joints, weights)) in carriers.joints.iter().zip(carriers.weights).enumerate().take(vertices) {
        for (&joint, &weight) in joints.iter().zip(weights) {
            if !(weight.is_finite() && weight >= 0.0) {
                return Err(BindError::BadWeight { vertex });
            }
            if weight > 0.0 && usize::from(joint) >= carriers.rest_joints.len() {
                return Err(BindError::NoSuchJoint { vertex, joint, joints: carriers.rest_joints.len() });
            }
        }
    }
    Ok(())
}

/// A point of the surface, in unit space.
struct Sample {
    point: Vec3,
    normal: Vec3,
    corners: [u32; 3],
    /// Barycentric coordinates.
    shares: [f64; 3],
}

/// Points spread evenly over the surface.
fn samples(surface: &Surface) -> Vec<Sample> {
    let spread = surface.spread();
    (0..SAMPLES)
        .map(|i| {
            let (t, shares) = spread(quasi_random(i));
            let [a, b, c] = surface.triangles[t];
            Sample {
                point: a * shares[0] + b * shares[1] + c * shares[2],
                normal: (b - a).cross(c - a).normalize_or_zero(),
                corners: surface.sources[t],
                shares: shares.map(f64::from),
            }
        })
        .collect()
}

/// The mesh in bind space, with its joints and weights.
struct BindPose<'a> {
    carriers: &'a Carriers<'a>,
    joints: Vec<DMat4>,
    /// The vertices in bind space, morphed as at rest.
    points: Vec<DVec3>,
}

impl<'a> BindPose<'a> {
    fn new(positions: &[Vec3], carriers: &'a Carriers<'a>) -> Self {
        let joints: Vec<DMat4> = carriers.rest_joints.iter().map(Mat4::as_dmat4).collect();
        let points = positions.iter().enumerate().map(|(v, position)| {
            let mut blend = DMat4::ZERO;
            for (joint, weight) in carriers.joints[v].iter().zip(carriers.weights[v]).filter(|(_, w)| *w > 0.0) {
                blend += joints[usize::from(*joint)] * f64::from(weight);
            }
            let point = blend.inverse().transform_point3(position.as_dvec3());
            // A collapsed vertex has been anywhere.
            if point.is_finite() { point } else { DVec3::ZERO }
        });
        Self { carriers, points: points.collect(), joints }
    }

    /// The joints that carry a sphere, given in the world and in unit space, and the offset of its near sphere.
    fn carry(&self, from: &Sphere, offset: Vec3, unit: Vec4, samples: &[Sample]) -> (BoundSphere, Vec<Morph>) {
        let (center, radius) = (from.center.as_dvec3(), from.radius);
        let patch = patch(unit, samples);
        // Per joint: its part of the patch, and the moment of that part in bind space.
        let mut shares = vec![(0.0_f64, DVec3::ZERO); self.joints.len()];
        self.over(&patch, |area, joint, vertex| {
            shares[joint].0 += area;
            shares[joint].1 += self.points[vertex] * area;
        });
        let mut order: Vec<usize> = (0..shares.len()).filter(|j| shares[*j].0 > 0.0).collect();
        order.sort_by(|a, b| shares[*b].0.total_cmp(&shares[*a].0));
        let whole: f64 = shares.iter().map(|(share, _)| share).sum();
        order.retain(|j| shares[*j].0 >= LEAST_SHARE * whole);
        order.truncate(CARRIERS);
        let kept: f64 = order.iter().map(|j| shares[*j].0).sum();

        let (joints, weights, points) = ([0; CARRIERS], [0.0; CARRIERS], [Vec3::ZERO; CARRIERS]);
        let mut sphere = BoundSphere { joints, weights, points, radius, offset };
        let mut carried = [(0.0_f64, DVec3::ZERO); CARRIERS];
        for (k, &j) in order.iter().enumerate() {
            carried[k] = (shares[j].0 / kept, shares[j].1 / shares[j].0);
            sphere.joints[k] = j as u16;
        }
        if order.is_empty() && !self.joints.is_empty() {
            carried[0].0 = 1.0;
        }
        let (mut blend, mut reach, mut regular) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        let joint = |k: usize| self.joints[usize::from(sphere.joints[k])];
        for (k, (weight, point)) in carried.iter().enumerate().filter(|(_, (weight, _))| *weight > 0.0) {
            blend += DMat3::from_mat4(joint(k)) * *weight;
            reach += joint(k).transform_point3(*point) * *weight;
            regular += if inverse(joint(k)).is_some() { *weight } else { 0.0 };
        }
        // The sphere's centre is not the patch's centroid: the difference turns with each joint.
        for (k, (weight, point)) in carried.iter_mut().enumerate().filter(|(_, (weight, _))| *weight > 0.0) {
            if let Some(back) = inverse(joint(k)) {
                *point += back * (center - reach) / regular;
            }
            sphere.weights[k] = *weight as f32;
        }
        let scale = stretch(blend);
        let bind_radius = if scale > 0.0 { f64::from(radius) / scale } else { f64::from(radius) };
        let morphs = self.morphs(&patch, &sphere, carried);
        let mut bind_radius = bind_radius as f32;
        for (morph, &weight) in morphs.iter().zip(self.carriers.rest_morph) {
            bind_radius -= weight * morph.radius;
            for ((_, point), add) in carried.iter_mut().zip(morph.points) {
                *point -= add.as_dvec3() * f64::from(weight);
            }
        }
        sphere.points = carried.map(|(_, point)| point.as_vec3());
        sphere.radius = bind_radius;
        if let Some(back) = Some(blend.inverse()).filter(DMat3::is_finite) {
            sphere.offset = (back * offset.as_dvec3()).normalize_or_zero().as_vec3() * offset.length();
        }
        (sphere, morphs)
    }

    /// Calls `each(area, joint, vertex)` for everything that carries a patch.
    fn over(&self, patch: &[(f64, &Sample)], mut each: impl FnMut(f64, usize, usize)) {
        for (area, sample) in patch {
            for (vertex, share) in sample.corners.iter().zip(sample.shares) {
                let vertex = *vertex as usize;
                let joints = self.carriers.joints[vertex].iter().zip(self.carriers.weights[vertex]);
                for (joint, weight) in joints.filter(|(_, weight)| *weight > 0.0) {
                    each(area * share * f64::from(weight), usize::from(*joint), vertex);
                }
            }
        }
    }

    /// The effect of each morph target on a sphere: it moves the sphere with the patch's mean displacement, and grows it by
    /// the g that fits `Δ_v ≈ t + g u_v` best, `u_v` from the sphere's centre to the patch.
    fn morphs(&self, patch: &[(f64, &Sample)], sphere: &BoundSphere, carried: [(f64, DVec3); CARRIERS]) -> Vec<Morph> {
        let center: DVec3 = carried.iter().map(|(weight, point)| *point * *weight).sum();
        let away = |vertex: usize| (self.points[vertex] - center).normalize_or_zero();
        let (mut area, mut outward) = (0.0, DVec3::ZERO);
        self.over(patch, |share, _, vertex| {
            area += share;
            outward += away(vertex) * share;
        });
        outward /= area.max(f64::MIN_POSITIVE);
        let morph = |target: &Vec<Vec3>| {
            let moved = |vertex: usize| target[vertex].as_dvec3();
            let mut sums = [(0.0_f64, DVec3::ZERO); CARRIERS];
            let mut total = DVec3::ZERO;
            self.over(patch, |share, joint, vertex| {
                total += moved(vertex) * share;
                let own = |k: &usize| usize::from(sphere.joints[*k]) == joint && sphere.weights[*k] > 0.0;
                if let Some(k) = (0..CARRIERS).find(own) {
                    sums[k].0 += share;
                    sums[k].1 += moved(vertex) * share;
                }
            });
            total /= area.max(f64::MIN_POSITIVE);
            // A patch that looks one way only says nothing of growth: the 0.02 keeps it from saying much.
            let (mut along, mut spread) = (0.0, 0.02 * area);
            self.over(patch, |share, _, vertex| {
                let u = away(vertex) - outward;
                along += u.dot(moved(vertex) - total) * share;
                spread += u.length_squared() * share;
            });
            let growth = if spread > 0.0 { along / spread } else { 0.0 };
            let shift = outward * growth;
            let points =
                sums.map(|(share, sum)| if share > 0.0 { (sum / share - shift).as_vec3() } else { Vec3::ZERO });
            Morph { points, radius: growth as f32 }
        };
        self.carriers.targets.iter().map(morph).collect()
    }
}

fn inverse(joint: DMat4) -> Option<DMat3> {
    Some(DMat3::from_mat4(joint).inverse()).filter(DMat3::is_finite)
}

/// The surface that a sphere stands for: samples near its own surface whose normals leave it, with their areas.
fn patch(unit: Vec4, samples: &[Sample]) -> Vec<(f64, &Sample)> {
    let center = unit.truncate();
    for near in [0.35, 0.7, 1.5, 4.0, 16.0] {
        let width = near * unit.w + 1e-4;
        let patch: Vec<(f64, &Sample)> = samples
            .iter()
            .filter_map(|sample| {
                let to = sample.point - center;
                let distance = to.length();
                let gap = (distance - unit.w) / width;
                // A sheet's own samples lie across, cos ≈ 0; a neighbour's face the sphere, cos < 0.
                let leaves = sample.normal.dot(to) / distance.max(1e-20) + 0.2;
                (gap.abs() < 3.0 && leaves > 0.0).then(|| (f64::from(leaves * (-gap * gap).exp()), sample))
            })
            .collect();
        let total: f64 = patch.iter().map(|(area, _)| area).sum();
        if total > 4.0 {
            return patch;
        }
    }
    let nearest =
        samples.iter().min_by(|a, b| a.point.distance_squared(center).total_cmp(&b.point.distance_squared(center)));
    nearest.map(|sample| (1.0, sample)).into_iter().collect()
}
