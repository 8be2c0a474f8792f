use crate::cap_table::VALUES;
use crate::{CapTable, ProductTable};
use glam::Vec3;
use lobe_core::{Cone, Lobe};

/// Pairs before the caps and before the products, as [`Tables::pack`] writes them.
pub(crate) const CAPS: usize = 1;
pub(crate) const PRODUCTS: usize = CAPS + 2 * VALUES;

/// The tables that the paper's method looks up while it renders: products (§4.1), light and occluder lobes (Eqs. 31, 35).
///
/// Independent of the scene: build once, share by reference.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Products of two lobes.
    pub products: ProductTable,
    /// Lobes of lights and occluders.
    pub caps: CapTable,
}

impl Tables {
    /// Both tables at the paper's resolution, on this thread: about 4 s.
    #[must_use]
    pub fn build() -> Self {
        Self::with_products(ProductTable::build())
    }

    /// Beside a product table that is already there.
    #[must_use]
    pub fn with_products(products: ProductTable) -> Self {
        Self { products, caps: CapTable::build() }
    }

    /// The tables as the WGSL of [`wgsl::TABLES`](crate::wgsl::TABLES) reads them, 4.3 MB at the paper's resolution:
    ///
    /// | pairs | hold |
    /// |---|---|
    /// | 1 | angles, exponents an interval |
    /// | 2 × 1000 | by `1 − cos θ`: `w_light`, `(e_light+1)(1−C)`; `(e_cap+1)(1−C)`, 0 |
    /// | the rest | products: `p_r`, `e_r` by row (e1), then e2 ≥ e1, then angle |
    ///
    /// Pairs that a caller appends begin where `paper_end()` says.
    #[must_use]
    pub fn pack(&self) -> Vec<[f32; 2]> {
        let resolution = self.products.resolution();
        let mut pairs = vec![[resolution.angles as f32, resolution.per_interval as f32]];
        let row = |[weight, light, occluder]: &[f32; 3]| [[*weight, *light], [*occluder, 0.0]];
        pairs.extend(self.caps.rows().iter().flat_map(row));
        pairs.extend(self.products.entries());
        pairs
    }

    /// The least-squares lobe of a light (Eqs. 30, 31).
    #[must_use]
    pub fn light_lobe(&self, cone: &Cone, radiance: Vec3) -> Lobe {
        self.caps.light(cone, radiance)
    }

    /// The product of two lobes as a lobe (Eqs. 15–17).
    #[must_use]
    pub fn product(&self, c1: &Lobe, c2: &Lobe) -> Lobe {
        self.products.product(c1, c2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Resolution;

    #[test]
    fn packed_as_wgsl_reads_them() {
        let resolution = Resolution { angles: 5, per_interval: 3 };
        let tables = Tables::with_products(ProductTable::build_with(resolution));
        let pairs = tables.pack();
        assert_eq!(pairs[0], [5.0, 3.0]);
        assert_eq!(pairs[PRODUCTS..], *tables.products.entries());
        assert_eq!(pairs.len(), PRODUCTS + 5 * 13 * 14 / 2);
    }
}
