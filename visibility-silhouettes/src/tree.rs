//! A hierarchy of edges, eight children a node, built once and refitted as the edges move.

use crate::halving::{Halves, Halving, unit};
use core::ops::Range;
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::Vec3x8;
use rayon::prelude::*;

/// Children of a node, and the most edges of a leaf.
pub(crate) const WIDE: usize = 8;
/// Half the sides of an empty box: it is outside every plane.
const NEVER: f32 = -1e30;
/// The sine for a child without a cone.
const WIDEST: f32 = 4.0;

/// Eight children side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct Node {
    /// Centre of the box, half its sides, axis of the cone of normals, each x y z, and the sine of the cone's half-angle, above 1
    /// if there is no cone.
    pub(crate) bounds: [[f32; WIDE]; 10],
    /// Another node, or the first edge of a leaf.
    pub(crate) first: [u32; WIDE],
    /// Edges of a leaf; 0 for a node.
    pub(crate) count: [u8; WIDE],
    /// Children.
    pub(crate) len: u8,
}

const EMPTY: Node = Node { bounds: [[0.0; WIDE]; 10], first: [0; WIDE], count: [0; WIDE], len: 0 };

#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// Parents before their children.
    nodes: Vec<Node>,
    /// For each child the distance from its centre at which any of its edges is drawn: `reach` and `detail`. Empty if all are
    /// always drawn.
    reaches: Vec<[[f32; WIDE]; 2]>,
}

/// Box and cone of normals.
#[derive(Clone, Copy)]
struct EdgeBounds {
    low: Vec3,
    high: Vec3,
    axis: Vec3,
    sin: f32,
}

/// The distance from a point at which an edge is drawn: `reach + detail · scale`, where `scale` is the receiver's distance ratio
/// for details.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    pub(crate) reach: f32,
    pub(crate) detail: f32,
}

impl Reach {
    /// Everywhere.
    pub(crate) const EVERYWHERE: Self = Self { reach: f32::INFINITY, detail: 0.0 };
    const NOWHERE: Self = Self { reach: f32::NEG_INFINITY, detail: f32::NEG_INFINITY };

    /// The union of two; the other one is around a point at the distance `away`.
    pub(crate) fn and(self, other: Self, away: f32) -> Self {
        Self { reach: self.reach.max(other.reach + away), detail: self.detail.max(other.detail) }
    }
}

/// An edge for the tree: its ends, the normals on both sides, and the sine of an angle by which these may be turned.
pub(crate) type Shape = ([Vec3; 2], Vec3, Option<Vec3>, f32);

impl Tree {
    /// A tree over boxes (low, high), and the order in which its leaves hold them: from `first` on. Bounds are there after
    /// [`fit`](Self::fit). It does not depend on the number of threads.
    pub(crate) fn new(boxes: impl IntoIterator<Item = [Vec3; 2]>, first: usize) -> (Self, Vec<u32>) {
        let halving = Halving::new(boxes);
        let mut tree = Self::default();
        if !halving.order.is_empty() {
            tree.add(&halving.halves, (0..halving.order.len(), halving.root), first);
        }
        (tree, halving.order)
    }

    /// Adds a node for a range of the edges and the nodes below it. The range is halved at a leaf, and the half with the largest box in
    /// turn, until there are eight parts. The order of all begins at `first`.
    fn add(&mut self, halves: &[Halves], (range, middle): (Range<usize>, u32), first: usize) -> u32 {
        let unit = unit(range.len());
        let mut parts = Vec::with_capacity(WIDE);
        // With half the areas of their boxes.
        parts.push((range, middle, 0.0_f32));
        while parts.len() < WIDE {
            let open = (0..parts.len()).filter(|k| parts[*k].0.len() > unit);
            let Some(k) = open.max_by(|a, b| parts[*a].2.total_cmp(&parts[*b].2)) else { break };
            let (part, middle, _) = parts[k].clone();
            let at = WIDE * middle as usize;
            let Halves { areas, middles } = halves[middle as usize];
            parts.splice(k..=k, [(part.start..at, middles[0], areas[0]), (at..part.end, middles[1], areas[1])]);
        }
        let number = self.nodes.len();
        self.nodes.push(Node { len: parts.len() as u8, ..EMPTY });
        for (k, (part, middle, _)) in parts.into_iter().enumerate() {
            if part.len() <= WIDE {
                self.nodes[number].count[k] = part.len() as u8;
                self.nodes[number].first[k] = (first + part.start) as u32;
            } else {
                self.nodes[number].first[k] = self.add(halves, (part, middle), first);
            }
        }
        number as u32
    }

