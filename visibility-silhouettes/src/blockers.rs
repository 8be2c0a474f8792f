use crate::any_hit::DynAnyHit;
use crate::beside::Beside;
use crate::clip::{Behind, LightSphere, add_chord};
use crate::fit::{is_flat, side};
use crate::hidden::Hidden;
use crate::hull::Fineness;
use crate::lists::{Lists, Meshes, SkyMeshes};
use crate::penumbra::narrowest;
use crate::project::View;
use crate::select::{add_arcs, add_edges, silhouettes};
use crate::topology::normal;
use crate::{AnyHit, SilhouetteInstances, SilhouetteMesh};
use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use lobe_core::{Outline, Receiver, Sphere};
use scratch::{Alike, Plane};
use shading::{Coverage, DynScratch, Shaft, VisibilityQuery};
use trapezoids::Emits;
use visibility_mask::{Blockers, Edges, LitArea, Mask, asks_for_openings, facet_coverage};

mod cells;
mod openings;
mod parts;
#[cfg(test)]
mod parts_tests;
mod scratch;
pub(crate) mod trapezoids;

pub use scratch::SilhouetteScratch;

/// The size of details that a tolerance leaves out: this fraction of it, in radii of the light. A root mean square, measured so
/// that masks differ by less than a quarter of the tolerance in the mean.
const DETAIL: f32 = 4.0;

/// The depth of a mask whose columns tell whether something may be open between rows.
const COLUMNS: u32 = 3;

/// The smallest cosine between two normals of one plane.
const ALONG: f64 = 0.999_9;

/// Before more outlines than this, the lit part of a dark mask, or of an ordinary penumbra, is found as it is only if anything is open between rows or samples.
const MANY: usize = 128;

/// The widest disc, `1 − cos θ`, in front of which edges are summed.
pub(crate) const WIDEST_DISC: f32 = 0.9;

/// The `silhouettes` strategy: triangle meshes block exactly, and the cost follows their outlines. Wrap it in
/// [`MaskVisibility`](visibility_mask::MaskVisibility).
///
/// # Method
/// Seen from a receiver, the number of surfaces in front of a direction changes only across silhouettes: borders, and edges between
/// a triangle that faces the receiver and one that does not. The crossings of silhouettes with the rows of the mask give the number
/// at each sample, up to one constant. One any-hit ray through a sample with the fewest surfaces gives the constant. A sample is
/// lit if its number is zero.
///
/// Each decision is made once for a vertex (between which rows it lies), once for a triangle (on which side of its plane the
/// receiver is: in f32 if that is certain, else in f64) or once for an edge (where it crosses a row). Outlines therefore stay
/// closed whatever the rounding: no light leaks between triangles, whether they are open, intersecting, or wound either way.
///
/// Surfaces count as far as the light's front side. If a triangle reaches into the light, its silhouettes end at the light's
/// surface, and the arc in which that surface cuts the triangle is an outline too, drawn as chords of a circle of 64 sides.
///
/// # Accuracy
/// On 10 000 random soups of triangles (loose, closed, intersecting, wound either way, cards, strips, needles) 1 of 12.9 million
/// samples differs from f64 rays, on a needle as thin as rounding. If triangles reach into the light, 108 of 1.3 million samples
/// differ, beside chords.
///
/// # Cost
/// A hierarchy of edges is searched once for a group of receivers that are close together, and cells of the group have shorter
/// lists; else it is searched for a few neighbours, or for each receiver. A receiver then takes time for each edge of its list, for
/// each silhouette in front of its light, for each row that a silhouette crosses, and for one ray. In a group without silhouettes,
/// all receivers on one face share one ray if all triangles near them are in the plane of that face.
/// `cargo run --release -p cosine-lobes-render-cpu --example silhouettes` compares the time with that of shadow rays.
///
/// # Simplified forms
/// Most edges of a large mesh are finer than a mask can show. [`SilhouetteMesh::with_coarse`] divides a mesh into patches and
/// simplifies each, except its rim. With [`with_tolerance`](Self::with_tolerance) a receiver sees the simplified form of a patch
/// from a distance at which the root mean square of its difference is a small fraction of the light's size there. Any choice of
/// forms is closed, since an edge between two patches is stored for each choice. Two of three rays then decide whether the fewest
/// surfaces are none.
///
/// A whole sky is seen through forms of its own ([`under_sky`](Self::under_sky)), of several levels: the farther, the simpler.
#[derive(Debug)]
pub struct SilhouetteBlockers<'m> {
    pub(crate) meshes: Meshes<'m>,
    /// Where any mesh has forms for a whole sky.
    sky: Option<SkyMeshes<'m>>,
    pub(crate) hits: Box<dyn DynAnyHit + 'm>,
}

