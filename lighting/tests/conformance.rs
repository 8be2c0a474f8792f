//! Every kind of light keeps the promises of `LightLobes`.

use conformance::{LightLimits, check_light};
use core::f32::consts::{PI, TAU};
use glam::{DVec3, Mat4, Quat, UVec2, Vec3};
use lighting::{
    Environment, EnvironmentError, EnvironmentMap, FlatLight, FlatLightError, Light, LightKind as _, SkyLight,
    SphereLight, SpotLight, SunLight, TubeLight,
};
use lobe_core::{Cone, LightImage, Lobe, Random, Receiver, Sphere, cap_integral, image_integral, outline_integral};
use shading::LightLobes;
use std::sync::Arc;

const COLOR: Vec3 = Vec3::new(3.0, 2.0, 1.0);

fn at(position: Vec3) -> Receiver {
    Receiver::on_surface(position, Vec3::Y, Vec3::Y)
}

fn rectangle() -> FlatLight {
    FlatLight::rectangle(Vec3::new(0.5, 3.0, -1.0), Vec3::new(1.0, 0.2, 0.0), Vec3::Z * 0.1, COLOR)
        .expect("a rectangle")
}

fn tube() -> TubeLight {
    TubeLight { ends: [Vec3::new(-1.0, 2.0, 0.0), Vec3::new(1.0, 2.5, 0.5)], radius: 0.1, radiance: COLOR }
}

#[test]
fn all_kinds_conform() {
    let limits = LightLimits::default();
    let bulb = Sphere { center: Vec3::new(0.0, 4.0, 0.0), radius: 0.5 };
    let sphere = SphereLight::new(bulb, COLOR);
    check_light(&sphere, &limits).expect("a sphere");
    check_light(&SpotLight { light: sphere, axis: Vec3::NEG_Y, cos: [0.9, 0.7], range: 9.0 }, &limits).expect("a spot");
    check_light(&rectangle(), &limits).expect("a rectangle");
    check_light(&rectangle().on_both_sides(), &limits).expect("a rectangle of two sides");
    // Its corners are those of a polygon around it.
    let disc = FlatLight::disc(Vec3::Y, Vec3::new(1.0, -1.0, 0.3), 0.7, COLOR).expect("a disc");
    check_light(&disc, &LightLimits { beyond: 0.02, ..limits }).expect("a disc");
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.5, 0.8, 0.0), Vec3::new(0.3, 1.0, 0.0)];
    let polygon = FlatLight::polygon(&corners, COLOR).expect("a polygon").on_both_sides();
    check_light(&polygon, &limits).expect("a polygon");
    check_light(&Light::from(polygon), &limits).expect("any light");
    let (image, _) = LightImage::new(UVec2::new(2, 1), &[Vec3::ONE, Vec3::X]).expect("an image");
    let right = FlatLight::rectangle(Vec3::Y * 2.0, Vec3::X, Vec3::Z * 0.4, COLOR).expect("a rectangle");
    check_light(&right.showing(Arc::new(image)).expect("right angles"), &limits).expect("a screen");
    // Its outline is that of a capsule in one plane: its ends reach beyond the sphere around it by a little.
    check_light(&tube(), &LightLimits { beyond: 0.2, ..limits }).expect("a tube");
}

const WORLD: Sphere = Sphere { center: Vec3::ZERO, radius: 3.0 };

/// A sky that is brighter above, with a warm side, dark ground, and a sun of half-angle 1.5° if `sun` is its radiance.
fn sky(sun: f32) -> EnvironmentMap {
    let size = UVec2::new(256, 128);
    let blank = EnvironmentMap::new(size, vec![Vec3::ZERO; 256 * 128]).expect("a picture");
    let toward = Vec3::new(0.5, 0.6, 0.62).normalize();
    let texels = (0..size.x * size.y).map(|k| {
        let d = blank.direction((k % size.x) as f32 + 0.5, (k / size.x) as f32 + 0.5);
        let ground = if d.y < 0.0 { 0.2 } else { 1.0 };
        let glow = ((d.dot(toward) - 1.0) * 20.0).exp();
        let sun = if d.dot(toward) > 1.5_f32.to_radians().cos() { sun } else { 0.0 };
        (Vec3::new(0.3, 0.5, 0.9) * (0.6 + 0.4 * d.y) + Vec3::new(2.0, 1.5, 0.8) * glow) * ground + Vec3::splat(sun)
    });
    EnvironmentMap::new(size, texels.collect()).expect("a picture")
}

