//! All maps in one buffer of words, as the WGSL reads them.
//!
//! Floats are stored by their bits. Word 0 is the number n of objects that [`ShadowMapBlockers::with_casters`] and
//! [`ShadowMapBlockers::leaving`] list. In word `1 + k / 16` bit `2 (k % 16)` says whether object k casts, and the next bit whether
//! its receivers are left to other blockers. Then comes the number of light numbers that follow, and for each light of the frame
//! the place of its map, 0 without one. Then, each at a place that another record names:
//!
//! | part | words |
//! |---|---|
//! | map | number of faces, then the faces |
//! | face ([`FACE`]) | right, up, forward (9), left, bottom, side of a texel, z₀ (4), width, height, number of layers (3), their places (4) |
//! | layer | levels of the pyramid, place of the texels, place of each level from the first |
//! | texels | q, row by row; [`EMPTY`] without a surface |
//! | level | nodes row by row: least q, largest q, deviation, place of the texels' corners (4 words) |
//! | corners | of the node's four texels, q at their four corners; only of level 1 where they are not means of four texels |
//!
//! Nothing is infinite: WGSL does not promise infinities.

use crate::blockers::ShadowMapBlockers;
use crate::face::Face;
use crate::layer::{Layer, MEANS};
use crate::map::ShadowMap;
use crate::wgsl;
use core::sync::atomic::{AtomicU64, Ordering};
use lobe_core::Sphere;
use lobe_core::wgsl::Piece;
use shading::LightId;
use shading::gpu::{GpuBlockers, GpuBuffer, GpuContents};
use std::sync::{Arc, Weak};

/// Words of a face.
pub(crate) const FACE: usize = 20;
/// The q of a texel without a surface; others are above −1.
const EMPTY: f32 = -1e20;
/// The deviation of a node that has empty texels.
const UNEVEN: f32 = 1e20;

/// The maps of [`ShadowMapBlockers`] as one buffer for the GPU.
#[derive(Clone, Debug, Default)]
pub struct PackedMaps {
    words: Vec<u32>,
    maps: Vec<Place>,
    /// Differs for all contents that this buffer has ever had.
    revision: u64,
}

/// The place of a map.
#[derive(Clone, Debug)]
struct Place {
    id: LightId,
    light: Sphere,
    /// The faces that were packed, for as long as they exist.
    faces: Weak<[Face]>,
    from: usize,
    to: usize,
}

impl Place {
    fn new(id: LightId, map: &ShadowMap, from: usize, to: usize) -> Self {
        Self { id, light: map.light, faces: Arc::downgrade(&map.faces), from, to }
    }

    /// Whether the record is of this map or of a clone of it.
    fn is_of(&self, map: &ShadowMap) -> bool {
        self.light == map.light && Weak::ptr_eq(&self.faces, &Arc::downgrade(&map.faces))
    }
}

impl PackedMaps {
    /// The words that the kernels read by `maps_word`: 9.3 bytes a texel and layer, 16 more for texels at outlines (a body over a
    /// floor, four layers: 39 MiB at 1024², 155 MiB at 2048²). On a device with smaller bindings they are bound in
    /// [`GpuPages`](shading::gpu::GpuPages).
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The place of a light's map; 0 for a light without one, which is not shadowed.
    #[must_use]
    pub fn map_of(&self, light: LightId) -> u32 {
        self.maps.iter().find(|place| place.id == light).map_or(0, |place| place.from as u32)
    }

    /// Replaces the maps by those of other blockers, such as those of the next frame. Maps that are already there (the same or
    /// clones, in the same order) stay; others replace earlier maps in place; if one does not fit, all are packed again. Returns
    /// the number of words written, 0 if nothing has changed.
    pub fn update(&mut self, blockers: &ShadowMapBlockers) -> usize {
        let maps = blockers.maps();
        if self.maps.len() != maps.len() {
            return self.renew(blockers);
        }
        for (place, id) in self.maps.iter_mut().zip(blockers.lights()) {
            place.id = *id;
        }
        let mut head = pack_objects(blockers.objects());
        self.pack_lights(&mut head, blockers.lights());
        let room = self.maps.first().map_or(self.words.len(), |place| place.from);
        if room != head.len() {
            return self.renew(blockers);
        }
        let mut written = 0;
        if self.words[..head.len()] != head {
            self.words[..head.len()].copy_from_slice(&head);
            written = head.len();
        }
        let mut words = Vec::new();
        for (place, map) in self.maps.iter_mut().zip(maps).filter(|(place, map)| !place.is_of(map)) {
            words.clear();
            pack_map(map, place.from, &mut words);
            let Some(room) = self.words[place.from..place.to].get_mut(..words.len()) else {
                return self.renew(blockers);
            };
            room.copy_from_slice(&words);
            written += words.len();
            *place = Place::new(place.id, map, place.from, place.to);
        }
        if written > 0 {
            self.revision = next_revision();
        }
        written
    }

