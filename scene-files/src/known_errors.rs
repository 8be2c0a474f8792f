//! Lines about things that a picture shows with a known error.

use brdf::Material;
use core::cell::OnceCell;
use glam::{Vec2, Vec3};
use lighting::{FlatLight, Light};
use lobe_core::Sphere;
use scene::{Bounds, Scene};
use shading::LightLobes;

/// Exponents of Neumann's metals and the mean difference of a floor, a sphere and a box under a sphere light of 8° from the reference,
/// as a part of the mean (docs/limits.md).
const NEUMANN: [(f32, f32); 6] = [(2.0, 0.14), (5.0, 0.19), (10.0, 0.19), (20.0, 0.12), (50.0, 0.02), (100.0, 0.01)];
/// Errors that are worth a line.
const WORTH: f32 = 0.02;
/// Lights are compared with each other up to so many.
const MOST: usize = 4096;

/// One line for each kind of error in a scene.
pub(crate) fn lines(scene: &Scene) -> Vec<String> {
    let metals = scene.materials.iter().enumerate().filter_map(|(i, material)| metal(i, material));
    metals
        .chain(twice(&scene.lights))
        .chain(stacked(&scene.lights))
        .chain(tiny(scene))
        .chain(black(&scene.lights))
        .collect()
}

/// Lights of which none shines.
fn black(lights: &[Light]) -> Option<String> {
    let is_black = !lights.is_empty() && lights.iter().all(|light| light.full_radiance() == Vec3::ZERO);
    is_black.then(|| "all its lights are black: they light nothing".to_owned())
}

/// Flat lights that lie partly on others in one plane.
fn stacked(lights: &[Light]) -> Option<String> {
    let shines = |light: &&FlatLight| light.radiance != Vec3::ZERO;
    let flat =
        lights.iter().take(MOST).filter_map(|light| if let Light::Flat(flat) = light { Some(flat) } else { None });
    let lights: Vec<&FlatLight> = flat.filter(shines).collect();
    let covers = |i: &usize| lights[..*i].iter().any(|other| *other != lights[*i] && overlap(other, lights[*i]));
    let count = (0..lights.len()).filter(covers).count();
    let lie = if count == 1 { "1 flat light lies" } else { &format!("{count} flat lights lie") };
    (count > 0).then(|| format!("{lie} partly on others in one plane: there the light is that of both"))
}

/// Whether two flat lights lie in one plane, shine to one side, and cover an area together.
fn overlap(a: &FlatLight, b: &FlatLight) -> bool {
    let cos = a.normal().dot(b.normal());
    let is_one_side = cos > 0.0 || a.two_sided || b.two_sided;
    let (near, far) = (a.bounds(), b.bounds());
    let least = a.area().min(b.area());
    // Of corners in single precision.
    let is_flat = cos.abs() > 0.999_99 && (far.center - near.center).dot(a.normal()).abs() < 1e-3 * least.sqrt();
    let is_near = near.center.distance(far.center) < near.radius + far.radius;
    is_one_side && is_flat && is_near && common_area(&corners(a), &corners(b), a.normal()) > 1e-2 * least
}

/// The corners of a flat light; points of its rim for a disc.
fn corners(light: &FlatLight) -> Vec<Vec3> {
    const RIM: usize = 24;
    let (center, Some(radius)) = light.as_disc() else { return light.corners().to_vec() };
    let (u, v) = light.normal().any_orthonormal_pair();
    let at = |k: usize| Vec2::from_angle(core::f32::consts::TAU * k as f32 / RIM as f32) * radius;
    (0..RIM).map(|k| center + u * at(k).x + v * at(k).y).collect()
}

/// The area of a convex polygon within another in its plane, whose corners go counter-clockwise about the normal: one is clipped at the
/// sides of the other.
fn common_area(around: &[Vec3], polygon: &[Vec3], normal: Vec3) -> f32 {
    let mut rest = polygon.to_vec();
    for (i, &from) in around.iter().enumerate() {
        let inward = normal.cross(around[(i + 1) % around.len()] - from);
        let inside = |p: Vec3| (p - from).dot(inward);
        let mut kept = Vec::with_capacity(rest.len() + 1);
        for (k, &p) in rest.iter().enumerate() {
            let next = rest[(k + 1) % rest.len()];
            let (here, there) = (inside(p), inside(next));
            if here >= 0.0 {
                kept.push(p);
            }
            if here * there < 0.0 {
                kept.push(p.lerp(next, here / (here - there)));
            }
        }
        rest = kept;
    }
    let Some(&first) = rest.first() else { return 0.0 };
    0.5 * rest[1..].windows(2).map(|p| (p[0] - first).cross(p[1] - first)).sum::<Vec3>().length()
}