/// Radiance of the lights of an environment without blockers.
fn unshadowed(lights: &[Light], at: &Receiver, lobe: &Lobe) -> Vec3 {
    lights
        .iter()
        .map(|light| {
            let term = light.seen_from(at);
            let integral = match (&term.outline, light.image()) {
                (None, _) => Vec3::splat(cap_integral(at, lobe, &term.cone)),
                (Some(outline), None) => Vec3::splat(outline_integral(at, lobe, outline)),
                (Some(outline), Some(image)) => image_integral(at, lobe, outline, image),
            };
            term.radiance * integral
        })
        .sum()
}

/// Suns and patches give what the picture gives, by quadrature of all of it.
#[test]
fn environments_are_their_pictures() {
    for (sun, across, limit) in
        [(0.0, 1, [0.01, 0.01]), (0.0, 2, [0.003, 0.005]), (0.0, 4, [0.001, 0.004]), (900.0, 2, [0.003, 0.005])]
    {
        let environment = Environment::new(sky(sun), across, WORLD);
        let map = environment.map();
        let suns = environment.lights().iter().filter(|l| matches!(l, Light::Sky(SkyLight::Sun(_)))).count();
        assert_eq!(suns, usize::from(sun > 0.0));
        let mut worst = [0.0_f32; 3];
        for k in 0..16 {
            let turn = Quat::from_rotation_y(k as f32) * Quat::from_rotation_x(0.4 * k as f32);
            let normal = turn * Vec3::Y;
            let at = Receiver { normal, face: normal, view: normal, ..at(Vec3::ZERO) };
            let lobes = [
                Lobe::new(normal, 1.0, Vec3::ONE),
                Lobe::new((normal + 0.5 * (turn * Vec3::X)).normalize(), 30.0, Vec3::ONE).times_cosine(),
                Lobe::new((normal + 0.3 * (turn * Vec3::Z)).normalize(), 400.0, Vec3::ONE),
            ];
            for (worst, lobe) in worst.iter_mut().zip(lobes) {
                let (axis, e) = (lobe.axis.as_dvec3(), f64::from(lobe.exponent));
                let mut want = DVec3::ZERO;
                let size = map.size();
                // Two by two points a texel.
                for y in 0..2 * size.y {
                    let solid = map.solid_angle(y / 2) / 4.0;
                    for x in 0..2 * size.x {
                        let v = map.direction((x as f32 + 0.5) / 2.0, (y as f32 + 0.5) / 2.0);
                        let (along, above) = (axis.dot(v.as_dvec3()), f64::from(normal.dot(v)));
                        if along > 0.0 && above > 0.0 {
                            let cosine = if lobe.has_cosine { above } else { 1.0 };
                            let weight = along.powf(e) * cosine * f64::from(solid);
                            want += map.radiance(v).as_dvec3() * weight;
                        }
                    }
                }
                let want = (want * (e + 1.0) / core::f64::consts::TAU).as_vec3();
                let got = unshadowed(environment.lights(), &at, &lobe);
                *worst = worst.max((got - want).abs().max_element() / want.max_element().max(0.1));
            }
        }
        println!("sun {sun}, {across} patches across: worst {worst:?}");
        // The third lobe is about as narrow as a texel of the patches.
        assert!(
            worst[0] < limit[0] && worst[1] < limit[1] && worst[2] < 0.025,
            "sun {sun}, {across} patches across: {worst:?}"
        );
    }
}

