//! Blocker spheres as shadow rays meet them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8, u32x8};
use glam::{Vec3, Vec3A};
use lobe_core::vec3x8::{LANES, Vec3x8};
use lobe_core::{Cone, NO_OBJECT, Receiver, SelfShadow, Sphere};
use ray_tracing::SphereHierarchy;
use scene::BlockerSet;
use shading::{Coverage, Shaft};

/// A blocker as receivers of its own object see it.
#[derive(Clone, Copy, Debug)]
struct Blocker {
    /// Of receivers inside it, from its centre.
    near: Sphere,
    /// For receivers of its own object it blocks only where the ray leaves it farther away than this.
    own_distance: f32,
    object: u32,
}

/// A hierarchy over blocker spheres.
#[derive(Debug)]
pub(super) struct SphereTargets {
    hierarchy: SphereHierarchy<Blocker>,
    /// Objects with a sphere, ascending.
    objects: Vec<u32>,
}

impl SphereTargets {
    pub(super) fn new(set: &BlockerSet) -> Self {
        let solid = |s: &Sphere| s.radius > 0.0 && s.radius.is_finite() && s.center.is_finite();
        let blockers: Vec<(Sphere, Blocker)> = (0..set.spheres.len())
            .filter(|i| solid(&set.spheres[*i]))
            .map(|i| {
                let (near, own_distance) = set.own(i);
                (set.spheres[i], Blocker { near, own_distance, object: set.objects[i] })
            })
            .collect();
        let hierarchy = SphereHierarchy::new(&blockers);
        let mut objects: Vec<_> = blockers.iter().map(|(_, b)| b.object).filter(|o| *o != NO_OBJECT).collect();
        objects.sort_unstable();
        objects.dedup();
        Self { hierarchy, objects }
    }

    /// The normal of the plane below which a receiver sees nothing: of its facet where its object has spheres.
    pub(super) fn facet(&self, at: &Receiver) -> Vec3 {
        if self.objects.binary_search(&at.object).is_ok() { at.face } else { at.normal }
    }

    /// Whether a sphere hides the direction from the receiver up to the distance.
    #[inline(never)]
    pub(super) fn hide(&self, at: &Receiver, direction: Vec3, distance: f32) -> bool {
        let (from, along_ray) = (Vec3A::from(at.position), Vec3A::from(direction));
        self.hierarchy.any(at.position, direction, distance, |sphere, b, farthest| {
            let own = b.object == at.object;
            let (sphere, least) =
                if own { (SelfShadow::seen(*sphere, b.near, at.position), b.own_distance) } else { (*sphere, 0.0) };
            let (to, radius) = (Vec3A::from(sphere.center) - from, sphere.radius);
            let along = to.dot(along_ray);
            let half_sq = radius * radius - (to - along_ray * along).length_squared();
            if half_sq <= 0.0 {
                return f32::INFINITY;
            }
            let half = half_sq.sqrt();
            let enter = (along - half).max(0.0);
            if along + half > least && enter < farthest { enter } else { f32::INFINITY }
        })
    }

    /// Lists the spheres that may hide some of the light from some of the receivers.
    pub(super) fn list(&self, shaft: &Shaft, out: &mut Vec<SpherePacket>) {
        out.clear();
        let mut count = 0;
        self.hierarchy.in_shaft(shaft, |sphere, b| {
            let lane = count % LANES;
            if lane == 0 {
                out.push(SpherePacket::default());
            }
            if let Some(packet) = out.last_mut() {
                [packet.x[lane], packet.y[lane], packet.z[lane]] = sphere.center.to_array();
                packet.radius[lane] = sphere.radius;
                [packet.offset[0][lane], packet.offset[1][lane], packet.offset[2][lane]] = b.near.center.to_array();
                packet.own_radius[lane] = b.near.radius;
                packet.own_distance[lane] = b.own_distance;
                packet.object[lane] = b.object;
            }
            count += 1;
        });
    }
}

/// Eight blockers side by side; those of radius 0 are none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SpherePacket {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    radius: [f32; LANES],
    offset: [[f32; LANES]; 3],
    own_radius: [f32; LANES],
    own_distance: [f32; LANES],
    object: [u32; LANES],
}