/// The half-angle, in radians, from which on lights are exact: of flat ones and tubes, whose corners are rounded, and of spheres.
const SMALLEST: [f32; 2] = [2e-5, 5e-7];

/// Lights that all objects see smaller than that.
fn tiny(scene: &Scene) -> Option<String> {
    // Of all vertices: once, and only where a light may be so small.
    let bounds: OnceCell<Vec<Bounds>> = OnceCell::new();
    let is_tiny = |light: &&Light| {
        let least = match light {
            Light::Flat(_) | Light::Tube(_) => SMALLEST[0],
            Light::Sphere(_) | Light::Spot(_) => SMALLEST[1],
            _ => return false,
        };
        let Sphere { center, radius } = light.bounds();
        let bounds = bounds.get_or_init(|| scene.objects.iter().map(|object| object.shape.bounds()).collect());
        let distances = bounds.iter().map(|b| center.distance(center.clamp(b.min, b.max)));
        let nearest = distances.fold(f32::INFINITY, f32::min);
        nearest.is_finite() && radius < least * nearest
    };
    let count = scene.lights.iter().take(MOST).filter(is_tiny).count();
    let of = if count == 1 { "1 light is" } else { &format!("{count} lights are") };
    let advice = "tens of per cent off: a light of kind \"point\" and a radius of 1e-4 of its distance is exact";
    (count > 0).then(|| format!("{of} seen under less than 1e-5 radians, and may be {advice}"))
}

fn metal(number: usize, material: &Material) -> Option<String> {
    let Material::Neumann(metal) = material else { return None };
    let e = metal.exponent;
    let next = NEUMANN.iter().position(|(exponent, _)| *exponent >= e)?;
    let error = match next {
        0 => NEUMANN[0].1,
        next => {
            let ((low, a), (high, b)) = (NEUMANN[next - 1], NEUMANN[next]);
            a + (b - a) * (e / low).ln() / (high / low).ln()
        }
    };
    let percent = 100.0 * error;
    (error >= WORTH && metal.ks.max_element() > 0.0).then(|| {
        format!(
            "material {number} (neumann of exponent {e}) is about {percent:.0} % off: its lobes suit exponents from 100"
        )
    })
}

