//! Samples of one point and one light.

use super::Geometry;
use super::meridian::{Cap, Meridian};
use super::occluders::Occluders;
use crate::area::{self, Seen};
use crate::cone::LightCone;
use crate::sky::Sky;
use crate::sobol::{Sequence, mix};
use brdf::{Brdf, Material};
use core::f64::consts::TAU;
use glam::{DVec3, Vec3};
use lighting::Area;
use lobe_core::{NO_OBJECT, Receiver};
use ray_tracing::World;

/// One point and one light.
pub(super) struct Pair<'a> {
    pub(super) world: &'a World<'a>,
    pub(super) geometry: Geometry<'a>,
    pub(super) at: &'a Receiver,
    pub(super) material: &'a Material,
    /// Of the light.
    pub(super) radiance: Vec3,
    /// Its shape, where that is no sphere.
    pub(super) area: Option<Area<'a>>,
    /// The sphere's directions, or those of a sphere around the shape.
    pub(super) cone: LightCone,
    pub(super) occluders: &'a Occluders,
    /// The directions below the receiver's horizon, where it cuts the light.
    pub(super) horizon: Option<Cap>,
    /// First azimuth at which some of the cone is above the horizon, and how far these azimuths reach.
    pub(super) azimuths: (f64, f64),
    /// The start of shadow rays in the true geometry.
    pub(super) origin: Vec3,
    pub(super) glossy: bool,
}

/// As f32, which does not round it up to 1.
fn below_one(x: f64) -> f32 {
    (x as f32).min(1.0 - f32::EPSILON / 2.0)
}

