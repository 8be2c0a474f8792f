//! A light's grid of nodes, the same for all receivers: for what varies little over the whole light.

use super::FlatShape;
use super::cubature::{EIGHT, FOUR, SIX, SIXTEEN, TWELVE, TWO, both_halves};
use core::f64::consts::TAU;
use glam::Vec3;

/// Rules for a side of the grid.
const RULES: [&[(f32, f32)]; 6] = [&TWO, &FOUR, &SIX, &EIGHT, &TWELVE, &SIXTEEN];

/// Of a disc a rule of squared radii, and twice as many angles as the grid's sides have nodes.
const OF_RADII: [&[(f32, f32)]; 6] = [&TWO, &TWO, &FOUR, &FOUR, &EIGHT, &EIGHT];

/// One more than the last rule: a grid would need more.
pub(super) const NONE: usize = RULES.len();

/// The distances of a pole from both ends of an interval over its length, from which on each rule takes `1/(1 + x²)²` to 5e-4 of its integral.
pub(super) const POLES: [f32; NONE] = [9.0, 2.6, 1.7, 1.37, 1.13, 1.07];

/// The halves of intervals, in standard deviations, up to which each rule takes a Gaussian to 5e-4 of its integral, wherever its peak is.
pub(super) const DEVIATIONS: [f32; NONE] = [0.25, 1.3, 2.6, 3.7, 5.8, 7.8];

/// Those of the rules of four and eight nodes, which parts of a light take.
pub(super) const POLES_OF_PARTS: [f32; 2] = [POLES[1], POLES[3]];
pub(super) const DEVIATIONS_OF_PARTS: [f32; 2] = [DEVIATIONS[1], DEVIATIONS[3]];

/// A quadrilateral `m + u U + v V + uv T` with `u`, `v` in [−1, 1], or the ellipse inside of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) middle: Vec3,
    pub(super) corners: [Vec3; 4],
    /// `U` and `V`.
    sides: [Vec3; 2],
    twist: Vec3,
    is_disc: bool,
}

/// A node: from the grid's middle, and the area for which it stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    pub(super) offset: Vec3,
    pub(super) area: f32,
}

/// The nodes of a grid.
pub(super) struct Nodes {
    pub(super) rules: [usize; 2],
    all: [Node; Self::MOST],
    count: usize,
}

impl Grid {
    /// None of a shape with more than four corners.
    pub(super) fn new(shape: &FlatShape) -> Option<Self> {
        let (a, b, c, d) = match *shape.corners() {
            [a, b, c] => (a, b, c, c),
            [a, b, c, d] => (a, b, c, d),
            _ => return None,
        };
        // From one corner: differences keep the digits of small shapes far away.
        let [b, c, d] = [b, c, d].map(|p| p - a);
        Some(Self {
            middle: a + 0.25 * (b + c + d),
            corners: [a, a + b, a + c, a + d],
            sides: [0.25 * (b + c - d), 0.25 * (c + d - b)],
            twist: 0.25 * (c - b - d),
            is_disc: shape.disc().is_some(),
        })
    }

    /// The nodes by a rule a side.
    pub(super) fn nodes(&self, rules: [usize; 2]) -> Nodes {
        let [u, v] = rules;
        let mut nodes = Nodes { rules, all: [Node::default(); Nodes::MOST], count: 0 };
        let [right, up] = self.sides;
        if !self.is_disc {
            for (u, part) in both_halves(RULES[u]) {
                for (v, weight) in both_halves(RULES[v]) {
                    let area = (right + self.twist * v).cross(up + self.twist * u).length();
                    nodes.push(right * u + up * v + self.twist * (u * v), part * weight * area);
                }
            }
            return nodes;
        }
        let radii = OF_RADII[u.max(v)];
        // A rule has two nodes an entry, and the grid twice as many a side.
        let turns = 8 * radii.len() as u32;
        let area = right.cross(up).length() * 0.25 * TAU as f32 / turns as f32;
        for turn in 0..turns {
            let (sin, cos) = (TAU * (f64::from(turn) + 0.5) / f64::from(turns)).sin_cos();
            let across = right * cos as f32 + up * sin as f32;
            for (node, weight) in both_halves(radii) {
                nodes.push(across * (0.5 + 0.5 * node).sqrt(), weight * area);
            }
        }
        nodes
    }
}

impl Nodes {
    const MOST: usize = 256;

    fn push(&mut self, offset: Vec3, area: f32) {
        self.all[self.count] = Node { offset, area };
        self.count += 1;
    }

    pub(super) fn all(&self) -> &[Node] {
        &self.all[..self.count]
    }
}

/// The least distances of a pole from both ends of a line over its length, of the lines between two: the pole is at 1 beside the origin, and these lines bend as far
/// as this.
#[inline(always)]
pub(super) fn poles(one: [Vec3; 2], other: [Vec3; 2], bend: f32) -> f32 {
    let along = |[from, to]: [Vec3; 2]| {
        let along = to - from;
        let square = along.length_squared();
        let length = (if square > 1e-30 { square } else { 1e-30 }).sqrt();
        (along * (1.0 / length), length)
    };
    let ((one_way, one_length), (other_way, other_length)) = (along(one), along(other));
    let aside = |from: Vec3, way: Vec3| from - way * from.dot(way);
    let (one_aside, other_aside) = (aside(one[0], one_way), aside(other[0], other_way));
    let is_between = one_aside.dot(other_aside) <= 0.0;
    let pole = |[from, to]: [Vec3; 2], way: Vec3, length: f32, aside: Vec3| {
        let aside = aside.length() - bend;
        let height = 1.0 + if (aside > 0.0) & !is_between { aside * aside } else { 0.0 };
        let (start, end) = (from.dot(way), to.dot(way));
        ((height + start * start).sqrt() + (height + end * end).sqrt()) / length
    };
    let (a, b) = (pole(one, one_way, one_length, one_aside), pole(other, other_way, other_length, other_aside));
    if a < b { a } else { b }
}