#[test]
fn pictures_of_all_directions() {
    let map = sky(0.0).turned(Vec3::Z, 30.0).scaled(Vec3::new(2.0, 1.0, 1.0));
    for (x, y) in [(0.5, 0.5), (100.2, 30.7), (255.5, 127.5), (128.0, 64.0)] {
        let place = map.place(map.direction(x, y)) * map.size().as_vec2();
        assert!((place - glam::Vec2::new(x, y)).abs().max_element() < 1e-2, "{x} {y} {place}");
    }
    // Its top is toward +z.
    assert!(map.radiance(Vec3::Z).z > 0.85 && map.radiance(Vec3::NEG_Z).z < 0.1);
    let solid: f32 = (0..128).map(|y| map.solid_angle(y) * 256.0).sum();
    assert!((solid - 4.0 * PI).abs() < 1e-4);

    let picture = |texels: Vec<Vec3>| EnvironmentMap::new(UVec2::new(2, 1), texels);
    assert_eq!(picture(vec![Vec3::ONE]), Err(EnvironmentError::Size));
    assert_eq!(picture(vec![Vec3::ONE, Vec3::NAN]), Err(EnvironmentError::NotANumber { x: 1, y: 0 }));
    let bright = picture(vec![Vec3::INFINITY, Vec3::splat(-3.0)]).expect("a picture");
    assert_eq!(bright.texels(), [Vec3::splat(EnvironmentMap::BRIGHTEST), Vec3::ZERO]);
    // Nothing in it is a sun.
    assert_eq!(Environment::new(bright, 1, WORLD).lights().len(), 6);
    assert!(Environment::new(EnvironmentMap::uniform(Vec3::ZERO), 2, WORLD).lights().is_empty());
}

/// A sun of a few pixels keeps its light, however bright it is.
#[test]
fn bright_pixels_keep_their_light() {
    let (width, height) = (128, 64);
    for (radiance, across) in [(1e3_f32, 1), (1e5, 1), (2e6, 1), (1e9, 2)] {
        let is_sun = |i: u32| i % width / across == 40 / across && i / width / across == 14 / across;
        let texel = |i: u32| Vec3::splat(if is_sun(i) { radiance } else { 1.0 });
        let map = EnvironmentMap::new(UVec2::new(width, height), (0..width * height).map(texel).collect());
        let map = map.expect("a picture");
        let want: f64 = (0..width * height)
            .filter(|i| is_sun(*i))
            .map(|i| f64::from(radiance - 1.0) * f64::from(map.solid_angle(i / width)))
            .sum();
        let got: f64 = Environment::new(map, 1, WORLD)
            .lights()
            .iter()
            .filter_map(|light| match light {
                Light::Sky(SkyLight::Sun(sun)) => {
                    let one_minus_cos = 1.0 - (1.0 - f64::from(sun.sin).powi(2)).sqrt();
                    Some(f64::from(sun.radiance.x) * core::f64::consts::TAU * one_minus_cos)
                }
                _ => None,
            })
            .sum();
        assert!((got / want - 1.0).abs() < 2e-3, "{radiance}: {got} for {want}");
    }
}

/// An outline that loses or adds area of the light shows in the flux that passes a far away sphere.
#[test]
fn flux_is_that_of_the_surface() {
    let flux = |light: &Light| {
        let (count, radius) = (40_000, 50.0_f64);
        let golden = core::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let mean = (0..count).map(|k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
            let (sin, cos) = (f64::from(k) * golden).sin_cos();
            let aside = (1.0 - z * z).sqrt();
            let outward = glam::DVec3::new(aside * cos, aside * sin, z);
            let at = Receiver { normal: -outward.as_vec3(), ..at((outward * radius).as_vec3()) };
            // Irradiance: all of it is near the middle of the sky.
            light.outline(&at).map_or(0.0, |o| f64::from(o.moments().1.dot(at.normal)))
                * f64::from(light.radiance(&at).x)
        });
        4.0 * core::f64::consts::PI * radius * radius * mean.sum::<f64>() / f64::from(count)
    };
    let power = Vec3::splat(7.0);
    let disc = FlatLight::disc(Vec3::ZERO, Vec3::new(1.0, -1.0, 0.3), 0.7, COLOR).expect("a disc");
    let lights = [
        Light::from(rectangle().with_flux(power)),
        rectangle().on_both_sides().with_flux(power).into(),
        disc.with_flux(power).into(),
        tube().with_flux(power).into(),
    ];
    for light in lights {
        let got = flux(&light);
        assert!((got / 7.0 - 1.0).abs() < 2e-3, "{}: {got}", light.name());
    }
}

