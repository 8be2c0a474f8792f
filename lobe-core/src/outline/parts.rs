//! Parts of a light for which few nodes are enough, and the sums over nodes.

use super::Outline;
use super::cubature::{EIGHT, FOUR, Value};
use super::grid::Node;
use super::integral::Power;
use super::rules::{Before, NOTHING, Shape, rules};
use crate::lanes::{Lane, Level, WIDTH, map, row, set_row};
use crate::microfacets::MicrofacetsAt;
use crate::{BrdfLobe, BrushedAt, Facets, Lobe, PackedLobe, Schlick};
use core::f32::consts::TAU;
use fearless_simd::dispatch;
use glam::Vec3;

/// A lobe at a point of the plane that is seen: of microfacets both parts.
pub(super) trait Both: Copy {
    fn both(&self, p: Vec3, inverse: f32) -> [f32; 2];
}

impl Both for Power {
    #[inline(always)]
    fn both(&self, p: Vec3, inverse: f32) -> [f32; 2] {
        [self.at(p, inverse), 0.0]
    }
}

/// The same where it is known beforehand whether the receiver's cosine multiplies it: else loops over nodes are no vector instructions.
#[derive(Clone, Copy)]
struct Alone<const HAS_COSINE: bool>(Power);

impl<const HAS_COSINE: bool> Both for Alone<HAS_COSINE> {
    #[inline(always)]
    fn both(&self, p: Vec3, inverse: f32) -> [f32; 2] {
        Power { has_cosine: HAS_COSINE, ..self.0 }.both(p, inverse)
    }
}

#[derive(Clone, Copy)]
struct Of<F>(F);

impl<F: Facets> Both for Of<F> {
    #[inline(always)]
    fn both(&self, p: Vec3, inverse: f32) -> [f32; 2] {
        self.0.both(p * inverse.sqrt())
    }
}

/// The summand of an area about a point relative to the receiver.
#[inline(always)]
fn added(lobe: &impl Both, p: Vec3, area: f32) -> [f32; 2] {
    let inverse = 1.0 / p.length_squared();
    let weight = area * (inverse * inverse.sqrt());
    lobe.both(p, inverse).map(|value| weight * value)
}

/// A receiver and its lobe, ready for nodes. Twelve numbers, so that many lie in columns.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct AtNode {
    /// Added to nodes.
    toward: Vec3,
    normal: Vec3,
    /// The lobe's axis, or the direction to the eye above the horizon.
    axis: Vec3,
    /// Half the exponent, or `α²`.
    shape: f32,
    /// The lobe's kind, or the eye's part of shadowing.
    more: f32,
    /// The factor of all nodes.
    scale: f32,
}

impl AtNode {
    #[inline(always)]
    pub(super) fn new<const IS_FACETS: bool>(toward: Vec3, before: &Before, lobe: &PackedLobe) -> Self {
        let Before { normal, height, .. } = *before;
        let PackedLobe { axis, exponent, kind, .. } = *lobe;
        if IS_FACETS {
            let at = MicrofacetsAt::new(normal, axis, exponent, Schlick::F0);
            return Self { toward, normal, axis: at.view, shape: at.alpha_sq, more: at.shadowing, scale: height };
        }
        let scale = height * ((exponent + 1.0) / TAU);
        Self { toward, normal, axis, shape: 0.5 * exponent, more: kind, scale }
    }

    /// A node's summand; of microfacets those of both parts.
    #[inline(always)]
    pub(super) fn value<const IS_FACETS: bool>(&self, node: &Node) -> [f32; 2] {
        let (p, area, normal) = (self.toward + node.offset, node.area * self.scale, self.normal);
        if IS_FACETS {
            let (view, alpha_sq, shadowing) = (self.axis, self.shape, self.more);
            return added(&Of(MicrofacetsAt { normal, view, alpha_sq, shadowing, part: Schlick::F0 }), p, area);
        }
        let has_cosine = self.more == PackedLobe::COSINE;
        added(&Power { axis: self.axis, half_exponent: self.shape, normal, has_cosine }, p, area)
    }
}

