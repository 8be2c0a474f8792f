//! The visibility of a whole sky: one search, one buffer.
//!
//! Light from all around is seen through half great circles from a [`Pole`], the [`Meridians`], which outlines of blockers cross. A
//! [`SkyBuffer`] counts surfaces along them, a [`SkyTable`] holds the sky's light in the same samples, a [`SkyView`] sums over what is
//! seen. [`SkyBlockers`] draw.
//!
//! ```
//! use glam::Vec3;
//! use lobe_core::{Lobe, Receiver};
//! use visibility_mask::sky::{Horizon, SkyResolution, SkyTable, SkyView};
//! let table = SkyTable::new(SkyResolution::new(64, 64), 1, |_| Vec3::ONE);
//! let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
//! let mut view = SkyView::default();
//! view.begin(&table, Horizon::new(&at, false));
//! // Nothing is drawn, and the ray meets nothing.
//! view.settle(&table, false, |_| false);
//! let [seen, all] = view.integrals(&table, &at, &Lobe::new(at.normal, 1.0, Vec3::ONE).into());
//! assert!(seen == all && (all.x - 1.0).abs() < 1e-3);
//! ```

mod arcs;
mod blend;
mod blockers;
pub(crate) mod buffer;
pub(crate) mod crowd;
mod highlight;
mod horizon;
pub(crate) mod meridians;
#[cfg(test)]
mod narrow_tests;
pub(crate) mod pole;
pub(crate) mod spread;
mod table;
#[cfg(test)]
mod tests;
pub(crate) mod view;
mod window;
mod witnesses;

pub use self::arcs::SkyArcs;
pub use self::blend::SkyBlend;
pub use self::blockers::{SkyBlockers, SkyTile};
pub use self::buffer::SkyBuffer;
pub use self::highlight::SkyHighlight;
pub use self::horizon::Horizon;
pub use self::meridians::{Meridians, SkyResolution};
pub use self::pole::Pole;
pub use self::table::SkyTable;
pub use self::view::SkyView;
pub use self::window::SkyWindow;
pub use self::witnesses::Witnesses;
