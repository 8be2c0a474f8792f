//! The normals of OBJ corners that name none: smooth within a smoothing group, the face's own outside of all.

use crate::obj::{Corner, Face};
use glam::{DVec3, Vec3};
use scene::normals::{angle_at, is_usable};
use std::collections::{HashMap, HashSet};

/// The smoothing group that the words after `s` name; 0 for none.
pub(crate) fn smoothing_group<'w>(mut words: impl Iterator<Item = &'w str>) -> u32 {
    match words.next() {
        Some("on") => 1,
        // Some programs write numbers that are negative or have more than 32 bits.
        Some(word) => word.parse().map_or(0, |n: i64| u32::try_from(n.unsigned_abs()).unwrap_or(u32::MAX)),
        None => 0,
    }
}

/// Gives the corners without a normal theirs, and appends it to `normals`. A corner whose normal has no direction counts as one without;
/// returns how many these are. Where no face has a normal or a smoothing group, all stay without.
///
/// The normal of a place in a group is the mean of the normals of all faces of the group there, weighted by their angles, whatever
/// their materials.
pub(crate) fn complete(lists: &mut [Vec<Face>], positions: &[Vec3], normals: &mut Vec<Vec3>) -> usize {
    let mut broken = 0;
    for corner in lists.iter_mut().flatten().flat_map(|face| &mut face.corners) {
        if corner.1.is_some_and(|n| !is_usable(&normals[n as usize])) {
            corner.1 = None;
            broken += 1;
        }
    }
    let says_nothing = |face: &Face| face.group == 0 && face.corners.iter().all(|c| c.1.is_none());
    if lists.iter().flatten().all(says_nothing) {
        return broken;
    }
    let smooth = group_normals(lists, positions);
    // Of a vertex in a group.
    let mut numbers: HashMap<(u32, u32), u32> = HashMap::new();
    for face in lists.iter_mut().flatten() {
        let own = own_normal(&face.corners, positions);
        let mut flat = None;
        for corner in face.corners.iter_mut().filter(|corner| corner.1.is_none()) {
            let mut add = |normal: DVec3| {
                normals.push(normal.as_vec3());
                normals.len() as u32 - 1
            };
            corner.1 = Some(match smooth.get(&(place(corner, positions), face.group)) {
                Some(normal) => *numbers.entry((corner.0, face.group)).or_insert_with(|| add(*normal)),
                None => *flat.get_or_insert_with(|| add(own)),
            });
        }
    }
    broken
}

fn corners_of(corners: &[Corner; 3], positions: &[Vec3]) -> [DVec3; 3] {
    corners.map(|c| positions[c.0 as usize].as_dvec3())
}

/// The face's normal, +y for a face without an area.
fn own_normal(corners: &[Corner; 3], positions: &[Vec3]) -> DVec3 {
    let [a, b, c] = corners_of(corners, positions);
    (b - a).cross(c - a).normalize_or(DVec3::Y)
}

/// The same for corners in one place, whatever their numbers.
fn place(corner: &Corner, positions: &[Vec3]) -> [u32; 3] {
    // −0 and 0 are the same place.
    (positions[corner.0 as usize] + 0.0).to_array().map(f32::to_bits)
}

/// Faces of a group in one place: the sum of their normals by angle, and the normals of the first ones.
#[derive(Default)]
struct Fan {
    sum: DVec3,
    some: Vec<DVec3>,
}

impl Fan {
    /// Faces in one place are compared with this many others at most.
    const COMPARED: usize = 64;

    /// A face whose back another one shows, as in two-sided models, does not count.
    fn add(&mut self, normal: DVec3, angle: f64) {
        if self.some.iter().any(|other| other.dot(normal) < -0.999_999) {
            return;
        }
        self.sum += angle * normal;
        if self.some.len() < Self::COMPARED {
            self.some.push(normal);
        }
    }

    fn mean(&self) -> DVec3 {
        // Below 1e-6 the sum is the rounding error of normals that cancel.
        let some = self.some.first().copied().unwrap_or(DVec3::Y);
        if self.sum.length() > 1e-6 { self.sum.normalize() } else { some }
    }
}

/// By place and group: no group 0.
fn group_normals(lists: &[Vec<Face>], positions: &[Vec3]) -> HashMap<([u32; 3], u32), DVec3> {
    let mut fans: HashMap<([u32; 3], u32), Fan> = HashMap::new();
    // A face that is there twice counts once.
    let mut seen = HashSet::new();
    for face in lists.iter().flatten().filter(|face| face.group > 0) {
        let places = face.corners.map(|corner| place(&corner, positions));
        let mut key = places;
        key.sort_unstable();
        let corners = corners_of(&face.corners, positions);
        let normal = own_normal(&face.corners, positions);
        let has_area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() > 1e-36;
        if !has_area || !seen.insert((key, face.group)) {
            continue;
        }
        for (k, place) in places.into_iter().enumerate() {
            fans.entry((place, face.group)).or_default().add(normal, angle_at(k, &corners));
        }
    }
    fans.into_iter().map(|(at, fan)| (at, fan.mean())).collect()
}
