//! A hierarchy of two children a node, in the order in which the GPU reads it.

use super::primitive::{GpuPrimitive, ShadowCasting, bounds};
use crate::GpuError;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use ray_tracing::binary_hierarchy;

/// `BvhNode` of bvh.wgsl.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuNode {
    pub(crate) low: [f32; 3],
    /// Primitives of a leaf; 0 in an inner node.
    pub(crate) count: u32,
    pub(crate) high: [f32; 3],
    /// First primitive of a leaf, or first of two children.
    pub(crate) first: u32,
}

/// Runs the steps of obvhs's own builder, which reads a clock that not every target has.
fn build(boxes: &[Aabb]) -> Bvh2 {
    let of = BvhBuildParams::medium_build();
    let mut bvh = binary_hierarchy(boxes);
    collapse(&mut bvh, of.max_prims_per_leaf.clamp(1, 255), of.collapse_traversal_cost);
    let ratio = of.reinsertion_batch_ratio * of.post_collapse_reinsertion_batch_ratio_multiplier;
    ReinsertionOptimizer::default().run(&mut bvh, ratio, None);
    bvh
}

/// Hierarchies deeper than this are refused: a kernel's stack is as long.
const DEEPEST: u32 = 1024;

/// The root; the node before it is a header.
const ROOT: usize = 1;

/// The hierarchy: children after their parents.
#[derive(Debug)]
pub(super) struct Tree {
    nodes: Vec<GpuNode>,
    /// Numbers of the primitives in the order of the leaves.
    order: Vec<u32>,
    /// Object, kind and number of each primitive at the time of building.
    names: Vec<[u32; 2]>,
    depth: u32,
    /// Area of all boxes over the root's at the time of building.
    built_area: f32,
}

impl Tree {
    /// Builds the hierarchy. There must be at least one primitive.
    pub(super) fn new(primitives: &[GpuPrimitive], names: Vec<u32>) -> Result<Self, GpuError> {
        let boxes: Vec<_> = primitives.iter().map(bounds).map(|[a, b]| Aabb::new(a.into(), b.into())).collect();
        let bvh = build(&boxes);
        let (nodes, depth) = laid_out(&bvh);
        if depth > DEEPEST {
            let (needed, allowed) = (depth.into(), DEEPEST.into());
            return Err(GpuError::Limits { what: "the hierarchy's depth", needed, allowed });
        }
        let names = primitives.iter().zip(names).map(|(p, name)| [p.object, name]).collect();
        let mut tree = Self { nodes, order: bvh.primitive_indices, names, depth, built_area: 0.0 };
        tree.built_area = tree.fit(primitives);
        Ok(tree)
    }

    /// The corners of a box around all primitives.
    pub(super) fn bounds(&self) -> [Vec3; 2] {
        [self.nodes[ROOT].low, self.nodes[ROOT].high].map(Vec3::from)
    }

    /// The same hierarchy around primitives that have moved. `None` if the primitives are others, or if a new hierarchy would be
    /// much better.
    pub(super) fn refitted(mut self, primitives: &[GpuPrimitive], names: &[u32]) -> Option<Self> {
        let same = primitives.len() == self.names.len()
            && primitives.iter().zip(names).zip(&self.names).all(|((p, name), was)| [p.object, *name] == *was);
        (same && self.fit(primitives) <= 2.0 * self.built_area).then_some(self)
    }

    /// Fits all boxes, leaves first; gives their area over the root's.
    fn fit(&mut self, primitives: &[GpuPrimitive]) -> f32 {
        let mut area = 0.0;
        for index in (ROOT..self.nodes.len()).rev() {
            let node = self.nodes[index];
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let (first, count) = (node.first as usize, node.count as usize);
            for number in &self.order[first.min(self.order.len())..][..count] {
                let [from, to] = bounds(&primitives[*number as usize]);
                (low, high) = (low.min(from), high.max(to));
            }
            if count == 0 {
                for child in &self.nodes[first..first + 2] {
                    (low, high) = (low.min(Vec3::from(child.low)), high.max(Vec3::from(child.high)));
                }
            }
            area += half_area(low, high);
            (self.nodes[index].low, self.nodes[index].high) = (low.into(), high.into());
        }
        let root = self.nodes[ROOT];
        area / half_area(root.low.into(), root.high.into()).max(f32::MIN_POSITIVE)
    }

    /// Puts the primitives into the order of the leaves.
    pub(super) fn arrange(&self, primitives: &mut Vec<GpuPrimitive>) {
        *primitives = self.order.iter().map(|number| primitives[*number as usize]).collect();
    }

    /// All nodes in the order in which the GPU reads them. The first node is a header: `low` has the hierarchy's units per world
    /// unit, `count` is 1 if all objects stop all rays. Otherwise `first` is where one node for each object begins, whose `count`
    /// says what the object stops: 0 no rays, 1 all, 2 those from receivers that cast alike.
    pub(super) fn packed(&self, scale: f32, casting: &[ShadowCasting]) -> Vec<GpuNode> {
        let mut nodes = Vec::with_capacity(self.nodes.len() + casting.len());
        nodes.extend_from_slice(&self.nodes);
        let count = u32::from(casting.is_empty());
        nodes[0] = GpuNode { low: [scale, 0.0, 0.0], count, first: nodes.len() as u32, ..GpuNode::default() };
        let count = |casting: &ShadowCasting| match casting {
            ShadowCasting::None => 0,
            ShadowCasting::All => 1,
            ShadowCasting::Alike => 2,
        };
        nodes.extend(casting.iter().map(|casting| GpuNode { count: count(casting), ..GpuNode::default() }));
        nodes
    }

    pub(super) fn primitive_count(&self) -> usize {
        self.order.len()
    }

    /// Levels below the root.
    pub(super) const fn depth(&self) -> u32 {
        self.depth
    }
}

fn half_area(low: Vec3, high: Vec3) -> f32 {
    let d = high - low;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// The nodes depth first, without their boxes, and their depth.
fn laid_out(bvh: &Bvh2) -> (Vec<GpuNode>, u32) {
    let mut nodes = Vec::with_capacity(bvh.nodes.len() + ROOT);
    nodes.resize(ROOT + 1, GpuNode::default());
    let (mut waiting, mut depth) = (vec![(0, ROOT, 0)], 0);
    while let Some((from, to, level)) = waiting.pop() {
        let node = &bvh.nodes[from];
        depth = depth.max(level);
        if node.is_leaf() {
            (nodes[to].count, nodes[to].first) = (node.prim_count, node.first_index);
            continue;
        }
        let first = nodes.len();
        nodes[to].first = first as u32;
        nodes.extend([GpuNode::default(); 2]);
        for k in [1, 0] {
            waiting.push((node.first_index as usize + k, first + k, level + 1));
        }
    }
    (nodes, depth)
}
