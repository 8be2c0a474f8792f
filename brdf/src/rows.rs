//! Tables of GGX's cosine lobes, and the lobes that they give.

use crate::Packer;
use crate::coat::MIN_ALPHA;
use crate::ggx::{FAMILY_COUNT, Row, SPREAD};
use crate::wgsl::TURN;
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::wgsl_numbers;
use lobe_core::{Lobe, Receiver, orthonormal_basis};
use std::sync::{Arc, OnceLock};

/// Rows of a table over the view, even in `√(1 − n·ω_o)`, which is all but even in the angle.
pub(crate) const ROWS: usize = 48;

pub(crate) type Rows = [Row; ROWS];

/// The rows of a metallic–roughness material's cosine lobes, made when they are first needed (some milliseconds).
#[derive(Clone, Debug)]
pub(crate) enum RowTable {
    /// Its own.
    Own(Arc<OnceLock<Box<Rows>>>),
    /// Those of the nearest of some roughnesses and reflectances, for materials as many as points.
    Shared,
}

const LEVELS: usize = 256;
const REFLECTANCES: usize = 4;

static SHARED: [[OnceLock<Box<Rows>>; LEVELS]; REFLECTANCES] =
    [const { [const { OnceLock::new() }; LEVELS] }; REFLECTANCES];

impl RowTable {
    pub(crate) fn own() -> Self {
        Self::Own(Arc::default())
    }

    /// For a roughness and a mean reflectance at normal incidence.
    pub(crate) fn get(&self, roughness: f32, f0: f32) -> &Rows {
        match self {
            Self::Own(rows) => rows.get_or_init(|| make(roughness, f0)),
            Self::Shared => Self::shared(roughness, f0),
        }
    }

    /// The nearest of those that many materials share.
    pub(crate) fn shared(roughness: f32, f0: f32) -> &'static Rows {
        let (level, steps) = ((LEVELS - 1) as f32, (REFLECTANCES - 1) as f32);
        let [r, f] = [(roughness * level).round(), (f0 * steps).round()];
        // The least is that of a dielectric.
        SHARED[f as usize][r as usize].get_or_init(|| make(r / level, (f / steps).max(0.04)))
    }
}

fn make(roughness: f32, f0: f32) -> Box<Rows> {
    let alpha = f64::from((roughness * roughness).max(MIN_ALPHA));
    Box::new(core::array::from_fn(|i| {
        let root = i as f64 / (ROWS - 1) as f64;
        let cos = 1.0 - root * root;
        Row::new(alpha, [(1.0 - cos * cos).sqrt(), cos], f64::from(f0))
    }))
}

/// The most cosine lobes for a roughness.
pub(crate) const LOBES: usize = 8;

/// Cosine lobes for reflectances at normal and grazing incidence.
pub(crate) fn lobes(rows: &Rows, [f0, f90]: [Vec3; 2], at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
    let n = at.normal;
    let cos = n.dot(at.view).clamp(0.0, 1.0);
    // Views below the horizon, which smooth normals have, are taken as at it.
    let along = n * n.dot(at.view) - at.view;
    let length = along.length();
    let forward = if length > 1e-12 { along / length } else { orthonormal_basis(n).0 };
    let sin = length.min(1.0);
    let (first, t) = row_place(cos, sin);
    let row = rows[first].lerp(&rows[first + 1], t);
    let (mirror, beside) = (n * cos + forward * sin, forward * cos - n * sin);
    let (mirror, beside) = (mirror.normalize_or(n), beside.normalize_or(forward));

    let mut lobes = [None; 3 * FAMILY_COUNT];
    for (k, family) in row.families.iter().enumerate() {
        let flux = f0 * family.flux[0] + f90 * family.flux[1];
        if flux == Vec3::ZERO {
            continue;
        }
        let axis = |angle: f32| (mirror * angle.cos() + beside * angle.sin()).normalize();
        // So near each other that they are one.
        let single = family.spread * family.spread * (family.exponent + 2.0) < 1e-3;
        for (i, share) in SPREAD.into_iter().enumerate() {
            let place = i as f32 - 1.0;
            lobes[3 * k + i] = match single {
                true if i == 1 => Some(Lobe::with_flux(axis(family.tilt), family.exponent, flux)),
                true => None,
                false => {
                    let axis = axis(family.tilt + place * family.spread);
                    Some(Lobe::with_flux(axis, family.exponent, flux * share))
                }
            };
        }
    }
    lobes.into_iter().flatten()
}

/// The row before a view and how far the view is on to the next, without the cancellation of `√(1 − cos)`.
fn row_place(cos: f32, sin: f32) -> (usize, f32) {
    let at = (sin / (1.0 + cos).sqrt()).clamp(0.0, 1.0) * (ROWS - 1) as f32;
    let first = (at as usize).min(ROWS - 2);
    (first, at - first as f32)
}

/// The WGSL of a lobe of directions.
pub(crate) static WGSL: Piece = Piece::new(include_str!("row_lobe.wgsl"))
    .numbers(wgsl_numbers![METAL_ROWS = ROWS, METAL_ROW_WORDS = 5 * FAMILY_COUNT])
    .needs(&[&TURN]);

/// Where packed rows begin.
pub(crate) fn pack(rows: &Rows, out: &mut Packer) -> u32 {
    out.table(rows, |rows, out| {
        for f in rows.iter().flat_map(|row| &row.families) {
            out.push([f.flux[0], f.flux[1], f.tilt, f.spread, f.exponent]);
        }
    })
}

/// For each lobe of directions its word, and how many there are; those of a base come first.
pub(crate) fn slots(rows: &Rows, has_base: u32) -> ([u32; 9], u32) {
    let mut slots = [0; 9];
    let mut lobes = has_base as usize;
    for k in 0..FAMILY_COUNT {
        let families = || rows.iter().map(|row| &row.families[k]);
        // Without F0 all that is left of a family is its grazing part.
        let places = match families().any(|family| family.flux != [0.0; 2]) {
            false => 0..0,
            true if families().all(|family| family.spread == 0.0) => 1..2,
            true => 0..3,
        };
        for place in places {
            slots[lobes] = 1 + 3 * k as u32 + place;
            lobes += 1;
        }
    }
    (slots, lobes as u32)
}
