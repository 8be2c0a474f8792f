//! A slit between the rows of a mask that is marked shows as much of a wide light as one that lies across the rows, for all kinds of lobes: masks
//! around it are turned.

use core::f32::consts::FRAC_1_SQRT_2;
use glam::{Vec2, Vec3};
use lobe_core::{Cone, Lobe, Microfacets, Receiver};
use shading::{Accuracy, Coverage, LightId, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, Edges, Mask, MaskVisibility, UnitSquare};

const AXIS: Vec3 = Vec3::Z;
/// Where the slit is along x at distance 1, and half its width: between two rows of masks with 32 rows.
const PLACE: f32 = 0.162;
const HALF: f32 = 0.005;

/// Hides all but the directions with an x of [`PLACE`], and says that its edges run across a direction.
struct Slit {
    across: Vec3,
}

impl Blockers for Slit {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }

    fn edges(&self, _: &VisibilityQuery<'_>, (): &(), edges: &mut Edges) {
        edges.add(self.across, 1.0);
    }

    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let (right, up) = (mask.square().right.x, mask.square().up.x);
        for j in 0..mask.side() {
            // right·x + up·y is the direction's own x.
            let y = mask.row_y(j);
            let end = |place: f32| (place - up * y) / right;
            let (from, to) = (end(PLACE - HALF), end(PLACE + HALF));
            if right.abs() > FRAC_1_SQRT_2 {
                mask.block_span(j, f32::NEG_INFINITY, from.min(to));
                mask.block_span(j, from.max(to), f32::INFINITY);
            } else if (up * y - PLACE).abs() > HALF {
                mask.block_span(j, f32::NEG_INFINITY, f32::INFINITY);
            }
        }
    }

    /// Where the slit crosses columns.
    fn mark_openings(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask, _: f32) -> bool {
        let UnitSquare { right, up, center, half, .. } = *mask.square();
        if right.x.abs() > FRAC_1_SQRT_2 {
            return true;
        }
        for k in 0..mask.side() {
            let x = center.x + half.x * ((2 * k + 1) as f32 / mask.side() as f32 - 1.0);
            let ends = [PLACE - HALF, PLACE + HALF].map(|place| Vec2::new(x, (place - right.x * x) / up.x));
            if ends[0].length() < mask.square().disc {
                mask.mark_opening(ends, mask.cell().x);
            }
        }
        true
    }
}

/// The visible fractions of a Lambert lobe, of two glossy ones, and of microfacets of two roughnesses.
fn fractions(across: Vec3) -> Vec<f32> {
    let normal = Vec3::new(0.2, -0.3, 1.0).normalize();
    let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
    let cone = Cone { axis: AXIS, one_minus_cos: 0.4, distance: f32::INFINITY };
    let query = VisibilityQuery::new(&at, LightId::default(), &cone, Accuracy::default());
    let visibility = MaskVisibility::new(Slit { across });
    let mut scratch = visibility.scratch();
    assert_eq!(visibility.coverage(&query, &mut scratch), Coverage::Partial);
    let glossy = |exponent: f32| Lobe::new(Vec3::new(0.1, 0.2, 1.0).normalize(), exponent, Vec3::ONE).times_cosine();
    let mut all: Vec<f32> = [Lobe::new(normal, 1.0, Vec3::ONE), glossy(4.0), glossy(30.0)]
        .map(|lobe| visibility.fraction(&query, &lobe, 1.0, &mut scratch).x)
        .to_vec();
    for alpha in [0.5, 0.1] {
        let view = Vec3::new(-0.5, 0.1, 0.8).normalize();
        let parts = Microfacets::new(view, alpha, [Vec3::ONE; 2]);
        all.extend(parts.map(|part| visibility.microfacets_fraction(&query, &part, 1.0, &mut scratch).x));
    }
    all
}

#[test]
fn slits_along_rows_and_across_them_show_the_same() {
    let (across, along) = (fractions(Vec3::X), fractions(Vec3::Y));
    println!("{across:?}\n{along:?}");
    for (k, (a, b)) in across.iter().zip(&along).enumerate() {
        assert!(*a > 1e-4 && (b / a - 1.0).abs() < 0.06, "lobe {k}: {a} {b}");
    }
}
