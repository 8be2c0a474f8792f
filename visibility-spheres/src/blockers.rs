use crate::block::{Candidates, LANES};
use crate::blocked_cones::LightSphere;
use crate::cone_list::ConeList;
use crate::ellipse::LANE;
use crate::shaft::ShaftTest;
use crate::sphere_tree::SphereTree;
use crate::splat::Front;
use fearless_simd::{Level, Simd, dispatch, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lobe_core::{Cone, NO_OBJECT, Receiver, SelfShadow, Sphere};
use shading::{Coverage, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Edges, LitArea, Mask, facet_coverage};

/// Spheres that block light, as the `spheres` strategy sees them: wrap it in
/// [`MaskVisibility`](visibility_mask::MaskVisibility).
///
/// # Self-shadowing
/// A sphere set stands for a mesh that lies partly inside, partly outside of it, so a receiver on the mesh is often inside
/// a sphere of its own object. The rule: *a sphere of the receiver's own object blocks a direction only if the ray leaves
/// it farther than τ from the receiver*. The blocked directions are again a cone about the sphere's centre, with `d` the
/// distance of the centre and `k = d² − r²`: the tangent cone if `k > 0` and `τ² ≤ k`, else `cos β = (τ² + k)/(2τd)`, and
/// it is continuous as the receiver moves through the sphere's surface. τ is one length for an object or, better, one for
/// each sphere, together with a smaller sphere inside it for the object's own receivers
/// ([`with_self_shadows`](Self::with_self_shadows)): both are fitted to the mesh when a set is built. That sphere becomes the
/// whole one as the receiver goes away ([`SelfShadow::seen`]), since what is far away sees a silhouette, which the spheres
/// were placed for. Spheres of other objects are whole and have τ = 0: what contains the receiver hides everything from it.
///
/// The mesh itself hides what is below the receiver's facet ([`facet_coverage`]), where the shading normal is another one
/// and the object has spheres: at the terminator spheres would let that light through.
///
/// # Order
/// A sphere blocks where it is in front of the light. For a sphere that does not meet the light this is the same for
/// all directions (the one with the smaller power `d² − r²` is in front); where blocker and light intersect it is
/// decided direction by direction.
#[derive(Clone, Debug, Default)]
pub struct SphereBlockers {
    spheres: Vec<Sphere>,
    objects: Vec<u32>,
    self_distances: Vec<f32>,
    /// For each sphere, or empty.
    self_shadows: Vec<SelfShadow>,
    tree: SphereTree,
    /// Objects with a sphere that can block, ascending.
    casters: Vec<u32>,
}

impl SphereBlockers {
    /// Blockers of several objects: `objects[i]` is the object of `spheres[i]`, `self_distances[object]` its τ (0 where
    /// missing). Spheres of radius zero or less, or with anything infinite or NaN, block nothing.
    ///
    /// Orders the spheres for a hierarchy: O(n log n).
    ///
    /// # Panics
    /// When `spheres` and `objects` differ in length.
    #[must_use]
    pub fn new(spheres: &[Sphere], objects: &[u32], self_distances: &[f32]) -> Self {
        assert_eq!(spheres.len(), objects.len(), "each sphere belongs to an object");
        let mut blockers = Self {
            spheres: spheres.to_vec(),
            objects: objects.to_vec(),
            self_distances: self_distances.to_vec(),
            self_shadows: Vec::new(),
            tree: SphereTree::new(spheres),
            casters: Vec::new(),
        };
        blockers.find_casters();
        blockers
    }

    fn find_casters(&mut self) {
        self.casters.clear();
        self.casters.extend(self.tree.order().iter().map(|i| self.objects[*i as usize]).filter(|o| *o != NO_OBJECT));
        self.casters.sort_unstable();
        self.casters.dedup();
    }

    /// How receivers of its own object see each sphere, instead of the object's τ; nothing changes for none.
    ///
    /// # Panics
    /// When it is not one for each sphere, or none.
    #[must_use]
    pub fn with_self_shadows(mut self, self_shadows: &[SelfShadow]) -> Self {
        assert!(self_shadows.is_empty() || self_shadows.len() == self.spheres.len(), "one for each sphere");
        // A sphere that reached out of its sphere would reach out of what the hierarchy bounds.
        self.self_shadows = self_shadows.iter().map(|own| own.sound()).collect();
        self
    }

    /// Moves the spheres, and makes them larger or smaller, for another pose; their objects stay. The result is as if
    /// made by [`new`](Self::new), bit for bit.
    ///
    /// The hierarchy is refitted, O(n), or made anew where that pays: when its nodes have grown by half in area since
    /// it was made, or other spheres block than before. `true` says that it was made anew. Working memory made
    /// before keeps its meaning only after the next [`enter`](Blockers::enter).
    ///
    /// # Panics
    /// When there are more or fewer spheres than before.
    pub fn update(&mut self, spheres: &[Sphere]) -> bool {
        self.spheres.copy_from_slice(spheres);
        let is_new = self.tree.update(spheres);
        if is_new {
            self.find_casters();
        }
        is_new
    }

    /// The spheres, as given.
    #[must_use]
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// The object of each.
    pub(crate) fn objects(&self) -> &[u32] {
        &self.objects
    }

    /// Objects with a sphere that can block, ascending.
    pub(crate) fn casters(&self) -> &[u32] {
        &self.casters
    }

    /// How much of the light the receiver's own facet hides, and its horizon does not.
    fn facet(&self, at: &Receiver, cone: &Cone) -> Coverage {
        let casts = at.face != at.normal && self.casters.binary_search(&at.object).is_ok();
        if casts { facet_coverage(at, cone) } else { Coverage::Lit }
    }

    /// By the facet, then by the candidates.
    fn select_by(&self, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch, culls: bool) -> Coverage {
        let facet = self.facet(query.at, query.cone);
        if facet == Coverage::Dark {
            return Coverage::Dark;
        }
        scratch.facet = (facet == Coverage::Partial).then_some(query.at.face);
        let found = dispatch!(Level::new(), simd => select_all(simd, query, scratch, culls));
        if found == Coverage::Lit { facet } else { found }
    }

    /// The numbers of the spheres that can block, neighbours near each other: the order in which a GPU holds them.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        self.tree.order()
    }

    /// The part of a sphere that receivers of its own object inside it see, from its centre, and its τ.
    pub(crate) fn own(&self, index: usize) -> (Sphere, f32) {
        let sphere = self.spheres[index];
        match self.self_shadows.get(index) {
            Some(own) => (own.near(sphere.radius), sphere.radius * own.distance),
            None => {
                let tau = self.self_distances.get(self.objects[index] as usize).copied().unwrap_or(0.0);
                (Sphere { center: Vec3::ZERO, ..sphere }, tau)
            }
        }
    }

    /// How receivers of its own object see sphere `index`, in units of its radius, and the part of its self-shadow distance τ that does
    /// not grow with the radius: what a shader needs to follow a sphere that changes.
    ///
    /// # Panics
    /// When there is no such sphere.
    #[must_use]
    pub fn self_shadow(&self, index: usize) -> (SelfShadow, f32) {
        match self.self_shadows.get(index) {
            Some(own) => (*own, 0.0),
            None => (SelfShadow::whole(0.0), self.own(index).1),
        }
    }

    /// Brings the candidates in the order of their numbers, so that a mask does not depend on the hierarchy.
    fn list(&self, scratch: &mut SphereScratch) {
        scratch.candidates.sort_unstable();
        scratch.blocks.clear();
        for numbers in scratch.candidates.chunks(LANES) {
            let mut block = Candidates::default();
            for (lane, i) in numbers.iter().map(|i| *i as usize).enumerate() {
                let (own, tau) = self.own(i);
                block.set(lane, &self.spheres[i], self.objects[i], &own, tau);
            }
            scratch.blocks.push(block);
        }
    }
}

