//! Reflectance as lobes: what a material writes for one receiver.

use lobe_core::{BrdfLobe, Receiver, Tile, TileLobes};

/// Reflectance as a sum of lobes of `f̃ = f_r·(n·v)` (Eq. 6), cosine included.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{BrdfLobe, Lobe, Receiver};
/// use shading::BrdfLobes;
///
/// /// Reflects back to where the light came from.
/// struct Retro;
///
/// impl BrdfLobes for Retro {
///     fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
///         out.push(Lobe::new(at.view, 40.0, Vec3::splat(2.0)).times_cosine().into());
///     }
/// }
///
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
/// let mut lobes = Vec::new();
/// Retro.brdf_lobes(&at, &mut lobes);
/// let toward_eye = lobes[0].eval_at(at.normal, at.view).x; // 2·(n·v)
/// assert!((toward_eye - 1.6).abs() < 1e-5);
/// ```
pub trait BrdfLobes {
    /// Appends the lobes of `f̃` as seen from `at.view`. All of them are to be understood as zero below the horizon of
    /// `at.normal`. A Lambert lobe has exponent 1 and *exactly* `at.normal` as its axis: integrators know it by that.
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>);

    /// The same by cosine lobes alone, for methods with visibility as lobes: products have closed forms for no others. Provided: the lobe
    /// of a mirror in the place of each lobe of microfacets. A model that knows nearer ones overrides it.
    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        let first = out.len();
        self.brdf_lobes(at, out);
        out[first..].iter_mut().for_each(|lobe| *lobe = lobe.cosine_lobe(at.normal).into());
    }

    /// The lobes of all receivers of a tile, receiver `i` of material `of[i]`. Provided: one receiver after the other. A set of
    /// models that has something faster overrides it; the lobes are to be the same, in the same order, bit for bit.
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    fn tile_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes)
    where
        Self: Sized,
    {
        out.one_by_one(materials, of, at, tile, Self::brdf_lobes);
    }

    /// The same of [`cosine_lobes`](Self::cosine_lobes).
    ///
    /// # Panics
    /// As [`tile_lobes`](Self::tile_lobes).
    fn tile_cosine_lobes(materials: &[Self], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes)
    where
        Self: Sized,
    {
        out.one_by_one(materials, of, at, tile, Self::cosine_lobes);
    }
}

impl<B: BrdfLobes + ?Sized> BrdfLobes for Box<B> {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        (**self).brdf_lobes(at, out);
    }

    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        (**self).cosine_lobes(at, out);
    }
}

// Object-safe.
const _: fn(&dyn BrdfLobes) = |_| {};
