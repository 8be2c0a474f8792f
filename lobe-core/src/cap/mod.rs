//! The integral of one lobe over a uniform disc of light, cut by the receiver's horizon.

mod albedo;
mod blocks;
mod brushed;
mod brushed_facets;
mod chord;
mod ellipse;
mod form;
mod lambert;
mod microfacets;
mod pair;
mod slab;
pub(crate) mod wgsl;

pub use self::lambert::sphere_light_irradiance;

use self::blocks::Blocks;
use self::brushed::Brushed;
use self::brushed_facets::BrushedFacets;
use self::chord::Chord;
use self::microfacets::Ellipse;
use self::pair::Pair;
use crate::lanes::{WIDTH, row};
use crate::seen::Seen;
use crate::{BrdfLobe, Cone, PackedLobe, Receiver, TileLight, TileLobes, outline};
use core::cell::RefCell;
use core::f32::consts::FRAC_1_PI;
use fearless_simd::{Level, dispatch};
use glam::Vec3;

/// `∫ f(v) dv` over the directions of a light's cone that are above the receiver's horizon, for a reflectance lobe of
/// flux 1, the receiver's cosine included. Multiply by the lobe's flux and the light's radiance for
/// the unshadowed radiance.
///
/// - Lambert: closed, exact at every horizon crossing ([`sphere_light_irradiance`]).
/// - exponent ≥ 400, light above the horizon and three times wider than the lobe: the *slab form*, three error functions. A Gaussian
///   over a disc, seen along its offset, is almost a Gaussian over a slab of adjusted half-width and width.
/// - else: *chords*, slices by the planes that contain the axis across lobe and light; along a chord the integral is
///   closed (an error function), chords are cut exactly at the horizon, and the nodes absorb the disc's square-root
///   edges. 10 chords, 6 where the light is narrower than the lobe; 14 in each of the pieces between which the horizon changes
///   how it cuts them; 32 below exponent 1 and for lights wider than 66°.
///
/// - microfacets: in the plane of half vectors the light is an ellipse and the distribution a cosine lobe, whose integral along a chord is
///   closed; the rest of the reflectance is smooth and taken at two points of each of 10 chords, or of both halves of 32 through the horizon.
/// - microfacets with a [grain](crate::Grain): the same, as lines and ellipses stay what they are where slopes are stretched;
/// - microfacets inside the light: the mean over the facets that the eye sees, 64 of them above the horizon.
///
/// # Domain
/// Exponents in [0, 1e7] (from 1e9 on the lobe sees its axis only, and between the two loses precision), cones from a
/// point (gives 0) to a hemisphere; a receiver inside the light sees it in all directions above its horizon.
///
/// # Accuracy
/// Against quadrature in f64, relative to the on-axis value, for all sizes up to a hemisphere: ≤ 0.15 % above the horizon for
/// exponents from 1, mean 0.003 %, seam between the two forms ≤ 0.15 %; through the horizon ≤ 0.3 %, mean 0.003 %, 99 % of
/// cases ≤ 0.15 %. Exponents below 1: ≤ 0.01 % up to a half-angle of 60°, ≤ 0.6 % for a hemisphere. Microfacets inside the light:
/// ≤ 1 % of their albedo at all views and roughnesses, mean ≤ 0.2 %. The height of a light's
/// centre above the horizon comes from `n·l`, of which f32 keeps 2e-7: that much of the light's half-angle is not known.
///
/// # Cost
/// Many at once are several times cheaper: [`cap_integrals`].
#[must_use]
pub fn cap_integral(at: &Receiver, lobe: impl Into<BrdfLobe>, cone: &Cone) -> f32 {
    let level = Level::new();
    let (light, lobe) = (Seen::new(at.normal, cone), PackedLobe::from(lobe.into()));
    let [form, value] = form::of(&light, &lobe);
    let pair = light.pair(&lobe);
    if form == form::CROSSED {
        lambert::through_horizon(light.cos_beta, light.sin_sq) * FRAC_1_PI
    } else if form == form::SLAB {
        slab::slab(&pair)
    } else if form == form::WHOLE {
        let chord = Chord::whole(&pair);
        if chord.is_narrow() {
            over_nodes::<{ chord::FEW }, false>(level, &chord)
        } else {
            over_nodes::<{ chord::MANY }, false>(level, &chord)
        }
    } else if form == form::PIECES {
        Chord::pieces(&pair).fold(0.0, |sum, chord| sum + over_nodes::<{ chord::PIECE }, true>(level, &chord))
    } else if form == form::MICROFACETS {
        of_microfacets::<false>(level, &pair)[usize::from(lobe.is_edge())]
    } else if form == form::MICROFACETS_CUT {
        of_microfacets::<true>(level, &pair)[usize::from(lobe.is_edge())]
    } else if form == form::MICROFACETS_ALL {
        of_everywhere(level, &pair)[usize::from(lobe.is_edge())]
    } else if form == form::MICROFACETS + form::BRUSHED {
        of_brushed::<false>(level, &pair)[usize::from(lobe.is_edge())]
    } else if form == form::MICROFACETS_CUT + form::BRUSHED {
        of_brushed::<true>(level, &pair)[usize::from(lobe.is_edge())]
    } else if form == form::MICROFACETS_ALL + form::BRUSHED {
        of_brushed_everywhere(level, &pair)[usize::from(lobe.is_edge())]
    } else if form == form::EDGE {
        Chord::pieces(&pair).fold(0.0, |sum, chord| sum + over_nodes::<{ chord::EDGE }, true>(level, &chord))
    } else {
        value
    }
}

