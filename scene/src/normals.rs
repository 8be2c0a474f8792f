//! Measures that smooth normals are made with, and places that share them.

pub use crate::windings::faces_against;
use core::hash::BuildHasher;
use foldhash::fast::RandomState;
use glam::{DVec3, Vec3};

/// Whether a normal has a direction.
#[must_use]
#[inline]
pub fn is_usable(normal: &Vec3) -> bool {
    normal.is_finite() && normal.length() > 1e-20
}

/// The angle of a triangle at its corner `k`, in radians, of its corners' positions.
#[must_use]
#[inline]
pub fn angle_at(k: usize, corners: &[DVec3; 3]) -> f64 {
    let (to_next, to_last) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
    to_next.cross(to_last).length().atan2(to_next.dot(to_last))
}

/// For each position the number of its place: the same for the same positions.
#[must_use]
pub fn same_places(positions: &[Vec3]) -> Vec<u32> {
    // Places by the hashes of their positions, plus one; small, since it is read at random.
    let mut table = vec![0_u32; (2 * positions.len()).next_power_of_two()];
    let (last, hasher) = (table.len() - 1, RandomState::default());
    // −0 and 0 are the same place.
    let bits = |p: Vec3| (p + 0.0).to_array().map(f32::to_bits);
    let mut places: Vec<Vec3> = Vec::new();
    let number = |p: &Vec3| {
        let own = bits(*p);
        let mut slot = hasher.hash_one(own) as usize & last;
        while let Some(place) = table[slot].checked_sub(1) {
            if bits(places[place as usize]) == own {
                return place;
            }
            slot = (slot + 1) & last;
        }
        places.push(*p);
        table[slot] = places.len() as u32;
        places.len() as u32 - 1
    };
    positions.iter().map(number).collect()
}
