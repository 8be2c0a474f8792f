//! Properties that every kind of light has to keep.

use crate::{Report, Run};
use core::f64::consts::TAU;
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, LobeBuffer, Receiver, SeenLight, Tile, TileLight};
use shading::LightLobes;

/// How far a light may be off.
#[derive(Clone, Copy, Debug)]
pub struct LightLimits {
    /// Radians by which its cone may reach beyond that of its bounds.
    pub beyond: f64,
    /// Relative error of the flux of its lobes against radiance times solid angle.
    pub flux: f64,
    /// Receivers that are tried.
    pub cases: usize,
}

impl Default for LightLimits {
    /// Those of lights that are what [`LightLobes`] says: uniformly bright cones.
    fn default() -> Self {
        Self { beyond: 1e-3, flux: 1e-4, cases: 200 }
    }
}

/// Tries a light: axes have length 1, nothing is NaN or negative, the cone lies in that of the bounds, lobes carry the light's flux
/// toward its middle, tiles see what single receivers see, and a light far away is seen as small.
///
/// # Errors
/// [`Report`]: every property that does not hold, each with its worst case.
///
/// ```
/// use glam::Vec3;
/// use conformance::{LightLimits, check_light};
/// # use lobe_core::*;
/// # use shading::*;
/// # struct Sphere64(Sphere);
/// # impl LightLobes for Sphere64 {
/// #     fn bounds(&self) -> Sphere { self.0 }
/// #     fn seen_from(&self, at: &Receiver) -> SeenLight {
/// #         SeenLight::of_cone(Cone::of_sphere(at.position, self.0), Vec3::ONE)
/// #     }
/// # }
/// let lamp = Sphere64(Sphere { center: Vec3::new(0.0, 4.0, 0.0), radius: 0.5 });
/// check_light(&lamp, &LightLimits::default()).unwrap();
/// ```
pub fn check_light(light: &impl LightLobes, limits: &LightLimits) -> Result<(), Report> {
    let (mut run, mut random) = (Run::default(), Random::new(9));
    let bounds = light.bounds();
    run.ensure(
        bounds.radius >= 0.0 && bounds.center.is_finite() && bounds.radius.is_finite(),
        "bounds are a sphere",
        || format!("{bounds:?}"),
    );
    let mut receivers = Vec::new();
    for _ in 0..limits.cases {
        let size = f64::from(bounds.radius).max(1e-3);
        let distance = size * random.log_uniform(1.05, 1e4);
        let position = (bounds.center.as_dvec3() + random.axis() * distance).as_vec3();
        let normal = random.axis().as_vec3().normalize();
        receivers.push(Receiver::on_surface(position, normal, normal));
    }
    for at in &receivers {
        one(light, at, limits, &mut run);
    }
    tiles(light, &receivers, &mut run);
    run.end()
}

fn one(light: &impl LightLobes, at: &Receiver, limits: &LightLimits, run: &mut Run) {
    let SeenLight { cone, radiance, outline } = light.seen_from(at);
    let case = || format!("{cone:?}, radiance {radiance} at {at:?}");
    let length = (f64::from(cone.axis.length()) - 1.0).abs();
    run.within(length, ("", 1e-5), "the cone's axis has length 1", case);
    run.ensure((0.0..=2.0).contains(&cone.one_minus_cos) && cone.distance > 0.0, "the cone is one", case);
    run.ensure(radiance.is_finite() && radiance.min_element() >= 0.0, "radiance is finite and not negative", case);
    let around = Cone::of_sphere(at.position, light.bounds());
    let angle = |cone: &Cone| f64::from(cone.cos()).clamp(-1.0, 1.0).acos();
    let from = |cone: &Cone, v: Vec3| f64::from(cone.axis.angle_between(v));
    let beyond = match &outline {
        None => (from(&around, cone.axis) + angle(&cone) - angle(&around)).max(0.0),
        Some(outline) => {
            let corners = || outline.corners().iter();
            let off = |cone: &Cone| corners().map(|p| from(cone, *p) - angle(cone)).fold(0.0, f64::max);
            run.within(off(&cone), ("beyond", limits.beyond), "the outline lies in the cone", case);
            off(&around)
        }
    };
    run.within(beyond, ("beyond", limits.beyond), "what is seen lies in the bounds", case);
    let mut buffer = LobeBuffer::default();
    light.light_lobes(at, &mut buffer.writer());
    let lobes = || buffer.lobes().iter();
    run.ensure(
        lobes().all(|l| l.flux.is_finite() && l.axis.is_finite() && l.exponent >= 0.0),
        "lobes are finite",
        case,
    );
    let flux: DVec3 = lobes().map(|l| l.flux.as_dvec3()).sum();
    let solid_angle = outline.map_or(TAU * f64::from(cone.one_minus_cos), |outline| f64::from(outline.moments().0));
    let want = radiance.as_dvec3() * solid_angle;
    let error = (flux - want).abs().max_element() / want.max_element().max(1e-30);
    if want.max_element() > 0.0 {
        run.within(error, ("flux", limits.flux), "lobes carry the light's flux", || {
            format!("{flux} for {want}, {}", case())
        });
    }
}

/// The same bits in tiles of any size.
fn tiles(light: &impl LightLobes, receivers: &[Receiver], run: &mut Run) {
    let (mut tile, mut seen) = (Tile::default(), TileLight::default());
    for receivers in receivers.chunks(37) {
        tile.set(receivers);
        light.tile_light(receivers, &tile, &mut seen);
        for (i, at) in receivers.iter().enumerate() {
            // In a tile nothing below the horizon is left.
            let same = seen.seen_by(i) == light.seen_from(at).above(at.normal);
            run.ensure(same, "tiles see what single receivers see", || {
                format!(
                    "{:?} {} for {:?} {} at {at:?}",
                    seen.cone(i),
                    seen.radiance(i),
                    light.cone(at),
                    light.radiance(at)
                )
            });
        }
    }
    let far = Vec3::splat(f32::MAX.sqrt());
    let at = Receiver::on_surface(far, Vec3::Y, Vec3::Y);
    let cone = light.cone(&at);
    run.ensure(cone.axis.is_finite() && cone.one_minus_cos < 1e-3, "from far away it is small", || format!("{cone:?}"));
}
