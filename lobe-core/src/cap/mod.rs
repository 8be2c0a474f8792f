//! The integral of one lobe over a uniform disc of light, cut by the receiver's horizon.

mod blocks;
mod chord;
mod lambert;
mod pair;
mod slab;

pub use self::lambert::sphere_light_irradiance;

use self::blocks::Blocks;
use self::chord::Chord;
use self::pair::Pair;
use crate::{Cone, Lobe, Lobes, Receiver, is_lambert};
use core::cell::RefCell;
use core::f32::consts::FRAC_1_PI;
use fearless_simd::{Level, dispatch};
use glam::Vec3;

/// Lobes from this exponent on, infinity included, see the one direction of their axis.
const MIRROR: f32 = 1e9;

/// `∫ f(v) dv` over the directions of a light's cone that are above the receiver's horizon, for a reflectance lobe of
/// flux 1; times the receiver's cosine where the lobe says so. Multiply by the lobe's flux and the light's radiance for
/// the unshadowed radiance.
///
/// - Lambert: closed, exact at every horizon crossing ([`sphere_light_irradiance`]).
/// - exponent ≥ 400, light above the horizon and wider than the lobe: the *slab form*, three error functions. A Gaussian
///   over a disc, seen along its offset, is almost a Gaussian over a slab of adjusted half-width and width.
/// - else: *chords*, slices by the planes that contain the axis across lobe and light; along a chord the integral is
///   closed (an error function), chords are cut exactly at the horizon, and the nodes absorb the disc's square-root
///   edges. 10 chords, 6 where the light is narrower than the lobe; 16 in each of the pieces into which the horizon cuts
///   the rim; 32 below exponent 1.
///
/// # Domain
/// Exponents in [0, 1e7] (from 1e9 on the lobe sees its axis only, and between the two loses precision), cones from a
/// point (gives 0) to a hemisphere; a receiver inside the light sees it in all directions above its horizon.
///
/// # Accuracy
/// Against quadrature in f64, relative to the on-axis value: ≤ 0.15 % above the horizon for all exponents from 1 and all
/// sizes, mean 0.003 %, seam between the two forms ≤ 0.15 %; through the horizon mean 0.03 %, 99 % of cases ≤ 0.4 %.
///
/// # Cost
/// Many at once are several times cheaper: [`cap_integrals`].
#[must_use]
pub fn cap_integral(at: &Receiver, lobe: &Lobe, cone: &Cone) -> f32 {
    let level = Level::new();
    let light = Seen::new(at, cone);
    let form = Form::new(at, lobe, &light);
    match form {
        Form::Done(value) => value,
        Form::Crossed => lambert::through_horizon(light.cos_beta, light.sin_sq) * FRAC_1_PI,
        Form::Slab => slab::slab(&light.pair(at, lobe)),
        Form::Whole => {
            let chord = Chord::whole(&light.pair(at, lobe));
            if chord.is_narrow() {
                over_nodes::<{ chord::FEW }, false>(level, &chord)
            } else {
                over_nodes::<{ chord::MANY }, false>(level, &chord)
            }
        }
        Form::Pieces | Form::Edge => Chord::pieces(&light.pair(at, lobe))
            .map(|chord| match form {
                Form::Edge => over_nodes::<{ chord::EDGE }, true>(level, &chord),
                _ => over_nodes::<{ chord::PIECE }, true>(level, &chord),
            })
            .fold(0.0, |sum, x| sum + x),
    }
}

/// [`cap_integral`] of many lobes, as when a tile of receivers meets one light: `out[k]` is the integral of `lobes[k]` at
/// the receiver `at[of[k]]` over `cones[of[k]]`, bit for bit what the single call gives, on every machine.
///
/// Lobes of one kind are taken sixteen at a time, as many in one instruction as the processor offers. Keep the lobes of a
/// receiver together.
///
/// # Cost
/// Instructions a lobe with AVX2, full blocks: Lambert 100 (through the horizon 155), slab 220, chords 420 (six) and 530
/// (ten), 200 where lobe and light do not meet; through the horizon 2800, exponents below 1 2300.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{Cone, Lobe, LobeBuffer, OWN_NONE, Receiver, cap_integral, cap_integrals};
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: OWN_NONE };
/// let cone = Cone { axis: Vec3::new(0.0, 0.6, 0.8), one_minus_cos: 0.01, distance: 2.0 };
/// let mut buffer = LobeBuffer::with_capacity(2);
/// let mut writer = buffer.writer();
/// writer.push(Lobe::new(Vec3::Z, 1.0, Vec3::ONE)).unwrap();
/// writer.push(Lobe::new(Vec3::new(0.0, 0.5, 0.86).normalize(), 40.0, Vec3::ONE)).unwrap();
/// let mut out = [0.0; 2];
/// cap_integrals(&[at], &[cone], &[0, 0], buffer.lobes(), &mut out);
/// assert_eq!(out[1], cap_integral(&at, &buffer.lobes().get(1), &cone));
/// ```
///
/// # Panics
/// When `of` or `out` is not as long as `lobes`, or a number in `of` is not that of a receiver and a cone.
pub fn cap_integrals(at: &[Receiver], cones: &[Cone], of: &[u32], lobes: Lobes<'_>, out: &mut [f32]) {
    integrals_at(Level::new(), at, cones, of, lobes, out);
}