#[test]
fn a_spot_ends_softly_and_a_sun_is_everywhere_the_same() {
    let light = SphereLight::with_intensity(Sphere { center: Vec3::Y, radius: 0.1 }, COLOR);
    let spot = SpotLight { light, axis: Vec3::NEG_Y, cos: [0.9, 0.7], range: f32::INFINITY };
    let share = |x: f32| spot.radiance(&at(Vec3::new(x, 0.0, 0.0))).x / light.radiance.x;
    assert_eq!((share(0.0), share(0.45), share(1.1)), (1.0, 1.0, 0.0));
    assert!(share(0.6) < share(0.55) && share(0.9) > 0.0 && share(0.9) < 0.1);
    // With a range: on the axis, at its end, and behind a light that shines to all sides.
    let share = |lamp: SpotLight, y: f32| lamp.radiance(&at(Vec3::Y * y)).x / light.radiance.x;
    assert_eq!(share(SpotLight { range: 2.0, ..spot }, 0.0), 1.0 - 0.5_f32.powi(4));
    assert_eq!(share(SpotLight { range: 2.0, ..spot }, -1.001), 0.0);
    assert_eq!([0.0, 2.0].map(|y| share(SpotLight::everywhere(light, 2.0), y)), [1.0 - 0.5_f32.powi(4); 2]);
    for range in [0.0, -1.0, f32::NAN] {
        assert!(SpotLight { range, ..spot }.validate().is_err(), "{range}");
    }

    let world = Sphere { center: Vec3::ZERO, radius: 5.0 };
    let sun = SunLight::new(Vec3::new(0.6, 0.8, 0.0), 2.0, COLOR, world);
    let [one, other] = [Vec3::ZERO, Vec3::new(4.0, -1.0, 2.0)].map(|p| sun.cone(&at(p)));
    assert_eq!(one, other);
    // E = L π sin²θ toward it.
    let lit = sun.radiance.x * core::f32::consts::PI * one.sin_sq();
    assert!((lit / COLOR.x - 1.0).abs() < 1e-5);
    let receivers = Sphere { center: Vec3::X, radius: 0.5 };
    let bounds = sun.bounds_from(&receivers);
    for k in 0..20 {
        let from = receivers.center + Quat::from_rotation_z(k as f32) * Vec3::X * 0.5;
        let seen = sun.sphere_from(from);
        assert!(seen.center.distance(bounds.center) + seen.radius <= bounds.radius * 1.000_01);
    }
}

#[test]
fn a_tube_seen_along_its_axis_is_its_end() {
    let tube = TubeLight { ends: [Vec3::ZERO, Vec3::X], radius: 0.1, radiance: COLOR };
    let term = tube.seen_from(&at(Vec3::new(3.0, 0.05, 0.0)));
    assert!(term.outline.is_none());
    let end = Sphere { center: Vec3::X, radius: 0.1 };
    assert_eq!(term.cone, Cone::of_sphere(Vec3::new(3.0, 0.05, 0.0), end));
    assert!(tube.outline(&at(Vec3::new(0.5, 2.0, 0.0))).is_some());
}

