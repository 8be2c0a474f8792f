//! The part of a face that can block light from one receiver.

use crate::face::{Affine, Face};
use crate::fit::tangents;
use crate::layer::{Layer, Node, Part};
use glam::{DVec3, Vec2, Vec3};
use lobe_core::Sphere;
use shading::Shaft;
use visibility_mask::UnitSquare;

/// A blocker near the receiver must be above its tangent plane by this many texels, or a surface would shadow itself. A blocker
/// more than `BIAS/TILT` texels away toward the light must only be above the plane by a rounding error, or light would leak along
/// the horizon at any distance of the blocker. Measured on a bunny's own surface, map of 512², light of 1°: a tilt of 1/16 darkens
/// lit surfaces by 0.10 % and leaves 2.1 % of the light in the umbra; without tilt 0.06 % and 4.1 %, without bias 1.9 % and 2.1 %.
/// With smooth normals a larger tilt gives dark specks near terminators.
pub(crate) const BIAS: f64 = 0.5;
pub(crate) const TILT: f64 = 1.0 / 32.0;
pub(crate) const ROUNDING: f64 = 0.02;
/// A node is drawn for its texels if none of its points appears farther than this from its true place, in cells.
pub(crate) const SHIFT: f64 = 0.125;
/// A node smaller than this, in cells, is not split at its outlines and depth steps, since a finer map has more nodes there.
pub(crate) const SMALL: f64 = 0.7;
/// The largest shift of a part of such a node by its depths, in cells; otherwise the node is split after all.
pub(crate) const PART_SHIFT: f64 = 0.25;
/// Points nearer to the receiver's plane than this, relative to its farthest point, are outside of every window.
pub(crate) const NEAR: f32 = 1e-4;
const LANES: usize = 12;

/// Affine functions that must all be positive at a point that blocks.
#[derive(Clone, Debug)]
pub(crate) struct Tests {
    a: [f32; LANES],
    b: [f32; LANES],
    c: [f32; LANES],
    d: [f32; LANES],
}

impl Tests {
    fn new(functions: &[Affine]) -> Self {
        let mut tests = Self { a: [0.0; LANES], b: [0.0; LANES], c: [0.0; LANES], d: [1.0; LANES] };
        for (k, f) in functions.iter().enumerate() {
            // Only the sign matters: scaling keeps f32 in range.
            let scale = 1.0 / f.a.abs().max(f.b.abs()).max(f.c.abs()).max(f.d.abs()).max(f64::MIN_POSITIVE);
            let f = f.times(scale);
            (tests.a[k], tests.b[k], tests.c[k], tests.d[k]) = (f.a as f32, f.b as f32, f.c as f32, f.d as f32);
        }
        tests
    }

    /// For a box of (i, j, q): whether some function is negative in the whole box, and whether the first `inner` are positive in
    /// the whole box.
    #[inline(always)]
    fn bounds(&self, at: &Block, inner: usize) -> (bool, bool) {
        let (mut outside, mut inside) = (false, true);
        for k in 0..LANES {
            let (a, b, c) = (self.a[k], self.b[k], self.c[k]);
            let middle = self.d[k] + a * at.i + b * at.j + c * at.q;
            let half = a.abs() * at.half_i + b.abs() * at.half_j + c.abs() * at.half_q;
            outside |= middle + half <= 0.0;
            inside &= middle - half > 0.0 || k >= inner;
        }
        (outside, inside)
    }

    /// Whether the first `count` functions are positive at a point.
    #[inline(always)]
    fn hold(&self, count: usize, i: f32, j: f32, q: f32) -> bool {
        (0..count).all(|k| self.d[k] + self.a[k] * i + self.b[k] * j + self.c[k] * q > 0.0)
    }
}

/// A box of texels and depths: centre and half extents.
pub(crate) struct Block {
    i: f32,
    j: f32,
    q: f32,
    half_i: f32,
    half_j: f32,
    half_q: f32,
}