    /// A tree over leaves in this order. Bounds are there after [`fit`](Self::fit).
    pub(crate) fn over(leaves: &[Range<usize>]) -> Self {
        let mut tree = Self::default();
        if !leaves.is_empty() {
            tree.add_over(leaves);
        }
        tree
    }

    fn add_over(&mut self, leaves: &[Range<usize>]) -> u32 {
        let mut size = 1;
        while size * WIDE < leaves.len() {
            size *= WIDE;
        }
        let number = self.nodes.len();
        self.nodes.push(Node { len: leaves.len().div_ceil(size) as u8, ..EMPTY });
        for (k, part) in leaves.chunks(size).enumerate() {
            if let [leaf] = part {
                self.nodes[number].first[k] = leaf.start as u32;
                self.nodes[number].count[k] = leaf.len() as u8;
            } else {
                self.nodes[number].first[k] = self.add_over(part);
            }
        }
        number as u32
    }

    /// The edges of each leaf, in their order.
    pub(crate) fn leaves(&self) -> Vec<Range<usize>> {
        let mut all: Vec<_> =
            self.nodes.iter().flat_map(|node| (0..usize::from(node.len)).filter_map(|k| node.edges(k))).collect();
        all.sort_by_key(|leaf| leaf.start);
        all
    }

    /// Boxes and cones of everything, from the edges of a range of the order.
    pub(crate) fn fit<I: Iterator<Item = Shape> + Clone>(&mut self, edges: impl Fn(Range<usize>) -> I + Sync) {
        self.nodes.par_iter_mut().with_min_len(32).for_each(|node| {
            for k in 0..usize::from(node.len) {
                if let Some(range) = node.edges(k) {
                    node.set(k, &around(edges(range)));
                }
            }
        });
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            for k in 0..usize::from(self.nodes[number].len) {
                if self.nodes[number].count[k] == 0 {
                    let bounds = self.nodes[self.nodes[number].first[k] as usize].all();
                    self.nodes[number].set(k, &bounds);
                }
            }
        }
    }

    /// Computes all reaches from those of the edges of a range; call it after [`fit`](Self::fit).
    pub(crate) fn fit_reaches(&mut self, reach: impl Fn(Range<usize>, Vec3) -> Reach + Sync) {
        let Self { nodes, reaches } = self;
        reaches.resize(nodes.len(), [[0.0; WIDE]; 2]);
        nodes.par_iter().with_min_len(32).zip(&mut *reaches).for_each(|(node, [reaches, details])| {
            let children = reaches.iter_mut().zip(details).enumerate().take(usize::from(node.len));
            for (k, (to, detail)) in children {
                if let Some(range) = node.edges(k) {
                    Reach { reach: *to, detail: *detail } = reach(range, node.middle(k));
                }
            }
        });
        for (number, node) in nodes.iter().enumerate().rev() {
            for k in (0..usize::from(node.len)).filter(|k| node.count[*k] == 0) {
                let child = node.first[k] as usize;
                let [reach, detail] = reaches[child];
                let all = (0..usize::from(nodes[child].len)).fold(Reach::NOWHERE, |sum, c| {
                    let away = node.middle(k).distance(nodes[child].middle(c));
                    sum.and(Reach { reach: reach[c], detail: detail[c] }, away)
                });
                (reaches[number][0][k], reaches[number][1][k]) = (all.reach, all.detail);
            }
        }
    }

    /// The reaches of the children of a node.
    pub(crate) fn reach(&self, node: usize) -> Option<&[[f32; WIDE]; 2]> {
        self.reaches.get(node)
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The box around all edges of a tree that is fitted and not empty.
    pub(crate) fn bounds(&self) -> [Vec3; 2] {
        let EdgeBounds { low, high, .. } = self.nodes[0].all();
        [low, high]
    }

    /// A node above those of up to eight trees, without their numbers.
    pub(crate) fn above<'t>(trees: impl Iterator<Item = &'t Self>) -> Node {
        let mut node = EMPTY;
        for (k, tree) in trees.take(WIDE).enumerate() {
            node.set(k, &tree.nodes[0].all());
            node.len = k as u8 + 1;
        }
        node
    }

    /// The most nodes from the root to a leaf.
    pub(crate) fn depth(&self) -> usize {
        let mut depths = vec![1; self.nodes.len()];
        for (number, node) in self.nodes.iter().enumerate().rev() {
            for k in (0..usize::from(node.len)).filter(|k| node.count[*k] == 0) {
                depths[number] = depths[number].max(1 + depths[node.first[k] as usize]);
            }
        }
        depths.first().copied().unwrap_or(0)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.reaches[..])
    }
}

