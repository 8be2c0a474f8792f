//! The cones of spheres, and the spheres in which objects look for shadows of their own.

use crate::*;
use glam::{Mat4, Quat, Vec3};

#[test]
fn even_scales() {
    let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(2.1);
    let place = |scale: Vec3| Mat4::from_scale_rotation_translation(scale, turn, Vec3::new(5.0, -1.0, 3.0));
    for scale in [1e-6, 0.3, 1.0, 2e6] {
        let even = place(Vec3::splat(scale));
        assert!(scales_evenly(&even, f64::from(scale), 1e-4), "{scale}");
        assert!(scales_evenly(&place(Vec3::new(-scale, scale, scale)), f64::from(scale), 1e-4), "mirrored, {scale}");
        assert!(!scales_evenly(&even, 1.001 * f64::from(scale), 1e-4), "another scale than {scale}");
        assert!(!scales_evenly(&place(Vec3::new(1.0, 1.001, 1.0) * scale), f64::from(scale), 1e-4), "{scale}");
        assert!(scales_evenly(&place(Vec3::new(1.0, 1.001, 1.0) * scale), f64::from(scale), 2e-3), "{scale}");
        let mut skew = even;
        skew.y_axis += skew.x_axis * 0.002;
        assert!(!scales_evenly(&skew, f64::from(scale), 1e-3), "skew, {scale}");
    }
    assert!(!scales_evenly(&(Mat4::IDENTITY * f32::NAN), 1.0, 1.0));
}

#[test]
fn cones_of_all_spheres() {
    let x = Vec3::new(1.0, -2.0, 0.5);
    for d in [0.0_f32, 1e-38, 1e-30, 1e-12, 1e-3, 1.0, 1e6, 1e15, 1e19, 3e25, 2e38] {
        for ratio in [0.0_f32, 1e-30, 1e-6, 0.5, 1.0 - 6e-8, 1.0, 1.0 + 1e-6, 2.0, 1e6] {
            for x in [Vec3::ZERO, x] {
                let center = x + Vec3::new(0.6, 0.0, 0.8) * d;
                let cone = Cone::of_sphere(x, Sphere { center, radius: d * ratio });
                assert!((cone.axis.length() - 1.0).abs() < 1e-5, "{d} {ratio}: {cone:?}");
                if d > 0.0 && (x == Vec3::ZERO || d > 1e6) {
                    assert!(cone.axis.distance(Vec3::new(0.6, 0.0, 0.8)) < 1e-5, "{d} {ratio}: {cone:?}");
                    assert!((cone.distance / d - 1.0).abs() < 1e-5, "{d} {ratio}: {cone:?}");
                }
                assert!((0.0..=2.0).contains(&cone.one_minus_cos) && cone.distance >= 0.0, "{d} {ratio}: {cone:?}");
                assert!(cone.sin_sq() >= 0.0 && cone.solid_angle() >= 0.0);
                if ratio == 0.0 {
                    assert_eq!(cone.one_minus_cos, 0.0, "a point at {d} has no width");
                }
                let lobe = cone_lobe(&cone);
                assert!(lobe.exponent >= 0.0 && !lobe.flux.is_nan(), "{lobe:?}");
            }
        }
    }
    // sin θ = r/d also where 1 − cos θ is far below an ulp of 1.
    let cone = Cone::of_sphere(Vec3::ZERO, Sphere { center: Vec3::Z, radius: 1e-6 });
    assert!((f64::from(cone.one_minus_cos) / 5e-13 - 1.0).abs() < 1e-6);
}

/// From the near sphere to the whole one, continuous, always inside the whole one and around the near one.
#[test]
fn the_own_sphere_grows_with_the_distance() {
    use crate::{SelfShadow, Sphere};
    let whole = Sphere { center: Vec3::X, radius: 2.0 };
    let own = SelfShadow { offset: Vec3::new(0.0, 0.5, 0.25), radius: 0.25, distance: 0.1 };
    let near = own.near(whole.radius);
    assert_eq!(near, Sphere { center: Vec3::new(0.0, 1.0, 0.5), radius: 0.5 });
    let at = |d: f32| SelfShadow::seen(whole, near, Vec3::new(1.0, 0.0, d));
    assert_eq!([0.0, 1.0, 2.0].map(at), [Sphere { center: whole.center + near.center, ..near }; 3]);
    assert_eq!(at(4.0), Sphere { center: Vec3::new(1.0, 0.5, 0.25), radius: 1.25 });
    assert_eq!(at(f32::INFINITY), whole);
    let inside = |a: Sphere, b: Sphere| a.center.distance(b.center) + a.radius <= b.radius * 1.000_001;
    let spheres: Vec<Sphere> = (0..1000).map(|k| at(0.01 * k as f32)).collect();
    assert!(spheres.iter().all(|sphere| inside(at(0.0), *sphere) && inside(*sphere, whole)));
    assert!(spheres.windows(2).all(|b| (0.0..0.01).contains(&(b[1].radius - b[0].radius)) && inside(b[0], b[1])));
    for (radius, share, d) in [(0.0, 0.0, 0.0), (f32::MAX, 0.0, 0.0), (1e-45, 0.0, 1e-45), (f32::MAX, 1.0, f32::MAX)] {
        let whole = Sphere { center: Vec3::ZERO, radius };
        let near = SelfShadow { radius: share, ..SelfShadow::whole(0.0) }.near(radius);
        let sphere = SelfShadow::seen(whole, near, Vec3::X * d);
        assert!(
            (0.0..=radius).contains(&sphere.radius) && sphere.center.is_finite(),
            "{radius} {share} {d}: {sphere:?}"
        );
    }
}

/// Numbers out of range are clamped, and turns keep them in range.
#[test]
fn own_spheres_stay_inside() {
    use crate::SelfShadow;
    let given = |x: f32, radius, distance| SelfShadow { offset: Vec3::X * x, radius, distance }.sound();
    assert_eq!(given(0.3, 0.5, 1.0), SelfShadow { offset: Vec3::X * 0.3, radius: 0.5, distance: 1.0 });
    assert_eq!(given(3.0, 0.5, -1.0), SelfShadow { offset: Vec3::X * 0.5, radius: 0.5, distance: 0.0 });
    assert_eq!(given(f32::NAN, f32::NAN, f32::NAN), SelfShadow::whole(0.0));
    assert_eq!(given(1.0, 7.0, 2.0), SelfShadow::whole(2.0));
    let own = given(0.5, 0.5, 1.0);
    let quarter = glam::Mat3::from_rotation_z(core::f32::consts::FRAC_PI_2);
    assert!(own.turned(quarter * 7.0).offset.distance(Vec3::Y * 0.5) < 1e-6);
    for flat in [glam::Mat3::ZERO, glam::Mat3::NAN, glam::Mat3::IDENTITY * 1e38, glam::Mat3::IDENTITY * 1e-42] {
        let turned = own.turned(flat);
        assert!(turned.offset.length() <= 0.500_001 && turned.radius == 0.5, "{turned:?}");
    }
}
