//! Materials at their ends, under a light.

use crate::table::Table;
use core::f64::consts::TAU;
use cosine_lobes::brdf::{Brdf, Lafortune, LafortuneLobe, Lambert, Material, ModifiedPhong, Phong};
use cosine_lobes::lobe_core::{Cone, Receiver, Sphere, cap_integral, orthonormal_basis};
use cosine_lobes::shading::BrdfLobes;
use glam::Vec3;

pub(crate) fn reflected(table: &mut Table) {
    Table::head(
        "Radiance reflected from a light of radiance 1, error over the whole of it or 1e-6",
        &["material", "view", "light's half-angle"],
    );
    let lambert = |albedo: f32| -> Material { Lambert { albedo: Vec3::splat(albedo) }.into() };
    let glossy =
        |exponent: f32| -> Material { ModifiedPhong { kd: Vec3::ZERO, ks: Vec3::splat(0.5), exponent }.into() };
    let phong = |exponent: f32| -> Material { Phong { kd: Vec3::ZERO, ks: Vec3::splat(0.5), exponent }.into() };
    let lafortune = |c: Vec3, exponent: f32| -> Material {
        let lobes = vec![LafortuneLobe::diagonal(c, exponent, Vec3::splat(0.5))];
        Lafortune { diffuse: Vec3::ZERO, lobes }.into()
    };
    let materials = [
        ("black", lambert(0.0)),
        ("white", lambert(1.0)),
        ("modified Phong, exponent 0", glossy(0.0)),
        ("modified Phong, 1e-6", glossy(1e-6)),
        ("modified Phong, 100", glossy(100.0)),
        ("modified Phong, 1e5", glossy(1e5)),
        ("modified Phong, 1e7", glossy(1e7)),
        ("Phong as printed, 0", phong(0.0)),
        ("Phong as printed, 100", phong(100.0)),
        ("Lafortune, M ω = 0 from above", lafortune(Vec3::new(-1.0, -1.0, 0.0), 20.0)),
        ("Lafortune, off-specular", lafortune(Vec3::new(-1.0, -1.0, 0.8), 20.0)),
    ];
    for (name, material) in &materials {
        for (view_name, view) in [("from above", Vec3::Z), ("grazing", Vec3::new(1.0, 0.0, 1e-3).normalize())] {
            let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
            for degrees in [1e-4_f64, 6.0, 40.0] {
                // Above the horizon, where a mirror sees it.
                let theta = degrees.to_radians();
                let height = if view.z < 0.5 { 1.01 * theta } else { core::f64::consts::FRAC_PI_2 };
                let toward = Vec3::new(-height.cos() as f32, 0.0, height.sin() as f32).normalize();
                let sphere = Sphere { center: toward * 10.0, radius: (10.0 * theta.sin()) as f32 };
                let cone = Cone::of_sphere(Vec3::ZERO, sphere);
                let (got, want) = (by_lobes(material, &at, &cone), by_quadrature(material, &at, &cone));
                let words = [(*name).to_owned(), view_name.to_owned(), format!("{degrees}°")];
                table.row(&words, got, want, want.max(1e-6), 1e-2);
            }
        }
    }
}

fn by_lobes(material: &Material, at: &Receiver, cone: &Cone) -> f32 {
    let mut lobes = Vec::new();
    material.cosine_lobes(at, &mut lobes);
    lobes.into_iter().map(|lobe| cap_integral(at, lobe, cone) * lobe.flux().x).sum()
}

/// The model itself, summed over the light in f64.
fn by_quadrature(material: &Material, at: &Receiver, cone: &Cone) -> f64 {
    const SIDE: u32 = 2500;
    let (right, up) = orthonormal_basis(cone.axis);
    let (axis, right, up) = (cone.axis.as_dvec3(), right.as_dvec3(), up.as_dvec3());
    let wide = f64::from(cone.one_minus_cos);
    let mut sum = 0.0;
    for i in 0..SIDE {
        // Steps of 1 − cos that are finer towards the middle, where a mirror has all of its light.
        let t = (f64::from(i) + 0.5) / f64::from(SIDE);
        let (off, step) = (wide * t.powi(3), 3.0 * t.powi(2));
        let (cos, sin) = (1.0 - off, (off * (2.0 - off)).sqrt());
        for j in 0..SIDE {
            let phi = (f64::from(j) + 0.5) / f64::from(SIDE) * TAU;
            let v = axis * cos + (right * phi.cos() + up * phi.sin()) * sin;
            sum += step * f64::from(material.eval(at, v.as_vec3()).x);
        }
    }
    sum * TAU * wide / f64::from(SIDE * SIDE)
}