impl<'m> SilhouetteBlockers<'m> {
    /// Blockers of several meshes, and the rays against their triangles.
    #[must_use]
    pub fn new(meshes: impl IntoIterator<Item = &'m SilhouetteMesh>, hits: impl AnyHit + 'm) -> Self {
        Self { meshes: Meshes::new(meshes.into_iter().collect()), sky: None, hits: Box::new(hits) }
    }

    /// Adds shared meshes at their places. The rays are to meet these as well.
    #[must_use]
    pub fn with_instances(mut self, instances: &'m SilhouetteInstances) -> Self {
        self.meshes = self.meshes.with_instances(instances);
        self
    }

    /// Draws [simplified forms](SilhouetteMesh::with_coarse) for receivers that cannot tell their outlines from the exact ones: the
    /// visible fraction changes by less than a quarter of `tolerance` in the mean. `tolerance` is relative to the unshadowed
    /// radiance. 0, as after [`new`](Self::new), gives exact masks.
    ///
    /// The outlines of a receiver depend only on it and its light, not on the other receivers of its group.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f32) -> Self {
        self.meshes.fineness = Fineness(DETAIL * tolerance.clamp(0.0, 0.1));
        self
    }

    /// Prepares what a whole sky is seen through ([`SkyBlockers`](visibility_mask::sky::SkyBlockers)): forms of large meshes, simpler by the distance.
    /// Call it last, and not in parallel loops. Without it a sky is seen through the forms for lights.
    ///
    /// # Cost
    /// For each mesh [with simplified forms](SilhouetteMesh::with_coarse) that has moved since the last call about as much time as those forms, and 300
    /// bytes a triangle while the mesh lives. Edges of other meshes are copied, 93 bytes a triangle.
    #[must_use]
    pub fn under_sky(self) -> Self {
        self.meshes.pack();
        let is_exact = self.meshes.fineness == Fineness::default();
        Self { sky: if is_exact { None } else { self.meshes.with_levels() }, ..self }
    }

    /// The forms before a sky, and the meshes without them.
    pub(crate) fn before_sky(&self) -> (Option<&SkyMeshes<'m>>, &Meshes<'m>) {
        (self.sky.as_ref(), self.sky.as_ref().map_or(&self.meshes, |sky| &sky.rest))
    }

    /// Calls `visit` for all triangles that may meet a sphere: see [`AnyHit::triangles_meeting`].
    pub fn triangles_meeting(&self, sphere: Sphere, visit: &mut dyn FnMut([Vec3; 3])) {
        self.hits.triangles_meeting(sphere, visit);
    }

    /// Lists the edges in a shaft.
    fn list(&self, shaft: &Shaft, scratch: &mut SilhouetteScratch) {
        let near = scratch.near.enter(shaft, |sphere, visit| self.hits.triangles_meeting(sphere, visit));
        scratch.light = shaft.light;
        scratch.is_clipped = near.is_clipped;
        // The outlines in which a light cuts triangles continue exact ones only.
        scratch.is_exact = !near.is_empty();
        let fineness = if scratch.is_exact { Fineness::default() } else { self.meshes.fineness };
        // Rays start off the surface, and thus slightly outside of the receivers' box.
        let off = self.hits.leave(shaft.receivers.center, Vec3::Y).distance(shaft.receivers.center);
        scratch.lists.enter(&self.meshes, shaft, 2.0 * off + 1e-6 * shaft.receivers.radius, fineness);
        scratch.is_met = self.hits.enter(shaft, &mut scratch.hits);
        scratch.alike = None;
    }

    /// Whether all receivers of the shaft on one face of an object are on the same side of all triangles near them. If no outline
    /// is visible from any place between them, each then sees the same number of surfaces in front of the light.
    #[cold]
    fn is_one_side(&self, at: &Receiver, lists: &Lists) -> bool {
        let mut first = None;
        let mut is_plane = true;
        self.hits.triangles_meeting(lists.origins(), &mut |corners| match first {
            None => first = Some(corners),
            Some(first) => is_plane &= is_flat(first, corners),
        });
        // One of the triangles is the receivers' own: they are on its plane, and rays start on the side of their face.
        let is_theirs = |corners| normal(corners).normalize_or_zero().dot(at.face.as_dvec3()).abs() > ALONG;
        is_plane && first.is_none_or(|corners| self.hits.has(at.object) && is_theirs(corners))
    }

    /// [`is_one_side`](Self::is_one_side), which is kept while the receivers are the same.
    fn is_plane(&self, at: &Receiver, scratch: &mut SilhouetteScratch) -> bool {
        let known = Plane { origins: scratch.lists.origins(), object: at.object, face: at.face, is_plane: false };
        match scratch.plane {
            Some(plane) if known == (Plane { is_plane: false, ..plane }) => plane.is_plane,
            _ => {
                let is_plane = self.is_one_side(at, &scratch.lists);
                scratch.plane = Some(Plane { is_plane, ..known });
                is_plane
            }
        }
    }

    /// Finds the outlines in which a flat light's plane, or a tube, cuts triangles near it. Returns whether there are any.
    fn clip_by_light(&self, light: &Outline, scratch: &mut SilhouetteScratch) -> bool {
        let SilhouetteScratch {
            near, arcs, silhouettes, outside, before, body, is_flat_cut, first_arc, origin, ..
        } = scratch;
        arcs.clear();
        let Some(near) = near.current() else { return false };
        let depth = light.depth_to(body.is_some());
        let plane = Behind::new(light, depth);
        let body = body.as_ref().map(|body| Hidden::new(body, plane));
        let [nearest, cut] = near.cut(&plane, *origin, body.as_ref());
        let relative = |corners: &[Vec3; 3]| corners.map(|p| p - *origin);
        if let Some(body) = &body {
            for corners in nearest {
                *is_flat_cut |= body.clip(relative(corners), || side(*corners, *origin), arcs);
            }
        }
        arcs.extend(cut.iter().filter_map(|corners| plane.clip(relative(corners), || side(*corners, *origin))));
        *is_flat_cut |= !arcs.is_empty();
        if !arcs.is_empty() {
            // A ceiling above a tube is cut for most receivers, and seldom where they see the tube.
            let beside = Beside::new(light, depth);
            arcs.retain(|(a, b, _)| !beside.misses_chord(*a, *b));
        }
        let are_there = !arcs.is_empty();
        if *is_flat_cut {
            plane.before(silhouettes, outside);
            if let Some(body) = &body {
                core::mem::swap(outside, before);
                body.outside(before, outside);
            }
            *first_arc = outside.len();
            arcs.drain(..).for_each(|arc| add_chord(outside, arc));
        }
        are_there
    }

    /// Lists the silhouettes of one receiver.
    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, query: &VisibilityQuery<'_>, scratch: &mut SilhouetteScratch) {
        let list = scratch.lists.at(simd, &self.meshes, query.at.position);
        let x = scratch.origin;
        let light = scratch.light;
        let sides = |edge| self.meshes.sides(edge, x);
        let is_exact = scratch.is_exact;
        let is_drawn = |edge| is_exact || self.meshes.is_drawn(edge, x, light);
        let outline = query.outline.map(|light| Beside::new(light, light.depth_to(scratch.body.is_some())));
        let outline = outline.as_ref();
        scratch.is_coarse =
            silhouettes(simd, x, (query.cone, outline), list, (sides, is_drawn), &mut scratch.silhouettes);
    }
}

