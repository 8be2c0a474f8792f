use crate::kept_maps::KeptMaps;
use crate::kept_points::KeptPoints;

/// Visible points and maps, kept from a picture of one size for the next.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    pub(crate) points: KeptPoints,
    pub(crate) maps: KeptMaps,
}