/// Blockers count up to the surface in the mean: before the middle line from beside, before the nearer end from in front of it.
#[test]
fn a_tube_s_plane_is_where_its_surface_is() {
    let tube = TubeLight { ends: [Vec3::ZERO, Vec3::X], radius: 0.1, radiance: COLOR };
    // Half a cylinder far away is π/4 of its radius before its middle line in the mean, a strip next to the receiver all of it.
    let inward =
        |distance: f32| tube.radius * (1.0 - (1.0 - core::f32::consts::FRAC_PI_4) * (1.0 - tube.radius / distance));
    let plane = |x: Vec3| {
        let outline = tube.outline(&at(x)).expect("an outline");
        (outline.axis(), outline.height())
    };
    let (axis, height) = plane(Vec3::new(0.5, 2.0, 0.0));
    assert!(axis.distance(Vec3::NEG_Y) < 1e-5 && (height - 2.0 + inward(2.0)).abs() < 1e-5, "{axis} {height}");
    // In line with the tube, where a little of its side is seen, and far away, where none is.
    for (x, least) in [(Vec3::new(3.0, 0.141, 0.0), 0.4), (Vec3::new(200.0, 0.141, 0.0), 0.998)] {
        let (axis, height) = plane(x);
        let toward = Vec3::X - x;
        let view = toward.normalize();
        assert!(axis.dot(view) > least, "{axis}");
        // Through a point of the end's outer half.
        let (distance, body) = (toward.length(), Vec3::NEG_X);
        let outward = (view * body.dot(view) - body).normalize();
        let met = view * (distance - inward(distance)) + outward * (0.6 * tube.radius);
        let off = axis.dot(met) - height;
        assert!(off.abs() < 0.01 * tube.radius, "{off} for {distance}");
        // The end covers most of what is seen, and the outline is little too large.
        let facing = Receiver::on_surface(x, axis, axis);
        let lobe = Lobe::new(axis, 1.0, Vec3::ONE);
        let flat = outline_integral(&facing, lobe, &tube.outline(&facing).expect("an outline"));
        let round = cap_integral(&facing, lobe, &Cone::of_sphere(x, Sphere { center: Vec3::X, radius: tube.radius }));
        assert!((1.0..1.2).contains(&(flat / round)), "{flat} {round}");
    }
    // From the side of an end the plane turns on without a step.
    let (before, behind) = (plane(Vec3::new(0.999, 0.4, 0.0)), plane(Vec3::new(1.001, 0.4, 0.0)));
    assert!(before.0.distance(behind.0) < 0.01 && (before.1 - behind.1).abs() < 0.01, "{before:?} {behind:?}");
}

/// From everywhere that is a tenth of the radius off the surface, against a count of the directions that meet the capsule.
#[test]
fn a_tube_looks_as_large_as_it_is() {
    for [length, radius] in [[1.0, 0.1], [0.02, 0.1], [12.0, 0.1]] {
        let tube = TubeLight { ends: [Vec3::ZERO, Vec3::X * length], radius, radiance: COLOR };
        for height in [1.1, 1.4, 2.0, 6.0] {
            for place in [-20.0, -2.0, -0.3, 0.0, 0.5 * length / radius] {
                let x = Vec3::new(place, height, 0.0) * radius;
                let middle = tube.outline(&at(x)).expect("not covered by an end").middle().normalize();
                let facing = Receiver::on_surface(x, middle, middle);
                let outline = tube.outline(&facing).expect("as before");
                let seen = outline_integral(&facing, Lobe::new(middle, 1.0, Vec3::ONE), &outline);
                let ends = tube.ends.map(|p| (p - x).as_dvec3());
                let widest = outline.corners().iter().map(|p| middle.angle_between(*p)).fold(0.0, f32::max);
                let truth = capsule_moment(ends, f64::from(radius), middle.as_dvec3(), f64::from(1.1 * widest));
                let off = (f64::from(PI * seen) / truth - 1.0).abs();
                assert!(off < 2e-3, "{length} long, {height} and {place} radii off: {seen} {truth}");
            }
        }
    }
}

/// Before an endless tube the irradiance is `π r L h/d²`.
#[test]
fn tubes_may_be_a_million_long() {
    for length in [1e3, 1e5, 1e6, 1e7] {
        for [near, far] in [[0.5, 0.5], [0.01, 1.0]] {
            let ends = [Vec3::new(0.0, 2.0, -near * length), Vec3::new(0.0, 2.0, far * length)];
            let tube = TubeLight { ends, radius: 0.5, radiance: COLOR };
            for aside in [0.0_f32, 1.0, 4.0] {
                let facing = Receiver::on_surface(Vec3::X * aside, Vec3::Y, Vec3::Y);
                let outline = tube.outline(&facing).expect("beside it");
                let seen = outline_integral(&facing, Lobe::new(Vec3::Y, 1.0, Vec3::ONE), &outline);
                let truth = 0.5 * 2.0 / (4.0 + aside * aside);
                // Where an end is near it gives a little less.
                let most = if near * length < 11.0 { 0.03 } else { 1e-3 };
                assert!((seen / truth - 1.0).abs() < most, "{length} {near} {aside}: {seen} {truth}");
            }
        }
    }
}