impl Node {
    /// Three numbers of each child, from one of `bounds` on.
    #[inline(always)]
    pub(crate) fn vectors<S: Simd>(&self, simd: S, first: usize) -> Vec3x8<S> {
        let [x, y, z] = [self.bounds[first], self.bounds[first + 1], self.bounds[first + 2]];
        Vec3x8::new(f32x8::simd_from(simd, x), f32x8::simd_from(simd, y), f32x8::simd_from(simd, z))
    }

    fn set(&mut self, k: usize, bounds: &EdgeBounds) {
        let center = 0.5 * bounds.low + 0.5 * bounds.high;
        // With a margin for the rounding of the centre; an empty box stays empty, outside every plane.
        let half = (bounds.high - center).max(center - bounds.low) * 1.000_001;
        let (center, half) =
            if bounds.low.cmple(bounds.high).all() { (center, half) } else { (Vec3::ZERO, Vec3::splat(NEVER)) };
        let all = [center, half, bounds.axis].map(|v| v.to_array());
        for (column, value) in self.bounds.iter_mut().zip(all.as_flattened()) {
            column[k] = *value;
        }
        self.bounds[9][k] = bounds.sin;
    }

    /// The edges of a child that is a leaf.
    fn edges(&self, k: usize) -> Option<Range<usize>> {
        let first = self.first[k] as usize;
        (self.count[k] > 0).then(|| first..first + usize::from(self.count[k]))
    }

    fn middle(&self, k: usize) -> Vec3 {
        Vec3::new(self.bounds[0][k], self.bounds[1][k], self.bounds[2][k])
    }

    fn get(&self, k: usize) -> EdgeBounds {
        let at = |c: usize| Vec3::new(self.bounds[c][k], self.bounds[c + 1][k], self.bounds[c + 2][k]);
        let (center, half) = (at(0), at(3));
        EdgeBounds { low: center - half, high: center + half, axis: at(6), sin: self.bounds[9][k] }
    }

    /// The bounds of all children together.
    fn all(&self) -> EdgeBounds {
        let children = (0..usize::from(self.len)).map(|k| self.get(k)).filter(|b| b.low.cmple(b.high).all());
        let mut bounds = NOTHING;
        let mut axis = Vec3::ZERO;
        for child in children.clone() {
            bounds.low = bounds.low.min(child.low);
            bounds.high = bounds.high.max(child.high);
            axis += child.axis;
        }
        let axis = axis.normalize_or_zero();
        // cos(α + β) of the child's half-angle and the angle between its axis and the new one.
        let least = children.map(|child| {
            let beside = child.axis.dot(axis).clamp(-1.0, 1.0);
            let cos = (1.0 - child.sin * child.sin).max(0.0).sqrt();
            let sum = beside * cos - child.sin * (1.0 - beside * beside).max(0.0).sqrt();
            if child.sin <= 1.0 && beside > 0.0 { sum } else { -1.0 }
        });
        EdgeBounds { axis, sin: sine(axis, least.fold(1.0, f32::min)), ..bounds }
    }
}

const NOTHING: EdgeBounds = EdgeBounds { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, axis: Vec3::ZERO, sin: WIDEST };

/// The sine of a half-angle with a small margin, or more than any sine if the angle is near a right one.
fn sine(axis: Vec3, cos: f32) -> f32 {
    if axis == Vec3::ZERO || cos < 0.1 { WIDEST } else { (1.0 - cos * cos).max(0.0).sqrt() + 1e-3 }
}

/// The cosine of an angle that is enlarged by another one, whose sine is given.
fn turned(cos: f32, turn: f32) -> f32 {
    if turn == 0.0 {
        return cos;
    }
    let (cos, sin) = (cos.clamp(-1.0, 1.0), (1.0 - cos * cos).max(0.0).sqrt());
    // Angles beyond a right one have no cone.
    if cos <= 0.0 || turn >= 1.0 { -1.0 } else { cos * (1.0 - turn * turn).sqrt() - sin * turn }
}

fn around(edges: impl Iterator<Item = Shape> + Clone) -> EdgeBounds {
    let (mut bounds, mut axis) = (NOTHING, Vec3::ZERO);
    for ([a, b], one, other, _) in edges.clone() {
        bounds.low = bounds.low.min(a).min(b);
        bounds.high = bounds.high.max(a).max(b);
        axis += one + other.unwrap_or(Vec3::ZERO);
    }
    let axis = axis.normalize_or_zero();
    let cos = |(_, one, other, turn): Shape| match other {
        Some(other) => turned(one.dot(axis).min(other.dot(axis)), turn),
        // A border is a silhouette from everywhere.
        None => -1.0,
    };
    EdgeBounds { axis, sin: sine(axis, edges.map(cos).fold(1.0, f32::min)), ..bounds }
}
