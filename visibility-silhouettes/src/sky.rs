//! Silhouettes before a whole sky.

use crate::edge_list::{CLOSED, COARSE, Columns, ENDS, EdgeList, ID, MARKS, SOMETIMES};
use crate::hull::{Fineness, Hull, Memory};
use crate::levels::Levels;
use crate::lists::{Meshes, SkyMeshes};
use crate::look::{LookMemory, Looker, Space, World};
use crate::look_placed::Search;
use crate::select::{drawn, steps};
use crate::sift::{FormMemory, Shared, Sift};
use crate::{SilhouetteBlockers, SilhouetteInstances};
use fearless_simd::{Level, Simd, dispatch, f32x8, mask32x8, prelude::*, u32x8};
use glam::Vec3;
use lobe_core::Receiver;
use shading::DynScratch;
use visibility_mask::sky::{Horizon, Meridians, SkyArcs, SkyBlockers, SkyBuffer, SkyTile, SkyWindow};

/// Receivers that share a list: those of a tile that are near each other.
const PART: usize = 8;
/// Parts that share a longer list, between that of the tile and theirs.
const PARTS: usize = 2;
/// A tile that meets more leaves than this is not drawn: its lists would take some 200 MB, and each receiver more time than rays.
const MOST_LEAVES: usize = 1 << 16;
/// Receivers of a part share the edges of a mesh's forms if they are within this part of the mesh's radius. Farther apart they see too different
/// edges, and each searches for itself.
const CLOSE: f32 = 0.25;
/// Details smaller than this part of the angle between meridians may be left out, root mean square.
const DETAIL: f32 = 0.05;

/// Numbers of an edge whose step is known: its ends, the step, and the bits of its number.
pub(crate) const KNOWN: usize = 8;
pub(crate) const STEP: usize = 6;
pub(crate) const NAME: usize = 7;

/// Working memory of [`SilhouetteBlockers`] before a sky.
#[derive(Debug)]
pub struct SkySilhouetteScratch {
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
    forms: FormMemory,
    hits: DynScratch,
}

/// Receivers that share lists.
#[derive(Clone, Debug, Default)]
struct Part {
    is_listed: bool,
    shared: Shared,
    /// Of each mesh with forms for a sky the edges that the receivers share, if they do; and whether these are listed.
    forms: Vec<Option<Shared>>,
    has_forms: bool,
    /// The same of places of shared meshes that matter to the receivers, with their numbers. Behind the first so many are old ones.
    placed: Vec<(u32, Option<Shared>)>,
    places: usize,
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

impl SkySilhouetteScratch {
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
        self.parts.iter_mut().for_each(|part| (part.is_listed, part.has_forms) = (false, false));
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

/// Gives receivers that are close together for a mesh's size lists to share, and others none.
fn share(hull: &Hull, levels: &Levels, shared: &mut Option<Shared>) {
    let (_, half) = hull.receivers();
    let is_close = half.length() < CLOSE * levels.radius();
    *shared = is_close.then(|| shared.take().unwrap_or_default());
}

impl SilhouetteBlockers<'_> {
    /// Makes the lists of a part.
    fn list_part(&self, tile: &SkyTile<'_>, number: usize, scratch: &mut SkySilhouetteScratch) {
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
        let sift = Sift::new(World, &hull, tile.meridians, own.map(|i| &tile.horizons[*i]));
        let Part { is_listed, shared, .. } = &mut parts[number];
        dispatch!(Level::new(), simd => sift.narrow(simd, &groups[group].edges, shared));
        *is_listed = true;
    }

