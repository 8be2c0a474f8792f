//! A receiver, a light and a soup between them.

use super::{Rays, Soup, cuboid, globe};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use shading::{Accuracy, LightId, LightVisibility, Visibility};
use visibility_mask::MaskVisibility;
use visibility_silhouettes::{SilhouetteBlockers, SilhouetteMesh};

pub(crate) const EXPONENTS: [f64; 6] = [1.0, 3.0, 20.0, 200.0, 2000.0, 50_000.0];
/// A receiver at the origin, a light at the distance 10, and triangles between them. Stored in f64 until it is used.
#[derive(Clone, Debug)]
pub(crate) struct Moment {
    pub(crate) position: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) light: DVec3,
    pub(crate) radius: f64,
    pub(crate) soup: Soup,
    pub(crate) moved: DVec3,
    /// Axis and exponent; exponent 1 around the normal is Lambert.
    pub(crate) lobe: (DVec3, f64),
    pub(crate) tolerance: f32,
}

impl Moment {
    pub(crate) fn random(random: &mut Random, kind: usize, theta: f64, exponent: f64, tolerance: f32) -> Self {
        let axis = random.axis();
        let tilt = random.between(0.0, (1.5 - theta).max(0.0));
        let normal = random.axis_at(axis, tilt);
        let distance = random.between(2.0, 5.0);
        let size = (theta * random.log_uniform(0.3, 4.0)).min(1.0) * 0.7 * distance;
        let aside = random.between((size / distance - theta).max(0.0), size / distance + theta).min(1.2);
        let center = (random.axis_at(axis, aside) * distance).as_vec3();
        let soup = match kind {
            0 => globe(center, size as f32, 4),
            1 => globe(center, size as f32, 10),
            2 => cuboid(random, center, size),
            // Edges at right angles, across the light: either one runs along the rows or all of them are slanted.
            _ => {
                let u = random.axis().cross(axis).normalize();
                let (u, v) = ((u * size).as_vec3(), (u.cross(axis) * size).as_vec3());
                let positions = vec![center - u - v, center + u - v, center + u + v, center - u + v];
                Soup { positions, triangles: vec![[0, 1, 2], [0, 2, 3]] }
            }
        };
        let off = random.between(0.0, (theta + 1.5 / exponent.sqrt()).min(1.0));
        let lobe = (if exponent == 1.0 { normal } else { random.axis_at(axis, off) }, exponent);
        let (light, radius) = (axis * 10.0, 10.0 * theta.sin());
        Self { position: DVec3::ZERO, normal, light, radius, soup, moved: DVec3::ZERO, lobe, tolerance }
    }

    /// The moment at `t` of a motion in which everything moves by less than a third of the light's visible size.
    pub(crate) fn moved(&self, kind: usize, direction: DVec3, t: f64) -> Self {
        let theta = (self.radius / 10.0).asin();
        let t = 0.3 * (t - 0.5) * theta.min(3.0 / self.lobe.1.sqrt());
        let mut new = self.clone();
        match kind {
            0 => new.lobe.0 = (self.lobe.0 + direction * t).normalize(),
            1 => new.moved = direction * (3.0 * t),
            2 => new.light += direction * (10.0 * t),
            3 => new.position = direction * (2.0 * t),
            _ => new.normal = (self.normal + direction * t).normalize(),
        }
        if self.lobe.1 == 1.0 {
            new.lobe.0 = new.normal;
        }
        new
    }

    /// The visible fraction of the light through the lobe, and its weight: 1 from a hundredth of the lobe's possible radiance on.
    pub(crate) fn fraction(&self) -> (f64, f64) {
        let normal = self.normal.as_vec3().normalize();
        let at = Receiver::on_surface(self.position.as_vec3(), normal, normal);
        let cone = Cone::of_sphere(at.position, Sphere { center: self.light.as_vec3(), radius: self.radius as f32 });
        let axis = if self.lobe.1 == 1.0 { normal } else { self.lobe.0.as_vec3().normalize() };
        let lobe = Lobe { exponent: self.lobe.1 as f32, flux: Vec3::ONE, axis, has_cosine: false };
        let mut soup = self.soup.clone();
        soup.positions.iter_mut().for_each(|p| *p = (p.as_dvec3() + self.moved).as_vec3());
        let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
        let blockers = SilhouetteBlockers::new(&meshes, Rays(&soup));
        let strategy = MaskVisibility::new(blockers);
        let mut scratch = strategy.scratch();
        let unshadowed = cap_integral(&at, lobe, &cone);
        let mut visit = LightVisibility::alone(&strategy, LightId(0), Accuracy::new(self.tolerance), &mut scratch);
        let fraction = visit.visible_fraction(&at, &cone, &lobe, unshadowed).x;
        let on_axis = 1.0 - ((self.lobe.1 + 1.0) * f64::from(cone.cos()).ln()).exp();
        (f64::from(fraction), (100.0 * f64::from(unshadowed) / on_axis).min(1.0))
    }
}