/// [`cap_integral`] of all lobes of a tile over one light: `out[k]` is that of row `k`, counted through all blocks, bit for
/// bit what the single call gives, on every machine; 0 for empty places.
///
/// Lobes of one kind are taken sixteen at a time, as many in one instruction as the processor offers.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::lanes::set_row;
/// use lobe_core::{Lobe, PackedLobe, Receiver, Sphere, Tile, TileLight, TileLobes, cap_integral, cap_integrals};
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// let gloss = Lobe::new(Vec3::new(0.0, 0.5, 0.86).normalize(), 40.0, Vec3::ONE);
/// let (mut tile, mut light, mut lobes, mut out) = Default::default();
/// Tile::set(&mut tile, &[at]);
/// TileLight::sphere(&mut light, &tile, Sphere { center: Vec3::new(0.0, 1.2, 1.6), radius: 0.3 }, Vec3::ONE);
/// TileLobes::reset(&mut lobes, &tile, 1);
/// set_row(lobes.block_mut(0, 0), 0, &bytemuck::cast(PackedLobe::from(gloss)));
/// cap_integrals(&light, &lobes, &mut out);
/// assert_eq!(out[0], cap_integral(&at, gloss, &light.cone(0)));
/// ```
pub fn cap_integrals(light: &TileLight, lobes: &TileLobes, out: &mut Vec<f32>) {
    integrals_at(Level::new(), light, lobes, out);
}

pub(crate) fn integrals_at(level: Level, light: &TileLight, lobes: &TileLobes, out: &mut Vec<f32>) {
    // One a thread: no caller needs to keep or clear them.
    thread_local! {
        static BLOCKS: RefCell<Blocks> = const { RefCell::new(Blocks::new()) };
    }
    out.resize(lobes.blocks() * WIDTH, 0.0);
    if let Some((flat, at)) = light.as_flat() {
        outline::of_flat(level, (flat, at), lobes, out);
        return;
    }
    if !light.outlines().is_empty() {
        of_outlines(light, lobes, out);
        return;
    }
    BLOCKS.with_borrow_mut(|blocks| {
        for number in 0..lobes.blocks() {
            let seen = &light.seen[number % lobes.blocks_of_place()].0;
            blocks.take(level, seen, lobes, number, out);
        }
        blocks.finish(level, out);
    });
}

