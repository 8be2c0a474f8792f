//! Silhouettes before a whole sky.

use crate::edge_list::{CLOSED, COARSE, Columns, ENDS, EdgeList, ID, MARKS, PLANES, SOMETIMES};
use crate::hull::{Fineness, Hull, Memory};
use crate::lists::Meshes;
use crate::look::{LookMemory, Looker};
use crate::select::{drawn, steps};
use crate::{AnyHit, SilhouetteBlockers};
use fearless_simd::{Level, Simd, dispatch, f32x8, mask32x8, prelude::*, u32x8};
use glam::Vec3;
use lobe_core::Receiver;
use lobe_core::vec3x8::Vec3x8;
use visibility_mask::sky::{Horizon, Meridians, SkyArcs, SkyBlockers, SkyBuffer, SkyTile, SkyWindow};

/// Receivers that share a list: those of a tile that are near each other.
const PART: usize = 8;
/// Parts that share a longer list, between that of the tile and theirs.
const PARTS: usize = 2;
/// Details smaller than this part of the angle between meridians may be left out, root mean square.
const DETAIL: f32 = 0.05;

/// Numbers of an edge whose step is known: its ends, the step, and the bits of its number.
pub(crate) const KNOWN: usize = 8;
pub(crate) const STEP: usize = 6;
pub(crate) const NAME: usize = 7;

/// Working memory of [`SilhouetteBlockers`] before a sky.
#[derive(Clone, Debug)]
pub struct SkySilhouetteScratch<H> {
    /// Where rays start, of each receiver of the tile.
    origins: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Edges that may be silhouettes for any of them.
    edges: EdgeList,
    /// The receivers in an order in which those of a part follow each other, and the place of each in it.
    order: Vec<usize>,
    places: Vec<usize>,
    parts: Vec<Part>,
    /// Of [`PARTS`] parts each.
    groups: Vec<Group>,
    /// The silhouettes of one receiver among the latter.
    found: Columns<KNOWN>,
    arcs: SkyArcs,
    memory: Memory,
    look: LookMemory,
    hits: H,
}

/// Receivers that share lists.
#[derive(Clone, Debug, Default)]
struct Part {
    is_listed: bool,
    /// Edges that are silhouettes for all of its receivers, and those that may be for some.
    known: Columns<KNOWN>,
    open: EdgeList,
}

/// Parts that share a list.
#[derive(Clone, Debug, Default)]
struct Group {
    is_listed: bool,
    /// Edges that may be silhouettes for any of their receivers.
    edges: EdgeList,
}

/// The run of `size` receivers of that number.
fn run(order: &[usize], number: usize, size: usize) -> &[usize] {
    &order[number * size..((number + 1) * size).min(order.len())]
}