/// The integral of the cosine to `axis` over a capsule, summed over 600 × 600 directions within the angle `reach` of that.
fn capsule_moment(ends: [DVec3; 2], radius: f64, axis: DVec3, reach: f64) -> f64 {
    const CELLS: u32 = 600;
    let (u, v) = axis.any_orthonormal_pair();
    let body = ends[1] - ends[0];
    let meets = |d: DVec3| {
        // The place of the middle line next to the ray's line; the capsule is convex, so that it is before or behind the eye as a whole.
        let [across, start] = [body, ends[0]].map(|p| p - d * p.dot(d));
        let place = (-start.dot(across) / across.length_squared().max(1e-300)).clamp(0.0, 1.0);
        (start + across * place).length() <= radius && (ends[0] + body * place).dot(d) > 0.0
    };
    let cell = |k: u32| (f64::from(k) + 0.5) / f64::from(CELLS);
    let sum: f64 = (0..CELLS * CELLS)
        .map(|k| {
            let (sin, cos) = (reach * cell(k / CELLS)).sin_cos();
            let turn = core::f64::consts::TAU * cell(k % CELLS);
            let d = axis * cos + (u * turn.cos() + v * turn.sin()) * sin;
            if meets(d) { sin * cos.max(0.0) } else { 0.0 }
        })
        .sum();
    core::f64::consts::TAU * reach * sum / f64::from(CELLS * CELLS)
}

#[test]
fn lights_move_and_turn() {
    let placement = Mat4::from_rotation_translation(Quat::from_rotation_x(0.7), Vec3::new(1.0, 2.0, 3.0));
    let turned = |p: Vec3| placement.transform_point3(p);
    let Light::Flat(moved) = rectangle().moved(placement) else { panic!("a rectangle") };
    let light = rectangle();
    for position in [Vec3::ZERO, Vec3::new(2.0, -1.0, 0.5)] {
        let (one, other) = (light.outline(&at(position)), moved.outline(&at(turned(position))));
        let [one, other] = [one, other].map(|o| o.expect("before it").moments().0);
        assert!((one - other).abs() < 1e-5 * one);
    }
    let Light::Tube(moved) = tube().moved(placement) else { panic!("a tube") };
    assert_eq!(moved.ends, tube().ends.map(turned));
}

#[test]
fn shapes_that_are_none_are_refused() {
    let polygon = |corners: &[[f32; 3]]| {
        FlatLight::polygon(&corners.iter().map(|c| Vec3::from_array(*c)).collect::<Vec<_>>(), COLOR).map(|_| ())
    };
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(polygon(&square), Ok(()));
    assert_eq!(polygon(&square[..2]), Err(FlatLightError::Corners));
    assert_eq!(polygon(&[[0.0, f32::NAN, 0.0], square[1], square[2]]), Err(FlatLightError::Corners));
    assert_eq!(polygon(&[square[0], square[1], [2.0, 0.0, 0.0]]), Err(FlatLightError::Degenerate));
    assert_eq!(polygon(&[square[0], square[1], square[2], [0.0, 1.0, 0.3]]), Err(FlatLightError::NotFlat));
    assert_eq!(polygon(&[square[0], square[1], square[2], [0.9, 0.2, 0.0]]), Err(FlatLightError::NotConvex));
    // A star winds twice.
    let star: Vec<[f32; 3]> = (0..5).map(|k| (k as f32 * 2.513_274).sin_cos()).map(|(y, x)| [x, y, 0.0]).collect();
    assert_eq!(polygon(&star), Err(FlatLightError::NotConvex));
    assert!(FlatLight::rectangle(Vec3::ZERO, Vec3::X, Vec3::X, COLOR).is_err());
    assert!(FlatLight::disc(Vec3::ZERO, Vec3::ZERO, 1.0, COLOR).is_err());
    // Only what has two sides at right angles shows an image.
    let image = Arc::new(LightImage::new(UVec2::ONE, &[Vec3::ONE]).expect("an image").0);
    let oblique = FlatLight::rectangle(Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, COLOR).expect("a parallelogram");
    let disc = FlatLight::disc(Vec3::ZERO, Vec3::Y, 1.0, COLOR).expect("a disc");
    assert!(oblique.showing(image.clone()).is_none() && disc.showing(image).is_none());
}

