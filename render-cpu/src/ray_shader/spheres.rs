//! Blocker spheres as shadow rays meet them.

use crate::ray_shader::LANES;
use crate::world::{Named, Tree, hierarchy_scale};
use core::time::Duration;
use glam::{Vec3, Vec3A};
use lobe_core::{Cone, Coverage, Receiver, Shaft, Sphere};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};
use scene::BlockerSet;

/// A blocker, and how receivers of its own object see it.
#[derive(Clone, Copy)]
struct Blocker {
    sphere: Sphere,
    own_radius: f32,
    /// For receivers of its own object it blocks only where the ray leaves it farther away than this.
    own_distance: f32,
    object: u32,
    index: u32,
}

impl Boundable for Blocker {
    fn aabb(&self) -> Aabb {
        let (c, r) = (Vec3A::from(self.sphere.center), Vec3A::splat(self.sphere.radius));
        Aabb::new(c - r, c + r)
    }
}

impl Named for Blocker {
    fn name(&self) -> (u32, u32) {
        (self.object, self.index)
    }
}

/// A hierarchy over blocker spheres.
#[derive(Debug)]
pub(super) struct SphereTargets {
    tree: Tree<Blocker>,
}

impl SphereTargets {
    pub(super) fn new(set: &BlockerSet) -> Self {
        let solid = |s: &Sphere| s.radius > 0.0 && s.radius.is_finite() && s.center.is_finite();
        let blockers: Vec<Blocker> = (0..set.spheres.len())
            .filter(|i| solid(&set.spheres[*i]))
            .map(|i| {
                let (own, own_distance) = set.own(i);
                let (object, index) = (set.objects[i], i as u32);
                Blocker { sphere: set.spheres[i], own_radius: own.radius, own_distance, object, index }
            })
            .collect();
        let bounds = blockers.iter().fold(Aabb::empty(), |all, b| all.union(&b.aabb()));
        let size = bounds.diagonal().length() + bounds.min.abs().max(bounds.max.abs()).max_element();
        let scale = if blockers.is_empty() { 1.0 } else { hierarchy_scale(size) };
        let tree = Tree::new(&blockers, scale, |b| {
            let boxes: Vec<_> = b.iter().map(|b| b.aabb()).map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
            build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::ZERO.clone())
        });
        Self { tree }
    }

    /// Whether a sphere hides the direction from the receiver up to the distance.
    #[inline(never)]
    pub(super) fn hide(&self, at: &Receiver, direction: Vec3, distance: f32) -> bool {
        let ray = Ray::new(at.position.into(), direction.into(), 0.0, distance);
        self.tree.any(ray, |b, ray| {
            let own = b.object == at.object;
            let (radius, least) = if own { (b.own_radius, b.own_distance) } else { (b.sphere.radius, 0.0) };
            let to = Vec3A::from(b.sphere.center) - ray.origin;
            let along = to.dot(ray.direction);
            let half_sq = radius * radius - (to - ray.direction * along).length_squared();
            if half_sq <= 0.0 {
                return f32::INFINITY;
            }
            let half = half_sq.sqrt();
            let enter = (along - half).max(0.0);
            if along + half > least && enter < ray.tmax { enter } else { f32::INFINITY }
        })
    }

    /// Lists the spheres that may hide some of the light from some of the receivers.
    pub(super) fn list(&self, shaft: &Shaft, out: &mut Vec<Eight>) {
        out.clear();
        let mut count = 0;
        self.tree.in_shaft(shaft, &mut |_, b| {
            let lane = count % LANES;
            if lane == 0 {
                out.push(Eight::default());
            }
            if let Some(eight) = out.last_mut() {
                [eight.x[lane], eight.y[lane], eight.z[lane]] = b.sphere.center.to_array();
                eight.radius[lane] = b.sphere.radius;
                eight.own_radius[lane] = b.own_radius;
                eight.own_distance[lane] = b.own_distance;
                eight.object[lane] = b.object;
            }
            count += 1;
            false
        });
    }
}

/// Eight blockers side by side; those of radius 0 are none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Eight {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    radius: [f32; LANES],
    own_radius: [f32; LANES],
    own_distance: [f32; LANES],
    object: [u32; LANES],
}

/// What hides some of one light from one receiver.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen {
    /// Unit direction and squared chord: all unit vectors nearer than the chord are hidden.
    caps: Vec<(Vec3, f32)>,
    /// Spheres that are behind the light's near surface in part: centre from the receiver, r², least distance of the exit.
    others: Vec<(Vec3, f32, f32)>,
}

