//! Spheres in all positions before a light.

use crate::table::Table;
use core::f64::consts::TAU;
use cosine_lobes::lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use cosine_lobes::shading::{Accuracy, LightId, LightVisibility, Visibility};
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::{DVec3, Vec3};

const LIGHT: Sphere = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.5 };

fn sphere(x: f32, y: f32, radius: f32) -> Sphere {
    Sphere { center: Vec3::new(x, y, 0.0), radius }
}

pub(crate) fn visible(table: &mut Table) {
    Table::head("Visible fraction of a diffuse light behind spheres", &["blockers"]);
    // The light's edge is at x = 0.5·y/√(25 − 0.25).
    let edge = |y: f32| 0.5 * y / (25.0_f32 - 0.25).sqrt();
    let touching = |y: f32, radius: f32| {
        let tan = 0.5 / (25.0_f32 - 0.25).sqrt();
        sphere(edge(y) + radius * (1.0 + tan * tan).sqrt(), y, radius)
    };
    let crowd = |count: u32| -> Vec<Sphere> {
        (0..count)
            .map(|k| {
                let (r, turn) = (0.4 * (k as f32 / count as f32).sqrt(), 2.399_963 * k as f32);
                let radius = 0.12 / (count as f32).sqrt();
                Sphere { center: Vec3::new(r * turn.cos(), 2.5, r * turn.sin()), radius }
            })
            .collect()
    };
    for (name, spheres) in [
        ("none", vec![]),
        ("before the middle", vec![sphere(0.0, 2.5, 0.1)]),
        ("half-way over the edge", vec![sphere(edge(2.5), 2.5, 0.1)]),
        ("tangent to the cone from outside", vec![touching(2.5, 0.1)]),
        ("larger than the light", vec![sphere(0.0, 2.5, 0.6)]),
        ("contains the receiver", vec![sphere(0.0, 0.0, 0.3)]),
        ("contains the light", vec![sphere(0.0, 5.0, 0.7)]),
        ("behind the light", vec![sphere(0.0, 7.0, 0.4)]),
        ("beside the light, as far", vec![sphere(1.2, 5.0, 0.4)]),
        ("half-way into the light", vec![sphere(0.0, 4.5, 0.3)]),
        ("radius 0", vec![sphere(0.0, 2.5, 0.0)]),
        ("radius 1e-6", vec![sphere(0.0, 2.5, 1e-6)]),
        ("near to the receiver, radius 1e-4", vec![sphere(0.0, 1e-3, 1e-4)]),
        ("two identical ones", vec![sphere(0.05, 2.5, 0.1); 2]),
        ("1000 identical ones", vec![sphere(0.05, 2.5, 0.1); 1000]),
        ("1000 in a disc", crowd(1000)),
        ("1e5 in a disc", crowd(100_000)),
    ] {
        // A sphere in the light hides nothing of it that the receiver could see.
        let (got, want) = (fraction(&spheres), truth(&spheres));
        table.row(&[name.to_owned()], got, want, 1.0, 5e-3);
    }
}

fn fraction(spheres: &[Sphere]) -> f32 {
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    let visibility = MaskVisibility::new(SphereBlockers::new(spheres, &vec![0; spheres.len()], &[]));
    let (cone, lobe) = (Cone::of_sphere(at.position, LIGHT), Lobe::new(Vec3::Y, 1.0, Vec3::ONE));
    let mut scratch = visibility.scratch();
    let mut visit = LightVisibility::alone(&visibility, LightId(0), Accuracy::new(0.001), &mut scratch);
    let unshadowed = cap_integral(&at, lobe, &cone);
    visit.visible_fraction(&at, &cone, &lobe, unshadowed).x
}

/// By rays to the light's disc in f64, weighted with the cosine.
fn truth(spheres: &[Sphere]) -> f64 {
    const SIDE: u32 = 600;
    let (distance, radius) = (f64::from(LIGHT.center.y), f64::from(LIGHT.radius));
    let sin_sq = (radius / distance).powi(2);
    let (mut lit, mut all) = (0.0, 0.0);
    let many = spheres.len() > 2000;
    for i in 0..SIDE {
        // Equal steps of the squared sine are equal weights of the cosine.
        let s = ((f64::from(i) + 0.5) / f64::from(SIDE) * sin_sq).sqrt();
        for j in (0..SIDE).step_by(if many { 20 } else { 1 }) {
            let phi = (f64::from(j) + 0.5) / f64::from(SIDE) * TAU;
            let v = DVec3::new(s * phi.cos(), (1.0 - s * s).sqrt(), s * phi.sin());
            // To the circle in which the receiver's tangents touch the light.
            let end = (distance * distance - radius * radius) / distance / v.y;
            let hides = |sphere: &Sphere| {
                let (c, r) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
                let t = c.dot(v).clamp(0.0, end);
                r > 0.0 && (c - v * t).length() < r
            };
            all += 1.0;
            lit += f64::from(u8::from(!spheres.iter().any(hides)));
        }
    }
    lit / all
}