#[test]
fn corners_given_twice_count_once() {
    let square = [[-1.0, 3.0, -1.0], [1.0, 3.0, -1.0], [1.0, 3.0, 1.0], [-1.0, 3.0, 1.0]].map(Vec3::from_array);
    let polygon = |corners: &[Vec3]| FlatLight::polygon(corners, COLOR);
    let right = polygon(&square);
    for place in 0..4 {
        for offset in [Vec3::ZERO, Vec3::X * 2e-7] {
            let mut corners = square.to_vec();
            corners.insert(place + 1, square[place] + offset);
            corners.insert(place + 1, square[place]);
            assert_eq!(polygon(&corners).expect("a square").corners().len(), 4, "{place}");
        }
        let mut corners = square.to_vec();
        corners.insert(place, square[place]);
        assert_eq!(polygon(&corners), right);
    }
    // The first once more at the end, and more of them than a light may have.
    let ring: Vec<Vec3> = (0..24).map(|k| Quat::from_rotation_y(k as f32 * -TAU / 24.0) * Vec3::X).collect();
    let closed: Vec<Vec3> = ring.iter().flat_map(|p| [*p; 2]).chain([ring[0]]).collect();
    assert_eq!(polygon(&closed), polygon(&ring));
    assert_eq!(polygon(&[square[0], square[1], square[1]]).map(|_| ()), Err(FlatLightError::Degenerate));
    // As thin as a light may be.
    let thin = FlatLight::rectangle(Vec3::Y, Vec3::X, Vec3::Z * 3e-6, COLOR).expect("a rectangle");
    assert_eq!(thin.corners().len(), 4);
}

/// `∫ v dv` over a polygon in f64 (Lambert's formula), of which the receiver is at the origin.
fn mean_vector(corners: &[DVec3]) -> DVec3 {
    let edge = |(a, b): (&DVec3, &DVec3)| {
        let cross = a.cross(*b - *a);
        cross.normalize_or_zero() * (0.5 * cross.length().atan2(a.dot(*b)))
    };
    corners.iter().zip(corners.iter().cycle().skip(1)).map(edge).sum()
}

/// The part of a polygon above the horizon of a receiver at the origin.
fn above(corners: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut out = Vec::new();
    for (p, q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (h, g) = (normal.dot(*p), normal.dot(*q));
        out.extend((h >= 0.0).then_some(*p));
        out.extend(((h >= 0.0) != (g >= 0.0)).then(|| *p + (*q - *p) * (h / (h - g))));
    }
    out
}

/// From as large as far to a million times as large, inside of the rim, below it and beside it.
#[test]
fn large_lights_are_not_black() {
    for size in [1.0, 1e2, 1e4, 2e4, 1e5, 1e6, 1e8_f32] {
        let rectangle =
            FlatLight::rectangle(Vec3::Y * 3.0, Vec3::X * size, Vec3::Z * size, COLOR).expect("a rectangle");
        let disc = FlatLight::disc(Vec3::Y * 3.0, Vec3::NEG_Y, size, COLOR).expect("a disc");
        let corners: Vec<Vec3> =
            (0..24).map(|k| Quat::from_rotation_y(0.1 + k as f32 * TAU / 24.0) * Vec3::X * size).collect();
        let corners: Vec<Vec3> = corners.iter().map(|p| *p + Vec3::Y * 3.0).collect();
        let polygon = FlatLight::polygon(&corners, COLOR).expect("a polygon").on_both_sides();
        for place in [Vec3::ZERO, Vec3::X * 0.3, Vec3::X, Vec3::Z * 0.999, Vec3::new(0.7, 0.0, 0.7)] {
            for aside in [Vec3::ZERO, Vec3::X * 40.0] {
                let receiver = at(place * size + aside);
                for (name, light) in [("rectangle", &rectangle), ("disc", &disc), ("polygon", &polygon)] {
                    // A disc is a polygon of 24 sides, which its rim is seen to be from next to it.
                    if name == "disc" && (100.0..5e3).contains(&size) && place.length() > 0.5 {
                        continue;
                    }
                    let from = receiver.position.as_dvec3();
                    let ring = |k: i32| {
                        let (sin, cos) = (f64::from(k) * 1e-3 * core::f64::consts::TAU).sin_cos();
                        DVec3::new(cos, 0.0, sin) * f64::from(size) + DVec3::Y * 3.0 - from
                    };
                    let right: Vec<DVec3> = match name {
                        "disc" => (0..1000).map(ring).collect(),
                        _ => light.corners().iter().map(|p| p.as_dvec3() - from).collect(),
                    };
                    let seen = light.outline(&receiver);
                    for normal in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0)] {
                        let at = Receiver::on_surface(receiver.position, normal, normal);
                        let lambert = Lobe::new(normal, 1.0, Vec3::ONE);
                        let value = seen.map_or(0.0, |outline| outline_integral(&at, lambert, &outline));
                        // Above the receiver's horizon.
                        let above = above(&right, normal.as_dvec3());
                        let want = mean_vector(&above).dot(normal.as_dvec3()).abs() / core::f64::consts::PI;
                        let off = (f64::from(value) - want).abs();
                        assert!(off < 2e-3, "{name} of {size} from {}, {normal}: {value} {want}", receiver.position);
                    }
                }
            }
        }
    }
}

