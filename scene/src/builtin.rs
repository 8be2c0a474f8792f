use crate::{Camera, Mesh, Object, Proxy, Scene};
use brdf::{Lambert, ModifiedPhong, Phong};
use core::f32::consts::TAU;
use glam::{Quat, Vec3};
use lighting::SphereLight;
use lobe_core::Sphere;

/// The built-in scene: what is shown when no file is given.
///
/// A still life on a polished floor: a cairn of pebbles that touches it, a knotted tube that hovers low, and a row of
/// pearls that rises out of the light; a large warm key light and a small cool rim light. Shadows run from contact to
/// half a metre of penumbra, and the highlights on the floor are cut by them. All blockers are exact balls; those of the
/// knot lie on its spine and touch its skin from inside.
#[must_use]
pub fn builtin() -> Scene {
    let materials = vec![
        // 0: floor
        ModifiedPhong { kd: Vec3::new(0.20, 0.21, 0.235), ks: Vec3::splat(0.22), exponent: 60.0 }.into(),
        // 1: knot
        ModifiedPhong { kd: Vec3::new(0.62, 0.155, 0.075), ks: Vec3::splat(0.16), exponent: 50.0 }.into(),
        // 2: slate pebbles
        Lambert { albedo: Vec3::new(0.30, 0.34, 0.38) }.into(),
        // 3: pearls
        Phong { kd: Vec3::new(0.235, 0.215, 0.18), ks: Vec3::splat(0.35), exponent: 120.0 }.into(),
        // 4: one pale pebble
        Lambert { albedo: Vec3::new(0.70, 0.64, 0.52) }.into(),
    ];
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 40.0, Vec3::NEG_Z * 40.0);
    let (knot, spine) = knot();
    let (slate, pale) = cairn();
    let objects = vec![
        Object::mesh("floor", floor, 0, Proxy::None),
        Object::mesh("knot", knot, 1, Proxy::Spheres(spine)),
        Object::spheres("slate pebbles", slate, 2),
        Object::spheres("pale pebble", pale, 4),
        Object::spheres("pearls", pearls(), 3),
    ];
    let light = |center: Vec3, radius: f32, radiance: Vec3| SphereLight::new(Sphere { center, radius }, radiance);
    Scene {
        camera: Camera {
            eye: Vec3::new(0.4, 2.9, 8.6),
            target: Vec3::new(0.1, 0.95, 0.0),
            up: Vec3::Y,
            vertical_fov: 30.0_f32.to_radians(),
        },
        width: 960,
        height: 540,
        background: Vec3::ZERO,
        materials,
        objects,
        lights: vec![
            light(Vec3::new(-4.6, 6.2, 2.6), 0.95, Vec3::new(1.0, 0.78, 0.55) * 34.0),
            light(Vec3::new(3.6, 3.4, -5.2), 0.22, Vec3::new(0.45, 0.68, 1.0) * 420.0),
        ],
    }
}

/// A (2, 3) torus knot, tilted, its lowest point a little above the floor; and balls along its spine.
fn knot() -> (Mesh, Vec<Sphere>) {
    const TUBE: f32 = 0.23;
    let tilt = Quat::from_rotation_z(-0.35) * Quat::from_rotation_x(1.15);
    let curve = |i: usize, n: usize| {
        let a = TAU * i as f32 / n as f32;
        let ring = 0.74 + 0.30 * (3.0 * a).cos();
        tilt * Vec3::new(ring * (2.0 * a).cos(), ring * (2.0 * a).sin(), 0.34 * (3.0 * a).sin())
    };
    let points: Vec<Vec3> = (0..480).map(|i| curve(i, 480)).collect();
    let lowest = points.iter().fold(f32::INFINITY, |m, p| m.min(p.y)) - TUBE;
    let place = Vec3::new(1.15, 0.30 - lowest, -0.2);
    let spine: Vec<Vec3> = points.into_iter().map(|p| p + place).collect();
    let mesh = Mesh::closed_tube(&spine, TUBE, 48);
    // A tube of 48 sides lies up to 1 − cos(π/48) = 0.21 % inside its radius, and chords of the spine a little more.
    let balls = (0..96).map(|i| Sphere { center: spine[5 * i], radius: TUBE * 0.996 }).collect();
    (mesh, balls)
}

/// Pebbles stacked and strewn, each resting on what is below it: the slate ones, and a pale one.
fn cairn() -> (Vec<Sphere>, Vec<Sphere>) {
    let on_floor = |x: f32, z: f32, radius: f32| Sphere { center: Vec3::new(x, radius, z), radius };
    let on_top = |below: Sphere, radius: f32, lean: Vec3| Sphere {
        center: below.center + (below.radius + radius) * (Vec3::Y + lean).normalize(),
        radius,
    };
    let base = on_floor(-1.55, 0.15, 0.55);
    let middle = on_top(base, 0.34, Vec3::new(0.12, 0.0, 0.08));
    let top = on_top(middle, 0.20, Vec3::new(-0.2, 0.0, 0.05));
    let slate = vec![base, top, on_floor(-0.72, 0.95, 0.17), on_floor(-2.45, 0.8, 0.12), on_floor(0.25, 1.55, 0.10)];
    (slate, vec![middle])
}

/// Pearls on a rising curve, the lowest touching the floor.
fn pearls() -> Vec<Sphere> {
    (0..8)
        .map(|i| {
            let t = i as f32 / 7.0;
            let radius = 0.085 + 0.045 * t;
            let center = Vec3::new(-0.35 - 1.5 * t + 0.9 * t * t, radius + 2.35 * t * t.sqrt(), 1.35 - 2.2 * t);
            Sphere { center, radius }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;

    #[test]
    fn is_valid() {
        builtin().validate().unwrap();
    }

    #[test]
    fn blockers_stay_inside_their_skin() {
        for object in builtin().objects {
            let (Shape::Mesh(mesh), Proxy::Spheres(balls)) = (&object.shape, &object.proxy) else {
                assert!(
                    matches!(&object.shape, Shape::Spheres(s) if object.proxy == Proxy::Spheres(s.clone()))
                        || object.proxy == Proxy::None
                );
                continue;
            };
            // Vertices lie on the tube; so do not protrude: no vertex and no triangle's middle is inside a ball.
            for ball in balls {
                for t in &mesh.triangles {
                    let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                    for p in [a, 0.5 * (a + b), 0.5 * (b + c), (a + b + c) / 3.0] {
                        assert!(p.distance(ball.center) >= ball.radius * 0.9999, "{p} in {ball:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn objects_reach_three_heights() {
        let scene = builtin();
        let lowest = |name: &str| {
            let o = scene.objects.iter().find(|o| o.name == name).unwrap();
            o.shape.bounds().min.y
        };
        assert_eq!(lowest("floor"), 0.0);
        assert!(lowest("slate pebbles").abs() < 1e-6);
        assert!((lowest("knot") - 0.30).abs() < 0.01);
        let top = scene.bounds().max.y;
        assert!(top > 2.0, "{top}");
    }
}