/// Parts that wait, and parts that are looked at for one lobe, at most.
pub(super) const ROOM: usize = 128;
pub(super) const MOST: usize = 512;

/// Polygons of up to this many corners have no long sides to begin with.
pub(super) const FEW: usize = 6;

/// The integral of a lobe over a polygon above the horizon, parts of which are halved until few nodes are enough for each. Powers are of exponent
/// [`STEEP`](super::integral::STEEP) or more.
pub(super) fn in_parts(normal: Vec3, lobe: &BrdfLobe, light: &Outline) -> f32 {
    let before = Before { normal, axis: light.axis, height: light.height };
    let shape = Shape::new(before, &PackedLobe::from(*lobe));
    let value = match lobe {
        BrdfLobe::Cosine(Lobe { axis, exponent, has_cosine, .. }) => {
            let power = Power { axis: *axis, half_exponent: 0.5 * exponent, normal, has_cosine: *has_cosine };
            let sum = if *has_cosine {
                sum_of_parts(&shape, Alone::<true>(power), light)
            } else {
                sum_of_parts(&shape, Alone::<false>(power), light)
            };
            sum[0] * ((exponent + 1.0) / TAU)
        }
        BrdfLobe::Microfacets(facets) => facets.part.of(match facets.grain {
            None => sum_of_parts(&shape, Of(facets.at(normal)), light),
            Some(grain) => {
                let brushed = BrushedAt::new(facets, grain, normal);
                sum_of_parts(&shape.with_fine(brushed.fine), Of(brushed), light)
            }
        }),
    };
    light.height * value
}

/// Of a factor that is the same all over the light all but that.
fn sum_of_parts(shape: &Shape, lobe: impl Both, light: &Outline) -> [f32; 2] {
    let level = Level::new();
    let (mut waiting, mut count, mut seen) = ([[Vec3::ZERO; 4]; ROOM], 0, 0);
    in_quadrilaterals(light.corners(), |part| {
        waiting[count] = part;
        count += 1;
    });
    let mut sums = [0.0; 2];
    while count > 0 {
        let (mut parts, mut wanted) = ([[0.0; WIDTH]; 12], [[0.0; WIDTH]; 2]);
        let taken = if count < WIDTH { count } else { WIDTH };
        count -= taken;
        for j in 0..taken {
            set_row(&mut parts, j, &bytemuck::cast(waiting[count + j]));
        }
        map(level, &Wanted(*shape), &parts, &[], &mut wanted);
        seen += taken;
        for j in 0..taken {
            let part: [Vec3; 4] = bytemuck::cast(row(&parts, j));
            let [u, v] = row(&wanted, j);
            let is_last = seen > MOST || count + 4 > ROOM;
            if u == NOTHING {
                continue;
            }
            let more = if u.max(v) <= 1.0 {
                over_nodes::<16>(level, lobe, part)
            } else if u.max(v) <= 3.0 || is_last {
                over_nodes::<64>(level, lobe, part)
            } else {
                for part in divided(part, [u > 3.0, v > 3.0]).into_iter().flatten() {
                    waiting[count] = part;
                    count += 1;
                }
                continue;
            };
            sums = [sums[0] + more[0], sums[1] + more[1]];
        }
    }
    sums
}

/// A convex polygon as quadrilaterals: what is between its two longest sides, which are those of a tube, and what that leaves at both ends.
fn in_quadrilaterals(corners: &[Vec3], mut take: impl FnMut([Vec3; 4])) {
    let count = corners.len();
    let corner = |k: usize| corners[k % count];
    let mut fan = |first: usize, last: usize| {
        for k in (first + 1..last).step_by(2) {
            take([corner(first), corner(k), corner(k + 1), corner(last.min(k + 2))]);
        }
    };
    if count <= FEW {
        return fan(0, count - 1);
    }
    let [mut longest, mut second] = [(0, 0.0); 2];
    for k in 0..count {
        let square = corner(k).distance_squared(corner(k + 1));
        if square > longest.1 {
            (longest, second) = ((k, square), longest);
        } else if square > second.1 {
            second = (k, square);
        }
    }
    let (from, to) = (longest.0.min(second.0), longest.0.max(second.0));
    fan(from + 1, to);
    fan(to + 1, from + count);
    take([corner(from), corner(from + 1), corner(to), corner(to + 1)]);
}

