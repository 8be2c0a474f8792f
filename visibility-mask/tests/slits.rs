//! A slit between the rows of a mask that is marked shows as much of a wide light as one that lies across the rows, for all kinds of lobes: masks
//! around it are turned.

use core::f32::consts::FRAC_1_SQRT_2;
use glam::{Vec2, Vec3};
use lobe_core::{Cone, Lobe, Microfacets, Receiver, cap_integral};
use shading::{Accuracy, Coverage, LightId, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, Edges, LitArea, Mask, MaskVisibility, Mixture, UnitSquare};

const AXIS: Vec3 = Vec3::Z;
/// Where the slit is along x at distance 1, and half its width: between two rows of masks with 32 rows.
const PLACE: f32 = 0.162;
const HALF: f32 = 0.005;

/// Hides all but the directions with an x of [`PLACE`], and says that its edges run across a direction.
struct Slit {
    across: Vec3,
    /// Whether what is lit is known as it is.
    is_known: bool,
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

    fn find_lit(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &Mask, _: f32, lit: &mut LitArea) -> bool {
        const SLABS: u16 = 64;
        let UnitSquare { right, center, half, .. } = *mask.square();
        let height = 2.0 * half.y / f32::from(SLABS);
        for k in 0..SLABS {
            let y = center.y - half.y + (f32::from(k) + 0.5) * height;
            let [from, to] = mask.emits_at(y, None);
            let [a, b] = [PLACE - HALF, PLACE + HALF].map(|place| place * right.x.signum());
            let ends = [a.min(b).max(from), a.max(b).min(to)];
            if ends[0] < ends[1] {
                lit.add(mask.square(), ends, [0.0; 2], y, height);
            }
        }
        // It crosses rows at one place if it lies across them.
        self.is_known && right.x.abs() > 0.999
    }
}

/// Hides a disc about a place.
struct Round(Vec2);

impl Round {
    const RADIUS: f32 = 0.1;
}

impl Blockers for Round {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }

    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let UnitSquare { right, up, .. } = *mask.square();
        let center = Vec2::new(right.truncate().dot(self.0), up.truncate().dot(self.0));
        for j in 0..mask.side() {
            let off = mask.row_y(j) - center.y;
            let half = (Self::RADIUS.powi(2) - off * off).max(0.0).sqrt();
            mask.block_span(j, center.x - half, center.x + half);
        }
    }
}

/// The visible fractions of a Lambert lobe, of two glossy ones, and of microfacets of two roughnesses.
fn fractions(blockers: impl Blockers) -> Vec<f32> {
    let normal = Vec3::new(0.2, -0.3, 1.0).normalize();
    let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
    let cone = Cone { axis: AXIS, one_minus_cos: 0.4, distance: f32::INFINITY };
    let query = VisibilityQuery::new(&at, LightId::default(), &cone, Accuracy::default());
    let visibility = MaskVisibility::new(blockers);
    let mut scratch = visibility.scratch();
    assert_eq!(visibility.coverage(&query, &mut scratch), Coverage::Partial);
    let glossy = |exponent: f32| Lobe::new(Vec3::new(0.1, 0.2, 1.0).normalize(), exponent, Vec3::ONE).times_cosine();
    let mut all: Vec<f32> = [Lobe::new(normal, 1.0, Vec3::ONE), glossy(4.0), glossy(30.0)]
        .map(|lobe| visibility.fraction(&query, &lobe, cap_integral(&at, lobe, &cone), &mut scratch).x)
        .to_vec();
    for alpha in [0.5, 0.1] {
        let view = Vec3::new(-0.5, 0.1, 0.8).normalize();
        let parts: [Microfacets; 2] = Microfacets::new(view, alpha, [Vec3::ONE; 2]);
        // Both parts together: the integral of the edge's, which is small, has a larger error, by which a fraction of a lit part that is known is divided.
        let (mut seen, mut whole) = (0.0, 0.0);
        for part in parts {
            let all = cap_integral(&at, part, &cone);
            seen += all * visibility.microfacets_fraction(&query, &part, all, &mut scratch).x;
            whole += all;
        }
        all.push(seen / whole);
    }
    all
}

#[test]
fn slits_along_rows_and_across_them_show_the_same() {
    let [across, along] = [Vec3::X, Vec3::Y].map(|across| fractions(Slit { across, is_known: false }));
    println!("{across:?}\n{along:?}");
    for (k, (a, b)) in across.iter().zip(&along).enumerate() {
        assert!(*a > 1e-4 && (b / a - 1.0).abs() < 0.06, "lobe {k}: {a} {b}");
    }
}

/// A slit that is known as it is shows all kinds of lobes as much as masks around it do; beside a disc that hides none of it, too, and not beside one that does.
#[test]
fn a_slit_as_it_is_shows_what_masks_show() {
    let slit = |is_known| Slit { across: Vec3::X, is_known };
    let (masks, known) = (fractions(slit(false)), fractions(slit(true)));
    println!("{masks:?}\n{known:?}");
    for (k, (a, b)) in masks.iter().zip(&known).enumerate() {
        assert!((b / a - 1.0).abs() < 0.04, "lobe {k}: {a} {b}");
    }
    let beside = |at: Vec2, is_known| fractions(Mixture::new(slit(is_known), Round(at)));
    assert_eq!(beside(Vec2::new(-0.3, 0.1), true), known);
    let on = Vec2::new(PLACE, 0.1);
    assert_eq!(beside(on, true), beside(on, false));
    assert!(beside(on, true).iter().zip(&known).all(|(on, free)| on < free));
}