impl Seen {
    pub(super) fn is_empty(&self) -> bool {
        self.caps.is_empty() && self.others.is_empty()
    }

    /// Keeps of the listed spheres those that the light's cone touches.
    #[inline(always)]
    pub(super) fn select(&mut self, at: &Receiver, cone: &Cone, list: &[Eight]) -> Coverage {
        // Rounding of products of unit vectors; a sphere too many does no harm.
        const SLACK: f32 = 2e-6;
        self.caps.clear();
        self.others.clear();
        let (sin, cos) = (cone.sin_sq().sqrt(), cone.cos());
        let (p, axis) = (at.position, cone.axis);
        let (nearest, farthest) = (cone.distance - cone.distance * sin, cone.distance);
        let mut dark = false;
        for e in list {
            let mut touched = [false; LANES];
            let mut hides = [false; LANES];
            let mut cap = [false; LANES];
            let mut chord_sq = [0.0f32; LANES];
            let (mut cx, mut cy, mut cz) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            let (mut d, mut radius, mut least) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            for l in 0..LANES {
                let own = e.object[l] == at.object;
                let r = if own { e.own_radius[l] } else { e.radius[l] };
                let tau = if own { e.own_distance[l] } else { 0.0 };
                let (x, y, z) = (e.x[l] - p.x, e.y[l] - p.y, e.z[l] - p.z);
                let dist = (x * x + y * y + z * z).sqrt();
                let inverse = 1.0 / dist.max(f32::MIN_POSITIVE);
                let (x, y, z) = (x * inverse, y * inverse, z * inverse);
                let along = x * axis.x + y * axis.y + z * axis.z;
                let power = (dist - r) * (dist + r);
                let sphere_sin = (r * inverse).min(1.0);
                let sphere_cos = (power.max(0.0)).sqrt() * inverse;
                let reaches = (dist + r > tau) & (dist - r < farthest) & (r > 0.0);
                let inside = power < 0.0;
                let near = along >= cos * sphere_cos - sin * sphere_sin - SLACK;
                let wide = sin < sphere_sin;
                let tangent_sq = power.max(0.0);
                let front = inside | (tangent_sq < nearest * nearest);
                let plain = tau * tau <= power;
                let whole = along > cos * sphere_cos + sin * sphere_sin + SLACK;
                hides[l] = reaches & ((inside & !own) | (front & plain & !inside & wide & whole));
                touched[l] = reaches & (inside | near);
                cap[l] = front;
                let narrow = r * inverse * r * inverse / (1.0 + sphere_cos);
                let late = (r - dist + tau) * (r + dist - tau) / (2.0 * tau * dist).max(f32::MIN_POSITIVE);
                chord_sq[l] = 2.0 * if plain { narrow } else { late };
                (cx[l], cy[l], cz[l], d[l], radius[l], least[l]) = (x, y, z, dist, r, tau);
            }
            for l in 0..LANES {
                dark |= hides[l];
                if !touched[l] {
                    continue;
                }
                let c = Vec3::new(cx[l], cy[l], cz[l]);
                if cap[l] {
                    self.caps.push((c, chord_sq[l]));
                } else {
                    self.others.push((c * d[l], radius[l] * radius[l], least[l]));
                }
            }
        }
        match (dark, self.is_empty()) {
            (true, _) => Coverage::Dark,
            (_, true) => Coverage::Lit,
            _ => Coverage::Partial,
        }
    }

    /// Which of eight directions are hidden up to their distances.
    #[inline(always)]
    pub(super) fn hide(&self, v: &[[f32; LANES]; 3], distance: &[f32; LANES]) -> [bool; LANES] {
        let mut hidden = [false; LANES];
        for (c, chord_sq) in &self.caps {
            for l in 0..LANES {
                let (x, y, z) = (v[0][l] - c.x, v[1][l] - c.y, v[2][l] - c.z);
                hidden[l] |= x * x + y * y + z * z < *chord_sq;
            }
        }
        for (c, radius_sq, least) in &self.others {
            for l in 0..LANES {
                let along = v[0][l] * c.x + v[1][l] * c.y + v[2][l] * c.z;
                let (x, y, z) = (c.x - v[0][l] * along, c.y - v[1][l] * along, c.z - v[2][l] * along);
                let half_sq = radius_sq - (x * x + y * y + z * z);
                let half = half_sq.max(0.0).sqrt();
                hidden[l] |= (half_sq > 0.0) & (along + half > *least) & ((along - half).max(0.0) < distance[l]);
            }
        }
        hidden
    }
}