fn of_outlines(light: &TileLight, lobes: &TileLobes, out: &mut [f32]) {
    out.fill(0.0);
    for (i, outline) in light.outlines().iter().enumerate() {
        let seen: Seen = bytemuck::cast(row(&light.seen[i / WIDTH].0, i % WIDTH));
        let at = Receiver::on_surface(Vec3::ZERO, seen.normal, seen.normal);
        for (number, lobe) in lobes.of(i) {
            let cone = bytemuck::cast(row(&light.cones[i / WIDTH].0, i % WIDTH));
            out[number] = outline::light_integral(&at, &lobe, &cone, outline.as_ref());
        }
    }
}

/// The albedo, for both lobes of a pair.
fn of_everywhere(level: Level, pair: &Pair) -> [f32; 2] {
    let facets = albedo::Facets::new(pair);
    dispatch!(level, _simd => {
        let mut sums = [0.0; 2];
        for turn in albedo::TURNS {
            let range = (0..albedo::HALVINGS).fold(facets.cap(), |range, _| facets.halve(range, turn));
            for place in albedo::PLACES {
                let node = facets.node(range, turn, place);
                sums = [sums[0] + node[0], sums[1] + node[1]];
            }
        }
        sums
    })
}

/// The same of microfacets with a grain.
fn of_brushed_everywhere(level: Level, pair: &Pair) -> [f32; 2] {
    let facets = BrushedFacets::new(pair);
    dispatch!(level, _simd => {
        let mut sums = [0.0; 2];
        for turn in albedo::all_turns() {
            let range = (0..albedo::HALVINGS).fold(facets.cap(), |range, _| facets.halve(range, turn));
            for place in albedo::PLACES {
                let node = facets.node(range, turn, place);
                sums = [sums[0] + node[0], sums[1] + node[1]];
            }
        }
        sums
    })
}

/// The chords of the ellipse of microfacets with a grain, for both lobes of a pair.
fn of_brushed<const IS_CUT: bool>(level: Level, pair: &Pair) -> [f32; 2] {
    let brushed = Brushed::new::<IS_CUT>(pair);
    let sums = dispatch!(level, _simd => {
        microfacets::nodes::<IS_CUT>().fold([0.0; 2], |[base, edge], (cos, weight)| {
            let node = brushed.node::<IS_CUT>(cos, weight);
            [base + node[0], edge + node[1]]
        })
    });
    sums.map(|sum| chord::finish(brushed.weight(), sum))
}

/// The chords of an ellipse of half vectors, for both lobes of a pair.
fn of_microfacets<const IS_CUT: bool>(level: Level, pair: &Pair) -> [f32; 2] {
    let ellipse = Ellipse::new::<IS_CUT>(pair);
    let sums = dispatch!(level, _simd => {
        microfacets::nodes::<IS_CUT>().fold([0.0; 2], |[base, edge], (cos, weight)| {
            let node = ellipse.node::<IS_CUT>(cos, weight);
            [base + node[0], edge + node[1]]
        })
    });
    sums.map(|sum| chord::finish(ellipse.weight(), sum))
}

/// One chord sum, its nodes side by side.
fn over_nodes<const N: usize, const CUT: bool>(level: Level, chord: &Chord) -> f32 {
    let nodes = const { chord::nodes::<N>() };
    let terms = dispatch!(level, _simd => {
        let mut terms = [0.0; N];
        for (term, (cos, sin)) in terms.iter_mut().zip(nodes) {
            *term = chord.node::<CUT>(cos, sin);
        }
        terms
    });
    // In the order in which blocks add them.
    let sum = terms.into_iter().fold(0.0, |sum, x| sum + x);
    chord::finish(chord.weight, sum)
}
