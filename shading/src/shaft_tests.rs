use crate::{LightId, Shaft};
use glam::DVec3;
use lobe_core::Sphere;
use lobe_core::oracle::Random;

/// All segments from receivers in a sphere and a box to a sphere of light stay within the planes, and each plane touches some end.
#[test]
fn a_shaft_is_within_its_planes() {
    let mut random = Random::new(31);
    for case in 0..400 {
        let radius = random.log_uniform(1e-3, 3.0);
        let sphere = Sphere { center: (random.axis() * random.between(0.0, 5.0)).as_vec3(), radius: radius as f32 };
        let light = Sphere {
            center: (random.axis() * random.between(0.0, 9.0)).as_vec3(),
            radius: random.log_uniform(1e-3, 4.0) as f32,
        };
        let thin = if case % 3 == 0 { 0.0 } else { random.log_uniform(1e-3, 1.0) };
        let half_extent = DVec3::new(random.between(0.1, 1.0), thin, random.between(0.1, 1.0)) * radius;
        let shaft = Shaft::new(sphere, light, LightId(0)).in_box(half_extent.as_vec3());
        let planes = shaft.normals().map(|n| (n, shaft.reach(n)));
        let mut nearest = [f64::INFINITY; 10];
        for _ in 0..400 {
            let corner = random.axis().signum();
            let p = if random.uniform() < 0.5 { corner * half_extent } else { random.axis() * half_extent };
            let p = p.clamp_length_max(radius);
            let on_light = (light.center - sphere.center).as_dvec3() + random.axis() * f64::from(light.radius);
            for ((n, reach), nearest) in planes.iter().zip(&mut nearest) {
                for end in [p, on_light] {
                    let room = f64::from(*reach) - n.as_dvec3().dot(end);
                    assert!(room > -1e-5, "case {case}: {room}");
                    *nearest = nearest.min(room);
                }
            }
        }
        assert!(
            nearest.iter().all(|room| *room < 0.3 * (radius + f64::from(light.radius))),
            "case {case}: {nearest:?}"
        );
    }
}