impl Block {
    /// The node and the box around all of its texels, corners included; `None` if it has no surface.
    #[inline(always)]
    pub(crate) fn around(item: Item, layer: &Layer) -> Option<(Node, Self)> {
        let node = item.node(layer);
        if node.is_empty() {
            return None;
        }
        let [x0, x1, y0, y1] = item.texels(layer).map(|x| x as f32);
        // The bounds of a texel do not include its corners; those of its parent node do.
        let (min, max) = match item.level {
            0 => {
                let above = layer.node(1, usize::from(item.i) / 2, usize::from(item.j) / 2);
                (above.min, above.max)
            }
            _ => (node.min, node.max),
        };
        let block = Self {
            i: 0.5 * (x0 + x1),
            j: 0.5 * (y0 + y1),
            q: 0.5 * (min + max),
            half_i: 0.5 * (x1 - x0),
            half_j: 0.5 * (y1 - y0),
            half_q: 0.5 * (max - min),
        };
        Some((node, block))
    }
}

/// A node of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    pub(crate) face: u8,
    pub(crate) layer: u8,
    pub(crate) level: u8,
    pub(crate) i: u16,
    pub(crate) j: u16,
}

impl Item {
    pub(crate) fn root(face: usize, layer: usize, top: u32) -> Self {
        Self { face: face as u8, layer: layer as u8, level: top as u8, i: 0, j: 0 }
    }

    #[inline(always)]
    pub(crate) fn node(self, layer: &Layer) -> Node {
        layer.node(self.level.into(), self.i.into(), self.j.into())
    }

    #[inline(always)]
    pub(crate) fn texels(self, layer: &Layer) -> [usize; 4] {
        layer.texels(self.level.into(), self.i.into(), self.j.into())
    }

    /// Appends the children of a node that are inside the layer.
    #[inline(always)]
    pub(crate) fn split(self, layer: &Layer, out: &mut Vec<Self>) {
        let level = self.level - 1;
        let (columns, rows) = layer.size(level.into());
        let (i, j) = (2 * self.i, 2 * self.j);
        let (right, up) = (usize::from(i) + 1 < columns, usize::from(j) + 1 < rows);
        out.push(Self { level, i, j, ..self });
        if right {
            out.push(Self { level, i: i + 1, j, ..self });
        }
        if up {
            out.push(Self { level, i, j: j + 1, ..self });
        }
        if right && up {
            out.push(Self { level, i: i + 1, j: j + 1, ..self });
        }
    }
}

/// Result of the test of a node in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// None of it blocks.
    No,
    /// Its children must be tested.
    Split,
    /// It blocks, as one quadrilateral.
    Blocks,
    /// It is small and some of it may block, see [`FaceView::parts`].
    Partly(Small),
}

/// A small node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Small {
    /// Whether all of it may block.
    inside: bool,
    /// The q that divides it in two.
    middle: f32,
    /// The largest difference of q within a part.
    range: f32,
}

/// One face as seen from one receiver through one window.
#[derive(Clone, Debug)]
pub(crate) struct FaceView {
    pub(crate) image: Image,
    /// The first `INNER` tests decide whether a point blocks; the others bound the window.
    tests: Tests,
    /// Depth toward the light, `(1 + q)·axis·(P − x)`.
    depth: [f32; 4],
    /// `deviation·reach ≤ depth` is the merge test.
    reach: f32,
    /// `texels·small ≤ depth` is the test of a small node.
    small: f32,
}

const INNER: usize = 3;
/// Twice [`PART_SHIFT`] in units of [`SHIFT`], since a change of q by `depth/reach` moves an image by [`SHIFT`] cells.
const PART_RANGE: f32 = (2.0 * PART_SHIFT / SHIFT) as f32;