impl Blockers for SilhouetteBlockers<'_> {
    type Scratch = SilhouetteScratch;

    fn scratch(&self) -> Self::Scratch {
        SilhouetteScratch::new(self.hits.scratch())
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        self.list(shaft, scratch);
        scratch.entered = true;
        if scratch.lists.is_empty() && !scratch.is_met { Coverage::Lit } else { Coverage::Partial }
    }

    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        let light = scratch.light;
        if !scratch.entered || scratch.is_clipped {
            return 0.0;
        }
        let Some(edges) = scratch.lists.whole() else { return 0.0 };
        let part = Sphere { radius: part.radius + scratch.lists.margin(), ..part };
        let width = dispatch!(Level::new(), simd => narrowest(simd, edges, part, light));
        // Next to a triangle there is no penumbra.
        if width > 0.0 && self.is_plane(at, scratch) { width } else { 0.0 }
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        let (at, cone) = (query.at, query.cone);
        if !scratch.entered {
            // Without `enter` the shaft is that of this receiver alone.
            let seen = query.outline.map_or_else(
                || Sphere { center: cone.axis * cone.distance, radius: cone.distance * cone.sin_sq().sqrt() },
                Outline::sphere,
            );
            let light = Sphere { center: at.position + seen.center, ..seen };
            self.list(&Shaft::new(Sphere { center: at.position, radius: 0.0 }, light, query.light), scratch);
        }
        let facet = if self.hits.has(at.object) { facet_coverage(at, cone) } else { Coverage::Lit };
        scratch.facet = (facet == Coverage::Partial).then_some(at.face);
        if facet == Coverage::Dark {
            return Coverage::Dark;
        }
        if facet == Coverage::Lit
            && let Some(coverage) = scratch.alike.and_then(|alike| alike.of(at))
        {
            return coverage;
        }
        scratch.begin(self.hits.leave(at.position, at.face), query);
        if scratch.lists.is_empty() && !scratch.is_met {
            return facet;
        }
        if cone.one_minus_cos > 0.0 && !scratch.lists.is_empty() {
            dispatch!(Level::new(), simd => self.look(simd, query, scratch));
            if scratch.lists.is_too_long() {
                return Coverage::Partial;
            }
        }
        let is_clipped = match query.outline {
            None => scratch.is_clipped,
            Some(outline) => self.clip_by_light(outline, scratch),
        };
        let is_whole = scratch.silhouettes.is_empty() && !is_clipped && scratch.facet.is_none();
        if cone.one_minus_cos > 0.0 && !is_whole {
            return Coverage::Partial;
        }
        // All samples have the same number of surfaces in front of them.
        let (toward, distance) = match query.outline {
            None => (cone.axis, cone.distance * cone.cos() * cone.cos()),
            Some(outline) => {
                let middle = outline.middle().normalize();
                (middle, outline.distance_to(scratch.body.is_some(), middle))
            }
        };
        let is_hit = self.hits.is_hit(scratch.origin, toward, distance, &mut scratch.hits);
        let coverage = if is_hit { Coverage::Dark } else { Coverage::Lit };
        if scratch.alike.is_none() && scratch.lists.is_empty() && scratch.lists.is_shared() {
            // If triangles reach into a light, they may be in front of its near side for some receivers only.
            let is_free = if query.outline.is_some() { !scratch.is_exact } else { !scratch.is_clipped };
            let coverage = (is_free && self.is_plane(at, scratch)).then_some(coverage);
            scratch.alike = Some(Alike { object: at.object, face: at.face, coverage });
        }
        coverage
    }

    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        if let Some(face) = scratch.facet {
            edges.add_plane(face, query.cone);
        }
        let mut light = scratch.cone;
        if query.outline.is_some() {
            // A flat light's cone may be a hemisphere, which has no disc.
            light.one_minus_cos = light.one_minus_cos.min(WIDEST_DISC);
        }
        dispatch!(Level::new(), simd => {
            add_edges(simd, query.cone, &light, &scratch.silhouettes, edges);
            if scratch.is_flat_cut {
                add_arcs(simd, query.cone, &light, (&scratch.outside, scratch.first_arc), edges);
            }
        });
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask) {
        if mask.is_dark() {
            return;
        }
        let mut view = scratch.view(query, mask);
        if let Some(face) = scratch.facet {
            mask.block_below(face);
        }
        if scratch.lists.is_too_long() {
            self.splat_by_rays(query, &mut view, scratch, mask);
            return;
        }
        let light = scratch.cross(query, &mut view, mask);
        if self.is_any_open(&view, light, scratch) {
            for j in (0..view.rows).step_by(8) {
                mask.keep_rows(j, scratch.fewest.rows(j));
            }
        } else {
            mask.block_all();
            scratch.may_hide = scratch.may_hide
                || asks_for_openings(query.cone)
                    && (scratch.may_hide_fewer(&view) || self.may_show_across(query, scratch, mask));
        }
    }

    fn refines_masks(&self) -> bool {
        true
    }

    fn may_hide_openings(&self, scratch: &Self::Scratch) -> bool {
        scratch.may_hide
    }

    fn mark_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &mut Mask,
        narrowest: f32,
    ) -> bool {
        self.mark(query, scratch, mask, narrowest);
        true
    }

    fn find_lit(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &Mask,
        narrowest: f32,
        lit: &mut LitArea,
    ) -> bool {
        // Simplified outlines, and arcs in which a round light cuts triangles, are left to masks.
        if scratch.is_coarse || scratch.lists.is_too_long() {
            return false;
        }
        if scratch.silhouettes.len() > MANY
            && (lit.is_ordinary() || mask.is_dark())
            && !self.hides_openings(query, scratch, mask, narrowest)
        {
            return mask.is_dark();
        }
        let mut view = scratch.view(query, mask);
        let light = scratch.cut_outlines(query, &mut view);
        if !scratch.arcs.is_empty() {
            return false;
        }
        let is_cut = scratch.is_cut(query.outline.is_some());
        let SilhouetteScratch { trapezoids, silhouettes, outside, facet, origin, hits, .. } = scratch;
        let drawn = if is_cut { &*outside } else { &*silhouettes };
        let facet = facet.map(|face| mask.square().local(face));
        let emits = Emits { mask, outline: query.outline, facet };
        trapezoids.find(drawn, &view, &emits, narrowest, lit, |p| self.is_open(view.ray_to(p), light, *origin, hits))
    }
}