pub(crate) fn integrals_at(
    level: Level,
    at: &[Receiver],
    cones: &[Cone],
    of_lobe: &[u32],
    lobes: Lobes<'_>,
    out: &mut [f32],
) {
    assert!(of_lobe.len() == lobes.len() && out.len() == lobes.len(), "one receiver and one output a lobe");
    // A thread's own, so that nobody has to carry them about, or clear them.
    thread_local! {
        static BLOCKS: RefCell<Blocks> = const { RefCell::new(Blocks::new()) };
    }
    BLOCKS.with_borrow_mut(|blocks| {
        out.fill(0.0);
        let n = lobes.len();
        let [x, y, z, exponent, _, _, _, cosine] = lobes.columns();
        let (x, y, z, exponent, cosine) = (&x[..n], &y[..n], &z[..n], &exponent[..n], &cosine[..n]);
        let (of_lobe, out) = (&of_lobe[..n], &mut out[..n]);
        let mut last: Option<(u32, Seen)> = None;
        for k in 0..n {
            // The lobes of a receiver follow each other.
            let of = of_lobe[k];
            let at = &at[of as usize];
            let light = match last {
                Some((seen_from, light)) if seen_from == of => light,
                _ => Seen::new(at, &cones[of as usize]),
            };
            last = Some((of, light));
            let axis = Vec3::new(x[k], y[k], z[k]);
            let lobe = Lobe { axis, exponent: exponent[k], flux: Vec3::ZERO, cosine: cosine[k] };
            match Form::new(at, &lobe, &light) {
                Form::Done(value) => out[k] = value,
                form => blocks.push(level, form, &light.pair(at, &lobe), &light, k, out),
            }
        }
        blocks.finish(level, out);
    });
}

/// A light above a receiver's horizon.
#[derive(Clone, Copy)]
struct Seen {
    axis: Vec3,
    one_minus_cos: f32,
    /// Cosine of the angle β between its axis and the normal; sin²θ.
    cos_beta: f32,
    sin_sq: f32,
    /// Whether the horizon leaves all of it; whether any.
    above: bool,
    below: bool,
}

impl Seen {
    #[inline(always)]
    fn new(at: &Receiver, cone: &Cone) -> Self {
        // Inside the light: everything above the horizon.
        let inside = cone.one_minus_cos > 1.0;
        let (axis, one_minus_cos) = if inside { (at.normal, 1.0) } else { (cone.axis, cone.one_minus_cos) };
        let sin_sq = one_minus_cos * (2.0 - one_minus_cos);
        let sin = sin_sq.sqrt();
        let cos_beta = at.normal.dot(axis);
        let below = one_minus_cos <= 0.0 || cos_beta <= -sin;
        Self { axis, one_minus_cos, cos_beta, sin_sq, above: cos_beta >= sin, below }
    }

    #[inline(always)]
    fn pair(&self, at: &Receiver, lobe: &Lobe) -> Pair {
        Pair {
            axis: lobe.axis,
            exponent: lobe.exponent,
            cosine: if lobe.cosine > 0.0 { 1.0 } else { 0.0 },
            normal: at.normal,
            light: self.axis,
            one_minus_cos: self.one_minus_cos,
        }
    }
}

/// How an integral is taken.
#[derive(Clone, Copy)]
enum Form {
    /// It has been.
    Done(f32),
    /// Lambert, a light that the horizon crosses.
    Crossed,
    /// A wide light and a narrow lobe above the horizon.
    Slab,
    /// A light above the horizon.
    Whole,
    /// A light that the horizon crosses.
    Pieces,
    /// A lobe that ends with an infinite slope.
    Edge,
}

impl Form {
    #[inline(always)]
    fn new(at: &Receiver, lobe: &Lobe, light: &Seen) -> Self {
        let e = lobe.exponent;
        if light.below {
            Self::Done(0.0)
        } else if is_lambert(at, lobe) {
            if light.above { Self::Done(light.sin_sq * light.cos_beta) } else { Self::Crossed }
        } else if e >= MIRROR {
            let inside = 0.5 * (lobe.axis - light.axis).length_squared() <= light.one_minus_cos;
            let cos = at.normal.dot(lobe.axis);
            let value = if lobe.cosine > 0.0 { cos } else { 1.0 };
            Self::Done(if inside && cos > 0.0 { value } else { 0.0 })
        } else if e < 1.0 {
            Self::Edge
        } else if !light.above {
            Self::Pieces
        } else if e >= slab::EXPONENT && 0.5 * (e + 1.0) * light.one_minus_cos >= slab::WIDTH {
            Self::Slab
        } else {
            Self::Whole
        }
    }
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
    finish(chord.weight, sum)
}

/// Not below zero, whatever rounding has done.
#[inline(always)]
fn finish(weight: f32, sum: f32) -> f32 {
    let value = weight * sum;
    if value > 0.0 { value } else { 0.0 }
}