    /// Appends the place of each light's map, as far as it is known.
    fn pack_lights(&self, words: &mut Vec<u32>, lights: &[LightId]) {
        let count = count_of_numbers(lights);
        words.push(count);
        words.extend((0..count).map(|number| self.map_of(LightId(number))));
    }

    fn renew(&mut self, blockers: &ShadowMapBlockers) -> usize {
        self.revision = next_revision();
        self.words = pack_objects(blockers.objects());
        let lights = self.words.len();
        self.words.resize(lights + 1 + count_of_numbers(blockers.lights()) as usize, 0);
        self.maps.clear();
        for (id, map) in blockers.lights().iter().zip(blockers.maps()) {
            let from = self.words.len();
            pack_map(map, 0, &mut self.words);
            self.maps.push(Place::new(*id, map, from, self.words.len()));
        }
        let mut table = Vec::new();
        self.pack_lights(&mut table, blockers.lights());
        self.words[lights..][..table.len()].copy_from_slice(&table);
        self.words.len()
    }

    /// Bytes before all maps in [`words`](Self::words), for these numbers of objects and lights.
    #[must_use]
    pub const fn bytes_before_maps(objects: usize, lights: usize) -> u64 {
        4 * (2 + objects.div_ceil(16) + lights) as u64
    }
}

/// A strategy of the GPU: call [`update`](Self::update), and pass it to the shader again.
impl GpuBlockers for PackedMaps {
    fn name(&self) -> &'static str {
        "maps"
    }

    fn coverage(&self) -> &'static Piece {
        &wgsl::COVERAGE
    }

    fn splat(&self) -> &'static Piece {
        &wgsl::SPLAT
    }

    fn buffers(&self) -> Vec<GpuBuffer<'_>> {
        let contents = GpuContents::Pages { words: &self.words, revision: self.revision };
        vec![GpuBuffer { name: "maps", element: "u32", contents }]
    }
}

/// More lights than a frame has: larger light numbers get no place.
const LIGHTS: u32 = 1 << 20;

/// The largest number of a light with a map, plus one.
fn count_of_numbers(lights: &[LightId]) -> u32 {
    lights.iter().map(|light| light.0).filter(|light| *light < LIGHTS).map(|light| light + 1).max().unwrap_or(0)
}

fn next_revision() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

impl ShadowMap {
    /// Bytes that the map takes among [`PackedMaps::words`].
    #[must_use]
    pub fn packed_bytes(&self) -> u64 {
        let of = |face: &Face| FACE + face.layers.iter().map(layer_words).sum::<usize>();
        4 * (1 + self.faces.iter().map(of).sum::<usize>()) as u64
    }
}

/// The words of a layer.
fn layer_words(layer: &Layer) -> usize {
    let area = |level| {
        let (columns, rows) = layer.size(level);
        columns * rows
    };
    let nodes: usize = (1..=layer.top()).map(area).sum();
    2 + layer.top() as usize + layer.q().len() + 4 * nodes + 16 * layer.outlines().len()
}

impl ShadowMapBlockers {
    /// Packs everything into one buffer, for the WGSL in [`wgsl`](crate::wgsl).
    ///
    /// # Cost
    /// A copy of the maps.
    #[must_use]
    pub fn pack(&self) -> PackedMaps {
        let mut packed = PackedMaps::default();
        packed.renew(self);
        packed
    }
}

/// The words before the first map.
fn pack_objects(objects: impl Iterator<Item = [bool; 2]>) -> Vec<u32> {
    let mut words = vec![0];
    for (k, [casts, is_left]) in objects.enumerate() {
        words.resize(2 + k / 16, 0);
        words[1 + k / 16] |= (u32::from(casts) | u32::from(is_left) << 1) << (2 * (k % 16));
        words[0] += 1;
    }
    words
}