/// By how much a sphere that shows a light differs from it, in radii, and somewhat more.
pub(crate) const SHOWS: f32 = 5e-3;

/// Working memory of [`SphereBlockers`].
#[derive(Clone, Debug, Default)]
pub struct SphereScratch {
    /// Spheres in the current shaft, ascending, and the same again to be tested eight at once.
    candidates: Vec<u32>,
    blocks: Vec<Candidates>,
    /// One sphere hides the whole light from the whole shaft.
    dark: bool,
    /// The block of a sphere that hid the whole light from the receiver before.
    darkener: Option<usize>,
    stack: Vec<(u32, u32)>,
    /// The spheres that meet the current receiver's light cone.
    cones: ConeList,
    /// The normal of its facet, where that hides a part of the light.
    facet: Option<Vec3>,
}

impl SphereScratch {
    /// The lanes of a block that hold a sphere.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, number: usize) -> mask32x8<S> {
        f32x8::simd_from(simd, LANE).simd_lt(f32x8::splat(simd, (self.candidates.len() - number * LANES) as f32))
    }
}

#[cfg(test)]
impl SphereScratch {
    pub(crate) fn candidates(&self) -> &[u32] {
        &self.candidates
    }

    pub(crate) fn is_dark(&self) -> bool {
        self.dark
    }

