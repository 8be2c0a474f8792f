use lobe_core::{Cone, Receiver};
use shading::Coverage;

/// Coverage of a light by the plane of the receiver's own facet: everything below the plane is hidden by the facet itself.
///
/// For receivers on an object that blocks. A smooth shading normal lets light from below the facet through. If the shading normal
/// is the facet's, the horizon leaves out the same directions, and a partly covered light counts as [`Coverage::Lit`].
#[must_use]
pub fn facet_coverage(at: &Receiver, cone: &Cone) -> Coverage {
    let (elevation, sin) = (at.face.dot(cone.axis), cone.sin_sq().sqrt());
    if elevation <= -sin {
        Coverage::Dark
    } else if elevation < sin && at.face != at.normal {
        Coverage::Partial
    } else {
        Coverage::Lit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contour, Edges, Mask, UnitSquare};
    use glam::Vec3;
    use lobe_core::oracle::Random;

    fn receiver(normal: Vec3, face: Vec3) -> Receiver {
        Receiver { position: Vec3::ZERO, normal, face, view: normal, object: 0 }
    }

    /// Against directions of the cone's rim.
    #[test]
    fn coverage_is_that_of_the_rim() {
        let mut random = Random::new(3);
        let mut counts = [0; 3];
        for _ in 0..2000 {
            let theta = random.log_uniform(0.01, 1.4);
            let axis = random.axis();
            let cone = Cone { axis: axis.as_vec3(), one_minus_cos: (1.0 - theta.cos()) as f32, distance: 5.0 };
            let face = random.axis().as_vec3();
            // Highest and lowest direction: the angle to the face's normal is that of the axis ± θ.
            let angle = f64::from(face.dot(cone.axis)).clamp(-1.0, 1.0).acos();
            let [low, high] = [angle + theta, angle - theta].map(|a| a - core::f64::consts::FRAC_PI_2);
            if low.abs() < 1e-4 || high.abs() < 1e-4 {
                continue;
            }
            let want = match (low < 0.0, high < 0.0) {
                (true, _) => Coverage::Lit,
                (false, true) => Coverage::Partial,
                (false, false) => Coverage::Dark,
            };
            assert_eq!(facet_coverage(&receiver(-face, face), &cone), want, "{face} {cone:?}");
            let own = facet_coverage(&receiver(face, face), &cone);
            assert_eq!(own, if want == Coverage::Partial { Coverage::Lit } else { want });
            counts[want as usize] += 1;
        }
        assert!(counts.iter().all(|n| *n > 100), "{counts:?}");
    }

    /// A facet and a horizon that cut the light, and an edge between them that rays find: the visible fraction of the disc against
    /// a sum over many directions, for fine masks and coarse ones, whole or zoomed.
    #[test]
    fn masks_are_cut_by_the_facet() {
        let mut random = Random::new(17);
        let (mut worst, mut count) = (0.0_f64, 0);
        for case in 0..600 {
            let theta = random.log_uniform(0.01, 0.5);
            let axis = random.axis();
            let cone =
                Cone { axis: axis.as_vec3(), one_minus_cos: (1.0 - theta.cos()) as f32, distance: f32::INFINITY };
            let mut tilted = |most: f64| {
                let angle = core::f64::consts::FRAC_PI_2 + theta * random.between(-most, most);
                random.axis_at(axis, angle).as_vec3()
            };
            let face = tilted(0.9);
            // At an angle to the facet as smooth normals have.
            let normal = (face + 0.4 * tilted(1.0)).normalize();
            let edge = tilted(0.8);
            let mut edges = Edges::new(&cone);
            edges.add_plane(face, &cone);
            edges.add_plane(normal, &cone);
            let square = UnitSquare::facing(&cone, edges.across()).above(normal);
            let mut mask = Mask::default();
            mask.set_coarse(case % 2 == 1);
            mask.reset(&square, 5, normal);
            let finds = case % 3 > 0;
            if finds {
                let asked = Contour::default().block_above(&mut mask, face, |v| {
                    assert!(v.dot(face) > 0.0, "case {case}: {}", v.dot(face));
                    v.dot(edge) < 0.0
                });
                // All cells of a wide light may be tested.
                assert!(asked < 1100, "{asked}");
            } else {
                mask.block_below(face);
            }
            const STEPS: i32 = 400;
            let (mut emits, mut lit) = (0, 0);
            for j in 0..STEPS {
                for i in 0..STEPS {
                    let at = |k: i32| f64::from(square.disc) * (f64::from(2 * k + 1) / f64::from(STEPS) - 1.0);
                    let (x, y) = (at(i), at(j));
                    let v = square.world(Vec3::new(x as f32, y as f32, 1.0));
                    if x.hypot(y) < f64::from(square.disc) && v.dot(normal) > 0.0 {
                        emits += 1;
                        lit += i32::from(v.dot(face) > 0.0 && (!finds || v.dot(edge) > 0.0));
                    }
                }
            }
            if emits > 2000 {
                let (whole, rest) = mask.areas();
                let error = f64::from(rest / whole) - f64::from(lit) / f64::from(emits);
                worst = worst.max(error.abs());
                count += 1;
            }
        }
        println!("{count} cases, worst {worst:.4}");
        assert!(count > 400 && worst < 0.02, "{count} cases, worst {worst}");
    }
}