/// Orders receivers so that each run of [`PART`] of them is close together: halves of halves, along the longest side of the box around
/// them.
fn divide(order: &mut [usize], origins: &[Vec3]) {
    if order.len() <= PART {
        return;
    }
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = order.iter().map(|i| origins[*i]).fold(none, |[low, high], p| [low.min(p), high.max(p)]);
    let axis = (high - low).max_position();
    let unit = if order.len() > PART * PARTS { PART * PARTS } else { PART };
    let half = (order.len() / 2).next_multiple_of(unit);
    let place = |i: &usize| origins[*i][axis];
    // Less than all: there are more than a unit.
    order.select_nth_unstable_by(half, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
    let (one, other) = order.split_at_mut(half);
    divide(one, origins);
    divide(other, origins);
}

impl<H> SkySilhouetteScratch<H> {
    /// Divides the receivers into parts without lists.
    fn divide(&mut self) {
        let count = self.origins.len();
        self.order.clear();
        self.order.extend(0..count);
        divide(&mut self.order, &self.origins);
        self.places.resize(count, 0);
        for (place, receiver) in self.order.iter().enumerate() {
            self.places[*receiver] = place;
        }
        self.parts.resize_with(count.div_ceil(PART), Part::default);
        self.parts.iter_mut().for_each(|part| part.is_listed = false);
        self.groups.resize_with(count.div_ceil(PART * PARTS), Group::default);
        self.groups.iter_mut().for_each(|group| group.is_listed = false);
    }

    /// The hull of the run of receivers of that number.
    fn hull_of(&self, number: usize, size: usize, scale: Option<f32>) -> Hull {
        let run = run(&self.order, number, size);
        let [origins, normals] =
            [&self.origins, &self.normals].map(|all| run.iter().map(|i| all[*i]).collect::<Vec<Vec3>>());
        Hull::of_sky(&origins, &normals, scale)
    }
}

impl<H: AnyHit> SilhouetteBlockers<'_, H> {
    /// Makes the lists of a part.
    fn list_part(&self, tile: &SkyTile<'_>, number: usize, scratch: &mut SkySilhouetteScratch<H::Scratch>) {
        let scale = self.sky_scale(tile.meridians);
        let group = number / PARTS;
        if !scratch.groups[group].is_listed {
            let hull = scratch.hull_of(group, PART * PARTS, scale);
            let SkySilhouetteScratch { groups, edges, .. } = scratch;
            dispatch!(Level::new(), simd => hull.narrow(simd, edges, &mut groups[group].edges));
            groups[group].is_listed = true;
        }
        let hull = scratch.hull_of(number, PART, scale);
        let SkySilhouetteScratch { order, parts, groups, .. } = scratch;
        let own = run(order, number, PART).iter();
        let sift = Sift::new(&hull, tile.meridians, own.map(|i| &tile.horizons[*i]));
        let Part { is_listed, known, open } = &mut parts[number];
        dispatch!(Level::new(), simd => sift.narrow(simd, &groups[group].edges, known, open));
        *is_listed = true;
    }

    /// The scale of the simplified forms that a sky's meridians allow.
    fn sky_scale(&self, meridians: &Meridians) -> Option<f32> {
        (self.meshes.fineness != Fineness::default()).then(|| 1.0 / (DETAIL * meridians.resolution().pitch()))
    }
}

impl<H: AnyHit> SkyBlockers for SilhouetteBlockers<'_, H> {
    type Scratch = SkySilhouetteScratch<H::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        SkySilhouetteScratch {
            origins: Vec::new(),
            normals: Vec::new(),
            edges: EdgeList::default(),
            order: Vec::new(),
            places: Vec::new(),
            parts: Vec::new(),
            groups: Vec::new(),
            found: Columns::default(),
            arcs: SkyArcs::default(),
            memory: Memory::default(),
            look: LookMemory::default(),
            hits: self.hits.scratch(),
        }
    }

    fn has_facet(&self, at: &Receiver) -> bool {
        self.hits.has(at.object)
    }

    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut Self::Scratch) {
        scratch.origins.clear();
        scratch.origins.extend(tile.receivers.iter().map(|at| self.hits.leave(at.position, at.face)));
        scratch.normals.clear();
        scratch.normals.extend(tile.horizons.iter().map(Horizon::normal));
        let hull = Hull::of_sky(&scratch.origins, &scratch.normals, self.sky_scale(tile.meridians));
        scratch.divide();
        // Of any number of leaves.
        let (_, rest) = self.before_sky();
        let _ = rest.list(&hull, usize::MAX, &mut scratch.memory, &mut scratch.edges);
    }

    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut Self::Scratch) -> bool {
        let (levels, rest) = self.before_sky();
        if scratch.edges.is_empty() && levels.is_empty() {
            return false;
        }
        let scale = self.sky_scale(tile.meridians);
        let part = scratch.places[number] / PART;
        if !scratch.edges.is_empty() && !scratch.parts[part].is_listed {
            self.list_part(tile, part, scratch);
        }
        let scale = scale.unwrap_or_default();
        let (horizon, origin) = (tile.horizons[number], scratch.origins[number]);
        let SkySilhouetteScratch { edges, parts, found, arcs, look: memory, .. } = scratch;
        let window = *buffer.window();
        let look = SkyOutlines { meshes: rest, meridians: tile.meridians, horizon, window, origin, scale };
        let looker = Looker { origin, horizon, window, meridians: tile.meridians, scale };
        let Part { known, open, .. } = &parts[part];
        arcs.clear();
        dispatch!(Level::new(), simd => {
            let mut is_coarse = false;
            if !edges.is_empty() {
                arcs.reserve(known.len() + open.len());
                is_coarse |= look.draw_known(simd, known, origin, arcs);
                look.find(simd, open, found);
                is_coarse |= look.draw_known(simd, found, Vec3::ZERO, arcs);
            }
            for levels in levels {
                looker.find(simd, levels, memory, found);
                arcs.reserve(found.len());
                is_coarse |= look.draw_known(simd, found, Vec3::ZERO, arcs);
            }
            buffer.draw(simd, tile.meridians, arcs);
            is_coarse
        })
    }

    fn hides(&self, _: &SkyTile<'_>, number: usize, direction: Vec3, scratch: &mut Self::Scratch) -> bool {
        self.hits.is_hit(scratch.origins[number], direction, f32::INFINITY, &mut scratch.hits)
    }
}

