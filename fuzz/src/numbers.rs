//! Formulas: no NaN, no negative light, and never more than there is.

use crate::bytes::Bytes;
use core::f32::consts::TAU;
use cosine_lobes::brdf::{
    Brdf, HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, ModifiedPhong,
    Neumann, Phong,
};
use cosine_lobes::lobe_core::{
    BrdfLobe, Cone, Lobe, NO_OBJECT, Receiver, cap_integral, power, product_of_angle, products_of_angle,
    sphere_light_irradiance,
};
use cosine_lobes::shading::BrdfLobes;
use cosine_lobes::visibility_mask::{MAX_DEPTH, Mask, UnitSquare};
use glam::{Mat3, Vec3};

/// Of the coaxial value; see the accuracy that [`product_of_angle`] states.
const SLACK: f32 = 2e-3;

pub(crate) fn product(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (mut first, mut second, mut angles) = (Vec::new(), Vec::new(), Vec::new());
    while !bytes.is_empty() {
        let exponent = |bytes: &mut Bytes<'_>| match bytes.byte() % 4 {
            // As far as it is stated to work.
            0 => bytes.any().abs().min(1e18),
            1 => bytes.size(-8.0, 3.0),
            _ => bytes.size(-2.0, 18.0),
        };
        first.push(exponent(&mut bytes));
        second.push(exponent(&mut bytes));
        angles.push(2.0 * bytes.edge());
    }
    let mut many = vec![0.0; first.len()];
    products_of_angle(&first, &second, &angles, &mut many);
    for (k, value) in many.iter().enumerate() {
        let (e1, e2, angle) = (first[k], second[k], angles[k]);
        let one = product_of_angle(e1, e2, angle);
        assert!(one.to_bits() == value.to_bits(), "{e1:e} {e2:e} {angle:e}: {one:e} alone, {value:e} among others");
        check_product(e1, e2, angle, one);
    }
}

/// A product lies between 0 and its value for equal axes.
///
/// # Panics
/// If it does not.
fn check_product(e1: f32, e2: f32, one_minus_cos: f32, value: f32) {
    assert!(value >= 0.0, "{e1:e} {e2:e} {one_minus_cos:e}: {value:e}");
    let coaxial = TAU / (e1 + e2 + 1.0);
    assert!(value <= coaxial * (1.0 + SLACK), "{e1:e} {e2:e} {one_minus_cos:e}: {value:e} of {coaxial:e}");
}

fn receiver(bytes: &mut Bytes<'_>) -> Receiver {
    let normal = bytes.direction();
    let face = if bytes.byte() < 128 { normal } else { (normal + 0.3 * bytes.direction()).normalize() };
    let view = bytes.direction();
    let view = if view.dot(normal) < 0.0 { -view } else { view };
    Receiver { position: Vec3::ZERO, normal, face, view, object: NO_OBJECT }
}

pub(crate) fn cap(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    while !bytes.is_empty() {
        let at = receiver(&mut bytes);
        let exponent = if bytes.byte().is_multiple_of(4) { bytes.any().abs() } else { bytes.size(-6.0, 8.0) };
        let axis = bytes.direction();
        let mut lobe = Lobe::with_flux(axis, exponent, Vec3::ONE);
        let cosine = bytes.byte().is_multiple_of(2);
        if cosine {
            lobe = lobe.times_cosine();
        }
        let cone = Cone { axis: bytes.direction(), one_minus_cos: bytes.edge(), distance: bytes.size(-18.0, 18.0) };
        let value = cap_integral(&at, lobe, &cone);
        // All of the lobe's flux is 1; the cosine takes from it.
        assert!((0.0..=1.006).contains(&value), "{at:?} {lobe:?} {cone:?}: {value:e}");

        let (sin_sq, height) = (bytes.edge(), 2.0 * bytes.edge() - 1.0);
        let light = sphere_light_irradiance(height, sin_sq);
        assert!((0.0..=core::f32::consts::PI * 1.00001).contains(&light), "{height:e} {sin_sq:e}: {light:e}");

        let p = power(axis, bytes.direction(), exponent);
        assert!((0.0..=1.001).contains(&p), "{axis} {exponent:e}: {p:e}");

        // A sphere of any size anywhere, as long as differences are numbers.
        let sphere = cosine_lobes::lobe_core::Sphere { center: anywhere(&mut bytes), radius: bytes.any().abs() };
        let seen = Cone::of_sphere(anywhere(&mut bytes), sphere);
        assert!(!seen.one_minus_cos.is_nan() && seen.one_minus_cos >= 0.0, "{sphere:?}: {seen:?}");
        assert!(seen.axis.is_finite() && (seen.axis.length() - 1.0).abs() < 1e-3, "{sphere:?}: {seen:?}");
    }
}

fn anywhere(bytes: &mut Bytes<'_>) -> Vec3 {
    Vec3::new(bytes.any(), bytes.any(), bytes.any()).clamp(Vec3::splat(-1e38), Vec3::splat(1e38))
}