/// Against the nearest of many points of the surface.
#[test]
fn distances_are_those_of_the_nearest_points() {
    let mut random = Random::new(3);
    let (center, u, v) = (Vec3::new(0.3, 1.0, -0.2), Vec3::new(0.8, 0.1, 0.0), Vec3::new(0.0, 0.2, 0.5));
    let quad: Light = FlatLight::rectangle(center, u, v, Vec3::ONE).expect("a rectangle").into();
    let normal = Vec3::new(0.2, 0.9, 0.1).normalize();
    let disc: Light = FlatLight::disc(center, normal, 0.7, Vec3::ONE).expect("a disc").into();
    let (x, y) = normal.any_orthonormal_pair();
    let ends = [center, center + u];
    let tube: Light = TubeLight { ends, radius: 0.25, radiance: Vec3::ONE }.into();
    let sphere: Light = SphereLight::new(Sphere { center, radius: 0.6 }, Vec3::ONE).into();
    let steps = || (0..=400).flat_map(|i| (0..=400).map(move |k| (i as f32 / 200.0 - 1.0, k as f32 / 200.0 - 1.0)));
    let quads: Vec<Vec3> = steps().map(|(s, t)| center + u * s + v * t).collect();
    let inside = |(s, t): &(f32, f32)| s * s + t * t <= 1.0;
    let discs: Vec<Vec3> = steps().filter(inside).map(|(s, t)| center + (x * s + y * t) * 0.7).collect();
    let axis = || (0..=20_000).map(|k| ends[0].lerp(ends[1], k as f32 / 20_000.0));
    let nearest = |points: &[Vec3], p: Vec3| points.iter().map(|q| q.distance(p)).fold(f32::INFINITY, f32::min);
    for _ in 0..60 {
        let p = center + Vec3::from_array(core::array::from_fn(|_| (random.uniform() * 4.0 - 2.0) as f32));
        let near = |light: &Light, want: f32| {
            let got = light.distance_to(p).expect("a surface");
            // Half a step of the samples.
            assert!((got - want).abs() <= 4e-3, "{}: {got} {want}", light.name());
        };
        near(&quad, nearest(&quads, p));
        near(&disc, nearest(&discs, p));
        near(&tube, (axis().map(|q| q.distance(p)).fold(f32::INFINITY, f32::min) - 0.25).abs());
        near(&sphere, (p.distance(center) - 0.6).abs());
    }
}

/// A bright area of 34° is no sun, and no part of it either.
#[test]
fn large_bright_areas_stay_in_the_sky() {
    let size = UVec2::new(256, 128);
    let texel = |i: u32| {
        let is_bright = (116..140).contains(&(i % size.x)) && (44..56).contains(&(i / size.x));
        Vec3::splat(if is_bright { 60.0 } else { 0.5 })
    };
    let map = EnvironmentMap::new(size, (0..size.x * size.y).map(texel).collect()).expect("a map");
    let world = Sphere { center: Vec3::ZERO, radius: 10.0 };
    let lights = Environment::new(map, 2, world).lights().to_vec();
    assert!(!lights.iter().any(|light| matches!(light, Light::Sky(SkyLight::Sun(_)))), "{}", lights.len());
}