    pub(crate) fn cones(&self) -> Vec<crate::splat::BlockedCone> {
        self.cones.iter().collect()
    }

    /// How many candidates meet a shaft: one by one.
    pub(crate) fn meets(&self, test: &ShaftTest) -> u32 {
        let lanes = |number: usize| (1 << (self.candidates.len() - number * LANES).min(LANES)) - 1;
        let met = |(number, block): (usize, &Candidates)| test.meets(&block.spheres) & lanes(number);
        self.blocks.iter().enumerate().map(|block| met(block).count_ones()).sum()
    }
}

#[cfg(test)]
impl SphereBlockers {
    /// `select` without any culling: the same exact question to every sphere.
    pub(crate) fn select_flat(&self, query: &VisibilityQuery<'_>) -> (Coverage, Vec<crate::splat::BlockedCone>) {
        let mut scratch = self.scratch();
        let coverage = self.select_by(query, &mut scratch, false);
        (coverage, scratch.cones())
    }
}

impl Blockers for SphereBlockers {
    type Scratch = SphereScratch;

    fn scratch(&self) -> SphereScratch {
        let mut scratch = SphereScratch { candidates: self.tree.order().to_vec(), ..SphereScratch::default() };
        self.list(&mut scratch);
        scratch
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut SphereScratch) -> Coverage {
        let test = ShaftTest::new(shaft);
        scratch.candidates.clear();
        self.tree.find(&test, &mut scratch.stack, &mut scratch.candidates);
        test.narrow(&self.spheres, &mut scratch.candidates);
        scratch.candidates.retain(|i| !shows(&self.spheres[*i as usize], &shaft.light));
        self.list(scratch);
        scratch.dark = scratch.candidates.iter().any(|i| {
            // Whose receivers they are is not known: what the smallest sphere hides, larger ones hide too.
            let (near, tau) = self.own(*i as usize);
            let center = self.spheres[*i as usize].center + near.center;
            test.darkens(&Sphere { center, ..near }, tau)
        });
        if scratch.candidates.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch) -> Coverage {
        if scratch.dark {
            return Coverage::Dark;
        }
        self.select_by(query, scratch, true)
    }

    /// The spheres' rims and the facet's edge. Masks of flat lights stay along these lights' sides: rows end there without an error, and see a rim as well in any
    /// direction.
    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &SphereScratch, edges: &mut Edges) {
        if query.outline.is_none() {
            dispatch!(Level::new(), simd => scratch.cones.add_edges(simd, query.cone, edges));
        }
        if let Some(face) = scratch.facet {
            edges.add_plane(face, query.cone);
        }
    }

    fn add_hidden(&self, _: &VisibilityQuery<'_>, scratch: &SphereScratch, mask: &Mask, lit: &mut LitArea) -> bool {
        scratch.facet.is_none() && scratch.cones.add_rims(mask.square(), lit)
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch, mask: &mut Mask) {
        if let Some(face) = scratch.facet {
            mask.block_below(face);
        }
        let light = Front::new(query);
        dispatch!(Level::new(), simd => scratch.cones.splat(simd, &light, mask));
    }
}

/// Whether a sphere is inside of a light and nearly as large: one that makes the light visible, and hides others.
fn shows(sphere: &Sphere, light: &Sphere) -> bool {
    let slack = SHOWS * light.radius;
    (light.radius - sphere.radius).abs() <= slack && sphere.center.distance_squared(light.center) <= slack * slack
}

/// Asks all candidates, and keeps those that hide something.
#[inline(always)]
fn select_all<S: Simd>(simd: S, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch, culls: bool) -> Coverage {
    let (light, object) = (LightSphere::new(query, culls), query.at.object);
    scratch.cones.clear(scratch.candidates.len());
    // A sphere that hides all of a receiver's light mostly hides it from its neighbour too.
    if let Some(number) = scratch.darkener.take()
        && let Some(block) = scratch.blocks.get(number)
        && light.blocked_cones(simd, object, block, scratch.lanes(simd, number)).is_some_and(|cones| cones.darkens)
    {
        scratch.darkener = Some(number);
        return Coverage::Dark;
    }
    for (number, block) in scratch.blocks.iter().enumerate() {
        if let Some(cones) = light.blocked_cones(simd, object, block, scratch.lanes(simd, number)) {
            if cones.darkens {
                scratch.darkener = Some(number);
                return Coverage::Dark;
            }
            scratch.cones.extend(&cones);
        }
    }
    if scratch.cones.is_empty() {
        return Coverage::Lit;
    }
    scratch.cones.end();
    Coverage::Partial
}
