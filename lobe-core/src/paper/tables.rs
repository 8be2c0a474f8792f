use super::{CapTable, ProductTable};
use crate::{Cone, Lobe};
use glam::Vec3;

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
    /// Both tables at the paper's resolution, on this thread: about 5 s.
    #[must_use]
    pub fn build() -> Self {
        Self::with_products(ProductTable::build())
    }

    /// Beside a product table that is already there.
    #[must_use]
    pub fn with_products(products: ProductTable) -> Self {
        Self { products, caps: CapTable::build() }
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
