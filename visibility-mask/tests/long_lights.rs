//! The part of a long light that a lip along it leaves, from beside the light's end.

use glam::Vec3;
use lobe_core::{Cone, Lobe, Outline, Receiver, light_integral};
use shading::{Accuracy, Coverage, LightId, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, Edges, Mask, MaskVisibility};

/// Half the width of the light and its length, at distance 1.
const HALF: f32 = 0.02;
const LENGTH: f32 = 4.0;

/// Hides what is below a plane through the receiver.
struct Lip(Vec3);

impl Blockers for Lip {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }

    fn edges(&self, _: &VisibilityQuery<'_>, (): &(), edges: &mut Edges) {
        edges.add(self.0, 1.0);
    }

    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        mask.block_below(self.0);
    }

    /// There are none.
    fn mark_openings(&self, _: &VisibilityQuery<'_>, (): &mut (), _: &mut Mask, _: f32) -> bool {
        true
    }
}

/// The light from one place across it on.
fn light(from: f32, behind: f32) -> Outline {
    let corners = [[HALF, -behind], [HALF, LENGTH], [from, LENGTH], [from, -behind]].map(|[x, y]| Vec3::new(x, y, 1.0));
    Outline::new(&corners, Vec3::Z).expect("before the receiver")
}

/// Rows of masks around the lit part end where the light does. While they went on for a row beyond it, ends of rows were worth up to a tenth of all light.
#[test]
fn rows_around_a_lit_part_end_where_the_light_does() {
    let normal = Vec3::new(0.6, 0.0, 0.8);
    let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
    let lobe = Lobe::new(normal, 1.0, Vec3::ONE);
    let (mut worst, mut sum, mut count) = (0.0_f32, 0.0, 0);
    for behind in [0.0, 0.01, 0.03, 0.1] {
        for seen in [0.03, 0.06, 0.09, 0.12] {
            let edge = HALF * (1.0 - 2.0 * seen);
            let [whole, lit] = [-HALF, edge].map(|from| light(from, behind));
            let [all, want] = [&whole, &lit].map(|light| light_integral(&at, &lobe.into(), &light.cone(), Some(light)));
            let cone: Cone = whole.cone();
            let query = VisibilityQuery {
                outline: Some(&whole),
                ..VisibilityQuery::new(&at, LightId::default(), &cone, Accuracy::default())
            };
            let visibility = MaskVisibility::new(Lip(Vec3::new(1.0, 0.0, -edge)));
            let mut scratch = visibility.scratch();
            assert_eq!(visibility.coverage(&query, &mut scratch), Coverage::Partial);
            let got = all * visibility.fraction(&query, &lobe, all, &mut scratch).x;
            let error = (got / want - 1.0).abs();
            println!("{behind} {seen}: {got} of {want}");
            (worst, sum, count) = (worst.max(error), sum + error, count + 1);
        }
    }
    println!("mean {}, largest {worst}", sum / count as f32);
    assert!(sum < 0.01 * count as f32 && worst < 0.02);
}