/// The spheres that hide some of one light from one receiver.
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
    pub(super) fn select<S: Simd>(&mut self, simd: S, at: &Receiver, cone: &Cone, list: &[SpherePacket]) -> Coverage {
        // Rounding of products of unit vectors; a sphere too many does no harm.
        const SLACK: f32 = 2e-6;
        self.caps.clear();
        self.others.clear();
        let (sin, cos) = (cone.sin_sq().sqrt(), cone.cos());
        let (p, axis) = (at.position, cone.axis);
        let (nearest, farthest) = (cone.distance - cone.distance * sin, cone.distance);
        let mut dark = 0;
        let zero = f32x8::splat(simd, 0.0);
        let object = u32x8::splat(simd, at.object);
        for e in list {
            let own = u32x8::simd_from(simd, e.object).simd_eq(object);
            let row = |row: &[f32; LANES]| f32x8::simd_from(simd, *row);
            let tau = own.select(row(&e.own_distance), zero);
            let to = Vec3x8 { x: row(&e.x), y: row(&e.y), z: row(&e.z) }.minus(p);
            // `SelfShadow::seen`.
            let whole = row(&e.radius);
            let d = to.length_squared().sqrt();
            let w = own.select(whole / d.max(whole).max(f32::MIN_POSITIVE), zero);
            let r = whole - (whole - row(&e.own_radius)) * w;
            let [x, y, z] = e.offset.each_ref().map(|column| row(column) * w);
            let to = to + Vec3x8 { x, y, z };
            let d = to.length_squared().sqrt();
            let inverse = 1.0 / d.max(f32::MIN_POSITIVE);
            let c = to * inverse;
            let along = c.dot_one(axis);
            let power = (d - r) * (d + r);
            let tangent_sq = power.max(0.0);
            let (sphere_sin, sphere_cos) = ((r * inverse).min(1.0), tangent_sq.sqrt() * inverse);
            let reaches = (d + r).simd_gt(tau) & (d - r).simd_lt(farthest) & r.simd_gt(0.0);
            let inside = power.simd_lt(0.0);
            let (both, aside) = (sphere_cos * cos, sphere_sin * sin);
            let near = along.simd_ge(both - aside - SLACK);
            let front = inside | tangent_sq.simd_lt(nearest * nearest);
            let plain = (tau * tau).simd_le(power);
            let whole = sphere_sin.simd_gt(sin) & along.simd_gt(both + aside + SLACK);
            dark |= (reaches & ((inside & !own) | (front & plain & !inside & whole))).to_bitmask();
            let narrow = r * inverse * (r * inverse) / (1.0 + sphere_cos);
            let late = (r - d + tau) * (r + d - tau) / (tau * d * 2.0).max(f32::MIN_POSITIVE);
            let chord_sq = plain.select(narrow, late) * 2.0;
            let (touched, front) = ((reaches & (inside | near)).to_bitmask(), front.to_bitmask());
            for l in (0..LANES).filter(|l| touched >> l & 1 != 0) {
                if front >> l & 1 != 0 {
                    self.caps.push((c.get(l), chord_sq[l]));
                } else {
                    self.others.push((to.get(l), r[l] * r[l], tau[l]));
                }
            }
        }
        match (dark != 0, self.is_empty()) {
            (true, _) => Coverage::Dark,
            (_, true) => Coverage::Lit,
            _ => Coverage::Partial,
        }
    }

    /// The mask of those of eight directions that are hidden up to their distances.
    #[inline(always)]
    pub(super) fn hide<S: Simd>(&self, v: Vec3x8<S>, distance: f32x8<S>) -> mask32x8<S> {
        let simd = distance.token();
        let mut hidden = mask32x8::splat(simd, false);
        for (c, chord_sq) in &self.caps {
            hidden |= v.minus(*c).length_squared().simd_lt(*chord_sq);
        }
        for (c, radius_sq, least) in &self.others {
            let along = v.dot_one(*c);
            let half_sq = *radius_sq - (v * along).minus(*c).length_squared();
            let half = half_sq.max(0.0).sqrt();
            let (enter, leave) = ((along - half).max(0.0), along + half);
            hidden |= half_sq.simd_gt(0.0) & leave.simd_gt(*least) & enter.simd_lt(distance);
        }
        hidden
    }
}