/// Lights in one place.
fn twice(lights: &[Light]) -> Vec<String> {
    let among = if lights.len() > MOST { format!("among the first {MOST} lights ") } else { String::new() };
    // Black ones add nothing.
    let shines = |light: &&Light| light.full_radiance() != Vec3::ZERO;
    let lights: Vec<&Light> = lights.iter().take(MOST).filter(shines).collect();
    let sphere = |light: &Light| match light {
        Light::Sphere(light) => Some(light.sphere),
        Light::Enclosed(light) => light.light.sphere(),
        _ => None,
    };
    let spheres: Vec<Option<Sphere>> = lights.iter().map(|light| sphere(light)).collect();
    let (mut equal, mut overlapping) = (0, 0);
    for (i, &light) in lights.iter().enumerate() {
        let (mut is_equal, mut overlaps) = (false, false);
        for j in 0..i {
            match (spheres[i], spheres[j]) {
                (Some(a), Some(b)) if a == b => is_equal = true,
                // Those that touch shine as they are.
                (Some(a), Some(b)) => {
                    let apart = a.center.as_dvec3().distance(b.center.as_dvec3());
                    overlaps |= apart < 0.999 * (f64::from(a.radius) + f64::from(b.radius));
                }
                (None, None) if !matches!(light, Light::Sky(_) | Light::Ambient(_)) => is_equal |= light == lights[j],
                _ => {}
            }
        }
        equal += usize::from(is_equal);
        overlapping += usize::from(overlaps && !is_equal);
    }
    let mut all = Vec::new();
    if equal > 0 {
        let are = if equal == 1 { "1 light is" } else { &format!("{equal} lights are") };
        all.push(format!("{among}{are} in the place of an equal one: it is as bright as both"));
    }
    if overlapping > 0 {
        let overlap =
            if overlapping == 1 { "1 light sphere overlaps" } else { &format!("{overlapping} light spheres overlap") };
        all.push(format!(
            "{among}{overlap} others: the parts inside these shine as well, so all are too bright together"
        ));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf::Neumann;
    use lighting::SphereLight;

    #[test]
    fn metals_are_told_with_their_error() {
        let of = |exponent| metal(0, &Neumann { kd: Vec3::ZERO, ks: Vec3::ONE, exponent }.into());
        for (exponent, words) in [(1.0, "14 %"), (5.0, "19 %"), (20.0, "12 %"), (31.6, "7 %")] {
            assert!(of(exponent).is_some_and(|line| line.contains(words)), "{:?}", of(exponent));
        }
        assert!(of(80.0).is_none() && of(1000.0).is_none());
    }

    #[test]
    fn lights_too_small_for_single_precision_are_told() {
        let scene = |light: Light| Scene { lights: vec![light], ..scene::builtin() };
        let flat = |size: f32| lighting::FlatLight::rectangle(Vec3::Y * 9.0, Vec3::X * size, Vec3::Z * size, Vec3::ONE);
        let sphere = |radius| SphereLight::new(Sphere { center: Vec3::Y * 9.0, radius }, Vec3::ONE);
        assert!(tiny(&scene(flat(1e-5).expect("a rectangle").into())).is_some());
        assert!(tiny(&scene(flat(1e-2).expect("a rectangle").into())).is_none());
        assert!(tiny(&scene(sphere(1e-7).into())).is_some() && tiny(&scene(sphere(1e-4).into())).is_none());
    }

    #[test]
    fn flat_lights_on_each_other_are_told() {
        let at = |x: f32, y: f32, v: Vec3| FlatLight::rectangle(Vec3::new(x, y, 0.0), Vec3::X, v, Vec3::ONE);
        let disc = |x: f32| FlatLight::disc(Vec3::new(x, 0.0, x), Vec3::NEG_Y, 1.0, Vec3::ONE);
        for (a, b, is_told) in [
            // Side by side, half on it, above it, facing the other way, and on it as two-sided ones.
            (at(0.0, 0.0, Vec3::Z), at(2.0, 0.0, Vec3::Z), false),
            (at(0.0, 0.0, Vec3::Z), at(1.0, 0.0, Vec3::Z), true),
            (at(0.0, 0.0, Vec3::Z), at(1.0, 0.1, Vec3::Z), false),
            (at(0.0, 0.0, Vec3::Z), at(1.0, 0.0, Vec3::NEG_Z), false),
            (at(0.0, 0.0, Vec3::Z), at(1.0, 0.0, Vec3::NEG_Z).map(FlatLight::on_both_sides), true),
            // Equal ones have a line of their own; discs do not reach the corners of their squares.
            (at(0.0, 0.0, Vec3::Z), at(0.0, 0.0, Vec3::Z), false),
            (disc(0.0), disc(1.5), false),
            (disc(0.0), disc(1.2), true),
        ] {
            let lights: Vec<Light> = [a, b].map(|light| light.expect("a light").into()).into();
            assert_eq!(stacked(&lights).is_some(), is_told, "{lights:?}");
        }
    }

    #[test]
    fn lights_that_are_all_black_are_told() {
        let of = |radiance: f32| -> Light {
            SphereLight::new(Sphere { center: Vec3::ZERO, radius: 1.0 }, Vec3::splat(radiance)).into()
        };
        assert!(black(&[of(0.0), of(0.0)]).is_some());
        assert!(black(&[of(0.0), of(1.0)]).is_none() && black(&[]).is_none());
    }

    #[test]
    fn lights_in_one_place_are_told() {
        let at = |x: f32, radius: f32| -> Light {
            SphereLight::new(Sphere { center: Vec3::X * x, radius }, Vec3::ONE).into()
        };
        let sun: Light =
            lighting::SunLight::new(Vec3::Y, 0.3, Vec3::ONE, Sphere { center: Vec3::ZERO, radius: 1.0 }).into();
        let black: Light = SphereLight::new(Sphere { center: Vec3::ZERO, radius: 1.0 }, Vec3::ZERO).into();
        for (lights, words) in [
            (vec![at(0.0, 1.0), black.clone(), at(1.5, 0.4), black], &[][..]),
            (vec![at(0.0, 1.0), at(2.0, 1.0)], &[][..]),
            (vec![at(0.0, 1.0), at(1.5, 1.0)], &["1 light sphere overlaps"]),
            (vec![at(0.0, 1.0), at(0.0, 1.0)], &["1 light is in the place"]),
            (vec![at(0.0, 1.0), at(0.1, 0.1), at(0.0, 1.0)], &["1 light is", "1 light sphere"]),
            (vec![sun.clone(), sun.clone(), sun], &["2 lights are"]),
        ] {
            let told = twice(&lights);
            assert_eq!(told.len(), words.len(), "{told:?}");
            assert!(told.iter().zip(words).all(|(line, words)| line.starts_with(words)), "{told:?}");
        }
    }
}