/// Steps of edges by the sides of their triangles, in half surfaces. Of closed surfaces only the triangles count that face one way.
#[inline(always)]
pub(crate) fn in_halves<S: Simd>(simd: S, step: f32x8<S>, names: f32x8<S>) -> f32x8<S> {
    let mark = u32x8::splat(simd, CLOSED);
    (names.bitcast::<u32x8<S>>() & mark).simd_eq(mark).select(step, step + step)
}

/// On which side of a plane all receivers are, 0 where there is no plane, and whether that is known.
#[inline(always)]
fn known_side<S: Simd>(simd: S, [front, behind]: [mask32x8<S>; 2], normal: Vec3x8<S>) -> (f32x8<S>, mask32x8<S>) {
    let zero = f32x8::splat(simd, 0.0);
    let is_absent = normal.abs().dot_one(Vec3::ONE).simd_eq(zero);
    let plus = front.select(f32x8::splat(simd, 1.0), zero);
    (behind.select(f32x8::splat(simd, -1.0), plus), front | behind | is_absent)
}

/// Narrows a tile's list for a part of its receivers.
struct Sift<'a> {
    hull: &'a Hull,
    meridians: &'a Meridians,
    /// The horizon's, where all receivers have one pole.
    horizon: Option<Horizon>,
}

impl<'a> Sift<'a> {
    fn new<'h>(hull: &'a Hull, meridians: &'a Meridians, mut horizons: impl Iterator<Item = &'h Horizon>) -> Self {
        let horizon = horizons.next().filter(|first| horizons.all(|other| other.pole() == first.pole()));
        Self { hull, meridians, horizon: horizon.copied() }
    }

    /// Divides the edges that may matter to the part into those whose step is the same for all receivers, and others.
    #[inline(always)]
    fn narrow<S: Simd>(&self, simd: S, list: &EdgeList, known: &mut Columns<KNOWN>, open: &mut EdgeList) {
        known.clear();
        open.clear();
        for first in (0..list.len()).step_by(8) {
            let packet = (list, first);
            let one = self.hull.faces(simd, &packet, PLANES[0]);
            let other = self.hull.faces(simd, &packet, PLANES[1]);
            let lanes = mask32x8::from_bitmask(simd, u64::from(list.lanes(first)));
            let mut keep = lanes & !((one[0] & other[0]) | (one[1] & other[1]));
            if !keep.any_true() {
                continue;
            }
            keep &= self.hull.meets_edges(simd, &packet);
            if keep.any_true()
                && let Some(horizon) = &self.horizon
            {
                keep &= self.crosses(simd, list, first, horizon);
            }
            if !keep.any_true() {
                continue;
            }
            let one = known_side(simd, one, list.load3(simd, PLANES[0], first));
            let other = known_side(simd, other, list.load3(simd, PLANES[1], first));
            let names = list.load(simd, ID, first);
            let sometimes = names.bitcast::<u32x8<S>>().simd_ge(u32x8::splat(simd, SOMETIMES));
            let is_known = one.1 & other.1 & !sometimes;
            let (sure, unsure) = (keep & is_known, keep & !is_known);
            if sure.any_true() {
                known.reserve(8);
                known.put3(0, sure, list.load3(simd, ENDS[0], first));
                known.put3(3, sure, list.load3(simd, ENDS[1], first));
                known.put(STEP, sure, in_halves(simd, other.0 - one.0, names));
                known.put(NAME, sure, names);
                known.end(sure);
            }
            if unsure.any_true() {
                open.reserve(8);
                for column in 0..crate::edge_list::COLUMNS {
                    open.put(column, unsure, list.load(simd, column, first));
                }
                open.end(unsure);
            }
        }
    }

    /// Which of eight edges may cross a meridian of any of the receivers.
    #[inline(always)]
    fn crosses<S: Simd>(&self, simd: S, list: &EdgeList, first: usize, horizon: &Horizon) -> mask32x8<S> {
        let (center, half) = self.hull.receivers();
        // As far as receivers are from the middle, seen along the pole.
        let off = f32x8::splat(simd, horizon.pole().reach(half) * 1.01);
        let ends = [list.load3(simd, ENDS[0], first).minus(center), list.load3(simd, ENDS[1], first).minus(center)];
        self.meridians.may_cross(simd, horizon, ends, off)
    }
}

