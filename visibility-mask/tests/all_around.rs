//! Square lights that are many times as large as far show most of themselves near the receiver's foot on their plane: there masks have samples enough.

use glam::{Vec2, Vec3};
use lobe_core::{Lobe, Outline, Receiver, outline_integral};
use shading::{Accuracy, Coverage, LightId, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, Mask, MaskVisibility, UnitSquare};

/// Hides a disc of the plane at distance 1.
struct Disc {
    center: Vec2,
    radius: f32,
}

impl Disc {
    /// The part of the irradiance of a receiver that faces the plane: the configuration factor of a disc parallel to it (J. R. Howell, *A catalog of
    /// radiation heat transfer configuration factors*, B-13).
    fn irradiance(&self) -> f32 {
        let (a, c) = (self.radius * self.radius, self.center.length_squared());
        let z = 1.0 + c + a;
        0.5 * (1.0 - (1.0 + c - a) / (z * z - 4.0 * a * c).sqrt())
    }
}

impl Blockers for Disc {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }

    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let UnitSquare { right, up, .. } = *mask.square();
        let center = Vec2::new(right.truncate().dot(self.center), up.truncate().dot(self.center));
        for j in 0..mask.side() {
            let off = mask.row_y(j) - center.y;
            let half = (self.radius.powi(2) - off * off).max(0.0).sqrt();
            if half > 0.0 {
                mask.block_span(j, center.x - half, center.x + half);
            }
        }
    }
}

#[test]
fn a_disc_hides_its_part_of_a_light_all_around() {
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
    let lobe = Lobe::new(Vec3::Z, 1.0, Vec3::ONE);
    for half in [4.1, 8.0, 20.0, 100.0, 800.0] {
        let corners =
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x * half, y * half, 1.0));
        let outline = Outline::new(&corners, Vec3::Z).expect("before its plane").with_roundness(0.6);
        let cone = outline.cone();
        let all = outline_integral(&at, lobe, &outline);
        let query = VisibilityQuery {
            outline: Some(&outline),
            ..VisibilityQuery::new(&at, LightId::default(), &cone, Accuracy::default())
        };
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f32, 0.0);
        for radius in [0.5, 1.0, 2.0] {
            for k in 0..20 {
                let center = Vec2::from_angle(0.4 * k as f32) * 0.15 * k as f32;
                let disc = Disc { center, radius };
                let want = 1.0 - disc.irradiance() / all;
                let visibility = MaskVisibility::new(disc);
                let mut scratch = visibility.scratch();
                assert_eq!(visibility.coverage(&query, &mut scratch), Coverage::Partial);
                let error = (visibility.fraction(&query, &lobe, all, &mut scratch).x / want - 1.0).abs();
                sum += error;
                worst = worst.max(error);
                count += 1.0;
            }
        }
        println!("half side {half}: mean {:.2} %, worst {:.2} %", 100.0 * sum / count, 100.0 * worst);
        assert!(sum < 0.005 * count && worst < 0.05, "{half}: {} {worst}", sum / count);
    }
}