fn material(bytes: &mut Bytes<'_>) -> Material {
    let color = |bytes: &mut Bytes<'_>| Vec3::new(bytes.edge(), bytes.edge(), bytes.edge());
    let exponent = |bytes: &mut Bytes<'_>| match bytes.byte() % 4 {
        0 => bytes.any(),
        _ => bytes.size(-3.0, 7.0),
    };
    // The last one takes a hundred milliseconds to make.
    match bytes.byte() % 64 {
        0..10 => Lambert { albedo: color(bytes) }.into(),
        10..25 => Phong { kd: color(bytes), ks: color(bytes), exponent: exponent(bytes) }.into(),
        25..32 => Neumann { kd: color(bytes), ks: color(bytes), exponent: exponent(bytes) }.into(),
        32..40 => ModifiedPhong { kd: color(bytes), ks: color(bytes), exponent: exponent(bytes) }.into(),
        40..44 => {
            let lobe = |bytes: &mut Bytes<'_>| HalfVectorLobe::new(bytes.edge(), color(bytes), color(bytes));
            let count = bytes.below(3);
            HalfVector { diffuse: color(bytes), lobes: (0..count).map(|_| lobe(bytes)).collect() }.into()
        }
        44..63 => {
            let lobe = |bytes: &mut Bytes<'_>| match bytes.byte() % 3 {
                0 => LafortuneLobe::new(
                    Mat3::from_cols(bytes.vector(2.0), bytes.vector(2.0), bytes.vector(2.0)),
                    exponent(bytes),
                    color(bytes),
                ),
                1 => LafortuneLobe::diagonal(
                    Vec3::new(bytes.any(), bytes.any(), bytes.any()),
                    exponent(bytes),
                    color(bytes),
                ),
                _ => LafortuneLobe::diagonal(bytes.vector(1.5), exponent(bytes), color(bytes)),
            };
            let count = bytes.below(4);
            Lafortune { diffuse: color(bytes), lobes: (0..count).map(|_| lobe(bytes)).collect() }.into()
        }
        _ => match MetallicRoughness::new(color(bytes), bytes.edge(), bytes.edge()) {
            Ok(model) => model.into(),
            Err(_) => Lambert { albedo: Vec3::ZERO }.into(),
        },
    }
}

pub(crate) fn brdf(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    while !bytes.is_empty() {
        let model = material(&mut bytes);
        if model.validate().is_err() {
            continue;
        }
        let at = receiver(&mut bytes);
        let cone = Cone { axis: bytes.direction(), one_minus_cos: bytes.edge(), distance: 1.0 };
        let mut lobes = Vec::new();
        model.brdf_lobes(&at, &mut lobes);
        model.cosine_lobes(&at, &mut lobes);
        for brdf in lobes {
            // Of microfacets this is the lobe that stands for them.
            let lobe = brdf.cosine_lobe(at.normal);
            let sound = lobe.axis.is_finite() && lobe.exponent >= 0.0 && lobe.scale().min_element() >= 0.0;
            assert!(sound && !lobe.scale().is_nan(), "{model:?} {at:?}: {lobe:?}");
            let is_facets = matches!(brdf, BrdfLobe::Microfacets(_));
            let integral = if is_facets { cap_integral(&at, brdf, &cone) } else { 0.0 };
            assert!((0.0..1.5).contains(&integral), "{model:?} {at:?} {cone:?}: {integral}");
        }
        let v = bytes.direction();
        let value = model.eval(&at, v);
        assert!(!value.is_nan() && value.min_element() >= 0.0, "{model:?} {at:?} {v}: {value}");
        if let Some(drawn) = model.sample(&at, [bytes.unit(), bytes.unit(), bytes.unit()].map(|u| u.min(0.999_999))) {
            let length = drawn.direction.length();
            assert!((length - 1.0).abs() < 1e-3 && drawn.pdf >= 0.0, "{model:?} {at:?}: {drawn:?}");
        }
        assert!(model.pdf(&at, v) >= 0.0, "{model:?} {at:?} {v}");
    }
}

pub(crate) fn mask(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let mut mask = Mask::default();
    while !bytes.is_empty() {
        let cone = Cone { axis: bytes.direction(), one_minus_cos: bytes.edge(), distance: 1.0 };
        let normal = bytes.direction();
        let across = Vec3::new(bytes.any(), bytes.any(), bytes.any());
        let square = UnitSquare::facing(&cone, across).above(normal);
        mask.reset(&square, 1 + bytes.below(MAX_DEPTH), normal);
        let (all, _) = mask.areas();
        for _ in 0..bytes.below(20) {
            let row = bytes.below(mask.side() as u32) as usize;
            let (from, to) = (bytes.any(), bytes.any());
            match bytes.byte() % 3 {
                0 => mask.block_span(row, from, to),
                1 => mask.block_area(row, |y| (from + y, to - y)),
                _ => mask.block_below(bytes.direction()),
            }
        }
        let (emitting, lit) = mask.areas();
        assert!(emitting == all && (0.0..=emitting).contains(&lit), "{square:?}: {lit} of {emitting}, {all} before");
        assert!(!mask.is_lit() || lit == emitting);
        assert!(!mask.is_dark() || lit == 0.0);
    }
}
