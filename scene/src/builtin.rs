use crate::{Camera, Encoding, Mesh, Object, Projection, Proxy, Scene, Surface, Texture, TextureMap};
use brdf::{Lambert, MetallicRoughness, ModifiedPhong, Phong};
use core::f32::consts::TAU;
use glam::{Quat, Vec3};
use lighting::SphereLight;
use lobe_core::Sphere;

/// The built-in scene, which is rendered when no file is given.
///
/// A still life on a polished floor before a curved wall: spheres of brass and of painted clay that rest on the floor, a knotted tube that
/// hovers low, and a trail of pearls that rises from contact to well above everything; a large warm key light and a small cool one behind.
/// Shadows run from sharp to nearly gone, and those of the knot cut the cool highlight on the floor. All blockers are exact
/// spheres; the knot's lie on its spine and touch its surface from inside.
#[must_use]
pub fn builtin() -> Scene {
    let materials = vec![
        // 0: floor
        ModifiedPhong { kd: Vec3::new(0.34, 0.345, 0.36), ks: Vec3::splat(0.20), exponent: 90.0 }.into(),
        // 1: knot
        ModifiedPhong { kd: Vec3::new(0.66, 0.15, 0.07), ks: Vec3::splat(0.14), exponent: 60.0 }.into(),
        // 2: brass
        brass().into(),
        // 3: pearls
        Phong { kd: Vec3::new(0.27, 0.245, 0.20), ks: Vec3::splat(0.35), exponent: 120.0 }.into(),
        // 4: clay
        Lambert { albedo: Vec3::splat(0.9) }.into(),
        // 5: wall
        Lambert { albedo: Vec3::new(0.34, 0.345, 0.36) }.into(),
    ];
    let mut surfaces = vec![Surface::default(); materials.len()];
    surfaces[4].color = Some(TextureMap::new(paint()));
    let floor = Mesh::quad(Vec3::new(0.0, 0.0, 4.5), Vec3::X * 20.0, Vec3::NEG_Z * (4.5 - BACK));
    let (knot, spine) = knot();
    let on_floor = |x: f32, z: f32, radius: f32| Sphere { center: Vec3::new(x, radius, z), radius };
    let brass = vec![on_floor(-1.75, -0.35, 0.72), on_floor(-0.55, 1.25, 0.13)];
    let clay = vec![on_floor(-2.55, 0.62, 0.34), on_floor(-1.13, 0.78, 0.21), on_floor(-2.02, 1.22, 0.15)];
    let objects = vec![
        Object::mesh("floor", floor, 0, Proxy::None),
        Object::mesh("wall", wall(), 5, Proxy::None),
        Object::mesh("knot", knot, 1, Proxy::Spheres(spine)),
        Object::spheres("brass spheres", brass, 2),
        Object::spheres("clay spheres", clay, 4),
        Object::spheres("pearls", pearls(), 3),
    ];
    let light =
        |center: Vec3, radius: f32, radiance: Vec3| SphereLight::new(Sphere { center, radius }, radiance).into();
    Scene {
        surfaces,
        camera: Camera {
            eye: Vec3::new(0.3, 2.7, 8.8),
            target: Vec3::new(0.1, 0.95, 0.0),
            up: Vec3::Y,
            projection: Projection::perspective(28.0_f32.to_radians()),
        },
        width: 960,
        height: 540,
        materials,
        objects,
        lights: vec![
            light(Vec3::new(-4.4, 6.4, 3.4), 1.0, Vec3::new(1.0, 0.80, 0.58) * 52.0),
            light(Vec3::new(1.75, 2.8, -4.2), 0.2, Vec3::new(0.42, 0.66, 1.0) * 310.0),
        ],
        ..Scene::default()
    }
}

/// A brushed metal.
fn brass() -> MetallicRoughness {
    let reflectance = Vec3::new(0.89, 0.70, 0.38);
    MetallicRoughness::new(reflectance, 1.0, 0.5).unwrap_or_else(|e| unreachable!("{e}"))
}

/// The paint around a sphere: a cap and a zigzag between two lines.
fn paint() -> Texture {
    const SIZE: [u32; 2] = [512, 256];
    const CREAM: [u8; 4] = [238, 226, 204, 255];
    const RED: [u8; 4] = [186, 84, 52, 255];
    const BLUE: [u8; 4] = [56, 82, 104, 255];
    // The place of a pixel, in turns around and from pole to pole.
    let color = |u: f32, v: f32| {
        let zigzag = 0.05 * (4.0 * (12.0 * u).fract() - 2.0).abs() - 0.05;
        let from_middle = v - 0.43;
        if v < 0.12 || (from_middle - zigzag).abs() < 0.035 {
            RED
        } else if (0.135..0.165).contains(&from_middle.abs()) {
            BLUE
        } else {
            CREAM
        }
    };
    let [width, height] = SIZE.map(|n| n as f32);
    let at = |i: u32| color(((i % SIZE[0]) as f32 + 0.5) / width, ((i / SIZE[0]) as f32 + 0.5) / height);
    Texture::new("paint", SIZE, (0..SIZE[0] * SIZE[1]).map(at).collect(), Encoding::Srgb)
}

