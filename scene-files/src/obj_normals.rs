//! The normals of OBJ corners that name none: smooth within a smoothing group, the face's own outside of all.

use crate::obj::{Corner, Face};
use foldhash::fast::RandomState;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::normals::{angle_at, faces_against, is_usable, same_places};
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
/// their materials. Faces that wind against the most of those around them are turned round.
pub(crate) fn complete(lists: &mut [Vec<Face>], positions: &[Vec3], normals: &mut Vec<Vec3>) -> usize {
    let mut broken = 0;
    for corner in lists.iter_mut().flatten().flat_map(|face| &mut face.corners) {
        if corner.1.is_some_and(|n| !is_usable(&normals[n as usize])) {
            corner.1 = None;
            broken += 1;
        }
    }
    let says_nothing = |face: &Face| face.group == 0 && face.corners.iter().all(|c| c.1.is_none());
    let has_all = |face: &Face| face.corners.iter().all(|c| c.1.is_some());
    if lists.iter().flatten().all(says_nothing) || lists.iter().flatten().all(has_all) {
        return broken;
    }
    let places = same_places(positions);
    align_windings(lists, &places);
    let smooth = Smooth::of(lists, positions, &places);
    let first = normals.len() as u32;
    normals.extend(&smooth.normals);
    for face in lists.iter_mut().flatten() {
        let own = own_normal(&face.corners, positions);
        let mut flat = None;
        for corner in face.corners.iter_mut().filter(|corner| corner.1.is_none()) {
            let fan = smooth.fans.get(&(places[corner.0 as usize], face.group)).map(|fan| first + fan);
            corner.1 = fan.or_else(|| {
                flat = flat.or_else(|| {
                    normals.push(own.as_vec3());
                    Some(normals.len() as u32 - 1)
                });
                flat
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

/// Turns the faces round that wind against the most of those around them.
fn align_windings(lists: &mut [Vec<Face>], places: &[u32]) {
    let by_place = |face: &Face| face.corners.map(|corner| places[corner.0 as usize]);
    let triangles: Vec<[u32; 3]> = lists.iter().flatten().map(by_place).collect();
    let against = faces_against(&triangles);
    for (face, _) in lists.iter_mut().flatten().zip(against.iter().flatten()).filter(|(_, against)| **against) {
        face.corners.swap(1, 2);
    }
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

    fn clear(&mut self) {
        self.sum = DVec3::ZERO;
        self.some.clear();
    }

    fn mean(&self) -> DVec3 {
        // Below 1e-6 the sum is the rounding error of normals that cancel.
        let some = self.some.first().copied().unwrap_or(DVec3::Y);
        if self.sum.length() > 1e-6 { self.sum.normalize() } else { some }
    }
}

/// The smooth normals of groups.
struct Smooth {
    /// By place and group, no group 0: a number of a normal.
    fans: HashMap<(u32, u32), u32, RandomState>,
    normals: Vec<Vec3>,
}

impl Smooth {
    fn of(lists: &[Vec<Face>], positions: &[Vec3], places: &[u32]) -> Self {
        let mut fans: HashMap<(u32, u32), u32, RandomState> = HashMap::default();
        // Of each fan the number of its faces.
        let mut counts: Vec<u32> = Vec::new();
        let mut faces: Vec<(&Face, [u32; 3])> = Vec::new();
        // A face that is there twice counts once.
        let mut seen: HashSet<([u32; 3], u32), RandomState> = HashSet::default();
        for face in lists.iter().flatten().filter(|face| face.group > 0) {
            let at = face.corners.map(|corner| places[corner.0 as usize]);
            let mut key = at;
            key.sort_unstable();
            let [a, b, c] = corners_of(&face.corners, positions);
            if (b - a).cross(c - a).length() <= 1e-36 || !seen.insert((key, face.group)) {
                continue;
            }
            let own = at.map(|place| {
                let fan = *fans.entry((place, face.group)).or_insert(counts.len() as u32);
                if fan as usize == counts.len() {
                    counts.push(0);
                }
                counts[fan as usize] += 1;
                fan
            });
            faces.push((face, own));
        }
        let mut firsts = vec![0; counts.len() + 1];
        for (fan, count) in counts.iter().enumerate() {
            firsts[fan + 1] = firsts[fan] + count;
        }
        let (mut next, mut members) = (firsts.clone(), vec![0_u32; 3 * faces.len()]);
        for (number, (_, fans)) in faces.iter().enumerate() {
            for &fan in fans {
                members[next[fan as usize] as usize] = number as u32;
                next[fan as usize] += 1;
            }
        }
        let normal = |all: &mut Fan, fan: usize| {
            all.clear();
            for &number in &members[firsts[fan] as usize..firsts[fan + 1] as usize] {
                let (face, fans) = faces[number as usize];
                let corners = corners_of(&face.corners, positions);
                let k = fans.iter().position(|other| *other as usize == fan).unwrap_or(0);
                all.add(own_normal(&face.corners, positions), angle_at(k, &corners));
            }
            all.mean().as_vec3()
        };
        let normals = (0..counts.len()).into_par_iter().map_init(Fan::default, normal).collect();
        Self { fans, normals }
    }
}
