use crate::block::{Blocks, LANES};
use crate::shaft::ShaftTest;
use glam::Vec3;
use lobe_core::{Sphere, compact_runs};

/// A hierarchy of spheres over spheres, eight to a node, without pointers: level 0 holds the spheres in an order in which
/// neighbours are near each other (medians along the longest side), each further level a sphere around each eight of the
/// level below. One test of a node looks at one block.
#[derive(Clone, Debug, Default)]
pub(crate) struct SphereTree {
    /// The sphere in each slot of level 0.
    order: Vec<u32>,
    levels: Vec<Blocks>,
    /// Σ r² over the nodes, now and when the order was made.
    area: f32,
    fresh_area: f32,
}

/// Nodes grown by more than this in area make a new order pay: culling then costs half as much again.
const WORN: f32 = 1.5;

impl SphereTree {
    /// Over those spheres that can block. O(n log n).
    pub(crate) fn new(spheres: &[Sphere]) -> Self {
        let mut items: Vec<(Vec3, u32)> =
            spheres.iter().zip(0..).filter(|(s, _)| is_solid(s)).map(|(s, i)| (s.center, i)).collect();
        compact_runs(&mut items, LANES);
        let mut tree = Self { order: items.iter().map(|item| item.1).collect(), ..Self::default() };
        let mut count = tree.order.len();
        while count > 0 {
            let mut level = Blocks::default();
            (0..count).for_each(|_| level.push(&Sphere::default()));
            tree.levels.push(level);
            count = if count > LANES { count.div_ceil(LANES) } else { 0 };
        }
        tree.refit(spheres);
        tree.fresh_area = tree.area;
        tree
    }

    /// Follows the spheres in the order they have. O(n).
    fn refit(&mut self, spheres: &[Sphere]) {
        let Some(first) = self.levels.first_mut() else { return };
        for (slot, index) in self.order.iter().enumerate() {
            first.set(slot, &spheres[*index as usize]);
        }
        self.area = 0.0;
        for level in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(level);
            let (below, above) = (&below[level - 1], &mut above[0]);
            for (slot, block) in below.blocks().iter().enumerate() {
                let sphere = block.bounds(below.lanes(slot));
                self.area += sphere.radius * sphere.radius;
                above.set(slot, &sphere);
            }
        }
    }

    /// Follows the spheres, in a new order where the old one has worn out or other spheres block than before. Says
    /// whether it made one.
    pub(crate) fn update(&mut self, spheres: &[Sphere]) -> bool {
        let same = self.order.iter().all(|i| is_solid(&spheres[*i as usize]))
            && spheres.iter().filter(|s| is_solid(s)).count() == self.order.len();
        if same {
            self.refit(spheres);
        }
        let worn = !same || self.area > WORN * self.fresh_area;
        if worn {
            *self = Self::new(spheres);
        }
        worn
    }

    /// The spheres that can block, in no order.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Appends the spheres that meet the shaft, in no order. `stack` is working memory.
    pub(crate) fn find(&self, shaft: &ShaftTest, stack: &mut Vec<(u32, u32)>, out: &mut Vec<u32>) {
        stack.clear();
        if let Some(top) = self.levels.len().checked_sub(1) {
            stack.push((top as u32, 0));
        }
        while let Some((level, number)) = stack.pop() {
            let blocks = &self.levels[level as usize];
            let block = &blocks.blocks()[number as usize];
            let lanes = blocks.lanes(number as usize);
            let mut hits = shaft.meets(block) & ((1 << lanes) - 1);
            while hits != 0 {
                let slot = number * LANES as u32 + hits.trailing_zeros();
                hits &= hits - 1;
                if level == 0 { out.push(self.order[slot as usize]) } else { stack.push((level - 1, slot)) }
            }
        }
    }
}

/// Whether a sphere can block: nothing without radius or with anything infinite or NaN does.
fn is_solid(sphere: &Sphere) -> bool {
    sphere.radius > 0.0 && sphere.radius.is_finite() && sphere.center.is_finite()
}
