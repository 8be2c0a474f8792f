use crate::coat::MIN_ALPHA;
use crate::ggx::Row;
use std::sync::{Arc, OnceLock};

/// Rows of a table over the view, even in `√(1 − n·ω_o)`, which is all but even in the angle.
pub(crate) const ROWS: usize = 48;

pub(crate) type Rows = [Row; ROWS];

/// The rows of a metallic–roughness material's lobes of directions, made when they are first asked for (some milliseconds).
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
            Self::Shared => {
                let (level, steps) = ((LEVELS - 1) as f32, (REFLECTANCES - 1) as f32);
                let [r, f] = [(roughness * level).round(), (f0 * steps).round()];
                // The least is that of a dielectric.
                SHARED[f as usize][r as usize].get_or_init(|| make(r / level, (f / steps).max(0.04)))
            }
        }
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
