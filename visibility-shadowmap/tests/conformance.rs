//! The suite of all visibility strategies, for shadow maps.

use conformance::{Limits, Setting, check};
use glam::Vec3;
use lobe_core::Sphere;
use shading::DynVisibility;
use visibility_mask::MaskVisibility;
use visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers};

/// Corners around a rim: the chords of the largest sphere (1.5 rad) are off its rim by 0.1 % of the smallest light (0.005).
const CORNERS: u32 = 1024;

/// A closed double cone that hides the same directions from `eye` as the sphere: its rim is the circle in which tangents from there
/// touch the sphere, and its tips are the sphere's nearest and farthest points. The rim's polygon has the circle's area.
fn add(sphere: &Sphere, eye: Vec3, positions: &mut Vec<Vec3>, triangles: &mut Vec<[u32; 3]>) {
    let to = (sphere.center - eye).as_dvec3();
    let (distance, radius) = (to.length(), f64::from(sphere.radius));
    if radius <= 0.0 || distance <= radius {
        return;
    }
    let axis = to / distance;
    let (u, v) = axis.any_orthonormal_pair();
    let sin = radius / distance;
    let (along, across) = (distance * (1.0 - sin * sin), radius * (1.0 - sin * sin).sqrt());
    let step = core::f64::consts::TAU / f64::from(CORNERS);
    let across = across * (step / step.sin()).sqrt();
    let first = positions.len() as u32;
    let mut push = |p: glam::DVec3| positions.push((eye.as_dvec3() + p).as_vec3());
    push(axis * (distance - radius));
    push(axis * (distance + radius));
    for k in 0..CORNERS {
        let (sin, cos) = (step * f64::from(k)).sin_cos();
        push(axis * along + (u * cos + v * sin) * across);
    }
    for k in 0..CORNERS {
        let [a, b] = [k, (k + 1) % CORNERS].map(|k| first + 2 + k);
        triangles.extend([[first, a, b], [first + 1, b, a]]);
    }
}

/// A map of the spheres, fitted to those that may shadow the receiver.
fn blockers(setting: &Setting<'_>, resolution: u32) -> ShadowMapBlockers {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    setting.spheres.iter().for_each(|sphere| add(sphere, setting.receiver, &mut positions, &mut triangles));
    let receivers = Some(ReceiverBounds { min: setting.receiver - 1e-3, max: setting.receiver + 1e-3 });
    let options = MapOptions { resolution, receivers, ..MapOptions::default() };
    let map = ShadowMap::build(&positions, &triangles, setting.light, &options).expect("finite spheres");
    ShadowMapBlockers::new(vec![map])
}

/// The accuracy of texels; a light is about 150 of them wide here.
fn limits() -> Limits {
    Limits {
        // Texels along the horizon do not block, by their own rounding: almost no radiance comes from there.
        cover: 1e-3,
        overlap_mean: 0.001,
        // A lobe of exponent 500 sees a tenth of the widest light, 15 texels; the smallest spheres are five texels wide.
        several_mean: 0.013,
        several: 0.06,
        // The texels lie elsewhere after a rotation of the scene, but not after a small motion.
        turn: 0.02,
        jump: 0.008,
        jump_several: 0.004,
        cases: 12,
        ..Limits::default()
    }
}

/// Used as `Box<dyn …>`; the suite itself compares it with the static one.
#[test]
fn shadow_map() {
    let boxed = |s: &Setting<'_>| -> Box<dyn DynVisibility> { Box::new(MaskVisibility::new(blockers(s, 256))) };
    let measured = check(&boxed, &limits());
    println!("{:?}", measured.unwrap_or_else(|e| panic!("{e}")));
}