impl Pair<'_> {
    /// Adds samples of one replicate to its sums, shadowed and unshadowed.
    pub(super) fn sample(
        &self,
        key: u64,
        range: core::ops::Range<u32>,
        meridian: &mut Meridian,
        sums: &mut [DVec3; 2],
    ) {
        let on_light = Sequence::new(mix(key, 1));
        let on_brdf = Sequence::new(mix(key, 2));
        let caps = self.occluders.caps();
        for i in range {
            let (x, y) = (on_light.get(i, 0), on_light.get(i, 1));
            if let Some(area) = &self.area {
                self.area_sample(area, [x, y], core::array::from_fn(|d| on_brdf.get(i, d)), sums);
                continue;
            }
            if caps.is_empty() && self.horizon.is_none() {
                let v = self.cone.sample(x, y);
                let value = self.light_sample(v);
                self.add(v, value, sums);
            } else {
                self.meridian_sample(x, y, meridian, sums);
            }
            if !self.glossy {
                continue;
            }
            let u = core::array::from_fn(|d| below_one(on_brdf.get(i, d)));
            let Some(sample) = self.material.sample(self.at, u) else { continue };
            let v = sample.direction.as_dvec3().normalize();
            if self.cone.contains(v) {
                let reflectance = self.material.eval(self.at, sample.direction);
                self.add(v, self.weighted(reflectance, f64::from(sample.pdf), self.cone.pdf()), sums);
            }
        }
    }

    /// Adds directions of a picture of all directions, and as many of the reflectance.
    pub(super) fn sky_sample(&self, key: u64, sky: &Sky<'_>, range: core::ops::Range<u32>, sums: &mut [DVec3; 2]) {
        let on_sky = Sequence::new(mix(key, 1));
        let on_brdf = Sequence::new(mix(key, 2));
        let far = self.cone.surface(self.at.normal.as_dvec3());
        let mut add = |v: DVec3, reflectance: Vec3, p: f64, q: f64| {
            self.add_before(v, far, self.weighted(reflectance * sky.radiance(v), p, q), sums);
        };
        for i in range {
            let (v, p) = sky.sample(on_sky.get(i, 0), on_sky.get(i, 1));
            let reflectance = self.material.eval(self.at, v.as_vec3());
            if reflectance != Vec3::ZERO && p > 0.0 {
                add(v, reflectance, p, f64::from(self.material.pdf(self.at, v.as_vec3())));
            }
            let u = core::array::from_fn(|d| below_one(on_brdf.get(i, d)));
            if let Some(sample) = self.material.sample(self.at, u) {
                let v = sample.direction.as_dvec3().normalize();
                add(v, self.material.eval(self.at, sample.direction), f64::from(sample.pdf), sky.pdf(v));
            }
        }
    }

    /// Adds a point of a light's surface, and a direction of a reflectance that is narrow compared with it.
    fn area_sample(&self, area: &Area<'_>, [x, y]: [f64; 2], on_brdf: [f64; 3], sums: &mut [DVec3; 2]) {
        if let Some(Seen { direction, distance, pdf, shows }) = area::sample(area, x, y) {
            let reflectance = self.material.eval(self.at, direction.as_vec3());
            if reflectance != Vec3::ZERO {
                let other = if self.glossy { f64::from(self.material.pdf(self.at, direction.as_vec3())) } else { 0.0 };
                self.add_before(direction, distance, self.weighted(reflectance * shows, pdf, other), sums);
            }
        }
        if !self.glossy {
            return;
        }
        let u = on_brdf.map(below_one);
        let Some(sample) = self.material.sample(self.at, u) else { return };
        if let Some(Seen { direction, distance, pdf, shows }) = area::hit(area, sample.direction.as_dvec3().normalize())
        {
            let reflectance = self.material.eval(self.at, sample.direction);
            let value = self.weighted(reflectance * shows, f64::from(sample.pdf), pdf);
            self.add_before(direction, distance, value, sums);
        }
    }

    fn add_before(&self, v: DVec3, distance: f64, value: DVec3, sums: &mut [DVec3; 2]) {
        sums[1] += value;
        let by_spheres = || self.geometry.has_spheres() && self.occluders.block(v, distance);
        if value != DVec3::ZERO && !by_spheres() && !self.blocked_by_surfaces(v, distance) {
            sums[0] += value;
        }
    }

    /// Adds a sample at a random meridian of the light's cone. The part that the horizon and caps hide is left out exactly,
    /// and a ray tests the other occluders alone.
    fn meridian_sample(&self, x: f64, y: f64, meridian: &mut Meridian, sums: &mut [DVec3; 2]) {
        let (start, span) = self.azimuths;
        let (azimuth, share) = (start + span * x, span / TAU);
        let mut part = |caps: &[Cap]| {
            meridian.set(&self.cone, self.horizon.iter().chain(caps), azimuth);
            let visible = meridian.visible();
            let v = self.cone.on_meridian(meridian.point(y), azimuth);
            (visible, v)
        };
        let (above, v) = part(&[]);
        let whole = if above > 0.0 { self.light_sample(v) * (above * share) } else { DVec3::ZERO };
        sums[1] += whole;
        let caps = self.occluders.caps();
        let (visible, v) = if caps.is_empty() { (above, v) } else { part(caps) };
        if visible > 0.0 && !self.blocked_beside_caps(v) {
            sums[0] += if visible < above { self.light_sample(v) * (visible * share) } else { whole };
        }
    }

    /// The weighted contribution of a direction that was drawn uniformly from the light's cone.
    #[inline]
    fn light_sample(&self, v: DVec3) -> DVec3 {
        let reflectance = self.material.eval(self.at, v.as_vec3());
        if reflectance == Vec3::ZERO {
            return DVec3::ZERO;
        }
        let other = if self.glossy { f64::from(self.material.pdf(self.at, v.as_vec3())) } else { 0.0 };
        self.weighted(reflectance, self.cone.pdf(), other)
    }

    /// `f̃·L·w/p` with the power heuristic's `w = p²/(p² + q²)` for a direction drawn with density p that the other
    /// technique draws with density q.
    #[inline]
    fn weighted(&self, reflectance: Vec3, p: f64, q: f64) -> DVec3 {
        let ratio = q / p;
        let value = (reflectance * self.radiance).as_dvec3() / (p * (1.0 + ratio * ratio));
        if value.is_finite() { value } else { DVec3::ZERO }
    }

    #[inline]
    fn add(&self, v: DVec3, value: DVec3, sums: &mut [DVec3; 2]) {
        sums[1] += value;
        if value != DVec3::ZERO && !self.blocked(v) {
            sums[0] += value;
        }
    }

    #[inline]
    fn blocked(&self, v: DVec3) -> bool {
        (self.geometry.has_spheres() && self.occluders.block(v, self.cone.surface(v)))
            || self.blocked_by_surfaces(v, self.cone.surface(v))
    }

    #[inline]
    fn blocked_beside_caps(&self, v: DVec3) -> bool {
        let by_spheres = self.geometry.has_spheres() && self.occluders.block_beside_caps(v, self.cone.surface(v));
        by_spheres || self.blocked_by_surfaces(v, self.cone.surface(v))
    }

    /// Whether the true geometry hides a direction, where it counts.
    #[inline]
    fn blocked_by_surfaces(&self, v: DVec3, distance: f64) -> bool {
        if !matches!(self.geometry, Geometry::Mesh | Geometry::Mixed(_)) {
            return false;
        }
        let counts = |object: u32| match self.geometry {
            Geometry::Mixed(objects) => objects.get(object as usize).is_some_and(|solid| *solid),
            _ => true,
        };
        let own = self.at.object;
        if self.at.face.as_dvec3().dot(v) <= 0.0 && own != NO_OBJECT && counts(own) {
            return true;
        }
        distance > 0.0 && self.world.occluded_by(self.origin, v.as_vec3(), distance as f32, counts)
    }
}
