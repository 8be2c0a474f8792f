//! The part of the light that a rough dielectric coat leaves to the base below it: a table over roughness and the view's angle.

use crate::Packer;
use crate::ggx::reflected;
use crate::wgsl::MATERIAL;
use lobe_core::wgsl::Piece;
use lobe_core::wgsl_numbers;
use std::sync::LazyLock;

/// Rows, even in roughness, and columns, even in `√(1 − n·ω_o)`.
const ROUGHNESSES: usize = 17;
const VIEWS: usize = 64;

/// Smallest `α = roughness²`: a lobe of exponent 2e6.
pub(crate) const MIN_ALPHA: f32 = 1e-3;

/// A coat: reflectance at normal and at grazing incidence, and the brightest channel of what is below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coat {
    pub(crate) f0: f32,
    pub(crate) f90: f32,
    pub(crate) base: f32,
}

pub(crate) struct Table {
    /// Mean over a cosine-weighted light of Schlick's `(1 − v·h)⁵`.
    pub(crate) schlick: [f32; VIEWS],
    /// Reflected with `F = 1 − s` and with `F = s`.
    pub(crate) reflected: [[[f32; 2]; VIEWS]; ROUGHNESSES],
}

/// Made with the first use, in some 10 ms.
pub(crate) static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let view = |i: usize| {
        let root = i as f64 / (VIEWS - 1) as f64;
        let cos = 1.0 - root * root;
        [(1.0 - cos * cos).sqrt(), cos]
    };
    let alpha = |i: usize| {
        let roughness = i as f64 / (ROUGHNESSES - 1) as f64;
        (roughness * roughness).max(f64::from(MIN_ALPHA))
    };
    Table {
        schlick: core::array::from_fn(|i| mean_schlick(view(i)) as f32),
        reflected: core::array::from_fn(|r| {
            core::array::from_fn(|i| reflected(alpha(r), view(i)).map(|part| part as f32))
        }),
    }
});

/// Mean of `(1 − v·h)⁵` over the light's directions, weighted by their cosine.
fn mean_schlick([sin, cos]: [f64; 2]) -> f64 {
    let mut sum = 0.0;
    for i in 0..16 {
        let r2 = (f64::from(i) + 0.5) / 16.0;
        let (ls, lz) = (r2.sqrt(), (1.0 - r2).sqrt());
        for j in 0..16 {
            let lx = ls * (core::f64::consts::PI * (f64::from(j) + 0.5) / 16.0).cos();
            // |v + l|² = 4 (v·h)².
            let vh = (0.5 * (1.0 + lz * cos - lx * sin)).max(0.0).sqrt();
            sum += (1.0 - vh).powi(5);
        }
    }
    sum / 256.0
}

impl Coat {
    /// The part of the light that reaches the base and comes back, for a white one, seen at an angle of this cosine and sine.
    ///
    /// Fresnel's reflection lets it through, averaged over the light's directions. It is less where that and the coat's own reflection
    /// would give back more than there is, at grazing views.
    pub(crate) fn leaves(&self, roughness: f32, cos: f32, sin: f32) -> f32 {
        let table = &*TABLE;
        let (column, t) = place(sin / (1.0 + cos).sqrt(), VIEWS);
        let (row, s) = place(roughness, ROUGHNESSES);
        let schlick = mix(table.schlick[column], table.schlick[column + 1], t);
        let [a, b] = [row, row + 1].map(|row| {
            let [low, high] = [table.reflected[row][column], table.reflected[row][column + 1]];
            [mix(low[0], high[0], t), mix(low[1], high[1], t)]
        });
        let reflected = self.f0 * mix(a[0], b[0], s) + self.f90 * mix(a[1], b[1], s);
        let through = 1.0 - self.f0 - (self.f90 - self.f0) * schlick;
        through.min((1.0 - reflected) / self.base.max(1e-9)).max(0.0)
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// The node before a place in [0, 1] and how far it is on to the next.
fn place(at: f32, nodes: usize) -> (usize, f32) {
    let at = at.clamp(0.0, 1.0) * (nodes - 1) as f32;
    let first = (at as usize).min(nodes - 2);
    (first, at - first as f32)
}

/// The WGSL of the base under a coat.
pub(crate) static WGSL: Piece = Piece::new(include_str!("coat.wgsl"))
    .numbers(wgsl_numbers![COAT_ROUGHNESSES = ROUGHNESSES, COAT_VIEWS = VIEWS])
    .needs(&[&MATERIAL]);

/// Where the packed table begins.
pub(crate) fn pack(out: &mut Packer) -> u32 {
    out.table(&*TABLE, |table, out| {
        out.push(table.schlick);
        out.push(table.reflected.as_flattened().as_flattened().iter().copied());
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_what_is_reflected_between_its_nodes() {
        // Up to 80°, and beyond, where smooth coats reflect a few per cent more with every degree.
        let mut worst = [0.0_f32; 2];
        for roughness in [0.05_f32, 0.11, 0.23, 0.4, 0.55, 0.78, 0.97] {
            for degrees in [0.0_f64, 10.0, 33.0, 51.0, 66.0, 78.0, 84.0, 88.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let [a, b] = reflected(f64::from(roughness * roughness).max(1e-3), [sin, cos]);
                for (f0, f90) in [(0.04, 1.0), (0.0, 1.0), (1.0, 1.0)] {
                    // A base so bright that what is left is what is not reflected.
                    let got = Coat { f0, f90, base: 1.0 }.leaves(roughness, cos as f32, sin as f32);
                    let through = 1.0 - f0 - (f90 - f0) * mean_schlick([sin, cos]) as f32;
                    let want = through.min(1.0 - f0 * a as f32 - f90 * b as f32);
                    let worst = &mut worst[usize::from(degrees > 80.0)];
                    *worst = worst.max((got - want).abs());
                }
            }
        }
        println!("worst {worst:?}");
        assert!(worst[0] < 2e-3 && worst[1] < 0.012, "{worst:?}");
    }
}
