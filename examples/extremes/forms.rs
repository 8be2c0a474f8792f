//! The closed forms.

use crate::table::Table;
use core::f32::consts::{FRAC_PI_2, PI};
use cosine_lobes::lobe_core::oracle::{self, CapLobe};
use cosine_lobes::lobe_core::{Cone, Lobe, Receiver, cap_integral, power, product_of_angle, sphere_light_irradiance};
use glam::{DVec3, Vec3};

/// Angles as `1 − cos`, and their name.
fn angles() -> [(&'static str, f32); 7] {
    let chord = |x: f64| (2.0 * (0.5 * x).sin().powi(2)) as f32;
    let ulp = f64::from(f32::EPSILON);
    let half = f64::from(FRAC_PI_2);
    [
        ("0", 0.0),
        ("1e-7", chord(1e-7)),
        ("1", chord(1.0)),
        ("π/2 − ulp", chord(half - ulp)),
        ("π/2 + ulp", chord(half + ulp)),
        ("3", chord(3.0)),
        ("π", 2.0),
    ]
}

pub(crate) fn products(table: &mut Table) {
    Table::head("Product of two lobes, error of the coaxial value", &["e₁", "e₂", "α"]);
    for e1 in [0.0_f32, 1e-6, 0.5, 1.0, 1e5, 1e7] {
        for e2 in [0.0_f32, 1.0, 1e5] {
            for (name, one_minus_cos) in angles() {
                let angle = 2.0 * (0.5 * f64::from(one_minus_cos)).sqrt().min(1.0).asin();
                let want = oracle::product(f64::from(e1), f64::from(e2), angle);
                let coaxial = core::f64::consts::TAU / (f64::from(e1) + f64::from(e2) + 1.0);
                let words = [format!("{e1:e}"), format!("{e2:e}"), name.to_owned()];
                table.row(&words, product_of_angle(e1, e2, one_minus_cos), want, coaxial, 2e-3);
            }
        }
    }
}

pub(crate) fn powers(table: &mut Table) {
    Table::head("Power of a cosine, relative error over 1 + its logarithm", &["e", "angle"]);
    for e in [0.0_f32, 1e-6, 0.5, 1.0, 1e5, 1e7, 1e30, f32::INFINITY] {
        for angle in [0.0_f32, 1e-7, 1e-3, 1.0, FRAC_PI_2 + 1e-6, PI] {
            let v = Vec3::new(angle.sin(), 0.0, angle.cos());
            // For the rounded vectors.
            let cos = 1.0 - 0.5 * (Vec3::Z.as_dvec3() - v.as_dvec3()).length_squared();
            let want = match e {
                _ if cos <= 0.0 => 0.0,
                f32::INFINITY => f64::from(u8::from(v == Vec3::Z)),
                e => (f64::from(e) * (cos - 1.0).ln_1p()).exp(),
            };
            let scale = want.max(1e-37) * (1.0 + want.max(1e-37).ln().abs());
            table.row(&[format!("{e:e}"), format!("{angle:e}")], power(Vec3::Z, v, e), want, scale, 2e-5);
        }
    }
}

pub(crate) fn irradiances(table: &mut Table) {
    Table::head("Sphere light on a Lambert receiver, relative error", &["radius/distance", "height of the centre"]);
    for sin in [0.0_f32, 1e-6, 1e-4, 1e-2, 0.5, 0.999, 1.0] {
        for (name, height) in [
            ("above", None),
            ("touches the horizon", Some(1.0_f32)),
            ("half below", Some(0.0)),
            ("a tenth of the radius below", Some(-0.1)),
            ("all but a thousandth below", Some(-0.999)),
            ("below", Some(-1.5)),
        ] {
            let (sin_sq, cos_beta) = (sin * sin, height.map_or(0.5_f32.sqrt().max(sin), |h| (h * sin).max(-1.0)));
            let s = f64::from(sin_sq).sqrt();
            let want = if sin == 0.0 { 0.0 } else { oracle::sphere_light_irradiance(f64::from(cos_beta), s.asin()) };
            let words = [format!("{sin:e}"), name.to_owned()];
            table.row(&words, sphere_light_irradiance(cos_beta, sin_sq), want, want.max(1e-30), 1e-5);
        }
    }
}

pub(crate) fn caps(table: &mut Table) {
    Table::head(
        "Lobe over a light, error of the on-axis value",
        &["e", "1 − cos θ", "lobe's axis", "light above the horizon"],
    );
    for e in [0.0_f32, 1e-6, 0.5, 1.0, 20.0, 1e5, 1e7] {
        for one_minus_cos in [1e-12_f32, 1e-4, 0.3, 1.0] {
            let theta = 2.0 * (0.5 * f64::from(one_minus_cos)).sqrt().asin();
            for (axis_name, off) in
                [("its centre", 0.0), ("its rim", theta), ("π/2 beside", core::f64::consts::FRAC_PI_2)]
            {
                for (name, elevation) in [("all", core::f64::consts::FRAC_PI_2), ("half", 0.0), ("none", -1.01 * theta)]
                {
                    if name == "none" && one_minus_cos == 1.0 {
                        continue;
                    }
                    let normal = DVec3::Z;
                    let light = DVec3::new(elevation.cos(), 0.0, elevation.sin()).as_vec3().normalize();
                    let aside = DVec3::Y;
                    let axis = (light.as_dvec3() * off.cos() + aside * off.sin()).as_vec3().normalize();
                    let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), Vec3::Z);
                    let cone = Cone { axis: light, one_minus_cos, distance: 1.0 };
                    let truth =
                        CapLobe { axis: axis.as_dvec3().normalize(), exponent: f64::from(e), cosine: false, normal };
                    let n = f64::from(e) + 1.0;
                    let integral = oracle::cap(&truth, light.as_dvec3().normalize(), theta);
                    let want = integral * n / core::f64::consts::TAU;
                    let on_axis = -(n * (-f64::from(one_minus_cos)).ln_1p()).exp_m1();
                    let got = cap_integral(&at, Lobe::with_flux(axis, e, Vec3::ONE), &cone);
                    // f32 knows n·l, and a lobe's edge, to 2e-7.
                    let stated = if e < 1.0 { 6e-3 } else { 3e-3 };
                    let limit = stated + 2e-7 / theta.sin();
                    let words = [format!("{e:e}"), format!("{one_minus_cos:e}"), axis_name.to_owned(), name.to_owned()];
                    table.row(&words, got, want, on_axis, limit);
                }
            }
        }
    }
}