impl FaceView {
    /// `cell`: the sides of a mask cell in plane coordinates.
    pub(crate) fn new(face: &Face, light: &Sphere, x: Vec3, normal: Vec3, square: &UnitSquare, cell: Vec2) -> Self {
        let center = light.center.as_dvec3();
        let to_light = center - x.as_dvec3();
        let distance = to_light.length();
        let n = normal.as_dvec3();
        let axis = square.axis.as_dvec3();
        let above = face.along(n, to_light).minus(face.per_distance(ROUNDING * face.texel));
        let clear = face.along(n + axis * TILT, to_light).minus(face.per_distance(BIAS * face.texel));
        // In front of the circle in which the receiver's tangents touch the light.
        let radius = f64::from(light.radius);
        let to_receiver = -to_light / distance;
        let front = face.relative(to_receiver).minus(Face::constant(radius * radius / distance));

        let (right, up) = (square.right.as_dvec3(), square.up.as_dvec3());
        let (middle, half) = (square.center.as_dvec2(), square.half.as_dvec2());
        let within = |direction: DVec3, at: f64, half: f64| face.along(axis * (at + half) - direction, to_light);
        let diagonal = core::f64::consts::FRAC_1_SQRT_2;
        // Includes all cells at the rim, since a mask stores the covered fraction of a cell.
        let disc = f64::from(square.disc) + 1.5 * f64::from(cell.max_element());
        let cell = cell.min_element();
        let tests = Tests::new(&[
            above,
            clear,
            front,
            within(right, middle.x, half.x),
            within(-right, -middle.x, half.x),
            within(up, middle.y, half.y),
            within(-up, -middle.y, half.y),
            within((right + up) * diagonal, 0.0, disc),
            within((-right - up) * diagonal, 0.0, disc),
            within((right - up) * diagonal, 0.0, disc),
            within((up - right) * diagonal, 0.0, disc),
        ]);
        // For a point at p on the square, a change δq moves the image by |p|·(axis·(L − x))·δq/depth.
        let farthest = middle.length() + half.max_element();
        let reach = farthest * axis.dot(to_light) / (SHIFT * f64::from(cell));
        let depth = face.along(axis, to_light);
        let small = (face.z0 * face.texel / (SMALL * f64::from(cell))) as f32;
        Self {
            image: Image::new(face, to_light, square, cell),
            tests,
            small,
            depth: [depth.a as f32, depth.b as f32, depth.c as f32, depth.d as f32],
            reach: reach as f32,
        }
    }

    #[inline(always)]
    pub(crate) fn judge(&self, item: Item, node: &Node, block: &Block) -> Verdict {
        if item.level == 0 {
            if self.tests.bounds(block, 0).0 {
                return Verdict::No;
            }
            // A texel blocks if its centre does.
            let there = self.tests.hold(INNER, block.i, block.j, node.min);
            return if there { Verdict::Blocks } else { Verdict::No };
        }
        let (outside, inside) = self.tests.bounds(block, INNER);
        if outside {
            return Verdict::No;
        }
        let [a, b, c, d] = self.depth;
        let nearest = d + a * block.i + b * block.j + c * block.q
            - (a.abs() * block.half_i + b.abs() * block.half_j + c.abs() * block.half_q);
        if inside && node.deviation * self.reach <= nearest {
            return Verdict::Blocks;
        }
        if (1 << item.level) as f32 * self.small <= nearest {
            let flat = block.half_q * self.reach <= nearest;
            let middle = if flat { f32::NEG_INFINITY } else { block.q };
            return Verdict::Partly(Small { inside, middle, range: PART_RANGE * nearest / self.reach });
        }
        Verdict::Split
    }

    /// The parts of a small node that block, as one trapezoid or two, see [`Layer::parts`]. `None`: test its children instead.
    #[inline(always)]
    pub(crate) fn parts(&self, item: Item, layer: &Layer, small: Small) -> Option<[Option<Part>; 2]> {
        let step = 1 << item.level.saturating_sub(2);
        layer.parts(item.texels(layer), step, [small.middle, small.range], |i, j, q| {
            small.inside || self.tests.hold(INNER, i, j, q)
        })
    }
}

/// Tests nodes against a group of receivers.
#[derive(Clone, Debug)]
pub(crate) struct TileView {
    tests: Tests,
    /// The light's diameter and the receivers' largest distance from it.
    diameter: f64,
    farthest: f64,
    z0: f64,
    texel: f64,
}

/// A node wider than this fraction of the light, seen from some receiver of a group, may be split for the group. Narrower nodes may
/// be drawn as one by some receiver: a mask has at least eight cells a side, and [`SMALL`] is less than one.
const WIDE: f64 = 1.0 / 6.0;