impl SilhouetteBlockers<'_> {
    /// Blocks what rays find to be hidden, where too many edges may be silhouettes.
    fn splat_by_rays(
        &self,
        query: &VisibilityQuery<'_>,
        view: &mut View,
        scratch: &mut SilhouetteScratch,
        mask: &mut Mask,
    ) {
        let light = scratch.cut_outlines(query, view);
        let SilhouetteScratch { contour, origin, facet, hits, .. } = scratch;
        let square = *mask.square();
        let hidden = |v: Vec3| {
            let at = square.local(v);
            !self.is_open(view.ray_to(at.truncate() / at.z), light, *origin, hits)
        };
        match *facet {
            None => contour.block(mask, hidden),
            Some(face) => contour.block_above(mask, face, hidden),
        };
    }

    /// Whether a ray in a direction meets nothing before the light's plane, or before the light if triangles reach into it.
    fn is_open(
        &self,
        (direction, plane): (Vec3, f32),
        light: Option<LightSphere>,
        origin: Vec3,
        hits: &mut DynScratch,
    ) -> bool {
        let distance = light.map_or(plane, |light| light.distance(direction));
        !self.hits.is_hit(origin, direction, distance, hits)
    }

    /// Whether something may be open between the rows of a mask that is dark: on or between the samples of some of its columns.
    fn may_show_across(&self, query: &VisibilityQuery<'_>, scratch: &mut SilhouetteScratch, mask: &Mask) -> bool {
        let turned = scratch.turned_mask(query, mask, COLUMNS);
        let mut view = scratch.view(query, &turned);
        let light = scratch.cross(query, &mut view, &turned);
        scratch.turned = turned;
        self.is_any_open(&view, light, scratch) || scratch.may_hide_fewer(&view)
    }

    /// Whether the samples with the fewest surfaces before them are open, by rays. Where their number is doubtful, those that are open are added.
    fn is_any_open(&self, view: &View, light: Option<LightSphere>, scratch: &mut SilhouetteScratch) -> bool {
        let SilhouetteScratch { origin, is_coarse, counter, fewest, next, hits, .. } = scratch;
        let mut is_ray_open = |row: usize, sample: usize| self.is_open(view.ray(row, sample), light, *origin, hits);
        let mut any = fewest.middle.is_some_and(|(row, sample)| is_ray_open(row, sample));
        if *is_coarse {
            // This ray may meet a detail that simplified forms leave out, so two of three rays decide.
            let mut rows = [fewest.middle.map_or(0, |(row, _)| row); 2];
            let mut ask = |rows: &[usize], any: bool| {
                fewest.witness(rows).map_or((0, any), |(row, sample)| (row, is_ray_open(row, sample)))
            };
            let second = ask(&rows, any);
            if second.1 != any {
                rows[1] = second.0;
                (_, any) = ask(&rows, any);
            }
        }
        let mut is_doubtful = fewest.is_doubtful();
        while is_doubtful {
            dispatch!(Level::new(), _simd => counter.fewest(next));
            is_doubtful = next.is_doubtful();
            match (any, next.middle.is_some_and(|(row, sample)| is_ray_open(row, sample))) {
                (true, true) => fewest.add(next),
                (false, true) => {
                    core::mem::swap(fewest, next);
                    any = true;
                }
                _ => {}
            }
        }
        any
    }
}