/// Appends a map to words that follow `before` others.
fn pack_map(map: &ShadowMap, before: usize, words: &mut Vec<u32>) {
    words.push(map.faces.len() as u32);
    let first = words.len();
    words.resize(first + FACE * map.faces.len(), 0);
    for (k, face) in map.faces.iter().enumerate() {
        let record = pack_face(face, before, words);
        words[first + FACE * k..][..FACE].copy_from_slice(&record);
    }
}

/// Appends the face's layers, and returns the face's record, which names their places.
fn pack_face(face: &Face, before: usize, out: &mut Vec<u32>) -> [u32; FACE] {
    let mut record = [0; FACE];
    let axes = [face.frame.right, face.frame.up, face.frame.forward].map(|axis| axis.as_vec3().to_array());
    let numbers = [face.left, face.bottom, face.texel, face.z0].map(|x| x as f32);
    for (word, x) in record.iter_mut().zip(axes.as_flattened().iter().chain(&numbers)) {
        *word = x.to_bits();
    }
    record[13..16].copy_from_slice(&[face.width as u32, face.height as u32, face.layers.len() as u32]);
    for (word, layer) in record[16..].iter_mut().zip(&face.layers) {
        *word = pack_layer(layer, before, out);
    }
    record
}

fn pack_layer(layer: &Layer, before: usize, out: &mut Vec<u32>) -> u32 {
    let (at, top) = (out.len(), layer.top());
    out.resize(at + 2 + top as usize, 0);
    (out[at], out[at + 1]) = (top, (before + out.len()) as u32);
    out.extend(layer.q().iter().map(|q| q.max(EMPTY).to_bits()));
    for level in 1..=top {
        out[at + 1 + level as usize] = (before + out.len()) as u32;
        let (columns, rows) = layer.size(level);
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            let node = layer.node(level, i, j);
            let numbers = [node.min.min(1.0 - EMPTY), node.max.max(EMPTY), node.deviation.min(UNEVEN)];
            out.extend(numbers.map(f32::to_bits));
            out.push(if level == 1 { layer.place(i, j) } else { MEANS });
        }
    }
    // The places of the corners are known only now.
    let (columns, rows) = layer.size(1);
    let (nodes, place) = (out[at + 2] as usize - before, (before + out.len()) as u32);
    for word in out[nodes..][..4 * columns * rows].iter_mut().skip(3).step_by(4) {
        if *word != MEANS {
            *word = place + 16 * *word;
        }
    }
    out.extend(layer.outlines().as_flattened().as_flattened().iter().map(|q| q.max(EMPTY).to_bits()));
    (before + at) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MapOptions, layer};
    use glam::Vec3;
    use lobe_core::oracle::Random;

    /// As `map_corner` of layer.wgsl reads it.
    fn corner(words: &[u32], at: usize, layer: &Layer, (i, j, k): (usize, usize, usize)) -> f32 {
        let float = |k: usize| f32::from_bits(words[k]);
        let (columns, _) = layer.size(1);
        let table = words[words[at + 2] as usize + 4 * (j / 2 * columns + i / 2) + 3];
        if table != MEANS {
            return float(table as usize + 4 * ((i & 1) + 2 * (j & 1)) + k);
        }
        let (x, y) = (i + usize::from(k == 1 || k == 2) - 1, j + (k >> 1) - 1);
        let q = |x: usize, y: usize| float(words[at + 1] as usize + y * layer.size(0).0 + x);
        ((q(x, y) + q(x + 1, y + 1)) + (q(x + 1, y) + q(x, y + 1))) / 4.0
    }

    /// A slanted quadrilateral over the origin, drawn for a light above it.
    fn map(x: f32, resolution: u32) -> ShadowMap {
        let corners = [
            Vec3::new(-1.0, 1.0, -1.0),
            Vec3::new(1.0, 1.2, -1.0),
            Vec3::new(1.0, 1.2, 1.0),
            Vec3::new(-1.0, 1.0, 1.0),
        ];
        let light = Sphere { center: Vec3::new(x, 5.0, 0.3), radius: 0.2 };
        let options = MapOptions { resolution, ..MapOptions::default() };
        ShadowMap::build(&corners, &[[0, 1, 2], [0, 2, 3]], light, &options).expect("a quad")
    }

    #[test]
    fn only_maps_that_have_changed_are_packed() {
        let of = |maps: &[&ShadowMap]| {
            ShadowMapBlockers::new(maps.iter().copied().cloned().collect()).with_casters(vec![true, false])
        };
        let (a, b, c) = (map(-1.0, 64), map(0.0, 64), map(1.0, 32));
        let mut packed = of(&[&a, &b, &c]).pack();
        let all = packed.words.len();
        assert_eq!(packed.update(&of(&[&a, &b, &c])), 0);
        // Only the casters change.
        assert_eq!(packed.update(&of(&[&a, &b, &c]).with_casters(vec![false, true])), 6);
        assert_eq!(packed.update(&of(&[&a, &b, &c])), 6);
        // A smaller map replaces the second one in place.
        for map in [&a, &b, &c] {
            let mut alone = Vec::new();
            pack_map(map, 0, &mut alone);
            assert_eq!(map.packed_bytes(), 4 * alone.len() as u64);
        }
        let small = map(0.5, 32);
        let before = packed.words.clone();
        let written = packed.update(&of(&[&a, &small, &c]));
        assert!(written > 100 && written < all / 2, "{written} of {all}");
        assert_eq!((packed.map_of(LightId(3)), packed.map_of(LightId(1))), (0, packed.maps[1].from as u32));
        let mut alone = Vec::new();
        pack_map(&small, packed.maps[1].from, &mut alone);
        assert_eq!(packed.words[packed.maps[1].from..][..written], alone);
        for other in [0, 2] {
            let place = packed.maps[other].from..packed.maps[other].to;
            assert_eq!(packed.words[place.clone()], before[place]);
        }
        // A larger map: all are packed again, as if new. The same with fewer maps.
        let large = map(0.5, 128);
        for maps in [&[&a, &large, &c][..], &[&a, &c], &[]] {
            let want = of(maps).pack();
            assert_eq!(packed.update(&of(maps)), want.words.len());
            assert_eq!(packed.words, want.words);
        }
        assert_eq!(packed.update(&of(&[]).with_casters(vec![true; 40])), 5);
    }

    #[test]
    fn a_layer_is_what_its_words_say() {
        let mut random = Random::new(7);
        let (width, height) = (29, 22);
        // A smooth layer, a step, holes.
        let q: Vec<f32> = (0..width * height)
            .map(|k| {
                let (x, y) = ((k % width) as f32, (k / width) as f32);
                let step = if x + 0.5 * y > 21.0 { 1.5 } else { 0.0 };
                if random.uniform() < 0.01 { layer::EMPTY } else { (0.1 * x).sin() * 0.1 + 0.003 * y * y * 0.1 + step }
            })
            .collect();
        let layer = Layer::new(width, height, 0.05, q.clone()).expect("a surface");
        let mut words = vec![0; 3];
        let at = pack_layer(&layer, 0, &mut words) as usize;
        assert_eq!((at, words[at]), (3, layer.top()));
        let (mut means, mut tables) = (0, 0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            if q[y * width + x] == layer::EMPTY {
                assert_eq!(f32::from_bits(words[words[at + 1] as usize + y * width + x]), EMPTY);
                continue;
            }
            let got = [0, 1, 2, 3].map(|k| corner(&words, at, &layer, (x, y, k)));
            assert_eq!(got, layer.corners(0, x, y), "{x} {y}");
            if layer.is_smooth(x / 2, y / 2) { means += 1 } else { tables += 1 }
        }
        assert!(means > 100 && tables > 100, "{means} {tables}");
        for level in 1..=layer.top() {
            let (columns, rows) = layer.size(level);
            for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
                let node = words[at + 1 + level as usize] as usize + 4 * (j * columns + i);
                let [min, max, deviation] = [0, 1, 2].map(|k| f32::from_bits(words[node + k]));
                let want = layer.node(level, i, j);
                assert_eq!(min > max, want.is_empty());
                if !want.is_empty() {
                    assert_eq!((min, max, deviation), (want.min, want.max, want.deviation.min(UNEVEN)));
                }
            }
        }
    }
}
