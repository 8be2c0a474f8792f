//! A light's grid of nodes, the same for all receivers: for what varies little over the whole light.

use super::FlatShape;
use super::cubature::{EIGHT, FOUR, SIX, SIXTEEN, TWELVE, TWO, both_halves};
use super::rules::NONE;
use core::f64::consts::TAU;
use glam::Vec3;

/// Rules for a side of the grid.
const RULES: [&[(f32, f32)]; NONE] = [&TWO, &FOUR, &SIX, &EIGHT, &TWELVE, &SIXTEEN];

/// Of a disc a rule of squared radii, and twice as many angles as the grid's sides have nodes.
const OF_RADII: [&[(f32, f32)]; NONE] = [&TWO, &TWO, &FOUR, &FOUR, &EIGHT, &EIGHT];

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