impl TileView {
    pub(crate) fn new(face: &Face, shaft: &Shaft) -> Self {
        let (light, receivers) = (shaft.light, shaft.receivers);
        let radius = f64::from(light.radius);
        let from_light = face.frame.local(receivers.center.as_dvec3() - light.center.as_dvec3());
        // Grown like the tests of single receivers, which include the cells at the rim of masks of depth 4 and more.
        let grown = 1.2 * radius + 1e-6 * from_light.length();
        let spread = f64::from(receivers.radius) + 1e-6 * from_light.length();
        let mut functions = Vec::with_capacity(4);
        for (across, direction) in [(from_light.x, face.frame.right), (from_light.y, face.frame.up)] {
            for [a, b] in tangents(across, from_light.z, spread, grown).into_iter().flatten() {
                functions.push(Face::constant(grown).minus(face.relative(direction * a + face.frame.forward * b)));
            }
        }
        Self {
            tests: Tests::new(&functions),
            diameter: 2.0 * radius,
            farthest: from_light.length() + f64::from(receivers.radius),
            z0: face.z0,
            texel: face.texel,
        }
    }

    pub(crate) fn meets(&self, item: Item, layer: &Layer) -> bool {
        Block::around(item, layer).is_some_and(|(_, block)| !self.tests.bounds(&block, 0).0)
    }

    /// Whether every receiver splits the node.
    pub(crate) fn splits(&self, item: Item, layer: &Layer) -> bool {
        let node = item.node(layer);
        if item.level == 0 || node.deviation.is_finite() {
            return false;
        }
        // The width of the shaft at the node's nearest point, in texels.
        let z = self.z0 / (1.0 + f64::from(node.max));
        let width = self.diameter * (self.farthest - z) / (self.farthest * z * self.texel);
        f64::from(1 << item.level) > WIDE * width
    }
}

/// Images of a face's points on a receiver's square, in homogeneous plane coordinates; affine in texel coordinates and q.
#[derive(Clone, Debug)]
pub(crate) struct Image {
    i: Vec3,
    j: Vec3,
    q: Vec3,
    origin: Vec3,
    /// Twice the largest shift of a node's texels from their true places.
    slack: f32,
}

impl Image {
    fn new(face: &Face, to_light: DVec3, square: &UnitSquare, cell: f32) -> Self {
        let rows = [square.right, square.up, square.axis].map(|m| face.along(m.as_dvec3(), to_light));
        let pick = |f: fn(&Affine) -> f64| Vec3::from_array(rows.map(|r| f(&r) as f32));
        let (i, j, q, origin) = (pick(|r| r.a), pick(|r| r.b), pick(|r| r.c), pick(|r| r.d));
        Self { i, j, q, origin, slack: 2.0 * SHIFT as f32 * cell }
    }

    /// Images of points of the face with given q.
    #[inline(always)]
    pub(crate) fn corners(&self, at: [[f32; 2]; 4], q: [f32; 4]) -> [Vec3; 4] {
        core::array::from_fn(|k| self.origin + self.i * at[k][0] + self.j * at[k][1] + self.q * q[k])
    }

    /// A box in the plane around a block's image; `None` if the block reaches behind the receiver.
    #[inline(always)]
    pub(crate) fn bounds(&self, block: &Block) -> Option<[Vec2; 2]> {
        let middle = self.origin + self.i * block.i + self.j * block.j + self.q * block.q;
        let half = self.i.abs() * block.half_i + self.j.abs() * block.half_j + self.q.abs() * block.half_q;
        let (low, high) = (middle - half, middle + half);
        if low.z < NEAR * low.abs().max(high.abs()).max_element() {
            return None;
        }
        let (far, near) = (1.0 / high.z, 1.0 / low.z);
        let (low, high) = (low.truncate(), high.truncate());
        Some([(low * far).min(low * near) - self.slack, (high * far).max(high * near) + self.slack])
    }

    /// Approximately how far, in plane coordinates, changes of q and rounding move an edge that meets several smaller edges.
    #[inline(always)]
    pub(crate) fn shifts(&self, points: &[Vec2], depth: f32, changes: [f32; 4]) -> [f32; 4] {
        let farthest = points.iter().map(|p| p.length_squared()).fold(0.0, f32::max).sqrt();
        // Within the window the shift is at most that for which nodes are merged; `slack` is twice that.
        let shift = |q: f32| (farthest * (self.q.z * q / depth + 1e-5)).min(0.5 * self.slack);
        changes.map(|q| if q > 0.0 { shift(q) } else { 0.0 })
    }
}
