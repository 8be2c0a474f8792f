//! Pictures of linear RGB values: OpenEXR and PNG files, parts of pictures, comparison and FLIP.
//!
//! ```
//! use glam::Vec3;
//! use pictures::{Comparison, Picture};
//! let reference = Picture::new(2, 1, vec![Vec3::ONE, Vec3::splat(2.0)]);
//! let test = Picture::new(2, 1, vec![Vec3::ONE, Vec3::splat(2.5)]);
//! let error = Comparison::of(&test, &reference).unwrap();
//! assert_eq!((error.mae, error.bias, error.max), (0.25, 0.25, 0.5));
//! ```

#![cfg_attr(not(feature = "files"), expect(dead_code, reason = "files carry stamps and checksums"))]

mod checksum;
mod comparison;
mod display;
mod error_map;
#[cfg(feature = "files")]
mod exr_file;
#[cfg(feature = "files")]
mod exr_layer;
#[cfg(feature = "files")]
mod exr_open;
#[cfg(feature = "files")]
mod exr_part;
mod flip;
mod output;
mod picture;
#[cfg(feature = "files")]
mod png_file;
mod srgb;
#[cfg(feature = "files")]
mod stamp;
#[cfg(feature = "files")]
mod stream;
mod tone;
mod window;

pub use crate::checksum::checksum;
pub use crate::comparison::{Comparison, RegionError, ShadowErrors, SizesDiffer};
pub use crate::display::{Display, PngDepth};
pub use crate::error_map::{FlipMap, signed_difference};
#[cfg(feature = "files")]
pub use crate::exr_file::{read_exr, read_exr_layer, write_exr};
#[cfg(feature = "files")]
pub use crate::exr_layer::ExrLayer;
#[cfg(feature = "files")]
pub use crate::exr_part::{ExrPart, MergeError, merge_exr};
pub use crate::output::{ImageFileError, Output, remove_unfinished, sweep_unfinished};
pub use crate::picture::{Picture, luminance};
#[cfg(feature = "files")]
pub use crate::png_file::{png_bytes, write_png};
pub use crate::srgb::{srgb, srgb_bytes, srgb_to_linear};
#[cfg(feature = "files")]
pub use crate::stamp::read_stamp;
#[cfg(feature = "files")]
pub use crate::stream::PictureStream;
pub use crate::tone::ToneMap;
pub use crate::window::Window;
pub use glam;