/// The floor ends here and the wall begins to rise.
const BACK: f32 = -5.0;

/// A wall that rises from the floor in a smooth bend.
fn wall() -> Mesh {
    const BEND: f32 = 3.0;
    const STEPS: u32 = 24;
    // Points of the profile and their normals, bottom to top.
    let mut profile = Vec::new();
    for i in 0..=STEPS {
        let (s, c) = (0.25 * TAU * i as f32 / STEPS as f32).sin_cos();
        profile.push((Vec3::new(0.0, BEND * (1.0 - c), BACK - BEND * s), Vec3::new(0.0, c, s)));
    }
    profile.push((Vec3::new(0.0, 12.0, BACK - BEND), Vec3::Z));
    let mut mesh = Mesh::default();
    for (i, (point, normal)) in profile.into_iter().enumerate() {
        mesh.positions.extend([point + 20.0 * Vec3::NEG_X, point + 20.0 * Vec3::X]);
        mesh.normals.extend([normal.normalize(); 2]);
        if i > 0 {
            let k = 2 * i as u32;
            mesh.triangles.extend([[k - 2, k - 1, k + 1], [k - 2, k + 1, k]]);
        }
    }
    mesh
}

/// A trefoil knot that leans back, its lowest point a little above the floor; and spheres along its spine.
fn knot() -> (Mesh, Vec<Sphere>) {
    const TUBE: f32 = 0.20;
    let tilt = Quat::from_rotation_y(-0.35) * Quat::from_rotation_x(-0.5) * Quat::from_rotation_z(0.3);
    let curve = |i: u32| {
        let a = TAU * i as f32 / 480.0;
        let flat = Vec3::new(a.sin() + 2.0 * (2.0 * a).sin(), a.cos() - 2.0 * (2.0 * a).cos(), -1.35 * (3.0 * a).sin());
        tilt * (0.30 * flat)
    };
    let points: Vec<Vec3> = (0..480).map(curve).collect();
    let lowest = points.iter().fold(f32::INFINITY, |m, p| m.min(p.y)) - TUBE;
    let place = Vec3::new(1.05, 0.24 - lowest, -0.1);
    let spine: Vec<Vec3> = points.into_iter().map(|p| p + place).collect();
    let mesh = Mesh::closed_tube(&spine, TUBE, 48);
    // The mesh's faces lie up to 0.5 % inside the tube: chords of 48 sides, and of the spine where it bends.
    let spheres = (0..120).map(|i| Sphere { center: spine[4 * i], radius: TUBE * 0.99 }).collect();
    (mesh, spheres)
}

/// Pearls on an arc that leaves the floor in front and rises behind the knot.
fn pearls() -> Vec<Sphere> {
    const COUNT: u32 = 10;
    (0..COUNT)
        .map(|i| {
            let t = i as f32 / (COUNT - 1) as f32;
            let radius = 0.075 + 0.055 * t;
            let turn = 0.42 * TAU * t;
            let across = Vec3::new(0.25 - 1.45 * turn.sin() + 2.0 * t * t, 0.0, 1.75 - 3.1 * t);
            Sphere { center: across + Vec3::Y * (radius + 2.35 * t.powf(1.6)), radius }
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
            let (Shape::Mesh(mesh), Proxy::Spheres(spheres)) = (&object.shape, &object.proxy) else {
                assert!(
                    matches!(&object.shape, Shape::Spheres(s) if object.proxy == Proxy::Spheres(s.clone()))
                        || object.proxy == Proxy::None
                );
                continue;
            };
            // Vertices lie on the tube. No vertex and no centre of a triangle may be inside a sphere.
            for sphere in spheres {
                for t in &mesh.triangles {
                    let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                    for p in [a, 0.5 * (a + b), 0.5 * (b + c), (a + b + c) / 3.0] {
                        assert!(p.distance(sphere.center) >= sphere.radius * 0.9999, "{p} in {sphere:?}");
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
        assert!(lowest("brass spheres").abs() < 1e-6);
        assert!((lowest("knot") - 0.24).abs() < 0.01);
        let pearls = scene.objects.iter().find(|o| o.name == "pearls").unwrap().shape.bounds();
        assert!(pearls.min.y.abs() < 1e-6 && pearls.max.y > 2.0, "{pearls:?}");
    }
}