/// The halves of a part along the sides that say so.
fn divided(part: [Vec3; 4], [across, up]: [bool; 2]) -> [Option<[Vec3; 4]>; 4] {
    let in_two = |[a, b, c, d]: [Vec3; 4]| {
        let (low, high) = (0.5 * (a + b), 0.5 * (d + c));
        [[a, low, high, d], [low, b, c, high]]
    };
    // Along the other side: as seen from the next corner.
    let turned = |[a, b, c, d]: [Vec3; 4]| [b, c, d, a];
    match (across, up) {
        (true, false) => {
            let [a, b] = in_two(part);
            [Some(a), Some(b), None, None]
        }
        (false, _) => {
            let [a, b] = in_two(turned(part));
            [Some(a), Some(b), None, None]
        }
        (true, true) => {
            let [a, b] = in_two(part);
            let ([a, b], [c, d]) = (in_two(turned(a)), in_two(turned(b)));
            [Some(a), Some(b), Some(c), Some(d)]
        }
    }
}

/// The rules of a part of a light.
struct Wanted(Shape);

impl Lane<12, 0, 2> for Wanted {
    #[inline(always)]
    fn value(&self, part: [f32; 12], []: [f32; 0]) -> [f32; 2] {
        rules(bytemuck::cast(part), &self.0)
    }
}

/// Places on a part and weights, of a rule along both of its sides: `N` nodes in columns.
const fn places<const N: usize>(rule: &[(f32, f32)]) -> [[f32; N]; 3] {
    let mut places = [[0.0; N]; 3];
    let side = 2 * rule.len();
    let mut k = 0;
    while k < N {
        let ([i, j], mut own) = ([k % side, k / side], [(0.0, 0.0); 2]);
        let mut axis = 0;
        while axis < 2 {
            let i = [i, j][axis];
            let (node, weight) = rule[i / 2];
            own[axis] = (if i % 2 == 0 { node } else { -node }, weight);
            axis += 1;
        }
        [places[0][k], places[1][k], places[2][k]] = [own[0].0, own[1].0, own[0].1 * own[1].1];
        k += 1;
    }
    places
}

/// The sum over nodes, sixteen side by side, of four or eight along each side of a part.
fn over_nodes<const N: usize>(level: Level, lobe: impl Both, [a, b, c, d]: [Vec3; 4]) -> [f32; 2] {
    let [across, along, weights] = const { places::<N>(if N == 16 { &FOUR } else { &EIGHT }) };
    let (middle, twist) = (0.25 * (a + b + c + d), 0.25 * (a + c - b - d));
    let (right, up) = (0.25 * (b + c - a - d), 0.25 * (c + d - a - b));
    dispatch!(level, _simd => {
        let mut sums = [[0.0; WIDTH]; 2];
        let [(across, _), (along, _), (weights, _)] = [&across, &along, &weights].map(|column| column.as_chunks::<WIDTH>());
        for ((u, v), weights) in across.iter().zip(along).zip(weights) {
            let [first_sums, second_sums] = &mut sums;
            for (j, (base, edge)) in first_sums.iter_mut().zip(second_sums).enumerate() {
                let (u, v, weight) = (u[j], v[j], weights[j]);
                let area = weight * (right + twist * v).cross(up + twist * u).length();
                let value = added(&lobe, middle + right * u + up * v + twist * (u * v), area);
                *base += value[0];
                *edge += value[1];
            }
        }
        sums.map(|sums| sums.into_iter().fold(0.0, |sum, x| sum + x))
    })
}