    /// Makes the lists of a part before forms for a sky.
    fn list_forms(
        &self,
        tile: &SkyTile<'_>,
        (sky, scale): (&SkyMeshes<'_>, f32),
        number: usize,
        scratch: &mut SkySilhouetteScratch,
    ) {
        let hull = scratch.hull_of(number, PART, Some(scale));
        let SkySilhouetteScratch { order, origins, normals, parts, forms: memory, look, .. } = scratch;
        let run = run(order, number, PART);
        let horizons = || run.iter().map(|i| &tile.horizons[*i]);
        let sift = Sift::new(World, &hull, tile.meridians, horizons());
        let Part { forms, has_forms, placed, places, .. } = &mut parts[number];
        forms.resize_with(sky.levels.len(), Default::default);
        for (levels, shared) in sky.levels.iter().zip(forms) {
            share(&hull, levels, shared);
            if let Some(shared) = shared {
                let origins = run.iter().map(|i| origins[*i]);
                dispatch!(Level::new(), simd => sift.list_forms(simd, (levels, scale), origins, memory, shared));
            }
        }
        *has_forms = true;
        *places = 0;
        let Some(all) = sky.placed else { return };
        dispatch!(Level::new(), simd => sift.places(simd, all, look));
        for place in &look.places {
            let (mesh, _) = all.at(*place as usize);
            let (at, Some(levels)) = (mesh.place, mesh.levels()) else { continue };
            let own = run.iter().map(|i| at.own(origins[*i], normals[*i]));
            let (own_origins, own_normals): (Vec<Vec3>, Vec<Vec3>) =
                own.map(|[origin, normal]| (origin, normal)).unzip();
            let hull = Hull::of_sky(&own_origins, &own_normals, Some(scale));
            if *places == placed.len() {
                placed.push((0, None));
            }
            let (known, shared) = &mut placed[*places];
            *known = *place;
            *places += 1;
            share(&hull, levels, shared);
            if let Some(shared) = shared {
                let sift = Sift::new(at.turn(), &hull, tile.meridians, horizons());
                let own = own_origins.iter().copied();
                dispatch!(Level::new(), simd => sift.list_forms(simd, (levels, scale), own, memory, shared));
            }
        }
    }

    /// The scale of the simplified forms that a sky's meridians allow.
    fn sky_scale(&self, meridians: &Meridians) -> Option<f32> {
        (self.meshes.fineness != Fineness::default()).then(|| 1.0 / (DETAIL * meridians.resolution().pitch()))
    }
}

impl SkyBlockers for SilhouetteBlockers<'_> {
    type Scratch = SkySilhouetteScratch;

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
            forms: FormMemory::default(),
            hits: self.hits.scratch(),
        }
    }

    fn has_facet(&self, at: &Receiver) -> bool {
        self.hits.has(at.object)
    }

    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut Self::Scratch) -> bool {
        scratch.origins.clear();
        scratch.origins.extend(tile.receivers.iter().map(|at| self.hits.leave(at.position, at.face)));
        scratch.normals.clear();
        scratch.normals.extend(tile.horizons.iter().map(Horizon::normal));
        let hull = Hull::of_sky(&scratch.origins, &scratch.normals, self.sky_scale(tile.meridians));
        scratch.divide();
        let (_, rest) = self.before_sky();
        rest.list(&hull, MOST_LEAVES, &mut scratch.memory, &mut scratch.edges).is_some()
    }

    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut Self::Scratch) -> bool {
        let (sky, rest) = self.before_sky();
        if scratch.edges.is_empty() && sky.is_none() {
            return false;
        }
        let scale = self.sky_scale(tile.meridians);
        let part = scratch.places[number] / PART;
        if !scratch.edges.is_empty() && !scratch.parts[part].is_listed {
            self.list_part(tile, part, scratch);
        }
        let scale = scale.unwrap_or_default();
        let window = *buffer.window();
        if let (true, Some(sky), false) = (window.is_whole(), sky, scratch.parts[part].has_forms) {
            self.list_forms(tile, (sky, scale), part, scratch);
        }
        let (horizon, origin) = (tile.horizons[number], scratch.origins[number]);
        let SkySilhouetteScratch { edges, parts, found, arcs, look: memory, .. } = scratch;
        let look = SkyOutlines { space: World, meridians: tile.meridians, horizon, window, origin };
        let (normal, meridians) = (horizon.normal(), tile.meridians);
        let looker = Looker { space: World, origin, normal, horizon, window, meridians, scale };
        let Part { shared, forms, placed, places, .. } = &parts[part];
        arcs.clear();
        dispatch!(Level::new(), simd => {
            let mut is_coarse = false;
            if !edges.is_empty() {
                is_coarse |= look.draw_shared(simd, shared, &(rest, scale), found, arcs);
            }
            for (number, levels) in sky.iter().flat_map(|sky| &sky.levels).enumerate() {
                let shared = forms.get(number).and_then(Option::as_ref).filter(|_| window.is_whole());
                if let Some(shared) = shared {
                    let seen = memory.seen(levels, origin, scale);
                    is_coarse |= look.draw_shared(simd, shared, &(*levels, seen), found, arcs);
                } else {
                    looker.find(simd, levels, memory, found);
                    is_coarse |= look.draw_found(simd, found, arcs);
                }
            }
            if let Some(all) = sky.and_then(|sky| sky.placed) {
                // Through windows receivers search for themselves.
                let listed = window.is_whole().then_some(&placed[..*places]);
                is_coarse |= look.draw_placed(simd, all, &looker, listed, (memory, found), arcs);
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

/// The sides of edges by their numbers, and which of them one receiver sees.
trait Source {
    /// On which sides of an edge's two triangles a point lies.
    fn sides(&self, edge: u32, x: Vec3) -> [f32; 2];

    /// Whether the receiver at `x` sees an edge that only some see.
    fn is_drawn(&self, edge: u32, x: Vec3) -> bool;
}

/// Meshes, and the scale of their simplified forms.
impl Source for (&Meshes<'_>, f32) {
    fn sides(&self, edge: u32, x: Vec3) -> [f32; 2] {
        self.0.sides(edge, x)
    }

    fn is_drawn(&self, edge: u32, x: Vec3) -> bool {
        self.0.is_drawn_at(edge, x, self.1)
    }
}

/// Forms for a sky, and which of them the receiver sees.
impl Source for (&Levels, &[bool]) {
    fn sides(&self, edge: u32, x: Vec3) -> [f32; 2] {
        self.0.sides(edge, x)
    }

    fn is_drawn(&self, edge: u32, _: Vec3) -> bool {
        let (_, tag) = self.0.leaf(edge);
        tag.iter().all(|form| self.1[usize::from(*form)])
    }
}

/// One receiver's silhouettes, of a mesh in whose coordinates the receiver is.
struct SkyOutlines<'a, T> {
    space: T,
    meridians: &'a Meridians,
    horizon: Horizon,
    window: SkyWindow,
    origin: Vec3,
}

impl<T: Space> SkyOutlines<'_, T> {
    /// Appends the arcs of edges that the receiver shares with others; whether any are of simplified forms.
    #[inline(always)]
    fn draw_shared<S: Simd>(
        &self,
        simd: S,
        Shared { known, open }: &Shared,
        source: &impl Source,
        found: &mut Columns<KNOWN>,
        arcs: &mut SkyArcs,
    ) -> bool {
        arcs.reserve(known.len() + open.len());
        let is_coarse = self.draw_known(simd, known, self.origin, arcs);
        self.find(simd, open, source, found);
        self.draw_known(simd, found, Vec3::ZERO, arcs) || is_coarse
    }

    /// Lists the silhouettes among some edges, seen from the receiver.
    #[inline(always)]
    fn find<S: Simd>(&self, simd: S, list: &EdgeList, source: &impl Source, out: &mut Columns<KNOWN>) {
        out.clear();
        out.reserve(list.len());
        let x = self.origin;
        let zero = f32x8::splat(simd, 0.0);
        for first in (0..list.len()).step_by(8) {
            let mut keep = mask32x8::from_bitmask(simd, u64::from(list.lanes(first)));
            let number = |lane: usize| list.get(ID, first + lane).to_bits() & !MARKS;
            // To the right as the receiver sees it; masks are seen from the light.
            let step = -steps(simd, &(list, first), keep, x, |lane| source.sides(number(lane), x));
            keep &= !step.simd_eq(zero);
            if !keep.any_true() {
                continue;
            }
            let names = list.load(simd, ID, first);
            let sometimes = names.bitcast::<u32x8<S>>().simd_ge(u32x8::splat(simd, SOMETIMES));
            keep = drawn(simd, keep, sometimes, |lane| source.is_drawn(number(lane), x));
            out.put3(0, keep, list.load3(simd, ENDS[0], first).minus(x));
            out.put3(3, keep, list.load3(simd, ENDS[1], first).minus(x));
            out.put(STEP, keep, in_halves(simd, step, names));
            out.put(NAME, keep, names);
            out.end(keep);
        }
    }

    /// The same for silhouettes whose ends are given as the receiver sees them.
    #[inline(always)]
    fn draw_found<S: Simd>(&self, simd: S, list: &Columns<KNOWN>, arcs: &mut SkyArcs) -> bool {
        arcs.reserve(list.len());
        self.draw_known(simd, list, Vec3::ZERO, arcs)
    }

    /// Appends the arcs of edges whose steps are known and whose ends are given as seen from `from`; whether any are of simplified forms.
    #[inline(always)]
    fn draw_known<S: Simd>(&self, simd: S, list: &Columns<KNOWN>, from: Vec3, arcs: &mut SkyArcs) -> bool {
        let mut is_coarse = false;
        for first in (0..list.len()).step_by(8) {
            let (a, b) = (list.load3(simd, 0, first).minus(from), list.load3(simd, 3, first).minus(from));
            let ends = [self.space.vector(a), self.space.vector(b)];
            let step = list.load(simd, STEP, first);
            let step = if self.space.is_mirrored() { -step } else { step };
            let lanes = mask32x8::from_bitmask(simd, u64::from(list.lanes(first)));
            let sight = (&self.horizon, &self.window);
            let kept = arcs.push(simd, self.meridians, sight, ends, step, lanes);
            if kept.any_true() {
                let names = list.load(simd, NAME, first).bitcast::<u32x8<S>>();
                is_coarse |= (kept & (names & COARSE).simd_ge(u32x8::splat(simd, COARSE))).any_true();
            }
        }
        is_coarse
    }
}

impl SkyOutlines<'_, World> {
    /// Appends the arcs of shared meshes at their places: of those that are listed for a part, or of those that the receiver finds itself; whether
    /// any are of simplified forms.
    #[inline(always)]
    fn draw_placed<S: Simd>(
        &self,
        simd: S,
        all: &SilhouetteInstances,
        looker: &Looker<'_, World>,
        listed: Option<&[(u32, Option<Shared>)]>,
        (memory, found): (&mut LookMemory, &mut Columns<KNOWN>),
        arcs: &mut SkyArcs,
    ) -> bool {
        if listed.is_none() {
            looker.places(simd, all, memory);
        }
        let mut is_coarse = false;
        for number in 0..listed.map_or(memory.places.len(), <[_]>::len) {
            let (place, shared) = match listed {
                Some(listed) => (listed[number].0, listed[number].1.as_ref()),
                None => (memory.places[number], None),
            };
            let (placed, _) = all.at(place as usize);
            let Some(levels) = placed.levels() else { continue };
            let own = looker.at(placed.place);
            if let Some(shared) = shared {
                let Looker { space, origin, .. } = own;
                let seen = memory.seen(levels, origin, looker.scale);
                let Self { meridians, horizon, window, .. } = *self;
                let outlines = SkyOutlines { space, meridians, horizon, window, origin };
                is_coarse |= outlines.draw_shared(simd, shared, &(levels, seen), found, arcs);
            } else {
                own.find(simd, levels, memory, found);
                is_coarse |= self.draw_found(simd, found, arcs);
            }
        }
        is_coarse
    }
}