/// One receiver's silhouettes.
struct SkyOutlines<'a, 'm> {
    meshes: &'a Meshes<'m>,
    meridians: &'a Meridians,
    horizon: Horizon,
    window: SkyWindow,
    origin: Vec3,
    scale: f32,
}

impl SkyOutlines<'_, '_> {
    /// Lists the silhouettes among some edges, seen from the receiver.
    #[inline(always)]
    fn find<S: Simd>(&self, simd: S, list: &EdgeList, out: &mut Columns<KNOWN>) {
        out.clear();
        out.reserve(list.len());
        let x = self.origin;
        let zero = f32x8::splat(simd, 0.0);
        for first in (0..list.len()).step_by(8) {
            let mut keep = mask32x8::from_bitmask(simd, u64::from(list.lanes(first)));
            let number = |lane: usize| list.get(ID, first + lane).to_bits() & !MARKS;
            // To the right as the receiver sees it; masks are seen from the light.
            let step = -steps(simd, &(list, first), keep, x, |lane| self.meshes.sides(number(lane), x));
            keep &= !step.simd_eq(zero);
            if !keep.any_true() {
                continue;
            }
            let names = list.load(simd, ID, first);
            let sometimes = names.bitcast::<u32x8<S>>().simd_ge(u32x8::splat(simd, SOMETIMES));
            keep = drawn(simd, keep, sometimes, |lane| self.meshes.is_drawn_at(number(lane), x, self.scale));
            out.put3(0, keep, list.load3(simd, ENDS[0], first).minus(x));
            out.put3(3, keep, list.load3(simd, ENDS[1], first).minus(x));
            out.put(STEP, keep, in_halves(simd, step, names));
            out.put(NAME, keep, names);
            out.end(keep);
        }
    }

    /// Appends the arcs of edges whose steps are known and whose ends are given as seen from `from`; whether any are of simplified forms.
    #[inline(always)]
    fn draw_known<S: Simd>(&self, simd: S, list: &Columns<KNOWN>, from: Vec3, arcs: &mut SkyArcs) -> bool {
        let mut is_coarse = false;
        for first in (0..list.len()).step_by(8) {
            let ends = [list.load3(simd, 0, first).minus(from), list.load3(simd, 3, first).minus(from)];
            let lanes = mask32x8::from_bitmask(simd, u64::from(list.lanes(first)));
            let sight = (&self.horizon, &self.window);
            let kept = arcs.push(simd, self.meridians, sight, ends, list.load(simd, STEP, first), lanes);
            if kept.any_true() {
                let names = list.load(simd, NAME, first).bitcast::<u32x8<S>>();
                is_coarse |= (kept & (names & COARSE).simd_ge(u32x8::splat(simd, COARSE))).any_true();
            }
        }
        is_coarse
    }
}
